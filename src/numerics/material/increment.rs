//! Inputs and outputs of a material in one increment.
#![allow(clippy::needless_range_loop)] // Loops over lanes are the form that compilers turn into vectors.

use crate::kernel::lanes::{InlineMap, LANES, Lanes};
use crate::kernel::moduli::ElasticModuli;

/// Smallest wave modulus over the initial one: a softening material keeps a finite stable time increment.
pub const LEAST_MODULUS: f64 = 1e-2;

/// Kinematics of a block of elements over an increment.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub struct StrainIncrement {
    /// Strain increments rr, zz, hoop, rz (tensor shear) in the middle of the increment.
    pub strain: [Lanes; 4],
    /// Previous stress, rotated with the material (Jaumann rate).
    pub carried: [Lanes; 4],
    /// Spin increments in the (r, z) plane, where [`super::Material::USES_SPIN`].
    pub spin: Lanes,
    /// Centres `[r, z]` of the elements or of their cells at the end of the increment, where
    /// [`super::Material::USES_PLACE`].
    pub place: [Lanes; 2],
    /// Volumes in the middle of the increment; 0 for lanes without element.
    pub volume: Lanes,
    /// Current volumes; only for materials with [`super::Material::EQUATION_OF_STATE`], as the next two fields.
    pub current_volume: Lanes,
    /// Masses of the elements.
    pub mass: Lanes,
    /// Stress of the bulk viscosity in the previous increment.
    pub viscous: Lanes,
    /// Length of the increment.
    pub dt: f64,
    /// Moduli of the elastic trial, upper bounds where they vary.
    pub moduli: ElasticModuli,
    /// Dynamic shear viscosity of a fluid; 0 for other materials.
    pub viscosity: f64,
    /// Lanes with an element.
    pub count: usize,
    /// Averaged minus own volumetric strain increments; `None` without averaging.
    pub averaging: Option<Lanes>,
}

/// Stress update of a block of elements: the elastic trial on entry, the results of the material on return.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub struct StressUpdate {
    /// Mean stress of the trial; pressure laws replace it.
    pub mean: Lanes,
    /// Deviator of the trial, relative to the back stress where there is one.
    pub deviator: [Lanes; 4],
    /// Von Mises stress of the deviator, for laws of [`super::PlasticFlow::Deviatoric`].
    pub trial: Lanes,
    /// Result: equivalent plastic strain increments; for [`super::PlasticFlow::Coupled`] a number that is positive
    /// during plastic flow.
    pub flow: Lanes,
    /// Result of [`super::PlasticFlow::Coupled`]: plastic strain increments. Other laws store the rotated back stress
    /// here.
    pub plastic: [Lanes; 4],
    /// Result: ratio of the returned to the trial stress, 1 without plastic flow.
    pub returned: Lanes,
    /// Result for varying moduli: bulk modulus.
    pub bulk: Lanes,
    /// Result for varying moduli without equation of state: shear modulus.
    pub shear: Lanes,
    /// Result of an equation of state: estimated work of the bulk viscosity.
    pub heat: Lanes,
    /// Result of a failure model with an equation of state: mean stress minus the largest tension of the material;
    /// negative infinity without a limit.
    pub tension_excess: Lanes,
    /// Result of a fluid with shear viscosity: work of the viscous stress.
    pub sheared: Lanes,
    /// Work of the stress, summed over the blocks of a task, lane by lane.
    pub internal: Lanes,
    /// Energy dissipated by plastic flow and damage, summed in the same way.
    pub dissipated: Lanes,
    /// Elastic energy lost by damage, a part of `dissipated`.
    pub damaged: Lanes,
    /// Number of elements that the material deleted.
    pub deleted: usize,
}

impl StrainIncrement {
    /// Returns the strain increments with averaged volumetric parts; `averaged` holds them if averaging is active.
    #[inline(always)]
    pub fn averaged<'a>(&'a self, averaged: &'a mut [Lanes; 4]) -> &'a [Lanes; 4] {
        let Some(averaging) = &self.averaging else { return &self.strain };
        *averaged = self.strain;
        for normal in &mut averaged[..3] {
            for l in 0..LANES {
                normal[l] += averaging[l] * (1.0 / 3.0);
            }
        }
        averaged
    }
}

impl StressUpdate {
    /// Resets sums and results at the start of a task: materials do not set results that are zero.
    #[inline(always)]
    pub fn begin(&mut self) {
        let tension_excess = [f64::NEG_INFINITY; LANES];
        *self = StressUpdate { returned: [1.0; LANES], tension_excess, ..StressUpdate::default() };
    }

    /// Adds the averaged part of the dilation to the mean stress of the trial.
    #[inline(always)]
    pub(super) fn add_averaged_dilation(&mut self, strain: &StrainIncrement) {
        let Some(averaging) = &strain.averaging else { return };
        for l in 0..LANES {
            self.mean[l] += strain.moduli.bulk * averaging[l];
        }
    }

    /// Computes the factor that returns the deviator to the yield surface from [`StressUpdate::flow`]. Equation (6.3).
    #[inline(always)]
    pub(super) fn return_to_yield_surface(&mut self, strain: &StrainIncrement) {
        let shear3 = 3.0 * strain.moduli.shear;
        for l in 0..LANES {
            let (trial, flow) = (self.trial[l], self.flow[l]);
            self.returned[l] = if flow > 0.0 { (trial - shear3 * flow) / trial } else { 1.0 };
        }
    }

    /// Returns the part of the previous stress along the plastic flow, whose product with the equivalent plastic strain
    /// increment is its plastic work: 3/2 times stress and trial deviator over the von Mises stress of the trial.
    #[inline(always)]
    pub(super) fn previous_along_flow(&self, strain: &StrainIncrement) -> Lanes {
        let mut along = [0.0; LANES];
        for l in 0..LANES {
            let part = |i: usize| strain.carried[i][l] * self.deviator[i][l];
            along[l] = 1.5 * ((part(0) + part(1)) + (part(2) + 2.0 * part(3))) / self.trial[l];
        }
        along
    }

    /// Sets the stress to mean stress plus deviator, the latter returned to the yield surface (`PLASTIC`) and shifted
    /// by the back stress (`BACK`), and adds the work of the stress and its plastic part. Both are that of the mean of
    /// previous and new stress, so that their difference is the change of elastic energy.
    #[inline(always)]
    pub(super) fn set_stress<const PLASTIC: bool, const BACK: bool>(
        &mut self,
        stress: &mut [Lanes; 4],
        strain: &StrainIncrement,
    ) {
        // The plastic strain increment is 3/2 of this times the deviator.
        let per_shear3 = if strain.moduli.shear > 0.0 { 1.0 / (3.0 * strain.moduli.shear) } else { 0.0 };
        for l in 0..LANES {
            let (factor, mean) = (if PLASTIC { self.returned[l] } else { 1.0 }, self.mean[l]);
            let mut s = [
                mean + factor * self.deviator[0][l],
                mean + factor * self.deviator[1][l],
                mean + factor * self.deviator[2][l],
                factor * self.deviator[3][l],
            ];
            if BACK {
                for i in 0..4 {
                    s[i] += self.plastic[i][l];
                }
            }
            let both = [0, 1, 2, 3].inline_map(|i| strain.carried[i][l] + s[i]);
            let double = |i: usize| strain.strain[i][l] * both[i];
            self.internal[l] += 0.5 * strain.volume[l] * ((double(0) + double(1)) + (double(2) + 2.0 * double(3)));
            if PLASTIC {
                let along = |i: usize| self.deviator[i][l] * both[i];
                let work = (along(0) + along(1)) + (along(2) + 2.0 * along(3));
                self.dissipated[l] += 0.75 * strain.volume[l] * ((1.0 - factor) * per_shear3) * work;
            }
            for i in 0..4 {
                stress[i][l] = s[i];
            }
        }
    }

    /// Sets the stress of a law of the deformation gradient, and adds its work: that of the mean of previous and new stress,
    /// each with its orientation, so that it is the work of the forces to the third order of the increment. Equation (14.3).
    #[inline(always)]
    pub(super) fn set_total_stress(&mut self, stress: &mut [Lanes; 4], strain: &StrainIncrement) {
        for l in 0..LANES {
            let mean = self.mean[l];
            let new = [0, 1, 2, 3].inline_map(|i| if i < 3 { mean + self.deviator[i][l] } else { self.deviator[i][l] });
            let double = |i: usize| strain.strain[i][l] * (stress[i][l] + new[i]);
            self.internal[l] += 0.5 * strain.volume[l] * ((double(0) + double(1)) + (double(2) + 2.0 * double(3)));
            for i in 0..4 {
                stress[i][l] = new[i];
            }
        }
    }
}
