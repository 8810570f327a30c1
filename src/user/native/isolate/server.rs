//! Calls as the process of the routines answers them: each reads its arguments and leaves its answer.
//! Never here: processes, the other side of the calls (`client`).

use super::super::subroutines::{Kind, interface};
use super::super::{
    AmplitudeCall, AnalysisMoment, HardeningAnswer, HardeningCall, LengthCall, LoadFailure, LoadPoints, Locked,
    MaterialAnswer, MaterialCall, MotionCall,
};
use super::message::{Answers, Field as _, Reader, get};
use super::shared_memory::{Exchange, Purpose};

/// Buffers for the calls.
#[derive(Default)]
pub struct Server {
    answers: Answers,
    sensors: Vec<String>,
}

impl Server {
    /// Calls a routine and leaves its answer, or why it failed.
    pub fn answer(&mut self, purpose: Purpose, exchange: &mut Exchange, held: &mut Locked<'_>) {
        let called = self.call(purpose, &mut exchange.call.read(), held);
        let called = called.unwrap_or_else(|| Err(LoadFailure::new("there is no such routine")));
        let mut writer = exchange.answer.write();
        let overrun = self.answers.write(&mut writer);
        let failure = called.err().or_else(|| writer.end().err()).or_else(|| {
            let name = interface(purpose.routine())?.arguments_of(Kind::RealResult).nth(overrun?)?;
            Some(LoadFailure::new(format!("it wrote past the end of its argument {name}")))
        });
        exchange.failure.set(failure.as_ref().map_or("", |failure| &failure.reason));
        exchange.point = failure.and_then(|failure| failure.point).map_or(-1, |point| point as i32);
    }

    /// Calls a routine; `None` if there is none.
    fn call(
        &mut self,
        purpose: Purpose,
        from: &mut Reader<'_>,
        held: &mut Locked<'_>,
    ) -> Option<Result<(), LoadFailure>> {
        let answers = &mut self.answers;
        Some(match purpose {
            Purpose::Load => {
                let points = LoadPoints::get(from);
                let [value] = answers.take(from);
                held.load.as_deref_mut()?.pressure(&points, value)
            }
            Purpose::Amplitude => return self.amplitude(from, held),
            Purpose::Motion => {
                let call = MotionCall::get(from);
                let [answer] = answers.take(from);
                held.motion.as_deref_mut()?.motion(&call).map(|value| answer[0] = value)
            }
            Purpose::Material => {
                let call = MaterialCall::get(from);
                let [stress, state, internal, inelastic] = answers.take(from);
                let mut answer = MaterialAnswer { stress, state, internal, inelastic };
                held.material.as_deref_mut()?.stress(&call, &mut answer)
            }
            Purpose::Hardening => {
                let call = HardeningCall::get(from);
                let [stress, by_temperature, slopes, state] = answers.take(from);
                let mut answer = HardeningAnswer { stress, by_temperature, slopes, state };
                held.hardening.as_deref_mut()?.yield_stress(&call, &mut answer)
            }
            Purpose::Lengths => {
                let call = LengthCall::get(from);
                let [lengths] = answers.take(from);
                held.lengths.as_deref_mut()?.lengths(&call, lengths)
            }
            Purpose::Moment => {
                let moment = usize::get(from);
                get!(from; now, increment);
                let [answer] = answers.take(from);
                let wish = held.events.as_deref_mut()?.moment(*AnalysisMoment::ALL.get(moment)?, &now, increment);
                wish.map(|wish| answer[0] = f64::from(wish as u8))
            }
            Purpose::RestartFollows => {
                let [] = answers.take(from);
                held.events.as_deref_mut()?.restart_follows();
                Ok(())
            }
        })
    }

    fn amplitude(&mut self, from: &mut Reader<'_>, held: &mut Locked<'_>) -> Option<Result<(), LoadFailure>> {
        get!(from; name, now, begins, increment, old, properties, sensor_values, sensors);
        self.sensors.resize(sensors, String::new());
        for known in &mut self.sensors {
            let name = <&str>::get(from);
            if known != name {
                name.clone_into(known);
            }
        }
        let [variables, answer] = self.answers.take(from);
        let sensor_names = &self.sensors[..];
        let mut call =
            AmplitudeCall { name, now, begins, increment, old, properties, variables, sensor_names, sensor_values };
        let called = held.amplitude.as_deref_mut()?.amplitude(&mut call);
        Some(called.map(|given| {
            let (derivative, gives) = given.derivative.map_or((0.0, 0.0), |derivative| (derivative, 1.0));
            let flags = [given.stop, given.conclude_step].map(|flag| f64::from(u8::from(flag)));
            answer.copy_from_slice(&[given.value, derivative, gives, flags[0], flags[1]]);
        }))
    }
}
