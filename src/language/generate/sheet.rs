//! A quadrilateral mesh in the meridian plane under construction: nodes, structured blocks, elements.

use super::profile::MeridianPoint;
use super::quality::{height, least_scaled_jacobian};

#[derive(Clone, Debug, Default)]
pub struct QuadMesh {
    pub points: Vec<MeridianPoint>,
    /// Corner nodes of the elements, counter-clockwise in (r, z).
    pub elements: Vec<[usize; 4]>,
}

/// Nodes of a structured block: rows of equal length. The outer rows and columns are its edges.
#[derive(Clone, Debug)]
pub struct QuadBlock(Vec<Vec<usize>>);

impl QuadMesh {
    pub fn node(&mut self, point: MeridianPoint) -> usize {
        self.points.push(point);
        self.points.len() - 1
    }

    /// Creates a block between four edges that share their ends. `first` and `last` have the same direction; `left`
    /// leads from the start of `first` to the start of `last`, and `right` connects their ends; `last` is to the left
    /// of `first`. Inner nodes are created at the origin and placed by [`QuadBlock::spread`].
    pub fn block(&mut self, [first, last]: [&[usize]; 2], [left, right]: [&[usize]; 2]) -> QuadBlock {
        let rows = left.len();
        let row = |n: usize, sheet: &mut QuadMesh| -> Vec<usize> {
            if n == 0 {
                return first.to_vec();
            }
            if n + 1 == rows {
                return last.to_vec();
            }
            let inner = (1..first.len() - 1).map(|_| sheet.node([0.0; 2])).collect::<Vec<_>>();
            [&[left[n]], &inner[..], &[right[n]]].concat()
        };
        QuadBlock((0..rows).map(|n| row(n, self)).collect())
    }

    pub fn fill(&mut self, block: &QuadBlock) {
        for rows in block.0.windows(2) {
            for (low, high) in rows[0].windows(2).zip(rows[1].windows(2)) {
                self.elements.push([low[0], low[1], high[1], high[0]]);
            }
        }
    }

    pub fn corners(&self, element: usize) -> [MeridianPoint; 4] {
        self.elements[element].map(|n| self.points[n])
    }
}

impl QuadBlock {
    /// Places the inner nodes by transfinite interpolation between the edges (Gordon and Hall 1973): the sum of the
    /// interpolations between both pairs of edges minus the bilinear interpolation of the corners.
    pub fn spread(&self, points: &mut [MeridianPoint]) {
        let (rows, columns) = (self.0.len() - 1, self.0[0].len() - 1);
        for i in 1..rows {
            for j in 1..columns {
                let coordinate = |i: usize, j: usize, axis: usize| points[self.0[i][j]][axis];
                // Fraction along the edges, as the mean of both opposite edges.
                let along = |ends: [MeridianPoint; 2], p: MeridianPoint| {
                    let chord = [ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]];
                    let square = chord[0] * chord[0] + chord[1] * chord[1];
                    ((p[0] - ends[0][0]) * chord[0] + (p[1] - ends[0][1]) * chord[1]) / square
                };
                let point = |i: usize, j: usize| points[self.0[i][j]];
                let u = 0.5
                    * (along([point(0, 0), point(0, columns)], point(0, j))
                        + along([point(rows, 0), point(rows, columns)], point(rows, j)));
                let v = 0.5
                    * (along([point(0, 0), point(rows, 0)], point(i, 0))
                        + along([point(0, columns), point(rows, columns)], point(i, columns)));
                let position = [0, 1].map(|k| {
                    (1.0 - v) * coordinate(0, j, k)
                        + v * coordinate(rows, j, k)
                        + (1.0 - u) * coordinate(i, 0, k)
                        + u * coordinate(i, columns, k)
                        - (1.0 - u) * (1.0 - v) * coordinate(0, 0, k)
                        - u * (1.0 - v) * coordinate(0, columns, k)
                        - (1.0 - u) * v * coordinate(rows, 0, k)
                        - u * v * coordinate(rows, columns, k)
                });
                points[self.0[i][j]] = position;
            }
        }
    }

    /// Returns the smallest scaled Jacobian and the smallest height of the elements.
    pub fn worst(&self, points: &[MeridianPoint]) -> [f64; 2] {
        let mut worst = [f64::INFINITY; 2];
        for rows in self.0.windows(2) {
            for (low, high) in rows[0].windows(2).zip(rows[1].windows(2)) {
                let corners = [low[0], low[1], high[1], high[0]].map(|n| points[n]);
                worst[0] = worst[0].min(least_scaled_jacobian(corners));
                worst[1] = worst[1].min(height(corners));
            }
        }
        worst
    }
}
