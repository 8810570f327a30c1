//! Decks of one deformable body and their results.

use std::fmt::Write as _;

use revolve::solve::Outcome;
use revolve::user::Routines;

use super::spheres::MeshMap;
use super::{RecordedOutput, prepared};

/// Returns nodes and elements of a grid of `n` by `m` cells; `place(i, j)` gives `[r, z]` of node 1 + i + j (n + 1). A
/// grid of quadrilaterals has node sets and surfaces I0, I1, J0, J1 on its four edges.
pub fn grid(n: usize, m: usize, triangles: bool, place: impl Fn(usize, usize) -> [f64; 2]) -> String {
    let node = |i: usize, j: usize| 1 + i + j * (n + 1);
    let mut text = String::from("*Node, nset=ALL\n");
    for j in 0..=m {
        for i in 0..=n {
            let [r, z] = place(i, j);
            writeln!(text, " {}, {r:.17e}, {z:.17e}", node(i, j)).expect("text");
        }
    }
    if triangles {
        text += "*Element, type=CAX3, elset=SOLID\n";
        for (e, (i, j)) in (0..m).flat_map(|j| (0..n).map(move |i| (i, j))).enumerate() {
            let [a, b, c, d] = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
            writeln!(text, " {}, {a}, {b}, {c}\n {}, {a}, {c}, {d}", 2 * e + 1, 2 * e + 2).expect("text");
        }
        return text;
    }
    text += "*Element, type=CAX4R, elset=SOLID\n";
    for (e, (i, j)) in (0..m).flat_map(|j| (0..n).map(move |i| (i, j))).enumerate() {
        let [a, b, c, d] = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
        writeln!(text, " {}, {a}, {b}, {c}, {d}", e + 1).expect("text");
    }
    for (name, first, last, step) in [
        ("I0", node(0, 0), node(0, m), n + 1),
        ("I1", node(n, 0), node(n, m), n + 1),
        ("J0", node(0, 0), node(n, 0), 1),
        ("J1", node(0, m), node(n, m), 1),
    ] {
        writeln!(text, "*Nset, nset={name}, generate\n {first}, {last}, {step}").expect("text");
    }
    for (name, side, first, last, step) in [
        ("I0", 4, 1, 1 + (m - 1) * n, n),
        ("I1", 2, n, m * n, n),
        ("J0", 1, 1, n, 1),
        ("J1", 3, 1 + (m - 1) * n, m * n, 1),
    ] {
        writeln!(text, "*Elset, elset=E{name}, generate\n {first}, {last}, {step}").expect("text");
        writeln!(text, "*Surface, name={name}\n E{name}, S{side}").expect("text");
    }
    text
}

/// Returns a deck whose mesh, a [`grid`] of `n` by `m` quadrilaterals (both even), is replaced by six-node triangles
/// (CAX6M): two for four quadrilaterals, with the same nodes and surfaces.
pub fn in_six_node_triangles(deck: &str, [n, m]: [usize; 2]) -> String {
    let (begin, end) = ("*Element, type=CAX4R, elset=SOLID\n", "*Surface, name=J1\n EJ1, S3\n");
    let from = deck.find(begin).expect("elements of a grid");
    let to = from + deck[from..].find(end).expect("surfaces of a grid") + end.len();
    let node = |i: usize, j: usize| 1 + i + j * (n + 1);
    let mut text = String::from("*Element, type=CAX6M, elset=SOLID\n");
    let mut sides = [("I0", 3, vec![]), ("I1", 2, vec![]), ("J0", 1, vec![]), ("J1", 2, vec![])];
    for (cell, (i, j)) in (0..m / 2).flat_map(|j| (0..n / 2).map(move |i| (2 * i, 2 * j))).enumerate() {
        let [a, b, c, d] = [node(i, j), node(i + 2, j), node(i + 2, j + 2), node(i, j + 2)];
        let [below, right, middle] = [node(i + 1, j), node(i + 2, j + 1), node(i + 1, j + 1)];
        let [above, left] = [node(i + 1, j + 2), node(i, j + 1)];
        let (lower, upper) = (2 * cell + 1, 2 * cell + 2);
        writeln!(text, " {lower}, {a}, {b}, {c}, {below}, {right}, {middle}").expect("text");
        writeln!(text, " {upper}, {a}, {c}, {d}, {middle}, {above}, {left}").expect("text");
        let outside = [(i == 0, upper), (i + 2 == n, lower), (j == 0, lower), (j + 2 == m, upper)];
        for (side, (_, element)) in sides.iter_mut().zip(outside).filter(|(_, (is_outside, _))| *is_outside) {
            side.2.push(element);
        }
    }
    for (name, first, last, step) in [
        ("I0", node(0, 0), node(0, m), n + 1),
        ("I1", node(n, 0), node(n, m), n + 1),
        ("J0", node(0, 0), node(n, 0), 1),
        ("J1", node(0, m), node(n, m), 1),
    ] {
        writeln!(text, "*Nset, nset={name}, generate\n {first}, {last}, {step}").expect("text");
    }
    for (name, side, elements) in sides {
        writeln!(text, "*Elset, elset=E{name}").expect("text");
        elements.iter().for_each(|e| writeln!(text, " {e},").expect("text"));
        writeln!(text, "*Surface, name={name}\n E{name}, S{side}").expect("text");
    }
    deck[..from].to_owned() + &text + &deck[to..]
}

pub fn material(e: f64, nu: f64, density: f64, more: &str) -> String {
    format!(
        "*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n {density:e},\n*Elastic\n {e:e}, {nu}\n{more}"
    )
}

/// Card of a step whose linear bulk viscosity acts on the whole rate: stresses settle sooner after a front.
pub const WHOLE_VISCOSITY: &str = "*Bulk Viscosity, linear term=UNFILTERED\n 0.06, 1.2\n";

/// Returns the deck of a copper bar (3.2 by 32.4 mm) that hits a rigid wall at 227 m/s, for 80 microseconds, with
/// history rows of its tip and of the rim of its foot.
pub fn copper_bar([n, m]: [usize; 2], triangles: bool, warp: MeshMap) -> String {
    let place = |i: usize, j: usize| {
        let [x, y] = warp([i as f64 / n as f64, j as f64 / m as f64]);
        [3.2 * x, 32.4 * y]
    };
    let (row, tip) = (n + 1, 1 + m * (n + 1));
    grid(n, m, triangles, place)
        + &format!(
            "*Nset, nset=AXIS, generate\n 1, {tip}, {row}\n*Nset, nset=FOOT, generate\n 1, {row}, 1\n\
             *Nset, nset=TIP\n {tip},\n*Nset, nset=RIM\n {row},\n"
        )
        + &material(117e3, 0.35, 8.93e-9, "*Plastic\n 400., 0.\n 500., 1.\n 700., 3.\n")
        + "*Initial Conditions, type=VELOCITY\n ALL, 2, -227.e3\n*Step\n*Dynamic, Explicit\n , 80.e-6\n\
           *Boundary\n AXIS, 1, 1\n FOOT, 2, 2\n*Output, history, number interval=1\n*Node Output, nset=TIP\n COOR2\n\
           *Node Output, nset=RIM\n COOR1\n*End Step\n"
}

pub fn run(text: &str) -> (Outcome, RecordedOutput) {
    super::run(text, &[], &Routines::none())
}

/// Returns time and value of each row of a column. The deck is read again only if the output has no names of columns: this
/// takes longer than many runs.
pub fn column(text: &str, memory: &RecordedOutput, name: &str) -> Vec<(f64, f64)> {
    let read_again = || RecordedOutput::of(&prepared(text, &[], &Routines::none())).columns;
    let names = if memory.columns.is_empty() { &read_again() } else { &memory.columns };
    let at = names.iter().position(|column| column == name).expect("a column");
    memory.rows.iter().map(|row| (row.0, row.1[at])).collect()
}

pub fn last(text: &str, memory: &RecordedOutput, name: &str) -> f64 {
    column(text, memory, name).last().expect("a row").1
}
