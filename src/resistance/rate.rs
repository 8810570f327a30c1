//! Growth of a yield stress with strain rate.

use super::ResistanceError;

/// Growth of the yield stress with the rate of the equivalent strain, at a radius of the cavity.
#[derive(Clone, Debug, PartialEq)]
pub struct Rate {
    /// What the yield stress is multiplied by.
    pub factor: Factor,
    /// Radius of the cavity, length: that of the projectile's shank.
    pub radius: f64,
}

/// What the yield stress is multiplied by at a strain rate e'.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Factor {
    /// `1 + (e' / reference)^exponent`.
    Power {
        /// Rate, 1/time.
        reference: f64,
        /// Exponent.
        exponent: f64,
    },
    /// `1 + c ln(e' / reference)`, not below 1.
    JohnsonCook {
        /// C.
        c: f64,
        /// Rate, 1/time.
        reference: f64,
    },
}

impl Factor {
    /// What it adds to one.
    pub(super) fn gain(self, rate: f64) -> f64 {
        match self {
            Factor::Power { reference, exponent } => libm::pow(rate / reference, exponent),
            Factor::JohnsonCook { c, reference } => c * libm::log(rate / reference).max(0.0),
        }
    }
}

impl Rate {
    pub(super) fn check(&self) -> Result<(), ResistanceError> {
        let numbers = match self.factor {
            Factor::Power { reference, exponent } => [reference, exponent],
            Factor::JohnsonCook { c, reference } => [reference, c],
        };
        let good = numbers.iter().chain([&self.radius]).all(|v| *v > 0.0 && v.is_finite());
        let wrong = || {
            ResistanceError::Target("a rate term needs its constants and the radius of the cavity above zero".into())
        };
        good.then_some(()).ok_or_else(wrong)
    }
}
