//! Errors of sweeps, studies and their runs.

use std::path::{Path, PathBuf};

use thiserror::Error;

use super::chart::ChartError;
use crate::deck::{Diagnostic, Severity};
use crate::job::PreparedJob;
use crate::solve::HaltReason;

/// Error of a sweep, a study or one of its runs; its text is shown to the user.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum StudyError {
    /// An invalid setting; the text names the option.
    #[error("{0}")]
    Setting(String),
    /// An invalid expression of a quantity, or one that cannot be evaluated for a run.
    #[error("--quantity `{text}`{}: {message}", at.map_or(String::new(), |at| format!(", character {at}")))]
    Quantity {
        /// The expression as written.
        text: String,
        /// Position of the error in characters, from 1, if known.
        at: Option<usize>,
        /// Description of the error.
        message: String,
    },
    /// A file named by an option that cannot be read or used.
    #[error("{option} {}: {message}", path.display())]
    File {
        /// The option that names the file.
        option: &'static str,
        /// Path of the file.
        path: PathBuf,
        /// Description of the error, with the line where there is one.
        message: String,
    },
    /// Errors of the deck or of a user subroutine file.
    #[error("{text}")]
    Refused {
        /// Stable code of the first error.
        code: &'static str,
        /// All diagnostics with their locations, as shown on the terminal.
        text: String,
    },
    /// A run halted before the end of its last step.
    #[error("halted: {0}")]
    Halted(HaltReason),
    /// A shot failed.
    #[error("the shot at {velocity} failed: {reason}")]
    Shot {
        /// Striking velocity.
        velocity: f64,
        /// Error of its run.
        reason: Box<StudyError>,
    },
    /// The settings or the values allow no comparison.
    #[error("{0}")]
    Comparison(String),
    /// Error of a run in another process.
    #[error("{0}")]
    Reported(String),
    /// A chart that cannot be drawn.
    #[error("{0}")]
    Chart(String),
}

impl From<ChartError> for StudyError {
    fn from(error: ChartError) -> StudyError {
        StudyError::Chart(error.0)
    }
}

impl StudyError {
    pub(super) fn file(option: &'static str, path: &Path, message: String) -> StudyError {
        StudyError::File { option, path: path.to_owned(), message }
    }

    pub(super) fn quantity(text: &str, message: String) -> StudyError {
        StudyError::Quantity { text: text.into(), at: None, message }
    }

    /// Creates the error from the diagnostics of a deck.
    pub fn refused(prepared: &PreparedJob) -> StudyError {
        let errors = |d: &&Diagnostic| d.severity == Severity::Error;
        let code = prepared.diagnostics.iter().find(errors).map_or("", |d| d.code);
        StudyError::Refused { code, text: prepared.diagnostics.render(&prepared.deck.sources) }
    }
}

/// Returns the prepared deck, or its errors.
pub(super) fn accepted(prepared: PreparedJob) -> Result<PreparedJob, StudyError> {
    if prepared.diagnostics.has_errors() { Err(StudyError::refused(&prepared)) } else { Ok(prepared) }
}

impl From<Diagnostic> for StudyError {
    fn from(fault: Diagnostic) -> StudyError {
        StudyError::Refused { code: fault.code, text: fault.message }
    }
}
