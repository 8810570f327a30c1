//! Estimate of increments and run time from a short trial run in memory.

use std::cell::Cell;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant as Stopwatch};

use serde::Serialize;

use crate::output::FramePoints;
use crate::output::OutputFrame;
use crate::output::history::row_length;
use crate::output::sums::SummedWriter;
use crate::output::vtu::VtuWriter;
use crate::plan::{Plan, State};
use crate::solve::{self, END_OF_TRIAL, HaltReason, Instant, Progress, RunControl, Sink, SinkError};

/// Estimated increments and run time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunEstimate {
    /// Time increment at the end of the trial run; the mean one if the trial run covered the whole run.
    pub increment: f64,
    /// Element that limits the increment, or the smallest one of the last step; empty if none does.
    pub limiting_element: String,
    /// Number of increments of the whole run with this increment.
    pub increments: f64,
    /// Run time in seconds on this machine, without output.
    pub seconds: f64,
    /// Fraction of the run that the trial run covered; 1 for the whole run.
    pub looked_at: f64,
    /// Mean bytes of a frame and of a history row. If the trial run covered a part of the run, the frame is its last one:
    /// frames of a model at rest are smaller.
    #[serde(skip)]
    pub mean_bytes: [Option<f64>; 2],
    /// Numbers of frames and of history rows if the trial run was the whole run and left out none.
    #[serde(skip)]
    pub counted: [Option<f64>; 2],
    /// Reason if the trial run halted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub halt: Option<String>,
}

/// Sink that counts output, and interrupts a run that takes very long.
struct TrialRun<'a> {
    /// Whether the deck requests frames.
    frames: bool,
    begin: Stopwatch,
    stop: &'a AtomicUsize,
    increment: f64,
    limiting: String,
    fraction: f64,
    vtu: VtuWriter,
    /// Whether frames were left out.
    skipped: Cell<bool>,
    /// Number and bytes of frames and of history rows.
    written: [[f64; 2]; 2],
    /// Number of points of the frames so far.
    frame_points: usize,
    last_frame: f64,
    /// Wall-clock time for frames and rows.
    output_time: Duration,
}

/// Number of increments times elements of the trial run, and of additional elements for the cost of an increment itself:
/// .1 to .5 s. The same deck thus has the same estimate on each machine.
const WORK: f64 = 3e6;
const WORK_OF_INCREMENT: f64 = 50.0;
/// Share of this work for decks with `*REMESH`, whose new meshes take up to ten times as long as their increments.
const SHARE_WITH_NEW_MESHES: f64 = 0.1;
/// Usual length of the origin of the results in a frame, characters.
const ORIGIN: usize = 190;
/// Share of the work of `check` that `run` does to count increments.
pub const COUNTING_SHARE: f64 = 0.06;
/// Largest number of points of the frames of a trial run.
const FRAME_POINTS: usize = 100_000;
/// Wall-clock time after which a trial run ends in any case.
const LONGEST: Duration = Duration::from_secs(10);

impl TrialRun<'_> {
    /// Returns the bytes of a frame and of a row, if there are any: means, or the last frame after the initial one.
    fn mean_bytes(&self, has_ended: bool) -> [Option<f64>; 2] {
        let mean = |[number, bytes]: [f64; 2]| (number > 0.0).then(|| bytes / number);
        let last = (self.written[0][0] > 1.0).then_some(self.last_frame);
        [if has_ended { mean(self.written[0]) } else { last }, mean(self.written[1])]
    }
}

impl Sink for TrialRun<'_> {
    fn wants_frames(&self) -> bool {
        let is_worth_a_frame = self.frame_points < FRAME_POINTS;
        self.skipped.set(self.skipped.get() || !is_worth_a_frame);
        self.frames && is_worth_a_frame
    }

    fn wants_last_instant(&self) -> bool {
        false
    }

    fn frame(&mut self, frame: &OutputFrame) -> Result<(), SinkError> {
        let begin = Stopwatch::now();
        let [number, bytes] = &mut self.written[0];
        let mut out = SummedWriter::new(std::io::sink());
        self.vtu.write(frame, &mut out)?;
        self.last_frame = out.length() as f64;
        self.frame_points += frame.points.len();
        (*number, *bytes) = (*number + 1.0, *bytes + self.last_frame);
        self.output_time += begin.elapsed();
        Ok(())
    }

    fn row(&mut self, now: &Instant, values: &[f64]) -> Result<(), SinkError> {
        let begin = Stopwatch::now();
        let text = row_length(now, values);
        let [number, bytes] = &mut self.written[1];
        (*number, *bytes) = (*number + 1.0, *bytes + text as f64);
        self.output_time += begin.elapsed();
        Ok(())
    }

    fn progress(&mut self, progress: &Progress<'_>) {
        if self.begin.elapsed() >= LONGEST {
            self.stop.store(END_OF_TRIAL, Ordering::Relaxed);
        }
        if progress.increment > 0.0 && !progress.ends {
            self.increment = progress.increment;
            progress.limiting.clone_into(&mut self.limiting);
        }
        self.fraction = progress.fraction;
    }
}

/// Runs a plan from its initial state for a limited number of increments and estimates the whole run; `None` with user
/// subroutines or if no increment was completed. `share` scales the number of increments.
pub fn measure(plan: &Plan, state: State, share: f64) -> Option<RunEstimate> {
    if plan.routines.any() {
        return None;
    }
    let stop = AtomicUsize::new(0);
    let mut trial = TrialRun {
        frames: plan.steps.iter().any(|step| !step.outputs.field.is_empty()),
        begin: Stopwatch::now(),
        stop: &stop,
        increment: 0.0,
        limiting: String::new(),
        fraction: 0.0,
        vtu: VtuWriter::new(FramePoints::default(), &" ".repeat(ORIGIN)),
        skipped: Cell::new(false),
        written: [[0.0; 2]; 2],
        frame_points: 0,
        last_frame: 0.0,
        output_time: Duration::ZERO,
    };
    let share = if plan.remesh.is_none() { share } else { share * SHARE_WITH_NEW_MESHES };
    let most_increments = (share * WORK / (WORK_OF_INCREMENT + plan.mesh.elements.len() as f64)).ceil() as u64;
    let control =
        RunControl { interrupt: Some(&stop), most_increments: Some(most_increments), ..RunControl::default() };
    let (outcome, _) = solve::run_with(plan, state, &mut trial, control).ok()?;
    let ended = !matches!(outcome.halt, Some(HaltReason::Interrupted(_)));
    let (mean_bytes, [[frames, _], [rows, _]]) = (trial.mean_bytes(ended), trial.written);
    let counted = [(ended && !trial.skipped.get()).then_some(frames), ended.then_some(rows)];
    let TrialRun { mut increment, mut limiting, fraction, output_time, .. } = trial;
    let run_time = (outcome.seconds - output_time.as_secs_f64()).max(0.0);
    let halt = outcome.halt.as_ref().filter(|_| ended).map(HaltReason::to_string);
    let increments_made = outcome.increments as f64;
    let (increments, seconds, looked_at) = if ended && halt.is_none() {
        // The last report of the progress, which is made from time to time, differs between runs.
        let total: f64 = outcome.steps.iter().map(|step| step.time).sum();
        increment = total / increments_made.max(1.0);
        limiting = outcome.steps.last().and_then(|step| step.limiting_element.clone()).unwrap_or_default();
        (increments_made, run_time, 1.0)
    } else if outcome.increments == 0 || increment <= 0.0 {
        return None;
    } else {
        let elapsed_time: f64 = outcome.steps.iter().map(|step| step.time).sum();
        let total: f64 = plan.steps.iter().map(|step| step.duration).sum();
        let increments = increments_made + (total - elapsed_time).max(0.0) / increment;
        (increments, increments * run_time / increments_made, fraction)
    };
    Some(RunEstimate {
        increment,
        limiting_element: limiting,
        increments,
        seconds,
        looked_at,
        mean_bytes,
        counted,
        halt,
    })
}
