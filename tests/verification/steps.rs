//! Loads, boundary conditions and output over several steps: kind of card x (same step, next step MOD, next step NEW,
//! end of amplitude).
//!
//! Goal: each entry of the table of ABAQUS rules, verified by the result of a run.
//! Source: kinematics and impulse in closed form (u = v t, m v = F t, ...); rules of the ABAQUS Analysis User's Guide
//! 34.1.2 "Amplitude curves" (continuation in subsequent steps), 34.3.1 "Boundary conditions", 34.4.1 "Applying loads",
//! 4.1.3 "Output to the output database", and the Keywords Reference Guide, `*BOUNDARY`, `*CLOAD`, `*CONTACT PAIR`,
//! `*OUTPUT`, `*STEP`, `*AMPLITUDE`. That loads of one step add up is not specified there; CalculiX documents it for
//! `*CLOAD`.
//! Tolerance: 1e-5 of the value; central differences with 1000 increments per step are of second order.

use std::f64::consts::PI;

use crate::common;
use crate::common::solid;
use revolve::job;
use revolve::user::Routines;

/// Duration of each of two steps.
const T: f64 = 0.1;
/// Mass of the rigid disc of radius 1.
const M: f64 = 2.0;

const AMPLITUDES: &str = "*Amplitude, name=UP\n 0., 0., 0.1, 1.\n*Amplitude, name=SMOOTH, definition=SMOOTH STEP\n 0., 0., 0.1, 1.\n\
    *Amplitude, name=DOWN, definition=SMOOTH STEP\n 0., 1., 0.1, 0.\n*Amplitude, name=HIGH\n 0., 1., 0.1, 2.\n\
    *Amplitude, name=TOTAL, time=TOTAL TIME\n 0., 0., 0.2, 1.\n*Amplitude, name=ABS, value=ABSOLUTE\n 0., 2., 0.1, 2.\n";

/// Rigid disc with surface FACE, elements DISC, reference node 3 in set REF.
const DISC: &str = "*Node\n 1, 0., 0.\n 2, 1., 0.\n 3, 0., 0.\n*Nset, nset=REF\n 3\n*Element, type=RAX2, elset=DISC\n 1, 1, 2\n\
    *Surface, name=FACE\n DISC, SPOS\n*Rigid Body, ref node=3, elset=DISC\n*Element, type=MASS, elset=M\n 2, 3\n*Mass, elset=M\n 2.\n";

/// Returns a block all of whose nodes are in set REF and move along z without strain.
fn block_model() -> String {
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

fn final_value(text: &str, name: &str) -> f64 {
    let (outcome, memory) = common::run(text, &[], &Routines::none());
    assert!(outcome.halt.is_none(), "{:?}\n{text}", outcome.halt);
    solid::last(text, &memory, name)
}

fn error_codes(text: &str) -> Vec<&'static str> {
    job::prepare_text("case.inp", text, &[], &Routines::none()).diagnostics.iter().map(|d| d.code).collect()
}

#[track_caller]
fn assert_close(what: &str, found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-5 * expected.abs() + 1e-9, "{what}: {found}, expected {expected}");
}

/// Card that applies an axial force to the disc, with parameters on its keyword line.
type LoadCard = fn(&str, Option<f64>) -> String;

/// Loads: 34.4.1 and 34.1.2. The final velocity is the impulse over the mass.
#[test]
fn loads_follow_the_step_rules() {
    let pushes: [(&str, LoadCard); 4] = [
        ("CLOAD", |p, f| f.map_or(format!("*Cload{p}\n"), |f| format!("*Cload{p}\n REF, 2, {f}\n"))),
        ("DLOAD", |p, f| f.map_or(format!("*Dload{p}\n"), |f| format!("*Dload{p}\n DISC, P, {}\n", -f / PI))),
        ("DSLOAD", |p, f| f.map_or(format!("*Dsload{p}\n"), |f| format!("*Dsload{p}\n FACE, P, {}\n", -f / PI))),
        ("GRAV", |p, f| f.map_or(format!("*Dload{p}\n"), |f| format!("*Dload{p}\n , GRAV, {}, 0., 1.\n", f / M))),
    ];
    for (name, push) in pushes {
        let of = |f| push("", Some(f));
        let table: [(&str, String, String, f64); 7] = [
            ("next step: continues", of(4.0), String::new(), 8.0),
            ("same step: adds", of(4.0) + &of(2.0), String::new(), 12.0),
            ("next step MOD: replaces", of(4.0), of(1.0), 5.0),
            ("next step NEW: ends", of(4.0), push(", op=NEW", None), 4.0),
            ("next step NEW with another", of(4.0), push(", op=NEW", Some(1.0)), 5.0),
            ("amplitude in step time ends: constant", push(", amplitude=UP", Some(4.0)), String::new(), 6.0),
            ("amplitude in total time continues", push(", amplitude=TOTAL", Some(4.0)), String::new(), 4.0),
        ];
        for (case, first, second, impulse) in table {
            let text = deck(DISC, [("", &first), ("", &second)]);
            assert_close(&format!("{name}, {case}"), final_value(&text, "V2@REF"), impulse * T / M);
            assert_eq!(error_codes(&text).contains(&"M144"), case.starts_with("same step"), "{name}, {case}");
        }
    }
}

/// 34.4.1: a later step replaces the load only on the nodes it names.
#[test]
fn later_load_replaces_earlier_load_node_by_node() {
    let model = block_model();
    let free = "*Cload\n ALL, 2, 1.\n";
    let of = |second: &str| {
        let text = deck(&model, [("", free), ("", second)]);
        (final_value(&text, "V2@1"), final_value(&text, "V2@2"), final_value(&text, "V2@3"), final_value(&text, "V2@4"))
    };
    // The momentum is the impulse of all forces.
    let momentum = |v: (f64, f64, f64, f64)| {
        // Lumped masses of a cylinder of density 1, height 1 and radius 1: row sums, 2 pi/12 at the axis, 2 pi/6 at r =
        // 1.
        let (inner, outer) = (2.0 * PI / 12.0, 2.0 * PI / 6.0);
        inner * (v.0 + v.2) + outer * (v.1 + v.3)
    };
    for (case, second, impulse, jump) in [
        ("all continue", "", 8.0, 0.0),
        ("node 2 has another load", "*Cload\n 2, 2, 5.\n", 4.0 + 8.0, 4.0),
        ("node 2 with OP=NEW", "*Cload, op=NEW\n 2, 2, 5.\n", 4.0 + 5.0, 1.0),
    ] {
        // Nodal accelerations continue over the step boundary, so a discontinuous force acts half an increment, 5e-5,
        // early.
        let error = (momentum(of(second)) - impulse * T).abs();
        assert!(error <= jump * 0.5e-4 + 1e-5 * impulse * T, "{case}: {error}");
    }
}

/// Boundary conditions: 34.3.1 and 34.1.2, on a rigid and on a deformable body. Compared is the final displacement.
#[test]
fn boundary_conditions_follow_the_step_rules() {
    let velocity = |p: &str, v: f64| format!("*Boundary, type=VELOCITY{p}\n REF, 2, 2, {v}\n");
    let push = |p: &str, a: f64| format!("*Boundary, type=ACCELERATION{p}\n REF, 2, 2, {a}\n");
    let place = |p: &str, u: f64| format!("*Boundary{p}\n REF, 2, 2, {u}\n");
    let none = String::new;
    let new = || "*Boundary, op=NEW\n".to_owned();
    let table: [(&str, String, String, f64); 19] = [
        ("velocity continues", velocity("", 1.0), none(), 0.2),
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
        ("displacement is constant", place(", amplitude=SMOOTH", 0.3), none(), 0.3),
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
        ("acceleration continues", push("", 2.0), none(), 0.04),
        ("acceleration, MOD", push("", 2.0), push("", -2.0), 0.02),
        ("acceleration, NEW", push("", 2.0), new(), 0.03),
        ("acceleration, amplitude ends", push(", amplitude=UP", 2.0), none(), 2.0 * T * T / 6.0 + 0.1 * T + T * T),
    ];
    for (model, name, node) in [
        (DISC.to_owned() + "*Nset, nset=NODES\n REF\n", "rigid", "REF"),
        (block_model() + "*Nset, nset=NODES\n 1, 2, 3, 4\n", "deformable", "4"),
    ] {
        for (case, first, second, displacement) in &table {
            let text = deck(&model, [("", first), ("", second)]);
            let found = final_value(&text, &format!("U2@{node}"));
            // Nodal accelerations continue over the step boundary, so a discontinuous acceleration acts half an
            // increment late.
            let late = if case.starts_with("acceleration") { 4.0 * 0.5e-4 * T } else { 0.0 };
            let error = (found - displacement).abs();
            assert!(
                error <= 1e-5 * displacement.abs() + late + 1e-9,
                "{name}, {case}: {found}, expected {displacement}"
            );
            let found = error_codes(&text);
            assert_eq!(found.contains(&"M145"), case.contains("same step"), "{name}, {case}: {found:?}");
            assert_eq!(found.contains(&"M146"), case.contains("jump"), "{name}, {case}: {found:?}");
        }
    }
}

/// A displacement that returns from 1 to 0 with a smooth amplitude has no jump in velocity (34.3.1).
#[test]
fn returning_displacement_has_no_velocity_jump() {
    let text = deck(
        DISC,
        [("", "*Boundary, amplitude=SMOOTH\n REF, 2, 2, 0.3\n"), ("", "*Boundary, amplitude=DOWN\n REF, 2, 2, 0.3\n")],
    );
    let (_, memory) = common::run(&text, &[], &Routines::none());
    let speeds = solid::column(&text, &memory, "V2@REF");
    let fastest = speeds.iter().fold(0.0, |m: f64, v| m.max(v.1.abs()));
    // The largest slope of 10 x^3 - 15 x^4 + 6 x^5 is 15/8.
    assert_close("largest speed", fastest, 0.3 / T * 15.0 / 8.0);
}

/// `*STEP, AMPLITUDE` (Keywords Reference Guide): loads and motions without amplitude are ramped from their previous
/// values.
#[test]
fn ramped_steps_start_from_previous_values() {
    let ramp = ", amplitude=RAMP";
    for (case, first, second, impulse) in [
        ("from zero, then constant", (ramp, "*Cload\n REF, 2, 4.\n"), ("", ""), 2.0 + 4.0),
        ("from the previous value", (ramp, "*Cload\n REF, 2, 4.\n"), (ramp, "*Cload\n REF, 2, 1.\n"), 2.0 + 2.5),
        ("down to zero", ("", "*Cload\n REF, 2, 4.\n"), (ramp, "*Cload\n REF, 2, 0.\n"), 4.0 + 2.0),
        ("its own amplitude first", (ramp, "*Cload, amplitude=ABS\n REF, 2, 4.\n"), ("", ""), 2.0 + 2.0),
        ("AMPLITUDE=STEP", (", amplitude=STEP", "*Cload\n REF, 2, 4.\n"), ("", ""), 4.0 + 4.0),
    ] {
        assert_close(case, final_value(&deck(DISC, [first, second]), "V2@REF"), impulse * T / M);
    }
    for (case, first, second, displacement) in [
        ("velocity", (ramp, "*Boundary, type=VELOCITY\n REF, 2, 2, 1.\n"), ("", ""), 0.05 + 0.1),
        ("displacement", (ramp, "*Boundary\n REF, 2, 2, 0.3\n"), (ramp, "*Boundary\n REF, 2, 2, 0.1\n"), 0.1),
    ] {
        let text = deck(DISC, [first, second]);
        assert_close(case, final_value(&text, "U2@REF"), displacement);
        assert!(error_codes(&text).is_empty(), "{:?}", error_codes(&text));
    }
}

/// `*AMPLITUDE, VALUE=ABSOLUTE`: magnitudes on the data lines of loads and motions are ignored.
#[test]
fn absolute_amplitudes_replace_magnitudes() {
    let text = deck(DISC, [("", "*Cload, amplitude=ABS\n REF, 2, 5.\n"), ("", "")]);
    assert_close("force", final_value(&text, "V2@REF"), 2.0 * 2.0 * T / M);
    let text = deck(DISC, [("", "*Boundary, type=VELOCITY, amplitude=ABS\n REF, 2, 2, 5.\n"), ("", "")]);
    assert_close("velocity", final_value(&text, "U2@REF"), 2.0 * 2.0 * T);
}

/// Input that would silently change the meaning of a deck is an error.
#[test]
fn unsupported_step_options_are_errors() {
    for (first, second, code) in [
        ((", nlgeom=NO", ""), ("", ""), "M104"),
        ((", nlgeom=MAYBE", ""), ("", ""), "M104"),
        ((", amplitude=SLOW", ""), ("", ""), "M103"),
        (("", "*Boundary\n REF, 1, 1\n"), ("", "*Boundary, op=NEW\n REF, 1, 1\n*Boundary\n REF, 6, 6\n"), "M103"),
        (("", "*Cload, op=OLD\n REF, 2, 1.\n"), ("", ""), "M103"),
        (("", "*Dynamic, explicit\n , 1.\n"), ("", ""), "M160"),
    ] {
        let text = deck(DISC, [first, second]);
        assert!(error_codes(&text).contains(&code), "{first:?} {second:?}: {:?}", error_codes(&text));
    }
}

/// `*CONTACT PAIR`, OP=ADD and DELETE: a block falls past a plane after deletion of the pair. u = v t.
#[test]
fn contact_pairs_can_be_deleted_and_added() {
    let model = solid::grid(1, 1, false, |i, j| [i as f64, j as f64 + 0.15])
        + &solid::material(1e5, 0.0, 1.0, "")
        + "*Node\n 99, 0., 0.\n*Nset, nset=REF\n 1\n*Surface, type=SEGMENTS, name=PLANE\n START, 2., 0.\n LINE, 0., 0.\n\
           *Rigid Body, ref node=99, analytical surface=PLANE\n*Surface, type=NODE, name=LOW\n J0\n\
           *Initial conditions, type=VELOCITY\n ALL, 2, -1.\n*Surface interaction, name=SMOOTH\n";
    let held = "*Boundary\n 99, 1, 6\n*Contact pair, interaction=SMOOTH\n LOW, PLANE\n";
    let of = |second: &str| final_value(&deck(&model, [("", held), ("", second)]), "U2@REF");
    assert_close("released", of("*Contact pair, interaction=SMOOTH, op=DELETE\n LOW, PLANE\n"), -2.0 * T);
    let continued = of("");
    assert!(continued >= -0.15 - 1e-9, "{continued}");
    assert_eq!(of("*Contact pair, interaction=SMOOTH\n LOW, PLANE\n").to_bits(), continued.to_bits(), "given again");
    let text = deck(
        &model,
        [("", "*Boundary\n 99, 1, 6\n"), ("", "*Contact pair, interaction=SMOOTH, op=DELETE\n LOW, PLANE\n")],
    );
    assert!(error_codes(&text).contains(&"M114"));
}

/// `*OUTPUT`, OP=NEW (default), ADD, REPLACE: history rows and frames by step.
#[test]
fn output_requests_follow_the_step_rules() {
    let first = "*Output, field, number interval=2\n*Node output\n U\n*Output, history, frequency=500\n*Node output, nset=REF\n U2\n";
    let count = |second: &str| {
        let text = format!("{DISC}{AMPLITUDES}{}{}", step("", "*Cload\n REF, 2, 4.\n", first), step("", "", second));
        let (_, memory) = common::run(&text, &[], &Routines::none());
        let after = |t: &f64| *t > T * (1.0 + 1e-9);
        let rows = memory.rows.iter().filter(|r| after(&r.0)).count();
        let frames = memory.frames.iter().filter(|f| after(&f.time)).count();
        (rows, frames, error_codes(&text).contains(&"M148"))
    };
    assert_eq!(count(""), (2, 2, false), "requests continue");
    assert_eq!(
        count("*Output, field, number interval=4\n*Node output\n U\n"),
        (0, 4, true),
        "NEW also ends history output"
    );
    assert_eq!(count("*Output, field, number interval=4, op=ADD\n*Node output\n V\n"), (2, 4, false), "ADD");
    assert_eq!(
        count("*Output, history, frequency=500, op=REPLACE\n*Node output, nset=REF\n V2\n"),
        (2, 2, false),
        "REPLACE"
    );
}

/// Degrees of freedom (Analysis User's Guide 1.2.2, 34.3.1): constraints, motions and loads on absent degrees of
/// freedom are reported.
#[test]
fn absent_degrees_of_freedom_are_reported() {
    let found = |model: &str, cards: &str| {
        let text = deck(model, [("", cards), ("", "")]);
        let prepared = job::prepare_text("case.inp", &text, &[], &Routines::none());
        (prepared.diagnostics.iter().map(|d| d.code).collect::<Vec<_>>(), prepared.diagnostics.has_errors())
    };
    let model = block_model();
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
    assert_eq!(
        found(DISC, "*Boundary\n REF, 1, 1\n REF, 6, 6\n").0,
        Vec::<&str>::new(),
        "a reference node has a rotation"
    );
    assert_eq!(found(DISC, "*Dload\n , GRAV, 9.81, 1., 0.\n").0, vec!["M152"]);
}

/// Fourth field of `*DYNAMIC, EXPLICIT` (Keywords Reference Guide): maximum increment.
#[test]
fn maximum_increment_is_respected() {
    let model = block_model();
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
    // Fields of other programs: the first and the smallest increment.
    assert_eq!(run("1.e-5, 0.1, 1.e-9, 1.").to_bits(), free.to_bits());
    let text = format!("{model}*Step\n*Dynamic, explicit\n , 0.1, , -1.\n*End step\n");
    assert!(error_codes(&text).contains(&"M103"));
}

/// `*FIXED MASS SCALING` (Analysis User's Guide 11.6.1): remains in steps without mass scaling, and is replaced
/// otherwise.
#[test]
fn mass_scaling_follows_the_step_rules() {
    let model = block_model();
    let push = "*Cload\n ALL, 2, 1.\n";
    let mean = |second: &str| {
        let text = deck(&model, [("", &format!("{push}*Fixed mass scaling, factor=2.\n")), ("", second)]);
        let v = ["V2@1", "V2@2", "V2@3", "V2@4"].map(|name| final_value(&text, name));
        (v[0] + v[2] + 2.0 * (v[1] + v[3])) / 6.0
    };
    // Four forces of 1 on a cylinder of mass pi times the factor.
    let speed = |factor: f64| 4.0 * T / (PI * factor);
    assert_close("no card", mean(""), 2.0 * speed(2.0));
    let found = mean("*Fixed mass scaling, factor=4.\n");
    let late = (speed(2.0) - speed(4.0)) / T * 0.5e-4;
    assert!((found - speed(2.0) - speed(4.0)).abs() <= late + 1e-6, "replaced: {found}");
}

/// Only fixed boundary conditions are valid before the first step (Analysis User's Guide 34.3.1, "as model data").
#[test]
fn model_data_boundaries_are_active_in_all_steps() {
    let refused = DISC.to_owned() + "*Boundary, type=VELOCITY\n REF, 2, 2, 1.\n";
    assert!(error_codes(&deck(&refused, [("", ""), ("", "")])).contains(&"M105"));
    let held = DISC.to_owned() + "*Boundary\n REF, 2, 2\n";
    let push = "*Cload\n REF, 2, 4.\n";
    assert_close("held", 1.0 + final_value(&deck(&held, [("", push), ("", "")]), "U2@REF"), 1.0);
    assert_close(
        "released",
        final_value(&deck(&held, [("", push), ("", "*Boundary, op=NEW\n")]), "V2@REF"),
        4.0 * T / M,
    );
    let moved = deck(&held, [("", ""), ("", "*Boundary, type=VELOCITY\n REF, 2, 2, 1.\n")]);
    assert_close("moved later", final_value(&moved, "U2@REF"), T);
}
