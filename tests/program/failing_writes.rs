//! The n-th call that changes the result folder fails, for every n: creation, write, flush, renaming, removal.
//!
//! Goal: after each failure the folder is complete, or the program ends with an error that names the file and the cause. No
//! file is incomplete, no summary says that the run is completed, and the command, continued or repeated, gives the same
//! files as an undisturbed one. The calls fail in a library that the system's loader adds to the program (`LD_PRELOAD`).
#![cfg(target_os = "linux")]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::common::{fortran, project};
use crate::faults::{FaultCase, results};

/// How a call fails.
#[derive(Clone, Copy, Debug)]
struct Failure {
    /// Value of `errno`, and its text.
    error: (i32, &'static str),
    /// `once`, `rest` or `short`, see failing_writes.c.
    mode: &'static str,
}

const NO_SPACE: (i32, &str) = (28, "No space left on device");
const INPUT_OUTPUT: (i32, &str) = (5, "Input/output error");
const FAILURES: [Failure; 4] = [
    Failure { error: NO_SPACE, mode: "once" },
    Failure { error: NO_SPACE, mode: "rest" },
    Failure { error: NO_SPACE, mode: "short" },
    Failure { error: INPUT_OUTPUT, mode: "once" },
];

/// States of a folder after failed calls. The same state needs to be continued once only: several calls of a write fail with
/// the same files.
#[derive(Default)]
struct FolderStates(BTreeSet<BTreeMap<String, Vec<u8>>>);

impl FolderStates {
    /// Adds the state of a folder; returns whether it is new. Times in files, and the letters at the end of temporary names, are
    /// not part of the state.
    fn is_new(&mut self, folder: &Path) -> bool {
        let mut files = BTreeMap::new();
        add_state(folder, "", &mut files);
        self.0.insert(files)
    }
}

fn add_state(folder: &Path, prefix: &str, files: &mut BTreeMap<String, Vec<u8>>) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries {
        let path = entry.expect("an entry").path();
        let mut name = path.file_name().expect("a name").to_str().expect("a name").to_owned();
        if name.starts_with(".revolve-") && name != ".revolve-lock" {
            name = name.rsplit_once('-').expect("random letters").0.to_owned();
        }
        if path.is_dir() {
            files.insert(format!("{prefix}{name}/"), Vec::new());
            add_state(&path, &format!("{prefix}{name}/"), files);
            continue;
        }
        let bytes = fs::read(&path).expect("a file");
        let has_times =
            ["json", "sta", "sfv", "html", "setup"].iter().any(|ending| name.ends_with(&format!(".{ending}")));
        let is_whole = bytes.ends_with(b"\n") || bytes.ends_with(b"}");
        let content = if has_times { vec![u8::from(bytes.is_empty()), u8::from(is_whole)] } else { bytes };
        files.insert(format!("{prefix}{name}"), content);
    }
}

/// Compiles a library that is loaded before the C library, from its source in this folder; `None` without a compiler.
pub(crate) fn preloaded(scratch: &Path, name: &str) -> Option<PathBuf> {
    if !fortran(&name.replace('_', " ")) {
        return None;
    }
    let library = scratch.join(name).with_extension("so");
    let mut compiler = Command::new(std::env::var("CC").unwrap_or_else(|_| "gcc".into()));
    compiler.args(["-shared", "-fPIC", "-O1", "-o"]).arg(&library);
    let source = project("tests/program").join(name).with_extension("c");
    assert!(compiler.arg(source).arg("-ldl").status().expect("a C compiler").success());
    Some(library)
}

/// The library and the file in which it records failed calls.
struct FailingCalls {
    library: PathBuf,
    mark: PathBuf,
}

impl FailingCalls {
    /// Compiles the library; `None` without a compiler.
    fn new(scratch: &Path) -> Option<FailingCalls> {
        Some(FailingCalls { library: preloaded(scratch, "failing_writes")?, mark: scratch.join("mark") })
    }

    /// Runs a command in which call number `call` on the folder fails. Returns its output and the failed call; `None` if the
    /// command has made fewer calls.
    fn run(&self, command: &mut Command, folder: &Path, call: usize, failure: Failure) -> Option<(Output, String)> {
        fs::remove_file(&self.mark).ok();
        command.env("LD_PRELOAD", &self.library).env("FAIL_FOLDER", folder).env("FAIL_MARK", &self.mark);
        command.env("FAIL_CALL", call.to_string()).env("FAIL_ERROR", failure.error.0.to_string());
        let output = command.env("FAIL_MODE", failure.mode).output().expect("the program runs");
        let failed = fs::read_to_string(&self.mark).ok()?;
        Some((output, format!("{failure:?}, call {call}: {failed}")))
    }
}

/// Returns whether the command has succeeded; otherwise it must have named the folder and the cause.
fn has_succeeded(output: &Output, folder: &Path, failure: Failure, context: &str) -> bool {
    let words = String::from_utf8_lossy(&output.stderr);
    match output.status.code() {
        Some(0) => true,
        Some(1 | 2) => {
            let folder = folder.to_str().expect("a name");
            assert!(words.contains(failure.error.1) && words.contains(folder), "{context}: {words}");
            false
        }
        _ => panic!("{context}: {}: {words}", output.status),
    }
}

/// Returns a run of a few milliseconds with frames, histories and checkpoints.
pub fn small_run(scratch: &Path) -> PathBuf {
    let deck = fs::read_to_string(project("input/taylor_copper.inp")).expect("a deck");
    let changes = [
        ("nr = 10", "nr = 2"),
        ("nz = 50", "nz = 6"),
        ("80.e-6", "4.e-6"),
        ("number interval=20", "number interval=2"),
        ("number interval=100", "number interval=4"),
        ("*End Step", "*Restart, write, number interval=2\n*End Step"),
    ];
    let small = changes.iter().fold(deck, |deck, (from, to)| {
        assert!(deck.contains(from), "{from}");
        deck.replace(from, to)
    });
    let path = scratch.join("bar.inp");
    fs::write(&path, small).expect("a deck");
    path
}

#[test]
fn run_loses_nothing_if_any_call_on_its_folder_fails() {
    let scratch = tempfile::tempdir().expect("a folder");
    let Some(calls) = FailingCalls::new(scratch.path()) else { return };
    let case = FaultCase::new("bar", &small_run(scratch.path()), &[], scratch.path());
    let folder = scratch.path().join("results");
    let (mut counts, mut states) = (Vec::new(), FolderStates::default());
    for failure in FAILURES {
        let mut successes = 0;
        for call in 1.. {
            fs::remove_dir_all(&folder).ok();
            let mut command = case.command(Command::new(env!("CARGO_BIN_EXE_revolve")), &folder, &["--threads", "1"]);
            command.stderr(std::process::Stdio::piped());
            let Some((output, context)) = calls.run(&mut command, &folder, call, failure) else {
                counts.push(format!("{failure:?}: {} calls, {successes} harmless", call - 1));
                assert!(call > 50, "{context}", context = counts.join("\n"));
                break;
            };
            case.check(&folder);
            let is_new = states.is_new(&folder);
            let summary = fs::read_to_string(folder.join("bar.json")).unwrap_or_default();
            if has_succeeded(&output, &folder, failure, &context) {
                successes += 1;
                let found = results(&folder);
                let differs = case.results.iter().find(|(name, bytes)| found.get(*name) != Some(bytes));
                assert!(differs.is_none(), "{context}: {:?} differs", differs.map(|file| file.0));
            } else {
                assert!(!summary.contains("\"completed\""), "{context}");
                if is_new {
                    assert_report_is_not_whole(&folder, scratch.path(), &context);
                }
            }
            if is_new {
                fs::create_dir_all(&folder).expect("a folder");
                case.resume(&folder, "1");
            }
        }
    }
    let continued = states.0.len();
    assert!(continued > 10, "{continued} states");
    println!("on this machine: run, failing calls on the result folder, {continued} states\n{}", counts.join("\n"));
}

/// Asserts that the report of a folder after a failure, if there is one, says that the run is not completed.
fn assert_report_is_not_whole(folder: &Path, scratch: &Path, context: &str) {
    let page = scratch.join("page.html");
    fs::remove_file(&page).ok();
    let mut report = Command::new(env!("CARGO_BIN_EXE_revolve"));
    let output = report.arg("report").arg(folder).arg("--out").arg(&page).output().expect("the program runs");
    let words = String::from_utf8_lossy(&output.stdout);
    let page = fs::read_to_string(&page).unwrap_or_default();
    let is_told = words.contains("has not finished") || page.contains("halted");
    assert!(output.status.code() == Some(2) || (output.status.success() && is_told), "{context}: {output:?}");
}

/// Returns the files below a folder without temporary ones and lists of finished runs. Of files that contain times, only whether they are complete.
fn files_below(folder: &Path, prefix: &str, has_times: bool) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let Ok(entries) = fs::read_dir(folder) else { return files };
    for entry in entries {
        let path = entry.expect("an entry").path();
        let name = path.file_name().expect("a name").to_str().expect("a name").to_owned();
        if path.is_dir() {
            files.extend(files_below(&path, &format!("{prefix}{name}/"), has_times));
        } else if !name.starts_with(".revolve-") && !name.ends_with("_log.csv") {
            let mut bytes = fs::read(&path).expect("a file");
            if name.ends_with(".json") {
                serde_json::from_slice::<serde_json::Value>(&bytes).expect("complete JSON");
                bytes.clear();
            } else if name.ends_with(".sfv") || (has_times && !name.ends_with(".png")) {
                assert!(bytes.ends_with(b"\n"), "{name} is incomplete");
                bytes.clear();
            } else if has_times {
                bytes.clear();
            }
            files.insert(format!("{prefix}{name}"), bytes);
        }
    }
    files
}

/// A command that writes several files to `OUT`.
fn commands(finished: &str) -> Vec<(&'static str, Vec<&str>)> {
    let depth = "-1000*final(U2@REF)";
    let scatter = ["scatter", "input/ogive.inp", "-d", "V=normal(800, 20)", "--count", "8", "--quantity", depth];
    let sweep = ["sweep", "input/ogive.inp", "--set", "V=569,821", "--quantity", depth, "--out", "OUT"];
    let with = |words: &[&'static str], more: &[&'static str]| [words, more].concat();
    let study = ["study", "input/ogive.inp", "--repeat", "1", "--quantity", depth, "--out", "OUT"];
    let between = ["--velocity", "V", "--between", "100,900", "--tolerance", "10", "--shots", "2", "--out", "OUT"];
    vec![
        ("sweep", with(&sweep, &["--threads", "1"])),
        ("sweep that keeps its runs", with(&sweep, &["--threads", "1", "--keep"])),
        ("part of a sweep", with(&sweep, &["--threads", "1", "--cases", "1/2"])),
        ("study", with(&study, &["--threads", "1", "--refine", "n=4,8"])),
        ("ablation", with(&study, &["--threads", "1", "--ablate"])),
        ("scatter, CSV", with(&scatter, &["--threads", "1", "--out", "OUT", "--table", "OUT/samples.csv"])),
        #[cfg(feature = "parquet")]
        ("scatter, Parquet", with(&scatter, &["--threads", "1", "--out", "OUT", "--table", "OUT/samples.parquet"])),
        ("limit", with(&["limit", "input/plates_derived.inp", "--threads", "1"], &between)),
        ("report", vec!["report", finished, "--out", "OUT/page.html"]),
        ("new", with(&["new", "vdload", "--out", "OUT"], &[])),
        ("material", with(&["material", "input/taylor_copper.inp", "--out", "OUT"], &[])),
    ]
}

#[test]
fn commands_lose_nothing_if_any_call_on_their_folder_fails() {
    let scratch = tempfile::tempdir().expect("a folder");
    let Some(calls) = FailingCalls::new(scratch.path()) else { return };
    let case = FaultCase::new("bar", &small_run(scratch.path()), &[], scratch.path());
    drop(case);
    let (folder, finished) = (scratch.path().join("results"), scratch.path().join("whole-bar"));
    for (name, words) in commands(finished.to_str().expect("a name")) {
        let command = || {
            let mut command = Command::new(env!("CARGO_BIN_EXE_revolve"));
            let out = folder.to_str().expect("a name");
            command.args(words.iter().map(|word| word.replace("OUT", out))).current_dir(env!("CARGO_MANIFEST_DIR"));
            command
        };
        let begin = || {
            fs::remove_dir_all(&folder).ok();
            if ["report", "scatter"].contains(&words[0]) {
                fs::create_dir_all(&folder).expect("a folder");
            }
        };
        let has_times = words[0] == "study";
        begin();
        let output = command().output().expect("the program runs");
        assert!(output.status.success(), "{name}: {output:?}");
        let complete = files_below(&folder, "", has_times);
        let (mut count, mut states) = (0, FolderStates::default());
        // The other commands write by the same functions.
        let failures = if name == "sweep" { &FAILURES[..3] } else { &FAILURES[..1] };
        for failure in failures {
            for call in 1.. {
                begin();
                let Some((output, context)) = calls.run(&mut command(), &folder, call, *failure) else { break };
                count += 1;
                let context = format!("{name}: {context}");
                let found = files_below(&folder, "", has_times);
                // Cases without a result make another table.
                let is_partial = String::from_utf8_lossy(&output.stderr).contains("gave no result");
                for (file, bytes) in found.iter().filter(|_| !is_partial) {
                    assert!(complete.get(file) == Some(bytes), "{context}: {file} is incomplete");
                }
                if has_succeeded(&output, &folder, *failure, &context) {
                    let missing = complete.keys().find(|file| !found.contains_key(*file));
                    assert_eq!(missing, None, "{context}");
                }
                if !states.is_new(&folder) {
                    continue;
                }
                let output = command().output().expect("the program runs");
                assert!(output.status.success(), "{context}: {output:?}");
                assert!(files_below(&folder, "", has_times) == complete, "{context}: the repetition differs");
            }
        }
        assert!(count >= 3, "{name}: {count} calls");
        println!("on this machine: {name}, {count} failing calls on the result folder, {} states", states.0.len());
    }
}

#[test]
fn deleted_frame_is_reported_at_the_end() {
    let scratch = tempfile::tempdir().expect("a folder");
    let folder = scratch.path().join("results");
    let deck = fs::read_to_string(small_run(scratch.path())).expect("a deck");
    // Long enough for the first frame to be deleted before the end.
    let long = deck.replace("nr = 2", "nr = 30").replace("nz = 6", "nz = 150").replace("4.e-6", "8.e-6");
    fs::write(scratch.path().join("bar.inp"), long).expect("a deck");
    let mut command = Command::new(env!("CARGO_BIN_EXE_revolve"));
    command.args(["run", "bar.inp", "--quiet", "--out"]).arg(&folder).current_dir(scratch.path());
    let mut child = command.stderr(std::process::Stdio::piped()).spawn().expect("the program runs");
    let frame = folder.join("bar_0000.vtu");
    while fs::remove_file(&frame).is_err() {
        assert!(child.try_wait().expect("a status").is_none(), "the run has ended before its frame was deleted");
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    let output = child.wait_with_output().expect("a status");
    let words = String::from_utf8_lossy(&output.stderr);
    let is_told = words.contains("K103") && words.contains("bar_0000.vtu") && words.contains("no longer exists");
    assert!(output.status.success() && is_told, "{words}");
    let summary = fs::read_to_string(folder.join("bar.json")).expect("a summary");
    assert!(summary.contains("K103"), "{summary}");
}
