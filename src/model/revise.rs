//! Numbers of a model that may take other values without reading the deck again: those that no name, no place in the mesh and
//! no other number of the model follows from.
//! Never here: what follows from them in a plan.

use super::types::{CavityExpansion, InitialKind, LoadKind, Model};
use crate::deck::template::{At, OpenWord};
use crate::deck::value::Value;
use crate::deck::{Card, Deck, Span};

/// A number of the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    /// Velocity at the start, by the index of the condition.
    Velocity(usize),
    /// Mass of points, by their card.
    Mass(Span),
    /// Density of a material.
    Density(usize),
    /// Y, A, B or C of the resistance of a material.
    Resistance(usize, usize),
    /// Place of the face of a target.
    Front(usize),
    /// Thickness of a layer of a target.
    Thickness(usize, usize),
    /// Friction of a resistance, by the lines of the card.
    Friction(Span, Span),
    /// Magnitude of a load, by its line.
    Magnitude(Span),
}

/// A number of the model that may be given other values, and what its card allows.
#[derive(Clone, Copy, Debug)]
pub struct Revisable {
    place: Place,
    allowed: Value,
}

/// The number that an open word gives; `None` where more than a number follows from it.
pub fn revisable(model: &Model, deck: &Deck, word: &OpenWord) -> Option<Revisable> {
    let card = &deck.cards[word.card];
    let rule = match word.at {
        At::Parameter(name) => card.keyword.rule(name),
        At::Field(line, field) => card.given_field(line, field).rule,
    };
    Some(Revisable { place: place_of(model, deck, word)?, allowed: rule?.value })
}

fn place_of(model: &Model, deck: &Deck, word: &OpenWord) -> Option<Place> {
    let card = &deck.cards[word.card];
    let given = |card: &Card| {
        let of_card = |c: &CavityExpansion| c.span == card.span && c.derived.is_none();
        model.materials.iter().position(|m| m.cavity.as_ref().is_some_and(of_card))
    };
    match (card.keyword.name, word.at) {
        ("INITIAL CONDITIONS", At::Field(line, 2)) => {
            let span = card.lines[line].span;
            let at = model.initial_conditions.iter().position(|c| c.span == span)?;
            matches!(model.initial_conditions[at].kind, InitialKind::Velocity(..)).then_some(Place::Velocity(at))
        }
        ("MASS", At::Field(0, 0)) => Some(Place::Mass(card.span)),
        ("DENSITY", At::Field(0, 0)) if card.lines.len() == 1 && card.lines[0].fields.len() == 1 => {
            let material = material_above(deck, word.card)?;
            let at = model.materials.iter().position(|m| m.name == material)?;
            // Derived constants follow from it.
            let derives = model.materials[at].cavity.is_some_and(|c| c.derived.is_some());
            (!derives).then_some(Place::Density(at))
        }
        ("CAVITY EXPANSION", At::Parameter("YIELD")) => Some(Place::Resistance(given(card)?, 0)),
        ("CAVITY EXPANSION", At::Field(0, i @ 0..3)) => Some(Place::Resistance(given(card)?, i + 1)),
        ("TARGET", At::Parameter("FRONT")) => target(model, card).map(Place::Front),
        ("TARGET", At::Field(line, 1)) => {
            let (target, span) = (target(model, card)?, card.lines[line].span);
            let layer = model.targets[target].layers.iter().position(|l| l.span == span)?;
            Some(Place::Thickness(target, layer))
        }
        ("DSLOAD" | "DLOAD", At::Parameter("FRICTION")) => {
            Some(Place::Friction(card.lines.first()?.span, card.lines.last()?.span))
        }
        ("CLOAD" | "DSLOAD" | "DLOAD", At::Field(line, 2)) if !card.has("AMPLITUDE") => {
            Some(Place::Magnitude(card.lines[line].span))
        }
        _ => None,
    }
}

/// Name of the material that a card belongs to, upper case.
fn material_above(deck: &Deck, card: usize) -> Option<String> {
    let above = deck.cards[..card].iter().rev().find(|c| c.keyword.name == "MATERIAL")?;
    Some(above.value("NAME")?.text.to_uppercase())
}

fn target(model: &Model, card: &Card) -> Option<usize> {
    model.targets.iter().position(|t| t.span == card.span)
}

/// Gives a number of the model another value; `false` where the deck could not have it, or where it changes what there is.
pub fn set(model: &mut Model, Revisable { place, allowed }: Revisable, value: f64) -> bool {
    if !allowed.allows(value) {
        return false;
    }
    match place {
        Place::Velocity(at) => match &mut model.initial_conditions[at].kind {
            InitialKind::Velocity(2, velocity) => *velocity = value,
            _ => return false,
        },
        Place::Mass(span) => {
            let mut points = model.discrete.masses.iter_mut().filter(|p| p.span == span).peekable();
            // One of zero is none.
            if points.peek().is_none() || value <= 0.0 {
                return false;
            }
            points.for_each(|point| point.mass = value);
        }
        Place::Density(at) => {
            if model.materials[at].density.replace(value).is_none() {
                return false;
            }
        }
        Place::Resistance(at, part) => {
            let Some(law) = &mut model.materials[at].cavity else { return false };
            *[&mut law.yield_stress, &mut law.a, &mut law.b, &mut law.c][part] = value;
        }
        Place::Front(target) => model.targets[target].front = value,
        Place::Thickness(target, layer) => {
            model.targets[target].layers[layer].thickness = value;
        }
        Place::Friction(first, last) => {
            let lines = first.start..=last.start;
            let within = |span: Span| span.file == first.file && lines.contains(&span.start);
            let loads = model.steps.iter_mut().flat_map(|s| &mut s.loads).filter(|l| within(l.span));
            let mut given = false;
            for load in loads {
                if let LoadKind::Cavity { friction, .. } = &mut load.kind {
                    (*friction, given) = (value, true);
                }
            }
            return given;
        }
        Place::Magnitude(span) => {
            let loads = model.steps.iter_mut().flat_map(|s| &mut s.loads).filter(|l| l.span == span);
            let mut given = false;
            for load in loads {
                let constant = matches!(load.kind, LoadKind::Pressure(_) | LoadKind::Concentrated { .. })
                    || matches!(load.kind, LoadKind::Gravity { direction: [r, _], .. } if r == 0.0);
                if !constant || load.amplitude.is_some() {
                    return false;
                }
                (load.magnitude, given) = (value, true);
            }
            return given;
        }
    }
    true
}
