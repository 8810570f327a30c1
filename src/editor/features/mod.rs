//! What an editor asks about a place in a deck.

pub mod completion;
mod context;
mod facts;
pub mod folding;
pub mod format;
pub mod hints;
pub mod hover;
pub mod letter_case;
pub mod navigation;
pub mod symbols;
pub mod tokens;

pub use facts::DeckFacts;

use std::path::Path;

use crate::deck::Card;
use crate::deck::name_kinds::NameKind;
use crate::outline::{DeckOutline, NameUse};
use crate::text::{ColumnEncoding, TextBuffer, TextPosition, TextRange};

/// A deck as features see it: its outline, and the properties of its model.
pub struct DeckView<'a> {
    pub outline: &'a DeckOutline,
    /// Properties of the model at the last check without errors.
    pub facts: Option<&'a DeckFacts>,
}

/// A file, and the deck to which it belongs.
pub struct FeatureContext<'a> {
    pub text: &'a TextBuffer,
    /// Index of the file in the deck.
    pub file: u32,
    pub root: DeckView<'a>,
    pub encoding: ColumnEncoding,
}

impl FeatureContext<'_> {
    pub fn name_at(&self, position: TextPosition) -> Option<&NameUse> {
        let outline = self.root.outline;
        outline
            .names
            .iter()
            .filter(|one| one.span.file == self.file)
            .find(|one| outline.locate(one.span, self.encoding).is_some_and(|(_, range)| range.touches(position)))
    }

    /// Returns the value of a parameter; `None` for other names, and for texts.
    pub fn parameter_value(&self, one: &NameUse) -> Option<f64> {
        let parameters = self.root.outline.deck.parameters.iter().filter(|_| one.kind == NameKind::Parameter);
        parameters.filter(|(name, _)| *name == one.name).map(|(_, value)| *value).next()
    }

    /// Iterates over the cards of the file with their lines.
    pub fn cards(&self) -> impl Iterator<Item = (u32, &Card)> {
        let outline = self.root.outline;
        let of_file = outline.deck.cards.iter().filter(|card| card.span.file == self.file);
        of_file.filter_map(|card| Some((outline.line(card.span)?, card)))
    }

    /// Iterates over the files that the file includes, with the ranges of their names.
    pub fn included_files(&self) -> impl Iterator<Item = (&Path, TextRange)> {
        let outline = self.root.outline;
        let included = outline.deck.sources.files().iter().filter_map(|file| Some((file, file.included_at?)));
        let of_this_file = included.filter(|(_, span)| span.file == self.file);
        of_this_file.filter_map(|(file, span)| Some((file.path.as_path(), outline.locate(span, self.encoding)?.1)))
    }

    /// Returns the part in which a line is, in upper case; empty outside of parts.
    pub fn scope_at(&self, line: u32) -> String {
        let preceding_cards = self.cards().take_while(|(at, _)| *at <= line);
        preceding_cards.fold(String::new(), |scope, (_, card)| match card.keyword.name {
            "PART" => card.value("NAME").map_or(String::new(), |word| word.text.trim().to_uppercase()),
            "END PART" => String::new(),
            _ => scope,
        })
    }

    /// Returns the name of the first instance of a part.
    pub fn instance_of(&self, part: &str) -> Option<&str> {
        let mut instances = self.root.outline.deck.cards.iter().filter(|card| card.keyword.name == "INSTANCE");
        let instance = instances
            .find(|card| card.value("PART").is_some_and(|word| word.text.trim().eq_ignore_ascii_case(part)))?;
        instance.value("NAME").map(|word| word.text.trim()).filter(|_| !part.is_empty())
    }
}
