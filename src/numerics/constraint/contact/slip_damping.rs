//! Damping of frictional flutter.
//!
//! Sliding with Coulomb friction is unstable at short wavelengths: pressure waves change the friction that drives them
//! (Martins, Guimarães and Faria 1995, J. Vib. Acoust. 117, 445). On a mesh the oscillation grows at the scale of the
//! elements until the surfaces separate, and the mean friction force falls. A dashpot along the surface therefore acts
//! on the quick part of the slip rate, relative to its mean over the surface. Its stress is at most the friction limit,
//! and it vanishes in steady sliding, in sticking and for a body that slides as a whole. The friction limit follows the
//! pressure with a delay of some increments (as measured by Prakash and Clifton; a regularization after Cochard and Rice
//! 2000, J. Geophys. Res. 105, 25891), so that friction does not drive waves of the length of an element.

use super::active_pairs::ActivePairs;
use super::mesh_continuation::{KeyPlace, MeshContinuation};
use super::sweeps::{ContactRow, ContactRows, ContactStep, ContactVelocities};
use super::written::WrittenEntries;
use crate::kernel::interaction::InteractionLaw;
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::Memory;
use crate::state::archive::Persist;

/// Share by which the slow part of the slip rate approaches the rate in an increment.
const APPROACH: f64 = 0.1;
/// Share by which the slow parts of the pressure approach it in an increment.
const PRESSURE_APPROACH: f64 = 0.1;

/// Slip rates of the keys in contact.
#[derive(Clone, Debug, Default, Persist, Memory)]
#[persist(fixed: slow, impulse, stress, pressure; derived: written, next, next_pressure)]
pub(super) struct SlipDamping {
    /// Slow part of the slip rate; NaN if not in contact. Empty without damping.
    slow: Vec<f64>,
    /// Impulse per area that acts in the next increment, before its limit.
    impulse: Vec<f64>,
    /// Shear stress of the damping in the last increment.
    stress: Vec<f64>,
    /// Slow part of the pressure, and slow part of that; NaN if not in contact. Twice the first less the second limits
    /// friction: it follows a steady rise without a delay.
    pressure: Vec<[f64; 2]>,
    /// Work array: the slow parts of the pressures at the end of the increment.
    next_pressure: Vec<[f64; 2]>,
    /// Work array: the slow parts at the end of the increment.
    next: Vec<f64>,
    written: WrittenKeys,
}

/// Keys with values in each array of the damping.
#[derive(Clone, Debug, Default, Memory)]
struct WrittenKeys {
    slow: WrittenEntries,
    next: WrittenEntries,
    impulse: WrittenEntries,
    stress: WrittenEntries,
    pressure: WrittenEntries,
    next_pressure: WrittenEntries,
}

impl WrittenKeys {
    fn all(&mut self) -> [&mut WrittenEntries; 6] {
        let WrittenKeys { slow, next, impulse, stress, pressure, next_pressure } = self;
        [slow, next, impulse, stress, pressure, next_pressure]
    }
}

impl SlipDamping {
    /// Damping of this number of keys.
    pub(super) fn new(keys: usize) -> SlipDamping {
        SlipDamping {
            slow: vec![f64::NAN; keys],
            impulse: vec![0.0; keys],
            stress: vec![0.0; keys],
            pressure: vec![[f64::NAN; 2]; keys],
            next_pressure: vec![[f64::NAN; 2]; keys],
            next: vec![f64::NAN; keys],
            written: WrittenKeys::default(),
        }
    }

    /// Allocates the lists of written keys for a number of rows.
    pub(super) fn reserve(&mut self, rows: usize) {
        if !self.slow.is_empty() {
            self.written.all().into_iter().for_each(|list| list.reserve(rows));
        }
    }

    /// Notes that any key may have values.
    pub(super) fn forget_written(&mut self) {
        self.written.all().into_iter().for_each(WrittenEntries::forget);
    }

    /// Takes the slip rate of a key from the previous contact.
    pub(super) fn take_over(&mut self, key: usize, previous: &SlipDamping, place: KeyPlace) {
        if self.slow.is_empty() || previous.slow.is_empty() {
            return;
        }
        self.forget_written();
        self.slow[key] = place.value(|other| previous.slow[other]);
        self.impulse[key] = place.value(|other| previous.impulse[other]);
        self.stress[key] = place.value(|other| previous.stress[other]);
        self.pressure[key] = [0, 1].inline_map(|part: usize| place.value(|other| previous.pressure[other][part]));
    }

    /// Moves the values to the new places of the keys on adaptive meshes.
    pub(super) fn carry(&mut self, mesh: &mut MeshContinuation) {
        self.forget_written();
        for values in [&mut self.slow, &mut self.impulse, &mut self.stress] {
            mesh.carry(values, |value| value);
        }
        for part in 0..2 {
            mesh.carry(&mut self.pressure, |slow| &mut slow[part]);
        }
    }

    /// Returns the shear stress of a key in the last increment.
    pub(super) fn stress(&self, key: usize) -> f64 {
        self.stress.get(key).copied().unwrap_or(0.0)
    }

    /// Begins an increment without damping.
    pub(super) fn begin(&mut self, active: &ActivePairs) {
        self.written.stress.reset_keys(&mut self.stress, 0.0, active);
    }

    /// Applies the impulses of the damping to the velocities, before the contact impulses are solved for. Their limit is
    /// that of friction under the pressure of the previous increment.
    pub(super) fn apply(&mut self, rows: &mut ContactRows, motion: &mut ContactVelocities, step: ContactStep<'_>) {
        let ContactRows { rows, terms, .. } = rows;
        for row in rows.iter_mut().filter(|row| !row.is_single_point) {
            if let Some([slow, slower]) = self.pressure.get(row.key as usize).filter(|slow| !slow[0].is_nan()) {
                let constant = (1.0 - PRESSURE_APPROACH) * ((2.0 - PRESSURE_APPROACH) * slow - slower);
                row.slow_impulse = Some([constant * step.span.half, (2.0 - PRESSURE_APPROACH) * PRESSURE_APPROACH]);
            }
            let Some(&impulse) = self.impulse.get(row.key as usize).filter(|impulse| **impulse != 0.0) else {
                continue;
            };
            let [pressure, _] = step.pressures[row.key as usize];
            let friction = &step.laws[row.law as usize].friction;
            // Not a number, after an instability, counts as no pressure.
            let pressure = if pressure > 0.0 { pressure } else { 0.0 };
            let limit = (friction.at_rest * pressure).min(friction.largest) * step.span.half;
            row.damping = impulse.clamp(-limit, limit);
            self.stress[row.key as usize] = row.damping / step.span.half;
            self.written.stress.add(row.key);
            motion.shear(row.terms_in(terms), row.damping);
        }
    }

    /// Updates the slow parts of the pressures; `half` is the time over which the impulses act. Equation (10.5b).
    fn update_pressures(&mut self, rows: &ContactRows, laws: &[InteractionLaw], half: f64, active: &ActivePairs) {
        self.written.next_pressure.reset_keys(&mut self.next_pressure, [f64::NAN; 2], active);
        let is_damped = |row: &&ContactRow| !row.is_single_point && laws[row.law as usize].friction.damps();
        for row in rows.rows.iter().filter(is_damped).filter(|row| row.normal_impulse > 0.0) {
            let ([slow, slower], pressure) = (self.pressure[row.key as usize], row.normal_impulse / half);
            self.written.next_pressure.add(row.key);
            let approached = slow + PRESSURE_APPROACH * (pressure - slow);
            self.next_pressure[row.key as usize] = match slow.is_nan() {
                true => [pressure; 2],
                false => [approached, slower + PRESSURE_APPROACH * (approached - slower)],
            };
        }
        std::mem::swap(&mut self.pressure, &mut self.next_pressure);
        std::mem::swap(&mut self.written.pressure, &mut self.written.next_pressure);
    }

    /// Updates the slip rates and pressures after the solution, and computes the impulses of the next increment. The rows
    /// of a pair (`pair_of` a key) have no resultant: a body that slides as a whole decelerates by friction alone.
    /// Equation (10.5a).
    pub(super) fn update(
        &mut self,
        rows: &ContactRows,
        motion: &ContactVelocities,
        (laws, half): (&[InteractionLaw], f64),
        pair_of: impl Fn(u32) -> usize,
        active: &ActivePairs,
    ) {
        if self.slow.is_empty() {
            return;
        }
        self.update_pressures(rows, laws, half, active);
        self.written.next.reset_keys(&mut self.next, f64::NAN, active);
        self.written.impulse.reset_keys(&mut self.impulse, 0.0, active);
        // Single points have no facets on which a wave could travel.
        let is_damped = |row: &&ContactRow| {
            !row.is_single_point
                && row.normal_impulse > 0.0
                && row.compliance[1] > 0.0
                && laws[row.law as usize].friction.damps()
        };
        for row in rows.rows.iter().filter(is_damped) {
            let (key, slip) = (row.key as usize, motion.slip(rows.terms_of(row)) / row.area);
            let previous = if self.slow[key].is_nan() { slip } else { self.slow[key] };
            self.next[key] = previous + APPROACH * (slip - previous);
            // For now the quick part of the slip rate; sticking rows have none.
            self.impulse[key] = if row.sticks { 0.0 } else { slip - self.next[key] };
            self.written.next.add(row.key);
            self.written.impulse.add(row.key);
        }
        std::mem::swap(&mut self.slow, &mut self.next);
        std::mem::swap(&mut self.written.slow, &mut self.written.next);
        for pair in rows.rows.chunk_by(|a, b| pair_of(a.key) == pair_of(b.key)) {
            let slides = |row: &&ContactRow| is_damped(row) && !row.sticks;
            let (mut mass, mut moment) = (0.0, 0.0);
            for row in pair.iter().filter(slides) {
                let row_mass = row.area * row.area / row.compliance[1];
                mass += row_mass;
                moment += row_mass * self.impulse[row.key as usize];
            }
            for row in pair.iter().filter(slides) {
                let impulse = &mut self.impulse[row.key as usize];
                *impulse = -laws[row.law as usize].friction.damping * (*impulse - moment / mass) * row.area
                    / row.compliance[1];
            }
        }
    }
}
