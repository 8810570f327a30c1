//! A job: a deck taken through the whole pipeline. Text to deck, deck to model, model to plan, plan to results.
//! Never here: printing, arguments.

use std::path::{Path, PathBuf};

use indexmap::IndexMap;
use serde::Serialize;

use crate::deck::{self, Deck, Diagnostics};
use crate::model::{self, Model};
use crate::output::pvd::FrameWriter;
use crate::output::{Frame, History, HistorySummary, Job, write_summary, write_whole};
use crate::plan::ledger::Ledger;
use crate::plan::{self, Plan};
use crate::solve::{self, Energy, Outcome, Rest, Sink, StepSummary};
use crate::user::{Routines, host};

/// `--set NAME=VALUE` pairs.
pub type Overrides = [(String, String)];

/// A deck that has been read, resolved and planned, with all that was found on the way.
pub struct Prepared {
    /// The syntax tree.
    pub deck: Deck,
    /// What will run; not to be run where there are errors.
    pub plan: Plan,
    /// Findings of all rooms.
    pub diagnostics: Diagnostics,
    /// Whether routines of the user take part.
    has_routines: bool,
}

/// Takes a deck file up to the plan.
pub fn prepare(path: &Path, overrides: &Overrides, routines: &Routines) -> Prepared {
    resolve(deck::read(path, overrides), routines)
}

/// The same from text in memory; `name` stands for the file.
pub fn prepare_text(name: &str, text: &str, overrides: &Overrides, routines: &Routines) -> Prepared {
    resolve(deck::read_text(name, text, overrides), routines)
}

fn resolve(read: (Deck, Diagnostics), routines: &Routines) -> Prepared {
    prepare_edited(read, &mut |_| {}, routines)
}

/// The same from a deck that has been read, with a change of the model before it is planned.
pub fn prepare_edited(
    (deck, mut diagnostics): (Deck, Diagnostics),
    edit: &mut dyn FnMut(&mut Model),
    routines: &Routines,
) -> Prepared {
    let (mut model, found) = model::build(&deck);
    diagnostics.append(found);
    if !diagnostics.has_errors() {
        edit(&mut model);
    }
    let (plan, found) = plan::compile(&deck, &model, routines);
    // What follows from a fault already told would only hide it.
    if !diagnostics.has_errors() {
        diagnostics.append(found);
    }
    Prepared { deck, plan, diagnostics, has_routines: routines.any() }
}

/// What `<job>.json` holds. The keys are stable.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// `completed` or `halted`.
    pub status: &'static str,
    /// Why it halted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Whether a user's routine ended the analysis.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub ended_by_user: bool,
    /// Messages of the user's routines.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub messages: Vec<host::Message>,
    /// Steps begun.
    pub steps: Vec<StepSummary>,
    /// History columns.
    pub history: HistorySummary,
    /// Energies at the end.
    pub energy: Energy,
    /// When bodies came to rest.
    pub rests: Vec<Rest>,
    /// What was simulated.
    pub ledger: Ledger,
    /// What it took.
    pub timing: Timing,
    /// The deck and its parameters.
    pub deck: DeckSummary,
    /// The program's version.
    pub version: &'static str,
}

/// What a run took.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Timing {
    /// Increments over all steps.
    pub increments: u64,
    /// Seconds in the time loop, output included.
    pub seconds: f64,
}

/// The deck and its parameters.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct DeckSummary {
    /// Files, the deck first.
    pub files: Vec<String>,
    /// `*PARAMETER` values in force.
    pub parameters: IndexMap<String, f64>,
}

/// Keeps histories in memory; frames are not wanted. What sweeps use.
#[derive(Debug, Default)]
pub struct HistoryOnly {
    /// Column names.
    pub columns: Vec<String>,
    /// What each came to.
    pub summary: HistorySummary,
}

impl Sink for HistoryOnly {
    fn wants_frames(&self) -> bool {
        false
    }

    fn frame(&mut self, _frame: &Frame) -> Result<(), String> {
        Ok(())
    }

    fn row(&mut self, time: f64, values: &[f64]) -> Result<(), String> {
        self.summary.observe(&self.columns, time, values);
        Ok(())
    }
}

/// Called with the step's name, the fraction done and the increment.
pub type Progress<'a> = dyn FnMut(&str, f64, u64) + 'a;

/// Writes frames as they come and keeps histories for the end.
struct Files<'a> {
    frames: FrameWriter,
    history: History,
    summary: HistorySummary,
    progress: &'a mut Progress<'a>,
}

impl Sink for Files<'_> {
    fn wants_frames(&self) -> bool {
        true
    }

    fn frame(&mut self, frame: &Frame) -> Result<(), String> {
        self.frames.write(frame).map_err(|e| e.to_string())
    }

    fn row(&mut self, time: f64, values: &[f64]) -> Result<(), String> {
        self.history.push(time, values);
        self.summary.observe(&self.history.columns, time, values);
        Ok(())
    }

    fn progress(&mut self, step: &str, fraction: f64, increment: u64) {
        (self.progress)(step, fraction, increment);
    }
}

/// Runs a prepared deck and keeps only what its histories came to.
pub fn run_in_memory(prepared: &mut Prepared) -> (Outcome, HistorySummary) {
    let mut sink = HistoryOnly { columns: column_names(&prepared.plan), ..HistoryOnly::default() };
    let outcome = run_into(prepared, &mut sink);
    (outcome, sink.summary)
}

/// Runs a prepared deck into a sink of the caller's; no file is written.
pub fn run_into(prepared: &mut Prepared, sink: &mut dyn Sink) -> Outcome {
    announce(prepared, &Job { folder: PathBuf::from("."), name: "job".into() });
    solve::run(&mut prepared.plan, sink)
}

/// Runs a prepared deck and writes its files.
///
/// # Errors
/// Where the folder or the final files cannot be written; a frame that cannot be written halts the run instead.
pub fn run_to_files<'a>(
    prepared: &mut Prepared,
    job: &Job,
    progress: &'a mut Progress<'a>,
) -> std::io::Result<Summary> {
    let frames = FrameWriter::new(job.clone())?;
    announce(prepared, job);
    let history = History { columns: column_names(&prepared.plan), ..History::default() };
    let mut files = Files { frames, history, summary: HistorySummary::default(), progress };
    let outcome = solve::run(&mut prepared.plan, &mut files);
    prepared.plan.ledger.share(&outcome.effect_seconds, outcome.seconds);
    let Files { history, summary, .. } = files;
    let summary = summarise(prepared, outcome, summary);
    write_whole(&job.path("_history.csv"), history.csv().as_bytes())?;
    write_summary(job, &summary)?;
    Ok(summary)
}

/// What the user's routines may ask of the job; nothing is made for a job without them.
fn announce(prepared: &Prepared, job: &Job) {
    if !prepared.has_routines {
        return;
    }
    let folder = std::path::absolute(&job.folder).unwrap_or_else(|_| job.folder.clone());
    host::announce(host::JobInfo {
        name: job.name.clone(),
        folder: folder.to_string_lossy().into_owned(),
        nodes: prepared.plan.mesh.node_names.clone(),
        elements: prepared.plan.mesh.elements.iter().map(|e| e.name.clone()).collect(),
    });
}

fn column_names(plan: &Plan) -> Vec<String> {
    plan.columns.iter().map(|c| c.name.clone()).collect()
}

fn summarise(prepared: &Prepared, outcome: Outcome, history: HistorySummary) -> Summary {
    let deck = &prepared.deck;
    Summary {
        status: if outcome.halt.is_some() { "halted" } else { "completed" },
        reason: outcome.halt.map(|h| format!("{}: {}", h.code, h.reason)),
        ended_by_user: outcome.ended_by_user,
        messages: host::take_messages(),
        steps: outcome.steps,
        history,
        energy: outcome.energy,
        rests: outcome.rests,
        ledger: prepared.plan.ledger.clone(),
        timing: Timing { increments: outcome.increments, seconds: outcome.seconds },
        deck: DeckSummary {
            files: deck.sources.files().iter().map(|f| f.name.clone()).collect(),
            parameters: deck.parameters.iter().cloned().collect(),
        },
        version: env!("CARGO_PKG_VERSION"),
    }
}

/// The name of a job: the deck's file name without ending; and its default folder, `out/<job>`.
pub fn default_job(deck: &Path, folder: Option<PathBuf>) -> Job {
    let name = deck.file_stem().map_or("job".into(), |s| s.to_string_lossy().into_owned());
    Job { folder: folder.unwrap_or_else(|| Path::new("out").join(&name)), name }
}
