//! Hostile surroundings: standard output without a reader, two jobs in one folder, names with special characters,
//! devices in place of files.
//!
//! Goal: no run is lost, nothing hangs, nothing is read without limit, no control characters reach a terminal. Source:
//! the same run undisturbed. Tolerance: none. A command that hangs is ended by `timeout`, whose exit status is 124.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use revolve::output::lock::FolderLock;

use crate::common::{self, project};

/// Returns a command with a time limit and a memory limit that detects unlimited reading.
fn limited(folder: &Path, words: &[&str]) -> Command {
    let mut command = Command::new("sh");
    command.args(["-c", "ulimit -v 4000000; exec timeout -k 5 100 \"$0\" \"$@\"", env!("CARGO_BIN_EXE_revolve")]);
    command.args(words).current_dir(folder).stdin(Stdio::null());
    command
}

fn output(folder: &Path, words: &[&str]) -> Output {
    limited(folder, words).output().expect("the program runs")
}

fn message_text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned() + &String::from_utf8_lossy(&output.stdout)
}

/// Writes a short version of `ogive.inp`; returns its path.
fn ogive(folder: &Path) -> PathBuf {
    let deck = folder.join("ogive.inp");
    fs::copy(project("input/ogive.inp"), &deck).expect("a deck");
    deck
}

#[test]
fn closed_standard_output_does_not_stop_a_run() {
    let scratch = tempfile::tempdir().expect("a folder");
    let folder = scratch.path();
    ogive(folder);
    let depth = "-1000*final(U2@REF)";
    let commands: [(&[&str], &str, i32); 5] = [
        (&["run", "ogive.inp", "--out", "run"], "run/ogive.json", 0),
        (
            &["sweep", "ogive.inp", "--set", "V=500,600", "--quantity", depth, "--out", "sweep"],
            "sweep/ogive_sweep.csv",
            0,
        ),
        (
            &[
                "study",
                "ogive.inp",
                "--refine",
                "increment=1,0.5,0.25",
                "--repeat",
                "1",
                "--quantity",
                depth,
                "--out",
                "study",
            ],
            "study/ogive_study.csv",
            0,
        ),
        (&["check", "ogive.inp"], "", 1),
        (&["explain", "keywords"], "", 1),
    ];
    for (words, result, of_full) in commands {
        let mut child = limited(folder, words).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it runs");
        drop(child.stdout.take());
        let closed = child.wait_with_output().expect("a status");
        assert_eq!(closed.status.code(), Some(0), "{words:?}: {}", message_text(&closed));
        assert!(result.is_empty() || fs::remove_file(folder.join(result)).is_ok(), "{words:?}");

        let device = fs::OpenOptions::new().write(true).open("/dev/full").expect("a device");
        let full = limited(folder, words).stdout(device).stderr(Stdio::piped()).output().expect("it runs");
        assert_eq!(full.status.code(), Some(of_full), "{words:?}: {}", message_text(&full));
        assert_eq!(
            message_text(&full).matches("cannot write to standard output").count(),
            1,
            "{}",
            message_text(&full)
        );
        assert!(result.is_empty() || folder.join(result).is_file(), "{words:?}");

        let device = || fs::OpenOptions::new().write(true).open("/dev/full").expect("a device");
        let mute = limited(folder, words).stdout(device()).stderr(device()).status().expect("it runs");
        assert_eq!(mute.code(), Some(of_full), "{words:?}");
    }
}

#[test]
fn second_job_in_a_folder_is_rejected() {
    let scratch = tempfile::tempdir().expect("a folder");
    ogive(scratch.path());
    let words = ["run", "ogive.inp", "--out", "."];
    let lock = FolderLock::take(scratch.path(), "first").expect("a lock");
    let refused = output(scratch.path(), &words);
    let holder = format!("job `first` of process {}", std::process::id());
    assert!(refused.status.code() == Some(2) && message_text(&refused).contains(&holder), "{}", message_text(&refused));
    assert!(!scratch.path().join("ogive.json").exists());
    drop(lock);
    // The lock file of a job that was killed.
    fs::write(scratch.path().join(".revolve-lock"), "1 ghost\n").expect("a file");
    let run = output(scratch.path(), &words);
    assert!(run.status.success(), "{}", message_text(&run));
    assert!(!scratch.path().join(".revolve-lock").exists());
}

#[test]
fn sweeps_and_studies_lock_their_folder() {
    let scratch = tempfile::tempdir().expect("a folder");
    ogive(scratch.path());
    let lock = FolderLock::take(scratch.path(), "first").expect("a lock");
    let commands: [&[&str]; 2] = [
        &["sweep", "ogive.inp", "--set", "V=500", "--quantity", "final(U2@REF)", "--out", "."],
        &["study", "ogive.inp", "--refine", "increment=1,0.5", "--quantity", "final(U2@REF)", "--out", "."],
    ];
    for words in commands {
        let refused = output(scratch.path(), words);
        let holder = format!("K007]: job `first` of process {}", std::process::id());
        assert!(
            refused.status.code() == Some(2) && message_text(&refused).contains(&holder),
            "{}",
            message_text(&refused)
        );
    }
    assert_eq!(fs::read_dir(scratch.path()).expect("a folder").count(), 2, "the deck and the lock");
    drop(lock);
    for words in commands {
        let done = output(scratch.path(), words);
        assert!(done.status.success(), "{}", message_text(&done));
        assert!(!scratch.path().join(".revolve-lock").exists());
    }
}

/// A sweep and a study issue the warnings of their runs.
#[test]
fn sweeps_and_studies_issue_warnings_of_their_runs() {
    let scratch = tempfile::tempdir().expect("a folder");
    let deck = common::solid::grid(1, 2, false, |i, j| [i as f64, j as f64])
        + &common::solid::material(100.0, 0.3, 1.0, "")
        + "*Nset, nset=TIP\n 6,\n*Parameter\n f = 1.\n*Step\n*Dynamic, Explicit\n , 2.\n*Boundary\n J0, 2, 2\n I0, 1, 1\n*Cload\n 6, 2, <f>\n\
           *Output, history, frequency=1\n*Node Output, nset=TIP\n U2\n*End Step\n";
    fs::write(scratch.path().join("block.inp"), deck).expect("a deck");
    let quantity = "final(U2@TIP)";
    let commands: [&[&str]; 2] = [
        &["sweep", "block.inp", "--set", "f=1,2", "--quantity", quantity, "--out", "out"],
        &["study", "block.inp", "--refine", "increment=1,0.5", "--repeat", "1", "--quantity", quantity, "--out", "out"],
    ];
    for words in commands {
        let done = output(scratch.path(), words);
        assert!(done.status.success(), "{}", message_text(&done));
        assert!(
            message_text(&done).matches("warning: ").count() >= 2 && message_text(&done).contains("ALLAE"),
            "{}",
            message_text(&done)
        );
    }
    let record = fs::read_to_string(scratch.path().join("out/block_study.json")).expect("a record");
    assert!(record.contains("\"warnings\""), "{record}");
}

#[test]
fn repeated_signal_counts_once() {
    let scratch = tempfile::tempdir().expect("a folder");
    fs::copy(project("input/taylor_copper.inp"), scratch.path().join("bar.inp")).expect("a deck");
    let mut child = Command::new(env!("CARGO_BIN_EXE_revolve"))
        .args(["run", "bar.inp", "--quiet", "--set", "nr=30", "--set", "nz=150", "--out", "out"])
        .current_dir(scratch.path())
        .spawn()
        .expect("the program runs");
    while !scratch.path().join("out/bar.pvd").exists() {
        assert!(child.try_wait().expect("a status").is_none(), "over too soon");
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    let process = child.id().to_string();
    let twice = format!("kill -TERM {process}; sleep 0.02; kill -TERM {process}; sleep 0.02; kill -INT {process}");
    // The program may have ended before the last signal.
    Command::new("sh").args(["-c", &twice]).stderr(Stdio::null()).status().expect("kill runs");
    assert_eq!(child.wait().expect("a status").code(), Some(143));
    assert!(scratch.path().join("out/bar.checkpoint").is_file());
}

#[test]
fn names_are_escaped_in_every_format() {
    let scratch = tempfile::tempdir().expect("a folder");
    let deck = fs::read_to_string(project("input/ogive.inp")).expect("a deck");
    let name = "R,\u{1b}[31mE";
    let deck =
        deck.replace("nset=REF", &format!("nset=\"{name}\"")).replace("*Step", "*Heading\n \u{1b}]0;x\u{7}\n*Step");
    fs::write(scratch.path().join("o\u{1b}[2J.inp"), deck).expect("a deck");
    let run = output(scratch.path(), &["run", "o\u{1b}[2J.inp", "--out", "out"]);
    println!("{}", message_text(&run));
    assert!(!message_text(&run).contains('\u{1b}') && message_text(&run).contains("\\u{1b}"), "{}", message_text(&run));
}

#[test]
fn column_name_with_a_comma_is_quoted() {
    let scratch = tempfile::tempdir().expect("a folder");
    let deck = fs::read_to_string(project("input/ogive.inp")).expect("a deck");
    let own =
        deck.replace("*End Step", "*Output, history, number interval=4\n*Node Output, nset=\"R,E\"\n U2\n*End Step");
    let own = own.replacen("*Step", "*Nset, nset=\"R,E\"\n REF,\n*Step", 1);
    fs::write(scratch.path().join("o.inp"), own).expect("a deck");
    let run = output(scratch.path(), &["run", "o.inp", "--out", "out"]);
    assert!(run.status.success(), "{}", message_text(&run));
    let csv = fs::read_to_string(scratch.path().join("out/o_history.csv")).expect("a history");
    let mut lines = csv.lines();
    let header = revolve::output::csv::fields(lines.next().expect("a header"));
    assert!(header.contains(&"U2@R,E".to_owned()), "{header:?}");
    assert!(lines.all(|line| line.split(',').count() == header.len()));
    let chart = output(scratch.path(), &["chart", "out", "--column", "U2@R,E"]);
    assert!(chart.status.success(), "{}", message_text(&chart));
}

#[test]
fn user_file_is_not_a_compiler_option() {
    if !common::fortran("a user file whose name begins with a minus") {
        return;
    }
    let scratch = tempfile::tempdir().expect("a folder");
    let deck = ogive(scratch.path());
    let text = fs::read_to_string(&deck).expect("a deck");
    fs::write(&deck, text).expect("a deck");
    let quiet = "      subroutine vexternaldb(lOp, i_Array, niArray, r_Array, nrArray)\n      include 'vaba_param.inc'\n      dimension i_Array(niArray), r_Array(nrArray)\n      return\n      end\n";
    fs::write(scratch.path().join("-fplugin=x.f"), quiet).expect("a file");
    let cache = scratch.path().join("cache");
    let run = limited(scratch.path(), &["run", "ogive.inp", "--user=-fplugin=x.f", "--out", "out"])
        .env("XDG_CACHE_HOME", &cache)
        .output()
        .expect("it runs");
    assert!(run.status.success(), "{}", message_text(&run));
}

#[test]
fn job_name_cannot_leave_its_folder() {
    let scratch = tempfile::tempdir().expect("a folder");
    let inner = scratch.path().join("a/b");
    fs::create_dir_all(&inner).expect("a folder");
    fs::copy(project("input/ogive.inp"), inner.join("...inp")).expect("a deck");
    for words in [
        &["run", "...inp"][..],
        &["run", "...inp", "--out", "out"],
        &["sweep", "...inp", "--set", "V=500", "--quantity", "final(U2@REF)"],
        &["study", "...inp", "--refine", "increment=1,0.5", "--quantity", "final(U2@REF)"],
    ] {
        let refused = output(&inner, words);
        assert!(
            refused.status.code() == Some(2) && message_text(&refused).contains("cannot be used for result files"),
            "{}",
            message_text(&refused)
        );
    }
    let names: Vec<_> = fs::read_dir(&inner).expect("a folder").collect();
    assert_eq!(names.len(), 1, "{names:?}");
}

/// Decks from unknown sources: no files outside the folder of the deck, no lines of included files, no user code, no
/// results above the limit.
#[test]
fn untrusted_decks_are_restricted() {
    let scratch = tempfile::tempdir().expect("a folder");
    let folder = scratch.path().join("job");
    fs::create_dir(&folder).expect("a folder");
    ogive(&folder);
    fs::write(scratch.path().join("other.inc"), "*Node\n 1, 0., 0.\n").expect("a file");
    fs::write(folder.join("own.inc"), "*Node\n 1, secret, 0.\n").expect("a file");
    let refused = |text: &str, words: &[&str], why: &str| {
        fs::write(folder.join("deck.inp"), text).expect("a deck");
        let found = output(&folder, words);
        assert_eq!(found.status.code(), Some(2), "{}", message_text(&found));
        assert!(message_text(&found).contains(why), "{}", message_text(&found));
        message_text(&found)
    };
    let check = ["check", "deck.inp", "--untrusted"];
    refused("*Include, input=../other.inc\n", &check, "error[D011]");
    refused("*Include, input=/etc/hostname\n", &check, "error[D011]");
    refused("*Mesh, input=../other.vtu\n", &check, "error[D011]");
    let text = refused("*Include, input=own.inc\n", &check, "own.inc:2");
    assert!(!text.contains("1, secret"), "{text}");
    let text = refused("*Include, input=own.inc\n", &check[..2], "own.inc:2");
    assert!(text.contains("1, secret"), "{text}");
    let many = "*Node\n 1, 0., 0.\n 2000001, 1., 0.\n*Ngen\n 1, 2000001\n";
    refused(many, &check, "at most 1000000 are allowed");
    refused("", &["run", "ogive.inp", "--user", "a.f", "--untrusted"], "user subroutines are not run");
    let ogive = fs::read_to_string(folder.join("ogive.inp")).expect("a deck");
    let frames = ogive.replace("number interval=20", "number interval=9000000");
    assert_ne!(ogive, frames);
    refused(&frames, &["run", "deck.inp", "--untrusted"], "error[K012]");
    let run = limited(&folder, &["run", "ogive.inp", "--out", "out"]).env("REVOLVE_UNTRUSTED", "1").output();
    assert!(run.expect("it runs").status.success());
}

/// A restricted command ends at its time limit, whatever it does then.
#[test]
fn untrusted_command_ends_at_its_time_limit() {
    let scratch = tempfile::tempdir().expect("a folder");
    ogive(scratch.path());
    let run = |seconds: &str| {
        // Increments that need days.
        let words = ["run", "endless.inp", "--untrusted", "--no-frames", "--out", "out"];
        let found = limited(scratch.path(), &words).env("REVOLVE_UNTRUSTED_SECONDS", seconds).output();
        found.expect("the program runs")
    };
    let deck = fs::read_to_string(scratch.path().join("ogive.inp")).expect("a deck");
    let step = deck.split("*Dynamic, Explicit\n").nth(1).and_then(|rest| rest.split('\n').next()).expect("a step");
    let endless = deck.replace(
        &format!("*Dynamic, Explicit\n{step}"),
        &format!("*Dynamic, Explicit, direct user control\n 1.e-16{step}"),
    );
    assert_ne!(endless, deck);
    fs::write(scratch.path().join("endless.inp"), endless).expect("a deck");
    let ended = run("1.5");
    assert_eq!(ended.status.code(), Some(1), "{}", message_text(&ended));
    assert!(
        message_text(&ended).contains("the time limit of --untrusted, 1.5 s, is reached"),
        "{}",
        message_text(&ended)
    );
    for wrong in ["0", "-1", "901", "soon", "inf"] {
        let refused = run(wrong);
        assert_eq!(refused.status.code(), Some(2), "{wrong}: {}", message_text(&refused));
        assert!(message_text(&refused).contains("expected a number of seconds above 0, at most 900"), "{wrong}");
    }
}

/// Contact and output cards in an included file: restricted commands show none of its lines, in errors, warnings, the
/// ledger, JSON and results.
#[test]
fn untrusted_commands_show_no_lines_of_included_files() {
    let scratch = tempfile::tempdir().expect("a folder");
    let folder = scratch.path();
    fs::copy(project("input/rod_plate_deletion.inp"), folder.join("rod.inp")).expect("a deck");
    let deck = fs::read_to_string(folder.join("rod.inp")).expect("a deck");
    let (head, step) = deck.split_once("*Contact\n").expect("contact");
    let deck = format!("{head}*Include, input=own.inc\n*End Step\n").replace("40.e-6", "1.e-8");
    fs::write(folder.join("rod.inp"), deck).expect("a deck");
    let included = format!("** a private remark\n*Contact\n{step}");
    let wrong = |card: &str| included.replace("*Output, history", &format!("{card}*Output, history"));
    let cases = [
        included.replace("*End Step\n", ""),
        wrong("*Contact Controls Assignment, type=SCALE PENALTY\n TAIL , ,   1.e3 x, private\n")
            .replace("*End Step\n", ""),
        wrong("*Contact Controls, reset, scale penalty=2.,   private=1\n").replace("*End Step\n", ""),
        included
            .replace("*Contact Output\n CFN, CFS, CAREA", "*Contact Output\n CFN,  CFS, PRIVAT , CAREA")
            .replace("*End Step\n", ""),
        included
            .replace("*Contact Output\n CFN, CFS, CAREA", "*Contact Output, cpset=NONE,   private=1\n CFN, CFS")
            .replace("*End Step\n", ""),
    ];
    for (number, text) in cases.iter().enumerate() {
        fs::write(folder.join("own.inc"), text).expect("a file");
        let is_shown = |output: &Output| {
            let shown = message_text(output);
            let is_private = |line: &&str| line.to_lowercase().contains("privat");
            text.lines().filter(is_private).any(|line| shown.contains(line.trim()))
        };
        for words in [
            &["check", "rod.inp"][..],
            &["check", "rod.inp", "--bytes"],
            &["check", "rod.inp", "--json"],
            &["run", "rod.inp", "--out", "out"],
        ] {
            let restricted = output(folder, &[words, &["--untrusted"]].concat());
            assert!(!is_shown(&restricted), "{words:?}: {}", message_text(&restricted));
            // An unknown output variable is a warning.
            let is_valid = number == 0 || text.contains("PRIVAT ");
            assert_eq!(restricted.status.success(), is_valid, "{words:?}: {}", message_text(&restricted));
        }
        // Without the restriction the same check fails for each faulty file.
        assert_eq!(is_shown(&output(folder, &["check", "rod.inp"])), number > 0);
    }
}

/// Pipes, devices and folders in place of every file that is read.
#[test]
fn devices_and_folders_are_rejected_as_input_files() {
    let scratch = tempfile::tempdir().expect("a folder");
    let folder = scratch.path();
    ogive(folder);
    let made = output(folder, &["run", "ogive.inp", "--quiet", "--out", "whole"]);
    assert!(made.status.success(), "{}", message_text(&made));
    fs::create_dir(folder.join("folder")).expect("a folder");
    for kind in ["pipe", "zero", "folder"] {
        let place = |name: &str| {
            let path = folder.join(name);
            let _ = fs::remove_file(&path);
            let _ = fs::remove_dir(&path);
            match kind {
                "pipe" => assert!(Command::new("mkfifo").arg(&path).status().expect("mkfifo runs").success()),
                "zero" => std::os::unix::fs::symlink("/dev/zero", &path).expect("a link"),
                _ => fs::create_dir(&path).expect("a folder"),
            }
        };
        let refused = |words: &[&str]| {
            let refused = output(folder, words);
            let what =
                ["a pipe", "a device", "a folder", "not a file"].iter().any(|w| message_text(&refused).contains(w));
            assert!(
                refused.status.code() == Some(2) && what,
                "{kind} {words:?}: {:?} {}",
                refused.status,
                message_text(&refused)
            );
        };
        place("x.inp");
        refused(&["run", "x.inp"]);
        refused(&["check", "x.inp"]);
        refused(&["sweep", "x.inp", "--set", "V=1", "--quantity", "final(U2@REF)"]);
        fs::write(folder.join("include.inp"), "*Include, input=x.inp\n").expect("a deck");
        refused(&["check", "include.inp"]);
        for mesh in ["x.vtu", "x.msh", "x.inp"] {
            place(mesh);
            fs::write(folder.join("mesh.inp"), format!("*Mesh, input={mesh}\n")).expect("a deck");
            refused(&["check", "mesh.inp"]);
        }
        for routine in ["x.f", "x.c", "x.so"] {
            place(routine);
            refused(&["check", "ogive.inp", "--user", routine]);
        }
        place("x.csv");
        refused(&[
            "sweep",
            "ogive.inp",
            "--set",
            "V=500",
            "--quantity",
            "final(U2@REF)",
            "--compare",
            "x.csv",
            "--out",
            "s",
        ]);
        fs::create_dir_all(folder.join("kept")).expect("a folder");
        place("kept/ogive.checkpoint");
        refused(&["run", "ogive.inp", "--resume", "--out", "kept"]);
        // A report lists the files that it cannot read, and shows the others.
        for ending in [".json", ".pvd", "_history.csv", "_0003.vtu", "_sweep.csv", "_study.json"] {
            let results = folder.join("results");
            let _ = fs::remove_dir_all(&results);
            fs::create_dir(&results).expect("a folder");
            for entry in fs::read_dir(folder.join("whole")).expect("results") {
                let entry = entry.expect("an entry");
                fs::copy(entry.path(), results.join(entry.file_name())).expect("a copy");
            }
            place(&format!("results/ogive{ending}"));
            let page = output(folder, &["report", "results"]);
            assert!(
                matches!(page.status.code(), Some(0 | 2)),
                "{kind} {ending}: {:?} {}",
                page.status,
                message_text(&page)
            );
        }
        refused_report(folder, kind);
    }
}

/// Asserts that a folder with a device in place of a file is rejected.
fn refused_report(folder: &Path, kind: &str) {
    let page = output(folder, &["report", "x.csv"]);
    assert_eq!(page.status.code(), Some(2), "{kind}: {}", message_text(&page));
    assert!(!page.stderr.is_empty());
}

/// Messages cut long names, and name the limit that a deck exceeds.
#[test]
fn messages_on_excessive_input_are_short_and_name_the_limit() {
    let scratch = tempfile::tempdir().expect("a folder");
    let folder = scratch.path();
    let name = "N".repeat(5_000_000);
    let bar = fs::read_to_string(project("input/taylor_copper.inp")).expect("a deck");
    let domain = "*Dynamic, Explicit\n , 80.e-6\n*Adaptive Mesh, elset=BAR, mesh sweeps=1000000000\n";
    let sweeps = bar.replace("*Dynamic, Explicit\n , 80.e-6\n", domain);
    let nodes = "*Heading\n*Node\n 1, 0., 0.\n 18000000, 1., 0.\n*Ngen, nset=ALL\n 1, 18000000, 1\n".to_owned();
    let cases = [
        (format!("*Heading\n*{name}\n"), "unknown keyword"),
        (format!("*Heading\n*Node, {name}=1\n 1, 0., 0.\n"), "no parameter NNN"),
        (format!("*Heading\n*Node\n 1, 0., 0.\n*Nset, nset=A\n {name}\n"), "no node set or node `NNN"),
        (format!("*Heading\n*Node\n 1, {}x, 0.\n", "9".repeat(5_000_000)), "D301"),
        (sweeps, "from 1 to 1000"),
        (nodes, "the limit of the process (ulimit -v) is"),
    ];
    for (deck, expected) in cases {
        fs::write(folder.join("long.inp"), deck).expect("a deck");
        let mut command = Command::new("sh");
        let limits = "ulimit -v 1500000; exec timeout -k 5 100 \"$0\" check long.inp";
        command.args(["-c", limits, env!("CARGO_BIN_EXE_revolve")]).current_dir(folder);
        let output = command.output().expect("the program runs");
        let shown = message_text(&output);
        assert!(output.status.code() == Some(2) && shown.contains(expected), "{expected}: {shown:.2000}");
        assert!(shown.len() < 5000, "{expected}: {} bytes", shown.len());
    }
}

/// Restricted commands show no words of included files, as text and as JSON.
#[test]
fn untrusted_commands_show_no_words_of_included_files() {
    let scratch = tempfile::tempdir().expect("a folder");
    let folder = scratch.path();
    let bar = fs::read_to_string(project("input/taylor_copper.inp")).expect("a deck");
    let deck = bar.replace("*Initial Conditions", "*Include, input=own.inc\n*Initial Conditions");
    fs::write(folder.join("bar.inp"), deck).expect("a deck");
    for text in [
        "*Privatecard\n",
        "*Nset, nset=A, private=3\n",
        "*Nset, nset=A\n PRIVATE\n",
        "*Material, name=PRIVATE\n*Density\n private\n",
        "*Amplitude, name=PRIVATE\n 0., private\n",
        "*Include, input=private.inc\n",
    ] {
        fs::write(folder.join("own.inc"), text).expect("a file");
        for more in [&[][..], &["--json"]] {
            let is_shown = |output: &Output| message_text(output).to_lowercase().contains("private");
            let words = [&["check", "bar.inp"], more].concat();
            assert!(is_shown(&output(folder, &words)), "{text}");
            let restricted = output(folder, &[&words[..], &["--untrusted"]].concat());
            let shown = message_text(&restricted);
            assert!(!is_shown(&restricted) && shown.contains("own.inc"), "{text}: {shown}");
            assert_eq!(restricted.status.code(), Some(2), "{text}: {shown}");
        }
    }
}
