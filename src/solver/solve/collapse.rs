//! History of the stable time increment: how many increments a few elements, for example squashed ones, have reduced.

use crate::state::archive::Persist;

/// Ratio of the largest stable time increment so far to the increment, from which the increment has collapsed.
pub(super) const COLLAPSED: f64 = 25.0;

/// History of the stable time increment.
#[derive(Clone, Debug, Default, Persist)]
pub(super) struct CollapseMonitor {
    /// Largest stable time increment of the elements.
    pub largest: f64,
    /// Number of collapsed increments, total time of the first one, and the smallest one with its group and element.
    pub count: u64,
    pub since: f64,
    pub smallest: f64,
    pub place: (usize, usize),
    /// Whether the last check found a collapse, and the increment of the last report, 0 before.
    pub seen: bool,
    pub reported: f64,
}

impl CollapseMonitor {
    /// Counts an increment that the elements limit and that starts at the total time `time`.
    #[inline(always)]
    pub(super) fn count(&mut self, length: f64, time: f64, place: (usize, usize)) {
        if length * COLLAPSED < self.largest {
            if self.count == 0 {
                (self.since, self.smallest) = (time, f64::INFINITY);
            }
            self.count += 1;
            if length < self.smallest {
                (self.smallest, self.place) = (length, place);
            }
        }
    }
}
