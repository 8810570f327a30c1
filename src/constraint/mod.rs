//! Constraints: what is prescribed, tied, linked or kept apart, one file a kind. The integrator knows none by name.
//! Never here: loads.

pub mod bonds;
pub mod contact;
mod dependence;
pub mod equation;
pub mod motion;
pub mod overlaps;
pub mod rigid_wall_contact;
pub mod system;
pub mod tie;
pub mod user_motion;

use std::any::Any;

use self::contact::curve::Carrier;
use crate::kernel::lists::MemoryUse;
use crate::kernel::topology::ElementNodes;
use crate::state::EffectId;
use crate::state::archive::Persist;
use crate::state::dofs::{Dof, Dofs};
use crate::state::limit::Limit;
use crate::state::magnitude::Clock;
use crate::variables::Part;

/// A constraint in force. In each increment the integrator transfers forces to bodies that carry nodes ([`ConstraintView::carried`]), calls
/// [`Constraint::accelerations`], [`Constraint::velocities`] and, after the motion, [`Constraint::motion`]; constraints follow each
/// other in the order of the plan: prescribed motions, equations, contact, ties.
pub trait Constraint: StoredConstraint + Send + Sync {
    /// Row of the ledger that its run time and memory belong to.
    fn effect(&self) -> EffectId;

    /// The constraints in force have changed: it begins, or goes on beside others.
    fn begin(&mut self, _dofs: &mut Dofs) {}

    /// Changes accelerations at the instant's own time.
    fn accelerations(&mut self, _dofs: &mut Dofs, _clock: &Clock<'_>) {}

    /// Changes velocities of rigid bodies at the instant's own time.
    fn velocities(&mut self, _dofs: &mut Dofs, _clock: &Clock<'_>) {}

    /// Changes the motion over an increment of the length `dt`, which all that moves has just made freely; books its work. The
    /// clock stands at the increment's start.
    fn motion(&mut self, dofs: &mut Dofs, clock: &Clock<'_>, dt: f64);

    /// How far the next increment may go.
    fn max_increment(&self, _clock: &Clock<'_>) -> Limit {
        Limit::NONE
    }

    /// The properties that the integrator and other constraints read.
    fn view(&self) -> ConstraintView<'_> {
        ConstraintView::default()
    }

    /// Where it follows changes of elements and masses, or has something to warn of.
    fn upkeep(&mut self) -> Option<&mut dyn ConstraintUpkeep> {
        None
    }
}

/// A constraint as an object of the state: saved, copied, measured, continued by the one that replaces it.
pub trait StoredConstraint: Persist + CopyConstraint + Any {
    /// Takes over the memory of a constraint that it replaces.
    fn continue_from(&mut self, _previous: &dyn Constraint) {}

    /// Memory of its arrays.
    fn memory(&self) -> MemoryUse;
}

/// Copies of a constraint behind its interface.
pub trait CopyConstraint {
    /// Another one in the same state.
    fn copy(&self) -> Box<dyn Constraint>;
}

impl<C: Constraint + Clone> CopyConstraint for C {
    fn copy(&self) -> Box<dyn Constraint> {
        Box::new(self.clone())
    }
}

/// What others see of a constraint.
#[derive(Clone, Copy, Default)]
pub struct ConstraintView<'a> {
    pub carried: Option<CarriedNodes<'a>>,
    /// Whether it moves nodes after the passes over them, so that none may be passed over as quiescent.
    pub moves_nodes: bool,
    pub forces: Option<&'a dyn ConstraintForces>,
    pub contact: Option<&'a dyn ContactResults>,
    pub heat: Option<&'a dyn HeatExchange>,
}

/// Nodes that a rigid body carries: it takes the sum of their forces along z. Forces along r balance around the ring.
#[derive(Clone, Copy)]
pub struct CarriedNodes<'a> {
    pub body: usize,
    pub nodes: &'a [usize],
}

impl CarriedNodes<'_> {
    /// Sum of the forces along z, given the force of elements and loads on a node.
    pub fn force(&self, of_node: impl Fn(usize) -> [f64; 2]) -> f64 {
        self.nodes.iter().map(|&n| of_node(n)[1]).sum()
    }
}

/// Forces of a constraint on degrees of freedom of nodes.
pub trait ConstraintForces {
    /// Node and axis of motions that it prescribes.
    fn prescribed(&self) -> Vec<(usize, usize)> {
        Vec::new()
    }

    /// Force of elements and loads on a degree of freedom whose motion it prescribes.
    fn free_force(&self, _dof: Dof) -> Option<f64> {
        None
    }

    /// Force that it exerts on a degree of freedom beside prescribed motions.
    fn constraint_force(&self, _dof: Dof) -> f64 {
        0.0
    }
}

/// Output variables of surfaces in contact.
pub trait ContactResults {
    /// Value at a point of a surface; `None` where that is in no contact.
    fn value_at_point(&self, carrier: Carrier, part: Part) -> Option<f64>;

    /// Value of a pair of surfaces; `None` where it is not in force.
    fn value_of_pair(&self, pair: usize, part: Part) -> Option<f64>;
}

pub trait HeatExchange {
    /// Gives nodes the heat a time that is exchanged over the increment `dt` whose motion has just been made, with temperatures at its
    /// start; returns the part that friction has made.
    fn exchange(&self, temperature: &[f64], dt: f64, into: &mut dyn FnMut(usize, f64)) -> f64;

    /// Gives what nodes could at most exchange in the next increment, heat a time and temperature.
    fn largest_exchange(&self, into: &mut dyn FnMut(usize, f64));
}

/// Changes that a constraint follows, and its warnings.
pub trait ConstraintUpkeep {
    /// Elements with these corner nodes have been deleted.
    fn remove_elements(&mut self, _deleted: &[ElementNodes]) {}

    /// A node has another mass; its kinetic energy grew by so much along r and z.
    fn masses_changed(&mut self, _node: usize, _gained: [f64; 2]) {}

    fn warnings(&mut self, _dofs: &Dofs, _clock: &Clock<'_>) -> Vec<String> {
        Vec::new()
    }
}

impl Clone for Box<dyn Constraint> {
    fn clone(&self) -> Self {
        (**self).copy()
    }
}

/// Reaction force on a degree of freedom whose motion is prescribed; 0 where none is. A rigid body keeps its own.
pub fn reaction(constraints: &[Box<dyn Constraint>], dofs: &Dofs, dof: Dof) -> f64 {
    if let Dof::Body(b) = dof {
        return dofs.bodies[b].reaction;
    }
    let forces = || constraints.iter().filter_map(|c| c.view().forces);
    let Some(free) = forces().find_map(|f| f.free_force(dof)) else { return 0.0 };
    let others: f64 = forces().map(|f| f.constraint_force(dof)).sum();
    dofs.mass(dof) * dofs.acceleration(dof) - free - others
}
