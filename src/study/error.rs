//! Why a sweep or a study cannot be made, or why one of its runs has no value.
//! Never here: printing.

use std::path::PathBuf;

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
    /// A table of references that cannot be read.
    #[error("--compare {}: {message}", path.display())]
    Reference {
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
    /// A table of shots that cannot be read.
    #[error("--shots {}: {message}", path.display())]
    Shots {
        /// The file.
        path: PathBuf,
        /// What is wrong, with the line where there is one.
        message: String,
    },
    /// The settings give nothing that could be compared, or the values do not.
    #[error("{0}")]
    Comparison(String),
    /// What a part of a sweep that ran elsewhere tells of a run without result.
    #[error("{0}")]
    Told(String),
    /// A file of Dakota's that cannot be followed.
    #[error("--dakota {}: {message}", path.display())]
    Dakota {
        /// The file.
        path: PathBuf,
        /// What is wrong, with the line where there is one.
        message: String,
    },
    /// A chart that cannot be drawn.
    #[error("{0}")]
    Chart(String),
}

impl StudyError {
    pub(super) fn quantity(text: &str, message: String) -> StudyError {
        StudyError::Quantity { text: text.into(), at: None, message }
    }

    /// What is wrong with a deck that has errors.
    pub fn refused(prepared: &Prepared) -> StudyError {
        let errors = |d: &&Diagnostic| d.severity == Severity::Error;
        let first = prepared.diagnostics.iter().find(errors).map_or("", |d| d.code);
        let text = prepared.diagnostics.render(&prepared.deck.sources);
        StudyError::Refused { code: first, text }
    }
}

impl From<Diagnostic> for StudyError {
    fn from(fault: Diagnostic) -> StudyError {
        StudyError::Refused { code: fault.code, text: fault.message }
    }
}
