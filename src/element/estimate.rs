//! When the highest frequency of the whole is estimated, and how far the last estimate holds.
//! Never here: the estimate itself.

use super::elements::Elements;
use super::frequency::{Held, WORN};
use crate::state::nodes::Nodes;

impl Elements {
    /// Begins a step in which the highest frequency of the whole bounds the increment, or not.
    pub fn begin_frequency(&mut self, asked: bool, nodes: &Nodes, held: &Held<'_>) {
        self.frequency_asked = asked;
        let mut cap = f64::INFINITY;
        if let Some(mut frequency) = self.frequency.take() {
            frequency.begin(&self.groups, nodes, held);
            if asked {
                // At once: an increment that jumps would jump the energy of the highest modes.
                frequency.renew(&self.groups, nodes);
                cap = frequency.standing.cap(0.0);
            }
            self.frequency = Some(frequency);
        }
        self.groups.iter_mut().for_each(|g| g.extensions().settings().limit_frequency(cap));
    }

    /// After a pass over the elements: the bound for the next.
    pub(super) fn bound_frequency(&mut self, nodes: &Nodes) {
        if !self.frequency_asked {
            return;
        }
        let Some(mut frequency) = self.frequency.take() else { return };
        let (deformed, rate) = (self.deformed, self.limit.0.rate);
        let standing = &mut frequency.standing;
        if standing.found > 0.0 {
            self.limit.0.rate *= 1.0 + standing.follow(deformed);
            if standing.age == 1 {
                standing.gain = (standing.by_elements / rate - 1.0).max(0.0);
            }
            if standing.grown > WORN {
                if standing.goes_on() {
                    frequency.renew(&self.groups, nodes);
                } else {
                    standing.drop();
                }
            }
        } else {
            standing.age += 1;
        }
        let standing = &frequency.standing;
        if standing.found == 0.0 && standing.age > standing.pause && rate.is_finite() {
            frequency.renew(&self.groups, nodes);
        }
        let cap = frequency.standing.cap(deformed);
        self.groups.iter_mut().for_each(|g| g.extensions().settings().limit_frequency(cap));
        self.frequency = Some(frequency);
    }

    /// Estimates of the highest frequency so far; `None` where none is made.
    pub fn estimates(&self) -> Option<u64> {
        self.frequency.as_ref().map(|f| f.standing.count)
    }
}
