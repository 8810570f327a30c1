//! Decks as PrePoMax exports them for CalculiX: title comments, no parts, internal sets, coordinates with three-digit
//! exponents, `*Node file` and `*El file` requests. The step card is that of CalculiX: `*Dynamic, Explicit=n` with four
//! values.

use std::fmt::Write;

use crate::grid::{Grid, Side, list};
use crate::run::{Deck, assert_near};

/// Returns a number in the format of CalculiX files.
fn number(x: f64) -> String {
    let text = format!("{x:.8E}");
    let (digits, exponent) = text.split_once('E').expect("an exponent");
    format!("{digits}E{:+04}", exponent.parse::<i32>().expect("a number"))
}

/// Returns a title comment.
fn title(name: &str) -> String {
    let rest = "+".repeat(58 - name.len());
    format!("**\n** {name} {rest}\n**\n")
}

/// What a user has edited in an export.
#[derive(Clone, Copy, PartialEq)]
enum Edited {
    No,
    Step,
}

/// Nodes, elements, sets and surfaces of parts, numbered across parts.
#[derive(Default)]
struct Export {
    nodes: String,
    elements: String,
    sets: String,
    surfaces: String,
    node_count: usize,
    element_count: usize,
}

impl Export {
    /// Adds a part; returns the offsets of its nodes and elements.
    fn add(&mut self, name: &str, grid: &Grid) -> [usize; 2] {
        let offsets = [self.node_count, self.element_count];
        for [r, z] in grid.points() {
            self.node_count += 1;
            let _ = writeln!(self.nodes, "{}, {}, {}, {}", self.node_count, number(r), number(z), number(0.0));
        }
        let _ = writeln!(self.elements, "*Element, Type=CAX4R, Elset={name}");
        for quad in grid.quads() {
            self.element_count += 1;
            let [a, b, c, d] = quad.map(|n| n + offsets[0]);
            let _ = writeln!(self.elements, "{}, {a}, {b}, {c}, {d}", self.element_count);
        }
        offsets
    }

    /// Adds a node set.
    fn add_nodes(&mut self, name: &str, grid: &Grid, side: Side, offset: usize) {
        let nodes: Vec<_> = grid.side_nodes(side).iter().map(|n| n + offset).collect();
        let _ = write!(self.sets, "*Nset, Nset={name}\n{}", list(&nodes, 16, 1).replace(',', ", "));
    }

    /// Adds a surface with its internal element set.
    fn add_surface(&mut self, name: &str, grid: &Grid, side: Side, offset: usize) {
        let elements: Vec<_> = grid.side_elements(side).iter().map(|n| n + offset).collect();
        let face = side.face();
        let _ = write!(self.sets, "*Elset, Elset=internal-1_{name}_{face}\n{}", list(&elements, 16, 1));
        let _ = write!(self.surfaces, "*Surface, Name={name}, Type=Element\ninternal-1_{name}_{face}, {face}\n");
    }

    /// Returns the deck; `step` has the cards of boundary conditions and loads.
    fn text(&self, properties: &str, initial: &str, step: &str, history: &str, time: f64, edited: Edited) -> String {
        let rule = "************************************************************\n";
        let procedure = match edited {
            Edited::No => {
                format!("*Dynamic, Explicit=3\n{}, {}, {}, {}\n", time / 100.0, time, time / 1e5, time / 10.0)
            }
            Edited::Step => format!("*Dynamic, Explicit\n, {time}\n"),
        };
        [
            format!("{rule}** PrePoMax v2.1.0\n{rule}"),
            title("Heading"),
            "*Heading\nHash: 2D4A6C31, Date: 01. 02. 2024, Unit system: MM_TON_S_C\n".to_owned(),
            title("Nodes") + "*Node\n" + &self.nodes,
            title("Elements") + &self.elements,
            title("Node sets") + &self.sets,
            title("Surfaces") + &self.surfaces,
            properties.to_owned(),
            title("Initial conditions") + initial,
            title("Steps") + &title("Step-1") + "*Step, Nlgeom, Inc=1000000\n" + &procedure,
            title("Output frequency") + if edited == Edited::No { "*Output, Frequency=10\n" } else { "" } + step,
            title("History outputs") + history,
            title("Field outputs")
                + "*Node file\nRF, U, V\n*El file\nS, E, ENER\n"
                + &title("End step")
                + "*End step\n",
        ]
        .concat()
    }
}

/// A bar that hangs from its upper end, under gravity that acts suddenly.
fn hanging_bar(edited: Edited) -> String {
    let grid = Grid::uniform([0.0, 0.0], [20.0, 1000.0], 1, 60);
    let mut export = Export::default();
    export.add("Bar", &grid);
    export.add_nodes("Top", &grid, Side::Top, 0);
    export.add_nodes("End", &grid, Side::Bottom, 0);
    let properties = title("Materials")
        + "*Material, Name=Rubbery\n*Density\n1.2E-09\n*Elastic\n100, 0\n"
        + &title("Sections")
        + "*Solid section, Elset=Bar, Material=Rubbery\n";
    let step = title("Boundary conditions")
        + "** Name: Fixed-1\n*Boundary, op=New\nTop, 1, 2, 0\n"
        + &title("Loads")
        + "** Name: Gravity-1\n*Dload, op=New\nBar, Grav, 9810, 0, -1, 0\n";
    // Histories are not part of an export: the user adds them.
    let history = "*Output, history, time interval=1E-5\n*Node output, nset=End\nU2\n*Energy output\nALLKE, ALLIE, ALLWK, ETOTAL\n";
    export.text(&properties, "", &step, history, 8e-3, edited)
}

/// Estimate: the end of an elastic bar under a sudden body force moves to twice its static displacement `ρ g L² / 2E`
/// at `2L/c` (d'Alembert's solution; Graff, Wave Motion in Elastic Solids, chapter 2). Tolerance 1 %; the strain is 0.1
/// %.
#[test]
fn bar_under_sudden_gravity_moves_by_twice_its_static_displacement() {
    let run = Deck::new(&hanging_bar(Edited::Step)).completes(&[]);
    let fixed = 1.2e-9 * 9810.0 * 1e6 / (2.0 * 100.0);
    assert_near("largest displacement", -run.smallest(run.columns_with("U2@")[0]), 2.0 * fixed, 0.01);
}

/// The step card of CalculiX gives located messages that name the card to write.
#[test]
fn step_card_of_calculix_names_the_card_to_write() {
    let finished = Deck::new(&hanging_bar(Edited::No)).fails(&["M103", "M101"]);
    for advice in ["write EXPLICIT alone", "one of CalculiX"] {
        assert!(finished.printed.contains(advice), "{advice}");
    }
}

/// A steel bar and an aluminium bar are tied; a pressure acts on the steel end.
///
/// Estimate: the transmitted stress is `2 Z2 / (Z1 + Z2)` times the incident one, `Z = sqrt(E ρ)` (Graff, Wave Motion
/// in Elastic Solids, chapter 2). Tolerance 2 %.
#[test]
fn wave_through_tied_bars_is_transmitted_by_the_impedances() {
    let steel = Grid::uniform([0.0, 0.0], [5.0, 100.0], 1, 100);
    let aluminium = Grid::uniform([0.0, 100.0], [5.0, 200.0], 2, 100);
    let mut export = Export::default();
    let [a, first] = export.add("Steel_bar", &steel);
    let [b, second] = export.add("Aluminium_bar", &aluminium);
    export.add_nodes("Axis_1", &steel, Side::Inner, a);
    export.add_nodes("Axis_2", &aluminium, Side::Inner, b);
    let _ = writeln!(export.sets, "*Elset, Elset=Gauge\n{}", second + 2 * 30 + 1);
    export.add_surface("Loaded", &steel, Side::Bottom, first);
    export.add_surface("Joint_1", &steel, Side::Top, first);
    export.add_surface("Joint_2", &aluminium, Side::Bottom, second);
    let properties = title("Materials")
        + "*Material, Name=S235\n*Density\n7.85E-09\n*Elastic\n200000, 0\n*Material, Name=AlMg\n*Density\n2.7E-09\n*Elastic\n70000, 0\n"
        + &title("Sections")
        + "*Solid section, Elset=Steel_bar, Material=S235\n*Solid section, Elset=Aluminium_bar, Material=AlMg\n"
        + &title("Constraints")
        + "*Tie, Name=Tie-1, Position tolerance=0.01, Adjust=No\nJoint_2, Joint_1\n"
        + &title("Amplitudes")
        + "*Amplitude, Name=Pulse\n0, 0\n1E-06, 1\n1, 1\n";
    let step = title("Boundary conditions")
        + "** Name: Roller-1\n*Boundary, op=New\nAxis_1, 1, 1, 0\nAxis_2, 1, 1, 0\n"
        + &title("Loads")
        + "** Name: Pressure-1\n*Dsload, op=New, Amplitude=Pulse\nLoaded, P, 100\n";
    let history = "*Output, history, time interval=2E-7\n*Element output, elset=Gauge\nS22\n*Energy output\nALLKE, ALLIE, ALLWK, ETOTAL\n";
    let time = 3.4e-5;
    let run = Deck::new(&export.text(&properties, "", &step, history, time, Edited::Step)).completes(&[]);
    let impedances = [(200_000.0_f64 * 7.85e-9).sqrt(), (70_000.0_f64 * 2.7e-9).sqrt()];
    let stress = 100.0 * 2.0 * impedances[1] / (impedances[0] + impedances[1]);
    assert_near("transmitted stress", -run.mean(run.columns_with("S22@")[0], 3.0e-5, time), stress, 0.02);
}
