//! User materials compared with built-in ones and closed forms.
//!
//! Goal: a VUMAT written for ABAQUS/Explicit gives the results of the same built-in law; errors are reported with a
//! place. Needs gfortran for Fortran files; without it those tests are left out, except in CI.

use std::fmt::Write as _;

use revolve::job;
use revolve::solve::Outcome;
use revolve::user::compile::compile;
use revolve::user::{LoadFailure, MaterialAnswer, MaterialCall, Routines, UserMaterial};

use crate::built_in_twin::GreenNaghdiHardening;
use crate::common;
use crate::common::RecordedOutput;
use crate::common::solid::grid;

fn fortran() -> bool {
    common::fortran("user materials in Fortran")
}

/// Compiles and loads a Fortran source; returns the error message otherwise.
pub fn compiled(source: &str) -> Result<Routines, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("material.f90");
    std::fs::write(&file, source).expect("a file");
    let rendered = |found: revolve::deck::Diagnostics| found.render(&revolve::deck::Sources::default());
    let library = compile(&[file], false).map_err(rendered)?;
    library.open().map_err(|d| format!("{} {}", d.code, d.message))
}

fn hardening() -> String {
    std::fs::read_to_string(common::project("input/vumat_hardening.f90")).expect("the example")
}

/// Returns the last value of a column.
pub fn last(text: &str, routines: &Routines, memory: &RecordedOutput, name: &str) -> f64 {
    let prepared = common::prepared(text, &[], routines);
    let at = prepared.plan.columns.iter().position(|c| c.name == name).expect("a column");
    memory.rows.last().expect("a row").1[at]
}

/// Returns a coarse Taylor bar of copper.
pub fn taylor(material: &str, variable: &str) -> String {
    let (n, m) = (5, 25);
    grid(n, m, false, |i, j| [i as f64 * 3.2e-3 / n as f64, j as f64 * 32.4e-3 / m as f64])
        + "*Solid Section, elset=SOLID, material=COPPER\n*Material, name=COPPER\n*Density\n 8930.\n"
        + material
        + "*Initial Conditions, type=VELOCITY\n ALL, 2, -227.\n*Nset, nset=CORNER\n 6,\n*Nset, nset=TIP\n 151,\n\
           *Elset, elset=FOOT\n 1,\n*Step\n*Dynamic, Explicit, element by element\n , 80.e-6\n*Boundary\n J0, 2, 2\n\
           *Output, history, number interval=20\n*Node Output, nset=CORNER\n U1\n*Node Output, nset=TIP\n U2\n\
           *Energy Output\n ALLIE, ALLPD, ALLSE\n*Element Output, elset=FOOT\n"
        + variable
        + ", S\n*Output, field, number interval=2\n*Element Output\n"
        + variable
        + "\n*End Step\n"
}

const BUILT_IN: &str = "*Elastic\n 117.e9, 0.35\n*Plastic\n 400.e6, 0.\n 900.e6, 5.\n";
const BY_USER: &str = "*User Material, constants=4\n 117.e9, 0.35, 400.e6, 100.e6\n*Depvar\n 1,\n";

/// The law in Fortran equals the same law in Rust, and the built-in law but for the rate of its stress: the axes of user
/// materials rotate by R of the polar decomposition, those of built-in laws with the spin.
#[test]
fn fortran_vumat_matches_the_law_in_rust_and_the_built_in_taylor_bar() {
    if !fortran() {
        return;
    }
    let (built_in, by_user) = (taylor(BUILT_IN, "PEEQ"), taylor(BY_USER, "SDV1"));
    let none = Routines::none();
    let [rust, routines] =
        [Routines::none().with_material(GreenNaghdiHardening), compiled(&hardening()).expect("it compiles")];
    let (known, with_jaumann_rate) = common::run(&built_in, &[], &none);
    let (expected, there) = common::run(&by_user, &[], &rust);
    let (got, here) = common::run(&by_user, &[], &routines);
    assert_eq!((&known.halt, &expected.halt, &got.halt), (&None, &None, &None));
    assert_eq!(expected.increments, got.increments);
    assert!(got.energy.drift < 2e-3 && (got.energy.drift / known.energy.drift - 1.0).abs() < 0.1, "{:?}", got.energy);
    for name in ["U1@CORNER", "U2@TIP", "ALLIE", "ALLPD", "SDV1@FOOT", "S22@FOOT", "ALLSE"] {
        let other = if name == "SDV1@FOOT" { "PEEQ@FOOT" } else { name };
        let built_in = last(&built_in, &none, &with_jaumann_rate, other);
        let expected = last(&by_user, &rust, &there, name);
        let got = last(&by_user, &routines, &here, name);
        println!("{name}: {expected:e}, ratio - 1 = {:e}, built-in {:e}", got / expected - 1.0, got / built_in - 1.0);
        // The same law with sums in another order; plastic flow amplifies rounding over 1000 increments.
        assert!((got / expected - 1.0).abs() < 1e-11, "{name}: {expected:e}, {got:e}");
    }
    // Displacements are those of the built-in law where the strains are large, but the shear is small.
    let length = |text: &str, routines: &Routines, memory: &RecordedOutput| last(text, routines, memory, "U2@TIP");
    let ratio = length(&by_user, &routines, &here) / length(&built_in, &none, &with_jaumann_rate);
    assert!((ratio - 1.0).abs() < 1e-3, "{ratio}");
    let state = here.frames.last().expect("a frame").cell_fields.iter().find(|f| f.name == "SDV1").expect("SDV1");
    let strain = there.frames.last().expect("a frame").cell_fields.iter().find(|f| f.name == "SDV1").expect("SDV1");
    assert_eq!(state.values.len(), 125);
    // Only the user subroutine knows the plastic strain of its material.
    let fields = &here.frames.last().expect("a frame").cell_fields;
    assert!(fields.iter().all(|f| f.name != "PEEQ" && f.name != "PE"));
    assert!(state.values.iter().zip(&strain.values).all(|(a, b)| (a - b).abs() < 1e-11));
}

/// The example deck has the depth of `taylor_copper.inp`, both with increments by elements and with the global estimate. The
/// objective rates of the stress differ: 1e-4 (2.5e-5).
#[test]
fn example_deck_matches_the_built_in_example() {
    if !fortran() {
        return;
    }
    let depth = |deck: &str, option: &str, settings: &[(&str, &str)], routines: &Routines| {
        let text = std::fs::read_to_string(common::project(deck)).expect("the deck");
        let text = text.replace("Explicit, element by element\n", "Explicit\n");
        let text = text.replacen("*Material,", "*Remesh, automatic=NO\n*Material,", 1);
        let text = text.replace("*Dynamic, Explicit\n", &format!("*Dynamic, Explicit{option}\n"));
        let prepared = job::prepare_text(deck, &text, &common::pairs(settings), routines);
        assert!(!prepared.diagnostics.has_errors(), "{}", prepared.diagnostics.render(&prepared.deck.sources));
        let (outcome, summary) = job::run_in_memory(&prepared);
        assert_eq!(outcome.halt, None);
        let depth = serde_json::to_value(&summary).expect("JSON")["U2@TIP"]["final"].as_f64().expect("a depth");
        (outcome.increments, depth)
    };
    let routines = compiled(&hardening()).expect("it compiles");
    let counts = [", element by element", ""].map(|option| {
        let coarse = [("nr", "5"), ("nz", "25")];
        let (count, expected) = depth("input/taylor_copper.inp", option, &coarse, &Routines::none());
        let (increments, got) = depth("input/taylor_vumat.inp", option, &[], &routines);
        assert!(increments.abs_diff(count) <= count / 1000, "{increments} {count}");
        assert!(expected < -0.01 && (got / expected - 1.0).abs() < 1e-4, "{got} {expected}");
        count
    });
    assert!(counts[1] < counts[0], "{counts:?}");
}

/// Elastic, with the stress computed from a strain in the state variables, which is correct only if they rotate with
/// the material. The following state variables store the values received: deformation gradient, stretch, density,
/// length. Fails if its strain exceeds a limit.
pub struct StrainRecorder {
    pub limit: f64,
}

impl UserMaterial for StrainRecorder {
    fn stress(&mut self, call: &MaterialCall<'_>, answer: &mut MaterialAnswer<'_>) -> Result<(), LoadFailure> {
        let n = call.count;
        let (bulk, shear2) = (call.properties[0], 2.0 * call.properties[1]);
        for i in 0..n {
            let strain = [0, 1, 2, 3].map(|k| call.state[k * n + i] + call.strain[k * n + i]);
            let mean = (strain[0] + strain[1] + strain[2]) / 3.0;
            for (k, &part) in strain.iter().enumerate() {
                let dilation = if k < 3 { mean } else { 0.0 };
                answer.stress[k * n + i] = 3.0 * bulk * dilation + shear2 * (part - dilation);
                answer.state[k * n + i] = part;
            }
            let shown = call.gradient[1].chunks(n).chain(call.stretch[1].chunks(n)).chain([call.density, call.length]);
            for (k, list) in shown.enumerate() {
                answer.state[(4 + k) * n + i] = list[i];
            }
            let there = strain[1] < self.limit && call.state[15 * n + i] == 1.0;
            answer.state[15 * n + i] = if there { 1.0 } else { 0.0 };
        }
        Ok(())
    }
}

pub const KEEPING: &str =
    "*User Material, constants=2\n 833.3333333333334, 384.6153846153846\n*Depvar, delete=16\n 16,\n";

/// Returns a grid of 2 by 2 elements from r = 1 to 3, z = 0 to 2, with prescribed velocities at all nodes.
pub fn moving(velocity: impl Fn([f64; 2]) -> [f64; 2], material: &str, outputs: &str) -> String {
    let place = |i: usize, j: usize| [1.0 + i as f64, j as f64];
    let mut deck = grid(2, 2, false, place)
        + "*Elset, elset=ONE\n 1,\n*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n 2.,\n"
        + material;
    for node in 1..=9 {
        write!(deck, "*Nset, nset=N{node}\n {node},\n").expect("text");
    }
    deck += "*Step\n*Dynamic, Explicit, direct user control\n 1.e-3, 1.\n*Boundary, type=VELOCITY\n";
    for node in 0..9 {
        let [v_r, v_z] = velocity(place(node % 3, node / 3));
        write!(deck, " N{}, 1, 1, {v_r:e}\n N{}, 2, 2, {v_z:e}\n", node + 1, node + 1).expect("text");
    }
    deck + "*Output, history, number interval=10\n*Element Output, elset=ONE\n" + outputs + "*End Step\n"
}

/// Simple shear of 1 with the Green-Naghdi rate (Dienes 1979, Acta Mech. 32, 217): tan b = 1/2. 1e-6: midpoint rule with
/// 1000 increments.
#[test]
fn tensor_state_variables_rotate_with_the_material() {
    let by_user = moving(|[r, _]| [0.0, r], KEEPING, " S, SDV\n*Energy Output\n ETOTAL\n");
    let routines = Routines::none().with_material(StrainRecorder { limit: f64::INFINITY });
    let (outcome, here) = common::run(&by_user, &[], &routines);
    assert_eq!(outcome.halt, None);
    let (shear, b) = (384.6153846153846, 0.5_f64.atan());
    let (double, log) = (2.0 * b, b.cos().ln());
    let normal = 4.0 * shear * (double.cos() * log + b * double.sin() - b.sin().powi(2));
    let along = 2.0 * shear * (double.cos() * (double - b.tan()) - 2.0 * double.sin() * log);
    for (component, expected) in [("S11", -normal), ("S22", normal), ("S33", 0.0), ("S12", along)] {
        let got = last(&by_user, &routines, &here, &format!("{component}@ONE"));
        assert!((expected - got).abs() < 1e-6 * shear, "{component}: {expected} {got}");
    }
    let state = |k: usize| last(&by_user, &routines, &here, &format!("SDV{k}@ONE"));
    // Deformation gradient of simple shear by 1: rr, zz, hoop, rz, zr.
    for (k, expected) in [1.0, 1.0, 1.0, 0.0, 1.0].into_iter().enumerate() {
        assert!((state(5 + k) - expected).abs() < 1e-12, "F{k} {}", state(5 + k));
    }
    // Its stretch: C = [2, 1; 1, 1] has the root [3, 1; 1, 2] / sqrt(5).
    for (k, expected) in [3.0, 2.0, 5_f64.sqrt(), 1.0].into_iter().enumerate() {
        assert!((state(10 + k) - expected / 5_f64.sqrt()).abs() < 1e-12, "U{k} {}", state(10 + k));
    }
    assert!((state(14) - 2.0).abs() < 1e-12 && (state(15) - 1.0).abs() < 1e-12, "density and length");
    // Drift by the sudden start of the motion.
    assert!(outcome.energy.drift < 1e-3, "{:e}", outcome.energy.drift);
}

/// Returns the values of a column.
fn column(text: &str, routines: &Routines, memory: &RecordedOutput, name: &str) -> Vec<f64> {
    let prepared = common::prepared(text, &[], routines);
    let at = prepared.plan.columns.iter().position(|c| c.name == name).expect("a column");
    memory.rows.iter().map(|row| row.1[at]).collect()
}

#[test]
fn deletion_variable_deletes_an_element_permanently() {
    // A stretched bar: its strain reaches 0.2 at the stretch exp(0.2), at t = 0.2214 for a rate of one length per time.
    let deck = moving(|[_, z]| [0.0, z], KEEPING, " S22, STATUS, SDV16, SENER\n*Energy Output\n ALLIE, ETOTAL\n");
    let routines = Routines::none().with_material(StrainRecorder { limit: 0.2 });
    let (outcome, memory) = common::run(&deck, &[], &routines);
    assert_eq!(outcome.halt, None);
    let rows = |name: &str| column(&deck, &routines, &memory, name);
    let (stress, status) = (rows("S22@ONE"), rows("STATUS@ONE"));
    assert_eq!(status, rows("SDV16@ONE"));
    let expected: Vec<f64> = memory.rows.iter().map(|r| if r.0 < 0.2214 { 1.0 } else { 0.0 }).collect();
    assert_eq!(status, expected);
    assert!(stress[2] > 100.0 && stress[3..].iter().all(|s| *s == 0.0), "{stress:?}");
    // The internal energy of the deleted element stays in the energy balance; its forces vanish between two increments
    // of 1e-3.
    let internal = rows("ALLIE");
    assert!(internal[3..].iter().all(|e| *e == internal[3]) && internal[3] > 0.0, "{internal:?}");
    assert!(outcome.energy.drift < 2e-3, "{:?}", outcome.energy);
}

/// Runs a deck with a Fortran material that halts.
fn halted(source: &str) -> Outcome {
    let routines = compiled(source).expect("it compiles");
    common::run(&taylor(BY_USER, "SDV1"), &[], &routines).0
}

#[test]
fn errors_of_a_subroutine_are_located() {
    if !fortran() {
        return;
    }
    let good = hardening();
    let later = |statement: &str| {
        good.replace("end subroutine", &format!("if (totalTime > 1.d-6) {statement}\nend subroutine"))
    };
    let cases = [
        (
            "a stress that is none",
            later("stressNew(7,2) = sqrt(-1.d0*totalTime)"),
            vec!["element 7", "stressNew(k, 2)", "increment"],
        ),
        (
            "an energy that is infinite",
            later("enerInelasNew(9) = 1.d0/(dt - dt)"),
            vec!["element 9", "enerInelasNew", "inf"],
        ),
        ("past the block", later("stressNew(nblock+1,4) = 0.d0"), vec!["past the nblock = 125", "stressNew"]),
        ("state past the block", later("stateNew(nblock+3,1) = 0.d0"), vec!["past the nblock = 125", "stateNew"]),
        ("the name", later("cmname = 'X'"), vec!["cmname"]),
        ("STOP", later("stop 'out of table'"), vec!["STOP out of table", "COPPER", "increment"]),
        ("nothing elastic", good.replace("bulk = ", "bulk = 0.d0*"), vec!["time zero", "bulk modulus", "element 1"]),
    ];
    for (name, source, words) in cases {
        assert_ne!(source, good, "{name}");
        let halt = halted(&source).halt.unwrap_or_else(|| panic!("{name}: it must halt"));
        assert_eq!(halt.code(), "R201", "{name}: {halt:?}");
        for word in words {
            assert!(halt.message().contains(word), "{name}: `{word}` in {}", halt.message());
        }
    }
    let short = compiled(&good.replace("tempNew, stretchNew, ", "stretchNew, ").replace("tempNew(nblock), ", ""));
    let rendered = short.err().expect("it is rejected");
    assert!(
        rendered.contains("U004") && rendered.contains("32 arguments") && rendered.contains("tempNew"),
        "{rendered}"
    );
}

#[test]
fn errors_of_a_deck_are_reported_with_a_place() {
    let routines = Routines::none().with_material(StrainRecorder { limit: 1.0 });
    let refused = |material: &str, routines: &Routines| {
        let prepared = job::prepare_text("test.inp", &taylor(material, "SDV1"), &[], routines);
        assert!(prepared.diagnostics.has_errors(), "{material}");
        prepared.diagnostics.render(&prepared.deck.sources)
    };
    let cases = [
        ("*User Material, constants=3\n 1., 2.\n", "M103", "found 2 constants"),
        ("*User Material\n 1.\n", "M101", "CONSTANTS"),
        ("*User Material, constants=1, type=THERMAL\n 1.\n", "M10", "THERMAL"),
        ("*User Material, constants=1, effmod\n 1.\n", "M10", "EFFMOD"),
        ("*User Material, constants=1\n 1.\n*Depvar, delete=2\n 1,\n", "M103", "DELETE must be from 1 to 1, found 2"),
        ("*User Material, constants=1\n 1.\n*Depvar\n -1,\n", "M103", "state variables"),
        ("*User Material, constants=1\n 1.\n*Elastic\n 1., 0.3\n", "P041", "in addition to"),
    ];
    for (material, code, words) in cases {
        let rendered = refused(material, &routines);
        assert!(
            rendered.contains(code) && rendered.contains(words) && rendered.contains("test.inp:"),
            "{material}:\n{rendered}"
        );
    }
    let rendered = refused(BY_USER, &Routines::none());
    assert!(rendered.contains("P004") && rendered.contains("vumat"), "{rendered}");
}
