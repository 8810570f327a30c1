//! Strains that vary across a quadrilateral, as an assumed field has them that locks neither in shear nor in volume: along one
//! direction of the element, linear across it, with the hoop strain that varies beside it (assumed strain by direction as in
//! Belytschko and Bindeman 1991, Comput. Meth. Appl. Mech. Eng. 88, 311, carried over to the ring: without the hoop part a
//! plate bends against E instead of E/(1 - nu^2)).
//! Never here: stress, what flows.

use super::quad::{Gradient, UNIT, gradient, section};

/// How much of the square of the longer side the shorter counts at least: an element pressed flat has no more stiffness.
const FLAT: f64 = 1e-4;

/// One of the two fields: strains at the edge of the element, of which the mean square is a third.
#[derive(Clone, Copy, Debug)]
pub struct Pattern {
    /// Direction of the strain, half a side, `[r, z]`.
    pub side: [f64; 2],
    /// One over the square of its length.
    pub per: f64,
    /// Hoop strain by the displacement of each corner along r.
    pub hoop: [f64; 4],
}

impl Pattern {
    /// Strain along the direction by the pattern's displacement `[r, z]`.
    #[inline(always)]
    pub fn strain(&self, [q_r, q_z]: [f64; 2]) -> f64 {
        0.25 * self.per * (self.side[0] * q_r + self.side[1] * q_z)
    }
}

/// Half the side between the middles of the edges 4-1 and 2-3, and of 1-2 and 3-4.
#[inline(always)]
fn sides(x: [f64; 4]) -> [f64; 2] {
    [0.25 * ((x[1] - x[0]) + (x[2] - x[3])), 0.25 * ((x[3] - x[0]) + (x[2] - x[1]))]
}

/// Hoop strains by displacements along r that differ across the element along a direction.
#[inline(always)]
fn hoop(per: f64, [across_r, across_z]: [f64; 2], g: &Gradient) -> [f64; 4] {
    let (r, z) = (per * across_r, per * across_z);
    [
        (g.r[0] - g.hoop[0]) * r + g.z[0] * z,
        (g.r[1] - g.hoop[1]) * r + g.z[1] * z,
        (g.r[2] - g.hoop[2]) * r + g.z[2] * z,
        (g.r[3] - g.hoop[3]) * r + g.z[3] * z,
    ]
}

/// The field along the first direction of the element and linear across it, and the same with the directions swapped.
#[inline(always)]
pub fn patterns(r: [f64; 4], z: [f64; 4], g: &Gradient) -> [Pattern; 2] {
    let ([a_r, c_r], [a_z, c_z]) = (sides(r), sides(z));
    let (aa, cc) = (a_r * a_r + a_z * a_z, c_r * c_r + c_z * c_z);
    let (least_a, least_c) = (FLAT * cc, FLAT * aa);
    let (aa, cc) = (if aa > least_a { aa } else { least_a }, if cc > least_c { cc } else { least_c });
    // With the mean radius V/(2 pi A): grad (v_r/r) = (grad v_r - v_r/r)/r. One division serves both squares.
    let per = 6.0 * section(r, z) / (g.volume * g.volume);
    let both = 1.0 / (aa * cc);
    let (per_a, per_c) = (cc * both, aa * both);
    let (a, c) = ([a_r, a_z], [c_r, c_z]);
    [Pattern { side: a, per: per_a, hoop: hoop(per, c, g) }, Pattern { side: c, per: per_c, hoop: hoop(per, a, g) }]
}

/// The hourglass pattern of an element, free of linear fields (Flanagan and Belytschko 1981, eqs. 25 to 45).
#[inline(always)]
pub fn shape(r: [f64; 4], z: [f64; 4], g: &Gradient) -> [f64; 4] {
    let per = 1.0 / g.volume;
    let (h_r, h_z) = (per * ((r[0] - r[1]) + (r[2] - r[3])), per * ((z[0] - z[1]) + (z[2] - z[3])));
    [
        1.0 - (h_r * g.r[0] + h_z * g.z[0]),
        -1.0 - (h_r * g.r[1] + h_z * g.z[1]),
        1.0 - (h_r * g.r[2] + h_z * g.z[2]),
        -1.0 - (h_r * g.r[3] + h_z * g.z[3]),
    ]
}

/// Plane stress moduli E/(1 - nu^2), and nu times it, by bulk and shear modulus.
#[inline(always)]
pub fn moduli(bulk: f64, shear: f64) -> [f64; 2] {
    let per = 2.0 * shear / (3.0 * bulk + 4.0 * shear);
    [2.0 * per * (3.0 * bulk + shear), per * (3.0 * bulk - 2.0 * shear)]
}

/// Stiffness that the two fields give an element: force over length, for `[r, z]` of each corner in turn.
pub fn stiffness(corners: [[f64; 2]; 4], [bulk, shear]: [f64; 2]) -> [[f64; 8]; 8] {
    let (r, z) = (corners.map(|c| c[0]), corners.map(|c| c[1]));
    let g = gradient(r, z);
    let shape = shape(r, z, &g);
    let [along, beside] = moduli(bulk, shear);
    let third = UNIT * g.volume / 3.0;
    let mut matrix = [[0.0; 8]; 8];
    for pattern in patterns(r, z, &g) {
        let column = |d: usize| {
            let (i, axis) = (d / 2, d % 2);
            let hoop = if axis == 0 { pattern.hoop[i] } else { 0.0 };
            [0.25 * pattern.per * pattern.side[axis] * shape[i], hoop]
        };
        for (a, row) in matrix.iter_mut().enumerate() {
            let [e, h] = column(a);
            for (b, entry) in row.iter_mut().enumerate() {
                let [f, k] = column(b);
                *entry += third * (along * (e * f + h * k) + beside * (e * k + h * f));
            }
        }
    }
    matrix
}

#[cfg(test)]
mod tests {
    use super::{gradient, moduli, patterns, shape, stiffness};

    /// A thin ring far from the axis bends as a plate strip: E/(1 - nu^2) times its section modulus, whatever its aspect.
    #[test]
    fn a_strip_far_from_the_axis_bends_as_a_plate() {
        let (bulk, shear) = (2.0, 0.9);
        let far = 1e6;
        for [long, high] in [[1.0, 1.0], [8.0, 1.0], [0.1, 1.0]] {
            let corners = [[far, 0.0], [far + long, 0.0], [far + long, high], [far, high]];
            let matrix = stiffness(corners, [bulk, shear]);
            // Ends turn against each other by the angle 1: u = -+ 1/2 of the height at the corners.
            let bent = [-0.25 * high, 0.0, 0.25 * high, 0.0, -0.25 * high, 0.0, 0.25 * high, 0.0];
            let energy: f64 = (0..8).map(|a| (0..8).map(|b| bent[a] * matrix[a][b] * bent[b]).sum::<f64>()).sum();
            let around = 2.0 * std::f64::consts::PI * (far + 0.5 * long);
            let exact = moduli(bulk, shear)[0] * high.powi(3) / 12.0 / long * around;
            // The angle is high/2 over high/2, on both sides: 1 in all.
            let angle: f64 = 1.0;
            assert!((energy / (exact * angle * angle) - 1.0).abs() < 1e-5, "{long} {high}: {energy} {exact}");
        }
    }

    /// Rigid motion along z, and growth of all radii alike, make neither strain.
    #[test]
    fn uniform_strain_is_not_seen() {
        let (r, z) = ([1.0, 3.2, 2.9, 0.8], [0.1, -0.2, 1.7, 2.0]);
        let g = gradient(r, z);
        let shape = shape(r, z, &g);
        for pattern in patterns(r, z, &g) {
            let dot = |a: [f64; 4], b: [f64; 4]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
            assert!(dot(pattern.hoop, r).abs() < 1e-12);
            assert!(pattern.strain([dot(shape, r), dot(shape, z)]).abs() < 1e-12);
            assert!(dot(shape, [1.0; 4]).abs() < 1e-12);
        }
    }
}
