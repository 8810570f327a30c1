//! What is shown when: history rows and frames at the instants that are due. Looking never changes the motion.
//! Never here: files.

use std::time::{Duration, Instant as Stopwatch};

use thiserror::Error;

use super::energy::Energy;
use super::frames::frame;
use super::run::Run;
use crate::output::Frame;
use crate::plan::{Plan, Schedule, StepPlan};
use crate::state::Instant;
use crate::state::archive::persist_struct;
use crate::state::halt::Halt;
use crate::user::RunAction;

/// Why a sink cannot keep what it is shown.
#[derive(Debug, Error)]
pub enum SinkError {
    /// A file could not be written.
    #[error(transparent)]
    File(#[from] std::io::Error),
    /// Any other reason.
    #[error(transparent)]
    Other(#[from] Box<dyn std::error::Error + Send + Sync>),
}

/// How far a run is.
#[derive(Clone, Copy, Debug)]
pub struct Progress<'a> {
    /// Name of the step.
    pub step: &'a str,
    /// Fraction of the time of all steps that is behind.
    pub fraction: f64,
    /// Now.
    pub now: Instant,
    /// Length of the increment behind; 0 at the start.
    pub increment: f64,
    /// Name of the element that limits the increment; empty where none does.
    pub limiting: &'a str,
    /// Energies now.
    pub energy: &'a Energy,
    /// Whether a frame of this instant follows.
    pub frame: bool,
    /// Whether the step ends here.
    pub ends: bool,
}

/// Takes what a run shows.
pub trait Sink {
    /// Whether frames are wanted at all.
    fn wants_frames(&self) -> bool {
        false
    }
    /// The scene at an instant.
    ///
    /// # Errors
    /// If it cannot be kept; the run halts.
    fn frame(&mut self, _frame: &Frame) -> Result<(), SinkError> {
        Ok(())
    }
    /// A history row at an instant, one value a column.
    ///
    /// # Errors
    /// If it cannot be kept; the run halts.
    fn row(&mut self, now: &Instant, values: &[f64]) -> Result<(), SinkError>;
    /// What the run warns of, as soon as it does; all of it is in [`super::Outcome::warnings`] at the end.
    fn warning(&mut self, _text: &str) {}
    /// How far the run is: some times a second, and before each frame.
    fn progress(&mut self, _progress: &Progress<'_>) {}
    /// Whether states can be kept.
    fn keeps(&self) -> bool {
        false
    }
    /// Keeps the state of a run, from which another can go on ([`super::Control::state`]).
    ///
    /// # Errors
    /// If it cannot be kept; the run halts.
    fn keep(&mut self, _state: &[u8], _now: &Instant) -> Result<(), SinkError> {
        Ok(())
    }
}

/// The next instants of one kind of output.
#[derive(Debug, Default)]
pub(super) struct Rhythm {
    schedules: Vec<Schedule>,
    pub(super) next_time: f64,
    pub(super) next_increment: u64,
}

impl Rhythm {
    /// Whether nothing is ever due.
    pub(super) fn is_empty(&self) -> bool {
        self.schedules.is_empty()
    }

    pub(super) fn begin(&mut self, schedules: &[Schedule], increment: u64) {
        self.schedules = schedules.to_vec();
        self.advance(0.0, increment);
    }

    pub(super) fn due(&self, time: f64, increment: u64) -> bool {
        time >= self.next_time || increment >= self.next_increment
    }

    /// Sets the next marks after this instant. Marks are multiples of the interval; an instant within rounding counts.
    pub(super) fn advance(&mut self, time: f64, increment: u64) {
        self.next_time = f64::INFINITY;
        self.next_increment = u64::MAX;
        for schedule in &self.schedules {
            match schedule {
                Schedule::Points(times) => {
                    let next = times.iter().find(|t| **t > time * (1.0 + 4e-12));
                    self.next_time = self.next_time.min(next.map_or(f64::INFINITY, |t| t * (1.0 - 1e-12)));
                }
                &Schedule::Time(interval) => {
                    let mark = ((time / interval) * (1.0 + 1e-12)).floor() + 1.0;
                    self.next_time = self.next_time.min(mark * interval * (1.0 - 1e-12));
                }
                &Schedule::Increments(interval) => {
                    self.next_increment = self.next_increment.min((increment / interval + 1) * interval);
                }
            }
        }
    }
}

/// Looks at the clock are about this far apart, so that a look costs nothing beside the increments between.
const LOOK: Duration = Duration::from_millis(100);

/// When progress is told: by the clock, at increments that are chosen to meet it.
struct Pace {
    looked: Stopwatch,
    stride: u64,
    next: u64,
}

impl Pace {
    fn new() -> Pace {
        Pace { looked: Stopwatch::now(), stride: 1, next: 0 }
    }

    /// Whether it is time; sets the next.
    fn due(&mut self, increment: u64) -> bool {
        if increment < self.next {
            return false;
        }
        let passed = self.looked.elapsed();
        self.looked = Stopwatch::now();
        if passed < LOOK / 2 {
            self.stride = self.stride.saturating_mul(2);
        } else if passed > LOOK {
            self.stride = (self.stride / 2).max(1);
        }
        self.next = increment.saturating_add(self.stride);
        true
    }
}

pub(super) struct Observing {
    field: Rhythm,
    history: Rhythm,
    row: Vec<f64>,
    pace: Pace,
    /// Nothing is due before these.
    next_time: f64,
    next_increment: u64,
    first: bool,
    /// Increments at which the last row and frame were shown.
    shown: [Option<u64>; 2],
}

impl Observing {
    pub(super) fn new(plan: &Plan) -> Self {
        Observing {
            field: Rhythm::default(),
            history: Rhythm::default(),
            row: vec![0.0; plan.columns.len()],
            pace: Pace::new(),
            next_time: 0.0,
            next_increment: 0,
            first: true,
            shown: [None; 2],
        }
    }

    pub(super) fn begin(&mut self, step: &StepPlan, first: bool, increment: u64) {
        self.field.begin(&step.outputs.field, increment);
        self.history.begin(&step.outputs.history, increment);
        self.first = first;
        self.next_time = 0.0;
    }

    /// Shows what is due: rows and frames at their marks, at the very start, and at the end of each step.
    #[inline]
    pub(super) fn show(&mut self, run: &mut Run<'_>, sink: &mut dyn Sink) -> Result<(), Halt> {
        if run.now.step_time < self.next_time
            && run.now.increment < self.next_increment
            && run.user.requested_action == RunAction::Continue
        {
            return Ok(());
        }
        let began = Stopwatch::now();
        let shown = self.show_due(run, sink);
        run.timing.add_output(began.elapsed().as_secs_f64());
        shown
    }

    fn show_due(&mut self, run: &Run<'_>, sink: &mut dyn Sink) -> Result<(), Halt> {
        let (step, time, increment) = (run.step, run.now.step_time, run.now.increment);
        let edge = std::mem::take(&mut self.first) || run.is_over();
        let frame = self.field.due(time, increment) || edge && !step.outputs.field.is_empty();
        if self.pace.due(increment) || frame || edge {
            tell_progress(run, frame, sink);
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

    /// The last complete instant before a halt, unless it has been shown. Of what deforms an instant that is not complete
    /// is no good state.
    pub(super) fn last(&mut self, run: &Run<'_>, sink: &mut dyn Sink) -> Result<(), Halt> {
        if !run.state.elements.is_empty() && !run.complete {
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

    fn show_frame(&mut self, run: &Run<'_>, sink: &mut dyn Sink) -> Result<(), Halt> {
        if !sink.wants_frames() {
            return Ok(());
        }
        self.shown[1] = Some(run.now.increment);
        sink.frame(&frame(run)).map_err(unwritten)
    }

    fn show_row(&mut self, run: &Run<'_>, sink: &mut dyn Sink) -> Result<(), Halt> {
        let energy = run.energy();
        for (i, column) in run.plan.columns.iter().enumerate() {
            self.row[i] = run.column_value(column, &energy, &self.row[..i]);
        }
        self.shown[0] = Some(run.now.increment);
        sink.row(&run.now, &self.row).map_err(unwritten)
    }
}

/// Tells the sink how far the run is.
fn tell_progress(run: &Run<'_>, frame: bool, sink: &mut dyn Sink) {
    let total: f64 = run.plan.steps.iter().map(|s| s.duration).sum();
    let limiting = if run.state.elements.is_empty() { (0, 0) } else { run.limits() };
    sink.progress(&Progress {
        step: &run.step.name,
        fraction: if total > 0.0 { (run.now.total_time / total).min(1.0) } else { 1.0 },
        now: run.now,
        increment: run.last_increment,
        limiting: run.plan.element_name(limiting.0, limiting.1),
        energy: &run.energy(),
        frame,
        ends: run.is_over(),
    });
}

pub(super) fn unwritten(why: SinkError) -> Halt {
    Halt { code: "R205", reason: why.to_string() }
}

persist_struct!(Rhythm { next_time, next_increment } derived { schedules });

persist_struct!(Observing { field, history, next_time, next_increment, first, shown } derived { row, pace });
