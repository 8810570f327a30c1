//! Contact of points with analytical surfaces: one row for each point, two in a re-entrant corner of two segments.
//!
//! The gap of a row is evaluated at the end of the increment, along the normal at its start (constrained central
//! differences, Ryckaert, Ciccotti and Berendsen 1977, J. Comput. Phys. 23, 327). A point that slides along an arc
//! therefore keeps its speed and its distance. The gap is linearised about the position x* without contact, gap(x*) -
//! dt n.v*, and updated on arcs after the impulses have been applied.

use super::curve::{FacetCurve, PointCarrier};
use super::sweeps::{ContactInterval, ContactRow, ContactRows, ContactStep, ContactVelocities, NONE};
use super::{ContactConstraint, ContactPair};
use crate::kernel::interaction::PressureOverclosure;
use crate::kernel::lanes::InlineMap;
use crate::kernel::profile::{ProfileSegment, SurfaceProfile};
use crate::kernel::shape::distance;
use crate::state::dofs::Dofs;

/// An analytical surface on a rigid body, in contact with the own curve of a pair.
#[derive(Clone, Debug)]
pub struct AnalyticalSurface {
    /// The profile at the start; its contact side is on the left.
    pub profile: SurfaceProfile,
    /// The contact point that represents its body, at z = 0 at the start.
    pub point: u32,
    /// Rounding error of coordinates: a point behind the surface by less is on the surface.
    pub rounding: f64,
    /// Largest overlap at which a point is in contact.
    pub overlap: f64,
    /// Distance from each own point to its surface (half the thickness of shells).
    pub(super) lift: Vec<f64>,
    /// The segments that each segment meets in re-entrant corners.
    pub(super) corner_segments: Vec<[Option<usize>; 2]>,
}

/// The point of an analytical surface that a row is in contact with.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClosestPoint {
    analytical: u32,
    segment: u32,
    point: u32,
    /// Distance from the profile that is gap zero, initial overlap included.
    target: f64,
}

/// Motion of a point relative to the profile over an increment.
#[derive(Clone, Copy, Debug)]
struct PointPath {
    start: [f64; 2],
    end: [f64; 2],
    /// Displacement of the body at the start and at the end of the increment.
    lift: [f64; 2],
    /// Distance from the profile that is gap zero.
    zero: f64,
}

/// Smallest squared part of a normal in unconstrained directions. Below it a node would have to be pushed along the
/// surface, and its row is left out.
const LEAST_SHARE: f64 = 1e-3;
/// Number of projections onto a profile; one is exact within a segment.
const PROJECTIONS: usize = 2;
/// Largest gap or overlap of a node in contact, in units of an edge.
const TOUCHING: f64 = 0.02;
/// Largest number of gap updates on arcs.
const ROUNDS: usize = 12;

impl AnalyticalSurface {
    /// Creates a surface on the body that `point` represents.
    pub fn new(profile: SurfaceProfile, point: u32) -> AnalyticalSurface {
        let [low, high] = profile.bounds();
        let rounding = 1e-9 * low[1].abs().max(high[1].abs()).max(high[0] - low[0]);
        let beside = (0..profile.segments.len()).map(|k| profile.reentrant_neighbors(k)).collect();
        AnalyticalSurface { profile, point, rounding, overlap: rounding, lift: Vec::new(), corner_segments: beside }
    }

    /// Returns the closest place with a distance from the profile of a body that has moved by `lift`.
    fn place_at(&self, target: f64, mut place: [f64; 2], lift: f64) -> Option<[f64; 2]> {
        for _ in 0..PROJECTIONS {
            let nearest = self.profile.nearest(place, lift);
            if nearest.beyond {
                return None;
            }
            let (normal, off) = (self.profile.segments[nearest.segment].normal(place, lift), nearest.gap - target);
            place = [0, 1].inline_map(|i| place[i] - off * normal[i]);
        }
        Some(place)
    }

    /// Returns whether points may be in contact with two segments at once.
    pub(super) fn has_corners(&self) -> bool {
        self.corner_segments.iter().flatten().any(Option::is_some)
    }

    /// Returns the segment that a point is in contact with, and its gap. If the point was in front of the surface but
    /// behind this segment, the segment is around a corner, and the previous segment counts.
    fn met(&self, segment: usize, path: &PointPath) -> Option<(usize, f64)> {
        let gap = |k: usize| self.profile.segments[k].gap(path.start, path.lift[0]) - path.zero;
        let start_gap = gap(segment);
        if start_gap >= -self.rounding {
            return Some((segment, 0.0));
        }
        let start_nearest = self.profile.nearest(path.start, path.lift[0]);
        if start_nearest.gap - path.zero >= -self.rounding {
            return (gap(start_nearest.segment) >= -self.rounding).then_some((start_nearest.segment, 0.0));
        }
        (start_gap > -self.overlap).then_some((segment, start_gap))
    }

    /// Returns a second segment that the point may be in contact with in a re-entrant corner.
    fn corner(&self, segment: usize, path: &PointPath, reach: f64) -> Option<usize> {
        let near = |k: &usize| {
            let other = &self.profile.segments[*k];
            let gap = other.gap(path.end, path.lift[1]) - path.zero;
            let away = |end: &[f64; 2]| libm::hypot(path.end[0] - end[0], path.end[1] - end[1] - path.lift[1]);
            let beside = other.side_of(path.end, path.lift[1]) == 0
                || other.ends().iter().map(away).fold(f64::INFINITY, f64::min) <= reach + path.zero.abs();
            gap < reach && beside && other.gap(path.start, path.lift[0]) - path.zero >= -self.rounding
        };
        self.corner_segments[segment].into_iter().flatten().find(near)
    }
}

impl ContactConstraint {
    /// Adds the rows of a pair with an analytical surface for an increment of length `dt`. A length of zero is used at
    /// the start, to report initial overlaps.
    pub(super) fn measure_analytical(&mut self, at: usize, dt: f64) {
        let ContactConstraint {
            curves,
            pairs,
            analyticals,
            rows,
            feet,
            dofs_of,
            motion,
            places,
            gap_offsets: fits,
            laws,
            shown,
            dofs,
            merged,
            ..
        } = self;
        let pair = &pairs[at];
        let Some((which, analytical)) = pair.analytical.and_then(|i| Some((i as u32, analyticals.get(i)?))) else {
            return;
        };
        let own = &curves[pair.own];
        let velocity_of = |point: u32| {
            dofs_of[point as usize].inline_map(|d| if d == NONE { 0.0 } else { motion.velocity[d as usize] })
        };
        let [_, body] = dofs_of[analytical.point as usize];
        let (carried, before) = (motion.velocity[body as usize], places[analytical.point as usize][1]);
        let lift = [before, before + dt * carried];
        // Impulses of other rows may move points that are at rest now.
        let coupled = pairs.len() > 1 || motion.inverse_mass[body as usize] > 0.0 || !merged.is_empty();
        let fastest = if coupled { motion.velocity.iter().fold(0.0_f64, |v, w| v.max(w.abs())) } else { 0.0 };
        let opens = pair.search.reach();
        let alone = own.orphans.iter().map(|&i| (i, true));
        for (index, alone) in own.exposed_points.iter().map(|&i| (i, false)).chain(alone) {
            let point = own.own[index as usize];
            if dofs_of[point as usize][1] == body {
                continue;
            }
            let (key, law) =
                (pair.first_key + index, if alone { pair.of_points as u32 } else { pair.law_of(index as usize) });
            let fit = |key: u32| fits.get(key as usize).copied().unwrap_or(0.0);
            let (start, velocity) = (places[point as usize], velocity_of(point));
            let end = [0, 1].inline_map(|i| start[i] + dt * velocity[i]);
            let mut path = PointPath { start, end, lift, zero: analytical.lift[index as usize] + fit(key) };
            let nearest = analytical.profile.nearest(end, lift[1]);
            let apart = analytical.profile.segments[nearest.segment].gap(start, lift[0]) - path.zero;
            if apart < opens && !nearest.beyond {
                shown.opening[key as usize] = apart;
            }
            let speed = velocity[0].abs() + velocity[1].abs() + carried.abs();
            let overclosure = &laws[law as usize].overclosure;
            let hard = *overclosure == PressureOverclosure::Hard;
            // Soft overclosure laws may press before the end of the increment.
            let reach = if coupled || !hard { dt * (2.0 * fastest).max(speed) } else { 0.0 };
            let begins = overclosure.onset_gap();
            let starts = dt == 0.0;
            if nearest.beyond || nearest.gap - path.zero >= reach + begins && !starts {
                continue;
            }
            let met = if starts { Some((nearest.segment, 0.0)) } else { analytical.met(nearest.segment, &path) };
            let Some((segment, target)) = met else { continue };
            let area = if alone { 1.0 } else { own.area(index as usize, places) };
            let second = || analytical.corner(segment, &path, (dt * speed).max(reach)).map(|k| (k, 0.0));
            let second = if starts { None } else { second() };
            let both = [(Some((segment, target)), key), (second, key + own.own.len() as u32)];
            for (met, key) in both {
                let Some((segment, target)) = met else { continue };
                path.zero = analytical.lift[index as usize] + fit(key);
                let met = &analytical.profile.segments[segment];
                let (n, gap) = (met.normal(start, lift[0]), met.gap(end, lift[1]) - path.zero);
                // Penalty and other soft laws press at any depth.
                let target = if hard { target } else { 0.0 };
                let [r, z] = dofs_of[point as usize];
                let part = |dof: u32, n: f64| if dof == NONE || dofs[dof as usize].1 { 0.0 } else { n * n };
                if part(r, n[0]) + part(z, n[1]) < LEAST_SHARE {
                    continue;
                }
                let closes = dt * (n[0] * velocity[0] + n[1] * (velocity[1] - carried));
                let mut row = ContactRow::of(key, law);
                row.closest_point = Some(feet.len() as u32);
                (row.is_single_point, row.area, row.gap) = (alone, area, area * (gap - target - closes));
                let target = path.zero + target;
                feet.push(ClosestPoint { analytical: which, segment: segment as u32, point, target });
                rows.open();
                rows.add_share([r, z], [area * n[0], area * n[1]]);
                rows.add_share(dofs_of[analytical.point as usize], [-area * n[0], -area * n[1]]);
                rows.close(row);
            }
        }
    }

    /// Updates the gaps on arcs until all rows under pressure end on their arcs; velocity errors are relative to
    /// `reference`.
    pub(super) fn correct_arc_gaps(&mut self, reference: f64, span: ContactInterval) {
        if !self.analyticals.iter().any(|a| a.profile.segments.iter().any(|s| matches!(s, ProfileSegment::Arc(..)))) {
            return;
        }
        for _ in 0..ROUNDS {
            if self.correct_gaps(span.dt) <= 1e-3 {
                return;
            }
            let ContactConstraint { rows, motion, laws, pressures, .. } = self;
            rows.solve_again(motion, reference, ContactStep { laws, before: pressures, span });
        }
    }

    /// Corrects the gaps of rows under pressure; returns the largest correction over the rounding of coordinates.
    fn correct_gaps(&mut self, dt: f64) -> f64 {
        let ContactConstraint { rows, feet, analyticals, motion, places, dofs_of, .. } = self;
        let ContactRows { rows, terms, .. } = rows;
        let mut off: f64 = 0.0;
        for row in rows.iter_mut().filter(|row| row.normal_impulse > 0.0) {
            let Some(foot) = row.closest_point.map(|f| feet[f as usize]) else { continue };
            let analytical = &analyticals[foot.analytical as usize];
            let segment = &analytical.profile.segments[foot.segment as usize];
            if let ProfileSegment::Line(_) = segment {
                continue;
            }
            let moved = |point: u32| end_of(point, places, dofs_of, motion, dt);
            let gap = segment.gap(moved(foot.point), moved(analytical.point)[1]) - foot.target;
            let rate = motion.rate(row.own(terms));
            let error = gap - (row.gap + dt * rate) / row.area;
            row.gap += error * row.area;
            off = off.max(error.abs() / analytical.rounding);
        }
        off
    }

    /// Returns the forces of pressure and of friction on the own surface of a pair with an analytical one.
    pub(super) fn forces_of_rows(&self, pair: &ContactPair) -> [f64; 4] {
        let keys = pair.first_key..pair.first_key + self.keys_of(pair);
        let mut sum = [0.0; 4];
        for row in self.rows.rows.iter().filter(|row| keys.contains(&row.key) && row.acts()) {
            let [pressure, shear] = self.stresses(row.key as usize);
            let Some(foot) = row.closest_point.map(|f| feet_dofs(self, f)) else { continue };
            for term in self.rows.terms_of(row) {
                if let Some(axis) = foot.iter().position(|d| *d == term.dof) {
                    sum[axis] += pressure * term.normal;
                    sum[2 + axis] += shear * term.slip;
                }
            }
        }
        sum
    }

    /// Returns the closest place on the only analytical surface of a point at the start of an increment, of which only the
    /// motion of bodies has been made. In soft contact it is the closest place with the gap that the material has there.
    pub(super) fn place_on_analytical(&self, point: u32, place: [f64; 2], dofs: &Dofs) -> Option<[f64; 2]> {
        let analytical_pairs = self.pairs.iter().filter(|pair| pair.analytical.is_some());
        let mut surfaces =
            analytical_pairs.filter_map(|pair| Some((pair, self.curves[pair.own].own.binary_search(&point).ok()?)));
        let (Some((pair, index)), None) = (surfaces.next(), surfaces.next()) else { return None };
        let analytical = &self.analyticals[pair.analytical?];
        let PointCarrier::Body(body, [_, start]) = self.points[analytical.point as usize].carrier else { return None };
        let lift = start + dofs.bodies[body].before.displacement;
        let gap = if self.laws[pair.law_of(index) as usize].is_soft() {
            self.gap_along_facets(pair, index, place, (dofs, lift))?
        } else {
            0.0
        };
        analytical.place_at(self.zero_of(analytical, index, pair.first_key as usize + index) + gap, place, lift)
    }

    /// Returns the gap to an analytical surface at the new place of a point that slides along its facets: between the gaps
    /// of the point and of the next one. `None` beyond the ends of the surface.
    fn gap_along_facets(
        &self,
        pair: &ContactPair,
        index: usize,
        place: [f64; 2],
        (dofs, lift): (&Dofs, f64),
    ) -> Option<f64> {
        let (analytical, own) = (&self.analyticals[pair.analytical?], &self.curves[pair.own]);
        let place_of = |point: u32| self.place_of(point, dofs, 0.0);
        let gap = |index: usize| {
            let nearest = analytical.profile.nearest(place_of(own.own[index]), lift);
            let zero = self.zero_of(analytical, index, pair.first_key as usize + index);
            (!nearest.beyond).then_some(nearest.gap - zero)
        };
        let start = gap(index)?;
        let Some((next, share)) = own.next_point(index, place, place_of) else { return Some(start) };
        let end = own.own.binary_search(&next).ok().and_then(gap).unwrap_or(start);
        Some(start + share * (end - start))
    }

    /// Returns the distance from the profile that is gap zero at a point.
    fn zero_of(&self, analytical: &AnalyticalSurface, index: usize, key: usize) -> f64 {
        analytical.lift[index] + self.gap_offsets.get(key).copied().unwrap_or(0.0)
    }

    /// Returns the place of a new node on the edge between two nodes of a surface that is in contact with an analytical
    /// one: on a curved surface the edge is not on it. Between two nodes in contact the new node has the gap between
    /// theirs, and others do not overlap. `None` if the node may remain on the edge.
    pub fn place_between(&self, ends: [usize; 2], share: f64, dofs: &Dofs) -> Option<[f64; 2]> {
        let at = ends.inline_map(|node| dofs.nodes[node].place());
        let edge = distance(at[0], at[1]);
        let start = [0, 1].inline_map(|i: usize| at[0][i] + share * (at[1][i] - at[0][i]));
        self.pairs.iter().find_map(|pair| {
            let analytical = &self.analyticals[pair.analytical?];
            let PointCarrier::Body(body, [_, z]) = self.points[analytical.point as usize].carrier else { return None };
            let (own, lift) = (&self.curves[pair.own].own, z + dofs.bodies[body].displacement);
            let is_at =
                |node: usize| move |point: &u32| self.points[*point as usize].carrier == PointCarrier::Node(node);
            let [first, second] = ends.inline_map(|node| own.iter().position(is_at(node)));
            let zeros = [first?, second?].inline_map(|i| self.zero_of(analytical, i, pair.first_key as usize + i));
            let gap = |place: [f64; 2], zero: f64| {
                let nearest = analytical.profile.nearest(place, lift);
                (!nearest.beyond).then_some(nearest.gap - zero)
            };
            let zero = zeros[0] + share * (zeros[1] - zeros[0]);
            let (gaps, own_gap) = ([gap(at[0], zeros[0])?, gap(at[1], zeros[1])?], gap(start, zero)?);
            let wanted = gaps[0] + share * (gaps[1] - gaps[0]);
            let touches = gaps.iter().all(|gap| gap.abs() <= TOUCHING * edge);
            let moves = if touches { own_gap != wanted } else { own_gap < wanted.min(0.0) };
            let target = zero + if touches { wanted } else { wanted.min(0.0) };
            if moves { analytical.place_at(target, start, lift) } else { None }
        })
    }

    pub(super) fn keys_of(&self, pair: &ContactPair) -> u32 {
        keys(&self.curves, &self.analyticals, pair)
    }
}

/// Returns the number of keys of a pair. Each own point has one, and a second one if it may be in a corner. Points of a
/// second curve have one if they may be in contact alone.
pub(super) fn keys(curves: &[FacetCurve], analyticals: &[AnalyticalSurface], pair: &ContactPair) -> u32 {
    let own = curves[pair.own].own.len() as u32;
    let loose = pair.other.map(|o| &curves[o]).filter(|c| c.has_single_points()).map_or(0, |c| c.own.len() as u32);
    let twice = pair.analytical.is_some_and(|a| analyticals[a].has_corners());
    own + loose + if twice { own } else { 0 }
}

/// Returns the degrees of freedom of the point of a [`ClosestPoint`].
fn feet_dofs(contact: &ContactConstraint, foot: u32) -> [u32; 2] {
    contact.dofs_of[contact.feet[foot as usize].point as usize]
}

/// Returns the position of a point at the end of the increment.
fn end_of(point: u32, places: &[[f64; 2]], dofs_of: &[[u32; 2]], motion: &ContactVelocities, dt: f64) -> [f64; 2] {
    let (place, dofs) = (places[point as usize], dofs_of[point as usize]);
    [0, 1].inline_map(|i| if dofs[i] == NONE { place[i] } else { place[i] + dt * motion.velocity[dofs[i] as usize] })
}

#[cfg(test)]
mod tests {
    use super::AnalyticalSurface;
    use crate::constraint::Constraint;
    use crate::constraint::contact::curve::{FacetCurve, PointCarrier, SurfacePoint};
    use crate::constraint::contact::{ContactConstraint, ContactPair};
    use crate::kernel::interaction::{CoulombFriction, InteractionLaw};
    use crate::kernel::profile::{ProfileSegment, SurfaceProfile};
    use crate::state::dofs::Dofs;
    use crate::state::magnitude::AmplitudeClock;
    use crate::state::nodes::{Node, Nodes};
    use crate::state::{BodyState, Instant};

    /// Nodes without elements, and one body with an analytical surface.
    struct ContactScene {
        contact: ContactConstraint,
        profile: SurfaceProfile,
        dofs: Dofs,
        gravity: [f64; 2],
    }

    impl ContactScene {
        /// Creates a scene from the mass and velocity of the body (`None` if it is fixed), and coordinates, velocity
        /// and mass of each node.
        fn new(
            profile: SurfaceProfile,
            friction: f64,
            body: Option<(f64, f64)>,
            nodes: &[([f64; 2], [f64; 2], f64)],
        ) -> ContactScene {
            let list = nodes.iter().map(|(p, v, _)| Node { r: p[0], z: p[1], v_r: v[0], v_z: v[1] }).collect();
            let masses = nodes.iter().map(|n| n.2).collect();
            let mut state = BodyState::new(body.map_or(1.0, |b| b.0), body.map_or(0.0, |b| b.1));
            state.velocity_half = state.velocity;
            state.prescribed = body.is_none();
            let mut dofs = Dofs { bodies: vec![state], nodes: Nodes::new(list, masses), ..Dofs::default() };
            let count = nodes.len() as u32;
            let carriers = (0..nodes.len()).map(PointCarrier::Node).chain([PointCarrier::Body(0, [0.0; 2])]);
            let points = carriers.map(|carrier| SurfacePoint { carrier, free: [true; 2] }).collect();
            let mut surface = AnalyticalSurface::new(profile.clone(), count);
            surface.overlap = 1e-3;
            let (curve, pair) =
                (FacetCurve::of_points((0..count).collect()), ContactPair::in_front_of(0, 0, 0, 0, 1.0));
            let law = InteractionLaw { friction: CoulombFriction::of(friction), ..InteractionLaw::default() };
            let mut contact = ContactConstraint::new(points, vec![curve], vec![surface], vec![pair], vec![law]);
            contact.begin(&mut dofs);
            ContactScene { contact, profile, dofs, gravity: [0.0; 2] }
        }

        fn advance(&mut self, dt: f64) {
            let body = &mut self.dofs.bodies[0];
            body.acceleration = 0.0;
            (body.before.displacement, body.before.velocity) = (body.displacement, body.velocity_half);
            body.displacement += dt * body.velocity_half;
            let nodes = &mut self.dofs.nodes;
            for n in 0..nodes.len() {
                nodes.acceleration[n] = self.gravity;
                for axis in [0, 1] {
                    *nodes[n].velocity(axis) += dt * self.gravity[axis];
                    let v = *nodes[n].velocity(axis);
                    *nodes[n].coordinate(axis) += dt * v;
                }
            }
            (nodes.previous_dt, nodes.half) = (dt, dt);
            self.contact.motion(&mut self.dofs, &AmplitudeClock { now: Instant::default(), user_amplitudes: &[] }, dt);
        }

        fn momentum(&self) -> f64 {
            let nodes = &self.dofs.nodes;
            let sum: f64 = (0..nodes.len()).map(|n| nodes.mass[n] * nodes[n].v_z).sum();
            sum + self.dofs.bodies[0].mass * self.dofs.bodies[0].velocity_half
        }

        fn kinetic(&self) -> f64 {
            let nodes = &self.dofs.nodes;
            let of = |n: usize| nodes.mass[n] * (nodes[n].v_r * nodes[n].v_r + nodes[n].v_z * nodes[n].v_z);
            let body = &self.dofs.bodies[0];
            let own = if body.prescribed { 0.0 } else { body.mass * body.velocity_half * body.velocity_half };
            0.5 * ((0..nodes.len()).map(of).sum::<f64>() + own)
        }
    }

    fn lines(points: &[[f64; 2]]) -> SurfaceProfile {
        SurfaceProfile { segments: points.windows(2).map(|w| ProfileSegment::Line([w[0], w[1]])).collect() }
    }

    /// Returns a bowl of radius 1 around (2, 1), counter-clockwise, so that its inside is the contact side.
    fn bowl() -> SurfaceProfile {
        let (c, points) = ([2.0, 1.0], [[1.0, 1.0], [2.0, 0.0], [3.0, 1.0]]);
        SurfaceProfile { segments: points.windows(2).map(|w| ProfileSegment::arc(w[0], w[1], c)).collect() }
    }

    /// Without friction a node that slides along a bowl keeps its speed to rounding for any increment.
    #[test]
    fn sliding_along_a_bowl_keeps_the_speed() {
        for dt in [0.1_f64, 0.01] {
            // On the arc half an increment past its start, along the chord.
            let (c, s) = (dt.cos(), dt.sin());
            let start = [2.0 - c, 1.0 - s];
            let mut scene = ContactScene::new(bowl(), 0.0, None, &[(start, [0.0, 0.0], 2.0)]);
            let (angle, speed) = (1.5 * dt, 2.0 * (0.5 * dt).sin() / dt);
            (scene.dofs.nodes[0].v_r, scene.dofs.nodes[0].v_z) = (speed * angle.sin(), -speed * angle.cos());
            for _ in 0..(2.5 / dt) as usize {
                scene.advance(dt);
            }
            let node = scene.dofs.nodes[0];
            let radius = (node.r - 2.0).hypot(node.z - 1.0);
            assert!(node.r > 2.5 && (radius - 1.0).abs() < 1e-12, "{node:?}");
            assert!((scene.kinetic() - speed * speed).abs() < 1e-9, "{} {}", dt, scene.kinetic());
            assert!(scene.dofs.energies.contact.abs() < 1e-9, "{:?}", scene.dofs.energies);
        }
    }

    /// In a bowl under gravity a node returns ten times to the height at which it started.
    #[test]
    fn node_in_a_bowl_has_the_period_of_a_pendulum() {
        let start = [2.0 + 0.5_f64.sin(), 1.0 - 0.5_f64.cos()];
        let mut scene = ContactScene::new(bowl(), 0.0, None, &[(start, [0.0; 2], 1.0)]);
        scene.gravity = [0.0, -1.0];
        let (mut crossings, mut highest, mut before, mut time) = (Vec::new(), 0.0_f64, start[0] - 2.0, 0.0);
        while crossings.len() < 20 {
            scene.advance(0.01);
            time += 0.01;
            let node = scene.dofs.nodes[0];
            if (node.r - 2.0) * before < 0.0 {
                crossings.push(time);
                highest = 0.0;
            }
            before = node.r - 2.0;
            highest = highest.max(node.z);
        }
        // Period of a pendulum by the complete elliptic integral: 2 pi (1 + a^2/16 + 11 a^4/3072 + ..) for a = 0.5.
        let period = (crossings[18] - crossings[0]) / 9.0;
        let exact = std::f64::consts::TAU * (1.0 + 0.25 / 16.0 + 11.0 * 0.0625 / 3072.0 + 173.0 * 0.015625 / 737_280.0);
        assert!((period / exact - 1.0).abs() < 1e-3, "{period} {exact}");
        while scene.dofs.nodes[0].v_r.abs() > 6e-3 {
            scene.advance(0.01);
            highest = highest.max(scene.dofs.nodes[0].z);
        }
        assert!((highest - start[1]).abs() < 1e-4, "{highest} {}", start[1]);
    }

    /// At a convex corner no force acts; in a concave corner only the velocity component into the second segment is
    /// lost.
    #[test]
    fn corners_add_no_impulse() {
        let down = lines(&[[0.0, 0.0], [1.0, 0.0], [2.0, -1.0]]);
        let mut scene = ContactScene::new(down, 0.0, None, &[([0.95, 0.0], [1.0, 0.0], 1.0)]);
        (0..20).for_each(|_| scene.advance(0.01));
        let node = scene.dofs.nodes[0];
        assert!((node.v_r, node.v_z) == (1.0, 0.0) && node.z.abs() < 1e-15, "{node:?}");
        let up = lines(&[[0.0, 0.0], [1.0, 0.0], [2.0, 1.0]]);
        let mut scene = ContactScene::new(up, 0.0, None, &[([0.955, 0.0], [1.0, 0.0], 1.0)]);
        (0..20).for_each(|_| scene.advance(0.01));
        let node = scene.dofs.nodes[0];
        assert!((node.v_r - 0.5).abs() < 1e-9 && (node.v_z - 0.5).abs() < 1e-9, "{node:?}");
        let lost = scene.dofs.energies.contact;
        assert!((lost - 0.25).abs() < 1e-9 && (lost + scene.kinetic() - 0.5).abs() < 1e-12, "{lost}");
    }

    /// On a slope of 45 degrees with friction 0.3 the acceleration is (1 - 0.3)/sqrt 2 g, and friction dissipates the
    /// lost energy.
    #[test]
    fn sliding_down_a_slope_is_slowed_by_friction() {
        let slope = lines(&[[0.0, 10.0], [10.0, 0.0]]);
        let mut scene = ContactScene::new(slope, 0.3, None, &[([1.0, 9.0], [0.0; 2], 2.0)]);
        scene.gravity = [0.0, -1.0];
        let steps = 400;
        (0..steps).for_each(|_| scene.advance(0.01));
        let node = scene.dofs.nodes[0];
        let (along, exact) = (node.v_r.hypot(node.v_z), 0.7 / 2.0_f64.sqrt() * 0.01 * f64::from(steps));
        assert!((along / exact - 1.0).abs() < 1e-9, "{along} {exact}");
        let work = 2.0 * (9.0 - node.z);
        let lost = scene.dofs.energies.friction;
        assert!((scene.kinetic() + lost - work).abs() < 0.01 * work, "{lost} {work}");
        assert!(scene.dofs.energies.contact.abs() < 1e-9);
        // It sticks if the friction coefficient is large enough.
        let slope = lines(&[[0.0, 10.0], [10.0, 0.0]]);
        let mut scene = ContactScene::new(slope, 1.1, None, &[([1.0, 9.0], [0.0; 2], 2.0)]);
        scene.gravity = [0.0, -1.0];
        (0..steps).for_each(|_| scene.advance(0.01));
        assert!((scene.dofs.nodes[0].r - 1.0).abs() < 1e-12);
    }

    /// Bodies from a million times lighter to a thousand times heavier than the nodes they touch: momentum is conserved
    /// to rounding, and energy is only dissipated.
    #[test]
    fn contact_with_free_bodies_conserves_momentum() {
        let punch = || {
            let c = [0.0, 2.0];
            SurfaceProfile { segments: vec![ProfileSegment::arc([0.0, 1.0], [1.0, 2.0], c).reversed()] }
        };
        for mass in [1e-6, 1e-3, 1.0, 1e3] {
            for friction in [0.0, 0.3] {
                let nodes: Vec<_> = (0..8).map(|i| ([0.05 + 0.1 * f64::from(i), 0.9999], [0.0; 2], 1.0)).collect();
                let mut scene = ContactScene::new(punch(), friction, Some((mass, -1.0)), &nodes);
                let (momentum, energy) = (scene.momentum(), scene.kinetic());
                for _ in 0..3000 {
                    scene.advance(1e-4);
                    let lost = scene.dofs.energies.contact + scene.dofs.energies.friction;
                    assert!((scene.kinetic() + lost - energy).abs() < 1e-9 * energy, "{mass} {friction}");
                }
                let now = scene.momentum();
                assert!((now - momentum).abs() < 1e-12 * momentum.abs(), "{mass} {friction}: {now} {momentum}");
                assert!(scene.kinetic() <= energy && scene.dofs.energies.friction >= 0.0);
                for n in 0..8 {
                    let node = scene.dofs.nodes[n];
                    let gap = scene.profile.nearest(node.place(), scene.dofs.bodies[0].displacement).gap;
                    assert!(gap > -1e-9, "{mass} {friction}: {n} {gap}");
                }
            }
        }
    }

    /// A body that hits one node and moves on with it: a perfectly plastic impact.
    #[test]
    fn impact_on_a_node_is_perfectly_plastic() {
        let flat = lines(&[[1.0, 0.0], [0.0, 0.0]]);
        let mut scene = ContactScene::new(flat, 0.0, Some((3.0, -1.0)), &[([0.5, -0.5], [0.0; 2], 1.0)]);
        (0..200).for_each(|_| scene.advance(0.01));
        assert!((scene.dofs.bodies[0].velocity_half + 0.75).abs() < 1e-12);
        assert!((scene.dofs.nodes[0].v_z + 0.75).abs() < 1e-12);
        // The lost energy is half the reduced mass times the squared speed.
        assert!((scene.dofs.energies.contact - 0.375).abs() < 1e-12);
    }
}
