//! Boxes sorted along one direction, to find those near another box.

use super::lists::Memory;

/// A box in the (r, z) plane, by its lower and upper corner.
pub type BoundingBox = [[f64; 2]; 2];

/// Returns the box of two points.
#[inline]
pub fn bounding_box([a, b]: [[f64; 2]; 2]) -> BoundingBox {
    [[a[0].min(b[0]), a[1].min(b[1])], [a[0].max(b[0]), a[1].max(b[1])]]
}

/// The box of no points.
pub const NO_BOX: BoundingBox = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];

/// Returns the box around two boxes.
#[inline]
pub fn box_around(a: BoundingBox, b: BoundingBox) -> BoundingBox {
    [[a[0][0].min(b[0][0]), a[0][1].min(b[0][1])], [a[1][0].max(b[1][0]), a[1][1].max(b[1][1])]]
}

/// Returns the box of several points.
pub fn box_of(points: &[[f64; 2]]) -> BoundingBox {
    points.iter().fold(NO_BOX, |all, p| box_around(all, [*p; 2]))
}

/// Returns whether the distance of two boxes along r or z is more than `margin`.
#[inline]
pub fn are_apart([low, high]: BoundingBox, [l, h]: BoundingBox, margin: f64) -> bool {
    (0..2).any(|i| l[i] > high[i] + margin || h[i] < low[i] - margin)
}

/// Returns whether a point is within the box of a body. The axis is no side of a body, so that points on it can be within.
#[inline]
pub fn is_within_body([low, high]: BoundingBox, point: [f64; 2]) -> bool {
    (low[0] < point[0] || point[0] == 0.0) && low[1] < point[1] && (0..2).all(|i| point[i] < high[i])
}

/// Boxes with an index each, sorted by their lower end along r or z: the direction in which the boxes extend farther.
#[derive(Clone, Debug, Default, Memory)]
pub struct SortedBoxes {
    axis: usize,
    longest: f64,
    boxes: Vec<(BoundingBox, u32)>,
}

impl SortedBoxes {
    /// Reserves memory for this number of boxes.
    pub fn with_capacity(count: usize) -> SortedBoxes {
        SortedBoxes { boxes: Vec::with_capacity(count), ..SortedBoxes::default() }
    }

    /// Reserves memory for a total number of boxes.
    pub fn reserve(&mut self, count: usize) {
        self.boxes.reserve_exact(count.saturating_sub(self.boxes.len()));
    }

    /// Sorts these boxes. Does not allocate within the capacity.
    pub fn sort(&mut self, boxes: impl Iterator<Item = (BoundingBox, u32)>) {
        self.boxes.clear();
        self.boxes.extend(boxes);
        let [low, high] = self.boxes.iter().fold(NO_BOX, |all, (b, _)| box_around(all, *b));
        let axis = usize::from(high[1] - low[1] > high[0] - low[0]);
        self.axis = axis;
        self.longest = self.boxes.iter().map(|(b, _)| b[1][axis] - b[0][axis]).fold(0.0, f64::max);
        self.boxes.sort_unstable_by(|a, b| a.0[0][axis].total_cmp(&b.0[0][axis]).then(a.1.cmp(&b.1)));
    }

    /// Calls `add` with the indices of the boxes within `margin` of a box, along both directions.
    #[inline]
    pub fn near(&self, [low, high]: BoundingBox, margin: f64, mut add: impl FnMut(u32)) {
        let axis = self.axis;
        let from = self.boxes.partition_point(|b| b.0[0][axis] < low[axis] - margin - self.longest);
        for (other, index) in self.boxes[from..].iter().take_while(|b| b.0[0][axis] <= high[axis] + margin) {
            if !are_apart([low, high], *other, margin) {
                add(*index);
            }
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Returns a sequence of numbers between 0 and 1.
    pub fn sequence() -> impl FnMut() -> f64 {
        let mut seed = 7_u64;
        move || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 40) as f64 / (1_u64 << 24) as f64
        }
    }

    /// Returns the boxes near another one by a comparison with every box.
    pub fn compared(boxes: &[BoundingBox], query: BoundingBox, margin: f64) -> Vec<u32> {
        let apart = |b: &BoundingBox| (0..2).any(|i| b[0][i] > query[1][i] + margin || b[1][i] < query[0][i] - margin);
        (0..).zip(boxes).filter(|b| !apart(b.1)).map(|b| b.0).collect()
    }

    /// The boxes that a search finds are those of a comparison with every box.
    #[test]
    fn search_finds_every_box_within_the_margin() {
        let mut next = sequence();
        let boxes: Vec<BoundingBox> = (0..300)
            .map(|_| bounding_box([[next(), 3.0 * next()], [next(), 3.0 * next()]].map(|p| [0.2 * p[0], p[1]])))
            .collect();
        let mut sorted = SortedBoxes::with_capacity(boxes.len());
        sorted.sort(boxes.iter().copied().zip(0..));
        for (query, margin) in boxes.iter().zip([0.0, 0.01, 0.3].into_iter().cycle()) {
            let mut hits = Vec::new();
            sorted.near(*query, margin, |index| hits.push(index));
            hits.sort_unstable();
            assert_eq!(hits, compared(&boxes, *query, margin));
        }
    }
}
