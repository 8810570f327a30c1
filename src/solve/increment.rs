//! The length of the next increment, and what it ends in.
//! Never here: forces, the motion itself.

use super::limits::Limiter;
use crate::constraint::Constraint;
use crate::element::elements::Elements;
use crate::heat::field::Heat;
use crate::load::{Load, SceneView};
use crate::model::IncrementControl;
use crate::plan::StepPlan;
use crate::state::archive::persist_struct;
use crate::state::halt::Halt;
use crate::state::limit::Limit;
use crate::state::{BodyState, Instant};

/// What an increment ends in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Nothing special.
    Plain,
    /// The end of the step.
    Step,
    /// A force jumps there.
    Jump,
    /// This body comes to rest there.
    Rest(usize),
}

/// The next increment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Increment {
    /// Length, time.
    pub length: f64,
    /// What it ends in.
    pub end: End,
    /// What it is no longer for.
    pub by: Limiter,
}

impl Increment {
    /// The instant it arrives at; the end of the step is met to the last bit.
    pub fn arrival(&self, now: &Instant, duration: f64) -> Instant {
        let added = self.length - now.lost;
        let sum = now.step_time + added;
        let lost = (sum - now.step_time) - added;
        let step_time = if self.end == End::Step { duration } else { sum };
        let total_time = now.total_time + (step_time - now.step_time);
        Instant { step_time, total_time, increment: now.increment + 1, lost, ..*now }
    }

    /// Whether it still advances the clock.
    ///
    /// # Errors
    /// If it is lost in rounding.
    pub fn check(&self, now: &Instant, increment: u64) -> Result<(), Halt> {
        if now.total_time + self.length > now.total_time {
            return Ok(());
        }
        let reason = format!(
            "the next increment, {:e}, no longer advances the clock at time {:e} (increment {increment})",
            self.length, now.total_time
        );
        Err(Halt { code: "R204", reason })
    }

    fn shorten(&mut self, limit: Limit, by: Limiter) {
        if limit.time < self.length {
            *self = Increment { length: limit.time, end: if limit.jump { End::Jump } else { End::Plain }, by };
        }
    }

    fn bound(&mut self, length: f64, by: Limiter) {
        if length < self.length {
            (self.length, self.by) = (length, by);
        }
    }
}

/// First automatic increment as a fraction of the largest allowed: nothing is known of the forces yet.
const FIRST: f64 = 0.01;
/// The most by which an increment may exceed the one before.
const GROWTH: f64 = 2.0;
/// Change of velocity over an increment, in units of sqrt(accuracy) of the scene's velocity. Central differences are of
/// second order, so the error follows the accuracy itself; the factor keeps it and the energy drift below it.
const RESOLUTION: f64 = 0.25;
/// The most by which the stiffness of loads shortens the increment of elements: what is beyond it is taken for a jump.
const STIFFEST: f64 = 100.0;
/// Part of the largest speed below which a body in space that is resisted is at rest, in units of the resolution.
const SLOW: f64 = 0.1;
/// The last increment of a step may be longer by this fraction.
const SLIVER: f64 = 1e-3;

/// What the length of an increment follows from.
pub struct Scene<'a> {
    /// What loads see.
    pub view: SceneView<'a>,
    /// Elements.
    pub elements: &'a Elements,
    /// Temperatures of nodes, where they are solved for.
    pub heat: Option<&'a Heat>,
    /// Loads of the step.
    pub loads: &'a [Box<dyn Load>],
    /// Constraints of the step.
    pub constraints: &'a [Box<dyn Constraint>],
    /// Length of the previous increment; 0 where central differences of bodies start afresh.
    pub previous_dt: f64,
    /// Time until the end of the step.
    pub remaining: f64,
}

impl Scene<'_> {
    fn bodies(&self) -> &[BodyState] {
        &self.view.dofs.bodies
    }

    /// What elements bear, and with them loads that were found to be stiff: the square of the highest frequency of both is at
    /// most the sum of the squares of each.
    fn stable_increment(&self) -> f64 {
        let alone = self.elements.stable_increment();
        let added: f64 = self.loads.iter().filter_map(|load| load.stiffness()).map(|s| s.squared).sum();
        if added > 0.0 { alone / shortened(added, alone) } else { alone }
    }
}

/// By how much the stiffness of loads, as the square of a frequency, shortens an increment: 2/omega becomes
/// 2/(omega^2 + added)^(1/2).
pub fn shortened(added: f64, increment: f64) -> f64 {
    (1.0 + 0.25 * added * increment * increment).sqrt().min(STIFFEST)
}

/// Chooses increments over a step.
#[derive(Debug)]
pub struct IncrementController {
    fixed: Option<f64>,
    factor: f64,
    /// The longest increment that the deck allows.
    most: f64,
    resolution: f64,
    largest: f64,
    free: f64,
    /// Largest speed of each body so far.
    speed: Vec<f64>,
}

impl IncrementController {
    /// The pace of a step.
    pub fn new(step: &StepPlan, bodies: &[BodyState]) -> Self {
        let (fixed, accuracy, most) = match step.control {
            IncrementControl::Fixed(length) => (Some(length), 1.0, f64::INFINITY),
            IncrementControl::Automatic { accuracy, largest, .. } => (None, accuracy, largest),
        };
        let largest = accuracy.sqrt() * step.duration;
        IncrementController {
            fixed,
            factor: step.scale_factor,
            most,
            resolution: RESOLUTION * accuracy.sqrt(),
            largest,
            free: FIRST * largest / GROWTH,
            speed: bodies.iter().map(BodyState::speed).collect(),
        }
    }

    /// The pace of a step that changes nothing after this one.
    pub fn continue_in(&mut self, step: &StepPlan, bodies: &[BodyState]) {
        let (free, speed) = (self.free, std::mem::take(&mut self.speed));
        *self = IncrementController { free, speed, ..IncrementController::new(step, bodies) };
    }

    /// The next increment.
    #[inline]
    pub fn choose(&mut self, scene: &Scene<'_>) -> Increment {
        let mut next = Increment { length: f64::INFINITY, end: End::Plain, by: Limiter::Given };
        match self.fixed {
            Some(length) => next.length = length,
            None => {
                if scene.bodies().iter().any(|b| !b.tied) {
                    next.bound(self.automatic(scene) * self.factor, Limiter::Accuracy);
                }
                if !scene.elements.is_empty() {
                    next.bound(scene.stable_increment() * self.factor, Limiter::Elements);
                }
                if let Some(heat) = scene.heat {
                    next.bound(heat.stable_increment() * self.factor, Limiter::Conduction);
                    next.shorten(heat.limit(&scene.view.clock), Limiter::Heat);
                }
                next.bound(self.most, Limiter::Longest);
                let loads = scene.loads.iter();
                loads.for_each(|load| next.shorten(load.max_increment(&scene.view), Limiter::Effect(load.effect())));
                let constraints = scene.constraints.iter();
                constraints.for_each(|c| next.shorten(c.max_increment(&scene.view.clock), Limiter::Effect(c.effect())));
            }
        }
        self.fit_step(&mut next, scene.remaining);
        meet_rest(&mut next, scene.bodies(), SLOW * self.resolution);
        next
    }

    /// From the error estimate: neither velocity nor acceleration may change much over an increment.
    fn automatic(&mut self, scene: &Scene<'_>) -> f64 {
        self.free = (GROWTH * self.free).min(self.largest);
        for (body, speed) in scene.bodies().iter().zip(&mut self.speed).filter(|(b, _)| !b.tied) {
            *speed = speed.max(body.speed());
            let [acceleration, change] = body.acceleration_and_change();
            let scale = speed.max(acceleration * self.largest);
            if body.reads_velocity && acceleration * self.free > self.resolution * scale {
                self.free = self.resolution * scale / acceleration;
            }
            let bound = self.resolution * self.resolution * scale * scene.previous_dt;
            if scene.previous_dt > 0.0 && change * self.free * self.free > bound {
                self.free = (bound / change).sqrt();
            }
        }
        self.free
    }

    /// Ends the step on time, without a sliver before it: the sum of many fixed increments misses the end by rounding.
    #[inline]
    fn fit_step(&self, next: &mut Increment, remaining: f64) {
        if next.length >= remaining * (1.0 - SLIVER) {
            *next = Increment { length: remaining, end: End::Step, by: Limiter::Step };
        } else if self.fixed.is_none() && next.end == End::Plain && next.length > 0.5 * remaining {
            (next.length, next.by) = (0.5 * remaining, Limiter::Step);
        }
    }
}

/// A body under loads that read its velocity meets rest exactly: x + v^2 / 2|a| after the time v / |a|. An increment
/// that would end just short of rest stops half way, so that a growing force cannot turn the velocity unnoticed. `slow` is for
/// bodies in space.
#[inline]
fn meet_rest(next: &mut Increment, bodies: &[BodyState], slow: f64) {
    for (b, body) in bodies.iter().enumerate() {
        if !body.reads_velocity || body.prescribed {
            continue;
        }
        let Some(rest) = body.time_to_rest(next.length, slow) else { continue };
        *next = if rest <= next.length {
            Increment { length: rest, end: End::Rest(b), by: Limiter::Rest }
        } else {
            Increment { length: 0.5 * rest, end: End::Plain, by: Limiter::Rest }
        };
    }
}

persist_struct!(IncrementController { free, speed: fixed } derived { fixed, factor, most, resolution, largest });
