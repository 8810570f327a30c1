//! `*CONTACT PAIR` of what deforms with analytical planes.
//! Never here: the contact itself.

use std::collections::HashSet;

use super::{Compiler, State};
use crate::constraint::Constraint;
use crate::constraint::wall::Wall;
use crate::deck::Diagnostic;
use crate::model::{Contact, Plane, Step};

impl Compiler<'_> {
    /// The planes of a step with the nodes that may meet them.
    pub(super) fn walls(
        &mut self,
        step: &Step,
        state: &State,
        prescribed: &HashSet<(usize, usize)>,
    ) -> Vec<Box<dyn Constraint>> {
        let mut walls: Vec<Box<dyn Constraint>> = Vec::new();
        for contact in &step.contacts {
            match self.wall(step, contact, state, prescribed) {
                Ok(mut wall) => {
                    let friction =
                        if wall.friction > 0.0 { format!(", friction {}", wall.friction) } else { String::new() };
                    let detail =
                        format!("{} on {}, z = {}, kinematic{friction}", contact.set, contact.plane, wall.height);
                    wall.id = self.cause(contact.span, "contact with a plane", wall.nodes.len(), "nodes", detail);
                    walls.push(Box::new(wall));
                }
                Err(why) => {
                    let finding = Diagnostic::error("P021", why).at(contact.span, "this pair");
                    self.diagnostics.push(finding);
                }
            }
        }
        walls
    }

    fn wall(
        &self,
        step: &Step,
        contact: &Contact,
        state: &State,
        prescribed: &HashSet<(usize, usize)>,
    ) -> Result<Wall, String> {
        let plane: &Plane = &self.model.planes[&contact.plane];
        let nothing = "no node of this surface deforms";
        let reference =
            plane.reference.ok_or("the analytical surface belongs to no *RIGID BODY, ANALYTICAL SURFACE=")?;
        let body = *self.body_of_node.get(&reference).ok_or("the plane's rigid body is missing")?;
        if !step.boundaries.iter().any(|b| b.dof == 2 && b.nodes.contains(&reference)) {
            return Err("the plane's reference node must be held or moved by *BOUNDARY along z".into());
        }
        let kept = self.kept.concerned();
        let mut nodes = Vec::new();
        for &node in &contact.nodes {
            let name = &self.model.mesh.node_names[node];
            let place = self
                .places
                .free_node(node)
                .ok_or(format!("node {name} does not deform, or a rigid body carries it"))?;
            if kept.contains(&(place, 0)) || kept.contains(&(place, 1)) {
                let why = "follows others (*EQUATION, *MPC, *COUPLING, *TIE): leave it out of the surface";
                return Err(format!("node {name} is in contact and {why}"));
            }
            let is_given = |axis: usize| prescribed.contains(&(place, axis));
            if !is_given(1) {
                nodes.push((place, !is_given(0)));
            }
        }
        let gaps = nodes.iter().map(|n| state.dofs.nodes.start[n.0][1] - plane.height);
        let (low, high) = gaps.fold((0.0_f64, 0.0_f64), |(low, high), gap| (low.min(gap), high.max(gap)));
        let reach = [plane.from.min(plane.to), plane.from.max(plane.to)];
        let rounding = 1e-9 * plane.height.abs().max(reach[1] - reach[0]);
        let side = match (low < -rounding, high > rounding) {
            (true, true) => return Err("nodes of this surface lie on both sides of the plane".into()),
            (true, false) => -1.0,
            (false, true) => 1.0,
            // All on it: in front is to the left of the way from START to LINE.
            (false, false) => (plane.to - plane.from).signum(),
        };
        if nodes.is_empty() {
            return Err(nothing.into());
        }
        Ok(Wall { id: 0, body, height: plane.height, reach, side, friction: contact.friction, nodes, force: 0.0 })
    }
}
