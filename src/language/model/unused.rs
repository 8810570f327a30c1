//! Lists input that nothing in the deck uses: named definitions, and values that depend on other cards.

use std::collections::HashSet;

use super::context::Context;
use super::names::upper;
use super::types::{IncrementControl, MaterialDefinition};
use crate::deck::keywords::CardPlace;
use crate::deck::{Card, Span, Word};

/// Cards that define something by NAME that other cards refer to. Sets and surfaces, which programs write in great number, are
/// not listed, and materials only in the deck's own file, since libraries of materials are included.
const DEFINITIONS: [&str; 11] = [
    "ADAPTIVE MESH CONTROLS",
    "AMPLITUDE",
    "CONTACT CLEARANCE",
    "CONTACT INITIALIZATION DATA",
    "INCIDENT WAVE INTERACTION PROPERTY",
    "INTEGRATED OUTPUT SECTION",
    "MATERIAL",
    "SECTION CONTROLS",
    "SURFACE INTERACTION",
    "TARGET",
    "TIME POINTS",
];

/// Parameters of `*SECTION CONTROLS` that cohesive elements have.
const OF_COHESIVE: [&str; 4] = ["NAME", "ELEMENT DELETION", "MAX DEGRADATION", "VISCOSITY"];

/// Lists what nothing uses, after all cards are read without errors.
pub fn list_unused(context: &mut Context<'_>) {
    if context.diagnostics.has_errors() {
        return;
    }
    let (unused, used) = (unused_names(context), UsedControls::of(context));
    let cards = context.deck.cards.iter().enumerate().filter(|(_, card)| !card.faulty);
    for (index, card) in cards {
        let name = card.value("NAME").map(|word| upper(&word.text));
        match card.keyword.name {
            "MATERIAL" if card.span.file != 0 => {}
            keyword if DEFINITIONS.contains(&keyword) && name.as_ref().is_some_and(|name| unused.contains(name)) => {
                context.ignore(keyword, card.span, "no other card names it");
            }
            "SECTION CONTROLS" => controls_without_effect(context, card, (&name.unwrap_or_default(), &used)),
            "GAP HEAT GENERATION" if !has_sibling(&context.deck.cards, index, "FRICTION") => {
                context.ignore("GAP HEAT GENERATION", card.span, "the interaction has no *FRICTION");
            }
            "CONCRETE FAILURE" => limits_of_absent_damage(context, index),
            "CONTACT PROPERTY ASSIGNMENT" => assignments_without_interaction(context, card),
            "CONTACT INCLUSIONS" if card.has("ALL EXTERIOR") => {
                for line in card.lines.iter().filter(|line| line.field(0).is_some()) {
                    context.ignore("CONTACT INCLUSIONS, surfaces", line.span, "ALL EXTERIOR includes all surfaces");
                }
            }
            "SOLID SECTION" => orientation_without_fibres(context, card),
            "CONTACT PAIR" => {
                let between = |word: &&Word| !matches!(word.text.parse(), Ok(0.0_f64 | 1.0));
                if let Some(word) = card.value("WEIGHT").filter(between) {
                    let why = "the side that carries the pressures is chosen automatically unless it is 0 or 1";
                    context.ignore("CONTACT PAIR, WEIGHT", word.span, why);
                }
            }
            "PHYSICAL CONSTANTS" => {
                let is_unread = !context.model.materials.iter().any(MaterialDefinition::is_ideal_gas);
                if let Some(word) = card.value("ABSOLUTE ZERO").filter(|_| is_unread) {
                    let why = "only the pressure of an ideal gas depends on the absolute temperature";
                    context.ignore("PHYSICAL CONSTANTS, ABSOLUTE ZERO", word.span, why);
                }
            }
            "RIGID BODY" if !card.has("DENSITY") => {
                if let Some(word) = card.lines.first().and_then(|line| line.field(0)) {
                    context.ignore("RIGID BODY, thickness", word.span, "there is no DENSITY");
                }
            }
            _ => {}
        }
    }
    accuracy_of_given_increments(context);
    adiabatic_without_dissipation(context);
    amplitudes_of_steps(context);
}

/// Returns whether a card with the same parent as the card at an index has the keyword.
fn has_sibling(cards: &[Card], index: usize, keyword: &str) -> bool {
    let CardPlace::Below(parents) = cards[index].keyword.place else { return false };
    let is_parent = |card: &Card| parents.contains(&card.keyword.name);
    let first = cards[..index].iter().rposition(is_parent).map_or(0, |parent| parent + 1);
    let siblings = cards[first..].iter().take_while(|card| !is_parent(card));
    siblings.into_iter().any(|card| card.keyword.name == keyword)
}

/// Lists limits of the damage of concrete without a table of this damage.
fn limits_of_absent_damage(context: &mut Context<'_>, index: usize) {
    let cards = &context.deck.cards;
    for (field, name, table) in
        [(2, "tensile damage", "CONCRETE TENSION DAMAGE"), (3, "compressive damage", "CONCRETE COMPRESSION DAMAGE")]
    {
        let word = cards[index].lines.first().and_then(|line| line.field(field));
        if let Some(word) = word.filter(|_| !has_sibling(cards, index, table)) {
            let why = format!("the material has no *{table}: this damage is 0");
            context.ignore(format!("CONCRETE FAILURE, {name}"), word.span, &why);
        }
    }
}

/// Lists the orientation of a solid section whose material has no fibres.
fn orientation_without_fibres(context: &mut Context<'_>, card: &Card) {
    let has_fibres = |material: &MaterialDefinition| material.user.energy.is_some_and(|energy| energy.families > 0);
    let model = &context.model;
    let is_used = model.sections.iter().any(|s| s.span == card.span && has_fibres(&model.materials[s.material]));
    if let Some(word) = card.value("ORIENTATION").filter(|_| !is_used) {
        let why =
            "built-in materials without fibres are isotropic; a *USER MATERIAL receives components along r, z and hoop";
        context.ignore("SOLID SECTION, ORIENTATION", word.span, why);
    }
}

/// Lists ADIABATIC if no material converts work to heat.
fn adiabatic_without_dissipation(context: &mut Context<'_>) {
    let heats = |material: &MaterialDefinition| {
        material.plastic.is_some()
            || material.has_strength_law()
            || material.foam.shape.is_some()
            || material.eos.is_some()
            || (material.user.material.is_some() && material.user.energy.is_none())
    };
    if context.model.materials.iter().any(heats) {
        return;
    }
    for card in context.deck.cards.iter().filter(|card| card.keyword.name == "DYNAMIC" && card.has("ADIABATIC")) {
        context.ignore("DYNAMIC, ADIABATIC", card.span, "no material converts work to heat");
    }
}

/// Lists AMPLITUDE of steps without loads and without prescribed motions.
fn amplitudes_of_steps(context: &mut Context<'_>) {
    let cards = context.deck.cards.iter().filter(|card| card.keyword.name == "STEP");
    let idle: Vec<Span> = cards
        .zip(&context.model.steps)
        .filter(|(_, step)| step.loads.is_empty() && step.boundaries.iter().all(|boundary| boundary.value == 0.0))
        .filter_map(|(card, _)| Some(card.parameter("AMPLITUDE")?.span))
        .collect();
    for span in idle {
        context.ignore("STEP, AMPLITUDE", span, "the step has no loads and no prescribed motions");
    }
}

/// Returns the names of definitions that no card mentions, in capitals: neither as the value of a parameter except NAME, nor in a
/// data line.
fn unused_names(context: &Context<'_>) -> HashSet<String> {
    let definitions = context.deck.cards.iter().filter(|card| DEFINITIONS.contains(&card.keyword.name));
    let mut unused: HashSet<String> = definitions.filter_map(|card| Some(upper(&card.value("NAME")?.text))).collect();
    for card in &context.deck.cards {
        let values = card.parameters.iter().filter(|parameter| parameter.name != "NAME");
        let values = values.filter_map(|parameter| parameter.value.as_ref());
        for word in values.chain(card.lines.iter().flat_map(|line| &line.fields)) {
            if unused.is_empty() {
                return unused;
            }
            let word = upper(&word.text);
            let without_instance = word.rsplit('.').next().unwrap_or_default();
            unused.remove(without_instance);
            unused.remove(&word);
        }
    }
    unused
}

/// Sections that use section controls.
struct UsedControls {
    /// Names of the controls of `*SOLID SECTION` and of `*COHESIVE SECTION`.
    of_solids: HashSet<String>,
    of_cohesive: HashSet<String>,
    /// Places of ELEMENT DELETION=NO for materials that fail.
    keeping_failed: HashSet<Span>,
}

impl UsedControls {
    fn of(context: &Context<'_>) -> UsedControls {
        let named_by = |keyword: &str| {
            let sections = context.deck.cards.iter().filter(|card| card.keyword.name == keyword);
            sections.filter_map(|card| Some(upper(&card.value("CONTROLS")?.text))).collect()
        };
        let fails = |material: &MaterialDefinition| {
            !material.failures.is_empty()
                || material.tensile_failure.is_some()
                || material.failed.is_some()
                || material.strength.johnson_holmquist.is_some()
                || material.strength.holmquist_johnson_cook.is_some()
                || material.strength.porous_failure.is_some()
                || material.strength.concrete_failure.is_some()
                || material.user.material.is_some()
        };
        let failing = context.model.sections.iter().filter(|section| fails(&context.model.materials[section.material]));
        UsedControls {
            of_solids: named_by("SOLID SECTION"),
            of_cohesive: named_by("COHESIVE SECTION"),
            keeping_failed: failing.filter_map(|section| section.controls.keep_failed_elements).collect(),
        }
    }
}

/// Lists parameters of section controls that the sections that name them do not have.
fn controls_without_effect(context: &mut Context<'_>, card: &Card, (name, used): (&str, &UsedControls)) {
    let (is_of_solids, is_of_cohesive) = (used.of_solids.contains(name), used.of_cohesive.contains(name));
    for parameter in &card.parameters {
        let why = match parameter.name {
            "VISCOSITY" if !is_of_cohesive => {
                "only cohesive elements have it, and no *COHESIVE SECTION names the controls"
            }
            other if !is_of_solids && !OF_COHESIVE.contains(&other) => "no *SOLID SECTION names the controls",
            "ELEMENT DELETION" if is_of_solids && !is_of_cohesive && keeps_nothing(card, used) => {
                "the materials of its sections have no failure criterion"
            }
            _ => continue,
        };
        context.ignore(format!("SECTION CONTROLS, {}", parameter.name), parameter.span, why);
    }
}

/// Returns whether ELEMENT DELETION=NO is given for materials that do not fail.
fn keeps_nothing(card: &Card, used: &UsedControls) -> bool {
    !card.read::<bool>("ELEMENT DELETION") && !used.keeping_failed.contains(&card.span)
}

/// Lists the lines of `*CONTACT PROPERTY ASSIGNMENT` that name no interaction.
fn assignments_without_interaction(context: &mut Context<'_>, card: &Card) {
    for line in card.lines.iter().filter(|line| line.field(2).is_none()) {
        let why = "the line names no interaction: the pairs have contact without friction";
        context.ignore("CONTACT PROPERTY ASSIGNMENT", line.span, why);
    }
}

/// Lists ACCURACY of steps with given increments.
fn accuracy_of_given_increments(context: &mut Context<'_>) {
    let fixed: Vec<Span> = context
        .model
        .steps
        .iter()
        .filter(|step| matches!(step.increment, IncrementControl::Fixed(_)))
        .map(|step| step.span)
        .collect();
    for card in context.deck.cards.iter().filter(|card| fixed.contains(&card.span)) {
        if let Some(word) = card.value("ACCURACY") {
            context.ignore("DYNAMIC, ACCURACY", word.span, "the time increment is given");
        }
    }
}
