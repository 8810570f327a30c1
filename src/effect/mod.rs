//! Effects: what a deck asks for, one file each. An effect that is not asked for is never constructed.
//! Never here: names of other effects; deck words (an effect carries an opaque cause that only the ledger reads).

pub mod cavity;
pub mod concentrated;
pub mod gravity;
pub mod motion;
pub mod pressure;
pub mod solid;
pub mod user_amplitude;
pub mod user_load;
pub mod user_motion;

use std::rc::Rc;

use crate::kernel::amplitude::{Curve, Track};
use crate::state::archive::{Archive, Persist};
use crate::state::{BodyState, Instant};
use crate::user::{LoadFailure, Wish};

/// Index into the ledger: the only thing an effect knows of the deck.
pub type Cause = usize;

/// Which energy a force's work is booked under.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Account {
    /// Work of prescribed loads and motions (`ALLWK`).
    Work,
    /// Dissipated by friction (`ALLFD`).
    Friction,
    /// Dissipated by opening the cavity (`ALLCD` is creep in ABAQUS, so `ALLCAV`).
    Cavity,
    /// Of what deforms on a body that it is tied to: passed on within the scene, so no account of its own.
    Tie,
}

/// A generalised force of one effect on one body, and the account of its work.
#[derive(Clone, Copy, Debug)]
pub struct Slot {
    /// Body index.
    pub body: usize,
    /// Where its work is booked.
    pub account: Account,
}

/// Why a run stops before its end.
#[derive(Clone, Debug, PartialEq)]
pub struct Halt {
    /// Stable code (`R…`).
    pub code: &'static str,
    /// What happened, with the place in the scene.
    pub reason: String,
}

impl Halt {
    /// A user's routine failed; `what` names routine and place.
    pub fn of_routine(what: &str, now: &Instant, failure: &LoadFailure) -> Halt {
        let reason = format!(
            "{what} failed in step {}, increment {}, total time {:e}: {}",
            now.step, now.increment, now.total_time, failure.reason
        );
        Halt { code: "R201", reason }
    }
}

/// How far in time an effect lets an increment go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// From now on.
    pub time: f64,
    /// Whether the force jumps there: central differences then start afresh.
    pub jump: bool,
}

impl Limit {
    /// No limit.
    pub const NONE: Limit = Limit { time: f64::INFINITY, jump: false };

    /// The nearer of two.
    #[must_use]
    pub fn nearer(self, other: Limit) -> Limit {
        if other.time < self.time { other } else { self }
    }
}

/// What a surface effect shows in a frame, one entry a facet.
#[derive(Clone, Debug, Default)]
pub struct FacetFields {
    /// Element index of each facet.
    pub elements: Vec<usize>,
    /// Pressure, area mean.
    pub pressure: Vec<f64>,
    /// Velocity along the outward normal.
    pub normal_velocity: Vec<f64>,
    /// Number (from 1) of the layer that takes the largest part of the facet's area; 0 outside any.
    pub layer: Vec<f64>,
}

/// A force of the scene.
pub trait Force: Persist {
    /// What asked for it.
    fn cause(&self) -> Cause;

    /// The generalised forces it will write.
    fn slots(&self) -> Vec<Slot>;

    /// Writes its generalised forces along z at this instant.
    ///
    /// # Errors
    /// Where no finite force can be given; the run halts.
    fn evaluate(&mut self, now: &Instant, bodies: &[BodyState], out: &mut [f64]) -> Result<(), Halt>;

    /// How far the next increment may go.
    fn limit(&self, _now: &Instant, _bodies: &[BodyState]) -> Limit {
        Limit::NONE
    }

    /// Whether it opposes motion and vanishes at rest, so that it can stop a body but never push it back.
    fn resists(&self) -> bool {
        false
    }

    /// Whether it reads velocity, so that an instant of rest must be met exactly.
    fn reads_velocity(&self) -> bool {
        false
    }

    /// What it shows on facets in a frame.
    fn facet_fields(&self, _bodies: &[BodyState]) -> Option<FacetFields> {
        None
    }

    /// Names and bytes of the arrays it holds.
    fn arrays(&self) -> Vec<(&'static str, usize)> {
        Vec::new()
    }
}

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

/// Something that a user's routine is asked once an increment, before the motion arrives at its end.
pub trait Asking: Persist {
    /// Asks for the value at `arrival`, an increment away (0 at the start of a step).
    ///
    /// # Errors
    /// Where the routine fails or gives no finite value; the run halts.
    fn ask(&mut self, arrival: &Instant, increment: f64, bodies: &[BodyState]) -> Result<Wish, Halt>;
}

/// What a track was told, by the effect that tells it.
fn persist_track(track: &Track, archive: &mut Archive<'_>) {
    let mut points = track.points();
    points.persist(archive);
    track.restore(points);
}
