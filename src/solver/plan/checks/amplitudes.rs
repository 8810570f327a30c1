//! Checks of amplitudes: times in other units than those of the steps.

use super::finding::warn_about;
use crate::model::{Amplitude, AmplitudeDefinition, AmplitudeId, Model};
use crate::plan::Report;

/// Change of an amplitude within the steps, as a fraction of its whole range, below which its times are assumed to be in
/// other units.
const HARDLY_CHANGES: f64 = 0.015;

/// Warns of amplitudes that hardly change in all steps that use them.
pub fn check_amplitudes(model: &Model, report: &mut Report) {
    for (index, amplitude) in model.amplitudes.iter().enumerate() {
        let AmplitudeDefinition::Curve { points, total_time, .. } = &amplitude.definition else { continue };
        let [from, to] = extremes(points.iter().map(|point| point[1]));
        let (mut start, mut used) = (0.0, None);
        for step in &model.steps {
            let is_it = |id: Option<AmplitudeId>| id.is_some_and(|id| id.index() == index);
            let begin = if *total_time { start } else { 0.0 };
            if step.boundaries.iter().any(|b| is_it(b.amplitude)) || step.loads.iter().any(|l| is_it(l.amplitude)) {
                let [low, high] = used.unwrap_or([f64::INFINITY, f64::NEG_INFINITY]);
                let [least, most] = range_within(points, begin, begin + step.duration);
                used = Some([least.min(low), most.max(high)]);
            }
            start += step.duration;
        }
        if let Some([least, most]) = used.filter(|[least, most]| most - least < HARDLY_CHANGES * (to - from)) {
            report_amplitude(amplitude, [least, most], [from, to], report);
        }
    }
}

fn report_amplitude(amplitude: &Amplitude, [least, most]: [f64; 2], [from, to]: [f64; 2], report: &mut Report) {
    let message = format!(
        "the steps end while amplitude `{}` has hardly changed: from {least:.4e} to {most:.4e}, and its values are {from:e} to {to:e}",
        amplitude.name
    );
    let help = "check that its times are in the unit of the steps";
    warn_about("P156", message, (amplitude.span, "this amplitude"), help, report);
}

/// Returns the smallest and largest value of a piecewise linear curve from one time to another.
fn range_within(points: &[[f64; 2]], from: f64, to: f64) -> [f64; 2] {
    let inside = points.iter().filter(|point| (from..=to).contains(&point[0])).map(|point| point[1]);
    extremes(inside.chain([value_at(points, from), value_at(points, to)]))
}

/// Returns the value of a piecewise linear curve, constant before its first and after its last point.
fn value_at(points: &[[f64; 2]], time: f64) -> f64 {
    let next = points.partition_point(|point| point[0] <= time);
    let (Some(before), Some(after)) = (points.get(next.saturating_sub(1)), points.get(next.min(points.len() - 1)))
    else {
        return 0.0;
    };
    let length = after[0] - before[0];
    let share = if length > 0.0 { ((time - before[0]) / length).clamp(0.0, 1.0) } else { 0.0 };
    before[1] + share * (after[1] - before[1])
}

fn extremes(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], value| [least.min(value), most.max(value)])
}
