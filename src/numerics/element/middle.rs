//! Material state at the centre of each element of a block that determines the assumed stresses at its edges: moduli,
//! plastic flow, damage.
#![allow(clippy::needless_range_loop)] // Compilers vectorize loops over lanes in this form.

use super::block::TaskWorkspace;
use super::constants::ElementConstants;
use crate::kernel::assumed::moduli;
use crate::kernel::lanes::{LANES, Lanes, column};
use crate::kernel::stress::mises;
use crate::material::Material;
use crate::material::increment::StressUpdate;

/// Largest ratio of the trace of the patterns' squared frequencies to the squared frequency bound of the strains. It
/// limits the stiffness of folded elements, whose patterns move almost no mass.
const SLOW: f64 = 0.5;

/// Material state at the centres of a block's elements.
#[repr(C, align(64))]
pub(super) struct CentroidState {
    /// Deviator of the elastic trial stress, relative to the centre of the yield surface, and its von Mises stress.
    pub deviator: [Lanes; 4],
    pub trial: Lanes,
    /// Moduli of a strain: for the stress in its direction, for the transverse stress, and the ratio of transverse to
    /// direct modulus.
    pub along: Lanes,
    pub transverse: Lanes,
    pub ratio: Lanes,
    /// Longitudinal modulus over the direct modulus, times the largest ratio of squared frequencies.
    pub slow: Lanes,
    /// One over twice the shear modulus.
    pub compliance: Lanes,
    /// Remaining stiffness fraction of damage, and its ratio to the previous one.
    pub share: Lanes,
    pub remains: Lanes,
}

/// Moduli of one lane, as in [`CentroidState`].
struct LaneModuli {
    along: f64,
    transverse: f64,
    ratio: f64,
    slow: f64,
    compliance: f64,
}

impl LaneModuli {
    #[inline(always)]
    fn of(bulk: f64, shear: f64) -> LaneModuli {
        let [along, transverse] = moduli(bulk, shear);
        // Without a shear modulus, the direct modulus is zero.
        let (per, compliance) = if shear > 0.0 { (1.0 / along, 0.5 / shear) } else { (0.0, 0.0) };
        let slow = 3.0 * SLOW * (bulk + 4.0 / 3.0 * shear) * per;
        LaneModuli { along, transverse, ratio: transverse * per, slow, compliance }
    }
}

impl CentroidState {
    /// Returns the state of a material without damage and with constant moduli.
    #[inline(always)]
    pub fn of(constants: &ElementConstants, scratch: &TaskWorkspace) -> CentroidState {
        let ElementConstants { bulk, shear, .. } = *constants;
        let LaneModuli { along, transverse, ratio, slow, compliance } = LaneModuli::of(bulk, shear);
        CentroidState {
            deviator: scratch.stress.deviator,
            trial: scratch.stress.trial,
            along: [along; LANES],
            transverse: [transverse; LANES],
            ratio: [ratio; LANES],
            slow: [slow; LANES],
            compliance: [compliance; LANES],
            share: [1.0; LANES],
            remains: [1.0; LANES],
        }
    }

    /// Sets the current moduli of a material whose moduli vary.
    #[inline(always)]
    pub fn vary<M: Material>(&mut self, constants: &ElementConstants, scratch: &TaskWorkspace) {
        for l in 0..LANES {
            let (mut bulk, mut shear) = (scratch.stress.bulk[l], constants.shear);
            if !M::EQUATION_OF_STATE {
                shear = scratch.stress.shear[l];
                bulk += 4.0 / 3.0 * (constants.shear - shear);
                bulk = if bulk > shear { bulk } else { shear };
            }
            let LaneModuli { along, transverse, ratio, slow, compliance } = LaneModuli::of(bulk, shear);
            self.along[l] = along;
            self.transverse[l] = transverse;
            self.ratio[l] = ratio;
            self.slow[l] = slow;
            self.compliance[l] = compliance;
        }
    }

    #[inline(always)]
    pub fn fail(&mut self, before: &Lanes, after: &Lanes) {
        for l in 0..LANES {
            let (had, has) = (before[l], after[l]);
            self.share[l] = has;
            self.remains[l] = if had > 0.0 { has / had } else { 0.0 };
        }
    }

    /// Restores the trial stress from the plastic strain of coupled flow, and the ratio of returned to trial stress.
    #[inline(always)]
    pub fn undo_flow(&mut self, update: &mut StressUpdate) {
        for l in 0..LANES {
            let plastic = column(&update.plastic, l);
            let mean = (plastic[0] + plastic[1] + plastic[2]) * (1.0 / 3.0);
            let end = column(&self.deviator, l);
            let twice = 1.0 / self.compliance[l];
            let normal = |i: usize| end[i] + twice * (plastic[i] - mean);
            let trial = [normal(0), normal(1), normal(2), end[3] + twice * plastic[3]];
            for i in 0..4 {
                self.deviator[i][l] = trial[i];
            }
            self.trial[l] = mises(trial);
            let flows = update.flow[l] > 0.0;
            update.returned[l] = if flows { mises(end) / self.trial[l] } else { 1.0 };
        }
    }
}
