//! Writes a deck with its refined or coarsened mesh listed node by node. All other cards keep their text, except words
//! that would refer to other nodes, elements or faces of the listed mesh.

pub(super) mod edits;
mod listing;
mod record;
mod text;

use super::types::Model;
use super::{coarsening, refinement};
use crate::deck::{Deck, Diagnostic, Diagnostics, MeshScaling};

/// Returns the text of a deck with its mesh listed, refined or coarsened as [`Deck::mesh_scaling`] requests. The text is
/// valid only if the diagnostics have no error.
pub fn write(deck: &Deck) -> (String, Diagnostics) {
    let (fine, diagnostics) = super::build(&Deck { mesh_scaling: None, refined_elements: None, ..deck.clone() });
    if diagnostics.has_errors() {
        return (String::new(), diagnostics);
    }
    let (mut builder, is_coarse) = match deck.mesh_scaling {
        Some(MeshScaling::Coarsen(factor)) => (coarsening::apply::read(deck, factor, &fine, true), true),
        Some(MeshScaling::Refine(factor)) => (refinement::apply::read(deck, factor, &fine, true), false),
        None => (refinement::apply::read(deck, 1, &fine, true), false),
    };
    let edits = *builder.context.scaling.edits.take().unwrap_or_default();
    let is_removed =
        builder.context.scaling.coarsened.as_ref().map_or_else(Vec::new, |merged| merged.is_removed.clone());
    let (model, mut diagnostics) = if is_coarse { coarsening::apply::finish(builder, &fine) } else { builder.finish() };
    moved_profiles(deck).for_each(|finding| diagnostics.push(finding));
    if diagnostics.has_errors() {
        return (String::new(), diagnostics);
    }
    let text = text::DeckWriter::new(deck, ListedMesh { model, edits, is_removed }).write();
    (text, diagnostics)
}

/// A mesh to be listed, and the changes of the deck.
struct ListedMesh {
    model: Model,
    edits: edits::DeckEdits,
    /// Whether a node belongs to no element of a coarsened mesh; empty for other meshes.
    is_removed: Vec<bool>,
}

/// Returns errors for analytical surfaces in parts with moved instances, because instances of a listed mesh are not
/// moved.
fn moved_profiles(deck: &Deck) -> impl Iterator<Item = Diagnostic> {
    let is_moved = |part: &str| {
        let mut instances = deck.cards.iter().filter(|card| card.keyword.name == "INSTANCE" && !card.lines.is_empty());
        instances.any(|card| card.value("PART").is_some_and(|word| word.is(part)))
    };
    let mut part: Option<&str> = None;
    deck.cards.iter().filter_map(move |card| {
        match card.keyword.name {
            "PART" => part = card.value("NAME").map(|name| name.text.as_str()),
            "END PART" => part = None,
            _ => {}
        }
        let is_profile = card.keyword.name == "RIGID SURFACE" || card.value("TYPE").is_some_and(|w| w.is("SEGMENTS"));
        let moved = part.filter(|part| is_profile && card.keyword.name.ends_with("SURFACE") && is_moved(part))?;
        let message =
            format!("the analytical surface of part {moved} cannot be written: an instance of the part is moved");
        let finding = Diagnostic::error("M192", message).at(card.span, "this surface");
        Some(finding.help("define the surface in the assembly, in the coordinates of the assembly"))
    })
}
