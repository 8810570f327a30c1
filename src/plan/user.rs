//! What a deck leaves to the user's routines, as effects: loads, amplitudes with their sensors, motions, events.
//! Never here: calling a routine.

use super::Compiler;
use crate::deck::{Diagnostic, Span};
use crate::load::user_amplitude::{SensorQuantity, SubroutineAmplitude};
use crate::model::{AmplitudeDefinition, AmplitudeId, OutputRegion, OutputRequest};
use crate::state::dofs::Dof;
use crate::variables::request::VariableRequest;
use crate::variables::{Variable, VariableComponent};

impl Compiler<'_> {
    /// Says that a routine that the deck asks for is not there, or why it cannot be called.
    pub(super) fn report_missing_routine(&mut self, span: Span, label: &str, asks: &str, name: &'static str) {
        self.called_routines.push(name);
        if let Some(uncallable) = self.routines.uncallable.iter().find(|m| m.routine == name) {
            let code = if uncallable.code == "U004" { "U004" } else { "U005" };
            let finding = Diagnostic::error(code, format!("{asks}: {}", uncallable.message));
            return self.diagnostics.push(finding.at(span, format!("this {label} calls the user's routine")));
        }
        let given =
            if self.routines.any() { "the files that were given do not define it" } else { "no routine was given" };
        let finding = Diagnostic::error("P004", format!("{asks}, but {given}"));
        let finding = finding.at(span, format!("this {label} calls the user's routine"));
        self.diagnostics.push(finding.help(format!("give a file that defines {name} with --user FILE")));
    }

    /// Notes routines of the user's files that nothing calls.
    pub(super) fn note_uncalled(&mut self) {
        let routines = self.routines;
        let there = [
            ("vdload", routines.load.is_some(), "no load PNU, BRNU or BZNU"),
            ("vuamp", routines.amplitude.is_some(), "no *AMPLITUDE, DEFINITION=USER is in use"),
            ("vdisp", routines.motion.is_some(), "no *BOUNDARY, USER"),
            ("vumat", routines.material.is_some(), "no element has a *USER MATERIAL"),
            ("vuhard", routines.hardening.is_some(), "no element has *PLASTIC, HARDENING=USER"),
            ("vusdfld", routines.fields.is_some(), "no element has a *USER DEFINED FIELD"),
            ("vucharlength", routines.lengths.is_some(), "no element takes a length of *CHARACTERISTIC LENGTH"),
        ];
        let uncalled: Vec<(&str, &str)> =
            there.into_iter().filter(|r| r.1 && !self.called_routines.contains(&r.0)).map(|r| (r.0, r.2)).collect();
        let unsupported = routines.unsupported.iter().map(|name| (*name, "Revolve does not have it"));
        for (name, why) in uncalled.into_iter().chain(unsupported) {
            self.add_unused_card(Span::default(), format!("routine {name}"), format!("it is never called: {why}"));
            let message = format!("the user's files define `{name}`, which is never called: {why}");
            self.diagnostics.push(Diagnostic::note("U009", message));
        }
    }

    /// Index of a user amplitude; its subroutine is called once an increment, whatever the number of loads it scales.
    pub(super) fn user_amplitude(&mut self, id: AmplitudeId) -> usize {
        if let Some(&index) = self.user_amplitude_index.get(&id) {
            return index;
        }
        let index = self.user_amplitude_count;
        self.user_amplitude_count += 1;
        self.user_amplitude_index.insert(id, index);
        let amplitude = &self.model.amplitudes[id];
        let AmplitudeDefinition::User { properties, variables } = &amplitude.definition else { return index };
        if self.routines.amplitude.is_none() {
            let asks = format!("the amplitude `{}` is the user's", amplitude.name);
            self.report_missing_routine(amplitude.span, "amplitude", &asks, "vuamp");
            return index;
        }
        self.called_routines.push("vuamp");
        let (sensor_names, sensors): (Vec<_>, Vec<_>) = self.sensors().into_iter().unzip();
        let detail = format!("{} ({} sensors)", amplitude.name, sensors.len());
        let id = self.ledger_row(amplitude.span, "user amplitude", 1, "amplitude", detail);
        self.amplitudes.push(SubroutineAmplitude {
            id,
            name: amplitude.name.clone(),
            properties: properties.clone(),
            variables: vec![0.0; *variables],
            sensor_values: vec![0.0; sensors.len()],
            sensor_names,
            sensors,
            index,
        });
        index
    }

    /// The sensors of all steps: `*OUTPUT, HISTORY, SENSOR, NAME=` with one variable on one node.
    fn sensors(&mut self) -> Vec<(String, SensorQuantity)> {
        let model = self.model;
        let mut sensors: Vec<(String, SensorQuantity)> = Vec::new();
        for request in model.steps.iter().flat_map(|s| &s.outputs) {
            let Some(name) = &request.sensor else { continue };
            match self.sensed(request) {
                Some(sensed) if !sensors.iter().any(|s| s.0 == *name) => sensors.push((name.clone(), sensed)),
                Some(_) => {}
                None => {
                    let message =
                        format!("the sensor `{name}` must be one of U, V, A with a number, on one node that moves");
                    self.diagnostics.push(Diagnostic::error("P010", message).at(request.span, "this sensor"));
                }
            }
        }
        sensors
    }

    fn sensed(&self, request: &OutputRequest) -> Option<SensorQuantity> {
        let OutputRegion::Nodes(set) = &request.region else { return None };
        if !request.statistics.is_empty() {
            return None;
        }
        let [node] = self.model.node_sets[*set].members[..] else { return None };
        let [VariableRequest::One(VariableComponent { variable, component })] = request.variables[..] else {
            return None;
        };
        let dof = match (self.places.free_node(node), self.body_of_node.get(&node)) {
            (Some(place), _) => Dof::Node(place, component),
            (_, Some(&body)) if component == 1 => Dof::Body(body),
            _ => return None,
        };
        match variable {
            Variable::Displacement => Some(SensorQuantity::Displacement(dof)),
            Variable::Velocity => Some(SensorQuantity::Velocity(dof)),
            Variable::Acceleration => Some(SensorQuantity::Acceleration(dof)),
            _ => None,
        }
    }

    /// Adds the ledger row of the subroutine that is called at the moments of the analysis.
    pub(super) fn events_row(&mut self) {
        if self.routines.events.is_some() {
            self.ledger.add("user events", 1, "routine", "--user".into(), "vexternaldb".into());
        }
    }
}
