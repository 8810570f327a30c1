//! Files: VTU/PVD frames, history CSV, summary JSON. One file per format.
//! Never here: decisions about physics.

use std::io;
use std::path::{Path, PathBuf};

use serde::Serialize;

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
    /// Cells as point indices: 2 = line, 3 = triangle, 4 = quad, 1 = vertex.
    pub cells: Vec<Vec<usize>>,
    /// Arrays over points.
    pub point_fields: Vec<Field>,
    /// Arrays over cells.
    pub cell_fields: Vec<Field>,
}

/// History samples: one row a time.
#[derive(Clone, Debug, Default)]
pub struct History {
    /// Column names without time (`U2@REF`, `ALLKE`).
    pub columns: Vec<String>,
    /// Total time of each row.
    pub times: Vec<f64>,
    /// Row-major values.
    pub rows: Vec<Vec<f64>>,
}

/// Where the files of a job go.
#[derive(Clone, Debug)]
pub struct Job {
    /// Folder.
    pub folder: PathBuf,
    /// Name: the deck's file name without ending.
    pub name: String,
}

/// Writes bytes so that the file is there whole or not at all (temporary file beside it, then rename).
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let _ = (path, bytes);
    todo!("the output room")
}

/// Serialises the summary into `<job>.json`.
pub fn write_summary<T: Serialize>(job: &Job, summary: &T) -> io::Result<()> {
    let _ = (job, summary);
    todo!("the output room")
}
