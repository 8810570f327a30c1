//! Mesh files that programs have written (`tests/writers`, whose README names program, version and command): each is the
//! same rod above the same plate, and reads to the same masses, sets and surfaces without a change of the file.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use revolve::deck;
use revolve::model::{self, ElementSide, Model};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/writers")
}

fn read(file: &str) -> (Model, String) {
    let text = format!("*Mesh, input=\"{}\"\n", folder().join(file).display());
    let (deck, _) = deck::read_text("t.inp", &text, &[]);
    let (model, diagnostics) = model::build(&deck);
    (model, diagnostics.render(&deck.sources))
}

/// Files that are not read, and a part of the message.
const NOT_READ: &[(&str, &str)] = &[
    ("freecad_coarse.med", "the format MED is not supported"),
    ("freecad_coarse.unv", "the format I-DEAS universal is not supported"),
    ("medcoupling_coarse.med", "the format MED is not supported"),
    ("gmsh_8_nodes_coarse.inp", "has 8 nodes"),
    ("gmsh_msh10_coarse.msh", "version 1.0 is not supported: save it as version 4.1"),
    ("gmsh_msh40_coarse.msh", "version 4 is not supported: save it as version 4.1"),
    ("gmsh_msh22_binary_coarse.msh", "Mesh.Binary = 0"),
    ("gmsh_msh41_binary_coarse.msh", "Mesh.Binary = 0"),
    ("meshio_msh22_binary_coarse.msh", "Mesh.Binary = 0"),
    ("medcoupling_binary.vtu", "WriteVTK(name, False)"),
    ("mfem_apart_coarse.vtu", "have no common points"),
    ("mfem_high_order_coarse.vtu", "has the VTK type 70"),
    ("ngsolve_apart_coarse.vtk", "have no common points"),
    ("ngsolve_apart_coarse.vtu", "have no common points"),
    ("vtk_lzma_coarse.vtu", "`vtkLZMADataCompressor` is not supported"),
];

/// Files without names of groups, or whose program has lost them: only the elements are compared.
const WITHOUT_GROUPS: &[&str] = &[
    "freecad.vtu",
    "freecad_calculix.inp",
    "freecad_coarse.vtk",
    "freecad_export.inp",
    "freecad_fem_coarse.inp",
    "gmsh_ascii.vtk",
    "gmsh_binary_coarse.vtk",
    "kratos_ascii_coarse.vtk",
    "kratos_binary_coarse.vtk",
    "meshio_cell_sets.vtu",
    "meshio_cell_sets_vtk51_coarse.vtk",
    "meshio_edges_cell_sets_coarse.vtu",
    "meshio_from_gmsh.vtu",
    "meshio_from_gmsh_coarse.inp",
    "meshio_msh41_coarse.msh",
    "mfem_coarse.vtk",
    "netgen_gmsh2.msh",
    "netgen_quads_gmsh2.msh",
    "netgen_second_order_gmsh2.msh",
    "pygmsh_meshio_coarse.inp",
];
/// Files with ROD and PLATE only, and files without BODY.
const WITHOUT_BOUNDARIES: &[&str] = &["cgx_bodies_coarse.inp", "freecad_highest.inp", "meshpy_second_order.vtk"];
const WITHOUT_BODY: &[&str] = &[
    "cgx_bodies_coarse.inp",
    "gmsh_clockwise_coarse.inp",
    "gmsh_clockwise_msh41_coarse.msh",
    "gmsh_msh22_one_group_coarse.msh",
    "gmsh_one_group_coarse.inp",
    "meshio_from_gmsh_msh41_coarse.msh",
    "meshio_msh22_coarse.msh",
    "netgen_abaqus.inp",
];
/// Files with coordinates of single precision.
const SINGLE_PRECISION: &[&str] = &[
    "freecad.vtu",
    "freecad_coarse.vtk",
    "kratos_ascii_coarse.vtk",
    "kratos_binary_coarse.vtk",
    "meshio_vtk42_float_coarse.vtk",
];

/// Volumes of the rod and of the plate.
const VOLUMES: [f64; 2] = [PI * 25e-6 * 0.03, PI * 2.5e-3 * 0.006];

fn corners(model: &Model, element: usize) -> Vec<[f64; 2]> {
    model.mesh.elements[element].nodes.iter().map(|&node| model.mesh.points[node]).collect()
}

/// Returns the volume of revolution of a polygon: 2 pi times the first moment of its area about the axis.
fn volume(corners: &[[f64; 2]]) -> f64 {
    let pair = |i: usize| (corners[i], corners[(i + 1) % corners.len()]);
    (0..corners.len()).map(pair).map(|([r, z], [s, y])| PI / 3.0 * (r + s) * (r * y - s * z)).sum()
}

fn centre_height(model: &Model, element: usize) -> f64 {
    let corners = corners(model, element);
    corners.iter().map(|corner| corner[1]).sum::<f64>() / corners.len() as f64
}

/// Conditions of the boundary groups: on the boundary or not, by coordinates and body.
fn is_on_boundary(name: &str, [r, z]: [f64; 2], is_rod: bool) -> bool {
    let near = |a: f64, b: f64| (a - b).abs() < 1e-7;
    match name {
        "TIP" => is_rod && near(z, 0.006) || is_rod && near(z, 0.0061) && r < 0.0051,
        "TAIL" => is_rod && z > 0.036 - 1e-7,
        "EDGE" => !is_rod && near(r, 0.05),
        _ => !is_rod && near(z, 0.006),
    }
}

fn check_groups(file: &str, model: &Model) {
    let prefix =
        |kind: &str, name: &str| if file.starts_with("cgx") { format!("{kind}{name}") } else { name.to_owned() };
    let all = 0..model.mesh.elements.len();
    for (name, is_member) in [("ROD", true), ("PLATE", false)] {
        let expected: Vec<usize> = all.clone().filter(|&e| (centre_height(model, e) > 0.006) == is_member).collect();
        assert_eq!(model.element_sets[&prefix("E", name)].members, expected, "{file}: {name}");
    }
    if !WITHOUT_BODY.contains(&file) {
        assert_eq!(model.element_sets[&prefix("E", "BODY")].members, all.clone().collect::<Vec<_>>(), "{file}: BODY");
    }
    if WITHOUT_BOUNDARIES.contains(&file) {
        return;
    }
    let mut is_of_rod = vec![false; model.mesh.points.len()];
    for &element in &model.element_sets[&prefix("E", "ROD")].members {
        model.mesh.elements[element].nodes.iter().for_each(|&node| is_of_rod[node] = true);
    }
    let mut is_of_element = vec![false; model.mesh.points.len()];
    model.mesh.elements.iter().flat_map(|e| e.nodes.iter()).for_each(|&node| is_of_element[node] = true);
    for name in ["TIP", "TAIL", "EDGE", "TOP"] {
        let is_member = |n: &usize| is_of_element[*n] && is_on_boundary(name, model.mesh.points[*n], is_of_rod[*n]);
        let expected: Vec<usize> = (0..model.mesh.points.len()).filter(is_member).collect();
        assert_eq!(model.node_sets[&prefix("N", name)].members, expected, "{file}: {name}");
        let Some(surface) = model.surfaces.faces.get(name) else { continue };
        assert_eq!(surface.faces.len() + 1, expected.len(), "{file}: faces of {name}");
        for &(element, side) in &surface.faces {
            let ElementSide::Face(face) = side else { panic!("{file}: {name}") };
            let nodes = &model.mesh.elements[element].nodes;
            for node in [nodes[face as usize - 1], nodes[face as usize % nodes.len()]] {
                assert!(expected.contains(&node), "{file}: face {face} of element {element} is not on {name}");
            }
        }
    }
}

/// Groups of edges are surfaces in these files.
const WITH_SURFACES: &[&str] = &[
    "abaqus_flat.inp",
    "abaqus_instances_translated.inp",
    "freecad_all.inp",
    "gmsh_edges_coarse.inp",
    "gmsh_msh22.msh",
    "gmsh_msh41.msh",
    "meshio_abaqus_edges.inp",
    "netgen_abaqus.inp",
    "pygmsh_gmsh_coarse.msh",
];

#[test]
fn files_of_mesh_programs_have_the_same_masses_sets_and_surfaces() {
    let mut count = 0;
    let entries = std::fs::read_dir(folder()).expect("the folder");
    let mut files: Vec<String> =
        entries.map(|e| e.expect("an entry").file_name().into_string().expect("a name")).collect();
    files.sort();
    let is_mesh = |file: &&String| ["inp", "msh", "vtk", "vtu", "vtp", "med", "unv"].iter().any(|e| file.ends_with(e));
    for file in files.iter().filter(is_mesh).map(String::as_str) {
        let (model, messages) = read(file);
        if let Some((_, expected)) = NOT_READ.iter().find(|entry| entry.0 == file) {
            assert!(messages.contains("error[M150]") && messages.contains(expected), "{file}: {messages}");
            continue;
        }
        assert!(!messages.contains("error["), "{file}: {messages}");
        let mut volumes = [0.0; 2];
        for element in 0..model.mesh.elements.len() {
            let is_plate = centre_height(&model, element) < 0.006;
            volumes[usize::from(is_plate)] += volume(&corners(&model, element));
        }
        let tolerance = if SINGLE_PRECISION.contains(&file) { 1e-7 } else { 1e-12 };
        for (volume, expected) in volumes.iter().zip(VOLUMES) {
            assert!((volume / expected - 1.0).abs() < tolerance, "{file}: volume {volume}, expected {expected}");
        }
        if !WITHOUT_GROUPS.contains(&file) {
            check_groups(file, &model);
        }
        if WITH_SURFACES.contains(&file) {
            for name in ["TIP", "TAIL", "EDGE", "TOP"] {
                assert!(model.surfaces.faces.contains_key(name), "{file}: surface {name}");
            }
        }
        count += 1;
    }
    assert!(count > 80, "{count} files");
}
