//! A run: the data of an increment, and its seven operations.

use crate::state::archive::Persist;
use std::ops::Range;

use super::body_forces::BodyForces;
use super::central_difference;
use super::energy::{Energy, EnergyBalance};
use super::increment::{Increment, IncrementContext, IncrementController, IncrementEnd};
use super::limits::{IncrementLimiter, IncrementLimits};
use super::mesh_quality::RemeshMonitor;
use super::outcome::{BodyRest, Outcome, StepSummary};
use super::position::RunPosition;
use super::routines::UserSession;
use super::timing::EffectTiming;
use super::watch::RunMonitor;
use crate::constraint::Constraint;
use crate::element::elements::CollapsedElement;
use crate::element::mass_scaling::StepMassScaling;
use crate::element::volume_guard::STARTING;
use crate::heat::field::TemperatureField;
use crate::kernel::lanes::InlineMap;
use crate::load::{LoadForces, SceneChange, SceneView, TargetDissipation};
use crate::model::{IncrementControl, LoadVelocity};
use crate::plan::{Plan, State, StepChanges, StepPlan};
use crate::state::halt::{HaltDetails, HaltReason};
use crate::state::magnitude::AmplitudeClock;
use crate::state::{BodyState, Instant};
use crate::user::RunAction;

/// Data that an increment uses or changes. It is aligned so that the run time does not depend on the stack address.
#[repr(align(64))]
#[derive(Persist)]
// The state of a step that has begun; the effects in force are those of the step.
#[persist(
    derived: plan, step, velocity_extrapolation, previous_stable_increment, finds_onsets, forces_may_differ, threads,
        kinetic, timing
)]
pub(super) struct SolverRun<'a> {
    pub(super) plan: &'a Plan,
    /// Plan of the current step.
    pub(super) step: &'a StepPlan,
    /// Degrees of freedom, elements, and the effects in force.
    pub(super) state: State,
    pub(super) now: Instant,
    /// Previous instant, to which a halt within an increment returns.
    pub(super) previous_instant: Instant,
    /// Length of the previous increment; 0 if central differences of bodies start with a half step.
    pub(super) previous_dt: f64,
    /// Length of the increment that led here, for the energy balance and for output.
    pub(super) last_increment: f64,
    /// Fraction of the previous increment over which the velocity that loads receive is extrapolated from
    /// mid-increment: a half, or zero.
    pub(super) velocity_extrapolation: f64,
    /// Stable time increment of the elements at the previous instant, if the deck fixes increments.
    pub(super) previous_stable_increment: f64,
    /// Whether forces, motion and energies belong to the current instant.
    pub(super) complete: bool,
    /// Whether increments in which a load begins suddenly are repeated in this step.
    pub(super) finds_onsets: bool,
    /// Whether a step has begun that may change the forces at this instant.
    pub(super) forces_may_differ: bool,
    /// Node and axis of prescribed motions that ended at this instant.
    pub(super) released: Vec<(usize, usize)>,
    pub(super) user: UserSession,
    pub(super) body_forces: BodyForces,
    /// Group and element that limited the smallest increment of the step.
    pub(super) limiting: Option<(usize, usize)>,
    pub(super) balance: EnergyBalance,
    /// Monitors that issue warnings.
    pub(super) watch: RunMonitor,
    /// New meshes of bodies.
    pub(super) remesh: RemeshMonitor,
    /// Whether other threads may be used.
    pub(super) threads: bool,
    /// Work array for the kinetic energies of chunks of nodes.
    pub(super) kinetic: Vec<f64>,
    pub(super) timing: EffectTiming<'a>,
    pub(super) outcome: Outcome,
}

impl<'a> SolverRun<'a> {
    pub(super) fn new(plan: &'a Plan, state: State, position: Option<&'a RunPosition>) -> Self {
        SolverRun {
            plan,
            step: &plan.steps[0],
            now: Instant::default(),
            previous_instant: Instant::default(),
            previous_dt: 0.0,
            last_increment: 0.0,
            velocity_extrapolation: 0.0,
            previous_stable_increment: f64::INFINITY,
            complete: false,
            finds_onsets: false,
            forces_may_differ: false,
            released: Vec::new(),
            user: UserSession::default(),
            body_forces: BodyForces::default(),
            limiting: None,
            balance: EnergyBalance::start(&state.dofs),
            watch: RunMonitor::default(),
            remesh: RemeshMonitor::new(plan),
            threads: rayon::current_num_threads() > 1,
            kinetic: central_difference::chunk_energies(&state.dofs.nodes),
            timing: EffectTiming::new(plan.ledger.effects.len(), position),
            outcome: Outcome::default(),
            state,
        }
    }

    /// Locks the user subroutines for the run.
    pub(super) fn with_routines(self) -> Self {
        SolverRun { user: UserSession::new(&self.plan.routines), ..self }
    }

    /// Evaluates the current instant.
    ///
    /// # Errors
    /// If a force fails or a value is not finite.
    #[inline]
    pub(super) fn evaluate(&mut self) -> Result<(), HaltReason> {
        self.timing.resume(self.now.increment);
        self.evaluate_forces()?; //             1. forces; resistances last
        if self.finds_onsets {
            self.resolve_onset()?;
        }
        self.accelerate()?; //                  2. a = F / m; a resistance keeps a body at rest
        self.correct_velocity(); //             3. velocity at the current instant
        self.update_balance(); //                         4. energy balance
        self.guard_energy()?;
        self.timing.pause();
        Ok(()) //                               5. output, in the time loop
    }

    /// Advances to the next instant. `next_output` is the step time at which output is due; it matters only while all
    /// bodies are at rest.
    ///
    /// # Errors
    /// If no further increment is possible, or a user subroutine fails.
    pub(super) fn advance(&mut self, control: &mut IncrementController, next_output: f64) -> Result<(), HaltReason> {
        self.timing.resume(self.now.increment);
        self.guard_increment()?;
        let next = control.choose(self.context(next_output)); // 6. length of the next increment
        self.remember_stable_increment();
        next.check(&self.now)?;
        self.call_routines(next)?;
        self.make_increment(next); //           7. v(i+1/2), u(i+1), and the velocity that loads receive
        self.record(next);
        self.timing.pause();
        Ok(())
    }

    #[inline]
    fn remember_stable_increment(&mut self) {
        if !self.state.elements.is_empty() && self.step.is_fixed() {
            self.previous_stable_increment = self.state.elements.stable_increment();
        }
    }

    #[inline(always)]
    fn context(&self, next_output: f64) -> IncrementContext<'_> {
        IncrementContext {
            state: &self.state,
            now: &self.now,
            velocity_extrapolation: self.velocity_extrapolation,
            previous_dt: self.previous_dt,
            remaining: self.step.duration - self.now.step_time,
            // With a margin for rounding, so that the instant is not before it.
            until_output: (next_output - self.now.step_time) * (1.0 + 1e-9),
        }
    }

    pub(super) fn name_limiting_element(&mut self) {
        let Some(summary) = self.outcome.steps.last_mut() else { return };
        summary.global_estimates = self.state.elements.estimates();
        if let Some((group, element)) = self.limiting.take() {
            summary.limiting_element = Some(self.plan.element_name(group, element).to_owned());
        }
    }

    fn is_last_step(&self) -> bool {
        self.now.step as usize == self.plan.steps.len()
    }

    /// Returns whether the step is at its end, or a user subroutine has requested the end.
    pub(super) fn is_over(&self) -> bool {
        self.now.step_time >= self.step.duration || self.user.requested_action != RunAction::Continue
    }

    /// Begins the step with this index and applies its changes of effects; all other effects continue. Returns whether
    /// anything changes.
    pub(super) fn begin(&mut self, index: usize) -> bool {
        let (step, previous) = (&self.plan.steps[index], self.step);
        let heat = self.state.thermal.as_mut().and_then(|t| t.heat.as_mut());
        let heat_changes = heat.is_some_and(|heat| heat.begin(index));
        let changes = index == 0 || heat_changes || !step.changes.is_empty();
        let releases = index > 0 && step.changes.constraints.is_some();
        let prescribed = if releases { self.prescribed_motions() } else { Vec::new() };
        self.put_in_force(&step.changes);
        self.find_released(prescribed);
        self.step = step;
        self.velocity_extrapolation = match step.load_velocity {
            LoadVelocity::Predicted => 0.5,
            LoadVelocity::Lagged => 0.0,
        };
        if changes {
            self.body_forces.begin(&mut self.state);
            self.begin_constraints();
            self.balance.begin(&self.body_forces.slots, &self.state.dofs.bodies);
            self.watch.begin_step();
        }
        if step.energy_limit != previous.energy_limit {
            self.watch.limits_reported = [false; 2];
        }
        self.forces_may_differ = changes;
        self.now.step_time = 0.0;
        self.now.lost = 0.0;
        self.now.step += 1;
        if self.now.increment == 0 {
            self.show_own_velocity();
        }
        let (name, smallest_increment) = (step.name.clone(), f64::INFINITY);
        let limits = IncrementLimits::begin();
        // Masses scaled in the previous step stay scaled.
        let scaled = self.outcome.steps.last().filter(|_| self.state.scaling.is_some());
        let added_mass_at = scaled.and_then(|previous| previous.added_mass_at);
        let added_mass = scaled.and_then(|previous| previous.added_mass);
        let summary = StepSummary { name, smallest_increment, limits, added_mass, added_mass_at, ..Default::default() };
        self.outcome.steps.push(summary);
        self.begin_onsets();
        self.begin_drift_bound();
        changes
    }

    fn put_in_force(&mut self, changes: &StepChanges) {
        if let Some(loads) = &changes.loads {
            let ended = loads.apply(&mut self.state.loads, |load, previous| load.continue_from(previous));
            self.warn_of_stiff_loads(&ended);
            self.record_ended_penetrations(&ended);
        }
        if let Some(constraints) = &changes.constraints {
            let take_over =
                |constraint: &mut dyn Constraint, previous: &dyn Constraint| constraint.continue_from(previous);
            let mut ended = constraints.apply(&mut self.state.constraints, take_over);
            self.warn_of_constraints(&mut ended);
        }
        if let Some(motions) = &changes.user_motions {
            motions.apply(&mut self.state.user_motions, |_, _| {});
        }
        match &changes.scaling {
            Some(scaling) => self.state.scaling.clone_from(scaling),
            None => self.state.scaling.iter_mut().for_each(StepMassScaling::begin_step),
        }
        if let Some(domains) = &changes.adaptive {
            self.change_domains(domains);
        }
    }

    /// Evaluates the forces at the start of a later step. If the forces on bodies have the same bits as before, bodies
    /// continue; otherwise their central differences start again, as after a jump of a force.
    ///
    /// # Errors
    /// If a force fails or a value is not finite.
    pub(super) fn evaluate_step_start(&mut self) -> Result<(), HaltReason> {
        if !std::mem::take(&mut self.forces_may_differ) || !self.complete {
            return Ok(());
        }
        // Without a previous increment its work is not added twice.
        let previous_dt = std::mem::take(&mut self.previous_dt);
        let bodies = self.state.dofs.bodies.clone();
        self.evaluate_accelerations()?;
        self.balance.take_forces(&self.body_forces.values);
        let go_on = bodies.iter().zip(&self.state.dofs.bodies).all(|(before, now)| now.has_same_forces(before));
        if go_on {
            (self.state.dofs.bodies, self.previous_dt) = (bodies, previous_dt);
        } else if self.body_forces.tied > 0 {
            self.previous_dt = previous_dt;
            self.correct_velocity();
        } else {
            self.show_own_velocity();
        }
        Ok(())
    }

    fn begin_constraints(&mut self) {
        self.state.elements.begin(self.state.constraints.iter().any(|c| c.view().moves_nodes));
        let pushed = self.state.elements.has_links() || self.state.loads.iter().any(|l| l.targets().nodes);
        self.state.dofs.nodes.resize_forces(pushed);
        self.state.constraints.iter_mut().for_each(|c| c.begin(&mut self.state.dofs));
        self.begin_domains();
    }

    /// Initialises user materials, and estimates the highest frequency from the elastic moduli and the prescribed
    /// motions.
    pub(super) fn begin_nodes(&mut self, changes: bool) -> Result<(), HaltReason> {
        if self.state.elements.is_empty() || !changes {
            return Ok(());
        }
        if self.now.increment == 0 {
            self.state.elements.probe(&self.state.dofs.nodes, &self.now, self.user.routines.at_points())?;
            let energies = self.state.elements.available_energies(&self.state.dofs.nodes);
            self.balance.supply().begin(energies, self.plan.stiffening, self.plan.returns_heat);
        }
        let global = matches!(self.step.control, IncrementControl::Automatic { element_by_element: false, .. });
        let views = || self.state.constraints.iter().map(|c| c.view());
        let prescribed: Vec<_> = views().filter_map(|v| v.forces).flat_map(|forces| forces.prescribed()).collect();
        let carried: Vec<_> = views().filter_map(|v| v.carried).flat_map(|c| c.nodes.to_vec()).collect();
        let held = crate::element::frequency::ConstrainedNodes { prescribed: &prescribed, carried: &carried };
        self.state.elements.begin_frequency(global, &self.state.dofs.nodes, &held);
        Ok(())
    }

    /// Evaluates forces and accelerations outside the increments: at the start of a step, or on a new mesh.
    ///
    /// # Errors
    /// If a force fails or a value is not finite.
    #[inline(never)]
    pub(super) fn evaluate_accelerations(&mut self) -> Result<(), HaltReason> {
        self.evaluate_forces()?;
        self.accelerate()
    }

    #[inline(always)]
    fn evaluate_forces(&mut self) -> Result<(), HaltReason> {
        if !self.state.elements.is_empty() {
            self.evaluate_nodes()?;
        }
        let is_at_rest = |body: &BodyState| body.direction == 0.0;
        if self.state.dofs.bodies.iter().any(is_at_rest) {
            self.evaluate_resting_bodies()
        } else {
            self.apply_body_loads(0..self.state.loads.len())
        }
    }

    /// Evaluates the forces on bodies of which one is at rest: resistances act against the motion that the other forces
    /// would start.
    #[inline(never)]
    fn evaluate_resting_bodies(&mut self) -> Result<(), HaltReason> {
        let (first_resistance, loads) = (self.body_forces.first_resistance, self.state.loads.len());
        self.apply_body_loads(0..first_resistance)?;
        if first_resistance < loads {
            self.body_forces.turn_resting_bodies(&mut self.state.dofs.bodies);
            self.apply_body_loads(first_resistance..loads)?;
        }
        Ok(())
    }

    /// Evaluates the forces on bodies of a range of loads.
    #[inline(always)]
    pub(super) fn apply_body_loads(&mut self, range: Range<usize>) -> Result<(), HaltReason> {
        let State { dofs, loads, user_amplitudes, .. } = &mut self.state;
        let clock = AmplitudeClock { now: self.now, user_amplitudes };
        let velocity_extrapolation = self.velocity_extrapolation;
        let view = SceneView { clock, dofs, velocity_extrapolation, rings: None, element_force: None };
        let mut start = self.body_forces.start_of(range.start);
        for (load, &(row, end)) in loads[range.clone()].iter_mut().zip(&self.body_forces.loads[range]) {
            let started = self.timing.start(row);
            let forces = &mut self.body_forces.values[start..end];
            load.apply(&view, &mut self.user.routines, &mut LoadForces::OnBodies(forces))?;
            self.timing.stop(started, row);
            start = end;
        }
        Ok(())
    }

    /// Evaluates element stresses, forces of loads and links on nodes, and the forces of tied nodes on bodies.
    #[inline(never)]
    fn evaluate_nodes(&mut self) -> Result<(), HaltReason> {
        self.scale_masses();
        let fresh = self.state.elements.is_pending();
        if fresh {
            self.apply_temperatures();
            self.give_fields();
        }
        let user = self.user.routines.at_points();
        self.state.elements.update(&mut self.state.dofs, &self.now, self.threads, user, self.timing.groups());
        if self.state.thermal.is_some() {
            self.conduct(fresh);
        }
        self.state.dofs.nodes.begin_forces();
        self.release_faces();
        self.apply_nodal_loads()?;
        self.state.elements.add_link_forces(&mut self.state.dofs);
        self.state.elements.check(&self.state.dofs.nodes).map_err(|collapsed| self.collapsed(collapsed))?;
        self.transfer_to_bodies();
        Ok(())
    }

    /// Returns the nodal temperatures, if they are solved for.
    pub(super) fn heat(&self) -> Option<&TemperatureField> {
        self.state.thermal.as_ref()?.heat.as_ref()
    }

    /// Sets element temperatures and removes thermal strains.
    #[inline(never)]
    fn apply_temperatures(&mut self) {
        let Some(thermal) = &mut self.state.thermal else { return };
        let clock = thermal.heat.as_ref().map(|heat| (self.timing.start(heat.id), heat.id));
        thermal.prepare_elements(
            &mut self.state.elements,
            &mut self.state.dofs,
            &AmplitudeClock { now: self.now, user_amplitudes: &self.state.user_amplitudes },
        );
        if let Some((clock, id)) = clock {
            self.timing.stop(clock, id);
        }
    }

    /// Sets prescribed field variables of elements.
    #[inline(never)]
    fn give_fields(&mut self) {
        let Some(id) = self.state.elements.fields.as_ref().map(|f| f.id) else { return };
        let clock = self.timing.start(id);
        self.state
            .elements
            .give_fields(&AmplitudeClock { now: self.now, user_amplitudes: &self.state.user_amplitudes });
        self.timing.stop(clock, id);
    }

    /// Adds the heat of plastic work and evaluates heat conduction.
    #[inline(never)]
    fn conduct(&mut self, fresh: bool) {
        let Some(heat) = self.state.thermal.as_mut().and_then(|t| t.heat.as_mut()) else { return };
        let started = self.timing.start(heat.id);
        if fresh {
            heat.collect_plastic_heat(&mut self.state.elements);
        }
        let clock = AmplitudeClock { now: self.now, user_amplitudes: &self.state.user_amplitudes };
        heat.evaluate(&self.state.elements, &self.state.dofs, &self.state.constraints, &clock, self.threads);
        self.timing.stop(started, heat.id);
    }

    pub(super) fn energy(&self) -> Energy {
        let heat = self.heat().map(TemperatureField::energies);
        let removed = self.state.elements.removed.as_ref().map(|r| r.totals(&self.state.dofs.nodes));
        let (external, internal) = (heat.map(|h| h.external), heat.map(|h| h.internal));
        let added_mass = self.state.scaling.as_ref().and_then(|_| self.added_mass_percent());
        Energy { heat: external, internal_heat: internal, removed, added_mass, ..self.balance.energy() }
    }

    /// Returns group and element that limit the increment.
    #[inline(never)]
    pub(super) fn limits(&self) -> (usize, usize) {
        let slower = |h: &&TemperatureField| h.stable_increment() < self.state.elements.stable_increment();
        self.heat().filter(slower).map_or_else(|| self.state.elements.limiting(), TemperatureField::limiting)
    }

    /// Sums the forces of tied nodes on their rigid bodies.
    fn transfer_to_bodies(&mut self) {
        let (elements, nodes) = (&self.state.elements, &self.state.dofs.nodes);
        let force = |n: usize| {
            let ([r, z], more) = (elements.nodal_force(n), nodes.forces[0].get(n).copied().unwrap_or_default());
            [r + more[0], z + more[1]]
        };
        let carried = self.state.constraints.iter().filter_map(|c| c.view().carried);
        for (carried, out) in carried.zip(&mut self.body_forces.values) {
            *out = carried.force(force);
        }
    }

    fn release_faces(&mut self) {
        let deleted = self.state.elements.newly_deleted();
        if !deleted.is_empty() {
            self.state.loads.iter_mut().for_each(|load| load.scene_changed(&SceneChange::DeletedElements(deleted)));
            self.state.constraints.iter_mut().filter_map(|c| c.upkeep()).for_each(|c| c.remove_elements(deleted));
            if let Some(heat) = self.state.thermal.as_mut().and_then(|t| t.heat.as_mut()) {
                heat.release(deleted);
            }
        }
    }

    fn apply_nodal_loads(&mut self) -> Result<(), HaltReason> {
        // Taken out of the state, because loads read the state.
        let mut forces = std::mem::take(&mut self.state.dofs.nodes.forces[0]);
        let mut dissipated = TargetDissipation::default();
        let (elements, rings) = (&self.state.elements, self.state.elements.ring_factors());
        let element_force = |n: usize| elements.nodal_force(n).inline_map(|f| rings.map_or(f, |rings| rings[n] * f));
        let view = SceneView {
            clock: AmplitudeClock { now: self.now, user_amplitudes: &self.state.user_amplitudes },
            dofs: &self.state.dofs,
            velocity_extrapolation: self.velocity_extrapolation,
            rings,
            element_force: Some(&element_force),
        };
        let mut result = Ok(());
        for load in &mut self.state.loads {
            let clock = self.timing.start(load.effect());
            match load.apply(&view, &mut self.user.routines, &mut LoadForces::OnNodes(&mut forces)) {
                Ok(work) => dissipated.add(work),
                Err(halt) => {
                    result = Err(halt);
                    break;
                }
            }
            self.timing.stop(clock, load.effect());
        }
        self.state.dofs.nodes.forces[0] = forces;
        let TargetDissipation { cavity, friction } = dissipated;
        self.state.dofs.energies.cavity += cavity;
        self.state.dofs.energies.friction += friction;
        self.state.dofs.energies.external += cavity + friction;
        result
    }

    #[cold]
    fn collapsed(&self, CollapsedElement { group, element, volume }: CollapsedElement) -> HaltReason {
        if let Some(halt) = &self.state.elements.failure {
            return halt.clone();
        }
        let why = if volume > 0.0 { "its state is not finite" } else { "it is inverted" };
        let name = self.plan.element_name(group, element);
        let reason = format!(
            "element {name} failed at increment {}, time {:e}: {why} (volume {volume:e})",
            self.now.increment, self.now.total_time
        );
        let remedy = match self.too_long() {
            text if text.is_empty() && (volume <= 0.0 || self.watch.collapse.reported > 0.0) => {
                self.name_folding_remedy(group)
            }
            text => text,
        };
        HaltReason::ElementFailed(HaltDetails::new(reason + &remedy)).at_element(name)
    }

    /// Adds instant and place to a halt that does not have them. The place of an element is its current centre.
    #[cold]
    pub(super) fn located(&self, mut halt: HaltReason, instant: Instant) -> HaltReason {
        let details = halt.details_mut();
        details.instant.get_or_insert(instant);
        if details.place.is_none()
            && let Some(name) = &details.element
            && let Some((_, (group, element))) =
                self.plan.places.elements.iter().find(|(e, _)| &*self.plan.mesh.elements[*e].name == name.as_str())
        {
            let corners = self.state.elements.groups[*group].boundary(*element);
            let places: Vec<[f64; 2]> = corners.iter().map(|n| self.state.dofs.nodes[*n as usize].place()).collect();
            details.place = Some([0, 1].map(|axis| places.iter().map(|p| p[axis]).sum::<f64>() / places.len() as f64));
        }
        halt
    }

    /// Compares a fixed increment with the stable time increment of the elements that remain.
    #[cold]
    fn too_long(&self) -> String {
        let IncrementControl::Fixed(given) = self.step.control else { return String::new() };
        let ratio = given / self.previous_stable_increment;
        if ratio <= 1.0 {
            return String::new();
        }
        format!(
            "; the increment of DIRECT USER CONTROL, {given:e}, is {ratio:.2} times the stable time increment at the previous \
             instant, {:.3e}: use a smaller one or automatic increments",
            self.previous_stable_increment
        )
    }

    #[inline(always)]
    fn accelerate(&mut self) -> Result<(), HaltReason> {
        let mut start = 0;
        for b in 0..self.state.dofs.bodies.len() {
            let body = &mut self.state.dofs.bodies[b];
            let own = &self.body_forces.order_by_body[start..start + body.slots as usize];
            start += own.len();
            let forces = own.iter().map(|&(coordinate, i)| (coordinate, self.body_forces.values[i]));
            if body.accelerate(forces) {
                self.body_forces.arrest(b);
            }
        }
        let deforms = !self.state.elements.is_empty();
        if deforms {
            let clock = self.timing.start_gather(self.plan);
            central_difference::accelerate_nodes(&self.state.elements, &mut self.state.dofs, &mut self.kinetic);
            self.timing.stop_gather(clock, self.plan);
        }
        for constraint in &mut self.state.constraints {
            let clock = AmplitudeClock { now: self.now, user_amplitudes: &self.state.user_amplitudes };
            constraint.accelerations(&mut self.state.dofs, &clock);
        }
        self.state.dofs.nodes.work_pending = false;
        // A fixed increment ignores the stable time increment.
        if deforms && self.now.increment < STARTING && !self.step.is_fixed() {
            self.state.elements.guard_start(&self.state.dofs.nodes);
        }
        if self.state.dofs.bodies.iter().all(|b| b.acceleration.abs() < f64::INFINITY) {
            Ok(())
        } else {
            Err(self.not_finite())
        }
    }

    fn update_balance(&mut self) {
        self.balance.add_increment(
            &self.state.dofs,
            &self.body_forces.values,
            self.previous_dt == 0.0,
            (!self.state.elements.is_empty()).then_some(self.now.total_time),
        );
        self.complete = true;
    }

    #[cold]
    fn not_finite(&self) -> HaltReason {
        let b = self.state.dofs.bodies.iter().position(|b| !b.acceleration.is_finite()).unwrap_or_default();
        let (name, time, body) = (&self.plan.bodies[b].name, self.now.total_time, &self.state.dofs.bodies[b]);
        let reason = format!(
            "the acceleration of rigid body `{name}` is {} at increment {}, time {time:e} ({}, mass {})",
            body.acceleration,
            self.now.increment,
            body.describe_force(),
            body.mass
        );
        HaltReason::NotFinite(HaltDetails::new(reason))
    }

    #[inline(always)]
    fn correct_velocity(&mut self) {
        if self.previous_dt == 0.0 {
            return;
        }
        self.state.dofs.bodies.iter_mut().for_each(|body| body.complete_velocity(self.previous_dt));
        self.prescribe_velocities();
    }

    #[inline]
    fn prescribe_velocities(&mut self) {
        for constraint in &mut self.state.constraints {
            let clock = AmplitudeClock { now: self.now, user_amplitudes: &self.state.user_amplitudes };
            constraint.velocities(&mut self.state.dofs, &clock);
        }
    }

    #[inline(always)]
    pub(super) fn make_increment(&mut self, next: Increment) {
        let dt = next.length;
        self.state.dofs.bodies.iter_mut().for_each(|body| body.advance(dt));
        if !self.state.elements.is_empty() {
            self.advance_nodes(dt);
        }
        for constraint in &mut self.state.constraints {
            let clock = AmplitudeClock { now: self.now, user_amplitudes: &self.state.user_amplitudes };
            let started = self.timing.start(constraint.effect());
            constraint.motion(&mut self.state.dofs, &clock, dt);
            self.timing.stop(started, constraint.effect());
        }
        if self.state.thermal.is_some() {
            self.advance_temperatures(dt);
        }
        for body in &mut self.state.dofs.bodies {
            body.show_velocity_after(self.velocity_extrapolation * dt);
        }
        self.complete = false;
        self.previous_instant = self.now;
        self.now = next.arrival(&self.now, self.step.duration);
        self.last_increment = dt;
        self.previous_dt = dt;
        // Central differences continue into the next step unless its forces on bodies differ.
        let goes_on = next.end == IncrementEnd::Step && (self.body_forces.tied > 0 || !self.is_last_step());
        if next.end != IncrementEnd::Plain && !goes_on {
            self.restart_integration(next.end);
        }
    }

    #[inline(never)]
    fn advance_nodes(&mut self, dt: f64) {
        self.adapt_meshes(dt);
        if !self.released.is_empty() {
            self.release(dt);
        }
        central_difference::advance_nodes(&self.state.elements, &mut self.state.dofs, dt);
        self.state.elements.mark_moved();
    }

    #[inline(never)]
    fn advance_temperatures(&mut self, dt: f64) {
        let Some(heat) = self.state.thermal.as_mut().and_then(|t| t.heat.as_mut()) else { return };
        heat.add_exchanged_heat(&self.state.constraints, dt);
        heat.advance(&AmplitudeClock { now: self.now, user_amplitudes: &self.state.user_amplitudes }, dt);
    }

    /// Starts central differences of bodies again with a half step after rest or a jump of a force, from the velocity
    /// at the current instant.
    #[inline(never)]
    fn restart_integration(&mut self, end: IncrementEnd) {
        self.state.dofs.bodies.iter_mut().for_each(|body| body.complete_velocity(self.previous_dt));
        self.prescribe_velocities();
        if let IncrementEnd::Rest(b) = end {
            self.state.dofs.bodies[b].arrest();
            let (body, displacement) = (self.plan.bodies[b].name.clone(), self.state.dofs.bodies[b].displacement);
            self.outcome.rests.push(BodyRest { body, time: self.now.total_time, displacement });
        }
        self.previous_dt = 0.0;
        self.show_own_velocity();
    }

    /// Passes the current velocity to loads when central differences start.
    pub(super) fn show_own_velocity(&mut self) {
        self.state.dofs.bodies.iter_mut().for_each(BodyState::show_own_velocity);
    }

    /// Returns to the last complete instant after a failure.
    pub(super) fn step_back(&mut self) {
        if self.now.increment == 0 || self.complete {
            return;
        }
        self.state.dofs.bodies.iter_mut().for_each(BodyState::step_back);
        self.now = self.previous_instant;
    }

    fn record(&mut self, Increment { length, by, .. }: Increment) {
        self.outcome.increments = self.now.increment;
        let limiting = (!self.state.elements.is_empty()).then(|| self.limits());
        if let Some(position) = self.timing.position {
            position.begin(&self.now, limiting);
        }
        if let (IncrementLimiter::Elements, Some(place)) = (by, limiting) {
            self.watch.collapse.count(length, self.previous_instant.total_time, place);
        }
        if let Some(summary) = self.outcome.steps.last_mut() {
            summary.increments += 1;
            summary.time = self.now.step_time;
            summary.limits.take(self.previous_instant.total_time, length, by, limiting.unwrap_or_default());
            if length < summary.smallest_increment {
                summary.smallest_increment = length;
                self.limiting = limiting;
            }
            if length > summary.largest_increment {
                summary.largest_increment = length;
            }
        }
    }
}
