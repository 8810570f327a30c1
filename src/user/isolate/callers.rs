//! The routines as the run calls them: each writes its arguments, hands the turn over, and takes the answer.
//! Never here: processes, the other side of the calls (`served`).

use std::sync::Arc;

use super::super::{
    AmplitudeAnswer, AmplitudeCall, HardeningAnswer, HardeningCall, LengthCall, LoadFailure, LoadPoints,
    MaterialAnswer, MaterialCall, Moment, MotionCall, UserAmplitude, UserEvents, UserHardening, UserLengths, UserLoad,
    UserMaterial, UserMotion, Wish,
};
use super::arena::Purpose;
use super::door::Door;
use super::tape::{Reader, Writer};
use crate::state::Instant;

/// A routine on the other side of the door.
pub struct Caller {
    door: Arc<Door>,
}

impl Caller {
    /// Of any routine that is there.
    pub fn new(door: &Arc<Door>) -> Caller {
        Caller { door: Arc::clone(door) }
    }

    fn call<T>(
        &self,
        purpose: Purpose,
        write: impl FnOnce(&mut Writer<'_>),
        take: impl FnOnce(&mut Reader<'_>) -> T,
    ) -> Result<T, LoadFailure> {
        let arena = &self.door.arena;
        arena.with(|content| {
            content.purpose = purpose as u32;
            let mut writer = content.call.write();
            write(&mut writer);
            writer.end()
        })?;
        if self.door.turn().is_none() {
            return Err(LoadFailure::new(format!("{} {}", purpose.routine(), self.door.last_words())));
        }
        arena.with(|content| {
            if content.words.is_empty() {
                return Ok(take(&mut content.answer.read()));
            }
            Err(LoadFailure { point: usize::try_from(content.point).ok(), reason: content.words.get() })
        })
    }

    /// Takes the lists of the answer, where some of them are part of the call.
    fn take<const N: usize>(&self, lists: [&mut [f64]; N]) {
        self.door.arena.with(|content| {
            let mut from = content.answer.read();
            lists.into_iter().for_each(|list| from.take(list));
        });
    }
}

impl UserLoad for Caller {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        let write = |to: &mut Writer<'_>| {
            to.instant(&points.now);
            to.number(points.amplitude);
            to.number(points.magnitude);
            to.whole(points.load_type as u64);
            to.whole(points.r.len() as u64);
            to.text(points.surface);
            to.list(points.coordinates);
            to.list(points.motion);
            to.list(points.directions);
        };
        self.call(Purpose::Load, write, |answer| answer.take(pressure))
    }

    fn reads_motion(&self) -> bool {
        true
    }
}

impl UserAmplitude for Caller {
    fn amplitude(&mut self, call: &mut AmplitudeCall<'_>) -> Result<AmplitudeAnswer, LoadFailure> {
        let mut answer = [0.0; 5];
        let AmplitudeCall { name, now, begins, increment, old, properties, variables, sensor_names, sensor_values } =
            call;
        let write = |to: &mut Writer<'_>| {
            to.instant(now);
            to.whole(u64::from(*begins));
            to.number(*increment);
            to.number(*old);
            to.whole(sensor_names.len() as u64);
            to.text(name);
            to.list(properties);
            to.list(variables);
            to.list(sensor_values);
            sensor_names.iter().for_each(|name| to.text(name));
        };
        self.call(Purpose::Amplitude, write, |_| ())?;
        self.take([&mut answer, &mut **variables]);
        let [value, derivative, gives, stop, conclude] = answer;
        Ok(AmplitudeAnswer {
            value,
            derivative: (gives != 0.0).then_some(derivative),
            stop: stop != 0.0,
            conclude_step: conclude != 0.0,
        })
    }
}

impl UserMotion for Caller {
    fn motion(&mut self, call: &MotionCall<'_>) -> Result<f64, LoadFailure> {
        let MotionCall { set, kind, node, dof, now, increments, amplitude, coordinates, state, across, mass } = call;
        let write = |to: &mut Writer<'_>| {
            to.instant(now);
            [*kind as u64, *node as u64, *dof as u64].into_iter().for_each(|whole| to.whole(whole));
            [*amplitude, *mass].into_iter().chain(*increments).chain(*coordinates).for_each(|number| to.number(number));
            state.iter().chain(across).for_each(|number| to.number(*number));
            to.text(set);
        };
        self.call(Purpose::Motion, write, |from| from.list().first().copied().unwrap_or(f64::NAN))
    }
}

impl UserMaterial for Caller {
    fn stress(&mut self, call: &MaterialCall<'_>, answer: &mut MaterialAnswer<'_>) -> Result<(), LoadFailure> {
        let state = &answer.state[..];
        let energies = [&answer.internal[..], &answer.inelastic[..]];
        let write = |to: &mut Writer<'_>| {
            let counts = [call.count, call.variables, call.fields];
            to.elements(&call.now, call.dt, &counts, call.name, call.elements);
            let lists = [call.properties, call.coordinates, call.length, call.density, call.strain, call.spin];
            let pairs = [call.temperature, call.field, call.stretch, call.gradient].into_iter().flatten();
            let old = [call.stress, call.state, call.internal, call.inelastic];
            lists.into_iter().chain(pairs).chain(old).for_each(|list| to.list(list));
            [state, energies[0], energies[1]].into_iter().for_each(|list| to.list(list));
        };
        self.call(Purpose::Material, write, |_| ())?;
        let MaterialAnswer { stress, state, internal, inelastic } = answer;
        self.take([stress, state, internal, inelastic]);
        Ok(())
    }
}

impl UserHardening for Caller {
    fn yield_stress(&mut self, call: &HardeningCall<'_>, answer: &mut HardeningAnswer<'_>) -> Result<(), LoadFailure> {
        let HardeningAnswer { stress, by_temperature, slopes, state } = answer;
        let write = |to: &mut Writer<'_>| {
            let counts = [call.count, call.variables, call.fields];
            to.elements(&call.now, call.dt, &counts, call.name, call.elements);
            let pairs = [call.temperature, call.field].into_iter().flatten();
            let lists = [call.state, call.strain, call.rate, state];
            [call.properties].into_iter().chain(pairs).chain(lists).for_each(|list| to.list(list));
        };
        self.call(Purpose::Hardening, write, |_| ())?;
        self.take([stress, by_temperature, slopes, state]);
        Ok(())
    }
}

impl UserLengths for Caller {
    fn lengths(&mut self, call: &LengthCall<'_>, lengths: &mut [f64]) -> Result<(), LoadFailure> {
        let given = &lengths[..];
        let write = |to: &mut Writer<'_>| {
            let counts = [call.count, call.variables, call.fields, call.corners];
            to.elements(&call.now, call.dt, &counts, call.name, call.elements);
            let lists = [call.properties, call.coordinates, call.nodes, call.field, call.state, given];
            lists.into_iter().for_each(|list| to.list(list));
        };
        self.call(Purpose::Lengths, write, |_| ())?;
        self.take([lengths]);
        Ok(())
    }
}

impl UserEvents for Caller {
    fn moment(&mut self, moment: Moment, now: &Instant, increment: f64) -> Result<Wish, LoadFailure> {
        let write = |to: &mut Writer<'_>| {
            to.instant(now);
            to.whole(moment as u64);
            to.number(increment);
        };
        self.call(Purpose::Moment, write, |from| match from.list().first() {
            Some(1.0) => Wish::EndStep,
            Some(2.0) => Wish::EndAnalysis,
            _ => Wish::Continue,
        })
    }

    fn restart_follows(&mut self) {
        // That the process is gone is told by the call that follows.
        let _ = self.call(Purpose::RestartFollows, |_| (), |_| ());
    }
}
