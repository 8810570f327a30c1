//! External faults during a run: kills, signals, full disks, deleted folders, too little memory.
//!
//! Goal: no file is ever incomplete, no finished frame is lost or changed, and `--resume` gives the same files as an
//! undisturbed run. Source: the undisturbed run. Tolerance: none. Moments are random with a seed; a run that ends
//! before its moment is repeated, so that the load of the machine has no influence.
//!
//! The long form: `cargo test --release --test program faults -- --ignored --show-output` kills 200 runs.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use revolve::output::checkpoint::Checkpoint;

use crate::common::fortran;

/// A deck with its settings, its undisturbed run time and its results.
pub struct FaultCase {
    pub name: &'static str,
    arguments: Vec<String>,
    /// Folder of compiled user subroutines.
    cache: PathBuf,
    seconds: f64,
    pub results: BTreeMap<String, Vec<u8>>,
}

impl FaultCase {
    /// Runs the deck undisturbed.
    pub fn new(name: &'static str, deck: &Path, more: &[&str], scratch: &Path) -> FaultCase {
        let mut arguments = vec!["run".to_owned(), deck.to_str().expect("a name").to_owned(), "--quiet".into()];
        arguments.extend(more.iter().map(|a| (*a).to_owned()));
        let mut case =
            FaultCase { name, arguments, cache: scratch.join("cache"), seconds: 0.0, results: BTreeMap::new() };
        let folder = scratch.join(format!("whole-{name}"));
        let begin = Instant::now();
        let status = case.start(&folder, &[]).wait().expect("a status");
        case.seconds = begin.elapsed().as_secs_f64();
        assert!(status.success(), "{name}: {status}");
        case.results = results(&folder);
        case
    }

    fn start(&self, folder: &Path, more: &[&str]) -> Child {
        self.command(Command::new(env!("CARGO_BIN_EXE_revolve")), folder, more).spawn().expect("the program runs")
    }

    pub fn command(&self, mut command: Command, folder: &Path, more: &[&str]) -> Command {
        command.args(&self.arguments).arg("--out").arg(folder).args(more).current_dir(env!("CARGO_MANIFEST_DIR"));
        command.env("XDG_CACHE_HOME", &self.cache).stdout(Stdio::null()).stderr(Stdio::null());
        command
    }

    /// Runs the deck under a limit of the shell's `ulimit`.
    fn limited(&self, limit: &str, folder: &Path, more: &[&str]) -> ExitStatus {
        self.command(under_limit(limit), folder, more).status().expect("the program runs")
    }

    /// Resumes the run to its end and compares all files.
    pub fn resume(&self, folder: &Path, threads: &str) {
        let status = self.start(folder, &["--resume", "--threads", threads]).wait().expect("a status");
        assert!(status.success(), "{}: {status}", self.name);
        let results = results(folder);
        let names = |r: &BTreeMap<String, Vec<u8>>| r.keys().cloned().collect::<Vec<_>>();
        assert_eq!(names(&results), names(&self.results), "{}", self.name);
        for (name, bytes) in &results {
            assert!(*bytes == self.results[name], "{}: {name} differs after resuming", self.name);
        }
    }

    /// Asserts that every file is complete and every listed frame equals that of the undisturbed run; returns their
    /// number.
    pub fn check(&self, folder: &Path) -> usize {
        let Ok(entries) = fs::read_dir(folder) else { return 0 };
        let names: Vec<String> =
            entries.map(|e| e.expect("an entry").file_name().to_str().expect("a name").to_owned()).collect();
        let read = |name: &str| fs::read(folder.join(name)).expect("a file");
        for name in names.iter().filter(|n| !n.starts_with(".revolve-")) {
            let bytes = read(name);
            let whole = match name.rsplit_once('.').expect("an ending").1 {
                "vtu" | "pvd" => bytes.ends_with(b"</VTKFile>\n"),
                "json" | "setup" => serde_json::from_slice::<serde_json::Value>(&bytes).is_ok(),
                // The status file is written line by line.
                "sta" => bytes.is_empty() || bytes.starts_with(b"Revolve "),
                "sfv" => bytes.ends_with(b"\n"),
                "tar" => bytes.len().is_multiple_of(512) && bytes.ends_with(&[0; 1024]),
                "csv" => self.results.iter().any(|(n, all)| n == name && rows_begin(all, &bytes)),
                "checkpoint" => Checkpoint::read(&folder.join(name)).is_ok_and(|c| c.is_some()),
                _ => false,
            };
            assert!(whole, "{}: {name} is torn", self.name);
        }
        let Some(list) = names.iter().find(|n| n.ends_with(".pvd")) else { return 0 };
        let list = String::from_utf8(read(list)).expect("text");
        let frames: Vec<&str> = list.split("file=\"").skip(1).map(|f| f.split('"').next().expect("a name")).collect();
        for (i, frame) in frames.iter().enumerate() {
            let bytes = read(frame);
            // A run ended by a signal writes an additional frame at that time.
            let extra = i + 1 == frames.len() && names.iter().any(|n| n.ends_with(".json"));
            assert!(extra || bytes == self.results[*frame], "{}: {frame} is another", self.name);
        }
        frames.len()
    }
}

/// Returns the program under a limit of the shell's `ulimit`.
pub fn under_limit(limit: &str) -> Command {
    let mut shell = Command::new("sh");
    shell.args(["-c", &format!("ulimit {limit}; exec \"$0\" \"$@\""), env!("CARGO_BIN_EXE_revolve")]);
    shell
}

/// Returns whether rows are the first of all rows, with at most one more at the end.
fn rows_begin(all: &[u8], rows: &[u8]) -> bool {
    let lines = rows.split_inclusive(|b| *b == b'\n').collect::<Vec<_>>();
    let commas = |line: &[u8]| line.iter().filter(|b| **b == b',').count();
    let Some((last, before)) = lines.split_last() else { return false };
    all.starts_with(&before.concat()) && last.ends_with(b"\n") && commas(last) == commas(lines[0])
}

/// Returns all files of a folder, without the times in the summary and without the checksum of the summary.
pub fn results(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut results = BTreeMap::new();
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        // The status file contains the wall clock and each restart.
        if path.extension().is_some_and(|e| e == "sta") {
            continue;
        }
        let mut bytes = fs::read(&path).expect("a file");
        if path.extension().is_some_and(|e| e == "json") {
            let mut summary: serde_json::Value = serde_json::from_slice(&bytes).expect("JSON");
            summary["timing"] = serde_json::Value::Null;
            summary["provenance"] = serde_json::Value::Null;
            for row in summary["ledger"]["effects"].as_array_mut().expect("rows") {
                row.as_object_mut().expect("a row").remove("share");
            }
            bytes = summary.to_string().into_bytes();
        }
        if path.extension().is_some_and(|e| e == "sfv") {
            let list = String::from_utf8(bytes).expect("text");
            bytes = list.lines().filter(|l| !l.contains(".json ")).collect::<Vec<_>>().join("\n").into_bytes();
        }
        results.insert(path.file_name().expect("a name").to_str().expect("a name").to_owned(), bytes);
    }
    results
}

/// Random numbers from a seed (Marsaglia 2003, xorshift).
struct RandomNumbers(u64);

impl RandomNumbers {
    fn below(&mut self, n: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % n
    }

    fn fraction(&mut self) -> f64 {
        self.below(1 << 20) as f64 / (1 << 20) as f64
    }
}

fn project(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// A load with internal state: a variable with SAVE, a COMMON block, and a module.
const REMEMBERS: &str = "      module law
        real*8 :: path = 0.d0
      end module
      subroutine vdload(nblock, ndim, stepTime, totalTime, amplitude,
     1 curCoords, velocity, dirCos, jltyp, sname, value)
      use law
      include 'vaba_param.inc'
      dimension curCoords(nblock,ndim), velocity(nblock,ndim),
     1 dirCos(nblock,ndim,ndim), value(nblock)
      character*80 sname
      common /seen/ speeds(500)
      save calls
      data calls /1.d0/
      calls = calls + 1.d0
      path = path + 1.d-9*velocity(1,2)
      speeds(mod(int(calls), 500) + 1) = velocity(1,2)
      do k = 1, nblock
        value(k) = 1.d7 + calls - 1.d5*path - speeds(mod(int(calls), 499) + 1)
      end do
      end
";

/// Returns the case of a rigid body whose user subroutine has internal state.
fn remembering(scratch: &Path) -> FaultCase {
    let routine = scratch.join("remembers.f");
    fs::write(&routine, REMEMBERS).expect("a routine");
    let deck = fs::read_to_string(project("input/ogive_user.inp")).expect("a deck");
    let fixed = deck.replace("*Dynamic, Explicit\n ,", "*Dynamic, Explicit, direct user control\n 2.e-9,");
    assert_ne!(fixed, deck);
    let small = scratch.join("ogive_remembers.inp");
    fs::write(&small, fixed).expect("a deck");
    let routine = routine.to_str().expect("a name");
    FaultCase::new("remembers", &small, &["--checkpoint-every", "0.02s", "--set", "n=4", "--user", routine], scratch)
}

/// Returns a rigid body, a deformable body, and two steps of a body with element deletion.
fn cases(scratch: &Path) -> Vec<FaultCase> {
    let input = |name: &str| project(&format!("input/{name}.inp"));
    let ogive = fs::read_to_string(input("ogive")).expect("a deck");
    let small = scratch.join("ogive_small.inp");
    let fixed = ogive.replace("*Dynamic, Explicit\n ,", "*Dynamic, Explicit, direct user control\n 2.e-9,");
    assert_ne!(fixed, ogive);
    fs::write(&small, fixed).expect("a deck");
    let taylor = fs::read_to_string(input("taylor_copper")).expect("a deck");
    let (head, step) = taylor.split_at(taylor.find("*Step").expect("a step"));
    let failing =
        head.replacen("*Plastic", "*Shear Failure\n 0.6,\n*Plastic", 1) + &step.replace("80.e-6", "30.e-6").repeat(2);
    let two = scratch.join("taylor_two.inp");
    fs::write(&two, failing).expect("a deck");
    vec![
        FaultCase::new("rigid", &small, &["--checkpoint-every", "40000"], scratch),
        FaultCase::new("bar", &input("taylor_copper"), &["--checkpoint-every", "1500"], scratch),
        FaultCase::new("failing", &two, &["--checkpoint-every", "0.02s"], scratch),
    ]
}

/// Returns a liner with new meshes, a block with an adaptive mesh, a pin with cohesive surfaces and a disc with cohesive elements.
pub fn cases_of_new_meshes_and_bonds(scratch: &Path) -> Vec<FaultCase> {
    let input = |name: &str| project(&format!("input/{name}.inp"));
    let block = fs::read_to_string(input("indentation")).expect("a deck");
    let more_frames = block.replace("field, number interval=10", "field, number interval=20");
    assert_ne!(more_frames, block);
    let adaptive = scratch.join("block.inp");
    fs::write(&adaptive, more_frames).expect("a deck");
    let case = |name, deck: &Path, settings: &[&str], every| {
        let settings = settings.iter().flat_map(|setting| ["--set", *setting]);
        let arguments: Vec<&str> = ["--checkpoint-every", every].into_iter().chain(settings).collect();
        FaultCase::new(name, deck, &arguments, scratch)
    };
    let cases = vec![
        case("new meshes", &input("jet"), &["k=2", "T=8.e-6"], "40"),
        case("adaptive mesh", &adaptive, &["n=12"], "200"),
        case("cohesive surfaces", &input("push_out"), &["n=10", "m=7"], "400"),
        case("cohesive elements", &input("debonding_disc"), &["n=1", "T=4.e-4"], "700"),
    ];
    for (case, effect) in cases.iter().zip(["ALLADV", "ALLADV", "ALLDMD", "ALLDMD"]) {
        let summary = case.results.iter().find(|(name, _)| name.ends_with(".json")).expect("a summary").1;
        assert!(String::from_utf8_lossy(summary).contains("verdict"), "{}", case.name);
        let table = case.results.iter().find(|(name, _)| name.ends_with("_history.csv")).expect("histories").1;
        let table = String::from_utf8_lossy(table);
        let column = table.lines().next().and_then(|header| header.split(',').position(|name| name == effect));
        let last_row = table.lines().last().expect("a row").split(',').collect::<Vec<_>>();
        let value = last_row[column.expect("a column")].parse::<f64>().expect("a number");
        assert!(value > 0.0, "{}: {effect} is {value}", case.name);
    }
    cases
}

/// Kills runs at random moments and resumes from the files, in some runs with a second kill.
fn kill(times: usize, seed: u64) {
    let scratch = tempfile::tempdir().expect("a folder");
    let mut cases = cases(scratch.path());
    if fortran("routines that remember") {
        cases.push(remembering(scratch.path()));
    }
    kill_cases(times, seed, &cases, scratch.path());
}

fn kill_cases(times: usize, seed: u64, cases: &[FaultCase], scratch: &Path) {
    for case in cases {
        assert!(case.results.keys().filter(|n| n.ends_with(".vtu")).count() >= 20, "{}", case.name);
    }
    let mut dice = RandomNumbers(seed);
    let (mut runs, mut kills, mut tries) = (0, 0, 0);
    while runs < times {
        tries += 1;
        assert!(tries < 10 * times + 50, "{runs} runs killed in {tries} tries");
        let case = &cases[runs % cases.len()];
        let folder = scratch.join(format!("killed-{tries}"));
        let mut more: Vec<&str> = Vec::new();
        let mut killed = 0;
        while killed < 2 {
            let mut child = case.start(&folder, &more);
            std::thread::sleep(Duration::from_secs_f64(1.1 * case.seconds * dice.fraction()));
            let over = child.try_wait().expect("a status").is_some();
            child.kill().expect("killed");
            child.wait().expect("a status");
            case.check(&folder);
            if over {
                break;
            }
            killed += 1;
            more = vec!["--resume"];
            if dice.below(3) > 0 {
                break;
            }
        }
        if killed > 0 {
            case.resume(&folder, ["1", "2", "3"][dice.below(3) as usize]);
            runs += 1;
        }
        kills += killed;
        fs::remove_dir_all(&folder).ok();
    }
    println!("{runs} runs killed {kills} times, {kills} times gone on, {runs} identical results ({tries} tries)");
}

#[test]
fn runs_killed_at_random_moments_resume() {
    kill(16, 20_250_611);
}

/// New meshes, adaptive meshes, cohesive elements and surfaces; the verdict is part of the compared summary.
#[test]
fn runs_with_new_meshes_and_bonds_resume_after_kills() {
    let scratch = tempfile::tempdir().expect("a folder");
    let cases = cases_of_new_meshes_and_bonds(scratch.path());
    kill_cases(12, 20_261_130, &cases, scratch.path());
}

/// Kills runs with a user subroutine that has internal state.
#[test]
#[ignore = "some minutes: cargo test --release --test program faults -- --ignored --show-output"]
fn two_hundred_killed_runs_with_user_state_resume() {
    let scratch = tempfile::tempdir().expect("a folder");
    if fortran("routines that remember") {
        kill_cases(200, 815, &[remembering(scratch.path())], scratch.path());
    }
}

#[test]
#[ignore = "some minutes: cargo test --release --test program faults -- --ignored --show-output"]
fn two_hundred_killed_runs_resume() {
    kill(200, 4_711);
}

/// Waits until a run has written its third frame.
fn wait_for_frames(folder: &Path, child: &mut Child) {
    let begin = Instant::now();
    let third = |name: &str| name.ends_with("_0002.vtu");
    while !fs::read_dir(folder).is_ok_and(|mut d| d.any(|e| e.is_ok_and(|e| e.file_name().to_str().is_some_and(third))))
    {
        assert!(child.try_wait().expect("a status").is_none(), "over too soon");
        assert!(begin.elapsed().as_secs() < 100);
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn fine_bar(scratch: &Path) -> FaultCase {
    let deck = project("input/taylor_copper.inp");
    FaultCase::new("fine", &deck, &["--set", "nr=8", "--set", "nz=40"], scratch)
}

/// SIGINT and SIGTERM end the run after the current increment: state, frame, histories and summary are written, and the
/// exit status is that of the signal.
#[test]
fn signals_end_runs_with_complete_files() {
    let scratch = tempfile::tempdir().expect("a folder");
    let case = fine_bar(scratch.path());
    for (signal, status) in [("INT", 130), ("TERM", 143)] {
        let folder = scratch.path().join(signal);
        let mut child = case.start(&folder, &[]);
        wait_for_frames(&folder, &mut child);
        let sent =
            Command::new("kill").args([format!("-{signal}"), child.id().to_string()]).status().expect("kill runs");
        assert!(sent.success());
        assert_eq!(child.wait().expect("a status").code(), Some(status));
        let frames = case.check(&folder);
        let summary = fs::read(folder.join("taylor_copper.json")).expect("a summary");
        let summary: serde_json::Value = serde_json::from_slice(&summary).expect("JSON");
        let reason = summary["reason"].as_str().expect("a reason");
        assert!(
            summary["status"] == "halted" && reason.starts_with(&format!("R207: interrupted by SIG{signal}")),
            "{reason}"
        );
        let list = fs::read_to_string(folder.join("taylor_copper.pvd")).expect("a list");
        let time = reason.rsplit(' ').next().expect("a time").parse::<f64>().expect("a number");
        let last = list.rsplit("timestep=\"").next().and_then(|l| l.split('"').next()).expect("a frame");
        assert!(frames > 2 && last.parse::<f64>() == Ok(time), "the last frame is from the end");
        let rows = fs::read_to_string(folder.join("taylor_copper_history.csv")).expect("histories");
        assert!(rows.lines().last().is_some_and(|row| row.starts_with(&format!("{time:?},"))));
        case.resume(&folder, "1");
    }
}

/// SIGTERM at a random moment of each command ends it soon: while it reads, runs, measures, writes or waits for threads.
#[test]
fn a_signal_ends_every_command() {
    let scratch = tempfile::tempdir().expect("a folder");
    let fine = ["--set", "nr=16", "--set", "nz=80"];
    let limits = ["--velocity", "V", "--between", "200,900", "--tolerance", "1e-9"];
    let spread = ["--distribution", "V=normal(500, 10)", "--count", "1000000", "--quantity", "final(V2@REF)"];
    let many = ["--set", "nz=80,81,82", "--set", "nr=16", "--quantity", "final(COOR2@TIP)"];
    let refined = ["--refine", "nr=8,16,32", "--quantity", "final(COOR2@TIP)"];
    let commands: [(&str, &str, &[&str]); 6] = [
        ("run", "taylor_copper", &fine),
        ("check", "taylor_copper", &fine),
        ("limit", "ogive_meshed", &limits),
        ("scatter", "plate_6061", &spread),
        ("sweep", "taylor_copper", &many),
        ("study", "taylor_copper", &refined),
    ];
    let (mut slowest, mut ended) = (Duration::ZERO, 0);
    for state in 0..30 {
        let (command, deck, more) = commands[state % commands.len()];
        let deck = project(&format!("input/{deck}.inp"));
        let mut revolve = Command::new(env!("CARGO_BIN_EXE_revolve"));
        revolve.arg(command).arg(deck).args(more).stdout(Stdio::null()).stderr(Stdio::null());
        if command != "check" {
            revolve.arg("--out").arg(scratch.path().join(state.to_string()));
        }
        let mut child = revolve.spawn().expect("the program runs");
        std::thread::sleep(Duration::from_millis([3, 30, 150, 400, 1100][state / commands.len()]));
        let sent = Instant::now();
        let kill = Command::new("kill").args(["-TERM", &child.id().to_string()]).stderr(Stdio::null()).status();
        kill.expect("kill runs");
        let status = child.wait().expect("a status");
        slowest = slowest.max(sent.elapsed());
        ended += usize::from(!status.success());
        assert!(sent.elapsed().as_secs() < 10, "{command} {deck:?}", deck = commands[state % commands.len()].1);
    }
    println!("slowest end after {slowest:?}; {ended} of 30 commands were interrupted");
    assert!(ended >= 20, "{ended}");
}

/// A limit on file sizes stops writing as a full disk does, at any size from none to enough.
#[test]
fn full_disk_halts_the_run_with_complete_files() {
    let scratch = tempfile::tempdir().expect("a folder");
    let cases = cases(scratch.path());
    let mut halted = 0;
    for (i, blocks) in [0, 1, 4, 16, 40, 64, 100, 160, 100_000].into_iter().enumerate() {
        let case = &cases[1 + i % 2];
        let folder = scratch.path().join(format!("full-{blocks}"));
        let status = case.limited(&format!("-f {blocks}"), &folder, &[]);
        assert!(matches!(status.code(), Some(0 | 1)), "{blocks} blocks: {status}");
        halted += usize::from(status.code() == Some(1));
        case.check(&folder);
        case.resume(&folder, "2");
    }
    assert!((3..9).contains(&halted), "{halted} of 9 runs were halted");
}

/// With too little memory the program may end at any moment, as if it were killed.
#[test]
fn too_little_memory_leaves_complete_files() {
    let scratch = tempfile::tempdir().expect("a folder");
    let case = fine_bar(scratch.path());
    let mut died = 0;
    for kilobytes in [4_000, 12_000, 20_000, 60_000, 160_000] {
        let folder = scratch.path().join(format!("memory-{kilobytes}"));
        let status = case.limited(&format!("-v {kilobytes}"), &folder, &["--threads", "1"]);
        died += usize::from(!status.success());
        case.check(&folder);
        case.resume(&folder, "2");
    }
    assert!(died > 0, "no limit had an effect");
}

#[test]
fn deleted_or_unwritable_folder_is_reported() {
    let scratch = tempfile::tempdir().expect("a folder");
    let deck = project("input/taylor_copper.inp");
    let arguments = ["run", deck.to_str().expect("a name"), "--quiet", "--out"];
    let file = scratch.path().join("file");
    fs::write(&file, "").expect("a file");
    for folder in [&file, &file.join("below"), Path::new("/proc/revolve")] {
        let output =
            Command::new(env!("CARGO_BIN_EXE_revolve")).args(arguments).arg(folder).output().expect("a status");
        assert_eq!(output.status.code(), Some(2), "{folder:?}");
        assert!(String::from_utf8_lossy(&output.stderr).contains("folder"), "{output:?}");
    }
    // Too fine to be completed in minutes: it ends because its folder is deleted.
    let folder = scratch.path().join("gone");
    let mut command = Command::new(env!("CARGO_BIN_EXE_revolve"));
    let fine = ["--set", "nr=30", "--set", "nz=150"];
    let child =
        command.args(arguments).arg(&folder).args(fine).stderr(Stdio::piped()).spawn().expect("the program runs");
    let begin = Instant::now();
    while !folder.join("taylor_copper.pvd").exists() && begin.elapsed().as_secs() < 100 {
        std::thread::sleep(Duration::from_millis(1));
    }
    fs::rename(&folder, scratch.path().join("elsewhere")).expect("moved away");
    let output = child.wait_with_output().expect("a status");
    let words = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(1) && words.contains("R205") && words.contains("gone"), "{output:?}");
}
