//! Groups of mesh files: the same cells, sets and surfaces from each format, as the programs write them.

use revolve::deck;
use revolve::model::{self, ElementSide, Model};

/// A square of one quadrilateral below a triangle; the foot is a group of one edge.
const GMSH2: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n1 7 \"FOOT\"\n2 8 \"BODY\"\n2 9 \"TIP\"\n\
$EndPhysicalNames\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 0 2 0\n$EndNodes\n\
$Elements\n4\n1 1 2 7 1 1 2\n2 3 2 8 1 1 2 3 4\n3 2 2 8 2 4 3 5\n4 2 2 9 2 4 3 5\n$EndElements\n";
const CLOCKWISE: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n1 7 \"FOOT\"\n2 8 \"BODY\"\n2 9 \"TIP\"\n\
$EndPhysicalNames\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 0 2 0\n$EndNodes\n\
$Elements\n4\n1 1 2 7 1 2 1\n2 3 2 8 1 1 4 3 2\n3 2 2 8 2 4 5 3\n4 2 2 9 2 4 5 3\n$EndElements\n";
const INP: &str = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 1., 1., 0.\n4, 0., 1., 0.\n5, 0., 2., 0.\n\
*ELEMENT, TYPE=EDGE, ELSET=FOOT\n11, 1, 2\n*ELEMENT, TYPE=QUAD, ELSET=BODY\n2, 1, 2, 3, 4\n\
*ELEMENT, TYPE=TRIANGLE, ELSET=BODY\n3, 4, 3, 5\n*ELSET, ELSET=TIP\n3\n";
const LEGACY: &str = "# vtk DataFile Version 4.2\nmesh\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 double\n\
0 0 0 1 0 0 1 1 0 0 1 0 0 2 0\nCELLS 3 12\n2 0 1\n4 0 1 2 3\n3 3 2 4\nCELL_TYPES 3\n3\n9\n5\n\
CELL_DATA 3\nFIELD FieldData 3\nELSET_FOOT 1 3 double\n1 0 0\nELSET_BODY 1 3 double\n0 1 1\nELSET%20TIP 1 3 double\n0 0 1\n";
const VTU: &str = r#"<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">
<UnstructuredGrid><Piece NumberOfPoints="5" NumberOfCells="3">
<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 1 1 0 0 1 0 0 2 0</DataArray></Points>
<Cells><DataArray type="Int64" Name="connectivity" format="ascii">0 1 0 1 3 2 3 2 4</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">2 6 9</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">3 8 5</DataArray></Cells>
<CellData><DataArray type="Int8" Name="ELSET_FOOT" format="ascii">1 0 0</DataArray>
<DataArray type="Int8" Name="ELSET_BODY" format="ascii">0 1 1</DataArray>
<DataArray type="Int8" Name="ELSET TIP" format="ascii">0 0 1</DataArray></CellData>
</Piece></UnstructuredGrid></VTKFile>
"#;

/// Writes a mesh file and returns the model of a deck that reads it, and the messages.
fn read(name: &str, text: &str, more: &str) -> (Model, String) {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join(name), text).expect("a file");
    let deck_text = format!("*Mesh, input=\"{}\"\n{more}", folder.path().join(name).display());
    let (deck, _) = deck::read_text("t.inp", &deck_text, &[]);
    let (model, diagnostics) = model::build(&deck);
    (model, diagnostics.render(&deck.sources))
}

fn built(name: &str, text: &str, more: &str) -> (Model, String) {
    let (model, messages) = read(name, text, more);
    assert!(!messages.contains("error["), "{name}: {messages}");
    (model, messages)
}

/// Returns the corners of the elements, with the lowest node first.
fn elements(model: &Model) -> Vec<Vec<[f64; 2]>> {
    let corners = |element: &model::Element| {
        let mut nodes: Vec<usize> = element.nodes.to_vec();
        let lowest = (0..nodes.len()).min_by_key(|&i| nodes[i]).expect("nodes");
        nodes.rotate_left(lowest);
        nodes.into_iter().map(|n| model.mesh.points[n]).collect()
    };
    model.mesh.elements.iter().map(corners).collect()
}

/// Returns the file in ABAQUS format with element types.
fn words(edge: &str, quad: &str, triangle: &str) -> String {
    INP.replace("EDGE", edge).replace("QUAD", quad).replace("TRIANGLE", triangle)
}

/// The mesh has 2 elements, each in the sets of its groups, counter-clockwise; the edge is a node set and a surface.
#[test]
fn all_formats_have_the_same_elements_sets_and_surfaces() {
    let meshio = words("B31H", "CAX4P", "R3D3");
    let clockwise =
        words("T3D2", "CPS4", "CPS3").replace("1, 2, 3, 4\n", "1, 4, 3, 2\n").replace("4, 3, 5\n", "4, 5, 3\n");
    for (name, text) in [
        ("a.msh", GMSH2),
        ("clockwise.msh", CLOCKWISE),
        ("gmsh.inp", &words("T3D2", "CPS4", "CPS3")),
        ("clockwise.inp", &clockwise),
        ("meshio.inp", &meshio),
        ("shells.inp", &words("B31", "S4", "S3R")),
        ("rigid.inp", &words("RAX2", "R3D4", "STRI3")),
        ("a.vtk", LEGACY),
        ("bytes.vtk", &LEGACY.replace("1 3 double", "1 3 signed_char")),
        ("shorts.vtk", &LEGACY.replace("1 3 double", "1 3 unsigned_short")),
        ("a.vtu", VTU),
    ] {
        let (model, _) = built(name, text, "");
        let square = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let triangle = vec![[1.0, 1.0], [0.0, 2.0], [0.0, 1.0]];
        assert_eq!(elements(&model), [square, triangle], "{name}");
        for (set, members) in [("BODY", &[0, 1][..]), ("TIP", &[1])] {
            assert_eq!(model.element_sets[set].members, members, "{name}: {set}");
        }
        assert!(!model.element_sets.contains_key("FOOT"), "{name}");
        for (set, members) in [("FOOT", &[0, 1][..]), ("BODY", &[0, 1, 2, 3, 4]), ("TIP", &[2, 3, 4])] {
            assert_eq!(model.node_sets[set].members, members, "{name}: {set}");
        }
        let [(element, ElementSide::Face(face))] = model.surfaces.faces["FOOT"].faces[..] else { panic!("{name}") };
        let nodes = &model.mesh.elements[element].nodes;
        let of_face = [nodes[face as usize - 1], nodes[face as usize % nodes.len()]];
        assert_eq!((element, of_face.iter().min(), of_face.iter().max()), (0, Some(&0), Some(&1)), "{name}");
    }
}

/// The middle point of an edge of second order is the second or the third one; the edge is a surface and no element.
#[test]
fn edges_of_second_order_are_found_in_any_order() {
    for edge in ["1, 4, 2", "1, 2, 4", "2, 4, 1"] {
        let text = format!(
            "*NODE\n1, 0., 0.\n2, 1., 0.\n3, 0., 1.\n4, 0.5, 0.\n5, 0.5, 0.5\n6, 0., 0.5\n*ELEMENT, TYPE=T3D3, ELSET=FOOT\n \
             7, {edge}\n*ELEMENT, TYPE=CPS6, ELSET=BODY\n 8, 1, 2, 3, 4, 5, 6\n"
        );
        let (model, _) = built("gmsh.inp", &text, "");
        assert_eq!(model.mesh.elements.len(), 1, "{edge}");
        // A side of a six-node triangle has two faces.
        assert_eq!(model.surfaces.faces["FOOT"].faces, [1, 2].map(|face| (0, ElementSide::Face(face))), "{edge}");
        assert_eq!(model.node_sets["FOOT"].members.len(), 3, "{edge}");
    }
}

/// Rounding errors of a turned mesh are removed; so are points outside the half-plane that nothing uses. A mesh of another plane is
/// an error that says how to turn it.
#[test]
fn rounding_errors_and_unused_points_are_removed() {
    let (expected, _) = built("a.inp", &words("T3D2", "CPS4", "CPS3"), "");
    let turned = words("T3D2", "CPS4", "CPS3").replace("1, 0., 0., 0.\n", "99, -3., 0., 7.\n1, -1e-17, 0., 2.2e-16\n");
    let (model, _) = built("turned.inp", &turned, "");
    assert_eq!(model.mesh.points, expected.mesh.points);
    assert_eq!(elements(&model), elements(&expected));
    assert_eq!(model.node_sets["TIP"].members, expected.node_sets["TIP"].members);
    let used = words("T3D2", "CPS4", "CPS3").replace("1, 0., 0., 0.\n", "1, 0., 0., 1.e-3\n");
    let (_, messages) = read("used.inp", &used, "");
    assert!(messages.contains("M126") && messages.contains("turn a mesh of the plane y = 0"), "{messages}");
}

#[test]
fn repeated_cells_are_noted_once() {
    let (_, messages) = built("a.msh", GMSH2, "");
    assert!(messages.contains("1 cells of the mesh file are listed more than once"), "{messages}");
}

/// A card of the deck with the name of a group replaces the node set or surface that follows from the group.
#[test]
fn cards_of_the_deck_replace_sets_and_surfaces_of_groups() {
    let (model, _) =
        built("a.msh", GMSH2, "*Nset, nset=FOOT\n 5\n*Surface, name=FOOT\n TIP, S2\n*Nset, nset=NEW\n FOOT, 1\n");
    assert_eq!(model.node_sets["FOOT"].members, [4]);
    assert_eq!(model.node_sets["NEW"].members, [0, 4]);
    assert_eq!(model.surfaces.faces["FOOT"].faces, [(1, ElementSide::Face(2))]);
}

/// Lines that are no edge of a face are rigid elements; the others are not.
/// Programs that write discontinuous fields give each cell separate points.
#[test]
fn faces_without_common_points_are_refused() {
    let file = |step: usize| {
        let (mut points, mut cells) = (String::new(), String::new());
        for cell in 0..4 {
            let z = cell * step;
            points += &format!("0 {z} 0 1 {z} 0 1 {} 0 0 {} 0\n", z + 1, z + 1);
            cells += &format!("4 {} {} {} {}\n", 4 * cell, 4 * cell + 1, 4 * cell + 2, 4 * cell + 3);
        }
        format!(
            "# vtk DataFile Version 3.0\nmesh\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 16 double\n{points}CELLS 4 20\n{cells}\
             CELL_TYPES 4\n9\n9\n9\n9\n"
        )
    };
    let (_, messages) = read("apart.vtk", &file(1), "");
    for words in ["error[M150]", "its 4 faces have no common points, but 12 of their 16 points", "PrintVTK", ".clean()"]
    {
        assert!(messages.contains(words), "{messages}");
    }
    // Bodies of one element with gaps between them.
    let (model, _) = built("gaps.vtk", &file(2), "");
    assert_eq!(model.mesh.elements.len(), 4);
}

#[test]
fn lines_apart_from_faces_are_rigid_elements() {
    let wall = words("T3D2", "CPS4", "CPS3")
        + "*NODE\n21, 0., -1.\n22, 2., -1.\n*ELEMENT, TYPE=R2D2, ELSET=WALL\n31, 21, 22\n";
    let (model, _) = built("wall.inp", &wall, "");
    assert_eq!(model.mesh.elements.len(), 3);
    assert_eq!(model.mesh.elements[2].kind, model::ElementKind::Rax2);
    assert_eq!(model.element_sets["WALL"].members, [2]);
}

const PARTS: &str = "*Part, name=P\n*Node\n1, 0., 0.\n2, 1., 0.\n3, 1., 1.\n4, 0., 1.\n\
*Element, type=CAX4R, elset=ROD\n1, 1, 2, 3, 4\n*Nset, nset=A\n 1, 3\n*Nset, nset=B\n A, 4\n*End Part\n\
*Assembly, name=S\n*Instance, name=P1, part=P\n 0., 10.\n*End Instance\n\
*Instance, name=P2, part=P\n 3., 0.\n 3., 0., 0., 3., 0., 1., 90.\n*End Instance\n\
*Nset, nset=TOP, instance=P1\n 3, 4\n*Nset, nset=BOTH\n P1.B, P2.2\n\
*Elset, elset=SECOND, instance=P2\n 1\n*Surface, name=FACE\n SECOND, S1\n*End Assembly\n";

/// Instances of a part are placed where their translation and rotation put them; equal labels are distinct nodes.
#[test]
fn instances_in_a_mesh_file_are_moved_and_rotated() {
    let (model, _) = built("parts.inp", PARTS, "");
    assert_eq!(model.mesh.points[..4], [[0.0, 10.0], [1.0, 10.0], [1.0, 11.0], [0.0, 11.0]]);
    for (point, expected) in model.mesh.points[4..].iter().zip([[3.0, 0.0], [3.0, 1.0], [2.0, 1.0], [2.0, 0.0]]) {
        assert!((point[0] - expected[0]).abs() + (point[1] - expected[1]).abs() < 1e-12, "{point:?}");
    }
    for (set, members) in
        [("A", &[0, 2, 4, 6][..]), ("B", &[0, 2, 3, 4, 6, 7]), ("TOP", &[2, 3]), ("BOTH", &[0, 2, 3, 5])]
    {
        assert_eq!(model.node_sets[set].members, members, "{set}");
    }
    assert_eq!(model.element_sets["ROD"].members, [0, 1]);
    let (moved, _) = built("parts.inp", PARTS, "*Nset, nset=LOW\n P2.A\n*Elset, elset=E\n P1.ROD\n");
    assert_eq!((&moved.node_sets["LOW"].members[..], &moved.element_sets["E"].members[..]), (&[4, 6][..], &[0][..]));
    assert_eq!(model.element_sets["SECOND"].members, [1]);
    assert_eq!(model.surfaces.faces["FACE"].faces, [(1, ElementSide::Face(1))]);
}

/// Two files number from 1: the labels of the second are increased.
#[test]
fn two_mesh_files_in_a_deck_are_two_bodies() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("second.msh");
    std::fs::write(&path, GMSH2.replace("BODY", "OTHER")).expect("a file");
    let (model, messages) = built("first.msh", GMSH2, &format!("*Mesh, input=\"{}\"\n", path.display()));
    assert_eq!((model.mesh.points.len(), model.mesh.elements.len()), (10, 4));
    assert_eq!(model.element_sets["OTHER"].members, [2, 3]);
    assert!(messages.contains("node labels of the mesh file are increased by 5"), "{messages}");
}

/// Salome writes names of 80 characters, filled with underscores, which Gmsh keeps.
#[test]
fn names_that_are_filled_with_underscores_are_cut() {
    let filled = format!("{:_<80}", "BODY");
    let (model, _) = built("salome.msh", &GMSH2.replace("BODY", &filled), "");
    assert_eq!(model.element_sets["BODY"].members, [0, 1]);
}

/// Instances within parts, and files that grow without bound, are refused.
#[test]
fn instances_do_not_repeat_parts_without_limit() {
    let nested = "*Part, name=P\n*Node\n1, 0., 0.\n*Instance, name=A, part=P\n*End Instance\n*End Part\n\
                  *Instance, name=B, part=P\n*End Instance\n";
    let (_, messages) = read("nested.inp", nested, "");
    assert!(messages.contains("*INSTANCE within the instance B"), "{messages}");
    let mut repeated = String::from("*Part, name=P\n");
    (0..20_000).for_each(|_| repeated.push_str("**\n"));
    repeated.push_str("*End Part\n");
    (0..1000).for_each(|i| repeated.push_str(&format!("*Instance, name=I{i}, part=P\n*End Instance\n")));
    let (_, messages) = read("repeated.inp", &repeated, "");
    assert!(messages.contains("the instances repeat more lines of parts than the limit"), "{messages}");
}

/// A rectilinear grid, as PyVista saves it as text.
const RECTILINEAR: &str = "# vtk DataFile Version 5.1\nvtk output\nASCII\nDATASET RECTILINEAR_GRID\nDIMENSIONS 2 2 1\n\
    X_COORDINATES 2 double\n0 1 \nY_COORDINATES 2 double\n0 1 \nZ_COORDINATES 1 double\n0 \n";

#[test]
fn unsupported_files_name_the_format_to_save() {
    for (name, text, expected) in [
        ("a.msh", "$NOD\n1\n1 0 0 0\n$ENDNOD\n".to_owned(), "version 1.0 is not supported: save it as version 4.1"),
        ("b.msh", GMSH2.replace("2.2 0", "4 0"), "version 4 is not supported: save it as version 4.1"),
        ("c.msh", GMSH2.replace("2.2 0", "4.1 1"), "Mesh.Binary = 0"),
        ("d.med", String::new(), "the format MED is not supported"),
        ("e.unv", String::new(), "gmsh FILE -save"),
        ("e.cgns", String::new(), "the format CGNS is not supported"),
        ("e.key", String::new(), "the format LS-DYNA is not supported"),
        ("e.vtk", RECTILINEAR.to_owned(), "cast_to_unstructured_grid"),
        (
            "e.vtr",
            "<VTKFile type=\"RectilinearGrid\" version=\"1.0\">\n</VTKFile>\n".to_owned(),
            "cast_to_unstructured_grid",
        ),
        ("f.inp", words("T3D2", "C3D8", "CPS3"), "C3D8 is three-dimensional"),
        ("g.vtk", LEGACY.replace("3\n9\n5\n", "3\n23\n5\n"), "quadrilateral of second order"),
    ] {
        let (_, messages) = read(name, &text, "");
        assert!(messages.contains("error[M150]") && messages.contains(expected), "{name}: {messages}");
    }
    let eight = "*NODE\n1, 0, 0\n2, 2, 0\n3, 2, 2\n4, 0, 2\n5, 1, 0\n6, 2, 1\n7, 1, 2\n8, 0, 1\n\
                 *ELEMENT, TYPE=CPS8\n1, 1, 2, 3, 4, 5, 6, 7, 8\n";
    let (_, messages) = read("h.inp", eight, "");
    assert!(messages.contains("has 8 nodes") && messages.contains("linear elements"), "{messages}");
}

/// Words of other families are explained; those of faces and edges name `*MESH`.
#[test]
fn element_words_of_abaqus_have_a_reason() {
    for (word, nodes, expected) in [
        ("CGAX4R", "1, 2, 3, 4", "twist about the axis"),
        ("DSAX1", "1, 2", "shells do not conduct heat"),
        ("ACAX4R", "1, 2, 3, 4", "acoustic elements are not simulated"),
        ("GAPUNI", "1, 2", "*CONTACT PAIR"),
        ("CAX4P", "1, 2, 3, 4", "*MESH, INPUT=FILE, or write TYPE=CAX4R"),
        ("S4", "1, 2, 3, 4", "*MESH, INPUT=FILE, or write TYPE=CAX4R"),
        ("R3D3", "1, 2, 3", "*MESH, INPUT=FILE, or write TYPE=CAX3"),
        ("B31H", "1, 2", "which makes sets and surfaces of its edges"),
        ("C3D8R", "1, 2, 3, 4, 5, 6, 7, 8", "three-dimensional"),
    ] {
        let text = format!("*Node\n 1, 0, 0\n 2, 1, 0\n 3, 1, 1\n 4, 0, 1\n*Element, type={word}\n 1, {nodes}\n");
        let (deck, _) = deck::read_text("t.inp", &text, &[]);
        let messages = model::build(&deck).1.render(&deck.sources);
        assert!(messages.contains(expected) && !messages.contains("did you mean"), "{word}: {messages}");
    }
}

/// Sets may precede their elements, labels may be written as `3.0`, and members that do not exist are reported.
#[test]
fn sets_of_inp_files_are_resolved_at_the_end() {
    let text = "*ELSET, ELSET=TIP\n3.0\n*NODE\n1, 0., 0.\n2, 1., 0.\n3, 1., 1.\n4, 0., 1.\n*NSET, NSET=GONE\n 77,\n\
                *ELEMENT, TYPE=CPS4\n3, 1, 2, 3, 4\n*ELSET, ELSET=ALL\n TIP\n";
    let (model, messages) = built("late.inp", text, "");
    assert_eq!(model.element_sets["TIP"].members, [0]);
    assert_eq!(model.element_sets["ALL"].members, [0]);
    assert!(!model.node_sets.contains_key("GONE"));
    assert!(messages.contains("1 members of the set GONE of the mesh file are not defined"), "{messages}");
}
