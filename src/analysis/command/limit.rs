//! The command `revolve limit`: ballistic limit velocity, outcomes of the other shots, and scatter of the limit.

use std::error::Error;

use crate::output::{JobFiles, csv};
use crate::study::StudyError;
use crate::study::evaluate::SampleEvaluator;
use crate::study::grid::CaseGrid;
use crate::study::inputs::RandomInputs;
use crate::study::limit::{self, DrawnShot, DrawnShots, LimitRequest, LimitScatter, LimitVelocity, Shot, VelocityBand};
use crate::study::quantity::Quantity;
use crate::study::shot::{ShotEnd, ShotResult};
use crate::study::statistics::design::{SampleDesign, SamplingScheme};
use crate::study::table::{TextTable, number};
use clap::Args;
use serde_json::{Value, json};

use super::search::{self, CompiledRoutines, NumberFormat, SearchArguments};
use super::{CommandStatus, ResultFile, write_results};

/// Largest number of draws whose shots are written.
const MOST_WRITTEN: u32 = 10_000;

/// Find the ballistic limit velocity, the residual velocity curve above it, the velocities of ricochet and embedding
/// below it, and optionally the scatter of the limit (V50).
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
    /// "-final(V2@REF)". Default: the speed of the rigid body that leaves the target.
    #[arg(long, value_name = "EXPR", allow_hyphen_values = true)]
    residual: Option<String>,
    /// Residual velocity that a shot must exceed to count as perforation. Required with `--residual` if no rigid body
    /// meets a `*TARGET`; choose it above the velocity of a meshed plate.
    #[arg(long, value_name = "SPEED")]
    least: Option<f64>,
    /// Find the limit for several values of another deck parameter: NAME=v1,v2,… or NAME=start:stop:step.
    #[arg(long, value_name = "NAME=VALUES", conflicts_with = "distribution")]
    over: Option<String>,
    /// Number of shots above the limit, for the residual velocity curve, and below it, for the other outcomes.
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
        self.reject_velocity(&inputs.names, "--distribution")?;
        let routines = self.search.routines()?;
        match self.over.clone() {
            Some(over) => self.find_over(&request, &over, &routines),
            None => self.find_one(&request, &inputs, &routines),
        }
    }

    /// Finds one limit, and its scatter for random parameters.
    fn find_one(
        &self,
        request: &LimitRequest,
        inputs: &RandomInputs,
        routines: &CompiledRoutines,
    ) -> Result<CommandStatus, Box<dyn Error>> {
        let labels = self.search.results.labels.checked(limit::AXES)?;
        let evaluator = self.evaluator(&[], routines)?;
        let (job, _lock) = self.search.job()?;
        let log = self.search.resume.log(&job)?;
        let evaluator = evaluator.logged(&log)?;
        let limit_velocity = limit::find(request, &mut |velocities| {
            limit::fire(request, &evaluator, velocities, &[], self.search.threads())
        })?;
        let Some(bracket) = limit_velocity.bracket else { return Err(no_limit(&limit_velocity).into()) };
        let drawn = match inputs.names.is_empty() {
            true => None,
            false => Some(self.scatter(request, inputs, &self.evaluator(&inputs.names, routines)?.logged(&log)?)?),
        };
        let scattered = drawn.as_ref().map(|drawn| &drawn.0);
        let table = |format| table(&limit_velocity, bracket, scattered, format);
        let mut object = record(&limit_velocity, scattered);
        let mut others = vec![shots_file(None, &[(0.0, &limit_velocity)])];
        if let Some((scattered, shots)) = drawn.as_ref().filter(|_| self.count <= MOST_WRITTEN) {
            object["draws"] = shots.record(scattered);
            others.push(draws_file(shots));
        }
        others.push(search::json_file("limit", &object)?);
        let mut charts = vec![(String::new(), limit::chart(&job.name, &limit_velocity, scattered))];
        charts.extend(scattered.iter().map(|s| ("_scatter".to_owned(), limit::scatter_chart(&job.name, s))));
        write_results(&job, "limit", &table(NumberFormat::Exact), others, &charts, &labels)?;
        self.search.end_log(&log);
        self.search.print(&table(NumberFormat::Rounded), &lines(&limit_velocity, bracket, scattered, &job));
        self.search.output.print_json(&object)?;
        Ok(CommandStatus::of(is_decided(&limit_velocity) && scattered.is_none_or(|s| s.lost == 0)))
    }

    /// Finds the limit for each value of another parameter.
    fn find_over(
        &self,
        request: &LimitRequest,
        over: &str,
        routines: &CompiledRoutines,
    ) -> Result<CommandStatus, Box<dyn Error>> {
        let (name, values) = values_over(over)?;
        self.reject_velocity(std::slice::from_ref(&name), "--over")?;
        let labels = self.search.results.labels.checked([&name[..], limit::AXES[0]])?;
        let evaluator = self.evaluator(std::slice::from_ref(&name), routines)?;
        let (job, _lock) = self.search.job()?;
        let log = self.search.resume.log(&job)?;
        let evaluator = evaluator.logged(&log)?;
        let find = |value: f64| {
            let threads = self.search.threads();
            let fire = &mut |velocities: &[f64]| limit::fire(request, &evaluator, velocities, &[value], threads);
            Ok((value, limit::find(request, fire)?))
        };
        let limits = values.into_iter().map(find).collect::<Result<Vec<_>, StudyError>>()?;
        let object = record_over(&name, &limits);
        let each: Vec<_> = limits.iter().map(|(value, limits)| (*value, limits)).collect();
        let others = vec![search::json_file("limit", &object)?, shots_file(Some(&name), &each)];
        let charts = [(String::new(), limit::map_chart(&job.name, &name, &limits))];
        write_results(&job, "limit", &table_over(&name, &limits, NumberFormat::Exact), others, &charts, &labels)?;
        self.search.end_log(&log);
        let files = files_line(limits.iter().map(|(_, limits)| limits.shots.len()).sum(), &job);
        let more = limits.iter().flat_map(|(value, limits)| {
            warnings(limits).into_iter().map(|line| format!("{name} = {}: {line}", number(*value)))
        });
        let table = table_over(&name, &limits, NumberFormat::Rounded);
        self.search.print(&table, &more.chain([files]).collect::<Vec<_>>());
        self.search.output.print_json(&object)?;
        Ok(CommandStatus::of(limits.iter().all(|(_, limits)| is_decided(limits))))
    }

    /// Returns an error if an option gives the striking velocity as another parameter.
    fn reject_velocity(&self, names: &[String], option: &str) -> Result<(), StudyError> {
        let velocity = &self.velocity;
        if !names.contains(velocity) {
            return Ok(());
        }
        Err(StudyError::Setting(format!(
            "{option} {velocity}: this parameter is given by --velocity; {option} needs another one"
        )))
    }

    /// Returns the evaluator of shots over the striking velocity and the parameters `others`.
    fn evaluator(&self, others: &[String], routines: &CompiledRoutines) -> Result<SampleEvaluator, Box<dyn Error>> {
        let names = [self.velocity.clone()].into_iter().chain(others.iter().cloned()).collect();
        let residual = self.residual.iter().map(|text| Quantity::parse(text)).collect::<Result<_, _>>()?;
        Ok(self.search.evaluator(names, residual, routines)?.of_shots(self.least))
    }

    /// Finds the limit of each draw. Returns the scatter and, of not too many draws, the shots.
    fn scatter(
        &self,
        request: &LimitRequest,
        inputs: &RandomInputs,
        evaluator: &SampleEvaluator,
    ) -> Result<(LimitScatter, DrawnShots), Box<dyn Error>> {
        let (width, count) = (inputs.names.len(), self.count as usize);
        let mut points = vec![0.0; width * count];
        SampleDesign::new(SamplingScheme::Random, width, count, self.seed)?.fill(&mut points);
        let mut drawn = vec![0.0; width * count];
        points.chunks(width).zip(drawn.chunks_mut(width)).for_each(|(point, values)| inputs.values(point, values));
        let (mut fired_shots, written) = (Vec::new(), self.count <= MOST_WRITTEN);
        let fire = &mut |shots: &[(usize, f64)]| -> Result<Vec<Option<Shot>>, StudyError> {
            let row = |(draw, velocity): &(usize, f64)| {
                [*velocity].into_iter().chain(drawn[draw * width..(draw + 1) * width].iter().copied())
            };
            let samples: Vec<f64> = shots.iter().flat_map(row).collect();
            let fired = evaluator.shots(&samples, self.search.threads())?;
            let judge =
                |(fired, shot): (ShotResult, &(usize, f64))| fired.ok().map(|fired| request.judge(shot.1, &fired));
            let judged: Vec<Option<Shot>> =
                fired.into_iter().zip(shots).map(judge).map(Option::transpose).collect::<Result<_, _>>()?;
            if written {
                let drawn_shot = |(&(draw, velocity), &result)| DrawnShot { draw, velocity, result };
                fired_shots.extend(shots.iter().zip(&judged).map(drawn_shot));
            }
            Ok(judged)
        };
        let scattered = limit::scatter(request, count, fire)?;
        Ok((scattered, DrawnShots { names: inputs.names.clone(), values: drawn, shots: fired_shots }))
    }
}

/// Parses `NAME=VALUES` of `--over`.
fn values_over(over: &str) -> Result<(String, Vec<f64>), StudyError> {
    let wrong = |why: &str| StudyError::Setting(format!("--over {over}: {why}"));
    let grid = CaseGrid::parse(&[over.to_owned()]).map_err(|e| wrong(&e.to_string()))?;
    let (name, values) = grid.axes().first().cloned().ok_or_else(|| wrong("expected NAME=VALUES"))?;
    let numbers = values.iter().map(|value| value.parse().ok()).collect::<Option<Vec<f64>>>();
    numbers.map(|numbers| (name, numbers)).ok_or_else(|| wrong("expected numbers, for example 0,15,30,45"))
}

/// Returns whether all shots above the limit perforate, and no shot directly below it still moves.
fn is_decided(found: &LimitVelocity) -> bool {
    found.gaps().next().is_none() && found.undecided().is_none()
}

/// Returns the error of a search interval that does not enclose a limit.
fn no_limit(found: &LimitVelocity) -> String {
    let ends = || found.bands().iter().map(band_text).collect::<Vec<_>>().join(", ");
    match (found.shots.first(), found.shots.last()) {
        (Some(low), _) if low.perforates() => {
            let velocity = low.velocity;
            format!("a shot at {velocity} perforates: decrease the lower end of --between (found: {})", ends())
        }
        (_, Some(Shot { velocity, residual, end: ShotEnd::Moving })) => format!(
            "a shot at {velocity} still moves in the target with the speed {}, although the last step was extended: increase \
             the duration of the steps, or the upper end of --between",
            number(*residual)
        ),
        (_, high) => format!(
            "a shot at {} does not perforate: increase the upper end of --between (found: {})",
            high.map_or(0.0, |shot| shot.velocity),
            ends()
        ),
    }
}

fn band_text(band: &VelocityBand) -> String {
    format!("{} from {} to {}", band.end.words(), number(band.from), number(band.to))
}

fn lines(found: &LimitVelocity, bracket: [f64; 2], scattered: Option<&LimitScatter>, job: &JobFiles) -> Vec<String> {
    let [low, high] = bracket.map(number);
    let limit = number(0.5 * (bracket[0] + bracket[1]));
    let is_open = found.shots.iter().any(|shot| shot.velocity == bracket[0] && shot.end == ShotEnd::Moving);
    let mut lines = vec![match is_open {
        true => format!("limit velocity at most {high}: the shot at {low} is undecided"),
        false => format!("limit velocity {limit}: {low} does not perforate, {high} does"),
    }];
    lines.extend(found.bands().iter().map(band_text));
    match &found.curve {
        Some(curve) => lines.push(format!(
            "Lambert and Jonas: v_r = a (v^p - v_l^p)^(1/p); standard deviation of a shot from the curve {}{}",
            number(curve.deviation),
            if curve.converged { "" } else { " (the fit did not converge)" }
        )),
        None => lines.push("no Lambert-Jonas curve: fewer than four shots perforate, or they do not determine the curve; increase --shots".into()),
    }
    lines.extend(warnings(found));
    if let Some(scattered) = scattered {
        let draw_count = scattered.members.len() + scattered.lost;
        let outside = scattered.members.iter().filter(|m| m.0.is_infinite() || m.1.is_infinite()).count();
        lines.push(format!(
            "{draw_count} draws: {outside} have their limit outside --between, {} failed",
            scattered.lost
        ));
        if scattered.scatter.is_none() {
            lines.push("no scatter can be estimated: the intervals of all limits overlap; decrease --tolerance or use more draws".into());
        }
    }
    lines.push(files_line(found.shots.len(), job));
    lines
}

/// Returns the sentences about a limit that is not unique or not decided.
fn warnings(found: &LimitVelocity) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some(gap) = found.gaps().next() {
        let gap = number(gap);
        lines.push(format!("a shot at {gap} above the limit does not perforate: there is more than one limit"));
    }
    if let Some(band) = found.undecided() {
        let [from, to] = [band.from, band.to].map(number);
        lines.push(format!(
            "shots from {from} to {to} are undecided: although the last step was extended, they still move in the target, or \
             their residual velocity falls or vibrates; increase the duration of the steps"
        ));
    }
    lines
}

fn files_line(shots: usize, job: &JobFiles) -> String {
    let (csv, png) = (job.path("_limit.csv"), job.path("_limit.png"));
    format!("{shots} shots; table {}, picture {}", csv.display(), png.display())
}

/// Returns the JSON object of one limit and its scatter.
fn record(found: &LimitVelocity, scattered: Option<&LimitScatter>) -> Value {
    let mut object = found.record();
    object["v50"] = json!(scattered.and_then(|s| s.scatter).map(|s| s.median));
    object["deviation"] = json!(scattered.and_then(|s| s.scatter).map(|s| s.deviation));
    object["lost"] = json!(scattered.map(|s| s.lost));
    object
}

/// Returns the JSON object of the limits for the values of another parameter.
fn record_over(name: &str, found: &[(f64, LimitVelocity)]) -> Value {
    let record_of = |(value, found): &(f64, LimitVelocity)| {
        let mut object = found.record();
        object["value"] = json!(value);
        object
    };
    json!({"over": name, "limits": found.iter().map(record_of).collect::<Vec<_>>()})
}

/// Returns the CSV file of all shots, with the value of the parameter `over` if there is one.
fn shots_file(over: Option<&str>, found: &[(f64, &LimitVelocity)]) -> ResultFile {
    let exact = |value: f64| NumberFormat::Exact.text(value);
    let row = |value: f64, shot: &Shot| {
        let end = json!(shot.end).as_str().unwrap_or_default().to_owned();
        csv::line(over.map(|_| exact(value)).into_iter().chain([exact(shot.velocity), exact(shot.residual), end]))
    };
    let mut text = csv::line(over.into_iter().chain(["velocity", "residual", "end"]));
    text.extend(found.iter().flat_map(|(value, found)| found.shots.iter().map(|shot| row(*value, shot))));
    ("_limit_shots.csv".into(), text.into_bytes())
}

/// Returns the CSV file of the shots of all draws, with the number of the draw and its parameters.
fn draws_file(drawn: &DrawnShots) -> ResultFile {
    let exact = |value: f64| NumberFormat::Exact.text(value);
    let header = ["draw"].into_iter().chain(drawn.names.iter().map(String::as_str));
    let mut text = csv::line(header.chain(["velocity", "residual", "end"]));
    let mut shots: Vec<_> = drawn.shots.iter().collect();
    shots.sort_by_key(|shot| shot.draw);
    for &DrawnShot { draw, velocity, result: shot } in shots {
        let end = shot.map_or(json!(limit::FAILED), |shot| json!(shot.end));
        let residual = shot.map_or(String::new(), |shot| exact(shot.residual));
        let parameters = drawn.of(draw).iter().copied().map(exact);
        let result = [exact(velocity), residual, end.as_str().unwrap_or_default().to_owned()];
        text += &csv::line([(draw + 1).to_string()].into_iter().chain(parameters).chain(result));
    }
    ("_limit_draws.csv".into(), text.into_bytes())
}

/// Returns the table of limits and bands for the values of another parameter.
fn table_over(name: &str, found: &[(f64, LimitVelocity)], format: NumberFormat) -> TextTable {
    let number = |value: f64| format.text(value);
    let rows = found.iter().flat_map(|(value, found)| {
        let row = move |what: &str, from: f64, to: f64| vec![number(*value), what.to_owned(), number(from), number(to)];
        let limit = found.bracket.map(|[low, high]| row("limit velocity", low, high));
        let bands: Vec<_> = found.bands().iter().map(|band| row(band.end.words(), band.from, band.to)).collect();
        limit.into_iter().chain(bands)
    });
    TextTable { header: [name, "outcome", "from", "to"].map(str::to_owned).to_vec(), rows: rows.collect() }
}

/// Returns the table of the limit velocity, the parameters of the curve and the scatter.
fn table(
    found: &LimitVelocity,
    bracket: [f64; 2],
    scattered: Option<&LimitScatter>,
    format: NumberFormat,
) -> TextTable {
    let limit = [0.5 * (bracket[0] + bracket[1]), bracket[0], bracket[1]].map(|value| format.text(value));
    let mut rows: Vec<Vec<String>> = vec![["limit velocity (bracket)".to_owned()].into_iter().chain(limit).collect()];
    let mut row =
        |what: &str, estimate| rows.push([what.to_owned()].into_iter().chain(format.cells(estimate)).collect());
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
