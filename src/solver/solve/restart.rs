//! Checkpoints: their schedule, continuing a run from one, and the return to the last complete instant before a halt. A
//! [`Sink`] stores the bytes; `state::archive` defines the format.

use std::fs::File;
use std::io::{BufWriter, Read as _, Seek as _};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant as Stopwatch};

use super::adaptive_meshes::restore_masses;
use super::increment::IncrementController;
use super::observe::{ClockReadings, OutputSchedule, RunOutput, output_failure, report_progress};
use super::position::RunPosition;
use super::{Sink, SinkError, SolverRun};
use crate::plan::StepPlan;
use crate::remesh::MeshRevision;
use crate::state::Instant;
use crate::state::archive::{Persist, StateArchive, UnfitState, persist_fields};
use crate::state::halt::{HaltDetails, HaltReason};
use crate::user::SavedMemory;

/// Interval of checkpoints, in addition to the deck's `*RESTART, WRITE`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CheckpointInterval {
    /// Wall-clock time.
    Elapsed(Duration),
    /// A number of increments.
    Increments(u64),
}

/// Control of a run in addition to its plan.
#[derive(Clone, Copy, Debug, Default)]
pub struct RunControl<'a> {
    /// Interval of checkpoints; `None` writes only those of the deck.
    pub every: Option<CheckpointInterval>,
    /// Number of the signal that has arrived, else 0; the run then ends after the current increment.
    pub interrupt: Option<&'a AtomicUsize>,
    /// Number of increments after which the run ends as by a signal.
    pub most_increments: Option<u64>,
    /// Saved state to continue from.
    pub state: Option<&'a [u8]>,
    /// Position of the run, for other threads.
    pub position: Option<&'a RunPosition>,
}

/// Signal of a run that has made its largest number of increments.
pub const END_OF_TRIAL: usize = usize::MAX;

/// Increments between states that are stored for [`Checkpointer::rewind`]; storing one costs about ten increments.
const HELD_EVERY: u64 = 4096;
/// Largest number of bytes of a state that is stored in memory if the sink has a file for it.
const MOST_IN_MEMORY: usize = 1 << 24;
/// Approximate time between two readings of the clock; one reading costs as much as an increment of a small model.
const LOOK: Duration = Duration::from_millis(5);

/// Writer of checkpoints during a run, with the stored states for a return to an earlier instant.
pub(super) struct Checkpointer<'a> {
    control: RunControl<'a>,
    /// Schedule of `*RESTART, WRITE`.
    schedule: OutputSchedule,
    /// Whether the previous step requested a checkpoint at its end, where this step begins.
    due_at_start: bool,
    /// Time of the last checkpoint.
    written: Stopwatch,
    clock: ClockReadings,
    /// Whether states are stored for the return to the last complete instant, and the increment of the next one.
    holds: bool,
    next_held: u64,
    /// Time before which no checkpoint is due, unless `next_increment` is reached.
    next_time: f64,
    next_increment: u64,
    /// Increment of the next checkpoint at an interval of increments; 0 before the first step. A new mesh at this increment
    /// only delays the checkpoint.
    next_of_interval: u64,
    /// State in memory: of the last checkpoint, or the stored one.
    state: Vec<u8>,
    /// File of the stored state, if it is large.
    file: Option<BufWriter<File>>,
    /// Whether the stored state is one of this step.
    has_state: bool,
}

impl<'a> Checkpointer<'a> {
    /// Creates the checkpointer of a run. `holds` states whether states are stored for a return to an earlier instant,
    /// which requires frames and deformable bodies, and excludes user subroutines, which would be called twice.
    pub(super) fn new(control: RunControl<'a>, holds: bool) -> Self {
        Checkpointer {
            control,
            schedule: OutputSchedule::default(),
            due_at_start: false,
            written: Stopwatch::now(),
            clock: ClockReadings::new(LOOK, 1),
            holds,
            next_held: 0,
            next_time: 0.0,
            next_increment: 0,
            next_of_interval: 0,
            state: Vec::new(),
            file: None,
            has_state: false,
        }
    }

    /// Begins a step, or continues one, at this instant.
    pub(super) fn begin(&mut self, step: &StepPlan, now: &Instant) {
        self.due_at_start = !self.schedule.is_empty();
        self.schedule.begin(&step.outputs.restart, now.increment);
        self.schedule.advance(now.step_time, now.increment);
        self.has_state = false;
        self.next_held = 0;
        if self.next_of_interval == 0 {
            self.next_of_interval = self.end_of_interval(now);
        }
        self.plan_ahead();
    }

    /// Returns the increment after an instant at which an interval of increments ends.
    fn end_of_interval(&self, now: &Instant) -> u64 {
        match self.control.every {
            Some(CheckpointInterval::Increments(n)) => (now.increment / n + 1) * n,
            _ => u64::MAX,
        }
    }

    fn plan_ahead(&mut self) {
        self.next_time = self.schedule.next_time;
        let every = match self.control.every {
            Some(CheckpointInterval::Elapsed(_)) => self.clock.next,
            _ => self.next_of_interval,
        };
        let next_stored = if self.holds { self.next_held } else { u64::MAX };
        let next_stored = next_stored.min(self.control.most_increments.unwrap_or(u64::MAX));
        self.next_increment =
            if self.due_at_start { 0 } else { self.schedule.next_increment.min(every).min(next_stored) };
    }

    /// Writes a checkpoint between two increments if one is due, and ends the run after a signal.
    #[inline]
    pub(super) fn write_if_due(&mut self, at: &mut RunCursor<'_, '_>, sink: &mut dyn Sink) -> Result<(), HaltReason> {
        let now = &at.run.current.now;
        let signal = self.control.interrupt.map_or(0, |signal| signal.load(Ordering::Relaxed));
        if signal == 0 && now.increment < self.next_increment && now.step_time < self.next_time {
            return Ok(());
        }
        self.write_now(at, sink, signal)
    }

    #[cold]
    fn write_now(&mut self, at: &mut RunCursor<'_, '_>, sink: &mut dyn Sink, signal: usize) -> Result<(), HaltReason> {
        let now = at.run.current.now;
        let is_last = self.control.most_increments.is_some_and(|most| now.increment >= most);
        let signal = if is_last { END_OF_TRIAL } else { signal };
        if signal != 0 {
            self.control.position.iter().for_each(|position| position.end());
        }
        let due = (self.is_due(&now) || signal != 0) && sink.keeps();
        let begin = Stopwatch::now();
        if due {
            at.run.user.announce_checkpoint(&at.run.current)?;
        }
        let stores = self.holds && (due || now.increment >= self.next_held);
        if stores {
            self.store(at, sink, if due { SavedFor::Restart } else { SavedFor::Rewind });
            self.next_held = now.increment + HELD_EVERY;
        }
        if due {
            if !stores || self.file.is_some() {
                at.write(&mut self.state, SavedFor::Restart);
            }
            sink.keep(&self.state, &now).map_err(output_failure)?;
            if self.file.is_some() {
                self.state = Vec::new();
            }
            at.warn_of_lost_memory(sink);
            self.written = Stopwatch::now();
            at.run.report.outcome.checkpoint_seconds += begin.elapsed().as_secs_f64();
        }
        self.plan_ahead();
        if signal == 0 {
            return Ok(());
        }
        report_progress(&at.run.current, false, false, sink);
        Err(interrupted(signal, &now))
    }

    /// Stores the state for a return to this instant: a large one in a file of the sink, if there is one.
    fn store(&mut self, at: &mut RunCursor<'_, '_>, sink: &mut dyn Sink, purpose: SavedFor) {
        if self.file.is_none() && at.length() > MOST_IN_MEMORY {
            self.file = sink.unnamed_file().map(BufWriter::new);
        }
        self.has_state = match &mut self.file {
            // A later state may be shorter.
            Some(file) => file.rewind().is_ok() && file.get_ref().set_len(0).is_ok() && at.write_to(file).is_ok(),
            None => {
                at.write(&mut self.state, purpose);
                true
            }
        };
    }

    /// Returns the stored state.
    fn stored(&mut self) -> &[u8] {
        if let Some(file) = &mut self.file {
            self.state.clear();
            // An incomplete state does not fit.
            let _ = file.rewind().and_then(|()| file.get_mut().read_to_end(&mut self.state));
        }
        &self.state
    }

    fn is_due(&mut self, now: &Instant) -> bool {
        let is_requested = self.schedule.due(now.step_time, now.increment) | std::mem::take(&mut self.due_at_start);
        if is_requested {
            self.schedule.advance(now.step_time, now.increment);
        }
        let is_of_interval = match self.control.every {
            None => false,
            Some(CheckpointInterval::Increments(_)) => now.increment >= self.next_of_interval,
            Some(CheckpointInterval::Elapsed(time)) => self.clock.due(now.increment) && self.written.elapsed() >= time,
        };
        if is_of_interval {
            self.next_of_interval = self.end_of_interval(now);
        }
        is_requested || is_of_interval
    }

    /// Returns to the last complete instant after a halt within an increment: restores the stored state and repeats the
    /// increments since then.
    pub(super) fn rewind(&mut self, at: &mut RunCursor<'_, '_>) {
        if at.run.current.complete || !self.has_state || !self.holds {
            return;
        }
        let last = at.run.current.now.increment - 1;
        let (_, mut archive) = CheckpointHead::read(self.stored());
        at.visit(&mut archive);
        // The state was written by this run, so it fits unless its file cannot be read.
        let mut fits = archive.finish().is_ok();
        while fits && at.run.current.now.increment < last {
            fits = at.repeat().is_ok();
        }
        at.run.current.complete = fits;
    }
}

fn interrupted(signal: usize, now: &Instant) -> HaltReason {
    let name = match signal {
        2 => "SIGINT".into(),
        15 => "SIGTERM".into(),
        other => format!("signal {other}"),
    };
    let reason = format!("interrupted by {name} at increment {}, time {:e}", now.increment, now.total_time);
    HaltReason::Interrupted(HaltDetails::new(reason))
}

/// Message for a checkpoint without all memory of the user subroutines.
pub const LOST: &str = "the checkpoint does not contain all memory of the user subroutines";

/// Sink that discards output, because repeated increments have been written before.
struct DiscardingSink;

impl Sink for DiscardingSink {
    fn wants_frames(&self) -> bool {
        true
    }
    fn row(&mut self, _now: &Instant, _values: &[f64]) -> Result<(), SinkError> {
        Ok(())
    }
}

/// State of a run between the output of an instant and the choice of the next increment.
pub(super) struct RunCursor<'r, 'p> {
    pub run: &'r mut SolverRun<'p>,
    pub observing: &'r mut RunOutput,
    pub control: &'r mut IncrementController,
}

/// Header of a saved state: index of the step, memory of the user subroutines, and the meshes that bodies had.
#[derive(Default, Persist)]
struct CheckpointHead {
    step: usize,
    routines: SavedMemory,
    revisions: Vec<MeshRevision>,
}

/// What a state is saved for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum SavedFor {
    /// Another run, which needs all new meshes.
    Restart,
    /// A return of this run to an earlier instant of its mesh.
    Rewind,
}

impl CheckpointHead {
    /// Reads the header of a saved state. Returns also the archive of the rest.
    fn read(state: &[u8]) -> (CheckpointHead, StateArchive<'_>) {
        let (mut head, mut archive) = (CheckpointHead::default(), StateArchive::reader(state));
        head.persist(&mut archive);
        (head, archive)
    }
}

/// Returns descriptions of the user memory that a saved state does not contain; empty if it is complete.
pub fn lost(state: &[u8]) -> Vec<String> {
    CheckpointHead::read(state).0.routines.lost
}

/// Returns the new meshes that bodies had when a state was saved.
pub(super) fn saved_revisions(state: &[u8]) -> Vec<MeshRevision> {
    CheckpointHead::read(state).0.revisions
}

impl RunCursor<'_, '_> {
    /// Replaces bytes by header and state. The memory is reserved first, so that a buffer that grows does not take twice
    /// as much.
    fn write(&mut self, bytes: &mut Vec<u8>, purpose: SavedFor) {
        let mut routines =
            self.run.current.plan.routines.memory.as_ref().map(|memory| memory.save()).unwrap_or_default();
        let mut length = 0;
        self.visit_with_head((&mut routines, purpose), &mut StateArchive::counter(&mut length));
        bytes.clear();
        bytes.reserve_exact(length);
        self.visit_with_head((&mut routines, purpose), &mut StateArchive::writer(bytes));
        self.run.report.outcome.lost = routines.lost;
    }

    /// Writes header and state to the file of stored states. There is no memory of user subroutines.
    fn write_to(&mut self, file: &mut BufWriter<File>) -> Result<(), UnfitState> {
        let mut archive = StateArchive::stream(file);
        self.visit_with_head((&mut SavedMemory::default(), SavedFor::Rewind), &mut archive);
        archive.finish()
    }

    /// Returns the number of bytes of the state without its header.
    fn length(&mut self) -> usize {
        let mut length = 0;
        self.visit(&mut StateArchive::counter(&mut length));
        length
    }

    fn visit_with_head(&mut self, (routines, purpose): (&mut SavedMemory, SavedFor), archive: &mut StateArchive<'_>) {
        let step = self.run.current.now.step as usize - 1;
        let mut none = Vec::new();
        let revisions = match purpose {
            SavedFor::Restart => &mut self.run.remesh.revisions,
            SavedFor::Rewind => &mut none,
        };
        let mut head =
            CheckpointHead { step, routines: std::mem::take(routines), revisions: std::mem::take(revisions) };
        head.persist(archive);
        (*routines, *revisions) = (head.routines, head.revisions);
        self.visit(archive);
    }

    /// Visits everything that changes in a run. The rest follows from the plan and the start of the step.
    fn visit(&mut self, archive: &mut StateArchive<'_>) {
        let RunCursor { run, observing, control } = self;
        archive.mark("run");
        run.persist(archive);
        persist_fields!(archive; &mut **observing, &mut **control);
        archive.mark("end");
    }

    /// Repeats the next increment, which has succeeded before, without output.
    fn repeat(&mut self) -> Result<(), HaltReason> {
        let RunCursor { run, observing, control } = self;
        run.advance(control, observing.next_time)?;
        observing.add_motion(&run.current);
        run.evaluate()?;
        observing.show(run, &mut DiscardingSink)
    }

    /// Warns once of memory that the checkpoint does not contain.
    fn warn_of_lost_memory(&mut self, sink: &mut dyn Sink) {
        let lost = &self.run.report.outcome.lost;
        if !lost.is_empty() && !std::mem::replace(&mut self.run.user.loss_reported, true) {
            sink.warning(&format!("K102: {LOST}: {}", lost.join("; ")));
        }
    }
}

/// Begins a step. The increment controller continues if the step changes no effects. Returns whether it changes any.
pub(super) fn begin_step(
    run: &mut SolverRun<'_>,
    index: usize,
    observing: &mut RunOutput,
    control: &mut Option<IncrementController>,
) -> bool {
    let control_before = run.current.step.control;
    let changes = run.begin(index) || run.current.step.control != control_before;
    observing.begin(&run.current);
    match control {
        Some(control) if !changes => control.continue_in(run.current.step, &run.current.state.dofs.bodies),
        _ => *control = Some(IncrementController::new(run.current.step, &run.current.state.dofs.bodies)),
    }
    changes
}

/// Restores a saved state; returns the index of its step and the increment controller.
///
/// # Errors
/// If the state does not belong to this plan.
pub(super) fn restore(
    run: &mut SolverRun<'_>,
    observing: &mut RunOutput,
    state: &[u8],
) -> Result<(usize, IncrementController), UnfitState> {
    let (CheckpointHead { step: index, routines, revisions }, mut archive) = CheckpointHead::read(state);
    run.remesh.revisions = revisions;
    if index >= run.current.plan.steps.len() {
        return Err(UnfitState { reason: "it is incomplete".into() });
    }
    // The effects in force follow from the changes of all steps up to this one.
    let mut begun = None;
    (0..=index).for_each(|i| {
        begin_step(run, i, observing, &mut begun);
    });
    let mut control =
        begun.unwrap_or_else(|| IncrementController::new(run.current.step, &run.current.state.dofs.bodies));
    RunCursor { run, observing, control: &mut control }.visit(&mut archive);
    archive.finish()?;
    restore_masses(&mut run.current.state);
    if let Some(memory) = &run.current.plan.routines.memory {
        memory.restore(&routines)?;
    }
    run.user.restored_memory = routines;
    Ok((index, control))
}
