//! Rubber: stress by the whole deformation since the start.
//! Never here: laws by the rate of strain, plasticity.
#![allow(clippy::needless_range_loop)] // Loops over lanes are the form that compilers turn into vectors.

use crate::kernel::lanes::LANES;
use crate::kernel::lanes::Lanes;
use crate::material::volumetric::{Squeeze, Stretch, Volumetric};
use crate::state::archive::{Archive, Persist};

/// Neo-Hooke: U = C10 (J^(-2/3) tr B - 3) + (J - 1)^2 / D1, so the Cauchy stress is 2 C10 J^(-5/3) dev B + 2 (J - 1)/D1
/// (ABAQUS Theory Guide, "Hyperelastic material behavior").
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeoHooke {
    /// C10, half the initial shear modulus.
    pub c10: f64,
    /// D1, two over the initial bulk modulus.
    pub d1: f64,
}

/// What a block of rubber keeps.
#[derive(Clone, Debug)]
pub struct Deformed {
    /// Deformation gradient: rr, rz, zr, zz, and the hoop stretch r/R.
    gradient: [Lanes; 5],
}

impl Volumetric for NeoHooke {
    type State = Deformed;
    const EOS: bool = true;
    const TOTAL: bool = true;

    fn fresh(&self) -> Deformed {
        let (one, zero) = ([1.0; LANES], [0.0; LANES]);
        Deformed { gradient: [one, zero, zero, one, one] }
    }

    #[inline(always)]
    fn squeeze(&self, _state: &mut Deformed, _ask: Squeeze<'_>) {}

    /// With h, the gradient of the displacement increment in the middle of the increment, the deformation gradient becomes
    /// (1 + h/2)(1 - h/2)^-1 F: exact, since the middle lies halfway.
    #[inline(always)]
    fn stretch(&self, state: &mut Deformed, ask: Stretch<'_>) {
        let (shear, bulk) = (2.0 * self.c10, 2.0 / self.d1);
        for l in 0..LANES {
            let (a, d) = (0.5 * ask.strain[0][l], 0.5 * ask.strain[1][l]);
            let (b, c) = (0.5 * (ask.strain[3][l] + ask.spin[l]), 0.5 * (ask.strain[3][l] - ask.spin[l]));
            let [rr, rz, zr, zz, hoop] = [0, 1, 2, 3, 4].map(|i| state.gradient[i][l]);
            // (1 - h/2)^-1 F, then (1 + h/2) times it.
            let per = 1.0 / ((1.0 - a) * (1.0 - d) - b * c);
            let (m_rr, m_rz) = (per * ((1.0 - d) * rr + b * zr), per * ((1.0 - d) * rz + b * zz));
            let (m_zr, m_zz) = (per * (c * rr + (1.0 - a) * zr), per * (c * rz + (1.0 - a) * zz));
            let now = [
                (1.0 + a) * m_rr + b * m_zr,
                (1.0 + a) * m_rz + b * m_zz,
                c * m_rr + (1.0 + d) * m_zr,
                c * m_rz + (1.0 + d) * m_zz,
                hoop * (1.0 + 0.5 * ask.strain[2][l]) / (1.0 - 0.5 * ask.strain[2][l]),
            ];
            let [rr, rz, zr, zz, hoop] = now;
            for i in 0..5 {
                state.gradient[i][l] = now[i];
            }
            let j = (rr * zz - rz * zr) * hoop;
            let left = [rr * rr + rz * rz, zr * zr + zz * zz, hoop * hoop, rr * zr + rz * zz];
            let trace = left[0] + left[1] + left[2];
            // J^(-5/3); a volume that is not above zero gives not a number, and is found.
            let third = libm::cbrt(j);
            let scale = if j > 0.0 { shear / (j * third * third) } else { f64::NAN };
            for i in 0..3 {
                ask.deviator[i][l] = scale * (left[i] - trace * (1.0 / 3.0));
            }
            ask.deviator[3][l] = scale * left[3];
            ask.mean[l] = bulk * (j - 1.0);
            // The stiffness along the greatest stretch is below bulk J + 4/3 scale tr B; the constants hold 4/3 of the
            // initial shear modulus.
            let stiffer = 4.0 / 3.0 * (scale * trace - shear);
            ask.bulk[l] =
                bulk * (if j > 1.0 { 2.0 * j - 1.0 } else { 1.0 }) + if stiffer < 0.0 { 0.0 } else { stiffer };
            ask.heat[l] = 0.0;
        }
    }
}

impl Persist for Deformed {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Deformed { gradient } = self;
        gradient.persist(archive);
    }
}
