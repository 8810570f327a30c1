//! Loads and prescribed motions of a step as effects.
//! Never here: what they do in an increment.

use std::collections::BTreeMap;

use super::Compiler;
use crate::constraint::motion::{Motion, Prescribed};
use crate::deck::{Diagnostic, Span};
use crate::kernel::amplitude::Curve;
use crate::kernel::cavity::Resistance;
use crate::kernel::facet::Facet;
use crate::load::Asking;
use crate::load::Force;
use crate::load::cavity::{CavityExpansion, Stack};
use crate::load::concentrated::Concentrated;
use crate::load::gravity::Gravity;
use crate::load::pressure::Pressure;
use crate::model::{self, AmplitudeDefinition, Boundary, IncrementControl, Load, LoadKind, Side, Sides, Step};
use crate::state::magnitude::Magnitude;
use crate::state::magnitude::Shape;

/// Facets with their element index, by body.
pub(super) type FacetsByBody = BTreeMap<usize, Vec<(usize, Facet)>>;

impl Compiler<'_> {
    /// Whether a load can do anything; one that cannot is noted as unused.
    pub(super) fn matters(&mut self, load: &Load) -> bool {
        let constant =
            !matches!(load.kind, LoadKind::User { .. } | LoadKind::UserBody { .. } | LoadKind::Cavity { .. });
        let zero = constant && load.magnitude == 0.0;
        if zero {
            self.unused(load.span, kind_name(&load.kind), "its magnitude is zero");
        }
        !zero
    }

    /// The effects of one load on rigid bodies, one for each body it acts on.
    pub(super) fn load(&mut self, load: &Load, step: &Step) -> Vec<Box<dyn Force>> {
        match &load.kind {
            LoadKind::Concentrated { nodes, dof, set } => self.concentrated(load, nodes, *dof, set),
            LoadKind::Gravity { elements, direction } => self.gravity(load, elements.as_deref(), *direction),
            LoadKind::Pressure(sides) => self.pressure(load, sides),
            LoadKind::User { sides, load_type } => self.user_load(load, sides, *load_type),
            LoadKind::UserBody { elements, set, load_type } => self.user_body(load, elements, set, *load_type),
            LoadKind::Cavity { sides, target, friction } => self.cavity(load, sides, *target, *friction, step),
        }
    }

    pub(super) fn magnitude(&mut self, value: f64, amplitude: Option<usize>) -> Magnitude {
        let Some(index) = amplitude else { return Magnitude { value, shape: Shape::Constant } };
        let shape = match &self.model.amplitudes[index].definition {
            AmplitudeDefinition::Curve { points, smooth, total_time } => {
                Shape::Curve(Curve::new(points.clone(), *smooth, *total_time))
            }
            AmplitudeDefinition::User { .. } => Shape::Track(self.user_amplitude(index)),
        };
        Magnitude { value, shape }
    }

    fn concentrated(&mut self, load: &Load, nodes: &[usize], dof: u8, set: &str) -> Vec<Box<dyn Force>> {
        if dof != 2 {
            self.unused(load.span, "*CLOAD", "a rigid body of revolution moves along z only");
            return Vec::new();
        }
        let nodes: Vec<usize> = nodes.iter().copied().filter(|n| !self.places.has_node(*n)).collect();
        let bodies: Vec<usize> = nodes.iter().filter_map(|n| self.body_of_node.get(n).copied()).collect();
        if bodies.len() < nodes.len() {
            let message = format!("a force acts on nodes of `{set}` that belong to no rigid body");
            self.diagnostics.push(Diagnostic::error("P003", message).at(load.span, "here"));
        }
        let detail = format!("F_z = {}{}", load.magnitude, self.amplitude_name(load));
        let cause = self.cause(load.span, "concentrated force", bodies.len(), "nodes", detail);
        let magnitude = self.magnitude(load.magnitude, load.amplitude);
        vec![Box::new(Concentrated { cause, bodies, magnitude })]
    }

    fn gravity(&mut self, load: &Load, elements: Option<&[usize]>, direction: [f64; 2]) -> Vec<Box<dyn Force>> {
        let axial = load.magnitude * direction[1];
        if axial == 0.0 {
            self.unused(load.span, "GRAV", "it has no component along z, and a rigid body moves along z only");
            return Vec::new();
        }
        let masses: Vec<(usize, f64)> = (0..self.bodies.len())
            .filter(|&b| elements.is_none_or(|list| self.bodies[b].elements.iter().any(|e| list.contains(e))))
            // What tied elements weigh, the list of elements gives to their nodes.
            .map(|b| (b, if elements.is_none() { self.bodies[b].mass() } else { self.bodies[b].own_mass() }))
            .collect();
        if masses.is_empty() {
            let message = "gravity acts on elements that belong to no rigid body";
            self.diagnostics.push(Diagnostic::error("P003", message).at(load.span, "here"));
        }
        let detail = format!("a_z = {axial}{}", self.amplitude_name(load));
        let cause = self.cause(load.span, "gravity", masses.len(), "bodies", detail);
        let acceleration = self.magnitude(axial, load.amplitude);
        vec![Box::new(Gravity { cause, masses, acceleration })]
    }

    fn pressure(&mut self, load: &Load, sides: &Sides) -> Vec<Box<dyn Force>> {
        let by_body = self.facets(sides, load.span);
        let facets: Vec<_> =
            by_body.iter().flat_map(|(&b, list)| list.iter().map(move |(e, f)| (*e, b, f.normal[1]))).collect();
        let axial_areas =
            by_body.iter().map(|(&b, list)| (b, list.iter().map(|(_, f)| f.area * f.normal[1]).sum())).collect();
        let detail = format!("on {}, p = {}{}", sides.name, load.magnitude, self.amplitude_name(load));
        let cause = self.cause(load.span, "pressure", facets.len(), "facets", detail);
        let magnitude = self.magnitude(load.magnitude, load.amplitude);
        vec![Box::new(Pressure { cause, axial_areas, facets, magnitude, current: 0.0 })]
    }

    fn cavity(&mut self, load: &Load, sides: &Sides, target: usize, friction: f64, step: &Step) -> Vec<Box<dyn Force>> {
        let by_body = self.facets(sides, load.span);
        let target = &self.model.targets[target];
        let Some(layers) = self.layers(target) else { return Vec::new() };
        let count = by_body.values().map(Vec::len).sum();
        let detail = format!("{} into {}", sides.name, target.name);
        let cause = self.cause(load.span, "cavity expansion", count, "facets", detail);
        if friction > 0.0 {
            self.cause(load.span, "friction", count, "facets", format!("Coulomb, coefficient {friction}"));
        }
        self.layer_row(target);
        let travel = match step.increment {
            IncrementControl::Automatic { accuracy, .. } => accuracy.sqrt(),
            IncrementControl::Fixed(_) => 1.0,
        };
        let make = |(body, facets): (usize, Vec<(usize, Facet)>)| -> Box<dyn Force> {
            let stack = Stack::new(target.front, target.direction, &layers);
            Box::new(CavityExpansion::new(cause, body, friction, stack, &facets, travel))
        };
        by_body.into_iter().map(make).collect()
    }

    pub(super) fn layer_row(&mut self, target: &model::Target) {
        let names: Vec<_> =
            target.layers.iter().take(4).map(|l| self.model.materials[l.material].name.clone()).collect();
        let more = if target.layers.len() > 4 { ", …" } else { "" };
        let detail = format!("{}: {}{more}; front at z = {}", target.name, names.join(", "), target.front);
        self.cause(target.span, "target", target.layers.len(), "layers", detail);
    }

    pub(super) fn layers(&self, target: &model::Target) -> Option<Vec<(f64, Resistance)>> {
        let layer = |l: &model::Layer| {
            let material = &self.model.materials[l.material];
            let law = material.cavity?;
            let resistance = Resistance::new(law.yield_stress, material.density?, [law.a, law.b, law.c]);
            Some((l.thickness, resistance))
        };
        target.layers.iter().map(layer).collect()
    }

    /// The facets of sides, by body. Elements of no body are an error.
    pub(super) fn facets(&mut self, sides: &Sides, span: Span) -> FacetsByBody {
        let mut by_body = FacetsByBody::new();
        let mut stray = None;
        for &(element, side) in &sides.faces {
            match (self.body_of_element.get(&element), self.facet(element, side)) {
                (Some(&body), Some(facet)) => by_body.entry(body).or_default().push((element, facet)),
                (None, _) if self.places.elements.contains_key(&element) => {}
                (None, _) => stray = stray.or(Some(element)),
                _ => {}
            }
        }
        if let Some(element) = stray {
            let name = &self.model.mesh.elements[element].name;
            let message = format!("`{}` holds element {name}, which belongs to no rigid body", sides.name);
            self.diagnostics.push(Diagnostic::error("P003", message).at(span, "this load needs facets of a body"));
        }
        by_body
    }

    /// The facet of one side. A solid's face runs counter-clockwise, so its outward normal is the negative side.
    fn facet(&self, element: usize, side: Side) -> Option<Facet> {
        let mesh = &self.model.mesh;
        let [from, to] = mesh.ends(element, side)?.map(|n| mesh.points[n]);
        Facet::new(from, to, side == Side::Positive)
    }

    pub(super) fn amplitude_name(&self, load: &Load) -> String {
        load.amplitude.map_or(String::new(), |a| format!(" x {}", self.model.amplitudes[a].name))
    }

    /// Prescribed motions of bodies along z; what axial symmetry holds already is noted as unused.
    pub(super) fn motions(&mut self, step: &Step, asking: &mut Vec<Box<dyn Asking>>) -> Vec<Motion> {
        let mut motions: Vec<Motion> = Vec::new();
        for boundary in &step.boundaries {
            if boundary.nodes.iter().all(|n| self.places.has_node(*n)) {
                continue;
            }
            if boundary.dof != 2 {
                self.radial_boundary(boundary);
                continue;
            }
            for &node in &boundary.nodes {
                let Some(&body) = self.body_of_node.get(&node) else { continue };
                if self.bodies[body].reference != node {
                    self.dependent_node(boundary, node);
                } else if let Some(motion) = self.motion(boundary, body, &motions, asking) {
                    motions.push(motion);
                }
            }
        }
        motions
    }

    fn motion(
        &mut self,
        boundary: &Boundary,
        body: usize,
        others: &[Motion],
        asking: &mut Vec<Box<dyn Asking>>,
    ) -> Option<Motion> {
        let (kind, value) = prescribed(boundary);
        if let Some(other) = others.iter().find(|m| m.body == body) {
            if other.kind != kind || other.magnitude.value != value {
                let message = format!("body `{}` is given two motions along z", self.bodies[body].name);
                self.diagnostics.push(Diagnostic::error("P008", message).at(boundary.span, "the second of them"));
            }
            return None;
        }
        if boundary.user {
            return self.user_motion(boundary, body, kind, asking);
        }
        let detail = format!("{}: {:?} {value} along z", boundary.set, kind).to_lowercase();
        let cause = self.cause(boundary.span, "prescribed motion", 1, "bodies", detail);
        let magnitude = self.magnitude(value, boundary.amplitude);
        Some(Motion { cause, body, kind, magnitude, start: 0.0 })
    }

    fn radial_boundary(&mut self, boundary: &Boundary) {
        if boundary.value == 0.0 {
            let what = format!("*BOUNDARY {}, {}", boundary.set, boundary.dof);
            self.unused(boundary.span, what, "a rigid body of revolution moves along z only");
        } else {
            let message = "radial motion or rotation of a rigid body of revolution cannot be prescribed";
            self.diagnostics.push(Diagnostic::error("P103", message).at(boundary.span, "only 2 (z) can move"));
        }
    }

    fn dependent_node(&mut self, boundary: &Boundary, node: usize) {
        let name = &self.model.mesh.node_names[node];
        let message = format!("node {name} follows its rigid body; its motion cannot be prescribed");
        let finding = Diagnostic::error("P007", message).at(boundary.span, "here");
        self.diagnostics.push(finding.help("prescribe the motion of the body's REF NODE"));
    }
}

/// What a boundary prescribes, and its value at amplitude 1.
pub(super) fn prescribed(boundary: &Boundary) -> (Prescribed, f64) {
    match boundary.kind {
        // ABAQUS/Explicit ignores a displacement without amplitude: it would be a jump.
        model::Motion::Displacement if boundary.amplitude.is_none() => (Prescribed::Displacement, 0.0),
        model::Motion::Displacement => (Prescribed::Displacement, boundary.value),
        model::Motion::Velocity => (Prescribed::Velocity, boundary.value),
        model::Motion::Acceleration => (Prescribed::Acceleration, boundary.value),
    }
}

fn kind_name(kind: &LoadKind) -> &'static str {
    match kind {
        LoadKind::Concentrated { .. } => "*CLOAD",
        LoadKind::Gravity { .. } => "GRAV",
        LoadKind::Pressure(_) => "P",
        LoadKind::User { .. } => "PNU",
        LoadKind::UserBody { .. } => "BRNU or BZNU",
        LoadKind::Cavity { .. } => "CAVITY",
    }
}
