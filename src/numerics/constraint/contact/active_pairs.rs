//! Pairs whose surfaces have been near each other. All other pairs have no candidates, no pressures and no slip, so that an
//! increment visits the active pairs only.

use crate::kernel::lists::Memory;
use crate::kernel::sorted_boxes::{BoundingBox, SortedBoxes, are_apart};

use super::curve::FacetCurve;
use super::pairs::ContactPair;
use super::sweeps::reserve_total;

/// Number of pairs up to which all are active from the start.
const ALL_ACTIVE: usize = 32;

/// Active pairs of a contact. A pair becomes active when its surfaces are near each other, and remains active.
#[derive(Clone, Debug, Default, Memory)]
pub(super) struct ActivePairs {
    /// Indices of the active pairs, ascending.
    pub(super) list: Vec<u32>,
    /// Indices of the active pairs with analytical surfaces, and of the pairs for which the last search found candidates,
    /// ascending.
    pub(super) analytical: Vec<u32>,
    pub(super) near: Vec<u32>,
    /// Indices of the pairs that the last search has made active.
    pub(super) added: Vec<u32>,
    /// First key and end of the keys of the active pairs, in contiguous ranges.
    keys: Vec<[u32; 2]>,
    /// Own curve and index of each active pair and of the first pair of each curve, ascending.
    by_own_curve: Vec<[u32; 2]>,
    /// Lower curve, higher curve and index of each pair of two curves that can become active, ascending.
    by_curves: Vec<[u32; 3]>,
    /// Box of the exposed facets and of the single points of each curve.
    pub(super) boxes: Vec<BoundingBox>,
    sorted: SortedBoxes,
    /// Smallest thickness of the elements of inactive pairs.
    pub(super) thinnest_inactive: f64,
    /// Largest distance of surfaces at which a pair has candidates.
    margin: f64,
}

impl ActivePairs {
    /// Lists the pairs that are active from the start: those with analytical surfaces, in self-contact, and all if there are
    /// few.
    pub(super) fn new(pairs: &mut [ContactPair], curves: &[FacetCurve]) -> ActivePairs {
        let all = pairs.len() <= ALL_ACTIVE;
        let mut active = ActivePairs {
            boxes: Vec::with_capacity(curves.len()),
            sorted: SortedBoxes::with_capacity(curves.len()),
            thinnest_inactive: f64::INFINITY,
            ..ActivePairs::default()
        };
        let mut has_first = vec![false; curves.len()];
        for (index, pair) in (0..).zip(pairs.iter_mut()) {
            if !std::mem::replace(&mut has_first[pair.secondary], true) {
                active.by_own_curve.push([pair.secondary as u32, index]);
            }
            match pair.other.filter(|_| !all) {
                None => active.added.push(index),
                Some(other) => {
                    let curves = [pair.secondary as u32, other as u32];
                    active.by_curves.push([curves[0].min(curves[1]), curves[0].max(curves[1]), index]);
                    active.margin = active.margin.max(pair.search.margin());
                }
            }
        }
        active.by_own_curve.sort_unstable();
        active.by_curves.sort_unstable();
        active.insert_added(pairs, curves);
        active
    }

    /// Activates pairs.
    pub(super) fn activate(
        &mut self,
        indices: impl Iterator<Item = usize>,
        pairs: &mut [ContactPair],
        curves: &[FacetCurve],
    ) {
        self.added.clear();
        self.added.extend(indices.filter(|index| !pairs[*index].is_active).map(|index| index as u32));
        self.insert_added(pairs, curves);
    }

    /// Updates the boxes of the curves from the shapes of their facets, and activates the pairs that may have candidates.
    pub(super) fn update(&mut self, pairs: &mut [ContactPair], curves: &[FacetCurve], places: &[[f64; 2]]) {
        self.boxes.clear();
        self.boxes.extend(curves.iter().map(|curve| curve.bounds(places)));
        self.added.clear();
        if self.list.len() == pairs.len() {
            return;
        }
        let ActivePairs { added, by_curves, boxes, sorted, margin, .. } = self;
        sorted.sort(boxes.iter().copied().zip(0..));
        for (first, bounds) in (0..).zip(boxes.iter()) {
            sorted.near(*bounds, *margin, |second| {
                let from = by_curves.partition_point(|known| [known[0], known[1]] < [first, second]);
                let of_curves = by_curves[from..].iter().take_while(|known| [known[0], known[1]] == [first, second]);
                added.extend(of_curves.map(|known| known[2]).filter(|index| {
                    let pair = &pairs[*index as usize];
                    !pair.is_active && !are_apart(*bounds, boxes[second as usize], pair.search.margin())
                }));
            });
        }
        self.insert_added(pairs, curves);
    }

    /// Inserts the added pairs into the lists and allocates their arrays.
    fn insert_added(&mut self, pairs: &mut [ContactPair], curves: &[FacetCurve]) {
        if self.added.is_empty() {
            return;
        }
        for &index in &self.added {
            let pair = &mut pairs[index as usize];
            pair.activate(curves);
            self.by_own_curve.push([pair.secondary as u32, index]);
        }
        self.list.extend_from_slice(&self.added);
        self.list.sort_unstable();
        self.analytical.clear();
        let is_analytical = |index: &u32| pairs[*index as usize].analytical.is_some();
        self.analytical.extend(self.list.iter().copied().filter(is_analytical));
        reserve_total(&mut self.near, self.list.len());
        self.by_own_curve.sort_unstable();
        self.by_own_curve.dedup();
        self.keys.clear();
        for &index in &self.list {
            let ContactPair { first_key, end_key, .. } = pairs[index as usize];
            match self.keys.last_mut().filter(|last| last[1] == first_key) {
                Some(last) => last[1] = end_key,
                None => self.keys.push([first_key, end_key]),
            }
        }
        let inactive = pairs.iter().filter(|pair| !pair.is_active);
        self.thinnest_inactive = inactive.fold(f64::INFINITY, |thinnest, pair| thinnest.min(pair.thickness));
    }

    /// Allocates what searches need. Copies of the lists have no reserve.
    pub(super) fn reserve(&mut self, pairs: &mut [ContactPair], curves: &[FacetCurve]) {
        reserve_total(&mut self.near, self.list.len());
        reserve_total(&mut self.boxes, curves.len());
        self.sorted.reserve(curves.len());
        for &index in &self.list {
            let pair = &mut pairs[index as usize];
            if pair.analytical.is_none() {
                pair.reserve(curves);
            }
        }
    }

    /// Returns whether the boxes of the curves of a pair are too far apart for candidates.
    pub(super) fn are_apart(&self, pair: &ContactPair) -> bool {
        pair.other.is_some_and(|other| are_apart(self.boxes[pair.secondary], self.boxes[other], pair.search.margin()))
    }

    /// Sets the values of all keys of active pairs. Other keys have no values.
    pub(super) fn fill<T: Copy>(&self, values: &mut [T], value: T) {
        if !values.is_empty() {
            self.keys.iter().for_each(|[from, to]| values[*from as usize..*to as usize].fill(value));
        }
    }

    /// Returns the lowest pair above `last` of an own curve: an active one, or the first pair of the curve.
    fn pair_of_curve_after(&self, curve: u32, last: Option<u32>) -> Option<u32> {
        let least = [curve, last.map_or(0, |last| last + 1)];
        let from = self.by_own_curve.partition_point(|known| *known < least);
        self.by_own_curve.get(from).filter(|known| known[0] == curve).map(|known| known[1])
    }

    /// Iterates over the pairs whose own curve is in a list, ascending: the active pairs, and the first pair of each curve.
    pub(super) fn pairs_of_curves(&self, curves: impl Iterator<Item = u32> + Clone) -> impl Iterator<Item = usize> {
        let after =
            move |last: Option<u32>| curves.clone().filter_map(|curve| self.pair_of_curve_after(curve, last)).min();
        std::iter::successors(after(None), move |last| after(Some(*last))).map(|index| index as usize)
    }
}
