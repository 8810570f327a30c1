//! Identification of deck parameters from shots, histories and outlines.
//!
//! Sources: parameters used to make the measurements; Student's t for a linear model; nodes on the outline of a bar.

use std::fs;
use std::path::Path;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore as _, SeedableRng as _};
use revolve::study::evaluate::{DeckSource, SampleEvaluator, UserRoutines};
use revolve::study::identify::data::{MeasuredData, Observation};
use revolve::study::identify::posterior::{Posterior, PosteriorRequest, posterior};
use revolve::study::identify::{IdentificationProblem, UnknownParameter, sentences};
use revolve::study::quantity::Quantity;
use revolve::study::statistics::least_squares::ParameterFit;
use revolve::study::statistics::{IntervalEstimate, design, normal};
use serde_json::Value;

use crate::common::{project, revolve};

const DEPTH: &str = "-1000*final(U2@REF)";
/// A body that is thrown upwards: U2 = v t - g t²/2, without error of the time integration.
const THROW: &str = "*Heading
 Throw
*Parameter
v = 10.
g = 9.81
*Node, nset=REF
 1, 0., 0.
*Node
 2, 0., 0.
 3, 1., 0.
*Element, type=RAX2, elset=DISC
 1, 2, 3
*Element, type=MASS, elset=M
 2, 1
*Mass, elset=M
 1.,
*Rigid Body, ref node=1, elset=DISC
*Initial Conditions, type=VELOCITY
 REF, 2, <v>
*Step
*Dynamic, Explicit, Direct User Control
 0.1, 1.
*Dload
 M, GRAV, <g>, 0., -1.
*Output, history, frequency=1
*Node Output, nset=REF
 U2
*End Step
";

fn json(words: &[&str]) -> Value {
    let output = revolve(&[words, &["--json"]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("an object")
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// Returns normal numbers with mean 0 and deviation 1.
fn normals(seed: u64) -> impl FnMut() -> f64 {
    let mut draws = ChaCha8Rng::seed_from_u64(seed);
    move || normal::quantile(design::unit(draws.next_u64()))
}

fn evaluator(source: DeckSource, names: &[String], quantities: Vec<Quantity>) -> SampleEvaluator {
    SampleEvaluator::new(source, Vec::new(), names.to_vec(), quantities, UserRoutines::Absent).expect("an evaluator")
}

fn unknowns(given: &[(&str, f64, Option<[f64; 2]>)]) -> Vec<UnknownParameter> {
    given
        .iter()
        .map(|(name, start, bounds)| UnknownParameter { name: (*name).into(), start: *start, bounds: *bounds })
        .collect()
}

/// Returns the problem for a deck.
fn problem<'a>(
    source: DeckSource,
    data: &'a MeasuredData,
    unknowns: &'a [UnknownParameter],
) -> IdentificationProblem<'a> {
    let names: Vec<String> = data.names.iter().cloned().chain(unknowns.iter().map(|u| u.name.clone())).collect();
    let quantities = data.parsed_quantities().expect("quantities");
    IdentificationProblem::new(evaluator(source, &names, quantities), data, unknowns, 2)
}

/// Returns shots of the ogive with the parameters of its deck, with normal errors of 1.5 mm.
fn shots(seed: u64) -> MeasuredData {
    let velocities: Vec<f64> = (0..8).map(|i| 500.0 + 80.0 * f64::from(i)).collect();
    let quantity = Quantity::parse(DEPTH).expect("a quantity");
    let ogive = evaluator(DeckSource::File(project("input/ogive.inp")), &["V".into()], vec![quantity]);
    let (depths, failures) = ogive.table(&velocities, 2).expect("threads");
    assert!(failures.is_empty());
    let mut normals = normals(seed);
    let observation = |(shot, depth): (usize, &f64)| Observation {
        shot,
        series: 0,
        abscissa: None,
        quantity: 0,
        value: depth + 1.5 * normals(),
        deviation: 1.0,
    };
    MeasuredData {
        names: vec!["V".into()],
        shots: velocities.into_iter().map(|v| vec![v]).collect(),
        series: vec!["depth".into()],
        has_deviations: vec![false],
        observations: depths.iter().enumerate().map(observation).collect(),
        quantities: [DEPTH.to_owned()].into_iter().collect(),
    }
}

fn fitted(seed: u64, unknown: &[(&str, f64, Option<[f64; 2]>)]) -> ParameterFit {
    let (data, unknowns) = (shots(seed), unknowns(unknown));
    let problem = problem(DeckSource::File(project("input/ogive.inp")), &data, &unknowns);
    problem.fit(1).expect("a fit").best
}

/// A 95 % interval contains the true A in 19 of 20 tables.
#[test]
fn true_resistance_is_within_the_confidence_interval() {
    let inside = (1..=20).filter(|seed| {
        let fit = fitted(*seed, &[("A", 4.0, None)]);
        let found = fit.estimates()[0];
        assert!(fit.converged && fit.freedom == 7 && found.high - found.low < 1.0, "{fit:?}");
        found.holds(5.0394)
    });
    let inside = inside.count();
    println!("A is inside in {inside} of 20 tables");
    assert!(inside >= 19, "{inside}");
}

/// A and friction have nearly the same effect on the depth: the shots determine little but their sum, which is
/// reported.
#[test]
fn unidentifiable_parameters_are_reported() {
    let names = ["A".to_owned(), "friction".to_owned()];
    let fit = fitted(3, &[("A", 4.0, None), ("friction", 0.02, None)]);
    let correlation = fit.correlation(0, 1).expect("a covariance");
    assert!(correlation < -0.95, "{correlation}");
    let message_text = sentences(&fit, &names).join("\n");
    assert!(message_text.contains("A and friction are hardly distinguishable"), "{message_text}");
    let alone = fitted(3, &[("A", 4.0, None)]).estimates()[0];
    let both = fit.estimates()[0];
    assert!(both.high - both.low > 3.0 * (alone.high - alone.low), "{both:?} {alone:?}");
}

/// Bounds limit the fit, and fits from random points within them find the same minimum.
#[test]
fn fits_from_several_starts_stay_within_the_bounds() {
    let (data, unknowns) = (shots(2), unknowns(&[("A", 3.0, Some([2.0, 4.0]))]));
    let problem = problem(DeckSource::File(project("input/ogive.inp")), &data, &unknowns);
    let fits = problem.fit(4).expect("a fit");
    assert!((fits.best.values[0] - 4.0).abs() < 0.05 && fits.best.edges == [0], "{fits:?}");
    assert!(fits.starts == 4 && fits.same >= 1);
    let free = self::unknowns(&[("A", 3.0, None)]);
    let problem = self::problem(DeckSource::File(project("input/ogive.inp")), &data, &free);
    assert!(problem.fit(2).is_err_and(|e| e.to_string().contains("--unknown A=low..high")));
}

/// Returns a history of the throw with normal errors.
fn throw(seed: u64, deviation: f64) -> MeasuredData {
    let mut normals = normals(seed);
    let mut data = MeasuredData {
        shots: vec![Vec::new()],
        series: vec!["height".into()],
        has_deviations: vec![false],
        ..MeasuredData::default()
    };
    for i in 1..=10_i32 {
        let t = 0.1 * f64::from(i);
        let value = 10.0 * t - 0.5 * 9.81 * t * t + deviation * normals();
        let (quantity, _) = data.quantities.insert_full(format!("at(U2@REF, {t:?})"));
        data.observations.push(Observation { shot: 0, series: 0, abscissa: Some(t), quantity, value, deviation: 1.0 });
    }
    data
}

fn throw_posterior(data: &MeasuredData, effective: f64) -> (Vec<IntervalEstimate>, Posterior) {
    let unknowns = unknowns(&[("v", 8.0, None), ("g", 5.0, None)]);
    let problem = problem(DeckSource::Text("throw.inp".into(), THROW.into()), data, &unknowns);
    let fit = problem.fit(1).expect("a fit").best;
    let request = PosteriorRequest { effective, most_runs: 2_000_000, seed: 1, model_error: false };
    let found = posterior(&problem, &fit, request, &|_| {}).expect("a posterior");
    assert!(found.converged && found.worst_r_hat() < 1.01 && found.least_effective() >= effective);
    (fit.estimates(), found)
}

/// For a linear model with the prior 1/s of an unknown standard deviation the posterior is Student's t distribution of
/// the least squares (Gelman and others, Bayesian Data Analysis, section 14.2). The prediction band
/// contains new measurements of the model.
#[test]
fn posterior_of_a_linear_model_is_students_t() {
    let data = throw(1, 0.05);
    let (fit, found) = throw_posterior(&data, 2000.0);
    for (exact, sampled) in fit.iter().zip(found.estimates()) {
        let width = exact.high - exact.low;
        let errors = [sampled.low - exact.low, sampled.value - exact.value, sampled.high - exact.high];
        println!("relative errors of the ends and the median: {:?}", errors.map(|e| e / width));
        assert!(errors.iter().all(|e| e.abs() < 0.05 * width), "{exact:?} {sampled:?}");
    }
    let again = throw_posterior(&data, 2000.0).1;
    assert_eq!(found.draws[17], again.draws[17]);
    let inside = (2..=41).flat_map(|seed| {
        let new = throw(seed, 0.05).observations;
        new.into_iter()
            .zip(&found.predictions)
            .map(|(o, [low, high])| (*low..=*high).contains(&o.value))
            .collect::<Vec<_>>()
    });
    let inside = inside.filter(|inside| *inside).count();
    println!("{inside} of 400 new measurements are inside the band");
    assert!(inside >= 360, "{inside}");
}

/// 95 % posterior intervals contain the true values in 19 of 20 synthetic tables.
#[test]
fn posterior_intervals_have_their_nominal_coverage() {
    let inside = |seed: u64| {
        let found = throw_posterior(&throw(seed, 0.05), 100.0).1.estimates();
        found.iter().zip([10.0, 9.81]).filter(|(estimate, truth)| estimate.holds(*truth)).count()
    };
    let inside: usize = (100..120).map(inside).sum();
    println!("{inside} of 40 posterior intervals contain the true value");
    assert!(inside >= 37, "{inside}");
}

/// The largest radius at the height of a node on the side of a bar is the radius of that node.
#[test]
fn outline_passes_through_the_nodes_of_the_side() {
    let bar = |quantities: &[String]| {
        let quantities = quantities.iter().map(|text| Quantity::parse(text).expect("a quantity")).collect();
        let deck = DeckSource::File(project("input/validation/taylor_bar.inp"));
        let (fixed, names) = (vec![("nr".into(), "4".into())], vec!["V".into()]);
        let evaluator = SampleEvaluator::new(deck, fixed, names, quantities, UserRoutines::Absent);
        evaluator.expect("an evaluator").table(&[120.0], 1).expect("a thread")
    };
    let (nodes, _) = bar(&["COOR1@25", "COOR2@25", "COOR1@50", "COOR2@50"].map(|column| format!("final({column})")));
    let (radii, _) = bar(&[nodes[1], nodes[3]].map(|z| format!("outline({z:?})")));
    for (radius, node) in radii.iter().zip([nodes[0], nodes[2]]) {
        assert!((radius / node - 1.0).abs() < 1e-12, "{radius} {node}");
    }
    let (_, failures) = bar(&["outline(1)".to_owned()]);
    assert!(failures[0].reason.to_string().contains("no deformable element is at the height"));
}

/// Velocity histories and depths of two shots, computed with A = 5.0394 and C = 0.983, determine both constants.
#[test]
fn histories_and_depths_together_determine_the_constants() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).to_str().expect("a name").to_owned();
    let mut table = "V,history,depth\n".to_owned();
    for velocity in ["600", "1000"] {
        let out = at(velocity);
        let run = ["run", "input/ogive.inp", "--set", &format!("V={velocity}"), "--out", &out, "--no-frames", "-q"];
        assert!(revolve(&run).status.success());
        let history = fs::read_to_string(Path::new(&out).join("ogive_history.csv")).expect("a history");
        let mut rows = history.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let header = rows.next().expect("a header");
        let column = |name: &str| header.iter().position(|c| *c == name).expect("a column");
        let (speed, depth) = (column("V2@REF"), column("U2@REF"));
        let rows: Vec<Vec<&str>> = rows.collect();
        let number = |text: &str| text.parse::<f64>().expect("a number");
        let points = rows.iter().step_by(4).map(|row| format!("{},{}\n", 1e6 * number(row[0]), row[speed]));
        fs::write(at(&format!("{velocity}.csv")), format!("us,v\n{}", points.collect::<String>())).expect("a curve");
        let last = number(rows.last().expect("a row")[depth]);
        table += &format!("{velocity},{velocity}.csv,{}\n", -1000.0 * last);
    }
    fs::write(at("shots.csv"), table).expect("a table");
    let (file, out) = (at("shots.csv"), at("out"));
    let words = ["identify", "input/ogive.inp", "--shots", &file, "--out", &out, "--unknown", "A=2..8,C=0.5..1.5"];
    let depth = ["--measured", "depth", "--quantity", DEPTH, "--deviation", "1"];
    let curve = ["--curve", "history=at(V2@REF, {x}*1e-6)"];
    let found = json(&[&words[..], &depth, &curve, &["--deviation", "5", "--starts", "3"]].concat());
    for (name, exact) in [("A", 5.0394), ("C", 0.983)] {
        let value = number(&found["estimates"][name]["value"]);
        assert!((value / exact - 1.0).abs() < 1e-4, "{name} {value}");
    }
    for file in ["ogive_identify.png", "ogive_identify_2.png", "ogive_identify_values.csv"] {
        assert!(Path::new(&out).join(file).exists(), "{file}");
    }
    for (wrong, message_text) in [
        (&depth[..4], "depth has no standard deviations"),
        (&depth[..2], "each needs the other"),
        (&["--curve", "depth=final(U2@REF)"], "{x}"),
        (&[], "no measured values"),
    ] {
        let both: &[&str] = if message_text.starts_with("depth") { &curve } else { &[] };
        let output = revolve(&[&words[..], wrong, both].concat());
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && message.contains(message_text), "{wrong:?}: {message}");
    }
}

#[test]
fn identify_reads_and_writes_tables() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).to_str().expect("a name").to_owned();
    let data = shots(5);
    let rows = data.observations.iter().step_by(2);
    let rows = rows.map(|o| format!("{},{},1.5\n", data.shots[o.shot][0], o.value));
    fs::write(at("shots.csv"), format!("V,depth,error\n{}", rows.collect::<String>())).expect("a table");
    let (file, out) = (at("shots.csv"), at("out"));
    let words =
        ["identify", "input/ogive.inp", "--shots", &file, "--measured", "depth", "--quantity", DEPTH, "--out", &out];
    let sampled = ["--deviation", "error", "--unknown", "A=4", "--posterior", "100", "--model-error"];
    let weighted = json(&[&words[..], &sampled].concat());
    assert!((number(&weighted["estimates"]["A"]["value"]) - 5.0394).abs() < 0.5, "{weighted}");
    assert!((0.3..2.0).contains(&number(&weighted["deviation"])));
    let sampled = &weighted["posterior"];
    assert!(sampled["converged"] == true && sampled["parameters"]["model error of depth"].is_object(), "{sampled}");
    let [low, high] = ["low", "high"].map(|end| number(&sampled["parameters"]["A"][end]));
    assert!((low..high).contains(&5.0394), "{sampled}");
    for file in ["csv", "svg", "png", "sfv"].map(|ending| format!("ogive_identify.{ending}")) {
        assert!(Path::new(&out).join(&file).exists(), "{file}");
    }
    let corner = fs::read_to_string(Path::new(&out).join("ogive_identify_corner.svg")).expect("a corner plot");
    assert!(corner.contains("model error of depth"));
    let draws = fs::read_to_string(Path::new(&out).join("ogive_identify_posterior.csv")).expect("draws");
    assert!(draws.starts_with("A,model error of depth\n") && draws.lines().count() > 500);
    for (wrong, message_text) in [
        (&["--unknown", "A=4"][..], "no parameter error"),
        (&["--unknown", "A=x", "--deviation", "error"], "NAME=NUMBER"),
        (&["--unknown", "A=5..4", "--deviation", "error"], "NAME=LOW..HIGH"),
        (&["--unknown", "V=500", "--deviation", "error"], "it is also a column"),
        (&["--unknown", "A=4", "--deviation", "eror"], "there is no column eror"),
        (&["--unknown", "A=4", "--deviation", "error", "--set", "V=5"], "another option gives the values"),
        (&["--unknown", "A=4", "--deviation", "error", "--posterior", "--most-runs", "9"], "--most-runs allows 9"),
    ] {
        let output = revolve(&[&words[..], wrong].concat());
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && message.contains(message_text), "{wrong:?}: {message}");
    }
}
