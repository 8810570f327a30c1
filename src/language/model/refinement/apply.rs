//! Refinement of the mesh of a deck: reading in two passes, sets, and names of new nodes and elements.

use super::lattice;
use super::mesh::RefinedMesh;
use super::relations::refine_relations;
use super::smooth;
use crate::deck::{Card, Deck, Span, Word};
use crate::kernel::lists::sorted_unique;
use crate::model::budget::BudgetedItem;
use crate::model::builder::ModelBuilder;
use crate::model::coarsening::apply::regions;
use crate::model::context::Context;
use crate::model::name::{EntityName, NewLabels};
use crate::model::types::{Element, ElementSide, Model, OutputKind, OutputRegion};
use crate::platform::PortableMath as _;

/// Reads a deck without errors again, with a refined mesh. `coarse` is its model.
pub(in crate::model) fn read<'a>(deck: &'a Deck, factor: usize, coarse: &Model, is_written: bool) -> ModelBuilder<'a> {
    let mut builder = ModelBuilder::with_changed_mesh(deck, is_written, |context| context.refine_mesh(factor, coarse));
    refine_relations(&mut builder.context);
    builder
}

impl Context<'_> {
    /// Divides all edges into `factor` parts, and extends all sets of nodes and elements.
    fn refine_mesh(&mut self, factor: usize, coarse: &Model) {
        if !self.affords_refinement(factor) {
            return;
        }
        let mut curves = std::mem::take(&mut self.scaling.curves);
        let mesh = &mut *self.model.mesh;
        if let Some(corner) = self.deck.mesh_curves {
            smooth::fit(mesh, &regions(coarse), corner.to_radians(), &mut curves);
        }
        let refined = lattice::refine(mesh, factor, self.deck.refined_elements.as_deref(), &curves);
        name_nodes(&refined, mesh.points.len(), &mut mesh.node_names);
        name_children(&refined, &mut mesh.elements);
        for set in self.model.element_sets.values_mut() {
            set.members = set.members.iter().flat_map(|&parent| refined.children(parent)).collect();
        }
        let regions = std::mem::take(&mut self.scaling.regions);
        for (name, set) in &mut self.model.node_sets {
            let more = refined.selection(&set.members).nodes(&refined);
            let elements = regions.iter().filter(|region| region.0 == *name).flat_map(|region| &region.1);
            let children = elements.flat_map(|&parent| refined.children(parent));
            let inside = children.flat_map(|child| mesh.elements[child].nodes.iter().copied());
            set.members = sorted_unique(set.members.drain(..).chain(more).chain(inside));
        }
        self.scaling.refined = Some(refined);
    }

    /// Reports a refined mesh that would exceed the size limits.
    fn affords_refinement(&mut self, factor: usize) -> bool {
        let is_mesh = |c: &&Card| matches!(c.keyword.name, "ELEMENT" | "MESH");
        let span = self.deck.cards.iter().find(is_mesh).map_or(Span::default(), |c| c.span);
        let square = (factor * factor) as u128;
        let more = |count: usize| (square - 1) * count as u128;
        let elements = more(self.model.mesh.elements.len());
        let nodes = more(self.model.mesh.points.len());
        self.fits_budget(BudgetedItem::Elements, elements, span) && self.fits_budget(BudgetedItem::Nodes, nodes, span)
    }

    /// Returns the elements of a refined or coarsened mesh that replace an element of the deck.
    pub(in crate::model) fn replacements(&self, element: usize) -> Vec<usize> {
        match (&self.scaling.refined, &self.scaling.coarsened) {
            (Some(refined), _) => refined.children(element).collect(),
            (None, Some(coarsened)) => vec![coarsened.merged[element]],
            (None, None) => vec![element],
        }
    }

    /// Returns the default position tolerance of a tie: 5 % of the mean facet length of the master surface in the mesh
    /// of the deck. `None` if the mesh is not refined.
    pub(in crate::model) fn tie_tolerance(&mut self, card: &Card, masters: &[(usize, ElementSide)]) -> Option<f64> {
        let (refined, mesh) = (self.scaling.refined.as_ref()?, &self.model.mesh);
        let ends = masters.iter().filter_map(|&(element, side)| mesh.side_nodes(element, side));
        let lengths = ends.map(|ends| {
            let [a, b] = ends.map(|node| mesh.points[node]);
            (b[0] - a[0]).portable_hypot(b[1] - a[1])
        });
        let is_part = |&&(element, side): &&(usize, ElementSide)| {
            let ends = mesh.side_nodes(element, side);
            ends.is_some_and(|ends| ends.iter().any(|&node| refined.edges.place(node).is_some()))
        };
        let parts = masters.iter().filter(is_part).count();
        let original_facets = (masters.len() - parts) as f64 + parts as f64 / refined.factor as f64;
        let parts_per_facet = masters.len() as f64 / original_facets;
        let tolerance = 0.05 * parts_per_facet * lengths.sum::<f64>() / masters.len() as f64;
        self.add_parameter(card.span, &format!("position tolerance={tolerance:?}"));
        Some(tolerance)
    }

    /// Returns the nodes of a set or label without those that refinement has added.
    pub(in crate::model) fn original_nodes(&mut self, word: &Word) -> Option<Vec<usize>> {
        let mut nodes = self.node_members(word)?;
        let Some(refined) = &self.scaling.refined else { return Some(nodes) };
        let count = nodes.len();
        nodes.retain(|&node| refined.is_original(node));
        if nodes.len() < count {
            self.edit_nodes(word, &nodes, false);
        }
        Some(nodes)
    }

    /// Reduces sets of one original element to its middle child if history output refers to them, so that the names of
    /// their columns do not depend on the refinement.
    pub(in crate::model) fn reduce_output_sets(&mut self) {
        let Some(refined) = &self.scaling.refined else { return };
        let requests = self.model.steps.iter().flat_map(|step| &step.outputs);
        let history = requests.filter(|request| request.kind == OutputKind::History && request.statistics.is_empty());
        for request in history {
            let OutputRegion::Elements(id) = request.region else { continue };
            let members = &mut self.model.element_sets[id].members;
            let parent = |child: usize| refined.first_child.partition_point(|&first| first <= child) - 1;
            let [Some(first), Some(last)] = [members.first(), members.last()].map(|child| child.map(|&c| parent(c)))
            else {
                continue;
            };
            if first == last {
                *members = vec![refined.middle_child[first]];
            }
        }
    }
}

fn name_nodes(refined: &RefinedMesh, count: usize, names: &mut Vec<EntityName>) {
    let mut labels = NewLabels::above(names.iter());
    names.reserve(count - refined.originals);
    for node in refined.originals..count {
        let like = refined.weights(node)[0].0;
        let name = labels.next(&names[like]);
        names.push(name);
    }
}

fn name_children(refined: &RefinedMesh, children: &mut [Element]) {
    let mut labels = NewLabels::above(refined.parents.iter().map(|parent| &parent.name));
    for (at, parent) in refined.parents.iter().enumerate() {
        for child in refined.children(at).filter(|&child| child != refined.middle_child[at]) {
            children[child].name = labels.next(&parent.name);
        }
    }
}
