//! Moduli of isotropic elasticity.

/// Bulk and shear modulus.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ElasticModuli {
    /// Bulk modulus, stress.
    pub bulk: f64,
    /// Shear modulus, stress.
    pub shear: f64,
}

impl ElasticModuli {
    /// Converts Young's modulus and Poisson's ratio. Equation (1.2).
    pub fn from_young(young: f64, ratio: f64) -> ElasticModuli {
        ElasticModuli { bulk: young / (3.0 * (1.0 - 2.0 * ratio)), shear: young / (2.0 * (1.0 + ratio)) }
    }
}
