//! The routines as the run calls them: each call writes its arguments, hands the turn over, and takes the answer.
//! Never here: processes, the other side of the calls (`server`).

use std::sync::Arc;

use super::super::{
    AmplitudeAnswer, AmplitudeCall, AnalysisMoment, HardeningAnswer, HardeningCall, LengthCall, LoadFailure,
    LoadPoints, MaterialAnswer, MaterialCall, MotionCall, RunAction, UserAmplitude, UserEvents, UserHardening,
    UserLengths, UserLoad, UserMaterial, UserMotion,
};
use super::channel::Channel;
use super::message::{Field as _, Writer, put};
use super::shared_memory::Purpose;
use crate::state::Instant;

/// A routine on the other side of the channel.
pub struct Client {
    channel: Arc<Channel>,
}

impl Client {
    /// A client of any routine.
    pub fn new(channel: &Arc<Channel>) -> Client {
        Client { channel: Arc::clone(channel) }
    }

    /// Calls a routine with its arguments and the lists of its answer, which it changes.
    fn call<const N: usize>(
        &self,
        purpose: Purpose,
        write: impl FnOnce(&mut Writer<'_>),
        answer: [&mut [f64]; N],
    ) -> Result<(), LoadFailure> {
        let memory = &self.channel.memory;
        memory.with(|exchange| {
            exchange.purpose = purpose as u32;
            let mut to = exchange.call.write();
            write(&mut to);
            answer.iter().for_each(|list| to.list(list));
            to.end()
        })?;
        if self.channel.turn().is_none() {
            return Err(LoadFailure::new(format!("{} {}", purpose.routine(), self.channel.last_words())));
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

impl UserLoad for Client {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        self.call(Purpose::Load, |to| points.put(to), [pressure])
    }

    fn reads_motion(&self) -> bool {
        true
    }
}

impl UserAmplitude for Client {
    fn amplitude(&mut self, call: &mut AmplitudeCall<'_>) -> Result<AmplitudeAnswer, LoadFailure> {
        let mut answer = [0.0; 5];
        let AmplitudeCall { name, now, begins, increment, old, properties, variables, sensor_names, sensor_values } =
            call;
        let write = |to: &mut Writer<'_>| {
            put!(to; *name, *now, *begins, *increment, *old, *properties, *sensor_values, sensor_names.len());
            sensor_names.iter().for_each(|name| name.as_str().put(to));
        };
        self.call(Purpose::Amplitude, write, [variables, &mut answer])?;
        let [value, derivative, gives, stop, conclude] = answer;
        Ok(AmplitudeAnswer {
            value,
            derivative: (gives != 0.0).then_some(derivative),
            stop: stop != 0.0,
            conclude_step: conclude != 0.0,
        })
    }
}

impl UserMotion for Client {
    fn motion(&mut self, call: &MotionCall<'_>) -> Result<f64, LoadFailure> {
        let mut value = [f64::NAN];
        self.call(Purpose::Motion, |to| call.put(to), [&mut value])?;
        Ok(value[0])
    }
}

impl UserMaterial for Client {
    fn stress(&mut self, call: &MaterialCall<'_>, answer: &mut MaterialAnswer<'_>) -> Result<(), LoadFailure> {
        let MaterialAnswer { stress, state, internal, inelastic } = answer;
        self.call(Purpose::Material, |to| call.put(to), [stress, state, internal, inelastic])
    }
}

impl UserHardening for Client {
    fn yield_stress(&mut self, call: &HardeningCall<'_>, answer: &mut HardeningAnswer<'_>) -> Result<(), LoadFailure> {
        let HardeningAnswer { stress, by_temperature, slopes, state } = answer;
        self.call(Purpose::Hardening, |to| call.put(to), [stress, by_temperature, slopes, state])
    }
}

impl UserLengths for Client {
    fn lengths(&mut self, call: &LengthCall<'_>, lengths: &mut [f64]) -> Result<(), LoadFailure> {
        self.call(Purpose::Lengths, |to| call.put(to), [lengths])
    }
}

impl UserEvents for Client {
    fn moment(&mut self, moment: AnalysisMoment, now: &Instant, increment: f64) -> Result<RunAction, LoadFailure> {
        let mut answer = [0.0];
        self.call(Purpose::Moment, |to| put!(to; moment as usize, *now, increment), [&mut answer])?;
        Ok(match answer {
            [1.0] => RunAction::EndStep,
            [2.0] => RunAction::EndAnalysis,
            _ => RunAction::Continue,
        })
    }

    fn restart_follows(&mut self) {
        // If the process is gone, the next call says so.
        let _ = self.call(Purpose::RestartFollows, |_| (), []);
    }
}
