//! User subroutines of the plan: missing and unused subroutines, user amplitudes with their sensors, and VEXTERNALDB.

use crate::deck::Diagnostic;
use crate::load::user_amplitude::{SensorQuantity, SubroutineAmplitude};
use crate::model::{AmplitudeDefinition, AmplitudeId, OutputRegion, OutputRequest};
use crate::plan::{Report, Scene};
use crate::state::dofs::Dof;
use crate::variables::request::VariableRequest;
use crate::variables::{Variable, VariableComponent};

/// Returns the index of a user amplitude. Its subroutine is called once per increment, for any number of loads.
pub fn user_amplitude(scene: Scene, id: AmplitudeId, report: &mut Report) -> usize {
    if let Some(&index) = report.shared.amplitude_index.get(&id) {
        return index;
    }
    let index = report.shared.amplitude_count;
    report.shared.amplitude_count += 1;
    report.shared.amplitude_index.insert(id, index);
    let amplitude = &scene.model.amplitudes[id];
    let AmplitudeDefinition::User { properties, variables } = &amplitude.definition else { return index };
    let asks = format!("amplitude `{}` is user-defined", amplitude.name);
    if report.require_routine(amplitude.span, "amplitude", &asks, "vuamp").is_none() {
        return index;
    }
    let (sensor_names, sensors): (Vec<_>, Vec<_>) = sensors(scene, report).into_iter().unzip();
    let detail = format!("{} ({} sensors)", amplitude.name, sensors.len());
    let id = report.ledger_row(amplitude.span, "user amplitude", 1, "amplitude", detail);
    report.shared.amplitudes.push(SubroutineAmplitude {
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
fn sensors(scene: Scene, report: &mut Report) -> Vec<(String, SensorQuantity)> {
    let model = scene.model;
    let mut sensors: Vec<(String, SensorQuantity)> = Vec::new();
    for request in model.steps.iter().flat_map(|s| &s.outputs) {
        let Some(name) = &request.sensor else { continue };
        match sensed(scene, request) {
            Some(sensed) if !sensors.iter().any(|s| s.0 == *name) => sensors.push((name.clone(), sensed)),
            Some(_) => {}
            None => {
                let message = format!("sensor `{name}` must be one component of U, V or A, at one node of a body");
                report.push(Diagnostic::error("P010", message).at(request.span, "this sensor"));
            }
        }
    }
    sensors
}

fn sensed(scene: Scene, request: &OutputRequest) -> Option<SensorQuantity> {
    let OutputRegion::Nodes(set) = &request.region else { return None };
    if !request.statistics.is_empty() {
        return None;
    }
    let [node] = scene.model.node_sets[*set].members[..] else { return None };
    let [VariableRequest::One(VariableComponent { variable, component })] = request.variables[..] else {
        return None;
    };
    let dof = match (scene.places.free_node(node), scene.bodies.of_node.get(&node)) {
        (Some(solver_node), _) => Dof::Node(solver_node, component),
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
