//! Brittle materials under impact: the second law of Johnson and Holmquist (1994, "An improved computational constitutive
//! model for brittle materials", AIP Conference Proceedings 309, 981).

use super::compression::{CompressionLaw, energy_of_stress_and_pressure};
use super::law::{ReturnPoint, StressReturn};
use crate::kernel::hardening::RateFactor;
use crate::kernel::moduli::ElasticModuli;
use crate::kernel::transcendental::power_of;
use crate::variables::{Variable, VariableComponent};

/// Constants of the law, in the order of the user material `ABQ_JH2`. Strengths are normalised by the von Mises stress at the
/// Hugoniot elastic limit, pressures by the pressure there.
#[derive(Clone, Debug)]
pub struct JohnsonHolmquist {
    /// Shear modulus, stress.
    pub shear: f64,
    /// Strength of the intact material: A, exponent N and largest value.
    pub intact: [f64; 3],
    /// Strength of the fractured material: B, exponent M and largest value.
    pub fractured: [f64; 3],
    /// Rate factor, 1 + C ln(rate/reference).
    pub rate: RateFactor,
    /// Largest hydrostatic tension T of the intact material, stress.
    pub tension: f64,
    /// Axial stress and pressure at the Hugoniot elastic limit, stress.
    pub elastic_limit: [f64; 2],
    /// Fraction beta of the lost elastic energy that becomes pressure.
    pub bulking: f64,
    /// Plastic strain to fracture D1 (P* + T*)^D2: D1 and D2.
    pub fracture: [f64; 2],
    /// Smallest and largest plastic strain to fracture.
    pub fracture_range: [f64; 2],
    /// Moduli K1, K2, K3 of the pressure, stress.
    pub compression: [f64; 3],
    /// Deletion: at a plastic strain if positive, at a pressure if negative, none if zero.
    pub deletion: f64,
}

/// Indices of the state; up to [`STATUS`] they are the state variables SDV1 to SDV8 of the user material.
const STRAIN: usize = 0;
const RATE: usize = 1;
const FRACTURED: usize = 2;
const DAMAGE: usize = 3;
const BULKING: usize = 4;
const STRENGTH: usize = 5;
/// Logarithm of the volume ratio.
const DILATION: usize = 6;
const STATUS: usize = 7;
/// Recoverable energy of the pressure per initial volume.
const ENERGY: usize = 8;

impl JohnsonHolmquist {
    /// Returns the strengths of the intact and of the fractured material at a pressure and a rate factor; those without share
    /// in the strength for damages in a range are zero. Equation (20.23).
    fn strengths(&self, pressure: f64, [least, most]: [f64; 2], rate: f64) -> JohnsonHolmquistStrengths {
        let [axial, hydrostatic] = self.elastic_limit;
        let [a, n, largest_intact] = self.intact;
        let [b, m, largest_fractured] = self.fractured;
        let scale = 1.5 * (axial - hydrostatic);
        let strength = |factor: f64, pressure: f64, exponent: f64, largest: f64| {
            scale * (factor * power_of(pressure / hydrostatic, exponent) * rate).min(largest)
        };
        let intact = if least < 1.0 { strength(a, pressure + self.tension, n, largest_intact) } else { 0.0 };
        let fractured = if most > 0.0 { strength(b, pressure, m, largest_fractured) } else { 0.0 };
        JohnsonHolmquistStrengths { intact, fractured }
    }

    /// Returns the damage after a plastic strain increment at a pressure. Equation (20.24).
    fn damage_after(&self, damage: f64, strain: f64, pressure: f64) -> f64 {
        let [factor, exponent] = self.fracture;
        let hydrostatic = self.elastic_limit[1];
        let normalised = (pressure + self.tension) / hydrostatic;
        let to_fracture = factor * if exponent == 1.0 { normalised.max(0.0) } else { power_of(normalised, exponent) };
        let to_fracture = to_fracture.max(self.fracture_range[0]).min(self.fracture_range[1]);
        if to_fracture > 0.0 { (damage + strain / to_fracture).min(1.0) } else { 1.0 }
    }

    fn compression(&self, bulking: f64, damage: f64) -> CompressionLaw {
        CompressionLaw { moduli: self.compression, shift: bulking, tension: -self.tension * (1.0 - damage) }
    }
}

/// Strengths of the intact and the fractured material at a pressure, stress.
#[derive(Clone, Copy)]
struct JohnsonHolmquistStrengths {
    intact: f64,
    fractured: f64,
}

impl JohnsonHolmquistStrengths {
    /// Returns the strength at a damage.
    fn at(self, damage: f64) -> f64 {
        self.intact - damage * (self.intact - self.fractured)
    }
}

impl StressReturn for JohnsonHolmquist {
    fn describe(&self) -> String {
        "Johnson-Holmquist 2".into()
    }

    fn moduli(&self) -> ElasticModuli {
        ElasticModuli { bulk: self.compression[0], shear: self.shear }
    }

    fn initial_state(&self) -> Vec<f64> {
        let mut state = vec![0.0; ENERGY + 1];
        state[STATUS] = 1.0;
        state
    }

    fn output(&self, part: VariableComponent) -> Option<usize> {
        match part.variable {
            Variable::PlasticStrain => Some(STRAIN),
            Variable::Damage => Some(DAMAGE),
            Variable::State => Some(part.component).filter(|component| *component <= STATUS),
            _ => None,
        }
    }

    fn holds_pressure(&self) -> bool {
        true
    }

    fn deletes(&self) -> bool {
        self.deletion != 0.0
    }

    fn recoverable_energy(&self, stress: [f64; 4], state: &[f64]) -> f64 {
        energy_of_stress_and_pressure(stress, self.shear, state[ENERGY], state[DILATION])
    }

    /// Equation (20.25).
    fn update(&self, point: &mut ReturnPoint<'_>) {
        let compression = point.advance_volume(DILATION);
        let (damage_before, bulking_before) = (point.state[DAMAGE], point.state[BULKING]);
        let mut damage = damage_before;
        let mut law = self.compression(point.state[BULKING], damage);
        let mut pressure = law.pressure(compression);
        let trial_mises = point.trial.mises;
        let rate_factor = if self.rate.is_constant() { 1.0 } else { self.rate.at(point.deviatoric_rate(), 0.0) };
        let mut strengths = self.strengths(pressure, [damage, damage], rate_factor);
        let mut strength = strengths.at(damage);
        let mut mises = trial_mises;
        point.state[RATE] = 0.0;
        if trial_mises > strength {
            let strain = (trial_mises - strength) / (3.0 * self.shear);
            damage = self.damage_after(damage, strain, pressure);
            if compression > 0.0 && self.bulking > 0.0 && damage > damage_before {
                // The elastic energy that the loss of strength releases, at this pressure.
                if damage_before == 0.0 {
                    strengths = self.strengths(pressure, [0.0, damage], rate_factor);
                }
                let weaker = strengths.at(damage);
                let released = (strength * strength - weaker * weaker) / (6.0 * self.shear);
                let linear = self.compression[0] * compression;
                let square = (linear + law.shift) * (linear + law.shift);
                law.shift = (square + 2.0 * self.bulking * self.compression[0] * released).sqrt() - linear;
            }
            if damage > damage_before {
                law = self.compression(law.shift, damage);
                pressure = law.pressure(compression);
                strength = self.strengths(pressure, [damage, damage], rate_factor).at(damage);
            }
            mises = trial_mises.min(strength);
            // With the loss of strength by the new damage.
            let strain = (trial_mises - mises) / (3.0 * self.shear);
            point.state[STRAIN] += strain;
            point.state[RATE] = if point.dt > 0.0 { strain / point.dt } else { 0.0 };
        }
        point.state[DAMAGE] = damage;
        point.state[FRACTURED] = if damage >= 1.0 { 1.0 } else { 0.0 };
        (point.state[BULKING], point.state[STRENGTH]) = (law.shift, strength);
        point.return_to(pressure, mises, 0.0);
        let changes = damage != damage_before || law.shift != bulking_before;
        let energy = law.recoverable_energy(compression, -point.state[DILATION]);
        point.dissipate_volumetric_work(ENERGY, energy, compression, changes);
        point.moduli.bulk = law.bulk_modulus(compression);
        let is_deleted = if self.deletion > 0.0 {
            point.state[STRAIN] >= self.deletion
        } else {
            self.deletion < 0.0 && pressure <= self.deletion
        };
        if is_deleted {
            (point.deleted, point.state[STATUS]) = (true, 0.0);
        }
    }
}
