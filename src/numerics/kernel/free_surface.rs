//! Reduction of a target's resistance near a free surface: the exact factor of a finite sphere.

/// Ratio of the pressure in a spherical cavity of radius a in a sphere of radius b, of incompressible elastic,
/// perfectly plastic material, to that in an infinite body. With q = 2E/(3Y) and the plastic radius c = q^(1/3) a, from
/// the equilibrium of a thick-walled sphere (Hill 1950, The Mathematical Theory of Plasticity, V.2, with a cavity
/// opened from zero radius):
///
/// - σ(b) = (2Y/3) (1 + ln q - q (a/b)³) if the plastic zone ends inside, b > c
/// - σ(b) = 2 Y ln(b/a) if the whole sphere is plastic
/// - σ(∞) = (2Y/3) (1 + ln q)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FiniteSphere {
    /// q = 2E/(3Y).
    stiffness: f64,
    /// b/a at which the plastic zone reaches the free surface.
    plastic: f64,
    /// 1 + ln q.
    whole: f64,
}

impl FiniteSphere {
    /// Creates the factor from Young's modulus and yield stress; `None` if q is not above 1, i.e. no yielding around a
    /// cavity.
    pub fn new(young: f64, yield_stress: f64) -> Option<Self> {
        let stiffness = 2.0 * young / (3.0 * yield_stress);
        let sound = stiffness > 1.0 && stiffness.is_finite();
        sound.then(|| FiniteSphere { stiffness, plastic: libm::cbrt(stiffness), whole: 1.0 + libm::log(stiffness) })
    }

    /// Returns the factor for a distance ≥ 0 from the cavity wall to the free surface, and the radius of the cavity.
    /// Equation (3.1).
    #[inline]
    pub fn factor(&self, radius: f64, distance: f64) -> f64 {
        let ratio = 1.0 + distance / radius;
        if !ratio.is_finite() {
            return 1.0;
        }
        if ratio > self.plastic {
            return 1.0 - self.stiffness / (ratio * ratio * ratio * self.whole);
        }
        3.0 * libm::log(ratio) / self.whole
    }
}

#[cfg(test)]
mod tests {
    use super::FiniteSphere;

    fn aluminium() -> FiniteSphere {
        FiniteSphere::new(68.9e9, 276e6).expect("a stiff material")
    }

    /// Reference: tabulated factor for 6061-T6511 over b/a.
    #[test]
    fn factor_matches_reference_table() {
        let table = [
            (1.25, 0.109),
            (1.5, 0.199),
            (2.0, 0.340),
            (3.0, 0.539),
            (4.0, 0.680),
            (5.5, 0.836),
            (8.0, 0.947),
            (10.0, 0.973),
            (20.0, 0.997),
        ];
        for (ratio, expected) in table {
            let factor = aluminium().factor(3.0, 3.0 * (ratio - 1.0));
            assert!((factor - expected).abs() < 5.1e-4, "b/a = {ratio}: {factor} for {expected}");
        }
    }

    #[test]
    fn factor_increases_continuously_from_zero_to_one() {
        let sphere = aluminium();
        assert_eq!(sphere.factor(1.0, 0.0), 0.0);
        assert_eq!(sphere.factor(1.0, f64::INFINITY), 1.0);
        assert_eq!(sphere.factor(0.0, 1.0), 1.0, "zero radius");
        assert!(1.0 - sphere.factor(1.0, 1e6) < 1e-15);
        let edge = sphere.plastic - 1.0;
        // Value and slope are continuous at the transition: 3/(b/a) on either side.
        let [below, at, above] = [-1e-6, 0.0, 1e-6].map(|d| sphere.factor(1.0, edge + d));
        assert!(below < at && at < above && ((above - at) / (at - below) - 1.0).abs() < 1e-5);
        assert!(FiniteSphere::new(1.0, 1.0).is_none());
    }
}
