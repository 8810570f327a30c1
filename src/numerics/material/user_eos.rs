//! Adapter from an equation of state in Rust (`revolve::user::EosLaw`) to a pressure law.
#![allow(clippy::needless_range_loop)] // Loops over lanes are written as in the other laws.

use std::fmt::{self, Debug, Formatter};
use std::sync::Arc;

use super::eos::EosLine;
use crate::kernel::lanes::{LANES, Lanes};
use crate::material::volumetric::PressureUpdate;
use crate::routines::{EosLaw, EosResponse};

/// Largest number of secants for the energy at the end of an increment; two or three are usual.
const MOST_SECANTS: usize = 30;
/// Smallest bulk modulus over that of the initial state.
const LEAST: f64 = 1e-6;
/// Energy difference over the square of the sound speed, from which the slope of the pressure is computed.
const DIFFERENCE: f64 = 1e-4;

/// Creates a law of the program.
type NewLaw = fn() -> Arc<dyn EosLaw>;

/// Equations of state in Rust that `TYPE` of `*EOS` selects, after the other types. That of USER is registered by the program
/// that uses the library.
pub const EOS_TYPES: &[(&str, Option<NewLaw>)] = &[("USER", None)];

/// An equation of state in Rust with the constants of the deck.
#[derive(Clone)]
pub struct UserEos {
    law: Arc<dyn EosLaw>,
    constants: Vec<f64>,
    /// Smallest bulk modulus.
    floor: f64,
}

impl Debug for UserEos {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.debug_struct("UserEos").field("constants", &self.constants).finish_non_exhaustive()
    }
}

impl UserEos {
    /// Creates the law from its constants and the initial density, for which the smallest bulk modulus is computed.
    pub fn new(law: Arc<dyn EosLaw>, constants: Vec<f64>, density: f64) -> UserEos {
        let sound_speed = law.respond(&constants, density, 0.0).sound_speed;
        let stiffness = density * sound_speed * sound_speed;
        UserEos { law, constants, floor: if stiffness > 0.0 { LEAST * stiffness } else { f64::MIN_POSITIVE } }
    }

    fn respond(&self, density: f64, energy: f64) -> EosResponse {
        self.law.respond(&self.constants, density, energy)
    }

    /// Returns the pressure line at a specific volume, with the slope at a specific energy. It is exact for laws that are
    /// linear in the energy.
    pub(super) fn line(&self, specific_volume: f64, energy: f64) -> EosLine {
        let density = 1.0 / specific_volume;
        let EosResponse { pressure, sound_speed } = self.respond(density, energy);
        let difference = DIFFERENCE * sound_speed * sound_speed;
        let change = self.respond(density, energy + difference).pressure - pressure;
        let per_energy = if difference > 0.0 { change / difference } else { 0.0 };
        EosLine { cold: pressure - per_energy * energy, per_energy, cold_slope: 0.0, energy_slope: 0.0 }
    }

    /// Returns the isentropic bulk modulus.
    pub(super) fn bulk_modulus(&self, density: f64, energy: f64) -> f64 {
        let EosResponse { sound_speed, .. } = self.respond(density, energy);
        density * sound_speed * sound_speed
    }

    /// Updates pressures and energies of a block. The energy balance of an increment is that of
    /// [`advance`](super::eos::advance), solved for the energy at its end by secants.
    pub(super) fn advance_block(&self, energy: &mut Lanes, update: &mut PressureUpdate) {
        for l in 0..LANES {
            // Unused lanes have no energy, for which the law may have no sound speed.
            if update.middle[l] == 0.0 {
                update.bulk[l] = self.floor;
                continue;
            }
            let density = update.mass[l] / update.volume[l];
            let inverse = 1.0 / update.mass[l];
            let change = update.middle[l] * update.dilation[l];
            let expected = update.viscous[l] * change;
            let known = energy[l] + (0.5 * update.mean[l] * change + update.work[l] + expected) * inverse;
            let balanced = |response: EosResponse| known - 0.5 * response.pressure * change * inverse;
            let mut current = energy[l];
            let mut response = self.respond(density, current);
            let mut next = balanced(response);
            for _ in 0..MOST_SECANTS {
                if next == current {
                    break;
                }
                let (previous, residual) = (current, next - current);
                current = next;
                response = self.respond(density, current);
                let excess = balanced(response) - current;
                // A residual that no longer changes is rounding.
                let slope = (excess - residual) / (current - previous);
                next = if excess.abs() < residual.abs() && slope != 0.0 { current - excess / slope } else { current };
            }
            energy[l] = current;
            let bulk = density * response.sound_speed * response.sound_speed;
            update.bulk[l] = if bulk < self.floor { self.floor } else { bulk };
            update.mean[l] = -response.pressure;
            update.heat[l] = expected;
        }
    }
}
