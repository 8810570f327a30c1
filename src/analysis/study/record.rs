//! Output of a study: table, CSV, JSON with stable keys, and charts.

use indexmap::IndexMap;
use serde::Serialize;
use serde_json::Value;

use super::chart::{AxisScale, Chart, ChartSeries, SeriesForm};
use super::effects::EffectAblation;
use super::grid::json_value;
use super::noise::NoiseEstimate;
use super::price::{self, AccuracyCost, setting, setting_without};
use super::refinement::{ErrorReference, RefinementStudy, StudyRow};
use super::richardson::{FORMAL_ORDER, LimitEstimate};
use super::runner::TimeSpread;
use super::table::{TextTable, cell, digits, duration, short};
use super::target::{EXTRA_LEVELS, MOST_CYCLES, TargetResult};

/// File name suffix of the certificate of a run.
pub const CERTIFICATE: &str = "_certificate.json";

/// Record of a convergence study, the contents of `<job>_study.json`. The keys are stable.
#[derive(Clone, Debug, Serialize)]
pub struct StudyRecord<'a> {
    /// Expression of the quantity as written.
    pub quantity: &'a str,
    /// Exact value of the quantity, if given by `--exact` or known to be zero.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exact: Option<f64>,
    /// Reference value from which errors are measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<ErrorReference>,
    /// Value by which errors are divided to make them relative; absent if the reference is zero.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// All settings, in the order of their runs.
    pub runs: Vec<RunRecord<'a>>,
    /// Series of runs that differ in one level of refinement only.
    pub refinements: Vec<RefinementRecord<'a>>,
    /// Indices of the runs on the Pareto front of run time and error.
    pub front: Vec<usize>,
    /// Run time for each accuracy.
    pub prices: Vec<AccuracyCost>,
    /// `prices` as one line of text.
    pub sentence: String,
    /// Scatter of the quantity over perturbed runs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<&'a NoiseEstimate>,
    /// Result of `--target`: the error target and the run that meets it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<&'a TargetResult>,
    /// Time in runs, total time and number of repetitions.
    pub timing: StudyTiming,
    /// Version of the program that wrote the record.
    pub version: &'static str,
}

/// Series of runs that differ only in the level of one parameter.
#[derive(Clone, Debug, Serialize)]
pub struct RefinementRecord<'a> {
    /// Name of the refined parameter, or names joined by "and".
    pub along: &'a str,
    /// Values of the other parameters, as written; empty if there are none.
    pub at: String,
    /// Indices of the runs, coarsest first.
    pub runs: &'a [usize],
    /// Size of each level divided by that of the finest.
    pub sizes: Vec<f64>,
    /// Observed order of convergence, if it can be determined.
    pub order: Option<f64>,
    /// Formal order of the method.
    pub formal_order: f64,
}

impl<'a> RefinementRecord<'a> {
    fn of(study: &'a RefinementStudy, series: &'a super::refinement::RefinementSeries) -> RefinementRecord<'a> {
        let finest = series.sizes.last().copied().unwrap_or(1.0);
        let fixed_setting = series
            .rows
            .first()
            .map_or(String::new(), |&r| setting_without(study, r, &series.along.split(" and ").collect::<Vec<_>>()));
        RefinementRecord {
            along: &series.along,
            at: fixed_setting,
            runs: &series.rows,
            sizes: series.sizes.iter().map(|size| size / finest).collect(),
            order: series.estimate.and_then(|e| e.order),
            formal_order: FORMAL_ORDER,
        }
    }
}

/// Record of an ablation study (`--ablate`), the contents of `<job>_study.json`. The keys are stable.
#[derive(Clone, Debug, Serialize)]
pub struct AblationRecord<'a> {
    /// Expression of the quantity as written.
    pub quantity: &'a str,
    /// Results for each removed effect.
    pub ablation: &'a EffectAblation,
    /// Version of the program that wrote the record.
    pub version: &'static str,
}

/// Creates the record of an ablation study.
pub fn ablation<'a>(quantity: &'a str, effects: &'a EffectAblation) -> AblationRecord<'a> {
    AblationRecord { quantity, ablation: effects, version: env!("CARGO_PKG_VERSION") }
}

/// Time spent on a study, in seconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StudyTiming {
    /// Seconds in all runs, from reading the deck to the last increment.
    pub runs: f64,
    /// Seconds of the study without writing files.
    pub total: f64,
    /// Number of runs of each setting.
    pub repeat: usize,
}

/// Study with the result of its target and the time spent.
#[derive(Clone, Debug)]
pub struct CompletedStudy {
    /// Settings with their results.
    pub study: RefinementStudy,
    /// Result of the error target; `None` without a target.
    pub target: Option<TargetResult>,
    /// Time spent.
    pub timing: StudyTiming,
}

/// Result of one setting, an entry of `runs`.
#[derive(Clone, Debug, Serialize)]
pub struct RunRecord<'a> {
    /// Value of each parameter; a text if it is not a number.
    pub setting: IndexMap<&'a str, Value>,
    /// Error, if the run gave no value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
    /// Value of the quantity; absent if the run failed.
    pub value: Option<f64>,
    /// Difference from the reference.
    pub error: Option<f64>,
    /// Bound of the absolute error.
    pub bound: Option<f64>,
    /// Estimate of the limit by each series: order, behaviour, limit, uncertainty and factor of safety.
    pub estimates: &'a [Option<LimitEstimate>],
    /// Order of convergence from the last two errors against the exact value, by series.
    #[serde(skip_serializing_if = "<[Option<f64>]>::is_empty")]
    pub exact_orders: &'a [Option<f64>],
    /// Sum of the grid convergence indices of all series, in the units of the quantity.
    pub uncertainty: Option<f64>,
    /// Number of increments of the run.
    pub increments: Option<u64>,
    /// Number of elements and facets.
    pub elements: Option<usize>,
    /// Elements times increments.
    pub element_cycles: Option<f64>,
    /// Run time in seconds: median, shortest, longest.
    pub seconds: Option<TimeSpread>,
    /// Time in the time loop in seconds: median, shortest, longest.
    pub loop_seconds: Option<TimeSpread>,
    /// Warnings of the run, and notes on bodies that are still moving in a target.
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    pub warnings: &'a [String],
}

/// Creates the record of a convergence study.
pub fn record<'a>(quantity: &'a str, exact: Option<f64>, completed: &'a CompletedStudy) -> StudyRecord<'a> {
    let CompletedStudy { study, target, timing } = completed;
    StudyRecord {
        quantity,
        exact,
        reference: study.reference,
        scale: study.scale,
        runs: study.rows.iter().map(|r| run(study, r)).collect(),
        refinements: study.series.iter().map(|series| RefinementRecord::of(study, series)).collect(),
        front: price::pareto_front(study),
        prices: price::list(study),
        sentence: price::sentence(study),
        noise: study.noise.as_ref(),
        target: target.as_ref(),
        timing: *timing,
        version: env!("CARGO_PKG_VERSION"),
    }
}

fn run<'a>(study: &'a RefinementStudy, row: &'a StudyRow) -> RunRecord<'a> {
    let ran = row.run.as_ref().ok();
    RunRecord {
        setting: study.axes.iter().map(String::as_str).zip(row.values.iter().map(|text| json_value(text))).collect(),
        failure: row.run.as_ref().err().map(ToString::to_string),
        value: row.value,
        error: row.error,
        bound: row.bound,
        estimates: &row.estimates,
        exact_orders: &row.exact_orders,
        uncertainty: row.uncertainty,
        increments: ran.map(|r| r.increments),
        elements: ran.map(|r| r.elements),
        element_cycles: ran.map(|r| r.element_cycles()),
        seconds: ran.map(|r| r.seconds),
        loop_seconds: ran.map(|r| r.loop_seconds),
        warnings: ran.map_or(&[], |r| &r.warnings),
    }
}

/// Returns the table of a study with few digits or with all digits.
pub fn table(study: &RefinementStudy, all_digits: bool) -> TextTable {
    let unit = if study.scale.is_some() { "%" } else { "" };
    let mut header: Vec<String> = study.axes.clone();
    let columns = ["value", "error", "error below", "order", "limit", "GCI", "increments", "element-cycles"];
    header.extend(columns.iter().map(|c| match *c {
        "error" | "error below" | "GCI" if study.scale.is_some() => format!("{c} {unit}"),
        c => c.to_owned(),
    }));
    header.extend(["time ms", "time min ms", "time max ms", "note"].map(String::from));
    let front = price::pareto_front(study);
    let rows = study.rows.iter().enumerate();
    let rows = rows.map(|(i, row)| cells(study, row, front.contains(&i), all_digits)).collect();
    TextTable { header, rows }
}

fn cells(study: &RefinementStudy, row: &StudyRow, on_front: bool, all_digits: bool) -> Vec<String> {
    let number = |value: Option<f64>, few: usize| cell(value, few, all_digits);
    let factor = study.scale.map_or(1.0, |s| 100.0 / s);
    let relative = |value: Option<f64>| number(value.map(|v| factor * v), 3);
    let in_words = |order: Option<f64>| order.map_or("-".into(), |o| format!("{o:.2}"));
    let orders: Vec<String> = if row.exact_orders.is_empty() {
        row.estimates.iter().map(|e| in_words(e.and_then(|e| e.order))).collect()
    } else {
        row.exact_orders.iter().map(|o| in_words(*o)).collect()
    };
    let run = row.run.as_ref().ok();
    let limit = match &row.estimates[..] {
        [Some(estimate)] => Some(estimate.limit),
        _ => None,
    };
    let mut cells = row.values.clone();
    cells.extend([number(row.value, 7), relative(row.error), relative(row.bound)]);
    cells.extend([orders.join(" / "), number(limit, 7), relative(row.uncertainty)]);
    cells.push(run.map_or(String::new(), |r| r.increments.to_string()));
    cells.push(number(run.map(|r| r.element_cycles()), 3));
    for time in [run.map(|r| r.seconds.median), run.map(|r| r.seconds.min), run.map(|r| r.seconds.max)] {
        cells.push(number(time.map(|t| 1e3 * t), 3));
    }
    cells.push(note(row, on_front));
    cells
}

fn note(row: &StudyRow, on_front: bool) -> String {
    let Ok(run) = &row.run else { return "no result".into() };
    let mut words: Vec<&str> =
        row.estimates.iter().flatten().map(|e| e.behaviour.word()).filter(|w| !w.is_empty()).collect();
    words.dedup();
    if on_front {
        words.insert(0, "front");
    }
    if !run.warnings.is_empty() {
        words.push("warned");
    }
    words.join(", ")
}

/// Returns the chart of error against run time: one series per family, and the Pareto front.
pub fn price_chart(study: &RefinementStudy, title: &str) -> Chart {
    let factor = study.scale.map_or(1.0, |s| 100.0 / s);
    let point = |row: usize| {
        let r = &study.rows[row];
        let seconds = r.run.as_ref().ok()?.seconds.median;
        r.bound.map(|b| (1e3 * seconds, factor * b)).filter(|p| p.0 > 0.0 && p.1 > 0.0)
    };
    let front = price::pareto_front(study).into_iter().filter_map(point).collect();
    let mut series = vec![ChartSeries::new("Pareto front", SeriesForm::Line, front)];
    for family in 0..=study.rows.iter().map(|r| r.family).max().unwrap_or(0) {
        let rows: Vec<usize> = (0..study.rows.len()).filter(|&i| study.rows[i].family == family).collect();
        let points: Vec<(f64, f64)> = rows.iter().filter_map(|&i| point(i)).collect();
        if let Some(&first) = rows.first().filter(|_| !points.is_empty()) {
            series.push(ChartSeries::new(family_name(study, first), SeriesForm::Marks, points));
        }
    }
    logarithmic(title, ["time", "error"], ["ms".into(), error_unit(study)], series)
}

/// Returns the chart of error over size: one line per series of refinement, and lines of the observed and formal order
/// through the finest point of the first.
pub fn order_chart(study: &RefinementStudy, title: &str) -> Chart {
    let factor = study.scale.map_or(1.0, |s| 100.0 / s);
    let error = |row: &usize| study.rows[*row].error.map(|e| factor * e.abs()).filter(|e| *e > 0.0);
    let line = |refined: &RefinementRecord<'_>| {
        let points: Vec<(f64, f64)> =
            refined.runs.iter().zip(&refined.sizes).filter_map(|(row, size)| Some((*size, error(row)?))).collect();
        let order = refined.order.map(|o| format!(", order {o:.2}")).unwrap_or_default();
        let others = if refined.at.is_empty() { String::new() } else { format!(", {}", refined.at) };
        ChartSeries::new(format!("{}{others}{order}", refined.along), SeriesForm::Line, points)
    };
    let refined = study.series.iter().map(|s| RefinementRecord::of(study, s));
    let lines = refined.map(|refined| (line(&refined), refined)).filter(|l| !l.0.points.is_empty());
    let lines: Vec<(ChartSeries, RefinementRecord<'_>)> = lines.take(MOST_LINES).collect();
    let guides = lines.first().map_or(Vec::new(), |(line, refined)| slopes(line, refined));
    let series = lines.into_iter().map(|l| l.0).chain(guides).collect();
    logarithmic(title, ["size relative to the finest", "error"], [String::new(), error_unit(study)], series)
}

/// Returns lines with the slopes of the observed and the formal order through the finest point of a line.
fn slopes(line: &ChartSeries, refined: &RefinementRecord<'_>) -> Vec<ChartSeries> {
    let (Some(&(coarsest, _)), Some(&(finest, error))) = (line.points.first(), line.points.last()) else {
        return Vec::new();
    };
    let guide = |order: f64, word: &str| {
        let end = error * libm::pow(coarsest / finest, order);
        let name = format!("slope of the {word} order {}", short(order));
        ChartSeries::new(name, SeriesForm::Guide, vec![(coarsest, end), (finest, error)])
    };
    let observed = refined.order.map(|order| guide(order, "observed"));
    observed.into_iter().chain([guide(refined.formal_order, "formal")]).filter(|_| coarsest > finest).collect()
}

/// Largest number of lines of the chart.
const MOST_LINES: usize = 12;

fn logarithmic(title: &str, labels: [&str; 2], units: [String; 2], series: Vec<ChartSeries>) -> Chart {
    Chart { units, scale: AxisScale::LogLog, ..Chart::new(title, labels, series) }
}

fn error_unit(study: &RefinementStudy) -> String {
    if study.scale.is_some() { "%".into() } else { String::new() }
}

fn family_name(study: &RefinementStudy, row: usize) -> String {
    let refined: Vec<&str> = study.series.iter().flat_map(|s| s.along.split(" and ")).collect();
    let name = setting_without(study, row, &refined);
    if name.is_empty() { "settings".into() } else { name }
}

/// Returns the lines below the table of a study of a quantity.
pub fn conclusions(completed: &CompletedStudy, quantity: &str) -> Vec<String> {
    let study = &completed.study;
    let mut lines = Vec::new();
    if let Some(reference) = study.reference {
        lines.push(match reference.row {
            None => format!("reference: exact value {}", digits(reference.value, 9)),
            Some(row) => format!(
                "estimated limit {} (from {}), uncertainty {}{}",
                digits(reference.value, 7),
                setting(study, row),
                short(reference.uncertainty),
                study.scale.map_or(String::new(), |s| format!(" ({} %)", short(100.0 * reference.uncertainty / s)))
            ),
        });
    }
    lines.extend(wide_estimates(study));
    lines.extend(study.noise.iter().flat_map(|noise| noise.conclusions(quantity)));
    lines.extend(disagreement(study));
    let sentence = price::sentence(study);
    if !sentence.is_empty() {
        lines.push(sentence);
    }
    lines.extend(completed.target.as_ref().map(|target| of_target(study, target)));
    lines
}

/// Returns why the estimate of the limit is wide, with the properties of the model that can be the cause.
fn wide_estimates(study: &RefinementStudy) -> Vec<String> {
    let Some(row) = study.reference.and_then(|r| r.row) else { return Vec::new() };
    let mut lines: Vec<String> = Vec::new();
    for behaviour in study.rows[row].estimates.iter().flatten().map(|e| e.behaviour) {
        let Some(reason) = behaviour.reason() else { continue };
        let causes = if behaviour.concerns_model() && !study.causes.is_empty() {
            format!("; possible causes in this deck: {}", study.causes.join(", "))
        } else {
            String::new()
        };
        lines.push(format!("wide uncertainty: {reason}{causes}"));
    }
    lines.dedup();
    lines
}

/// Returns a line for each family whose values disagree with the reference: it has another limit, or is not yet
/// asymptotic.
fn disagreement(study: &RefinementStudy) -> Vec<String> {
    let Some(reference) = study.reference else { return Vec::new() };
    let last = |s: &super::refinement::RefinementSeries| s.rows.last().copied();
    let mut lines = Vec::new();
    for row in study.series.iter().filter_map(last) {
        let r = &study.rows[row];
        let (Some(value), Some(uncertainty), [_]) = (r.value, r.uncertainty, &r.estimates[..]) else { continue };
        let gap = (value - reference.value).abs();
        if gap > uncertainty + reference.uncertainty {
            lines.push(format!(
                "{}: differs by {} from the reference, more than the uncertainty {}: not yet asymptotic, or a different limit",
                setting(study, row),
                short(gap),
                short(uncertainty)
            ));
        }
    }
    lines
}

fn of_target(study: &RefinementStudy, met: &TargetResult) -> String {
    let target = price::tolerance_in_words(met.target.value, met.target.relative);
    match met.run.and_then(|row| Some((row, study.rows[row].run.as_ref().ok()?))) {
        Some((row, run)) => {
            format!("target {target}: reached by {} in {}", setting(study, row), duration(run.seconds.median))
        }
        None => format!(
            "target {target}: not reached by the given levels and up to {EXTRA_LEVELS} finer ones of at most {MOST_CYCLES:e} \
             element-cycles each"
        ),
    }
}
