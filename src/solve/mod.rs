//! The time loop: central differences, one increment as a numbered recipe.
//! Never here: deck words, files.

mod digest;
mod energy;
mod guard;
mod increment;
mod observe;
mod restart;
mod routines;

use std::time::Instant as Stopwatch;

use serde::Serialize;

use crate::element::body::Solid;
use crate::element::volume_guard::STARTING;
use crate::load::Account;
use crate::load::Asking;
use crate::load::Slot;
use crate::model::{IncrementControl, LoadVelocity};
use crate::plan::{Plan, StepPlan};
use crate::state::halt::Halt;
use crate::state::{Before, BodyState, Instant, direction};
use crate::user::Wish;
use energy::Balance;
pub use energy::Energy;
use increment::{End, Increment, Pace};
use observe::Observing;
pub use observe::{Sink, element_value};
use restart::{At, Keeping};
pub use restart::{Control, Every};

/// How a run ended and what it cost.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Outcome {
    /// Why it stopped early, if it did.
    #[serde(skip)]
    pub halt: Option<Halt>,
    /// Whether a user's routine ended it before its last step was over.
    pub ended_by_user: bool,
    /// Steps begun.
    pub steps: Vec<StepSummary>,
    /// Energies at the end, and the largest drift of their sum.
    pub energy: Energy,
    /// When bodies came to rest.
    pub rests: Vec<Rest>,
    /// What the run warns of.
    pub warnings: Vec<String>,
    /// Increments over all steps.
    pub increments: u64,
    /// Seconds in the time loop.
    pub seconds: f64,
    /// Of these, seconds that keeping the state took.
    pub checkpoint_seconds: f64,
    /// SHA-256 over the bits of the state at the end, hexadecimal: the same on any machine, number of threads and
    /// instruction set.
    pub digest: String,
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
    /// Element that limited the smallest increment, if one did.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limiting_element: Option<String>,
    /// How often the highest frequency of the whole was estimated; absent where increments go element by element.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub global_estimates: Option<u64>,
    /// Mass that mass scaling has added to the original one, as it was found last; absent without mass scaling.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub added_mass: Option<f64>,
}

/// A body came to rest.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
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
    // Without a state to go on from there is none that could be refused.
    run_with(plan, sink, Control::default()).unwrap_or_default()
}

/// The same, keeping the state now and then, from the start or from a state that was kept.
///
/// # Errors
/// Why a state is not one of this plan. The plan must then not be run.
pub fn run_with(plan: &mut Plan, sink: &mut dyn Sink, control: Control<'_>) -> Result<Outcome, String> {
    let begin = Stopwatch::now();
    let mut steps = std::mem::take(&mut plan.steps);
    let asking = std::mem::take(&mut plan.asking);
    let solid = plan.solid.take();
    let mut run = Run::new(plan, steps.len(), asking, solid);
    let mut observing = Observing::new(plan);
    let (mut first, mut pace) = (0, None);
    if let Some(state) = control.state {
        let (index, taken_up) = run.take_up(&mut steps, &mut observing, state)?;
        (first, pace) = (index, Some(taken_up));
    }
    let mut keeping = Keeping::new(control, run.solid.is_some() && sink.wants_frames() && !plan.asks_user);
    for step in steps.iter_mut().skip(first) {
        if let Err(halt) = run.step(step, pace.take(), &mut observing, &mut keeping, sink) {
            run.step_back();
            let written = observing.last(&run, step, sink);
            run.outcome.halt = Some(written.err().unwrap_or(halt));
            break;
        }
        if run.wish == Wish::EndAnalysis {
            run.outcome.ended_by_user = true;
            break;
        }
    }
    run.outcome.digest = run.digest();
    let Run { mut outcome, balance, asking, solid, .. } = run;
    outcome.energy = balance.energy();
    outcome.seconds = begin.elapsed().as_secs_f64();
    plan.steps = steps;
    plan.asking = asking;
    plan.solid = solid;
    Ok(outcome)
}

/// Everything an increment touches. Aligned, so that what it costs does not depend on where the stack begins.
#[repr(align(64))]
struct Run<'a> {
    plan: &'a Plan,
    /// How many steps there are.
    steps: usize,
    bodies: Vec<BodyState>,
    now: Instant,
    /// Generalised forces of all effects of the step, one slot after the other, and where each effect's slots end.
    forces: Vec<f64>,
    slots: Vec<Slot>,
    /// Indices of the slots in order of their bodies.
    slots_by_body: Vec<usize>,
    ends: Vec<usize>,
    /// Index of the first force that resists; such forces come last.
    resistances: usize,
    /// The first slots are those of tied nodes.
    ties: usize,
    now_before: Instant,
    /// Part of the increment behind over which loads see the velocity carried on: half of it, or none.
    reach: f64,
    /// Length of the increment behind; 0 where central differences start afresh with the half step.
    behind: f64,
    /// The increment that led here, for the energy balance and for output.
    last_increment: f64,
    /// Whether the instant is complete: forces, motion and energies belong to it.
    complete: bool,
    /// What the user's routines are asked once an increment, in every step.
    asking: Vec<Box<dyn Asking>>,
    /// What deforms.
    solid: Option<Solid>,
    /// What the user's routines want.
    wish: Wish,
    /// Whether they know already that the increment is complete.
    told: bool,
    /// Group and element that limited the smallest increment of the step.
    limiting: Option<(usize, usize)>,
    balance: Balance,
    /// Which limits on energies have been told in this step.
    warned: [bool; 2],
    outcome: Outcome,
}

impl<'a> Run<'a> {
    fn new(plan: &'a Plan, steps: usize, asking: Vec<Box<dyn Asking>>, solid: Option<Solid>) -> Self {
        let bodies: Vec<_> = plan.bodies.iter().map(|b| BodyState::new(b.mass(), b.initial_velocity)).collect();
        let balance = Balance::start(&bodies);
        let outcome = Outcome { effect_seconds: vec![0.0; plan.ledger.effects.len()], ..Outcome::default() };
        Run {
            plan,
            steps,
            now: Instant::default(),
            forces: Vec::new(),
            slots: Vec::new(),
            slots_by_body: Vec::new(),
            ends: Vec::new(),
            resistances: 0,
            ties: 0,
            now_before: Instant::default(),
            bodies,
            reach: 0.0,
            behind: 0.0,
            last_increment: 0.0,
            complete: false,
            asking,
            solid,
            wish: Wish::Continue,
            told: false,
            limiting: None,
            warned: [false; 2],
            balance,
            outcome,
        }
    }

    /// One step, from its beginning or from the pace at which a state was taken up. The recipe of an increment, as in ABAQUS
    /// Theory Guide 2.4.5 with the half-step start, is what [`Run::arrive`] and [`Run::go`] do in turn.
    fn step(
        &mut self,
        step: &mut StepPlan,
        taken_up: Option<Pace>,
        observing: &mut Observing,
        keeping: &mut Keeping<'_>,
        sink: &mut dyn Sink,
    ) -> Result<(), Halt> {
        let goes_on = taken_up.is_some();
        let mut pace = taken_up.unwrap_or_else(|| self.begin_step(step, observing));
        keeping.begin(step, &self.now);
        let end = self.increments(step, &mut pace, goes_on, observing, keeping, sink);
        if end.is_err() {
            keeping.way_back(&mut At { run: self, step, observing, pace: &mut pace });
        }
        self.name_limiting_element();
        end
    }

    fn begin_step(&mut self, step: &mut StepPlan, observing: &mut Observing) -> Pace {
        self.begin(step);
        observing.begin(step, self.now.increment == 0, self.now.increment);
        Pace::new(step, &self.bodies)
    }

    fn increments(
        &mut self,
        step: &mut StepPlan,
        pace: &mut Pace,
        goes_on: bool,
        observing: &mut Observing,
        keeping: &mut Keeping<'_>,
        sink: &mut dyn Sink,
    ) -> Result<(), Halt> {
        if goes_on {
            self.resume_routines()?;
            self.go(step, pace)?;
        } else {
            self.begin_routines(step)?;
        }
        loop {
            self.arrive(step, observing, sink)?;
            if self.is_over(step) {
                return self.end_routines();
            }
            keeping.look(&mut At { run: self, step, observing, pace }, sink)?;
            self.go(step, pace)?;
        }
    }

    /// What an instant is made of.
    #[inline]
    fn arrive(&mut self, step: &mut StepPlan, observing: &mut Observing, sink: &mut dyn Sink) -> Result<(), Halt> {
        self.evaluate_forces(step)?; //           1. forces, resistances last
        self.accelerate(step)?; //                2. a = F / m; a resistance holds what is at rest
        self.correct_velocity(step); //           3. velocity at the increment's own time
        self.book(); //                           4. energy balance
        self.guard_energy(step)?;
        observing.show(self, step, sink) //       5. output that is due
    }

    /// From one instant to the next.
    #[inline]
    fn go(&mut self, step: &mut StepPlan, pace: &mut Pace) -> Result<(), Halt> {
        self.guard_increment(step)?;
        let next = pace.choose(self, step); //    6. length of the next increment
        next.check(&self.now, self.now.increment)?;
        self.ask_routines(step, next)?;
        self.advance(step, next); //              7. v(i+1/2), u(i+1), and the velocity that loads will see
        self.record(next.length);
        Ok(())
    }

    fn name_limiting_element(&mut self) {
        if let (Some(solid), Some(summary)) = (&self.solid, self.outcome.steps.last_mut()) {
            summary.global_estimates = solid.estimates();
        }
        if let (Some(solid), Some((group, element)), Some(summary)) =
            (&self.solid, self.limiting.take(), self.outcome.steps.last_mut())
        {
            summary.limiting_element = Some(solid.element_names[group][element].clone());
        }
    }

    /// Whether the step is at its end, or a user's routine wants it to be.
    fn is_over(&self, step: &StepPlan) -> bool {
        self.now.step_time >= step.duration || self.wish != Wish::Continue
    }

    fn begin(&mut self, step: &mut StepPlan) {
        self.slots.clear();
        self.ends.clear();
        if let Some(solid) = &mut self.solid {
            self.slots.extend(solid.ties.iter().map(|t| Slot { body: t.body, account: Account::Tie }));
            if self.now.increment == 0 {
                solid.follow(&self.bodies, |body| body.velocity);
            }
        }
        self.ties = self.slots.len();
        for force in &step.forces {
            self.slots.extend(force.slots());
            self.ends.push(self.slots.len());
        }
        self.resistances = step.forces.iter().filter(|f| !f.resists()).count();
        self.forces = vec![0.0; self.slots.len()];
        self.balance.begin(&self.slots, &step.motions);
        self.slots_by_body = (0..self.slots.len()).collect();
        self.slots_by_body.sort_by_key(|&i| self.slots[i].body);
        for (b, body) in self.bodies.iter_mut().enumerate() {
            (body.reads_velocity, body.prescribed) = (false, false);
            body.tied = self.slots[..self.ties].iter().any(|s| s.body == b);
            body.slots = self.slots.iter().filter(|s| s.body == b).count();
        }
        for slot in step.forces.iter().filter(|f| f.reads_velocity()).flat_map(|f| f.slots()) {
            self.bodies[slot.body].reads_velocity = true;
        }
        for motion in &mut step.motions {
            let body = &mut self.bodies[motion.body];
            body.prescribed = true;
            motion.start = body.displacement;
        }
        self.reach = match step.load_velocity {
            LoadVelocity::Predicted => 0.5,
            LoadVelocity::Lagged => 0.0,
        };
        if let Some(solid) = &mut self.solid {
            solid.walls.clone_from(&step.walls);
            solid.equations.clone_from(&step.equations);
            solid.begin(&step.given, step.node_forces.len());
            let global = matches!(step.control, IncrementControl::Automatic { element_by_element: false, .. });
            solid.begin_frequency(global, &step.given);
        }
        self.warned = [false; 2];
        self.now.step_time = 0.0;
        self.now.lost = 0.0;
        self.now.step += 1;
        if self.ties == 0 {
            self.behind = 0.0;
            self.show_own_velocity();
        }
        let summary = StepSummary { name: step.name.clone(), smallest_increment: f64::INFINITY, ..Default::default() };
        self.outcome.steps.push(summary);
    }

    fn evaluate_forces(&mut self, step: &mut StepPlan) -> Result<(), Halt> {
        let timed = self.now.increment.is_multiple_of(TIMED_EVERY);
        self.evaluate_solid(step, timed)?;
        let mut start = self.ties;
        for (i, (force, &end)) in step.forces.iter_mut().zip(&self.ends).enumerate() {
            if i == self.resistances {
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

    fn evaluate_solid(&mut self, step: &mut StepPlan, timed: bool) -> Result<(), Halt> {
        let Some(solid) = &mut self.solid else { return Ok(()) };
        let clock = timed.then(Stopwatch::now);
        if let Some(scaling) = &mut step.scaling {
            let scaled = solid.scale_masses(scaling, &self.now, &mut step.node_forces);
            if let Some(summary) = self.outcome.steps.last_mut().filter(|_| scaled) {
                summary.added_mass = solid.added_mass();
            }
        }
        solid.evaluate(&self.now, &mut step.node_forces)?;
        solid.tie_forces(&mut self.forces);
        if let Some(clock) = clock {
            self.outcome.effect_seconds[solid.cause] += clock.elapsed().as_secs_f64() * TIMED_EVERY as f64;
        }
        Ok(())
    }

    fn accelerate(&mut self, step: &StepPlan) -> Result<(), Halt> {
        let mut finite = true;
        let mut start = 0;
        for b in 0..self.bodies.len() {
            let body = &mut self.bodies[b];
            let own = &self.slots_by_body[start..start + body.slots];
            start += body.slots;
            body.force = own.iter().fold(0.0, |sum, &slot| sum + self.forces[slot]);
            if body.velocity_load == 0.0 && body.direction != 0.0 && body.force * body.direction <= 0.0 {
                self.hold(b);
            }
            let body = &mut self.bodies[b];
            body.before.acceleration = body.acceleration;
            body.acceleration = body.force * body.inverse_mass;
            finite &= body.acceleration.abs() < f64::INFINITY || body.prescribed;
        }
        for motion in &step.motions {
            let body = &mut self.bodies[motion.body];
            body.acceleration = motion.rates(&self.now, body.velocity)[1];
            body.reaction = body.mass * body.acceleration - body.force;
            finite &= body.acceleration.is_finite();
        }
        if let Some(solid) = &mut self.solid {
            solid.accelerate(&step.given);
            solid.accelerate_ties(&self.bodies);
            // An increment that the deck fixes follows nothing.
            if self.now.increment < STARTING && matches!(step.control, IncrementControl::Automatic { .. }) {
                solid.guard_start();
            }
            for wall in &solid.walls {
                self.bodies[wall.body].reaction -= wall.force;
            }
        }
        if finite { Ok(()) } else { Err(self.not_finite()) }
    }

    fn book(&mut self) {
        self.balance.book(&self.bodies, &self.forces, self.behind == 0.0);
        if let Some(solid) = &self.solid {
            self.balance.book_solid(&solid.energies);
        }
        self.complete = true;
    }

    /// The resistances on a body at rest give just what the other forces ask of them, and do no work.
    fn hold(&mut self, body: usize) {
        self.bodies[body].force = 0.0;
        for (slot, force) in self.slots.iter().zip(&mut self.forces) {
            if slot.body == body && matches!(slot.account, Account::Friction | Account::Cavity) {
                *force = 0.0;
            }
        }
    }

    fn not_finite(&self) -> Halt {
        let b = self.bodies.iter().position(|b| !b.acceleration.is_finite()).unwrap_or_default();
        let (name, time, body) = (&self.plan.bodies[b].name, self.now.total_time, &self.bodies[b]);
        let reason = format!(
            "the acceleration of rigid body `{name}` is {} at increment {}, time {time:e} (force {}, mass {})",
            body.acceleration, self.now.increment, body.force, body.mass
        );
        Halt { code: "R203", reason }
    }

    fn correct_velocity(&mut self, step: &StepPlan) {
        if self.behind == 0.0 {
            return;
        }
        self.velocity_from_half();
        self.prescribe_velocity(step);
    }

    fn velocity_from_half(&mut self) {
        let half = 0.5 * self.behind;
        for body in &mut self.bodies {
            body.velocity = body.velocity_half + half * body.acceleration;
        }
    }

    #[inline]
    fn prescribe_velocity(&mut self, step: &StepPlan) {
        for motion in &step.motions {
            let body = &mut self.bodies[motion.body];
            body.velocity = motion.rates(&self.now, body.velocity)[0];
        }
    }

    fn advance(&mut self, step: &StepPlan, next: Increment) {
        let dt = next.length;
        for body in &mut self.bodies {
            body.before.displacement = body.displacement;
            body.before.velocity = body.velocity;
            body.velocity_half = body.velocity + 0.5 * dt * body.acceleration;
            body.displacement += dt * body.velocity_half;
            body.show(body.velocity_half + self.reach * dt * body.acceleration);
        }
        for motion in &step.motions {
            let body = &mut self.bodies[motion.body];
            let start = body.before.displacement;
            body.velocity_half = motion.velocity_over(&self.now, dt, start, body.velocity);
            body.displacement = start + dt * body.velocity_half;
            body.show(body.velocity_half + self.reach * dt * body.acceleration);
        }
        if let Some(solid) = &mut self.solid {
            solid.advance(&step.given, &self.now, dt);
            solid.follow(&self.bodies, |body| body.velocity_half);
            solid.meet_walls(&self.bodies, dt);
        }
        self.complete = false;
        self.now_before = self.now;
        self.now = next.arrival(&self.now, step.duration);
        self.last_increment = dt;
        self.behind = dt;
        // Central differences of what is tied go on from step to step, as those of its nodes do.
        if next.end != End::Plain && !(next.end == End::Step && self.ties > 0) {
            self.start_afresh(step, next.end);
        }
    }

    /// After an instant of rest or a jump of a force the next increment starts as the first did, from the velocity at
    /// its own time.
    fn start_afresh(&mut self, step: &StepPlan, end: End) {
        self.velocity_from_half();
        self.prescribe_velocity(step);
        if let End::Rest(b) = end {
            self.bodies[b].velocity = 0.0;
            let (body, displacement) = (self.plan.bodies[b].name.clone(), self.bodies[b].displacement);
            self.outcome.rests.push(Rest { body, time: self.now.total_time, displacement });
        }
        self.behind = 0.0;
        self.show_own_velocity();
    }

    /// Where central differences start, loads see the velocity itself.
    fn show_own_velocity(&mut self) {
        for body in &mut self.bodies {
            body.show(body.velocity);
        }
    }

    /// After a failure: the state of the last instant that was complete.
    fn step_back(&mut self) {
        if self.now.increment == 0 || self.complete {
            return;
        }
        for body in &mut self.bodies {
            let Before { displacement, velocity, acceleration } = body.before;
            (body.displacement, body.velocity, body.acceleration) = (displacement, velocity, acceleration);
        }
        self.now = self.now_before;
    }

    fn record(&mut self, length: f64) {
        self.outcome.increments = self.now.increment;
        if let Some(summary) = self.outcome.steps.last_mut() {
            summary.increments += 1;
            summary.time = self.now.step_time;
            if length < summary.smallest_increment {
                summary.smallest_increment = length;
                self.limiting = self.solid.as_ref().map(Solid::limiting);
            }
            summary.largest_increment = summary.largest_increment.max(length);
        }
    }
}

/// A body at rest would start the way the other forces push it: that is what a resistance then opposes.
fn turn_resting_bodies(bodies: &mut [BodyState], applied: &[Slot], forces: &[f64]) {
    for (b, body) in bodies.iter_mut().enumerate().filter(|(_, body)| body.direction == 0.0) {
        let on = applied.iter().zip(forces).filter(|(s, _)| s.body == b);
        body.direction = direction(on.map(|(_, f)| f).sum());
    }
}
