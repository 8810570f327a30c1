//! `--target`: one level after the other until the error is inside, then the cheapest setting that holds it.

use serde::Serialize;

use super::StudyError;
use super::price;
use super::refinement::{RefinementSeries, Study, StudyRow, families, judge};
use super::richardson::{Behaviour, FORMAL_ORDER};
use super::runner::StudyRunner;
use super::settings::Axis;

/// Levels beyond those given.
pub const BEYOND: usize = 4;
/// A level beyond those given is not begun if it is expected to take more element-cycles: some minutes.
pub const MOST_CYCLES: f64 = 1e10;
/// Fraction of the target that a setting between two levels is aimed at.
const MARGIN: f64 = 0.9;

/// An error aimed at.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Target {
    /// The number.
    pub value: f64,
    /// Whether it is relative to the exact value or the limit.
    pub relative: bool,
}

impl Target {
    /// Reads `0.5%` (relative) or `1e-6` (in the units of the quantity).
    pub fn parse(text: &str) -> Result<Target, StudyError> {
        let (number, relative) = match text.trim().strip_suffix('%') {
            Some(number) => (number.trim(), true),
            None => (text.trim(), false),
        };
        let value = number.parse::<f64>().ok().filter(|v| *v > 0.0 && v.is_finite());
        let wrong = || StudyError::Setting(format!("--target {text}: 0.5% or an error above zero is the form"));
        let value = value.ok_or_else(wrong)?;
        Ok(Target { value: if relative { value / 100.0 } else { value }, relative })
    }

    /// The error in the units of the quantity; `None` where it is relative to nothing.
    pub fn bound(&self, study: &Study) -> Option<f64> {
        if self.relative { study.scale.map(|s| s * self.value) } else { Some(self.value) }
    }
}

/// Whether a target was met.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TargetResult {
    /// What was aimed at.
    pub target: Target,
    /// Row of the cheapest setting that holds it; `None` where none does.
    pub run: Option<usize>,
}

/// Levels that go together over all refinements.
struct LevelLadder<'a> {
    axes: &'a [Axis],
    family: Vec<(usize, String)>,
}

impl LevelLadder<'_> {
    /// Levels that were given.
    fn given(&self) -> usize {
        self.axes.iter().filter(|a| a.is_refinement()).map(|a| a.sizes.len()).min().unwrap_or(0)
    }

    /// Size of one axis at a level; beyond those given by the ratio of the last two.
    fn size(axis: &Axis, level: usize) -> f64 {
        let last = axis.sizes.len() - 1;
        let ratio = axis.sizes[last] / axis.sizes[last - 1];
        axis.sizes.get(level).copied().unwrap_or_else(|| axis.sizes[last] * ratio.powi((level - last) as i32))
    }

    /// One value for each axis, where refinements have the size of a level times a factor.
    fn values(&self, level: usize, factor: f64) -> Vec<String> {
        let value = |(index, axis): (usize, &Axis)| {
            let choice = self.family.iter().find(|(i, _)| *i == index);
            match choice {
                Some((_, value)) => value.clone(),
                None if factor == 1.0 && level < axis.values.len() => axis.values[level].clone(),
                None => between(axis, factor * Self::size(axis, level)),
            }
        };
        self.axes.iter().enumerate().map(value).collect()
    }

    /// Size of the first refinement at a level: the one that orders are observed on.
    fn leading(&self, level: usize) -> f64 {
        self.axes.iter().find(|a| a.is_refinement()).map_or(1.0, |a| Self::size(a, level))
    }
}

/// A value of that size or finer; a count stays whole, and even where all given are.
fn between(axis: &Axis, size: f64) -> String {
    let value = axis.value(size);
    if !axis.counts() {
        return format!("{value:e}");
    }
    let even = axis.values.iter().all(|v| v.parse::<u64>().is_ok_and(|v| v % 2 == 0));
    let step = if even { 2.0 } else { 1.0 };
    format!("{}", (value / step * (1.0 - 1e-9)).ceil() * step)
}

/// Refines all levels together, family by family, until the error is inside the target.
pub fn reach(
    bench: &mut StudyRunner<'_>,
    axes: &[Axis],
    exact: Option<f64>,
    target: Target,
) -> Result<(Study, TargetResult), StudyError> {
    let wrong = |why: &str| StudyError::Setting(why.into());
    let mut counts = axes.iter().filter(|a| a.is_refinement()).map(|a| a.sizes.len());
    let first = counts.next().ok_or_else(|| wrong("--target needs a --refine with levels"))?;
    if counts.any(|c| c != first) {
        return Err(wrong("with --target all --refine go level by level together: give each as many levels"));
    }
    let mut whole = Study { axes: axes.iter().map(|a| a.name.clone()).collect(), ..Study::default() };
    for (index, family) in families(axes).into_iter().enumerate() {
        let climbed = climb(bench, &LevelLadder { axes, family }, exact, target, index);
        let before = whole.rows.len();
        whole.rows.extend(climbed.rows);
        whole.series.extend(climbed.series.into_iter().map(|mut s| {
            s.rows.iter_mut().for_each(|r| *r += before);
            s
        }));
    }
    judge(&mut whole, exact, bench.measure().is_norm());
    let run = target.bound(&whole).and_then(|bound| price::cheapest(&whole, bound));
    Ok((whole, TargetResult { target, run }))
}

/// One family: up the ladder, then a look between its levels.
fn climb(
    bench: &mut StudyRunner<'_>,
    ladder: &LevelLadder<'_>,
    exact: Option<f64>,
    target: Target,
    family: usize,
) -> Study {
    let along: Vec<&str> = ladder.axes.iter().filter(|a| a.is_refinement()).map(|a| a.name.as_str()).collect();
    let series = RefinementSeries { along: along.join(" and "), rows: Vec::new(), sizes: Vec::new(), estimate: None };
    let mut study = Study { series: vec![series], ..Study::default() };
    let norm = bench.measure().is_norm();
    let inside = |study: &Study, row: usize| {
        let bound = if exact.is_some() { study.rows[row].bound } else { study.rows[row].uncertainty };
        bound.zip(target.bound(study)).is_some_and(|(found, allowed)| found <= allowed)
    };
    for level in 0..ladder.given() + BEYOND {
        if level >= ladder.given() && next_cycles(&study).is_some_and(|c| c > MOST_CYCLES) {
            break;
        }
        let values = ladder.values(level, 1.0);
        let run = bench.at(ladder.axes, &values, None);
        let failed = run.is_err();
        study.rows.push(StudyRow::new(values, run, 0));
        study.series[0].rows.push(level);
        study.series[0].sizes.push(ladder.leading(level));
        judge(&mut study, exact, norm);
        if inside(&study, level) || failed {
            break;
        }
    }
    look_between(bench, ladder, exact, target, &mut study);
    study.rows.iter_mut().for_each(|r| r.family = family);
    study
}

/// Element-cycles of the next level by the ratio of the last two.
fn next_cycles(study: &Study) -> Option<f64> {
    let cycles = |row: &StudyRow| row.run.as_ref().ok().map(|r| r.element_cycles());
    match &study.rows[..] {
        [.., a, b] => Some(cycles(b)? * cycles(b)? / cycles(a)?),
        _ => None,
    }
}

/// The coarsest setting that the observed power lets hold the target, tried where it is coarser than the level that does.
fn look_between(
    bench: &mut StudyRunner<'_>,
    ladder: &LevelLadder<'_>,
    exact: Option<f64>,
    target: Target,
    study: &mut Study,
) {
    let Some(factor) = coarser(study, exact, target) else { return };
    let finest = study.series[0].rows.len() - 1;
    let values = ladder.values(finest, factor);
    if study.rows.iter().any(|r| r.values == values) {
        return;
    }
    let run = bench.at(ladder.axes, &values, None);
    study.rows.push(StudyRow::new(values, run, 0));
    judge(study, exact, bench.measure().is_norm());
}

/// How much coarser than the finest level a setting may be; `None` where nothing is known or nothing to be gained.
fn coarser(study: &Study, exact: Option<f64>, target: Target) -> Option<f64> {
    let series = &study.series[0];
    let finest = *series.rows.last()?;
    let allowed = target.bound(study)?;
    let row = &study.rows[finest];
    let (error, doubt, order) = match exact {
        Some(_) => (row.error?.abs(), 0.0, row.exact_orders.last().copied().flatten().unwrap_or(FORMAL_ORDER)),
        None => {
            let estimate = series.estimate.filter(|e| e.behaviour != Behaviour::Oscillating)?;
            let error = (row.value? - estimate.limit).abs();
            (error, estimate.uncertainty - error, estimate.order.unwrap_or(FORMAL_ORDER))
        }
    };
    let share = MARGIN * (allowed - doubt) / error;
    let factor = libm::pow(share, 1.0 / order.clamp(0.5, FORMAL_ORDER));
    let holds = |i: &usize| study.rows[series.rows[*i]].bound.is_some_and(|b| b <= allowed);
    let coarsest = (0..series.rows.len()).find(holds)?;
    let limit = series.sizes[coarsest] / series.sizes[series.sizes.len() - 1];
    (factor.is_finite() && factor > 1.05 * limit && coarsest > 0).then_some(factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_are_relative_or_in_the_units_of_the_quantity() {
        assert_eq!(Target::parse("0.5%"), Ok(Target { value: 0.005, relative: true }));
        assert_eq!(Target::parse(" 1e-6"), Ok(Target { value: 1e-6, relative: false }));
        for wrong in ["", "%", "0%", "-1", "x", "inf"] {
            assert!(Target::parse(wrong).is_err(), "{wrong}");
        }
    }
}
