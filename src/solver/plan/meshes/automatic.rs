//! Bodies without a card that have a new mesh once plastic flow has squashed their elements.

use std::sync::Arc;

use crate::kernel::lists::sorted_unique;
use crate::kernel::topology::ElementTopology;
use crate::model::remesh::ModelBody;
use crate::model::{AnalyticalFront, Model, Remeshing, SolidSection};
use crate::plan::meshes::remesh::{RemeshPlan, remeshed_body, unsupported_remeshing};
use crate::plan::solids::user_material::fails;
use crate::plan::{Pairs, Report, Scene, SolidPlaces, State};
use crate::remesh::sizes::SizeLimits;
use crate::variables::Variable;

/// Smallest angle of the elements after the first new mesh, degrees.
const SHARP: f64 = 15.0;

/// Bodies that have a new mesh once theirs collapses, and the model with which a plan for it is compiled.
pub struct AutomaticMeshes {
    model: Arc<Model>,
    fronts: Vec<AnalyticalFront>,
    bodies: Vec<WaitingBody>,
}

/// A body with the mesh of the deck.
struct WaitingBody {
    /// Element group.
    group: usize,
    /// Index of its section in the model.
    section: usize,
}

impl AutomaticMeshes {
    /// Fraction of the largest stable time increment below which squashed elements are worth a new mesh.
    pub const COLLAPSED: f64 = 0.3;
    /// Increments between two checks.
    pub const INTERVAL: u64 = 10;

    /// Lists the bodies without a card that may have a new mesh; `None` without any. If all time increments are fixed,
    /// none collapses. `shared` is the model of the scene, if its owner shares it.
    pub fn plan(
        scene: Scene,
        shared: Option<&Arc<Model>>,
        pairs: &Pairs,
        fronts: &[AnalyticalFront],
        state: &mut State,
        report: &Report,
    ) -> Option<AutomaticMeshes> {
        let model = scene.model;
        // A model with fronts is that of a new mesh.
        let excludes = report.diagnostics.has_errors()
            || !model.remeshings.is_empty()
            || model.surfaces.fronts.is_some()
            || !model.erosions.is_empty()
            || !report.called_routines.is_empty()
            || state.heat().is_some()
            || model.steps.iter().all(|step| step.increment.is_fixed());
        if excludes {
            return None;
        }
        let sections = model.sections.iter().enumerate();
        let waiting = sections.filter_map(|(index, section)| {
            let group = scene.places.elements.get(section.elements.first()?)?.0;
            let may_have_new_mesh = flows_without_failure(scene, state, (group, section)) && {
                let card = card_of(model, index);
                let body = ModelBody::of_elements(&model.mesh, 0, &card.elements);
                !keeps_mesh(model, &card.elements)
                    && unsupported_remeshing(scene, pairs, &card, &body, state, report).is_none()
            };
            may_have_new_mesh.then_some(WaitingBody { group, section: index })
        });
        let bodies: Vec<WaitingBody> = waiting.collect();
        let shares = || shared.map_or_else(|| Arc::new(model.clone()), Arc::clone);
        (!bodies.is_empty()).then(|| AutomaticMeshes { model: shares(), fronts: fronts.to_vec(), bodies })
    }

    /// Returns the element group of each body.
    pub fn groups(&self) -> impl Iterator<Item = usize> {
        self.bodies.iter().map(|body| body.group)
    }

    /// Returns the model with a card for each body.
    pub fn model(&self) -> Model {
        let mut model = (*self.model).clone();
        model.remeshings = self.bodies.iter().map(|body| card_of(&self.model, body.section)).collect();
        model.surfaces.fronts = Some(self.fronts.clone());
        model
    }

    /// Returns the bodies as those of cards, on the meshes of the deck.
    pub fn remesh_plan(&self, places: &SolidPlaces) -> RemeshPlan {
        let model = self.model();
        let body = |(index, card)| remeshed_body(places, card, &ModelBody::new(&model, index));
        let bodies = model.remeshings.iter().enumerate().map(body).collect();
        RemeshPlan { bodies, model }
    }
}

/// Returns the card of the body of a section.
fn card_of(model: &Model, section: usize) -> Remeshing {
    let section = &model.sections[section];
    Remeshing {
        span: section.span,
        set: model.materials[section.material].name.clone(),
        elements: sorted_unique(section.elements.iter().copied()),
        angle: SHARP.to_radians(),
        increment: AutomaticMeshes::COLLAPSED,
        frequency: AutomaticMeshes::INTERVAL,
        size: None,
        limits: SizeLimits::default(),
        automatic: true,
    }
}

/// Returns whether the deck keeps the mesh of a body, or moves its nodes; `elements` are in ascending order.
fn keeps_mesh(model: &Model, elements: &[usize]) -> bool {
    let domains = model.steps.iter().flat_map(|step| &step.adaptive).map(|domain| &domain.elements);
    domains.chain([&model.kept_meshes]).any(|list| list.iter().any(|e| elements.binary_search(e).is_ok()))
}

/// Returns whether a group is of quadrilaterals with a plastic strain that are never deleted.
fn flows_without_failure(scene: Scene, state: &mut State, (group, section): (usize, &SolidSection)) -> bool {
    let group = &mut state.elements.groups[group];
    group.topology() == ElementTopology::Quadrilateral
        && group.value(0, Variable::PlasticStrain.into()).is_some()
        && group.transfer().is_some()
        && !fails(&scene.model.materials[section.material])
}
