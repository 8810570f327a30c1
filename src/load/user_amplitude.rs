//! An amplitude computed by the user's routine (`*AMPLITUDE, DEFINITION=USER`).
//! Never here: what it scales.

use crate::kernel::amplitude::SampledAmplitude;
use crate::kernel::lists::heap_bytes;
use crate::state::archive::persist_struct;
use crate::state::dofs::{Dof, Dofs};
use crate::state::halt::Halt;
use crate::state::{EffectId, Instant};
use crate::user::{AmplitudeCall, LoadFailure, Locked, RunAction};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sensed {
    Displacement(Dof),
    Velocity(Dof),
    Acceleration(Dof),
}

/// The amplitude: asked once an increment, whatever it scales.
#[derive(Clone, Debug)]
pub struct UserAmplitude {
    pub id: EffectId,
    /// Name, upper case.
    pub name: String,
    /// Constants on the data lines.
    pub properties: Vec<f64>,
    pub variables: Vec<f64>,
    pub sensor_names: Vec<String>,
    pub sensors: Vec<Sensed>,
    pub sensor_values: Vec<f64>,
    /// Its index among the user amplitudes.
    pub index: usize,
}

impl UserAmplitude {
    /// Asks for the value at `arrival`, an increment away (0 at the start of a step).
    ///
    /// # Errors
    /// Where the routine fails or gives no finite value; the run halts.
    pub fn call(
        &mut self,
        arrival: &Instant,
        increment: f64,
        dofs: &Dofs,
        user_amplitudes: &mut [SampledAmplitude],
        user: &mut Locked<'_>,
    ) -> Result<RunAction, Halt> {
        let Some(routine) = user.amplitude.as_deref_mut() else { return Ok(RunAction::Continue) };
        for (value, sensor) in self.sensor_values.iter_mut().zip(&self.sensors) {
            *value = match *sensor {
                Sensed::Displacement(dof) => dofs.displacement(dof),
                Sensed::Velocity(dof) => dofs.velocity(dof),
                Sensed::Acceleration(dof) => dofs.acceleration(dof),
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
            let reason = || LoadFailure::new(format!("it gave the value {}", answer.value));
            answer.value.is_finite().then_some(answer).ok_or_else(reason)
        });
        let what = || format!("the user amplitude `{}`", self.name);
        let answer = answer.map_err(|failure| failure.halt(&what(), arrival))?;
        user_amplitudes[self.index].tell(arrival.total_time, answer.value);
        Ok(match (answer.stop, answer.conclude_step) {
            (true, _) => RunAction::EndAnalysis,
            (_, true) => RunAction::EndStep,
            _ => RunAction::Continue,
        })
    }

    pub fn bytes(&self) -> usize {
        let names: usize = self.sensor_names.iter().map(|n| size_of::<String>() + n.capacity()).sum();
        let numbers = self.properties.capacity() + self.variables.capacity() + self.sensor_values.capacity();
        names + 8 * numbers + heap_bytes(&self.sensors) + self.name.capacity()
    }
}

// Values of sensors are read before each call; the values that the subroutine gives belong to the run.
persist_struct!(UserAmplitude {
    variables: fixed
} derived {
    id, name, properties, sensor_names, sensors, sensor_values, index
});
