//! Quantities of a deck over samples of its parameters, as programs for uncertainty, optimisation and design ask for them:
//! a table of inputs to a table of outputs, from any number of threads to the same bits.

use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use super::StudyError;
use super::error::accepted;
use super::quantity::{self, FinishedRun, Quantity};
use crate::deck::names::nearest;
use crate::deck::template::Template;
use crate::deck::{self, Deck, Diagnostics};
use crate::job::{self, Overrides};
use crate::model::revise::{self, Revisable};
use crate::model::{self, Model};
use crate::output::History;
use crate::plan::revise::Reviser;
use crate::plan::{self, Plan, Schedule, State};
use crate::solve::{self, Control, Instant, Outcome, Progress, Sink, SinkError};
use crate::user::Routines;
use crate::user::compile::Compiled;

/// Where a deck comes from.
#[derive(Clone, Debug)]
pub enum DeckSource {
    /// A file.
    File(PathBuf),
    /// Text in memory, with the name of the file for which it stands.
    Text(String, String),
}

impl DeckSource {
    /// Reads the deck with these values of its parameters.
    pub fn read(&self, overrides: &Overrides) -> (Deck, Diagnostics) {
        match self {
            DeckSource::File(path) => deck::read(path, overrides),
            DeckSource::Text(name, text) => deck::read_text(name, text, overrides),
        }
    }
}

/// The user's routines of samples.
#[derive(Default)]
pub enum UserRoutines {
    /// None.
    #[default]
    Absent,
    /// Compiled files, opened anew for each sample: what routines keep to themselves begins anew.
    Files(Arc<Compiled>),
    /// Routines that keep nothing from one sample to the next, made once for each thread.
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

/// What is evaluated.
pub struct Evaluator {
    source: DeckSource,
    fixed: Vec<(String, String)>,
    names: Vec<String>,
    quantities: Vec<Quantity>,
    user: UserRoutines,
    /// Threads that one run has work for.
    most_threads: usize,
    /// Whether histories are looked at in their last row alone.
    ends_alone: bool,
    /// Workers that wait for samples.
    idle: Mutex<Vec<Worker>>,
    /// Whether a body that still moves in a target at the end of its run leaves the sample without numbers.
    to_the_end: bool,
    /// Samples so far at whose end one did.
    still_moving: AtomicUsize,
}

/// Samples in their order.
#[derive(Clone, Copy, Debug)]
pub struct Samples<'a> {
    /// One row a sample, one number a parameter.
    pub values: &'a [f64],
    /// How many there are.
    pub count: usize,
}

/// Why a sample gave nothing: its row of the table is not a number.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleFailure {
    /// The sample, from 0.
    pub row: usize,
    /// Why.
    pub reason: StudyError,
}

/// The most samples that a thread takes at once.
const CHUNK: usize = 256;
/// The waiting thread looks up this often.
const LOOK: Duration = Duration::from_millis(50);

impl Evaluator {
    /// Quantities over the parameters `names`; `fixed` are values of others.
    pub fn new(
        source: DeckSource,
        fixed: Vec<(String, String)>,
        names: Vec<String>,
        quantities: Vec<Quantity>,
        user: UserRoutines,
    ) -> Result<Evaluator, StudyError> {
        let prepared = accepted(job::prepare_edited(source.read(&fixed), &mut |_| {}, &user.routines()?))?;
        let known: Vec<&str> = prepared.deck.definitions.iter().map(|d| d.name.as_str()).collect();
        if let Some(name) = names.iter().find(|name| !known.contains(&name.as_str())) {
            let near = nearest(name, known.iter().copied()).map(|near| format!("; did you mean {near}?"));
            let there = near.unwrap_or_else(|| format!("; it defines {}", known.join(", ")));
            return Err(StudyError::Setting(format!("the deck defines no parameter {name}{there}")));
        }
        for quantity in &quantities {
            quantity.stands_alone()?;
            quantity.check(&prepared.plan)?;
        }
        let ends_alone = quantities.iter().all(Quantity::looks_at_end_alone);
        let (most_threads, idle) = (prepared.most_threads(), Mutex::default());
        let (to_the_end, still_moving) = (false, AtomicUsize::new(0));
        Ok(Evaluator {
            source,
            fixed,
            names,
            quantities,
            user,
            most_threads,
            ends_alone,
            idle,
            to_the_end,
            still_moving,
        })
    }

    /// The same, where a sample has no numbers if a body still moves in a target at the end of its run.
    #[must_use]
    pub fn to_the_end(self) -> Evaluator {
        Evaluator { to_the_end: true, ..self }
    }

    /// At the end of how many samples so far a body still moved in a target: a depth read there is not its last.
    pub fn still_moving(&self) -> usize {
        self.still_moving.load(Ordering::Relaxed)
    }

    /// Numbers of a sample.
    pub fn width(&self) -> usize {
        self.names.len()
    }

    /// Evaluates all samples into `table`, one row a sample and one number a quantity, NaN where a sample fails; returns the failures.
    /// `look` receives the number of finished samples several times a second; a nonzero `interrupt` ends the evaluation. The table does
    /// not depend on the number of threads.
    pub fn run(
        &self,
        samples: Samples<'_>,
        table: &mut [f64],
        threads: usize,
        interrupt: &AtomicUsize,
        look: &mut dyn FnMut(usize),
    ) -> Result<Vec<SampleFailure>, StudyError> {
        let threads = threads.clamp(1, samples.count.max(1));
        let batch = Batch { evaluator: self, samples, interrupt };
        let mut failures = if threads == 1 && self.most_threads <= 1 {
            batch.run_here(table, look)
        } else {
            batch.run_over(table, threads, look)?
        };
        failures.sort_by_key(|f| f.row);
        Ok(failures)
    }

    /// Runs all samples and gives one row of quantities each, without progress.
    pub fn table(&self, samples: &[f64], threads: usize) -> Result<(Vec<f64>, Vec<SampleFailure>), StudyError> {
        let count = samples.len() / self.width().max(1);
        let mut table = vec![f64::NAN; count * self.quantities.len()];
        let samples = Samples { values: samples, count };
        let failures = self.run(samples, &mut table, threads, &AtomicUsize::new(0), &mut |_| {})?;
        Ok((table, failures))
    }

    fn worker(&self) -> Worker {
        held(&self.idle).pop().unwrap_or_else(|| Worker { plan: ReusablePlan::new(self).map(Box::new) })
    }

    fn rest(&self, worker: Worker) {
        held(&self.idle).push(worker);
    }

    /// The settings of a sample as the command line would have them.
    fn overrides(&self, sample: &[f64]) -> Vec<(String, String)> {
        let given = self.names.iter().zip(sample).map(|(name, value)| (name.clone(), format!("{value:?}")));
        self.fixed.iter().cloned().chain(given).collect()
    }

    /// Rows and frames that nobody looks at are not due.
    fn look_less(&self, plan: &mut Plan) {
        for step in &mut plan.steps {
            step.outputs.field.clear();
            if self.ends_alone && !step.outputs.history.is_empty() {
                step.outputs.history = vec![Schedule::Time(f64::INFINITY)];
            }
        }
    }

    /// Evaluates the quantities of a run.
    fn finish(&self, history: &History, outcome: Outcome, state: &State, out: &mut [f64]) -> Result<(), StudyError> {
        let end = Some((outcome.total_time(), state));
        outcome.halt.map_or(Ok(()), |halt| Err(StudyError::Halted(halt)))?;
        if outcome.still_moving > 0 {
            self.still_moving.fetch_add(1, Ordering::Relaxed);
            if self.to_the_end {
                let why = format!("{}; its steps need more time", outcome.unfinished.join("; "));
                return Err(StudyError::Unfinished(why));
            }
        }
        for (out, quantity) in out.iter_mut().zip(&self.quantities) {
            *out = quantity.number(FinishedRun { history, end })?;
        }
        Ok(())
    }
}

/// Samples that are evaluated together.
struct Batch<'a> {
    evaluator: &'a Evaluator,
    samples: Samples<'a>,
    interrupt: &'a AtomicUsize,
}

impl Batch<'_> {
    fn is_interrupted(&self) -> bool {
        self.interrupt.load(Ordering::Relaxed) != 0
    }

    fn run_here(&self, table: &mut [f64], look: &mut dyn FnMut(usize)) -> Vec<SampleFailure> {
        let mut worker = self.evaluator.worker();
        let mut failures = Vec::new();
        let rows = table.chunks_exact_mut(self.evaluator.quantities.len().max(1));
        for (row, out) in rows.enumerate().take(self.samples.count) {
            failures.extend(self.row(&mut worker, row, out, &mut || look(row)));
            if row % CHUNK == CHUNK - 1 {
                look(row + 1);
            }
            if self.is_interrupted() {
                break;
            }
        }
        self.evaluator.rest(worker);
        failures
    }

    fn run_over(
        &self,
        table: &mut [f64],
        threads: usize,
        look: &mut dyn FnMut(usize),
    ) -> Result<Vec<SampleFailure>, StudyError> {
        let wrong = |e: rayon::ThreadPoolBuildError| StudyError::Setting(format!("cannot start threads: {e}"));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(wrong)?;
        let size = (self.samples.count / (16 * threads)).clamp(1, CHUNK);
        let width = self.evaluator.quantities.len().max(1);
        let chunks = Mutex::new(table.chunks_mut(size * width).enumerate());
        // A call of its own: the lock is released before the chunk is run.
        let take = || held(&chunks).next();
        let (done, failures) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
        let (ended, ends) = std::sync::mpsc::channel();
        pool.in_place_scope(|scope| {
            for _ in 0..threads {
                let (ended, take, done, failures) = (ended.clone(), &take, &done, &failures);
                scope.spawn(move |_| {
                    let mut worker = self.evaluator.worker();
                    while let Some((chunk, out)) = take().filter(|_| !self.is_interrupted()) {
                        for (i, out) in out.chunks_mut(width).enumerate() {
                            if let Some(failure) = self.row(&mut worker, chunk * size + i, out, &mut || {}) {
                                held(failures).push(failure);
                            }
                            done.fetch_add(1, Ordering::Relaxed);
                            if self.is_interrupted() {
                                break;
                            }
                        }
                    }
                    self.evaluator.rest(worker);
                    // Nobody waits any longer if this is not heard.
                    let _ = ended.send(());
                });
            }
            let mut working = threads;
            while working > 0 {
                match ends.recv_timeout(LOOK) {
                    Ok(()) => working -= 1,
                    Err(_) => look(done.load(Ordering::Relaxed)),
                }
            }
        });
        Ok(failures.into_inner().unwrap_or_else(PoisonError::into_inner))
    }

    /// Runs one sample; why it gave nothing.
    fn row(&self, worker: &mut Worker, row: usize, out: &mut [f64], look: &mut dyn FnMut()) -> Option<SampleFailure> {
        let width = self.evaluator.width();
        let sample = &self.samples.values[row * width..(row + 1) * width];
        let revised = worker.plan.as_mut().and_then(|plan| plan.revise(sample).then_some(plan));
        let result = match revised {
            Some(plan) => plan.run(self, out, look),
            None => self.run_anew(sample, out, look),
        };
        result.err().map(|reason| {
            out.fill(f64::NAN);
            SampleFailure { row, reason }
        })
    }

    /// Runs a sample from the deck's text on.
    fn run_anew(&self, sample: &[f64], out: &mut [f64], look: &mut dyn FnMut()) -> Result<(), StudyError> {
        let evaluator = self.evaluator;
        let routines = evaluator.user.routines()?;
        let read = evaluator.source.read(&evaluator.overrides(sample));
        let mut prepared = accepted(job::prepare_edited(read, &mut |_| {}, &routines))?;
        evaluator.look_less(&mut prepared.plan);
        let mut history = quantity::history(&evaluator.quantities, &prepared.plan);
        let mut sink = HistorySink { history: &mut history, look };
        let (outcome, state) = job::run_until(&prepared, &mut sink, self.interrupt);
        evaluator.finish(&history, outcome, &state, out)
    }
}

fn held<T>(shared: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What one thread reuses from sample to sample.
struct Worker {
    plan: Option<Box<ReusablePlan>>,
}

/// A plan whose numbers change from sample to sample.
struct ReusablePlan {
    template: Template,
    places: Vec<Revisable>,
    model: Model,
    routines: Routines,
    plan: Plan,
    state: State,
    reviser: Reviser,
    history: History,
    /// Values of parameters, and numbers of the deck's open words.
    values: Vec<f64>,
    numbers: Vec<f64>,
}

impl ReusablePlan {
    /// `None` where a sample takes more than other numbers in the same plan.
    fn new(evaluator: &Evaluator) -> Option<ReusablePlan> {
        if matches!(evaluator.user, UserRoutines::Files(_)) {
            return None;
        }
        let routines = evaluator.user.routines().ok()?;
        let (deck, _) = evaluator.source.read(&evaluator.fixed);
        let template = Template::of(&deck, &evaluator.names)?;
        let model = model::build(&deck).0;
        let places = template.words.iter().map(|word| revise::revisable(&model, &deck, word));
        let places = places.collect::<Option<Vec<_>>>()?;
        let (mut plan, state, _, reviser) = plan::revise::compile(&model, &routines);
        evaluator.look_less(&mut plan);
        let history = quantity::history(&evaluator.quantities, &plan);
        let (reviser, values, numbers) = (reviser?, Vec::new(), Vec::new());
        Some(ReusablePlan { template, places, model, routines, plan, state, reviser, history, values, numbers })
    }

    /// Whether the plan is that of the sample now.
    fn revise(&mut self, sample: &[f64]) -> bool {
        self.template.numbers(sample, &mut self.values, &mut self.numbers)
            && self.places.iter().zip(&self.numbers).all(|(place, value)| revise::set(&mut self.model, *place, *value))
            && self.reviser.revise(&self.model, &self.routines, &mut self.plan, &mut self.state)
    }

    fn run(&mut self, batch: &Batch<'_>, out: &mut [f64], look: &mut dyn FnMut()) -> Result<(), StudyError> {
        self.history.clear();
        let mut sink = HistorySink { history: &mut self.history, look };
        let control = Control { interrupt: Some(batch.interrupt), ..Control::default() };
        let (outcome, state) = solve::run_with(&self.plan, self.state.clone(), &mut sink, control).unwrap_or_default();
        batch.evaluator.finish(&self.history, outcome, &state, out)
    }
}

/// Keeps the history, and lets the caller look up now and then.
struct HistorySink<'a> {
    history: &'a mut History,
    look: &'a mut dyn FnMut(),
}

impl Sink for HistorySink<'_> {
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
