//! The element that limits the time increment.

use super::connector::damped_rate;
use super::group::GroupTotals;
use super::lane_sums::is_larger;
use crate::state::archive::Persist;

/// Totals of the group that limits the time increment in the last pass, and the index of the group.
#[derive(Clone, Copy, Debug, Default, PartialEq, Persist)]
pub struct StableLimit {
    pub totals: GroupTotals,
    pub group: usize,
}

impl StableLimit {
    /// Replaces the limit by that of a group if it is stricter.
    pub(super) fn take_stricter(&mut self, totals: GroupTotals, group: usize) {
        if is_larger(totals.rate, self.totals.rate) {
            *self = StableLimit { totals, group };
        }
    }

    /// Adds the limit of cohesive elements to that of the bodies which they join: the squares of both frequencies add
    /// (Rayleigh).
    pub(super) fn add_interface(&mut self, interface: StableLimit) {
        let (bodies, rate) = (self.totals.rate, interface.totals.rate);
        if rate == 0.0 {
            return;
        }
        self.take_stricter(interface.totals, interface.group);
        self.totals.rate = damped_rate(bodies, 4.0 * rate * rate, 0.0);
    }

    /// Limits the time increment by the rate of an element, until the next update.
    pub(super) fn raise(&mut self, group: usize, element: usize, rate: f64) {
        if rate > self.totals.rate {
            (self.totals.rate, self.totals.limiting, self.group) = (rate, element, group);
        }
    }
}
