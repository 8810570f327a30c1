//! The command `revolve run`: a run with result files, checkpoints and restart.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicUsize;
use std::time::Duration;

use crate::deck::{self, Diagnostic, Diagnostics, untrusted};
use crate::job::{
    self, FrameOutput, Instructions, JobError, JobOptions, ParameterOverrides, PreparedJob, Provenance,
    RestartRequirement, RunSummary, Verdict,
};
use crate::model::Model;
use crate::output::checkpoint::Checkpoint;
use crate::output::{self, FrameFormat, FramePoints, FrameStyle, RunHistory};
use crate::overview::{self, StorageEstimate};
use crate::plan::WriteSchedule;
use crate::platform::signals::watch_signals;
use crate::solve::{CheckpointInterval, HaltReason, LOST, Progress, RunPosition};
use crate::study::quantity::{self, FinishedRun, Quantity};
use crate::study::settings::ModelEdit;
use crate::study::uncertainty::{ModelTraits, RunCertificate};
use crate::user::{Routines, host};
use crate::view::JobView;
use clap::Args;
use indexmap::IndexMap;
use serde::Serialize;

use super::options::{DeckOptions, FolderOption, OutputOptions, ThreadOption, start_threads};
use super::progress::{self, RunBar};
use super::slurm;
use super::uncertainty::{EstimatedRun, UncertaintyOptions};
use super::view::{self, ViewOption};
use super::watchdog::Watchdog;
use super::words::{self, print_err, print_out};
use super::{COMMIT, CommandStatus, accept, outcome, print_findings};

/// Run a deck and write frames, histories and a summary file.
#[derive(Args)]
pub struct RunCommand {
    /// Input deck.
    #[arg(value_parser = super::options::deck_parser())]
    deck: PathBuf,
    #[command(flatten)]
    options: DeckOptions,
    /// Run the user subroutines in a separate process: if they crash, the run still writes its results. Not available
    /// for VUSDFLD.
    #[arg(long, requires = "files")]
    isolate: bool,
    #[command(flatten)]
    folder: FolderOption,
    /// Restart from the checkpoint in the result folder; results are bit-identical to an uninterrupted run. Without a
    /// checkpoint the run starts at time 0.
    #[arg(long)]
    resume: bool,
    /// Like --resume, but also accept a checkpoint without the internal data of user subroutines; these data then have
    /// their initial values.
    #[arg(long)]
    resume_anyway: bool,
    /// Write a checkpoint at this interval: 10s, 5m or 1h of wall-clock time, or a number of increments.
    #[arg(long, value_name = "TIME|INCREMENTS", value_parser = every)]
    checkpoint_every: Option<CheckpointInterval>,
    #[command(flatten)]
    threads: ThreadOption,
    /// Instruction set for deformable elements: scalar, avx2 or avx512 (default: the best of this machine); results are
    /// bit-identical on all.
    #[arg(long, value_name = "SET")]
    instructions: Option<Instructions>,
    /// Print the value of an expression over history columns, for example "-1000*final(U2@REF)"; can be repeated.
    #[arg(long, allow_hyphen_values = true)]
    quantity: Vec<String>,
    #[command(flatten)]
    uncertainty: UncertaintyOptions,
    #[command(flatten)]
    output: OutputOptions,
    /// Coordinates of the points in frames: current, or reference (initial coordinates, for Warp By Vector with U in
    /// ParaView).
    #[arg(long, value_enum, default_value = "current", conflicts_with = "no_frames")]
    points: FramePoints,
    /// Files of the frames: pvd (one .vtu file per frame) or vtkhdf (one file with all frames, for VTK 9.5 and ParaView
    /// 6.0 or later).
    #[arg(long, value_enum, default_value = "pvd", conflicts_with = "no_frames")]
    format: FrameFormat,
    /// Write no frames, only histories and the summary file.
    #[arg(long)]
    no_frames: bool,
    /// Start the run even if its results are probably larger than the free disk space.
    #[arg(long)]
    force: bool,
    /// Print the ledger before the run: each effect with its cards and details.
    #[arg(long)]
    ledger: bool,
    /// Print the run time of each effect.
    #[arg(long)]
    profile: bool,
    /// End with exit status 3 if the verdict is worse: ok, or unverified (the mesh error may be unknown).
    #[arg(long, value_name = "VERDICT", value_parser = required_verdict)]
    require: Option<Verdict>,
    #[command(flatten)]
    view: ViewOption,
    /// Words of the command line; `None` for those of the process.
    #[arg(skip)]
    words: Option<Vec<String>>,
}

/// Parses the worst verdict that is accepted.
fn required_verdict(text: &str) -> Result<Verdict, String> {
    let accepted = [Verdict::Ok, Verdict::Unverified].into_iter().find(|verdict| verdict.word() == text);
    accepted.ok_or_else(|| "expected ok or unverified".to_owned())
}

/// Parses a checkpoint interval in seconds, minutes, hours or increments.
fn every(text: &str) -> Result<CheckpointInterval, String> {
    let wrong = || "expected 10s, 5m, 1h or a number of increments above zero".to_owned();
    if let Ok(increments) = text.parse::<u64>() {
        return if increments > 0 { Ok(CheckpointInterval::Increments(increments)) } else { Err(wrong()) };
    }
    duration(text).map(CheckpointInterval::Elapsed).ok_or_else(wrong)
}

/// Parses a time above zero in seconds, minutes or hours.
pub fn duration(text: &str) -> Option<Duration> {
    let unit = text.chars().last()?;
    let (unit, factor) = [('s', 1.0), ('m', 60.0), ('h', 3600.0)].into_iter().find(|known| known.0 == unit)?;
    let seconds: f64 = text.trim_end_matches(unit).parse().ok()?;
    Duration::try_from_secs_f64(factor * seconds).ok().filter(|time| *time > Duration::ZERO)
}

impl RunCommand {
    /// Returns the command, with the words of the original one, for copies of its files: the deck, the result folder and the
    /// files of user subroutines. It starts at time 0 and shows nothing in the browser.
    pub fn moved(mut self, words: Vec<String>, (deck, out): (PathBuf, PathBuf), user: Vec<PathBuf>) -> RunCommand {
        self.words = Some(words);
        self.deck = deck;
        self.folder.out = Some(out);
        self.options.user.files = user;
        RunCommand { resume: false, resume_anyway: false, view: ViewOption::default(), ..self }
    }

    pub fn execute(self) -> Result<CommandStatus, Box<dyn Error>> {
        // Before any thread starts: with --isolate the process is forked here.
        let (routines, user) = self.options.user.routines(self.is_silent(), self.isolate)?;
        let inputs = self.uncertainty.inputs()?;
        let settings = self.options.settings()?;
        let (mut prepared, traits) = self.prepared(&self.deck, &settings, &[], &routines)?;
        let quantities = self.uncertainty.quantities(&self.quantity, &traits)?;
        self.start_threads(&prepared)?;
        quantity::check_all(&quantities, &prepared.plan)?;
        let compiled = if self.uncertainty.is_requested() { self.options.user.compiled(true)? } else { None };
        let (deck, overrides, user_files) = (&*self.deck, &settings[..], compiled.as_ref());
        let estimated = EstimatedRun { deck, overrides, user: user_files, traits: &traits, quantities: &quantities };
        let chosen = self.uncertainty.chosen(&estimated, self.is_silent())?;
        let job = job::default_job(&self.deck, self.folder.out.clone())?;
        let provenance = self.provenance(&prepared);
        if let Some(chosen) = &chosen {
            let listed = job.path("_local.inp");
            if let Some(local) = &chosen.local {
                super::mesh::write(&listed, local.text.as_bytes())?;
            }
            let deck = if chosen.local.is_some() { &listed } else { &self.deck };
            prepared = self.prepared(deck, &chosen.overrides(&settings), &chosen.edits()?, &routines)?.0;
        }
        if let Some(instructions) = self.instructions {
            prepared.use_instructions(instructions)?;
        }
        let from = self.checkpoint(&prepared, &job, &user)?;
        self.note_missing_grace_period(&prepared);
        prepared.release_texts();
        if !self.is_silent() {
            let ledger = &prepared.plan.ledger;
            words::write(
                format_args!("{}", if self.ledger { ledger.render(false) } else { ledger.render_names() }),
                false,
            );
        }
        self.announce_output(&mut prepared, &job, from.is_some())?;
        let mut view = self.view.open(&job, self.is_silent())?;
        let signal = watch_signals()?;
        // The run takes the state itself, without a copy, which could be large.
        let state = Some(std::mem::take(&mut prepared.state));
        let frames = self.frames();
        let options = JobOptions {
            every: self.checkpoint_every,
            interrupt: Some(&*signal),
            from,
            state,
            user,
            provenance: Some(provenance),
            frames,
            ..JobOptions::default()
        };
        let mut summary = self.carry_out(&prepared, &job, options, &signal, view.as_mut())?;
        print_messages(&summary.messages, self.is_silent());
        if !self.is_silent() {
            outcome::print(&summary, &job, frames, self.profile);
        }
        let values = values(&quantities, &summary.history);
        let missed = chosen.as_ref().is_some_and(|chosen| !chosen.reached);
        let certificate = if self.uncertainty.is_requested() && summary.halt.is_none() {
            let numbers = values.values().map(|value| value.as_ref().ok().copied()).collect();
            let run = (&summary, numbers);
            let certificate = self.uncertainty.estimate(&estimated, inputs.as_ref(), chosen, &prepared, run, &job)?;
            summary.set_unknown(&job, certificate.unknown(&traits))?;
            Some(certificate)
        } else {
            None
        };
        if self.output.json {
            let quantities = values.iter().map(|(text, value)| (text.as_str(), value.as_ref().ok().copied())).collect();
            let certificate = certificate.as_ref();
            self.output.print_json(&RunReport { summary: &summary, quantities, certificate })?;
        } else if let Some(certificate) = &certificate {
            certificate.conclusions.iter().for_each(|line| print_out!("{line}"));
        } else {
            values.iter().for_each(|(text, value)| print_value(text, value));
        }
        if !self.is_silent() {
            outcome::print_verdict(&summary.verdict);
        }
        if let Some(view) = &view {
            view::serve_until_closed(view, &signal, self.is_silent());
        }
        let signal = signal.load(std::sync::atomic::Ordering::Relaxed);
        let end = print_end(&summary, &job, frames, signal);
        routines.memory.iter().for_each(|memory| memory.close());
        if matches!(summary.halt, Some(HaltReason::UserRoutine(_))) {
            crate::user::crash::leave(CommandStatus::HALTED.0);
        }
        // Libraries are never unloaded: a thread started by a user subroutine may still run in one.
        std::mem::forget((prepared, routines));
        Ok(match end {
            CommandStatus::SUCCESS if missed => CommandStatus::HALTED,
            CommandStatus::SUCCESS if self.require.is_some_and(|worst| summary.verdict.verdict > worst) => {
                CommandStatus::DOUBTFUL
            }
            _ => end,
        })
    }

    /// Returns the origin of the results: the deck as given, even if a refined one is run.
    fn provenance(&self, prepared: &PreparedJob) -> Provenance {
        let words = self.words.clone().unwrap_or_else(words::words_of_command);
        let commit = Some(COMMIT.to_owned()).filter(|commit| !commit.is_empty());
        Provenance { commit, ..Provenance::of(prepared, words, &self.options.user.files) }
    }

    /// Reads and plans a deck, and returns the properties of its model.
    fn prepared(
        &self,
        deck: &Path,
        settings: &ParameterOverrides,
        edits: &[ModelEdit],
        routines: &Routines,
    ) -> Result<(PreparedJob, ModelTraits), Box<dyn Error>> {
        let reading = progress::over_reading(deck, self.is_silent());
        let (mut traits, mut fault) = (ModelTraits::default(), Ok(()));
        let mut edit = |model: &mut Model| {
            fault = edits.iter().try_for_each(|edit| edit(model));
            traits = ModelTraits::of(model);
        };
        let prepared = job::prepare_edited(deck::read(deck, settings), &mut edit, routines);
        reading.finish_and_clear();
        accept(&prepared.diagnostics, &prepared.deck.sources, self.is_silent())?;
        fault?;
        Ok((prepared, traits))
    }

    /// Starts one thread per core or as many as requested, but not more than the run can use: idle threads would still
    /// be woken in each pass.
    fn start_threads(&self, prepared: &PreparedJob) -> Result<(), String> {
        let count = self.threads.count().min(prepared.most_threads());
        start_threads(count)
    }

    fn frames(&self) -> FrameOutput {
        let style = FrameStyle { points: self.points, format: self.format };
        if self.no_frames { FrameOutput::Absent } else { FrameOutput::Written(style) }
    }

    /// Returns whether informational output is suppressed.
    fn is_silent(&self) -> bool {
        self.output.is_silent()
    }

    /// Prints the size of the result files. An output that counts increments needs a short trial run.
    ///
    /// # Errors
    /// K011 if the files are larger than the free disk space, except for a restart or with `--force`.
    fn announce_output(
        &self,
        prepared: &mut PreparedJob,
        job: &output::JobFiles,
        resumed: bool,
    ) -> Result<(), Box<Diagnostic>> {
        let PreparedJob { plan, state, .. } = prepared;
        let steps = || plan.steps.iter().flat_map(|step| step.outputs.field.iter().chain(&step.outputs.history));
        let counts = steps().any(|schedule| matches!(schedule, WriteSchedule::Increments(_)));
        let (frames, restart) = (!self.no_frames, self.checkpoint_every.is_some());
        let (sizes, unchanged) = StorageEstimate::of(plan, std::mem::take(state), frames, restart);
        *state = unchanged;
        let effort = if counts { overview::measure(plan, state.clone(), overview::COUNTING_SHARE) } else { None };
        let estimate = sizes.with_effort(plan, effort.as_ref());
        let free = super::free_space(&job.folder);
        if !self.is_silent() {
            words::write(format_args!("{}", estimate.render(free)), false);
        }
        let is_unknown = estimate.frames.is_none() || estimate.rows.is_none();
        if untrusted::is_restricted() && (is_unknown || estimate.largest_bytes() > untrusted::MAX_OUTPUT) {
            let (needed, permitted) = (overview::size(estimate.largest_bytes()), overview::size(untrusted::MAX_OUTPUT));
            let message = format!("the results can need {needed}; with --untrusted at most {permitted} are permitted");
            return Err(Box::new(
                Diagnostic::error("K012", message).help("request fewer frames, rows or variables, or use --no-frames"),
            ));
        }
        match free {
            Some(free) if estimate.bytes() > free as f64 && !self.force && !resumed => {
                let (needed, free) = (overview::size(estimate.bytes()), overview::size(free as f64));
                let message = format!(
                    "the results need about {needed}, and {free} are free on the disk of {}",
                    job.folder.display()
                );
                Err(Box::new(Diagnostic::error("K011", message).help(
                    "request fewer frames, rows or variables, choose another folder with --out, or start the run with --force",
                )))
            }
            _ => Ok(()),
        }
    }

    /// Runs the job with a progress bar and a watchdog.
    fn carry_out(
        &self,
        prepared: &PreparedJob,
        job: &output::JobFiles,
        options: JobOptions<'_>,
        signal: &AtomicUsize,
        mut view: Option<&mut JobView>,
    ) -> Result<RunSummary, JobError> {
        let quiet = self.is_silent();
        let mut bar = RunBar::new(quiet);
        let above = bar.handle();
        let warn = |text: &str| {
            if !quiet || job::is_doubtful(text) {
                above.suspend(|| print_err!("warning: {text}"));
            }
        };
        let mut follow = |progress: &Progress<'_>| {
            bar.follow(progress);
            if let Some(view) = view.as_deref_mut() {
                view.report_progress(progress);
            }
        };
        // Run as one thread of the pool: calls from outside the pool would wait in each pass over the elements.
        let position = RunPosition::default();
        let options = JobOptions { warn: Some(&warn), position: Some(&position), ..options };
        let work = || job::run_with(prepared, job, options, &mut follow);
        let watchdog = Watchdog { plan: &prepared.plan, position: &position, signal, quiet };
        let summary =
            watchdog.during(|| if rayon::current_num_threads() > 1 { rayon::scope(|_| work()) } else { work() });
        bar.finish();
        summary
    }

    /// Returns the checkpoint for a restart if one is requested and exists, and prints notes on it.
    fn checkpoint(
        &self,
        prepared: &PreparedJob,
        job: &output::JobFiles,
        user: &str,
    ) -> Result<Option<Checkpoint>, Box<Diagnostic>> {
        if !self.resume && !self.resume_anyway {
            return Ok(None);
        }
        let demand = if self.resume_anyway { RestartRequirement::Anything } else { RestartRequirement::Whole };
        let (checkpoint, mut notes) = job::find_checkpoint(prepared, job, user, demand)?;
        if self.is_silent() {
            // The note on lost data of user subroutines is printed in any case.
            notes.retain(|note| note.code == "K102");
        }
        print_findings(&notes, &prepared.deck.sources);
        Ok(checkpoint)
    }

    /// Prints a note if Slurm would kill the run at the time limit of the job before it has written a checkpoint.
    fn note_missing_grace_period(&self, prepared: &PreparedJob) {
        let writes_checkpoints = || prepared.plan.steps.iter().any(|step| !step.outputs.restart.is_empty());
        if self.is_silent() || self.checkpoint_every.is_some() || writes_checkpoints() || !slurm::has_no_grace_period()
        {
            return;
        }
        let message = "at its time limit, Slurm will kill this run before it can write a checkpoint: the batch script \
                       runs it as an ordinary command";
        let mut notes = Diagnostics::default();
        notes.push(Diagnostic::note("K104", message).help("add --checkpoint-every 10m, or start it with exec or srun"));
        print_findings(&notes, &prepared.deck.sources);
    }
}

/// Value or error of each quantity.
type QuantityValues = IndexMap<String, Result<f64, String>>;

fn values(quantities: &[Quantity], history: &RunHistory) -> QuantityValues {
    let run = FinishedRun { history, end: None };
    let value = |q: &Quantity| (q.text.clone(), q.number(run).map_err(|e| e.to_string()));
    quantities.iter().map(value).collect()
}

fn print_value(text: &str, value: &Result<f64, String>) {
    match value {
        Ok(value) => print_out!("{text} = {value:?}"),
        Err(why) => print_err!("error: {why}"),
    }
}

/// Summary with the requested quantities, as `--json` prints it.
#[derive(Serialize)]
struct RunReport<'a> {
    #[serde(flatten)]
    summary: &'a RunSummary,
    #[serde(skip_serializing_if = "IndexMap::is_empty")]
    quantities: IndexMap<&'a str, Option<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    certificate: Option<&'a RunCertificate>,
}

/// Prints the reason of a halt. Returns 0, the status of a halted run, or 128 plus the signal number, as shells do.
fn print_end(summary: &RunSummary, job: &output::JobFiles, frames: FrameOutput, signal: usize) -> CommandStatus {
    let Some(halt) = &summary.halt else { return CommandStatus::SUCCESS };
    // After a failure of the first frame there is no file.
    let last =
        frames.file(job).map_or_else(String::new, |path| format!("\nthe last valid state is in {}", path.display()));
    print_err!("halted: {halt}{last}");
    if !summary.interrupted {
        return CommandStatus::HALTED;
    }
    match &summary.lost[..] {
        [] => print_err!("continue with --resume"),
        lost => print_err!("{LOST}: {}\n--resume-anyway continues without it", lost.join("; ")),
    }
    CommandStatus(128 + signal as u8)
}

/// Prints the messages of user subroutines.
fn print_messages(messages: &[host::RoutineMessage], quiet: bool) {
    for message in messages.iter().filter(|m| !quiet || m.level == host::MessageLevel::Error) {
        let level = format!("{:?}", message.level).to_lowercase();
        let times = if message.times > 1 { format!(" ({} times)", message.times) } else { String::new() };
        print_err!("{level} from a user subroutine: {}{times}", message.text);
    }
}
