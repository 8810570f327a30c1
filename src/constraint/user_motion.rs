//! A motion prescribed by the user's routine (`*BOUNDARY, USER`).
//! Never here: how a body follows it.

use std::rc::Rc;

use crate::constraint::motion::Prescribed;
use crate::kernel::amplitude::Track;
use crate::load::Asking;
use crate::state::archive::{Archive, Persist, persist_fields};
use crate::state::halt::Halt;
use crate::state::magnitude::Magnitude;
use crate::state::magnitude::persist_track;
use crate::state::{BodyState, Instant};
use crate::user::{LoadFailure, MotionCall, SharedMotion, Wish};

/// The routine asked for the motion of one body.
pub struct UserMotion {
    /// Node set, upper case.
    pub set: String,
    /// User's number of the reference node.
    pub node: i32,
    /// Body.
    pub body: usize,
    /// What is prescribed.
    pub kind: Prescribed,
    /// Amplitude that the routine is told; it applies it itself.
    pub amplitude: Magnitude,
    /// Coordinates of the reference node at the start.
    pub start: [f64; 2],
    /// Displacement of the body when the step began: the motion's own displacement counts from there.
    pub offset: f64,
    /// The routine.
    pub routine: SharedMotion,
    /// Where the value goes.
    pub track: Rc<Track>,
    /// Length of the increment before.
    pub increment_before: f64,
}

impl Asking for UserMotion {
    fn ask(&mut self, arrival: &Instant, increment: f64, bodies: &[BodyState]) -> Result<Wish, Halt> {
        let body = &bodies[self.body];
        if increment == 0.0 {
            self.offset = body.displacement;
        }
        let call = MotionCall {
            set: &self.set,
            kind: self.kind.number(),
            node: self.node,
            dof: 2,
            now: *arrival,
            increments: [self.increment_before, increment],
            amplitude: self.amplitude.amplitude(arrival),
            coordinates: [self.start[0], self.start[1] + body.displacement],
            state: [body.displacement, body.velocity, body.acceleration, body.reaction],
            across: [0.0; 4],
            mass: body.mass,
        };
        self.increment_before = increment;
        let answer = self.routine.with(|r| r.motion(&call)).and_then(|value| {
            let reason = || LoadFailure::new(format!("it gave the value {value} for degree of freedom 2"));
            value.is_finite().then_some(value).ok_or_else(reason)
        });
        let what = || format!("the user motion of `{}`", self.set);
        let value = answer.map_err(|failure| failure.halt(&what(), arrival))?;
        // A displacement is the total one; the motion counts from the start of the step.
        let base = if self.kind == Prescribed::Displacement { self.offset } else { 0.0 };
        self.track.tell(arrival.total_time, value - base);
        Ok(Wish::Continue)
    }
}

impl Persist for UserMotion {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let UserMotion {
            set: _,
            node: _,
            body: _,
            kind: _,
            amplitude: _,
            start: _,
            offset,
            routine: _,
            track,
            increment_before,
        } = self;
        persist_fields!(archive; offset, increment_before);
        persist_track(track, archive);
    }
}
