//! A run: everything an increment touches, and the increment as a numbered recipe.
//! Never here: the loop over increments, output, states that are kept.

use super::central_difference;
use super::energy::{Balance, Energy};
use super::increment::{End, Increment, IncrementController, Scene};
use super::limits::Limits;
use super::outcome::{Outcome, Rest, StepSummary};
use super::timing::Timing;
use super::watch::Watch;
use crate::constraint::Constraint;
use crate::constraint::user_motion::UserMotion;
use crate::element::elements::{Collapsed, Elements};
use crate::element::mass_scaling::Scaling;
use crate::element::volume_guard::STARTING;
use crate::heat::Thermal;
use crate::heat::field::Heat;
use crate::kernel::amplitude::SampledAmplitude;
use crate::load::user_amplitude::UserAmplitude;
use crate::load::{
    Account, Dissipation, Forces, GeneralizedForce, Load, Penetration, PenetrationOutcome, SceneChange, SceneView,
    VelocityUse,
};
use crate::model::{IncrementControl, LoadVelocity};
use crate::plan::{Changes, Plan, State, StepPlan};
use crate::state::dofs::Dofs;
use crate::state::halt::Halt;
use crate::state::magnitude::Clock;
use crate::state::{BodyState, Instant};
use crate::user::{Locked, RunAction, SavedMemory};

/// Everything an increment touches. Aligned, so that what it costs does not depend on where the stack begins.
#[repr(align(64))]
pub(super) struct Run<'a> {
    pub(super) plan: &'a Plan,
    pub(super) step: &'a StepPlan,
    pub(super) dofs: Dofs,
    pub(super) elements: Elements,
    /// Temperatures of nodes and thermal strains.
    pub(super) thermal: Option<Box<Thermal>>,
    pub(super) now: Instant,
    /// Loads in force; those that resist come last.
    pub(super) loads: Vec<Box<dyn Load>>,
    pub(super) constraints: Vec<Box<dyn Constraint>>,
    pub(super) scaling: Option<Scaling>,
    /// What resistances that are no longer in force have seen of the bodies in them.
    pub(super) ended: EndedResistances,
    /// Functions of time that the user's routines tell, and what asks for them.
    pub(super) told: Vec<SampledAmplitude>,
    pub(super) amplitudes: Vec<UserAmplitude>,
    #[allow(clippy::vec_box)] // The list is changed as those of loads and constraints are.
    pub(super) motions: Vec<Box<UserMotion>>,
    pub(super) user: Locked<'a>,
    /// Generalised forces on bodies: those of constraints, then of loads; what each is; and where each load's end.
    pub(super) forces: Vec<f64>,
    pub(super) slots: Vec<GeneralizedForce>,
    /// Indices of the generalised forces in order of their bodies.
    pub(super) slots_by_body: Vec<usize>,
    pub(super) ends: Vec<usize>,
    /// Index of the first load that resists; such loads come last.
    pub(super) resistances: usize,
    /// The first generalised forces are those of tied nodes.
    pub(super) ties: usize,
    pub(super) now_before: Instant,
    /// Part of the previous increment over which the velocity that loads see is extrapolated from its middle: half of it, or none.
    pub(super) velocity_extrapolation: f64,
    /// Length of the increment behind; 0 where central differences of bodies start afresh with the half step.
    pub(super) behind: f64,
    /// The increment that led here, for the energy balance and for output.
    pub(super) last_increment: f64,
    /// The increment that elements bore at the instant before, where the deck gives increments.
    pub(super) bearable: f64,
    /// Whether the instant is complete: forces, motion and energies belong to it.
    pub(super) complete: bool,
    /// Whether a step has begun in which the forces of this instant may be others.
    pub(super) forces_may_differ: bool,
    /// What the user's routines want.
    pub(super) wish: RunAction,
    /// Whether they know already that the increment is complete.
    pub(super) told_complete: bool,
    /// Whether it has been said what states that are kept do not hold.
    pub(super) told_of_loss: bool,
    /// What a state that was taken up has of the routines.
    pub(super) taken_up: SavedMemory,
    /// Group and element that limited the smallest increment of the step.
    pub(super) limiting: Option<(usize, usize)>,
    pub(super) balance: Balance,
    /// Which limits on energies have been told in this step.
    pub(super) warned: [bool; 2],
    /// What is watched over the run.
    pub(super) watch: Watch,
    /// Whether other threads may take part.
    pub(super) threads: bool,
    /// Room for the kinetic energies of chunks of nodes.
    pub(super) kinetic: Vec<f64>,
    pub(super) timing: Timing,
    pub(super) outcome: Outcome,
}

impl<'a> Run<'a> {
    pub(super) fn new(plan: &'a Plan, state: State) -> Self {
        let State { dofs, elements, thermal, loads, constraints, scaling, .. } = state;
        let State { user_motions, amplitude_routines, user_amplitudes, .. } = state;
        let balance = Balance::start(&dofs);
        Run {
            plan,
            step: &plan.steps[0],
            now: Instant::default(),
            loads,
            constraints,
            scaling,
            ended: EndedResistances::default(),
            told: user_amplitudes,
            amplitudes: amplitude_routines,
            motions: user_motions,
            user: plan.routines.lock(),
            forces: Vec::new(),
            slots: Vec::new(),
            slots_by_body: Vec::new(),
            ends: Vec::new(),
            resistances: 0,
            ties: 0,
            now_before: Instant::default(),
            velocity_extrapolation: 0.0,
            behind: 0.0,
            last_increment: 0.0,
            bearable: f64::INFINITY,
            complete: false,
            forces_may_differ: false,
            wish: RunAction::Continue,
            told_complete: false,
            told_of_loss: false,
            taken_up: SavedMemory::default(),
            limiting: None,
            warned: [false; 2],
            watch: Watch::default(),
            threads: rayon::current_num_threads() > 1,
            kinetic: central_difference::room_for_parts(&dofs.nodes),
            timing: Timing::new(plan.ledger.effects.len()),
            balance,
            outcome: Outcome::default(),
            dofs,
            elements,
            thermal,
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
            self.bearable = self.elements.stable_increment();
        }
    }

    #[inline]
    fn choose(&self, control: &mut IncrementController) -> Increment {
        let clock = Clock { now: self.now, told: &self.told };
        control.choose(&Scene {
            view: SceneView {
                clock,
                dofs: &self.dofs,
                velocity_extrapolation: self.velocity_extrapolation,
                rings: self.elements.ring_factors(),
            },
            elements: &self.elements,
            heat: self.heat(),
            loads: &self.loads,
            constraints: &self.constraints,
            behind: self.behind,
            remaining: self.step.duration - self.now.step_time,
        })
    }

    pub(super) fn name_limiting_element(&mut self) {
        let Some(summary) = self.outcome.steps.last_mut() else { return };
        summary.global_estimates = self.elements.estimates();
        if let Some((group, element)) = self.limiting.take() {
            summary.limiting_element = Some(self.plan.element_name(group, element).to_owned());
        }
    }

    fn is_last_step(&self) -> bool {
        self.now.step as usize == self.plan.steps.len()
    }

    /// Whether the step is at its end, or a user's routine wants it to be.
    pub(super) fn is_over(&self) -> bool {
        self.now.step_time >= self.step.duration || self.wish != RunAction::Continue
    }

    /// Begins a step, counted from 0: puts in force what it changes. All else goes on. Returns whether anything changes.
    pub(super) fn begin(&mut self, index: usize) -> bool {
        let (step, previous) = (&self.plan.steps[index], self.step);
        let heat = self.thermal.as_mut().and_then(|t| t.heat.as_mut());
        let heat_changes = heat.is_some_and(|heat| heat.begin(index));
        let changes = index == 0 || heat_changes || !step.changes.is_empty();
        self.put_in_force(&step.changes);
        self.step = step;
        self.velocity_extrapolation = match step.load_velocity {
            LoadVelocity::Predicted => 0.5,
            LoadVelocity::Lagged => 0.0,
        };
        if changes {
            self.begin_slots();
            self.begin_constraints();
            self.balance.begin(&self.slots, &self.dofs.bodies);
            self.watch.begin_step();
        }
        if step.energy_limit != previous.energy_limit {
            self.warned = [false; 2];
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
        let added_mass = added_mass.filter(|_| self.scaling.is_some());
        self.outcome.steps.push(StepSummary { name, smallest_increment, limits, added_mass, ..Default::default() });
        changes
    }

    fn put_in_force(&mut self, changes: &Changes) {
        if let Some(loads) = &changes.loads {
            let ended = loads.apply(&mut self.loads, |load, previous| load.continue_from(previous));
            self.warn_of_stiff_loads(&ended);
            self.ended.take(&ended, &self.dofs);
        }
        if let Some(constraints) = &changes.constraints {
            let take_over =
                |constraint: &mut dyn Constraint, previous: &dyn Constraint| constraint.continue_from(previous);
            let mut ended = constraints.apply(&mut self.constraints, take_over);
            self.warn_of_constraints(&mut ended);
        }
        if let Some(motions) = &changes.user_motions {
            motions.apply(&mut self.motions, |_, _| {});
        }
        match &changes.scaling {
            Some(scaling) => self.scaling.clone_from(scaling),
            None => self.scaling.iter_mut().for_each(Scaling::begin_step),
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
        // Without an increment behind nothing is booked twice.
        let previous_dt = std::mem::take(&mut self.behind);
        let bodies = self.dofs.bodies.clone();
        self.evaluate_forces()?;
        self.accelerate()?;
        self.balance.take_forces(&self.forces);
        let go_on = bodies.iter().zip(&self.dofs.bodies).all(|(before, now)| now.has_same_forces(before));
        if go_on {
            (self.dofs.bodies, self.behind) = (bodies, previous_dt);
        } else if self.ties > 0 {
            self.behind = previous_dt;
            self.correct_velocity();
        } else {
            self.show_own_velocity();
        }
        Ok(())
    }

    fn begin_slots(&mut self) {
        self.slots.clear();
        self.ends.clear();
        let carried = self.constraints.iter().filter_map(|c| c.view().carried);
        self.slots.extend(carried.map(|carried| GeneralizedForce::along_z(carried.body, Account::Tie)));
        self.ties = self.slots.len();
        for load in &self.loads {
            self.slots.extend(load.targets().bodies);
            self.ends.push(self.slots.len());
        }
        self.resistances = self.loads.iter().filter(|l| l.velocity_use() != VelocityUse::Resists).count();
        self.forces = vec![0.0; self.slots.len()];
        self.slots_by_body = (0..self.slots.len()).collect();
        self.slots_by_body.sort_by_key(|&i| self.slots[i].body);
        for (b, body) in self.dofs.bodies.iter_mut().enumerate() {
            // Constraints say anew which are prescribed, and what contact does to them.
            (body.reads_velocity, body.prescribed, body.contact) = (false, false, 0.0);
            body.tied = self.slots[..self.ties].iter().any(|s| s.body == b);
            body.slots = self.slots.iter().filter(|s| s.body == b).count() as u32;
            body.set_resisted(false);
        }
        for load in &self.loads {
            let resists = load.velocity_use() == VelocityUse::Resists;
            if load.velocity_use() == VelocityUse::None {
                continue;
            }
            for force in load.targets().bodies {
                self.dofs.bodies[force.body].reads_velocity = true;
                if resists {
                    self.dofs.bodies[force.body].set_resisted(true);
                }
            }
        }
    }

    fn begin_constraints(&mut self) {
        self.elements.begin(self.constraints.iter().any(|c| c.view().moves_nodes));
        let pushed = self.elements.has_links() || self.loads.iter().any(|l| l.targets().nodes);
        self.dofs.nodes.make_room(pushed);
        self.constraints.iter_mut().for_each(|c| c.begin(&mut self.dofs));
    }

    /// What the user's routine tells of its material, and what follows from the moduli and from what is prescribed: the first
    /// estimate of the highest frequency.
    pub(super) fn begin_nodes(&mut self, changes: bool) -> Result<(), Halt> {
        if self.elements.is_empty() || !changes {
            return Ok(());
        }
        if self.now.step == 1 {
            self.elements.probe(&self.dofs.nodes, &self.now, self.user.at_points())?;
        }
        let global = matches!(self.step.control, IncrementControl::Automatic { element_by_element: false, .. });
        let views = || self.constraints.iter().map(|c| c.view());
        let prescribed: Vec<_> = views().filter_map(|v| v.forces).flat_map(|forces| forces.prescribed()).collect();
        let carried: Vec<_> = views().filter_map(|v| v.carried).flat_map(|c| c.nodes.to_vec()).collect();
        let held = crate::element::frequency::Held { prescribed: &prescribed, carried: &carried };
        self.elements.begin_frequency(global, &self.dofs.nodes, &held);
        Ok(())
    }

    fn evaluate_forces(&mut self) -> Result<(), Halt> {
        if !self.elements.is_empty() {
            self.evaluate_nodes()?;
        }
        self.push_bodies(0, self.resistances)?;
        if self.resistances < self.loads.len() {
            let applied = self.resistances.checked_sub(1).map_or(self.ties, |last| self.ends[last]);
            turn_resting_bodies(&mut self.dofs.bodies, &self.slots[..applied], &self.forces);
            self.push_bodies(self.resistances, self.loads.len())?;
        }
        Ok(())
    }

    /// Forces of some of the loads on bodies.
    #[inline]
    fn push_bodies(&mut self, first: usize, end: usize) -> Result<(), Halt> {
        let clock = Clock { now: self.now, told: &self.told };
        let view =
            SceneView { clock, dofs: &self.dofs, velocity_extrapolation: self.velocity_extrapolation, rings: None };
        let mut start = first.checked_sub(1).map_or(self.ties, |before| self.ends[before]);
        for (load, &end) in self.loads[first..end].iter_mut().zip(&self.ends[first..end]) {
            let clock = self.timing.start();
            load.apply(&view, &mut self.user, &mut Forces::OnBodies(&mut self.forces[start..end]))?;
            self.timing.stop(clock, load.effect());
            start = end;
        }
        Ok(())
    }

    /// Stresses of elements, forces of loads and links on nodes, and what of them goes to bodies.
    fn evaluate_nodes(&mut self) -> Result<(), Halt> {
        self.scale_masses();
        let fresh = self.elements.is_pending();
        if fresh {
            self.warm();
            self.give_fields();
        }
        let user = self.user.at_points();
        self.elements.update(&mut self.dofs, &self.now, self.threads, user, self.timing.groups());
        if self.thermal.is_some() {
            self.conduct(fresh);
        }
        self.dofs.nodes.begin_forces();
        self.release_faces();
        self.push_nodes()?;
        self.elements.link(&mut self.dofs);
        self.elements.check(&self.dofs.nodes).map_err(|collapsed| self.collapsed(collapsed))?;
        self.transfer_to_bodies();
        Ok(())
    }

    /// Temperatures of nodes, where they are solved for.
    pub(super) fn heat(&self) -> Option<&Heat> {
        self.thermal.as_ref()?.heat.as_ref()
    }

    /// Gives elements their temperatures and takes their thermal strains off.
    #[inline(never)]
    fn warm(&mut self) {
        let Some(thermal) = &mut self.thermal else { return };
        let clock = self.timing.start();
        thermal.before(&mut self.elements, &mut self.dofs, &Clock { now: self.now, told: &self.told });
        if let Some(heat) = &thermal.heat {
            self.timing.stop(clock, heat.id);
        }
    }

    /// Gives elements the field variables that are prescribed.
    #[inline(never)]
    fn give_fields(&mut self) {
        let Some(id) = self.elements.fields.as_ref().map(|f| f.id) else { return };
        let clock = self.timing.start();
        self.elements.give_fields(&Clock { now: self.now, told: &self.told });
        self.timing.stop(clock, id);
    }

    /// What plastic work made, and the flow of heat at this instant.
    #[inline(never)]
    fn conduct(&mut self, fresh: bool) {
        let Some(heat) = self.thermal.as_mut().and_then(|t| t.heat.as_mut()) else { return };
        let started = self.timing.start();
        if fresh {
            heat.take(&mut self.elements);
        }
        let clock = Clock { now: self.now, told: &self.told };
        heat.evaluate(&self.elements, &self.dofs, &self.constraints, &clock, self.threads);
        self.timing.stop(started, heat.id);
    }

    pub(super) fn energy(&self) -> Energy {
        let heat = self.heat().map(Heat::energies);
        let removed = self.elements.removed.as_ref().map(|r| r.books(&self.dofs.nodes));
        let (external, internal) = (heat.map(|h| h.external), heat.map(|h| h.internal));
        Energy { heat: external, internal_heat: internal, removed, ..self.balance.energy() }
    }

    /// Group and element that limit the increment.
    pub(super) fn limits(&self) -> (usize, usize) {
        let slower = |h: &&Heat| h.stable_increment() < self.elements.stable_increment();
        self.heat().filter(slower).map_or_else(|| self.elements.limiting(), Heat::limiting)
    }

    /// Forces of nodes on the rigid bodies that carry them.
    fn transfer_to_bodies(&mut self) {
        let (elements, nodes) = (&self.elements, &self.dofs.nodes);
        let force = |n: usize| {
            let ([r, z], more) = (elements.nodal_force(n), nodes.forces[0].get(n).copied().unwrap_or_default());
            [r + more[0], z + more[1]]
        };
        let carried = self.constraints.iter().filter_map(|c| c.view().carried);
        for (carried, out) in carried.zip(&mut self.forces) {
            *out = carried.force(force);
        }
    }

    fn scale_masses(&mut self) {
        let Some(scaling) = &mut self.scaling else { return };
        let constraints = &mut self.constraints;
        let changed = &mut |n, gained| {
            constraints.iter_mut().filter_map(|c| c.upkeep()).for_each(|c| c.masses_changed(n, gained));
        };
        if !self.elements.scale_masses(scaling, &self.now, &mut self.dofs, changed) {
            return;
        }
        let masses = SceneChange::Masses(&self.dofs.nodes.mass);
        self.loads.iter_mut().for_each(|load| load.scene_changed(&masses));
        if let Some(summary) = self.outcome.steps.last_mut() {
            summary.added_mass = self.elements.added_mass(&self.dofs.nodes);
        }
    }

    fn release_faces(&mut self) {
        let deleted = self.elements.newly_deleted();
        if !deleted.is_empty() {
            self.loads.iter_mut().for_each(|load| load.scene_changed(&SceneChange::DeletedElements(deleted)));
            self.constraints.iter_mut().filter_map(|c| c.upkeep()).for_each(|c| c.remove_elements(deleted));
            if let Some(heat) = self.thermal.as_mut().and_then(|t| t.heat.as_mut()) {
                heat.release(deleted);
            }
        }
    }

    fn push_nodes(&mut self) -> Result<(), Halt> {
        // Out of the way of what loads look at.
        let mut forces = std::mem::take(&mut self.dofs.nodes.forces[0]);
        let mut dissipated = Dissipation::default();
        let view = SceneView {
            clock: Clock { now: self.now, told: &self.told },
            dofs: &self.dofs,
            velocity_extrapolation: self.velocity_extrapolation,
            rings: self.elements.ring_factors(),
        };
        let mut result = Ok(());
        for load in &mut self.loads {
            let clock = self.timing.start();
            match load.apply(&view, &mut self.user, &mut Forces::OnNodes(&mut forces)) {
                Ok(work) => dissipated.add(work),
                Err(halt) => {
                    result = Err(halt);
                    break;
                }
            }
            self.timing.stop(clock, load.effect());
        }
        self.dofs.nodes.forces[0] = forces;
        let Dissipation { cavity, friction } = dissipated;
        self.dofs.energies.cavity += cavity;
        self.dofs.energies.friction += friction;
        self.dofs.energies.external += cavity + friction;
        result
    }

    #[cold]
    fn collapsed(&self, Collapsed { group, element, volume }: Collapsed) -> Halt {
        if let Some(halt) = &self.elements.failure {
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
        let ratio = given / self.bearable;
        if ratio <= 1.0 {
            return String::new();
        }
        format!(
            "; the increment that DIRECT USER CONTROL gives, {given:e}, is {ratio:.2} times the stable one at the instant before, \
             {:.3e}: give a smaller one, or leave it to the program",
            self.bearable
        )
    }

    fn accelerate(&mut self) -> Result<(), Halt> {
        let mut start = 0;
        for b in 0..self.dofs.bodies.len() {
            let body = &mut self.dofs.bodies[b];
            let own = &self.slots_by_body[start..start + body.slots as usize];
            start += own.len();
            let forces = own.iter().map(|&i| (self.slots[i].coordinate, self.forces[i]));
            if body.accelerate(forces) {
                self.hold(b);
            }
        }
        if !self.elements.is_empty() {
            let clock = self.timing.start();
            central_difference::accelerate_nodes(&self.elements, &mut self.dofs, &mut self.kinetic, self.threads);
            self.timing.stop_gather(clock, self.plan);
        }
        let clock = Clock { now: self.now, told: &self.told };
        for constraint in &mut self.constraints {
            constraint.accelerations(&mut self.dofs, &clock);
        }
        self.dofs.nodes.moved = false;
        // An increment that the deck fixes follows nothing.
        let automatic = matches!(self.step.control, IncrementControl::Automatic { .. });
        if !self.elements.is_empty() && self.now.increment < STARTING && automatic {
            self.elements.guard_start(&self.dofs.nodes);
        }
        if self.dofs.bodies.iter().all(|b| b.acceleration.abs() < f64::INFINITY) {
            Ok(())
        } else {
            Err(self.not_finite())
        }
    }

    fn book(&mut self) {
        self.balance.book(&self.dofs, &self.forces, self.behind == 0.0, !self.elements.is_empty());
        self.complete = true;
    }

    /// The resistances on a body at rest give just what the other forces ask of them, and do no work.
    fn hold(&mut self, body: usize) {
        for (slot, force) in self.slots.iter().zip(&mut self.forces) {
            if slot.body == body && matches!(slot.account, Account::Friction | Account::Cavity) {
                *force = 0.0;
            }
        }
    }

    fn not_finite(&self) -> Halt {
        let b = self.dofs.bodies.iter().position(|b| !b.acceleration.is_finite()).unwrap_or_default();
        let (name, time, body) = (&self.plan.bodies[b].name, self.now.total_time, &self.dofs.bodies[b]);
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
        if self.behind == 0.0 {
            return;
        }
        self.dofs.bodies.iter_mut().for_each(|body| body.complete_velocity(self.behind));
        self.prescribe_velocities();
    }

    #[inline]
    fn prescribe_velocities(&mut self) {
        let clock = Clock { now: self.now, told: &self.told };
        self.constraints.iter_mut().for_each(|c| c.velocities(&mut self.dofs, &clock));
    }

    fn make_increment(&mut self, next: Increment) {
        let dt = next.length;
        self.dofs.bodies.iter_mut().for_each(|body| body.advance(dt));
        if !self.elements.is_empty() {
            central_difference::advance_nodes(&self.elements, &mut self.dofs, dt, self.threads);
            self.elements.moved();
        }
        let clock = Clock { now: self.now, told: &self.told };
        for constraint in &mut self.constraints {
            let started = self.timing.start();
            constraint.motion(&mut self.dofs, &clock, dt);
            self.timing.stop(started, constraint.effect());
        }
        if let Some(heat) = self.thermal.as_mut().and_then(|t| t.heat.as_mut()) {
            heat.cross(&self.constraints, dt);
            heat.advance(&clock, dt);
        }
        for body in &mut self.dofs.bodies {
            body.show_velocity_after(self.velocity_extrapolation * dt);
        }
        self.complete = false;
        self.now_before = self.now;
        self.now = next.arrival(&self.now, self.step.duration);
        self.last_increment = dt;
        self.behind = dt;
        // From step to step central differences go on, unless forces on bodies turn out to be others.
        let goes_on = next.end == End::Step && (self.ties > 0 || !self.is_last_step());
        if next.end != End::Plain && !goes_on {
            self.start_afresh(next.end);
        }
    }

    /// After an instant of rest or a jump of a force the next increment of bodies starts as the first did, from the velocity
    /// at its own time.
    fn start_afresh(&mut self, end: End) {
        self.dofs.bodies.iter_mut().for_each(|body| body.complete_velocity(self.behind));
        self.prescribe_velocities();
        if let End::Rest(b) = end {
            self.dofs.bodies[b].arrest();
            let (body, displacement) = (self.plan.bodies[b].name.clone(), self.dofs.bodies[b].displacement);
            self.outcome.rests.push(Rest { body, time: self.now.total_time, displacement });
        }
        self.behind = 0.0;
        self.show_own_velocity();
    }

    /// Where central differences start, loads see the velocity itself.
    fn show_own_velocity(&mut self) {
        self.dofs.bodies.iter_mut().for_each(BodyState::show_own_velocity);
    }

    /// After a failure: the state of the last instant that was complete.
    pub(super) fn step_back(&mut self) {
        if self.now.increment == 0 || self.complete {
            return;
        }
        self.dofs.bodies.iter_mut().for_each(BodyState::step_back);
        self.now = self.now_before;
    }

    fn record(&mut self, Increment { length, by, .. }: Increment) {
        self.outcome.increments = self.now.increment;
        let limiting = (!self.elements.is_empty()).then(|| self.limits());
        if let Some(summary) = self.outcome.steps.last_mut() {
            summary.increments += 1;
            summary.time = self.now.step_time;
            summary.limits.take(self.now_before.total_time, length, by, limiting.unwrap_or_default());
            if length < summary.smallest_increment {
                summary.smallest_increment = length;
                self.limiting = limiting;
            }
            summary.largest_increment = summary.largest_increment.max(length);
        }
    }
}

/// What has become of bodies in resistances that are no longer in force.
#[derive(Default)]
pub(super) struct EndedResistances(pub(super) Vec<Penetration>);

impl EndedResistances {
    fn take(&mut self, ended: &[Box<dyn Load>], dofs: &Dofs) {
        let all = ended.iter().flat_map(|load| load.penetrations(dofs));
        self.0.extend(all.filter(|p| p.in_space.is_some() || p.outcome == PenetrationOutcome::Through));
    }

    /// What has become of all bodies, where that in resistances in force is given.
    pub(super) fn beside(&self, in_force: Vec<Penetration>) -> Vec<Penetration> {
        let is_met = |p: &&Penetration| p.outcome != PenetrationOutcome::NotMet;
        let newer = |p: &Penetration| in_force.iter().filter(is_met).any(|other| other.body == p.body);
        let kept: Vec<Penetration> = self.0.iter().filter(is_met).filter(|p| !newer(p)).copied().collect();
        let rest = in_force.iter().filter(|p| kept.iter().all(|other| other.body != p.body));
        kept.iter().chain(rest).copied().collect()
    }
}

/// A body at rest would start the way the other forces push it: that is what a resistance then opposes.
fn turn_resting_bodies(bodies: &mut [BodyState], applied: &[GeneralizedForce], forces: &[f64]) {
    for (b, body) in bodies.iter_mut().enumerate().filter(|(_, body)| body.direction == 0.0) {
        let on = applied.iter().zip(forces).filter(|(s, _)| s.body == b);
        body.probe(on.map(|(s, &force)| (s.coordinate, force)));
    }
}
