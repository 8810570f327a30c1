//! Plane stress elasticity at a point of a shell: isotropic, or orthotropic with any direction in the plane (lamina).
//!
//! Directions of the shell are meridian and hoop. The shear strain between them is zero in axisymmetric deformation
//! without twist; a lamina whose direction is neither has a shear stress nevertheless, which does no work.

use super::plane_stress::PlaneElastic;

/// Constants of a lamina in its directions 1 (along the fibres) and 2 (`*ELASTIC, TYPE=LAMINA`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lamina {
    /// Young's moduli E1 and E2.
    pub young: [f64; 2],
    /// Poisson's ratio ν12: strain along 2 over strain along 1, for stress along 1.
    pub ratio: f64,
    /// Shear moduli G12, G13, G23.
    pub shear: [f64; 3],
}

/// Plane stress elasticity of a lamina in the directions meridian (s) and hoop (θ).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrthotropicPlane {
    /// Stiffnesses ss, sθ, θθ.
    stiffness: [f64; 3],
    /// Shear stress per strain along s and along θ.
    twist: [f64; 2],
    /// Shear modulus between the meridian and the normal.
    transverse: f64,
}

/// Elasticity of a point of a shell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointElasticity {
    /// Isotropic.
    Isotropic(PlaneElastic),
    /// Orthotropic in the plane.
    Orthotropic(OrthotropicPlane),
}

impl Lamina {
    /// Returns whether the strain energy is positive for every strain: ν12² < E1/E2.
    pub fn is_stable(&self) -> bool {
        self.ratio * self.ratio < self.young[0] / self.young[1]
    }

    /// Returns the elasticity with direction 1 at an angle from the meridian toward the hoop, in degrees. Equation (8.9).
    pub fn turned(&self, degrees: f64) -> OrthotropicPlane {
        let [e1, e2] = self.young;
        let [g12, g13, g23] = self.shear;
        let determinant = 1.0 - self.ratio * self.ratio * e2 / e1;
        let [q11, q12, q22] = [e1 / determinant, self.ratio * e2 / determinant, e2 / determinant];
        let [c, s] = direction(degrees);
        let (cc, ss) = (c * c, s * s);
        let mixed = 2.0 * (q12 + 2.0 * g12) * ss * cc;
        let (first, second) = (q11 - q12 - 2.0 * g12, q12 - q22 + 2.0 * g12);
        OrthotropicPlane {
            stiffness: [
                q11 * cc * cc + mixed + q22 * ss * ss,
                (q11 + q22 - 4.0 * g12) * ss * cc + q12 * (ss * ss + cc * cc),
                q11 * ss * ss + mixed + q22 * cc * cc,
            ],
            twist: [s * c * (first * cc + second * ss), s * c * (first * ss + second * cc)],
            transverse: g13 * cc + g23 * ss,
        }
    }
}

/// Returns cosine and sine of an angle in degrees; exact for multiples of 90.
pub fn direction(degrees: f64) -> [f64; 2] {
    let turn = degrees / 90.0;
    if turn == turn.round() {
        return [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]][turn.rem_euclid(4.0) as usize];
    }
    [libm::cos(degrees.to_radians()), libm::sin(degrees.to_radians())]
}

impl OrthotropicPlane {
    /// Returns the stress after a strain increment, both along meridian and hoop.
    #[inline(always)]
    pub fn trial(&self, stress: [f64; 2], strain: [f64; 2]) -> [f64; 2] {
        let [a, b, c] = self.stiffness;
        [stress[0] + a * strain[0] + b * strain[1], stress[1] + b * strain[0] + c * strain[1]]
    }

    /// Returns the elastic strain of a stress.
    fn strain(&self, stress: [f64; 2]) -> [f64; 2] {
        let [a, b, c] = self.stiffness;
        let determinant = a * c - b * b;
        [(c * stress[0] - b * stress[1]) / determinant, (a * stress[1] - b * stress[0]) / determinant]
    }
}

impl PointElasticity {
    /// Returns the stiffnesses ss, sθ, θθ.
    pub fn stiffness(&self) -> [f64; 3] {
        match self {
            PointElasticity::Isotropic(elastic) => {
                let modulus = elastic.modulus();
                [modulus, elastic.ratio * modulus, modulus]
            }
            PointElasticity::Orthotropic(plane) => plane.stiffness,
        }
    }

    /// Returns the shear stresses per strain along meridian and hoop.
    pub fn twist(&self) -> [f64; 2] {
        match self {
            PointElasticity::Isotropic(_) => [0.0; 2],
            PointElasticity::Orthotropic(plane) => plane.twist,
        }
    }

    /// Returns the shear modulus between meridian and normal.
    pub fn transverse_shear(&self) -> f64 {
        match self {
            PointElasticity::Isotropic(elastic) => elastic.shear(),
            PointElasticity::Orthotropic(plane) => plane.transverse,
        }
    }

    /// Returns the strain through the thickness per sum of both stresses; 0 for a lamina, whose constants do not define it.
    #[inline(always)]
    pub fn thinning(&self) -> f64 {
        match self {
            PointElasticity::Isotropic(elastic) => -elastic.ratio / elastic.young,
            PointElasticity::Orthotropic(_) => 0.0,
        }
    }

    /// Returns the shear stress between meridian and hoop that belongs to a stress along meridian and hoop.
    pub fn shear_stress(&self, stress: [f64; 2]) -> f64 {
        let PointElasticity::Orthotropic(plane) = self else { return 0.0 };
        let strain = plane.strain(stress);
        plane.twist[0] * strain[0] + plane.twist[1] * strain[1]
    }

    /// Returns the strain energy per volume.
    pub fn energy(&self, [along, hoop]: [f64; 2]) -> f64 {
        match self {
            PointElasticity::Isotropic(PlaneElastic { young, ratio }) => {
                0.5 * (along * along + hoop * hoop - 2.0 * ratio * along * hoop) / young
            }
            PointElasticity::Orthotropic(plane) => {
                let strain = plane.strain([along, hoop]);
                0.5 * (along * strain[0] + hoop * strain[1])
            }
        }
    }
}

/// Returns the components 11, 22, 12 of a symmetric tensor in directions at an angle, in degrees, from its components along
/// meridian and hoop and their shear component.
pub fn in_layer(degrees: f64, [along, hoop, shear]: [f64; 3]) -> [f64; 3] {
    let [c, s] = direction(degrees);
    [
        c * c * along + s * s * hoop + 2.0 * s * c * shear,
        s * s * along + c * c * hoop - 2.0 * s * c * shear,
        s * c * (hoop - along) + (c * c - s * s) * shear,
    ]
}

#[cfg(test)]
mod tests {
    use super::{Lamina, PointElasticity, in_layer};
    use crate::kernel::plane_stress::PlaneElastic;

    const CARBON: Lamina = Lamina { young: [181e9, 10.3e9], ratio: 0.28, shear: [7.17e9, 7.17e9, 3.5e9] };

    /// Reduced stiffnesses of T300/5208 (Tsai and Hahn 1980, Introduction to Composite Materials, tables 1.7 and 3.4), in GPa:
    /// along the fibres, and at 45 degrees.
    #[test]
    fn stiffness_of_a_turned_lamina_matches_published_values() {
        for (angle, stiffness, twist) in
            [(0.0, [181.8, 2.897, 10.35], [0.0, 0.0]), (45.0, [56.66, 42.32, 56.66], [42.87, 42.87])]
        {
            let plane = PointElasticity::Orthotropic(CARBON.turned(angle));
            let close = |found: f64, expected: f64| (found / 1e9 - expected).abs() < 1e-3 * 56.66;
            assert!(plane.stiffness().iter().zip(stiffness).all(|(a, b)| close(*a, b)), "{:?}", plane.stiffness());
            assert!(plane.twist().iter().zip(twist).all(|(a, b)| close(*a, b)), "{:?}", plane.twist());
        }
    }

    /// Half a turn changes nothing; a quarter turn exchanges the directions.
    #[test]
    fn quarter_turns_exchange_directions() {
        let [straight, across, around] = [0.0, 90.0, 180.0].map(|a| CARBON.turned(a));
        assert_eq!(straight, around);
        assert_eq!(straight.stiffness[0], across.stiffness[2]);
        assert_eq!((across.transverse, across.twist), (3.5e9, [0.0; 2]));
    }

    /// A lamina with equal moduli is isotropic at every angle.
    #[test]
    fn lamina_of_an_isotropic_material_is_isotropic() {
        let steel = PlaneElastic { young: 200e9, ratio: 0.3 };
        let lamina = Lamina { young: [200e9; 2], ratio: 0.3, shear: [steel.shear(); 3] };
        let isotropic = PointElasticity::Isotropic(steel);
        for angle in [0.0, 30.0, 90.0, -45.0] {
            let plane = PointElasticity::Orthotropic(lamina.turned(angle));
            let (a, b) = (plane.stiffness(), isotropic.stiffness());
            assert!((0..3).all(|i| (a[i] / b[i] - 1.0).abs() < 1e-12), "{a:?} {b:?}");
            assert!(plane.twist().iter().all(|t| t.abs() < 1e-4));
            assert!((plane.energy([3e6, -1e6]) / isotropic.energy([3e6, -1e6]) - 1.0).abs() < 1e-12);
        }
    }

    /// Stress in the directions of the layer follows Hooke's law of the layer.
    #[test]
    fn stress_in_the_layer_obeys_its_law() {
        let (angle, strain) = (30.0, [1e-3, -4e-4]);
        let plane = CARBON.turned(angle);
        let stress = plane.trial([0.0; 2], strain);
        let shear = PointElasticity::Orthotropic(plane).shear_stress(stress);
        let [s1, s2, s12] = in_layer(angle, [stress[0], stress[1], shear]);
        let [e1, e2, half] = in_layer(angle, [strain[0], strain[1], 0.0]);
        assert!((s1 / CARBON.young[0] - CARBON.ratio * s2 / CARBON.young[0] - e1).abs() < 1e-15);
        assert!((s2 / CARBON.young[1] - CARBON.ratio * s1 / CARBON.young[0] - e2).abs() < 1e-15);
        assert!((s12 / CARBON.shear[0] - 2.0 * half).abs() < 1e-15);
    }
}
