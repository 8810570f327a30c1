//! The four-node axisymmetric quadrilateral with mean quadrature (CAX4R): volume, gradient operators, corner masses.
//! Corners run counter-clockwise in (r, z).
//!
//! Mean quadrature integrates the gradient operators over the volume exactly (Flanagan and Belytschko 1981, Int. J.
//! Numer. Meth. Eng. 17, eqs. 13 to 21, extended to the axisymmetric volume): with V = 2π∫r dA, the operator along z is
//! dV/dz_I, and the operator along r is dV/dr_I minus the hoop part 2π∫N_I dA. Centroid quadrature would be inaccurate
//! on the axis.

use super::lanes::InlineMap;
use revolve_derive::Persist;
use std::f64::consts::PI;

use super::real::Real;

/// Factor of all integrals in [`QuadOperators`] and [`CornerGradient`]; it cancels in most uses, which are ratios.
pub const UNIT: f64 = PI / 8.0;

/// Returns the sums of the values at four corners with the signs of the base vectors Sigma, Lambda_1, Lambda_2 and
/// Gamma: the total, the differences along the first and the second direction of the parent square, and the hourglass
/// pattern (Flanagan and Belytschko 1981, eq. 6). They are computed from differences, so that a large common value does
/// not reduce the accuracy of the last three. Equation (5.2).
#[inline(always)]
pub fn sums<T: Real>(x: [T; 4]) -> [T; 4] {
    let (below, above) = (x[1] - x[0], x[2] - x[3]);
    let (left_side, right_side) = (x[3] - x[0], x[2] - x[1]);
    [(x[0] + x[1]) + (x[2] + x[3]), below + above, left_side + right_side, above - below]
}

/// Returns the values at the corners from their components in the four base vectors.
#[inline(always)]
pub fn at_corners<T: Real>([all, first, second, pattern]: [T; 4]) -> [T; 4] {
    let (even, odd) = (all + pattern, all - pattern);
    let (both, apart) = (first + second, first - second);
    [even - both, odd + apart, even + both, odd - apart]
}

/// Gradient operators of a quadrilateral in base vectors, in [`UNIT`]. For values with the [`sums`] s, the integral of
/// the derivative along r is r . s\[1..4\], along z it is z . s\[1..4\], and the integral of the value over r is hoop .
/// s\[0..3\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadOperators<T = f64> {
    /// Components of int dN_I/dr dV in Lambda_1, Lambda_2 and Gamma, length².
    pub r: [T; 3],
    /// Components of int dN_I/dz dV, length².
    pub z: [T; 3],
    /// Components of int N_I/r dV in Sigma, Lambda_1 and Lambda_2, length².
    pub hoop: [T; 3],
    /// Volume, length³.
    pub volume: T,
}

impl<T: Real> QuadOperators<T> {
    /// Computes the operators from the [`sums`] of r and z, with volume or area weighting. With volume weighting they
    /// are the derivatives of the ring volume, minus the hoop part along r. Area weighting (Goudreau and Hallquist
    /// 1982, Comput. Meth. Appl. Mech. Eng. 33, 725) uses the gradients at the centre of the plane section times 2π
    /// times the radius there, so that ratios to the volume are those of the plane. Equations (5.1), (5.3).
    #[inline(always)]
    pub fn of<const AREA: bool>(r: [T; 4], z: [T; 4]) -> Self {
        let section = r[1] * z[2] - r[2] * z[1];
        let (r_first, r_second) = ([r[0] * z[2], -(r[0] * z[1])], [-(r[0] * r[2]), r[0] * r[1]]);
        if AREA {
            let zero = section.like(0.0);
            return QuadOperators {
                r: [r_first[0], r_first[1], zero],
                z: [r_second[0], r_second[1], zero],
                hoop: [section, zero, zero],
                volume: r[0] * section,
            };
        }
        let [_, r1, r2, r3] = r.inline_map(|x| x * x.like(1.0 / 3.0));
        let (first, second) = (r1 * z[3], r2 * z[3]);
        let hoop = [section, first - r3 * z[1], r3 * z[2] - second];
        QuadOperators {
            r: [r_first[0] + first, r_first[1] - second, r2 * z[2] - r1 * z[1]],
            z: [r_second[0] - r1 * r[3], r_second[1] + r2 * r[3], (r1 - r2) * (r[1] + r[2])],
            hoop,
            volume: r[0] * section + (r[1] * hoop[1] + r[2] * hoop[2]),
        }
    }

    /// Returns the hourglass pattern orthogonal to linear fields (Flanagan and Belytschko 1981, eqs. 25 to 45), times
    /// the volume: components in Lambda_1, Lambda_2 and Gamma, from the last of the [`sums`] of r and z. Equation
    /// (5.7).
    #[inline(always)]
    pub fn pattern(&self, [r, z]: [T; 2]) -> [T; 3] {
        let linear = |i: usize| r * self.r[i] + z * self.z[i];
        [-linear(0), -linear(1), self.volume - linear(2)]
    }
}

impl QuadOperators {
    /// Returns the operators at each corner.
    #[inline(always)]
    pub fn gradient(&self) -> CornerGradient {
        let [along, across, around] = [self.r, self.z, self.hoop];
        CornerGradient {
            r: at_corners([0.0, along[0], along[1], along[2]]),
            z: at_corners([0.0, across[0], across[1], across[2]]),
            hoop: at_corners([around[0], around[1], around[2], 0.0]),
            volume: self.volume,
        }
    }
}

/// Returns the scalar product of three numbers, summed in this order.
#[inline(always)]
pub fn dot3<T: Real>(a: [T; 3], b: [T; 3]) -> T {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

/// Sums of the squares and products of fields at the corners, from their components in the base vectors.
#[derive(Clone, Copy)]
pub struct SquareSums<T>([T; 4]);

impl<T: Real> SquareSums<T> {
    /// Returns the sums of a field with these components in Sigma, Lambda_1, Lambda_2 and Gamma.
    #[inline(always)]
    pub fn of([d, a, b, c]: [T; 4]) -> Self {
        SquareSums([(d * d + a * a) + (b * b + c * c), d * a + b * c, d * b + a * c, d * c + a * b])
    }

    /// Returns the sums of a field without component in Sigma, such as a gradient operator or the hourglass pattern.
    #[inline(always)]
    pub fn of_gradient([a, b, c]: [T; 3]) -> Self {
        SquareSums([a * a + (b * b + c * c), b * c, a * c, a * b])
    }

    /// Returns the sums of a field without component in Gamma, such as the hoop operator.
    #[inline(always)]
    pub fn of_hoop([d, a, b]: [T; 3]) -> Self {
        SquareSums([(d * d + a * a) + b * b, d * a, d * b, a * b])
    }

    /// Adds the sums of another field.
    #[inline(always)]
    pub fn plus(self, other: Self) -> Self {
        let (SquareSums(a), SquareSums(b)) = (self, other);
        SquareSums([a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]])
    }

    /// Returns the weighted sum over the corners of the squares of the fields; the weight is given by its [`sums`].
    #[inline(always)]
    pub fn weighted(self, weight: [T; 4]) -> T {
        let SquareSums(sums) = self;
        let products = (sums[1] * weight[1] + sums[2] * weight[2]) + sums[3] * weight[3];
        sums[0] * weight[0] + products.like(2.0) * products
    }
}

/// Integrals over the volume of an element, a full ring, in [`UNIT`].
#[derive(Clone, Copy, Debug, PartialEq, Persist)]
pub struct CornerGradient {
    /// int dN_I/dr dV of each corner, length².
    pub r: [f64; 4],
    /// int dN_I/dz dV, length².
    pub z: [f64; 4],
    /// int N_I/r dV, length².
    pub hoop: [f64; 4],
    /// Volume, length³.
    pub volume: f64,
}

/// Returns the gradient operators of a quadrilateral at its corners.
#[inline(always)]
pub fn gradient(r: [f64; 4], z: [f64; 4]) -> CornerGradient {
    QuadOperators::of::<false>(sums(r), sums(z)).gradient()
}

/// Volume of a ring in [`UNIT`], and its derivatives with respect to r and z of the corners of an element.
pub struct VolumeGradient {
    pub volume: f64,
    pub by_r: [f64; 4],
    pub by_z: [f64; 4],
}

/// Returns the volume of a ring with these corners, and its derivatives.
#[inline(always)]
pub fn volume_gradient(r: [f64; 4], z: [f64; 4]) -> VolumeGradient {
    let QuadOperators { r: [a, b, c], z: [d, e, f], hoop, volume } = QuadOperators::of::<false>(sums(r), sums(z));
    let by_r = at_corners([hoop[0], a + hoop[1], b + hoop[2], c]);
    VolumeGradient { volume, by_r, by_z: at_corners([0.0, d, e, f]) }
}

/// Returns the edge of the square far from the axis that has the stable time increment of an element with these corners, by
/// the bound (4.7) with a uniform density; 0 if its volume is not positive.
pub fn stable_edge(corners: [[f64; 2]; 4]) -> f64 {
    let g = gradient(corners.inline_map(|c| c[0]), corners.inline_map(|c| c[1]));
    if g.volume <= 0.0 {
        return 0.0;
    }
    let masses = corner_masses(corners, 1.0);
    let corner = |i: usize| (g.r[i] * g.r[i] + g.z[i] * g.z[i] + g.hoop[i] * g.hoop[i]) / masses[i];
    (8.0 * g.volume / (UNIT * ((corner(0) + corner(1)) + (corner(2) + corner(3))))).sqrt()
}

/// Returns the area of the plane section, positive for corners that run counter-clockwise.
#[inline(always)]
pub fn section(r: [f64; 4], z: [f64; 4]) -> f64 {
    0.5 * ((r[2] - r[0]) * (z[3] - z[1]) - (r[3] - r[1]) * (z[2] - z[0]))
}

/// Returns the stiffness of a linear elastic element with mean quadrature and of its hourglass control: force per
/// length, for `[r, z]` of each corner in turn. With the gradient operators B it is V Bᵀ C B. The hourglass stiffness
/// follows Flanagan and Belytschko 1981, eqs. 25 to 45, with `hourglass` times the shear modulus.
pub fn stiffness(corners: [[f64; 2]; 4], [bulk, shear]: [f64; 2], hourglass: f64) -> [[f64; 8]; 8] {
    let (r, z) = (corners.inline_map(|c| c[0]), corners.inline_map(|c| c[1]));
    let (r, z) = (sums(r), sums(z));
    let operators = QuadOperators::of::<false>(r, z);
    let g = operators.gradient();
    let (lame, per) = (bulk - 2.0 / 3.0 * shear, 1.0 / g.volume);
    let [first, second, pattern] = operators.pattern([r[3], z[3]]).inline_map(|part| per * part);
    let shape = at_corners([0.0, first, second, pattern]);
    let square: f64 = (0..4).map(|i| g.r[i] * g.r[i] + g.z[i] * g.z[i]).sum();
    let spring = hourglass * shear * square;
    let mut matrix = [[0.0; 8]; 8];
    for i in 0..4 {
        let along = [g.r[i] + g.hoop[i], g.z[i]];
        for j in i..4 {
            let across = [g.r[j] + g.hoop[j], g.z[j]];
            let (rr, zz, hoop) = (g.r[i] * g.r[j], g.z[i] * g.z[j], g.hoop[i] * g.hoop[j]);
            let control = spring * shape[i] * shape[j];
            let block = [
                [
                    lame * along[0] * across[0] + shear * (2.0 * (rr + hoop) + zz) + control,
                    lame * along[0] * across[1] + shear * g.z[i] * g.r[j],
                ],
                [lame * along[1] * across[0] + shear * g.r[i] * g.z[j], lame * zz + shear * (2.0 * zz + rr) + control],
            ];
            for (a, row) in block.into_iter().enumerate() {
                for (b, entry) in row.into_iter().enumerate() {
                    let entry = UNIT * per * entry;
                    (matrix[2 * i + a][2 * j + b], matrix[2 * j + b][2 * i + a]) = (entry, entry);
                }
            }
        }
    }
    matrix
}

/// Returns the volume change of an element with these corners `[r, z, v_r, v_z]` over the previous increment, from the
/// strain at mid-increment, with volume weighting or area weighting.
pub fn volume_change(corners: [[f64; 4]; 4], dt: f64, by_area: bool) -> f64 {
    if by_area { dilation::<true>(corners, dt)[1] } else { dilation::<false>(corners, dt)[1] }
}

/// Returns the volume at mid-increment, and the volume change of [`volume_change`].
pub fn dilation<const AREA: bool>(corners: [[f64; 4]; 4], dt: f64) -> [f64; 2] {
    let middle = |axis: usize| corners.inline_map(|c| c[axis] - 0.5 * dt * c[axis + 2]);
    let g = QuadOperators::of::<AREA>(sums(middle(0)), sums(middle(1)));
    let ([s0, s1, s2, s3], [_, v1, v2, v3]) = (sums(corners.inline_map(|c| c[2])), sums(corners.inline_map(|c| c[3])));
    let growth = dot3(g.r, [s1, s2, s3]) + dot3(g.hoop, [s0, s1, s2]) + dot3(g.z, [v1, v2, v3]);
    [UNIT * g.volume, UNIT * dt * growth]
}

/// Returns the volume of a full ring with these corners `[r, z]`.
pub fn volume(corners: [[f64; 2]; 4]) -> f64 {
    UNIT * gradient(corners.inline_map(|c| c[0]), corners.inline_map(|c| c[1])).volume
}

/// Returns the row-sum lumped mass of each corner: density times int N_I dV, exact with two Gauss points per direction.
pub fn corner_masses(corners: [[f64; 2]; 4], density: f64) -> [f64; 4] {
    let (r, z) = (corners.inline_map(|c| c[0]), corners.inline_map(|c| c[1]));
    let mut masses = [0.0; 4];
    let point = 1.0 / 3f64.sqrt();
    for (xi, eta) in [(-point, -point), (point, -point), (point, point), (-point, point)] {
        let shape = [
            0.25 * (1.0 - xi) * (1.0 - eta),
            0.25 * (1.0 + xi) * (1.0 - eta),
            0.25 * (1.0 + xi) * (1.0 + eta),
            0.25 * (1.0 - xi) * (1.0 + eta),
        ];
        let along_xi = [-0.25 * (1.0 - eta), 0.25 * (1.0 - eta), 0.25 * (1.0 + eta), -0.25 * (1.0 + eta)];
        let along_eta = [-0.25 * (1.0 - xi), -0.25 * (1.0 + xi), 0.25 * (1.0 + xi), 0.25 * (1.0 - xi)];
        let dot = |a: &[f64; 4], b: &[f64; 4]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let jacobian = dot(&along_xi, &r) * dot(&along_eta, &z) - dot(&along_eta, &r) * dot(&along_xi, &z);
        let weight = density * 2.0 * PI * dot(&shape, &r) * jacobian;
        for (mass, n) in masses.iter_mut().zip(shape) {
            *mass += weight * n;
        }
    }
    masses
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::solid;

    const R: [f64; 4] = [1.0, 3.2, 2.9, 0.8];
    const Z: [f64; 4] = [0.1, -0.2, 1.7, 2.0];

    #[test]
    fn operators_are_the_derivatives_of_the_volume() {
        let g = gradient(R, Z);
        let corners: Vec<[f64; 2]> = (0..4).map(|i| [R[i], Z[i]]).collect();
        assert!((UNIT * g.volume / solid::volume(&corners) - 1.0).abs() < 1e-14);
        let step = 1e-6;
        for i in 0..4 {
            let shifted = |d: usize, h: f64| {
                let mut c = corners.clone();
                c[i][d] += h;
                solid::volume(&c)
            };
            let slope = |d| (shifted(d, step) - shifted(d, -step)) / (2.0 * step);
            assert!((UNIT * (g.r[i] + g.hoop[i]) - slope(0)).abs() < 1e-8);
            assert!((UNIT * g.z[i] - slope(1)).abs() < 1e-8);
        }
    }

    #[test]
    fn gradients_of_linear_and_constant_fields_are_exact() {
        let g = gradient(R, Z);
        let dot = |a: [f64; 4], b: [f64; 4]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        for (value, expected) in [
            (dot(g.r, R), g.volume),
            (dot(g.z, Z), g.volume),
            (dot(g.hoop, R), g.volume),
            (dot(g.r, Z), 0.0),
            (dot(g.z, R), 0.0),
            (dot(g.r, [1.0; 4]), 0.0),
            (dot(g.z, [1.0; 4]), 0.0),
        ] {
            assert!((value - expected).abs() < 1e-13 * g.volume, "{value} {expected}");
        }
    }

    #[test]
    fn plane_operators_are_those_of_the_section() {
        let plane = |r, z| QuadOperators::of::<true>(sums(r), sums(z)).gradient();
        let g = plane(R, Z);
        let dot = |a: [f64; 4], b: [f64; 4]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let flat = [dot(g.r, R) - g.volume, dot(g.z, Z) - g.volume, dot(g.hoop, R) - g.volume];
        let none = [dot(g.r, Z), dot(g.z, R), dot(g.r, [1.0; 4]), dot(g.z, [1.0; 4])];
        assert!(flat.iter().chain(&none).all(|x| x.abs() < 1e-13 * g.volume), "{flat:?} {none:?}");
        // Pappus: a ring at the mean radius.
        let square = plane([1.0, 3.0, 3.0, 1.0], [0.0, 0.0, 1.0, 1.0]);
        assert!((UNIT * square.volume - 8.0 * PI).abs() < 1e-13);
    }

    #[test]
    fn section_area_of_a_rectangle_is_exact() {
        assert!((section([1.0, 3.0, 3.0, 1.0], [0.0, 0.0, 1.5, 1.5]) - 3.0).abs() < 1e-15);
    }

    #[test]
    fn corner_masses_sum_to_the_total_and_are_smaller_on_the_axis() {
        let masses = corner_masses([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], 6.0);
        assert!((masses.iter().sum::<f64>() - 6.0 * PI).abs() < 1e-13);
        // int (1 - r) 2π r dr = π/3; of the total π on the axis side.
        assert!((masses[0] - PI).abs() < 1e-13 && (masses[1] - 2.0 * PI).abs() < 1e-13);
    }
}
