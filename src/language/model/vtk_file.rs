//! Reader of VTK files (`.vtu`, `.vtk`, `.vtp`): mesh files, and frames of results. It uses the crate vtkio, whose
//! version is pinned in `Cargo.toml` and which no other file uses.
//!
//! vtkio panics on some damaged files and trusts declared sizes. Panics are caught, and array lengths, numbers of tags
//! and attributes, and references to other files are checked before vtkio reads the file.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use vtkio::Vtk;
use vtkio::model::{Attribute, Attributes, CellType, DataSet, IOBuffer, VertexNumbers};

use super::mesh_data::{MeshFile, is_recognized_array};
use super::xml_limits::exceeded_limit;
use crate::deck::files;

/// Largest file size in bytes; vtkio needs several times as much memory.
const MAX_BYTES: u64 = 2 << 30;

/// Returns whether a compressed array declares more bytes than it can contain; vtkio allocates the declared size. The
/// compression ratio of zlib is at most 1032 (RFC 1951: 258 bytes in two bits).
fn declares_oversized_array(text: &str) -> bool {
    if !text.contains("compressor=") {
        return false;
    }
    let size = if text.contains("UInt64") && text.contains("header_type=\"UInt64\"") { 8 } else { 4 };
    let number = |bytes: &[u8]| bytes.iter().rev().fold(0_u64, |sum, &b| sum << 8 | u64::from(b));
    text.split("<DataArray").skip(1).filter_map(|part| part.split_once('>')).any(|(_, data)| {
        // Header: number of blocks, block size, size of the last block.
        let head = data.trim_start().as_bytes().get(..4 * size).and_then(|head| STANDARD.decode(head).ok());
        let Some(head) = head else { return false };
        let blocks = number(&head[..size]);
        // The header lists the size of each block.
        blocks > text.len() as u64
            || blocks.saturating_mul(number(&head[size..2 * size])) > 1100 * text.len() as u64
            || number(&head[2 * size..3 * size]) > 1100 * text.len() as u64
    })
}

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

/// Reads a VTK file. A panic of vtkio on a damaged file is returned as an error.
pub fn read(path: &Path) -> Result<MeshFile, String> {
    READING.set(true);
    let read = catch_unwind(AssertUnwindSafe(|| parse(path)));
    READING.set(false);
    read.unwrap_or_else(|_| Err("the file is damaged".into()))
}

fn parse(path: &Path) -> Result<MeshFile, String> {
    if path.metadata().is_ok_and(|file| file.len() > MAX_BYTES) {
        return Err(format!("the file is larger than {} GB", MAX_BYTES >> 30));
    }
    let bytes = files::read(path).map_err(|e| e.to_string())?;
    let text = String::from_utf8_lossy(&bytes);
    if text.contains("<VTKFile") && !text.contains("</VTKFile>") {
        return Err("the file is incomplete".into());
    }
    if let Some(limit) = text.contains("<VTKFile").then(|| exceeded_limit(&text)).flatten() {
        return Err(limit);
    }
    if ["<PUnstructuredGrid", "<PPolyData"].iter().any(|list| text.contains(list)) {
        return Err("it refers to pieces in other files; save it as one file".into());
    }
    if let Some(kind) = unknown_type(&text) {
        return Err(format!("an array has the type `{kind}`, which does not exist in VTK"));
    }
    if declares_oversized_array(&text) {
        return Err("the file is damaged: an array declares more data than the file can contain".into());
    }
    let vtk = Vtk::import(path).map_err(|e| e.to_string())?;
    let mesh = match vtk.data {
        DataSet::UnstructuredGrid { pieces, .. } => {
            let [piece] = <[_; 1]>::try_from(pieces).map_err(|_| "it has several pieces; save it as one piece")?;
            let piece = piece.into_loaded_piece_data(Some(path)).map_err(|e| e.to_string())?;
            let cells = cells(Some(piece.cells.cell_verts));
            check_types(&piece.cells.types, &cells)?;
            assemble(&piece.points, cells, piece.data)?
        }
        DataSet::PolyData { pieces, .. } => {
            let [piece] = <[_; 1]>::try_from(pieces).map_err(|_| "it has several pieces; save it as one piece")?;
            let piece = piece.into_loaded_piece_data(Some(path)).map_err(|e| e.to_string())?;
            // The cell arrays of poly data cover vertices, lines and polygons in this order.
            let all = [piece.verts, piece.lines, piece.polys].into_iter().flat_map(cells).collect();
            assemble(&piece.points, all, piece.data)?
        }
        _ => return Err("it must be an unstructured grid or poly data".into()),
    };
    let declared = declared_arrays(&text);
    let found = mesh.point_arrays.len() + mesh.cell_arrays.len();
    match declared.filter(|d| *d != found) {
        Some(declared) => Err(format!("only {found} of its {declared} arrays can be decoded")),
        None => Ok(mesh),
    }
}

/// Returns the number of point and cell arrays that an XML file declares; vtkio silently skips arrays that it cannot
/// decode.
fn declared_arrays(text: &str) -> Option<usize> {
    let section = |name: &str| {
        let start = text.find(&format!("<{name}"))?;
        let end = text[start..].find(&format!("</{name}>"))?;
        Some(text[start..start + end].matches("<DataArray").count())
    };
    text.contains("<VTKFile").then(|| section("PointData").unwrap_or(0) + section("CellData").unwrap_or(0))
}

/// Checks that all cells are of supported types with the matching number of points.
fn check_types(types: &[CellType], cells: &[Vec<usize>]) -> Result<(), String> {
    let points = |t: CellType| match t {
        CellType::Vertex => 1,
        CellType::Line => 2,
        CellType::Triangle => 3,
        CellType::Quad => 4,
        CellType::QuadraticTriangle => 6,
        _ => 0,
    };
    match types.iter().zip(cells).position(|(t, c)| points(*t) != c.len()) {
        Some(i) => Err(format!(
            "cell {} is a {:?} with {} points; supported are vertices, lines, \
             triangles, quadrilaterals and six-point triangles",
            i + 1,
            types[i],
            cells[i].len()
        )),
        None => Ok(()),
    }
}

/// Returns the first array type that does not exist in VTK.
fn unknown_type(text: &str) -> Option<&str> {
    const TYPES: [&str; 11] =
        ["Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64", "Float32", "Float64", "String"];
    let tags = text.split("<DataArray").skip(1).filter_map(|t| t.split('>').next());
    let types = tags.filter_map(|tag| tag.split_once(" type=\"")?.1.split('"').next());
    types.into_iter().find(|t| !TYPES.contains(t))
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

fn assemble(points: &IOBuffer, cells: Vec<Vec<usize>>, data: Attributes) -> Result<MeshFile, String> {
    let values: Vec<f64> = points.cast_into().ok_or("its point coordinates are not numbers")?;
    let points = values.as_chunks::<3>().0.to_vec();
    if let Some(cell) = cells.iter().position(|c| c.is_empty() || c.iter().any(|&p| p >= points.len())) {
        return Err(format!("cell {} refers to points that do not exist", cell + 1));
    }
    let (point_arrays, cell_arrays) = (arrays(data.point), arrays(data.cell));
    let wrong = misfit(&point_arrays, points.len()).or(misfit(&cell_arrays, cells.len()));
    match wrong {
        Some(name) => Err(format!("its array {name} does not have one value per point or cell")),
        None => Ok(MeshFile { points, cells, point_arrays, cell_arrays, unread: Vec::new() }),
    }
}

/// Returns the name of the first set or label array with a wrong length.
fn misfit(arrays: &[(String, Vec<f64>)], count: usize) -> Option<&str> {
    arrays.iter().find(|(name, values)| is_recognized_array(name) && values.len() != count).map(|a| a.0.as_str())
}

fn arrays(attributes: Vec<Attribute>) -> Vec<(String, Vec<f64>)> {
    let array = |a: Attribute| match a {
        Attribute::DataArray(array) => Some((array.name, array.data.cast_into()?)),
        Attribute::Field { .. } => None,
    };
    attributes.into_iter().filter_map(array).collect()
}
