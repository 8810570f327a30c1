//! Surface interactions: `*SURFACE INTERACTION`, `*FRICTION`, `*SURFACE BEHAVIOR`, `*GAP CONDUCTANCE`,
//! `*GAP HEAT GENERATION` (ABAQUS Keywords Reference Guide).

use std::sync::Arc;

use super::contact;
use super::context::Context;
use super::families::MaterialReader;
use super::faults::{ValueCheck, require};
use super::names::upper;
use super::types::{
    ContactDamping, CoulombFriction, FrictionRoutine, InteractionLaw, PressureOverclosure, SurfaceInteraction,
};
use super::user_material::constants;
use crate::deck::table::constraints as cards;
use crate::deck::{Card, Diagnostic};

/// Indices of the values of `PRESSURE-OVERCLOSURE` in the keyword table.
const HARD: usize = 0;
const LINEAR: usize = 1;
const EXPONENTIAL: usize = 2;

pub fn read_surface_interaction(context: &mut Context<'_>, materials: &mut MaterialReader, card: &Card) {
    materials.in_interaction = true;
    let Some(name) = context.required(card, "NAME") else { return };
    let (name, law) = (upper(&name.text), InteractionLaw::default());
    context.model.interactions.push(SurfaceInteraction { name, law, heat_cards: Vec::new(), cohesion: None });
    contact::contact_note(context, card);
}

fn last_law<'c>(context: &'c mut Context<'_>) -> Option<&'c mut InteractionLaw> {
    context.model.interactions.last_mut().map(|interaction| &mut interaction.law)
}

pub fn read_friction(context: &mut Context<'_>, card: &Card) {
    contact::contact_note(context, card);
    let routine = friction_routine(context, card);
    if let (Some(friction), Some(law)) = (friction_law(context, card), last_law(context)) {
        (law.friction, law.friction_routine) = (friction, routine);
    }
}

/// Index of the value `COEFFICIENT` of `USER` in the keyword table.
const COEFFICIENT: usize = 2;

/// Returns the user subroutine of `*FRICTION, USER`.
fn friction_routine(context: &mut Context<'_>, card: &Card) -> Option<Arc<FrictionRoutine>> {
    let cards::Friction { user, variables, .. } = card.values();
    if user == COEFFICIENT {
        let help = "give USER, and a subroutine VFRICTION that returns -min(mu*fNormal, fStickForce)";
        return context.refuse_unsupported(card.span, "user subroutine VFRIC_COEF is not supported", help);
    }
    if user == 0 {
        return None;
    }
    let properties = constants(context, card, "PROPERTIES")?;
    let interaction = context.model.interactions.last()?.name.clone();
    Some(Arc::new(FrictionRoutine { interaction, properties, variables }))
}

fn friction_law(context: &mut Context<'_>, card: &Card) -> Option<CoulombFriction> {
    let cards::Friction { largest, rough, decays, damping, user, values: [at_rest, sliding, decay], .. } =
        card.values();
    let mut friction = if user != 0 {
        // The subroutine limits the friction.
        CoulombFriction::of(f64::INFINITY)
    } else if rough {
        if let Some(word) = card.lines.first().and_then(|line| line.field(0)) {
            context.report_surplus(word, "ROUGH has no coefficient");
        }
        CoulombFriction::of(f64::INFINITY)
    } else if decays {
        CoulombFriction { at_rest, sliding, decay, ..CoulombFriction::default() }
    } else {
        context.first_line(card)?;
        CoulombFriction::of(at_rest)
    };
    friction.damping = damping;
    friction.largest = largest.unwrap_or(friction.largest);
    Some(friction)
}

pub fn read_surface_behavior(context: &mut Context<'_>, card: &Card) {
    contact::contact_note(context, card);
    if let (Some(overclosure), Some(law)) = (overclosure(context, card), last_law(context)) {
        law.overclosure = overclosure;
    }
}

pub fn read_contact_damping(context: &mut Context<'_>, card: &Card) {
    contact::contact_note(context, card);
    let cards::ContactDamping { is_fraction, values: [value] } = card.values();
    let damping = if is_fraction { ContactDamping::CriticalFraction } else { ContactDamping::Coefficient };
    if let Some(law) = last_law(context) {
        law.damping = Some(damping(value));
    }
}

pub fn read_gap_conductance(context: &mut Context<'_>, card: &Card) {
    contact::contact_note(context, card);
    let cards::GapConductance { over_pressure, rows } = card.values();
    if rows.len() < 2 {
        return context.out_of_range(card.span, "a gap conductance requires at least two rows");
    }
    let Some(interaction) = context.model.interactions.last_mut() else { return };
    let heat = &mut interaction.law.heat;
    let table = if over_pressure { &mut heat.over_pressure } else { &mut heat.over_clearance };
    if !table.is_empty() {
        let over = if over_pressure { "PRESSURE" } else { "the clearance" };
        let message = format!("*GAP CONDUCTANCE over {over} is defined twice for one *SURFACE INTERACTION");
        let diagnostic = Diagnostic::error("M160", message).at(card.span, "second definition");
        return context.diagnostics.push(diagnostic.help("remove one definition"));
    }
    *table = rows;
    interaction.heat_cards.push((card.keyword.name, card.span));
}

pub fn read_gap_heat_generation(context: &mut Context<'_>, card: &Card) {
    contact::contact_note(context, card);
    let cards::GapHeatGeneration { values: [fraction, to_first] } = card.values();
    let Some(interaction) = context.model.interactions.last_mut() else { return };
    (interaction.law.heat.fraction, interaction.law.heat.to_first) = (fraction, to_first);
    interaction.heat_cards.push((card.keyword.name, card.span));
}

fn overclosure(context: &mut Context<'_>, card: &Card) -> Option<PressureOverclosure> {
    let cards::SurfaceBehavior { kind } = card.values();
    match kind {
        HARD => Some(PressureOverclosure::Hard),
        LINEAR => {
            let [stiffness]: [f64; 1] = card.read_lines();
            Some(PressureOverclosure::Linear(stiffness))
        }
        EXPONENTIAL => {
            let [clearance, pressure]: [f64; 2] = card.read_lines();
            Some(PressureOverclosure::Exponential([pressure, clearance]))
        }
        _ => {
            let table = PressureOverclosure::Table(card.read_lines());
            context.accepts(card, check_overclosure(&table)).then_some(table)
        }
    }
}

/// Checks rows of pressure and overclosure.
pub fn check_overclosure(overclosure: &PressureOverclosure) -> ValueCheck {
    let PressureOverclosure::Table(rows) = overclosure else { return Ok(()) };
    let is_valid = rows.len() > 1 && rows[0][0] == 0.0 && rows.windows(2).all(|w| w[0][0] <= w[1][0]);
    let message = "the table requires at least two rows, with pressures that start at zero and do not decrease";
    require(is_valid, message)
}
