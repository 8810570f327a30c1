//! Stations of a rigid body with six degrees of freedom as points of the contact, in front of an analytical surface of
//! revolution that moves along 2 or is fixed. The meridian points of the body form rings around its axis, which are
//! divided into stations.
//!
//! Each station has a row with two directions of slip ([`ContactRows::solve_in_space`]). The degrees of freedom of the
//! rows are the velocity of the centre of mass, the angular velocity in the frame of the body, and the velocity of the
//! wall.
//!
//! In hard contact, points must not pass the surface at the end of the increment. The impulses act at the contact points
//! at its start (constrained central differences, Ryckaert, Ciccotti and Berendsen 1977, J. Comput. Phys. 23, 327). In
//! soft contact, pressures follow from the overlaps at the start of the increment, and sweeps compute damping and
//! friction. The pressures have a potential, so that central differences conserve the energy.

use super::dofs::ContactDofs;
use super::sweeps::{ContactInterval, ContactRow, ContactRows, ContactStep, ContactVelocities, GapTerm};
use super::wall_stations::{WallDistance, WallPose, WallSurfaces};
use crate::constraint::PairForces;
use crate::kernel::attitude::{SpatialVector, cross, dot, norm, plus, times};
use crate::kernel::interaction::{InteractionLaw, PressureOverclosure};
use crate::kernel::lanes::{InlineMap, inline_from_fn};
use crate::kernel::lists::Memory;
use crate::state::archive::Persist;
use crate::state::dofs::Dofs;
use crate::state::rigid_body_3d::{RigidBody3d, Wrench};
use crate::state::{BodyState, EffectId};

/// Largest number of solutions, between which gaps are measured after the impulses have moved and turned the body.
const ROUNDS: usize = 4;
/// Cosine below which the projection of an area in soft contact is a smooth function of the attitude: rounding errors would
/// otherwise turn an upright body, whose shank is perpendicular to the wall.
const ROUNDED: f64 = 0.01;
/// Largest squared product of frequency and increment for which pressures follow from the overlaps at the start of the
/// increment. Only fixed increments are longer; pressures then follow from the overlaps at their end.
const EXPLICIT: f64 = 1.0;
/// Number of degrees of freedom of a row, of which the last one is the velocity of the wall.
const DOFS: usize = 7;
const OF_WALL: usize = DOFS - 1;

/// The two surfaces and their contact laws.
#[derive(Clone, Debug)]
pub struct StationPair {
    /// Row of the ledger.
    pub id: EffectId,
    /// Number among the pairs of all steps.
    pub number: usize,
    /// Whether the surface of the moving body is the first one of the pair.
    pub first: bool,
    /// Indices of the moving body and of the body of the wall.
    pub bodies: [usize; 2],
    /// The contact point that represents the body of the wall.
    pub wall: u32,
    /// Contact laws of the rings. All are hard, or all are soft.
    pub laws: Vec<InteractionLaw>,
    /// Largest displacement of the body's points in an increment, as a fraction of the body's size.
    pub travel: f64,
}

impl StationPair {
    fn is_soft(&self) -> bool {
        self.laws.iter().any(InteractionLaw::is_soft)
    }

    fn has_springs(&self) -> bool {
        self.laws.iter().any(|law| matches!(law.overclosure, PressureOverclosure::Spring(_)))
    }

    /// Returns the gap at which pressure begins.
    fn onset_gap(&self) -> f64 {
        self.laws.iter().map(|law| law.overclosure.onset_gap()).fold(0.0, f64::max)
    }

    fn law_of(&self, row: &ContactRow) -> &PressureOverclosure {
        &self.laws[row.law as usize].overclosure
    }

    fn step(&self, span: ContactInterval) -> ContactStep<'_> {
        ContactStep { laws: &self.laws, pressures: &[], span }
    }
}

/// A point of the body that may touch the wall: a station of a ring, or the deepest point of a ring (`station` is
/// `None`).
#[derive(Clone, Copy, Debug)]
struct StationPoint {
    ring: usize,
    station: Option<usize>,
    /// Gap that the point keeps; negative for an overlap at the start of the increment.
    target: f64,
    /// Gap at the end of the increment without contact.
    end_gap: f64,
}

/// Contact of the stations of one rigid body with one wall over a step.
#[derive(Clone, Debug, Persist, Memory)]
#[persist(derived: pair, surfaces, points, rows, motion, couple)]
#[memory(uncounted: pair)]
pub struct StationContact {
    pub(super) pair: StationPair,
    surfaces: WallSurfaces,
    points: Vec<StationPoint>,
    /// Rows of the points; their keys are the indices of the points.
    rows: ContactRows,
    motion: ContactVelocities,
    /// Impulse of the moment on the body by the change of the projected areas with the attitude.
    couple: SpatialVector,
    /// Forces of pressure and of friction on the body over the previous increment.
    forces: [SpatialVector; 2],
    /// Longest increment.
    pub(super) longest: f64,
}

impl StationContact {
    pub fn new(pair: StationPair, surfaces: WallSurfaces) -> Self {
        let mut contact = StationContact {
            pair,
            surfaces,
            points: Vec::new(),
            rows: ContactRows::default(),
            motion: ContactVelocities { velocity: vec![0.0; DOFS], inverse_mass: vec![0.0; DOFS] },
            couple: [0.0; 3],
            forces: [[0.0; 3]; 2],
            longest: f64::INFINITY,
        };
        contact.reserve();
        contact
    }

    fn reserve(&mut self) {
        let count = self.surfaces.most_points();
        self.points.reserve(count);
        self.rows.reserve_in_space(count, DOFS);
    }

    /// Takes the forces of the previous contact of the same pair.
    pub(super) fn take_over(&mut self, previous: &StationContact) {
        self.forces = previous.forces;
    }

    /// Returns the forces on the first surface over the previous increment.
    pub(super) fn forces(&self, dofs: &ContactDofs) -> PairForces {
        let factor = if self.pair.first { dofs.output_share } else { -dofs.output_share };
        let forces = self.forces.inline_map(|force| times(factor, force));
        PairForces { forces, duration: dofs.half / dofs.output_share }
    }

    /// Returns the projected area under pressure; NaN in hard contact.
    pub(super) fn area(&self) -> f64 {
        let pressed = self.rows.rows.iter().filter(|row| row.normal_impulse > 0.0);
        if self.pair.is_soft() { pressed.fold(0.0, |sum, row| sum + row.area) } else { f64::NAN }
    }

    /// Begins a step; `starts` states whether the contact begins with it. The energy of overlaps is then given.
    pub(super) fn begin(&mut self, dofs: &mut Dofs, starts: bool) {
        self.reserve();
        let Some(body) = dofs.bodies[self.pair.bodies[0]].spatial.take() else { return };
        self.clear();
        if self.pair.is_soft() {
            self.measure(&body, self.wall(dofs), self.reach(&body, 0.0), ContactInterval { dt: 0.0, half: 0.0 });
        }
        if starts {
            let energy = |row: &ContactRow| row.area * self.pair.law_of(row).energy(-self.end_gap(row));
            dofs.energies.initial_overlap += self.rows.rows.iter().map(energy).sum::<f64>();
        }
        self.longest =
            self.look_ahead(&body, [body.velocity, body.momentum], self.wall(dofs), self.squared_frequency());
        self.clear();
        dofs.bodies[self.pair.bodies[0]].spatial = Some(body);
    }

    /// Makes the contact of an increment of length `dt`; `own_dofs` are the degrees of freedom of the contact.
    pub(super) fn act(&mut self, own_dofs: &mut ContactDofs, dofs: &mut Dofs, dt: f64) {
        let Some(mut body) = dofs.bodies[self.pair.bodies[0]].spatial.take() else { return };
        let (wall, span) = (self.wall(dofs), ContactInterval { dt, half: own_dofs.half });
        let reach = self.reach(&body, dt * closing_speed(&body, body.half, wall));
        self.clear();
        if self.surfaces.distance(body.centre, wall.displacement) < body.size + reach {
            self.measure(&body, wall, reach, span);
        }
        let squared_frequency = self.squared_frequency();
        let free: [f64; DOFS] = inline_from_fn(|dof| self.motion.velocity[dof]);
        let sums = self.collide(&mut body, wall, span, squared_frequency);
        self.forces = [0, 1].inline_map(|part: usize| [0, 1, 2].inline_map(|i: usize| sums[i][part] / span.half));
        let to_wall = own_dofs.add_impulse(self.pair.wall, sums[OF_WALL], dofs, dt);
        if self.rows.rows.iter().any(|row| row.normal_impulse > 0.0) {
            let lost = body.take_lost_energy() - to_wall[0] - to_wall[1];
            self.add_losses(lost, free, &sums, dofs);
        }
        self.longest = self.look_ahead(&body, body.half, self.wall(dofs), squared_frequency);
        dofs.bodies[self.pair.bodies[0]].spatial = Some(body);
    }

    /// Adds the energy that contact and friction have taken from the body and not passed to the wall. Friction dissipates
    /// its impulses times the means of the velocities without contact and after it.
    fn add_losses(&self, lost: f64, free: [f64; DOFS], sums: &[[f64; 2]; DOFS], dofs: &mut Dofs) {
        let means = free.iter().zip(&self.motion.velocity).map(|(free, velocity)| 0.5 * (free + velocity));
        let friction = -means.zip(sums).map(|(mean, sum)| mean * sum[1]).sum::<f64>();
        let energies = &mut dofs.energies;
        let account = if self.pair.has_springs() { &mut energies.penalty } else { &mut energies.contact };
        *account += lost - friction;
        energies.friction += friction;
    }

    fn wall<'a>(&self, dofs: &'a Dofs) -> &'a BodyState {
        &dofs.bodies[self.pair.bodies[1]]
    }

    fn clear(&mut self) {
        self.rows.clear();
        self.points.clear();
        self.couple = [0.0; 3];
    }

    /// Reads the velocities without contact and adds the rows of the points with a gap below `reach` at the end of the
    /// increment.
    fn measure(&mut self, body: &RigidBody3d, wall: &BodyState, reach: f64, span: ContactInterval) {
        self.read_motion(body, wall);
        let start_pose = WallPose { body: body.previous, lift: wall.before.displacement };
        let end_pose = WallPose { body: body.pose(), lift: wall.displacement };
        let is_soft = self.pair.is_soft();
        for ring in 0..self.surfaces.rings.len() {
            if is_soft && self.surfaces.is_far(ring, &end_pose, reach) {
                continue;
            }
            // The deepest point has no area.
            let deepest = (!is_soft).then_some(None);
            for station in (0..self.surfaces.count(ring)).map(Some).chain(deepest) {
                let measured = self.surfaces.measure(ring, station, &end_pose);
                let Some(end) = measured.filter(|end| end.gap < reach) else { continue };
                let start = self.surfaces.measure(ring, station, &start_pose).unwrap_or(end);
                let target = if is_soft { 0.0 } else { start.gap.min(0.0) };
                self.add_row(StationPoint { ring, station, target, end_gap: end.gap }, &start, body, span);
            }
        }
    }

    /// Sets the velocities without contact and the inverse masses.
    fn read_motion(&mut self, body: &RigidBody3d, wall: &BodyState) {
        let ContactVelocities { velocity, inverse_mass } = &mut self.motion;
        let free = body.motion_of(body.half[0], body.half[1]);
        velocity[..3].copy_from_slice(&free.velocity);
        velocity[3..OF_WALL].copy_from_slice(&body.attitude.to_body(free.turning));
        velocity[OF_WALL] = wall.velocity_half;
        inverse_mass[..3].fill(1.0 / body.mass);
        inverse_mass[3..OF_WALL].fill(1.0 / body.inertia.transverse);
        inverse_mass[4] = 1.0 / body.inertia.axial;
        inverse_mass[OF_WALL] = if wall.prescribed { 0.0 } else { wall.inverse_mass };
    }

    /// Adds the row of a point with the contact geometry at the start of the increment. Equation (13.7).
    ///
    /// In soft contact, pressure acts on the projection of the area of the station onto the surface of the wall. The energy
    /// depends on the attitude through this projection, which adds a moment. Equation (13.8).
    fn add_row(&mut self, point: StationPoint, start: &WallDistance, body: &RigidBody3d, span: ContactInterval) {
        let StationContact { pair, surfaces, points, rows, motion, couple, .. } = self;
        let law = surfaces.rings[point.ring].law;
        let mut row = ContactRow::of(points.len() as u32, law as u32);
        let closest_point = (!pair.is_soft()).then_some(row.key);
        (row.area, row.closest_point) = (1.0, closest_point);
        if let (Some(station), None) = (point.station, closest_point) {
            let (normal, area) = surfaces.facet(point.ring, station);
            let facet_normal = body.previous.attitude.to_world(normal);
            let [share, slope] = projection(dot(facet_normal, start.normal));
            let law = &pair.laws[law].overclosure;
            let stored = if start.gap < law.onset_gap() { law.energy(-start.gap) } else { 0.0 };
            *couple = plus(*couple, -span.half * area * stored * slope, cross(facet_normal, start.normal));
            (row.area, row.gap) = (area * share, area * share * start.gap);
            if row.area <= 0.0 {
                return;
            }
        }
        let [normal, first, second] = basis(start.normal).inline_map(|axis| {
            let ([x, y, z], [a, b, c]) = (axis, body.attitude.to_body(cross(start.arm, axis)));
            [x, y, z, a, b, c, -y].inline_map(|derivative| row.area * derivative)
        });
        rows.open();
        rows.terms.extend((0..DOFS).map(|i| GapTerm { dof: i as u32, normal: normal[i], slip: first[i] }));
        rows.close(row);
        rows.terms.extend((0..DOFS).map(|i| GapTerm { dof: i as u32, normal: 0.0, slip: second[i] }));
        points.push(point);
        let Some(row) = rows.rows.last_mut() else { return };
        row.update_compliance(row.terms_in(&rows.terms), motion);
        if closest_point.is_some() {
            row.gap = point.end_gap - point.target - span.dt * motion.rate(row.terms_in(&rows.terms));
        }
    }

    /// Applies contact to the motion of the body. Returns the impulses of pressure and of friction on each degree of
    /// freedom.
    fn collide(
        &mut self,
        body: &mut RigidBody3d,
        wall: &BodyState,
        span: ContactInterval,
        squared_frequency: f64,
    ) -> [[f64; 2]; DOFS] {
        let (free, attitude, mut sums) = (body.half, body.attitude, [[0.0; 2]; DOFS]);
        let StationContact { pair, rows, .. } = self;
        let is_explicit = pair.is_soft() && squared_frequency * span.dt * span.dt <= EXPLICIT;
        if is_explicit {
            rows.rows.retain(|row| -row.gap > -pair.law_of(row).onset_gap() * row.area);
        }
        let law_span = ContactInterval { dt: if is_explicit { 0.0 } else { span.dt }, ..span };
        let Some(reference) = rows.begin(&self.motion, pair.step(span)) else { return sums };
        let moment = attitude.to_body(self.couple);
        (0..3).for_each(|i| self.motion.velocity[3 + i] += self.motion.inverse_mass[3 + i] * moment[i]);
        let mut on_body = Wrench::default();
        for round in 0..if self.pair.is_soft() { 1 } else { ROUNDS } {
            if round > 0 {
                self.measure_again(body, wall, span);
            }
            self.rows.solve_in_space(&mut self.motion, reference, self.pair.step(law_span));
            sums = self.sum_impulses();
            let [x, y, z, a, b, c, _] = sums.inline_map(|[pressed, sheared]| pressed + sheared);
            on_body = Wrench { force: [x, y, z], moment: plus(self.couple, 1.0, attitude.to_world([a, b, c])) };
            body.half = [plus(free[0], 1.0 / body.mass, on_body.force), plus(free[1], 1.0, on_body.moment)];
            body.move_freely(span.dt);
        }
        let mean = [on_body.force, on_body.moment].inline_map(|impulse| times(1.0 / span.half, impulse));
        body.contact.0.add(&Wrench { force: mean[0], moment: mean[1] });
        body.contact.1 = 0.5 * span.half;
        sums
    }

    /// Updates the gaps after the impulses have moved the body and the wall. Lever arms and effective masses remain those
    /// of the motion without contact.
    fn measure_again(&mut self, body: &RigidBody3d, wall: &BodyState, span: ContactInterval) {
        let StationContact { pair, surfaces, points, rows: ContactRows { rows, terms, .. }, motion, .. } = self;
        let lift = wall.displacement + span.dt * (motion.velocity[OF_WALL] - wall.velocity_half);
        let end = WallPose { body: body.pose(), lift };
        for row in rows.iter_mut().filter(|row| row.normal_impulse > 0.0) {
            let point = &points[row.key as usize];
            if let Some(distance) = surfaces.measure(point.ring, point.station, &end) {
                row.gap = distance.gap - point.target - span.dt * motion.rate(row.terms_in(terms));
                row.take_bias(&pair.laws[row.law as usize], span);
            }
        }
    }

    /// Returns the impulses of pressure and of friction on each degree of freedom.
    fn sum_impulses(&self) -> [[f64; 2]; DOFS] {
        let ContactRows { rows, terms, .. } = &self.rows;
        let mut sums = [[0.0; 2]; DOFS];
        for row in rows {
            for (first, second) in row.terms_in(terms).iter().zip(row.second_terms_in(terms)) {
                let [pressed, sheared] = &mut sums[first.dof as usize];
                *pressed += first.normal * row.normal_impulse;
                *sheared += first.slip * row.shear_impulse + second.slip * row.second_shear_impulse;
            }
        }
        sums
    }

    /// Returns the gap at the end of the increment, in which points move by at most `moved`, up to which points are
    /// considered. In soft contact it includes all points that may touch the wall in the next increment.
    fn reach(&self, body: &RigidBody3d, moved: f64) -> f64 {
        let StationPair { travel, .. } = self.pair;
        if self.pair.is_soft() { (2.0 * moved).max(travel * body.size) + self.pair.onset_gap() } else { 2.0 * moved }
    }

    /// Returns the gap of a row's point at the end of the increment without contact.
    fn end_gap(&self, row: &ContactRow) -> f64 {
        self.points[row.key as usize].end_gap
    }

    /// Returns a bound of the square of the highest frequency of soft contact, with all points that may touch the wall in
    /// the next increment.
    fn squared_frequency(&self) -> f64 {
        let stiffness = |row: &ContactRow| {
            let [_, slope] = self.pair.law_of(row).linearized(-self.end_gap(row));
            slope * row.compliance[0] / row.area
        };
        if self.pair.is_soft() { self.rows.rows.iter().map(stiffness).sum() } else { 0.0 }
    }

    /// Returns the longest increment for these velocities: the distance to the wall plus a fraction of the body's size,
    /// over the speed. In soft contact, the error of the period of an oscillation is at most the square of this fraction:
    /// with the frequency ω, central differences have the relative error (ω Δt)²/24. Equation (13.9).
    fn look_ahead(
        &self,
        body: &RigidBody3d,
        moving: [SpatialVector; 2],
        wall: &BodyState,
        squared_frequency: f64,
    ) -> f64 {
        let travel = self.pair.travel;
        let speed = closing_speed(body, moving, wall);
        let distance = self.surfaces.distance(body.centre, wall.displacement) - self.pair.onset_gap();
        let ahead = (distance - body.size).max(0.0) + travel * body.size;
        let time = if speed > 0.0 { ahead / speed } else { f64::INFINITY };
        time.min(travel * (24.0 / squared_frequency).sqrt())
    }
}

/// Returns a bound of the speed of all points of a body relative to the wall, for a velocity and an angular momentum.
fn closing_speed(body: &RigidBody3d, [velocity, momentum]: [SpatialVector; 2], wall: &BodyState) -> f64 {
    body.speed_bound(&body.motion_of(velocity, momentum)) + wall.velocity_half.abs()
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
