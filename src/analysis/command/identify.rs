//! The command `revolve identify`: identification of deck parameters from measurements.

use std::error::Error;
use std::path::PathBuf;

use crate::deck::files;
use crate::output::{JobFiles, csv};
use crate::report::QuantityLabels;
use crate::study::identify::data::{MeasuredData, SeriesRequest};
use crate::study::identify::figures::{corner_plot, prediction_chart};
use crate::study::identify::posterior::{Posterior, PosteriorRequest, posterior};
use crate::study::identify::{self, FitResults, IdentificationProblem, UnknownParameter};
use crate::study::statistics::IntervalEstimate;
use crate::study::statistics::least_squares::ParameterFit;
use crate::study::table::{TextTable, number, short};
use clap::Args;
use serde_json::json;

use super::search::{self, NumberFormat, SearchArguments};
use super::{CommandStatus, ResultFile, progress, write_results};

/// Largest number of posterior draws that are written.
const WRITTEN_DRAWS: usize = 4000;

/// Identify deck parameters from measured shots and curves: least squares with 95 % confidence intervals, and on request
/// the posterior distribution.
#[derive(Args)]
pub struct IdentifyCommand {
    #[command(flatten)]
    search: SearchArguments,
    /// CSV file with one row per shot: a column for each known deck parameter, and the measured values.
    #[arg(long, value_name = "FILE")]
    shots: PathBuf,
    /// Column of a measured value; can be repeated, each with its --quantity.
    #[arg(long, value_name = "COLUMN")]
    measured: Vec<String>,
    /// Standard deviation of the measurements: a column or a number. One for each --measured, in the same order, and one
    /// more for each --curve without a third column. Default: equal weights.
    #[arg(long, value_name = "COLUMN|NUMBER")]
    deviation: Vec<String>,
    /// Computed counterpart of a measured value: an expression over history columns, for example
    /// "-1000*final(U2@REF)"; one for each --measured, in the same order.
    #[arg(long, allow_hyphen_values = true, value_name = "EXPR")]
    quantity: Vec<String>,
    /// Column that names CSV files of curves, and their computed counterpart, in which {x} is replaced by the abscissa, for
    /// example "curve=at(V2@REAR, {x}*1e-6)" or "profile=1000*outline({x}/1000)". The files have a header and the columns
    /// abscissa, measured value and optionally its standard deviation. Can be repeated.
    #[arg(long, value_name = "COLUMN=EXPR")]
    curve: Vec<String>,
    /// Parameter to identify and its initial value or bounds; can be repeated or given as a list separated by commas.
    /// With bounds the fit starts in their middle.
    #[arg(long, value_name = "NAME=START|LOW..HIGH", value_delimiter = ',', required = true)]
    unknown: Vec<String>,
    /// Number of fits from different initial values: the given ones, then random ones within the bounds.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    starts: u32,
    /// Compute the posterior distribution until each parameter has this effective sample size (default: 1000). Writes
    /// draws, prediction bands and a corner plot.
    #[arg(long, value_name = "N", num_args = 0..=1, default_missing_value = "1000", value_parser = clap::value_parser!(u32).range(100..=1_000_000))]
    posterior: Option<u32>,
    /// Add an unknown error of the model to the standard deviations of the measurements (with --posterior).
    #[arg(long, requires = "posterior")]
    model_error: bool,
    /// Largest number of runs of --posterior.
    #[arg(long, value_name = "N", default_value_t = 2_000_000, requires = "posterior")]
    most_runs: usize,
    /// Seed of the random numbers of --posterior.
    #[arg(long, value_name = "NUMBER", default_value_t = 0, requires = "posterior")]
    seed: u64,
}

struct IdentificationResults<'a> {
    data: &'a MeasuredData,
    names: Vec<String>,
    fits: FitResults,
    posterior: Option<Posterior>,
}

impl IdentifyCommand {
    pub fn execute(self) -> Result<CommandStatus, Box<dyn Error>> {
        let unknowns = self.unknowns()?;
        let names: Vec<String> = unknowns.iter().map(|unknown| unknown.name.clone()).collect();
        let text = files::read_text(&self.shots).map_err(|e| format!("--shots {}: {e}", self.shots.display()))?;
        let data = MeasuredData::parse(&self.shots, &text, &self.requests()?)?;
        if let Some(name) = names.iter().find(|name| data.names.contains(name)) {
            return Err(format!(
                "--unknown {name}: it is also a column of {}; remove the option or the column",
                self.shots.display()
            )
            .into());
        }
        let routines = self.search.routines()?;
        let parameters: Vec<String> = data.names.iter().chain(&names).cloned().collect();
        let labels = self.search.results.labels.checked(parameters.iter().chain(&data.series))?;
        let evaluator = self.search.evaluator(parameters, data.parsed_quantities()?, &routines)?;
        let (job, _lock) = self.search.job()?;
        let log = self.search.resume.log(&job)?;
        let problem = IdentificationProblem::new(evaluator.logged(&log)?, &data, &unknowns, self.search.threads());
        let fits = problem.fit(self.starts as usize)?;
        let posterior = self.posterior.map(|effective| self.sample(&problem, &fits.best, effective)).transpose()?;
        let results = IdentificationResults { data: &data, names, fits, posterior };
        let object = results.json();
        results.write(&job, &object, &labels)?;
        self.search.end_log(&log);
        let lines = self.lines(&results, &job);
        self.search.print(&results.table(NumberFormat::Rounded), &lines);
        self.search.output.print_json(&object)?;
        search::warn_still_moving(problem.evaluator().still_moving());
        Ok(CommandStatus::of(results.converged()))
    }

    fn sample(
        &self,
        problem: &IdentificationProblem<'_>,
        fit: &ParameterFit,
        effective: u32,
    ) -> Result<Posterior, Box<dyn Error>> {
        let bar = progress::over_runs(self.most_runs as u64, self.search.is_silent());
        let request = PosteriorRequest {
            effective: f64::from(effective),
            most_runs: self.most_runs,
            seed: self.seed,
            model_error: self.model_error,
        };
        let posterior = posterior(problem, fit, request, &|runs| bar.set_position(runs as u64))?;
        bar.finish_and_clear();
        Ok(posterior)
    }

    fn unknowns(&self) -> Result<Vec<UnknownParameter>, String> {
        let mut unknowns: Vec<UnknownParameter> = Vec::new();
        for text in &self.unknown {
            let wrong =
                || format!("--unknown {text}: expected NAME=NUMBER or NAME=LOW..HIGH, for example A=4.5 or A=1..9");
            let (name, value) = text.split_once('=').ok_or_else(wrong)?;
            let number = |text: &str| text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
            let (start, bounds) = match value.split_once("..") {
                None => (number(value).ok_or_else(wrong)?, None),
                Some((low, high)) => {
                    let bounds = number(low).zip(number(high)).filter(|(low, high)| low < high);
                    let (low, high) = bounds.ok_or_else(wrong)?;
                    (0.5 * (low + high), Some([low, high]))
                }
            };
            let name = name.trim().to_owned();
            if unknowns.iter().any(|known| known.name == name) {
                return Err(format!("--unknown {name} is given twice"));
            }
            unknowns.push(UnknownParameter { name, start, bounds });
        }
        Ok(unknowns)
    }

    /// Returns the requested series: scalars, then curves.
    fn requests(&self) -> Result<Vec<SeriesRequest>, String> {
        let (measured, quantities) = (self.measured.len(), self.quantity.len());
        if measured != quantities {
            return Err(format!(
                "{measured} options --measured and {quantities} options --quantity: each needs the other"
            ));
        }
        if measured + self.curve.len() == 0 {
            return Err("no measured values: give --measured with --quantity, or --curve".into());
        }
        if self.deviation.len() > measured + self.curve.len()
            || (!self.deviation.is_empty() && self.deviation.len() < measured)
        {
            let deviations = self.deviation.len();
            return Err(format!(
                "{deviations} options --deviation for {measured} options --measured and {} options --curve: give one for each",
                self.curve.len()
            ));
        }
        let scalars = self.measured.iter().cloned().zip(self.quantity.iter().cloned()).map(|pair| Ok((pair, false)));
        let curves = self.curve.iter().map(|text| {
            let parts = text.split_once('=').filter(|parts| parts.1.contains("{x}"));
            let parts = parts.ok_or(format!("--curve {text}: expected COLUMN=EXPR with {{x}} for the abscissa"))?;
            Ok(((parts.0.trim().to_owned(), parts.1.to_owned()), true))
        });
        let series = scalars.chain(curves).enumerate().map(|(i, request)| {
            request.map(|((column, quantity), is_curve)| SeriesRequest {
                column,
                quantity,
                is_curve,
                deviation: self.deviation.get(i).cloned(),
            })
        });
        series.collect()
    }

    fn lines(&self, results: &IdentificationResults<'_>, job: &JobFiles) -> Vec<String> {
        let fit = &results.fits.best;
        let known = results.data.has_deviations.iter().all(|has| *has);
        let unit = if known { "standard deviations" } else { "units of the quantity" };
        let mut lines = vec![format!(
            "{} shots, {} measured values, {} degrees of freedom; standard deviation of a residual {} {unit}",
            results.data.shots.len(),
            results.data.observations.len(),
            fit.freedom,
            number(fit.deviation())
        )];
        lines.extend(results.sentences());
        let (csv, png) = (job.path("_identify.csv"), job.path("_identify.png"));
        lines.push(format!("table {}, picture {}", csv.display(), png.display()));
        if results.posterior.is_some() {
            let (draws, corner) = (job.path("_identify_posterior.csv"), job.path("_identify_corner.png"));
            lines.push(format!("draws {}, corner plot {}", draws.display(), corner.display()));
        }
        lines
    }
}

impl IdentificationResults<'_> {
    fn converged(&self) -> bool {
        self.fits.best.converged && self.posterior.as_ref().is_none_or(|posterior| posterior.converged)
    }

    /// Returns the computed counterparts of all observations with the fitted parameters.
    fn computed(&self) -> Vec<f64> {
        let observations = self.data.observations.iter().zip(&self.fits.best.residuals);
        observations.map(|(o, residual)| o.value + residual * o.deviation).collect()
    }

    /// Returns remarks on the fit and the posterior.
    fn sentences(&self) -> Vec<String> {
        let mut sentences = identify::sentences(&self.fits.best, &self.names);
        if self.fits.starts > 1 {
            let next = self.fits.next.map_or(String::new(), |ratio| {
                format!("; the next minimum has {} times its sum of squares", short(ratio))
            });
            sentences.push(format!("{} of {} fits ended in the best minimum{next}", self.fits.same, self.fits.starts));
        }
        if let Some(posterior) = &self.posterior {
            let (worst, least) = (posterior.worst_r_hat(), posterior.least_effective());
            sentences.push(format!(
                "posterior: {} runs, {:.0} % of moves accepted, R-hat at most {worst:.4}, effective sample size at least {least:.0}",
                posterior.runs,
                100.0 * posterior.acceptance
            ));
            if !posterior.converged {
                let cure = "increase --most-runs, or give bounds to parameters that the data do not determine";
                sentences.push(format!("the posterior did not converge (R-hat below 1.01): {cure}"));
            }
        }
        sentences
    }

    /// Returns the table of the parameters with their confidence intervals, posterior and correlations.
    fn table(&self, format: NumberFormat) -> TextTable {
        let fit = &self.fits.best;
        let mut header = search::header("parameter");
        header.extend(self.names.iter().map(|name| format!("correlation with {name}")));
        let correlations = |i| (0..self.names.len()).map(move |j| fit.correlation(i, j));
        let digits = |r: f64| if format == NumberFormat::Exact { format.text(r) } else { format!("{r:.4}") };
        let with = |r: Option<f64>| r.map_or("-".to_owned(), digits);
        let row = |(i, estimate): (usize, IntervalEstimate)| {
            let cells = [self.names[i].clone()].into_iter().chain(format.cells(estimate));
            cells.chain(correlations(i).map(with)).collect::<Vec<String>>()
        };
        let mut rows: Vec<Vec<String>> = fit.estimates().into_iter().enumerate().map(row).collect();
        if let Some(posterior) = &self.posterior {
            let absent = vec!["-".to_owned(); self.names.len()];
            for (name, estimate) in posterior.names.iter().zip(posterior.estimates()) {
                let cells = [format!("{name}, posterior")].into_iter().chain(format.cells(estimate));
                rows.push(cells.chain(absent.iter().cloned()).collect());
            }
        }
        TextTable { header, rows }
    }

    /// Writes the tables, the JSON object and the charts.
    fn write(&self, job: &JobFiles, object: &serde_json::Value, labels: &QuantityLabels) -> Result<(), Box<dyn Error>> {
        let computed = self.computed();
        let band = self.posterior.as_ref().map_or(&[][..], |posterior| &posterior.predictions[..]);
        let ending = |i: usize| if i == 0 { String::new() } else { format!("_{}", i + 1) };
        let series = 0..self.data.series.len();
        let charts: Vec<_> =
            series.map(|i| (ending(i), prediction_chart(self.data, &job.name, i, &computed, band))).collect();
        let mut others: Vec<ResultFile> = vec![
            search::json_file("identify", object)?,
            ("_identify_values.csv".into(), self.values(&computed).into_bytes()),
        ];
        if let Some(posterior) = &self.posterior {
            let plot = corner_plot(posterior);
            others.push(("_identify_posterior.csv".into(), draws(posterior).into_bytes()));
            others.push(("_identify_corner.svg".into(), plot.svg().into_bytes()));
            others.push(("_identify_corner.png".into(), plot.png()?));
        }
        write_results(job, "identify", &self.table(NumberFormat::Exact), others, &charts, labels)
    }

    /// Returns a CSV table of the measured and the computed values.
    fn values(&self, computed: &[f64]) -> String {
        let mut header = vec!["shot", "series", "x", "measured", "deviation", "computed"];
        if self.posterior.is_some() {
            header.extend(["95 % from", "to"]);
        }
        let mut text = csv::line(header);
        for (i, (o, computed)) in self.data.observations.iter().zip(computed).enumerate() {
            let x = o.abscissa.map_or(String::new(), |x| x.to_string());
            let deviation = if self.data.has_deviations[o.series] { o.deviation.to_string() } else { String::new() };
            let mut row =
                vec![(o.shot + 1).to_string(), self.data.series[o.series].clone(), x, o.value.to_string(), deviation];
            row.push(computed.to_string());
            row.extend(self.posterior.iter().flat_map(|p| p.predictions[i].map(|limit| limit.to_string())));
            text += &csv::line(row);
        }
        text
    }

    fn json(&self) -> serde_json::Value {
        let (fit, names) = (&self.fits.best, &self.names);
        let estimates = names.iter().cloned().zip(fit.estimates().into_iter().map(|e| json!(e)));
        let estimates: serde_json::Map<_, _> = estimates.collect();
        let correlations: Vec<Vec<Option<f64>>> =
            (0..names.len()).map(|i| (0..names.len()).map(|j| fit.correlation(i, j)).collect()).collect();
        let mut object = json!({
            "estimates": estimates, "correlations": correlations, "deviation": fit.deviation(),
            "freedom": fit.freedom, "settled": fit.converged, "said": self.sentences(),
            "starts": self.fits.starts, "starts_in_best_minimum": self.fits.same,
        });
        if let Some(posterior) = &self.posterior {
            let each = posterior.names.iter().cloned().zip(posterior.estimates()).enumerate().map(|(i, (name, e))| {
                let (r_hat, effective) = (posterior.r_hat[i], posterior.effective[i]);
                (
                    name,
                    json!({ "median": e.value, "low": e.low, "high": e.high, "r_hat": r_hat, "effective": effective }),
                )
            });
            let parameters: serde_json::Map<_, _> = each.collect();
            object["posterior"] = json!({
                "parameters": parameters, "runs": posterior.runs, "acceptance": posterior.acceptance,
                "converged": posterior.converged,
            });
        }
        object
    }
}

/// Returns a CSV table of posterior draws, evenly spaced over the chains.
fn draws(posterior: &Posterior) -> String {
    let every = posterior.draws.len().div_ceil(WRITTEN_DRAWS).max(1);
    let rows = posterior.draws.iter().step_by(every).map(|draw| csv::line(draw.iter().map(f64::to_string)));
    std::iter::once(csv::line(&posterior.names)).chain(rows).collect()
}
