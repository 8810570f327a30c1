//! A study as table, CSV, JSON with stable keys, and charts.

use indexmap::IndexMap;
use serde::Serialize;

use super::chart::{Chart, Form, Scale, Series};
use super::effects::Effects;
use super::price::{self, Price, setting};
use super::refinement::{Reference, Study, StudyRow};
use super::richardson::{FORMAL_ORDER, LimitEstimate};
use super::runner::TimeSpread;
use super::table::{Table, cell, digits, duration, short};
use super::target::{BEYOND, MOST_CYCLES, TargetResult};

/// What `<job>_study.json` holds. The keys are stable.
#[derive(Clone, Debug, Serialize)]
pub struct StudyRecord<'a> {
    /// The quantity as written.
    pub quantity: &'a str,
    /// The exact value, if one was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exact: Option<f64>,
    /// What errors are measured from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<Reference>,
    /// What makes errors relative; absent where the reference is zero.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// All settings, in the order in which they ran.
    pub runs: Vec<RunRecord<'a>>,
    /// What converges.
    pub refinements: Vec<RefinementRecord<'a>>,
    /// Indices of the runs that no other beats in both time and error.
    pub front: Vec<usize>,
    /// What an accuracy costs.
    pub prices: Vec<Price>,
    /// The same in a line.
    pub sentence: String,
    /// Whether `--target` was met.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<TargetResult>,
    /// What the study took.
    pub timing: StudyTiming,
    /// The program's version.
    pub version: &'static str,
}

/// Runs that differ in the size of one thing.
#[derive(Clone, Debug, Serialize)]
pub struct RefinementRecord<'a> {
    /// What is refined.
    pub along: &'a str,
    /// The other values of its setting, as written; empty where there are none.
    pub at: String,
    /// Indices of runs, from the coarsest on.
    pub runs: &'a [usize],
    /// Size of each over that of the finest.
    pub sizes: Vec<f64>,
    /// Observed order, where one is to be seen.
    pub order: Option<f64>,
    /// The order of the method.
    pub formal_order: f64,
}

impl<'a> RefinementRecord<'a> {
    fn of(study: &'a Study, series: &'a super::refinement::RefinementSeries) -> RefinementRecord<'a> {
        let finest = series.sizes.last().copied().unwrap_or(1.0);
        let at = series.rows.first().map_or(String::new(), |&r| setting_but(study, r, &series.along));
        RefinementRecord {
            along: &series.along,
            at,
            runs: &series.rows,
            sizes: series.sizes.iter().map(|size| size / finest).collect(),
            order: series.estimate.and_then(|e| e.order),
            formal_order: FORMAL_ORDER,
        }
    }
}

/// What `<job>_study.json` holds after `--ablate`. The keys are stable.
#[derive(Clone, Debug, Serialize)]
pub struct AblationRecord<'a> {
    /// The quantity as written.
    pub quantity: &'a str,
    /// Each effect left out.
    pub ablation: &'a Effects,
    /// The program's version.
    pub version: &'static str,
}

/// The record of effects left out.
pub fn ablation<'a>(quantity: &'a str, effects: &'a Effects) -> AblationRecord<'a> {
    AblationRecord { quantity, ablation: effects, version: env!("CARGO_PKG_VERSION") }
}

/// What a study took.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StudyTiming {
    /// Seconds in all runs, deck to last increment.
    pub runs: f64,
    /// Seconds of the study from its first run to its results, files aside.
    pub total: f64,
    /// How often each setting ran.
    pub repeat: usize,
}

/// One setting.
#[derive(Clone, Debug, Serialize)]
pub struct RunRecord<'a> {
    /// Value of each axis, as written.
    pub setting: IndexMap<&'a str, &'a str>,
    /// Why there is no value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
    /// The quantity.
    pub value: Option<f64>,
    /// Difference from the reference.
    pub error: Option<f64>,
    /// What its size is below.
    pub bound: Option<f64>,
    /// By each series: order, behaviour, limit, uncertainty and factor of safety.
    pub estimates: &'a [Option<LimitEstimate>],
    /// Order of the last two errors against the exact value, by series.
    #[serde(skip_serializing_if = "<[Option<f64>]>::is_empty")]
    pub exact_orders: &'a [Option<f64>],
    /// Grid convergence index of all series together.
    pub uncertainty: Option<f64>,
    /// Increments.
    pub increments: Option<u64>,
    /// Elements and facets.
    pub elements: Option<usize>,
    /// Their product.
    pub element_cycles: Option<f64>,
    /// Seconds of the whole run: median, shortest, longest.
    pub seconds: Option<TimeSpread>,
    /// Seconds in the time loop.
    pub loop_seconds: Option<TimeSpread>,
    /// What the run warns of.
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    pub warnings: &'a [String],
}

/// The record of a study.
pub fn record<'a>(
    quantity: &'a str,
    exact: Option<f64>,
    study: &'a Study,
    target: Option<TargetResult>,
    timing: StudyTiming,
) -> StudyRecord<'a> {
    StudyRecord {
        quantity,
        exact,
        reference: study.reference,
        scale: study.scale,
        runs: study.rows.iter().map(|r| run(study, r)).collect(),
        refinements: study.series.iter().map(|series| RefinementRecord::of(study, series)).collect(),
        front: price::front(study),
        prices: price::list(study),
        sentence: price::sentence(study),
        target,
        timing,
        version: env!("CARGO_PKG_VERSION"),
    }
}

fn run<'a>(study: &'a Study, row: &'a StudyRow) -> RunRecord<'a> {
    let ran = row.run.as_ref().ok();
    RunRecord {
        setting: study.axes.iter().map(String::as_str).zip(row.values.iter().map(String::as_str)).collect(),
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
        warnings: ran.map_or(&[], |r| &r.doubts),
    }
}

/// The table of a study, in few digits or in all.
pub fn table(study: &Study, all_digits: bool) -> Table {
    let unit = if study.scale.is_some() { "%" } else { "" };
    let mut header: Vec<String> = study.axes.clone();
    let columns = ["value", "error", "error below", "order", "limit", "GCI", "increments", "element-cycles"];
    header.extend(columns.iter().map(|c| match *c {
        "error" | "error below" | "GCI" if study.scale.is_some() => format!("{c} {unit}"),
        c => c.to_owned(),
    }));
    header.extend(["time ms", "time min ms", "time max ms", "note"].map(String::from));
    let front = price::front(study);
    let rows = study.rows.iter().enumerate();
    let rows = rows.map(|(i, row)| cells(study, row, front.contains(&i), all_digits)).collect();
    Table { header, rows }
}

fn cells(study: &Study, row: &StudyRow, on_front: bool, all_digits: bool) -> Vec<String> {
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
    if !run.doubts.is_empty() {
        words.push("warned");
    }
    words.join(", ")
}

/// Error against time, one series for each family, with the front drawn through.
pub fn price_chart(study: &Study, title: &str) -> Chart {
    let factor = study.scale.map_or(1.0, |s| 100.0 / s);
    let point = |row: usize| {
        let r = &study.rows[row];
        let seconds = r.run.as_ref().ok()?.seconds.median;
        r.bound.map(|b| (1e3 * seconds, factor * b)).filter(|p| p.0 > 0.0 && p.1 > 0.0)
    };
    let front = price::front(study).into_iter().filter_map(point).collect();
    let mut series = vec![Series::new("no setting beats these", Form::Line, front)];
    for family in 0..=study.rows.iter().map(|r| r.family).max().unwrap_or(0) {
        let rows: Vec<usize> = (0..study.rows.len()).filter(|&i| study.rows[i].family == family).collect();
        let points: Vec<(f64, f64)> = rows.iter().filter_map(|&i| point(i)).collect();
        if let Some(&first) = rows.first().filter(|_| !points.is_empty()) {
            series.push(Series::new(family_name(study, first), Form::Marks, points));
        }
    }
    logarithmic(title, ["time", "error"], ["ms".into(), error_unit(study)], series)
}

/// Error over size of what is refined, one series for each, and the slopes of the orders through the finest point of the first.
pub fn order_chart(study: &Study, title: &str) -> Chart {
    let factor = study.scale.map_or(1.0, |s| 100.0 / s);
    let error = |row: &usize| study.rows[*row].error.map(|e| factor * e.abs()).filter(|e| *e > 0.0);
    let line = |refined: &RefinementRecord<'_>| {
        let points: Vec<(f64, f64)> =
            refined.runs.iter().zip(&refined.sizes).filter_map(|(row, size)| Some((*size, error(row)?))).collect();
        let order = refined.order.map(|o| format!(", order {o:.2}")).unwrap_or_default();
        let others = if refined.at.is_empty() { String::new() } else { format!(", {}", refined.at) };
        Series::new(format!("{}{others}{order}", refined.along), Form::Line, points)
    };
    let refined = study.series.iter().map(|s| RefinementRecord::of(study, s));
    let lines = refined.map(|refined| (line(&refined), refined)).filter(|l| !l.0.points.is_empty());
    let lines: Vec<(Series, RefinementRecord<'_>)> = lines.take(MOST_LINES).collect();
    let guides = lines.first().map_or(Vec::new(), |(line, refined)| slopes(line, refined));
    let series = lines.into_iter().map(|l| l.0).chain(guides).collect();
    logarithmic(title, ["size over the finest", "error"], [String::new(), error_unit(study)], series)
}

/// Straight lines of the observed and the formal order through the finest point of a line.
fn slopes(line: &Series, refined: &RefinementRecord<'_>) -> Vec<Series> {
    let (Some(&(coarsest, _)), Some(&(finest, error))) = (line.points.first(), line.points.last()) else {
        return Vec::new();
    };
    let guide = |order: f64, word: &str| {
        let end = error * libm::pow(coarsest / finest, order);
        let name = format!("slope of the {word} order {}", short(order));
        Series::new(name, Form::Guide, vec![(coarsest, end), (finest, error)])
    };
    let observed = refined.order.map(|order| guide(order, "observed"));
    observed.into_iter().chain([guide(refined.formal_order, "formal")]).filter(|_| coarsest > finest).collect()
}

/// More lines than this are no picture.
const MOST_LINES: usize = 12;

fn logarithmic(title: &str, labels: [&str; 2], units: [String; 2], series: Vec<Series>) -> Chart {
    Chart { units, scale: Scale::LogLog, ..Chart::new(title, labels, series) }
}

fn error_unit(study: &Study) -> String {
    if study.scale.is_some() { "%".into() } else { String::new() }
}

fn family_name(study: &Study, row: usize) -> String {
    let mut refined: Vec<&str> = study.series.iter().flat_map(|s| s.along.split(" and ")).collect();
    refined.dedup();
    let of = study.axes.iter().zip(&study.rows[row].values).filter(|(name, _)| !refined.contains(&name.as_str()));
    let name = of.map(|(name, value)| format!("{name} = {value}")).collect::<Vec<_>>().join(", ");
    if name.is_empty() { "settings".into() } else { name }
}

fn setting_but(study: &Study, row: usize, along: &str) -> String {
    let skip: Vec<&str> = along.split(" and ").collect();
    let of = study.axes.iter().zip(&study.rows[row].values).filter(|(name, _)| !skip.contains(&name.as_str()));
    of.map(|(name, value)| format!("{name} = {value}")).collect::<Vec<_>>().join(", ")
}

/// What is said under the table, a line each.
pub fn conclusions(study: &Study, target: Option<&TargetResult>) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some(reference) = study.reference {
        lines.push(match reference.row {
            None => format!("errors from the exact value {}", digits(reference.value, 9)),
            Some(row) => format!(
                "limit {} (from {}), expected within {} of the finest value{}",
                digits(reference.value, 7),
                setting(study, row),
                short(reference.uncertainty),
                study.scale.map_or(String::new(), |s| format!(" ({} %)", short(100.0 * reference.uncertainty / s)))
            ),
        });
    }
    lines.extend(disagreement(study));
    let sentence = price::sentence(study);
    if !sentence.is_empty() {
        lines.push(sentence);
    }
    lines.extend(target.map(|met| of_target(study, met)));
    lines
}

/// Families whose own limit lies outside of what the reference allows: they converge to something else, or not yet.
fn disagreement(study: &Study) -> Vec<String> {
    let Some(reference) = study.reference else { return Vec::new() };
    let last = |s: &super::refinement::RefinementSeries| s.rows.last().copied();
    let mut lines = Vec::new();
    for row in study.series.iter().filter_map(last) {
        let r = &study.rows[row];
        let (Some(value), Some(uncertainty), [_]) = (r.value, r.uncertainty, &r.estimates[..]) else { continue };
        let gap = (value - reference.value).abs();
        if gap > uncertainty + reference.uncertainty {
            lines.push(format!(
                "{}: {} from the reference, but only {} is expected: not yet asymptotic, or another limit",
                setting(study, row),
                short(gap),
                short(uncertainty)
            ));
        }
    }
    lines
}

fn of_target(study: &Study, met: &TargetResult) -> String {
    let target = price::tolerance_in_words(met.target.value, met.target.relative);
    match met.run.and_then(|row| Some((row, study.rows[row].run.as_ref().ok()?))) {
        Some((row, run)) => {
            format!("target {target}: held by {} in {}", setting(study, row), duration(run.seconds.median))
        }
        None => format!(
            "target {target}: not reached by the levels given and at most {BEYOND} more of at most {MOST_CYCLES:e} \
             element-cycles each"
        ),
    }
}
