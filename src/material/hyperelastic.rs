//! Rubber: stress by the whole deformation since the start.
//! Never here: laws by the rate of strain, plasticity.
#![allow(clippy::needless_range_loop)] // Loops over lanes are the form that compilers turn into vectors.

use crate::kernel::lanes::LANES;
use crate::kernel::lanes::Lanes;
use crate::material::strain_energy::{Compression, Principal, StrainEnergy};
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

impl Deformed {
    fn fresh() -> Deformed {
        let (one, zero) = ([1.0; LANES], [0.0; LANES]);
        Deformed { gradient: [one, zero, zero, one, one] }
    }

    /// With h, the gradient of the displacement increment in the middle of the increment, the deformation gradient becomes
    /// (1 + h/2)(1 - h/2)^-1 F: exact, since the middle lies halfway.
    #[inline(always)]
    fn advance(&mut self, ask: &Stretch<'_>, l: usize) -> [f64; 5] {
        let (a, d) = (0.5 * ask.strain[0][l], 0.5 * ask.strain[1][l]);
        let (b, c) = (0.5 * (ask.strain[3][l] + ask.spin[l]), 0.5 * (ask.strain[3][l] - ask.spin[l]));
        let [rr, rz, zr, zz, hoop] = [0, 1, 2, 3, 4].map(|i| self.gradient[i][l]);
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
        for i in 0..5 {
            self.gradient[i][l] = now[i];
        }
        now
    }
}

impl Volumetric for NeoHooke {
    type State = Deformed;
    const EOS: bool = true;
    const TOTAL: bool = true;

    fn fresh(&self) -> Deformed {
        Deformed::fresh()
    }

    #[inline(always)]
    fn squeeze(&self, _state: &mut Deformed, _ask: Squeeze<'_>) {}

    #[inline(always)]
    fn stretch(&self, state: &mut Deformed, ask: Stretch<'_>) {
        let (shear, bulk) = (2.0 * self.c10, 2.0 / self.d1);
        for l in 0..LANES {
            let [rr, rz, zr, zz, hoop] = state.advance(&ask, l);
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
            ask.shear[l] = scale * trace * (1.0 / 3.0);
            // The stiffness along the greatest stretch is below bulk J + 4/3 scale tr B; the constants hold 4/3 of the
            // initial shear modulus.
            let stiffer = 4.0 / 3.0 * (scale * trace - shear);
            ask.bulk[l] =
                bulk * (if j > 1.0 { 2.0 * j - 1.0 } else { 1.0 }) + if stiffer < 0.0 { 0.0 } else { stiffer };
            ask.heat[l] = 0.0;
        }
    }
}

/// Rubber by any energy of the principal stretches.
#[derive(Clone, Debug)]
pub struct Rubber<E> {
    /// Energy of a change of shape.
    pub shape: E,
    /// Energy of a change of volume.
    pub volume: Compression,
    /// Initial shear modulus.
    pub shear: f64,
}

impl<E: StrainEnergy> Volumetric for Rubber<E> {
    type State = Deformed;
    const EOS: bool = true;
    const TOTAL: bool = true;

    fn fresh(&self) -> Deformed {
        Deformed::fresh()
    }

    #[inline(always)]
    fn squeeze(&self, _state: &mut Deformed, _ask: Squeeze<'_>) {}

    /// The principal directions are those of B: two in the plane, which turn, and the hoop.
    #[inline(always)]
    fn stretch(&self, state: &mut Deformed, ask: Stretch<'_>) {
        let known = 4.0 / 3.0 * self.shear;
        let least = LEAST * (known + self.volume.initial());
        for l in 0..LANES {
            let [rr, rz, zr, zz, hoop] = state.advance(&ask, l);
            let plane = rr * zz - rz * zr;
            let j = plane * hoop;
            let (a, d, c) = (rr * rr + rz * rz, zr * zr + zz * zz, rr * zr + rz * zz);
            let half = 0.5 * (a - d);
            let radius = (half * half + c * c).sqrt();
            let first = 0.5 * (a + d) + radius;
            // J^(-2/3); a volume that is not above zero gives not a number, and is found.
            let third = libm::cbrt(j);
            let scale = if j > 0.0 { 1.0 / (third * third) } else { f64::NAN };
            let squares = [scale * first, scale * (plane * plane / first), scale * (hoop * hoop)];
            let Principal { stress, stiffness } = self.shape.respond(squares);
            let [pressing, slope] = self.volume.respond(j);
            let per = 1.0 / j;
            let [one, two, three] = stress.map(|t| per * t);
            let (cosine, sine) = if radius > 0.0 { (half / radius, c / radius) } else { (0.0, 0.0) };
            let (middle, apart) = (0.5 * (one + two), 0.5 * (one - two));
            ask.deviator[0][l] = middle + apart * cosine;
            ask.deviator[1][l] = middle - apart * cosine;
            ask.deviator[2][l] = three;
            ask.deviator[3][l] = apart * sine;
            ask.mean[l] = pressing;
            // Along a principal direction a wave has the modulus (dtau/de - tau)/J, tau the Kirchhoff stress and e the
            // logarithmic stretch; a tension is not counted, which makes it no less.
            let mut modulus = least;
            for i in 0..3 {
                let stress = per * stress[i] + pressing;
                let along = per * stiffness[i] + pressing + j * slope - if stress < 0.0 { stress } else { 0.0 };
                modulus = if along <= modulus { modulus } else { along };
            }
            ask.bulk[l] = modulus - known;
            let mean = 0.25 * per * (stiffness[0] + stiffness[1] + stiffness[2]);
            let softest = LEAST * self.shear;
            ask.shear[l] = if mean > softest { mean } else { softest };
            ask.heat[l] = 0.0;
        }
    }
}

/// The least modulus of a wave, over the initial one: rubber that softens still has an increment.
const LEAST: f64 = 1e-2;

impl Persist for Deformed {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Deformed { gradient } = self;
        gradient.persist(archive);
    }
}
