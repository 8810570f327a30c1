//! Contact of a rigid body with six degrees of freedom and an analytical surface of revolution that moves along 2 or is
//! fixed. The meridian points of the body form rings around its axis, which are divided into stations.
//!
//! Contact laws, friction limit, damping and the motion of the wall are those of [`super::ContactConstraint`]. Its
//! solver is not used: its rows have one direction of slip, and its gaps depend linearly on degrees of freedom, while
//! stations slip in two directions and turn with the body.
//!
//! In hard contact, points must not pass the surface at the end of the increment. The impulses act at the contact points
//! at its start (constrained central differences, Ryckaert, Ciccotti and Berendsen 1977, J. Comput. Phys. 23, 327) and
//! are computed by projected Gauss-Seidel sweeps over the points (Moreau 1988, in Nonsmooth Mechanics and Applications,
//! CISM Courses 302; Jean 1999, Comput. Methods Appl. Mech. Eng. 177, 235). In soft contact, pressures follow from the
//! overlaps at the start of the increment, and sweeps compute damping and friction. The pressures have a potential, so
//! that central differences conserve the energy.

use super::curve::{PointCarrier, SurfacePoint};
use super::dofs::ContactDofs;
use super::sweeps::{ContactInterval, ContactRow, ContactRows, TOLERANCE, dashpot, shear_limit, soft_impulse};
use super::wall_stations::{WallDistance, WallPose, WallSurfaces};
use crate::constraint::{Constraint, ConstraintForces, PairForces, StoredConstraint};
use crate::kernel::attitude::{SpatialVector, cross, dot, norm, plus, times};
use crate::kernel::interaction::{InteractionLaw, PressureOverclosure};
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::Memory;
use crate::platform::PortableMath as _;
use crate::state::EffectId;
use crate::state::archive::Persist;
use crate::state::dofs::{Dof, Dofs};
use crate::state::limit::IncrementLimit;
use crate::state::magnitude::AmplitudeClock;
use crate::state::rigid_body_3d::{RigidBody3d, RigidMotion, Wrench};

/// Largest number of gap updates after impulses have moved and turned the body.
const ROUNDS: usize = 4;
/// Largest number of sweeps over the points for each gap update.
const SWEEPS: usize = 500;
/// Change of an impulse at convergence in hard contact, relative to the largest impulse.
const CONVERGED: f64 = 1e-12;
/// Cosine below which the projection of an area in soft contact is a smooth function of the attitude: rounding errors would
/// otherwise turn an upright body, whose shank is perpendicular to the wall.
const ROUNDED: f64 = 0.01;
/// Largest squared product of frequency and increment for which pressures follow from the overlaps at the start of the
/// increment. Only fixed increments are longer; pressures then follow from the overlaps at their end.
const EXPLICIT: f64 = 1.0;

/// The two surfaces and their contact laws.
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
    /// Contact laws of the rings. All are hard, or all are soft.
    pub laws: Vec<InteractionLaw>,
}

impl WallPair {
    fn is_soft(&self) -> bool {
        self.laws.iter().any(InteractionLaw::is_soft)
    }

    fn has_springs(&self) -> bool {
        self.laws.iter().any(|law| matches!(law.overclosure, PressureOverclosure::Spring(_)))
    }
}

/// Motion of the wall in an increment without the contact.
#[derive(Clone, Copy, Debug)]
struct WallMotion {
    /// Displacements along 2 at the start and at the end.
    lifts: [f64; 2],
    velocity: f64,
    /// One over the mass; 0 if the motion is prescribed.
    inverse_mass: f64,
}

/// Velocities of the body and of the wall.
#[derive(Clone, Copy, Debug, Default)]
struct PairMotion {
    body: RigidMotion,
    /// Velocity of the wall along 2.
    wall: f64,
}

impl PairMotion {
    /// Returns the velocity of a body point relative to the wall.
    fn at(&self, arm: SpatialVector) -> SpatialVector {
        let velocity = plus(self.body.velocity, 1.0, cross(self.body.turning, arm));
        plus(velocity, -1.0, [0.0, self.wall, 0.0])
    }

    /// Adds the velocities by an impulse on the body, which acts on the wall in the opposite direction.
    fn push(&mut self, body: &RigidBody3d, wall: &WallMotion, impulse: &Wrench) {
        self.body.velocity = plus(self.body.velocity, 1.0 / body.mass, impulse.force);
        let turned = body.inertia.angular_velocity(body.attitude.axis(), impulse.moment);
        self.body.turning = plus(self.body.turning, 1.0, turned);
        self.wall -= wall.inverse_mass * impulse.force[1];
    }
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
    /// Overlap at the start of the increment, which must not grow; 0 in soft contact.
    depth: f64,
    /// Gap at the end of the increment, for the velocity `rate` along the normal.
    gap: f64,
    rate: f64,
    /// Inverse effective mass along each axis.
    inverse_mass: [f64; 3],
    /// Area, and impulse per area along the normal. In soft contact also the gap at the start of the increment.
    row: ContactRow,
    /// Impulses of friction on the body along axes 2 and 3.
    friction: [f64; 2],
    /// Impulse of the moment on the body by the change of the projected area with the attitude.
    couple: SpatialVector,
}

impl ContactPoint {
    /// Completes the point with the contact geometry at the start and the gap at the end of the motion without contact.
    /// Equation (13.7).
    fn complete(self, body: &RigidBody3d, wall: &WallMotion, start: WallDistance, gap: f64) -> ContactPoint {
        let (arm, axes) = (start.arm, basis(start.normal));
        let axis = body.attitude.axis();
        let inverse_mass = axes.inline_map(|direction| {
            let lever = cross(arm, direction);
            let of_body = 1.0 / body.mass + dot(lever, body.inertia.angular_velocity(axis, lever));
            of_body + wall.inverse_mass * direction[1] * direction[1]
        });
        ContactPoint { arm, axes, gap, inverse_mass, ..self }
    }

    /// Completes the point of hard contact: an overlap at the start must not grow.
    fn harden(mut self, start_gap: f64, free: &PairMotion) -> ContactPoint {
        self.depth = (-start_gap).max(0.0);
        self.gap += self.depth;
        self.rate = dot(self.axes[0], free.at(self.arm));
        self.row.area = 1.0;
        self
    }

    /// Completes the point of soft contact. Pressure acts on the projection of the area of the station onto the surface of
    /// the wall. The energy depends on the attitude through this projection, which adds a moment. Equation (13.8).
    fn soften(
        mut self,
        (facet_normal, area): (SpatialVector, f64),
        start_gap: f64,
        law: &PressureOverclosure,
        half: f64,
    ) -> ContactPoint {
        let [share, slope] = projection(dot(facet_normal, self.axes[0]));
        let projected = area * share;
        let stored = if start_gap < law.onset_gap() { law.energy(-start_gap) } else { 0.0 };
        self.couple = times(-half * area * stored * slope, cross(facet_normal, self.axes[0]));
        (self.row.area, self.row.gap) = (projected, projected * start_gap);
        self.row.compliance[0] = projected * projected * self.inverse_mass[0];
        self
    }

    fn normal_impulse(&self) -> f64 {
        self.row.area * self.row.normal_impulse
    }

    /// Returns the impulses of pressure and of friction.
    fn impulses(&self) -> [SpatialVector; 2] {
        let along = |axes: &[SpatialVector], sizes: &[f64]| {
            axes.iter().zip(sizes).fold([0.0; 3], |sum, (axis, size)| plus(sum, *size, *axis))
        };
        [along(&self.axes[..1], &[self.normal_impulse()]), along(&self.axes[1..], &self.friction)]
    }

    /// Computes the normal impulse: that which keeps the gap open, or that of a soft law.
    fn press(&mut self, law: &PressureOverclosure, velocity: SpatialVector, span: ContactInterval, law_dt: f64) {
        let (rate, row) = (dot(self.axes[0], velocity), &mut self.row);
        row.normal_impulse = match law {
            PressureOverclosure::Hard => {
                let missing = self.gap / span.dt + (rate - self.rate);
                (row.normal_impulse - missing / self.inverse_mass[0]).max(0.0)
            }
            soft => {
                let free_rate = row.area * rate - row.compliance[0] * row.normal_impulse;
                soft_impulse(row, soft, free_rate, ContactInterval { dt: law_dt, ..span })
            }
        };
    }

    /// Computes the tangential impulses that stop the slip, limited by friction.
    fn rub(&mut self, law: &InteractionLaw, velocity: SpatialVector, half: f64) {
        if !law.friction.is_active() {
            return;
        }
        let slip = [1, 2].inline_map(|i| dot(self.axes[i], velocity));
        let inverse_mass = self.inverse_mass[1].max(self.inverse_mass[2]);
        let trial = [0, 1].inline_map(|i| self.friction[i] - slip[i] / inverse_mass);
        self.row.coefficient = law.friction.coefficient(slip[0].portable_hypot(slip[1]));
        let limit = self.row.area * shear_limit(&self.row, law, half);
        let size = trial[0].portable_hypot(trial[1]);
        let factor = if size > limit { limit / size } else { 1.0 };
        self.friction = trial.inline_map(|impulse| factor * impulse);
    }
}

/// Contact of one rigid body with one wall over a step.
#[derive(Clone, Debug, Persist, Memory)]
#[persist(derived: pair, surfaces, travel, points)]
#[memory(uncounted: pair)]
pub struct RigidWallContact {
    pair: WallPair,
    surfaces: WallSurfaces,
    /// Largest displacement of its points in an increment, as a fraction of the body's size.
    travel: f64,
    points: Vec<ContactPoint>,
    /// The degree of freedom of the wall.
    wall: ContactDofs,
    /// Forces of pressure and of friction over the previous increment.
    forces: [SpatialVector; 2],
    /// Time over which the forces act: half of the previous and of the next increment.
    duration: f64,
    longest: f64,
    previous_dt: f64,
}

impl RigidWallContact {
    /// Creates the contact; `travel` is the largest displacement in an increment, as a fraction of the body's size.
    pub fn new(pair: WallPair, surfaces: WallSurfaces, travel: f64) -> Self {
        let carrier = PointCarrier::Body(pair.bodies[1], [0.0; 2]);
        RigidWallContact {
            points: Vec::with_capacity(surfaces.most_points()),
            wall: ContactDofs::new(&[SurfacePoint { carrier, free: [true; 2] }]),
            pair,
            surfaces,
            travel,
            forces: [[0.0; 3]; 2],
            duration: 0.0,
            longest: f64::INFINITY,
            previous_dt: 0.0,
        }
    }

    /// Returns the forces of a contact pair over the previous increment; `None` if it is the contact of another pair.
    pub fn forces_of_pair(&self, pair: usize) -> Option<PairForces> {
        let sign = if self.pair.first { 1.0 } else { -1.0 };
        let forces = self.forces.inline_map(|force| times(sign, force));
        (pair == self.pair.number).then_some(PairForces { forces, duration: self.duration })
    }

    /// Returns the projected area under pressure; NaN in hard contact, `None` if it is the contact of another pair.
    pub fn area_of_pair(&self, pair: usize) -> Option<f64> {
        let pressed = || self.points.iter().map(|point| &point.row).filter(|row| row.normal_impulse > 0.0);
        let area = || if self.pair.is_soft() { pressed().fold(0.0, |sum, row| sum + row.area) } else { f64::NAN };
        (pair == self.pair.number).then(area)
    }

    /// Finds the points with a gap below `reach` at the end of the increment.
    fn find_points(&mut self, body: &RigidBody3d, wall: &WallMotion, reach: f64, half: f64) {
        let RigidWallContact { pair, surfaces, points, .. } = self;
        let is_soft = pair.is_soft();
        let free = PairMotion { body: body.motion_of(body.half[0], body.half[1]), wall: wall.velocity };
        let start_pose = WallPose { body: body.previous, lift: wall.lifts[0] };
        let end_pose = WallPose { body: body.pose(), lift: wall.lifts[1] };
        points.clear();
        for (ring, law) in surfaces.rings.iter().map(|ring| ring.law).enumerate() {
            if is_soft && surfaces.is_far(ring, &end_pose, reach) {
                continue;
            }
            // The deepest point has no area.
            let deepest = (!is_soft).then_some(None);
            for station in (0..surfaces.count(ring)).map(Some).chain(deepest) {
                let measured = surfaces.measure(ring, station, &end_pose);
                let Some(end) = measured.filter(|end| end.gap < reach) else { continue };
                let start = surfaces.measure(ring, station, &start_pose).unwrap_or(end);
                let row = ContactRow::of(0, law as u32);
                let point = ContactPoint { ring, station, row, ..ContactPoint::default() };
                let point = point.complete(body, wall, start, end.gap);
                let Some(k) = station.filter(|_| is_soft) else {
                    points.push(point.harden(start.gap, &free));
                    continue;
                };
                let (normal, area) = surfaces.facet(ring, k);
                let facet = (body.previous.attitude.to_world(normal), area);
                let point = point.soften(facet, start.gap, &pair.laws[law].overclosure, half);
                points.extend((point.row.area > 0.0).then_some(point));
            }
        }
    }

    /// Sets the damping of soft contact. The mass per area is that which a uniform pressure on all overlapping points
    /// moves. Equation (10.15).
    fn set_dashpots(&mut self, body: &RigidBody3d, wall: &WallMotion) {
        let RigidWallContact { pair, points, .. } = self;
        if pair.laws.iter().all(|law| law.damping.is_none()) {
            return;
        }
        let overlap = |point: &ContactPoint| -point.row.gap / point.row.area;
        let mut response = PairMotion::default();
        for point in points.iter() {
            if overlap(point) > -pair.laws[point.row.law as usize].overclosure.onset_gap() {
                let force = times(point.row.area, point.axes[0]);
                response.push(body, wall, &Wrench::at(point.arm, force));
            }
        }
        for point in points {
            let rate = dot(point.axes[0], response.at(point.arm));
            let mass = || if rate > 0.0 { 1.0 / rate } else { 0.0 };
            point.row.dashpot = dashpot(&pair.laws[point.row.law as usize], overlap(point), mass);
        }
    }

    /// Returns a bound of the square of the highest frequency of soft contact, with all points that may touch the wall in
    /// the next increment.
    fn squared_frequency(&self) -> f64 {
        let stiffness = |point: &ContactPoint| {
            let [_, slope] = self.pair.laws[point.row.law as usize].overclosure.linearized(-point.gap);
            slope * point.row.area * point.inverse_mass[0]
        };
        if self.pair.is_soft() { self.points.iter().map(stiffness).sum() } else { 0.0 }
    }

    /// Solves for the impulses on all points and updates the velocities. Returns whether any point is in contact.
    fn solve(
        &mut self,
        body: &RigidBody3d,
        wall: &WallMotion,
        motion: &mut PairMotion,
        span: ContactInterval,
        law_dt: f64,
    ) -> bool {
        let tolerance = if self.pair.is_soft() { TOLERANCE } else { CONVERGED };
        for _ in 0..SWEEPS {
            let (mut change, mut largest) = (0.0_f64, 0.0_f64);
            for point in &mut self.points {
                let old = [point.normal_impulse(), point.friction[0], point.friction[1]];
                let (law, velocity) = (&self.pair.laws[point.row.law as usize], motion.at(point.arm));
                point.press(&law.overclosure, velocity, span, law_dt);
                point.rub(law, velocity, span.half);
                let new = [point.normal_impulse(), point.friction[0], point.friction[1]];
                let changes = [0, 1, 2].inline_map(|i: usize| new[i] - old[i]);
                let impulse = (0..3).fold([0.0; 3], |sum, i| plus(sum, changes[i], point.axes[i]));
                motion.push(body, wall, &Wrench::at(point.arm, impulse));
                change = changes.iter().fold(change, |most, d| most.max(d.abs()));
                largest = largest.max(new[0]);
            }
            if change <= tolerance * largest {
                return largest > 0.0;
            }
        }
        true
    }

    /// Updates the gaps after the impulses have moved the body and the wall.
    fn measure_again(&mut self, body: &RigidBody3d, lift: f64, motion: &PairMotion) {
        let end = WallPose { body: body.pose(), lift };
        for point in self.points.iter_mut().filter(|p| p.row.normal_impulse > 0.0) {
            if let Some(touch) = self.surfaces.measure(point.ring, point.station, &end) {
                (point.gap, point.rate) = (touch.gap + point.depth, dot(point.axes[0], motion.at(point.arm)));
            }
        }
    }

    /// Applies contact to the motion of the body; returns whether any point is in contact.
    fn collide(&mut self, body: &mut RigidBody3d, wall: &WallMotion, span: ContactInterval) -> bool {
        let (free, dt) = (body.half, span.dt);
        let law_dt = if self.squared_frequency() * dt * dt > EXPLICIT { dt } else { 0.0 };
        let rounds = if self.pair.is_soft() { 1 } else { ROUNDS };
        for _ in 0..rounds {
            let moment = self.points.iter().fold([0.0; 3], |sum, point| plus(sum, 1.0, point.couple));
            let pushed = wall.velocity - wall.inverse_mass * self.sum().force[1];
            let mut motion = PairMotion { body: body.motion_of(body.half[0], body.half[1]), wall: pushed };
            if self.pair.is_soft() {
                motion.push(body, wall, &Wrench { moment, ..Wrench::default() });
            }
            if !self.solve(body, wall, &mut motion, span, law_dt) {
                break;
            }
            let sum = self.sum();
            body.half = [plus(free[0], 1.0 / body.mass, sum.force), plus(free[1], 1.0, sum.moment)];
            let attitude = body.attitude;
            body.move_freely(dt);
            let lift = wall.lifts[1] + dt * (motion.wall - wall.velocity);
            self.measure_again(body, lift, &motion);
            // Lever arms and effective masses stay those of the motion without contact.
            body.attitude = attitude;
        }
        let touches = self.points.iter().any(|p| p.row.normal_impulse > 0.0);
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
            sum.moment = plus(sum.moment, 1.0, point.couple);
        }
        sum
    }

    /// Adds the energies that contact and friction have taken from the body and not passed to the wall. Friction
    /// dissipates its impulses times the mean tangential velocities; the total follows from the energies of both.
    fn add_losses(&self, body: &mut RigidBody3d, [free, motion]: [PairMotion; 2], to_wall: f64, dofs: &mut Dofs) {
        let mut friction = 0.0;
        for point in &self.points {
            let mean = times(0.5, plus(free.at(point.arm), 1.0, motion.at(point.arm)));
            friction -= dot(point.impulses()[1], mean);
        }
        let contact = body.take_lost_energy() - to_wall - friction;
        let energies = &mut dofs.energies;
        let account = if self.pair.has_springs() { &mut energies.penalty } else { &mut energies.contact };
        *account += contact;
        energies.friction += friction;
    }

    /// Makes the contact of an increment.
    fn act(&mut self, body: &mut RigidBody3d, dofs: &mut Dofs, span: ContactInterval) {
        let wall = self.wall_motion(dofs);
        let free = PairMotion { body: body.motion_of(body.half[0], body.half[1]), wall: wall.velocity };
        let reach = self.reach(body, span.dt * (body.speed_bound(&free.body) + wall.velocity.abs()));
        self.points.clear();
        if self.surfaces.distance(body.centre, wall.lifts[1]) < body.size + reach {
            self.find_points(body, &wall, reach, span.half);
            self.set_dashpots(body, &wall);
        }
        let touches = self.collide(body, &wall, span);
        let of_points = |i: usize, factor: f64| {
            self.points.iter().fold([0.0; 3], |sum, point| plus(sum, factor, point.impulses()[i]))
        };
        self.forces = [0, 1].inline_map(|i| of_points(i, 1.0 / span.half));
        self.wall.impulses[0] = [0, 1].inline_map(|i| -of_points(i, 1.0)[1]);
        let work = self.wall.apply_impulses(&[0], dofs, span.dt);
        if touches {
            let Wrench { force, moment } = self.sum();
            let mean = Wrench { force: times(1.0 / span.half, force), moment: times(1.0 / span.half, moment) };
            body.contact.0.add(&mean);
            body.contact.1 = 0.5 * span.half;
            let pushed = wall.velocity - wall.inverse_mass * force[1];
            let motion = PairMotion { body: body.motion_of(body.half[0], body.half[1]), wall: pushed };
            self.add_losses(body, [free, motion], work.of_impulses[0] + work.of_impulses[1], dofs);
        }
        self.wall.push_bodies(dofs, |_| 0.0);
        self.duration = span.half;
        self.longest = self.look_ahead(body, body.half, &self.wall_motion(dofs));
    }

    fn wall_motion(&self, dofs: &Dofs) -> WallMotion {
        let body = &dofs.bodies[self.pair.bodies[1]];
        let inverse_mass = if body.prescribed { 0.0 } else { body.inverse_mass };
        let lifts = [body.before.displacement, body.displacement];
        WallMotion { lifts, velocity: body.velocity_half, inverse_mass }
    }

    /// Returns the gap at the end of the increment, in which points move by at most `moved`, up to which points are
    /// considered. In soft contact it includes all points that may touch the wall in the next increment.
    fn reach(&self, body: &RigidBody3d, moved: f64) -> f64 {
        if self.pair.is_soft() { (2.0 * moved).max(self.travel * body.size) + self.onset_gap() } else { 2.0 * moved }
    }

    /// Returns the gap at which pressure begins.
    fn onset_gap(&self) -> f64 {
        self.pair.laws.iter().map(|law| law.overclosure.onset_gap()).fold(0.0, f64::max)
    }

    /// Returns the longest increment for these velocities: the distance to the wall plus a fraction of the body's size,
    /// over the speed. In soft contact, the error of the period of an oscillation is at most the square of this fraction:
    /// with the frequency ω, central differences have the relative error (ω Δt)²/24. Equation (13.9).
    fn look_ahead(&self, body: &RigidBody3d, [velocity, momentum]: [SpatialVector; 2], wall: &WallMotion) -> f64 {
        let speed = body.speed_bound(&body.motion_of(velocity, momentum)) + wall.velocity.abs();
        let distance = self.surfaces.distance(body.centre, wall.lifts[1]) - self.onset_gap();
        let ahead = (distance - body.size).max(0.0) + self.travel * body.size;
        let time = if speed > 0.0 { ahead / speed } else { f64::INFINITY };
        time.min(self.travel * (24.0 / self.squared_frequency()).sqrt())
    }
}

/// Returns the projection of a unit area onto a plane from the cosine of the angle between their normals, and its
/// derivative. It is smooth where the area is perpendicular to the plane, and exact where it is parallel.
fn projection(cosine: f64) -> [f64; 2] {
    let size = cosine.abs();
    let rounded = if size < ROUNDED {
        [0.5 * size * size / ROUNDED, cosine / ROUNDED]
    } else {
        [size - 0.5 * ROUNDED, cosine.signum()]
    };
    rounded.inline_map(|value| value / (1.0 - 0.5 * ROUNDED))
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
        self.points.reserve(self.surfaces.most_points());
        self.wall.begin(&mut ContactRows::default(), dofs);
        let Some(body) = dofs.bodies[self.pair.bodies[0]].spatial.take() else { return };
        let wall = self.wall_motion(dofs);
        if self.pair.is_soft() {
            self.find_points(&body, &wall, self.reach(&body, 0.0), 0.0);
            let energy = |point: &ContactPoint| {
                point.row.area * self.pair.laws[point.row.law as usize].overclosure.energy(-point.gap)
            };
            if self.previous_dt == 0.0 {
                dofs.energies.initial_overlap += self.points.iter().map(energy).sum::<f64>();
            }
        }
        self.longest = self.look_ahead(&body, [body.velocity, body.momentum], &wall);
        self.points.clear();
        dofs.bodies[self.pair.bodies[0]].spatial = Some(body);
    }

    fn accelerations(&mut self, dofs: &mut Dofs, _clock: &AmplitudeClock<'_>) {
        let (wall, [normal, slip]) = (&mut dofs.bodies[self.pair.bodies[1]], self.wall.impulses[0]);
        if wall.prescribed && self.wall.half > 0.0 {
            wall.reaction -= (normal + slip) / self.wall.half * self.wall.output_share;
        }
    }

    fn motion(&mut self, dofs: &mut Dofs, _clock: &AmplitudeClock<'_>, dt: f64) {
        let half = 0.5 * (dt + std::mem::replace(&mut self.previous_dt, dt));
        self.wall.begin_increment(half, dt);
        self.wall.read_point(0, PointCarrier::Body(self.pair.bodies[1], [0.0; 2]), dofs);
        let Some(mut body) = dofs.bodies[self.pair.bodies[0]].spatial.take() else { return };
        self.act(&mut body, dofs, ContactInterval { dt, half });
        dofs.bodies[self.pair.bodies[0]].spatial = Some(body);
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
        self.wall.list.iter().position(|d| *d == (dof, true))
    }

    fn impulse(&self, _dof: Dof, index: usize, _half: f64) -> f64 {
        let [normal, slip] = self.wall.impulses[index];
        normal + slip
    }
}

impl StoredConstraint for RigidWallContact {}
