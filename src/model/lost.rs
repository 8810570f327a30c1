//! What errors have taken away: names, nodes and elements that are missing because a card could not be read. What misses them
//! says nothing more, so that one cause has one message.
//! Never here: the checks themselves.

use std::collections::HashSet;

use super::names::upper;
use crate::deck::{Card, Deck, Diagnostics, Word};

/// What is missing, as an error has told.
#[derive(Debug, Default)]
pub(super) struct Lost {
    /// A file: anything may have been in it.
    pub everything: bool,
    /// Some nodes.
    pub nodes: bool,
    /// Some elements.
    pub elements: bool,
    /// Names of sets, surfaces, materials and so on, upper case.
    names: HashSet<String>,
    /// Something that bodies are made of: what the plan would say of bodies cannot be trusted.
    pub bodies: bool,
}

/// Cards on which nothing hangs that bodies are made of.
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

impl Lost {
    /// What the deck room could not read.
    pub fn of(deck: &Deck) -> Lost {
        let unread = &deck.unread;
        Lost {
            everything: unread.files,
            names: unread.names.iter().cloned().collect(),
            bodies: unread.files || unread.cards > 0,
            ..Lost::default()
        }
    }

    /// What a card with an error would have defined.
    pub fn card(&mut self, card: &Card) {
        let name = card.keyword.name;
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

    /// Whether a name or label may be missing for an error that has been told.
    pub fn explains(&self, what: &str, word: &Word) -> bool {
        let last = upper(word.text.rsplit('.').next().unwrap_or(""));
        let label = last.parse::<i64>().is_ok();
        let labels = if what.starts_with("element") { self.elements } else { self.nodes };
        self.everything || crate::deck::is_unresolved(&word.text) || label && labels || self.names.contains(&last)
    }
}

/// Whether a card with a fault that has been told is left alone: what else is wrong with it would follow from that. Blocks and
/// what lists single items are read all the same, for much hangs on them.
pub(super) fn is_skipped(card: &Card) -> bool {
    const READ: &[&str] = &[
        "HEADING",
        "PART",
        "END PART",
        "ASSEMBLY",
        "END ASSEMBLY",
        "INSTANCE",
        "END INSTANCE",
        "STEP",
        "END STEP",
        "MATERIAL",
        "OUTPUT",
        "NODE",
        "NGEN",
        "NFILL",
        "ELEMENT",
        "ELGEN",
        "NSET",
        "ELSET",
        "SURFACE",
        "SURFACE INTERACTION",
        "SECTION CONTROLS",
        "BOUNDARY",
        "RIGID BODY",
        "ATTITUDE",
        "ROTARY INERTIA",
        "SOLID SECTION",
        "SHELL SECTION",
    ];
    !READ.contains(&card.keyword.name)
}

/// Drops what is said only because a deck is of another geometry than a body of revolution: that has been told.
pub(super) fn drop_what_follows(diagnostics: &mut Diagnostics) {
    const OTHER: &str = "this code is axisymmetric";
    if diagnostics.iter().any(|d| d.code == "M121" && d.message.ends_with(OTHER)) {
        diagnostics.retain(|d| {
            let third = d.code == "M104" && (d.message.starts_with("third ") || d.message.contains("cosine"));
            !(third || matches!(d.code, "M149" | "M141"))
        });
    }
}
