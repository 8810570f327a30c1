//! Input decks: source files, spans, lexer, parser, keyword table and diagnostics. The result of reading is a syntax
//! tree ([`Deck`]); names are resolved and physics is checked in `model`.

#[macro_use] // Exports `codes!` to the other folders that define codes.
pub mod codes;
pub mod diagnostic;
pub mod expression;
pub mod files;
pub mod finding;
mod findings;
mod fractions;
pub mod keywords;
pub mod lexer;
pub mod lines;
pub mod lists;
pub mod manual;
pub mod name_kinds;
pub use revolve_numerics::names;
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
pub mod untrusted;
pub mod value;
pub mod ways;

use std::path::Path;

pub use codes::{CODES, find_code};
pub use diagnostic::{Correction, Diagnostic, Diagnostics, Severity};
pub use finding::Finding;
pub use findings::tier_findings;
pub use parameters::{
    CURVE_SETTING, MESH_SETTINGS, ParameterDefinition, is_name as is_parameter_name, is_unresolved, next_reference,
};
pub use printable::printable;
pub use source::{Sources, Span};
pub use syntax::{Card, DataLine, Deck, MeshScaling, Parameter, ParseGaps, Word};

/// Explanation of a diagnostic code, as `revolve explain CODE` prints it.
#[derive(Debug)]
pub struct DiagnosticCode {
    /// The code, for example `D101`; it does not change between versions.
    pub code: &'static str,
    /// Description in one line.
    pub title: &'static str,
    /// Cause of the diagnostic and how to fix the deck.
    pub text: &'static str,
}

/// Reads a deck file and the files that it includes. Returns a tree even if the deck has errors, which are in the
/// diagnostics. `overrides` are pairs (name, expression) of `--set NAME=VALUE`; each replaces the `*PARAMETER`
/// definition of that name. Without such a definition, `mesh` divides each edge of the mesh into that number of parts,
/// and `mesh=1/N` merges N edges.
pub fn read(path: &Path, overrides: &[(String, String)]) -> (Deck, Diagnostics) {
    let mut parser = parser::Parser::new(overrides, &|_| None);
    parser.main_file(path);
    parser.finish()
}

/// Reads a deck from `text`. `name` is the file name in messages; `*INCLUDE` paths are relative to its folder.
pub fn read_text(name: &str, text: &str, overrides: &[(String, String)]) -> (Deck, Diagnostics) {
    let mut parser = parser::Parser::new(overrides, &|_| None);
    parser.text(Path::new(name), source::normalise(text.to_owned()), None);
    parser.finish()
}

/// Returns the text of a file that is open in an editor; `None` for a file that is read from disk.
pub type OpenTexts<'a> = dyn Fn(&Path) -> Option<String> + 'a;

/// Reads a deck whose files are open in an editor. `text` is that of the deck, `path` its file; the text of an included
/// file is that of `open_texts`, if there is one, in place of the file on disk.
pub fn read_open(path: &Path, text: String, open_texts: &OpenTexts<'_>) -> (Deck, Diagnostics) {
    let mut parser = parser::Parser::new(&[], open_texts);
    parser.text(path, source::normalise(text), None);
    parser.finish()
}
