//! Small solid models: patch tests, hourglass modes, errors, halted runs.
//!
//! Goal: stress and motion of few elements, equilibrium of patches.
//! Source: closed forms of elasticity. The tolerance and its reason are stated at each test.

use std::fmt::Write as _;

use revolve::job;
use revolve::solve;
use revolve::user::Routines;

use crate::common;
use crate::common::RecordedOutput;
use crate::common::solid::{column, grid, last, material, run};

/// Returns a node of a distorted patch that touches the axis.
fn distorted_node(i: usize, j: usize) -> [f64; 2] {
    let shift = |a: usize, b: usize| if (1..3).contains(&a) && (1..3).contains(&b) { 0.2 } else { 0.0 };
    let sign = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
    [i as f64 + shift(i, j) * sign(i + j), 0.7 * j as f64 + shift(i, j) * sign(i)]
}

#[test]
fn distorted_patch_under_pressure_is_in_equilibrium() {
    let pressure = |surfaces: &[&str]| surfaces.iter().map(|s| format!(" {s}, P, 3.\n")).collect::<String>();
    let deck = grid(3, 3, false, distorted_node)
        + &material(1000.0, 0.3, 1.0, "")
        + "*Initial Conditions, type=STRESS\n SOLID, -3., -3., -3., 0.\n*Step\n*Dynamic, Explicit\n , 1.\n*Dsload\n"
        + &pressure(&["I1", "J0", "J1"])
        + "*Output, field, number interval=1\n*Node Output\n A\n*Element Output\n S\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert!(outcome.halt.is_none() && outcome.increments > 30, "{:?}", outcome.halt);
    for frame in &memory.frames {
        let acceleration = &frame.point_fields[0].values;
        // Rounding of a force of 3 on a mass of order 1.
        assert!(acceleration.iter().all(|a| a.abs() < 1e-12), "{acceleration:?}");
    }
    let stress = &memory.frames.last().expect("a frame").cell_fields.iter().find(|f| f.name == "S").expect("S").values;
    for s in stress.chunks(4) {
        assert!(s[..3].iter().all(|x| (x + 3.0).abs() < 1e-12) && s[3].abs() < 1e-12, "{s:?}");
    }
}

/// Linear velocity fields give uniform strain rates in quadrilaterals and triangles: v_r = a r, v_z = b z.
#[test]
fn distorted_patch_has_uniform_strain() {
    for triangles in [false, true] {
        let mut deck = grid(3, 3, triangles, distorted_node) + &material(1000.0, 0.25, 1.0, "");
        deck += "*Initial Conditions, type=VELOCITY\n";
        for n in 0..16 {
            let [r, z] = distorted_node(n % 4, n / 4);
            write!(deck, " {}, 1, {:e}\n {}, 2, {:e}\n", n + 1, 1e-3 * r, n + 1, 2e-3 * z).expect("text");
        }
        deck += "*Step\n*Dynamic, Explicit, direct user control\n 1.e-4, 1.e-4\n*Bulk Viscosity\n 0., 0.\n\
                 *Output, field, number interval=1\n*Element Output\n S\n*End Step\n";
        let (outcome, memory) = run(&deck);
        assert!(outcome.halt.is_none());
        let stress = &memory.frames.last().expect("a frame").cell_fields[0].values;
        // lambda = 400, mu = 400: strains 1e-7 in r and hoop, 2e-7 in z, with rates at the middle of the increment.
        let (lambda, mu) = (400.0, 400.0);
        let trace = 4e-7;
        for s in stress.chunks(4) {
            for (got, strain) in s[..3].iter().zip([1e-7, 2e-7, 1e-7]) {
                let expected = lambda * trace + 2.0 * mu * strain;
                assert!((got / expected - 1.0).abs() < 1e-6, "{got} {expected}");
            }
            assert!(s[3].abs() < 1e-13, "{s:?}");
        }
    }
}

/// A prescribed displacement counts from the start of its step: the next step can hold the position or continue from
/// it.
#[test]
fn displacement_counts_from_the_start_of_its_step() {
    let step = |cards: &str| {
        format!(
            "*Step\n*Dynamic, Explicit, element by element\n , 1.\n*Boundary, {cards}\n*Output, history, frequency=1\n\
             *Node Output, nset=ONE\n U2\n*End Step\n"
        )
    };
    let deck = grid(2, 2, false, |i, j| [i as f64, j as f64])
        + &material(
            100.0,
            0.3,
            1.0,
            "*Nset, nset=ONE\n 2\n*Amplitude, name=RAMP, definition=SMOOTH STEP\n 0., 0., 1., 1.\n",
        )
        + &step("amplitude=RAMP\n J0, 2, 2, 0.5")
        + &step("op=NEW\n J0, 2, 2")
        + &step("op=NEW, amplitude=RAMP\n J0, 2, 2, 0.25");
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    let u = column(&deck, &memory, "U2@ONE");
    for (time, expected) in [(1.0, 0.5), (1.5, 0.5), (2.0, 0.5), (3.0, 0.75)] {
        let at = u.iter().rfind(|row| row.0 <= time + 1e-12).expect("a row").1;
        assert!((at - expected).abs() < 1e-12, "U2 = {at} at {time}, expected {expected}");
    }
    let energy = outcome.energy;
    // Four elements under ramps of some ten increments: the energy error is of second order.
    assert!(energy.drift < 2e-2, "drift {:e}", energy.drift);
}

/// A fixed increment inverts the element; automatic increments decrease until the element inverts or the increment is
/// too small.
#[test]
fn inverted_element_stops_the_run_and_is_named() {
    for (card, codes) in [("\n , 1.", &["R209", "R206"][..]), (", direct user control\n 1.e-3, 1.", &["R206"])] {
        let deck = grid(3, 3, false, |i, j| [1.0 + i as f64, j as f64])
            + &material(1000.0, 0.3, 1.0, "*Plastic\n 1., 0.\n")
            + &format!("*Initial Conditions, type=VELOCITY\n 6, 1, 4000.\n*Step\n*Dynamic, Explicit{card}\n")
            + "*Output, field, number interval=100\n*Node Output\n U\n*End Step\n";
        let (outcome, memory) = run(&deck);
        let halt = outcome.halt.expect("a halt");
        assert!(codes.contains(&halt.code()), "{}", halt.code());
        for part in ["element ", "increment", "time"] {
            assert!(halt.message().contains(part), "{}", halt.message());
        }
        // The node velocity is the cause, not the increment.
        assert!(!halt.message().contains("times the stable time increment"), "{}", halt.message());
        let frame = memory.frames.last().expect("a frame");
        assert!(frame.point_fields.iter().all(|f| f.values.iter().all(|v| v.is_finite())));
    }
}

#[test]
fn invalid_solids_are_errors() {
    let good = grid(1, 1, false, |i, j| [i as f64, j as f64])
        + &material(1000.0, 0.3, 1.0, "")
        + "*Step\n*Dynamic, Explicit\n , 1.\n*End Step\n";
    let cases = [
        ("M123", good.replace(" 1, 1, 2, 4, 3\n", " 1, 1, 3, 4, 2\n")),
        ("P013", good.replace("*Density\n 1e0,\n", "")),
        ("P001", good.replace("*Solid Section, elset=SOLID, material=M\n", "")),
        ("M103", good.replace("*Step", "*Plastic\n 1., 0.\n 2., 0.\n*Step")),
    ];
    let two = good.replace("*End Step\n", "*End Step\n*Step\n*Dynamic, Explicit, adiabatic\n , 1.\n*End Step\n");
    for (code, text) in cases.into_iter().chain([("P015", two)]) {
        assert_ne!(text, good, "{code}");
        let prepared = job::prepare_text("bad.inp", &text, &[], &Routines::none());
        assert!(
            prepared.diagnostics.iter().any(|d| d.code == code),
            "{code}: {}",
            prepared.diagnostics.render(&prepared.deck.sources)
        );
    }
}

/// Hourglass controls limit the motion of a bar excited in its hourglass mode.
#[test]
fn every_hourglass_control_limits_the_hourglass_mode() {
    for control in ["STIFFNESS", "VISCOUS", "COMBINED", "ENHANCED"] {
        let mut deck = grid(4, 8, false, |i, j| [10.0 + i as f64, j as f64]) + &material(1000.0, 0.3, 1.0, "");
        deck = deck.replace("material=M\n", "material=M, controls=C\n");
        deck += &format!("*Section Controls, name=C, hourglass={control}\n");
        deck += "*Initial Conditions, type=VELOCITY\n";
        for n in 0..45 {
            let sign = if (n % 5 + n / 5) % 2 == 0 { 1.0 } else { -1.0 };
            writeln!(deck, " {}, 2, {}", n + 1, 0.01 * sign).expect("text");
        }
        deck += "*Step\n*Dynamic, Explicit\n , 20.\n*Output, history, number interval=100\n*Node Output, nset=ALL\n U2\n*Energy Output\n ALLAE\n*End Step\n";
        let prepared = common::prepared(&deck, &[], &Routines::none());
        let mut memory = RecordedOutput::default();
        let (outcome, _) = solve::run(&prepared.plan, prepared.state, &mut memory);
        assert!(outcome.halt.is_none(), "{control}: {:?}", outcome.halt);
        let largest = memory.rows.iter().flat_map(|r| r.1.iter().take(45)).fold(0.0f64, |m, u| m.max(u.abs()));
        // Without control the displacement would reach v t = 0.2.
        assert!(largest < 0.05, "{control}: {largest}");
        assert!(outcome.energy.artificial > 0.0, "{control}");
    }
}

/// Gravity on an element set acts on triangles.
#[test]
fn gravity_acts_on_a_set_of_triangles() {
    let fall = |elements: &str| {
        let deck = grid(2, 2, true, |i, j| [i as f64, j as f64])
            + &material(100.0, 0.3, 1.0, "*Nset, nset=ONE\n 5\n")
            + &format!("*Step\n*Dynamic, Explicit\n , 1.\n*Dload\n {elements}, GRAV, 9.81, 0., -1.\n")
            + "*Output, history, frequency=1\n*Node Output, nset=ONE\n V2\n*End Step\n";
        let (outcome, memory) = run(&deck);
        assert_eq!(outcome.halt, None);
        last(&deck, &memory, "V2@ONE")
    };
    assert!((fall("SOLID") / -9.81 - 1.0).abs() < 1e-12);
    assert_eq!(fall("SOLID").to_bits(), fall("").to_bits());
}
