//! An amplitude computed by the user's routine (`*AMPLITUDE, DEFINITION=USER`).
//! Never here: what it scales.

use std::rc::Rc;

use crate::kernel::amplitude::Track;
use crate::load::Asking;
use crate::state::archive::{Archive, Persist};
use crate::state::halt::Halt;
use crate::state::magnitude::persist_track;
use crate::state::{BodyState, Instant};
use crate::user::{AmplitudeCall, LoadFailure, SharedAmplitude, Wish};

/// What a sensor measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sensed {
    /// Displacement of a body along z.
    Displacement(usize),
    /// Velocity along z.
    Velocity(usize),
    /// Acceleration along z.
    Acceleration(usize),
}

/// The amplitude: asked once an increment, whatever it scales.
pub struct UserAmplitude {
    /// Name, upper case.
    pub name: String,
    /// The routine.
    pub routine: SharedAmplitude,
    /// Constants on the data lines.
    pub properties: Vec<f64>,
    /// Variables of the routine.
    pub variables: Vec<f64>,
    /// Names of the sensors.
    pub sensor_names: Vec<String>,
    /// What they measure.
    pub sensors: Vec<Sensed>,
    /// Their values.
    pub sensor_values: Vec<f64>,
    /// Where the value goes.
    pub track: Rc<Track>,
}

impl Asking for UserAmplitude {
    fn ask(&mut self, arrival: &Instant, increment: f64, bodies: &[BodyState]) -> Result<Wish, Halt> {
        for (value, sensor) in self.sensor_values.iter_mut().zip(&self.sensors) {
            *value = match *sensor {
                Sensed::Displacement(b) => bodies[b].displacement,
                Sensed::Velocity(b) => bodies[b].velocity,
                Sensed::Acceleration(b) => bodies[b].acceleration,
            };
        }
        let mut call = AmplitudeCall {
            name: &self.name,
            now: *arrival,
            begins: increment == 0.0,
            increment,
            old: self.track.last(),
            properties: &self.properties,
            variables: &mut self.variables,
            sensor_names: &self.sensor_names,
            sensor_values: &self.sensor_values,
        };
        let answer = self.routine.with(|r| r.amplitude(&mut call)).and_then(|answer| {
            let reason = || LoadFailure::new(format!("it gave the value {}", answer.value));
            answer.value.is_finite().then_some(answer).ok_or_else(reason)
        });
        let what = || format!("the user amplitude `{}`", self.name);
        let answer = answer.map_err(|failure| failure.halt(&what(), arrival))?;
        self.track.tell(arrival.total_time, answer.value);
        Ok(match (answer.stop, answer.conclude_step) {
            (true, _) => Wish::EndAnalysis,
            (_, true) => Wish::EndStep,
            _ => Wish::Continue,
        })
    }
}

impl Persist for UserAmplitude {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let UserAmplitude {
            name: _,
            routine: _,
            properties: _,
            variables,
            sensor_names: _,
            sensors: _,
            // Read anew before each question.
            sensor_values: _,
            track,
        } = self;
        variables.as_mut_slice().persist(archive);
        persist_track(track, archive);
    }
}
