//! Rows of points in front of analytical surfaces, and their gaps on arcs; see `analytical.rs`.

use super::analytical::{ClosestPoint, PointPath};
use super::dofs::ContactDofs;
use super::keys::KeyValues;
use super::measured_gaps::MeasuredGaps;
use super::pairs::ContactPair;
use super::surfaces::ContactSurfaces;
use super::sweeps::{ContactRow, ContactRows, ContactStep, NONE};
use crate::kernel::interaction::{InteractionLaw, PressureOverclosure};
use crate::kernel::lanes::InlineMap;
use crate::kernel::profile::ProfileSegment;
use crate::state::energies::ImpactKind;

/// Smallest squared part of a normal in unconstrained directions. Below it a node would have to be pushed along the
/// surface, and its row is left out.
const LEAST_SHARE: f64 = 1e-3;
/// Largest number of gap updates on arcs.
const ROUNDS: usize = 12;

/// A segment of an analytical surface that a point may be in contact with.
struct MetSegment {
    segment: usize,
    /// Gap that the point keeps; negative for an existing overlap.
    target: f64,
    key: u32,
}

impl MeasuredGaps {
    /// Adds the rows of a pair with an analytical surface for an increment of length `dt`. A length of zero is used at
    /// the start, to report initial overlaps.
    pub(super) fn measure_analytical(
        &mut self,
        pair: &ContactPair,
        surfaces: &ContactSurfaces,
        laws: &[InteractionLaw],
        dofs: &ContactDofs,
        keys: &mut KeyValues,
        dt: f64,
    ) {
        let ContactDofs { of_points: dofs_of, motion, merged, .. } = dofs;
        let Some((which, analytical)) = pair.analytical.and_then(|i| Some((i as u32, surfaces.analyticals.get(i)?)))
        else {
            return;
        };
        let secondary = &surfaces.curves[pair.secondary];
        let velocity_of = |point: u32| {
            dofs_of[point as usize].inline_map(|d| if d == NONE { 0.0 } else { motion.velocity[d as usize] })
        };
        let body_dofs = dofs_of[analytical.point as usize];
        let body = body_dofs[1] as usize;
        let (body_velocity, body_place) = (motion.velocity[body], surfaces.places[analytical.point as usize][1]);
        let lift = [body_place, body_place + dt * body_velocity];
        // Impulses of other rows may move points that are at rest now.
        let is_coupled = surfaces.pair_count() > 1 || motion.inverse_mass[body] > 0.0 || !merged.is_empty();
        let fastest = if is_coupled { motion.velocity.iter().fold(0.0_f64, |v, w| v.max(w.abs())) } else { 0.0 };
        let is_start = dt == 0.0;
        let orphans = secondary.orphans.iter().map(|&i| (i, true));
        for (index, is_single_point) in secondary.exposed_points.iter().map(|&i| (i, false)).chain(orphans) {
            let point = secondary.points[index as usize];
            let point_dofs = dofs_of[point as usize];
            if point_dofs[1] == body_dofs[1] {
                continue;
            }
            let (key, index) = (pair.first_key + index, index as usize);
            let impact = match is_single_point && secondary.loses_elements() {
                true => ImpactKind::FreePoint,
                false if surfaces.is_on_new_face(point) => ImpactKind::ClosingGap,
                false => ImpactKind::FirstTouch,
            };
            let law = if is_single_point { pair.of_points as u32 } else { pair.law_of(index) };
            let (start, velocity) = (surfaces.places[point as usize], velocity_of(point));
            let end = [0, 1].inline_map(|i| start[i] + dt * velocity[i]);
            let zero_of = |key: u32| analytical.lift[index] + keys.gap_offset(key as usize);
            let path = PointPath { start, end, lift, zero: zero_of(key) };
            let nearest = analytical.profile.nearest(end, lift[1]);
            let start_gap = analytical.profile.segments[nearest.segment].gap(start, lift[0]) - path.zero;
            let speed = velocity[0].abs() + velocity[1].abs() + body_velocity.abs();
            let overclosure = &laws[law as usize].overclosure;
            let is_hard = *overclosure == PressureOverclosure::Hard;
            // Soft overclosure laws may press before the end of the increment.
            let reach = if is_coupled || !is_hard { dt * (2.0 * fastest).max(speed) } else { 0.0 };
            let is_far = nearest.gap - path.zero >= reach + overclosure.onset_gap() && !is_start;
            let zeros = [zero_of(key), zero_of(key + secondary.points.len() as u32)];
            if start_gap < pair.search.reach() && !nearest.beyond {
                keys.set_opening(key, start_gap);
            }
            if nearest.beyond || is_far {
                continue;
            }
            let met = if is_start { Some((nearest.segment, 0.0)) } else { analytical.met(nearest.segment, &path) };
            let Some((segment, target)) = met else { continue };
            let area = if is_single_point { 1.0 } else { secondary.area(index, &surfaces.places) };
            let corner = if is_start { None } else { analytical.corner(segment, &path, (dt * speed).max(reach)) };
            let second =
                corner.map(|segment| MetSegment { segment, target: 0.0, key: key + secondary.points.len() as u32 });
            for (MetSegment { segment, target, key }, zero) in
                [Some(MetSegment { segment, target, key }), second].into_iter().flatten().zip(zeros)
            {
                let profile_segment = &analytical.profile.segments[segment];
                let normal = profile_segment.normal(start, lift[0]);
                if dofs.free_share(point_dofs, normal) < LEAST_SHARE {
                    continue;
                }
                // Penalty and other soft laws press at any depth.
                let target = if is_hard { target } else { 0.0 };
                let gap = profile_segment.gap(end, lift[1]) - zero;
                let closes = dt * (normal[0] * velocity[0] + normal[1] * (velocity[1] - body_velocity));
                let mut row = ContactRow::of(key, law);
                row.closest_point = Some(self.closest.len() as u32);
                (row.is_single_point, row.area, row.gap) = (is_single_point, area, area * (gap - target - closes));
                row.impact = impact;
                let (segment, target) = (segment as u32, zero + target);
                self.closest.push(ClosestPoint { analytical: which, segment, point, target });
                self.rows.open();
                self.rows.add_share(point_dofs, normal.inline_map(|n| area * n));
                self.rows.add_share(body_dofs, normal.inline_map(|n| -area * n));
                self.rows.close(row);
            }
        }
    }

    /// Updates the gaps on arcs until all rows under pressure end on their arcs; velocity errors are relative to
    /// `reference`.
    pub(super) fn correct_arc_gaps(
        &mut self,
        surfaces: &ContactSurfaces,
        dofs: &mut ContactDofs,
        reference: f64,
        step: ContactStep<'_>,
    ) {
        let is_arc = |segment: &ProfileSegment| matches!(segment, ProfileSegment::Arc(..));
        if !surfaces.analyticals.iter().any(|surface| surface.profile.segments.iter().any(is_arc)) {
            return;
        }
        for _ in 0..ROUNDS {
            if self.correct_gaps(surfaces, dofs, step.span.dt) <= 1e-3 {
                return;
            }
            self.rows.solve_again(&mut dofs.motion, reference, step);
        }
    }

    /// Corrects the gaps of rows under pressure; returns the largest correction over the rounding of coordinates.
    fn correct_gaps(&mut self, surfaces: &ContactSurfaces, dofs: &ContactDofs, dt: f64) -> f64 {
        let MeasuredGaps { rows: ContactRows { rows, terms, .. }, closest, .. } = self;
        // Returns the position of a point at the end of the increment.
        let end_of = |point: u32| {
            let (start, dofs_of) = (surfaces.places[point as usize], dofs.of_points[point as usize]);
            [0, 1].inline_map(|i| match dofs_of[i] {
                NONE => start[i],
                dof => start[i] + dt * dofs.motion.velocity[dof as usize],
            })
        };
        let mut largest: f64 = 0.0;
        for row in rows.iter_mut().filter(|row| row.normal_impulse > 0.0) {
            let Some(closest) = row.closest_point.map(|index| closest[index as usize]) else { continue };
            let analytical = &surfaces.analyticals[closest.analytical as usize];
            let segment = &analytical.profile.segments[closest.segment as usize];
            if let ProfileSegment::Line(_) = segment {
                continue;
            }
            let gap = segment.gap(end_of(closest.point), end_of(analytical.point)[1]) - closest.target;
            let rate = dofs.motion.rate(row.terms_in(terms));
            let error = gap - (row.gap + dt * rate) / row.area;
            row.gap += error * row.area;
            largest = largest.max(error.abs() / analytical.rounding);
        }
        largest
    }
}
