//! The command `revolve identify`: least-squares identification of deck parameters.

use std::error::Error;
use std::path::PathBuf;

use crate::deck::files;
use crate::study::identify::{self, ShotTable};
use crate::study::quantity::Quantity;
use crate::study::statistics::least_squares::ParameterFit;
use crate::study::table::{TextTable, number};
use clap::Args;
use serde_json::json;

use super::search::{self, SearchArguments};
use super::{CommandStatus, HALTED, write_results};

/// Identify deck parameters from measured shots by least squares, with 95 % confidence intervals and correlations.
#[derive(Args)]
pub struct IdentifyCommand {
    #[command(flatten)]
    search: SearchArguments,
    /// CSV file with one row per shot: a column for each known deck parameter, and the measured value.
    #[arg(long, value_name = "FILE")]
    shots: PathBuf,
    /// Column of the measured value.
    #[arg(long, value_name = "COLUMN")]
    measured: String,
    /// Column with the standard deviation of each measurement; residuals are divided by it (default: equal
    /// weights).
    #[arg(long, value_name = "COLUMN")]
    deviation: Option<String>,
    /// Computed counterpart of the measured value: an expression over history columns, for example
    /// "-1000*final(U2@REF)".
    #[arg(long, allow_hyphen_values = true)]
    quantity: String,
    /// Parameter to identify and its initial value; can be repeated or given as a list separated by commas.
    #[arg(long, value_name = "NAME=START", value_delimiter = ',', required = true)]
    unknown: Vec<String>,
}

impl IdentifyCommand {
    pub fn execute(self) -> Result<CommandStatus, Box<dyn Error>> {
        let (names, start) = self.unknowns()?;
        let text = files::read_text(&self.shots).map_err(|e| format!("--shots {}: {e}", self.shots.display()))?;
        let shots = ShotTable::parse(&self.shots, &text, &self.measured, self.deviation.as_deref())?;
        if let Some(name) = names.iter().find(|name| shots.names.contains(name)) {
            return Err(format!(
                "--unknown {name}: it is also a column of {}; remove the option or the column",
                self.shots.display()
            )
            .into());
        }
        let routines = self.search.routines()?;
        let all = shots.names.iter().chain(&names).cloned().collect();
        let evaluator = self.search.evaluator(all, vec![Quantity::parse(&self.quantity)?], &routines)?;
        let (job, _lock) = self.search.job()?;
        let found = identify::identify(&evaluator, &shots, &start, self.search.threads())?;
        let table = table(&names, &found);
        let chart = shots.chart(&job.name, &self.measured, &self.quantity, &found);
        write_results(&job, "identify", &table, Vec::new(), &[(String::new(), chart)])?;
        let said = identify::sentences(&found, &names);
        self.search.print(&table, &self.lines(&shots, &found, &said, &job));
        let estimates = names.iter().cloned().zip(found.estimates().into_iter().map(|e| json!(e)));
        let estimates: serde_json::Map<_, _> = estimates.collect();
        let correlations: Vec<Vec<Option<f64>>> =
            (0..names.len()).map(|i| (0..names.len()).map(|j| found.correlation(i, j)).collect()).collect();
        self.search.print_json(&json!({
            "estimates": estimates, "correlations": correlations, "deviation": found.deviation(),
            "freedom": found.freedom, "settled": found.converged, "said": said,
        }))?;
        search::warn_still_moving(&evaluator);
        Ok(if found.converged { CommandStatus::SUCCESS } else { CommandStatus::from(HALTED) })
    }

    fn unknowns(&self) -> Result<(Vec<String>, Vec<f64>), String> {
        let (mut names, mut start) = (Vec::new(), Vec::new());
        for text in &self.unknown {
            let parts =
                text.split_once('=').and_then(|(name, value)| Some((name.trim(), value.trim().parse::<f64>().ok()?)));
            let Some((name, value)) = parts.filter(|p| p.1.is_finite()) else {
                return Err(format!("--unknown {text}: expected NAME=NUMBER, for example A=4.5"));
            };
            if names.iter().any(|known| known == name) {
                return Err(format!("--unknown {name} is given twice"));
            }
            names.push(name.to_owned());
            start.push(value);
        }
        Ok((names, start))
    }

    fn lines(
        &self,
        shots: &ShotTable,
        found: &ParameterFit,
        said: &[String],
        job: &crate::output::JobFiles,
    ) -> Vec<String> {
        let unit = if self.deviation.is_some() { "standard deviations" } else { "units of the quantity" };
        let mut lines = vec![format!(
            "{} shots, {} degrees of freedom; standard deviation of a residual {} {unit}",
            shots.rows.len(),
            found.freedom,
            number(found.deviation())
        )];
        lines.extend(said.iter().cloned());
        let (csv, png) = (job.path("_identify.csv"), job.path("_identify.png"));
        lines.push(format!("table {}, picture {}", csv.display(), png.display()));
        lines
    }
}

/// Returns the table of the parameters with their confidence intervals and correlations.
fn table(names: &[String], found: &ParameterFit) -> TextTable {
    let mut header = search::header("parameter");
    header.extend(names.iter().map(|name| format!("correlation with {name}")));
    let row = |(i, estimate)| {
        let with = |j| found.correlation(i, j).map_or("-".to_owned(), |r| format!("{r:.4}"));
        let cells = [names[i].clone()].into_iter().chain(search::cells(estimate));
        cells.chain((0..names.len()).map(with)).collect()
    };
    TextTable { header, rows: found.estimates().into_iter().enumerate().map(row).collect() }
}
