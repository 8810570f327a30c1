//! Statistics that know no deck: distributions, points of the unit cube, estimates with their errors, fits.

pub mod cholesky;
pub mod design;
pub mod distribution;
pub mod indices;
pub mod lambert_jonas;
pub mod least_squares;
pub mod probit;
pub mod summary;

use serde::Serialize;

pub use crate::kernel::normal;
use crate::kernel::students_t;

/// Half of what lies outside an interval: intervals hold 95 %.
const TAIL: f64 = 0.025;

/// A number with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// The number.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Estimate {
    /// Symmetrical, by a standard error with so many degrees of freedom (infinitely many: the normal distribution).
    pub fn around(value: f64, error: f64, freedom: f64) -> Estimate {
        let half = student(freedom) * error;
        Estimate { value, low: value - half, high: value + half }
    }

    /// Whether a value lies inside.
    pub fn holds(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }
}

/// How many standard errors a 95 % interval reaches to either side: the quantile 0.975 of Student's t.
pub fn student(freedom: f64) -> f64 {
    students_t::quantile(1.0 - TAIL, freedom)
}

#[cfg(test)]
mod tests {
    use super::{Estimate, student};

    /// Source: tables of Student's t (Abramowitz and Stegun 26.10).
    #[test]
    fn intervals_reach_as_far_as_tables_say() {
        for (freedom, t) in
            [(1.0, 12.706), (5.0, 2.571), (15.0, 2.131), (120.0, 1.980), (1023.0, 1.9623), (f64::INFINITY, 1.95996)]
        {
            assert!((student(freedom) - t).abs() < 5e-4, "{freedom}: {}", student(freedom));
        }
        let estimate = Estimate::around(10.0, 1.0, 5.0);
        assert!(estimate.holds(12.5) && !estimate.holds(12.6) && !estimate.holds(7.4));
        assert_eq!(student(0.0), f64::INFINITY);
    }
}
