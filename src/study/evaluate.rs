//! Quantities of a deck over samples of its parameters, as programs for uncertainty, optimisation and design ask for them:
//! a table of inputs to a table of outputs, from any number of threads to the same bits.
//! Never here: tables in files, grids (`sweep.rs`).

use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use super::StudyError;
use super::quantity::{self, Finished, Quantity};
use crate::deck::names::nearest;
use crate::deck::template::Template;
use crate::deck::{self, Deck, Diagnostics};
use crate::job::{self, Overrides};
use crate::model::revise::{self, Place};
use crate::model::{self, Model};
use crate::output::History;
use crate::plan::revise::Reviser;
use crate::plan::{self, Plan, Schedule, State};
use crate::solve::{self, Control, Instant, Outcome, Progress, Sink, SinkError};
use crate::user::Routines;
use crate::user::compile::Compiled;

/// Where a deck comes from.
#[derive(Clone, Debug)]
pub enum Source {
    /// A file.
    File(PathBuf),
    /// Text in memory, with the name of the file for which it stands.
    Text(String, String),
}

impl Source {
    /// Reads the deck with these values of its parameters.
    pub fn read(&self, overrides: &Overrides) -> (Deck, Diagnostics) {
        match self {
            Source::File(path) => deck::read(path, overrides),
            Source::Text(name, text) => deck::read_text(name, text, overrides),
        }
    }
}

/// The user's routines of samples.
#[derive(Default)]
pub enum User {
    /// None.
    #[default]
    Absent,
    /// Compiled files, opened anew for each sample: what routines keep to themselves begins anew.
    Files(Arc<Compiled>),
    /// Routines that keep nothing from one sample to the next, made once for each thread.
    Stateless(Box<dyn Fn() -> Routines + Send + Sync>),
}

impl User {
    fn routines(&self) -> Result<Routines, StudyError> {
        match self {
            User::Absent => Ok(Routines::none()),
            User::Files(compiled) => Ok(compiled.open()?),
            User::Stateless(make) => Ok(make()),
        }
    }
}

/// What is evaluated.
pub struct Evaluator {
    source: Source,
    fixed: Vec<(String, String)>,
    names: Vec<String>,
    quantities: Vec<Quantity>,
    user: User,
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
pub struct Failure {
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
    ///
    /// # Errors
    /// Where the deck is refused, does not define a parameter, or no run of it can give a quantity.
    pub fn new(
        source: Source,
        fixed: Vec<(String, String)>,
        names: Vec<String>,
        quantities: Vec<Quantity>,
        user: User,
    ) -> Result<Evaluator, StudyError> {
        let prepared = job::prepare_edited(source.read(&fixed), &mut |_| {}, &user.routines()?);
        if prepared.diagnostics.has_errors() {
            return Err(StudyError::refused(&prepared));
        }
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

    /// Runs all samples on so many threads and writes one row each into `table`, one number a quantity, NaN where there is none; says
    /// which those are and why. `look` is told several times a second how many are done; a number other than 0 in
    /// `interrupt` ends it early. The table does not depend on the threads, nor on how samples are split over calls.
    ///
    /// # Errors
    /// Where threads cannot be started.
    pub fn run(
        &self,
        samples: Samples<'_>,
        table: &mut [f64],
        threads: usize,
        interrupt: &AtomicUsize,
        look: &mut dyn FnMut(usize),
    ) -> Result<Vec<Failure>, StudyError> {
        let threads = threads.clamp(1, samples.count.max(1));
        let mut failures = if threads == 1 && self.most_threads <= 1 {
            self.run_here(samples, table, interrupt, look)
        } else {
            self.run_over(samples, table, threads, interrupt, look)?
        };
        failures.sort_by_key(|f| f.row);
        Ok(failures)
    }

    fn run_here(
        &self,
        samples: Samples<'_>,
        table: &mut [f64],
        interrupt: &AtomicUsize,
        look: &mut dyn FnMut(usize),
    ) -> Vec<Failure> {
        let mut worker = self.worker();
        let mut failures = Vec::new();
        let rows = table.chunks_exact_mut(self.quantities.len().max(1));
        for (row, out) in rows.enumerate().take(samples.count) {
            failures.extend(self.row(&mut worker, samples, row, out, interrupt, &mut || look(row)));
            if row % CHUNK == CHUNK - 1 {
                look(row + 1);
            }
            if interrupt.load(Ordering::Relaxed) != 0 {
                break;
            }
        }
        self.rest(worker);
        failures
    }

    fn run_over(
        &self,
        samples: Samples<'_>,
        table: &mut [f64],
        threads: usize,
        interrupt: &AtomicUsize,
        look: &mut dyn FnMut(usize),
    ) -> Result<Vec<Failure>, StudyError> {
        let wrong = |e: rayon::ThreadPoolBuildError| StudyError::Setting(format!("cannot start threads: {e}"));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(wrong)?;
        let size = (samples.count / (16 * threads)).clamp(1, CHUNK);
        let width = self.quantities.len().max(1);
        let chunks = Mutex::new(table.chunks_mut(size * width).enumerate());
        // A call of its own: the lock is given back before the chunk is run.
        let take = || held(&chunks).next();
        let (done, failures) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
        let (ended, ends) = std::sync::mpsc::channel();
        pool.in_place_scope(|scope| {
            for _ in 0..threads {
                let (ended, take, done, failures) = (ended.clone(), &take, &done, &failures);
                scope.spawn(move |_| {
                    let mut worker = self.worker();
                    while interrupt.load(Ordering::Relaxed) == 0
                        && let Some((chunk, out)) = take()
                    {
                        for (i, out) in out.chunks_mut(width).enumerate() {
                            let row = chunk * size + i;
                            if let Some(failure) = self.row(&mut worker, samples, row, out, interrupt, &mut || {}) {
                                held(failures).push(failure);
                            }
                            done.fetch_add(1, Ordering::Relaxed);
                            if interrupt.load(Ordering::Relaxed) != 0 {
                                break;
                            }
                        }
                    }
                    self.rest(worker);
                    // Nobody waits any longer where that is not heard.
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
    fn row(
        &self,
        worker: &mut Worker,
        samples: Samples<'_>,
        row: usize,
        out: &mut [f64],
        interrupt: &AtomicUsize,
        look: &mut dyn FnMut(),
    ) -> Option<Failure> {
        let sample = &samples.values[row * self.width()..(row + 1) * self.width()];
        let told = worker.sample(self, sample, out, interrupt, look);
        told.err().map(|reason| Failure { row, reason })
    }

    fn worker(&self) -> Worker {
        held(&self.idle).pop().unwrap_or_else(|| Worker::new(self))
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

    fn values(&self, run: Finished<'_>, out: &mut [f64]) -> Result<(), StudyError> {
        for (out, quantity) in out.iter_mut().zip(&self.quantities) {
            *out = quantity.number(run)?;
        }
        Ok(())
    }
}

fn held<T>(shared: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// One thread's part: what it needs for a sample, used again for the next.
struct Worker {
    kept: Option<Box<Kept>>,
}

/// A plan whose numbers change from sample to sample.
struct Kept {
    template: Template,
    places: Vec<Place>,
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

impl Worker {
    fn new(evaluator: &Evaluator) -> Worker {
        Worker { kept: Kept::new(evaluator).map(Box::new) }
    }

    fn sample(
        &mut self,
        evaluator: &Evaluator,
        sample: &[f64],
        out: &mut [f64],
        interrupt: &AtomicUsize,
        look: &mut dyn FnMut(),
    ) -> Result<(), StudyError> {
        let revised = self.kept.as_mut().and_then(|kept| kept.revise(sample).then_some(kept));
        let told = match revised {
            Some(kept) => kept.run(evaluator, out, interrupt, look),
            None => anew(evaluator, sample, out, interrupt, look),
        };
        if told.is_err() {
            out.fill(f64::NAN);
        }
        told
    }
}

impl Kept {
    /// `None` where a sample takes more than other numbers in the same plan.
    fn new(evaluator: &Evaluator) -> Option<Kept> {
        if matches!(evaluator.user, User::Files(_)) {
            return None;
        }
        let routines = evaluator.user.routines().ok()?;
        let (deck, _) = evaluator.source.read(&evaluator.fixed);
        let template = Template::of(&deck, &evaluator.names)?;
        let model = model::build(&deck).0;
        let places = template.words.iter().map(|word| revise::place_of(&model, &deck, word));
        let places = places.collect::<Option<Vec<_>>>()?;
        let (mut plan, state, _, reviser) = plan::revise::compile(&model, &routines);
        evaluator.look_less(&mut plan);
        let history = quantity::history(&evaluator.quantities, &plan);
        let (reviser, values, numbers) = (reviser?, Vec::new(), Vec::new());
        Some(Kept { template, places, model, routines, plan, state, reviser, history, values, numbers })
    }

    /// Whether the plan is that of the sample now.
    fn revise(&mut self, sample: &[f64]) -> bool {
        self.template.numbers(sample, &mut self.values, &mut self.numbers)
            && self.places.iter().zip(&self.numbers).all(|(place, value)| revise::set(&mut self.model, *place, *value))
            && self.reviser.revise(&self.model, &self.routines, &mut self.plan, &mut self.state)
    }

    fn run(
        &mut self,
        evaluator: &Evaluator,
        out: &mut [f64],
        interrupt: &AtomicUsize,
        look: &mut dyn FnMut(),
    ) -> Result<(), StudyError> {
        self.history.clear();
        let mut watched = Watched { history: &mut self.history, look };
        let control = Control { interrupt: Some(interrupt), ..Control::default() };
        let (outcome, state) =
            solve::run_with(&self.plan, self.state.clone(), &mut watched, control).unwrap_or_default();
        finish(evaluator, &self.history, outcome, &state, out)
    }
}

/// A sample from the deck's text on.
fn anew(
    evaluator: &Evaluator,
    sample: &[f64],
    out: &mut [f64],
    interrupt: &AtomicUsize,
    look: &mut dyn FnMut(),
) -> Result<(), StudyError> {
    let routines = evaluator.user.routines()?;
    let read = evaluator.source.read(&evaluator.overrides(sample));
    let mut prepared = job::prepare_edited(read, &mut |_| {}, &routines);
    if prepared.diagnostics.has_errors() {
        return Err(StudyError::refused(&prepared));
    }
    evaluator.look_less(&mut prepared.plan);
    let mut history = quantity::history(&evaluator.quantities, &prepared.plan);
    let (outcome, state) = job::run_until(&prepared, &mut Watched { history: &mut history, look }, interrupt);
    finish(evaluator, &history, outcome, &state, out)
}

fn finish(
    evaluator: &Evaluator,
    history: &History,
    outcome: Outcome,
    state: &State,
    out: &mut [f64],
) -> Result<(), StudyError> {
    let end = Some((outcome.total_time(), state));
    outcome.halt.map_or(Ok(()), |halt| Err(StudyError::Halted(halt)))?;
    if outcome.still_moving > 0 {
        evaluator.still_moving.fetch_add(1, Ordering::Relaxed);
        if evaluator.to_the_end {
            let why = format!("{}; its steps need more time", outcome.unfinished.join("; "));
            return Err(StudyError::Unfinished(why));
        }
    }
    evaluator.values(Finished { history, end }, out)
}

/// Keeps the history, and lets the caller look up now and then.
struct Watched<'a> {
    history: &'a mut History,
    look: &'a mut dyn FnMut(),
}

impl Sink for Watched<'_> {
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
