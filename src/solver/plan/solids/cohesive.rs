//! Cohesive elements of the plan: traction-separation laws, element groups, and bounds of the time increment.

use std::collections::{HashMap, HashSet};

use indexmap::IndexMap;

use crate::deck::Diagnostic;
use crate::element::cohesive::bounds::{InertiaShare, InterfaceBounds, InterfaceSpring};
use crate::element::cohesive::{CohesiveElement, CohesiveGroup};
use crate::element::group::ElementGroup;
use crate::kernel::cohesive::{PAIRS, areas, geometric_thickness};
use crate::kernel::traction_separation::{DamageInitiationLaw, InterfaceSoftening, TractionSeparationLaw};
use crate::model::{
    CohesiveSection, InitiationMeasure, InterfaceEvolution, InterfaceInitiation, MaterialDefinition, Mesh,
    ModeDependence, ModeMixRatio, Model, Step,
};
use crate::plan::constraints::connectors::inverse;
use crate::plan::state::SolidState;
use crate::plan::{Bodies, GroupInput, Links, Report, Scene};
use crate::variables::Variable;

/// Depth to which equations of linked nodes are followed.
const DEPTH: usize = 4;

/// Prescribed motions, and equations by their dependent degrees of freedom.
struct InertiaSearch {
    /// Mesh nodes whose motion along r and z is prescribed in all steps.
    prescribed: [HashSet<usize>; 2],
    /// Index of the equation of each dependent degree of freedom (solver node, axis).
    dependent: HashMap<(usize, usize), usize>,
}

impl InertiaSearch {
    /// Returns whether the motion of a mesh node along an axis is prescribed in all steps, or fixed on the axis.
    fn is_held(&self, node: usize, axis: usize, mesh: &Mesh) -> bool {
        self.prescribed[axis].contains(&node) || axis == 0 && mesh.points[node][0] == 0.0
    }
}

/// Returns the cohesive sections with their elements.
pub fn cohesive_sections(model: &Model) -> Vec<(&CohesiveSection, Vec<usize>)> {
    let sections = model.cohesive_sections.iter().map(|s| (s, s.elements.clone()));
    sections.filter(|(_, elements): &(_, Vec<usize>)| !elements.is_empty()).collect()
}

/// Returns the materials of cohesive elements that can be damaged.
pub fn damaged_interfaces(model: &Model) -> impl Iterator<Item = &CohesiveSection> {
    let grows = |s: &&CohesiveSection| model.materials[s.material].interface.evolution.is_some();
    model.cohesive_sections.iter().filter(grows)
}

/// Creates the element group of a section.
pub fn cohesive_group(
    input: &GroupInput<'_, CohesiveSection, ()>,
    report: &mut Report,
) -> Option<Box<dyn ElementGroup>> {
    let GroupInput { model, places, section, material, elements, nodes, .. } = *input;
    check_section(section, material, report)?;
    let (mut thicknesses, mut list): (Vec<f64>, Vec<CohesiveElement>) = Default::default();
    for &e in elements {
        let element = &model.mesh.elements[e];
        let corners = PAIRS.map(|[bottom, top]| [element.nodes[bottom], element.nodes[top]]);
        let [[a, d], [b, c]] = corners.map(|pair| pair.map(|n| places.nodes[&n] as u32));
        let nodes = [a, b, c, d].map(|n| nodes[n as usize].place());
        let thickness = section.thickness.unwrap_or_else(|| geometric_thickness(nodes));
        if thickness.is_nan() || thickness <= 0.0 {
            let message = format!("element {} has no geometric thickness: its faces coincide", element.name);
            let finding = Diagnostic::error("P026", message).at(element.span, "this element");
            let help = "give THICKNESS=SPECIFIED on *COHESIVE SECTION, with the thickness on its data line";
            return report.refuse(finding.at(section.span, "THICKNESS=GEOMETRY").help(help));
        }
        let law = thicknesses.iter().position(|t| *t == thickness).unwrap_or_else(|| {
            thicknesses.push(thickness);
            thicknesses.len() - 1
        });
        list.push(CohesiveElement { nodes: [a, b, c, d], thickness, law });
    }
    let damage = (section.controls.max_degradation, viscosity_of(section, material, report)?);
    let laws: Vec<TractionSeparationLaw> =
        thicknesses.iter().filter_map(|&thickness| law(material, thickness, damage)).collect();
    let (interface, name) = (&material.interface, format!("material `{}`", material.name));
    let origin = interface.initiation.as_ref().zip(interface.evolution.as_ref());
    let part = InterfacePart { code: "P026", name: &name, card: "*ELASTIC, TYPE=TRACTION" };
    laws.iter().try_for_each(|law| check_energies(origin, law, &part, report))?;
    cohesive_row(section, material, &thicknesses, list.len(), report);
    let deletes = material.interface.evolution.is_some() && section.controls.keep_failed_elements.is_none();
    let shown = (deletes, material.interface.initiation.as_ref().map(variable));
    Some(Box::new(CohesiveGroup::new(laws, list, material.density.unwrap_or(0.0), shown, nodes)))
}

/// Returns the viscosity of the damage, which the material or the section controls give.
fn viscosity_of(section: &CohesiveSection, material: &MaterialDefinition, report: &mut Report) -> Option<f64> {
    let (of_section, viscosity) = (section.controls.viscosity, damage_viscosity(section, material));
    if let Some((_, span)) = material.interface.viscosity
        && of_section != 0.0
        && of_section != viscosity
    {
        let message = format!("the damage of material `{}` has two viscosities", material.name);
        let finding = Diagnostic::error("P026", message).at(span, "this viscosity");
        let finding = finding.at(section.span, "VISCOSITY of the controls of this section");
        return report.refuse(finding.help("give one of the two"));
    }
    Some(viscosity)
}

/// Checks that a material has a traction-separation law and no other.
fn check_section(section: &CohesiveSection, material: &MaterialDefinition, report: &mut Report) -> Option<()> {
    let refusal = refusal(material);
    if let Some((message, help)) = refusal {
        let message = format!("material `{}` {message}", material.name);
        let finding = Diagnostic::error("P026", message).at(section.span, "these elements are cohesive");
        return report.refuse(finding.help(help));
    }
    if section.controls.by_area {
        let message = "WEIGHTING=AREA together with cohesive elements is not supported";
        return report.refuse(Diagnostic::error("P050", message).at(section.span, "this section"));
    }
    let (interface, max_degradation) = (&material.interface, section.controls.max_degradation);
    if let (Some(initiation), None) = (interface.initiation, &interface.evolution) {
        let message = format!("cohesive elements of material `{}` are never damaged", material.name);
        let finding = Diagnostic::warning("P147", message).at(initiation.span, "no *DAMAGE EVOLUTION after it");
        report.push(finding.help("add *DAMAGE EVOLUTION; without it the criterion is output only"));
    }
    let unused = [("MAX DEGRADATION", max_degradation < 1.0), ("VISCOSITY", section.controls.viscosity != 0.0)];
    for (name, _) in unused.into_iter().filter(|entry| entry.1 && interface.evolution.is_none()) {
        report.add_unused_card(section.span, name, format!("material {} has no damage evolution", material.name));
    }
    Some(())
}

/// An interface in messages.
pub struct InterfacePart<'a> {
    /// Code of the errors.
    pub code: &'static str,
    pub name: &'a str,
    /// Card of the stiffness.
    pub card: &'a str,
}

/// Reports a fracture energy that is less than the elastic energy at damage initiation: the traction would have to
/// return to smaller separations.
pub fn check_energies(
    origin: Option<(&InterfaceInitiation, &InterfaceEvolution)>,
    law: &TractionSeparationLaw,
    part: &InterfacePart<'_>,
    report: &mut Report,
) -> Option<()> {
    let Some((initiation, evolution)) = origin else { return Some(()) };
    let InterfacePart { code, name, card } = *part;
    for (mode, of) in ["normal", "shear"].into_iter().enumerate() {
        let Some([elastic, fracture]) = law.energies_of_mode(mode) else { continue };
        if fracture < elastic {
            let message = format!(
                "the fracture energy {fracture:e} of the {of} mode is less than the elastic energy {elastic:e} at \
                 damage initiation ({name})"
            );
            let finding = Diagnostic::error(code, message).at(evolution.span, "this energy");
            let help = format!(
                "increase the fracture energy or the stiffness ({card}), or decrease the strength: strength squared \
                 over twice the stiffness must be less than the fracture energy"
            );
            return report.refuse(finding.at(initiation.span, "this strength").help(help));
        }
    }
    Some(())
}

fn cohesive_row(
    section: &CohesiveSection,
    material: &MaterialDefinition,
    thicknesses: &[f64],
    count: usize,
    report: &mut Report,
) {
    let least = thicknesses.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = thicknesses.iter().copied().fold(0.0, f64::max);
    let thickness =
        if least == largest { format!("thickness {least}") } else { format!("thickness {least} to {largest}") };
    let mut parts = vec![format!("material {}", material.name), thickness];
    let interface = &material.interface;
    parts.extend((interface.coupling != 0.0).then(|| format!("coupled tractions, Ens {:e}", interface.coupling)));
    parts.extend(interface.initiation.as_ref().map(|i| format!("damage by {}", criterion(i))));
    parts.extend(interface.evolution.as_ref().map(|e| softening(&e.softening)));
    if interface.evolution.is_some() {
        let max_degradation = section.controls.max_degradation;
        let keeps_elements = section.controls.keep_failed_elements.is_some();
        parts.push(format!("{} at damage {max_degradation}", if keeps_elements { "kept" } else { "deleted" }));
        let viscosity = damage_viscosity(section, material);
        parts.extend((viscosity > 0.0).then(|| format!("viscosity {viscosity:e}")));
    }
    report.ledger_row(section.span, "cohesive elements", count, "COHAX4", parts.join(", "));
}

/// Bounds the time increment by the cohesive elements. A node without mass is an error: forces of elements act on masses.
pub fn bound_cohesive_elements(scene: Scene, links: &Links, state: &mut SolidState, report: &mut Report) {
    if scene.model.cohesive_sections.is_empty() {
        return;
    }
    let (mesh, mass) = (&scene.model.mesh, &state.dofs.nodes.mass);
    let search = inertia_search(scene.model, links);
    let (mut springs, mut bare): (Vec<InterfaceSpring>, Vec<usize>) = Default::default();
    for (e, &(group, element)) in scene.places.elements.iter() {
        let Some(cohesive) = state.elements.groups[group].as_cohesive() else { continue };
        let stiffness = cohesive.stiffness_of_points(element);
        for (stiffness, pair) in stiffness.into_iter().zip(PAIRS) {
            let ends = pair.map(|i| mesh.elements[e].nodes[i]);
            for axis in 0..2 {
                let moving = || ends.iter().filter(|n| !search.is_held(**n, axis, mesh));
                let solver_node = |n: &usize| scene.places.nodes[n];
                let shares = moving()
                    .flat_map(|n| inertia_of_dof(scene.bodies, links, (solver_node(n), axis), (&search, mass), DEPTH))
                    .collect();
                bare.extend(ends.iter().filter(|n| mass[solver_node(n)] == 0.0 && !scene.places.tied.contains_key(n)));
                springs.push(InterfaceSpring { element: (group, element), axis, stiffness, shares });
            }
        }
    }
    if let Some(&node) = bare.first() {
        return refuse_bare_node(scene.model, node, report);
    }
    if !springs.is_empty() {
        state.elements.interfaces = Some(Box::new(InterfaceBounds::new(springs, state.dofs.nodes.len())));
        state.elements.bound_interfaces(&state.dofs.nodes);
    }
}

/// Adds the nodal masses of cohesive elements.
pub fn add_masses_of_cohesive_elements(scene: Scene, elements: &[usize], masses: &mut IndexMap<usize, f64>) {
    let mesh = &scene.model.mesh;
    for section in &scene.model.cohesive_sections {
        let density = scene.model.materials[section.material].density.unwrap_or(0.0);
        let section_elements: HashSet<usize> = section.elements.iter().copied().collect();
        for &e in elements.iter().filter(|e| section_elements.contains(*e) && scene.places.elements.contains_key(e)) {
            let nodes = [0, 1, 2, 3].map(|i| mesh.elements[e].nodes[i]);
            let corners = nodes.map(|n| mesh.points[n]);
            let thickness = section.thickness.unwrap_or_else(|| geometric_thickness(corners));
            for (pair, area) in PAIRS.into_iter().zip(areas(corners)) {
                for node in pair.map(|i| nodes[i]) {
                    *masses.entry(scene.places.nodes[&node]).or_default() += 0.5 * density * thickness * area;
                }
            }
        }
    }
}

/// Collects the prescribed motions of all steps and the equations by their dependent degrees of freedom.
fn inertia_search(model: &Model, links: &Links) -> InertiaSearch {
    let of_step = |step: &Step, axis: usize| -> HashSet<usize> {
        let boundaries = step.boundaries.iter().filter(|b| usize::from(b.dof) == axis + 1);
        boundaries.flat_map(|b| b.nodes.iter().copied()).collect()
    };
    let prescribed = [0, 1].map(|axis| {
        let sets = model.steps.iter().map(|step| of_step(step, axis));
        sets.reduce(|all, next| all.intersection(&next).copied().collect()).unwrap_or_default()
    });
    let firsts = links.equations.iter().enumerate();
    let dependent = firsts.filter_map(|(i, e)| e.terms.first().map(|term| (term.0, i))).collect();
    InertiaSearch { prescribed, dependent }
}

/// Returns the degrees of freedom whose inertia resists a node along an axis: the node, the rigid body or the set of
/// linked nodes to which it belongs, or the other terms of the equation that it depends on.
fn inertia_of_dof(
    bodies: &Bodies,
    links: &Links,
    (node, axis): (usize, usize),
    (search, mass): (&InertiaSearch, &[f64]),
    depth: usize,
) -> Vec<InertiaShare> {
    if let Some(tie) = links.rigid_ties.iter().find(|tie| tie.nodes.binary_search(&node).is_ok()) {
        let inverse_mass = Some(inverse(bodies.list[tie.body].mass()));
        return vec![InertiaShare { node: tie.nodes[0], weight: 1.0, inverse_mass }];
    }
    if let Some(set) = links.merged_with(node, axis) {
        let inverse_mass = Some(inverse(set.nodes.iter().map(|&n| mass[n]).sum()));
        return vec![InertiaShare { node: set.nodes[0], weight: 1.0, inverse_mass }];
    }
    let Some(&equation) = search.dependent.get(&(node, axis)).filter(|_| depth > 0) else {
        return vec![InertiaShare { node, weight: 1.0, inverse_mass: None }];
    };
    let terms = &links.equations[equation].terms;
    let others = terms[1..].iter().flat_map(|&((other, along), c)| {
        let weight = -c / terms[0].1;
        let shares = inertia_of_dof(bodies, links, (other, along), (search, mass), depth - 1).into_iter();
        shares.map(move |share| InertiaShare { weight: weight * share.weight, ..share })
    });
    others.collect()
}

fn refuse_bare_node(model: &Model, node: usize, report: &mut Report) {
    let mesh = &model.mesh;
    let message = format!("node {} of a cohesive element has no mass", mesh.node_names[node]);
    let at = mesh.elements.iter().find(|e| e.kind.is_cohesive() && e.nodes.contains(&node));
    let finding = Diagnostic::error("P026", message).at(at.map(|e| e.span).unwrap_or_default(), "this element");
    let help = "give the material of the cohesive elements a *DENSITY, or share the node with a solid element";
    report.push(finding.help(help));
}

/// Returns the viscosity of the damage: that of the material, or else that of the section controls.
fn damage_viscosity(section: &CohesiveSection, material: &MaterialDefinition) -> f64 {
    material.interface.viscosity.map_or(section.controls.viscosity, |(viscosity, _)| viscosity)
}

/// Returns the law of a material for a constitutive thickness and a largest damage; `None` without elasticity.
fn law(material: &MaterialDefinition, thickness: f64, (most, viscosity): (f64, f64)) -> Option<TractionSeparationLaw> {
    let interface = &material.interface;
    let stiffness = interface.elastic?.map(|modulus| modulus / thickness);
    let initiation = interface.initiation.map(|initiation| initiation_law(&initiation, stiffness, thickness));
    let softening = interface.evolution.as_ref().map(|evolution| evolution.softening.clone());
    let coupling = interface.coupling / thickness;
    Some(TractionSeparationLaw { stiffness, coupling, initiation, softening, largest_damage: most, viscosity })
}

/// Returns the criterion of damage initiation in separations, for a stiffness and a constitutive thickness.
pub fn initiation_law(initiation: &InterfaceInitiation, stiffness: [f64; 2], thickness: f64) -> DamageInitiationLaw {
    let separation = |i: usize| match initiation.measure {
        InitiationMeasure::Stress => initiation.limits[i] / stiffness[i],
        InitiationMeasure::Strain => initiation.limits[i] * thickness,
        InitiationMeasure::Separation => initiation.limits[i],
    };
    let in_tractions = initiation.measure == InitiationMeasure::Stress;
    DamageInitiationLaw { quadratic: initiation.quadratic, in_tractions, limits: [0, 1].map(separation) }
}

/// Returns what cohesive elements do not support of a material, or what it lacks, and a help text.
fn refusal(material: &MaterialDefinition) -> Option<(&'static str, &'static str)> {
    let other = material.elastic.is_some()
        || material.shear_modulus.is_some()
        || material.plastic.is_some()
        || material.eos.is_some()
        || material.hyperelastic.is_some()
        || material.foam.shape.is_some()
        || material.has_strength_law()
        || material.user.material.is_some();
    if other {
        return Some((
            "has a law of solids, which cohesive elements with RESPONSE=TRACTION SEPARATION do not support",
            "define a material with *ELASTIC, TYPE=TRACTION for the cohesive elements",
        ));
    }
    if material.interface.elastic.is_none() {
        return Some((
            "has no *ELASTIC, TYPE=TRACTION",
            "give the stiffness: normal and shear traction over the nominal strain",
        ));
    }
    if material.has_failure() {
        return Some((
            "has a failure criterion of solids",
            "cohesive elements support *DAMAGE INITIATION with CRITERION=MAXS, QUADS, MAXE or QUADE",
        ));
    }
    if material.damping.is_some() {
        return Some(("has *DAMPING, which cohesive elements do not support", "remove it"));
    }
    None
}

/// Returns the output variable of a criterion of cohesive elements.
fn variable(initiation: &InterfaceInitiation) -> Variable {
    match (initiation.measure == InitiationMeasure::Stress, initiation.quadratic) {
        (true, false) => Variable::LargestStressInitiation,
        (true, true) => Variable::QuadraticStressInitiation,
        (false, false) => Variable::LargestStrainInitiation,
        (false, true) => Variable::QuadraticStrainInitiation,
    }
}

/// Returns the value of `CRITERION`.
pub fn criterion(initiation: &InterfaceInitiation) -> &'static str {
    let [largest, quadratic] = match initiation.measure {
        InitiationMeasure::Stress => ["MAXS", "QUADS"],
        InitiationMeasure::Strain => ["MAXE", "QUADE"],
        InitiationMeasure::Separation => ["MAXU", "QUADU"],
    };
    if initiation.quadratic { quadratic } else { largest }
}

/// Describes a softening for the ledger.
pub fn softening(softening: &InterfaceSoftening) -> String {
    match softening {
        InterfaceSoftening::Displacement(mode) => format!("linear softening to displacement {}", dependence(mode)),
        InterfaceSoftening::ExponentialDisplacement(mode, _) => {
            format!("exponential softening to displacement {}", dependence(mode))
        }
        InterfaceSoftening::Energy(mode) => format!("linear softening with energy {}", dependence(mode)),
        InterfaceSoftening::ExponentialEnergy(mode) => {
            format!("exponential softening with energy {}", dependence(mode))
        }
        InterfaceSoftening::Tabular(rows) => format!("softening by a table of {} rows", rows.len()),
    }
}

fn dependence(mode: &ModeDependence) -> String {
    match mode {
        ModeDependence::Independent(value) => format!("{value}"),
        ModeDependence::Table(ModeMixRatio::Energy, _) => "by a table over the mode mix of energies".into(),
        ModeDependence::Table(ModeMixRatio::Traction, _) => "by a table over the mode mix of tractions".into(),
        ModeDependence::PowerLaw([a, b], power) => format!("{a} and {b}, power law {power}"),
        ModeDependence::BenzeggaghKenane([a, b], power) => format!("{a} and {b}, BK {power}"),
    }
}
