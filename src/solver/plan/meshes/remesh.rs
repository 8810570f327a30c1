//! Bodies of the plan that are remeshed (`*REMESH`), and combinations that are not supported.

use rustc_hash::FxHashSet;

use crate::deck::{Diagnostic, Diagnostics};
use crate::kernel::lists::{Memory, sorted_unique};
use crate::kernel::topology::ElementTopology;
use crate::model::remesh::{ModelBody, elements_at_body, kept_nodes_of_histories, linked_nodes, single_nodes};
use crate::model::{
    AnalyticalFront, LoadKind, Model, OutputCard, OutputKind, OutputRegion, OutputRequest, Remeshing, SideSelection,
    SolidSection, Step, SurfaceContact,
};
use crate::plan::constraints::surface_ties::find_attached_nodes;
use crate::plan::contact::cohesion::cohesion_of;
use crate::plan::heat::fields::has_uniform_fields;
use crate::plan::meshes::pieces::parts_in_contact;
use crate::plan::solids::mass_scaling::scales_equation_of_state;
use crate::plan::{Links, Pairs, Report, Scene, SolidPlaces, State};
use crate::remesh::BodyMesh;
use crate::remesh::outline::loops;
use crate::state::{BodyState, EffectId};
use crate::variables::Variable;

/// Bodies that are remeshed, and the model from which their plans are compiled.
pub struct RemeshPlan {
    /// The model of this plan.
    pub model: Model,
    /// Bodies in the order of their cards.
    pub bodies: Vec<RemeshedBody>,
}

/// A body that is remeshed, with its own numbering of nodes and elements ([`ModelBody`]).
#[derive(Memory)]
pub struct RemeshedBody {
    /// Ledger row; `None` on the first mesh of a body that no card names.
    pub id: Option<EffectId>,
    /// Element group.
    pub group: usize,
    /// Index in the group of each element.
    pub elements: Vec<u32>,
    /// Solver node of each node.
    pub nodes: Vec<usize>,
    /// Nodes of the body at the corners of its elements.
    pub quads: Vec<[u32; 4]>,
    /// Increments between two checks.
    pub frequency: u64,
    /// Smallest angle, radians.
    pub angle: f64,
    /// Smallest fraction of the stable time increment after the last mesh; without a card, of the largest one.
    pub increment: f64,
    /// Whether no card names the body.
    pub automatic: bool,
}

/// User subroutines that continue on new meshes: their state is that of elements, amplitudes and points of loads.
const CARRIED_ROUTINES: &[&str] = &["vumat", "vuhard", "vusdfld", "vuanisohyper_inv", "vuamp", "vdload", "vfriction"];
const UNCARRIED_ROUTINES: &str =
    "user subroutines other than VUMAT, VUHARD, VUSDFLD, VUANISOHYPER_INV, VUAMP, VDLOAD and VFRICTION";

/// Lists the bodies of all `*REMESH` cards; `None` without any. New meshes keep the `fronts` of analytical surfaces.
pub fn plan(
    scene: Scene,
    (links, pairs): (&Links, &Pairs),
    fronts: &[AnalyticalFront],
    state: &mut State,
    report: &mut Report,
) -> Option<Box<RemeshPlan>> {
    let model = scene.model;
    if model.remeshings.is_empty() || report.diagnostics.has_errors() {
        return None;
    }
    let mut bodies = Vec::new();
    for (index, card) in model.remeshings.iter().enumerate() {
        let body = ModelBody::new(model, index);
        let shared = SharedNodes::new(scene, &body, card, state);
        let unsupported = unsupported_remeshing(scene, (links, pairs), card, (&body, &shared), (state, report));
        if let Some((message, help)) = unsupported {
            report.push(Diagnostic::error("P072", message).at(card.span, "this body").help(help));
            continue;
        }
        bodies.extend(planned_body(scene.places, card, &body, state, report));
    }
    let mut model = model.clone();
    fix_tied_nodes(&mut model);
    model.surfaces.fronts = Some(fronts.to_vec());
    model.surfaces.parts.get_or_insert_with(|| parts_in_contact(scene));
    Some(Box::new(RemeshPlan { model, bodies }))
}

/// Makes the nodes that ties have found those that remain tied, and that no tie moves again.
pub(super) fn fix_tied_nodes(model: &mut Model) {
    if model.constraints.ties.is_empty() || !model.constraints.tie_places.is_empty() {
        return;
    }
    let attached = find_attached_nodes(model, &mut Diagnostics::default());
    for (tie, nodes) in model.constraints.ties.iter_mut().zip(attached) {
        tie.adjust = false;
        tie.chosen = Some(sorted_unique(nodes.iter().map(|attached| attached.node)));
    }
}

fn planned_body(
    places: &SolidPlaces,
    card: &Remeshing,
    body: &ModelBody,
    state: &mut State,
    report: &mut Report,
) -> Option<RemeshedBody> {
    let group = places.elements[&card.elements[0]].0;
    let Some(transfer) = state.elements.groups[group].transfer() else {
        let message = "moduli that depend on field variables, WEIGHTING=AREA and SUBZONAL=YES are not supported in bodies that are remeshed";
        let finding = Diagnostic::error("P072", message).at(card.span, "this body");
        return report.refuse(finding.help("use another material or other section controls"));
    };
    transfer.prepare();
    if let Some(heat) = state.thermal.as_mut().and_then(|thermal| thermal.heat.as_mut()) {
        heat.begin_adaptive(group, &state.elements);
    }
    let detail = format!(
        "new mesh below {} degrees or {} of the stable time increment, checked every {} increments",
        (1e9 * card.angle.to_degrees()).round() / 1e9,
        card.increment,
        card.frequency
    );
    let id = report.ledger_row(card.span, "remeshing", card.elements.len(), "elements", detail);
    Some(RemeshedBody { id: Some(id), ..remeshed_body(places, card, body) })
}

pub(super) fn remeshed_body(places: &SolidPlaces, card: &Remeshing, body: &ModelBody) -> RemeshedBody {
    let members = || card.elements.iter().map(|e| places.elements[e]);
    RemeshedBody {
        id: None,
        group: members().next().map_or(0, |place| place.0),
        elements: members().map(|place| place.1 as u32).collect(),
        nodes: body.nodes.iter().map(|node| places.nodes[node]).collect(),
        quads: body.quads.clone(),
        frequency: card.frequency,
        angle: card.angle,
        increment: card.increment,
        automatic: card.automatic,
    }
}

/// Returns why a body cannot be remeshed, and what could be.
pub(super) fn unsupported_remeshing(
    scene: Scene,
    (links, pairs): (&Links, &Pairs),
    card: &Remeshing,
    (body, shared): (&ModelBody, &SharedNodes),
    (state, report): (&State, &Report),
) -> Option<(String, &'static str)> {
    let name = &card.set;
    let groups = &state.elements.groups;
    let places: Vec<_> = card.elements.iter().filter_map(|e| scene.places.elements.get(e)).collect();
    let whole = places
        .first()
        .is_some_and(|first| places.len() == groups[first.0].len() && places.iter().all(|place| place.0 == first.0));
    if !whole || places.len() < card.elements.len() {
        let message = format!("`{name}` does not consist of all elements of one *SOLID SECTION");
        return Some((message, "give one *REMESH, and one section, for each body"));
    }
    let group = &groups[places[0].0];
    if group.topology() != ElementTopology::Quadrilateral {
        let message = format!("`{name}` contains elements other than CAX4R and CAX3");
        return Some((message, "give a set of CAX4R or CAX3 elements"));
    }
    if group.properties().deletable && scene.model.steps.iter().any(Step::merges_detached_nodes) {
        let message =
            format!("NODAL EROSION=MERGE adds mass to nodes of `{name}`, which new elements would not contain");
        return Some((message, "use NODAL EROSION=YES, or keep failed material instead of deleting it"));
    }
    if card.limits.strain_change.is_some() && group.value(0, Variable::PlasticStrain.into()).is_none() {
        let message = format!("the material of `{name}` has no equivalent plastic strain (PEEQ)");
        return Some((message, "remove STRAIN CHANGE, or use a material with plasticity"));
    }
    if scales_equation_of_state(scene.model, &card.elements) {
        let message = format!("the mass of `{name}`, whose material has *EOS, is scaled");
        return Some((message, "give the mass scaling an ELSET without this body"));
    }
    if let Some((what, help)) = shared.refusal(scene, group.properties().deletable, state) {
        return Some((format!("elements outside `{name}` use nodes of its elements{what}"), help));
    }
    if state.elements.fields.is_some() && !has_uniform_fields(scene.model, &body.nodes) {
        let message = format!("prescribed temperatures or field variables differ between the nodes of `{name}`");
        return Some((message, "prescribe one value for all nodes of the body"));
    }
    let mesh = BodyMesh { quads: body.quads.clone(), ..BodyMesh::default() };
    let boundaries = loops(&mesh);
    let Some(boundaries) = boundaries else {
        return Some((format!("the boundary of `{name}` touches itself in a node"), "separate the parts of the body"));
    };
    let used = |node: usize| body.nodes.binary_search(&node).ok();
    let on_boundary: FxHashSet<u32> = boundaries.iter().flatten().map(|edge| edge.ends[0]).collect();
    if shared.nodes.iter().any(|node| !on_boundary.contains(node)) {
        let message = format!("elements outside `{name}` use a node inside it");
        return Some((message, "separate the bodies, with contact between them"));
    }
    if kept_nodes_of_histories(scene.model).filter_map(used).any(|at| !on_boundary.contains(&(at as u32))) {
        let message = format!("a history shows the values of a node inside `{name}`, which a new mesh does not keep");
        return Some((message, "request only U, V, A, COORD or NT, a statistic of a set, or a node on the boundary"));
    }
    if single_nodes(scene.model).filter_map(used).any(|at| !on_boundary.contains(&(at as u32))) {
        let message = format!(
            "a spring, dashpot, point mass or concentrated load acts on a node inside `{name}`, which a new \
             mesh does not keep"
        );
        return Some((
            message,
            "attach it to a node on the boundary of the body, or use *BOUNDARY, pressures or body forces",
        ));
    }
    if has_pairs_at_ties(scene, links, pairs, body) {
        let message = format!("a *CONTACT PAIR contains tied nodes of `{name}` or of the body to which it is tied");
        return Some((
            message,
            "leave the faces at tied nodes out of the surfaces of the pair, or use general contact (*CONTACT)",
        ));
    }
    let exclusion = excluded_by_model(scene, state, report)
        .or_else(|| excluded_by_elements(scene.model, pairs, &card.elements))
        .or_else(|| excluded_by_nodes(scene, body, &used));
    exclusion.map(|what| (format!("*REMESH cannot be combined with {what}"), "remove one of the two"))
}

/// Nodes of a body that elements outside it use. New meshes keep them, and the edges between them.
pub(super) struct SharedNodes {
    /// Nodes of the body, ascending.
    pub(super) nodes: Vec<u32>,
    /// Whether all these elements are CAX4R or CAX3.
    of_quadrilaterals: bool,
}

impl SharedNodes {
    pub(super) fn new(scene: Scene, body: &ModelBody, card: &Remeshing, state: &State) -> SharedNodes {
        let is_quadrilateral = |element: usize| {
            let place = scene.places.elements.get(&element);
            let topology = place.map(|place| state.elements.groups[place.0].topology());
            topology == Some(ElementTopology::Quadrilateral)
        };
        let (mut nodes, mut of_quadrilaterals) = (Vec::new(), true);
        for (element, node) in elements_at_body(&scene.model.mesh, body, &card.elements) {
            nodes.push(node);
            of_quadrilaterals &= is_quadrilateral(element);
        }
        SharedNodes { nodes: sorted_unique(nodes), of_quadrilaterals }
    }

    /// Returns why a body with such nodes cannot have new meshes, after the statement that it has them, and what would help.
    /// `deletable`: elements of the body may be deleted.
    fn refusal(&self, scene: Scene, deletable: bool, state: &State) -> Option<(&'static str, &'static str)> {
        if self.nodes.is_empty() {
            return None;
        }
        let heats = state.thermal.as_ref().is_some_and(|thermal| thermal.heat.is_some());
        let exclusions = [
            (!self.of_quadrilaterals, ", and are not CAX4R or CAX3"),
            (deletable, ", and elements may be deleted"),
            (heats, ", and nodes have temperatures"),
            (scene.model.scales_masses(), ", and masses are scaled"),
        ];
        let found = exclusions.into_iter().find(|(is_there, _)| *is_there);
        found.map(|(_, what)| (what, "separate the bodies, with contact or *TIE between them"))
    }
}

/// Returns what in the model excludes new meshes of any body.
fn excluded_by_model(scene: Scene, state: &State, report: &Report) -> Option<&'static str> {
    let (model, elements) = (scene.model, &state.elements);
    let loads = || model.steps.iter().flat_map(|step| &step.loads);
    let heats = state.thermal.as_ref().is_some_and(|thermal| thermal.heat.is_some());
    let exclusions = [
        (report.called_routines.iter().any(|name| !CARRIED_ROUTINES.contains(name)), UNCARRIED_ROUTINES),
        (elements.assembly.rings.is_some(), "WEIGHTING=AREA"),
        (heats && !model.constraints.ties.is_empty(), "*TIE together with nodal temperatures"),
        (ties_rigid_bodies(scene), "*TIE at rigid bodies"),
        (!model.targets.is_empty(), "*TARGET"),
        (loads().any(|load| matches!(load.kind, LoadKind::Cavity { .. })), "resistance loads"),
        (state.dofs.bodies.iter().any(BodyState::is_spatial), "oblique rigid bodies"),
    ];
    exclusions.into_iter().find(|(is_there, _)| *is_there).map(|(_, what)| what)
}

/// Returns what excludes new meshes in the section or on the surfaces of a body; `elements` are in ascending order.
fn excluded_by_elements(model: &Model, pairs: &Pairs, elements: &[usize]) -> Option<&'static str> {
    let is_own = |element: &usize| elements.binary_search(element).is_ok();
    let controls = |section: &SolidSection| section.controls.distortion.is_some();
    let mut sections = model.sections.iter().filter(|section| controls(section));
    let mut contacts = pairs.by_step.iter().flat_map(|pairs| pairs.iter());
    let bonds = |contact: &SurfaceContact| {
        cohesion_of(model, contact).is_some() && contact.sides.iter().any(|side| has_faces_of(side, elements))
    };
    let exclusions = [
        (sections.any(|section| section.elements.iter().any(is_own)), "DISTORTION CONTROL in its section"),
        (contacts.any(bonds), "*COHESIVE BEHAVIOR on its surfaces"),
    ];
    exclusions.into_iter().find(|(is_there, _)| *is_there).map(|(_, what)| what)
}

/// Returns whether a side of a contact pair has faces of elements, which are in ascending order.
pub(super) fn has_faces_of(side: &SideSelection, elements: &[usize]) -> bool {
    let is_own = |element: &usize| elements.binary_search(element).is_ok();
    side.faces.iter().any(|(e, _)| is_own(e)) || side.free_face_elements.iter().any(is_own)
}

/// Returns whether a tie has nodes of rigid bodies.
fn ties_rigid_bodies(scene: Scene) -> bool {
    let mesh = &scene.model.mesh;
    let is_rigid = |node: &usize| scene.bodies.of_node.contains_key(node);
    scene.model.constraints.ties.iter().any(|tie| {
        let masters = tie.masters.iter().filter_map(|(e, side)| mesh.side_nodes(*e, *side)).flatten();
        tie.slaves.iter().any(is_rigid) || masters.into_iter().any(|node| is_rigid(&node))
    })
}

/// Returns whether a body is tied, and a contact pair contains tied nodes. They may be in contact while the nodes of both
/// surfaces coincide; those of a new mesh are in equations.
fn has_pairs_at_ties(scene: Scene, links: &Links, pairs: &Pairs, body: &ModelBody) -> bool {
    let model = scene.model;
    if model.constraints.ties.is_empty() {
        return false;
    }
    let linked: FxHashSet<usize> = links.involved_dofs().into_iter().map(|(node, _)| node).collect();
    let is_linked = |node: &usize| scene.places.nodes.get(node).is_some_and(|place| linked.contains(place));
    let has_linked_face = |side: &SideSelection| {
        let ends = side.faces.iter().filter_map(|(element, side)| model.mesh.side_nodes(*element, *side));
        ends.flatten().any(|node| is_linked(&node))
    };
    let mut contacts = pairs.by_step.iter().flat_map(|pairs| pairs.iter()).filter(|contact| !contact.general);
    body.nodes.iter().any(is_linked) && contacts.any(|contact| contact.sides.iter().any(has_linked_face))
}

/// Returns what excludes new meshes at the nodes or elements of a body.
fn excluded_by_nodes(scene: Scene, body: &ModelBody, used: &dyn Fn(usize) -> Option<usize>) -> Option<&'static str> {
    let model = scene.model;
    let requests = model.steps.iter().flat_map(|step| &step.outputs);
    let is_single = |request: &&OutputRequest| {
        let of_elements = request.kind == OutputKind::History && request.card == OutputCard::Element;
        of_elements && request.statistics.is_empty()
    };
    let sets_of_histories = requests.filter(is_single).filter_map(|request| match request.region {
        OutputRegion::Elements(id) => Some(&model.element_sets[id].members),
        _ => None,
    });
    let mut nodes_of_histories = sets_of_histories.flatten().flat_map(|e| model.mesh.elements[*e].nodes.iter());
    let is_used = |node: usize| used(node).is_some();
    // A new node between two nodes of an equation or a link would not follow.
    let mut linked = linked_nodes(model);
    let exclusions = [
        (linked.any(is_used), "*EQUATION, *MPC and *COUPLING at nodes of the body"),
        (nodes_of_histories.any(|node| is_used(*node)), "histories of single elements of the body"),
        (body.nodes.iter().any(|node| scene.bodies.of_node.contains_key(node)), "rigid bodies at nodes of the body"),
        (model.constraints.equations.iter().any(|equation| equation.is_thermal()), "*EQUATION between temperatures"),
    ];
    exclusions.into_iter().find(|(is_there, _)| *is_there).map(|(_, what)| what)
}
