//! `*MESH`: mesh files (`.vtu`, `.vtk`, `.vtp`, `.msh`, `.inp`). In VTK files sets are point and cell arrays
//! `NSET_name` and `ELSET_name`, nonzero on members; labels are `NODE_LABEL` and `ELEMENT_LABEL`.

use std::path::Path;

use super::context::Context;
use super::families::MeshReader;
use super::mesh_data::{MeshFile, is_recognized_array};
use super::names::SetKind;
use super::types::ElementKind;
use super::vtk_file::read;
use super::{elements, nodes, sets};
use super::{gmsh_file, inp_file};
use crate::deck::{Card, Diagnostic, Span, files, untrusted};

/// Help text for VTK files that cannot be read.
const RESAVE: &str = "save it as one .vtu file with zlib, LZ4 or no compression; LZMA and legacy files with a FIELD block \
                      are not supported";

/// Reads a mesh file by its extension.
///
/// # Errors
/// The reason, and a help text if there is one.
fn read_any(path: &Path) -> Result<MeshFile, (String, Option<&'static str>)> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    let text = || files::read(path).map(lossy_text).map_err(|e| e.to_string());
    match ending.as_deref() {
        Some("msh") => text().and_then(|t| gmsh_file::parse(&t)).map_err(|why| (why, None)),
        Some("inp") => text().and_then(|t| inp_file::parse(&t)).map_err(|why| (why, None)),
        _ => read(path, &is_recognized_array).map_err(|why| (why, Some(RESAVE))),
    }
}

/// Returns the text of a file; valid UTF-8 is not copied.
fn lossy_text(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes).unwrap_or_else(|error| String::from_utf8_lossy(error.as_bytes()).into_owned())
}

pub fn read_mesh_file(context: &mut Context<'_>, mesh: &mut MeshReader, card: &Card) {
    let Some(input) = context.required(card, "INPUT") else { return };
    let Some(kind) = context.optional(card.value("TYPE"), elements::element_kind) else { return };
    let path = context.deck.sources.folder(card.span).join(input.text.replace('\\', "/"));
    let deck = Span { file: 0, ..Span::default() };
    if untrusted::forbids(context.deck.sources.folder(deck), &path) {
        let message = format!("{} is not in the folder of the deck", input.text);
        let finding = Diagnostic::error("D011", message).at(input.span, "not read with --untrusted");
        let help = "copy the file into the folder of the deck or a folder below it";
        return context.diagnostics.push(finding.help(help));
    }
    match read_any(&path) {
        Ok(file) => add_mesh(context, mesh, &file, kind, card.span),
        Err((why, help)) => {
            let message = format!("cannot read the mesh file `{}`: {why}", input.text);
            let diagnostic = Diagnostic::error("M150", message).at(input.span, "this file");
            context.diagnostics.push(match help {
                Some(help) => diagnostic.help(help),
                None => diagnostic,
            });
        }
    }
}

fn add_mesh(context: &mut Context<'_>, mesh: &mut MeshReader, file: &MeshFile, kind: Option<ElementKind>, span: Span) {
    let node_labels = labels(&file.point_arrays, "NODE_LABEL", file.points.len());
    let element_labels = labels(&file.cell_arrays, "ELEMENT_LABEL", file.cells.len());
    let in_plane = |p: &[f64; 3]| p[2] == 0.0 && p[0] >= 0.0 && p[0].is_finite() && p[1].is_finite();
    if let Some(i) = file.points.iter().position(|p| !in_plane(p)) {
        let [x, y, z] = file.points[i];
        let message = format!("point {i} of the mesh file, ({x}, {y}, {z}), is not in the half-plane z = 0, x >= 0");
        let diagnostic = Diagnostic::error("M126", message).at(span, "this mesh");
        return context.diagnostics.push(diagnostic.help("x of the file is r, and y is z of the axisymmetric model"));
    }
    let nodes: Vec<usize> =
        file.points.iter().zip(&node_labels).map(|(p, &l)| nodes::add_node(context, mesh, l, [p[0], p[1]])).collect();
    let mut elements = Vec::with_capacity(file.cells.len());
    for (cell, &label) in file.cells.iter().zip(&element_labels) {
        elements.push(mesh_cell(context, cell, label, kind, &nodes, span));
    }
    report_unread(context, file, span);
    for (name, values) in &file.point_arrays {
        if let Some(name) = name.strip_prefix("NSET_") {
            let members = nodes.iter().zip(values).filter(|(_, v)| **v != 0.0).map(|(n, _)| *n).collect();
            sets::add_set(context, SetKind::Nodes, name, members, span);
        }
    }
    for (name, values) in &file.cell_arrays {
        if let Some(name) = name.strip_prefix("ELSET_") {
            let members = elements.iter().zip(values).filter(|(_, v)| **v != 0.0).filter_map(|(e, _)| *e).collect();
            sets::add_set(context, SetKind::Elements, name, members, span);
        }
    }
}

/// Reports cards and arrays that were not read; a set may only lack its prefix.
fn report_unread(context: &mut Context<'_>, mesh: &MeshFile, span: Span) {
    if !mesh.unread.is_empty() {
        let message = format!("cards of the mesh file are not read: *{}", mesh.unread.join(", *"));
        let diagnostic = Diagnostic::note("M143", message).at(span, "this mesh");
        context.diagnostics.push(
            diagnostic
                .help("only nodes, elements and sets of an .inp file are read; use *INCLUDE to read the whole file"),
        );
    }
    let arrays = mesh.point_arrays.iter().chain(&mesh.cell_arrays).map(|a| a.0.as_str());
    let unread: Vec<&str> = arrays.filter(|name| !is_recognized_array(name)).collect();
    if !unread.is_empty() {
        let message = format!("arrays of the mesh file are not read: {}", unread.join(", "));
        let diagnostic = Diagnostic::note("M143", message).at(span, "this mesh");
        context
            .diagnostics
            .push(diagnostic.help("a set is an array named NSET_name or ELSET_name, nonzero on its members"));
    }
}

fn mesh_cell(
    context: &mut Context<'_>,
    cell: &[usize],
    label: i64,
    expected: Option<ElementKind>,
    nodes: &[usize],
    span: Span,
) -> Option<usize> {
    let by_count = match cell.len() {
        1 => Some(ElementKind::Mass),
        2 => Some(ElementKind::Rax2),
        3 => Some(ElementKind::Cax3),
        4 => Some(ElementKind::Cax4r),
        6 => Some(ElementKind::Cax6m),
        _ => None,
    };
    let kind = expected.or(by_count);
    let fits = kind.filter(|k| k.node_count() == cell.len());
    let corners: Option<Vec<usize>> = cell.iter().map(|&p| nodes.get(p).copied()).collect();
    if let (Some(kind), Some(corners)) = (fits, corners) {
        return elements::add_element(context, label, kind, kind.around(&corners), span);
    }
    let expected = kind.map_or("an element type", ElementKind::name);
    let message = format!("cell {label} of the mesh file has {} points, which does not match {expected}", cell.len());
    context.diagnostics.refuse(Diagnostic::error("M121", message).at(span, "this mesh"))
}

fn labels(arrays: &[(String, Vec<f64>)], name: &str, count: usize) -> Vec<i64> {
    match arrays.iter().find(|a| a.0 == name && a.1.len() == count) {
        Some((_, values)) => values.iter().map(|v| *v as i64).collect(),
        None => (1..=count as i64).collect(),
    }
}
