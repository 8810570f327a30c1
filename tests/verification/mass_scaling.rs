//! Mass scaling of deformable elements.
//!
//! Goal: increments and masses are those specified; free fall and the energy balance are correct.
//! Source: hand calculation (volumes of rings, increment proportional to the root of the mass, v = g t), ABAQUS
//! Analysis User's Guide, "Mass scaling". The tolerance and its reason are stated at each test.

use std::f64::consts::PI;

use revolve::job;
use revolve::solve::Outcome;
use revolve::user::Routines;

use crate::common::solid::{column, grid, in_six_node_triangles, last, material, run};

/// Returns a body at rest with two by two cells, the outer ones a fifth as wide, and a step with `cards`.
fn body_with(cards: &str) -> String {
    grid(2, 2, false, |i, j| [[0.0, 1.0, 1.2][i], j as f64])
        + &material(100.0, 0.3, 2.0, "")
        + "*Elset, elset=THIN\n 2, 4\n*Elset, elset=WIDE\n 1, 3\n"
        + &step(cards)
}

fn step(cards: &str) -> String {
    format!("*Step\n*Dynamic, Explicit, element by element\n , 3.\n{cards}*End Step\n")
}

fn largest_increment_of(outcome: &Outcome) -> f64 {
    outcome.steps.last().expect("a step").largest_increment
}

fn added_mass_of(outcome: &Outcome) -> f64 {
    outcome.steps.last().expect("a step").added_mass.expect("added mass")
}

/// Mass of the body: pi (1.2^2 - 0) 2 times density 2.
const MASS: f64 = PI * 1.44 * 2.0 * 2.0;
/// Mass of the thin elements.
const THIN: f64 = PI * 0.44 * 2.0 * 2.0;

/// Asserts equality to the rounding of sums in another order, 1e-12.
fn assert_near(got: f64, expected: f64) {
    assert!((got / expected - 1.0).abs() < 1e-12, "{got} found, expected {expected}");
}

#[test]
fn mass_factor_scales_the_increment_by_its_root() {
    let plain = run(&body_with("")).0;
    let scaled = run(&body_with("*Fixed Mass Scaling, factor=9.\n")).0;
    assert_near(largest_increment_of(&scaled), 3.0 * largest_increment_of(&plain));
    assert_near(added_mass_of(&scaled), 8.0 * MASS);
    assert_eq!(plain.steps[0].added_mass, None);
    let less = run(&body_with("*Fixed Mass Scaling, factor=0.25\n")).0;
    assert_near(largest_increment_of(&less), 0.5 * largest_increment_of(&plain));
    assert_near(added_mass_of(&less), -0.75 * MASS);
}

/// The factor scales only its set, and the most critical elements limit the increment.
#[test]
fn mass_scaling_is_limited_to_its_element_set() {
    let plain = run(&body_with("")).0;
    let scaled = run(&body_with("*Fixed Mass Scaling, factor=4., elset=THIN\n")).0;
    assert_near(largest_increment_of(&scaled), 2.0 * largest_increment_of(&plain));
    assert_near(added_mass_of(&scaled), 3.0 * THIN);
}

/// The thin elements gain the part b of the mass of all: their increment grows by the root of 1 + b MASS/THIN. A target that needs
/// less mass is kept.
#[test]
fn budget_limits_the_added_mass() {
    let plain = largest_increment_of(&run(&body_with("")).0);
    for (card, every) in [("Fixed", ""), ("Variable", ", frequency=2")] {
        let scaled = |dt: f64, budget: f64| {
            run(&body_with(&format!("*{card} Mass Scaling, dt={dt:e}, budget={budget}{every}\n"))).0
        };
        for budget in [0.01, 0.2] {
            let ran = scaled(100.0 * plain, budget);
            let added = added_mass_of(&ran) / (budget * MASS);
            let increment = largest_increment_of(&ran) / (plain * (1.0 + budget * MASS / THIN).sqrt());
            assert!((1.0 - 1e-3..=1.0).contains(&added) && (increment - 1.0).abs() < 1e-5, "{added} {increment}");
        }
        assert_near(added_mass_of(&scaled(1.5 * plain, 0.5)), 1.25 * THIN);
    }
}

#[test]
fn each_scaling_type_reaches_the_target_increment() {
    let plain = largest_increment_of(&run(&body_with("")).0);
    let dt = 1.5 * plain;
    for (card, every) in [("Fixed", ""), ("Variable", ", frequency=2"), ("Variable", ", number interval=5")] {
        let cards = |kind: &str, dt: f64| format!("*{card} Mass Scaling, dt={dt:.17e}, type={kind}{every}\n");
        // Only the thin elements are below this increment; `uniform` scales all masses by 1.5^2.
        let below = run(&body_with(&cards("below min", dt))).0;
        assert_near(largest_increment_of(&below), dt);
        assert_near(added_mass_of(&below), 1.25 * THIN);
        let uniform = run(&body_with(&cards("uniform", dt))).0;
        assert_near(largest_increment_of(&uniform), dt);
        assert_near(added_mass_of(&uniform), 1.25 * MASS);
        // No element is below this increment, so no mass is added; `set equal` reduces masses.
        let slow = 0.5 * plain;
        let none = run(&body_with(&cards("below min", slow))).0;
        assert_near(largest_increment_of(&none), plain);
        assert_eq!(added_mass_of(&none), 0.0);
        let equal = run(&body_with(&cards("set equal dt", slow))).0;
        assert_near(largest_increment_of(&equal), slow);
        assert!(added_mass_of(&equal) < -0.75 * THIN);
    }
}

/// EMSF of each element is its factor, in histories and frames; without mass scaling it is listed as unused.
#[test]
fn mass_factors_are_output() {
    let output = "*Output, history, frequency=1\n*Element Output, elset=THIN\n EMSF\n*Element Output, elset=WIDE\n EMSF\n\
                  *Output, field, number interval=1\n*Element Output\n EMSF\n";
    let text = body_with(&format!("*Fixed Mass Scaling, factor=4., elset=THIN\n{output}"));
    let (_, memory) = run(&text);
    for (element, factor) in [(1, 1.0), (2, 4.0), (3, 1.0), (4, 4.0)] {
        assert_eq!(last(&text, &memory, &format!("EMSF@{element}")), factor);
    }
    let frame = memory.frames.last().expect("a frame");
    let field = frame.cell_fields.iter().find(|field| field.name == "EMSF").expect("the field");
    assert_eq!(field.values, [1.0, 4.0, 1.0, 4.0]);
    let plain = job::prepare_text("deck.inp", &body_with(output), &[], &Routines::none()).plan;
    assert!(plain.ledger.unused.iter().any(|unused| unused.what == "EMSF"), "{:?}", plain.ledger.unused);
    assert!(plain.columns.is_empty() && plain.fields.is_empty());
}

/// The factor is applied before the increment; it alone exceeds the target increment of the thin elements.
#[test]
fn factor_precedes_increment_and_fixed_precedes_variable() {
    let plain = largest_increment_of(&run(&body_with("")).0);
    let dt = 1.5 * plain;
    for cards in [
        format!("*Fixed Mass Scaling, factor=4., dt={dt:e}, elset=THIN\n"),
        format!("*Fixed Mass Scaling, factor=4., elset=THIN\n*Variable Mass Scaling, dt={dt:e}, frequency=1\n"),
    ] {
        assert_near(added_mass_of(&run(&body_with(&cards)).0), 3.0 * THIN);
    }
}

/// A step without a card keeps the masses; a step with a card scales the original masses.
#[test]
fn scaled_mass_persists_until_rescaled() {
    let text = body_with("*Fixed Mass Scaling, factor=9.\n")
        + &step("")
        + &step("*Fixed Mass Scaling, factor=4., elset=THIN\n");
    let (outcome, _) = run(&text);
    let plain = largest_increment_of(&run(&body_with("")).0);
    assert_near(outcome.steps[0].largest_increment, 3.0 * plain);
    assert_near(outcome.steps[1].largest_increment, 3.0 * plain);
    // The thin elements limit again; no increment of the step is longer.
    assert_near(outcome.steps[2].largest_increment, 2.0 * plain);
    for (step, mass) in outcome.steps.iter().zip([8.0 * MASS, 8.0 * MASS, 3.0 * THIN]) {
        assert_near(step.added_mass.expect("added mass"), mass);
    }
}

/// Nodes of any mass fall alike: v = g t and u = g t^2/2 are exact for central differences with constant acceleration,
/// and gravity does work on the scaled mass.
#[test]
fn scaled_bodies_fall_with_gravity() {
    let cards = |scaling: &str| {
        format!(
            "{scaling}*Dload\n , GRAV, 9.81, 0., -1.\n*Output, history, frequency=1\n*Node Output, nset=ALL\n U2, V2\n\
             *Energy Output\n ALLKE, ALLWK\n"
        )
    };
    for scaling in ["", "*Fixed Mass Scaling, factor=5., elset=THIN\n"] {
        let text = body_with(&cards(scaling));
        let (outcome, memory) = run(&text);
        assert_eq!(outcome.halt, None);
        let row = &memory.rows.last().expect("a row").1;
        let wanted = |x: f64| ((x + 9.81 * 3.0) / 9.81).abs() < 1e-9 || ((x + 4.5 * 9.81) / 9.81).abs() < 1e-9;
        assert!(row[..18].iter().all(|x| wanted(*x)), "{row:?}");
        let mass = MASS + if scaling.is_empty() { 0.0 } else { 4.0 * THIN };
        let kinetic = 0.5 * mass * (9.81 * 3.0_f64).powi(2);
        // The kinetic energy of central differences uses v(i-1/2) v(i+1/2) instead of v^2, which is smaller by (g
        // dt/2)^2.
        assert!((last(&text, &memory, "ALLKE") / kinetic - 1.0).abs() < 1e-3);
        // The work of the initial half increment is exact; the shorter last increment contributes (dt/t)^2/4 of the
        // energy.
        assert!(outcome.energy.drift < 1e-5, "{:e}", outcome.energy.drift);
    }
}

/// Mass added at a velocity v adds m v^2/2 to ALLKE and to ALLMW, not to ALLWK, and ETOTAL is constant. DMASS is the
/// added mass in percent; more than 5 % is a warning.
#[test]
fn added_mass_appears_in_kinetic_energy_and_its_own_work() {
    let text = |scaling: &str| {
        let moves = "*Initial Conditions, type=VELOCITY\n ALL, 2, 3.\n";
        let output = "*Output, history, frequency=1\n*Energy Output\n ALLKE, ALLWK, ALLMW, ETOTAL\n*Incrementation Output\n DMASS\n";
        body_with("").replace("*Step\n", &format!("{moves}*Step\n")).replace("*End Step", &format!("{output}*End Step"))
            + &step(scaling)
    };
    let deck = text("*Fixed Mass Scaling, factor=4., elset=THIN\n");
    let (outcome, memory) = run(&deck);
    let gained = 0.5 * 3.0 * THIN * 9.0;
    assert_near(last(&deck, &memory, "ALLMW"), gained);
    assert!(last(&deck, &memory, "ALLWK").abs() < 1e-12 * gained);
    assert_near(last(&deck, &memory, "DMASS"), 100.0 * 3.0 * THIN / MASS);
    assert!(outcome.warnings.iter().any(|w| w.starts_with("R316")), "{:?}", outcome.warnings);
    let little = run(&text("*Fixed Mass Scaling, factor=1.04, elset=THIN\n")).0;
    assert!(!little.warnings.iter().any(|w| w.starts_with("R316")), "{:?}", little.warnings);
    assert_near(last(&deck, &memory, "ALLKE"), 0.5 * MASS * 9.0 + gained);
    let total = column(&deck, &memory, "ETOTAL");
    assert!(total.iter().all(|t| (t.1 / total[0].1 - 1.0).abs() < 1e-11), "{total:?}");
    assert!(outcome.energy.drift < 1e-11, "{:e}", outcome.energy.drift);
}

/// A bar compressed by a prescribed velocity, with repeated variable mass scaling at free and prescribed nodes. The
/// energy drift is as small as without scaling.
#[test]
fn energy_balance_closes_with_variable_mass() {
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

/// Rubber with scaled mass moves as rubber with that density, element type by element type: the same increments and
/// displacements to the rounding of masses.
#[test]
fn scaled_rubber_moves_as_dense_rubber() {
    let load = "*Output, history, number interval=10\n*Node Output, nset=J1\n U2\n*Boundary\n J0, 2, 2\n\
                *Boundary, type=VELOCITY\n J1, 2, 2, -0.1\n";
    for law in ["neo hooke\n 20., 0.1\n", "mooney-rivlin\n 12., 8., 0.1\n"] {
        for six in [false, true] {
            let rubber = |density: &str, cards: &str| {
                let text = body_with(&format!("{cards}{load}"))
                    .replace("*Elastic\n 1e2, 0.3\n", &format!("*Hyperelastic, {law}"))
                    .replace("*Density\n 2e0,", &format!("*Density\n {density},"));
                match six {
                    true => in_six_node_triangles(&text, [2, 2]).replace("2, 4\n", "2,\n").replace("1, 3\n", "1,\n"),
                    false => text,
                }
            };
            let [scaled, dense] = [("2.", "*Fixed Mass Scaling, factor=9.\n"), ("18.", "")].map(|(density, cards)| {
                let deck = rubber(density, cards);
                let (outcome, memory) = run(&deck);
                assert_eq!(outcome.halt, None);
                (outcome.steps[0].largest_increment, outcome.increments, last(&deck, &memory, "U2@7"))
            });
            println!("{law} {six}: {scaled:?} {dense:?}");
            assert_near(scaled.0, dense.0);
            assert_eq!(scaled.1, dense.1);
            assert_near(scaled.2, dense.2);
        }
    }
}

/// Variable mass scaling of rubber keeps the target increment while compression raises the stiffness. The last scaling
/// of a body that is compressed to a third is at most two increments old.
#[test]
fn variable_mass_scaling_follows_the_stiffness_of_rubber() {
    let rubber = |cards: &str| {
        let load = "*Boundary\n J0, 2, 2\n*Amplitude, name=A, definition=SMOOTH STEP\n 0., 0., 3., 1.\n\
                    *Boundary, amplitude=A\n J1, 2, 2, -1.3\n";
        body_with(&format!("{cards}{load}")).replace("*Elastic\n 1e2, 0.3\n", "*Hyperelastic, neo hooke\n 20., 0.1\n")
    };
    let plain = run(&rubber("")).0;
    let dt = 1.2 * largest_increment_of(&plain);
    let (scaled, _) = run(&rubber(&format!("*Variable Mass Scaling, dt={dt:.17e}, type=below min, frequency=2\n")));
    println!("{} {} dt {dt} {:?}", plain.increments, scaled.increments, scaled.steps[0]);
    assert_eq!(scaled.halt, None);
    let expected = (3.0 / dt).ceil();
    // Without scaling, the increment falls with the height of the elements.
    assert!(plain.increments as f64 > 1.5 * expected, "{} {expected}", plain.increments);
    assert!((scaled.increments as f64 / expected - 1.0).abs() < 0.02, "{} {expected}", scaled.increments);
}

#[test]
fn invalid_mass_scaling_is_an_error() {
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
        fails(&body_with(cards), code);
    }
    let explosive = body_with("*Fixed Mass Scaling, factor=2.\n").replace(
        "*Elastic\n 1e2, 0.3\n",
        "*Eos, type=JWL\n 6930., 3.712E11, 3.231E9, 0.3, 4.15, 0.95, 4.29E6, 9.e9\n*Detonation Point\n 0., 0.\n",
    );
    fails(&explosive, "P022");
    fails(&("*Fixed Mass Scaling, factor=2.\n".to_owned() + &body_with("")), "M105");
}

/// The mass of deleted elements is that without scaling: the ring of one element, pi r² h rho, to rounding. A part has it, too.
#[test]
fn eroded_mass_contains_no_scaled_mass() {
    let text = grid(1, 3, false, |i, j| [i as f64, j as f64])
        + &material(100.0, 0.3, 2.0, "")
        + "*Elset, elset=MIDDLE\n 2,\n*Nset, nset=PULLED, generate\n 7, 8, 1\n*Nset, nset=HELD, generate\n 1, 2, 1\n\
           *Erosion, elset=MIDDLE, principal strain=0.05\n*Step\n*Dynamic, Explicit\n , 3.\n\
           *Fixed Mass Scaling, factor=9.\n*Boundary\n HELD, 2, 2\n*Boundary, type=VELOCITY\n PULLED, 2, 2, 0.1\n\
           *Output, history, number interval=10\n*Energy Output\n EROMASS\n*Energy Output, elset=SOLID\n PARTERO\n\
           *End Step\n";
    let (outcome, memory) = run(&text);
    assert_eq!(outcome.deleted, 1);
    for name in ["EROMASS", "PARTERO@SOLID"] {
        let mass = last(&text, &memory, name);
        assert!((mass / (2.0 * PI) - 1.0).abs() < 1e-12, "{name} {mass}");
    }
}

/// Scaled masses do not change the density of an equation of state: elements that are compressed by 5 % in a smooth step have
/// the pressure without scaling, to 1e-5 (increments are up to three times as long), and that of the isentrope, `rho0 c0² eta / (1 - s eta)²` within the thermal part of
/// third order, 1e-3. The increments are longer by the root of the factor. A target is reached to 6 % (-4.7 %): the rate from which
/// the factor follows has no viscosity of hourglass patterns.
#[test]
fn equations_of_state_have_the_density_without_scaling() {
    let deck = |cards: &str| {
        grid(2, 2, false, |i, j| [0.5 * i as f64, 0.5 * j as f64])
            + "*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n 8.93e-9,\n*EOS, type=USUP\n 3.94e6, 1.489, \
               0.5\n*Elastic, type=SHEAR\n 1.,\n*Amplitude, name=A, definition=SMOOTH STEP\n 0., 0., 2e-4, 1.\n*Step\n*Dynamic, \
               Explicit, element by element\n , 2e-4\n"
            + cards
            + "*Boundary\n ALL, 1, 1\n J0, 2, 2\n*Boundary, amplitude=A\n J1, 2, 2, -0.05\n*Output, history, number \
               interval=10\n*Element Output, elset=SOLID\n S22\n*End Step\n"
    };
    let pressure = |cards: &str| {
        let text = deck(cards);
        let (outcome, memory) = run(&text);
        assert_eq!(outcome.halt, None);
        (-last(&text, &memory, "S22@1"), largest_increment_of(&outcome))
    };
    let (plain, increment) = pressure("");
    let eta = 0.05;
    let isentrope = 8.93e-9 * 3.94e6 * 3.94e6 * eta / f64::powi(1.0 - 1.489 * eta, 2);
    assert!((plain / isentrope - 1.0).abs() < 1e-3, "{plain} {isentrope}");
    let dt = 2.0 * increment;
    for (cards, [ratio, tolerance]) in [
        ("*Fixed Mass Scaling, factor=9.\n".to_string(), [3.0, 1e-9]),
        (format!("*Fixed Mass Scaling, type=UNIFORM, dt={dt:e}\n"), [2.0, 0.06]),
        (format!("*Variable Mass Scaling, type=UNIFORM, dt={dt:e}, frequency=10\n"), [2.0, 0.06]),
    ] {
        let (scaled, longer) = pressure(&cards);
        let (apart, reached) = (scaled / plain - 1.0, longer / increment / ratio - 1.0);
        println!("{cards}: pressure {apart:.1e} apart, increment {reached:.1e} from the expected one");
        assert!(apart.abs() < 1e-5 && reached.abs() < tolerance, "{apart:e} {reached:e}");
    }
}
