//! `*ORIENTATION`: material directions of shell sections and of their layers.
//!
//! The directions are those of ABAQUS (Analysis User's Guide, "Orientations"): the second data line names the local direction
//! closest to the normal of the shell, and an additional rotation about the normal. Direction 1 of the material is the
//! projection of the next local direction on the surface, before this rotation.

use super::context::Context;
use super::names::upper;
use crate::deck::table::materials as cards;
use crate::deck::{Card, Deck, Diagnostic, Word};

/// Smallest cosine between a local direction and the meridian of a shell at which it has a projection.
const LEAST_PROJECTION: f64 = 1e-3;
/// Numbers of the first data line: two points and the origin.
const COORDINATES: usize = 9;

/// Notes orientations that no shell section uses.
pub fn read_orientation(context: &mut Context<'_>, card: &Card) {
    let Some(name) = context.required(card, "NAME").map(|word| upper(&word.text)) else { return };
    let is_name = |word: &Word| upper(&word.text) == name;
    let uses = |section: &Card| {
        let of_layers = section.lines.iter().filter_map(|line| line.field(super::shells::ANGLE_FIELD));
        section.value("ORIENTATION").into_iter().chain(of_layers).any(is_name)
    };
    if !context.deck.cards.iter().any(|section| section.keyword.name == "SHELL SECTION" && uses(section)) {
        context.inert(card, "only shell sections have directions: built-in materials of solid elements are isotropic");
    }
}

/// Returns the angle in degrees from the meridian of shell elements to direction 1 of the orientation that a word of a section
/// names.
pub fn shell_angle(context: &mut Context<'_>, section: &Card, word: &Word, elements: &[usize]) -> Option<f64> {
    let card = orientation_named(context, section, word)?;
    let cards::Orientation { system, definition } = card.values();
    if system != 0 || definition != 0 {
        let message = "orientations of shells have SYSTEM=RECTANGULAR and DEFINITION=COORDINATES";
        return context.refuse_unsupported(card.span, message, "give the local directions 1 and 2 by two points");
    }
    let [first, second] = local_directions(context, card)?;
    let (axis, turn) = match card.lines.get(1) {
        Some(line) => (context.number_or(line, 0, 1.0)?, context.number_or(line, 1, 0.0)?),
        None => (1.0, 0.0),
    };
    let direction = if axis == 1.0 {
        second
    } else if axis == 2.0 {
        // The third local direction is the hoop.
        return Some(90.0 + turn);
    } else if axis == 3.0 {
        first
    } else {
        return context.refuse_value(card.lines[1].span, format!("a local direction is 1, 2 or 3, found {axis}"));
    };
    check_projection(context, word, direction, elements)?;
    Some(turn)
}

/// Returns the orientation with the name of a word: the one in the part of the section if there are several.
fn orientation_named<'d>(context: &mut Context<'d>, section: &Card, word: &Word) -> Option<&'d Card> {
    let (deck, name) = (context.deck, upper(&word.text));
    let named = |card: &Card| card.value("NAME").is_some_and(|known| upper(&known.text) == name);
    let mut found: Vec<&Card> = orientations(deck).filter(|card| named(card)).collect();
    if found.len() > 1 {
        found.retain(|card| part_of(deck, card) == part_of(deck, section));
    }
    if let [card] = found[..] {
        return Some(card);
    }
    let names =
        |_: &Context<'_>| orientations(deck).filter_map(|card| Some(card.value("NAME")?.text.clone())).collect();
    context.unknown("M114", "orientation", word, names);
    None
}

fn orientations(deck: &Deck) -> impl Iterator<Item = &Card> {
    deck.cards.iter().filter(|card| card.keyword.name == "ORIENTATION")
}

/// Returns the number of parts that begin before a card, and whether it is in a part.
fn part_of(deck: &Deck, card: &Card) -> (usize, bool) {
    let before = deck.cards.iter().take_while(|other| !std::ptr::eq(*other, card));
    before.fold((0, false), |(count, inside), other| match other.keyword.name {
        "PART" => (count + 1, true),
        "END PART" => (count, false),
        _ => (count, inside),
    })
}

/// Returns the local directions 1 and 2, which are in the r-z plane.
fn local_directions(context: &mut Context<'_>, card: &Card) -> Option<[[f64; 2]; 2]> {
    let line = context.first_line(card)?;
    let [ar, az, a3, br, bz, b3, cr, cz, c3] = context.numbers_or::<COORDINATES>(line, 0, 0.0)?;
    let ([ar, az], [br, bz]) = ([ar - cr, az - cz], [br - cr, bz - cz]);
    let (length, across) = (libm::hypot(ar, az), ar * bz - az * br);
    if [a3, b3, c3] != [0.0; 3] || across == 0.0 || across.is_nan() {
        let message = "the local directions 1 and 2 must span the r-z plane: third coordinates are 0, and the two points \
                       are not on a line through the origin";
        return context.refuse_value(line.span, message);
    }
    let first = [ar / length, az / length];
    Some([first, [-first[1], first[0]].map(|part| part * across.signum())])
}

/// Reports a shell element to which a direction is normal.
fn check_projection(context: &mut Context<'_>, word: &Word, direction: [f64; 2], elements: &[usize]) -> Option<()> {
    let mesh = &context.model.mesh;
    let is_normal = |element: &&usize| {
        let [a, b] = [0, 1].map(|end| mesh.points[mesh.elements[**element].nodes[end]]);
        let along = [b[0] - a[0], b[1] - a[1]];
        let cosine = along[0] * direction[0] + along[1] * direction[1];
        cosine.abs() <= LEAST_PROJECTION * libm::hypot(along[0], along[1])
    };
    let Some(element) = elements.iter().find(is_normal) else { return Some(()) };
    let name = mesh.elements[*element].name.clone();
    let message = format!("orientation `{}` has no direction along shell element {name}", word.text);
    let finding = Diagnostic::error("M103", message).at(word.span, "its projected direction is normal to this element");
    context.diagnostics.push(finding.help(
        "the second data line of *ORIENTATION names the local direction closest to the normal; the next one is projected: \
         after 1 follows 2, after 2 the hoop, after 3 follows 1",
    ));
    None
}
