//! Shape of elements: flat corners and angles.

use super::topology::is_triangle;
use crate::kernel::lanes::InlineMap;
use crate::kernel::quad;

/// Sum of the squares of the sides of an equilateral triangle over its area.
const FOUR_ROOT_THREE: f64 = 6.928_203_230_275_509;

/// Returns the area of the smallest corner triangle over half the area of the element, 1 for a parallelogram; for a
/// triangle 4 √3 times its area over the sum of the squares of its sides, 1 if they are equal. Negative for elements that
/// overlap.
pub(super) fn corner_shape(corners: &[u32; 4], places: &[[f64; 2]]) -> f64 {
    let at = corners.inline_map(|n| places[n as usize]);
    let area = quad::section(at.inline_map(|c| c[0]), at.inline_map(|c| c[1]));
    if area <= 0.0 {
        return -1.0;
    }
    if is_triangle(corners) {
        let square = |a: [f64; 2], b: [f64; 2]| (b[0] - a[0]) * (b[0] - a[0]) + (b[1] - a[1]) * (b[1] - a[1]);
        let sides = square(at[0], at[1]) + square(at[1], at[2]) + square(at[2], at[0]);
        return FOUR_ROOT_THREE * area / sides;
    }
    let smallest = |a: f64, b: f64| if b < a { b } else { a };
    let twice = |list: &[usize; 3]| {
        let [a, b, c] = list.inline_map(|i| at[i]);
        (c[0] - b[0]) * (a[1] - b[1]) - (c[1] - b[1]) * (a[0] - b[0])
    };
    corner_lists(corners).iter().map(twice).fold(f64::INFINITY, smallest) / area
}

/// Returns the smallest angle of an element, radians.
pub(super) fn smallest_angle(corners: &[u32; 4], place: impl Fn(u32) -> [f64; 2]) -> f64 {
    let at = corners.inline_map(&place);
    let angle = |list: &[usize; 3]| {
        let [a, b, c] = list.inline_map(|i| at[i]);
        let ([p, q], [s, t]) = ([c[0] - b[0], c[1] - b[1]], [a[0] - b[0], a[1] - b[1]]);
        let angle = libm::atan2(p * t - q * s, p * s + q * t);
        if angle < 0.0 { angle + 2.0 * std::f64::consts::PI } else { angle }
    };
    corner_lists(corners).iter().map(angle).fold(f64::INFINITY, f64::min)
}

/// Returns the corners before, at and after each angle of an element.
fn corner_lists(corners: &[u32; 4]) -> &'static [[usize; 3]] {
    if is_triangle(corners) {
        &[[2, 0, 1], [0, 1, 2], [1, 2, 0]]
    } else {
        &[[3, 0, 1], [0, 1, 2], [1, 2, 3], [2, 3, 0]]
    }
}
