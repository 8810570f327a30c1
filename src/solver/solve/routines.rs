//! Calls of user subroutines outside loads: amplitudes and motions once per increment, and events of the analysis.

use super::increment::Increment;
use super::run_state::RunState;
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
    /// Values of the sensors at the start of the increment.
    pub sensor_values: Vec<f64>,
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

    /// Calls the subroutines at the start of a step.
    pub(super) fn begin(&mut self, run: &mut RunState<'_>) -> Result<(), HaltReason> {
        self.requested_action = RunAction::Continue;
        if run.now.step == 1 {
            self.report_moment(run, AnalysisMoment::StartAnalysis, 0.0)?;
        }
        self.report_moment(run, AnalysisMoment::StartStep, 0.0)?;
        let now = run.now;
        self.call(run, &now, 0.0)
    }

    /// Calls the subroutines before the motion over an increment.
    #[inline]
    pub(super) fn call_before(&mut self, run: &mut RunState<'_>, next: Increment) -> Result<(), HaltReason> {
        if self.routines.events.is_some() {
            if run.now.step_time > 0.0 && !std::mem::take(&mut self.increment_reported) {
                self.report_moment(run, AnalysisMoment::EndIncrement, run.last_increment)?;
            }
            self.report_moment(run, AnalysisMoment::SetupIncrement, next.length)?;
            self.report_moment(run, AnalysisMoment::StartIncrement, next.length)?;
        }
        if run.state.amplitude_routines.is_empty() && run.state.user_motions.is_empty() {
            return Ok(());
        }
        let arrival = next.arrival(&run.now, run.step.duration);
        self.call(run, &arrival, next.length)
    }

    /// Calls the subroutines at the end of a step, and at the end of the analysis.
    pub(super) fn end(&mut self, run: &RunState<'_>) -> Result<(), HaltReason> {
        if run.now.step_time > 0.0 {
            self.report_moment(run, AnalysisMoment::EndIncrement, run.last_increment)?;
        }
        self.report_moment(run, AnalysisMoment::EndStep, 0.0)?;
        if self.requested_action == RunAction::EndAnalysis || run.now.step as usize == run.plan.steps.len() {
            self.report_moment(run, AnalysisMoment::EndAnalysis, 0.0)?;
        }
        Ok(())
    }

    /// Calls the subroutines for amplitudes and motions at `arrival`, which is `increment` after the current instant.
    fn call(&mut self, run: &mut RunState<'_>, arrival: &Instant, increment: f64) -> Result<(), HaltReason> {
        if !run.state.amplitude_routines.is_empty() {
            run.sensor_values(&mut self.sensor_values);
        }
        for amplitude in &mut run.state.amplitude_routines {
            let action = amplitude.call(
                arrival,
                increment,
                &self.sensor_values,
                &mut run.state.user_amplitudes,
                &mut self.routines,
            )?;
            self.requested_action = self.requested_action.max(action);
        }
        let reaction = |dof| constraint::reaction(&run.state.constraints, &run.state.dofs, dof);
        for motion in &mut run.state.user_motions {
            motion.call(
                arrival,
                increment,
                &run.state.dofs,
                &reaction,
                &mut run.state.user_amplitudes,
                &mut self.routines,
            )?;
        }
        Ok(())
    }

    /// Informs the subroutine that the analysis starts, when a run continues from a saved state. Its memory is then
    /// restored, because the call may have changed it.
    pub(super) fn resume(&mut self, run: &RunState<'_>) -> Result<(), HaltReason> {
        let (action, memory_of_checkpoint) = (self.requested_action, std::mem::take(&mut self.restored_memory));
        self.report_moment(run, AnalysisMoment::StartAnalysis, 0.0)?;
        if let Some(memory) = run.plan.routines.memory.as_ref().filter(|_| self.routines.events.is_some()) {
            let restored = memory.restore(&memory_of_checkpoint);
            restored.map_err(|failure| HaltReason::UserRoutine(HaltDetails::new(failure.reason)))?;
        }
        self.requested_action = action;
        Ok(())
    }

    /// Informs the subroutine that the increment is complete and that a checkpoint follows.
    pub(super) fn announce_checkpoint(&mut self, run: &RunState<'_>) -> Result<(), HaltReason> {
        let due = run.now.step_time > 0.0 && !self.increment_reported;
        if let Some(events) = self.routines.events.as_deref_mut().filter(|_| due) {
            events.restart_follows();
            self.report_moment(run, AnalysisMoment::EndIncrement, run.last_increment)?;
            self.increment_reported = true;
        }
        Ok(())
    }

    fn report_moment(&mut self, run: &RunState<'_>, moment: AnalysisMoment, increment: f64) -> Result<(), HaltReason> {
        let Some(events) = self.routines.events.as_deref_mut() else { return Ok(()) };
        let action = events.moment(moment, &run.now, increment);
        let failed = |f: crate::user::LoadFailure| f.halt("the user subroutine for analysis events", &run.now);
        self.requested_action = self.requested_action.max(action.map_err(failed)?);
        Ok(())
    }
}
