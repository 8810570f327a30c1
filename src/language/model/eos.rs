//! Equations of state: `*EOS`, `*DETONATION POINT`, `*PHYSICAL CONSTANTS`.

use super::context::Context;
use super::faults::{ValueCheck, require, require_line};
use super::types::{EosKind, EquationOfState, MaterialDefinition};
use super::user_material::constants;
use crate::deck::table::materials as cards;
use crate::deck::{Card, Diagnostic};
use crate::kernel::moduli::ElasticModuli;
use crate::material::user_eos::EOS_TYPES;

pub fn read_eos(context: &mut Context<'_>, card: &Card) {
    let cards::Eos { kind } = card.values();
    let kind = match kind {
        0 => EosKind::IdealGas(card.read_lines()),
        1 => EosKind::UsUp(card.read_lines()),
        _ if context.first_line(card).is_none() => return,
        2 => EosKind::Tabular(card.read_lines()),
        3 => EosKind::Jwl(card.read_lines()),
        law => match constants(context, card, "PROPERTIES") {
            Some(list) => EosKind::Law(law - 4, list),
            None => return,
        },
    };
    if let EosKind::Jwl([speed, .., energy, _]) = kind {
        warn_of_large_energy(context, card, speed * speed, energy);
    }
    if context.accepts(card, kind.check()) {
        context.last_material().eos = Some(EquationOfState { kind, span: card.span });
    }
}

/// Warns of a detonation energy above the square of the wave speed, which is likely an energy per volume.
fn warn_of_large_energy(context: &mut Context<'_>, card: &Card, square: f64, energy: f64) {
    if energy > square {
        let message = format!(
            "the detonation energy per mass, {energy:e}, is above the square of the detonation wave speed, \
             {square:e}; it is used as given"
        );
        let diagnostic = Diagnostic::warning("M169", message).at(card.lines[0].span, "seventh value");
        context.diagnostics.push(diagnostic.help("if it is an energy per volume, divide it by the density"));
    }
}

impl MaterialDefinition {
    /// Returns the bulk modulus of the equation of state at the initial density: the density times the slope of the
    /// pressure over the density. That of an ideal gas depends on the absolute temperature. That of an explosive is the
    /// larger of the bulk modulus before detonation and that at the detonation front, ρ D² γ/(γ + 1) with γ = 3
    /// (C. L. Mader, Numerical Modeling of Explosives and Propellants, 2008, chapter 2). `None` without an equation of
    /// state, for a law in Rust that is registered, or if the material has no stiffness.
    pub fn bulk_modulus(&self, absolute_temperature: Option<f64>) -> Option<f64> {
        let density = self.density?;
        let modulus = match &self.eos.as_ref()?.kind {
            EosKind::UsUp([c, ..]) => {
                let speed = self.compaction.map_or(*c, |compaction| compaction.speed);
                density * speed * speed
            }
            EosKind::Tabular(rows) => slope_at_reference(rows),
            EosKind::IdealGas([gas_constant, _]) => {
                let &[[specific_heat, _]] = self.thermal.specific_heat.as_deref()? else { return None };
                (1.0 + gas_constant / specific_heat) * density * gas_constant * absolute_temperature?
            }
            EosKind::Law(row, constants) => {
                let sound_speed = EOS_TYPES[*row].1?().respond(constants, density, 0.0).sound_speed;
                density * sound_speed * sound_speed
            }
            EosKind::Jwl([speed, .., before]) => before.max(0.75 * density * speed * speed),
        };
        (modulus > 0.0).then_some(modulus)
    }

    /// Returns the small-strain moduli at an absolute temperature, on which those of an ideal gas depend; `None` if a user
    /// subroutine defines them.
    pub fn small_strain_moduli(&self, absolute_temperature: Option<f64>) -> Option<ElasticModuli> {
        if let Some([modulus, ratio]) = self.elastic.filter(|_| self.eos.is_none()) {
            return Some(ElasticModuli::from_young(modulus, ratio));
        }
        if let Some(rubber) = &self.hyperelastic {
            let shear = rubber.shape.shear();
            let compressibility = rubber.compressibility.first().filter(|d| **d > 0.0);
            // Without D1 Poisson's ratio is 0.475 (ABAQUS Analysis User's Guide, "Hyperelastic behavior",
            // "Compressibility").
            let bulk = compressibility.map_or(shear * 2.0 * 1.475 / (3.0 * 0.05), |d| 2.0 / d);
            return Some(ElasticModuli { bulk, shear });
        }
        if let Some((constants, _)) = &self.strength.johnson_holmquist {
            return Some(ElasticModuli { bulk: *constants.get(20)?, shear: *constants.get(1)? });
        }
        if let Some((card, _)) = &self.strength.holmquist_johnson_cook {
            let [[shear, ..], [_, _, pressure, compression, ..], ..] = card.rows[..] else { return None };
            return Some(ElasticModuli { bulk: pressure / compression, shear });
        }
        let bulk = self.bulk_modulus(absolute_temperature)?;
        Some(ElasticModuli { bulk, shear: self.shear_modulus.unwrap_or(0.0) })
    }
}

/// Returns the bulk modulus of a tabulated equation of state at zero volumetric strain and energy: minus the slope of the
/// first function, there or in the stiffest interval if the table is flat there.
fn slope_at_reference(rows: &[[f64; 3]]) -> f64 {
    let slope = |pair: &[[f64; 3]]| (pair[1][0] - pair[0][0]) / (pair[0][2] - pair[1][2]);
    let around = rows.windows(2).filter(|pair| pair[0][2] >= 0.0 && pair[1][2] <= 0.0).map(slope).fold(0.0, f64::max);
    if around > 0.0 { around } else { rows.windows(2).map(slope).fold(0.0, f64::max) }
}

impl EosKind {
    /// Checks rows of f1, f2 and volumetric strain, from tension to compression.
    pub fn check(&self) -> ValueCheck {
        let EosKind::Tabular(rows) = self else { return Ok(()) };
        if let Some(row) = (1..rows.len()).find(|&i| rows[i - 1][2] <= rows[i][2]) {
            let message = "the volumetric strain must decrease from row to row, from tension to compression";
            return require_line(row, false, message);
        }
        let stiffens = rows.windows(2).all(|w| w[1][0] >= w[0][0]);
        let stiffens = stiffens && rows.first().zip(rows.last()).is_some_and(|(first, last)| last[0] > first[0]);
        require(stiffens, "at least two rows are required, and f1 must increase with compression")
    }
}

/// Reads detonation points: coordinates and, in the fourth field, the delay time.
pub fn read_detonation_points(context: &mut Context<'_>, card: &Card) {
    let cards::DetonationPoint { points } = card.values();
    if context.first_line(card).is_some() {
        context.last_material().detonation = points.iter().map(|p| [p[0], p[1], p[3]]).collect();
    }
}

/// Reads absolute zero; the other physical constants are not used.
pub fn read_physical_constants(context: &mut Context<'_>, card: &Card) {
    let cards::PhysicalConstants { absolute_zero } = card.values();
    context.model.settings.absolute_zero = absolute_zero.unwrap_or(0.0);
}
