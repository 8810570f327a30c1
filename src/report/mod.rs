//! `revolve report`: one self-contained HTML page for the runs, sweeps and studies found in a folder.
//! Never here: solving, printing, what a terminal shows.
//!
//! The folder is read into [`data::Page`], which the page carries as JSON; `page.js` draws it. Nothing is fetched:
//! style, script and numbers are in the file, and a content security policy forbids the rest.

pub mod data;
mod error;
mod find;
mod frames;
mod history;
mod html;
mod mesh;
pub mod picture;
mod study;
mod sweep;
mod units;

use std::path::Path;

pub use error::ReportError;
pub use frames::{BYTES, CELLS, FRAMES};
pub use html::html;

/// Reads what a folder holds.
///
/// # Errors
/// No such folder, nothing in it that a report knows, or a file that cannot be read.
pub fn gather(folder: &Path) -> Result<data::Page, ReportError> {
    find::page(folder).map_err(|reason| ReportError::of(folder, reason))
}

/// Six significant digits: what a chart can show, in the fewest characters.
fn shorten(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}
