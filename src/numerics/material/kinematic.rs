//! Linear kinematic hardening: the yield surface translates with the plastic strain and keeps its size.
#![allow(clippy::needless_range_loop)] // Loops over lanes are the form that compilers turn into vectors.

use crate::kernel::lanes::LANES;
use crate::kernel::lanes::Lanes;
use crate::material::carried::carried_state;
use crate::material::plasticity::{FlowUpdate, HardeningLaw};
use crate::state::archive::Persist;

/// Linear kinematic hardening of Prager and Ziegler (ABAQUS Analysis User's Guide, "Models for metals subjected to
/// cyclic loading", linear kinematic hardening): the back stress grows by 2/3 C times the plastic strain and rotates
/// with the material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KinematicHardening {
    /// Radius of the yield surface: the initial yield stress.
    pub yield_stress: f64,
    /// C, slope of the stress over the plastic strain in uniaxial tension.
    pub slope: f64,
}

/// State variables of a block.
#[derive(Clone, Debug, Persist)]
pub struct BackStress {
    strain: Lanes,
    /// Back stress: rr, zz, hoop, rz; its trace is zero.
    back: [Lanes; 4],
}

impl HardeningLaw for KinematicHardening {
    type State = BackStress;
    const PLASTIC: bool = true;
    const BACKSTRESS: bool = true;

    fn fresh(&self) -> BackStress {
        BackStress { strain: [0.0; LANES], back: [[0.0; LANES]; 4] }
    }

    /// Computes the plastic increment by radial return: the trial stress relative to the back stress minus (3 G + C) dp
    /// equals the yield stress. Equation (6.8).
    #[inline(always)]
    fn flow(&self, state: &mut BackStress, flow: &mut FlowUpdate<'_>) {
        let per = 1.0 / (flow.shear3 + self.slope);
        for l in 0..LANES {
            let dp = (flow.trial[l] - self.yield_stress) * per;
            let increment = if dp > 0.0 { dp } else { 0.0 };
            flow.increment[l] = increment;
            state.strain[l] += increment;
        }
    }

    #[inline(always)]
    fn back_stress(&self, state: &BackStress) -> [Lanes; 4] {
        state.back
    }

    /// Adds the increment of the back stress, along the plastic strain increment. The plastic strain increment is 3/2
    /// dp times the direction of the relative stress. Equation (6.8).
    #[inline(always)]
    fn update_back_stress(
        &self,
        state: &mut BackStress,
        carried: &[Lanes; 4],
        relative: &[Lanes; 4],
        trial: &Lanes,
        flow: &Lanes,
        _remaining: Option<&Lanes>,
    ) {
        for l in 0..LANES {
            let part = if flow[l] > 0.0 { self.slope * flow[l] / trial[l] } else { 0.0 };
            for i in 0..4 {
                state.back[i][l] = carried[i][l] + part * relative[i][l];
            }
        }
    }

    fn plastic_strain(&self, state: &BackStress, lane: usize) -> f64 {
        state.strain[lane]
    }
}

carried_state!(BackStress { strain, back });
