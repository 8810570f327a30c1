//! The command `revolve sweep`: runs over a grid or table of parameters, also in parts and for Dakota.

use std::collections::BTreeMap;
use std::error::Error;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;

use crate::deck::{Diagnostics, files};
use crate::study::cases::{self, CaseRange, SweepPart};
use crate::study::compare::{Agreement, ReferenceTable};
use crate::study::dakota;
use crate::study::evaluate::DeckSource;
use crate::study::grid::{CaseGrid, json_value};
use crate::study::quantity::{self, Quantity};
use crate::study::sensitivity::{SensitivityRequest, sensitivities};
use crate::study::{StudyError, sweep};
use crate::user::compile::Compiled;
use crate::user::thread_pool;
use crate::{job, output};
use clap::Args;
use indexmap::IndexMap;
use serde::Serialize;

use super::options::{OutputOptions, ResultOptions};
use super::words::{self, print_err, print_out};
use super::{
    CommandStatus, UserFiles, accept, print_run_warnings, progress, report_failures, settings_text, write_results,
};

/// Run a deck over values of its parameters and write one table and one picture.
#[derive(Args)]
pub struct SweepCommand {
    /// Input deck.
    #[arg(value_parser = super::options::deck_parser())]
    deck: PathBuf,
    /// Values of a deck parameter, or of mesh (parts of each edge): NAME=v1,v2,… or NAME=start:stop:step or
    /// NAME=start:stop:#count; several options form a grid.
    #[arg(short, long = "set", value_name = "NAME=VALUES", required_unless_present_any = ["samples", "dakota"])]
    set: Vec<String>,
    /// CSV file with one column per parameter and one row per run (design of experiments). `--set` then gives one value
    /// to each other parameter.
    #[arg(long, value_name = "FILE")]
    samples: Option<PathBuf>,
    /// Number of random cases: `--set NAME=low..high` draws uniformly, `--set "NAME=normal(mean, deviation)"` and
    /// others as in `scatter`; other parameters have one value. A case depends only on its number and the seed.
    #[arg(long, value_name = "N", conflicts_with_all = ["samples", "dakota"])]
    random: Option<usize>,
    /// Seed of the random number generator.
    #[arg(long, value_name = "NUMBER", default_value_t = 0, requires = "random")]
    seed: u64,
    /// Run only some cases and write them as one part: A-B, A, K/N (part K of N), task/N or task, where `task` is the
    /// index in a scheduler array (Slurm, HyperQueue, PBS, Grid Engine, LSF). See --gather.
    #[arg(long, value_name = "CASES", conflicts_with_all = ["dakota", "compare", "json"])]
    cases: Option<String>,
    /// Combine the parts in the result folder into the table of the sweep without running; missing cases are listed.
    #[arg(long, conflicts_with_all = ["cases", "dakota", "keep"])]
    gather: bool,
    /// Continue an interrupted sweep: cases that have finished are not run again.
    #[arg(long, conflicts_with_all = ["cases", "gather", "dakota", "plan"])]
    resume: bool,
    /// Print the list of cases as CSV without running.
    #[arg(long, conflicts_with_all = ["gather", "dakota", "keep", "compare", "json"])]
    plan: bool,
    /// Dakota parameters file and results file (standard or JSON format; one evaluation or a batch). Each `--quantity`
    /// is one response, in order.
    #[arg(long, num_args = 2, value_names = ["PARAMETERS", "RESULTS"], conflicts_with_all = ["samples", "keep", "compare", "json"])]
    dakota: Option<Vec<PathBuf>>,
    /// Keep the summary and histories of each run in a separate folder, `<out>/<deck>_00001` and so on.
    #[arg(long)]
    keep: bool,
    /// Quantity to evaluate: an expression over history columns, for example "-1000*final(U2@REF)"; can be repeated.
    #[arg(long, required = true, allow_hyphen_values = true)]
    quantity: Vec<String>,
    /// CSV file with reference values: the first parameter in the first column, then one column per reference.
    #[arg(long)]
    compare: Option<PathBuf>,
    /// Column of the --samples file with the measured value of each run, which the first quantity predicts: bias, rms,
    /// shares within 10 % and 20 %, and a picture of predicted over measured values.
    #[arg(long, value_name = "NAME", requires = "samples", conflicts_with_all = ["compare", "cases", "plan"])]
    compare_column: Option<String>,
    #[command(flatten)]
    user: UserFiles,
    #[command(flatten)]
    results: ResultOptions,
    #[command(flatten)]
    output: OutputOptions,
}

/// A sweep whose deck and arguments have been checked.
struct PreparedSweep {
    grid: CaseGrid,
    origin: CaseOrigin,
    quantities: Vec<Quantity>,
    compiled: Option<Arc<Compiled>>,
    /// The deck with the values of the first case.
    first: job::PreparedJob,
}

impl SweepCommand {
    pub fn execute(self) -> Result<CommandStatus, Box<dyn Error>> {
        let quantities = self.quantity.iter().map(|q| Quantity::parse(q)).collect::<Result<Vec<_>, _>>()?;
        if let Some(files) = &self.dakota {
            return self.answer_dakota(files, quantities);
        }
        let (mut grid, origin) = self.grid()?;
        let measured = self.compare_column.as_deref().map(|name| measured(&mut grid, name)).transpose()?;
        let cases =
            self.cases.as_deref().map(CaseRange::parse).transpose()?.map(|cases| cases.of(grid.count())).transpose()?;
        if self.plan {
            words::write(format_args!("{}", cases::list(&grid, cases.unwrap_or(0..grid.count()))), false);
            return Ok(CommandStatus::SUCCESS);
        }
        let reference = measured.map_or_else(|| self.reference(&grid), |measured| Ok(Some(measured)))?;
        let prepared = self.prepare(grid, origin, quantities)?;
        match cases {
            Some(cases) => self.run_part(&prepared, cases),
            None => self.run_all(&prepared, reference.as_ref()),
        }
    }

    /// Returns the cases, and the file that gives their values.
    fn grid(&self) -> Result<(CaseGrid, CaseOrigin), Box<dyn Error>> {
        Ok(match (&self.samples, self.random) {
            (Some(path), _) => {
                let text = files::read_text(path).map_err(|e| format!("{}: {e}", path.display()))?;
                let grid = CaseGrid::samples(path, &text, &self.set)?;
                let origin = CaseOrigin::of_file("--samples", path, &grid, self.set.len());
                (grid, origin)
            }
            (None, Some(count)) => (CaseGrid::random(&self.set, count, self.seed)?, CaseOrigin::default()),
            (None, None) => (CaseGrid::parse(&self.set)?, CaseOrigin::default()),
        })
    }

    fn reference(&self, grid: &CaseGrid) -> Result<Option<ReferenceTable>, Box<dyn Error>> {
        let Some(path) = &self.compare else { return Ok(None) };
        let reference = ReferenceTable::read(path)?;
        sweep::comparable(grid, path, &reference)?;
        if reference.is_open {
            print_err!(
                "warning: --compare {}: the last line has no line end; if the file is truncated, its last row is wrong",
                path.display()
            );
        }
        Ok(Some(reference))
    }

    /// Checks deck, user subroutines and quantities with the parameters of the first case.
    fn prepare(
        &self,
        grid: CaseGrid,
        origin: CaseOrigin,
        quantities: Vec<Quantity>,
    ) -> Result<PreparedSweep, Box<dyn Error>> {
        let compiled = self.user.compiled(self.output.is_silent())?;
        let routines = Compiled::open_any(compiled.as_ref())?;
        let compiled = compiled.map(Arc::new);
        let mut first = job::prepare(&self.deck, &grid.combination(0), &routines);
        origin.attribute(&mut first.diagnostics);
        accept(&first.diagnostics, &first.deck.sources, self.output.is_silent())?;
        quantity::check_all(&quantities, &first.plan)?;
        Ok(PreparedSweep { grid, origin, quantities, compiled, first })
    }

    /// Runs the given range of cases on all threads.
    fn run(
        &self,
        prepared: &PreparedSweep,
        cases: Range<usize>,
        kept: Option<&output::JobFiles>,
        listed: Option<&output::JobFiles>,
    ) -> Result<sweep::SweepResults, Box<dyn Error>> {
        let pool = thread_pool(self.results.threads.count()).build().map_err(|e| e.to_string())?;
        let bar = progress::over_runs(cases.len() as u64, self.output.quiet.quiet);
        let PreparedSweep { grid, origin, quantities, compiled, .. } = prepared;
        let identity = prepared.identity();
        let part = prepared.part(&identity);
        let mut known = BTreeMap::new();
        if let Some(job) = listed.filter(|_| self.resume) {
            known = part.finished(job)?;
            bar.inc(known.len() as u64);
        }
        let log = listed.map(|job| part.begin_log(job, &known)).transpose()?;
        let record_case = |index: usize, case: &sweep::CaseResult| {
            log.iter().for_each(|log| log.add(index, case));
            bar.inc(1);
        };
        let open_cases: Vec<usize> = cases.clone().filter(|index| !known.contains_key(index)).collect();
        let run = pool.install(|| {
            sweep::run(&self.deck, (grid, &open_cases), quantities, compiled.as_deref(), kept, &record_case)
        });
        bar.finish_and_clear();
        if let Some(warning) = log.and_then(cases::SweepLog::finish) {
            print_err!("warning: {warning}");
        }
        known.extend(open_cases.into_iter().zip(run));
        let mut results = sweep::SweepResults::default();
        for (index, mut case) in known {
            if let Err(error) = &mut case.values {
                origin.attribute_error(index, error);
            }
            results.push(grid, index, case);
        }
        Ok(results)
    }

    fn run_all(
        &self,
        prepared: &PreparedSweep,
        reference: Option<&ReferenceTable>,
    ) -> Result<CommandStatus, Box<dyn Error>> {
        let PreparedSweep { grid, quantities, first, .. } = prepared;
        let known = grid.names().into_iter().chain(quantities.iter().map(|q| q.text.as_str()));
        let labels = self.results.labels.checked(known)?;
        let (job, _lock) = self.results.lock_job(&self.deck)?;
        let results = if self.gather {
            prepared.part(&prepared.identity()).gather(&job)?
        } else {
            self.run(prepared, 0..grid.count(), self.keep.then_some(&job), Some(&job))?
        };
        let compared = sweep::table(grid, quantities, &results, reference);
        // A table without rows does not overwrite an earlier one.
        if !compared.table.rows.is_empty() {
            let title = first.deck.sources.files().first().map_or("sweep", |f| f.name.as_str());
            let chart = sweep::chart(title, grid, quantities, &results, reference);
            let mut charts = vec![(String::new(), chart)];
            if let Some(measured) = reference.filter(|reference| reference.by_run) {
                let chart = sweep::measured_chart(title, quantities, &results, measured);
                charts.push(("_measured".to_owned(), chart));
            }
            write_results(&job, "sweep", &compared.table, Vec::new(), &charts, &labels)?;
        }
        if !self.gather {
            // The table contains all cases.
            let _ = std::fs::remove_file(job.path(cases::LOG));
        }
        if self.output.json {
            self.output.print_json(&json_object(grid, quantities, &results, &compared))?;
        } else if !self.output.is_silent() {
            print_sweep(&compared, &job);
        }
        Ok(report(grid, &results))
    }

    /// Runs the given range of cases and writes them as a part for `--gather`. Other processes may write parts to the
    /// same folder at the same time, so the folder is not locked.
    fn run_part(&self, prepared: &PreparedSweep, cases: Range<usize>) -> Result<CommandStatus, Box<dyn Error>> {
        let whole = self.results.job(&self.deck)?;
        job::make_folder(&whole)?;
        let results = self.run(prepared, cases.clone(), self.keep.then_some(&whole), None)?;
        let path = prepared.part(&prepared.identity()).write(&whole, &cases, &results)?;
        if !self.output.is_silent() {
            print_out!("cases {}-{} of {}: {}", cases.start + 1, cases.end, prepared.grid.count(), path.display());
        }
        Ok(report(&prepared.grid, &results))
    }

    /// Runs the evaluations that Dakota requests. Failed evaluations are marked in the results file, as Dakota
    /// requires.
    fn answer_dakota(&self, files: &[PathBuf], quantities: Vec<Quantity>) -> Result<CommandStatus, Box<dyn Error>> {
        let [parameters, answers] = files else { return Err("--dakota needs two files".into()) };
        let text = files::read_text(parameters).map_err(|e| format!("{}: {e}", parameters.display()))?;
        let evaluations = dakota::DakotaRequest::read(parameters, &text, &quantities)?;
        let grid = evaluations.grid(&self.set)?;
        let origin = CaseOrigin::of_file("--dakota", parameters, &grid, self.set.len());
        let prepared = match self.prepare(grid, origin, quantities) {
            Ok(prepared) => prepared,
            Err(error) => {
                // Dakota waits for a results file also when the evaluation fails.
                output::write_whole(answers, evaluations.failed().as_bytes())?;
                return Err(error);
            }
        };
        let results = self.run(&prepared, 0..prepared.grid.count(), None, None)?;
        let gradients = self.gradients(&evaluations, &prepared)?;
        output::write_whole(answers, evaluations.answer(&results, &gradients).as_bytes())?;
        report(&prepared.grid, &results);
        Ok(CommandStatus::SUCCESS)
    }
}

impl SweepCommand {
    /// Computes the gradients that Dakota requests. An evaluation with an error has none, as one whose derivatives are
    /// below the noise (R322).
    fn gradients(
        &self,
        evaluations: &dakota::DakotaRequest,
        prepared: &PreparedSweep,
    ) -> Result<Vec<dakota::DakotaGradients>, Box<dyn Error>> {
        let pool = thread_pool(self.results.threads.count()).build().map_err(|e| e.to_string())?;
        let gradient = |(case, names): (usize, Option<Vec<String>>)| {
            let names = names?;
            let request = SensitivityRequest {
                deck: &DeckSource::File(self.deck.clone()),
                settings: &prepared.grid.combination(case),
                user: prepared.compiled.as_ref(),
                quantities: &prepared.quantities,
                names: &names,
                steps: &vec![None; names.len()],
                jitter: None,
                log: None,
                in_increments: false,
                threads: self.results.threads.count(),
                interrupt: &AtomicUsize::new(0),
            };
            match sensitivities(&request, &mut |_| {}) {
                Ok(results) => results.gradients(),
                Err(error) => {
                    print_err!("evaluation {}: no gradient: {error}", case + 1);
                    None
                }
            }
        };
        Ok(pool.install(|| evaluations.gradient_names().into_iter().enumerate().map(gradient).collect()))
    }
}

/// File that gives the values of parameters, for messages on them.
#[derive(Default)]
struct CaseOrigin {
    /// Option and path; empty without a file.
    file: String,
    /// Parameters with values in the file.
    names: Vec<String>,
}

impl CaseOrigin {
    /// Creates the origin of a grid whose last `fixed` parameters are given by `--set`.
    fn of_file(option: &str, path: &Path, grid: &CaseGrid, fixed: usize) -> CaseOrigin {
        let names = grid.names();
        let names = names[..names.len() - fixed].iter().map(|name| (*name).to_owned()).collect();
        CaseOrigin { file: format!("{option} {}", path.display()), names }
    }

    /// Replaces the option `--set` in a message on a value by the file, row (from 1) and column.
    fn place(&self, case: usize, message: &str) -> String {
        let replace = |message: String, name: &String| {
            let location = |end: char| format!("{}, row {}, column {name}: `{name}{end}", self.file, case + 1);
            ['=', '`']
                .into_iter()
                .fold(message, |text, end| text.replace(&format!("`--set {name}{end}"), &location(end)))
        };
        self.names.iter().fold(message.to_owned(), replace)
    }

    /// Names the place of invalid values of the first case.
    fn attribute(&self, diagnostics: &mut Diagnostics) {
        diagnostics.iter_mut().for_each(|found| found.message = self.place(0, &found.message));
    }

    /// Names the place of invalid values of a case.
    fn attribute_error(&self, case: usize, error: &mut StudyError) {
        if let StudyError::Refused { text, .. } = error {
            *text = self.place(case, text);
        }
    }
}

impl PreparedSweep {
    /// Returns a hash of deck, values, quantities, user subroutines and version. Parts with a different hash belong to
    /// a different sweep.
    fn identity(&self) -> String {
        let user = self.compiled.as_deref().map(Compiled::identity).unwrap_or_default();
        let quantities: Vec<&str> = self.quantities.iter().map(|q| q.text.as_str()).collect();
        let description =
            format!("{:?} {:?} {quantities:?} {}", self.first.identity(&user), self.grid, env!("CARGO_PKG_VERSION"));
        output::checkpoint::hash([description.as_bytes()])
    }

    fn part<'a>(&'a self, sweep: &'a str) -> SweepPart<'a> {
        SweepPart { sweep, grid: &self.grid, quantities: &self.quantities }
    }
}

/// Removes the measured values of the samples from the grid.
fn measured(grid: &mut CaseGrid, name: &str) -> Result<ReferenceTable, StudyError> {
    let values = grid.take_column(name)?;
    let first = |axis: &(String, Vec<String>)| axis.1.iter().map(|v| v.parse().unwrap_or(f64::NAN)).collect();
    let first: Vec<f64> = grid.axes().first().map(first).unwrap_or_default();
    Ok(ReferenceTable::of_runs(name, &first, &values))
}

/// A run of a sweep as `--json` prints it.
#[derive(Serialize)]
struct SweepRunRecord<'a> {
    parameters: IndexMap<&'a str, serde_json::Value>,
    #[serde(skip_serializing_if = "Option::is_none")]
    values: Option<IndexMap<&'a str, f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    doubts: &'a [String],
}

fn json_object(
    grid: &CaseGrid,
    quantities: &[Quantity],
    results: &sweep::SweepResults,
    compared: &sweep::ComparedTable,
) -> serde_json::Value {
    let names = grid.names();
    let each_run = results.parameters.iter().zip(&results.values).zip(&results.warnings);
    let runs: Vec<SweepRunRecord<'_>> = each_run
        .map(|((parameters, values), doubts)| SweepRunRecord {
            parameters: names.iter().copied().zip(parameters.iter().map(|text| json_value(text))).collect(),
            values: values
                .as_ref()
                .ok()
                .map(|v| quantities.iter().map(|q| q.text.as_str()).zip(v.iter().copied()).collect()),
            error: values.as_ref().err().map(ToString::to_string),
            doubts,
        })
        .collect();
    let agreement: IndexMap<&str, Agreement> = compared.agreement.iter().map(|(c, a)| (c.as_str(), *a)).collect();
    let rms: IndexMap<&str, f64> = agreement.iter().map(|(column, agreement)| (*column, agreement.rms)).collect();
    serde_json::json!({ "runs": runs, "rms": rms, "agreement": agreement })
}

fn print_sweep(compared: &sweep::ComparedTable, job: &output::JobFiles) {
    if compared.table.rows.is_empty() {
        return;
    }
    words::write(format_args!("{}", compared.table.terminal_excerpt()), false);
    for (column, agreement) in &compared.agreement {
        print_out!("difference from {column}: {}", agreement.text());
    }
    print_out!("table {}, picture {}", job.path("_sweep.csv").display(), job.path("_sweep.png").display());
}

/// Prints the warnings of the runs with their parameters, and the number of runs without a result.
fn report(grid: &CaseGrid, results: &sweep::SweepResults) -> CommandStatus {
    let names = grid.names();
    let runs = results.parameters.iter().zip(&results.warnings);
    let with_settings = runs.map(|(values, doubts)| (settings_text(names.iter().copied().zip(values)), &doubts[..]));
    print_run_warnings(&with_settings.collect::<Vec<_>>());
    let failed: Vec<&StudyError> = results.values.iter().filter_map(|v| v.as_ref().err()).collect();
    report_failures(failed.len(), results.values.len(), "runs", failed.first().copied())
}
