//! Points of a block in one increment: trial stresses, then the results of a law.
#![allow(clippy::needless_range_loop)] // Loops over lanes, with one array per quantity.

use super::lane_roots::Flags;
use super::law::{TrialStress, contraction, returned};
use crate::kernel::lanes::{InlineMap, LANES, Lanes, column, put_column};
use crate::kernel::moduli::ElasticModuli;
use crate::kernel::stress::mises;
use crate::material::increment::{StrainIncrement, StressUpdate};

/// Trial stresses of the points of a block, then the results of the law.
pub struct ReturnedPoints {
    /// Lanes with an active element, and active lanes that no law has updated yet.
    pub(super) live: Flags,
    pub(super) open: Flags,
    pub(super) pressure: Lanes,
    pub(super) deviator: [Lanes; 4],
    pub(super) mises: Lanes,
    pub(super) stress: [Lanes; 4],
    pub(super) plastic: [Lanes; 4],
    /// Energies per current volume: of compaction and of damage.
    pub(super) compacted: Lanes,
    pub(super) lost: Lanes,
    pub(super) bulk: Lanes,
    pub(super) shear: Lanes,
    /// 0 for a point that is deleted in this increment; 1 otherwise.
    pub(super) kept: Lanes,
}

impl ReturnedPoints {
    /// Creates points without results; filled in place, because copies of so many numbers take longer than many a law.
    #[inline(always)] // Likewise.
    pub(super) fn zero() -> ReturnedPoints {
        ReturnedPoints {
            live: [0; LANES],
            open: [0; LANES],
            pressure: [0.0; LANES],
            deviator: [[0.0; LANES]; 4],
            mises: [0.0; LANES],
            stress: [[0.0; LANES]; 4],
            plastic: [[0.0; LANES]; 4],
            compacted: [0.0; LANES],
            lost: [0.0; LANES],
            bulk: [0.0; LANES],
            shear: [0.0; LANES],
            kept: [1.0; LANES],
        }
    }

    /// Computes the trial stresses.
    #[inline(always)] // Likewise.
    pub(super) fn begin(&mut self, moduli: ElasticModuli, strain: &StrainIncrement, active: &Lanes) {
        for l in 0..LANES {
            self.live[l] = u64::from(active[l] > 0.0) & u64::from(l < strain.count);
            self.open[l] = self.live[l];
            (self.bulk[l], self.shear[l]) = (moduli.bulk, moduli.shear);
            let trial = TrialStress::elastic(column(&strain.carried, l), column(&strain.strain, l), moduli);
            put_column(&mut self.deviator, l, trial.deviator);
            (self.pressure[l], self.mises[l]) = (trial.pressure, trial.mises);
        }
    }

    /// Returns the trial stress of a lane.
    #[inline(always)] // Likewise.
    pub(super) fn trial(&self, l: usize) -> TrialStress {
        TrialStress { pressure: self.pressure[l], deviator: column(&self.deviator, l), mises: self.mises[l] }
    }

    /// Sets the stress of a lane like [`ReturnPoint::return_to_deviator`].
    #[inline(always)] // Likewise.
    pub(super) fn return_to_deviator(&mut self, l: usize, pressure: f64, deviator: [f64; 4], dilation: f64) {
        let (stress, plastic) =
            returned(column(&self.deviator, l), (pressure, deviator), dilation, 1.0 / (2.0 * self.shear[l]));
        let is_live = self.live[l] == 1;
        put_column(&mut self.stress, l, stress.inline_map(|part| if is_live { part } else { 0.0 }));
        put_column(&mut self.plastic, l, plastic.inline_map(|part| if is_live { part } else { 0.0 }));
    }

    /// Sets the stresses of a block to the trial; no lane remains open.
    #[inline(always)] // Likewise.
    pub(super) fn stay_elastic(&mut self) {
        for l in 0..LANES {
            let TrialStress { pressure, deviator, .. } = self.trial(l);
            self.return_to_deviator(l, pressure, deviator, 0.0);
            self.open[l] = 0;
        }
    }

    /// Stores stresses, moduli and energies of the block. Returns the number of deleted points. The recoverable energy of a
    /// stress is per current volume, so that the volume change of plastic flow takes a part of the plastic work; a law that
    /// `holds_pressure` has the energy of the pressure per initial volume.
    #[inline(always)] // Likewise.
    pub(super) fn finish(
        &self,
        stress: &mut [Lanes; 4],
        strain: &StrainIncrement,
        update: &mut StressUpdate,
        holds_pressure: bool,
    ) -> usize {
        let [per_bulk, per_shear] =
            [if holds_pressure { 0.0 } else { 0.5 / strain.moduli.bulk }, 0.5 / (3.0 * strain.moduli.shear)];
        for l in 0..LANES {
            let (new, plastic) = (column(&self.stress, l), column(&self.plastic, l));
            let carried = column(&strain.carried, l);
            let both = [0, 1, 2, 3].inline_map(|i: usize| 0.5 * (carried[i] + new[i]));
            let (volume, work) = (strain.volume[l], contraction(both, column(&strain.strain, l)));
            update.internal[l] += volume * work;
            // The force of a deleted element ends with its stress: its elastic energy and the work of the increment are lost.
            let is_kept = self.kept[l] > 0.0;
            let by_deletion = if is_kept { 0.0 } else { work };
            let lost = self.lost[l] + by_deletion;
            let flow = contraction(plastic, plastic);
            let mean = TrialStress::of(both);
            let recoverable = per_bulk * mean.pressure * mean.pressure + per_shear * mean.mises * mean.mises;
            let by_volume = recoverable * (strain.strain[0][l] + strain.strain[1][l] + strain.strain[2][l]);
            let kept_by_volume = if flow > 0.0 { by_volume } else { 0.0 };
            let spent = contraction(both, plastic) + self.compacted[l] - kept_by_volume;
            let spent = if is_kept { spent } else { 0.0 };
            update.dissipated[l] += volume * (spent + lost);
            update.damaged[l] += volume * lost;
            update.flow[l] = flow;
            let trial = mises(column(&update.deviator, l));
            let end = TrialStress::of(new);
            put_column(&mut update.plastic, l, plastic);
            put_column(&mut update.deviator, l, end.deviator);
            put_column(stress, l, new);
            let quotient = end.mises / trial;
            let ratio = if trial > 0.0 { quotient } else { 1.0 };
            update.returned[l] = if ratio < 1.0 - 1e-12 { ratio } else { 1.0 };
            // The constants of the elements contain the shear modulus.
            update.bulk[l] = self.bulk[l] + 4.0 / 3.0 * (self.shear[l] - strain.moduli.shear);
            update.shear[l] = self.shear[l];
        }
        // Apart from the loop over lanes: a sum of numbers is not reordered, which would keep that loop scalar.
        self.kept.iter().filter(|kept| **kept == 0.0).count()
    }
}
