//! Why a sweep or a study cannot be made, or why one of its runs has no value.

use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::deck::{Diagnostic, Severity};
use crate::job::Prepared;
use crate::solve::Halt;

/// The reason, in the words that the program shows.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum StudyError {
    /// A setting that has no meaning, with the option that it belongs to.
    #[error("{0}")]
    Setting(String),
    /// An expression of a quantity that cannot be read, or that a run cannot answer.
    #[error("--quantity `{text}`{}: {message}", at.map_or(String::new(), |at| format!(", character {at}")))]
    Quantity {
        /// The expression as written.
        text: String,
        /// Character from 1 on at which it goes wrong, where that is known.
        at: Option<usize>,
        /// What is wrong.
        message: String,
    },
    /// A file of an option that cannot be read or used.
    #[error("{option} {}: {message}", path.display())]
    File {
        /// The option that names the file.
        option: &'static str,
        /// The file.
        path: PathBuf,
        /// What is wrong, with the line where there is one.
        message: String,
    },
    /// The deck or a user's file is refused.
    #[error("{text}")]
    Refused {
        /// Stable code of the first error.
        code: &'static str,
        /// All that was found.
        text: String,
    },
    /// A run halted.
    #[error("halted: {0}")]
    Halted(Halt),
    /// A run was over before what it is asked for had come to its end.
    #[error("{0}")]
    Unfinished(String),
    /// The settings give nothing that could be compared, or the values do not.
    #[error("{0}")]
    Comparison(String),
    /// Why a run of another process gave no result.
    #[error("{0}")]
    Reported(String),
    /// A chart that cannot be drawn.
    #[error("{0}")]
    Chart(String),
}

impl StudyError {
    pub(super) fn file(option: &'static str, path: &Path, message: String) -> StudyError {
        StudyError::File { option, path: path.to_owned(), message }
    }

    pub(super) fn quantity(text: &str, message: String) -> StudyError {
        StudyError::Quantity { text: text.into(), at: None, message }
    }

    /// The errors of a deck.
    pub fn refused(prepared: &Prepared) -> StudyError {
        let errors = |d: &&Diagnostic| d.severity == Severity::Error;
        let code = prepared.diagnostics.iter().find(errors).map_or("", |d| d.code);
        StudyError::Refused { code, text: prepared.diagnostics.render(&prepared.deck.sources) }
    }
}

/// The deck, or an error if it has some.
pub(super) fn accepted(prepared: Prepared) -> Result<Prepared, StudyError> {
    if prepared.diagnostics.has_errors() { Err(StudyError::refused(&prepared)) } else { Ok(prepared) }
}

impl From<Diagnostic> for StudyError {
    fn from(fault: Diagnostic) -> StudyError {
        StudyError::Refused { code: fault.code, text: fault.message }
    }
}
