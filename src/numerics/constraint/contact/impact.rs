//! Surfaces that are about to touch: the limit of the time increment by their closing speed; see `impact_limit.rs`.

use super::impact_limit::{AHEAD, LARGEST_COMPRESSION, SOFT};
use super::sweeps::{ContactRow, NONE};
use super::{ContactConstraint, ContactPair, pair_of};
use crate::state::dofs::{Dof, Dofs};

impl ContactConstraint {
    /// Limits the increments until surfaces touch that approach each other at the start of their contact.
    pub(super) fn limit_first_impacts(&mut self, dofs: &Dofs) {
        let is_limited = self.pairs.iter().any(|pair| pair.thickness < f64::INFINITY);
        if self.half != 0.0 || self.uncovered || !is_limited {
            return;
        }
        self.read_motion(dofs, 0.0);
        for (&(dof, _), velocity) in self.dofs.iter().zip(&mut self.motion.velocity) {
            if let Dof::Body(body) = dof {
                *velocity = dofs.bodies[body].velocity;
            }
        }
        self.search();
        self.measure_curves();
        self.limit_impacts(0.0);
        self.rows.clear();
        self.gaps.clear();
        // The first increment searches again.
        self.listed.clear();
    }

    /// Limits the next increments by the surfaces that are about to touch after an increment of length `dt`; with 0, by all
    /// surfaces closer than the thickness of their elements.
    pub(super) fn limit_impacts(&mut self, dt: f64) {
        let open = (0..self.pairs.len()).filter(|&at| !self.touched[at]);
        let thinnest = open.fold(f64::INFINITY, |thinnest, at| thinnest.min(SOFT * self.pairs[at].thickness));
        if thinnest == f64::INFINITY {
            return;
        }
        // Both surfaces may have components along r and z.
        let slow = if dt > 0.0 { LARGEST_COMPRESSION * thinnest / (4.0 * AHEAD * dt) } else { 0.0 };
        if !self.near.dofs.iter().any(|&dof| self.motion.velocity[dof as usize].abs() > slow) {
            return;
        }
        for at in 0..self.pairs.len() {
            self.touched[at] |= self.touches(at);
        }
        for row in self.rows.rows.iter().filter(|row| !row.is_single_point && row.closest_point.is_none()) {
            let at = pair_of(&self.pairs, row.key);
            if !self.touched[at] {
                self.impact.add_if_near(self.approach_of(row), self.thickness_of(&self.pairs[at]), dt);
            }
        }
        for at in 0..self.pairs.len() {
            if !self.touched[at] {
                self.limit_analytical_impacts(at, dt);
            }
        }
    }

    /// Returns whether surfaces of a pair press or hold each other. From then on new points of a surface that erodes or
    /// slides are no impact.
    fn touches(&self, at: usize) -> bool {
        let pair = &self.pairs[at];
        let first = pair.first_key as usize;
        self.pressures[first..first + self.keys_of(pair) as usize].iter().any(|pressure| pressure[0] != 0.0)
    }

    /// Returns the thickness that limits the increment of a pair.
    fn thickness_of(&self, pair: &ContactPair) -> f64 {
        let is_soft = self.laws[pair.law_of(0) as usize].is_soft();
        if is_soft { SOFT * pair.thickness } else { pair.thickness }
    }

    /// Returns the gap of a row and its closing speed.
    fn approach_of(&self, row: &ContactRow) -> [f64; 2] {
        [row.gap / row.area, -self.motion.rate(self.rows.terms_of(row)) / row.area]
    }

    /// Limits the next increments by the points that are about to touch an analytical surface: they have no rows before.
    fn limit_analytical_impacts(&mut self, at: usize, dt: f64) {
        let thickness = self.thickness_of(&self.pairs[at]);
        let ContactConstraint { pairs, analyticals, curves, dofs_of, motion, places, impact, .. } = self;
        let (pair, own) = (&pairs[at], &curves[pairs[at].own]);
        let Some(analytical) = pair.analytical.map(|index| &analyticals[index]) else { return };
        let velocity_of = |point: u32, axis: usize| match dofs_of[point as usize][axis] {
            NONE => 0.0,
            dof => motion.velocity[dof as usize],
        };
        let (lift, carried) = (places[analytical.point as usize][1], velocity_of(analytical.point, 1));
        for &index in &own.exposed_points {
            let point = own.own[index as usize];
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
