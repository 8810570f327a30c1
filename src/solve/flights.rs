//! Rigid bodies with six degrees of freedom over an increment: forces, central differences of the centre of mass and of the angular
//! momentum, with the exact free motion of a symmetric top between their kicks (Strang splitting, second order), work, rest.
//! Never here: which forces act, the length of an increment.

use super::outcome::{FlightSummary, Rest};
use super::run::Run;
use crate::kernel::attitude::{Vector, norm, plus, times};
use crate::load::How;
use crate::state::flight::{ACCOUNTS, Flight, Motion, Place, Wrench};
use crate::state::halt::Halt;
use crate::state::magnitude::Clock;

/// Speed at which a resistance on what lies still is asked, as a part of the fastest there was: which way it would move is what
/// matters.
const ASKING: f64 = 1e-9;

impl Run<'_> {
    /// Forces on them, resistances last; velocities at the instant's own time; and work.
    ///
    /// # Errors
    /// Where a force fails or is not finite.
    #[inline(never)]
    pub(super) fn evaluate_flights(&mut self) -> Result<(), Halt> {
        let mut flights = std::mem::take(&mut self.dofs.flights);
        let result = self.push_flights(&mut flights);
        flights.iter_mut().for_each(|flight| flight.complete(self.behind));
        self.dofs.flights = flights;
        result?;
        let lost = |f: &Flight| !(norm(f.total.force) + norm(f.total.moment)).is_finite();
        match self.dofs.flights.iter().find(|f| lost(f)) {
            None => Ok(()),
            Some(flight) => Err(self.flight_not_finite(flight)),
        }
    }

    fn push_flights(&mut self, flights: &mut [Flight]) -> Result<(), Halt> {
        let clock = Clock { now: self.now, told: &self.told };
        flights.iter_mut().for_each(|flight| flight.forces = Default::default());
        let (applied, resistances) = self.loads.split_at_mut(self.resistances);
        for load in applied {
            load.on_flights(&clock, flights)?;
        }
        flights.iter_mut().filter(|f| f.rests).for_each(ask);
        for load in resistances {
            let started = self.timing.start();
            load.on_flights(&clock, flights)?;
            self.timing.stop(started, load.id());
        }
        flights.iter_mut().filter(|f| f.rests).for_each(hold_or_go);
        Ok(())
    }

    #[cold]
    fn flight_not_finite(&self, flight: &Flight) -> Halt {
        let (name, time) = (&self.plan.bodies[flight.body].name, self.now.total_time);
        let reason = format!(
            "the acceleration of rigid body `{name}` is not finite at increment {}, time {time:e} (force {:?}, moment {:?})",
            self.now.increment, flight.total.force, flight.total.moment
        );
        Halt { code: "R203", reason }
    }

    /// Carries them over an increment.
    pub(super) fn advance_flights(&mut self, dt: f64) {
        let reach = self.reach * dt;
        self.dofs.flights.iter_mut().for_each(|flight| flight.advance(dt, reach));
    }

    /// The next increment starts as the first did; one of them may have come to rest.
    pub(super) fn restart_flights(&mut self, rest: Option<usize>) {
        for flight in &mut self.dofs.flights {
            flight.complete(self.behind);
        }
        let Some(flight) = rest.map(|index| &mut self.dofs.flights[index]) else { return };
        (flight.velocity, flight.momentum, flight.rests) = ([0.0; 3], [0.0; 3], true);
        let body = &self.plan.bodies[flight.body];
        let start = self.plan.mesh.points[body.reference];
        let displacement = flight.place(start, 0.0)[1] - start[1];
        self.outcome.rests.push(Rest { body: body.name.clone(), time: self.now.total_time, displacement });
    }

    /// At the end: what has become of them.
    pub(super) fn tell_flights(&mut self) {
        for end in self.loads.iter().flat_map(|load| load.ends(&self.dofs)) {
            let flight = &self.dofs.flights[end.flight];
            let (body, speed) = (self.plan.bodies[flight.body].name.clone(), norm(flight.velocity));
            let exit = format!(
                "at time {:.4e}; residual speed {speed:.4e}, obliquity {:.2} deg, yaw {:.2} deg",
                end.time.unwrap_or_default(),
                end.obliquity.to_degrees(),
                flight.yaw().to_degrees()
            );
            match end.how {
                How::Moving => {
                    self.outcome.still_moving += 1;
                    self.outcome.unfinished.push(format!(
                        "{body} still moves in the target, speed {speed:.4e}: a depth read now is not its last"
                    ));
                }
                How::Through => {
                    self.outcome.unfinished.push(format!("{body} has left the target through its back {exit}"));
                }
                How::Ricochet => self
                    .outcome
                    .unfinished
                    .push(format!("{body} has ricocheted: it left the target through its front {exit}")),
                How::AtRest | How::NotMet => {}
            }
            self.outcome.flights.push(FlightSummary {
                body,
                end: end.how.words(),
                exit_time: end.time,
                velocity: flight.velocity,
                rotational_velocity: flight.motion().turning,
                speed,
                obliquity: end.obliquity.to_degrees(),
                yaw: flight.yaw().to_degrees(),
                tilt: flight.tilt().to_degrees(),
            });
        }
    }
}

/// What lies still would move as the other forces push it: that is what a resistance then opposes.
fn ask(flight: &mut Flight) {
    let applied = flight.forces[0];
    let turning = flight.inertia.angular_velocity(flight.attitude.axis(), applied.moment);
    let motion = Motion { velocity: times(1.0 / flight.mass, applied.force), turning };
    let speed = flight.reach(&motion);
    let factor = if speed > 0.0 { ASKING * flight.fastest.max(1e-3) / speed } else { 0.0 };
    flight.shown = Motion { velocity: times(factor, motion.velocity), turning: times(factor, motion.turning) };
}

/// What resists gives just what the other forces ask of it, unless these do more work than it takes.
fn hold_or_go(flight: &mut Flight) {
    let mut all = flight.forces[0];
    all.add(&flight.forces[1]);
    all.add(&flight.forces[2]);
    flight.rests = all.power(&flight.shown) <= 0.0;
    if flight.rests {
        flight.forces = Default::default();
    }
}

impl Flight {
    /// Sums forces up; completes velocity and angular momentum at the instant's own time, an increment `behind` after the last, and
    /// books the work of the second half of it by the trapezoid, as of bodies along z.
    fn complete(&mut self, behind: f64) {
        self.before = self.kicks();
        self.total = Wrench::default();
        self.forces.iter().for_each(|force| self.total.add(force));
        if behind == 0.0 {
            return;
        }
        let [velocity, momentum] = self.half;
        self.velocity = plus(velocity, 0.5 * behind / self.mass, self.total.force);
        self.momentum = plus(momentum, 0.5 * behind, self.total.moment);
        let motion = self.motion_of(velocity, momentum);
        for account in 0..ACCOUNTS {
            self.work[account] += 0.5 * behind * (self.first_halves[account] + self.forces[account].power(&motion));
        }
    }

    /// Carries it over an increment, with the second-order estimate of its motion at the end that loads will see, `reach` after the
    /// middle.
    fn advance(&mut self, dt: f64, reach: f64) {
        self.last = Place { centre: self.centre, attitude: self.attitude, moving: [self.velocity, self.momentum] };
        if self.rests {
            self.half = [[0.0; 3]; 2];
            self.first_halves = [0.0; ACCOUNTS];
            return;
        }
        let per_mass = 1.0 / self.mass;
        let velocity = plus(self.velocity, 0.5 * dt * per_mass, self.total.force);
        let momentum = plus(self.momentum, 0.5 * dt, self.total.moment);
        let motion = self.motion_of(velocity, momentum);
        self.first_halves = self.forces.map(|force| force.power(&motion));
        self.half = [velocity, momentum];
        self.centre = plus(self.centre, dt, velocity);
        self.attitude = self.inertia.free_motion(self.attitude, momentum, dt);
        let shown = |v: Vector, rate: Vector, factor: f64| plus(v, reach * factor, rate);
        self.shown =
            self.motion_of(shown(velocity, self.total.force, per_mass), shown(momentum, self.total.moment, 1.0));
        self.fastest = self.fastest.max(self.reach(&motion));
    }

    /// The state of the instant before.
    pub(super) fn step_back(&mut self) {
        let Place { centre, attitude, moving: [velocity, momentum] } = self.last;
        (self.centre, self.attitude, self.velocity, self.momentum) = (centre, attitude, velocity, momentum);
    }
}
