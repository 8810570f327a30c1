//! When the highest frequency of the whole model is estimated, and how long an estimate is valid.

use pulp::Arch;

use super::frequency::{ConstrainedNodes, HighestFrequency, WORN};
use super::group::{ElementGroup, GroupSetting};
use super::stable_limit::StableLimit;
use crate::state::nodes::Nodes;

impl HighestFrequency {
    /// Begins a step that uses the estimate or not. Returns the bound of the frequency for the next pass.
    pub(super) fn begin_step(
        &mut self,
        use_estimate: bool,
        groups: &[Box<dyn ElementGroup>],
        nodes: &Nodes,
        held: &ConstrainedNodes<'_>,
        arch: Arch,
    ) -> f64 {
        self.begin(groups, nodes, held);
        if !use_estimate {
            return f64::INFINITY;
        }
        if self.wears_at_once(groups, nodes) {
            self.allocate();
            self.state.wait();
        } else {
            // Immediately: a jump of the time increment would change the energy of the highest modes.
            self.update_estimate(groups, nodes, arch);
        }
        self.state.cap(0.0)
    }

    /// Updates the frequency bound for the next pass after a pass over the elements with its limit of the time increment.
    /// `deformed` is the bound of the relative increase of frequencies in that pass.
    pub(super) fn follow_pass(
        &mut self,
        groups: &mut [Box<dyn ElementGroup>],
        limit: &mut StableLimit,
        deformed: f64,
        nodes: &Nodes,
        arch: Arch,
    ) {
        let rate = limit.totals.rate;
        let state = &mut self.state;
        if state.found > 0.0 {
            limit.totals.rate *= 1.0 + state.follow(deformed);
            if state.age == 1 {
                state.gain = (state.by_elements / rate - 1.0).max(0.0);
            }
            if state.growth > WORN {
                if state.renews_at_once() {
                    self.update_estimate(groups, nodes, arch);
                } else {
                    state.discard();
                }
            }
        } else {
            state.age += 1;
        }
        let state = &self.state;
        if state.found == 0.0 && state.age > state.pause && rate.is_finite() {
            self.update_estimate(groups, nodes, arch);
        }
        let cap = self.state.cap(deformed);
        groups.iter_mut().for_each(|g| g.configure(GroupSetting::HighestFrequency(cap)));
    }
}
