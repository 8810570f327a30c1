//! Rigid bodies of the plan: nodes, lumped mass and initial velocity.

pub mod rigid_bodies_3d;
pub mod rigid_body;

use std::collections::{HashMap, HashSet};

use crate::deck::{Diagnostic, Span};
use crate::kernel::facet::Facet;
use crate::kernel::lists::sorted_unique;
use crate::kernel::quad::corner_masses;
use crate::model::{ElementKind, InitialCondition, InitialKind, Model, RigidBody, RigidSurface};
use crate::plan::bodies::rigid_bodies_3d::{is_oblique, starts_in_space};
use crate::plan::constraints::links::add_followers_of_body;
use crate::plan::constraints::tie_equations::TieEquations;
use crate::plan::{Bodies, PlannedRigidBody, Report, Scene, SolidPlaces};

/// Names of the velocities of an oblique body, by degree of freedom.
const ALONG: [&str; 6] = ["v_1", "v_2", "v_3", "w_1", "w_2", "w_3"];

/// Densities of the elements of rigid bodies, and point masses by node.
struct MassSources {
    densities: HashMap<usize, f64>,
    points: HashMap<usize, Vec<f64>>,
}

impl MassSources {
    fn new(model: &Model) -> MassSources {
        let rigid: HashSet<usize> = model.rigid_bodies.iter().flat_map(|body| &body.elements).copied().collect();
        let mut densities = HashMap::new();
        for section in &model.sections {
            let Some(density) = model.materials[section.material].density else { continue };
            densities.extend(section.elements.iter().filter(|e| rigid.contains(*e)).map(|e| (*e, density)));
        }
        let mut points: HashMap<usize, Vec<f64>> = HashMap::new();
        model.discrete.masses.iter().for_each(|point| points.entry(point.node).or_default().push(point.mass));
        MassSources { densities, points }
    }
}

/// Creates all rigid bodies.
pub fn plan(model: &Model, ties: &[TieEquations], report: &mut Report) -> Bodies {
    let (sources, mut bodies) = (MassSources::new(model), Bodies::default());
    for body in &model.rigid_bodies {
        add_body(model, &mut bodies, ties, body, &sources, report);
    }
    bodies
}

/// Returns the initial velocities of the bodies along z, and checks the bodies, after the deformable bodies are known.
pub fn start(scene: Scene, report: &mut Report) -> Vec<f64> {
    let velocities = initial_velocities(scene, report);
    refuse_stray_elements(scene, report);
    check_masses(scene.model, scene.bodies, report);
    velocities
}

/// Updates masses of existing bodies from the current model.
pub fn update_masses(model: &Model, bodies: &mut Bodies, report: &mut Report) {
    let sources = MassSources::new(model);
    for (index, rigid) in model.rigid_bodies.iter().enumerate() {
        bodies.list[index].lumped_mass = lumped_mass(model, rigid, &bodies.list[index].nodes, &sources);
    }
    check_masses(model, bodies, report);
}

fn add_body(
    model: &Model,
    bodies: &mut Bodies,
    ties: &[TieEquations],
    rigid: &RigidBody,
    sources: &MassSources,
    report: &mut Report,
) {
    let index = bodies.list.len();
    let mesh = &model.mesh;
    let mut nodes: Vec<usize> = rigid.elements.iter().flat_map(|&e| mesh.elements[e].nodes.iter().copied()).collect();
    nodes.extend(&rigid.nodes);
    nodes.push(rigid.reference);
    add_followers_of_body(model, ties, rigid, &mut nodes);
    nodes.sort_unstable();
    nodes.dedup();
    for &node in &nodes {
        if bodies.of_node.insert(node, index).is_some_and(|other| other != index) {
            refuse_shared_member(rigid, format!("node {}", mesh.node_names[node]), report);
        }
    }
    for &element in &rigid.elements {
        if bodies.of_element.insert(element, index).is_some_and(|other| other != index) {
            refuse_shared_member(rigid, format!("element {}", mesh.elements[element].name), report);
        }
    }
    let lumped_mass = lumped_mass(model, rigid, &nodes, sources);
    let spatial = is_oblique(model, rigid);
    let along_z = extent_along_z(model, rigid, &nodes);
    let body = PlannedRigidBody {
        name: rigid.name.clone(),
        reference: rigid.reference,
        lumped_mass,
        tied_mass: 0.0,
        nodes,
        elements: rigid.elements.clone(),
        spatial,
        along_z,
        initial_velocity: 0.0,
        span: rigid.span,
    };
    let how = if spatial { "six degrees of freedom" } else { "moves along z" };
    let detail = format!("reference node {}, {how}", mesh.node_names[rigid.reference]);
    report.ledger_row(rigid.span, "rigid body", body.nodes.len(), "nodes", detail);
    report.ledger_row(rigid.span, "lumped mass", body.lumped_mass.len(), "nodes", format!("mass {}", body.mass()));
    bodies.list.push(body);
}

/// Returns the lowest and the highest initial z of a rigid body.
fn extent_along_z(model: &Model, rigid: &RigidBody, nodes: &[usize]) -> [f64; 2] {
    let is_of_body = |surface: &&RigidSurface| surface.reference == Some(rigid.reference);
    let profiles = model.surfaces.analytical.values().filter(is_of_body).flat_map(|s| s.profile.bounds());
    let others = nodes.iter().filter(|node| **node != rigid.reference).map(|node| model.mesh.points[*node]);
    let heights = || profiles.clone().chain(others.clone()).map(|place| place[1]);
    match heights().next() {
        None => [model.mesh.points[rigid.reference][1]; 2],
        Some(_) => [heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max)],
    }
}

fn refuse_shared_member(rigid: &RigidBody, what: String, report: &mut Report) {
    let message = format!("{what} belongs to two rigid bodies");
    report.push(Diagnostic::error("P009", message).at(rigid.span, "the second body"));
}

/// Returns the lumped nodal masses: row sums of RAX2 elements, point masses, and solid elements with the density of
/// their section (ABAQUS Analysis User's Guide, "Rigid body definition", "Rigid body mass").
fn lumped_mass(model: &Model, rigid: &RigidBody, nodes: &[usize], sources: &MassSources) -> Vec<(usize, f64)> {
    let mesh = &model.mesh;
    let mut masses = vec![0.0; nodes.len()];
    let mut add = |node: usize, mass: f64| {
        if let Ok(index) = nodes.binary_search(&node) {
            masses[index] += mass;
        }
    };
    for &element in &rigid.elements {
        if let Some(&density) = sources.densities.get(&element) {
            for cell in mesh.cells(element) {
                let masses = corner_masses(cell.map(|n| mesh.points[n]), density);
                cell.into_iter().zip(masses).for_each(|(n, mass)| add(n, mass));
            }
        }
        let element = &mesh.elements[element];
        if element.kind != ElementKind::Rax2 {
            continue;
        }
        let ends = [element.nodes[0], element.nodes[1]];
        let Some(facet) = Facet::new(mesh.points[ends[0]], mesh.points[ends[1]], true) else { continue };
        let [low, high] = facet.lumped_mass(rigid.density, rigid.thickness);
        let first_is_low = facet.low == mesh.points[ends[0]];
        add(ends[0], if first_is_low { low } else { high });
        add(ends[1], if first_is_low { high } else { low });
    }
    for node in nodes {
        sources.points.get(node).into_iter().flatten().for_each(|mass| add(*node, *mass));
    }
    nodes.iter().copied().zip(masses).filter(|m| m.1 != 0.0).collect()
}

/// Returns the initial velocity of each body along z.
pub fn initial_velocities(scene: Scene, report: &mut Report) -> Vec<f64> {
    let Scene { model, bodies, places } = scene;
    let mut velocities = vec![0.0; bodies.list.len()];
    for condition in &model.initial_conditions {
        let of_solid = condition.members.iter().any(|m| places.has_node(*m)) || is_of_solid(places, condition);
        let is_axial = matches!(condition.kind, InitialKind::Velocity(2, _));
        if of_solid && !(is_axial && referenced_bodies(bodies, condition).next().is_some()) {
            continue;
        }
        let InitialKind::Velocity(dof, value) = condition.kind else {
            report.add_unused_card(condition.span, "*INITIAL CONDITIONS", "rigid bodies have no temperature or stress");
            continue;
        };
        if dof != 2 {
            if starts_in_space(bodies, &condition.members) {
                let detail = format!("{} = {value}", ALONG[usize::from(dof) - 1]);
                report.ledger_row(condition.span, "initial velocity", 1, "bodies", detail);
            } else {
                radial_velocity(condition.span, value, report);
            }
            continue;
        }
        let moved: Vec<usize> = sorted_unique(referenced_bodies(bodies, condition));
        if moved.is_empty() {
            let message = "the initial velocity is given for no reference node and has no effect";
            let finding = Diagnostic::warning("P104", message).at(condition.span, "no reference node in this set");
            report.push(finding.help("give the velocity of a rigid body at its REF NODE"));
            continue;
        }
        if value != 0.0 {
            report.ledger_row(condition.span, "initial velocity", moved.len(), "bodies", format!("v_z = {value}"));
        }
        for body in moved {
            velocities[body] = value;
        }
    }
    velocities
}

/// Iterates over the bodies whose reference nodes are members of an initial condition.
fn referenced_bodies(bodies: &Bodies, condition: &InitialCondition) -> impl Iterator<Item = usize> {
    let members = condition.members.iter();
    members.filter_map(|m| bodies.of_node.get(m).copied().filter(|&body| bodies.list[body].reference == *m))
}

fn is_of_solid(places: &SolidPlaces, condition: &InitialCondition) -> bool {
    condition.kind.applies_to_elements() && condition.members.iter().any(|e| places.elements.contains_key(e))
}

fn radial_velocity(span: Span, value: f64, report: &mut Report) {
    if value == 0.0 {
        report.add_unused_card(span, "*INITIAL CONDITIONS", "a rigid body of revolution moves along z only");
    } else {
        let message = "a rigid body of revolution cannot start with a radial velocity or a rotation";
        let finding = Diagnostic::error("P103", message).at(span, "only degree of freedom 2 (z) can move");
        report.push(finding.help("use *ATTITUDE for a body with six degrees of freedom"));
    }
}

/// Reports elements that belong neither to a rigid nor to a deformable body.
fn refuse_stray_elements(scene: Scene, report: &mut Report) {
    let Scene { model, bodies, .. } = scene;
    // Elements whose section had an error are not reported again.
    let in_section: HashSet<usize> = model.material_regions().flat_map(|s| s.1).copied().collect();
    let free = |e: &usize| !bodies.of_element.contains_key(e) && !in_section.contains(e);
    let mesh = &model.mesh;
    let first = (0..mesh.elements.len()).find(|e| !mesh.elements[*e].kind.is_discrete() && free(e));
    let Some(first) = first else { return };
    let element = &mesh.elements[first];
    let (message, help) = if element.kind == ElementKind::Rax2 {
        ("RAX2 elements belong to no rigid body", "give their element set on *RIGID BODY, ELSET=")
    } else if element.kind.is_shell() {
        ("shells have no section", "give their element set on *SHELL SECTION or *RIGID BODY")
    } else if element.kind.is_cohesive() {
        ("cohesive elements have no section", "give their element set on *COHESIVE SECTION")
    } else {
        ("solid elements have no section", "give their element set on *SOLID SECTION or *RIGID BODY")
    };
    let label = format!("element {} and others", element.name);
    report.push(Diagnostic::error("P001", message).at(element.span, label).help(help));
}

/// Reports free bodies without mass. A body with prescribed axial motion in every step needs no mass.
fn check_masses(model: &Model, bodies: &Bodies, report: &mut Report) {
    for body in &bodies.list {
        let prescribes_body = |b: &crate::model::BoundaryCondition| b.dof == 2 && b.nodes.contains(&body.reference);
        let is_free = || model.steps.iter().any(|s| !s.boundaries.iter().any(prescribes_body));
        let mass = body.mass();
        if !(mass > 0.0 && mass.is_finite()) && is_free() {
            let message = format!("rigid body `{}` has no mass", body.name);
            let finding = Diagnostic::error("P002", message).at(body.span, format!("its mass is {mass}"));
            let help = "give DENSITY= and a thickness on the data line, a *SOLID SECTION for solids, or *MASS on the reference node";
            report.push(finding.help(help));
        }
    }
}
