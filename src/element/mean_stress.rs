//! The phase of a block that asks its volumetric law for the mean stress.
//! Never here: the law.
#![allow(clippy::needless_range_loop)] // Loops over lanes are the form that compilers turn into vectors.

use super::block::{Block, Nodes, Stage};
use crate::kernel::lanes::LANES;
use crate::kernel::quad::{UNIT, operators};
use crate::material::plasticity::Hardening;
use crate::material::volumetric::{Squeeze, Stretch, Volumetric};

impl<S: Clone, Q: Clone, X: Clone> Block<S, Q, X> {
    /// Mean stress by the volumetric law, with the work of the deviator that the yield surface left.
    #[inline(always)]
    pub(super) fn respond<H: Hardening, V: Volumetric<State = Q>, const AREA: bool>(
        &mut self,
        law: &V,
        shear3: f64,
        nodes: &Nodes,
        stage: &mut Stage,
    ) {
        if V::TOTAL {
            let ask = Stretch {
                strain: &stage.strain,
                spin: &stage.spin,
                mean: &mut stage.mean,
                deviator: &mut stage.deviator,
                bulk: &mut stage.bulk,
                heat: &mut stage.heat,
            };
            law.stretch(&mut self.volumetric, ask);
            return;
        }
        let (mut work, mut dilation, mut volume) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for l in 0..LANES {
            let mut factor = 1.0;
            if H::FLOWS {
                let (trial, flow) = (stage.trial[l], stage.flow[l]);
                factor = if flow > 0.0 { (trial - shear3 * flow) / trial } else { 1.0 };
            }
            let mean = stage.mean[l];
            let normal = |i: usize| stage.strain[i][l] * ((stage.carried[i][l] - mean) + factor * stage.deviator[i][l]);
            let shear = 2.0 * stage.strain[3][l] * (stage.carried[3][l] + factor * stage.deviator[3][l]);
            work[l] = 0.5 * stage.volume[l] * ((normal(0) + normal(1)) + (normal(2) + shear));
            dilation[l] = stage.strain[0][l] + stage.strain[1][l] + stage.strain[2][l];
            volume[l] = UNIT * operators::<AREA>(nodes.of(l, 0), nodes.of(l, 1)).volume;
        }
        let viscous = stage.viscous.get(stage.at).copied().unwrap_or_default();
        let ask = Squeeze {
            mean: &mut stage.mean,
            bulk: &mut stage.bulk,
            viscous: &viscous,
            heat: &mut stage.heat,
            dilation: &dilation,
            work: &work,
            middle: &stage.volume,
            volume: &volume,
            mass: &self.mass,
        };
        law.squeeze(&mut self.volumetric, ask);
    }
}
