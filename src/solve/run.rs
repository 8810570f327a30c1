//! A run: everything an increment touches, and the increment as a numbered recipe.
//! Never here: the loop over increments, output, states that are kept.

use super::body_forces::BodyForces;
use super::central_difference;
use super::energy::{Balance, Energy};
use super::increment::{End, Increment, IncrementController, Scene};
use super::limits::Limits;
use super::outcome::{Outcome, Rest, StepSummary};
use super::routines::UserSession;
use super::timing::Timing;
use super::watch::Watch;
use crate::constraint::Constraint;
use crate::element::elements::Collapsed;
use crate::element::mass_scaling::Scaling;
use crate::element::volume_guard::STARTING;
use crate::heat::field::Heat;
use crate::load::{Dissipation, Forces, SceneChange, SceneView};
use crate::model::{IncrementControl, LoadVelocity};
use crate::plan::{Changes, Plan, State, StepPlan};
use crate::state::halt::Halt;
use crate::state::magnitude::Clock;
use crate::state::{BodyState, Instant};
use crate::user::RunAction;

/// Everything an increment uses or changes. Aligned, so that its run time does not depend on where the stack begins.
#[repr(align(64))]
pub(super) struct Run<'a> {
    pub(super) plan: &'a Plan,
    /// The current step.
    pub(super) step: &'a StepPlan,
    /// Degrees of freedom, elements, and the effects in force.
    pub(super) state: State,
    pub(super) now: Instant,
    /// The instant before, which a halt inside an increment returns to.
    pub(super) previous_instant: Instant,
    /// Length of the previous increment; 0 where central differences of bodies start afresh with the half step.
    pub(super) previous_dt: f64,
    /// Length of the increment that led here, for the energy balance and for output.
    pub(super) last_increment: f64,
    /// Part of the previous increment over which the velocity that loads see is extrapolated from its middle: half of it, or none.
    pub(super) velocity_extrapolation: f64,
    /// Stable time increment of the elements at the previous instant, where the deck gives increments.
    pub(super) previous_stable_increment: f64,
    /// Whether the instant is complete: forces, motion and energies belong to it.
    pub(super) complete: bool,
    /// Whether a step has begun in which the forces of this instant may differ.
    pub(super) forces_may_differ: bool,
    pub(super) user: UserSession<'a>,
    pub(super) body_forces: BodyForces,
    /// Group and element that limited the smallest increment of the step.
    pub(super) limiting: Option<(usize, usize)>,
    pub(super) balance: Balance,
    /// What is monitored over the run.
    pub(super) watch: Watch,
    /// Whether other threads may take part.
    pub(super) threads: bool,
    /// Work array for the kinetic energies of chunks of nodes.
    pub(super) kinetic: Vec<f64>,
    pub(super) timing: Timing,
    pub(super) outcome: Outcome,
}

impl<'a> Run<'a> {
    pub(super) fn new(plan: &'a Plan, state: State) -> Self {
        Run {
            plan,
            step: &plan.steps[0],
            now: Instant::default(),
            previous_instant: Instant::default(),
            previous_dt: 0.0,
            last_increment: 0.0,
            velocity_extrapolation: 0.0,
            previous_stable_increment: f64::INFINITY,
            complete: false,
            forces_may_differ: false,
            user: UserSession::new(&plan.routines),
            body_forces: BodyForces::default(),
            limiting: None,
            balance: Balance::start(&state.dofs),
            watch: Watch::default(),
            threads: rayon::current_num_threads() > 1,
            kinetic: central_difference::room_for_parts(&state.dofs.nodes),
            timing: Timing::new(plan.ledger.effects.len()),
            outcome: Outcome::default(),
            state,
        }
    }

    /// What an instant is made of.
    ///
    /// # Errors
    /// Where a force fails or a number is not finite.
    #[inline]
    pub(super) fn evaluate(&mut self) -> Result<(), Halt> {
        self.timing.resume(self.now.increment);
        self.evaluate_forces()?; //             1. forces, resistances last
        self.accelerate()?; //                  2. a = F / m; a resistance holds what is at rest
        self.correct_velocity(); //             3. velocity at the increment's own time
        self.book(); //                         4. energy balance
        self.guard_energy()?;
        self.timing.pause();
        Ok(()) //                               5. output that is due: the loop shows it
    }

    /// From one instant to the next.
    ///
    /// # Errors
    /// Where no increment goes on, or a routine of the user fails.
    pub(super) fn advance(&mut self, control: &mut IncrementController) -> Result<(), Halt> {
        self.timing.resume(self.now.increment);
        self.guard_increment()?;
        let next = self.choose(control); //     6. length of the next increment
        self.remember_bearable();
        next.check(&self.now, self.now.increment)?;
        self.call_routines(next)?;
        self.make_increment(next); //           7. v(i+1/2), u(i+1), and the velocity that loads will see
        self.record(next);
        self.timing.pause();
        Ok(())
    }

    #[inline]
    fn remember_bearable(&mut self) {
        if let IncrementControl::Fixed(_) = self.step.control {
            self.previous_stable_increment = self.state.elements.stable_increment();
        }
    }

    #[inline]
    fn choose(&self, control: &mut IncrementController) -> Increment {
        let clock = Clock { now: self.now, user_amplitudes: &self.state.user_amplitudes };
        control.choose(&Scene {
            view: SceneView {
                clock,
                dofs: &self.state.dofs,
                velocity_extrapolation: self.velocity_extrapolation,
                rings: self.state.elements.ring_factors(),
            },
            elements: &self.state.elements,
            heat: self.heat(),
            loads: &self.state.loads,
            constraints: &self.state.constraints,
            previous_dt: self.previous_dt,
            remaining: self.step.duration - self.now.step_time,
        })
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

    /// Whether the step is at its end, or a user's routine wants it to be.
    pub(super) fn is_over(&self) -> bool {
        self.now.step_time >= self.step.duration || self.user.requested_action != RunAction::Continue
    }

    /// Begins a step, counted from 0: puts in force what it changes. All else goes on. Returns whether anything changes.
    pub(super) fn begin(&mut self, index: usize) -> bool {
        let (step, previous) = (&self.plan.steps[index], self.step);
        let heat = self.state.thermal.as_mut().and_then(|t| t.heat.as_mut());
        let heat_changes = heat.is_some_and(|heat| heat.begin(index));
        let changes = index == 0 || heat_changes || !step.changes.is_empty();
        self.put_in_force(&step.changes);
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
        let limits = Limits::begin();
        // Masses that the previous step scaled stay scaled.
        let added_mass = self.outcome.steps.last().and_then(|previous| previous.added_mass);
        let added_mass = added_mass.filter(|_| self.state.scaling.is_some());
        self.outcome.steps.push(StepSummary { name, smallest_increment, limits, added_mass, ..Default::default() });
        changes
    }

    fn put_in_force(&mut self, changes: &Changes) {
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
            None => self.state.scaling.iter_mut().for_each(Scaling::begin_step),
        }
    }

    /// At the start of a later step: the forces of what is in force now. Where those on bodies are the same to the last bit, bodies
    /// go on as they were; else their central differences start afresh, as where a force jumps.
    ///
    /// # Errors
    /// Where a force fails or a number is not finite.
    pub(super) fn evaluate_step_start(&mut self) -> Result<(), Halt> {
        if !std::mem::take(&mut self.forces_may_differ) || !self.complete {
            return Ok(());
        }
        // Without a previous increment no work is counted twice.
        let previous_dt = std::mem::take(&mut self.previous_dt);
        let bodies = self.state.dofs.bodies.clone();
        self.evaluate_forces()?;
        self.accelerate()?;
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
        self.state.dofs.nodes.make_room(pushed);
        self.state.constraints.iter_mut().for_each(|c| c.begin(&mut self.state.dofs));
    }

    /// What the user's routine tells of its material, and what follows from the moduli and from what is prescribed: the first
    /// estimate of the highest frequency.
    pub(super) fn begin_nodes(&mut self, changes: bool) -> Result<(), Halt> {
        if self.state.elements.is_empty() || !changes {
            return Ok(());
        }
        if self.now.step == 1 {
            self.state.elements.probe(&self.state.dofs.nodes, &self.now, self.user.routines.at_points())?;
        }
        let global = matches!(self.step.control, IncrementControl::Automatic { element_by_element: false, .. });
        let views = || self.state.constraints.iter().map(|c| c.view());
        let prescribed: Vec<_> = views().filter_map(|v| v.forces).flat_map(|forces| forces.prescribed()).collect();
        let carried: Vec<_> = views().filter_map(|v| v.carried).flat_map(|c| c.nodes.to_vec()).collect();
        let held = crate::element::frequency::Held { prescribed: &prescribed, carried: &carried };
        self.state.elements.begin_frequency(global, &self.state.dofs.nodes, &held);
        Ok(())
    }

    fn evaluate_forces(&mut self) -> Result<(), Halt> {
        if !self.state.elements.is_empty() {
            self.evaluate_nodes()?;
        }
        let (first_resistance, loads) = (self.body_forces.first_resistance, self.state.loads.len());
        self.push_bodies(0, first_resistance)?;
        if first_resistance < loads {
            self.body_forces.turn_resting_bodies(&mut self.state.dofs.bodies);
            self.push_bodies(first_resistance, loads)?;
        }
        Ok(())
    }

    /// Forces of some of the loads on bodies.
    #[inline]
    fn push_bodies(&mut self, first: usize, end: usize) -> Result<(), Halt> {
        let State { dofs, loads, user_amplitudes, .. } = &mut self.state;
        let clock = Clock { now: self.now, user_amplitudes };
        let view = SceneView { clock, dofs, velocity_extrapolation: self.velocity_extrapolation, rings: None };
        let mut start = self.body_forces.start_of(first);
        for (load, &end) in loads[first..end].iter_mut().zip(&self.body_forces.load_ends[first..end]) {
            let started = self.timing.start();
            let forces = &mut self.body_forces.values[start..end];
            load.apply(&view, &mut self.user.routines, &mut Forces::OnBodies(forces))?;
            self.timing.stop(started, load.effect());
            start = end;
        }
        Ok(())
    }

    /// Stresses of elements, forces of loads and links on nodes, and what of them goes to bodies.
    fn evaluate_nodes(&mut self) -> Result<(), Halt> {
        self.scale_masses();
        let fresh = self.state.elements.is_pending();
        if fresh {
            self.warm();
            self.give_fields();
        }
        let user = self.user.routines.at_points();
        self.state.elements.update(&mut self.state.dofs, &self.now, self.threads, user, self.timing.groups());
        if self.state.thermal.is_some() {
            self.conduct(fresh);
        }
        self.state.dofs.nodes.begin_forces();
        self.release_faces();
        self.push_nodes()?;
        self.state.elements.link(&mut self.state.dofs);
        self.state.elements.check(&self.state.dofs.nodes).map_err(|collapsed| self.collapsed(collapsed))?;
        self.transfer_to_bodies();
        Ok(())
    }

    /// Temperatures of nodes, where they are solved for.
    pub(super) fn heat(&self) -> Option<&Heat> {
        self.state.thermal.as_ref()?.heat.as_ref()
    }

    /// Gives elements their temperatures and takes their thermal strains off.
    #[inline(never)]
    fn warm(&mut self) {
        let Some(thermal) = &mut self.state.thermal else { return };
        let clock = self.timing.start();
        thermal.before(
            &mut self.state.elements,
            &mut self.state.dofs,
            &Clock { now: self.now, user_amplitudes: &self.state.user_amplitudes },
        );
        if let Some(heat) = &thermal.heat {
            self.timing.stop(clock, heat.id);
        }
    }

    /// Gives elements the field variables that are prescribed.
    #[inline(never)]
    fn give_fields(&mut self) {
        let Some(id) = self.state.elements.fields.as_ref().map(|f| f.id) else { return };
        let clock = self.timing.start();
        self.state.elements.give_fields(&Clock { now: self.now, user_amplitudes: &self.state.user_amplitudes });
        self.timing.stop(clock, id);
    }

    /// What plastic work made, and the flow of heat at this instant.
    #[inline(never)]
    fn conduct(&mut self, fresh: bool) {
        let Some(heat) = self.state.thermal.as_mut().and_then(|t| t.heat.as_mut()) else { return };
        let started = self.timing.start();
        if fresh {
            heat.take(&mut self.state.elements);
        }
        let clock = Clock { now: self.now, user_amplitudes: &self.state.user_amplitudes };
        heat.evaluate(&self.state.elements, &self.state.dofs, &self.state.constraints, &clock, self.threads);
        self.timing.stop(started, heat.id);
    }

    pub(super) fn energy(&self) -> Energy {
        let heat = self.heat().map(Heat::energies);
        let removed = self.state.elements.removed.as_ref().map(|r| r.books(&self.state.dofs.nodes));
        let (external, internal) = (heat.map(|h| h.external), heat.map(|h| h.internal));
        Energy { heat: external, internal_heat: internal, removed, ..self.balance.energy() }
    }

    /// Group and element that limit the increment.
    pub(super) fn limits(&self) -> (usize, usize) {
        let slower = |h: &&Heat| h.stable_increment() < self.state.elements.stable_increment();
        self.heat().filter(slower).map_or_else(|| self.state.elements.limiting(), Heat::limiting)
    }

    /// Forces of nodes on the rigid bodies that carry them.
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

    fn scale_masses(&mut self) {
        let Some(scaling) = &mut self.state.scaling else { return };
        let constraints = &mut self.state.constraints;
        let changed = &mut |n, gained| {
            constraints.iter_mut().filter_map(|c| c.upkeep()).for_each(|c| c.masses_changed(n, gained));
        };
        if !self.state.elements.scale_masses(scaling, &self.now, &mut self.state.dofs, changed) {
            return;
        }
        let masses = SceneChange::Masses(&self.state.dofs.nodes.mass);
        self.state.loads.iter_mut().for_each(|load| load.scene_changed(&masses));
        if let Some(summary) = self.outcome.steps.last_mut() {
            summary.added_mass = self.state.elements.added_mass(&self.state.dofs.nodes);
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

    fn push_nodes(&mut self) -> Result<(), Halt> {
        // Out of the way of what loads look at.
        let mut forces = std::mem::take(&mut self.state.dofs.nodes.forces[0]);
        let mut dissipated = Dissipation::default();
        let view = SceneView {
            clock: Clock { now: self.now, user_amplitudes: &self.state.user_amplitudes },
            dofs: &self.state.dofs,
            velocity_extrapolation: self.velocity_extrapolation,
            rings: self.state.elements.ring_factors(),
        };
        let mut result = Ok(());
        for load in &mut self.state.loads {
            let clock = self.timing.start();
            match load.apply(&view, &mut self.user.routines, &mut Forces::OnNodes(&mut forces)) {
                Ok(work) => dissipated.add(work),
                Err(halt) => {
                    result = Err(halt);
                    break;
                }
            }
            self.timing.stop(clock, load.effect());
        }
        self.state.dofs.nodes.forces[0] = forces;
        let Dissipation { cavity, friction } = dissipated;
        self.state.dofs.energies.cavity += cavity;
        self.state.dofs.energies.friction += friction;
        self.state.dofs.energies.external += cavity + friction;
        result
    }

    #[cold]
    fn collapsed(&self, Collapsed { group, element, volume }: Collapsed) -> Halt {
        if let Some(halt) = &self.state.elements.failure {
            return halt.clone();
        }
        let why = if volume > 0.0 { "its state is not finite" } else { "it has turned inside out" };
        let reason = format!(
            "element {} failed at increment {}, time {:e}: {why} (volume {volume:e})",
            self.plan.element_name(group, element),
            self.now.increment,
            self.now.total_time
        );
        Halt { code: "R206", reason: reason + &self.too_long() }
    }

    /// Where the deck gives increments: by how much they exceed what the elements that are left bear.
    #[cold]
    fn too_long(&self) -> String {
        let IncrementControl::Fixed(given) = self.step.control else { return String::new() };
        let ratio = given / self.previous_stable_increment;
        if ratio <= 1.0 {
            return String::new();
        }
        format!(
            "; the increment that DIRECT USER CONTROL gives, {given:e}, is {ratio:.2} times the stable one at the instant before, \
             {:.3e}: give a smaller one, or leave it to the program",
            self.previous_stable_increment
        )
    }

    fn accelerate(&mut self) -> Result<(), Halt> {
        let mut start = 0;
        for b in 0..self.state.dofs.bodies.len() {
            let body = &mut self.state.dofs.bodies[b];
            let own = &self.body_forces.order_by_body[start..start + body.slots as usize];
            start += own.len();
            let forces = own.iter().map(|&i| (self.body_forces.slots[i].coordinate, self.body_forces.values[i]));
            if body.accelerate(forces) {
                self.body_forces.arrest(b);
            }
        }
        if !self.state.elements.is_empty() {
            let clock = self.timing.start();
            central_difference::accelerate_nodes(
                &self.state.elements,
                &mut self.state.dofs,
                &mut self.kinetic,
                self.threads,
            );
            self.timing.stop_gather(clock, self.plan);
        }
        let clock = Clock { now: self.now, user_amplitudes: &self.state.user_amplitudes };
        for constraint in &mut self.state.constraints {
            constraint.accelerations(&mut self.state.dofs, &clock);
        }
        self.state.dofs.nodes.moved = false;
        // An increment that the deck fixes follows nothing.
        let automatic = matches!(self.step.control, IncrementControl::Automatic { .. });
        if !self.state.elements.is_empty() && self.now.increment < STARTING && automatic {
            self.state.elements.guard_start(&self.state.dofs.nodes);
        }
        if self.state.dofs.bodies.iter().all(|b| b.acceleration.abs() < f64::INFINITY) {
            Ok(())
        } else {
            Err(self.not_finite())
        }
    }

    fn book(&mut self) {
        self.balance.book(
            &self.state.dofs,
            &self.body_forces.values,
            self.previous_dt == 0.0,
            !self.state.elements.is_empty(),
        );
        self.complete = true;
    }

    fn not_finite(&self) -> Halt {
        let b = self.state.dofs.bodies.iter().position(|b| !b.acceleration.is_finite()).unwrap_or_default();
        let (name, time, body) = (&self.plan.bodies[b].name, self.now.total_time, &self.state.dofs.bodies[b]);
        let reason = format!(
            "the acceleration of rigid body `{name}` is {} at increment {}, time {time:e} ({}, mass {})",
            body.acceleration,
            self.now.increment,
            body.describe_force(),
            body.mass
        );
        Halt { code: "R203", reason }
    }

    fn correct_velocity(&mut self) {
        if self.previous_dt == 0.0 {
            return;
        }
        self.state.dofs.bodies.iter_mut().for_each(|body| body.complete_velocity(self.previous_dt));
        self.prescribe_velocities();
    }

    #[inline]
    fn prescribe_velocities(&mut self) {
        let clock = Clock { now: self.now, user_amplitudes: &self.state.user_amplitudes };
        self.state.constraints.iter_mut().for_each(|c| c.velocities(&mut self.state.dofs, &clock));
    }

    fn make_increment(&mut self, next: Increment) {
        let dt = next.length;
        self.state.dofs.bodies.iter_mut().for_each(|body| body.advance(dt));
        if !self.state.elements.is_empty() {
            central_difference::advance_nodes(&self.state.elements, &mut self.state.dofs, dt, self.threads);
            self.state.elements.moved();
        }
        let clock = Clock { now: self.now, user_amplitudes: &self.state.user_amplitudes };
        for constraint in &mut self.state.constraints {
            let started = self.timing.start();
            constraint.motion(&mut self.state.dofs, &clock, dt);
            self.timing.stop(started, constraint.effect());
        }
        if let Some(heat) = self.state.thermal.as_mut().and_then(|t| t.heat.as_mut()) {
            heat.cross(&self.state.constraints, dt);
            heat.advance(&clock, dt);
        }
        for body in &mut self.state.dofs.bodies {
            body.show_velocity_after(self.velocity_extrapolation * dt);
        }
        self.complete = false;
        self.previous_instant = self.now;
        self.now = next.arrival(&self.now, self.step.duration);
        self.last_increment = dt;
        self.previous_dt = dt;
        // From step to step central differences go on, unless forces on bodies turn out to be others.
        let goes_on = next.end == End::Step && (self.body_forces.tied > 0 || !self.is_last_step());
        if next.end != End::Plain && !goes_on {
            self.start_afresh(next.end);
        }
    }

    /// After an instant of rest or a jump of a force the next increment of bodies starts as the first did, from the velocity
    /// at its own time.
    fn start_afresh(&mut self, end: End) {
        self.state.dofs.bodies.iter_mut().for_each(|body| body.complete_velocity(self.previous_dt));
        self.prescribe_velocities();
        if let End::Rest(b) = end {
            self.state.dofs.bodies[b].arrest();
            let (body, displacement) = (self.plan.bodies[b].name.clone(), self.state.dofs.bodies[b].displacement);
            self.outcome.rests.push(Rest { body, time: self.now.total_time, displacement });
        }
        self.previous_dt = 0.0;
        self.show_own_velocity();
    }

    /// Where central differences start, loads see the velocity itself.
    fn show_own_velocity(&mut self) {
        self.state.dofs.bodies.iter_mut().for_each(BodyState::show_own_velocity);
    }

    /// After a failure: the state of the last instant that was complete.
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
        if let Some(summary) = self.outcome.steps.last_mut() {
            summary.increments += 1;
            summary.time = self.now.step_time;
            summary.limits.take(self.previous_instant.total_time, length, by, limiting.unwrap_or_default());
            if length < summary.smallest_increment {
                summary.smallest_increment = length;
                self.limiting = limiting;
            }
            summary.largest_increment = summary.largest_increment.max(length);
        }
    }
}
