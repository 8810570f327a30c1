//! Deformable bodies of the plan: sections to groups of elements, masses, what is given and what pushes.
//! Never here: rigid bodies, arithmetic of elements.

use indexmap::IndexMap;

use super::Compiler;
use crate::deck::{Diagnostic, Span};
use crate::effect::solid::body::{Gather, Solid};
use crate::effect::solid::group::{Group, Quads};
use crate::effect::solid::law::{Constants, Elastic, General, Hardening, Lines};
use crate::kernel::hardening::{JohnsonCook, RateDependent, RateFactor, Table, YieldStress};
use crate::kernel::quad::{self, corner_masses};
use crate::model::{Hourglass, InitialKind, Material, Plastic, RateDependence, SolidSection};
use crate::state::nodes::Node;

/// Where deformable nodes and elements of the mesh went.
#[derive(Clone, Debug, Default)]
pub struct SolidPlaces {
    /// Node of the solver by node of the mesh.
    pub nodes: IndexMap<usize, usize>,
    /// Group and element of the group by element of the mesh.
    pub elements: IndexMap<usize, (usize, usize)>,
}

impl SolidPlaces {
    /// Whether a node of the mesh deforms with a body.
    pub fn has_node(&self, node: usize) -> bool {
        self.nodes.contains_key(&node)
    }
}

/// Default hourglass stiffness over the shear modulus (ABAQUS Analysis User's Guide, "Section controls": factor 0.005).
const HOURGLASS_STIFFNESS: f64 = 0.005;
/// Default hourglass viscosity, the fraction of what is critical at the element's highest frequency.
const HOURGLASS_VISCOSITY: f64 = 0.05;

impl Compiler<'_> {
    /// Makes the deformable part of the scene, if the deck has one.
    pub(super) fn solids(&mut self) -> Option<Solid> {
        let model = self.model;
        let sections: Vec<(&SolidSection, Vec<usize>)> =
            model.sections.iter().map(|s| (s, self.free_elements(s))).filter(|s| !s.1.is_empty()).collect();
        if sections.is_empty() {
            return None;
        }
        let mesh = &self.model.mesh;
        let mut used: Vec<usize> =
            sections.iter().flat_map(|s| &s.1).flat_map(|&e| mesh.elements[e].nodes.clone()).collect();
        used.sort_unstable();
        used.dedup();
        if let Some(node) = used.iter().find(|n| self.body_of_node.contains_key(*n)) {
            let message = format!("node {} belongs to a rigid body and to a deformable one", mesh.node_names[*node]);
            let finding = Diagnostic::error("P011", message).at(sections[0].0.span, "this section");
            self.diagnostics.push(finding.help("deformable and rigid bodies cannot be tied yet"));
            return None;
        }
        self.places.nodes = used.iter().enumerate().map(|(i, &n)| (n, i)).collect();
        let nodes: Vec<Node> =
            used.iter().map(|&n| Node { r: mesh.points[n][0], z: mesh.points[n][1], ..Node::default() }).collect();
        let mut mass = vec![0.0; nodes.len()];
        let (mut groups, mut corners, mut names): (Vec<Box<dyn Group>>, Vec<_>, Vec<_>) = Default::default();
        for (section, elements) in &sections {
            let Some(list) = self.corner_nodes(elements, &nodes) else { continue };
            let Some(group) = self.group(section, elements, &list, &nodes, &mut mass) else { continue };
            for (i, &e) in elements.iter().enumerate() {
                self.places.elements.insert(e, (groups.len(), i));
            }
            let cause = self.causes.get(&(section.span, "deformable elements")).copied().unwrap_or_default();
            self.ledger.effects[cause].arrays = vec![("element state".into(), group.bytes())];
            names.push(elements.iter().map(|&e| mesh.elements[e].name.clone()).collect());
            groups.push(group);
            corners.push(list);
        }
        self.check_steps_alike();
        self.point_masses(&mut mass);
        let lists: Vec<&[[u32; 4]]> = corners.iter().map(Vec::as_slice).collect();
        let gather = Gather::new(nodes.len(), &lists);
        let mut solid = Solid::new(nodes, mass, groups, names, gather);
        solid.cause = self.causes.get(&(sections[0].0.span, "deformable elements")).copied().unwrap_or_default();
        self.start_solid(&mut solid);
        Some(solid)
    }

    /// Whether plastic work heats: the first step says so, and all others alike.
    pub(super) fn adiabatic(&self) -> bool {
        self.model.steps.first().is_some_and(|s| s.adiabatic)
    }

    /// What elements take from the first step must not change later.
    fn check_steps_alike(&mut self) {
        let Some(first) = self.model.steps.first() else { return };
        for step in &self.model.steps {
            if step.bulk_viscosity != first.bulk_viscosity || step.adiabatic != first.adiabatic {
                let message = "bulk viscosity and ADIABATIC must be the same in all steps";
                let finding = Diagnostic::error("P015", message).at(step.span, "this step differs from the first");
                self.diagnostics.push(finding.help("change in mid-analysis is not supported yet"));
            }
        }
    }

    fn free_elements(&self, section: &SolidSection) -> Vec<usize> {
        section.elements.iter().copied().filter(|e| !self.body_of_element.contains_key(e)).collect()
    }

    /// Corner nodes of elements; an element without positive volume is an error.
    fn corner_nodes(&mut self, elements: &[usize], nodes: &[Node]) -> Option<Vec<[u32; 4]>> {
        let mesh = &self.model.mesh;
        let mut list = Vec::with_capacity(elements.len());
        for &e in elements {
            let element = &mesh.elements[e];
            let corners = mesh.corners(e).map(|n| self.places.nodes[&n] as u32);
            let volume = quad::volume(corners.map(|n| nodes[n as usize].place()));
            if volume.is_nan() || volume <= 0.0 {
                let message = format!("element {} has the volume {volume:e}", element.name);
                let finding = Diagnostic::error("P012", message).at(element.span, "this element");
                self.diagnostics
                    .push(finding.help("its nodes must run counter-clockwise in (r, z), and r must not be below 0"));
                return None;
            }
            list.push(corners);
        }
        Some(list)
    }

    fn group(
        &mut self,
        section: &SolidSection,
        elements: &[usize],
        corners: &[[u32; 4]],
        nodes: &[Node],
        mass: &mut [f64],
    ) -> Option<Box<dyn Group>> {
        let material = &self.model.materials[section.material];
        if let Some(properties) = &material.user {
            return self.user_group(section, material, properties, elements, corners, nodes, mass);
        }
        let (Some(density), Some([e, nu])) = (material.density, material.elastic) else {
            let missing = if material.density.is_none() { "*DENSITY" } else { "*ELASTIC" };
            let message = format!("material `{}` has no {missing}", material.name);
            self.diagnostics.push(Diagnostic::error("P013", message).at(section.span, "these elements deform"));
            return None;
        };
        add_masses(corners, nodes, density, mass);
        let shear = e / (2.0 * (1.0 + nu));
        let [stiffness, viscosity] = self.hourglass(section, nu);
        let bulk_viscosity = self.model.steps.first().map_or([0.06, 1.2], |s| s.bulk_viscosity);
        let constants = Constants {
            bulk: e / (3.0 * (1.0 - 2.0 * nu)),
            shear,
            hourglass_stiffness: stiffness,
            hourglass_viscosity: viscosity,
            bulk_viscosity,
        };
        self.solid_rows(section, elements.len(), &constants, material);
        let heating = if self.adiabatic() { heating(material, density) } else { 0.0 };
        let Some(plastic) = &material.plastic else {
            return Some(quads(Elastic, constants, density, corners, nodes));
        };
        let law = self.yield_stress(plastic, material.rate.as_ref(), section.span)?;
        if let (Plastic::Tabular(rows), None, 0.0) = (plastic, &material.rate, heating) {
            let rows: Vec<[f64; 2]> = rows.iter().map(|r| [r[0], r[1]]).collect();
            if let Some(lines) = Lines::new(&rows, shear) {
                return Some(quads(lines, constants, density, corners, nodes));
            }
        }
        Some(quads(General { law, heating }, constants, density, corners, nodes))
    }

    /// Hourglass stiffness and viscosity of a section.
    pub(super) fn hourglass(&self, section: &SolidSection, nu: f64) -> [f64; 2] {
        let controls = section.controls.as_ref().and_then(|name| self.model.controls.iter().find(|c| c.name == *name));
        let Some(controls) = controls else { return [HOURGLASS_STIFFNESS, 0.0] };
        let (stiffness, viscosity) = (HOURGLASS_STIFFNESS * controls.factor, HOURGLASS_VISCOSITY * controls.factor);
        match controls.hourglass {
            Hourglass::Stiffness => [stiffness, 0.0],
            Hourglass::Viscous => [0.0, viscosity],
            Hourglass::Combined(weight) => [weight * stiffness, (1.0 - weight) * viscosity],
            // Bending stiffness of an assumed strain field that does not lock (Belytschko and Bindeman 1991, Comput. Meth.
            // Appl. Mech. Eng. 88, 311): E/12 on a square element.
            Hourglass::Enhanced => [(1.0 + nu) / 12.0 * controls.factor, 0.0],
        }
    }

    fn solid_rows(&mut self, section: &SolidSection, count: usize, constants: &Constants, material: &Material) {
        let detail = format!("material {}, elastic, Jaumann rate", material.name);
        self.cause(section.span, "deformable elements", count, "CAX4R", detail);
        if let Some(plastic) = &material.plastic {
            let law = match plastic {
                Plastic::Tabular(_) => "tabular isotropic",
                Plastic::JohnsonCook(_) => "Johnson-Cook",
            };
            let rate = if material.rate.is_some() { ", rate dependent" } else { "" };
            let heat = if self.adiabatic() && heating(material, 1.0) > 0.0 { ", heated by plastic work" } else { "" };
            self.cause(section.span, "plasticity", count, "elements", format!("{law}{rate}{heat}"));
        }
        self.control_rows(section, count, constants);
    }

    /// The rows of hourglass control and bulk viscosity.
    pub(super) fn control_rows(&mut self, section: &SolidSection, count: usize, constants: &Constants) {
        let [stiffness, viscosity] = [constants.hourglass_stiffness, constants.hourglass_viscosity];
        let detail = format!("stiffness {stiffness} G, viscosity {viscosity}");
        self.cause(section.span, "hourglass control", count, "elements", detail);
        let [linear, quadratic] = constants.bulk_viscosity;
        if linear != 0.0 || quadratic != 0.0 {
            self.cause(section.span, "bulk viscosity", count, "elements", format!("{linear}, {quadratic}"));
        }
    }

    fn yield_stress(
        &mut self,
        plastic: &Plastic,
        rate: Option<&RateDependence>,
        span: Span,
    ) -> Option<Box<dyn YieldStress>> {
        let factor = match rate {
            None => None,
            Some(RateDependence::JohnsonCook([c, reference])) => {
                Some(RateFactor::JohnsonCook { c: *c, reference: *reference })
            }
            Some(RateDependence::PowerLaw(rows)) => rows.first().map(|[d, n]| RateFactor::PowerLaw { d: *d, n: *n }),
            Some(RateDependence::YieldRatio(rows)) => Some(RateFactor::Ratio(Table { rows: rows.clone() })),
        };
        match plastic {
            Plastic::JohnsonCook([a, b, n, m, melt, transition]) => {
                let law = JohnsonCook { a: *a, b: *b, n: *n, m: *m, melt: *melt, transition: *transition };
                Some(with_rate(law, factor))
            }
            Plastic::Tabular(rows) => {
                let bad = if rows.iter().any(|r| !r[2].is_nan()) {
                    Some("a yield stress that depends on temperature is not supported yet")
                } else if rows.windows(2).any(|w| w[1][1] <= w[0][1]) || rows.first().is_none_or(|r| r[1] != 0.0) {
                    Some("plastic strains must start at 0 and ascend")
                } else {
                    None
                };
                if let Some(message) = bad {
                    self.diagnostics.push(Diagnostic::error("P014", message).at(span, "the material of this section"));
                    return None;
                }
                Some(with_rate(Table { rows: rows.iter().map(|r| [r[0], r[1]]).collect() }, factor))
            }
        }
    }

    fn point_masses(&mut self, mass: &mut [f64]) {
        for point in &self.model.point_masses {
            if let Some(&n) = self.places.nodes.get(&point.node) {
                mass[n] += point.mass;
            }
        }
    }

    /// Velocities, stresses and temperatures at the start.
    fn start_solid(&mut self, solid: &mut Solid) {
        for condition in &self.model.initial_conditions {
            match &condition.kind {
                InitialKind::Velocity(dof, value) if *dof <= 2 => {
                    for n in condition.members.iter().filter_map(|n| self.places.nodes.get(n)) {
                        let node = &mut solid.nodes[*n];
                        *(if *dof == 1 { &mut node.v_r } else { &mut node.v_z }) = *value;
                    }
                }
                InitialKind::Velocity(..) => {}
                InitialKind::Temperature(value) => {
                    let mesh = &self.model.mesh;
                    for (&e, &(group, i)) in &self.places.elements {
                        if mesh.elements[e].nodes.iter().all(|n| condition.members.binary_search(n).is_ok()) {
                            solid.groups[group].set(i, None, Some(*value));
                        }
                    }
                }
                InitialKind::Stress(values) => {
                    let stress = [0, 1, 2, 3].map(|i| values.get(i).copied().unwrap_or(0.0));
                    for (group, i) in condition.members.iter().filter_map(|e| self.places.elements.get(e)) {
                        solid.groups[*group].set(*i, Some(stress), None);
                    }
                }
            }
        }
    }
}

/// Puts the masses of elements on their corners.
pub(super) fn add_masses(corners: &[[u32; 4]], nodes: &[Node], density: f64, mass: &mut [f64]) {
    for corner in corners {
        for (n, m) in corner.iter().zip(corner_masses(corner.map(|n| nodes[n as usize].place()), density)) {
            mass[*n as usize] += m;
        }
    }
}

fn with_rate<Y: YieldStress + 'static>(base: Y, factor: Option<RateFactor>) -> Box<dyn YieldStress> {
    match factor {
        Some(factor) => Box::new(RateDependent { base, factor }),
        None => Box::new(base),
    }
}

/// Rise of temperature for plastic work a volume; 0 where a card for it is missing.
fn heating(material: &Material, density: f64) -> f64 {
    match (material.inelastic_heat_fraction, material.specific_heat) {
        (Some(fraction), Some(heat)) => fraction / (density * heat),
        _ => 0.0,
    }
}

fn quads<H: Hardening + 'static>(
    law: H,
    constants: Constants,
    density: f64,
    corners: &[[u32; 4]],
    nodes: &[Node],
) -> Box<dyn Group> {
    Box::new(Quads::new(law, constants, density, corners, nodes))
}
