//! Contact of nodes with equal motion (*COUPLING with *KINEMATIC) and of bodies with equations.
//!
//! Goal: contact and constraint act on the same node; momentum and energy are conserved to rounding.
//! Source: decks with the same motion without the constraint, conservation laws. The tolerance and its reason are stated
//! at each test.

use revolve::job;
use revolve::user::Routines;

use super::contact::{SPEED, bars};
use crate::common::bodies::{DeckRun, assembly, elastic, part, point_field, run};
use crate::common::solid::{grid, material};

/// Returns a deck whose face `face` follows the massless reference node RP along z, with `cards` in the step.
fn coupled(deck: &str, face: &str, cards: &str) -> String {
    let coupling = format!(
        "*Node, nset=RP\n 90001, 0.5, 7.\n*Coupling, constraint name=C, ref node=RP, surface={face}\n*Kinematic\n 2, 2\n\
         *End Assembly"
    );
    deck.replace("*End Assembly", &coupling).replace("*Output, field", &format!("{cards}*Output, field"))
}

fn axial(ran: &DeckRun) -> Vec<f64> {
    let nodes: Vec<[usize; 2]> = ["LOWER", "UPPER"].iter().flat_map(|name| ran.nodes(name)).collect();
    nodes.iter().map(|n| point_field(ran.end(), "V")[2 * n[0] + 1]).collect()
}

/// The face of a bar in uniform motion moves in the same way with and without coupling. The tolerance is
/// that of the iteration for contact, 1e-9 of the approach velocity, over many increments.
#[test]
fn coupled_face_in_uniform_contact_moves_as_the_free_face() {
    for face in ["LOWER.J1", "UPPER.J0"] {
        let deck = bars(10, [3, 4], 1e-10, 3.0);
        let (free, linked) = (run(&deck).whole(), run(&coupled(&deck, face, "")).whole());
        let worst = axial(&free).iter().zip(axial(&linked)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / SPEED;
        println!("{face}: {worst:.1e}, drift {:.1e}", linked.outcome.energy.drift);
        assert!(worst < 1e-8, "{worst}");
        assert!((linked.outcome.energy.contact / free.outcome.energy.contact - 1.0).abs() < 1e-9);
    }
}

/// A narrow bar hits the middle of a coupled face: the face moves as a rigid ring with the mass of its nodes.
/// Momentum is conserved to the rounding of the sums, and the face stays plane. Changes of geometry affect the energy
/// balance in proportion to the strain, 1e-5.
#[test]
fn partial_contact_of_a_coupled_face_conserves_momentum_and_energy() {
    for (friction, face) in [(0.0, "LOWER.J1"), (0.3, "LOWER.J1"), (0.0, "UPPER.J0")] {
        let bar = |name: &str, radius: f64, n: usize, from: f64| {
            part(name, [n, 10], |i, j| [radius * i as f64 / n as f64, from + 0.1 * j as f64], "")
        };
        let deck = bar("LOWER", 1.0, 5, -1.0)
            + &bar("UPPER", 0.45, 3, 1e-7)
            + &assembly(&["LOWER", "UPPER"], "")
            + &elastic("LOWER", [1.0, 0.3, 1.0], "")
            + &elastic("UPPER", [1.0, 0.3, 1.0], "")
            + &format!("*Surface Interaction, name=I\n*Friction\n {friction},\n*Initial Conditions, type=VELOCITY\n")
            + " UPPER.ALL, 2, -1e-5\n*Step\n*Dynamic, Explicit, direct user control\n 0.02, 4.\n*Bulk Viscosity\n 0., 0.\n\
               *Contact Pair, interaction=I\n LOWER.J1, UPPER.J0\n*Output, field, number interval=20\n*Node Output\n V, U\n\
               *End Step\n";
        let ran = run(&coupled(&deck, face, "")).whole();
        let start = -SPEED * std::f64::consts::PI * 0.45 * 0.45;
        let (momentum, energy) = (ran.momentum() / start - 1.0, &ran.outcome.energy);
        let places = &ran.prepared.plan.mesh.points;
        let level = if face == "LOWER.J1" { 0.0 } else { 1e-7 };
        let part = if face == "LOWER.J1" { "LOWER" } else { "UPPER" };
        let moved: Vec<f64> = ran
            .nodes(part)
            .iter()
            .filter(|n| (places[n[0]][1] - level).abs() < 1e-9)
            .map(|n| point_field(ran.end(), "U")[2 * n[0] + 1])
            .collect();
        let bent = moved.iter().map(|u| (u - moved[0]).abs()).fold(0.0, f64::max);
        println!(
            "{face}, friction {friction}: momentum {momentum:.1e}, drift {:.1e}, {energy:?}, face {moved:?}",
            energy.drift
        );
        assert!(momentum.abs() < 1e-12 && energy.drift < 1e-6, "{momentum} {energy:?}");
        assert!(moved.len() > 3 && moved[0].abs() > 1e-7 && bent < 1e-15, "{moved:?}");
        // The energy lost is that of the nodes that meet; it cannot be negative.
        assert!(energy.contact >= 0.0, "{energy:?}");
    }
}

/// A coupled face with prescribed motion in contact: the same motion as with prescribed motion of its nodes, and a
/// reaction force at the reference node that is the sum of the forces on the nodes. Tolerance: rounding of sums.
#[test]
fn reference_node_carries_the_contact_force() {
    let deck = bars(10, [3, 4], 1e-10, 1.5);
    let history =
        |set: &str| format!("*Output, history, frequency=1\n*Node Output, nset={set}\n RF2\n*Energy Output\n ALLWK\n");
    let linked = coupled(&deck, "UPPER.J0", &format!("*Boundary, type=VELOCITY\n RP, 2, 2, -1e-5\n{}", history("RP")));
    let linked = linked.replace(" UPPER.ALL, 2,", &format!(" RP, 2, {:e}\n UPPER.ALL, 2,", -SPEED));
    let direct = deck.replace(
        "*Output, field",
        &format!("*Boundary, type=VELOCITY\n UPPER.J0, 2, 2, -1e-5\n{}*Output, field", history("UPPER.J0")),
    );
    let (linked, direct) = (run(&linked).whole(), run(&direct).whole());
    let sum = |ran: &DeckRun| {
        let names: Vec<&str> = ran.prepared.plan.columns.iter().map(|c| c.name.as_str()).collect();
        let columns: Vec<Vec<[f64; 2]>> =
            names.iter().filter(|n| n.starts_with("RF2@")).map(|n| ran.column(n)).collect();
        (0..columns[0].len()).map(|i| columns.iter().map(|c| c[i][1]).sum()).collect::<Vec<f64>>()
    };
    let (one, all) = (sum(&linked), sum(&direct));
    let largest = all.iter().fold(0.0, |m: f64, f| m.max(f.abs()));
    let worst = one.iter().zip(&all).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest;
    println!("reaction force {largest:.4e}, difference {worst:.1e}, drift {:.1e}", linked.outcome.energy.drift);
    assert!(one.len() > 15 && worst < 1e-9, "{worst}");
    assert!(linked.outcome.energy.drift < 1e-12, "{:?}", linked.outcome.energy);
    let works = [&linked, &direct].map(|ran| ran.outcome.energy.work / ran.outcome.energy.initial);
    println!("work over initial energy {works:?}");
    assert!((works[0] - works[1]).abs() < 1e-9, "{works:?}");
}

/// Two discs that a tie joins node by node vibrate as one body. General contact of all surfaces contains the tied faces, whose
/// gap cannot change, and changes neither velocities nor the energy balance. Tolerance: rounding.
#[test]
fn general_contact_does_not_act_between_tied_nodes() {
    let disc = |name: &str, foot: f64| part(name, [5, 4], |i, j| [0.2 * i as f64, foot + 0.1 * j as f64], "");
    let deck = |contact: &str| {
        disc("LOWER", 0.0)
            + &disc("UPPER", 0.4)
            + &assembly(&["LOWER", "UPPER"], "*Tie, name=T\n UPPER.J0, LOWER.J1\n")
            + &elastic("LOWER", [1.0, 0.3, 1.0], "")
            + &elastic("UPPER", [0.2, 0.4, 2.0], "")
            + "*Initial Conditions, type=VELOCITY\n UPPER.J1, 2, -1e-3\n LOWER.J0, 2, 1e-3\n*Step\n*Dynamic, Explicit\n , 4.\n"
            + contact
            + "*Output, field, number interval=1\n*Node Output\n V\n*End Step\n"
    };
    let [alone, general] =
        ["", "*Contact\n*Contact Inclusions, all exterior\n"].map(|contact| run(&deck(contact)).whole());
    let worst = axial(&alone).iter().zip(axial(&general)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / 1e-3;
    println!(
        "velocities {worst:.1e}, drift {:.1e} and {:.1e}",
        alone.outcome.energy.drift, general.outcome.energy.drift
    );
    assert!(worst < 1e-12, "{worst}");
    let drifts = [&alone, &general].map(|ran| ran.outcome.energy.drift);
    assert!(general.outcome.energy.contact == 0.0 && (drifts[0] - drifts[1]).abs() < 1e-12, "{drifts:?}");
}

/// Nodes of ties are in equations. General contact leaves their facets out with a warning; a contact pair that names
/// them is an error.
#[test]
fn tied_facets_are_left_out_of_general_contact() {
    let deck = |contact: &str| {
        grid(2, 2, false, |i, j| [0.5 * i as f64, 0.5 * j as f64])
            + "*Node, nset=UP\n 101, 0., 1.\n 102, 1., 1.\n 103, 0., 2.\n 104, 1., 2.\n*Element, type=CAX4R, elset=TOP\n 101, 101, \
               102, 104, 103\n*Surface, name=FOOT\n TOP, S1\n*Surface, name=SKIN\n SOLID,\n*Tie, name=T\n J1, FOOT\n"
            + &material(1.0, 0.3, 1.0, "")
            + "*Solid Section, elset=TOP, material=M\n*Surface, type=SEGMENTS, name=WALL\n START, 0., -1.\n LINE, 9., -1.\n\
               *Node, nset=REF\n 900, 0., 0.\n*Rigid Body, ref node=900, analytical surface=WALL\n*Step\n*Dynamic, Explicit\n , \
               1.\n*Boundary\n REF, 2, 2\n"
            + contact
            + "*End Step\n"
    };
    for (contact, expected) in [
        ("*Contact\n*Contact Inclusions, all exterior\n", "P123"),
        ("*Surface Interaction, name=I\n*Contact Pair, interaction=I\n SKIN, WALL\n", "P021"),
    ] {
        let prepared = job::prepare_text("test.inp", &deck(contact), &Vec::new(), &Routines::none());
        let codes: Vec<&str> = prepared.diagnostics.iter().map(|d| d.code).collect();
        println!("{}", prepared.diagnostics.render(&prepared.deck.sources));
        assert_eq!(
            (codes.contains(&expected), prepared.diagnostics.has_errors()),
            (true, expected == "P021"),
            "{codes:?}"
        );
    }
}
