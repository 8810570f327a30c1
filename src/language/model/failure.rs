//! Material failure: `*SHEAR FAILURE`, `*TENSILE FAILURE`, `*DAMAGE INITIATION`, `*DAMAGE EVOLUTION`.

use super::context::Context;
use super::families::MaterialReader;
use super::types::{DamageEvolution, FailureCriterion, StrainAtFailure, TensileFailure};
use super::{cohesive, cohesive_contact};
use crate::deck::Card;
use crate::deck::table::materials as cards;
use crate::kernel::levels::NestedTable;

/// Index of the value of `CRITERION` in the keyword table.
const DUCTILE: usize = 1;

pub(super) fn read_shear_failure(context: &mut Context<'_>, card: &Card) {
    let cards::ShearFailure { johnson_cook } = card.values();
    let Some(line) = context.first_line(card) else { return };
    let strain = if johnson_cook {
        Some(StrainAtFailure::JohnsonCook(card.read_lines(), None))
    } else if card.lines.len() > 1 || (1..4).any(|i| line.field(i).is_some()) {
        strains(context, card).map(StrainAtFailure::Shear)
    } else {
        let [strain]: [f64; 1] = card.read_lines();
        Some(StrainAtFailure::Constant(strain))
    };
    criterion(context, card, strain, DamageEvolution::Sudden);
}

fn criterion(context: &mut Context<'_>, card: &Card, strain: Option<StrainAtFailure>, evolution: DamageEvolution) {
    if let Some(strain) = strain {
        context.last_material().failures.push(FailureCriterion { strain, evolution, span: card.span });
    }
}

/// Reads rows of a strain and three variables, the first of which varies fastest.
fn strains(context: &mut Context<'_>, card: &Card) -> Option<Vec<[f64; 4]>> {
    let line = context.first_line(card)?;
    let rows: Vec<[f64; 4]> = card.read_lines();
    if NestedTable::new(&rows).is_none() {
        let message = "the rows must be in ascending order, with the first variable varying fastest";
        return context.refuse_value(line.span, message);
    }
    Some(rows)
}

/// Reads d1 to d5, melting temperature, transition temperature and reference strain rate.
fn johnson_cook(context: &mut Context<'_>, card: &Card) -> Option<StrainAtFailure> {
    let line = context.first_line(card)?;
    let [d1, d2, d3, d4, d5, melt, transition, rate]: [f64; 8] = card.read_lines();
    if d4 != 0.0 && rate <= 0.0 || d5 != 0.0 && melt <= transition {
        let message = "d4 requires a positive reference strain rate, d5 a melting \
             temperature above the transition temperature";
        return context.refuse_value(line.span, message);
    }
    Some(StrainAtFailure::JohnsonCook([d1, d2, d3, d4, d5], Some([melt, transition, rate])))
}

/// Reads `*DAMAGE INITIATION` of a material or of a surface interaction.
pub(super) fn read_damage_initiation(context: &mut Context<'_>, materials: &mut MaterialReader, card: &Card) {
    if materials.in_interaction {
        return cohesive_contact::read_cohesive_initiation(context, card);
    }
    let cards::DamageInitiation { criterion: kind } = card.values();
    let cohesive = cohesive::interface_initiation(context, card, kind);
    let material = context.last_material();
    if material.interface.initiation.is_some() && (!cohesive || !material.failures.is_empty()) {
        let message = "a material has criteria either of solids or of cohesive elements";
        return context.unsupported(card.span, message, "define two materials");
    }
    if cohesive {
        return;
    }
    let strain = if kind == DUCTILE {
        strains(context, card).map(StrainAtFailure::Ductile)
    } else {
        johnson_cook(context, card)
    };
    criterion(context, card, strain, DamageEvolution::Absent);
}

/// Reads `*DAMAGE EVOLUTION` of a material or of a surface interaction.
pub(super) fn read_damage_evolution(context: &mut Context<'_>, materials: &mut MaterialReader, card: &Card) {
    if materials.in_interaction {
        return cohesive_contact::read_cohesive_evolution(context, card);
    }
    if context.last_material().interface.initiation.is_some() {
        return cohesive::interface_evolution(context, card);
    }
    if !cohesive::is_bulk_evolution(context, card) {
        return;
    }
    let cards::DamageEvolution { energy, rows, .. } = card.values();
    let value = rows.first().map_or(f64::NAN, |row| row[0]);
    let evolution = if energy { DamageEvolution::Energy(value) } else { DamageEvolution::Displacement(value) };
    let is_refused = context.missing.has_card("DAMAGE INITIATION");
    match context.last_material().failures.last_mut() {
        Some(last) if last.evolution == DamageEvolution::Absent => last.evolution = evolution,
        _ if is_refused => {}
        _ => context.misplaced(card, cohesive::NO_INITIATION, "DAMAGE INITIATION"),
    }
}

/// Reads `*DAMAGE STABILIZATION` of a material or of a surface interaction.
pub(super) fn read_damage_stabilization(context: &mut Context<'_>, materials: &mut MaterialReader, card: &Card) {
    if materials.in_interaction {
        return cohesive_contact::read_cohesive_stabilization(context, card);
    }
    cohesive::read_interface_stabilization(context, card);
}

pub(super) fn read_tensile_failure(context: &mut Context<'_>, card: &Card) {
    let cards::TensileFailure { deletes, cutoff: [cutoff] } = card.values();
    context.last_material().tensile_failure = Some(TensileFailure { cutoff, deletes, span: card.span });
}
