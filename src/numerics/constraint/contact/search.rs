//! Search for contact candidates: lists of facets that may come into contact, valid until a point has moved too far.

use crate::kernel::lists::Memory;
use crate::kernel::sorted_boxes::{BoundingBox, SortedBoxes, are_apart};

use super::curve::{FacetCurve, PointKind};
use super::sweeps::reserve_total;

/// Reach of contact as a fraction of the facet length of a pair; points at a larger distance are not in contact.
const REACH: f64 = 0.5;
/// Displacement of a point after which the lists are built again, as a fraction of the facet length. Both surfaces may
/// move by this distance, so boxes are enlarged by the reach and twice the distance.
const SLACK: f64 = 0.5;

/// Factor on displacements, for rounding.
const ROUNDING: f64 = 1.001;
/// Displacement of a point after which the close candidates are selected again, as a fraction of the facet length.
const CLOSE_SLACK: f64 = 0.1;
/// Displacement of a point up to which surfaces may be known to be out of reach, as a fraction of the facet length.
const QUIET_SLACK: f64 = 0.2;

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
    /// Facets and points that may come within reach before the next selection.
    pub close: CloseParts,
    sorted: SortedBoxes,
}

/// Parts of the own curve with candidates that may come within reach before a point has moved by
/// [`ContactSearch::close_slack`]. Only these are measured.
#[derive(Clone, Debug, Default, Memory)]
pub struct CloseParts {
    /// Own facets with close candidates, in the order of the exposed facets.
    pub facets: Vec<u32>,
    /// Close candidates of each of these facets.
    pub candidates: CandidateLists,
    /// Points of these facets, as indices of points of the own curve, in the order of the exposed points.
    pub points: Vec<u32>,
    /// Whether each facet of the own curve has close candidates.
    is_close: Vec<bool>,
}

impl CloseParts {
    fn reserve(&mut self, facets: usize, candidates: usize) {
        reserve_total(&mut self.facets, facets);
        reserve_total(&mut self.points, 2 * facets);
        reserve_total(&mut self.is_close, facets);
        self.candidates.reserve(facets + 1, candidates);
    }

    fn clear(&mut self, facets: usize) {
        self.facets.clear();
        self.points.clear();
        self.candidates.clear();
        self.is_close.clear();
        self.is_close.resize(facets, false);
    }
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

    /// Allocates for a number of lists and of all indices. Copies of the lists have no reserve.
    fn reserve(&mut self, count: usize, indices: usize) {
        reserve_total(&mut self.first, count);
        reserve_total(&mut self.list, indices);
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
    /// Creates a search without lists.
    pub fn new(length: f64) -> ContactSearch {
        ContactSearch { length, ..ContactSearch::default() }
    }

    /// Allocates lists for curves with this number of facets.
    pub fn reserve(&mut self, facets: usize, others: usize) {
        self.facets.reserve(facets + 1, 16 * (facets + others));
        self.orphans.reserve(facets + 1, 4 * facets);
        self.others.reserve(others + 1, 4 * others);
        self.close.reserve(facets, 16 * (facets + others));
        self.sorted.reserve(facets.max(others));
    }

    /// Returns the displacement of a point at which lists are built again.
    pub fn slack(&self) -> f64 {
        SLACK * self.length
    }

    /// Returns the displacement of a point at which lists are built again if no surfaces are within reach
    /// ([`Self::is_out_of_reach`]).
    pub fn quiet_slack(&self) -> f64 {
        QUIET_SLACK * self.length
    }

    /// Returns the displacement of a point at which the close candidates are selected again.
    pub fn close_slack(&self) -> f64 {
        CLOSE_SLACK * self.length
    }

    /// Returns the distance from a surface within which gaps are measured.
    pub fn reach(&self) -> f64 {
        REACH * self.length
    }

    /// Returns the distance within which facets are candidates.
    pub fn margin(&self) -> f64 {
        self.reach() + self.lift + 2.0 * self.slack()
    }

    /// Returns whether a list has a candidate.
    pub fn has_candidates(&self) -> bool {
        [&self.facets, &self.orphans, &self.others].iter().any(|lists| !lists.list.is_empty())
    }

    /// Empties the lists.
    pub fn clear(&mut self) {
        [&mut self.facets, &mut self.orphans, &mut self.others].into_iter().for_each(CandidateLists::clear);
    }

    /// Builds the lists. In self-contact (`other` is `None`) a pair of facets is listed once, under the lower index.
    /// Facets with a common point, or with points that move alike, are not candidates. `alike` has for each point the first one
    /// with the same motion; it is empty if there are none.
    pub fn build(&mut self, own: &FacetCurve, other: Option<&FacetCurve>, (places, alike): (&[[f64; 2]], &[u32])) {
        let of_motion = |point: u32| alike.get(point as usize).copied().unwrap_or(point);
        let has_point = |facet: &[u32; 2], point: u32| facet.iter().any(|end| of_motion(*end) == of_motion(point));
        let (against, margin) = (other.unwrap_or(own), self.margin());
        let ContactSearch { facets, orphans, others, sorted, .. } = self;
        sorted.sort(boxes_of(against));
        facets.clear();
        for &k in &own.exposed {
            let shape = &own.shapes[k as usize];
            sorted.near(shape.bounds(), margin, |j| {
                let seen_already = other.is_none() && j <= k;
                let neighbours = own.facets[k as usize].iter().any(|p| has_point(&against.facets[j as usize], *p));
                if !seen_already && !neighbours {
                    facets.list.push(j);
                }
            });
            facets.end_one();
        }
        let is_apart = |curve: &FacetCurve, facet: u32, point| !has_point(&curve.facets[facet as usize], point);
        let near = NearFacets { sorted, places, margin };
        list_points(orphans, (own, own.orphans.iter().copied()), near, |facet, point| is_apart(against, facet, point));
        if let Some(other) = other.filter(|o| o.single_points().next().is_some()) {
            sorted.sort(boxes_of(own));
            let points = other.single_points().map(|point| point.0);
            let near = NearFacets { sorted, places, margin };
            list_points(others, (other, points), near, |facet, point| is_apart(own, facet, point));
        }
    }
}

impl ContactSearch {
    /// Selects from the candidates of facets those that may come within reach while each point moves by at most `motion`.
    pub fn select_close(&mut self, own: &FacetCurve, other: Option<&FacetCurve>, motion: f64) {
        self.close.clear(own.facets.len());
        let (opposite, limit) = (other.unwrap_or(own), self.reach() + 2.0 * motion * ROUNDING);
        let ContactSearch { facets, close: CloseParts { facets: close_facets, candidates, points, is_close }, .. } =
            self;
        for (at, &k) in own.exposed.iter().enumerate() {
            let (bounds, lift) = (own.shapes[k as usize].bounds(), own.lift[k as usize]);
            let is_near = |j: &&u32| {
                let margin = limit + lift + opposite.lift[**j as usize];
                !are_apart(bounds, opposite.shapes[**j as usize].bounds(), margin)
            };
            let first = candidates.list.len();
            candidates.list.extend(facets.of(at).iter().filter(is_near));
            if candidates.list.len() > first {
                candidates.end_one();
                close_facets.push(k);
                is_close[k as usize] = true;
            }
        }
        let has_close_facet =
            |index: &&u32| own.around_own(**index as usize).iter().any(|facet| is_close[facet.0 as usize]);
        points.extend(own.exposed_points.iter().filter(has_close_facet));
    }

    /// Returns whether no candidates come within reach of each other while each point moves by at most `motion`.
    pub fn is_out_of_reach(
        &self,
        own: &FacetCurve,
        other: Option<&FacetCurve>,
        places: &[[f64; 2]],
        motion: f64,
    ) -> bool {
        let opposite = other.unwrap_or(own);
        let limit = self.reach() + self.lift + 2.0 * motion * ROUNDING;
        let are_far = |at: usize, k: u32| {
            let bounds = own.shapes[k as usize].bounds();
            self.facets.of(at).iter().all(|j| are_apart(bounds, opposite.shapes[*j as usize].bounds(), limit))
        };
        let facets_are_far = own.exposed.iter().enumerate().all(|(at, &k)| are_far(at, k));
        facets_are_far
            && (0..own.orphans.len()).all(|at| self.orphans.of(at).is_empty())
            && other.is_none_or(|other| self.points_are_out_of_reach(own, other, places, motion))
    }

    /// Returns whether no single point of the other curve comes within reach of its candidates. Only a corner can be in front
    /// of a facet without being in contact with it.
    fn points_are_out_of_reach(&self, own: &FacetCurve, other: &FacetCurve, places: &[[f64; 2]], motion: f64) -> bool {
        let limit = self.reach() + self.lift + 2.0 * motion * ROUNDING;
        other.single_points().enumerate().all(|(at, (index, kind))| {
            let position = places[other.points[index as usize] as usize];
            self.others.of(at).iter().all(|&j| {
                let shape = &own.shapes[j as usize];
                kind == PointKind::Corner
                    && are_apart([position; 2], shape.bounds(), limit)
                    && shape.stays_in_front_or_beside(position, self.reach(), 2.0 * motion * ROUNDING)
            })
        })
    }
}

/// Iterates over the boxes of the exposed facets of a curve.
fn boxes_of(curve: &FacetCurve) -> impl Iterator<Item = (BoundingBox, u32)> + '_ {
    curve.exposed.iter().map(|&j| (curve.shapes[j as usize].bounds(), j))
}

/// Boxes of facets, places of the points of surfaces, and the distance within which facets are candidates.
struct NearFacets<'a> {
    sorted: &'a SortedBoxes,
    places: &'a [[f64; 2]],
    margin: f64,
}

/// Lists for each point of a curve the facets near it that are candidates (facet, point).
fn list_points(
    lists: &mut CandidateLists,
    (of, points): (&FacetCurve, impl Iterator<Item = u32>),
    NearFacets { sorted, places, margin }: NearFacets<'_>,
    is_candidate: impl Fn(u32, u32) -> bool,
) {
    lists.clear();
    for index in points {
        let point = of.points[index as usize];
        let near = |j: u32| {
            if is_candidate(j, point) {
                lists.list.push(j);
            }
        };
        sorted.near([places[point as usize]; 2], margin, near);
        lists.end_one();
    }
}
