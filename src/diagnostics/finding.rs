//! Diagnostics as plain data, for result files and the library interface.

use serde::Serialize;

use crate::diagnostic::Diagnostics;
use crate::source::Sources;

/// A diagnostic with its place as text.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// `note`, `warning` or `error`.
    pub severity: &'static str,
    /// Code, for example `D101`.
    pub code: &'static str,
    /// One sentence that states the problem.
    pub message: String,
    /// `file:line`; `None` if the diagnostic has no place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub place: Option<String>,
    /// File, line and column.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub at: Option<FilePosition>,
    /// Suggested correction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub help: Option<String>,
}

/// Line and column in a named file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FilePosition {
    /// Name of the file.
    pub file: String,
    /// Line, counted from 1.
    pub line: usize,
    /// Column in characters, counted from 1.
    pub column: usize,
}

impl Diagnostics {
    /// Converts all diagnostics to plain data.
    pub fn findings(&self, sources: &Sources) -> Vec<Finding> {
        let finding = |d: &crate::Diagnostic| Finding {
            severity: d.severity.word(),
            code: d.code,
            message: d.message.clone(),
            place: d.labels.first().map(|label| sources.describe(label.span)),
            at: d.labels.first().and_then(|label| {
                let (line, column) = sources.line_column(label.span);
                sources.name(label.span).map(|file| FilePosition { file: file.to_owned(), line, column })
            }),
            help: d.help.clone(),
        };
        self.iter().map(|diagnostic| finding(&diagnostic.shown(sources))).collect()
    }
}
