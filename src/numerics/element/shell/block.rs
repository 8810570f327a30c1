//! Update of a block of shells over an increment: strains, section points, thickness, nodal forces and stable rate.
#![allow(clippy::needless_range_loop)] // Compilers vectorize loops over lanes in this form.

use pulp::{Simd, WithSimd};

use super::group::{ShellGroup, ShellState};
use super::record::ShellRecord;
use super::section::{LayerProperties, ShellProperties, ThicknessPoint, ThicknessRule};
use crate::element::constants::CHANGE;
use crate::kernel::laminate::PointElasticity;
use crate::kernel::lanes::{BlockCornerForces, InlineMap, LANES, Lanes};
use crate::kernel::pack::{Pack, PackPosition};
use crate::kernel::plane_return::{PlaneReturns, PlaneTrial};
use crate::kernel::real::Real;
use crate::kernel::shell::{SectionComponents, ShellFrame};
use crate::kernel::transcendental::exp;
use crate::state::nodes::Node;

const ZERO: Lanes = [0.0; LANES];

/// Kinematics and sums of the elements of a block.
#[derive(Clone, Copy, Debug, Default)]
struct ShellLanes {
    /// Coordinates of both ends at the end of the increment.
    places: [[Lanes; 2]; 2],
    /// Displacements of both ends and their rotations over the increment.
    steps: [[Lanes; 3]; 2],
    masses: [Lanes; 4],
    thickness: Lanes,
    shear: Lanes,
    slow_rates: [Lanes; 2],
    viscous: [Lanes; 2],
    strains: [Lanes; 5],
    /// Forces and moments of the stress per thickness and half thickness: integrals over a unit thickness.
    integrals: [Lanes; 4],
    /// Plastic work per thickness and area, and the strain through the thickness.
    plastic: Lanes,
    thinning: Lanes,
}

/// Results of the elements of a block.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ShellBlockTotals {
    /// Work of the stress, plastic work, work of the viscosity.
    pub work: [Lanes; 3],
    /// One over the stable time increment.
    pub rate: Lanes,
}

/// Update of the elements of the block `index`.
pub(super) struct ShellBlockUpdate<'a> {
    pub group: &'a mut ShellGroup,
    pub index: usize,
    pub nodes: &'a [Node],
    pub dt: f64,
    pub corners: &'a mut BlockCornerForces,
}

impl WithSimd for ShellBlockUpdate<'_> {
    type Output = ShellBlockTotals;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) -> ShellBlockTotals {
        let mut lanes = self.read();
        for at in (0..PackPosition::<S>::COUNT).map(|index| PackPosition::new(simd, index)) {
            lanes.measure_strains(at);
        }
        self.update_points(&mut lanes);
        lanes.update_thickness(&self.group.section, self.dt);
        let mut totals = ShellBlockTotals::default();
        for at in (0..PackPosition::<S>::COUNT).map(|index| PackPosition::new(simd, index)) {
            lanes.update_forces(at, (&self.group.section, self.dt), self.corners, &mut totals);
        }
        self.store(&lanes, &totals);
        self.clear_unused();
        totals
    }
}

impl ShellBlockUpdate<'_> {
    /// Returns the element of a lane. Lanes beyond the last element repeat it.
    fn element(&self, lane: usize) -> usize {
        (self.index * LANES + lane).min(self.group.ends.len() - 1)
    }

    /// Returns the number of lanes with an element.
    fn count(&self) -> usize {
        LANES.min(self.group.ends.len() - self.index * LANES)
    }

    #[inline(always)]
    fn read(&self) -> ShellLanes {
        let mut lanes = ShellLanes::default();
        for l in 0..LANES {
            let element = self.element(l);
            let ends = self.group.ends[element].inline_map(|n| &self.nodes[n as usize]);
            for end in 0..2 {
                let (node, turn) = (ends[end], ends[2 + end]);
                (lanes.places[end][0][l], lanes.places[end][1][l]) = (node.r, node.z);
                for (axis, velocity) in [node.v_r, node.v_z, turn.v_r].into_iter().enumerate() {
                    lanes.steps[end][axis][l] = self.dt * velocity;
                }
            }
            lanes.masses.iter_mut().zip(self.group.masses[element]).for_each(|(list, mass)| list[l] = mass);
            let ShellState { thickness, shear, slow_rates, viscous } = self.group.state[element];
            (lanes.thickness[l], lanes.shear[l]) = (thickness, shear);
            for i in 0..2 {
                (lanes.slow_rates[i][l], lanes.viscous[i][l]) = (slow_rates[i], viscous[i]);
            }
        }
        lanes
    }

    /// Updates the section points, and integrates stress, plastic work and strain through the thickness.
    #[inline(always)]
    fn update_points(&mut self, lanes: &mut ShellLanes) {
        let section = self.group.section.clone();
        for (index, &point) in section.points.iter().enumerate() {
            let stress = self.update_point(&section, lanes, (index, point));
            let ThicknessPoint { place, weight, .. } = point;
            for l in 0..LANES {
                for axis in 0..2 {
                    lanes.integrals[axis][l] += weight * stress[axis][l];
                    lanes.integrals[2 + axis][l] += weight * place * stress[axis][l];
                }
            }
        }
    }

    /// Updates a section point of all lanes; returns its stress.
    #[inline(always)]
    fn update_point(
        &mut self,
        section: &ShellProperties,
        lanes: &mut ShellLanes,
        (point, ThicknessPoint { place, weight, layer }): (usize, ThicknessPoint),
    ) -> [Lanes; 2] {
        let index = |element: usize| element * section.points.len() + point;
        let mut previous = [ZERO; 2];
        for l in 0..LANES {
            let stress = self.group.stress[index(self.element(l))];
            (previous[0][l], previous[1][l]) = (stress[0], stress[1]);
        }
        if self.dt == 0.0 {
            return previous;
        }
        let mut strain = [ZERO; 2];
        for l in 0..LANES {
            let height = 0.5 * place * lanes.thickness[l];
            for axis in 0..2 {
                strain[axis][l] = lanes.strains[axis][l] + height * lanes.strains[2 + axis][l];
            }
        }
        let layer = &section.layers[layer];
        let (returned, work) = self.return_point(layer, (&previous, &strain), index);
        let mut thinning = ZERO;
        let per_stress = layer.elasticity.thinning();
        for l in 0..LANES {
            let change = [0, 1].inline_map(|axis: usize| returned.stress[axis][l] - previous[axis][l]);
            thinning[l] = per_stress * (change[0] + change[1]) - (returned.plastic[0][l] + returned.plastic[1][l]);
            lanes.thinning[l] += weight * thinning[l];
            lanes.plastic[l] += weight * work[l];
        }
        for l in 0..self.count() {
            let point_index = index(self.element(l));
            if self.group.is_deleted(self.element(l)) {
                continue;
            }
            self.group.stress[point_index] = returned.stress.inline_map(|list| list[l]);
            if let Some(ShellRecord { points, .. }) = self.group.record.as_deref_mut() {
                let strain = [strain[0][l], strain[1][l], thinning[l]];
                points[point_index].follow(strain, returned.plastic.inline_map(|list| list[l]), self.dt);
            }
        }
        returned.stress
    }

    /// Returns the stress of a section point after a strain increment and the plastic work per volume, that of the mean of
    /// previous and new stress; updates the plastic state.
    #[inline(always)]
    fn return_point(
        &mut self,
        layer: &LayerProperties,
        (before, strain): (&[Lanes; 2], &[Lanes; 2]),
        index: impl Fn(usize) -> usize,
    ) -> (PlaneReturns, Lanes) {
        let trial = trial_stress(&layer.elasticity, before, strain);
        let (Some(flowing), PointElasticity::Isotropic(elastic)) = (&layer.flowing, &layer.elasticity) else {
            return (PlaneReturns { stress: trial, flow: ZERO, plastic: [ZERO; 2] }, ZERO);
        };
        let (mut plastic, mut temperature) = (ZERO, ZERO);
        for l in 0..LANES {
            let state = self.group.flow[index(self.element(l))];
            (plastic[l], temperature[l]) = (state.strain, state.temperature);
        }
        let trial_state = PlaneTrial { stress: &trial, strain: &plastic, temperature: &temperature, dt: self.dt };
        let returned = elastic.returned_lanes(&flowing.law, trial_state, self.count());
        let mut work = ZERO;
        for l in 0..LANES {
            let half = |axis: usize| 0.5 * (before[axis][l] + returned.stress[axis][l]) * returned.plastic[axis][l];
            work[l] = half(0) + half(1);
        }
        for l in (0..self.count()).filter(|l| returned.flow[*l] != 0.0) {
            let point_index = index(self.element(l));
            let state = &mut self.group.flow[point_index];
            state.strain += returned.flow[l];
            state.temperature += flowing.heating.rise(state.temperature, [work[l]]);
        }
        (returned, work)
    }

    /// Sets the forces of deleted elements, and of lanes without an element, to zero.
    #[inline(always)]
    fn clear_unused(&mut self) {
        let count = self.count();
        for l in (0..LANES).filter(|l| *l >= count || self.group.is_deleted(self.index * LANES + l)) {
            self.corners.as_flattened_mut().iter_mut().for_each(|list| list[l] = 0.0);
        }
    }

    /// Stores the state of the elements, and their recorded strains and work.
    #[inline(always)]
    fn store(&mut self, lanes: &ShellLanes, totals: &ShellBlockTotals) {
        for l in 0..self.count() {
            let element = self.element(l);
            if self.group.is_deleted(element) {
                continue;
            }
            self.group.state[element] = ShellState {
                thickness: lanes.thickness[l],
                shear: lanes.shear[l],
                slow_rates: lanes.slow_rates.inline_map(|list| list[l]),
                viscous: lanes.viscous.inline_map(|list| list[l]),
            };
            if let Some(ShellRecord { elements, .. }) = self.group.record.as_deref_mut() {
                let followed = &mut elements[element];
                followed.section.iter_mut().zip(&lanes.strains).for_each(|(sum, strain)| *sum += strain[l]);
                let [stress, plastic, _] = totals.work;
                followed.work = [followed.work[0] + stress[l], followed.work[1] + plastic[l]];
            }
        }
    }
}

/// Returns the elastic trial stress of all lanes after a strain increment.
#[inline(always)]
fn trial_stress(elasticity: &PointElasticity, before: &[Lanes; 2], strain: &[Lanes; 2]) -> [Lanes; 2] {
    let mut trial = [ZERO; 2];
    match elasticity {
        PointElasticity::Isotropic(elastic) => {
            for l in 0..LANES {
                let after = elastic.trial([before[0][l], before[1][l]], [strain[0][l], strain[1][l]]);
                (trial[0][l], trial[1][l]) = (after[0], after[1]);
            }
        }
        PointElasticity::Orthotropic(plane) => {
            for l in 0..LANES {
                let after = plane.trial([before[0][l], before[1][l]], [strain[0][l], strain[1][l]]);
                (trial[0][l], trial[1][l]) = (after[0], after[1]);
            }
        }
    }
    trial
}

impl ShellLanes {
    #[inline(always)]
    fn places<S: Simd>(&self, at: PackPosition<S>) -> [[Pack<S>; 2]; 2] {
        [at.load_all(&self.places[0]), at.load_all(&self.places[1])]
    }

    #[inline(always)]
    fn steps<S: Simd>(&self, at: PackPosition<S>) -> [[Pack<S>; 3]; 2] {
        [at.load_all(&self.steps[0]), at.load_all(&self.steps[1])]
    }

    /// Measures the strains at mid-increment.
    #[inline(always)]
    fn measure_strains<S: Simd>(&mut self, at: PackPosition<S>) {
        let ([a, b], [c, d]) = (self.places(at), self.steps(at));
        let half = at.splat(0.5);
        let middle =
            ShellFrame::new([[a[0] - half * c[0], a[1] - half * c[1]], [b[0] - half * d[0], b[1] - half * d[1]]]);
        let strains = middle.strains([c, d]);
        for (list, strain) in self.strains.iter_mut().zip(strains) {
            at.store(strain, list);
        }
    }

    #[inline(always)]
    fn update_thickness(&mut self, section: &ShellProperties, dt: f64) {
        if dt == 0.0 {
            return;
        }
        for l in 0..LANES {
            if let ThicknessRule::Ratio(ratio) = section.thinning {
                self.thinning[l] = -ratio / (1.0 - ratio) * (self.strains[0][l] + self.strains[1][l]);
            }
            self.shear[l] += section.stiffness.shear() * self.strains[4][l];
            // Plastic work is per thickness before the change.
            self.plastic[l] *= self.thickness[l];
        }
        let factor = exp(&self.thinning);
        for l in 0..LANES {
            self.thickness[l] *= factor[l];
        }
    }

    /// Returns forces and moments of the stress per length. Equation (8.3).
    #[inline(always)]
    fn resultants<S: Simd>(&self, at: PackPosition<S>) -> SectionComponents<Pack<S>> {
        let thickness = at.load(&self.thickness);
        let bending = at.splat(0.5) * thickness * thickness;
        let [n_s, n_h, m_s, m_h] = at.load_all(&self.integrals);
        [thickness * n_s, thickness * n_h, bending * m_s, bending * m_h, at.load(&self.shear)]
    }

    /// Replaces the corner forces; computes the work over the increment and the stable rate.
    #[inline(always)]
    fn update_forces<S: Simd>(
        &mut self,
        at: PackPosition<S>,
        (section, dt): (&ShellProperties, f64),
        corners: &mut BlockCornerForces,
        totals: &mut ShellBlockTotals,
    ) {
        let frame = ShellFrame::new(self.places(at));
        let (masses, thickness) = (at.load_all(&self.masses), at.load(&self.thickness));
        let strains = [0, 1, 2, 3].inline_map(|i: usize| at.load(&self.strains[i]));
        let per_dt = at.splat(if dt > 0.0 { 1.0 / dt } else { 0.0 });
        let sums = [strains[0] + strains[1], strains[2] + strains[3]];
        let rates = sums.inline_map(|sum| per_dt * sum);
        let previous = (at.load_all(&self.slow_rates), thickness);
        let slow = section.slow_rates(&frame, &masses, previous, rates, dt);
        let [force, moment] = section.viscosity(&frame, &masses, thickness, rates, slow);
        let [n_s, n_h, m_s, m_h, q] = self.resultants(at);
        let forces = frame.forces(&[n_s + force, n_h + force, m_s + moment, m_h + moment, q]);
        let work = put(at, &forces, &self.steps(at), corners);
        let area = frame.area();
        let previous = at.load_all(&self.viscous);
        // By the trapezoidal rule, as the work of all forces.
        let viscous = at.splat(0.5) * area * ((previous[0] + force) * sums[0] + (previous[1] + moment) * sums[1]);
        at.store_all([work - viscous, area * at.load(&self.plastic), viscous], &mut totals.work);
        at.store_all(slow, &mut self.slow_rates);
        at.store_all([force, moment], &mut self.viscous);
        let section_rate = section.rate(&frame, &masses, thickness, rates[0]);
        let change = per_dt * (strains[0].size() + strains[1].size()) / at.splat(CHANGE);
        at.store(change.if_larger_rate(section_rate, change, section_rate), &mut totals.rate);
    }
}

/// Replaces the forces of a pack and returns the work of the previous and the new forces over the increment, by the
/// trapezoidal rule: energy gained by the elements.
#[inline(always)]
fn put<S: Simd>(
    at: PackPosition<S>,
    forces: &[[Pack<S>; 3]; 2],
    steps: &[[Pack<S>; 3]; 2],
    corners: &mut BlockCornerForces,
) -> Pack<S> {
    let half = at.splat(0.5);
    let mut work = at.splat(0.0);
    for end in 0..2 {
        for axis in 0..3 {
            let (corner, component) = if axis < 2 { (end, axis) } else { (2 + end, 0) };
            let list = &mut corners[corner][component];
            work = work - half * (at.load(list) + forces[end][axis]) * steps[end][axis];
            at.store(forces[end][axis], list);
        }
    }
    work
}
