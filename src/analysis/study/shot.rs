//! Shots at targets: how they end, from the events that the run records.

use serde::Serialize;

use super::StudyError;
use super::quantity::{FinishedRun, Quantity};
use crate::load::PenetrationOutcome;
use crate::output::RunHistory;
use crate::solve::{ImpactEnd, Instant};
use crate::state::BodyState;

/// End of a shot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ShotEnd {
    /// All bodies have left their targets through the rear face, or a piece of a meshed projectile has passed
    /// through its target.
    Perforation,
    /// No body has met a target.
    NotMet,
    /// A body has left a target through its front face, or a meshed projectile moves back.
    Ricochet,
    /// A body is at rest in a target, or moves at no more than [`CREEP`] of its initial velocity along z.
    Embedded,
    /// A body still moves in a target, or has not met the next one, or its residual velocity still falls.
    Moving,
    /// The residual velocity does not exceed that of `--least`.
    Slow,
    /// No connected piece of the projectile has a tenth of its mass: its elements have been deleted.
    Consumed,
}

/// Fraction of the initial velocity along z at which a body in a target counts as embedded. A body that would perforate
/// has a residual velocity of `a (v² - v_l²)^(1/2)` (Lambert and Jonas). It is below `CREEP v` if the striking velocity
/// exceeds the limit by less than the fraction `CREEP²/2`, so the limit velocity changes by no more than this fraction.
pub const CREEP: f64 = 0.01;

/// Smallest factor between the durations of the last step of successive runs of a shot that has not ended, and largest
/// factors on the duration in the deck: without an estimate of the remaining time, and with one.
const LONGER: f64 = 4.0;
const LONGEST: [f64; 2] = [16.0, 64.0];
/// Factor on the estimate of the remaining time, because projectiles are decelerated.
const MARGIN: f64 = 2.0;

/// Returns the factor on the duration of the last step with which a run is repeated after one with `factor`; `None` if
/// the shot has ended, or would not end within the largest factor. `remaining` is the remaining time of the shot over
/// the duration in the deck: zero if it has ended, infinite if it is unknown.
pub(super) fn longer(factor: f64, remaining: f64) -> Option<f64> {
    let is_known = factor + remaining <= LONGEST[1];
    let needed = if is_known { factor + MARGIN * remaining } else { 0.0 };
    let next = (LONGER * factor).max(needed).min(LONGEST[usize::from(is_known)]);
    (remaining > 0.0 && next > factor).then_some(next)
}

impl ShotEnd {
    /// Returns the text of messages and charts.
    pub fn words(self) -> &'static str {
        match self {
            ShotEnd::Perforation => "perforation",
            ShotEnd::NotMet => "target not met",
            ShotEnd::Ricochet => "ricochet",
            ShotEnd::Embedded => "embedded",
            ShotEnd::Moving => "still moving",
            ShotEnd::Slow => "residual velocity not above --least",
            ShotEnd::Consumed => "projectile consumed",
        }
    }

    /// All ends, in the order of their values.
    pub const ALL: [ShotEnd; 7] = [
        ShotEnd::Perforation,
        ShotEnd::NotMet,
        ShotEnd::Ricochet,
        ShotEnd::Embedded,
        ShotEnd::Moving,
        ShotEnd::Slow,
        ShotEnd::Consumed,
    ];
}

/// Result of a shot: its end with the speed of the body that decides it, and the quantities.
#[derive(Clone, Debug, PartialEq)]
pub struct FiredShot {
    /// End of the shot; `None` if projectile and target of the model cannot be distinguished.
    pub end: Option<ShotEnd>,
    /// Speed of the body at the end of the run, zero without an end.
    pub speed: f64,
    /// Quantities of the evaluator.
    pub values: Vec<f64>,
}

/// Result of a shot, or the error of its run.
pub type ShotResult = Result<FiredShot, StudyError>;

/// Part of the run at its end in which the residual velocity is judged.
const WINDOW: f64 = 0.2;
/// Relative decrease of the mean residual velocity between the halves of the window above which it still falls.
const SETTLED: f64 = 0.01;
/// Range of the residual velocity in the window, relative to its mean, above which vibrations hide its course.
const VIBRATION: f64 = 0.2;

/// Rule for the end of shots without a recorded end whose projectile and target cannot be distinguished.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ShotRule {
    /// Residual velocity that a perforation must exceed. A smaller velocity that falls cannot become a perforation.
    pub least: Option<f64>,
}

impl ShotRule {
    /// Returns whether the residual velocity is above `least` and still falls at the end of the run: over the rows of
    /// the last fifth, its mean over the second half is smaller than over the first half. A velocity that vibrates by
    /// more than a fifth of its mean may fall.
    pub fn may_fall(self, residual: &Quantity, history: &RunHistory, last: f64) -> bool {
        let (times, width) = (history.times(), history.columns.len());
        let &[begin, .., end] = times else { return false };
        if last <= self.least.unwrap_or(0.0) {
            return false;
        }
        let first = times.partition_point(|time| *time < end - WINDOW * (end - begin)).min(times.len() - 2);
        let mut part = RunHistory::of_sums(history.columns.clone());
        let mut values = Vec::new();
        for (row, time) in times.iter().enumerate() {
            let cells: Vec<f64> = (0..width).map(|column| history.cell(row, column)).collect();
            part.push(&Instant { total_time: *time, ..Instant::default() }, &cells);
            if row >= first {
                values.extend(residual.number(FinishedRun { history: &part, end: None }));
            }
        }
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let half = values.len() / 2;
        let [low, high] = [f64::min as fn(f64, f64) -> f64, f64::max].map(|f| values.iter().copied().fold(last, f));
        high - low > VIBRATION * mean(&values)
            || mean(&values[values.len() - half..]) < (1.0 - SETTLED) * mean(&values[..half])
    }
}

/// Number of cells by which [`encode`] extends a row of quantities.
pub(super) const CELLS: usize = 2;

/// Returns end and speed of a shot as cells of a table.
pub(super) fn encode(found: Option<(ShotEnd, f64)>) -> [f64; CELLS] {
    found.map_or([f64::NAN, 0.0], |(end, speed)| [f64::from(end as u8), speed])
}

/// Returns the shot of a row of quantities with the cells of [`encode`].
pub(super) fn decode(row: &[f64]) -> FiredShot {
    let (values, cells) = row.split_at(row.len() - CELLS);
    let end = ShotEnd::ALL.into_iter().find(|end| f64::from(*end as u8) == cells[0]);
    FiredShot { end, speed: cells[1], values: values.to_vec() }
}

/// Returns the end of a shot and the smallest speed of the bodies with this end; `None` if no body can meet a target.
/// `bodies` have their motion at the start.
pub(super) fn end(impacts: &[ImpactEnd], bodies: &[BodyState]) -> Option<(ShotEnd, f64)> {
    let striking = |body: usize| bodies.get(body).map_or(0.0, |body| body.velocity.abs());
    let end = |impact: &ImpactEnd| end_of(impact, impacts, striking(impact.body));
    let decisive = impacts.iter().map(end).max()?;
    let deciding = impacts.iter().filter(|impact| end(impact) == decisive);
    let speed = deciding.map(|impact| impact.speed).fold(f64::INFINITY, f64::min);
    Some((decisive, speed))
}

/// Returns the end of the impact of a body on one of its targets.
fn end_of(impact: &ImpactEnd, all: &[ImpactEnd], striking: f64) -> ShotEnd {
    let has_left = |other: &ImpactEnd| other.body == impact.body && other.outcome == PenetrationOutcome::Through;
    match impact.outcome {
        PenetrationOutcome::Through => ShotEnd::Perforation,
        PenetrationOutcome::NotMet if all.iter().any(has_left) => ShotEnd::Moving,
        PenetrationOutcome::NotMet => ShotEnd::NotMet,
        PenetrationOutcome::Ricochet => ShotEnd::Ricochet,
        PenetrationOutcome::AtRest => ShotEnd::Embedded,
        PenetrationOutcome::Moving if impact.speed <= CREEP * striking => ShotEnd::Embedded,
        PenetrationOutcome::Moving => ShotEnd::Moving,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn impact(body: usize, outcome: PenetrationOutcome, speed: f64) -> ImpactEnd {
        ImpactEnd { body, outcome, speed }
    }

    fn ended(impacts: &[ImpactEnd]) -> Option<ShotEnd> {
        let bodies = [500.0, 300.0].map(|velocity| BodyState { velocity, ..BodyState::default() });
        end(impacts, &bodies).map(|found| found.0)
    }

    #[test]
    fn slowest_outcome_of_all_bodies_decides() {
        use PenetrationOutcome::{AtRest, Moving, NotMet, Ricochet, Through};
        assert_eq!(ended(&[]), None);
        for (impacts, expected) in [
            (&[(0, Through, 90.0)][..], ShotEnd::Perforation),
            (&[(0, Ricochet, 90.0)], ShotEnd::Ricochet),
            (&[(0, Ricochet, 90.0), (1, Through, 200.0)], ShotEnd::Ricochet),
            (&[(0, Through, 90.0), (0, AtRest, 0.0)], ShotEnd::Embedded),
            (&[(0, Through, 90.0), (0, NotMet, 90.0)], ShotEnd::Moving),
            (&[(0, Through, 90.0), (1, NotMet, 300.0)], ShotEnd::NotMet),
            (&[(0, Moving, 5.1)], ShotEnd::Moving),
            (&[(0, Moving, 5.0)], ShotEnd::Embedded),
            (&[(1, Moving, 3.1)], ShotEnd::Moving),
        ] {
            let impacts: Vec<ImpactEnd> = impacts.iter().map(|i| impact(i.0, i.1, i.2)).collect();
            assert_eq!(ended(&impacts), Some(expected), "{impacts:?}");
        }
    }

    #[test]
    fn extensions_are_bounded() {
        for (remaining, expected) in
            [(f64::INFINITY, &[4.0, 16.0][..]), (0.0, &[]), (0.1, &[4.0, 16.0, 64.0]), (9.0, &[19.0, 64.0])]
        {
            let factors = std::iter::successors(longer(1.0, remaining), |factor| longer(*factor, remaining));
            assert_eq!(factors.collect::<Vec<_>>(), expected, "{remaining}");
        }
    }

    #[test]
    fn ends_survive_a_table() {
        for end in ShotEnd::ALL {
            let row: Vec<f64> = [1.5].into_iter().chain(encode(Some((end, 7.0)))).collect();
            assert_eq!(decode(&row), FiredShot { end: Some(end), speed: 7.0, values: vec![1.5] });
        }
        assert_eq!(decode(&encode(None)).end, None);
    }
}
