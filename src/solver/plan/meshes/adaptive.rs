//! Adaptive meshes of the plan: domains, the nodes that they do not move, and combinations that are not supported.

use std::collections::{BTreeSet, HashSet};

use crate::adaptive::held_places::MeshMotion;
use crate::adaptive::smoothing::SmoothingWeights;
use crate::adaptive::transport::TransportOrder;
use crate::adaptive::{AdaptiveDomain, AdaptiveSettings, DomainBoundary};
use crate::deck::{Diagnostic, Span};
use crate::kernel::lists::{sorted_pair, sorted_unique};
use crate::kernel::topology::ElementTopology;
use crate::model::{
    AdaptiveMesh, AdaptiveRegion, BoundaryCondition, ElementSide, LoadKind, Model, MotionKind, RegionType, Step,
};
use crate::plan::contact::cohesion::cohesive_nodes;
use crate::plan::heat::fields::has_uniform_fields;
use crate::plan::loads::magnitude;
use crate::plan::solids::mass_scaling::{constrained_nodes, scales_equation_of_state};
use crate::plan::{Links, Pairs, Report, Scene, State};

/// Default of FREQUENCY, and that with Eulerian boundaries or spatial constraints (ABAQUS Keywords Reference Guide,
/// `*ADAPTIVE MESH`).
const FREQUENCY: u64 = 10;
const SPATIAL_FREQUENCY: u64 = 1;

/// Creates the domains of a step; `None` if those of the previous step continue.
pub fn adaptive_change<'a>(
    scene: Scene<'a>,
    links: &Links,
    pairs: &Pairs,
    index: usize,
    state: &mut State,
    report: &mut Report,
) -> Option<Vec<AdaptiveDomain>> {
    let step = &scene.model.steps[index];
    let previous = index.checked_sub(1).map(|i| &scene.model.steps[i]);
    // Loaded and bonded nodes follow the material.
    let causes = |step: &'a Step| {
        let regions = (&step.adaptive_regions, &step.mesh_motions);
        (&step.adaptive, &step.adaptive_fixed, regions, &step.loads, heated_nodes(step).collect::<Vec<usize>>())
    };
    report_unused_regions(scene.model, step, report);
    let is_absent = step.adaptive.is_empty() && previous.is_none_or(|previous| previous.adaptive.is_empty());
    let is_unchanged = |previous: &'a Step| {
        causes(previous) == causes(step)
            && cohesive_nodes(scene.model, pairs, index - 1).eq(cohesive_nodes(scene.model, pairs, index))
    };
    if is_absent || previous.is_some_and(is_unchanged) {
        return None;
    }
    // A domain of the same set continues that of the previous step.
    for mesh in &step.adaptive {
        let continued = previous.and_then(|previous| previous.adaptive.iter().find(|domain| domain.set == mesh.set));
        if let Some(domain) = continued {
            report.share_ledger_rows(domain.span, mesh.span);
        }
    }
    let constrained = constrained_nodes(links, state.dofs.nodes.len());
    let input = DomainInput { scene, step, constrained, loaded: nodes_with_loads(scene.model, pairs, index) };
    let mut taken = HashSet::new();
    let domains = step.adaptive.iter();
    Some(domains.filter_map(|mesh| adaptive_domain(&input, mesh, state, &mut taken, report)).collect())
}

/// The step of a domain, and the nodes of all its domains that must move with the material.
struct DomainInput<'a> {
    scene: Scene<'a>,
    step: &'a Step,
    /// Whether each node belongs to a rigid body, an equation or a link. Empty if there are none.
    constrained: Vec<bool>,
    /// Mesh nodes with loads, temperatures, masses and bonds.
    loaded: Vec<usize>,
}

/// Lists region types and spatial constraints of nodes that no adaptive mesh contains.
fn report_unused_regions(model: &Model, step: &Step, report: &mut Report) {
    let elements = step.adaptive.iter().flat_map(|mesh| &mesh.elements);
    let nodes: HashSet<usize> = elements.flat_map(|e| model.mesh.elements[*e].nodes.iter().copied()).collect();
    let outside = |list: &[usize]| !list.iter().any(|node| nodes.contains(node));
    let regions =
        step.adaptive_regions.iter().filter(|region| outside(&nodes_of_region(model, region).collect::<Vec<_>>()));
    let regions = regions.map(|region| (region.span, "REGION TYPE"));
    let motions = step.mesh_motions.iter().filter(|motion| outside(&motion.nodes));
    let motions = motions.map(|motion| (motion.span, "spatial constraint of a mesh"));
    let fixed = step.adaptive_fixed.iter().filter(|(_, nodes)| outside(nodes));
    let fixed = fixed.map(|(span, _)| (*span, "*ADAPTIVE MESH CONSTRAINT"));
    for (span, what) in regions.chain(motions).chain(fixed).collect::<Vec<_>>() {
        report.add_unused_card(span, what, "no adaptive mesh contains its nodes");
    }
}

fn adaptive_domain(
    input: &DomainInput,
    mesh: &AdaptiveMesh,
    state: &mut State,
    taken: &mut HashSet<usize>,
    report: &mut Report,
) -> Option<AdaptiveDomain> {
    let DomainInput { scene, step, ref constrained, ref loaded } = *input;
    let places: Vec<(usize, usize)> =
        mesh.elements.iter().filter_map(|e| scene.places.elements.get(e).copied()).collect();
    let Some(&(group, _)) = places.first() else {
        report.add_unused_card(mesh.span, "adaptive mesh", "none of its elements is deformable");
        return None;
    };
    if let Some((message, help)) = unsupported_domain(scene, (&mesh.set, &mesh.elements), &places, state) {
        refuse_domain(mesh.span, message, help, report);
        return None;
    }
    if mesh.elements.iter().any(|element| !taken.insert(*element)) {
        let message = format!("elements of `{}` belong to two adaptive meshes", mesh.set);
        refuse_domain(mesh.span, message, "give each element to one domain", report);
        return None;
    }
    let mut elements: Vec<u32> = places.iter().map(|(_, e)| *e as u32).collect();
    elements.sort_unstable();
    elements.dedup();
    let nodes: BTreeSet<u32> = elements.iter().flat_map(|e| state.elements.groups[group].nodes(*e as usize)).collect();
    let (motions, open) = (mesh_motions(scene, step, &nodes, report), eulerian_edges(scene, step, &nodes));
    let mut fixed = nodes_of_others(constrained, group, &elements, state);
    if let Some((message, help)) = unsupported_boundary(scene, step, &fixed, (&motions, &open)) {
        refuse_domain(mesh.span, message, help, report);
        return None;
    }
    note_constraints_of_fixed_nodes(scene, step, &nodes, &fixed, report);
    let sliding = sliding_nodes(scene, step, &motions, fixed.len());
    for place in loaded.iter().filter_map(|node| scene.places.nodes.get(node)) {
        fixed[*place] |= !sliding[*place];
    }
    nodes_with_material(scene, step, &mut fixed);
    let prescribed: BTreeSet<usize> = motions.iter().flat_map(|motion| &motion.dofs).map(|dof| dof.0).collect();
    let settings = settings(mesh, [!open.is_empty(), !prescribed.is_empty()]);
    let detail = adaptive_detail(mesh, &settings, [open.len(), prescribed.len()]);
    let id = report.ledger_row(mesh.span, "adaptive mesh", elements.len(), "elements", detail);
    let of_group = &mut *state.elements.groups[group];
    let is_open = |ends| open.contains(&sorted_pair(ends));
    let boundary = DomainBoundary { fixed: &fixed, sliding: &sliding, is_open: &is_open, motions };
    let domain = AdaptiveDomain::new(id, settings, (group, of_group), elements, (&state.dofs.nodes, boundary));
    if domain.is_none() {
        let message = "moduli that depend on field variables, WEIGHTING=AREA and SUBZONAL=YES are not supported in \
                       adaptive meshes";
        let help = "use another material or other section controls, or no adaptive mesh";
        refuse_domain(mesh.span, message.into(), help, report);
    }
    let domain = domain.map(|domain| if scene.model.scales_masses() { domain.with_mass_scaling() } else { domain });
    domain.map(|domain| if state.conducts_heat(group) { domain.with_temperatures() } else { domain })
}

/// Returns why a domain is not supported, and what would be.
pub(super) fn unsupported_domain(
    scene: Scene,
    (set, elements): (&str, &[usize]),
    places: &[(usize, usize)],
    state: &State,
) -> Option<(String, &'static str)> {
    let group = places[0].0;
    if places.iter().any(|(g, _)| *g != group) {
        let message = format!("the elements of `{set}` belong to several sections");
        return Some((message, "give one *ADAPTIVE MESH for the elements of each section"));
    }
    let is_supported = |&(g, _): &(usize, usize)| state.elements.groups[g].topology() == ElementTopology::Quadrilateral;
    if !places.iter().all(is_supported) {
        let message = format!("`{set}` contains elements other than CAX4R, CAX4RT, CAX3 and CAX3T");
        return Some((message, "give a set of CAX4R, CAX4RT, CAX3 or CAX3T elements"));
    }
    if scene.model.scales_masses() && state.conducts_heat(group) {
        let message = "adaptive meshes with heat conduction cannot be combined with mass scaling".into();
        return Some((message, "remove the mass scaling, or use ADIABATIC on *DYNAMIC, EXPLICIT"));
    }
    if scales_equation_of_state(scene.model, &sorted_unique(elements.iter().copied())) {
        let message = format!("the mass of `{set}`, whose material has *EOS, is scaled");
        return Some((message, "give the mass scaling an ELSET without this domain"));
    }
    if state.elements.distortion.is_some() {
        let message = "adaptive meshes cannot be combined with DISTORTION CONTROL".into();
        return Some((message, "remove DISTORTION CONTROL from *SECTION CONTROLS; the mesh stays undistorted"));
    }
    let nodes: Vec<usize> =
        sorted_unique(elements.iter().flat_map(|e| scene.model.mesh.elements[*e].nodes.iter().copied()));
    if state.elements.fields.is_some() && !has_uniform_fields(scene.model, &nodes) {
        let message = format!(
            "prescribed temperatures or field variables differ between the nodes of `{set}`: they do not follow a mesh that moves"
        );
        return Some((message, "prescribe one value for all nodes of the domain in *TEMPERATURE and *FIELD"));
    }
    None
}

fn refuse_domain(span: Span, message: String, help: &str, report: &mut Report) {
    report.push(Diagnostic::error("P071", message).at(span, "this domain").help(help));
}

/// Returns whether each node belongs to other elements, is linked, or to an element at a linked node, whose masses must
/// not change.
fn nodes_of_others(linked: &[bool], group: usize, elements: &[u32], state: &State) -> Vec<bool> {
    let mut fixed = vec![false; state.dofs.nodes.len()];
    let domain_elements: HashSet<u32> = elements.iter().copied().collect();
    let groups = &state.elements.groups;
    for (g, other) in groups.iter().enumerate() {
        for e in (0..other.len()).filter(|e| g != group || !domain_elements.contains(&(*e as u32))) {
            other.nodes(e).into_iter().for_each(|n| fixed[n as usize] = true);
        }
    }
    for e in elements {
        let nodes = groups[group].nodes(*e as usize);
        if nodes.into_iter().any(|n| linked.get(n as usize) == Some(&true)) {
            nodes.into_iter().for_each(|n| fixed[n as usize] = true);
        }
    }
    fixed
}

/// Returns the nodes of the model with concentrated loads, temperatures, masses and bonds, and those at the ends of
/// loaded surfaces.
fn nodes_with_loads(model: &Model, pairs: &Pairs, index: usize) -> Vec<usize> {
    let (step, mut nodes) = (&model.steps[index], Vec::new());
    for load in &step.loads {
        if let LoadKind::Concentrated { nodes: loaded, .. } = &load.kind {
            nodes.extend(loaded);
        }
        nodes.extend(end_nodes(model, load.kind.sides().into_iter().flat_map(|sides| &sides.faces)));
    }
    nodes.extend(heated_nodes(step));
    nodes.extend(model.discrete.masses.iter().map(|mass| mass.node));
    nodes.extend(cohesive_nodes(model, pairs, index));
    nodes
}

/// Returns the nodes that belong to one of the faces only.
fn end_nodes<'f>(model: &Model, faces: impl Iterator<Item = &'f (usize, ElementSide)>) -> HashSet<usize> {
    let mut ends = HashSet::new();
    for node in faces.filter_map(|(e, side)| model.mesh.side_nodes(*e, *side)).flatten() {
        if !ends.remove(&node) {
            ends.insert(node);
        }
    }
    ends
}

/// Lists constraints of a mesh all of whose nodes move with the material in any case.
fn note_constraints_of_fixed_nodes(
    scene: Scene,
    step: &Step,
    domain_nodes: &BTreeSet<u32>,
    fixed: &[bool],
    report: &mut Report,
) {
    for (span, nodes) in &step.adaptive_fixed {
        let places = nodes.iter().filter_map(|node| scene.places.nodes.get(node).copied());
        let mut of_domain = places.filter(|place| domain_nodes.contains(&(*place as u32))).peekable();
        if of_domain.peek().is_some() && of_domain.all(|place| fixed[place]) {
            let why = "its nodes move with the material in any case: they belong to other bodies, or to elements with \
                       nodes of links or rigid bodies";
            report.add_unused_card(*span, "*ADAPTIVE MESH CONSTRAINT", why);
        }
    }
}

/// Marks the nodes of `*ADAPTIVE MESH CONSTRAINT, CONSTRAINT TYPE=LAGRANGIAN`, and the ends of surfaces of REGION
/// TYPE=LAGRANGIAN.
fn nodes_with_material(scene: Scene, step: &Step, fixed: &mut [bool]) {
    let lagrangian = step.adaptive_regions.iter().filter(|region| region.kind == RegionType::Lagrangian);
    let ends = lagrangian.flat_map(|region| end_nodes(scene.model, region.faces.iter()));
    let named = step.adaptive_fixed.iter().flat_map(|(_, nodes)| nodes).copied();
    named.chain(ends).filter_map(|node| scene.places.nodes.get(&node)).for_each(|place| fixed[*place] = true);
}

/// Returns whether each node may move in spite of its loads: it belongs to a sliding or Eulerian region, or its place is
/// prescribed.
fn sliding_nodes(scene: Scene, step: &Step, motions: &[MeshMotion], count: usize) -> Vec<bool> {
    let mut sliding = vec![false; count];
    let regions = step.adaptive_regions.iter().filter(|region| region.kind != RegionType::Lagrangian);
    let nodes = regions.flat_map(|region| nodes_of_region(scene.model, region));
    let prescribed = motions.iter().flat_map(|motion| &motion.dofs).map(|dof| dof.0);
    nodes.filter_map(|node| scene.places.nodes.get(&node).copied()).chain(prescribed).for_each(|n| sliding[n] = true);
    sliding
}

fn nodes_of_region<'r>(model: &'r Model, region: &'r AdaptiveRegion) -> impl Iterator<Item = usize> + 'r {
    let of_faces = region.faces.iter().filter_map(|(e, side)| model.mesh.side_nodes(*e, *side)).flatten();
    region.nodes.iter().copied().chain(of_faces)
}

/// Returns the pairs of nodes of a domain between which material flows through its boundary; pairs inside have no effect.
fn eulerian_edges(scene: Scene, step: &Step, nodes: &BTreeSet<u32>) -> HashSet<[u32; 2]> {
    let domain_node = |node: &usize| scene.places.nodes.get(node).map(|n| *n as u32).filter(|n| nodes.contains(n));
    let mut edges = HashSet::new();
    for region in step.adaptive_regions.iter().filter(|region| region.kind == RegionType::Eulerian) {
        let of_nodes: HashSet<&usize> = region.nodes.iter().collect();
        let exterior = if of_nodes.is_empty() { Vec::new() } else { scene.model.mesh.exterior_faces() };
        let between = exterior.iter().filter_map(|(e, side)| scene.model.mesh.side_nodes(*e, *side));
        let between = between.filter(|ends| ends.iter().all(|node| of_nodes.contains(node)));
        let of_faces = region.faces.iter().filter_map(|(e, side)| scene.model.mesh.side_nodes(*e, *side));
        for [a, b] in of_faces.chain(between) {
            if let (Some(a), Some(b)) = (domain_node(&a), domain_node(&b)) {
                edges.insert(sorted_pair([a, b]));
            }
        }
    }
    edges
}

/// Returns the motions of the nodes of a domain that are prescribed in space.
fn mesh_motions(scene: Scene, step: &Step, nodes: &BTreeSet<u32>, report: &mut Report) -> Vec<MeshMotion> {
    let mut motions = Vec::new();
    for motion in &step.mesh_motions {
        let places = motion.nodes.iter().filter_map(|node| scene.places.nodes.get(node).copied());
        let axis = usize::from(motion.dof) - 1;
        let dofs: Vec<_> = places.filter(|n| nodes.contains(&(*n as u32))).map(|n| (n, axis)).collect();
        if !dofs.is_empty() {
            let magnitude = magnitude(scene, motion.value, motion.amplitude, report);
            motions.push(MeshMotion { dofs, is_velocity: motion.kind == MotionKind::Velocity, magnitude });
        }
    }
    motions
}

/// Returns why Eulerian boundaries or spatial constraints of a domain are not supported, and what would be.
fn unsupported_boundary(
    scene: Scene,
    step: &Step,
    others: &[bool],
    (motions, open): (&[MeshMotion], &HashSet<[u32; 2]>),
) -> Option<(String, &'static str)> {
    let name = |n: usize| {
        let mesh_node = scene.places.nodes.iter().find(|(_, place)| **place == n).map(|(node, _)| node);
        mesh_node.map_or_else(String::new, |node| scene.model.mesh.node_names[node].to_string())
    };
    if let Some(n) = motions.iter().flat_map(|m| &m.dofs).map(|dof| dof.0).filter(|n| others[*n]).min() {
        let message =
            format!("the place of node {} is prescribed in space, but it must move with the material", name(n));
        let help = "nodes of other elements, of links and of rigid bodies cannot be held in space: remove them from \
                    *ADAPTIVE MESH CONSTRAINT";
        return Some((message, help));
    }
    if let Some(n) = open.iter().flatten().map(|n| *n as usize).filter(|n| others[*n]).min() {
        let message = format!("node {} of an Eulerian boundary must move with the material", name(n));
        return Some((message, "an Eulerian boundary has no nodes of other elements, links or rigid bodies"));
    }
    let solver_node = |node: usize| scene.places.nodes.get(&node).map_or(u32::MAX, |n| *n as u32);
    let moved = |b: &&BoundaryCondition| b.user || b.kind == MotionKind::Displacement && b.amplitude.is_some();
    let held_dofs: HashSet<(u32, usize)> =
        motions.iter().flat_map(|m| &m.dofs).map(|(node, axis)| (*node as u32, axis + 1)).collect();
    let is_held =
        |b: &&BoundaryCondition| b.nodes.iter().any(|n| held_dofs.contains(&(solver_node(*n), usize::from(b.dof))));
    if let Some(boundary) = step.boundaries.iter().filter(moved).find(is_held) {
        let message = format!(
            "a displacement of `{}` is prescribed along the same axis as the place of the mesh: the displacement of a \
             node that material passes has no meaning",
            boundary.set
        );
        return Some((message, "prescribe the velocity of the material (*BOUNDARY, TYPE=VELOCITY)"));
    }
    let is_open = |(e, side): &(usize, ElementSide)| {
        let ends = scene.model.mesh.side_nodes(*e, *side);
        ends.is_some_and(|ends| open.contains(&sorted_pair(ends.map(solver_node))))
    };
    let contact = step.surface_contacts.iter().find(|c| c.sides.iter().any(|sides| sides.faces.iter().any(is_open)));
    if contact.is_some() {
        let message = "a surface in contact contains an Eulerian boundary".to_string();
        return Some((message, "give contact a surface without the faces through which material flows"));
    }
    let is_spatial = !open.is_empty() || !motions.is_empty();
    if is_spatial && !scene.model.remeshings.is_empty() {
        let message = "*REMESH cannot be combined with Eulerian boundaries or spatial constraints".to_string();
        return Some((message, "use one of the two"));
    }
    None
}

fn adaptive_detail(mesh: &AdaptiveMesh, settings: &AdaptiveSettings, [open, held]: [usize; 2]) -> String {
    let [volumetric, laplacian, equipotential] = mesh.controls.weights;
    let methods = [("volume", volumetric), ("Laplacian", laplacian), ("equipotential", equipotential)];
    let used: Vec<&str> = methods.iter().filter(|m| m.1 > 0.0).map(|m| m.0).collect();
    let order = if mesh.controls.second_order { "second" } else { "first" };
    let mut detail = format!(
        "every {} increments, {} sweeps of {} smoothing, transport of {order} order",
        settings.frequency,
        mesh.sweeps,
        if mesh.controls.graded { "graded".into() } else { used.join(" and ") }
    );
    if open > 0 {
        detail += &format!(", {open} edges on Eulerian boundaries");
    }
    if held > 0 {
        detail += &format!(", {held} nodes held in space");
    }
    detail
}

/// Iterates over the nodes with prescribed temperatures and nodal heat sources.
fn heated_nodes(step: &Step) -> impl Iterator<Item = usize> {
    let boundaries = step.boundaries.iter().filter(|boundary| boundary.is_thermal());
    let sources = step.loads.iter().filter_map(|load| match &load.kind {
        LoadKind::NodalHeat { nodes, .. } => Some(nodes),
        _ => None,
    });
    boundaries.flat_map(|boundary| &boundary.nodes).chain(sources.flatten()).copied()
}

/// Returns the settings of a domain, which may have Eulerian boundaries and nodes whose places are prescribed.
fn settings(mesh: &AdaptiveMesh, [is_eulerian, is_held]: [bool; 2]) -> AdaptiveSettings {
    let [volumetric, laplacian, equipotential] = mesh.controls.weights;
    let default = if is_eulerian || is_held { SPATIAL_FREQUENCY } else { FREQUENCY };
    AdaptiveSettings {
        frequency: mesh.frequency.unwrap_or(default),
        sweeps: mesh.sweeps,
        initial_sweeps: mesh.initial_sweeps,
        weights: SmoothingWeights { volumetric, laplacian, equipotential },
        graded: mesh.controls.graded,
        corner_angle: mesh.controls.corner_angle,
        order: if mesh.controls.second_order { TransportOrder::Second } else { TransportOrder::First },
        returns: mesh.controls.previous.unwrap_or(is_eulerian),
    }
}
