//! Thermal strain and heating by plastic work.
//!
//! Goal: stresses of constrained thermal expansion and of a thick cylinder between two temperatures; temperatures of
//! plastic elements.
//! Source: closed forms (Timoshenko and Goodier 1970, Theory of Elasticity, art. 151; ABAQUS Analysis User's Guide
//! 26.1.2 "Thermal expansion" and 6.5.4 "Adiabatic analysis"). The tolerance and its reason are stated at each test.

use crate::common;
use crate::common::solid::{column, grid, last, material, run};
use revolve::user::{LoadFailure, MaterialAnswer, MaterialCall, Routines, UserMaterial};

const ELASTIC: &str = "*Density\n 1.,\n*Elastic\n 1., 0.3\n*Conductivity\n 0.05,\n*Specific Heat\n 1.,\n";

fn thermal_body(n: usize, m: usize, place: impl Fn(usize, usize) -> [f64; 2], cards: &str) -> String {
    grid(n, m, false, place).replace("CAX4R", "CAX4RT")
        + "*Solid Section, elset=SOLID, material=M\n*Material, name=M\n"
        + ELASTIC
        + cards
}

fn coupled_step(duration: f64, cards: &str) -> String {
    format!(
        "*Step\n*Dynamic Temperature-displacement, Explicit\n , {duration}\n{cards}*Output, field, number interval=1\n\
         *Node Output\n U, NT\n*Element Output\n S, TEMP, LE\n*Output, history, number interval=40\n*Energy Output\n\
         ALLHF, ALLIHE, ALLPD, ETOTAL\n*End Step\n"
    )
}

/// Fully constrained expansion has the stress -E alpha dT/(1 - 2 nu) to rounding; with a table and ZERO by the formula
/// of the manual.
#[test]
fn constrained_expansion_stress_matches_closed_form() {
    let place = |i: usize, j: usize| [i as f64 + 0.1 * (j % 2) as f64 * (i as f64), j as f64];
    let held = "*Boundary\n ALL, 1, 2\n*Dflux\n SOLID, BF, 10.\n";
    for (rows, strain) in [
        ("*Expansion\n 1e-5,\n", 1e-5 * 60.0),
        ("*Expansion, zero=50.\n 1e-5, 0.\n 2e-5, 100.\n", 1.8e-5 * 30.0 - 1.2e-5 * -30.0),
    ] {
        let deck = thermal_body(3, 3, place, rows)
            + "*Initial Conditions, type=TEMPERATURE\n ALL, 20.\n"
            + &coupled_step(6.0, held);
        let (outcome, memory) = run(&deck);
        assert!(outcome.halt.is_none());
        let frame = memory.frames.last().expect("a frame");
        let field = |name: &str| &frame.cell_fields.iter().find(|f| f.name == name).expect("a field").values;
        assert!(field("TEMP").iter().all(|t| (t / 80.0 - 1.0).abs() < 1e-12));
        for s in field("S").chunks(4) {
            let expected = -strain / (1.0 - 0.6);
            assert!(
                s[..3].iter().all(|s| (s / expected - 1.0).abs() < 1e-11) && s[3].abs() < 1e-14,
                "{s:?} {expected}"
            );
        }
    }
}

/// Free expansion is alpha dT in every direction, without stress after the waves have decayed.
#[test]
fn free_expansion_is_stress_free() {
    let ramp = "*Amplitude, name=SLOW, definition=SMOOTH STEP\n 0., 0., 100., 1., 200., 0.\n";
    let deck = thermal_body(4, 4, |i, j| [0.25 * i as f64, 0.25 * j as f64], "*Expansion\n 1e-5,\n")
        + ramp
        + &coupled_step(400.0, "*Boundary\n J0, 2, 2\n*Dflux, amplitude=SLOW\n SOLID, BF, 0.5\n");
    let (outcome, memory) = run(&deck);
    assert!(outcome.energy.drift < 2e-3, "{}", outcome.energy.drift);
    let frame = memory.frames.last().expect("a frame");
    let field = |name: &str| &frame.cell_fields.iter().find(|f| f.name == name).expect("a field").values;
    let rise = field("TEMP")[0];
    assert!((rise / 50.0 - 1.0).abs() < 1e-3, "{rise}");
    let strain = 1e-5 * rise;
    assert!(field("S").iter().all(|s| s.abs() < 1e-6 * strain), "{:?}", field("S"));
    let even = |le: &[f64]| le[..3].iter().all(|e| (e / strain - 1.0).abs() < 1e-6) && le[3].abs() < 1e-6 * strain;
    assert!(field("LE").chunks(4).all(even), "{:?}", field("LE"));
    let grown = &frame.point_fields.iter().find(|f| f.name == "U").expect("U").values;
    for (u, [r, z]) in grown.chunks(2).zip(&frame.points) {
        let expected = |x: f64| x * (1.0 - (-strain).exp());
        assert!((u[0] - expected(*r)).abs() < 1e-9 && (u[1] - expected(*z)).abs() < 1e-9, "{u:?} at {r}, {z}");
    }
}

/// Thick cylinder from 1 to 2 with temperature 1 inside and 0 outside and no axial strain: all stresses of all elements
/// over E alpha dT.
#[test]
fn thick_cylinder_thermal_stress_matches_closed_form() {
    let (nu, alpha, ln2) = (0.3, 1e-6, 2.0_f64.ln());
    let exact = |r: f64| {
        let factor = alpha / (2.0 * (1.0 - nu) * ln2);
        let (log, part) = ((2.0 / r).ln(), ln2 / 3.0);
        let radial = factor * (-log - part * (1.0 - 4.0 / (r * r)));
        let hoop = factor * (1.0 - log - part * (1.0 + 4.0 / (r * r)));
        [radial, nu * (radial + hoop) - alpha * log / ln2, hoop]
    };
    let errors = [8, 16, 32].map(|n| {
        let ramp = "*Amplitude, name=SLOW, definition=SMOOTH STEP\n 0., 0., 200., 1.\n";
        let deck = thermal_body(n, 1, |i, j| [1.0 + i as f64 / n as f64, j as f64 / n as f64], "*Expansion\n 1e-6,\n")
            + ramp
            + &coupled_step(
                320.0,
                "*Boundary\n ALL, 2, 2\n I1, 11, 11, 0.\n*Boundary, amplitude=SLOW\n I0, 11, 11, 1.\n",
            );
        let (outcome, memory) = run(&deck);
        assert!(outcome.halt.is_none());
        let frame = memory.frames.last().expect("a frame");
        let stress = &frame.cell_fields.iter().find(|f| f.name == "S").expect("S").values;
        let mut worst: f64 = 0.0;
        for (cell, s) in frame.cells.iter().zip(stress.chunks(4)) {
            let r = cell.iter().map(|&p| frame.points[p as usize][0]).sum::<f64>() / cell.len() as f64;
            let expected = exact(r);
            worst = (0..3).map(|k| (s[k] - expected[k]).abs() / alpha).fold(worst, f64::max);
        }
        worst
    });
    let order = (errors[1] / errors[2]).log2();
    println!("thick cylinder: errors {errors:?}, order {order:.2}");
    assert!(order > 1.6 && order < 2.5, "order {order}: {errors:?}");
    assert!(errors[2] < 5e-3, "{errors:?}");
}

/// Returns a body of CAX4R whose nodal temperatures `*TEMPERATURE` prescribes.
fn prescribed_body(n: usize, m: usize, place: impl Fn(usize, usize) -> [f64; 2], material: &str) -> String {
    grid(n, m, false, place) + "*Solid Section, elset=SOLID, material=M\n*Material, name=M\n" + material
}

fn prescribed_step(duration: f64, cards: &str) -> String {
    format!(
        "*Step\n*Dynamic, Explicit\n , {duration}\n{cards}*Output, field, number interval=1\n\
         *Node Output\n U, NT\n*Element Output\n S, TEMP\n*Output, history, number interval=40\n*Energy Output\n\
         ALLIE, ETOTAL\n*End Step\n"
    )
}

/// Prescribed temperatures of a constrained body, from 20 to 80 in the first step: -E alpha dT/(1 - 2 nu). In the second
/// they return to 20 (OP=NEW), in the third they jump to 50. Exact to rounding, with `NT` of the nodes.
#[test]
fn prescribed_temperatures_have_the_closed_form_stress_in_each_step() {
    let place = |i: usize, j: usize| [i as f64 + 0.1 * (j % 2) as f64 * (i as f64), j as f64];
    let elastic = "*Density\n 1.,\n*Elastic\n 1., 0.3\n*Expansion\n 1e-5,\n";
    let plastic = "*Density\n 1.,\n*Elastic\n 1., 0.3\n*Expansion\n 1e-5,\n*Plastic\n 1., 0., 0.\n 0.5, 0., 1000.\n";
    for material in [elastic, plastic] {
        let steps =
            ["*Temperature, amplitude=RAMP\n ALL, 80.\n", "*Temperature, op=NEW\n", "*Temperature\n ALL, 50.\n"];
        let held = |cards: &str| format!("*Boundary\n ALL, 1, 2\n{cards}");
        let deck = prescribed_body(3, 3, place, material)
            + "*Initial Conditions, type=TEMPERATURE\n ALL, 20.\n*Amplitude, name=RAMP\n 0., 0.25, 6., 1.\n"
            + &steps.map(|cards| prescribed_step(6.0, &held(cards))).concat();
        let (outcome, memory) = run(&deck);
        assert!(outcome.halt.is_none());
        assert!(outcome.energy.drift < 1e-12, "{}", outcome.energy.drift);
        for (frame, temperature) in memory.frames[memory.frames.len() - 3..].iter().zip([80.0, 20.0, 50.0]) {
            let cells = |name: &str| &frame.cell_fields.iter().find(|f| f.name == name).expect("a field").values;
            let nodes = &frame.point_fields.iter().find(|f| f.name == "NT11").expect("NT").values;
            let is_given = |t: &f64| (t / temperature - 1.0).abs() < 1e-12;
            assert!(cells("TEMP").iter().chain(nodes).all(is_given), "{:?}", cells("TEMP"));
            for s in cells("S").chunks(4) {
                let expected = -1e-5 * (temperature - 20.0) / (1.0 - 0.6);
                assert!(s[..3].iter().all(|s| (s - expected).abs() < 1e-15), "{s:?} {expected}");
            }
        }
    }
}

/// A temperature that differs from the initial one at the start: -E alpha dT/(1 - 2 nu) with constant moduli, with moduli from
/// a table, and with initial temperatures at some nodes of the element, where the others have 0.
#[test]
fn temperature_jump_at_the_start_has_its_stress() {
    let corner = |i: usize, j: usize| [i as f64, j as f64];
    let heads = ["*Density\n 1.,\n*Expansion\n 1e-5,\n", "*Density\n 1.,\n*Expansion, zero=10.\n 1e-5,\n"];
    for (elastic, start, rise) in [
        ("*Elastic\n 1., 0.3\n", "ALL, 20.", 60.0),
        ("*Elastic\n 1., 0.3, 0.\n 1., 0.3, 1000.\n", "ALL, 20.", 60.0),
        ("*Elastic\n 1., 0.3, 0.\n 1., 0.3, 1000.\n", "J0, 20.", 70.0),
    ] {
        for head in heads {
            let deck = prescribed_body(1, 1, corner, &format!("{head}{elastic}"))
                + &format!("*Initial Conditions, type=TEMPERATURE\n {start}\n")
                + &prescribed_step(6.0, "*Boundary\n ALL, 1, 2\n*Temperature\n ALL, 80.\n");
            let (outcome, memory) = run(&deck);
            assert!(outcome.halt.is_none());
            let frame = memory.frames.last().expect("a frame");
            let stress = &frame.cell_fields.iter().find(|f| f.name == "S").expect("S").values;
            let expected = -1e-5 * rise / 0.4;
            assert!(
                stress[..3].iter().all(|s| (s / expected - 1.0).abs() < 1e-11),
                "{elastic}{start}: {stress:?} {expected}"
            );
        }
    }
}

/// Temperatures given by sets at both ends: nodes of a refined mesh between them have the interpolated temperature; with two
/// amplitudes the deck is refused.
#[test]
fn refined_meshes_interpolate_temperatures_of_sets() {
    let corner = |i: usize, j: usize| [1.0 + i as f64, j as f64];
    let body = prescribed_body(1, 1, corner, "*Density\n 1.,\n*Elastic\n 1., 0.3\n*Expansion\n 1e-5,\n")
        + "*Amplitude, name=A\n 0., 1., 9., 1.\n";
    let deck = body.clone() + &prescribed_step(1.0, "*Boundary\n ALL, 1, 2\n*Temperature\n I0, 10.\n I1, 20.\n");
    let (_, memory) = common::run(&deck, &[("mesh", "2")], &Routines::none());
    let frame = memory.frames.last().expect("a frame");
    let temperatures = &frame.point_fields.iter().find(|f| f.name == "NT11").expect("NT11").values;
    assert_eq!(frame.points.len(), 9);
    for (place, temperature) in frame.points.iter().zip(temperatures) {
        assert!((temperature - 10.0 * place[0]).abs() < 1e-12, "{place:?} {temperature}");
    }
    let deck = body + &prescribed_step(1.0, "*Temperature\n I0, 10.\n*Temperature, amplitude=A\n I1, 20.\n");
    let prepared = revolve::job::prepare_text("a.inp", &deck, &common::pairs(&[("mesh", "2")]), &Routines::none());
    assert!(prepared.diagnostics.iter().any(|finding| finding.code == "M190"));
}

/// A shrink fit: a ring at 1 < r < 2 of the same material as the shaft is cooled by 100. The temperature between nodes is
/// linear, so it falls from 0 to -100 at 1 - h < r < 1. Stress at the axis without axial strain (Timoshenko and Goodier, art.
/// 151): E alpha / (1 - nu) times the mean of T over the section, halved. Second order.
#[test]
fn shrink_fit_has_the_closed_form_stress_of_the_shaft() {
    let exact = |h: f64| {
        // Integral of r from 1 to 2, and of r (r - 1 + h)/h from 1 - h to 1.
        let sum = 1.5 + (0.5 * h - h * h / 6.0);
        -1e-6 * 100.0 * sum / 4.0 / 0.7
    };
    let errors = [4, 8].map(|n| {
        let place = |i: usize, j: usize| [2.0 * i as f64 / (2 * n) as f64, j as f64 / n as f64];
        let ring = (n..=2 * n).flat_map(|i| [1 + i, 2 + i + 2 * n]);
        let rings: Vec<String> = ring.map(|node| format!(" {node}, -100.\n")).collect();
        let deck = prescribed_body(2 * n, 1, place, "*Density\n 1.,\n*Elastic\n 1., 0.3\n*Expansion\n 1e-6,\n")
            + "*Amplitude, name=SLOW, definition=SMOOTH STEP\n 0., 0., 200., 1.\n"
            + &prescribed_step(
                320.0,
                &format!("*Boundary\n ALL, 2, 2\n*Temperature, amplitude=SLOW\n{}", rings.concat()),
            );
        let (outcome, memory) = run(&deck);
        assert!(outcome.halt.is_none());
        let frame = memory.frames.last().expect("a frame");
        let radial = &frame.cell_fields.iter().find(|f| f.name == "S").expect("S").values;
        (radial[0] / exact(1.0 / n as f64) - 1.0).abs()
    });
    println!("shrink fit: errors {errors:?}");
    assert!(errors[1] < 5e-3 && errors[1] < 0.3 * errors[0], "{errors:?}");
}

const METAL: &str = "*Density\n 7800.,\n*Elastic\n 200.e9, 0.3\n*Plastic\n 500.e6, 0.\n 600.e6, 1.\n*Specific Heat\n 500.,\n\
     *Inelastic Heat Fraction\n 0.9\n";

/// Returns an element of 1 mm compressed uniaxially at 10 m/s for 30 microseconds.
fn compressed_element(dynamic: &str, kind: &str, cards: &str) -> String {
    grid(1, 1, false, |i, j| [i as f64 * 1e-3, j as f64 * 1e-3]).replace("CAX4R", kind)
        + "*Elset, elset=ONE\n 1\n*Solid section, elset=SOLID, material=M\n*Material, name=M\n"
        + METAL
        + cards
        + "*Initial conditions, type=TEMPERATURE\n ALL, 20.\n*Step\n"
        + dynamic
        + "\n , 3.e-5\n*Boundary\n J0, 2, 2\n*Boundary, type=VELOCITY\n J1, 2, 2, -10.\n*Output, history, number interval=20\n\
           *Element output, elset=ONE\n TEMP, PEEQ, S22\n*Energy output\n ALLPD\n*End step\n"
}

const COUPLED: &str = "*Dynamic Temperature-displacement, Explicit";

/// The inelastic heat fraction of the plastic work heats an adiabatic element and an element of a coupled step.
/// Tolerance 1.5e-3: heat is per mass and work per volume, and the elastic volume change is Y/3K = 1e-3.
#[test]
fn plastic_work_heats_by_the_specified_fraction() {
    let mass = 7800.0 * std::f64::consts::PI * 1e-9;
    let rises = [("*Dynamic, Explicit, adiabatic", "CAX4R"), (COUPLED, "CAX4RT")].map(|(dynamic, kind)| {
        let deck = compressed_element(dynamic, kind, "*Conductivity\n 50.,\n");
        let (_, memory) = run(&deck);
        let rise = last(&deck, &memory, "TEMP@ONE") - 20.0;
        let expected = 0.9 * last(&deck, &memory, "ALLPD") / (mass * 500.0);
        assert!(rise > 30.0 && (rise / expected - 1.0).abs() < 1.5e-3, "{dynamic}: {rise} {expected}");
        rise
    });
    assert!((rises[0] / rises[1] - 1.0).abs() < 1e-9, "{rises:?}");
}

/// ALLIHE is ALLHF plus the inelastic heat fraction of ALLPD in a plastic, conducting, cooled bar.
#[test]
fn heat_balance_closes() {
    let deck = grid(4, 8, false, |i, j| [i as f64 * 1e-3, j as f64 * 1e-3]).replace("CAX4R", "CAX4RT")
        + "*Solid section, elset=SOLID, material=M\n*Material, name=M\n"
        + METAL
        + "*Conductivity\n 5e3,\n*Expansion\n 1.2e-5,\n*Initial conditions, type=TEMPERATURE\n ALL, 20.\n\
           *Initial conditions, type=VELOCITY\n ALL, 2, -200.\n*Step\n"
        + COUPLED
        + "\n , 2.e-5\n*Boundary\n J0, 2, 2\n J0, 11, 11, 20.\n*Film\n EI1, F2, 0., 1e6\n*Output, history, number interval=20\n\
           *Energy output\n ALLHF, ALLIHE, ALLPD, ETOTAL\n*End step\n";
    let (outcome, memory) = run(&deck);
    // A foot fixed suddenly vibrates, with and without heat.
    assert!(outcome.halt.is_none() && outcome.energy.drift < 1e-2, "{}", outcome.energy.drift);
    let [outside, internal_heat, plastic] = ["ALLHF", "ALLIHE", "ALLPD"].map(|name| last(&deck, &memory, name));
    assert!(outside < -0.01 * internal_heat, "{outside} {internal_heat}");
    assert!(((internal_heat - outside) / (0.9 * plastic) - 1.0).abs() < 3e-3, "{internal_heat} {outside} {plastic}");
}

/// Thermal expansion with element temperatures in an adiabatic step: a uniaxial test has only the axial yield stress,
/// and the volume grows by 3 alpha dT.
#[test]
fn adiabatic_elements_expand_thermally() {
    let volume = |cards: &str| {
        let deck = compressed_element("*Dynamic, Explicit, adiabatic", "CAX4R", cards)
            .replace("TEMP, PEEQ", "TEMP, PEEQ, EVOL");
        let (outcome, memory) = run(&deck);
        assert!(outcome.energy.drift < 2e-2);
        [last(&deck, &memory, "EVOL@ONE"), last(&deck, &memory, "TEMP@ONE") - 20.0]
    };
    let ([cold, _], [warm, rise]) = (volume(""), volume("*Expansion\n 1.2e-5,\n"));
    let expected = 3.0 * 1.2e-5 * rise;
    assert!(((warm / cold - 1.0) / expected - 1.0).abs() < 2e-2, "{} {expected}", warm / cold - 1.0);
    let expansion_is_unused = |cards: &str, dynamic: &str| {
        let prepared = common::prepared(&compressed_element(dynamic, "CAX4R", cards), &[], &Routines::none());
        prepared.plan.ledger.unused.iter().any(|u| u.what == "*EXPANSION")
    };
    assert!(expansion_is_unused("*Expansion\n 1.2e-5,\n", "*Dynamic, Explicit"));
    assert!(!expansion_is_unused("*Expansion\n 1.2e-5,\n", "*Dynamic, Explicit, adiabatic"));
}

/// Johnson-Cook uses nodal temperatures: halfway to melting, with m = 1, the yield stress is halved.
#[test]
fn johnson_cook_uses_nodal_temperatures() {
    let stress = |temperature: f64| {
        let deck = compressed_element(COUPLED, "CAX4RT", "*Conductivity\n 50.,\n")
            .replace(
                "*Plastic\n 500.e6, 0.\n 600.e6, 1.\n",
                "*Plastic, hardening=JOHNSON COOK\n 500.e6, 0., 1., 1., 1020., 20.\n",
            )
            .replace("*Boundary\n J0, 2, 2\n", &format!("*Boundary\n J0, 2, 2\n ALL, 11, 11, {temperature}\n"));
        let (_, memory) = run(&deck);
        let temperatures = column(&deck, &memory, "TEMP@ONE");
        assert!(temperatures.iter().all(|t| (t.1 - temperature).abs() < 1e-9), "{temperatures:?}");
        last(&deck, &memory, "S22@ONE")
    };
    for (temperature, expected) in [(20.0, -500e6), (520.0, -250e6), (770.0, -125e6)] {
        let found = stress(temperature);
        // Inertia, rho v^2.
        assert!((found - expected).abs() < 0.8e6, "{temperature}: {found}");
    }
}

/// Hooke's law with E = 1 and nu = 0.3, inelastic energy of 0.02 per mass and time, and a check of the temperatures it
/// receives.
struct HookeMaterial;

impl UserMaterial for HookeMaterial {
    fn stress(&mut self, call: &MaterialCall<'_>, answer: &mut MaterialAnswer<'_>) -> Result<(), LoadFailure> {
        let (n, lame, shear2) = (call.count, 0.3 / (1.3 * 0.4), 1.0 / 1.3);
        let [old, new] = call.temperature;
        if call.now.increment > 1 && !old.iter().zip(new).all(|(old, new)| new > old) {
            return Err(LoadFailure::new("the temperatures do not increase"));
        }
        for i in 0..n {
            let trace: f64 = (0..3).map(|k| call.strain[k * n + i]).sum();
            for k in 0..4 {
                let volume = if k < 3 { lame * trace } else { 0.0 };
                answer.stress[k * n + i] = call.stress[k * n + i] + volume + shear2 * call.strain[k * n + i];
            }
            answer.inelastic[i] = call.inelastic[i] + 0.02 * call.dt;
        }
        Ok(())
    }
}

/// A constrained user material receives the strain without the thermal part, and nodal temperatures raised by its
/// inelastic energy and by a flux.
#[test]
fn user_material_receives_mechanical_strain_and_temperature() {
    let deck = thermal_body(3, 3, |i, j| [i as f64, j as f64], "*Expansion\n 1e-5,\n*Inelastic Heat Fraction\n 0.5\n")
        .replace("*Elastic\n 1., 0.3\n", "*User Material, constants=1\n 1.,\n")
        + "*Initial Conditions, type=TEMPERATURE\n ALL, 20.\n"
        + &coupled_step(20.0, "*Boundary\n ALL, 1, 2\n*Dflux\n SOLID, BF, 3.\n");
    let (outcome, memory) = common::run(&deck, &[], &Routines::none().with_material(HookeMaterial));
    assert!(outcome.halt.is_none(), "{:?}", outcome.halt);
    let frame = memory.frames.last().expect("a frame");
    let field = |name: &str| &frame.cell_fields.iter().find(|f| f.name == name).expect("a field").values;
    let rise = 3.0 * 20.0 + 0.5 * 0.02 * 20.0;
    assert!(field("TEMP").iter().all(|t| ((t - 20.0) / rise - 1.0).abs() < 1e-12), "{:?}", field("TEMP"));
    // The heat of the last increment is in the temperature but not yet in the strain.
    for s in field("S").chunks(4) {
        let expected = -1e-5 * rise / (1.0 - 0.6);
        assert!(s[..3].iter().all(|s| (s / expected - 1.0).abs() < 1e-3), "{s:?} {expected}");
    }
}

/// Initial temperatures of single nodes: an element has the mean of its nodes, and equal values give the bits of a set.
#[test]
fn elements_start_with_the_mean_of_their_nodes() {
    let start = |conditions: &str| {
        let text = grid(2, 1, false, |i, j| [i as f64, j as f64])
            + &material(100.0, 0.3, 1.0, "").replace(", 0.3\n", ", 0.3, 0.\n 50., 0.3, 1000.\n")
            + &format!(
                "*Initial Conditions, type=TEMPERATURE\n{conditions}*Step\n*Dynamic, Explicit\n , 1.e-3\n\
                        *Output, history, number interval=1\n*Element Output, elset=SOLID\n TEMP\n*End Step\n"
            );
        let (_, memory) = run(&text);
        memory.rows[0].1.clone()
    };
    assert_eq!(start(" 1, 10.\n 2, 20.\n 3, 30.\n 4, 40.\n 5, 50.\n 6, 60.\n"), [30.0, 40.0]);
    let each: String = (1..=6).map(|node| format!(" {node}, 0.1\n")).collect();
    assert_eq!(start(&each), start(" ALL, 0.1\n"));
    assert_eq!(start(" ALL, 0.1\n"), [0.1; 2]);
}
