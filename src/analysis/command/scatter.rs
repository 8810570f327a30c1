//! The command `revolve scatter`: Monte Carlo study of quantities.

use std::error::Error;
use std::path::PathBuf;

use crate::study::columns::TableWriter;
use crate::study::inputs::RandomInputs;
use crate::study::quantity::Quantity;
use crate::study::scatter::{self, ScatterRequest, ScatterResults};
use crate::study::statistics::design::SamplingScheme;
use crate::study::statistics::summary::{SampleStatistic, estimate_sorted, sorted};
use crate::study::table::TextTable;
use clap::Args;
use serde_json::{Value, json};

use super::search::{self, NumberFormat, SearchArguments};
use super::{CommandStatus, progress, report_failures, write_results};

/// Monte Carlo study: draw deck parameters from distributions and estimate the statistics and sensitivities of
/// quantities.
#[derive(Args)]
pub struct ScatterCommand {
    #[command(flatten)]
    search: SearchArguments,
    /// Random parameter: NAME=low..high (uniform), NAME=normal(mean, deviation), NAME=lognormal(mean, deviation) or
    /// NAME=truncated(DISTRIBUTION, low, high); can be repeated.
    #[arg(short, long, value_name = "NAME=DISTRIBUTION", required = true)]
    distribution: Vec<String>,
    /// Correlation of two random parameters, between -1 and 1; can be repeated.
    #[arg(long, value_name = "NAME:OTHER=NUMBER")]
    correlation: Vec<String>,
    /// Quantity to evaluate: an expression over history columns, for example "-1000*final(U2@REF)"; can be repeated.
    #[arg(long, required = true, allow_hyphen_values = true)]
    quantity: Vec<String>,
    /// Number of samples.
    #[arg(short, long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(2..=100_000_000))]
    count: u32,
    /// Seed of the random number generator.
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    seed: u64,
    /// Sampling scheme: random, latin (Latin hypercube) or sobol (scrambled Sobol sequence).
    #[arg(long, value_name = "WAY", default_value = "random")]
    sampling: SamplingScheme,
    /// Quantiles to estimate, each between 0 and 1.
    #[arg(long, value_name = "PARTS", value_delimiter = ',', default_value = "0.05,0.5,0.95")]
    quantiles: Vec<f64>,
    /// Estimate first-order and total Sobol indices; this takes N (parameters + 2) runs.
    #[arg(long, conflicts_with = "correlation")]
    indices: bool,
    /// Write all samples with their quantities to a .csv file, or to a .parquet file if the program has the feature
    /// `parquet`.
    #[arg(long, value_name = "FILE")]
    table: Option<PathBuf>,
}

impl ScatterCommand {
    pub fn execute(self) -> Result<CommandStatus, Box<dyn Error>> {
        let inputs = RandomInputs::parse(&self.distribution, &self.correlation)?;
        let quantities = self.quantity.iter().map(|q| Quantity::parse(q)).collect::<Result<Vec<_>, _>>()?;
        if let Some(part) = self.quantiles.iter().find(|part| !(0.0..=1.0).contains(*part)) {
            return Err(format!("--quantiles {part}: expected numbers between 0 and 1").into());
        }
        let known: Vec<String> = inputs.names.iter().chain(&self.quantity).cloned().collect();
        let labels = self.search.results.labels.checked(known.clone())?;
        let routines = self.search.routines()?;
        let evaluator = self.search.evaluator(inputs.names.clone(), quantities, &routines)?;
        let (job, _lock) = self.search.job()?;
        let log = self.search.resume.log(&job)?;
        let evaluator = evaluator.logged(&log)?;
        let request = ScatterRequest {
            sampling: self.sampling,
            count: self.count as usize,
            seed: self.seed,
            indices: self.indices,
            threads: self.search.threads(),
        };
        let mut table = self.table.as_deref().map(|path| TableWriter::begin(path, known)).transpose()?;
        let runs = request.count * request.runs(&inputs);
        let bar = progress::over_runs(runs as u64, self.search.is_silent());
        let mut keep = |rows: &[f64]| table.as_mut().map_or(Ok(()), |table| table.append(rows));
        let results = scatter::run(&evaluator, &inputs, self.quantity.len(), request, &mut keep, &mut |n| {
            bar.set_position(n as u64)
        })?;
        bar.finish_and_clear();
        table.map_or(Ok(()), TableWriter::finish)?;
        if results.failed < runs {
            let exact = self.table(&inputs, &results, NumberFormat::Exact);
            let object = self.json(&exact, runs, &results);
            let others = vec![search::json_file("scatter", &object)?];
            write_results(&job, "scatter", &exact, others, &self.charts(&job.name, &results), &labels)?;
            self.search.end_log(&log);
            self.search.print(&self.table(&inputs, &results, NumberFormat::Rounded), &self.lines(runs, &job));
            self.search.output.print_json(&object)?;
        }
        search::warn_still_moving(evaluator.still_moving());
        Ok(report_failures(results.failed, runs, "runs", results.reason.as_ref()))
    }

    /// Returns a table with one row per quantity and statistic or Sobol index.
    fn table(&self, inputs: &RandomInputs, results: &ScatterResults, format: NumberFormat) -> TextTable {
        let mut rows = Vec::new();
        let mut statistics =
            vec![("mean".to_owned(), SampleStatistic::Mean), ("standard deviation".into(), SampleStatistic::Deviation)];
        statistics
            .extend(self.quantiles.iter().map(|part| (format!("quantile {part}"), SampleStatistic::Quantile(*part))));
        for (of, (quantity, values)) in self.quantity.iter().zip(&results.values).enumerate() {
            let mut row = |what: &str, found| {
                rows.push([quantity.clone(), what.to_owned()].into_iter().chain(format.cells(found)).collect());
            };
            let sorted = sorted(values);
            for (what, statistic) in &statistics {
                if let Some(found) = estimate_sorted(values, &sorted, &results.sets, *statistic) {
                    row(what, found);
                }
            }
            let Some(Some(indices)) = results.indices.get(of) else { continue };
            for (name, (first, total)) in inputs.names.iter().zip(indices.first.iter().zip(&indices.total)) {
                row(&format!("first order of {name}"), *first);
                row(&format!("total of {name}"), *total);
            }
        }
        let header = ["quantity".to_owned()].into_iter().chain(search::header("what")).collect();
        TextTable { header, rows }
    }

    fn charts(&self, name: &str, results: &ScatterResults) -> Vec<(String, crate::study::chart::Chart)> {
        let ending = |i: usize| if i == 0 { String::new() } else { format!("_{}", i + 1) };
        let each = self.quantity.iter().zip(&results.values).enumerate();
        each.map(|(i, (quantity, values))| (ending(i), scatter::chart(name, quantity, values))).collect()
    }

    fn lines(&self, runs: usize, job: &crate::output::JobFiles) -> Vec<String> {
        let table = self.table.as_ref().map_or(String::new(), |path| format!(", samples {}", path.display()));
        let (csv, png) = (job.path("_scatter.csv"), job.path("_scatter.png"));
        vec![format!("{} samples, {runs} runs; table {}, picture {}{table}", self.count, csv.display(), png.display())]
    }

    fn json(&self, table: &TextTable, runs: usize, results: &ScatterResults) -> Value {
        let number = |text: &String| text.parse::<f64>().map_or(Value::Null, |v| json!(v));
        let rows: Vec<Value> = table
            .rows
            .iter()
            .map(|r| json!({ "quantity": r[0], "what": r[1], "value": number(&r[2]), "low": number(&r[3]), "high": number(&r[4]) }))
            .collect();
        json!({ "samples": self.count, "runs": runs, "failed": results.failed, "seed": self.seed, "estimates": rows })
    }
}
