//! Student's t distribution.
//! Never here: what it is the distribution of.

use statrs::distribution::{Continuous as _, ContinuousCDF as _, StudentsT};

use super::normal;

/// The value below which so much (a half or more) lies, with so many degrees of freedom; infinite where there are none.
///
/// Newton's method on the cumulative function from the expansion of Cornish and Fisher (Abramowitz and Stegun 26.7.5). The quantile of
/// statrs 0.19 finds no end for some thousand degrees of freedom.
pub fn quantile(part: f64, freedom: f64) -> f64 {
    let Ok(t) = StudentsT::new(0.0, 1.0, freedom) else { return f64::INFINITY };
    let x = normal::quantile(part);
    let square = x * x;
    let first = x * (square + 1.0) / 4.0;
    let second = x * (5.0 * square * square + 16.0 * square + 3.0) / 96.0;
    let mut value = x + first / freedom + second / (freedom * freedom);
    if freedom > 1e4 {
        return value;
    }
    for _ in 0..30 {
        value += (part - t.cdf(value)) / t.pdf(value);
    }
    value
}

#[cfg(test)]
mod tests {
    use super::quantile;

    #[test]
    fn quantiles_of_students_t() {
        for (freedom, exact) in [(3.0, 3.182446), (10.0, 2.228139), (38.0, 2.024394), (1000.0, 1.962339)] {
            let found = quantile(0.975, freedom);
            assert!((found / exact - 1.0).abs() < 1e-2 / freedom, "{freedom} {found}");
        }
    }
}
