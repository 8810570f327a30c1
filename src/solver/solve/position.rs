//! Position of a run, which another thread can read: a watchdog reports where a run does not advance.

use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering::Relaxed};

use crate::state::{EffectId, Instant};

/// Increment and effect that a run evaluates.
#[derive(Debug, Default)]
pub struct RunPosition {
    increment: AtomicU64,
    /// Bits of the total time.
    time: AtomicU64,
    effect: AtomicUsize,
    /// Group and element that limited the last increment.
    limiting: [AtomicUsize; 2],
    ending: AtomicBool,
}

impl RunPosition {
    /// Records the start of an increment.
    pub(super) fn begin(&self, now: &Instant, limiting: Option<(usize, usize)>) {
        self.time.store(now.total_time.to_bits(), Relaxed);
        let (group, element) = limiting.unwrap_or((usize::MAX, 0));
        self.limiting[0].store(group, Relaxed);
        self.limiting[1].store(element, Relaxed);
        self.increment.store(now.increment, Relaxed);
    }

    /// Returns the variable for the ledger row of the effect that is evaluated.
    pub(super) fn effect_mark(&self) -> &AtomicUsize {
        &self.effect
    }

    /// Records that the time loop has ended, or that the last checkpoint is being written.
    pub fn end(&self) {
        self.ending.store(true, Relaxed);
    }

    /// Returns whether the time loop has ended or ends.
    pub fn is_ending(&self) -> bool {
        self.ending.load(Relaxed)
    }

    /// Returns the number of complete increments.
    pub fn increment(&self) -> u64 {
        self.increment.load(Relaxed)
    }

    /// Returns the total time.
    pub fn time(&self) -> f64 {
        f64::from_bits(self.time.load(Relaxed))
    }

    /// Returns the ledger row of the effect that is evaluated.
    pub fn effect(&self) -> EffectId {
        self.effect.load(Relaxed)
    }

    /// Returns group and element that limited the last increment.
    pub fn limiting(&self) -> (usize, usize) {
        (self.limiting[0].load(Relaxed), self.limiting[1].load(Relaxed))
    }
}
