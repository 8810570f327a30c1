//! Resistance on a rigid body with six degrees of freedom in a stack of inclined planes. The facets of its meridian are
//! treated as rings; the sums over their stations are in `rings`.

use super::rings::{RigidCompliance, RingKinematics, RingSet};
use super::stack::LayerStack;
use crate::kernel::attitude::{SpatialVector, dot, norm};
use crate::kernel::lists::Memory;
use crate::load::fields::FacetFields;
use crate::load::stations::{divided_facets, largest_radius};
use crate::load::{FinalMotion, PenetrationOutcome, PenetrationRecord};
use crate::mesh::surface::RigidFacets;
use crate::platform::PortableMath as _;
use crate::state::BodyState;
use crate::state::archive::Persist;
use crate::state::limit::IncrementLimit;
use crate::state::rigid_body_3d::{RigidBody3d, RigidMotion, Wrench};

/// Regularisation of pressure and friction: both rise linearly up to the speed `ONSET * travel` times the body speed,
/// or `SLOW` times its largest speed so far if that is larger. A law that jumps when a wall begins to move into the
/// material would reverse the transverse motion in every increment, regardless of its length.
const ONSET: f64 = 0.25;
const SLOW: f64 = 0.1;
/// Largest increment, as a fraction of the time in which the damping would stop the body.
const DAMPED: f64 = 0.5;
/// Longest part of a facet, as a fraction of the thinnest layer.
const PART_OF_LAYER: f64 = 0.25;
/// Lower limit of the length that follows from layers and free surfaces, as a fraction of the body.
const SHORTEST: f64 = 1.0 / 30.0;

/// Orientation of a stack: heights are measured along a direction, and equal those of the deck at a pivot on the axis.
#[derive(Clone, Copy, Debug)]
pub struct StackTilt {
    /// Unit normal of the planes.
    pub up: SpatialVector,
    /// Height z of the pivot on the axis of the deck.
    pub pivot: f64,
}

impl StackTilt {
    /// Rotates planes about direction 3 through the point on the axis at height `pivot`, by an angle in radians.
    pub fn new(pivot: f64, angle: f64) -> StackTilt {
        StackTilt { up: [-libm::sin(angle), libm::cos(angle), 0.0], pivot }
    }

    /// Returns the height in the stack of a point in global coordinates.
    fn height(&self, point: SpatialVector) -> f64 {
        self.pivot + dot(self.relative_to_pivot(point), self.up)
    }

    /// Returns the vector from the pivot to a point.
    fn relative_to_pivot(&self, [x, y, z]: SpatialVector) -> SpatialVector {
        [x, y - self.pivot, z]
    }
}

/// Facets of one body in an inclined stack.
#[derive(Clone, Debug, Persist, Memory)]
#[persist(derived: body, tilt, friction, travel, rings, elements, direction)]
pub(super) struct ObliqueResistance {
    pub(super) body: usize,
    tilt: StackTilt,
    friction: f64,
    /// Fraction of the body's extent normal to the planes that it may travel in one increment; it also scales the
    /// regularisation speed.
    travel: f64,
    rings: RingSet,
    /// Mesh index of the element of each ring.
    elements: Vec<usize>,
    /// Direction in which the layers follow each other along `up`, 1 or -1.
    direction: f64,
    /// Whether the body has entered the stack.
    entered: bool,
    /// Total time at which the body left the stack, and whether through the rear face.
    exit: Option<(f64, bool)>,
    /// Upper bound of the rate at which the regularised forces damp the motion, 1/s.
    damping: f64,
}

impl ObliqueResistance {
    pub(super) fn new(
        patch: &RigidFacets,
        of: &RigidBody3d,
        stack: &LayerStack,
        (tilt, direction): (StackTilt, f64),
        (friction, travel): (f64, f64),
    ) -> ObliqueResistance {
        let of_layers = PART_OF_LAYER * stack.thinnest_layer();
        // The reduction near free surfaces varies over the radius of the body.
        let near_surfaces = if stack.bounds.is_some() { largest_radius(patch) } else { f64::INFINITY };
        let longest = of_layers.min(near_surfaces).max(SHORTEST * of.size);
        let parts = divided_facets(patch, of, longest);
        ObliqueResistance {
            body: patch.body,
            tilt,
            friction,
            travel,
            rings: RingSet::new(parts.iter().map(|part| &part.1), of.heights[0], of.stations),
            elements: parts.iter().map(|part| part.0).collect(),
            direction,
            entered: false,
            exit: None,
            damping: 0.0,
        }
    }

    fn scene(&self, body: &RigidBody3d, motion: &RigidMotion) -> RingKinematics {
        let in_body = |v: SpatialVector| body.attitude.to_body(v);
        // For a body at rest, the regularisation speed is almost zero, so that the full resistance is available.
        let floor = if body.rests { 0.0 } else { SLOW * body.fastest };
        let speed = body.speed_bound(motion).max(floor);
        let up = in_body(self.tilt.up);
        RingKinematics {
            velocity: in_body(motion.velocity),
            turning: in_body(motion.turning),
            up,
            across: up[0].portable_hypot(up[2]),
            height: self.tilt.height(body.centre),
            relative_to_pivot: in_body(self.tilt.relative_to_pivot(body.centre)),
            onset: (ONSET * self.travel * speed).max(f64::MIN_POSITIVE),
            friction: self.friction,
            compliance: RigidCompliance {
                mass: 1.0 / body.mass,
                transverse: 1.0 / body.inertia.transverse,
                axial: 1.0 / body.inertia.axial,
            },
        }
    }

    /// Returns the forces and moments of friction and pressure on the body; `None` if they are not finite.
    pub(super) fn resist(&mut self, stack: &LayerStack, body: &BodyState, time: f64) -> Option<[Wrench; 2]> {
        let body = body.spatial.as_ref()?;
        let scene = self.scene(body, &body.shown);
        let [low, high] = self.rings.heights(&scene);
        self.update_outcome(stack, [low, high], time);
        self.damping = 0.0;
        if high <= stack.planes[0] || low >= stack.planes[stack.planes.len() - 1] {
            return Some(Default::default());
        }
        let sum = self.rings.resist(stack, &scene);
        self.damping = sum.damping();
        let attitude = body.attitude;
        let world = |w: &Wrench| Wrench { force: attitude.to_world(w.force), moment: attitude.to_world(w.moment) };
        let wrenches = [world(&sum.friction), world(&sum.pressure)];
        wrenches.iter().all(Wrench::is_finite).then_some(wrenches)
    }

    /// Updates whether the body has entered and left the stack.
    fn update_outcome(&mut self, stack: &LayerStack, [low, high]: [f64; 2], time: f64) {
        let inside = high > stack.planes[0] && low < stack.planes[stack.planes.len() - 1];
        if inside {
            (self.entered, self.exit) = (true, None);
        } else if self.entered && self.exit.is_none() {
            let below = high <= stack.planes[0];
            let through = below == (self.direction < 0.0);
            self.exit = Some((time, through));
        }
    }

    /// Returns the outcome and the motion of the body.
    pub(super) fn penetration(&self, body: &BodyState) -> Option<PenetrationRecord> {
        let body = body.spatial.as_ref()?;
        let speed = norm(body.velocity);
        let along = dot(body.velocity, self.tilt.up).abs();
        let obliquity = if speed > 0.0 { libm::acos((along / speed).min(1.0)) } else { 0.0 };
        let outcome = match self.exit {
            Some((_, true)) => PenetrationOutcome::Through,
            Some((_, false)) => PenetrationOutcome::Ricochet,
            None if !self.entered => PenetrationOutcome::NotMet,
            None if body.rests => PenetrationOutcome::AtRest,
            None => PenetrationOutcome::Moving,
        };
        let in_space = FinalMotion {
            exit_time: self.exit.map(|left| left.0),
            velocity: body.velocity,
            rotational_velocity: body.motion().turning,
            speed,
            obliquity: obliquity.to_degrees(),
            yaw: body.yaw().to_degrees(),
            tilt: body.tilt().to_degrees(),
        };
        Some(PenetrationRecord { body: self.body, outcome, in_space: Some(in_space) })
    }

    /// Copies the history of the resistance on the same body that this one replaces.
    pub(super) fn continue_from(&mut self, previous: &ObliqueResistance) {
        if previous.body == self.body {
            (self.entered, self.exit, self.damping) = (previous.entered, previous.exit, previous.damping);
        }
    }

    /// Returns the limit on the next time increment: the time to the next plane plus a fraction of the body, and a
    /// fraction of the damping time.
    pub(super) fn limit(&self, stack: &LayerStack, body: &BodyState) -> IncrementLimit {
        let Some(body) = &body.spatial else { return IncrementLimit::NONE };
        let motion = body.motion();
        let scene = self.scene(body, &motion);
        let [low, high] = self.rings.heights(&scene);
        let speed = dot(motion.velocity, self.tilt.up).abs() + body.size * norm(motion.turning);
        let inside = high > stack.planes[0] && low < stack.planes[stack.planes.len() - 1];
        let changes = inside && stack.bounds.is_some();
        let cut = changes || stack.planes.iter().any(|p| (low..=high).contains(p));
        let gap = |p: &f64| if *p > high { p - high } else { low - p };
        let ahead = if cut { 0.0 } else { stack.planes.iter().map(gap).fold(f64::INFINITY, f64::min) };
        let distance = ahead + self.travel * (high - low);
        let mut time = if speed > 0.0 { distance / speed } else { f64::INFINITY };
        if inside && self.damping > 0.0 {
            time = time.min(DAMPED / self.damping);
        }
        IncrementLimit { time, jump: false }
    }

    /// Adds the facet output: one entry per station of each ring.
    pub(super) fn show(&self, stack: &LayerStack, body: &BodyState, fields: &mut FacetFields) {
        let Some(body) = &body.spatial else { return };
        let scene = self.scene(body, &body.motion());
        self.rings.show(stack, &scene, |ring, area, shown| fields.push_station(self.elements[ring], area, shown));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::attitude::plus;

    #[test]
    fn heights_increase_along_the_normal_of_an_inclined_stack() {
        let tilt = StackTilt::new(2.0, 0.5);
        assert!((tilt.height(plus([0.0, 2.0, 0.0], 3.0, tilt.up)) - 5.0).abs() < 1e-15);
        assert!((tilt.height([libm::cos(0.5), 2.0 + libm::sin(0.5), 7.0]) - 2.0).abs() < 1e-15);
    }
}
