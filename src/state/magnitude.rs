//! Magnitudes of loads and motions that follow functions of time.
//! Never here: what is scaled.

use std::rc::Rc;

use super::Instant;
use super::archive::{Archive, Persist};
use super::limit::Limit;
use crate::kernel::amplitude::{Curve, Track};

/// A function of time that scales a magnitude.
#[derive(Clone, Debug)]
pub enum Shape {
    /// 1 at all times.
    Constant,
    /// Known beforehand.
    Curve(Curve),
    /// Told by a user's routine as the run goes.
    Track(Rc<Track>),
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
    /// Amplitude now, 1 without one.
    pub fn amplitude(&self, now: &Instant) -> f64 {
        match &self.shape {
            Shape::Constant => 1.0,
            Shape::Curve(curve) => curve.value(curves_time(curve, now)),
            Shape::Track(track) => track.value(now.total_time),
        }
    }

    /// Value now.
    pub fn at(&self, now: &Instant) -> f64 {
        self.value * self.amplitude(now)
    }

    /// Rate of change now.
    pub fn rate(&self, now: &Instant) -> f64 {
        self.value
            * match &self.shape {
                Shape::Constant => 0.0,
                Shape::Curve(curve) => curve.slope(curves_time(curve, now)),
                Shape::Track(track) => track.slope(),
            }
    }

    /// Time until the next kink of the amplitude.
    pub fn limit(&self, now: &Instant) -> Limit {
        let Shape::Curve(curve) = &self.shape else { return Limit::NONE };
        let time = curves_time(curve, now);
        Limit { time: curve.next_point(time) - time, jump: false }
    }
}

fn curves_time(curve: &Curve, now: &Instant) -> f64 {
    if curve.total_time { now.total_time } else { now.step_time }
}

/// What a track was told, by the effect that tells it.
pub fn persist_track(track: &Track, archive: &mut Archive<'_>) {
    let mut points = track.points();
    points.persist(archive);
    track.restore(points);
}
