//! Statistics: distributions, sample points of the unit cube, estimates with confidence intervals, fits.

pub mod cholesky;
pub mod design;
pub mod distribution;
pub mod indices;
pub mod lambert_jonas;
pub mod least_squares;
pub mod probit;
pub mod summary;

use serde::Serialize;

pub use crate::probability::normal;
use crate::probability::students_t;

/// Probability on each side of a 95 % confidence interval.
pub(super) const TAIL: f64 = 0.025;

/// Estimate with its 95 % confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct IntervalEstimate {
    /// Estimated value, in the units of the quantity.
    pub value: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

impl IntervalEstimate {
    /// Creates a symmetrical interval from a standard error with `freedom` degrees of freedom; infinity gives the
    /// normal distribution.
    pub fn around(value: f64, error: f64, freedom: f64) -> IntervalEstimate {
        let half = student(freedom) * error;
        IntervalEstimate { value, low: value - half, high: value + half }
    }

    /// Returns whether a value is inside the interval.
    pub fn holds(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }
}

/// Returns the half-width of a 95 % interval in standard errors: the 0.975 quantile of Student's t.
pub fn student(freedom: f64) -> f64 {
    students_t::quantile(1.0 - TAIL, freedom)
}

#[cfg(test)]
mod tests {
    use super::{IntervalEstimate, student};

    /// Source: tables of Student's t (Abramowitz and Stegun 26.10).
    #[test]
    fn quantiles_of_students_t_match_tables() {
        for (freedom, t) in
            [(1.0, 12.706), (5.0, 2.571), (15.0, 2.131), (120.0, 1.980), (1023.0, 1.9623), (f64::INFINITY, 1.95996)]
        {
            assert!((student(freedom) - t).abs() < 5e-4, "{freedom}: {}", student(freedom));
        }
        let estimate = IntervalEstimate::around(10.0, 1.0, 5.0);
        assert!(estimate.holds(12.5) && !estimate.holds(12.6) && !estimate.holds(7.4));
        assert_eq!(student(0.0), f64::INFINITY);
    }
}
