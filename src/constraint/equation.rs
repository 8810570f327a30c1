//! Linear equations between degrees of freedom of nodes, sum of c u = 0, and nodes that move alike, kept exactly.
//! Never here: deck words, rigid bodies.
//!
//! Equations that share degrees of freedom are solved together: with C the coefficients and M the masses, of which those
//! of given motions count as infinite, the multipliers follow from (C M^-1 C^T) lambda = C a, and a -= M^-1 C^T lambda
//! (Lagrange multipliers; Belytschko, Liu and Moran, Nonlinear Finite Elements, 6.2). Velocities are then held to the same
//! equations, which takes in motions that are given and change within the increment. Nodes that move alike are one unknown
//! with the mass and the forces of all; what has no mass follows ([`super::bonds`]).

use super::bonds::Bonds;
use super::{Constraint, ConstraintForces, ConstraintView, StoredConstraint};
use crate::kernel::lists::MemoryUse;
use crate::state::EffectId;
use crate::state::archive::persist_struct;
use crate::state::dofs::{Dof, Dofs};
use crate::state::magnitude::Clock;

#[derive(Clone, Debug)]
pub struct Equations {
    id: EffectId,
    bonds: Bonds,
}

impl Equations {
    pub fn new(id: EffectId, bonds: Bonds) -> Self {
        Equations { id, bonds }
    }

    fn hold_velocities(&mut self, dofs: &mut Dofs, dt: f64, half: f64) {
        self.bonds.systems.iter_mut().for_each(|s| s.hold_velocities(dofs, dt, half));
        self.bonds.followers.iter().for_each(|f| f.hold_velocity(dofs, dt, half));
    }
}

impl Constraint for Equations {
    fn effect(&self) -> EffectId {
        self.id
    }

    fn begin(&mut self, dofs: &mut Dofs) {
        if dofs.nodes.behind == 0.0 {
            self.hold_velocities(dofs, 0.0, 0.0);
        }
    }

    /// The kinetic energy needs no correction: on velocities that satisfy the equations their forces do no work.
    fn accelerations(&mut self, dofs: &mut Dofs, _clock: &Clock<'_>) {
        self.bonds.followers.iter_mut().for_each(|f| f.hand_on(dofs));
        for system in &mut self.bonds.systems {
            let acceleration = &dofs.nodes.acceleration;
            system.solve(dofs, |node, axis| acceleration[node][axis], true);
            system.accelerate(dofs);
        }
        self.bonds.followers.iter().for_each(|f| f.accelerate(dofs));
    }

    fn motion(&mut self, dofs: &mut Dofs, _clock: &Clock<'_>, dt: f64) {
        let half = dofs.nodes.half;
        self.hold_velocities(dofs, dt, half);
    }

    fn view(&self) -> ConstraintView<'_> {
        ConstraintView { moves_nodes: true, forces: Some(self), ..ConstraintView::default() }
    }
}

impl ConstraintForces for Equations {
    fn constraint_force(&self, dof: Dof) -> f64 {
        let Dof::Node(node, axis) = dof else { return 0.0 };
        let of_system = self.bonds.systems.iter().find_map(|s| s.constraint_force(node, axis)).unwrap_or(0.0);
        self.bonds.followers.iter().fold(of_system, |sum, f| sum + f.constraint_force(node, axis))
    }
}

impl StoredConstraint for Equations {
    fn memory(&self) -> MemoryUse {
        MemoryUse::in_use(self.bonds.bytes())
    }
}

persist_struct!(Equations { bonds } derived { id });
