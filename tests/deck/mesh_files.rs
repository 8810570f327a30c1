//! Mesh files: a mesh written by Revolve reads back to the same model; damaged and invalid files are reported.

use revolve::deck;
use revolve::model::{self, Model};
use revolve::output::vtu::VtuWriter;

use crate::common::mesh::mesh_frame;

const DECK: &str = "*Node, nset=ALL\n 1, 0., 0.\n 2, 1., 0.\n 3, 1., 1.\n 4, 0., 1.\n 5, 0., 2.\n 20, 3., 0.\n 21, 3., 1.\n\
 30, 5., 0.\n 31, 6., 0.\n 32, 5., 1.\n 33, 5.5, 0.\n 34, 5.6, 0.5\n 35, 5., 0.5\n\
*Element, type=CAX4R, elset=BODY\n 10, 1, 2, 3, 4\n*Element, type=CAX3, elset=BODY\n 11, 4, 3, 5\n\
*Element, type=CAX6M, elset=BODY\n 12, 30, 31, 32, 33, 34, 35\n\
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
    let message_text = errors(&format!("*Mesh, input=\"{}\", type=RAX2\n", path.display()));
    assert!(message_text.contains("does not match"), "{message_text}");
    std::fs::write(&path, LEGACY.replace("0 1 0\n", "0 1 7\n")).expect("a file");
    let message_text = errors(&format!("*Mesh, input=\"{}\"\n", path.display()));
    assert!(message_text.contains("half-plane"), "{message_text}");
}

#[test]
fn damaged_and_missing_files_are_reported() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("mesh.vtu");
    let message_text = errors(&format!("*Mesh, input=\"{}\"\n", path.display()));
    assert!(message_text.contains("M150"), "{message_text}");
    let whole = VtuWriter::default().text(&mesh_frame(&build(DECK))).to_owned();
    for cut in [whole.len() / 4, whole.len() / 2, whole.len() - 40] {
        std::fs::write(&path, &whole[..cut]).expect("a file");
        assert!(errors(&format!("*Mesh, input=\"{}\"\n", path.display())).contains("M150"), "cut at {cut}");
    }
}

/// Source: the number of blocks at the start of a compressed array; numbers of points, offsets and sizes that the file
/// cannot contain.
#[test]
fn declared_sizes_that_a_file_cannot_contain_are_rejected() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("mesh.vtu");
    let rejected = |text: &[u8], why: &str| {
        std::fs::write(&path, text).expect("a file");
        let message_text = errors(&format!("*Mesh, input=\"{}\"\n", path.display()));
        assert!(message_text.contains("error[M150]") && message_text.contains("t.inp:1"), "{message_text}");
        assert!(message_text.contains(why), "{message_text}");
    };
    let compressed = SMALL
        .replace("header_type=\"UInt64\"", "header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\"")
        .replace("format=\"ascii\">1 0<", "format=\"binary\">AAAAAAABAAAAAAAAAAAAAAAAAAAAAAAA<");
    // 2^40 blocks of zero bytes: base64 of three 8-byte integers.
    rejected(
        compressed.as_bytes(),
        "array `ELSET_NOSE`: it declares 1099511627776 blocks of 0 bytes, expected 2 bytes",
    );
    let points = |count: &str| SMALL.replace("NumberOfPoints=\"3\"", &format!("NumberOfPoints=\"{count}\""));
    rejected(points("4000000000").as_bytes(), "fewer than the 12000000000 expected numbers");
    rejected(points("99999999999").as_bytes(), "more than 2^32 - 1");
    rejected(points("-3").as_bytes(), "`NumberOfPoints` is not a count");
    rejected(SMALL.replace("2 4<", "2 4000000000<").as_bytes(), "array `connectivity`");
    rejected(SMALL.replace("2 4<", "4 2<").as_bytes(), "do not increase");
    rejected(SMALL.replace("2 4<", "2 nan<").as_bytes(), "do not increase");
    rejected(SMALL.replace("ascii\">1 0<", "binary\">/////////////w==<").as_bytes(), "it declares");
    rejected(SMALL.replace("ascii\">1 0<", "ascii\">1.0<").as_bytes(), "it has 1 numbers, expected 2");
    rejected(SMALL.replace("<CellData>", &"<DataArray/>".repeat(30_000)).as_bytes(), "more than 20000 arrays");
    // Zeros that are compressed by a factor of 1000: 6.4e6 points in 200 kB.
    let mut zip = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    std::io::Write::write_all(&mut zip, &vec![0; 6_400_000 * 24]).expect("memory");
    let zeros = zip.finish().expect("memory");
    let mut raw: Vec<u8> = [1, 6_400_000 * 24, 0, zeros.len() as u64].iter().flat_map(|n| n.to_le_bytes()).collect();
    raw.extend(zeros);
    let appended = appended_file(&raw, "raw", &[0]).replace_bytes("NumberOfPoints=\"3\"", "NumberOfPoints=\"6400000\"");
    let zlib = "header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\"";
    rejected(&appended.replace_bytes("header_type=\"UInt64\"", zlib), "more than a mesh in a file of this size");
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

/// Replacement of text in a file with binary data.
trait ReplaceBytes {
    fn replace_bytes(&self, from: &str, to: &str) -> Vec<u8>;
}

impl ReplaceBytes for [u8] {
    fn replace_bytes(&self, from: &str, to: &str) -> Vec<u8> {
        let at = self.windows(from.len()).position(|w| w == from.as_bytes()).expect("the text");
        [&self[..at], to.as_bytes(), &self[at + from.len()..]].concat()
    }
}

/// Returns `SMALL` with its arrays in appended data, at the given offsets; the other arrays are unchanged.
fn appended_file(data: &[u8], encoding: &str, offsets: &[usize]) -> Vec<u8> {
    let arrays = ["0 0 0 1 1 0 2 4 0", "0 1 1 2", "2 4", "3 3", "1 0"];
    let mut text = SMALL.to_owned();
    for (array, offset) in arrays.iter().zip(offsets) {
        let to = format!("format=\"appended\" offset=\"{offset}\"><");
        text = text.replace(&format!("format=\"ascii\">{array}<"), &to);
    }
    let head = text.strip_suffix("</VTKFile>\n").expect("its end");
    let open = format!("{head}<AppendedData encoding=\"{encoding}\">\n _");
    [open.as_bytes(), data, b"</AppendedData>\n</VTKFile>\n"].concat()
}

/// Appended arrays, raw and as base64, have the values of inline arrays; truncated ones are rejected.
#[test]
fn appended_arrays_are_read() {
    use base64::Engine as _;
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("mesh.vtu");
    let text = format!("*Mesh, input=\"{}\"\n", path.display());
    let points = [0.0_f64, 0.0, 0.0, 1.0, 1.0, 0.0, 2.0, 4.0, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let whole = |numbers: &[i64]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>();
    let arrays: [Vec<u8>; 5] = [points, whole(&[0, 1, 1, 2]), whole(&[2, 4]), vec![3, 3], vec![1, 0]];
    for encoding in ["raw", "base64"] {
        let (mut data, mut offsets) = (Vec::new(), Vec::new());
        for bytes in &arrays {
            offsets.push(data.len());
            let bytes = [&(bytes.len() as u64).to_le_bytes(), bytes.as_slice()].concat();
            match encoding {
                "raw" => data.extend(bytes),
                _ => data.extend(base64::engine::general_purpose::STANDARD.encode(bytes).into_bytes()),
            }
        }
        std::fs::write(&path, appended_file(&data, encoding, &offsets)).expect("a file");
        let model = build(&text);
        assert_eq!(model.mesh.points, [[0.0, 0.0], [1.0, 1.0], [2.0, 4.0]]);
        assert_eq!(model.mesh.elements[1].nodes, [1, 2]);
        assert_eq!(model.element_sets["NOSE"].members, [0]);
        std::fs::write(&path, appended_file(&data[..data.len() - 1], encoding, &offsets)).expect("a file");
        assert!(errors(&text).contains("array `ELSET_NOSE`: it is truncated"), "{}", errors(&text));
    }
}

#[test]
fn files_of_other_programs_are_read_or_rejected_with_a_reason() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("mesh.vtu");
    let text = format!("*Mesh, input=\"{}\"\n", path.display());
    std::fs::write(&path, SMALL).expect("a file");
    assert_eq!(build(&text).element_sets["NOSE"].members, [0]);
    for (from, to, message_text) in [
        ("3 3<", "9 3<", "cell 1 is a quadrilateral with 2 points, expected 4"),
        ("3 3<", "3 12<", "cell 2 has the VTK type 12"),
        ("2 4 0", "2 nan 0", "half-plane"),
        ("Int8\" Name=\"E", "Int9\" Name=\"E", "`Int9`"),
        ("ELSET_NOSE", "NOSE", "not read: NOSE"),
        ("0 1 1 2", "0 1 1 7", "points that do not exist"),
        ("0 1 1 2", "0 1 1 -1", "points that do not exist"),
        ("header_type=\"UInt64\"", "compressor=\"vtkLZMADataCompressor\"", "`vtkLZMADataCompressor` is not supported"),
        ("format=\"ascii\">1 0", "format=\"appended\" offset=\"0\">", "outside the appended data"),
    ] {
        assert!(SMALL.contains(from));
        std::fs::write(&path, SMALL.replace(from, to)).expect("a file");
        let (deck, _) = deck::read_text("t.inp", &text, &[]);
        let found = model::build(&deck).1.render(&deck.sources);
        assert!(found.contains(message_text), "{found}");
    }
}

const GMSH2: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n1 7 \"AXIS\"\n2 8 \"BODY\"\n$EndPhysicalNames\n\
$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 0 2 0\n$EndNodes\n\
$Elements\n4\n1 1 2 7 1 1 4\n2 1 2 7 1 4 5\n3 3 2 8 1 1 2 3 4\n4 2 2 8 1 5 3 4\n$EndElements\n";

const GMSH4: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n1 7 \"AXIS\"\n2 8 \"BODY\"\n$EndPhysicalNames\n\
$Entities\n1 1 1 0\n1 0 0 0 0\n1 0 0 0 0 2 0 1 7 2 1 -1\n1 0 0 0 1 2 0 1 8 1 1\n$EndEntities\n\
$Nodes\n2 5 1 5\n1 1 0 3\n1\n4\n5\n0 0 0\n0 1 0\n0 2 0\n2 1 0 2\n2\n3\n1 0 0\n1 1 0\n$EndNodes\n\
$Elements\n3 4 1 4\n1 1 1 2\n1 1 4\n2 4 5\n2 1 3 1\n3 1 2 3 4\n2 1 2 1\n4 5 3 4\n$EndElements\n";

const INP: &str = "*Heading\n made by a mesher\n*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 1, 1, 0\n4, 0, 1, 0\n5, 0, 2, 0\n\
******* E L E M E N T S *************\n*ELEMENT, type=T3D2, ELSET=Line1\n1, 1, 4\n2, 4, 5\n*ELEMENT, type=CPS4, ELSET=Surface1\n3, 1, 2, 3,\n 4\n\
*ELEMENT, type=CPS3, ELSET=Surface2\n4, 4, 3, 5\n*ELSET,ELSET=BODY\n3, Surface2\n*ELSET,ELSET=AXIS, GENERATE\n1, 2\n*STEP\n";

const GMSH_SECOND_ORDER: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n\
$Nodes\n6\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0.5 0 0\n5 0.6 0.5 0\n6 0 0.5 0\n$EndNodes\n\
$Elements\n1\n1 9 2 0 1 1 2 3 4 5 6\n$EndElements\n";

/// Files and decks list corner nodes first; the model numbers nodes along the boundary, and each face has two segments.
#[test]
fn six_node_triangles_are_numbered_along_the_boundary() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("mesh.msh");
    std::fs::write(&path, GMSH_SECOND_ORDER).expect("a file");
    let listed = "*Node\n 1, 0., 0.\n 2, 1., 0.\n 3, 0., 1.\n 4, 0.5, 0.\n 5, 0.6, 0.5\n 6, 0., 0.5\n\
                  *Element, type=CAX6M\n 1, 1, 2, 3, 4, 5, 6\n";
    for text in [format!("*Mesh, input=\"{}\"\n", path.display()), listed.to_owned()] {
        let model = build(&(text + "*Elset, elset=E\n 1,\n*Surface, name=RIM\n E, S2\n"));
        let element = &model.mesh.elements[0];
        assert_eq!(element.kind, model::ElementKind::Cax6m);
        let names: Vec<&str> = element.nodes.iter().map(|&n| model.mesh.node_names[n].as_str()).collect();
        assert_eq!(names, ["1", "4", "2", "5", "3", "6"]);
        let faces = &model.surfaces.faces["RIM"].faces;
        assert_eq!(faces, &[(0, model::ElementSide::Face(3)), (0, model::ElementSide::Face(4))]);
    }
    for (nodes, what) in [("1, 3, 2, 6, 5, 4", "clockwise"), ("1, 2, 3, 6, 5, 4", "folded")] {
        let message_text = errors(&listed.replace("1, 2, 3, 4, 5, 6", nodes));
        assert!(message_text.contains("M123") && message_text.contains(what), "{message_text}");
    }
    assert!(errors(&listed.replace("CAX6M", "CAX6MT")).contains("M121"));
}

/// In files of mesh generators, cells of the highest dimension become elements and groups of lower dimension become
/// node sets.
#[test]
fn files_of_mesh_generators_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in [("two.msh", GMSH2), ("four.msh", GMSH4), ("mesh.inp", INP)] {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("a file");
        let model = build(&format!("*Mesh, input=\"{}\"\n", path.display()));
        let at =
            |label: &str| model.mesh.points[model.mesh.node_names.iter().position(|n| n == label).expect("a node")];
        assert_eq!(["1", "2", "3", "4", "5"].map(at), [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 2.0]]);
        let corners = |i: usize| {
            let e = &model.mesh.elements[i];
            (e.name.as_str(), e.kind, e.nodes.iter().map(|&n| model.mesh.points[n]).collect::<Vec<_>>())
        };
        let quad = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        assert_eq!(corners(0), ("3", model::ElementKind::Cax4r, quad), "{name}");
        assert_eq!((corners(1).0, corners(1).1), ("4", model::ElementKind::Cax3), "{name}");
        assert_eq!(model.element_sets["BODY"].members, [0, 1], "{name}");
        let axis: Vec<&str> =
            model.node_sets["AXIS"].members.iter().map(|&n| model.mesh.node_names[n].as_str()).collect();
        assert_eq!(axis, ["1", "4", "5"], "{name}");
    }
    let refused = |name: &str, text: &str, why: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("a file");
        let message_text = errors(&format!("*Mesh, input=\"{}\"\n", path.display()));
        assert!(message_text.contains("M150") && message_text.contains(why), "{message_text}");
    };
    refused("a.msh", &GMSH2.replace("2.2 0", "2.2 1"), "binary");
    refused("b.msh", &GMSH2.replace("2.2 0", "3.0 0"), "version 3.0 is not supported");
    refused("c.msh", &GMSH2.replace("$EndElements", ""), "not closed");
    refused("n.msh", "$\r\u{fffd}M\n3 1\n$End\u{fffd}M\n", "does not begin with $MeshFormat");
    refused("d.msh", &GMSH2.replace("8 1 1 2 3 4", "8 1 1 2 3 9"), "refers to an undefined node");
    refused("e.inp", &INP.replace("CPS4", "C3D4"), "three-dimensional");
    refused("f.inp", &INP.replace("1, 1, 4", "1, x, 4"), "not a whole number");
}

/// A copied, mirrored and mapped mesh equals the mesh defined node by node.
#[test]
fn copied_and_mapped_meshes_match_listed_nodes() {
    let half = "*Node, nset=LOW\n 1, 0., 0.\n 2, 1., 0.\n 3, 0., 1.\n 4, 1., 1.\n*Element, type=CAX4R, elset=A\n 1, 1, 2, 4, 3\n";
    let points = |text: &str| build(text).mesh.points.clone();
    let moved = points(&format!("{half}*Ncopy, old set=LOW, change number=10, shift\n 0., 2., 0.\n"));
    assert_eq!(moved[4..], [[0.0, 2.0], [1.0, 2.0], [0.0, 3.0], [1.0, 3.0]]);
    for reflect in ["LINE\n 0., 1., 0., 1., 1., 0.\n", "MIRROR\n 0., 1., 0., 1., 1., 0.\n 0., 1., 1.\n"] {
        let text = format!(
            "{half}*Ncopy, old set=LOW, change number=10, new set=HIGH, reflect={reflect}\
             *Elcopy, old set=A, element shift=5, shift nodes=10, new set=B, reflect\n"
        );
        let model = build(&text);
        assert_eq!(model.mesh.points[4..], [[0.0, 2.0], [1.0, 2.0], [0.0, 1.0], [1.0, 1.0]]);
        assert_eq!(model.mesh.elements[1].nodes, [4, 6, 7, 5]);
        assert_eq!((model.mesh.elements[1].name.as_str(), model.element_sets["B"].members.len()), ("6", 1));
        assert_eq!(model.node_sets["HIGH"].members, [4, 5, 6, 7]);
    }
    let polar = points(
        "*Node, nset=ALL\n 1, 1., 0.\n 2, 2., 0.\n 3, 1., 90.\n 4, 2., 90.\n\
         *Nmap, nset=ALL, type=CYLINDRICAL\n 0., 5., 0., 0., 5., 1.\n 1., 5., 0.\n",
    );
    assert_eq!(polar, [[1.0, 5.0], [2.0, 5.0], [0.0, 6.0], [0.0, 7.0]]);
    assert_eq!(points("*Node, system=C\n 1, 2., 90.\n"), [[0.0, 2.0]]);
    let turned = points("*System\n 1., 1., 0., 1., 2., 0.\n*Node\n 1, 3., -1.\n*System\n*Node\n 2, 3., -1.\n");
    assert_eq!(turned, [[2.0, 4.0], [3.0, -1.0]]);
    // A node defined by two cards is one error, not seven.
    let slip = "*Node\n 1, 0., 0.\n 3, 2., 0.\n 21, 0., 2.\n 23, 2., 2.\n*Ngen, nset=LOW\n 1, 3\n*Ngen, nset=TOP\n 21, 23\n\
                *Nfill, nset=ALL\n LOW, TOP, 10, 2\n*Element, type=CAX4R, elset=A\n 1, 1, 2, 4, 3\n*Elgen, elset=A\n 1, 2, 1, 1, 10, 2, 2\n";
    let message_text = errors(slip);
    assert!(
        message_text.contains("M164") && message_text.contains("generated again") && !message_text.contains("M123"),
        "{message_text}"
    );
}
