//! Reproducibility: identical bits on all machines.
//!
//! Goal: a deck has one digest, for any number of threads and every instruction set of this machine. The digests are
//! pinned, so that a machine or compiler with other bits is detected; a change of arithmetic updates them. Tolerance:
//! none.

use std::fs;

use revolve::job;
use revolve::job::Instructions;
use revolve::user::Routines;
use revolve::user::compile::compile;

use crate::common;
use crate::common::solid::{grid, material};
use crate::common::{pairs, project};
use crate::faults::{cases_of_new_meshes_and_bonds, results};

/// Returns the digest of a deck on a number of threads; `None` if the machine lacks the instruction set.
fn digest(
    text: &str,
    settings: &[(&str, &str)],
    user: Option<&str>,
    threads: usize,
    instructions: Instructions,
) -> Option<String> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    pool.install(|| {
        let routines = user.map_or(Routines::none(), |file| {
            compile(&[project(file)], false).expect("a library").open().expect("routines")
        });
        let mut prepared = job::prepare_text("test.inp", text, &pairs(settings), &routines);
        assert!(!prepared.diagnostics.has_errors(), "{}", prepared.diagnostics.render(&prepared.deck.sources));
        prepared.use_instructions(instructions).ok()?;
        let (outcome, _) = job::run_in_memory(&prepared);
        assert_eq!(outcome.halt, None);
        Some(outcome.digest)
    })
}

/// Returns a bar of 50 by 200 elements, enough for several threads.
fn bar(material: &str, time: f64) -> String {
    grid(50, 200, false, |i, j| [0.064 * i as f64, 0.162 * j as f64])
        + material
        + &format!(
            "*Initial Conditions, type=VELOCITY\n ALL, 2, -1.e5\n*Step\n*Dynamic, Explicit\n , {time:e}\n*Boundary\n I0, 1, 1\n \
             J0, 2, 2\n*Output, history, number interval=10\n*Energy Output\n ETOTAL\n*End Step\n"
        )
}

/// The printed digest is that of the summary, also with a forced instruction set.
#[test]
fn program_prints_the_digest() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = |more: &[&str]| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_revolve"));
        command.args(["run", "input/taylor_copper.inp", "--set", "nr=4", "--set", "nz=20", "--out"]).arg(folder.path());
        let output = command.args(more).current_dir(env!("CARGO_MANIFEST_DIR")).output().expect("the program runs");
        assert!(output.status.success(), "{output:?}");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let printed = text.lines().find_map(|l| l.strip_prefix("digest ")).expect("a digest").to_owned();
        let summary = fs::read(folder.path().join("taylor_copper.json")).expect("a summary");
        let summary: serde_json::Value = serde_json::from_slice(&summary).expect("JSON");
        assert_eq!(summary["digest"], *printed);
        printed
    };
    assert_eq!(run(&[]), run(&["--threads", "3", "--instructions", "scalar", "--checkpoint-every", "100"]));
}

/// Returns one line per deck, after asserting that every instruction set and number of threads gives the digest of
/// scalar arithmetic.
fn digests(decks: &[(&str, String, Option<&str>)]) -> String {
    let mut lines = String::new();
    for (name, text, user) in decks {
        let scalar = digest(text, &[], *user, 1, Instructions::Scalar).expect("every machine is scalar");
        for (threads, instructions) in [(2, Instructions::Avx2), (5, Instructions::Avx512), (3, Instructions::Scalar)] {
            match digest(text, &[], *user, threads, instructions) {
                Some(digest) => assert_eq!(digest, scalar, "{name}: {threads} threads, {instructions:?}"),
                None => println!("on this machine: no {instructions:?}, so its bits are not compared"),
            }
        }
        lines += &format!("{scalar}  {name}\n");
    }
    lines
}

fn example(name: &str) -> String {
    fs::read_to_string(project(&format!("input/{name}.inp"))).expect("a deck")
}

#[test]
fn every_deck_has_one_digest() {
    let eos = "*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n 2.785e-9,\n*Eos, type=USUP\n 5.328e6, 1.338, 2.\n";
    let tough = "*Plastic\n 400., 0.\n 500., 0.1\n*Shear Failure\n 0.02,\n";
    insta::assert_snapshot!(digests(&[
        ("ogive", example("ogive"), None),
        ("taylor_copper", example("taylor_copper"), None),
        ("bar with deletion", bar(&material(206e3, 0.3, 7.83e-9, tough), 2e-7), None),
        ("bar with an equation of state", bar(eos, 2e-7), None),
    ]));
}

/// New meshes, adaptive meshes and bonds: all files, and with them the verdict, are the same on any number of threads and with
/// each instruction set of the machine.
#[test]
fn new_meshes_and_bonds_give_the_same_files() {
    let scratch = tempfile::tempdir().expect("a folder");
    let mut compared = 0;
    for case in cases_of_new_meshes_and_bonds(scratch.path()) {
        for [threads, instructions] in [["1", "scalar"], ["2", "avx2"], ["5", "avx512"], ["3", "scalar"]] {
            let folder = scratch.path().join("again");
            fs::remove_dir_all(&folder).ok();
            let program = std::process::Command::new(env!("CARGO_BIN_EXE_revolve"));
            let mut command = case.command(program, &folder, &["--threads", threads, "--instructions", instructions]);
            if !command.status().expect("the program runs").success() && instructions != "scalar" {
                println!("on this machine: no {instructions}, so its files are not compared");
                continue;
            }
            let files = results(&folder);
            let differing = case.results.iter().find(|(name, bytes)| files.get(*name) != Some(bytes));
            assert_eq!(differing.map(|file| file.0), None, "{}: {threads} threads, {instructions}", case.name);
            compared += 1;
        }
    }
    assert!(compared >= 8, "{compared} runs");
}

#[test]
fn every_deck_with_a_routine_has_one_digest() {
    if !common::fortran("digests of decks with routines in Fortran") {
        return;
    }
    insta::assert_snapshot!(digests(&[
        ("ogive_user", example("ogive_user"), Some("input/vdload_cavity.f")),
        ("blast_disk", example("blast_disk"), Some("input/vdload_blast.f")),
        ("taylor_vumat", example("taylor_vumat"), Some("input/vumat_hardening.f90")),
    ]));
}
