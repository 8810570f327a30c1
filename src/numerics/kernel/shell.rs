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
use super::real::Real;
use std::f64::consts::PI;

use super::section_stiffness::{RotaryRule, SectionStiffness};

/// Strains, or stress resultants per length, in the order of the table above.
pub type SectionComponents<T = f64> = [T; 5];

/// Geometry of an element, or of the elements in a pack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShellFrame<T = f64> {
    /// Unit vector from the first node to the second.
    pub t: [T; 2],
    /// Length of the meridian.
    pub length: T,
    /// Radius at the middle of the meridian.
    pub radius: T,
}

impl<T: Real> ShellFrame<T> {
    /// Creates the frame of a shell between two nodes `[r, z]`.
    #[inline(always)]
    pub fn new([a, b]: [[T; 2]; 2]) -> ShellFrame<T> {
        let (dr, dz) = (b[0] - a[0], b[1] - a[1]);
        let length = (dr * dr + dz * dz).root();
        ShellFrame { t: [dr / length, dz / length], length, radius: length.like(0.5) * (a[0] + b[0]) }
    }

    /// Returns the unit normal.
    #[inline(always)]
    pub fn n(&self) -> [T; 2] {
        [-self.t[1], self.t[0]]
    }

    /// Returns the area of the middle surface, a full ring.
    #[inline(always)]
    pub fn area(&self) -> T {
        self.length.like(2.0 * PI) * self.radius * self.length
    }

    /// Returns the strains for displacements `[r, z]` and a rotation of each node. Equations (8.1), (8.2).
    #[inline(always)]
    pub fn strains(&self, [a, b]: [[T; 3]; 2]) -> SectionComponents<T> {
        let (along, n) = ([b[0] - a[0], b[1] - a[1]], self.n());
        let half = self.length.like(0.5);
        let turn = half * (a[2] + b[2]);
        [
            (along[0] * self.t[0] + along[1] * self.t[1]) / self.length,
            half * (a[0] + b[0]) / self.radius,
            -(b[2] - a[2]) / self.length,
            -turn * self.t[0] / self.radius,
            (along[0] * n[0] + along[1] * n[1]) / self.length - turn,
        ]
    }

    /// Returns forces and moments of the stress resultants on both nodes; their power is minus that of the strains.
    /// Equation (8.5).
    #[inline(always)]
    pub fn forces(&self, [n_s, n_h, m_s, m_h, q]: &SectionComponents<T>) -> [[T; 3]; 2] {
        let (area, n, half) = (self.area(), self.n(), self.length.like(0.5));
        let pull = [0, 1].inline_map(|i: usize| (*n_s * self.t[i] + *q * n[i]) / self.length);
        let hoop = half * *n_h / self.radius;
        let turn = half * (*m_h * self.t[0] / self.radius + *q);
        let bend = *m_s / self.length;
        [
            [area * (pull[0] - hoop), area * pull[1], area * (turn - bend)],
            [-area * (pull[0] + hoop), -area * pull[1], area * (turn + bend)],
        ]
    }

    /// Returns a bound of the highest frequency of the single element, radians per time. The eigenvalues of the
    /// operator of the five strains are real, so that the eighth root of the trace of its eighth power bounds the
    /// largest one. Equation (8.7).
    #[inline(always)]
    pub fn frequency(&self, masses: &[T; 4], thickness: T, stiffness: &SectionStiffness) -> T {
        let operator = stiffness.times(self.area(), thickness, &self.compliance(masses));
        let scale = operator[0][0] + operator[1][1] + operator[2][2] + operator[3][3] + operator[4][4];
        let inverse = scale.like(1.0) / scale;
        let [a, b, c, d, e] = &operator;
        let relative =
            [scaled(a, inverse), scaled(b, inverse), scaled(c, inverse), scaled(d, inverse), scaled(e, inverse)];
        let fourth = square(&square(&relative));
        let [a, b, c, d, e] = fourth;
        let eighth = product(a, &fourth, 0)
            + product(b, &fourth, 1)
            + product(c, &fourth, 2)
            + product(d, &fourth, 3)
            + product(e, &fourth, 4);
        (scale * eighth.root().root().root()).root()
    }

    /// Returns B M⁻¹ Bᵀ.
    #[inline(always)]
    fn compliance(&self, m: &[T; 4]) -> [SectionComponents<T>; 5] {
        let (l, r, t_r, n_r) = (self.length, self.radius, self.t[0], -self.t[1]);
        let like = |value: f64| l.like(value);
        let (zero, half, quarter) = (like(0.0), like(0.5), like(0.25));
        let [a, b, c, d] = m.inline_map(|mass| like(1.0) / mass);
        let ([sum, difference], [turns, twist]) = ([a + b, b - a], [c + d, d - c]);
        let (membrane, bending) = (half * t_r * difference / (l * r), half * t_r * twist / (l * r));
        let (by_hoop, by_bend, by_turn) =
            (half * n_r * difference / (l * r), half * twist / l, quarter * turns * t_r / r);
        [
            [sum / (l * l), membrane, zero, zero, zero],
            [membrane, quarter * sum / (r * r), zero, zero, by_hoop],
            [zero, zero, turns / (l * l), bending, by_bend],
            [zero, zero, bending, quarter * turns * t_r * t_r / (r * r), by_turn],
            [zero, by_hoop, by_bend, by_turn, sum / (l * l) + quarter * turns],
        ]
    }
}

impl ShellFrame {
    /// Returns the lumped masses of both nodes, each for its half of the meridian, from the mass per area.
    pub fn nodal_masses(&self, [a, b]: [f64; 2], per_area: f64) -> [f64; 2] {
        let quarter = 0.25 * PI * self.length * per_area;
        [quarter * (3.0 * a + b), quarter * (a + 3.0 * b)]
    }

    /// Returns the lumped masses of both nodes, and their rotary inertias. Equation (8.6).
    ///
    /// Rotary inertias are scaled with the initial geometry, so that the frequency of transverse shear is not above
    /// that of the membrane (ABAQUS Theory Guide 3.6.5, "Rotary inertia scaling for explicit dynamics"): with the
    /// modulus E' and a mass m and inertia J at each node, the squared shear frequency is K (4/l² + m/J) / (E' h)
    /// relative to 4/l² of the membrane.
    pub fn masses(&self, radii: [f64; 2], per_area: f64, rotary: RotaryRule) -> [f64; 4] {
        let masses = self.nodal_masses(radii, per_area);
        let arm = rotary.least.max(0.25 * self.length * self.length / rotary.slack);
        [masses[0], masses[1], arm * masses[0], arm * masses[1]]
    }
}

// Functions in place of closures: closures within closures are not always inlined.

#[inline(always)]
fn square<T: Real>(a: &[SectionComponents<T>; 5]) -> [SectionComponents<T>; 5] {
    [times(a[0], a), times(a[1], a), times(a[2], a), times(a[3], a), times(a[4], a)]
}

/// Returns a row times a matrix.
#[inline(always)]
fn times<T: Real>(row: SectionComponents<T>, a: &[SectionComponents<T>; 5]) -> SectionComponents<T> {
    [product(row, a, 0), product(row, a, 1), product(row, a, 2), product(row, a, 3), product(row, a, 4)]
}

/// Returns the scalar product of a row and a column of a matrix.
#[inline(always)]
fn product<T: Real>(row: SectionComponents<T>, a: &[SectionComponents<T>; 5], column: usize) -> T {
    row[0] * a[0][column]
        + row[1] * a[1][column]
        + row[2] * a[2][column]
        + row[3] * a[3][column]
        + row[4] * a[4][column]
}

/// Returns `factor (a + ratio b)`.
#[inline(always)]
pub(super) fn coupled<T: Real>(
    factor: T,
    ratio: T,
    a: &SectionComponents<T>,
    b: &SectionComponents<T>,
) -> SectionComponents<T> {
    [
        factor * (a[0] + ratio * b[0]),
        factor * (a[1] + ratio * b[1]),
        factor * (a[2] + ratio * b[2]),
        factor * (a[3] + ratio * b[3]),
        factor * (a[4] + ratio * b[4]),
    ]
}

/// Returns a row times a factor.
#[inline(always)]
pub(super) fn scaled<T: Real>(a: &SectionComponents<T>, factor: T) -> SectionComponents<T> {
    [a[0] * factor, a[1] * factor, a[2] * factor, a[3] * factor, a[4] * factor]
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
    use crate::kernel::section_stiffness::SectionStiffness;

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
            let stiffness = SectionStiffness::uniform(STEEL, thickness);
            let rule = stiffness.rotary_rule(thickness, 0.0);
            let masses = frame.masses([places[0][0], places[1][0]], 7800.0 * thickness, rule);
            let shear = stiffness.shear();
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
            let bound = frame.frequency(&masses, thickness, &stiffness);
            assert!(bound >= largest * (1.0 - 1e-12) && bound < 1.06 * largest, "{bound} {largest}");
            // Rotations do not limit the time increment.
            let membrane = 2.0 / frame.length * (STEEL.modulus() / 7800.0).sqrt();
            assert!(places[0][0] < 0.05 || bound < 1.1 * membrane, "{bound} {membrane}");
        }
    }
}
