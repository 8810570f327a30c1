//! Which facets may meet within the next increments: lists that hold until something has moved too far.
//! Never here: gaps.

use super::curve::Curve;

/// Part of the pair's length of facets that is the reach of contact: points further from the other surface are out of it.
pub const REACH: f64 = 0.5;
/// Part of it that a point may move before lists are made anew. Both surfaces may move so far: boxes are widened by reach and
/// twice this.
const SLACK: f64 = 0.5;

/// For each facet of one curve the facets of another that it may meet, ascending.
#[derive(Clone, Debug, Default)]
pub struct Search {
    /// The length that reach and slack are parts of: the smaller of the longest facets of both.
    pub length: f64,
    first: Vec<u32>,
    list: Vec<u32>,
    order: Vec<(f64, u32)>,
}

impl Search {
    /// Room for lists.
    pub fn new(length: f64, facets: usize, others: usize) -> Search {
        Search {
            length,
            first: Vec::with_capacity(facets + 1),
            list: Vec::with_capacity(16 * (facets + others)),
            order: Vec::with_capacity(others),
        }
    }

    /// How far points may move before lists are made anew.
    pub fn slack(&self) -> f64 {
        SLACK * self.length
    }

    /// How far in front of a surface contact begins to be looked at.
    pub fn reach(&self) -> f64 {
        REACH * self.length
    }

    /// Facets that the facet `k` may meet.
    #[inline]
    pub fn candidates(&self, k: usize) -> &[u32] {
        match (self.first.get(k), self.first.get(k + 1)) {
            (Some(&from), Some(&to)) => &self.list[from as usize..to as usize],
            _ => &[],
        }
    }

    /// Makes the lists. A curve that meets itself (`other` is `None`) has each two facets once, under the lower index. Facets
    /// with a point in common do not meet.
    pub fn build(&mut self, own: &Curve, other: Option<&Curve>) {
        let (against, margin) = (other.unwrap_or(own), self.reach() + 2.0 * self.slack());
        let axis = longer_extent(against);
        let order = &mut self.order;
        order.clear();
        let mut longest: f64 = 0.0;
        for (j, shape) in against.shapes.iter().enumerate().filter(|(j, _)| against.there[*j]) {
            let [low, high] = shape.bounds();
            order.push((low[axis], j as u32));
            longest = longest.max(high[axis] - low[axis]);
        }
        order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        self.first.clear();
        self.list.clear();
        for (k, shape) in own.shapes.iter().enumerate() {
            let begin = self.list.len();
            self.first.push(begin as u32);
            if !own.there[k] {
                continue;
            }
            let [low, high] = shape.bounds();
            let from = order.partition_point(|o| o.0 < low[axis] - margin - longest);
            for &(_, j) in order[from..].iter().take_while(|o| o.0 <= high[axis] + margin) {
                let [l, h] = against.shapes[j as usize].bounds();
                let apart = (0..2).any(|i| l[i] > high[i] + margin || h[i] < low[i] - margin);
                let seen_already = other.is_none() && j as usize <= k;
                let neighbours = own.facets[k].iter().any(|p| against.facets[j as usize].contains(p));
                if !apart && !seen_already && !neighbours {
                    self.list.push(j);
                }
            }
            self.list[begin..].sort_unstable();
        }
        self.first.push(self.list.len() as u32);
    }

    /// Bytes of the lists.
    pub fn bytes(&self) -> usize {
        size_of::<u32>() * (self.first.capacity() + self.list.capacity())
            + size_of::<(f64, u32)>() * self.order.capacity()
    }
}

/// The direction along which a curve is longer: r (0) or z (1).
fn longer_extent(curve: &Curve) -> usize {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for shape in &curve.shapes {
        let [l, h] = shape.bounds();
        for i in [0, 1] {
            (low[i], high[i]) = (low[i].min(l[i]), high[i].max(h[i]));
        }
    }
    usize::from(high[1] - low[1] > high[0] - low[0])
}
