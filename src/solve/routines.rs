//! When the user's routines are asked and told: amplitudes and motions once an increment, and the moments of the analysis.
//! Never here: loads, which are forces like others.

use super::increment::Increment;
use super::run::Run;
use crate::constraint;
use crate::state::Instant;
use crate::state::halt::Halt;
use crate::user::{AnalysisMoment, Locked, Routines, RunAction, SavedMemory};

/// The user's subroutines over a run, and what they have requested.
pub(super) struct UserSession<'a> {
    pub routines: Locked<'a>,
    pub requested_action: RunAction,
    /// Whether the subroutines have been told already that the increment is complete.
    pub increment_reported: bool,
    /// Whether a warning has named the memory of the subroutines that checkpoints do not hold.
    pub loss_reported: bool,
    /// Memory of the subroutines from the checkpoint that the run goes on from.
    pub restored_memory: SavedMemory,
}

impl<'a> UserSession<'a> {
    pub fn new(routines: &'a Routines) -> Self {
        UserSession {
            routines: routines.lock(),
            requested_action: RunAction::Continue,
            increment_reported: false,
            loss_reported: false,
            restored_memory: SavedMemory::default(),
        }
    }
}

impl Run<'_> {
    /// At the start of a step.
    pub(super) fn begin_routines(&mut self) -> Result<(), Halt> {
        self.user.requested_action = RunAction::Continue;
        if self.now.step == 1 {
            self.tell(AnalysisMoment::StartAnalysis, 0.0)?;
        }
        self.tell(AnalysisMoment::StartStep, 0.0)?;
        let now = self.now;
        self.call(&now, 0.0)
    }

    /// Before the motion over an increment.
    #[inline]
    pub(super) fn call_routines(&mut self, next: Increment) -> Result<(), Halt> {
        if self.user.routines.events.is_some() {
            if self.now.step_time > 0.0 && !std::mem::take(&mut self.user.increment_reported) {
                self.tell(AnalysisMoment::EndIncrement, self.last_increment)?;
            }
            self.tell(AnalysisMoment::SetupIncrement, next.length)?;
            self.tell(AnalysisMoment::StartIncrement, next.length)?;
        }
        if self.state.amplitude_routines.is_empty() && self.state.user_motions.is_empty() {
            return Ok(());
        }
        let arrival = next.arrival(&self.now, self.step.duration);
        self.call(&arrival, next.length)
    }

    /// At the end of a step, and of the analysis.
    pub(super) fn end_routines(&mut self) -> Result<(), Halt> {
        if self.now.step_time > 0.0 {
            self.tell(AnalysisMoment::EndIncrement, self.last_increment)?;
        }
        self.tell(AnalysisMoment::EndStep, 0.0)?;
        if self.user.requested_action == RunAction::EndAnalysis || self.now.step as usize == self.plan.steps.len() {
            self.tell(AnalysisMoment::EndAnalysis, 0.0)?;
        }
        Ok(())
    }

    /// What the routines tell of amplitudes and motions at `arrival`, an increment away.
    fn call(&mut self, arrival: &Instant, increment: f64) -> Result<(), Halt> {
        for amplitude in &mut self.state.amplitude_routines {
            let wish = amplitude.call(
                arrival,
                increment,
                &self.state.dofs,
                &mut self.state.user_amplitudes,
                &mut self.user.routines,
            )?;
            self.user.requested_action = self.user.requested_action.max(wish);
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

    /// Where the run goes on from a state that was kept: the analysis starts for the routine, in the middle. What it then does
    /// to its own memory is taken back: that is as it was when the state was kept.
    pub(super) fn resume_routines(&mut self) -> Result<(), Halt> {
        let (wish, kept) = (self.user.requested_action, std::mem::take(&mut self.user.restored_memory));
        self.tell(AnalysisMoment::StartAnalysis, 0.0)?;
        if let (Some(memory), Some(_)) = (&self.plan.routines.memory, &self.user.routines.events) {
            memory.take_up(&kept).map_err(|why| Halt { code: "R201", reason: why.reason })?;
        }
        self.user.requested_action = wish;
        Ok(())
    }

    pub(super) fn tell(&mut self, moment: AnalysisMoment, increment: f64) -> Result<(), Halt> {
        let Some(events) = self.user.routines.events.as_deref_mut() else { return Ok(()) };
        let wish = events.moment(moment, &self.now, increment);
        let failed = |f: crate::user::LoadFailure| f.halt("the user's routine that is told of events", &self.now);
        self.user.requested_action = self.user.requested_action.max(wish.map_err(failed)?);
        Ok(())
    }
}
