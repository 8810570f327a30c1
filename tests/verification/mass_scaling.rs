//! Mass scaling of deformable elements.
//!
//! Goal: increments become what is asked, masses what they must be, free fall and the energy balance do not suffer.
//! Source: hand calculation (volumes of rings, square law of frequency and mass, v = g t), ABAQUS Analysis User's Guide,
//! "Mass scaling". Each test says its tolerance and why.

use std::f64::consts::PI;

use revolve::job;
use revolve::solve::Outcome;
use revolve::user::Routines;

use crate::common::solid::{column, grid, last, material, run};

/// Two by two cells, those of the outer column a fifth as wide: a step at rest with these cards.
fn body(cards: &str) -> String {
    grid(2, 2, false, |i, j| [[0.0, 1.0, 1.2][i], j as f64])
        + &material(100.0, 0.3, 2.0, "")
        + "*Elset, elset=THIN\n 2, 4\n*Elset, elset=WIDE\n 1, 3\n"
        + &step(cards)
}

fn step(cards: &str) -> String {
    format!("*Step\n*Dynamic, Explicit, element by element\n , 3.\n{cards}*End Step\n")
}

fn largest(outcome: &Outcome) -> f64 {
    outcome.steps.last().expect("a step").largest_increment
}

fn added(outcome: &Outcome) -> f64 {
    outcome.steps.last().expect("a step").added_mass.expect("added mass")
}

/// Volume times density: pi (1.2^2 - 0) 2 times 2.
const MASS: f64 = PI * 1.44 * 2.0 * 2.0;
/// That of the thin elements.
const THIN: f64 = PI * 0.44 * 2.0 * 2.0;

/// Increments are those of the formula in another order of sums: 1e-12.
fn near(got: f64, expected: f64) {
    assert!((got / expected - 1.0).abs() < 1e-12, "{got} is not {expected}");
}

#[test]
fn a_factor_on_all_mass_stretches_the_increment_by_its_root() {
    let plain = run(&body("")).0;
    let scaled = run(&body("*Fixed Mass Scaling, factor=9.\n")).0;
    near(largest(&scaled), 3.0 * largest(&plain));
    near(added(&scaled), 8.0 * MASS);
    assert_eq!(plain.steps[0].added_mass, None);
    let less = run(&body("*Fixed Mass Scaling, factor=0.25\n")).0;
    near(largest(&less), 0.5 * largest(&plain));
    near(added(&less), -0.75 * MASS);
}

/// The factor of a part is on that part alone, and the increment that of the part which limits.
#[test]
fn an_element_set_is_scaled_alone() {
    let plain = run(&body("")).0;
    let scaled = run(&body("*Fixed Mass Scaling, factor=4., elset=THIN\n")).0;
    near(largest(&scaled), 2.0 * largest(&plain));
    near(added(&scaled), 3.0 * THIN);
}

#[test]
fn the_increment_becomes_what_is_asked_by_each_type() {
    let plain = largest(&run(&body("")).0);
    let dt = 1.5 * plain;
    for (card, every) in [("Fixed", ""), ("Variable", ", frequency=2"), ("Variable", ", number interval=5")] {
        let cards = |kind: &str, dt: f64| format!("*{card} Mass Scaling, dt={dt:.17e}, type={kind}{every}\n");
        // Only the thin ones are below it; uniform scales all by 1.5^2.
        let below = run(&body(&cards("below min", dt))).0;
        near(largest(&below), dt);
        near(added(&below), 1.25 * THIN);
        let uniform = run(&body(&cards("uniform", dt))).0;
        near(largest(&uniform), dt);
        near(added(&uniform), 1.25 * MASS);
        // Nothing is below this: no mass is added, and set equal takes some away.
        let slow = 0.5 * plain;
        let none = run(&body(&cards("below min", slow))).0;
        near(largest(&none), plain);
        assert_eq!(added(&none), 0.0);
        let equal = run(&body(&cards("set equal dt", slow))).0;
        near(largest(&equal), slow);
        assert!(added(&equal) < -0.75 * THIN);
    }
}

/// A factor first, then the increment: the factor alone has done more than is asked of the thin elements.
#[test]
fn a_factor_comes_before_an_increment_and_fixed_before_variable() {
    let plain = largest(&run(&body("")).0);
    let dt = 1.5 * plain;
    for cards in [
        format!("*Fixed Mass Scaling, factor=4., dt={dt:e}, elset=THIN\n"),
        format!("*Fixed Mass Scaling, factor=4., elset=THIN\n*Variable Mass Scaling, dt={dt:e}, frequency=1\n"),
    ] {
        near(added(&run(&body(&cards)).0), 3.0 * THIN);
    }
}

/// A step without a card keeps the masses, one with a card begins from the original ones.
#[test]
fn scaling_goes_on_until_another_step_scales() {
    let text =
        body("*Fixed Mass Scaling, factor=9.\n") + &step("") + &step("*Fixed Mass Scaling, factor=4., elset=THIN\n");
    let (outcome, _) = run(&text);
    let plain = largest(&run(&body("")).0);
    near(outcome.steps[0].largest_increment, 3.0 * plain);
    near(outcome.steps[1].largest_increment, 3.0 * plain);
    // Now the thin elements limit again; no increment of the step may be longer, nor after the first shorter.
    near(outcome.steps[2].largest_increment, 2.0 * plain);
    for (step, mass) in outcome.steps.iter().zip([8.0 * MASS, 8.0 * MASS, 3.0 * THIN]) {
        near(step.added_mass.expect("added mass"), mass);
    }
}

/// All points fall alike, whatever their mass; v = g t and u = g t^2/2 hold for central differences with constant
/// acceleration to rounding, and the work of gravity is that on the scaled mass.
#[test]
fn scaled_bodies_fall_as_all_bodies_do() {
    let cards = |scaling: &str| {
        format!(
            "{scaling}*Dload\n , GRAV, 9.81, 0., -1.\n*Output, history, frequency=1\n*Node Output, nset=ALL\n U2, V2\n\
             *Energy Output\n ALLKE, ALLWK\n"
        )
    };
    for scaling in ["", "*Fixed Mass Scaling, factor=5., elset=THIN\n"] {
        let text = body(&cards(scaling));
        let (outcome, memory) = run(&text);
        assert_eq!(outcome.halt, None);
        let row = &memory.rows.last().expect("a row").1;
        let wanted = |x: f64| ((x + 9.81 * 3.0) / 9.81).abs() < 1e-9 || ((x + 4.5 * 9.81) / 9.81).abs() < 1e-9;
        assert!(row[..18].iter().all(|x| wanted(*x)), "{row:?}");
        let mass = MASS + if scaling.is_empty() { 0.0 } else { 4.0 * THIN };
        let kinetic = 0.5 * mass * (9.81 * 3.0_f64).powi(2);
        // Central differences take v(i-1/2) v(i+1/2) in place of v^2: less by (g dt/2)^2 of it.
        assert!((last(&text, &memory, "ALLKE") / kinetic - 1.0).abs() < 1e-3);
        // The work of the half increment at the start is exact; the last increment is shorter: (dt/t)^2/4 of the energy, less
        // what it still has.
        assert!(outcome.energy.drift < 1e-5, "{:e}", outcome.energy.drift);
    }
}

/// Mass that comes at a velocity brings half m v^2, which ALLWK shows, and the sum of all energies stays.
#[test]
fn added_mass_brings_kinetic_energy_that_is_booked() {
    let text = |scaling: &str| {
        let moves = "*Initial Conditions, type=VELOCITY\n ALL, 2, 3.\n";
        let output = "*Output, history, frequency=1\n*Energy Output\n ALLKE, ALLWK, ETOTAL\n";
        body("").replace("*Step\n", &format!("{moves}*Step\n")).replace("*End Step", &format!("{output}*End Step"))
            + &step(scaling)
    };
    let deck = text("*Fixed Mass Scaling, factor=4., elset=THIN\n");
    let (outcome, memory) = run(&deck);
    let gained = 0.5 * 3.0 * THIN * 9.0;
    near(last(&deck, &memory, "ALLWK"), gained);
    near(last(&deck, &memory, "ALLKE"), 0.5 * MASS * 9.0 + gained);
    let total = column(&deck, &memory, "ETOTAL");
    assert!(total.iter().all(|t| (t.1 / total[0].1 - 1.0).abs() < 1e-11), "{total:?}");
    assert!(outcome.energy.drift < 1e-11, "{:e}", outcome.energy.drift);
}

/// A bar struck at one end by a prescribed velocity, squeezed so that variable scaling works on and on, at moving and at
/// held nodes. The trapezoid of work and a deck without scaling agree in their drift.
#[test]
fn the_energy_balance_holds_while_masses_change() {
    let text = |scaling: &str| {
        grid(3, 12, false, |i, j| [i as f64, j as f64])
            + &material(1000.0, 0.3, 1.0, "*Plastic\n 10., 0.\n 40., 1.\n")
            + &format!(
                "*Step\n*Dynamic, Explicit\n , 1.\n{scaling}*Boundary\n J0, 2, 2\n*Boundary, type=VELOCITY\n J1, 2, 2, -4.\n\
                 *End Step\n"
            )
    };
    let plain = run(&text("")).0;
    let dt = 1.3 * plain.steps[0].largest_increment;
    for every in ["frequency=1", "frequency=7", "number interval=10"] {
        let outcome = run(&text(&format!("*Variable Mass Scaling, dt={dt:e}, {every}\n"))).0;
        assert_eq!(outcome.halt, None);
        assert!(outcome.increments < plain.increments, "{} {}", outcome.increments, plain.increments);
        println!("{every}: drift {:.1e}, without scaling {:.1e}", outcome.energy.drift, plain.energy.drift);
        assert!(outcome.energy.drift < 1e-2, "{:e}", outcome.energy.drift);
    }
}

#[test]
fn what_cannot_be_scaled_is_refused() {
    let fails = |text: &str, code: &str| {
        let prepared = job::prepare_text("test.inp", text, &Vec::new(), &Routines::none());
        let codes: Vec<&str> = prepared.diagnostics.iter().map(|d| d.code).collect();
        assert!(codes.contains(&code), "{code} is not in {codes:?} for {text}");
        assert!(prepared.diagnostics.has_errors());
    };
    for (cards, code) in [
        ("*Fixed Mass Scaling\n", "M103"),
        ("*Fixed Mass Scaling, factor=-1.\n", "M103"),
        ("*Fixed Mass Scaling, dt=0.\n", "M103"),
        ("*Fixed Mass Scaling, factor=2., type=uniform\n", "M103"),
        ("*Fixed Mass Scaling, dt=1., type=rolling\n", "M104"),
        ("*Variable Mass Scaling, dt=1.\n", "M103"),
        ("*Variable Mass Scaling, dt=1., frequency=0\n", "M103"),
        ("*Variable Mass Scaling, frequency=1\n", "M103"),
        ("*Variable Mass Scaling, dt=1., frequency=1, feed rate=2.\n", "M104"),
        ("*Fixed Mass Scaling, factor=2.\n*Dload\n THIN, GRAV, 9.81, 0., -1.\n", "P022"),
    ] {
        fails(&body(cards), code);
    }
    let gas =
        body("*Fixed Mass Scaling, factor=2.\n").replace("*Elastic\n 1e2, 0.3\n", "*Eos, type=USUP\n 10., 1.5, 1.\n");
    fails(&gas, "P022");
    let rubber = body("*Fixed Mass Scaling, factor=2.\n")
        .replace("*Elastic\n 1e2, 0.3\n", "*Hyperelastic, neo hooke\n 20., 0.1\n");
    fails(&rubber, "P022");
    let ideal = body("*Variable Mass Scaling, dt=1., frequency=1\n")
        .replace("*Elastic\n 1e2, 0.3\n", "*Eos, type=IDEAL GAS\n 287., 0.\n*Specific Heat\n 700.,\n");
    fails(&ideal, "P022");
    fails(&("*Fixed Mass Scaling, factor=2.\n".to_owned() + &body("")), "M105");
}
