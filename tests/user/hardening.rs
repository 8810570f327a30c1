//! User yield stresses and fields (VUHARD, VUSDFLD) compared with the built-in laws and closed forms.
//!
//! Goal: a subroutine with the yield stress of a built-in law gives the results of that law; the values passed to a
//! field subroutine are those of the output, and its results reach the subroutines called after it. Needs gfortran for
//! Fortran files; without it those tests are left out, except in CI.

use std::fmt::Write as _;

use revolve::job;
use revolve::user::{
    FieldAnswer, FieldCall, HardeningAnswer, HardeningCall, LoadFailure, Routines, UserFields, UserHardening,
};

use crate::common::{self, RecordedOutput};
use crate::material::{compiled, last, taylor};

const HEAT: &str = "*Inelastic Heat Fraction\n 0.9,\n*Specific Heat\n 385.,\n";

/// Returns a Taylor bar of Johnson-Cook copper, heated by plastic work.
fn johnson_cook(plastic: &str) -> String {
    let material = format!("*Elastic\n 124.e9, 0.34\n{plastic}{HEAT}");
    let start = "*Initial Conditions, type=TEMPERATURE\n ALL, 20.\n*Initial Conditions, type=VELOCITY";
    taylor(&material, "PEEQ, TEMP")
        .replace("*Dynamic, Explicit, element by element", "*Dynamic, Explicit, adiabatic, element by element")
        .replacen("*Initial Conditions, type=VELOCITY", start, 1)
}

#[test]
fn fortran_vuhard_matches_built_in_johnson_cook() {
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
    // Both satisfy the yield condition within 1e-11 of the trial stress; plastic flow amplifies the difference over
    // 1000 increments.
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

/// Linear hardening, multiplied by the first field variable if there is one, with optional slopes. Counts its calls in
/// a state variable.
pub struct LinearYieldStress {
    pub slopes: bool,
}

impl UserHardening for LinearYieldStress {
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
fn linear_user_hardening_matches_the_table() {
    let built_in = taylor("*Elastic\n 117.e9, 0.35\n*Plastic\n 400.e6, 0.\n 900.e6, 5.\n", "PEEQ");
    let (expected, there) = common::run(&built_in, &[], &Routines::none());
    for slopes in [true, false] {
        let routines = Routines::none().with_hardening(LinearYieldStress { slopes });
        let (outcome, here) = common::run(&taylor(LINE, "PEEQ"), &[], &routines);
        assert_eq!((outcome.halt, outcome.increments), (None, expected.increments));
        for name in ["U1@CORNER", "U2@TIP", "ALLIE", "ALLPD", "ALLSE", "PEEQ@FOOT", "S22@FOOT"] {
            let expected = last(&built_in, &Routines::none(), &there, name);
            let ratio = last(&taylor(LINE, "PEEQ"), &routines, &here, name) / expected;
            // The yield condition is satisfied within 1e-11; plastic flow amplifies the difference over 1000
            // increments.
            assert!((ratio - 1.0).abs() < 1e-8, "{name}: {expected:e}, ratio {ratio:.12}");
        }
    }
}

/// Returns a tube of 2 by 2 elements stretched along z at a rate of one length per time, without radial motion.
pub fn pulled(material: &str, outputs: &str) -> String {
    crate::material::moving(|[_, z]| [0.0, z], material, outputs)
}

/// Returns the values of a column.
fn column(text: &str, routines: &Routines, memory: &RecordedOutput, name: &str) -> Vec<f64> {
    let prepared = common::prepared(text, &[], routines);
    let at = prepared.plan.columns.iter().position(|c| c.name == name).expect("a column");
    memory.rows.iter().map(|row| row.1[at]).collect()
}

pub const SOFT: &str = "*Elastic\n 1000., 0.3\n*Plastic, hardening=USER, properties=2\n 10., 5.\n";

/// User field that stores the values it receives, decreases with plastic strain, and deletes elements above a plastic
/// strain.
pub struct SofteningField {
    pub limit: f64,
}

impl UserFields for SofteningField {
    fn fields(&mut self, call: &FieldCall<'_>, answer: &mut FieldAnswer<'_>) -> Result<(), LoadFailure> {
        let n = call.count;
        let mut received = vec![[0.0; 4]; n];
        assert_eq!(call.values.give("S", &mut |c, i, value| received[i][c] = value), Some(4));
        let mut strain = vec![0.0; n];
        assert_eq!(call.values.give("PEEQ", &mut |_, i, value| strain[i] = value), Some(1));
        let mut logarithmic = vec![[0.0; 4]; n];
        assert_eq!(call.values.give("LE", &mut |c, i, value| logarithmic[i][c] = value), Some(4));
        assert_eq!(call.values.give("SDEG", &mut |_, _, _| ()), None);
        for i in 0..n {
            answer.state[n + i] = received[i][1];
            answer.state[2 * n + i] = logarithmic[i][1];
            answer.state[3 * n + i] = if strain[i] < self.limit { 1.0 } else { 0.0 };
            answer.field[i] = 1.0 - call.properties[0] * strain[i].min(0.5);
        }
        Ok(())
    }
}

#[test]
fn user_fields_reach_hardening_and_match_output() {
    let fields = "*User Defined Field, properties=1\n 0.8,\n*Depvar, delete=4\n 4,\n 2, AXIAL, \"stress before\"\n";
    let text = pulled(&(SOFT.to_owned() + fields), " S22, MISES, PEEQ, SDV, LE22\n")
        .replace("number interval=10", "frequency=1");
    let text = text.replace("*End Step", "*Output, field, number interval=1\n*Element Output\n SDV\n*End Step");
    let routines = || {
        Routines::none()
            .with_hardening(LinearYieldStress { slopes: true })
            .with_fields(SofteningField { limit: f64::INFINITY })
    };
    let (outcome, memory) = common::run(&text, &[], &routines());
    assert_eq!(outcome.halt, None);
    let rows = |name: &str| column(&text, &routines(), &memory, &format!("{name}@ONE"));
    let (stress, received, plastic, mises) = (rows("S22"), rows("SDV2"), rows("PEEQ"), rows("MISES"));
    assert_eq!(received[1..], stress[..stress.len() - 1], "the stress of the previous increment");
    assert_eq!(rows("SDV3")[1..], rows("LE22")[..stress.len() - 1]);
    let flows = plastic.iter().position(|p| *p > 0.0).expect("it yields");
    for i in flows + 1..plastic.len() {
        let expected = (1.0 - 0.8 * plastic[i - 1].min(0.5)) * (10.0 + 5.0 * plastic[i]);
        assert!((mises[i] / expected - 1.0).abs() < 1e-10, "{i}: {} {expected}", mises[i]);
    }
    // The yield stress was requested at each point in each increment, and the state of the last request was kept.
    assert!(rows("SDV1").last().is_some_and(|n| *n == (memory.rows.len() - 1) as f64), "{:?}", rows("SDV1").last());
    let names: Vec<&str> = memory.frames.last().expect("a frame").cell_fields.iter().map(|f| f.name.as_str()).collect();
    assert!(names.contains(&"SDV_AXIAL") && names.contains(&"SDV1") && !names.contains(&"SDV2"), "{names:?}");
}

#[test]
fn fields_delete_elements_of_built_in_materials() {
    let built_in = "*Elastic\n 1000., 0.3\n*Plastic\n 10., 0.\n 15., 1.\n";
    let fields = "*User Defined Field, properties=1\n 0.,\n*Depvar, delete=4\n 4,\n";
    let text = pulled(&format!("{built_in}{fields}"), " S22, PEEQ, STATUS, SDV4\n*Energy Output\n ALLIE, ALLPD\n");
    let routines = || Routines::none().with_fields(SofteningField { limit: 0.1 });
    let (outcome, memory) = common::run(&text, &[], &routines());
    assert_eq!(outcome.halt, None);
    let rows = |name: &str| column(&text, &routines(), &memory, &format!("{name}@ONE"));
    let (status, plastic) = (rows("STATUS"), rows("PEEQ"));
    let gone = status.iter().position(|s| *s == 0.0).expect("it goes");
    assert!(plastic[gone - 1] < 0.1 + 0.02 && status[gone..].iter().all(|s| *s == 0.0), "{plastic:?}");
    assert!(rows("S22")[gone..].iter().all(|s| *s == 0.0));
    // Until then it equals the built-in material.
    let plain = pulled(built_in, " S22, PEEQ\n");
    let (_, there) = common::run(&plain, &[], &Routines::none());
    let expected = column(&plain, &Routines::none(), &there, "S22@ONE");
    for (a, b) in rows("S22")[..gone].iter().zip(&expected) {
        assert!((a - b).abs() < 1e-9 * b.abs().max(1.0), "{a} {b}");
    }
}

#[test]
fn initial_states_and_fields_reach_subroutines() {
    let start = "*Depvar\n 9,\n*Initial Conditions, type=SOLUTION\n SOLID, , 2., , , , ,7.\n 8., 9.\n*Initial Conditions, \
                 type=FIELD, variable=1\n ALL, 2.\n";
    let text = pulled(&(SOFT.to_owned() + start), " MISES, PEEQ, SDV\n");
    let routines = || Routines::none().with_hardening(LinearYieldStress { slopes: true });
    let (outcome, memory) = common::run(&text, &[], &routines());
    assert_eq!(outcome.halt, None);
    let rows = |name: &str| column(&text, &routines(), &memory, &format!("{name}@ONE"));
    let first: Vec<f64> = (2..=9).map(|k| rows(&format!("SDV{k}"))[0]).collect();
    assert_eq!(first, [2.0, 0.0, 0.0, 0.0, 0.0, 7.0, 8.0, 9.0]);
    let (mises, plastic) = (rows("MISES"), rows("PEEQ"));
    let expected = 2.0 * (10.0 + 5.0 * plastic.last().expect("a row"));
    assert!((mises.last().expect("a row") / expected - 1.0).abs() < 1e-10, "twice the yield stress");
}

/// User hardening with a selectable error.
pub struct FaultyHardening(pub &'static str);

impl UserHardening for FaultyHardening {
    fn yield_stress(&mut self, call: &HardeningCall<'_>, answer: &mut HardeningAnswer<'_>) -> Result<(), LoadFailure> {
        answer.stress.fill(1.0);
        match self.0 {
            "nan" => answer.stress[2] = f64::NAN,
            // An infinite state variable.
            "state" => answer.state[call.count - 1] = f64::INFINITY,
            _ => return Err(LoadFailure { point: Some(1), reason: "out of table".into() }),
        }
        Ok(())
    }
}

#[test]
fn errors_are_located_and_missing_routines_named() {
    let text = pulled(&(SOFT.to_owned() + "*Depvar\n 1,\n"), " S22\n");
    for (fault, words) in [("nan", "yield(k) = NaN"), ("state", "stateNew(k, 1) = inf"), ("own", "out of table")] {
        let (outcome, _) = common::run(&text, &[], &Routines::none().with_hardening(FaultyHardening(fault)));
        let halt = outcome.halt.expect("a halt");
        let element = if fault == "state" {
            "element 4"
        } else if fault == "nan" {
            "element 3"
        } else {
            "element 2"
        };
        assert!(
            halt.code() == "R201" && halt.message().contains(words) && halt.message().contains(element),
            "{halt:?}"
        );
    }
    let refused = |material: &str, routines: &Routines| {
        let prepared = job::prepare_text("test.inp", &pulled(material, " S22\n"), &[], routines);
        assert!(prepared.diagnostics.has_errors(), "{material}");
        prepared.diagnostics.render(&prepared.deck.sources)
    };
    let mut rendered = String::new();
    let fields = SOFT.to_owned() + "*User Defined Field\n";
    let eos = "*Eos, type=USUP\n 1., 1., 1.\n*User Defined Field\n";
    for (material, routines, words) in [
        (SOFT, Routines::none(), "vuhard"),
        (&fields, Routines::none().with_hardening(LinearYieldStress { slopes: true }), "vusdfld"),
        (eos, Routines::none().with_fields(SofteningField { limit: 1.0 }), "together with *EOS"),
    ] {
        let received = refused(material, &routines);
        assert!(received.contains(words), "{words} in {received}");
        writeln!(rendered, "{received}").expect("text");
    }
    assert!(rendered.contains("P004") && rendered.contains("P041"), "{rendered}");
}

/// Bars with initial plastic strain: they yield like a material whose table starts at this strain.
#[test]
fn initial_plastic_strain_shifts_the_hardening_table() {
    let later = pulled("*Elastic\n 1000., 0.3\n*Plastic\n 20., 0.\n 60., 8.\n", " S22, PEEQ\n");
    let (_, there) = common::run(&later, &[], &Routines::none());
    let drawn = |material: &str| {
        pulled(material, " S22, PEEQ\n").replace("*Step\n", "*Initial Conditions, type=HARDENING\n SOLID, 2.\n*Step\n")
    };
    let table = "*Elastic\n 1000., 0.3\n*Plastic\n 10., 0.\n 60., 10.\n";
    // A rate dependence without effect selects the update of single elements.
    let rate = table.to_owned() + "*Rate Dependent, type=JOHNSON COOK\n 0., 1.\n";
    for (material, routines) in [
        (table, Routines::none()),
        (&rate, Routines::none()),
        (SOFT, Routines::none().with_hardening(LinearYieldStress { slopes: true })),
    ] {
        let text = drawn(material);
        let (outcome, here) = common::run(&text, &[], &routines);
        assert_eq!(outcome.halt, None);
        for (name, more) in [("S22@ONE", 0.0), ("PEEQ@ONE", 2.0)] {
            let expected = last(&later, &Routines::none(), &there, name) + more;
            let got = last(&text, &routines, &here, name);
            // The user yield stress is satisfied within 1e-11 of the trial stress.
            assert!((got / expected - 1.0).abs() < 1e-8, "{material}{name}: {expected} {got}");
        }
    }
    for material in
        ["*Elastic\n 1000., 0.3\n", "*Elastic\n 1000., 0.3\n*Plastic, hardening=KINEMATIC\n 10., 0.\n 20., 1.\n"]
    {
        let prepared = job::prepare_text("test.inp", &drawn(material), &[], &Routines::none());
        let rendered = prepared.diagnostics.render(&prepared.deck.sources);
        assert!(rendered.contains("P017") && rendered.contains("isotropic hardening"), "{rendered}");
    }
}

/// Power law whose slope is unbounded at first yield, with optional slopes.
struct PowerLaw {
    slopes: bool,
}

impl UserHardening for PowerLaw {
    fn yield_stress(&mut self, call: &HardeningCall<'_>, answer: &mut HardeningAnswer<'_>) -> Result<(), LoadFailure> {
        let [start, factor, exponent] = [0, 1, 2].map(|i| call.properties[i]);
        for i in 0..call.count {
            answer.stress[i] = start + factor * call.strain[i].powf(exponent);
            answer.slopes[i] = if self.slopes { factor * exponent * call.strain[i].powf(exponent - 1.0) } else { 0.0 };
        }
        Ok(())
    }
}

/// A stretched tube passes first yield, where the exponent 0.02 makes the plastic strain of the first increment smaller
/// than 1e-30. The stress at the end is the yield stress at the plastic strain, to the tolerance of the return.
#[test]
fn yield_stress_with_unbounded_slope_passes_first_yield() {
    let law = "*Elastic\n 206000., 0.3\n*Plastic, hardening=USER, properties=3\n 8., 614., 0.02\n";
    let deck = pulled(law, " PEEQ, MISES\n");
    for slopes in [true, false] {
        let routines = Routines::none().with_hardening(PowerLaw { slopes });
        let (outcome, memory) = common::run(&deck, &[], &routines);
        assert_eq!(outcome.halt, None);
        let strain = column(&deck, &routines, &memory, "PEEQ@ONE");
        let stress = column(&deck, &routines, &memory, "MISES@ONE");
        let (strain, stress) = (strain[strain.len() - 1], stress[stress.len() - 1]);
        let expected = 8.0 + 614.0 * strain.powf(0.02);
        assert!(strain > 1e-3 && (stress / expected - 1.0).abs() < 1e-9, "{strain:e} {stress:e} {expected:e}");
    }
}
