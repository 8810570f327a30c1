//! Energy that soft contact has stored.
//!
//! The pressure of a soft law belongs to the overlap up to which work has been done: with the energy `E` that the
//! impulses of a row have absorbed, its area `A`, and the energy `W(o)` per area of the law, the overlap is limited to
//! `A W(o) <= E`. Contact therefore releases at most what it has stored, for any change of area or geometry.

use std::ops::Range;

use super::active_pairs::ActivePairs;
use super::mesh_continuation::KeyPlace;
use super::sweeps::{ContactInterval, ContactRow, ContactRows, ContactVelocities, closed_overlap};
use super::written::WrittenEntries;
use crate::kernel::interaction::{InteractionLaw, PressureOverclosure};
use crate::kernel::lists::Memory;
use crate::state::archive::Persist;

/// Energy that soft contact has stored, by the key of the contact row.
#[derive(Clone, Debug, Default, Persist, Memory)]
#[persist(fixed: stored; derived: next, written, written_next)]
pub(super) struct StoredEnergy {
    /// Energy that a soft law has absorbed and not released; NaN before the first increment. Empty without soft laws.
    pub(super) stored: Vec<f64>,
    /// Work array: stored energy at the end of the increment.
    next: Vec<f64>,
    /// Keys with energies in both arrays.
    written: WrittenEntries,
    written_next: WrittenEntries,
}

impl StoredEnergy {
    /// Creates the store for a number of keys; the energies are determined in the first increment.
    pub(super) fn new(keys: usize) -> StoredEnergy {
        StoredEnergy { stored: vec![f64::NAN; keys], next: vec![0.0; keys], ..StoredEnergy::default() }
    }

    /// Allocates the lists of written keys for a number of rows.
    pub(super) fn reserve(&mut self, rows: usize) {
        if !self.stored.is_empty() {
            [&mut self.written, &mut self.written_next].into_iter().for_each(|list| list.reserve(rows));
        }
    }

    /// Notes that any key may have an energy.
    pub(super) fn forget_written(&mut self) {
        self.written.forget();
        self.written_next.forget();
    }

    /// Returns the energies, of which any may be changed.
    pub(super) fn stored_mut(&mut self) -> &mut [f64] {
        self.written.forget();
        &mut self.stored
    }

    /// Begins keys in a run: they have stored no energy.
    pub(super) fn begin_keys(&mut self, keys: Range<usize>) {
        if let Some(stored) = self.stored.get_mut(keys) {
            stored.fill(0.0);
            self.written.forget();
        }
    }

    /// Takes the energy of a key from the previous contact.
    pub(super) fn take_over(&mut self, key: usize, previous: &StoredEnergy, place: KeyPlace) {
        if let Some(own) = self.stored.get_mut(key).filter(|_| !previous.stored.is_empty()) {
            *own = place.value(|other| previous.stored[other]);
            self.written.forget();
        }
    }

    /// Limits the overlaps of soft rows to those that work has been done for. Returns the energy of the overlaps with
    /// which soft contact begins.
    pub(super) fn limit_overlaps(
        &mut self,
        rows: &mut ContactRows,
        laws: &[InteractionLaw],
        active: &ActivePairs,
    ) -> f64 {
        if self.stored.is_empty() {
            return 0.0;
        }
        self.written_next.reset_keys(&mut self.next, 0.0, active);
        let mut initial = 0.0;
        for row in &mut rows.rows {
            let law = &laws[row.law as usize].overclosure;
            if *law != PressureOverclosure::Hard {
                let overlap = -row.gap / row.area;
                let paid = self.paid(row.key as usize, law, [row.area, overlap], &mut initial);
                if paid < overlap {
                    row.gap = -paid * row.area;
                }
            }
        }
        initial
    }

    /// Adds the work that the impulses of soft rows have absorbed over the displacement of the increment.
    pub(super) fn add_work(
        &mut self,
        rows: &ContactRows,
        laws: &[InteractionLaw],
        motion: &ContactVelocities,
        span: ContactInterval,
    ) {
        if self.stored.is_empty() {
            return;
        }
        for row in rows.rows.iter().filter(|row| laws[row.law as usize].is_soft()) {
            let rate = motion.rate(rows.terms_of(row));
            let work =
                -elastic_impulse(row, &laws[row.law as usize].overclosure, rate, span) * (span.dt / span.half) * rate;
            let stored = &mut self.next[row.key as usize];
            *stored = (*stored + work).max(0.0);
        }
        std::mem::swap(&mut self.stored, &mut self.next);
        std::mem::swap(&mut self.written, &mut self.written_next);
    }

    /// Returns the overlap of a soft row that work has been done for. The overlap at the start is given, and its energy
    /// is added to `initial`. Equation (10.13).
    fn paid(&mut self, key: usize, law: &PressureOverclosure, [area, overlap]: [f64; 2], initial: &mut f64) -> f64 {
        let closed = overlap > -law.onset_gap();
        let needed = if closed { area * law.energy(overlap) } else { 0.0 };
        let begins = self.stored[key].is_nan();
        *initial += if begins { needed } else { 0.0 };
        let stored = if begins { needed } else { self.stored[key] };
        self.next[key] = if closed { stored } else { 0.0 };
        self.written_next.add(key as u32);
        if needed <= stored { overlap } else { law.overlap_of_energy(stored / area, overlap) }
    }
}

/// Returns the part of the normal impulse of a row that its soft law causes, without damping.
fn elastic_impulse(row: &ContactRow, law: &PressureOverclosure, rate: f64, span: ContactInterval) -> f64 {
    if row.dashpot == 0.0 {
        return row.normal_impulse;
    }
    let [pressure, _] = law.pressure(closed_overlap(row, law, rate, span));
    if row.normal_impulse > 0.0 { span.half * pressure } else { 0.0 }
}
