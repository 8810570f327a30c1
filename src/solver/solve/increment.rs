//! Choice of the time increment, and of the event at its end.

use super::limits::IncrementLimiter;
use super::run_state::RunState;
use crate::constraint::contact::ContactConstraint;
use crate::constraint::{Constraint, of_kind};
use crate::element::connector::damped_rate;
use crate::load::{SceneView, VelocityUse};
use crate::model::IncrementControl;
use crate::plan::{State, StepPlan};
use crate::state::archive::Persist;
use crate::state::halt::{HaltDetails, HaltReason};
use crate::state::limit::IncrementLimit;
use crate::state::{BodyState, Instant};

/// Event that determines the end of an increment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IncrementEnd {
    /// No event.
    Plain,
    /// The step ends.
    Step,
    /// A force jumps, for example at the interface of two layers.
    Jump,
    /// The body with this index comes to rest.
    Rest(usize),
}

/// Length of the next increment and the event at its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Increment {
    /// Length of the increment, time.
    pub length: f64,
    /// Event at the end of the increment.
    pub end: IncrementEnd,
    /// Reason for its length.
    pub by: IncrementLimiter,
}

impl Increment {
    /// Returns the instant at the end of the increment; the end of the step is reached to the last bit.
    pub fn arrival(&self, now: &Instant, duration: f64) -> Instant {
        let added = self.length - now.lost;
        let sum = now.step_time + added;
        let lost = (sum - now.step_time) - added;
        let step_time = if self.end == IncrementEnd::Step { duration } else { sum };
        let total_time = now.total_time + (step_time - now.step_time);
        Instant { step_time, total_time, increment: now.increment + 1, lost, ..*now }
    }

    /// Checks that the increment changes the time.
    ///
    /// # Errors
    /// If the time does not change because of rounding.
    #[inline]
    pub fn check(&self, now: &Instant) -> Result<(), HaltReason> {
        if now.total_time + self.length > now.total_time { Ok(()) } else { Err(too_small(self.length, now)) }
    }

    #[inline]
    fn shorten(&mut self, limit: IncrementLimit, by: impl FnOnce() -> IncrementLimiter) {
        if limit.time < self.length {
            *self = Increment {
                length: limit.time,
                end: if limit.jump { IncrementEnd::Jump } else { IncrementEnd::Plain },
                by: by(),
            };
        }
    }

    fn bound(&mut self, length: f64, by: IncrementLimiter) {
        if length < self.length {
            (self.length, self.by) = (length, by);
        }
    }
}

#[cold]
fn too_small(length: f64, now: &Instant) -> HaltReason {
    let Instant { total_time, increment, .. } = now;
    let reason = format!(
        "the next increment, {length:e}, is too small to change the time {total_time:e} (increment {increment})"
    );
    HaltReason::IncrementTooSmall(HaltDetails::new(reason))
}

/// First automatic increment as a fraction of the largest allowed one, because no forces are known yet.
const FIRST: f64 = 0.01;
/// Largest ratio of successive increments.
const GROWTH: f64 = 2.0;
/// Allowed change of velocity over an increment, in units of sqrt(accuracy) times the velocity. Central differences are
/// second order, so the error is proportional to `accuracy`; the factor keeps it, and the energy drift, below
/// `accuracy`.
const RESOLUTION: f64 = 0.25;
/// Change of velocity over an increment, in units of the resolution, that is allowed if the force hardly changes.
const COARSEST: f64 = 4.0;
/// Product of the changes of velocity and of acceleration (times the increment) up to which the force hardly changes, in
/// units of the cube of the resolution times the square of the velocity. The energy drift of an increment is an eighth
/// of the mass times twice this product.
const DRIFT: f64 = 0.3;
/// Largest ratio by which the stiffness of loads reduces the increment of elements; a larger stiffness is regarded as a
/// jump.
const STIFFEST: f64 = 100.0;
/// Fraction of the largest speed, in units of the resolution, below which a body with six degrees of freedom under
/// resistance is at rest.
const SLOW: f64 = 0.1;
/// Number of increments between two points of amplitudes up to which all have the same length, from the second such interval on. A
/// pattern of long and short increments with this period could excite vibrations of the mesh (parametric resonance).
const FEW: f64 = 8.0;
/// Fraction by which the last increment of a step may exceed the chosen length.
const SLIVER: f64 = 1e-3;

impl RunState<'_> {
    #[inline]
    fn view(&self) -> SceneView<'_> {
        SceneView {
            clock: self.clock(),
            dofs: &self.state.dofs,
            velocity_extrapolation: self.velocity_extrapolation,
            rings: self.state.elements.assembly.ring_factors(),
            element_force: None,
        }
    }

    /// Returns whether rigid bodies at rest are alone with resistances, which vanish at rest.
    #[inline]
    fn stays_at_rest(&self) -> bool {
        let State { dofs, loads, constraints, user_motions, .. } = &self.state;
        dofs.bodies.iter().all(BodyState::is_still)
            && dofs.nodes.is_empty()
            && constraints.is_empty()
            && user_motions.is_empty()
            && loads.iter().all(|load| load.velocity_use() == VelocityUse::Resists)
    }

    /// Returns the sum of the bounds of the squares of frequencies by springs between bodies.
    fn squared_frequency(&self) -> f64 {
        of_kind(&self.state.constraints).map(ContactConstraint::squared_frequency).sum()
    }

    /// Returns what limits the stable time increment: the elements, or a constraint whose springs have a higher frequency.
    fn stability_limiter(&self) -> IncrementLimiter {
        let elements = self.state.elements.stable_increment();
        let is_stiffer = |squared: f64| squared * elements * elements > 4.0;
        let mut contacts = of_kind::<ContactConstraint>(&self.state.constraints);
        let stiffer = contacts.find(|contact| is_stiffer(contact.squared_frequency()));
        stiffer.map_or(IncrementLimiter::Elements, |constraint| IncrementLimiter::Effect(constraint.effect()))
    }

    /// Returns the stable time increment of elements together with springs of constraints, viscous loads and loads that
    /// were found to be stiff. The square of the highest frequency is at most the sum of the squares of both.
    fn stable_increment(&self) -> f64 {
        let elements = self.state.elements.stable_increment();
        let springs = self.squared_frequency();
        let alone = if springs > 0.0 { 1.0 / damped_rate(1.0 / elements, springs, 0.0) } else { elements };
        let added: f64 = self.state.loads.iter().filter_map(|load| load.stiffness()).map(|s| s.squared).sum();
        let undamped = if added > 0.0 { alone / shortened(added, alone) } else { alone };
        let damping: f64 = self.state.loads.iter().map(|load| load.damping()).sum();
        if damping > 0.0 { 1.0 / damped_rate(1.0 / undamped, 0.0, damping) } else { undamped }
    }
}

/// Returns the ratio by which the stiffness of loads reduces an increment; `added` is the square of a frequency. The
/// increment 2/omega becomes 2/(omega^2 + added)^(1/2).
pub fn shortened(added: f64, increment: f64) -> f64 {
    (1.0 + 0.25 * added * increment * increment).sqrt().min(STIFFEST)
}

/// Choice of increments over a step.
#[derive(Debug, Persist)]
#[persist(fixed: speed; derived: fixed, factor, most, accuracy, resolution, largest)]
pub struct IncrementController {
    fixed: Option<f64>,
    factor: f64,
    /// Largest increment that the deck allows.
    most: f64,
    accuracy: f64,
    resolution: f64,
    largest: f64,
    free: f64,
    /// Step time of the last point of an amplitude at which an increment ends, and the time between the last two.
    last_point: f64,
    last_interval: f64,
    /// Largest speed of each body so far.
    speed: Vec<f64>,
}

impl IncrementController {
    /// Creates the controller at the start of a step.
    pub fn new(step: &StepPlan, bodies: &[BodyState]) -> Self {
        let (fixed, accuracy, longest) = match step.control {
            IncrementControl::Fixed(length) => (Some(length), 1.0, f64::INFINITY),
            IncrementControl::Automatic { accuracy, largest, .. } => (None, accuracy, largest),
        };
        let largest = accuracy.sqrt() * step.duration;
        IncrementController {
            fixed,
            factor: step.scale_factor,
            most: longest,
            accuracy,
            resolution: RESOLUTION * accuracy.sqrt(),
            largest,
            free: FIRST * largest / GROWTH,
            last_point: 0.0,
            last_interval: f64::INFINITY,
            speed: bodies.iter().map(BodyState::speed).collect(),
        }
    }

    /// Continues in a step that changes no effects.
    pub fn continue_in(&mut self, step: &StepPlan, bodies: &[BodyState]) {
        let (free, speed) = (self.free, std::mem::take(&mut self.speed));
        *self = IncrementController { free, speed, ..IncrementController::new(step, bodies) };
    }

    /// Returns the next increment. `next_output` is the step time at which output is due.
    #[inline]
    pub(super) fn choose(&mut self, run: &RunState<'_>, next_output: f64) -> Increment {
        let (state, bodies) = (&run.state, &run.state.dofs.bodies[..]);
        let remaining = run.step.duration - run.now.step_time;
        let mut next = Increment { length: f64::INFINITY, end: IncrementEnd::Plain, by: IncrementLimiter::Given };
        match self.fixed {
            Some(length) => next.length = length,
            None => {
                if bodies.iter().any(|b| !b.tied) {
                    let resolved = self.automatic(bodies, run.previous_dt);
                    let length = if run.stays_at_rest() {
                        // With a margin for rounding, so that the instant is not before the output.
                        resolved.max((next_output - run.now.step_time) * (1.0 + 1e-9))
                    } else {
                        resolved
                    };
                    next.bound(length * self.factor, IncrementLimiter::Accuracy);
                }
                if !state.dofs.nodes.is_empty() {
                    next = self.bound_by_stability(next, run);
                }
                next.bound(self.most, IncrementLimiter::Longest);
                let view = run.view();
                for load in &state.loads {
                    let limit = self.even_limit(load.max_increment(&view), next.length, run);
                    next.shorten(limit, || IncrementLimiter::Effect(load.effect()));
                }
                for constraint in &state.constraints {
                    let limit = constraint.max_increment(&view.clock);
                    let is_contact = constraint.as_kind::<ContactConstraint>().is_some();
                    let limit = if is_contact { limit } else { self.even_limit(limit, next.length, run) };
                    next.shorten(limit, || IncrementLimiter::Effect(constraint.effect()));
                }
            }
        }
        self.fit_step(&mut next, remaining);
        end_at_rest(&mut next, bodies, SLOW * self.resolution);
        next
    }

    /// Returns the limit by a load or prescribed motion for an increment of at most `length`. If few increments of elements are between
    /// points of amplitudes, they have the same length.
    #[inline]
    fn even_limit(&mut self, limit: IncrementLimit, length: f64, run: &RunState<'_>) -> IncrementLimit {
        if limit.jump || !limit.time.is_finite() || run.state.elements.is_empty() {
            return limit;
        }
        let (now, rest) = (run.now.step_time, limit.time);
        let interval = now - self.last_point + rest;
        if rest <= length {
            (self.last_point, self.last_interval) = (now + rest, interval);
        } else if interval.max(self.last_interval) < FEW * length {
            return IncrementLimit { time: rest / (rest / length).ceil(), ..limit };
        }
        limit
    }

    /// Returns the increment with the limits of stability, and of heat if temperatures are solved for.
    #[inline(never)]
    fn bound_by_stability(&self, mut next: Increment, run: &RunState<'_>) -> Increment {
        if run.state.elements.is_empty() {
            next.bound(self.accurate_increment(run) * self.factor, IncrementLimiter::Accuracy);
        } else {
            next.bound(run.stable_increment() * self.factor, run.stability_limiter());
        }
        if let Some(heat) = run.state.heat() {
            next.bound(heat.stable_increment() * self.factor, IncrementLimiter::Conduction);
            next.shorten(heat.limit(&run.clock()), || IncrementLimiter::Heat);
        }
        next
    }

    /// Returns the increment that resolves the vibration of masses without elements. Central differences change the
    /// highest frequency by the fraction (ω dt)²/24, and dashpots, whose velocity is half an increment old, by c dt/(4 m).
    /// Both are at most `accuracy`.
    fn accurate_increment(&self, run: &RunState<'_>) -> f64 {
        let vibration = (6.0 * self.accuracy).sqrt() * run.stable_increment();
        let damping = 4.0 * self.accuracy / run.state.elements.damping_rate();
        vibration.min(damping).min(self.largest)
    }

    /// Returns the increment from error control: velocity and acceleration may change only by a small fraction. The
    /// previous increment is 0 if central differences of bodies start again. Equation (4.5).
    fn automatic(&mut self, bodies: &[BodyState], previous_dt: f64) -> f64 {
        let grown = GROWTH * self.free;
        self.free = if grown < self.largest { grown } else { self.largest };
        for (body, speed) in bodies.iter().zip(&mut self.speed).filter(|(b, _)| !b.tied) {
            let now = body.speed();
            if now > *speed {
                *speed = now;
            }
            let [acceleration, change] = body.acceleration_and_change();
            let gain = acceleration * self.largest;
            let scale = if gain > *speed { gain } else { *speed };
            let allowed = self.resolution * scale;
            let bound = self.resolution * allowed * previous_dt;
            if body.reads_velocity && acceleration * self.free > allowed {
                let least = allowed / acceleration;
                let drift = acceleration * change * previous_dt * previous_dt * previous_dt;
                let length = coarsened(least, previous_dt, [drift, DRIFT * bound * allowed]);
                if length < self.free {
                    self.free = length;
                }
            }
            if previous_dt > 0.0 && change * self.free * self.free > bound {
                self.free = (bound / change).sqrt();
            }
        }
        self.free
    }

    /// Ends the step at its exact time and avoids a very small last increment, which rounding of many fixed increments
    /// would cause.
    #[inline]
    fn fit_step(&self, next: &mut Increment, remaining: f64) {
        if next.length >= remaining * (1.0 - SLIVER) {
            *next = Increment { length: remaining, end: IncrementEnd::Step, by: IncrementLimiter::Step };
        } else if self.fixed.is_none() && next.end == IncrementEnd::Plain && next.length > 0.5 * remaining {
            (next.length, next.by) = (0.5 * remaining, IncrementLimiter::Step);
        }
    }
}

/// Returns an increment from `least` to [`COARSEST`] times as long. In between, a quantity that grows with the cube of the
/// increment, and has the first value for the previous one, approaches the second value by a step of Halley's method for
/// the cube root: it needs one division.
#[inline]
fn coarsened(least: f64, previous: f64, [value, allowed]: [f64; 2]) -> f64 {
    let approached = previous * ((value + 2.0 * allowed) / (2.0 * value + allowed));
    // Without a previous increment it is not a number, or zero.
    approached.max(least).min(COARSEST * least)
}

/// Ends the increment at the instant at which a body under velocity-dependent loads comes to rest: displacement v^2 /
/// 2|a| after the time v / |a|. An increment that would end just before this instant is halved, so that an increasing
/// force cannot reverse the velocity unnoticed. `slow` applies to bodies with six degrees of freedom.
#[inline]
fn end_at_rest(next: &mut Increment, bodies: &[BodyState], slow: f64) {
    for (b, body) in bodies.iter().enumerate() {
        if !body.reads_velocity || body.prescribed {
            continue;
        }
        let Some(time_to_rest) = body.time_to_rest(next.length, slow) else { continue };
        *next = if time_to_rest <= next.length {
            Increment { length: time_to_rest, end: IncrementEnd::Rest(b), by: IncrementLimiter::Rest }
        } else {
            Increment { length: 0.5 * time_to_rest, end: IncrementEnd::Plain, by: IncrementLimiter::Rest }
        };
    }
}
