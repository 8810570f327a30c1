//! `revolve sweep`.

use std::error::Error;
use std::path::PathBuf;

use crate::deck::files;
use crate::model::Precision;
use crate::study::compare::Reference;
use crate::study::grid::Grid;
use crate::study::quantity::Quantity;
use crate::study::{sweep, table};
use crate::user::compile::Compiled;
use crate::{deck, job, output};
use clap::Args;
use indexmap::IndexMap;
use serde::Serialize;

use super::words::{self, say, tell};
use super::{HALTED, REFUSED, Status, UserFiles, accepted, folder_of, given, progress, tell_doubts};

/// Run a deck over values of its parameters: one table, CSV and picture.
#[derive(Args)]
pub struct Sweep {
    /// The input deck.
    deck: PathBuf,
    /// NAME=v1,v2,… or NAME=start:stop:step or NAME=start:stop:#count; several make a grid.
    #[arg(short, long = "set", value_name = "NAME=VALUES", required_unless_present = "samples")]
    set: Vec<String>,
    /// CSV file with a parameter a column and a run a row: any design of experiments. `--set` then gives other parameters one
    /// value each.
    #[arg(long, value_name = "FILE")]
    samples: Option<PathBuf>,
    /// Keep the results of each run: summary and histories in a folder of its own, `<out>/<deck>_00001` and so on.
    #[arg(long)]
    keep: bool,
    /// Expression over history columns, such as "-1000*final(U2@REF)"; may be given several times.
    #[arg(long, required = true, allow_hyphen_values = true)]
    quantity: Vec<String>,
    /// CSV file with reference columns over the first parameter.
    #[arg(long)]
    compare: Option<PathBuf>,
    #[command(flatten)]
    user: UserFiles,
    /// Folder for table and picture (default out/<deck name>).
    #[arg(short, long)]
    out: Option<PathBuf>,
    /// Precision of solid elements: double or single.
    #[arg(long, value_name = "DIGITS", default_value = "double")]
    precision: Precision,
    /// Threads (default: all cores).
    #[arg(short, long)]
    threads: Option<usize>,
    /// Print one JSON object: parameters and values of each run, or why there are none.
    #[arg(long)]
    json: bool,
    /// Print nothing but errors.
    #[arg(short, long)]
    quiet: bool,
}

impl Sweep {
    /// Carries it out.
    pub fn execute(self) -> Result<Status, Box<dyn Error>> {
        let grid = match &self.samples {
            None => Grid::parse(&self.set)?,
            Some(path) => {
                let text = files::read_text(path).map_err(|e| format!("{}: {e}", path.display()))?;
                Grid::samples(path, &text, &self.set)?
            }
        };
        let quantities = self.quantity.iter().map(|q| Quantity::parse(q)).collect::<Result<Vec<_>, _>>()?;
        let reference = self.compare.as_deref().map(Reference::read).transpose()?;
        if let (Some(path), Some(reference)) = (&self.compare, &reference) {
            sweep::comparable(&grid, path, reference)?;
        }
        if let Some(path) = self.compare.as_ref().filter(|_| reference.as_ref().is_some_and(|r| r.is_open)) {
            tell!(
                "warning: --compare {}: the last line has no end; if the file is cut off its last row is wrong",
                path.display()
            );
        }
        let Some(compiled) = self.user.compiled(self.quiet || self.json) else { return Ok(Status::from(REFUSED)) };
        let routines = Compiled::open_any(compiled.as_ref()).map_err(|fault| fault.message)?;
        let first = job::prepare_in(self.precision, &self.deck, &grid.combination(0), &routines);
        if !accepted(&first, self.quiet || self.json) {
            return Ok(Status::from(REFUSED));
        }
        for quantity in &quantities {
            quantity.stands_alone()?;
            quantity.check(&first.plan)?;
        }
        let Some((job, _lock)) = folder_of(&self.deck, self.out)? else { return Ok(Status::from(REFUSED)) };
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(self.threads.unwrap_or(0))
            .build()
            .map_err(|e| e.to_string())?;
        let bar = progress::over_runs(grid.count() as u64, self.quiet);
        let kept = self.keep.then_some(&job);
        let done = || bar.inc(1);
        let deck = (&*self.deck, self.precision);
        let results = pool.install(|| sweep::run_keeping(deck, &grid, &quantities, compiled.as_ref(), kept, &done));
        bar.finish_and_clear();
        let sheet = sweep::sheet(&grid, &quantities, &results, reference.as_ref());
        write_sweep(&job, &first.deck, &grid, &quantities, &results, reference.as_ref(), &sheet)?;
        if self.json {
            print_json(&grid, &quantities, &results, &sheet)?;
        } else if !self.quiet {
            print_sweep(&sheet, &job);
        }
        tell_doubts(&doubts(&grid, &results));
        Ok(report_failures(&results))
    }
}

/// A run of a sweep as `--json` prints it.
#[derive(Serialize)]
struct Run<'a> {
    parameters: IndexMap<&'a str, &'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    values: Option<IndexMap<&'a str, f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    doubts: &'a [String],
}

fn print_json(
    grid: &Grid,
    quantities: &[Quantity],
    results: &sweep::Results,
    sheet: &sweep::Sheet,
) -> Result<(), Box<dyn Error>> {
    let names = grid.names();
    let all = results.parameters.iter().zip(&results.values).zip(&results.doubts);
    let runs: Vec<Run<'_>> = all
        .map(|((parameters, values), doubts)| Run {
            parameters: names.iter().copied().zip(parameters.iter().map(String::as_str)).collect(),
            values: values
                .as_ref()
                .ok()
                .map(|v| quantities.iter().map(|q| q.text.as_str()).zip(v.iter().copied()).collect()),
            error: values.as_ref().err().map(ToString::to_string),
            doubts,
        })
        .collect();
    let rms: IndexMap<&str, f64> = sheet.rms.iter().map(|(column, rms)| (column.as_str(), *rms)).collect();
    say!("{}", serde_json::to_string_pretty(&serde_json::json!({ "runs": runs, "rms": rms }))?);
    Ok(())
}

fn print_sweep(sheet: &sweep::Sheet, job: &output::Job) {
    if sheet.rows.is_empty() {
        return;
    }
    words::write(format_args!("{}", table::terminal(&sheet.header, &sheet.rows)), false);
    for (column, rms) in &sheet.rms {
        say!("rms difference from {column}: {rms:.4}");
    }
    say!("table {}, picture {}", job.path("_sweep.csv").display(), job.path("_sweep.png").display());
}

/// Each run's parameters, and what is to be known of its values.
fn doubts<'a>(grid: &Grid, results: &'a sweep::Results) -> Vec<(String, &'a [String])> {
    let names = grid.names();
    let runs = results.parameters.iter().zip(&results.doubts);
    runs.map(|(values, doubts)| (given(names.iter().copied().zip(values)), &doubts[..])).collect()
}

fn report_failures(results: &sweep::Results) -> Status {
    let failed: Vec<_> = results.values.iter().filter_map(|v| v.as_ref().err()).collect();
    match failed.first() {
        None => Status::SUCCESS,
        Some(reason) => {
            tell!("{} of {} runs gave no result; the first:\n{reason}", failed.len(), results.values.len());
            Status::from(HALTED)
        }
    }
}

fn write_sweep(
    job: &output::Job,
    deck: &deck::Deck,
    grid: &Grid,
    quantities: &[Quantity],
    results: &sweep::Results,
    reference: Option<&Reference>,
    sheet: &sweep::Sheet,
) -> Result<(), Box<dyn Error>> {
    let title = deck.sources.files().first().map_or("sweep", |f| f.name.as_str());
    // A table without a row takes no good one's place.
    if sheet.rows.is_empty() {
        return Ok(());
    }
    let chart = sweep::chart(title, grid, quantities, results, reference);
    let files = [
        ("_sweep.csv".to_owned(), table::csv(&sheet.header, &sheet.rows).into_bytes()),
        ("_sweep.svg".into(), chart.svg()?.into_bytes()),
        ("_sweep.png".into(), chart.png()?),
    ];
    Ok(output::write_with_sums(job, &files, "_sweep.sfv").map_err(|e| e.to_string())?)
}
