//! A diagnostic in words alone, as results carry it when the sources are gone.
//! Never here: how a terminal shows it.

use serde::Serialize;

use super::diagnostic::{Diagnostics, Severity};
use super::source::Sources;

/// One finding with its place as text.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// `note`, `warning` or `error`.
    pub severity: &'static str,
    /// Stable code.
    pub code: &'static str,
    /// What is wrong.
    pub message: String,
    /// `file:line`, where it has a place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub place: Option<String>,
    /// File, line and column of it, counted from 1.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub at: Option<At>,
    /// What would be right.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub help: Option<String>,
}

/// A place in a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct At {
    /// The file, as it was named.
    pub file: String,
    /// Line.
    pub line: usize,
    /// Column, in letters.
    pub column: usize,
}

impl Diagnostics {
    /// All findings as plain words.
    pub fn findings(&self, sources: &Sources) -> Vec<Finding> {
        let finding = |d: &super::Diagnostic| Finding {
            severity: match d.severity {
                Severity::Note => "note",
                Severity::Warning => "warning",
                Severity::Error => "error",
            },
            code: d.code,
            message: d.message.clone(),
            place: d.labels.first().map(|label| sources.describe(label.span)),
            at: d.labels.first().and_then(|label| {
                let (line, column) = sources.line_column(label.span);
                sources.name(label.span).map(|file| At { file: file.to_owned(), line, column })
            }),
            help: d.help.clone(),
        };
        self.iter().map(finding).collect()
    }
}
