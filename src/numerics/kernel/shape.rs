//! Shape of elements with four corners in the (r, z) plane, or three, of which the last is given twice: angles, flat
//! corners, division into triangles.

use super::lanes::InlineMap;
use super::quad;

/// Sum of the squares of the sides of an equilateral triangle over its area.
const FOUR_ROOT_THREE: f64 = 6.928_203_230_275_509;

/// Returns the area of the smallest corner triangle over half the area of the element, 1 for a parallelogram; for a
/// triangle 4 √3 times its area over the sum of the squares of its sides, 1 if they are equal. Negative for elements that
/// overlap.
pub fn corner_shape(corners: &[u32; 4], places: &[[f64; 2]]) -> f64 {
    let positions = corners.inline_map(|n| places[n as usize]);
    let area = quad::section(positions.inline_map(|c| c[0]), positions.inline_map(|c| c[1]));
    if area <= 0.0 {
        return -1.0;
    }
    if is_triangle(corners) {
        let sides = squared_distance(positions[0], positions[1])
            + squared_distance(positions[1], positions[2])
            + squared_distance(positions[2], positions[0]);
        return FOUR_ROOT_THREE * area / sides;
    }
    let smallest = |a: f64, b: f64| if b < a { b } else { a };
    let twice = |list: &[usize; 3]| {
        let [a, b, c] = list.inline_map(|i| positions[i]);
        twice_area([b, c, a])
    };
    corner_lists(corners).iter().map(twice).fold(f64::INFINITY, smallest) / area
}

/// Returns the smallest angle of an element, radians.
pub fn smallest_angle(corners: &[u32; 4], place: impl Fn(u32) -> [f64; 2]) -> f64 {
    let positions = corners.inline_map(&place);
    let angle = |list: &[usize; 3]| {
        let [a, b, c] = list.inline_map(|i| positions[i]);
        let ([p, q], [s, t]) = ([c[0] - b[0], c[1] - b[1]], [a[0] - b[0], a[1] - b[1]]);
        let angle = libm::atan2(p * t - q * s, p * s + q * t);
        if angle < 0.0 { angle + 2.0 * std::f64::consts::PI } else { angle }
    };
    corner_lists(corners).iter().map(angle).fold(f64::INFINITY, f64::min)
}

/// Returns the smallest sine of the angles of an element; negative if it is not convex.
pub fn smallest_sine(corners: &[u32; 4], place: impl Fn(u32) -> [f64; 2]) -> f64 {
    let positions = corners.inline_map(place);
    let sine = |list: &[usize; 3]| {
        let [a, b, c] = list.inline_map(|i| positions[i]);
        twice_area([b, c, a]) / (distance(a, b) * distance(b, c))
    };
    corner_lists(corners).iter().map(sine).fold(1.0, f64::min)
}

/// Returns whether a quadrilateral is convex, and the squares of the sines of its angles are all above a limit; false for
/// triangles.
pub fn has_larger_sines(corners: &[u32; 4], place: impl Fn(u32) -> [f64; 2], square: f64) -> bool {
    let [a, b, c, d] = corners.inline_map(place);
    let sides = [(a, b), (b, c), (c, d), (d, a)].inline_map(|(from, to)| [to[0] - from[0], to[1] - from[1]]);
    let squares = sides.inline_map(|[r, z]| r * r + z * z);
    let is_larger = |i: usize, k: usize| {
        let twice = sides[i][0] * sides[k][1] - sides[i][1] * sides[k][0];
        twice > 0.0 && twice * twice > square * (squares[i] * squares[k])
    };
    is_larger(0, 1) & is_larger(1, 2) & is_larger(2, 3) & is_larger(3, 0)
}

/// Returns whether an element with these corners is a triangle.
pub fn is_triangle(corners: &[u32; 4]) -> bool {
    corners[2] == corners[3]
}

/// Returns a triangle as an element with four corners. The last one is opposite the longest side: the bound of the stable
/// time increment takes the other sides.
pub fn triangle(corners: [u32; 3], place: impl Fn(u32) -> [f64; 2]) -> [u32; 4] {
    let side = |i: usize| distance(place(corners[i]), place(corners[(i + 1) % 3]));
    let longest = (0..3).max_by(|i, k| side(*i).total_cmp(&side(*k))).unwrap_or_default();
    let [a, b, c] = [0, 1, 2].inline_map(|i: usize| corners[(longest + i) % 3]);
    [a, b, c, c]
}

/// Returns the elements at each of `count` nodes.
pub fn elements_around(corners: &[[u32; 4]], count: usize) -> Vec<Vec<u32>> {
    let mut around = vec![Vec::new(); count];
    for (e, corners) in corners.iter().enumerate() {
        let count = if is_triangle(corners) { 3 } else { 4 };
        corners[..count].iter().for_each(|n| around[*n as usize].push(e as u32));
    }
    around
}

/// Returns twice the area of a triangle, positive for corners that run counter-clockwise.
pub fn twice_area([a, b, c]: [[f64; 2]; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Returns the area of a quadrilateral, positive for corners that run counter-clockwise.
pub fn quad_area([a, b, c, d]: [[f64; 2]; 4]) -> f64 {
    0.5 * (twice_area([a, b, c]) + twice_area([a, c, d]))
}

/// Returns the distance from the first of two ends to the point between both that is nearest to a place, as a fraction of the
/// distance between the ends; 0 if the ends are the same point.
pub fn share_between([from, to]: [[f64; 2]; 2], place: [f64; 2]) -> f64 {
    let [whole, own] = [to, place].inline_map(|to| [to[0] - from[0], to[1] - from[1]]);
    let square = whole[0] * whole[0] + whole[1] * whole[1];
    if square > 0.0 { ((own[0] * whole[0] + own[1] * whole[1]) / square).clamp(0.0, 1.0) } else { 0.0 }
}

/// Returns the distance between two points.
pub fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    squared_distance(a, b).sqrt()
}

fn squared_distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (b[0] - a[0]) + (b[1] - a[1]) * (b[1] - a[1])
}

/// Returns the mean of the corners.
pub fn middle(at: [[f64; 2]; 4]) -> [f64; 2] {
    [0, 1].inline_map(|i: usize| 0.25 * ((at[0][i] + at[1][i]) + (at[2][i] + at[3][i])))
}

/// Returns the corners of two triangles of positive area that make up a quadrilateral, also if one of its angles exceeds
/// 180 degrees.
pub fn halves(at: [[f64; 2]; 4]) -> [[usize; 3]; 2] {
    let twice = |list: [usize; 3]| twice_area(list.inline_map(|i| at[i]));
    let (first, second) = ([[0, 1, 2], [0, 2, 3]], [[0, 1, 3], [1, 2, 3]]);
    let smallest = |pair: [[usize; 3]; 2]| twice(pair[0]).min(twice(pair[1]));
    if smallest(second) > smallest(first) { second } else { first }
}

/// Returns the corners before, at and after each angle of an element.
fn corner_lists(corners: &[u32; 4]) -> &'static [[usize; 3]] {
    if is_triangle(corners) {
        &[[2, 0, 1], [0, 1, 2], [1, 2, 0]]
    } else {
        &[[3, 0, 1], [0, 1, 2], [1, 2, 3], [2, 3, 0]]
    }
}
