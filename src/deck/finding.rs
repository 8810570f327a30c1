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
    /// What would be right.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub help: Option<String>,
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
            help: d.help.clone(),
        };
        self.iter().map(finding).collect()
    }
}
