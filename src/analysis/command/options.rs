//! Options that several commands have. Each is defined once.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser};
use serde::Serialize;

use super::words::{print_err, print_out};
use super::{UserFiles, pairs, threads};
use crate::deck::{self, CURVE_SETTING};
use crate::job::{self, JobError};
use crate::output::JobFiles;
use crate::output::lock::FolderLock;
use crate::report::QuantityLabels;
use crate::study::StudyError;
use crate::study::log::RunLog;
use crate::user::{thread_failure, thread_pool};

/// Returns the parser of the path of a deck, whose ending `.inp` may be left out.
pub fn deck_parser() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().map(|path: PathBuf| {
        let with_ending = path.with_extension("inp");
        if path.extension().is_none() && !path.is_file() && with_ending.is_file() { with_ending } else { path }
    })
}

/// Values of deck parameters.
#[derive(Args)]
pub struct SetOption {
    /// Override a *PARAMETER of the deck: NAME=VALUE; can be repeated.
    #[arg(short, long = "set", value_name = "NAME=VALUE")]
    set: Vec<String>,
}

impl SetOption {
    /// Returns names and values; several values and distributions are errors.
    pub fn pairs(&self) -> Result<Vec<(String, String)>, String> {
        pairs(&self.set)
    }
}

/// Options of a deck that is run or checked once.
#[derive(Args)]
pub struct DeckOptions {
    #[command(flatten)]
    set: SetOption,
    /// Divide each edge of the mesh into N equal parts. Sets, surfaces, loads and constraints follow.
    #[arg(long, value_name = "N")]
    mesh_refine: Option<u32>,
    #[command(flatten)]
    curved: CurvedOption,
    #[command(flatten)]
    pub user: UserFiles,
}

impl DeckOptions {
    pub fn settings(&self) -> Result<Vec<(String, String)>, String> {
        let mut settings = self.set.pairs()?;
        settings.extend(self.mesh_refine.map(|parts| (deck::MESH_SETTINGS[0].to_owned(), parts.to_string())));
        settings.extend(self.curved.setting());
        Ok(settings)
    }
}

/// Option for curved boundaries of a refined mesh.
#[derive(Args)]
pub struct CurvedOption {
    /// Fit smooth curves to the boundaries of a refined mesh; they have corners where a boundary of the deck turns by more
    /// than this angle in degrees.
    #[arg(long, value_name = "ANGLE", num_args = 0..=1, require_equals = true, default_missing_value = "30")]
    curved: Option<String>,
}

impl CurvedOption {
    /// Returns the setting of the deck.
    pub fn setting(&self) -> Option<(String, String)> {
        self.curved.as_ref().map(|angle| (CURVE_SETTING.to_owned(), angle.clone()))
    }
}

/// Number of threads of a command that runs decks.
#[derive(Args, Clone, Copy)]
pub struct ThreadOption {
    /// Number of threads (default: all cores; in a scheduler task the assigned cores, or one); results are bit-identical
    /// for any number.
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

impl ThreadOption {
    pub fn count(self) -> usize {
        self.threads.map_or_else(threads::default, Into::into)
    }

    /// Starts the threads of all later parallel loops.
    pub fn start(self) -> Result<(), String> {
        start_threads(self.count())
    }
}

/// Starts so many threads for all later parallel loops.
pub fn start_threads(count: usize) -> Result<(), String> {
    thread_pool(count).build_global().map_err(|error| thread_failure(count, &error))
}

/// Result folder of a command that writes several files.
#[derive(Args, Clone)]
pub struct FolderOption {
    /// Result folder (default: out/<deck name>).
    #[arg(short, long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
}

/// Continuation of a command that makes many runs.
#[derive(Args, Clone, Copy)]
pub struct ResumeOption {
    /// Continue an interrupted command: runs that have finished are not repeated.
    #[arg(long)]
    resume: bool,
}

impl ResumeOption {
    /// Begins the list of finished runs of a job.
    ///
    /// # Errors
    /// If the list cannot be read or written.
    pub fn log(self, job: &JobFiles) -> Result<Arc<RunLog>, StudyError> {
        RunLog::begin(job, self.resume).map(Arc::new)
    }

    /// Removes the list after the results have been written, and prints how many runs were taken from it.
    pub fn end(self, log: &RunLog, is_silent: bool) {
        if let Some(warning) = log.finish() {
            print_err!("warning: {warning}");
        }
        if self.resume && !is_silent {
            print_out!("{}", log.reused());
        }
    }
}

/// Suppression of informational output.
#[derive(Args, Clone, Copy)]
pub struct QuietOption {
    /// Print errors only, and warnings that results may be wrong (R301 to R304).
    #[arg(short, long)]
    pub quiet: bool,
}

/// Form of the output of a command with a JSON object.
#[derive(Args, Clone, Copy)]
pub struct OutputOptions {
    #[command(flatten)]
    pub quiet: QuietOption,
    /// Print only one JSON object.
    #[arg(long)]
    pub json: bool,
}

impl OutputOptions {
    /// Returns whether informational output is suppressed.
    pub fn is_silent(self) -> bool {
        self.quiet.quiet || self.json
    }

    /// Prints a JSON object if `--json` is given.
    pub fn print_json(self, object: &impl Serialize) -> Result<(), serde_json::Error> {
        if self.json {
            print_out!("{}", serde_json::to_string_pretty(object)?);
        }
        Ok(())
    }
}

/// Labels of quantities in pictures.
#[derive(Args, Clone)]
pub struct LabelOption {
    /// Label shown in pictures for a quantity, a column or a parameter, for example U2@REF="depth"; can be repeated.
    #[arg(long, value_name = "COLUMN=TEXT")]
    pub label: Vec<String>,
}

impl LabelOption {
    /// Parses the labels; a label of a name that is not among the `known` ones is an error.
    pub fn checked(&self, known: impl IntoIterator<Item = impl Into<String>>) -> Result<QuantityLabels, String> {
        let labels = QuantityLabels::parse(&self.label)?;
        labels.check(&known.into_iter().map(Into::into).collect::<Vec<_>>())?;
        Ok(labels)
    }
}

/// Options of a command that runs decks and writes tables and pictures.
#[derive(Args)]
pub struct ResultOptions {
    #[command(flatten)]
    folder: FolderOption,
    #[command(flatten)]
    pub threads: ThreadOption,
    #[command(flatten)]
    pub labels: LabelOption,
}

impl ResultOptions {
    pub fn job(&self, deck: &Path) -> Result<JobFiles, JobError> {
        job::default_job(deck, self.folder.out.clone()).map_err(JobError::Checkpoint)
    }

    /// Returns the job of a deck and locks its output folder against other jobs.
    pub fn lock_job(&self, deck: &Path) -> Result<(JobFiles, FolderLock), JobError> {
        let job = self.job(deck)?;
        let lock = job::lock_folder(&job)?;
        Ok((job, lock))
    }
}
