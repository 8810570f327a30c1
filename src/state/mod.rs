//! The state: what moves, only what the plan declared.
//! Never here: anything no effect asked for.

pub mod archive;
pub mod dofs;
pub mod energies;
pub mod halt;
pub mod limit;
pub mod magnitude;
pub mod nodes;
pub mod rigid_body_3d;

use archive::{Archive, Persist, persist_fields, persist_struct};

use crate::kernel::amplitude::SampledAmplitude;
use crate::kernel::lanes::Corners;
use crate::kernel::topology::{MOST_NODES, PerNode};
use rigid_body_3d::{PointMotion, RigidBody3d, Wrench};

/// Index into the ledger: the only thing an effect knows of the deck.
pub type EffectId = usize;

/// Where the clock stands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Instant {
    /// Time since the start of the step.
    pub step_time: f64,
    /// Time since the start of the analysis.
    pub total_time: f64,
    /// Number of the step, from 1.
    pub step: u32,
    /// Increments behind, over all steps.
    pub increment: u64,
    /// What rounding has taken from the step time (Kahan's summation): a million equal increments end on time.
    pub lost: f64,
}

/// A rigid body: one degree of freedom, along z, or six where its impact is oblique; what is along z then is of its reference node
/// along 2. Bodies are few and all of one is touched together, so each is one piece in memory: two cache lines.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub struct BodyState {
    pub mass: f64,
    /// One over the mass: a division would be the longest link of the chain from force to velocity.
    pub inverse_mass: f64,
    /// Displacement at the increment's own time.
    pub displacement: f64,
    /// Velocity at the middle of the previous increment.
    pub velocity_half: f64,
    /// Acceleration at the increment's own time.
    pub acceleration: f64,
    /// Velocity at the increment's own time. (Not beside the displacement: the two copied as one piece would wait for the
    /// velocity's way to memory.)
    pub velocity: f64,
    /// Sum of the forces of all effects.
    pub force: f64,
    /// The velocity that loads are shown.
    pub velocity_load: f64,
    /// Sign of the motion a resistance opposes: of the velocity, or at rest of the force that would start it; 0 if none.
    pub direction: f64,
    /// The previous increment.
    pub before: Before,
    /// Force that a prescribed motion adds.
    pub reaction: f64,
    /// Acceleration over the previous increment by contact on a body that moves freely; the acceleration holds it no more.
    pub contact: f64,
    /// The six degrees of freedom; `None` where it moves along z.
    pub spatial: Option<Box<RigidBody3d>>,
    /// How many generalised forces act on it.
    pub slots: u32,
    /// Whether it is under loads that read velocity.
    pub reads_velocity: bool,
    /// Whether its motion is prescribed.
    pub prescribed: bool,
    /// Whether it carries nodes of deformable elements, whose stable increment then serves it too.
    pub tied: bool,
}

/// Where a body stood an increment ago.
#[derive(Clone, Copy, Debug, Default)]
pub struct Before {
    pub velocity: f64,
    pub acceleration: f64,
    pub displacement: f64,
}

impl BodyState {
    /// A body that flies at a velocity.
    pub fn new(mass: f64, velocity: f64) -> Self {
        BodyState { mass, inverse_mass: 1.0 / mass, velocity, ..BodyState::default() }
    }

    /// A body with six degrees of freedom.
    pub fn in_space(spatial: RigidBody3d) -> Self {
        let (mass, spatial) = (spatial.mass, Some(Box::new(spatial)));
        let mut body = BodyState { mass, inverse_mass: 1.0 / mass, spatial, ..BodyState::default() };
        body.follow_reference_node();
        body
    }

    /// Says whether a resistance acts on it in this step.
    pub fn set_resisted(&mut self, resisted: bool) {
        self.spatial.iter_mut().for_each(|spatial| spatial.resisted = resisted);
    }

    /// Lets resistances see in which direction a body at rest would move under the other forces, given by their coordinates.
    pub fn probe(&mut self, applied: impl Iterator<Item = (u32, f64)>) {
        match &mut self.spatial {
            None => self.direction = direction(applied.map(|(_, force)| force).sum()),
            Some(spatial) if spatial.rests => spatial.probe(&sum(applied)),
            Some(_) => {}
        }
    }

    /// The sum of forces, for messages.
    pub fn describe_force(&self) -> String {
        match &self.spatial {
            None => format!("force {}", self.force),
            Some(spatial) => format!("force {:?}, moment {:?}", spatial.total.force, spatial.total.moment),
        }
    }

    /// Whether it moves in space.
    #[inline]
    pub fn is_spatial(&self) -> bool {
        self.spatial.is_some()
    }

    /// Takes the acceleration from generalised forces, given by their coordinates; that of a prescribed motion is still to be
    /// replaced. Returns whether it is at rest and resistances hold it there.
    #[inline]
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

    /// Completes the velocity at the instant's own time, `dt` after the previous one.
    #[inline]
    pub fn complete_velocity(&mut self, dt: f64) {
        self.velocity = self.velocity_half + 0.5 * dt * self.acceleration;
        if let Some(spatial) = &mut self.spatial {
            spatial.complete_velocity(dt);
            self.velocity = spatial.along_axis_2()[1];
        }
    }

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

    /// Lets loads see the velocity a time after the middle of the previous increment.
    #[inline]
    pub fn show_velocity_after(&mut self, time: f64) {
        self.show(self.velocity_half + time * self.acceleration);
        if let Some(spatial) = &mut self.spatial {
            spatial.show_motion_after(time);
            self.follow_reference_node();
        }
    }

    /// Lets loads see the velocity at the instant's own time.
    pub fn show_own_velocity(&mut self) {
        self.show(self.velocity);
        self.spatial.iter_mut().for_each(|spatial| spatial.show_own_motion());
    }

    #[inline]
    fn show(&mut self, velocity: f64) {
        self.velocity_load = velocity;
        self.direction = direction(velocity);
    }

    /// What is along z, of the reference node of a body in space.
    fn follow_reference_node(&mut self) {
        if let Some(spatial) = &self.spatial {
            [self.displacement, self.velocity, self.acceleration] = spatial.along_axis_2();
        }
    }

    /// Stops it.
    pub fn arrest(&mut self) {
        self.velocity = 0.0;
        self.spatial.iter_mut().for_each(|spatial| spatial.arrest());
    }

    /// Restores the previous instant.
    pub fn step_back(&mut self) {
        let Before { displacement, velocity, acceleration } = self.before;
        (self.displacement, self.velocity, self.acceleration) = (displacement, velocity, acceleration);
        self.spatial.iter_mut().for_each(|spatial| spatial.step_back());
    }

    /// Work over the previous increment of a generalised force, given at its start and at its end; after one that ended in a jump the
    /// force at its start counts.
    #[inline]
    pub fn work(&self, coordinate: u32, [before, now]: [f64; 2], jump: bool) -> f64 {
        if let Some(spatial) = &self.spatial {
            return spatial.work(coordinate as usize, [before, if jump { before } else { now }]);
        }
        let mean = if jump { before } else { 0.5 * (before + now) };
        mean * (self.displacement - self.before.displacement)
    }

    /// The largest speed of any of its points.
    #[inline]
    pub fn speed(&self) -> f64 {
        self.spatial.as_ref().map_or(self.velocity.abs(), |spatial| spatial.speed_bound(&spatial.motion()))
    }

    /// Acceleration now, and by how much it differs from that an increment ago: bounds over all of its points.
    #[inline]
    pub fn acceleration_and_change(&self) -> [f64; 2] {
        match &self.spatial {
            None => [self.acceleration.abs(), (self.acceleration - self.before.acceleration).abs()],
            Some(spatial) => spatial.acceleration_and_change(),
        }
    }

    /// Time until it comes to rest, where that is less than 1.25 `increment`; `slow` as in [`RigidBody3d::time_to_rest`].
    #[inline]
    pub fn time_to_rest(&self, increment: f64, slow: f64) -> Option<f64> {
        if let Some(spatial) = &self.spatial {
            return spatial.time_to_rest(increment, slow);
        }
        let (v, a) = (self.velocity, self.acceleration);
        // Far from rest, the common case, needs no division.
        (v * a < 0.0 && v.abs() < 1.25 * increment * a.abs()).then(|| -v / a)
    }

    /// Whether the same forces act on it as on another state of it, to the last bit.
    pub fn has_same_forces(&self, other: &BodyState) -> bool {
        let in_space = |body: &BodyState| body.spatial.as_ref().map(|spatial| spatial.total);
        let forces = |body: &BodyState| (body.force, body.acceleration, in_space(body));
        forces(self) == forces(other)
    }

    /// Kinetic energy that the impulse of contact in the previous increment takes from a body in space that is at rest.
    pub fn energy_stopped(&self) -> f64 {
        self.spatial.as_ref().map_or(0.0, |spatial| spatial.energy_stopped())
    }

    /// Motion of a point whose place in the mesh is `[r, z]`, turned around the axis by an angle; `None` where it moves along z.
    pub fn point_motion(&self, place: [f64; 2], around: f64) -> Option<PointMotion> {
        self.spatial.as_ref().map(|spatial| spatial.point_motion(place, around))
    }

    /// Stations around the axis of a body that moves in space; `None` of others.
    pub fn stations(&self) -> Option<usize> {
        self.spatial.as_ref().map(|spatial| spatial.stations)
    }

    /// Passes on position, attitude, velocity, momentum and forces of a body in space, for a digest.
    pub fn numbers_in_space(&self, each: &mut dyn FnMut(&[f64])) {
        let Some(body) = &self.spatial else { return };
        [body.centre, body.velocity, body.momentum, body.total.force, body.total.moment].iter().for_each(|v| each(v));
        each(&body.attitude.0);
    }

    /// Kinetic energy. In contact the velocities before and behind the instant without the contact's next impulse make it: their
    /// mean, squared, would hold the motion that the impulse is about to stop, (F dt)^2/8M under a load F at rest.
    pub fn kinetic(&self) -> f64 {
        if let Some(spatial) = &self.spatial {
            return spatial.kinetic();
        }
        if self.contact == 0.0 {
            return 0.5 * self.mass * self.velocity * self.velocity;
        }
        let behind = 2.0 * self.velocity - self.velocity_half;
        (0.5 * self.mass * self.velocity_half * behind).max(0.0)
    }
}

/// Generalised forces on a body in space as force and moment.
fn sum(forces: impl Iterator<Item = (u32, f64)>) -> Wrench {
    let mut sums = [0.0; 6];
    forces.for_each(|(coordinate, force)| sums[coordinate as usize] += force);
    Wrench::of(sums)
}

/// 1, -1, or 0 for zero (and for what is not a number).
#[inline]
pub fn direction(value: f64) -> f64 {
    f64::from(i8::from(value > 0.0) - i8::from(value < 0.0))
}

impl<T: Persist> Persist for Corners<T> {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        self.0.persist(archive);
    }
}

impl<T: Persist + Copy + Default> Persist for PerNode<T> {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let (values, count) = self.parts_mut();
        persist_fields!(archive; values, count);
        if usize::from(*count) > MOST_NODES {
            archive.refuse(|| "an element has more nodes than any topology".into());
            *self = PerNode::default();
        }
    }
}

impl Persist for SampledAmplitude {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        self.points().into_iter().for_each(|point| point.persist(archive));
    }
}

persist_struct!(Instant { step_time, total_time, step, increment, lost });

persist_struct!(Before { velocity, acceleration, displacement });

// What the plan and the beginning of a step give.
persist_struct!(BodyState {
    spatial: present, displacement, velocity_half, acceleration, velocity, force, velocity_load, direction, before,
    reaction, contact
} derived {
    mass, inverse_mass, slots, reads_velocity, prescribed, tied
});
