//! Ties of surfaces with unequal meshes (`*TIE`).
//!
//! Goal: forces and stresses across ties do not depend on the meshes.
//! Source: closed forms of uniform stress; conforming meshes. The tolerance and its reason are stated at each test.

use crate::common::bodies::{DeckRun, assembly, cell_field, elastic, part, point_field, run};

/// Returns two rings of height 1 from the radius `inner` to the radii `outer`, with these numbers of facets at the tie, pressed
/// together slowly by a tenth of their height.
fn tied_rings(facets: [usize; 2], inner: f64, outer: [f64; 2], ratio: f64, cards: &str) -> String {
    let ring = |name: &str, i: usize, foot: f64, more: &str| {
        let place =
            |k: usize, j: usize| [inner + (outer[i] - inner) * k as f64 / facets[i] as f64, foot + 0.5 * j as f64];
        part(name, [facets[i], 2], place, more)
    };
    ring("LOW", 0, 0.0, "")
        + &ring("HIGH", 1, 1.0, "")
        + &assembly(&["LOW", "HIGH"], cards)
        + &elastic("LOW", [1.0, ratio, 1.0], "")
        + &elastic("HIGH", [1.0, ratio, 1.0], "")
        + "*Amplitude, name=A, definition=SMOOTH STEP\n 0., 0., 400., 1.\n*Step\n*Dynamic, Explicit\n , 400.\n*Boundary\n LOW.J0, \
           2\n*Boundary, amplitude=A\n HIGH.J1, 2, 2, -0.2\n*Output, field, number interval=1\n*Node Output\n RF, U\n*Element \
           Output\n S\n*Output, history, number interval=1\n*Energy Output\n ETOTAL, ALLWK\n*End Step\n"
}

/// Returns the sum of the reaction forces along z on an instance.
fn reaction(ran: &DeckRun, instance: &str) -> f64 {
    let forces = point_field(ran.end(), "RF");
    ran.nodes(instance).iter().map(|n| forces[2 * n[0] + 1]).sum()
}

fn last(ran: &DeckRun, column: &str) -> f64 {
    ran.column(column).last().expect("rows")[1]
}

/// Discs and rings with any ratio of the facets and with either surface as the master have the uniform stress
/// `E ln(1 - 0.1)` and the force of one body, `π E ln(1 - 0.1) (1 - 0.1)^(-2ν)` times the squares of the radii. The rest is
/// that of the slow motion.
#[test]
fn tied_bodies_of_any_meshes_have_the_force_of_one_body() {
    let stress = 0.9_f64.ln();
    for (facets, inner, ratio) in [
        ([4, 4], 0.0, 0.0),
        ([4, 5], 0.0, 0.3),
        ([3, 7], 0.0, 0.3),
        ([2, 16], 0.0, 0.0),
        ([5, 3], 0.5, 0.0),
        ([2, 9], 0.5, 0.0),
    ] {
        for tie in ["LOW.J1, HIGH.J0", "HIGH.J0, LOW.J1"] {
            for kind in ["", ", type=SURFACE TO SURFACE", ", adjust=NO"] {
                let cards = format!("*Tie, name=T{kind}\n {tie}\n");
                let ran = run(&tied_rings(facets, inner, [1.0; 2], ratio, &cards)).whole();
                let force = std::f64::consts::PI * (1.0 - inner * inner) * stress * 0.9_f64.powf(-2.0 * ratio);
                let errors = [reaction(&ran, "LOW") / -force - 1.0, reaction(&ran, "HIGH") / force - 1.0];
                let axial =
                    cell_field(ran.end(), "S").chunks(4).map(|s| (s[1] / stress - 1.0).abs()).fold(0.0, f64::max);
                println!("{facets:?} {inner} {ratio} {tie}{kind}: force {errors:?}, stress {axial:.1e}");
                assert!(
                    errors.iter().all(|e| e.abs() < 1e-4) && axial < 1e-4,
                    "{facets:?} {tie}: {errors:?} {axial:e}"
                );
                assert!(last(&ran, "ETOTAL").abs() < 1e-6 * last(&ran, "ALLWK"));
            }
        }
    }
}

/// With NODE TO SURFACE each slave node follows a point of the master surface. A coarse slave surface then transmits less
/// force, and its nodes have the displacement of these points.
#[test]
fn node_to_surface_follows_points() {
    let cards = "*Tie, name=T, type=NODE TO SURFACE\n HIGH.J0, LOW.J1\n";
    let ran = run(&tied_rings([8, 4], 0.0, [1.0; 2], 0.0, cards)).whole();
    let force = reaction(&ran, "LOW") / (-std::f64::consts::PI * 0.9_f64.ln());
    println!("node to surface, 4 facets on 8: {force:.3} of the force");
    assert!(force < 0.97, "{force}");
    let (moved, mesh) = (point_field(ran.end(), "U"), &ran.prepared.plan.mesh);
    for i in 0..5 {
        let at = |name: String| mesh.node_names.iter().position(|n| n.as_str() == name).expect("a node");
        // Nodes are numbered from 1 along r, then along z.
        let (slave, master) = (at(format!("HIGH.{}", i + 1)), at(format!("LOW.{}", 2 * 9 + 2 * i + 1)));
        assert!((moved[2 * slave + 1] - moved[2 * master + 1]).abs() < 1e-12);
    }
    // The fine surface moves through the coarse facets between the tied nodes; contact would be the wrong advice.
    let overlap = ran.outcome.warnings.iter().find(|w| w.contains("overlap")).expect("R311");
    assert!(overlap.contains("although they are tied") && !overlap.contains("*CONTACT"), "{overlap}");
}

/// A narrow disc on a wide one: the facet of the wide one under the edge is tied in part. The force is that of meshes with
/// common nodes at the tie, within the error of the meshes; with the narrow disc as the master too.
#[test]
fn partly_covered_surfaces_are_tied_where_they_are_opposite() {
    let force = |facets, tie: &str| {
        let ran = run(&tied_rings(facets, 0.0, [1.0, 0.6], 0.3, &format!("*Tie, name=T\n {tie}\n"))).whole();
        let [low, high] = ["LOW", "HIGH"].map(|name| reaction(&ran, name));
        assert!((low + high).abs() < 1e-3 * low.abs(), "{low} {high}");
        low
    };
    let common = force([20, 12], "HIGH.J0, LOW.J1");
    for (facets, tie) in [
        ([20, 17], "HIGH.J0, LOW.J1"),
        ([13, 12], "HIGH.J0, LOW.J1"),
        ([23, 8], "HIGH.J0, LOW.J1"),
        ([23, 8], "LOW.J1, HIGH.J0"),
        ([13, 12], "LOW.J1, HIGH.J0"),
    ] {
        let error = force(facets, tie) / common - 1.0;
        println!("{facets:?} {tie}: force {error:+.1e}");
        assert!(error.abs() < 0.02, "{facets:?} {tie}: {error}");
    }
}
