//! Yield stresses and fields of the user (VUHARD, VUSDFLD) against the built-in laws and by hand.
//!
//! Goal: a routine that gives a law's yield stress gives the results of the law built in; what a routine of fields is told is
//! what outputs show, and what it answers reaches the routines behind it.
//! Needs gfortran for the routines in Fortran; without it those tests say so and pass, except in CI.

use std::fmt::Write as _;

use revolve::job;
use revolve::user::{
    FieldAnswer, FieldCall, HardeningAnswer, HardeningCall, LoadFailure, Routines, UserFields, UserHardening,
};

use crate::common::{self, Memory};
use crate::material::{compiled, last, taylor};

const HEAT: &str = "*Inelastic Heat Fraction\n 0.9,\n*Specific Heat\n 385.,\n";

/// Taylor's bar of a Johnson-Cook copper, heated by plastic work.
fn johnson_cook(plastic: &str) -> String {
    let material = format!("*Elastic\n 124.e9, 0.34\n{plastic}{HEAT}");
    let start = "*Initial Conditions, type=TEMPERATURE\n ALL, 20.\n*Initial Conditions, type=VELOCITY";
    taylor(&material, "PEEQ, TEMP")
        .replace("*Dynamic, Explicit, element by element", "*Dynamic, Explicit, adiabatic, element by element")
        .replacen("*Initial Conditions, type=VELOCITY", start, 1)
}

#[test]
fn a_vuhard_in_fortran_is_the_built_in_johnson_cook_bar() {
    if !common::fortran("a hardening of the user in Fortran") {
        return;
    }
    let built_in = johnson_cook(
        "*Plastic, hardening=JOHNSON COOK\n 90.e6, 292.e6, 0.31, 1.09, 1083., 20.\n*Rate Dependent, type=JOHNSON COOK\n \
         0.025, 1.\n",
    );
    let by_user =
        johnson_cook("*Plastic, hardening=USER, properties=8\n 90.e6, 292.e6, 0.31, 0.025, 1.09, 1., 20., 1083.\n");
    let source = std::fs::read_to_string(common::project("input/vuhard_johnson_cook.f90")).expect("the example");
    let (none, routines) = (Routines::none(), compiled(&source).expect("it compiles"));
    let ((expected, there), (outcome, here)) =
        (common::run(&built_in, &[], &none), common::run(&by_user, &[], &routines));
    assert_eq!((&expected.halt, &outcome.halt), (&None, &None));
    // Both meet the yield stress to 1e-11 of the trial's; a wave of plastic flow carries that on over 1000 increments.
    for name in ["U1@CORNER", "U2@TIP", "ALLIE", "ALLPD", "PEEQ@FOOT", "TEMP@FOOT"] {
        let expected = last(&built_in, &none, &there, name);
        let ratio = last(&by_user, &routines, &here, name) / expected;
        println!("{name}: {expected:e}, ratio - 1 = {:e}", ratio - 1.0);
        assert!((ratio - 1.0).abs() < 1e-7, "{name}: {expected:e}, ratio {ratio:.12}");
    }
    let heated = last(&by_user, &routines, &here, "TEMP@FOOT");
    assert!(heated > 40.0 && outcome.energy.drift < 2e-3, "{heated} {:?}", outcome.energy);
    let fields = &here.frames.last().expect("a frame").cell_fields;
    assert!(fields.iter().any(|f| f.name == "PEEQ"));
}

/// Linear hardening, scaled by the first field variable where there is one; slopes may be left out. Counts its answers.
struct Line {
    slopes: bool,
}

impl UserHardening for Line {
    fn yield_stress(&mut self, call: &HardeningCall<'_>, answer: &mut HardeningAnswer<'_>) -> Result<(), LoadFailure> {
        for i in 0..call.count {
            let factor = if call.fields > 0 { call.field[1][i] } else { 1.0 };
            answer.stress[i] = factor * (call.properties[0] + call.properties[1] * call.strain[i]);
            if self.slopes {
                answer.slopes[i] = factor * call.properties[1];
            }
            if call.variables > 0 {
                answer.state[i] = call.state[i] + 1.0;
            }
        }
        Ok(())
    }
}

const LINE: &str = "*Elastic\n 117.e9, 0.35\n*Plastic, hardening=USER, properties=2\n 400.e6, 100.e6\n";

#[test]
fn a_line_of_the_user_is_the_table_with_slopes_and_without() {
    let built_in = taylor("*Elastic\n 117.e9, 0.35\n*Plastic\n 400.e6, 0.\n 900.e6, 5.\n", "PEEQ");
    let (expected, there) = common::run(&built_in, &[], &Routines::none());
    for slopes in [true, false] {
        let routines = Routines::none().with_hardening(Line { slopes });
        let (outcome, here) = common::run(&taylor(LINE, "PEEQ"), &[], &routines);
        assert_eq!((outcome.halt, outcome.increments), (None, expected.increments));
        for name in ["U1@CORNER", "U2@TIP", "ALLIE", "ALLPD", "ALLSE", "PEEQ@FOOT", "S22@FOOT"] {
            let expected = last(&built_in, &Routines::none(), &there, name);
            let ratio = last(&taylor(LINE, "PEEQ"), &routines, &here, name) / expected;
            // The yield stress is met to 1e-11; a wave of plastic flow carries that on over 1000 increments.
            assert!((ratio - 1.0).abs() < 1e-8, "{name}: {expected:e}, ratio {ratio:.12}");
        }
    }
}

/// A tube of 2 by 2 cells pulled along z at a rate of one length a time, nothing moving along r.
fn pulled(material: &str, outputs: &str) -> String {
    crate::material::moving(|[_, z]| [0.0, z], material, outputs)
}

/// Row by row of a column.
fn column(text: &str, routines: &Routines, memory: &Memory, name: &str) -> Vec<f64> {
    let prepared = common::prepared(text, &[], routines);
    let at = prepared.plan.columns.iter().position(|c| c.name == name).expect("a column");
    memory.rows.iter().map(|row| row.1[at]).collect()
}

const SOFT: &str = "*Elastic\n 1000., 0.3\n*Plastic, hardening=USER, properties=2\n 10., 5.\n";

/// Writes down what it is told, softens with the plastic strain, and deletes behind a limit of the third state variable.
struct Softening {
    limit: f64,
}

impl UserFields for Softening {
    fn fields(&mut self, call: &FieldCall<'_>, answer: &mut FieldAnswer<'_>) -> Result<(), LoadFailure> {
        let n = call.count;
        let mut told = vec![[0.0; 4]; n];
        assert_eq!(call.values.give("S", &mut |c, i, value| told[i][c] = value), Some(4));
        let mut strain = vec![0.0; n];
        assert_eq!(call.values.give("PEEQ", &mut |_, i, value| strain[i] = value), Some(1));
        let mut logarithmic = vec![[0.0; 4]; n];
        assert_eq!(call.values.give("LE", &mut |c, i, value| logarithmic[i][c] = value), Some(4));
        assert_eq!(call.values.give("SDEG", &mut |_, _, _| ()), None);
        for i in 0..n {
            answer.state[n + i] = told[i][1];
            answer.state[2 * n + i] = logarithmic[i][1];
            answer.state[3 * n + i] = if strain[i] < self.limit { 1.0 } else { 0.0 };
            answer.field[i] = 1.0 - call.properties[0] * strain[i].min(0.5);
        }
        Ok(())
    }
}

#[test]
fn fields_reach_the_hardening_and_what_they_are_told_is_what_outputs_show() {
    let fields = "*User Defined Field, properties=1\n 0.8,\n*Depvar, delete=4\n 4,\n 2, AXIAL, \"stress before\"\n";
    let text = pulled(&(SOFT.to_owned() + fields), " S22, MISES, PEEQ, SDV, LE22\n")
        .replace("number interval=10", "frequency=1");
    let text = text.replace("*End Step", "*Output, field, number interval=1\n*Element Output\n SDV\n*End Step");
    let routines =
        || Routines::none().with_hardening(Line { slopes: true }).with_fields(Softening { limit: f64::INFINITY });
    let (outcome, memory) = common::run(&text, &[], &routines());
    assert_eq!(outcome.halt, None);
    let rows = |name: &str| column(&text, &routines(), &memory, &format!("{name}@ONE"));
    let (stress, told, plastic, mises) = (rows("S22"), rows("SDV2"), rows("PEEQ"), rows("MISES"));
    assert_eq!(told[1..], stress[..stress.len() - 1], "the stress of the increment before");
    assert_eq!(rows("SDV3")[1..], rows("LE22")[..stress.len() - 1]);
    let flows = plastic.iter().position(|p| *p > 0.0).expect("it yields");
    for i in flows + 1..plastic.len() {
        let expected = (1.0 - 0.8 * plastic[i - 1].min(0.5)) * (10.0 + 5.0 * plastic[i]);
        assert!((mises[i] / expected - 1.0).abs() < 1e-10, "{i}: {} {expected}", mises[i]);
    }
    // The hardening was asked for each point in each increment, and kept what the last question gave.
    assert!(rows("SDV1").last().is_some_and(|n| *n == (memory.rows.len() - 1) as f64), "{:?}", rows("SDV1").last());
    let names: Vec<&str> = memory.frames.last().expect("a frame").cell_fields.iter().map(|f| f.name.as_str()).collect();
    assert!(names.contains(&"SDV_AXIAL") && names.contains(&"SDV1") && !names.contains(&"SDV2"), "{names:?}");
}

#[test]
fn fields_delete_elements_of_built_in_materials() {
    let built_in = "*Elastic\n 1000., 0.3\n*Plastic\n 10., 0.\n 15., 1.\n";
    let fields = "*User Defined Field, properties=1\n 0.,\n*Depvar, delete=4\n 4,\n";
    let text = pulled(&format!("{built_in}{fields}"), " S22, PEEQ, STATUS, SDV4\n*Energy Output\n ALLIE, ALLPD\n");
    let routines = || Routines::none().with_fields(Softening { limit: 0.1 });
    let (outcome, memory) = common::run(&text, &[], &routines());
    assert_eq!(outcome.halt, None);
    let rows = |name: &str| column(&text, &routines(), &memory, &format!("{name}@ONE"));
    let (status, plastic) = (rows("STATUS"), rows("PEEQ"));
    let gone = status.iter().position(|s| *s == 0.0).expect("it goes");
    assert!(plastic[gone - 1] < 0.1 + 0.02 && status[gone..].iter().all(|s| *s == 0.0), "{plastic:?}");
    assert!(rows("S22")[gone..].iter().all(|s| *s == 0.0));
    // Until then it is the built-in material.
    let plain = pulled(built_in, " S22, PEEQ\n");
    let (_, there) = common::run(&plain, &[], &Routines::none());
    let expected = column(&plain, &Routines::none(), &there, "S22@ONE");
    for (a, b) in rows("S22")[..gone].iter().zip(&expected) {
        assert!((a - b).abs() < 1e-9 * b.abs().max(1.0), "{a} {b}");
    }
}

#[test]
fn initial_states_and_fields_are_told() {
    let start = "*Depvar\n 9,\n*Initial Conditions, type=SOLUTION\n SOLID, , 2., , , , ,7.\n 8., 9.\n*Initial Conditions, \
                 type=FIELD, variable=1\n ALL, 2.\n";
    let text = pulled(&(SOFT.to_owned() + start), " MISES, PEEQ, SDV\n");
    let routines = || Routines::none().with_hardening(Line { slopes: true });
    let (outcome, memory) = common::run(&text, &[], &routines());
    assert_eq!(outcome.halt, None);
    let rows = |name: &str| column(&text, &routines(), &memory, &format!("{name}@ONE"));
    let first: Vec<f64> = (2..=9).map(|k| rows(&format!("SDV{k}"))[0]).collect();
    assert_eq!(first, [2.0, 0.0, 0.0, 0.0, 0.0, 7.0, 8.0, 9.0]);
    let (mises, plastic) = (rows("MISES"), rows("PEEQ"));
    let expected = 2.0 * (10.0 + 5.0 * plastic.last().expect("a row"));
    assert!((mises.last().expect("a row") / expected - 1.0).abs() < 1e-10, "twice the yield stress");
}

/// Fails in a way of its own.
struct Faulty(&'static str);

impl UserHardening for Faulty {
    fn yield_stress(&mut self, call: &HardeningCall<'_>, answer: &mut HardeningAnswer<'_>) -> Result<(), LoadFailure> {
        answer.stress.fill(1.0);
        match self.0 {
            "nan" => answer.stress[2] = f64::NAN,
            // The more it flows, the lower it lies: nothing to meet.
            "state" => answer.state[call.count - 1] = f64::INFINITY,
            _ => return Err(LoadFailure { point: Some(1), reason: "out of table".into() }),
        }
        Ok(())
    }
}

#[test]
fn faults_are_located_and_what_is_missing_is_named() {
    let text = pulled(&(SOFT.to_owned() + "*Depvar\n 1,\n"), " S22\n");
    for (fault, words) in [("nan", "yield(k) = NaN"), ("state", "stateNew(k, 1) = inf"), ("own", "out of table")] {
        let (outcome, _) = common::run(&text, &[], &Routines::none().with_hardening(Faulty(fault)));
        let halt = outcome.halt.expect("a halt");
        let element = if fault == "state" {
            "element 4"
        } else if fault == "nan" {
            "element 3"
        } else {
            "element 2"
        };
        assert!(halt.code == "R201" && halt.reason.contains(words) && halt.reason.contains(element), "{halt:?}");
    }
    let refused = |material: &str, routines: &Routines| {
        let prepared = job::prepare_text("test.inp", &pulled(material, " S22\n"), &[], routines);
        assert!(prepared.diagnostics.has_errors(), "{material}");
        prepared.diagnostics.render(&prepared.deck.sources)
    };
    let mut said = String::new();
    let fields = SOFT.to_owned() + "*User Defined Field\n";
    let eos = "*Eos, type=USUP\n 1., 1., 1.\n*User Defined Field\n";
    for (material, routines, words) in [
        (SOFT, Routines::none(), "vuhard"),
        (&fields, Routines::none().with_hardening(Line { slopes: true }), "vusdfld"),
        (eos, Routines::none().with_fields(Softening { limit: 1.0 }), "beside *EOS"),
    ] {
        let told = refused(material, &routines);
        assert!(told.contains(words), "{words} in {told}");
        writeln!(said, "{told}").expect("text");
    }
    assert!(said.contains("P004") && said.contains("P041"), "{said}");
}

/// Bars drawn before the analysis: what has hardened yields as a material does whose table begins there.
#[test]
fn a_plastic_strain_at_the_start_is_a_table_that_begins_later() {
    let later = pulled("*Elastic\n 1000., 0.3\n*Plastic\n 20., 0.\n 60., 8.\n", " S22, PEEQ\n");
    let (_, there) = common::run(&later, &[], &Routines::none());
    let drawn = |material: &str| {
        pulled(material, " S22, PEEQ\n").replace("*Step\n", "*Initial Conditions, type=HARDENING\n SOLID, 2.\n*Step\n")
    };
    let table = "*Elastic\n 1000., 0.3\n*Plastic\n 10., 0.\n 60., 10.\n";
    // A rate that does nothing: elements one after the other.
    let rate = table.to_owned() + "*Rate Dependent, type=JOHNSON COOK\n 0., 1.\n";
    for (material, routines) in [
        (table, Routines::none()),
        (&rate, Routines::none()),
        (SOFT, Routines::none().with_hardening(Line { slopes: true })),
    ] {
        let text = drawn(material);
        let (outcome, here) = common::run(&text, &[], &routines);
        assert_eq!(outcome.halt, None);
        for (name, more) in [("S22@ONE", 0.0), ("PEEQ@ONE", 2.0)] {
            let expected = last(&later, &Routines::none(), &there, name) + more;
            let got = last(&text, &routines, &here, name);
            // The user's yield stress is met to 1e-11 of the trial's.
            assert!((got / expected - 1.0).abs() < 1e-8, "{material}{name}: {expected} {got}");
        }
    }
    for material in
        ["*Elastic\n 1000., 0.3\n", "*Elastic\n 1000., 0.3\n*Plastic, hardening=KINEMATIC\n 10., 0.\n 20., 1.\n"]
    {
        let prepared = job::prepare_text("test.inp", &drawn(material), &[], &Routines::none());
        let said = prepared.diagnostics.render(&prepared.deck.sources);
        assert!(said.contains("P017") && said.contains("isotropic hardening"), "{said}");
    }
}
