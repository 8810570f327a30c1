//! Derivatives of quantities by parameters: `revolve sensitivity`.
//!
//! Source: the closed form of the embedded ogive, differences of shots by stages, the Taylor bar with finer differences.

use std::fs;

use revolve::study::evaluate::{DeckSource, SampleEvaluator, UserRoutines};
use revolve::study::quantity::Quantity;
use serde_json::Value;

use crate::common::{self, revolve};

const DEPTH: &str = "-1000*final(U2@REF)";

fn evaluator(text: &str, names: &[&str], quantities: &[&str]) -> SampleEvaluator {
    let source = DeckSource::Text("shot.inp".into(), text.to_owned());
    let names = names.iter().map(|name| (*name).to_owned()).collect();
    let quantities = quantities.iter().map(|text| Quantity::parse(text).expect("a quantity")).collect();
    SampleEvaluator::new(source, Vec::new(), names, quantities, UserRoutines::Absent).expect("an evaluator")
}

fn sensitivity(words: &[&str]) -> (Value, String, Option<i32>) {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().to_str().expect("a name");
    let output = revolve(&[&["sensitivity"], words, &["--json", "--out", out]].concat());
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    (serde_json::from_slice(&output.stdout).unwrap_or_default(), message, output.status.code())
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// Source: derivatives of P = m/(2β) ln(1 + βV²/α) by the logarithms of its parameters. The facets of the nose have an
/// error of 1e-6.
#[test]
fn embedded_ogive_matches_closed_form() {
    let words = ["input/ogive.inp", "--set", "front=0.1", "--set", "n=1000", "--of", DEPTH, "--to", "V,A,mass,C,Y"];
    let (object, message, status) = sensitivity(&words);
    assert_eq!(status, Some(0), "{message}");
    let quantity = &object["quantities"][0];
    assert!((number(&quantity["value"]) / 59.612643939 - 1.0).abs() < 1e-6, "{quantity}");
    // Y multiplies the same force as A.
    for (entry, expected) in [115.4935914, -57.7467957, 59.6126439, -1.8658482, -57.7467957].into_iter().enumerate() {
        let parameter = &quantity["parameters"][entry];
        assert_eq!(parameter["method"], "stages");
        let found = number(&parameter["logarithmic"]["value"]);
        assert!((found / expected - 1.0).abs() < 1e-6, "{parameter}");
        assert!(number(&parameter["logarithmic"]["uncertainty"]) < 1e-8 * expected.abs());
        let by_parameter = number(&parameter["derivative"]["value"]) * number(&parameter["at"]);
        assert!((by_parameter / found - 1.0).abs() < 1e-12);
    }
}

/// Source: differences of fourth order of the same shots, for entry, exit and rest, friction, laws with and without terms
/// of V, and quantities that are no linear function of columns.
#[test]
fn shots_by_stages_match_differences() {
    let names = ["V", "A", "mass", "C", "Y", "rho", "friction", "B"];
    let quantities =
        ["final(U2@REF)", "final(V2@REF)**2", "final(ALLKE)/final(ETOTAL)", "final(A2@REF)", "exp(10*final(U2@REF))"];
    let text = common::ogive();
    for (linear, friction, thickness, duration) in [
        (0.0, 0.05, "0.5", "1.e-3"),
        (0.7, 0.05, "0.5", "1.e-3"),
        (0.0, 0.1, "0.02", "1.e-3"),
        (0.7, 0.02, "0.02", "1.e-3"),
        (0.0, 0.02, "0.5", "6.e-5"),
        (0.7, 0.02, "0.5", "6.e-5"),
    ] {
        let text = text
            .replace("B = 0.\n", &format!("B = {linear}\n"))
            .replace("friction = 0.\n", &format!("friction = {friction}\n"))
            .replace(" AL6061, 0.5", &format!(" AL6061, {thickness}"))
            .replace(" , 1.e-3", &format!(" , {duration}"));
        let evaluator = evaluator(&text, &names, &quantities);
        let point: Vec<f64> = evaluator.nominal_values().iter().map(|value| value.expect("a number")).collect();
        let exact = evaluator.derivatives(&point).expect("shots by stages").expect("derivatives");
        for (parameter, value) in point.iter().enumerate() {
            let step = if *value == 0.0 { 1e-3 } else { 1e-3 * value };
            let moved = |steps: f64| {
                let mut sample = point.clone();
                sample[parameter] += steps * step;
                let (table, failures) = evaluator.table(&sample, 1).expect("threads");
                assert_eq!(failures, []);
                table
            };
            // The law without a term of V has no values of B below zero.
            let stencil = if *value == 0.0 {
                [(0.0, -25.0), (1.0, 48.0), (2.0, -36.0), (3.0, 16.0), (4.0, -3.0)]
            } else {
                [(0.0, 0.0), (1.0, 8.0), (-1.0, -8.0), (2.0, -1.0), (-2.0, 1.0)]
            };
            let rows = stencil.map(|(steps, weight)| (weight, moved(steps)));
            for (quantity, text) in quantities.iter().enumerate() {
                let sum: f64 = rows.iter().map(|(weight, row)| weight * row[quantity]).sum();
                let difference = sum / (12.0 * step) * value.abs().max(1.0);
                let found = exact.slopes[quantity][parameter] * value.abs().max(1.0);
                let scale = exact.values[quantity].abs().max(found.abs()).max(1e-12);
                let name = names[parameter];
                assert!((found - difference).abs() < 1e-8 * scale, "{name} {text}: {found} {difference}");
            }
        }
    }
}

/// A parameter of the geometry has companion runs, which agree with the exact derivatives of others. The same quantity
/// integrated in increments has the same derivatives within its uncertainty. A parameter with the value zero needs a
/// step, and one that must not be negative is changed to one side.
#[test]
fn companion_runs_match_exact_derivatives() {
    let deck = ["input/ogive.inp", "--set", "n=40", "--of", DEPTH];
    let logarithmic = |words: &[&str], entry: usize| {
        let (object, message, status) = sensitivity(&[&deck[..], words].concat());
        assert_eq!(status, Some(0), "{message}");
        let parameter = object["quantities"][0]["parameters"][entry].clone();
        (number(&parameter["logarithmic"]["value"]), number(&parameter["logarithmic"]["uncertainty"]), parameter)
    };
    for (entry, name) in ["V", "A", "mass"].into_iter().enumerate() {
        let exact = logarithmic(&["--to", "V,A,mass"], entry);
        let (slope, uncertainty, parameter) = logarithmic(&["--to", name, "--in-increments"], 0);
        assert_eq!((&exact.2["method"], &parameter["method"]), (&"stages".into(), &"differences".into()));
        assert!((slope - exact.0).abs() <= uncertainty.max(2e-5 * exact.0.abs()), "{name}: {slope} {exact:?}");
        assert!(uncertainty < 2e-3 * slope.abs(), "{name}: {parameter}");
    }
    // Without entry P is proportional to 1/a² for a given radius in calibres: N2 does not depend on the radius.
    let (slope, uncertainty, parameter) = logarithmic(&["--set", "front=0.1", "--to", "a"], 0);
    assert_eq!(parameter["method"], "differences");
    assert!((slope + 2.0 * 59.6126).abs() < uncertainty.max(0.01), "{parameter}");
    let (_, message, status) = sensitivity(&[&deck[..], &["--in-increments", "--to", "friction"]].concat());
    assert!(status == Some(2) && message.contains("--step friction=0.01"), "{message}");
    let exact = logarithmic(&["--to", "friction"], 0).2;
    let (_, _, stepped) = logarithmic(&["--in-increments", "--to", "friction", "--step", "friction=0.01"], 0);
    assert_eq!((&exact["method"], &stepped["method"]), (&"stages".into(), &"one-sided".into()));
    let [exact, one_sided] = [&exact, &stepped].map(|of| number(&of["derivative"]["value"]));
    let uncertainty = number(&stepped["derivative"]["uncertainty"]);
    assert!((exact - one_sided).abs() < uncertainty && uncertainty < 0.02 * exact.abs(), "{exact} {stepped}");
}

/// Source: the slope of a straight line through 40 lengths with yield stresses within 0.5 %.
#[test]
fn taylor_bar_matches_reference() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = fs::read_to_string(common::project("input/taylor_copper.inp")).expect("a deck");
    let text = text.replace("nr = 10", "nr = 6\nY = 400.e6").replace("nz = 50", "nz = 30");
    let text = text.replace("400.e6, 0.", "<Y>, 0.");
    let deck = folder.path().join("taylor.inp");
    fs::write(&deck, text).expect("a deck");
    let deck = deck.to_str().expect("a name");
    let (object, message, status) = sensitivity(&[deck, "--of", "1000*final(COOR2@TIP)", "--to", "Y"]);
    assert_eq!(status, Some(0), "{message}");
    let parameter = &object["quantities"][0]["parameters"][0];
    let [slope, uncertainty] = ["value", "uncertainty"].map(|part| number(&parameter["logarithmic"][part]));
    assert!((slope / 5.802 - 1.0).abs() < 0.01, "{parameter}");
    assert!((slope - 5.802).abs() < uncertainty && uncertainty < 0.02 * slope, "{parameter}");
}

/// The velocity of a rod after it has perforated a plate whose elements are deleted follows no smooth curve. Source: its scatter over 60
/// friction coefficients within 6 % exceeds the trend.
#[test]
fn derivatives_below_the_noise_are_left_out() {
    let mesh = ["--set", "nr=2", "--set", "nz=10", "--set", "mr=10", "--set", "mz=5"];
    let words = ["input/rod_plate_deletion.inp", "--of", "final(V2@TAIL)", "--to", "mu"];
    let (object, message, status) = sensitivity(&[&words[..], &mesh].concat());
    assert!(status == Some(1) && message.contains("warning: R322: final(V2@TAIL): "), "{message}");
    let quantity = &object["quantities"][0];
    let parameter = &quantity["parameters"][0];
    assert!(parameter["derivative"].is_null() && parameter["logarithmic"].is_null(), "{parameter}");
    assert!(parameter["reason"].as_str().is_some_and(|reason| reason.contains("|dQ/d ln mu| is below")));
    assert!(number(&quantity["noise"]) > 0.0 && number(&parameter["deviation"]) > 0.0, "{quantity}");
}

/// A coarser mesh changes the derivative, and the change is that of two commands.
#[test]
fn change_on_a_coarser_mesh_is_that_of_two_commands() {
    let deck = ["input/taylor_copper.inp", "--set", "nr=4", "--set", "nz=20", "--of", "1000*final(COOR2@TIP)"];
    let run = |words: &[&str]| {
        let (object, message, status) = sensitivity(&[&deck[..], &["--to", "length"], words].concat());
        assert_eq!(status, Some(0), "{message}");
        let parameter = object["quantities"][0]["parameters"][0].clone();
        (number(&parameter["logarithmic"]["value"]), parameter["mesh"].clone())
    };
    let [(fine, none), (coarse, _), (same, change)] =
        [&[][..], &["--set", "mesh=1/2"], &["--coarser", "mesh=1/2"]].map(run);
    assert!(none.is_null() && same == fine);
    assert_eq!(number(&change), (fine - coarse).abs());
}

#[test]
fn invalid_requests_name_the_option() {
    let deck = ["input/ogive.inp", "--of", DEPTH];
    for (words, expected) in [
        (&["--to", "speed"][..], "the deck defines no parameter speed"),
        (&["--to", "V,V"], "--to V: the parameter is given twice"),
        (&["--to", "V", "--step", "A=1"], "--step A=1: expected a parameter of --to"),
        (&["--to", "V", "--step", "V=x"], "--step V=x: expected a number"),
        (&["--to", "a", "--step", "a=-1"], "--step a=-1: expected a number above zero"),
        (&["--to", "V", "--coarser", "V=1"], "--coarser V=1: --to has the same parameter"),
        (&["--to", "n"], "8 of 8 runs with changes of n gave no result"),
        (&["--to", "V", "--of", "final(X)"], "final(X)"),
    ] {
        let (_, message, status) = sensitivity(&[&deck[..], words].concat());
        assert!(status == Some(2) && message.contains(expected), "{words:?}: {message}");
    }
}
