//! Commands that make many runs, killed after some of them and continued with `--resume`.
//!
//! Goal: the same results as without the kill, from the runs that had finished. Source: the undisturbed command.
//! Tolerance: none, except for measured times.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::common::project;

const LENGTH: &str = "final(COOR2@TIP)";

/// Returns the commands of this test on a copper bar, and of `limit` on a rod and a plate.
fn commands(scratch: &Path) -> Vec<Vec<String>> {
    let bar = "input/taylor_copper.inp";
    let shots = scratch.join("shots.csv");
    fs::write(&shots, "length,rest\n0.0324,0.0225\n0.03,0.021\n").expect("a table");
    let rod = fs::read_to_string(project("input/rod_plate_deletion.inp")).expect("a deck");
    let (before, after) = ("*Dynamic, Explicit\n , 40.e-6", "*Dynamic, Explicit\n , 200.e-6");
    assert!(rod.contains(before));
    let plate = scratch.join("rod.inp");
    fs::write(&plate, rod.replace(before, after)).expect("a deck");
    let [shots, plate] = [&shots, &plate].map(|path| path.to_str().expect("a name"));
    let of_rod = "--set nr=4 --set nz=20 --set mr=20 --set mz=10 --between 100e3,900e3 --tolerance 10e3 --shots 3";
    let lines = [
        format!("scatter {bar} -d speed=normal(227,5) --count 16 --quantity {LENGTH}"),
        format!("identify {bar} --shots {shots} --unknown speed=210 --measured rest --quantity {LENGTH}"),
        format!("sensitivity {bar} --of {LENGTH} --to speed,length --jitter 0"),
        format!("study {bar} --refine nr=5,10 --refine nz=25,50,100 --repeat 2 --quantity {LENGTH}"),
        format!("sweep {bar} --set speed=180:230:4 --quantity {LENGTH}"),
        format!("limit {plate} --velocity speed {of_rod}"),
    ];
    lines.iter().map(|line| line.split(' ').map(str::to_owned).collect()).collect()
}

/// Returns the results of a command without measured times and checksums.
fn results(folder: &Path) -> Vec<(String, String)> {
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let mut files: Vec<(String, String)> = entries
        .filter(|path| path.extension().is_some_and(|ending| ending == "csv" || ending == "json"))
        .map(|path| {
            let name = path.file_name().expect("a name").to_str().expect("a name").to_owned();
            let text = fs::read_to_string(&path).expect("a file");
            (name.clone(), if name.contains("_study") { without_times(&name, &text) } else { text })
        })
        .collect();
    files.sort();
    files
}

/// Returns the table of a study without its times and notes, which name the fastest settings. Its JSON record has times.
fn without_times(name: &str, text: &str) -> String {
    if !name.ends_with(".csv") {
        return String::new();
    }
    let header = text.lines().next().expect("a header");
    let depends_on_time = |column: &str| column.contains("time") || column == "note";
    let kept: Vec<bool> = header.split(',').map(|column| !depends_on_time(column)).collect();
    let row =
        |line: &str| line.split(',').zip(&kept).filter(|cell| *cell.1).map(|cell| cell.0.to_owned() + ",").collect();
    text.lines().map(row).collect::<Vec<String>>().join("\n")
}

#[test]
fn killed_commands_continue_with_the_results_of_an_undisturbed_one() {
    let scratch = tempfile::tempdir().expect("a folder");
    for words in commands(scratch.path()) {
        let name = words[0].clone();
        let [complete, killed] = ["complete", "killed"].map(|kind| scratch.path().join(format!("{name}-{kind}")));
        let start = |folder: &Path, more: &[&str]| {
            let mut command = Command::new(env!("CARGO_BIN_EXE_revolve"));
            command.args(&words).args(["--threads", "1", "--out"]).arg(folder).args(more);
            command.current_dir(env!("CARGO_MANIFEST_DIR")).stdout(Stdio::piped()).stderr(Stdio::piped());
            command
        };
        let output = start(&complete, &[]).output().expect("the program runs");
        let is_done = output.status.code() == Some(0) || (name == "limit" && output.status.code() == Some(1));
        assert!(is_done, "{name}: {output:?}");
        let mut child = start(&killed, &["--quiet"]).spawn().expect("the program runs");
        let ending = if name == "sweep" { "_cases_log.csv" } else { "_runs_log.csv" };
        let has_runs = || {
            let entries = fs::read_dir(&killed).into_iter().flatten().filter_map(Result::ok);
            let mut lists = entries.filter(|entry| {
                let name = entry.file_name().into_string().unwrap_or_default();
                name.ends_with(ending) && !name.starts_with('.')
            });
            let text = lists.next().and_then(|list| fs::read_to_string(list.path()).ok()).unwrap_or_default();
            text.lines().count() > if name == "sweep" { 2 } else { 0 }
        };
        while !has_runs() {
            assert!(child.try_wait().expect("a status").is_none(), "{name} has ended before it was killed");
            std::thread::sleep(Duration::from_millis(2));
        }
        child.kill().expect("killed");
        child.wait().expect("a status");
        let resumed = start(&killed, &["--resume"]).output().expect("the program runs");
        assert_eq!(resumed.status, output.status, "{name}: {resumed:?}");
        let words = String::from_utf8_lossy(&resumed.stdout);
        let sentence = words.lines().find(|line| line.starts_with("--resume:"));
        assert!(name == "sweep" || sentence.is_some_and(|line| !line.contains(": 0 results")), "{name}: {words}");
        assert_eq!(results(&killed), results(&complete), "{name}");
        println!("on this machine: {name}: {}", sentence.unwrap_or("continued"));
    }
}
