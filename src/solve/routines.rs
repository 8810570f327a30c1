//! When the user's routines are asked and told: amplitudes and motions once an increment, and the moments of the analysis.
//! Never here: loads, which are forces like others.

use super::Run;
use super::increment::Increment;
use crate::plan::StepPlan;
use crate::state::Instant;
use crate::state::halt::Halt;
use crate::user::{Moment, Wish};

impl Run<'_> {
    /// At the start of a step.
    pub(super) fn begin_routines(&mut self, step: &mut StepPlan) -> Result<(), Halt> {
        self.wish = Wish::Continue;
        if self.now.step == 1 {
            self.tell(Moment::StartAnalysis, 0.0)?;
        }
        self.tell(Moment::StartStep, 0.0)?;
        let now = self.now;
        self.ask(step, &now, 0.0)
    }

    /// Before the motion over an increment.
    #[inline]
    pub(super) fn ask_routines(&mut self, step: &mut StepPlan, next: Increment) -> Result<(), Halt> {
        if self.plan.events.is_some() {
            if self.now.step_time > 0.0 && !std::mem::take(&mut self.told) {
                self.tell(Moment::EndIncrement, self.last_increment)?;
            }
            self.tell(Moment::SetupIncrement, next.length)?;
            self.tell(Moment::StartIncrement, next.length)?;
        }
        if self.asking.is_empty() && step.asking.is_empty() && step.node_asking.is_empty() {
            return Ok(());
        }
        let arrival = next.arrival(&self.now, step.duration);
        self.ask(step, &arrival, next.length)
    }

    /// At the end of a step, and of the analysis.
    pub(super) fn end_routines(&mut self) -> Result<(), Halt> {
        if self.now.step_time > 0.0 {
            self.tell(Moment::EndIncrement, self.last_increment)?;
        }
        self.tell(Moment::EndStep, 0.0)?;
        if self.wish == Wish::EndAnalysis || self.now.step as usize == self.steps {
            self.tell(Moment::EndAnalysis, 0.0)?;
        }
        Ok(())
    }

    fn ask(&mut self, step: &mut StepPlan, arrival: &Instant, increment: f64) -> Result<(), Halt> {
        for asking in self.asking.iter_mut().chain(&mut step.asking) {
            self.wish = self.wish.max(asking.ask(arrival, increment, &self.bodies)?);
        }
        if let Some(solid) = &self.solid {
            step.node_asking.iter_mut().try_for_each(|a| a.ask(arrival, increment, solid))?;
        }
        Ok(())
    }

    /// Where the run goes on from a state that was kept: the analysis starts for the routine, in the middle.
    pub(super) fn resume_routines(&mut self) -> Result<(), Halt> {
        let wish = self.wish;
        self.tell(Moment::StartAnalysis, 0.0)?;
        self.wish = wish;
        Ok(())
    }

    pub(super) fn tell(&mut self, moment: Moment, increment: f64) -> Result<(), Halt> {
        let Some(events) = &self.plan.events else { return Ok(()) };
        let wish = events.with(|e| e.moment(moment, &self.now, increment));
        let failed = |f: crate::user::LoadFailure| f.halt("the user's routine that is told of events", &self.now);
        self.wish = self.wish.max(wish.map_err(failed)?);
        Ok(())
    }
}
