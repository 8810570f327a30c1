//! What commands that search by many runs of one plan share: their deck, its parameters, threads, files.
//! Never here: what is searched.

use std::error::Error;
use std::path::PathBuf;
use std::sync::Arc;

use crate::output::{self, Job};
use crate::study::StudyError;
use crate::study::chart::Chart;
use crate::study::evaluate::{Evaluator, Source, User};
use crate::study::quantity::Quantity;
use crate::study::statistics::Estimate;
use crate::study::table::{self, number};
use crate::user::compile::Compiled;
use clap::Args;

use super::words::{self, say, tell};
use super::{UserFiles, pairs, threads};

/// Deck, parameters that stay, threads, and what is printed.
#[derive(Args)]
pub struct Search {
    /// The input deck.
    pub deck: PathBuf,
    /// Replace the value of a *PARAMETER: NAME=VALUE.
    #[arg(short, long = "set", value_name = "NAME=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    user: UserFiles,
    /// Folder for table and pictures (default out/<deck name>).
    #[arg(short, long)]
    pub out: Option<PathBuf>,
    /// Threads (default: all cores; in a task of a scheduler those it gives, or one).
    #[arg(short, long)]
    threads: Option<usize>,
    /// Print one JSON object and nothing else.
    #[arg(long)]
    pub json: bool,
    /// Print nothing but errors.
    #[arg(short, long)]
    pub quiet: bool,
}

/// The user's routines, compiled.
pub struct Routines(Option<Arc<Compiled>>);

/// A table as it is shown and written.
pub struct Sheet {
    pub header: Vec<String>,
    pub rows: Vec<Vec<String>>,
}

impl Search {
    /// Threads to run on.
    pub fn threads(&self) -> usize {
        self.threads.unwrap_or_else(threads::default)
    }

    /// Whether nothing but the answer, or not even that, is printed.
    pub fn is_silent(&self) -> bool {
        self.quiet || self.json
    }

    /// Compiles the user's routines; `None` if they were refused (told).
    pub fn routines(&self) -> Option<Routines> {
        Some(Routines(self.user.compiled(self.is_silent())?.map(Arc::new)))
    }

    /// Quantities over parameters.
    pub fn evaluator(
        &self,
        names: Vec<String>,
        quantities: Vec<Quantity>,
        routines: &Routines,
    ) -> Result<Evaluator, Box<dyn Error>> {
        let fixed = pairs(&self.set)?;
        if let Some((name, _)) = fixed.iter().find(|pair| names.contains(&pair.0)) {
            return Err(format!("--set {name}: its values are given already").into());
        }
        let user = routines.0.clone().map_or(User::Absent, User::Files);
        Ok(Evaluator::new(Source::File(self.deck.clone()), fixed, names, quantities, user)?)
    }

    /// Prints a table and lines below it, unless nothing is to be printed.
    pub fn print(&self, sheet: &Sheet, lines: &[String]) {
        if !self.is_silent() {
            words::write(format_args!("{}", table::terminal(&sheet.header, &sheet.rows)), false);
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

/// Writes a table and charts, with their checksums; charts without points are left out.
pub fn write(job: &Job, name: &str, sheet: &Sheet, charts: &[(String, Chart)]) -> Result<(), Box<dyn Error>> {
    let mut files = vec![(format!("_{name}.csv"), table::csv(&sheet.header, &sheet.rows).into_bytes())];
    for (ending, chart) in charts.iter().filter(|(_, chart)| chart.series.iter().any(|s| !s.points.is_empty())) {
        files.push((format!("_{name}{ending}.svg"), chart.svg()?.into_bytes()));
        files.push((format!("_{name}{ending}.png"), chart.png()?));
    }
    Ok(output::write_with_sums(job, &files, &format!("_{name}.sfv")).map_err(|e| e.to_string())?)
}
