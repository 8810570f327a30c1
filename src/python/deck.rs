//! A deck, as Python holds it, and the user's compiled files.
//! Never here: what a run gives (`run.rs`), studies.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use revolve::deck::{Sources, files, source};
use revolve::job::{self, Frames, Options, Prepared};
use revolve::model::{Model, Precision};
use revolve::output::{Job, Points};
use revolve::solve::Progress;
use revolve::study::evaluate::DeckSource;
use revolve::user::Routines;
use revolve::user::compile::Compiled;

use crate::errors;
use crate::evaluate::Evaluator;
use crate::load::{Load, Raised, raised};
use crate::run::Run;
use crate::waiting::Waiting;

/// Stack of a thread, bytes: routines of the user may keep large arrays there, as in a main thread.
const STACK: usize = 64 << 20;

/// Settings of parameters by name.
pub type Settings = Vec<(String, String)>;

/// The user's files, compiled.
#[pyclass(frozen, module = "revolve._revolve")]
pub struct User {
    pub compiled: Arc<Compiled>,
    /// What the user should know, as JSON.
    #[pyo3(get)]
    notes: String,
}

/// Compiles user subroutines; `checked` with bounds checks.
#[pyfunction]
pub fn compile(py: Python<'_>, files: Vec<PathBuf>, checked: bool) -> PyResult<User> {
    let compiled = py.detach(|| revolve::user::compile::compile(&files, checked));
    let compiled = compiled.map_err(|faults| errors::refused(py, &faults, &Sources::default()))?;
    let notes = serde_json::to_string(&compiled.notes.findings(&Sources::default())).unwrap_or_default();
    Ok(User { compiled: Arc::new(compiled), notes })
}

/// A deck that has been planned without a user's routines, and the settings that it was planned for.
type Known = Option<(Settings, Arc<Prepared>)>;

/// A deck as text, read when it was made.
#[pyclass(frozen, module = "revolve._revolve")]
pub struct Deck {
    pub source: DeckSource,
    precision: Precision,
    known: Mutex<Known>,
}

/// How a run is to be made.
struct Asked {
    threads: usize,
    frames: bool,
    out: Option<PathBuf>,
}

#[pymethods]
impl Deck {
    /// From a file, or from text with the name of the file for which it stands.
    #[new]
    fn new(name: &str, text: Option<String>, precision: &str) -> PyResult<Deck> {
        let text = match text {
            Some(text) => text,
            None => {
                let bytes = files::read(Path::new(name));
                source::decode(bytes.map_err(|e| PyOSError::new_err(format!("cannot read {name}: {e}")))?)
            }
        };
        let precision = precision.parse().map_err(|e| errors::setting(format!("precision={precision}: {e}")))?;
        Ok(Deck { source: DeckSource::Text(name.to_owned(), text), precision, known: Mutex::default() })
    }

    /// The text.
    #[getter]
    fn text(&self) -> &str {
        let DeckSource::Text(_, text) = &self.source else { return "" };
        text
    }

    /// What is found in it, as JSON: findings, ledger, parameters, title.
    fn check(&self, py: Python<'_>, settings: Settings, user: Option<&User>, load: Option<Load>) -> PyResult<String> {
        let (routines, _) = routines(py, user, load.as_ref())?;
        let prepared = py.detach(|| self.prepare(&settings, &routines));
        let sources = &prepared.deck.sources;
        let found = serde_json::json!({
            "findings": prepared.diagnostics.findings(sources),
            "text": prepared.diagnostics.render(sources),
            "ledger": prepared.plan.ledger,
            "rendered": prepared.plan.ledger.render(true),
            "parameters": prepared.deck.parameters,
            "title": prepared.title,
            "columns": prepared.plan.column_names(),
        });
        Ok(found.to_string())
    }

    /// Runs it.
    #[expect(clippy::too_many_arguments, reason = "keywords of Python")]
    fn run(
        &self,
        py: Python<'_>,
        settings: Settings,
        user: Option<&User>,
        load: Option<Load>,
        threads: usize,
        frames: bool,
        out: Option<PathBuf>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Run> {
        let (own, exception) = routines(py, user, load.as_ref())?;
        let prepared = py.detach(|| self.prepared(settings, &own));
        if prepared.diagnostics.has_errors() {
            return Err(errors::refused(py, &prepared.diagnostics, &prepared.deck.sources));
        }
        let waiting = Waiting::new(progress);
        let identity = user.map_or_else(String::new, |user| user.compiled.identity());
        let asked = Asked { threads, frames, out };
        let ran = py.detach(|| self.carry_out(&prepared, asked, identity, &waiting));
        raised(&exception)?;
        waiting.end()?;
        ran.map_err(|why| why.raise(py))
    }

    /// Quantities over parameters.
    fn evaluator(
        &self,
        py: Python<'_>,
        names: Vec<String>,
        fixed: Settings,
        quantities: Vec<String>,
        user: Option<Py<User>>,
        load: Option<Load>,
    ) -> PyResult<Evaluator> {
        Evaluator::make(py, self.source.clone(), names, fixed, quantities, user, load)
    }
}

/// Why there is no run.
enum NoRun {
    Refused(job::Refusal),
    Named(Box<revolve::deck::Diagnostic>),
    Threads(String),
}

impl NoRun {
    fn raise(self, py: Python<'_>) -> PyErr {
        match self {
            NoRun::Refused(why) => errors::refusal(py, why),
            NoRun::Named(finding) => errors::finding(py, *finding),
            NoRun::Threads(why) => PyOSError::new_err(why),
        }
    }
}

/// The routines that Python gives, and what its function raised.
fn routines(py: Python<'_>, user: Option<&User>, load: Option<&Load>) -> PyResult<(Routines, Raised)> {
    let raised = Raised::default();
    let mut routines = load.map_or_else(Routines::none, |load| load.routines(&raised));
    if let Some(user) = user {
        let opened = py.detach(|| user.compiled.open()).map_err(|found| errors::finding(py, found))?;
        let load = routines.load.take();
        routines = opened;
        routines.load = load.or(routines.load);
    }
    Ok((routines, raised))
}

impl Deck {
    fn prepare(&self, settings: &Settings, routines: &Routines) -> Prepared {
        let precision = self.precision;
        job::prepare_edited(
            self.source.read(settings),
            &mut |model: &mut Model| model.settings.precision = precision,
            routines,
        )
    }

    /// The same; a deck without routines is planned once for the same settings.
    fn prepared(&self, settings: Settings, routines: &Routines) -> Arc<Prepared> {
        if routines.any() {
            return Arc::new(self.prepare(&settings, routines));
        }
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, prepared)) = known.as_ref().filter(|(of, _)| *of == settings) {
            return prepared.clone();
        }
        let prepared = Arc::new(self.prepare(&settings, routines));
        *known = Some((settings, prepared.clone()));
        prepared
    }

    /// Runs on threads of its own where there is work for several; Python's waits and looks for signals.
    fn carry_out(&self, prepared: &Prepared, asked: Asked, user: String, waiting: &Waiting) -> Result<Run, NoRun> {
        let DeckSource::Text(name, _) = &self.source else { return Err(NoRun::Threads("a deck has text".into())) };
        let job = job::default_job(Path::new(name), asked.out.clone()).map_err(NoRun::Named)?;
        let threads = asked.threads.min(prepared.most_threads()).max(1);
        if threads == 1 && prepared.most_threads() == 1 {
            return work(prepared, &job, &asked, user, waiting, &mut |progress| waiting.look(progress.0, &progress.1));
        }
        let pool = rayon::ThreadPoolBuilder::new().stack_size(STACK).num_threads(threads);
        let pool = pool.build().map_err(|e| NoRun::Threads(format!("cannot start threads: {e}")))?;
        let (tell, told) = std::sync::mpsc::channel();
        let mut ran = None;
        pool.in_place_scope(|scope| {
            let (ran, asked, job) = (&mut ran, &asked, &job);
            scope.spawn(move |_| {
                // Nobody waits any longer where that is not heard.
                *ran = Some(work(prepared, job, asked, user, waiting, &mut |progress| drop(tell.send(progress))));
            });
            let mut now = (0.0, String::new());
            loop {
                match told.recv_timeout(std::time::Duration::from_millis(50)) {
                    Ok(progress) => now = progress,
                    Err(std::sync::mpsc::RecvTimeoutError::Timeout) => waiting.look(now.0, &now.1),
                    Err(std::sync::mpsc::RecvTimeoutError::Disconnected) => break,
                }
            }
        });
        ran.unwrap_or_else(|| Err(NoRun::Threads("the run has ended without a word".into())))
    }
}

/// The run itself, into memory or into files; `tell` hears a fraction and words.
fn work(
    prepared: &Prepared,
    job: &Job,
    asked: &Asked,
    user: String,
    waiting: &Waiting,
    tell: &mut dyn FnMut((f64, String)),
) -> Result<Run, NoRun> {
    let mut follow = |progress: &Progress<'_>| {
        if !progress.ends && progress.now.increment > 0 {
            tell((progress.fraction, format!("{} t = {:.4e}", progress.step, progress.now.total_time)));
        }
    };
    if asked.out.is_none() {
        let (summary, frames) = job::run_kept(prepared, job, asked.frames, &waiting.interrupt, &mut follow);
        return Ok(Run::new(summary, frames, None));
    }
    let frames = if asked.frames { Frames::Written(Points::Current) } else { Frames::Absent };
    let options = Options { interrupt: Some(&waiting.interrupt), user, frames, ..Options::default() };
    let summary = job::run_with(prepared, job, options, &mut follow).map_err(NoRun::Refused)?;
    Ok(Run::new(summary, Vec::new(), Some(job.path(".pvd"))))
}
