//! `--target`: refines level by level until the error is below the target, then selects the cheapest setting that meets
//! it.

use serde::Serialize;

use super::StudyError;
use super::price;
use super::refinement::{RefinementSeries, RefinementStudy, StudyRow, evaluate_errors, families};
use super::richardson::{ConvergenceBehaviour, FORMAL_ORDER};
use super::runner::StudyRunner;
use super::settings::{StudyAxis, StudyParameter};

/// Largest number of levels added to the given ones.
pub const EXTRA_LEVELS: usize = 4;
/// Smallest number of levels from which a target is met without an exact value.
const LEAST_LEVELS: usize = 3;
/// Limit of element-cycles (a few minutes) above which no level is added.
pub const MOST_CYCLES: f64 = 1e10;
/// Ratio of the element-cycles of the first two levels, before it is known: twice as many elements in each direction, and
/// half the increment.
const FIRST_RATIO: f64 = 8.0;
/// Fraction of the target for which a setting between two levels is chosen.
const MARGIN: f64 = 0.9;

/// Error target of a study, given by `--target`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorTarget {
    /// Largest allowed error.
    pub value: f64,
    /// Whether the error is relative to the exact value or the limit.
    pub relative: bool,
}

impl ErrorTarget {
    /// Parses `0.5%` (relative) or `1e-6` (in the units of the quantity).
    pub fn parse(text: &str) -> Result<ErrorTarget, StudyError> {
        let (number, relative) = match text.trim().strip_suffix('%') {
            Some(number) => (number.trim(), true),
            None => (text.trim(), false),
        };
        let value = number.parse::<f64>().ok().filter(|v| *v > 0.0 && v.is_finite());
        let wrong =
            || StudyError::Setting(format!("--target {text}: expected an error above zero, for example 0.5% or 1e-6"));
        let value = value.ok_or_else(wrong)?;
        Ok(ErrorTarget { value: if relative { value / 100.0 } else { value }, relative })
    }

    /// Returns the error in the units of the quantity; `None` if it is relative and the reference is zero or unknown.
    pub fn bound(&self, study: &RefinementStudy) -> Option<f64> {
        if self.relative { study.scale.map(|s| s * self.value) } else { Some(self.value) }
    }
}

/// Result of an error target.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TargetResult {
    /// Error target that was requested.
    pub target: ErrorTarget,
    /// Row of the cheapest setting that meets the target; `None` if none does.
    pub run: Option<usize>,
}

impl TargetResult {
    /// Selects the cheapest setting that meets the target. Settings coarser than the second finest level of their
    /// family are excluded: their values can agree with finer ones by chance.
    pub fn of(target: ErrorTarget, study: &RefinementStudy) -> TargetResult {
        let coarse: Vec<usize> = study.series.iter().flat_map(|s| s.rows.iter().rev().skip(2).copied()).collect();
        let run = target.bound(study).and_then(|bound| price::cheapest(study, bound, &coarse));
        TargetResult { target, run }
    }
}

/// Levels of one family, in which all refined parameters advance together.
struct LevelSequence<'a> {
    axes: &'a [StudyAxis],
    family: Vec<(usize, String)>,
}

impl LevelSequence<'_> {
    /// Returns the number of given levels.
    fn given(&self) -> usize {
        self.axes.iter().filter(|a| a.is_refinement()).map(|a| a.sizes.len()).min().unwrap_or(0)
    }

    /// Returns the size of an axis at a level; added levels have the size ratio of the last two given levels.
    fn size(axis: &StudyAxis, level: usize) -> f64 {
        let last = axis.sizes.len() - 1;
        let ratio = axis.sizes[last] / axis.sizes[last - 1];
        axis.sizes.get(level).copied().unwrap_or_else(|| axis.sizes[last] * ratio.powi((level - last) as i32))
    }

    /// Returns the value of each axis at a level, with sizes multiplied by a factor.
    fn values(&self, level: usize, factor: f64) -> Vec<String> {
        let value = |(index, axis): (usize, &StudyAxis)| {
            let choice = self.family.iter().find(|(i, _)| *i == index);
            match choice {
                Some((_, value)) => value.clone(),
                None if factor == 1.0 && level < axis.values.len() => axis.values[level].clone(),
                None => between(axis, factor * Self::size(axis, level)),
            }
        };
        self.axes.iter().enumerate().map(value).collect()
    }

    /// Returns the size of the first refined parameter at a level; the order of convergence refers to it.
    fn leading(&self, level: usize) -> f64 {
        self.axes.iter().find(|a| a.is_refinement()).map_or(1.0, |a| Self::size(a, level))
    }
}

/// Returns a value with the given size or a finer one. Counts remain integers, and even if all given values are even.
fn between(axis: &StudyAxis, size: f64) -> String {
    let value = axis.value(size);
    if axis.parameter == StudyParameter::Mesh {
        let parts = |x: f64| (x * (1.0 - 1e-9)).ceil();
        return if value > 1.0 { parts(value).to_string() } else { (1.0 / (1.0 / value + 1e-9).floor()).to_string() };
    }
    if !axis.counts() {
        return format!("{value:e}");
    }
    let even = axis.values.iter().all(|v| v.parse::<u64>().is_ok_and(|v| v % 2 == 0));
    let step = if even { 2.0 } else { 1.0 };
    format!("{}", (value / step * (1.0 - 1e-9)).ceil() * step)
}

/// Refines all parameters together, family by family, until the error is below the target.
pub fn refine_to_target(
    bench: &mut StudyRunner<'_>,
    axes: &[StudyAxis],
    exact: Option<f64>,
    target: ErrorTarget,
) -> Result<(RefinementStudy, TargetResult), StudyError> {
    let wrong = |why: &str| StudyError::Setting(why.into());
    let mut counts = axes.iter().filter(|a| a.is_refinement()).map(|a| a.sizes.len());
    let first = counts.next().ok_or_else(|| wrong("--target needs a --refine with numeric levels"))?;
    if counts.any(|c| c != first) {
        return Err(wrong("with --target all --refine options must have the same number of levels"));
    }
    let mut whole = RefinementStudy::empty(axes);
    for (index, family) in families(axes).into_iter().enumerate() {
        let climbed = refine_family(bench, &LevelSequence { axes, family }, exact, target, index);
        let row_offset = whole.rows.len();
        whole.rows.extend(climbed.rows);
        whole.series.extend(climbed.series.into_iter().map(|mut s| {
            s.rows.iter_mut().for_each(|r| *r += row_offset);
            s
        }));
    }
    evaluate_errors(&mut whole, exact, bench.measure().is_norm());
    let result = TargetResult::of(target, &whole);
    Ok((whole, result))
}

/// Refines one family level by level, then tries a setting between levels.
fn refine_family(
    bench: &mut StudyRunner<'_>,
    ladder: &LevelSequence<'_>,
    exact: Option<f64>,
    target: ErrorTarget,
    family: usize,
) -> RefinementStudy {
    let along: Vec<&str> = ladder.axes.iter().filter(|a| a.is_refinement()).map(|a| a.name.as_str()).collect();
    let series = RefinementSeries { along: along.join(" and "), rows: Vec::new(), sizes: Vec::new(), estimate: None };
    let mut study = RefinementStudy { series: vec![series], ..RefinementStudy::default() };
    let norm = bench.measure().is_norm();
    let inside = |study: &RefinementStudy, row: usize| {
        let bound = match exact {
            Some(_) => study.rows[row].bound,
            None => study.rows[row].uncertainty.filter(|_| row + 1 >= LEAST_LEVELS),
        };
        bound.zip(target.bound(study)).is_some_and(|(found, allowed)| found <= allowed)
    };
    for level in 0..ladder.given() + EXTRA_LEVELS {
        let cycles = next_cycles(&study);
        if level >= ladder.given() && cycles.is_some_and(|c| c > MOST_CYCLES) {
            break;
        }
        let values = ladder.values(level, 1.0);
        let last = study.rows.last().and_then(|row| row.run.as_ref().ok());
        if !bench.affords(last, &format!("level {}", values.join(", ")), cycles) {
            break;
        }
        let run = bench.at(ladder.axes, &values, None);
        let failed = run.is_err();
        study.rows.push(StudyRow::new(values, run, 0));
        study.series[0].rows.push(level);
        study.series[0].sizes.push(ladder.leading(level));
        evaluate_errors(&mut study, exact, norm);
        if inside(&study, level) || failed {
            break;
        }
    }
    try_intermediate(bench, ladder, exact, target, &mut study);
    study.rows.iter_mut().for_each(|r| r.family = family);
    study
}

/// Estimates the element-cycles of the next level from the ratio of the last two.
fn next_cycles(study: &RefinementStudy) -> Option<f64> {
    let cycles = |row: &StudyRow| row.run.as_ref().ok().map(|r| r.element_cycles());
    match &study.rows[..] {
        [.., a, b] => Some(cycles(b)? * cycles(b)? / cycles(a)?),
        [a] => Some(FIRST_RATIO * cycles(a)?),
        _ => None,
    }
}

/// Runs the coarsest setting that should meet the target by the observed order, if it is coarser than the level that
/// meets it.
fn try_intermediate(
    bench: &mut StudyRunner<'_>,
    ladder: &LevelSequence<'_>,
    exact: Option<f64>,
    target: ErrorTarget,
    study: &mut RefinementStudy,
) {
    let Some(factor) = coarser(study, exact, target) else { return };
    let finest = study.series[0].rows.len() - 1;
    let values = ladder.values(finest, factor);
    if study.rows.iter().any(|r| r.values == values) {
        return;
    }
    let run = bench.at(ladder.axes, &values, None);
    study.rows.push(StudyRow::new(values, run, 0));
    evaluate_errors(study, exact, bench.measure().is_norm());
}

/// Returns the size, relative to the finest level, of the coarsest setting that should meet the target, at most that of
/// the second finest level; `None` if it cannot be estimated or is not coarser than a level that meets the target.
fn coarser(study: &RefinementStudy, exact: Option<f64>, target: ErrorTarget) -> Option<f64> {
    let series = &study.series[0];
    let finest = *series.rows.last()?;
    let allowed = target.bound(study)?;
    let row = &study.rows[finest];
    let (error, uncertainty, order) = match exact {
        Some(_) => (row.error?.abs(), 0.0, row.exact_orders.last().copied().flatten().unwrap_or(FORMAL_ORDER)),
        None => {
            let estimate = series.estimate.filter(|e| e.behaviour != ConvergenceBehaviour::Oscillating)?;
            let error = (row.value? - estimate.limit).abs();
            (error, estimate.uncertainty - error, estimate.order.unwrap_or(FORMAL_ORDER))
        }
    };
    let share = MARGIN * (allowed - uncertainty) / error;
    let factor = libm::pow(share, 1.0 / order.clamp(0.5, FORMAL_ORDER));
    let second = series.rows.len().checked_sub(2)?;
    let holds = |i: &usize| study.rows[series.rows[*i]].bound.is_some_and(|b| b <= allowed);
    let coarsest = (second..series.rows.len()).find(holds)?;
    let ratio = |level: usize| series.sizes[level] / series.sizes[series.sizes.len() - 1];
    let factor = factor.min(ratio(second));
    (factor.is_finite() && factor > 1.05 * ratio(coarsest)).then_some(factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_are_relative_or_in_the_units_of_the_quantity() {
        assert_eq!(ErrorTarget::parse("0.5%"), Ok(ErrorTarget { value: 0.005, relative: true }));
        assert_eq!(ErrorTarget::parse(" 1e-6"), Ok(ErrorTarget { value: 1e-6, relative: false }));
        for wrong in ["", "%", "0%", "-1", "x", "inf"] {
            assert!(ErrorTarget::parse(wrong).is_err(), "{wrong}");
        }
    }
}
