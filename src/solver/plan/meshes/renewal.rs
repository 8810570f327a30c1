//! Cards that may renew the mesh of a body during the run, for the advice of messages.

use crate::kernel::lists::sorted_unique;
use crate::model::SolidSection;
use crate::model::remesh::ModelBody;
use crate::plan::meshes::adaptive::unsupported_domain;
use crate::plan::meshes::automatic::card_of;
use crate::plan::meshes::remesh::{SharedNodes, unsupported_remeshing};
use crate::plan::{Links, Pairs, Report, Scene, State};

/// Cards that may renew the mesh of an element group.
#[derive(Clone, Debug, Default)]
pub struct MeshRenewal {
    /// Why `*REMESH` cannot, and what would be supported; `None` if it can.
    pub refusal: Option<String>,
    /// Whether `*ADAPTIVE MESH` can. It does not move nodes that several bodies share.
    pub adapts: bool,
    /// Whether elements outside the group use its nodes.
    pub shares_nodes: bool,
}

impl MeshRenewal {
    /// Returns whether a body may have new meshes without a card. They keep edges in common with other elements, which stretch, so that
    /// layers became worse than on folded meshes in trials: bodies with such edges need a card.
    pub fn is_automatic(&self) -> bool {
        self.refusal.is_none() && !self.shares_nodes
    }

    /// Finds the cards for each element group. The list is empty if the model has `*REMESH` or errors, or if all time
    /// increments are fixed: none collapses.
    pub fn plan(
        scene: Scene,
        (links, pairs): (&Links, &Pairs),
        state: &mut State,
        report: &Report,
    ) -> Vec<MeshRenewal> {
        let model = scene.model;
        let is_fixed = model.steps.iter().all(|step| step.increment.is_fixed());
        if !model.remeshings.is_empty() || report.diagnostics.has_errors() || is_fixed {
            return Vec::new();
        }
        let refusal = Some("its section or material cannot have a new mesh".into());
        let neither = MeshRenewal { refusal, ..MeshRenewal::default() };
        let mut renewals = vec![neither; state.elements.groups.len()];
        for (index, section) in model.sections.iter().enumerate() {
            let first = section.elements.first().and_then(|element| scene.places.elements.get(element));
            let Some(&(group, _)) = first.filter(|place| state.elements.groups[place.0].transfer().is_some()) else {
                continue;
            };
            let card = card_of(model, index);
            let body = ModelBody::of_elements(&model.mesh, 0, &card.elements);
            let shared = SharedNodes::new(scene, &body, &card, state);
            let refusal = unsupported_remeshing(scene, (links, pairs), &card, (&body, &shared), (state, report));
            let shares_nodes = !shared.nodes.is_empty();
            let adapts = !shares_nodes && can_adapt(scene, section, &card.set, state);
            let refusal = refusal.map(|(what, help)| format!("{what}: {help}"));
            renewals[group] = MeshRenewal { refusal, adapts, shares_nodes };
        }
        renewals
    }
}

/// Returns whether `*ADAPTIVE MESH` supports the elements of a section.
fn can_adapt(scene: Scene, section: &SolidSection, name: &str, state: &State) -> bool {
    let elements = sorted_unique(section.elements.iter().copied());
    let places: Vec<_> = elements.iter().filter_map(|element| scene.places.elements.get(element).copied()).collect();
    !places.is_empty() && unsupported_domain(scene, (name, &elements), &places, state).is_none()
}
