//! Sweeps in parts, and interfaces for programs that distribute cases: lists of cases, job arrays, Dakota's files.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::common::{project, revolve};

const RANDOM: [&str; 8] = ["--random", "7", "--seed", "3", "--set", "V=600..900", "--quantity", "-1000*final(U2@REF)"];

fn printed(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn sweep(words: &[&str]) -> Output {
    revolve(&[&["sweep", "input/ogive.inp"], words].concat())
}

#[test]
fn gathered_parts_match_the_whole_sweep() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).to_str().expect("a name").to_owned();
    let (whole, parts) = (at("whole"), at("parts"));
    let run = |more: &[&str]| sweep(&[&RANDOM[..], more].concat());
    printed(&run(&["--out", &whole]));
    printed(&run(&["--out", &parts, "--cases", "2/2", "--threads", "1"]));
    let early = run(&["--out", &parts, "--gather"]);
    let message_text = String::from_utf8_lossy(&early.stderr).into_owned();
    assert!(!early.status.success() && message_text.contains("cases 1-3 are missing"), "{message_text}");
    // A task of a job array, one part run twice, and a single case that another part contains as well.
    let task = Command::new(env!("CARGO_BIN_EXE_revolve"))
        .args([&["sweep", "input/ogive.inp"], &RANDOM[..], &["--out", &parts, "--cases", "task/2"]].concat())
        .env("HQ_TASK_ID", "1")
        .current_dir(project(""))
        .output();
    printed(&task.expect("the program runs"));
    printed(&run(&["--out", &parts, "--cases", "2/2"]));
    printed(&run(&["--out", &parts, "--cases", "5"]));
    printed(&run(&["--out", &parts, "--gather"]));
    for ending in ["csv", "svg", "png"] {
        let [a, b] = [&whole, &parts].map(|f| fs::read(format!("{f}/ogive_sweep.{ending}")).expect("a file"));
        assert!(a == b, "{ending} differs");
    }
    // With another seed.
    let words: Vec<&str> = RANDOM.iter().map(|w| if *w == "3" { "4" } else { w }).collect();
    let other = sweep(&[&words[..], &["--out", &parts, "--gather"]].concat());
    assert!(!other.status.success() && String::from_utf8_lossy(&other.stderr).contains("different sweep"));
}

#[test]
fn list_of_cases_is_a_table_of_samples() {
    let folder = tempfile::tempdir().expect("a folder");
    let list = printed(&sweep(&[&RANDOM[..], &["--plan"]].concat()));
    assert!(list.starts_with("case,V\n1,") && list.lines().count() == 8, "{list}");
    assert_eq!(printed(&sweep(&[&RANDOM[..], &["--plan", "--cases", "3-4"]].concat())).lines().count(), 3);
    let samples: String = list.lines().map(|l| format!("{}\n", l.split_once(',').expect("two columns").1)).collect();
    let file = folder.path().join("samples.csv");
    fs::write(&file, samples).expect("a file");
    let out = |name: &str| folder.path().join(name).to_str().expect("a name").to_owned();
    printed(&sweep(&[&RANDOM[..], &["--out", &out("a")]].concat()));
    printed(&sweep(&["--samples", file.to_str().expect("a name"), RANDOM[6], RANDOM[7], "--out", &out("b")]));
    let table = |name: &str| fs::read_to_string(Path::new(&out(name)).join("ogive_sweep.csv")).expect("a table");
    assert_eq!(table("a"), table("b"));
}

/// Returns a parameters file as Dakota 6.16 and newer write it.
fn dakota_input(id: &str, speed: &str) -> String {
    format!(
        "                                          1 variables\n{speed:>43} V\n                                          1 functions\n\
         {:>43} ASV_1:depth\n{:>43} derivative_variables\n{:>43} DVV_1:V\n{:>43} analysis_components\n{id:>43} eval_id\n{:>43} metadata\n",
        1, 1, 1, 0, 0
    )
}

#[test]
fn dakota_files_are_read_and_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).to_str().expect("a name").to_owned();
    let answer = |text: &str, name: &str| {
        fs::write(at("params.in"), text).expect("a file");
        let words = ["--quantity", "-1000*final(U2@REF)", "--dakota", &at("params.in"), &at(name)];
        (sweep(&words), fs::read_to_string(at(name)).unwrap_or_default())
    };
    let table = at("out");
    printed(&sweep(&["--set", "V=600,700", "--quantity", "-1000*final(U2@REF)", "--out", &table]));
    let table = fs::read_to_string(Path::new(&table).join("ogive_sweep.csv")).expect("a table");
    let known: Vec<f64> =
        table.lines().skip(1).map(|l| l.split(',').nth(1).expect("a value").parse().expect("a number")).collect();
    let same = |text: &str, known: f64| {
        let value: f64 = text.trim().parse().expect("a number");
        assert!((value / known - 1.0).abs() < 1e-6, "{value} and {known}");
    };
    let (output, one) = answer(&dakota_input("4", "6.000000000000000e+02"), "one.out");
    printed(&output);
    same(one.strip_suffix("depth\n").expect("its label"), known[0]);
    // The third sample of the batch has an invalid velocity.
    let batch = dakota_input("1:1", "7.0e+02") + &dakota_input("1:2", "6.0e+02") + &dakota_input("1:3", "nan");
    let (output, many) = answer(&batch, "many.out");
    printed(&output);
    let blocks: Vec<&str> = many.split("#\n").collect();
    assert_eq!((blocks.len(), blocks[0], blocks[3]), (4, "", "FAIL\n"), "{many}");
    same(blocks[1].strip_suffix("depth\n").expect("its label"), known[1]);
    assert_eq!(blocks[2], one);
    let object = r#"[{"variables": [{"label": "V", "value": 600.0}], "responses": [{"label": "depth", "active_set": 1}],
        "eval_id": "2:1", "metadata": [], "derivative_variables": [1], "analysis_components": []}]"#;
    let (output, answered) = answer(object, "json.out");
    printed(&output);
    let answered: serde_json::Value = serde_json::from_str(&answered).expect("JSON");
    same(&answered[0]["functions"]["depth"].to_string(), known[0]);
    // A gradient follows the value. Source: differences of the depth over 1 m/s in increments.
    let (output, both) = answer(&dakota_input("4", "600").replace("1 ASV", "3 ASV"), "gradient.out");
    printed(&output);
    let (value, gradient) = both.split_once("depth\n").expect("its label");
    same(value, known[0]);
    let gradient = gradient.trim().trim_start_matches('[').trim_end_matches(']').trim();
    let near = ["599", "601"].map(|speed| {
        let (output, depth) = answer(&dakota_input("4", speed), "near.out");
        printed(&output);
        depth.trim().trim_end_matches("depth").trim().parse::<f64>().expect("a number")
    });
    let slope: f64 = gradient.parse().expect("a number");
    assert!((0.5 * (near[1] - near[0]) / slope - 1.0).abs() < 1e-3, "{slope} {near:?}");
    // An invalid deck gives a failed evaluation, because Dakota waits for a results file.
    let (output, failed) = answer(&dakota_input("4", "nan"), "failed.out");
    assert_eq!((output.status.code(), &*failed), (Some(2), "FAIL\n"));
    // An invalid parameters file gives no results file.
    let (output, nothing) = answer(&dakota_input("4", "600").replace("1 ASV", "4 ASV"), "none.out");
    let message_text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        !output.status.success() && nothing.is_empty() && message_text.contains("second derivatives of depth"),
        "{message_text}"
    );
}
