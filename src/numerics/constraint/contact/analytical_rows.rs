//! Contact of points with analytical surfaces as part of the contact: rows, gaps on arcs, forces, and places on the surfaces;
//! see `analytical.rs`.

use super::analytical::{AnalyticalSurface, ClosestPoint, PointPath};
use super::curve::PointCarrier;
use super::dofs::ContactDofs;
use super::measured_gaps::MeasuredGaps;
use super::shown::SurfaceForces;
use super::sweeps::{ContactInterval, ContactRow, ContactRows, ContactStep, NONE};
use super::{ContactConstraint, ContactPair};
use crate::kernel::interaction::PressureOverclosure;
use crate::kernel::lanes::InlineMap;
use crate::kernel::profile::ProfileSegment;
use crate::kernel::shape::distance;
use crate::state::dofs::Dofs;

/// Smallest squared part of a normal in unconstrained directions. Below it a node would have to be pushed along the
/// surface, and its row is left out.
const LEAST_SHARE: f64 = 1e-3;
/// Largest gap or overlap of a node in contact, in units of an edge.
const TOUCHING: f64 = 0.02;
/// Largest number of gap updates on arcs.
const ROUNDS: usize = 12;

/// A segment of an analytical surface that a point may be in contact with.
struct MetSegment {
    segment: usize,
    /// Gap that the point keeps; negative for an existing overlap.
    target: f64,
    key: u32,
}

impl ContactConstraint {
    /// Adds the rows of a pair with an analytical surface for an increment of length `dt`. A length of zero is used at
    /// the start, to report initial overlaps.
    pub(super) fn measure_analytical(&mut self, pair_index: usize, dt: f64) {
        let ContactConstraint { surfaces, pairs, laws, dofs, keys, measured, .. } = self;
        let ContactDofs { of_points: dofs_of, motion, merged, .. } = &*dofs;
        let pair = &pairs[pair_index];
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
        let is_coupled = pairs.len() > 1 || motion.inverse_mass[body] > 0.0 || !merged.is_empty();
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
                row.closest_point = Some(measured.closest.len() as u32);
                (row.is_single_point, row.area, row.gap) = (is_single_point, area, area * (gap - target - closes));
                let (segment, target) = (segment as u32, zero + target);
                measured.closest.push(ClosestPoint { analytical: which, segment, point, target });
                measured.rows.open();
                measured.rows.add_share(point_dofs, normal.inline_map(|n| area * n));
                measured.rows.add_share(body_dofs, normal.inline_map(|n| -area * n));
                measured.rows.close(row);
            }
        }
    }

    /// Updates the gaps on arcs until all rows under pressure end on their arcs; velocity errors are relative to
    /// `reference`.
    pub(super) fn correct_arc_gaps(&mut self, reference: f64, span: ContactInterval) {
        let is_arc = |segment: &ProfileSegment| matches!(segment, ProfileSegment::Arc(..));
        if !self.surfaces.analyticals.iter().any(|surface| surface.profile.segments.iter().any(is_arc)) {
            return;
        }
        for _ in 0..ROUNDS {
            if self.correct_gaps(span.dt) <= 1e-3 {
                return;
            }
            let ContactConstraint { laws, dofs, keys, measured, .. } = self;
            let step = ContactStep { laws, pressures: &keys.pressures, span };
            measured.rows.solve_again(&mut dofs.motion, reference, step);
        }
    }

    /// Corrects the gaps of rows under pressure; returns the largest correction over the rounding of coordinates.
    fn correct_gaps(&mut self, dt: f64) -> f64 {
        let ContactConstraint { surfaces, dofs, measured, .. } = self;
        let MeasuredGaps { rows: ContactRows { rows, terms, .. }, closest, .. } = measured;
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

    /// Adds the forces of pressure and of friction on the own surface of a pair with an analytical one.
    pub(super) fn add_forces_of_rows(&self, pair: &ContactPair, sum: &mut SurfaceForces) {
        let (keys, MeasuredGaps { rows, closest, .. }) = (pair.keys(), &self.measured);
        for row in rows.rows.iter().filter(|row| keys.contains(&(row.key as usize)) && row.acts()) {
            let [pressure, shear] = self.stresses(row.key as usize);
            let Some(closest) = row.closest_point.map(|index| closest[index as usize]) else { continue };
            let point_dofs = self.dofs.of_points[closest.point as usize];
            for term in rows.terms_of(row) {
                if let Some(axis) = point_dofs.iter().position(|dof| *dof == term.dof) {
                    sum.pressure[axis] += pressure * term.normal;
                    sum.friction[axis] += shear * term.slip;
                }
            }
        }
    }

    /// Returns the closest place to `place` on the only analytical surface of a point, at the start of an increment of which
    /// only the motion of bodies has been made; `None` without one. In soft contact it is the closest place with the gap that
    /// the material has there.
    pub fn place_on_surface(&self, carrier: PointCarrier, place: [f64; 2], dofs: &Dofs) -> Option<[f64; 2]> {
        let point = self.surfaces.point_on(carrier)?;
        let analytical_pairs = self.pairs.iter().filter(|pair| pair.analytical.is_some());
        let index_in = |pair: &ContactPair| self.surfaces.curves[pair.secondary].points.binary_search(&point).ok();
        let mut pairs = analytical_pairs.filter_map(|pair| Some((pair, index_in(pair)?)));
        let (Some((pair, index)), None) = (pairs.next(), pairs.next()) else { return None };
        let analytical = &self.surfaces.analyticals[pair.analytical?];
        let lift = self.surfaces.place_of(analytical.point, dofs, 0.0)[1];
        let gap = if self.laws[pair.law_of(index) as usize].is_soft() {
            self.gap_along_facets(pair, index, place, dofs)?
        } else {
            0.0
        };
        analytical.place_at(self.zero_of(analytical, index, pair.first_key as usize + index) + gap, place, lift)
    }

    /// Returns the gap to an analytical surface at the new place of a point that slides along its facets: between the gaps
    /// of the point and of the next one. `None` beyond the ends of the surface.
    fn gap_along_facets(&self, pair: &ContactPair, index: usize, place: [f64; 2], dofs: &Dofs) -> Option<f64> {
        let (analytical, secondary) =
            (&self.surfaces.analyticals[pair.analytical?], &self.surfaces.curves[pair.secondary]);
        let place_of = |point: u32| self.surfaces.place_of(point, dofs, 0.0);
        let lift = place_of(analytical.point)[1];
        let gap = |index: usize| {
            let nearest = analytical.profile.nearest(place_of(secondary.points[index]), lift);
            let zero = self.zero_of(analytical, index, pair.first_key as usize + index);
            (!nearest.beyond).then_some(nearest.gap - zero)
        };
        let start = gap(index)?;
        let Some((next, share)) = secondary.next_point(index, place, place_of) else { return Some(start) };
        let end = secondary.points.binary_search(&next).ok().and_then(gap).unwrap_or(start);
        Some(start + share * (end - start))
    }

    /// Returns the distance from the profile that is gap zero at a point.
    fn zero_of(&self, analytical: &AnalyticalSurface, index: usize, key: usize) -> f64 {
        analytical.lift[index] + self.keys.gap_offset(key)
    }

    /// Returns the place of a new node on the edge between two nodes of a surface that is in contact with an analytical
    /// one: on a curved surface the edge is not on it. Between two nodes in contact the new node has the gap between
    /// theirs, and others do not overlap. `None` if the node may remain on the edge.
    pub fn place_between(&self, ends: [usize; 2], share: f64, dofs: &Dofs) -> Option<[f64; 2]> {
        let end_places = ends.inline_map(|node| dofs.nodes[node].place());
        let edge = distance(end_places[0], end_places[1]);
        let start = [0, 1].inline_map(|i: usize| end_places[0][i] + share * (end_places[1][i] - end_places[0][i]));
        let surfaces = &self.surfaces;
        self.pairs.iter().find_map(|pair| {
            let analytical = &surfaces.analyticals[pair.analytical?];
            let PointCarrier::Body(body, [_, z]) = surfaces.points[analytical.point as usize].carrier else {
                return None;
            };
            let (own_points, lift) = (&surfaces.curves[pair.secondary].points, z + dofs.bodies[body].displacement);
            let is_at =
                |node: usize| move |point: &u32| surfaces.points[*point as usize].carrier == PointCarrier::Node(node);
            let [first, second] = ends.inline_map(|node| own_points.iter().position(is_at(node)));
            let zeros = [first?, second?].inline_map(|i| self.zero_of(analytical, i, pair.first_key as usize + i));
            let gap = |place: [f64; 2], zero: f64| {
                let nearest = analytical.profile.nearest(place, lift);
                (!nearest.beyond).then_some(nearest.gap - zero)
            };
            let zero = zeros[0] + share * (zeros[1] - zeros[0]);
            let end_gaps = [gap(end_places[0], zeros[0])?, gap(end_places[1], zeros[1])?];
            let (start_gap, mean_gap) = (gap(start, zero)?, end_gaps[0] + share * (end_gaps[1] - end_gaps[0]));
            let touches = end_gaps.iter().all(|gap| gap.abs() <= TOUCHING * edge);
            let moves = if touches { start_gap != mean_gap } else { start_gap < mean_gap.min(0.0) };
            let target = zero + if touches { mean_gap } else { mean_gap.min(0.0) };
            if moves { analytical.place_at(target, start, lift) } else { None }
        })
    }
}
