//! Limit of the time increment by the closing speed of surfaces that are about to touch.
//!
//! Contact stops a face within one increment. The elements behind it learn of this in the next one, and are until then
//! compressed by the closing speed times the increment. If this is a large part of their thickness, as at closing speeds of
//! the order of the wave speed, the pressure of a shock overshoots or the element collapses. Before surfaces touch, and until
//! the shock has left the elements at the surface, the increment is at most a part of thickness over closing speed.

use super::sweeps::{ContactRow, NONE};
use super::{ContactConstraint, ContactPair, pair_of};
use crate::state::archive::persist_struct;
use crate::state::dofs::{Dof, Dofs};

/// Largest compression of an element in an increment by the closing speed, as a fraction of its thickness.
const LARGEST_COMPRESSION: f64 = 0.2;
/// Number of increments before contact in which the limit acts: an increment may be longer than the one before.
const AHEAD: f64 = 3.0;
/// Part of the thickness that counts for soft contact: its springs return the closing speed, so that a light face moves away
/// from a heavy one at up to twice this speed.
const SOFT: f64 = 0.5;
/// Time for which the limit acts after contact begins, in units of thickness over closing speed.
const AFTER: f64 = 4.0;

/// Limit of the time increment by impacts.
#[derive(Clone, Copy, Debug)]
pub(super) struct ImpactLimit {
    /// Largest increment.
    pub(super) increment: f64,
    /// Time until the limit ends.
    remaining: f64,
}

impl Default for ImpactLimit {
    fn default() -> Self {
        ImpactLimit { increment: f64::INFINITY, remaining: 0.0 }
    }
}

impl ImpactLimit {
    /// Ends the limit if its time has passed.
    pub(super) fn advance(&mut self, dt: f64) {
        self.remaining -= dt;
        if self.remaining <= 0.0 {
            *self = ImpactLimit::default();
        }
    }

    /// Adds surfaces that approach each other at a speed, with the smallest thickness of their elements.
    fn add(&mut self, [gap, speed]: [f64; 2], thickness: f64) {
        self.increment = self.increment.min(LARGEST_COMPRESSION * thickness / speed);
        self.remaining = self.remaining.max((gap.max(0.0) + AFTER * thickness) / speed);
    }
}

persist_struct!(ImpactLimit { increment, remaining });

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
        let thinnest = self.pairs.iter().fold(f64::INFINITY, |thinnest, pair| thinnest.min(SOFT * pair.thickness));
        let speed = |dof: &u32| self.motion.velocity[*dof as usize].abs();
        let fastest = self.near.dofs.iter().map(speed).fold(0.0, f64::max);
        // Both surfaces may have components along r and z.
        if fastest == 0.0 || 4.0 * AHEAD * dt * fastest <= LARGEST_COMPRESSION * thinnest && dt > 0.0 {
            return;
        }
        // The last pair, and whether it is in contact.
        let mut pressed = (usize::MAX, false);
        for row in self.rows.rows.iter().filter(|row| !row.is_single_point && row.closest_point.is_none()) {
            let at = pair_of(&self.pairs, row.key);
            if pressed.0 != at {
                pressed = (at, self.is_pressed(at));
            }
            if pressed.1 {
                continue;
            }
            let pair = &self.pairs[at];
            let (approach, thickness) = (self.approach_of(row), self.thickness_of(pair));
            self.impact.add_if_near(approach, thickness, (dt, self.pressures[row.key as usize][0]));
        }
        for at in 0..self.pairs.len() {
            if !self.is_pressed(at) {
                self.limit_analytical_impacts(at, dt);
            }
        }
    }

    /// Returns whether a pair is in contact: new points of a surface that erodes or slides are not an impact.
    fn is_pressed(&self, at: usize) -> bool {
        let pair = &self.pairs[at];
        let first = pair.first_key as usize;
        self.pressures[first..first + self.keys_of(pair) as usize].iter().any(|pressure| pressure[0] > 0.0)
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
        let ContactConstraint { pairs, analyticals, curves, dofs_of, motion, places, pressures, impact, .. } = self;
        let (pair, own) = (&pairs[at], &curves[pairs[at].own]);
        let Some(analytical) = pair.analytical.map(|index| &analyticals[index]) else { return };
        let velocity_of = |point: u32, axis: usize| match dofs_of[point as usize][axis] {
            NONE => 0.0,
            dof => motion.velocity[dof as usize],
        };
        let (lift, carried) = (places[analytical.point as usize][1], velocity_of(analytical.point, 1));
        for &index in &own.exposed_points {
            let (point, key) = (own.own[index as usize], pair.first_key + index);
            let nearest = analytical.profile.nearest(places[point as usize], lift);
            if nearest.beyond {
                continue;
            }
            let normal = analytical.profile.segments[nearest.segment].normal(places[point as usize], lift);
            let speed = -(normal[0] * velocity_of(point, 0) + normal[1] * (velocity_of(point, 1) - carried));
            let approach = [nearest.gap - analytical.lift[index as usize], speed];
            impact.add_if_near(approach, thickness, (dt, pressures[key as usize][0]));
        }
    }
}

impl ImpactLimit {
    /// Adds surfaces that are about to touch and have not been in contact; see [`ContactConstraint::limit_impacts`].
    fn add_if_near(&mut self, [gap, speed]: [f64; 2], thickness: f64, (dt, pressure): (f64, f64)) {
        let near = if dt > 0.0 { AHEAD * speed * dt } else { thickness };
        if pressure == 0.0 && speed > 0.0 && gap <= near && thickness < f64::INFINITY {
            self.add([gap, speed], thickness);
        }
    }
}
