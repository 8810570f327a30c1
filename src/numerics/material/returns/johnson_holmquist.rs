//! Brittle materials under impact: the second law of Johnson and Holmquist (1994, "An improved computational constitutive
//! model for brittle materials", AIP Conference Proceedings 309, 981).

use super::compression::{CompressionLaw, energy_of_stress_and_pressure};
use super::law::{ReturnPoint, StressReturn, TrialStress, VolumeChange};
use crate::kernel::hardening::{RateFactor, power};
use crate::kernel::moduli::ElasticModuli;
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
    /// Returns the strength at a pressure, damage and rate factor. Equation (20.23).
    fn strength(&self, pressure: f64, damage: f64, rate: f64) -> f64 {
        let [axial, hydrostatic] = self.elastic_limit;
        let [a, n, largest_intact] = self.intact;
        let [b, m, largest_fractured] = self.fractured;
        let normalised = pressure / hydrostatic;
        let intact = (a * power(normalised + self.tension / hydrostatic, n) * rate).min(largest_intact);
        let fractured = if damage > 0.0 { (b * power(normalised, m) * rate).min(largest_fractured) } else { 0.0 };
        1.5 * (axial - hydrostatic) * (intact - damage * (intact - fractured))
    }

    /// Returns the damage after a plastic strain increment at a pressure. Equation (20.24).
    fn damage_after(&self, damage: f64, strain: f64, pressure: f64) -> f64 {
        let [factor, exponent] = self.fracture;
        let hydrostatic = self.elastic_limit[1];
        let to_fracture = factor * power((pressure + self.tension) / hydrostatic, exponent);
        let to_fracture = to_fracture.max(self.fracture_range[0]).min(self.fracture_range[1]);
        if to_fracture > 0.0 { (damage + strain / to_fracture).min(1.0) } else { 1.0 }
    }

    fn compression(&self, bulking: f64, damage: f64) -> CompressionLaw {
        CompressionLaw { moduli: self.compression, shift: bulking, tension: -self.tension * (1.0 - damage) }
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
        let rate = point.deviatoric_rate();
        let VolumeChange { volume_before, compression } = point.advance_volume(DILATION);
        let (damage_before, bulking_before) = (point.state[DAMAGE], point.state[BULKING]);
        let mut damage = damage_before;
        let mut law = self.compression(point.state[BULKING], damage);
        let mut pressure = law.pressure(compression);
        let trial = TrialStress::of(point.elastic(point.carried, self.moduli()));
        let rate_factor = self.rate.at(rate, 0.0);
        let mut strength = self.strength(pressure, damage, rate_factor);
        let mut mises = trial.mises;
        point.state[RATE] = 0.0;
        if trial.mises > strength {
            let strain = (trial.mises - strength) / (3.0 * self.shear);
            damage = self.damage_after(damage, strain, pressure);
            if compression > 0.0 && self.bulking > 0.0 {
                // The elastic energy that the loss of strength releases, at this pressure.
                let weaker = self.strength(pressure, damage, rate_factor);
                let released = (strength * strength - weaker * weaker) / (6.0 * self.shear);
                let linear = self.compression[0] * compression;
                let square = (linear + law.shift) * (linear + law.shift);
                law.shift = (square + 2.0 * self.bulking * self.compression[0] * released).sqrt() - linear;
            }
            law = self.compression(law.shift, damage);
            pressure = law.pressure(compression);
            strength = self.strength(pressure, damage, rate_factor);
            mises = trial.mises.min(strength);
            // With the loss of strength by the new damage.
            let strain = (trial.mises - mises) / (3.0 * self.shear);
            point.state[STRAIN] += strain;
            point.state[RATE] = if point.dt > 0.0 { strain / point.dt } else { 0.0 };
        }
        point.state[DAMAGE] = damage;
        point.state[FRACTURED] = if damage >= 1.0 { 1.0 } else { 0.0 };
        (point.state[BULKING], point.state[STRENGTH]) = (law.shift, strength);
        point.return_to(&trial, pressure, mises, 0.0);
        let changes = damage != damage_before || law.shift != bulking_before;
        point.dissipate_volumetric_work(ENERGY, law.recoverable_energy(compression), volume_before, changes);
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
