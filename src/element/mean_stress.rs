//! The phase of a block that asks its volumetric law for the mean stress.
//! Never here: the law.
#![allow(clippy::needless_range_loop)] // Loops over lanes are the form that compilers turn into vectors.

use super::block::{Block, Workspace};
use crate::kernel::lanes::{LANES, column};
use crate::kernel::quad::{Operators, UNIT};
use crate::material::plasticity::Hardening;
use crate::material::volumetric::{Squeeze, Stretch, Volumetric};

impl<S: Clone, Q: Clone, X: Clone> Block<S, Q, X> {
    /// Mean stress by the volumetric law, with the work of the deviator that the yield surface left.
    #[inline(always)]
    pub(super) fn respond<H: Hardening, V: Volumetric<State = Q>, const AREA: bool>(
        &mut self,
        law: &V,
        (shear3, dt): (f64, f64),
        scratch: &mut Workspace,
    ) {
        if V::TOTAL {
            let own = scratch.lacking.map(|_| scratch.strain);
            if let Some(lacking) = &scratch.lacking {
                for l in 0..LANES {
                    for normal in &mut scratch.strain[..3] {
                        normal[l] += lacking[l] * (1.0 / 3.0);
                    }
                }
            }
            let ask = Stretch {
                strain: &scratch.strain,
                spin: &scratch.spin,
                dt,
                mean: &mut scratch.mean,
                deviator: &mut scratch.deviator,
                plastic: &mut scratch.back,
                dissipated: &mut scratch.flow,
                bulk: &mut scratch.bulk,
                shear: &mut scratch.shear,
                heat: &mut scratch.heat,
            };
            law.stretch(&mut self.volumetric, ask);
            if let Some(own) = own {
                scratch.strain = own;
            }
            if V::FLOWS {
                for l in 0..LANES {
                    scratch.sums.plastic[l] += scratch.volume[l] * scratch.flow[l];
                }
            }
            return;
        }
        let (mut work, mut dilation, mut volume) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for l in 0..LANES {
            let mut factor = 1.0;
            if H::PLASTIC {
                let (trial, flow) = (scratch.trial[l], scratch.flow[l]);
                factor = if flow > 0.0 { (trial - shear3 * flow) / trial } else { 1.0 };
            }
            let mean = scratch.mean[l];
            let normal =
                |i: usize| scratch.strain[i][l] * ((scratch.carried[i][l] - mean) + factor * scratch.deviator[i][l]);
            let shear = 2.0 * scratch.strain[3][l] * (scratch.carried[3][l] + factor * scratch.deviator[3][l]);
            work[l] = 0.5 * scratch.volume[l] * ((normal(0) + normal(1)) + (normal(2) + shear));
            dilation[l] = scratch.strain[0][l] + scratch.strain[1][l] + scratch.strain[2][l];
            volume[l] = UNIT * Operators::of::<AREA>(column(&scratch.r, l), column(&scratch.z, l)).volume;
        }
        let viscous = scratch.viscous.get(scratch.at).copied().unwrap_or_default();
        let ask = Squeeze {
            mean: &mut scratch.mean,
            bulk: &mut scratch.bulk,
            viscous: &viscous,
            heat: &mut scratch.heat,
            dilation: &dilation,
            work: &work,
            middle: &scratch.volume,
            volume: &volume,
            mass: &self.mass,
        };
        law.squeeze(&mut self.volumetric, ask);
    }
}
