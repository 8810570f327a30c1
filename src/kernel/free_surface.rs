//! What a free surface takes from the resistance of a target: the exact factor of a finite sphere.
//! Never here: where the free surfaces of a target are.

/// The pressure in a spherical cavity of radius a within a sphere of radius b of incompressible elastic, perfectly plastic material,
/// over that in a body without end: with q = 2E/3Y, c = q^(1/3) a the radius of the plastic zone, by the equilibrium of a thick-walled
/// sphere (Hill 1950, The Mathematical Theory of Plasticity, V.2, with a cavity opened from nothing),
/// sigma(b) = (2Y/3) (1 + ln q - q (a/b)^3) where the plastic zone ends inside, b > c, and 2 Y ln(b/a) where all is plastic;
/// sigma(without end) = (2Y/3) (1 + ln q).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FiniteSphere {
    /// q = 2E/3Y.
    stiffness: f64,
    /// b/a at which the plastic zone meets the free surface.
    plastic: f64,
    /// 1 + ln q.
    whole: f64,
}

impl FiniteSphere {
    /// Of a material with these Young's modulus and yield stress; `None` where q is not above 1: nothing yields around a cavity.
    pub fn new(young: f64, yield_stress: f64) -> Option<Self> {
        let stiffness = 2.0 * young / (3.0 * yield_stress);
        let sound = stiffness > 1.0 && stiffness.is_finite();
        sound.then(|| FiniteSphere { stiffness, plastic: libm::cbrt(stiffness), whole: 1.0 + libm::log(stiffness) })
    }

    /// The factor at a distance (>= 0) from the cavity's wall to the free surface, for a cavity of this radius.
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

    /// Reference: the table of the factor for 6061-T6511, b/a and the factor.
    #[test]
    fn the_factor_is_that_of_the_table() {
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
    fn it_grows_from_nothing_to_one_without_a_jump() {
        let sphere = aluminium();
        assert_eq!(sphere.factor(1.0, 0.0), 0.0);
        assert_eq!(sphere.factor(1.0, f64::INFINITY), 1.0);
        assert_eq!(sphere.factor(0.0, 1.0), 1.0, "nothing is near a point");
        assert!(1.0 - sphere.factor(1.0, 1e6) < 1e-15);
        let edge = sphere.plastic - 1.0;
        // At the change both value and slope meet: 3/(b/a) on either side.
        let [below, at, above] = [-1e-6, 0.0, 1e-6].map(|d| sphere.factor(1.0, edge + d));
        assert!(below < at && at < above && ((above - at) / (at - below) - 1.0).abs() < 1e-5);
        assert!(FiniteSphere::new(1.0, 1.0).is_none());
    }
}
