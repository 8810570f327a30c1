//! Warnings of checks of values.

use crate::deck::{Diagnostic, Span};
use crate::kernel::lists::sorted_unique;
use crate::model::{MaterialDefinition, Model};
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

/// Returns the materials of all sections, with their index.
pub fn used_materials(model: &Model) -> impl Iterator<Item = (usize, &MaterialDefinition)> {
    let used = sorted_unique(model.layer_regions().map(|region| region.0.index()));
    used.into_iter().filter_map(|index| Some((index, model.materials.get(index)?)))
}
