//! Strain-rate dependence of the yield stress.

use super::ResistanceError;

/// Dependence of the yield stress on the equivalent strain rate, for a given cavity radius.
#[derive(Clone, Debug, PartialEq)]
pub struct StrainRateEffect {
    /// Factor on the yield stress.
    pub factor: StrainRateFactor,
    /// Cavity radius (length): the shank radius of the projectile.
    pub radius: f64,
}

/// Factor on the yield stress at a strain rate e'.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StrainRateFactor {
    /// Power law: `1 + (e' / reference)^exponent`.
    Power {
        /// Reference strain rate, 1/time.
        reference: f64,
        /// Exponent of the strain rate.
        exponent: f64,
    },
    /// `1 + c ln(e' / reference)`, not below 1.
    JohnsonCook {
        /// Constant C of the Johnson-Cook rate term, dimensionless.
        c: f64,
        /// Reference strain rate, 1/time.
        reference: f64,
    },
}

impl StrainRateFactor {
    /// Returns the factor minus one.
    pub(super) fn gain(self, rate: f64) -> f64 {
        match self {
            StrainRateFactor::Power { reference, exponent } => libm::pow(rate / reference, exponent),
            StrainRateFactor::JohnsonCook { c, reference } => c * libm::log(rate / reference).max(0.0),
        }
    }
}

impl StrainRateEffect {
    pub(super) fn check(&self) -> Result<(), ResistanceError> {
        let numbers = match self.factor {
            StrainRateFactor::Power { reference, exponent } => [reference, exponent],
            StrainRateFactor::JohnsonCook { c, reference } => [reference, c],
        };
        let are_positive = numbers.iter().chain([&self.radius]).all(|v| *v > 0.0 && v.is_finite());
        let wrong = || {
            ResistanceError::Target(
                "the constants of strain-rate dependence and the cavity radius must be above zero".into(),
            )
        };
        are_positive.then_some(()).ok_or_else(wrong)
    }
}
