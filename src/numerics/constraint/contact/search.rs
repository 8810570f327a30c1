//! Search for contact candidates: lists of facets that may come into contact, valid until a point has moved too far.

use crate::kernel::lists::Memory;
use crate::kernel::sorted_boxes::{BoundingBox, SortedBoxes};

use super::curve::FacetCurve;

/// Reach of contact as a fraction of the facet length of a pair; points at a larger distance are not in contact.
const REACH: f64 = 0.5;
/// Displacement of a point after which the lists are built again, as a fraction of the facet length. Both surfaces may
/// move by this distance, so boxes are enlarged by the reach and twice the distance.
const SLACK: f64 = 0.5;

/// Contact candidates: for each exposed facet and each single point of one curve, the facets of the other curve,
/// ascending.
#[derive(Clone, Debug, Default, Memory)]
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
    sorted: SortedBoxes,
}

/// Lists of indices, stored one after the other.
#[derive(Clone, Debug, Default, Memory)]
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
            sorted: SortedBoxes::with_capacity(facets.max(others)),
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
        let ContactSearch { facets, orphans, others, sorted, .. } = self;
        sorted.sort(boxes_of(against));
        facets.clear();
        for &k in &own.exposed {
            let shape = &own.shapes[k as usize];
            sorted.near(shape.bounds(), margin, |j| {
                let seen_already = other.is_none() && j <= k;
                let neighbours = own.facets[k as usize].iter().any(|p| against.facets[j as usize].contains(p));
                if !seen_already && !neighbours {
                    facets.list.push(j);
                }
            });
            facets.end_one();
        }
        list_points(orphans, (own, own.orphans.iter().copied()), sorted, places, margin);
        if let Some(other) = other.filter(|o| o.single_points().next().is_some()) {
            sorted.sort(boxes_of(own));
            list_points(others, (other, other.single_points().map(|point| point.0)), sorted, places, margin);
        }
    }
}

/// Iterates over the boxes of the exposed facets of a curve.
fn boxes_of(curve: &FacetCurve) -> impl Iterator<Item = (BoundingBox, u32)> + '_ {
    curve.exposed.iter().map(|&j| (curve.shapes[j as usize].bounds(), j))
}

fn list_points(
    lists: &mut CandidateLists,
    (of, points): (&FacetCurve, impl Iterator<Item = u32>),
    sorted: &SortedBoxes,
    places: &[[f64; 2]],
    margin: f64,
) {
    lists.clear();
    for index in points {
        let position = places[of.points[index as usize] as usize];
        sorted.near([position; 2], margin, |j| lists.list.push(j));
        lists.end_one();
    }
}
