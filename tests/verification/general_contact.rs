//! General contact with analytical rigid surfaces, with both sides of rigid elements, and with interior faces.
//!
//! Goal: the contact domain contains every surface that ABAQUS includes.
//! Source: hand calculation (an elastic rod rebounds with its velocity; load = section area times flow stress), ABAQUS
//! Keywords Guide, "CONTACT INCLUSIONS": ALL EXTERIOR includes all analytical rigid surfaces. The tolerance and its
//! reason are stated at each test.

use std::f64::consts::PI;

use revolve::job;
use revolve::user::Routines;

use crate::common::solid::{grid, last, material, run};

/// Cards of a fixed wall at z = 0 with reference node set REF: an analytical surface, or rigid elements whose surface
/// names no side.
fn wall(analytical: bool) -> &'static str {
    match analytical {
        true => {
            "*Node, nset=REF\n 9000, 0., 0.\n*Surface, type=SEGMENTS, name=WALL\n START, 0., 0.\n LINE, 3., 0.\n\
             *Rigid Body, ref node=9000, analytical surface=WALL\n"
        }
        false => {
            "*Node, nset=REF\n 9000, 0., 0.\n*Node\n 9001, 0., 0.\n 9002, 3., 0.\n*Element, type=RAX2, elset=EW\n \
             9001, 9001, 9002\n*Surface, name=WALL\n EW,\n*Rigid Body, ref node=9000, elset=EW\n"
        }
    }
}

/// Returns an elastic rod of length 1 without lateral expansion and with unit wave speed that flies at a wall with
/// velocity 0.01. It leaves the wall after 2 (two passages of the wave), with the opposite velocity.
fn flying_rod(wall: &str, contact: &str) -> String {
    let cells = 40;
    grid(1, cells, false, |i, j| [i as f64, j as f64 / cells as f64])
        + &material(1.0, 0.0, 1.0, &format!("{wall}*Surface, name=SKIN\n SOLID,\n"))
        + "*Initial Conditions, type=VELOCITY\n ALL, 2, -0.01\n*Step\n*Dynamic, Explicit\n , 3.\n*Boundary\n I0, 1, 1\n\
           REF, 2, 2\n*Contact\n"
        + contact
        + "*Output, history, number interval=30\n*Node Output, nset=ALL\n V2\n*Energy Output\n ALLKE, ETOTAL\n\
           *Contact Output\n CFN\n*End Step\n"
}

/// The mean velocity after the impact is that before it; bulk viscosity takes the highest frequencies of the wave, less
/// than 5 %.
#[test]
fn rod_rebounds_from_surfaces_of_every_kind() {
    let named = "*Contact Inclusions\n WALL, SKIN\n";
    let all = "*Contact Inclusions, all exterior\n";
    let excluded = "*Contact Inclusions, all exterior\n*Contact Exclusions\n , WALL\n";
    for (analytical, contact, rebounds) in [
        (true, all, true),
        (true, named, true),
        (true, "*Contact Inclusions\n , WALL\n", true),
        (true, excluded, false),
        (false, all, true),
        (false, named, true),
        (false, excluded, false),
    ] {
        let deck = flying_rod(wall(analytical), contact);
        let (outcome, memory) = run(&deck);
        assert_eq!(outcome.halt, None);
        let velocities = (1..=82).map(|n| last(&deck, &memory, &format!("V2@{n}")));
        let mean = velocities.sum::<f64>() / 82.0;
        println!("analytical {analytical}, {contact:?}: mean velocity {mean}");
        let expected = if rebounds { 0.01 } else { -0.01 };
        assert!((mean / expected - 1.0).abs() < 0.05, "{analytical} {contact}: {mean}");
        // The front of the impact is a jump of one element.
        assert!(outcome.energy.drift < 5e-3, "{:?}", outcome.energy);
    }
}

/// The ledger names every surface of the contact domain.
#[test]
fn ledger_lists_the_surfaces_of_the_contact_domain() {
    let deck = flying_rod(wall(true), "*Contact Inclusions, all exterior\n");
    let prepared = crate::common::prepared(&deck, &[], &Routines::none());
    let row = prepared.plan.ledger.effects.iter().find(|row| row.effect == "general contact").expect("a row");
    assert_eq!((row.count, row.detail.as_str()), (2, "surfaces SOLID, WALL (analytical)"));
}

/// A perfectly plastic tube between two analytical plates carries its section area times the yield stress. The plates
/// are without friction, so that the tube yields in uniaxial stress; hoop inertia and the wave decay with a slow ramp.
/// The second plate is given with the wrong orientation, and is reversed with a warning.
#[test]
fn tube_between_analytical_plates_carries_its_yield_load() {
    for (order, warned) in [(" START, 40., 20.\n LINE, 0., 20.\n", false), (" START, 0., 20.\n LINE, 40., 20.\n", true)]
    {
        let deck = grid(2, 20, false, |i, j| [10.0 + i as f64, j as f64])
            + &material(2e5, 0.3, 7.8e-9, "*Plastic\n 300., 0.\n")
            + "*Node, nset=LOW\n 901, 0., 0.\n*Node, nset=UP\n 902, 0., 20.\n*Surface, type=SEGMENTS, name=BOTTOM\n \
               START, 0., 0.\n LINE, 40., 0.\n*Surface, type=SEGMENTS, name=TOP\n"
            + order
            + "*Rigid Body, ref node=901, analytical surface=BOTTOM\n*Rigid Body, ref node=902, analytical surface=TOP\n\
               *Amplitude, name=A, definition=SMOOTH STEP\n 0., 0., 2.e-4, 1.\n*Step\n*Dynamic, explicit\n , 2.e-4\n\
               *Boundary\n LOW, 2, 2\n*Boundary, amplitude=A\n UP, 2, 2, -0.4\n*Contact\n\
               *Contact Inclusions, all exterior\n*Output, history, number interval=20\n*Node Output, nset=LOW\n RF2\n\
               *End Step\n";
        let (outcome, memory) = run(&deck);
        assert_eq!(outcome.halt, None);
        let load = last(&deck, &memory, "RF2@LOW");
        let expected = 300.0 * PI * (12.0_f64.powi(2) - 10.0_f64.powi(2));
        println!("tube between plates: {load:e}, {expected:e} expected");
        assert!((load / expected - 1.0).abs() < 0.02, "{load:e}");
        let prepared = crate::common::prepared(&deck, &[], &Routines::none());
        assert_eq!(prepared.diagnostics.iter().any(|d| d.code == "P110"), warned);
    }
}

/// The exterior faces of a surface follow element deletion, so that the face identifier INTERIOR changes nothing. It
/// requires the exterior faces, and solid elements.
#[test]
fn interior_faces_are_those_that_element_deletion_exposes() {
    let deck = |skin: &str| {
        flying_rod(wall(true), "*Contact Inclusions\n WALL, SKIN\n").replace("*Surface, name=SKIN\n SOLID,\n", skin)
    };
    let digest = |skin: &str| run(&deck(skin)).0.digest;
    let plain = digest("*Surface, name=SKIN\n SOLID,\n");
    assert_eq!(digest("*Surface, name=SKIN\n SOLID,\n SOLID, INTERIOR\n"), plain);
    assert_eq!(digest("*Surface, name=SKIN\n SOLID, INTERIOR\n SOLID,\n"), plain);
    let prepared =
        job::prepare_text("test.inp", &deck("*Surface, name=SKIN\n SOLID, INTERIOR\n"), &Vec::new(), &Routines::none());
    let codes: Vec<&str> = prepared.diagnostics.iter().map(|d| d.code).collect();
    assert_eq!(codes, ["M131"], "{}", prepared.diagnostics.render(&prepared.deck.sources));
}
