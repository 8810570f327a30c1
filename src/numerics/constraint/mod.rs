//! Constraints: prescribed motions, linear equations, ties and contact, one kind per file. What all kinds have is in
//! [`Constraint`].

pub mod bonds;
pub mod contact;
pub mod equation;
pub mod motion;
pub mod overlaps;
mod queries;
pub mod system;
pub mod tie;
pub mod user_motion;

use std::any::Any;

pub use self::queries::{ConstraintIndex, area_of_pair, forces_of_pair, prescribed_motions, reaction};
use crate::kernel::lists::Memory;
use crate::routines::FrictionInput;
use crate::state::EffectId;
use crate::state::archive::Persist;
use crate::state::dofs::{Dof, Dofs};
use crate::state::halt::HaltReason;
use crate::state::limit::IncrementLimit;
use crate::state::magnitude::AmplitudeClock;

/// A constraint in force. In each increment the integrator adds the forces on tied nodes to their bodies
/// ([`tie::TiedNodes::force`]), calls [`Constraint::accelerations`] and [`motion::PrescribedMotion::velocities`], and
/// after the motion [`Constraint::motion`]. Constraints are called in the order of the plan: prescribed motions,
/// equations, contact, ties. What only one kind of constraint has is a method of its type; [`of_kind`] finds it.
pub trait Constraint: StoredConstraint + Send + Sync {
    /// Returns the ledger row that its run time and memory are charged to.
    fn effect(&self) -> EffectId;

    /// Prepares the constraint. It is called for new and continued constraints at the start of each step in which any
    /// constraint changes.
    fn begin(&mut self, _dofs: &mut Dofs) {}

    /// Corrects accelerations at the current instant.
    fn accelerations(&mut self, _dofs: &mut Dofs, _clock: &AmplitudeClock<'_>) {}

    /// Corrects the unconstrained motion over an increment of length `dt`, which the integrator has just made, and adds
    /// the work of the constraint to the energies. `clock` is at the start of the increment.
    fn motion(&mut self, dofs: &mut Dofs, clock: &AmplitudeClock<'_>, dt: f64);

    /// As [`Constraint::motion`], with a user subroutine for friction.
    ///
    /// # Errors
    /// If the subroutine fails.
    fn motion_with_friction(
        &mut self,
        dofs: &mut Dofs,
        clock: &AmplitudeClock<'_>,
        dt: f64,
        _friction: FrictionInput<'_>,
    ) -> Result<(), HaltReason> {
        self.motion(dofs, clock, dt);
        Ok(())
    }

    /// Returns the largest length that the constraint allows for the next increment.
    fn max_increment(&self, _clock: &AmplitudeClock<'_>) -> IncrementLimit {
        IncrementLimit::NONE
    }

    /// Returns whether the constraint moves nodes after the integrator has updated them; then no node is skipped as
    /// quiescent.
    fn moves_nodes(&self) -> bool {
        false
    }

    /// Informs it that the mass of a node has changed; `gained` is the increase of kinetic energy along r and z.
    fn masses_changed(&mut self, _node: usize, _gained: [f64; 2]) {}

    /// Returns the constraint forces on degrees of freedom, if it has any.
    fn forces(&self) -> Option<&dyn ConstraintForces> {
        None
    }
}

/// A constraint as part of the state: it can be saved, copied and measured, and continued by the constraint that
/// replaces it.
pub trait StoredConstraint: Persist + Memory + CopyConstraint + Any {
    /// Takes the history of the constraint that it replaces.
    fn continue_from(&mut self, _previous: &dyn Constraint) {}

    /// Takes the history of the same constraint of a model in which bodies had other meshes.
    fn follow_new_mesh(&mut self, _previous: &dyn Constraint, _nodes: &NodeRelation<'_>, _dofs: &Dofs) {}
}

/// Copies of a constraint trait object.
pub trait CopyConstraint {
    /// Returns a copy in the same state.
    fn copy(&self) -> Box<dyn Constraint>;
}

impl<C: Constraint + Clone> CopyConstraint for C {
    fn copy(&self) -> Box<dyn Constraint> {
        Box::new(self.clone())
    }
}

impl Clone for Box<dyn Constraint> {
    fn clone(&self) -> Self {
        (**self).copy()
    }
}

impl dyn Constraint {
    /// Returns the constraint as one of the kind `C`; `None` if it is of another kind.
    pub fn as_kind<C: Constraint>(&self) -> Option<&C> {
        (self as &dyn Any).downcast_ref()
    }
}

/// Returns the constraints of the kind `C` in a list, in its order.
pub fn of_kind<C: Constraint>(constraints: &[Box<dyn Constraint>]) -> impl Iterator<Item = &C> {
    constraints.iter().filter_map(|constraint| constraint.as_kind())
}

/// Returns the constraints of the kind `C` in a list, in its order, to change them.
pub fn of_kind_mut<C: Constraint>(constraints: &mut [Box<dyn Constraint>]) -> impl Iterator<Item = &mut C> {
    constraints.iter_mut().filter_map(|constraint| (&mut **constraint as &mut dyn Any).downcast_mut())
}

/// Forces of a constraint on degrees of freedom of nodes.
pub trait ConstraintForces {
    /// Returns the force that it exerts on a degree of freedom; prescribed motions excluded.
    fn constraint_force(&self, _dof: Dof) -> f64 {
        0.0
    }

    /// Returns the index at which it stores a degree of freedom; `None` if the constraint has no impulse there. The index is
    /// valid during a step.
    fn index_of(&self, dof: Dof) -> Option<usize>;

    /// Returns its impulse on a degree of freedom with prescribed motion over the previous increment, in which velocities
    /// changed over the time `half`. A prescribed motion returns the impulse of elements and loads.
    fn impulse(&self, dof: Dof, index: usize, half: f64) -> f64;

    /// Returns the force on the same degree of freedom at the current instant, as [`Self::impulse`]; 0 for contact, which
    /// acts during increments.
    fn current_force(&self, _dof: Dof, _index: usize) -> f64 {
        0.0
    }
}

/// Forces on the first surface of a contact pair over the previous increment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PairForces {
    /// Forces of pressure and of friction along 1, 2 and 3.
    pub forces: [[f64; 3]; 2],
    /// Time over which they act; with it they give the impulse.
    pub duration: f64,
}

/// New places of the nodes of adaptive meshes.
pub trait MeshMotion {
    /// Returns the new place of a node; `None` if its mesh does not change now.
    fn place(&self, node: usize) -> Option<[f64; 2]>;

    /// Returns whether the new place of a node may be corrected along r and z.
    fn is_free(&self, node: usize) -> [bool; 2];

    /// Moves the new place of a node.
    fn shift(&mut self, node: usize, by: [f64; 2]);
}

/// Place of a node in a previous mesh of its body.
#[derive(Clone, Copy, Debug)]
pub struct PreviousPlace {
    /// Nodes of the previous model between which it is; twice the same one at the place of this node.
    pub nodes: [usize; 2],
    /// Distance from the first node, as a fraction of that between both.
    pub share: f64,
}

impl PreviousPlace {
    /// Returns the place of a node of the previous model.
    pub fn at(node: usize) -> PreviousPlace {
        PreviousPlace { nodes: [node; 2], share: 0.0 }
    }

    /// Returns the node of the previous model at this place; `None` between two nodes.
    pub fn node(&self) -> Option<usize> {
        (self.nodes[0] == self.nodes[1]).then_some(self.nodes[0])
    }
}

/// Returns the place of a node of a model with a new mesh in the previous model; `None` inside a new mesh.
pub type NodeRelation<'a> = dyn Fn(usize) -> Option<PreviousPlace> + 'a;
