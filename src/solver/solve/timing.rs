//! Run time of each ledger row. One increment in many is timed, so that the cost is negligible; output and new meshes are
//! always timed.
//! Time that no row uses belongs to the integration.

use std::sync::OnceLock;
use std::sync::atomic::Ordering::Relaxed;
use std::time::Instant as Stopwatch;

use super::position::RunPosition;
use crate::element::timing::GroupTiming;
use crate::plan::Plan;
use crate::plan::ledger::{Ledger, LedgerRow};
use crate::state::EffectId;

/// Increments per timed increment.
const TIMED_EVERY: u64 = 64;

/// Returns the time of one reading of the clock, s; measured once in a process, because a search runs thousands of models.
fn time_of_reading() -> f64 {
    static READING: OnceLock<f64> = OnceLock::new();
    let measure = || (0..8).map(|_| Stopwatch::now().elapsed().as_secs_f64()).fold(f64::INFINITY, f64::min);
    *READING.get_or_init(measure)
}

/// Measured times of a run, s.
#[derive(Debug)]
pub(super) struct EffectTiming<'a> {
    /// Time of each row in timed increments.
    rows: Vec<f64>,
    /// Total time of timed increments.
    sampled: f64,
    /// Time of the work of each row that is always timed.
    whole: Vec<f64>,
    /// Time of one reading of the clock.
    look: f64,
    /// Start of the part that is being timed, if any.
    began: Option<Stopwatch>,
    /// Position of the run, for other threads.
    pub position: Option<&'a RunPosition>,
}

/// Measured times of a run, s: of each effect and of all timed increments.
#[derive(Debug)]
pub(super) struct TimeSums {
    effects: Vec<EffectSeconds>,
    sampled: f64,
}

/// Time of an effect. Another mesh may have other rows in its ledger, so the effect is known by its name and cards.
#[derive(Debug)]
struct EffectSeconds {
    effect: String,
    asked_by: Vec<String>,
    /// In timed increments.
    seconds: f64,
    /// Of work that is always timed.
    whole: f64,
}

impl<'a> EffectTiming<'a> {
    /// Takes the times so far.
    pub fn take_sums(&mut self, ledger: &Ledger) -> TimeSums {
        let times = self.rows.iter_mut().zip(&mut self.whole);
        let rows = ledger.effects.iter().zip(times);
        let effects = rows.map(|(LedgerRow { effect, asked_by, .. }, (seconds, whole))| EffectSeconds {
            effect: effect.clone(),
            asked_by: asked_by.clone(),
            seconds: std::mem::take(seconds),
            whole: std::mem::take(whole),
        });
        TimeSums { effects: effects.collect(), sampled: std::mem::take(&mut self.sampled) }
    }

    /// Adds the times of the same run with another mesh. The integration gets the times of effects that have ended.
    pub fn add(&mut self, previous: &TimeSums, ledger: &Ledger) {
        let mut is_taken = vec![false; self.rows.len()];
        for EffectSeconds { effect, asked_by, seconds, whole } in &previous.effects {
            let mut rows = ledger.effects.iter().zip(&is_taken);
            let same = rows.position(|(row, taken)| !taken && row.is_of(effect, asked_by));
            if let Some(row) = same {
                is_taken[row] = true;
                self.rows[row] += seconds;
                self.whole[row] += whole;
            }
        }
        self.sampled += previous.sampled;
    }

    /// Timers for this number of rows.
    pub fn new(rows: usize, position: Option<&'a RunPosition>) -> Self {
        EffectTiming {
            rows: vec![0.0; rows],
            sampled: 0.0,
            whole: vec![0.0; rows],
            look: time_of_reading(),
            began: None,
            position,
        }
    }

    /// Starts timing a part of an increment, if the increment is timed.
    #[inline(always)]
    pub fn resume(&mut self, increment: u64) {
        if increment.is_multiple_of(TIMED_EVERY) {
            self.began = Some(Stopwatch::now());
        }
    }

    /// Stops timing the part.
    #[inline(always)]
    pub fn pause(&mut self) {
        if let Some(began) = self.began.take() {
            self.sampled += began.elapsed().as_secs_f64();
        }
    }

    /// Records that a row is evaluated. Returns the start time, if the increment is timed.
    #[inline(always)]
    pub fn start(&self, row: EffectId) -> Option<Stopwatch> {
        if let Some(position) = self.position {
            position.effect_mark().store(row, Relaxed);
        }
        self.began.map(|_| Stopwatch::now())
    }

    /// Adds the time since `since` to a row.
    #[inline(always)]
    pub fn stop(&mut self, since: Option<Stopwatch>, row: EffectId) {
        if let Some(since) = since {
            let passed = since.elapsed().as_secs_f64();
            self.rows[row] += (passed - self.look).max(0.0);
            // The two readings of the clock belong to no row.
            self.sampled -= 2.0 * self.look;
        }
    }

    /// Returns the times of the rows, to which element groups add in a timed increment, and the variable for the row that
    /// is evaluated.
    pub fn groups(&mut self) -> GroupTiming<'_> {
        GroupTiming {
            seconds: self.began.is_some().then_some(&mut self.rows[..]),
            mark: self.position.map(RunPosition::effect_mark),
        }
    }

    /// Adds time of work of a row that is always timed.
    pub fn add_whole(&mut self, row: Option<EffectId>, seconds: f64) {
        if let Some(row) = row {
            self.whole[row] += seconds;
        }
    }

    /// Returns the time of each row, s; the sum is the total time of the loop.
    pub fn seconds(&self, plan: &Plan, total: f64) -> Vec<f64> {
        let loop_seconds = (total - self.whole.iter().sum::<f64>()).max(0.0);
        let claimed: f64 = self.rows.iter().sum();
        let sampled = self.sampled.max(claimed);
        let factor = if sampled > 0.0 { loop_seconds / sampled } else { 0.0 };
        let mut seconds: Vec<f64> = self.rows.iter().zip(&self.whole).map(|(s, whole)| s * factor + whole).collect();
        if let Some(row) = plan.rows.integration {
            seconds[row] += loop_seconds - claimed * factor;
        }
        seconds
    }
}

#[cfg(test)]
mod tests {
    use super::EffectTiming;
    use crate::plan::ledger::Ledger;

    /// The ledger of a new mesh has no row for a condition whose nodes have been deleted, and rows with the same effect
    /// and card.
    #[test]
    fn times_follow_their_effects_to_another_ledger() {
        let ledger = |effects: &[&str]| {
            let mut ledger = Ledger::default();
            for effect in effects {
                ledger.add(effect, 1, "nodes", "a.inp:7".into(), String::new());
            }
            ledger
        };
        let (old, new) = (ledger(&["plate", "load", "contact", "contact"]), ledger(&["load", "contact", "contact"]));
        let mut timing = EffectTiming::new(4, None);
        (timing.rows, timing.sampled) = (vec![1.0, 2.0, 3.0, 4.0], 10.0);
        timing.add_whole(Some(1), 0.5);
        let mut next = EffectTiming::new(3, None);
        next.add(&timing.take_sums(&old), &new);
        assert_eq!((next.rows, next.whole, next.sampled), (vec![2.0, 3.0, 4.0], vec![0.5, 0.0, 0.0], 10.0));
        assert_eq!((timing.rows, timing.sampled), (vec![0.0; 4], 0.0));
    }
}
