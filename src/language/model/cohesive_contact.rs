//! Cohesive behaviour of contact surfaces: `*COHESIVE BEHAVIOR` of a surface interaction, and the `*DAMAGE INITIATION`,
//! `*DAMAGE EVOLUTION` and `*DAMAGE STABILIZATION` that follow it (ABAQUS Keywords Reference Guide).

use super::cohesive::{NO_INITIATION, check_coupling, initiation_of, softening};
use super::contact;
use super::context::Context;
use super::types::{CohesiveBehavior, InitiationMeasure, InterfaceEvolution};
use crate::deck::table::{constraints, materials};
use crate::deck::{Card, Diagnostic};

pub fn read_cohesive_behavior(context: &mut Context<'_>, card: &Card) {
    contact::contact_note(context, card);
    let constraints::CohesiveBehavior { original, coupled, repeated, stiffness } = card.values();
    let (stiffness, coupling) = ([stiffness[0], stiffness[1]], if coupled { stiffness[3] } else { 0.0 });
    if coupled && !context.accepts(card, check_coupling(stiffness, coupling)) {
        return;
    }
    if stiffness[0].is_nan() != stiffness[1].is_nan() {
        let span = card.lines.first().map_or(card.span, |line| line.span);
        let message = "*COHESIVE BEHAVIOR requires both the normal and the shear stiffness, or no data line";
        return context.out_of_range(span, message);
    }
    let stiffness = (!stiffness[0].is_nan()).then_some(stiffness);
    let Some(interaction) = context.model.interactions.last_mut() else { return };
    interaction.cohesion = Some(CohesiveBehavior {
        stiffness,
        coupling,
        viscosity: 0.0,
        original_only: original,
        repeated,
        initiation: None,
        evolution: None,
        span: card.span,
    });
}

/// Returns the cohesive behaviour of the current surface interaction, or reports that it is missing.
fn last_cohesion<'c>(context: &'c mut Context<'_>, card: &Card) -> Option<&'c mut CohesiveBehavior> {
    let is_there = context.model.interactions.last().is_some_and(|interaction| interaction.cohesion.is_some());
    if !is_there && !context.missing.has_card("COHESIVE BEHAVIOR") {
        let message = format!("*{} of a surface interaction must follow its *COHESIVE BEHAVIOR", card.keyword.name);
        let finding = Diagnostic::error("M105", message).at(card.span, "no *COHESIVE BEHAVIOR before");
        context.diagnostics.push(finding.help("add *COHESIVE BEHAVIOR, or move the card below its *MATERIAL"));
    }
    context.model.interactions.last_mut().and_then(|interaction| interaction.cohesion.as_mut())
}

/// Reads `*DAMAGE INITIATION` of a surface interaction.
pub fn read_cohesive_initiation(context: &mut Context<'_>, card: &Card) {
    let materials::DamageInitiation { criterion } = card.values();
    let Some(before) = last_cohesion(context, card).map(|cohesion| cohesion.initiation) else { return };
    let initiation = initiation_of(card, criterion).filter(|i| i.measure != InitiationMeasure::Strain);
    if initiation.is_none() {
        let name = card.value("CRITERION").map_or(String::new(), |word| word.text.to_uppercase());
        let message = format!("CRITERION={name} does not apply to cohesive surfaces");
        let span = card.value("CRITERION").map_or(card.span, |word| word.span);
        return context.unsupported(span, message, "give MAXS, QUADS (tractions), MAXU or QUADU (separations)");
    }
    if before.is_some() {
        let message = "a cohesive behaviour has one *DAMAGE INITIATION";
        return context.unsupported(card.span, message, "remove one of the criteria");
    }
    if let Some(cohesion) = last_cohesion(context, card) {
        cohesion.initiation = initiation;
    }
}

/// Reads `*DAMAGE EVOLUTION` of a surface interaction.
pub fn read_cohesive_evolution(context: &mut Context<'_>, card: &Card) {
    let Some(cohesion) = last_cohesion(context, card) else { return };
    if cohesion.initiation.is_none() || cohesion.evolution.is_some() {
        if !context.missing.has_card("DAMAGE INITIATION") {
            context.misplaced(card, NO_INITIATION, "DAMAGE INITIATION");
        }
        return;
    }
    let softening = softening(context, card);
    if let (Some(softening), Some(cohesion)) = (softening, last_cohesion(context, card)) {
        cohesion.evolution = Some(InterfaceEvolution { softening, span: card.span });
    }
}

/// Reads `*DAMAGE STABILIZATION` of a surface interaction.
pub fn read_cohesive_stabilization(context: &mut Context<'_>, card: &Card) {
    let materials::DamageStabilization { viscosity: [viscosity] } = card.values();
    let Some(cohesion) = last_cohesion(context, card) else { return };
    if cohesion.evolution.is_none() {
        if !context.missing.has_card("DAMAGE INITIATION") && !context.missing.has_card("DAMAGE EVOLUTION") {
            context.misplaced(card, "*DAMAGE STABILIZATION must follow a *DAMAGE EVOLUTION", "DAMAGE EVOLUTION");
        }
        return;
    }
    if cohesion.viscosity != 0.0 {
        let message = "a surface interaction has one *DAMAGE STABILIZATION";
        return context.unsupported(card.span, message, "remove one of the cards");
    }
    cohesion.viscosity = viscosity;
}
