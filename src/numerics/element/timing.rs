//! Run time of element groups by ledger row.

use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::Instant as Stopwatch;

use crate::state::EffectId;

/// Records of the element groups that are updated.
#[derive(Default)]
pub struct GroupTiming<'a> {
    /// Wall-clock seconds by ledger row; `None` if they are not measured.
    pub seconds: Option<&'a mut [f64]>,
    /// Ledger row of the group that is updated, for other threads.
    pub mark: Option<&'a AtomicUsize>,
}

impl GroupTiming<'_> {
    /// Records that a row is evaluated. Returns the start time, if times are measured.
    pub(super) fn start(&self, row: EffectId) -> Option<Stopwatch> {
        if let Some(mark) = self.mark {
            mark.store(row, Relaxed);
        }
        self.seconds.as_ref().map(|_| Stopwatch::now())
    }

    /// Adds the time since `started` to a row.
    pub(super) fn stop(&mut self, started: Option<Stopwatch>, row: EffectId) {
        if let (Some(started), Some(seconds)) = (started, &mut self.seconds) {
            seconds[row] += started.elapsed().as_secs_f64();
        }
    }
}
