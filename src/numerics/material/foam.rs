//! Crushable foam: an elliptic yield surface in the plane of pressure and von Mises stress (ABAQUS Analysis User's
//! Guide, "Crushable foam plasticity models"; isotropic hardening after Deshpande and Fleck 2000, J. Mech. Phys. Solids
//! 48, 1253).
#![allow(clippy::needless_range_loop)] // Loops over lanes are written as in the other laws.

use crate::kernel::hardening::{LinearTable, RateFactor};
use crate::kernel::lanes::{InlineMap, LANES, Lanes};
use crate::material::carried::carried_state;
use crate::material::increment::{StrainIncrement, StressUpdate};
use crate::material::{BlockStart, Material, PlasticFlow};
use crate::state::archive::Persist;
use crate::variables::{Variable, VariableComponent};

/// Hardening of the yield surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FoamHardening {
    /// Volumetric hardening: by compaction, with constant strength in hydrostatic tension. Flow is along the stress, so
    /// that uniaxial compression causes no lateral plastic strain.
    Volumetric {
        /// Ratio of the initial yield stresses in uniaxial and hydrostatic compression, k.
        compression: f64,
        /// Ratio of the yield stress in hydrostatic tension to the initial one in hydrostatic compression, k_t.
        tension: f64,
    },
    /// Isotropic hardening: uniform growth by the equivalent plastic strain, plastic work over yield stress.
    Isotropic {
        /// Ratio of the yield stresses in uniaxial and hydrostatic compression, k.
        compression: f64,
        /// Plastic Poisson's ratio.
        ratio: f64,
    },
}

#[derive(Clone, Debug)]
pub struct FoamMaterial {
    pub growth: FoamHardening,
    /// Yield stress in uniaxial compression over the plastic strain, constant beyond both ends of the table.
    pub hardening: LinearTable,
    /// Rate factor on the yield stress.
    pub rate: Option<RateFactor>,
    /// Bulk and shear modulus.
    pub moduli: [f64; 2],
}

/// State variables of a block.
#[derive(Clone, Debug, Persist)]
pub struct FoamState {
    /// Compacting volumetric plastic strain (volumetric hardening) or equivalent plastic strain (isotropic hardening).
    strain: Lanes,
}

/// Result of the return to the yield surface.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FoamReturn {
    pressure: f64,
    mises: f64,
    /// Plastic multiplier: plastic strain over the stress that is normal to the flow potential.
    flow: f64,
    /// Increment of the hardening strain.
    hardening: f64,
}

/// Yield surface and flow potential of a foam.
struct FoamSurface<'a> {
    law: &'a FoamMaterial,
    /// Squared shape factors beta² of the flow potential sqrt(q² + beta² p²) and alpha² of the yield surface
    /// sqrt(q² + alpha² (p - p0)²).
    beta2: f64,
    alpha2: f64,
    /// Half axis along the von Mises stress: over that along the pressure (volumetric hardening), over the yield stress in
    /// uniaxial compression (isotropic hardening).
    half: f64,
    /// Strength in hydrostatic tension; used for volumetric hardening.
    drawn: f64,
}

impl FoamSurface<'_> {
    fn new(law: &FoamMaterial) -> FoamSurface<'_> {
        match law.growth {
            FoamHardening::Volumetric { compression: k, tension } => {
                let alpha2 = 9.0 * k * k / ((3.0 * tension + k) * (3.0 - k));
                let drawn = tension * law.hardening.value(0.0) / k;
                FoamSurface { law, beta2: 4.5, alpha2, half: alpha2.sqrt(), drawn }
            }
            FoamHardening::Isotropic { compression: k, ratio } => {
                let alpha2 = 9.0 * k * k / (9.0 - k * k);
                let beta2 = 4.5 * (1.0 - 2.0 * ratio) / (1.0 + ratio);
                FoamSurface { law, beta2, alpha2, half: (1.0 + alpha2 / 9.0).sqrt(), drawn: 0.0 }
            }
        }
    }

    /// Returns the centre of the yield surface on the pressure axis and its half axis along the von Mises stress, for a
    /// yield stress in uniaxial compression. Equation (6.14).
    fn axes(&self, uniaxial: f64) -> [f64; 2] {
        let FoamSurface { alpha2, half, drawn, .. } = *self;
        match self.law.growth {
            FoamHardening::Volumetric { .. } => {
                // The ellipse passes through hydrostatic tension and uniaxial compression.
                let pressed =
                    uniaxial * (uniaxial * (1.0 / alpha2 + 1.0 / 9.0) + drawn / 3.0) / (drawn + uniaxial / 3.0);
                [0.5 * (pressed - drawn), half * 0.5 * (pressed + drawn)]
            }
            FoamHardening::Isotropic { .. } => [0.0, uniaxial * half],
        }
    }

    /// Returns the state for a ratio `share` of the von Mises stress to that of the trial, and its yield function:
    /// positive outside the surface. Equations (6.13), (6.15).
    fn at(&self, share: f64, [pressure, mises]: [f64; 2], before: f64, dt: f64) -> (FoamReturn, f64) {
        let FoamSurface { law, beta2, alpha2, half, .. } = *self;
        let [bulk, shear] = law.moduli;
        // With the plastic multiplier x: q = q_trial/(1 + 3 G x), p = p_trial/(1 + beta² K x).
        let flow = (1.0 / share - 1.0) / (3.0 * shear);
        let (p, q) = (pressure / (1.0 + beta2 * bulk * flow), mises * share);
        let potential = (q * q + beta2 * p * p).sqrt();
        let hardening = match law.growth {
            FoamHardening::Volumetric { .. } => beta2 * flow * p,
            FoamHardening::Isotropic { .. } => {
                let yielding = (q * q + alpha2 * p * p).sqrt() / half;
                if yielding > 0.0 { flow * potential * potential / yielding } else { 0.0 }
            }
        };
        let mut uniaxial = law.hardening.value(before + hardening);
        if let (Some(rate), true) = (&law.rate, dt > 0.0) {
            // The rate of the axial strain in uniaxial compression.
            let axial = match law.growth {
                FoamHardening::Volumetric { .. } => 1.5_f64.sqrt() * flow * potential,
                FoamHardening::Isotropic { .. } => hardening,
            };
            uniaxial *= rate.at(axial / dt, 0.0);
        }
        let [centre, half] = self.axes(uniaxial);
        let away = p - centre;
        let outside = (q * q + alpha2 * away * away).sqrt() - half;
        (FoamReturn { pressure: p, mises: q, flow, hardening }, outside)
    }

    /// Returns a ratio of the von Mises stresses below that of the return, if the yield surface is nearly plane up to there:
    /// hardening only increases the ratio. `outside` is the yield function of the trial.
    fn without_hardening(&self, [pressure, mises]: [f64; 2], before: f64, outside: f64) -> f64 {
        let FoamSurface { law: FoamMaterial { moduli: [bulk, shear], hardening, .. }, beta2, alpha2, .. } = *self;
        let [centre, _] = self.axes(hardening.value(before));
        let away = pressure - centre;
        let by_share = mises * mises + alpha2 * away * pressure * beta2 * bulk / (3.0 * shear);
        let share = 1.0 - 1.1 * outside * (mises * mises + alpha2 * away * away).sqrt() / by_share;
        if share > 0.5 && share < 1.0 { share } else { 0.5 }
    }

    /// Returns a trial stress to the yield surface, by the Illinois method for the ratio of the von Mises stresses
    /// between 0 and 1 (Dowell and Jarratt 1971, BIT 11, 168); `None` for an elastic trial.
    fn flow(&self, trial: [f64; 2], before: f64, dt: f64) -> Option<FoamReturn> {
        let (start, mut high) = self.at(1.0, trial, before, dt);
        let size = high + self.law.hardening.value(before);
        // A NaN is not returned, so that the run halts.
        if high.is_nan() || high <= 1e-14 * size {
            return None;
        }
        let (mut upper, mut lower) = (1.0, self.without_hardening(trial, before, high));
        let mut root = start;
        let mut low = 0.0;
        for _ in 0..200 {
            (root, low) = self.at(lower, trial, before, dt);
            if low <= 0.0 {
                break;
            }
            (upper, high, lower) = (lower, low, 0.5 * lower);
        }
        if low.abs() <= 1e-13 * size {
            return Some(root);
        }
        // Bound that the last iteration replaced: 1 upper, -1 lower.
        let mut last = 0;
        for _ in 0..100 {
            let share = lower + (upper - lower) * low / (low - high);
            let (next, outside) = self.at(share, trial, before, dt);
            root = next;
            if outside.abs() <= 1e-13 * size || upper - lower <= 1e-15 * upper {
                break;
            }
            if outside > 0.0 {
                (upper, high) = (share, outside);
                low *= if last == 1 { 0.5 } else { 1.0 };
                last = 1;
            } else {
                (lower, low) = (share, outside);
                high *= if last == -1 { 0.5 } else { 1.0 };
                last = -1;
            }
        }
        Some(root)
    }
}

impl Material for FoamMaterial {
    type State = FoamState;
    const FLOW: PlasticFlow = PlasticFlow::Coupled;
    const MODULI_VARY: bool = true;

    fn initial_state(&self, _start: &BlockStart) -> FoamState {
        FoamState { strain: [0.0; LANES] }
    }

    #[inline(always)]
    fn update(
        &self,
        state: &mut FoamState,
        stress: &mut [Lanes; 4],
        strain: &StrainIncrement,
        update: &mut StressUpdate,
    ) {
        let surface = FoamSurface::new(self);
        let beta2 = surface.beta2;
        for l in 0..LANES {
            let s = [0, 1, 2, 3].inline_map(|i| update.deviator[i][l]);
            let mises = (1.5 * (s[0] * s[0] + s[1] * s[1] + s[2] * s[2]) + 3.0 * s[3] * s[3]).sqrt();
            let trial = [-update.mean[l], mises];
            let flown = surface.flow(trial, state.strain[l], strain.dt);
            let FoamReturn { pressure, mises: q, flow, hardening } =
                flown.unwrap_or(FoamReturn { pressure: trial[0], mises, flow: 0.0, hardening: 0.0 });
            let factor = if q < mises { q / mises } else { 1.0 };
            for i in 0..4 {
                update.deviator[i][l] = factor * s[i];
                let along = if i < 3 { beta2 / 3.0 * -pressure } else { 0.0 };
                update.plastic[i][l] = flow * (1.5 * update.deviator[i][l] + along);
            }
            update.mean[l] = -pressure;
            update.flow[l] = flow;
            state.strain[l] += hardening;
            update.bulk[l] = self.moduli[0];
            update.shear[l] = self.moduli[1];
        }
        update.set_stress::<false, false>(stress, strain);
        for l in 0..LANES {
            let work = |i: usize| (strain.carried[i][l] + stress[i][l]) * update.plastic[i][l];
            let both = (work(0) + work(1)) + (work(2) + 2.0 * work(3));
            update.dissipated[l] += 0.5 * strain.volume[l] * both;
        }
    }

    fn value(&self, state: &FoamState, lane: usize, part: VariableComponent) -> Option<f64> {
        (part.variable == Variable::PlasticStrain).then(|| state.strain[lane])
    }
}

carried_state!(FoamState { strain });

#[cfg(test)]
mod tests {
    use super::{FoamHardening, FoamMaterial, FoamSurface};
    use crate::kernel::hardening::LinearTable;

    fn foam(growth: FoamHardening) -> FoamMaterial {
        let hardening = LinearTable { rows: vec![[6.0, 0.0], [7.0, 0.4], [20.0, 0.8]] };
        FoamMaterial { growth, hardening, rate: None, moduli: [50.0, 75.0] }
    }

    /// Uniaxial and hydrostatic compression and hydrostatic tension are on the initial yield surface.
    #[test]
    fn initial_yield_surface_passes_through_the_given_strengths() {
        let (k, kt) = (1.1, 0.1);
        let p_c = 6.0 / k;
        for (growth, tension) in [
            (FoamHardening::Volumetric { compression: k, tension: kt }, kt * p_c),
            (FoamHardening::Isotropic { compression: k, ratio: 0.2 }, p_c),
        ] {
            let law = foam(growth);
            let surface = FoamSurface::new(&law);
            let ([centre, half], alpha2) = (surface.axes(6.0), surface.alpha2);
            for [p, q] in [[2.0, 6.0], [p_c, 0.0], [-tension, 0.0]] {
                let outside = (q * q + alpha2 * (p - centre) * (p - centre)).sqrt() - half;
                assert!(outside.abs() < 1e-12, "{growth:?} {p} {q}: {outside}");
            }
        }
    }

    /// The returned stress is on the hardened yield surface, even for distant trials.
    #[test]
    fn trial_stress_returns_to_the_yield_surface() {
        for growth in [
            FoamHardening::Volumetric { compression: 1.1, tension: 0.1 },
            FoamHardening::Volumetric { compression: 1.1, tension: 0.0 },
            FoamHardening::Isotropic { compression: 1.7, ratio: -0.2 },
        ] {
            let law = foam(growth);
            let surface = FoamSurface::new(&law);
            for trial in [[20.0, 60.0], [-30.0, 0.0], [6.0, 0.0], [300.0, 10.0], [-30.0, 40.0], [2.1, 6.3]] {
                let Some(flown) = surface.flow(trial, 0.05, 1.0) else { panic!("{growth:?} {trial:?} flows") };
                let share = 1.0 / (1.0 + 3.0 * law.moduli[1] * flown.flow);
                let (_, outside) = surface.at(share, trial, 0.05, 1.0);
                assert!(outside.abs() < 1e-9 && flown.flow > 0.0, "{growth:?} {trial:?}: {outside:e}");
            }
            assert_eq!(surface.flow([1.0, 2.0], 0.0, 1.0), None);
        }
    }
}
