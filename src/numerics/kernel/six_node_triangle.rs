//! The six-node axisymmetric triangle (CAX6M) as a composite element: strains at three points, volume, masses, a bound
//! of the highest frequency.
//!
//! The element consists of four triangles with linear displacements. Their strains are projected onto strains that are
//! linear over the element (least squares; Guo, Ortiz, Belytschko and Repetto 2000, Int. J. Numer. Meth. Eng. 47, 287,
//! "Triangular composite finite elements"), here over the volume of the ring, and evaluated at three points (2/3, 1/6,
//! 1/6) whose volumes integrate linear functions exactly. Linear displacements have exact strains, and the forces of a
//! uniform stress are those of the tractions on the sides.
//!
//! Each point has its own volume change. With a common value for the whole element, only the deviatoric stress would
//! resist dilations that vary over the element, and a yielding element could fold.
//!
//! Nodes are ordered counter-clockwise around the boundary: corner, middle, corner, middle, corner, middle.

#![allow(clippy::needless_range_loop)] // Loops over nodes and points have the form of loops over lanes.

use super::lanes::{InlineMap, inline_from_fn};
use std::f64::consts::PI;

use super::topology::ElementTopology;

/// Number of nodes of the element.
pub const NODES: usize = 6;
/// Number of integration points.
pub const POINTS: usize = 3;

/// Linear shape functions of the corners at the nodes: 1 at the corner, 0 on the opposite side.
const WEIGHTS: [[f64; NODES]; POINTS] =
    [[1.0, 0.5, 0.0, 0.0, 0.0, 0.5], [0.0, 0.5, 1.0, 0.5, 0.0, 0.0], [0.0, 0.0, 0.0, 0.5, 1.0, 0.5]];

/// Gradient operators at the points of an element times their volumes, per radian.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TriangleOperators {
    /// Volume times the derivative along r, for each point and node, length².
    pub r: [[f64; NODES]; POINTS],
    /// Volume times the derivative along z, length².
    pub z: [[f64; NODES]; POINTS],
    /// Volume times 1/r, length².
    pub hoop: [[f64; NODES]; POINTS],
    /// Volume of each point, length³.
    pub volume: [f64; POINTS],
}

impl TriangleOperators {
    /// Computes the operators from the nodal coordinates.
    #[inline(always)]
    pub fn of(r: [f64; NODES], z: [f64; NODES]) -> TriangleOperators {
        let mut g = TriangleOperators::default();
        // Integrals of products of the linear functions of two corners, by the midpoints of sides.
        let mut products = [[0.0; POINTS]; POINTS];
        for cell in ElementTopology::SixNodeTriangle.cells() {
            let [a, b, c] = [cell[0], cell[1], cell[2]];
            let along = [z[b] - z[c], z[c] - z[a], z[a] - z[b]];
            let across = [r[c] - r[b], r[a] - r[c], r[b] - r[a]];
            let twice = (r[b] - r[a]) * (z[c] - z[a]) - (r[c] - r[a]) * (z[b] - z[a]);
            let radius = (r[a] + r[b]) + r[c];
            for (p, weights) in WEIGHTS.iter().enumerate() {
                let w = [weights[a], weights[b], weights[c]];
                let sum = (w[0] + w[1]) + w[2];
                // Integral over the area, times 24, of a triangle with linear w and r: (sum of w)(sum of r) + sum of w
                // r.
                let moment = (sum * radius + ((w[0] * r[a] + w[1] * r[b]) + w[2] * r[c])) * (1.0 / 24.0);
                g.volume[p] += moment * twice;
                for (i, node) in [a, b, c].into_iter().enumerate() {
                    g.r[p][node] += moment * along[i];
                    g.z[p][node] += moment * across[i];
                    g.hoop[p][node] += (sum + w[i]) * twice * (1.0 / 24.0);
                }
            }
            for [i, j] in [[a, b], [b, c], [c, a]] {
                let share = twice * (r[i] + r[j]) * (1.0 / 12.0);
                let w: [f64; POINTS] = inline_from_fn(|p| 0.5 * (WEIGHTS[p][i] + WEIGHTS[p][j]));
                for p in 0..POINTS {
                    for q in 0..POINTS {
                        products[p][q] += share * w[p] * w[q];
                    }
                }
            }
        }
        g.project(&products)
    }

    /// Converts integrals weighted by the linear corner functions to values at the points. Equation (5.16).
    #[inline(always)]
    fn project(&self, m: &[[f64; POINTS]; POINTS]) -> TriangleOperators {
        let minor = |p: usize, q: usize| {
            let ([a, b], [c, d]) = ([(p + 1) % 3, (p + 2) % 3], [(q + 1) % 3, (q + 2) % 3]);
            m[a][c] * m[b][d] - m[a][d] * m[b][c]
        };
        let inverse = 1.0 / ((m[0][0] * minor(0, 0) + m[0][1] * minor(0, 1)) + m[0][2] * minor(0, 2));
        let third = self.total() * (1.0 / 3.0);
        let volume = self.volume.inline_map(|v| 2.0 * v - third);
        let mut projected = TriangleOperators { volume, ..TriangleOperators::default() };
        for p in 0..POINTS {
            for q in 0..POINTS {
                let sum = (minor(0, q) + minor(1, q)) + minor(2, q);
                let part = volume[p] * inverse * (0.5 * minor(p, q) + (1.0 / 6.0) * sum);
                for n in 0..NODES {
                    projected.r[p][n] += part * self.r[q][n];
                    projected.z[p][n] += part * self.z[q][n];
                    projected.hoop[p][n] += part * self.hoop[q][n];
                }
            }
        }
        projected
    }

    /// Returns the volume of the element per radian.
    #[inline(always)]
    pub fn total(&self) -> f64 {
        (self.volume[0] + self.volume[1]) + self.volume[2]
    }

    /// Returns the velocity gradients at a point times its volume: rr, zz, hoop, rz and zr.
    #[inline(always)]
    pub fn gradients(&self, point: usize, v_r: &[f64; NODES], v_z: &[f64; NODES]) -> [f64; 5] {
        let (r, z, hoop) = (&self.r[point], &self.z[point], &self.hoop[point]);
        [dot(r, v_r), dot(z, v_z), dot(hoop, v_r), dot(z, v_r), dot(r, v_z)]
    }

    /// Returns the relative rate of volume.
    #[inline(always)]
    pub fn dilation(&self, v_r: &[f64; NODES], v_z: &[f64; NODES]) -> f64 {
        let of_point = |p: usize| {
            let [rr, zz, hoop, ..] = self.gradients(p, v_r, v_z);
            rr + zz + hoop
        };
        (of_point(0) + of_point(1) + of_point(2)) / self.total()
    }

    /// Returns the nodal forces `[r, z]`, per radian, of stresses rr, zz, hoop, rz at the points.
    #[inline(always)]
    pub fn forces(&self, stress: &[[f64; 4]; POINTS]) -> [[f64; 2]; NODES] {
        let mut forces = [[0.0; 2]; NODES];
        for p in 0..POINTS {
            let [rr, zz, hoop, rz] = stress[p];
            for (n, force) in forces.iter_mut().enumerate() {
                force[0] += self.r[p][n] * rr + self.hoop[p][n] * hoop + self.z[p][n] * rz;
                force[1] += self.z[p][n] * zz + self.r[p][n] * rz;
            }
        }
        forces
    }

    /// Returns bounds of squared frequencies over a modulus and 2π, for given nodal masses: of volumetric strain, and
    /// of deviatoric strain with twice the shear modulus. Equation (5.18).
    ///
    /// The energy density of an elastic element is K/2 (tr e)² + G |dev e|². For displacements u with u . M u = 1 the
    /// volumetric part is at most K/2 times the largest eigenvalue of the products of the operators of tr e at the
    /// points, hence at most the root of the sum of their squares. The deviatoric part is at most G times the largest
    /// eigenvalue of the sum over points of BᵀB, hence at most the fourth root of the sum of fourth powers of all
    /// eigenvalues.
    #[inline(always)]
    pub fn bounds(&self, inverse_mass: &[f64; NODES]) -> [f64; 2] {
        let traces: [[[f64; NODES]; 2]; POINTS] =
            inline_from_fn(|p| [inline_from_fn(|n| self.r[p][n] + self.hoop[p][n]), self.z[p]]);
        let mut squares = 0.0;
        for p in 0..POINTS {
            for q in 0..POINTS {
                let terms: [f64; NODES] = inline_from_fn(|n| {
                    (traces[p][0][n] * traces[q][0][n] + traces[p][1][n] * traces[q][1][n]) * inverse_mass[n]
                });
                let product = sum6(&terms);
                squares += product * product / (self.volume[p] * self.volume[q]);
            }
        }
        let mut matrix = [[0.0; NODES]; NODES];
        for n in 0..NODES {
            for m in 0..=n {
                let pair = |list: &[[f64; NODES]; POINTS], p: usize| list[p][n] * list[p][m];
                let of_point = |p: usize| (pair(&self.r, p) + pair(&self.z, p) + pair(&self.hoop, p)) / self.volume[p];
                let entry = (of_point(0) + of_point(1)) + of_point(2);
                matrix[n][m] = entry;
                matrix[m][n] = entry;
            }
        }
        // M⁻¹ A has the eigenvalues of its symmetric form; this is the trace of its fourth power.
        let mut square = [[0.0; NODES]; NODES];
        for n in 0..NODES {
            for m in 0..NODES {
                let terms: [f64; NODES] = inline_from_fn(|k| matrix[n][k] * inverse_mass[k] * matrix[k][m]);
                square[n][m] = inverse_mass[n] * sum6(&terms);
            }
        }
        let mut fourth = 0.0;
        for n in 0..NODES {
            for m in 0..NODES {
                fourth += square[n][m] * square[m][n];
            }
        }
        [squares.sqrt(), fourth.sqrt().sqrt()]
    }
}

#[inline(always)]
fn sum6(x: &[f64; NODES]) -> f64 {
    ((x[0] + x[1]) + (x[2] + x[3])) + (x[4] + x[5])
}

/// Returns the scalar product, summed in order.
#[inline(always)]
pub fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    let mut sum = 0.0;
    for i in 0..N {
        sum += a[i] * b[i];
    }
    sum
}

/// Returns the square of a bound of the highest frequency for these moduli and inverse masses. Equation (5.17).
#[inline(always)]
pub fn frequency_squared(g: &TriangleOperators, [bulk, shear]: [f64; 2], inverse_mass: &[f64; NODES]) -> f64 {
    let [volume, shape] = g.bounds(inverse_mass);
    2.0 * PI * (bulk * volume + 2.0 * shear * shape)
}

/// Returns the elastic stiffness, force per length, for `[r, z]` of each node in turn.
pub fn stiffness(places: [[f64; 2]; NODES], [bulk, shear]: [f64; 2]) -> [[f64; 2 * NODES]; 2 * NODES] {
    let g = TriangleOperators::of(places.inline_map(|p| p[0]), places.inline_map(|p| p[1]));
    inline_from_fn(|d| {
        let mut v = [[0.0; NODES]; 2];
        v[d % 2][d / 2] = 1.0;
        let stress = [0, 1, 2].inline_map(|p| {
            let [rr, zz, hoop, rz, zr] = g.gradients(p, &v[0], &v[1]).inline_map(|s| s / g.volume[p]);
            let dilation = rr + zz + hoop;
            let normal = |e: f64| bulk * dilation + 2.0 * shear * (e - dilation * (1.0 / 3.0));
            [normal(rr), normal(zz), normal(hoop), shear * (rz + zr)]
        });
        let forces = g.forces(&stress);
        inline_from_fn(|i| 2.0 * PI * forces[i / 2][i % 2])
    })
}

/// Returns the lumped masses of the nodes: row sums of the four triangles.
pub fn masses(places: [[f64; 2]; NODES], density: f64) -> [f64; NODES] {
    let mut masses = [0.0; NODES];
    for cell in ElementTopology::SixNodeTriangle.cells() {
        let corners = [cell[0], cell[1], cell[2]];
        let [a, b, c] = corners.inline_map(|n| places[n]);
        let twice = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        let radius = (a[0] + b[0]) + c[0];
        for n in corners {
            masses[n] += density * PI / 12.0 * twice * (radius + places[n][0]);
        }
    }
    masses
}

#[cfg(test)]
mod tests {
    use faer::{Mat, Side};

    use super::*;
    use crate::kernel::{quad, solid};

    /// Triangles of many shapes near the axis and far from it, with middle nodes off the sides.
    fn shapes() -> impl Iterator<Item = [[f64; 2]; NODES]> {
        (0..2000_usize).filter_map(|shape| {
            let noise = |i: usize| ((shape * 7919 + i * 104_729) % 9973) as f64 / 9973.0 - 0.5;
            let inner = [0.0, 0.3, 2.0, 50.0][shape % 4];
            let high = [0.1, 0.5, 1.0, 3.0, 10.0][shape % 5];
            let (a, b) = ([inner, 0.0], [inner + 1.0 + 0.5 * noise(0), 0.3 * high * noise(1)]);
            let c = [inner + if shape % 3 == 0 { 0.0 } else { 0.5 + noise(2) }, high * (1.0 + 0.5 * noise(3))];
            let middle = |p: [f64; 2], q: [f64; 2], i: usize| {
                let on_axis = p[0] == 0.0 && q[0] == 0.0;
                let off = if on_axis { 0.0 } else { 0.15 * noise(i) };
                [0.5 * (p[0] + q[0]) + off, 0.5 * (p[1] + q[1]) + 0.1 * high * noise(i + 1)]
            };
            let places = [a, middle(a, b, 4), b, middle(b, c, 6), c, middle(c, a, 8)];
            let whole = ElementTopology::SixNodeTriangle
                .cells()
                .iter()
                .all(|s| quad::volume(s.map(|i| places[i])) > 0.02 * high);
            (whole && places.iter().all(|p| p[0] >= 0.0)).then_some(places)
        })
    }

    fn columns(places: [[f64; 2]; NODES]) -> [[f64; NODES]; 2] {
        [places.map(|p| p[0]), places.map(|p| p[1])]
    }

    #[test]
    fn point_volumes_sum_to_the_element_and_linear_fields_are_exact() {
        let mut count = 0;
        for places in shapes() {
            count += 1;
            let [r, z] = columns(places);
            let g = TriangleOperators::of(r, z);
            let volume = solid::volume(&places);
            assert!((2.0 * PI * g.total() / volume - 1.0).abs() < 1e-12);
            assert!((masses(places, 3.0).iter().sum::<f64>() / (3.0 * volume) - 1.0).abs() < 1e-12);
            assert!(masses(places, 3.0).iter().all(|m| *m > 0.0) && g.volume.iter().all(|v| *v > 0.0));
            for p in 0..POINTS {
                let [rr, zz, hoop, rz, zr] = g.gradients(p, &r, &z).map(|x| x / g.volume[p]);
                assert!([rr - 1.0, zz - 1.0, hoop - 1.0, rz, zr].iter().all(|x| x.abs() < 1e-10), "{places:?}");
                let sheared = g.gradients(p, &[0.0; NODES], &r.map(|r| 2.0 * r + 5.0)).map(|x| x / g.volume[p]);
                assert!((sheared[4] - 2.0).abs() < 1e-10 && sheared[1].abs() < 1e-10);
            }
        }
        assert!(count > 500, "{count} shapes");
    }

    /// Forces of a uniform pressure are the derivatives of the volume, i.e. the forces of a pressure on the sides.
    #[test]
    fn pressure_forces_match_volume_derivatives() {
        for places in shapes().take(300) {
            let [r, z] = columns(places);
            let forces = TriangleOperators::of(r, z).forces(&[[1.0, 1.0, 1.0, 0.0]; POINTS]);
            let size = forces.as_flattened().iter().fold(0.0, |m: f64, f| m.max(f.abs()));
            for n in 0..NODES {
                for axis in 0..2 {
                    let moved = |h: f64| {
                        let mut places = places;
                        places[n][axis] += h;
                        solid::volume(&places)
                    };
                    let slope = (moved(1e-5) - moved(-1e-5)) / 2e-5;
                    assert!((2.0 * PI * forces[n][axis] - slope).abs() < 1e-6 * (1.0 + size) * 2.0 * PI);
                }
            }
        }
    }

    /// Comparison with dense eigenvalues (faer): no frequency exceeds the bound, and only translation along z is
    /// stress-free.
    #[test]
    fn only_axial_translation_is_free_and_the_frequency_bound_holds() {
        let mut largest: f64 = 0.0;
        let mut mean = (0.0, 0);
        for (bulk, shear) in [(1.0, 1.5), (2.0, 0.9), (100.0, 1.0)] {
            for places in shapes() {
                let [r, z] = columns(places);
                let (matrix, mass) = (stiffness(places, [bulk, shear]), masses(places, 1.0));
                let entry = |a: usize, b: usize| matrix[a][b] / (mass[a / 2] * mass[b / 2]).sqrt();
                let dense = Mat::<f64>::from_fn(12, 12, |a, b| 0.5 * (entry(a, b) + entry(b, a)));
                let values = dense.self_adjoint_eigenvalues(Side::Lower).expect("eigenvalues");
                assert!(values[0].abs() < 1e-9 * values[11], "{values:?}");
                // Far from the axis a translation along r is almost free of stress.
                let first = if r[0] > 10.0 { 2 } else { 1 };
                assert!(values[first] > 1e-8 * values[11] / bulk, "{places:?} {values:?}");
                let bound = frequency_squared(&TriangleOperators::of(r, z), [bulk, shear], &mass.map(|m| 1.0 / m));
                largest = largest.max(values[11] / bound);
                mean = (mean.0 + (values[11] / bound).sqrt(), mean.1 + 1);
            }
        }
        // Two triangles with a common side: only translation along z is stress-free.
        let places = [
            [1.0, 0.0],
            [2.0, 0.0],
            [2.0, 1.0],
            [1.0, 1.0],
            [1.5, 0.0],
            [2.0, 0.5],
            [1.5, 0.5],
            [1.5, 1.0],
            [1.0, 0.5],
        ];
        let mut dense = Mat::<f64>::zeros(18, 18);
        for nodes in [[0, 4, 1, 5, 2, 6], [0, 6, 2, 7, 3, 8]] {
            let matrix = stiffness(nodes.map(|n: usize| places[n]), [1.0, 0.5]);
            for (a, b) in (0..12).flat_map(|a| (0..12).map(move |b| (a, b))) {
                dense[(2 * nodes[a / 2] + a % 2, 2 * nodes[b / 2] + b % 2)] += 0.5 * (matrix[a][b] + matrix[b][a]);
            }
        }
        let values = dense.self_adjoint_eigenvalues(Side::Lower).expect("eigenvalues");
        assert!(values[0].abs() < 1e-12 * values[17] && values[1] > 1e-4 * values[17], "{values:?}");
        println!("highest frequency over its bound: {:.4}, mean {:.4}", largest.sqrt(), mean.0 / mean.1 as f64);
        assert!(largest <= 1.0, "{largest}");
    }
}
