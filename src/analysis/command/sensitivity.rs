//! The command `revolve sensitivity`: derivatives of quantities by deck parameters.

use std::error::Error;
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;

use crate::job::ParameterOverrides;
use crate::study::chart::{Chart, ChartSeries, SeriesForm};
use crate::study::evaluate::DeckSource;
use crate::study::log::RunLog;
use crate::study::quantity::Quantity;
use crate::study::sensitivity::{
    QuantitySensitivities, Sensitivity, SensitivityRequest, SensitivityResults, sensitivities,
};
use crate::study::table::{TextTable, short};
use clap::Args;
use serde_json::json;

use super::search::{self, CompiledRoutines, NumberFormat, SearchArguments};
use super::words::print_err;
use super::{CommandStatus, progress, write_results};

/// Derivatives of quantities by deck parameters, with their numerical uncertainty: exact for rigid shots by stages, from
/// companion runs with changed parameters otherwise.
#[derive(Args)]
pub struct SensitivityCommand {
    #[command(flatten)]
    search: SearchArguments,
    /// Quantity to differentiate: an expression over history columns, for example "-1000*final(U2@REF)"; can be repeated.
    #[arg(long = "of", value_name = "EXPR", required = true, allow_hyphen_values = true)]
    quantity: Vec<String>,
    /// Parameters of the deck, separated by commas.
    #[arg(long = "to", value_name = "NAME,…", required = true, value_delimiter = ',')]
    parameters: Vec<String>,
    /// Largest change of a parameter in companion runs, in its unit (default: 4 % of its value, then 1 % and 12 % until
    /// the uncertainty is below 1 %); can be repeated.
    #[arg(long, value_name = "NAME=NUMBER")]
    step: Vec<String>,
    /// Number of runs with small perturbations of initial velocities and nodal coordinates, from which the noise follows
    /// (default: 8 runs if the deck has contact, failure, element deletion or new meshes; 0 omits them).
    #[arg(long, value_name = "N")]
    jitter: Option<u16>,
    /// Repeat all runs with a coarser mesh, given by a parameter or by mesh, and print how much the derivatives change: for
    /// example mesh=1/2 or k=2.
    #[arg(long, value_name = "NAME=VALUE")]
    coarser: Option<String>,
}

impl SensitivityCommand {
    pub fn execute(self) -> Result<CommandStatus, Box<dyn Error>> {
        self.check_names()?;
        let quantities = self.quantity.iter().map(|text| Quantity::parse(text)).collect::<Result<Vec<_>, _>>()?;
        let labels = self.search.results.labels.checked(self.parameters.iter().chain(&self.quantity))?;
        let routines = self.search.routines()?;
        let settings = self.search.settings()?;
        let coarse_settings = self.coarse_settings(&settings)?;
        let (job, _lock) = self.search.job()?;
        let log = self.search.resume.log(&job)?;
        let mut results = self.differentiated(&quantities, &settings, &routines, &log)?;
        if let Some(settings) = coarse_settings {
            results.compare_with(&self.differentiated(&quantities, &settings, &routines, &log)?);
        }
        let object = json!(results);
        let others = vec![search::json_file("sensitivity", &object)?];
        let charts = charts(&job.name, &results);
        write_results(&job, "sensitivity", &table(&results, NumberFormat::Exact), others, &charts, &labels)?;
        self.search.end_log(&log);
        let lines = [format!("{} runs; table {}", results.runs, job.path("_sensitivity.csv").display())];
        self.search.print(&table(&results, NumberFormat::Rounded), &lines);
        self.search.output.print_json(&object)?;
        search::warn_still_moving(results.still_moving);
        warn(&results);
        Ok(CommandStatus::of(results.is_complete()))
    }

    /// Returns an error if a parameter is given twice.
    fn check_names(&self) -> Result<(), String> {
        let is_repeated = |(index, name): &(usize, &String)| self.parameters[..*index].contains(name);
        let repeated = self.parameters.iter().enumerate().find(is_repeated);
        repeated.map_or(Ok(()), |(_, name)| Err(format!("--to {name}: the parameter is given twice")))
    }

    /// Returns the settings of a coarser mesh; `None` without `--coarser`.
    fn coarse_settings(&self, settings: &ParameterOverrides) -> Result<Option<Vec<(String, String)>>, String> {
        let Some(text) = &self.coarser else { return Ok(None) };
        let wrong = |why: &str| format!("--coarser {text}: {why}, for example mesh=1/2");
        let (name, value) = text.split_once('=').ok_or_else(|| wrong("expected NAME=VALUE"))?;
        let (name, value) = (name.trim(), value.trim());
        if self.parameters.iter().any(|parameter| parameter == name) {
            return Err(wrong("--to has the same parameter; expected a parameter of the mesh"));
        }
        let others = settings.iter().filter(|(other, _)| other != name).cloned();
        Ok(Some(others.chain([(name.to_owned(), value.to_owned())]).collect()))
    }

    /// Runs the companion runs.
    fn differentiated(
        &self,
        quantities: &[Quantity],
        settings: &ParameterOverrides,
        routines: &CompiledRoutines,
        log: &Arc<RunLog>,
    ) -> Result<SensitivityResults, Box<dyn Error>> {
        let request = SensitivityRequest {
            deck: &DeckSource::File(self.search.deck().to_owned()),
            settings,
            user: routines.as_ref(),
            quantities,
            names: &self.parameters,
            steps: &self.steps()?,
            jitter: self.jitter.map(usize::from),
            log: Some(log),
            in_increments: self.search.in_increments,
            threads: self.search.threads(),
            interrupt: &AtomicUsize::new(0),
        };
        let bar = progress::over_runs(request.expected_runs() as u64, self.search.is_silent());
        let results = sensitivities(&request, &mut |runs| bar.set_position(runs as u64));
        bar.finish_and_clear();
        Ok(results?)
    }

    /// Parses the largest change of each parameter.
    fn steps(&self) -> Result<Vec<Option<f64>>, String> {
        let mut steps = vec![None; self.parameters.len()];
        for text in &self.step {
            let wrong = |why: &str| format!("--step {text}: {why}, for example --step V=5");
            let (name, number) = text.split_once('=').ok_or_else(|| wrong("expected NAME=NUMBER"))?;
            let index = self.parameters.iter().position(|other| other == name.trim());
            let index = index.ok_or_else(|| wrong("expected a parameter of --to"))?;
            steps[index] = Some(number.trim().parse().map_err(|_| wrong("expected a number"))?);
        }
        Ok(steps)
    }
}

/// Prints a warning for each parameter without a derivative.
fn warn(results: &SensitivityResults) {
    for QuantitySensitivities { quantity, parameters, .. } in &results.quantities {
        for reason in parameters.iter().filter_map(|of| of.reason.as_ref()) {
            print_err!("warning: R322: {quantity}: {reason}");
        }
    }
}

/// Returns a table with one row per quantity and parameter.
fn table(results: &SensitivityResults, format: NumberFormat) -> TextTable {
    let number = |value: Option<f64>| value.map_or("-".to_owned(), |value| format.text(value));
    let error = |value: f64| if format == NumberFormat::Exact { format.text(value) } else { short(value) };
    let has_mesh = results.quantities.iter().flat_map(|of| &of.parameters).any(|of| of.mesh.is_some());
    let row = |of: &QuantitySensitivities, parameter: &Sensitivity| {
        let Sensitivity { derivative, logarithmic, relative, method, .. } = parameter;
        let mut cells = vec![
            of.quantity.clone(),
            format.text(of.value),
            parameter.parameter.clone(),
            format.text(parameter.at),
            number(derivative.map(|of| of.value)),
            derivative.map_or("-".to_owned(), |of| error(of.uncertainty)),
            number(logarithmic.map(|of| of.value)),
            logarithmic.map_or("-".to_owned(), |of| error(of.uncertainty)),
            number(*relative),
        ];
        if has_mesh {
            cells.push(parameter.mesh.map_or("-".to_owned(), error));
        }
        cells.push(method.words().to_owned());
        cells
    };
    let rows = results.quantities.iter().flat_map(|of| of.parameters.iter().map(move |parameter| row(of, parameter)));
    let mut header: Vec<&str> =
        vec!["quantity", "Q", "parameter", "p", "dQ/dp", "±", "dQ/d ln p", "±", "d ln Q/d ln p"];
    header.extend(has_mesh.then_some("mesh"));
    header.push("method");
    TextTable { header: header.into_iter().map(str::to_owned).collect(), rows: rows.collect() }
}

/// Returns the charts of all quantities: results of the companion runs, and tangents, over relative changes of the
/// parameters.
fn charts(title: &str, results: &SensitivityResults) -> Vec<(String, Chart)> {
    let ending = |i: usize| if i == 0 { String::new() } else { format!("_{}", i + 1) };
    let chart = |of: &QuantitySensitivities| {
        let series = of.parameters.iter().flat_map(|parameter| series(of.value, parameter)).collect();
        Chart::new(title, ["change of the parameter, %", &of.quantity], series)
    };
    results.quantities.iter().enumerate().map(|(i, of)| (ending(i), chart(of))).collect()
}

/// Returns the tangent and the companion runs of a parameter over its relative changes; over changes in its unit if it is
/// zero.
fn series(value: f64, parameter: &Sensitivity) -> Vec<ChartSeries> {
    let Sensitivity { parameter: name, at, derivative, points, .. } = parameter;
    let unit = if *at == 0.0 { 1.0 } else { 0.01 * at };
    let mut runs: Vec<(f64, f64)> = points.iter().map(|[p, result]| ((p - at) / unit, *result)).collect();
    runs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let largest = runs.iter().map(|run| run.0.abs()).fold(0.0, f64::max);
    let range = if largest > 0.0 { largest } else { 1.0 };
    let tangent = |slope: f64| [-range, range].map(|change| (change, value + slope * unit * change)).to_vec();
    let tangent = derivative.map(|of| ChartSeries::new(name.as_str(), SeriesForm::Line, tangent(of.value)));
    let runs = Some(runs).filter(|runs| !runs.is_empty());
    let runs = runs.map(|runs| ChartSeries::new(format!("{name}, runs"), SeriesForm::Marks, runs));
    tangent.into_iter().chain(runs).collect()
}
