//! Input decks: source files, spans, lexer, parser, keyword table and diagnostics. The result of reading is a syntax
//! tree ([`Deck`]); names are resolved and physics is checked in `model`.

pub mod codes;
pub mod expression;
mod findings;
mod fractions;
pub mod keywords;
pub mod lexer;
pub mod lines;
pub mod manual;
pub mod name_kinds;
mod parameters;
mod parser;
pub mod read;
pub mod rows;
pub mod rule;
pub mod syntax;
pub mod table;
pub mod template;
pub mod value;
pub mod ways;

use std::path::Path;

pub use codes::{CODES, find_code};
pub use findings::tier_findings;
pub use parameters::{
    CURVE_SETTING, MESH_SETTINGS, ParameterDefinition, ParameterReference, is_name as is_parameter_name, is_unresolved,
    next_reference,
};
pub use revolve_diagnostics::{
    Correction, Diagnostic, DiagnosticCode, Diagnostics, Finding, OpenTexts, Severity, Sources, Span, printable,
    shortened,
};
pub use revolve_diagnostics::{
    codes_with_effects, diagnostic, digest, files, finding, lists, number, source, untrusted, verdict,
};
pub use revolve_numerics::names;
pub use syntax::{Card, DataLine, Deck, MeshScaling, Parameter, ParseGaps, Word};

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

/// Reads a deck whose files are open in an editor. `text` is that of the deck, `path` its file; the text of an included
/// file is that of `open_texts`, if there is one, in place of the file on disk.
pub fn read_open(path: &Path, text: String, open_texts: &OpenTexts<'_>) -> (Deck, Diagnostics) {
    let mut parser = parser::Parser::new(&[], open_texts);
    parser.text(path, source::normalise(text), None);
    parser.finish()
}
