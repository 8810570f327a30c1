//! Why a folder of results gives no page and no picture.
//! Never here: printing.

use std::path::{Path, PathBuf};

use thiserror::Error;

/// The reason, in the words that the program shows.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{reason}")]
pub struct ReportError {
    /// The folder of results.
    pub folder: PathBuf,
    /// What is missing or cannot be read, with the file.
    pub reason: String,
}

impl ReportError {
    pub(super) fn of(folder: &Path, reason: String) -> ReportError {
        ReportError { folder: folder.to_owned(), reason }
    }
}
