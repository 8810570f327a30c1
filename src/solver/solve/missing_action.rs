//! Warnings of runs in which nothing happens that the deck prepares: contact that never closes, and plastic materials whose
//! stress stays far below yield.

use super::run_state::RunState;
use super::watch::RunReport;
use crate::element::values;
use crate::variables::Variable;

/// Fraction of the yield stress that no element of a plastic material reaches if loads and velocities are too small by a unit:
/// mistakes in units are factors of 1000. Parts that stay elastic by design reach 0.01 to 0.5.
const UNLOADED: f64 = 1e-3;

/// Returns the largest von Mises stress over the initial yield stress so far. Stops at a stress of [`UNLOADED`].
pub(super) fn largest_utilization(run: &RunState<'_>, previous: f64) -> f64 {
    if previous > UNLOADED {
        return previous;
    }
    let nodes = run.state.dofs.nodes.as_slice();
    let groups = run
        .plan
        .yield_stresses
        .iter()
        .filter_map(|&(group, stress)| Some((run.state.elements.groups.get(group)?, stress)));
    groups.fold(previous, |largest, (group, stress)| {
        let mises = |element| values::value(&**group, nodes, element, Variable::Mises.into()).unwrap_or(0.0);
        (0..group.len()).map(mises).fold(largest, |largest, mises| largest.max(mises / stress))
    })
}

impl RunReport {
    /// Warns at the end of a run of contact pairs that have never closed, and of stress far below yield.
    pub(super) fn warn_of_missing_action(&mut self, run: &RunState<'_>) {
        if self.outcome.halt.is_some() {
            return;
        }
        let totals = &run.state.dofs.energies;
        let contact = [totals.contact, totals.friction, totals.penalty, totals.initial_overlap, totals.impacts.sum()];
        let pairs = &run.plan.contact_pairs;
        if !pairs.is_empty() && contact.iter().all(|energy| *energy == 0.0) {
            let others = if pairs.len() > 1 { format!(" (and {} more)", pairs.len() - 1) } else { String::new() };
            self.outcome.warn("R328", format!(
                "no contact has closed until the end of the run: {}{others} have not touched each other. Check the gap between \
                 them, the direction of the motion, the sides of the surfaces, and the length of the step",
                pairs[0]
            ));
        }
        let utilization = largest_utilization(run, self.watch.utilization);
        if !run.plan.yield_stresses.is_empty() && utilization < UNLOADED {
            self.outcome.warn("R329", format!(
                "no plastic material has reached {:.1} % of its yield stress: the largest von Mises stress was {:.1e} of it. \
                 Loads, prescribed motions or velocities are probably in other units, or the step is too short",
                100.0 * UNLOADED,
                utilization
            ));
        }
    }
}
