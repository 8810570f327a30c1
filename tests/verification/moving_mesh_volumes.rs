//! Volumes of elements and of their material where the mesh does not follow the material.
//!
//! Goal: no energy from nothing. Source: a bar without stress in free flight has no energy but its kinetic energy; a body
//! whose mesh follows the material. Tolerances are stated at each test.

use std::fmt::Write as _;

use revolve::job;
use revolve::output::HistorySummary;
use revolve::solve::Outcome;
use revolve::user::Routines;

use crate::common;
use crate::common::solid;

/// Energies other than the kinetic energy.
const ENERGIES: [&str; 6] = ["ALLIE", "ALLSE", "ALLVD", "ALLPD", "ALLAE", "ALLADV"];

const USUP: &str = "8930.\n*Eos, type=USUP\n 3940., 1.489, 2.02\n*Elastic, type=SHEAR\n 4.8e10\n*Plastic\n 1.e8, 0.\n";
const TABLE: &str = "8930.\n*Eos, type=TABULAR\n -1.386e10, 2.02, 0.1\n 1.386e10, 2.02, -0.1\n";
const GAS: &str = "1.2\n*Eos, type=IDEAL GAS\n 287., 103320.\n*Specific Heat\n 717.5\n";
const JWL: &str = "1630.\n*Eos, type=JWL\n 6930., 3.712E11, 3.231E9, 0.3, 4.15, 0.95, 4.29E6, 9.e9\n*Detonation Point\n 0., 0., , 1.\n";
const ELASTIC: &str = "8930.\n*Elastic\n 1.2e11, 0.34\n*Plastic\n 1.e8, 0.\n";

const REMESH: [&str; 2] = ["*Remesh, elset=BAR, angle=59.9, frequency=1\n", ""];
const ADAPTIVE: [&str; 2] = ["", "*Adaptive Mesh, elset=BAR\n"];

/// Returns a bar of 3 by 5 cells in free flight, of quadrilaterals or pairs of triangles. A node inside is out of line,
/// and a node of the outline at the same height by `bulge`. `cards` belong to the model and to the step.
fn bar(law: &str, cards: [&str; 2], triangles: bool, bulge: f64) -> String {
    let mut deck = "*Node, nset=ALL\n".to_owned();
    for (i, j) in (0..6).flat_map(|j| (0..4).map(move |i| (i, j))) {
        let [mut r, mut z] = [1.07e-3 * f64::from(i), 1.84e-3 * f64::from(j)];
        match (i, j) {
            (1, 2) => (r, z) = (1.5e-3, 3.1e-3),
            (3, 2) => r += bulge,
            _ => {}
        }
        writeln!(deck, "{}, {r:e}, {z:e}", 1 + i + 4 * j).expect("text");
    }
    writeln!(deck, "*Element, type={}, elset=BAR", if triangles { "CAX3" } else { "CAX4R" }).expect("text");
    for (i, j) in (0..5).flat_map(|j| (0..3).map(move |i| (i, j))) {
        let a = 1 + i + 4 * j;
        let corners = [a, a + 1, a + 5, a + 4];
        let e = 1 + 2 * (i + 3 * j);
        if triangles {
            let [a, b, c, d] = corners;
            writeln!(deck, "{e}, {a}, {b}, {c}\n{}, {a}, {c}, {d}", e + 1).expect("text");
        } else {
            writeln!(deck, "{e}, {corners:?}").expect("text");
        }
    }
    let deck = deck.replace(['[', ']'], "");
    let [of_model, of_step] = cards;
    deck + "*Nset, nset=AXIS, generate\n 1, 21, 4\n*Section Controls, name=NO_SUBZONES, subzonal=NO\n"
        + "*Solid Section, elset=BAR, material=M, controls=NO_SUBZONES\n"
        + of_model
        + "*Material, name=M\n*Density\n "
        + law
        + "*Physical Constants, absolute zero=0.\n*Initial Conditions, type=VELOCITY\n ALL, 2, -310.\n"
        + if law == GAS { "*Initial Conditions, type=TEMPERATURE\n ALL, 300.\n" } else { "" }
        + "*Step\n*Dynamic, Explicit\n , 20.e-6\n*Boundary\n AXIS, 1, 1\n"
        + of_step
        + "*Output, history, number interval=50\n*Energy Output\n ALL\n*Element Output, elset=BAR, \
           statistics=\"MIN, MAX\"\n DENSITY\n*End Step\n"
}

fn run(deck: &str) -> (Outcome, HistorySummary) {
    job::run_in_memory(&common::prepared(deck, &[], &Routines::none()))
}

/// Returns the number of changes of the mesh of a run that is complete.
fn changes(outcome: &Outcome) -> u64 {
    assert_eq!(outcome.halt, None);
    outcome.new_meshes.iter().chain(&outcome.mesh_changes).map(|changes| changes.count).sum()
}

/// Returns the largest energy other than the kinetic one, relative to the kinetic energy.
fn energy_from_nothing((outcome, history): &(Outcome, HistorySummary)) -> f64 {
    assert!(changes(outcome) > 0);
    let largest = |name: &&str| history.0.get(*name).map_or(0.0, |column| column.max.abs().max(column.min.abs()));
    ENERGIES.iter().map(largest).fold(0.0, f64::max) / outcome.energy.initial
}

/// A change of a bent outline changes no pressure: energies other than the kinetic one are zero to rounding.
#[test]
fn a_new_mesh_of_a_bar_in_free_flight_makes_no_energy() {
    for law in [USUP, TABLE, GAS, JWL, ELASTIC] {
        for (cards, triangles) in [(REMESH, false), (ADAPTIVE, false), (REMESH, true), (ADAPTIVE, true)] {
            for bulge in [1e-3, 0.0] {
                let energy = energy_from_nothing(&run(&bar(law, cards, triangles, bulge)));
                println!("{energy:.1e}: {} {cards:?}, triangles {triangles}, bulge {bulge}", &law[..20]);
                assert!(energy < 1e-12, "{energy:e}: {law} {cards:?}, triangles {triangles}, bulge {bulge}");
            }
        }
    }
}

/// The mass follows the volume of a bent outline, also without an equation of state: the nodes of an adaptive mesh slide
/// and keep the volume of the body, so that densities stay within 1e-3. A new mesh has another outline; the change of the
/// whole volume, 0.6 %, is shared by all elements within 2e-3.
#[test]
fn densities_stay_uniform_when_the_outline_changes() {
    for law in [USUP, ELASTIC] {
        let densities = |cards| {
            let (outcome, history) = run(&bar(law, cards, false, 1e-3));
            assert!(changes(&outcome) > 0);
            ["DENSITY_MIN@BAR", "DENSITY_MAX@BAR"].map(|name| history.0[name].last / 8930.0)
        };
        let [[low, high], [low_of_new, high_of_new]] = [densities(ADAPTIVE), densities(REMESH)];
        println!("adaptive {low:.5} to {high:.5}, new mesh {low_of_new:.5} to {high_of_new:.5}");
        assert!((low - 1.0).abs() < 1e-3 && (high - 1.0).abs() < 1e-3, "{low} {high}");
        assert!((low_of_new - 1.0).abs() < 8e-3 && high_of_new / low_of_new - 1.0 < 2e-3, "{low_of_new} {high_of_new}");
    }
}

/// A bar of few elements that hits a wall: strain energy does not fall below zero, and bulk viscosity dissipates what it
/// does on the mesh that follows the material, within 2 % of the energy put in.
#[test]
fn an_impact_on_a_moving_mesh_makes_no_strain_energy() {
    let impact = |cards| {
        let deck = bar(USUP, cards, false, 0.0)
            .replace("*Nset, nset=AXIS", "*Nset, nset=FOOT, generate\n 1, 4\n*Nset, nset=AXIS");
        run(&deck.replace(" AXIS, 1, 1\n", " AXIS, 1, 1\n FOOT, 2, 2\n").replace(" , 20.e-6\n", " , 40.e-6\n"))
    };
    let (follows, reference) = impact(["", ""]);
    let initial = follows.energy.initial;
    for cards in [REMESH, ["", "*Adaptive Mesh, elset=BAR, frequency=1\n"]] {
        let (outcome, history) = impact(cards);
        let [strain, viscous] = [history.0["ALLSE"].min, history.0["ALLVD"].last - reference.0["ALLVD"].last];
        println!("{} changes: ALLSE {:.4}, ALLVD {:.4}", changes(&outcome), strain / initial, viscous / initial);
        assert!(changes(&outcome) > 2 && strain > -0.02 * initial && viscous.abs() < 0.02 * initial);
    }
}

/// A column of water in a smooth tube hits a wall at 100 m/s. By the Rankine-Hugoniot relation the wall stops the momentum
/// of the column at the rate rho (c0 + s V) V A. The mesh of such a body may change without further cards: subzonal
/// pressures are the default only where it follows the material. Tolerance: the start of the shock, on 12 elements.
#[test]
fn fluids_have_changing_meshes_without_section_controls() {
    let [radius, length, speed, time] = [2e-3, 4.8e-3, 100.0, 2e-6];
    for [of_model, of_step] in [
        ["", ""],
        ["*Remesh, elset=SOLID, angle=59.9, frequency=5\n", ""],
        ["", "*Adaptive Mesh, elset=SOLID, frequency=3\n"],
    ] {
        let mut deck = solid::grid(5, 12, false, |i, j| {
            [radius * i as f64 / 5.0, length * (j as f64 + if i == 2 && j == 6 { 0.2 } else { 0.0 }) / 12.0]
        });
        deck += "*Solid Section, elset=SOLID, material=WATER\n";
        deck += of_model;
        deck += "*Material, name=WATER\n*Density\n 1000.\n*Eos, type=USUP\n 1480., 1.75, 0.28\n";
        write!(deck, "*Initial Conditions, type=VELOCITY\n ALL, 2, {}\n", -speed).expect("text");
        write!(deck, "*Step\n*Dynamic, Explicit\n , {time}\n{of_step}*Boundary\n J0, 2, 2\n I1, 1, 1\n").expect("text");
        deck += "*Output, history, number interval=20\n*Energy Output, elset=SOLID\n PARTMASS, PARTMOM\n*End Step\n";
        let (outcome, memory) = solid::run(&deck);
        assert_eq!(outcome.halt, None);
        let [mass, momentum] = ["PARTMASS@SOLID", "PARTMOM@SOLID"].map(|name| solid::last(&deck, &memory, name));
        let area = std::f64::consts::PI * radius * radius;
        let expected = 1000.0 * area * speed * ((1480.0 + 1.75 * speed) * time - length);
        println!("{of_model}{of_step}: mass {mass:e}, momentum {momentum:e}, expected {expected:e}");
        assert!((mass / (1000.0 * area * length) - 1.0).abs() < 1e-12, "{mass}");
        assert!((momentum / expected - 1.0).abs() < 0.02, "{momentum} {expected}");
    }
}
