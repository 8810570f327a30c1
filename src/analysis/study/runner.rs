//! Runs of the settings of a study, in memory and one after the other, so that run times can be compared.

use std::sync::atomic::AtomicUsize;
use std::time::{Duration, Instant as Stopwatch};

use rayon::prelude::*;
use serde::Serialize;

use super::StudyError;
use super::error::accepted;
use super::log::{FinishedValues, RunLog};
use super::quantity::{self, FinishedRun, Quantity, QuantityValue};
use super::settings::{ModelEdit, StudyAxis, StudyParameter, edit};
use super::table::duration;
use crate::deck::{Deck, Diagnostics};
use crate::job::{self, ParameterOverrides, PreparedJob};
use crate::model::Model;
use crate::output::checkpoint::hash;
use crate::user::compile::Compiled;

/// Function that reads the deck with given parameter values.
pub type DeckReader<'a> = dyn Fn(&ParameterOverrides) -> (Deck, Diagnostics) + Sync + 'a;

/// Deck, user subroutines and interrupt of runs in memory.
#[derive(Clone, Copy)]
pub struct RunSource<'a> {
    /// Reader of the deck.
    pub deck: &'a DeckReader<'a>,
    /// Compiled user subroutines.
    pub user: Option<&'a Compiled>,
    /// A nonzero value halts the runs.
    pub interrupt: Option<&'a AtomicUsize>,
}

/// Runner of the settings of a study.
pub struct StudyRunner<'a> {
    source: RunSource<'a>,
    overrides: Vec<(String, String)>,
    measure: &'a Quantity,
    repeat: usize,
    done: &'a dyn Fn(),
    spent: f64,
    limit: Option<TimeLimit<'a>>,
    log: Option<StudyLog<'a>>,
}

/// List of the finished runs of a study, which always makes the same runs in the same order.
struct StudyLog<'a> {
    log: &'a RunLog,
    /// Hash of everything on which the runs depend.
    identity: String,
    /// Number of settings so far.
    settings: usize,
}

impl StudyLog<'_> {
    /// Returns the key of the next setting.
    fn next_key(&mut self, overrides: &ParameterOverrides) -> String {
        self.settings += 1;
        hash([self.identity.as_bytes(), &self.settings.to_le_bytes(), format!("{overrides:?}").as_bytes()])
    }
}

/// Limit of the time of all runs.
#[derive(Clone, Copy)]
struct TimeLimit<'a> {
    begin: Stopwatch,
    budget: Duration,
    announce: &'a dyn Fn(&str),
}

/// Number of times that the next level must fit into the remaining time: it may be run again, with files, and its
/// perturbed runs follow.
const RESERVE: f64 = 3.0;

/// Result and run time of a setting.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyRun {
    /// Number or field that the quantity has for this setting.
    pub found: QuantityValue,
    /// Warnings, and notes on bodies that are still moving in a target.
    pub warnings: Vec<String>,
    /// Number of elements and facets.
    pub elements: usize,
    /// Number of increments of one run.
    pub increments: u64,
    /// Kinetic and internal energy at the end.
    pub energies: [f64; 2],
    /// Run time in seconds, from reading the deck to the last increment.
    pub seconds: TimeSpread,
    /// Run time of the time loop alone, in seconds.
    pub loop_seconds: TimeSpread,
}

impl StudyRun {
    /// Number of values of a run in a list of finished runs.
    const NUMBERS: usize = 11;

    /// Returns the values for a list of finished runs; `None` if the result is a field.
    fn numbers(&self) -> Option<[f64; StudyRun::NUMBERS]> {
        let [kinetic, internal] = self.energies;
        let (whole, inside) = (self.seconds, self.loop_seconds);
        Some([
            self.found.number()?,
            self.elements as f64,
            self.increments as f64,
            kinetic,
            internal,
            whole.median,
            whole.min,
            whole.max,
            inside.median,
            inside.min,
            inside.max,
        ])
    }

    /// Returns the run with these values and warnings; `None` if their number is wrong.
    fn of(numbers: &[f64], warnings: &[String]) -> Option<StudyRun> {
        let [found, elements, increments, kinetic, internal, times @ ..] = numbers else { return None };
        let [median, min, max, inside_median, inside_min, inside_max] = *times else { return None };
        Some(StudyRun {
            found: QuantityValue::Number(*found),
            warnings: warnings.to_vec(),
            elements: *elements as usize,
            increments: *increments as u64,
            energies: [*kinetic, *internal],
            seconds: TimeSpread { median, min, max },
            loop_seconds: TimeSpread { median: inside_median, min: inside_min, max: inside_max },
        })
    }

    /// Returns elements and facets times increments: the cost of a run, independent of the machine.
    pub fn element_cycles(&self) -> f64 {
        self.elements as f64 * self.increments as f64
    }
}

/// Run times of repeated runs, in seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct TimeSpread {
    /// Median run time.
    pub median: f64,
    /// Shortest run time.
    pub min: f64,
    /// Longest run time.
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
    /// Creates a runner that runs each setting `repeat` times and calls `done` after each run.
    pub fn new(
        source: &'a DeckReader<'a>,
        overrides: &ParameterOverrides,
        user: Option<&'a Compiled>,
        measure: &'a Quantity,
        repeat: usize,
        done: &'a dyn Fn(),
    ) -> Self {
        let source = RunSource { deck: source, user, interrupt: None };
        StudyRunner {
            source,
            overrides: overrides.to_vec(),
            measure,
            repeat: repeat.max(1),
            done,
            spent: 0.0,
            limit: None,
            log: None,
        }
    }

    /// Takes finished runs from a list and adds others to it; `identity` is the hash of deck and request.
    pub fn logged(&mut self, log: &'a RunLog, identity: String) {
        self.log = Some(StudyLog { log, identity, settings: 0 });
    }

    /// Sets the interrupt: a nonzero value halts the runs.
    pub fn interrupted_by(&mut self, interrupt: &'a AtomicUsize) {
        self.source.interrupt = Some(interrupt);
    }

    /// Limits the time of all runs; `announce` shows the expected time of each level before it starts.
    pub fn limited_to(&mut self, budget: Duration, announce: &'a dyn Fn(&str)) {
        self.limit = Some(TimeLimit { begin: Stopwatch::now(), budget, announce });
    }

    /// Returns whether a level with estimated element-cycles fits into the time limit, from the run time of the last
    /// one, and shows its expected time.
    pub fn affords(&self, last: Option<&StudyRun>, name: &str, cycles: Option<f64>) -> bool {
        let Some((limit, (last, cycles))) = self.limit.as_ref().zip(last.zip(cycles)) else { return true };
        let seconds = last.seconds.median * cycles / last.element_cycles().max(1.0);
        let remaining = limit.budget.saturating_sub(limit.begin.elapsed()).as_secs_f64();
        let affordable = RESERVE * seconds * self.repeat as f64 <= remaining;
        let verdict = if affordable { "" } else { ", outside the budget" };
        (limit.announce)(&format!(
            "{name}: about {} expected, {} of the budget left{verdict}",
            duration(seconds),
            duration(remaining)
        ));
        affordable
    }

    /// Returns the quantity that is evaluated for each setting.
    pub fn measure(&self) -> &'a Quantity {
        self.measure
    }

    /// Returns the deck and the user subroutines.
    pub fn source(&self) -> RunSource<'a> {
        self.source
    }

    /// Returns the number of runs of each setting.
    pub fn repeat(&self) -> usize {
        self.repeat
    }

    /// Returns the total time of all runs so far, in seconds.
    pub fn spent(&self) -> f64 {
        self.spent
    }

    /// Runs the deck with one value for each axis; `change` edits the model after the edits of the axes.
    pub fn at(
        &mut self,
        axes: &[StudyAxis],
        values: &[String],
        change: Option<ModelEdit>,
    ) -> Result<StudyRun, StudyError> {
        let (overrides, mut edits) = self.setting(axes, values)?;
        edits.extend(change);
        self.edited(&overrides, &edits)
    }

    /// Runs the deck with one value for each axis once for each change of the model, in parallel. Returns the result of
    /// each quantity for each run.
    pub fn changed(
        &mut self,
        axes: &[StudyAxis],
        values: &[String],
        changes: Vec<ModelEdit>,
        quantities: &[Quantity],
    ) -> Result<Vec<Vec<Result<StudyRun, StudyError>>>, StudyError> {
        let begin = Stopwatch::now();
        let (overrides, edits) = self.setting(axes, values)?;
        let source = self.source;
        let run = |change: &ModelEdit| source.run(&overrides, &[&edits, std::slice::from_ref(change)], quantities);
        let listed = self.log.as_mut().map(|log| (log.next_key(&overrides), log.log));
        let listed_run = |(index, change): (usize, &ModelEdit)| match &listed {
            None => run(change),
            Some((key, log)) => run_listed(log, &format!("{key}/{index}"), &mut || run(change)),
        };
        let runs: Vec<_> = changes.par_iter().enumerate().map(listed_run).collect();
        self.spent += begin.elapsed().as_secs_f64();
        runs.iter().for_each(|_| (self.done)());
        Ok(runs)
    }

    /// Returns the overrides of the deck and the edits of the model for one value of each axis.
    pub(super) fn setting(&self, axes: &[StudyAxis], values: &[String]) -> Result<RunSetting, StudyError> {
        let mut overrides = self.overrides.clone();
        let mut edits: Vec<ModelEdit> = Vec::new();
        for (axis, value) in axes.iter().zip(values) {
            match &axis.parameter {
                StudyParameter::Parameter(name) => overrides.push((name.clone(), value.clone())),
                StudyParameter::Mesh => overrides.push((axis.name.clone(), value.clone())),
                parameter => edits.extend(edit(parameter, value).map_err(StudyError::Setting)?),
            }
        }
        Ok((overrides, edits))
    }

    fn edited(&mut self, overrides: &ParameterOverrides, edits: &[ModelEdit]) -> Result<StudyRun, StudyError> {
        match self.log.as_mut().map(|log| (log.next_key(overrides), log.log)) {
            None => self.repeated(overrides, edits),
            Some((key, log)) => {
                let mut runs = 0;
                let found = run_listed(log, &key, &mut || {
                    runs = self.repeat;
                    vec![self.repeated(overrides, edits)]
                });
                (runs..self.repeat).for_each(|_| (self.done)());
                found.into_iter().next().unwrap_or_else(|| Err(StudyError::Comparison("no run".into())))
            }
        }
    }

    /// Runs a setting as often as requested.
    fn repeated(&mut self, overrides: &ParameterOverrides, edits: &[ModelEdit]) -> Result<StudyRun, StudyError> {
        let (mut whole, mut inside) = (Vec::new(), Vec::new());
        let mut first = None;
        for _ in 0..self.repeat {
            let begin = Stopwatch::now();
            let run = self.source.run(overrides, &[edits], std::slice::from_ref(self.measure)).swap_remove(0);
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
}

/// Returns the results of runs from a list of finished runs, or makes the runs and adds them to the list. Runs with fields and
/// runs that fail are not listed.
fn run_listed(
    log: &RunLog,
    key: &str,
    run: &mut dyn FnMut() -> Vec<Result<StudyRun, StudyError>>,
) -> Vec<Result<StudyRun, StudyError>> {
    let listed = log
        .known(key)
        .map(|known| known.values.chunks(StudyRun::NUMBERS).map(|numbers| StudyRun::of(numbers, &known.warnings)));
    if let Some(runs) = listed.and_then(Iterator::collect::<Option<Vec<StudyRun>>>) {
        return runs.into_iter().map(Ok).collect();
    }
    let begin = Stopwatch::now();
    let runs = run();
    let numbers = runs.iter().map(|run| run.as_ref().ok()?.numbers()).collect::<Option<Vec<_>>>();
    if let Some(numbers) = numbers {
        let warnings = runs.iter().flatten().next().map(|run| run.warnings.clone()).unwrap_or_default();
        log.add(key, &FinishedValues { values: numbers.concat(), warnings }, begin.elapsed());
    }
    runs
}

/// Returns the number of elements and facets of a run.
pub fn element_count(prepared: &PreparedJob) -> usize {
    prepared.plan.mesh.elements.iter().filter(|e| !e.kind.is_discrete()).count()
}

/// Overrides of the deck, and edits of the model.
pub(super) type RunSetting = (Vec<(String, String)>, Vec<ModelEdit>);

impl RunSource<'_> {
    /// Runs the deck once, with the edits of all lists, and returns a result for each quantity.
    pub fn run(
        &self,
        overrides: &ParameterOverrides,
        edits: &[&[ModelEdit]],
        quantities: &[Quantity],
    ) -> Vec<Result<StudyRun, StudyError>> {
        self.measured(overrides, edits, quantities).unwrap_or_else(|reason| vec![Err(reason); quantities.len()])
    }

    fn measured(
        &self,
        overrides: &ParameterOverrides,
        edits: &[&[ModelEdit]],
        quantities: &[Quantity],
    ) -> Result<Vec<Result<StudyRun, StudyError>>, StudyError> {
        let routines = Compiled::open_any(self.user)?;
        let mut fault = Ok(());
        let mut change = |model: &mut Model| {
            fault = edits.iter().copied().flatten().try_for_each(|edit| edit(model));
        };
        let prepared = accepted(job::prepare_edited((self.deck)(overrides), &mut change, &routines))?;
        fault?;
        let mut history = quantity::history(quantities, &prepared.plan);
        let never = AtomicUsize::new(0);
        let (outcome, state) = job::run_until(&prepared, &mut history, self.interrupt.unwrap_or(&never));
        let warnings = outcome.all_warnings();
        if let Some(halt) = outcome.halt {
            return Err(StudyError::Halted(halt));
        }
        let finished = FinishedRun { history: &history, end: Some((outcome.total_time(), &state)) };
        let elements = element_count(&prepared);
        let seconds = TimeSpread { median: outcome.seconds, ..TimeSpread::default() };
        let result = |quantity: &Quantity| {
            let quantity_value = quantity.evaluate(finished)?;
            let (increments, warnings) = (outcome.increments, warnings.clone());
            let energies = [outcome.energy.kinetic, outcome.energy.internal];
            Ok(StudyRun {
                found: quantity_value,
                warnings,
                elements,
                increments,
                energies,
                seconds,
                loop_seconds: seconds,
            })
        };
        Ok(quantities.iter().map(result).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::TimeSpread;

    #[test]
    fn median_of_an_even_number_is_the_mean_of_the_middle_two() {
        assert_eq!(TimeSpread::of(&mut [3.0, 1.0, 2.0]), TimeSpread { median: 2.0, min: 1.0, max: 3.0 });
        assert_eq!(TimeSpread::of(&mut [3.0, 1.0]).median, 2.0);
    }
}
