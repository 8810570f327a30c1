//! Amplitudes computed by a user subroutine (`*AMPLITUDE, DEFINITION=USER`).

use crate::kernel::amplitude::SampledAmplitude;
use crate::kernel::lists::Memory;
use crate::routines::{AmplitudeCall, LoadFailure, LockedRoutines, RunAction};
use crate::state::archive::Persist;
use crate::state::halt::HaltReason;
use crate::state::{EffectId, Instant};

/// A user amplitude, evaluated once per increment for all loads and conditions that use it.
#[derive(Clone, Debug, Persist, Memory)]
// Amplitude values are saved with the run.
#[persist(fixed: variables; derived: id, name, properties, sensor_names, index)]
pub struct SubroutineAmplitude {
    pub id: EffectId,
    /// Name, upper case.
    pub name: String,
    /// Constants of the data lines.
    pub properties: Vec<f64>,
    pub variables: Vec<f64>,
    pub sensor_names: Vec<String>,
    /// Index among the user amplitudes.
    pub index: usize,
}

impl SubroutineAmplitude {
    /// Calls the subroutine for the value at `arrival`, the end of an increment (of length 0 at the start of a step).
    /// `sensor_values` are those at the start of the increment.
    ///
    /// # Errors
    /// If the subroutine fails or returns a value that is not finite; the run halts.
    pub fn call(
        &mut self,
        arrival: &Instant,
        increment: f64,
        sensor_values: &[f64],
        user_amplitudes: &mut [SampledAmplitude],
        user: &mut LockedRoutines,
    ) -> Result<RunAction, HaltReason> {
        let Some(routine) = user.amplitude.as_deref_mut() else { return Ok(RunAction::Continue) };
        let mut call = AmplitudeCall {
            name: &self.name,
            now: *arrival,
            begins: increment == 0.0,
            increment,
            old: user_amplitudes[self.index].last(),
            properties: &self.properties,
            variables: &mut self.variables,
            sensor_names: &self.sensor_names,
            sensor_values,
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
