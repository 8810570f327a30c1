//! Calls as the process of the routines answers them: each reads its arguments and leaves its answer.
//! Never here: processes, the other side of the calls (`callers`).

use super::super::{
    AmplitudeCall, HardeningAnswer, HardeningCall, LengthCall, LoadFailure, LoadPoints, Locked, MaterialAnswer,
    MaterialCall, Moment, MotionCall, Wish,
};
use super::arena::{Content, Purpose};
use super::tape::{Answers, Reader};

/// What calls work with from one to the next.
#[derive(Default)]
pub struct Service {
    answers: Answers,
    sensors: Vec<String>,
}

impl Service {
    /// Calls a routine and leaves its answer, or why it failed.
    pub fn answer(&mut self, purpose: Purpose, content: &mut Content, held: &mut Locked<'_>) {
        let called = self.call(purpose, &mut content.call.read(), held);
        let mut writer = content.answer.write();
        let overrun = self.answers.write(&mut writer);
        let failure = called.err().or_else(|| writer.end().err()).or_else(|| {
            overrun.map(|place| {
                let name = purpose.answers().get(place).copied().unwrap_or_default();
                LoadFailure::new(format!("it wrote past the {}", name))
            })
        });
        content.words.set(failure.as_ref().map_or("", |failure| &failure.reason));
        content.point = failure.and_then(|failure| failure.point).map_or(-1, |point| point as i32);
    }

    fn call(&mut self, purpose: Purpose, from: &mut Reader<'_>, held: &mut Locked<'_>) -> Result<(), LoadFailure> {
        let done = match purpose {
            Purpose::Load => self.load(from, held),
            Purpose::Amplitude => self.amplitude(from, held),
            Purpose::Motion => self.motion(from, held),
            Purpose::Material => self.material(from, held),
            Purpose::Hardening => self.hardening(from, held),
            Purpose::Lengths => self.lengths(from, held),
            Purpose::Moment => self.moment(from, held),
            Purpose::RestartFollows => {
                let [] = self.answers.lists([]);
                held.events.as_deref_mut().map(|events| {
                    events.restart_follows();
                    Ok(())
                })
            }
        };
        done.unwrap_or_else(|| Err(LoadFailure::new("there is no such routine")))
    }

    fn load(&mut self, from: &mut Reader<'_>, held: &mut Locked<'_>) -> Option<Result<(), LoadFailure>> {
        let (now, amplitude, magnitude) = (from.instant(), from.number(), from.number());
        let (load_type, n) = (from.whole() as i32, from.whole() as usize);
        let (surface, coordinates, motion, directions) = (from.text(), from.list(), from.list(), from.list());
        let [value] = self.answers.lists([n]);
        value.fill(f64::NAN);
        let points = LoadPoints {
            surface,
            load_type,
            now,
            amplitude,
            magnitude,
            r: &coordinates[..n],
            z: &coordinates[n..2 * n],
            velocity_r: &motion[..n],
            velocity_z: &motion[n..2 * n],
            // A compiled routine has them in `directions`.
            normal_r: &directions[..n],
            normal_z: &directions[2 * n..3 * n],
            coordinates,
            motion,
            directions,
        };
        Some(held.load.as_deref_mut()?.pressure(&points, value))
    }

    fn amplitude(&mut self, from: &mut Reader<'_>, held: &mut Locked<'_>) -> Option<Result<(), LoadFailure>> {
        let (now, begins) = (from.instant(), from.whole() != 0);
        let (increment, old, sensors) = (from.number(), from.number(), from.whole() as usize);
        let (name, properties, before, sensor_values) = (from.text(), from.list(), from.list(), from.list());
        self.sensors.resize(sensors, String::new());
        for kept in &mut self.sensors {
            let name = from.text();
            if kept != name {
                name.clone_into(kept);
            }
        }
        let [answer, variables] = self.answers.lists([5, before.len()]);
        variables.copy_from_slice(before);
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

    fn motion(&mut self, from: &mut Reader<'_>, held: &mut Locked<'_>) -> Option<Result<(), LoadFailure>> {
        let now = from.instant();
        let [kind, node, dof] = [(); 3].map(|()| from.whole());
        let [amplitude, mass, last, next, r, z] = [(); 6].map(|()| from.number());
        let [state, across] = [(); 2].map(|()| [(); 4].map(|()| from.number()));
        let call = MotionCall {
            set: from.text(),
            kind: kind as i32,
            node: node as i32,
            dof: dof as usize,
            now,
            increments: [last, next],
            amplitude,
            coordinates: [r, z],
            state,
            across,
            mass,
        };
        let [answer] = self.answers.lists([1]);
        Some(held.motion.as_deref_mut()?.motion(&call).map(|value| answer[0] = value))
    }

    fn material(&mut self, from: &mut Reader<'_>, held: &mut Locked<'_>) -> Option<Result<(), LoadFailure>> {
        let (now, dt, [count, variables, fields], name, elements) = from.elements();
        let [properties, coordinates, length, density, strain, spin] = [(); 6].map(|()| from.list());
        let [temperature, field, stretch, gradient] = [(); 4].map(|()| [(); 2].map(|()| from.list()));
        let [stress, state, internal, inelastic] = [(); 4].map(|()| from.list());
        let before = [(); 3].map(|()| from.list());
        let call = MaterialCall {
            name,
            now,
            dt,
            count,
            variables,
            properties,
            coordinates,
            length,
            density,
            strain,
            spin,
            elements,
            temperature,
            fields,
            field,
            stretch,
            gradient,
            stress,
            state,
            internal,
            inelastic,
        };
        let lists = self.answers.lists([stress.len(), before[0].len(), before[1].len(), before[2].len()]);
        let [stress, state, internal, inelastic] = lists;
        stress.fill(f64::NAN);
        state.copy_from_slice(before[0]);
        internal.copy_from_slice(before[1]);
        inelastic.copy_from_slice(before[2]);
        let mut answer = MaterialAnswer { stress, state, internal, inelastic };
        Some(held.material.as_deref_mut()?.stress(&call, &mut answer))
    }

    fn hardening(&mut self, from: &mut Reader<'_>, held: &mut Locked<'_>) -> Option<Result<(), LoadFailure>> {
        let (now, dt, [count, variables, fields], name, elements) = from.elements();
        let properties = from.list();
        let [temperature, field] = [(); 2].map(|()| [(); 2].map(|()| from.list()));
        let [state, strain, rate, before] = [(); 4].map(|()| from.list());
        let call = HardeningCall {
            name,
            now,
            dt,
            count,
            variables,
            fields,
            properties,
            elements,
            temperature,
            field,
            state,
            strain,
            rate,
        };
        let [stress, by_temperature, slopes, state] = self.answers.lists([count, count, 2 * count, before.len()]);
        stress.fill(f64::NAN);
        by_temperature.fill(0.0);
        slopes.fill(0.0);
        state.copy_from_slice(before);
        let mut answer = HardeningAnswer { stress, by_temperature, slopes, state };
        Some(held.hardening.as_deref_mut()?.yield_stress(&call, &mut answer))
    }

    fn lengths(&mut self, from: &mut Reader<'_>, held: &mut Locked<'_>) -> Option<Result<(), LoadFailure>> {
        let (now, dt, [count, variables, fields, corners], name, elements) = from.elements();
        let [properties, coordinates, nodes, field, state, given] = [(); 6].map(|()| from.list());
        let call = LengthCall {
            name,
            now,
            dt,
            count,
            variables,
            fields,
            corners,
            properties,
            elements,
            coordinates,
            nodes,
            field,
            state,
        };
        let [lengths] = self.answers.lists([given.len()]);
        lengths.copy_from_slice(given);
        Some(held.lengths.as_deref_mut()?.lengths(&call, lengths))
    }

    fn moment(&mut self, from: &mut Reader<'_>, held: &mut Locked<'_>) -> Option<Result<(), LoadFailure>> {
        let (now, moment, increment) = (from.instant(), from.whole(), from.number());
        let all = [
            Moment::StartAnalysis,
            Moment::StartStep,
            Moment::SetupIncrement,
            Moment::StartIncrement,
            Moment::EndIncrement,
            Moment::EndStep,
            Moment::EndAnalysis,
        ];
        let moment = all.into_iter().find(|known| *known as u64 == moment)?;
        let [answer] = self.answers.lists([1]);
        let wish = held.events.as_deref_mut()?.moment(moment, &now, increment);
        Some(wish.map(|wish| {
            answer[0] = match wish {
                Wish::Continue => 0.0,
                Wish::EndStep => 1.0,
                Wish::EndAnalysis => 2.0,
            };
        }))
    }
}
