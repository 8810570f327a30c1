//! When the user's routines are asked and told: amplitudes and motions once an increment, and the moments of the analysis.
//! Never here: loads, which are forces like others.

use super::increment::Increment;
use super::run::Run;
use crate::constraint;
use crate::state::Instant;
use crate::state::halt::Halt;
use crate::user::{AnalysisMoment, RunAction};

impl Run<'_> {
    /// At the start of a step.
    pub(super) fn begin_routines(&mut self) -> Result<(), Halt> {
        self.wish = RunAction::Continue;
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
        if self.user.events.is_some() {
            if self.now.step_time > 0.0 && !std::mem::take(&mut self.told_complete) {
                self.tell(AnalysisMoment::EndIncrement, self.last_increment)?;
            }
            self.tell(AnalysisMoment::SetupIncrement, next.length)?;
            self.tell(AnalysisMoment::StartIncrement, next.length)?;
        }
        if self.amplitudes.is_empty() && self.motions.is_empty() {
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
        if self.wish == RunAction::EndAnalysis || self.now.step as usize == self.plan.steps.len() {
            self.tell(AnalysisMoment::EndAnalysis, 0.0)?;
        }
        Ok(())
    }

    /// What the routines tell of amplitudes and motions at `arrival`, an increment away.
    fn call(&mut self, arrival: &Instant, increment: f64) -> Result<(), Halt> {
        for amplitude in &mut self.amplitudes {
            let wish = amplitude.call(arrival, increment, &self.dofs, &mut self.told, &mut self.user)?;
            self.wish = self.wish.max(wish);
        }
        let reaction = |dof| constraint::reaction(&self.constraints, &self.dofs, dof);
        for motion in &mut self.motions {
            motion.call(arrival, increment, &self.dofs, &reaction, &mut self.told, &mut self.user)?;
        }
        Ok(())
    }

    /// Where the run goes on from a state that was kept: the analysis starts for the routine, in the middle. What it then does
    /// to its own memory is taken back: that is as it was when the state was kept.
    pub(super) fn resume_routines(&mut self) -> Result<(), Halt> {
        let (wish, kept) = (self.wish, std::mem::take(&mut self.taken_up));
        self.tell(AnalysisMoment::StartAnalysis, 0.0)?;
        if let (Some(memory), Some(_)) = (&self.plan.routines.memory, &self.user.events) {
            memory.take_up(&kept).map_err(|why| Halt { code: "R201", reason: why.reason })?;
        }
        self.wish = wish;
        Ok(())
    }

    pub(super) fn tell(&mut self, moment: AnalysisMoment, increment: f64) -> Result<(), Halt> {
        let Some(events) = self.user.events.as_deref_mut() else { return Ok(()) };
        let wish = events.moment(moment, &self.now, increment);
        let failed = |f: crate::user::LoadFailure| f.halt("the user's routine that is told of events", &self.now);
        self.wish = self.wish.max(wish.map_err(failed)?);
        Ok(())
    }
}
