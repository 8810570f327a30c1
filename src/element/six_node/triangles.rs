//! Six-node triangles side by side, without their materials: motion, strains of their points, forces on their nodes, stable
//! increments. Compiled once for all materials.
//! Never here: stress, threads.
#![allow(clippy::needless_range_loop)] // Loops over lanes and points are written as in the other phases.

use std::f64::consts::PI;

use pulp::{Arch, NullaryFnOnce};

use crate::element::block::{Workspace, is_larger};
use crate::element::constants::{CHANGE, Constants, damped};
use crate::kernel::lanes::{Corners, InlineMap, LANES, Lanes, column, inline_from_fn};
use crate::kernel::quad::UNIT;
use crate::kernel::six_node_triangle::{NODES, Operators, POINTS, frequency_squared, masses};
use crate::state::archive::persist_struct;
use crate::state::nodes::{Accelerated, Node};

/// Blocks of corner forces of a block of triangles.
pub const FORCE_BLOCKS: usize = 2;

/// Volumes per radian to those of [`Workspace`], full rings in the unit [`UNIT`].
const RING: f64 = 2.0 * PI / UNIT;

/// Triangles side by side.
#[derive(Clone)]
pub struct Triangles {
    /// Nodes around each element from a corner on, counter-clockwise.
    nodes: [[u32; LANES]; NODES],
    /// One over the masses of the nodes.
    pub inverse_mass: [Lanes; NODES],
    /// Volume at the start.
    volume: Lanes,
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

/// A point of each lane in an increment.
#[derive(Clone, Copy, Default)]
pub struct PointIncrement {
    /// Velocity gradients in the middle of the increment times the volumes there, and these, as [`Workspace::set_gradients`] takes
    /// them.
    pub gradients: [Lanes; 5],
    pub middle: Lanes,
    /// Volumes at its end.
    pub current_volume: Lanes,
    /// Strain increments, and volumes in the middle of the increment, 0 of lanes without element.
    pub strain: [Lanes; 4],
    pub volume: Lanes,
    /// Moduli at its end.
    pub bulk: Lanes,
    pub shear: Lanes,
    /// Heat of the bulk viscosity beyond what the material expected.
    pub heat: Lanes,
}

/// Work arrays of one block.
#[derive(Clone, Default)]
pub struct WorkArrays {
    motion: [Motion; LANES],
    /// Rate of the volume over the volume in the middle of the increment.
    dilation_rate: Lanes,
    /// Operators at the end of the increment.
    now: [Operators; LANES],
    pub points: [PointIncrement; POINTS],
}

/// An increment of all blocks of a group.
pub struct Increment<'a> {
    pub nodes: &'a [Node],
    pub dt: f64,
    pub before: Accelerated<'a>,
    /// Total time.
    pub time: f64,
    pub arch: Arch,
    /// Elements of the group.
    pub count: usize,
}

/// Places of the nodes of an element.
pub fn places(element: [u32; NODES], nodes: &[Node]) -> [[f64; 2]; NODES] {
    element.inline_map(|n| nodes[n as usize].place())
}

impl Triangles {
    /// Elements by their nodes, at their places now.
    pub fn new(elements: [[u32; NODES]; LANES], density: f64, nodes: &[Node]) -> Self {
        let at = elements.inline_map(|element| places(element, nodes));
        let masses = at.inline_map(|at| masses(at, density));
        Triangles {
            nodes: inline_from_fn(|n| elements.inline_map(|element| element[n])),
            inverse_mass: inline_from_fn(|n| masses.inline_map(|masses| 1.0 / masses[n])),
            volume: at
                .inline_map(|at| 2.0 * PI * Operators::of(at.inline_map(|p| p[0]), at.inline_map(|p| p[1])).total()),
            deleted: [false; LANES],
            rate: [0.0; LANES],
        }
    }

    /// Nodes of a lane.
    pub fn element(&self, lane: usize) -> [u32; NODES] {
        self.nodes.inline_map(|list| list[lane])
    }

    /// One over the masses of the nodes of a lane.
    pub fn inverse_masses(&self, lane: usize) -> [f64; NODES] {
        self.inverse_mass.inline_map(|list| list[lane])
    }

    /// Motion of a lane; an element that is deleted is replaced by one of its volume at rest.
    #[inline(always)]
    fn motion(&self, l: usize, nodes: &[Node]) -> Motion {
        if self.deleted[l] {
            let height = 0.75 * self.volume[l] / PI;
            let (r, z) = ([1.0, 1.5, 2.0, 1.5, 1.0, 1.0], [0.0, 0.0, 0.0, 0.5, 1.0, 0.5].inline_map(|z| height * z));
            return Motion { r, z, ..Motion::default() };
        }
        let mut motion = Motion::default();
        for n in 0..NODES {
            let node = &nodes[self.nodes[n][l] as usize];
            (motion.r[n], motion.z[n], motion.v_r[n], motion.v_z[n]) = (node.r, node.z, node.v_r, node.v_z);
        }
        motion
    }

    /// Puts motion, volumes and velocity gradients into the work arrays.
    pub fn measure(&self, increment: &Increment<'_>, work: &mut WorkArrays) {
        increment.arch.dispatch(Measurement { triangles: self, increment, work });
    }

    /// Energy that the elements lose to the forces of the start of an increment; see [`Workspace::owe`].
    pub fn work_of_start(&self, corners: &[Corners], increment: &Increment<'_>, work: &WorkArrays) -> Lanes {
        let Increment { dt, before, .. } = *increment;
        let share = 0.5 * before.half * (dt - before.half);
        let mut lost = [0.0; LANES];
        for n in 0..NODES {
            for l in 0..LANES {
                let ([f_r, f_z], motion) = (corners[n / 4].0[n % 4][l], &work.motion[l]);
                let [a_r, a_z] = before.accelerations.get(self.nodes[n][l] as usize).copied().unwrap_or_default();
                lost[l] +=
                    f_r * (0.5 * dt * motion.v_r[n] - share * a_r) + f_z * (0.5 * dt * motion.v_z[n] - share * a_z);
            }
        }
        lost
    }

    /// The same with the forces of its end.
    pub fn work_of_end(
        &self,
        mut lost: Lanes,
        corners: &[Corners],
        increment: &Increment<'_>,
        work: &WorkArrays,
    ) -> Lanes {
        for n in 0..NODES {
            for l in 0..LANES {
                let ([f_r, f_z], motion) = (corners[n / 4].0[n % 4][l], &work.motion[l]);
                lost[l] += 0.5 * increment.dt * (f_r * motion.v_r[n] + f_z * motion.v_z[n]);
            }
        }
        lost
    }

    /// Forces of stress and bulk viscosity on the nodes, the heat of the viscosity and the stable increment; whether moduli vary.
    pub fn assemble(
        &mut self,
        (constants, varies): (&Constants, bool),
        increment: &Increment<'_>,
        stress: &[[Lanes; 4]; POINTS],
        (scratch, work): (&mut Workspace, &mut WorkArrays),
        corners: &mut [Corners],
    ) {
        let (triangles, dt) = (self, increment.dt);
        increment.arch.dispatch(Assembly { triangles, constants, varies, dt, stress, scratch, work, corners });
    }
}

/// See [`Triangles::measure`].
struct Measurement<'a> {
    triangles: &'a Triangles,
    increment: &'a Increment<'a>,
    work: &'a mut WorkArrays,
}

impl NullaryFnOnce for Measurement<'_> {
    type Output = ();

    /// Inlined into a function of the machine's instruction set.
    #[inline(always)]
    fn call(self) {
        let Measurement { triangles, increment, work } = self;
        let half = 0.5 * increment.dt;
        for l in 0..LANES {
            let motion = triangles.motion(l, increment.nodes);
            let Motion { r, z, v_r, v_z } = motion;
            let middle = |x: [f64; NODES], v: [f64; NODES]| inline_from_fn(|n| x[n] - half * v[n]);
            let (g, now) = (Operators::of(middle(r, v_r), middle(z, v_z)), Operators::of(r, z));
            for (p, point) in work.points.iter_mut().enumerate() {
                for (list, sum) in point.gradients.iter_mut().zip(g.gradients(p, &v_r, &v_z)) {
                    list[l] = RING * sum;
                }
                point.middle[l] = RING * g.volume[p];
                point.current_volume[l] = 2.0 * PI * now.volume[p];
            }
            work.motion[l] = motion;
            work.dilation_rate[l] = g.dilation(&v_r, &v_z);
            work.now[l] = now;
        }
    }
}

/// See [`Triangles::assemble`].
struct Assembly<'a> {
    triangles: &'a mut Triangles,
    constants: &'a Constants,
    varies: bool,
    dt: f64,
    stress: &'a [[Lanes; 4]; POINTS],
    scratch: &'a mut Workspace,
    work: &'a mut WorkArrays,
    corners: &'a mut [Corners],
}

impl NullaryFnOnce for Assembly<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Assembly { triangles, constants, varies, dt, stress: own, scratch, work, corners } = self;
        let first = scratch.at + 1 - POINTS;
        let [linear, quadratic] = constants.bulk_viscosity;
        let cap = scratch.cap;
        for l in 0..LANES {
            let (now, done) = (&work.now[l], &mut work.points);
            let largest = |of: fn(&PointIncrement) -> &Lanes| of(&done[0])[l].max(of(&done[1])[l]).max(of(&done[2])[l]);
            let (bulk, shear) = (largest(|d| &d.bulk), largest(|d| &d.shear));
            let omega = frequency_squared(now, [bulk, shear], &triangles.inverse_masses(l)).sqrt();
            let (modulus, period) = (bulk + 4.0 / 3.0 * constants.shear, 1.0 / omega);
            // Where moduli vary, the velocities at the start say how fast the volume changes.
            let rate = if dt > 0.0 || varies { work.dilation_rate[l] } else { 0.0 };
            let fraction = linear - quadratic * quadratic * 2.0 * period * rate.min(0.0);
            let damping = 2.0 * modulus * period * rate * fraction;
            let mut stress = [[0.0; 4]; POINTS];
            for p in 0..POINTS {
                stress[p] = column(&own[p], l);
                stress[p][..3].iter_mut().for_each(|s| *s += damping);
                if let Some(viscous) = scratch.task.viscous.get_mut(first + p) {
                    let heat = done[p].volume[l] * 0.5 * (viscous[l] + damping) * dt * rate;
                    viscous[l] = damping;
                    scratch.sums.viscous[l] += heat;
                    done[p].heat[l] += heat;
                }
            }
            let forces = now.forces(&stress);
            for (n, force) in forces.iter().enumerate() {
                corners[n / 4].0[n % 4][l] =
                    if triangles.deleted[l] { [0.0; 2] } else { force.inline_map(|f| -2.0 * PI * f) };
            }
            // As of quadrilaterals (`ElementBlock::forces`).
            let pressing = modulus / constants.bulk;
            let share = cap * period;
            let capped = share < 1.0;
            let xi = if capped { fraction * share * pressing } else { fraction };
            let damped = if varies { xi + (1.0 + xi * xi).sqrt() } else { damped(xi) };
            let stable = if capped { cap } else { omega } * damped;
            triangles.rate[l] = stable;
            let changing = rate.abs() * 2.0 / CHANGE;
            let rate = if triangles.deleted[l] || !scratch.weighs(l) {
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
    }
}

persist_struct!(Triangles { inverse_mass, deleted, rate } derived { nodes, volume });
