//! `*MESH`: mesh files (`.vtu`, `.vtk`, `.vtp`, `.msh`, `.inp`), by the rule of [`super::mesh_data`].

use std::path::Path;

use super::context::Context;
use super::families::MeshReader;
use super::mesh_data::{MeshCell, NO_COMMON_POINTS, PlaneMesh, is_in_half_plane};
use super::names::{SetKind, qualified};
use super::types::{ElementKind, ElementSide, ElementSurface};
use super::vtk_mesh::{NOT_A_MESH, is_mesh_array};
use super::{elements, nodes, sets};
use super::{gmsh_file, inp_file, vtk_file};
use crate::deck::{Card, Diagnostic, Span, files, untrusted};

/// Help texts for files that cannot be read.
const VTK_HELP: &str =
    "save it as one .vtu or legacy .vtk file with zlib, LZ4 or no compression; LZMA is not supported";
const GMSH_HELP: &str = "for linear elements: Mesh.ElementOrder = 1, or SetOrder 1 after the mesh is made";
const INP_HELP: &str = "write linear elements (CPS3, CPS4, CAX3, CAX4R) of the half-plane z = 0";
const JOIN_POINTS: &str = "save the mesh, not the fields (Netgen: Export, MFEM: PrintVTK), or join the points with PyVista, \
     body by body if bodies touch: pyvista.read(FILE).clean().save(NEW)";
const CAST: &str = "save an unstructured grid: pyvista.read(FILE).cast_to_unstructured_grid().save(\"mesh.vtu\"), or a block of a multiblock file";
/// Formats that are not read, by the ending of the file.
const OTHER_FORMATS: [(&str, &str); 16] = [
    ("med", "MED"),
    ("unv", "I-DEAS universal"),
    ("bdf", "Nastran"),
    ("nas", "Nastran"),
    ("e", "Exodus"),
    ("exo", "Exodus"),
    ("stl", "STL"),
    ("cgns", "CGNS"),
    ("mesh", "Medit"),
    ("su2", "SU2"),
    ("k", "LS-DYNA"),
    ("key", "LS-DYNA"),
    ("rad", "Radioss"),
    ("vol", "Netgen"),
    ("xdmf", "XDMF"),
    ("vtkhdf", "VTKHDF"),
];
const CONVERT: &str =
    "convert it to .msh, .inp or .vtu, for example `gmsh FILE -save -o mesh.msh` or `meshio convert FILE mesh.vtu`";

/// Reads a mesh file of a deck in `folder` by its extension.
///
/// # Errors
/// The reason, and a help text.
fn read_any(folder: &Path, path: &Path) -> Result<PlaneMesh, (String, &'static str)> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    if let Some((_, format)) = OTHER_FORMATS.iter().find(|(other, _)| *other == ending) {
        return Err((format!("the format {format} is not supported"), CONVERT));
    }
    let bytes = || files::read_below(folder, path).map_err(|e| e.to_string());
    let text = || bytes().map(lossy_text);
    let with_help = |why: String, help| {
        let help = if why.contains(NO_COMMON_POINTS) {
            JOIN_POINTS
        } else if why == NOT_A_MESH {
            CAST
        } else {
            help
        };
        (why, help)
    };
    match ending.as_str() {
        "msh" => text().and_then(|t| gmsh_file::parse(&t)).map_err(|why| with_help(why, GMSH_HELP)),
        "inp" => text().and_then(|t| inp_file::parse(&t)).map_err(|why| with_help(why, INP_HELP)),
        _ => {
            let mesh = vtk_file::check_length(path).and_then(|()| vtk_file::parse(&bytes()?, &is_mesh_array));
            mesh.and_then(|mesh| mesh.into_listed().in_plane()).map_err(|why| with_help(why, VTK_HELP))
        }
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
    let folder = context.deck.sources.folder(deck).to_owned();
    if untrusted::forbids(&folder, &path) {
        let message = format!("{} is not in the folder of the deck", input.text);
        let finding = Diagnostic::error("D011", message).at(input.span, "not read with --untrusted");
        let help = "copy the file into the folder of the deck or a folder below it";
        return context.diagnostics.push(finding.help(help));
    }
    match read_any(&folder, &path) {
        Ok(file) => {
            context.model.origin.mesh_files.push(path);
            add_mesh(context, mesh, &file, kind, card.span);
        }
        Err((why, help)) => {
            let message = format!("cannot read the mesh file `{}`: {why}", input.text);
            context.diagnostics.push(Diagnostic::error("M150", message).at(input.span, "this file").help(help));
        }
    }
}

fn add_mesh(context: &mut Context<'_>, mesh: &mut MeshReader, file: &PlaneMesh, kind: Option<ElementKind>, span: Span) {
    if let Some(i) = file.points.iter().position(|point| !is_in_half_plane(point)) {
        let [x, y, z] = file.points[i];
        let message = format!("point {i} of the mesh file, ({x}, {y}, {z}), is not in the half-plane z = 0, x >= 0");
        let diagnostic = Diagnostic::error("M126", message).at(span, "this mesh");
        return context.diagnostics.push(diagnostic.help(
            "x of the file is r, and y is z of the axisymmetric model: turn a mesh of the plane y = 0 by 90 degrees about x \
             before it is saved",
        ));
    }
    let node_offset = label_offset(context, SetKind::Nodes, file.point_labels.iter().copied(), span);
    let element_labels = file.elements.iter().map(|cell| cell.label);
    let element_offset = label_offset(context, SetKind::Elements, element_labels, span);
    let labels = file.point_labels.iter().map(|label| label.saturating_add(node_offset));
    let nodes: Vec<usize> =
        file.points.iter().zip(labels).map(|(p, label)| nodes::add_node(context, mesh, label, [p[0], p[1]])).collect();
    let element = |cell| mesh_element(context, cell, element_offset, kind, &nodes, span);
    let elements: Vec<Option<usize>> = file.elements.iter().map(element).collect();
    report_unread(context, file, span);
    for (name, points) in &file.node_sets {
        sets::add_set(context, SetKind::Nodes, name, points.iter().map(|&point| nodes[point]).collect(), span);
    }
    for (name, points) in &file.nodes_of_groups {
        let key = qualified(&context.scope, name);
        if !context.model.node_sets.contains_key(&key) {
            sets::add_set(context, SetKind::Nodes, name, points.iter().map(|&point| nodes[point]).collect(), span);
            mesh.derived_node_sets.insert(key);
        }
    }
    for (name, cells) in &file.element_sets {
        let members = cells.iter().filter_map(|&cell| elements[cell]).collect();
        sets::add_set(context, SetKind::Elements, name, members, span);
    }
    for (name, faces) in &file.surfaces {
        add_surface(context, mesh, name, faces, &elements, span);
    }
}

/// Returns the number that is added to the labels of a file: 0, or the largest label that the deck has so far if one of
/// the file is among these.
fn label_offset(context: &mut Context<'_>, kind: SetKind, mut labels: impl Iterator<Item = i64>, span: Span) -> i64 {
    let Some(scope) = context.labels(kind).scope(&context.scope) else { return 0 };
    if !labels.any(|label| scope.find(label).is_some()) {
        return 0;
    }
    let (offset, what) = (scope.largest(), if kind == SetKind::Nodes { "node" } else { "element" });
    let message =
        format!("{what} labels of the mesh file are increased by {offset}, because the deck uses some labels already");
    context.diagnostics.push(Diagnostic::note("M143", message).at(span, "this mesh"));
    offset
}

/// Adds a surface of element faces, unless the deck defines one of this name; a later card of the deck replaces it.
fn add_surface(
    context: &mut Context<'_>,
    mesh: &mut MeshReader,
    name: &str,
    faces: &[(usize, usize)],
    elements: &[Option<usize>],
    span: Span,
) {
    let key = qualified(&context.scope, name);
    let surfaces = &mut context.model.surfaces;
    if surfaces.faces.contains_key(&key) || surfaces.nodes.contains_key(&key) {
        return;
    }
    let of_face = |&(cell, face): &(usize, usize)| {
        let element = elements[cell]?;
        let sides = context.model.mesh.elements[element].kind.face(face as u8 + 1);
        Some(sides.map(move |side| (element, ElementSide::Face(side))))
    };
    let faces = faces.iter().filter_map(of_face).flatten().collect();
    let surface = ElementSurface { name: name.to_owned(), faces, free_face_elements: Vec::new(), span };
    surfaces.faces.insert(key.clone(), surface);
    mesh.derived_surfaces.insert(key);
}

/// Reports cards and arrays that were not read, and cells that are listed more than once.
fn report_unread(context: &mut Context<'_>, file: &PlaneMesh, span: Span) {
    if !file.unread.is_empty() {
        let message = format!("the mesh file has data that are not read: {}", file.unread.join(", "));
        let diagnostic = Diagnostic::note("M143", message).at(span, "this mesh");
        context.diagnostics.push(diagnostic.help(
            "nodes, elements, sets and surfaces are read; in VTK files a set is an array named NSET_name or ELSET_name, \
             nonzero on its members; *INCLUDE reads a whole .inp file",
        ));
    }
    for (set, count) in &file.undefined_members {
        let message = format!("{count} members of the set {set} of the mesh file are not defined in the file");
        let diagnostic = Diagnostic::warning("M166", message).at(span, "this mesh");
        context
            .diagnostics
            .push(diagnostic.help("export the elements or nodes of all sets; the set has the other members"));
    }
    if file.repeated_cells > 0 {
        let message =
            format!("{} cells of the mesh file are listed more than once; each is one element", file.repeated_cells);
        context.diagnostics.push(Diagnostic::note("M143", message).at(span, "this mesh"));
    }
}

fn mesh_element(
    context: &mut Context<'_>,
    cell: &MeshCell,
    label_offset: i64,
    expected: Option<ElementKind>,
    nodes: &[usize],
    span: Span,
) -> Option<usize> {
    let by_shape = match (cell.dimension, cell.points.len()) {
        (0, 1) => Some(ElementKind::Mass),
        (1, 2) => Some(ElementKind::Rax2),
        (2, 3) => Some(ElementKind::Cax3),
        (2, 4) => Some(ElementKind::Cax4r),
        (2, 6) => Some(ElementKind::Cax6m),
        _ => None,
    };
    let kind = expected.or(by_shape);
    if let Some(kind) = kind.filter(|k| k.node_count() == cell.points.len()) {
        let corners: Vec<usize> = cell.points.iter().map(|&point| nodes[point]).collect();
        return elements::add_element(
            context,
            cell.label.saturating_add(label_offset),
            kind,
            kind.around(&corners),
            span,
        );
    }
    let expected = kind.map_or("an element type", ElementKind::name);
    let count = cell.points.len();
    let message = format!("cell {} of the mesh file has {count} points, which does not match {expected}", cell.label);
    context.diagnostics.refuse(Diagnostic::error("M121", message).at(span, "this mesh"))
}
