//! Evaluation of quantities for samples of deck parameters, for uncertainty quantification, optimisation and design: a
//! table of inputs gives a table of outputs, bit-identical for any number of threads.

mod derivatives;

use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant as Stopwatch};

pub use derivatives::{RELATIVE_ERROR, SampleDerivatives};

use super::StudyError;
use super::error::accepted;
use super::log::{FinishedValues, RunLog};
use super::passage::{self, PassageEnd};
use super::quantity::{self, FinishedRun, Quantity};
use super::shot::{self, ShotEnd, ShotResult, ShotRule};
use crate::deck::names::nearest;
use crate::deck::template::DeckTemplate;
use crate::deck::{self, Deck, Diagnostics};
use crate::job::{self, ParameterOverrides};
use crate::model::revise::{self, RevisableNumber};
use crate::model::{self, Model};
use crate::output::RunHistory;
use crate::output::checkpoint::hash;
use crate::plan::revise::{PlanReviser, RevisablePlan};
use crate::plan::{self, ColumnSource, CompiledModel, HistoryColumn, Plan, State, WriteSchedule};
use crate::solve::{self, Instant, Progress, RunControl, RunEnd, Sink, SinkError, StagedShots};
use crate::user::compile::Compiled;
use crate::user::{Routines, thread_pool};
use crate::variables::Variable;

/// Source of a deck: a file or a text in memory.
#[derive(Clone, Debug)]
pub enum DeckSource {
    /// Path of a deck file, read again for each sample that needs it.
    File(PathBuf),
    /// File name and text in memory; the name is used in messages and for relative paths.
    Text(String, String),
}

impl DeckSource {
    /// Reads the deck with the given parameter values.
    pub fn read(&self, overrides: &ParameterOverrides) -> (Deck, Diagnostics) {
        match self {
            DeckSource::File(path) => deck::read(path, overrides),
            DeckSource::Text(name, text) => deck::read_text(name, text, overrides),
        }
    }
}

/// User subroutines of the samples.
#[derive(Default)]
pub enum UserRoutines {
    /// No user subroutines.
    #[default]
    Absent,
    /// Compiled files, loaded again for each sample, so that internal data have their initial values.
    Files(Arc<Compiled>),
    /// Subroutines without data that persist between samples; created once per thread.
    Stateless(Box<dyn Fn() -> Routines + Send + Sync>),
}

impl UserRoutines {
    fn routines(&self) -> Result<Routines, StudyError> {
        match self {
            UserRoutines::Absent => Ok(Routines::none()),
            UserRoutines::Files(compiled) => Ok(compiled.open()?),
            UserRoutines::Stateless(make) => Ok(make()),
        }
    }
}

/// Evaluator of quantities for samples of deck parameters.
pub struct SampleEvaluator {
    source: DeckSource,
    fixed: Vec<(String, String)>,
    names: Vec<String>,
    quantities: Vec<Quantity>,
    /// Value of each parameter in the deck with the fixed values; `None` for text.
    nominal: Vec<Option<f64>>,
    /// Whether the model has deformable elements or free nodes.
    deforms: bool,
    user: UserRoutines,
    /// Largest number of threads that one run can use.
    most_threads: usize,
    /// Whether the quantities need only the last history row.
    only_last_row: bool,
    /// Whether all runs are integrated in increments.
    stepped: bool,
    /// Idle workers, reused by later calls.
    idle: Mutex<Vec<SampleWorker>>,
    /// Present if the samples are shots: the last step is extended while a body moves in a target, and the end of the
    /// shot is recorded.
    shots: Option<ShotRule>,
    /// Number of samples so far with a body still moving in a target at the end.
    still_moving: AtomicUsize,
    /// Indices of the quantities that sample k evaluates, in entry k modulo the length.
    selections: Vec<Vec<usize>>,
    /// List of finished samples, and the hash of everything else on which a sample depends.
    log: Option<(Arc<RunLog>, String)>,
}

/// Table of samples: the parameter values of all runs.
#[derive(Clone, Copy, Debug)]
pub struct SampleTable<'a> {
    /// Values row by row: one row per sample, one number per parameter.
    pub values: &'a [f64],
    /// Number of samples (rows).
    pub count: usize,
}

/// Error of a sample; its row of the table is NaN.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleFailure {
    /// Index of the sample, from 0.
    pub row: usize,
    /// Error of the run.
    pub reason: StudyError,
}

/// Largest number of samples that a thread takes at once.
const CHUNK: usize = 256;
/// Interval at which the waiting thread reports progress and checks for interrupts.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

impl SampleEvaluator {
    /// Creates an evaluator of `quantities` over the parameters `names`; `fixed` are values of other parameters.
    pub fn new(
        source: DeckSource,
        fixed: Vec<(String, String)>,
        names: Vec<String>,
        quantities: Vec<Quantity>,
        user: UserRoutines,
    ) -> Result<SampleEvaluator, StudyError> {
        let prepared = accepted(job::prepare_read(source.read(&fixed), &user.routines()?))?;
        let known: Vec<&str> = prepared.deck.definitions.iter().map(|d| d.name.as_str()).collect();
        if let Some(name) = names.iter().find(|name| !known.contains(&name.as_str())) {
            let near = nearest(name, known.iter().copied()).map(|near| format!("; did you mean {near}?"));
            let hint = near.unwrap_or_else(|| format!("; it defines {}", known.join(", ")));
            return Err(StudyError::Setting(format!("the deck defines no parameter {name}{hint}")));
        }
        quantity::check_all(&quantities, &prepared.plan)?;
        let value = |name: &String| prepared.deck.parameters.iter().rev().find(|p| p.0 == *name).map(|p| p.1);
        let nominal = names.iter().map(value).collect();
        let deforms = !prepared.state.dofs.nodes.is_empty();
        let ends_alone = quantities.iter().all(Quantity::needs_last_row_only);
        let (most_threads, idle) = (prepared.most_threads(), Mutex::default());
        let every_quantity = (0..quantities.len()).collect();
        let (shots, still_moving) = (None, AtomicUsize::new(0));
        Ok(SampleEvaluator {
            source,
            fixed,
            names,
            quantities,
            nominal,
            deforms,
            user,
            most_threads,
            only_last_row: ends_alone,
            stepped: false,
            idle,
            shots,
            still_moving,
            selections: vec![every_quantity],
            log: None,
        })
    }

    /// Makes sample k evaluate only the quantities with the indices in entry k modulo the length of `selections`; the
    /// other cells of its row are NaN. Without selections all samples evaluate all quantities.
    #[must_use]
    pub fn with_selections(self, selections: Vec<Vec<usize>>) -> SampleEvaluator {
        if selections.is_empty() { self } else { SampleEvaluator { selections, ..self } }
    }

    /// Integrates all runs in increments, as [`solve::run`] does, with the same bits. By default, shots of rigid bodies
    /// are solved by [stages](StagedShots) where the plan and the quantities allow it.
    #[must_use]
    pub fn in_increments(self) -> SampleEvaluator {
        SampleEvaluator { stepped: true, ..self }
    }

    /// Takes finished samples from a list and adds others to it. Shots by stages are not listed: they take microseconds.
    ///
    /// # Errors
    /// If the deck cannot be read again.
    pub(crate) fn logged(self, log: &Arc<RunLog>) -> Result<SampleEvaluator, StudyError> {
        let prepared = accepted(job::prepare_read(self.source.read(&self.fixed), &self.user.routines()?))?;
        let user = if let UserRoutines::Files(compiled) = &self.user { compiled.identity() } else { String::new() };
        let quantities: Vec<&str> = self.quantities.iter().map(|quantity| quantity.text.as_str()).collect();
        let description = format!(
            "{:?} {:?} {quantities:?} {:?} {:?} {}",
            prepared.identity(&user),
            self.names,
            self.stepped,
            self.shots.map(|rule| rule.least),
            env!("CARGO_PKG_VERSION")
        );
        Ok(SampleEvaluator { log: Some((Arc::clone(log), hash([description.as_bytes()]))), ..self })
    }

    /// Makes an evaluator of [`shots`](SampleEvaluator::shots). The first quantity, if there is one, is the residual
    /// velocity; without rigid bodies that meet a target, a shot moves as long as it falls and is above `least`.
    #[must_use]
    pub fn of_shots(self, least: Option<f64>) -> SampleEvaluator {
        SampleEvaluator { shots: Some(ShotRule { least }), ..self }
    }

    /// Returns the number of samples so far in which a body was still moving in a target at the end; their depths are
    /// not final.
    pub fn still_moving(&self) -> usize {
        self.still_moving.load(Ordering::Relaxed)
    }

    /// Returns the number of parameters of a sample.
    pub fn width(&self) -> usize {
        self.names.len()
    }

    /// Returns the value of each parameter in the deck with the fixed values; `None` for a text.
    pub fn nominal_values(&self) -> &[Option<f64>] {
        &self.nominal
    }

    /// Returns whether the model has deformable elements or free nodes.
    pub fn deforms(&self) -> bool {
        self.deforms
    }

    /// Evaluates all samples into `table`, one row per sample and one number per quantity, NaN if a sample fails. Rows
    /// of shots have two more numbers. Returns the failures. `look` receives the number of finished samples several
    /// times a second; a nonzero `interrupt` ends the evaluation. The table does not depend on the number of threads.
    pub fn run(
        &self,
        samples: SampleTable<'_>,
        table: &mut [f64],
        threads: usize,
        interrupt: &AtomicUsize,
        look: &mut dyn FnMut(usize),
    ) -> Result<Vec<SampleFailure>, StudyError> {
        let threads = threads.clamp(1, samples.count.max(1));
        let batch = SampleBatch { evaluator: self, samples, interrupt };
        let mut failures = if threads == 1 && self.most_threads <= 1 {
            batch.run_here(table, look)
        } else {
            batch.run_over(table, threads, look)?
        };
        failures.sort_by_key(|f| f.row);
        Ok(failures)
    }

    /// Evaluates all samples without progress reports. Returns the table, one row of quantities per sample, and the
    /// failures.
    pub fn table(&self, samples: &[f64], threads: usize) -> Result<(Vec<f64>, Vec<SampleFailure>), StudyError> {
        let count = samples.len() / self.width().max(1);
        let mut table = vec![f64::NAN; count * self.row_width()];
        let samples = SampleTable { values: samples, count };
        let failures = self.run(samples, &mut table, threads, &AtomicUsize::new(0), &mut |_| {})?;
        Ok((table, failures))
    }

    /// Runs all samples as shots at targets: a run whose bodies still move in their targets at its end is repeated with
    /// an extended last step, up to 64 times as long.
    pub fn shots(&self, samples: &[f64], threads: usize) -> Result<Vec<ShotResult>, StudyError> {
        let (table, failures) = self.table(samples, threads)?;
        let mut shots: Vec<ShotResult> = table.chunks(self.row_width()).map(|row| Ok(shot::decode(row))).collect();
        failures.into_iter().for_each(|failure| shots[failure.row] = Err(failure.reason));
        Ok(shots)
    }

    /// Returns the number of cells of a row of the table.
    fn row_width(&self) -> usize {
        self.quantities.len() + if self.shots.is_some() { shot::CELLS } else { 0 }
    }

    /// Runs a plan with the duration of its last step; repeats a shot with longer ones as long as `run` returns a
    /// remaining time above zero.
    fn run_extended(
        &self,
        duration: f64,
        run: &mut dyn FnMut(f64) -> Result<f64, StudyError>,
    ) -> Result<(), StudyError> {
        let mut factor = Some(1.0);
        while let Some(longer) = factor {
            factor = shot::longer(longer, run(longer * duration)? / duration);
        }
        Ok(())
    }

    fn worker(&self) -> SampleWorker {
        lock(&self.idle).pop().unwrap_or_else(|| SampleWorker { plan: ReusablePlan::new(self).map(Box::new) })
    }

    fn return_worker(&self, worker: SampleWorker) {
        lock(&self.idle).push(worker);
    }

    /// Returns the parameter values of a sample as text, as on the command line.
    fn overrides(&self, sample: &[f64]) -> Vec<(String, String)> {
        let sampled = self.names.iter().zip(sample).map(|(name, value)| (name.clone(), format!("{value:?}")));
        let fixed = self.fixed.iter().filter(|(name, _)| !self.names.contains(name));
        fixed.cloned().chain(sampled).collect()
    }

    /// Removes frames and unused history rows from the output requests of a plan.
    fn reduce_output(&self, plan: &mut Plan) {
        let only_last_row = self.only_last_row && !self.needs_rows(plan) && !self.uses_means(plan);
        for step in &mut plan.steps {
            step.outputs.field.clear();
            if only_last_row && !step.outputs.history.is_empty() {
                step.outputs.history = vec![WriteSchedule::Time(f64::INFINITY)];
            }
        }
    }

    /// Returns whether a quantity uses means over the interval between rows: reactions and forces of contact pairs, also in
    /// an expression of the deck.
    fn uses_means(&self, plan: &Plan) -> bool {
        let is_mean = |column: &HistoryColumn| {
            let variable = column.part.map(|part| part.variable);
            matches!(column.source, ColumnSource::Pair(_))
                || matches!(variable, Some(Variable::Reaction | Variable::ReactionMoment))
        };
        let is_or_has_mean = |column: &HistoryColumn| match column.source {
            ColumnSource::Expression(_) => plan.columns.iter().any(is_mean),
            _ => is_mean(column),
        };
        let is_used = |name: &str| {
            let mut columns = plan.columns.iter().filter(|column| column.name.eq_ignore_ascii_case(name));
            columns.any(is_or_has_mean)
        };
        self.quantities.iter().flat_map(Quantity::columns).any(is_used)
    }

    /// Returns whether the end of shots is judged by the course of the residual velocity.
    fn needs_rows(&self, plan: &Plan) -> bool {
        self.shots.is_some() && !self.quantities.is_empty() && !plan.places.elements.is_empty()
    }

    /// Returns the shots of a plan by stages; `None` if the plan or a quantity does not allow it.
    fn staged(&self, plan: &Plan, start: &State) -> Option<StagedShots> {
        if self.stepped || !self.only_last_row {
            return None;
        }
        let staged = StagedShots::new(plan, start)?;
        let mut columns = self.quantities.iter().flat_map(Quantity::columns);
        columns.all(|name| staged.has_column(name, plan)).then_some(staged)
    }

    /// Creates a history that stores the data needed for all quantities and for the ends of shots.
    fn history(&self, plan: &Plan) -> RunHistory {
        if self.needs_rows(plan) {
            RunHistory::of_rows(plan.column_names())
        } else {
            quantity::history(&self.quantities, plan)
        }
    }

    /// Evaluates the row of a run that began from the state `start`. Returns the remaining time of a shot: zero if it has
    /// ended, infinite if it is unknown.
    fn finish(&self, run: EndedRun<'_>, start: &State, out: &mut [f64]) -> Result<f64, StudyError> {
        let EndedRun { row, plan, history, end: run_end, state } = run;
        let end = Some((run_end.total_time, state));
        let recorded = shot::end(&run_end.impacts, &start.dofs.bodies);
        run_end.halt.map_or(Ok(()), |halt| Err(StudyError::Halted(halt)))?;
        if run_end.still_moving > 0 {
            self.still_moving.fetch_add(1, Ordering::Relaxed);
        }
        out.fill(f64::NAN);
        for &i in &self.selections[row % self.selections.len()] {
            out[i] = self.quantities[i].number(FinishedRun { history, end })?;
        }
        let Some(rule) = self.shots else { return Ok(0.0) };
        let passed = if recorded.is_none() { passage::end(plan, start, state) } else { None };
        let least = rule.least.unwrap_or(0.0);
        let is_slow = |passed: &PassageEnd| passed.end == ShotEnd::Moving && passed.speed <= least;
        let of_passage = |passed: PassageEnd| (if is_slow(&passed) { ShotEnd::Slow } else { passed.end }, passed.speed);
        let end_and_speed = recorded.or(passed.map(of_passage));
        let residual = self.quantities.first().filter(|_| end_and_speed.is_none());
        let is_moving = residual.is_some_and(|residual| rule.may_fall(residual, history, out[0]));
        let end_and_speed = if is_moving { Some((ShotEnd::Moving, out[0])) } else { end_and_speed };
        out[self.quantities.len()..].copy_from_slice(&shot::encode(end_and_speed));
        let is_late = passed.is_some_and(|passed| passed.end == ShotEnd::NotMet);
        let has_ended = !is_late && end_and_speed.is_none_or(|(end, _)| end != ShotEnd::Moving);
        Ok(if has_ended { 0.0 } else { passed.map_or(f64::INFINITY, |passed| passed.remaining) })
    }
}

/// Results of a run that has ended.
struct EndedRun<'a> {
    /// Index of the sample.
    row: usize,
    plan: &'a Plan,
    history: &'a RunHistory,
    end: RunEnd,
    /// State at the end. Of shots by stages, which have no nodes, that at the start.
    state: &'a State,
}

/// Samples of one call.
struct SampleBatch<'a> {
    evaluator: &'a SampleEvaluator,
    samples: SampleTable<'a>,
    interrupt: &'a AtomicUsize,
}

impl SampleBatch<'_> {
    fn is_interrupted(&self) -> bool {
        self.interrupt.load(Ordering::Relaxed) != 0
    }

    fn run_here(&self, table: &mut [f64], look: &mut dyn FnMut(usize)) -> Vec<SampleFailure> {
        let mut worker = self.evaluator.worker();
        let mut failures = Vec::new();
        let rows = table.chunks_exact_mut(self.evaluator.row_width().max(1));
        for (row, out) in rows.enumerate().take(self.samples.count) {
            failures.extend(self.row(&mut worker, row, out, &mut || look(row)));
            if row % CHUNK == CHUNK - 1 {
                look(row + 1);
            }
            if self.is_interrupted() {
                break;
            }
        }
        self.evaluator.return_worker(worker);
        failures
    }

    fn run_over(
        &self,
        table: &mut [f64],
        threads: usize,
        look: &mut dyn FnMut(usize),
    ) -> Result<Vec<SampleFailure>, StudyError> {
        let wrong = |e: rayon::ThreadPoolBuildError| StudyError::Setting(format!("cannot start threads: {e}"));
        let pool = thread_pool(threads).build().map_err(wrong)?;
        let size = (self.samples.count / (16 * threads)).clamp(1, CHUNK);
        let width = self.evaluator.row_width().max(1);
        let chunks = Mutex::new(table.chunks_mut(size * width).enumerate());
        // A separate call, so that the lock is released before the chunk is run.
        let take = || lock(&chunks).next();
        let (finished, failures) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
        let (ended, ends) = std::sync::mpsc::channel();
        pool.in_place_scope(|scope| {
            for _ in 0..threads {
                let (ended, take, finished, failures) = (ended.clone(), &take, &finished, &failures);
                scope.spawn(move |_| {
                    let mut worker = self.evaluator.worker();
                    while let Some((chunk, out)) = take().filter(|_| !self.is_interrupted()) {
                        for (i, out) in out.chunks_mut(width).enumerate() {
                            if let Some(failure) = self.row(&mut worker, chunk * size + i, out, &mut || {}) {
                                lock(failures).push(failure);
                            }
                            finished.fetch_add(1, Ordering::Relaxed);
                            if self.is_interrupted() {
                                break;
                            }
                        }
                    }
                    self.evaluator.return_worker(worker);
                    // The receiver may have been dropped.
                    let _ = ended.send(());
                });
            }
            let mut working = threads;
            while working > 0 {
                match ends.recv_timeout(POLL_INTERVAL) {
                    Ok(()) => working -= 1,
                    Err(_) => look(finished.load(Ordering::Relaxed)),
                }
            }
        });
        Ok(failures.into_inner().unwrap_or_else(PoisonError::into_inner))
    }

    /// Runs one sample and returns its failure, if any.
    fn row(
        &self,
        worker: &mut SampleWorker,
        row: usize,
        out: &mut [f64],
        look: &mut dyn FnMut(),
    ) -> Option<SampleFailure> {
        let width = self.evaluator.width();
        let sample = &self.samples.values[row * width..(row + 1) * width];
        let mut revised = worker.plan.as_mut().and_then(|plan| plan.revise(self.evaluator, sample).then_some(plan));
        let is_staged = revised.as_ref().is_some_and(|plan| plan.staged.is_some());
        let run = &mut |out: &mut [f64]| match &mut revised {
            Some(plan) => plan.run(self, row, out, look),
            None => self.run_anew(row, sample, out, look),
        };
        let result = match self.evaluator.log.as_ref().filter(|_| !is_staged) {
            None => run(out),
            Some((log, identity)) => self.run_listed(log, &self.key(identity, row, sample), out, run),
        };
        result.err().map(|reason| {
            out.fill(f64::NAN);
            SampleFailure { row, reason }
        })
    }

    /// Takes the results of a sample from a list of finished runs, or runs it and adds it to the list.
    fn run_listed(
        &self,
        log: &RunLog,
        key: &str,
        out: &mut [f64],
        run: &mut dyn FnMut(&mut [f64]) -> Result<(), StudyError>,
    ) -> Result<(), StudyError> {
        if let Some(known) = log.known(key).filter(|known| known.values.len() == out.len()) {
            out.copy_from_slice(&known.values);
            return Ok(());
        }
        let (begin, moving_before) = (Stopwatch::now(), self.evaluator.still_moving());
        run(out)?;
        // A sample whose body still moves is counted, also when the command continues: it is run again.
        let is_counted = self.evaluator.shots.is_none() && self.evaluator.still_moving() != moving_before;
        if !is_counted && !self.is_interrupted() {
            log.add(key, &FinishedValues { values: out.to_vec(), warnings: Vec::new() }, begin.elapsed());
        }
        Ok(())
    }

    /// Returns the key of a sample in a list of finished runs.
    fn key(&self, identity: &str, row: usize, sample: &[f64]) -> String {
        let selection = format!("{:?}", self.evaluator.selections[row % self.evaluator.selections.len()]);
        let values: Vec<u8> = sample.iter().flat_map(|value| value.to_bits().to_le_bytes()).collect();
        hash([identity.as_bytes(), selection.as_bytes(), &values])
    }

    /// Runs a sample from the text of the deck, without a reusable plan.
    fn run_anew(&self, row: usize, sample: &[f64], out: &mut [f64], look: &mut dyn FnMut()) -> Result<(), StudyError> {
        let evaluator = self.evaluator;
        let routines = evaluator.user.routines()?;
        let read = evaluator.source.read(&evaluator.overrides(sample));
        let mut prepared = accepted(job::prepare_read(read, &routines))?;
        evaluator.reduce_output(&mut prepared.plan);
        let mut staged = evaluator.staged(&prepared.plan, &prepared.state);
        evaluator.run_extended(last_duration(&prepared.plan), &mut |duration| {
            prepared.plan.set_last_duration(duration);
            let (plan, start) = (&prepared.plan, &prepared.state);
            let mut history = evaluator.history(plan);
            let mut sink = HistorySink { history: &mut history, look };
            let staged = staged.as_mut().filter(|_| !self.is_interrupted());
            if let Some(end) = staged.and_then(|staged| staged.run(plan, start, &mut sink)) {
                return evaluator.finish(EndedRun { row, plan, history: &history, end, state: start }, start, out);
            }
            let (outcome, state) = job::run_until(&prepared, &mut sink, self.interrupt);
            let ended = EndedRun { row, plan, history: &history, end: outcome.into(), state: &state };
            evaluator.finish(ended, start, out)
        })
    }
}

fn last_duration(plan: &Plan) -> f64 {
    plan.steps.last().map_or(0.0, |step| step.duration)
}

fn lock<T>(shared: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Data that one thread reuses for all its samples.
struct SampleWorker {
    plan: Option<Box<ReusablePlan>>,
}

/// A model in which only numbers change between samples, and its plan.
struct ReusablePlan {
    template: DeckTemplate,
    places: Vec<RevisableNumber>,
    model: Model,
    routines: Routines,
    plan: Plan,
    state: State,
    /// `None` if the plan must be compiled for each sample.
    reviser: Option<PlanReviser>,
    /// `None` if the motion must be integrated in increments.
    staged: Option<StagedShots>,
    history: RunHistory,
    /// Work arrays: parameter values, and the numbers of deck words that contain parameters.
    values: Vec<f64>,
    numbers: Vec<f64>,
}

impl ReusablePlan {
    /// Returns `None` if samples differ in more than numbers of one model, or if user subroutine files must be loaded
    /// for each sample.
    fn new(evaluator: &SampleEvaluator) -> Option<ReusablePlan> {
        if matches!(evaluator.user, UserRoutines::Files(_)) {
            return None;
        }
        let routines = evaluator.user.routines().ok()?;
        let (deck, _) = evaluator.source.read(&evaluator.fixed);
        let template = DeckTemplate::of(&deck, &evaluator.names)?;
        let model = model::build(&deck).0;
        let places = template.words.iter().map(|word| revise::revisable(&model, &deck, word));
        let places = places.collect::<Option<Vec<_>>>()?;
        let RevisablePlan { mut plan, state, reviser } = plan::revise::compile(&model, &routines, &places);
        evaluator.reduce_output(&mut plan);
        let history = evaluator.history(&plan);
        let staged = evaluator.staged(&plan, &state);
        let (values, numbers) = (Vec::new(), Vec::new());
        Some(ReusablePlan { template, places, model, routines, plan, state, reviser, staged, history, values, numbers })
    }

    /// Changes the model to the values of a sample; returns whether this is possible.
    fn revise_model(&mut self, sample: &[f64]) -> bool {
        self.template.numbers(sample, &mut self.values, &mut self.numbers)
            && self.places.iter().zip(&self.numbers).all(|(place, value)| revise::set(&mut self.model, *place, *value))
    }

    /// Changes a revisable plan without its stages to the values of a sample; returns whether this is possible.
    fn revise_plan(&mut self, sample: &[f64]) -> bool {
        let is_changed = self.revise_model(sample);
        let reviser = self.reviser.as_mut().filter(|_| is_changed);
        reviser.is_some_and(|r| r.revise(&self.model, &self.routines, &mut self.plan, &mut self.state))
    }

    /// Changes the plan to the values of a sample; returns whether this is possible.
    fn revise(&mut self, evaluator: &SampleEvaluator, sample: &[f64]) -> bool {
        let is_valid = match self.reviser {
            Some(_) => self.revise_plan(sample),
            None => self.revise_model(sample) && self.compile(evaluator),
        };
        if is_valid && self.reviser.as_ref().is_none_or(PlanReviser::changes_forces) {
            self.staged = evaluator.staged(&self.plan, &self.state);
        }
        is_valid
    }

    /// Compiles the plan of the changed model; returns whether it has no errors.
    fn compile(&mut self, evaluator: &SampleEvaluator) -> bool {
        // Only one plan is in memory at a time.
        (self.plan, self.state) = (Plan::default(), State::default());
        let CompiledModel { plan, state, diagnostics } = plan::compile(&self.model, &self.routines);
        (self.plan, self.state) = (plan, state);
        evaluator.reduce_output(&mut self.plan);
        !diagnostics.has_errors()
    }

    fn run(
        &mut self,
        batch: &SampleBatch<'_>,
        row: usize,
        out: &mut [f64],
        look: &mut dyn FnMut(),
    ) -> Result<(), StudyError> {
        let ReusablePlan { plan, state: start, staged, history, .. } = self;
        let duration = last_duration(plan);
        let result = batch.evaluator.run_extended(duration, &mut |duration| {
            plan.set_last_duration(duration);
            history.clear();
            let mut sink = HistorySink { history, look };
            let staged = staged.as_mut().filter(|_| !batch.is_interrupted());
            if let Some(end) = staged.and_then(|staged| staged.run(plan, start, &mut sink)) {
                return batch.evaluator.finish(EndedRun { row, plan, history, end, state: start }, start, out);
            }
            let control = RunControl { interrupt: Some(batch.interrupt), ..RunControl::default() };
            let (outcome, state) = solve::run_with(plan, start.clone(), &mut sink, control).unwrap_or_default();
            batch.evaluator.finish(EndedRun { row, plan, history, end: outcome.into(), state: &state }, start, out)
        });
        plan.set_last_duration(duration);
        result
    }
}

/// Sink that collects the history and calls `look` at progress reports.
struct HistorySink<'a> {
    history: &'a mut RunHistory,
    look: &'a mut dyn FnMut(),
}

impl Sink for HistorySink<'_> {
    fn wants_digest(&self) -> bool {
        false
    }

    fn row(&mut self, now: &Instant, values: &[f64]) -> Result<(), SinkError> {
        self.history.push(now, values);
        Ok(())
    }

    fn progress(&mut self, progress: &Progress<'_>) {
        if !progress.ends {
            (self.look)();
        }
    }
}
