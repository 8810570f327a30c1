//! Material failure: `*SHEAR FAILURE`, `*TENSILE FAILURE`, `*DAMAGE INITIATION`, `*DAMAGE EVOLUTION`, `*COUPLED DAMAGE`.

use super::context::Context;
use super::families::MaterialReader;
use super::faults::{ValueCheck, require, require_line};
use super::types::{DamageEvolution, FailedMaterial, FailureCriterion, StrainAtFailure};
use super::{cohesive, cohesive_contact};
use crate::deck::Card;
use crate::deck::table::materials as cards;
use crate::kernel::levels::NestedTable;

/// Index of the value of `CRITERION` in the keyword table.
const DUCTILE: usize = 1;

pub fn read_shear_failure(context: &mut Context<'_>, card: &Card) {
    let cards::ShearFailure { johnson_cook, deletes } = card.values();
    if !deletes {
        let without_strength = FailedMaterial { residual: 0.0, crossings: 0.0, span: card.span };
        context.last_material().failed.get_or_insert(without_strength);
    }
    let Some(line) = context.first_line(card) else { return };
    let strain = if johnson_cook {
        StrainAtFailure::JohnsonCook(card.read_lines(), None)
    } else if card.lines.len() > 1 || (1..4).any(|i| line.field(i).is_some()) {
        StrainAtFailure::Shear(card.read_lines())
    } else {
        let [strain]: [f64; 1] = card.read_lines();
        StrainAtFailure::Constant(strain)
    };
    criterion(context, card, strain, DamageEvolution::Sudden);
}

fn criterion(context: &mut Context<'_>, card: &Card, strain: StrainAtFailure, evolution: DamageEvolution) {
    if context.accepts(card, strain.check()) {
        context.last_material().failures.push(FailureCriterion { strain, evolution, span: card.span });
    }
}

impl StrainAtFailure {
    /// Checks the order of tables, and the constants of Johnson and Cook.
    pub fn check(&self) -> ValueCheck {
        match self {
            StrainAtFailure::Constant(strain) => {
                require(*strain > 0.0, format!("the strain at failure must be positive, found {strain}"))
            }
            StrainAtFailure::JohnsonCook(constants, thermal) => {
                let [melt, transition, rate] = thermal.unwrap_or([f64::INFINITY, 0.0, 1.0]);
                let message = "d4 requires a positive reference strain rate, d5 a melting \
                               temperature above the transition temperature";
                require_line(
                    0,
                    (constants[3] == 0.0 || rate > 0.0) && (constants[4] == 0.0 || melt > transition),
                    message,
                )?;
                require(constants.iter().all(|d| d.is_finite()), "d1 to d5 must be finite")
            }
            // The first of three variables varies fastest.
            StrainAtFailure::Ductile(rows) | StrainAtFailure::Shear(rows) => {
                let message = "the rows must be in ascending order, with the first variable varying fastest";
                require_line(0, NestedTable::new(rows).is_some(), message)?;
                require(rows.iter().all(|row| row[0] > 0.0), "the strains at failure must be positive")
            }
        }
    }
}

/// Reads `*DAMAGE INITIATION` of a material or of a surface interaction.
pub fn read_damage_initiation(context: &mut Context<'_>, materials: &mut MaterialReader, card: &Card) {
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
    if context.first_line(card).is_none() {
        return;
    }
    let strain = if kind == DUCTILE {
        StrainAtFailure::Ductile(card.read_lines())
    } else {
        // d1 to d5, melting temperature, transition temperature and reference strain rate.
        let [d1, d2, d3, d4, d5, melt, transition, rate]: [f64; 8] = card.read_lines();
        StrainAtFailure::JohnsonCook([d1, d2, d3, d4, d5], Some([melt, transition, rate]))
    };
    criterion(context, card, strain, DamageEvolution::Absent);
}

/// Reads `*DAMAGE EVOLUTION` of a material or of a surface interaction.
pub fn read_damage_evolution(context: &mut Context<'_>, materials: &mut MaterialReader, card: &Card) {
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
    set_evolution(context, card, evolution);
}

/// Reads `*COUPLED DAMAGE`.
pub fn read_coupled_damage(context: &mut Context<'_>, card: &Card) {
    let cards::CoupledDamage { values: [critical, length] } = card.values();
    let length = Some(length).filter(|length| !length.is_nan());
    set_evolution(context, card, DamageEvolution::Strain(critical, length));
}

/// Sets how the damage of the last criterion evolves.
fn set_evolution(context: &mut Context<'_>, card: &Card, evolution: DamageEvolution) {
    let is_refused = context.missing.has_card("DAMAGE INITIATION");
    match context.last_material().failures.last_mut() {
        Some(last) if last.evolution == DamageEvolution::Absent => last.evolution = evolution,
        _ if is_refused => {}
        _ => context.misplaced(card, cohesive::NO_INITIATION, "DAMAGE INITIATION"),
    }
}

/// Reads `*DAMAGE STABILIZATION` of a material or of a surface interaction.
pub fn read_damage_stabilization(context: &mut Context<'_>, materials: &mut MaterialReader, card: &Card) {
    if materials.in_interaction {
        return cohesive_contact::read_cohesive_stabilization(context, card);
    }
    cohesive::read_interface_stabilization(context, card);
}
