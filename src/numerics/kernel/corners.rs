//! Element quality and deformation: scaled Jacobian of the corners, and largest principal strain.

use super::lanes::InlineMap;

/// Returns the cross product of the two sides at a corner, and the product of their squared lengths.
#[inline(always)]
fn corner_products(at: [f64; 2], next: [f64; 2], before: [f64; 2]) -> [f64; 2] {
    let (a, b) = ([next[0] - at[0], next[1] - at[1]], [before[0] - at[0], before[1] - at[1]]);
    [a[0] * b[1] - a[1] * b[0], (a[0] * a[0] + a[1] * a[1]) * (b[0] * b[0] + b[1] * b[1])]
}

/// Returns whether the scaled Jacobian at a corner is above `least`, by a margin for rounding; `places` are those of the
/// corner, of the next and of the previous one.
#[inline(always)]
pub fn is_clear([at, next, before]: [[f64; 2]; 3], least: f64) -> bool {
    let limit = 1.0001 * least.max(0.0);
    let [cross, squares] = corner_products(at, next, before);
    (cross > 0.0) & (cross * cross > limit * limit * squares)
}

/// Returns the scaled Jacobian of an element: the smallest sine of its corner angles, for triangles divided by that of
/// the equilateral triangle. It is 1 for a rectangle, 0 if a corner is on the line between its neighbours, and negative
/// for an inverted element (P. Knupp 2000, Int. J. Numer. Meth. Eng. 48, 401). Corners run counter-clockwise;
/// coincident corners count once. NaN for fewer than three corners. Equation (12.1).
pub fn scaled_jacobian(places: [[f64; 2]; 4]) -> f64 {
    let mut corners = [[0.0; 2]; 4];
    let mut count = 0;
    for (i, place) in places.iter().enumerate() {
        if *place != places[(i + 1) % 4] {
            corners[count] = *place;
            count += 1;
        }
    }
    let best = match count {
        4 => 1.0,
        3 => 0.75_f64.sqrt(),
        _ => return f64::NAN,
    };
    let sine = |i: usize| {
        let [cross, squares] = corner_products(corners[i], corners[(i + 1) % count], corners[(i + count - 1) % count]);
        cross / squares.sqrt()
    };
    (0..count).map(sine).fold(f64::INFINITY, f64::min) / best
}

/// Returns whether the scaled Jacobian of an element is at most `least`, mostly without roots and divisions.
#[inline]
pub fn is_distorted(places: [[f64; 2]; 4], least: f64) -> bool {
    let clear = |i: usize| is_clear([places[i], places[(i + 1) % 4], places[(i + 3) % 4]], least);
    // Corners that coincide are not clear.
    !(clear(0) && clear(1) && clear(2) && clear(3)) && scaled_jacobian(places) <= least
}

/// Returns the derivatives of the coordinates with respect to those of the unit square at its centre, times 2: `[r, z]`
/// along each direction.
fn spans(places: [[f64; 2]; 4]) -> [[f64; 2]; 2] {
    let [a, b, c, d] = places;
    [0, 1].inline_map(|way| {
        [0, 1].inline_map(|i| if way == 0 { (b[i] - a[i]) + (c[i] - d[i]) } else { (d[i] - a[i]) + (c[i] - b[i]) })
    })
}

/// Returns the largest principal logarithmic strain at the centre of an element with initial corners `start`: the
/// larger of the in-plane and the hoop strain. Equation (12.2).
pub fn largest_strain(places: [[f64; 2]; 4], start: [[f64; 2]; 4]) -> f64 {
    let (now, then) = (spans(places), spans(start));
    let per = 1.0 / (then[0][0] * then[1][1] - then[0][1] * then[1][0]);
    // Columns of the deformation gradient.
    let column = |[along, across]: [f64; 2]| [0, 1].inline_map(|i| per * (now[0][i] * along + now[1][i] * across));
    let (of_r, of_z) = (column([then[1][1], -then[0][1]]), column([-then[1][0], then[0][0]]));
    let square = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
    let (rr, zz, rz) = (square(of_r, of_r), square(of_z, of_z), square(of_r, of_z));
    let half = 0.5 * (rr - zz);
    let plane = 0.5 * libm::log(0.5 * (rr + zz) + (half * half + rz * rz).sqrt());
    larger(plane, hoop(&places, &start))
}

/// Returns the largest logarithmic strain of a shell: along the meridian between two nodes, or hoop.
pub fn largest_shell_strain(places: [[f64; 2]; 2], start: [[f64; 2]; 2]) -> f64 {
    let length = |[a, b]: [[f64; 2]; 2]| {
        let along = [b[0] - a[0], b[1] - a[1]];
        (along[0] * along[0] + along[1] * along[1]).sqrt()
    };
    larger(libm::log(length(places) / length(start)), hoop(&places, &start))
}

/// Returns the logarithmic hoop strain at the mean radius of some points.
fn hoop(places: &[[f64; 2]], start: &[[f64; 2]]) -> f64 {
    let radius = |list: &[[f64; 2]]| list.iter().map(|p| p[0]).sum::<f64>();
    libm::log(radius(places) / radius(start))
}

/// Returns the larger of two numbers; NaN if the first is NaN.
fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::{is_distorted, largest_shell_strain, largest_strain, scaled_jacobian};

    const SQUARE: [[f64; 2]; 4] = [[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]];

    #[test]
    fn rectangles_and_equilateral_triangles_have_scaled_jacobian_one() {
        assert_eq!(scaled_jacobian(SQUARE), 1.0);
        assert_eq!(scaled_jacobian(SQUARE.map(|[r, z]| [r, 50.0 * z])), 1.0);
        let height = 0.75_f64.sqrt();
        for doubled in 0..4 {
            let mut corners = vec![[0.0, 0.0], [1.0, 0.0], [0.5, height]];
            corners.insert(doubled.min(2), corners[doubled.min(2)]);
            let corners = [corners[0], corners[1], corners[2], corners[3]];
            assert!((scaled_jacobian(corners) - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn inverted_elements_have_a_negative_scaled_jacobian() {
        let with = |corner: [f64; 2]| scaled_jacobian([SQUARE[0], SQUARE[1], corner, SQUARE[3]]);
        assert!(with([1.5, 0.5]).abs() < 1e-15 && with([1.4, 0.4]) < 0.0 && with([1.6, 0.6]) > 0.0);
        let turned = [[0.0, 0.0], [0.5, 1.0], [1.0, 0.0], [1.0, 0.0]];
        assert!(scaled_jacobian(turned) < 0.0);
        // Sheared by the angle whose tangent is 2.
        let sheared = SQUARE.map(|[r, z]| [r + 2.0 * z, z]);
        assert!((scaled_jacobian(sheared) - 0.2_f64.sqrt()).abs() < 1e-15);
    }

    /// Random quadrilaterals, folded ones and triangles among them, at limits of both signs and at their own values.
    #[test]
    fn distortion_limit_agrees_with_the_scaled_jacobian() {
        let mut seed = 1_u64;
        let mut noise = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) as f64 / (1_u64 << 31) as f64 - 0.5
        };
        let mut distorted = 0;
        for shape in 0..4000 {
            let mut places = SQUARE.map(|[r, z]| [r + 1.5 * noise(), z + 1.5 * noise()]);
            if shape % 5 == 0 {
                places[3] = places[2];
            }
            let jacobian = scaled_jacobian(places);
            for least in [-0.5, 0.0, 0.05, 0.4, jacobian] {
                assert_eq!(is_distorted(places, least), jacobian <= least, "{places:?} {least}");
                distorted += usize::from(jacobian <= least);
            }
        }
        assert!(distorted > 4000);
        assert!(!is_distorted([[f64::NAN; 2]; 4], 0.5));
    }

    /// Rotated, and stretched by 1.5 along one direction of the plane.
    #[test]
    fn largest_strain_is_that_of_the_largest_stretch() {
        let (cosine, sine) = (0.8, 0.6);
        let moved = SQUARE.map(|[r, z]| {
            let (along, across) = (1.5 * (r - 1.5), 0.7 * (z - 0.5));
            [1.4 + cosine * along - sine * across, sine * along + cosine * across]
        });
        assert!((largest_strain(moved, SQUARE) - 1.5_f64.ln()).abs() < 1e-14);
        let wide = SQUARE.map(|[r, z]| [r + 3.0, 0.5 * z]);
        assert!((largest_strain(wide, SQUARE) - 3.0_f64.ln()).abs() < 1e-14);
        let triangle = [SQUARE[0], SQUARE[1], SQUARE[2], SQUARE[2]];
        let longer = triangle.map(|[r, z]| [r, 2.0 * z]);
        assert!((largest_strain(longer, triangle) - 2.0_f64.ln()).abs() < 1e-14);
        assert!(
            (largest_shell_strain([[1.0, 0.0], [1.0, 3.0]], [[1.0, 0.0], [1.0, 1.0]]) - 3.0_f64.ln()).abs() < 1e-14
        );
    }
}
