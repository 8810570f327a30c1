//! Dynamic cavity expansion: normal stress on a surface that opens a cavity in a material.
//! Never here: where the material is.

/// sigma_n = Y (A + B x + C x^2) with x = v_n sqrt(rho / Y), multiplied out:
/// sigma_n = c0 + c1 v_n + c2 v_n^2 (Forrestal and Luk 1992; Warren and Tabbara 2000, eq. 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resistance {
    /// A Y, stress.
    pub c0: f64,
    /// B sqrt(rho Y), stress per velocity.
    pub c1: f64,
    /// C rho, density.
    pub c2: f64,
}

impl Resistance {
    /// Of nothing.
    pub const NONE: Resistance = Resistance { c0: 0.0, c1: 0.0, c2: 0.0 };

    /// From yield stress Y, density rho and the dimensionless A, B, C.
    pub fn new(yield_stress: f64, density: f64, [a, b, c]: [f64; 3]) -> Self {
        Resistance { c0: a * yield_stress, c1: b * (density * yield_stress).sqrt(), c2: c * density }
    }

    /// Normal stress at a normal velocity >= 0.
    #[inline]
    pub fn stress(&self, normal_velocity: f64) -> f64 {
        self.c0 + normal_velocity * (self.c1 + normal_velocity * self.c2)
    }
}
