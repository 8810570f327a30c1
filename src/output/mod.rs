//! Files: VTU frames in a PVD series, history CSV, summary JSON, checksums of them. One file per format; each appears whole or not at all.
//! Never here: decisions about physics.

pub mod checkpoint;
pub mod clock;
pub mod codes;
pub mod columns;
pub mod csv;
pub mod drawing;
pub mod history;
pub mod lock;
pub mod pvd;
#[cfg(feature = "cli")]
mod raster;
pub mod sums;
pub mod vtu;
pub mod whole;

use std::io;
use std::path::PathBuf;

use serde::Serialize;

pub use history::{ColumnSummary, History, HistorySummary};
pub use whole::{Whole, write_durable, write_whole};

/// Ending of the file with the histories.
pub const HISTORY: &str = "_history.csv";
/// Ending of the status file.
pub const STATUS: &str = ".sta";

/// An array over points or cells.
#[derive(Clone, Debug)]
pub struct Field {
    /// ABAQUS's name (`U`, `V`, `S`, …) or ours in upper case.
    pub name: String,
    /// Values per point or cell.
    pub components: usize,
    /// Names of the components (empty: none given).
    pub component_names: Vec<String>,
    /// Point- or cell-major.
    pub values: Vec<f64>,
}

/// The scene at one time.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// Total time.
    pub time: f64,
    /// Increment number.
    pub increment: u64,
    /// Current coordinates `[r, z]`.
    pub points: Vec<[f64; 2]>,
    /// Third coordinates of points, of bodies in space; empty where all lie in the plane of the mesh.
    pub third: Vec<f64>,
    /// The same at the start.
    pub third_at_start: Vec<f64>,
    /// Cells as point indices: 1 = vertex, 2 = line, 3 = triangle, 4 = quadrilateral.
    pub cells: Vec<Vec<usize>>,
    /// Whether what a cell stood for is deleted, for each cell; empty where none is.
    pub deleted: Vec<bool>,
    /// Arrays over points.
    pub point_fields: Vec<Field>,
    /// Arrays over cells.
    pub cell_fields: Vec<Field>,
    /// Coordinates `[r, z]` at the start.
    pub start: Vec<[f64; 2]>,
    /// What stays as it is over points.
    pub point_labels: Vec<Label>,
    /// What stays as it is over cells.
    pub cell_labels: Vec<Label>,
}

/// Whole numbers over points or cells by which they are found: the deck's numbers, materials, members of sets.
#[derive(Clone, Debug)]
pub struct Label {
    /// `NODE`, `ELEMENT`, `MATERIAL`, `NSET …` or `ELSET …`.
    pub name: String,
    /// One a point or cell.
    pub values: Vec<i32>,
}

impl Label {
    /// Whether an array of this name is one of labels.
    pub fn is_name(name: &str) -> bool {
        ["NODE", "ELEMENT", "MATERIAL"].contains(&name) || name.starts_with("NSET ") || name.starts_with("ELSET ")
    }
}

/// Where the points of frames are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Points {
    /// Where they are now.
    #[default]
    Current,
    /// Where they were at the start, with U beside them: what warps by it shows the motion, at any scale.
    Reference,
}

/// Where the files of a job go.
#[derive(Clone, Debug)]
pub struct Job {
    /// Folder.
    pub folder: PathBuf,
    /// Name: the deck's file name without ending.
    pub name: String,
}

impl Job {
    /// Path of one of the job's files: `<name><ending>`.
    pub fn path(&self, ending: &str) -> PathBuf {
        self.folder.join(format!("{}{ending}", self.name))
    }
}

/// Writes the summary as `<job>.json`; its checksum.
///
/// # Errors
/// Where the file cannot be written.
pub fn write_summary<T: Serialize>(job: &Job, summary: &T) -> io::Result<u32> {
    let mut text = serde_json::to_string_pretty(summary)?;
    text.push('\n');
    write_whole(&job.path(".json"), text.as_bytes())?;
    Ok(sums::sum(text.as_bytes()))
}

/// Writes files of a job, given by ending and bytes, and the list of their checksums with this ending.
///
/// # Errors
/// With the path in the message.
pub fn write_with_sums(job: &Job, files: &[(String, Vec<u8>)], list: &str) -> io::Result<()> {
    // None of these sums is that of a file before.
    whole::remove(&job.path(list))?;
    let mut sums = sums::Checksums::default();
    for (ending, bytes) in files {
        write_whole(&job.path(ending), bytes)?;
        sums.add(job, ending, bytes);
    }
    sums.write(job, list)
}
