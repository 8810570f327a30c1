//! Solid elements as rings: their corner polygon rotated about the axis.

use super::lanes::InlineMap;
use std::f64::consts::PI;

/// Returns the mean of the corners `[r, z]`: the integration point of an element with reduced integration.
pub fn centre(corners: &[[f64; 2]]) -> [f64; 2] {
    let sum = corners.iter().fold([0.0; 2], |sum, c| [sum[0] + c[0], sum[1] + c[1]]);
    sum.inline_map(|s| s / corners.len() as f64)
}

/// Returns the volume of the ring, positive for corners that run counter-clockwise in (r, z). By Pappus's theorem with
/// the polygon's moment about the axis: 2π/6 times the sum of (r1 z2 - r2 z1)(r1 + r2).
pub fn volume(corners: &[[f64; 2]]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    let moment: f64 = corners.iter().zip(next).map(|(a, b)| (a[0] * b[1] - b[0] * a[1]) * (a[0] + b[0])).sum();
    PI / 3.0 * moment
}

#[cfg(test)]
mod tests {
    use super::{PI, centre, volume};

    #[test]
    fn volume_and_centre_of_a_rectangular_ring_are_exact() {
        let corners = [[1.0, 0.0], [3.0, 0.0], [3.0, 0.5], [1.0, 0.5]];
        assert!((volume(&corners) - PI * (9.0 - 1.0) * 0.5).abs() < 1e-14);
        assert_eq!(centre(&corners), [2.0, 0.25]);
    }
}
