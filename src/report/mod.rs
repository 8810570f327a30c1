//! `revolve report`: one self-contained HTML page for the runs, sweeps and studies found in a folder.
//! Never here: solving, printing, what a terminal shows.
//!
//! The folder is read into [`data::Page`], which the page carries as JSON; `page.js` draws it. Nothing is fetched:
//! style, script and numbers are in the file, and a content security policy forbids the rest.

mod balance;
mod compare;
pub mod data;
mod error;
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

pub use error::ReportError;
pub use frames::{BYTES, CELLS, FRAMES};
pub use html::html;
pub use labels::Labels;

/// What is asked of a page or a chart beside what a folder holds.
#[derive(Clone, Debug, Default)]
pub struct Asked {
    /// Names of quantities.
    pub labels: Labels,
    /// A CSV file with curves that histories are compared with.
    pub compare: Option<PathBuf>,
}

/// Reads what a folder holds.
///
/// # Errors
/// No such folder, nothing in it that a report knows, or a file that cannot be read.
pub fn gather(folder: &Path) -> Result<data::Page, ReportError> {
    gather_with(folder, &Asked::default())
}

/// The same, with names for quantities and curves to compare with.
///
/// # Errors
/// Those of [`gather`], and what is asked of it that is not there.
pub fn gather_with(folder: &Path, asked: &Asked) -> Result<data::Page, ReportError> {
    find::page(folder, asked).map_err(|reason| ReportError::of(folder, reason))
}

/// Six significant digits: what a chart can show, in the fewest characters.
fn shorten(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}
