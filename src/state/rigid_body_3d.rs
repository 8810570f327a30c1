//! The six degrees of freedom of a rigid body that translates and rotates in space: central differences of its centre of mass and
//! of its angular momentum, with the exact free motion of a symmetric top between their kicks (Strang splitting, second order).
//! Only bodies whose impact is oblique have them; directions are 1, 2, 3 of `kernel::attitude`.
//! Never here: which forces act, the length of an increment.

use super::archive::{Archive, Persist, persist_struct};
use crate::kernel::attitude::{Attitude, Inertia, Vector, angle, cross, dot, norm, plus, times};
use crate::kernel::lanes::InlineMap;

/// Speed at which the resistance on a body at rest is evaluated, as a part of its largest speed so far: the direction in which the
/// body would start to move is what matters.
const PROBE: f64 = 1e-9;

/// A force at the centre of mass and a moment about it, in the world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wrench {
    pub force: Vector,
    pub moment: Vector,
}

impl Wrench {
    /// A force at a point `arm` away from the centre of mass.
    pub fn at(arm: Vector, force: Vector) -> Wrench {
        Wrench { force, moment: cross(arm, force) }
    }

    pub fn add(&mut self, other: &Wrench) {
        self.force = plus(self.force, 1.0, other.force);
        self.moment = plus(self.moment, 1.0, other.moment);
    }

    /// The wrench whose components along and about 1, 2, 3 are generalised forces.
    pub fn of(components: [f64; 6]) -> Wrench {
        let [f1, f2, f3, m1, m2, m3] = components;
        Wrench { force: [f1, f2, f3], moment: [m1, m2, m3] }
    }

    /// Its components along and about 1, 2, 3.
    pub fn components(&self) -> [f64; 6] {
        let ([f1, f2, f3], [m1, m2, m3]) = (self.force, self.moment);
        [f1, f2, f3, m1, m2, m3]
    }

    /// Power at a velocity of the centre of mass and an angular velocity.
    pub fn power(&self, motion: &Motion) -> f64 {
        dot(self.force, motion.velocity) + dot(self.moment, motion.turning)
    }

    /// Whether all components are finite numbers.
    pub fn is_finite(&self) -> bool {
        (norm(self.force) + norm(self.moment)).is_finite()
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

/// Position, attitude, velocity and angular momentum at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Centre of mass.
    pub centre: Vector,
    pub attitude: Attitude,
    /// Velocity and angular momentum.
    pub moving: [Vector; 2],
}

/// Motion of one point of a body, for output; vectors along and about 1, 2, 3.
#[derive(Clone, Copy, Debug)]
pub struct PointMotion {
    /// Current position.
    pub place: Vector,
    /// Displacement since the start of the analysis.
    pub displacement: Vector,
    pub velocity: Vector,
    pub acceleration: Vector,
    /// Rotation vector of the body since the start of the analysis.
    pub rotation: Vector,
    /// Angular velocity of the body.
    pub rotational_velocity: Vector,
    /// Angular acceleration of the body.
    pub rotational_acceleration: Vector,
    /// Angle between the axis of the body and its velocity, radians.
    pub yaw: f64,
    /// Angle between the axis of the body and direction 2, radians.
    pub tilt: f64,
}

/// A rigid body with six degrees of freedom.
#[derive(Clone, Debug, Default)]
pub struct RigidBody3d {
    pub mass: f64,
    /// Moments of inertia about the centre of mass.
    pub inertia: Inertia,
    /// Height of the centre of mass on the axis where the mesh has the body, and of its reference node.
    pub heights: [f64; 2],
    /// Largest distance of a node from the centre of mass.
    pub size: f64,
    /// Pose at the start of the analysis.
    pub start: Pose,
    /// Stations around its axis, in loads, contact and frames.
    pub stations: usize,
    /// Centre of mass.
    pub centre: Vector,
    pub attitude: Attitude,
    /// Velocity of the centre of mass at the instant's own time.
    pub velocity: Vector,
    /// Angular momentum about the centre of mass, likewise.
    pub momentum: Vector,
    /// Velocity and angular momentum at the middle of the previous increment.
    pub half: [Vector; 2],
    /// The motion that loads see.
    pub shown: Motion,
    /// Sum of the forces of all effects.
    pub total: Wrench,
    /// Force of contact over the previous increment, which `total` does not hold, and half the time over which it acted on velocities.
    pub contact: (Wrench, f64),
    /// Accelerations an increment ago, as [`RigidBody3d::kicks`].
    pub previous_kicks: [Vector; 2],
    /// Pose an increment ago.
    pub previous: Pose,
    /// Largest speed of any of its points so far.
    pub fastest: f64,
    /// Displacements along and rotations about 1, 2, 3 over the previous increment, with the attitude at its start and at its end: twice
    /// the weights of the forces at both in the work.
    pub moved: [[f64; 6]; 2],
    /// Kinetic energy at the start of the increment less half the work of the forces there: what contact leaves of it, it has not lost.
    pub energy_before: f64,
    /// Whether it is at rest and held by resistances.
    pub rests: bool,
    /// Whether a resistance acts on it in this step.
    pub resisted: bool,
}

impl RigidBody3d {
    /// Velocity of the centre of mass and angular velocity now.
    pub fn motion(&self) -> Motion {
        self.motion_of(self.velocity, self.momentum)
    }

    /// Lets loads see the motion at the instant's own time, where central differences start.
    pub fn show_own_motion(&mut self) {
        self.shown = self.motion();
        self.fastest = self.fastest.max(self.speed_bound(&self.shown));
    }

    /// Lets loads see the motion a time after the middle of the previous increment.
    pub fn show_motion_after(&mut self, time: f64) {
        let [velocity, momentum] = self.half;
        let velocity = plus(velocity, time / self.mass, self.total.force);
        self.shown = self.motion_of(velocity, plus(momentum, time, self.total.moment));
    }

    /// Takes the sum of all forces; a body at rest stays there unless these do more work than resistances take. Returns whether
    /// it does.
    pub fn take_forces(&mut self, total: Wrench) -> bool {
        self.previous_kicks = self.kicks();
        self.rests = self.rests && self.resisted && total.power(&self.shown) <= 0.0;
        self.total = if self.rests { Wrench::default() } else { total };
        self.rests
    }

    /// Lets resistances see in which direction a body at rest would move under the other forces.
    pub fn probe(&mut self, applied: &Wrench) {
        let turning = self.inertia.angular_velocity(self.attitude.axis(), applied.moment);
        let motion = Motion { velocity: times(1.0 / self.mass, applied.force), turning };
        let speed = self.speed_bound(&motion);
        let factor = if speed > 0.0 { PROBE * self.fastest.max(1e-3) / speed } else { 0.0 };
        self.shown = Motion { velocity: times(factor, motion.velocity), turning: times(factor, motion.turning) };
    }

    /// Completes velocity and angular momentum at the instant's own time, `dt` after the previous one.
    pub fn complete_velocity(&mut self, dt: f64) {
        let [velocity, momentum] = self.half;
        self.velocity = plus(velocity, 0.5 * dt / self.mass, self.total.force);
        self.momentum = plus(momentum, 0.5 * dt, self.total.moment);
    }

    /// Its pose, with velocity and angular momentum at the instant's own time.
    pub fn pose(&self) -> Pose {
        Pose { centre: self.centre, attitude: self.attitude, moving: [self.velocity, self.momentum] }
    }

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

    /// Moves from the pose at the start of the increment with velocity and angular momentum of its middle.
    pub fn move_freely(&mut self, dt: f64) {
        let [velocity, momentum] = self.half;
        let moved = |body: &RigidBody3d| {
            let Motion { velocity, turning } = body.motion_of(velocity, momentum);
            Wrench { force: velocity, moment: turning }.components().inline_map(|rate| dt * rate)
        };
        self.attitude = self.previous.attitude;
        let first = moved(self);
        self.centre = plus(self.previous.centre, dt, velocity);
        self.attitude = self.inertia.free_motion(self.attitude, momentum, dt);
        self.moved = [first, moved(self)];
    }

    /// Energy that contact has taken in the increment, since it was asked last. With velocities v of the middle of increments and
    /// kinetic energies 1/2 v m v' of both around an instant (as in [`RigidBody3d::kinetic`]) it is what 1/2 v m v less half the work
    /// of the forces at the start of the increment loses.
    pub fn take_lost_energy(&mut self) -> f64 {
        let [velocity, momentum] = self.half;
        let kinetic = 0.5 * self.mass * dot(velocity, velocity) + self.inertia.energy(self.attitude.axis(), momentum);
        let forces = self.total.components().into_iter().zip(self.moved[0]);
        let now = kinetic - 0.5 * forces.map(|(force, moved)| force * moved).sum::<f64>();
        std::mem::replace(&mut self.energy_before, now) - now
    }

    /// Work over the previous increment of a generalised force at its start and at its end, by the trapezoid.
    pub fn work(&self, coordinate: usize, [before, now]: [f64; 2]) -> f64 {
        0.5 * (before * self.moved[0][coordinate] + now * self.moved[1][coordinate])
    }

    /// Restores the previous instant.
    pub fn step_back(&mut self) {
        let Pose { centre, attitude, moving: [velocity, momentum] } = self.previous;
        (self.centre, self.attitude, self.velocity, self.momentum) = (centre, attitude, velocity, momentum);
    }

    /// Time until it comes to rest, where that is less than 1.25 `increment`: its kinetic energy T is spent at the power P of all forces
    /// as under even deceleration after 2T/|P|, which of a body without rotation is v/|a|; at the end of its motion the forces oppose
    /// what is left of it. Below the part `slow` of its largest speed, where resistances are in proportion to the velocity, the
    /// increment ends at rest.
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

    /// Kinetic energy that the impulse of contact in the previous increment takes from a body at rest.
    pub fn energy_stopped(&self) -> f64 {
        let (Wrench { force, .. }, time) = self.contact;
        let impulse = 2.0 * time * norm(force);
        0.5 * impulse * impulse / self.mass
    }

    pub fn arrest(&mut self) {
        (self.velocity, self.momentum, self.rests) = ([0.0; 3], [0.0; 3], true);
    }

    /// Motion of a point whose place in the mesh is `[r, z]`, turned around the axis by an angle.
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

    /// Displacement, velocity and acceleration of the reference node along 2.
    pub fn along_axis_2(&self) -> [f64; 3] {
        let [centre, reference] = self.heights;
        let (arm, start) = (times(reference - centre, self.attitude.axis()), self.start.attitude.axis());
        let displacement = plus(plus(self.centre, 1.0, arm), -1.0, plus(self.start.centre, reference - centre, start));
        [displacement[1], self.velocity_at(arm)[1], self.acceleration_at(arm)[1]]
    }

    /// The motion with a velocity and an angular momentum at the attitude now.
    pub fn motion_of(&self, velocity: Vector, momentum: Vector) -> Motion {
        Motion { velocity, turning: self.inertia.angular_velocity(self.attitude.axis(), momentum) }
    }

    /// The largest speed that any of its points can have in a motion.
    pub fn speed_bound(&self, motion: &Motion) -> f64 {
        norm(motion.velocity) + self.size * norm(motion.turning)
    }

    /// Kinetic energy, of rotation too. In contact it follows from the velocities before and behind the instant without the next
    /// impulse of contact, as that of a body along z does.
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

    /// The motion at the instant's own time with contact as over the previous increment.
    pub fn motion_in_contact(&self) -> Motion {
        let (Wrench { force, moment }, time) = self.contact;
        self.motion_of(plus(self.velocity, time / self.mass, force), plus(self.momentum, time, moment))
    }

    /// Velocity of a point that far from the centre of mass.
    pub fn velocity_at(&self, arm: Vector) -> Vector {
        let motion = self.motion_in_contact();
        plus(motion.velocity, 1.0, cross(motion.turning, arm))
    }

    /// Acceleration of a point that far from the centre of mass: a + alpha x d + omega x (omega x d). Euler's equations give alpha.
    pub fn acceleration_at(&self, arm: Vector) -> Vector {
        let (motion, [linear, angular]) = (self.motion_in_contact(), self.accelerations());
        let turning = cross(motion.turning, cross(motion.turning, arm));
        plus(plus(linear, 1.0, cross(angular, arm)), 1.0, turning)
    }

    /// Acceleration of the centre of mass, and angular acceleration: L' = M, with omega = L/I_t + (1/I_a - 1/I_t) (L . e) e and
    /// e' = omega x e.
    pub fn accelerations(&self) -> [Vector; 2] {
        let axis = self.attitude.axis();
        let turning = self.motion_in_contact().turning;
        let mut total = self.total;
        total.add(&self.contact.0);
        let difference = 1.0 / self.inertia.axial - 1.0 / self.inertia.transverse;
        let moving = cross(turning, axis);
        let own = self.inertia.angular_velocity(axis, total.moment);
        let carried = dot(self.momentum, moving);
        let angular = plus(plus(own, difference * carried, axis), difference * dot(self.momentum, axis), moving);
        [total.force.inline_map(|f| f / self.mass), angular]
    }

    /// What forces and moments give to velocity and angular velocity a time, the latter as of a body without spin.
    pub fn kicks(&self) -> [Vector; 2] {
        [self.total.force.inline_map(|f| f / self.mass), self.total.moment.inline_map(|m| m / self.inertia.transverse)]
    }

    /// Bounds over all points of the acceleration and of its change since the previous instant.
    pub fn acceleration_and_change(&self) -> [f64; 2] {
        let size = |[linear, angular]: [Vector; 2]| norm(linear) + self.size * norm(angular);
        let ([linear, angular], [old_linear, old_angular]) = (self.kicks(), self.previous_kicks);
        [size([linear, angular]), size([plus(linear, -1.0, old_linear), plus(angular, -1.0, old_angular)])]
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

persist_struct!(Motion { velocity, turning });

persist_struct!(Pose { centre, attitude, moving });

persist_struct!(Wrench { force, moment });

// From the plan and the beginning of a step.
// Of an increment alone.
persist_struct!(RigidBody3d {
    centre, attitude, velocity, momentum, half, shown, total, contact, previous_kicks, previous, fastest, moved, rests
} derived {
    mass, inertia, heights, size, start, stations, resisted, energy_before
});

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_body_shows_the_velocity_of_its_points() {
        let inertia = Inertia { axial: 1.0, transverse: 3.0 };
        let attitude = Attitude::turned([0.2, 0.0, -0.4]);
        let turning = [0.3, -2.0, 0.9];
        let momentum = inertia.momentum(attitude.axis(), turning);
        let body =
            RigidBody3d { mass: 2.0, inertia, attitude, momentum, velocity: [1.0, 2.0, 3.0], ..RigidBody3d::default() };
        let place = [0.7, -0.3];
        let dt = 1e-6;
        let mut later = body.clone();
        later.centre = plus(later.centre, dt, later.velocity);
        later.attitude = inertia.free_motion(attitude, momentum, dt);
        let expected = plus(later.place(place, 0.8), -1.0, body.place(place, 0.8)).map(|x| x / dt);
        assert!(norm(plus(body.velocity_at(body.arm(place, 0.8)), -1.0, expected)) < 1e-5);
        let change = plus(later.velocity_at(later.arm(place, 0.8)), -1.0, body.velocity_at(body.arm(place, 0.8)));
        assert!(norm(plus(body.acceleration_at(body.arm(place, 0.8)), -1.0 / dt, change)) < 1e-4);
    }
}
