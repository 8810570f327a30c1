//! A prescribed motion of a body along z (`*BOUNDARY` on its reference node).
//! Never here: forces.

use crate::state::EffectId;
use crate::state::Instant;
use crate::state::archive::{Archive, Persist};
use crate::state::magnitude::Magnitude;

/// What is prescribed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Prescribed {
    /// Displacement since the start of the step.
    Displacement,
    /// Velocity.
    Velocity,
    /// Acceleration.
    Acceleration,
}

impl Prescribed {
    /// As a user's routine is told: the order of the time derivative (`jTyp` of VDISP).
    pub fn number(self) -> i32 {
        match self {
            Prescribed::Displacement => 0,
            Prescribed::Velocity => 1,
            Prescribed::Acceleration => 2,
        }
    }
}

/// A motion that a body follows whatever forces act; the force needed is its reaction.
#[derive(Clone, Debug)]
pub struct Motion {
    /// What asked for it.
    pub cause: EffectId,
    /// The body it moves.
    pub body: usize,
    /// What is prescribed.
    pub kind: Prescribed,
    /// How much.
    pub magnitude: Magnitude,
    /// Displacement of the body at the start of the step, to which a prescribed displacement adds.
    pub start: f64,
}

impl Motion {
    /// Velocity and acceleration now, given the velocity the body has.
    pub fn rates(&self, now: &Instant, velocity: f64) -> [f64; 2] {
        match self.kind {
            Prescribed::Displacement => [self.magnitude.rate(now), 0.0],
            Prescribed::Velocity => [self.magnitude.at(now), self.magnitude.rate(now)],
            Prescribed::Acceleration => [velocity, self.magnitude.at(now)],
        }
    }

    /// The mid-increment velocity that carries the body over an increment from displacement `u` and velocity `v`.
    pub fn velocity_over(&self, now: &Instant, increment: f64, u: f64, v: f64) -> f64 {
        self.kind.velocity_over(&self.magnitude, now, increment, u - self.start, [v, 0.5 * increment])
    }
}

impl Prescribed {
    /// The mid-increment velocity that carries what moves over an increment. It has come as far as `moved` since the start
    /// of the step; an acceleration acts on a velocity over a time, given with it.
    pub fn velocity_over(
        self,
        magnitude: &Magnitude,
        now: &Instant,
        increment: f64,
        moved: f64,
        [velocity, time]: [f64; 2],
    ) -> f64 {
        let later = |time: f64| Instant { step_time: now.step_time + time, total_time: now.total_time + time, ..*now };
        match self {
            Prescribed::Displacement => (magnitude.at(&later(increment)) - moved) / increment,
            Prescribed::Velocity => magnitude.at(&later(0.5 * increment)),
            Prescribed::Acceleration => velocity + time * magnitude.at(now),
        }
    }
}

impl Persist for Motion {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Motion { cause: _, body: _, kind: _, magnitude: _, start } = self;
        start.persist(archive);
    }
}
