//! Hyperelastic materials (rubber): the stress is a function of the total deformation gradient.
#![allow(clippy::needless_range_loop)] // Loops over lanes are the form that compilers turn into vectors.

use crate::kernel::lanes::Lanes;
use crate::kernel::lanes::{InlineMap, LANES};
use crate::kernel::transcendental::inverse_cbrt;
use crate::material::carried::carried_state;
use crate::material::increment::{LEAST_MODULUS, StrainIncrement, StressUpdate};
use crate::material::strain_energy::{PrincipalResponse, StrainEnergy, VolumetricEnergy};
use crate::material::{BlockStart, Material};
use crate::state::archive::Persist;

/// Neo-Hooke: U = C10 (J^(-2/3) tr B - 3) + (J - 1)²/D1. The Cauchy stress is 2 C10 J^(-5/3) dev B + 2 (J - 1)/D1
/// (ABAQUS Theory Guide, "Hyperelastic material behavior").
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeoHooke {
    /// C10, half the initial shear modulus.
    pub c10: f64,
    /// D1, two over the initial bulk modulus.
    pub d1: f64,
}

/// State variables of a block.
#[derive(Clone, Debug, Persist)]
pub struct DeformationState {
    /// Deformation gradient: rr, rz, zr, zz, and the hoop stretch r/R.
    gradient: [Lanes; 5],
}

impl DeformationState {
    pub(super) fn fresh() -> DeformationState {
        let (unity, zero) = ([1.0; LANES], [0.0; LANES]);
        DeformationState { gradient: [unity, zero, zero, unity, unity] }
    }

    /// Updates the deformation gradient by (1 + h/2)(1 - h/2)^-1 F with the displacement gradient h in the middle of
    /// the increment. The update is exact, since the middle configuration is the mean of both ends. Equation (6.9).
    #[inline(always)]
    pub(super) fn advance(&mut self, increment: &StrainIncrement) {
        let mut averaged = [[0.0; LANES]; 4];
        let strain = increment.averaged(&mut averaged);
        for l in 0..LANES {
            let now = self.advanced(strain, &increment.spin, l);
            for i in 0..5 {
                self.gradient[i][l] = now[i];
            }
        }
    }

    /// Returns the deformation gradient of a lane: rr, rz, zr, zz, hoop.
    #[inline(always)]
    pub(super) fn of(&self, l: usize) -> [f64; 5] {
        [0, 1, 2, 3, 4].inline_map(|i| self.gradient[i][l])
    }

    #[inline(always)]
    fn advanced(&self, strain: &[Lanes; 4], spin: &Lanes, l: usize) -> [f64; 5] {
        let (a, d) = (0.5 * strain[0][l], 0.5 * strain[1][l]);
        let (b, c) = (0.5 * (strain[3][l] + spin[l]), 0.5 * (strain[3][l] - spin[l]));
        let [rr, rz, zr, zz, hoop] = self.of(l);
        // (1 - h/2)^-1 F, then (1 + h/2) times it.
        let (determinant, shorter) = ((1.0 - a) * (1.0 - d) - b * c, 1.0 - 0.5 * strain[2][l]);
        let both = 1.0 / (determinant * shorter);
        let per = shorter * both;
        let (m_rr, m_rz) = (per * ((1.0 - d) * rr + b * zr), per * ((1.0 - d) * rz + b * zz));
        let (m_zr, m_zz) = (per * (c * rr + (1.0 - a) * zr), per * (c * rz + (1.0 - a) * zz));
        [
            (1.0 + a) * m_rr + b * m_zr,
            (1.0 + a) * m_rz + b * m_zz,
            c * m_rr + (1.0 + d) * m_zr,
            c * m_rz + (1.0 + d) * m_zz,
            hoop * (1.0 + 0.5 * strain[2][l]) * (determinant * both),
        ]
    }
}

impl Material for NeoHooke {
    type State = DeformationState;
    const MODULI_VARY: bool = true;
    const USES_SPIN: bool = true;
    const OF_GRADIENT: bool = true;

    fn initial_state(&self, _start: &BlockStart) -> DeformationState {
        DeformationState::fresh()
    }

    fn initial_bulk(&self) -> f64 {
        2.0 / self.d1
    }

    /// Equation (6.10).
    #[inline(always)]
    fn update(
        &self,
        state: &mut DeformationState,
        stress: &mut [Lanes; 4],
        strain: &StrainIncrement,
        update: &mut StressUpdate,
    ) {
        let (shear, bulk) = (2.0 * self.c10, 2.0 / self.d1);
        state.advance(strain);
        for l in 0..LANES {
            let [rr, rz, zr, zz, hoop] = state.of(l);
            let left_cauchy_green = [rr * rr + rz * rz, zr * zr + zz * zz, hoop * hoop, rr * zr + rz * zz];
            let trace = left_cauchy_green[0] + left_cauchy_green[1] + left_cauchy_green[2];
            let j = (rr * zz - rz * zr) * hoop;
            let third = inverse_cbrt(j);
            // J^(-5/3); a volume ratio that is not positive gives NaN, so that the run halts.
            let scale = if j > 0.0 { shear * ((third * third) * (third * third) * third) } else { f64::NAN };
            for i in 0..3 {
                update.deviator[i][l] = scale * (left_cauchy_green[i] - trace * (1.0 / 3.0));
            }
            update.deviator[3][l] = scale * left_cauchy_green[3];
            update.mean[l] = bulk * (j - 1.0);
            update.shear[l] = scale * trace * (1.0 / 3.0);
            // The stiffness along the largest stretch is below bulk J + 4/3 scale tr B; the constant moduli contain 4/3
            // of the initial shear modulus.
            let stiffer = 4.0 / 3.0 * (scale * trace - shear);
            update.bulk[l] =
                bulk * (if j > 1.0 { 2.0 * j - 1.0 } else { 1.0 }) + if stiffer < 0.0 { 0.0 } else { stiffer };
        }
        update.set_total_stress(stress, strain);
    }
}

/// Hyperelastic material with any strain energy of the principal stretches.
#[derive(Clone, Debug)]
pub struct HyperelasticMaterial<E> {
    /// Deviatoric strain energy.
    pub shape: E,
    /// Volumetric part of the strain energy.
    pub volume: VolumetricEnergy,
    /// Initial shear modulus.
    pub shear: f64,
}

impl<E: StrainEnergy> Material for HyperelasticMaterial<E> {
    type State = DeformationState;
    const MODULI_VARY: bool = true;
    const USES_SPIN: bool = true;
    const OF_GRADIENT: bool = true;

    fn initial_state(&self, _start: &BlockStart) -> DeformationState {
        DeformationState::fresh()
    }

    fn initial_bulk(&self) -> f64 {
        self.volume.initial()
    }

    /// Computes the stress from the left Cauchy-Green tensor B. The principal directions are those of B: two in the (r,
    /// z) plane and the hoop direction. Equation (6.12).
    #[inline(always)]
    fn update(
        &self,
        state: &mut DeformationState,
        stress: &mut [Lanes; 4],
        strain: &StrainIncrement,
        update: &mut StressUpdate,
    ) {
        state.advance(strain);
        let (mut volume, mut squares, mut turn) = ([0.0; LANES], [[0.0; LANES]; 3], [[0.0; LANES]; 2]);
        for l in 0..LANES {
            let [rr, rz, zr, zz, hoop] = state.of(l);
            let plane = rr * zz - rz * zr;
            volume[l] = plane * hoop;
            let (a, d, c) = (rr * rr + rz * rz, zr * zr + zz * zz, rr * zr + rz * zz);
            let half = 0.5 * (a - d);
            let radius = (half * half + c * c).sqrt();
            let first = 0.5 * (a + d) + radius;
            (squares[0][l], squares[1][l], squares[2][l]) = (first, plane * plane / first, hoop * hoop);
            let per = if radius > 0.0 { 1.0 / radius } else { 0.0 };
            (turn[0][l], turn[1][l]) = (half * per, c * per);
        }
        for l in 0..LANES {
            let third = inverse_cbrt(volume[l]);
            for list in &mut squares {
                list[l] *= third * third;
            }
        }
        let shape = self.shape.respond(&squares);
        self.set_response(&volume, &shape, &turn, update);
        update.set_total_stress(stress, strain);
    }
}

impl<E: StrainEnergy> HyperelasticMaterial<E> {
    #[inline(always)]
    fn set_response(&self, volume: &Lanes, shape: &PrincipalResponse, turn: &[Lanes; 2], update: &mut StressUpdate) {
        let known = 4.0 / 3.0 * self.shear;
        let (least, softest) = (LEAST_MODULUS * (known + self.volume.initial()), LEAST_MODULUS * self.shear);
        let [pressing, slope] = self.volume.respond(volume);
        for l in 0..LANES {
            let (j, pressing) = (volume[l], pressing[l]);
            // A volume ratio that is not positive gives NaN, so that the run halts.
            let per = if j > 0.0 { 1.0 / j } else { f64::NAN };
            let [one, two, three] = [0, 1, 2].inline_map(|k| per * shape.stress[k][l]);
            let stiffness = [0, 1, 2].inline_map(|k| shape.stiffness[k][l]);
            let (middle, apart) = (0.5 * (one + two), 0.5 * (one - two));
            update.deviator[0][l] = middle + apart * turn[0][l];
            update.deviator[1][l] = middle - apart * turn[0][l];
            update.deviator[2][l] = three;
            update.deviator[3][l] = apart * turn[1][l];
            update.mean[l] = pressing;
            // A wave along a principal direction has the modulus (dtau/de - tau)/J with the Kirchhoff stress tau and
            // the logarithmic stretch e. Tension is ignored, which can only increase the modulus.
            let mut modulus = least;
            for (deviator, stiffness) in [one, two, three].into_iter().zip(stiffness) {
                let stress = deviator + pressing;
                let along = per * stiffness + pressing + j * slope[l] - if stress < 0.0 { stress } else { 0.0 };
                modulus = if along <= modulus { modulus } else { along };
            }
            update.bulk[l] = modulus - known;
            let mean = 0.25 * per * (stiffness[0] + stiffness[1] + stiffness[2]);
            update.shear[l] = if mean > softest { mean } else { softest };
        }
    }
}

carried_state!(DeformationState { gradient });
