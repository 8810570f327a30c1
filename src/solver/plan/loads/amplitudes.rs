//! User subroutines of the plan: missing and unused subroutines, user amplitudes with their sensors, and VEXTERNALDB.

use crate::deck::{Diagnostic, Span};
use crate::load::user_amplitude::{SensorQuantity, SubroutineAmplitude};
use crate::model::{AmplitudeDefinition, AmplitudeId, OutputRegion, OutputRequest};
use crate::plan::Compiler;
use crate::state::dofs::Dof;
use crate::variables::request::VariableRequest;
use crate::variables::{Variable, VariableComponent};

impl Compiler<'_> {
    /// Reports that a user subroutine that the deck needs is missing, or the reason why it cannot be called.
    pub(crate) fn report_missing_routine(&mut self, span: Span, label: &str, asks: &str, name: &'static str) {
        self.called_routines.push(name);
        if let Some(uncallable) = self.routines.uncallable.iter().find(|m| m.routine == name) {
            let code = if uncallable.code == "U004" { "U004" } else { "U005" };
            let finding = Diagnostic::error(code, format!("{asks}: {}", uncallable.message));
            return self.diagnostics.push(finding.at(span, format!("this {label} calls a user subroutine")));
        }
        let given =
            if self.routines.any() { "the given files do not define it" } else { "no user subroutine was given" };
        let finding = Diagnostic::error("P004", format!("{asks}, but {given}"));
        let finding = finding.at(span, format!("this {label} calls a user subroutine"));
        self.diagnostics.push(finding.help(format!("give a file that defines {name} with --user FILE")));
    }

    /// Notes user subroutines that are never called.
    pub(crate) fn note_uncalled(&mut self) {
        let routines = self.routines;
        let there = [
            ("vdload", routines.load.is_some(), "there is no load PNU, BRNU or BZNU"),
            ("vuamp", routines.amplitude.is_some(), "no *AMPLITUDE, DEFINITION=USER is used"),
            ("vdisp", routines.motion.is_some(), "there is no *BOUNDARY, USER"),
            ("vumat", routines.material.is_some(), "no element has a *USER MATERIAL"),
            ("vuhard", routines.hardening.is_some(), "no element has *PLASTIC, HARDENING=USER"),
            ("vusdfld", routines.fields.is_some(), "no element has a *USER DEFINED FIELD"),
            ("vucharlength", routines.lengths.is_some(), "no element uses a length of *CHARACTERISTIC LENGTH"),
        ];
        let uncalled: Vec<(&str, &str)> =
            there.into_iter().filter(|r| r.1 && !self.called_routines.contains(&r.0)).map(|r| (r.0, r.2)).collect();
        let unsupported = routines.unsupported.iter().map(|name| (*name, "Revolve does not support it"));
        for (name, why) in uncalled.into_iter().chain(unsupported) {
            self.add_unused_card(Span::default(), format!("routine {name}"), format!("it is never called: {why}"));
            let message = format!("user subroutine `{name}` is never called: {why}");
            self.diagnostics.push(Diagnostic::note("U009", message));
        }
    }

    /// Returns the index of a user amplitude. Its subroutine is called once per increment, for any number of loads.
    pub(crate) fn user_amplitude(&mut self, id: AmplitudeId) -> usize {
        if let Some(&index) = self.user_amplitude_index.get(&id) {
            return index;
        }
        let index = self.user_amplitude_count;
        self.user_amplitude_count += 1;
        self.user_amplitude_index.insert(id, index);
        let amplitude = &self.model.amplitudes[id];
        let AmplitudeDefinition::User { properties, variables } = &amplitude.definition else { return index };
        if self.routines.amplitude.is_none() {
            let asks = format!("amplitude `{}` is user-defined", amplitude.name);
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

    /// Returns the sensors of all steps: `*OUTPUT, HISTORY, SENSOR, NAME=` with one variable at one node.
    fn sensors(&mut self) -> Vec<(String, SensorQuantity)> {
        let model = self.model;
        let mut sensors: Vec<(String, SensorQuantity)> = Vec::new();
        for request in model.steps.iter().flat_map(|s| &s.outputs) {
            let Some(name) = &request.sensor else { continue };
            match self.sensed(request) {
                Some(sensed) if !sensors.iter().any(|s| s.0 == *name) => sensors.push((name.clone(), sensed)),
                Some(_) => {}
                None => {
                    let message = format!("sensor `{name}` must be one component of U, V or A, at one node of a body");
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

    /// Adds the ledger row of VEXTERNALDB.
    pub(crate) fn events_row(&mut self) {
        if self.routines.events.is_some() {
            self.ledger.add("user events", 1, "routine", "--user".into(), "vexternaldb".into());
        }
    }
}
