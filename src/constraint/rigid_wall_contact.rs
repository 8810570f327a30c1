//! Contact of a rigid body in space with a fixed analytical surface of revolution: hard, without restitution, with Coulomb friction.
//! Rings that points of the body's meridian make around its axis may not pass the surface where the increment ends; the impulses that
//! see to it act where and as the surfaces touch at its start (constrained central differences, Ryckaert, Ciccotti and Berendsen
//! 1977, J. Comput. Phys. 23, 327), and are found by projected Gauss-Seidel sweeps over the points (Moreau 1988, in Nonsmooth
//! Mechanics and Applications, CISM Courses 302; Jean 1999, Comput. Methods Appl. Mech. Eng. 177, 235).
//! Never here: deformable bodies, surfaces that move.

use crate::kernel::lanes::{InlineMap, inline_from_fn};
use std::f64::consts::PI;

use super::contact::curve::Carrier;
use super::{Constraint, ConstraintView, ContactResults, StoredConstraint};
use crate::kernel::attitude::{Vector, cross, dot, norm, plus, times};
use crate::kernel::interaction::Friction;
use crate::kernel::lists::MemoryUse;
use crate::kernel::profile::Profile;
use crate::platform::PortableMath as _;
use crate::state::EffectId;
use crate::state::archive::persist_struct;
use crate::state::dofs::Dofs;
use crate::state::limit::Limit;
use crate::state::magnitude::Clock;
use crate::state::rigid_body_3d::{Motion, Pose, RigidBody3d, Wrench};
use crate::variables::{Part, Variable};

/// Stations of a ring that count beside its deepest point: what lies flat on a plane is held by these.
const MOST_STATIONS: usize = 16;
/// Steps to the deepest point of a ring; on a plane the first is exact.
const DEEPEST: usize = 3;
/// Rounds in which gaps are measured anew where impulses have moved and turned the body.
const ROUNDS: usize = 4;
/// Sweeps over the points in a round, and the change of an impulse, over the largest one, at which they end.
const SWEEPS: usize = 500;
const CONVERGED: f64 = 1e-12;

/// Two surfaces, and how they interact.
#[derive(Clone, Debug)]
pub struct WallPair {
    pub id: EffectId,
    /// Its number among the pairs of all steps.
    pub number: usize,
    /// Whether the surface of the moving body is the first one of the pair.
    pub first: bool,
    /// The body, and the one that holds the wall.
    pub bodies: [usize; 2],
    pub friction: Friction,
}

/// A place of the body in front of the wall.
#[derive(Clone, Copy, Debug)]
struct Touch {
    /// Signed distance from the wall.
    gap: f64,
    normal: Vector,
    /// From the centre of mass.
    arm: Vector,
}

/// A point of the body that may touch the wall: a station of a ring, or the deepest point of one, wherever that lies.
#[derive(Clone, Copy, Debug, Default)]
struct ContactPoint {
    ring: usize,
    station: Option<usize>,
    /// From the centre of mass, where the increment begins.
    arm: Vector,
    /// Normal of the wall there, and two directions along it.
    axes: [Vector; 3],
    /// Depth behind the wall where the increment begins: the point goes no deeper.
    depth: f64,
    /// Gap where the increment ends, for the velocity `rate` along the normal.
    gap: f64,
    rate: f64,
    /// One over the mass that an impulse along each axis accelerates.
    inverse_mass: [f64; 3],
    /// Impulses along the axes.
    impulse: [f64; 3],
}

impl ContactPoint {
    /// With where the surfaces touch at the start, and the gap at the end of the motion without contact.
    fn complete(self, body: &RigidBody3d, start: Touch, gap: f64) -> ContactPoint {
        let (arm, depth) = (start.arm, (-start.gap).max(0.0));
        let axes = basis(start.normal);
        let axis = body.attitude.axis();
        let inverse_mass = axes.inline_map(|direction| {
            let lever = cross(arm, direction);
            1.0 / body.mass + dot(lever, body.inertia.angular_velocity(axis, lever))
        });
        let point = ContactPoint { arm, axes, depth, gap: gap + depth, inverse_mass, ..self };
        let motion = body.motion_of(body.half[0], body.half[1]);
        ContactPoint { rate: dot(axes[0], point.velocity(&motion)), ..point }
    }

    fn impulses(&self) -> [Vector; 2] {
        let along = |axes: &[Vector], sizes: &[f64]| {
            axes.iter().zip(sizes).fold([0.0; 3], |sum, (axis, size)| plus(sum, *size, *axis))
        };
        [along(&self.axes[..1], &self.impulse[..1]), along(&self.axes[1..], &self.impulse[1..])]
    }

    fn velocity(&self, motion: &Motion) -> Vector {
        plus(motion.velocity, 1.0, cross(motion.turning, self.arm))
    }
}

/// Contact of one body with one wall over a step.
#[derive(Clone, Debug)]
pub struct RigidWallContact {
    pair: WallPair,
    profile: Profile,
    /// Places of the meridian's points, `[r, z]` from the centre of mass.
    rings: Vec<[f64; 2]>,
    /// Cosines and sines of the stations' angles.
    stations: Vec<[f64; 2]>,
    /// Largest part of the body's size by which its points may move in an increment.
    travel: f64,
    points: Vec<ContactPoint>,
    /// Forces of pressure and of friction over the previous increment.
    forces: [Vector; 2],
    longest: f64,
    previous_dt: f64,
}

impl RigidWallContact {
    /// The contact of a pair, of points of a meridian `[r, z]` from the centre of mass; the wall's front is to the left of the profile.
    pub fn new(pair: WallPair, profile: Profile, rings: Vec<[f64; 2]>, stations: usize, travel: f64) -> Self {
        let count = stations.min(MOST_STATIONS);
        let around = |k: usize| libm::sincos(2.0 * PI * k as f64 / count as f64);
        let stations: Vec<[f64; 2]> = (0..count).map(around).map(|(sine, cosine)| [cosine, sine]).collect();
        let points = Vec::with_capacity(rings.len() * (count + 1));
        let (forces, longest) = ([[0.0; 3]; 2], f64::INFINITY);
        RigidWallContact { pair, profile, rings, stations, travel, points, forces, longest, previous_dt: 0.0 }
    }

    /// Signed distance of a place in space from the wall, and the wall's normal there; `None` beyond its edges.
    fn gap(&self, [x, y, z]: Vector) -> Option<(f64, Vector)> {
        let r = x.portable_hypot(z);
        let nearest = self.profile.nearest([r, y], 0.0);
        let [n_r, n_z] = self.profile.segments[nearest.segment].normal([r, y], 0.0);
        let [c, s] = if r > 0.0 { [x / r, z / r] } else { [1.0, 0.0] };
        (!nearest.beyond).then_some((nearest.gap, [n_r * c, n_z, n_r * s]))
    }

    /// A point of the body, given in its frame.
    fn touch(&self, pose: &Pose, own: Vector) -> Option<Touch> {
        let arm = pose.attitude.to_world(own);
        let (gap, normal) = self.gap(plus(pose.centre, 1.0, arm))?;
        Some(Touch { gap, normal, arm })
    }

    fn station(&self, ring: usize, k: usize) -> Vector {
        let ([r, z], [c, s]) = (self.rings[ring], self.stations[k]);
        [r * c, z, r * s]
    }

    /// Stations of a ring that are not one point.
    fn count(&self, ring: usize) -> usize {
        if self.rings[ring][0] == 0.0 { 1 } else { self.stations.len() }
    }

    /// The deepest point of a ring, from its deepest station on: each step goes to that in front of the plane that touches the wall.
    fn deepest(&self, pose: &Pose, ring: usize) -> Option<Touch> {
        let stations = (0..self.count(ring)).filter_map(|k| self.touch(pose, self.station(ring, k)));
        let mut best = stations.min_by(|a, b| a.gap.total_cmp(&b.gap))?;
        let [r, z] = self.rings[ring];
        for _ in 0..DEEPEST {
            let normal = pose.attitude.to_body(best.normal);
            let across = normal[0].portable_hypot(normal[2]);
            let own = [-r * normal[0] / across, z, -r * normal[2] / across];
            match self.touch(pose, own).filter(|_| across > 0.0).filter(|touch| touch.gap < best.gap) {
                Some(deeper) => best = deeper,
                None => break,
            }
        }
        Some(best)
    }

    fn measure(&self, point: &ContactPoint, pose: &Pose) -> Option<Touch> {
        match point.station {
            Some(k) => self.touch(pose, self.station(point.ring, k)),
            None => self.deepest(pose, point.ring),
        }
    }

    /// Looks for points that come closer than `reach` where the increment ends.
    fn find_points(&mut self, body: &RigidBody3d, reach: f64) {
        let end = body.pose();
        let mut points = std::mem::take(&mut self.points);
        for ring in 0..self.rings.len() {
            let all = (0..self.count(ring)).map(Some).chain([None]);
            for station in all {
                let point = ContactPoint { ring, station, ..ContactPoint::default() };
                let Some(touch) = self.measure(&point, &end).filter(|touch| touch.gap < reach) else { continue };
                let start = self.measure(&point, &body.previous).unwrap_or(touch);
                points.push(point.complete(body, start, touch.gap));
            }
        }
        self.points = points;
    }

    /// Impulses on all points, and the velocities that they come to. Returns whether they press at all.
    fn solve(&mut self, body: &RigidBody3d, motion: &mut Motion, dt: f64) -> bool {
        let axis = body.attitude.axis();
        for _ in 0..SWEEPS {
            let (mut change, mut largest) = (0.0_f64, 0.0_f64);
            for point in &mut self.points {
                let old = point.impulse;
                let velocity = point.velocity(motion);
                let rate = dot(point.axes[0], velocity);
                let missing = point.gap / dt + (rate - point.rate);
                point.impulse[0] = (old[0] - missing / point.inverse_mass[0]).max(0.0);
                point.rub(&self.pair.friction, velocity);
                let given: [f64; 3] = inline_from_fn(|i| point.impulse[i] - old[i]);
                let impulse = (0..3).fold([0.0; 3], |sum, i| plus(sum, given[i], point.axes[i]));
                motion.velocity = plus(motion.velocity, 1.0 / body.mass, impulse);
                let turned = body.inertia.angular_velocity(axis, cross(point.arm, impulse));
                motion.turning = plus(motion.turning, 1.0, turned);
                change = given.iter().fold(change, |most, d| most.max(d.abs()));
                largest = largest.max(point.impulse[0]);
            }
            if change <= CONVERGED * largest {
                return largest > 0.0;
            }
        }
        true
    }

    /// Gaps anew, where the body ends with its impulses.
    fn measure_again(&mut self, body: &RigidBody3d, motion: &Motion) {
        let mut points = std::mem::take(&mut self.points);
        let end = body.pose();
        for point in points.iter_mut().filter(|p| p.impulse[0] > 0.0) {
            if let Some(touch) = self.measure(point, &end) {
                (point.gap, point.rate) = (touch.gap + point.depth, dot(point.axes[0], point.velocity(motion)));
            }
        }
        self.points = points;
    }

    /// Moves the body with what points do to it; returns whether any touches.
    fn collide(&mut self, body: &mut RigidBody3d, dt: f64) -> bool {
        let free = body.half;
        for _ in 0..ROUNDS {
            let mut motion = body.motion_of(body.half[0], body.half[1]);
            if !self.solve(body, &mut motion, dt) {
                break;
            }
            let sum = self.sum();
            body.half = [plus(free[0], 1.0 / body.mass, sum.force), plus(free[1], 1.0, sum.moment)];
            let attitude = body.attitude;
            body.move_freely(dt);
            self.measure_again(body, &motion);
            // Arms and masses stay those of the motion without contact.
            body.attitude = attitude;
        }
        let touches = self.points.iter().any(|p| p.impulse[0] > 0.0);
        if touches {
            body.move_freely(dt);
        }
        touches
    }

    /// All impulses about the centre of mass.
    fn sum(&self) -> Wrench {
        let mut sum = Wrench::default();
        for point in &self.points {
            point.impulses().into_iter().for_each(|impulse| sum.add(&Wrench::at(point.arm, impulse)));
        }
        sum
    }

    /// What contact and friction took of the energy: by friction its impulses times the mean velocity along the wall, all of it by the
    /// balance of the body.
    fn losses(&self, body: &mut RigidBody3d, free: &Motion) -> [f64; 2] {
        let motion = body.motion_of(body.half[0], body.half[1]);
        let mut friction = 0.0;
        for point in &self.points {
            let mean = times(0.5, plus(point.velocity(free), 1.0, point.velocity(&motion)));
            friction -= dot(point.impulses()[1], mean);
        }
        [body.take_lost_energy() - friction, friction]
    }

    /// How long an increment may be with these velocities: to the wall, and a part of the body's size beyond.
    fn look_ahead(&self, body: &RigidBody3d, [velocity, momentum]: [Vector; 2]) -> f64 {
        let speed = body.speed_bound(&body.motion_of(velocity, momentum));
        let distance = (self.distance(body) - body.size).max(0.0) + self.travel * body.size;
        if speed > 0.0 { distance / speed } else { f64::INFINITY }
    }

    /// Distance of the centre of mass from the wall.
    fn distance(&self, body: &RigidBody3d) -> f64 {
        let [x, y, z] = body.centre;
        self.profile.nearest([x.portable_hypot(z), y], 0.0).gap.abs()
    }
}

impl ContactPoint {
    /// Impulses along the wall that would stop the point there, as far as friction lets them.
    fn rub(&mut self, friction: &Friction, velocity: Vector) {
        if !friction.is_there() {
            return;
        }
        let slip = [1, 2].inline_map(|i| dot(self.axes[i], velocity));
        let inverse_mass = self.inverse_mass[1].max(self.inverse_mass[2]);
        let trial = [0, 1].inline_map(|i| self.impulse[i + 1] - slip[i] / inverse_mass);
        let (size, pressed) = (trial[0].portable_hypot(trial[1]), self.impulse[0]);
        let most = if pressed > 0.0 { friction.coefficient(slip[0].portable_hypot(slip[1])) * pressed } else { 0.0 };
        let factor = if size > most { most / size } else { 1.0 };
        (self.impulse[1], self.impulse[2]) = (factor * trial[0], factor * trial[1]);
    }
}

/// A unit vector with two across it.
fn basis(normal: Vector) -> [Vector; 3] {
    let [x, y, z] = normal.inline_map(f64::abs);
    let other = if x <= y && x <= z {
        [1.0, 0.0, 0.0]
    } else if y <= z {
        [0.0, 1.0, 0.0]
    } else {
        [0.0, 0.0, 1.0]
    };
    let across = cross(normal, other);
    let first = times(1.0 / norm(across), across);
    [normal, first, cross(normal, first)]
}

impl Constraint for RigidWallContact {
    fn effect(&self) -> EffectId {
        self.pair.id
    }

    fn begin(&mut self, dofs: &mut Dofs) {
        self.points.reserve(self.rings.len() * (self.stations.len() + 1));
        if let Some(body) = &dofs.bodies[self.pair.bodies[0]].spatial {
            self.longest = self.look_ahead(body, [body.velocity, body.momentum]);
        }
    }

    fn accelerations(&mut self, dofs: &mut Dofs, _clock: &Clock<'_>) {
        let [pressed, rubbed] = self.forces;
        dofs.bodies[self.pair.bodies[1]].reaction += pressed[1] + rubbed[1];
    }

    fn motion(&mut self, dofs: &mut Dofs, _clock: &Clock<'_>, dt: f64) {
        let half = 0.5 * (dt + std::mem::replace(&mut self.previous_dt, dt));
        let Dofs { bodies, energies, .. } = dofs;
        let Some(body) = &mut bodies[self.pair.bodies[0]].spatial else { return };
        let free = body.motion_of(body.half[0], body.half[1]);
        let reach = 2.0 * dt * body.speed_bound(&free);
        self.points.clear();
        if self.distance(body) < body.size + reach {
            self.find_points(body, reach);
        }
        if self.collide(body, dt) {
            let sum = self.sum();
            let force = Wrench { force: times(1.0 / half, sum.force), moment: times(1.0 / half, sum.moment) };
            body.contact.0.add(&force);
            body.contact.1 = 0.5 * half;
            let [contact, friction] = self.losses(body, &free);
            energies.contact += contact;
            energies.friction += friction;
        }
        self.forces =
            [0, 1].inline_map(|i| self.points.iter().fold([0.0; 3], |sum, p| plus(sum, 1.0 / half, p.impulses()[i])));
        self.longest = self.look_ahead(body, body.half);
    }

    fn max_increment(&self, _clock: &Clock<'_>) -> Limit {
        Limit { time: self.longest, jump: false }
    }

    fn view(&self) -> ConstraintView<'_> {
        ConstraintView { contact: Some(self), ..ConstraintView::default() }
    }
}

impl ContactResults for RigidWallContact {
    fn value_at_point(&self, _carrier: Carrier, _part: Part) -> Option<f64> {
        None
    }

    fn value_of_pair(&self, pair: usize, part: Part) -> Option<f64> {
        if pair != self.pair.number {
            return None;
        }
        let sign = if self.pair.first { 1.0 } else { -1.0 };
        let [pressed, rubbed] = self.forces;
        let all = plus(pressed, 1.0, rubbed);
        match part.variable {
            Variable::NormalContactForce => Some(sign * pressed[part.component]),
            Variable::ShearContactForce => Some(sign * rubbed[part.component]),
            Variable::ContactForce => Some(sign * all[part.component]),
            Variable::NormalContactMagnitude => Some(norm(pressed)),
            Variable::ShearContactMagnitude => Some(norm(rubbed)),
            Variable::ContactMagnitude => Some(norm(all)),
            _ => None,
        }
    }
}

impl StoredConstraint for RigidWallContact {
    fn memory(&self) -> MemoryUse {
        MemoryUse::of(&self.points) + MemoryUse::of(&self.rings) + MemoryUse::of(&self.stations)
    }
}

persist_struct!(RigidWallContact {
    forces, longest, previous_dt
} derived {
    pair, profile, rings, stations, travel, points
});
