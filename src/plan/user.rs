//! What a deck leaves to the user's routines, as effects: loads, amplitudes with their sensors, motions, events.
//! Never here: calling a routine.

use std::collections::BTreeMap;
use std::rc::Rc;

use super::Compiler;
use crate::constraint::motion::{Motion, Prescribed};
use crate::constraint::user_motion::UserMotion;
use crate::deck::{Diagnostic, Span};
use crate::kernel::amplitude::Track;
use crate::kernel::solid;
use crate::load::Asking;
use crate::load::Force;
use crate::load::user_amplitude::{Sensed, UserAmplitude};
use crate::load::user_load::{Point, UserLoad, UserPressure};
use crate::model::{AmplitudeDefinition, Boundary, ElementKind, Load, OutputRequest, Region, Sides};
use crate::state::magnitude::Magnitude;
use crate::state::magnitude::Shape;

impl Compiler<'_> {
    /// `PNU` and `P1NU` to `P4NU`.
    pub(super) fn user_load(&mut self, load: &Load, sides: &Sides, load_type: i32) -> Vec<Box<dyn Force>> {
        let by_body = self.facets(sides, load.span);
        // The manual: normals point out of a surface element's loaded side, and into a solid.
        let solid = |e: usize| self.model.mesh.elements[e].kind != ElementKind::Rax2;
        let inward = sides.faces.first().is_some_and(|f| solid(f.0));
        let points = by_body.into_iter().map(|(body, facets)| {
            let point = |(element, facet): &(usize, crate::kernel::facet::Facet)| Point {
                element: *element,
                place: facet.middle(),
                normal: facet.normal,
                weight: -facet.area * facet.normal[1],
            };
            (body, facets.iter().map(point).collect())
        });
        let points = points.collect();
        self.user_points(load, "user load", &sides.name, load_type, inward, points)
    }

    /// `BRNU` and `BZNU`: the load integration point of a solid is its centre, its weight the volume.
    pub(super) fn user_body(
        &mut self,
        load: &Load,
        elements: &[usize],
        set: &str,
        load_type: i32,
    ) -> Vec<Box<dyn Force>> {
        if load_type == 1 {
            self.unused(load.span, "BRNU", "a rigid body of revolution moves along z only");
            return Vec::new();
        }
        let mesh = &self.model.mesh;
        let mut points: BTreeMap<usize, Vec<Point>> = BTreeMap::new();
        let mut stray = None;
        for &element in elements {
            let corners: Vec<[f64; 2]> = mesh.elements[element].nodes.iter().map(|&n| mesh.points[n]).collect();
            match self.body_of_element.get(&element) {
                Some(&body) if corners.len() > 2 => {
                    let place = solid::centre(&corners);
                    let weight = solid::volume(&corners);
                    points.entry(body).or_default().push(Point { element, place, normal: [0.0; 2], weight });
                }
                _ if self.places.elements.contains_key(&element) => {}
                _ => stray = stray.or(Some(element)),
            }
        }
        if let Some(element) = stray {
            let message =
                format!("`{set}` holds element {}, which is no solid of a rigid body", mesh.elements[element].name);
            let finding = Diagnostic::error("P003", message).at(load.span, "a body force needs solid elements");
            self.diagnostics.push(finding);
        }
        self.user_points(load, "user body force", set, load_type, false, points)
    }

    fn user_points(
        &mut self,
        load: &Load,
        effect: &'static str,
        name: &str,
        load_type: i32,
        inward: bool,
        points: BTreeMap<usize, Vec<Point>>,
    ) -> Vec<Box<dyn Force>> {
        let Some(routine) = self.routines.load.clone() else {
            self.no_routine(load.span, "load", &format!("`{name}` asks for a user load (PNU)"), "vdload");
            return Vec::new();
        };
        let count = points.values().map(Vec::len).sum();
        let detail = format!("on {name}{}", self.amplitude_name(load));
        let cause = self.cause(load.span, effect, count, "points", detail);
        let magnitude = self.magnitude(load.magnitude, load.amplitude);
        let make = |(body, points): (usize, Vec<Point>)| -> Box<dyn Force> {
            let load = UserLoad {
                cause,
                name: name.to_uppercase(),
                load_type,
                inward,
                magnitude: magnitude.clone(),
                routine: routine.clone(),
            };
            Box::new(UserPressure::new(load, body, &points))
        };
        points.into_iter().map(make).collect()
    }

    pub(super) fn no_routine(&mut self, span: Span, label: &str, asks: &str, name: &str) {
        let message = format!("{asks}, but no routine was given");
        let finding = Diagnostic::error("P004", message).at(span, format!("this {label} calls the user's routine"));
        self.diagnostics.push(finding.help(format!("give a file that defines {name} with --user FILE")));
    }

    /// The values of a user amplitude; its routine is asked once an increment, however many loads it scales.
    pub(super) fn user_amplitude(&mut self, index: usize) -> Rc<Track> {
        if let Some(track) = self.tracks.get(&index) {
            return track.clone();
        }
        let amplitude = &self.model.amplitudes[index];
        let track = Rc::new(Track::default());
        self.tracks.insert(index, track.clone());
        let AmplitudeDefinition::User { properties, variables } = &amplitude.definition else { return track };
        let Some(routine) = self.routines.amplitude.clone() else {
            let asks = format!("the amplitude `{}` is the user's", amplitude.name);
            self.no_routine(amplitude.span, "amplitude", &asks, "vuamp");
            return track;
        };
        let (sensor_names, sensors): (Vec<_>, Vec<_>) = self.sensors().into_iter().unzip();
        let detail = format!("{} ({} sensors)", amplitude.name, sensors.len());
        self.cause(amplitude.span, "user amplitude", 1, "amplitude", detail);
        self.asking.push(Box::new(UserAmplitude {
            name: amplitude.name.clone(),
            routine,
            properties: properties.clone(),
            variables: vec![0.0; *variables],
            sensor_values: vec![0.0; sensors.len()],
            sensor_names,
            sensors,
            track: track.clone(),
        }));
        track
    }

    /// The sensors of all steps: `*OUTPUT, HISTORY, SENSOR, NAME=` with one variable on one node.
    fn sensors(&mut self) -> Vec<(String, Sensed)> {
        let model = self.model;
        let mut sensors: Vec<(String, Sensed)> = Vec::new();
        for request in model.steps.iter().flat_map(|s| &s.outputs) {
            let Some(name) = &request.sensor else { continue };
            match self.sensed(request) {
                Some(sensed) if !sensors.iter().any(|s| s.0 == *name) => sensors.push((name.clone(), sensed)),
                Some(_) => {}
                None => {
                    let message = format!("the sensor `{name}` must be one of U2, V2, A2 on one node of a rigid body");
                    self.diagnostics.push(Diagnostic::error("P010", message).at(request.span, "this sensor"));
                }
            }
        }
        sensors
    }

    fn sensed(&self, request: &OutputRequest) -> Option<Sensed> {
        let Region::Nodes(set) = &request.region else { return None };
        let [node] = self.model.node_sets.get(set)?.members[..] else { return None };
        let body = *self.body_of_node.get(&node)?;
        match request.variables.iter().map(String::as_str).collect::<Vec<_>>()[..] {
            ["U2"] => Some(Sensed::Displacement(body)),
            ["V2"] => Some(Sensed::Velocity(body)),
            ["A2"] => Some(Sensed::Acceleration(body)),
            _ => None,
        }
    }

    /// `*BOUNDARY, USER` on a body's reference node.
    pub(super) fn user_motion(
        &mut self,
        boundary: &Boundary,
        body: usize,
        kind: Prescribed,
        asking: &mut Vec<Box<dyn Asking>>,
    ) -> Option<Motion> {
        let Some(routine) = self.routines.motion.clone() else {
            let asks = format!("the motion of `{}` is the user's (*BOUNDARY, USER)", boundary.set);
            self.no_routine(boundary.span, "motion", &asks, "vdisp");
            return None;
        };
        let detail = format!("{}: {:?} along z by the user", boundary.set, kind).to_lowercase();
        let cause = self.cause(boundary.span, "prescribed motion", 1, "bodies", detail);
        let track = Rc::new(Track::default());
        let mesh = &self.model.mesh;
        let reference = self.bodies[body].reference;
        let node = mesh.node_names[reference].parse().unwrap_or(reference as i32 + 1);
        let start = mesh.points[reference];
        let amplitude = self.magnitude(1.0, boundary.amplitude);
        asking.push(Box::new(UserMotion {
            set: boundary.set.to_uppercase(),
            node,
            body,
            kind,
            amplitude,
            start,
            offset: 0.0,
            routine,
            track: track.clone(),
            increment_before: 0.0,
        }));
        Some(Motion { cause, body, kind, magnitude: Magnitude { value: 1.0, shape: Shape::Track(track) }, start: 0.0 })
    }

    /// The row of the routine that is told how the analysis goes.
    pub(super) fn events_row(&mut self) {
        if self.routines.events.is_some() {
            self.ledger.add("user events", 1, "routine", "--user".into(), "vexternaldb".into());
        }
    }
}
