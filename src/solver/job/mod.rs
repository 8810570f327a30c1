//! The pipeline from a deck to results: text to deck, deck to model, model to plan, plan to results.

mod memory;
mod provenance;
mod setup;
mod status;
mod verdict;

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;
use std::time::{Duration, Instant as Stopwatch};

use indexmap::IndexMap;
use serde::{Serialize, Serializer};
use thiserror::Error;

use crate::deck::files::STANDARD_INPUT;
pub use crate::deck::verdict::Verdict;
use crate::deck::{self, Deck, Diagnostic, Diagnostics, Finding, Severity};
pub use crate::element::instructions::{Instructions, UnknownInstructions};
use crate::element::lane_sums::TASK;
use crate::kernel::lanes::LANES;
use crate::model::{self, DeckUnits, EntityName, Model, scene::SceneOutline};
use crate::output::checkpoint::{CHECKPOINT, Checkpoint, JobIdentity, hash, hash_mesh};
use crate::output::lock::{FolderLock, LockError};
use crate::output::pvd::{FrameWriter, WrittenFrame, missing_frames};
use crate::output::sums::{Checksums, SUMS, sum};
use crate::output::{
    FrameStyle, HISTORY, HistorySummary, INPUT, JobFiles, OutputFrame, RunHistory, SETUP, unnamed_file, whole::remove,
    write_summary, write_whole,
};
use crate::overview::DeckOverview;
use crate::plan::ledger::Ledger;
use crate::plan::{self, CompiledModel, Plan, PlannedRange, State};
use crate::solve::{
    self, BodyExit, BodyRest, CheckpointInterval, ContactLosses, Energy, HaltDetails, HaltReason, Instant, LOST,
    LimitsOverTime, MeshChanges, MeshShape, Outcome, PenetrationSummary, Progress, RangeShare, RunControl, RunPosition,
    Sink, SinkError, StepSummary, UnfitState,
};
use crate::state::archive::{Persist, StateArchive};
use crate::user::{Routines, host};
use crate::variables::dimension::dimension_of;
pub use memory::run_kept;
pub use provenance::{InputFile, InputKind, Provenance, read_copies};
use status::StatusFile;
pub use verdict::{RunVerdict, VerdictReason, effect_of, is_doubtful};

/// Codes of planning errors on elements, sections and materials. They are reported even if the deck has errors
/// elsewhere.
const OF_BODIES: &[&str] = &["P001", "P012", "P013", "P014", "P016", "P017", "P019", "P041"];

/// Pairs of parameter name and value, as given by `--set NAME=VALUE`.
pub type ParameterOverrides = [(String, String)];

/// Error: the machine does not have the requested instruction set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("this machine does not support the instruction set {0:?}")]
pub struct MissingInstructions(pub Instructions);

/// A deck that has been read, validated and planned, with its diagnostics.
pub struct PreparedJob {
    /// Source texts and parameters of the deck; its list of cards is empty.
    pub deck: Deck,
    /// The plan. Do not run it if `diagnostics` contains errors.
    pub plan: Plan,
    /// Initial state of a run of the plan.
    pub state: State,
    /// Diagnostics of reading, validation and planning.
    pub diagnostics: Diagnostics,
    /// Text of `*HEADING`; empty without one.
    pub title: String,
    /// Targets without a mesh and analytical planes, for pictures.
    pub scene: SceneOutline,
    /// Names of the units, if the deck has `*UNITS`.
    pub units: Option<DeckUnits>,
    /// Mesh files that the deck reads (`*MESH`).
    mesh_files: Vec<PathBuf>,
    /// Whether user subroutines are present.
    has_routines: bool,
    /// Hash of a model that is composed in Rust, or of a deck whose texts are released.
    known_hash: Option<String>,
}

/// Reads a deck file, validates it and plans the analysis.
pub fn prepare(path: &Path, overrides: &ParameterOverrides, routines: &Routines) -> PreparedJob {
    prepare_read(deck::read(path, overrides), routines)
}

/// Prepares a deck file like [`prepare`] and summarises the model; the overview is `None` if the deck has errors.
pub fn examine(
    path: &Path,
    overrides: &ParameterOverrides,
    routines: &Routines,
) -> (PreparedJob, Option<DeckOverview>) {
    let (prepared, model) = prepared_model(deck::read(path, overrides), &mut |_| {}, routines);
    let accepted = !prepared.diagnostics.has_errors();
    let overview = accepted.then(|| DeckOverview::of(&model, &prepared.plan, &prepared.state));
    (prepared, overview)
}

/// Reads a deck text, validates it and plans the analysis; `name` is used as its file name in messages and for relative
/// paths.
pub fn prepare_text(name: &str, text: &str, overrides: &ParameterOverrides, routines: &Routines) -> PreparedJob {
    prepare_read(deck::read_text(name, text, overrides), routines)
}

impl PreparedJob {
    /// Selects the instruction set of the elements; results are bit-identical for all sets.
    pub fn use_instructions(&mut self, instructions: Instructions) -> Result<(), MissingInstructions> {
        let arch = instructions.arch().ok_or(MissingInstructions(instructions))?;
        self.state.elements.use_arch(arch);
        Ok(())
    }

    fn hash_of_texts(&self) -> String {
        hash(self.deck.sources.files().iter().map(|file| file.text.as_bytes()))
    }

    /// Frees the texts of the deck before a run, unless diagnostics refer to them. Their hash remains.
    pub fn release_texts(&mut self) {
        if self.diagnostics.is_empty() {
            self.known_hash = Some(self.known_hash.take().unwrap_or_else(|| self.hash_of_texts()));
            Arc::make_mut(&mut self.deck.sources).release_texts(|_| true);
        }
    }

    /// Returns the largest number of threads that the run can use.
    pub fn most_threads(&self) -> usize {
        self.plan.mesh.elements.len().div_ceil(TASK * LANES).max(1)
    }

    /// Returns the identity that a checkpoint must have for a restart of this job; `user` is the hash of the user
    /// subroutines.
    pub fn identity(&self, user: &str) -> JobIdentity {
        let parameters = self.deck.parameters.iter().map(|(name, value)| format!("{name} = {value:?}"));
        let mesh = &self.plan.mesh;
        JobIdentity {
            deck: self.known_hash.clone().unwrap_or_else(|| self.hash_of_texts()),
            parameters: parameters.collect::<Vec<_>>().join(", "),
            mesh: hash_mesh(&mesh.points, mesh.elements.iter().map(|e| &e.nodes[..])),
            user: user.into(),
        }
    }
}

/// Validates and plans a deck that has been read.
pub fn prepare_read(read: (Deck, Diagnostics), routines: &Routines) -> PreparedJob {
    prepare_edited(read, &mut |_| {}, routines)
}

/// Validates and plans a deck that has been read; `edit` changes the model before it is planned.
pub fn prepare_edited(read: (Deck, Diagnostics), edit: &mut dyn FnMut(&mut Model), routines: &Routines) -> PreparedJob {
    prepared_model(read, edit, routines).0
}

/// A deck that has been read and validated.
pub struct ValidatedDeck {
    /// Without its cards.
    deck: Deck,
    /// Incomplete if there are errors.
    model: Model,
    diagnostics: Diagnostics,
}

impl ValidatedDeck {
    /// Validates a deck that has been read.
    pub fn new((mut deck, mut diagnostics): (Deck, Diagnostics)) -> ValidatedDeck {
        let (model, model_diagnostics) = model::build(&deck);
        // The cards are not needed any more, and with a large mesh they take most of the memory.
        deck.cards = Vec::new();
        diagnostics.append(model_diagnostics);
        deck.name_fractions(&mut diagnostics);
        ValidatedDeck { deck, model, diagnostics }
    }

    /// Frees the texts of files that can be read again: the plan needs only places. [`deck::Sources::restore_texts`] sets
    /// them again.
    pub fn release_texts(&mut self, is_open: impl Fn(&Path) -> bool) {
        // The model shares the sources of the deck.
        self.model.origin.sources = Arc::default();
        Arc::make_mut(&mut self.deck.sources).release_texts(is_open);
        self.model.origin.sources = Arc::clone(&self.deck.sources);
    }

    /// Plans the analysis.
    pub fn plan(self, routines: &Routines) -> (PreparedJob, Arc<Model>) {
        let model = Arc::new(self.model);
        (planned(self.deck, &model, self.diagnostics, routines), model)
    }
}

/// Prepares a job like [`prepare_edited`], and also returns the model.
fn prepared_model(
    read: (Deck, Diagnostics),
    edit: &mut dyn FnMut(&mut Model),
    routines: &Routines,
) -> (PreparedJob, Arc<Model>) {
    let mut validated = ValidatedDeck::new(read);
    if !validated.diagnostics.has_errors() {
        edit(&mut validated.model);
    }
    validated.plan(routines)
}

/// Plans a model that is composed in Rust.
pub fn prepare_model(model: &Model, routines: &Routines) -> PreparedJob {
    let prepared = planned(Deck::default(), &Arc::new(model.clone()), Diagnostics::default(), routines);
    PreparedJob { known_hash: Some(hash([format!("{model:?}").as_bytes()])), ..prepared }
}

fn planned(deck: Deck, model: &Arc<Model>, mut diagnostics: Diagnostics, routines: &Routines) -> PreparedJob {
    let CompiledModel { plan, state, diagnostics: mut plan_diagnostics } = plan::compile_shared(model, routines);
    // After an error in the deck, planning errors may be consequences of it and are dropped, except those on elements,
    // sections and materials if all bodies have been read.
    if diagnostics.has_errors() {
        plan_diagnostics
            .retain(|d| model.origin.bodies_read && d.severity == Severity::Error && OF_BODIES.contains(&d.code));
    }
    diagnostics.append(plan_diagnostics);
    diagnostics.merge_repeats();
    let (title, scene, has_routines) = (model.settings.title.clone(), SceneOutline::of(model), routines.any());
    let units = model.settings.units.clone();
    let mesh_files = model.origin.mesh_files.clone();
    PreparedJob { title, scene, units, deck, plan, state, diagnostics, mesh_files, has_routines, known_hash: None }
}

/// Summary of a run, the contents of `<job>.json`. The keys are stable.
#[derive(Clone, Debug, Serialize)]
pub struct RunSummary {
    /// `completed` or `halted`.
    pub status: &'static str,
    /// One word on whether the results can be used, with reasons.
    #[serde(flatten)]
    pub verdict: RunVerdict,
    /// Reason of the halt; as text its code and message.
    #[serde(rename = "reason", skip_serializing_if = "Option::is_none")]
    pub halt: Option<HaltReason>,
    /// Whether a user subroutine ended the analysis.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub ended_by_user: bool,
    /// Shares of materials beyond the range of their constants (`*MATERIAL RANGE`).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub ranges: Vec<RangeShare>,
    /// Warnings issued during the run.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// Messages of user subroutines.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub messages: Vec<host::RoutineMessage>,
    /// Summaries of the steps that have started.
    pub steps: Vec<StepSummary>,
    /// What limited the increments of each step, over time.
    pub limits: Vec<LimitsOverTime>,
    /// Final, smallest and largest value of each history column.
    #[serde(serialize_with = "serialize_summary")]
    pub history: RunHistory,
    /// Energies at the end of the run.
    pub energy: Energy,
    /// SHA-256 hash of the final state.
    pub digest: String,
    /// Times at which bodies came to rest in a target.
    pub rests: Vec<BodyRest>,
    /// Penetration results of rigid bodies with six degrees of freedom.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[serde(rename = "flights")]
    pub penetrations: Vec<PenetrationSummary>,
    /// Notes on bodies that are still moving in a target, or have passed through it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub unfinished: Vec<String>,
    /// Bodies that have left their target through its back face, with their residual velocities.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub exits: Vec<BodyExit>,
    /// Number of deleted elements; absent if zero.
    #[serde(skip_serializing_if = "is_zero")]
    pub deleted_elements: usize,
    /// Number of changes of adaptive meshes in which nodes moved; `None` without adaptive mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh_changes: Option<u64>,
    /// Number of new meshes of all bodies; `None` without `*REMESH`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub new_meshes: Option<u64>,
    /// Number of elements that these meshes together did not have from the mesh before them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub new_elements: Option<u64>,
    /// Shapes of the quadrilaterals and triangles at the end; `None` without any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh_shape: Option<MeshShape>,
    /// Energy that contact has absorbed, by the kind of the impact, if elements have been deleted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contact_losses: Option<ContactLosses>,
    /// Ledger of the simulated effects.
    pub ledger: Ledger,
    /// Notes and warnings of the deck.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub diagnostics: Vec<Finding>,
    /// Targets without a mesh and analytical planes, for pictures.
    #[serde(skip_serializing_if = "SceneOutline::is_empty")]
    pub scene: SceneOutline,
    /// Names of the units, if the deck has `*UNITS`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub units: Option<DeckUnits>,
    /// Units of the history columns with a known dimension.
    #[serde(skip_serializing_if = "IndexMap::is_empty")]
    pub column_units: IndexMap<String, String>,
    /// Names of the materials; the array MATERIAL of frames has their numbers, counted from 1.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub materials: Vec<String>,
    /// Number of increments, and wall-clock times.
    pub timing: RunTiming,
    /// Title, files and parameters of the deck.
    pub deck: DeckSummary,
    /// Version of the program that wrote the summary.
    pub version: &'static str,
    /// Program, command, machine and input; `None` for runs without a command.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub provenance: Option<Provenance>,
    /// Whether a signal ended the run.
    #[serde(skip)]
    pub interrupted: bool,
    /// Internal data of user subroutines that the last checkpoint does not contain.
    #[serde(skip)]
    pub lost: Vec<String>,
    /// Uncertainties that are not known.
    #[serde(skip)]
    unknown: Vec<VerdictReason>,
}

/// Serialises the history without its rows, which are in a CSV file.
fn serialize_summary<S: Serializer>(history: &RunHistory, serializer: S) -> Result<S::Ok, S::Error> {
    history.summary.serialize(serializer)
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde calls it with a reference")]
fn is_zero(count: &usize) -> bool {
    *count == 0
}

/// Increments and run time of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunTiming {
    /// Number of increments of all steps.
    pub increments: u64,
    /// Wall-clock seconds in the time loop, output included; after a restart, those since the restart.
    pub seconds: f64,
    /// Increment of the checkpoint from which the run was restarted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resumed_at: Option<u64>,
    /// Seconds spent on writing checkpoints.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub checkpoint_seconds: Option<f64>,
}

/// Title, files and parameters of a deck.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct DeckSummary {
    /// Text of `*HEADING`; empty without one.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub title: String,
    /// File names; the deck is the first, then its includes.
    pub files: Vec<String>,
    /// Values of the `*PARAMETER`s, overrides applied.
    pub parameters: IndexMap<String, f64>,
}

impl DeckSummary {
    fn of(prepared: &PreparedJob) -> DeckSummary {
        let deck = &prepared.deck;
        DeckSummary {
            title: prepared.title.clone(),
            files: deck.sources.files().iter().map(|f| f.name.clone()).collect(),
            parameters: deck.parameters.iter().cloned().collect(),
        }
    }
}

/// Sink of sweeps and studies: histories in memory, no frames.
impl Sink for RunHistory {
    fn row(&mut self, now: &Instant, values: &[f64]) -> Result<(), SinkError> {
        self.push(now, values);
        Ok(())
    }
}

/// Callback that receives the progress of a run several times a second.
pub type ProgressFollower<'a> = dyn FnMut(&Progress<'_>) + 'a;

/// Options of a job in addition to its deck.
#[derive(Default)]
pub struct JobOptions<'a> {
    /// Interval of checkpoints, in addition to those of `*RESTART`.
    pub every: Option<CheckpointInterval>,
    /// Set to a signal number to interrupt the run; 0 otherwise.
    pub interrupt: Option<&'a AtomicUsize>,
    /// Position of the run, for other threads.
    pub position: Option<&'a RunPosition>,
    /// Checkpoint for a restart, from [`find_checkpoint`].
    pub from: Option<Checkpoint>,
    /// Initial state to use instead of a copy of the prepared one; saves memory.
    pub state: Option<State>,
    /// Hash of the user subroutines ([`crate::user::compile::Compiled::identity`]); empty without any.
    pub user: String,
    /// What produces the results; its copies of the input are written.
    pub provenance: Option<Provenance>,
    /// Callback that receives each warning when it is issued.
    pub warn: Option<&'a (dyn Fn(&str) + Sync)>,
    /// Whether frames are written, with which coordinates and to which files.
    pub frames: FrameOutput,
}

/// Whether frames are written, with which coordinates and to which files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameOutput {
    /// Frames are written.
    Written(FrameStyle),
    /// No frames are written, only histories and the summary.
    Absent,
}

impl FrameOutput {
    /// Returns the file of a job to open in ParaView; `None` if there is none.
    pub fn file(self, job: &JobFiles) -> Option<PathBuf> {
        let FrameOutput::Written(style) = self else { return None };
        Some(job.path(style.format.suffix())).filter(|path| path.is_file())
    }
}

impl Default for FrameOutput {
    fn default() -> Self {
        FrameOutput::Written(FrameStyle::default())
    }
}

/// Error that prevents a job from starting.
#[derive(Debug, Error)]
pub enum JobError {
    /// The output folder cannot be created, cleared or read.
    #[error(transparent)]
    Folder(#[from] io::Error),
    /// The checkpoint does not belong to this job, or another job is using the output folder.
    #[error(transparent)]
    Checkpoint(Box<Diagnostic>),
}

/// What a checkpoint must contain of the internal data of user subroutines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RestartRequirement {
    /// All internal data; otherwise the restart is an error (K009).
    #[default]
    Whole,
    /// Nothing: missing internal data have their initial values after the restart.
    Anything,
}

/// Returns the checkpoint of a job, if there is one, and notes on it.
///
/// # Errors
/// If the checkpoint belongs to a different job, or lacks internal data of user subroutines (K009).
pub fn find_checkpoint(
    prepared: &PreparedJob,
    job: &JobFiles,
    user: &str,
    demand: RestartRequirement,
) -> Result<(Option<Checkpoint>, Diagnostics), Box<Diagnostic>> {
    let mut notes = Diagnostics::default();
    let path = job.path(CHECKPOINT);
    let Some(checkpoint) = Checkpoint::read(&path)? else {
        let message = format!("there is no checkpoint {}: the run starts at time 0", path.display());
        notes.push(Diagnostic::note("K101", message));
        return Ok((None, notes));
    };
    checkpoint.accept(&prepared.identity(user))?;
    let mut frames: Vec<WrittenFrame> = Vec::new();
    frames.persist(&mut StateArchive::reader(&checkpoint.shown));
    if let Some(message) = describe_missing(&missing_frames(job, frames.len()), "before the checkpoint") {
        notes.push(Diagnostic::warning("K103", message));
    }
    if demand == RestartRequirement::Whole
        && let lost = solve::lost(&checkpoint.state)
        && !lost.is_empty()
    {
        let finding = Diagnostic::error("K009", format!("{LOST}: {}", lost.join("; ")));
        return Err(Box::new(finding.help(
            "use --resume-anyway to continue without these data, or start the run from the beginning without --resume",
        )));
    }
    notes.append(lost_state_notes(prepared, Some(&checkpoint), &[]));
    Ok((Some(checkpoint), notes))
}

/// Returns the message on frames that are missing; `None` without any.
fn describe_missing(frames: &[PathBuf], when: &str) -> Option<String> {
    let (first, rest) = frames.split_first()?;
    let more = if rest.is_empty() { String::new() } else { format!(" and {} more", rest.len()) };
    Some(format!("{}{more}, written {when}, no longer exists", first.display()))
}

/// Returns warnings on internal data of user subroutines that are missing in the checkpoint of a restart (`from`) or in
/// the last checkpoint of this run (`left`).
fn lost_state_notes(prepared: &PreparedJob, from: Option<&Checkpoint>, left: &[String]) -> Diagnostics {
    let mut notes = Diagnostics::default();
    let missed = from.map(|checkpoint| solve::lost(&checkpoint.state)).unwrap_or_default();
    for (lost, what) in [(&missed[..], "; the run continues without these data"), (left, "")] {
        if !lost.is_empty() {
            notes.push(Diagnostic::warning("K102", format!("{LOST}: {}{what}", lost.join("; "))));
        }
    }
    if prepared.has_routines && prepared.plan.routines.memory.is_none() && from.is_some() {
        notes.push(Diagnostic::note(
            "K102",
            "internal data of user subroutines in Rust have their initial values after a restart",
        ));
    }
    notes
}

/// The history file is rewritten at a frame if it is older than this, so that little is lost if the process is killed.
const STALE: Duration = Duration::from_secs(1);

/// Sink that writes frames, histories, the status file and checkpoints.
struct FileSink<'a> {
    job: &'a JobFiles,
    frames: FrameWriter,
    wanted: FrameOutput,
    status: StatusFile,
    history: RunHistory,
    identity: JobIdentity,
    progress: &'a mut ProgressFollower<'a>,
    warn: &'a dyn Fn(&str),
    history_written: Stopwatch,
}

impl FileSink<'_> {
    /// Writes the history file and returns its checksum.
    fn write_history(&mut self) -> io::Result<u32> {
        self.history_written = Stopwatch::now();
        let text = self.history.csv();
        write_whole(&self.job.path(HISTORY), text.as_bytes())?;
        Ok(sum(text.as_bytes()))
    }

    /// Writes the final history file. Returns the checksums of all files except the summary, and the error if the
    /// history file could not be written or the frames not be read.
    fn end(&mut self) -> (Checksums, Option<io::Error>) {
        let of_frames = if self.wants_frames() { self.frames.sums() } else { Ok(Checksums::default()) };
        let (mut sums, unread) = of_frames.map_or_else(|e| (Checksums::default(), Some(e)), |sums| (sums, None));
        let written = self.write_history();
        if let Ok(sum) = &written {
            sums.add_sum(self.job, HISTORY, *sum);
        }
        (sums, written.err().or(unread))
    }
}

/// Reads or writes the output so far in a checkpoint: list of frames, histories, messages.
fn persist_shown(frames: &mut Vec<WrittenFrame>, history: &mut RunHistory, archive: &mut StateArchive<'_>) {
    frames.persist(archive);
    history.persist(archive);
    host::persist_messages(archive);
}

impl Sink for FileSink<'_> {
    fn wants_frames(&self) -> bool {
        self.wanted != FrameOutput::Absent
    }

    fn unnamed_file(&mut self) -> Option<File> {
        unnamed_file(&self.job.path(CHECKPOINT)).ok()
    }

    fn frame(&mut self, frame: &OutputFrame) -> Result<(), SinkError> {
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
        self.status.report_progress(progress, next.as_deref());
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
        let mut lines = Vec::new();
        let mut frames = self.frames.frames().to_vec();
        persist_shown(&mut frames, &mut self.history, &mut StateArchive::writer(&mut lines));
        let (version, identity) = (env!("CARGO_PKG_VERSION").into(), self.identity.clone());
        let mut checkpoint = Checkpoint { version, identity, now: *now, shown: lines, state: Vec::new() };
        Ok(checkpoint.write(&self.job.path(CHECKPOINT), state)?)
    }
}

/// Runs a prepared deck without writing files. Returns the outcome and the final, smallest and largest value of each
/// history column.
pub fn run_in_memory(prepared: &PreparedJob) -> (Outcome, HistorySummary) {
    let mut history = RunHistory::of_sums(prepared.plan.column_names());
    let (outcome, _) = run_into(prepared, &mut history);
    (outcome, history.summary)
}

/// Why [`run_to_end`] has no results.
#[derive(Debug, Error)]
pub enum IncompleteRun {
    /// The rendered diagnostics of a deck with errors.
    #[error("{0}")]
    Rejected(String),
    /// The run halted before its end time.
    #[error(transparent)]
    Halted(#[from] HaltReason),
}

/// Runs like [`run_in_memory`], to the end time.
///
/// # Errors
/// If the deck has errors, or if the run halts.
pub fn run_to_end(prepared: &PreparedJob) -> Result<HistorySummary, IncompleteRun> {
    if prepared.diagnostics.has_errors() {
        return Err(IncompleteRun::Rejected(prepared.diagnostics.render(&prepared.deck.sources)));
    }
    let (outcome, history) = run_in_memory(prepared);
    outcome.halt.map_or(Ok(history), |halt| Err(halt.into()))
}

/// Runs a prepared deck with a given sink; no file is written.
pub fn run_into(prepared: &PreparedJob, sink: &mut dyn Sink) -> (Outcome, State) {
    announce_to_user(prepared, &JobFiles { folder: PathBuf::from("."), name: "job".into() });
    solve::run(&prepared.plan, prepared.state.clone(), sink)
}

/// Runs like [`run_into`]; a nonzero `interrupt` ends the run.
pub fn run_until(prepared: &PreparedJob, sink: &mut dyn Sink, interrupt: &AtomicUsize) -> (Outcome, State) {
    announce_to_user(prepared, &JobFiles { folder: PathBuf::from("."), name: "job".into() });
    let control = RunControl { interrupt: Some(interrupt), ..RunControl::default() };
    // Cannot fail: only a restart can have an unsuitable state.
    solve::run_with(&prepared.plan, prepared.state.clone(), sink, control).unwrap_or_default()
}

/// Writes the summary and histories of a run in memory to the folder of a job, without frames.
pub fn write_run(prepared: &PreparedJob, job: &JobFiles, outcome: Outcome, history: RunHistory) -> io::Result<()> {
    make_folder(job)?;
    // Messages of user subroutines are shared by concurrent runs and cannot be assigned to one.
    let summary = RunSummary { messages: Vec::new(), ..summarise(prepared, outcome, history) };
    let rows = summary.history.csv();
    for ending in [SUMS, ".json"] {
        remove(&job.path(ending))?;
    }
    write_whole(&job.path(HISTORY), rows.as_bytes())?;
    let mut sums = Checksums::default();
    sums.add(job, HISTORY, rows.as_bytes());
    write_summary(job, &summary, sums)
}

/// Creates the output folder of a job.
pub fn make_folder(job: &JobFiles) -> io::Result<()> {
    let made = std::fs::create_dir_all(&job.folder);
    made.map_err(|e| io::Error::new(e.kind(), format!("cannot create folder {}: {e}", job.folder.display())))
}

/// Runs a prepared deck and writes its result files.
///
/// # Errors
/// If the folder cannot be written. A file that cannot be written during the run halts the run instead.
pub fn run_to_files<'a>(
    prepared: &PreparedJob,
    job: &'a JobFiles,
    progress: &'a mut ProgressFollower<'a>,
) -> Result<RunSummary, JobError> {
    run_with(prepared, job, JobOptions::default(), progress)
}

/// Runs like [`run_to_files`], with options.
///
/// # Errors
/// If the folder cannot be written or the checkpoint does not fit the deck.
pub fn run_with<'a>(
    prepared: &PreparedJob,
    job: &'a JobFiles,
    options: JobOptions<'a>,
    progress: &'a mut ProgressFollower<'a>,
) -> Result<RunSummary, JobError> {
    let identity = prepared.identity(&options.user);
    let _lock = lock_folder(job)?;
    announce_to_user(prepared, job);
    let mut history = RunHistory::of_rows(prepared.plan.column_names());
    let goes_on = options.from.is_some();
    let style = if let FrameOutput::Written(style) = options.frames { style } else { FrameStyle::default() };
    let mut provenance = options.provenance;
    let origin = provenance::origin(prepared, provenance.as_ref());
    let frames = match &options.from {
        None => FrameWriter::new(job.clone(), style, origin),
        Some(checkpoint) => {
            let (mut frames, mut archive) = (Vec::new(), StateArchive::reader(&checkpoint.shown));
            persist_shown(&mut frames, &mut history, &mut archive);
            archive.finish().map_err(checkpoint_mismatch)?;
            FrameWriter::resume(job.clone(), frames, style, origin)
        }
    };
    let frames = frames.map_err(JobError::Folder)?;
    let of_copies = provenance.as_mut().map(|provenance| provenance.write_copies(job));
    // Only the live view reads it. Where it cannot be written, the first result file that cannot halts the run.
    setup::write_setup(prepared, job).ok();
    let status = StatusFile::open(job, goes_on).map_err(JobError::Folder)?;
    let history_written = Stopwatch::now();
    let warn = options.warn.unwrap_or(&|_| {});
    let mut files =
        FileSink { job, frames, wanted: options.frames, status, history, identity, progress, warn, history_written };
    let saved_state = options.from.as_ref().map(|c| &c.state[..]);
    let control = RunControl {
        every: options.every,
        interrupt: options.interrupt,
        most_increments: None,
        state: saved_state,
        position: options.position,
    };
    let state = options.state.unwrap_or_else(|| prepared.state.clone());
    let (mut outcome, _) = solve::run_with(&prepared.plan, state, &mut files, control).map_err(checkpoint_mismatch)?;
    let checkpoint_seconds = outcome.checkpoint_seconds;
    let missing = missing_frames(job, files.frames.frames().len());
    if let Some(message) = describe_missing(&missing, "during the run") {
        let message = format!("K103: {message}");
        files.warning(&message);
        outcome.warnings.push(message);
    }
    let (mut sums, history_failed) = files.end();
    if let Some(Ok(sum)) = &of_copies {
        sums.add_sum(job, INPUT, *sum);
    }
    let FileSink { mut status, history, .. } = files;
    let mut summary = summarise(prepared, outcome, history);
    let forgotten = lost_state_notes(prepared, options.from.as_ref(), &summary.lost);
    summary.diagnostics.extend(forgotten.findings(&prepared.deck.sources));
    summary.timing.resumed_at = options.from.map(|c| c.now.increment);
    summary.timing.checkpoint_seconds = (checkpoint_seconds > 0.0).then_some(checkpoint_seconds);
    history_failed
        .into_iter()
        .chain(of_copies.and_then(Result::err))
        .for_each(|why| summary.mark_unwritten(why.to_string()));
    summary.halt.iter().for_each(|halt| status.note(&format!("***ERROR: {halt}")));
    if let Some(MeshShape { smallest_angle, turned_corners }) = summary.mesh_shape {
        status.note(&format!("SMALLEST ANGLE {smallest_angle:.1}, ELEMENTS WITH A TURNED CORNER {turned_corners}"));
    }
    if let (Some(count), Some(elements)) = (summary.new_meshes, summary.new_elements) {
        status.note(&format!("NEW MESHES {count}, NEW ELEMENTS {elements}"));
    }
    status.note(&format!("THE ANALYSIS HAS {}", summary.status.to_uppercase()));
    status.failed.into_iter().for_each(|why| summary.mark_unwritten(why.to_string()));
    provenance.iter_mut().for_each(Provenance::end);
    summary.judge();
    summary.provenance = provenance;
    finish_files(job, &mut summary, sums);
    Ok(summary)
}

/// Creates the output folder of a job and locks it until the returned lock is dropped.
///
/// # Errors
/// If the folder cannot be created, or another job is using it.
pub fn lock_folder(job: &JobFiles) -> Result<FolderLock, JobError> {
    make_folder(job)?;
    FolderLock::take(&job.folder, &job.name).map_err(|why| match why {
        LockError::Busy(finding) => JobError::Checkpoint(finding),
        LockError::File(error) => JobError::Folder(error),
    })
}

/// Writes the list of checksums and the summary, and removes the checkpoint of a completed run.
fn finish_files(job: &JobFiles, summary: &mut RunSummary, sums: Checksums) {
    if let Err(why) = write_summary(job, summary, sums.clone()) {
        summary.mark_unwritten(why.to_string());
        // The reason of the halt is in the summary if this can be written now.
        write_summary(job, summary, sums).ok();
    }
    if job.path(".json").is_file() {
        // Its contents are in the summary.
        let _ = std::fs::remove_file(job.path(SETUP));
    }
    if summary.halt.is_none() {
        // A failure is harmless: a restart from the checkpoint gives the same results.
        let _ = std::fs::remove_file(job.path(CHECKPOINT));
    }
}

impl RunSummary {
    /// Marks the run as halted because a final file could not be written.
    fn mark_unwritten(&mut self, why: String) {
        self.status = "halted";
        self.halt.get_or_insert_with(|| HaltReason::Output(HaltDetails::new(why)));
        self.judge();
    }

    /// Derives the verdict from what the summary has.
    fn judge(&mut self) {
        self.verdict = RunVerdict::of(self, &self.unknown);
    }

    /// Replaces the uncertainties that are not known, and writes the summary of a job again.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn set_unknown(&mut self, job: &JobFiles, unknown: Vec<VerdictReason>) -> io::Result<()> {
        self.unknown.retain(|reason| !reason.is_unknown_uncertainty());
        self.unknown.extend(unknown);
        self.judge();
        let sums = Checksums::of_file(&job.path(SUMS)).map_err(io::Error::other)?;
        write_summary(job, self, sums)
    }
}

fn checkpoint_mismatch(why: UnfitState) -> JobError {
    let message = format!("the checkpoint does not fit the deck: {why}");
    JobError::Checkpoint(Box::new(
        Diagnostic::error("K006", message).help("run without --resume to start from the beginning"),
    ))
}

/// Provides the job data that user subroutines can query: name, folder, node and element names.
fn announce_to_user(prepared: &PreparedJob, job: &JobFiles) {
    if !prepared.has_routines {
        return;
    }
    // As in ABAQUS, where the job runs in the folder of its deck.
    let deck = prepared.deck.sources.files().first().and_then(|file| std::path::absolute(&file.path).ok());
    let folder = deck.as_deref().and_then(Path::parent).unwrap_or(&job.folder);
    host::begin_job(host::JobInfo {
        name: job.name.clone(),
        folder: folder.to_string_lossy().into_owned(),
        nodes: prepared.plan.mesh.node_names.iter().map(EntityName::to_string).collect(),
        elements: prepared.plan.mesh.elements.iter().map(|e| e.name.to_string()).collect(),
    });
}

/// Returns the units of the columns with a known dimension.
fn units_of(columns: &[String], units: &DeckUnits) -> IndexMap<String, String> {
    let unit = |name: &String| Some((name.clone(), units.name(dimension_of(name)?)));
    columns.iter().filter_map(unit).filter(|(_, unit)| !unit.is_empty()).collect()
}

fn summarise(prepared: &PreparedJob, outcome: Outcome, history: RunHistory) -> RunSummary {
    let deck = &prepared.deck;
    let column_units = prepared.units.as_ref().map(|units| units_of(&history.columns, units)).unwrap_or_default();
    let mut ledger = prepared.plan.ledger.clone();
    for share in &outcome.ranges {
        let is_same = |planned: &&PlannedRange| {
            planned.material == share.material && planned.range.quantity.name() == share.quantity
        };
        if let Some(planned) = prepared.plan.ranges.iter().find(is_same) {
            let basis = planned.range.quantity.basis();
            let change = share.change.map(|change| format!(" (flow stress changed by {:.1} %)", 100.0 * change));
            let beyond = format!("{:.1} % of {basis} beyond {}", 100.0 * share.share, share.quantity);
            ledger.add_result(planned.row, &(beyond + &change.unwrap_or_default()));
        }
    }
    // The following rows are those of the last mesh.
    if let Some(last) = outcome.last_rows {
        ledger.follow(last);
    }
    ledger.set_time_shares(&outcome.effect_seconds, outcome.seconds);
    if let Some(losses) = &outcome.contact_losses {
        ledger.add_result(losses.row, &losses.text);
    }
    for changes in &outcome.mesh_changes {
        ledger.add_result(changes.row, &format!("NADAPT {}", changes.count));
    }
    for changes in &outcome.new_meshes {
        let MeshChanges { count, new_elements, lost_energy, .. } = *changes;
        let text = format!("NREMESH {count}, {new_elements} new elements, ALLADV {lost_energy:.3e}");
        ledger.add_result(changes.row, &text);
        if changes.removed_mass > 0.0 {
            ledger.add_result(changes.row, &format!("mass of sheets left out {:.4e}", changes.removed_mass));
        }
    }
    let message = "the error from the mesh, and noise, are not known: they are estimated with --uncertainty or a study";
    let unknown =
        VerdictReason::unknown_uncertainty(None, message).filter(|_| !prepared.plan.places.elements.is_empty());
    let depth =
        (outcome.still_moving > 0).then_some("a body still moves in a target: its penetration depth is not final");
    let depth = depth.and_then(|message| VerdictReason::of("R315", message));
    let mut summary = RunSummary {
        verdict: RunVerdict::default(),
        unknown: unknown.into_iter().chain(depth).collect(),
        halt: outcome.halt.clone(),
        interrupted: outcome.halt.as_ref().is_some_and(|h| matches!(h, HaltReason::Interrupted(_))),
        status: if outcome.halt.is_some() { "halted" } else { "completed" },
        ended_by_user: outcome.ended_by_user,
        warnings: outcome.warnings,
        ranges: outcome.ranges,
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
        mesh_changes: outcome.mesh_changes.iter().map(|changes| changes.count).reduce(|sum, count| sum + count),
        mesh_shape: outcome.mesh_shape,
        contact_losses: outcome.contact_losses,
        new_meshes: outcome.new_meshes.iter().map(|changes| changes.count).reduce(|sum, count| sum + count),
        new_elements: outcome.new_meshes.iter().map(|changes| changes.new_elements).reduce(|sum, count| sum + count),
        ledger,
        diagnostics: prepared.diagnostics.findings(&deck.sources),
        scene: prepared.scene.clone(),
        units: prepared.units.clone(),
        column_units,
        materials: prepared.plan.labels.material_names().to_vec(),
        timing: RunTiming {
            increments: outcome.increments,
            seconds: outcome.seconds,
            resumed_at: None,
            checkpoint_seconds: None,
        },
        deck: DeckSummary::of(prepared),
        version: env!("CARGO_PKG_VERSION"),
        provenance: None,
    };
    summary.judge();
    summary
}

/// Returns the job of a deck: the name is the file name without extension, the default folder `out/<job>`.
pub fn default_job(deck: &Path, folder: Option<PathBuf>) -> Result<JobFiles, Box<Diagnostic>> {
    let named = if deck == Path::new(STANDARD_INPUT) { None } else { deck.file_stem() };
    let name = named.map_or("job".into(), |s| s.to_string_lossy().into_owned());
    if [".", ".."].contains(&name.as_str()) {
        let message = format!("the deck name {} cannot be used for result files", deck.display());
        return Err(Box::new(Diagnostic::error("K008", message).help("rename the deck, for example to deck.inp")));
    }
    Ok(JobFiles { folder: folder.unwrap_or_else(|| Path::new("out").join(&name)), name })
}
