//! Runs a job with its results in memory: summary, histories and frames.

use std::sync::atomic::AtomicUsize;

use super::{PreparedJob, ProgressFollower, RunSummary, announce_to_user, summarise};
use crate::output::{JobFiles, OutputFrame, RunHistory};
use crate::solve::{self, Instant, Progress, RunControl, Sink, SinkError};

/// Sink that collects histories and frames in memory.
struct MemorySink<'a> {
    history: RunHistory,
    frames: Option<Vec<OutputFrame>>,
    follow: &'a mut ProgressFollower<'a>,
}

impl Sink for MemorySink<'_> {
    fn wants_frames(&self) -> bool {
        self.frames.is_some()
    }

    fn frame(&mut self, frame: &OutputFrame) -> Result<(), SinkError> {
        self.frames.iter_mut().for_each(|frames| frames.push(frame.clone()));
        Ok(())
    }

    fn row(&mut self, now: &Instant, values: &[f64]) -> Result<(), SinkError> {
        self.history.push(now, values);
        Ok(())
    }

    fn progress(&mut self, progress: &Progress<'_>) {
        (self.follow)(progress);
    }
}

/// Runs a prepared deck in memory. Returns the summary with all history rows, and the frames if `frames` is true. A
/// nonzero `interrupt` ends the run.
pub fn run_kept<'a>(
    prepared: &PreparedJob,
    job: &JobFiles,
    frames: bool,
    interrupt: &AtomicUsize,
    follow: &'a mut ProgressFollower<'a>,
) -> (RunSummary, Vec<OutputFrame>) {
    announce_to_user(prepared, job);
    let history = RunHistory::of_rows(prepared.plan.column_names());
    let mut memory = MemorySink { history, frames: frames.then(Vec::new), follow };
    let control = RunControl { interrupt: Some(interrupt), ..RunControl::default() };
    // Cannot fail: only a restart can have an unsuitable state.
    let (outcome, _) =
        solve::run_with(&prepared.plan, prepared.state.clone(), &mut memory, control).unwrap_or_default();
    (summarise(prepared, outcome, memory.history), memory.frames.unwrap_or_default())
}
