//! `revolve report`: one self-contained HTML page for the runs, sweeps, studies and searches in a folder.
//!
//! The folder is read into [`data::ReportPage`], which is embedded as JSON and drawn by `page.js`. Style, script and
//! data are in the file; a content security policy forbids loading anything else.

mod balance;
mod compare;
pub mod data;
pub mod filter;
mod find;
#[cfg(feature = "cli")]
pub(crate) mod fragments;
pub(crate) mod frame_mesh;
pub(crate) mod frames;
mod history;
mod html;
mod labels;
pub(crate) mod limits;
pub mod meridian;
mod mesh;
mod pack;
pub mod picture;
mod read;
mod search;
mod study;
mod sweep;
pub(crate) mod units;

use std::path::{Path, PathBuf};

use thiserror::Error;

pub use find::page as gather_with;
pub(crate) use find::{only_run, run_without_frames};
pub use html::html;
pub(crate) use html::{PageContents, SHARED_SCRIPT, STYLE};
pub use labels::QuantityLabels;
pub use mesh::CELLS;
pub use pack::{BYTES, FRAMES};

use crate::study::table::rounded;

/// Error of a report or picture: a file that is missing or cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct ReportError(String);

impl From<String> for ReportError {
    fn from(reason: String) -> ReportError {
        ReportError(reason)
    }
}

/// Options of a report page or a chart.
#[derive(Clone, Debug, Default)]
pub struct PageOptions {
    /// Labels shown in place of the names of quantities.
    pub labels: QuantityLabels,
    /// CSV file with reference curves for histories.
    pub compare: Option<PathBuf>,
}

/// Reads the results in a folder.
pub fn gather(folder: &Path) -> Result<data::ReportPage, ReportError> {
    gather_with(folder, &PageOptions::default())
}

/// Rounds to six significant digits, enough for a chart.
fn shorten(value: f64) -> f64 {
    rounded(value, 6)
}
