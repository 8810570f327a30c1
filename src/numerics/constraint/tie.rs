//! Nodes of deformable bodies that belong to a rigid body: they move with it, and it takes their forces.

use super::{Constraint, StoredConstraint};
use crate::kernel::lists::Memory;
use crate::state::EffectId;
use crate::state::archive::Persist;
use crate::state::dofs::Dofs;
use crate::state::magnitude::AmplitudeClock;

/// Nodes that one rigid body carries. Their mass is added to the body and is zero in the solver. The body takes the sum of
/// their forces along z; forces along r balance around the ring.
#[derive(Clone, Debug, PartialEq, Persist, Memory)]
#[persist(derived: id, body, nodes)]
pub struct TiedNodes {
    /// Row of the ledger.
    pub id: EffectId,
    /// Index of the rigid body.
    pub body: usize,
    /// Indices of the nodes, ascending.
    pub nodes: Vec<usize>,
}

impl TiedNodes {
    /// Returns the sum of the forces along z; `of_node` gives the force of elements and loads on a node.
    pub fn force(&self, of_node: impl Fn(usize) -> [f64; 2]) -> f64 {
        self.nodes.iter().map(|&n| of_node(n)[1]).sum()
    }

    /// Moves the nodes with their body and sets their velocity.
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

impl Constraint for TiedNodes {
    fn effect(&self) -> EffectId {
        self.id
    }

    fn begin(&mut self, dofs: &mut Dofs) {
        if dofs.nodes.previous_dt == 0.0 {
            let velocity = dofs.bodies[self.body].velocity;
            self.follow(dofs, velocity);
        }
    }

    /// Sets the acceleration of tied nodes, which is output only.
    fn accelerations(&mut self, dofs: &mut Dofs, _clock: &AmplitudeClock<'_>) {
        let acceleration = dofs.bodies[self.body].acceleration;
        self.nodes.iter().for_each(|&n| dofs.nodes.acceleration[n] = [0.0, acceleration]);
    }

    fn motion(&mut self, dofs: &mut Dofs, _clock: &AmplitudeClock<'_>, _dt: f64) {
        let velocity = dofs.bodies[self.body].velocity_half;
        self.follow(dofs, velocity);
    }

    fn moves_nodes(&self) -> bool {
        true
    }
}

impl StoredConstraint for TiedNodes {}
