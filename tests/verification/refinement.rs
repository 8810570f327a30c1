//! Uniform refinement of meshes that are listed node by node.
//!
//! Goal: a refined mesh is the mesh that the deck generates with more elements, and has its results. Refinement changes
//! no total of the model.
//! Source: the same decks with other numbers of elements; integrals over straight-sided elements and faces. The tolerance
//! and its reason are stated at each test.

use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::fmt::Write as _;

use revolve::deck;
use revolve::model::{self, ElementSide, LoadKind, Model};
use revolve::user::Routines;

use crate::common::random::RandomSequence;
use crate::common::solid::{copper_bar, grid, material};
use crate::common::spheres::{self, EVEN, SKEWED};
use crate::common::{self, model_of, pairs, project};

/// Returns the coordinates of the nodes of elements; merged elements leave other nodes without elements.
fn used_points(model: &Model) -> Vec<[f64; 2]> {
    let used: BTreeSet<usize> = model.mesh.elements.iter().flat_map(|e| e.nodes.to_vec()).collect();
    used.into_iter().map(|node| model.mesh.points[node]).collect()
}

/// Asserts that two meshes have the same nodes, within 1e-14 of their size, and equally many elements.
fn assert_same_nodes(what: &str, [a, b]: [&Model; 2]) {
    assert_eq!(a.mesh.elements.len(), b.mesh.elements.len(), "{what}");
    let [a, b] = [a, b].map(used_points);
    assert_eq!(a.len(), b.len(), "{what}");
    let size = a.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
    let distance = |p: &[f64; 2], q: &[f64; 2]| (p[0] - q[0]).abs().max((p[1] - q[1]).abs()) / size;
    let nearest = |p: &[f64; 2]| b.iter().map(|q| distance(p, q)).fold(f64::INFINITY, f64::min);
    let worst = a.iter().map(nearest).fold(0.0, f64::max);
    println!("{what}: {} nodes, distance {worst:.1e} of the size", a.len());
    assert!(worst <= 1e-14, "{what}: {worst:e}");
}

/// Returns the last row of the history of a deck with settings.
fn last_row(text: &str, settings: &[(&str, &str)]) -> Vec<(String, f64)> {
    let prepared = common::prepared(text, settings, &Routines::none());
    let (outcome, memory) = common::run(text, settings, &Routines::none());
    assert_eq!(outcome.halt, None);
    let row = &memory.rows.last().expect("a row").1;
    prepared.plan.columns.iter().map(|c| c.name.clone()).zip(row.iter().copied()).collect()
}

/// Compares a refined coarse deck with the fine deck: nodes within 1e-14 of the size, and the last values of all history
/// columns of single nodes and of the model within 1e-10 of the largest value of their variable. The increments are
/// those of single elements, because the global estimate depends on the order of the nodes.
fn compare(what: &str, coarse: (&str, &[(&str, &str)]), fine: (&str, &[(&str, &str)])) {
    let by_element = |text: &str| text.replace("*Dynamic, Explicit", "*Dynamic, Explicit, element by element");
    let texts = [by_element(coarse.0), by_element(fine.0)];
    assert_same_nodes(what, [&model_of(&texts[0], coarse.1), &model_of(&texts[1], fine.1)]);
    let (refined, generated) = (last_row(&texts[0], coarse.1), last_row(&texts[1], fine.1));
    let mut compared = 0;
    for (name, value) in &generated {
        let Some((_, other)) = refined.iter().find(|column| column.0 == *name) else { continue };
        // The difference of a small energy is that of the energies that it is computed from.
        let kind = if name.contains('@') { &name[..1] } else { "" };
        let alike = generated
            .iter()
            .filter(|column| if kind.is_empty() { !column.0.contains('@') } else { column.0.starts_with(kind) });
        let scale = alike.fold(f64::MIN_POSITIVE, |m, column| m.max(column.1.abs()));
        assert!((value - other).abs() <= 1e-10 * scale, "{what}: {name} {value:e} {other:e}");
        compared += 1;
    }
    assert!(compared > 1, "{what}: {compared} columns");
}

fn input(name: &str) -> String {
    std::fs::read_to_string(project("input").join(name)).expect("an input deck")
}

/// Bars, a rod through a plate in general contact, and the arc of a nose.
#[test]
fn refined_decks_have_the_results_of_generated_meshes() {
    let taylor = input("taylor_copper.inp");
    compare(
        "Taylor bar",
        (&taylor, &[("nr", "4"), ("nz", "20"), ("mesh", "2")]),
        (&taylor, &[("nr", "8"), ("nz", "40")]),
    );
    // Without element deletion, which depends on rounding errors.
    let rod = input("rod_plate_deletion.inp").replace("80.e-6", "40.e-6");
    let fine = [("nr", "6"), ("nz", "30"), ("mr", "30"), ("mz", "15"), ("strain", "60")];
    let coarse = [("nr", "2"), ("nz", "10"), ("mr", "10"), ("mz", "5"), ("strain", "60"), ("mesh", "3")];
    compare("rod and plate", (&rod, &coarse), (&rod, &fine));
    let ogive = input("ogive.inp");
    compare("ogive", (&ogive, &[("n", "5"), ("mesh", "4")]), (&ogive, &[("n", "20")]));
}

/// Meshes of listed nodes: a bars of quadrilaterals and of triangles, Lamé's cylinder under pressure, Verney's cylinder.
#[test]
fn refined_listed_meshes_have_the_results_of_finer_listed_meshes() {
    let bar = |n: [usize; 2]| copper_bar(n, false, EVEN).replace("80.e-6", "20.e-6");
    compare("copper bar", (&bar([3, 12]), &[("mesh", "2")]), (&bar([6, 24]), &[]));
    // The results of triangles depend on the order of their corners (1e-5 of the length), which is another one here.
    let bar = |n: [usize; 2], settings: &[_]| model_of(&copper_bar(n, true, SKEWED), settings);
    assert_same_nodes("triangles", [&bar([1, 1], &[("mesh", "4")]), &model_of(&copper_bar([4, 4], true, EVEN), &[])]);
    assert_same_totals("triangles", &totals(&bar([4, 9], &[])), &totals(&bar([4, 9], &[("mesh", "3")])));
    let lame = |n: usize| {
        grid(n, n / 2, false, |i, j| [10.0 + 10.0 * i as f64 / n as f64, 5.0 * j as f64 / (n / 2) as f64])
            + &material(200e3, 0.3, 7.85e-9, "")
            + &format!("*Nset, nset=INNER\n 1,\n*Nset, nset=OUTER\n {},\n", n + 1)
            + "*Step\n*Dynamic, Explicit\n , 2.e-5\n*Boundary\n ALL, 2, 2\n*Dsload\n I0, P, 1.\n\
               *Output, history, number interval=2\n*Node Output, nset=INNER\n U1\n*Node Output, nset=OUTER\n U1\n\
               *Energy Output\n ALLKE, ALLIE, ALLWK\n*End Step\n"
    };
    compare("Lame's cylinder", (&lame(4), &[("mesh", "3")]), (&lame(12), &[]));
    let verney = |n, settings: &[_]| model_of(&(spheres::verney(4.0, false, n, EVEN) + "*End Step\n"), settings);
    let mut fine = verney([8, 16], &[]);
    // Its length is a quarter of the number of elements.
    fine.mesh.points.iter_mut().for_each(|point| point[1] *= 0.5);
    assert_same_nodes("Verney's cylinder", [&verney([4, 8], &[("mesh", "2")]), &fine]);
}

/// Lamé's sphere with arcs of `*NGEN`, and rows of `*NFILL` between two arcs, or between an arc and a straight line.
#[test]
fn generated_arcs_and_rows_between_them_keep_their_shape() {
    let sphere = |outer: &str| {
        format!(
            "*Parameter\nn = 3\nm = 4\nlast = 1 + m\nout = 1 + 100*n\noutlast = out + m\n*Node\n 1, 10., 0.\n <last>, 0., 10.\n \
             <out>, 20., 0.\n <outlast>, {}\n*Ngen, line=C, nset=INNER\n 1, <last>, 1, , 0., 0.\n*Ngen{outer}, nset=OUTER\n \
             <out>, <outlast>, 1{}\n*Nfill, nset=ALL\n INNER, OUTER, <n>, 100\n*Element, type=CAX4R\n 1, 1, 101, 102, 2\n\
             *Elgen, elset=SOLID\n 1, <m>, 1, 1, <n>, 100, 100\n*Elset, elset=EI, generate\n 1, <m>, 1\n*Surface, name=I\n EI, S4\n\
             *Nset, nset=TIP\n 1,\n*Nset, nset=RIM\n <out>,\n*Nset, nset=FOOT, generate\n 1, <out>, 100\n",
            if outer.is_empty() { "0., 16." } else { "0., 20." },
            if outer.is_empty() { "" } else { ", , 0., 0." },
        ) + &material(200e3, 0.3, 7.85e-9, "")
            + "*Step\n*Dynamic, Explicit\n , 1.e-5\n*Boundary\n FOOT, 2, 2\n*Dsload\n I, P, 1.\n*Output, history, number interval=2\n\
               *Node Output, nset=TIP\n U1\n*Node Output, nset=RIM\n U1\n*Energy Output\n ALLKE, ALLIE, ALLWK\n*End Step\n"
    };
    for outer in [", line=C", ""] {
        let text = sphere(outer);
        compare("sphere", (&text, &[("mesh", "3")]), (&text, &[("n", "9"), ("m", "12")]));
    }
}

/// Arcs that `*NCOPY` copies, that `*NMAP` moves, or that are lines in polar coordinates.
#[test]
fn copied_and_mapped_arcs_keep_their_shape() {
    let ring = |outer: [&str; 2], arc: &str, after: &str| {
        let centre = if arc.is_empty() { "" } else { ", , 0., 0." };
        format!(
            "*Parameter\nn = 2\nm = 4\nlast = 1 + m\nout = 1 + 100*n\noutlast = out + m\n*Node\n 1, 10., 0.\n <last>, {}\n \
             <out>, 20., 0.\n <outlast>, {}\n*Ngen{arc}, nset=INNER\n 1, <last>, 1{centre}\n*Ngen{arc}, nset=OUTER\n \
             <out>, <outlast>, 1{centre}\n{after}*Element, type=CAX4R\n 1, 1, 101, 102, 2\n*Elgen, elset=SOLID\n \
             1, <m>, 1, 1, <n>, 100, 100\n",
            outer[0], outer[1]
        )
    };
    let fill = "*Nfill, nset=ALL\n INNER, OUTER, <n>, 100\n";
    let nmap = |set: &str| format!("*Nmap, nset={set}, type=CYLINDRICAL\n 0., 5., 0., 0., 5., 1.\n 1., 5., 0.\n");
    let polar = ["10., 80.", "20., 80."];
    let copies = "*Elcopy, element shift=5000, old set=SOLID, shift nodes=5000";
    let copied = |how: &str| format!("{fill}*Ncopy, change number=5000, old set=ALL, {how}\n");
    let mirror = copied("reflect=LINE").replace("LINE\n", "LINE\n 0., 0., 0., 1., 0., 0.\n");
    let turned = copied("shift") + " 0., 50., 0.\n 0., 50., 0., 0., 50., 1., -90.\n";
    let arcs = ["0., 10.", "0., 20."];
    let moved =
        format!("{fill}*Nmap, nset=ALL, type=RECTANGULAR\n 0., 30., 0., 1., 30., 0.\n 0., 31., 0.\n 2., 2., 1.\n");
    for (what, text) in [
        ("lines in polar coordinates", ring(polar, "", &(fill.to_owned() + &nmap("ALL")))),
        ("rows between polar lines", ring(polar, "", &(nmap("INNER") + &nmap("OUTER") + fill))),
        ("mirror image", ring(arcs, ", line=C", &mirror) + copies + ", reflect\n"),
        ("turned copy", ring(arcs, ", line=C", &turned) + copies + "\n"),
        ("copy of polar lines", ring(polar, "", &(nmap("INNER") + &nmap("OUTER") + &turned)) + copies + "\n"),
        ("mapped arcs", ring(arcs, ", line=C", &moved)),
    ] {
        let text = text + &material(200e3, 0.3, 7.85e-9, "");
        let [coarse, fine] = [[("n", "2"), ("m", "4"), ("mesh", "3")], [("n", "6"), ("m", "12"), ("mesh", "1")]];
        assert_same_nodes(what, [&model_of(&text, &coarse), &model_of(&text, &fine)]);
    }
}

/// `*NMAP` with unequal factors changes arcs into ellipses, which a refined mesh does not keep: a warning.
#[test]
fn ellipses_of_a_refined_mesh_cause_a_warning() {
    let text = |factors: &str| {
        format!(
            "*Node\n 1, 10., 0.\n 3, 0., 10.\n 101, 20., 0.\n 103, 0., 20.\n*Ngen, line=C, nset=INNER\n 1, 3, 1, , 0., 0.\n\
             *Ngen, nset=OUTER\n 101, 103, 1\n*Nset, nset=ALL\n INNER, OUTER\n*Nmap, nset=ALL, type=RECTANGULAR\n 0., 30., 0., 1., 30., 0.\n 0., 31., 0.\n\
             {factors}\n*Element, type=CAX4R, elset=SOLID\n 1, 1, 101, 102, 2\n 2, 2, 102, 103, 3\n"
        ) + &material(200e3, 0.3, 7.85e-9, "")
    };
    let warns = |factors: &str, settings: &[(&str, &str)]| {
        let (deck, _) = deck::read_text("deck.inp", &text(factors), &pairs(settings));
        let (_, diagnostics) = model::build(&deck);
        diagnostics.findings(&deck.sources).iter().any(|finding| finding.code == "M193")
    };
    assert!(warns("2., 3., 1.", &[("mesh", "3")]));
    assert!(!warns("2., 2., 1.", &[("mesh", "3")]));
    assert!(!warns("2., 3., 1.", &[]));
}

/// Six-node triangles have the nodes of the four-node mesh, divided twice as often.
#[test]
fn six_node_triangles_keep_their_midside_nodes() {
    let quads = copper_bar([4, 8], false, SKEWED);
    let deck = common::solid::in_six_node_triangles(&quads, [4, 8]);
    for (factor, count) in [("2", 4), ("3", 9)] {
        let refined = model_of(&deck, &[("mesh", factor)]);
        assert_eq!(refined.mesh.elements.len(), 16 * count);
        let coarse = totals(&model_of(&deck, &[]));
        assert_same_totals("six-node triangles", &coarse, &totals(&refined));
    }
}

/// Integrals of a model with pressures, gravity, point masses and forces.
pub fn totals(model: &Model) -> Vec<(&'static str, f64)> {
    let mesh = &model.mesh;
    // Volume and first moment along z of a triangle: exact for quadratic integrands, by the midpoints of its sides.
    let triangle = |[a, b, c]: [[f64; 2]; 3]| {
        let area = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
        let middle = |p: [f64; 2], q: [f64; 2]| [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])];
        let points = [middle(a, b), middle(b, c), middle(c, a)];
        let sum = |f: fn([f64; 2]) -> f64| points.iter().map(|&p| f(p)).sum::<f64>() * area / 3.0;
        [2.0 * PI * sum(|p| p[0]), 2.0 * PI * sum(|p| p[0] * p[1])]
    };
    let (mut volume, mut moment) = (0.0, 0.0);
    for element in 0..mesh.elements.len() {
        for [a, b, c, d] in mesh.initial_cells(element) {
            for part in [triangle([a, b, c]), triangle([a, c, d])] {
                volume += part[0];
                moment += part[1];
            }
        }
    }
    let mut all = vec![("volume", volume), ("moment", moment)];
    let masses = &model.discrete.masses;
    all.push(("point masses", masses.iter().map(|m| m.mass).sum()));
    all.push(("moment of masses", masses.iter().map(|m| m.mass * mesh.points[m.node][1]).sum()));
    for load in model.steps.iter().flat_map(|step| &step.loads) {
        match &load.kind {
            LoadKind::Pressure(sides) => all.extend(face_totals(model, &sides.faces)),
            LoadKind::Concentrated { nodes, .. } => {
                all.push(("force", nodes.iter().map(|_| load.magnitude).sum()));
                all.push(("moment of forces", nodes.iter().map(|&n| load.magnitude * mesh.points[n][0]).sum()));
            }
            _ => {}
        }
    }
    all
}

/// Returns area, resultants along r and z, and moment of a unit pressure on faces.
fn face_totals(model: &Model, faces: &[(usize, ElementSide)]) -> [(&'static str, f64); 4] {
    let mut sums = [0.0; 4];
    for &(element, side) in faces {
        let ends = model.mesh.side_nodes(element, side).expect("a side");
        let [a, b] = ends.map(|n| model.mesh.points[n]);
        let (dr, dz) = (b[0] - a[0], b[1] - a[1]);
        let mean = 0.5 * (a[0] + b[0]);
        // The integral of r^2 over the face, per length.
        let square = (a[0] * a[0] + a[0] * b[0] + b[0] * b[0]) / 3.0;
        let parts = [mean * dr.hypot(dz), mean * dz, mean * dr, square * dr];
        sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += 2.0 * PI * part);
    }
    [("area", sums[0]), ("resultant along r", sums[1]), ("resultant along z", sums[2]), ("moment of pressure", sums[3])]
}

pub fn assert_same_totals(what: &str, coarse: &[(&str, f64)], fine: &[(&str, f64)]) {
    assert_eq!(coarse.len(), fine.len(), "{what}");
    for ((name, a), (_, b)) in coarse.iter().zip(fine) {
        // Resultants and moments may cancel; the models have sizes near one.
        let scale = a.abs().max(1.0);
        assert!((a - b).abs() <= 1e-13 * scale, "{what}: {name} {a:e} {b:e}");
    }
}

/// A random mesh of quadrilaterals and triangles, and the nodes of its lines.
pub struct RandomMesh {
    pub text: String,
    /// Sets of nodes on lines of the grid.
    pub lines: Vec<(&'static str, Vec<usize>)>,
}

/// Returns a distorted grid whose cells are quadrilaterals or two triangles, with sets, pressures, gravity, forces and
/// point masses.
pub fn random_mesh(seed: u64) -> RandomMesh {
    let mut random = RandomSequence(seed);
    let (n, m) = (random.count(2, 5), random.count(2, 5));
    let node = |i: usize, j: usize| 1 + i + j * (n + 1);
    let inner = if random.next() < 0.3 { 0.0 } else { random.between(0.1, 1.0) };
    let mut text = String::from("*Node, nset=ALL\n");
    for (i, j) in (0..=m).flat_map(|j| (0..=n).map(move |i| (i, j))) {
        let mut shift = || random.between(-0.2, 0.2);
        let (dr, dz) = (shift(), shift());
        let r = if i == 0 && inner == 0.0 { 0.0 } else { inner + (i as f64 + dr).max(0.0) / n as f64 };
        let z = (j as f64 + dz) / m as f64;
        writeln!(text, " {}, {r:.17e}, {z:.17e}", node(i, j)).expect("text");
    }
    let (mut quads, mut triangles) = (String::new(), String::new());
    // Faces of the sides I0, I1, J0, J1 of the grid, and the number of elements.
    let (mut faces, mut count) = ([const { String::new() }; 4], 0);
    for (i, j) in (0..m).flat_map(|j| (0..n).map(move |i| (i, j))) {
        let corners = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
        let outer = [(i == 0, 3), (i + 1 == n, 1), (j == 0, 0), (j + 1 == m, 2)];
        let split = random.count(0, 2);
        let parts: Vec<Vec<usize>> = match split {
            0 => vec![vec![0, 1, 2, 3]],
            1 => vec![vec![0, 1, 2], vec![0, 2, 3]],
            _ => vec![vec![0, 1, 3], vec![1, 2, 3]],
        };
        for part in parts {
            count += 1;
            let list = if part.len() == 4 { &mut quads } else { &mut triangles };
            let labels: Vec<String> = part.iter().map(|&c| corners[c].to_string()).collect();
            writeln!(list, " {count}, {}", labels.join(", ")).expect("text");
            for (faces, (_, side)) in faces.iter_mut().zip(outer).filter(|(_, (is_outer, _))| *is_outer) {
                let at = |k: usize| part[k] == side && part[(k + 1) % part.len()] == (side + 1) % 4;
                if let Some(k) = (0..part.len()).find(|&k| at(k)) {
                    writeln!(faces, " {count}, S{}", k + 1).expect("text");
                }
            }
        }
    }
    let column = random.count(1, n - 1);
    let lines = vec![
        ("LEFT", (0..=m).map(|j| node(0, j)).collect::<Vec<_>>()),
        ("LOWER", (0..=n).map(|i| node(i, 0)).collect()),
        ("CORNER", (0..=m).map(|j| node(n, j)).chain((0..n).map(|i| node(i, m))).collect()),
        ("COLUMN", (0..=m).map(|j| node(column, j)).collect()),
    ];
    for (name, cells) in [("CAX4R", quads), ("CAX3", triangles)] {
        if !cells.is_empty() {
            write!(text, "*Element, type={name}, elset=SOLID\n{cells}").expect("text");
        }
    }
    for (name, members) in &lines {
        writeln!(text, "*Nset, nset={name}").expect("text");
        members.iter().for_each(|n| writeln!(text, " {n},").expect("text"));
    }
    for (name, faces) in ["I0", "I1", "J0", "J1"].into_iter().zip(&faces) {
        write!(text, "*Surface, name={name}\n{faces}").expect("text");
    }
    let part = random.count(1, count);
    text += &format!(
        "*Elset, elset=SOME, generate\n 1, {part}\n*Nset, nset=REGION, elset=SOME\n*Element, type=MASS, elset=POINTS\n 9001, {}\n \
         9002, {}\n*Mass, elset=POINTS\n 0.7\n",
        node(0, 0),
        node(n, m)
    );
    text += &material(1e5, 0.3, 1.0, "");
    text += "*Step\n*Dynamic, Explicit\n , 1.e-3\n*Boundary\n LOWER, 2, 2\n*Dsload\n I0, P, 1.\n I1, P, 2.\n J0, P, 3.\n J1, P, 4.\n\
             *Cload\n CORNER, 2, 0.3\n*Dload\n SOME, GRAV, 9.81, 0., -1.\n*End Step\n";
    RandomMesh { text, lines }
}

/// Totals within 1e-13. A set of the nodes of a line of the grid has exactly the new nodes on the edges of the line, also
/// where a triangle cuts a corner; the nodes of a region include all nodes of its elements.
#[test]
fn refinement_of_random_meshes_preserves_totals_and_lines() {
    for seed in 0..200 {
        let RandomMesh { text, lines } = random_mesh(seed);
        let factor = 2 + (seed % 3) as usize;
        let coarse = model_of(&text, &[]);
        let fine = model_of(&text, &[("mesh", &factor.to_string())]);
        assert_same_totals(&format!("seed {seed}"), &totals(&coarse), &totals(&fine));
        assert_eq!(fine.mesh.elements.len(), (coarse.mesh.elements.len() - 2) * factor * factor + 2);
        for (name, members) in lines {
            let expected = (members.len() - 1) * factor + 1;
            assert_eq!(fine.node_sets[name].members.len(), expected, "seed {seed}: {name}\n{text}");
        }
        let of = |e: &usize| fine.mesh.elements[*e].nodes.to_vec();
        let inside: BTreeSet<usize> = fine.element_sets["SOME"].members.iter().flat_map(of).collect();
        let region: BTreeSet<usize> = fine.node_sets["REGION"].members.iter().copied().collect();
        assert!(inside.is_subset(&region), "seed {seed}");
        let names: BTreeSet<&str> = fine.mesh.node_names.iter().map(|n| n.as_str()).collect();
        assert_eq!(names.len(), fine.mesh.points.len(), "labels are unique");
    }
}

/// Values listed node by node continue on the new nodes: equal ones exactly, others by interpolation.
#[test]
fn conditions_at_listed_nodes_continue_between_them() {
    let mut text = grid(2, 2, false, |i, j| [1.0 + i as f64, j as f64]) + &material(1e5, 0.3, 1.0, "");
    text += "*Initial Conditions, type=VELOCITY\n";
    for node in 1..=9 {
        writeln!(text, " {node}, 2, {}", 3 * ((node - 1) / 3)).expect("text");
    }
    text += "*Step\n*Dynamic, Explicit\n , 1.e-3\n*Boundary\n 1, 1, 1\n 2, 1, 1\n 3, 1, 1\n*End Step\n";
    let fine = model_of(&text, &[("mesh", "3")]);
    let mut velocities = vec![f64::NAN; fine.mesh.points.len()];
    for condition in &fine.initial_conditions {
        let model::InitialKind::Velocity(2, value) = condition.kind else { panic!("a velocity along z") };
        condition.members.iter().for_each(|&n| velocities[n] = value);
    }
    for (velocity, [_, z]) in velocities.iter().zip(&fine.mesh.points) {
        assert!((velocity - 3.0 * z).abs() < 1e-14, "{velocity} at {z}");
    }
    let held: BTreeSet<usize> = fine.steps[0].boundaries.iter().flat_map(|b| b.nodes.iter().copied()).collect();
    let lower: BTreeSet<usize> = (0..fine.mesh.points.len()).filter(|&n| fine.mesh.points[n][1] == 0.0).collect();
    assert_eq!(held, lower);
}

/// Equations between two lines get the pairs of new nodes; with one reference node, all new nodes are related to it.
#[test]
fn equations_and_constraints_follow_both_lines() {
    let two = |cards: &str| {
        "*Node\n 101, 1., 1.\n 102, 2., 1.\n 103, 3., 1.\n 104, 1., 2.\n 105, 2., 2.\n 106, 3., 2.\n 900, 2., 3.\n*Nset, nset=A\n 101, 102, 103\n"
            .to_owned()
            + &grid(2, 1, false, |i, j| [1.0 + i as f64, j as f64])
            + "*Element, type=CAX4R, elset=SOLID\n 11, 101, 102, 105, 104\n 12, 102, 103, 106, 105\n"
            + &material(1e5, 0.3, 1.0, "")
            + cards
            + "*Step\n*Dynamic, Explicit\n , 1.e-3\n*End Step\n"
    };
    let built = |cards: &str| {
        let (deck, _) = deck::read_text("deck.inp", &two(cards), &pairs(&[("mesh", "3")]));
        model::build(&deck)
    };
    let (paired, found) = built("*Equation\n 2\n A, 2, 1., J1, 2, -1.\n*MPC\n PIN, A, J1\n");
    assert!(!found.has_errors());
    assert_eq!(paired.constraints.equations.len(), 7);
    let of_equations = paired.constraints.equations.iter().map(|e| [e.terms[0].0, e.terms[1].0]);
    let of_pairs = paired.constraints.links.iter().flat_map(|l| l.nodes.iter().map(|&n| [n, l.reference]));
    let all: Vec<[usize; 2]> = of_equations.chain(of_pairs).collect();
    assert_eq!(all.len(), 14);
    for [a, b] in all {
        assert_eq!(paired.mesh.points[a], paired.mesh.points[b]);
    }
    let (single, _) = built("*MPC\n BEAM, A, 900\n");
    assert_eq!(single.constraints.links.iter().map(|l| l.nodes.len()).sum::<usize>(), 7);
    // A chain: the new nodes have no partner.
    let (_, found) = built("*Equation\n 2\n 101, 2, 1., 102, 2, -1.\n 2\n 102, 2, 1., 103, 2, -1.\n");
    assert!(found.iter().any(|d| d.code == "M190" && !d.labels.is_empty()));
}

/// Merged elements: a fine deck with `mesh=1/N` has the mesh and the results of the coarse deck.
#[test]
fn coarsened_decks_have_the_results_of_coarse_meshes() {
    let taylor = input("taylor_copper.inp");
    let fine = [("nr", "8"), ("nz", "40"), ("mesh", "1/2")];
    compare("merged Taylor bar", (&taylor, &fine), (&taylor, &[("nr", "4"), ("nz", "20")]));
    let rod = input("rod_plate_deletion.inp");
    let fine = [("nr", "6"), ("nz", "30"), ("mr", "30"), ("mz", "15"), ("strain", "60"), ("mesh", "1/3")];
    let coarse = [("nr", "2"), ("nz", "10"), ("mr", "10"), ("mz", "5"), ("strain", "60")];
    compare("merged rod and plate", (&rod, &fine), (&rod, &coarse));
    let ogive = input("ogive.inp");
    compare("merged ogive", (&ogive, &[("n", "20"), ("mesh", "1/4")]), (&ogive, &[("n", "5")]));
}

/// Writes the mesh of a model as a deck, with its elements in one set.
fn listed(model: &Model) -> String {
    let mut text = String::from("*Node, nset=ALL\n");
    for (name, [r, z]) in model.mesh.node_names.iter().zip(&model.mesh.points) {
        writeln!(text, " {}, {r:.17e}, {z:.17e}", name.as_str()).expect("text");
    }
    text += "*Element, type=CAX4R, elset=SOLID\n";
    for element in &model.mesh.elements {
        let nodes: Vec<&str> = element.nodes.iter().map(|&n| model.mesh.node_names[n].as_str()).collect();
        writeln!(text, " {}, {}", element.name.as_str(), nodes.join(", ")).expect("text");
    }
    text + &material(1e5, 0.3, 1.0, "")
}

/// Three quadrilaterals around an irregular node, with their first corners at different places: refined, listed, merged.
#[test]
fn blocks_around_an_irregular_node_are_found() {
    let text = "*Node\n 1, 2., 2.\n 2, 3., 2.\n 3, 3., 3.5\n 4, 2., 3.\n 5, 1., 3.2\n 6, 1., 2.\n 7, 2., 1.\n\
                *Element, type=CAX4R, elset=SOLID\n 1, 1, 2, 3, 4\n 2, 4, 5, 6, 1\n 3, 6, 7, 2, 1\n"
        .to_owned()
        + &material(1e5, 0.3, 1.0, "");
    let coarse = model_of(&text, &[]);
    for factor in [2, 3, 4] {
        let fine = model_of(&text, &[("mesh", &factor.to_string())]);
        let merged = model_of(&listed(&fine), &[("mesh", &format!("1/{factor}"))]);
        assert_same_nodes("three blocks", [&merged, &coarse]);
        assert_same_totals("three blocks", &totals(&coarse), &totals(&merged));
    }
}

/// Meshes that cannot be merged are located errors.
#[test]
fn meshes_that_cannot_be_merged_are_errors() {
    let deck = |n: usize, m: usize, triangles: bool, more: &str| {
        grid(n, m, triangles, |i, j| [i as f64, j as f64])
            + &material(1e5, 0.3, 1.0, "")
            + &format!("*Step\n*Dynamic, Explicit\n , 1.e-3\n{more}*End Step\n")
    };
    let part = "*Elset, elset=PART, generate\n 1, 3, 1\n*Surface, name=PART\n PART, S1\n";
    for (text, message) in [
        (deck(4, 3, false, ""), "a block of 4 by 3 elements"),
        (deck(4, 4, true, ""), "triangles cannot be merged"),
        (deck(4, 4, false, &format!("{part}*Dsload\n PART, P, 1.\n")), "surface PART ends inside elements"),
        (deck(4, 4, false, "*Cload\n J1, 2, 1.\n"), "a block of 1 by"),
        (deck(4, 4, false, "*Output, history\n*Node Output, nset=2\n U1\n"), "a block of 1 by 4 elements"),
    ] {
        let (read, _) = deck::read_text("deck.inp", &text, &pairs(&[("mesh", "1/2")]));
        let (_, found) = model::build(&read);
        let is_it = |d: &deck::Diagnostic| d.code == "M191" && d.message.contains(message) && !d.labels.is_empty();
        assert!(found.iter().any(is_it), "{message}: {}", found.render(&read.sources));
    }
}

/// Settings that are not numbers of parts; a parameter of the deck with the name `mesh` has precedence.
#[test]
fn bad_factors_are_errors() {
    let text = grid(1, 1, false, |i, j| [i as f64, j as f64]) + &material(1e5, 0.3, 1.0, "");
    for value in ["0", "-1", "1.5", "a", "1e9", "2/3"] {
        let (_, found) = deck::read_text("deck.inp", &text, &pairs(&[("mesh", value)]));
        assert!(found.iter().any(|d| d.code == "D408"), "{value}");
    }
    let own = format!("*Parameter\nmesh = 0.5\n{text}");
    assert_eq!(model_of(&own, &[("mesh", "0.25")]).mesh.elements.len(), 1);
    assert_eq!(model_of(&own, &[("mesh-refine", "2")]).mesh.elements.len(), 4);
}

/// A surface that lists its faces element by element: in a coarser mesh a merged element is named once for each of its parts,
/// and has the pressure once. The force of the pressure is that of the area.
#[test]
fn coarser_meshes_have_the_pressure_of_listed_faces_once() {
    let faces: String = (1..=4).map(|e| format!(" {e}, S1\n")).collect();
    let text = grid(4, 4, false, |i, j| [1.0 + 0.25 * i as f64, 0.25 * j as f64])
        + "*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n 1.,\n*Elastic\n 1., 0.25\n*Surface, name=FOOT\n"
        + &faces
        + "*Step\n*Dynamic, Explicit\n , 1.\n*Boundary\n J1, 2, 2\n*Dsload\n FOOT, P, 1e-4\n*Output, history, number interval=10\n\
           *Node Output, nset=J1\n RF2\n*Energy Output\n ALLWK\n*End Step\n";
    let work = |mesh: &str| {
        let (outcome, memory) = common::run(&text, &[("mesh", mesh)], &Routines::none());
        assert!(outcome.halt.is_none());
        let columns = common::prepared(&text, &[("mesh", mesh)], &Routines::none()).plan.columns;
        let at = columns.iter().position(|column| column.name == "ALLWK").expect("ALLWK");
        memory.rows.last().expect("a row").1[at]
    };
    let (coarse, fine) = (work("1/2"), work("1"));
    assert!((coarse / fine - 1.0).abs() < 0.2, "{coarse} {fine}");
}
