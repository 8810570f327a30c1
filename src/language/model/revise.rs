//! Numbers of a model that can be changed without reading the deck again: names, mesh connectivity and all other
//! numbers of the model do not depend on them.

use super::types::{CavityExpansion, InitialKind, LoadKind, Model};
use crate::deck::template::{ParametricWord, WordPosition};
use crate::deck::value::ValueSpec;
use crate::deck::{Card, Deck, Span};

/// Location of a number in the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum NumberPlace {
    /// Initial velocity, by index of the initial condition.
    Velocity(usize),
    /// Point masses, by source position of the card.
    Mass(Span),
    /// Density, by index of the material.
    Density(usize),
    /// Constant of cavity expansion: index of the material, and 0 to 3 for Y, A, B, C.
    Resistance(usize, usize),
    /// Position of the impact face, by index of the target.
    Front(usize),
    /// Layer thickness, by indices of target and layer.
    Thickness(usize, usize),
    /// Friction of cavity loads, by first and last data line of the card.
    Friction(Span, Span),
    /// Load magnitude, by data line.
    Magnitude(Span),
}

/// A number of the model that can be changed, with its allowed values.
#[derive(Clone, Copy, Debug)]
pub struct RevisableNumber {
    place: NumberPlace,
    allowed: ValueSpec,
}

impl RevisableNumber {
    /// Returns whether masses of bodies depend on it.
    pub fn changes_masses(&self) -> bool {
        matches!(self.place, NumberPlace::Mass(_) | NumberPlace::Density(_))
    }

    /// Returns whether loads depend on it; gravity depends on masses.
    pub fn changes_loads(&self) -> bool {
        !matches!(self.place, NumberPlace::Velocity(_))
    }
}

/// Returns the number that a parametric word defines; `None` if other data of the model depend on it.
pub fn revisable(model: &Model, deck: &Deck, word: &ParametricWord) -> Option<RevisableNumber> {
    let card = &deck.cards[word.card];
    let rule = match word.at {
        WordPosition::Parameter(name) => card.keyword.rule(name),
        WordPosition::Field(line, field) => card.given_field(line, field).rule,
    };
    Some(RevisableNumber { place: place_of(model, deck, word)?, allowed: rule?.value })
}

fn place_of(model: &Model, deck: &Deck, word: &ParametricWord) -> Option<NumberPlace> {
    let card = &deck.cards[word.card];
    let constants_of = |card: &Card| {
        let of_card = |c: &CavityExpansion| c.span == card.span && c.derived.is_none();
        model.materials.iter().position(|m| m.cavity.as_ref().is_some_and(of_card))
    };
    match (card.keyword.name, word.at) {
        ("INITIAL CONDITIONS", WordPosition::Field(line, 2)) => {
            let span = card.lines[line].span;
            let index = model.initial_conditions.iter().position(|c| c.span == span)?;
            matches!(model.initial_conditions[index].kind, InitialKind::Velocity(..))
                .then_some(NumberPlace::Velocity(index))
        }
        ("MASS", WordPosition::Field(0, 0)) => Some(NumberPlace::Mass(card.span)),
        ("DENSITY", WordPosition::Field(0, 0)) if card.lines.len() == 1 && card.lines[0].fields.len() == 1 => {
            let material = material_above(deck, word.card)?;
            let index = model.materials.iter().position(|m| m.name == material)?;
            // Derived constants depend on the density.
            let derives = model.materials[index].cavity.is_some_and(|c| c.derived.is_some());
            (!derives).then_some(NumberPlace::Density(index))
        }
        ("CAVITY EXPANSION", WordPosition::Parameter("YIELD")) => Some(NumberPlace::Resistance(constants_of(card)?, 0)),
        ("CAVITY EXPANSION", WordPosition::Field(0, i @ 0..3)) => {
            Some(NumberPlace::Resistance(constants_of(card)?, i + 1))
        }
        ("TARGET", WordPosition::Parameter("FRONT")) => target(model, card).map(NumberPlace::Front),
        ("TARGET", WordPosition::Field(line, 1)) => {
            let (target, span) = (target(model, card)?, card.lines[line].span);
            let layer = model.targets[target].layers.iter().position(|l| l.span == span)?;
            Some(NumberPlace::Thickness(target, layer))
        }
        ("DSLOAD" | "DLOAD", WordPosition::Parameter("FRICTION")) => {
            Some(NumberPlace::Friction(card.lines.first()?.span, card.lines.last()?.span))
        }
        ("CLOAD" | "DSLOAD" | "DLOAD", WordPosition::Field(line, 2)) if !card.has("AMPLITUDE") => {
            Some(NumberPlace::Magnitude(card.lines[line].span))
        }
        _ => None,
    }
}

/// Returns the upper-case name of the material that a card belongs to.
fn material_above(deck: &Deck, card: usize) -> Option<String> {
    let above = deck.cards[..card].iter().rev().find(|c| c.keyword.name == "MATERIAL")?;
    Some(above.value("NAME")?.text.to_uppercase())
}

fn target(model: &Model, card: &Card) -> Option<usize> {
    model.targets.iter().position(|t| t.span == card.span)
}

/// Changes a number of the model. Returns `false` if the value is not allowed or would change the structure of the
/// model.
pub fn set(model: &mut Model, RevisableNumber { place, allowed }: RevisableNumber, value: f64) -> bool {
    if !allowed.allows(value) {
        return false;
    }
    match place {
        NumberPlace::Velocity(at) => match &mut model.initial_conditions[at].kind {
            InitialKind::Velocity(2, velocity) => *velocity = value,
            _ => return false,
        },
        NumberPlace::Mass(span) => {
            let mut points = model.discrete.masses.iter_mut().filter(|p| p.span == span).peekable();
            // A mass of zero would remove the mass.
            if points.peek().is_none() || value <= 0.0 {
                return false;
            }
            points.for_each(|point| point.mass = value);
        }
        NumberPlace::Density(at) => {
            if model.materials[at].density.replace(value).is_none() {
                return false;
            }
        }
        NumberPlace::Resistance(at, part) => {
            let Some(law) = &mut model.materials[at].cavity else { return false };
            *[&mut law.yield_stress, &mut law.a, &mut law.b, &mut law.c][part] = value;
        }
        NumberPlace::Front(target) => model.targets[target].front = value,
        NumberPlace::Thickness(target, layer) => {
            model.targets[target].layers[layer].thickness = value;
        }
        NumberPlace::Friction(first, last) => {
            let lines = first.start..=last.start;
            let within = |span: Span| span.file == first.file && lines.contains(&span.start);
            let loads = model.steps.iter_mut().flat_map(|s| &mut s.loads).filter(|l| within(l.span));
            let mut is_changed = false;
            for load in loads {
                if let LoadKind::Cavity { friction, .. } = &mut load.kind {
                    (*friction, is_changed) = (value, true);
                }
            }
            return is_changed;
        }
        NumberPlace::Magnitude(span) => {
            let loads = model.steps.iter_mut().flat_map(|s| &mut s.loads).filter(|l| l.span == span);
            let mut is_changed = false;
            for load in loads {
                let constant = matches!(
                    load.kind,
                    LoadKind::Pressure(_) | LoadKind::Traction { .. } | LoadKind::Concentrated { .. }
                ) || matches!(load.kind, LoadKind::Gravity { direction: [r, _, third], .. } if r == 0.0 && third == 0.0);
                if !constant || load.amplitude.is_some() {
                    return false;
                }
                (load.magnitude, is_changed) = (value, true);
            }
            return is_changed;
        }
    }
    true
}
