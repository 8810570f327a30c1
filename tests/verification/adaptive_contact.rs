//! Contact of deformable bodies on adaptive meshes.
//!
//! Goal: results of meshes that follow the material, where these work; the depth of a rigid ogive in a law of cavity
//! expansion. Conservation: momentum, energy balance. Tolerances are stated at each test.

use revolve::job;
use revolve::output::HistorySummary;
use revolve::solve::Outcome;
use revolve::user::Routines;

use crate::common::bodies::{BOTH_ADAPTIVE, DeckRun, assembly, elastic, part, punch_and_block, run};
use crate::common::{pairs, project};

/// Laws of contact: hard without and with friction, and soft.
const LAWS: [&str; 3] =
    ["", "*Friction\n 0.3,\n", "*Friction\n 0.1,\n*Surface Behavior, pressure-overclosure=LINEAR\n 1e6,\n"];

fn last(ran: &DeckRun, name: &str) -> f64 {
    ran.column(name).last().map_or(f64::NAN, |row| row[1])
}

/// A copper punch hits an aluminium block; both are free, both meshes change, and both surfaces slide. Momentum is conserved
/// to rounding, the energy drift is below 1e-3, contact creates no energy, and the plastic work is that of meshes that
/// follow the material within 1 %.
#[test]
fn sliding_surfaces_keep_momentum_and_plastic_work() {
    for law in LAWS {
        let follows = run(&punch_and_block(20, 2e-5, law, "")).whole();
        let ran = run(&punch_and_block(20, 2e-5, law, BOTH_ADAPTIVE)).whole();
        let nodes = &ran.prepared.state.dofs.nodes;
        let before: f64 = nodes.as_slice().iter().zip(&nodes.mass).map(|(n, m)| m * n.v_z).sum();
        let momentum = ran.momentum() / before - 1.0;
        let [work, expected] = [&ran, &follows].map(|run| last(run, "ALLPD"));
        let (energy, changes) = (ran.outcome.energy, last(&ran, "NADAPT"));
        println!(
            "{}: momentum {momentum:.1e}, drift {:.1e}, contact {:.2e} of {:.2e}, plastic work {:.3} %, friction {:.2} %",
            law.trim(),
            energy.drift,
            energy.contact,
            energy.initial,
            100.0 * (work / expected - 1.0),
            100.0 * (last(&ran, "ALLFD") / last(&follows, "ALLFD") - 1.0),
        );
        assert!(changes > 20.0, "{changes}");
        assert!(momentum.abs() < 1e-11, "{momentum:e}");
        assert!(energy.drift < 1e-3 && energy.contact > -1e-3 * energy.initial, "{energy:?}");
        assert!((work / expected - 1.0).abs() < 0.01, "{work} {expected}");
    }
}

/// The same bits on 1, 2 and 5 threads.
#[test]
fn sliding_surfaces_do_not_depend_on_the_number_of_threads() {
    let digest = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let deck = punch_and_block(40, 3e-6, LAWS[1], BOTH_ADAPTIVE);
        pool.install(|| run(&deck).whole().outcome.digest)
    };
    let one = digest(1);
    for threads in [2, 5] {
        assert_eq!(one, digest(threads), "{threads} threads");
    }
}

fn run_file(deck: &str, settings: &[(&str, &str)]) -> (Outcome, HistorySummary) {
    let prepared = job::prepare(&project(deck), &pairs(settings), &Routines::none());
    assert!(!prepared.diagnostics.has_errors());
    job::run_in_memory(&prepared)
}

/// A rigid ogive widens a thin hole along the axis of an adaptive target, without deletion of elements. Depths on three
/// meshes agree within 1 %, and with the law of cavity expansion with three terms within 3 %. No angle is below 5 degrees.
#[test]
fn depth_of_an_ogive_does_not_depend_on_the_mesh() {
    let (_, law) = run_file("input/ogive.inp", &[("B", "0.983"), ("C", "0.9402")]);
    let expected = -law.0["U2@REF"].min;
    let depths = ["3", "4", "6"].map(|k| {
        let (outcome, history) = run_file("input/ogive_adaptive.inp", &[("k", k), ("nc", "16"), ("mc", "8")]);
        assert_eq!(outcome.halt, None);
        let (depth, angle) = (-history.0["U2@REF"].min, history.0["ADANGLE"].min);
        println!("k {k}: depth {depth:.6}, law {expected:.6}, angle {angle:.1}, drift {:.1e}", outcome.energy.drift);
        assert!((depth / expected - 1.0).abs() < 0.03, "{depth} {expected}");
        assert!(outcome.energy.drift < 1e-3 && angle > 5.0, "{:e} {angle}", outcome.energy.drift);
        assert!(outcome.energy.removed.is_none());
        depth
    });
    for depth in &depths {
        assert!((depth / depths[2] - 1.0).abs() < 0.01, "{depths:?}");
    }
}

/// A thin lead disc is pressed between a billet of aluminium and one of steel, with friction, until it flows around the edge of
/// the stiff one. All three meshes change. Where contact corrects the places of nodes at the rim of the disc, no
/// corner turns over, and no node loses its mass. The plastic work of the disc is that of meshes that follow the material within 2 %,
/// and the energy drift is below 1e-3.
#[test]
fn corrections_of_contact_turn_no_element_over() {
    let bodies = [("LOW", [6, 5], 0.0, 8e-3), ("DISC", [16, 3], 8e-3, 1.5e-3), ("UPP", [6, 5], 9.5e-3, 8e-3)];
    let part = |(name, [n, m], bottom, height): (&str, [usize; 2], f64, f64)| {
        part(name, [n, m], |i, j| [10e-3 * i as f64 / n as f64, bottom + height * j as f64 / m as f64], "")
    };
    let deck = |frequency: Option<u64>| {
        let card = |name: &str, frequency| format!("*Adaptive Mesh, elset={name}.SOLID, frequency={frequency}\n");
        let cards = frequency.map(|frequency| ["LOW", "DISC", "UPP"].map(|name| card(name, frequency)).concat());
        bodies.map(part).concat()
            + &assembly(&["LOW", "DISC", "UPP"], "")
            + &elastic("LOW", [70e9, 0.33, 2700.0], "*Plastic\n 100.e6, 0.\n 160.e6, 0.3\n 200.e6, 1.\n 240.e6, 4.\n")
            + &elastic("DISC", [16e9, 0.44, 11340.0], "*Plastic\n 12.e6, 0.\n 20.e6, 0.5\n 24.e6, 3.\n")
            + &elastic("UPP", [200e9, 0.3, 7850.0], "*Plastic\n 300.e6, 0.\n 700.e6, 1.\n 900.e6, 3.\n")
            + "*Surface Interaction, name=DRY\n*Friction\n 0.3,\n*Boundary\n LOW.J0, 2, 2\n\
               *Amplitude, name=A, definition=SMOOTH STEP\n 0., 0., 3.e-4, 1.\n*Step\n*Dynamic, Explicit\n , 1.3e-4\n"
            + &cards.unwrap_or_default()
            + "*Boundary, amplitude=A\n UPP.J1, 2, 2, -6.e-3\n*Contact\n*Contact Inclusions, all exterior\n\
               *Contact Property Assignment\n , , DRY\n*Output, history, number interval=20\n*Energy Output\n ALLPD\n*End Step\n"
    };
    let follows = run(&deck(None)).whole();
    for frequency in [3, 7, 13] {
        let ran = run(&deck(Some(frequency))).whole();
        let [work, expected] = [&ran, &follows].map(|run| last(run, "ALLPD"));
        println!("every {frequency}: plastic work {work} {expected}, drift {:.1e}", ran.outcome.energy.drift);
        assert!((work / expected - 1.0).abs() < 0.02, "{work} {expected}");
        assert!(ran.outcome.energy.drift < 1e-3, "{:?}", ran.outcome.energy);
    }
}
