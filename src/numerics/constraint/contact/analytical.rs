//! Contact of points with analytical surfaces: one row for each point, two in a re-entrant corner of two segments.
//!
//! The gap of a row is evaluated at the end of the increment, along the normal at its start (constrained central
//! differences, Ryckaert, Ciccotti and Berendsen 1977, J. Comput. Phys. 23, 327). A point that slides along an arc
//! therefore keeps its speed and its distance. The gap is linearised about the position x* without contact, gap(x*) -
//! dt n.v*, and updated on arcs after the impulses have been applied (`analytical_rows.rs`).

use crate::kernel::lanes::InlineMap;
use crate::kernel::profile::SurfaceProfile;

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
    pub(super) analytical: u32,
    pub(super) segment: u32,
    pub(super) point: u32,
    /// Distance from the profile that is gap zero, initial overlap included.
    pub(super) target: f64,
}

/// Motion of a point relative to the profile over an increment.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointPath {
    pub(super) start: [f64; 2],
    pub(super) end: [f64; 2],
    /// Displacement of the body at the start and at the end of the increment.
    pub(super) lift: [f64; 2],
    /// Distance from the profile that is gap zero.
    pub(super) zero: f64,
}

/// Number of projections onto a profile; one is exact within a segment.
const PROJECTIONS: usize = 2;

impl AnalyticalSurface {
    /// Creates a surface on the body that `point` represents.
    pub fn new(profile: SurfaceProfile, point: u32) -> AnalyticalSurface {
        let [low, high] = profile.bounds();
        let rounding = 1e-9 * low[1].abs().max(high[1].abs()).max(high[0] - low[0]);
        let corner_segments = (0..profile.segments.len()).map(|k| profile.reentrant_neighbors(k)).collect();
        AnalyticalSurface { profile, point, rounding, overlap: rounding, lift: Vec::new(), corner_segments }
    }

    /// Returns the closest place with a distance from the profile of a body that has moved by `lift`.
    pub(super) fn place_at(&self, target: f64, mut place: [f64; 2], lift: f64) -> Option<[f64; 2]> {
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
    pub(super) fn met(&self, segment: usize, path: &PointPath) -> Option<(usize, f64)> {
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
    pub(super) fn corner(&self, segment: usize, path: &PointPath, reach: f64) -> Option<usize> {
        let is_near = |k: &usize| {
            let other = &self.profile.segments[*k];
            let gap = other.gap(path.end, path.lift[1]) - path.zero;
            let away = |end: &[f64; 2]| libm::hypot(path.end[0] - end[0], path.end[1] - end[1] - path.lift[1]);
            let is_at_segment = other.side_of(path.end, path.lift[1]) == 0
                || other.ends().iter().map(away).fold(f64::INFINITY, f64::min) <= reach + path.zero.abs();
            gap < reach && is_at_segment && other.gap(path.start, path.lift[0]) - path.zero >= -self.rounding
        };
        self.corner_segments[segment].into_iter().flatten().find(is_near)
    }
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
            let energy_of = |n: usize| nodes.mass[n] * (nodes[n].v_r * nodes[n].v_r + nodes[n].v_z * nodes[n].v_z);
            let body = &self.dofs.bodies[0];
            let of_body = if body.prescribed { 0.0 } else { body.mass * body.velocity_half * body.velocity_half };
            0.5 * ((0..nodes.len()).map(energy_of).sum::<f64>() + of_body)
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
        let (mut crossings, mut highest, mut previous, mut time) = (Vec::new(), 0.0_f64, start[0] - 2.0, 0.0);
        while crossings.len() < 20 {
            scene.advance(0.01);
            time += 0.01;
            let node = scene.dofs.nodes[0];
            if (node.r - 2.0) * previous < 0.0 {
                crossings.push(time);
                highest = 0.0;
            }
            previous = node.r - 2.0;
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
