//! Six-node triangles side by side, and what one increment does to them. The points of a triangle go through the same phases of
//! laws as quadrilaterals with one point; strains, forces and viscosity are those of the triangle.
//! Never here: which elements a patch holds, threads.
#![allow(clippy::needless_range_loop)] // Loops over lanes and points are written as in the other phases.

use std::f64::consts::PI;

use pulp::Arch;

use crate::element::block::{ElementBlock, Workspace, is_larger};
use crate::element::constants::{CHANGE, Constants, damped};
use crate::element::group::block_of_points;
use crate::kernel::lanes::{Corners, LANES, Lanes, column};
use crate::kernel::quad::UNIT;
use crate::kernel::six_node_triangle::{NODES, Operators, POINTS, frequency_squared, masses};
use crate::kernel::stress::mises;
use crate::material::{BlockStart, Material, PlasticFlow};
use crate::state::archive::{Archive, Persist, persist_fields};
use crate::state::nodes::{Accelerated, Node};

/// Blocks of corner forces of a patch.
pub const FORCE_BLOCKS: usize = 2;

/// Volumes per radian to those of [`Workspace`], full rings in the unit [`UNIT`].
const RING: f64 = 2.0 * PI / UNIT;

/// Elements side by side.
#[derive(Clone)]
pub struct Patch<S> {
    /// Nodes around each element from a corner on, counter-clockwise.
    pub nodes: [[u32; LANES]; NODES],
    /// One over the masses of the nodes.
    pub inverse_mass: [Lanes; NODES],
    /// Stress and state of the points, each with its mass.
    pub points: [ElementBlock<S>; POINTS],
    /// Volume at the start.
    pub volume: Lanes,
    /// Whether an element is deleted.
    pub deleted: [bool; LANES],
    /// Two over the stable increments of the last pass.
    pub rate: Lanes,
}

/// Places and velocities of the nodes of a lane.
#[derive(Clone, Copy, Default)]
struct Motion {
    r: [f64; NODES],
    z: [f64; NODES],
    v_r: [f64; NODES],
    v_z: [f64; NODES],
}

/// What a point goes through in an increment.
#[derive(Clone, Copy)]
struct PointIncrement {
    strain: [Lanes; 4],
    /// Volume in the middle of the increment; 0 of lanes without element.
    volume: Lanes,
    bulk: Lanes,
    shear: Lanes,
    /// Work of the bulk viscosity that the volumetric law expects.
    expected: Lanes,
}

/// Work arrays of one patch.
#[derive(Clone)]
pub struct Room {
    motion: [Motion; LANES],
    /// Operators in the middle of the increment, the change of volume over it, and operators at its end.
    middle: [Operators; LANES],
    dilation: Lanes,
    now: [Operators; LANES],
    points: [PointIncrement; POINTS],
}

impl Default for Room {
    fn default() -> Self {
        let zero = [0.0; LANES];
        let point = PointIncrement { strain: [zero; 4], volume: zero, bulk: zero, shear: zero, expected: zero };
        Room {
            motion: [Motion::default(); LANES],
            middle: [Operators::default(); LANES],
            dilation: zero,
            now: [Operators::default(); LANES],
            points: [point; POINTS],
        }
    }
}

/// What an increment of a patch is given.
pub struct Increment<'a> {
    pub nodes: &'a [Node],
    pub dt: f64,
    pub before: Accelerated<'a>,
    /// Total time.
    pub time: f64,
    pub arch: Arch,
    /// Number of the patch in the group, and in its task.
    pub number: usize,
    pub at: usize,
    /// Elements of the group.
    pub count: usize,
}

/// Places of the nodes of an element.
pub fn places(element: [u32; NODES], nodes: &[Node]) -> [[f64; 2]; NODES] {
    element.map(|n| nodes[n as usize].place())
}

impl<S> Patch<S> {
    /// Elements at rest, at most as many as there are lanes.
    pub fn new<M: Material<State = S>>(
        material: &M,
        density: f64,
        (first, elements): (usize, &[[u32; NODES]]),
        nodes: &[Node],
    ) -> Self {
        // Lanes behind the last element repeat it; nothing reads their answers.
        let element = |l: usize| elements[l.min(elements.len() - 1)];
        let at = |l: usize| places(element(l), nodes);
        let operators: [Operators; LANES] =
            std::array::from_fn(|l| Operators::of(at(l).map(|p| p[0]), at(l).map(|p| p[1])));
        let inverse: [[f64; NODES]; LANES] = std::array::from_fn(|l| masses(at(l), density).map(|m| 1.0 / m));
        let area: Lanes = std::array::from_fn(|l| section(&at(l)));
        let points = std::array::from_fn(|p| {
            let volume = operators.map(|g| 2.0 * PI * g.volume[p]);
            let around = |n: usize, l: usize, i: usize| at(l)[n % NODES][i];
            let centre = |i: usize| {
                std::array::from_fn(|l| (around(2 * p, l, i) + around(2 * p + 1, l, i) + around(2 * p + 5, l, i)) / 3.0)
            };
            // Damage goes by half the length of elements of second order, the length of the triangles that this one consists of.
            let corner = |l: usize, i: usize| [2 * p, 2 * p + 1, 2 * p + 5, 2 * p + 5].map(|n| around(n, l, i));
            let start = BlockStart {
                count: elements.len(),
                area: area.map(|a| 0.25 * a),
                volume,
                centre: [centre(0), centre(1)],
                corners: std::array::from_fn(|l| [corner(l, 0), corner(l, 1)]),
                first,
            };
            block_of_points(material.initial_state(&start), volume.map(|v| density * v))
        });
        Patch {
            nodes: std::array::from_fn(|n| std::array::from_fn(|l| element(l)[n])),
            inverse_mass: std::array::from_fn(|n| std::array::from_fn(|l| inverse[l][n])),
            points,
            volume: operators.map(|g| 2.0 * PI * g.total()),
            deleted: [false; LANES],
            rate: [0.0; LANES],
        }
    }

    /// Nodes of a lane.
    pub fn element(&self, lane: usize) -> [u32; NODES] {
        self.nodes.map(|list| list[lane])
    }

    /// One over the masses of the nodes of a lane.
    pub fn inverse_masses(&self, lane: usize) -> [f64; NODES] {
        self.inverse_mass.map(|list| list[lane])
    }

    /// Mass of a lane.
    pub fn mass(&self, lane: usize) -> f64 {
        self.points.iter().map(|p| p.mass[lane]).sum()
    }

    /// Puts the nodes into the work arrays; an element that is deleted is replaced by one of its volume at rest.
    #[inline(always)]
    fn collect(&self, nodes: &[Node], room: &mut Room) {
        for l in 0..LANES {
            let motion = &mut room.motion[l];
            for n in 0..NODES {
                let node = &nodes[self.nodes[n][l] as usize];
                (motion.r[n], motion.z[n], motion.v_r[n], motion.v_z[n]) = (node.r, node.z, node.v_r, node.v_z);
            }
            if self.deleted[l] {
                let height = 0.75 * self.volume[l] / PI;
                let (r, z) = ([1.0, 1.5, 2.0, 1.5, 1.0, 1.0], [0.0, 0.0, 0.0, 0.5, 1.0, 0.5].map(|z| height * z));
                *motion = Motion { r, z, v_r: [0.0; NODES], v_z: [0.0; NODES] };
            }
        }
    }

    /// Work of the forces on the nodes of a lane at a speed and share of the accelerations.
    #[inline(always)]
    fn power(
        &self,
        l: usize,
        corners: &[Corners],
        motion: &Motion,
        (half, share): (f64, f64),
        before: Accelerated<'_>,
    ) -> f64 {
        let mut lost = 0.0;
        for n in 0..NODES {
            let [f_r, f_z] = corners[n / 4].0[n % 4][l];
            let [a_r, a_z] = before.accelerations.get(self.nodes[n][l] as usize).copied().unwrap_or_default();
            lost += f_r * (half * motion.v_r[n] - share * a_r) + f_z * (half * motion.v_z[n] - share * a_z);
        }
        lost
    }
}

impl<S: Clone> Patch<S> {
    /// One increment: stresses at its end, forces on the nodes, and what is added to the sums of the scratch memory.
    #[inline(always)]
    pub fn update<M: Material<State = S>>(
        &mut self,
        material: &M,
        constants: &Constants,
        increment: &Increment<'_>,
        (scratch, room): (&mut Workspace, &mut Room),
        corners: &mut [Corners],
    ) {
        let (dt, before) = (increment.dt, increment.before);
        self.collect(increment.nodes, room);
        self.measure(dt, room);
        // The energy of what has an equation of state comes from what forces do on the nodes (compatible.rs).
        let share = 0.5 * before.half * (dt - before.half);
        let mut lost = [0.0; LANES];
        if M::EQUATION_OF_STATE {
            for l in 0..LANES {
                lost[l] = self.power(l, corners, &room.motion[l], (0.5 * dt, share), before);
            }
        }
        let booked = [scratch.stress.internal, scratch.sums.viscous];
        for p in 0..POINTS {
            self.update_point(p, material, constants, increment, scratch, room);
        }
        if M::FAILS {
            self.delete_failed(material, constants, scratch, room);
        }
        let heat = self.assemble::<M>(constants, increment, (scratch, room), corners);
        if !M::EQUATION_OF_STATE {
            return;
        }
        let mut missing = [0.0; LANES];
        for l in 0..LANES {
            lost[l] += self.power(l, corners, &room.motion[l], (0.5 * dt, 0.0), before);
            let known = (scratch.stress.internal[l] - booked[0][l]) + (scratch.sums.viscous[l] - booked[1][l]);
            missing[l] = if scratch.weighs(l) { -lost[l] - known } else { 0.0 };
            scratch.stress.internal[l] += missing[l];
        }
        let mass: Lanes = std::array::from_fn(|l| self.mass(l));
        for (point, mut heat) in self.points.iter_mut().zip(heat) {
            for l in 0..LANES {
                heat[l] += missing[l] * point.mass[l] / mass[l];
            }
            material.add_heat(&mut point.state, &heat, &point.mass);
        }
    }

    /// Operators in the middle of an increment and at its end, and the change of volume.
    #[inline(always)]
    fn measure(&self, dt: f64, room: &mut Room) {
        let half = 0.5 * dt;
        for l in 0..LANES {
            let Motion { r, z, v_r, v_z } = room.motion[l];
            let middle = |x: [f64; NODES], v: [f64; NODES]| std::array::from_fn(|n| x[n] - half * v[n]);
            let g = Operators::of(middle(r, v_r), middle(z, v_z));
            room.dilation[l] = dt * growth(&g, &room.motion[l]) / g.total();
            room.middle[l] = g;
            room.now[l] = Operators::of(r, z);
        }
    }

    /// Stress of a point at the end of an increment.
    #[inline(always)]
    fn update_point<M: Material<State = S>>(
        &mut self,
        p: usize,
        material: &M,
        constants: &Constants,
        increment: &Increment<'_>,
        scratch: &mut Workspace,
        room: &mut Room,
    ) {
        let (dt, at) = (increment.dt, POINTS * increment.at + p);
        let whole: Lanes = std::array::from_fn(|l| self.mass(l));
        scratch.prepare(increment.number, at, increment.count - increment.number * LANES);
        let point = &mut self.points[p];
        for l in (0..LANES).filter(|l| self.deleted[*l]) {
            scratch.mask(l);
            scratch.stress.flow[l] = 0.0;
            point.stress.iter_mut().for_each(|s| s[l] = 0.0);
        }
        if M::FAILS {
            // The stress of the undamaged material.
            for l in (0..scratch.strain.count).filter(|l| !self.deleted[*l]) {
                let share = material.share(&point.state, l);
                point.stress.iter_mut().for_each(|s| s[l] /= share);
            }
        }
        scratch.set_gradients(dt, |l| {
            let (g, Motion { v_r, v_z, .. }) = (&room.middle[l], &room.motion[l]);
            let [rr, zz, hoop, rz, zr] = g.gradients(p, v_r, v_z);
            let mean = growth(g, &room.motion[l]) / g.total() * g.volume[p];
            let lacks = (mean - (rr + zz + hoop)) * (1.0 / 3.0);
            ([rr + lacks, zz + lacks, hoop + lacks, rz, zr].map(|x| RING * x), RING * g.volume[p])
        });
        material.begin(&mut point.state, increment.time);
        point.trial::<M>(constants, dt, scratch);
        if scratch.cap < f64::INFINITY {
            scratch.measure();
        }
        if M::EQUATION_OF_STATE {
            // Density is that of the element.
            for l in 0..LANES {
                let share = 2.0 * PI * point.mass[l] / whole[l];
                scratch.strain.volume[l] = if scratch.weighs(l) { share * room.middle[l].total() } else { 0.0 };
                scratch.strain.current_volume[l] = share * room.now[l].total();
            }
            scratch.strain.mass = point.mass;
            scratch.strain.viscous = scratch.task.viscous.get(at).copied().unwrap_or_default();
        }
        point.update_stress(material, constants, scratch);
        // Stress that answers to the whole deformation stayed.
        for l in (0..LANES).filter(|l| self.deleted[*l]) {
            point.stress.iter_mut().for_each(|s| s[l] = 0.0);
        }
        if !scratch.task.records.is_empty() {
            scratch.follow(increment.arch, at, &point.stress, M::FLOW, (scratch.strain.spin, dt));
        }
        let [bulk, shear] = moduli::<M>(constants, scratch);
        let expected = if M::EQUATION_OF_STATE { scratch.stress.heat } else { [0.0; LANES] };
        room.points[p] =
            PointIncrement { strain: scratch.strain.strain, volume: scratch.strain.volume, bulk, shear, expected };
    }

    /// Deletes elements of which a point has failed. The stress of the other points ends with the increment, and what they have
    /// stored counts as dissipated.
    #[inline(never)]
    fn delete_failed<M: Material<State = S>>(
        &mut self,
        material: &M,
        constants: &Constants,
        scratch: &mut Workspace,
        room: &Room,
    ) {
        for l in 0..LANES {
            if l >= scratch.strain.count {
                // Lanes behind the last element repeat it.
                self.deleted[l] = self.deleted[scratch.strain.count - 1];
                continue;
            }
            if self.deleted[l] || self.points.iter().all(|point| material.share(&point.state, l) > 0.0) {
                continue;
            }
            self.deleted[l] = true;
            for (point, done) in self.points.iter_mut().zip(&room.points) {
                let (stress, volume) = (column(&point.stress, l), done.volume[l]);
                let double = |i: usize| done.strain[i][l] * stress[i];
                scratch.stress.internal[l] -= 0.5 * volume * ((double(0) + double(1)) + (double(2) + 2.0 * double(3)));
                let share = material.share(&point.state, l);
                if share > 0.0 {
                    let (mises, mean) = (mises(stress), (stress[0] + stress[1] + stress[2]) / 3.0);
                    let distortion = if constants.shear > 0.0 { mises * mises / (6.0 * constants.shear) } else { 0.0 };
                    let stored = (distortion + 0.5 * mean * mean / done.bulk[l]) / share;
                    scratch.stress.dissipated[l] += volume * stored;
                }
                point.stress.iter_mut().for_each(|s| s[l] = 0.0);
            }
        }
    }

    /// Forces of stress and bulk viscosity on the nodes, and the stable increment. Returns the heat of the viscosity beyond what the
    /// volumetric law of each point expected.
    #[inline(always)]
    fn assemble<M: Material<State = S>>(
        &mut self,
        constants: &Constants,
        increment: &Increment<'_>,
        (scratch, room): (&mut Workspace, &mut Room),
        corners: &mut [Corners],
    ) -> [Lanes; POINTS] {
        let dt = increment.dt;
        let per_dt = if dt > 0.0 { 1.0 / dt } else { 0.0 };
        let [linear, quadratic] = constants.bulk_viscosity;
        let cap = scratch.cap;
        let first = POINTS * increment.at;
        let mut heat = [[0.0; LANES]; POINTS];
        for l in 0..LANES {
            let (now, done) = (&room.now[l], &room.points);
            let largest = |of: fn(&PointIncrement) -> &Lanes| of(&done[0])[l].max(of(&done[1])[l]).max(of(&done[2])[l]);
            let (bulk, shear) = (largest(|d| &d.bulk), largest(|d| &d.shear));
            let omega = frequency_squared(now, [bulk, shear], &self.inverse_masses(l)).sqrt();
            let (modulus, period) = (bulk + 4.0 / 3.0 * constants.shear, 1.0 / omega);
            let dilation = room.dilation[l];
            // Without an increment behind, the velocities say how fast the volume changes.
            let starts = M::MODULI_VARY && per_dt == 0.0;
            let rate = if starts { growth(now, &room.motion[l]) / now.total() } else { dilation * per_dt };
            let fraction = linear - quadratic * quadratic * 2.0 * period * rate.min(0.0);
            let damping = 2.0 * modulus * period * rate * fraction;
            let mut stress = [[0.0; 4]; POINTS];
            for p in 0..POINTS {
                stress[p] = column(&self.points[p].stress, l);
                stress[p][..3].iter_mut().for_each(|s| *s += damping);
                if let Some(viscous) = scratch.task.viscous.get_mut(first + p) {
                    let work = done[p].volume[l] * 0.5 * (viscous[l] + damping) * dilation;
                    viscous[l] = damping;
                    scratch.sums.viscous[l] += work;
                    heat[p][l] = work;
                }
                heat[p][l] -= done[p].expected[l];
            }
            let forces = now.forces(&stress);
            for (n, force) in forces.iter().enumerate() {
                corners[n / 4].0[n % 4][l] = if self.deleted[l] { [0.0; 2] } else { force.map(|f| -2.0 * PI * f) };
            }
            // As of quadrilaterals (`ElementBlock::forces`).
            let pressing = modulus / constants.bulk;
            let share = cap * period;
            let capped = share < 1.0;
            let xi = if capped { fraction * share * pressing } else { fraction };
            let damped = if M::MODULI_VARY { xi + (1.0 + xi * xi).sqrt() } else { damped(xi) };
            let stable = if capped { cap } else { omega } * damped;
            self.rate[l] = stable;
            let changing = rate.abs() * 2.0 / CHANGE;
            let rate = if self.deleted[l] || !scratch.weighs(l) {
                0.0
            } else if changing > stable {
                changing
            } else {
                stable
            };
            let number = scratch.number();
            if is_larger(rate, scratch.sums.rate[l]) {
                (scratch.sums.rate[l], scratch.sums.limiting[l]) = (rate, number);
            }
        }
        heat
    }
}

/// Sum of the normal velocity gradients over the volume of an element.
#[inline(always)]
pub fn growth_of(g: &Operators, v_r: &[f64; NODES], v_z: &[f64; NODES]) -> f64 {
    let mut sum = 0.0;
    for p in 0..POINTS {
        let [rr, zz, hoop, ..] = g.gradients(p, v_r, v_z);
        sum += rr + zz + hoop;
    }
    sum
}

#[inline(always)]
fn growth(g: &Operators, motion: &Motion) -> f64 {
    growth_of(g, &motion.v_r, &motion.v_z)
}

/// Area of the plane section.
fn section(places: &[[f64; 2]; NODES]) -> f64 {
    let cross = |i: usize| {
        let (p, q) = (places[i], places[(i + 1) % NODES]);
        0.5 * (p[0] * q[1] - q[0] * p[1])
    };
    (0..NODES).map(cross).sum()
}

/// Moduli that bound the frequencies of a point: those of its material where they vary. The shear modulus that rubber answers is a
/// mean of three.
#[inline(always)]
fn moduli<M: Material>(constants: &Constants, scratch: &Workspace) -> [Lanes; 2] {
    let constant = [[constants.bulk; LANES], [constants.shear; LANES]];
    match M::FLOW {
        _ if !M::MODULI_VARY => constant,
        PlasticFlow::None if !M::EQUATION_OF_STATE => [scratch.stress.bulk, scratch.stress.shear.map(|s| 3.0 * s)],
        _ => [scratch.stress.bulk, constant[1]],
    }
}

impl<S: Persist> Persist for Patch<S> {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Patch { nodes: _, inverse_mass, points, volume: _, deleted, rate } = self;
        persist_fields!(archive; inverse_mass, points, deleted, rate);
    }
}
