//! `revolve report`: one self-contained HTML page for the runs, sweeps and studies found in a folder.
//!
//! The folder is read into [`data::Page`], which the page carries as JSON; `page.js` draws it. Nothing is fetched:
//! style, script and numbers are in the file, and a content security policy forbids the rest.

mod balance;
mod compare;
pub mod data;
mod find;
mod frames;
mod history;
mod html;
mod labels;
mod limits;
mod mesh;
pub mod picture;
mod study;
mod sweep;
mod units;

use std::path::{Path, PathBuf};

use thiserror::Error;

pub use find::page as gather_with;
pub use frames::{BYTES, CELLS, FRAMES};
pub use html::html;
pub use labels::Labels;

use crate::study::table::rounded;

/// Why a folder of results gives no page or picture: what is missing or cannot be read, with the file.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct ReportError(String);

impl From<String> for ReportError {
    fn from(reason: String) -> ReportError {
        ReportError(reason)
    }
}

/// Options of a page or a chart.
#[derive(Clone, Debug, Default)]
pub struct PageOptions {
    /// Names of quantities.
    pub labels: Labels,
    /// A CSV file with curves that histories are compared with.
    pub compare: Option<PathBuf>,
}

/// Reads the results in a folder.
pub fn gather(folder: &Path) -> Result<data::Page, ReportError> {
    gather_with(folder, &PageOptions::default())
}

/// Six significant digits: what a chart can show, in the fewest characters.
fn shorten(value: f64) -> f64 {
    rounded(value, 6)
}
