//! A run: its parts, the beginning of a step, and the seven operations of an increment.

use crate::state::archive::Persist;

use super::adaptive_meshes::{adapt_meshes, begin_domains, change_domains};
use super::central_difference::{advance_nodes, chunk_energies};
use super::guard::guard_increment;
use super::increment::{Increment, IncrementController, IncrementEnd};
use super::limits::{IncrementLimiter, IncrementLimits};
use super::mesh_quality::RemeshMonitor;
use super::outcome::{BodyRest, StepSummary};
use super::penetrations::record_ended_penetrations;
use super::position::RunPosition;
use super::release::ReleasedNodes;
use super::routines::UserSession;
use super::run_state::RunState;
use super::timing::EffectTiming;
use super::watch::RunReport;
use crate::constraint::motion::PrescribedMotion;
use crate::constraint::tie::TiedNodes;
use crate::constraint::{Constraint, of_kind, prescribed_motions};
use crate::element::frequency::ConstrainedNodes;
use crate::element::mass_scaling::StepMassScaling;
use crate::model::IncrementControl;
use crate::plan::{Plan, State, StepChanges};
use crate::state::halt::HaltReason;
use crate::state::magnitude::AmplitudeClock;
use crate::user::{FrictionInput, RunAction};

/// Data that an increment uses or changes. It is aligned so that the run time does not depend on the stack address.
#[repr(align(64))]
#[derive(Persist)]
// The state of a step that has begun; the effects in force are those of the step.
#[persist(derived: finds_onsets, forces_may_differ, threads, kinetic, timing)]
pub(super) struct SolverRun<'a> {
    pub(super) current: RunState<'a>,
    pub(super) user: UserSession,
    /// Warnings and results.
    pub(super) report: RunReport,
    /// New meshes of bodies.
    pub(super) remesh: RemeshMonitor,
    /// Nodes whose prescribed motion has ended at this instant.
    pub(super) released: ReleasedNodes,
    /// Group and element that limited the smallest increment of the step.
    pub(super) limiting: Option<(usize, usize)>,
    /// Whether increments in which a load begins suddenly are repeated in this step.
    pub(super) finds_onsets: bool,
    /// Whether a step has begun that may change the forces at this instant.
    forces_may_differ: bool,
    /// Whether other threads may be used.
    pub(super) threads: bool,
    /// Work array for the kinetic energies of chunks of nodes.
    pub(super) kinetic: Vec<f64>,
    pub(super) timing: EffectTiming<'a>,
}

impl<'a> SolverRun<'a> {
    pub(super) fn new(plan: &'a Plan, state: State, position: Option<&'a RunPosition>) -> Self {
        SolverRun {
            user: UserSession::default(),
            report: RunReport::default(),
            remesh: RemeshMonitor::new(plan),
            released: ReleasedNodes::default(),
            limiting: None,
            finds_onsets: false,
            forces_may_differ: false,
            threads: rayon::current_num_threads() > 1,
            kinetic: chunk_energies(&state.dofs.nodes),
            timing: EffectTiming::new(plan.ledger.effects.len(), position),
            current: RunState::new(plan, state),
        }
    }

    /// Locks the user subroutines for the run.
    pub(super) fn with_routines(self) -> Self {
        SolverRun { user: UserSession::new(&self.current.plan.routines), ..self }
    }

    /// Evaluates the current instant.
    ///
    /// # Errors
    /// If a force fails or a value is not finite.
    #[inline]
    pub(super) fn evaluate(&mut self) -> Result<(), HaltReason> {
        self.timing.resume(self.current.now.increment);
        self.evaluate_forces()?; //                          1. forces; resistances last
        self.resolve_onset()?;
        self.accelerate()?; //                               2. a = F / m; a resistance keeps a body at rest
        self.correct_velocity(); //                          3. velocity at the current instant
        self.current.update_balance(); //                    4. energy balance
        self.report.guard_energy(&mut self.current)?;
        self.timing.pause();
        Ok(()) //                                            5. output, in the time loop
    }

    /// Advances to the next instant. `next_output` is the step time at which output is due; it matters only while all
    /// bodies are at rest.
    ///
    /// # Errors
    /// If no further increment is possible, or a user subroutine fails.
    pub(super) fn advance(&mut self, control: &mut IncrementController, next_output: f64) -> Result<(), HaltReason> {
        self.timing.resume(self.current.now.increment);
        guard_increment(&self.current)?;
        let next = control.choose(&self.current, next_output); // 6. length of the next increment
        self.current.remember_stable_increment();
        next.check(&self.current.now)?;
        self.user.call_before(&mut self.current, next)?;
        self.make_increment(next)?; //                       7. v(i+1/2), u(i+1), and the velocity that loads receive
        self.record(next);
        self.timing.pause();
        Ok(())
    }

    /// Completes the summary of the step.
    pub(super) fn name_limiting_element(&mut self) {
        let Some(summary) = self.report.outcome.steps.last_mut() else { return };
        summary.global_estimates = self.current.state.elements.estimates();
        if let Some((group, element)) = self.limiting.take() {
            summary.limiting_element = Some(self.current.plan.element_name(group, element).to_owned());
        }
    }

    /// Returns whether the step is at its end, or a user subroutine has requested the end.
    pub(super) fn is_over(&self) -> bool {
        self.current.now.step_time >= self.current.step.duration || self.user.requested_action != RunAction::Continue
    }

    /// Begins the step with this index and applies its changes of effects; all other effects continue. Returns whether
    /// anything changes.
    pub(super) fn begin(&mut self, index: usize) -> bool {
        let run = &mut self.current;
        let (step, previous) = (&run.plan.steps[index], run.step);
        let heat_changes = run.state.heat_mut().is_some_and(|heat| heat.begin(index));
        let changes = index == 0 || heat_changes || !step.changes.is_empty();
        let releases = index > 0 && step.changes.constraints.is_some();
        let prescribed = if releases { run.sorted_prescribed_motions() } else { Vec::new() };
        self.put_in_force(&step.changes);
        let run = &mut self.current;
        self.released.find(prescribed, &run.sorted_prescribed_motions());
        run.use_step(step);
        if changes {
            run.body_forces.begin(&mut run.state);
            begin_constraints(run);
            run.balance.begin(&run.body_forces.slots, &run.state.dofs.bodies);
            self.report.watch.begin_step();
        }
        if step.energy_limit != previous.energy_limit {
            self.report.watch.limits_reported = [false; 2];
        }
        self.forces_may_differ = changes;
        (run.now.step_time, run.now.lost) = (0.0, 0.0);
        run.now.step += 1;
        if run.now.increment == 0 {
            run.show_own_velocity();
        }
        let (name, smallest_increment) = (step.name.clone(), f64::INFINITY);
        let limits = IncrementLimits::begin();
        // Masses scaled in the previous step stay scaled.
        let scaled = self.report.outcome.steps.last().filter(|_| run.state.scaling.is_some());
        let added_mass_at = scaled.and_then(|previous| previous.added_mass_at);
        let added_mass = scaled.and_then(|previous| previous.added_mass);
        let summary = StepSummary { name, smallest_increment, limits, added_mass, added_mass_at, ..Default::default() };
        self.report.outcome.steps.push(summary);
        self.report.watch.begin_drift_bound(run);
        self.begin_onsets();
        changes
    }

    fn put_in_force(&mut self, changes: &StepChanges) {
        let run = &mut self.current;
        if let Some(loads) = &changes.loads {
            let ended = loads.apply(&mut run.state.loads, |load, previous| load.continue_from(previous));
            self.report.warn_of_stiff_loads(run, &ended);
            record_ended_penetrations(&mut run.state, &ended);
        }
        if let Some(constraints) = &changes.constraints {
            let take_over =
                |constraint: &mut dyn Constraint, previous: &dyn Constraint| constraint.continue_from(previous);
            let mut ended = constraints.apply(&mut run.state.constraints, take_over);
            self.report.warn_of_constraints(run, &mut ended);
        }
        if let Some(motions) = &changes.user_motions {
            motions.apply(&mut run.state.user_motions, |_, _| {});
        }
        match &changes.scaling {
            Some(scaling) => run.state.scaling.clone_from(scaling),
            None => run.state.scaling.iter_mut().for_each(StepMassScaling::begin_step),
        }
        if let Some(domains) = &changes.adaptive {
            self.report.outcome.mesh_changes.extend(change_domains(&mut run.state, domains));
        }
    }

    /// Evaluates the forces at the start of a later step. If the forces on bodies have the same bits as before, bodies
    /// continue; otherwise their central differences start again, as after a jump of a force.
    ///
    /// # Errors
    /// If a force fails or a value is not finite.
    pub(super) fn evaluate_step_start(&mut self) -> Result<(), HaltReason> {
        if !std::mem::take(&mut self.forces_may_differ) || !self.current.complete {
            return Ok(());
        }
        // Without a previous increment its work is not added twice.
        let previous_dt = std::mem::take(&mut self.current.previous_dt);
        let bodies = self.current.state.dofs.bodies.clone();
        self.evaluate_accelerations()?;
        let run = &mut self.current;
        run.balance.take_forces(&run.body_forces.values);
        if run.state.dofs.bodies.iter().zip(&bodies).all(|(now, previous)| now.has_same_forces(previous)) {
            (run.state.dofs.bodies, run.previous_dt) = (bodies, previous_dt);
        } else if run.body_forces.tied > 0 {
            run.previous_dt = previous_dt;
            self.correct_velocity();
        } else {
            run.show_own_velocity();
        }
        Ok(())
    }

    /// Initialises user materials, and estimates the highest frequency from the elastic moduli and the prescribed
    /// motions.
    pub(super) fn begin_nodes(&mut self, changes: bool) -> Result<(), HaltReason> {
        let run = &mut self.current;
        if run.state.dofs.nodes.is_empty() || !changes {
            return Ok(());
        }
        if run.now.increment == 0 {
            run.state.elements.probe(&run.state.dofs.nodes, &run.now, self.user.routines.at_points())?;
            let energies = run.state.elements.available_energies(&run.state.dofs.nodes);
            run.balance.supply.begin(energies, run.plan.stiffening, run.plan.returns_heat);
        }
        let global = matches!(run.step.control, IncrementControl::Automatic { element_by_element: false, .. });
        let prescribed: Vec<_> = prescribed_motions(&run.state.constraints).collect();
        let carried: Vec<_> = of_kind::<TiedNodes>(&run.state.constraints).flat_map(|tie| tie.nodes.clone()).collect();
        let constrained = ConstrainedNodes { prescribed: &prescribed, carried: &carried };
        run.state.elements.begin_frequency(global, &run.state.dofs.nodes, &constrained);
        Ok(())
    }

    #[inline(always)]
    fn correct_velocity(&mut self) {
        if self.current.previous_dt != 0.0 {
            self.complete_velocities();
        }
    }

    /// Completes the velocities of bodies at the current instant, and prescribes velocities.
    #[inline(always)]
    fn complete_velocities(&mut self) {
        let RunState { state: State { dofs, constraints, user_amplitudes, .. }, now, previous_dt, .. } =
            &mut self.current;
        dofs.bodies.iter_mut().for_each(|body| body.complete_velocity(*previous_dt));
        let clock = AmplitudeClock { now: *now, user_amplitudes };
        of_kind::<PrescribedMotion>(constraints).for_each(|motion| motion.velocities(dofs, &clock));
    }

    #[inline(always)]
    pub(super) fn make_increment(&mut self, next: Increment) -> Result<(), HaltReason> {
        let dt = next.length;
        self.current.state.dofs.bodies.iter_mut().for_each(|body| body.advance(dt));
        if !self.current.state.dofs.nodes.is_empty() {
            self.advance_nodes(dt);
        }
        let RunState { state: State { dofs, constraints, user_amplitudes, .. }, now, step, .. } = &mut self.current;
        let mut outcome = Ok(());
        for constraint in constraints {
            let started = self.timing.start(constraint.effect());
            let clock = AmplitudeClock { now: *now, user_amplitudes };
            match self.user.routines.friction.as_deref_mut() {
                Some(routine) => {
                    let friction = FrictionInput { routine, arrival: next.arrival(now, step.duration) };
                    outcome = outcome.and(constraint.motion_with_friction(dofs, &clock, dt, friction));
                }
                None => constraint.motion(dofs, &clock, dt),
            }
            self.timing.stop(started, constraint.effect());
        }
        if self.current.state.thermal.is_some() {
            advance_temperatures(&mut self.current, dt);
        }
        let run = &mut self.current;
        for body in &mut run.state.dofs.bodies {
            body.show_velocity_after(run.velocity_extrapolation * dt);
        }
        run.complete = false;
        run.previous_instant = run.now;
        run.now = next.arrival(&run.now, run.step.duration);
        run.last_increment = dt;
        run.previous_dt = dt;
        // Central differences continue into the next step unless its forces on bodies differ.
        let goes_on = next.end == IncrementEnd::Step && (run.body_forces.tied > 0 || !run.is_last_step());
        if next.end != IncrementEnd::Plain && !goes_on {
            self.restart_integration(next.end);
        }
        outcome
    }

    #[inline(never)]
    fn advance_nodes(&mut self, dt: f64) {
        let RunState { state, now, .. } = &mut self.current;
        adapt_meshes(state, *now, dt, &mut self.timing);
        self.released.accelerate(&mut state.dofs.nodes, dt);
        advance_nodes(&state.elements, &mut state.dofs, dt);
        if let Some(free) = &state.elements.deletions.free_nodes {
            free.reflect(&mut state.dofs.nodes);
        }
        state.elements.mark_moved();
    }

    /// Starts central differences of bodies again with a half step after rest or a jump of a force, from the velocity
    /// at the current instant.
    #[inline(never)]
    fn restart_integration(&mut self, end: IncrementEnd) {
        self.complete_velocities();
        let run = &mut self.current;
        if let IncrementEnd::Rest(b) = end {
            run.state.dofs.bodies[b].arrest();
            let (body, displacement) = (run.plan.bodies[b].name.clone(), run.state.dofs.bodies[b].displacement);
            self.report.outcome.rests.push(BodyRest { body, time: run.now.total_time, displacement });
        }
        run.previous_dt = 0.0;
        run.show_own_velocity();
    }

    fn record(&mut self, Increment { length, by, .. }: Increment) {
        let (run, RunReport { watch, outcome }) = (&self.current, &mut self.report);
        outcome.increments = run.now.increment;
        let limiting = run.limits();
        if let Some(position) = self.timing.position {
            position.begin(&run.now, limiting);
        }
        if let (IncrementLimiter::Elements, Some(element)) = (by, limiting) {
            watch.collapse.count(length, run.previous_instant.total_time, element);
        }
        if let Some(summary) = outcome.steps.last_mut() {
            summary.increments += 1;
            summary.time = run.now.step_time;
            summary.limits.take(run.previous_instant.total_time, length, by, limiting.unwrap_or_default());
            // The last increment of a step is as long as the time that is left.
            let is_cut = matches!(by, IncrementLimiter::Step | IncrementLimiter::Rest);
            if length < summary.smallest_increment && (!is_cut || summary.smallest_increment.is_infinite()) {
                summary.smallest_increment = length;
                self.limiting = limiting;
            }
            if length > summary.largest_increment {
                summary.largest_increment = length;
            }
        }
    }
}

fn begin_constraints(run: &mut RunState<'_>) {
    let State { elements, constraints, loads, dofs, .. } = &mut run.state;
    elements.begin(constraints.iter().any(|c| c.moves_nodes()));
    let pushed = elements.has_links() || loads.iter().any(|l| l.targets().nodes);
    dofs.nodes.resize_forces(pushed);
    constraints.iter_mut().for_each(|c| c.begin(dofs));
    begin_domains(run);
}

#[inline(never)]
fn advance_temperatures(run: &mut RunState<'_>, dt: f64) {
    let State { thermal, constraints, user_amplitudes, .. } = &mut run.state;
    let Some(heat) = thermal.as_mut().and_then(|t| t.heat.as_mut()) else { return };
    heat.add_exchanged_heat(constraints, dt);
    heat.advance(&AmplitudeClock { now: run.now, user_amplitudes }, dt);
}
