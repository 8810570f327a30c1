//! Shares of mass and time for which materials are beyond the range of their constants (`*MATERIAL RANGE`).

use super::outcome::{Outcome, RangeShare};
use super::run_state::RunState;
use crate::element::group::ElementGroup;
use crate::element::values;
use crate::kernel::shape::middle;
use crate::model::RangedQuantity;
use crate::plan::PlannedRange;
use crate::state::archive::Persist;
use crate::variables::Variable;

/// Largest number of increments between samples. Samples do not coincide with other checks.
const SAMPLE_EVERY: u64 = 16;

/// Mean change of the flow stress by extrapolation, or share beyond the range, above which a warning is issued. It is the
/// limit of hourglass energy and of energy lost in contact: a smaller one hardly changes integral results.
const NOTABLE: f64 = 0.05;

/// Sums over the samples of a range.
#[derive(Clone, Copy, Debug, Default, Persist)]
struct RangeSums {
    /// Weight beyond the range, and total weight.
    beyond: f64,
    total: f64,
    /// Sum of weight times change of the flow stress by extrapolation.
    changed: f64,
    /// Smallest and largest value so far; meaningless while `total` is zero.
    extremes: [f64; 2],
    /// Farthest value beyond the range, its distance from the range, place and total time.
    farthest: f64,
    distance: f64,
    place: [f64; 2],
    time: f64,
}

/// Samples of all ranges.
#[derive(Clone, Debug, Default, Persist)]
pub(super) struct RangeMonitor {
    /// Increment of the next sample; never without ranges.
    pub(super) next: u64,
    /// Total time of the previous sample.
    time: f64,
    sums: Vec<RangeSums>,
    /// Plastic strain of all elements with a range of the strain rate at the previous sample, by range.
    strains: Vec<Vec<f64>>,
}

impl RangeMonitor {
    /// Allocates the memory of samples, and records the plastic strains at the start.
    pub(super) fn prepare(&mut self, run: &RunState<'_>) {
        let ranges = &run.plan.ranges;
        self.sums.resize(ranges.len(), RangeSums::default());
        self.strains.resize(ranges.len(), Vec::new());
        for (range, strains) in ranges.iter().zip(&mut self.strains).filter(|(_, strains)| strains.is_empty()) {
            record_strains(range, run, strains);
        }
    }

    /// Adds a sample if one is due, or if `ends`.
    pub(super) fn sample(&mut self, run: &RunState<'_>, ends: bool) {
        let ranges = &run.plan.ranges;
        if ranges.is_empty() {
            self.next = u64::MAX;
        } else if ends || run.now.increment >= self.next {
            self.next = run.now.increment + SAMPLE_EVERY;
            let duration = run.now.total_time - std::mem::replace(&mut self.time, run.now.total_time);
            for (range, (sums, strains)) in ranges.iter().zip(self.sums.iter_mut().zip(&mut self.strains)) {
                add_sample(range, run, duration, (sums, strains));
            }
        }
    }

    /// Adds the results to the outcome, and warns of large shares.
    pub(super) fn finish(&mut self, run: &RunState<'_>, outcome: &mut Outcome) {
        self.sample(run, true);
        for (planned, sums) in run.plan.ranges.iter().zip(&self.sums).filter(|(_, sums)| sums.total > 0.0) {
            let (range, name) = (&planned.range, planned.range.quantity.name());
            let share = sums.beyond / sums.total;
            let change = range.quantity.is_argument_of_flow_stress().then_some(sums.changed / sums.total);
            outcome.ranges.push(RangeShare {
                material: planned.material.clone(),
                quantity: name,
                lower: Some(range.low).filter(|limit| limit.is_finite()),
                upper: Some(range.high).filter(|limit| limit.is_finite()),
                share,
                change,
                extremes: sums.extremes,
            });
            if change.unwrap_or(share) > NOTABLE {
                outcome.warn("R324", sums.warning(planned, change));
            }
        }
    }
}

impl RangeSums {
    fn warning(&self, planned: &PlannedRange, change: Option<f64>) -> String {
        let ([r, z], range, percent) = (self.place, &planned.range, |share: f64| format!("{:.1} %", 100.0 * share));
        let effect = change.map(|change| format!(", which changes the flow stress by {} on average", percent(change)));
        format!(
            "material {} is beyond the range of its constants for {} of its {}{}: {} {:.4e}, allowed {}, near (r = {r:.4e}, \
             z = {z:.4e}) at time {:.4e}. Results there are extrapolated: give constants that hold there, or extend \
             *MATERIAL RANGE if a source confirms it",
            planned.material,
            percent(self.beyond / self.total),
            range.quantity.basis(),
            effect.unwrap_or_default(),
            range.quantity.name(),
            self.farthest,
            range.limits(),
            self.time
        )
    }
}

/// Adds one sample of all elements of a range; `duration` is the time since the previous sample.
fn add_sample(
    planned: &PlannedRange,
    run: &RunState<'_>,
    duration: f64,
    (sums, strains): (&mut RangeSums, &mut Vec<f64>),
) {
    let (range, is_rate) = (&planned.range, planned.range.quantity == RangedQuantity::StrainRate);
    let groups = || planned.groups.iter().map(|&group| &*run.state.elements.groups[group]);
    // After a new mesh there is no earlier strain of the same element.
    if is_rate && strains.len() != groups().map(|group| group.len()).sum::<usize>() {
        return record_strains(planned, run, strains);
    }
    let elements = groups().flat_map(|group| (0..group.len()).map(move |element| (group, element)));
    for (index, (group, element)) in elements.enumerate() {
        if group.is_deleted(element) || duration <= 0.0 {
            continue;
        }
        let (value, weight) = if is_rate {
            let strain = plastic_strain(group, element);
            let increase = strain - std::mem::replace(&mut strains[index], strain);
            (increase / duration, increase)
        } else {
            let Some(value) = sampled_value(range.quantity, run, group, element) else { continue };
            (value, duration)
        };
        if weight <= 0.0 {
            continue;
        }
        let weight = weight * group.masses(element).into_iter().sum::<f64>();
        sums.extremes =
            if sums.total > 0.0 { [sums.extremes[0].min(value), sums.extremes[1].max(value)] } else { [value; 2] };
        sums.total += weight;
        let distance = (value - range.high).max(range.low - value);
        if distance > 0.0 {
            sums.beyond += weight;
            let temperature = sampled_value(RangedQuantity::Temperature, run, group, element).unwrap_or(f64::NAN);
            let change = planned.change_of_flow_stress(value, plastic_strain(group, element), temperature);
            sums.changed += weight * change;
            if distance > sums.distance {
                (sums.distance, sums.farthest, sums.time) = (distance, value, run.now.total_time);
                sums.place = place(run, group, element);
            }
        }
    }
}

/// Records the plastic strains of the elements of a range of the strain rate.
fn record_strains(planned: &PlannedRange, run: &RunState<'_>, strains: &mut Vec<f64>) {
    strains.clear();
    if planned.range.quantity == RangedQuantity::StrainRate {
        let groups = planned.groups.iter().map(|&group| &*run.state.elements.groups[group]);
        strains.extend(groups.flat_map(|group| (0..group.len()).map(move |e| plastic_strain(group, e))));
    }
}

fn plastic_strain(group: &dyn ElementGroup, element: usize) -> f64 {
    group.value(element, Variable::PlasticStrain.into()).unwrap_or(0.0)
}

/// Returns the value of a quantity other than the strain rate; `None` if the element does not have it.
fn sampled_value(
    quantity: RangedQuantity,
    run: &RunState<'_>,
    group: &dyn ElementGroup,
    element: usize,
) -> Option<f64> {
    let variable = match quantity {
        RangedQuantity::Temperature => Variable::Temperature,
        RangedQuantity::Pressure => Variable::Pressure,
        RangedQuantity::PlasticStrain | RangedQuantity::StrainRate => Variable::PlasticStrain,
    };
    values::value(group, run.state.dofs.nodes.as_slice(), element, variable.into())
}

/// Returns the centre of an element.
fn place(run: &RunState<'_>, group: &dyn ElementGroup, element: usize) -> [f64; 2] {
    let nodes = group.nodes(element);
    let corner = |i: usize| run.state.dofs.nodes[nodes[i.min(nodes.len() - 1)] as usize].place();
    middle([corner(0), corner(1), corner(2), corner(3)])
}
