//! A job whose results stay in memory: its summary, all rows of its histories, and its frames.

use std::sync::atomic::AtomicUsize;

use super::{Follower, Prepared, Summary, announce, summarise};
use crate::output::{Frame, History, Job};
use crate::solve::{self, Control, Instant, Progress, Sink, SinkError};

/// Keeps what it is shown.
struct MemorySink<'a> {
    history: History,
    frames: Option<Vec<Frame>>,
    follow: &'a mut Follower<'a>,
}

impl Sink for MemorySink<'_> {
    fn wants_frames(&self) -> bool {
        self.frames.is_some()
    }

    fn frame(&mut self, frame: &Frame) -> Result<(), SinkError> {
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

/// Runs a prepared deck in memory until `interrupt` is nonzero; the summary has all rows, frames only if wanted.
pub fn run_kept<'a>(
    prepared: &Prepared,
    job: &Job,
    frames: bool,
    interrupt: &AtomicUsize,
    follow: &'a mut Follower<'a>,
) -> (Summary, Vec<Frame>) {
    announce(prepared, job);
    let history = History::of_rows(prepared.plan.column_names());
    let mut memory = MemorySink { history, frames: frames.then(Vec::new), follow };
    let control = Control { interrupt: Some(interrupt), ..Control::default() };
    // Without a state to go on from there is none that could be refused.
    let (outcome, _) =
        solve::run_with(&prepared.plan, prepared.state.clone(), &mut memory, control).unwrap_or_default();
    (summarise(prepared, outcome, memory.history), memory.frames.unwrap_or_default())
}
