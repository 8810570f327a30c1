//! Warnings of contact that the deck prepares and does not define: interactions and analytical surfaces without contact, and
//! bodies with nodes at the same places that nothing joins.

use std::collections::HashSet;

use super::finding::warn_about;
use super::overlaps::{ConnectedPart, contacts_of, elements_of};
use crate::deck::Diagnostic;
use crate::kernel::box_grid::BoxGrid;
use crate::model::{ElementSide, Model};
use crate::plan::meshes::pieces::exterior_faces_of;
use crate::plan::{Links, Pairs, Report, Scene};

/// Distance of nodes at the same place, as a fraction of the length of their face.
const SAME_PLACE: f64 = 1e-3;

/// Warns of cards of contact in a model in which no step has contact.
pub fn check_missing_contact(scene: Scene, report: &mut Report) {
    let model = scene.model;
    if model.steps.is_empty() || model.steps.iter().any(|step| step.has_contact()) {
        return;
    }
    let help = "add *CONTACT PAIR with this interaction, or *CONTACT, to the step";
    if let Some(card) = model.origin.inert.iter().find(|card| card.keyword == "SURFACE INTERACTION") {
        let message =
            "the deck has a *SURFACE INTERACTION, and no step defines contact: bodies move through each other";
        return warn_about("P151", message.into(), (card.span, "this interaction is not used"), help, report);
    }
    let deforms = !scene.places.elements.is_empty();
    if let Some((name, surface)) = model.surfaces.analytical.iter().next().filter(|_| deforms) {
        let message = format!("the analytical surface `{name}` has no use but contact, and no step defines contact");
        let help = "add *CONTACT PAIR with this surface, or *CONTACT, to the step";
        warn_about("P151", message, (surface.span, "this surface"), help, report);
    }
}

/// Warns of two deformable bodies with faces at the same place, without common nodes, tie or contact.
pub(super) fn check_unjoined_faces(
    scene: Scene,
    parts: &[ConnectedPart],
    (links, pairs): (&Links, &Pairs),
    report: &mut Report,
) {
    let model = scene.model;
    if parts.len() < 2 {
        return;
    }
    let faces = exterior_faces_of(&model.mesh, elements_of(parts));
    let linked = linked_nodes(model);
    let deforms = |part: usize| scene.places.elements.contains_key(&parts[part].elements[0]);
    let mut edges: Vec<Edge> = Vec::new();
    for (part, faces) in faces.iter().enumerate().filter(|(part, _)| deforms(*part)) {
        edges.extend(edges_of(model, part, faces).filter(|edge| edge.nodes.iter().all(|n| !linked.contains(n))));
    }
    edges.sort_unstable_by(|a, b| a.middle[1].total_cmp(&b.middle[1]));
    let grid = BoxGrid::new(edges.iter().map(|edge| [edge.middle; 2]).zip(0..));
    let contacts = contacts_of(model, links, pairs, parts);
    let are_joined =
        |a: usize, b: usize| contacts.connect([a.min(b), a.max(b)]) || contacts.are_tied([a.min(b), a.max(b)]);
    for (edge, index) in edges.iter().zip(0..) {
        let is_unjoined = |other: &Edge| {
            other.part != edge.part && edge.coincides(other, model) && !are_joined(edge.part, other.part)
        };
        let mut found: Option<u32> = None;
        grid.near([edge.middle; 2], SAME_PLACE * edge.length, |other| {
            if other > index && found.is_none_or(|first| other < first) && is_unjoined(&edges[other as usize]) {
                found = Some(other);
            }
        });
        if let Some(other) = found {
            return report_unjoined(model, [edge, &edges[other as usize]], report);
        }
    }
}

fn report_unjoined(model: &Model, edges: [&Edge; 2], report: &mut Report) {
    let [a, b] = edges.map(|edge| &model.mesh.elements[edge.element]);
    let [r, z] = edges[0].middle;
    let message = format!(
        "elements {} and {} have faces at the same place, (r = {r:.4e}, z = {z:.4e}), and belong to bodies without common nodes, \
         tie or contact: the bodies separate or overlap there",
        a.name, b.name
    );
    let finding = Diagnostic::warning("P152", message).at(a.span, "of this element").at(b.span, "and of this one");
    report.push(finding.help("use common nodes, *TIE, or contact (*CONTACT PAIR, *CONTACT)"));
}

/// An exterior face of a part.
struct Edge {
    part: usize,
    element: usize,
    nodes: [usize; 2],
    middle: [f64; 2],
    length: f64,
}

impl Edge {
    /// Returns whether both ends are at the places of the ends of another face, in the opposite order.
    fn coincides(&self, other: &Edge, model: &Model) -> bool {
        let [[a, b], [c, d]] = [self.nodes, other.nodes].map(|nodes| nodes.map(|n| model.mesh.points[n]));
        let is_near = |p: [f64; 2], q: [f64; 2]| libm::hypot(p[0] - q[0], p[1] - q[1]) <= SAME_PLACE * self.length;
        is_near(a, d) && is_near(b, c)
    }
}

fn edges_of<'m>(model: &'m Model, part: usize, faces: &'m [(usize, ElementSide)]) -> impl Iterator<Item = Edge> + 'm {
    faces.iter().filter_map(move |&(element, side)| {
        let nodes = model.mesh.side_nodes(element, side)?;
        let [a, b] = nodes.map(|n| model.mesh.points[n]);
        let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
        let length = libm::hypot(b[0] - a[0], b[1] - a[1]);
        (middle[0] > 0.0).then_some(Edge { part, element, nodes, middle, length })
    })
}

/// Returns the nodes of equations, couplings and cohesive elements.
fn linked_nodes(model: &Model) -> HashSet<usize> {
    let terms = model.constraints.equations.iter().flat_map(|equation| &equation.terms).map(|term| term.0);
    let links = model.constraints.links.iter().flat_map(|link| link.nodes.iter().copied());
    let cohesive = model.cohesive_sections.iter().flat_map(|section| &section.elements);
    let bonded = cohesive.flat_map(|&e| model.mesh.elements[e].nodes.iter().copied());
    terms.chain(links).chain(bonded).collect()
}
