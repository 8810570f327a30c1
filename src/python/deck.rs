//! Python classes of decks and of compiled user subroutine files.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use revolve::deck::{Sources, files, source};
use revolve::job::{self, FrameOutput, JobOptions, PreparedJob, Provenance};
use revolve::output::JobFiles;
use revolve::solve::Progress;
use revolve::study::evaluate::{DeckSource, SampleEvaluator, UserRoutines};
use revolve::study::quantity::Quantity;
use revolve::user::Routines;
use revolve::user::compile::Compiled;

use crate::errors;
use crate::evaluate::Evaluator;
use crate::load::{PythonLoad, RaisedException, raised};
use crate::run::Run;
use crate::waiting::{self, PythonWait};

/// Values of deck parameters by name.
pub type ParameterSettings = Vec<(String, String)>;

/// Compiled user subroutine files.
#[pyclass(frozen, module = "revolve._revolve")]
pub struct User {
    pub compiled: Arc<Compiled>,
    /// Notes and warnings of the compilation, as JSON.
    #[pyo3(get)]
    notes: String,
}

/// Compiles user subroutines; `checked` enables array bounds checks.
#[pyfunction]
pub fn compile(py: Python<'_>, files: Vec<PathBuf>, checked: bool) -> PyResult<User> {
    let compiled = py.detach(|| revolve::user::compile::compile(&files, checked));
    let compiled = compiled.map_err(|faults| errors::refused(py, &faults, &Sources::default()))?;
    let notes = serde_json::to_string(&compiled.notes.findings(&Sources::default())).unwrap_or_default();
    Ok(User { compiled: Arc::new(compiled), notes })
}

/// A deck prepared without user subroutines, and the parameter values it was prepared with.
type CachedPlan = Option<(ParameterSettings, Arc<PreparedJob>)>;

/// A deck whose text was read when the object was created.
#[pyclass(frozen, module = "revolve._revolve")]
pub struct Deck {
    pub source: DeckSource,
    known: Mutex<CachedPlan>,
}

/// Options of one run, as passed from Python.
struct RunRequest {
    threads: usize,
    frames: bool,
    out: Option<PathBuf>,
    /// What produces the result, if files are written.
    provenance: Option<Provenance>,
}

#[pymethods]
impl Deck {
    /// Creates a deck from a file, or from text with a file name for messages and relative paths.
    #[new]
    fn new(name: &str, text: Option<String>) -> PyResult<Deck> {
        let text = match text {
            Some(text) => text,
            None => {
                let bytes = files::read(Path::new(name));
                source::decode(bytes.map_err(|e| errors::unreadable(name, &e))?)
            }
        };
        Ok(Deck { source: DeckSource::Text(name.to_owned(), text), known: Mutex::default() })
    }

    /// Text of the deck.
    #[getter]
    fn text(&self) -> &str {
        let DeckSource::Text(_, text) = &self.source else { return "" };
        text
    }

    /// Checks the deck; returns diagnostics, ledger, parameters, title and history columns as JSON.
    fn check(
        &self,
        py: Python<'_>,
        settings: ParameterSettings,
        user: Option<&User>,
        load: Option<PythonLoad>,
    ) -> PyResult<String> {
        let (routines, _) = routines(py, user, load.as_ref())?;
        let prepared = py.detach(|| self.prepare(&settings, &routines));
        let sources = &prepared.deck.sources;
        let summary = serde_json::json!({
            "findings": prepared.diagnostics.findings(sources),
            "text": prepared.diagnostics.render(sources),
            "ledger": prepared.plan.ledger,
            "rendered": prepared.plan.ledger.render(true),
            "parameters": prepared.deck.parameters,
            "title": prepared.title,
            "units": prepared.units,
            "columns": prepared.plan.column_names(),
        });
        Ok(summary.to_string())
    }

    /// Runs the deck in memory, or with result files if `out` is given.
    #[expect(clippy::too_many_arguments, reason = "keywords of Python")]
    fn run(
        &self,
        py: Python<'_>,
        settings: ParameterSettings,
        user: Option<&User>,
        load: Option<PythonLoad>,
        threads: usize,
        frames: bool,
        out: Option<PathBuf>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Run> {
        let (run_routines, exception) = routines(py, user, load.as_ref())?;
        let prepared = py.detach(|| self.prepared(settings.clone(), &run_routines));
        if prepared.diagnostics.has_errors() {
            return Err(errors::refused(py, &prepared.diagnostics, &prepared.deck.sources));
        }
        let waiting = PythonWait::new(progress);
        let identity = user.map_or_else(String::new, |user| user.compiled.identity());
        let files = user.map_or(&[][..], |user| user.compiled.files());
        // A function of Python has no file.
        let command = if load.is_none() { self.command(&settings, files) } else { Vec::new() };
        let provenance = out.as_ref().map(|_| Provenance::of(&prepared, command, files));
        let request = RunRequest { threads, frames, out, provenance };
        let ran = py.detach(|| self.carry_out(&prepared, request, identity, &waiting));
        raised(&exception)?;
        waiting.end()?;
        ran.map_err(|why| why.raise(py))
    }

    /// Creates an evaluator of quantities over parameters; `in_increments`: no shots by stages.
    fn evaluator(
        &self,
        py: Python<'_>,
        names: Vec<String>,
        fixed: ParameterSettings,
        quantities: Vec<String>,
        routines: (Option<Py<User>>, Option<PythonLoad>),
        in_increments: bool,
    ) -> PyResult<Evaluator> {
        let parsed = quantities.iter().map(|q| Quantity::parse(q)).collect::<Result<Vec<_>, _>>();
        let parsed = parsed.map_err(|why| errors::study(py, &why))?;
        let (width, raised) = (parsed.len(), RaisedException::default());
        let routines = match routines {
            (None, None) => UserRoutines::Absent,
            (Some(user), None) => UserRoutines::Files(Arc::clone(&user.get().compiled)),
            (_, Some(load)) => {
                let exception = raised.clone();
                UserRoutines::Stateless(Box::new(move || load.routines(&exception)))
            }
        };
        let source = self.source.clone();
        let evaluator = py.detach(|| SampleEvaluator::new(source, fixed, names, parsed, routines));
        let evaluator = evaluator.map_err(|why| errors::study(py, &why))?;
        let evaluator = if in_increments { evaluator.in_increments() } else { evaluator };
        Ok(Evaluator { evaluator, width, raised })
    }
}

/// Error that prevents a run.
enum RunError {
    Refused(job::JobError),
    Named(Box<revolve::deck::Diagnostic>),
    Threads(String),
}

impl RunError {
    fn raise(self, py: Python<'_>) -> PyErr {
        match self {
            RunError::Refused(why) => errors::refusal(py, why),
            RunError::Named(finding) => errors::finding(py, *finding),
            RunError::Threads(why) => PyOSError::new_err(why),
        }
    }
}

/// Returns the user subroutines given in Python, and the storage for an exception of the load function.
fn routines(py: Python<'_>, user: Option<&User>, load: Option<&PythonLoad>) -> PyResult<(Routines, RaisedException)> {
    let raised = RaisedException::default();
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
    /// Returns the words of the command line that runs the deck with these parameters and user subroutines.
    fn command(&self, settings: &ParameterSettings, files: &[PathBuf]) -> Vec<String> {
        let DeckSource::Text(name, _) = &self.source else { return Vec::new() };
        let parameters = settings.iter().flat_map(|(name, value)| ["--set".to_owned(), format!("{name}={value}")]);
        let user = files.iter().flat_map(|file| ["--user".to_owned(), file.display().to_string()]);
        ["run".to_owned(), name.clone()].into_iter().chain(parameters).chain(user).collect()
    }

    fn prepare(&self, settings: &ParameterSettings, routines: &Routines) -> PreparedJob {
        job::prepare_read(self.source.read(settings), routines)
    }

    /// Like [`prepare`](Self::prepare); without user subroutines the last result is reused for the same parameter
    /// values.
    fn prepared(&self, settings: ParameterSettings, routines: &Routines) -> Arc<PreparedJob> {
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

    /// Runs the deck, on a separate thread pool if it can use several threads; the Python thread meanwhile waits and
    /// checks for signals.
    fn carry_out(
        &self,
        prepared: &PreparedJob,
        request: RunRequest,
        user: String,
        waiting: &PythonWait,
    ) -> Result<Run, RunError> {
        let DeckSource::Text(name, _) = &self.source else {
            return Err(RunError::Threads("the deck has no text".into()));
        };
        let job = job::default_job(Path::new(name), request.out.clone()).map_err(RunError::Named)?;
        let threads = request.threads.min(prepared.most_threads()).max(1);
        // The stack of the Python thread may be too small for compiled user subroutines.
        let is_compiled = prepared.plan.routines.memory.is_some();
        if threads == 1 && prepared.most_threads() == 1 && !is_compiled {
            return work(prepared, &job, request, user, waiting, &mut |progress| waiting.look(progress.0, &progress.1));
        }
        let mut now = (0.0, String::new());
        let ran = waiting::on_threads(
            threads,
            |tell| work(prepared, &job, request, user, waiting, &mut |progress| tell(progress)),
            &mut |message| match message {
                Some(progress) => now = progress,
                None => waiting.look(now.0, &now.1),
            },
        );
        ran.unwrap_or_else(|why| Err(RunError::Threads(why)))
    }
}

/// Runs the deck in memory or into files; `tell` receives the completed fraction and a text.
fn work(
    prepared: &PreparedJob,
    job: &JobFiles,
    request: RunRequest,
    user: String,
    waiting: &PythonWait,
    tell: &mut dyn FnMut((f64, String)),
) -> Result<Run, RunError> {
    let mut follow = |progress: &Progress<'_>| {
        if !progress.ends && progress.now.increment > 0 {
            tell((progress.fraction, format!("{} t = {:.4e}", progress.step, progress.now.total_time)));
        }
    };
    if request.out.is_none() {
        let (summary, frames) = job::run_kept(prepared, job, request.frames, &waiting.interrupt, &mut follow);
        return Ok(Run::new(summary, frames, None));
    }
    let frames = if request.frames { FrameOutput::default() } else { FrameOutput::Absent };
    let provenance = request.provenance.map(|provenance| Provenance { threads: request.threads, ..provenance });
    let interrupt = Some(&waiting.interrupt);
    let options = JobOptions { interrupt, user, frames, provenance, ..JobOptions::default() };
    let summary = job::run_with(prepared, job, options, &mut follow).map_err(RunError::Refused)?;
    Ok(Run::new(summary, Vec::new(), Some(job.path(".pvd"))))
}
