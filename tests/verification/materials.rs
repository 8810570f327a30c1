//! Material laws on single elements, compared with the laws evaluated by hand.
//!
//! Goal: hardening, failure and element deletion as specified.
//! Source: one-dimensional return mapping and closed forms, implemented independently here. The tolerance is stated at
//! each test.

use revolve::job;
use revolve::solve::Outcome;
use revolve::user::Routines;

use crate::common;
use crate::common::RecordedOutput;
use crate::common::bodies::short;
use crate::common::solid::{column, grid, last, material, run};

/// Returns a cylinder small enough for negligible inertia, whose top is displaced by `displacement` times an amplitude.
fn cylinder(cards: &str, amplitude: &str, displacement: f64, time: f64, variables: &str) -> String {
    grid(1, 1, false, |i, j| [1e-3 * i as f64, 1e-3 * j as f64])
        + &material(200e3, 0.3, 7.85e-9, cards)
        + &format!(
            "*Amplitude, name=A\n {amplitude}\n*Step\n*Dynamic, Explicit\n , {time:e}\n*Boundary\n J0, 2, 2\n\
             *Boundary, amplitude=A\n J1, 2, 2, {displacement:e}\n*Output, history, number interval=400\n\
             *Element Output, elset=SOLID\n {variables}\n*Node Output, nset=J1\n U2\n*Energy Output\n ALLPD, ALLIE\n*End Step\n"
        )
}

fn assert_complete(outcome: &Outcome, drift: f64) {
    assert_eq!(outcome.halt, None);
    println!("{} increments, drift {:.1e}", outcome.increments, outcome.energy.drift);
    assert!(outcome.energy.drift < drift, "drift {:e}", outcome.energy.drift);
}

/// Returns the axial logarithmic strain from the displacements of two corner nodes at the top.
fn strains(deck: &str, memory: &RecordedOutput) -> Vec<f64> {
    let prepared = common::prepared(deck, &[], &Routines::none());
    let at = prepared.plan.columns.iter().position(|c| c.name.starts_with("U2@")).expect("U2");
    memory.rows.iter().map(|row| (1.0 + row.1[at] / 1e-3).ln()).collect()
}

/// An element that yields within two large increments of prescribed motion: ALLIE less ALLPD is the elastic energy of
/// the stress, and the temperature of an adiabatic element rises with ALLPD. Tolerance 1e-3: strains are 1e-4, and work
/// is summed over volumes in the middle of increments.
#[test]
fn strain_energy_is_that_of_the_stress_after_yield_in_large_increments() {
    let [young, ratio, heat] = [200e9, 0.3, 500.0];
    let heated =
        "*Rate Dependent, type=JOHNSON COOK\n 0.02, 1.\n*Specific Heat\n 500.\n*Inelastic Heat Fraction\n 0.9\n";
    let laws = [
        ("*Plastic\n 4.e6, 0.\n", "CAX4R"),
        ("*Plastic\n 4.e6, 0.\n 8.e6, 1.e-4\n", "CAX4R"),
        ("*Plastic\n 4.e6, 0.\n", "CAX3"),
        ("*Plastic, hardening=KINEMATIC\n 4.e6, 0.\n 8.e6, 1.e-4\n", "CAX4R"),
        (&format!("*Plastic, hardening=JOHNSON COOK\n 4.e6, 1.e8, 0.5, 1., 1300., 293.\n{heated}"), "CAX4R"),
        ("*Plastic\n 4.e6, 0.\n", "SAX1"),
    ];
    for (law, kind) in laws {
        let elements = match kind {
            "SAX1" => "*Element, type=SAX1, elset=SOLID\n 1, 1, 3\n*Shell Section, elset=SOLID, material=M\n 0.01, 5\n",
            "CAX3" => "*Element, type=CAX3, elset=SOLID\n 1, 1, 2, 4\n*Solid Section, elset=SOLID, material=M\n",
            _ => "*Element, type=CAX4R, elset=SOLID\n 1, 1, 2, 4, 3\n*Solid Section, elset=SOLID, material=M\n",
        };
        let fixed = if kind == "SAX1" { " ALL, 6\n" } else { "" };
        let adiabatic = if law.contains("Heat") { ", adiabatic" } else { "" };
        let temperature = if law.contains("Heat") { "*Initial Conditions, type=TEMPERATURE\n ALL, 293.\n" } else { "" };
        let deck = format!(
            "*Node, nset=ALL\n 1, 1., 0.\n 2, 1.01, 0.\n 3, 1., 0.01\n 4, 1.01, 0.01\n{elements}*Material, name=M\n\
             *Density\n 7800.,\n*Elastic\n {young:e}, {ratio}\n{law}{temperature}*Step\n*Dynamic, Explicit, direct user \
             control{adiabatic}\n 1.e-6, 2.e-6\n*Boundary, type=VELOCITY\n ALL, 1, 1, 0.\n ALL, 2, 2, 0.\n 3, 2, 2, 0.6\n \
             4, 2, 2, 0.6\n{fixed}*Output, history, frequency=1\n*Element Output, elset=SOLID\n S{}\n*Energy Output\n \
             ALLIE, ALLSE, ALLPD\n*End Step\n",
            if adiabatic.is_empty() { "" } else { ", TEMP" }
        );
        let deck = if kind == "SAX1" {
            deck.replace(" 2, 1.01, 0.\n", "").replace(" 4, 1.01, 0.01\n", "").replace(" 4, 2, 2, 0.6\n", "")
        } else {
            deck
        };
        let (outcome, memory) = run(&deck);
        assert_eq!(outcome.halt, None);
        let value = |name: &str| last(&deck, &memory, name);
        let volume = std::f64::consts::PI
            * match kind {
                "SAX1" => 2.0 * 0.01 * 0.01,
                "CAX3" => 0.5 * 0.01 * 0.01 * 2.0 * (1.0 + 1.01 + 1.01) / 3.0,
                _ => (1.01 * 1.01 - 1.0) * 0.01,
            };
        let normal: Vec<f64> = ["S11", "S22", "S33"]
            .iter()
            .filter(|n| kind != "SAX1" || **n != "S33")
            .map(|n| value(&format!("{n}@SOLID")))
            .collect();
        let shear = if kind == "SAX1" { 0.0 } else { value("S12@SOLID") };
        let (squares, sum) =
            (normal.iter().map(|s| s * s).sum::<f64>() + 2.0 * shear * shear, normal.iter().sum::<f64>());
        let elastic = volume * ((1.0 + ratio) * squares - ratio * sum * sum) / (2.0 * young);
        let (stored, plastic) = (value("ALLSE"), value("ALLPD"));
        println!("{kind} {:?}: ALLSE {stored:e}, elastic energy {elastic:e}, ALLPD {plastic:e}", law.lines().next());
        assert!(
            (stored / elastic - 1.0).abs() < 1e-3 && plastic > 0.05 * elastic,
            "{law}: {stored} {elastic} {plastic}"
        );
        if !adiabatic.is_empty() {
            let rise = value("TEMP@SOLID") - 293.0;
            let expected = 0.9 * plastic / (volume * 7800.0 * heat);
            assert!((rise / expected - 1.0).abs() < 1e-3, "{rise} {expected}");
        }
    }
}

/// Tension, compression and tension with linear kinematic hardening; the stress of each row by hand. Hooke's law is
/// integrated from rates, so the axial stress follows the logarithmic strain.
#[test]
fn kinematic_hardening_cycle_matches_return_mapping() {
    let (young, radius, slope) = (200e3, 300.0, 5000.0);
    let deck = cylinder(
        "*Plastic, hardening=KINEMATIC\n 300., 0.\n 800., 0.1\n",
        "0., 0., 1.e-5, 1., 3.e-5, -1., 5.e-5, 1.",
        2e-5,
        5e-5,
        "S22, PEEQ",
    );
    let (outcome, memory) = run(&deck);
    assert_complete(&outcome, 2e-3);
    let stress = column(&deck, &memory, "S22@SOLID");
    let (mut plastic, mut sum, mut before) = (0.0, 0.0, 0.0);
    let mut worst: f64 = 0.0;
    for (strain, found) in strains(&deck, &memory).into_iter().zip(&stress) {
        // Substeps between rows resolve the reversals of the path.
        for k in 1..=50 {
            let here = before + (strain - before) * f64::from(k) / 50.0;
            let relative: f64 = young * (here - plastic) - slope * plastic;
            let over = relative.abs() - radius;
            if over > 0.0 {
                plastic += relative.signum() * over / (young + slope);
                sum += over / (young + slope);
            }
        }
        before = strain;
        worst = worst.max((found.1 - young * (strain - plastic)).abs());
    }
    let peeq = last(&deck, &memory, "PEEQ@SOLID");
    println!("kinematic: worst {worst:.2} MPa, PEEQ {peeq:.5} against {sum:.5}");
    // The bar vibrates slightly, and reversals occur between rows.
    assert!(worst < 3.0, "{worst}");
    assert!((peeq / sum - 1.0).abs() < 2e-3 && sum > 0.08, "{peeq} {sum}");
}

/// The yield stress is linear between the temperatures of the table, 20 and 220 degrees.
#[test]
fn yield_stress_is_linear_between_temperatures() {
    let deck = cylinder(
        "*Plastic\n 400., 0., 20.\n 500., 0.1, 20.\n 200., 0., 220.\n 240., 0.1, 220.\n",
        "0., 0., 1.e-5, 1.",
        5e-5,
        1e-5,
        "S22, PEEQ",
    )
    .replace("*Step", "*Initial Conditions, type=TEMPERATURE\n ALL, 170.\n*Step");
    let (outcome, memory) = run(&deck);
    assert_complete(&outcome, 2e-3);
    let (stress, strain) = (last(&deck, &memory, "S22@SOLID"), last(&deck, &memory, "PEEQ@SOLID"));
    let expected = 0.25 * (400.0 + 1000.0 * strain) + 0.75 * (200.0 + 400.0 * strain);
    println!("table over temperature: {stress:.3} against {expected:.3}");
    assert!(strain > 0.04 && (stress / expected - 1.0).abs() < 2e-3, "{stress} {expected}");
}

#[test]
fn invalid_materials_are_errors() {
    let deck = |cards: &str| cylinder(cards, "0., 0., 1., 1.", 1e-5, 1e-6, "S22");
    let gas = |cards: &str| deck(cards).replace("*Elastic\n 2e5, 0.3\n", "");
    for (code, text) in [
        ("M104", deck("*Plastic, hardening=KINEMATIC\n 300., 0.\n")),
        ("M103", deck("*Plastic, hardening=KINEMATIC\n 300., 0.\n 200., 0.1\n")),
        ("M104", deck("*Plastic, hardening=KINEMATIC\n 300., 0., 20.\n 400., 0.1, 30.\n")),
        ("M103", deck("*Plastic, hardening=KINEMATIC\n 3., 0., 20.\n 4., 0.1, 20.\n 2., 0., 10.\n 3., 0.1, 10.\n")),
        ("P014", deck("*Plastic\n 300., 0., 20.\n 200., 0.\n")),
        ("P014", deck("*Plastic\n 300., 0., 20.\n 200., 0., 10.\n")),
        ("P019", deck("*Shear Failure\n 0.1,\n")),
        ("P019", deck("*Plastic\n 300., 0.\n*Shear Failure, type=JOHNSON COOK\n 0.1, 0., 0., 0.1\n")),
        ("P013", deck("*Tensile Failure, element deletion=NO\n 100.,\n*Failed Material\n 0.1,\n")),
        ("P014", deck("*Plastic, hardening=KINEMATIC\n 300., 0.\n 400., 0.1\n*Shear Failure\n 0.1,\n")),
        ("P019", gas("*Eos, type=USUP\n 5000., 1.\n*Tensile Failure, element deletion=NO, pressure=BRITTLE\n 100.,\n")),
        ("P019", deck("*Shear Failure, element deletion=NO\n 0.1,\n")),
        ("P019", deck("*Tensile Failure\n 100.,\n*Failed Material\n 0.1,\n")),
        ("M103", deck("*Plastic\n 300., 0.\n*Shear Failure\n 0.1,\n*Failed Material\n 1.,\n")),
        ("M103", deck("*Shear Failure\n 0.1, 1.\n 0.2, 0.\n")),
        ("M104", deck("*Shear Failure\n 0.1, 0., 0., 20., 1.\n")),
        ("M103", deck("*Damage Initiation, criterion=DUCTILE\n 0.1, 0., 5.\n 0.1, 0., 1.\n")),
        ("M103", deck("*Shear Failure\n -0.1,\n")),
        ("M103", deck("*Tensile Failure\n -1.,\n")),
        ("M104", deck("*Damage Initiation, criterion=FLD\n 0.1,\n")),
        ("M103", deck("*Damage Initiation, criterion=DUCTILE\n 0.1, 0.\n 0.1, -1.\n")),
        ("M105", deck("*Damage Evolution, type=ENERGY\n 0.1,\n")),
        ("P013", deck("*Hyperelastic, neo hooke\n 1., 0.1\n")),
        ("P013", gas("*Hyperelastic, neo hooke\n 1., 0.1\n*Plastic\n 1., 0.\n")),
        ("M104", gas("*Hyperelastic, marlow\n 1., 0.1\n")),
        ("M194", gas("*Hyperelastic, yeoh, test data input\n")),
        ("M103", gas("*Hyperelastic, neo hooke\n 1., -0.1\n")),
        ("M167", gas("*Hyperelastic, neo hooke, yeoh\n 1., 0.1\n")),
        ("M103", gas("*Hyperelastic, mooney-rivlin\n 0.1, -0.1, 0.1\n")),
        ("M103", gas("*Hyperelastic, mooney-rivlin\n 0.1, 0.1, 0.1, 20., 5.\n")),
        ("M103", gas("*Hyperelastic, mooney-rivlin, n=2\n 0.1, 0.1, 0.1\n")),
        ("M103", gas("*Hyperelastic, ogden, n=4\n 0.1, 2., 0.1\n")),
        ("M103", gas("*Hyperelastic, ogden\n 0.1, 0., 0.1\n")),
        ("M103", gas("*Hyperelastic, reduced polynomial, n=2\n 0.1, 0.1, 0., 1.\n")),
        ("M104", gas("*Hyperelastic, yeoh\n 1., 0.1\n 1., 0.2\n")),
        ("M102", gas("*Hyperelastic, yeoh\n , 0.1\n")),
        ("P013", deck("*Crushable Foam\n 1.1, 0.1\n")),
        ("P013", deck("*Crushable Foam Hardening\n 1., 0.\n")),
        ("P013", gas("*Crushable Foam\n 1.1, 0.1\n*Crushable Foam Hardening\n 1., 0.\n")),
        ("P013", deck("*Crushable Foam\n 1.1, 0.1\n*Crushable Foam Hardening\n 1., 0.\n*Plastic\n 1., 0.\n")),
        ("M103", deck("*Crushable Foam\n 3.1, 0.1\n*Crushable Foam Hardening\n 1., 0.\n")),
        ("M103", deck("*Crushable Foam, hardening=ISOTROPIC\n 1.1, 0.5\n*Crushable Foam Hardening\n 1., 0.\n")),
        ("M103", deck("*Crushable Foam\n 1.1, 0.1\n*Crushable Foam Hardening\n 1., 0.1\n")),
        ("M103", deck("*Damping, alpha=-1.\n")),
        ("M103", deck("*Damping, beta=-1.e-6\n")),
        ("P013", gas("*Eos, type=JWL\n 6.93e6, 3.7e5, 3231., 0.3, 4.15, 0.95, 4.29e12\n")),
        ("M103", gas("*Eos, type=JWL\n 6.93e6, 3.7e5, 3231., 0.3, 0., 0.95, 4.29e12\n")),
        ("M169", gas("*Eos, type=JWL\n 6.93e6, 3.7e5, 3231., 0.3, 4.15, 0.95, 4.29e15\n*Detonation Point\n 0., 0.\n")),
        ("M103", gas("*Eos, type=TABULAR\n 0., 0., 0.\n 1., 0., 0.1\n")),
        ("M103", gas("*Eos, type=TABULAR\n 0., 0., 0.\n 0., 0., -0.1\n")),
        ("P017", gas("*Hyperelastic, neo hooke\n 1., 0.1\n*Initial Conditions, type=STRESS\n SOLID, 1., 1., 1.\n")),
        ("M102", deck("*Eos, type=JWL\n 1., 1.\n")),
        ("M104", deck("*Eos, type=IGNITION AND GROWTH\n 1., 1.\n")),
        ("M103", deck("*Eos, type=USUP\n -1., 1.\n")),
        ("P013", deck("*Eos, type=USUP\n 5000., 1.\n")),
        ("P013", gas("*Eos, type=IDEAL GAS\n 287., 0.\n")),
        ("P013", gas("*Eos, type=USUP\n 5000., 1.\n*Plastic\n 300., 0.\n")),
        ("P013", deck("*Viscosity\n 1.,\n")),
        ("P013", gas("*Eos, type=USUP\n 5000., 1.\n*Elastic, type=SHEAR\n 100.,\n*Viscosity\n 1.,\n")),
        ("M103", gas("*Eos, type=USUP\n 5000., 1.\n*Viscosity\n 0.,\n")),
        ("P013", gas("*Elastic, type=SHEAR\n 80e3,\n")),
        ("P017", gas("*Eos, type=USUP\n 5000., 1.\n*Initial Conditions, type=STRESS\n SOLID, 1., 1., 1.\n")),
        ("P017", deck("*Initial Conditions, type=SPECIFIC ENERGY\n SOLID, 1.\n")),
    ] {
        let prepared = job::prepare_text("bad.inp", &text, &[], &Routines::none());
        let found = prepared.diagnostics.iter().any(|d| d.code == code);
        assert!(found, "{code}: {text}\n{}", prepared.diagnostics.render(&prepared.deck.sources));
    }
}

/// Runs a perfectly plastic cylinder in tension with failure cards.
fn run_to_failure(cards: &str) -> (String, Outcome, RecordedOutput) {
    let begins = cards.contains("criterion=JOHNSON COOK");
    let variables = if begins { "S22, PEEQ, SDEG, DMICRT, JCCRT, ELPD, ELDMD" } else { "S22, PEEQ" };
    let deck = cylinder(&format!("*Plastic\n 400., 0.\n{cards}"), "0., 0., 1.e-5, 1.", 2e-4, 1e-5, variables);
    let (outcome, memory) = run(&deck);
    // The separated part vibrates after failure.
    assert_complete(&outcome, 2e-3);
    (deck, outcome, memory)
}

/// Elastic energy per volume at the yield stress of 400.
const ELASTIC: f64 = 0.5 * 400.0 * 400.0 / 200e3;

/// Checks ALLPD and ALLDMD of a cylinder, given per volume.
fn assert_dissipated(outcome: &Outcome, expected: [f64; 2]) {
    let volume = std::f64::consts::PI * 1e-9;
    let found = [outcome.energy.plastic, outcome.energy.damage.expect("ALLDMD")];
    let off = [0, 1].map(|i| found[i] / (volume * expected[i]) - 1.0);
    println!("dissipated by plastic flow and damage: {}, errors {}", short(&found), short(&off));
    assert!(off[0].abs() < 5e-3 && off[1].abs() < 5e-3, "{found:?} {expected:?}");
}

/// Returns the plastic strain at which the stress vanishes.
fn strain_at_the_end(deck: &str, memory: &RecordedOutput) -> f64 {
    assert_eq!(last(deck, memory, "S22@SOLID"), 0.0);
    last(deck, memory, "PEEQ@SOLID")
}

/// A deleted element carries no stress from the plastic strain of its criterion on. The triaxiality in uniaxial tension
/// is 1/3.
#[test]
fn elements_fail_at_the_specified_strain() {
    for (cards, expected) in [
        ("*Shear Failure\n 0.12,\n", 0.12),
        ("*Shear Failure, type=JOHNSON COOK\n 0.05, 0.1, 1.5\n", 0.05 + 0.1 * (-0.5f64).exp()),
        (
            "*Damage Initiation, criterion=DUCTILE\n 0.2, 0.\n 0.05, 0.66666666667\n*Damage Evolution, type=DISPLACEMENT\n 0.,\n",
            0.125,
        ),
    ] {
        let (deck, outcome, memory) = run_to_failure(cards);
        let strain = strain_at_the_end(&deck, &memory);
        println!("failed at {strain:.5}, expected {expected:.5}");
        // The strain increment is below 1e-5.
        assert!((strain - expected).abs() < 2e-4, "{strain} {expected}");
        // All stored energy is dissipated.
        let energy = outcome.energy;
        assert!(energy.strain.abs() < 1e-3 * energy.plastic, "{} {}", energy.strain, energy.plastic);
        // Perfect plasticity: 400 times strain and volume, and the elastic energy.
        assert_dissipated(&outcome, [400.0 * strain, ELASTIC]);
    }
}

/// MAX DEGRADATION: the element is deleted at this damage, halfway from a strain of 0.1 to 0.15.
#[test]
fn elements_are_deleted_at_maximum_damage() {
    let cards = "*Plastic\n 400., 0.\n*Damage Initiation, criterion=JOHNSON COOK\n 0.1, 0., 0., 0., 0., 0., 0., 1.\n\
                 *Damage Evolution, type=DISPLACEMENT\n 5.e-5,\n";
    let deck = cylinder(cards, "0., 0., 1.e-5, 1.", 2e-4, 1e-5, "S22, PEEQ, SDEG");
    let section =
        "material=M, controls=C\n*Section Controls, name=C, element deletion=YES, max degradation=0.5\n*Material";
    let deck = deck.replacen("material=M\n*Material", section, 1);
    let (outcome, memory) = run(&deck);
    assert_complete(&outcome, 2e-3);
    let (strain, damage) = (strain_at_the_end(&deck, &memory), last(&deck, &memory, "SDEG@SOLID"));
    println!("deleted at {strain:.5}, damage {damage:.5}");
    assert!((strain - 0.125).abs() < 2e-4 && (damage - 0.5).abs() < 5e-3);
    assert_dissipated(&outcome, [400.0 * (0.1 + 0.025 * 0.75), ELASTIC]);
}

/// ELEMENT DELETION=NO: after the maximum damage, 0.99 without MAX DEGRADATION, the element keeps the undamaged
/// fraction of its yield stress and continues to flow; the energy is that of 400 times the strain by hand.
#[test]
fn failed_elements_remain_without_element_deletion() {
    for (given, most) in [("", 0.99), (", max degradation=0.6", 0.6), (", max degradation=1.", 1.0)] {
        let cards = "*Plastic\n 400., 0.\n*Damage Initiation, criterion=JOHNSON COOK\n 0.05, 0., 0., 0., 0., 0., 0., 1.\n\
                     *Damage Evolution, type=DISPLACEMENT\n 5.e-5,\n";
        let deck = cylinder(cards, "0., 0., 1.e-5, 1.", 2e-4, 1e-5, "S22, PEEQ, SDEG, STATUS");
        let section =
            format!("material=M, controls=C\n*Section Controls, name=C, element deletion=NO{given}\n*Material");
        let (outcome, memory) = run(&deck.replacen("material=M\n*Material", &section, 1));
        assert_complete(&outcome, 2e-3);
        let of = |name: &str| last(&deck, &memory, &format!("{name}@SOLID"));
        let (stress, strain, damage) = (of("S22"), of("PEEQ"), of("SDEG"));
        println!("remaining at {strain:.5}: stress {stress:.5}, damage {damage:.8}");
        assert!((damage - most).abs() < 2e-6 && of("STATUS") == 1.0);
        assert!(strain > 0.15 && (stress - 400.0 * (1.0 - most)).abs() < 1e-2, "{stress} at {strain}");
        // Full stress until 0.05, then linear to the remaining fraction over 0.05 times the damage.
        let left = 1.0 - most;
        let falling = 0.05 * most;
        let area = 0.05 + falling * 0.5 * (1.0 + left) + left * (strain - 0.05 - falling);
        assert_dissipated(&outcome, [400.0 * area, ELASTIC * most]);
    }
}

/// `*DAMAGE INITIATION` without evolution: the criteria are computed, also above 1, and the stress is unaffected to
/// rounding.
#[test]
fn damage_initiation_without_evolution_is_computed() {
    let run = |cards: &str, variables: &str| {
        let text = format!("*Plastic\n 400., 0.\n 500., 1.\n{cards}");
        let deck = cylinder(&text, "0., 0., 1.e-5, 1.", 2e-4, 1e-5, variables);
        let (outcome, memory) = run(&deck);
        assert_complete(&outcome, 2e-3);
        (deck, memory)
    };
    let both = "*Damage Initiation, criterion=JOHNSON COOK\n 0.1, 0., 0., 0., 0., 0., 0., 1.\n\
                *Damage Initiation, criterion=DUCTILE\n 0.2, 0.\n 0.05, 0.66666666667\n";
    let (deck, memory) = run(both, "S22, PEEQ, DMICRT, JCCRT, DUCTCRT");
    let of = |name: &str| column(&deck, &memory, &format!("{name}@SOLID"));
    let [stress, strains, all, cook, ductile] = ["S22", "PEEQ", "DMICRT", "JCCRT", "DUCTCRT"].map(of);
    let end = strains.last().expect("a row").1;
    assert!(end > 0.15, "{end}");
    for (i, (_, p)) in strains.iter().enumerate() {
        assert!((cook[i].1 - p / 0.1).abs() < 1e-9, "{} at {p}", cook[i].1);
        // The triaxiality in uniaxial tension is 1/3, except for waves at the onset of flow.
        assert!((ductile[i].1 - p / 0.125).abs() < 2e-3, "{} at {p}", ductile[i].1);
        assert_eq!(all[i].1, cook[i].1.max(ductile[i].1));
    }
    let (plain_deck, plain) = run("", "S22, PEEQ");
    let without = column(&plain_deck, &plain, "S22@SOLID");
    assert_eq!(stress.len(), without.len());
    for (with, without) in stress.iter().zip(&without) {
        assert!((with.1 - without.1).abs() < 1e-6 * 400.0, "{with:?} {without:?}");
    }
}

/// Linear damage evolution: the stress decreases linearly with plastic displacement, and the dissipated energy is the
/// specified one.
#[test]
fn damage_evolution_has_the_specified_displacement_and_energy() {
    // The element length is 1e-3, so the strain grows by 0.05; an energy of 400 times 5e-5 / 2 is equivalent.
    for evolution in ["type=DISPLACEMENT\n 5.e-5,\n", "type=ENERGY\n 1.e-2,\n"] {
        let begin = "*Damage Initiation, criterion=JOHNSON COOK\n 0.1, 0., 0., 0., 0., 0., 0., 1.\n*Damage Evolution, ";
        let (deck, outcome, memory) = run_to_failure(&format!("{begin}{evolution}"));
        let strain = strain_at_the_end(&deck, &memory);
        assert!((strain - 0.15).abs() < 2e-4, "{strain}");
        let (stress, strains) = (column(&deck, &memory, "S22@SOLID"), column(&deck, &memory, "PEEQ@SOLID"));
        for (s, p) in stress.iter().zip(&strains).filter(|x| (0.1..0.149).contains(&x.1.1)) {
            let expected = 400.0 * (1.0 - (p.1 - 0.1) / 0.05);
            assert!((s.1 - expected).abs() < 2.0, "{} {expected}", s.1);
        }
        // The plastic work is half of that without damage.
        assert_dissipated(&outcome, [400.0 * (0.1 + 0.025), ELASTIC]);
        let damage = column(&deck, &memory, "SDEG@SOLID");
        for (d, p) in damage.iter().zip(&strains).filter(|x| (0.1..0.149).contains(&x.1.1)) {
            assert!((d.1 - (p.1 - 0.1) / 0.05).abs() < 5e-3, "{} at {}", d.1, p.1);
        }
        let [all, own] = ["DMICRT@SOLID", "JCCRT@SOLID"].map(|name| column(&deck, &memory, name));
        for ((begun, same), p) in all.iter().zip(&own).zip(&strains) {
            assert_eq!(begun, same);
            assert!((begun.1 - (p.1 / 0.1).min(1.0)).abs() < 1e-9, "{} at {}", begun.1, p.1);
        }
        let found = [outcome.energy.plastic, outcome.energy.damage.expect("ALLDMD")];
        let parts = ["ELPD@SOLID", "ELDMD@SOLID"].map(|name| column(&deck, &memory, name));
        let last = |of: &[(f64, f64)]| of.last().expect("a row").1;
        assert!((last(&parts[0]) / found[0] - 1.0).abs() < 1e-9 && (last(&parts[1]) / found[1] - 1.0).abs() < 1e-9);
    }
}

/// A load on an element face ends with the element; the rest of the cylinder continues without force.
#[test]
fn loads_end_with_the_deleted_element() {
    let deck = grid(1, 1, false, |i, j| [1e-3 * i as f64, 1e-3 * j as f64])
        + &material(200e3, 0.3, 7.85e-9, "*Plastic\n 400., 0.\n*Shear Failure\n 0.05,\n")
        + "*Amplitude, name=A\n 0., 0., 1.e-6, 1., 1., 1.\n*Step\n*Dynamic, Explicit\n , 3.e-6\n*Boundary\n J0, 2, 2\n\
           *Dsload, amplitude=A\n J1, P, -500.\n*Output, history, frequency=1\n*Node Output, nset=J1\n A2, V2\n\
           *Energy Output\n ALLWK\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert_complete(&outcome, 2e-3);
    let prepared = common::prepared(&deck, &[], &Routines::none());
    let at = |start: &str| prepared.plan.columns.iter().position(|c| c.name.starts_with(start)).expect("a column");
    let free = memory.rows.iter().skip(1).position(|row| row.1[at("A2@")] == 0.0).expect("the end of the load") + 1;
    let after = &memory.rows[free..];
    println!("free from row {free} of {}", memory.rows.len());
    assert!(free > 100 && after.len() >= 3);
    // The last half increment of the trapezoidal work appears one row later.
    for row in &after[1..] {
        assert_eq!((row.1[at("A2@")], row.1[at("ALLWK")]), (0.0, after[1].1[at("ALLWK")]));
        assert!(row.1[at("V2@")] > 0.0);
    }
}

/// A fluid in tension: the tension is limited to the cutoff or vanishes with the element.
#[test]
fn tensile_failure_limits_tension() {
    for (deletion, expected) in [("NO", -50.0), ("YES", 0.0)] {
        let deck = grid(1, 1, false, |i, j| [1e-3 * i as f64, 1e-3 * j as f64])
            + &format!(
                "*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n 1.e-9,\n*Eos, type=USUP\n 1.5e6, 1.9, 0.1\n\
                 *Tensile Failure, element deletion={deletion}\n 50.,\n*Step\n*Dynamic, Explicit\n , 1.e-7\n*Boundary\n ALL, 1, 1\n\
                 J0, 2, 2\n*Boundary, type=VELOCITY\n J1, 2, 2, 1000.\n*Output, history, number interval=10\n\
                 *Element Output, elset=SOLID\n PRESS\n*End Step\n"
            );
        let (outcome, memory) = run(&deck);
        // All energy is the work of the prescribed motion on the fluid.
        assert_complete(&outcome, 5e-2);
        let pressure = last(&deck, &memory, "PRESS@SOLID");
        assert!((pressure - expected).abs() < 1e-9, "{pressure} {expected}");
    }
}

/// Returns the relative error of the kinetic energy at time 0.5 of a fluid with the axial velocity V J0(j0 r) in a pipe
/// of radius 1 with walls at rest, with `n` elements. The kinematic viscosity is 0.3, so that the closed form decays
/// by a factor of 5.7 (the first decay constant of axial flow is ν j0², with J0(j0) = 0). The deck ends with `more`.
fn decay_error(n: usize, more: &str) -> (f64, Outcome, [f64; 2]) {
    let (first_root, viscosity, time) = (2.404_825_557_695_773_f64, 0.3, 0.5);
    // J0 by its power series, which converges to rounding in twenty terms for arguments up to j0.
    let j0 = |x: f64| {
        let terms = (1..20).scan(1.0, |term, k| {
            *term *= -0.25 * x * x / (k * k) as f64;
            Some(*term)
        });
        1.0 + terms.sum::<f64>()
    };
    let mut deck = grid(n, 1, false, |i, j| [i as f64 / n as f64, 0.05 * j as f64])
        + &format!(
            "*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n 2.,\n*Eos, type=USUP\n 10., 0., 0.\n\
             *Viscosity\n {},\n*Initial Conditions, type=VELOCITY\n",
            2.0 * viscosity
        );
    for i in 0..n {
        let v = 1e-4 * j0(first_root * i as f64 / n as f64);
        deck += &format!(" {}, 2, {v:.17e}\n {}, 2, {v:.17e}\n", i + 1, i + n + 2);
    }
    deck += &format!(
        "*Step\n*Dynamic, Explicit\n , {time}\n*Boundary\n ALL, 1, 1\n I1, 2, 2\n{more}*Output, history, number interval=10\n\
         *Energy Output\n ALLKE, ALLVD, ALLIE, ETOTAL\n*End Step\n"
    );
    let (outcome, memory) = run(&deck);
    assert_complete(&outcome, 1e-3);
    let energies = column(&deck, &memory, "ALLKE");
    let (start, end) = (energies[0].1, energies.last().expect("rows").1);
    let exact = (-2.0 * viscosity * first_root * first_root * time).exp();
    let dissipated = last(&deck, &memory, "ALLVD") / (start - end);
    ((end / start / exact - 1.0).abs(), outcome, [dissipated, last(&deck, &memory, "ALLIE") / start])
}

/// The decay of axial flow in a pipe has second order in the element length, and the lost kinetic energy is viscous
/// dissipation.
#[test]
fn viscous_flow_decays_as_the_closed_form() {
    let [coarse, fine] = [10, 20].map(|n| decay_error(n, ""));
    let order = (coarse.0 / fine.0).log2();
    println!("errors {:e} {:e}, order {order}", coarse.0, fine.0);
    assert!(order > 1.9, "{order}");
    assert!(fine.0 < 5e-3, "{}", fine.0);
    let [dissipated, internal] = fine.2;
    // Hourglass modes and the change of volume take less than 0.1 % of the energy.
    assert!((dissipated - 1.0).abs() < 1e-3 && internal.abs() < 1e-3, "{dissipated} {internal}");
}

/// The viscosity limits the stable time increment: of diffusion, it is proportional to the square of the element length.
#[test]
fn viscosity_limits_the_stable_increment() {
    let [coarse, fine] = [80, 160].map(|n| decay_error(n, "").1.steps[0].largest_increment);
    println!("{coarse:e} {fine:e}");
    let ratio = coarse / fine;
    assert!((3.0..4.1).contains(&ratio), "{ratio}");
}

/// Neo-Hooke with C10 = 0.5 and D1 = 0.1: shear modulus 1, bulk modulus 20.
const RUBBER: &str = "*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n 1.e-9,\n*Hyperelastic, neo hooke\n 0.5, 0.1\n";

/// Stretches a block of rubber. Returns the final displacements of node 4 and the stresses.
fn stretch_rubber(boundary: &str) -> [f64; 6] {
    let deck = grid(1, 1, false, |i, j| [i as f64, j as f64])
        + RUBBER
        + "*Nset, nset=CORNER\n 4,\n*Amplitude, name=A, definition=SMOOTH STEP\n 0., 0., 0.02, 1.\n*Step\n*Dynamic, Explicit\n , 0.02\n"
        + &format!("*Boundary\n J0, 2, 2\n*Boundary, amplitude=A\n {boundary}\n")
        + "*Output, history, number interval=100\n*Node Output, nset=CORNER\n U1, U2\n*Element Output, elset=SOLID\n S11, S22, S33, S12\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert_complete(&outcome, 1e-3);
    let of = |name: &str| last(&deck, &memory, name);
    let corner = ["U1@CORNER", "U2@CORNER"].map(of);
    let [rr, zz, hoop, rz] = ["S11@SOLID", "S22@SOLID", "S33@SOLID", "S12@SOLID"].map(of);
    [corner[0], corner[1], rr, zz, hoop, rz]
}

/// Uniaxial tension to a stretch of 2.5 and equibiaxial to 1.8: stresses of the closed form at the computed stretches,
/// and zero stress in free directions.
#[test]
fn neo_hooke_tension_matches_closed_form() {
    for (boundary, equibiaxial) in [("J1, 2, 2, 1.5", false), ("I1, 1, 1, 0.8", true)] {
        let [u, w, rr, zz, hoop, rz] = stretch_rubber(boundary);
        let (radial, axial) = (1.0 + u, 1.0 + w);
        let j = radial * radial * axial;
        let deviator =
            |stretch: f64| j.powf(-5.0 / 3.0) * (stretch * stretch - (2.0 * radial * radial + axial * axial) / 3.0);
        let (expected_r, expected_z) = (deviator(radial) + 20.0 * (j - 1.0), deviator(axial) + 20.0 * (j - 1.0));
        println!("rubber: {radial:.4} {axial:.4}: rr {rr:.5} {expected_r:.5}, zz {zz:.5} {expected_z:.5}");
        // Rounding only: the deformation gradient is exact.
        for (got, expected) in [(rr, expected_r), (hoop, expected_r), (zz, expected_z), (rz, 0.0)] {
            assert!((got - expected).abs() < 1e-9, "{got} {expected}");
        }
        let (free, held) = if equibiaxial { (zz, rr) } else { (rr, zz) };
        // The block vibrates slightly.
        assert!(free.abs() < 0.02 && held > 2.0, "{free} {held}");
    }
}

/// Simple shear of a ring with a large radius: S12 = 2 C10 gamma and S22 - S11 = 2 C10 gamma^2 at gamma = 2.
#[test]
fn neo_hooke_shear_matches_closed_form() {
    let deck = grid(1, 1, false, |i, j| [1e6 + i as f64, j as f64])
        + RUBBER
        + "*Amplitude, name=A\n 0., 0., 0.01, 1.\n*Step\n*Dynamic, Explicit\n , 0.01\n*Boundary\n ALL, 1, 1\n I0, 2, 2\n\
           *Boundary, amplitude=A\n I1, 2, 2, 2.\n*Output, history, number interval=10\n\
           *Element Output, elset=SOLID\n S11, S22, S33, S12\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert_complete(&outcome, 1e-3);
    let [rr, zz, hoop, rz] = ["S11@SOLID", "S22@SOLID", "S33@SOLID", "S12@SOLID"].map(|n| last(&deck, &memory, n));
    println!("rubber in shear: {rr} {zz} {hoop} {rz}");
    // Rounding of the radius 1e6, summed over the increments.
    for (got, expected) in [(rz, 2.0), (zz - rr, 4.0), (hoop - rr, 0.0), (rr + zz + hoop, 0.0)] {
        assert!((got - expected).abs() < 1e-5, "{got} {expected}");
    }
}

/// Johnson-Cook with rate dependence and heating, one element compressed at constant velocity: yield stress by hand.
#[test]
fn johnson_cook_with_heating_matches_quadrature() {
    let cards = "*Plastic, hardening=JOHNSON COOK\n 806., 614., 0.168, 1.1, 1540., 20.\n*Rate Dependent, type=JOHNSON COOK\n 0.0089, 1.\n\
                 *Inelastic Heat Fraction\n 0.9,\n*Specific Heat\n 4.6e8,\n";
    // Uniform motion v_z = -1000 z with free v_r; inertia is negligible in the small element.
    let deck = grid(1, 1, false, |i, j| [1e-3 * i as f64, 1e-3 * j as f64])
        + &material(206e3, 0.3, 7.83e-9, cards)
        + "*Initial Conditions, type=TEMPERATURE\n ALL, 20.\n*Step\n*Dynamic, Explicit, adiabatic\n , 3.e-4\n*Boundary\n J0, 2, 2\n\
           *Boundary, type=VELOCITY\n J1, 2, 2, -1.\n*Output, history, number interval=300\n*Element Output, elset=SOLID\n MISES, PEEQ, TEMP, S11\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert!(outcome.halt.is_none(), "{:?}", outcome.halt);
    let [mises, strain, heat] = ["MISES", "PEEQ", "TEMP"].map(|n| column(&deck, &memory, &format!("{n}@SOLID")));
    // Temperature by quadrature of the plastic work of the hand-written law, rate by differences of the strain.
    let law = |p: f64, rate: f64, t: f64| {
        (806.0 + 614.0 * p.powf(0.168))
            * (1.0 + 0.0089 * rate.ln().max(0.0))
            * (1.0 - ((t - 20.0) / 1520.0).max(0.0).powf(1.1))
    };
    let mut temperature = 20.0;
    for k in 1..strain.len() {
        let (dp, dt) = (strain[k].1 - strain[k - 1].1, strain[k].0 - strain[k - 1].0);
        temperature += 0.9 / (7.83e-9 * 4.6e8) * 0.5 * (mises[k].1 + mises[k - 1].1) * dp;
        if k > 10 && dp > 0.0 {
            let expected = law(strain[k].1, dp / dt, heat[k].1);
            assert!((mises[k].1 / expected - 1.0).abs() < 2e-3, "row {k}: {} {expected}", mises[k].1);
        }
    }
    let got = heat.last().expect("a row").1;
    assert!(got > 60.0 && ((got - 20.0) / (temperature - 20.0) - 1.0).abs() < 5e-3, "{got} {temperature}");
}
