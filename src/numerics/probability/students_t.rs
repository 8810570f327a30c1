//! Student's t distribution.

use statrs::distribution::{Continuous as _, ContinuousCDF as _, StudentsT};

use super::normal;

/// Returns the quantile of a probability ≥ 0.5 for a number of degrees of freedom; infinite if that is not positive.
///
/// Newton's method on the cumulative distribution function, started from the Cornish-Fisher expansion (Abramowitz and
/// Stegun 26.7.5). The quantile function of statrs 0.19 does not terminate for some thousand degrees of freedom.
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
