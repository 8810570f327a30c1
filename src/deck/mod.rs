//! From text to syntax tree: sources and spans, diagnostics, the keyword table, a parser that never fails.
//! Never here: physics.

#[macro_use] // `codes!`, for every folder with codes.
pub mod codes;
pub mod diagnostic;
pub mod expression;
pub mod files;
pub mod finding;
mod findings;
pub mod keywords;
mod lexer;
pub mod lists;
pub mod manual;
pub mod names;
pub mod number;
mod parameters;
mod parser;
mod printable;
pub mod read;
mod render;
pub mod rows;
pub mod rule;
pub mod source;
pub mod syntax;
pub mod table;
pub mod template;
pub mod value;
pub mod ways;

use std::path::Path;

pub use codes::{CODES, find_code};
pub use diagnostic::{Diagnostic, Diagnostics, Severity};
pub use finding::Finding;
pub use findings::tier_findings;
pub use parameters::{Definition, is_unresolved};
pub use printable::printable;
pub use source::{Sources, Span};
pub use syntax::{Card, DataLine, Deck, Parameter, Unread, Word};

/// A diagnostic code with its explanation, for `revolve explain`.
#[derive(Debug)]
pub struct Code {
    /// The stable code.
    pub code: &'static str,
    /// One line.
    pub title: &'static str,
    /// A few lines: what it means and what to do.
    pub text: &'static str,
}

/// Reads a deck file and everything it includes. Always returns a tree; what was wrong is in the diagnostics.
/// `overrides` are `--set NAME=VALUE` and take the place of `*PARAMETER` definitions of that name.
pub fn read(path: &Path, overrides: &[(String, String)]) -> (Deck, Diagnostics) {
    let mut parser = parser::Parser::new(overrides);
    parser.main_file(path);
    parser.finish()
}

/// The same from text already in memory; `name` stands for the file (used to look up includes beside it).
pub fn read_text(name: &str, text: &str, overrides: &[(String, String)]) -> (Deck, Diagnostics) {
    let mut parser = parser::Parser::new(overrides);
    parser.text(Path::new(name), source::normalise(text.to_owned()), None);
    parser.finish()
}
