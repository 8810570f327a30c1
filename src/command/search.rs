//! What commands that search by many runs of one plan share: their deck, its parameters, threads, files.

use std::error::Error;
use std::path::PathBuf;
use std::sync::Arc;

use crate::job::Refusal;
use crate::output::Job;
use crate::output::lock::FolderLock;
use crate::study::StudyError;
use crate::study::evaluate::{DeckSource, Evaluator, UserRoutines};
use crate::study::quantity::Quantity;
use crate::study::statistics::Estimate;
use crate::study::table::{Table, number};
use crate::user::compile::Compiled;
use clap::Args;

use super::words::{say, tell};
use super::{AlreadyPrinted, UserFiles, lock_job, pairs, print_table, threads};

/// Deck, parameters that stay, threads, and what is printed.
#[derive(Args)]
pub struct SearchArguments {
    /// The input deck.
    deck: PathBuf,
    /// Replace the value of a *PARAMETER: NAME=VALUE.
    #[arg(short, long = "set", value_name = "NAME=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    user: UserFiles,
    /// Folder for table and pictures (default out/<deck name>).
    #[arg(short, long)]
    out: Option<PathBuf>,
    /// Threads (default: all cores; in a task of a scheduler those it gives, or one).
    #[arg(short, long)]
    threads: Option<usize>,
    /// Print one JSON object and nothing else.
    #[arg(long)]
    json: bool,
    /// Print nothing but errors.
    #[arg(short, long)]
    quiet: bool,
}

pub struct CompiledRoutines(Option<Arc<Compiled>>);

impl SearchArguments {
    pub fn threads(&self) -> usize {
        self.threads.unwrap_or_else(threads::default)
    }

    /// Whether nothing but the answer, or not even that, is printed.
    pub fn is_silent(&self) -> bool {
        self.quiet || self.json
    }

    /// Compiles the user's routines.
    pub fn routines(&self) -> Result<CompiledRoutines, AlreadyPrinted> {
        Ok(CompiledRoutines(self.user.compiled(self.is_silent())?.map(Arc::new)))
    }

    /// The job of the deck, whose folder is locked.
    pub fn job(&self) -> Result<(Job, FolderLock), Refusal> {
        lock_job(&self.deck, self.out.clone())
    }

    /// Quantities over parameters.
    pub fn evaluator(
        &self,
        names: Vec<String>,
        quantities: Vec<Quantity>,
        routines: &CompiledRoutines,
    ) -> Result<Evaluator, Box<dyn Error>> {
        let fixed = pairs(&self.set)?;
        if let Some((name, _)) = fixed.iter().find(|pair| names.contains(&pair.0)) {
            return Err(format!("--set {name}: its values are given already").into());
        }
        let user = routines.0.clone().map_or(UserRoutines::Absent, UserRoutines::Files);
        Ok(Evaluator::new(DeckSource::File(self.deck.clone()), fixed, names, quantities, user)?)
    }

    /// Prints a table and lines below it, unless nothing is to be printed.
    pub fn print(&self, table: &Table, lines: &[String]) {
        if !self.is_silent() {
            print_table(table);
            lines.iter().for_each(|line| say!("{line}"));
        }
    }

    /// Prints the one object of `--json`, if that is asked.
    pub fn print_json(&self, object: &serde_json::Value) -> Result<(), Box<dyn Error>> {
        if self.json {
            say!("{}", serde_json::to_string_pretty(object)?);
        }
        Ok(())
    }
}

/// Tells of runs whose body still moved.
pub fn tell_still_moving(evaluator: &Evaluator) {
    let count = evaluator.still_moving();
    if count > 0 {
        tell!(
            "warning: at the end of {count} runs a body still moves in the target: a depth read then is not its last"
        );
    }
}

/// Tells how many runs gave nothing, and why the first did not.
pub fn tell_failures(failed: usize, runs: usize, reason: Option<&StudyError>) {
    if let Some(reason) = reason {
        tell!("{failed} of {runs} runs gave no result; the first:\n{reason}");
    }
}

/// A number with its interval, as cells of a table.
pub fn cells(estimate: Estimate) -> [String; 3] {
    [estimate.value, estimate.low, estimate.high].map(|v| if v.is_finite() { number(v) } else { "-".into() })
}

/// Header of a table of numbers with intervals.
pub fn header(what: &str) -> Vec<String> {
    [what, "value", "95 % from", "to"].map(str::to_owned).to_vec()
}
