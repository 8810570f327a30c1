//! `*CONTACT PAIR` of what deforms with analytical surfaces: which nodes, on which side, and what is told of how they start.
//! Never here: the contact itself.

use std::collections::HashSet;

use super::{Compiler, State};
use crate::constraint::Constraint;
use crate::constraint::wall::Wall;
use crate::deck::Diagnostic;
use crate::kernel::profile::Profile;
use crate::model::{Contact, Element, RigidSurface, Step};

/// Part of the smaller of both surfaces by which nodes may begin behind the surface: chords of a mesh, digits of a deck.
const OVERLAP: f64 = 1e-3;

/// How nodes lie to a surface at the start.
#[derive(Debug, Default)]
struct Start {
    /// How far the one furthest behind is behind, and the one furthest in front in front.
    behind: f64,
    front: f64,
    /// How many are behind.
    count: usize,
}

impl Start {
    fn new(profile: &Profile, places: &[[f64; 2]], rounding: f64) -> Start {
        let mut start = Start::default();
        for &place in places {
            let gap = profile.nearest(place, 0.0).gap;
            (start.behind, start.front) = (start.behind.max(-gap), start.front.max(gap));
            start.count += usize::from(gap < -rounding);
        }
        start
    }
}

/// Length of the box around points.
fn extent(points: &[[f64; 2]]) -> f64 {
    let along = |axis: usize| {
        let all = points.iter().map(|p| p[axis]);
        all.clone().fold(f64::NEG_INFINITY, f64::max) - all.fold(f64::INFINITY, f64::min)
    };
    along(0).max(along(1))
}

impl Compiler<'_> {
    /// The surfaces of a step with the nodes that may meet them.
    pub(super) fn walls(
        &mut self,
        step: &Step,
        state: &State,
        prescribed: &HashSet<(usize, usize)>,
    ) -> Vec<Box<dyn Constraint>> {
        let mut walls: Vec<Box<dyn Constraint>> = Vec::new();
        for contact in &step.contacts {
            match self.wall(contact, state, prescribed) {
                Ok(mut wall) => {
                    let friction =
                        if wall.friction > 0.0 { format!(", friction {}", wall.friction) } else { String::new() };
                    let (set, name) = (&contact.set, &contact.surface);
                    let (effect, detail) = match wall.profile.height() {
                        Some(z) => ("contact with a plane", format!("{set} on {name}, z = {z}, kinematic{friction}")),
                        None => {
                            let count = wall.profile.segments.len();
                            let detail = format!("{set} on {name}, {count} segments, kinematic{friction}");
                            ("contact with a surface", detail)
                        }
                    };
                    wall.id = self.cause(contact.span, effect, wall.nodes.len(), "nodes", detail);
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

    fn wall(&mut self, contact: &Contact, state: &State, prescribed: &HashSet<(usize, usize)>) -> Result<Wall, String> {
        let surface: &RigidSurface = &self.model.rigid_surfaces[&contact.surface];
        let reference =
            surface.reference.ok_or("the analytical surface belongs to no *RIGID BODY, ANALYTICAL SURFACE=")?;
        let body = *self.body_of_node.get(&reference).ok_or("the surface's rigid body is missing")?;
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
            nodes.push((place, [0, 1].map(|axis| !prescribed.contains(&(place, axis)))));
        }
        if surface.profile.height().is_some() {
            nodes.retain(|n| n.1[1]);
        }
        if nodes.is_empty() {
            return Err("no node of this surface deforms".into());
        }
        let places: Vec<[f64; 2]> = nodes.iter().map(|n| state.dofs.nodes.start[n.0]).collect();
        let mut wall = Wall::new(body, surface.profile.clone(), contact.friction, nodes);
        let ends = surface.profile.bounds();
        let overlap =
            OVERLAP * [extent(&ends), extent(&places)].into_iter().filter(|e| *e > 0.0).fold(f64::MAX, f64::min);
        wall.profile = self.facing(contact, surface, &places, wall.rounding, overlap)?;
        wall.overlap = overlap.max(wall.rounding);
        Ok(wall)
    }

    /// The surface with its front where the nodes are, and what is to be said of it.
    fn facing(
        &mut self,
        contact: &Contact,
        surface: &RigidSurface,
        places: &[[f64; 2]],
        rounding: f64,
        overlap: f64,
    ) -> Result<Profile, String> {
        let (profile, name) = (surface.profile.clone(), &contact.surface);
        let start = Start::new(&profile, places, rounding);
        let way = "its front is to the left of the way from START on";
        let help = "give the points of the surface in the opposite order";
        if start.behind <= rounding {
            if start.front <= rounding && self.looks_away(contact, &profile) {
                let message =
                    format!("`{name}` faces away from `{}`, which lies on it: nothing will meet it", contact.set);
                let finding = Diagnostic::warning("P110", message).at(surface.span, format!("{way}, as in ABAQUS"));
                self.diagnostics.push(finding.at(contact.span, "this pair").help(help));
            }
            return Ok(profile);
        }
        let away = match contact.faces.is_empty() {
            true => start.behind > overlap,
            false => self.looks_away(contact, &profile),
        };
        if away && start.front <= rounding.max(overlap) {
            let message =
                format!("`{name}` faces away from `{}`: contact is taken on the side where that is", contact.set);
            let finding = Diagnostic::warning("P110", message).at(surface.span, format!("{way}; ABAQUS keeps to it"));
            self.diagnostics.push(finding.at(contact.span, "this pair").help(help));
            return Ok(profile.reversed());
        }
        if start.behind <= overlap {
            let (count, behind) = (start.count, start.behind);
            let message = format!("{count} nodes of `{}` begin up to {behind:.3e} behind `{name}`", contact.set);
            let finding = Diagnostic::warning("P111", message).at(contact.span, "they stay there and go no deeper");
            self.diagnostics.push(finding.help("move the nodes onto the surface"));
            return Ok(profile);
        }
        if start.front <= overlap {
            return Err(format!("nodes of this surface begin up to {:.3e} behind the analytical one", start.behind));
        }
        Err("nodes of this surface lie on both sides of the analytical one".into())
    }

    /// Whether what has the nodes of a surface lies behind the analytical one, in the mean.
    fn body_of_nodes_is_behind(&self, contact: &Contact, profile: &Profile) -> bool {
        let mesh = &self.model.mesh;
        let touches =
            |e: &&Element| e.nodes.len() > 2 && e.nodes.iter().any(|n| contact.nodes.binary_search(n).is_ok());
        let body = mesh.elements.iter().filter(touches).flat_map(|e| &e.nodes);
        body.map(|&n| profile.nearest(mesh.points[n], 0.0).gap).sum::<f64>() < 0.0
    }

    /// Whether the faces of a surface look the same way as the analytical one: those of them that are nearest to it.
    fn looks_away(&self, contact: &Contact, profile: &Profile) -> bool {
        let points = &self.model.mesh.points;
        if contact.faces.is_empty() {
            return self.body_of_nodes_is_behind(contact, profile);
        }
        let face = |f: &[usize; 2]| {
            let [a, b] = f.map(|n| points[n]);
            let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
            let near = profile.nearest(middle, 0.0);
            let n = profile.segments[near.segment].normal(middle, 0.0);
            (near.gap.abs(), n[0] * (b[1] - a[1]) - n[1] * (b[0] - a[0]), libm::hypot(b[0] - a[0], b[1] - a[1]))
        };
        let least = contact.faces.iter().map(|f| face(f).0).fold(f64::INFINITY, f64::min);
        let near = contact.faces.iter().map(face).filter(|(gap, _, length)| *gap <= least + 0.5 * length);
        near.map(|f| f.1).sum::<f64>() > 0.0
    }
}
