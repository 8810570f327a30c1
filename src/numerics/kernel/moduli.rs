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

    /// Returns the elastic energy per volume of a stress rr, zz, hoop, rz; without the part of a modulus that is zero.
    pub fn energy(self, stress: [f64; 4]) -> f64 {
        if stress == [0.0; 4] {
            return 0.0;
        }
        let [rr, zz, hoop, shear] = stress;
        let mean = (rr + zz + hoop) / 3.0;
        let squares: f64 = [rr, zz, hoop].iter().map(|s| (s - mean) * (s - mean)).sum();
        let parts = [0.5 * mean * mean / self.bulk, 0.25 * (squares + 2.0 * shear * shear) / self.shear];
        parts.into_iter().filter(|part| part.is_finite()).sum()
    }
}
