//! Calls of user subroutines outside loads: amplitudes and motions once per increment, and events of the analysis.

use super::increment::Increment;
use super::run::SolverRun;
use crate::constraint;
use crate::state::Instant;
use crate::state::archive::Persist;
use crate::state::halt::{HaltDetails, HaltReason};
use crate::user::{AnalysisMoment, LockedRoutines, Routines, RunAction, SavedMemory};

/// User subroutines over a run, and the action that they have requested.
#[derive(Default, Persist)]
#[persist(derived: routines, loss_reported, restored_memory)]
pub(super) struct UserSession {
    pub routines: LockedRoutines,
    pub requested_action: RunAction,
    /// Whether the subroutines have been informed that the increment is complete.
    pub increment_reported: bool,
    /// Whether a warning has named memory of the subroutines that checkpoints do not contain.
    pub loss_reported: bool,
    /// Memory of the subroutines from the checkpoint that the run goes on from.
    pub restored_memory: SavedMemory,
}

impl UserSession {
    pub fn new(routines: &Routines) -> Self {
        UserSession { routines: routines.lock(), ..UserSession::default() }
    }
}

impl SolverRun<'_> {
    /// Calls the subroutines at the start of a step.
    pub(super) fn begin_routines(&mut self) -> Result<(), HaltReason> {
        self.user.requested_action = RunAction::Continue;
        if self.now.step == 1 {
            self.report_moment(AnalysisMoment::StartAnalysis, 0.0)?;
        }
        self.report_moment(AnalysisMoment::StartStep, 0.0)?;
        let now = self.now;
        self.call(&now, 0.0)
    }

    /// Calls the subroutines before the motion over an increment.
    #[inline]
    pub(super) fn call_routines(&mut self, next: Increment) -> Result<(), HaltReason> {
        if self.user.routines.events.is_some() {
            if self.now.step_time > 0.0 && !std::mem::take(&mut self.user.increment_reported) {
                self.report_moment(AnalysisMoment::EndIncrement, self.last_increment)?;
            }
            self.report_moment(AnalysisMoment::SetupIncrement, next.length)?;
            self.report_moment(AnalysisMoment::StartIncrement, next.length)?;
        }
        if self.state.amplitude_routines.is_empty() && self.state.user_motions.is_empty() {
            return Ok(());
        }
        let arrival = next.arrival(&self.now, self.step.duration);
        self.call(&arrival, next.length)
    }

    /// Calls the subroutines at the end of a step, and at the end of the analysis.
    pub(super) fn end_routines(&mut self) -> Result<(), HaltReason> {
        if self.now.step_time > 0.0 {
            self.report_moment(AnalysisMoment::EndIncrement, self.last_increment)?;
        }
        self.report_moment(AnalysisMoment::EndStep, 0.0)?;
        if self.user.requested_action == RunAction::EndAnalysis || self.now.step as usize == self.plan.steps.len() {
            self.report_moment(AnalysisMoment::EndAnalysis, 0.0)?;
        }
        Ok(())
    }

    /// Calls the subroutines for amplitudes and motions at `arrival`, which is `increment` after the current instant.
    fn call(&mut self, arrival: &Instant, increment: f64) -> Result<(), HaltReason> {
        for amplitude in &mut self.state.amplitude_routines {
            let action = amplitude.call(
                arrival,
                increment,
                &self.state.dofs,
                &mut self.state.user_amplitudes,
                &mut self.user.routines,
            )?;
            self.user.requested_action = self.user.requested_action.max(action);
        }
        let reaction = |dof| constraint::reaction(&self.state.constraints, &self.state.dofs, dof);
        for motion in &mut self.state.user_motions {
            motion.call(
                arrival,
                increment,
                &self.state.dofs,
                &reaction,
                &mut self.state.user_amplitudes,
                &mut self.user.routines,
            )?;
        }
        Ok(())
    }

    /// Informs the subroutine that the analysis starts, when a run continues from a saved state. Its memory is then
    /// restored, because the call may have changed it.
    pub(super) fn resume_routines(&mut self) -> Result<(), HaltReason> {
        let (action, memory_of_checkpoint) =
            (self.user.requested_action, std::mem::take(&mut self.user.restored_memory));
        self.report_moment(AnalysisMoment::StartAnalysis, 0.0)?;
        if let Some(memory) = self.plan.routines.memory.as_ref().filter(|_| self.user.routines.events.is_some()) {
            memory
                .restore(&memory_of_checkpoint)
                .map_err(|why| HaltReason::UserRoutine(HaltDetails::new(why.reason)))?;
        }
        self.user.requested_action = action;
        Ok(())
    }

    pub(super) fn report_moment(&mut self, moment: AnalysisMoment, increment: f64) -> Result<(), HaltReason> {
        let Some(events) = self.user.routines.events.as_deref_mut() else { return Ok(()) };
        let action = events.moment(moment, &self.now, increment);
        let failed = |f: crate::user::LoadFailure| f.halt("the user subroutine for analysis events", &self.now);
        self.user.requested_action = self.user.requested_action.max(action.map_err(failed)?);
        Ok(())
    }
}
