//! The command `revolve limit`: ballistic limit velocity and its scatter.

use std::error::Error;

use crate::output::JobFiles;
use crate::study::StudyError;
use crate::study::evaluate::SampleEvaluator;
use crate::study::inputs::RandomInputs;
use crate::study::limit::{self, LimitRequest, LimitScatter, LimitVelocity};
use crate::study::quantity::Quantity;
use crate::study::statistics::design::{SampleDesign, SamplingScheme};
use crate::study::table::{TextTable, number};
use clap::Args;
use serde_json::json;

use super::search::{self, CompiledRoutines, SearchArguments};
use super::{CommandStatus, HALTED, write_results};

/// Find the ballistic limit velocity, the residual velocity curve above it, and optionally the scatter of the limit
/// (V50).
#[derive(Args)]
pub struct LimitCommand {
    #[command(flatten)]
    search: SearchArguments,
    /// Deck parameter that holds the striking velocity.
    #[arg(long, value_name = "NAME")]
    velocity: String,
    /// Search interval: the shot at LOW must not perforate, the shot at HIGH must.
    #[arg(long, value_name = "LOW,HIGH")]
    between: String,
    /// Bisection stops when the interval around the limit is at most this wide.
    #[arg(long, value_name = "WIDTH")]
    tolerance: f64,
    /// Residual velocity, positive in the direction of flight: an expression over history columns, for example
    /// "-final(V2@REF)".
    #[arg(long, value_name = "EXPR", allow_hyphen_values = true)]
    residual: String,
    /// A shot perforates if its residual velocity exceeds this value. For meshed plates choose it above the velocity of
    /// the plate.
    #[arg(long, value_name = "SPEED", default_value_t = 0.0)]
    least: f64,
    /// Number of shots above the limit for the residual velocity curve.
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    shots: u32,
    /// Random parameter, as in `scatter`: the limit is found for each of `--count` draws, and V50 and the standard
    /// deviation are estimated; can be repeated.
    #[arg(short, long, value_name = "NAME=DISTRIBUTION")]
    distribution: Vec<String>,
    /// Correlation of two random parameters, between -1 and 1; can be repeated.
    #[arg(long, value_name = "NAME:OTHER=NUMBER", requires = "distribution")]
    correlation: Vec<String>,
    /// Number of draws.
    #[arg(short, long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(3..=10_000_000))]
    count: u32,
    /// Seed of the random number generator.
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    seed: u64,
}

impl LimitCommand {
    pub fn execute(self) -> Result<CommandStatus, Box<dyn Error>> {
        let request = LimitRequest::new(&self.between, self.tolerance, self.least, self.shots as usize)?;
        let inputs = RandomInputs::parse(&self.distribution, &self.correlation)?;
        if inputs.names.contains(&self.velocity) {
            return Err(format!(
                "--distribution {}: this parameter is given by --velocity and cannot be random as well",
                self.velocity
            )
            .into());
        }
        let routines = self.search.routines()?;
        let evaluator = self.evaluator(&[], &routines)?;
        let (job, _lock) = self.search.job()?;
        let found = limit::find(&request, &mut |velocities| self.fire(&evaluator, velocities))?;
        let scattered = match inputs.names.is_empty() {
            true => None,
            false => Some(self.scatter(&request, &inputs, &self.evaluator(&inputs.names, &routines)?)?),
        };
        let table = table(&found, scattered.as_ref());
        let mut charts = vec![(String::new(), limit::chart(&job.name, &found, scattered.as_ref()))];
        charts.extend(scattered.iter().map(|s| ("_scatter".to_owned(), limit::scatter_chart(&job.name, s))));
        write_results(&job, "limit", &table, Vec::new(), &charts)?;
        self.search.print(&table, &self.lines(&found, scattered.as_ref(), &job));
        self.search.print_json(&json!({
            "bracket": found.bracket,
            "shots": found.shots,
            "a": found.curve.as_ref().map(|c| c.estimates[0]),
            "p": found.curve.as_ref().map(|c| c.estimates[1]),
            "limit_of_curve": found.curve.as_ref().map(|c| c.estimates[2]),
            "v50": scattered.as_ref().and_then(|s| s.scatter).map(|s| s.median),
            "deviation": scattered.as_ref().and_then(|s| s.scatter).map(|s| s.deviation),
            "lost": scattered.as_ref().map(|s| s.lost),
        }))?;
        let whole = found.gaps.is_empty() && scattered.is_none_or(|s| s.lost == 0);
        Ok(if whole { CommandStatus::SUCCESS } else { CommandStatus::from(HALTED) })
    }

    /// Returns the evaluator of the residual velocity over the striking velocity and the parameters `others`.
    fn evaluator(&self, others: &[String], routines: &CompiledRoutines) -> Result<SampleEvaluator, Box<dyn Error>> {
        let names = [self.velocity.clone()].into_iter().chain(others.iter().cloned()).collect();
        let evaluator = self.search.evaluator(names, vec![Quantity::parse(&self.residual)?], routines)?;
        Ok(evaluator.to_the_end())
    }

    fn fire(&self, evaluator: &SampleEvaluator, velocities: &[f64]) -> Result<Vec<f64>, StudyError> {
        let (table, failures) = evaluator.table(velocities, self.search.threads())?;
        failures.into_iter().next().map_or(Ok(table), |failure| Err(failure.reason))
    }

    /// Finds the limit of each draw.
    fn scatter(
        &self,
        request: &LimitRequest,
        inputs: &RandomInputs,
        evaluator: &SampleEvaluator,
    ) -> Result<LimitScatter, Box<dyn Error>> {
        let (width, count) = (inputs.names.len(), self.count as usize);
        let mut points = vec![0.0; width * count];
        SampleDesign::new(SamplingScheme::Random, width, count, self.seed)?.fill(&mut points);
        let mut drawn = vec![0.0; width * count];
        points.chunks(width).zip(drawn.chunks_mut(width)).for_each(|(point, values)| inputs.values(point, values));
        let fire = &mut |shots: &[(usize, f64)]| -> Result<Vec<f64>, StudyError> {
            let row = |(draw, velocity): &(usize, f64)| {
                [*velocity].into_iter().chain(drawn[draw * width..(draw + 1) * width].iter().copied())
            };
            let samples: Vec<f64> = shots.iter().flat_map(row).collect();
            Ok(evaluator.table(&samples, self.search.threads())?.0)
        };
        Ok(limit::scatter(request, count, fire)?)
    }

    fn lines(&self, found: &LimitVelocity, scattered: Option<&LimitScatter>, job: &JobFiles) -> Vec<String> {
        let [low, high] = found.bracket.map(number);
        let mut lines =
            vec![format!("limit velocity {}: {low} does not perforate, {high} does", number(found.velocity()))];
        match &found.curve {
            Some(curve) => lines.push(format!(
                "Lambert and Jonas: v_r = a (v^p - v_l^p)^(1/p); standard deviation of a shot from the curve {}{}",
                number(curve.deviation),
                if curve.converged { "" } else { " (the fit did not converge)" }
            )),
            None => {
                lines.push("no Lambert-Jonas curve: it needs at least four perforating shots; increase --shots".into())
            }
        }
        if let Some(gap) = found.gaps.first() {
            lines.push(format!(
                "a shot at {} above the limit does not perforate: there is more than one limit",
                number(*gap)
            ));
        }
        if let Some(scattered) = scattered {
            let all = scattered.members.len() + scattered.lost;
            let outside = scattered.members.iter().filter(|m| m.0.is_infinite() || m.1.is_infinite()).count();
            lines.push(format!("{all} draws: {outside} have their limit outside --between, {} failed", scattered.lost));
            if scattered.scatter.is_none() {
                lines.push("no scatter can be estimated: the intervals of all limits overlap; decrease --tolerance or use more draws".into());
            }
        }
        let (csv, png) = (job.path("_limit.csv"), job.path("_limit.png"));
        lines.push(format!("{} shots; table {}, picture {}", found.shots.len(), csv.display(), png.display()));
        lines
    }
}

/// Returns the table of the limit velocity, the parameters of the curve and the scatter.
fn table(found: &LimitVelocity, scattered: Option<&LimitScatter>) -> TextTable {
    let mut rows = vec![vec![
        "limit velocity (bracket)".to_owned(),
        number(found.velocity()),
        number(found.bracket[0]),
        number(found.bracket[1]),
    ]];
    let mut row =
        |what: &str, estimate| rows.push([what.to_owned()].into_iter().chain(search::cells(estimate)).collect());
    if let Some(curve) = &found.curve {
        for (what, estimate) in ["a", "p", "limit velocity of the curve"].into_iter().zip(curve.estimates) {
            row(what, estimate);
        }
    }
    if let Some(scatter) = scattered.and_then(|s| s.scatter) {
        row("V50", scatter.median);
        row("standard deviation of the limit", scatter.deviation);
    }
    TextTable { header: search::header("what"), rows }
}
