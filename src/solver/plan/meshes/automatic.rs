//! Bodies without a card that have a new mesh once plastic flow has squashed their elements.

use std::sync::Arc;

use crate::kernel::lists::sorted_unique;
use crate::kernel::topology::ElementTopology;
use crate::model::remesh::ModelBody;
use crate::model::{AnalyticalFront, Mesh, Model, RegionType, Remeshing, SolidSection, Step};
use crate::plan::meshes::remesh::{RemeshPlan, fix_tied_nodes, has_faces_of, remeshed_body};
use crate::plan::{MeshRenewal, Pairs, Report, Scene, SolidPlaces, State};
use crate::remesh::sizes::SizeLimits;
use crate::variables::Variable;

/// Largest ratio of the edges of an element in the mesh of the deck of a body that has new meshes.
const LONGEST: f64 = 200.0;
/// Smallest angle of the elements after the first new mesh, degrees.
const SHARP: f64 = 15.0;
/// Smallest angle of adaptive meshes, which smoothing should keep, degrees.
const SHARP_ADAPTIVE: f64 = 25.0;

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
    /// When it has its first new mesh.
    trigger: FirstMesh,
}

/// When a body without a card has its first new mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FirstMesh {
    /// Its elements are squashed, and the stable time increment is below this fraction of the largest one; or a corner of an element
    /// has turned over.
    Squashed(f64),
    /// A corner of its adaptive mesh has turned over; or smoothing has not kept the angles above this one, radians, and the stable
    /// time increment is below [`AutomaticMeshes::COLLAPSED_ADAPTIVE`].
    Sharp(f64),
}

impl AutomaticMeshes {
    /// Fraction of the largest stable time increment below which squashed elements are worth a new mesh.
    const COLLAPSED: f64 = 0.3;
    /// The same for the first new mesh of a body in contact with faces, whose forces a new outline disturbs a little.
    const COLLAPSED_AT_FACES: f64 = 0.2;
    /// The same for adaptive meshes with sharp angles, which smoothing may still repair.
    pub const COLLAPSED_ADAPTIVE: f64 = 0.12;
    /// Increments between two checks.
    pub const INTERVAL: u64 = 10;

    /// Lists the bodies without a card that may have a new mesh; `None` without any. `renewals` are those of the element groups; `shared` is the model of the scene, if its owner shares it.
    pub fn plan(
        scene: Scene,
        shared: Option<&Arc<Model>>,
        (pairs, renewals): (&Pairs, &[MeshRenewal]),
        fronts: &[AnalyticalFront],
        state: &mut State,
        report: &Report,
    ) -> Option<AutomaticMeshes> {
        let model = scene.model;
        // A model with fronts is that of a new mesh.
        let excludes = renewals.is_empty()
            || model.surfaces.fronts.is_some()
            || !model.erosions.is_empty()
            || !report.called_routines.is_empty()
            || model.steps.iter().flat_map(|step| &step.loads).any(|load| load.kind.is_user())
            || state.heat().is_some();
        if excludes {
            return None;
        }
        let sections = model.sections.iter().enumerate();
        let waiting = sections.filter_map(|(index, section)| {
            let group = scene.places.elements.get(section.elements.first()?)?.0;
            if !flows_without_failure(scene, state, (group, section)) {
                return None;
            }
            let card = card_of(model, index);
            let adapts = moves_nodes(model, &card.elements);
            if contains_any(&model.kept_meshes, &card.elements)
                || has_needles(&model.mesh, &card.elements)
                || adapts && has_spatial_constraints(model)
                || !renewals.get(group).is_some_and(MeshRenewal::is_automatic)
            {
                return None;
            }
            let touches = touches_faces(pairs, &card.elements);
            let fraction = if touches { AutomaticMeshes::COLLAPSED_AT_FACES } else { AutomaticMeshes::COLLAPSED };
            let trigger = if adapts { FirstMesh::Sharp(card.angle) } else { FirstMesh::Squashed(fraction) };
            Some(WaitingBody { group, section: index, trigger })
        });
        let bodies: Vec<WaitingBody> = waiting.collect();
        let shares = || shared.map_or_else(|| Arc::new(model.clone()), Arc::clone);
        (!bodies.is_empty()).then(|| AutomaticMeshes { model: shares(), fronts: fronts.to_vec(), bodies })
    }

    /// Returns the element group of each body.
    pub fn groups(&self) -> impl Iterator<Item = usize> {
        self.bodies.iter().map(|body| body.group)
    }

    /// Returns the element group of each body, and when it has its first new mesh.
    pub fn triggers(&self) -> impl Iterator<Item = (usize, FirstMesh)> {
        self.bodies.iter().map(|body| (body.group, body.trigger))
    }

    /// Returns the model without cards; a shared one is copied first.
    pub fn model_mut(&mut self) -> &mut Model {
        Arc::make_mut(&mut self.model)
    }

    /// Returns the model with a card for each body.
    pub fn model(&self) -> Model {
        let mut model = (*self.model).clone();
        model.remeshings = self.bodies.iter().map(|body| card_of(&self.model, body.section)).collect();
        model.surfaces.fronts = Some(self.fronts.clone());
        fix_tied_nodes(&mut model);
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
pub(super) fn card_of(model: &Model, section: usize) -> Remeshing {
    let section = &model.sections[section];
    let elements = sorted_unique(section.elements.iter().copied());
    let angle = if moves_nodes(model, &elements) { SHARP_ADAPTIVE } else { SHARP };
    Remeshing {
        span: section.span,
        set: model.materials[section.material].name.clone(),
        elements,
        angle: angle.to_radians(),
        increment: AutomaticMeshes::COLLAPSED,
        frequency: AutomaticMeshes::INTERVAL,
        thickness: 0.0,
        size: None,
        limits: SizeLimits::default(),
        automatic: true,
        shared: Vec::new(),
    }
}

/// Returns whether an adaptive mesh moves nodes of a body; `elements` are in ascending order.
fn moves_nodes(model: &Model, elements: &[usize]) -> bool {
    let mut domains = model.steps.iter().flat_map(|step| &step.adaptive);
    domains.any(|domain| contains_any(&domain.elements, elements))
}

/// Returns whether a list contains one of the elements, which are in ascending order.
fn contains_any(list: &[usize], elements: &[usize]) -> bool {
    list.iter().any(|e| elements.binary_search(e).is_ok())
}

/// Returns whether an element has an edge that is more than [`LONGEST`] times as long as another one. New elements, which are
/// nearly square, would be too many.
fn has_needles(mesh: &Mesh, elements: &[usize]) -> bool {
    let is_needle = |element: &usize| {
        let [shortest, longest] = mesh.side_lengths(*element);
        longest > LONGEST * shortest
    };
    elements.iter().any(is_needle)
}

/// Returns whether material flows through adaptive meshes that are held in space.
fn has_spatial_constraints(model: &Model) -> bool {
    let is_eulerian = |step: &Step| step.adaptive_regions.iter().any(|region| region.kind == RegionType::Eulerian);
    model.steps.iter().any(|step| !step.mesh_motions.is_empty() || is_eulerian(step))
}

/// Returns whether a surface of a body takes part in contact with faces of elements; `elements` are in ascending order.
fn touches_faces(pairs: &Pairs, elements: &[usize]) -> bool {
    let mut all_pairs = pairs.by_step.iter().flat_map(|pairs| pairs.iter());
    all_pairs.any(|pair| pair.analytical.is_none() && pair.sides.iter().any(|side| has_faces_of(side, elements)))
}

/// Returns whether a group is of quadrilaterals with a plastic strain that are never deleted.
fn flows_without_failure(scene: Scene, state: &mut State, (group, section): (usize, &SolidSection)) -> bool {
    let group = &mut state.elements.groups[group];
    group.topology() == ElementTopology::Quadrilateral
        && group.value(0, Variable::PlasticStrain.into()).is_some()
        && group.transfer().is_some()
        && !scene.model.materials[section.material].has_failure()
}
