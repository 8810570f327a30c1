//! Mesh files of VTK (`.vtu`, `.vtk`, `.vtp`), read through vtkio; frames of results are read back here, too.
//! Never here: what their arrays mean.
//!
//! The one file that knows vtkio, a release before its first: its version is pinned in `Cargo.toml`, its panics are caught here,
//! and what it would take at its word (lengths of compressed arrays, numbers of tags and attributes, lists of other files) is
//! looked at before. What would take
//! its place is a reader of our own for what we write and ParaView saves by default: unstructured grids in XML with inline
//! arrays, by base64 and flate2, which are here anyway; legacy files would no longer be read. It would keep to [`read`].

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use vtkio::Vtk;
use vtkio::model::{Attribute, Attributes, CellType, DataSet, IOBuffer, VertexNumbers};

use super::mesh_data::{MeshFile, is_ours};
use super::xml_limits::exceeded_limit;
use crate::deck::files;

/// Bytes of a file that is read: vtkio holds it several times over.
const MOST: u64 = 2 << 30;

/// Whether an array says that it is larger than its compressed bytes can hold: vtkio makes room for what it says. Zlib
/// presses to no less than a 1032nd (RFC 1951: 258 bytes in two bits).
fn claims_too_much(text: &str) -> bool {
    if !text.contains("compressor=") {
        return false;
    }
    let size = if text.contains("UInt64") && text.contains("header_type=\"UInt64\"") { 8 } else { 4 };
    let number = |bytes: &[u8]| bytes.iter().rev().fold(0_u64, |sum, &b| sum << 8 | u64::from(b));
    text.split("<DataArray").skip(1).filter_map(|part| part.split_once('>')).any(|(_, data)| {
        // Number of blocks, size of each, size of the last.
        let head = data.trim_start().as_bytes().get(..4 * size).and_then(|head| STANDARD.decode(head).ok());
        let Some(head) = head else { return false };
        let blocks = number(&head[..size]);
        // The size of each block stands in the file.
        blocks > text.len() as u64
            || blocks.saturating_mul(number(&head[size..2 * size])) > 1100 * text.len() as u64
            || number(&head[2 * size..3 * size]) > 1100 * text.len() as u64
    })
}

thread_local! {
    /// Whether this thread is in vtkio, whose panics are caught.
    static READING: Cell<bool> = const { Cell::new(false) };
}

/// Lets panics of vtkio, which become errors, say nothing of their own: for programs.
pub fn silence_caught_panics() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if !READING.get() {
            usual(info);
        }
    }));
}

/// Reads a file. vtkio may panic on damaged files, as it reads or as cells are taken from it; that is an error like any
/// other here.
pub(crate) fn read(path: &Path) -> Result<MeshFile, String> {
    READING.set(true);
    let read = catch_unwind(AssertUnwindSafe(|| parse(path)));
    READING.set(false);
    read.unwrap_or_else(|_| Err("the file is damaged".into()))
}

fn parse(path: &Path) -> Result<MeshFile, String> {
    if path.metadata().is_ok_and(|file| file.len() > MOST) {
        return Err(format!("it has more than {} GB", MOST >> 30));
    }
    let bytes = files::read(path).map_err(|e| e.to_string())?;
    let text = String::from_utf8_lossy(&bytes);
    if text.contains("<VTKFile") && !text.contains("</VTKFile>") {
        return Err("the file ends early".into());
    }
    if let Some(limit) = text.contains("<VTKFile").then(|| exceeded_limit(&text)).flatten() {
        return Err(limit);
    }
    if ["<PUnstructuredGrid", "<PPolyData"].iter().any(|list| text.contains(list)) {
        return Err("it lists pieces in other files; save it as one".into());
    }
    if let Some(kind) = unknown_type(&text) {
        return Err(format!("an array has the type `{kind}`, which VTK does not know"));
    }
    if claims_too_much(&text) {
        return Err("the file is damaged: an array says that it is larger than the file can hold".into());
    }
    let vtk = Vtk::import(path).map_err(|e| e.to_string())?;
    let mesh = match vtk.data {
        DataSet::UnstructuredGrid { pieces, .. } => {
            let [piece] = <[_; 1]>::try_from(pieces).map_err(|_| "it has several pieces; save it as one")?;
            let piece = piece.into_loaded_piece_data(Some(path)).map_err(|e| e.to_string())?;
            let cells = cells(Some(piece.cells.cell_verts));
            check_types(&piece.cells.types, &cells)?;
            assemble(&piece.points, cells, piece.data)?
        }
        DataSet::PolyData { pieces, .. } => {
            let [piece] = <[_; 1]>::try_from(pieces).map_err(|_| "it has several pieces; save it as one")?;
            let piece = piece.into_loaded_piece_data(Some(path)).map_err(|e| e.to_string())?;
            // Cell arrays of poly data run over verts, lines and polygons in this order.
            let all = [piece.verts, piece.lines, piece.polys].into_iter().flat_map(cells).collect();
            assemble(&piece.points, all, piece.data)?
        }
        _ => return Err("it is neither an unstructured grid nor poly data".into()),
    };
    let declared = declared_arrays(&text);
    let found = mesh.point_arrays.len() + mesh.cell_arrays.len();
    match declared.filter(|d| *d != found) {
        Some(declared) => Err(format!("{found} of its {declared} arrays can be decoded")),
        None => Ok(mesh),
    }
}

/// How many arrays an XML file declares on points and cells: vtkio leaves out what it cannot decode without a word.
fn declared_arrays(text: &str) -> Option<usize> {
    let section = |name: &str| {
        let start = text.find(&format!("<{name}"))?;
        let end = text[start..].find(&format!("</{name}>"))?;
        Some(text[start..start + end].matches("<DataArray").count())
    };
    text.contains("<VTKFile").then(|| section("PointData").unwrap_or(0) + section("CellData").unwrap_or(0))
}

/// The simplest cells only: a line of second order has the points of a triangle.
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
            "cell {} is a {:?} with {} points; vertices, lines, triangles, quads and triangles of six points are read",
            i + 1,
            types[i],
            cells[i].len()
        )),
        None => Ok(()),
    }
}

/// The first type of an array that VTK does not have.
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
    let values: Vec<f64> = points.cast_into().ok_or("its points are no numbers")?;
    let points = values.as_chunks::<3>().0.to_vec();
    if let Some(cell) = cells.iter().position(|c| c.is_empty() || c.iter().any(|&p| p >= points.len())) {
        return Err(format!("cell {} refers to points that it does not have", cell + 1));
    }
    let (point_arrays, cell_arrays) = (arrays(data.point), arrays(data.cell));
    let wrong = misfit(&point_arrays, points.len()).or(misfit(&cell_arrays, cells.len()));
    match wrong {
        Some(name) => Err(format!("its array {name} does not have one value each")),
        None => Ok(MeshFile { points, cells, point_arrays, cell_arrays, unread: Vec::new() }),
    }
}

/// A set or label array whose length is not that of what it marks.
fn misfit(arrays: &[(String, Vec<f64>)], count: usize) -> Option<&str> {
    arrays.iter().find(|(name, values)| is_ours(name) && values.len() != count).map(|a| a.0.as_str())
}

fn arrays(attributes: Vec<Attribute>) -> Vec<(String, Vec<f64>)> {
    let array = |a: Attribute| match a {
        Attribute::DataArray(array) => Some((array.name, array.data.cast_into()?)),
        Attribute::Field { .. } => None,
    };
    attributes.into_iter().filter_map(array).collect()
}
