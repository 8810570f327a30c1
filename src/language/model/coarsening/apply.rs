//! Coarsening of the mesh of a deck, between the cards of the mesh and all other cards.

use crate::model::builder::ModelBuilder;
use crate::model::context::Context;
use std::collections::HashMap;

use super::blocks::find_blocks;
use super::chains::{ChainEnds, merge_chains};
use super::mesh::{CoarsenedMesh, CoarseningFault};
use super::quadrilaterals::{Quadrilaterals, Regions};
use super::verify::verify;
use crate::deck::{Deck, Diagnostic, Diagnostics};
use crate::kernel::lists::sorted_unique;
use crate::model::types::{LoadRegion, Mesh, Model, OutputKind, OutputRegion};

/// Largest number of faults that are reported.
const REPORTED: usize = 10;

/// Reads a deck without errors again, with groups of `factor` by `factor` elements merged. `fine` is its model.
pub(in crate::model) fn read<'a>(deck: &'a Deck, factor: usize, fine: &Model, is_written: bool) -> ModelBuilder<'a> {
    ModelBuilder::with_changed_mesh(deck, is_written, |context| coarsen_mesh(context, factor, fine))
}

/// Completes the coarsened model of a deck, and compares it with the model of the deck.
pub(in crate::model) fn finish(mut builder: ModelBuilder<'_>, fine: &Model) -> (Model, Diagnostics) {
    let merged = builder.context.scaling.coarsened.take();
    let (model, mut diagnostics) = builder.finish();
    if let Some(merged) = merged.filter(|_| !diagnostics.has_errors()) {
        report(verify(&merged, &model, fine), &mut diagnostics);
    }
    (model, diagnostics)
}

fn report(faults: Vec<CoarseningFault>, diagnostics: &mut Diagnostics) {
    for CoarseningFault { words: [message, label], span } in faults.into_iter().take(REPORTED) {
        diagnostics.push(Diagnostic::error("M191", message).at(span, label).help(
            "only rows of quadrilaterals, shells and rigid surface elements can be merged; blocks end at boundaries, \
             sections, irregular nodes, corners, and nodes with forces, masses or constraints",
        ));
    }
}

fn coarsen_mesh(context: &mut Context<'_>, factor: usize, fine_model: &Model) {
    let fine: Mesh = std::mem::take(&mut *context.model.mesh);
    let mut mesh = Mesh { points: fine.points.clone(), node_names: fine.node_names.clone(), elements: Vec::new() };
    let mut merged = CoarsenedMesh { merged: vec![0; fine.elements.len()], ..CoarsenedMesh::default() };
    let faults = merge(&fine, factor, fine_model, (&mut mesh, &mut merged));
    if !faults.is_empty() {
        *context.model.mesh = fine;
        return report(faults, &mut context.diagnostics);
    }
    merged.is_removed = removed(&fine, &mesh);
    *context.model.mesh = mesh;
    for set in context.model.element_sets.values_mut() {
        set.members = sorted_unique(set.members.iter().map(|&element| merged.merged[element]));
    }
    for set in context.model.node_sets.values_mut() {
        set.members.retain(|&node| !merged.is_removed[node]);
    }
    context.scaling.coarsened = Some(merged);
}

/// Merges the elements of a mesh; returns why this is not possible.
fn merge(
    fine: &Mesh,
    factor: usize,
    model: &Model,
    (mesh, merged): (&mut Mesh, &mut CoarsenedMesh),
) -> Vec<CoarseningFault> {
    let is_other = |e: &&crate::model::types::Element| {
        e.kind.is_solid() && (e.nodes.len() != 4 || sorted_unique::<usize>(e.nodes.iter().copied()).len() != 4)
    };
    let triangle = fine.elements.iter().find(is_other).map(|element| ("triangles", element));
    let cohesive = || fine.elements.iter().find(|e| e.kind.is_cohesive()).map(|element| ("cohesive elements", element));
    if let Some((what, element)) = triangle.or_else(cohesive) {
        let message = format!("{what} cannot be merged: element {} is {}", element.name, element.kind.name());
        return vec![CoarseningFault::new(message, "this element", element.span)];
    }
    let (regions, fixed) = (regions(model), fixed_nodes(model));
    let quads = Quadrilaterals::new(fine);
    let blocks = find_blocks(&quads, &regions, &fixed);
    let faults: Vec<CoarseningFault> = blocks.iter().filter_map(|block| block.fault(fine, factor)).collect();
    if !faults.is_empty() {
        return faults;
    }
    blocks.iter().for_each(|block| block.merge(fine, factor, (mesh, merged)));
    let mut of_solids: HashMap<usize, bool> = quads.at_node.keys().map(|&node| (node, false)).collect();
    of_solids.extend(mesh.elements.iter().flat_map(|e| e.nodes.iter().map(|&node| (node, true))));
    let ends = ChainEnds { regions: &regions, fixed: &fixed, of_solids };
    let faults = merge_chains(fine, factor, &ends, (mesh, merged));
    for (at, element) in fine.elements.iter().enumerate().filter(|(_, element)| element.kind.is_discrete()) {
        merged.add(element.clone(), vec![at], mesh);
    }
    faults
}

/// Returns which nodes of elements belong to no merged element.
fn removed(fine: &Mesh, coarse: &Mesh) -> Vec<bool> {
    let mut removed = vec![false; fine.points.len()];
    fine.elements.iter().flat_map(|e| &e.nodes).for_each(|&node| removed[node] = true);
    coarse.elements.iter().flat_map(|e| &e.nodes).for_each(|&node| removed[node] = false);
    removed
}

/// Returns the sections and rigid bodies of each element.
pub fn regions(model: &Model) -> Regions {
    let mut regions = Regions::new();
    let sections = model.sections.iter().map(|s| &s.elements).chain(model.shell_sections.iter().map(|s| &s.elements));
    let sections = sections.chain(model.cohesive_sections.iter().map(|s| &s.elements));
    let element_lists = sections.chain(model.rigid_bodies.iter().map(|body| &body.elements));
    for (at, elements) in element_lists.enumerate() {
        elements.iter().for_each(|&element| regions.entry(element).or_default().push(at));
    }
    regions
}

/// Returns the nodes that must remain: those of point masses, springs, forces, equations, links and rigid bodies, and
/// nodes of history output.
fn fixed_nodes(model: &Model) -> Vec<usize> {
    let mut nodes: Vec<usize> = Vec::new();
    let discrete = model.mesh.elements.iter().filter(|element| element.kind.is_discrete());
    nodes.extend(discrete.flat_map(|element| element.nodes.iter().copied()));
    nodes.extend(model.rigid_bodies.iter().map(|body| body.reference));
    nodes.extend(model.constraints.equations.iter().flat_map(|e| e.terms.iter().map(|term| term.0)));
    for link in &model.constraints.links {
        nodes.push(link.reference);
        nodes.extend(link.nodes.iter().filter(|_| link.name.starts_with("MPC")));
    }
    for step in &model.steps {
        for load in &step.loads {
            if let LoadRegion::Nodes(loaded) = load.kind.region() {
                nodes.extend(loaded);
            }
        }
        for request in step.outputs.iter().filter(|request| request.kind == OutputKind::History) {
            let OutputRegion::Nodes(id) = request.region else { continue };
            nodes.extend(model.node_sets[id].members.iter().filter(|_| model.node_sets[id].members.len() == 1));
        }
    }
    sorted_unique(nodes)
}
