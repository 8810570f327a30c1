//! When the highest frequency of the whole model is estimated, and how long an estimate is valid.

use super::elements::Elements;
use super::frequency::{ConstrainedNodes, WORN};
use super::group::GroupSetting;
use crate::state::nodes::Nodes;

impl Elements {
    /// Begins a step; `use_estimate` selects the global estimate of the stable time increment.
    pub fn begin_frequency(&mut self, use_estimate: bool, nodes: &Nodes, held: &ConstrainedNodes<'_>) {
        self.uses_frequency = use_estimate;
        let mut cap = f64::INFINITY;
        if let Some(mut frequency) = self.frequency.take() {
            frequency.begin(&self.groups, nodes, held);
            if use_estimate && frequency.wears_at_once(&self.groups, nodes) {
                frequency.state.wait();
            } else if use_estimate {
                // Immediately: a jump of the time increment would change the energy of the highest modes.
                frequency.update_estimate(&self.groups, nodes, self.arch);
                cap = frequency.state.cap(0.0);
            }
            self.frequency = Some(frequency);
        }
        self.groups.iter_mut().for_each(|g| g.configure(GroupSetting::HighestFrequency(cap)));
    }

    /// Updates the frequency bound for the next pass after a pass over the elements.
    pub(super) fn bound_frequency(&mut self, nodes: &Nodes) {
        if !self.uses_frequency {
            return;
        }
        let Some(mut frequency) = self.frequency.take() else { return };
        let (deformed, rate) = (self.deformed, self.limit.0.rate);
        let standing = &mut frequency.state;
        if standing.found > 0.0 {
            self.limit.0.rate *= 1.0 + standing.follow(deformed);
            if standing.age == 1 {
                standing.gain = (standing.by_elements / rate - 1.0).max(0.0);
            }
            if standing.growth > WORN {
                if standing.renews_at_once() {
                    frequency.update_estimate(&self.groups, nodes, self.arch);
                } else {
                    standing.discard();
                }
            }
        } else {
            standing.age += 1;
        }
        let standing = &frequency.state;
        if standing.found == 0.0 && standing.age > standing.pause && rate.is_finite() {
            frequency.update_estimate(&self.groups, nodes, self.arch);
        }
        let cap = frequency.state.cap(deformed);
        self.groups.iter_mut().for_each(|g| g.configure(GroupSetting::HighestFrequency(cap)));
        self.frequency = Some(frequency);
    }

    /// Returns the stable time increment that the mesh would have without deformation: where a step has begun without the
    /// global estimate, as if the elements were squares, which it helps by sqrt(2).
    pub fn undisturbed_increment(&self) -> f64 {
        let waits = self.frequency.as_ref().is_some_and(|frequency| frequency.state.waits);
        self.stable_increment() * if waits { std::f64::consts::SQRT_2 } else { 1.0 }
    }

    /// Returns the number of estimates of the highest frequency so far; `None` without the estimate.
    pub fn estimates(&self) -> Option<u64> {
        self.frequency.as_ref().map(|f| f.state.count)
    }
}
