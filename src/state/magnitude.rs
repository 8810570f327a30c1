//! Magnitudes of loads and motions that follow functions of time.
//! Never here: what is scaled.

use super::Instant;
use super::limit::Limit;
use crate::kernel::amplitude::{Curve, SampledAmplitude};

/// An instant, with the functions of time that user amplitudes give.
#[derive(Clone, Copy, Debug)]
pub struct Clock<'a> {
    pub now: Instant,
    /// Functions of time of user amplitudes, by the number of a [`Shape::Told`].
    pub user_amplitudes: &'a [SampledAmplitude],
}

impl Clock<'_> {
    /// A time later.
    #[must_use]
    pub fn later(self, time: f64) -> Self {
        let now = Instant { step_time: self.now.step_time + time, total_time: self.now.total_time + time, ..self.now };
        Clock { now, ..self }
    }
}

/// A function of time that scales a magnitude.
#[derive(Clone, Debug)]
pub enum Shape {
    /// 1 at all times.
    Constant,
    /// Known beforehand.
    Curve(Curve),
    /// Told by a user's routine as the run goes: which of the clock's.
    Told(usize),
}

/// A magnitude that may follow an amplitude.
#[derive(Clone, Debug)]
pub struct Magnitude {
    /// Value at amplitude 1.
    pub value: f64,
    /// Its amplitude.
    pub shape: Shape,
}

impl Magnitude {
    pub fn constant(value: f64) -> Self {
        Magnitude { value, shape: Shape::Constant }
    }

    pub fn amplitude(&self, clock: &Clock<'_>) -> f64 {
        match &self.shape {
            Shape::Constant => 1.0,
            Shape::Curve(curve) => curve.value(curves_time(curve, &clock.now)),
            Shape::Told(index) => clock.user_amplitudes[*index].value(clock.now.total_time),
        }
    }

    pub fn at(&self, clock: &Clock<'_>) -> f64 {
        self.value * self.amplitude(clock)
    }

    pub fn rate(&self, clock: &Clock<'_>) -> f64 {
        self.value
            * match &self.shape {
                Shape::Constant => 0.0,
                Shape::Curve(curve) => curve.slope(curves_time(curve, &clock.now)),
                Shape::Told(index) => clock.user_amplitudes[*index].slope(),
            }
    }

    /// Time until the next kink of the amplitude.
    pub fn limit(&self, clock: &Clock<'_>) -> Limit {
        let Shape::Curve(curve) = &self.shape else { return Limit::NONE };
        let time = curves_time(curve, &clock.now);
        Limit { time: curve.next_point(time) - time, jump: false }
    }

    pub fn bytes(&self) -> usize {
        if let Shape::Curve(curve) = &self.shape { curve.bytes() } else { 0 }
    }
}

fn curves_time(curve: &Curve, now: &Instant) -> f64 {
    if curve.total_time { now.total_time } else { now.step_time }
}
