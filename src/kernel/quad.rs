//! The four-node axisymmetric quadrilateral with mean quadrature (CAX4R): volume, gradient operators, corner masses.
//! Corners run counter-clockwise in (r, z). Never here: stress, meshes.
//!
//! Mean quadrature integrates the gradient operators over the volume exactly (Flanagan and Belytschko 1981, Int. J. Numer.
//! Meth. Eng. 17, eqs. 13 to 21, carried over to the axisymmetric volume): with V = 2 pi int r dA, the operator along z is
//! dV/dz_I, and along r dV/dr_I less the hoop part 2 pi int N_I dA. Centroid quadrature would be wrong on the axis.

use super::lanes::{InlineMap, inline_from_fn};
use std::f64::consts::PI;

use super::real::Real;

/// Factor of all integrals in [`Operators`] and [`Gradient`]: most uses are ratios, in which it drops out.
pub const UNIT: f64 = PI / 8.0;

/// Sums of the values at four corners with the signs of the base vectors Sigma, Lambda_1, Lambda_2 and Gamma: all, along the first
/// direction of the square that the corners are mapped from, along the second, and the hourglass pattern (Flanagan and
/// Belytschko 1981, eq. 6). Formed from differences, so that what is common to all corners costs no digits of the last three.
#[inline(always)]
pub fn sums<T: Real>(x: [T; 4]) -> [T; 4] {
    let (below, above) = (x[1] - x[0], x[2] - x[3]);
    let (left, right) = (x[3] - x[0], x[2] - x[1]);
    [(x[0] + x[1]) + (x[2] + x[3]), below + above, left + right, above - below]
}

/// Values at the corners by their parts in the four base vectors.
#[inline(always)]
pub fn at_corners<T: Real>([all, first, second, pattern]: [T; 4]) -> [T; 4] {
    let (even, odd) = (all + pattern, all - pattern);
    let (both, apart) = (first + second, first - second);
    [even - both, odd + apart, even + both, odd - apart]
}

/// Gradient operators of a quadrilateral by base vectors: of values with the [`sums`] s the integral of the derivative along r
/// is r . s\[1..4\], along z z . s\[1..4\], and of the value over r it is hoop . s\[0..3\]. In the unit [`UNIT`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Operators<T = f64> {
    /// Parts of int dN_I/dr dV in Lambda_1, Lambda_2 and Gamma, length^2.
    pub r: [T; 3],
    /// Parts of int dN_I/dz dV, length^2.
    pub z: [T; 3],
    /// Parts of int N_I/r dV in Sigma, Lambda_1 and Lambda_2, length^2.
    pub hoop: [T; 3],
    /// Volume, length^3.
    pub volume: T,
}

impl<T: Real> Operators<T> {
    /// By the [`sums`] of r and z, weighted by volume or by area. By volume they are the derivatives of the volume of the ring, the
    /// hoop part taken off along r. Area weighting (Goudreau and Hallquist 1982, Comput. Meth. Appl. Mech. Eng. 33, 725) has the
    /// gradients in the middle of the plane section times 2 pi times the radius there, so that ratios to the volume are those of
    /// the plane.
    #[inline(always)]
    pub fn of<const AREA: bool>(r: [T; 4], z: [T; 4]) -> Self {
        let section = r[1] * z[2] - r[2] * z[1];
        let (r_first, r_second) = ([r[0] * z[2], -(r[0] * z[1])], [-(r[0] * r[2]), r[0] * r[1]]);
        if AREA {
            return Operators {
                r: [r_first[0], r_first[1], T::ZERO],
                z: [r_second[0], r_second[1], T::ZERO],
                hoop: [section, T::ZERO, T::ZERO],
                volume: r[0] * section,
            };
        }
        let [_, r1, r2, r3] = r.inline_map(|x| x * T::of(1.0 / 3.0));
        let (first, second) = (r1 * z[3], r2 * z[3]);
        let hoop = [section, first - r3 * z[1], r3 * z[2] - second];
        Operators {
            r: [r_first[0] + first, r_first[1] - second, r2 * z[2] - r1 * z[1]],
            z: [r_second[0] - r1 * r[3], r_second[1] + r2 * r[3], (r1 - r2) * (r[1] + r[2])],
            hoop,
            volume: r[0] * section + (r[1] * hoop[1] + r[2] * hoop[2]),
        }
    }

    /// The hourglass pattern, free of linear fields (Flanagan and Belytschko 1981, eqs. 25 to 45), times the volume: its parts in
    /// Lambda_1, Lambda_2 and Gamma, by the last of the [`sums`] of r and of z.
    #[inline(always)]
    pub fn pattern(&self, [r, z]: [T; 2]) -> [T; 3] {
        let linear = |i: usize| r * self.r[i] + z * self.z[i];
        [-linear(0), -linear(1), self.volume - linear(2)]
    }
}

impl Operators {
    /// The operators of each corner.
    #[inline(always)]
    pub fn gradient(&self) -> Gradient {
        let [along, across, around] = [self.r, self.z, self.hoop];
        Gradient {
            r: at_corners([0.0, along[0], along[1], along[2]]),
            z: at_corners([0.0, across[0], across[1], across[2]]),
            hoop: at_corners([around[0], around[1], around[2], 0.0]),
            volume: self.volume,
        }
    }
}

/// Sum of the products of three and three numbers, in this order.
#[inline(always)]
pub fn dot3<T: Real>(a: [T; 3], b: [T; 3]) -> T {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

/// Sum over the corners of a weight, by its [`sums`], times the squares of what has these lists of parts in the base vectors.
#[inline(always)]
pub fn squares<T: Real, const N: usize>(lists: &[[T; 4]; N], weight: [T; 4]) -> T {
    let mut sums = [T::ZERO; 4];
    for [d, a, b, c] in *lists {
        sums[0] += (d * d + a * a) + (b * b + c * c);
        sums[1] += d * a + b * c;
        sums[2] += d * b + a * c;
        sums[3] += d * c + a * b;
    }
    sums[0] * weight[0] + T::of(2.0) * ((sums[1] * weight[1] + sums[2] * weight[2]) + sums[3] * weight[3])
}

/// Integrals over the volume of an element, a full ring, in the unit [`UNIT`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gradient {
    /// int dN_I/dr dV of each corner, length^2.
    pub r: [f64; 4],
    /// int dN_I/dz dV, length^2.
    pub z: [f64; 4],
    /// int N_I/r dV, length^2.
    pub hoop: [f64; 4],
    /// Volume.
    pub volume: f64,
}

/// The gradient operators of a quadrilateral.
#[inline(always)]
pub fn gradient(r: [f64; 4], z: [f64; 4]) -> Gradient {
    Operators::of::<false>(sums(r), sums(z)).gradient()
}

/// Derivatives of the volume of a ring by r and z of its corners, and the volume, in the unit [`UNIT`].
#[inline(always)]
pub fn volume_gradient(r: [f64; 4], z: [f64; 4]) -> ([f64; 4], [f64; 4], f64) {
    let Operators { r: [a, b, c], z: [d, e, f], hoop, volume } = Operators::of::<false>(sums(r), sums(z));
    (at_corners([hoop[0], a + hoop[1], b + hoop[2], c]), at_corners([0.0, d, e, f]), volume)
}

/// Area of the plane section, positive for corners that run counter-clockwise.
#[inline(always)]
pub fn section(r: [f64; 4], z: [f64; 4]) -> f64 {
    0.5 * ((r[2] - r[0]) * (z[3] - z[1]) - (r[3] - r[1]) * (z[2] - z[0]))
}

/// Stiffness of a linear elastic element with mean quadrature, and of its hourglass control: force over length, for
/// `[r, z]` of each corner in turn. With gradient operators B it is V B^T C B; hourglass stiffness as in Flanagan and
/// Belytschko 1981, eqs. 25 to 45, `hourglass` times the shear modulus.
pub fn stiffness(corners: [[f64; 2]; 4], [bulk, shear]: [f64; 2], hourglass: f64) -> [[f64; 8]; 8] {
    let (r, z) = (corners.inline_map(|c| c[0]), corners.inline_map(|c| c[1]));
    let (r, z) = (sums(r), sums(z));
    let operators = Operators::of::<false>(r, z);
    let g = operators.gradient();
    let (lame, per) = (bulk - 2.0 / 3.0 * shear, 1.0 / g.volume);
    let [first, second, pattern] = operators.pattern([r[3], z[3]]).inline_map(|part| per * part);
    let shape = at_corners([0.0, first, second, pattern]);
    let square: f64 = (0..4).map(|i| g.r[i] * g.r[i] + g.z[i] * g.z[i]).sum();
    let spring = hourglass * shear * square;
    // Strains rr, zz, hoop and twice rz that a corner's displacement along r or z makes, and the pattern.
    let column = |d: usize| {
        let i = d / 2;
        if d.is_multiple_of(2) {
            ([g.r[i], 0.0, g.hoop[i], g.z[i]], [shape[i], 0.0])
        } else {
            ([0.0, g.z[i], 0.0, g.r[i]], [0.0, shape[i]])
        }
    };
    let entry = |a: usize, b: usize| {
        let ((e, p), (f, q)) = (column(a), column(b));
        let (trace_e, trace_f) = (e[0] + e[1] + e[2], f[0] + f[1] + f[2]);
        let plain = e[0] * f[0] + e[1] * f[1] + e[2] * f[2];
        let elastic = lame * trace_e * trace_f + 2.0 * shear * plain + shear * e[3] * f[3];
        UNIT * per * (elastic + spring * (p[0] * q[0] + p[1] * q[1]))
    };
    inline_from_fn(|a| inline_from_fn(|b| entry(a, b)))
}

/// By how much the volume of an element with these corners `[r, z, v_r, v_z]` grew over an increment behind them, as the strain
/// in the middle of the increment says.
pub fn volume_change<const AREA: bool>(corners: [[f64; 4]; 4], dt: f64) -> f64 {
    dilation::<AREA>(corners, dt)[1]
}

/// The same, behind the volume in the middle of the increment.
pub fn dilation<const AREA: bool>(corners: [[f64; 4]; 4], dt: f64) -> [f64; 2] {
    let middle = |axis: usize| corners.inline_map(|c| c[axis] - 0.5 * dt * c[axis + 2]);
    let g = Operators::of::<AREA>(sums(middle(0)), sums(middle(1)));
    let ([s0, s1, s2, s3], [_, v1, v2, v3]) = (sums(corners.inline_map(|c| c[2])), sums(corners.inline_map(|c| c[3])));
    let growth = dot3(g.r, [s1, s2, s3]) + dot3(g.hoop, [s0, s1, s2]) + dot3(g.z, [v1, v2, v3]);
    [UNIT * g.volume, UNIT * dt * growth]
}

/// Volume of a full ring with these corners `[r, z]`.
pub fn volume(corners: [[f64; 2]; 4]) -> f64 {
    UNIT * gradient(corners.inline_map(|c| c[0]), corners.inline_map(|c| c[1])).volume
}

/// Row-sum lumped mass of each corner: density times int N_I dV, exact by two Gauss points each way.
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
    fn linear_fields_have_their_gradients_and_constant_fields_none() {
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
        let plane = |r, z| Operators::of::<true>(sums(r), sums(z)).gradient();
        let g = plane(R, Z);
        let dot = |a: [f64; 4], b: [f64; 4]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let flat = [dot(g.r, R) - g.volume, dot(g.z, Z) - g.volume, dot(g.hoop, R) - g.volume];
        let none = [dot(g.r, Z), dot(g.z, R), dot(g.r, [1.0; 4]), dot(g.z, [1.0; 4])];
        assert!(flat.iter().chain(&none).all(|x| x.abs() < 1e-13 * g.volume), "{flat:?} {none:?}");
        // Pappus: the ring of the middle radius.
        let square = plane([1.0, 3.0, 3.0, 1.0], [0.0, 0.0, 1.0, 1.0]);
        assert!((UNIT * square.volume - 8.0 * PI).abs() < 1e-13);
    }

    #[test]
    fn a_section_has_its_area() {
        assert!((section([1.0, 3.0, 3.0, 1.0], [0.0, 0.0, 1.5, 1.5]) - 3.0).abs() < 1e-15);
    }

    #[test]
    fn corner_masses_add_up_and_the_axis_carries_little() {
        let masses = corner_masses([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], 6.0);
        assert!((masses.iter().sum::<f64>() - 6.0 * PI).abs() < 1e-13);
        // int (1 - r) 2 pi r dr = pi/3 of pi on the axis side.
        assert!((masses[0] - PI).abs() < 1e-13 && (masses[1] - 2.0 * PI).abs() < 1e-13);
    }
}
