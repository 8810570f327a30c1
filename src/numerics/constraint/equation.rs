//! Linear equations between degrees of freedom of nodes, `sum of c u = 0`, and nodes with equal motion.
//!
//! Equations that share degrees of freedom are solved together. With the coefficients C and the masses M (infinite for
//! prescribed motions), the multipliers follow from (C M^-1 C^T) lambda = C a, and a -= M^-1 C^T lambda (Lagrange
//! multipliers; Belytschko, Liu and Moran, Nonlinear Finite Elements, 6.2). Velocities are then corrected by the same
//! equations, because prescribed motions may change within the increment. Nodes with equal motion are one unknown with
//! their total mass and force. Nodes without mass follow the others ([`super::bonds`]).

use super::bonds::LinkSystem;
use super::{Constraint, ConstraintForces, StoredConstraint};
use crate::kernel::lists::{Memory, MemoryUse};
use crate::state::EffectId;
use crate::state::archive::{Persist, StateArchive};
use crate::state::dofs::{Dof, Dofs};
use crate::state::magnitude::AmplitudeClock;

/// Constraint that enforces linear equations and equal motions.
#[derive(Clone, Debug)]
pub struct EquationConstraint {
    id: EffectId,
    bonds: LinkSystem,
    /// Whether masses of nodes may have changed since the equations were factorised.
    has_new_masses: bool,
}

impl EquationConstraint {
    pub fn new(id: EffectId, bonds: LinkSystem) -> Self {
        EquationConstraint { id, bonds, has_new_masses: true }
    }

    /// Projects velocities at the first instant of a new mesh onto the equations. The impulses between the nodes conserve
    /// momentum. Equation (18.12a).
    pub fn project_velocities(&mut self, dofs: &mut Dofs) {
        self.update_masses(dofs);
        self.hold_velocities(dofs, 0.0, 0.0);
    }

    /// Returns whether a node takes part in an equation or moves with other nodes.
    pub fn has_node(&self, node: usize) -> bool {
        let unknowns = self.bonds.systems.iter().flat_map(|system| &system.unknowns);
        unknowns.into_iter().any(|unknown| unknown.members.contains(&node))
    }

    fn update_masses(&mut self, dofs: &Dofs) {
        if std::mem::take(&mut self.has_new_masses) {
            let mass = &dofs.nodes.mass;
            self.bonds.systems.iter_mut().for_each(|system| system.update_masses(|n| mass[n]));
        }
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
        self.has_new_masses = true;
        if dofs.nodes.previous_dt == 0.0 {
            self.hold_velocities(dofs, 0.0, 0.0);
        }
    }

    /// Corrects accelerations. The kinetic energy needs no correction: velocities satisfy the equations, so that the
    /// constraint forces do no work.
    fn accelerations(&mut self, dofs: &mut Dofs, _clock: &AmplitudeClock<'_>) {
        self.update_masses(dofs);
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

    fn moves_nodes(&self) -> bool {
        true
    }

    fn masses_changed(&mut self, _node: usize, _gained: [f64; 2]) {
        self.has_new_masses = true;
    }

    fn forces(&self) -> Option<&dyn ConstraintForces> {
        Some(self)
    }
}

impl ConstraintForces for EquationConstraint {
    fn constraint_force(&self, dof: Dof) -> f64 {
        let Dof::Node(node, axis) = dof else { return 0.0 };
        self.bonds.constraint_force((node, axis))
    }

    fn index_of(&self, dof: Dof) -> Option<usize> {
        let Dof::Node(node, axis) = dof else { return None };
        self.bonds.acts_on((node, axis)).then_some(0)
    }

    fn impulse(&self, dof: Dof, _index: usize, half: f64) -> f64 {
        let Dof::Node(node, axis) = dof else { return 0.0 };
        half * self.constraint_force(dof) + self.bonds.velocity_impulse((node, axis))
    }

    fn current_force(&self, dof: Dof, _index: usize) -> f64 {
        self.constraint_force(dof)
    }
}

impl StoredConstraint for EquationConstraint {}

impl Memory for EquationConstraint {
    fn memory(&self) -> MemoryUse {
        MemoryUse::in_use(self.bonds.bytes())
    }
}

impl Persist for EquationConstraint {
    fn persist(&mut self, archive: &mut StateArchive<'_>) {
        let EquationConstraint { id: _, bonds, has_new_masses } = self;
        bonds.persist(archive);
        // The factors follow from the masses.
        *has_new_masses |= archive.reads();
    }
}
