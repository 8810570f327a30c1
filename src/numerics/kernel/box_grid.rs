//! Boxes in the cells of a grid, to find those near another box.

use super::lanes::InlineMap;
use super::sorted_boxes::{BoundingBox, NO_BOX, are_apart, box_around};

/// Boxes with an index each, by the cell of a regular grid in which their lower corner is. The grid has about one cell for
/// each box, so that a search visits few boxes that are not near.
#[derive(Clone, Debug, Default)]
pub struct BoxGrid {
    low: [f64; 2],
    /// Cells per length, and their number, along both directions.
    density: [f64; 2],
    counts: [usize; 2],
    /// Largest extent of a box.
    longest: [f64; 2],
    /// First box of each cell, and the number of all boxes.
    first: Vec<u32>,
    boxes: Vec<(BoundingBox, u32)>,
}

impl BoxGrid {
    /// Sorts boxes into a grid.
    pub fn new(boxes: impl Iterator<Item = (BoundingBox, u32)>) -> BoxGrid {
        let boxes: Vec<(BoundingBox, u32)> = boxes.collect();
        let [low, high] = boxes.iter().fold(NO_BOX, |all, (b, _)| box_around(all, [b[0]; 2]));
        let longest = [0, 1].inline_map(|i: usize| boxes.iter().map(|(b, _)| b[1][i] - b[0][i]).fold(0.0, f64::max));
        let extents = [0, 1].inline_map(|i: usize| high[i] - low[i]);
        let count = boxes.len().max(1) as f64;
        let edge = (extents[0] * extents[1] / count).sqrt().max(extents[0].max(extents[1]) / count);
        let counts = extents.inline_map(|extent| if edge > 0.0 { 1 + (extent / edge) as usize } else { 1 });
        let density = [0, 1].inline_map(|i: usize| if extents[i] > 0.0 { counts[i] as f64 / extents[i] } else { 0.0 });
        let mut grid = BoxGrid { low, density, counts, longest, ..BoxGrid::default() };
        grid.fill(&boxes);
        grid
    }

    fn fill(&mut self, boxes: &[(BoundingBox, u32)]) {
        let cells: Vec<usize> =
            boxes.iter().map(|(b, _)| self.cell([0, 1].inline_map(|i| self.row(i, b[0][i])))).collect();
        self.first = vec![0; self.counts[0] * self.counts[1] + 1];
        cells.iter().for_each(|cell| self.first[cell + 1] += 1);
        for cell in 1..self.first.len() {
            self.first[cell] += self.first[cell - 1];
        }
        let mut next = self.first.clone();
        self.boxes = vec![(NO_BOX, 0); boxes.len()];
        for (own, cell) in boxes.iter().zip(cells) {
            self.boxes[next[cell] as usize] = *own;
            next[cell] += 1;
        }
    }

    fn cell(&self, [r, z]: [usize; 2]) -> usize {
        z * self.counts[0] + r
    }

    /// Returns the row of cells at a coordinate; the first or the last one outside the grid.
    #[inline]
    fn row(&self, axis: usize, x: f64) -> usize {
        (((x - self.low[axis]) * self.density[axis]) as usize).min(self.counts[axis] - 1)
    }

    /// Calls `add` with the indices of the boxes within `margin` of a box, along both directions.
    #[inline]
    pub fn near(&self, [low, high]: BoundingBox, margin: f64, mut add: impl FnMut(u32)) {
        let rows = [0, 1]
            .inline_map(|i: usize| [self.row(i, low[i] - margin - self.longest[i]), self.row(i, high[i] + margin)]);
        for z in rows[1][0]..=rows[1][1] {
            let [from, to] = rows[0].inline_map(|r| self.cell([r, z]));
            for (other, index) in &self.boxes[self.first[from] as usize..self.first[to + 1] as usize] {
                if !are_apart([low, high], *other, margin) {
                    add(*index);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::sorted_boxes::bounding_box;
    use crate::kernel::sorted_boxes::tests::{compared, sequence};

    /// Returns the boxes that a search finds and those of a comparison with every box, both in ascending order.
    fn found(boxes: &[BoundingBox], query: BoundingBox, margin: f64) -> [Vec<u32>; 2] {
        let grid = BoxGrid::new(boxes.iter().copied().zip(0..));
        let mut hits = Vec::new();
        grid.near(query, margin, |index| hits.push(index));
        hits.sort_unstable();
        [hits, compared(boxes, query, margin)]
    }

    #[test]
    fn search_finds_every_box_within_the_margin() {
        let mut next = sequence();
        let boxes: Vec<BoundingBox> = (0..300)
            .map(|_| {
                let corner = [next(), 3.0 * next()];
                bounding_box([corner, [corner[0] + 0.1 * next(), corner[1] + 0.05 * next()]])
            })
            .collect();
        for (query, margin) in boxes.iter().zip([0.0, 0.01, 0.3].into_iter().cycle()) {
            let [hits, right] = found(&boxes, *query, margin);
            assert_eq!(hits, right);
        }
        let band = [[f64::NEG_INFINITY, 0.95], [f64::INFINITY, 1.05]];
        let [hits, right] = found(&boxes, band, 0.0);
        assert!(hits == right && !right.is_empty());
    }

    #[test]
    fn boxes_on_a_line_or_in_one_point_are_found() {
        let on_a_line: Vec<BoundingBox> = (0..50).map(|i| [[0.1 * f64::from(i), 2.0]; 2]).collect();
        let in_a_point = vec![[[1.0, 2.0]; 2]; 7];
        for (boxes, count) in [(on_a_line, 6), (in_a_point, 7)] {
            let [hits, right] = found(&boxes, [[0.95, 2.0], [1.35, 2.0]], 0.06);
            assert_eq!(hits, right);
            assert_eq!(right.len(), count);
        }
        assert!(found(&[], [[0.0; 2]; 2], 1.0).iter().all(Vec::is_empty));
    }
}
