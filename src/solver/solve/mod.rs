//! Time loop: steps and their increments.

mod adaptive_meshes;
mod body_forces;
mod body_surfaces;
mod central_difference;
mod collapse;
mod contact_losses;
mod contact_means;
mod digest;
mod energy;
mod energy_supply;
mod forces;
mod frames;
mod guard;
mod increment;
mod limits;
mod masses;
mod merging;
mod mesh_patch;
mod mesh_quality;
mod missing_action;
mod new_mesh_state;
mod observe;
mod onset;
mod outcome;
mod penetrations;
mod position;
mod ranges;
mod reaction_means;
mod release;
mod remesh;
mod restart;
mod routines;
mod run;
mod run_state;
mod shot_derivatives;
mod staged_shots;
mod timing;
mod volumes;
mod watch;

use std::time::Instant as Stopwatch;

use crate::output::OutputFrame;
use crate::plan::{Plan, State};
pub use crate::state::Instant;
pub use crate::state::archive::UnfitState;
pub use crate::state::halt::{HaltDetails, HaltReason};
use crate::user::RunAction;
pub use energy::Energy;
pub use frames::node_value;
use guard::located;
use increment::IncrementController;
pub use limits::{IncrementLimits, LimitsOverTime};
use observe::RunOutput;
pub use observe::{Progress, Sink, SinkError};
pub use outcome::{
    AddedMassPlaces, BodyExit, BodyRest, ContactLosses, ImpactEnd, MeshChanges, MeshShape, Outcome, PenetrationSummary,
    RangeShare, RunEnd, StepSummary,
};
pub use position::RunPosition;
use remesh::{DetachedRun, NextMesh, next_mesh, plan_of_revisions};
pub use restart::{CheckpointInterval, END_OF_TRIAL, LOST, RunControl, lost};
use restart::{Checkpointer, RunCursor, begin_step, restore, saved_revisions};
use run::SolverRun;
use run_state::RunState;
pub use shot_derivatives::{FinalRow, ShotInputs};
pub use staged_shots::StagedShots;
use watch::RunReport;

/// Runs a plan from its initial state to the end; rows and frames are passed to `sink`.
///
/// ```
/// # std::env::set_current_dir("../..").expect("the folder of the project");
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
/// let (deck, diagnostics) = deck::read("input/ogive.inp".as_ref(), &[]);
/// assert!(!diagnostics.has_errors());
/// let (model, _) = model::build(&deck);
/// let plan::CompiledModel { plan, state: start, .. } = plan::compile(&model, &Routines::none());
/// let (first, _) = solve::run(&plan, start.clone(), &mut Print);
/// let (second, end) = solve::run(&plan, start, &mut Print);
/// assert_eq!(first.digest, second.digest); // A plan runs as often as one likes, to the same bits.
/// assert_eq!(end.dofs.bodies.len(), 1);
/// ```
pub fn run(plan: &Plan, state: State, sink: &mut dyn Sink) -> (Outcome, State) {
    // Without a saved state no error is possible.
    run_with(plan, state, sink, RunControl::default()).unwrap_or_default()
}

/// Runs a plan with control over checkpoints and interruption, from the initial or a saved state. It uses the thread
/// pool in which it is called.
///
/// # Errors
/// If the saved state does not belong to this plan.
pub fn run_with(
    plan: &Plan,
    state: State,
    sink: &mut dyn Sink,
    control: RunControl<'_>,
) -> Result<(Outcome, State), UnfitState> {
    let begin = Stopwatch::now();
    if plan.steps.is_empty() {
        return Ok((Outcome::default(), state));
    }
    // A saved state with new meshes belongs to the plan of the last one.
    let revisions = control.state.map(saved_revisions).unwrap_or_default();
    let mut replaced = match &revisions[..] {
        [] => (None, state),
        meshes => plan_of_revisions(plan, meshes).map(|(plan, state)| (Some(plan), state)).ok_or_else(unfit_meshes)?,
    };
    let mut keeping = None;
    let mut session: Option<RunSession> = None;
    let mut detached = None;
    loop {
        let plan = replaced.0.as_deref().unwrap_or(plan);
        let mut run = match detached.take() {
            Some(detached) => DetachedRun::attach(detached, plan, control.position),
            None => SolverRun::new(plan, std::mem::take(&mut replaced.1), control.position).with_routines(),
        };
        let session = match &mut session {
            Some(session) => session,
            None => {
                plan.routines.memory.iter().for_each(|memory| memory.begin());
                session.insert(RunSession::begin(&mut run, control)?)
            }
        };
        let keeping = keeping.get_or_insert_with(|| {
            let holds = !run.current.state.dofs.nodes.is_empty() && sink.wants_last_instant() && !plan.routines.any();
            Checkpointer::new(control, holds)
        });
        match session.run_steps(&mut run, keeping, sink) {
            None => return Ok(finished(run, begin.elapsed().as_secs_f64(), sink)),
            Some(NextMesh { plan, run: next }) => {
                drop(run);
                (replaced.0, detached) = (Some(plan), Some(next));
            }
        }
    }
}

fn unfit_meshes() -> UnfitState {
    UnfitState { reason: "its meshes do not belong to the deck".into() }
}

/// The part of a run that does not depend on the mesh: the place among the steps, output and increment control.
struct RunSession {
    /// Way in which the next step begins.
    begins: StepStart,
    control: Option<IncrementController>,
    observing: RunOutput,
}

impl RunSession {
    fn begin(run: &mut SolverRun<'_>, control: RunControl<'_>) -> Result<RunSession, UnfitState> {
        let mut observing = RunOutput::new(run.current.plan);
        let Some(saved_state) = control.state else {
            return Ok(RunSession { begins: StepStart::Step(0), control: None, observing });
        };
        let (index, control) = restore(run, &mut observing, saved_state)?;
        Ok(RunSession { begins: StepStart::Within(index), control: Some(control), observing })
    }

    /// Runs the steps until a body has a new mesh, or to the end.
    fn run_steps(
        &mut self,
        run: &mut SolverRun<'_>,
        keeping: &mut Checkpointer<'_>,
        sink: &mut dyn Sink,
    ) -> Option<NextMesh> {
        while let StepStart::Step(index) | StepStart::Within(index) | StepStart::NewMesh(index) = self.begins
            && index < run.current.plan.steps.len()
        {
            match self.run_step(run, keeping, sink) {
                Ok(None) => self.begins = StepStart::Step(index + 1),
                Ok(Some(next)) => {
                    self.begins = StepStart::NewMesh(index);
                    return Some(next);
                }
                Err(halt) => {
                    let halted_at = run.current.now;
                    run.current.step_back();
                    let written = self.observing.last(&run.current, sink);
                    let halt = written.err().unwrap_or(halt);
                    run.report.outcome.halt = Some(located(&run.current, halt, halted_at));
                    break;
                }
            }
            if run.user.requested_action == RunAction::EndAnalysis {
                run.report.outcome.ended_by_user = true;
                break;
            }
        }
        None
    }

    /// Runs one step; the increment control continues from step to step. Each increment is [`SolverRun::evaluate`] followed
    /// by [`SolverRun::advance`], as in ABAQUS Theory Guide 2.4.5 with a half step at the start.
    fn run_step(
        &mut self,
        run: &mut SolverRun<'_>,
        keeping: &mut Checkpointer<'_>,
        sink: &mut dyn Sink,
    ) -> Result<Option<NextMesh>, HaltReason> {
        let RunSession { begins, control, observing } = self;
        let changes = match *begins {
            StepStart::Step(index) => begin_step(run, index, observing, control),
            StepStart::Within(_) | StepStart::NewMesh(_) => false,
        };
        let Some(control) = control else { return Ok(None) };
        keeping.begin(run.current.step, &run.current.now);
        let begun = match begins {
            StepStart::Within(_) => {
                run.user.resume(&run.current).and_then(|()| run.advance(control, observing.next_time))
            }
            StepStart::NewMesh(_) => run.advance(control, observing.next_time),
            StepStart::Step(_) => run.user.begin(&mut run.current).and_then(|()| run.begin_nodes(changes)),
        };
        let end = begun.and_then(|()| increments(run, control, observing, keeping, sink));
        if end.is_err() {
            keeping.rewind(&mut RunCursor { run, observing, control });
        }
        run.name_limiting_element();
        end
    }
}

/// Completes the outcome of a run.
fn finished(run: SolverRun<'_>, seconds: f64, sink: &mut dyn Sink) -> (Outcome, State) {
    let SolverRun { mut current, mut report, remesh, timing, .. } = run;
    let plan = current.plan;
    timing.position.iter().for_each(|position| position.end());
    report.warn_of_sections(&current, true);
    if report.outcome.halt.is_none() {
        let halt = report.check_final_drift(&current).err();
        report.outcome.halt = halt.map(|halt| located(&current, halt, current.now));
    }
    plan.routines.memory.iter().for_each(|memory| memory.end());
    report.warn_of_effects(&mut current);
    report.warn_of_energy(&mut current);
    if let Some(warning) = report.watch.collapse.final_warning(&current) {
        report.outcome.warn("R307", warning);
    }
    report.outcome.report_penetrations(&current);
    show_warnings(&mut report, sink);
    let mut outcome = report.outcome;
    if sink.wants_digest() {
        outcome.digest = digest::digest(&current);
    }
    outcome.deleted = current.state.elements.deletions.count();
    outcome.contact_losses = contact_losses::losses_of(&current);
    outcome.new_meshes = remesh.counts(plan);
    outcome.last_rows = plan.remesh.as_ref().map(|_| plan.ledger.effects.clone());
    outcome.mesh_shape = mesh_quality::shape_of(&current.state);
    outcome.energy = current.energy();
    outcome.mesh_changes.extend(current.state.adaptive.iter().map(adaptive_meshes::changes_of));
    outcome.seconds = seconds;
    outcome.effect_seconds = timing.seconds(plan, outcome.seconds - outcome.checkpoint_seconds);
    (outcome, current.state)
}

/// Returns the frame of the initial state, and the state unchanged.
pub fn initial_frame(plan: &Plan, state: State) -> (OutputFrame, State) {
    if plan.steps.is_empty() {
        return (OutputFrame::default(), state);
    }
    let run = RunState::new(plan, state);
    (frames::frame(&run), run.state)
}

/// Passes new warnings to the sink.
#[inline(always)]
fn show_warnings(RunReport { watch, outcome }: &mut RunReport, sink: &mut dyn Sink) {
    if watch.shown < outcome.warnings.len() {
        outcome.warnings[watch.shown..].iter().for_each(|warning| sink.warning(warning));
        watch.shown = outcome.warnings.len();
    }
}

/// Way in which a step begins.
#[derive(Clone, Copy)]
enum StepStart {
    /// At its beginning; index from 0.
    Step(usize),
    /// Within the step with this index, from a saved state.
    Within(usize),
    /// Within the step with this index, with a new mesh.
    NewMesh(usize),
}

fn increments(
    run: &mut SolverRun<'_>,
    control: &mut IncrementController,
    observing: &mut RunOutput,
    keeping: &mut Checkpointer<'_>,
    sink: &mut dyn Sink,
) -> Result<Option<NextMesh>, HaltReason> {
    run.evaluate_step_start()?;
    loop {
        if !run.current.complete {
            observing.add_motion(&run.current);
            run.evaluate()?;
        }
        show_warnings(&mut run.report, sink);
        observing.show(run, sink)?;
        if run.is_over() {
            return run.user.end(&run.current).map(|()| None);
        }
        // Before a checkpoint, so that a resumed run does not check the same mesh again.
        if let Some(body) = run.remesh.body_to_mesh(&run.current)
            && let Some(next) = next_mesh(run, body, observing)?
        {
            return Ok(Some(next));
        }
        keeping.write_if_due(&mut RunCursor { run, observing, control }, sink)?;
        run.advance(control, observing.next_time)?;
    }
}
