//! Deformable solids of the plan: element groups from sections, nodal masses, initial conditions.

pub mod averaging;
pub mod cohesive;
pub mod erosion;
pub mod mass_scaling;
pub mod ranges;
pub mod shells;
pub mod soft_material;
pub mod solid_material;
pub mod solid_properties;
pub mod strength;
pub mod user_material;

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};

use crate::constraint::tie::TiedNodes;
use crate::deck::{Diagnostic, Span};
use crate::element::damping::{RayleighDamping, RayleighFactors};
use crate::element::distortion::DistortionControl;
use crate::element::elements::Elements;
use crate::element::frequency::HighestFrequency;
use crate::element::group::ElementGroup;
use crate::element::lengths::UserLengthElements;
use crate::element::rings::RingFactors;
use crate::element::solid_groups::Connectivity;
use crate::kernel::moduli::ElasticModuli;
use crate::kernel::quad;
use crate::kernel::topology::ElementTopology;
use crate::material::PointValue;
use crate::mesh::gather::NodalAssembly;
use crate::model::{
    FailureCriterion, IncrementControl, InitialCondition, InitialKind, MaterialDefinition, Model, PointMass,
    RayleighCoefficients, Remeshing, SolidSection, Step,
};
use crate::plan::constraints::links::linked_nodes;
use crate::plan::constraints::tie_equations::TieEquations;
use crate::plan::heat::fields::start_fields;
use crate::plan::meshes::numbering;
use crate::plan::solids::averaging::dilation_averaging;
use crate::plan::solids::cohesive::{cohesive_group, cohesive_sections};
use crate::plan::solids::mass_scaling::{marked_nodes, nodes_of_links};
use crate::plan::solids::shells::{ShellInput, free_shells, place_rotations, shell_group};
use crate::plan::solids::solid_material::solid_group;
use crate::plan::solids::user_material::calls_routines_at_points;
use crate::plan::state::SolidState;
use crate::plan::{Bodies, GroupInput, Links, MeshIndexMap, Report, Scene, SolidPlaces, State};
use crate::state::EffectId;
use crate::state::dofs::Dofs;
use crate::state::nodes::{Node, Nodes};
use crate::variables::Variable;

/// Sets the places of the elements of a group, and returns its ledger row.
fn place_elements(
    places: &mut SolidPlaces,
    elements: &[usize],
    group: usize,
    row: (Span, &'static str),
    report: &mut Report,
) -> EffectId {
    for (i, &e) in elements.iter().enumerate() {
        places.elements.insert(e, (group, i));
    }
    report.ledger_rows.get(&row).copied().unwrap_or_default()
}

/// The deformable bodies of a plan.
#[derive(Default)]
pub struct Solids {
    pub places: SolidPlaces,
    /// Deformable nodes that are tied to rigid bodies.
    pub ties: Vec<TiedNodes>,
    /// Nodes and elements, with their initial conditions.
    pub state: SolidState,
}

/// Creates the nodes and element groups of all deformable bodies, and the nodes of springs, dashpots and free masses; empty
/// if there are none. Adds the mass of tied nodes to the rigid bodies.
pub fn plan(model: &Model, bodies: &mut Bodies, ties: &[TieEquations], report: &mut Report) -> Solids {
    let of_section =
        |s| by_topology(model, elements_in_order(model, bodies, s)).into_iter().map(move |elements| (s, elements));
    let sections: Vec<(&SolidSection, Vec<usize>)> = model.sections.iter().flat_map(of_section).collect();
    let (shells, interfaces) = (free_shells(model, bodies), cohesive_sections(model));
    if sections.is_empty() && shells.is_empty() && interfaces.is_empty() && !has_discrete_nodes(model, bodies) {
        return Solids::default();
    }
    let mut solids = Solids::default();
    let places = &mut solids.places;
    let lists = sections.iter().map(|s| &s.1).chain(shells.iter().map(|s| &s.1));
    let mut nodes = place_nodes(model, bodies, places, ties, lists.chain(interfaces.iter().map(|s| &s.1)));
    place_rotations(model, places, &shells, &mut nodes, report);
    let count = sections.iter().map(|s| s.1.len()).chain(shells.iter().map(|s| s.1.len())).sum();
    places.elements = MeshIndexMap::with_capacity(count);
    let mut mass = vec![0.0; nodes.len()];
    let (mut groups, mut ids): (Vec<Box<dyn ElementGroup>>, Vec<_>) = Default::default();
    let (mut controlled, mut damped, mut averagings, mut lengths) = <(Vec<_>, Vec<_>, Vec<_>, Vec<_>)>::default();
    for (section, elements) in &sections {
        let nodes = &*nodes_of_mesh(model, places, elements, &nodes);
        let Some(list) = connectivity_of(model, places, elements, nodes, report) else { continue };
        let material = &model.materials[section.material];
        let input = GroupInput { model, places, section: *section, material, elements, connectivity: &list, nodes };
        list.add_masses(nodes, material.density.unwrap_or(0.0), &mut mass);
        let Some(group) = solid_group(&input, report) else { continue };
        ids.push(place_elements(places, elements, groups.len(), (section.span, "deformable elements"), report));
        controlled.extend(distortion_control(section, elements.len(), report).map(|ratio| (groups.len(), ratio)));
        damped.push(rayleigh_factors(model, section, elements.len(), report));
        averagings.push(dilation_averaging(model, section, list.quadrilaterals(), report));
        lengths.extend(user_lengths(model, section, elements, groups.len()));
        groups.push(group);
    }
    for (section, elements) in &shells {
        let input =
            ShellInput { scene: Scene { model, bodies: &*bodies, places: &*places }, section, elements, nodes: &nodes };
        let Some(group) = shell_group(&input, report) else { continue };
        add_masses(&*group, &mut mass);
        ids.push(place_elements(places, elements, groups.len(), (section.span, "shells"), report));
        groups.push(group);
    }
    for (section, elements) in &interfaces {
        let material = &model.materials[section.material];
        let input =
            GroupInput { model, places, section: *section, material, elements, connectivity: &(), nodes: &nodes };
        let Some(group) = cohesive_group(&input, report) else { continue };
        add_masses(&*group, &mut mass);
        ids.push(place_elements(places, elements, groups.len(), (section.span, "cohesive elements"), report));
        groups.push(group);
    }
    check_steps_alike(model, report);
    point_masses(model, places, &mut mass, report);
    solids.ties = tie_nodes(bodies, places, &mut mass, report);
    let listed = groups.iter().map(|g| (g.topology().force_blocks(), (0..g.len()).map(|e| g.nodes(e))));
    let gather = NodalAssembly::new(nodes.len(), &listed.collect::<Vec<_>>());
    let mut elements = Elements::new(groups, ids, gather, nodes.len());
    elements.lengths = lengths;
    let nodes = Nodes::new(nodes, mass);
    for (group, ratio) in controlled {
        let control = elements.distortion.get_or_insert_with(Box::<DistortionControl>::default);
        let controlled = &elements.groups[group];
        let cells = (0..controlled.len()).flat_map(|e| controlled.cells(e).map(move |cell| (e, cell)));
        control.add(group, cells, &nodes, ratio);
    }
    if averagings.iter().any(Option::is_some) {
        elements.averagings = averagings;
    }
    if damped.iter().any(|factors: &RayleighFactors| factors.mass > 0.0 || factors.stiffness > 0.0) {
        let linear = model.steps.iter().map(|s| s.bulk_viscosity.linear).fold(0.0, f64::max);
        elements.damping = Some(Box::new(RayleighDamping::new(damped, linear, &elements.groups, nodes.len())));
    }
    if sections.iter().any(|(s, _)| s.controls.by_area) {
        elements.assembly.rings = Some(Box::new(RingFactors::new(&elements.groups, nodes.len())));
    }
    let mut state = SolidState { dofs: Dofs { nodes, ..Dofs::default() }, elements };
    start_solid(model, places, &mut state, report);
    start_temperatures(model, places, &mut state.elements.groups);
    start_fields(model, places, &mut state);
    note_unused_rate_dependence(model, report);
    solids.state = state;
    solids
}

/// Returns whether the model has springs, dashpots, or masses on nodes that belong to no rigid body.
fn has_discrete_nodes(model: &Model, bodies: &Bodies) -> bool {
    let is_free = |point: &PointMass| !bodies.of_node.contains_key(&point.node);
    !model.discrete.connectors.is_empty() || model.discrete.masses.iter().any(is_free)
}

/// Adds the masses of the elements of a group to those of their nodes.
fn add_masses(group: &dyn ElementGroup, mass: &mut [f64]) {
    for element in 0..group.len() {
        for (n, m) in group.nodes(element).into_iter().zip(group.masses(element)) {
            mass[n as usize] += m;
        }
    }
}

/// Lists `*RATE DEPENDENT` of materials without a yield stress as unused.
fn note_unused_rate_dependence(model: &Model, report: &mut Report) {
    let yields = |m: &MaterialDefinition| m.plastic.is_some() || m.foam.shape.is_some() || m.has_strength_law();
    for material in model.materials.iter().filter(|m| m.rate.is_some() && !yields(m) && m.user.material.is_none()) {
        report.add_unused_card(material.span, "*RATE DEPENDENT", "the material has no *PLASTIC");
    }
}

/// Creates the solver nodes of deformable elements, including those shared with rigid bodies.
fn place_nodes<'e>(
    model: &Model,
    bodies: &Bodies,
    places: &mut SolidPlaces,
    ties: &[TieEquations],
    sections: impl Iterator<Item = &'e Vec<usize>>,
) -> Vec<Node> {
    let mesh = &model.mesh;
    places.nodes = numbering::nodes(sections.flatten().copied(), linked_nodes(model, bodies, ties), mesh);
    places.tied = places.nodes.keys().filter_map(|n| Some((n, *bodies.of_node.get(&n)?))).collect();
    let mut nodes = vec![Node::default(); places.nodes.len()];
    for (n, &place) in places.nodes.iter() {
        nodes[place] = Node { r: mesh.points[n][0], z: mesh.points[n][1], ..Node::default() };
    }
    nodes
}

/// Returns the nodes of the mesh of elements. Those that a body with a new mesh shares with other elements are at their places in this
/// mesh.
fn nodes_of_mesh<'n>(model: &Model, places: &SolidPlaces, elements: &[usize], nodes: &'n [Node]) -> Cow<'n, [Node]> {
    let mut bodies = model.remeshings.iter().filter(|body| !body.shared.is_empty());
    let has_first = |body: &&Remeshing| elements.first().is_some_and(|e| body.elements.binary_search(e).is_ok());
    let Some(body) = bodies.find(has_first) else { return Cow::Borrowed(nodes) };
    let mut moved = nodes.to_vec();
    for (node, [r, z]) in &body.shared {
        moved[places.nodes[node]] = Node { r: *r, z: *z, ..Node::default() };
    }
    Cow::Owned(moved)
}

/// Returns the damping factors of a section; zeros without damping.
fn rayleigh_factors(model: &Model, section: &SolidSection, count: usize, report: &mut Report) -> RayleighFactors {
    let material = &model.materials[section.material];
    let Some(RayleighCoefficients { alpha, beta, span }) = material.damping else {
        return RayleighFactors::default();
    };
    if section.controls.by_area {
        let message = "WEIGHTING=AREA with *DAMPING is not supported";
        report.push(Diagnostic::error("P050", message).at(section.span, "this section"));
    }
    let ElasticModuli { bulk, shear } =
        material.elastic.map(|[young, ratio]| ElasticModuli::from_young(young, ratio)).unwrap_or_default();
    if beta > 0.0 && material.elastic.is_none() {
        let message = format!("BETA of *DAMPING requires *ELASTIC, and material {} has none", material.name);
        let help = "use ALPHA, or *BULK VISCOSITY";
        report.push(Diagnostic::error("P051", message).at(span, "here").help(help));
    }
    if alpha > 0.0 {
        report.ledger_row(span, "mass proportional damping", count, "elements", format!("alpha = {alpha}"));
    }
    if beta > 0.0 {
        report.ledger_row(span, "stiffness proportional damping", count, "elements", format!("beta = {beta}"));
    }
    RayleighFactors { mass: alpha, stiffness: beta, moduli: [bulk, shear] }
}

/// Returns the elements of built-in materials whose characteristic length is user-defined (VUCHARLENGTH).
fn user_lengths(model: &Model, section: &SolidSection, elements: &[usize], group: usize) -> Option<UserLengthElements> {
    let material = &model.materials[section.material];
    let (properties, _) = material.user.lengths.as_ref()?;
    let evolves = material.failures.iter().any(FailureCriterion::takes_length);
    (evolves && !calls_routines_at_points(material)).then(|| UserLengthElements {
        group,
        name: material.name.clone(),
        properties: properties.clone(),
        elements: elements.iter().map(|&e| model.mesh.elements[e].name.to_string()).collect(),
    })
}

/// Returns LENGTH RATIO of a section with distortion control.
fn distortion_control(section: &SolidSection, count: usize, report: &mut Report) -> Option<f64> {
    let ratio = section.controls.distortion?;
    report.ledger_row(section.span, "distortion control", count, "elements", format!("length ratio {ratio}"));
    Some(ratio)
}

/// Creates the global estimate of the stable time increment, unless all steps use ELEMENT BY ELEMENT.
pub fn estimate_frequency(scene: Scene, state: &mut State, report: &mut Report) {
    let asks = |s: &&Step| matches!(s.increment, IncrementControl::Automatic { element_by_element: false, .. });
    let Some(step) = scene.model.steps.iter().find(asks) else { return };
    let model = scene.model;
    let frequency = (!model.scales_masses() && !model.has_adaptive_mesh())
        .then(|| HighestFrequency::new(&state.elements.groups, &state.dofs.nodes));
    let Some(mut frequency) = frequency.flatten() else {
        let why = if model.scales_masses() {
            "with mass scaling the estimate is element by element"
        } else if model.has_adaptive_mesh() {
            "with adaptive meshes the estimate is element by element"
        } else if !model.cohesive_sections.is_empty() {
            "with cohesive elements the estimate is element by element"
        } else if scene.places.rotations.is_empty() {
            "a material is not linear elastic at small strains; the estimate is element by element"
        } else {
            "with shells the estimate is element by element"
        };
        report.add_unused_card(step.span, "global estimate of the stable increment", why);
        return;
    };
    let detail = "highest frequency by the Lanczos method, if below the element estimate";
    let count = state.dofs.nodes.len();
    frequency.id = report.ledger_row(step.span, "global estimate", count, "nodes", detail.into());
    state.elements.frequency = Some(Box::new(frequency));
}

/// Checks that step settings that elements take from the first step do not change.
fn check_steps_alike(model: &Model, report: &mut Report) {
    let Some(first) = model.steps.first() else { return };
    for step in &model.steps {
        let heat = (step.adiabatic, step.coupled) != (first.adiabatic, first.coupled);
        if step.bulk_viscosity != first.bulk_viscosity || heat {
            let message = "bulk viscosity, ADIABATIC and the solution for temperatures must be the same in all steps";
            let finding = Diagnostic::error("P015", message).at(step.span, "this step differs from the first");
            report.push(finding.help("a change between steps is not supported"));
        }
    }
}

/// Returns the deformable elements of a section in solver order. For user subroutines this is the order of the
/// deck.
fn elements_in_order(model: &Model, bodies: &Bodies, section: &SolidSection) -> Vec<usize> {
    let elements = section.elements.iter().copied().filter(|e| !bodies.of_element.contains_key(e)).collect();
    let keeps_order = calls_routines_at_points(&model.materials[section.material]);
    if keeps_order { elements } else { numbering::in_order(elements, &model.mesh) }
}

/// Splits elements into lists of one topology.
fn by_topology(model: &Model, elements: Vec<usize>) -> Vec<Vec<usize>> {
    let is_triangle = |e: &usize| model.mesh.elements[*e].kind.topology() == Some(ElementTopology::SixNodeTriangle);
    let (triangles, others): (Vec<usize>, Vec<usize>) = elements.into_iter().partition(is_triangle);
    [others, triangles].into_iter().filter(|list| !list.is_empty()).collect()
}

/// Returns the solver nodes of elements of one topology. An element without positive volume is an error.
fn connectivity_of(
    model: &Model,
    places: &SolidPlaces,
    elements: &[usize],
    nodes: &[Node],
    report: &mut Report,
) -> Option<Connectivity> {
    let mesh = &model.mesh;
    let node = |n: usize| places.nodes[&n] as u32;
    for &e in elements {
        let element = &mesh.elements[e];
        let volumes = mesh.cells(e).map(|cell| quad::volume(cell.map(|n| nodes[node(n) as usize].place())));
        let volume = volumes.fold(f64::INFINITY, |least, v| if v > least { least } else { v });
        if volume.is_nan() || volume <= 0.0 {
            let message = format!("element {} has volume {volume:e}", element.name);
            let finding = Diagnostic::error("P012", message).at(element.span, "this element");
            report.push(finding.help("number its nodes counter-clockwise in the r-z plane, with r >= 0"));
            return None;
        }
    }
    let kind = mesh.elements[*elements.first()?].kind;
    Some(if kind.topology() == Some(ElementTopology::SixNodeTriangle) {
        let around = |&e: &usize| Some(mesh.elements[e].nodes.first_chunk::<6>()?.map(node));
        Connectivity::SixNodeTriangles(elements.iter().filter_map(around).collect())
    } else {
        let mut cells = Vec::with_capacity(elements.len());
        cells.extend(elements.iter().flat_map(|&e| mesh.cells(e)).map(|cell| cell.map(node)));
        Connectivity::Quadrilaterals(cells)
    })
}

/// Adds the point masses on nodes that are not tied to rigid bodies.
fn point_masses(model: &Model, places: &SolidPlaces, mass: &mut [f64], report: &mut Report) {
    for points in model.discrete.masses.chunk_by(|a, b| a.span == b.span) {
        let free = || points.iter().filter_map(|point| Some((places.free_node(point.node)?, point.mass)));
        free().for_each(|(n, m)| mass[n] += m);
        if let (count @ 1.., span) = (free().count(), points[0].span) {
            let sum: f64 = free().map(|(_, m)| m).sum();
            report.ledger_row(span, "point masses", count, "nodes", format!("mass {sum}"));
        }
    }
}

/// Warns of elements of an ideal gas with an initial energy and an initial temperature.
fn check_gas_states(model: &Model, report: &mut Report) {
    let conditions = || model.initial_conditions.iter();
    let is_gas = |section: &SolidSection| model.materials[section.material].is_ideal_gas();
    let gas: Vec<usize> = model.sections.iter().filter(|s| is_gas(s)).flat_map(|s| s.elements.clone()).collect();
    for energy in conditions().filter(|c| matches!(c.kind, InitialKind::Energy(_)) && !gas.is_empty()) {
        let both = |heat: &&InitialCondition| {
            let warm = |e: &usize| model.mesh.elements[*e].nodes.iter().all(|n| heat.members.binary_search(n).is_ok());
            heat.kind.temperature().is_some() && gas.iter().any(|e| energy.members.binary_search(e).is_ok() && warm(e))
        };
        if let Some(heat) = conditions().find(both) {
            let message = "an ideal gas has an initial specific energy and an initial temperature, of which one \
                           follows from the other; the later condition replaces the earlier one";
            let finding = Diagnostic::warning("P017", message).at(energy.span, "the energy");
            report.push(finding.at(heat.span, "the temperature").help("remove one of the conditions"));
            return;
        }
    }
}

/// Sets the initial temperatures of elements to the means of their nodes. An element without a temperature at all
/// nodes keeps its default.
fn start_temperatures(model: &Model, places: &SolidPlaces, groups: &mut [Box<dyn ElementGroup>]) {
    let mut nodal: HashMap<usize, f64> = HashMap::new();
    for condition in &model.initial_conditions {
        if let Some(value) = condition.kind.temperature() {
            nodal.extend(condition.members.iter().map(|n| (*n, value)));
        }
    }
    if nodal.is_empty() {
        return;
    }
    let mut values = Vec::new();
    for (e, &(group, i)) in places.elements.iter() {
        let nodes = &model.mesh.elements[e].nodes;
        values.clear();
        values.extend(nodes.iter().filter_map(|n| nodal.get(n)));
        if values.len() == nodes.len() {
            // The mean of equal values has their bits.
            let is_uniform = values.iter().all(|v| *v == values[0]);
            let mean = if is_uniform { values[0] } else { values.iter().sum::<f64>() / values.len() as f64 };
            groups[group].set(i, PointValue::Temperature(mean));
        }
    }
}

/// Sets the initial velocities, stresses, energies and state variables.
fn start_solid(model: &Model, places: &SolidPlaces, state: &mut SolidState, report: &mut Report) {
    check_gas_states(model, report);
    let (nodes, groups) = (&mut state.dofs.nodes, &mut state.elements.groups);
    for condition in &model.initial_conditions {
        match &condition.kind {
            InitialKind::Velocity(dof, value) if *dof <= 2 => {
                for n in condition.members.iter().filter_map(|n| places.free_node(*n)) {
                    *nodes[n].velocity(usize::from(*dof) - 1) = *value;
                }
            }
            InitialKind::Velocity(6, value) => {
                for n in condition.members.iter().filter_map(|n| places.rotations.get(n)) {
                    *nodes[*n].velocity(0) = *value;
                }
            }
            InitialKind::Velocity(..) => {}
            // Set in `start_temperatures`: elements have the mean values of their nodes.
            InitialKind::Temperature(_) => {}
            InitialKind::Energy(value) => {
                for (group, i) in condition.members.iter().filter_map(|e| places.elements.get(e)) {
                    if groups[*group].value(*i, Variable::SpecificEnergy.into()).is_none() {
                        let message = "TYPE=SPECIFIC ENERGY needs a material with *EOS";
                        report.push(Diagnostic::error("P017", message).at(condition.span, "here"));
                        break;
                    }
                    groups[*group].set(*i, PointValue::SpecificEnergy(*value));
                }
            }
            InitialKind::Hardening(value) => {
                let mut elements = condition.members.iter().filter_map(|e| places.elements.get(e));
                let set = |(group, i): &(usize, usize)| groups[*group].set(*i, PointValue::PlasticStrain(*value));
                if !elements.all(set) {
                    let message = "TYPE=HARDENING needs solid elements with *PLASTIC and isotropic hardening";
                    report.push(Diagnostic::error("P017", message).at(condition.span, "here"));
                }
            }
            InitialKind::State(values) => {
                for (group, i) in condition.members.iter().filter_map(|e| places.elements.get(e)) {
                    let group = &mut groups[*group];
                    let mut values_by_index = values.iter().enumerate();
                    if !values_by_index.all(|(v, x)| group.set(*i, PointValue::StateVariable(v, *x)) || *x == 0.0) {
                        let message = format!(
                            "{} state variables are given, but the material of some elements has fewer \
                             (*DEPVAR)",
                            values.len()
                        );
                        report.push(Diagnostic::error("P017", message).at(condition.span, "here"));
                        break;
                    }
                }
            }
            // Set in `start_fields`: elements have the mean values of their nodes.
            InitialKind::Field(..) => {}
            InitialKind::Stress(values) => {
                let eos = |&&(group, _): &&(usize, usize)| groups[group].properties().holds_pressure;
                if condition.members.iter().filter_map(|e| places.elements.get(e)).find(eos).is_some() {
                    let message = "an initial stress cannot be prescribed: the stress follows from density and energy, or from the deformation";
                    let finding = Diagnostic::error("P017", message).at(condition.span, "this initial stress");
                    report.push(finding.help("give TYPE=SPECIFIC ENERGY, or a temperature of an ideal gas"));
                    continue;
                }
                let stress = [0, 1, 2, 3].map(|i| values.get(i).copied().unwrap_or(0.0));
                for (group, i) in condition.members.iter().filter_map(|e| places.elements.get(e)) {
                    groups[*group].set(*i, PointValue::Stress(stress));
                }
            }
        }
    }
}

pub fn scale_and_estimate(scene: Scene, links: &Links, state: &mut State, report: &mut Report) {
    if state.elements.is_empty() {
        return;
    }
    if scene.model.scales_masses() {
        let linked = marked_nodes(state.dofs.nodes.len(), nodes_of_links(links));
        let Elements { groups, mass_scaling, .. } = &mut state.elements;
        mass_scaling.store_unscaled(groups, &state.dofs.nodes, linked);
    }
    estimate_frequency(scene, state, report);
}

/// Creates the ties of nodes to rigid bodies: nodes shared with deformable elements, ends of springs and dashpots. The
/// mass of deformable elements at tied nodes is moved to the rigid bodies.
fn tie_nodes(bodies: &mut Bodies, places: &SolidPlaces, mass: &mut [f64], report: &mut Report) -> Vec<TiedNodes> {
    let mut ties = Vec::new();
    let mut by_body: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (node, &body) in places.tied.iter() {
        by_body.entry(body).or_default().push(places.nodes[&node]);
    }
    for (body, mut nodes) in by_body {
        nodes.sort_unstable();
        let tied: f64 = nodes.iter().map(|&n| mass[n]).sum();
        nodes.iter().for_each(|&n| mass[n] = 0.0);
        bodies.list[body].tied_mass += tied;
        let detail = if tied > 0.0 {
            format!("shared with deformable elements, whose nodal mass {tied} is added to the rigid body")
        } else {
            "forces on them act on the rigid body".into()
        };
        let id = report.ledger_row(bodies.list[body].span, "tied nodes", nodes.len(), "nodes", detail);
        ties.push(TiedNodes { id, body, nodes });
    }
    ties
}
