//! Loads of a step as effects, on rigid bodies and on what deforms alike.
//! Never here: what they do in an increment.

use std::collections::HashSet;

use indexmap::IndexMap;

use super::{Compiler, State};
use crate::deck::Diagnostic;
use crate::kernel::amplitude::Curve;
use crate::kernel::quad::corner_masses;
use crate::kernel::solid;
use crate::load::Load as Effect;
use crate::load::concentrated::Concentrated;
use crate::load::gravity::Gravity;
use crate::load::pressure::Pressure;
use crate::load::user_load::{Description, UserLoad, Volume};
use crate::mesh::surface::Surface;
use crate::model::{AmplitudeDefinition, AmplitudeId, ElementKind, Load, LoadKind, Sides, Step};
use crate::state::magnitude::{Magnitude, Shape};

impl Compiler<'_> {
    /// Whether a load can do anything; one that cannot is noted as unused.
    pub(super) fn matters(&mut self, load: &Load) -> bool {
        let constant = !matches!(
            load.kind,
            LoadKind::User { .. } | LoadKind::UserBody { .. } | LoadKind::Cavity { .. } | LoadKind::Film { .. }
        );
        let zero = constant && load.magnitude == 0.0;
        if zero {
            self.unused(load.span, kind_name(&load.kind), "its magnitude is zero");
        }
        !zero
    }

    /// The effect of one load; `None` where it has none, or where it cannot be (reported).
    pub(super) fn load(&mut self, load: &Load, step: &Step, state: &State) -> Option<Box<dyn Effect>> {
        if !self.matters(load) {
            return None;
        }
        match &load.kind {
            LoadKind::Concentrated { nodes, dof, set } => self.concentrated(load, nodes, *dof, set),
            LoadKind::Gravity { elements, direction } => self.gravity(load, elements.as_deref(), *direction, state),
            LoadKind::Pressure(sides) => self.pressure(load, sides),
            LoadKind::User { sides, load_type } => self.user_load(load, sides, *load_type, state),
            LoadKind::UserBody { elements, set, load_type } => self.user_body(load, elements, set, *load_type, state),
            LoadKind::Cavity { sides, target, friction } => self.cavity(load, sides, *target, *friction, step, state),
            // They act on temperatures (heat.rs).
            LoadKind::NodalHeat { .. }
            | LoadKind::SurfaceHeat(_)
            | LoadKind::BodyHeat { .. }
            | LoadKind::Film { .. } => None,
        }
    }

    pub(super) fn magnitude(&mut self, value: f64, amplitude: Option<AmplitudeId>) -> Magnitude {
        let Some(id) = amplitude else { return Magnitude::constant(value) };
        let shape = match &self.model.amplitudes[id].definition {
            AmplitudeDefinition::Curve { points, smooth, total_time } => {
                Shape::Curve(Curve::new(points.clone(), *smooth, *total_time))
            }
            AmplitudeDefinition::User { .. } => Shape::Told(self.user_amplitude(id)),
        };
        Magnitude { value, shape }
    }

    fn concentrated(&mut self, load: &Load, nodes: &[usize], dof: u8, set: &str) -> Option<Box<dyn Effect>> {
        let turning: Vec<usize> = nodes.iter().filter_map(|n| self.places.rotations.get(n).copied()).collect();
        if dof == 6 && !turning.is_empty() {
            let detail = format!("M = {}{}", load.magnitude, self.amplitude_name(load));
            let id = self.cause(load.span, "concentrated moment", turning.len(), "nodes", detail);
            let magnitude = self.magnitude(load.magnitude, load.amplitude);
            return Some(Box::new(Concentrated {
                id,
                bodies: Vec::new(),
                flights: Vec::new(),
                nodes: turning,
                axis: 0,
                magnitude,
            }));
        }
        let (mut bodies, mut deforming, mut stray) = (Vec::new(), Vec::new(), false);
        let mut flights = Vec::new();
        for node in nodes {
            match (self.places.free_node(*node), self.body_of_node.get(node)) {
                (Some(place), _) => deforming.push(place),
                (_, Some(&body)) => match self.bodies[body].flight {
                    Some(flight) => flights.push((flight, self.model.mesh.points[*node][1])),
                    None => bodies.push(body),
                },
                _ => stray = true,
            }
        }
        if stray {
            let message = format!("a force acts on nodes of `{set}` that belong to no body");
            self.diagnostics.push(Diagnostic::error("P003", message).at(load.span, "here"));
        }
        if dof != 2 && !flights.is_empty() {
            let name =
                self.bodies.iter().find(|b| b.flight == Some(flights[0].0)).map_or(String::new(), |b| b.name.clone());
            self.refuse_on_flight(load.span, &name, "a concentrated force that is not along 2, or a moment,");
            flights.clear();
        }
        if dof != 2 && !bodies.is_empty() {
            self.unused(load.span, "*CLOAD", "a rigid body of revolution moves along z only");
            bodies.clear();
        }
        if dof > 2 && !deforming.is_empty() {
            self.unused(load.span, "*CLOAD", "nodes of a body of revolution move along r and z only");
            deforming.clear();
        }
        let count = bodies.len() + flights.len() + deforming.len();
        if count == 0 {
            return None;
        }
        let axis = usize::from(dof) - 1;
        if deforming.iter().any(|&n| self.idle.contains(&(n, axis))) {
            let message = format!(
                "a force acts on `{set}`, which has no mass and on which nothing hangs along {}",
                ["r", "z"][axis]
            );
            let finding = Diagnostic::error("P062", message).at(load.span, "here");
            self.diagnostics.push(finding.help("couple that degree of freedom, or put a *MASS on the node"));
        }
        let detail = format!("F_{} = {}{}", ["r", "z"][axis], load.magnitude, self.amplitude_name(load));
        let id = self.cause(load.span, "concentrated force", count, "nodes", detail);
        let magnitude = self.magnitude(load.magnitude, load.amplitude);
        Some(Box::new(Concentrated { id, bodies, flights, nodes: deforming, axis, magnitude }))
    }

    fn gravity(
        &mut self,
        load: &Load,
        elements: Option<&[usize]>,
        direction: [f64; 2],
        state: &State,
    ) -> Option<Box<dyn Effect>> {
        let axial = load.magnitude * direction[1];
        let flies = self.bodies.iter().any(|b| b.flight.is_some());
        if axial == 0.0 && !(flies && direction[0] != 0.0) {
            self.unused(load.span, "GRAV", "it has no component along z, and a body of revolution moves along z only");
            return None;
        }
        let along_z = (0..self.bodies.len()).filter(|&b| self.bodies[b].flight.is_none());
        let bodies: Vec<(usize, f64)> =
            along_z.filter_map(|b| Some((b, self.weighed(&self.bodies[b], elements)?))).collect();
        let flights = self.weighed_flights(load, elements);
        let nodes: Vec<(usize, f64)> = match elements {
            None => {
                let masses = state.dofs.nodes.mass.iter().copied().enumerate().filter(|m| m.1 > 0.0);
                // Rotations come behind all nodes, and have inertia instead.
                masses.take_while(|(n, _)| *n < self.places.nodes.len()).collect()
            }
            Some(list) => self.masses_of(list),
        };
        if bodies.is_empty() && flights.is_empty() && nodes.is_empty() {
            let message = "gravity acts on elements that belong to no body";
            self.diagnostics.push(Diagnostic::error("P003", message).at(load.span, "here"));
        }
        let detail = format!("a_z = {axial}{}", self.amplitude_name(load));
        let (count, unit) = if nodes.is_empty() {
            (bodies.len() + flights.len(), "bodies")
        } else {
            (bodies.len() + nodes.len(), "nodes")
        };
        let id = self.cause(load.span, "gravity", count, unit, detail);
        let acceleration = self.magnitude(axial, load.amplitude);
        let across = self.magnitude(load.magnitude * direction[0], load.amplitude);
        Some(Box::new(Gravity { id, bodies, flights, nodes, whole: elements.is_none(), acceleration, across }))
    }

    /// Bodies with six degrees of freedom on which gravity acts, all of the mass of each at its centre.
    fn weighed_flights(&mut self, load: &Load, elements: Option<&[usize]>) -> Vec<(usize, f64)> {
        let mut flights = Vec::new();
        for b in 0..self.bodies.len() {
            let body = &self.bodies[b];
            let (Some(flight), Some(mass)) = (body.flight, self.weighed(body, elements)) else { continue };
            if mass == body.mass() {
                flights.push((flight, mass));
            } else {
                let name = body.name.clone();
                self.refuse_on_flight(load.span, &name, "gravity on a part of its mass");
            }
        }
        flights
    }

    /// The mass of a body on which gravity acts: all of it, or of the elements named its own, or that of the point masses among
    /// them.
    fn weighed(&self, body: &super::Body, elements: Option<&[usize]>) -> Option<f64> {
        let Some(list) = elements else { return Some(body.mass()) };
        // What tied elements weigh, the list of elements gives to their nodes.
        if body.elements.iter().any(|e| list.contains(e)) {
            return Some(body.own_mass());
        }
        let mesh = &self.model.mesh;
        let points = list.iter().filter(|&&e| mesh.elements[e].kind == ElementKind::Mass);
        let mut on: Vec<usize> =
            points.map(|&e| mesh.elements[e].nodes[0]).filter(|n| body.nodes.contains(n)).collect();
        on.sort_unstable();
        on.dedup();
        let mass: f64 = self.model.discrete.masses.iter().filter(|p| on.contains(&p.node)).map(|p| p.mass).sum();
        (mass > 0.0).then_some(mass)
    }

    /// Masses that some elements put on their nodes.
    fn masses_of(&self, elements: &[usize]) -> Vec<(usize, f64)> {
        let mesh = &self.model.mesh;
        let mut masses: IndexMap<usize, f64> = IndexMap::new();
        for section in &self.model.sections {
            let density = self.model.materials[section.material].density.unwrap_or(0.0);
            let own: HashSet<usize> = section.elements.iter().copied().collect();
            for &e in elements.iter().filter(|e| own.contains(*e) && self.places.elements.contains_key(e)) {
                for cell in mesh.cells(e) {
                    for (n, mass) in cell.iter().zip(corner_masses(cell.map(|n| mesh.points[n]), density)) {
                        *masses.entry(self.places.nodes[n]).or_default() += mass;
                    }
                }
            }
        }
        self.add_masses_of_shells(elements, &mut masses);
        masses.into_iter().collect()
    }

    fn pressure(&mut self, load: &Load, sides: &Sides) -> Option<Box<dyn Effect>> {
        let surface = self.surface(sides, load.span);
        self.refuse_on_patches(load, &surface);
        let detail = format!("on {}, p = {}{}", sides.name, load.magnitude, self.amplitude_name(load));
        let id = self.cause(load.span, "pressure", surface.count(), "facets", detail);
        let magnitude = self.magnitude(load.magnitude, load.amplitude);
        Some(Box::new(Pressure::new(id, surface, magnitude)))
    }

    /// Refuses a load on surfaces of bodies with six degrees of freedom.
    fn refuse_on_patches(&mut self, load: &Load, surface: &Surface) {
        let oblique = surface.patches.iter().map(|p| &self.bodies[p.body]).find(|b| b.flight.is_some());
        if let Some(name) = oblique.map(|body| body.name.clone()) {
            self.refuse_on_flight(load.span, &name, kind_name(&load.kind));
        }
    }

    /// `PNU` and `P1NU` to `P4NU`.
    fn user_load(&mut self, load: &Load, sides: &Sides, load_type: i32, state: &State) -> Option<Box<dyn Effect>> {
        let surface = self.surface(sides, load.span);
        self.refuse_on_patches(load, &surface);
        // The manual: normals point out of a surface element's loaded side, and into a solid.
        let solid = |e: usize| !matches!(self.model.mesh.elements[e].kind, ElementKind::Rax2 | ElementKind::Sax1);
        let inward = sides.faces.first().is_some_and(|f| solid(f.0));
        let load = self.described(load, "user load", &sides.name, load_type, inward, surface.count())?;
        Some(Box::new(UserLoad::on_surface(load, &surface, &state.dofs.nodes)))
    }

    /// `BRNU` and `BZNU`: the load integration point of a solid is its centre, its weight the volume.
    fn user_body(
        &mut self,
        load: &Load,
        elements: &[usize],
        set: &str,
        load_type: i32,
        state: &State,
    ) -> Option<Box<dyn Effect>> {
        let mesh = &self.model.mesh;
        let (mut volume, mut stray) = (Volume::default(), None);
        for &element in elements {
            if self.places.elements.contains_key(&element) {
                volume.cells.extend(mesh.cells(element).map(|cell| cell.map(|n| self.places.nodes[&n] as u32)));
                continue;
            }
            let corners: Vec<[f64; 2]> = mesh.elements[element].nodes.iter().map(|&n| mesh.points[n]).collect();
            match self.body_of_element.get(&element) {
                Some(&body) if self.bodies[body].flight.is_some() => {
                    let name = self.bodies[body].name.clone();
                    self.refuse_on_flight(load.span, &name, "a user body force");
                    return None;
                }
                Some(&body) if corners.len() > 2 => {
                    volume.rigid.push((body, element, solid::centre(&corners), solid::volume(&corners)));
                }
                _ => stray = stray.or(Some(element)),
            }
        }
        if let Some(element) = stray {
            let message = format!("`{set}` holds element {}, which is no solid of a body", mesh.elements[element].name);
            let finding = Diagnostic::error("P003", message).at(load.span, "a body force needs solid elements");
            self.diagnostics.push(finding);
        }
        if load_type == 1 && !volume.rigid.is_empty() {
            self.unused(load.span, "BRNU", "a rigid body of revolution moves along z only");
            volume.rigid.clear();
        }
        let count = volume.rigid.len() + volume.cells.len();
        if count == 0 {
            return None;
        }
        volume.rigid.sort_by_key(|point| point.0);
        let load = self.described(load, "user body force", set, load_type, false, count)?;
        Some(Box::new(UserLoad::on_volume(load, &volume, &state.dofs.nodes)))
    }

    fn described(
        &mut self,
        load: &Load,
        effect: &'static str,
        name: &str,
        load_type: i32,
        inward: bool,
        count: usize,
    ) -> Option<Description> {
        let Some(routine) = self.routines.load.clone() else {
            self.no_routine(load.span, "load", &format!("`{name}` asks for a user load (PNU)"), "vdload");
            return None;
        };
        self.called.push("vdload");
        let detail = format!("on {name}{}", self.amplitude_name(load));
        let id = self.cause(load.span, effect, count, "points", detail);
        let magnitude = self.magnitude(load.magnitude, load.amplitude);
        let reads_motion = routine.lock().reads_motion();
        Some(Description { id, name: name.to_uppercase(), load_type, inward, magnitude, reads_motion })
    }

    pub(super) fn amplitude_name(&self, load: &Load) -> String {
        load.amplitude.map_or(String::new(), |a| format!(" x {}", self.model.amplitudes[a].name))
    }
}

pub(super) fn kind_name(kind: &LoadKind) -> &'static str {
    match kind {
        LoadKind::Concentrated { .. } => "*CLOAD",
        LoadKind::Gravity { .. } => "GRAV",
        LoadKind::Pressure(_) => "P",
        LoadKind::User { .. } => "PNU",
        LoadKind::UserBody { .. } => "BRNU or BZNU",
        LoadKind::Cavity { .. } => "CAVITY",
        LoadKind::NodalHeat { .. } => "*CFLUX",
        LoadKind::SurfaceHeat(_) | LoadKind::BodyHeat { .. } => "*DFLUX",
        LoadKind::Film { .. } => "*FILM",
    }
}
