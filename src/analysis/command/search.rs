//! Options and output shared by the commands `limit`, `identify`, `scatter` and `sensitivity`, which evaluate one plan many times.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::job::JobError;
use crate::output::JobFiles;
use crate::output::lock::FolderLock;
use crate::study::evaluate::{DeckSource, SampleEvaluator, UserRoutines};
use crate::study::log::RunLog;
use crate::study::quantity::Quantity;
use crate::study::statistics::IntervalEstimate;
use crate::study::table::{TextTable, number};
use crate::user::compile::Compiled;
use clap::Args;

use super::options::{OutputOptions, ResultOptions, ResumeOption, SetOption};
use super::words::{print_err, print_out};
use super::{AlreadyPrinted, ResultFile, UserFiles, print_table};

/// Options for the deck, its fixed parameters, threads and output.
#[derive(Args)]
pub struct SearchArguments {
    /// Input deck.
    #[arg(value_parser = super::options::deck_parser())]
    deck: PathBuf,
    #[command(flatten)]
    set: SetOption,
    #[command(flatten)]
    user: UserFiles,
    /// Integrate every run in time increments, with the bits of `revolve run`. By default, shots of rigid bodies into
    /// unbounded layers are solved by stages.
    #[arg(long)]
    pub in_increments: bool,
    #[command(flatten)]
    pub resume: ResumeOption,
    #[command(flatten)]
    pub results: ResultOptions,
    #[command(flatten)]
    pub output: OutputOptions,
}

/// Compiled user subroutines; `None` without any.
pub type CompiledRoutines = Option<Arc<Compiled>>;

impl SearchArguments {
    pub fn threads(&self) -> usize {
        self.results.threads.count()
    }

    /// Returns the path of the deck.
    pub fn deck(&self) -> &Path {
        &self.deck
    }

    /// Returns the fixed parameters.
    pub fn settings(&self) -> Result<Vec<(String, String)>, String> {
        self.set.pairs()
    }

    /// Returns whether informational output is suppressed.
    pub fn is_silent(&self) -> bool {
        self.output.is_silent()
    }

    /// Compiles the user subroutines.
    pub fn routines(&self) -> Result<CompiledRoutines, AlreadyPrinted> {
        Ok(self.user.compiled(self.is_silent())?.map(Arc::new))
    }

    /// Returns the job of the deck and the lock of its output folder.
    pub fn job(&self) -> Result<(JobFiles, FolderLock), JobError> {
        self.results.lock_job(&self.deck)
    }

    /// Creates the evaluator of `quantities` over the parameters `names`.
    pub fn evaluator(
        &self,
        names: Vec<String>,
        quantities: Vec<Quantity>,
        routines: &CompiledRoutines,
    ) -> Result<SampleEvaluator, Box<dyn Error>> {
        let fixed = self.set.pairs()?;
        if let Some((name, _)) = fixed.iter().find(|pair| names.contains(&pair.0)) {
            return Err(format!("--set {name}: another option gives the values of this parameter").into());
        }
        let user = routines.clone().map_or(UserRoutines::Absent, UserRoutines::Files);
        let evaluator = SampleEvaluator::new(DeckSource::File(self.deck.clone()), fixed, names, quantities, user)?;
        Ok(if self.in_increments { evaluator.in_increments() } else { evaluator })
    }

    /// Removes the list of finished runs after the results have been written.
    pub fn end_log(&self, log: &RunLog) {
        self.resume.end(log, self.is_silent());
    }

    /// Prints a table and the lines below it, unless output is suppressed.
    pub fn print(&self, table: &TextTable, lines: &[String]) {
        if !self.is_silent() {
            print_table(table);
            lines.iter().for_each(|line| print_out!("{line}"));
        }
    }
}

/// Warns of `count` runs at whose end a body was still moving in a target.
pub fn warn_still_moving(count: usize) {
    if count > 0 {
        print_err!(
            "warning: R315: in {count} runs a body is still moving in the target at the end; their depths are not final"
        );
    }
}

/// Number format of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NumberFormat {
    /// Few digits, for the terminal.
    Rounded,
    /// All digits, for files.
    Exact,
}

impl NumberFormat {
    pub fn text(self, value: f64) -> String {
        if self == NumberFormat::Exact { format!("{value:?}") } else { number(value) }
    }

    /// Formats an estimate and its confidence interval as table cells.
    pub fn cells(self, estimate: IntervalEstimate) -> [String; 3] {
        [estimate.value, estimate.low, estimate.high].map(|v| if v.is_finite() { self.text(v) } else { "-".into() })
    }
}

/// Returns the file `<job>_<name>.json` of the object that `--json` prints.
pub fn json_file(name: &str, object: &serde_json::Value) -> Result<ResultFile, serde_json::Error> {
    Ok((format!("_{name}.json"), (serde_json::to_string_pretty(object)? + "\n").into_bytes()))
}

/// Returns the header of a table of estimates with confidence intervals.
pub fn header(what: &str) -> Vec<String> {
    [what, "value", "95 % from", "to"].map(str::to_owned).to_vec()
}
