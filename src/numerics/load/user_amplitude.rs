//! Amplitudes computed by a user subroutine (`*AMPLITUDE, DEFINITION=USER`).

use crate::kernel::amplitude::SampledAmplitude;
use crate::kernel::lists::Memory;
use crate::routines::{AmplitudeCall, LoadFailure, LockedRoutines, RunAction};
use crate::state::archive::Persist;
use crate::state::dofs::{Dof, Dofs};
use crate::state::halt::HaltReason;
use crate::state::{EffectId, Instant};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorQuantity {
    Displacement(Dof),
    Velocity(Dof),
    Acceleration(Dof),
}

/// A user amplitude, evaluated once per increment for all loads and conditions that use it.
#[derive(Clone, Debug, Persist, Memory)]
// Sensor values are read before each call; amplitude values are saved with the run.
#[persist(fixed: variables; derived: id, name, properties, sensor_names, sensors, sensor_values, index)]
pub struct SubroutineAmplitude {
    pub id: EffectId,
    /// Name, upper case.
    pub name: String,
    /// Constants of the data lines.
    pub properties: Vec<f64>,
    pub variables: Vec<f64>,
    pub sensor_names: Vec<String>,
    pub sensors: Vec<SensorQuantity>,
    pub sensor_values: Vec<f64>,
    /// Index among the user amplitudes.
    pub index: usize,
}

impl SubroutineAmplitude {
    /// Calls the subroutine for the value at `arrival`, the end of an increment (of length 0 at the start of a step).
    ///
    /// # Errors
    /// If the subroutine fails or returns a value that is not finite; the run halts.
    pub fn call(
        &mut self,
        arrival: &Instant,
        increment: f64,
        dofs: &Dofs,
        user_amplitudes: &mut [SampledAmplitude],
        user: &mut LockedRoutines,
    ) -> Result<RunAction, HaltReason> {
        let Some(routine) = user.amplitude.as_deref_mut() else { return Ok(RunAction::Continue) };
        for (value, sensor) in self.sensor_values.iter_mut().zip(&self.sensors) {
            *value = match *sensor {
                SensorQuantity::Displacement(dof) => dofs.displacement(dof),
                SensorQuantity::Velocity(dof) => dofs.velocity(dof),
                SensorQuantity::Acceleration(dof) => dofs.acceleration(dof),
            };
        }
        let mut call = AmplitudeCall {
            name: &self.name,
            now: *arrival,
            begins: increment == 0.0,
            increment,
            old: user_amplitudes[self.index].last(),
            properties: &self.properties,
            variables: &mut self.variables,
            sensor_names: &self.sensor_names,
            sensor_values: &self.sensor_values,
        };
        let answer = routine.amplitude(&mut call).and_then(|answer| {
            let reason = || LoadFailure::new(format!("it returned the value {}", answer.value));
            answer.value.is_finite().then_some(answer).ok_or_else(reason)
        });
        let what = || format!("the user amplitude `{}`", self.name);
        let answer = answer.map_err(|failure| failure.halt(&what(), arrival))?;
        user_amplitudes[self.index].add_sample(arrival.total_time, answer.value);
        Ok(match (answer.stop, answer.conclude_step) {
            (true, _) => RunAction::EndAnalysis,
            (_, true) => RunAction::EndStep,
            _ => RunAction::Continue,
        })
    }
}
