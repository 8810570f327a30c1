//! Where the time of a run goes, by rows of the ledger: one increment in many is timed, often enough for a share, too seldom to
//! be felt; output whenever there is any. What no row claims is the integrator's own.
//! Never here: what is timed.

use std::time::Instant as Stopwatch;

use crate::plan::Plan;
use crate::state::EffectId;

/// One increment in how many is timed.
const TIMED_EVERY: u64 = 64;

/// Seconds of a run.
#[derive(Debug)]
pub(super) struct Timing {
    /// Of timed increments, by row.
    rows: Vec<f64>,
    /// Of timed increments, all of it.
    sampled: f64,
    output: f64,
    /// What a look at the clock costs.
    look: f64,
    /// When the part being timed began; `None` where none is.
    began: Option<Stopwatch>,
}

impl Timing {
    /// For so many rows.
    pub fn new(rows: usize) -> Self {
        let looks = (0..8).map(|_| Stopwatch::now().elapsed().as_secs_f64());
        let look = looks.fold(f64::INFINITY, f64::min);
        Timing { rows: vec![0.0; rows], sampled: 0.0, output: 0.0, look, began: None }
    }

    /// A part of an increment begins.
    #[inline(always)]
    pub fn resume(&mut self, increment: u64) {
        if increment.is_multiple_of(TIMED_EVERY) {
            self.began = Some(Stopwatch::now());
        }
    }

    /// It ends.
    #[inline(always)]
    pub fn pause(&mut self) {
        if let Some(began) = self.began.take() {
            self.sampled += began.elapsed().as_secs_f64();
        }
    }

    /// The time, where this increment is timed.
    #[inline(always)]
    pub fn start(&self) -> Option<Stopwatch> {
        self.began.map(|_| Stopwatch::now())
    }

    /// Books the time since then for a row.
    #[inline(always)]
    pub fn stop(&mut self, since: Option<Stopwatch>, row: EffectId) {
        if let Some(since) = since {
            let passed = since.elapsed().as_secs_f64();
            self.rows[row] += (passed - self.look).max(0.0);
            // A look before and one behind belong to nobody.
            self.sampled -= 2.0 * self.look;
        }
    }

    /// Books the time since then for the way from corners to nodes.
    pub fn stop_gather(&mut self, since: Option<Stopwatch>, plan: &Plan) {
        if let Some(row) = plan.rows.gather {
            self.stop(since, row);
        }
    }

    /// Where groups of elements book their own time, in a timed increment.
    pub fn groups(&mut self) -> Option<&mut [f64]> {
        self.began.is_some().then_some(&mut self.rows[..])
    }

    /// Books time of output.
    pub fn add_output(&mut self, seconds: f64) {
        self.output += seconds;
    }

    /// Seconds of each row, which together are those of the whole loop.
    pub fn seconds(&self, plan: &Plan, total: f64) -> Vec<f64> {
        let loop_seconds = (total - self.output).max(0.0);
        let claimed: f64 = self.rows.iter().sum();
        let sampled = self.sampled.max(claimed);
        let factor = if sampled > 0.0 { loop_seconds / sampled } else { 0.0 };
        let mut seconds: Vec<f64> = self.rows.iter().map(|s| s * factor).collect();
        if let Some(row) = plan.rows.integration {
            seconds[row] += loop_seconds - claimed * factor;
        }
        if let Some(row) = plan.rows.output {
            seconds[row] += self.output;
        }
        seconds
    }
}
