//! Shells of the plan: element groups from sections, nodal rotations and masses.

use indexmap::IndexMap;

use crate::deck::Diagnostic;
use crate::element::group::ElementGroup;
use crate::element::shell::ShellGroup;
use crate::element::shell::section::{
    LayerProperties, SectionPlasticity, ShellProperties, ThicknessPoint, ThicknessRule,
};
use crate::kernel::laminate::PointElasticity;
use crate::kernel::lists::sorted_unique;
use crate::kernel::plane_stress::PlaneElastic;
use crate::kernel::section_stiffness::{Layer, SectionStiffness, squared_gyration};
use crate::kernel::shell::{ShellFrame, simpson};
use crate::model::{MaterialDefinition, Model, PlasticityModel, ShellLayer, ShellSection, ShellThinning};
use crate::plan::solids::solid_material::{bulk_viscosity, heating, yield_stress};
use crate::plan::{Bodies, Report, Scene, SolidPlaces};
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

/// A shell section with the elements that it gives a group.
pub struct ShellInput<'a> {
    pub scene: Scene<'a>,
    pub section: &'a ShellSection,
    pub elements: &'a [usize],
    pub nodes: &'a [Node],
}

/// Creates the element group of a section.
pub fn shell_group(input: &ShellInput<'_>, report: &mut Report) -> Option<Box<dyn ElementGroup>> {
    let ShellInput { scene: Scene { model, places, .. }, elements, nodes, .. } = *input;
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
fn note_unused_on_shells(model: &Model, layer: &ShellLayer, report: &mut Report) {
    if model.sections.iter().any(|solid| solid.material == layer.material) {
        return;
    }
    let (material, why) = (&model.materials[layer.material], "it has no effect on shells");
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
fn shell_properties(input: &ShellInput<'_>, report: &mut Report) -> Option<ShellProperties> {
    let ShellInput { scene: Scene { model, .. }, section, elements, .. } = *input;
    let mut layers = Vec::with_capacity(section.layers.len());
    for layer in &section.layers {
        layers.push(layer_properties(input, layer, report)?);
    }
    let parts = stacked(model, section)?;
    let thickness = section.thickness();
    let is_uniform = layers.len() == 1 && section.offset == 0.0;
    let stiffness = match layers[0].elasticity {
        PointElasticity::Isotropic(elastic) if is_uniform => SectionStiffness::uniform(elastic, thickness),
        _ => SectionStiffness::layered(&parts),
    };
    let rotary = stiffness.rotary_rule(thickness, squared_gyration(&parts));
    let thinning = thickness_rule(model, section, report)?;
    let thins = match thinning {
        ThicknessRule::Material => "thickness change by the material".into(),
        ThicknessRule::Ratio(ratio) => format!("thickness change with ratio {ratio}"),
    };
    let detail = format!("{}, {thins}; rotary inertia scaled", description(model, section));
    report.ledger_row(section.span, "shells", elements.len(), "SAX1", detail);
    warn_of_twist(section, &parts, report);
    let bulk_viscosity = bulk_viscosity(model, false);
    if !bulk_viscosity.is_none() {
        report.ledger_row(section.span, "bulk viscosity", elements.len(), "elements", bulk_viscosity.detail());
    }
    let per_area = mass_per_area(model, section)?;
    let points = points_of(section);
    Some(ShellProperties { layers, stiffness, rotary, thickness, per_area, points, thinning, bulk_viscosity })
}

/// Returns material, thickness and points of a section for the ledger.
fn description(model: &Model, section: &ShellSection) -> String {
    let thickness = section.thickness();
    let points: usize = section.layers.iter().map(|layer| layer.points).sum();
    let offset =
        if section.offset == 0.0 { String::new() } else { format!(", nodes at {} of the thickness", section.offset) };
    match &section.layers[..] {
        [layer] => {
            let turned = if layer.angle == 0.0 { String::new() } else { format!(" at {} degrees", layer.angle) };
            let name = &model.materials[layer.material].name;
            format!("material {name}{turned}, thickness {thickness}, {points} points{offset}")
        }
        layers => format!("{} layers, thickness {thickness}, {points} points{offset}", layers.len()),
    }
}

/// Returns elasticity and plasticity of a layer. An unsupported material is an error.
fn layer_properties(input: &ShellInput<'_>, layer: &ShellLayer, report: &mut Report) -> Option<LayerProperties> {
    let ShellInput { scene: Scene { model, .. }, section, elements, .. } = *input;
    let material = &model.materials[layer.material];
    if let Some(message) = refusal(material, model.is_adiabatic()) {
        let message = format!("material `{}`: {message}", material.name);
        let finding = Diagnostic::error("P023", message).at(section.span, "these elements are shells");
        let help = "shells support *ELASTIC with TYPE=ISOTROPIC or LAMINA, *PLASTIC with isotropic hardening, \
                    *RATE DEPENDENT";
        report.push(finding.help(help));
        return None;
    }
    note_unused_on_shells(model, layer, report);
    let (elasticity, density) = (elasticity_of(material, layer.angle)?, material.density?);
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
            report.ledger_row(section.span, "plasticity", elements.len() * layer.points, "points", detail);
            Some(SectionPlasticity { law, heating })
        }
    };
    Some(LayerProperties { elasticity, flowing, angle: layer.angle })
}

/// Returns the elasticity of a layer in the directions of the shell; `None` without *ELASTIC.
fn elasticity_of(material: &MaterialDefinition, angle: f64) -> Option<PointElasticity> {
    let lamina = material.lamina.map(|lamina| PointElasticity::Orthotropic(lamina.turned(angle)));
    lamina.or(material.elastic.map(|[young, ratio]| PointElasticity::Isotropic(PlaneElastic { young, ratio })))
}

/// Returns the layers of a section with their heights over the nodes; `None` without density or elasticity.
fn stacked(model: &Model, section: &ShellSection) -> Option<Vec<Layer>> {
    let mut bottom = -section.distances()[0];
    let layer = |layer: &ShellLayer| {
        let material = &model.materials[layer.material];
        let heights = [bottom, bottom + layer.thickness];
        bottom = heights[1];
        Some(Layer { heights, density: material.density?, elasticity: elasticity_of(material, layer.angle)? })
    };
    section.layers.iter().map(layer).collect()
}

/// Returns the integration points of a section: Simpson's rule in each layer.
fn points_of(section: &ShellSection) -> Vec<ThicknessPoint> {
    if let ([layer], 0.0) = (&section.layers[..], section.offset) {
        let point = |[place, weight]: [f64; 2]| ThicknessPoint { place, weight, layer: 0 };
        return simpson(layer.points).into_iter().map(point).collect();
    }
    let (thickness, mut bottom) = (section.thickness(), -section.distances()[0]);
    let mut points = Vec::new();
    for (layer, ShellLayer { thickness: of_layer, points: count, .. }) in section.layers.iter().enumerate() {
        points.extend(simpson(*count).into_iter().map(|[place, weight]| ThicknessPoint {
            place: (2.0 * bottom + of_layer * (1.0 + place)) / thickness,
            weight: weight * of_layer / thickness,
            layer,
        }));
        bottom += of_layer;
    }
    points
}

/// Returns the rule of the thickness change.
fn thickness_rule(model: &Model, section: &ShellSection, report: &mut Report) -> Option<ThicknessRule> {
    match (section.thinning, &section.layers[..]) {
        (ShellThinning::Material, _) => Some(ThicknessRule::Material),
        (ShellThinning::Ratio(ratio), _) => Some(ThicknessRule::Ratio(ratio)),
        (ShellThinning::Elastic, [ShellLayer { material, .. }]) if model.materials[*material].elastic.is_some() => {
            model.materials[*material].elastic.map(|[_, ratio]| ThicknessRule::Ratio(ratio))
        }
        (ShellThinning::Elastic, _) => {
            let message = "POISSON=ELASTIC requires one isotropic material";
            let finding = Diagnostic::error("P023", message).at(section.span, "this section");
            report.refuse(finding.help("give POISSON=MATERIAL or an effective Poisson's ratio"))
        }
    }
}

/// Warns of layers whose shear stresses have a resultant: without the constraint of SAX1 the shell would twist.
fn warn_of_twist(section: &ShellSection, layers: &[Layer], report: &mut Report) {
    const NEGLIGIBLE: f64 = 1e-6;
    let sum = |of: &dyn Fn(&Layer) -> f64| layers.iter().map(|l| of(l) * (l.heights[1] - l.heights[0])).sum::<f64>();
    let twist = [0, 1].map(|i| sum(&|l| l.elasticity.twist()[i]).abs());
    let stretch = sum(&|l| l.elasticity.stiffness()[0]);
    if twist.iter().all(|t| *t <= NEGLIGIBLE * stretch) {
        return;
    }
    let message = "the layers resist twist about the axis, and SAX1 elements do not twist";
    let finding = Diagnostic::warning("P129", message).at(section.span, "the angles are not balanced");
    report.push(finding.help("for each layer at an angle add one of the same thickness at the opposite angle"));
}

/// Returns the mass per area of a section; `None` without density.
fn mass_per_area(model: &Model, section: &ShellSection) -> Option<f64> {
    let mass = |layer: &ShellLayer| Some(model.materials[layer.material].density? * layer.thickness);
    Some(section.layers.iter().map(mass).sum::<Option<f64>>()? + section.per_area)
}

/// Adds the nodal masses of shell elements.
pub fn add_masses_of_shells(scene: Scene, elements: &[usize], masses: &mut IndexMap<usize, f64>) {
    let mesh = &scene.model.mesh;
    for section in &scene.model.shell_sections {
        let Some(per_area) = mass_per_area(scene.model, section) else { continue };
        let is_deformable = |e: &&usize| section.elements.contains(e) && scene.places.elements.contains_key(e);
        for &e in elements.iter().filter(is_deformable) {
            let ends = [0, 1].map(|i| mesh.elements[e].nodes[i]);
            let places = ends.map(|n| mesh.points[n]);
            let added = ShellFrame::new(places).nodal_masses(places.map(|p| p[0]), per_area);
            for (node, mass) in ends.iter().zip(added) {
                *masses.entry(scene.places.nodes[node]).or_default() += mass;
            }
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
    if material.elastic.is_none() && material.lamina.is_none() {
        return Some("it has no *ELASTIC");
    }
    if material.lamina.is_some() && material.plastic.is_some() {
        return Some("*PLASTIC together with *ELASTIC, TYPE=LAMINA is not supported");
    }
    None
}
