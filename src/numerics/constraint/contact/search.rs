//! Search for contact candidates: lists of facets that may come into contact, valid until a point has moved too far.

use crate::kernel::lists::MemoryUse;

use super::curve::FacetCurve;

/// Reach of contact as a fraction of the facet length of a pair; points at a larger distance are not in contact.
const REACH: f64 = 0.5;
/// Displacement of a point after which the lists are built again, as a fraction of the facet length. Both surfaces may
/// move by this distance, so boxes are enlarged by the reach and twice the distance.
const SLACK: f64 = 0.5;

/// A box, by its lower and upper corner.
type BoundingBox = [[f64; 2]; 2];

/// Contact candidates: for each exposed facet and each single point of one curve, the facets of the other curve,
/// ascending.
#[derive(Clone, Debug, Default)]
pub struct ContactSearch {
    /// Length that reach and slack refer to: the smaller of the longest facets of both curves.
    pub length: f64,
    /// Sum of the largest distances of both surfaces from their facets.
    pub lift: f64,
    /// Candidates of each exposed facet of the own curve.
    pub facets: CandidateLists,
    /// Candidates on the other curve of each own point without elements.
    pub orphans: CandidateLists,
    /// Candidates on the own curve of each single point of the other curve.
    pub others: CandidateLists,
    order: SortedFacets,
}

/// Lists of indices, stored one after the other.
#[derive(Clone, Debug, Default)]
pub struct CandidateLists {
    first: Vec<u32>,
    list: Vec<u32>,
}

impl CandidateLists {
    #[inline]
    pub fn of(&self, index: usize) -> &[u32] {
        match (self.first.get(index), self.first.get(index + 1)) {
            (Some(&from), Some(&to)) => &self.list[from as usize..to as usize],
            _ => &[],
        }
    }

    fn clear(&mut self) {
        self.first.clear();
        self.list.clear();
        self.first.push(0);
    }

    fn end_one(&mut self) {
        let from = self.first[self.first.len() - 1] as usize;
        self.list[from..].sort_unstable();
        self.first.push(self.list.len() as u32);
    }

    fn memory(&self) -> MemoryUse {
        MemoryUse::of(&self.first) + MemoryUse::of(&self.list)
    }
}

/// Exposed facets of a curve, sorted by the lower end of their boxes along the longer direction of the curve.
#[derive(Clone, Debug, Default)]
struct SortedFacets {
    axis: usize,
    longest: f64,
    order: Vec<(f64, u32)>,
}

impl SortedFacets {
    fn sort(&mut self, curve: &FacetCurve) {
        self.axis = longer_extent(curve);
        self.longest = 0.0;
        self.order.clear();
        for &j in &curve.exposed {
            let [low, high] = curve.shapes[j as usize].bounds();
            self.order.push((low[self.axis], j));
            self.longest = self.longest.max(high[self.axis] - low[self.axis]);
        }
        self.order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    }

    /// Adds the facets with boxes within `margin` of a box.
    fn near(&self, curve: &FacetCurve, [low, high]: BoundingBox, margin: f64, mut add: impl FnMut(u32)) {
        let axis = self.axis;
        let from = self.order.partition_point(|o| o.0 < low[axis] - margin - self.longest);
        for &(_, j) in self.order[from..].iter().take_while(|o| o.0 <= high[axis] + margin) {
            let [l, h] = curve.shapes[j as usize].bounds();
            if (0..2).all(|i| l[i] <= high[i] + margin && h[i] >= low[i] - margin) {
                add(j);
            }
        }
    }
}

impl ContactSearch {
    /// Allocates lists for curves with this number of facets.
    pub fn new(length: f64, lift: f64, facets: usize, others: usize) -> ContactSearch {
        let with_capacity_for = |count: usize, list: usize| CandidateLists {
            first: Vec::with_capacity(count),
            list: Vec::with_capacity(list),
        };
        ContactSearch {
            length,
            lift,
            facets: with_capacity_for(facets + 1, 16 * (facets + others)),
            orphans: with_capacity_for(facets + 1, 4 * facets),
            others: with_capacity_for(others + 1, 4 * others),
            order: SortedFacets { order: Vec::with_capacity(facets.max(others)), ..SortedFacets::default() },
        }
    }

    /// Returns the displacement of a point at which lists are built again.
    pub fn slack(&self) -> f64 {
        SLACK * self.length
    }

    /// Returns the distance from a surface within which gaps are measured.
    pub fn reach(&self) -> f64 {
        REACH * self.length
    }

    /// Builds the lists. In self-contact (`other` is `None`) a pair of facets is listed once, under the lower index.
    /// Facets with a common point are not candidates.
    pub fn build(&mut self, own: &FacetCurve, other: Option<&FacetCurve>, places: &[[f64; 2]]) {
        let (against, margin) = (other.unwrap_or(own), self.reach() + self.lift + 2.0 * self.slack());
        let ContactSearch { facets, orphans, others, order, .. } = self;
        order.sort(against);
        facets.clear();
        for &k in &own.exposed {
            let shape = &own.shapes[k as usize];
            order.near(against, shape.bounds(), margin, |j| {
                let seen_already = other.is_none() && j <= k;
                let neighbours = own.facets[k as usize].iter().any(|p| against.facets[j as usize].contains(p));
                if !seen_already && !neighbours {
                    facets.list.push(j);
                }
            });
            facets.end_one();
        }
        list_points(orphans, (own, own.orphans.iter().copied()), against, order, places, margin);
        if let Some(other) = other.filter(|o| o.single_points().next().is_some()) {
            order.sort(own);
            list_points(others, (other, other.single_points().map(|point| point.0)), own, order, places, margin);
        }
    }

    /// Returns the number of bytes of the lists, in use and in reserve.
    pub fn memory(&self) -> MemoryUse {
        [&self.facets, &self.orphans, &self.others].into_iter().map(CandidateLists::memory).sum::<MemoryUse>()
            + MemoryUse::of(&self.order.order)
    }
}

fn list_points(
    lists: &mut CandidateLists,
    (of, points): (&FacetCurve, impl Iterator<Item = u32>),
    against: &FacetCurve,
    order: &SortedFacets,
    places: &[[f64; 2]],
    margin: f64,
) {
    lists.clear();
    for index in points {
        let place = places[of.own[index as usize] as usize];
        order.near(against, [place; 2], margin, |j| lists.list.push(j));
        lists.end_one();
    }
}

/// Returns the direction along which a curve is longer: r (0) or z (1).
fn longer_extent(curve: &FacetCurve) -> usize {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for &k in &curve.exposed {
        let [l, h] = curve.shapes[k as usize].bounds();
        for i in [0, 1] {
            (low[i], high[i]) = (low[i].min(l[i]), high[i].max(h[i]));
        }
    }
    usize::from(high[1] - low[1] > high[0] - low[0])
}
