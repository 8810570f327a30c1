//! A job: a deck taken through the whole pipeline. Text to deck, deck to model, model to plan, plan to results.

mod memory;
mod status;

use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicUsize;
use std::time::{Duration, Instant as Stopwatch};

use indexmap::IndexMap;
use serde::{Serialize, Serializer};
use thiserror::Error;

use crate::deck::files::STANDARD_INPUT;
use crate::deck::{self, Deck, Diagnostic, Diagnostics, Finding, Severity};
use crate::element::group::TASK;
pub use crate::element::instructions::{Instructions, UnknownInstructions};
use crate::kernel::lanes::LANES;
use crate::model::{self, Model, Name, Precision, Units, scene::Scene};
use crate::output::checkpoint::{CHECKPOINT, Checkpoint, Identity, hash};
use crate::output::lock::{FolderLock, LockError};
use crate::output::pvd::{FrameWriter, Written, missing_frames};
use crate::output::sums::{Checksums, SUMS, sum};
use crate::output::{
    Frame, HISTORY, History, HistorySummary, Job, Points, write_summary, write_whole, write_with_sums,
};
use crate::overview::Overview;
use crate::plan::ledger::Ledger;
use crate::plan::{self, Plan, State};
use crate::solve::{
    self, Control, Energy, Every, Exit, Instant, LOST, LimitsOverTime, Outcome, PenetrationSummary, Progress, Rest,
    Sink, SinkError, StepSummary, UnfitState,
};
use crate::state::archive::{Archive, Persist};
use crate::user::{Routines, host};
pub use memory::run_kept;
use status::Status;

/// Errors of the plan on what bodies are made of: elements, sections, materials.
const OF_BODIES: &[&str] = &["P001", "P012", "P013", "P014", "P016", "P017", "P019", "P041"];

/// `--set NAME=VALUE` pairs.
pub type Overrides = [(String, String)];

/// An instruction set that the machine does not have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("this machine does not have {0:?}")]
pub struct MissingInstructions(pub Instructions);

/// A deck that has been read, resolved and planned, with all that was found on the way.
pub struct Prepared {
    /// Sources and parameters of the deck; its cards are in the plan.
    pub deck: Deck,
    /// What will run; not to be run where there are errors.
    pub plan: Plan,
    /// The state that it starts from.
    pub state: State,
    /// Findings of all rooms.
    pub diagnostics: Diagnostics,
    /// The `*HEADING`.
    pub title: String,
    /// What no mesh shows.
    scene: Scene,
    /// Names of the units.
    pub units: Option<Units>,
    /// Whether routines of the user take part.
    has_routines: bool,
    /// What tells a model that is composed in Rust from others.
    composed: Option<String>,
}

/// Takes a deck file up to the plan.
pub fn prepare(path: &Path, overrides: &Overrides, routines: &Routines) -> Prepared {
    resolve(deck::read(path, overrides), routines)
}

/// The same with elements in this precision, as far as they can be.
pub fn prepare_in(precision: Precision, path: &Path, overrides: &Overrides, routines: &Routines) -> Prepared {
    prepare_edited(deck::read(path, overrides), &mut |model| model.settings.precision = precision, routines)
}

/// The same, with what the deck amounts to; `None` where it is refused.
pub fn examine(
    precision: Precision,
    path: &Path,
    overrides: &Overrides,
    routines: &Routines,
) -> (Prepared, Option<Overview>) {
    let set = &mut |model: &mut Model| model.settings.precision = precision;
    let (prepared, model) = prepared_model(deck::read(path, overrides), set, routines);
    let accepted = !prepared.diagnostics.has_errors();
    let overview = accepted.then(|| Overview::of(&model, &prepared.plan, &prepared.state));
    (prepared, overview)
}

/// The same from text in memory; `name` stands for the file.
pub fn prepare_text(name: &str, text: &str, overrides: &Overrides, routines: &Routines) -> Prepared {
    resolve(deck::read_text(name, text, overrides), routines)
}

impl Prepared {
    /// Lets elements use an instruction set other than the machine's best; the bits stay the same.
    pub fn use_instructions(&mut self, instructions: Instructions) -> Result<(), MissingInstructions> {
        let arch = instructions.arch().ok_or(MissingInstructions(instructions))?;
        self.state.elements.use_arch(arch);
        Ok(())
    }

    /// Threads that have something to do in its run, at most.
    pub fn most_threads(&self) -> usize {
        self.plan.mesh.elements.len().div_ceil(TASK * LANES).max(1)
    }

    /// What tells a checkpoint of this job from others; `user` is that of the user's routines.
    pub fn identity(&self, user: &str) -> Identity {
        let files = self.deck.sources.files().iter().map(|f| f.text.as_bytes());
        let parameters = self.deck.parameters.iter().map(|(name, value)| format!("{name} = {value:?}"));
        let mesh = &self.plan.mesh;
        let points: Vec<u8> = mesh.points.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        let corners = mesh.elements.iter().flat_map(|e| [e.nodes.len()].into_iter().chain(e.nodes.iter().copied()));
        let corners: Vec<u8> = corners.flat_map(usize::to_le_bytes).collect();
        Identity {
            deck: self.composed.clone().unwrap_or_else(|| hash(files)),
            parameters: parameters.collect::<Vec<_>>().join(", "),
            mesh: hash([&points[..], &corners[..]]),
            user: user.into(),
            precision: self.plan.precision.name().into(),
        }
    }
}

fn resolve(read: (Deck, Diagnostics), routines: &Routines) -> Prepared {
    prepare_edited(read, &mut |_| {}, routines)
}

/// The same from a deck that has been read, with a change of the model before it is planned.
pub fn prepare_edited(read: (Deck, Diagnostics), edit: &mut dyn FnMut(&mut Model), routines: &Routines) -> Prepared {
    prepared_model(read, edit, routines).0
}

/// The same, with the model.
fn prepared_model(
    (mut deck, mut diagnostics): (Deck, Diagnostics),
    edit: &mut dyn FnMut(&mut Model),
    routines: &Routines,
) -> (Prepared, Model) {
    let (mut model, found) = model::build(&deck);
    // Nothing asks for the cards again, and of a large mesh they are the largest part.
    deck.cards = Vec::new();
    diagnostics.append(found);
    if !diagnostics.has_errors() {
        edit(&mut model);
    }
    (planned(deck, &model, diagnostics, routines), model)
}

/// Takes a model that is composed in Rust up to the plan.
pub fn prepare_model(model: &Model, routines: &Routines) -> Prepared {
    let prepared = planned(Deck::default(), model, Diagnostics::default(), routines);
    Prepared { composed: Some(hash([format!("{model:?}").as_bytes()])), ..prepared }
}

fn planned(deck: Deck, model: &Model, mut diagnostics: Diagnostics, routines: &Routines) -> Prepared {
    let (plan, state, mut found) = plan::compile(model, routines);
    // What follows from a fault already told would only hide it; what bodies are made of does not, where all of it was read.
    if diagnostics.has_errors() {
        found.retain(|d| model.origin.bodies_read && d.severity == Severity::Error && OF_BODIES.contains(&d.code));
    }
    diagnostics.append(found);
    diagnostics.merge_repeats();
    let (title, scene, has_routines) = (model.settings.title.clone(), Scene::of(model), routines.any());
    let units = model.settings.units.clone();
    Prepared { title, scene, units, deck, plan, state, diagnostics, has_routines, composed: None }
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
    /// What the run warns of.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// Messages of the user's routines.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub messages: Vec<host::RoutineMessage>,
    /// Steps begun.
    pub steps: Vec<StepSummary>,
    /// What limited the increments of each.
    pub limits: Vec<LimitsOverTime>,
    /// History columns.
    #[serde(serialize_with = "what_they_came_to")]
    pub history: History,
    /// Energies at the end.
    pub energy: Energy,
    /// SHA-256 over the bits of the state at the end.
    pub digest: String,
    /// When bodies came to rest.
    pub rests: Vec<Rest>,
    /// What has become of bodies with six degrees of freedom.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[serde(rename = "flights")]
    pub penetrations: Vec<PenetrationSummary>,
    /// Bodies that are still on their way in a target, or behind it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub unfinished: Vec<String>,
    /// Bodies that have left their target through its back, with their residual velocities.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub exits: Vec<Exit>,
    /// Elements that were deleted; absent where none was.
    #[serde(skip_serializing_if = "is_zero")]
    pub deleted_elements: usize,
    /// What was simulated.
    pub ledger: Ledger,
    /// Notes and warnings on the deck.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub diagnostics: Vec<Finding>,
    /// Targets that are not meshed and analytical planes, for pictures.
    #[serde(skip_serializing_if = "Scene::is_empty")]
    pub scene: Scene,
    /// Names of the units, where the deck gives them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub units: Option<Units>,
    /// What it took.
    pub timing: Timing,
    /// The deck and its parameters.
    pub deck: DeckSummary,
    /// The program's version.
    pub version: &'static str,
    /// Whether a signal ended it.
    #[serde(skip)]
    pub interrupted: bool,
    /// What the state that was kept last does not hold of the user's routines.
    #[serde(skip)]
    pub lost: Vec<String>,
}

/// The rows are in a file of their own.
fn what_they_came_to<S: Serializer>(history: &History, serializer: S) -> Result<S::Ok, S::Error> {
    history.summary.serialize(serializer)
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde calls it with a reference")]
fn is_zero(count: &usize) -> bool {
    *count == 0
}

/// What a run took.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Timing {
    /// Increments over all steps.
    pub increments: u64,
    /// Seconds in the time loop, output included; of a run that went on, since it did.
    pub seconds: f64,
    /// Increment from which a run went on that had been interrupted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resumed_at: Option<u64>,
    /// Seconds that keeping the state took.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub checkpoint_seconds: Option<f64>,
}

/// The deck and its parameters.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct DeckSummary {
    /// The `*HEADING`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub title: String,
    /// Files, the deck first.
    pub files: Vec<String>,
    /// `*PARAMETER` values in force.
    pub parameters: IndexMap<String, f64>,
}

/// Histories in memory and nothing else: frames are not wanted. What sweeps and studies use.
impl Sink for History {
    fn row(&mut self, now: &Instant, values: &[f64]) -> Result<(), SinkError> {
        self.push(now, values);
        Ok(())
    }
}

/// Is told how far a run is, some times a second.
pub type Follower<'a> = dyn FnMut(&Progress<'_>) + 'a;

/// How a job runs, beside its deck.
#[derive(Default)]
pub struct Options<'a> {
    /// When the state is kept, beside what the deck asks.
    pub every: Option<Every>,
    /// Number of a signal as soon as one has come, else 0.
    pub interrupt: Option<&'a AtomicUsize>,
    /// State to go on from, as [`find_checkpoint`] gives it.
    pub from: Option<Checkpoint>,
    /// State to start from in place of a copy of the prepared one, where memory is dear.
    pub state: Option<State>,
    /// What the user's routines are ([`crate::user::compile::Compiled::identity`]); empty without any.
    pub user: String,
    /// Is told each warning as soon as there is one.
    pub warn: Option<&'a (dyn Fn(&str) + Sync)>,
    /// What becomes of the frames.
    pub frames: Frames,
}

/// What becomes of the frames of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Frames {
    /// They are written, with their points there.
    Written(Points),
    /// There are none: histories and the summary alone.
    Absent,
}

impl Default for Frames {
    fn default() -> Self {
        Frames::Written(Points::default())
    }
}

/// Why a job does not begin.
#[derive(Debug, Error)]
pub enum Refusal {
    /// Its folder cannot be made, cleared or read.
    #[error(transparent)]
    Folder(#[from] io::Error),
    /// Its checkpoint is not one of this job, or another job is at work in its folder.
    #[error(transparent)]
    Checkpoint(Box<Diagnostic>),
}

/// What a checkpoint must hold of the user's routines for a run to go on from it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Demand {
    /// All that they keep to themselves.
    #[default]
    Whole,
    /// Whatever it holds.
    Anything,
}

/// The checkpoint of a job, if there is one, and what is to be noted.
///
/// # Errors
/// Why it is not one of this job, or what it does not hold (K009).
pub fn find_checkpoint(
    prepared: &Prepared,
    job: &Job,
    user: &str,
    demand: Demand,
) -> Result<(Option<Checkpoint>, Diagnostics), Box<Diagnostic>> {
    let mut notes = Diagnostics::default();
    let path = job.path(CHECKPOINT);
    let Some(checkpoint) = Checkpoint::read(&path)? else {
        let message = format!("there is no checkpoint {}: the run starts at its beginning", path.display());
        notes.push(Diagnostic::note("K101", message));
        return Ok((None, notes));
    };
    checkpoint.accept(&prepared.identity(user))?;
    let mut frames: Vec<Written> = Vec::new();
    frames.persist(&mut Archive::reader(&checkpoint.shown));
    if let [first, rest @ ..] = &missing_frames(job, frames.len())[..] {
        let more = if rest.is_empty() { String::new() } else { format!(" and {} more", rest.len()) };
        let message = format!("{}{more}, written before the checkpoint, is no longer there", first.display());
        notes.push(Diagnostic::warning("K103", message));
    }
    if demand == Demand::Whole
        && let lost = solve::lost(&checkpoint.state)
        && !lost.is_empty()
    {
        let finding = Diagnostic::error("K009", format!("{LOST}: {}", lost.join("; ")));
        return Err(Box::new(finding.help("--resume-anyway goes on without it; without either the run starts anew")));
    }
    notes.append(forgotten(prepared, Some(&checkpoint), &[]));
    Ok((Some(checkpoint), notes))
}

/// What routines keep to themselves and checkpoints do not hold: of one that a run went on from, and of the one that it left.
fn forgotten(prepared: &Prepared, from: Option<&Checkpoint>, left: &[String]) -> Diagnostics {
    let mut notes = Diagnostics::default();
    let missed = from.map(|checkpoint| solve::lost(&checkpoint.state)).unwrap_or_default();
    for (lost, what) in [(&missed[..], "; the run goes on without it"), (left, "")] {
        if !lost.is_empty() {
            notes.push(Diagnostic::warning("K102", format!("{LOST}: {}{what}", lost.join("; "))));
        }
    }
    if prepared.has_routines && prepared.plan.routines.memory.is_none() && from.is_some() {
        notes.push(Diagnostic::note("K102", "what routines in Rust keep to themselves starts anew"));
    }
    notes
}

/// Histories are written with a frame if they are older than this: a killed process then loses little of them.
const STALE: Duration = Duration::from_secs(1);

/// Writes frames as they come, and histories and states now and then.
struct FileSink<'a> {
    job: &'a Job,
    frames: FrameWriter,
    wanted: Frames,
    status: Status,
    history: History,
    identity: Identity,
    progress: &'a mut Follower<'a>,
    warn: &'a dyn Fn(&str),
    history_written: Stopwatch,
}

impl FileSink<'_> {
    /// Writes the histories so far; their checksum.
    fn write_history(&mut self) -> io::Result<u32> {
        self.history_written = Stopwatch::now();
        let text = self.history.csv();
        write_whole(&self.job.path(HISTORY), text.as_bytes())?;
        Ok(sum(text.as_bytes()))
    }

    /// Writes the histories; checksums of all but the summary, and why the histories could not be written.
    fn end(&mut self) -> (Checksums, Option<io::Error>) {
        let mut sums = if self.wanted == Frames::Absent { Checksums::default() } else { self.frames.sums() };
        let written = self.write_history();
        if let Ok(sum) = &written {
            sums.add_sum(self.job, HISTORY, *sum);
        }
        (sums, written.err())
    }
}

/// What has been shown so far: frames, histories, messages.
fn persist_shown(frames: &mut Vec<Written>, history: &mut History, archive: &mut Archive<'_>) {
    frames.persist(archive);
    history.persist(archive);
    host::persist_messages(archive);
}

impl Sink for FileSink<'_> {
    fn wants_frames(&self) -> bool {
        self.wanted != Frames::Absent
    }

    fn frame(&mut self, frame: &Frame) -> Result<(), SinkError> {
        self.frames.write(frame)?;
        if self.history_written.elapsed() >= STALE {
            self.write_history()?;
        }
        Ok(())
    }

    fn row(&mut self, now: &Instant, values: &[f64]) -> Result<(), SinkError> {
        self.history.push(now, values);
        Ok(())
    }

    fn progress(&mut self, progress: &Progress<'_>) {
        let next = (progress.frame && self.wants_frames()).then(|| self.frames.next_name());
        self.status.tell(progress, next.as_deref());
        (self.progress)(progress);
    }

    fn warning(&mut self, text: &str) {
        self.status.note(&format!("***WARNING: {text}"));
        (self.warn)(text);
    }

    fn keeps(&self) -> bool {
        true
    }

    fn keep(&mut self, state: &[u8], now: &Instant) -> Result<(), SinkError> {
        self.write_history()?;
        let mut shown = Vec::new();
        let mut frames = self.frames.frames().to_vec();
        persist_shown(&mut frames, &mut self.history, &mut Archive::writer(&mut shown));
        let (version, identity) = (env!("CARGO_PKG_VERSION").into(), self.identity.clone());
        let mut checkpoint = Checkpoint { version, identity, now: *now, shown, state: state.to_vec() };
        Ok(checkpoint.write(&self.job.path(CHECKPOINT))?)
    }
}

/// Runs a prepared deck and keeps only what its histories came to.
pub fn run_in_memory(prepared: &Prepared) -> (Outcome, HistorySummary) {
    let mut history = History::of_sums(prepared.plan.column_names());
    let (outcome, _) = run_into(prepared, &mut history);
    (outcome, history.summary)
}

/// Runs a prepared deck into a sink of the caller's; no file is written.
pub fn run_into(prepared: &Prepared, sink: &mut dyn Sink) -> (Outcome, State) {
    announce(prepared, &Job { folder: PathBuf::from("."), name: "job".into() });
    solve::run(&prepared.plan, prepared.state.clone(), sink)
}

/// The same until `interrupt` is a number other than 0.
pub fn run_until(prepared: &Prepared, sink: &mut dyn Sink, interrupt: &AtomicUsize) -> (Outcome, State) {
    announce(prepared, &Job { folder: PathBuf::from("."), name: "job".into() });
    let control = Control { interrupt: Some(interrupt), ..Control::default() };
    // Without a state to go on from there is none that could be refused.
    solve::run_with(&prepared.plan, prepared.state.clone(), sink, control).unwrap_or_default()
}

/// Writes summary and histories of a run in memory into the folder of a job; frames there are none.
pub fn write_run(prepared: &Prepared, job: &Job, outcome: Outcome, history: History) -> io::Result<()> {
    make_folder(job)?;
    // Several runs at once share the messages of routines: whose they are is not known.
    let summary = Summary { messages: Vec::new(), ..summarise(prepared, outcome, history) };
    let (text, rows) = (serde_json::to_string_pretty(&summary)? + "\n", summary.history.csv());
    let files = [(HISTORY.to_owned(), rows.into_bytes()), (".json".to_owned(), text.into_bytes())];
    write_with_sums(job, &files, SUMS)
}

/// Makes the folder of a job.
pub fn make_folder(job: &Job) -> io::Result<()> {
    let made = std::fs::create_dir_all(&job.folder);
    made.map_err(|e| io::Error::new(e.kind(), format!("cannot make the folder {}: {e}", job.folder.display())))
}

/// Runs a prepared deck and writes its files.
///
/// # Errors
/// Where the folder cannot be written; a file that cannot be written later halts the run instead.
pub fn run_to_files<'a>(prepared: &Prepared, job: &'a Job, progress: &'a mut Follower<'a>) -> Result<Summary, Refusal> {
    run_with(prepared, job, Options::default(), progress)
}

/// The same with options.
///
/// # Errors
/// Where the folder cannot be written, or a state does not fit.
pub fn run_with<'a>(
    prepared: &Prepared,
    job: &'a Job,
    options: Options<'a>,
    progress: &'a mut Follower<'a>,
) -> Result<Summary, Refusal> {
    let identity = prepared.identity(&options.user);
    let _lock = take(job)?;
    announce(prepared, job);
    let mut history = History::of_rows(prepared.plan.column_names());
    let goes_on = options.from.is_some();
    let points = if let Frames::Written(points) = options.frames { points } else { Points::default() };
    let frames = match &options.from {
        None => FrameWriter::new(job.clone(), points),
        Some(checkpoint) => {
            let (mut frames, mut archive) = (Vec::new(), Archive::reader(&checkpoint.shown));
            persist_shown(&mut frames, &mut history, &mut archive);
            archive.finish().map_err(unfit)?;
            FrameWriter::go_on(job.clone(), frames, points)
        }
    };
    let frames = frames.map_err(Refusal::Folder)?;
    let status = Status::open(job, goes_on).map_err(Refusal::Folder)?;
    let history_written = Stopwatch::now();
    let warn = options.warn.unwrap_or(&|_| {});
    let mut files =
        FileSink { job, frames, wanted: options.frames, status, history, identity, progress, warn, history_written };
    let kept = options.from.as_ref().map(|c| &c.state[..]);
    let control = Control { every: options.every, interrupt: options.interrupt, state: kept };
    let state = options.state.unwrap_or_else(|| prepared.state.clone());
    let (outcome, _) = solve::run_with(&prepared.plan, state, &mut files, control).map_err(unfit)?;
    let kept = outcome.checkpoint_seconds;
    let (sums, history_failed) = files.end();
    let FileSink { mut status, history, .. } = files;
    let mut summary = summarise(prepared, outcome, history);
    let forgotten = forgotten(prepared, options.from.as_ref(), &summary.lost);
    summary.diagnostics.extend(forgotten.findings(&prepared.deck.sources));
    summary.timing.resumed_at = options.from.map(|c| c.now.increment);
    summary.timing.checkpoint_seconds = (kept > 0.0).then_some(kept);
    history_failed.into_iter().for_each(|why| summary.unwritten(why.to_string()));
    summary.reason.iter().for_each(|reason| status.note(&format!("***ERROR: {reason}")));
    status.note(&format!("THE ANALYSIS HAS {}", summary.status.to_uppercase()));
    status.failed.into_iter().for_each(|why| summary.unwritten(why.to_string()));
    finish_files(job, &mut summary, sums);
    Ok(summary)
}

/// Makes the folder of a job and takes it: it is this job's until the lock is dropped.
///
/// # Errors
/// Where it cannot be made, or another job is at work in it.
pub fn take(job: &Job) -> Result<FolderLock, Refusal> {
    make_folder(job)?;
    FolderLock::take(&job.folder, &job.name).map_err(|why| match why {
        LockError::Busy(finding) => Refusal::Checkpoint(finding),
        LockError::File(error) => Refusal::Folder(error),
    })
}

/// The summary and the list of checksums; then the checkpoint of a run that is complete has served its purpose.
fn finish_files(job: &Job, summary: &mut Summary, mut sums: Checksums) {
    let written = write_summary(job, summary).and_then(|sum| {
        sums.add_sum(job, ".json", sum);
        sums.write(job, SUMS)
    });
    if let Err(e) = written {
        summary.unwritten(e.to_string());
    }
    if summary.reason.is_none() {
        // One that cannot be removed is of no harm: it leads to the same results again.
        let _ = std::fs::remove_file(job.path(CHECKPOINT));
    }
}

impl Summary {
    /// A final file could not be written: nobody shall take the run for complete.
    fn unwritten(&mut self, why: String) {
        self.status = "halted";
        self.reason.get_or_insert_with(|| format!("R205: {why}"));
    }
}

fn unfit(why: UnfitState) -> Refusal {
    let message = format!("the checkpoint does not fit the deck: {why}");
    Refusal::Checkpoint(Box::new(Diagnostic::error("K006", message).help("run without --resume to start anew")))
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
        nodes: prepared.plan.mesh.node_names.iter().map(Name::to_string).collect(),
        elements: prepared.plan.mesh.elements.iter().map(|e| e.name.to_string()).collect(),
    });
}

fn summarise(prepared: &Prepared, outcome: Outcome, history: History) -> Summary {
    let deck = &prepared.deck;
    let mut ledger = prepared.plan.ledger.clone();
    ledger.share(&outcome.effect_seconds, outcome.seconds);
    Summary {
        interrupted: outcome.halt.as_ref().is_some_and(|h| h.code == "R207"),
        status: if outcome.halt.is_some() { "halted" } else { "completed" },
        reason: outcome.halt.map(|h| format!("{}: {}", h.code, h.reason)),
        ended_by_user: outcome.ended_by_user,
        warnings: outcome.warnings,
        messages: host::take_messages(),
        limits: outcome.steps.iter().map(|step| step.limits.named(&prepared.plan)).collect(),
        steps: outcome.steps,
        history,
        energy: outcome.energy,
        lost: outcome.lost,
        digest: outcome.digest,
        rests: outcome.rests,
        penetrations: outcome.penetrations,
        unfinished: outcome.unfinished,
        exits: outcome.exits,
        deleted_elements: outcome.deleted,
        ledger,
        diagnostics: prepared.diagnostics.findings(&deck.sources),
        scene: prepared.scene.clone(),
        units: prepared.units.clone(),
        timing: Timing {
            increments: outcome.increments,
            seconds: outcome.seconds,
            resumed_at: None,
            checkpoint_seconds: None,
        },
        deck: DeckSummary {
            title: prepared.title.clone(),
            files: deck.sources.files().iter().map(|f| f.name.clone()).collect(),
            parameters: deck.parameters.iter().cloned().collect(),
        },
        version: env!("CARGO_PKG_VERSION"),
    }
}

/// The name of a job: the deck's file name without ending; and its default folder, `out/<job>`.
pub fn default_job(deck: &Path, folder: Option<PathBuf>) -> Result<Job, Box<Diagnostic>> {
    let named = if deck == Path::new(STANDARD_INPUT) { None } else { deck.file_stem() };
    let name = named.map_or("job".into(), |s| s.to_string_lossy().into_owned());
    if [".", ".."].contains(&name.as_str()) {
        let message = format!("a deck called {} has no name that its results could have", deck.display());
        return Err(Box::new(Diagnostic::error("K008", message).help("give the file a name before its ending")));
    }
    Ok(Job { folder: folder.unwrap_or_else(|| Path::new("out").join(&name)), name })
}
