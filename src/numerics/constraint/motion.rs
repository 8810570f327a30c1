//! Prescribed motions (`*BOUNDARY`) of rigid bodies along z and of nodes along r and z.

use std::collections::HashMap;

use super::{Constraint, ConstraintForces, NodeRelation, StoredConstraint};
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::Memory;
use crate::state::EffectId;
use crate::state::archive::Persist;
use crate::state::dofs::{Dof, Dofs};
use crate::state::limit::IncrementLimit;
use crate::state::magnitude::{AmplitudeClock, Magnitude};

/// The quantity that a motion prescribes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PrescribedQuantity {
    /// Displacement since the start of the step.
    Displacement,
    Velocity,
    Acceleration,
}

impl PrescribedQuantity {
    /// Returns the order of the time derivative, as user subroutines receive it (`jTyp` of VDISP).
    pub fn number(self) -> i32 {
        match self {
            PrescribedQuantity::Displacement => 0,
            PrescribedQuantity::Velocity => 1,
            PrescribedQuantity::Acceleration => 2,
        }
    }

    /// Returns velocity and acceleration at the current instant; `velocity` is the current velocity.
    fn rates(self, magnitude: &Magnitude, clock: &AmplitudeClock<'_>, velocity: f64) -> [f64; 2] {
        match self {
            PrescribedQuantity::Displacement => [magnitude.rate(clock), 0.0],
            PrescribedQuantity::Velocity => [magnitude.at(clock), magnitude.rate(clock)],
            PrescribedQuantity::Acceleration => [velocity, magnitude.at(clock)],
        }
    }

    /// Returns the mid-increment velocity over an increment. `moved` is the displacement since the start of the step. A
    /// prescribed acceleration acts on the given velocity over the given time.
    fn velocity_over(
        self,
        magnitude: &Magnitude,
        clock: &AmplitudeClock<'_>,
        increment: f64,
        moved: f64,
        [velocity, time]: [f64; 2],
    ) -> f64 {
        match self {
            PrescribedQuantity::Displacement => (magnitude.at(&clock.later(increment)) - moved) / increment,
            PrescribedQuantity::Velocity => magnitude.at(&clock.later(0.5 * increment)),
            PrescribedQuantity::Acceleration => velocity + time * magnitude.at(clock),
        }
    }
}

/// Prescribed motion of a list of degrees of freedom.
#[derive(Clone, Debug, Persist, Memory)]
#[persist(fixed: bodies, nodes; derived: id, kind, magnitudes, order, has_begun)]
pub struct PrescribedMotion {
    id: EffectId,
    kind: PrescribedQuantity,
    /// One magnitude for all degrees of freedom, or one for each: bodies first, then nodes.
    magnitudes: Vec<Magnitude>,
    bodies: Vec<BodyMotion>,
    nodes: Vec<NodeMotion>,
    /// Indices in `nodes`, sorted by node and axis.
    order: Vec<u32>,
    /// Whether the motion was in force in a previous step, so that the origins of its displacements are known.
    has_begun: bool,
}

/// A rigid body and its displacement when the motion began. A prescribed displacement is added to it.
#[derive(Clone, Copy, Debug, Persist)]
#[persist(derived: body)]
struct BodyMotion {
    body: usize,
    start: f64,
}

/// A node along one axis.
#[derive(Clone, Copy, Debug, Persist)]
#[persist(derived: node, axis)]
struct NodeMotion {
    node: usize,
    axis: usize,
    /// Coordinate when the motion began; a prescribed displacement is added to it.
    origin: f64,
    /// Force of elements and loads on the degree of freedom.
    force: f64,
    kinetic: f64,
    travel: f64,
}

impl NodeMotion {
    /// Returns node and axis.
    fn place(&self) -> (usize, usize) {
        (self.node, self.axis)
    }
}

impl PrescribedMotion {
    /// Prescribes one magnitude for all of `dofs`, or one for each: bodies first, then nodes.
    pub fn new(id: EffectId, kind: PrescribedQuantity, magnitudes: Vec<Magnitude>, dofs: &[Dof]) -> Self {
        let (mut bodies, mut nodes) = (Vec::new(), Vec::new());
        for &dof in dofs {
            match dof {
                Dof::Body(body) => bodies.push(BodyMotion { body, start: 0.0 }),
                Dof::Node(node, axis) => {
                    nodes.push(NodeMotion { node, axis, origin: 0.0, force: 0.0, kinetic: 0.0, travel: 0.0 });
                }
            }
        }
        let mut order: Vec<u32> = (0..nodes.len() as u32).collect();
        order.sort_by_key(|index| nodes[*index as usize].place());
        PrescribedMotion { id, kind, magnitudes, bodies, nodes, order, has_begun: false }
    }

    /// Corrects velocities of rigid bodies at the current instant.
    pub fn velocities(&self, dofs: &mut Dofs, clock: &AmplitudeClock<'_>) {
        for (i, motion) in self.bodies.iter().enumerate() {
            let body = &mut dofs.bodies[motion.body];
            body.velocity = self.kind.rates(magnitude(&self.magnitudes, i), clock, body.velocity)[0];
        }
    }

    /// Returns node and axis of each motion of a node.
    pub(super) fn node_axes(&self) -> impl Iterator<Item = (usize, usize)> {
        self.nodes.iter().map(NodeMotion::place)
    }

    /// Returns the force of elements and loads on a degree of freedom of a node; `None` if its motion is not prescribed.
    pub fn free_force(&self, dof: Dof) -> Option<f64> {
        self.index_of(dof).map(|index| self.nodes[index].force)
    }

    /// Returns the position of the first motion in the order whose node and axis are not below these.
    fn position_in_order(&self, place: (usize, usize)) -> usize {
        self.order.partition_point(|index| self.nodes[*index as usize].place() < place)
    }

    /// Returns whether it prescribes a zero displacement or a zero velocity.
    fn is_fixed(&self) -> bool {
        self.magnitudes.iter().all(|m| m.value == 0.0) && self.kind != PrescribedQuantity::Acceleration
    }
}

/// Returns the magnitude with index `i`; bodies come before nodes.
fn magnitude(magnitudes: &[Magnitude], i: usize) -> &Magnitude {
    &magnitudes[i.min(magnitudes.len() - 1)]
}

impl Constraint for PrescribedMotion {
    fn effect(&self) -> EffectId {
        self.id
    }

    fn begin(&mut self, dofs: &mut Dofs) {
        self.bodies.iter().for_each(|motion| dofs.bodies[motion.body].prescribed = true);
        if std::mem::replace(&mut self.has_begun, true) {
            return;
        }
        self.bodies.iter_mut().for_each(|motion| motion.start = dofs.bodies[motion.body].displacement);
        // A fixed node starts without velocity.
        let stops = dofs.nodes.previous_dt == 0.0 && self.is_fixed();
        for motion in &mut self.nodes {
            let node = &mut dofs.nodes[motion.node];
            *motion =
                NodeMotion { origin: *node.coordinate(motion.axis), force: 0.0, kinetic: 0.0, travel: 0.0, ..*motion };
            if stops {
                *node.velocity(motion.axis) = 0.0;
            }
        }
    }

    fn accelerations(&mut self, dofs: &mut Dofs, clock: &AmplitudeClock<'_>) {
        for (i, motion) in self.bodies.iter().enumerate() {
            let body = &mut dofs.bodies[motion.body];
            body.acceleration = self.kind.rates(magnitude(&self.magnitudes, i), clock, body.velocity)[1];
            body.reaction = body.mass * body.acceleration - body.force;
        }
        let (nodes, energies) = (&mut dofs.nodes, &mut dofs.energies);
        let (moved, previous_dt) = (nodes.work_pending, nodes.previous_dt);
        for motion in &mut self.nodes {
            let mass = nodes.mass[motion.node];
            let velocity = *nodes[motion.node].velocity(motion.axis);
            let acceleration = &mut nodes.acceleration[motion.node][motion.axis];
            // The pass over nodes took the kinetic energy with the unconstrained acceleration.
            let taken = 0.5 * mass * velocity * (velocity + previous_dt * *acceleration);
            let kinetic = 0.5 * mass * velocity * velocity;
            energies.kinetic += kinetic - taken;
            let force = mass * *acceleration;
            if moved {
                let gained = kinetic - motion.kinetic;
                energies.external += gained - 0.5 * (motion.force + force) * motion.travel;
            }
            (motion.force, motion.kinetic, motion.travel) = (force, kinetic, 0.0);
            *acceleration = 0.0;
        }
    }

    fn motion(&mut self, dofs: &mut Dofs, clock: &AmplitudeClock<'_>, dt: f64) {
        for (i, motion) in self.bodies.iter().enumerate() {
            let body = &mut dofs.bodies[motion.body];
            let start = body.before.displacement;
            let magnitude = magnitude(&self.magnitudes, i);
            let moved = start - motion.start;
            body.velocity_half = self.kind.velocity_over(magnitude, clock, dt, moved, [body.velocity, 0.5 * dt]);
            body.displacement = start + dt * body.velocity_half;
        }
        let is_fixed = self.is_fixed();
        let (half, first) = (dofs.nodes.half, self.bodies.len());
        for (i, motion) in self.nodes.iter_mut().enumerate() {
            let NodeMotion { node, axis, origin, .. } = *motion;
            let old = *dofs.nodes[node].velocity(axis);
            if old == 0.0 && is_fixed {
                continue;
            }
            // The pass over nodes moved the node with its old velocity.
            let place_before = *dofs.nodes[node].coordinate(axis) - dt * old;
            let moved = place_before - origin;
            let magnitude = magnitude(&self.magnitudes, first + i);
            let velocity = self.kind.velocity_over(magnitude, clock, dt, moved, [old, half]);
            *dofs.nodes[node].velocity(axis) = velocity;
            *dofs.nodes[node].coordinate(axis) = place_before + dt * velocity;
            dofs.nodes.acceleration[node][axis] = (velocity - old) / half;
            motion.travel = dt * velocity;
        }
    }

    fn max_increment(&self, clock: &AmplitudeClock<'_>) -> IncrementLimit {
        self.magnitudes.iter().map(|m| m.limit(clock)).fold(IncrementLimit::NONE, IncrementLimit::earlier)
    }

    /// Excludes the gained kinetic energy from the work of the motion, which is computed from changes of kinetic
    /// energy.
    fn masses_changed(&mut self, node: usize, gained: [f64; 2]) {
        let [from, to] = [node, node + 1].inline_map(|node| self.position_in_order((node, 0)));
        for &index in &self.order[from..to] {
            let motion = &mut self.nodes[index as usize];
            motion.kinetic += gained[motion.axis];
        }
    }

    fn forces(&self) -> Option<&dyn ConstraintForces> {
        Some(self)
    }
}

impl ConstraintForces for PrescribedMotion {
    fn index_of(&self, dof: Dof) -> Option<usize> {
        let Dof::Node(node, axis) = dof else { return None };
        let index = *self.order.get(self.position_in_order((node, axis)))? as usize;
        (self.nodes[index].place() == (node, axis)).then_some(index)
    }

    fn impulse(&self, dof: Dof, index: usize, half: f64) -> f64 {
        half * self.current_force(dof, index)
    }

    fn current_force(&self, _dof: Dof, index: usize) -> f64 {
        self.nodes[index].force
    }
}

impl StoredConstraint for PrescribedMotion {
    fn continue_from(&mut self, previous: &dyn Constraint) {
        let Some(previous) = previous.as_kind::<PrescribedMotion>() else { return };
        for motion in &mut self.bodies {
            if let Some(known) = previous.bodies.iter().find(|m| m.body == motion.body) {
                (*motion, self.has_begun) = (*known, true);
            }
        }
        let known: HashMap<_, _> = previous.nodes.iter().map(|m| ((m.node, m.axis), m)).collect();
        for motion in &mut self.nodes {
            if let Some(known) = known.get(&(motion.node, motion.axis)) {
                (*motion, self.has_begun) = (**known, true);
            }
        }
    }

    fn follow_new_mesh(&mut self, previous: &dyn Constraint, nodes: &NodeRelation<'_>, _dofs: &Dofs) {
        let Some(previous) = previous.as_kind::<PrescribedMotion>() else { return };
        for motion in &mut self.bodies {
            let known = previous.bodies.iter().find(|known| known.body == motion.body);
            known.into_iter().for_each(|known| *motion = *known);
        }
        let known: HashMap<_, _> = previous.nodes.iter().map(|m| ((m.node, m.axis), m.origin)).collect();
        // All nodes of a displacement have moved by the same amount, and so have those between them.
        for motion in &mut self.nodes {
            let Some(place) = nodes(motion.node) else { continue };
            if let [Some(a), Some(b)] = place.nodes.inline_map(|node| known.get(&(node, motion.axis))) {
                motion.origin = a + place.share * (b - a);
            }
        }
    }
}
