//! Calls in the process of the user subroutines: each reads its arguments and writes its results. The other side is in
//! `client`.

use super::super::subroutines::{ArgumentKind, interface};
use super::super::{
    AmplitudeCall, AnalysisMoment, EnergyAnswer, EnergyCall, FrictionCall, HardeningAnswer, HardeningCall, LengthCall,
    LoadFailure, LoadPoints, LockedRoutines, MaterialAnswer, MaterialCall, MotionCall, NodalFieldCall, bounds_advice,
};
use super::message::{AnswerLists, MessageField as _, MessageReader, get};
use super::shared_memory::{CallExchange, TurnPurpose};

/// Executes calls; holds their buffers.
#[derive(Default)]
pub struct RoutineServer {
    answers: AnswerLists,
    sensors: Vec<String>,
}

impl RoutineServer {
    /// Calls a subroutine and writes its results, or the reason of its failure.
    pub fn answer(&mut self, purpose: TurnPurpose, exchange: &mut CallExchange, routines: &mut LockedRoutines) {
        let called = self.call(purpose, &mut exchange.call.read(), routines);
        let called = called.unwrap_or_else(|| Err(LoadFailure::new("the subroutine is not defined")));
        let mut writer = exchange.answer.write();
        let overrun = self.answers.write(&mut writer);
        let failure = called.err().or_else(|| writer.end().err()).or_else(|| {
            let name = interface(purpose.routine())?.arguments_of(ArgumentKind::RealResult).nth(overrun?)?;
            Some(LoadFailure::new(format!("it wrote past the end of its argument {name}{}", bounds_advice(name))))
        });
        exchange.failure.set(failure.as_ref().map_or("", |failure| &failure.reason));
        exchange.point = failure.and_then(|failure| failure.point).map_or(-1, |point| point as i32);
    }

    /// Calls a subroutine; `None` if it is not defined.
    fn call(
        &mut self,
        purpose: TurnPurpose,
        from: &mut MessageReader<'_>,
        routines: &mut LockedRoutines,
    ) -> Option<Result<(), LoadFailure>> {
        let answers = &mut self.answers;
        Some(match purpose {
            TurnPurpose::Load => {
                let points = LoadPoints::get(from);
                let [value] = answers.take(from);
                routines.load.as_deref_mut()?.pressure(&points, value)
            }
            TurnPurpose::Amplitude => return self.amplitude(from, routines),
            TurnPurpose::Motion => {
                let call = MotionCall::get(from);
                let [answer] = answers.take(from);
                routines.motion.as_deref_mut()?.motion(&call).map(|value| answer[0] = value)
            }
            TurnPurpose::Material => {
                let call = MaterialCall::get(from);
                let [stress, state, internal, inelastic] = answers.take(from);
                let mut answer = MaterialAnswer { stress, state, internal, inelastic };
                routines.material.as_deref_mut()?.stress(&call, &mut answer)
            }
            TurnPurpose::Energy => {
                let call = EnergyCall::get(from);
                let [deviatoric, first, second, state] = answers.take(from);
                let mut answer = EnergyAnswer { deviatoric, first, second, state };
                routines.energy.as_deref_mut()?.energy(&call, &mut answer)
            }
            TurnPurpose::Hardening => {
                let call = HardeningCall::get(from);
                let [stress, by_temperature, slopes, state] = answers.take(from);
                let mut answer = HardeningAnswer { stress, by_temperature, slopes, state };
                routines.hardening.as_deref_mut()?.yield_stress(&call, &mut answer)
            }
            TurnPurpose::NodalFields => {
                let call = NodalFieldCall::get(from);
                let [values] = answers.take(from);
                routines.nodal_fields.as_deref_mut()?.nodal_fields(&call, values)
            }
            TurnPurpose::Friction => {
                let call = FrictionCall::get(from);
                let [forces, state] = answers.take(from);
                routines.friction.as_deref_mut()?.friction(&call, forces, state)
            }
            TurnPurpose::Lengths => {
                let call = LengthCall::get(from);
                let [lengths] = answers.take(from);
                routines.lengths.as_deref_mut()?.lengths(&call, lengths)
            }
            TurnPurpose::Moment => {
                let moment = usize::get(from);
                get!(from; now, increment);
                let [answer] = answers.take(from);
                let action = routines.events.as_deref_mut()?.moment(*AnalysisMoment::ALL.get(moment)?, &now, increment);
                action.map(|action| answer[0] = f64::from(action as u8))
            }
            TurnPurpose::RestartFollows => {
                let [] = answers.take(from);
                routines.events.as_deref_mut()?.restart_follows();
                Ok(())
            }
        })
    }

    fn amplitude(
        &mut self,
        from: &mut MessageReader<'_>,
        routines: &mut LockedRoutines,
    ) -> Option<Result<(), LoadFailure>> {
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
        let called = routines.amplitude.as_deref_mut()?.amplitude(&mut call);
        Some(called.map(|given| {
            let (derivative, gives) = given.derivative.map_or((0.0, 0.0), |derivative| (derivative, 1.0));
            let flags = [given.stop, given.conclude_step].map(|flag| f64::from(u8::from(flag)));
            answer.copy_from_slice(&[given.value, derivative, gives, flags[0], flags[1]]);
        }))
    }
}
