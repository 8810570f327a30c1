//! Announced size of the result files: frames, history and restart file.

use serde::Serialize;

use super::RunEstimate;
use crate::output::OutputFrame;
use crate::output::vtu::VtuWriter;
use crate::plan::{Plan, State, StepOutputs, WriteSchedule};
use crate::solve;
use crate::state::archive::{Persist, StateArchive};

/// Largest number of output times that are listed, so that coincident times count once.
const MOST_TIMES: f64 = 100_000.0;
/// Largest number of characters of a number with its comma in the history file.
const NUMBER: f64 = 25.0;
/// Bytes of a frame in the `.pvd` and `.sfv` files, without the job name.
const LISTED: f64 = 110.0;

/// Ratio of the mean size of a frame and of a row to their largest size, without a trial run: 0.34 to 0.42 and 0.47 to
/// 0.70 in the examples.
const TYPICAL: [f64; 2] = [0.4, 0.6];

/// Ratio of the size to the free disk space above which the line names the free space.
const SCARCE: f64 = 0.1;

/// Announced size of the result files.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct StorageEstimate {
    /// Number of frames; absent if it depends on an unknown number of increments.
    pub frames: Option<f64>,
    /// Bytes of a frame: mean of the trial run, or a typical ratio of the largest size.
    pub frame_bytes: f64,
    /// Bytes of a frame without compression.
    pub largest_frame_bytes: f64,
    /// Number of history rows; absent if it depends on an unknown number of increments.
    pub rows: Option<f64>,
    /// Bytes of a history row, estimated like those of a frame.
    pub row_bytes: f64,
    /// Bytes of a history row in which all numbers have all digits.
    pub largest_row_bytes: f64,
    /// Bytes of the restart file; 0 if none is requested.
    pub restart_bytes: f64,
}

impl StorageEstimate {
    /// Measures one frame, one row and the restart file. Returns the state unchanged. `frames` and `restart` state
    /// whether frames and a restart file are written. The numbers of frames and rows follow by
    /// [`StorageEstimate::with_effort`].
    pub fn of(plan: &Plan, mut state: State, frames: bool, restart: bool) -> (StorageEstimate, State) {
        let mut estimate = StorageEstimate {
            largest_row_bytes: NUMBER * (plan.columns.len() + 2) as f64,
            ..StorageEstimate::default()
        };
        // The frame of a large model takes much memory.
        if frames && plan.steps.iter().any(|step| !step.outputs.field.is_empty()) {
            let (frame, unchanged): (OutputFrame, State) = solve::initial_frame(plan, state);
            (estimate.largest_frame_bytes, state) = (VtuWriter::largest_length(&frame) as f64 + LISTED, unchanged);
        }
        if restart || plan.steps.iter().any(|step| !step.outputs.restart.is_empty()) {
            let mut bytes = 0;
            state.persist(&mut StateArchive::counter(&mut bytes));
            estimate.restart_bytes = bytes as f64;
        }
        (estimate, state)
    }

    /// Adds the numbers of frames and rows, and their mean sizes in a trial run if there was one. A restart file also
    /// contains the rows.
    pub fn with_effort(self, plan: &Plan, effort: Option<&RunEstimate>) -> StorageEstimate {
        let [frames, rows] = effort.map_or([None; 2], |effort| effort.counted);
        let [frame, row] = effort.map_or([None; 2], |effort| effort.mean_bytes);
        let (writes_frames, writes_restart) = (self.largest_frame_bytes > 0.0, self.restart_bytes > 0.0);
        let frames = if writes_frames { frames.or_else(|| count(plan, effort, |o| &o.field)) } else { Some(0.0) };
        let rows = rows.or_else(|| count(plan, effort, |outputs| &outputs.history));
        let frame = frame.filter(|_| writes_frames).map(|bytes| bytes + LISTED);
        let checkpoint_bytes =
            if writes_restart { rows.unwrap_or(0.0) * 8.0 * (plan.columns.len() + 2) as f64 } else { 0.0 };
        StorageEstimate {
            frames,
            rows,
            frame_bytes: frame.unwrap_or(TYPICAL[0] * self.largest_frame_bytes),
            row_bytes: row.unwrap_or(TYPICAL[1] * self.largest_row_bytes),
            restart_bytes: self.restart_bytes + checkpoint_bytes,
            ..self
        }
    }

    /// Returns the number of bytes of all files.
    pub fn bytes(&self) -> f64 {
        self.sum(self.frame_bytes, self.row_bytes)
    }

    /// Returns the largest number of bytes of all files.
    pub fn largest_bytes(&self) -> f64 {
        self.sum(self.largest_frame_bytes, self.largest_row_bytes)
    }

    fn sum(&self, frame: f64, row: f64) -> f64 {
        self.frames.unwrap_or(0.0) * frame + self.rows.unwrap_or(0.0) * row + self.restart_bytes
    }

    /// Formats the estimate as one line. `free` is the free space at the place of the results in bytes; it is shown if
    /// it is small.
    pub fn render(&self, free: Option<u64>) -> String {
        let mut parts = Vec::new();
        for (number, name, each) in
            [(self.frames, "frames", self.frame_bytes), (self.rows, "history rows", self.row_bytes)]
        {
            let each = size(each);
            match number {
                Some(0.0) => {}
                Some(number) => parts.push(format!("{number:.0} {name} of {each}")),
                None => parts.push(format!("{name} of {each} at intervals of increments, whose number is unknown")),
            }
        }
        if self.restart_bytes > 0.0 {
            parts.push(format!("restart file of {}", size(self.restart_bytes)));
        }
        if parts.is_empty() {
            return "output: no frames, no history\n".into();
        }
        let (about, largest) = (size(self.bytes()), size(self.largest_bytes()));
        let scarce = free.map(|free| free as f64).filter(|free| self.bytes() > SCARCE * free);
        let free = scarce.map_or_else(String::new, |free| format!("; free disk space {}", size(free)));
        format!("output: {}: about {about}, at most {largest}{free}\n", parts.join(", "))
    }
}

/// Formats a number of bytes.
pub fn size(bytes: f64) -> String {
    match bytes {
        ..1e3 => format!("{bytes:.0} bytes"),
        ..1e6 => format!("{:.1} kB", 1e-3 * bytes),
        ..1e9 => format!("{:.1} MB", 1e-6 * bytes),
        _ => format!("{:.1} GB", 1e-9 * bytes),
    }
}

/// Returns the number of times at which an output is written: at the start, at the times of its schedules and at the end
/// of each step. `None` if a schedule counts increments and their number is unknown.
fn count(plan: &Plan, effort: Option<&RunEstimate>, of: fn(&StepOutputs) -> &Vec<WriteSchedule>) -> Option<f64> {
    let total: f64 = plan.steps.iter().map(|step| step.duration).sum();
    let start = plan.steps.first().is_some_and(|step| !of(&step.outputs).is_empty());
    let mut number = f64::from(u8::from(start));
    for step in plan.steps.iter().filter(|step| !of(&step.outputs).is_empty()) {
        let increments = effort.map(|effort| effort.increments * step.duration / total);
        number += in_step(of(&step.outputs), step.duration, increments)?;
    }
    Some(number)
}

/// Returns the number of outputs of a step after its start, at most one for each increment.
fn in_step(schedules: &[WriteSchedule], duration: f64, increments: Option<f64>) -> Option<f64> {
    let (mut times, mut others) = (vec![duration], 0.0);
    for schedule in schedules {
        match schedule {
            WriteSchedule::Points(points) => times.extend(points.iter().filter(|t| **t > 0.0 && **t <= duration)),
            WriteSchedule::Time(interval) if duration / interval <= MOST_TIMES => {
                let last = (duration / interval * (1.0 + 1e-12)).floor() as u64;
                times.extend((1..=last).map(|i| i as f64 * interval));
            }
            WriteSchedule::Time(interval) => others += (duration / interval).floor(),
            WriteSchedule::Increments(interval) => others += (increments? / *interval as f64).floor(),
        }
    }
    times.sort_by(f64::total_cmp);
    times.dedup_by(|b, a| *b <= *a + 1e-9 * duration);
    let number = times.len() as f64 + others;
    Some(increments.map_or(number, |increments| number.min(increments.max(1.0))))
}

#[cfg(test)]
mod tests {
    use super::{StorageEstimate, in_step, size};
    use crate::plan::WriteSchedule;

    #[test]
    fn coincident_times_count_once() {
        let number = |schedules: &[WriteSchedule], increments| in_step(schedules, 1.0, increments);
        assert_eq!(number(&[WriteSchedule::Time(0.1)], None), Some(10.0));
        assert_eq!(number(&[WriteSchedule::Time(0.1), WriteSchedule::Time(0.05)], None), Some(20.0));
        // The end of the step is not a multiple of 0.3.
        assert_eq!(number(&[WriteSchedule::Time(0.3)], None), Some(4.0));
        assert_eq!(number(&[WriteSchedule::Points([0.2, 0.5, 7.0].into())], None), Some(3.0));
        assert_eq!(number(&[WriteSchedule::Increments(10)], None), None);
        assert_eq!(number(&[WriteSchedule::Increments(10)], Some(1005.0)), Some(101.0));
        assert_eq!(number(&[WriteSchedule::Time(1e-9)], Some(500.0)), Some(500.0));
    }

    #[test]
    fn sizes_are_formatted_by_their_magnitude() {
        let texts = [0.0, 999.0, 1500.0, 2.5e6, 3.04e10].map(size);
        assert_eq!(texts, ["0 bytes", "999 bytes", "1.5 kB", "2.5 MB", "30.4 GB"]);
        let estimate = StorageEstimate {
            frames: Some(11.0),
            frame_bytes: 1e6,
            largest_frame_bytes: 2e6,
            rows: Some(101.0),
            row_bytes: 300.0,
            largest_row_bytes: 500.0,
            ..StorageEstimate::default()
        };
        assert_eq!(
            estimate.render(Some(100_000_000)),
            "output: 11 frames of 1.0 MB, 101 history rows of 300 bytes: about 11.0 MB, at most 22.1 MB; free disk space \
             100.0 MB\n"
        );
        assert!(!estimate.render(Some(1 << 40)).contains("free"));
    }
}
