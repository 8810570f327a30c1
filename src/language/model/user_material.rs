//! Material data of user subroutines: `*USER MATERIAL`, `*PLASTIC, HARDENING=USER`, `*USER DEFINED FIELD`, `*DEPVAR`,
//! and initial state variables.

use super::bodies::warn_of_repeated_condition;
use super::context::Context;
use super::families::ConditionReader;
use super::types::{AnisotropicEnergyCard, InitialCondition, InitialKind, PlasticityModel, StateVariables};
use crate::deck::read::FromValue;
use crate::deck::table::materials as cards;
use crate::deck::{Card, DataLine};

/// Values on a full data line.
const ROW: usize = 8;

/// Reads `*USER MATERIAL, CONSTANTS=n`.
pub fn read_user_material(context: &mut Context<'_>, card: &Card) {
    if context.required(card, "CONSTANTS").is_none() {
        return;
    }
    let values = constants(context, card, "CONSTANTS");
    let material = context.last_material();
    if material.name.starts_with(JOHNSON_HOLMQUIST) {
        material.strength.johnson_holmquist = values.map(|values| (values, card.span));
    } else if ["ABQ_JH1", "ABQ_JHB"].iter().any(|name| material.name.starts_with(name)) {
        context.unsupported(
            card.span,
            "the laws JH-1 and JHB of ABAQUS are not supported",
            "give the constants of JH-2 under a name that begins with ABQ_JH2, or write a VUMAT with another name",
        );
    } else {
        material.user.material = values;
    }
}

/// Reads `*ANISOTROPIC HYPERELASTIC`.
pub fn read_anisotropic_energy(context: &mut Context<'_>, card: &Card) {
    let cards::AnisotropicHyperelastic { is_user, families } = card.values();
    if !is_user && !card.has("HOLZAPFEL") {
        return context.unsupported(card.span, "the strain energy is missing", "give HOLZAPFEL or USER");
    }
    let constants = if is_user { constants(context, card, "PROPERTIES") } else { holzapfel_constants(context, card) };
    let user = &mut context.last_material().user;
    user.energy = constants.is_some().then_some(AnisotropicEnergyCard { is_user, families });
    user.material = constants;
}

/// Reads C10, D, k1, k2 and kappa. D = 0 selects the default compressibility.
fn holzapfel_constants(context: &mut Context<'_>, card: &Card) -> Option<Vec<f64>> {
    let line = context.first_line(card)?;
    let [c10, d, k1, k2, kappa] = context.numbers_or::<5>(line, 0, 0.0)?;
    // The bulk modulus 2/D is 20 times the shear modulus 2 C10.
    Some(vec![c10, if d == 0.0 { 0.05 / c10 } else { d }, k1, k2, kappa])
}

/// Beginning of the names of materials for which ABAQUS reads `*USER MATERIAL` as the second law of Johnson and Holmquist.
const JOHNSON_HOLMQUIST: &str = "ABQ_JH2";

/// Reads `*PLASTIC, HARDENING=USER, PROPERTIES=n`.
pub fn user_hardening(context: &mut Context<'_>, card: &Card) {
    context.last_material().plastic = constants(context, card, "PROPERTIES").map(PlasticityModel::User);
}

/// Reads `*USER DEFINED FIELD, PROPERTIES=n`.
pub fn read_user_fields(context: &mut Context<'_>, card: &Card) {
    context.last_material().user.fields =
        constants(context, card, "PROPERTIES").map(|constants| (constants, card.span));
}

/// Reads `*CHARACTERISTIC LENGTH`: the square root of the area (default) or a user subroutine.
pub fn read_characteristic_length(context: &mut Context<'_>, card: &Card) {
    if !card.read::<bool>("DEFINITION") {
        context.inert(card, "the square root of the area is the default");
    } else {
        context.last_material().user.lengths = constants(context, card, "PROPERTIES").map(|list| (list, card.span));
    }
}

/// Reads the number of constants given by a parameter, default 0, from data lines with eight values each. Empty
/// fields, and missing fields of all but the last line, are zero.
pub fn constants(context: &mut Context<'_>, card: &Card, parameter: &str) -> Option<Vec<f64>> {
    let expected: usize = card.read(parameter);
    let mut constants = Vec::new();
    for (row, line) in card.lines.iter().enumerate() {
        constants.resize(ROW * row, 0.0);
        let filled = line.fields.iter().rposition(|w| !w.text.is_empty()).map_or(0, |last| last + 1);
        // Trailing empty fields are zeros up to the required number of constants.
        let empty = line.fields.len().min(expected.saturating_sub(ROW * row));
        if filled > ROW {
            let message = format!("a data line has at most {ROW} constants, found {filled}");
            return context.refuse_value(line.span, message);
        }
        for i in 0..filled.max(empty) {
            constants.push(context.number_or(line, i, 0.0)?);
        }
    }
    if expected == constants.len() {
        return Some(constants);
    }
    let expected = card.value(parameter).map_or(String::new(), |word| format!("{parameter}={}, but ", word.text));
    let rows =
        if card.lines.len() > 1 { format!(" (each line except the last counts as {ROW})") } else { String::new() };
    context.refuse_value(card.span, format!("{expected}found {} constants{rows}", constants.len()))
}

/// Reads `*DEPVAR`: the number of variables, then lines of number, name and description.
pub fn read_state_variables(context: &mut Context<'_>, card: &Card) {
    let calls = |c: &&Card| {
        let name = c.keyword.name;
        let hardening = name == "PLASTIC" && c.value("HARDENING").is_some_and(|w| w.is("USER"));
        let is_user = hardening || (name == "ANISOTROPIC HYPERELASTIC" && c.has("USER"));
        is_user || matches!(name, "USER MATERIAL" | "USER DEFINED FIELD")
    };
    if !context.deck.cards.iter().any(|c| calls(&c)) {
        return context.inert(card, "it is used by user subroutines only, and this deck has none at material points");
    }
    let count = usize::from_value(card.given_field(0, 0));
    let delete = card.read::<Option<usize>>("DELETE");
    if let Some((number, word)) = delete.zip(card.value("DELETE")).filter(|(number, _)| *number > count) {
        context.out_of_range(word.span, format!("DELETE must be from 1 to {count}, found {number}"));
    }
    let delete = delete.filter(|number| *number <= count).map(|number| number - 1);
    context.last_material().user.state = StateVariables { count, delete };
    let names = card.lines[1..].iter().filter_map(|line| state_name(context, line, count)).collect();
    context.last_material().user.state_names = names;
}

/// Reads the index from 0 and the name of a state variable.
fn state_name(context: &mut Context<'_>, line: &DataLine, count: usize) -> Option<(usize, String)> {
    let number = context.integer(line, 0, "the number of a state variable")?;
    let Some(variable) = usize::try_from(number).ok().filter(|n| (1..=count).contains(n)) else {
        return context
            .refuse_value(line.span, format!("state variable {number} does not exist; the material has {count}"));
    };
    line.field(1).map(|name| (variable - 1, name.text.trim_matches('"').to_owned()))
}

/// Reads `*INITIAL CONDITIONS, TYPE=SOLUTION`: a set with seven state variables, then eight per line. A line of
/// numbers continues the previous one until all variables are given; other lines start a new set.
pub fn initial_state(context: &mut Context<'_>, conditions: &mut ConditionReader, card: &Card) {
    let cards = context.deck.cards.iter().filter(|c| c.keyword.name == "DEPVAR");
    let counts = cards.filter_map(|c| c.lines.first()?.field(0)?.text.parse::<usize>().ok());
    let largest_count = counts.max().unwrap_or(0);
    let mut lines = card.lines.iter().peekable();
    while let Some(line) = lines.next() {
        let Some(set) = line.field(0) else { continue };
        let mut values = Vec::new();
        let mut read = |context: &mut Context<'_>, line: &DataLine, from: usize, to: usize| {
            for i in from..to {
                values.push(context.number_or(line, i, 0.0)?);
            }
            Some(values.len())
        };
        let Some(mut count) = read(context, line, 1, if largest_count > ROW - 1 { ROW } else { line.fields.len() })
        else {
            continue;
        };
        while let Some(next) = lines.next_if(|next| count < largest_count && is_continuation(next)) {
            match read(context, next, 0, ROW) {
                Some(more) => count = more,
                None => return,
            }
        }
        if let Some(members) = context.element_members(set) {
            let kind = InitialKind::State(values);
            let condition = InitialCondition { kind, members, span: line.span };
            warn_of_repeated_condition(context, conditions, &condition);
            context.model.initial_conditions.push(condition);
        }
    }
}

/// Returns whether a line has numbers only, as continuation lines do.
fn is_continuation(line: &DataLine) -> bool {
    line.fields.iter().all(|w| w.text.is_empty() || crate::deck::number::parse_number(&w.text).is_ok())
}
