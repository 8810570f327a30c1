//! Motions prescribed by a user subroutine (`*BOUNDARY, USER`): one call per degree of freedom. The values become user
//! amplitudes of a [`super::motion`].

use super::motion::PrescribedQuantity;
use crate::kernel::amplitude::SampledAmplitude;
use crate::kernel::lists::Memory;
use crate::routines::{LoadFailure, LockedRoutines, MotionCall};
use crate::state::Instant;
use crate::state::archive::Persist;
use crate::state::dofs::{Dof, Dofs};
use crate::state::halt::HaltReason;
use crate::state::magnitude::{AmplitudeClock, Magnitude};

/// Prescribed motion of a node set along one axis.
#[derive(Clone, Debug, Persist, Memory)]
#[persist(fixed: dofs; derived: set, kind, amplitude, first)]
pub struct UserMotion {
    /// Node set, upper case.
    pub set: String,
    pub kind: PrescribedQuantity,
    /// Amplitude that the subroutine receives and applies itself.
    pub amplitude: Magnitude,
    pub dofs: Vec<UserDof>,
    /// Index of the first of its user amplitudes.
    pub first: usize,
    pub increment_before: f64,
    /// Whether the subroutine was called before, so that the origins of displacements are known.
    pub has_begun: bool,
}

/// A degree of freedom whose motion the subroutine prescribes.
#[derive(Clone, Debug, Persist, Memory)]
#[persist(derived: dof, number, reference)]
pub struct UserDof {
    pub dof: Dof,
    pub number: i32,
    /// Initial coordinates of a rigid body's reference node.
    pub reference: [f64; 2],
    /// Displacement when the motion began.
    pub offset: f64,
}

impl UserMotion {
    /// Calls the subroutine for the values at `arrival`, which is `increment` after the current instant (0 at the start
    /// of a step); `reaction` returns reaction forces.
    ///
    /// # Errors
    /// If the subroutine fails or returns a value that is not finite; the run halts.
    pub fn call(
        &mut self,
        arrival: &Instant,
        increment: f64,
        dofs: &Dofs,
        reaction: &dyn Fn(Dof) -> f64,
        user_amplitudes: &mut [SampledAmplitude],
        user: &mut LockedRoutines,
    ) -> Result<(), HaltReason> {
        let Some(routine) = user.motion.as_deref_mut() else { return Ok(()) };
        let amplitude = self.amplitude.amplitude(&AmplitudeClock { now: *arrival, user_amplitudes });
        for (i, user_dof) in self.dofs.iter_mut().enumerate() {
            let state_of = |dof| [dofs.displacement(dof), dofs.velocity(dof), dofs.acceleration(dof), reaction(dof)];
            let state = state_of(user_dof.dof);
            if !self.has_begun {
                user_dof.offset = state[0];
            }
            let (axis, coordinates, across) = match user_dof.dof {
                Dof::Body(_) => (1, [user_dof.reference[0], user_dof.reference[1] + state[0]], [0.0; 4]),
                Dof::Node(n, axis) => (axis, dofs.nodes[n].place(), state_of(Dof::Node(n, 1 - axis))),
            };
            let call = MotionCall {
                set: &self.set,
                kind: self.kind.number(),
                node: user_dof.number,
                dof: axis + 1,
                now: *arrival,
                increments: [self.increment_before, increment],
                amplitude,
                coordinates,
                state,
                across,
                mass: dofs.mass(user_dof.dof),
            };
            let answer = routine.motion(&call).and_then(|value| {
                let reason =
                    || LoadFailure::new(format!("it returned the value {value} for degree of freedom {}", call.dof));
                value.is_finite().then_some(value).ok_or_else(reason)
            });
            let what = || format!("the user motion of `{}` at node {}", self.set, user_dof.number);
            let value = answer.map_err(|failure| failure.halt(&what(), arrival))?;
            // The subroutine returns the total displacement; the amplitude starts at the beginning of the motion.
            let base = if self.kind == PrescribedQuantity::Displacement { user_dof.offset } else { 0.0 };
            user_amplitudes[self.first + i].add_sample(arrival.total_time, value - base);
        }
        (self.increment_before, self.has_begun) = (increment, true);
        Ok(())
    }
}
