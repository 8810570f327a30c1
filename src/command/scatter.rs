//! `revolve scatter`.

use std::error::Error;
use std::path::PathBuf;

use crate::study::columns::TableWriter;
use crate::study::inputs::RandomInputs;
use crate::study::quantity::Quantity;
use crate::study::scatter::{self, ScatterRequest, ScatterResults};
use crate::study::statistics::design::Sampling;
use crate::study::statistics::summary::{Statistic, estimate};
use crate::study::table::Table;
use clap::Args;
use serde_json::{Value, json};

use super::search::{self, SearchArguments};
use super::{HALTED, Status, progress, write_results};

/// Draw parameters of a deck from distributions: how its quantities scatter, and what that comes from.
#[derive(Args)]
pub struct Scatter {
    #[command(flatten)]
    search: SearchArguments,
    /// NAME=low..high, NAME=normal(mean, deviation), NAME=lognormal(mean, deviation), NAME=truncated(DISTRIBUTION, low, high).
    #[arg(short, long, value_name = "NAME=DISTRIBUTION", required = true)]
    distribution: Vec<String>,
    /// How two parameters go together: NAME:OTHER=NUMBER between -1 and 1.
    #[arg(long, value_name = "NAME:OTHER=NUMBER")]
    correlation: Vec<String>,
    /// Expression over history columns, such as "-1000*final(U2@REF)"; may be given several times.
    #[arg(long, required = true, allow_hyphen_values = true)]
    quantity: Vec<String>,
    /// How many samples.
    #[arg(short, long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(2..=100_000_000))]
    count: u32,
    /// Seed of the samples.
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    seed: u64,
    /// How samples are spread: random, latin (Latin hypercubes) or sobol (Sobol's sequence, scrambled).
    #[arg(long, value_name = "WAY", default_value = "random")]
    sampling: Sampling,
    /// Quantiles to be found, each between 0 and 1.
    #[arg(long, value_name = "PARTS", value_delimiter = ',', default_value = "0.05,0.5,0.95")]
    quantiles: Vec<f64>,
    /// Sobol's indices, of the first order and total: N runs for each parameter and two times N more.
    #[arg(long, conflicts_with = "correlation")]
    indices: bool,
    /// File for all samples with their quantities: .csv, or .parquet in a program with that feature.
    #[arg(long, value_name = "FILE")]
    table: Option<PathBuf>,
}

impl Scatter {
    pub fn execute(self) -> Result<Status, Box<dyn Error>> {
        let inputs = RandomInputs::parse(&self.distribution, &self.correlation)?;
        let quantities = self.quantity.iter().map(|q| Quantity::parse(q)).collect::<Result<Vec<_>, _>>()?;
        if let Some(part) = self.quantiles.iter().find(|part| !(0.0..=1.0).contains(*part)) {
            return Err(format!("--quantiles {part}: between 0 and 1").into());
        }
        let routines = self.search.routines()?;
        let evaluator = self.search.evaluator(inputs.names.clone(), quantities, &routines)?;
        let (job, _lock) = self.search.job()?;
        let asked = ScatterRequest {
            sampling: self.sampling,
            count: self.count as usize,
            seed: self.seed,
            indices: self.indices,
            threads: self.search.threads(),
        };
        let names = inputs.names.iter().chain(&self.quantity).cloned().collect();
        let mut table = self.table.as_deref().map(|path| TableWriter::begin(path, names)).transpose()?;
        let runs = asked.count * asked.runs(&inputs);
        let bar = progress::over_runs(runs as u64, self.search.is_silent());
        let mut keep = |rows: &[f64]| table.as_mut().map_or(Ok(()), |table| table.append(rows));
        let results = scatter::run(&evaluator, &inputs, self.quantity.len(), asked, &mut keep, &mut |n| {
            bar.set_position(n as u64)
        })?;
        bar.finish_and_clear();
        table.map_or(Ok(()), TableWriter::finish)?;
        let table = self.table(&inputs, &results);
        if results.failed < runs {
            write_results(&job, "scatter", &table, Vec::new(), &self.charts(&job.name, &results))?;
            self.search.print(&table, &self.lines(runs, &job));
            self.search.print_json(&self.json(&table, runs, &results))?;
        }
        search::tell_still_moving(&evaluator);
        search::tell_failures(results.failed, runs, results.reason.as_ref());
        Ok(if results.failed == 0 { Status::SUCCESS } else { Status::from(HALTED) })
    }

    /// A row for each statistic and index of each quantity.
    fn table(&self, inputs: &RandomInputs, results: &ScatterResults) -> Table {
        let mut rows = Vec::new();
        let mut statistics =
            vec![("mean".to_owned(), Statistic::Mean), ("standard deviation".into(), Statistic::Deviation)];
        statistics.extend(self.quantiles.iter().map(|part| (format!("quantile {part}"), Statistic::Quantile(*part))));
        for (of, (quantity, values)) in self.quantity.iter().zip(&results.values).enumerate() {
            let mut row = |what: &str, found| {
                rows.push([quantity.clone(), what.to_owned()].into_iter().chain(search::cells(found)).collect());
            };
            for (what, statistic) in &statistics {
                if let Some(found) = estimate(values, &results.sets, *statistic) {
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
        Table { header, rows }
    }

    fn charts(&self, name: &str, results: &ScatterResults) -> Vec<(String, crate::study::chart::Chart)> {
        let ending = |i: usize| if i == 0 { String::new() } else { format!("_{}", i + 1) };
        let each = self.quantity.iter().zip(&results.values).enumerate();
        each.map(|(i, (quantity, values))| (ending(i), scatter::chart(name, quantity, values))).collect()
    }

    fn lines(&self, runs: usize, job: &crate::output::Job) -> Vec<String> {
        let table = self.table.as_ref().map_or(String::new(), |path| format!(", samples {}", path.display()));
        let (csv, png) = (job.path("_scatter.csv"), job.path("_scatter.png"));
        vec![format!("{} samples, {runs} runs; table {}, picture {}{table}", self.count, csv.display(), png.display())]
    }

    fn json(&self, table: &Table, runs: usize, results: &ScatterResults) -> Value {
        let number = |text: &String| text.parse::<f64>().map_or(Value::Null, |v| json!(v));
        let rows: Vec<Value> = table
            .rows
            .iter()
            .map(|r| json!({ "quantity": r[0], "what": r[1], "value": number(&r[2]), "low": number(&r[3]), "high": number(&r[4]) }))
            .collect();
        json!({ "samples": self.count, "runs": runs, "failed": results.failed, "seed": self.seed, "estimates": rows })
    }
}
