//! How far an element has come from a good shape: its corners, and its largest stretch.
//! Never here: limits.

use super::lanes::InlineMap;
/// The least sine of the angles at the corners of an element over that of a rectangle, of a triangle over that of the
/// equilateral one: 1 at best, 0 where a corner lies on the line between its neighbours, below 0 once the element is folded.
/// (The scaled Jacobian of mesh generators: P. Knupp 2000, Int. J. Numer. Meth. Eng. 48, 401.) Corners run counter-clockwise; a
/// side without length is no side. Not a number where no three corners are left.
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
        let [at, next, before] = [i, (i + 1) % count, (i + count - 1) % count].inline_map(|k| corners[k]);
        let (a, b) = ([next[0] - at[0], next[1] - at[1]], [before[0] - at[0], before[1] - at[1]]);
        let squares = (a[0] * a[0] + a[1] * a[1]) * (b[0] * b[0] + b[1] * b[1]);
        (a[0] * b[1] - a[1] * b[0]) / squares.sqrt()
    };
    (0..count).map(sine).fold(f64::INFINITY, f64::min) / best
}

/// Derivatives of the coordinates by those of a square at its middle, times 4: `[r, z]` along each.
fn spans(places: [[f64; 2]; 4]) -> [[f64; 2]; 2] {
    let [a, b, c, d] = places;
    [0, 1].inline_map(|way| {
        [0, 1].inline_map(|i| if way == 0 { (b[i] - a[i]) + (c[i] - d[i]) } else { (d[i] - a[i]) + (c[i] - b[i]) })
    })
}

/// The largest principal logarithmic strain in the middle of an element that had its corners at `start`: of both directions in the
/// plane and the hoop.
pub fn largest_strain(places: [[f64; 2]; 4], start: [[f64; 2]; 4]) -> f64 {
    let (now, then) = (spans(places), spans(start));
    let per = 1.0 / (then[0][0] * then[1][1] - then[0][1] * then[1][0]);
    // Deformation gradient: what a direction at the start has become.
    let column = |[along, across]: [f64; 2]| [0, 1].inline_map(|i| per * (now[0][i] * along + now[1][i] * across));
    let (of_r, of_z) = (column([then[1][1], -then[0][1]]), column([-then[1][0], then[0][0]]));
    let square = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
    let (rr, zz, rz) = (square(of_r, of_r), square(of_z, of_z), square(of_r, of_z));
    let half = 0.5 * (rr - zz);
    let plane = 0.5 * libm::log(0.5 * (rr + zz) + (half * half + rz * rz).sqrt());
    larger(plane, hoop(&places, &start))
}

/// The same of a shell: along the meridian between two nodes, and the hoop.
pub fn largest_shell_strain(places: [[f64; 2]; 2], start: [[f64; 2]; 2]) -> f64 {
    let length = |[a, b]: [[f64; 2]; 2]| {
        let along = [b[0] - a[0], b[1] - a[1]];
        (along[0] * along[0] + along[1] * along[1]).sqrt()
    };
    larger(libm::log(length(places) / length(start)), hoop(&places, &start))
}

/// Logarithmic strain of the circle through the mean of some places.
fn hoop(places: &[[f64; 2]], start: &[[f64; 2]]) -> f64 {
    let radius = |list: &[[f64; 2]]| list.iter().map(|p| p[0]).sum::<f64>();
    libm::log(radius(places) / radius(start))
}

/// The larger of two numbers; not a number where the first is not one.
fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::{largest_shell_strain, largest_strain, scaled_jacobian};

    const SQUARE: [[f64; 2]; 4] = [[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]];

    #[test]
    fn rectangles_and_equilateral_triangles_are_best() {
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
    fn a_fold_is_below_zero() {
        let with = |corner: [f64; 2]| scaled_jacobian([SQUARE[0], SQUARE[1], corner, SQUARE[3]]);
        assert!(with([1.5, 0.5]).abs() < 1e-15 && with([1.4, 0.4]) < 0.0 && with([1.6, 0.6]) > 0.0);
        let turned = [[0.0, 0.0], [0.5, 1.0], [1.0, 0.0], [1.0, 0.0]];
        assert!(scaled_jacobian(turned) < 0.0);
        // Sheared by the angle whose tangent is 2.
        let sheared = SQUARE.map(|[r, z]| [r + 2.0 * z, z]);
        assert!((scaled_jacobian(sheared) - 0.2_f64.sqrt()).abs() < 1e-15);
    }

    /// Turned and stretched by 1.5 along one direction of the plane.
    #[test]
    fn the_largest_strain_is_that_of_the_stretch() {
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
