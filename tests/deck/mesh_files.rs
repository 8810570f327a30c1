//! Mesh files: a mesh written by Revolve reads back to the same model; damaged and wrong files are told.

use revolve::deck;
use revolve::model::{self, Model};
use revolve::output::vtu::VtuWriter;

use crate::common::mesh::mesh_frame;

const DECK: &str = "*Node, nset=ALL\n 1, 0., 0.\n 2, 1., 0.\n 3, 1., 1.\n 4, 0., 1.\n 5, 0., 2.\n 20, 3., 0.\n 21, 3., 1.\n\
*Element, type=CAX4R, elset=BODY\n 10, 1, 2, 3, 4\n*Element, type=CAX3, elset=BODY\n 11, 4, 3, 5\n\
*Element, type=RAX2, elset=WALL\n 40, 20, 21\n*Element, type=MASS, elset=POINT\n 50, 20\n*Nset, nset=AXIS\n 1, 4, 5\n";

fn build(text: &str) -> Model {
    let (deck, diagnostics) = deck::read_text("t.inp", text, &[]);
    assert!(!diagnostics.has_errors(), "{}", diagnostics.render(&deck.sources));
    let (model, diagnostics) = model::build(&deck);
    assert!(!diagnostics.has_errors(), "{}", diagnostics.render(&deck.sources));
    model
}

fn errors(text: &str) -> String {
    let (deck, _) = deck::read_text("t.inp", text, &[]);
    let (_, diagnostics) = model::build(&deck);
    assert!(diagnostics.has_errors());
    diagnostics.render(&deck.sources)
}

#[test]
fn a_written_mesh_reads_back_to_the_same_model() {
    let model = build(DECK);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("mesh.vtu");
    std::fs::write(&path, VtuWriter::default().text(&mesh_frame(&model))).expect("a file");
    let back = build(&format!("*Mesh, input=\"{}\"\n", path.display()));
    assert_eq!(back.mesh.points, model.mesh.points);
    assert_eq!(back.mesh.node_names, model.mesh.node_names);
    let shape =
        |m: &Model| m.mesh.elements.iter().map(|e| (e.name.clone(), e.kind, e.nodes.clone())).collect::<Vec<_>>();
    assert_eq!(shape(&back), shape(&model));
    let sets = |m: &Model| {
        let all = m.node_sets.iter().chain(&m.element_sets);
        all.map(|(n, s)| (n.clone(), s.members.clone())).collect::<Vec<_>>()
    };
    assert_eq!(sets(&back), sets(&model));
}

const LEGACY: &str = "# vtk DataFile Version 3.0\nmesh\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 3 double\n0 0 0 1 0 0 0 1 0\n\
CELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n5\n";

#[test]
fn legacy_files_are_read_and_types_overridden() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("mesh.vtk");
    std::fs::write(&path, LEGACY).expect("a file");
    let model = build(&format!("*Mesh, input=\"{}\"\n", path.display()));
    assert_eq!(model.mesh.elements[0].kind, model::ElementKind::Cax3);
    let told = errors(&format!("*Mesh, input=\"{}\", type=RAX2\n", path.display()));
    assert!(told.contains("does not fit"), "{told}");
    std::fs::write(&path, LEGACY.replace("0 1 0\n", "0 1 7\n")).expect("a file");
    let told = errors(&format!("*Mesh, input=\"{}\"\n", path.display()));
    assert!(told.contains("half plane"), "{told}");
}

#[test]
fn damaged_and_missing_files_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("mesh.vtu");
    let told = errors(&format!("*Mesh, input=\"{}\"\n", path.display()));
    assert!(told.contains("M150"), "{told}");
    let whole = VtuWriter::default().text(&mesh_frame(&build(DECK))).to_owned();
    for cut in [whole.len() / 4, whole.len() / 2, whole.len() - 40] {
        std::fs::write(&path, &whole[..cut]).expect("a file");
        assert!(errors(&format!("*Mesh, input=\"{}\"\n", path.display())).contains("M150"), "cut at {cut}");
    }
}

const SMALL: &str = r#"<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">
<UnstructuredGrid><Piece NumberOfPoints="3" NumberOfCells="2">
<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">0 0 0 1 1 0 2 4 0</DataArray></Points>
<Cells><DataArray type="Int64" Name="connectivity" format="ascii">0 1 1 2</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">2 4</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">3 3</DataArray></Cells>
<CellData><DataArray type="Int8" Name="ELSET_NOSE" format="ascii">1 0</DataArray></CellData>
</Piece></UnstructuredGrid></VTKFile>
"#;

#[test]
fn other_programs_files_are_read_or_refused_with_the_reason() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("mesh.vtu");
    let text = format!("*Mesh, input=\"{}\"\n", path.display());
    std::fs::write(&path, SMALL).expect("a file");
    assert_eq!(build(&text).element_sets["NOSE"].members, [0]);
    for (from, to, told) in [
        ("3 3<", "9 3<", "Quad with 2 points"),
        ("2 4 0", "2 nan 0", "half plane"),
        ("Int8\" Name=\"E", "Int9\" Name=\"E", "`Int9`"),
        ("ELSET_NOSE", "NOSE", "not read: NOSE"),
        ("0 1 1 2", "0 1 1 7", "points that it does not have"),
    ] {
        assert!(SMALL.contains(from));
        std::fs::write(&path, SMALL.replace(from, to)).expect("a file");
        let (deck, _) = deck::read_text("t.inp", &text, &[]);
        let found = model::build(&deck).1.render(&deck.sources);
        assert!(found.contains(told), "{found}");
    }
}
