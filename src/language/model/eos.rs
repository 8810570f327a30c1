//! Equations of state: `*EOS`, `*DETONATION POINT`, `*PHYSICAL CONSTANTS`.

use super::context::Context;
use super::types::{EosKind, EquationOfState};
use crate::deck::table::materials as cards;
use crate::deck::{Card, Diagnostic};

pub(super) fn read_eos(context: &mut Context<'_>, card: &Card) {
    let cards::Eos { kind } = card.values();
    let kind = match kind {
        0 => Some(EosKind::IdealGas(card.read_lines())),
        1 => Some(EosKind::UsUp(card.read_lines())),
        2 => tabulated(context, card),
        _ => jwl(context, card),
    };
    if let Some(kind) = kind {
        context.last_material().eos = Some(EquationOfState { kind, span: card.span });
    }
}

/// Reads rows of f1, f2 and volumetric strain, from tension to compression.
fn tabulated(context: &mut Context<'_>, card: &Card) -> Option<EosKind> {
    context.first_line(card)?;
    let rows: Vec<[f64; 3]> = card.read_lines();
    if let Some(line) = (1..rows.len()).find(|&i| rows[i - 1][2] <= rows[i][2]) {
        let message = "the volumetric strain must decrease from row to row, from tension to compression";
        return context.refuse_value(card.lines[line].span, message);
    }
    if !stiffens(&rows) {
        return context
            .refuse_value(card.span, "at least two rows are required, and f1 must increase with compression");
    }
    Some(EosKind::Tabular(rows))
}

/// Reads a JWL explosive. A very large energy is likely given per volume instead of per mass.
fn jwl(context: &mut Context<'_>, card: &Card) -> Option<EosKind> {
    let line = context.first_line(card)?;
    let values: [f64; 8] = card.read_lines();
    let [speed, .., energy, _] = values;
    let square = speed * speed;
    if energy > square {
        let message = format!(
            "the detonation energy per mass, {energy:e}, is above the square of the detonation wave speed, \
             {square:e}; it is used as given"
        );
        let diagnostic = Diagnostic::warning("M169", message).at(line.span, "seventh value");
        context.diagnostics.push(diagnostic.help("if it is an energy per volume, divide it by the density"));
    }
    Some(EosKind::Jwl(values))
}

/// Reads detonation points: coordinates and, in the fourth field, the delay time.
pub(super) fn read_detonation_points(context: &mut Context<'_>, card: &Card) {
    let cards::DetonationPoint { points } = card.values();
    if context.first_line(card).is_some() {
        context.last_material().detonation = points.iter().map(|p| [p[0], p[1], p[3]]).collect();
    }
}

/// Reads absolute zero; the other physical constants are not used.
pub(super) fn read_physical_constants(context: &mut Context<'_>, card: &Card) {
    let cards::PhysicalConstants { absolute_zero } = card.values();
    context.model.settings.absolute_zero = absolute_zero.unwrap_or(0.0);
}

/// Returns whether the pressure increases with compression, for rows in descending order of volumetric strain.
pub(super) fn stiffens(rows: &[[f64; 3]]) -> bool {
    rows.len() > 1 && rows.windows(2).all(|w| w[1][0] >= w[0][0]) && rows[rows.len() - 1][0] > rows[0][0]
}
