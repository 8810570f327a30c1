//! The four-node axisymmetric quadrilateral with mean quadrature (CAX4R): volume, gradient operators, corner masses.
//! Corners run counter-clockwise in (r, z). Never here: stress, meshes.
//!
//! Mean quadrature integrates the gradient operators over the volume exactly (Flanagan and Belytschko 1981, Int. J. Numer.
//! Meth. Eng. 17, eqs. 13 to 21, carried over to the axisymmetric volume): with V = 2 pi int r dA, the operator along z is
//! dV/dz_I, and along r dV/dr_I less the hoop part 2 pi int N_I dA. Centroid quadrature would be wrong on the axis.

use std::f64::consts::PI;

/// Factor of all integrals in [`Gradient`]: most uses are ratios, in which it drops out.
pub const UNIT: f64 = PI / 3.0;

/// Integrals over the volume of an element, a full ring, in units of pi/3.
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
    // Triangles at the corners: twice their areas, with T1 + T3 = T2 + T4 = 2 A.
    let (r21, z21) = (r[1] - r[0], z[1] - z[0]);
    let (r31, z31) = (r[2] - r[0], z[2] - z[0]);
    let (r41, z41) = (r[3] - r[0], z[3] - z[0]);
    let t1 = r21 * z41 - r41 * z21;
    let t2 = r21 * z31 - r31 * z21;
    let t4 = r31 * z41 - r41 * z31;
    let double = t2 + t4;
    // int N_I dA = (A + T_I)/6 with plain areas.
    let hoop = [double + t1, double + t2, double + double - t1, double + t4].map(|t| 0.5 * t);
    let mut out_r = [0.0; 4];
    let mut out_z = [0.0; 4];
    let mut moment = 0.0;
    for i in 0..4 {
        let (j, p) = ((i + 1) % 4, (i + 3) % 4);
        let next = r[i] + r[j];
        let before = r[p] + r[i];
        out_z[i] = r[p] * before - r[j] * next;
        // dV/dr_I is pi/3 times 2 r_I (z_J - z_P) + r_J (z_J - z_I) + r_P (z_I - z_P).
        let by_r = (r[i] + next) * (z[j] - z[i]) + (r[i] + before) * (z[i] - z[p]);
        moment += r[i] * by_r;
        out_r[i] = by_r - hoop[i];
    }
    // V is of second degree in r.
    Gradient { r: out_r, z: out_z, hoop, volume: 0.5 * moment }
}

/// Derivatives of the volume of a ring by r and z of its corners, and the volume, in units of pi/3.
#[inline(always)]
pub fn volume_gradient(r: [f64; 4], z: [f64; 4]) -> ([f64; 4], [f64; 4], f64) {
    let (mut by_r, mut by_z, mut moment) = ([0.0; 4], [0.0; 4], 0.0);
    for i in 0..4 {
        let (j, p) = ((i + 1) % 4, (i + 3) % 4);
        let (next, before) = (r[i] + r[j], r[p] + r[i]);
        by_r[i] = (r[i] + next) * (z[j] - z[i]) + (r[i] + before) * (z[i] - z[p]);
        by_z[i] = r[p] * before - r[j] * next;
        moment += r[i] * by_r[i];
    }
    (by_r, by_z, 0.5 * moment)
}

/// Area of the plane section, positive for corners that run counter-clockwise.
#[inline(always)]
pub fn section(r: [f64; 4], z: [f64; 4]) -> f64 {
    0.5 * ((r[2] - r[0]) * (z[3] - z[1]) - (r[3] - r[1]) * (z[2] - z[0]))
}

/// Operators of area weighting (Goudreau and Hallquist 1982, Comput. Meth. Appl. Mech. Eng. 33, 725): gradients in the
/// middle of the plane section times 2 pi times the radius there, so that ratios to the volume are those of the plane.
#[inline(always)]
pub fn plane_gradient(r: [f64; 4], z: [f64; 4]) -> Gradient {
    let ring = 6.0 * 0.25 * ((r[0] + r[1]) + (r[2] + r[3]));
    let area = section(r, z);
    let (a, b) = (0.5 * ring * (z[1] - z[3]), 0.5 * ring * (z[2] - z[0]));
    let (c, d) = (0.5 * ring * (r[3] - r[1]), 0.5 * ring * (r[0] - r[2]));
    Gradient { r: [a, b, -a, -b], z: [c, d, -c, -d], hoop: [1.5 * area; 4], volume: ring * area }
}

/// The operators of an element, weighted by volume or by area.
#[inline(always)]
pub fn operators<const AREA: bool>(r: [f64; 4], z: [f64; 4]) -> Gradient {
    if AREA { plane_gradient(r, z) } else { gradient(r, z) }
}

/// Stiffness of a linear elastic element with mean quadrature, and of its hourglass control: force over length, for
/// `[r, z]` of each corner in turn. With gradient operators B it is V B^T C B; hourglass stiffness as in Flanagan and
/// Belytschko 1981, eqs. 25 to 45, `hourglass` times the shear modulus.
pub fn stiffness(corners: [[f64; 2]; 4], [bulk, shear]: [f64; 2], hourglass: f64) -> [[f64; 8]; 8] {
    let (r, z) = (corners.map(|c| c[0]), corners.map(|c| c[1]));
    let g = gradient(r, z);
    let (lame, per) = (bulk - 2.0 / 3.0 * shear, 1.0 / g.volume);
    let slope = |x: [f64; 4]| per * ((x[0] - x[1]) + (x[2] - x[3]));
    let (h_r, h_z) = (slope(r), slope(z));
    let signs = [1.0, -1.0, 1.0, -1.0];
    let shape = [0, 1, 2, 3].map(|i: usize| signs[i] - h_r * g.r[i] - h_z * g.z[i]);
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
    std::array::from_fn(|a| std::array::from_fn(|b| entry(a, b)))
}

/// By how much the volume of an element with these corners `[r, z, v_r, v_z]` grew over an increment behind them, as the strain
/// in the middle of the increment says.
pub fn volume_change<const AREA: bool>(corners: [[f64; 4]; 4], dt: f64) -> f64 {
    dilation::<AREA>(corners, dt)[1]
}

/// The same, behind the volume in the middle of the increment.
pub fn dilation<const AREA: bool>(corners: [[f64; 4]; 4], dt: f64) -> [f64; 2] {
    let middle = |axis: usize| corners.map(|c| c[axis] - 0.5 * dt * c[axis + 2]);
    let (g, v_r, v_z) = (operators::<AREA>(middle(0), middle(1)), corners.map(|c| c[2]), corners.map(|c| c[3]));
    let growth = UNIT * dt * (0..4).map(|i| (g.r[i] + g.hoop[i]) * v_r[i] + g.z[i] * v_z[i]).sum::<f64>();
    [UNIT * g.volume, growth]
}

/// Volume of a full ring with these corners `[r, z]`.
pub fn volume(corners: [[f64; 2]; 4]) -> f64 {
    UNIT * gradient(corners.map(|c| c[0]), corners.map(|c| c[1])).volume
}

/// Row-sum lumped mass of each corner: density times int N_I dV, exact by two Gauss points each way.
pub fn corner_masses(corners: [[f64; 2]; 4], density: f64) -> [f64; 4] {
    let (r, z) = (corners.map(|c| c[0]), corners.map(|c| c[1]));
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
        let g = plane_gradient(R, Z);
        let dot = |a: [f64; 4], b: [f64; 4]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let flat = [dot(g.r, R) - g.volume, dot(g.z, Z) - g.volume, dot(g.hoop, R) - g.volume];
        let none = [dot(g.r, Z), dot(g.z, R), dot(g.r, [1.0; 4]), dot(g.z, [1.0; 4])];
        assert!(flat.iter().chain(&none).all(|x| x.abs() < 1e-13 * g.volume), "{flat:?} {none:?}");
        // Pappus: the ring of the middle radius.
        let square = plane_gradient([1.0, 3.0, 3.0, 1.0], [0.0, 0.0, 1.0, 1.0]);
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
