//! Result files: VTU frames in a PVD series, history CSV, summary JSON and checksums, one module per format. Each file
//! is written atomically. Drawings become SVG and PNG pictures and animations. The public interface is in the crate
//! `revolve`, as module `output`.
#![forbid(unsafe_code)]
#![warn(missing_docs)]
// Links to private items serve readers of the sources.
#![allow(rustdoc::private_intra_doc_links)]

#[cfg(feature = "cli")]
pub mod animation;
#[cfg(feature = "cli")]
pub mod axis;
pub mod chart;
#[cfg(feature = "cli")]
mod chart_drawing;
pub mod checkpoint;
pub mod clock;
pub mod codes;
pub mod columns;
pub mod csv;
pub mod drawing;
mod hdf5;
pub mod history;
pub mod lock;
pub mod pvd;
#[cfg(feature = "cli")]
mod raster;
pub mod sums;
pub mod table;
pub mod vtkhdf;
pub mod vtu;

use std::borrow::Cow;
use std::io;
use std::ops::Index;
use std::path::PathBuf;

use serde::Serialize;

pub use history::{ColumnSummary, HistorySummary, RunHistory};
pub use revolve_diagnostics::whole::{self, AtomicFile, unnamed_file, write_durable, write_whole};

/// Suffix of the history file.
pub const HISTORY: &str = "_history.csv";
/// Suffix of the status file.
pub const STATUS: &str = ".sta";
/// Suffix of the archive with copies of the files that a run has read.
pub const INPUT: &str = ".input.tar";
/// Suffix of the file with all frames in the format VTKHDF.
pub const VTKHDF: &str = ".vtkhdf";
/// Suffix of the file with the setup of a run, which exists until the summary is written.
pub const SETUP: &str = ".setup";

/// An array over points or cells.
#[derive(Clone, Debug)]
pub struct FieldArray {
    /// Name in ABAQUS (`U`, `V`, `S`, …), or an extension in upper case.
    pub name: String,
    /// Values per point or cell.
    pub components: usize,
    /// Names of the components; may be empty.
    pub component_names: Vec<String>,
    /// Values of all components of the first point or cell, then of the next.
    pub values: Vec<f64>,
}

/// Model at one time: geometry and fields.
#[derive(Clone, Debug, Default)]
pub struct OutputFrame {
    /// Total time of the frame.
    pub time: f64,
    /// Number of completed increments at the time of the frame.
    pub increment: u64,
    /// Current coordinates `[r, z]` of points.
    pub points: Vec<[f64; 2]>,
    /// Third coordinates of points, for bodies with six degrees of freedom; empty if all points are in the plane of the
    /// mesh.
    pub third: Vec<f64>,
    /// Initial third coordinates; empty likewise.
    pub third_at_start: Vec<f64>,
    /// Cells as point indices: 1 = vertex, 2 = line, 3 = triangle, 4 = quadrilateral.
    pub cells: CellList,
    /// Whether the element of each cell is deleted; empty if none is.
    pub deleted: Vec<bool>,
    /// Arrays with one value or vector per point.
    pub point_fields: Vec<FieldArray>,
    /// Arrays with one value or vector per cell.
    pub cell_fields: Vec<FieldArray>,
    /// Initial coordinates `[r, z]` of points.
    pub start: Vec<[f64; 2]>,
    /// Labels of points, constant over time.
    pub point_labels: Vec<EntityLabels>,
    /// Labels of cells, constant over time.
    pub cell_labels: Vec<EntityLabels>,
}

impl FieldArray {
    /// Returns whether the components are those of a symmetric tensor: rr, zz, hoop, rz.
    pub fn is_tensor(&self) -> bool {
        self.components == 4 && self.component_names.last().is_some_and(|name| name.ends_with("12"))
    }

    /// Returns the number of components in VTK files. Vectors in the plane have a third component there, and symmetric
    /// tensors the two components that are zero in a body of revolution. VTK's filters then recognise both: XX, YY, ZZ,
    /// XY, YZ, XZ.
    pub fn components_in_space(&self) -> usize {
        match self.components {
            4 if self.is_tensor() => 6,
            2 => 3,
            count => count,
        }
    }

    /// Returns the values with [`FieldArray::components_in_space`].
    pub fn values_in_space(&self) -> impl Iterator<Item = f64> {
        let more = self.components_in_space() - self.components;
        let groups = self.values.chunks_exact(self.components.max(1));
        groups.flat_map(move |group| group.iter().copied().chain(std::iter::repeat_n(0.0, more)))
    }
}

impl OutputFrame {
    /// Returns three coordinates of each point: r becomes x, z becomes y, and direction 3 becomes z.
    pub fn coordinates(&self, points: FramePoints) -> impl Iterator<Item = f64> {
        let (places, third) = match points {
            FramePoints::Current => (&self.points, &self.third),
            FramePoints::Reference => (&self.start, &self.third_at_start),
        };
        places.iter().enumerate().flat_map(|(i, p)| [p[0], p[1], third.get(i).copied().unwrap_or(0.0)])
    }

    /// Returns the displacements of all points as the array U.
    pub fn displacement(&self) -> FieldArray {
        let third = |i: usize| Some(self.third.get(i)? - self.third_at_start.get(i)?);
        let pairs = self.points.iter().zip(&self.start).enumerate();
        let moved = pairs.flat_map(|(i, (p, q))| [p[0] - q[0], p[1] - q[1]].into_iter().chain(third(i)));
        let components = if self.third.is_empty() { 2 } else { 3 };
        let component_names = (1..=components).map(|i| format!("U{i}")).collect();
        FieldArray { name: "U".into(), components, component_names, values: moved.collect() }
    }

    /// Returns the frame without the cells of deleted elements, as it is written: filters of VTK that average, measure or
    /// bound cells count hidden ones.
    pub fn without_deleted(&self) -> Cow<'_, OutputFrame> {
        if self.deleted.is_empty() {
            return Cow::Borrowed(self);
        }
        let mut frame = self.clone();
        let deleted = std::mem::take(&mut frame.deleted);
        frame.remove_cells(&deleted);
        Cow::Owned(frame)
    }

    /// Removes cells, and the points that belonged to these only, with their values and labels.
    fn remove_cells(&mut self, is_removed: &[bool]) {
        let mut keeps_point = vec![true; self.points.len()];
        for keeps in [false, true] {
            let cells = self.cells.iter().zip(is_removed).filter(|(_, is_removed)| **is_removed != keeps);
            cells.flat_map(|(cell, _)| cell).for_each(|&point| keeps_point[point as usize] = keeps);
        }
        let keeps_cell: Vec<bool> = is_removed.iter().map(|is_removed| !is_removed).collect();
        let mut new_index = vec![0; self.points.len()];
        for (new, (index, _)) in new_index.iter_mut().zip(&keeps_point).filter(|(_, keeps)| **keeps).enumerate() {
            *index = new;
        }
        let cells = self.cells.iter().zip(&keeps_cell).filter(|(_, keeps)| **keeps);
        self.cells = cells.map(|(cell, _)| cell.iter().map(|&point| new_index[point as usize]).collect()).collect();
        retain(&mut self.points, 1, &keeps_point);
        retain(&mut self.start, 1, &keeps_point);
        retain(&mut self.third, 1, &keeps_point);
        retain(&mut self.third_at_start, 1, &keeps_point);
        for (fields, labels, keeps) in [
            (&mut self.point_fields, &mut self.point_labels, &keeps_point),
            (&mut self.cell_fields, &mut self.cell_labels, &keeps_cell),
        ] {
            fields.iter_mut().for_each(|field| retain(&mut field.values, field.components, keeps));
            labels.iter_mut().for_each(|label| retain(&mut label.values, 1, keeps));
        }
    }
}

/// Retains the groups of `width` values that `keeps` marks; an empty list stays empty.
fn retain<T>(values: &mut Vec<T>, width: usize, keeps: &[bool]) {
    let mut index = 0;
    values.retain(|_| {
        index += 1;
        keeps[(index - 1) / width]
    });
}

/// VTK's order of the points of a six-node triangle, corners first, as indices around the boundary.
const QUADRATIC: [usize; 6] = [0, 2, 4, 1, 3, 5];
/// Order of the points of other cells.
const IN_ORDER: [usize; 4] = [0, 1, 2, 3];

/// Point indices of cells, in one list.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CellList {
    corners: Vec<u32>,
    /// End of each cell in `corners`.
    ends: Vec<u32>,
}

impl CellList {
    /// Creates an empty list with memory for a number of quadrilaterals.
    pub fn with_capacity(count: usize) -> CellList {
        CellList { corners: Vec::with_capacity(4 * count), ends: Vec::with_capacity(count) }
    }

    /// Adds a cell.
    pub fn push(&mut self, corners: impl IntoIterator<Item = usize>) {
        self.corners.extend(corners.into_iter().map(|point| point as u32));
        self.ends.push(self.corners.len() as u32);
    }

    /// Returns the number of cells.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Returns whether there are no cells.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Iterates over the point indices of each cell.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> + Clone {
        (0..self.len()).map(|cell| &self[cell])
    }

    /// Returns the point indices of all cells in VTK's order.
    pub fn vtk_connectivity(&self) -> impl Iterator<Item = i64> {
        self.iter().flat_map(|cell| {
            let order = if cell.len() == QUADRATIC.len() { &QUADRATIC[..] } else { &IN_ORDER[..cell.len()] };
            order.iter().map(move |&i| i64::from(cell[i]))
        })
    }

    /// Returns the start of each cell in the connectivity, and its length.
    pub fn vtk_offsets(&self) -> impl Iterator<Item = i64> {
        [0].into_iter().chain(self.ends.iter().map(|&end| i64::from(end)))
    }

    /// Returns VTK's number of the type of each cell.
    pub fn vtk_types(&self) -> impl Iterator<Item = u8> {
        let linear = |count: usize| [1, 3, 5, 9][count.clamp(1, 4) - 1];
        self.iter().map(move |cell| if cell.len() == QUADRATIC.len() { 22 } else { linear(cell.len()) })
    }

    /// Returns the point indices of all cells.
    pub fn corners(&self) -> &[u32] {
        &self.corners
    }
}

impl Index<usize> for CellList {
    type Output = [u32];

    fn index(&self, cell: usize) -> &[u32] {
        let start = cell.checked_sub(1).map_or(0, |previous| self.ends[previous]);
        &self.corners[start as usize..self.ends[cell] as usize]
    }
}

impl FromIterator<Vec<usize>> for CellList {
    fn from_iter<I: IntoIterator<Item = Vec<usize>>>(cells: I) -> CellList {
        let mut list = CellList::default();
        cells.into_iter().for_each(|cell| list.push(cell));
        list
    }
}

/// Integer labels of points or cells: node and element numbers of the deck, materials, members of sets.
#[derive(Clone, Debug)]
pub struct EntityLabels {
    /// `NODE`, `ELEMENT`, `MATERIAL`, `NSET_…` or `ELSET_…`. Frames of earlier versions have a blank in place of `_`.
    pub name: String,
    /// One value for each point or cell.
    pub values: Vec<i32>,
}

impl EntityLabels {
    /// Returns whether this is the name of a label array.
    pub fn is_name(name: &str) -> bool {
        ["NODE", "ELEMENT", "MATERIAL"].contains(&name) || name.starts_with("NSET") || name.starts_with("ELSET")
    }
}

/// Point coordinates written to frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum FramePoints {
    /// Current coordinates.
    #[default]
    Current,
    /// Initial coordinates, with U as an array: Warp By Vector in ParaView shows the motion at any scale.
    Reference,
}

/// Files to which frames are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum FrameFormat {
    /// One `.vtu` file per frame, and a `.pvd` file that lists them.
    #[default]
    Pvd,
    /// One `.vtkhdf` file with all frames.
    Vtkhdf,
}

impl FrameFormat {
    /// Returns the suffix of the file to open in ParaView.
    pub fn suffix(self) -> &'static str {
        match self {
            FrameFormat::Pvd => ".pvd",
            FrameFormat::Vtkhdf => VTKHDF,
        }
    }
}

/// Coordinates and files of frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameStyle {
    /// Coordinates of points.
    pub points: FramePoints,
    /// Files.
    pub format: FrameFormat,
}

/// Folder and name of a job's files.
#[derive(Clone, Debug)]
pub struct JobFiles {
    /// Folder to which the results are written.
    pub folder: PathBuf,
    /// Name: the file name of the deck without its suffix.
    pub name: String,
}

impl JobFiles {
    /// Returns the path of one of the job's files: `<name><ending>`.
    pub fn path(&self, ending: &str) -> PathBuf {
        self.folder.join(format!("{}{ending}", self.name))
    }
}

/// Writes the list of checksums and then the summary `<job>.json`: a summary exists only if all other files are complete.
///
/// # Errors
/// If a file cannot be written; the message contains the path.
pub fn write_summary<T: Serialize>(job: &JobFiles, summary: &T, mut sums: sums::Checksums) -> io::Result<()> {
    let mut text = serde_json::to_string_pretty(summary)?;
    text.push('\n');
    sums.add(job, ".json", text.as_bytes());
    sums.write(job, sums::SUMS)?;
    write_whole(&job.path(".json"), text.as_bytes())
}

/// Writes files of a job, given by suffix and bytes, and a checksum file with the suffix `list`.
///
/// # Errors
/// If a file cannot be written; the message contains the path.
pub fn write_with_sums(job: &JobFiles, files: &[(String, Vec<u8>)], list: &str) -> io::Result<()> {
    // An old list would not match the new files.
    whole::remove(&job.path(list))?;
    let mut sums = sums::Checksums::default();
    for (ending, bytes) in files {
        write_whole(&job.path(ending), bytes)?;
        sums.add(job, ending, bytes);
    }
    sums.write(job, list)
}
