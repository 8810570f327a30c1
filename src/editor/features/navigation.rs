//! Definitions, uses and renaming of names, across the files of a deck.

use std::path::PathBuf;

use super::FeatureContext;
use crate::deck::is_parameter_name;
use crate::deck::name_kinds::NameKind;
use crate::text::{TextPosition, TextRange};

#[derive(PartialEq, Eq)]
pub struct NamePlace {
    pub path: PathBuf,
    pub range: TextRange,
    /// Whether the name is defined there.
    pub defines: bool,
}

/// Returns all places of the name at a position, in the order of the deck.
pub fn places_of_name(context: &FeatureContext<'_>, position: TextPosition) -> Vec<NamePlace> {
    let Some(one) = context.name_at(position) else { return Vec::new() };
    let outline = &context.root.outline;
    let located = outline.names.same_as(one).filter_map(|u| {
        let (path, range) = outline.locate(u.span, context.encoding)?;
        Some(NamePlace { path: path.to_owned(), range, defines: u.defines })
    });
    // A file that is included twice has the same place twice.
    let mut places: Vec<NamePlace> = Vec::new();
    for place in located {
        if !places.contains(&place) {
            places.push(place);
        }
    }
    places
}

/// Returns the range and text of the name at a position, if it can be renamed.
pub fn renamed_word(context: &FeatureContext<'_>, position: TextPosition) -> Option<(TextRange, String)> {
    let name_use = context.name_at(position)?;
    let outline = &context.root.outline;
    let (_, range) = outline.locate(name_use.span, context.encoding)?;
    Some((range, outline.deck.sources.text(name_use.span).to_owned()))
}

/// Returns the reason why a text cannot be the name of something; `None` for a name.
pub fn invalid_name(kind: NameKind, name: &str) -> Option<&'static str> {
    let name = name.trim();
    if kind == NameKind::Parameter && !is_parameter_name(name) {
        return Some("the name of a parameter consists of letters, digits and `_`, and does not begin with a digit");
    }
    if name.is_empty() {
        return Some("a name must not be empty");
    }
    if name.contains([',', '=', '"', '<', '>', '\n', '\r']) {
        return Some("a name must not contain commas, equals signs, quotes, angle brackets or line breaks");
    }
    if name.starts_with('*') {
        return Some("a name must not begin with a star");
    }
    name.parse::<f64>().is_ok().then_some("a number is read as a label, not as a name")
}
