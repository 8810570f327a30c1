//! The resistance on a rigid body that moves and turns in space: its meridian's facets as rings, in a stack whose planes are tilted.
//! Never here: sums over stations (`rings`), the load as the integrator sees it.

use super::rings::{Rings, Scene};
use super::stack::Stack;
use crate::kernel::attitude::{Vector, dot, norm};
use crate::kernel::lists::heap_bytes;
use crate::load::fields::FacetFields;
use crate::load::{MotionAtEnd, Penetration, PenetrationOutcome};
use crate::mesh::surface::Patch;
use crate::state::BodyState;
use crate::state::archive::persist_struct;
use crate::state::limit::Limit;
use crate::state::rigid_body_3d::{Motion, RigidBody3d, Wrench};

/// Speed over which pressure and friction come up, as a part of the body's own; below a tenth of the fastest there was it is no
/// longer in proportion. A law that jumps where a wall begins to move into the material would turn the motion across the wall in
/// every increment, however short.
const ONSET: f64 = 0.25;
const SLOW: f64 = 0.1;
/// An increment covers this part of the time in which what damps would stop the body.
const DAMPED: f64 = 0.5;

/// Where a stack lies: its heights grow along a direction, and are those of the deck where that passes through a point.
#[derive(Clone, Copy, Debug)]
pub struct Tilt {
    /// Direction of the normal of the planes.
    pub up: Vector,
    /// Height z at which planes and the axis of the deck meet that all turn about.
    pub pivot: f64,
}

impl Tilt {
    /// Planes turned about direction 3 through the point of the axis at a height, by an angle in radians.
    pub fn new(pivot: f64, angle: f64) -> Tilt {
        Tilt { up: [-libm::sin(angle), libm::cos(angle), 0.0], pivot }
    }

    /// Height in the stack of a point of the world.
    fn height(&self, point: Vector) -> f64 {
        self.pivot + dot(self.beside_pivot(point), self.up)
    }

    /// The way from the point about which it is turned.
    fn beside_pivot(&self, [x, y, z]: Vector) -> Vector {
        [x, y - self.pivot, z]
    }
}

/// Facets of one body in a tilted stack.
#[derive(Clone, Debug)]
pub(super) struct Oblique {
    pub(super) body: usize,
    tilt: Tilt,
    friction: f64,
    /// Part of what of the body lies across planes that an increment may travel; it also scales the onset.
    travel: f64,
    rings: Rings,
    elements: Vec<usize>,
    /// Which way layers follow each other along `up`.
    direction: f64,
    /// Whether it has met the stack.
    met: bool,
    /// When it had left it again, and how.
    left: Option<(f64, bool)>,
    /// How fast the force grows with speed where it comes up.
    damping: f64,
}

impl Oblique {
    pub(super) fn new(
        patch: &Patch,
        of: &RigidBody3d,
        (tilt, direction): (Tilt, f64),
        (friction, travel): (f64, f64),
    ) -> Oblique {
        let facets = patch.facets.iter().map(|f| &f.1);
        Oblique {
            body: patch.body,
            tilt,
            friction,
            travel,
            rings: Rings::new(facets, of.heights[0], of.stations),
            elements: patch.facets.iter().map(|f| f.0).collect(),
            direction,
            met: false,
            left: None,
            damping: 0.0,
        }
    }

    fn scene(&self, body: &RigidBody3d, motion: &Motion) -> Scene {
        let own = |v: Vector| body.attitude.to_body(v);
        // What lies still is asked at next to no speed, for all that it can hold.
        let floor = if body.rests { 0.0 } else { SLOW * body.fastest };
        let speed = body.speed_bound(motion).max(floor);
        Scene {
            velocity: own(motion.velocity),
            turning: own(motion.turning),
            up: own(self.tilt.up),
            height: self.tilt.height(body.centre),
            beside_pivot: own(self.tilt.beside_pivot(body.centre)),
            onset: (ONSET * self.travel * speed).max(f64::MIN_POSITIVE),
            friction: self.friction,
        }
    }

    /// Friction and pressure on its body; `None` where they are not finite.
    pub(super) fn resist(&mut self, stack: &Stack, body: &BodyState, time: f64) -> Option<[Wrench; 2]> {
        let body = body.spatial.as_ref()?;
        let scene = self.scene(body, &body.shown);
        let [low, high] = self.rings.heights(&scene);
        self.look(stack, [low, high], time);
        self.damping = 0.0;
        if high <= stack.planes[0] || low >= stack.planes[stack.planes.len() - 1] {
            return Some(Default::default());
        }
        let sum = self.rings.resist(stack, &scene);
        self.damping = sum.damping;
        let attitude = body.attitude;
        let world = |w: &Wrench| Wrench { force: attitude.to_world(w.force), moment: attitude.to_world(w.moment) };
        let wrenches = [world(&sum.friction), world(&sum.pressure)];
        wrenches.iter().all(Wrench::is_finite).then_some(wrenches)
    }

    /// Whether it has met the stack, and has left it.
    fn look(&mut self, stack: &Stack, [low, high]: [f64; 2], time: f64) {
        let inside = high > stack.planes[0] && low < stack.planes[stack.planes.len() - 1];
        if inside {
            (self.met, self.left) = (true, None);
        } else if self.met && self.left.is_none() {
            let below = high <= stack.planes[0];
            let through = below == (self.direction < 0.0);
            self.left = Some((time, through));
        }
    }

    /// What has become of its body here.
    pub(super) fn penetration(&self, body: &BodyState) -> Option<Penetration> {
        let body = body.spatial.as_ref()?;
        let speed = norm(body.velocity);
        let along = dot(body.velocity, self.tilt.up).abs();
        let obliquity = if speed > 0.0 { libm::acos((along / speed).min(1.0)) } else { 0.0 };
        let outcome = match self.left {
            Some((_, true)) => PenetrationOutcome::Through,
            Some((_, false)) => PenetrationOutcome::Ricochet,
            None if !self.met => PenetrationOutcome::NotMet,
            None if body.rests => PenetrationOutcome::AtRest,
            None => PenetrationOutcome::Moving,
        };
        let in_space = MotionAtEnd {
            exit_time: self.left.map(|left| left.0),
            velocity: body.velocity,
            rotational_velocity: body.motion().turning,
            speed,
            obliquity: obliquity.to_degrees(),
            yaw: body.yaw().to_degrees(),
            tilt: body.tilt().to_degrees(),
        };
        Some(Penetration { body: self.body, outcome, in_space: Some(in_space) })
    }

    /// Goes on from the resistance on the same body that it replaces.
    pub(super) fn continue_from(&mut self, previous: &Oblique) {
        if previous.body == self.body {
            (self.met, self.left, self.damping) = (previous.met, previous.left, previous.damping);
        }
    }

    /// How far the next increment may go: to the next plane and a part of the body beyond, and no longer than what damps lets it.
    pub(super) fn limit(&self, stack: &Stack, body: &BodyState) -> Limit {
        let Some(body) = &body.spatial else { return Limit::NONE };
        let motion = body.motion();
        let scene = self.scene(body, &motion);
        let [low, high] = self.rings.heights(&scene);
        let speed = dot(motion.velocity, self.tilt.up).abs() + body.size * norm(motion.turning);
        let inside = high > stack.planes[0] && low < stack.planes[stack.planes.len() - 1];
        let changes = inside && stack.finite.is_some();
        let cut = changes || stack.planes.iter().any(|p| (low..=high).contains(p));
        let gap = |p: &f64| if *p > high { p - high } else { low - p };
        let ahead = if cut { 0.0 } else { stack.planes.iter().map(gap).fold(f64::INFINITY, f64::min) };
        let distance = ahead + self.travel * (high - low);
        let mut time = if speed > 0.0 { distance / speed } else { f64::INFINITY };
        if inside && self.damping > 0.0 {
            let yields = 1.0 / body.mass + body.size * body.size / body.inertia.transverse;
            time = time.min(DAMPED / (self.damping * yields));
        }
        Limit { time, jump: false }
    }

    /// Adds what frames show: each element as often as there are stations.
    pub(super) fn show(&self, stack: &Stack, body: &BodyState, fields: &mut FacetFields) {
        let Some(body) = &body.spatial else { return };
        let scene = self.scene(body, &body.motion());
        self.rings
            .show(stack, &scene, |ring, _, [pressure, velocity]| fields.push(self.elements[ring], pressure, velocity));
    }

    pub(super) fn bytes(&self) -> usize {
        self.rings.bytes() + heap_bytes(&self.elements)
    }
}

persist_struct!(Oblique { met, left, damping } derived { body, tilt, friction, travel, rings, elements, direction });

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::attitude::plus;

    #[test]
    fn heights_of_a_tilted_stack_grow_along_its_normal() {
        let tilt = Tilt::new(2.0, 0.5);
        assert!((tilt.height(plus([0.0, 2.0, 0.0], 3.0, tilt.up)) - 5.0).abs() < 1e-15);
        assert!((tilt.height([libm::cos(0.5), 2.0 + libm::sin(0.5), 7.0]) - 2.0).abs() < 1e-15);
    }
}
