//! Assumed strains that vary across a quadrilateral, without shear or volumetric locking: in each of two directions of
//! the element a normal strain that is linear across it, with the corresponding hoop strain. (Directional assumed
//! strain of Belytschko and Bindeman 1991, Comput. Meth. Appl. Mech. Eng. 88, 311, extended to rings: without the hoop
//! part, a plate would bend with E instead of E/(1 - ν²).)

use super::lanes::InlineMap;
use super::quad::{QuadOperators, SquareSums, UNIT, at_corners, sums};
use super::real::Real;

/// Smallest ratio of the squared lengths of the two directions, which limits the stiffness of flattened elements.
const FLAT: f64 = 1e-4;

/// The two directions of an element. Each field is a strain in one direction that varies along the other. Strains are
/// the values at the edge of the element; the mean square is a third of their square. The first entry of a pair belongs
/// to the first direction.
#[derive(Clone, Copy, Debug)]
pub struct AssumedDirections<T = f64> {
    /// Twice the lines `[r, z]` between the midpoints of the edges 4-1 and 2-3, and of 1-2 and 3-4.
    sides: [[T; 2]; 2],
    /// Inverse squares of their lengths, and the lines divided by the squares.
    per: [T; 2],
    dual: [[T; 2]; 2],
    /// Factors from displacements along r, combined by [`hoop`], to hoop strains: the transverse line over the mean
    /// radius V/(2πA) and the volume, from grad (v_r/r) = (grad v_r - v_r/r)/r.
    across: [[T; 2]; 2],
    /// Sum of the squares of `across`.
    wide: T,
}

impl<T: Real> AssumedDirections<T> {
    /// Computes the directions from the [`sums`] of r and z and the factor of [`ring`].
    #[inline(always)]
    pub fn of([_, a_r, c_r, _]: [T; 4], [_, a_z, c_z, _]: [T; 4], ring: T) -> Self {
        let (aa, cc) = (a_r * a_r + a_z * a_z, c_r * c_r + c_z * c_z);
        let (least_a, least_c) = (aa.like(FLAT) * cc, aa.like(FLAT) * aa);
        let (aa, cc) = (least_a.if_less(aa, aa, least_a), least_c.if_less(cc, cc, least_c));
        // One division for both squares.
        let both = aa.like(1.0) / (aa * cc);
        let (per_a, per_c) = (cc * both, aa * both);
        let factor = ring.like(0.25) * ring;
        AssumedDirections {
            sides: [[a_r, a_z], [c_r, c_z]],
            per: [per_a, per_c],
            dual: [[per_a * a_r, per_a * a_z], [per_c * c_r, per_c * c_z]],
            across: [[factor * c_r, factor * c_z], [factor * a_r, factor * a_z]],
            wide: (factor * factor) * (aa + cc),
        }
    }

    /// Returns the strains in both directions from the pattern's displacement `[r, z]`. Equation (5.9).
    #[inline(always)]
    pub fn along(&self, [q_r, q_z]: [T; 2]) -> [T; 2] {
        let [a, c] = self.dual;
        [a[0] * q_r + a[1] * q_z, c[0] * q_r + c[1] * q_z]
    }

    /// Returns the hoop strains of both fields from displacements along r, combined by [`hoop`]. Equation (5.9).
    #[inline(always)]
    pub fn around(&self, [x, y]: [T; 2]) -> [T; 2] {
        let [a, c] = self.across;
        [a[0] * x + a[1] * y, c[0] * x + c[1] * y]
    }

    /// Returns the components of a tensor rr, zz, rz in both directions.
    #[inline(always)]
    pub fn normal(&self, [rr, zz, rz]: [T; 3]) -> [T; 2] {
        let ([a, c], [dual_a, dual_c]) = (self.sides, self.dual);
        let twice = rz + rz;
        [
            dual_a[0] * (a[0] * rr + a[1] * twice) + dual_a[1] * (a[1] * zz),
            dual_c[0] * (c[0] * rr + c[1] * twice) + dual_c[1] * (c[1] * zz),
        ]
    }

    /// Returns the generalised forces of stresses in both directions and hoop stresses: on the hourglass pattern `[r,
    /// z]`, and on the operators of [`hoop`]. Equation (5.11).
    #[inline(always)]
    pub fn forces(&self, along: [T; 2], around: [T; 2]) -> [[T; 2]; 2] {
        let sum = |[x, y]: [T; 2], [a, c]: [[T; 2]; 2]| [x * a[0] + y * c[0], x * a[1] + y * c[1]];
        [sum(along, self.dual), sum(around, self.across)]
    }

    /// Returns the trace of the fields' stiffness over the corner masses, times three over the volume and the direct
    /// modulus. Input: hourglass pattern and operators of [`hoop`] in base vectors, [`sums`] of the inverse masses, and
    /// the ratio n of the transverse to the direct modulus. The stiffness of a direct strain e and a hoop strain h is
    /// (h + n e)² + (1 - n²) e².
    #[inline(always)]
    pub fn trace(&self, (shape, [by_r, by_z]): ([T; 3], [[T; 4]; 2]), inverse: [T; 4], ratio: T) -> T {
        let [a, c] = self.across;
        let (n_a, n_c) = (ratio * self.dual[0][0], ratio * self.dual[1][0]);
        // There is no hoop strain along z.
        let remainder = (self.per[0] + self.per[1]) - (n_a * n_a + n_c * n_c);
        let [first, second] = [(a, n_a), (c, n_c)].inline_map(
            #[inline(always)]
            |([b_r, b_z], n)| {
                SquareSums::of([
                    b_r * by_r[0] + b_z * by_z[0],
                    b_r * by_r[1] + b_z * by_z[1] + n * shape[0],
                    b_r * by_r[2] + b_z * by_z[2] + n * shape[1],
                    b_r * by_r[3] + b_z * by_z[3] + n * shape[2],
                ])
            },
        );
        let both = first.plus(second);
        both.weighted(inverse) + remainder * SquareSums::of_gradient(shape).weighted(inverse)
    }

    /// Returns an upper bound of the [trace](Self::trace), divided by 1 + |n|, that needs less arithmetic: the
    /// stiffness is not above (1 + |n|)(h² + e²). Input: sums over the corners of the squared pattern over the mass,
    /// and of all squared gradient and hoop operators over the mass. A hoop strain is a product of `across` with the
    /// difference of gradient and hoop operators, whose square is not above twice the sum of their squares.
    #[inline(always)]
    pub fn largest_trace(&self, pattern: T, operators: T) -> T {
        (self.per[0] + self.per[1]) * pattern + self.wide * (operators + operators)
    }
}

/// Returns one over the product of mean radius and volume, in the unit of [`QuadOperators`]; `square` is one over the
/// squared volume. The mean radius follows from the ratio of the volume to the first hoop operator.
#[inline(always)]
pub fn ring<T: Real>(g: &QuadOperators<T>, square: T) -> T {
    square.like(4.0) * g.hoop[0] * square
}

/// Returns the operators `[r, z]` in base vectors from which [`AssumedDirections`] computes hoop strains.
#[inline(always)]
pub fn hoop<T: Real>(g: &QuadOperators<T>) -> [[T; 4]; 2] {
    let zero = g.volume.like(0.0);
    [[-g.hoop[0], g.r[0] - g.hoop[1], g.r[1] - g.hoop[2], g.r[2]], [zero, g.z[0], g.z[1], g.z[2]]]
}

/// Returns the plane stress moduli E/(1 - ν²) and ν E/(1 - ν²) from bulk and shear modulus.
#[inline(always)]
pub fn moduli<T: Real>(bulk: T, shear: T) -> [T; 2] {
    let (two, bulk3) = (shear.like(2.0), bulk.like(3.0) * bulk);
    let per = two * shear / (bulk3 + shear.like(4.0) * shear);
    [two * per * (bulk3 + shear), per * (bulk3 - two * shear)]
}

/// Returns the stiffness of the two fields of an element: force per length, for `[r, z]` of each corner in turn.
pub fn stiffness(corners: [[f64; 2]; 4], [bulk, shear]: [f64; 2]) -> [[f64; 8]; 8] {
    let (r, z) = (sums(corners.inline_map(|c| c[0])), sums(corners.inline_map(|c| c[1])));
    let g = QuadOperators::of::<false>(r, z);
    let per = 1.0 / g.volume;
    let [first, second, pattern] = g.pattern([r[3], z[3]]).inline_map(|part| per * part);
    let shape = at_corners([0.0, first, second, pattern]);
    let [along, transverse] = moduli(bulk, shear);
    let third = UNIT * g.volume / 3.0;
    let (directions, operators) = (AssumedDirections::of(r, z, ring(&g, per * per)), hoop(&g).inline_map(at_corners));
    let mut matrix = [[0.0; 8]; 8];
    for field in 0..2 {
        let column = |d: usize| {
            let (i, axis) = (d / 2, d % 2);
            let mut pushed = [0.0; 2];
            pushed[axis] = shape[i];
            let turned = directions.around(operators.inline_map(|o| o[i]))[field];
            [directions.along(pushed)[field], if axis == 0 { turned } else { 0.0 }]
        };
        for (a, row) in matrix.iter_mut().enumerate() {
            let [e, h] = column(a);
            for (b, entry) in row.iter_mut().enumerate() {
                let [f, k] = column(b);
                *entry += third * (along * (e * f + h * k) + transverse * (e * k + h * f));
            }
        }
    }
    matrix
}

#[cfg(test)]
mod tests {
    use super::{AssumedDirections, QuadOperators, SquareSums, UNIT, at_corners, hoop, moduli, ring, stiffness, sums};
    use crate::kernel::quad::dot3;

    const R: [f64; 4] = [1.0, 3.2, 2.9, 0.8];
    const Z: [f64; 4] = [0.1, -0.2, 1.7, 2.0];

    /// Returns sums, operators, pattern and directions of the element above.
    fn element() -> ([[f64; 4]; 2], QuadOperators, [f64; 3], AssumedDirections) {
        let (r, z) = (sums(R), sums(Z));
        let g = QuadOperators::of::<false>(r, z);
        let per = 1.0 / g.volume;
        ([r, z], g, g.pattern([r[3], z[3]]).map(|part| per * part), AssumedDirections::of(r, z, ring(&g, per * per)))
    }

    /// A thin ring far from the axis bends as a plate strip: E/(1 - ν²) times its second moment of area, for any aspect
    /// ratio.
    #[test]
    fn a_strip_far_from_the_axis_bends_as_a_plate() {
        let (bulk, shear) = (2.0, 0.9);
        let far = 1e6;
        for [long, high] in [[1.0, 1.0], [8.0, 1.0], [0.1, 1.0]] {
            let corners = [[far, 0.0], [far + long, 0.0], [far + long, high], [far, high]];
            let matrix = stiffness(corners, [bulk, shear]);
            // The ends rotate relative to each other by the angle 1: u = ±1/2 of the height at the corners.
            let bent = [-0.25 * high, 0.0, 0.25 * high, 0.0, -0.25 * high, 0.0, 0.25 * high, 0.0];
            let energy: f64 = (0..8).map(|a| (0..8).map(|b| bent[a] * matrix[a][b] * bent[b]).sum::<f64>()).sum();
            let around = 2.0 * std::f64::consts::PI * (far + 0.5 * long);
            let exact = moduli(bulk, shear)[0] * high.powi(3) / 12.0 / long * around;
            // The relative angle of both ends is 1.
            let angle: f64 = 1.0;
            assert!((energy / (exact * angle * angle) - 1.0).abs() < 1e-5, "{long} {high}: {energy} {exact}");
        }
    }

    /// A translation along z and a uniform radial expansion cause no strain of the fields.
    #[test]
    fn uniform_strain_has_no_assumed_part() {
        let ([r, z], g, shape, directions) = element();
        let dot = |a: [f64; 4], b: [f64; 4]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let around = directions.around(hoop(&g).map(|o| dot(o, r)));
        let along = directions.along([r, z].map(|x| dot3(shape, [x[1], x[2], x[3]])));
        assert!(around.iter().chain(&along).all(|strain| strain.abs() < 1e-12), "{around:?} {along:?}");
        let corners = at_corners([0.0, shape[0], shape[1], shape[2]]);
        assert!(dot(corners, [1.0; 4]).abs() < 1e-12);
    }

    #[test]
    fn trace_matches_the_stiffness_matrix() {
        let (_, g, shape, directions) = element();
        let (inverse, [bulk, shear]) = ([0.3, 0.2, 0.5, 0.7], [2.0, 0.9]);
        let [along, transverse] = moduli(bulk, shear);
        let trace =
            directions.trace((shape, hoop(&g)), sums(inverse), transverse / along) * along * UNIT * g.volume / 3.0;
        let matrix = stiffness([0, 1, 2, 3].map(|i| [R[i], Z[i]]), [bulk, shear]);
        let exact: f64 = (0..8).map(|d| matrix[d][d] * inverse[d / 2]).sum();
        assert!((trace / exact - 1.0).abs() < 1e-13, "{trace} {exact}");
        let weights = sums(inverse);
        let operators = SquareSums::of_gradient(g.r).plus(SquareSums::of_gradient(g.z));
        let operators = operators.plus(SquareSums::of_hoop(g.hoop)).weighted(weights);
        let bound = directions.largest_trace(SquareSums::of_gradient(shape).weighted(weights), operators);
        assert!((along + transverse) * bound * UNIT * g.volume / 3.0 > exact, "{bound} {exact}");
    }

    /// Forces and strains are work-conjugate.
    #[test]
    fn forces_and_strains_are_work_conjugate() {
        let directions = element().3;
        let (q, x, along, around) = ([0.3, -0.4], [0.7, 0.2], [2.0, -3.0], [0.5, 1.5]);
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        let [bent, turned] = directions.forces(along, around);
        let work = dot(along, directions.along(q)) + dot(around, directions.around(x));
        assert!((dot(bent, q) + dot(turned, x) - work).abs() < 1e-14);
        // In a square, the two directional components sum to the in-plane trace of a tensor.
        let flat = AssumedDirections::of(sums([1.0, 3.0, 3.0, 1.0]), sums([0.0, 0.0, 2.0, 2.0]), 1.0);
        assert_eq!(flat.normal([2.0, 5.0, 7.0]), [2.0, 5.0]);
    }
}
