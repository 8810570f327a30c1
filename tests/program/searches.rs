//! Searches over many runs: perforation limits, identification of parameters from shots, Monte Carlo samples.
//!
//! Sources: parameters used to make a table of shots, runs at the ends of a bracket, counted fractions, `sweep` for the
//! same samples.

use std::fs;
use std::process::Output;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore as _, SeedableRng as _};
use revolve::study::evaluate::{DeckSource, SampleEvaluator, UserRoutines};
use revolve::study::quantity::Quantity;
use revolve::study::shot::ShotEnd;
use revolve::study::statistics::design;
use serde_json::Value;

use crate::common::{project, revolve};

const PLATE: &str = "input/plate_6061.inp";
const RESIDUAL: &str = "-final(V2@REF)";
const DEPTH: &str = "-1000*final(U2@REF)";

fn rendered(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn json(words: &[&str]) -> Value {
    serde_json::from_str(&rendered(&revolve(&[words, &["--json"]].concat()))).expect("an object")
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// A meshed rod that is still in the plate when the step ends has not perforated: its run is extended. Source: the same
/// rod with a step that lasts ten times as long. The limit is the same with and without a residual velocity.
#[test]
fn meshed_rod_that_is_still_in_the_plate_has_not_perforated() {
    let text = fs::read_to_string(project("input/rod_plate_deletion.inp")).expect("a deck");
    let [before, after] = ["*Dynamic, Explicit\n , 40.e-6", "*Energy Output"];
    assert!(text.contains(before) && text.contains(after), "the deck has changed");
    let parts = text.replace(after, "*Energy Output, elset=ROD\n PARTVEL\n*Energy Output");
    let folder = tempfile::tempdir().expect("a folder");
    let limit = |duration: &str, more: &[&str]| {
        let deck = folder.path().join("rod.inp");
        let text = parts.replace(before, &format!("*Dynamic, Explicit\n , {duration}"));
        fs::write(&deck, text).expect("a deck");
        let out = folder.path().join("out");
        let [deck, out] = [&deck, &out].map(|path| path.to_str().expect("a name"));
        let words = ["limit", deck, "--velocity", "speed", "--between", "100e3,900e3", "--tolerance", "25e3"];
        let others =
            ["--shots", "1", "--out", out, "--set", "nr=2", "--set", "nz=10", "--set", "mr=10", "--set", "mz=5"];
        let found = json(&[&words[..], &others, more].concat());
        [0, 1].map(|end| number(&found["bracket"][end]))
    };
    let residual = ["--residual", "-final(PARTVEL@ROD)", "--least", "20e3"];
    let long = limit("400.e-6", &residual);
    for found in [limit("40.e-6", &residual), limit("40.e-6", &[]), limit("400.e-6", &[])] {
        assert_eq!(found, long);
    }
}

/// A rod that has not reached the plate at the end of the step, even after its extension, has not perforated.
#[test]
fn rod_that_does_not_reach_the_plate_has_not_met_it() {
    let text = fs::read_to_string(project("input/rod_plate_deletion.inp")).expect("a deck");
    let short = text.replace("*Dynamic, Explicit\n , 40.e-6", "*Dynamic, Explicit\n , 1.e-8");
    assert_ne!(short, text);
    let folder = tempfile::tempdir().expect("a folder");
    let deck = folder.path().join("rod.inp");
    fs::write(&deck, short.replace("gap = ", "gap = 1. + ")).expect("a deck");
    let [deck, out] = [&deck, folder.path()].map(|path| path.to_str().expect("a name"));
    let output = revolve(&[
        "limit",
        deck,
        "--velocity",
        "speed",
        "--between",
        "100e3,900e3",
        "--tolerance",
        "25e3",
        "--out",
        out,
    ]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2) && message.contains("target not met from 100000 to 900000"), "{message}");
}

/// A shot at the lower end of the bracket is stopped, one at the upper end perforates; the fitted curve passes through
/// all points.
#[test]
fn limit_is_within_its_bracket() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().to_str().expect("a name");
    let words = ["limit", PLATE, "--velocity", "V", "--tolerance", "0.1", "--residual", RESIDUAL, "--out", out];
    let found = json(&[&words[..], &["--between", "200,900"]].concat());
    let [low, high] = [0, 1].map(|i| number(&found["bracket"][i]));
    assert!(low < high && high - low <= 0.1, "{low} {high}");
    let ends = format!("V={low},{high}");
    let table = rendered(&revolve(&["sweep", PLATE, "--set", &ends, "--quantity", RESIDUAL, "--out", out, "--json"]));
    let table: Value = serde_json::from_str(&table).expect("an object");
    let residual = |i: usize| number(&table["runs"][i]["values"][RESIDUAL]);
    assert!(residual(0) == 0.0 && residual(1) > 0.0, "{table}");
    let [a, p, of_curve] = ["a", "p", "limit_of_curve"].map(|name| number(&found[name]["value"]));
    assert!(
        (0.9..=1.0).contains(&a) && (1.8..2.2).contains(&p) && (of_curve / low - 1.0).abs() < 0.02,
        "{a} {p} {of_curve}"
    );
    for file in ["plate_6061_limit.csv", "plate_6061_limit.svg", "plate_6061_limit.png"] {
        assert!(folder.path().join(file).exists(), "{file}");
    }
    for (between, more, message_text) in [
        ("500,900", &[][..], "a shot at 500 perforates"),
        ("100,300", &[], "a shot at 300 does not perforate"),
        ("900,200", &[], "expected 0 <= LOW < HIGH"),
        ("200,900", &["--distribution", "V=1..2"], "is given by --velocity"),
        ("200,900", &["--set", "V=1"], "another option gives the values"),
    ] {
        let output = revolve(&[&words[..], &["--between", between], more].concat());
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && message.contains(message_text), "{between} {more:?}: {message}");
    }
}

/// The JSON file is the object of `--json`, the table has all digits, and all files have checksums.
#[test]
fn searches_write_what_json_prints() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().to_str().expect("a name");
    let text = |name: &str| fs::read_to_string(folder.path().join(name)).expect("a file");
    let limit = ["limit", PLATE, "--velocity", "V", "--tolerance", "1", "--between", "200,900", "--shots", "4"];
    let scatter = ["scatter", PLATE, "-d", "V=500..600", "--quantity", RESIDUAL, "--count", "8"];
    let shots = ["--shots", "input/reference/shots_6061.csv", "--measured", "depth", "--quantity", DEPTH];
    let fixed = ["--unknown", "A=4", "--set", "B=0.983", "--set", "C=0.9402"];
    let identify = [&["identify", "input/ogive.inp"][..], &shots, &fixed].concat();
    for (words, name) in
        [(&limit[..], "plate_6061_limit"), (&scatter, "plate_6061_scatter"), (&identify, "ogive_identify")]
    {
        let printed = rendered(&revolve(&[words, &["--out", out, "--json"]].concat()));
        assert_eq!(text(&format!("{name}.json")), printed, "{name}");
        assert!(text(&format!("{name}.sfv")).contains(&format!("{name}.json ")), "{name}");
        // The limit of the bracket is not in the object.
        let (table, first) = (text(&format!("{name}.csv")), if words[0] == "limit" { 2 } else { 1 });
        let row: Vec<&str> = table.lines().nth(first).expect("a row").split(',').collect();
        let value = row[row.iter().position(|cell| cell.parse::<f64>().is_ok()).expect("a number")];
        assert!(printed.contains(&format!("\"value\": {value},")), "{name}: {value} in {printed}");
    }
    let (table, object) = (text("plate_6061_limit_shots.csv"), text("plate_6061_limit.json"));
    let mut rows = table.lines();
    assert_eq!(rows.next(), Some("velocity,residual,end"));
    for row in rows.clone() {
        let [velocity, residual, end] = row.split(',').collect::<Vec<_>>()[..] else { panic!("{row}") };
        let lines = [("velocity", velocity), ("residual", residual)].map(|(key, value)| format!("\"{key}\": {value},"));
        assert!(
            lines.iter().all(|line| object.contains(line)) && object.contains(&format!("\"end\": \"{end}\"")),
            "{row}"
        );
    }
    assert_eq!(rows.count(), object.matches("\"residual\"").count());
    rendered(&revolve(&[&limit[..], &["--out", out, "--over", "THICK=0.01,0.013"]].concat()));
    let table = text("plate_6061_limit_shots.csv");
    assert!(table.starts_with("THICK,velocity,residual,end\n0.01,200.0,"), "{table}");
}

/// A step that is too short is extended; a body that still moves at 16 times its duration gives no limit.
#[test]
fn short_steps_are_extended() {
    let folder = tempfile::tempdir().expect("a folder");
    let whole = fs::read_to_string(project(PLATE)).expect("a deck");
    let paths = ["short.inp", "out"].map(|name| folder.path().join(name));
    let [deck, out] = [&paths[0], &paths[1]].map(|path| path.to_str().expect("a name"));
    let write = |duration: &str| fs::write(deck, whole.replace(" , 2.e-3\n", duration)).expect("a deck");
    let limit = ["--velocity", "V", "--tolerance", "1", "--between", "200,900", "--out", out];
    write(" , 2.e-4\n");
    let [short, full] = [deck, PLATE].map(|deck| json(&[&["limit", deck], &limit[..]].concat()));
    assert_eq!((&short["bracket"], &short["bands"]), (&full["bracket"], &full["bands"]));
    write(" , 2.e-7\n");
    let output = revolve(&[&["limit", deck], &limit[..]].concat());
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2) && message.contains("increase the duration of the steps"), "{message}");
    let words = ["scatter", deck, "-d", "V=500..600", "--quantity", "final(U2@REF)", "--count", "5", "--out", out];
    let message = String::from_utf8_lossy(&revolve(&words).stderr).into_owned();
    assert!(message.contains("in 5 runs a body is still moving"), "{message}");
}

/// A coarse mesh of the oblique deck.
fn coarse_oblique() -> String {
    let text = fs::read_to_string(project("input/oblique.inp")).expect("a deck");
    text.replace("stations  = 64", "stations = 8").replace("n     = 20", "n = 4").replace("m     = 10", "m = 2")
}

/// Ricochet is no perforation, although the body moves on in its direction of flight.
#[test]
fn ricochets_are_no_perforations() {
    let folder = tempfile::tempdir().expect("a folder");
    let deck = folder.path().join("oblique.inp");
    fs::write(&deck, coarse_oblique()).expect("a deck");
    let [deck, out] = [&deck, folder.path()].map(|path| path.to_str().expect("a name"));
    let words = ["limit", deck, "--velocity", "V", "--tolerance", "2", "--shots", "4", "--out", out];
    let ricochets = ["--set", "obliquity=70", "--between", "20,400", "--residual", RESIDUAL];
    let output = revolve(&[&words[..], &ricochets].concat());
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2) && message.contains("ricochet from 20 to 400"), "{message}");
    let found = json(&[&words[..], &["--between", "300,900", "--over", "obliquity=30,70"]].concat());
    let limits = found["limits"].as_array().expect("limits");
    let ends = |limit: &Value| -> Vec<String> {
        let bands = limit["bands"].as_array().expect("bands");
        bands.iter().map(|band| band["end"].as_str().expect("an end").to_owned()).collect()
    };
    assert!(ends(&limits[0]).ends_with(&["embedded".to_owned(), "perforation".to_owned()]), "{found}");
    let at = |i: usize, end: usize| number(&limits[i]["bracket"][end]);
    assert!(at(0, 1) - at(0, 0) <= 2.0 && ends(&limits[1])[0] == "ricochet", "{found}");
    for (over, message_text) in [("V=1,2", "needs another one"), ("obliquity=a", "expected numbers")] {
        let output = revolve(&[&words[..], &["--between", "100,900", "--over", over]].concat());
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && message.contains(message_text), "{over}: {message}");
    }
}

/// Fires random oblique shots and compares their ends with the final place of the body. Returns the numbers of
/// perforations and ricochets.
fn random_oblique_shots(count: usize) -> [usize; 2] {
    let names = ["V", "obliquity", "yaw", "thickness", "friction"].map(str::to_owned).to_vec();
    let columns = ["U1@REF", "U2@REF"].map(|column| format!("final({column})"));
    let quantities = columns.iter().map(|text| Quantity::parse(text).expect("a quantity")).collect();
    let source = DeckSource::Text("oblique.inp".into(), coarse_oblique());
    let evaluator = SampleEvaluator::new(source, Vec::new(), names, quantities, UserRoutines::Absent);
    let evaluator = evaluator.expect("an evaluator").of_shots(None);
    let ranges = [[20.0, 900.0], [0.5, 80.0], [-8.0, 8.0], [2e-3, 30e-3], [0.0, 0.05]];
    let mut draws = ChaCha8Rng::seed_from_u64(7);
    let mut draw = |[low, high]: [f64; 2]| low + (high - low) * design::unit(draws.next_u64());
    let samples: Vec<f64> = (0..count).flat_map(|_| ranges).map(&mut draw).collect();
    let shots = evaluator.shots(&samples, 2).expect("threads");
    let [mut through, mut back] = [0, 0];
    for (shot, sample) in shots.into_iter().zip(samples.chunks(ranges.len())) {
        let shot = shot.unwrap_or_else(|why| panic!("{sample:?}: {why}"));
        let [angle, thickness] = [sample[1].to_radians(), sample[3]];
        let along = |v: &[f64]| v[1] * angle.cos() - v[0] * angle.sin();
        // The reference node is 12 mm above the tip, which touches the front; the body is 72 mm long.
        let height = along(&[shot.values[0], shot.values[1] + 0.012]);
        let (is_behind, is_before) = (height < -thickness, height > 0.0);
        match shot.end {
            Some(ShotEnd::Perforation) => {
                assert!(is_behind, "{sample:?}: {shot:?}");
                through += 1;
            }
            Some(ShotEnd::Ricochet) => {
                assert!(is_before, "{sample:?}: {shot:?}");
                back += 1;
            }
            Some(ShotEnd::Embedded) => assert!(shot.speed <= 0.01 * sample[0], "{sample:?}: {shot:?}"),
            end => assert_eq!(end, Some(ShotEnd::Moving), "{sample:?}"),
        }
    }
    println!("{through} perforations, {back} ricochets of {count}");
    [through, back]
}

#[test]
fn random_ricochets_are_never_perforations() {
    let [through, back] = random_oblique_shots(60);
    assert!(through > 10 && back > 10, "{through} {back}");
}

#[test]
#[ignore = "1000 shots"]
fn thousand_random_ricochets_are_never_perforations() {
    let [through, back] = random_oblique_shots(1000);
    assert!(through > 200 && back > 200, "{through} {back}");
}

/// A run without a target records no event: its shots are judged by `--residual` and `--least`, which are then required.
#[test]
fn decks_without_events_need_a_criterion() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = fs::read_to_string(project(PLATE)).expect("a deck");
    let free = text.replace("*Dsload, target=PLATES, friction=<FRICTION>\n NOSE, CAVITY\n", "");
    assert_ne!(free, text);
    let deck = folder.path().join("free.inp");
    fs::write(&deck, free).expect("a deck");
    let [deck, out] = [&deck, folder.path()].map(|path| path.to_str().expect("a name"));
    let words = ["limit", deck, "--velocity", "V", "--between", "100,600", "--tolerance", "1", "--out", out];
    for more in [&[][..], &["--residual", RESIDUAL], &["--least", "300"]] {
        let output = revolve(&[&words[..], more].concat());
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && message.contains("--least SPEED"), "{more:?}: {message}");
    }
    let found = json(&[&words[..], &["--residual", RESIDUAL, "--least", "300"]].concat());
    let [low, high] = [0, 1].map(|i| number(&found["bracket"][i]));
    assert!(low <= 300.0 && 300.0 < high && high - low <= 1.0, "{low} {high}");
    assert_eq!(found["bands"][0]["end"], "slow");
}

/// At V50 half of the shots perforate; one standard deviation above V50 the fraction is that of a normal distribution.
#[test]
fn sampled_limits_give_v50() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().to_str().expect("a name");
    let drawn = ["-d", "THICK=normal(0.013, 0.0003)", "-d", "MASS=truncated(normal(0.021, 0.0004), 0.02, 0.022)"];
    let words =
        ["limit", PLATE, "--velocity", "V", "--between", "300,500", "--tolerance", "0.05", "--residual", RESIDUAL];
    let with = |threads: &str| {
        json(&[&words[..], &drawn, &["--count", "100", "--seed", "4", "--threads", threads, "--out", out]].concat())
    };
    let found = with("2");
    assert_eq!(found, with("1"));
    assert_eq!(found["lost"], 0);
    let [median, deviation] = ["v50", "deviation"].map(|name| number(&found[name]["value"]));
    assert!((1.0..20.0).contains(&deviation), "{deviation}");
    for (velocity, fraction) in [(median, 0.5), (median + deviation, 0.841)] {
        let velocity = format!("V={velocity}");
        let table = folder.path().join("shots.csv");
        let file = table.to_str().expect("a name");
        let more = ["--set", &velocity, "--count", "400", "--quantity", RESIDUAL, "--table", file, "--out", out];
        rendered(&revolve(&[&["scatter", PLATE][..], &drawn, &more].concat()));
        let text = fs::read_to_string(&table).expect("a table");
        let residual =
            |line: &str| line.rsplit_once(',').and_then(|cells| cells.1.parse::<f64>().ok()).expect("a number");
        let through = text.lines().skip(1).filter(|line| residual(line) > 0.0).count() as f64 / 400.0;
        // Three standard deviations of the count, plus the error of V50 from 100 samples.
        assert!((through - fraction).abs() < 0.12, "{velocity}: {through} perforate, not {fraction}");
    }
    assert!(folder.path().join("plate_6061_limit_scatter.svg").exists());
    assert_draws(&found, &fs::read_to_string(folder.path().join("plate_6061_limit_draws.csv")).expect("a table"));
}

/// Checks that the draws of a limit and the table of their shots are equal, and that the shots give the bracket of each draw.
fn assert_draws(found: &Value, table: &str) {
    let draws = found["draws"].as_array().expect("draws");
    assert_eq!((draws.len(), table.lines().next()), (100, Some("draw,THICK,MASS,velocity,residual,end")));
    let mut rows = table.lines().skip(1);
    for (i, draw) in draws.iter().enumerate() {
        let parameters = ["THICK", "MASS"].map(|name| number(&draw["parameters"][name]));
        let mut bracket = [f64::NEG_INFINITY, f64::INFINITY];
        for shot in draw["shots"].as_array().expect("shots") {
            let cells: Vec<&str> = rows.next().expect("a row").split(',').collect();
            let numbers: Vec<f64> = cells[..5].iter().map(|cell| cell.parse().expect("a number")).collect();
            let [velocity, residual] = ["velocity", "residual"].map(|name| number(&shot[name]));
            let expected = [i as f64 + 1.0, parameters[0], parameters[1], velocity, residual];
            // The parser of JSON rounds to the last digit but one.
            let equal = numbers.iter().zip(expected).all(|(a, b)| (a - b).abs() <= 1e-15 * b.abs());
            assert!(equal, "{numbers:?} {expected:?}");
            assert_eq!(shot["end"], cells[5]);
            match cells[5] {
                "perforation" => bracket[1] = bracket[1].min(velocity),
                _ => bracket[0] = bracket[0].max(velocity),
            }
        }
        assert!(number(&draw["bracket"][0]) <= bracket[0] && bracket[1] <= number(&draw["bracket"][1]), "{bracket:?}");
    }
    assert_eq!(rows.next(), None);
}

/// Samples depend on the seed alone: identical bytes on one and two threads, and the samples of `sweep --random`.
#[test]
fn samples_do_not_depend_on_threads() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).to_str().expect("a name").to_owned();
    for sampling in ["random", "latin", "sobol"] {
        let tables = ["1", "2"].map(|threads| {
            let (table, out) = (at(&format!("{sampling}{threads}.csv")), at(threads));
            let words =
                ["scatter", "input/ogive.inp", "-d", "V=600..900", "-d", "mass=lognormal(0.021, 0.001)", "--seed", "3"];
            let more = ["--sampling", sampling, "--count", "50", "--quantity", DEPTH, "--indices", "--table", &table];
            let message_text = json(&[&words[..], &more, &["--threads", threads, "--out", &out]].concat());
            assert_eq!((&message_text["runs"], &message_text["failed"]), (&Value::from(200), &Value::from(0)));
            (message_text, fs::read(table).expect("a table"))
        });
        assert!(tables[0] == tables[1], "{sampling}");
        assert_eq!(tables[0].1.iter().filter(|b| **b == b'\n').count(), 51);
    }
    let set = ["--set", "V=600..900", "--set", "mass=lognormal(0.021, 0.001)", "--quantity", DEPTH];
    let plan = rendered(&revolve(
        &[&["sweep", "input/ogive.inp", "--random", "50", "--seed", "3", "--plan"], &set[..]].concat(),
    ));
    let table = fs::read_to_string(at("random1.csv")).expect("a table");
    for (drawn, planned) in table.lines().zip(plan.lines()).skip(1) {
        let both = drawn.rsplit_once(',').expect("a quantity").0;
        assert_eq!(both, planned.split_once(',').expect("a number of the case").1);
    }
}

/// Failed runs are counted and reported, and their cells are empty.
#[test]
fn failed_samples_are_counted_and_reported() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).to_str().expect("a name").to_owned();
    let (table, out) = (at("a.csv"), at("out"));
    let words = ["scatter", "input/ogive.inp", "--quantity", DEPTH, "--count", "40", "--table", &table, "--out", &out];
    let output = revolve(&[&words[..], &["-d", "mass=-0.01..0.02"]].concat());
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(1) && message.contains("of 40 runs gave no result; the first:"), "{message}");
    let text = fs::read_to_string(&table).expect("a table");
    for line in text.lines().skip(1) {
        let (mass, depth) = line.split_once(',').expect("two cells");
        assert_eq!(depth.is_empty(), mass.starts_with('-'), "{line}");
    }
    for (wrong, message_text) in [
        (&["-d", "mass=0.01"][..], "is not a distribution"),
        (&["-d", "mas=0.01..0.02"], "did you mean mass?"),
        (&["-d", "mass=0.01..0.02", "--correlation", "mass:V=0.5"], "both parameters need"),
        (&["-d", "mass=0.01..0.02", "--sampling", "sobol", "--count", "8"], "at least 32 points"),
        (&["-d", "mass=0.01..0.02", "--quantiles", "2"], "between 0 and 1"),
        (&["-d", "mass=0.01..0.02", "--table", "a.xls"], "must end in .csv, or in .parquet"),
    ] {
        let words = ["scatter", "input/ogive.inp", "--quantity", DEPTH, "--out", &out];
        let output = revolve(&[&words[..], wrong].concat());
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && message.contains(message_text), "{wrong:?}: {message}");
    }
}
