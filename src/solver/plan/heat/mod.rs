//! Heat conduction, thermal boundary conditions and loads, and thermal expansion of the plan.

pub mod fields;
pub mod ties;

use std::collections::{BTreeSet, HashSet};

use crate::deck::Diagnostic;
use crate::element::group::ElementGroup;
use crate::heat::ThermalState;
use crate::heat::conductors::{ConductingElement, ConductingElements, ConductionProperties, ConductorGroup};
use crate::heat::expansion::{GroupExpansion, ThermalStrains};
use crate::heat::field::{TemperatureField, ThermalConditions, ThermalSteps};
use crate::heat::sources::{HeatSource, HeatSourceKind, PrescribedTemperature, TemperatureNode};
use crate::kernel::hardening::LinearTable;
use crate::kernel::quad::corner_masses;
use crate::mesh::hidden::InteriorFaces;
use crate::model::{BoundaryCondition, Load, LoadKind, MaterialDefinition, Model, SolidSection, Step};
use crate::plan::heat::fields::has_prescribed_temperature;
use crate::plan::heat::ties::tie_temperatures;
use crate::plan::loads::{amplitude_name, has_effect, kind_name, magnitude};
use crate::plan::meshes::surfaces::load_surface;
use crate::plan::queries::heated_references;
use crate::plan::solids::solid_material::heating;
use crate::plan::state::SolidState;
use crate::plan::{Links, Report, Scene};
use crate::state::magnitude::Magnitude;
use crate::state::nodes::Nodes;
use crate::variables::Variable;

/// A section with the index of an element group.
type SectionGroup<'m> = (&'m SolidSection, usize);

/// The elements and nodes that conduct heat.
#[derive(Clone, Copy)]
pub struct HeatInput<'a> {
    pub scene: Scene<'a>,
    pub conductors: &'a ConductingElements,
    /// Solver nodes with temperatures.
    pub conducting: &'a HashSet<usize>,
}

/// Creates the thermal part of the state; `None` if temperatures have no effect.
pub fn plan(scene: Scene, links: &Links, state: &SolidState, report: &mut Report) -> Option<Box<ThermalState>> {
    let model = scene.model;
    let coupled = model.solves_for_temperatures();
    if !coupled {
        note_unused_thermal_input(scene.model, report);
    }
    let groups = |s: &SolidSection| {
        let of_elements = s.elements.iter().filter_map(|e| scene.places.elements.get(e)).map(|place| place.0);
        of_elements.collect::<BTreeSet<usize>>()
    };
    let with_groups = |s| groups(s).into_iter().map(move |group| (s, group));
    let sections: Vec<SectionGroup> = model.sections.iter().flat_map(with_groups).collect();
    let heat = if coupled { temperature_field(scene, links, &sections, state, report) } else { None };
    let start = initial_temperatures(scene, state);
    let mut expanding = Vec::new();
    for &(section, group) in &sections {
        let material = &model.materials[section.material];
        if let Some(expansion) = group_expansion(scene.model, section, group, material, state, report) {
            let elements = &state.elements.groups[group];
            let is_prescribed = has_prescribed_temperature(model, &section.elements);
            let strain_temperature = |e: usize| {
                let element_temperature = elements.value(e, Variable::Temperature.into());
                element_temperature
                    .filter(|_| heat.is_none() && !is_prescribed)
                    .unwrap_or_else(|| mean(&**elements, e, &start, &state.dofs.nodes))
            };
            expanding.push((expansion, (0..elements.len()).map(strain_temperature).collect()));
        }
    }
    let expansion = (!expanding.is_empty()).then(|| ThermalStrains::new(expanding));
    if heat.is_none() && expansion.is_none() {
        note_unused_initial_temperatures(scene, state, report);
    }
    (heat.is_some() || expansion.is_some()).then(|| Box::new(ThermalState { heat, expansion }))
}

/// Lists initial temperatures as unused if no material depends on the temperature.
fn note_unused_initial_temperatures(scene: Scene, state: &SolidState, report: &mut Report) {
    let model = scene.model;
    let material = |section: &SolidSection| &model.materials[section.material];
    let may_read = |m: &MaterialDefinition| m.eos.is_some() || m.user.material.is_some();
    let groups = &state.elements.groups;
    let holds = |&(group, e): &(usize, usize)| groups[group].value(e, Variable::Temperature.into()).is_some();
    let reads = model.sections.iter().map(material).any(may_read) || scene.places.elements.values().any(holds);
    if reads || report.routines.any() {
        return;
    }
    for condition in &model.initial_conditions {
        if condition.kind.temperature().is_some() {
            let what = "*INITIAL CONDITIONS, TYPE=TEMPERATURE";
            report.add_unused_card(condition.span, what, "no material depends on the temperature");
        }
    }
}

/// Lists thermal input as unused if no step solves for temperatures.
fn note_unused_thermal_input(model: &Model, report: &mut Report) {
    for material in &model.materials {
        if let Some((_, span)) = &material.thermal.conductivity {
            let why = "no step solves for temperatures (*DYNAMIC TEMPERATURE-DISPLACEMENT)";
            report.add_unused_card(*span, "*CONDUCTIVITY", why);
        }
        let heats = material.thermal.inelastic_heat_fraction.is_some() && material.user.material.is_none();
        if heats && !model.is_adiabatic() && material.eos.is_none() {
            let why = "no step is ADIABATIC or solves for temperatures";
            report.add_unused_card(material.span, format!("*INELASTIC HEAT FRACTION of {}", material.name), why);
        }
    }
    let why = "no step solves for temperatures (*DYNAMIC TEMPERATURE-DISPLACEMENT)";
    for (keyword, span) in model.interactions.iter().flat_map(|i| &i.heat_cards) {
        report.add_unused_card(*span, format!("*{keyword}"), why);
    }
    for step in &model.steps {
        for boundary in step.boundaries.iter().filter(|b| b.is_thermal()) {
            report.add_unused_card(boundary.span, format!("*BOUNDARY {}, 11", boundary.set), why);
        }
        for load in step.loads.iter().filter(|l| l.kind.is_thermal()) {
            report.add_unused_card(load.span, kind_name(&load.kind), why);
        }
    }
    if let Some(equation) = model.constraints.equations.iter().find(|e| e.is_thermal()) {
        report.add_unused_card(equation.span, "*EQUATION between temperatures", why);
    }
}

fn temperature_field(
    scene: Scene,
    links: &Links,
    sections: &[SectionGroup],
    state: &SolidState,
    report: &mut Report,
) -> Option<TemperatureField> {
    let model = scene.model;
    let step = model.steps.first()?;
    let (mut parts, mut list, mut id) = (Vec::new(), Vec::new(), None);
    for &(section, group) in sections {
        if !model.conducts_heat(section) {
            continue;
        }
        let material = &model.materials[section.material];
        let properties = conduction_properties(scene.model, section, material, report)?;
        let density = material.density.unwrap_or(0.0);
        let elements = &state.elements.groups[group];
        let first = list.len();
        list.extend((0..elements.len()).flat_map(|e| elements.cells(e)).map(|nodes| {
            let places = nodes.map(|n| state.dofs.nodes[n as usize].place());
            ConductingElement { nodes, masses: corner_masses(places, density) }
        }));
        let rows = |table: &LinearTable| match table.rows.as_slice() {
            [[value, _]] => format!("{value}"),
            rows => format!("{} rows", rows.len()),
        };
        let holds = model.steps.iter().any(|step| !step.current_conduction);
        let held = if holds { ", rates held over 5e-4 of the stable increment" } else { "" };
        let detail = format!(
            "material {}, conductivity {}, specific heat {}, lumped capacity, forward differences{held}",
            material.name,
            rows(&properties.conductivity),
            rows(&properties.capacity)
        );
        let row = report.ledger_row(section.span, "heat conduction", elements.len(), "elements", detail);
        id = id.or(Some(row));
        if !heating(material, 1.0).is_none() && (material.plastic.is_some() || material.user.material.is_some()) {
            let detail = "plastic work of elements heats their nodes at the end of each increment";
            report.ledger_row(section.span, "plastic heat", elements.len(), "elements", detail.into());
        }
        parts.push(ConductorGroup { group, first, end: list.len(), properties });
    }
    let Some(id) = id else {
        // A section that could not be planned has been reported.
        if report.diagnostics.has_errors() && model.sections.iter().any(|section| model.conducts_heat(section)) {
            return None;
        }
        let message = "the step solves for temperatures, but no element has temperatures";
        let finding = Diagnostic::error("P065", message).at(step.span, "this step");
        return report.refuse(finding.help("use CAX4RT or CAX3T elements, or *DYNAMIC, EXPLICIT"));
    };
    let conductors = ConductingElements::new(parts, list, state.dofs.nodes.len());
    let mut conducting: HashSet<usize> = conductors.list.iter().flat_map(|c| c.nodes).map(|n| n as usize).collect();
    let references = heated_references(scene.model).into_iter().filter_map(|n| scene.places.nodes.get(&n).copied());
    let sinks: Vec<usize> = references.filter(|n| !conducting.contains(n)).collect();
    conducting.extend(&sinks);
    let start = initial_temperatures(scene, state);
    let mut steps = Vec::with_capacity(model.steps.len());
    let input = HeatInput { scene, conductors: &conductors, conducting: &conducting };
    for (index, step) in model.steps.iter().enumerate() {
        let continues = index > 0 && has_same_heat(&model.steps[index - 1], step);
        steps.push((!continues).then(|| {
            let mut conditions = thermal_conditions(input, step, report);
            hold_sinks(step, &sinks, &start, &mut conditions, report);
            conditions
        }));
    }
    tie_temperatures(input, links, &mut steps, &start, report);
    let meets = model.steps.iter().any(Step::has_contact);
    let holds_conduction = model.steps.iter().map(|step| !step.current_conduction).collect();
    let steps = ThermalSteps { conditions: steps, holds_conduction };
    Some(TemperatureField::new(id, conductors, steps, start, sinks, meets))
}

/// Holds the temperatures of rigid bodies that the step does not prescribe: they have no heat capacity.
fn hold_sinks(step: &Step, sinks: &[usize], start: &[f64], conditions: &mut ThermalConditions, report: &mut Report) {
    let prescribed: HashSet<usize> = conditions.held.iter().flat_map(|h| &h.nodes).map(|n| n.node).collect();
    for &node in sinks.iter().filter(|node| !prescribed.contains(node)) {
        let detail = format!("initial temperature {}: rigid bodies have no heat capacity", start[node]);
        let id = report.ledger_row(step.span, "constant temperature", 1, "rigid body", detail);
        let magnitude = Magnitude::constant(start[node]);
        conditions.held.push(PrescribedTemperature { id, magnitude, nodes: vec![TemperatureNode::new(node)] });
    }
}

/// Returns conductivity and specific heat of the material of a section; missing properties are errors.
fn conduction_properties(
    model: &Model,
    section: &SolidSection,
    material: &MaterialDefinition,
    report: &mut Report,
) -> Option<ConductionProperties> {
    let mixed = section.elements.iter().find(|e| !model.mesh.elements[**e].kind.is_thermal());
    let missing = match (&material.thermal.conductivity, &material.thermal.specific_heat) {
        _ if mixed.is_some() => "has elements with and without nodal temperatures",
        _ if material.is_ideal_gas() => "has an ideal gas, for which heat conduction is unsupported",
        (None, _) => "solves for temperatures, but its material has no *CONDUCTIVITY",
        (_, None) => "solves for temperatures, but its material has no *SPECIFIC HEAT",
        (Some((conductivity, _)), Some(capacity)) => {
            let table = |rows: &[[f64; 2]]| LinearTable { rows: rows.to_vec() };
            return Some(ConductionProperties { conductivity: table(conductivity), capacity: table(capacity) });
        }
    };
    let message = format!("this section (material `{}`) {missing}", material.name);
    report.refuse(Diagnostic::error("P066", message).at(section.span, "this section"))
}

/// Returns the initial nodal temperatures, 0 by default.
pub fn initial_temperatures(scene: Scene, state: &SolidState) -> Vec<f64> {
    let mut temperatures = vec![0.0; state.dofs.nodes.len()];
    for condition in &scene.model.initial_conditions {
        if let Some(value) = condition.kind.temperature() {
            for place in condition.members.iter().filter_map(|n| scene.places.nodes.get(n)) {
                temperatures[*place] = value;
            }
        }
    }
    temperatures
}

fn thermal_conditions(input: HeatInput, step: &Step, report: &mut Report) -> ThermalConditions {
    let HeatInput { scene, conducting, .. } = input;
    let mut conditions = ThermalConditions::default();
    let mut taken = HashSet::new();
    for boundary in step.boundaries.iter().filter(|b| b.is_thermal()) {
        let places = boundary.nodes.iter().filter_map(|n| scene.places.nodes.get(n).copied());
        let nodes: Vec<usize> = places.filter(|n| conducting.contains(n) && taken.insert(*n)).collect();
        if nodes.is_empty() {
            let message = format!("the temperature of `{}` has no effect: its nodes have no temperature", boundary.set);
            let finding = Diagnostic::warning("P067", message).at(boundary.span, "here");
            report.push(finding.help("rigid bodies and elements other than CAX4RT and CAX3T have none"));
            continue;
        }
        let detail = format!("{}: {}", boundary.set, boundary.value);
        let id = report.ledger_row(boundary.span, "prescribed temperature", nodes.len(), "nodes", detail);
        let magnitude = magnitude(scene, boundary.value, boundary.amplitude, report);
        let nodes = nodes.into_iter().map(TemperatureNode::new).collect();
        conditions.held.push(PrescribedTemperature { id, magnitude, nodes });
    }
    let loads: Vec<&Load> = step.loads.iter().filter(|l| l.kind.is_thermal()).collect();
    for load in loads {
        conditions.sources.extend(heat_source(input, load, report));
    }
    conditions
}

fn heat_source(input: HeatInput, load: &Load, report: &mut Report) -> Option<HeatSource> {
    let HeatInput { scene, conductors, conducting } = input;
    if !has_effect(load, report) {
        return None;
    }
    let (kind, effect, count, unit, set) = match &load.kind {
        LoadKind::NodalHeat { nodes, set } => {
            let places = nodes.iter().filter_map(|n| scene.places.nodes.get(n).copied());
            let list: Vec<usize> = places.filter(|n| conducting.contains(n)).collect();
            let count = if list.len() == nodes.len() { list.len() } else { 0 };
            (HeatSourceKind::Nodes(list), "heat into nodes", count, "nodes", set)
        }
        LoadKind::BodyHeat { elements, set } => {
            let index = |e: &usize| {
                let (group, i) = *scene.places.elements.get(e)?;
                Some(conductors.parts.iter().find(|p| p.group == group)?.first + i)
            };
            let list: Vec<usize> = elements.iter().filter_map(index).collect();
            let count = list.len();
            (HeatSourceKind::Volumes(list), "heat into volumes", count, "elements", set)
        }
        LoadKind::SurfaceHeat(sides) => {
            let surface = load_surface(scene, sides, load.span, report);
            let count = surface.skin.faces.len();
            (HeatSourceKind::Faces(surface.skin), "heat flux", count, "faces", &sides.name)
        }
        LoadKind::Film { sides, coefficient, amplitude } => {
            let skin = load_surface(scene, sides, load.span, report).skin;
            let count = skin.faces.len();
            let coefficient = magnitude(scene, *coefficient, *amplitude, report);
            (HeatSourceKind::Film(skin, coefficient), "film", count, "faces", &sides.name)
        }
        _ => return None,
    };
    if count == 0 || !all_conduct(&kind, conducting) {
        let message = format!("`{set}` contains nodes or elements without temperatures");
        let finding = Diagnostic::error("P063", message).at(load.span, "this heat source");
        return report.refuse(finding.help("only CAX4RT and CAX3T elements have nodal temperatures"));
    }
    let film = match &load.kind {
        LoadKind::Film { coefficient, .. } => format!("h = {coefficient}, T = "),
        _ => "q = ".into(),
    };
    let detail = format!("on {set}, {film}{}{}", load.magnitude, amplitude_name(scene.model, load));
    let id = report.ledger_row(load.span, effect, count, unit, detail);
    let magnitude = magnitude(scene, load.magnitude, load.amplitude, report);
    Some(HeatSource { id, kind, magnitude })
}

fn all_conduct(kind: &HeatSourceKind, conducting: &HashSet<usize>) -> bool {
    match kind {
        HeatSourceKind::Faces(skin) | HeatSourceKind::Film(skin, _) => skin
            .faces
            .iter()
            .chain(skin.hidden().map_or(&[][..], InteriorFaces::faces))
            .flatten()
            .all(|n| conducting.contains(n)),
        HeatSourceKind::Nodes(_) | HeatSourceKind::Volumes(_) => true,
    }
}

/// Returns the thermal expansion of a section; `None` if its temperatures do not change or the material has no
/// thermal strain.
fn group_expansion(
    model: &Model,
    section: &SolidSection,
    group: usize,
    material: &MaterialDefinition,
    state: &SolidState,
    report: &mut Report,
) -> Option<GroupExpansion> {
    let expansion = material.thermal.expansion.as_ref()?;
    let (conducts, elements) = (model.conducts_heat(section), &state.elements.groups[group]);
    let warms = (model.is_adiabatic() && !heating(material, 1.0).is_none() && material.plastic.is_some())
        || (material.eos.is_none() && has_prescribed_temperature(model, &section.elements));
    let idle = |coefficient: f64| coefficient == 0.0;
    let why = if elements.is_empty() || expansion.rows.iter().all(|r| idle(r[0])) {
        Some("its coefficient is zero")
    } else if !conducts && !warms {
        Some("temperatures do not change")
    } else if material.eos.is_some() {
        Some("the equation of state determines the thermal expansion")
    } else {
        None
    };
    if let Some(why) = why {
        let is_warmed = |other: &SolidSection| {
            other.material == section.material && has_prescribed_temperature(model, &other.elements)
        };
        if !model.sections.iter().any(is_warmed) {
            report.add_unused_card(expansion.span, "*EXPANSION", why);
        }
        return None;
    }
    if material.hyperelastic.is_some() || material.user.energy.is_some() {
        let finding = Diagnostic::error("P064", "*EXPANSION with hyperelasticity is not supported");
        return report.refuse(finding.at(expansion.span, "here").help("remove one of the two cards"));
    }
    let detail = match expansion.rows.as_slice() {
        [[value, _]] => format!("coefficient {value} from {}", expansion.zero),
        rows => format!("{} rows from {}", rows.len(), expansion.zero),
    };
    let id = report.ledger_row(section.span, "thermal expansion", elements.len(), "elements", detail);
    let coefficient = LinearTable { rows: expansion.rows.clone() };
    Some(GroupExpansion { id, group, coefficient, reference: expansion.zero })
}

/// Returns the volume average of the nodal temperatures of an element.
fn mean(group: &dyn ElementGroup, element: usize, nodal: &[f64], nodes: &Nodes) -> f64 {
    let conductor = |cell: [u32; 4]| {
        let masses = corner_masses(cell.map(|n| nodes[n as usize].place()), 1.0);
        ConductingElement { nodes: cell, masses }
    };
    let cells = || group.cells(element).map(conductor);
    let volume: f64 = cells().map(|c| c.mass()).sum();
    cells().map(|c| c.mean(nodal) * (c.mass() / volume)).sum()
}

/// Returns whether two steps have the same heat loads and prescribed temperatures.
fn has_same_heat(a: &Step, b: &Step) -> bool {
    let is_temperature = |b: &&BoundaryCondition| b.is_thermal();
    let gives = |l: &&Load| l.kind.is_thermal();
    a.boundaries.iter().filter(is_temperature).eq(b.boundaries.iter().filter(is_temperature))
        && a.loads.iter().filter(gives).eq(b.loads.iter().filter(gives))
}
