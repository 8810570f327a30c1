//! State of a run at an instant: what the motion changes, and what monitors and output read.

use super::body_forces::BodyForces;
use super::energy::{Energy, EnergyBalance};
use super::masses::MassMonitor;
use crate::constraint::contact::ContactConstraint;
use crate::constraint::{of_kind, prescribed_motions};
use crate::heat::field::TemperatureField;
use crate::model::{IncrementControl, LoadVelocity};
use crate::plan::{Plan, State, StepPlan};
use crate::state::archive::Persist;
use crate::state::magnitude::AmplitudeClock;
use crate::state::{BodyState, Instant};

/// State of a run at an instant.
#[derive(Persist)]
#[persist(derived: plan, step, velocity_extrapolation, previous_stable_increment)]
pub(super) struct RunState<'a> {
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
    /// Stable time increment of elements, springs and dashpots at the previous instant, if the deck fixes increments.
    pub(super) previous_stable_increment: f64,
    /// Whether forces, motion and energies belong to the current instant.
    pub(super) complete: bool,
    pub(super) body_forces: BodyForces,
    pub(super) balance: EnergyBalance,
    /// Masses before and after mass scaling.
    pub(super) masses: MassMonitor,
}

impl<'a> RunState<'a> {
    pub(super) fn new(plan: &'a Plan, state: State) -> Self {
        RunState {
            plan,
            step: &plan.steps[0],
            now: Instant::default(),
            previous_instant: Instant::default(),
            previous_dt: 0.0,
            last_increment: 0.0,
            velocity_extrapolation: 0.0,
            previous_stable_increment: f64::INFINITY,
            complete: false,
            body_forces: BodyForces::default(),
            balance: EnergyBalance::start(&state.dofs),
            masses: MassMonitor::default(),
            state,
        }
    }

    /// Sets the plan of the current step.
    pub(super) fn use_step(&mut self, step: &'a StepPlan) {
        self.step = step;
        self.velocity_extrapolation = match step.load_velocity {
            LoadVelocity::Predicted => 0.5,
            LoadVelocity::Lagged => 0.0,
        };
    }

    /// Returns the current instant with the values of user amplitudes.
    #[inline(always)]
    pub(super) fn clock(&self) -> AmplitudeClock<'_> {
        AmplitudeClock { now: self.now, user_amplitudes: &self.state.user_amplitudes }
    }

    pub(super) fn is_last_step(&self) -> bool {
        self.now.step as usize == self.plan.steps.len()
    }

    pub(super) fn contacts(&self) -> impl Iterator<Item = &ContactConstraint> {
        of_kind(&self.state.constraints)
    }

    /// Returns node and axis of all prescribed motions, in ascending order.
    pub(super) fn sorted_prescribed_motions(&self) -> Vec<(usize, usize)> {
        let mut motions: Vec<_> = prescribed_motions(&self.state.constraints).collect();
        motions.sort_unstable();
        motions
    }

    pub(super) fn energy(&self) -> Energy {
        let heat = self.state.heat().map(TemperatureField::energies);
        let removed = self.state.elements.deletions.record.as_ref().map(|r| r.totals(&self.state.dofs.nodes));
        let (external, internal) = (heat.map(|h| h.external), heat.map(|h| h.internal));
        let added_mass = self.state.scaling.as_ref().and_then(|_| self.masses.added_percent(&self.state.elements));
        Energy { heat: external, internal_heat: internal, removed, added_mass, ..self.balance.energy() }
    }

    /// Returns group and element that limit the increment; `None` without elements.
    #[inline]
    pub(super) fn limits(&self) -> Option<(usize, usize)> {
        // Rigid bodies alone have many short increments.
        if self.state.elements.is_empty() { None } else { self.slowest_element() }
    }

    #[inline(never)]
    fn slowest_element(&self) -> Option<(usize, usize)> {
        let slower = |h: &&TemperatureField| h.stable_increment() < self.state.elements.stable_increment();
        self.state.heat().filter(slower).map(TemperatureField::limiting).or_else(|| self.state.elements.limiting())
    }

    /// Returns the length of fixed increments and its ratio to the stable time increment at the previous instant, if they
    /// are longer.
    pub(super) fn beyond_stability(&self) -> Option<[f64; 2]> {
        match self.step.control {
            IncrementControl::Fixed(length) if length > self.previous_stable_increment => {
                Some([length, length / self.previous_stable_increment])
            }
            _ => None,
        }
    }

    /// Returns whether all energies so far are negligible: less than the kinetic energy of the model at 100 rounding
    /// errors of coordinates per increment, or than the energy that contact takes from bodies at rest.
    pub(super) fn is_noise(&self) -> bool {
        const ROUNDINGS: f64 = 100.0;
        let nodes = &self.state.dofs.nodes;
        let extent = nodes.start.iter().flatten().fold(0.0_f64, |largest, x| largest.max(x.abs()));
        let speed = ROUNDINGS * f64::EPSILON * extent / self.last_increment;
        let rounding = 0.5 * nodes.mass.iter().sum::<f64>() * speed * speed;
        // Below this value products of energies underflow.
        let stopped: f64 = self.state.dofs.bodies.iter().map(BodyState::energy_stopped).sum();
        self.balance.largest() <= rounding.max(stopped).max(f64::MIN_POSITIVE / f64::EPSILON)
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

    #[inline]
    pub(super) fn remember_stable_increment(&mut self) {
        if !self.state.dofs.nodes.is_empty() && self.step.is_fixed() {
            self.previous_stable_increment = self.state.elements.stable_increment();
        }
    }

    pub(super) fn update_balance(&mut self) {
        self.balance.add_increment(
            &self.state.dofs,
            &self.body_forces.values,
            self.previous_dt == 0.0,
            (!self.state.dofs.nodes.is_empty()).then_some(self.now.total_time),
        );
        self.complete = true;
    }
}
