//! What the middle of each element of a block says of what is assumed at its edges: moduli, what flows, what damage leaves.
//! Never here: strains of the patterns.
#![allow(clippy::needless_range_loop)] // Loops over lanes are the form that compilers turn into vectors.

use super::block::Workspace;
use super::constants::Constants;
use crate::kernel::assumed::moduli;
use crate::kernel::lanes::{LANES, Lanes, column};
use crate::kernel::stress::mises;
use crate::material::Material;
use crate::material::increment::StressUpdate;

/// The largest trace of the squares of the patterns' frequencies over the square of that of the strains' bound: a folded
/// element, whose patterns move next to no mass, has no more stiffness than that.
const SLOW: f64 = 0.5;

/// What the middle of each element says of what flows at its edges.
#[repr(C, align(64))]
pub(super) struct Middle {
    /// Deviator of the elastic trial, reckoned from the middle of the yield surface, and its von Mises stress.
    pub deviator: [Lanes; 4],
    pub trial: Lanes,
    /// Moduli of a stress: along a strain, beside it, and that over the one along it.
    pub along: Lanes,
    pub beside: Lanes,
    pub ratio: Lanes,
    /// Modulus of a wave over that along a strain, with what the patterns' frequencies may be of the strains'.
    pub slow: Lanes,
    /// One over twice the shear modulus.
    pub compliance: Lanes,
    /// Part of the stress that damage leaves, and that over what it left before.
    pub share: Lanes,
    pub remains: Lanes,
}

/// The moduli of one lane as [`Middle`] has them.
struct Elastic {
    along: f64,
    beside: f64,
    ratio: f64,
    slow: f64,
    compliance: f64,
}

impl Elastic {
    #[inline(always)]
    fn of(bulk: f64, shear: f64) -> Elastic {
        let [along, beside] = moduli(bulk, shear);
        // Without a shear modulus there is nothing along either.
        let (per, compliance) = if shear > 0.0 { (1.0 / along, 0.5 / shear) } else { (0.0, 0.0) };
        let slow = 3.0 * SLOW * (bulk + 4.0 / 3.0 * shear) * per;
        Elastic { along, beside, ratio: beside * per, slow, compliance }
    }
}

impl Middle {
    /// Of a material without damage that has these moduli everywhere.
    #[inline(always)]
    pub fn of(constants: &Constants, scratch: &Workspace) -> Middle {
        let Constants { bulk, shear, .. } = *constants;
        let Elastic { along, beside, ratio, slow, compliance } = Elastic::of(bulk, shear);
        Middle {
            deviator: scratch.stress.deviator,
            trial: scratch.stress.trial,
            along: [along; LANES],
            beside: [beside; LANES],
            ratio: [ratio; LANES],
            slow: [slow; LANES],
            compliance: [compliance; LANES],
            share: [1.0; LANES],
            remains: [1.0; LANES],
        }
    }

    /// Moduli of now where they vary.
    #[inline(always)]
    pub fn vary<M: Material>(&mut self, constants: &Constants, scratch: &Workspace) {
        for l in 0..LANES {
            let (mut bulk, mut shear) = (scratch.stress.bulk[l], constants.shear);
            if !M::EQUATION_OF_STATE {
                shear = scratch.stress.shear[l];
                bulk += 4.0 / 3.0 * (constants.shear - shear);
                bulk = if bulk > shear { bulk } else { shear };
            }
            let Elastic { along, beside, ratio, slow, compliance } = Elastic::of(bulk, shear);
            self.along[l] = along;
            self.beside[l] = beside;
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

    /// Of coupled plastic flow: the trial from the plastic strain, and the part of it that is left.
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
