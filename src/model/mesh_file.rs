//! Mesh files: `*MESH, INPUT=file.vtu|.vtk|.vtp` read through vtkio.
//! Sets are point and cell arrays named `NSET_name` and `ELSET_name` that are not zero on members; labels are
//! `NODE_LABEL` and `ELEMENT_LABEL`. Never here: decks.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use vtkio::Vtk;
use vtkio::model::{Attribute, Attributes, CellType, DataSet, IOBuffer, VertexNumbers};

use super::builder::Builder;
use super::types::ElementKind;
use crate::deck::{Card, Diagnostic, Span};

/// What is said of a file that vtkio cannot read.
const RESAVE: &str = "save it as .vtu with inline (binary) data and zlib or no compression; appended raw data, LZMA and \
                      legacy files with a FIELD block are not read";

/// A mesh as it stands in a file.
#[derive(Debug, Default)]
pub(crate) struct MeshFile {
    pub(crate) points: Vec<[f64; 3]>,
    pub(crate) cells: Vec<Vec<usize>>,
    pub(crate) point_arrays: Vec<(String, Vec<f64>)>,
    pub(crate) cell_arrays: Vec<(String, Vec<f64>)>,
}

impl Builder<'_> {
    pub(super) fn mesh_file(&mut self, card: &Card) {
        let Some(input) = self.required(card, "INPUT") else { return };
        let kind = match card.value("TYPE") {
            Some(word) => match self.element_kind(word) {
                Some(kind) => Some(kind),
                None => return,
            },
            None => None,
        };
        let path = self.deck.sources.folder(card.span).join(input.text.replace('\\', "/"));
        match read(&path) {
            Ok(mesh) => self.take_mesh(&mesh, kind, card.span),
            Err(why) => {
                let message = format!("cannot read the mesh file `{}`: {why}", input.text);
                self.diagnostics.push(Diagnostic::error("M150", message).at(input.span, "this file").help(RESAVE));
            }
        }
    }

    fn take_mesh(&mut self, mesh: &MeshFile, kind: Option<ElementKind>, span: Span) {
        let node_labels = labels(&mesh.point_arrays, "NODE_LABEL", mesh.points.len());
        let element_labels = labels(&mesh.cell_arrays, "ELEMENT_LABEL", mesh.cells.len());
        let in_plane = |p: &[f64; 3]| p[2] == 0.0 && p[0] >= 0.0 && p[0].is_finite() && p[1].is_finite();
        if let Some(i) = mesh.points.iter().position(|p| !in_plane(p)) {
            let [x, y, z] = mesh.points[i];
            let message =
                format!("point {i} of the mesh file, ({x}, {y}, {z}), is not in the half plane z = 0, x >= 0");
            let finding = Diagnostic::error("M126", message).at(span, "this mesh");
            self.diagnostics.push(finding.help("x of the file is r, y is z of the axisymmetric model"));
            return;
        }
        let nodes: Vec<usize> =
            mesh.points.iter().zip(&node_labels).map(|(p, &l)| self.add_node(l, [p[0], p[1]])).collect();
        let mut elements = Vec::with_capacity(mesh.cells.len());
        for (cell, &label) in mesh.cells.iter().zip(&element_labels) {
            elements.push(self.mesh_cell(cell, label, kind, &nodes, span));
        }
        self.name_unread(mesh, span);
        for (name, values) in &mesh.point_arrays {
            if let Some(name) = name.strip_prefix("NSET_") {
                let members = nodes.iter().zip(values).filter(|(_, v)| **v != 0.0).map(|(n, _)| *n).collect();
                self.add_node_set(name, members, span);
            }
        }
        for (name, values) in &mesh.cell_arrays {
            if let Some(name) = name.strip_prefix("ELSET_") {
                let members = elements.iter().zip(values).filter(|(_, v)| **v != 0.0).filter_map(|(e, _)| *e).collect();
                self.add_element_set(name, members, span);
            }
        }
    }

    /// Arrays that are neither sets nor labels are told once: a set may only lack its prefix.
    fn name_unread(&mut self, mesh: &MeshFile, span: Span) {
        let arrays = mesh.point_arrays.iter().chain(&mesh.cell_arrays).map(|a| a.0.as_str());
        let unread: Vec<&str> = arrays.filter(|name| !is_ours(name)).collect();
        if !unread.is_empty() {
            let message = format!("arrays of the mesh file are not read: {}", unread.join(", "));
            let finding = Diagnostic::note("M143", message).at(span, "this mesh");
            self.diagnostics
                .push(finding.help("a set is an array named NSET_name or ELSET_name, not zero on its members"));
        }
    }

    fn mesh_cell(
        &mut self,
        cell: &[usize],
        label: i64,
        wanted: Option<ElementKind>,
        nodes: &[usize],
        span: Span,
    ) -> Option<usize> {
        let by_count = [ElementKind::Mass, ElementKind::Rax2, ElementKind::Cax3, ElementKind::Cax4r];
        let kind = wanted.or_else(|| by_count.get(cell.len().wrapping_sub(1)).copied());
        let fits = kind.filter(|k| k.node_count() == cell.len());
        let corners: Option<Vec<usize>> = cell.iter().map(|&p| nodes.get(p).copied()).collect();
        if let (Some(kind), Some(corners)) = (fits, corners) {
            return self.add_element(label, kind, corners, span);
        }
        let wanted = kind.map_or("no element type", ElementKind::name);
        let message = format!("cell {label} of the mesh file has {} points; {wanted} does not fit", cell.len());
        self.diagnostics.push(Diagnostic::error("M121", message).at(span, "this mesh"));
        None
    }
}

fn labels(arrays: &[(String, Vec<f64>)], name: &str, count: usize) -> Vec<i64> {
    match arrays.iter().find(|a| a.0 == name && a.1.len() == count) {
        Some((_, values)) => values.iter().map(|v| *v as i64).collect(),
        None => (1..=count as i64).collect(),
    }
}

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
        number(&head[..size]).saturating_mul(number(&head[size..2 * size])) > 1100 * text.len() as u64
            || number(&head[2 * size..3 * size]) > 1100 * text.len() as u64
    })
}

/// Reads a file. vtkio may panic on damaged files, as it reads or as cells are taken from it; that is an error like any
/// other here.
pub(crate) fn read(path: &Path) -> Result<MeshFile, String> {
    catch_unwind(AssertUnwindSafe(|| parse(path))).unwrap_or_else(|_| Err("the file is damaged".into()))
}

fn parse(path: &Path) -> Result<MeshFile, String> {
    let bytes = std::fs::read(path).map_err(|e| e.to_string())?;
    let text = String::from_utf8_lossy(&bytes);
    if text.contains("<VTKFile") && !text.contains("</VTKFile>") {
        return Err("the file ends early".into());
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
        _ => 0,
    };
    match types.iter().zip(cells).position(|(t, c)| points(*t) != c.len()) {
        Some(i) => Err(format!(
            "cell {} is a {:?} with {} points; vertices, lines, triangles and quads of first order are read",
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
        None => Ok(MeshFile { points, cells, point_arrays, cell_arrays }),
    }
}

/// A set or label array whose length is not that of what it marks.
fn misfit(arrays: &[(String, Vec<f64>)], count: usize) -> Option<&str> {
    arrays.iter().find(|(name, values)| is_ours(name) && values.len() != count).map(|a| a.0.as_str())
}

fn is_ours(name: &str) -> bool {
    name.starts_with("NSET_") || name.starts_with("ELSET_") || name.ends_with("_LABEL")
}

fn arrays(attributes: Vec<Attribute>) -> Vec<(String, Vec<f64>)> {
    let array = |a: Attribute| match a {
        Attribute::DataArray(array) => Some((array.name, array.data.cast_into()?)),
        Attribute::Field { .. } => None,
    };
    attributes.into_iter().filter_map(array).collect()
}
