//! Motion of a deformable face over the next increment without its own resistance: the velocity that resistance can
//! take from the face without reversing it or doing work on it.

use crate::kernel::lanes::InlineMap;
use crate::load::SceneView;
use crate::mesh::surface::CurrentFace;
use crate::state::archive::Persist;

/// Motion of a node at the previous instant, from which the effect of constraints follows.
#[derive(Clone, Copy, Debug, Default, Persist)]
pub(super) struct PreviousMotion {
    /// Velocity in the middle of the increment before that instant.
    velocity: [f64; 2],
    /// Sum of the forces of elements and loads.
    force: [f64; 2],
}

/// Largest change of velocity by constraints, relative to the other changes, that is regarded as rounding.
const ROUNDING: f64 = 1e-6;

impl PreviousMotion {
    /// Returns the motion of a node at the current instant; `loads` are the forces of loads on all nodes.
    pub(super) fn now(view: &SceneView<'_>, loads: &[[f64; 2]], node: usize) -> PreviousMotion {
        PreviousMotion { velocity: view.dofs.nodes.velocity_after(node, 0.0), force: known_force(view, loads, node) }
    }
}

/// Motion of a face along a direction, from sums over its two nodes. Constraints are taken to change the velocity of a
/// node as over the previous increment.
pub(super) struct FaceMotion {
    /// Velocity in the middle of the previous increment.
    before: f64,
    /// Velocity in the middle of the next increment without the resistance of the face.
    after: f64,
    /// Whether constraints, or loads that are evaluated later, act on the nodes along the direction.
    pub(super) is_constrained: bool,
}

impl FaceMotion {
    /// Returns the motion along `direction`; `loads` are the forces of other loads and faces on all nodes.
    #[inline]
    pub(super) fn new(
        view: &SceneView<'_>,
        face: &CurrentFace,
        direction: [f64; 2],
        (previous, loads): (&[PreviousMotion; 2], &[[f64; 2]]),
    ) -> FaceMotion {
        let nodes = &view.dofs.nodes;
        let mut motion = FaceMotion { before: 0.0, after: 0.0, is_constrained: false };
        for (&n, previous) in face.nodes.iter().zip(previous) {
            let (velocity, force) = (nodes.velocity_after(n, 0.0), known_force(view, loads, n));
            let [dt, half] = [nodes.previous_dt, nodes.half].inline_map(|time| time * nodes.inverse_mass[n]);
            let along = free_direction(view, n, direction);
            let part = |vector: [f64; 2]| along[0] * vector[0] + along[1] * vector[1];
            let reaction = |i: usize| velocity[i] - previous.velocity[i] - half * previous.force[i];
            let change = |i: usize| dt * force[i] + reaction(i);
            motion.before += part(velocity);
            motion.after += part(velocity) + part([change(0), change(1)]);
            let others = |i: usize| {
                along[i].abs() * ((velocity[i] - previous.velocity[i]).abs() + (half * previous.force[i]).abs())
            };
            motion.is_constrained |= part([reaction(0), reaction(1)]).abs() > ROUNDING * (others(0) + others(1));
        }
        motion
    }

    /// Returns the largest velocity that resistance can take from the face, as a sum over its nodes; negative if the
    /// face moves away from the resistance. A larger one would reverse the motion or do work on the body: the force of
    /// an increment acts with the mean of the velocities in the middle of the increments before and after it. Equation
    /// (2.17).
    pub(super) fn velocity_to_rest(&self) -> f64 {
        self.after.min(self.after + self.before)
    }
}

/// Returns the velocity that nodal forces take from a face along `direction` in the next increment, as a sum over its
/// nodes.
#[inline]
pub(super) fn velocity_lost(
    view: &SceneView<'_>,
    face: &CurrentFace,
    direction: [f64; 2],
    resistance: &[[f64; 2]; 2],
) -> f64 {
    let nodes = &view.dofs.nodes;
    let lost = |(&n, force): (&usize, &[f64; 2])| {
        let along = free_direction(view, n, direction);
        nodes.previous_dt * nodes.inverse_mass[n] * (along[0] * force[0] + along[1] * force[1])
    };
    -face.nodes.iter().zip(resistance).map(lost).sum::<f64>()
}

/// Returns the components of a direction along which a node can move: a node on the axis does not move along r.
fn free_direction(view: &SceneView<'_>, node: usize, direction: [f64; 2]) -> [f64; 2] {
    [if view.dofs.nodes[node].r == 0.0 { 0.0 } else { direction[0] }, direction[1]]
}

/// Returns the sum of the forces of elements and loads on a node.
fn known_force(view: &SceneView<'_>, loads: &[[f64; 2]], node: usize) -> [f64; 2] {
    let ([r, z], [more_r, more_z]) = (view.element_force.map_or([0.0; 2], |force| force(node)), loads[node]);
    [r + more_r, z + more_z]
}
