//! `*ORIENTATION`: material directions of shell sections and of their layers, and of fibres in solid sections.
//!
//! The directions are those of ABAQUS (Analysis User's Guide, "Orientations"): the second data line names the local direction
//! closest to the normal of the shell, and an additional rotation about the normal. Direction 1 of the material is the
//! projection of the next local direction on the surface, before this rotation.

use super::context::Context;
use super::names::upper;
use crate::deck::table::materials as cards;
use crate::deck::{Card, DataLine, Deck, Diagnostic, Word};

/// Field of the angle or the orientation of a layer on a data line of `COMPOSITE`.
pub const ANGLE_FIELD: usize = 3;
/// Smallest cosine between a local direction and the meridian of a shell at which it has a projection.
const LEAST_PROJECTION: f64 = 1e-3;
/// Numbers of the first data line: two points and the origin.
const COORDINATES: usize = 9;

/// Notes orientations that no section uses.
pub fn read_orientation(context: &mut Context<'_>, card: &Card) {
    let Some(name) = context.required(card, "NAME").map(|word| upper(&word.text)) else { return };
    let is_name = |word: &Word| upper(&word.text) == name;
    let uses = |section: &Card| {
        let of_layers = section.lines.iter().filter_map(|line| line.field(ANGLE_FIELD));
        section.value("ORIENTATION").into_iter().chain(of_layers).any(is_name)
    };
    let is_section = |section: &Card| matches!(section.keyword.name, "SHELL SECTION" | "SOLID SECTION");
    if !context.deck.cards.iter().any(|section| is_section(section) && uses(section)) {
        context.inert(card, "no section uses it");
    }
}

/// Returns the directions of fibres that a solid section names: unit vectors along r, z and hoop. Other orientations of solids
/// are not read.
pub fn section_fibres(context: &mut Context<'_>, section: &Card) -> Option<Vec<[f64; 3]>> {
    let has_fibres = |card: &Card| card.value("LOCAL DIRECTIONS").is_some();
    let Some(word) = section.value("ORIENTATION").filter(|_| orientations(context.deck).any(has_fibres)) else {
        return Some(Vec::new());
    };
    let card = orientation_named(context, section, word)?;
    let cards::Orientation { families, .. } = card.values();
    if families == 0 {
        return Some(Vec::new());
    }
    let directions = rectangular_directions(context, card)?;
    let lines = card.lines.get(2..).unwrap_or_default();
    if lines.len() != families {
        let found = lines.len();
        let message = format!(
            "LOCAL DIRECTIONS={families}, but {found} lines follow that of the axis and angle of rotation; each has one direction"
        );
        return context.refuse_value(card.span, message);
    }
    let rotation = axis_and_angle(context, card)?;
    lines.iter().map(|line| fibre(context, line, directions, rotation)).collect()
}

/// Reports sections that lack directions of the fibres of their material.
pub fn check_fibres(context: &mut Context<'_>) {
    let model = &context.model;
    let missing = model.sections.iter().filter_map(|section| {
        let material = &model.materials[section.material];
        let (families, found) = (material.user.energy?.families, section.fibres.len());
        let message = format!(
            "material `{}` has {families} families of fibres, but the *ORIENTATION of its section gives {found}",
            material.name
        );
        let label = format!("ORIENTATION= with LOCAL DIRECTIONS={families} is missing");
        (found < families).then(|| Diagnostic::error("M101", message).at(section.span, label))
    });
    let missing: Vec<Diagnostic> = missing.collect();
    missing.into_iter().for_each(|diagnostic| context.diagnostics.push(diagnostic));
}

/// Reads a direction of fibres. The local directions are rotated about the direction `axis`.
fn fibre(
    context: &mut Context<'_>,
    line: &DataLine,
    [first, second]: [[f64; 2]; 2],
    (axis, degrees): (usize, f64),
) -> Option<[f64; 3]> {
    let parts = context.numbers_or::<3>(line, 0, 0.0)?;
    let length = libm::sqrt(parts.iter().map(|part| part * part).sum());
    if !(length > 0.0 && length.is_finite()) {
        return context.refuse_value(line.span, "a direction of fibres needs a component that is not 0");
    }
    let (sine, cosine) = libm::sincos(degrees.to_radians());
    let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut local = parts.map(|part| part / length);
    (local[next], local[last]) = (cosine * local[next] - sine * local[last], sine * local[next] + cosine * local[last]);
    let [along_r, along_z] = [0, 1].map(|i| local[0] * first[i] + local[1] * second[i]);
    Some([along_r, along_z, local[2]])
}

/// Returns the angle in degrees from the meridian of shell elements to direction 1 of the orientation that a word of a section
/// names.
pub fn shell_angle(context: &mut Context<'_>, section: &Card, word: &Word, elements: &[usize]) -> Option<f64> {
    let card = orientation_named(context, section, word)?;
    let [first, second] = rectangular_directions(context, card)?;
    let (axis, turn) = axis_and_angle(context, card)?;
    let direction = match axis {
        0 => second,
        // The third local direction is the hoop.
        1 => return Some(90.0 + turn),
        _ => first,
    };
    check_projection(context, word, direction, elements)?;
    Some(turn)
}

/// Returns the local directions 1 and 2 of a supported orientation.
fn rectangular_directions(context: &mut Context<'_>, card: &Card) -> Option<[[f64; 2]; 2]> {
    let cards::Orientation { system, definition, .. } = card.values();
    if system != 0 || definition != 0 {
        let message = "orientations have SYSTEM=RECTANGULAR and DEFINITION=COORDINATES";
        return context.refuse_unsupported(card.span, message, "give the local directions 1 and 2 by two points");
    }
    local_directions(context, card)
}

/// Returns the local direction of the second line, from 0, and the angle in degrees.
fn axis_and_angle(context: &mut Context<'_>, card: &Card) -> Option<(usize, f64)> {
    let Some(line) = card.lines.get(1) else { return Some((0, 0.0)) };
    let (axis, turn) = (context.number_or(line, 0, 1.0)?, context.number_or(line, 1, 0.0)?);
    match [1.0, 2.0, 3.0].iter().position(|known| *known == axis) {
        Some(axis) => Some((axis, turn)),
        None => context.refuse_value(line.span, format!("a local direction is 1, 2 or 3, found {axis}")),
    }
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
