//! A frame's mesh with few enough cells to draw: points that share a square of a grid become one (vertex clustering,
//! Rossignac and Borrel 1993), cells that collapse are dropped. No gaps open, and it is done once for all frames.

use std::collections::HashMap;

/// What is drawn of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DrawnMesh {
    /// Points of the mesh that are drawn.
    pub points: Vec<usize>,
    /// Corners of each cell as indices into `points`.
    pub corners: Vec<Vec<usize>>,
    /// The cell of the mesh that each stands for.
    pub cells: Vec<usize>,
}

/// The whole mesh if it has no more than `most` cells, else a coarser one.
pub fn drawn(points: &[[f64; 2]], cells: &[Vec<usize>], most: usize) -> DrawnMesh {
    let whole: Vec<usize> = (0..points.len()).collect();
    let mut drawn = clustered(&whole, cells);
    let [low, high] = bounds(points);
    let extent = f64::max(high[0] - low[0], high[1] - low[1]);
    // Squares that a mesh of `most` cells would have if it filled the box; smaller boxes follow until it fits.
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

/// The smallest and the largest of each coordinate.
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

/// Cells over the leaders of their corners; what collapses to fewer than a triangle, or a line to a point, is dropped.
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
        let place = |p: usize| {
            *number.entry(p).or_insert_with(|| {
                drawn.points.push(p);
                drawn.points.len() - 1
            })
        };
        drawn.corners.push(corners.into_iter().map(place).collect());
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
    fn a_small_mesh_is_drawn_as_it_is() {
        let (points, cells) = square(5);
        let drawn = drawn(&points, &cells, 100);
        assert_eq!(drawn.cells.len(), 25);
        assert_eq!(drawn.points.len(), 36);
    }

    #[test]
    fn a_large_mesh_gets_coarser_and_covers_nearly_the_same_area() {
        let (points, cells) = square(200);
        let drawn = drawn(&points, &cells, 3000);
        assert!((300..=3000).contains(&drawn.cells.len()), "{}", drawn.cells.len());
        let place = |p: usize| points[drawn.points[p]];
        let area = |corners: &Vec<usize>| {
            let shifted = corners.iter().skip(1).chain(corners.first());
            let cross = |(&a, &b): (&usize, &usize)| place(a)[0] * place(b)[1] - place(b)[0] * place(a)[1];
            0.5 * corners.iter().zip(shifted).map(cross).sum::<f64>()
        };
        let sum: f64 = drawn.corners.iter().map(area).sum();
        // Up to one square of the grid may be lost along two of the four sides.
        assert!((0.85..=1.0).contains(&(sum / 40_000.0)), "{sum}");
    }
}
