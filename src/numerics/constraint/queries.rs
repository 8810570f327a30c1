//! Questions about all constraints in force: prescribed motions, reaction forces, forces and areas of contact pairs.

use super::contact::ContactConstraint;
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

/// Constraints by the degrees of freedom on which they act, for questions about many nodes.
pub struct ConstraintIndex<'a> {
    constraints: &'a [Box<dyn Constraint>],
    /// Node and axis of each prescribed motion, with the index of its constraint, ascending.
    motions: Vec<((usize, usize), usize)>,
    /// Constraints with forces that are no prescribed motions.
    others: Vec<usize>,
}

impl<'a> ConstraintIndex<'a> {
    pub fn new(constraints: &'a [Box<dyn Constraint>]) -> ConstraintIndex<'a> {
        let (mut motions, mut others) = (Vec::new(), Vec::new());
        for (index, constraint) in constraints.iter().enumerate() {
            match constraint.as_kind::<PrescribedMotion>() {
                Some(motion) => motions.extend(motion.node_axes().map(|place| (place, index))),
                None => others.extend(constraint.forces().map(|_| index)),
            }
        }
        motions.sort_unstable();
        ConstraintIndex { constraints, motions, others }
    }

    /// Iterates over the indices of the prescribed motions of a node along an axis, ascending.
    fn motions_of(&self, place: (usize, usize)) -> impl Iterator<Item = usize> {
        let from = self.motions.partition_point(|known| known.0 < place);
        self.motions[from..].iter().take_while(move |known| known.0 == place).map(|known| known.1)
    }

    /// Returns [`reaction`] of a node along an axis.
    pub fn reaction(&self, dofs: &Dofs, place: (usize, usize)) -> f64 {
        let dof = Dof::Node(place.0, place.1);
        let motion = self.motions_of(place).next().and_then(|index| self.constraints[index].as_kind());
        let Some(free) = motion.and_then(|motion: &PrescribedMotion| motion.free_force(dof)) else { return 0.0 };
        let forces = self.others.iter().filter_map(|index| self.constraints[*index].forces());
        let others = forces.fold(0.0, |sum, forces| sum + forces.constraint_force(dof));
        dofs.mass(dof) * dofs.acceleration(dof) - free - others
    }

    /// Returns the indices of the constraints with an impulse on a degree of freedom, ascending, each with the index of the
    /// degree of freedom in the constraint, and whether the motion is prescribed.
    pub fn acting_on(&self, dof: Dof) -> (Vec<(usize, usize)>, bool) {
        let mut indices = self.others.clone();
        if let Dof::Node(node, axis) = dof {
            indices.extend(self.motions_of((node, axis)));
        }
        let is_prescribed = indices.len() > self.others.len();
        indices.sort_unstable();
        indices.dedup();
        let of_dof = |index: usize| Some((index, self.constraints[index].forces()?.index_of(dof)?));
        (indices.into_iter().filter_map(of_dof).collect(), is_prescribed)
    }
}

/// Returns the forces of a contact pair over the previous increment; `None` if the pair is not in force.
pub fn forces_of_pair(constraints: &[Box<dyn Constraint>], pair: usize) -> Option<PairForces> {
    of_kind::<ContactConstraint>(constraints).find_map(|contact| contact.forces_of_pair(pair))
}

/// Returns the area in contact of a pair; `None` if the pair is not in force, NaN for hard contact of a rigid body and a
/// wall.
pub fn area_of_pair(constraints: &[Box<dyn Constraint>], pair: usize) -> Option<f64> {
    of_kind::<ContactConstraint>(constraints).find_map(|contact| contact.area_of_pair(pair))
}
