//! Coarsening of a mesh for drawing by vertex clustering (Rossignac and Borrel 1993): points in the same square of a
//! grid are merged, and collapsed cells are dropped. No gaps appear. It is done once for all frames of a mesh.

use std::collections::HashMap;

/// Largest number of cells that are drawn.
pub const CELLS: usize = 6000;

/// Part of a mesh that is drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DrawnMesh {
    /// Indices of the drawn points in the mesh.
    pub points: Vec<usize>,
    /// Corners of each cell as indices into `points`.
    pub corners: Vec<Vec<usize>>,
    /// Index of each drawn cell in the mesh.
    pub cells: Vec<usize>,
}

/// Returns the whole mesh if it has at most `most` cells, otherwise a coarser one.
pub fn drawn(points: &[[f64; 2]], cells: &[Vec<usize>], most: usize) -> DrawnMesh {
    let whole: Vec<usize> = (0..points.len()).collect();
    let mut drawn = clustered(&whole, cells);
    let [low, high] = bounds(points);
    let extent = f64::max(high[0] - low[0], high[1] - low[1]);
    // Start with a quarter of the area of `most` cells that fill the bounding box; enlarge the squares until the mesh
    // fits.
    let mut size = (0.25 * (high[0] - low[0]) * (high[1] - low[1]) / most as f64).sqrt().max(1e-4 * extent);
    while drawn.corners.len() > most && size < extent {
        let square = |p: &[f64; 2]| [0, 1].map(|i| ((p[i] - low[i]) / size).floor() as i64);
        let mut first: HashMap<[i64; 2], usize> = HashMap::new();
        let leader: Vec<usize> = points.iter().enumerate().map(|(i, p)| *first.entry(square(p)).or_insert(i)).collect();
        drawn = clustered(&leader, cells);
        size *= 1.25;
    }
    drawn
}

/// Returns the smallest and largest value of each coordinate.
pub fn bounds(points: &[[f64; 2]]) -> [[f64; 2]; 2] {
    let mut bounds = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    for point in points.iter().filter(|p| p[0].is_finite() && p[1].is_finite()) {
        for i in 0..2 {
            bounds[0][i] = bounds[0][i].min(point[i]);
            bounds[1][i] = bounds[1][i].max(point[i]);
        }
    }
    bounds
}

/// Replaces the corners of cells by their cluster points; drops areas with fewer than three corners and lines with
/// fewer than two.
fn clustered(leader: &[usize], cells: &[Vec<usize>]) -> DrawnMesh {
    let mut drawn = DrawnMesh::default();
    let mut number: HashMap<usize, usize> = HashMap::new();
    for (index, cell) in cells.iter().enumerate() {
        let mut corners: Vec<usize> = cell.iter().map(|&p| leader[p]).collect();
        corners.dedup();
        if corners.len() > 1 && corners.first() == corners.last() {
            corners.pop();
        }
        if corners.len() < cell.len().min(3) || corners.len() > 6 || cell.len() < 2 {
            continue;
        }
        let drawn_index = |p: usize| {
            *number.entry(p).or_insert_with(|| {
                drawn.points.push(p);
                drawn.points.len() - 1
            })
        };
        drawn.corners.push(corners.into_iter().map(drawn_index).collect());
        drawn.cells.push(index);
    }
    drawn
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(n: usize) -> (Vec<[f64; 2]>, Vec<Vec<usize>>) {
        let points = (0..=n).flat_map(|j| (0..=n).map(move |i| [i as f64, j as f64])).collect();
        let cell = |i: usize, j: usize| {
            let a = i + j * (n + 1);
            vec![a, a + 1, a + n + 2, a + n + 1]
        };
        (points, (0..n).flat_map(|j| (0..n).map(move |i| cell(i, j))).collect())
    }

    #[test]
    fn small_mesh_is_unchanged() {
        let (points, cells) = square(5);
        let drawn = drawn(&points, &cells, 100);
        assert_eq!(drawn.cells.len(), 25);
        assert_eq!(drawn.points.len(), 36);
    }

    #[test]
    fn large_mesh_is_coarsened_with_nearly_the_same_area() {
        let (points, cells) = square(200);
        let drawn = drawn(&points, &cells, 3000);
        assert!((300..=3000).contains(&drawn.cells.len()), "{}", drawn.cells.len());
        let point_of = |p: usize| points[drawn.points[p]];
        let area = |corners: &Vec<usize>| {
            let shifted = corners.iter().skip(1).chain(corners.first());
            let cross = |(&a, &b): (&usize, &usize)| point_of(a)[0] * point_of(b)[1] - point_of(b)[0] * point_of(a)[1];
            0.5 * corners.iter().zip(shifted).map(cross).sum::<f64>()
        };
        let sum: f64 = drawn.corners.iter().map(area).sum();
        // Up to one grid square may be lost along two of the four sides.
        assert!((0.85..=1.0).contains(&(sum / 40_000.0)), "{sum}");
    }
}
