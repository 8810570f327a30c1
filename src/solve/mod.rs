//! The time loop: steps and their increments.
//! Never here: what happens in an increment, deck words, files.

mod body_forces;
mod body_surfaces;
mod central_difference;
mod digest;
mod energy;
mod frames;
mod guard;
mod increment;
mod limits;
mod observe;
mod outcome;
mod penetrations;
mod restart;
mod routines;
mod run;
mod timing;
mod watch;

use std::time::Instant as Stopwatch;

use crate::plan::{Plan, State};
pub use crate::state::Instant;
pub use crate::state::archive::UnfitState;
pub use crate::state::halt::Halt;
use crate::user::RunAction;
pub use energy::Energy;
pub use frames::node_value;
use increment::IncrementController;
pub use limits::{Limits, LimitsOverTime};
use observe::Observing;
pub use observe::{Progress, Sink, SinkError};
pub use outcome::{Exit, Outcome, PenetrationSummary, Rest, StepSummary};
use restart::{At, Checkpointer, begin_step, take_up};
pub use restart::{Control, Every, LOST, lost};
use run::Run;

/// Runs a plan from a state at its start to its end, showing every due instant to `sink`.
///
/// ```
/// use revolve::solve::{self, Instant, Sink, SinkError};
/// use revolve::{deck, model, plan, user::Routines};
///
/// /// Prints each row of the history.
/// struct Print;
/// impl Sink for Print {
///     fn row(&mut self, now: &Instant, values: &[f64]) -> Result<(), SinkError> {
///         println!("{} {:e} {values:?}", now.step, now.total_time);
///         Ok(())
///     }
/// }
///
/// let (deck, found) = deck::read("input/ogive.inp".as_ref(), &[]);
/// assert!(!found.has_errors());
/// let (model, _) = model::build(&deck);
/// let (plan, start, _) = plan::compile(&model, &Routines::none());
/// let (first, _) = solve::run(&plan, start.clone(), &mut Print);
/// let (second, end) = solve::run(&plan, start, &mut Print);
/// assert_eq!(first.digest, second.digest); // A plan runs as often as one likes, to the same bits.
/// assert_eq!(end.dofs.bodies.len(), 1);
/// ```
pub fn run(plan: &Plan, state: State, sink: &mut dyn Sink) -> (Outcome, State) {
    // Without a state to go on from there is none that could be refused.
    run_with(plan, state, sink, Control::default()).unwrap_or_default()
}

/// The same, keeping the state now and then, from the start or from a state that was kept. Threads are those of the pool in
/// which it is called.
///
/// # Errors
/// Why a state is not one of this plan.
pub fn run_with(
    plan: &Plan,
    state: State,
    sink: &mut dyn Sink,
    asked: Control<'_>,
) -> Result<(Outcome, State), UnfitState> {
    let begin = Stopwatch::now();
    if plan.steps.is_empty() {
        return Ok((Outcome::default(), state));
    }
    let mut run = Run::new(plan, state);
    plan.routines.memory.iter().for_each(|memory| memory.begin());
    let mut observing = Observing::new(plan);
    let (mut first, mut control, mut restored) = (0, None, false);
    if let Some(kept) = asked.state {
        let (index, taken_up) = take_up(&mut run, &mut observing, kept)?;
        (first, control, restored) = (index, Some(taken_up), true);
    }
    let mut keeping =
        Checkpointer::new(asked, !run.state.elements.is_empty() && sink.wants_frames() && !plan.routines.any());
    for index in first..plan.steps.len() {
        let begins = if std::mem::take(&mut restored) { Begins::Restored } else { Begins::Step(index) };
        if let Err(halt) = step(&mut run, begins, &mut control, &mut observing, &mut keeping, sink) {
            run.step_back();
            let written = observing.last(&run, sink);
            run.outcome.halt = Some(written.err().unwrap_or(halt));
            break;
        }
        if run.user.requested_action == RunAction::EndAnalysis {
            run.outcome.ended_by_user = true;
            break;
        }
    }
    if run.outcome.halt.is_none() {
        run.outcome.halt = run.judge_end().err();
    }
    plan.routines.memory.iter().for_each(|memory| memory.end());
    run.warn_of_effects();
    run.warn_of_energy();
    run.report_penetrations();
    show_warnings(&mut run, sink);
    run.outcome.digest = run.digest();
    run.outcome.deleted = run.state.elements.deleted();
    let energy = run.energy();
    let Run { mut outcome, state: end, timing, .. } = run;
    outcome.energy = energy;
    outcome.seconds = begin.elapsed().as_secs_f64();
    outcome.effect_seconds = timing.seconds(plan, outcome.seconds - outcome.checkpoint_seconds);
    Ok((outcome, end))
}

/// Shows the sink what is new among the warnings.
#[inline(always)]
fn show_warnings(run: &mut Run<'_>, sink: &mut dyn Sink) {
    if run.watch.shown < run.outcome.warnings.len() {
        run.outcome.warnings[run.watch.shown..].iter().for_each(|warning| sink.warning(warning));
        run.watch.shown = run.outcome.warnings.len();
    }
}

/// Where a step begins.
#[derive(Clone, Copy)]
enum Begins {
    /// At its start; counted from 0.
    Step(usize),
    /// In the middle, from a state that was kept.
    Restored,
}

/// One step, with what chooses its increments, which goes on from step to step. The recipe of an increment, as in ABAQUS Theory Guide
/// 2.4.5 with the half-step start, is what [`Run::evaluate`] and [`Run::advance`] do in turn.
fn step(
    run: &mut Run<'_>,
    begins: Begins,
    control: &mut Option<IncrementController>,
    observing: &mut Observing,
    keeping: &mut Checkpointer<'_>,
    sink: &mut dyn Sink,
) -> Result<(), Halt> {
    let mut changes = false;
    if let Begins::Step(index) = begins {
        changes = begin_step(run, index, observing, control);
    }
    let Some(control) = control else { return Ok(()) };
    keeping.begin(run.step, &run.now);
    let begun = match begins {
        Begins::Restored => run.resume_routines().and_then(|()| run.advance(control)),
        Begins::Step(_) => run.begin_routines().and_then(|()| run.begin_nodes(changes)),
    };
    let end = begun.and_then(|()| increments(run, control, observing, keeping, sink));
    if end.is_err() {
        keeping.way_back(&mut At { run, observing, control });
    }
    run.name_limiting_element();
    end
}

fn increments(
    run: &mut Run<'_>,
    control: &mut IncrementController,
    observing: &mut Observing,
    keeping: &mut Checkpointer<'_>,
    sink: &mut dyn Sink,
) -> Result<(), Halt> {
    run.evaluate_step_start()?;
    loop {
        if !run.complete {
            run.evaluate()?;
        }
        show_warnings(run, sink);
        observing.show(run, sink)?;
        if run.is_over() {
            return run.end_routines();
        }
        keeping.look(&mut At { run, observing, control }, sink)?;
        run.advance(control)?;
    }
}
