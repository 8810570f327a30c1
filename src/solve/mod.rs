//! The time loop: central differences, one increment as a numbered recipe.
//! Never here: deck words, files.

mod energy;
mod increment;
mod observe;

use std::time::Instant as Stopwatch;

use serde::Serialize;

use crate::effect::{Account, Halt, Slot};
use crate::model::LoadVelocity;
use crate::plan::{Plan, StepPlan};
use crate::state::{Bodies, Instant};
pub use energy::Energy;
use increment::{End, Increment, Pace};
use observe::Observing;
pub use observe::Sink;

/// How a run ended and what it cost.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Outcome {
    /// Why it stopped early, if it did.
    #[serde(skip)]
    pub halt: Option<Halt>,
    /// Steps begun.
    pub steps: Vec<StepSummary>,
    /// Energies at the end, and the largest drift of their sum.
    pub energy: Energy,
    /// When bodies came to rest.
    pub rests: Vec<Rest>,
    /// Increments over all steps.
    pub increments: u64,
    /// Seconds in the time loop.
    pub seconds: f64,
    /// Seconds sampled in each effect, by its row of the ledger.
    #[serde(skip)]
    pub effect_seconds: Vec<f64>,
}

/// What a step took.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct StepSummary {
    /// Name.
    pub name: String,
    /// Increments.
    pub increments: u64,
    /// Time reached in the step.
    pub time: f64,
    /// Smallest increment.
    pub smallest_increment: f64,
    /// Largest increment.
    pub largest_increment: f64,
}

/// A body came to rest.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rest {
    /// Name of the body.
    pub body: String,
    /// Total time.
    pub time: f64,
    /// Displacement along z.
    pub displacement: f64,
}

/// One force in how many increments is timed: often enough for a share, too seldom to be felt.
const TIMED_EVERY: u64 = 64;

/// Runs a plan from its start to its end, showing every due instant to `sink`.
pub fn run(plan: &mut Plan, sink: &mut dyn Sink) -> Outcome {
    let begin = Stopwatch::now();
    let mut steps = std::mem::take(&mut plan.steps);
    let mut run = Run::new(plan);
    let mut observing = Observing::new(plan);
    for step in &mut steps {
        if let Err(halt) = run.step(step, &mut observing, sink) {
            run.step_back();
            let written = observing.last(&run, step, sink);
            run.outcome.halt = Some(written.err().unwrap_or(halt));
            break;
        }
    }
    let mut outcome = run.outcome;
    outcome.energy = run.energy;
    outcome.seconds = begin.elapsed().as_secs_f64();
    plan.steps = steps;
    outcome
}

/// Everything an increment touches.
struct Run<'a> {
    plan: &'a Plan,
    bodies: Bodies,
    now: Instant,
    /// Generalised forces of all effects of the step, one slot after the other, and where each effect's slots end.
    forces: Vec<f64>,
    slots: Vec<Slot>,
    ends: Vec<usize>,
    /// Sum of forces on each body, and what a prescribed motion adds.
    total: Vec<f64>,
    reaction: Vec<f64>,
    displacement_before: Vec<f64>,
    velocity_before: Vec<f64>,
    now_before: Instant,
    acceleration_before: Vec<f64>,
    /// Whether a body is under loads that read velocity, and whether under a resistance.
    reads_velocity: Vec<bool>,
    /// Length of the increment behind; 0 where central differences start afresh with the half step.
    behind: f64,
    /// The increment that led here, for the energy balance and for output.
    last_increment: f64,
    increment: u64,
    energy: Energy,
    outcome: Outcome,
}

impl<'a> Run<'a> {
    fn new(plan: &'a Plan) -> Self {
        let mut bodies = Bodies::default();
        for body in &plan.bodies {
            let index = bodies.add(body.mass());
            bodies.velocity[index] = body.initial_velocity;
        }
        let zeros = vec![0.0; bodies.count()];
        let energy = Energy::start(&bodies);
        let outcome = Outcome { effect_seconds: vec![0.0; plan.ledger.effects.len()], ..Outcome::default() };
        Run {
            plan,
            now: Instant::default(),
            forces: Vec::new(),
            slots: Vec::new(),
            ends: Vec::new(),
            total: zeros.clone(),
            reaction: zeros.clone(),
            displacement_before: zeros.clone(),
            velocity_before: zeros.clone(),
            now_before: Instant::default(),
            acceleration_before: zeros,
            reads_velocity: vec![false; bodies.count()],
            bodies,
            behind: 0.0,
            last_increment: 0.0,
            increment: 0,
            energy,
            outcome,
        }
    }

    /// One step. The recipe of an increment, as in ABAQUS Theory Guide 2.4.5 with the half-step start, is the loop's body.
    fn step(&mut self, step: &mut StepPlan, observing: &mut Observing, sink: &mut dyn Sink) -> Result<(), Halt> {
        self.begin(step);
        observing.begin(step, self.increment == 0, self.increment);
        let mut pace = Pace::new(step, &self.bodies);
        loop {
            self.estimate_velocity(step); //          1. velocity at the increment's own time, for the loads
            self.evaluate_forces(step)?; //           2. forces, resistances last
            self.accelerate(step)?; //                3. a = F / m; a resistance holds what is at rest
            self.correct_velocity(step); //           4. velocity at the increment's own time
            self.energy.book(&self.bodies, &self.slots, &self.forces); //5. energy balance
            observing.show(self, step, sink)?; //     6. output that is due
            if self.now.step_time >= step.duration {
                break;
            }
            let next = pace.choose(self, step)?; //   7. length of the next increment
            self.advance(step, next); //              8. v(i+1/2), u(i+1)
            self.record(next.length);
        }
        Ok(())
    }

    fn begin(&mut self, step: &mut StepPlan) {
        self.slots.clear();
        self.ends.clear();
        for force in &step.forces {
            self.slots.extend(force.slots());
            self.ends.push(self.slots.len());
        }
        self.forces = vec![0.0; self.slots.len()];
        self.energy.begin(self.bodies.count(), &self.slots, &step.motions);
        self.reads_velocity.fill(false);
        for force in step.forces.iter().filter(|f| f.reads_velocity()) {
            for slot in force.slots() {
                self.reads_velocity[slot.body] = true;
            }
        }
        for motion in &mut step.motions {
            motion.start = self.bodies.displacement[motion.body];
        }
        self.now.step_time = 0.0;
        self.behind = 0.0;
        let summary = StepSummary { name: step.name.clone(), smallest_increment: f64::INFINITY, ..Default::default() };
        self.outcome.steps.push(summary);
    }

    fn estimate_velocity(&mut self, step: &StepPlan) {
        let reach = match step.load_velocity {
            LoadVelocity::Predicted => 0.5 * self.behind,
            LoadVelocity::Lagged => 0.0,
        };
        let bodies = &mut self.bodies;
        for b in 0..bodies.count() {
            bodies.velocity_load[b] = if self.behind == 0.0 {
                bodies.velocity[b]
            } else {
                bodies.velocity_half[b] + reach * bodies.acceleration[b]
            };
        }
    }

    fn evaluate_forces(&mut self, step: &mut StepPlan) -> Result<(), Halt> {
        for (direction, velocity) in self.bodies.direction.iter_mut().zip(&self.bodies.velocity_load) {
            *direction = sign(*velocity);
        }
        let timed = self.increment.is_multiple_of(TIMED_EVERY);
        let mut start = 0;
        let mut resisted = false;
        for (force, &end) in step.forces.iter_mut().zip(&self.ends) {
            if force.resists() && !resisted {
                resisted = true;
                turn_resting_bodies(&mut self.bodies, &self.slots[..start], &self.forces);
            }
            let clock = timed.then(Stopwatch::now);
            force.evaluate(&self.now, &self.bodies, &mut self.forces[start..end])?;
            start = end;
            if let Some(clock) = clock {
                self.outcome.effect_seconds[force.cause()] += clock.elapsed().as_secs_f64() * TIMED_EVERY as f64;
            }
        }
        Ok(())
    }

    fn accelerate(&mut self, step: &StepPlan) -> Result<(), Halt> {
        self.total.fill(0.0);
        for (slot, force) in self.slots.iter().zip(&self.forces) {
            self.total[slot.body] += force;
        }
        self.acceleration_before.copy_from_slice(&self.bodies.acceleration);
        for b in 0..self.bodies.count() {
            let at_rest = self.bodies.velocity_load[b] == 0.0 && self.bodies.direction[b] != 0.0;
            if at_rest && self.total[b] * self.bodies.direction[b] <= 0.0 {
                self.hold(b);
            }
            self.bodies.acceleration[b] = self.total[b] / self.bodies.mass[b];
        }
        for motion in &step.motions {
            let b = motion.body;
            self.bodies.acceleration[b] = motion.rates(&self.now, self.bodies.velocity[b])[1];
            self.reaction[b] = self.bodies.mass[b] * self.bodies.acceleration[b] - self.total[b];
        }
        match self.bodies.acceleration.iter().position(|a| !a.is_finite()) {
            Some(b) => Err(self.not_finite(b)),
            None => Ok(()),
        }
    }

    /// The resistances on a body at rest give just what the other forces ask of them, and do no work.
    fn hold(&mut self, body: usize) {
        self.total[body] = 0.0;
        for (slot, force) in self.slots.iter().zip(&mut self.forces) {
            if slot.body == body && slot.account != Account::Work {
                *force = 0.0;
            }
        }
    }

    fn not_finite(&self, b: usize) -> Halt {
        let (body, time) = (&self.plan.bodies[b].name, self.now.total_time);
        let reason = format!(
            "the acceleration of rigid body `{body}` is {} at increment {}, time {time:e} (force {}, mass {})",
            self.bodies.acceleration[b], self.increment, self.total[b], self.bodies.mass[b]
        );
        Halt { code: "R203", reason }
    }

    fn correct_velocity(&mut self, step: &StepPlan) {
        if self.behind == 0.0 {
            return;
        }
        let bodies = &mut self.bodies;
        for b in 0..bodies.count() {
            bodies.velocity[b] = bodies.velocity_half[b] + 0.5 * self.behind * bodies.acceleration[b];
        }
        for motion in &step.motions {
            bodies.velocity[motion.body] = motion.rates(&self.now, bodies.velocity[motion.body])[0];
        }
    }

    fn advance(&mut self, step: &StepPlan, next: Increment) {
        let dt = next.length;
        self.displacement_before.copy_from_slice(&self.bodies.displacement);
        self.velocity_before.copy_from_slice(&self.bodies.velocity);
        let bodies = &mut self.bodies;
        for b in 0..bodies.count() {
            bodies.velocity_half[b] = bodies.velocity[b] + 0.5 * dt * bodies.acceleration[b];
        }
        for motion in &step.motions {
            let b = motion.body;
            bodies.velocity_half[b] = motion.velocity_over(&self.now, dt, bodies.displacement[b], bodies.velocity[b]);
        }
        for b in 0..bodies.count() {
            bodies.displacement[b] += dt * bodies.velocity_half[b];
        }
        self.now_before = self.now;
        self.now = next.arrival(&self.now, step.duration);
        self.last_increment = dt;
        self.increment += 1;
        self.behind = dt;
        if next.end != End::Plain {
            self.start_afresh(step, next.end);
        }
        self.energy.moved(&self.bodies, &self.displacement_before, self.behind == 0.0);
    }

    /// After an instant of rest or a jump of a force the next increment starts as the first did, from the velocity at
    /// its own time.
    fn start_afresh(&mut self, step: &StepPlan, end: End) {
        let bodies = &mut self.bodies;
        for b in 0..bodies.count() {
            bodies.velocity[b] = bodies.velocity_half[b] + 0.5 * self.behind * bodies.acceleration[b];
        }
        for motion in &step.motions {
            bodies.velocity[motion.body] = motion.rates(&self.now, bodies.velocity[motion.body])[0];
        }
        if let End::Rest(b) = end {
            bodies.velocity[b] = 0.0;
            let (body, displacement) = (self.plan.bodies[b].name.clone(), bodies.displacement[b]);
            self.outcome.rests.push(Rest { body, time: self.now.total_time, displacement });
        }
        self.behind = 0.0;
    }

    /// After a failure: the state of the last instant that was complete.
    fn step_back(&mut self) {
        if self.increment > 0 {
            self.bodies.displacement.copy_from_slice(&self.displacement_before);
            self.bodies.velocity.copy_from_slice(&self.velocity_before);
            self.bodies.acceleration.copy_from_slice(&self.acceleration_before);
            self.now = self.now_before;
        }
    }

    fn record(&mut self, length: f64) {
        self.outcome.increments = self.increment;
        if let Some(summary) = self.outcome.steps.last_mut() {
            summary.increments += 1;
            summary.time = self.now.step_time;
            summary.smallest_increment = summary.smallest_increment.min(length);
            summary.largest_increment = summary.largest_increment.max(length);
        }
    }
}

/// A body at rest would start the way the other forces push it: that is what a resistance then opposes.
fn turn_resting_bodies(bodies: &mut Bodies, applied: &[Slot], forces: &[f64]) {
    for b in 0..bodies.count() {
        if bodies.direction[b] == 0.0 {
            let on = applied.iter().zip(forces).filter(|(s, _)| s.body == b);
            bodies.direction[b] = sign(on.map(|(_, f)| f).sum());
        }
    }
}

fn sign(value: f64) -> f64 {
    if value > 0.0 {
        1.0
    } else if value < 0.0 {
        -1.0
    } else {
        0.0
    }
}
