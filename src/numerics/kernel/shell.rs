//! The two-node axisymmetric shell with one integration point along the meridian (SAX1): frame, strain increments,
//! nodal forces, masses, transverse shear stiffness and highest frequency.
//!
//! The meridian t points from the first node to the second, and the normal n is t rotated counter-clockwise in (r, z)
//! (ABAQUS Analysis User's Guide 29.6.1, "Shell elements: overview"). Strains assume straight normals (ABAQUS Theory
//! Guide 3.6.2, "Axisymmetric shell elements"). They are computed as rates at mid-increment, so that membrane strains
//! sum to logarithmic strains and rotations may be large:
//!
//! | strain | of velocities v and rotation rates w (counter-clockwise) |
//! |---|---|
//! | meridian | (v2 - v1).t / l |
//! | hoop | v_r / r |
//! | curvature of the meridian | -(w2 - w1) / l |
//! | curvature of the hoop | -w t_r / r |
//! | transverse shear | (v2 - v1).n / l - w |
//!
//! Quantities without an index are means over both nodes. Curvatures are positive if they stretch the side that n
//! points to. The six nodal velocities contain one rigid-body mode and five strain modes; there is no hourglass mode.

use super::lanes::InlineMap;
use std::f64::consts::PI;

use super::plane_stress::PlaneElastic;

/// Strains, or stress resultants per length, in the order of the table above.
pub type SectionComponents = [f64; 5];

/// Shear correction factor of a parabolic shear stress over the thickness.
const SHEAR_SHARE: f64 = 5.0 / 6.0;

/// Geometry of an element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShellFrame {
    /// Unit vector from the first node to the second.
    pub t: [f64; 2],
    /// Length of the meridian.
    pub length: f64,
    /// Radius at the middle of the meridian.
    pub radius: f64,
}

impl ShellFrame {
    /// Creates the frame of a shell between two nodes `[r, z]`.
    pub fn new([a, b]: [[f64; 2]; 2]) -> ShellFrame {
        let (dr, dz) = (b[0] - a[0], b[1] - a[1]);
        let length = (dr * dr + dz * dz).sqrt();
        ShellFrame { t: [dr / length, dz / length], length, radius: 0.5 * (a[0] + b[0]) }
    }

    /// Returns the unit normal.
    pub fn n(&self) -> [f64; 2] {
        [-self.t[1], self.t[0]]
    }

    /// Returns the area of the middle surface, a full ring.
    pub fn area(&self) -> f64 {
        2.0 * PI * self.radius * self.length
    }

    /// Returns the strains for displacements `[r, z]` and a rotation of each node.
    pub fn strains(&self, [a, b]: [[f64; 3]; 2]) -> SectionComponents {
        let (along, n) = ([b[0] - a[0], b[1] - a[1]], self.n());
        let turn = 0.5 * (a[2] + b[2]);
        [
            (along[0] * self.t[0] + along[1] * self.t[1]) / self.length,
            0.5 * (a[0] + b[0]) / self.radius,
            -(b[2] - a[2]) / self.length,
            -turn * self.t[0] / self.radius,
            (along[0] * n[0] + along[1] * n[1]) / self.length - turn,
        ]
    }

    /// Returns forces and moments of the stress resultants on both nodes; their power is minus that of the strains.
    pub fn forces(&self, [n_s, n_h, m_s, m_h, q]: &SectionComponents) -> [[f64; 3]; 2] {
        let (area, n) = (self.area(), self.n());
        let pull = [0, 1].inline_map(|i| (n_s * self.t[i] + q * n[i]) / self.length);
        let hoop = 0.5 * n_h / self.radius;
        let turn = 0.5 * (m_h * self.t[0] / self.radius + q);
        let bend = m_s / self.length;
        [
            [area * (pull[0] - hoop), area * pull[1], area * (turn - bend)],
            [-area * (pull[0] + hoop), -area * pull[1], area * (turn + bend)],
        ]
    }

    /// Returns the lumped masses of both nodes, each for its half of the meridian, and their rotary inertias, from the
    /// mass per area and the initial thickness.
    ///
    /// Rotary inertias are scaled with the initial geometry, so that the frequency of transverse shear is not above
    /// that of the membrane (ABAQUS Theory Guide 3.6.5, "Rotary inertia scaling for explicit dynamics"): with the
    /// modulus E' and a mass m and inertia J at each node, the squared shear frequency is K (4/l² + m/J) / (E' h)
    /// relative to 4/l² of the membrane.
    pub fn masses(&self, [a, b]: [f64; 2], per_area: f64, thickness: f64, elastic: &PlaneElastic) -> [f64; 4] {
        let quarter = 0.25 * PI * self.length * per_area;
        let masses = [quarter * (3.0 * a + b), quarter * (a + 3.0 * b)];
        let slack = elastic.modulus() * thickness / ShellFrame::shear_stiffness(thickness, elastic) - 1.0;
        let arm = (thickness * thickness / 12.0).max(0.25 * self.length * self.length / slack);
        [masses[0], masses[1], arm * masses[0], arm * masses[1]]
    }

    /// Returns the transverse shear force per length and shear angle: elastic, for the initial section.
    pub fn shear_stiffness(thickness: f64, elastic: &PlaneElastic) -> f64 {
        SHEAR_SHARE * elastic.shear() * thickness
    }

    /// Returns a bound of the highest frequency of the single element, radians per time. The eigenvalues of the
    /// operator of the five strains are real, so that the eighth root of the trace of its eighth power bounds the
    /// largest one.
    pub fn frequency(&self, masses: &[f64; 4], thickness: f64, shear_stiffness: f64, elastic: &PlaneElastic) -> f64 {
        let operator = self.operator(masses, thickness, shear_stiffness, elastic);
        let scale: f64 = (0..5).map(|i| operator[i][i]).sum();
        let fourth = square(&square(&operator.inline_map(|row| row.inline_map(|x| x / scale))));
        let eighth: f64 = (0..5).map(|i| (0..5).map(|j| fourth[i][j] * fourth[j][i]).sum::<f64>()).sum();
        (scale * eighth.sqrt().sqrt().sqrt()).sqrt()
    }

    /// Returns the elasticity matrix times B M⁻¹ Bᵀ.
    fn operator(
        &self,
        m: &[f64; 4],
        thickness: f64,
        shear_stiffness: f64,
        elastic: &PlaneElastic,
    ) -> [SectionComponents; 5] {
        let (l, r, t_r, n_r) = (self.length, self.radius, self.t[0], -self.t[1]);
        let [sum, difference] = [1.0 / m[0] + 1.0 / m[1], 1.0 / m[1] - 1.0 / m[0]];
        let [turns, twist] = [1.0 / m[2] + 1.0 / m[3], 1.0 / m[3] - 1.0 / m[2]];
        let (membrane, bending) = (0.5 * t_r * difference / (l * r), 0.5 * t_r * twist / (l * r));
        let (by_hoop, by_bend, by_turn) = (0.5 * n_r * difference / (l * r), 0.5 * twist / l, 0.25 * turns * t_r / r);
        let compliance = [
            [sum / (l * l), membrane, 0.0, 0.0, 0.0],
            [membrane, 0.25 * sum / (r * r), 0.0, 0.0, by_hoop],
            [0.0, 0.0, turns / (l * l), bending, by_bend],
            [0.0, 0.0, bending, 0.25 * turns * t_r * t_r / (r * r), by_turn],
            [0.0, by_hoop, by_bend, by_turn, sum / (l * l) + 0.25 * turns],
        ];
        let stretch = self.area() * elastic.modulus() * thickness;
        let bend = stretch * thickness * thickness / 12.0;
        let pair = |factor: f64, a: &SectionComponents, b: &SectionComponents| {
            [0, 1, 2, 3, 4].inline_map(|j| factor * (a[j] + elastic.ratio * b[j]))
        };
        let [s, h, k, c, q] = &compliance;
        let shear = q.inline_map(|x| self.area() * shear_stiffness * x);
        [pair(stretch, s, h), pair(stretch, h, s), pair(bend, k, c), pair(bend, c, k), shear]
    }
}

fn square(a: &[SectionComponents; 5]) -> [SectionComponents; 5] {
    let entry = |i: usize, j: usize| (0..5).map(|k| a[i][k] * a[k][j]).sum();
    [0, 1, 2, 3, 4].inline_map(|i| [0, 1, 2, 3, 4].inline_map(|j| entry(i, j)))
}

/// Returns Simpson's rule over a unit thickness: position of each point between -1 (the side opposite to n) and 1, and
/// its weight. `count` is odd and at least 3 (ABAQUS Analysis User's Guide 29.6.5, "Using a shell section integrated
/// during the analysis").
pub fn simpson(count: usize) -> Vec<[f64; 2]> {
    let intervals = (count - 1) as f64;
    let weight = |i: usize| match i {
        _ if i == 0 || i + 1 == count => 1.0,
        _ if i % 2 == 1 => 4.0,
        _ => 2.0,
    };
    (0..count).map(|i| [2.0 * i as f64 / intervals - 1.0, weight(i) / (3.0 * intervals)]).collect()
}

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::{ShellFrame, simpson};
    use crate::kernel::plane_stress::PlaneElastic;

    const STEEL: PlaneElastic = PlaneElastic { young: 200e9, ratio: 0.3 };

    #[test]
    fn simpson_rule_integrates_cubics_exactly() {
        for count in [3, 5, 9] {
            let over = |f: fn(f64) -> f64| simpson(count).iter().map(|[x, w]| w * f(*x)).sum::<f64>();
            assert!((over(|_| 1.0) - 1.0).abs() < 1e-15 && over(|x| x * x * x).abs() < 1e-15);
            assert!((over(|x| x * x) - 1.0 / 3.0).abs() < 1e-15);
        }
    }

    /// The power of nodal forces is that of the strains for any motion, and a translation along z causes no strain.
    #[test]
    fn forces_do_the_work_of_the_strains() {
        let frame = ShellFrame::new([[0.3, 0.1], [0.5, 0.4]]);
        let motion = [[0.1, -0.4, 0.7], [0.3, 0.2, -0.5]];
        let resultants = [3.0, -1.0, 0.2, 0.5, 0.9];
        let power: f64 = frame.strains(motion).iter().zip(resultants).map(|(e, s)| e * s).sum::<f64>() * frame.area();
        let forces = frame.forces(&resultants);
        let taken: f64 = forces.iter().flatten().zip(motion.iter().flatten()).map(|(f, v)| -f * v).sum();
        assert!((power / taken - 1.0).abs() < 1e-14);
        assert!(frame.strains([[0.0, 1.0, 0.0]; 2]).iter().all(|e| *e == 0.0));
    }

    /// Comparison with the eigenvalues of the dense stiffness.
    #[test]
    fn frequency_bound_is_close_to_the_highest_frequency() {
        for (places, thickness) in [
            ([[0.0, 0.0], [0.01, 0.0]], 0.002),
            ([[0.1, 0.0], [0.1, 0.005]], 0.002),
            ([[0.1, 0.0], [0.105, 0.003]], 0.0001),
            ([[0.001, 0.0], [0.002, 0.003]], 0.02),
        ] {
            let frame = ShellFrame::new(places);
            let masses = frame.masses([places[0][0], places[1][0]], 7800.0 * thickness, thickness, &STEEL);
            let shear = ShellFrame::shear_stiffness(thickness, &STEEL);
            let unit = |i: usize| {
                let mut motion = [[0.0; 3]; 2];
                motion[i / 3][i % 3] = 1.0;
                frame.strains(motion)
            };
            let c = STEEL.modulus() * thickness;
            let bend = c * thickness * thickness / 12.0;
            let resultants = |e: [f64; 5]| {
                [
                    c * (e[0] + 0.3 * e[1]),
                    c * (e[1] + 0.3 * e[0]),
                    bend * (e[2] + 0.3 * e[3]),
                    bend * (e[3] + 0.3 * e[2]),
                    shear * e[4],
                ]
            };
            let mass = |i: usize| if i % 3 == 2 { masses[2 + i / 3] } else { masses[i / 3] };
            let matrix = Mat::from_fn(6, 6, |i, j| {
                let force = frame.forces(&resultants(unit(j)))[i / 3][i % 3];
                -force / (mass(i) * mass(j)).sqrt()
            });
            let largest = matrix.self_adjoint_eigenvalues(faer::Side::Lower).expect("eigenvalues")[5].sqrt();
            let bound = frame.frequency(&masses, thickness, shear, &STEEL);
            assert!(bound >= largest * (1.0 - 1e-12) && bound < 1.06 * largest, "{bound} {largest}");
            // Rotations do not limit the time increment.
            let membrane = 2.0 / frame.length * (STEEL.modulus() / 7800.0).sqrt();
            assert!(places[0][0] < 0.05 || bound < 1.1 * membrane, "{bound} {membrane}");
        }
    }
}
