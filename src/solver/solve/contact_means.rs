//! Mean contact forces over the output interval: the impulse of a pair since the last row, divided by the time since then.
//! The integral of the written forces over time is the impulse for any interval.

use super::run_state::RunState;
use crate::constraint::{area_of_pair, forces_of_pair};
use crate::kernel::lanes::InlineMap;
use crate::plan::Plan;
use crate::state::Instant;
use crate::state::archive::Persist;
use crate::variables::{Variable, VariableComponent};

/// Impulse of a contact pair since the last row, and the mean forces over the interval of that row.
#[derive(Clone, Debug, Default, Persist)]
#[persist(derived: pair)]
struct PairMean {
    /// Index of the pair among the pairs of all steps.
    pair: usize,
    /// Impulses of pressure and of friction.
    impulse: [[f64; 3]; 2],
    mean: [[f64; 3]; 2],
    /// Contact area at the last row.
    area: f64,
}

/// Impulses of the contact pairs that have history columns.
#[derive(Clone, Debug, Default, Persist)]
#[persist(fixed: pairs)]
pub(super) struct ContactMeans {
    pairs: Vec<PairMean>,
    /// Last increment whose impulses have been added.
    added: u64,
    /// Total time of the last row.
    row_time: f64,
}

impl ContactMeans {
    pub(super) fn new(plan: &Plan) -> ContactMeans {
        let mut pairs: Vec<usize> = plan.columns.iter().filter_map(|column| column.source.pair()).collect();
        pairs.sort_unstable();
        pairs.dedup();
        let pairs = pairs.into_iter().map(|pair| PairMean { pair, ..PairMean::default() }).collect();
        ContactMeans { pairs, ..ContactMeans::default() }
    }

    /// Adds the impulses of the increment that leads to the current instant, once.
    #[inline(always)]
    pub(super) fn add(&mut self, run: &RunState<'_>) {
        if !self.pairs.is_empty() && self.added < run.now.increment {
            self.added = run.now.increment;
            self.add_increment(run, 1.0);
        }
    }

    /// Adds the impulses that complete the velocities at this instant, before a new mesh: those of half an increment.
    pub(super) fn add_completion(&mut self, run: &RunState<'_>) {
        let nodes = &run.state.dofs.nodes;
        if nodes.half > 0.0 {
            self.add_increment(run, 0.5 * nodes.previous_dt / nodes.half);
        }
    }

    #[inline(never)]
    fn add_increment(&mut self, run: &RunState<'_>, part: f64) {
        for pair in &mut self.pairs {
            let Some(total) = forces_of_pair(&run.state.constraints, pair.pair) else { continue };
            for (impulse, force) in pair.impulse.iter_mut().flatten().zip(total.forces.iter().flatten()) {
                *impulse += part * total.duration * force;
            }
        }
    }

    /// Computes the means at a row. A second row at the same instant repeats the first one.
    pub(super) fn begin_row(&mut self, run: &RunState<'_>) {
        let Instant { total_time, .. } = run.now;
        let interval = total_time - std::mem::replace(&mut self.row_time, total_time);
        for pair in &mut self.pairs {
            // A pair that is not in force in this step is not in contact.
            let area = area_of_pair(&run.state.constraints, pair.pair);
            pair.area = area.unwrap_or(0.0);
            if interval > 0.0 {
                pair.mean = std::mem::take(&mut pair.impulse).inline_map(|sum| sum.inline_map(|sum| sum / interval));
            }
        }
    }

    /// Returns the value of a column of a pair; NaN if the pair does not have the variable.
    pub(super) fn value(&self, pair: usize, part: VariableComponent) -> f64 {
        let Some(PairMean { mean: [normal, shear], area, .. }) = self.pairs.iter().find(|p| p.pair == pair) else {
            return f64::NAN;
        };
        let both = [0, 1, 2].inline_map(|i| normal[i] + shear[i]);
        let size = |force: &[f64; 3]| force.iter().map(|f| f * f).sum::<f64>().sqrt();
        match part.variable {
            Variable::NormalContactForce => normal[part.component],
            Variable::ShearContactForce => shear[part.component],
            Variable::ContactForce => both[part.component],
            Variable::NormalContactMagnitude => size(normal),
            Variable::ShearContactMagnitude => size(shear),
            Variable::ContactMagnitude => size(&both),
            Variable::ContactArea => *area,
            _ => f64::NAN,
        }
    }
}
