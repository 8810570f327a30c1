//! Questions about all constraints in force: prescribed motions, reaction forces, forces and areas of contact pairs.

use super::contact::ContactConstraint;
use super::contact::rigid_wall::RigidWallContact;
use super::motion::PrescribedMotion;
use super::{Constraint, PairForces, of_kind};
use crate::state::dofs::{Dof, Dofs};

/// Returns node and axis of each motion of nodes that constraints prescribe.
pub fn prescribed_motions(constraints: &[Box<dyn Constraint>]) -> impl Iterator<Item = (usize, usize)> {
    of_kind::<PrescribedMotion>(constraints).flat_map(PrescribedMotion::node_axes)
}

/// Returns the reaction force on a degree of freedom whose motion is prescribed; 0 if it is not prescribed. A rigid
/// body stores its own reaction.
pub fn reaction(constraints: &[Box<dyn Constraint>], dofs: &Dofs, dof: Dof) -> f64 {
    if let Dof::Body(b) = dof {
        return dofs.bodies[b].reaction;
    }
    let mut motions = of_kind::<PrescribedMotion>(constraints);
    let Some(free) = motions.find_map(|motion| motion.free_force(dof)) else { return 0.0 };
    let others: f64 = constraints.iter().filter_map(|c| c.forces()).map(|f| f.constraint_force(dof)).sum();
    dofs.mass(dof) * dofs.acceleration(dof) - free - others
}

/// Returns the forces of a contact pair over the previous increment; `None` if the pair is not in force.
pub fn forces_of_pair(constraints: &[Box<dyn Constraint>], pair: usize) -> Option<PairForces> {
    of_kind::<ContactConstraint>(constraints)
        .find_map(|contact| contact.forces_of_pair(pair))
        .or_else(|| of_kind::<RigidWallContact>(constraints).find_map(|wall| wall.forces_of_pair(pair)))
}

/// Returns the area in contact of a pair; `None` if the pair is not in force, NaN for hard contact of a rigid body and a
/// wall.
pub fn area_of_pair(constraints: &[Box<dyn Constraint>], pair: usize) -> Option<f64> {
    of_kind::<ContactConstraint>(constraints)
        .find_map(|contact| contact.area_of_pair(pair))
        .or_else(|| of_kind::<RigidWallContact>(constraints).find_map(|wall| wall.area_of_pair(pair)))
}
