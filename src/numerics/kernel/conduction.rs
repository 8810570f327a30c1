//! Heat conduction in a four-node axisymmetric quadrilateral: its conductance matrix, and the highest eigenvalue over
//! lumped capacities. Corners run counter-clockwise in (r, z).
//!
//! Two Gauss points per direction: with one point, a checkerboard of temperatures would cause no flux.
#![allow(clippy::needless_range_loop)] // Matrices are written by their indices.

use super::lanes::InlineMap;
use std::f64::consts::PI;

/// Abscissa of two Gauss points.
const POINT: f64 = 0.577_350_269_189_625_8;

/// Returns the conductance of a full ring with these corners `[r, z]`, heat per time and temperature: `int k grad N_I .
/// grad N_J dV`. The conductivity is evaluated at the temperature of each Gauss point. Equation (9.1).
pub fn conductance(corners: [[f64; 2]; 4], temperatures: [f64; 4], conductivity: impl Fn(f64) -> f64) -> [[f64; 4]; 4] {
    let (r, z) = (corners.inline_map(|c| c[0]), corners.inline_map(|c| c[1]));
    let dot = |a: &[f64; 4], b: &[f64; 4]| (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3]);
    let mut matrix = [[0.0; 4]; 4];
    for (xi, eta) in [(-POINT, -POINT), (POINT, -POINT), (POINT, POINT), (-POINT, POINT)] {
        let [left, right, low, high] = [0.25 * (1.0 - xi), 0.25 * (1.0 + xi), 1.0 - eta, 1.0 + eta];
        let shape = [left * low, right * low, right * high, left * high];
        let along_xi = [-0.25 * low, 0.25 * low, 0.25 * high, -0.25 * high];
        let along_eta = [-left, -right, right, left];
        let (r_xi, r_eta) = (dot(&along_xi, &r), dot(&along_eta, &r));
        let (z_xi, z_eta) = (dot(&along_xi, &z), dot(&along_eta, &z));
        // Gradients times the Jacobian.
        let by_r = [0, 1, 2, 3].inline_map(|i| along_xi[i] * z_eta - along_eta[i] * z_xi);
        let by_z = [0, 1, 2, 3].inline_map(|i| along_eta[i] * r_xi - along_xi[i] * r_eta);
        let jacobian = r_xi * z_eta - r_eta * z_xi;
        let weight = conductivity(dot(&shape, &temperatures)) * 2.0 * PI * dot(&shape, &r) / jacobian;
        for i in 0..4 {
            for j in 0..=i {
                matrix[i][j] += weight * (by_r[i] * by_r[j] + by_z[i] * by_z[j]);
            }
        }
    }
    for i in 0..4 {
        for j in 0..i {
            matrix[j][i] = matrix[i][j];
        }
    }
    matrix
}

/// Returns the highest eigenvalue of a conductance over lumped capacities, 1/time, never below the exact value. Forward
/// differences are stable up to two over this rate. For a triangle the last two corners coincide. Equation (9.2).
pub fn highest_rate(conductance: &[[f64; 4]; 4], capacities: [f64; 4], triangle: bool) -> f64 {
    let (mut k, mut m) = (*conductance, capacities);
    if triangle {
        for row in &mut k {
            row[2] += row[3];
        }
        let last = k[3];
        (0..4).for_each(|j| k[2][j] += last[j]);
        m[2] += m[3];
        for i in 0..4 {
            (k[i][3], k[3][i]) = (0.0, 0.0);
        }
        m[3] = 1.0;
    }
    // Characteristic polynomial of a matrix with zero row sums: x (x³ - a x² + b x - c).
    let inverse = m.inline_map(|m| 1.0 / m);
    let a: f64 = (0..4).map(|i| k[i][i] * inverse[i]).sum();
    let mut b = 0.0;
    for i in 0..4 {
        for j in 0..i {
            b += (k[i][i] * k[j][j] - k[i][j] * k[i][j]) * (inverse[i] * inverse[j]);
        }
    }
    // All cofactors of the matrix are equal.
    let cofactor = k[0][0] * (k[1][1] * k[2][2] - k[1][2] * k[1][2])
        - k[0][1] * (k[0][1] * k[2][2] - k[1][2] * k[0][2])
        + k[0][2] * (k[0][1] * k[1][2] - k[1][1] * k[0][2]);
    let product = (inverse[0] * inverse[1]) * (inverse[2] * inverse[3]);
    let c = if triangle { 0.0 } else { cofactor * ((m[0] + m[1]) + (m[2] + m[3])) * product };
    // Three real roots; the highest is mean + 2 sqrt(p) cos(angle/3) (Viète).
    let p = (a * a - 3.0 * b) / 9.0;
    let p = if p > 0.0 { p } else { 0.0 };
    let q = (2.0 * a * a * a - 9.0 * a * b + 27.0 * c) / 54.0;
    let root = p.sqrt();
    let cosine = if p > 0.0 { q / (p * root) } else { 1.0 };
    let angle = libm::acos(cosine.clamp(-1.0, 1.0));
    // A margin for rounding, which is large near double roots.
    (a / 3.0 + 2.0 * root * libm::cos(angle / 3.0)) * (1.0 + 1e-7)
}

#[cfg(test)]
mod tests {
    use super::{conductance, highest_rate};

    const SKEWED: [[f64; 2]; 4] = [[1.0, 0.1], [3.2, -0.2], [2.9, 1.7], [0.8, 2.0]];

    fn flux(matrix: &[[f64; 4]; 4], t: [f64; 4]) -> [f64; 4] {
        [0, 1, 2, 3].map(|i| (0..4).map(|j| matrix[i][j] * t[j]).sum())
    }

    #[test]
    fn uniform_temperatures_cause_no_flux_and_a_gradient_has_its_energy() {
        let k = conductance(SKEWED, [0.0; 4], |_| 2.0);
        assert!(flux(&k, [5.0; 4]).iter().all(|q| q.abs() < 1e-12));
        let slope = SKEWED.map(|c| c[1]);
        let energy: f64 = flux(&k, slope).iter().zip(slope).map(|(q, t)| q * t).sum();
        let volume = crate::kernel::quad::volume(SKEWED);
        assert!((energy / (2.0 * volume) - 1.0).abs() < 1e-13, "{energy} {volume}");
    }

    /// Comparison with power iteration, on quadrilaterals and on a triangle.
    #[test]
    fn highest_rate_matches_the_highest_eigenvalue() {
        let triangle = [[0.0, 0.0], [1.0, 0.1], [0.2, 1.3], [0.2, 1.3]];
        let flat = [[5.0, 0.0], [9.0, 0.0], [9.0, 0.1], [5.0, 0.1]];
        let square = [[1e3, 0.0], [1001.0, 0.0], [1001.0, 1.0], [1e3, 1.0]];
        for (corners, folded) in [(SKEWED, false), (flat, false), (square, false), (triangle, true)] {
            let k = conductance(corners, [0.0; 4], |_| 1.5);
            let m = crate::kernel::quad::corner_masses(corners, 0.7);
            let mut x = [1.0, -0.7, 0.4, -0.9];
            let mut rate = 0.0;
            for _ in 0..2000 {
                let mut y = flux(&k, x);
                if folded {
                    let both = (y[2] + y[3]) / (m[2] + m[3]);
                    (y[2], y[3]) = (both * m[2], both * m[3]);
                }
                let y = [0, 1, 2, 3].map(|i| y[i] / m[i]);
                rate = y.iter().map(|y| y * y).sum::<f64>().sqrt();
                x = y.map(|y| y / rate);
            }
            let bound = highest_rate(&k, m, folded);
            assert!(bound >= rate && bound < 1.001 * rate, "{corners:?}: {bound} and {rate}");
        }
        // Squares far from the axis: 4 k/(ρ c h²), so that the stable increment is h² ρ c/(2 k).
        let k = conductance(square, [0.0; 4], |_| 1.0);
        let rate = highest_rate(&k, crate::kernel::quad::corner_masses(square, 1.0), false);
        assert!((rate / 4.0 - 1.0).abs() < 2e-3, "{rate}");
    }
}
