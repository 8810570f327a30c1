//! Warnings of checks of values.

use crate::deck::{Diagnostic, Span};
use crate::plan::Report;

/// An implausible value.
pub struct Finding {
    /// Code of the warning.
    pub code: &'static str,
    /// What is implausible, with the value.
    pub message: String,
    /// How to correct it.
    pub help: &'static str,
}

/// Adds a warning with its place, the label of the place and advice.
pub fn warn_about(code: &'static str, message: String, (span, label): (Span, &str), help: &str, report: &mut Report) {
    report.push(Diagnostic::warning(code, message).at(span, label).help(help));
}
