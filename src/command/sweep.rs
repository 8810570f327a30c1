//! `revolve sweep`.

use std::error::Error;
use std::ops::Range;
use std::path::PathBuf;

use crate::deck::files;
use crate::model::Precision;
use crate::study::cases::{self, CaseRange, SweepPart};
use crate::study::compare::Reference;
use crate::study::dakota;
use crate::study::grid::Grid;
use crate::study::quantity::Quantity;
use crate::study::sweep;
use crate::user::compile::Compiled;
use crate::{job, output};
use clap::Args;
use indexmap::IndexMap;
use serde::Serialize;

use super::words::{self, say, tell};
use super::{
    HALTED, Status, UserFiles, accept, given, lock_job, print_table, progress, tell_doubts, threads, write_results,
};

/// Run a deck over values of its parameters: one table, CSV and picture.
#[derive(Args)]
pub struct Sweep {
    /// The input deck.
    deck: PathBuf,
    /// NAME=v1,v2,… or NAME=start:stop:step or NAME=start:stop:#count; several make a grid.
    #[arg(short, long = "set", value_name = "NAME=VALUES", required_unless_present_any = ["samples", "dakota"])]
    set: Vec<String>,
    /// CSV file with a parameter a column and a run a row: any design of experiments. `--set` then gives other parameters one
    /// value each.
    #[arg(long, value_name = "FILE")]
    samples: Option<PathBuf>,
    /// So many cases at random: `--set NAME=low..high` is drawn evenly, `--set "NAME=normal(mean, deviation)"` and others as in
    /// `scatter`; other parameters have one value each. A case depends on its number and the seed alone.
    #[arg(long, value_name = "N", conflicts_with_all = ["samples", "dakota"])]
    random: Option<usize>,
    /// Seed of `--random`.
    #[arg(long, value_name = "NUMBER", default_value_t = 0, requires = "random")]
    seed: u64,
    /// Run some of the cases and leave them as a part in the folder: A-B, A, K/N (part K of N), or task/N and task, where the
    /// number is that of a task of an array (Slurm, HyperQueue, PBS, Grid Engine, LSF).
    #[arg(long, value_name = "CASES", conflicts_with_all = ["dakota", "compare", "json"])]
    cases: Option<String>,
    /// Run nothing: make the table of the parts that are in the folder, or say what is missing.
    #[arg(long, conflicts_with_all = ["cases", "dakota", "keep"])]
    gather: bool,
    /// Run nothing: print the list of cases as CSV.
    #[arg(long, conflicts_with_all = ["gather", "dakota", "keep", "compare", "json"])]
    plan: bool,
    /// Dakota's parameters file and the results file it waits for, standard or JSON, of one evaluation or a batch; each
    /// `--quantity` answers one response.
    #[arg(long, num_args = 2, value_names = ["PARAMETERS", "RESULTS"], conflicts_with_all = ["samples", "keep", "compare", "json"])]
    dakota: Option<Vec<PathBuf>>,
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
    /// Threads (default: all cores; in a task of a scheduler those it gives, or one).
    #[arg(short, long)]
    threads: Option<usize>,
    /// Print one JSON object: parameters and values of each run, or why there are none.
    #[arg(long)]
    json: bool,
    /// Print nothing but errors.
    #[arg(short, long)]
    quiet: bool,
}

/// A sweep whose deck and arguments have been checked.
struct PreparedSweep {
    grid: Grid,
    quantities: Vec<Quantity>,
    compiled: Option<Compiled>,
    /// The deck with the values of the first case.
    first: job::Prepared,
}

impl Sweep {
    pub fn execute(self) -> Result<Status, Box<dyn Error>> {
        let quantities = self.quantity.iter().map(|q| Quantity::parse(q)).collect::<Result<Vec<_>, _>>()?;
        if let Some(files) = &self.dakota {
            return self.answer_dakota(files, quantities);
        }
        let grid = self.grid()?;
        let cases =
            self.cases.as_deref().map(CaseRange::parse).transpose()?.map(|cases| cases.of(grid.count())).transpose()?;
        if self.plan {
            words::write(format_args!("{}", cases::list(&grid, cases.unwrap_or(0..grid.count()))), false);
            return Ok(Status::SUCCESS);
        }
        let reference = self.reference(&grid)?;
        let asked = self.prepare(grid, quantities)?;
        match cases {
            Some(cases) => self.run_part(&asked, cases),
            None => self.run_all(&asked, reference.as_ref()),
        }
    }

    fn grid(&self) -> Result<Grid, Box<dyn Error>> {
        Ok(match (&self.samples, self.random) {
            (Some(path), _) => {
                let text = files::read_text(path).map_err(|e| format!("{}: {e}", path.display()))?;
                Grid::samples(path, &text, &self.set)?
            }
            (None, Some(count)) => Grid::random(&self.set, count, self.seed)?,
            (None, None) => Grid::parse(&self.set)?,
        })
    }

    fn reference(&self, grid: &Grid) -> Result<Option<Reference>, Box<dyn Error>> {
        let Some(path) = &self.compare else { return Ok(None) };
        let reference = Reference::read(path)?;
        sweep::comparable(grid, path, &reference)?;
        if reference.is_open {
            tell!(
                "warning: --compare {}: the last line has no end; if the file is cut off its last row is wrong",
                path.display()
            );
        }
        Ok(Some(reference))
    }

    /// Checks deck, routines and quantities with the first case.
    fn prepare(&self, grid: Grid, quantities: Vec<Quantity>) -> Result<PreparedSweep, Box<dyn Error>> {
        let compiled = self.user.compiled(self.quiet || self.json)?;
        let routines = Compiled::open_any(compiled.as_ref())?;
        let first = job::prepare_in(self.precision, &self.deck, &grid.combination(0), &routines);
        accept(&first, self.quiet || self.json)?;
        for quantity in &quantities {
            quantity.stands_alone()?;
            quantity.check(&first.plan)?;
        }
        Ok(PreparedSweep { grid, quantities, compiled, first })
    }

    /// Runs some of the cases on all threads.
    fn run(
        &self,
        asked: &PreparedSweep,
        cases: Range<usize>,
        kept: Option<&output::Job>,
    ) -> Result<sweep::Results, Box<dyn Error>> {
        let threads = self.threads.unwrap_or_else(threads::default);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(|e| e.to_string())?;
        let bar = progress::over_runs(cases.len() as u64, self.quiet);
        let done = || bar.inc(1);
        let PreparedSweep { grid, quantities, compiled, .. } = asked;
        let deck = (&*self.deck, self.precision);
        let results = pool.install(|| sweep::run(deck, (grid, cases), quantities, compiled.as_ref(), kept, &done));
        bar.finish_and_clear();
        Ok(results)
    }

    fn run_all(&self, asked: &PreparedSweep, reference: Option<&Reference>) -> Result<Status, Box<dyn Error>> {
        let (job, _lock) = lock_job(&self.deck, self.out.clone())?;
        let PreparedSweep { grid, quantities, first, .. } = asked;
        let results = if self.gather {
            asked.part(&asked.identity()).gather(&job)?
        } else {
            self.run(asked, 0..grid.count(), self.keep.then_some(&job))?
        };
        let compared = sweep::table(grid, quantities, &results, reference);
        // A table without rows does not replace one that has some.
        if !compared.table.rows.is_empty() {
            let title = first.deck.sources.files().first().map_or("sweep", |f| f.name.as_str());
            let chart = sweep::chart(title, grid, quantities, &results, reference);
            write_results(&job, "sweep", &compared.table, Vec::new(), &[(String::new(), chart)])?;
        }
        if self.json {
            print_json(grid, quantities, &results, &compared)?;
        } else if !self.quiet {
            print_sweep(&compared, &job);
        }
        tell_doubts(&doubts(grid, &results));
        Ok(report_failures(&results))
    }

    /// Runs some of the cases and leaves them for `--gather`. Other parts may be at work in the same folder.
    fn run_part(&self, asked: &PreparedSweep, cases: Range<usize>) -> Result<Status, Box<dyn Error>> {
        let whole = job::default_job(&self.deck, self.out.clone())?;
        job::make_folder(&whole)?;
        let results = self.run(asked, cases.clone(), self.keep.then_some(&whole))?;
        let path = asked.part(&asked.identity()).write(&whole, &cases, &results)?;
        if !self.quiet {
            say!("cases {}-{} of {}: {}", cases.start + 1, cases.end, asked.grid.count(), path.display());
        }
        tell_doubts(&doubts(&asked.grid, &results));
        Ok(report_failures(&results))
    }

    /// Evaluates what Dakota asks for; what fails is said in the results file, as Dakota expects it.
    fn answer_dakota(&self, files: &[PathBuf], quantities: Vec<Quantity>) -> Result<Status, Box<dyn Error>> {
        let [parameters, answers] = files else { return Err("--dakota takes two files".into()) };
        let text = files::read_text(parameters).map_err(|e| format!("{}: {e}", parameters.display()))?;
        let evaluations = dakota::DakotaRequest::read(parameters, &text, &quantities)?;
        let asked = match self.prepare(evaluations.grid(&self.set)?, quantities) {
            Ok(asked) => asked,
            Err(error) => {
                // Dakota waits for a results file also when the evaluation fails.
                output::write_whole(answers, evaluations.failed().as_bytes())?;
                return Err(error);
            }
        };
        let results = self.run(&asked, 0..asked.grid.count(), None)?;
        output::write_whole(answers, evaluations.answer(&results).as_bytes())?;
        tell_doubts(&doubts(&asked.grid, &results));
        report_failures(&results);
        Ok(Status::SUCCESS)
    }
}

impl PreparedSweep {
    /// What makes the sweep the one it is: parts with another do not belong to it.
    fn identity(&self) -> String {
        let user = self.compiled.as_ref().map(Compiled::identity).unwrap_or_default();
        let quantities: Vec<&str> = self.quantities.iter().map(|q| q.text.as_str()).collect();
        let own =
            format!("{:?} {:?} {quantities:?} {}", self.first.identity(&user), self.grid, env!("CARGO_PKG_VERSION"));
        output::checkpoint::hash([own.as_bytes()])
    }

    fn part<'a>(&'a self, sweep: &'a str) -> SweepPart<'a> {
        SweepPart { sweep, grid: &self.grid, quantities: &self.quantities }
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
    compared: &sweep::ComparedTable,
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
    let rms: IndexMap<&str, f64> = compared.rms.iter().map(|(column, rms)| (column.as_str(), *rms)).collect();
    say!("{}", serde_json::to_string_pretty(&serde_json::json!({ "runs": runs, "rms": rms }))?);
    Ok(())
}

fn print_sweep(compared: &sweep::ComparedTable, job: &output::Job) {
    if compared.table.rows.is_empty() {
        return;
    }
    print_table(&compared.table);
    for (column, rms) in &compared.rms {
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
