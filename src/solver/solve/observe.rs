//! Output schedule of history rows, frames and progress. Output never changes the motion.

use std::fs::File;
use std::time::{Duration, Instant as Stopwatch};

use thiserror::Error;

use super::contact_means::ContactMeans;
use super::energy::Energy;
use super::frames::{RowSources, frame};
use super::reaction_means::ReactionMeans;
use super::run::SolverRun;
use super::run_state::RunState;
use crate::output::OutputFrame;
use crate::plan::{ColumnSource, Plan, WriteSchedule};
use crate::state::Instant;
use crate::state::archive::Persist;
use crate::state::halt::{HaltDetails, HaltReason};
use crate::user::RunAction;

/// Reason why a sink cannot store output.
#[derive(Debug, Error)]
pub enum SinkError {
    /// A file could not be written.
    #[error(transparent)]
    File(#[from] std::io::Error),
    /// Any other error of the sink.
    #[error(transparent)]
    Other(#[from] Box<dyn std::error::Error + Send + Sync>),
}

/// Progress of a run.
#[derive(Clone, Copy, Debug)]
pub struct Progress<'a> {
    /// Name of the step.
    pub step: &'a str,
    /// Fraction of the total time of all steps that is complete.
    pub fraction: f64,
    /// Instant of the report.
    pub now: Instant,
    /// Length of the previous increment; 0 at the start.
    pub increment: f64,
    /// Name of the element that limits the increment; empty if none does.
    pub limiting: &'a str,
    /// Current energies.
    pub energy: &'a Energy,
    /// Whether a frame of this instant follows.
    pub frame: bool,
    /// Whether this instant is the end of the step.
    pub ends: bool,
}

/// Receiver of the output of a run.
pub trait Sink {
    /// Returns whether the sink uses frames; if not, they are not computed.
    fn wants_frames(&self) -> bool {
        false
    }
    /// Returns whether the sink needs the last complete instant after a halt, for which states are stored.
    fn wants_last_instant(&self) -> bool {
        self.wants_frames()
    }
    /// Returns whether the digest of the final state is used; if not, it is empty in the outcome.
    fn wants_digest(&self) -> bool {
        true
    }
    /// Returns a file without a name for a large state; `None` if it must be stored in memory.
    fn unnamed_file(&mut self) -> Option<File> {
        None
    }
    /// Receives a frame.
    ///
    /// # Errors
    /// If it cannot be stored; the run halts.
    fn frame(&mut self, _frame: &OutputFrame) -> Result<(), SinkError> {
        Ok(())
    }
    /// Receives a history row: one value for each column.
    ///
    /// # Errors
    /// If it cannot be stored; the run halts.
    fn row(&mut self, now: &Instant, values: &[f64]) -> Result<(), SinkError>;
    /// Receives a warning when it is issued; [`super::Outcome::warnings`] contains all of them at the end.
    fn warning(&mut self, _text: &str) {}
    /// Receives the progress several times a second, and before each frame.
    fn progress(&mut self, _progress: &Progress<'_>) {}
    /// Returns whether it stores checkpoints.
    fn keeps(&self) -> bool {
        false
    }
    /// Stores the state of a run, from which [`super::RunControl::state`] can continue.
    ///
    /// # Errors
    /// If it cannot be stored; the run halts.
    fn keep(&mut self, _state: &[u8], _now: &Instant) -> Result<(), SinkError> {
        Ok(())
    }
}

/// Next instants of one kind of output.
#[derive(Debug, Default, Persist)]
#[persist(derived: schedules)]
pub(super) struct OutputSchedule {
    schedules: Vec<WriteSchedule>,
    pub(super) next_time: f64,
    pub(super) next_increment: u64,
}

impl OutputSchedule {
    /// Returns whether no output is requested.
    pub(super) fn is_empty(&self) -> bool {
        self.schedules.is_empty()
    }

    pub(super) fn begin(&mut self, schedules: &[WriteSchedule], increment: u64) {
        self.schedules = schedules.to_vec();
        self.advance(0.0, increment);
    }

    /// Takes the next instants of a schedule of the same step.
    fn follow(&mut self, previous: &OutputSchedule) {
        (self.next_time, self.next_increment) = (previous.next_time, previous.next_increment);
    }

    pub(super) fn due(&self, time: f64, increment: u64) -> bool {
        time >= self.next_time || increment >= self.next_increment
    }

    /// Computes the next times after this instant. They are multiples of the interval; an instant within rounding error
    /// counts.
    pub(super) fn advance(&mut self, time: f64, increment: u64) {
        self.next_time = f64::INFINITY;
        self.next_increment = u64::MAX;
        for schedule in &self.schedules {
            match schedule {
                WriteSchedule::Points(times) => {
                    let next = times.iter().find(|t| **t > time * (1.0 + 4e-12));
                    self.next_time = self.next_time.min(next.map_or(f64::INFINITY, |t| t * (1.0 - 1e-12)));
                }
                &WriteSchedule::Time(interval) => {
                    let mark = ((time / interval) * (1.0 + 1e-12)).floor() + 1.0;
                    self.next_time = self.next_time.min(mark * interval * (1.0 - 1e-12));
                }
                &WriteSchedule::Increments(interval) => {
                    self.next_increment = self.next_increment.min((increment / interval + 1) * interval);
                }
            }
        }
    }
}

/// Approximate time between two readings of the clock for progress, which makes their cost negligible.
const LOOK: Duration = Duration::from_millis(100);

/// First number of increments between two readings of the clock in models without deformable elements.
const RIGID_STRIDE: u64 = 256;

/// Schedule of readings of the clock: every `stride` increments, adapted to the time between them.
pub(super) struct ClockReadings {
    look: Duration,
    looked: Stopwatch,
    stride: u64,
    /// Increment of the next reading.
    pub(super) next: u64,
}

impl ClockReadings {
    /// Creates a schedule with about the time `look` between readings. `stride` is the first number of increments.
    pub(super) fn new(look: Duration, stride: u64) -> ClockReadings {
        ClockReadings { look, looked: Stopwatch::now(), stride, next: 0 }
    }

    /// Returns whether a reading is due, and schedules the next one.
    pub(super) fn due(&mut self, increment: u64) -> bool {
        if increment < self.next {
            return false;
        }
        let passed = self.looked.elapsed();
        self.looked = Stopwatch::now();
        if passed < self.look / 2 {
            self.stride = self.stride.saturating_mul(2);
        } else if passed > self.look {
            self.stride = (self.stride / 2).max(1);
        }
        self.next = increment.saturating_add(self.stride);
        true
    }
}

/// Output of a run: schedules of fields and history, the current row, and the time of the last progress message.
#[derive(Persist)]
#[persist(derived: row, pace)]
pub(super) struct RunOutput {
    field: OutputSchedule,
    history: OutputSchedule,
    row: Vec<f64>,
    contact: ContactMeans,
    reactions: ReactionMeans,
    pace: ClockReadings,
    /// Step time before which no output is due, unless `next_increment` is reached.
    pub(super) next_time: f64,
    next_increment: u64,
    first: bool,
    /// Increment numbers of the last row and of the last frame.
    shown: [Option<u64>; 2],
}

impl RunOutput {
    pub(super) fn new(plan: &Plan) -> Self {
        RunOutput {
            field: OutputSchedule::default(),
            history: OutputSchedule::default(),
            row: vec![0.0; plan.columns.len()],
            contact: ContactMeans::new(plan),
            reactions: ReactionMeans::new(plan),
            pace: ClockReadings::new(LOOK, if plan.places.elements.is_empty() { RIGID_STRIDE } else { 1 }),
            next_time: 0.0,
            next_increment: 0,
            first: true,
            shown: [None; 2],
        }
    }

    /// Begins a step; its constraints are in force.
    pub(super) fn begin(&mut self, run: &RunState<'_>) {
        let (outputs, increment) = (&run.step.outputs, run.now.increment);
        self.field.begin(&outputs.field, increment);
        self.history.begin(&outputs.history, increment);
        self.reactions.begin_step(run);
        self.first = increment == 0;
        self.next_time = 0.0;
    }

    /// Takes the schedules and sums of the output of the mesh that has been replaced.
    pub(super) fn follow(&mut self, previous: RunOutput, now: &Instant) {
        self.field.follow(&previous.field);
        self.history.follow(&previous.history);
        self.reactions.follow(&previous.reactions, now.total_time);
        let RunOutput { row, contact, pace, next_time, next_increment, shown, .. } = previous;
        (self.row, self.contact, self.pace) = (row, contact, pace);
        (self.next_time, self.next_increment, self.shown, self.first) = (next_time, next_increment, shown, false);
    }

    /// Adds the impulses with which constraints complete the velocities before a new mesh.
    pub(super) fn add_completion(&mut self, run: &RunState<'_>) {
        self.contact.add_completion(run);
        self.reactions.add_completion(run);
    }

    /// Adds the impulses of the motion that has led to a new instant, before that instant is evaluated.
    #[inline(always)]
    pub(super) fn add_motion(&mut self, run: &RunState<'_>) {
        self.reactions.add_motion(run);
    }

    /// Writes output that is due: rows and frames by their schedules, at the start of the analysis, and at the end of
    /// each step.
    #[inline(always)]
    pub(super) fn show(&mut self, run: &mut SolverRun<'_>, sink: &mut dyn Sink) -> Result<(), HaltReason> {
        let current = &run.current;
        self.contact.add(current);
        self.reactions.add_instant(current);
        if current.now.step_time < self.next_time
            && current.now.increment < self.next_increment
            && run.user.requested_action == RunAction::Continue
        {
            return Ok(());
        }
        self.show_timed(run, sink)
    }

    #[inline(never)]
    fn show_timed(&mut self, run: &mut SolverRun<'_>, sink: &mut dyn Sink) -> Result<(), HaltReason> {
        let began = Stopwatch::now();
        let is_over = run.is_over();
        let result = self.show_due(&run.current, is_over, sink);
        run.timing.add_whole(run.current.plan.rows.output, began.elapsed().as_secs_f64());
        result
    }

    fn show_due(&mut self, run: &RunState<'_>, is_over: bool, sink: &mut dyn Sink) -> Result<(), HaltReason> {
        let (step, time, increment) = (run.step, run.now.step_time, run.now.increment);
        let edge = std::mem::take(&mut self.first) || is_over;
        let frame = self.field.due(time, increment) || edge && !step.outputs.field.is_empty();
        if self.pace.due(increment) || frame || edge {
            report_progress(run, frame, is_over, sink);
        }
        if self.history.due(time, increment) || edge && !step.outputs.history.is_empty() {
            self.history.advance(time, increment);
            self.show_row(run, sink)?;
        }
        if frame {
            self.field.advance(time, increment);
            self.show_frame(run, sink)?;
        }
        self.next_time = self.field.next_time.min(self.history.next_time).min(step.duration);
        self.next_increment = self.field.next_increment.min(self.history.next_increment).min(self.pace.next);
        Ok(())
    }

    /// Writes the last complete instant before a halt, unless it has been written. An incomplete instant is not written if
    /// nodes are integrated.
    pub(super) fn last(&mut self, run: &RunState<'_>, sink: &mut dyn Sink) -> Result<(), HaltReason> {
        if !run.state.dofs.nodes.is_empty() && !run.complete {
            return Ok(());
        }
        let now = Some(run.now.increment);
        if self.shown[0] != now {
            self.show_row(run, sink)?;
        }
        if self.shown[1] != now {
            self.show_frame(run, sink)?;
        }
        Ok(())
    }

    fn show_frame(&mut self, run: &RunState<'_>, sink: &mut dyn Sink) -> Result<(), HaltReason> {
        if !sink.wants_frames() {
            return Ok(());
        }
        self.shown[1] = Some(run.now.increment);
        sink.frame(&frame(run)).map_err(output_failure)
    }

    fn show_row(&mut self, run: &RunState<'_>, sink: &mut dyn Sink) -> Result<(), HaltReason> {
        let energy = run.energy();
        self.contact.begin_row(run);
        self.reactions.begin_row(run.now.total_time);
        let sources = RowSources { energy: &energy, reactions: &self.reactions };
        for (i, column) in run.plan.columns.iter().enumerate() {
            self.row[i] = match (column.source, column.part) {
                (ColumnSource::Pair(pair), Some(part)) => self.contact.value(pair, part),
                _ => run.column_value(column, &sources, &self.row[..i]),
            };
        }
        self.shown[0] = Some(run.now.increment);
        sink.row(&run.now, &self.row).map_err(output_failure)
    }
}

/// Passes step, time, energies and the limiting element to the sink.
pub(super) fn report_progress(run: &RunState<'_>, frame: bool, is_over: bool, sink: &mut dyn Sink) {
    let total: f64 = run.plan.steps.iter().map(|s| s.duration).sum();
    let limiting = run.limits();
    sink.progress(&Progress {
        step: &run.step.name,
        fraction: if total > 0.0 { (run.now.total_time / total).min(1.0) } else { 1.0 },
        now: run.now,
        increment: run.last_increment,
        limiting: limiting.map_or("", |(group, element)| run.plan.element_name(group, element)),
        energy: &run.energy(),
        frame,
        ends: is_over,
    });
}

pub(super) fn output_failure(why: SinkError) -> HaltReason {
    HaltReason::Output(HaltDetails::new(why.to_string()))
}
