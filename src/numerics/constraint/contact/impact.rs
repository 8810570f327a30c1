//! Limit of the time increment by the closing speed of surfaces that are about to touch.
//!
//! Contact stops a face within one increment. The elements next to it follow in the next increment, and are until then
//! compressed by the closing speed times the increment. If this is a large part of their thickness, as at closing speeds of
//! the order of the wave speed, the pressure of a shock overshoots or the element collapses. Before surfaces touch, and until
//! the shock has left the elements at the surface, the increment is at most a part of thickness over closing speed.

use super::pairs::{ContactPair, pair_of};
use super::sweeps::{ContactRow, NONE};
use super::system::ContactSystem;
use crate::state::archive::Persist;
use crate::state::dofs::{Dof, Dofs};

/// Largest compression of an element in an increment by the closing speed, as a fraction of its thickness.
const LARGEST_COMPRESSION: f64 = 0.1;
/// Number of increments before contact in which the limit acts: an increment may be longer than the one before.
const AHEAD: f64 = 3.0;
/// Part of the thickness that counts for soft contact: its springs return the closing speed, so that a light face moves away
/// from a heavy one at up to twice this speed.
const SOFT: f64 = 0.5;
/// Time for which the limit acts after contact begins, in units of thickness over closing speed.
const AFTER: f64 = 4.0;

/// Limit of the time increment by impacts.
#[derive(Clone, Copy, Debug, Persist)]
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

    /// Adds surfaces that approach each other at a speed, with the smallest thickness of their elements, if they are about to
    /// touch; see [`ImpactLimit::limit_impacts`].
    fn add_if_near(&mut self, [gap, speed]: [f64; 2], thickness: f64, dt: f64) {
        let near = if dt > 0.0 { AHEAD * speed * dt } else { thickness };
        if speed > 0.0 && gap <= near && thickness < f64::INFINITY {
            self.increment = self.increment.min(LARGEST_COMPRESSION * thickness / speed);
            self.remaining = self.remaining.max((gap.max(0.0) + AFTER * thickness) / speed);
        }
    }

    /// Limits the increments until surfaces touch that approach each other at the start of their contact.
    pub(super) fn limit_first_impacts(&mut self, contact: &mut ContactSystem, dofs: &Dofs) {
        let is_limited = contact.pairs.iter().any(|pair| pair.thickness < f64::INFINITY);
        if contact.dofs.half != 0.0 || contact.surfaces.uncovered || !is_limited {
            return;
        }
        contact.read_motion(dofs, 0.0);
        for (&(dof, _), velocity) in contact.dofs.list.iter().zip(&mut contact.dofs.motion.velocity) {
            if let Dof::Body(body) = dof {
                *velocity = dofs.bodies[body].velocity;
            }
        }
        contact.search();
        contact.measure_curves();
        self.limit_impacts(contact, 0.0);
        contact.measured.rows.clear();
        contact.measured.facets.clear();
        // The first increment searches again.
        contact.surfaces.listed.clear();
    }

    /// Limits the next increments by the surfaces that are about to touch after an increment of length `dt`; with 0, by all
    /// surfaces closer than the thickness of their elements. Equation (10.18).
    pub(super) fn limit_impacts(&mut self, contact: &mut ContactSystem, dt: f64) {
        if contact.surfaces.near.dofs.is_empty() {
            return;
        }
        let active = contact.surfaces.active.list.iter().map(|index| &contact.pairs[*index as usize]);
        let of_inactive = SOFT * contact.surfaces.active.thinnest_inactive;
        let open = active.filter(|pair| !pair.has_touched);
        let thinnest = open.fold(of_inactive, |thinnest, pair| thinnest.min(SOFT * pair.thickness));
        if thinnest == f64::INFINITY {
            return;
        }
        // Both surfaces may have components along r and z.
        let slow = if dt > 0.0 { LARGEST_COMPRESSION * thinnest / (4.0 * AHEAD * dt) } else { 0.0 };
        if !contact.surfaces.near.dofs.iter().any(|&dof| contact.dofs.motion.velocity[dof as usize].abs() > slow) {
            return;
        }
        for &index in &contact.surfaces.active.list {
            let pair = &mut contact.pairs[index as usize];
            pair.has_touched |= touches(pair, &contact.keys.pressures);
        }
        for row in contact.measured.rows.rows.iter().filter(|row| !row.is_single_point && row.closest_point.is_none()) {
            let pair = &contact.pairs[pair_of(&contact.pairs, row.key)];
            if !pair.has_touched {
                self.add_if_near(approach_of(contact, row), thickness_of(contact, pair), dt);
            }
        }
        for &index in &contact.surfaces.active.analytical {
            let pair = &contact.pairs[index as usize];
            if !pair.has_touched {
                self.limit_analytical_impacts(contact, pair, dt);
            }
        }
    }

    /// Limits the next increments by the points that are about to touch an analytical surface: they have no rows before.
    fn limit_analytical_impacts(&mut self, contact: &ContactSystem, pair: &ContactPair, dt: f64) {
        let ContactSystem { surfaces, dofs, .. } = contact;
        let (thickness, places) = (thickness_of(contact, pair), &surfaces.places);
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
            self.add_if_near(approach, thickness, dt);
        }
    }
}

/// Returns the thickness that limits the increment of a pair.
fn thickness_of(contact: &ContactSystem, pair: &ContactPair) -> f64 {
    let is_soft = contact.laws[pair.law_of(0) as usize].is_soft();
    if is_soft { SOFT * pair.thickness } else { pair.thickness }
}

/// Returns the gap of a row and its closing speed.
fn approach_of(contact: &ContactSystem, row: &ContactRow) -> [f64; 2] {
    let ContactSystem { dofs, measured, .. } = contact;
    [row.gap / row.area, -dofs.motion.rate(measured.rows.terms_of(row)) / row.area]
}

/// Returns whether surfaces of a pair press or hold each other. From then on new points of a surface that erodes or slides
/// are no impact.
fn touches(pair: &ContactPair, pressures: &[[f64; 2]]) -> bool {
    pressures[pair.keys()].iter().any(|pressure| pressure[0] != 0.0)
}
