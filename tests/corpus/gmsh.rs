//! Meshes as Gmsh exports them to `.inp`: nodes with three coordinates, boundary edges as T3D2, faces as CPS3 and CPS4,
//! sets of physical groups. The names of the types are those of `src/geo/MElement*.h` of Gmsh.

use std::fmt::Write;

use crate::grid::{Grid, Side, list};
use crate::run::{Deck, assert_near};

/// What a user has edited in an export.
#[derive(Clone, Copy, PartialEq)]
enum Edited {
    No,
    TypesReplaced,
    EdgesDeleted,
}

/// Returns the export of a ring; every second column of quadrilaterals is split into triangles.
fn export(grid: &Grid, edited: Edited) -> String {
    let mut text = "*Heading\n ring.inp\n*NODE\n".to_owned();
    for (i, [r, z]) in grid.points().into_iter().enumerate() {
        let _ = writeln!(text, "{}, {r}, {z}, 0", i + 1);
    }
    text += "******* E L E M E N T S *************\n";
    let mut label = 0;
    let mut edges = String::new();
    for (line, side) in [Side::Bottom, Side::Outer, Side::Top, Side::Inner].into_iter().enumerate() {
        let _ = writeln!(edges, "*ELEMENT, type=T3D2, ELSET=Line{}", line + 1);
        for pair in grid.side_nodes(side).windows(2) {
            label += 1;
            let _ = writeln!(edges, "{label}, {}, {}", pair[0], pair[1]);
        }
    }
    let [mut quads, mut triangles] = [String::new(), String::new()];
    let first = label + 1;
    for (i, [a, b, c, d]) in grid.quads().into_iter().enumerate() {
        if (i % grid.columns()).is_multiple_of(2) {
            label += 1;
            let _ = writeln!(quads, "{label}, {a}, {b}, {c}, {d}");
        } else {
            let _ = writeln!(triangles, "{}, {a}, {b}, {c}\n{}, {a}, {c}, {d}", label + 1, label + 2);
            label += 2;
        }
    }
    let [three, four] = if edited == Edited::No { ["CPS3", "CPS4"] } else { ["CAX3", "CAX4R"] };
    if edited != Edited::EdgesDeleted {
        text += &edges;
    }
    let _ = write!(
        text,
        "*ELEMENT, type={three}, ELSET=Surface1\n{triangles}*ELEMENT, type={four}, ELSET=Surface1\n{quads}"
    );
    let elements: Vec<usize> = (first..=label).collect();
    let lines = |numbers: &[usize]| list(numbers, 10, 1).replace(',', ", ").replace('\n', ", \n");
    let _ = write!(text, "*ELSET,ELSET=ring\n{}", lines(&elements));
    for (name, side) in [("bottom", Side::Bottom), ("outer", Side::Outer), ("top", Side::Top), ("bore", Side::Inner)] {
        let _ = write!(text, "*NSET,NSET={name}\n{}", lines(&grid.side_nodes(side)));
    }
    text
}

/// The deck of a mesh, which the lines `mesh` read.
fn deck(mesh: &str, time: f64) -> String {
    format!(
        "*Heading\nexpanded ring, mesh of Gmsh\n{mesh}\n*Solid Section, elset=ring, material=steel\n\
         *Material, name=steel\n*Density\n7.85e-9\n*Elastic\n2e5, 0.3\n\
         *Amplitude, name=slow, definition=smooth step\n0, 0, {time}, 1\n*Step\n*Dynamic, Explicit\n, {time}\n\
         *Boundary\nbottom, 2\ntop, 2\n*Boundary, amplitude=slow\nbore, 1, 1, 0.01\n\
         *Output, history, time interval={}\n*Node output, nset=outer, statistics=mean\nU1\n\
         *Energy output\nALLKE, ALLIE, ALLWK, ETOTAL\n*End Step\n",
        time / 200.0
    )
}

fn ring() -> Grid {
    Grid::uniform([20.0, 0.0], [40.0, 5.0], 12, 3)
}

/// A ring in plane strain is expanded at its inner face. The deck includes an edited export, or reads the export itself with
/// `*MESH`.
///
/// Estimate: `u = A r + B / r` with a stress-free outer face. Therefore `u(b)/u(a) = 2 (1 - ν) a b / (a² (1 - 2ν) +
/// b²)` (Timoshenko and Goodier, Theory of Elasticity, chapter 4). Tolerance 1 %.
#[test]
fn expanded_ring_of_a_gmsh_mesh_has_the_displacement_of_lame() {
    let time = 1e-3;
    let (a, b, nu): (f64, f64, f64) = (20.0, 40.0, 0.3);
    let ratio = 2.0 * (1.0 - nu) * a * b / (a * a * (1.0 - 2.0 * nu) + b * b);
    for (card, edited) in [("*Include", Edited::EdgesDeleted), ("*Mesh", Edited::No)] {
        let text = deck(&format!("{card}, input=ring.inp"), time);
        let run = Deck::new(&text).with_file("ring.inp", &export(&ring(), edited)).completes(&[]);
        assert_near("outer displacement", run.mean("U1_MEAN@OUTER", 0.97 * time, time), 0.01 * ratio, 0.01);
    }
}

/// The export as it is has plane elements and edges: each message names the type to write or to delete, and no other
/// follows.
#[test]
fn unedited_gmsh_export_names_the_types_to_replace() {
    let finished = Deck::new(&deck("*Include, input=ring.inp", 1e-3))
        .with_file("ring.inp", &export(&ring(), Edited::No))
        .fails(&["M121"; 3]);
    for advice in ["write TYPE=CAX4R", "write TYPE=CAX3", "delete these lines", "*MESH, INPUT=FILE", "ring.inp:"] {
        assert!(finished.printed.contains(advice), "{advice}");
    }
}

/// With the types replaced, only the edges remain.
#[test]
fn edges_of_a_gmsh_export_are_to_be_deleted() {
    let mesh = export(&ring(), Edited::TypesReplaced);
    Deck::new(&deck("*Include, input=ring.inp", 1e-3)).with_file("ring.inp", &mesh).fails(&["M121"]);
}
