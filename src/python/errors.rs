//! Creation of the exceptions in `revolve._errors`, with diagnostics as JSON.

use pyo3::prelude::*;
use revolve::deck::{Diagnostic, Diagnostics, Sources};
use revolve::job::JobError;
use revolve::study::StudyError;

/// Creates an exception of the package from its class name, a message and diagnostics as JSON.
fn raise(py: Python<'_>, class: &str, message: &str, findings: &str) -> PyErr {
    let made = py.import("revolve._errors").and_then(|m| m.getattr(class)).and_then(|c| c.call1((message, findings)));
    made.map_or_else(|failed| failed, PyErr::from_value)
}

/// Creates the exception for errors of a deck or a user subroutine file.
pub fn refused(py: Python<'_>, found: &Diagnostics, sources: &Sources) -> PyErr {
    let findings = serde_json::to_string(&found.findings(sources)).unwrap_or_default();
    raise(py, "DeckError", found.render(sources).trim_end(), &findings)
}

/// Creates the exception for a single diagnostic.
pub fn finding(py: Python<'_>, finding: Diagnostic) -> PyErr {
    refused(py, &Diagnostics::from_iter([finding]), &Sources::default())
}

/// Creates the exception for an error of a study or an evaluation.
pub fn study(py: Python<'_>, why: &StudyError) -> PyErr {
    let class = if let StudyError::Refused { .. } = why { "DeckError" } else { "StudyError" };
    raise(py, class, why.to_string().trim_end(), "[]")
}

/// Creates the exception for an error that prevents a job from starting.
pub fn refusal(py: Python<'_>, why: JobError) -> PyErr {
    match why {
        JobError::Folder(error) => error.into(),
        JobError::Checkpoint(found) => finding(py, *found),
    }
}

/// Creates the exception for a file that cannot be read, `FileNotFoundError` if it does not exist.
pub fn unreadable(name: &str, why: &std::io::Error) -> PyErr {
    std::io::Error::new(why.kind(), format!("cannot read {name}: {why}")).into()
}

/// Creates a `ValueError` for an invalid setting.
pub fn setting(why: String) -> PyErr {
    pyo3::exceptions::PyValueError::new_err(why)
}
