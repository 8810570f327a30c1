//! Rings that edges sweep when nodes move, and centres of elements.

use crate::kernel::lanes::InlineMap;
use crate::kernel::quad;

/// Returns the volume of the ring that an edge sweeps when its ends move, positive if the element on its left grows,
/// and the centre of the swept ring `[r, z]`. Equation (18.4).
pub(super) fn swept(before: [[f64; 2]; 2], after: [[f64; 2]; 2]) -> (f64, [f64; 2]) {
    let ([a0, b0], [a1, b1]) = (before, after);
    let volume = quad::volume([a1, b1, b0, a0]);
    let first = share_of_first(a0[0] + a1[0], b0[0] + b1[0]);
    let middle = [0, 1].inline_map(|i| 0.5 * (first * (a0[i] + a1[i]) + (1.0 - first) * (b0[i] + b1[i])));
    (volume, middle)
}

/// Returns the share of a thin ring along an edge that belongs to its first end, for the radii of both ends.
pub(super) fn share_of_first(first: f64, second: f64) -> f64 {
    let sum = first + second;
    if sum > 0.0 { (2.0 * first + second) / (3.0 * sum) } else { 0.5 }
}

/// Returns the centre of volume of a ring with this section.
pub(super) fn centre(corners: [[f64; 2]; 4]) -> [f64; 2] {
    let base = corners[0][1];
    let (mut volume, mut along_r, mut along_z) = (0.0, 0.0, 0.0);
    for i in 0..4 {
        let ([r, z], [s, w]) = (corners[i], corners[(i + 1) % 4]);
        let (z, w) = (z - base, w - base);
        let cross = r * w - s * z;
        volume += (r + s) * cross;
        along_r += (r * r + r * s + s * s) * cross;
        along_z += (2.0 * r * z + r * w + s * z + 2.0 * s * w) * cross;
    }
    if volume == 0.0 { corners[0] } else { [0.5 * along_r / volume, base + 0.25 * along_z / volume] }
}

#[cfg(test)]
mod tests {
    use super::{centre, swept};
    use crate::kernel::quad::volume;

    const CORNERS: [[f64; 2]; 4] = [[1.0, 0.1], [3.2, -0.2], [2.9, 1.7], [0.8, 2.0]];

    /// The volume of an element changes by the rings that its edges sweep, whatever the motion.
    #[test]
    fn swept_rings_sum_to_the_change_of_volume() {
        let moved = [[1.3, 0.0], [3.0, 0.2], [3.1, 1.5], [0.9, 2.2]];
        let rings: f64 = (0..4)
            .map(|i| [i, (i + 1) % 4])
            .map(|[i, j]| swept([CORNERS[i], CORNERS[j]], [moved[i], moved[j]]).0)
            .sum();
        assert!((volume(moved) - volume(CORNERS) - rings).abs() < 1e-13 * volume(CORNERS));
    }

    /// Reference: 2D integrals over a rectangle, where the centre along r is (r² + r s + s²) 2/(3 (r + s)).
    #[test]
    fn centre_of_a_ring_is_that_of_its_volume() {
        let [r, z] = centre([[1.0, 5.0], [2.0, 5.0], [2.0, 9.0], [1.0, 9.0]]);
        assert!((r - 14.0 / 9.0).abs() < 1e-14 && (z - 7.0).abs() < 1e-14, "{r} {z}");
    }
}
