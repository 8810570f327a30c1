//! The program on the command line: exit status, messages, files.

use std::path::Path;

use crate::common::solid::{grid, material};
use crate::common::{project, revolve};

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn run_writes_complete_files_with_stable_keys() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().to_str().expect("a name");
    let output = revolve(&["run", "input/ogive.inp", "--quiet", "--out", out, "--set", "V=600"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(output.stdout.is_empty() && output.stderr.is_empty(), "quiet");
    let summary = std::fs::read_to_string(folder.path().join("ogive.json")).expect("a summary");
    let summary: serde_json::Value = serde_json::from_str(&summary).expect("JSON");
    let keys: Vec<_> = summary.as_object().expect("an object").keys().cloned().collect();
    let expected = [
        "status",
        "verdict",
        "verdict_reasons",
        "steps",
        "limits",
        "history",
        "energy",
        "digest",
        "rests",
        "ledger",
        "scene",
        "units",
        "column_units",
        "materials",
        "timing",
        "deck",
        "version",
        "provenance",
    ];
    assert_eq!(keys, expected);
    assert_eq!(summary["status"], "completed");
    let limits = &summary["limits"][0];
    let counts = ["time", "increment", "by"].map(|key| limits[key].as_array().map_or(0, Vec::len));
    assert!(counts[0] > 10 && counts[0] <= 64 && counts[1] == counts[0] && counts[2] == counts[0], "{counts:?}");
    assert_eq!(limits["time"][0], 0.0);
    assert!(limits["names"].to_string().contains("a body comes to rest"), "{}", limits["names"]);
    assert_eq!(summary["deck"]["parameters"]["V"], 600.0);
    for key in ["final", "min", "max", "time_min", "time_max"] {
        assert!(summary["history"]["U2@REF"][key].is_number(), "{key}");
    }
    let csv = std::fs::read_to_string(folder.path().join("ogive_history.csv")).expect("a history");
    assert!(csv.starts_with("time,step,U2@REF,V2@REF,A2@REF,ALLKE,ALLWK,ALLFD,ALLCAV,ETOTAL\n"));
    let names: Vec<String> = std::fs::read_dir(folder.path())
        .expect("a folder")
        .map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned())
        .collect();
    assert_eq!(names.iter().filter(|n| n.ends_with(".vtu")).count(), 21);
    assert!(names.iter().all(|n| !n.starts_with(".revolve")), "no temporary file is left: {names:?}");
}

#[test]
fn invalid_decks_are_rejected_with_a_place() {
    let mut seen = 0;
    for entry in std::fs::read_dir(project("tests/decks/bad")).expect("broken decks") {
        let path = entry.expect("an entry").path();
        if path.extension().is_none_or(|e| e != "inp") {
            continue;
        }
        let name = path.strip_prefix(env!("CARGO_MANIFEST_DIR")).unwrap_or(&path).to_str().expect("a name").to_owned();
        let output = revolve(&["run", &name, "--out", "target/never"]);
        assert_eq!(output.status.code(), Some(2), "{name}: {}", text(&output.stderr));
        assert!(text(&output.stderr).contains("error["), "{name}: {}", text(&output.stderr));
        seen += 1;
    }
    assert!(seen >= 10, "{seen} broken decks");
    assert!(!Path::new("target/never").exists(), "nothing is written for an invalid deck");
}

#[test]
fn invalid_arguments_are_rejected_with_a_message() {
    for arguments in [
        &["run", "no/such.inp"][..],
        &["run", "input/ogive.inp", "--set", "v=1"],
        &["run", "input/ogive.inp", "--set", "V"],
        &["run", "input/ogive.inp", "--set", "V=1+"],
        &["explain", "NOSUCHWORD"],
        &["sweep", "input/ogive.inp", "--set", "V=1:2", "--quantity", "final(U2@REF)"],
        &["sweep", "input/ogive.inp", "--set", "V=600", "--quantity", "final("],
        &["study", "input/ogive.inp", "--refine", "m=10,20", "--quantity", "final(U2@REF)"],
        &["study", "input/ogive.inp", "--refine", "n=10", "--quantity", "final(U2@REF)"],
        &["study", "input/ogive.inp", "--refine", "n=20,40,10", "--quantity", "final(U2@REF)"],
        &["study", "input/ogive.inp", "--refine", "n=10,20", "--quantity", "final(U2@RFE)"],
        &["study", "input/ogive.inp", "--refine", "n=10,20", "--quantity", "norm(S22, r)"],
        &["study", "input/ogive.inp", "--refine", "n=10,20", "--quantity", "3"],
        &["study", "input/ogive.inp", "--refine", "n=10,20", "--quantity", "final(U2@REF)", "--target", "0"],
        &["study", "input/ogive.inp", "--refine", "n=10,20", "--quantity", "final(U2@REF)", "--exact", "1+"],
        &["study", "input/ogive.inp", "--refine", "hourglass=enhanced", "--quantity", "final(U2@REF)", "--exact", "1"],
        &["study", "input/ogive.inp", "--refine", "load-velocity=lagged", "--quantity", "final(U2@REF)"],
        &["study", "input/ogive.inp", "--refine", "increment=1000,1", "--quantity", "final(U2@REF)"],
        &["study", "input/ogive.inp", "--quantity", "final(U2@REF)"],
        &["study", "input/ogive.inp", "--ablate", "--quantity", "final(U2@REF)", "--exact", "1"],
    ] {
        let output = revolve(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", text(&output.stderr));
        assert!(text(&output.stderr).contains("error"), "{arguments:?}");
    }
}

#[test]
fn the_ledger_of_the_seed_deck_is_pinned() {
    let output = revolve(&["check", "--no-look", "input/ogive.inp"]);
    assert!(output.status.success());
    insta::assert_snapshot!(text(&output.stdout));
}

/// A run names its effects in one line, or prints the ledger; the table at its end has the units of the deck.
#[test]
fn a_run_names_its_effects_and_units() {
    let run = ["run", "input/ogive.inp", "--no-frames", "--out", "target/tests/names_of_effects"];
    let brief = text(&revolve(&run).stdout);
    let first = brief.lines().next().unwrap_or_default();
    assert!(first.starts_with("effects: ") && first.contains("cavity expansion, target"), "{brief}");
    let unit = |column: &str| {
        let line = brief.lines().find(|line| line.trim_start().starts_with(column));
        line.and_then(|line| line.split_whitespace().last()).unwrap_or_default().to_owned()
    };
    assert_eq!(["U2@REF", "V2@REF", "ALLKE"].map(unit), ["m", "m/s", "J"], "{brief}");
    let whole = text(&revolve(&[&run[..], &["--ledger"]].concat()).stdout);
    assert!(whole.trim_start().starts_with("effect ") && whole.contains("ogive.inp:"), "{whole}");
}

/// A quantity that is given twice is evaluated once, also with an estimate of its uncertainty.
#[test]
fn repeated_quantity_is_evaluated_once() {
    let quantity = ["--quantity", "final(U2@REF)"];
    let run = ["run", "input/ogive.inp", "--no-frames", "--json", "--out", "target/tests/repeated_quantity"];
    for more in [&[][..], &["--uncertainty"]] {
        let output = revolve(&[&run[..], &quantity, &quantity, more].concat());
        assert!(output.status.success(), "{}", text(&output.stderr));
        let found: serde_json::Value = serde_json::from_slice(&output.stdout).expect("an object");
        assert_eq!(found["quantities"].as_object().map(serde_json::Map::len), Some(1));
        if !more.is_empty() {
            assert_eq!(found["certificate"]["quantities"].as_array().map(Vec::len), Some(1));
        }
    }
}

/// Each file of `input/materials` is listed with the name of its material and its range.
#[test]
fn explain_lists_all_ready_materials() {
    let listed = text(&revolve(&["explain", "materials"]).stdout);
    let files = std::fs::read_dir(project("input/materials")).expect("a folder");
    let files = files.map(|f| f.expect("a file").path()).filter(|f| f.extension().is_some_and(|e| e == "inp"));
    for file in files {
        let name = file.file_name().and_then(|n| n.to_str()).expect("a name").to_owned();
        if name.ends_with("_failure.inp") || name == "one_element.inp" {
            continue;
        }
        let content = std::fs::read_to_string(&file).expect("a file");
        let material = content.split("Material name: ").nth(1).and_then(|rest| rest.split('.').next());
        let line = listed.lines().find(|line| line.trim_start().starts_with(&name));
        let line = line.unwrap_or_else(|| panic!("{name} is not listed"));
        assert!(line.contains(material.expect("a material name")), "{line}");
        let range = content.split("Range: ").nth(1).expect("a range").to_owned();
        let last = line.rsplit("  ").next().expect("a range");
        let numbers = |text: &str| {
            let is_number = |word: &&str| word.starts_with(|c: char| c.is_ascii_digit());
            text.split([' ', ',', '\n']).filter(is_number).map(str::to_owned).collect::<Vec<_>>()
        };
        let given = numbers(&range);
        assert!(numbers(last).iter().all(|number| given.contains(number)), "{line}: {range}");
    }
}

#[test]
fn explain_knows_keywords_and_every_code() {
    assert!(text(&revolve(&["explain", "cavity", "expansion"]).stdout).contains("CAVITY EXPANSION"));
    for code in revolve::explain::codes() {
        assert!(revolve::explain::explain(code.code).is_some_and(|t| t.contains(code.text)));
    }
}

/// Options that are defined once, with the beginning of their help, and the commands that have them. The others do not run
/// decks (`threads`), write no folder of results (`out`), draw no pictures (`label`), or print no result (`json`).
const SHARED_OPTIONS: [(&str, &str, &[&str]); 6] = [
    (
        "--threads",
        "<N> Number of threads (default: all cores;",
        &["run", "study", "sweep", "scatter", "sensitivity", "limit", "identify", "material"],
    ),
    ("--no-frames", "Write no frames,", &["run"]),
    (
        "--out",
        "<FOLDER> Result folder (default: out/<deck name>)",
        &["run", "study", "sweep", "scatter", "sensitivity", "limit", "identify", "material"],
    ),
    (
        "--label",
        "<COLUMN=TEXT> Label shown in pictures for a quantity, a column or a parameter,",
        &["study", "sweep", "scatter", "sensitivity", "limit", "identify", "report", "material", "chart"],
    ),
    (
        "--json",
        "Print only one JSON object",
        &["run", "study", "check", "sweep", "scatter", "sensitivity", "limit", "identify", "resistance", "material"],
    ),
    (
        "--quiet",
        "Print errors only",
        &[
            "run",
            "study",
            "check",
            "sweep",
            "scatter",
            "sensitivity",
            "limit",
            "identify",
            "report",
            "resistance",
            "material",
            "chart",
            "new",
        ],
    ),
];

/// Each command has the shared options of the table, with one description. `-o` of the other commands is one file, or the
/// folder of an example.
#[test]
fn commands_have_the_shared_options() {
    let commands = [
        "run",
        "study",
        "check",
        "explain",
        "sweep",
        "scatter",
        "sensitivity",
        "limit",
        "identify",
        "report",
        "resistance",
        "material",
        "chart",
        "view",
        "new",
        "lsp",
        "completions",
        "man",
    ];
    let help = |command: &&str| {
        let help = text(&revolve(&[command, "--help"]).stdout);
        help.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let helps: Vec<(&str, String)> = commands.iter().map(|command| (*command, help(command))).collect();
    for (option, description, having) in SHARED_OPTIONS {
        let words = format!("{option} {description}");
        let with: Vec<&str> = helps.iter().filter(|(_, help)| help.contains(&words)).map(|(name, _)| *name).collect();
        assert_eq!(with, having, "{option}");
        let otherwise =
            helps.iter().filter(|(name, help)| !having.contains(name) && help.contains(&format!("{option} ")));
        let otherwise: Vec<&str> = otherwise.map(|(name, _)| *name).collect();
        let allowed: &[&str] = if option == "--out" { &["report", "chart", "new"] } else { &[] };
        assert_eq!(otherwise, allowed, "{option}");
    }
}

/// `study` accepts all shared options: the values are those of any number of threads, and the picture has the label.
#[test]
fn study_has_the_shared_options() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_str().expect("a name").to_owned();
    let bar = grid(2, 4, false, |i, j| [0.5 * i as f64, 0.5 * j as f64])
        + &material(1.0, 0.3, 1.0, "*Initial Conditions, type=VELOCITY\n J1, 2, 0.01\n*Nset, nset=TIP\n 13\n")
        + "*Step\n*Dynamic, Explicit\n , 2.\n*Boundary\n J0, 2, 2\n*Output, history, number interval=5\n*Node Output, nset=TIP\n U2\n*End Step\n";
    std::fs::write(path("bar.inp"), bar).expect("a deck");
    let (deck, out) = (path("bar.inp"), path("out"));
    let study = |more: &[&str]| {
        let words = ["study", &deck, "--refine", "increment=0.5,0.25", "--quantity", "final(U2@TIP)", "--repeat", "1"];
        let output = revolve(&[&words[..], &["--jitter", "0", "--out", &out, "--quiet", "--json"], more].concat());
        assert!(output.status.success(), "{}", text(&output.stderr));
        let record: serde_json::Value = serde_json::from_str(&text(&output.stdout)).expect("JSON");
        record["runs"].as_array().expect("runs").iter().map(|row| row["value"].as_f64()).collect::<Vec<_>>()
    };
    let one = study(&["--threads", "1", "--label", "final(U2@TIP)=depth of the tip"]);
    let picture = std::fs::read_to_string(path("out/bar_study_order.svg")).expect("a picture");
    assert!(picture.contains("depth of the tip") && !picture.contains("final(U2@TIP)"), "{picture}");
    assert_eq!(one, study(&["--threads", "2"]));
    let words = ["study", &deck, "--refine", "increment=0.5,0.25", "--quantity", "final(U2@TIP)", "--label", "U2=x"];
    let wrong = revolve(&words);
    assert!(!wrong.status.success() && text(&wrong.stderr).contains("there is no quantity `U2`"));
}

/// Each warning of a run is issued with a code, all codes from R301 on are those of such warnings, and each is explained. The
/// gauntlet checks the warnings of its runs.
#[test]
fn every_warning_of_a_run_has_a_code_with_an_explanation() {
    let mut issued = Vec::new();
    for folder in
        ["src/solver/solve", "src/analysis/command", "src/analysis/study", "src/numerics/constraint", "src/solver/job"]
    {
        for file in std::fs::read_dir(project(folder)).expect("a folder").map(|entry| entry.expect("an entry").path()) {
            let Ok(source) = std::fs::read_to_string(&file) else { continue };
            let pushes = source.matches("warnings.push(format!").count();
            assert_eq!(
                pushes,
                usize::from(file.ends_with("solve/outcome.rs")),
                "{}: use Outcome::warn",
                file.display()
            );
            let codes = source.match_indices("\"R3").map(|(at, _)| source[at + 1..at + 5].to_owned());
            let printed = source.match_indices("warning: R3").map(|(at, _)| source[at + 9..at + 13].to_owned());
            issued.extend(codes.chain(printed));
        }
    }
    issued.sort();
    issued.dedup();
    let explained: Vec<&str> =
        revolve::explain::codes().map(|c| c.code).filter(|code| code.starts_with("R3")).collect();
    assert_eq!(issued, explained);
    for code in issued {
        let output = revolve(&["explain", &code]);
        assert!(output.status.success() && text(&output.stdout).starts_with(&code), "{code}");
    }
}

/// A reference table without a row for some value of the sweep is rejected before any run.
#[test]
fn reference_without_matching_rows_is_rejected() {
    let folder = tempfile::tempdir().expect("a folder");
    let table = folder.path().join("other.csv");
    std::fs::write(&table, "V,depth\n12,3\n").expect("a table");
    let (table, out) = (table.to_str().expect("a name"), folder.path().to_str().expect("a name"));
    let sweep = ["sweep", "input/ogive.inp", "--set", "V=569,570", "--quantity", "final(U2@REF)"];
    let output = revolve(&[&sweep[..], &["--compare", table, "--out", out]].concat());
    let rendered = text(&output.stderr);
    assert!(
        !output.status.success()
            && rendered.contains("no row has V = 569 or 570; the values of the first column are 12"),
        "{rendered}"
    );
}

#[test]
fn sweep_writes_table_and_picture_independent_of_threads() {
    let folder = tempfile::tempdir().expect("a folder");
    let table = |threads: &str| {
        let out = folder.path().join(threads);
        let output = revolve(&[
            "sweep",
            "input/ogive.inp",
            "--set",
            "V=569,570,679,821,966,1147",
            "--quantity",
            "-1000*final(U2@REF)",
            "--compare",
            "input/reference/piekutowski_1999.csv",
            "--threads",
            threads,
            "--out",
            out.to_str().expect("a name"),
        ]);
        assert!(output.status.success(), "{}", text(&output.stderr));
        for picture in ["ogive_sweep.svg", "ogive_sweep.png"] {
            assert!(std::fs::metadata(out.join(picture)).expect("a picture").len() > 2000);
        }
        std::fs::read_to_string(out.join("ogive_sweep.csv")).expect("a table")
    };
    let (one, two, five) = (table("1"), table("2"), table("5"));
    assert_eq!(one, two);
    assert_eq!(one, five);
    assert_eq!(one.lines().count(), 7);
    assert!(
        one.lines().nth(1).is_some_and(|l| l.starts_with("569,64.85") && l.contains(",58,") && l.contains(",67.1,"))
    );
}

/// Measured values in the table of samples are compared run by run, also if several parameters vary and a value of the
/// first one occurs twice.
#[test]
fn samples_are_compared_with_a_measured_column() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).to_str().expect("a name").to_owned();
    let (table, out) = (at("shots.csv"), at("out"));
    let quantity = "-1000*final(U2@REF)";
    let sweep = ["sweep", "input/ogive.inp", "--samples", &table, "--quantity", quantity, "--out", &out];
    std::fs::write(&table, "V,mass\n569,0.021\n569,0.023\n821,0.021\n").expect("a table");
    let runs: serde_json::Value =
        serde_json::from_slice(&revolve(&[&sweep[..], &["--json"]].concat()).stdout).expect("an object");
    let depth = |i: usize| runs["runs"][i]["values"][quantity].as_f64().expect("a depth");
    // The predictions are 5 % above, 15 % below and 30 % above the measured values.
    let measured = [depth(0) / 1.05, depth(1) / 0.85, depth(2) / 1.3];
    let row = |(first, depth): (&str, f64)| format!("{first},{depth:e}\n");
    let rows: String = ["569,0.021", "569,0.023", "821,0.021"].into_iter().zip(measured).map(row).collect();
    std::fs::write(&table, format!("V,mass,depth\n{rows}")).expect("a table");
    let compare = [&sweep[..], &["--compare-column", "depth"]].concat();
    let found: serde_json::Value =
        serde_json::from_slice(&revolve(&[&compare[..], &["--json"]].concat()).stdout).expect("an object");
    let agreement = |key: &str| found["agreement"]["depth"][key].as_f64().expect("a number");
    let expected = [0.2 / 3.0, ((0.05_f64.powi(2) + 0.15_f64.powi(2) + 0.3_f64.powi(2)) / 3.0).sqrt()];
    assert!((agreement("relative_bias") - expected[0]).abs() < 1e-9, "{found}");
    assert!((agreement("relative_rms") - expected[1]).abs() < 1e-9, "{found}");
    let bias: f64 = (0..3).map(|i| depth(i) - measured[i]).sum::<f64>() / 3.0;
    assert!((agreement("bias") - bias).abs() < 1e-9 && found["rms"]["depth"] == found["agreement"]["depth"]["rms"]);
    let printed = text(&revolve(&compare).stdout);
    assert!(printed.contains("33.3 % of the rows within 10 %, 66.7 % within 20 %"), "{printed}");
    for file in ["ogive_sweep.csv", "ogive_sweep.png", "ogive_sweep_measured.svg", "ogive_sweep_measured.png"] {
        assert!(folder.path().join("out").join(file).exists(), "{file}");
    }
    let output = revolve(&[&sweep[..], &["--compare-column", "dpth"]].concat());
    let errors = text(&output.stderr);
    assert!(output.status.code() == Some(2) && errors.contains("it has V, mass, depth"), "{errors}");
}

/// Two checks of a deck give the same text, also on a busy machine; the measured run time is a note on standard error.
#[test]
fn checks_of_a_deck_give_the_same_text() {
    let folder = std::fs::read_dir(project("input")).expect("decks");
    let mut decks: Vec<_> = folder.map(|entry| entry.expect("an entry").path()).collect();
    decks.retain(|path| path.extension().is_some_and(|extension| extension == "inp"));
    assert!(decks.len() > 20);
    let mut timed = 0;
    for deck in decks {
        let name = deck.to_str().expect("a name").to_owned();
        // Both at the same time: they disturb each other.
        let check = || revolve(&["check", &name]);
        let [first, second] = std::thread::scope(|scope| {
            [scope.spawn(check), scope.spawn(check)].map(|thread| thread.join().expect("an output"))
        });
        let text = String::from_utf8_lossy(&first.stdout).into_owned();
        assert_eq!(text, String::from_utf8_lossy(&second.stdout), "{name}");
        assert!(!text.contains("on this machine"), "{text}");
        timed += usize::from(String::from_utf8_lossy(&first.stderr).contains("note: run time on this machine"));
    }
    assert!(timed > 10, "{timed}");
}
