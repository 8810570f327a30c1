//! Equations of state: `*EOS`, `*DETONATION POINT`, `*PHYSICAL CONSTANTS`.

use super::context::Context;
use super::faults::{ValueCheck, require, require_line};
use super::types::{EosKind, EquationOfState};
use crate::deck::table::materials as cards;
use crate::deck::{Card, Diagnostic};

pub fn read_eos(context: &mut Context<'_>, card: &Card) {
    let cards::Eos { kind } = card.values();
    let kind = match kind {
        0 => EosKind::IdealGas(card.read_lines()),
        1 => EosKind::UsUp(card.read_lines()),
        _ if context.first_line(card).is_none() => return,
        2 => EosKind::Tabular(card.read_lines()),
        _ => EosKind::Jwl(card.read_lines()),
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
