//! Linear equations between degrees of freedom of nodes, `sum of c u = 0`, and nodes with equal motion.
//!
//! Equations that share degrees of freedom are solved together. With the coefficients C and the masses M (infinite for
//! prescribed motions), the multipliers follow from (C M^-1 C^T) lambda = C a, and a -= M^-1 C^T lambda (Lagrange
//! multipliers; Belytschko, Liu and Moran, Nonlinear Finite Elements, 6.2). Velocities are then corrected by the same
//! equations, because prescribed motions may change within the increment. Nodes with equal motion are one unknown with
//! their total mass and force. Nodes without mass follow the others ([`super::bonds`]).

use super::bonds::LinkSystem;
use super::{Constraint, ConstraintForces, ConstraintView, StoredConstraint};
use crate::kernel::lists::MemoryUse;
use crate::state::EffectId;
use crate::state::archive::persist_struct;
use crate::state::dofs::{Dof, Dofs};
use crate::state::magnitude::AmplitudeClock;

/// Constraint that enforces linear equations and equal motions.
#[derive(Clone, Debug)]
pub struct EquationConstraint {
    id: EffectId,
    bonds: LinkSystem,
}

impl EquationConstraint {
    pub fn new(id: EffectId, bonds: LinkSystem) -> Self {
        EquationConstraint { id, bonds }
    }

    fn hold_velocities(&mut self, dofs: &mut Dofs, dt: f64, half: f64) {
        self.bonds.systems.iter_mut().for_each(|s| s.hold_velocities(dofs, dt, half));
        self.bonds.followers.iter().for_each(|f| f.follow_velocity(dofs, dt, half));
    }
}

impl Constraint for EquationConstraint {
    fn effect(&self) -> EffectId {
        self.id
    }

    fn begin(&mut self, dofs: &mut Dofs) {
        if dofs.nodes.previous_dt == 0.0 {
            self.hold_velocities(dofs, 0.0, 0.0);
        }
    }

    /// Corrects accelerations. The kinetic energy needs no correction: velocities satisfy the equations, so that the
    /// constraint forces do no work.
    fn accelerations(&mut self, dofs: &mut Dofs, _clock: &AmplitudeClock<'_>) {
        self.bonds.followers.iter_mut().for_each(|f| f.transfer_load(dofs));
        for system in &mut self.bonds.systems {
            let acceleration = &dofs.nodes.acceleration;
            system.solve(dofs, |node, axis| acceleration[node][axis], true);
            system.accelerate(dofs);
        }
        self.bonds.followers.iter().for_each(|f| f.accelerate(dofs));
    }

    fn motion(&mut self, dofs: &mut Dofs, _clock: &AmplitudeClock<'_>, dt: f64) {
        let half = dofs.nodes.half;
        self.hold_velocities(dofs, dt, half);
    }

    fn view(&self) -> ConstraintView<'_> {
        ConstraintView { moves_nodes: true, forces: Some(self), ..ConstraintView::default() }
    }
}

impl ConstraintForces for EquationConstraint {
    fn constraint_force(&self, dof: Dof) -> f64 {
        let Dof::Node(node, axis) = dof else { return 0.0 };
        let of_system = self.bonds.systems.iter().find_map(|s| s.constraint_force(node, axis)).unwrap_or(0.0);
        self.bonds.followers.iter().fold(of_system, |sum, f| sum + f.constraint_force(node, axis))
    }

    fn index_of(&self, dof: Dof) -> Option<usize> {
        let Dof::Node(node, axis) = dof else { return None };
        let LinkSystem { systems, followers } = &self.bonds;
        let acts = systems.iter().any(|s| s.has(node, axis)) || followers.iter().any(|f| f.loads(node, axis));
        acts.then_some(0)
    }

    fn impulse(&self, dof: Dof, _index: usize, half: f64) -> f64 {
        let Dof::Node(node, axis) = dof else { return 0.0 };
        half * self.constraint_force(dof)
            + self.bonds.systems.iter().map(|s| s.velocity_impulse(node, axis)).sum::<f64>()
    }

    fn current_force(&self, dof: Dof, _index: usize) -> f64 {
        self.constraint_force(dof)
    }
}

impl StoredConstraint for EquationConstraint {
    fn memory(&self) -> MemoryUse {
        MemoryUse::in_use(self.bonds.bytes())
    }
}

persist_struct!(EquationConstraint { bonds } derived { id });
