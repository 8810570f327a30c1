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

use self::contact::curve::Carrier;
use crate::kernel::topology::ElementNodes;
use crate::load::GeneralizedForce;
use crate::state::EffectId;
use crate::state::archive::Persist;
use crate::state::dofs::{Dof, Dofs};
use crate::state::limit::Limit;
use crate::state::magnitude::Clock;
use crate::variables::Part;

/// A constraint over a step. In each increment the integrator calls [`Constraint::passes_on`], [`Constraint::accelerations`],
/// [`Constraint::velocities`] and, behind the motion, [`Constraint::motion`]; constraints follow each other in the order of the
/// plan: prescribed motions, equations, contact, ties.
pub trait Constraint: Persist + Send + Sync {
    /// Its row of the ledger.
    fn id(&self) -> EffectId;

    /// The step begins.
    fn begin(&mut self, _dofs: &mut Dofs) {}

    /// Generalised forces that it passes on from nodes to rigid bodies: one where it carries nodes, else none.
    fn slots(&self) -> Vec<GeneralizedForce> {
        Vec::new()
    }

    /// Writes these forces, given the force of elements and loads on a node.
    fn passes_on(&self, _force: &dyn Fn(usize) -> [f64; 2], _out: &mut [f64]) {}

    /// Changes accelerations at the instant's own time.
    fn accelerations(&mut self, _dofs: &mut Dofs, _clock: &Clock<'_>) {}

    /// Changes velocities of rigid bodies at the instant's own time.
    fn velocities(&mut self, _dofs: &mut Dofs, _clock: &Clock<'_>) {}

    /// Changes the motion over an increment of the length `dt`, which all that moves has just made freely; books its work. The
    /// clock stands at the increment's start.
    fn motion(&mut self, dofs: &mut Dofs, clock: &Clock<'_>, dt: f64);

    /// How far the next increment may go.
    fn limit(&self, _clock: &Clock<'_>) -> Limit {
        Limit::NONE
    }

    /// Force of elements and loads on a degree of freedom whose motion it prescribes.
    fn free_force(&self, _dof: Dof) -> Option<f64> {
        None
    }

    /// Force that it exerts on a degree of freedom beside prescribed motions.
    fn pull(&self, _dof: Dof) -> f64 {
        0.0
    }

    /// Elements with these boundaries are deleted.
    fn release(&mut self, _deleted: &[ElementNodes]) {}

    /// A node has another mass; its kinetic energy grew by so much along r and z.
    fn mass_changed(&mut self, _node: usize, _gained: [f64; 2]) {}

    /// Whether it moves nodes behind the passes over them, so that none may be passed over as quiescent.
    fn moves_nodes(&self) -> bool {
        false
    }

    /// Degrees of freedom of nodes whose motion it prescribes.
    fn prescribes(&self) -> Vec<(usize, usize)> {
        Vec::new()
    }

    /// Whether it holds them where they are.
    fn holds(&self) -> bool {
        false
    }

    /// Nodes that a rigid body carries.
    fn carries(&self) -> &[usize] {
        &[]
    }

    /// A number that it shows at a point of a surface.
    fn at_point(&self, _carrier: Carrier, _part: Part) -> Option<f64> {
        None
    }

    /// A number that it shows of two surfaces in contact.
    fn of_pair(&self, _pair: usize, _part: Part) -> Option<f64> {
        None
    }

    /// Gives nodes the heat a time that it passes on over the increment `dt` whose motion it has just made, with temperatures at its
    /// start; returns what friction made of it.
    fn heats(&self, _temperature: &[f64], _dt: f64, _into: &mut dyn FnMut(usize, f64)) -> f64 {
        0.0
    }

    /// Tells what nodes could at most exchange through it in the increment ahead, heat a time and temperature.
    fn conducts(&self, _into: &mut dyn FnMut(usize, f64)) {}

    /// What the step that ends should be told.
    fn warnings(&mut self, _dofs: &Dofs, _clock: &Clock<'_>) -> Vec<String> {
        Vec::new()
    }

    /// Bytes that it holds.
    fn bytes(&self) -> usize;

    /// Another one in the same state.
    fn copy(&self) -> Box<dyn Constraint>;
}

impl Clone for Box<dyn Constraint> {
    fn clone(&self) -> Self {
        self.copy()
    }
}

/// Force that constraints exert on a degree of freedom whose motion is prescribed; 0 where none is. A rigid body keeps its own.
pub fn reaction(constraints: &[Box<dyn Constraint>], dofs: &Dofs, dof: Dof) -> f64 {
    if let Dof::Body(b) = dof {
        return dofs.bodies[b].reaction;
    }
    let Some(force) = constraints.iter().find_map(|c| c.free_force(dof)) else { return 0.0 };
    let pull: f64 = constraints.iter().map(|c| c.pull(dof)).sum();
    dofs.mass(dof) * dofs.acceleration(dof) - force - pull
}
