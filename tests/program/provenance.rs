//! What produced a result, and the run that produces it again.
//!
//! Goal: a result folder alone gives the same digest again, whatever the deck reads; a changed copy is noticed.
//! Source: the digest of the first run; hashes by the checksum that tools print (SHA-256, FIPS 180-4).

use std::path::{Path, PathBuf};

use revolve::output::vtu::VtuWriter;
use revolve::output::{FramePoints, OutputFrame};

use crate::common::revolve;

fn text(output: &std::process::Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

/// Writes a deck that reads a file of the folder above, a file of the folder of the deck and a mesh, and runs it with a
/// parameter.
fn run_of_many_files(folder: &Path) -> PathBuf {
    let decks = folder.join("decks");
    std::fs::create_dir_all(&decks).expect("a folder");
    let write = |name: &str, contents: &str| std::fs::write(folder.join(name), contents).expect("a file");
    write("steel.inc", "*Material, name=M\n*Density\n 1.,\n*Elastic\n <E>, 0.3\n");
    write("decks/start.inc", "*Initial Conditions, type=VELOCITY\n N, 2, -0.1\n");
    write(
        "decks/block.inp",
        "*Node\n 1, 0., 0.\n 2, 1., 0.\n 3, 1., 1.\n 4, 0., 1.\n*Element, type=CAX4R, elset=B\n 1, 1, 2, 3, 4\n",
    );
    write(
        "decks/bar.inp",
        "*Parameter\n E = 1.\n*Mesh, input=block.inp\n*Nset, nset=N, elset=B\n*Solid Section, elset=B, material=M\n\
         *Include, input=../steel.inc\n*Include, input=start.inc\n*Step\n*Dynamic, Explicit\n , 1.\n*Boundary\n N, 1, 1\n\
         *Output, field, number interval=2\n*Node Output\n U\n*End Step\n",
    );
    let results = folder.join("results");
    let (deck, out) = (decks.join("bar.inp"), results.display().to_string());
    let ran = revolve(&["run", &deck.display().to_string(), "--set", "E=2", "--out", &out, "--quiet"]);
    assert!(ran.status.success(), "{}", text(&ran));
    results
}

/// The deck, its includes, its mesh and the parameter are recorded; without the original files the run is repeated with the
/// same digest, from the folder and from a frame.
#[test]
fn a_run_is_repeated_from_its_folder_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let results = run_of_many_files(folder.path());
    std::fs::remove_dir_all(folder.path().join("decks")).expect("removed");
    std::fs::remove_file(folder.path().join("steel.inc")).expect("removed");
    let place = results.display().to_string();
    let shown = text(&revolve(&["info", &place]));
    for part in ["--set E=2", "bar.inp", "../steel.inc", "start.inc", "block.inp", "completed"] {
        assert!(shown.contains(part), "{part}: {shown}");
    }
    for from in [place.clone(), results.join("bar_0001.vtu").display().to_string()] {
        let again = revolve(&["rerun", &from]);
        assert!(again.status.success() && text(&again).contains("that of the run"), "{}", text(&again));
    }
}

/// Each frame names the deck and its hash. Two hyphens end no comment of XML.
#[test]
fn frames_name_their_deck() {
    let folder = tempfile::tempdir().expect("a folder");
    let results = run_of_many_files(folder.path());
    let summary: serde_json::Value =
        serde_json::from_slice(&std::fs::read(results.join("bar.json")).expect("a summary")).expect("JSON");
    let hash = summary["provenance"]["input"][0]["sha256"].as_str().expect("a hash").to_owned();
    let frame = std::fs::read_to_string(results.join("bar_0002.vtu")).expect("a frame");
    let head = frame.lines().nth(1).expect("a line");
    assert!(head.starts_with("<!-- revolve ") && head.contains(&format!("deck bar.inp, SHA-256 {hash}")), "{head}");
    let mut writer = VtuWriter::new(FramePoints::Current, "deck a--b.inp");
    assert!(writer.text(&OutputFrame::default()).contains("<!-- deck a- -b.inp -->"));
}

/// A copy that has been changed is not the input of the run.
#[test]
fn a_changed_copy_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let results = run_of_many_files(folder.path());
    let archive = results.join("bar.input.tar");
    let mut bytes = std::fs::read(&archive).expect("an archive");
    let at = bytes.windows(8).position(|part| part == b"N, 2, -0").expect("the velocity");
    bytes[at + 9] = b'2';
    std::fs::write(&archive, bytes).expect("written");
    let again = revolve(&["rerun", &results.display().to_string()]);
    assert!(
        !again.status.success() && text(&again).contains("is not the file that the run has read"),
        "{}",
        text(&again)
    );
}

/// A folder without a run is named as such.
#[test]
fn a_folder_without_a_record_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    for command in ["info", "rerun"] {
        let shown = revolve(&[command, &folder.path().display().to_string()]);
        assert_eq!(shown.status.code(), Some(2));
        assert!(text(&shown).contains("has no summary"), "{}", text(&shown));
    }
}
