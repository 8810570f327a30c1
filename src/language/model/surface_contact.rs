//! Surfaces and options of the pairs of `*CONTACT PAIR`.

use super::contact;
use super::context::Context;
use super::families::StepReader;
use super::names::upper;
use super::types::{AnalyticalSide, InteractionLaw, PrescribedClearance, SideSelection, SurfaceContact};
use crate::deck::{Card, DataLine, Diagnostic, Word};

/// Adds or deletes a pair of element-based surfaces.
pub fn surface_pair(
    context: &mut Context<'_>,
    steps: &mut StepReader,
    card: &Card,
    line: &DataLine,
    words: [&Word; 2],
) {
    let Some(first) = contact_sides(context, words[0]) else { return };
    let Some(second) = contact_sides(context, words[1]) else { return };
    for a in first.one_sided() {
        if first.name == second.name {
            add_pair(context, steps, card, line, [a.clone(), a], None);
            continue;
        }
        for b in second.one_sided() {
            add_pair(context, steps, card, line, [a.clone(), b], None);
        }
    }
}

/// Adds or deletes a contact pair; one surface may be analytical.
pub fn add_pair(
    context: &mut Context<'_>,
    steps: &mut StepReader,
    card: &Card,
    line: &DataLine,
    sides: [SideSelection; 2],
    analytical: Option<AnalyticalSide>,
) {
    let clearance = match card.value("ADJUST") {
        None => None,
        Some(word) => {
            let Some(fits) = adjust(context, word) else { return };
            Some(PrescribedClearance { gap: 0.0, above: Some(fits), below: Some(0.0) })
        }
    };
    let penalty = card.read::<bool>("MECHANICAL CONSTRAINT").then_some(1.0);
    let same = |c: &SurfaceContact| {
        let names = [&c.sides[0].name, &c.sides[1].name];
        names == [&sides[0].name, &sides[1].name] || names == [&sides[1].name, &sides[0].name]
    };
    warn_of_pair_given_twice(context, steps, line, same);
    let pairs = &mut steps.state().surface_contacts;
    let count_before = pairs.len();
    // A redefined pair replaces the earlier one.
    pairs.retain(|c| !same(c));
    if !card.read::<bool>("OP") {
        if pairs.len() == count_before {
            context.error("M114", "the contact pair to delete does not exist", line.span, "not in force here");
        }
        return;
    }
    let weight = card.read::<f64>("WEIGHT");
    let interaction = card.value("INTERACTION").and_then(|word| contact::interaction(context, word));
    steps.state().surface_contacts.push(SurfaceContact {
        sides,
        analytical,
        general: false,
        no_thickness: card.has("NO THICKNESS"),
        clearance,
        penalty,
        secondary: [(0.0, 0), (1.0, 1)].into_iter().find(|w| w.0 == weight).map(|w| w.1),
        cpset: card.value("CPSET").map(|w| upper(&w.text)),
        interaction,
        law: InteractionLaw::default(),
        span: line.span,
    });
}

/// Warns of a pair that an earlier line of the same step, or before the steps, has defined.
fn warn_of_pair_given_twice(
    context: &mut Context<'_>,
    steps: &mut StepReader,
    line: &DataLine,
    same: impl Fn(&SurfaceContact) -> bool,
) {
    let begin = steps.current.as_ref().map_or(0, |step| step.span.start);
    let known = steps.state().surface_contacts.iter().find(|pair| same(pair)).map(|pair| pair.span);
    let Some(earlier) = known.filter(|span| span.start > begin && span.file == line.span.file) else { return };
    let message = "this contact pair is defined twice; the second definition replaces the first";
    let diagnostic = Diagnostic::warning("M160", message).at(line.span, "second definition");
    context.diagnostics.push(diagnostic.at(earlier, "first definition"));
}

/// Returns the faces of an element-based surface.
pub fn contact_sides(context: &mut Context<'_>, word: &Word) -> Option<SideSelection> {
    if context.names_of(word).iter().any(|n| context.model.surfaces.nodes.contains_key(n)) {
        let message = format!("`{}` is a node-based surface, which can only contact analytical surfaces", word.text);
        return context.refuse_unsupported(word.span, message, "use an element-based surface");
    }
    let id = context.surface_id(word)?;
    let faces = context.model.surfaces.faces[id].faces.clone();
    if faces.is_empty() {
        if context.missing.explains("surface", word) {
            return None;
        }
        return context.refuse_value(word.span, format!("surface `{}` has no faces", word.text));
    }
    let name = context.model.surfaces.name(id).to_owned();
    Some(SideSelection { name, surface: true, faces, free_face_elements: Vec::new() })
}

/// Returns the largest initial gap that `ADJUST` closes.
fn adjust(context: &mut Context<'_>, word: &Word) -> Option<f64> {
    let Some(value) = word.text.trim().parse::<f64>().ok() else {
        let help = "give the largest gap to be closed";
        return context.refuse_unsupported(word.span, "ADJUST with a node set is not supported", help);
    };
    if value >= 0.0 && value.is_finite() {
        return Some(value);
    }
    context.refuse_value(word.span, format!("ADJUST must be a gap that is not negative, found {value}"))
}
