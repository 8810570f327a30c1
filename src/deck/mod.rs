//! From text to syntax tree: sources and spans, diagnostics, the keyword table, a parser that never fails.
//! Never here: physics.

pub mod codes;
pub mod diagnostic;
pub mod expression;
pub mod keywords;
pub mod manual;
pub mod number;
mod parser;
pub mod source;
pub mod syntax;

use std::path::{Path, PathBuf};

pub use codes::Code;
pub use diagnostic::{Diagnostic, Diagnostics, Severity};
use keywords::Tier;
pub use source::{Sources, Span};
pub use syntax::{Card, DataLine, Deck, Parameter, Word};

/// Reads a deck file and everything it includes. Always returns a tree; what was wrong is in the diagnostics.
/// `overrides` are `--set NAME=VALUE` and take the place of `*PARAMETER` definitions of that name.
pub fn read(path: &Path, overrides: &[(String, String)]) -> (Deck, Diagnostics) {
    match std::fs::read(path) {
        Ok(bytes) => parse(path, parser::decode(&bytes), overrides),
        Err(e) => {
            let mut diagnostics = Diagnostics::default();
            let reason = parser::plain_error(&e);
            diagnostics.push(Diagnostic::error("D100", format!("cannot read the deck {}: {reason}", path.display())));
            (Deck::default(), diagnostics)
        }
    }
}

/// The same from text already in memory; `name` stands for the file, and includes are looked up beside it.
pub fn read_text(name: &str, text: &str, overrides: &[(String, String)]) -> (Deck, Diagnostics) {
    parse(Path::new(name), parser::decode(text.as_bytes()), overrides)
}

fn parse(path: &Path, text: String, overrides: &[(String, String)]) -> (Deck, Diagnostics) {
    let mut parser = parser::Parser::new(overrides);
    parser.file(path.display().to_string(), PathBuf::from(path), text, None);
    let (deck, mut diagnostics) = parser.finish();
    tier_findings(&deck, &mut diagnostics);
    (deck, diagnostics)
}

/// What is said of cards that are known and not used: an error where leaving them out would change the physics, one
/// note for all that only change output files.
fn tier_findings(deck: &Deck, diagnostics: &mut Diagnostics) {
    let mut output_only: Vec<&Card> = Vec::new();
    for card in &deck.cards {
        let name = card.keyword.name;
        match card.keyword.tier {
            Tier::UnsupportedPhysics => {
                let message = format!("*{name} is known, but not supported; without it the physics would change");
                diagnostics.push(Diagnostic::error("D120", message).at(card.span, "not supported"));
            }
            Tier::UnsupportedInert => {
                let message = format!("*{name} is not supported and changes no result here");
                diagnostics.push(Diagnostic::note("D121", message).at(card.span, "left out"));
            }
            Tier::OutputOnly => output_only.push(card),
            Tier::Used | Tier::Parsed => {}
        }
    }
    if let Some(first) = output_only.first() {
        let mut names: Vec<String> =
            output_only.iter().map(|c| format!("*{} ({})", c.keyword.name, deck.sources.describe(c.span))).collect();
        names.dedup();
        let message = format!("accepted without effect, they concern other programs' output: {}", names.join(", "));
        diagnostics.push(Diagnostic::note("D122", message).at(first.span, "the first of them"));
    }
}
