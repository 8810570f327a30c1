//! Constraints: prescribed motions, linear equations, ties and contact, one kind per file. The integrator uses them
//! only through [`Constraint`].

pub mod bonds;
pub mod contact;
pub mod equation;
pub mod motion;
pub mod overlaps;
pub mod rigid_wall_contact;
pub mod system;
pub mod tie;
pub mod user_motion;

use std::any::Any;

use self::contact::curve::PointCarrier;
use crate::kernel::lists::Memory;
use crate::kernel::topology::ElementNodes;
use crate::state::EffectId;
use crate::state::archive::Persist;
use crate::state::dofs::{Dof, Dofs};
use crate::state::limit::IncrementLimit;
use crate::state::magnitude::AmplitudeClock;
use crate::variables::VariableComponent;

/// A constraint in force. In each increment the integrator adds the forces on tied nodes to their bodies
/// ([`ConstraintView::carried`]), calls [`Constraint::accelerations`] and [`Constraint::velocities`], and after the
/// motion [`Constraint::motion`]. Constraints are called in the order of the plan: prescribed motions, equations,
/// contact, ties.
pub trait Constraint: StoredConstraint + Send + Sync {
    /// Returns the ledger row that its run time and memory are charged to.
    fn effect(&self) -> EffectId;

    /// Prepares the constraint. It is called for new and continued constraints at the start of each step in which any
    /// constraint changes.
    fn begin(&mut self, _dofs: &mut Dofs) {}

    /// Corrects accelerations at the current instant.
    fn accelerations(&mut self, _dofs: &mut Dofs, _clock: &AmplitudeClock<'_>) {}

    /// Corrects velocities of rigid bodies at the current instant.
    fn velocities(&mut self, _dofs: &mut Dofs, _clock: &AmplitudeClock<'_>) {}

    /// Corrects the unconstrained motion over an increment of length `dt`, which the integrator has just made, and adds
    /// the work of the constraint to the energies. `clock` is at the start of the increment.
    fn motion(&mut self, dofs: &mut Dofs, clock: &AmplitudeClock<'_>, dt: f64);

    /// Returns the largest length that the constraint allows for the next increment.
    fn max_increment(&self, _clock: &AmplitudeClock<'_>) -> IncrementLimit {
        IncrementLimit::NONE
    }

    /// Returns the properties that the integrator and other constraints read.
    fn view(&self) -> ConstraintView<'_> {
        ConstraintView::default()
    }

    /// Returns the interface to element deletion, changed masses and warnings, if the constraint uses it.
    fn upkeep(&mut self) -> Option<&mut dyn ConstraintUpkeep> {
        None
    }
}

/// A constraint as part of the state: it can be saved, copied and measured, and continued by the constraint that
/// replaces it.
pub trait StoredConstraint: Persist + Memory + CopyConstraint + Any {
    /// Takes the history of the constraint that it replaces.
    fn continue_from(&mut self, _previous: &dyn Constraint) {}
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

/// Properties of a constraint that other code reads.
#[derive(Clone, Copy, Default)]
pub struct ConstraintView<'a> {
    /// Nodes that a rigid body carries, if this is a tie.
    pub carried: Option<CarriedNodes<'a>>,
    /// Whether the constraint moves nodes after the integrator has updated them; then no node is skipped as quiescent.
    pub moves_nodes: bool,
    /// Constraint forces on degrees of freedom.
    pub forces: Option<&'a dyn ConstraintForces>,
    /// Contact output variables.
    pub contact: Option<&'a dyn ContactResults>,
    /// Heat exchange across contact surfaces.
    pub heat: Option<&'a dyn HeatExchange>,
    /// Bound of the square of the highest frequency of springs between bodies, which adds to that of the elements.
    pub squared_frequency: f64,
}

/// Nodes that a rigid body carries. The body takes the sum of their forces along z; forces along r balance around the
/// ring.
#[derive(Clone, Copy)]
pub struct CarriedNodes<'a> {
    /// Index of the rigid body.
    pub body: usize,
    /// Indices of the nodes.
    pub nodes: &'a [usize],
}

impl CarriedNodes<'_> {
    /// Returns the sum of the forces along z; `of_node` gives the force of elements and loads on a node.
    pub fn force(&self, of_node: impl Fn(usize) -> [f64; 2]) -> f64 {
        self.nodes.iter().map(|&n| of_node(n)[1]).sum()
    }
}

/// Forces of a constraint on degrees of freedom of nodes.
pub trait ConstraintForces {
    /// Returns node and axis of each motion that it prescribes.
    fn prescribed(&self) -> Vec<(usize, usize)> {
        Vec::new()
    }

    /// Returns the force of elements and loads on a degree of freedom whose motion it prescribes.
    fn free_force(&self, _dof: Dof) -> Option<f64> {
        None
    }

    /// Returns the force that it exerts on a degree of freedom; prescribed motions excluded.
    fn constraint_force(&self, _dof: Dof) -> f64 {
        0.0
    }

    /// Returns the index at which it stores a degree of freedom; `None` if the constraint has no impulse there. The index is
    /// valid during a step.
    fn index_of(&self, _dof: Dof) -> Option<usize> {
        None
    }

    /// Returns its impulse on a degree of freedom with prescribed motion over the previous increment, in which velocities
    /// changed over the time `half`. A prescribed motion returns the impulse of elements and loads.
    fn impulse(&self, _dof: Dof, _index: usize, _half: f64) -> f64 {
        0.0
    }

    /// Returns the force on the same degree of freedom at the current instant, as [`Self::impulse`]; 0 for contact, which
    /// acts during increments.
    fn current_force(&self, _dof: Dof, _index: usize) -> f64 {
        0.0
    }
}

/// Output variables of surfaces in contact.
pub trait ContactResults {
    /// Returns the place that a new node of the outline takes instead of its place on the edge between two nodes: `share` is
    /// its distance from the first one, as a fraction of the edge.
    fn place_between(&self, _ends: [usize; 2], _share: f64, _dofs: &Dofs) -> Option<[f64; 2]> {
        None
    }

    /// Returns the value at a point of a surface; `None` if the point belongs to no contact surface.
    fn value_at_point(&self, carrier: PointCarrier, part: VariableComponent) -> Option<f64>;

    /// Returns whether contact pressed on a point of a surface in the previous increment; `None` if the point belongs to no
    /// contact surface.
    fn is_pressed(&self, _carrier: PointCarrier) -> Option<bool> {
        None
    }

    /// Returns whether the contact corrects the new place of a point whose mesh moves ([`ConstraintUpkeep::follow_meshes`]),
    /// after [`ConstraintUpkeep::begin_mesh_motion`].
    fn keeps_gaps(&self, _carrier: PointCarrier) -> bool {
        false
    }

    /// Returns the closest place to `place` on the analytical surface that a point is in contact with, at the start of the
    /// current increment; `None` if it has no such surface, or several.
    fn place_on_surface(&self, _carrier: PointCarrier, _place: [f64; 2], _dofs: &Dofs) -> Option<[f64; 2]> {
        None
    }

    /// Returns the forces of a contact pair over the previous increment; `None` if the pair is not in force.
    fn forces_of_pair(&self, pair: usize) -> Option<PairForces>;

    /// Returns the area in contact of a pair; `None` if the pair is not in force, NaN if its area is not computed.
    fn area_of_pair(&self, pair: usize) -> Option<f64>;

    /// Returns the pair that has absorbed the least energy: its name, this energy, and the coordinates of the largest
    /// release in an increment.
    fn lowest_energy(&self) -> Option<(&str, f64, [f64; 2])>;
}

/// Forces on the first surface of a contact pair over the previous increment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PairForces {
    /// Forces of pressure and of friction along 1, 2 and 3.
    pub forces: [[f64; 3]; 2],
    /// Time over which they act; with it they give the impulse.
    pub duration: f64,
}

/// Heat exchange of nodes across contact surfaces.
pub trait HeatExchange {
    /// Passes to `into` the heat rate of each node over the increment `dt` that has just been made. Temperatures are
    /// those at its start. Returns the part generated by friction.
    fn exchange(&self, temperature: &[f64], dt: f64, into: &mut dyn FnMut(usize, f64)) -> f64;

    /// Passes to `into` an upper bound of each node's conductance in the next increment, heat rate per temperature
    /// difference.
    fn largest_exchange(&self, into: &mut dyn FnMut(usize, f64));
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

/// Changes of the model that a constraint follows, and its warnings.
pub trait ConstraintUpkeep {
    /// Informs it that elements with these corner nodes have been deleted.
    fn remove_elements(&mut self, _deleted: &[ElementNodes]) {}

    /// Informs it that the mass of a node has changed; `gained` is the increase of kinetic energy along r and z.
    fn masses_changed(&mut self, _node: usize, _gained: [f64; 2]) {}

    /// Takes the history of the same constraint of a model in which bodies had other meshes.
    fn follow_new_mesh(&mut self, _previous: &dyn Constraint, _nodes: &NodeRelation<'_>, _dofs: &Dofs) {}

    /// Adds the impulses of half an increment to the velocities at the middle of the previous increment. With them and the
    /// accelerations the velocities are those at the current instant. Returns the kinetic energy that they add.
    fn complete_velocities(&mut self, _dofs: &mut Dofs) -> f64 {
        0.0
    }

    /// Allocates for [`Self::follow_meshes`].
    fn reserve_mesh_motion(&mut self) {}

    /// Informs it that adaptive meshes are about to change, at the start of an increment of which only the motion of bodies
    /// has been made.
    fn begin_mesh_motion(&mut self, _dofs: &Dofs) {}

    /// Corrects the new places of nodes of adaptive meshes, so that the constraint continues.
    fn follow_meshes(&mut self, _dofs: &Dofs, _mesh: &mut dyn MeshMotion) {}

    /// Returns the messages of overlaps of bodies that it has found.
    fn overlaps(&mut self, _dofs: &Dofs, _clock: &AmplitudeClock<'_>) -> Vec<String> {
        Vec::new()
    }
}

impl Clone for Box<dyn Constraint> {
    fn clone(&self) -> Self {
        (**self).copy()
    }
}

/// Returns the reaction force on a degree of freedom whose motion is prescribed; 0 if it is not prescribed. A rigid
/// body stores its own reaction.
pub fn reaction(constraints: &[Box<dyn Constraint>], dofs: &Dofs, dof: Dof) -> f64 {
    if let Dof::Body(b) = dof {
        return dofs.bodies[b].reaction;
    }
    let forces = || constraints.iter().filter_map(|c| c.view().forces);
    let Some(free) = forces().find_map(|f| f.free_force(dof)) else { return 0.0 };
    let others: f64 = forces().map(|f| f.constraint_force(dof)).sum();
    dofs.mass(dof) * dofs.acceleration(dof) - free - others
}
