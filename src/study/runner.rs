//! One setting of a study, run in memory as often as its time is to be taken, nothing else at once.

use std::sync::atomic::AtomicUsize;
use std::time::Instant as Stopwatch;

use serde::Serialize;

use super::StudyError;
use super::error::accepted;
use super::quantity::{FinishedRun, Quantity, QuantityValue};
use super::settings::{Axis, ModelEdit, StudyParameter, edit};
use crate::deck::{Deck, Diagnostics};
use crate::job::{self, Overrides};
use crate::user::compile::Compiled;

/// Gives the deck for values of its parameters.
pub type DeckReader<'a> = dyn Fn(&Overrides) -> (Deck, Diagnostics) + 'a;

/// What settings have in common.
pub struct StudyRunner<'a> {
    source: &'a DeckReader<'a>,
    overrides: Vec<(String, String)>,
    user: Option<&'a Compiled>,
    measure: &'a Quantity,
    repeat: usize,
    done: &'a dyn Fn(),
    spent: f64,
    interrupt: Option<&'a AtomicUsize>,
}

/// What a setting gave and took.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyRun {
    /// What was found.
    pub found: QuantityValue,
    /// What is to be known of it: warnings, and bodies that are still on their way.
    pub doubts: Vec<String>,
    /// Elements and facets.
    pub elements: usize,
    /// Increments.
    pub increments: u64,
    /// Seconds of the whole run, deck to last increment, by repetition.
    pub seconds: TimeSpread,
    /// Seconds in the time loop.
    pub loop_seconds: TimeSpread,
}

impl StudyRun {
    /// Elements (facets, of rigid bodies) times increments: what a run costs, without a clock.
    pub fn element_cycles(&self) -> f64 {
        self.elements as f64 * self.increments as f64
    }
}

/// Times of repeated runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct TimeSpread {
    /// Median.
    pub median: f64,
    /// Shortest.
    pub min: f64,
    /// Longest.
    pub max: f64,
}

impl TimeSpread {
    fn of(times: &mut [f64]) -> TimeSpread {
        times.sort_by(f64::total_cmp);
        let n = times.len();
        let (Some(&min), Some(&max)) = (times.first(), times.last()) else { return TimeSpread::default() };
        TimeSpread { median: 0.5 * (times[(n - 1) / 2] + times[n / 2]), min, max }
    }
}

impl<'a> StudyRunner<'a> {
    /// Runs of a deck with these overrides; each setting `repeat` times, `done` after each run.
    pub fn new(
        source: &'a DeckReader<'a>,
        overrides: &Overrides,
        user: Option<&'a Compiled>,
        measure: &'a Quantity,
        repeat: usize,
        done: &'a dyn Fn(),
    ) -> Self {
        StudyRunner {
            source,
            overrides: overrides.to_vec(),
            user,
            measure,
            repeat: repeat.max(1),
            done,
            spent: 0.0,
            interrupt: None,
        }
    }

    /// Halts all runs as soon as this is a number other than 0.
    pub fn interrupted_by(&mut self, interrupt: &'a AtomicUsize) {
        self.interrupt = Some(interrupt);
    }

    /// The quantity.
    pub fn measure(&self) -> &Quantity {
        self.measure
    }

    /// How often each setting runs.
    pub fn repeat(&self) -> usize {
        self.repeat
    }

    /// Seconds that all runs took so far.
    pub fn spent(&self) -> f64 {
        self.spent
    }

    /// Runs with one value for each axis, and a change of the model after those that the values ask for.
    pub fn at(&mut self, axes: &[Axis], values: &[String], change: Option<ModelEdit>) -> Result<StudyRun, StudyError> {
        let mut overrides = self.overrides.clone();
        let mut edits: Vec<ModelEdit> = Vec::new();
        for (axis, value) in axes.iter().zip(values) {
            match &axis.parameter {
                StudyParameter::Parameter(name) => overrides.push((name.clone(), value.clone())),
                parameter => edits.extend(edit(parameter, value).map_err(StudyError::Setting)?),
            }
        }
        edits.extend(change);
        self.edited(&overrides, &edits)
    }

    fn edited(&mut self, overrides: &Overrides, edits: &[ModelEdit]) -> Result<StudyRun, StudyError> {
        let (mut whole, mut inside) = (Vec::new(), Vec::new());
        let mut first = None;
        for _ in 0..self.repeat {
            let begin = Stopwatch::now();
            let run = self.once(overrides, edits);
            let seconds = begin.elapsed().as_secs_f64();
            self.spent += seconds;
            (self.done)();
            let run = run?;
            whole.push(seconds);
            inside.push(run.loop_seconds.median);
            first.get_or_insert(run);
        }
        let run = first.ok_or_else(|| StudyError::Comparison("no run".into()))?;
        Ok(StudyRun { seconds: TimeSpread::of(&mut whole), loop_seconds: TimeSpread::of(&mut inside), ..run })
    }

    fn once(&self, overrides: &Overrides, edits: &[ModelEdit]) -> Result<StudyRun, StudyError> {
        let routines = Compiled::open_any(self.user)?;
        let mut fault = Ok(());
        let mut change = |model: &mut _| fault = edits.iter().try_for_each(|edit| edit(model));
        let prepared = accepted(job::prepare_edited((self.source)(overrides), &mut change, &routines))?;
        fault?;
        let mut history = self.measure.history(&prepared.plan);
        let never = AtomicUsize::new(0);
        let (outcome, state) = job::run_until(&prepared, &mut history, self.interrupt.unwrap_or(&never));
        if let Some(halt) = outcome.halt {
            return Err(StudyError::Halted(halt));
        }
        let found =
            self.measure.evaluate(FinishedRun { history: &history, end: Some((outcome.total_time(), &state)) })?;
        let elements = prepared.plan.mesh.elements.iter().filter(|e| !e.kind.is_discrete()).count();
        let seconds = TimeSpread { median: outcome.seconds, ..TimeSpread::default() };
        let doubts = outcome.unfinished.into_iter().chain(outcome.warnings).collect();
        Ok(StudyRun { found, doubts, elements, increments: outcome.increments, seconds, loop_seconds: seconds })
    }
}

#[cfg(test)]
mod tests {
    use super::TimeSpread;

    #[test]
    fn the_median_of_times() {
        assert_eq!(TimeSpread::of(&mut [3.0, 1.0, 2.0]), TimeSpread { median: 2.0, min: 1.0, max: 3.0 });
        assert_eq!(TimeSpread::of(&mut [3.0, 1.0]).median, 2.0);
    }
}
