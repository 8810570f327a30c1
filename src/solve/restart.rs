//! When a run's state is kept, going on from it, and the way back to the last good instant before a halt.
//! Never here: files (a [`Sink`] keeps the bytes), what single types consist of (`state::archive`).

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant as Stopwatch};

use super::body_forces::BodyForces;
use super::increment::IncrementController;
use super::observe::{Observing, Rhythm, unwritten};
use super::routines::UserSession;
use super::{Outcome, Rest, Run, Sink, SinkError, StepSummary};
use crate::plan::StepPlan;
use crate::state::Instant;
use crate::state::archive::{Archive, Persist, UnfitState, persist_fields, persist_struct};
use crate::state::halt::Halt;
use crate::user::{AnalysisMoment, RunAction, SavedMemory};

/// How often the state is kept, beside what the deck's `*RESTART, WRITE` asks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Every {
    /// So much time on the clock of the wall.
    Elapsed(Duration),
    /// So many increments.
    Increments(u64),
}

/// What a run is asked beside its plan.
#[derive(Clone, Copy, Debug, Default)]
pub struct Control<'a> {
    /// When to keep the state.
    pub every: Option<Every>,
    /// Number of a signal as soon as one has come, else 0: the run then ends behind its increment.
    pub interrupt: Option<&'a AtomicUsize>,
    /// State to go on from.
    pub state: Option<&'a [u8]>,
}

/// Increments between states that are held in memory for the way back: a state costs some ten increments.
const HELD_EVERY: u64 = 4096;
/// Looks at the clock are about this far apart: a look costs as much as an increment of a small scene.
const LOOK: Duration = Duration::from_millis(5);

/// Keeps states over a run.
pub(super) struct Checkpointer<'a> {
    control: Control<'a>,
    /// Of `*RESTART, WRITE`.
    asked: Rhythm,
    /// Whether the step before has asked for its end, which is where this one begins.
    owed: bool,
    /// When the state was kept last and when the clock was looked at last.
    kept: Stopwatch,
    looked: Stopwatch,
    /// Increments until the next look at the clock, and when it comes.
    stride: u64,
    next_look: u64,
    /// Whether states are held for the way back, and when the next is due.
    holds: bool,
    next_held: u64,
    /// Nothing is due before these.
    next_time: f64,
    next_increment: u64,
    state: Vec<u8>,
    /// Whether the state held is one of this step.
    has_state: bool,
}

impl<'a> Checkpointer<'a> {
    /// `holds`: whether the way back is open, which needs frames and what deforms, and no routine of the user, which would
    /// be called twice.
    pub(super) fn new(control: Control<'a>, holds: bool) -> Self {
        let now = Stopwatch::now();
        Checkpointer {
            control,
            asked: Rhythm::default(),
            owed: false,
            kept: now,
            looked: now,
            stride: 1,
            next_look: 0,
            holds,
            next_held: 0,
            next_time: 0.0,
            next_increment: 0,
            state: Vec::new(),
            has_state: false,
        }
    }

    /// A step begins, or goes on, at this instant.
    pub(super) fn begin(&mut self, step: &StepPlan, now: &Instant) {
        self.owed = !self.asked.is_empty();
        self.asked.begin(&step.outputs.restart, now.increment);
        self.asked.advance(now.step_time, now.increment);
        self.has_state = false;
        self.next_held = 0;
        self.plan_ahead(now);
    }

    fn plan_ahead(&mut self, now: &Instant) {
        self.next_time = self.asked.next_time;
        let every = match self.control.every {
            None => u64::MAX,
            Some(Every::Increments(n)) => (now.increment / n + 1) * n,
            Some(Every::Elapsed(_)) => self.next_look,
        };
        let held = if self.holds { self.next_held } else { u64::MAX };
        self.next_increment = if self.owed { 0 } else { self.asked.next_increment.min(every).min(held) };
    }

    /// Between two increments: keeps the state if that is due, and ends the run if a signal wants it.
    #[inline]
    pub(super) fn look(&mut self, at: &mut At<'_, '_>, sink: &mut dyn Sink) -> Result<(), Halt> {
        let now = &at.run.now;
        let signal = self.control.interrupt.map_or(0, |signal| signal.load(Ordering::Relaxed));
        if signal == 0 && now.increment < self.next_increment && now.step_time < self.next_time {
            return Ok(());
        }
        self.look_closely(at, sink, signal)
    }

    #[cold]
    fn look_closely(&mut self, at: &mut At<'_, '_>, sink: &mut dyn Sink, signal: usize) -> Result<(), Halt> {
        let now = at.run.now;
        let due = (self.is_due(&now) || signal != 0) && sink.keeps();
        let begin = Stopwatch::now();
        if due {
            at.run.tell_restart()?;
        }
        if due || self.holds && now.increment >= self.next_held {
            self.state.clear();
            at.write(&mut self.state);
            self.has_state = true;
            self.next_held = now.increment + HELD_EVERY;
        }
        if due {
            sink.keep(&self.state, &now).map_err(unwritten)?;
            at.run.tell_of_loss(sink);
            self.kept = Stopwatch::now();
            at.run.outcome.checkpoint_seconds += begin.elapsed().as_secs_f64();
        }
        self.plan_ahead(&now);
        if signal == 0 { Ok(()) } else { Err(interrupted(signal, &now)) }
    }

    fn is_due(&mut self, now: &Instant) -> bool {
        let asked = self.asked.due(now.step_time, now.increment) | std::mem::take(&mut self.owed);
        if asked {
            self.asked.advance(now.step_time, now.increment);
        }
        asked
            || match self.control.every {
                None => false,
                Some(Every::Increments(n)) => now.increment > 0 && now.increment.is_multiple_of(n),
                Some(Every::Elapsed(time)) => self.clock_is_due(now, time),
            }
    }

    /// Looks at the clock every so many increments, so that a look costs nothing beside them.
    fn clock_is_due(&mut self, now: &Instant, time: Duration) -> bool {
        if now.increment < self.next_look {
            return false;
        }
        let passed = self.looked.elapsed();
        self.looked = Stopwatch::now();
        self.stride = if passed < LOOK { 2 * self.stride } else { (self.stride / 2).max(1) };
        self.next_look = now.increment + self.stride;
        self.kept.elapsed() >= time
    }

    /// After a halt within an increment: goes back to the last instant that was complete, from the state held and over the
    /// same increments again.
    pub(super) fn way_back(&mut self, at: &mut At<'_, '_>) {
        if at.run.complete || !self.has_state || !self.holds {
            return;
        }
        let last = at.run.now.increment - 1;
        let mut archive = Archive::reader(&self.state);
        Head::default().persist(&mut archive);
        at.visit(&mut archive);
        // What this very run has written fits.
        let mut fits = archive.finish().is_ok();
        while fits && at.run.now.increment < last {
            fits = at.repeat().is_ok();
        }
        at.run.complete = fits;
    }
}

fn interrupted(signal: usize, now: &Instant) -> Halt {
    let name = match signal {
        2 => "SIGINT".into(),
        15 => "SIGTERM".into(),
        other => format!("signal {other}"),
    };
    let reason = format!("interrupted by {name} at increment {}, time {:e}", now.increment, now.total_time);
    Halt { code: "R207", reason }
}

/// What is said of a state that does not hold all of the user's routines.
pub const LOST: &str = "the checkpoint does not hold all that the user's routines keep to themselves";

/// Shows nothing: what is gone over again has been shown.
struct Nowhere;

impl Sink for Nowhere {
    fn wants_frames(&self) -> bool {
        true
    }
    fn row(&mut self, _now: &Instant, _values: &[f64]) -> Result<(), SinkError> {
        Ok(())
    }
}

/// A place between the output of an instant and the choice of the next increment, in a step that has begun.
pub(super) struct At<'r, 'p> {
    pub run: &'r mut Run<'p>,
    pub observing: &'r mut Observing,
    pub control: &'r mut IncrementController,
}

/// What stands before the state: the index of its step, and what the user's routines keep to themselves.
#[derive(Default)]
struct Head {
    step: usize,
    routines: SavedMemory,
}

persist_struct!(Head { step, routines });

/// What a state does not hold of the user's routines, in words; nothing where it holds all.
pub fn lost(state: &[u8]) -> Vec<String> {
    let mut head = Head::default();
    head.persist(&mut Archive::reader(state));
    head.routines.lost
}

impl At<'_, '_> {
    /// The state behind its head.
    fn write(&mut self, bytes: &mut Vec<u8>) {
        let mut archive = Archive::writer(bytes);
        let routines = self.run.plan.routines.memory.as_ref().map(|memory| memory.keep()).unwrap_or_default();
        let mut head = Head { step: self.run.now.step as usize - 1, routines };
        head.persist(&mut archive);
        self.run.outcome.lost = head.routines.lost;
        self.visit(&mut archive);
    }

    /// All that moves. What is not visited follows from the plan and the beginning of the step.
    fn visit(&mut self, archive: &mut Archive<'_>) {
        let At { run, observing, control } = self;
        archive.mark("run");
        run.persist(archive);
        persist_fields!(archive; &mut **observing, &mut **control);
        archive.mark("end");
    }

    /// The next increment, which is known to succeed, without showing anything.
    fn repeat(&mut self) -> Result<(), Halt> {
        let At { run, observing, control } = self;
        run.advance(control)?;
        run.evaluate()?;
        observing.show(run, &mut Nowhere)
    }
}

impl Persist for Run<'_> {
    /// In a step that has begun: the effects in force are those of the step.
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Run {
            plan: _,
            step: _,
            state,
            now,
            previous_instant,
            previous_dt,
            last_increment,
            velocity_extrapolation: _,
            previous_stable_increment: _,
            complete,
            forces_may_differ: _,
            user,
            body_forces,
            limiting,
            balance,
            watch,
            threads: _,
            kinetic: _,
            timing: _,
            outcome,
        } = self;
        persist_fields!(archive; now, previous_instant, previous_dt, last_increment, complete, user);
        persist_fields!(archive; body_forces, limiting, balance, watch, state, outcome);
    }
}

impl Persist for UserSession<'_> {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let UserSession { routines: _, requested_action, increment_reported, loss_reported: _, restored_memory: _ } =
            self;
        persist_fields!(archive; requested_action, increment_reported);
    }
}

// What forces there are follows from the effects in force.
persist_struct!(BodyForces { values: fixed } derived { slots, order_by_body, load_ends, tied, first_resistance });

// Halts and what is computed at the end are not there yet; times are those of this process.
persist_struct!(Outcome { steps, rests, increments, warnings } derived {
    halt, ended_by_user, energy, penetrations, unfinished, still_moving, exits, deleted, seconds, checkpoint_seconds, digest, lost,
    effect_seconds
});

impl Persist for RunAction {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let mut number = *self as u8;
        number.persist(archive);
        *self = [RunAction::Continue, RunAction::EndStep, RunAction::EndAnalysis]
            .into_iter()
            .find(|w| *w as u8 == number)
            .unwrap_or_default();
    }
}

persist_struct!(StepSummary {
    name,
    increments,
    time,
    smallest_increment,
    largest_increment,
    limiting_element,
    global_estimates,
    added_mass,
    limits
});

persist_struct!(Rest { body, time, displacement });

impl Run<'_> {
    /// Says once what the state that has been kept does not hold.
    fn tell_of_loss(&mut self, sink: &mut dyn Sink) {
        if !self.outcome.lost.is_empty() && !std::mem::replace(&mut self.user.loss_reported, true) {
            sink.warning(&format!("{LOST}: {}", self.outcome.lost.join("; ")));
        }
    }

    /// Tells the user's routine that the increment is complete and that its state will be kept.
    fn tell_restart(&mut self) -> Result<(), Halt> {
        let due = self.now.step_time > 0.0 && !self.user.increment_reported;
        if let Some(events) = self.user.routines.events.as_deref_mut().filter(|_| due) {
            events.restart_follows();
            self.tell(AnalysisMoment::EndIncrement, self.last_increment)?;
            self.user.increment_reported = true;
        }
        Ok(())
    }
}

/// Begins a step with what chooses its increments, which goes on where the step changes nothing. Returns whether it does.
pub(super) fn begin_step(
    run: &mut Run<'_>,
    index: usize,
    observing: &mut Observing,
    control: &mut Option<IncrementController>,
) -> bool {
    let control_before = run.step.control;
    let changes = run.begin(index) || run.step.control != control_before;
    observing.begin(run.step, run.now.increment == 0, run.now.increment);
    match control {
        Some(control) if !changes => control.continue_in(run.step, &run.state.dofs.bodies),
        _ => *control = Some(IncrementController::new(run.step, &run.state.dofs.bodies)),
    }
    changes
}

/// Takes up a state that was kept: the index of its step and the pace there.
///
/// # Errors
/// Why it is not one of this plan.
pub(super) fn take_up(
    run: &mut Run<'_>,
    observing: &mut Observing,
    state: &[u8],
) -> Result<(usize, IncrementController), UnfitState> {
    let mut archive = Archive::reader(state);
    let mut head = Head::default();
    head.persist(&mut archive);
    let Head { step: index, routines } = head;
    if index >= run.plan.steps.len() {
        return Err(UnfitState { reason: "it ends too early".into() });
    }
    // What is in force follows from the changes of all steps up to this one.
    let mut begun = None;
    (0..=index).for_each(|i| {
        begin_step(run, i, observing, &mut begun);
    });
    let mut control = begun.unwrap_or_else(|| IncrementController::new(run.step, &run.state.dofs.bodies));
    At { run, observing, control: &mut control }.visit(&mut archive);
    archive.finish()?;
    if let Some(memory) = &run.plan.routines.memory {
        memory.take_up(&routines)?;
    }
    run.user.restored_memory = routines;
    Ok((index, control))
}
