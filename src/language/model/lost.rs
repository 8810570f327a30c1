//! Definitions that are missing because of errors: names, nodes and elements of cards that could not be read.
//! References to them are not reported again, so that one cause has one message.

use std::collections::HashSet;

use super::names::upper;
use crate::deck::{Card, Deck, Diagnostics, Span, Word};

/// Definitions that are missing because of reported errors.
#[derive(Debug, Default)]
pub struct MissingDefinitions {
    /// An included file is missing, which may have contained anything.
    pub everything: bool,
    /// Some nodes are missing.
    pub nodes: bool,
    /// Some elements are missing.
    pub elements: bool,
    /// Missing names of sets, surfaces, materials and so on, in upper case.
    names: HashSet<String>,
    /// Keywords of cards with a reported error.
    cards: HashSet<&'static str>,
    /// A definition of a body is missing: messages of the plan about bodies are not reliable.
    pub bodies: bool,
    /// Cards with a reported error.
    pub faulty: HashSet<Span>,
    /// Number of unknown names for which similar names were suggested.
    pub suggested: usize,
}

/// Cards that do not define bodies.
const LEAVES: &[&str] = &[
    "BOUNDARY",
    "CLOAD",
    "DLOAD",
    "DSLOAD",
    "OUTPUT",
    "NODE OUTPUT",
    "ELEMENT OUTPUT",
    "ENERGY OUTPUT",
    "INCREMENTATION OUTPUT",
    "RESTART",
    "TIME POINTS",
    "INITIAL CONDITIONS",
    "BULK VISCOSITY",
];

/// Cards that define a name by their parameter NAME.
const NAMED: &[&str] = &["MATERIAL", "SURFACE", "SURFACE INTERACTION", "SECTION CONTROLS", "AMPLITUDE"];

impl MissingDefinitions {
    /// Returns the definitions that the parser could not read.
    pub fn from_deck(deck: &Deck) -> MissingDefinitions {
        let unread = &deck.unread;
        // Cards before the definition may refer to a name that could not be read.
        let unnamed = |card: &Card| card.faulty && NAMED.contains(&card.keyword.name) && !card.has("NAME");
        MissingDefinitions {
            everything: unread.files || deck.cards.iter().any(unnamed),
            names: unread.names.iter().cloned().collect(),
            bodies: unread.files || unread.cards > 0,
            ..MissingDefinitions::default()
        }
    }

    /// Notes the definitions of a card with an error.
    pub fn note_faulty_card(&mut self, card: &Card) {
        let name = card.keyword.name;
        self.cards.insert(name);
        match name {
            "NODE" | "NGEN" | "NFILL" | "NCOPY" | "NMAP" | "SYSTEM" => self.nodes = true,
            "ELEMENT" | "ELGEN" | "ELCOPY" => self.elements = true,
            "MESH" => (self.nodes, self.elements) = (true, true),
            "PART" | "INSTANCE" => self.everything = true,
            _ => {}
        }
        self.bodies |= !LEAVES.contains(&name);
        for parameter in ["NAME", "NSET", "ELSET"] {
            let defines = parameter == "NAME"
                || matches!(name, "NODE" | "NGEN" | "NFILL" | "NSET" | "ELEMENT" | "ELGEN" | "ELSET");
            if let Some(word) = card.value(parameter).filter(|_| defines) {
                self.names.insert(upper(&word.text));
            }
        }
    }

    /// Returns whether a card with this keyword has a reported error, so that a card that follows it has no place.
    pub fn has_card(&self, keyword: &str) -> bool {
        self.cards.contains(keyword)
    }

    /// Returns whether a name or label may be missing because of a reported error.
    pub fn explains(&self, what: &str, word: &Word) -> bool {
        let last = upper(word.text.rsplit('.').next().unwrap_or(""));
        let label = last.parse::<i64>().is_ok();
        let labels = if what.starts_with("element") { self.elements } else { self.nodes };
        self.everything || crate::deck::is_unresolved(&word.text) || label && labels || self.names.contains(&last)
    }
}

/// Removes diagnostics that only follow from unsupported (plane or three-dimensional) element types.
pub fn drop_consequential_diagnostics(diagnostics: &mut Diagnostics) {
    const OTHER: &str = "this code is axisymmetric";
    if diagnostics.iter().any(|d| d.code == "M121" && d.message.ends_with(OTHER)) {
        diagnostics.retain(|d| {
            let third = d.code == "M104" && (d.message.starts_with("third ") || d.message.contains("cosine"));
            !(third || matches!(d.code, "M149" | "M141"))
        });
    }
}
