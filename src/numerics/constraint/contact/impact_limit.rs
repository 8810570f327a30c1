//! Limit of the time increment by the closing speed of surfaces that are about to touch.
//!
//! Contact stops a face within one increment. The elements next to it follow in the next increment, and are until then
//! compressed by the closing speed times the increment. If this is a large part of their thickness, as at closing speeds of
//! the order of the wave speed, the pressure of a shock overshoots or the element collapses. Before surfaces touch, and until
//! the shock has left the elements at the surface, the increment is at most a part of thickness over closing speed.

use crate::state::archive::Persist;

/// Largest compression of an element in an increment by the closing speed, as a fraction of its thickness.
pub(super) const LARGEST_COMPRESSION: f64 = 0.1;
/// Number of increments before contact in which the limit acts: an increment may be longer than the one before.
pub(super) const AHEAD: f64 = 3.0;
/// Part of the thickness that counts for soft contact: its springs return the closing speed, so that a light face moves away
/// from a heavy one at up to twice this speed.
pub(super) const SOFT: f64 = 0.5;
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
    /// touch; see `ContactConstraint::limit_impacts`.
    pub(super) fn add_if_near(&mut self, [gap, speed]: [f64; 2], thickness: f64, dt: f64) {
        let near = if dt > 0.0 { AHEAD * speed * dt } else { thickness };
        if speed > 0.0 && gap <= near && thickness < f64::INFINITY {
            self.increment = self.increment.min(LARGEST_COMPRESSION * thickness / speed);
            self.remaining = self.remaining.max((gap.max(0.0) + AFTER * thickness) / speed);
        }
    }
}
