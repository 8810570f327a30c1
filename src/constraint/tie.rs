//! Nodes of deformable bodies that belong to a rigid body as well: they move with it, and it takes their forces.
//! Never here: the motion of rigid bodies.

use super::{CarriedNodes, Constraint, ConstraintView, StoredConstraint};
use crate::kernel::lists::MemoryUse;
use crate::state::EffectId;
use crate::state::archive::persist_struct;
use crate::state::dofs::Dofs;
use crate::state::magnitude::Clock;

/// The nodes that one rigid body carries. Their mass is the body's, in the solver they have none.
#[derive(Clone, Debug, PartialEq)]
pub struct Tie {
    pub id: EffectId,
    pub body: usize,
    /// Nodes, ascending.
    pub nodes: Vec<usize>,
}

impl Tie {
    /// Puts tied nodes where their body is, with the velocity that it moves with.
    fn follow(&self, dofs: &mut Dofs, velocity: f64) {
        let displacement = dofs.bodies[self.body].displacement;
        for &n in &self.nodes {
            let [r, z] = dofs.nodes.start[n];
            let node = &mut dofs.nodes[n];
            (node.r, node.z) = (r, z + displacement);
            (node.v_r, node.v_z) = (0.0, velocity);
        }
    }
}

impl Constraint for Tie {
    fn effect(&self) -> EffectId {
        self.id
    }

    fn begin(&mut self, dofs: &mut Dofs) {
        if dofs.nodes.behind == 0.0 {
            let velocity = dofs.bodies[self.body].velocity;
            self.follow(dofs, velocity);
        }
    }

    /// Tied nodes show the acceleration of their body.
    fn accelerations(&mut self, dofs: &mut Dofs, _clock: &Clock<'_>) {
        let acceleration = dofs.bodies[self.body].acceleration;
        self.nodes.iter().for_each(|&n| dofs.nodes.acceleration[n] = [0.0, acceleration]);
    }

    fn motion(&mut self, dofs: &mut Dofs, _clock: &Clock<'_>, _dt: f64) {
        let velocity = dofs.bodies[self.body].velocity_half;
        self.follow(dofs, velocity);
    }

    fn view(&self) -> ConstraintView<'_> {
        let carried = Some(CarriedNodes { body: self.body, nodes: &self.nodes });
        ConstraintView { carried, moves_nodes: true, ..ConstraintView::default() }
    }
}

impl StoredConstraint for Tie {
    fn memory(&self) -> MemoryUse {
        MemoryUse::of(&self.nodes)
    }
}

persist_struct!(Tie {} derived { id, body, nodes });
