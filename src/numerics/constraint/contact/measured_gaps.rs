//! The gaps of an increment: weighted gaps of facets, gaps of single points and of points on analytical surfaces, and the
//! contact rows that they make.

use super::analytical::ClosestPoint;
use super::curve::{FacetCurve, PointKind};
use super::gaps::{GapIntegrator, SinglePoint};
use super::keys::KeyValues;
use super::pairs::ContactPair;
use super::surfaces::ContactSurfaces;
use super::sweeps::{ContactRow, ContactRows};
use crate::kernel::interaction::InteractionLaw;
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::Memory;
use crate::state::energies::ImpactKind;

/// Part of the area of a hat function that the other surface must cover in hard contact. A smaller part does not
/// determine the pressure: a sliver of a hundredth of a facet moves with the rest of the facet. Pressures of soft contact
/// follow from overlaps.
const LEAST_COVER: f64 = 1e-4;

/// Overlap of a corner at which its row begins to act, as a fraction of the facet length of the pair. Less is left to
/// the weighted gaps, which are equivalent where the edges of both surfaces coincide.
const CORNER_OVERLAP: f64 = 1e-9;

/// Gaps of all pairs, and the contact rows that they make.
#[derive(Clone, Debug, Default, Memory)]
pub(super) struct MeasuredGaps {
    pub(super) facets: GapIntegrator,
    pub(super) rows: ContactRows,
    /// Points of analytical surfaces that rows are in contact with in this increment.
    pub(super) closest: Vec<ClosestPoint>,
}

/// What gaps between facets are measured from.
#[derive(Clone, Copy)]
pub(super) struct GapSources<'a> {
    pub(super) surfaces: &'a ContactSurfaces,
    pub(super) laws: &'a [InteractionLaw],
    pub(super) keys: &'a KeyValues,
    /// Degrees of freedom of each point.
    pub(super) dofs_of: &'a [[u32; 2]],
}

/// A point in contact by itself, and the opposite curve with the candidates of its facets.
struct SinglePointContact<'a> {
    curve: &'a FacetCurve,
    /// Index of the point in `curve`.
    index: u32,
    key: u32,
    kind: PointKind,
    opposite: &'a FacetCurve,
    candidates: &'a [u32],
}

impl MeasuredGaps {
    pub(super) fn clear(&mut self) {
        self.facets.clear();
        self.rows.clear();
        self.closest.clear();
    }

    /// Adds the rows of a pair of two curves, or of one curve in self-contact.
    pub(super) fn measure_pair(&mut self, pair: &mut ContactPair, sources: GapSources<'_>) {
        let GapSources { surfaces, laws, .. } = sources;
        let (secondary, other) = surfaces.sides(pair);
        let (onset, reach) = (pair.onset_gap(laws), pair.search.reach());
        let mut is_near = false;
        let close = std::mem::take(&mut pair.search.close);
        for (at, &k) in close.facets.iter().enumerate() {
            let candidates = close.candidates.of(at);
            let gaps = self.facets.facet_gap((secondary, k as usize), other, candidates, reach, onset);
            is_near |= gaps.area != [0.0; 2];
            pair.facet_gaps[k as usize] = gaps;
        }
        if is_near {
            if onset.is_some() {
                close.points.iter().for_each(|&index| self.leave_out_open_facet(pair, secondary, index as usize));
            } else if pair.initial_clearance.is_none() {
                secondary.kinks.iter().for_each(|&index| self.leave_out_open_side(pair, secondary, index as usize));
            }
            close.points.iter().for_each(|&index| self.add_row(pair, secondary, index as usize, sources));
        }
        pair.search.close = close;
        self.measure_single_points(pair, onset.is_some(), sources);
    }

    /// Adds the rows of the points of a pair that are in contact by themselves.
    fn measure_single_points(&mut self, pair: &ContactPair, is_soft: bool, sources: GapSources<'_>) {
        let (secondary, other) = sources.surfaces.sides(pair);
        for (at, &index) in secondary.orphans.iter().enumerate() {
            let (key, candidates) = (pair.first_key + index, pair.search.orphans.of(at));
            let point =
                SinglePointContact { curve: secondary, index, key, kind: PointKind::Free, opposite: other, candidates };
            self.add_point_row(pair, point, sources);
        }
        // In self-contact the single points have been added above.
        let others = pair.other.is_some().then_some(other);
        for (at, (index, kind)) in others.into_iter().flat_map(FacetCurve::single_points).enumerate() {
            let (key, candidates) = (pair.first_key + secondary.points.len() as u32 + index, pair.search.others.of(at));
            // The area that a corner covers is part of the energy of soft contact.
            if kind == PointKind::Corner && is_soft {
                continue;
            }
            let point = SinglePointContact { curve: other, index, key, kind, opposite: secondary, candidates };
            self.add_point_row(pair, point, sources);
        }
    }

    /// Adds the row of one point from the gaps of the facets around it.
    fn add_row(&mut self, pair: &ContactPair, own: &FacetCurve, index: usize, sources: GapSources<'_>) {
        let GapSources { laws, keys, dofs_of, .. } = sources;
        let mut row = ContactRow::of(pair.first_key + index as u32, pair.law_of(index));
        let facets = || own.exposed_around(index);
        for &(facet, end) in facets() {
            let (gaps, end) = (&pair.facet_gaps[facet as usize], end as usize);
            row.area += gaps.area[end];
            row.gap += gaps.gap[end];
        }
        let law = &laws[row.law as usize];
        if row.area <= 0.0 || !law.is_soft() && row.area <= LEAST_COVER * own.hat_area(index) {
            return;
        }
        if let Some(offset) = keys.gap_offsets.get(row.key as usize) {
            row.gap -= offset * row.area;
        }
        let MeasuredGaps { facets: integrator, rows, .. } = self;
        rows.open();
        for &(facet, end) in facets() {
            let shares = integrator.shares_of(&pair.facet_gaps[facet as usize]);
            if shares.iter().any(|share| sources.surfaces.is_on_new_face(share.point)) {
                row.impact = ImpactKind::ClosingGap;
            }
            rows.add_shares(shares.iter().map(|share| (share.point, share.of[end as usize])), dofs_of);
            for share in integrator.edges_of(&pair.facet_gaps[facet as usize]) {
                let factor = law.overclosure.change_by_cover(-row.gap / row.area, share.overlap);
                let derivatives = share.of[end as usize].inline_map(|cover| factor * cover);
                rows.add_normal_share(dofs_of[share.point as usize], derivatives);
            }
        }
        rows.close(row);
    }

    /// Leaves out the open facet of a point in soft contact if its other facet has pressure.
    fn leave_out_open_facet(&mut self, pair: &mut ContactPair, own: &FacetCurve, index: usize) {
        let &[a, b] = own.around_own(index) else { return };
        let has_pressure = [a, b].inline_map(|(facet, end)| {
            let gaps = &pair.facet_gaps[facet as usize];
            gaps.is_closed && gaps.area[end as usize] > 0.0 && own.is_exposed[facet as usize]
        });
        let (facet, end) = match has_pressure {
            [true, false] => b,
            [false, true] => a,
            _ => return,
        };
        self.facets.leave_out(&mut pair.facet_gaps[facet as usize], end as usize);
    }

    /// Leaves out one facet at a kink of the own surface if the other surface follows only the other facet: the mean gap of
    /// both would be open although one side overlaps. The criterion is half the opening that the kink gives to a plane
    /// surface on one facet: over the hat function, a third of the facet length times the angle.
    fn leave_out_open_side(&mut self, pair: &mut ContactPair, own: &FacetCurve, index: usize) {
        let &[a, b] = own.around_own(index) else { return };
        let is_measured = |&(facet, end): &(u32, u8)| {
            pair.facet_gaps[facet as usize].area[end as usize] > 0.0 && own.is_exposed[facet as usize]
        };
        if ![a, b].iter().all(is_measured) {
            return;
        }
        let gaps = [a, b].inline_map(|(facet, end)| pair.facet_gaps[facet as usize].mean_gap(end as usize));
        let [closed, open] = if gaps[0] <= gaps[1] { [0, 1] } else { [1, 0] };
        let facets = [a.0, b.0];
        let [flat, shape] = [closed, open].inline_map(|side: usize| &own.shapes[facets[side] as usize]);
        let angle = (flat.normal[0] * shape.normal[1] - flat.normal[1] * shape.normal[0]).abs();
        if gaps[open] - gaps[closed] > angle * shape.length / 6.0 {
            let (facet, end) = [a, b][open];
            self.facets.leave_out(&mut pair.facet_gaps[facet as usize], end as usize);
        }
    }

    /// Adds the row of a single point: its area is one, its multiplier an impulse. A corner is in contact if it pressed in
    /// the previous increment, or if its overlap is larger than [`CORNER_OVERLAP`]. Equation (10.10).
    fn add_point_row(&mut self, pair: &ContactPair, contact: SinglePointContact<'_>, sources: GapSources<'_>) {
        let SinglePointContact { curve, index, key, kind, opposite, candidates } = contact;
        let is_corner = kind == PointKind::Corner;
        if candidates.is_empty() {
            return;
        }
        let normals = if is_corner { curve.normals_around(index as usize) } else { None };
        if is_corner && normals.is_none() {
            return;
        }
        let (GapSources { surfaces, keys, dofs_of, .. }, point) = (sources, curve.points[index as usize]);
        let half_thickness =
            if opposite.is_side_of_line { curve.half_thickness_around(index as usize) } else { f64::INFINITY };
        let position = surfaces.places[point as usize];
        let single = SinglePoint { point, place: position, normals, half_thickness };
        let Some((mut gaps, facet)) = self.facets.point_gap(single, opposite, candidates, pair.search.reach()) else {
            return;
        };
        if is_corner {
            gaps.gap[0] += accepted_overlap(pair, opposite, facet, keys);
            let is_pressed = keys.pressures[key as usize][0] > 0.0;
            if !is_pressed && gaps.gap[0] > -CORNER_OVERLAP * pair.search.length {
                return;
            }
        }
        self.rows.open();
        let shares = self.facets.shares_of(&gaps).iter().map(|share| (share.point, share.of[0]));
        self.rows.add_shares(shares, dofs_of);
        let mut row = ContactRow::of(key, pair.of_points as u32);
        (row.is_single_point, row.area, row.gap) = (true, gaps.area[0], gaps.gap[0]);
        let meets_new_face = || self.facets.shares_of(&gaps).iter().any(|share| surfaces.is_on_new_face(share.point));
        row.impact = match kind {
            PointKind::Free => ImpactKind::FreePoint,
            _ if meets_new_face() => ImpactKind::ClosingGap,
            _ => ImpactKind::FirstTouch,
        };
        if is_corner {
            let neighbours = opposite.facets[facet as usize].inline_map(|point| pair.key_of(opposite, point));
            self.rows.close_after(row, neighbours);
        } else {
            self.rows.close(row);
        }
    }
}

/// Returns the overlap that the initial clearances of an own facet accept.
fn accepted_overlap(pair: &ContactPair, own: &FacetCurve, facet: u32, keys: &KeyValues) -> f64 {
    let offset = |point: u32| keys.gap_offsets.get(pair.key_of(own, point) as usize).copied();
    own.facets[facet as usize].into_iter().filter_map(offset).fold(0.0, |accepted, offset| accepted.max(-offset))
}
