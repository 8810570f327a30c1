//! Comparison of a coarsened model with that of the deck: surfaces, loads and sections must cover the same elements.

use std::collections::HashSet;

use super::mesh::{CoarsenedMesh, CoarseningFault};
use crate::deck::Span;
use crate::model::types::{ElementSide, Load, LoadRegion, Model, OutputRegion};

/// Elements or faces of a card in both models.
struct Verification<'a> {
    merged: &'a CoarsenedMesh,
    models: [&'a Model; 2],
    faults: Vec<CoarseningFault>,
}

/// Returns the cards whose regions differ between a coarsened model and the model of the deck.
pub fn verify(merged: &CoarsenedMesh, coarse: &Model, fine: &Model) -> Vec<CoarseningFault> {
    let mut check = Verification { merged, models: [coarse, fine], faults: Vec::new() };
    for (a, b) in coarse.surfaces.faces.values().zip(fine.surfaces.faces.values()) {
        check.faces(&format!("surface {}", b.name), [&a.faces, &b.faces], b.span);
    }
    for (a, b) in coarse.sections.iter().zip(&fine.sections) {
        check.elements("a section", [&a.elements, &b.elements], b.span);
    }
    for (a, b) in coarse.shell_sections.iter().zip(&fine.shell_sections) {
        check.elements("a section", [&a.elements, &b.elements], b.span);
    }
    for (a, b) in coarse.rigid_bodies.iter().zip(&fine.rigid_bodies) {
        check.elements("a rigid body", [&a.elements, &b.elements], b.span);
    }
    for (a, b) in coarse.initial_conditions.iter().zip(&fine.initial_conditions) {
        if b.kind.applies_to_elements() {
            check.elements("an initial condition", [&a.members, &b.members], b.span);
        }
    }
    for (a, b) in coarse.steps.iter().zip(&fine.steps) {
        a.loads.iter().zip(&b.loads).for_each(|(a, b)| check.load(a, b));
        for (a, b) in a.boundaries.iter().zip(&b.boundaries).filter(|(_, b)| b.nodes.len() > 1) {
            check.nodes("a boundary condition", [&a.nodes, &b.nodes], b.span);
        }
        for (a, b) in a.outputs.iter().zip(&b.outputs) {
            if let (OutputRegion::Nodes(of_a), OutputRegion::Nodes(of_b)) = (&a.region, &b.region) {
                let members = [&coarse.node_sets[*of_a].members[..], &fine.node_sets[*of_b].members[..]];
                check.nodes("an output request", members, b.span);
            }
        }
    }
    check.faults
}

impl Verification<'_> {
    fn elements(&mut self, what: &str, [coarse, fine]: [&[usize]; 2], span: Span) {
        let covered: HashSet<usize> = coarse.iter().flat_map(|&e| self.merged.parts[e].iter().copied()).collect();
        if covered != fine.iter().copied().collect() {
            self.differs(what, span);
        }
    }

    fn faces(&mut self, what: &str, [coarse, fine]: [&[(usize, ElementSide)]; 2], span: Span) {
        let [of_coarse, of_fine] = self.models.map(|model| &*model.mesh);
        let faces = coarse.iter().flat_map(|&face| self.merged.faces_of(of_coarse, of_fine, face));
        if faces.collect::<HashSet<_>>() != fine.iter().copied().collect() {
            self.differs(what, span);
        }
    }

    fn nodes(&mut self, what: &str, [coarse, fine]: [&[usize]; 2], span: Span) {
        if coarse.is_empty() && !fine.is_empty() {
            let message = format!("{what} applies only to nodes that are removed by merging elements");
            self.faults.push(CoarseningFault::new(message, "here", span));
        }
    }

    fn load(&mut self, coarse: &Load, fine: &Load) {
        match (coarse.kind.region(), fine.kind.region()) {
            (LoadRegion::Elements(a), LoadRegion::Elements(b)) => self.elements("a load", [a, b], fine.span),
            (LoadRegion::Sides(a), LoadRegion::Sides(b)) => self.faces("a load", [&a.faces, &b.faces], fine.span),
            _ => {}
        }
    }

    fn differs(&mut self, what: &str, span: Span) {
        let message = format!("{what} ends inside elements that would be merged");
        self.faults.push(CoarseningFault::new(message, "here", span));
    }
}
