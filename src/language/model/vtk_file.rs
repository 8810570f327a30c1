//! Reader of VTK files (`.vtu`, `.vtk`, `.vtp`): mesh files, and frames of results.
//!
//! Legacy files are read by the crate vtkio, whose version is pinned in `Cargo.toml` and which no other file uses. It
//! panics on some damaged files; panics are caught.

use std::cell::Cell;
use std::panic::catch_unwind;
use std::path::Path;

use vtkio::Vtk;
use vtkio::model::{Attribute, DataSet, VertexNumbers};

use super::vtk_mesh::{NOT_A_MESH, VtkMesh, is_mesh_array};
use super::xml_mesh;
use crate::deck::files;

/// Bytes of a legacy file before the name of its data set: two lines, of at most 256 bytes, and a word.
const HEADER: usize = 1024;
/// Largest file size in bytes; the mesh needs several times as much memory.
const MAX_BYTES: u64 = 2 << 30;

thread_local! {
    /// Whether this thread is in vtkio, whose panics are caught.
    static READING: Cell<bool> = const { Cell::new(false) };
}

/// Suppresses the messages of vtkio panics, which are reported as errors. For programs, not for libraries.
pub fn silence_caught_panics() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if !READING.get() {
            usual(info);
        }
    }));
}

/// Reads a VTK file, with the values of the arrays whose names `wanted` accepts.
///
/// # Errors
/// The reason if the file is damaged or not supported.
pub fn read(path: &Path, wanted: &dyn Fn(&str) -> bool) -> Result<VtkMesh, String> {
    check_length(path)?;
    parse(&files::read(path).map_err(|e| e.to_string())?, wanted)
}

/// Checks that a file is not too large to be read.
///
/// # Errors
/// The reason if it is.
pub(super) fn check_length(path: &Path) -> Result<(), String> {
    if path.metadata().is_ok_and(|file| file.len() > MAX_BYTES) {
        return Err(format!("the file is larger than {} GB", MAX_BYTES >> 30));
    }
    Ok(())
}

/// Reads the bytes of a VTK file, like [`read`].
///
/// # Errors
/// The reason if the file is damaged or not supported.
pub(super) fn parse(bytes: &[u8], wanted: &dyn Fn(&str) -> bool) -> Result<VtkMesh, String> {
    let mut mesh = if bytes.starts_with(b"# vtk DataFile") {
        READING.set(true);
        let read = catch_unwind(|| parse_legacy(bytes));
        READING.set(false);
        read.unwrap_or_else(|_| Err("the file is damaged".into()))?
    } else {
        xml_mesh::parse(bytes, wanted)?
    };
    check_types(&mesh.types, &mut mesh.cells)?;
    check_arrays(mesh)
}

/// Returns the contents of a legacy file.
fn parse_legacy(bytes: &[u8]) -> Result<VtkMesh, String> {
    let header = &bytes[..bytes.len().min(HEADER)];
    if [&b"DATASET RECTILINEAR_GRID"[..], b"DATASET STRUCTURED_"].iter().any(|other| find(header, other).is_some()) {
        return Err(NOT_A_MESH.into());
    }
    let vtk = Vtk::parse_legacy_be(&with_known_types(adapted(bytes))?[..]).map_err(|e| e.to_string())?;
    let (points, cells, types, data) = match vtk.data {
        DataSet::UnstructuredGrid { pieces, .. } => {
            let [piece] = <[_; 1]>::try_from(pieces).map_err(|_| "it has several pieces; save it as one piece")?;
            let piece = piece.into_loaded_piece_data(None).map_err(|e| e.to_string())?;
            let types = piece.cells.types.iter().map(|t| *t as u8).collect();
            (piece.points, cells(Some(piece.cells.cell_verts)), types, piece.data)
        }
        DataSet::PolyData { pieces, .. } => {
            let [piece] = <[_; 1]>::try_from(pieces).map_err(|_| "it has several pieces; save it as one piece")?;
            let piece = piece.into_loaded_piece_data(None).map_err(|e| e.to_string())?;
            // The cell arrays of poly data cover vertices, lines and polygons in this order.
            let listed_cells = [piece.verts, piece.lines, piece.polys].into_iter().flat_map(cells).collect();
            (piece.points, listed_cells, Vec::new(), piece.data)
        }
        _ => return Err(NOT_A_MESH.into()),
    };
    let values: Vec<f64> = points.cast_into().ok_or("its point coordinates are not numbers")?;
    let points = values.as_chunks::<3>().0.to_vec();
    let (point_arrays, cell_arrays) = (arrays(data.point), arrays(data.cell));
    Ok(VtkMesh { points, cells, types, point_arrays, cell_arrays })
}

/// Returns a legacy file in the form that vtkio 0.7.0-rc2 reads: without fields of the data set, such as TimeValue,
/// before the points, and with the number type `long` in place of `vtktypeint64`.
fn adapted(bytes: &[u8]) -> Vec<u8> {
    const INT64: &[u8] = b" vtktypeint64";
    let points = find(bytes, b"\nPOINTS ").unwrap_or(0);
    let fields = find(&bytes[..points], b"\nFIELD ").unwrap_or(points);
    let mut adapted = bytes[..fields].to_vec();
    let mut remaining = &bytes[points..];
    while let Some(at) = find(remaining, INT64) {
        let line = remaining[..at].rsplit(|byte| *byte == b'\n').next().unwrap_or_default();
        let is_cell_list = line == b"OFFSETS" || line == b"CONNECTIVITY";
        adapted.extend_from_slice(&remaining[..at]);
        adapted.extend_from_slice(if is_cell_list { INT64 } else { b" long" });
        remaining = &remaining[at + INT64.len()..];
    }
    adapted.extend_from_slice(remaining);
    adapted
}

/// Returns a legacy file with types of arrays that vtkio 0.7.0-rc2 reads: `char` in place of `signed_char`, and in text files
/// `unsigned_int` in place of `unsigned_short`.
///
/// # Errors
/// The reason for `unsigned_short` in a binary file.
fn with_known_types(mut bytes: Vec<u8>) -> Result<Vec<u8>, String> {
    let is_text = bytes.splitn(4, |byte| *byte == b'\n').nth(2).is_some_and(|line| line.starts_with(b"ASCII"));
    for (unknown, known) in [(&b" signed_char"[..], &b" char"[..]), (b" unsigned_short", b" unsigned_int")] {
        let mut from = 0;
        while let Some(at) = find(&bytes[from..], unknown).map(|at| from + at) {
            from = at + unknown.len();
            let line = bytes[..at].rsplit(|byte| *byte == b'\n').next().unwrap_or_default();
            if !line.iter().all(|byte| byte.is_ascii_graphic() || *byte == b' ') {
                continue;
            }
            if known == b" unsigned_int" && !is_text {
                let line = String::from_utf8_lossy(line).into_owned();
                return Err(format!(
                    "the array `{line}` has the type unsigned_short: save it as int, or the file as text"
                ));
            }
            bytes.splice(at..from, known.iter().copied());
            from = at + known.len();
        }
    }
    Ok(bytes)
}

fn find(bytes: &[u8], word: &[u8]) -> Option<usize> {
    bytes.windows(word.len()).position(|window| window == word)
}

/// Supported cell types: number in VTK, name, number of points.
const TYPES: [(u8, &str, usize); 7] = [
    (1, "vertex", 1),
    (3, "line", 2),
    (5, "triangle", 3),
    (PIXEL, "pixel", 4),
    (9, "quadrilateral", 4),
    (21, "three-point line", 3),
    (22, "six-point triangle", 6),
];
/// Rectangle whose points are in the order of a grid.
const PIXEL: u8 = 8;
/// Quadrilaterals of second order.
const SECOND_ORDER: [u8; 3] = [23, 28, 30];

/// Checks that all cells are of supported types with the matching number of points; pixels become quadrilaterals.
fn check_types(types: &[u8], cells: &mut [Vec<usize>]) -> Result<(), String> {
    for (i, (number, cell)) in types.iter().zip(cells).enumerate() {
        let (i, points) = (i + 1, cell.len());
        match TYPES.iter().find(|t| t.0 == *number) {
            Some((kind, _, expected)) if *expected == points => {
                if *kind == PIXEL {
                    cell.swap(2, 3);
                }
            }
            Some((_, name, expected)) => {
                return Err(format!("cell {i} is a {name} with {points} points, expected {expected}"));
            }
            None if SECOND_ORDER.contains(number) => {
                return Err(format!(
                    "cell {i} is a quadrilateral of second order (VTK type {number}): write elements of first order"
                ));
            }
            None => {
                return Err(format!(
                    "cell {i} has the VTK type {number}; supported are vertices (1), lines (3, 21), triangles (5), pixels \
                     (8), quadrilaterals (9) and six-point triangles (22)"
                ));
            }
        }
    }
    Ok(())
}

fn cells(numbers: Option<VertexNumbers>) -> Vec<Vec<usize>> {
    let Some(numbers) = numbers else { return Vec::new() };
    let (connectivity, offsets) = numbers.into_xml();
    let mut start = 0;
    let mut cells = Vec::with_capacity(offsets.len());
    for end in offsets.into_iter().map(|o| o as usize) {
        if end > start {
            cells.push(connectivity.get(start..end).unwrap_or(&[]).iter().map(|&p| p as usize).collect());
        }
        start = end;
    }
    cells
}

/// Checks the references of cells to points and the lengths of sets and labels.
fn check_arrays(mesh: VtkMesh) -> Result<VtkMesh, String> {
    let (points, cells) = (mesh.points.len(), mesh.cells.len());
    if let Some(cell) = mesh.cells.iter().position(|c| c.is_empty() || c.iter().any(|&p| p >= points)) {
        return Err(format!("cell {} refers to points that do not exist", cell + 1));
    }
    match misfit(&mesh.point_arrays, points).or(misfit(&mesh.cell_arrays, cells)) {
        Some(name) => Err(format!("its array {name} does not have one value per point or cell")),
        None => Ok(mesh),
    }
}

/// Returns the name of the first set or label array with a wrong length.
fn misfit(arrays: &[(String, Vec<f64>)], count: usize) -> Option<&str> {
    arrays.iter().find(|(name, values)| is_mesh_array(name) && values.len() != count).map(|a| a.0.as_str())
}

/// Returns the arrays of a legacy file, alone or in FIELD blocks. Names are encoded with percent signs.
fn arrays(attributes: Vec<Attribute>) -> Vec<(String, Vec<f64>)> {
    let arrays = attributes.into_iter().flat_map(|attribute| match attribute {
        Attribute::DataArray(array) => vec![(array.name, array.data)],
        Attribute::Field { data_array, .. } => data_array.into_iter().map(|array| (array.name, array.data)).collect(),
    });
    arrays.filter_map(|(name, data)| Some((percent_decoded(&name), data.cast_into()?))).collect()
}

/// Decodes `%20` and the like, by which legacy files write blanks in names. VTK writes `%%20` for some arrays.
fn percent_decoded(name: &str) -> String {
    let name = name.replace("%%", "%");
    let Some((before, after)) = name.split_once('%') else { return name };
    let byte = after.get(..2).and_then(|digits| u8::from_str_radix(digits, 16).ok()).filter(u8::is_ascii);
    match byte {
        Some(byte) => format!("{before}{}{}", byte as char, percent_decoded(&after[2..])),
        None => format!("{before}%{}", percent_decoded(after)),
    }
}
