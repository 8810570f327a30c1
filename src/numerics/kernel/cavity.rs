//! Dynamic cavity expansion: normal stress on a surface that opens a cavity in a material.

/// σ_n = Y (A + B x + C x²) with x = v_n sqrt(ρ/Y), expanded to σ_n = c0 + c1 v_n + c2 v_n² (Forrestal and Luk 1992;
/// Warren and Tabbara 2000, eq. 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CavityResistance {
    /// A Y, stress.
    pub c0: f64,
    /// B sqrt(ρ Y), stress per velocity.
    pub c1: f64,
    /// C ρ, density.
    pub c2: f64,
}

impl CavityResistance {
    /// No resistance: all coefficients are zero.
    pub const NONE: CavityResistance = CavityResistance { c0: 0.0, c1: 0.0, c2: 0.0 };

    /// Creates the resistance from yield stress Y, density ρ and the dimensionless A, B, C. Equation (2.1).
    pub fn new(yield_stress: f64, density: f64, [a, b, c]: [f64; 3]) -> Self {
        CavityResistance { c0: a * yield_stress, c1: b * (density * yield_stress).sqrt(), c2: c * density }
    }

    /// Returns the resistance with all coefficients multiplied by a factor.
    pub fn scaled(&self, factor: f64) -> CavityResistance {
        CavityResistance { c0: factor * self.c0, c1: factor * self.c1, c2: factor * self.c2 }
    }

    /// Returns the normal stress c0 + c1 v + c2 v² at a normal velocity v ≥ 0. Equation (2.2).
    #[inline]
    pub fn stress(&self, normal_velocity: f64) -> f64 {
        self.c0 + normal_velocity * (self.c1 + normal_velocity * self.c2)
    }
}
