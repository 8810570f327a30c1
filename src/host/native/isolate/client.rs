//! User subroutines in another process, as implementations of the traits of `user`: each call writes its arguments,
//! hands over the turn, and reads the results. The other side is in `server`.

use std::sync::Arc;

use super::super::{
    AmplitudeAnswer, AmplitudeCall, AnalysisMoment, EnergyAnswer, EnergyCall, FrictionCall, HardeningAnswer,
    HardeningCall, LengthCall, LoadFailure, LoadPoints, MaterialAnswer, MaterialCall, MotionCall, NodalFieldCall,
    RunAction, UserAmplitude, UserEnergy, UserEvents, UserFriction, UserHardening, UserLengths, UserLoad, UserMaterial,
    UserMotion, UserNodalFields,
};
use super::channel::RoutineChannel;
use super::message::{MessageField as _, MessageWriter, put};
use super::shared_memory::TurnPurpose;
use revolve_numerics::state::Instant;

/// A user subroutine on the other side of the channel.
pub struct RoutineClient {
    channel: Arc<RoutineChannel>,
}

impl RoutineClient {
    /// Creates a client, which can call any subroutine.
    pub fn new(channel: &Arc<RoutineChannel>) -> RoutineClient {
        RoutineClient { channel: Arc::clone(channel) }
    }

    /// Calls a subroutine with its arguments and the lists of its results, which it overwrites.
    fn call<const N: usize>(
        &self,
        purpose: TurnPurpose,
        write: impl FnOnce(&mut MessageWriter<'_>),
        answer: [&mut [f64]; N],
    ) -> Result<(), LoadFailure> {
        let memory = &self.channel.memory;
        memory.with(|exchange| {
            exchange.purpose = purpose as u32;
            let mut writer = exchange.call.write();
            write(&mut writer);
            answer.iter().for_each(|list| writer.list(list));
            writer.end()
        })?;
        if self.channel.turn().is_none() {
            return Err(LoadFailure::new(format!("{} {}", purpose.routine(), self.channel.failure_reason())));
        }
        memory.with(|exchange| {
            if !exchange.failure.is_empty() {
                let point = usize::try_from(exchange.point).ok();
                return Err(LoadFailure { point, reason: exchange.failure.get() });
            }
            let mut from = exchange.answer.read();
            answer.into_iter().for_each(|list| from.take(list));
            Ok(())
        })
    }
}

impl UserLoad for RoutineClient {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        self.call(TurnPurpose::Load, |to| points.put(to), [pressure])
    }

    fn reads_motion(&self) -> bool {
        true
    }

    fn reads_magnitude(&self) -> bool {
        false
    }
}

impl UserAmplitude for RoutineClient {
    fn amplitude(&mut self, call: &mut AmplitudeCall<'_>) -> Result<AmplitudeAnswer, LoadFailure> {
        let mut answer = [0.0; 5];
        let AmplitudeCall { name, now, begins, increment, old, properties, variables, sensor_names, sensor_values } =
            call;
        let write = |to: &mut MessageWriter<'_>| {
            put!(to; *name, *now, *begins, *increment, *old, *properties, *sensor_values, sensor_names.len());
            sensor_names.iter().for_each(|name| name.as_str().put(to));
        };
        self.call(TurnPurpose::Amplitude, write, [variables, &mut answer])?;
        let [value, derivative, gives, stop, conclude] = answer;
        Ok(AmplitudeAnswer {
            value,
            derivative: (gives != 0.0).then_some(derivative),
            stop: stop != 0.0,
            conclude_step: conclude != 0.0,
        })
    }
}

impl UserMotion for RoutineClient {
    fn motion(&mut self, call: &MotionCall<'_>) -> Result<f64, LoadFailure> {
        let mut value = [f64::NAN];
        self.call(TurnPurpose::Motion, |to| call.put(to), [&mut value])?;
        Ok(value[0])
    }
}

impl UserMaterial for RoutineClient {
    fn stress(&mut self, call: &MaterialCall<'_>, answer: &mut MaterialAnswer<'_>) -> Result<(), LoadFailure> {
        let MaterialAnswer { stress, state, internal, inelastic } = answer;
        self.call(TurnPurpose::Material, |to| call.put(to), [stress, state, internal, inelastic])
    }
}

impl UserEnergy for RoutineClient {
    fn energy(&mut self, call: &EnergyCall<'_>, answer: &mut EnergyAnswer<'_>) -> Result<(), LoadFailure> {
        let EnergyAnswer { deviatoric, first, second, state } = answer;
        self.call(TurnPurpose::Energy, |to| call.put(to), [deviatoric, first, second, state])
    }
}

impl UserHardening for RoutineClient {
    fn yield_stress(&mut self, call: &HardeningCall<'_>, answer: &mut HardeningAnswer<'_>) -> Result<(), LoadFailure> {
        let HardeningAnswer { stress, by_temperature, slopes, state } = answer;
        self.call(TurnPurpose::Hardening, |to| call.put(to), [stress, by_temperature, slopes, state])
    }
}

impl UserNodalFields for RoutineClient {
    fn nodal_fields(&mut self, call: &NodalFieldCall<'_>, values: &mut [f64]) -> Result<(), LoadFailure> {
        self.call(TurnPurpose::NodalFields, |to| call.put(to), [values])
    }
}

impl UserFriction for RoutineClient {
    fn friction(&mut self, call: &FrictionCall<'_>, forces: &mut [f64], state: &mut [f64]) -> Result<(), LoadFailure> {
        self.call(TurnPurpose::Friction, |to| call.put(to), [forces, state])
    }
}

impl UserLengths for RoutineClient {
    fn lengths(&mut self, call: &LengthCall<'_>, lengths: &mut [f64]) -> Result<(), LoadFailure> {
        self.call(TurnPurpose::Lengths, |to| call.put(to), [lengths])
    }
}

impl UserEvents for RoutineClient {
    fn moment(&mut self, moment: AnalysisMoment, now: &Instant, increment: f64) -> Result<RunAction, LoadFailure> {
        let mut answer = [0.0];
        self.call(TurnPurpose::Moment, |to| put!(to; moment as usize, *now, increment), [&mut answer])?;
        Ok(match answer {
            [1.0] => RunAction::EndStep,
            [2.0] => RunAction::EndAnalysis,
            _ => RunAction::Continue,
        })
    }

    fn restart_follows(&mut self) {
        // If the process has ended, the next call reports it.
        let _ = self.call(TurnPurpose::RestartFollows, |_| (), []);
    }
}
