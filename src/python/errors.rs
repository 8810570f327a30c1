//! Exceptions: those of `revolve._errors`, with findings as JSON.
//! Never here: what is wrong.

use pyo3::prelude::*;
use revolve::deck::{Diagnostic, Diagnostics, Sources};
use revolve::job::Refusal;
use revolve::study::StudyError;

/// An exception of the package by its name, made of a message and of findings as JSON.
fn raise(py: Python<'_>, class: &str, message: &str, findings: &str) -> PyErr {
    let made = py.import("revolve._errors").and_then(|m| m.getattr(class)).and_then(|c| c.call1((message, findings)));
    made.map_or_else(|failed| failed, PyErr::from_value)
}

/// What is wrong with a deck or a user's file.
pub fn refused(py: Python<'_>, found: &Diagnostics, sources: &Sources) -> PyErr {
    let findings = serde_json::to_string(&found.findings(sources)).unwrap_or_default();
    raise(py, "DeckError", found.render(sources).trim_end(), &findings)
}

/// The same of one finding.
pub fn finding(py: Python<'_>, finding: Diagnostic) -> PyErr {
    let mut found = Diagnostics::default();
    found.push(finding);
    refused(py, &found, &Sources::default())
}

/// What is wrong with a study or an evaluation.
pub fn study(py: Python<'_>, why: &StudyError) -> PyErr {
    let class = if let StudyError::Refused { .. } = why { "DeckError" } else { "StudyError" };
    raise(py, class, why.to_string().trim_end(), "[]")
}

/// Why a job does not begin.
pub fn refusal(py: Python<'_>, why: Refusal) -> PyErr {
    match why {
        Refusal::Folder(error) => error.into(),
        Refusal::Checkpoint(found) => finding(py, *found),
    }
}

/// A setting that has no meaning.
pub fn setting(why: String) -> PyErr {
    pyo3::exceptions::PyValueError::new_err(why)
}
