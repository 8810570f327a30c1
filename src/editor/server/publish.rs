//! Diagnostics of a deck as the protocol sends them, by file, with levels that depend on the kind of the deck.

use std::path::{Path, PathBuf};

use crate::deck::{Deck, Diagnostic, Diagnostics, Severity, Sources};
use crate::outline::{DeckOutline, range_of_span};
use crate::protocol::{DiagnosticLevel, DocumentDiagnostic, FileLocation, RelatedPlace, ServerMode, TextEdit};
use crate::text::{ColumnEncoding, TextRange};

/// A diagnostic with its place in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileDiagnostic {
    pub path: PathBuf,
    pub range: TextRange,
    /// Level, as `revolve check` prints it.
    pub severity: Severity,
    pub code: &'static str,
    /// Problem, reason and correction in words.
    pub message: String,
    pub related: Vec<RelatedText>,
    pub correction: Option<TextEdit>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RelatedText {
    pub path: PathBuf,
    pub range: TextRange,
    pub text: String,
}

impl FileDiagnostic {
    /// Returns whether reading the deck gives the diagnostic, without its model.
    pub fn is_of_syntax(&self) -> bool {
        self.code.starts_with('D') && !self.code.starts_with("D3")
    }

    /// Returns the diagnostic of a check that failed.
    pub fn internal_error(root: &Path) -> FileDiagnostic {
        FileDiagnostic {
            path: root.to_owned(),
            range: TextRange::default(),
            severity: Severity::Error,
            code: "",
            message: "the check of this deck failed inside the program; please report it".into(),
            related: Vec::new(),
            correction: None,
        }
    }

    /// Returns whether the deck has physics or a dimension that Revolve does not have.
    fn shows_other_analysis(&self) -> bool {
        // Nodes in space.
        matches!(self.code, "D201" | "M121") || self.code == "M104" && self.message.starts_with("third coordinate")
    }

    /// Converts the diagnostic for the client.
    pub fn document(&self, level: DiagnosticLevel, uri: &dyn Fn(&Path) -> String) -> DocumentDiagnostic {
        let related = self.related.iter().map(|related| RelatedPlace {
            location: FileLocation { uri: uri(&related.path), range: related.range },
            message: related.text.clone(),
        });
        DocumentDiagnostic {
            range: self.range,
            severity: level,
            code: self.code,
            source: "revolve",
            message: self.message.clone(),
            related_information: related.collect(),
        }
    }

    /// Returns the level that the client shows. In a deck for another analysis of ABAQUS only mistakes that are
    /// mistakes in each deck remain errors. User subroutines are given to a run, not in the deck.
    pub fn level(&self, mode: ServerMode, is_foreign: bool) -> DiagnosticLevel {
        let level = match self.severity {
            Severity::Error => DiagnosticLevel::Error,
            Severity::Warning => DiagnosticLevel::Warning,
            Severity::Note => DiagnosticLevel::Information,
        };
        match self.code {
            "P004" if mode != ServerMode::Revolve => DiagnosticLevel::Information,
            _ if !is_foreign => level,
            "D002" | "D003" | "D004" | "D005" | "D006" | "D007" | "D105" | "D106" | "D107" | "D108" | "D302"
            | "D303" | "D401" | "D402" | "D404" => level,
            // A name that is nearly right is probably a mistake.
            "D101" | "D103" if self.correction.is_some() => DiagnosticLevel::Warning,
            "D201" | "M104" | "M121" => DiagnosticLevel::Hint,
            _ => DiagnosticLevel::Information,
        }
    }
}

/// Returns whether a deck is for another analysis of ABAQUS than Revolve has: it has unsupported cards, element types
/// or options.
pub fn is_foreign(mode: ServerMode, diagnostics: &[FileDiagnostic]) -> bool {
    match mode {
        ServerMode::Revolve => false,
        ServerMode::Abaqus => true,
        ServerMode::Auto => diagnostics.iter().any(FileDiagnostic::shows_other_analysis),
    }
}

/// Converts the diagnostics of a check.
pub fn file_diagnostics(deck: &Deck, diagnostics: &Diagnostics, encoding: ColumnEncoding) -> Vec<FileDiagnostic> {
    let sources = &deck.sources;
    let locate = |span| {
        let range = range_of_span(sources, span, encoding)?;
        Some((sources.file(span)?.path.clone(), range))
    };
    converted(deck, diagnostics, &locate)
}

/// Converts the diagnostics of the syntax of an outline.
pub fn outline_diagnostics(outline: &DeckOutline, encoding: ColumnEncoding) -> Vec<FileDiagnostic> {
    let locate = |span| outline.locate(span, encoding).map(|(path, range)| (path.to_owned(), range));
    let mut merged = outline.diagnostics.clone();
    merged.merge_repeats();
    converted(&outline.deck, &merged, &locate)
}

type SpanLocator<'a> = dyn Fn(crate::deck::Span) -> Option<(PathBuf, TextRange)> + 'a;

fn converted(deck: &Deck, diagnostics: &Diagnostics, locate: &SpanLocator<'_>) -> Vec<FileDiagnostic> {
    diagnostics.iter().map(|diagnostic| file_diagnostic(&deck.sources, diagnostic, locate)).collect()
}

fn file_diagnostic(sources: &Sources, diagnostic: &Diagnostic, locate: &SpanLocator<'_>) -> FileDiagnostic {
    let main = || sources.files().first().map_or_else(PathBuf::new, |file| file.path.clone());
    let mut places = diagnostic.labels.iter().map(|label| (locate(label.span), label.text.clone()));
    let (main_place, label) = places.next().unwrap_or_default();
    let (path, range) = main_place.unwrap_or_else(|| (main(), TextRange::default()));
    let mut message = diagnostic.message.clone();
    if !label.is_empty() {
        message += &format!("\n{label}");
    }
    if let Some(help) = &diagnostic.help {
        message += &format!("\nhelp: {help}");
    }
    message += &format!("\n`revolve explain {}` explains this message", diagnostic.code);
    let related =
        places.filter_map(|(place, text)| place.map(|(path, range)| RelatedText { path, range, text })).collect();
    let correction = diagnostic
        .correction(sources)
        .and_then(|correction| Some(TextEdit { range: locate(correction.span)?.1, new_text: correction.text }));
    FileDiagnostic { path, range, severity: diagnostic.severity, code: diagnostic.code, message, related, correction }
}
