//! User subroutines of the plan: missing and unused subroutines, user amplitudes, and VEXTERNALDB.

use crate::load::user_amplitude::SubroutineAmplitude;
use crate::model::{AmplitudeDefinition, AmplitudeId};
use crate::plan::{Report, Scene};

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
    let sensor_names = scene.model.sensor_names();
    let detail = format!("{} ({} sensors)", amplitude.name, sensor_names.len());
    let id = report.ledger_row(amplitude.span, "user amplitude", 1, "amplitude", detail);
    report.shared.amplitudes.push(SubroutineAmplitude {
        id,
        name: amplitude.name.clone(),
        properties: properties.clone(),
        variables: vec![0.0; *variables],
        sensor_names,
        index,
    });
    index
}
