//! How good elements are: scaled Jacobian, aspect ratio, height, volume.

use std::f64::consts::PI;

use super::profile::{Point, distance};

/// Side `k` of corners: from corner k to the next.
fn side(corners: [Point; 4], k: usize) -> Point {
    let (a, b) = (corners[k], corners[(k + 1) % 4]);
    [b[0] - a[0], b[1] - a[1]]
}

/// The least scaled Jacobian, the sine of the corner angles: 1 in a rectangle, 0 or less in a degenerate element.
pub fn least_scaled_jacobian(corners: [Point; 4]) -> f64 {
    let sine = |k: usize| {
        let (into, out) = (side(corners, (k + 3) % 4), side(corners, k));
        let square = |p: Point| p[0] * p[0] + p[1] * p[1];
        let lengths = (square(into) * square(out)).sqrt();
        if lengths > 0.0 { (into[0] * out[1] - into[1] * out[0]) / lengths } else { 0.0 }
    };
    [0, 1, 2, 3].map(sine).into_iter().fold(f64::INFINITY, f64::min)
}

/// Longest over shortest side.
pub fn aspect(corners: [Point; 4]) -> f64 {
    let lengths = [0, 1, 2, 3].map(|k| distance(corners[k], corners[(k + 1) % 4]));
    lengths.into_iter().fold(0.0, f64::max) / lengths.into_iter().fold(f64::INFINITY, f64::min)
}

/// Area over longest side: what a wave has to cross, which bounds the stable increment.
pub fn height(corners: [Point; 4]) -> f64 {
    let [p, q, r, s] = corners;
    let area = 0.5 * ((r[0] - p[0]) * (s[1] - q[1]) - (s[0] - q[0]) * (r[1] - p[1]));
    let longest = [0, 1, 2, 3].map(|k| distance(corners[k], corners[(k + 1) % 4])).into_iter().fold(0.0, f64::max);
    area.abs() / longest
}

/// Volume of the ring that an element sweeps about the axis, exact by Green's theorem.
pub fn volume(corners: [Point; 4]) -> f64 {
    let along = |k: usize| {
        let (a, b) = (corners[k], corners[(k + 1) % 4]);
        (b[1] - a[1]) * (a[0] * a[0] + a[0] * b[0] + b[0] * b[0])
    };
    PI / 3.0 * [0, 1, 2, 3].map(along).iter().sum::<f64>()
}
