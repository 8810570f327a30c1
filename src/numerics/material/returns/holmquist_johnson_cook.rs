//! Concrete under large strains, high rates and pressures: Holmquist, Johnson and Cook (1993, "A computational constitutive
//! model for concrete subjected to large strains, high strain rates, and high pressures", 14th International Symposium on
//! Ballistics, 591).

use super::compression::{CompressionLaw, energy_of_stress_and_pressure};
use super::law::{ReturnPoint, StressReturn};
use super::root::bracketed_root;
use crate::kernel::hardening::RateFactor;
use crate::kernel::moduli::ElasticModuli;
use crate::kernel::transcendental::power_of;
use crate::variables::{Variable, VariableComponent};

/// Constants of the law.
#[derive(Clone, Debug)]
pub struct HolmquistJohnsonCook {
    /// Shear modulus, stress.
    pub shear: f64,
    /// Cohesive strength A, pressure factor B and exponent N, over the compressive strength.
    pub strength: [f64; 3],
    /// Largest strength over the compressive strength, SMAX.
    pub largest_strength: f64,
    /// Quasi-static uniaxial compressive strength fc, stress.
    pub compressive: f64,
    /// Rate factor, 1 + C ln(rate/reference).
    pub rate: RateFactor,
    /// Largest hydrostatic tension T, stress.
    pub tension: f64,
    /// Plastic strain to fracture D1 (P* + T*)^D2: D1, D2 and its smallest value EFMIN.
    pub fracture: [f64; 3],
    /// Pressure PC and compression UC at which compaction begins.
    pub crush: [f64; 2],
    /// Pressure PL at which compaction ends, and the compression UL of the solid without pores at pressure zero.
    pub lock: [f64; 2],
    /// Moduli K1, K2, K3 of the compacted material, stress.
    pub compression: [f64; 3],
    /// Equivalent plastic strain at which the element is deleted; 0 for none.
    pub deletion: f64,
    /// Compression at which compaction ends, from [`HolmquistJohnsonCook::compacted`].
    pub compacted: f64,
}

const STRAIN: usize = 0;
const DAMAGE: usize = 1;
/// Largest compression so far.
const LARGEST: usize = 2;
/// Plastic compaction.
const COMPACTION: usize = 3;
/// Logarithm of the volume ratio.
const DILATION: usize = 4;
/// Recoverable energy of the pressure per initial volume.
const ENERGY: usize = 5;

impl HolmquistJohnsonCook {
    /// Returns the compression at which the pressure of the compacted material equals PL; `None` if it never does.
    pub fn compacted(lock: [f64; 2], moduli: [f64; 3]) -> Option<f64> {
        let [pressure, compression] = lock;
        let law = CompressionLaw { moduli, shift: 0.0, tension: f64::NEG_INFINITY };
        let mut upper = pressure / moduli[0];
        for _ in 0..40 {
            if law.pressure(upper) >= pressure {
                let solid = bracketed_root(0.0, upper, 1e-14 * pressure, |x| pressure - law.pressure(x));
                return Some(compression + (1.0 + compression) * solid);
            }
            upper *= 1.5;
        }
        None
    }

    /// Returns the pressure law on the path of unloading from the largest compression, the compression that it
    /// takes as argument over that of the element, and the plastic compaction. Equation (20.26).
    fn unloading(&self, largest: f64, damage: f64) -> Unloading {
        let ([crush_pressure, crush], [lock_pressure, lock]) = (self.crush, self.lock);
        let initial = crush_pressure / crush;
        let tension = -self.tension * (1.0 - damage);
        if largest <= crush {
            let law = CompressionLaw { moduli: [initial, 0.0, 0.0], shift: 0.0, tension };
            return Unloading { law, solid: 0.0, compaction: 0.0 };
        }
        if largest < self.compacted {
            let crushed = (largest - crush) / (self.compacted - crush);
            let slope = (1.0 - crushed) * initial + crushed * self.compression[0];
            let compaction = largest - (crush_pressure + crushed * (lock_pressure - crush_pressure)) / slope;
            let law = CompressionLaw { moduli: [slope, 0.0, 0.0], shift: -slope * compaction, tension };
            return Unloading { law, solid: 0.0, compaction };
        }
        let compaction = self.compacted - lock_pressure / self.compression[0];
        let law = CompressionLaw { moduli: self.compression, shift: 0.0, tension };
        Unloading { law, solid: lock, compaction }
    }

    /// Returns the part of the normalised strength that a pressure adds to the cohesion. Equation (20.27).
    fn pressure_strength(&self, pressure: f64) -> f64 {
        let [a, b, n] = self.strength;
        if pressure < 0.0 { a * pressure / self.tension } else { b * power_of(pressure / self.compressive, n) }
    }

    /// Returns the strength with the part of the pressure, at a damage and a rate factor. Equation (20.27).
    fn yield_strength(&self, of_pressure: f64, damage: f64, rate: f64) -> f64 {
        let normalised = (self.strength[0] * (1.0 - damage) + of_pressure).max(0.0) * rate;
        self.compressive * if of_pressure < 0.0 { normalised } else { normalised.min(self.largest_strength) }
    }
}

/// Path of unloading.
struct Unloading {
    law: CompressionLaw,
    /// Compression from which that of the law counts: (mu - solid)/(1 + solid).
    solid: f64,
    /// Plastic compaction.
    compaction: f64,
}

impl StressReturn for HolmquistJohnsonCook {
    fn describe(&self) -> String {
        "Holmquist-Johnson-Cook concrete".into()
    }

    fn moduli(&self) -> ElasticModuli {
        ElasticModuli { bulk: self.crush[0] / self.crush[1], shear: self.shear }
    }

    fn initial_state(&self) -> Vec<f64> {
        vec![0.0; ENERGY + 1]
    }

    fn output(&self, part: VariableComponent) -> Option<usize> {
        match part.variable {
            Variable::PlasticStrain => Some(STRAIN),
            Variable::Damage => Some(DAMAGE),
            Variable::PlasticCompaction => Some(COMPACTION),
            _ => None,
        }
    }

    fn holds_pressure(&self) -> bool {
        true
    }

    fn deletes(&self) -> bool {
        self.deletion > 0.0
    }

    fn recoverable_energy(&self, stress: [f64; 4], state: &[f64]) -> f64 {
        energy_of_stress_and_pressure(stress, self.shear, state[ENERGY], state[DILATION])
    }

    /// Equation (20.28).
    fn update(&self, point: &mut ReturnPoint<'_>) {
        let rate = point.deviatoric_rate();
        let compression = point.advance_volume(DILATION);
        let largest = compression.max(point.state[LARGEST]);
        let damage = point.state[DAMAGE];
        let Unloading { law, solid, compaction } = self.unloading(largest, damage);
        let counted = (compression - solid) / (1.0 + solid);
        let pressure = law.pressure(counted);
        let trial_mises = point.trial.mises;
        let rate_factor = self.rate.at(rate, 0.0);
        let of_pressure = self.pressure_strength(pressure);
        let mut mises = trial_mises.min(self.yield_strength(of_pressure, damage, rate_factor));
        let strain = (trial_mises - mises) / (3.0 * self.shear);
        let [factor, exponent, smallest] = self.fracture;
        let inelastic = strain + (compaction - point.state[COMPACTION]).max(0.0);
        if inelastic > 0.0 {
            let normalised = (pressure + self.tension) / self.compressive;
            let to_fracture = factor * if exponent == 1.0 { normalised } else { power_of(normalised, exponent) };
            point.state[DAMAGE] = (damage + inelastic / to_fracture.max(smallest)).min(1.0);
            // The loss of strength by the new damage is plastic flow too, but damages no further.
            mises = mises.min(self.yield_strength(of_pressure, point.state[DAMAGE], rate_factor));
        }
        point.state[STRAIN] += (trial_mises - mises) / (3.0 * self.shear);
        let changes = inelastic > 0.0 || compaction != point.state[COMPACTION];
        (point.state[LARGEST], point.state[COMPACTION]) = (largest, compaction);
        point.return_to(pressure, mises, 0.0);
        // The compression of the solid without pores.
        let logarithm = if solid == 0.0 { -point.state[DILATION] } else { libm::log1p(counted) };
        let energy = law.recoverable_energy(counted, logarithm) / (1.0 + solid);
        point.dissipate_volumetric_work(ENERGY, energy, compression, changes);
        point.moduli.bulk = law.bulk_modulus(counted);
        point.deleted = self.deletion > 0.0 && point.state[STRAIN] >= self.deletion;
    }
}
