//! Deformable bodies of the plan: sections to groups of elements, masses, what is given and what pushes.
//! Never here: rigid bodies, arithmetic of elements.

use indexmap::IndexMap;

use super::Compiler;
use crate::deck::{Diagnostic, Span};
use crate::effect::cavity::Stack;
use crate::effect::motion::Prescribed;
use crate::effect::solid::body::{Gather, Given, NodeForce, Solid};
use crate::effect::solid::group::{Group, Quads};
use crate::effect::solid::law::{Constants, Elastic, General, Hardening, Lines};
use crate::effect::solid::loads::{Face, FaceCavity, FacePressure, FaceUser, NodeConcentrated, NodeGravity};
use crate::effect::user_load::UserLoad;
use crate::effect::{Magnitude, Shape};
use crate::kernel::hardening::{JohnsonCook, RateDependent, RateFactor, Table, YieldStress};
use crate::kernel::quad::{UNIT, corner_masses, gradient};
use crate::model::{
    self, Boundary, Hourglass, InitialKind, Load, LoadKind, Material, Plastic, RateDependence, Side, Sides,
    SolidSection, Step,
};
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
        let sections: Vec<(SolidSection, Vec<usize>)> = self
            .model
            .sections
            .iter()
            .map(|s| (s.clone(), self.free_elements(s)))
            .filter(|s| !s.1.is_empty())
            .collect();
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
    fn adiabatic(&self) -> bool {
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
            // A triangle is a quadrilateral whose last two corners coincide: the polygon formulas hold, and every motion
            // of three nodes is linear, so hourglass control has nothing to act on.
            let place = |i: usize| self.places.nodes[&element.nodes[i.min(element.nodes.len() - 1)]] as u32;
            let corners = [0, 1, 2, 3].map(place);
            let at = corners.map(|n| nodes[n as usize]);
            let volume = UNIT * gradient(at.map(|n| n.r), at.map(|n| n.z)).volume;
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
        let (Some(density), Some([e, nu])) = (material.density, material.elastic) else {
            let missing = if material.density.is_none() { "*DENSITY" } else { "*ELASTIC" };
            let message = format!("material `{}` has no {missing}", material.name);
            self.diagnostics.push(Diagnostic::error("P013", message).at(section.span, "these elements deform"));
            return None;
        };
        for corner in corners {
            let at = corner.map(|n| nodes[n as usize]);
            for (n, m) in corner.iter().zip(corner_masses(at.map(|n| n.r), at.map(|n| n.z), density)) {
                mass[*n as usize] += m;
            }
        }
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
        Some(quads(General { law, heating, temperature: 0.0 }, constants, density, corners, nodes))
    }

    /// Hourglass stiffness and viscosity of a section.
    fn hourglass(&self, section: &SolidSection, nu: f64) -> [f64; 2] {
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
        let cause = self.cause(section.span, "deformable elements", count, "CAX4R", detail);
        self.ledger.effects[cause].arrays = vec![("element state".into(), count * 16 * size_of::<f64>())];
        if let Some(plastic) = &material.plastic {
            let law = match plastic {
                Plastic::Tabular(_) => "tabular isotropic",
                Plastic::JohnsonCook(_) => "Johnson-Cook",
            };
            let rate = if material.rate.is_some() { ", rate dependent" } else { "" };
            let heat = if self.adiabatic() && heating(material, 1.0) > 0.0 { ", heated by plastic work" } else { "" };
            self.cause(section.span, "plasticity", count, "elements", format!("{law}{rate}{heat}"));
        }
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
            Some(RateDependence::YieldRatio(rows)) => Some(RateFactor::Ratio(rows.clone())),
        };
        match plastic {
            Plastic::JohnsonCook([a, b, n, m, melt, transition]) => {
                let law = JohnsonCook { a: *a, b: *b, n: *n, m: *m, melt: *melt, transition: *transition };
                Some(with_rate(law, factor))
            }
            Plastic::Tabular(rows) => {
                let bad = if rows.iter().any(|r| !r[2].is_nan()) {
                    Some("a yield stress that depends on temperature is not supported yet")
                } else if rows.windows(2).any(|w| w[1][1] <= w[0][1]) || rows[0][1] != 0.0 {
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
                        if mesh.elements[e].nodes.iter().all(|n| condition.members.contains(n)) {
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

    /// What is prescribed on deformable nodes in a step, and the axis, which holds r by itself.
    pub(super) fn given(&mut self, step: &Step) -> Vec<Given> {
        let mut given: Vec<Given> = Vec::new();
        for boundary in &step.boundaries {
            if boundary.dof > 2 {
                continue;
            }
            let nodes: Vec<usize> = boundary.nodes.iter().filter_map(|n| self.places.nodes.get(n).copied()).collect();
            if nodes.is_empty() {
                continue;
            }
            self.given_of(boundary, &nodes, &mut given);
        }
        self.axis(step, &mut given);
        given
    }

    fn given_of(&mut self, boundary: &Boundary, nodes: &[usize], given: &mut Vec<Given>) {
        if boundary.user {
            let message = "*BOUNDARY, USER on deformable nodes is not supported yet";
            self.diagnostics.push(Diagnostic::error("P015", message).at(boundary.span, "here"));
            return;
        }
        let kind = match boundary.kind {
            model::Motion::Displacement => Prescribed::Displacement,
            model::Motion::Velocity => Prescribed::Velocity,
            model::Motion::Acceleration => Prescribed::Acceleration,
        };
        // ABAQUS/Explicit ignores a displacement without amplitude: it would be a jump.
        let jump = kind == Prescribed::Displacement && boundary.amplitude.is_none();
        let value = if jump { 0.0 } else { boundary.value };
        let detail = format!("{}: {:?} {value} along {}", boundary.set, kind, ["r", "z"][boundary.dof as usize - 1]);
        let cause = self.cause(boundary.span, "prescribed motion", nodes.len(), "nodes", detail.to_lowercase());
        let magnitude = self.magnitude(value, boundary.amplitude);
        let axis = boundary.dof as usize - 1;
        for &node in nodes {
            if given.iter().any(|g| g.node == node && g.axis == axis) {
                continue;
            }
            given.push(Given { cause, node, axis, kind, magnitude: magnitude.clone() });
        }
    }

    fn axis(&mut self, step: &Step, given: &mut Vec<Given>) {
        let mesh = &self.model.mesh;
        let on_axis = |(n, _): &(&usize, &usize)| mesh.points[**n][0] == 0.0;
        let nodes: Vec<usize> = self.places.nodes.iter().filter(on_axis).map(|(_, &i)| i).collect();
        let nodes: Vec<usize> =
            nodes.into_iter().filter(|n| !given.iter().any(|g| g.node == *n && g.axis == 0)).collect();
        if nodes.is_empty() {
            return;
        }
        let cause = self.cause(step.span, "axis of symmetry", nodes.len(), "nodes", "r = 0 held".into());
        let magnitude = Magnitude { value: 0.0, shape: Shape::Constant };
        let kind = Prescribed::Velocity;
        given.extend(nodes.into_iter().map(|node| Given { cause, node, axis: 0, kind, magnitude: magnitude.clone() }));
    }

    /// The part of a load that acts on deformable bodies.
    pub(super) fn node_force(&mut self, load: &Load, solid: &Solid) -> Option<Box<dyn NodeForce>> {
        match &load.kind {
            LoadKind::Pressure(sides) => {
                let faces = self.faces(sides);
                if faces.is_empty() || load.magnitude == 0.0 {
                    return None;
                }
                let detail = format!("on {}, p = {}{}", sides.name, load.magnitude, self.amplitude_name(load));
                let cause = self.cause(load.span, "pressure", faces.len(), "faces", detail);
                let magnitude = self.magnitude(load.magnitude, load.amplitude);
                Some(Box::new(FacePressure { cause, faces, magnitude }))
            }
            LoadKind::Concentrated { nodes, dof, .. } => {
                let nodes: Vec<usize> = nodes.iter().filter_map(|n| self.places.nodes.get(n).copied()).collect();
                if nodes.is_empty() || *dof > 2 || load.magnitude == 0.0 {
                    return None;
                }
                let detail = format!("{}{}", load.magnitude, self.amplitude_name(load));
                let cause = self.cause(load.span, "concentrated force", nodes.len(), "nodes", detail);
                let magnitude = self.magnitude(load.magnitude, load.amplitude);
                Some(Box::new(NodeConcentrated { cause, nodes, axis: usize::from(*dof) - 1, magnitude }))
            }
            LoadKind::Gravity { elements, direction } => {
                self.node_gravity(load, elements.as_deref(), *direction, solid)
            }
            LoadKind::User { sides, load_type } => {
                let faces = self.faces(sides);
                if faces.is_empty() {
                    return None;
                }
                self.face_user(load, sides, *load_type, faces, solid)
            }
            LoadKind::Cavity { sides, target, friction } => {
                let faces = self.faces(sides);
                if faces.is_empty() {
                    return None;
                }
                let target = &self.model.targets[*target];
                let layers = self.layers(target)?;
                let detail = format!("{} into {}", sides.name, target.name);
                let cause = self.cause(load.span, "cavity expansion", faces.len(), "faces", detail);
                self.layer_row(target);
                let stack = Stack::new(target.front, target.direction, &layers);
                Some(Box::new(FaceCavity { cause, faces, stack, friction: *friction }))
            }
            LoadKind::UserBody { elements, .. } => {
                if elements.iter().any(|e| self.places.elements.contains_key(e)) {
                    let message = "BRNU and BZNU on deformable elements are not supported yet";
                    self.diagnostics.push(Diagnostic::error("P015", message).at(load.span, "here"));
                }
                None
            }
        }
    }

    fn node_gravity(
        &mut self,
        load: &Load,
        elements: Option<&[usize]>,
        direction: [f64; 2],
        solid: &Solid,
    ) -> Option<Box<dyn NodeForce>> {
        let axial = load.magnitude * direction[1];
        if axial == 0.0 {
            return None;
        }
        let masses: Vec<(usize, f64)> = match elements {
            None => solid.mass.iter().copied().enumerate().collect(),
            Some(list) => self.masses_of(list),
        };
        if masses.is_empty() {
            return None;
        }
        let detail = format!("a_z = {axial}{}", self.amplitude_name(load));
        let cause = self.cause(load.span, "gravity", masses.len(), "nodes", detail);
        let acceleration = self.magnitude(axial, load.amplitude);
        Some(Box::new(NodeGravity { cause, masses, acceleration }))
    }

    /// Masses that some elements put on their nodes.
    fn masses_of(&self, elements: &[usize]) -> Vec<(usize, f64)> {
        let mesh = &self.model.mesh;
        let mut masses: IndexMap<usize, f64> = IndexMap::new();
        for e in elements.iter().filter(|e| self.places.elements.contains_key(*e)) {
            let section = self.model.sections.iter().find(|s| s.elements.contains(e));
            let density = section.and_then(|s| self.model.materials[s.material].density).unwrap_or(0.0);
            let corners = [0, 1, 2, 3].map(|i| mesh.elements[*e].nodes[i]);
            let [r, z] = [0, 1].map(|axis| corners.map(|n| mesh.points[n][axis]));
            for (n, mass) in corners.iter().zip(corner_masses(r, z, density)) {
                *masses.entry(self.places.nodes[n]).or_default() += mass;
            }
        }
        masses.into_iter().collect()
    }

    fn face_user(
        &mut self,
        load: &Load,
        sides: &Sides,
        load_type: i32,
        faces: Vec<Face>,
        solid: &Solid,
    ) -> Option<Box<dyn NodeForce>> {
        let Some(routine) = self.routines.load.clone() else {
            self.no_routine(load.span, "load", &format!("`{}` asks for a user load (PNU)", sides.name), "vdload");
            return None;
        };
        let detail = format!("on {}{}", sides.name, self.amplitude_name(load));
        let cause = self.cause(load.span, "user load", faces.len(), "faces", detail);
        let magnitude = self.magnitude(load.magnitude, load.amplitude);
        let load = UserLoad { cause, name: sides.name.to_uppercase(), load_type, inward: true, magnitude, routine };
        Some(Box::new(FaceUser::new(load, faces, &solid.nodes)))
    }

    /// Sides of deformable elements as pairs of nodes.
    fn faces(&self, sides: &Sides) -> Vec<Face> {
        let mesh = &self.model.mesh;
        let face = |&(element, side): &(usize, Side)| {
            let Side::Face(number) = side else { return None };
            self.places.elements.get(&element)?;
            let nodes = &mesh.elements[element].nodes;
            let from = usize::from(number).checked_sub(1)?;
            let pair = [*nodes.get(from)?, nodes[(from + 1) % nodes.len()]];
            Some(pair.map(|n| self.places.nodes[&n]))
        };
        sides.faces.iter().filter_map(face).collect()
    }

    /// Whether a load acts on something rigid, too.
    pub(super) fn acts_on_rigid(&self, load: &Load) -> bool {
        let deforms = |e: &usize| self.places.elements.contains_key(e);
        match &load.kind {
            LoadKind::Concentrated { nodes, .. } => !nodes.iter().all(|n| self.places.has_node(*n)),
            LoadKind::Gravity { elements: None, .. } => !self.bodies.is_empty(),
            LoadKind::Gravity { elements: Some(list), .. } | LoadKind::UserBody { elements: list, .. } => {
                !list.iter().all(deforms)
            }
            LoadKind::Pressure(s) | LoadKind::User { sides: s, .. } | LoadKind::Cavity { sides: s, .. } => {
                s.faces.is_empty() || !s.faces.iter().all(|f| deforms(&f.0))
            }
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
