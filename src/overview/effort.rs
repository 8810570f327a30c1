//! What a run will take: its first moments are run in memory and carried on.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant as Stopwatch};

use serde::Serialize;

use crate::plan::{Plan, State};
use crate::solve::{self, Control, Instant, Progress, Sink, SinkError};

/// What a run will take.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Effort {
    /// Length of the increments where the look ended.
    pub increment: f64,
    /// Element that limits them; empty where none does.
    pub limiting_element: String,
    /// Increments of the whole run at this length.
    pub increments: f64,
    /// Seconds of the whole run on this machine, without its files.
    pub seconds: f64,
    /// Fraction of the run that was looked at; 1 if all of it.
    pub looked_at: f64,
    /// Why the run would halt within the look, if it would.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub halt: Option<String>,
}

/// Follows a run until a time on the clock has passed.
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

/// Runs a plan for a limited time and estimates the whole run; `None` with user subroutines or without an increment.
pub fn measure(plan: &Plan, state: &State, length: Duration) -> Option<Effort> {
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
    let control = Control { interrupt: Some(&stop), ..Control::default() };
    let (outcome, _) = solve::run_with(plan, state.clone(), &mut look, control).ok()?;
    let TrialRun { increment, limiting, fraction, .. } = look;
    let ended = stop.load(Ordering::Relaxed) == 0;
    let halt = outcome.halt.as_ref().filter(|_| ended).map(|halt| format!("{}: {}", halt.code, halt.reason));
    if ended && halt.is_none() {
        let (increments, seconds) = (outcome.increments as f64, outcome.seconds);
        return Some(Effort { increment, limiting_element: limiting, increments, seconds, looked_at: 1.0, halt });
    }
    if outcome.increments == 0 || increment <= 0.0 {
        return None;
    }
    let behind: f64 = outcome.steps.iter().map(|step| step.time).sum();
    let total: f64 = plan.steps.iter().map(|step| step.duration).sum();
    let increments = outcome.increments as f64 + (total - behind).max(0.0) / increment;
    let seconds = increments * outcome.seconds / outcome.increments as f64;
    Some(Effort { increment, limiting_element: limiting, increments, seconds, looked_at: fraction, halt })
}
