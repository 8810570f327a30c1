//! Contact laws and contact output on analytical rigid surfaces.
//!
//! Goal: lines give the results of rigid elements on the same line; arcs give those of Hertz.
//! Source: surfaces of rigid elements, which other tests compare with closed forms; Hertz 1882 (Johnson, Contact
//! Mechanics, 4.2). The tolerance and its reason are stated at each test.

use revolve::solve::Outcome;

use crate::common::RecordedOutput;
use crate::common::bodies::cell_field;
use crate::common::solid::{WHOLE_VISCOSITY, column, grid, last, material, run};

/// Returns the cards of a straight tool whose contact side is on its left, with reference node 9000 in set REF, as an
/// analytical surface or as rigid elements.
pub(crate) fn straight_tool(analytical: bool, [from, to]: [[f64; 2]; 2], facets: usize) -> String {
    let reference = "*Node, nset=REF\n 9000, 0., 0.\n";
    if analytical {
        return format!(
            "{reference}*Surface, type=SEGMENTS, name=TOOL\n START, {:e}, {:e}\n LINE, {:e}, {:e}\n\
             *Rigid Body, ref node=9000, analytical surface=TOOL\n",
            from[0], from[1], to[0], to[1]
        );
    }
    let place = |i: usize| [0, 1].map(|k| from[k] + i as f64 / facets as f64 * (to[k] - from[k]));
    let nodes = (0..=facets).map(|i| format!(" {}, {:e}, {:e}\n", 9001 + i, place(i)[0], place(i)[1]));
    let elements = (1..=facets).map(|i| format!(" {}, {}, {}\n", 9000 + i, 9000 + i, 9001 + i));
    format!(
        "{reference}*Node\n{}*Element, type=RAX2, elset=ET\n{}*Surface, name=TOOL\n ET, SPOS\n*Rigid Body, ref node=9000, elset=ET\n",
        nodes.collect::<String>(),
        elements.collect::<String>()
    )
}

/// Runs a deck with both tools, the analytical one first.
fn run_with_both_tools(
    deck: impl Fn(&str) -> String,
    line: [[f64; 2]; 2],
    facets: usize,
) -> [(String, Outcome, RecordedOutput); 2] {
    [true, false].map(|analytical| {
        let deck = deck(&straight_tool(analytical, line, facets));
        let (outcome, memory) = run(&deck);
        assert_eq!(outcome.halt, None);
        (deck, outcome, memory)
    })
}

/// Returns the difference of a history column between two runs, relative to its largest value.
fn relative_difference([(deck, _, a), (other, _, b)]: &[(String, Outcome, RecordedOutput); 2], name: &str) -> f64 {
    let (a, b) = (column(deck, a, name), column(other, b, name));
    assert_eq!(a.len(), b.len());
    let largest = b.iter().map(|row| row.1.abs()).fold(0.0, f64::max);
    assert!(largest > 0.0, "{name} is zero");
    a.iter().zip(&b).map(|(a, b)| (a.1 - b.1).abs()).fold(0.0, f64::max) / largest
}

/// A ring pressed on a shaft by external pressure slides along it, with decaying friction and with a shear stress
/// limit. The whole inner face is in contact and slides at once. Node-to-segment and weighted pressures then agree at
/// every node, and so does a constant coefficient. The shear stress limit differs by the mesh at the ends of the face,
/// because it caps the share of each node.
#[test]
fn ring_slides_alike_on_analytical_and_meshed_shafts() {
    for (law, tolerance) in
        [("*Friction, exponential decay\n 0.1, 0.05, 800.\n", 1e-4), ("*Friction, taumax=4.e-6\n 0.1,\n", 1e-2)]
    {
        let cells = 6;
        let deck = |tool: &str| {
            grid(cells, cells, false, |i, j| [1.0 + i as f64 / cells as f64, j as f64 / cells as f64])
                + &material(1.0, 0.3, 1.0, &format!("{tool}*Surface Interaction, name=DRY\n{law}"))
                + "*Amplitude, name=RAMP, definition=SMOOTH STEP\n 0., 0., 60., 1.\n\
                   *Initial Conditions, type=VELOCITY\n ALL, 2, 9e-4\n*Step\n*Dynamic, Explicit\n , 150.\n*Boundary\n REF, 2, 2\n\
                   *Dsload, amplitude=RAMP\n I1, P, 1.e-4\n*Contact Pair, interaction=DRY\n I0, TOOL\n\
                   *Output, history, number interval=100\n*Energy Output\n ALLKE, ALLFD\n*Contact Output\n CFN, CFS, CAREA\n\
                   *Contact Output, nset=I0\n CSLIP\n*End Step\n"
        };
        let runs = run_with_both_tools(deck, [[1.0, 3.0], [1.0, -1.0]], 4 * cells);
        let names = ["ALLKE", "CFN1@I0_TOOL", "CFS2@I0_TOOL", "CAREA@I0_TOOL"];
        let off = names.map(|name| relative_difference(&runs, name));
        println!("ring on an analytical shaft, {law:?}: errors of kinetic energy, forces, area {off:?}");
        assert!(off.iter().all(|off| *off < tolerance), "{law}: {off:?}");
        assert!(runs[0].1.energy.drift < 1e-5, "{:?}", runs[0].1.energy);
    }
}

/// A disc pressed on a compliant plane sinks in and widens as on rigid elements, with a difference of second order in
/// the element size because pressures act at points instead of being distributed by shape functions.
#[test]
fn disc_sinks_alike_into_analytical_and_meshed_planes() {
    for (law, pair) in [
        ("*Surface Behavior, pressure-overclosure=EXPONENTIAL\n 0.01, 1e-3\n", ""),
        ("*Surface Behavior, pressure-overclosure=LINEAR\n 0.1,\n", ""),
        ("", ", mechanical constraint=PENALTY"),
        ("", ", adjust=0.001"),
    ] {
        let off = [4, 8].map(|cells: usize| {
            let lifted = if pair.contains("adjust") { 5e-4 } else { 0.0 };
            let deck = |tool: &str, rows: &str| {
                grid(cells, cells, false, |i, j| [i as f64 / cells as f64, lifted + j as f64 / cells as f64])
                    + &material(
                        1.0,
                        0.3,
                        1.0,
                        &format!("*Damping, alpha=0.6\n{tool}*Surface Interaction, name=LAW\n{law}"),
                    )
                    + "*Amplitude, name=RAMP, definition=SMOOTH STEP\n 0., 0., 40., 1.\n*Nset, nset=CENTRE\n 1\n\
                       *Step\n*Dynamic, Explicit\n , 80.\n"
                    + WHOLE_VISCOSITY
                    + "*Boundary\n REF, 2, 2\n I0, 1, 1\n*Dsload, amplitude=RAMP\n J1, P, 1.e-3\n"
                    + &format!("*Contact Pair, interaction=LAW{pair}\n TOOL, J0\n")
                    + &format!("*Output, history, {rows}\n")
                    + "*Node Output, nset=CENTRE\n U2\n*Node Output, nset=REF\n RF2\n\
                       *Contact Output\n CFN\n*Contact Output, nset=CENTRE\n CPRESS, COPEN\n*End Step\n"
            };
            let line = [[0.0, 0.0], [2.0, 0.0]];
            let runs = run_with_both_tools(|tool| deck(tool, "number interval=20"), line, 3);
            let [(whole, _, memory), _] = &run_with_both_tools(|tool| deck(tool, "frequency=1"), line, 3);
            // With a row for each increment, the mean contact force of the pair is the reaction force of the reference node.
            let [shown, held] = ["CFN2@TOOL_J0", "RF2@REF"].map(|name| last(whole, memory, name));
            assert!((shown / held + 1.0).abs() < 1e-9, "{shown} {held}");
            let pressure = last(whole, memory, "CPRESS@CENTRE");
            assert!((pressure / 1e-3 - 1.0).abs() < 0.05, "{pressure}");
            let names = ["RF2@REF", "U2@CENTRE"];
            let names = if pair.contains("adjust") { &names[..1] } else { &names[..] };
            names.iter().map(|name| relative_difference(&runs, name)).fold(0.0, f64::max)
        });
        println!("disc on an analytical plane, {law:?}{pair}: errors {off:?}");
        assert!(off[1] < 0.01 && (off[1] < 0.5 * off[0] || off[1] < 1e-6), "{law}{pair}: {off:?}");
    }
}

/// On a rough plane the foot of the disc behaves as if it were fixed radially, to the tolerance of the impulses.
#[test]
fn rough_analytical_plane_fixes_the_foot() {
    let of = |friction: &str, foot: &str| {
        let deck = grid(6, 6, false, |i, j| [i as f64 / 6.0, j as f64 / 6.0])
            + &material(1.0, 0.3, 1.0, "*Damping, alpha=0.6\n")
            + &straight_tool(true, [[0.0, 0.0], [2.0, 0.0]], 1)
            + &format!("*Surface Interaction, name=LAW\n{friction}")
            + "*Amplitude, name=RAMP, definition=SMOOTH STEP\n 0., 0., 40., 1.\n*Nset, nset=EDGE\n 49\n\
               *Step\n*Dynamic, Explicit\n , 80.\n*Boundary\n REF, 2, 2\n I0, 1, 1\n"
            + &format!("{foot}*Dsload, amplitude=RAMP\n J1, P, 1.e-4\n*Contact Pair, interaction=LAW\n J0, TOOL\n")
            + "*Output, history, number interval=4\n*Node Output, nset=EDGE\n U1, U2\n*End Step\n";
        let (outcome, memory) = run(&deck);
        assert_eq!(outcome.halt, None);
        ["U1@EDGE", "U2@EDGE"].map(|name| last(&deck, &memory, name))
    };
    let (rough, held, smooth) = (of("*Friction, rough\n", ""), of("", " J0, 1, 1\n"), of("", ""));
    let off = (0..2).map(|i| (rough[i] / held[i] - 1.0).abs()).fold(0.0, f64::max);
    println!("rough analytical plane: error of displacements {off:.1e}");
    assert!(off < 1e-7 && (smooth[0] / held[0] - 1.0).abs() > 0.05, "{rough:?} {held:?} {smooth:?}");
}

/// The nodal pressures of a spherical punch in a block are those of Hertz for its force, their sum is that force, and
/// the contact area matches. With eight elements over the contact radius, pressures agree to 3 % of the maximum within
/// three quarters of the radius, and the contact radius to 0.15 of an element.
#[test]
fn spherical_punch_pressure_matches_hertz() {
    let (depth, nu, cells) = (0.01_f64, 0.3, 8_usize);
    let contact = depth.sqrt();
    let place = |k: usize| {
        let outer = k.saturating_sub(2 * cells) as i32;
        contact / cells as f64 * (k.min(2 * cells) as f64 + (1.2_f64.powi(outer) - 1.0) / 0.2 * 1.2)
    };
    let count = (0..).find(|&k| place(k) > 10.0 * contact).expect("it grows");
    let deck = grid(count, count, false, |i, j| [place(i), -place(count - j)])
        + &material(
            1.0,
            nu,
            1.0,
            "*Node, nset=REF\n 9800, 0., 0.\n*Surface, type=SEGMENTS, name=BALL\n START, 1., 1.\n CIRCL, 0., 0., 0., 1.\n\
             *Rigid Body, ref node=9800, analytical surface=BALL\n*Surface Interaction, name=DRY\n\
             *Amplitude, name=PUSH, definition=SMOOTH STEP\n 0., 0., 16., 1., 1000., 1.\n",
        )
        + &format!(
            "*Step\n*Dynamic, Explicit\n , 40.\n*Boundary\n J0, 2, 2\n I0, 1, 1\n I1, 1, 1\n\
             *Boundary, amplitude=PUSH\n 9800, 2, 2, {}\n*Contact Pair, interaction=DRY\n BALL, J1\n\
             *Output, history, frequency=1\n*Node Output, nset=REF\n RF2\n*Contact Output\n CFN, CAREA\n\
             *Contact Output, nset=J1\n CPRESS, COPEN\n*End Step\n",
            -depth
        );
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    let force = -last(&deck, &memory, "RF2@REF");
    let shown = last(&deck, &memory, "CFN2@BALL_J1");
    assert!((shown / force - 1.0).abs() < 1e-9, "{shown} {force}");
    let radius = (0.75 * force * (1.0 - nu * nu)).cbrt();
    let largest = 1.5 * force / (std::f64::consts::PI * radius * radius);
    let at = |k: usize, name: &str| last(&deck, &memory, &format!("{name}@{}", 1 + k + count * (count + 1)));
    let mut worst = 0.0_f64;
    for k in (0..).take_while(|&k| place(k) < 0.75 * radius) {
        let expected = (1.0 - (place(k) / radius).powi(2)).sqrt();
        worst = worst.max((at(k, "CPRESS") / largest - expected).abs());
        assert!(at(k, "COPEN").abs() < 1e-6 * depth, "{k}: {}", at(k, "COPEN"));
    }
    let ring = (last(&deck, &memory, "CAREA@BALL_J1") / std::f64::consts::PI).sqrt() / radius - 1.0;
    println!("spherical punch: error of pressures {worst:.3} of the largest, of the radius {ring:.3}");
    assert!(worst < 0.03, "{worst}");
    assert!(ring.abs() < 0.15 / cells as f64, "{ring}");
}

/// A shell touches an analytical plane at half its thickness from its nodes, or at its nodes with NO THICKNESS.
#[test]
fn shell_contact_accounts_for_half_the_thickness() {
    for (word, way) in [("", 0.075), (", no thickness", 0.1)] {
        let deck = "*Node, nset=ALL\n 1, 0., 0.1\n 2, 0.5, 0.1\n 3, 1., 0.1\n*Element, type=SAX1, elset=SHELL\n 1, 1, 2\n 2, 2, 3\n\
             *Surface, name=UNDER\n SHELL, SNEG\n*Shell Section, elset=SHELL, material=M\n 0.05,\n*Material, name=M\n\
             *Density\n 1.,\n*Elastic\n 1., 0.3\n"
            .to_owned()
            + &straight_tool(true, [[0.0, 0.0], [2.0, 0.0]], 1)
            + "*Nset, nset=RIM\n 3\n*Surface Interaction, name=DRY\n*Initial Conditions, type=VELOCITY\n ALL, 2, -0.1\n\
               *Step\n*Dynamic, Explicit\n , 1.5\n*Boundary\n REF, 2, 2\n 1, 1, 1\n 1, 6, 6\n"
            + &format!("*Contact Pair, interaction=DRY{word}\n UNDER, TOOL\n")
            + "*Output, history, number interval=10\n*Node Output, nset=RIM\n U2\n*End Step\n";
        let (outcome, memory) = run(&deck);
        assert_eq!(outcome.halt, None);
        let fallen = -last(&deck, &memory, "U2@RIM");
        println!("shell on a plane{word}: displacement {fallen:.12}");
        assert!((fallen - way).abs() < 1e-12, "{fallen}");
    }
}

/// A bar whose foot fails on an analytical plane: rows exposed by deletion meet the plane, and nodes without elements
/// do not pass it. Penetration is limited to the rounding of coordinates.
#[test]
fn eroded_bar_does_not_pass_an_analytical_plane() {
    let (n, m) = (4, 16);
    let deck = grid(n, m, false, |i, j| [3.2e-3 * i as f64 / n as f64, 12.8e-3 * j as f64 / m as f64])
        + &material(117e9, 0.35, 8930.0, "*Plastic\n 4.e8, 0.\n 5.e8, 1.\n*Shear Failure\n 0.4,\n")
        + &straight_tool(true, [[0.0, 0.0], [1.0, 0.0]], 1)
        + "*Surface Interaction, name=DRY\n*Initial Conditions, type=VELOCITY\n ALL, 2, -300.\n\
           *Step\n*Dynamic, Explicit\n , 2.5e-5\n*Boundary\n REF, 2, 2\n*Contact Pair, interaction=DRY\n J0, TOOL\n\
           *Output, history, number interval=50\n*Node Output, nset=ALL\n COOR2\n\
           *Output, field, number interval=2\n*Element Output\n STATUS\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    let deleted = cell_field(memory.frames.last().expect("a frame"), "STATUS").iter().filter(|s| **s == 0.0).count();
    let lowest = (1..=(n + 1) * (m + 1)).flat_map(|k| column(&deck, &memory, &format!("COOR2@{k}")));
    let lowest = lowest.map(|row| row.1).fold(f64::INFINITY, f64::min);
    println!(
        "eroding bar on an analytical plane: {deleted} deleted, lowest position {lowest:.1e}, drift {:.1e}",
        outcome.energy.drift
    );
    assert!(deleted > n, "rows above the first are deleted: {deleted}");
    assert!(lowest > -1e-9, "{lowest}");
}

/// Rigid disc of the thickness 1 around the plane z = 0, with reference node 9000 in set REF.
const DISC: &str = "*Node, nset=REF\n 9000, 0., 0.\n*Surface, type=SEGMENTS, name=DISC\n START, 0., 0.5\n LINE, 2.5, 0.5\n LINE, 2.5, \
                    -0.5\n LINE, 0., -0.5\n*Rigid Body, ref node=9000, analytical surface=DISC\n";

/// Returns a square ring of one element of the size 0.1 with its lower edge from r = `from[0]` at z = `from[1]`.
fn square_ring(name: &str, first: usize, [r, z]: [f64; 2]) -> String {
    let [outer, top] = [r + 0.5, z + 0.1];
    format!(
        "*Node, nset={name}\n {first}, {r}, {z}\n {}, {outer}, {z}\n {}, {outer}, {top}\n {}, {r}, {top}\n*Element, type=CAX4R, \
         elset={name}\n {first}, {first}, {}, {}, {}\n*Solid Section, elset={name}, material=M\n",
        first + 1,
        first + 2,
        first + 3,
        first + 1,
        first + 2,
        first + 3
    )
}

/// Runs bodies at the disc, and checks that nodes of set B which rest on it at the start are not in it after any increment.
fn assert_stays_outside(bodies: &str, steps: &str) {
    let deck = format!(
        "{bodies}{DISC}*Material, name=M\n*Density\n 1.,\n*Elastic\n 1., 0.\n*Surface Interaction, name=I\n{steps}*Output, history, \
         frequency=1\n*Node Output, nset=B\n U2\n*Node Output, nset=REF\n U2, RF2\n*End Step\n"
    );
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    let disc = column(&deck, &memory, "U2@REF");
    for node in ["U2@11", "U2@12"] {
        let depths = column(&deck, &memory, node).into_iter().zip(&disc).map(|(node, disc)| disc.1 - node.1);
        let deepest = depths.fold(f64::NEG_INFINITY, f64::max);
        assert!(deepest < 1e-12, "{node}: {deepest}");
    }
    let moves = disc.iter().any(|row| row.1 > 1e-3);
    let presses = column(&deck, &memory, "RF2@REF").iter().any(|row| row.1.abs() > 1e-3);
    assert!(moves || presses, "a body has hit the disc");
}

/// A free disc that is hit from below lifts a body that rests on it in the same increment, before this body moves.
#[test]
fn body_at_rest_on_a_disc_is_lifted_in_the_increment_of_an_impact() {
    let bodies = square_ring("A", 1, [0.0, -0.62]) + &square_ring("B", 11, [1.5, 0.5]);
    let steps = "*Element, type=MASS, elset=MD\n 9000, 9000\n*Mass, elset=MD\n 1.,\n*Surface, name=FACES\n A, S3\n B, S1\n\
                 *Initial Conditions, type=VELOCITY\n A, 2, 0.1\n*Step\n*Dynamic, Explicit\n , 0.5\n*Contact Pair, \
                 interaction=I\n FACES, DISC\n";
    assert_stays_outside(&bodies, steps);
}

/// A shell at rest on a fixed disc is hit from above: the disc stops it in the same increment.
#[test]
fn shell_at_rest_on_a_disc_is_stopped_in_the_increment_of_an_impact() {
    let bodies = square_ring("A", 1, [1.0, 0.62])
        + "*Node, nset=B\n 11, 1., 0.55\n 12, 1.5, 0.55\n*Element, type=SAX1, elset=B\n 11, 11, 12\n*Shell Section, elset=B, \
           material=M\n 0.1,\n";
    let steps = "*Surface, name=FOOT\n A, S1\n*Surface, name=TOP\n B, SPOS\n*Surface, name=UNDER\n B, SNEG\n*Initial Conditions, \
                 type=VELOCITY\n A, 2, -0.1\n*Step\n*Dynamic, Explicit\n , 0.5\n*Boundary\n REF, 2\n*Contact Pair, \
                 interaction=I\n FOOT, TOP\n UNDER, DISC\n";
    assert_stays_outside(&bodies, steps);
}
