//! What conditions mean over several steps: kind of card x (same step, next step MOD, next step NEW, amplitude ends).
//!
//! Goal: each entry of the table of ABAQUS's rules, seen on a run's result.
//! Source: kinematics and impulse in closed form (u = v t, m v = F t, ...); rules from the ABAQUS Analysis User's Guide 34.1.2
//! "Amplitude curves" (continuation in subsequent steps), 34.3.1 "Boundary conditions", 34.4.1 "Applying loads", 4.1.3 "Output to
//! the output database", and the Keywords Reference Guide, *BOUNDARY, *CLOAD, *CONTACT PAIR, *OUTPUT, *STEP, *AMPLITUDE. That
//! loads of one step add, the manual leaves open: CalculiX's manual says it of the same card (*CLOAD).
//! Tolerance: 1e-5 of the value; central differences over 1000 increments a step are of second order.

use std::f64::consts::PI;

use crate::common;
use crate::common::solid;
use revolve::job;
use revolve::user::Routines;

/// Length of each of two steps.
const T: f64 = 0.1;
/// Mass of the rigid disc of radius 1.
const M: f64 = 2.0;

const AMPLITUDES: &str = "*Amplitude, name=UP\n 0., 0., 0.1, 1.\n*Amplitude, name=SMOOTH, definition=SMOOTH STEP\n 0., 0., 0.1, 1.\n\
    *Amplitude, name=DOWN, definition=SMOOTH STEP\n 0., 1., 0.1, 0.\n*Amplitude, name=HIGH\n 0., 1., 0.1, 2.\n\
    *Amplitude, name=TOTAL, time=TOTAL TIME\n 0., 0., 0.2, 1.\n*Amplitude, name=ABS, value=ABSOLUTE\n 0., 2., 0.1, 2.\n";

/// A rigid disc with face FACE, elements DISC, reference node 3 in set REF.
const DISC: &str = "*Node\n 1, 0., 0.\n 2, 1., 0.\n 3, 0., 0.\n*Nset, nset=REF\n 3\n*Element, type=RAX2, elset=DISC\n 1, 1, 2\n\
    *Surface, name=FACE\n DISC, SPOS\n*Rigid Body, ref node=3, elset=DISC\n*Element, type=MASS, elset=M\n 2, 3\n*Mass, elset=M\n 2.\n";

/// Nodes of what deforms move along z as the cards of REF say; nothing strains it.
fn block() -> String {
    solid::grid(1, 1, false, |i, j| [i as f64, j as f64])
        + &solid::material(1e3, 0.3, 1.0, "")
        + "*Nset, nset=REF\n ALL\n"
}

fn step(header: &str, cards: &str, output: &str) -> String {
    format!("*Step{header}\n*Dynamic, explicit, direct user control\n 1.e-4, {T}\n{cards}{output}*End step\n")
}

fn deck(model: &str, steps: [(&str, &str); 2]) -> String {
    let output = "*Output, history, frequency=1\n*Node output, nset=REF\n U2, V2\n";
    let [first, second] = steps;
    format!("{model}{AMPLITUDES}{}{}", step(first.0, first.1, output), step(second.0, second.1, ""))
}

fn last(text: &str, name: &str) -> f64 {
    let (outcome, memory) = common::run(text, &[], &Routines::none());
    assert!(outcome.halt.is_none(), "{:?}\n{text}", outcome.halt);
    solid::last(text, &memory, name)
}

fn codes(text: &str) -> Vec<&'static str> {
    job::prepare_text("case.inp", text, &[], &Routines::none()).diagnostics.iter().map(|d| d.code).collect()
}

#[track_caller]
fn close(what: &str, found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-5 * expected.abs() + 1e-9, "{what}: {found} and not {expected}");
}

/// A card that pushes the disc along z with a force, with parameters on its keyword line.
type Push = fn(&str, Option<f64>) -> String;

/// Loads: 34.4.1 and 34.1.2. The velocity at the end is the impulse over the mass.
#[test]
fn loads_over_steps() {
    let pushes: [(&str, Push); 4] = [
        ("CLOAD", |p, f| f.map_or(format!("*Cload{p}\n"), |f| format!("*Cload{p}\n REF, 2, {f}\n"))),
        ("DLOAD", |p, f| f.map_or(format!("*Dload{p}\n"), |f| format!("*Dload{p}\n DISC, P, {}\n", -f / PI))),
        ("DSLOAD", |p, f| f.map_or(format!("*Dsload{p}\n"), |f| format!("*Dsload{p}\n FACE, P, {}\n", -f / PI))),
        ("GRAV", |p, f| f.map_or(format!("*Dload{p}\n"), |f| format!("*Dload{p}\n , GRAV, {}, 0., 1.\n", f / M))),
    ];
    for (name, push) in pushes {
        let of = |f| push("", Some(f));
        let table: [(&str, String, String, f64); 7] = [
            ("goes on", of(4.0), String::new(), 8.0),
            ("same step: adds", of(4.0) + &of(2.0), String::new(), 12.0),
            ("next step MOD: takes its place", of(4.0), of(1.0), 5.0),
            ("next step NEW: ends", of(4.0), push(", op=NEW", None), 4.0),
            ("next step NEW with another", of(4.0), push(", op=NEW", Some(1.0)), 5.0),
            ("amplitude in step time ends: stays", push(", amplitude=UP", Some(4.0)), String::new(), 6.0),
            ("amplitude in total time goes on", push(", amplitude=TOTAL", Some(4.0)), String::new(), 4.0),
        ];
        for (case, first, second, impulse) in table {
            let text = deck(DISC, [("", &first), ("", &second)]);
            close(&format!("{name}, {case}"), last(&text, "V2@REF"), impulse * T / M);
            assert_eq!(codes(&text).contains(&"M144"), case.starts_with("same step"), "{name}, {case}");
        }
    }
}

/// 34.4.1: a later step replaces the load of those nodes alone that it names.
#[test]
fn a_later_load_takes_the_place_of_an_earlier_one_node_by_node() {
    let model = block();
    let free = "*Cload\n ALL, 2, 1.\n";
    let of = |second: &str| {
        let text = deck(&model, [("", free), ("", second)]);
        (last(&text, "V2@1"), last(&text, "V2@2"), last(&text, "V2@3"), last(&text, "V2@4"))
    };
    // The impulse of all forces is the momentum.
    let momentum = |v: (f64, f64, f64, f64)| {
        // Lumped masses of a cylinder of density 1, height 1 and radius 1: row sums, 2 pi/12 at the axis, 2 pi/6 at r = 1.
        let (inner, outer) = (2.0 * PI / 12.0, 2.0 * PI / 6.0);
        inner * (v.0 + v.2) + outer * (v.1 + v.3)
    };
    for (case, second, impulse, jump) in [
        ("all go on", "", 8.0, 0.0),
        ("node 2 gets another", "*Cload\n 2, 2, 5.\n", 4.0 + 8.0, 4.0),
        ("node 2 with OP=NEW", "*Cload, op=NEW\n 2, 2, 5.\n", 4.0 + 5.0, 1.0),
    ] {
        // Nodes go on from step to step, so that a jump of the force acts half an increment, 5e-5, too early.
        let error = (momentum(of(second)) - impulse * T).abs();
        assert!(error <= jump * 0.5e-4 + 1e-5 * impulse * T, "{case}: {error}");
    }
}

/// Boundaries: 34.3.1 and 34.1.2, on a rigid body and on what deforms. The displacement at the end.
#[test]
fn boundaries_over_steps() {
    let velocity = |p: &str, v: f64| format!("*Boundary, type=VELOCITY{p}\n REF, 2, 2, {v}\n");
    let push = |p: &str, a: f64| format!("*Boundary, type=ACCELERATION{p}\n REF, 2, 2, {a}\n");
    let place = |p: &str, u: f64| format!("*Boundary{p}\n REF, 2, 2, {u}\n");
    let none = String::new;
    let new = || "*Boundary, op=NEW\n".to_owned();
    let table: [(&str, String, String, f64); 19] = [
        ("velocity goes on", velocity("", 1.0), none(), 0.2),
        (
            "velocity, same step: the later acts",
            velocity("", 1.0) + "*Boundary, type=VELOCITY\n NODES, 2, 2, 3.\n",
            none(),
            0.6,
        ),
        ("velocity, MOD", velocity("", 1.0), velocity("", 2.0), 0.3),
        ("velocity, MOD by another set", velocity("", 1.0), "*Boundary, type=VELOCITY\n NODES, 2, 2, 2.\n".into(), 0.3),
        ("velocity, NEW: free flight", velocity("", 1.0), new(), 0.2),
        ("velocity, amplitude ends", velocity(", amplitude=UP", 1.0), none(), 0.15),
        ("velocity, total time", velocity(", amplitude=TOTAL", 1.0), none(), 0.1),
        (
            "held, then a velocity on the same nodes by another set",
            place("", 0.0),
            "*Boundary, type=VELOCITY\n NODES, 2, 2, 1.\n".into(),
            0.1,
        ),
        ("displacement stays", place(", amplitude=SMOOTH", 0.3), none(), 0.3),
        (
            "displacement, same step: the later acts",
            place(", amplitude=SMOOTH", 0.3) + "*Boundary, amplitude=SMOOTH\n NODES, 2, 2, 0.4\n",
            none(),
            0.4,
        ),
        ("displacement, MOD back", place(", amplitude=SMOOTH", 0.3), place(", amplitude=DOWN", 0.3), 0.0),
        (
            "displacement, MOD with a jump that is ignored",
            place(", amplitude=SMOOTH", 0.3),
            place(", amplitude=SMOOTH", 0.1),
            0.4,
        ),
        ("displacement, NEW: at rest", place(", amplitude=SMOOTH", 0.3), new(), 0.3),
        ("displacement, total time", place(", amplitude=TOTAL", 0.3), none(), 0.3),
        ("displacement that begins with a jump", place(", amplitude=HIGH", 0.3), none(), 0.3),
        ("acceleration goes on", push("", 2.0), none(), 0.04),
        ("acceleration, MOD", push("", 2.0), push("", -2.0), 0.02),
        ("acceleration, NEW", push("", 2.0), new(), 0.03),
        ("acceleration, amplitude ends", push(", amplitude=UP", 2.0), none(), 2.0 * T * T / 6.0 + 0.1 * T + T * T),
    ];
    for (model, name, node) in [
        (DISC.to_owned() + "*Nset, nset=NODES\n REF\n", "rigid", "REF"),
        (block() + "*Nset, nset=NODES\n 1, 2, 3, 4\n", "deformable", "4"),
    ] {
        for (case, first, second, displacement) in &table {
            let text = deck(&model, [("", first), ("", second)]);
            let found = last(&text, &format!("U2@{node}"));
            // Where nodes go on from step to step, a jump of the acceleration is met half an increment late.
            let late = if case.starts_with("acceleration") { 4.0 * 0.5e-4 * T } else { 0.0 };
            let error = (found - displacement).abs();
            assert!(error <= 1e-5 * displacement.abs() + late + 1e-9, "{name}, {case}: {found} and not {displacement}");
            let found = codes(&text);
            assert_eq!(found.contains(&"M145"), case.contains("same step"), "{name}, {case}: {found:?}");
            assert_eq!(found.contains(&"M146"), case.contains("jump"), "{name}, {case}: {found:?}");
        }
    }
}

/// No velocity of a thrown node: a displacement from 1 to 0 moves back as smoothly as it came (34.3.1: no jumps).
#[test]
fn a_displacement_goes_back_without_a_throw() {
    let text = deck(
        DISC,
        [("", "*Boundary, amplitude=SMOOTH\n REF, 2, 2, 0.3\n"), ("", "*Boundary, amplitude=DOWN\n REF, 2, 2, 0.3\n")],
    );
    let (_, memory) = common::run(&text, &[], &Routines::none());
    let speeds = solid::column(&text, &memory, "V2@REF");
    let fastest = speeds.iter().fold(0.0, |m: f64, v| m.max(v.1.abs()));
    // The steepest of 10 x^3 - 15 x^4 + 6 x^5 is 15/8.
    close("largest speed", fastest, 0.3 / T * 15.0 / 8.0);
}

/// *STEP, AMPLITUDE (Keywords Reference Guide): loads and motions without amplitude grow from what they were.
#[test]
fn conditions_of_a_ramped_step_grow() {
    let ramp = ", amplitude=RAMP";
    for (case, first, second, impulse) in [
        ("from zero, then it stays", (ramp, "*Cload\n REF, 2, 4.\n"), ("", ""), 2.0 + 4.0),
        ("from what it was", (ramp, "*Cload\n REF, 2, 4.\n"), (ramp, "*Cload\n REF, 2, 1.\n"), 2.0 + 2.5),
        ("down to zero", ("", "*Cload\n REF, 2, 4.\n"), (ramp, "*Cload\n REF, 2, 0.\n"), 4.0 + 2.0),
        ("its own amplitude first", (ramp, "*Cload, amplitude=ABS\n REF, 2, 4.\n"), ("", ""), 2.0 + 2.0),
        ("AMPLITUDE=STEP", (", amplitude=STEP", "*Cload\n REF, 2, 4.\n"), ("", ""), 4.0 + 4.0),
    ] {
        close(case, last(&deck(DISC, [first, second]), "V2@REF"), impulse * T / M);
    }
    for (case, first, second, displacement) in [
        ("velocity", (ramp, "*Boundary, type=VELOCITY\n REF, 2, 2, 1.\n"), ("", ""), 0.05 + 0.1),
        ("displacement", (ramp, "*Boundary\n REF, 2, 2, 0.3\n"), (ramp, "*Boundary\n REF, 2, 2, 0.1\n"), 0.1),
    ] {
        let text = deck(DISC, [first, second]);
        close(case, last(&text, "U2@REF"), displacement);
        assert!(codes(&text).is_empty(), "{:?}", codes(&text));
    }
}

/// *AMPLITUDE, VALUE=ABSOLUTE: values on the data lines of loads and motions are ignored.
#[test]
fn absolute_amplitudes_are_magnitudes() {
    let text = deck(DISC, [("", "*Cload, amplitude=ABS\n REF, 2, 5.\n"), ("", "")]);
    close("force", last(&text, "V2@REF"), 2.0 * 2.0 * T / M);
    let text = deck(DISC, [("", "*Boundary, type=VELOCITY, amplitude=ABS\n REF, 2, 2, 5.\n"), ("", "")]);
    close("velocity", last(&text, "U2@REF"), 2.0 * 2.0 * T);
}

/// What would change the meaning of a deck without a word is refused.
#[test]
fn what_is_not_done_is_refused() {
    for (first, second, code) in [
        ((", nlgeom=NO", ""), ("", ""), "M104"),
        ((", nlgeom=MAYBE", ""), ("", ""), "M103"),
        ((", amplitude=SLOW", ""), ("", ""), "M103"),
        (("", "*Boundary\n REF, 1, 1\n"), ("", "*Boundary, op=NEW\n REF, 1, 1\n*Boundary\n REF, 6, 6\n"), "M103"),
        (("", "*Cload, op=OLD\n REF, 2, 1.\n"), ("", ""), "M103"),
        (("", "*Dynamic, explicit\n , 1.\n"), ("", ""), "M105"),
    ] {
        let text = deck(DISC, [first, second]);
        assert!(codes(&text).contains(&code), "{first:?} {second:?}: {:?}", codes(&text));
    }
}

/// *CONTACT PAIR, OP=ADD and DELETE: a block falls past a plane from which it was released. u = v t.
#[test]
fn contact_pairs_over_steps() {
    let model = solid::grid(1, 1, false, |i, j| [i as f64, j as f64 + 0.15])
        + &solid::material(1e5, 0.0, 1.0, "")
        + "*Node\n 99, 0., 0.\n*Nset, nset=REF\n 1\n*Surface, type=SEGMENTS, name=PLANE\n START, 2., 0.\n LINE, 0., 0.\n\
           *Rigid Body, ref node=99, analytical surface=PLANE\n*Surface, type=NODE, name=LOW\n J0\n\
           *Initial conditions, type=VELOCITY\n ALL, 2, -1.\n*Surface interaction, name=SMOOTH\n";
    let held = "*Boundary\n 99, 1, 6\n*Contact pair, interaction=SMOOTH\n LOW, PLANE\n";
    let of = |second: &str| last(&deck(&model, [("", held), ("", second)]), "U2@REF");
    close("released", of("*Contact pair, interaction=SMOOTH, op=DELETE\n LOW, PLANE\n"), -2.0 * T);
    let kept = of("");
    assert!(kept >= -0.15 - 1e-9, "{kept}");
    assert_eq!(of("*Contact pair, interaction=SMOOTH\n LOW, PLANE\n").to_bits(), kept.to_bits(), "given again");
    let text = deck(
        &model,
        [("", "*Boundary\n 99, 1, 6\n"), ("", "*Contact pair, interaction=SMOOTH, op=DELETE\n LOW, PLANE\n")],
    );
    assert!(codes(&text).contains(&"M114"));
}

/// *OUTPUT, OP=NEW (default), ADD, REPLACE: rows of a history and frames by step.
#[test]
fn output_over_steps() {
    let first = "*Output, field, number interval=2\n*Node output\n U\n*Output, history, frequency=500\n*Node output, nset=REF\n U2\n";
    let count = |second: &str| {
        let text = format!("{DISC}{AMPLITUDES}{}{}", step("", "*Cload\n REF, 2, 4.\n", first), step("", "", second));
        let (_, memory) = common::run(&text, &[], &Routines::none());
        let after = |t: &f64| *t > T * (1.0 + 1e-9);
        let rows = memory.rows.iter().filter(|r| after(&r.0)).count();
        let frames = memory.frames.iter().filter(|f| after(&f.time)).count();
        (rows, frames, codes(&text).contains(&"M148"))
    };
    assert_eq!(count(""), (2, 2, false), "requests go on");
    assert_eq!(
        count("*Output, field, number interval=4\n*Node output\n U\n"),
        (0, 4, true),
        "NEW ends histories as well"
    );
    assert_eq!(count("*Output, field, number interval=4, op=ADD\n*Node output\n V\n"), (2, 4, false), "ADD");
    assert_eq!(
        count("*Output, history, frequency=500, op=REPLACE\n*Node output, nset=REF\n V2\n"),
        (2, 2, false),
        "REPLACE"
    );
}

/// Degrees of freedom (Analysis User's Guide 1.2.2, 34.3.1): what a line cannot hold, move or load is said.
#[test]
fn degrees_of_freedom_that_nodes_do_not_have_are_told() {
    let found = |model: &str, cards: &str| {
        let text = deck(model, [("", cards), ("", "")]);
        let prepared = job::prepare_text("case.inp", &text, &[], &Routines::none());
        (prepared.diagnostics.iter().map(|d| d.code).collect::<Vec<_>>(), prepared.diagnostics.has_errors())
    };
    let model = block();
    for (cards, code, refused) in [
        ("*Boundary\n J0, 3, 3\n", Some("M149"), false),
        ("*Boundary\n J0, ZSYMM\n", Some("M149"), false),
        ("*Boundary\n J0, 6, 6\n", Some("M149"), false),
        ("*Boundary, type=VELOCITY\n J0, 3, 3, 1.\n", Some("M149"), true),
        ("*Boundary\n J0, YASYMM\n", Some("M104"), true),
        ("*Cload\n J0, 4, 1.\n", Some("M149"), true),
        ("*Boundary\n J0, YSYMM\n", None, false),
        ("*Boundary\n J0, ENCASTRE\n", None, false),
        ("*Boundary\n J0, 2, 3\n", None, false),
        ("*Dload\n SOLID, GRAV, 9.81, 1., 1.\n", Some("M152"), false),
    ] {
        assert_eq!(found(&model, cards), (code.into_iter().collect(), refused), "{cards}");
    }
    let moving = model.clone() + "*Initial conditions, type=VELOCITY\n ALL, 3, -1.\n";
    assert_eq!(found(&moving, ""), (vec!["M149"], true));
    assert_eq!(found(DISC, "*Boundary\n REF, 1, 1\n REF, 6, 6\n").0, Vec::<&str>::new(), "a reference node turns");
    assert_eq!(found(DISC, "*Dload\n , GRAV, 9.81, 1., 0.\n").0, vec!["M152"]);
}

/// The fourth field of *DYNAMIC, EXPLICIT (Keywords Reference Guide): the largest increment.
#[test]
fn the_largest_increment_is_kept() {
    let model = block();
    let run = |fields: &str| {
        let text = format!(
            "{model}*Initial conditions, type=VELOCITY\n ALL, 2, 1.\n*Step\n*Dynamic, explicit\n {fields}\n*End step\n"
        );
        common::run(&text, &[], &Routines::none()).0.steps[0].largest_increment
    };
    let free = run(", 0.1");
    assert!(free > 2e-4, "{free}");
    assert!((run(", 0.1, , 1.e-4") - 1e-4).abs() < 1e-6, "the last may be longer by a thousandth");
    assert_eq!(run(", 0.1, , 1.").to_bits(), free.to_bits());
    for (fields, code) in [("1.e-5, 0.1", "M104"), (", 0.1, 2.", "M104"), (", 0.1, , -1.", "M103")] {
        let text = format!("{model}*Step\n*Dynamic, explicit\n {fields}\n*End step\n");
        assert!(codes(&text).contains(&code), "{fields}");
    }
}

/// *FIXED MASS SCALING (Analysis User's Guide 11.6.1): stays in steps that do not scale, and is replaced where one does.
#[test]
fn mass_scaling_over_steps() {
    let model = block();
    let push = "*Cload\n ALL, 2, 1.\n";
    let mean = |second: &str| {
        let text = deck(&model, [("", &format!("{push}*Fixed mass scaling, factor=2.\n")), ("", second)]);
        let v = ["V2@1", "V2@2", "V2@3", "V2@4"].map(|name| last(&text, name));
        (v[0] + v[2] + 2.0 * (v[1] + v[3])) / 6.0
    };
    // Four forces of 1 on a cylinder of mass pi times the factor.
    let speed = |factor: f64| 4.0 * T / (PI * factor);
    close("stays", mean(""), 2.0 * speed(2.0));
    let found = mean("*Fixed mass scaling, factor=4.\n");
    let late = (speed(2.0) - speed(4.0)) / T * 0.5e-4;
    assert!((found - speed(2.0) - speed(4.0)).abs() <= late + 1e-6, "replaced: {found}");
}

/// Only what holds can be said before the first step (Analysis User's Guide 34.3.1, "as model data").
#[test]
fn boundaries_before_the_first_step_hold() {
    let refused = DISC.to_owned() + "*Boundary, type=VELOCITY\n REF, 2, 2, 1.\n";
    assert!(codes(&deck(&refused, [("", ""), ("", "")])).contains(&"M105"));
    let held = DISC.to_owned() + "*Boundary\n REF, 2, 2\n";
    let push = "*Cload\n REF, 2, 4.\n";
    close("held", 1.0 + last(&deck(&held, [("", push), ("", "")]), "U2@REF"), 1.0);
    close("released", last(&deck(&held, [("", push), ("", "*Boundary, op=NEW\n")]), "V2@REF"), 4.0 * T / M);
    let moved = deck(&held, [("", ""), ("", "*Boundary, type=VELOCITY\n REF, 2, 2, 1.\n")]);
    close("moved later", last(&moved, "U2@REF"), T);
}
