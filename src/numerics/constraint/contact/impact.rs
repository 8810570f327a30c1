//! Surfaces that are about to touch: the limit of the time increment by their closing speed; see `impact_limit.rs`.

use super::ContactConstraint;
use super::impact_limit::{AHEAD, LARGEST_COMPRESSION, SOFT};
use super::pairs::{ContactPair, pair_of};
use super::sweeps::{ContactRow, NONE};
use crate::state::dofs::{Dof, Dofs};

impl ContactConstraint {
    /// Limits the increments until surfaces touch that approach each other at the start of their contact.
    pub(super) fn limit_first_impacts(&mut self, dofs: &Dofs) {
        let is_limited = self.pairs.iter().any(|pair| pair.thickness < f64::INFINITY);
        if self.dofs.half != 0.0 || self.surfaces.uncovered || !is_limited {
            return;
        }
        self.read_motion(dofs, 0.0);
        for (&(dof, _), velocity) in self.dofs.list.iter().zip(&mut self.dofs.motion.velocity) {
            if let Dof::Body(body) = dof {
                *velocity = dofs.bodies[body].velocity;
            }
        }
        self.search();
        self.measure_curves();
        self.limit_impacts(0.0);
        self.measured.rows.clear();
        self.measured.facets.clear();
        // The first increment searches again.
        self.surfaces.listed.clear();
    }

    /// Limits the next increments by the surfaces that are about to touch after an increment of length `dt`; with 0, by all
    /// surfaces closer than the thickness of their elements. Equation (10.18).
    pub(super) fn limit_impacts(&mut self, dt: f64) {
        if self.surfaces.near.dofs.is_empty() {
            return;
        }
        let active = self.surfaces.active.list.iter().map(|index| &self.pairs[*index as usize]);
        let of_inactive = SOFT * self.surfaces.active.thinnest_inactive;
        let open = active.filter(|pair| !pair.has_touched);
        let thinnest = open.fold(of_inactive, |thinnest, pair| thinnest.min(SOFT * pair.thickness));
        if thinnest == f64::INFINITY {
            return;
        }
        // Both surfaces may have components along r and z.
        let slow = if dt > 0.0 { LARGEST_COMPRESSION * thinnest / (4.0 * AHEAD * dt) } else { 0.0 };
        if !self.surfaces.near.dofs.iter().any(|&dof| self.dofs.motion.velocity[dof as usize].abs() > slow) {
            return;
        }
        for &index in &self.surfaces.active.list {
            let pair = &mut self.pairs[index as usize];
            pair.has_touched |= touches(pair, &self.keys.pressures);
        }
        for row in self.measured.rows.rows.iter().filter(|row| !row.is_single_point && row.closest_point.is_none()) {
            let pair = &self.pairs[pair_of(&self.pairs, row.key)];
            if !pair.has_touched {
                self.impact.add_if_near(self.approach_of(row), self.thickness_of(pair), dt);
            }
        }
        for index in 0..self.surfaces.active.analytical.len() {
            let pair = self.surfaces.active.analytical[index] as usize;
            if !self.pairs[pair].has_touched {
                self.limit_analytical_impacts(pair, dt);
            }
        }
    }

    /// Returns the thickness that limits the increment of a pair.
    fn thickness_of(&self, pair: &ContactPair) -> f64 {
        let is_soft = self.laws[pair.law_of(0) as usize].is_soft();
        if is_soft { SOFT * pair.thickness } else { pair.thickness }
    }

    /// Returns the gap of a row and its closing speed.
    fn approach_of(&self, row: &ContactRow) -> [f64; 2] {
        [row.gap / row.area, -self.dofs.motion.rate(self.measured.rows.terms_of(row)) / row.area]
    }

    /// Limits the next increments by the points that are about to touch an analytical surface: they have no rows before.
    fn limit_analytical_impacts(&mut self, index: usize, dt: f64) {
        let thickness = self.thickness_of(&self.pairs[index]);
        let ContactConstraint { surfaces, pairs, dofs, impact, .. } = self;
        let (pair, places) = (&pairs[index], &surfaces.places);
        let secondary = &surfaces.curves[pair.secondary];
        let Some(analytical) = pair.analytical.map(|surface| &surfaces.analyticals[surface]) else { return };
        let velocity_of = |point: u32, axis: usize| match dofs.of_points[point as usize][axis] {
            NONE => 0.0,
            dof => dofs.motion.velocity[dof as usize],
        };
        let (lift, carried) = (places[analytical.point as usize][1], velocity_of(analytical.point, 1));
        for &index in &secondary.exposed_points {
            let point = secondary.points[index as usize];
            let nearest = analytical.profile.nearest(places[point as usize], lift);
            if nearest.beyond {
                continue;
            }
            let normal = analytical.profile.segments[nearest.segment].normal(places[point as usize], lift);
            let speed = -(normal[0] * velocity_of(point, 0) + normal[1] * (velocity_of(point, 1) - carried));
            let approach = [nearest.gap - analytical.lift[index as usize], speed];
            impact.add_if_near(approach, thickness, dt);
        }
    }
}

/// Returns whether surfaces of a pair press or hold each other. From then on new points of a surface that erodes or slides
/// are no impact.
fn touches(pair: &ContactPair, pressures: &[[f64; 2]]) -> bool {
    pressures[pair.keys()].iter().any(|pressure| pressure[0] != 0.0)
}
