//! Estimate of increments and run time from a short trial run in memory.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant as Stopwatch};

use serde::Serialize;

use crate::plan::{Plan, State};
use crate::solve::{self, Instant, Progress, RunControl, Sink, SinkError};

/// Estimated increments and run time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunEstimate {
    /// Time increment at the end of the trial run.
    pub increment: f64,
    /// Element that limits the increment; empty if none does.
    pub limiting_element: String,
    /// Number of increments of the whole run with this increment.
    pub increments: f64,
    /// Run time in seconds on this machine, without output.
    pub seconds: f64,
    /// Fraction of the run that the trial run covered; 1 for the whole run.
    pub looked_at: f64,
    /// Reason if the trial run halted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub halt: Option<String>,
}

/// Sink that interrupts a run after a given wall-clock time.
struct TrialRun<'a> {
    begin: Stopwatch,
    length: Duration,
    stop: &'a AtomicUsize,
    increment: f64,
    limiting: String,
    fraction: f64,
}

impl Sink for TrialRun<'_> {
    fn row(&mut self, _now: &Instant, _values: &[f64]) -> Result<(), SinkError> {
        Ok(())
    }

    fn progress(&mut self, progress: &Progress<'_>) {
        if self.begin.elapsed() >= self.length {
            self.stop.store(usize::MAX, Ordering::Relaxed);
        }
        if progress.increment > 0.0 && !progress.ends {
            self.increment = progress.increment;
            progress.limiting.clone_into(&mut self.limiting);
        }
        self.fraction = progress.fraction;
    }
}

/// Runs a plan for a limited wall-clock time and estimates the whole run; `None` with user subroutines or if no
/// increment was completed.
pub fn measure(plan: &Plan, state: &State, length: Duration) -> Option<RunEstimate> {
    if plan.routines.any() {
        return None;
    }
    let stop = AtomicUsize::new(0);
    let mut look = TrialRun {
        begin: Stopwatch::now(),
        length,
        stop: &stop,
        increment: 0.0,
        limiting: String::new(),
        fraction: 0.0,
    };
    let control = RunControl { interrupt: Some(&stop), ..RunControl::default() };
    let (outcome, _) = solve::run_with(plan, state.clone(), &mut look, control).ok()?;
    let TrialRun { increment, limiting, fraction, .. } = look;
    let ended = stop.load(Ordering::Relaxed) == 0;
    let halt = outcome.halt.as_ref().filter(|_| ended).map(|halt| format!("{}: {}", halt.code, halt.reason));
    if ended && halt.is_none() {
        let (increments, seconds) = (outcome.increments as f64, outcome.seconds);
        return Some(RunEstimate { increment, limiting_element: limiting, increments, seconds, looked_at: 1.0, halt });
    }
    if outcome.increments == 0 || increment <= 0.0 {
        return None;
    }
    let elapsed_time: f64 = outcome.steps.iter().map(|step| step.time).sum();
    let total: f64 = plan.steps.iter().map(|step| step.duration).sum();
    let increments = outcome.increments as f64 + (total - elapsed_time).max(0.0) / increment;
    let seconds = increments * outcome.seconds / outcome.increments as f64;
    Some(RunEstimate { increment, limiting_element: limiting, increments, seconds, looked_at: fraction, halt })
}
