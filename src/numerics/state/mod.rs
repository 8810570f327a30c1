//! State of a run: degrees of freedom, time, energies, and their serialization. Only what the plan declares exists.

pub mod archive;
pub mod dofs;
pub mod energies;
pub mod halt;
pub mod limit;
pub mod magnitude;
pub mod nodes;
pub mod rigid_body_3d;

use archive::{Persist, StateArchive, persist_fields};

use crate::kernel::amplitude::SampledAmplitude;
use crate::kernel::topology::{MOST_NODES, PerNode};
use rigid_body_3d::{PointMotion, RigidBody3d, Wrench};

/// Index of an effect in the ledger: the only link from an effect to the deck.
pub type EffectId = usize;

/// Current time, step and increment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Persist)]
pub struct Instant {
    /// Time since the start of the step.
    pub step_time: f64,
    /// Time since the start of the analysis.
    pub total_time: f64,
    /// Number of the step, from 1.
    pub step: u32,
    /// Number of completed increments of all steps.
    pub increment: u64,
    /// Rounding error of the step time (Kahan summation): a million equal increments end at the exact time.
    pub lost: f64,
}

/// A rigid body with one degree of freedom along z, or with six if its impact is oblique; the values along z are then
/// those of its reference node along direction 2. The fields of a body are used together, so each body is one object of
/// two cache lines.
#[derive(Clone, Debug, Default, Persist)]
#[repr(C, align(64))]
// The derived fields follow from the plan and the start of a step.
#[persist(present: spatial; derived: slots, reads_velocity, prescribed, tied)]
pub struct BodyState {
    pub mass: f64,
    /// Inverse mass, which avoids a division in the chain from force to velocity.
    pub inverse_mass: f64,
    /// Displacement at the current instant.
    pub displacement: f64,
    /// Velocity at the middle of the previous increment.
    pub velocity_half: f64,
    /// Acceleration at the current instant.
    pub acceleration: f64,
    /// Velocity at the current instant. (Not adjacent to the displacement: copying both as one piece would wait for the
    /// store of the velocity.)
    pub velocity: f64,
    /// Sum of the forces of all effects.
    pub force: f64,
    /// Velocity that loads use.
    pub velocity_load: f64,
    /// Sign of the motion that resistances oppose: of the velocity, or for a body at rest of the force that would start
    /// its motion; 0 if none.
    pub direction: f64,
    /// Motion at the previous instant.
    pub before: PreviousMotion,
    /// Reaction force of a prescribed motion.
    pub reaction: f64,
    /// Acceleration by contact over the previous increment, for a body without prescribed motion; not included in
    /// `acceleration`.
    pub contact: f64,
    /// The six degrees of freedom; `None` for a body that moves along z.
    pub spatial: Option<Box<RigidBody3d>>,
    /// Number of generalised forces that act on it.
    pub slots: u32,
    /// Whether a load depends on its velocity.
    pub reads_velocity: bool,
    /// Whether the motion of the body is prescribed.
    pub prescribed: bool,
    /// Whether the body is tied to nodes of deformable elements, whose stable time increment then also applies to it.
    pub tied: bool,
}

/// Motion of a body at the previous instant.
#[derive(Clone, Copy, Debug, Default, Persist)]
pub struct PreviousMotion {
    pub velocity: f64,
    pub acceleration: f64,
    pub displacement: f64,
}

impl BodyState {
    /// Creates a body with an initial velocity.
    pub fn new(mass: f64, velocity: f64) -> Self {
        BodyState { mass, inverse_mass: 1.0 / mass, velocity, ..BodyState::default() }
    }

    /// Creates a body with six degrees of freedom.
    pub fn in_space(spatial: RigidBody3d) -> Self {
        let (mass, spatial) = (spatial.mass, Some(Box::new(spatial)));
        let mut body = BodyState { mass, inverse_mass: 1.0 / mass, spatial, ..BodyState::default() };
        body.follow_reference_node();
        body
    }

    /// Sets whether a resistance acts on it in this step.
    pub fn set_resisted(&mut self, resisted: bool) {
        self.spatial.iter_mut().for_each(|spatial| spatial.resisted = resisted);
    }

    /// Determines the direction in which a body at rest would move under the other forces, given with their
    /// coordinates, for the evaluation of resistances.
    pub fn probe(&mut self, applied: impl Iterator<Item = (u32, f64)>) {
        match &mut self.spatial {
            None => self.direction = direction(applied.map(|(_, force)| force).sum()),
            Some(spatial) if spatial.rests => spatial.probe(&sum(applied)),
            Some(_) => {}
        }
    }

    /// Returns the sum of forces, formatted for messages.
    pub fn describe_force(&self) -> String {
        match &self.spatial {
            None => format!("force {}", self.force),
            Some(spatial) => format!("force {:?}, moment {:?}", spatial.total.force, spatial.total.moment),
        }
    }

    /// Returns whether it has six degrees of freedom.
    #[inline]
    pub fn is_spatial(&self) -> bool {
        self.spatial.is_some()
    }

    /// Computes the acceleration from generalised forces, given with their coordinates; a prescribed motion replaces it
    /// later. Returns whether the body is at rest and resistances keep it at rest.
    #[inline(always)]
    pub fn accelerate(&mut self, forces: impl Iterator<Item = (u32, f64)>) -> bool {
        self.before.acceleration = self.acceleration;
        if let Some(spatial) = &mut self.spatial {
            let total = sum(forces);
            let rests = spatial.take_forces(total);
            self.force = spatial.total.force[1];
            self.acceleration = if total.is_finite() { spatial.along_axis_2()[2] } else { f64::NAN };
            return rests;
        }
        self.force = forces.fold(0.0, |sum, (_, force)| sum + force);
        let rests = self.velocity_load == 0.0 && self.direction != 0.0 && self.force * self.direction <= 0.0;
        if rests {
            self.force = 0.0;
        }
        self.acceleration = self.force * self.inverse_mass;
        rests
    }

    /// Computes the velocity at the current instant, `dt` after the previous one. Equation (4.3).
    #[inline]
    pub fn complete_velocity(&mut self, dt: f64) {
        self.velocity = self.velocity_half + 0.5 * dt * self.acceleration;
        if let Some(spatial) = &mut self.spatial {
            spatial.complete_velocity(dt);
            self.velocity = spatial.along_axis_2()[1];
        }
    }

    /// Advances velocity and displacement over an increment `dt` by central differences. Equation (4.1).
    #[inline]
    pub fn advance(&mut self, dt: f64) {
        self.before.displacement = self.displacement;
        self.before.velocity = self.velocity;
        self.velocity_half = self.velocity + 0.5 * dt * self.acceleration;
        self.displacement += dt * self.velocity_half;
        if let Some(spatial) = &mut self.spatial {
            spatial.advance(dt);
        }
    }

    /// Changes the mass at constant velocity: that at the middle of the previous increment, or the current one if central
    /// differences start. Returns the increase of kinetic energy.
    pub fn change_mass(&mut self, mass: f64, starts: bool) -> f64 {
        let (added, velocity) = (mass - self.mass, if starts { self.velocity } else { self.velocity_half });
        (self.mass, self.inverse_mass) = (mass, 1.0 / mass);
        0.5 * added * velocity * velocity
    }

    /// Returns to the start of the increment, before the forces at its end have been accepted.
    pub fn undo_advance(&mut self) {
        (self.displacement, self.velocity) = (self.before.displacement, self.before.velocity);
        self.spatial.iter_mut().for_each(|spatial| spatial.step_back());
    }

    /// Sets the velocity that loads use: a time after the middle of the previous increment.
    #[inline]
    pub fn show_velocity_after(&mut self, time: f64) {
        self.show(self.velocity_half + time * self.acceleration);
        if let Some(spatial) = &mut self.spatial {
            spatial.show_motion_after(time);
            self.follow_reference_node();
        }
    }

    /// Sets the velocity that loads use to that of the current instant.
    pub fn show_own_velocity(&mut self) {
        self.show(self.velocity);
        self.spatial.iter_mut().for_each(|spatial| spatial.show_own_motion());
    }

    #[inline]
    fn show(&mut self, velocity: f64) {
        self.velocity_load = velocity;
        self.direction = direction(velocity);
    }

    /// Copies the motion of the reference node of a body with six degrees of freedom to the values along z.
    fn follow_reference_node(&mut self) {
        if let Some(spatial) = &self.spatial {
            [self.displacement, self.velocity, self.acceleration] = spatial.along_axis_2();
        }
    }

    /// Sets the velocity to zero.
    pub fn arrest(&mut self) {
        self.velocity = 0.0;
        self.spatial.iter_mut().for_each(|spatial| spatial.arrest());
    }

    /// Restores the previous instant.
    pub fn step_back(&mut self) {
        let PreviousMotion { displacement, velocity, acceleration } = self.before;
        (self.displacement, self.velocity, self.acceleration) = (displacement, velocity, acceleration);
        self.spatial.iter_mut().for_each(|spatial| spatial.step_back());
    }

    /// Returns the work of a generalised force over the previous increment, given its values at the start and the end;
    /// after an increment that ended in a jump, the value at the start is used. Equation (14.3).
    #[inline]
    pub fn work(&self, coordinate: u32, [before, now]: [f64; 2], jump: bool) -> f64 {
        if let Some(spatial) = &self.spatial {
            return spatial.work(coordinate as usize, [before, if jump { before } else { now }]);
        }
        let mean = if jump { before } else { 0.5 * (before + now) };
        mean * (self.displacement - self.before.displacement)
    }

    /// Returns a bound of the speed of all points of the body.
    #[inline]
    pub fn speed(&self) -> f64 {
        self.spatial.as_ref().map_or(self.velocity.abs(), |spatial| spatial.speed_bound(&spatial.motion()))
    }

    /// Returns bounds over all points of the acceleration and of its change since the previous instant.
    #[inline]
    pub fn acceleration_and_change(&self) -> [f64; 2] {
        match &self.spatial {
            None => [self.acceleration.abs(), (self.acceleration - self.before.acceleration).abs()],
            Some(spatial) => spatial.acceleration_and_change(),
        }
    }

    /// Returns whether the body is at rest and remains so under constant forces.
    #[inline]
    pub fn is_still(&self) -> bool {
        self.speed() == 0.0 && self.acceleration_and_change()[0] == 0.0
    }

    /// Returns the time until the body comes to rest if it is less than 1.25 `increment`; `slow` as in
    /// [`RigidBody3d::time_to_rest`].
    #[inline]
    pub fn time_to_rest(&self, increment: f64, slow: f64) -> Option<f64> {
        if let Some(spatial) = &self.spatial {
            return spatial.time_to_rest(increment, slow);
        }
        let (v, a) = (self.velocity, self.acceleration);
        // The common case, far from rest, needs no division.
        (v * a < 0.0 && v.abs() < 1.25 * increment * a.abs()).then(|| -v / a)
    }

    /// Returns whether the forces are equal to those of another state, to the last bit.
    pub fn has_same_forces(&self, other: &BodyState) -> bool {
        let in_space = |body: &BodyState| body.spatial.as_ref().map(|spatial| spatial.total);
        let forces = |body: &BodyState| (body.force, body.acceleration, in_space(body));
        forces(self) == forces(other)
    }

    /// Returns the kinetic energy that the contact impulse of the previous increment takes from a body at rest with six
    /// degrees of freedom.
    pub fn energy_stopped(&self) -> f64 {
        self.spatial.as_ref().map_or(0.0, |spatial| spatial.energy_stopped())
    }

    /// Returns the motion of a point with mesh coordinates `[r, z]`, rotated about the axis by an angle; `None` for a
    /// body that moves along z.
    pub fn point_motion(&self, place: [f64; 2], around: f64) -> Option<PointMotion> {
        self.spatial.as_ref().map(|spatial| spatial.point_motion(place, around))
    }

    /// Returns the number of stations around the axis of a body with six degrees of freedom; `None` for other bodies.
    pub fn stations(&self) -> Option<usize> {
        self.spatial.as_ref().map(|spatial| spatial.stations)
    }

    /// Passes position, attitude, velocity, momentum and forces of a body with six degrees of freedom to `each`, for a
    /// digest.
    pub fn numbers_in_space(&self, each: &mut dyn FnMut(&[f64])) {
        let Some(body) = &self.spatial else { return };
        [body.centre, body.velocity, body.momentum, body.total.force, body.total.moment].iter().for_each(|v| each(v));
        each(&body.attitude.0);
    }

    /// Returns the kinetic energy. In contact, it is computed from the velocities before and after the instant without
    /// the next contact impulse. The square of their mean would include motion that the impulse is about to stop: (F
    /// dt)²/(8M) under a load F at rest.
    #[inline]
    pub fn kinetic(&self) -> f64 {
        if let Some(spatial) = &self.spatial {
            return spatial.kinetic();
        }
        if self.contact == 0.0 {
            return 0.5 * self.mass * self.velocity * self.velocity;
        }
        let next_half = 2.0 * self.velocity - self.velocity_half;
        (0.5 * self.mass * self.velocity_half * next_half).max(0.0)
    }
}

/// Returns the sum of generalised forces as force and moment.
fn sum(forces: impl Iterator<Item = (u32, f64)>) -> Wrench {
    let mut sums = [0.0; 6];
    forces.for_each(|(coordinate, force)| sums[coordinate as usize] += force);
    Wrench::of(sums)
}

/// Returns the sign: 1, -1, or 0 for zero and NaN.
#[inline]
pub fn direction(value: f64) -> f64 {
    f64::from(i8::from(value > 0.0) - i8::from(value < 0.0))
}

impl<T: Persist + Copy + Default> Persist for PerNode<T> {
    fn persist(&mut self, archive: &mut StateArchive<'_>) {
        let (values, count) = self.parts_mut();
        persist_fields!(archive; values, count);
        if usize::from(*count) > MOST_NODES {
            archive.reject(|| "an element has more nodes than any topology".into());
            *self = PerNode::default();
        }
    }
}

impl Persist for SampledAmplitude {
    fn persist(&mut self, archive: &mut StateArchive<'_>) {
        self.points().into_iter().for_each(|point| point.persist(archive));
    }
}
