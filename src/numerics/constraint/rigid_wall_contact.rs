//! Contact of a rigid body with six degrees of freedom and a fixed analytical surface of revolution: hard, without
//! restitution, with Coulomb friction. The meridian points of the body form rings around its axis. They must not pass
//! the surface at the end of the increment. The impulses act at the contact points at its start (constrained central
//! differences, Ryckaert, Ciccotti and Berendsen 1977, J. Comput. Phys. 23, 327) and are computed by projected
//! Gauss-Seidel sweeps over the points (Moreau 1988, in Nonsmooth Mechanics and Applications, CISM Courses 302; Jean
//! 1999, Comput. Methods Appl. Mech. Eng. 177, 235).

use crate::kernel::lanes::{InlineMap, inline_from_fn};
use std::f64::consts::PI;

use super::{Constraint, ConstraintForces, PairForces, StoredConstraint};
use crate::kernel::attitude::{SpatialVector, cross, dot, norm, plus, times};
use crate::kernel::interaction::CoulombFriction;
use crate::kernel::lists::Memory;
use crate::kernel::profile::SurfaceProfile;
use crate::platform::PortableMath as _;
use crate::state::EffectId;
use crate::state::archive::Persist;
use crate::state::dofs::{Dof, Dofs};
use crate::state::limit::IncrementLimit;
use crate::state::magnitude::AmplitudeClock;
use crate::state::rigid_body_3d::{Pose, RigidBody3d, RigidMotion, Wrench};

/// Largest number of stations of a ring that are checked in addition to its deepest point, so that a flat contact on a
/// plane is stable.
const MOST_STATIONS: usize = 16;
/// Iterations for the deepest point of a ring; on a plane the first one is exact.
const DEEPEST: usize = 3;
/// Largest number of gap updates after impulses have moved and turned the body.
const ROUNDS: usize = 4;
/// Largest number of sweeps over the points for each gap update.
const SWEEPS: usize = 500;
/// Change of an impulse at convergence, relative to the largest impulse.
const CONVERGED: f64 = 1e-12;

/// The two surfaces and their friction law.
#[derive(Clone, Debug)]
pub struct WallPair {
    /// Row of the ledger.
    pub id: EffectId,
    /// Number among the pairs of all steps.
    pub number: usize,
    /// Whether the surface of the moving body is the first one of the pair.
    pub first: bool,
    /// Indices of the moving body and of the body of the wall.
    pub bodies: [usize; 2],
    /// Friction between body and wall.
    pub friction: CoulombFriction,
}

/// Position of a body point relative to the wall.
#[derive(Clone, Copy, Debug)]
struct WallDistance {
    /// Signed distance from the wall.
    gap: f64,
    normal: SpatialVector,
    /// Vector from the centre of mass.
    arm: SpatialVector,
}

/// A point of the body that may touch the wall: a station of a ring, or the deepest point of a ring (`station` is
/// `None`).
#[derive(Clone, Copy, Debug, Default)]
struct ContactPoint {
    ring: usize,
    station: Option<usize>,
    /// Vector from the centre of mass at the start of the increment.
    arm: SpatialVector,
    /// Normal of the wall and two tangents.
    axes: [SpatialVector; 3],
    /// Overlap at the start of the increment, which must not grow.
    depth: f64,
    /// Gap at the end of the increment, for the velocity `rate` along the normal.
    gap: f64,
    rate: f64,
    /// Inverse effective mass along each axis.
    inverse_mass: [f64; 3],
    /// Contact impulses on the body along axes 1, 2 and 3.
    impulse: [f64; 3],
}

impl ContactPoint {
    /// Completes the point with the contact geometry at the start and the gap at the end of the motion without contact.
    /// Equation (13.7).
    fn complete(self, body: &RigidBody3d, start: WallDistance, gap: f64) -> ContactPoint {
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

    fn impulses(&self) -> [SpatialVector; 2] {
        let along = |axes: &[SpatialVector], sizes: &[f64]| {
            axes.iter().zip(sizes).fold([0.0; 3], |sum, (axis, size)| plus(sum, *size, *axis))
        };
        [along(&self.axes[..1], &self.impulse[..1]), along(&self.axes[1..], &self.impulse[1..])]
    }

    fn velocity(&self, motion: &RigidMotion) -> SpatialVector {
        plus(motion.velocity, 1.0, cross(motion.turning, self.arm))
    }
}

/// Contact of one rigid body with one wall over a step.
#[derive(Clone, Debug, Persist, Memory)]
#[persist(derived: pair, profile, rings, stations, travel, points)]
#[memory(uncounted: pair, profile)]
pub struct RigidWallContact {
    pair: WallPair,
    profile: SurfaceProfile,
    /// Meridian points `[r, z]`, relative to the centre of mass.
    rings: Vec<[f64; 2]>,
    /// Cosines and sines of the angles of the stations.
    stations: Vec<[f64; 2]>,
    /// Largest displacement of its points in an increment, as a fraction of the body's size.
    travel: f64,
    points: Vec<ContactPoint>,
    /// Forces of pressure and of friction over the previous increment.
    forces: [SpatialVector; 2],
    /// Time over which the forces act: half of the previous and of the next increment.
    duration: f64,
    longest: f64,
    previous_dt: f64,
}

impl RigidWallContact {
    /// Creates the contact for meridian points `[r, z]` relative to the centre of mass; the contact side of the wall is
    /// to the left of its profile.
    pub fn new(pair: WallPair, profile: SurfaceProfile, rings: Vec<[f64; 2]>, stations: usize, travel: f64) -> Self {
        let count = stations.min(MOST_STATIONS);
        let around = |k: usize| libm::sincos(2.0 * PI * k as f64 / count as f64);
        let stations: Vec<[f64; 2]> = (0..count).map(around).map(|(sine, cosine)| [cosine, sine]).collect();
        let points = Vec::with_capacity(rings.len() * (count + 1));
        let (forces, longest) = ([[0.0; 3]; 2], f64::INFINITY);
        let duration = 0.0;
        RigidWallContact { pair, profile, rings, stations, travel, points, forces, duration, longest, previous_dt: 0.0 }
    }

    /// Returns the forces of a contact pair over the previous increment; `None` if it is the contact of another pair.
    pub(super) fn forces_of_pair(&self, pair: usize) -> Option<PairForces> {
        let sign = if self.pair.first { 1.0 } else { -1.0 };
        let forces = self.forces.inline_map(|force| times(sign, force));
        (pair == self.pair.number).then_some(PairForces { forces, duration: self.duration })
    }

    /// Returns signed distance and wall normal at a position in space; `None` beyond the edges of the wall.
    fn gap(&self, [x, y, z]: SpatialVector) -> Option<(f64, SpatialVector)> {
        let r = x.portable_hypot(z);
        let nearest = self.profile.nearest([r, y], 0.0);
        let [n_r, n_z] = self.profile.segments[nearest.segment].normal([r, y], 0.0);
        let [c, s] = if r > 0.0 { [x / r, z / r] } else { [1.0, 0.0] };
        (!nearest.beyond).then_some((nearest.gap, [n_r * c, n_z, n_r * s]))
    }

    /// Returns the wall distance of a point given in the frame of the body.
    fn touch(&self, pose: &Pose, own: SpatialVector) -> Option<WallDistance> {
        let arm = pose.attitude.to_world(own);
        let (gap, normal) = self.gap(plus(pose.centre, 1.0, arm))?;
        Some(WallDistance { gap, normal, arm })
    }

    fn station(&self, ring: usize, k: usize) -> SpatialVector {
        let ([r, z], [c, s]) = (self.rings[ring], self.stations[k]);
        [r * c, z, r * s]
    }

    /// Returns the number of different stations of a ring.
    fn count(&self, ring: usize) -> usize {
        if self.rings[ring][0] == 0.0 { 1 } else { self.stations.len() }
    }

    /// Returns the deepest point of a ring, starting from its deepest station. Each iteration takes the deepest point
    /// in front of the tangent plane of the wall.
    fn deepest(&self, pose: &Pose, ring: usize) -> Option<WallDistance> {
        let stations = (0..self.count(ring)).filter_map(|k| self.touch(pose, self.station(ring, k)));
        let mut best = stations.min_by(|a, b| a.gap.total_cmp(&b.gap))?;
        let [r, z] = self.rings[ring];
        for _ in 0..DEEPEST {
            let normal = pose.attitude.to_body(best.normal);
            let across = normal[0].portable_hypot(normal[2]);
            let deeper_place = [-r * normal[0] / across, z, -r * normal[2] / across];
            match self.touch(pose, deeper_place).filter(|_| across > 0.0).filter(|touch| touch.gap < best.gap) {
                Some(deeper) => best = deeper,
                None => break,
            }
        }
        Some(best)
    }

    fn measure(&self, point: &ContactPoint, pose: &Pose) -> Option<WallDistance> {
        match point.station {
            Some(k) => self.touch(pose, self.station(point.ring, k)),
            None => self.deepest(pose, point.ring),
        }
    }

    /// Finds the points with a gap below `reach` at the end of the increment.
    fn find_points(&mut self, body: &RigidBody3d, reach: f64) {
        let end = body.pose();
        let mut points = std::mem::take(&mut self.points);
        for ring in 0..self.rings.len() {
            let stations = (0..self.count(ring)).map(Some).chain([None]);
            for station in stations {
                let point = ContactPoint { ring, station, ..ContactPoint::default() };
                let Some(touch) = self.measure(&point, &end).filter(|touch| touch.gap < reach) else { continue };
                let start = self.measure(&point, &body.previous).unwrap_or(touch);
                points.push(point.complete(body, start, touch.gap));
            }
        }
        self.points = points;
    }

    /// Solves for the impulses on all points and updates the velocities. Returns whether any point is in contact.
    fn solve(&mut self, body: &RigidBody3d, motion: &mut RigidMotion, dt: f64) -> bool {
        let axis = body.attitude.axis();
        for _ in 0..SWEEPS {
            let (mut change, mut largest) = (0.0_f64, 0.0_f64);
            for point in &mut self.points {
                let old = point.impulse;
                let velocity = point.velocity(motion);
                let rate = dot(point.axes[0], velocity);
                let missing = point.gap / dt + (rate - point.rate);
                point.impulse[0] = (old[0] - missing / point.inverse_mass[0]).max(0.0);
                point.apply_friction(&self.pair.friction, velocity);
                let changes: [f64; 3] = inline_from_fn(|i| point.impulse[i] - old[i]);
                let impulse = (0..3).fold([0.0; 3], |sum, i| plus(sum, changes[i], point.axes[i]));
                motion.velocity = plus(motion.velocity, 1.0 / body.mass, impulse);
                let turned = body.inertia.angular_velocity(axis, cross(point.arm, impulse));
                motion.turning = plus(motion.turning, 1.0, turned);
                change = changes.iter().fold(change, |most, d| most.max(d.abs()));
                largest = largest.max(point.impulse[0]);
            }
            if change <= CONVERGED * largest {
                return largest > 0.0;
            }
        }
        true
    }

    /// Updates the gaps after the impulses have moved the body.
    fn measure_again(&mut self, body: &RigidBody3d, motion: &RigidMotion) {
        let mut points = std::mem::take(&mut self.points);
        let end = body.pose();
        for point in points.iter_mut().filter(|p| p.impulse[0] > 0.0) {
            if let Some(touch) = self.measure(point, &end) {
                (point.gap, point.rate) = (touch.gap + point.depth, dot(point.axes[0], point.velocity(motion)));
            }
        }
        self.points = points;
    }

    /// Applies contact to the motion of the body; returns whether any point is in contact.
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
            // Lever arms and effective masses stay those of the motion without contact.
            body.attitude = attitude;
        }
        let touches = self.points.iter().any(|p| p.impulse[0] > 0.0);
        if touches {
            body.move_freely(dt);
        }
        touches
    }

    /// Returns the sum of all impulses about the centre of mass.
    fn sum(&self) -> Wrench {
        let mut sum = Wrench::default();
        for point in &self.points {
            point.impulses().into_iter().for_each(|impulse| sum.add(&Wrench::at(point.arm, impulse)));
        }
        sum
    }

    /// Returns the energy dissipated by contact and by friction. Friction dissipates its impulses times the mean
    /// tangential velocities; the total follows from the energy of the body.
    fn losses(&self, body: &mut RigidBody3d, free: &RigidMotion) -> [f64; 2] {
        let motion = body.motion_of(body.half[0], body.half[1]);
        let mut friction = 0.0;
        for point in &self.points {
            let mean = times(0.5, plus(point.velocity(free), 1.0, point.velocity(&motion)));
            friction -= dot(point.impulses()[1], mean);
        }
        [body.take_lost_energy() - friction, friction]
    }

    /// Returns the longest increment for these velocities: the distance to the wall plus a fraction of the body's size,
    /// over the speed.
    fn look_ahead(&self, body: &RigidBody3d, [velocity, momentum]: [SpatialVector; 2]) -> f64 {
        let speed = body.speed_bound(&body.motion_of(velocity, momentum));
        let distance = (self.distance(body) - body.size).max(0.0) + self.travel * body.size;
        if speed > 0.0 { distance / speed } else { f64::INFINITY }
    }

    /// Returns the distance of the centre of mass from the wall.
    fn distance(&self, body: &RigidBody3d) -> f64 {
        let [x, y, z] = body.centre;
        self.profile.nearest([x.portable_hypot(z), y], 0.0).gap.abs()
    }
}

impl ContactPoint {
    /// Computes the tangential impulses that stop the slip, limited by friction.
    fn apply_friction(&mut self, friction: &CoulombFriction, velocity: SpatialVector) {
        if !friction.is_active() {
            return;
        }
        let slip = [1, 2].inline_map(|i| dot(self.axes[i], velocity));
        let inverse_mass = self.inverse_mass[1].max(self.inverse_mass[2]);
        let trial = [0, 1].inline_map(|i| self.impulse[i + 1] - slip[i] / inverse_mass);
        let (size, pressed) = (trial[0].portable_hypot(trial[1]), self.impulse[0]);
        let limit = if pressed > 0.0 { friction.coefficient(slip[0].portable_hypot(slip[1])) * pressed } else { 0.0 };
        let factor = if size > limit { limit / size } else { 1.0 };
        (self.impulse[1], self.impulse[2]) = (factor * trial[0], factor * trial[1]);
    }
}

/// Returns a unit vector and two unit vectors perpendicular to it.
fn basis(normal: SpatialVector) -> [SpatialVector; 3] {
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

    fn accelerations(&mut self, dofs: &mut Dofs, _clock: &AmplitudeClock<'_>) {
        let [pressed, rubbed] = self.forces;
        dofs.bodies[self.pair.bodies[1]].reaction += pressed[1] + rubbed[1];
    }

    fn motion(&mut self, dofs: &mut Dofs, _clock: &AmplitudeClock<'_>, dt: f64) {
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
        self.duration = half;
        self.longest = self.look_ahead(body, body.half);
    }

    fn max_increment(&self, _clock: &AmplitudeClock<'_>) -> IncrementLimit {
        IncrementLimit { time: self.longest, jump: false }
    }

    fn forces(&self) -> Option<&dyn ConstraintForces> {
        Some(self)
    }
}

impl ConstraintForces for RigidWallContact {
    fn index_of(&self, dof: Dof) -> Option<usize> {
        (dof == Dof::Body(self.pair.bodies[1])).then_some(0)
    }

    fn impulse(&self, _dof: Dof, _index: usize, _half: f64) -> f64 {
        let [pressed, rubbed] = self.forces;
        -self.duration * (pressed[1] + rubbed[1])
    }
}

impl StoredConstraint for RigidWallContact {}
