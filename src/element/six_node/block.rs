//! Six-node triangles side by side with their materials, and what one increment does to them. The points of a triangle go through
//! the same phases of laws as quadrilaterals with one point; strains and forces are those of the triangle.
//! Never here: which elements a block holds, threads.
#![allow(clippy::needless_range_loop)] // Loops over lanes and points are written as in the other phases.

use std::f64::consts::PI;

use super::triangles::{Increment, Triangles, WorkArrays, places};
use crate::element::block::{ElementBlock, Workspace};
use crate::element::constants::Constants;
use crate::element::group::block_of_points;
use crate::kernel::lanes::{Corners, InlineMap, LANES, Lanes, column, inline_from_fn};
use crate::kernel::six_node_triangle::{NODES, Operators, POINTS};
use crate::kernel::stress::mises;
use crate::material::{BlockStart, Material, PlasticFlow};
use crate::state::archive::{Persist, persist_struct};
use crate::state::nodes::Node;

/// Triangles side by side with the stress and the state of their points.
#[derive(Clone)]
pub struct TriangleBlock<S> {
    pub triangles: Triangles,
    /// The points, each with its mass.
    pub points: [ElementBlock<S>; POINTS],
}

impl<S: Clone> TriangleBlock<S> {
    /// Elements at rest, at most as many as there are lanes.
    pub fn new<M: Material<State = S>>(
        material: &M,
        density: f64,
        (first, elements): (usize, &[[u32; NODES]]),
        nodes: &[Node],
    ) -> Self {
        // Lanes after the last element repeat it; their results are not read.
        let element = |l: usize| elements[l.min(elements.len() - 1)];
        let at = |l: usize| places(element(l), nodes);
        let operators: [Operators; LANES] =
            inline_from_fn(|l| Operators::of(at(l).inline_map(|p| p[0]), at(l).inline_map(|p| p[1])));
        let area: Lanes = inline_from_fn(|l| section(&at(l)));
        let point = |p: usize| {
            let volume = operators.inline_map(|g| 2.0 * PI * g.volume[p]);
            let around = |n: usize, l: usize, i: usize| at(l)[n % NODES][i];
            let centre = |i: usize| {
                inline_from_fn(|l| (around(2 * p, l, i) + around(2 * p + 1, l, i) + around(2 * p + 5, l, i)) / 3.0)
            };
            // Damage goes by half the length of elements of second order, the length of the triangles that this one consists of.
            let corner = |l: usize, i: usize| [2 * p, 2 * p + 1, 2 * p + 5, 2 * p + 5].inline_map(|n| around(n, l, i));
            let start = BlockStart {
                count: elements.len(),
                area: area.inline_map(|a| 0.25 * a),
                volume,
                centre: [centre(0), centre(1)],
                corners: inline_from_fn(|l| [corner(l, 0), corner(l, 1)]),
                first,
            };
            block_of_points(material.initial_state(&start), volume.inline_map(|v| density * v))
        };
        let points = [point(0), point(1), point(2)];
        TriangleBlock { triangles: Triangles::new(inline_from_fn(element), density, nodes), points }
    }

    /// Mass of a lane.
    pub fn mass(&self, lane: usize) -> f64 {
        self.points.iter().map(|p| p.mass[lane]).sum()
    }

    /// One increment of a block, by its number in the group and in its task: stresses at its end, forces on the nodes, and what is
    /// added to the sums of the scratch memory.
    #[inline(always)]
    pub fn update<M: Material<State = S>>(
        &mut self,
        material: &M,
        constants: &Constants,
        increment: &Increment<'_>,
        (number, at): (usize, usize),
        (scratch, work): (&mut Workspace, &mut WorkArrays),
        corners: &mut [Corners],
    ) {
        self.triangles.measure(increment, work);
        let before = M::EQUATION_OF_STATE.then(|| {
            let lost = self.triangles.work_of_start(corners, increment, work);
            (lost, scratch.stress.internal, scratch.sums.viscous)
        });
        for p in 0..POINTS {
            scratch.prepare(number, POINTS * at + p, increment.count - number * LANES);
            self.update_point(p, material, constants, increment, scratch, work);
        }
        if M::FAILS {
            self.delete_failed(material, constants, scratch, work);
        }
        let stress = self.points.each_ref().inline_map(|point| point.stress);
        self.triangles.assemble((constants, M::MODULI_VARY), increment, &stress, (scratch, work), corners);
        let Some((lost, internal, viscous)) = before else { return };
        // The energy comes from what forces do on the nodes (compatible.rs).
        let lost = self.triangles.work_of_end(lost, corners, increment, work);
        let mass: Lanes = inline_from_fn(|l| self.mass(l));
        let mut missing = [0.0; LANES];
        for l in 0..LANES {
            let known = (scratch.stress.internal[l] - internal[l]) + (scratch.sums.viscous[l] - viscous[l]);
            missing[l] = if scratch.weighs(l) { -lost[l] - known } else { 0.0 };
            scratch.stress.internal[l] += missing[l];
        }
        for (point, done) in self.points.iter_mut().zip(&work.points) {
            let heat = inline_from_fn(|l| done.heat[l] + missing[l] * point.mass[l] / mass[l]);
            material.add_heat(&mut point.state, &heat, &point.mass);
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
        work: &mut WorkArrays,
    ) {
        let (dt, at) = (increment.dt, scratch.at);
        let (point, deleted) = (&mut self.points[p], self.triangles.deleted);
        for l in (0..LANES).filter(|l| deleted[*l]) {
            scratch.mask(l);
            scratch.stress.flow[l] = 0.0;
            point.stress.iter_mut().for_each(|s| s[l] = 0.0);
        }
        if M::FAILS {
            // The stress of the undamaged material.
            for l in (0..scratch.strain.count).filter(|l| !deleted[*l]) {
                let share = material.share(&point.state, l);
                point.stress.iter_mut().for_each(|s| s[l] /= share);
            }
        }
        scratch.set_gradients(dt, &work.points[p].gradients, &work.points[p].middle);
        material.begin(&mut point.state, increment.time);
        point.trial::<M>(constants, dt, scratch);
        if scratch.cap < f64::INFINITY {
            scratch.measure();
        }
        if M::EQUATION_OF_STATE {
            scratch.strain.current_volume = work.points[p].current_volume;
            scratch.strain.mass = point.mass;
            scratch.strain.viscous = scratch.task.viscous.get(at).copied().unwrap_or_default();
        }
        point.update_stress(material, constants, scratch);
        // Stress that answers to the whole deformation stayed.
        for l in (0..LANES).filter(|l| deleted[*l]) {
            point.stress.iter_mut().for_each(|s| s[l] = 0.0);
        }
        if !scratch.task.records.is_empty() {
            scratch.follow(increment.arch, at, &point.stress, M::FLOW, (scratch.strain.spin, dt));
        }
        let done = &mut work.points[p];
        (done.strain, done.volume) = (scratch.strain.strain, scratch.strain.volume);
        [done.bulk, done.shear] = moduli::<M>(constants, scratch);
        // Less the work of the viscosity that the law expected.
        done.heat = if M::EQUATION_OF_STATE { scratch.stress.heat.inline_map(|heat| -heat) } else { [0.0; LANES] };
    }

    /// Deletes elements of which a point has failed. The stress of the other points ends with the increment, and what they have
    /// stored counts as dissipated.
    #[inline(never)]
    fn delete_failed<M: Material<State = S>>(
        &mut self,
        material: &M,
        constants: &Constants,
        scratch: &mut Workspace,
        work: &WorkArrays,
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
            for (point, done) in self.points.iter_mut().zip(&work.points) {
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
        PlasticFlow::None if !M::EQUATION_OF_STATE => {
            [scratch.stress.bulk, scratch.stress.shear.inline_map(|s| 3.0 * s)]
        }
        _ => [scratch.stress.bulk, constant[1]],
    }
}

persist_struct!(TriangleBlock<S> [S: Persist] { triangles, points });
