//! A rigid body that moves and turns in space: six degrees of freedom, of its centre of mass and its attitude. Only bodies whose
//! impact is oblique have one; directions are 1, 2, 3 of `kernel::attitude`.
//! Never here: what pushes it, how it is carried over an increment.

use super::archive::{Archive, Persist, persist_fields};
use crate::kernel::attitude::{Attitude, Inertia, Vector, angle, cross, dot, norm, plus};

/// A force at the centre of mass and a moment about it, in the world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wrench {
    /// Force.
    pub force: Vector,
    /// Moment.
    pub moment: Vector,
}

impl Wrench {
    /// A force at a point `arm` away from the centre of mass.
    pub fn at(arm: Vector, force: Vector) -> Wrench {
        Wrench { force, moment: cross(arm, force) }
    }

    /// Adds another one.
    pub fn add(&mut self, other: &Wrench) {
        self.force = plus(self.force, 1.0, other.force);
        self.moment = plus(self.moment, 1.0, other.moment);
    }

    /// Power at a velocity of the centre of mass and an angular velocity.
    pub fn power(&self, motion: &Motion) -> f64 {
        dot(self.force, motion.velocity) + dot(self.moment, motion.turning)
    }
}

/// Velocity of the centre of mass and angular velocity, in the world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Velocity.
    pub velocity: Vector,
    /// Angular velocity.
    pub turning: Vector,
}

/// Where a body stood, how it was turned, and its velocity and angular momentum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Place {
    /// Centre of mass.
    pub centre: Vector,
    /// Attitude.
    pub attitude: Attitude,
    /// Velocity and angular momentum.
    pub moving: [Vector; 2],
}

/// What forces are booked under: work of loads, friction, opening of the cavity.
pub const ACCOUNTS: usize = 3;

/// A rigid body with six degrees of freedom.
#[derive(Clone, Debug, Default)]
pub struct Flight {
    /// Index of the body.
    pub body: usize,
    /// Mass.
    pub mass: f64,
    /// Moments of inertia about the centre of mass.
    pub inertia: Inertia,
    /// Height of the centre of mass on the axis where the mesh has the body, and of its reference node.
    pub heights: [f64; 2],
    /// Largest distance of a node from the centre of mass.
    pub size: f64,
    /// Where it was at the start of the analysis.
    pub start: Place,
    /// Stations around its axis, in resistances and frames.
    pub stations: usize,
    /// Centre of mass.
    pub centre: Vector,
    /// Attitude.
    pub attitude: Attitude,
    /// Velocity of the centre of mass at the instant's own time.
    pub velocity: Vector,
    /// Angular momentum about the centre of mass, likewise.
    pub momentum: Vector,
    /// Velocity and angular momentum at the middle of the increment behind.
    pub half: [Vector; 2],
    /// What loads are shown.
    pub shown: Motion,
    /// Forces by account.
    pub forces: [Wrench; ACCOUNTS],
    /// Their sum.
    pub total: Wrench,
    /// Sum an increment ago, as [`Flight::kicks`].
    pub before: [Vector; 2],
    /// Centre and attitude, velocity and angular momentum an increment ago.
    pub last: Place,
    /// Largest speed of any of its points so far.
    pub fastest: f64,
    /// Power of each account over the first half of the increment behind, for the trapezoid.
    pub first_halves: [f64; ACCOUNTS],
    /// Work of each account so far.
    pub work: [f64; ACCOUNTS],
    /// Whether it lies still and what resists holds it.
    pub rests: bool,
    /// Whether something that resists acts on it in this step.
    pub resisted: bool,
}

impl Flight {
    /// Velocity of the centre of mass and angular velocity now.
    pub fn motion(&self) -> Motion {
        self.motion_of(self.velocity, self.momentum)
    }

    /// Where it starts afresh loads see its own motion.
    pub fn show_own_motion(&mut self) {
        self.shown = self.motion();
        self.fastest = self.fastest.max(self.reach(&self.shown));
    }

    /// The motion with a velocity and an angular momentum at the attitude now.
    pub fn motion_of(&self, velocity: Vector, momentum: Vector) -> Motion {
        Motion { velocity, turning: self.inertia.angular_velocity(self.attitude.axis(), momentum) }
    }

    /// The largest speed that any of its points can have in a motion.
    pub fn reach(&self, motion: &Motion) -> f64 {
        norm(motion.velocity) + self.size * norm(motion.turning)
    }

    /// Kinetic energy, of rotation too.
    pub fn kinetic(&self) -> f64 {
        0.5 * self.mass * dot(self.velocity, self.velocity) + self.inertia.energy(self.attitude.axis(), self.momentum)
    }

    /// Where a point of the body is whose place in the mesh is `[r, z]`, turned around the axis by an angle.
    pub fn place(&self, [r, z]: [f64; 2], around: f64) -> Vector {
        plus(self.centre, 1.0, self.arm([r, z], around))
    }

    /// Where that point was at the start.
    pub fn place_at_start(&self, [r, z]: [f64; 2], around: f64) -> Vector {
        let of_body = [r * libm::cos(around), z - self.heights[0], r * libm::sin(around)];
        plus(self.start.centre, 1.0, self.start.attitude.to_world(of_body))
    }

    /// From the centre of mass to that point, in the world.
    pub fn arm(&self, [r, z]: [f64; 2], around: f64) -> Vector {
        self.attitude.to_world([r * libm::cos(around), z - self.heights[0], r * libm::sin(around)])
    }

    /// Velocity of a point that far from the centre of mass.
    pub fn velocity_at(&self, arm: Vector) -> Vector {
        let motion = self.motion();
        plus(motion.velocity, 1.0, cross(motion.turning, arm))
    }

    /// Acceleration of a point that far from the centre of mass: a + alpha x d + omega x (omega x d). Euler's equations give alpha.
    pub fn acceleration_at(&self, arm: Vector) -> Vector {
        let (motion, [linear, angular]) = (self.motion(), self.accelerations());
        let turning = cross(motion.turning, cross(motion.turning, arm));
        plus(plus(linear, 1.0, cross(angular, arm)), 1.0, turning)
    }

    /// Acceleration of the centre of mass, and angular acceleration: L' = M, with omega = L/I_t + (1/I_a - 1/I_t) (L . e) e and
    /// e' = omega x e.
    pub fn accelerations(&self) -> [Vector; 2] {
        let axis = self.attitude.axis();
        let turning = self.motion().turning;
        let difference = 1.0 / self.inertia.axial - 1.0 / self.inertia.transverse;
        let moving = cross(turning, axis);
        let own = self.inertia.angular_velocity(axis, self.total.moment);
        let carried = dot(self.momentum, moving);
        let angular = plus(plus(own, difference * carried, axis), difference * dot(self.momentum, axis), moving);
        [self.total.force.map(|f| f / self.mass), angular]
    }

    /// What forces and moments give to velocity and angular velocity a time, the latter as of a body without spin.
    pub fn kicks(&self) -> [Vector; 2] {
        [self.total.force.map(|f| f / self.mass), self.total.moment.map(|m| m / self.inertia.transverse)]
    }

    /// Angle between its axis, on the side to which it flies, and its velocity: total yaw, radians.
    pub fn yaw(&self) -> f64 {
        let total = angle(self.attitude.axis(), self.velocity);
        if norm(self.velocity) == 0.0 { 0.0 } else { total.min(std::f64::consts::PI - total) }
    }

    /// Angle between its axis and direction 2, where the mesh has it, radians.
    pub fn tilt(&self) -> f64 {
        angle(self.attitude.axis(), [0.0, 1.0, 0.0])
    }
}

impl Persist for Attitude {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        self.0.persist(archive);
    }
}

impl Persist for Motion {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Motion { velocity, turning } = self;
        persist_fields!(archive; velocity, turning);
    }
}

impl Persist for Place {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Place { centre, attitude, moving } = self;
        persist_fields!(archive; centre, attitude, moving);
    }
}

impl Persist for Wrench {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Wrench { force, moment } = self;
        persist_fields!(archive; force, moment);
    }
}

impl Persist for Flight {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Flight {
            // What the plan and the beginning of a step give.
            body: _,
            mass: _,
            inertia: _,
            heights: _,
            size: _,
            start: _,
            stations: _,
            resisted: _,
            centre,
            attitude,
            velocity,
            momentum,
            half,
            shown,
            forces,
            total,
            before,
            last,
            fastest,
            first_halves,
            work,
            rests,
        } = self;
        persist_fields!(archive; centre, attitude, velocity, momentum, half, shown, forces, total, before, first_halves);
        persist_fields!(archive; last, fastest, work, rests);
    }
}
