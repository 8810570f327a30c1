//! Before, during and after a run: `check`, the status file, the end of the run, example decks.

use std::io::Write as _;
use std::process::{Command, Stdio};

use crate::common::{project, revolve};

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn checked(arguments: &[&str]) -> serde_json::Value {
    let output = revolve(&[&["check", "--json", "--no-look"], arguments].concat());
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {}", text(&output.stderr)))
}

fn number(value: &serde_json::Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

fn near(value: &serde_json::Value, expected: f64) {
    assert!((number(value) / expected - 1.0).abs() < 1e-12, "{value} and not {expected}");
}

/// A cylinder: mass, centre, energy and wave times calculated by hand, and the conditions at its foot.
#[test]
fn check_summarises_a_deck() {
    let found = checked(&["input/taylor_copper.inp"]);
    let (density, radius, length, speed): (f64, f64, f64, f64) = (8930.0, 3.2e-3, 32.4e-3, 227.0);
    let overview = &found["overview"];
    let part = &overview["parts"][0];
    let mass = density * std::f64::consts::PI * radius * radius * length;
    near(&part["mass"], mass);
    near(&overview["mass"], mass);
    near(&part["centre"], 0.5 * length);
    near(&part["extent"][0][1], radius);
    assert_eq!(part["elements"]["CAX4R"], 500);
    near(&part["velocity"][0], -speed);
    near(&part["velocity"][1], speed);
    let (modulus, ratio) = (117e9, 0.35);
    let wave = (modulus * (1.0 - ratio) / ((1.0 + ratio) * (1.0 - 2.0 * ratio) * density)).sqrt();
    near(&overview["waves"][0]["longitudinal"], wave);
    near(&overview["waves"][0]["shear"], (modulus / (2.0 * (1.0 + ratio)) / density).sqrt());
    // The foot is fixed from the start, so its lumped mass has no kinetic energy.
    let energy = 0.5 * mass * speed * speed;
    let part = number(&overview["kinetic_energy"]) / energy;
    assert!((0.98..=1.0 + 1e-12).contains(&part), "{part}");
}

/// Longitudinal wave speed sqrt(K/rho) of every equation of state, with the density 4 and the bulk modulus 1, or 1.4 of the
/// gas, which is (1 + R/cv) rho R T.
#[test]
fn wave_speeds_follow_from_every_equation_of_state() {
    let gas =
        "*Eos, type=IDEAL GAS\n 0.4, 0.\n*Specific Heat\n 1.,\n*Initial Conditions, type=TEMPERATURE\n ALL, 0.625\n";
    let laws = [
        ("*Eos, type=USUP\n 0.5, 1.5, 2.\n", 1.0),
        ("*Eos, type=TABULAR\n -0.1, 0., 0.1\n 0., 0., 0.\n 0.2, 0., -0.2\n", 1.0),
        (gas, 1.4),
        ("*Eos, type=JWL\n 0.5, 1., 1., 0.3, 4., 1., 0.05, 1.\n*Detonation Point\n 0., 0.\n", 1.0),
    ];
    let folder = tempfile::tempdir().expect("a folder");
    for (law, modulus) in laws {
        let deck = folder.path().join("block.inp");
        let text = format!(
            "*Node, nset=ALL\n 1, 0., 0.\n 2, 1., 0.\n 3, 1., 1.\n 4, 0., 1.\n*Element, type=CAX4R, elset=E\n 1, 1, 2, 3, 4\n\
             *Solid Section, elset=E, material=M\n*Material, name=M\n*Density\n 4.,\n{law}*Step\n*Dynamic, Explicit\n , \
             1.\n*End Step\n"
        );
        std::fs::write(&deck, text).expect("a deck");
        let found = checked(&[deck.to_str().expect("a path")]);
        near(&found["overview"]["waves"][0]["longitudinal"], (modulus / 4.0_f64).sqrt());
    }
}

/// A short trial run: runs that end within it are reported completely, for others the increment and its element.
#[test]
fn check_estimates_the_run_time() {
    let effort = |deck: &str| {
        let output = revolve(&["check", "--json", deck]);
        let found: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        found["overview"]["effort"].clone()
    };
    let whole = effort("input/ogive.inp");
    assert_eq!(number(&whole["looked_at"]), 1.0);
    let folder = tempfile::tempdir().expect("a folder");
    let output =
        revolve(&["run", "input/ogive.inp", "--json", "--no-frames", "-o", folder.path().to_str().expect("a name")]);
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(number(&whole["increments"]), number(&summary["timing"]["increments"]));
    let part = effort("input/taylor_copper.inp");
    assert!(number(&part["increment"]) > 1e-9 && number(&part["increment"]) < 1e-7, "{part}");
    assert!(part["limiting_element"].as_str().is_some_and(|e| e.parse::<u32>().is_ok()), "{part}");
}

/// The trial run is bounded by increments, not by time: the estimate is the same each time.
#[test]
fn check_estimates_the_same_increment_each_time() {
    let estimates = || {
        let output = revolve(&["check", "--json", "input/rod_plate_deletion.inp"]);
        let found: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let effort = &found["overview"]["effort"];
        ["increment", "limiting_element", "increments", "looked_at"].map(|key| effort[key].clone())
    };
    let first = estimates();
    assert!(number(&first[0]) > 0.0);
    assert_eq!(first, estimates());
}

/// A frame is a mesh file: with the sets of the deck, without the elements that have been deleted. Its points are the
/// initial ones, because some deformed elements are concave.
#[test]
fn frames_are_read_as_meshes_with_their_sets() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = path_in(&folder, "out");
    assert!(
        revolve(&["run", "input/rod_plate_deletion.inp", "-q", "-o", &out, "--points", "reference"]).status.success()
    );
    let summary = std::fs::read_to_string(folder.path().join("out/rod_plate_deletion.json")).expect("a summary");
    let summary: serde_json::Value = serde_json::from_str(&summary).expect("JSON");
    let frames = std::fs::read_dir(&out).expect("files").filter_map(|e| e.ok()?.file_name().into_string().ok());
    let last = frames.filter(|name| name.ends_with(".vtu")).max().expect("frames");
    let text = format!("*Mesh, input=\"{out}/{last}\"\n");
    let (deck, _) = revolve::deck::read_text("frame.inp", &text, &[]);
    let (model, diagnostics) = revolve::model::build(&deck);
    let messages = diagnostics.render(&deck.sources);
    assert!(!diagnostics.has_errors(), "{messages}");
    let deleted = number(&summary["deleted_elements"]) as usize;
    assert!(deleted > 0);
    assert_eq!(model.mesh.elements.len(), 280 - deleted);
    let [rod, plate] = ["ROD", "PLATE"].map(|name| model.element_sets[name].members.clone());
    assert_eq!(rod.len() + plate.len(), model.mesh.elements.len());
    assert!(rod.iter().all(|element| !plate.contains(element)));
}

/// `check` announces the bytes of frames and of the history within 5 %, if its trial run is the whole run.
#[test]
fn announced_output_matches_written_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = revolve(&["check", "--json", "input/ogive.inp"]);
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let announced = &found["overview"]["output"];
    let out = path_in(&folder, "out");
    assert!(revolve(&["run", "input/ogive.inp", "-q", "-o", &out]).status.success());
    let length = |name: &str| std::fs::metadata(folder.path().join("out").join(name)).expect("a file").len() as f64;
    let frames: f64 = (0..21).map(|i| length(&format!("ogive_{i:04}.vtu"))).sum();
    assert_eq!(number(&announced["frames"]), 21.0);
    // A line in the list of frames and one in the list of checksums.
    let of_frames = 21.0 * (number(&announced["frame_bytes"]) - 110.0);
    assert!((of_frames / frames - 1.0).abs() < 0.05, "{of_frames} {frames}");
    let rows = number(&announced["rows"]) * number(&announced["row_bytes"]);
    assert!((rows / length("ogive_history.csv") - 1.0).abs() < 0.05, "{rows}");
    assert!(number(&announced["largest_frame_bytes"]) > number(&announced["frame_bytes"]));
}

/// The announced bytes of all files except summary and status are those written, within 5 %: rigid projectiles, an
/// elastic-plastic bar, and general contact with erosion over a tenth of its time.
#[test]
fn announced_bytes_of_examples_match_written_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let text_of_rod = std::fs::read_to_string(project("input/rod_plate_deletion.inp")).expect("a deck");
    let rod = path_in(&folder, "rod_plate_deletion.inp");
    std::fs::write(&rod, text_of_rod.replace("40.e-6", "4.e-6")).expect("a deck");
    for (deck, settings) in [
        ("input/ogive.inp", &[][..]),
        ("input/ogive_steel.inp", &[]),
        ("input/taylor_copper.inp", &["nr=2", "nz=10"]),
        (&rod, &["nr=2", "nz=4", "mr=4", "mz=2"]),
    ] {
        let settings: Vec<&str> = settings.iter().flat_map(|setting| ["--set", setting]).collect();
        let output = revolve(&[&["check", "--json", deck], &settings[..]].concat());
        let found: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let announced = |name: &str| number(&found["overview"]["output"][name]);
        let bytes = announced("frames") * announced("frame_bytes") + announced("rows") * announced("row_bytes");
        let out = tempfile::tempdir().expect("a folder");
        let place = out.path().to_str().expect("a name");
        let run = revolve(&[&["run", deck, "-q", "-o", place], &settings[..]].concat());
        assert!(run.status.success(), "{}", text(&run.stderr));
        let files = std::fs::read_dir(out.path()).expect("a folder").map(|file| file.expect("a file"));
        let is_counted = |name: &str| !name.ends_with(".json") && !name.ends_with(".sta");
        let counted = files.filter(|file| is_counted(&file.file_name().to_string_lossy()));
        let written: u64 = counted.map(|file| file.metadata().expect("a file").len()).sum();
        println!("{deck}: {bytes:.0} announced, {written} written");
        assert!((bytes / written as f64 - 1.0).abs() < 0.05, "{deck}: {bytes} announced, {written} written");
    }
}

/// Values of a file are reported with file, row and column, not as `--set`.
#[test]
fn invalid_samples_are_reported_with_their_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let (file, out) = (path_in(&folder, "samples.csv"), path_in(&folder, "out"));
    let failure = |text: &str| {
        std::fs::write(&file, text).expect("a file");
        let words = ["sweep", "input/ogive.inp", "--samples", &file, "--quantity", "final(U2@REF)", "-q", "-o", &out];
        String::from_utf8_lossy(&revolve(&words).stderr).into_owned()
    };
    let found = failure("V,B\n600,0.9\n700,abc\n");
    assert!(found.contains("samples.csv, row 2, column B: `B=abc`") && !found.contains("--set"), "{found}");
    let found = failure("V,B\n600,1/0\n");
    assert!(found.contains("samples.csv, row 1, column B: `B=1/0`") && !found.contains("--set"), "{found}");
}

fn path_in(folder: &tempfile::TempDir, name: &str) -> String {
    folder.path().join(name).to_str().expect("a name").to_owned()
}

/// Density and modulus from different systems of units: `check` reports this and proposes a consistent pair.
#[test]
fn inconsistent_units_are_reported() {
    let folder = tempfile::tempdir().expect("a folder");
    let deck = std::fs::read_to_string(project("input/taylor_copper.inp")).expect("a deck");
    let codes = |change: [&str; 2]| {
        assert!(deck.contains(change[0]), "{change:?}");
        let path = folder.path().join("deck.inp");
        std::fs::write(&path, deck.replacen(change[0], change[1], 1)).expect("a deck");
        let found = checked(&[path.to_str().expect("a name")]);
        let codes: Vec<String> = found["diagnostics"]
            .as_array()
            .expect("a list")
            .iter()
            .map(|d| d["code"].as_str().unwrap_or_default().to_owned())
            .collect();
        (codes, found["diagnostics"].clone())
    };
    let (message_text, found) = codes(["117.e9", "117.e3"]);
    assert!(message_text.contains(&"P119".into()), "{found}");
    let finding = found.as_array().and_then(|l| l.iter().find(|d| d["code"] == "P119")).expect("a finding").clone();
    assert!(finding["line"].is_u64() && finding["column"].is_u64() && finding["file"].is_string(), "{finding}");
    assert!(finding["help"].as_str().is_some_and(|h| h.contains("m, kg, s") && h.contains("2.1")), "{finding}");
    assert!(!codes(["", ""]).0.contains(&"P119".into()));
    assert!(codes([" m, kg, s", " mm, t, s"]).0.contains(&"P119".into()));
}

#[test]
fn run_writes_a_status_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = path_in(&folder, "status");
    let output =
        revolve(&["run", "input/taylor_copper.inp", "-o", &out, "--profile", "--quantity", "at(U2@TIP, 4e-5)"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let status = std::fs::read_to_string(format!("{out}/taylor_copper.sta")).expect("a status file");
    let rows: Vec<Vec<&str>> = status
        .lines()
        .map(|line| line.split_whitespace().collect::<Vec<_>>())
        .filter(|words| words.len() == 8 && words[0].parse::<u64>().is_ok())
        .collect();
    assert!(rows.len() >= 21, "at least one line per frame: {status}");
    let increments: Vec<u64> = rows.iter().map(|row| row[0].parse().expect("a number")).collect();
    assert!(increments.is_sorted(), "{increments:?}");
    let times: Vec<f64> = rows.iter().map(|row| row[2].parse().expect("a time")).collect();
    assert_eq!((times[0], *times.last().expect("a time")), (0.0, 8e-5));
    assert!(status.ends_with("THE ANALYSIS HAS COMPLETED\n"), "{status}");
    let printed = text(&output.stdout);
    assert!(printed.contains("completed: ") && printed.contains("ns/increment"), "{printed}");
    let value: f64 = printed
        .lines()
        .find_map(|line| line.strip_prefix("at(U2@TIP, 4e-5) = "))
        .and_then(|value| value.parse().ok())
        .expect("a value");
    assert!((-0.0108..-0.006).contains(&value), "{value}");
    // The same expression gives the same number in a sweep.
    let swept =
        revolve(&["sweep", "input/taylor_copper.inp", "-s", "nr=10", "-o", &out, "--quantity", "at(U2@TIP, 4e-5)"]);
    let table = text(&swept.stdout);
    assert!(table.contains(&format!("{:.7}", value)[..9]), "{table} {value}");
}

#[test]
fn run_without_frames_has_the_same_result() {
    let folder = tempfile::tempdir().expect("a folder");
    let (with, without) = (path_in(&folder, "frames"), path_in(&folder, "no-frames"));
    let json = |arguments: &[&str]| -> serde_json::Value {
        let output = revolve(&[&["run", "input/ogive.inp", "--json"], arguments].concat());
        serde_json::from_slice(&output.stdout).expect("JSON and nothing else")
    };
    let (a, b) = (json(&["-o", &with]), json(&["-o", &without, "--no-frames"]));
    assert_eq!(a["digest"], b["digest"]);
    let names = |folder: &str| -> Vec<String> {
        let entries = std::fs::read_dir(folder).expect("a folder");
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect()
    };
    assert!(names(&with).iter().any(|n| n.ends_with(".vtu")));
    assert!(names(&without).iter().all(|n| !n.ends_with(".vtu") && !n.ends_with(".pvd")), "{:?}", names(&without));
}

/// A run that ends early and one that perforates: both are reported with the depth.
#[test]
fn depths_of_unfinished_shots_are_reported() {
    let folder = tempfile::tempdir().expect("a folder");
    let deck = std::fs::read_to_string(project("input/ogive.inp")).expect("a deck");
    let path = folder.path().join("ogive.inp");
    std::fs::write(&path, deck.replace(" , 1.e-3", " , 1.e-4")).expect("a deck");
    let (short, out) = (path.to_str().expect("a name"), path_in(&folder, "depths"));
    let run = revolve(&["run", short, "-o", &out]);
    assert!(text(&run.stdout).contains("NOSE still moves in the target"), "{}", text(&run.stdout));
    let arguments = ["-o", &out, "--quantity", "-1000*final(U2@REF)"];
    let sweep = revolve(&[&["sweep", "input/ogive.inp", "-s", "V=569,2000"], &arguments[..]].concat());
    let message_text = text(&sweep.stderr);
    assert!(message_text.contains("V = 2000: R315: NOSE has left the target through its back"), "{message_text}");
    assert!(!message_text.contains("V = 569"), "{message_text}");
    let study = revolve(&[&["study", short, "--refine", "n=5,10,20"], &arguments[..]].concat());
    assert!(text(&study.stderr).contains("n = 20: R315: NOSE still moves"), "{}", text(&study.stderr));
}

/// A user-defined design of experiments: rows in order, a failing one named, the results of each kept.
#[test]
fn samples_are_run_in_order_with_their_own_results() {
    let folder = tempfile::tempdir().expect("a folder");
    let (design, out) = (folder.path().join("doe.csv"), folder.path().join("out"));
    std::fs::write(&design, "V, CRH\n821, 3\n569, 2\n700, 0\n").expect("a design");
    let (design, out) = (design.to_str().expect("a name"), out.to_str().expect("a name"));
    let arguments = ["sweep", "input/ogive.inp", "--samples", design, "-s", "n=10", "-o", out, "--keep", "--json"];
    let output = revolve(&[&arguments[..], &["--quantity", "-1000*final(U2@REF)"]].concat());
    assert_eq!(output.status.code(), Some(1), "one row gives no result: {}", text(&output.stderr));
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let runs = found["runs"].as_array().expect("runs");
    assert_eq!(runs.len(), 3);
    assert_eq!(runs[1]["parameters"], serde_json::json!({"V": 569, "CRH": 2, "n": 10}));
    let depth = |i: usize| number(&runs[i]["values"]["-1000*final(U2@REF)"]);
    assert!(depth(0) > depth(1) && depth(1) > 40.0, "{found}");
    assert!(runs[2]["error"].is_string() && runs[2]["values"].is_null(), "{found}");
    for run in ["ogive_00001", "ogive_00002"] {
        let summary = std::fs::read_to_string(format!("{out}/{run}/ogive.json")).expect("a summary");
        assert!(summary.contains("\"completed\""));
        assert!(std::fs::metadata(format!("{out}/{run}/ogive_history.csv")).is_ok_and(|m| m.len() > 100));
    }
}

#[test]
fn deck_is_read_from_standard_input() {
    let folder = tempfile::tempdir().expect("a folder");
    let deck = std::fs::read(project("input/ogive.inp")).expect("a deck");
    let piped = |arguments: &[&str]| {
        let mut child = Command::new(env!("CARGO_BIN_EXE_revolve"))
            .args(arguments)
            .args(["-o", &path_in(&folder, "out")])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the program");
        child.stdin.take().expect("a pipe").write_all(&deck).expect("a reader");
        let output = child.wait_with_output().expect("an end");
        assert!(output.status.success(), "{arguments:?}");
        text(&output.stdout)
    };
    piped(&["run", "-", "-q", "--no-frames"]);
    assert!(folder.path().join("out/job.json").is_file());
    // A sweep reads its deck again for each run.
    let swept = piped(&["sweep", "-", "-q", "--json", "-s", "V=569,821", "--quantity", "-1000*final(U2@REF)"]);
    let found: serde_json::Value = serde_json::from_str(&swept).expect("JSON");
    assert!(found["runs"].as_array().is_some_and(|runs| runs.iter().all(|run| run["error"].is_null())), "{found}");
}

/// Each example deck runs as it is written, with its user subroutine; existing files are not overwritten.
#[test]
fn example_decks_run_as_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().to_str().expect("a name");
    for template in ["taylor", "ogive", "plate"] {
        let output = revolve(&["new", template, "-o", out]);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let deck =
            text(&output.stdout).lines().find_map(|l| l.trim().strip_prefix("revolve check ").map(str::to_owned));
        let output = revolve(&["check", "--no-look", &deck.expect("a deck")]);
        assert!(output.status.success(), "{template}: {}", text(&output.stderr));
    }
    let again = revolve(&["new", "taylor", "-o", out]);
    assert_eq!(again.status.code(), Some(2));
    assert!(revolve(&["new", "vdload", "-o", out]).status.success());
    assert!(folder.path().join("vdload_cavity.f").is_file());
}

#[test]
fn technical_terms_are_explained() {
    for (word, rendered) in [
        ("CAX4R", "quadrilateral"),
        ("c3d8r", "axisymmetric"),
        ("final", "last value"),
        ("units", "steel"),
        ("paraview", ".pvd"),
        ("*Solid Section", "MATERIAL"),
        ("P119", "implausible units"),
        ("S", "Stress"),
    ] {
        let output = revolve(&["explain", word]);
        assert!(output.status.success() && text(&output.stdout).contains(rendered), "{word}: {}", text(&output.stdout));
    }
    let unknown = revolve(&["explain", "CAX4RR"]);
    assert!(text(&unknown.stderr).contains("did you mean CAX4R"), "{}", text(&unknown.stderr));
}

#[test]
fn completions_and_manual_page_are_written() {
    let completions = text(&revolve(&["completions", "bash"]).stdout);
    assert!(completions.contains("--checkpoint-every") && completions.contains("complete -F"));
    let page = text(&revolve(&["man"]).stdout);
    assert!(page.contains(".TH revolve") && page.contains("checkpoint"), "{page}");
    let version = text(&revolve(&["--version"]).stdout);
    assert!(version.contains("features: ") && version.contains("target: "), "{version}");
    assert!(version.contains("instructions "), "{version}");
    // A checkout with history prints commit and date, a source archive neither.
    let first = version.lines().next().unwrap_or_default();
    let message_text =
        first.split_once('(').map(|(_, commit)| commit.trim_end_matches(')').split(' ').collect::<Vec<_>>());
    assert!(message_text.is_none_or(|words| words.len() >= 2 && words[1].split('-').count() == 3), "{version}");
}
