//! Shells of the plan: element groups from sections, nodal rotations and masses.

use indexmap::IndexMap;

use crate::deck::Diagnostic;
use crate::element::group::ElementGroup;
use crate::element::shell::ShellGroup;
use crate::element::shell::section::{SectionPlasticity, ShellProperties, ThicknessRule};
use crate::kernel::lists::sorted_unique;
use crate::kernel::plane_stress::PlaneElastic;
use crate::kernel::shell::{ShellFrame, simpson};
use crate::model::{MaterialDefinition, Model, PlasticityModel, ShellSection, ShellThinning};
use crate::plan::solids::solid_material::{bulk_viscosity, heating, yield_stress};
use crate::plan::{Bodies, GroupInput, Report, Scene, SolidPlaces};
use crate::state::nodes::Node;

/// Returns the shell sections with their elements that do not belong to a rigid body.
pub fn free_shells<'a>(model: &'a Model, bodies: &'a Bodies) -> Vec<(&'a ShellSection, Vec<usize>)> {
    let free = |e: &usize| !bodies.of_element.contains_key(e);
    let free_elements = |s: &ShellSection| s.elements.iter().copied().filter(free).collect();
    let sections = model.shell_sections.iter().map(|s| (s, free_elements(s)));
    sections.filter(|(_, elements): &(_, Vec<usize>)| !elements.is_empty()).collect()
}

/// Adds the rotations of shell nodes after all nodes, with zero angles.
pub fn place_rotations(
    model: &Model,
    places: &mut SolidPlaces,
    shells: &[(&ShellSection, Vec<usize>)],
    nodes: &mut Vec<Node>,
    report: &mut Report,
) {
    let mesh = &model.mesh;
    let ends = shells.iter().flat_map(|s| &s.1).flat_map(|&e| mesh.elements[e].nodes.iter().copied());
    let turning: Vec<usize> = sorted_unique(ends);
    places.rotations = turning.iter().enumerate().map(|(i, &n)| (n, nodes.len() + i)).collect();
    nodes.resize(nodes.len() + turning.len(), Node::default());
    if let Some((section, _)) = shells.first() {
        let detail = "rotations in the r-z plane; nodes shared with solids are hinges";
        report.ledger_row(section.span, "rotations", turning.len(), "nodes", detail.into());
    }
}

/// Creates the element group of a section.
pub fn shell_group(input: &GroupInput<'_, ShellSection, ()>, report: &mut Report) -> Option<Box<dyn ElementGroup>> {
    let GroupInput { model, places, elements, nodes, .. } = *input;
    let section_of_group = shell_properties(input, report)?;
    let corners = |&e: &usize| {
        let ends = [0, 1].map(|i| model.mesh.elements[e].nodes[i]);
        let [a, b] = ends.map(|n| places.nodes[&n] as u32);
        let [x, y] = ends.map(|n| places.rotations[&n] as u32);
        [a, b, x, y]
    };
    let list: Vec<[u32; 4]> = elements.iter().map(corners).collect();
    if let Some(index) = list.iter().position(|c| !lies_off_the_axis(c, nodes)) {
        let element = &model.mesh.elements[elements[index]];
        let message = format!("element {} is on the axis or has no length", element.name);
        return report.refuse(Diagnostic::error("P012", message).at(element.span, "this element"));
    }
    Some(Box::new(ShellGroup::new(section_of_group, list, nodes)))
}

/// Lists cards of a material without effect on shells as unused, unless solid elements have the material too.
fn note_unused_on_shells(input: &GroupInput<'_, ShellSection, ()>, report: &mut Report) {
    let GroupInput { model, section, material, .. } = *input;
    if model.sections.iter().any(|solid| solid.material == section.material) {
        return;
    }
    let why = "it has no effect on shells";
    if let Some((_, span)) = material.viscosity {
        report.add_unused_card(span, "*VISCOSITY", why);
    }
    if let Some(expansion) = &material.thermal.expansion {
        report.add_unused_card(expansion.span, "*EXPANSION", why);
    }
    if !material.detonation.is_empty() {
        report.add_unused_card(material.span, "*DETONATION POINT", why);
    }
}

/// Returns the section data of shells. An unsupported material is an error.
fn shell_properties(input: &GroupInput<'_, ShellSection, ()>, report: &mut Report) -> Option<ShellProperties> {
    let GroupInput { model, section, material, elements, .. } = *input;
    let count = elements.len();
    if let Some(message) = refusal(material, model.is_adiabatic()) {
        let message = format!("material `{}`: {message}", material.name);
        let finding = Diagnostic::error("P023", message).at(section.span, "these elements are shells");
        report.push(finding.help("shells support *ELASTIC, *PLASTIC with isotropic hardening, *RATE DEPENDENT"));
        return None;
    }
    note_unused_on_shells(input, report);
    let ([young, ratio], density) = (material.elastic?, material.density?);
    let flowing = match &material.plastic {
        None => None,
        Some(plastic) => {
            let law = yield_stress(plastic, material, section.span, report)?;
            let heats = model.is_adiabatic();
            let heating = if heats { heating(material, density) } else { crate::kernel::heating::PlasticHeating::None };
            let heat = if heating.is_none() { "" } else { ", heated by plastic work" };
            let kind =
                if matches!(plastic, PlasticityModel::Tabular(_)) { "tabular isotropic" } else { "Johnson-Cook" };
            let rate = if material.rate.is_some() { ", rate dependent" } else { "" };
            let detail = format!("{kind}{rate}{heat}, plane stress");
            report.ledger_row(section.span, "plasticity", count * section.points, "points", detail);
            Some(SectionPlasticity { law, heating })
        }
    };
    let (thinning, thins) = match section.thinning {
        ShellThinning::Material => (ThicknessRule::Material, "thickness change by the material".into()),
        ShellThinning::Elastic => (ThicknessRule::Ratio(ratio), format!("thickness change with ratio {ratio}")),
        ShellThinning::Ratio(ratio) => (ThicknessRule::Ratio(ratio), format!("thickness change with ratio {ratio}")),
    };
    let detail = format!(
        "material {}, thickness {}, {} points, {thins}; rotary inertia scaled",
        material.name, section.thickness, section.points
    );
    report.ledger_row(section.span, "shells", count, "SAX1", detail);
    let bulk_viscosity = bulk_viscosity(model, false);
    if !bulk_viscosity.is_none() {
        report.ledger_row(section.span, "bulk viscosity", count, "elements", bulk_viscosity.detail());
    }
    Some(ShellProperties {
        elastic: PlaneElastic { young, ratio },
        thickness: section.thickness,
        per_area: density * section.thickness + section.per_area,
        points: simpson(section.points),
        flowing,
        thinning,
        bulk_viscosity,
    })
}

/// Adds the nodal masses of shell elements.
pub fn add_masses_of_shells(scene: Scene, elements: &[usize], masses: &mut IndexMap<usize, f64>) {
    let mesh = &scene.model.mesh;
    for section in &scene.model.shell_sections {
        let material = &scene.model.materials[section.material];
        let (Some([young, ratio]), Some(density)) = (material.elastic, material.density) else { continue };
        let per_area = density * section.thickness + section.per_area;
        let is_deformable = |e: &&usize| section.elements.contains(e) && scene.places.elements.contains_key(e);
        for &e in elements.iter().filter(is_deformable) {
            let ends = [0, 1].map(|i| mesh.elements[e].nodes[i]);
            let places = ends.map(|n| mesh.points[n]);
            let elastic = PlaneElastic { young, ratio };
            let [a, b, ..] =
                ShellFrame::new(places).masses(places.map(|p| p[0]), per_area, section.thickness, &elastic);
            *masses.entry(scene.places.nodes[&ends[0]]).or_default() += a;
            *masses.entry(scene.places.nodes[&ends[1]]).or_default() += b;
        }
    }
}

/// Returns whether an element has a positive area: it has a length and is not on the axis.
fn lies_off_the_axis(corners: &[u32; 4], nodes: &[Node]) -> bool {
    let area = ShellFrame::new([corners[0], corners[1]].map(|n| nodes[n as usize].place())).area();
    area > 0.0 && area.is_finite()
}

/// Returns the reason why shells do not support a material; `None` if they do. `warms` states whether temperatures
/// change.
fn refusal(material: &MaterialDefinition, warms: bool) -> Option<&'static str> {
    if material.user.material.is_some() {
        return Some("a *USER MATERIAL on shells is not supported");
    }
    if material.eos.is_some() || material.hyperelastic.is_some() || material.shear_modulus.is_some() {
        return Some("shells need *ELASTIC with Young's modulus and Poisson's ratio");
    }
    if material.has_strength_law() {
        return Some("a yield surface of shells that depends on pressure, porosity or direction is not supported");
    }
    if material.foam.shape.is_some() || material.user.fields.is_some() || material.has_user_hardening() {
        return Some("*CRUSHABLE FOAM and user subroutines on shells are not supported");
    }
    if material.damping.is_some() {
        return Some("*DAMPING of shells is not supported");
    }
    if warms && material.thermal.expansion.is_some() {
        return Some("thermal strain of shells is not supported");
    }
    if material.has_failure() {
        return Some("failure of shells is not supported");
    }
    if !material.elastic_table.is_empty() || matches!(material.plastic, Some(PlasticityModel::OverFields(_))) {
        return Some("temperature-dependent moduli and tables over field variables are not supported on shells");
    }
    if matches!(material.plastic, Some(PlasticityModel::Kinematic(_))) {
        return Some("kinematic hardening of shells is not supported");
    }
    if material.density.is_none() {
        return Some("it has no *DENSITY");
    }
    if material.elastic.is_none() {
        return Some("it has no *ELASTIC");
    }
    None
}
