//! Damping of frictional flutter.
//!
//! Sliding with Coulomb friction is unstable at short wavelengths: pressure waves change the friction that drives them
//! (Martins, Guimarães and Faria 1995, J. Vib. Acoust. 117, 445). On a mesh the oscillation grows at the scale of the
//! elements until the surfaces separate, and the mean friction force falls. A dashpot along the surface therefore acts
//! on the quick part of the slip rate. Its stress is at most the friction limit, and it vanishes in steady sliding and
//! in sticking, so that the friction force keeps its mean.

use super::sweeps::{ContactRow, ContactRows, ContactStep, ContactVelocities};
use crate::kernel::interaction::InteractionLaw;
use crate::kernel::lists::MemoryUse;
use crate::state::archive::persist_struct;

/// Share by which the slow part of the slip rate approaches the rate in an increment.
const APPROACH: f64 = 0.1;

/// Slip rates of the keys in contact.
#[derive(Clone, Debug, Default)]
pub(super) struct SlipDamping {
    /// Slow part of the slip rate; NaN if not in contact. Empty without damping.
    slow: Vec<f64>,
    /// Impulse per area that acts in the next increment.
    impulse: Vec<f64>,
    /// Work array: the slow parts at the end of the increment.
    next: Vec<f64>,
}

impl SlipDamping {
    /// Damping of this number of keys.
    pub(super) fn new(keys: usize) -> SlipDamping {
        SlipDamping { slow: vec![f64::NAN; keys], impulse: vec![0.0; keys], next: vec![f64::NAN; keys] }
    }

    /// Takes the slip rate of a key from the previous contact.
    pub(super) fn take_over(&mut self, key: usize, previous: &SlipDamping, other: usize) {
        if let (Some(own), Some(before)) = (self.slow.get_mut(key), previous.slow.get(other)) {
            (*own, self.impulse[key]) = (*before, previous.impulse[other]);
        }
    }

    pub(super) fn memory(&self) -> MemoryUse {
        MemoryUse::of(&self.slow) + MemoryUse::of(&self.impulse) + MemoryUse::of(&self.next)
    }

    /// Applies the impulses of the damping to the velocities, before the contact impulses are solved for.
    pub(super) fn apply(&self, rows: &mut ContactRows, motion: &mut ContactVelocities, given: ContactStep<'_>) {
        let ContactRows { rows, terms, .. } = rows;
        for row in rows.iter_mut() {
            let Some(&impulse) = self.impulse.get(row.key as usize).filter(|impulse| **impulse != 0.0) else {
                continue;
            };
            let [pressure, _] = given.before[row.key as usize];
            let friction = &given.laws[row.law as usize].friction;
            let most = (friction.at_rest * pressure).min(friction.largest) * given.span.half;
            row.damping = impulse.clamp(-most, most);
            motion.shear(row.own(terms), row.damping);
        }
    }

    /// Updates the slip rates after the solution, and computes the impulses of the next increment.
    pub(super) fn update(&mut self, rows: &ContactRows, motion: &ContactVelocities, laws: &[InteractionLaw]) {
        if self.slow.is_empty() {
            return;
        }
        self.next.fill(f64::NAN);
        self.impulse.fill(0.0);
        let slides = |row: &&ContactRow| {
            let friction = &laws[row.law as usize].friction;
            row.normal_impulse > 0.0 && row.compliance[1] > 0.0 && friction.at_rest.is_finite()
        };
        for row in rows.rows.iter().filter(slides) {
            let (key, slip) = (row.key as usize, motion.slip(rows.terms_of(row)) / row.area);
            let before = if self.slow[key].is_nan() { slip } else { self.slow[key] };
            let slow = before + APPROACH * (slip - before);
            self.next[key] = slow;
            if !row.sticks {
                let damping = laws[row.law as usize].friction.damping;
                self.impulse[key] = -damping * (slip - slow) * row.area / row.compliance[1];
            }
        }
        std::mem::swap(&mut self.slow, &mut self.next);
    }
}

persist_struct!(SlipDamping { slow: fixed, impulse: fixed } derived { next });
