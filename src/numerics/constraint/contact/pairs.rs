//! Contact pairs: two surfaces that may come into contact, or one with self-contact.

use std::ops::Range;

use super::curve::FacetCurve;
use super::gaps::FacetGap;
use super::search::ContactSearch;
use super::sweeps::NONE;
use crate::kernel::interaction::InteractionLaw;
use crate::kernel::lists::Memory;
use crate::state::EffectId;
use crate::state::archive::Persist;

/// Two surfaces that may come into contact, or one with self-contact.
#[derive(Clone, Debug, Default, Persist, Memory)]
#[persist(derived: id, number, name, secondary, other, analytical, law, springs, of_points, first, thickness,
    initial_clearance, is_near, is_active, is_cohesive, search, facet_gaps, first_key, end_key)]
#[memory(uncounted: name)]
pub struct ContactPair {
    /// Row of the ledger.
    pub id: EffectId,
    /// Number among the pairs of all steps.
    pub number: usize,
    /// Name of the pair in warnings.
    pub name: String,
    /// Index of the curve whose points carry pressures, called the own curve of the pair.
    pub secondary: usize,
    /// Index of the other curve; `None` for self-contact and for an analytical surface.
    pub other: Option<usize>,
    /// Index of the analytical surface, if the other surface is one.
    pub analytical: Option<usize>,
    /// Index of the law of the pair; with penalty springs, the index of the first spring: each point of the own curve
    /// has one.
    pub law: usize,
    /// Whether the pair has penalty springs.
    pub springs: bool,
    /// Index of the law of single points, whose multipliers are impulses instead of pressures. It is not a spring.
    pub of_points: usize,
    /// Whether the own curve is the first surface of the pair in the deck; output forces are those on the first
    /// surface.
    pub first: bool,
    /// Smallest thickness of the deformable elements at both surfaces; infinite without any, and in
    /// self-contact.
    pub thickness: f64,
    /// Clearance at the start, if the deck gives one.
    pub initial_clearance: Option<InitialClearance>,
    /// Energy that the pair has stored and dissipated in its normal direction.
    pub absorbed: f64,
    /// Largest energy that a row has released in an increment, and its coordinates.
    pub largest_release: (f64, [f64; 2]),
    /// Whether the surfaces have been in contact: then their impacts no longer limit the increment.
    pub(super) has_touched: bool,
    /// Whether the last search found candidates; otherwise there are no gaps.
    pub(super) is_near: bool,
    /// Whether the surfaces have been near each other; only then the pair has lists and gaps.
    pub(super) is_active: bool,
    /// Whether the surfaces have cohesive behaviour. Bonds act at any distance.
    pub(super) is_cohesive: bool,
    pub(super) search: ContactSearch,
    pub(super) facet_gaps: Vec<FacetGap>,
    /// First key of the pair; each point of the own curve has one.
    pub(super) first_key: u32,
    /// End of the keys of the pair.
    pub(super) end_key: u32,
}

impl ContactPair {
    /// Creates a pair of two curves, or of one curve with itself, with the first law of the contact. `length` is the
    /// smaller of the longest facets of both.
    pub fn new(id: EffectId, number: usize, [secondary, other]: [usize; 2], length: f64) -> ContactPair {
        ContactPair {
            id,
            number,
            secondary,
            other: (secondary != other).then_some(other),
            first: true,
            thickness: f64::INFINITY,
            search: ContactSearch::new(length),
            ..ContactPair::default()
        }
    }

    /// Creates a pair of a curve and an analytical surface.
    pub fn in_front_of(id: EffectId, number: usize, secondary: usize, analytical: usize, length: f64) -> ContactPair {
        ContactPair { analytical: Some(analytical), ..ContactPair::new(id, number, [secondary, secondary], length) }
    }

    /// Makes the pair active: allocates its candidates and gaps.
    pub(super) fn activate(&mut self, curves: &[FacetCurve]) {
        self.is_active = true;
        if self.analytical.is_none() {
            self.reserve(curves);
            self.facet_gaps = vec![FacetGap::default(); curves[self.secondary].facets.len()];
        }
    }

    /// Allocates the candidates.
    pub(super) fn reserve(&mut self, curves: &[FacetCurve]) {
        let other = self.other.unwrap_or(self.secondary);
        self.search.reserve(curves[self.secondary].facets.len(), curves[other].facets.len());
    }

    /// Completes a search: a pair without candidates has no gaps, and is not measured. Returns whether it has candidates.
    pub(super) fn end_search(&mut self) -> bool {
        let was_near = std::mem::replace(&mut self.is_near, self.search.has_candidates());
        if was_near && !self.is_near {
            self.facet_gaps.fill(FacetGap::default());
        }
        self.is_near
    }

    /// Selects the close candidates of facets while each point moves by at most `motion`. The other facets have no gaps.
    pub(super) fn select_close(&mut self, curves: &[FacetCurve], motion: f64) {
        for &k in &self.search.close.facets {
            self.facet_gaps[k as usize] = FacetGap::default();
        }
        let other = self.other.map(|other| &curves[other]);
        self.search.select_close(&curves[self.secondary], other, motion);
    }

    /// Returns the keys of the pair.
    pub(super) fn keys(&self) -> Range<usize> {
        self.first_key as usize..self.end_key as usize
    }

    /// Returns the identity of the pair in the deck: its number, and whether the own curve is its first surface.
    pub(super) fn identity(&self) -> (usize, bool) {
        (self.number, self.first)
    }

    /// Returns whether the pair and one of a previous contact are the same pair of the deck.
    pub(super) fn continues(&self, previous: &ContactPair) -> bool {
        self.identity() == previous.identity()
    }

    /// Returns the key of a point of the own curve; [`NONE`] for other points.
    pub(super) fn key_of(&self, own: &FacetCurve, point: u32) -> u32 {
        own.points.binary_search(&point).map_or(NONE, |index| self.first_key + index as u32)
    }

    /// Returns the index of the law of an own point.
    pub(super) fn law_of(&self, index: usize) -> u32 {
        (if self.springs { self.law + index } else { self.law }) as u32
    }

    /// Returns the gap at which the pressure of soft contact begins; `None` for hard contact. An initial clearance shifts
    /// the gaps of each point, so that pressure may begin at any gap.
    pub(super) fn onset_gap(&self, laws: &[InteractionLaw]) -> Option<f64> {
        let law = &laws[self.law_of(0) as usize];
        let gap = if self.measures_closed_parts() { law.overclosure.onset_gap() } else { f64::INFINITY };
        law.is_soft().then_some(gap)
    }

    /// Returns whether soft contact of this pair leaves out the parts of facets without pressure.
    pub(super) fn measures_closed_parts(&self) -> bool {
        self.analytical.is_none() && self.initial_clearance.is_none()
    }
}

/// Clearance that replaces the initial gaps within a range. The difference is subtracted from the gap in the whole
/// analysis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialClearance {
    /// Clearance that replaces the geometric gap; negative for an overlap.
    pub gap: f64,
    /// Smallest and largest geometric gap that is replaced; overlaps are negative.
    pub range: [f64; 2],
}

/// Returns the index of the pair that a key belongs to.
pub(super) fn pair_of(pairs: &[ContactPair], key: u32) -> usize {
    pairs.partition_point(|pair| pair.first_key <= key) - 1
}
