//! Rigid body with six degrees of freedom, for oblique impact: central differences of the velocity of its centre of
//! mass and of its angular momentum, with the exact torque-free motion of a symmetric top between the updates (Strang
//! splitting, second order). Directions are 1, 2, 3 of `kernel::attitude`.

use super::archive::Persist;
use crate::kernel::attitude::{Attitude, PrincipalInertia, SpatialVector, angle, cross, dot, norm, plus, times};
use crate::kernel::lanes::InlineMap;

/// Speed at which the resistance on a body at rest is evaluated, relative to its largest speed so far; only its
/// direction matters.
const PROBE: f64 = 1e-9;

/// Force at the centre of mass and moment about it, in the global frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Persist)]
pub struct Wrench {
    pub force: SpatialVector,
    pub moment: SpatialVector,
}

impl Wrench {
    /// Returns the wrench of a force at a point `arm` from the centre of mass.
    pub fn at(arm: SpatialVector, force: SpatialVector) -> Wrench {
        Wrench { force, moment: cross(arm, force) }
    }

    pub fn add(&mut self, other: &Wrench) {
        self.force = plus(self.force, 1.0, other.force);
        self.moment = plus(self.moment, 1.0, other.moment);
    }

    /// Returns the wrench with these components along and about 1, 2, 3.
    pub fn of(components: [f64; 6]) -> Wrench {
        let [f1, f2, f3, m1, m2, m3] = components;
        Wrench { force: [f1, f2, f3], moment: [m1, m2, m3] }
    }

    /// Returns the components along and about 1, 2, 3.
    pub fn components(&self) -> [f64; 6] {
        let ([f1, f2, f3], [m1, m2, m3]) = (self.force, self.moment);
        [f1, f2, f3, m1, m2, m3]
    }

    /// Returns the power at a velocity of the centre of mass and an angular velocity.
    pub fn power(&self, motion: &RigidMotion) -> f64 {
        dot(self.force, motion.velocity) + dot(self.moment, motion.turning)
    }

    /// Returns whether all components are finite.
    pub fn is_finite(&self) -> bool {
        (norm(self.force) + norm(self.moment)).is_finite()
    }
}

/// Velocity of the centre of mass and angular velocity, in the global frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Persist)]
pub struct RigidMotion {
    /// Velocity of the centre of mass.
    pub velocity: SpatialVector,
    /// Angular velocity.
    pub turning: SpatialVector,
}

/// Position, attitude, velocity and angular momentum at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Persist)]
pub struct Pose {
    /// Position of the centre of mass.
    pub centre: SpatialVector,
    pub attitude: Attitude,
    /// Velocity and angular momentum.
    pub moving: [SpatialVector; 2],
}

/// Motion of a point of a body, for output; vectors along and about 1, 2, 3.
#[derive(Clone, Copy, Debug)]
pub struct PointMotion {
    /// Current position.
    pub place: SpatialVector,
    /// Displacement since the start of the analysis.
    pub displacement: SpatialVector,
    pub velocity: SpatialVector,
    pub acceleration: SpatialVector,
    /// Rotation vector of the body since the start of the analysis.
    pub rotation: SpatialVector,
    /// Angular velocity of the body.
    pub rotational_velocity: SpatialVector,
    /// Angular acceleration of the body.
    pub rotational_acceleration: SpatialVector,
    /// Angle between the axis of the body and its velocity, radians.
    pub yaw: f64,
    /// Angle between the axis of the body and direction 2, radians.
    pub tilt: f64,
}

/// A rigid body with six degrees of freedom.
#[derive(Clone, Debug, Default, Persist)]
// Derived fields follow from the plan and the start of a step; `energy_before` is used within an increment only.
#[persist(derived: mass, inertia, heights, size, start, stations, resisted, energy_before)]
pub struct RigidBody3d {
    pub mass: f64,
    /// Moments of inertia about the centre of mass.
    pub inertia: PrincipalInertia,
    /// Axial coordinate in the mesh of the centre of mass and of the reference node.
    pub heights: [f64; 2],
    /// Largest distance of a node from the centre of mass.
    pub size: f64,
    /// Pose at the start of the analysis.
    pub start: Pose,
    /// Number of stations around its axis, for loads, contact and frames.
    pub stations: usize,
    /// Position of the centre of mass.
    pub centre: SpatialVector,
    pub attitude: Attitude,
    /// Velocity of the centre of mass at the current instant.
    pub velocity: SpatialVector,
    /// Angular momentum about the centre of mass at the current instant.
    pub momentum: SpatialVector,
    /// Velocity and angular momentum at the middle of the previous increment.
    pub half: [SpatialVector; 2],
    /// Motion that loads use.
    pub shown: RigidMotion,
    /// Sum of the forces of all effects.
    pub total: Wrench,
    /// Contact force over the previous increment, not included in `total`, and half the time over which it acted.
    pub contact: (Wrench, f64),
    /// Accelerations at the previous instant, as [`RigidBody3d::kicks`].
    pub previous_kicks: [SpatialVector; 2],
    /// Pose at the previous instant.
    pub previous: Pose,
    /// Largest speed of any point so far.
    pub fastest: f64,
    /// Displacements along and rotations about 1, 2, 3 over the previous increment, with the attitude at its start and
    /// at its end; half of each weights the forces at that instant in the work.
    pub moved: [[f64; 6]; 2],
    /// Kinetic energy minus half the work of the forces at the start of the increment: reference for the energy lost in
    /// contact.
    pub energy_before: f64,
    /// Whether the body is at rest and resistances keep it at rest.
    pub rests: bool,
    /// Whether a resistance acts on it in this step.
    pub resisted: bool,
}

impl RigidBody3d {
    /// Returns velocity and angular velocity at the current instant.
    pub fn motion(&self) -> RigidMotion {
        self.motion_of(self.velocity, self.momentum)
    }

    /// Sets the motion that loads use to that of the current instant, at the start of central differences.
    pub fn show_own_motion(&mut self) {
        self.shown = self.motion();
        self.fastest = self.fastest.max(self.speed_bound(&self.shown));
    }

    /// Sets the motion that loads use: a time after the middle of the previous increment.
    pub fn show_motion_after(&mut self, time: f64) {
        let [velocity, momentum] = self.half;
        let velocity = plus(velocity, time / self.mass, self.total.force);
        self.shown = self.motion_of(velocity, plus(momentum, time, self.total.moment));
    }

    /// Sets the sum of all forces. A body at rest stays at rest unless their power exceeds that of resistances. Returns
    /// whether it stays at rest.
    pub fn take_forces(&mut self, total: Wrench) -> bool {
        self.previous_kicks = self.kicks();
        self.rests = self.rests && self.resisted && total.power(&self.shown) <= 0.0;
        self.total = if self.rests { Wrench::default() } else { total };
        self.rests
    }

    /// Determines the direction in which a body at rest would move under the other forces, for the evaluation of
    /// resistances.
    pub fn probe(&mut self, applied: &Wrench) {
        let turning = self.inertia.angular_velocity(self.attitude.axis(), applied.moment);
        let motion = RigidMotion { velocity: times(1.0 / self.mass, applied.force), turning };
        let speed = self.speed_bound(&motion);
        let factor = if speed > 0.0 { PROBE * self.fastest.max(1e-3) / speed } else { 0.0 };
        self.shown = RigidMotion { velocity: times(factor, motion.velocity), turning: times(factor, motion.turning) };
    }

    /// Computes velocity and angular momentum at the current instant, `dt` after the previous one. Equation (13.3).
    pub fn complete_velocity(&mut self, dt: f64) {
        let [velocity, momentum] = self.half;
        self.velocity = plus(velocity, 0.5 * dt / self.mass, self.total.force);
        self.momentum = plus(momentum, 0.5 * dt, self.total.moment);
    }

    /// Returns the pose at the current instant.
    pub fn pose(&self) -> Pose {
        Pose { centre: self.centre, attitude: self.attitude, moving: [self.velocity, self.momentum] }
    }

    /// Advances over an increment `dt`: half-step velocities from the current forces, then torque-free motion. Equation
    /// (13.3).
    pub fn advance(&mut self, dt: f64) {
        (self.energy_before, self.contact) = (self.kinetic(), Default::default());
        self.previous = self.pose();
        self.half = [
            plus(self.velocity, 0.5 * dt / self.mass, self.total.force),
            plus(self.momentum, 0.5 * dt, self.total.moment),
        ];
        if self.rests {
            self.half = [[0.0; 3]; 2];
        }
        self.move_freely(dt);
        self.fastest = self.fastest.max(self.speed_bound(&self.motion_of(self.half[0], self.half[1])));
    }

    /// Moves from the pose at the start of the increment with the velocity and angular momentum of its middle.
    pub fn move_freely(&mut self, dt: f64) {
        let [velocity, momentum] = self.half;
        let moved = |body: &RigidBody3d| {
            let RigidMotion { velocity, turning } = body.motion_of(velocity, momentum);
            Wrench { force: velocity, moment: turning }.components().inline_map(|rate| dt * rate)
        };
        self.attitude = self.previous.attitude;
        let first = moved(self);
        self.centre = plus(self.previous.centre, dt, velocity);
        self.attitude = self.inertia.free_motion(self.attitude, momentum, dt);
        self.moved = [first, moved(self)];
    }

    /// Returns the energy lost in contact in the increment since the last call. It is the decrease of v m v/2
    /// (velocities v at mid-increment) minus half the work of the forces at the start of the increment, consistent with
    /// the kinetic energy v m v'/2 of the velocities v and v' before and after an instant (see
    /// [`RigidBody3d::kinetic`]).
    pub fn take_lost_energy(&mut self) -> f64 {
        let [velocity, momentum] = self.half;
        let kinetic = 0.5 * self.mass * dot(velocity, velocity) + self.inertia.energy(self.attitude.axis(), momentum);
        let forces = self.total.components().into_iter().zip(self.moved[0]);
        let now = kinetic - 0.5 * forces.map(|(force, moved)| force * moved).sum::<f64>();
        std::mem::replace(&mut self.energy_before, now) - now
    }

    /// Returns the work of a generalised force over the previous increment from its values at the start and the end, by
    /// the trapezoidal rule.
    pub fn work(&self, coordinate: usize, [before, now]: [f64; 2]) -> f64 {
        0.5 * (before * self.moved[0][coordinate] + now * self.moved[1][coordinate])
    }

    /// Restores the previous instant.
    pub fn step_back(&mut self) {
        let Pose { centre, attitude, moving: [velocity, momentum] } = self.previous;
        (self.centre, self.attitude, self.velocity, self.momentum) = (centre, attitude, velocity, momentum);
    }

    /// Returns the time until the body comes to rest if it is less than 1.25 `increment`. With the kinetic energy T and
    /// the power P of all forces, uniform deceleration ends after 2T/|P|, which is v/|a| for a body without rotation.
    /// Below `slow` times its largest speed, where resistances are proportional to the velocity, the increment itself
    /// is returned.
    pub fn time_to_rest(&self, increment: f64, slow: f64) -> Option<f64> {
        if !self.resisted || self.rests {
            return None;
        }
        let motion = self.motion();
        let (energy, power) = (self.kinetic(), self.total.power(&motion));
        if power < 0.0 && self.speed_bound(&motion) < slow * self.fastest {
            return Some(increment);
        }
        (power < 0.0 && 2.0 * energy < -1.25 * increment * power).then(|| -2.0 * energy / power)
    }

    /// Returns the kinetic energy that the contact impulse of the previous increment takes from a body at rest.
    pub fn energy_stopped(&self) -> f64 {
        let (Wrench { force, .. }, time) = self.contact;
        let impulse = 2.0 * time * norm(force);
        0.5 * impulse * impulse / self.mass
    }

    /// Sets velocity and angular momentum to zero.
    pub fn arrest(&mut self) {
        (self.velocity, self.momentum, self.rests) = ([0.0; 3], [0.0; 3], true);
    }

    /// Returns the motion of a point with mesh coordinates `[r, z]`, rotated about the axis by an angle.
    pub fn point_motion(&self, place: [f64; 2], around: f64) -> PointMotion {
        let arm = self.arm(place, around);
        PointMotion {
            place: plus(self.centre, 1.0, arm),
            displacement: plus(self.place(place, around), -1.0, self.place_at_start(place, around)),
            velocity: self.velocity_at(arm),
            acceleration: self.acceleration_at(arm),
            rotation: self.attitude.after(self.start.attitude.inverse()).vector(),
            rotational_velocity: self.motion_in_contact().turning,
            rotational_acceleration: self.accelerations()[1],
            yaw: self.yaw(),
            tilt: self.tilt(),
        }
    }

    /// Returns displacement, velocity and acceleration of the reference node along 2.
    pub fn along_axis_2(&self) -> [f64; 3] {
        let [centre, reference] = self.heights;
        let (arm, start) = (times(reference - centre, self.attitude.axis()), self.start.attitude.axis());
        let displacement = plus(plus(self.centre, 1.0, arm), -1.0, plus(self.start.centre, reference - centre, start));
        [displacement[1], self.velocity_at(arm)[1], self.acceleration_at(arm)[1]]
    }

    /// Returns the motion for a velocity and an angular momentum, at the current attitude.
    pub fn motion_of(&self, velocity: SpatialVector, momentum: SpatialVector) -> RigidMotion {
        RigidMotion { velocity, turning: self.inertia.angular_velocity(self.attitude.axis(), momentum) }
    }

    /// Returns an upper bound of the speed of all points in a motion.
    pub fn speed_bound(&self, motion: &RigidMotion) -> f64 {
        norm(motion.velocity) + self.size * norm(motion.turning)
    }

    /// Returns the kinetic energy, including rotation. In contact, it is computed from the velocities before and after
    /// the instant without the next contact impulse, as for a body along z.
    pub fn kinetic(&self) -> f64 {
        if self.contact.0 != Wrench::default() {
            let [velocity, momentum] = self.half;
            let next = plus(times(2.0, self.velocity), -1.0, velocity);
            let next_momentum = plus(times(2.0, self.momentum), -1.0, momentum);
            let turning = self.inertia.angular_velocity(self.attitude.axis(), next_momentum);
            return (0.5 * (self.mass * dot(velocity, next) + dot(momentum, turning))).max(0.0);
        }
        0.5 * self.mass * dot(self.velocity, self.velocity) + self.inertia.energy(self.attitude.axis(), self.momentum)
    }

    /// Returns the current position of a point with mesh coordinates `[r, z]`, rotated about the axis by an angle.
    pub fn place(&self, [r, z]: [f64; 2], around: f64) -> SpatialVector {
        plus(self.centre, 1.0, self.arm([r, z], around))
    }

    /// Returns the initial position of this point.
    pub fn place_at_start(&self, [r, z]: [f64; 2], around: f64) -> SpatialVector {
        let of_body = [r * libm::cos(around), z - self.heights[0], r * libm::sin(around)];
        plus(self.start.centre, 1.0, self.start.attitude.to_world(of_body))
    }

    /// Returns the global vector from the centre of mass to this point.
    pub fn arm(&self, [r, z]: [f64; 2], around: f64) -> SpatialVector {
        self.attitude.to_world([r * libm::cos(around), z - self.heights[0], r * libm::sin(around)])
    }

    /// Returns the motion at the current instant, including the contact force of the previous increment.
    pub fn motion_in_contact(&self) -> RigidMotion {
        let (Wrench { force, moment }, time) = self.contact;
        self.motion_of(plus(self.velocity, time / self.mass, force), plus(self.momentum, time, moment))
    }

    /// Returns the velocity of a point at `arm` from the centre of mass.
    pub fn velocity_at(&self, arm: SpatialVector) -> SpatialVector {
        let motion = self.motion_in_contact();
        plus(motion.velocity, 1.0, cross(motion.turning, arm))
    }

    /// Returns the acceleration of a point at `arm` d from the centre of mass: a + α × d + ω × (ω × d), with α from
    /// Euler's equations.
    pub fn acceleration_at(&self, arm: SpatialVector) -> SpatialVector {
        let (motion, [linear, angular]) = (self.motion_in_contact(), self.accelerations());
        let turning = cross(motion.turning, cross(motion.turning, arm));
        plus(plus(linear, 1.0, cross(angular, arm)), 1.0, turning)
    }

    /// Returns the acceleration of the centre of mass and the angular acceleration: L' = M, with ω = L/I_t + (1/I_a -
    /// 1/I_t) (L . e) e and e' = ω × e.
    pub fn accelerations(&self) -> [SpatialVector; 2] {
        let axis = self.attitude.axis();
        let turning = self.motion_in_contact().turning;
        let mut total = self.total;
        total.add(&self.contact.0);
        let difference = 1.0 / self.inertia.axial - 1.0 / self.inertia.transverse;
        let moving = cross(turning, axis);
        let of_moment = self.inertia.angular_velocity(axis, total.moment);
        let carried = dot(self.momentum, moving);
        let angular = plus(plus(of_moment, difference * carried, axis), difference * dot(self.momentum, axis), moving);
        [total.force.inline_map(|f| f / self.mass), angular]
    }

    /// Returns the accelerations by forces and moments: linear, and angular as for a body without spin.
    pub fn kicks(&self) -> [SpatialVector; 2] {
        [self.total.force.inline_map(|f| f / self.mass), self.total.moment.inline_map(|m| m / self.inertia.transverse)]
    }

    /// Returns bounds over all points of the acceleration and of its change since the previous instant.
    pub fn acceleration_and_change(&self) -> [f64; 2] {
        let size = |[linear, angular]: [SpatialVector; 2]| norm(linear) + self.size * norm(angular);
        let ([linear, angular], [old_linear, old_angular]) = (self.kicks(), self.previous_kicks);
        [size([linear, angular]), size([plus(linear, -1.0, old_linear), plus(angular, -1.0, old_angular)])]
    }

    /// Returns the total yaw angle between the velocity and the body axis (in the direction of flight), radians.
    pub fn yaw(&self) -> f64 {
        let total = angle(self.attitude.axis(), self.velocity);
        if norm(self.velocity) == 0.0 { 0.0 } else { total.min(std::f64::consts::PI - total) }
    }

    /// Returns the tilt angle between the body axis and direction 2, its direction in the mesh, radians.
    pub fn tilt(&self) -> f64 {
        angle(self.attitude.axis(), [0.0, 1.0, 0.0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn point_velocity_and_acceleration_match_finite_differences() {
        let inertia = PrincipalInertia { axial: 1.0, transverse: 3.0 };
        let attitude = Attitude::turned([0.2, 0.0, -0.4]);
        let turning = [0.3, -2.0, 0.9];
        let momentum = inertia.momentum(attitude.axis(), turning);
        let body =
            RigidBody3d { mass: 2.0, inertia, attitude, momentum, velocity: [1.0, 2.0, 3.0], ..RigidBody3d::default() };
        let point = [0.7, -0.3];
        let dt = 1e-6;
        let mut later = body.clone();
        later.centre = plus(later.centre, dt, later.velocity);
        later.attitude = inertia.free_motion(attitude, momentum, dt);
        let expected = plus(later.place(point, 0.8), -1.0, body.place(point, 0.8)).map(|x| x / dt);
        assert!(norm(plus(body.velocity_at(body.arm(point, 0.8)), -1.0, expected)) < 1e-5);
        let change = plus(later.velocity_at(later.arm(point, 0.8)), -1.0, body.velocity_at(body.arm(point, 0.8)));
        assert!(norm(plus(body.acceleration_at(body.arm(point, 0.8)), -1.0 / dt, change)) < 1e-4);
    }
}
