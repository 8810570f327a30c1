//! Springs and dashpots of the plan.

use std::collections::BTreeMap;

use crate::constraint::bonds::MergedDofs;
use crate::deck::{Diagnostic, Span};
use crate::element::connector::{CarriedEnd, Connector, Connectors, SpringDashpotLaw};
use crate::model::{BoundaryCondition, ConnectorLaw, ConnectorProperty, ElementKind};
use crate::plan::state::SolidState;
use crate::plan::{Bodies, Links, Report, Scene};

/// Creates all springs and dashpots.
pub fn connectors(scene: Scene, report: &mut Report) -> Vec<Connector> {
    let model = scene.model;
    let mut connectors = Vec::new();
    let mut with_property = Vec::new();
    for property in &model.discrete.connectors {
        let previous_count = connectors.len();
        for &e in &property.elements {
            with_property.push(e);
            connectors.extend(connector(scene, e, property, report));
        }
        let (effect, detail) = match &property.law {
            ConnectorLaw::Spring(k) => ("springs", format!("stiffness {k}")),
            ConnectorLaw::Table(rows) => ("springs", format!("table of {} rows", rows.len())),
            ConnectorLaw::Dashpot(c) => ("dashpots", format!("coefficient {c}")),
            ConnectorLaw::DashpotTable(rows) => ("dashpots", format!("table of {} rows", rows.len())),
        };
        report.ledger_row(property.span, effect, connectors.len() - previous_count, "elements", detail);
    }
    with_property.sort_unstable();
    let mesh = &model.mesh;
    let bare = |e: &usize| mesh.elements[*e].kind.is_connector() && with_property.binary_search(e).is_err();
    if let Some(e) = (0..mesh.elements.len()).find(bare) {
        let kind = mesh.elements[e].kind;
        let card = if matches!(kind, ElementKind::SpringA | ElementKind::Spring1) { "*SPRING" } else { "*DASHPOT" };
        let message = format!("{} element without {card}", kind.name());
        let help = format!("give {card}, ELSET= with a set that contains element {}", mesh.elements[e].name);
        refuse_connector(mesh.elements[e].span, message, help, report);
    }
    connectors
}

fn connector(scene: Scene, element: usize, property: &ConnectorProperty, report: &mut Report) -> Option<Connector> {
    let mesh = &scene.model.mesh;
    let element = &mesh.elements[element];
    let ends: Vec<usize> = element.nodes.iter().map(|n| scene.places.nodes[n]).collect();
    let places: Vec<[f64; 2]> = element.nodes.iter().map(|&n| mesh.points[n]).collect();
    if places.len() == 2 && places[0] == places[1] {
        let message = format!("the ends of element {} coincide", element.name);
        let help = "it acts along the line between its ends: give them different places";
        refuse_connector(element.span, message, help.into(), report);
        return None;
    }
    let law = match &property.law {
        ConnectorLaw::Spring(k) => SpringDashpotLaw::Spring(*k),
        ConnectorLaw::Table(rows) => SpringDashpotLaw::Table(rows.clone()),
        ConnectorLaw::Dashpot(c) => SpringDashpotLaw::Dashpot(*c),
        ConnectorLaw::DashpotTable(rows) => SpringDashpotLaw::DashpotTable(rows.clone()),
    };
    let axis = (ends.len() == 1).then_some(usize::from(property.dof) - 1);
    Some(Connector::new([ends.first().copied(), ends.get(1).copied()], axis, law))
}

fn refuse_connector(span: Span, message: String, help: String, report: &mut Report) {
    report.push(Diagnostic::error("P020", message).at(span, "here").help(help));
}

/// Adds the springs and dashpots to the elements of the state.
pub fn connect(scene: Scene, links: &Links, state: &mut SolidState, report: &mut Report) {
    let list = connectors(scene, report);
    let mass = &state.dofs.nodes.mass;
    let mut carried = BTreeMap::new();
    for connector in &list {
        let axes = connector.axis.map_or(vec![0, 1], |axis| vec![axis]);
        for node in connector.ends.into_iter().flatten() {
            if let Some(end) = carried_end(scene.bodies, links, node, &axes, mass) {
                carried.insert(node, end);
            } else if mass[node] == 0.0 && !axes.iter().all(|&axis| is_always_prescribed(scene, node, axis)) {
                refuse_massless_end(scene, node, report);
            }
        }
    }
    if !list.is_empty() {
        state.elements.connectors = Some(Box::new(Connectors::new(list, &state.dofs.nodes, carried)));
    }
}

/// Returns the inertia of an end whose motion is that of a rigid body, of linked nodes, or a weighted mean; `None`
/// if only its own mass resists. Mass scaling, which adds mass, is not included.
fn carried_end(bodies: &Bodies, links: &Links, node: usize, axes: &[usize], mass: &[f64]) -> Option<CarriedEnd> {
    if let Some(tie) = links.rigid_ties.iter().find(|tie| tie.nodes.contains(&node)) {
        return Some(CarriedEnd { with: tie.nodes[0], inverse_mass: inverse(bodies.list[tie.body].mass()) });
    }
    let merged = links.merged.iter().filter(|m| axes.contains(&m.axis) && m.nodes.contains(&node));
    let of_set = |set: &MergedDofs| (set.nodes[0], inverse(set.nodes.iter().map(|&n| mass[n]).sum()));
    if let Some((with, inverse_mass)) = merged.map(of_set).max_by(|a, b| a.1.total_cmp(&b.1)) {
        return Some(CarriedEnd { with, inverse_mass });
    }
    if mass[node] > 0.0 {
        return None;
    }
    let is_at_node = |dof: &(usize, usize)| dof.0 == node && axes.contains(&dof.1);
    let coefficient =
        |terms: &[((usize, usize), f64)]| terms.iter().find(|term| is_at_node(&term.0)).map(|term| term.1);
    let (terms, factor) = links.equations.iter().find_map(|e| Some((&e.terms, coefficient(&e.terms)?)))?;
    let others = terms.iter().filter(|term| term.0.0 != node);
    let inverse_mass = others.map(|&((other, _), c)| (c / factor).powi(2) * inverse(mass[other])).sum();
    Some(CarriedEnd { with: node, inverse_mass })
}

/// Returns whether the motion of a node without mass is prescribed in all steps.
fn is_always_prescribed(scene: Scene, place: usize, axis: usize) -> bool {
    let Some(node) = scene.places.nodes.iter().find(|n| *n.1 == place).map(|n| n.0) else { return false };
    let prescribes = |b: &BoundaryCondition| usize::from(b.dof) == axis + 1 && b.nodes.contains(&node);
    let on_axis = axis == 0 && scene.model.mesh.points[node][0] == 0.0;
    on_axis || scene.model.steps.iter().all(|step| step.boundaries.iter().any(prescribes))
}

fn refuse_massless_end(scene: Scene, place: usize, report: &mut Report) {
    let Some(node) = scene.places.nodes.iter().find(|n| *n.1 == place).map(|n| n.0) else { return };
    let mesh = &scene.model.mesh;
    let name = &mesh.node_names[node];
    let message = format!("a spring or dashpot is attached to node {name}, which has no mass");
    let attached = mesh.elements.iter().find(|e| e.kind.is_connector() && e.nodes.contains(&node));
    let finding = Diagnostic::error("P020", message).at(attached.map(|e| e.span).unwrap_or_default(), "here");
    let help =
        "add a *MASS, prescribe the motion of the node in every step (*BOUNDARY), or attach it to a node with mass";
    report.push(finding.help(help));
}

/// Returns one over a mass; 0 without mass.
pub fn inverse(mass: f64) -> f64 {
    if mass > 0.0 { 1.0 / mass } else { 0.0 }
}
