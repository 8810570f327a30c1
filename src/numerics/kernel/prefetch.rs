//! Prefetching: hints that make a core load data into its caches before an update needs them. They change no value. Models
//! larger than the caches become faster, smaller ones slower, so that each large model compares both at its start.

use std::time::{Duration, Instant};

use prefetch_index::prefetch_index;

/// Numbers in a cache line.
const LINE: usize = 8;

/// Requests `count` numbers, `ahead` numbers after the start of a list. They may be beyond its end.
#[inline(always)]
pub fn request(list: &[f64], ahead: usize, count: usize) {
    for line in (0..count).step_by(LINE) {
        prefetch_index(list, ahead + line);
    }
}

/// Requests the cache line in which an entry of a list begins.
#[inline(always)]
pub fn request_entry<T>(list: &[T], index: usize) {
    prefetch_index(list, index);
}

/// Passes before the comparison, in which memory is used for the first time.
const FIRST: usize = 8;
/// Pairs of passes without and with prefetching that are compared.
const PAIRS: usize = 15;
/// Largest median ratio of run times for which prefetching is chosen.
const FASTER: f64 = 0.97;

/// Choice of prefetching from the run times of the first passes over a model. It affects no result.
#[derive(Clone, Debug, Default)]
pub struct PrefetchChoice {
    /// Passes so far, until the choice.
    passes: usize,
    without: Duration,
    ratios: [f64; PAIRS],
    chosen: Option<bool>,
}

impl PrefetchChoice {
    /// Returns the choice not to prefetch, for a model that fits into caches.
    pub fn never() -> Self {
        PrefetchChoice { chosen: Some(false), ..PrefetchChoice::default() }
    }

    /// Returns whether the current pass prefetches.
    pub fn is_on(&self) -> bool {
        self.chosen.unwrap_or(self.passes >= FIRST && (self.passes - FIRST) % 2 == 1)
    }

    /// Returns the start of a pass if its run time is needed.
    pub fn start(&self) -> Option<Instant> {
        self.chosen.is_none().then(Instant::now)
    }

    /// Takes the run time of a pass.
    pub fn stop(&mut self, start: Option<Instant>) {
        if let Some(start) = start {
            self.add(start.elapsed());
        }
    }

    fn add(&mut self, time: Duration) {
        if let Some(trial) = self.passes.checked_sub(FIRST) {
            if trial % 2 == 0 {
                self.without = time;
            } else {
                self.ratios[trial / 2] = time.as_secs_f64() / self.without.as_secs_f64();
            }
            if trial + 1 == 2 * PAIRS {
                self.ratios.sort_unstable_by(f64::total_cmp);
                self.chosen = Some(self.ratios[PAIRS / 2] < FASTER);
            }
        }
        self.passes += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::{FIRST, PAIRS, PrefetchChoice};
    use std::time::Duration;

    /// One pass in five takes ten times as long, as on a shared machine.
    fn choice(with: u64, without: u64) -> PrefetchChoice {
        let mut choice = PrefetchChoice::default();
        for pass in 0..FIRST + 2 * PAIRS {
            assert!(choice.start().is_some());
            let time = if choice.is_on() { with } else { without };
            choice.add(Duration::from_micros(if pass % 5 == 2 { 10 * time } else { time }));
        }
        assert!(choice.start().is_none());
        choice
    }

    #[test]
    fn prefetching_is_chosen_only_if_it_is_faster() {
        assert!(choice(85, 100).is_on());
        assert!(!choice(99, 100).is_on());
        assert!(!choice(105, 100).is_on());
        assert!(!PrefetchChoice::never().is_on() && PrefetchChoice::never().start().is_none());
    }

    #[test]
    fn requests_beyond_a_list_are_harmless() {
        super::request(&[1.0; 4], 1 << 40, 1 << 10);
        super::request_entry(&[[0_u32; 4]; 2], usize::MAX);
    }
}
