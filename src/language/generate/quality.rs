//! Measures of element quality: scaled Jacobian, aspect ratio, height, volume.

use std::f64::consts::PI;

use super::profile::{MeridianPoint, distance};

/// Returns the vector from corner `k` to the next corner.
fn side(corners: [MeridianPoint; 4], k: usize) -> MeridianPoint {
    let (a, b) = (corners[k], corners[(k + 1) % 4]);
    [b[0] - a[0], b[1] - a[1]]
}

/// Returns the smallest scaled Jacobian, the sine of a corner angle: 1 for a rectangle, 0 or less for a degenerate
/// element.
pub fn least_scaled_jacobian(corners: [MeridianPoint; 4]) -> f64 {
    let sine = |k: usize| {
        let (into, out) = (side(corners, (k + 3) % 4), side(corners, k));
        let square = |p: MeridianPoint| p[0] * p[0] + p[1] * p[1];
        let lengths = (square(into) * square(out)).sqrt();
        if lengths > 0.0 { (into[0] * out[1] - into[1] * out[0]) / lengths } else { 0.0 }
    };
    [0, 1, 2, 3].map(sine).into_iter().fold(f64::INFINITY, f64::min)
}

/// Returns the aspect ratio: longest over shortest side.
pub fn aspect(corners: [MeridianPoint; 4]) -> f64 {
    let lengths = [0, 1, 2, 3].map(|k| distance(corners[k], corners[(k + 1) % 4]));
    lengths.into_iter().fold(0.0, f64::max) / lengths.into_iter().fold(f64::INFINITY, f64::min)
}

/// Returns the height, area over longest side, which determines the stable time increment.
pub fn height(corners: [MeridianPoint; 4]) -> f64 {
    let [p, q, r, s] = corners;
    let area = 0.5 * ((r[0] - p[0]) * (s[1] - q[1]) - (s[0] - q[0]) * (r[1] - p[1]));
    let longest = [0, 1, 2, 3].map(|k| distance(corners[k], corners[(k + 1) % 4])).into_iter().fold(0.0, f64::max);
    area.abs() / longest
}

/// Returns the volume of revolution, exact by Green's theorem.
pub fn volume(corners: [MeridianPoint; 4]) -> f64 {
    let along = |k: usize| {
        let (a, b) = (corners[k], corners[(k + 1) % 4]);
        (b[1] - a[1]) * (a[0] * a[0] + a[0] * b[0] + b[0] * b[0])
    };
    PI / 3.0 * [0, 1, 2, 3].map(along).iter().sum::<f64>()
}
