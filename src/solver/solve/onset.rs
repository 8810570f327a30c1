//! Loads that begin inside an increment. Loads report the instants at which they begin (`Load::max_increment`), except
//! those of user subroutines on rigid bodies: an increment in which such a load begins suddenly is repeated, until it
//! ends where the load begins.

use super::increment::{Increment, IncrementEnd};
use super::limits::IncrementLimiter;
use super::run::SolverRun;
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
        let State { elements, constraints, loads, user_motions, amplitude_routines, .. } = &self.state;
        let is_repeatable = matches!(self.step.control, IncrementControl::Automatic { .. })
            && elements.is_empty()
            && constraints.is_empty()
            && user_motions.is_empty()
            && amplitude_routines.is_empty()
            && !self.user.routines.events.is_some();
        self.finds_onsets = is_repeatable
            && loads.iter().any(|load| load.may_begin_suddenly())
            && loads.iter().all(|load| load.velocity_use() != VelocityUse::Resists);
    }

    /// Returns the sum of the forces of the loads that may begin suddenly and had no force at the previous instant.
    fn beginning_force(&self) -> f64 {
        let mut sum = 0.0;
        for i in (0..self.state.loads.len()).filter(|&i| self.state.loads[i].may_begin_suddenly()) {
            let slots = self.body_forces.start_of(i)..self.body_forces.loads[i].1;
            if slots.clone().all(|slot| self.balance.force(slot) == 0.0) {
                sum += self.body_forces.values[slots].iter().map(|force| force.abs()).sum::<f64>();
            }
        }
        sum
    }

    /// Repeats the increment that led to this instant if a load has begun suddenly, so that it ends where the load begins.
    ///
    /// # Errors
    /// If a force fails.
    #[inline(never)]
    pub(super) fn resolve_onset(&mut self) -> Result<(), HaltReason> {
        let (whole, force) = (self.last_increment, self.beginning_force());
        if self.previous_dt == 0.0 || force == 0.0 {
            return Ok(());
        }
        let end = if self.now.step_time >= self.step.duration { IncrementEnd::Step } else { IncrementEnd::Plain };
        let [mut before, mut after] = [0.0, whole];
        while after - before > PRECISION * whole {
            let middle = 0.5 * (before + after);
            self.repeat_increment(middle, IncrementEnd::Plain)?;
            if self.beginning_force() > 0.0 {
                after = middle;
            } else {
                before = middle;
            }
        }
        self.repeat_increment(after, IncrementEnd::Plain)?;
        if self.beginning_force() >= SUDDEN * force {
            self.repeat_increment(after, IncrementEnd::Jump)?;
        } else {
            self.repeat_increment(whole, end)?;
        }
        if let Some(summary) = self.outcome.steps.last_mut() {
            summary.time = self.now.step_time;
        }
        Ok(())
    }

    /// Makes the increment that led to this instant again, with another length, and evaluates the forces at its end.
    fn repeat_increment(&mut self, length: f64, end: IncrementEnd) -> Result<(), HaltReason> {
        self.state.dofs.bodies.iter_mut().for_each(BodyState::undo_advance);
        self.now = self.previous_instant;
        self.make_increment(Increment { length, end, by: IncrementLimiter::Accuracy });
        self.apply_body_loads(0..self.state.loads.len())
    }
}
