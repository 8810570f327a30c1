//! Run time of a Fortran user subroutine compared with the same subroutine in Rust, of a job with it compared with the
//! built-in load, and of user subroutines in a separate process.
//!
//! Scene: ogive with 20 points and fixed increments; with 200 facets including output. Without gfortran nothing is
//! measured.

use std::path::Path;
use std::process::Command;

use revolve::job;
use revolve::output::JobFiles;
use revolve::user::Routines;
use revolve::user::compile::{Compiled, compile};

use crate::common;
use crate::common::routines::CavityResistance;

const INCREMENTS: u32 = 200_000;

/// Returns milliseconds of a job including its files.
fn whole_job(deck: &str, settings: &[(&str, &str)], routines: &Routines) -> f64 {
    let folder = tempfile::tempdir().expect("a folder");
    let prepared = job::prepare(&common::project(deck), &common::pairs(settings), routines);
    let job = JobFiles { folder: folder.path().to_path_buf(), name: "job".into() };
    let summary = job::run_to_files(&prepared, &job, &mut |_| {}).expect("files");
    assert!(!summary.rests.is_empty(), "{deck}");
    summary.timing.seconds * 1e3
}

/// Returns nanoseconds per increment, and the bits of the kinetic energy.
fn increments(deck: &str, routines: &Routines) -> (f64, u64) {
    let prepared = job::prepare_text("user.inp", deck, &[], routines);
    assert!(!prepared.diagnostics.has_errors());
    let (outcome, _) = job::run_in_memory(&prepared);
    assert_eq!(outcome.increments, u64::from(INCREMENTS));
    (outcome.seconds * 1e9 / f64::from(INCREMENTS), outcome.energy.kinetic.to_bits())
}

fn compare_jobs(fortran: &Compiled) {
    let mut best = [f64::INFINITY; 2];
    for _ in 0..9 {
        best[0] = best[0].min(whole_job("input/ogive.inp", &[("n", "200"), ("front", "0.1")], &Routines::none()));
        let routines = fortran.open().expect("routines");
        best[1] = best[1].min(whole_job("input/ogive_user.inp", &[("n", "200")], &routines));
    }
    println!(
        "200 facets, whole job: CAVITY {:.2} ms, Fortran VDLOAD {:.2} ms ({:.2})",
        best[0],
        best[1],
        best[1] / best[0]
    );
}

fn compare_calls(fortran: &Compiled) {
    let deck = std::fs::read_to_string(common::project("input/ogive_user.inp")).expect("the deck");
    let card = format!("*Dynamic, Explicit, direct user control\n {:e}, 1.e-3", 1e-3 / f64::from(INCREMENTS));
    let deck = deck.replace("mass = 0.021", "mass = 1e4").replace("*Dynamic, Explicit\n , 1.e-3", &card);
    let mut best = [f64::INFINITY; 2];
    for _ in 0..15 {
        let own = increments(&deck, &Routines::none().with_load(CavityResistance));
        let compiled = increments(&deck, &fortran.open().expect("routines"));
        assert_eq!(own.1, compiled.1, "the same arithmetic, the same bits");
        best = [best[0].min(own.0), best[1].min(compiled.0)];
    }
    let [rust, fortran] = best;
    println!("20 points: {rust:.1} ns per increment in Rust, {fortran:.1} ns in Fortran ({:.2})", fortran / rust);
}

/// Runs the program and returns milliseconds of its time loop, and its digest.
fn run_program(deck: &Path, folder: &Path, more: &[&str]) -> (f64, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_revolve"));
    command.arg("run").arg(deck).arg("--out").arg(folder).args(["--quiet", "--set", "n=200", "--user"]);
    let status = command.arg(common::project("input/vdload_cavity.f")).args(more).status().expect("the program runs");
    assert!(status.success());
    let job = deck.file_stem().expect("a name").to_str().expect("a name");
    let text = std::fs::read_to_string(folder.join(format!("{job}.json"))).expect("a summary");
    let summary: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let seconds = summary["timing"]["seconds"].as_f64().expect("a number");
    (seconds * 1e3, summary["digest"].as_str().expect("a digest").to_owned())
}

/// Measures the deck, and the deck with increments so short that calls dominate.
fn compare_processes() {
    let folder = tempfile::tempdir().expect("a folder");
    let shot = common::project("input/ogive_user.inp");
    let text = std::fs::read_to_string(&shot).expect("the deck");
    let short = folder.path().join("short.inp");
    let fixed = text.replace("*Dynamic, Explicit\n ,", "*Dynamic, Explicit, direct user control\n 5.e-9,");
    assert_ne!(fixed, text);
    std::fs::write(&short, fixed).expect("a deck");
    for (name, deck) in [("shot", &shot), ("200 000 increments", &short)] {
        let mut best = [f64::INFINITY; 2];
        for _ in 0..9 {
            let here = run_program(deck, folder.path(), &[]);
            let there = run_program(deck, folder.path(), &["--isolate"]);
            assert_eq!(here.1, there.1, "the same bits");
            best = [best[0].min(here.0), best[1].min(there.0)];
        }
        println!(
            "200 facets, {name}: {:.2} ms in one process, {:.2} ms in two ({:.2})",
            best[0],
            best[1],
            best[1] / best[0]
        );
    }
}

pub fn run() {
    match compile(&[common::project("input/vdload_cavity.f")], false) {
        Ok(fortran) => {
            compare_jobs(&fortran);
            compare_calls(&fortran);
            compare_processes();
        }
        Err(found) => println!("not measured: {}", found.render(&revolve::deck::Sources::default())),
    }
}
