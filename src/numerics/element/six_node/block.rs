//! A block of six-node triangles with their materials, and its update over one increment. The points of a triangle use
//! the same material phases as quadrilaterals with one point; strains and forces are those of the triangle.
#![allow(clippy::needless_range_loop)] // Loops over lanes and points have the same form as in the other phases.

use std::f64::consts::PI;

use super::triangles::{TriangleLanes, WorkArrays, operators_at, places};
use crate::element::block::ElementBlock;
use crate::element::constants::ElementConstants;
use crate::element::solid::{BlockPass, BlockPlace, InitialBlock, SolidIncrement};
use crate::element::strain::measure_gradients;
use crate::element::workspace::TaskWorkspace;
use crate::kernel::lanes::{BlockCornerForces, InlineMap, LANES, Lanes, column, inline_from_fn, put_column};
use crate::kernel::six_node_triangle::{NODES, POINTS, TriangleOperators};
use crate::kernel::stress::{mises, undamaged};
use crate::kernel::topology::ElementTopology;
use crate::material::volumetric::ElementSize;
use crate::material::{BlockStart, Material, PlasticFlow};
use crate::state::archive::Persist;

/// Triangles with stress and state of their points.
#[derive(Clone, Persist)]
#[persist(derived: start)]
pub struct TriangleBlock<S> {
    pub triangles: TriangleLanes,
    /// Integration points, each with its mass.
    pub points: [ElementBlock<S>; POINTS],
    /// Operators of the elements in the initial configuration, to which the deformation gradients of user subroutines
    /// refer; empty for other materials.
    pub start: Vec<TriangleOperators>,
}

impl<S: Clone> TriangleBlock<S> {
    /// Creates a block of elements at rest.
    pub fn at_rest<M: Material<State = S>>(material: &M, initial: &InitialBlock<'_, [u32; NODES]>) -> Self {
        let InitialBlock { first, elements, nodes, density } = *initial;
        // Lanes after the last element repeat it; their results are not used.
        let element = |l: usize| elements[l.min(elements.len() - 1)];
        let places_of = |l: usize| places(element(l), nodes);
        let operators: [TriangleOperators; LANES] = inline_from_fn(|l| operators_at(places_of(l)));
        let area: Lanes = inline_from_fn(|l| section(&places_of(l)));
        let point = |p: usize| {
            let volume = operators.inline_map(|g| 2.0 * PI * g.volume[p]);
            let around = |n: usize, l: usize, i: usize| places_of(l)[n % NODES][i];
            let centre = |i: usize| {
                inline_from_fn(|l| (around(2 * p, l, i) + around(2 * p + 1, l, i) + around(2 * p + 5, l, i)) / 3.0)
            };
            // The characteristic length of damage for second-order elements is half the usual one: that of the
            // subtriangles.
            let corner = |l: usize, i: usize| [2 * p, 2 * p + 1, 2 * p + 5, 2 * p + 5].inline_map(|n| around(n, l, i));
            let start = BlockStart {
                count: elements.len(),
                area: area.inline_map(|a| 0.25 * a),
                volume,
                centre: [centre(0), centre(1)],
                corners: inline_from_fn(|l| [corner(l, 0), corner(l, 1)]),
                first,
            };
            ElementBlock::of_points(material.initial_state(&start), volume.inline_map(|v| density * v))
        };
        let points = [point(0), point(1), point(2)];
        let start = if M::CALLS { operators.to_vec() } else { Vec::new() };
        TriangleBlock { triangles: TriangleLanes::new(inline_from_fn(element), density, nodes), points, start }
    }

    /// Updates the block over one increment, given its number in the group and in its task: stresses and nodal forces
    /// at the end of the increment, and the sums of the scratch memory.
    #[inline(always)]
    pub fn update<M: Material<State = S>>(
        &mut self,
        pass: &BlockPass<'_, M>,
        BlockPlace { number, at }: BlockPlace,
        (scratch, work): (&mut TaskWorkspace, &mut WorkArrays),
        corners: &mut [BlockCornerForces],
    ) {
        let BlockPass { material, ref increment, .. } = *pass;
        self.triangles.measure(increment, work);
        let sums_at_start = M::EQUATION_OF_STATE.then(|| {
            let lost = self.triangles.work_of_start(corners, increment, work);
            (lost, scratch.stress.internal, scratch.sums.viscous)
        });
        for p in 0..POINTS {
            scratch.prepare(number, POINTS * at + p, increment.count - number * LANES);
            self.measure_point(p, pass, scratch, work);
            self.update_point(p, pass, scratch, work);
        }
        self.assemble(pass, at, (scratch, work), corners);
        let Some((lost, internal, viscous)) = sums_at_start else { return };
        // The energy follows from the work of forces on the nodes (compatible.rs).
        let lost = self.triangles.work_of_end(lost, corners, increment, work);
        let mass: Lanes = inline_from_fn(|l| self.points.iter().map(|p| p.mass[l]).sum());
        let mut missing = [0.0; LANES];
        for l in 0..LANES {
            let known = (scratch.stress.internal[l] - internal[l]) + (scratch.sums.viscous[l] - viscous[l]);
            missing[l] = if scratch.is_active(l) { -lost[l] - known } else { 0.0 };
            scratch.stress.internal[l] += missing[l];
        }
        for (p, (point, done)) in self.points.iter_mut().zip(&work.points).enumerate() {
            let share: Lanes = inline_from_fn(|l| missing[l] * point.mass[l] / mass[l]);
            (0..LANES).for_each(|l| scratch.task.add_to_record(POINTS * at + p, l, [share[l], 0.0]));
            let heat = inline_from_fn(|l| done.heat[l] + share[l]);
            material.add_heat(&mut point.state, &heat, &point.mass);
        }
    }

    /// Deletes elements with a failed point, and computes the nodal forces. `scratch` is that of the last point.
    #[inline(always)]
    pub fn assemble<M: Material<State = S>>(
        &mut self,
        pass: &BlockPass<'_, M>,
        at: usize,
        (scratch, work): (&mut TaskWorkspace, &mut WorkArrays),
        corners: &mut [BlockCornerForces],
    ) {
        if M::FAILS {
            self.delete_failed(pass, at, (scratch, work));
        }
        let stress = self.points.each_ref().inline_map(|point| point.stress);
        let constants = (pass.constants, M::MODULI_VARY);
        self.triangles.assemble(constants, &pass.increment, &stress, (scratch, work), corners);
    }

    /// Computes the strain increment and the trial stress of a point.
    #[inline(always)]
    pub fn measure_point<M: Material<State = S>>(
        &mut self,
        p: usize,
        pass: &BlockPass<'_, M>,
        scratch: &mut TaskWorkspace,
        work: &WorkArrays,
    ) {
        let BlockPass { material, constants, increment: SolidIncrement { dt, time, .. } } = *pass;
        let (point, deleted) = (&mut self.points[p], self.triangles.deleted);
        for l in (0..LANES).filter(|l| deleted[*l]) {
            scratch.mask(l);
            scratch.stress.flow[l] = 0.0;
            point.stress.iter_mut().for_each(|s| s[l] = 0.0);
        }
        if M::FAILS {
            // The stress of the undamaged material.
            for l in (0..scratch.strain.count).filter(|l| !deleted[*l]) {
                let shares = [material.share(&point.state, l), material.mean_share(&point.state, l)];
                let stress = undamaged(column(&point.stress, l), shares);
                put_column(&mut point.stress, l, stress);
            }
        }
        scratch.set_gradients(dt, &work.points[p].gradients, &work.points[p].middle);
        material.begin(&mut point.state, time);
        measure_gradients::<M>(&point.stress, constants, dt, scratch);
        if M::USES_PLACE {
            let cell = ElementTopology::SixNodeTriangle.cells()[p];
            scratch.set_places(|l| {
                let places = work.places(l);
                [0, 1].inline_map(|axis: usize| cell.inline_map(|n| places[n][axis]))
            });
        }
        if scratch.cap < f64::INFINITY {
            scratch.measure();
        }
        if M::EQUATION_OF_STATE {
            scratch.strain.current_volume = work.points[p].current_volume;
            scratch.strain.mass = point.mass;
            scratch.strain.viscous = scratch.task.controls[scratch.at].viscous;
        }
    }

    /// Updates the stress of a point to the end of an increment.
    #[inline(always)]
    pub fn update_point<M: Material<State = S>>(
        &mut self,
        p: usize,
        pass: &BlockPass<'_, M>,
        scratch: &mut TaskWorkspace,
        work: &mut WorkArrays,
    ) {
        let BlockPass { material, constants, increment: SolidIncrement { dt, arch, .. } } = *pass;
        let index = scratch.at;
        let (point, deleted) = (&mut self.points[p], self.triangles.deleted);
        point.update_stress(material, constants, scratch);
        // Materials that compute stress from the total deformation have set it again.
        for l in (0..LANES).filter(|l| deleted[*l]) {
            point.stress.iter_mut().for_each(|s| s[l] = 0.0);
        }
        if !scratch.task.records.is_empty() {
            scratch.update_record(arch, index, M::FLOW, (scratch.strain.spin, dt));
        }
        let increment_of_point = &mut work.points[p];
        (increment_of_point.strain, increment_of_point.volume) = (scratch.strain.strain, scratch.strain.volume);
        [increment_of_point.bulk, increment_of_point.shear] = moduli::<M>(constants, scratch);
        // Subtracts the viscous work that the material expected.
        increment_of_point.heat =
            if M::EQUATION_OF_STATE { scratch.stress.heat.inline_map(|heat| -heat) } else { [0.0; LANES] };
    }

    /// Deletes elements with a failed point. The stress of the other points ends with the increment, and their stored
    /// energy counts as dissipated.
    #[inline(never)]
    fn delete_failed<M: Material<State = S>>(
        &mut self,
        &BlockPass { material, constants, .. }: &BlockPass<'_, M>,
        at: usize,
        (scratch, work): (&mut TaskWorkspace, &WorkArrays),
    ) {
        for l in 0..LANES {
            if l >= scratch.strain.count {
                // Lanes after the last element repeat it.
                self.triangles.deleted[l] = self.triangles.deleted[scratch.strain.count - 1];
                continue;
            }
            if self.triangles.deleted[l] || self.points.iter().all(|point| material.share(&point.state, l) > 0.0) {
                continue;
            }
            self.triangles.deleted[l] = true;
            for (p, (point, done)) in self.points.iter_mut().zip(&work.points).enumerate() {
                let (stress, volume) = (column(&point.stress, l), done.volume[l]);
                let double = |i: usize| done.strain[i][l] * stress[i];
                let undone = 0.5 * volume * ((double(0) + double(1)) + (double(2) + 2.0 * double(3)));
                scratch.stress.internal[l] -= undone;
                scratch.task.add_to_record(POINTS * at + p, l, [-undone, 0.0]);
                let share = material.share(&point.state, l);
                // User subroutines know what energy is stored.
                if share > 0.0 && !M::CALLS {
                    let (mises, mean) = (mises(stress), (stress[0] + stress[1] + stress[2]) / 3.0);
                    let distortion = if constants.shear > 0.0 { mises * mises / (6.0 * constants.shear) } else { 0.0 };
                    let element = ElementSize { volume: done.current_volume[l], mass: point.mass[l] };
                    // The energy is that of the undamaged material times its factor; the stress has this factor.
                    let stored = match material.recoverable_energy(&point.state, l, element) {
                        Some(energy) => distortion / share + share * energy / volume,
                        None => (distortion + 0.5 * mean * mean / done.bulk[l]) / share,
                    };
                    // The stress has done half of the work of the increment less.
                    let lost = volume * stored - undone;
                    scratch.stress.dissipated[l] += lost;
                    scratch.stress.damaged[l] += lost;
                    scratch.task.add_to_record(POINTS * at + p, l, [0.0, lost]);
                }
                point.stress.iter_mut().for_each(|s| s[l] = 0.0);
            }
        }
    }
}

/// Returns the area of the plane section.
fn section(places: &[[f64; 2]; NODES]) -> f64 {
    let cross = |i: usize| {
        let (p, q) = (places[i], places[(i + 1) % NODES]);
        0.5 * (p[0] * q[1] - q[0] * p[1])
    };
    (0..NODES).map(cross).sum()
}

/// Returns the moduli that bound the frequencies of a point: those of its material if they vary. The shear modulus of
/// rubber is a mean of three values; three times it is an upper bound.
#[inline(always)]
fn moduli<M: Material>(constants: &ElementConstants, scratch: &TaskWorkspace) -> [Lanes; 2] {
    let constant = [[constants.bulk; LANES], [constants.shear; LANES]];
    match M::FLOW {
        _ if !M::MODULI_VARY => constant,
        PlasticFlow::None if !M::EQUATION_OF_STATE => {
            [scratch.stress.bulk, scratch.stress.shear.inline_map(|s| 3.0 * s)]
        }
        _ => [scratch.stress.bulk.inline_map(|bulk| bulk.max(0.0)), constant[1]],
    }
}
