//! Motions of deformable nodes that the user's routine prescribes (`*BOUNDARY, USER`).
//! Never here: how nodes follow them.

use std::rc::Rc;

use crate::constraint::motion::Prescribed;
use crate::element::body::Solid;
use crate::kernel::amplitude::Track;
use crate::state::Instant;
use crate::state::archive::{Archive, Persist, persist_fields};
use crate::state::halt::Halt;
use crate::state::magnitude::Magnitude;
use crate::state::magnitude::persist_track;
use crate::user::{LoadFailure, MotionCall, SharedMotion};

/// The routine asked for the motion of nodes along one axis, node by node.
pub struct NodeMotions {
    /// Node set, upper case.
    pub set: String,
    /// 0 along r, 1 along z.
    pub axis: usize,
    /// What is prescribed.
    pub kind: Prescribed,
    /// Amplitude that the routine is told; it applies it itself.
    pub amplitude: Magnitude,
    /// The routine.
    pub routine: SharedMotion,
    /// Nodes.
    pub nodes: Vec<Asked>,
    /// Length of the increment before.
    pub increment_before: f64,
}

/// One node.
pub struct Asked {
    /// Node of the solver.
    pub node: usize,
    /// User's number.
    pub number: i32,
    /// Where the value goes.
    pub track: Rc<Track>,
    /// Displacement when the step began: what the node follows counts from there.
    pub offset: f64,
}

impl NodeMotions {
    /// Asks for the values at `arrival`, an increment away (0 at the start of a step).
    ///
    /// # Errors
    /// Where the routine fails or gives no finite value; the run halts.
    pub fn ask(&mut self, arrival: &Instant, increment: f64, solid: &Solid) -> Result<(), Halt> {
        let amplitude = self.amplitude.amplitude(arrival);
        for asked in &mut self.nodes {
            let n = asked.node;
            let along = |axis: usize| {
                let motion = [solid.displacement(n)[axis], solid.velocity_now(n)[axis], solid.acceleration[n][axis]];
                [motion[0], motion[1], motion[2], solid.reaction(n, axis)]
            };
            let state = along(self.axis);
            if increment == 0.0 {
                asked.offset = state[0];
            }
            let call = MotionCall {
                set: &self.set,
                kind: self.kind.number(),
                node: asked.number,
                dof: self.axis + 1,
                now: *arrival,
                increments: [self.increment_before, increment],
                amplitude,
                coordinates: solid.place(n),
                state,
                across: along(1 - self.axis),
                mass: solid.mass[n],
            };
            let answer = self.routine.with(|r| r.motion(&call)).and_then(|value| {
                let reason =
                    || LoadFailure::new(format!("it gave the value {value} for degree of freedom {}", call.dof));
                value.is_finite().then_some(value).ok_or_else(reason)
            });
            let what = || format!("the user motion of `{}` at node {}", self.set, asked.number);
            let value = answer.map_err(|failure| failure.halt(&what(), arrival))?;
            // A displacement is the total one; the motion counts from the start of the step.
            let base = if self.kind == Prescribed::Displacement { asked.offset } else { 0.0 };
            asked.track.tell(arrival.total_time, value - base);
        }
        self.increment_before = increment;
        Ok(())
    }
}

impl Persist for Asked {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Asked { node: _, number: _, track, offset } = self;
        persist_track(track, archive);
        offset.persist(archive);
    }
}

impl Persist for NodeMotions {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let NodeMotions { set: _, axis: _, kind: _, amplitude: _, routine: _, nodes, increment_before } = self;
        persist_fields!(archive; nodes.as_mut_slice(), increment_before);
    }
}
