//! A block of six-node triangles without their materials: motion, strains of points, nodal forces, stable time
//! increments. Compiled once for all materials.
#![allow(clippy::needless_range_loop)] // Loops over lanes and points have the same form as in the other phases.

use std::f64::consts::PI;

use pulp::NullaryFnOnce;

use crate::element::constants::{CHANGE, ElementConstants, damped};
use crate::element::lane_sums::is_larger;
use crate::element::solid::SolidIncrement;
use crate::element::workspace::TaskWorkspace;
use crate::kernel::bulk_viscosity::{BulkViscosity, slow_rate};
use crate::kernel::lanes::{BlockCornerForces, InlineMap, LANES, Lanes, column, inline_from_fn};
use crate::kernel::quad::UNIT;
use crate::kernel::six_node_triangle::{NODES, POINTS, TriangleOperators, frequency_squared, masses};
use crate::state::archive::Persist;
use crate::state::nodes::Node;

/// Blocks of corner forces per block of triangles.
pub const FORCE_BLOCKS: usize = 2;

/// Factor from volumes per radian to those of [`TaskWorkspace`]: full rings in [`UNIT`].
const RING: f64 = 2.0 * PI / UNIT;

/// Nodes, masses and deletion state of a block of triangles.
#[derive(Clone, Persist)]
#[persist(derived: nodes, volume)]
pub struct TriangleLanes {
    /// Nodes around each element from a corner, counter-clockwise.
    nodes: [[u32; LANES]; NODES],
    /// Inverse masses of the nodes.
    pub inverse_mass: [Lanes; NODES],
    /// Initial volume.
    volume: Lanes,
    /// Whether an element is deleted.
    pub deleted: [bool; LANES],
    /// Two over the stable time increments of the last pass.
    pub rate: Lanes,
}

/// Positions and velocities of the nodes of a lane.
#[derive(Clone, Copy, Default)]
struct TriangleMotion {
    r: [f64; NODES],
    z: [f64; NODES],
    v_r: [f64; NODES],
    v_z: [f64; NODES],
}

/// Increment of one point of each lane.
#[derive(Clone, Copy, Default)]
pub struct PointIncrement {
    /// Velocity gradients at mid-increment times the volumes there, and these volumes, as input of
    /// [`TaskWorkspace::set_gradients`].
    pub gradients: [Lanes; 5],
    pub middle: Lanes,
    /// Volumes at the end of the increment.
    pub current_volume: Lanes,
    /// Strain increments, and volumes at mid-increment (0 for lanes without element).
    pub strain: [Lanes; 4],
    pub volume: Lanes,
    /// Moduli at the end of the increment.
    pub bulk: Lanes,
    pub shear: Lanes,
    /// Heat of the bulk viscosity that exceeds what the material expected.
    pub heat: Lanes,
}

/// Work arrays for the update of one block of elements.
#[derive(Clone, Default)]
pub struct WorkArrays {
    motion: [TriangleMotion; LANES],
    /// Relative rate of volume at mid-increment.
    dilation_rate: Lanes,
    /// Operators at the end of the increment.
    now: [TriangleOperators; LANES],
    pub points: [PointIncrement; POINTS],
}

impl WorkArrays {
    /// Returns the positions of the nodes of a lane.
    pub fn places(&self, l: usize) -> [[f64; 2]; NODES] {
        inline_from_fn(|n| [self.motion[l].r[n], self.motion[l].z[n]])
    }

    /// Returns the deformation gradients (rr, zz, hoop, rz, zr) of a point of each lane since the configuration with
    /// these operators.
    pub fn deformation(&self, p: usize, start: &[TriangleOperators]) -> [Lanes; 5] {
        let mut gradients = [[0.0; LANES]; 5];
        for (l, (g, TriangleMotion { r, z, .. })) in start.iter().zip(&self.motion).enumerate() {
            for (list, sum) in gradients.iter_mut().zip(g.gradients(p, r, z)) {
                list[l] = sum / g.volume[p];
            }
        }
        gradients
    }
}

/// Returns the positions of the nodes of an element.
pub fn places(element: [u32; NODES], nodes: &[Node]) -> [[f64; 2]; NODES] {
    element.inline_map(|n| nodes[n as usize].place())
}

/// Returns the operators of an element with nodes at these places. Compiled once for all materials.
#[inline(never)]
pub fn operators_at(places: [[f64; 2]; NODES]) -> TriangleOperators {
    TriangleOperators::of(places.inline_map(|p| p[0]), places.inline_map(|p| p[1]))
}

impl TriangleLanes {
    /// Creates a block from the nodes of its elements in the initial configuration.
    pub fn new(elements: [[u32; NODES]; LANES], density: f64, nodes: &[Node]) -> Self {
        let positions = elements.inline_map(|element| places(element, nodes));
        let masses = positions.inline_map(|positions| masses(positions, density));
        TriangleLanes {
            nodes: inline_from_fn(|n| elements.inline_map(|element| element[n])),
            inverse_mass: inline_from_fn(|n| masses.inline_map(|masses| 1.0 / masses[n])),
            volume: positions.inline_map(|positions| 2.0 * PI * operators_at(positions).total()),
            deleted: [false; LANES],
            rate: [0.0; LANES],
        }
    }

    /// Returns the node indices of the element in a lane.
    pub fn element(&self, lane: usize) -> [u32; NODES] {
        self.nodes.inline_map(|list| list[lane])
    }

    /// Returns the inverse masses of the six nodes of the element in a lane.
    pub fn inverse_masses(&self, lane: usize) -> [f64; NODES] {
        self.inverse_mass.inline_map(|list| list[lane])
    }

    /// Returns the motion of a lane; a deleted element is replaced by one of its volume at rest.
    #[inline(always)]
    fn motion(&self, l: usize, nodes: &[Node]) -> TriangleMotion {
        if self.deleted[l] {
            let height = 0.75 * self.volume[l] / PI;
            let (r, z) = ([1.0, 1.5, 2.0, 1.5, 1.0, 1.0], [0.0, 0.0, 0.0, 0.5, 1.0, 0.5].inline_map(|z| height * z));
            return TriangleMotion { r, z, ..TriangleMotion::default() };
        }
        let mut motion = TriangleMotion::default();
        for n in 0..NODES {
            let node = &nodes[self.nodes[n][l] as usize];
            (motion.r[n], motion.z[n], motion.v_r[n], motion.v_z[n]) = (node.r, node.z, node.v_r, node.v_z);
        }
        motion
    }

    /// Computes motion, volumes and velocity gradients into the work arrays.
    pub fn measure(&self, increment: &SolidIncrement<'_>, work: &mut WorkArrays) {
        increment.arch.dispatch(TriangleMeasurement { triangles: self, increment, work });
    }

    /// Returns the energy that the elements lose to the forces of the start of an increment; see
    /// [`TaskWorkspace::begin_energy_correction`].
    pub fn work_of_start(
        &self,
        corners: &[BlockCornerForces],
        increment: &SolidIncrement<'_>,
        work: &WorkArrays,
    ) -> Lanes {
        let SolidIncrement { dt, before, .. } = *increment;
        let share = 0.5 * before.half * (dt - before.half);
        let mut lost = [0.0; LANES];
        for n in 0..NODES {
            for l in 0..LANES {
                let ([f_r, f_z], motion) =
                    ([0, 1].inline_map(|axis: usize| corners[n / 4][n % 4][axis][l]), &work.motion[l]);
                let [a_r, a_z] = before.accelerations.get(self.nodes[n][l] as usize).copied().unwrap_or_default();
                lost[l] +=
                    f_r * (0.5 * dt * motion.v_r[n] - share * a_r) + f_z * (0.5 * dt * motion.v_z[n] - share * a_z);
            }
        }
        lost
    }

    /// Adds the energy that the elements lose to the forces of the end of the increment.
    pub fn work_of_end(
        &self,
        mut lost: Lanes,
        corners: &[BlockCornerForces],
        increment: &SolidIncrement<'_>,
        work: &WorkArrays,
    ) -> Lanes {
        for n in 0..NODES {
            for l in 0..LANES {
                let ([f_r, f_z], motion) =
                    ([0, 1].inline_map(|axis: usize| corners[n / 4][n % 4][axis][l]), &work.motion[l]);
                lost[l] += 0.5 * increment.dt * (f_r * motion.v_r[n] + f_z * motion.v_z[n]);
            }
        }
        lost
    }

    /// Computes the nodal forces of stress and bulk viscosity, the heat of the viscosity and the stable time increment.
    /// `varies` selects moduli that vary.
    pub fn assemble(
        &mut self,
        (constants, varies): (&ElementConstants, bool),
        increment: &SolidIncrement<'_>,
        stress: &[[Lanes; 4]; POINTS],
        (scratch, work): (&mut TaskWorkspace, &mut WorkArrays),
        corners: &mut [BlockCornerForces],
    ) {
        let (triangles, dt) = (self, increment.dt);
        increment.arch.dispatch(TriangleAssembly { triangles, constants, varies, dt, stress, scratch, work, corners });
    }
}

/// Arguments of [`TriangleLanes::measure`], as an operation for the selected instruction set.
struct TriangleMeasurement<'a> {
    triangles: &'a TriangleLanes,
    increment: &'a SolidIncrement<'a>,
    work: &'a mut WorkArrays,
}

impl NullaryFnOnce for TriangleMeasurement<'_> {
    type Output = ();

    /// Executes the operation. It is inlined into a function compiled for the selected instruction set.
    #[inline(always)]
    fn call(self) {
        let TriangleMeasurement { triangles, increment, work } = self;
        let half = 0.5 * increment.dt;
        for l in 0..LANES {
            let motion = triangles.motion(l, increment.nodes);
            let TriangleMotion { r, z, v_r, v_z } = motion;
            let middle = |x: [f64; NODES], v: [f64; NODES]| inline_from_fn(|n| x[n] - half * v[n]);
            let (g, now) = (TriangleOperators::of(middle(r, v_r), middle(z, v_z)), TriangleOperators::of(r, z));
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

/// Arguments of [`TriangleLanes::assemble`], as an operation for the selected instruction set.
struct TriangleAssembly<'a> {
    triangles: &'a mut TriangleLanes,
    constants: &'a ElementConstants,
    varies: bool,
    dt: f64,
    stress: &'a [[Lanes; 4]; POINTS],
    scratch: &'a mut TaskWorkspace,
    work: &'a mut WorkArrays,
    corners: &'a mut [BlockCornerForces],
}

impl NullaryFnOnce for TriangleAssembly<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let TriangleAssembly { triangles, constants, varies, dt, stress: own, scratch, work, corners } = self;
        let first = scratch.at + 1 - POINTS;
        let BulkViscosity { linear, quadratic, .. } = constants.bulk_viscosity;
        let filter = constants.bulk_viscosity.filter();
        let cap = scratch.cap;
        for l in 0..LANES {
            let (now, points) = (&work.now[l], &mut work.points);
            let largest =
                |of: fn(&PointIncrement) -> &Lanes| of(&points[0])[l].max(of(&points[1])[l]).max(of(&points[2])[l]);
            let (bulk, shear) = (largest(|d| &d.bulk), largest(|d| &d.shear));
            let omega = frequency_squared(now, [bulk, shear], &triangles.inverse_masses(l)).sqrt();
            let (modulus, period) = (bulk + 4.0 / 3.0 * constants.shear, 1.0 / omega);
            // If moduli vary, the velocities at the start of the analysis determine the rate of volume.
            let rate = if dt > 0.0 || varies { work.dilation_rate[l] } else { 0.0 };
            let fraction = linear - quadratic * quadratic * 2.0 * period * rate.min(0.0);
            let mut slow = 0.0;
            if constants.bulk_viscosity.filters() {
                let stored = &mut scratch.task.controls[first].slow_dilation[l];
                slow = if dt > 0.0 { slow_rate(*stored, rate, dt * omega, filter) } else { work.dilation_rate[l] };
                *stored = slow;
            }
            let scale = 2.0 * modulus * period;
            let damping = scale * rate * fraction - scale * slow * linear;
            let mut stress = [[0.0; 4]; POINTS];
            for p in 0..POINTS {
                stress[p] = column(&own[p], l);
                stress[p][..3].iter_mut().for_each(|s| *s += damping);
                let viscous = &mut scratch.task.controls[first + p].viscous[l];
                let heat = points[p].volume[l] * 0.5 * (*viscous + damping) * dt * rate;
                *viscous = damping;
                scratch.sums.viscous[l] += heat;
                points[p].heat[l] += heat;
            }
            let forces = now.forces(&stress);
            for (n, force) in forces.iter().enumerate() {
                for (list, force) in corners[n / 4][n % 4].iter_mut().zip(force) {
                    list[l] = if triangles.deleted[l] { 0.0 } else { -2.0 * PI * force };
                }
            }
            // As for quadrilaterals (`ElementBlock::forces`).
            let pressing = modulus / constants.bulk;
            let share = cap * period;
            let capped = share < 1.0;
            let xi = if capped { fraction * share * pressing } else { fraction };
            let damped = if varies { xi + (1.0 + xi * xi).sqrt() } else { damped(xi) };
            let stable = if capped { cap } else { omega } * damped;
            triangles.rate[l] = stable;
            let changing = rate.abs() * 2.0 / CHANGE;
            let rate = if triangles.deleted[l] || !scratch.is_active(l) {
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
