//! Injected faults for all commands. `faults.rs` covers kills, signals and full disks of `run` and `--resume`; this
//! file covers the other commands, and files that are truncated or changed before they are read.
//!
//! Goal: the correct answer or a message that names the file; never a panic, a hang, or a wrong number without a
//! message. Source: the same command undisturbed. Tolerance: none. Moments and places are random with a seed.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use revolve::output::drawing::Drawing;
use revolve::report::meridian::{ColourRange, FieldOptions, RunFrames};
use revolve::report::{self, ReportError};

use crate::common::bodies::between;
use crate::common::project;

/// Commands that read a deck and write into the folder `out`, and commands that read this folder.
const COMMANDS: [&str; 5] = ["run", "sweep", "study", "report", "chart"];

fn words(command: &str) -> Vec<&str> {
    let depth = "-1000*final(U2@REF)";
    match command {
        "run" => vec!["run", "ogive.inp", "--out", "out", "--quiet"],
        "sweep" => vec!["sweep", "ogive.inp", "--set", "V=500,600", "--quantity", depth, "--out", "out"],
        "study" => {
            vec![
                "study",
                "ogive.inp",
                "--refine",
                "increment=1,0.5",
                "--repeat",
                "1",
                "--quantity",
                depth,
                "--out",
                "out",
            ]
        }
        "report" => vec!["report", "out"],
        _ => vec!["chart", "out", "--field", "PRESSURE", "--out", "out/chart.svg"],
    }
}

/// Returns a command under a limit of the shell's `ulimit`, with a time limit.
fn limited(folder: &Path, limit: &str, command: &str) -> Command {
    let mut shell = Command::new("sh");
    let line = format!("ulimit {limit}; exec timeout -k 5 100 \"$0\" \"$@\"");
    shell.args(["-c", &line, env!("CARGO_BIN_EXE_revolve")]).args(words(command));
    shell.current_dir(folder).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    shell
}

fn ran(folder: &Path, limit: &str, command: &str) -> Output {
    limited(folder, limit, command).output().expect("the program runs")
}

fn message_text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Returns a folder with a deck and the undisturbed results of all commands.
fn scene() -> (tempfile::TempDir, BTreeMap<String, Vec<u8>>) {
    let scratch = tempfile::tempdir().expect("a folder");
    fs::copy(project("input/ogive.inp"), scratch.path().join("ogive.inp")).expect("a deck");
    for command in COMMANDS {
        let output = ran(scratch.path(), "-c 0", command);
        assert!(output.status.success(), "{command}: {}", message_text(&output));
    }
    let results = results(&scratch.path().join("out"));
    assert!(results.len() > 25, "{:?}", results.keys());
    (scratch, results)
}

/// Returns the files of a folder that are identical in every run; files with times are left out.
fn results(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let timed = |name: &str| ["ogive.json", "ogive.sfv", "report.html"].contains(&name) || name.contains("_study");
    let entries = fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").path());
    let name = |path: &PathBuf| path.file_name().and_then(|n| n.to_str()).expect("a name").to_owned();
    entries.filter(|p| !timed(&name(p))).map(|p| (name(&p), fs::read(&p).expect("a file"))).collect()
}

/// Asserts that all files are complete and that the same command then gives the undisturbed files.
fn check(folder: &Path, what: &str, command: &str, whole: &BTreeMap<String, Vec<u8>>) {
    for entry in fs::read_dir(folder.join("out")).into_iter().flatten().flatten() {
        let (name, bytes) = (entry.file_name().into_string().expect("a name"), fs::read(entry.path()).expect("a file"));
        let complete = match name.rsplit_once('.').map(|n| n.1) {
            // A torn last line of a list of finished runs is run again.
            _ if name.starts_with(".revolve-") || name.ends_with("_log.csv") => true,
            Some("vtu" | "pvd") => bytes.ends_with(b"</VTKFile>\n"),
            Some("json" | "setup") => serde_json::from_slice::<serde_json::Value>(&bytes).is_ok(),
            Some("html") => bytes.trim_ascii_end().ends_with(b"</html>"),
            Some("svg") => bytes.trim_ascii_end().ends_with(b"</svg>"),
            Some("tar") => bytes.len().is_multiple_of(512) && bytes.ends_with(&[0; 1024]),
            Some("png") => bytes.ends_with(b"IEND\xaeB`\x82"),
            _ => bytes.ends_with(b"\n"),
        };
        assert!(complete, "{what}, {command}: {name} is torn");
    }
    let again = ran(folder, "-c 0", command);
    assert!(again.status.success(), "{what}, {command}: {}", message_text(&again));
    let now = results(&folder.join("out"));
    let own = |name: &str| match command {
        "run" => !name.contains("_sweep") && !name.starts_with("chart"),
        "sweep" => name.contains("_sweep"),
        "chart" => name == "chart.svg",
        _ => false,
    };
    for (name, bytes) in whole.iter().filter(|(name, _)| own(name)) {
        assert!(now.get(name) == Some(bytes), "{what}, {command}: {name} is another");
    }
}

fn sound(output: &Output, what: &str, command: &str) {
    let words = message_text(output);
    assert!(!words.contains("panicked"), "{what}, {command}: {words}");
    assert!(output.status.code() != Some(124), "{what}, {command} hangs");
    assert!(output.status.success() || !words.is_empty(), "{what}, {command}: {:?} without a message", output.status);
}

#[test]
fn kills_leave_complete_files_and_no_lock() {
    let (scratch, whole) = scene();
    let mut dice = between(20_261);
    for command in COMMANDS {
        let begin = Instant::now();
        ran(scratch.path(), "-c 0", command);
        let seconds = begin.elapsed().as_secs_f64();
        for _ in 0..4 {
            let mut child = Command::new(env!("CARGO_BIN_EXE_revolve"))
                .args(words(command))
                .current_dir(scratch.path())
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
                .expect("the program runs");
            std::thread::sleep(Duration::from_secs_f64(dice(0.0, seconds)));
            child.kill().expect("killed");
            child.wait().expect("a status");
        }
        check(scratch.path(), "killed", command, &whole);
    }
}

#[test]
fn full_disk_is_reported() {
    let (scratch, whole) = scene();
    let mut refused = 0;
    for command in COMMANDS {
        for blocks in [0, 1, 8, 40] {
            let output = ran(scratch.path(), &format!("-f {blocks}"), command);
            sound(&output, &format!("{blocks} blocks"), command);
            refused += usize::from(!output.status.success());
        }
        check(scratch.path(), "full disk", command, &whole);
    }
    assert!(refused > 8, "{refused} commands failed at a limit");
}

#[test]
fn too_little_memory_is_reported_or_ends_the_program() {
    let (scratch, whole) = scene();
    let mut ended = 0;
    for command in COMMANDS {
        // With less memory the program itself is not loaded.
        for kilobytes in [41_000, 42_000, 43_000, 46_000, 60_000, 90_000, 200_000] {
            let output = ran(scratch.path(), &format!("-v {kilobytes}"), command);
            sound(&output, &format!("{kilobytes} kB"), command);
            ended += usize::from(!output.status.success());
        }
        check(scratch.path(), "little memory", command, &whole);
    }
    assert!(ended > 4, "{ended} commands failed at a limit");
}

/// The modification times of files have no influence.
#[test]
fn clocks_that_jump_change_nothing() {
    let (scratch, whole) = scene();
    for date in ["1970-01-02", "2106-02-07"] {
        for entry in fs::read_dir(scratch.path().join("out")).expect("a folder").flatten() {
            Command::new("touch").args(["-d", date]).arg(entry.path()).status().expect("touch runs");
        }
        Command::new("touch").args(["-d", date]).arg(scratch.path().join("ogive.inp")).status().expect("touch runs");
        for command in COMMANDS {
            check(scratch.path(), date, command, &whole);
        }
    }
}

/// Draws the pressure of the last frame.
fn pressure_picture(folder: &Path) -> Result<Drawing, ReportError> {
    let options = FieldOptions { field: "PRESSURE".into(), range: ColourRange::Frame, smooth: false, window: None };
    RunFrames::of(folder)?.drawing(None, &options)
}

/// Asserts that `report` and `chart` give the undisturbed answer or an error that names a file; returns whether there
/// was an error.
fn read_back(folder: &Path, changed: &str, whole: &[String; 2]) -> bool {
    let page = report::gather(folder).map(|page| serde_json::to_string(&page).expect("a page"));
    let picture = pressure_picture(folder).map(|picture| picture.svg());
    let mut refused = false;
    for (answer, whole) in [page.map_err(|e| e.to_string()), picture.map_err(|e| e.to_string())].into_iter().zip(whole)
    {
        match answer {
            // Files missing from a damaged list are reported as unverified.
            Ok(answer) => {
                assert!(
                    answer == *whole || answer.contains("checksums"),
                    "{changed}: another answer without a message"
                );
            }
            Err(why) => {
                assert!(why.contains("ogive") || why.contains("page"), "{changed}: {why}");
                refused = true;
            }
        }
    }
    refused
}

#[test]
fn truncated_and_changed_results_are_reported() {
    let (scratch, _) = scene();
    let out = scratch.path().join("out");
    fs::remove_file(out.join("report.html")).expect("removed");
    let whole = [
        serde_json::to_string(&report::gather(&out).expect("a page")).expect("JSON"),
        pressure_picture(&out).expect("a picture").svg(),
    ];
    let mut dice = between(4711);
    let (mut cases, mut refused) = (0, 0);
    for name in [
        "ogive.json",
        "ogive.pvd",
        "ogive_history.csv",
        "ogive_0000.vtu",
        "ogive_0020.vtu",
        "ogive_sweep.csv",
        "ogive_study.json",
        "ogive.sfv",
        "ogive_sweep.sfv",
    ] {
        let path = out.join(name);
        let bytes = fs::read(&path).expect("a file");
        for i in 0..30 {
            let at = dice(0.0, bytes.len() as f64) as usize;
            let mut other = bytes.clone();
            if i % 2 == 0 {
                other.truncate(at);
            } else {
                other[at] ^= 1 << (dice(0.0, 8.0) as u32);
            }
            fs::write(&path, &other).expect("a file");
            cases += 1;
            refused += usize::from(read_back(&out, &format!("{name}, {at}"), &whole));
        }
        fs::write(&path, &bytes).expect("a file");
    }
    println!("{cases} files truncated or with a flipped bit, {refused} rejected, the others give the same answer");
    assert!(refused > cases / 2, "{refused} of {cases}");
    // Without the list of checksums changes cannot be detected, which is reported; nothing panics.
    fs::remove_file(out.join("ogive.sfv")).expect("removed");
    let page = report::gather(&out).expect("a page");
    assert!(page.runs[0].notes.iter().any(|note| note.contains("checksums")), "{:?}", page.runs[0].notes);
    for name in ["ogive.json", "ogive.pvd", "ogive_history.csv", "ogive_0000.vtu", "ogive_0020.vtu"] {
        let path = out.join(name);
        let bytes = fs::read(&path).expect("a file");
        for _ in 0..60 {
            let mut other = bytes.clone();
            let at = dice(0.0, other.len() as f64) as usize;
            other[at] ^= 1 << (dice(0.0, 8.0) as u32);
            fs::write(&path, &other).expect("a file");
            let _ = report::gather(&out).map(|page| report::html(&page));
            let _ = pressure_picture(&out);
        }
        fs::write(&path, &bytes).expect("a file");
    }
}

/// A frame list must not refer to files outside its folder.
#[test]
fn frame_list_cannot_leave_its_folder() {
    let (scratch, _) = scene();
    let list = scratch.path().join("out/ogive.pvd");
    fs::remove_file(scratch.path().join("out/ogive.sfv")).expect("removed");
    let text = fs::read_to_string(&list).expect("a list");
    fs::write(&list, text.replace("ogive_0000", "../out/ogive_0000")).expect("a list");
    let why = report::gather(&scratch.path().join("out")).expect_err("refused").to_string();
    assert!(why.contains("ogive.pvd") && why.contains("not a frame in this folder"), "{why}");
}

#[test]
fn truncated_reference_is_reported() {
    let (scratch, _) = scene();
    let path = scratch.path().join("known.csv");
    let text = "V,depth\n500,41.25\n600,58.75\n";
    for end in 0..text.len() {
        fs::write(&path, &text[..end]).expect("a table");
        let mut command = limited(scratch.path(), "-c 0", "sweep");
        let output = command.args(["--compare", "known.csv"]).output().expect("the program runs");
        sound(&output, "a torn table", "sweep");
        // Complete rows are valid; an incomplete row is rejected or reported.
        let rows = text[..end].ends_with('\n') && text[..end].lines().count() > 1;
        assert!(rows || message_text(&output).contains("known.csv"), "{end}: {}", message_text(&output));
    }
}
