//! Motions prescribed by the user's routine (`*BOUNDARY, USER`): what it is asked, degree of freedom by degree of freedom.
//! Never here: how bodies and nodes follow them.

use super::motion::Prescribed;
use crate::kernel::amplitude::SampledAmplitude;
use crate::kernel::lists::heap_bytes;
use crate::state::Instant;
use crate::state::archive::persist_struct;
use crate::state::dofs::{Dof, Dofs};
use crate::state::halt::Halt;
use crate::state::magnitude::{Clock, Magnitude};
use crate::user::{LoadFailure, Locked, MotionCall};

/// The motion of a set along one axis.
#[derive(Clone, Debug)]
pub struct UserMotion {
    /// Node set, upper case.
    pub set: String,
    pub kind: Prescribed,
    /// Amplitude that the subroutine receives and applies itself.
    pub amplitude: Magnitude,
    pub asked: Vec<UserDof>,
    /// Index of the first among the user amplitudes.
    pub first: usize,
    pub increment_before: f64,
    /// Whether it has been asked before: what its displacements count from stays as it is.
    pub has_begun: bool,
}

#[derive(Clone, Debug)]
pub struct UserDof {
    pub dof: Dof,
    pub number: i32,
    /// Coordinates of a rigid body's reference node at the start.
    pub reference: [f64; 2],
    /// Displacement when the motion began: what follows it counts from there.
    pub offset: f64,
}

impl UserMotion {
    /// Asks for the values at `arrival`, an increment away (0 at the start of a step), given the reactions.
    ///
    /// # Errors
    /// Where the routine fails or gives no finite value; the run halts.
    pub fn call(
        &mut self,
        arrival: &Instant,
        increment: f64,
        dofs: &Dofs,
        reaction: &dyn Fn(Dof) -> f64,
        user_amplitudes: &mut [SampledAmplitude],
        user: &mut Locked<'_>,
    ) -> Result<(), Halt> {
        let Some(routine) = user.motion.as_deref_mut() else { return Ok(()) };
        let amplitude = self.amplitude.amplitude(&Clock { now: *arrival, user_amplitudes });
        for (i, asked) in self.asked.iter_mut().enumerate() {
            let state_of = |dof| [dofs.displacement(dof), dofs.velocity(dof), dofs.acceleration(dof), reaction(dof)];
            let state = state_of(asked.dof);
            if !self.has_begun {
                asked.offset = state[0];
            }
            let (axis, coordinates, across) = match asked.dof {
                Dof::Body(_) => (1, [asked.reference[0], asked.reference[1] + state[0]], [0.0; 4]),
                Dof::Node(n, axis) => (axis, dofs.nodes[n].place(), state_of(Dof::Node(n, 1 - axis))),
            };
            let call = MotionCall {
                set: &self.set,
                kind: self.kind.number(),
                node: asked.number,
                dof: axis + 1,
                now: *arrival,
                increments: [self.increment_before, increment],
                amplitude,
                coordinates,
                state,
                across,
                mass: dofs.mass(asked.dof),
            };
            let answer = routine.motion(&call).and_then(|value| {
                let reason =
                    || LoadFailure::new(format!("it gave the value {value} for degree of freedom {}", call.dof));
                value.is_finite().then_some(value).ok_or_else(reason)
            });
            let what = || format!("the user motion of `{}` at node {}", self.set, asked.number);
            let value = answer.map_err(|failure| failure.halt(&what(), arrival))?;
            // A displacement is the total one; the motion counts from where it began.
            let base = if self.kind == Prescribed::Displacement { asked.offset } else { 0.0 };
            user_amplitudes[self.first + i].tell(arrival.total_time, value - base);
        }
        (self.increment_before, self.has_begun) = (increment, true);
        Ok(())
    }

    pub fn bytes(&self) -> usize {
        heap_bytes(&self.asked) + self.set.capacity() + self.amplitude.bytes()
    }
}

persist_struct!(UserDof { offset } derived { dof, number, reference });

persist_struct!(UserMotion { asked: fixed, increment_before, has_begun } derived { set, kind, amplitude, first });
