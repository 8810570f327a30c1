//! Loads that begin inside an increment. Loads report the instants at which they begin (`Load::max_increment`), except
//! those of user subroutines on rigid bodies: an increment in which such a load begins suddenly is repeated, until it
//! ends where the load begins.

use super::increment::{Increment, IncrementEnd};
use super::limits::IncrementLimiter;
use super::run::SolverRun;
use super::run_state::RunState;
use crate::load::VelocityUse;
use crate::model::IncrementControl;
use crate::plan::State;
use crate::state::BodyState;
use crate::state::halt::HaltReason;

/// Precision of the instant, as a fraction of the increment in which the load begins.
const PRECISION: f64 = 1e-4;
/// Smallest force at the instant at which a load begins, as a fraction of that at the end of the increment, for a sudden
/// beginning.
const SUDDEN: f64 = 0.5;

impl SolverRun<'_> {
    /// Determines for a step whether increments can be repeated: error control chooses them, nothing but rigid bodies and
    /// loads has a state, and no user subroutine counts increments.
    pub(super) fn begin_onsets(&mut self) {
        let State { dofs, constraints, loads, user_motions, amplitude_routines, .. } = &self.current.state;
        let is_repeatable = matches!(self.current.step.control, IncrementControl::Automatic { .. })
            && dofs.nodes.is_empty()
            && constraints.is_empty()
            && user_motions.is_empty()
            && amplitude_routines.is_empty()
            && !self.user.routines.events.is_some();
        self.finds_onsets = is_repeatable
            && loads.iter().any(|load| load.may_begin_suddenly())
            && loads.iter().all(|load| load.velocity_use() != VelocityUse::Resists);
    }

    /// Repeats the increment that led to this instant if a load has begun suddenly, so that it ends where the load begins.
    ///
    /// # Errors
    /// If a force fails.
    #[inline(always)]
    pub(super) fn resolve_onset(&mut self) -> Result<(), HaltReason> {
        if self.finds_onsets { self.find_onset() } else { Ok(()) }
    }

    #[inline(never)]
    fn find_onset(&mut self) -> Result<(), HaltReason> {
        let run = &self.current;
        let (whole, force) = (run.last_increment, beginning_force(run));
        if run.previous_dt == 0.0 || force == 0.0 {
            return Ok(());
        }
        let end = if run.now.step_time >= run.step.duration { IncrementEnd::Step } else { IncrementEnd::Plain };
        let [mut without_force, mut with_force] = [0.0, whole];
        while with_force - without_force > PRECISION * whole {
            let middle = 0.5 * (without_force + with_force);
            self.repeat_increment(middle, IncrementEnd::Plain)?;
            if beginning_force(&self.current) > 0.0 {
                with_force = middle;
            } else {
                without_force = middle;
            }
        }
        self.repeat_increment(with_force, IncrementEnd::Plain)?;
        if beginning_force(&self.current) >= SUDDEN * force {
            self.repeat_increment(with_force, IncrementEnd::Jump)?;
        } else {
            self.repeat_increment(whole, end)?;
        }
        if let Some(summary) = self.report.outcome.steps.last_mut() {
            summary.time = self.current.now.step_time;
        }
        Ok(())
    }

    /// Makes the increment that led to this instant again, with another length, and evaluates the forces at its end.
    fn repeat_increment(&mut self, length: f64, end: IncrementEnd) -> Result<(), HaltReason> {
        self.current.state.dofs.bodies.iter_mut().for_each(BodyState::undo_advance);
        self.current.now = self.current.previous_instant;
        self.make_increment(Increment { length, end, by: IncrementLimiter::Accuracy })?;
        self.apply_body_loads(0..self.current.state.loads.len())
    }
}

/// Returns the sum of the forces of the loads that may begin suddenly and had no force at the previous instant.
fn beginning_force(run: &RunState<'_>) -> f64 {
    let (loads, forces) = (&run.state.loads, &run.body_forces);
    let mut sum = 0.0;
    for i in (0..loads.len()).filter(|&i| loads[i].may_begin_suddenly()) {
        let slots = forces.start_of(i)..forces.loads[i].1;
        if slots.clone().all(|slot| run.balance.force(slot) == 0.0) {
            sum += forces.values[slots].iter().map(|force| force.abs()).sum::<f64>();
        }
    }
    sum
}
