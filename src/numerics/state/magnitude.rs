//! Magnitudes of loads and motions as functions of time.

use super::Instant;
use super::limit::IncrementLimit;
use crate::kernel::amplitude::{AmplitudeCurve, SampledAmplitude};
use crate::kernel::lists::{Memory, MemoryUse};

/// Current time, with the amplitudes that user subroutines define.
#[derive(Clone, Copy, Debug)]
pub struct AmplitudeClock<'a> {
    pub now: Instant,
    /// User amplitudes, by the index of [`TimeFunction::Sampled`].
    pub user_amplitudes: &'a [SampledAmplitude],
}

impl AmplitudeClock<'_> {
    /// Returns the clock advanced by a time.
    #[must_use]
    pub fn later(self, time: f64) -> Self {
        let now = Instant { step_time: self.now.step_time + time, total_time: self.now.total_time + time, ..self.now };
        AmplitudeClock { now, ..self }
    }
}

/// A function of time that scales a magnitude.
#[derive(Clone, Debug)]
pub enum TimeFunction {
    /// 1 at all times.
    Constant,
    /// Amplitude defined in the deck.
    Curve(AmplitudeCurve),
    /// User amplitude sampled during the run: index into those of the clock.
    Sampled(usize),
}

/// A magnitude scaled by an amplitude.
#[derive(Clone, Debug, Memory)]
pub struct Magnitude {
    /// Value at amplitude 1.
    pub value: f64,
    /// Amplitude: factor of the value as a function of time.
    pub shape: TimeFunction,
}

impl Memory for TimeFunction {
    fn memory(&self) -> MemoryUse {
        if let TimeFunction::Curve(curve) = self { curve.memory() } else { MemoryUse::default() }
    }
}

impl Magnitude {
    pub fn constant(value: f64) -> Self {
        Magnitude { value, shape: TimeFunction::Constant }
    }

    /// Returns the amplitude at a time.
    pub fn amplitude(&self, clock: &AmplitudeClock<'_>) -> f64 {
        match &self.shape {
            TimeFunction::Constant => 1.0,
            TimeFunction::Curve(curve) => curve.value(curves_time(curve, &clock.now)),
            TimeFunction::Sampled(index) => clock.user_amplitudes[*index].value(clock.now.total_time),
        }
    }

    /// Returns the magnitude at a time.
    pub fn at(&self, clock: &AmplitudeClock<'_>) -> f64 {
        self.value * self.amplitude(clock)
    }

    /// Returns the time derivative of the magnitude.
    pub fn rate(&self, clock: &AmplitudeClock<'_>) -> f64 {
        self.value
            * match &self.shape {
                TimeFunction::Constant => 0.0,
                TimeFunction::Curve(curve) => curve.slope(curves_time(curve, &clock.now)),
                TimeFunction::Sampled(index) => clock.user_amplitudes[*index].slope(),
            }
    }

    /// Returns the time until the next kink of the amplitude.
    pub fn limit(&self, clock: &AmplitudeClock<'_>) -> IncrementLimit {
        let TimeFunction::Curve(curve) = &self.shape else { return IncrementLimit::NONE };
        let time = curves_time(curve, &clock.now);
        IncrementLimit { time: curve.next_point(time) - time, jump: false }
    }
}

fn curves_time(curve: &AmplitudeCurve, now: &Instant) -> f64 {
    if curve.total_time { now.total_time } else { now.step_time }
}
