//! Run time outside the increments: a study compared with its runs, the whole process compared with its time loop.
//!
//! Scene: the default deck.

use std::process::Command;
use std::time::Instant;

use revolve::deck;
use revolve::job::{self, ParameterOverrides};
use revolve::study::quantity::Quantity;
use revolve::study::runner::StudyRunner;
use revolve::study::{record, refinement, settings};
use revolve::user::Routines;

const DECK: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/input/ogive.inp");

/// Returns the time of a study over the time of its runs.
fn study() -> f64 {
    let source = |overrides: &ParameterOverrides| deck::read(DECK.as_ref(), overrides);
    let measure = Quantity::parse("final(U2@REF)").expect("a quantity");
    let axes = settings::axes(&["n=20,40,80,160".to_owned()], &["n".to_owned()]).expect("levels");
    let begin = Instant::now();
    let mut bench = StudyRunner::new(&source, &[], None, &measure, 10, &|| {});
    let study = refinement::grid(&mut bench, &axes, None).expect("a study");
    assert_eq!(record::table(&study, true).rows.len(), 4);
    begin.elapsed().as_secs_f64() / bench.spent()
}

/// Returns milliseconds of the whole process including frames, and of the time loop alone.
fn process() -> [f64; 2] {
    let folder = tempfile::tempdir().expect("a folder");
    let begin = Instant::now();
    let status = Command::new(env!("CARGO_BIN_EXE_revolve"))
        .args(["run", DECK, "--quiet", "--out", folder.path().to_str().expect("a name")])
        .status();
    let whole = begin.elapsed().as_secs_f64();
    assert!(status.expect("the program runs").success());
    let prepared = job::prepare(DECK.as_ref(), &[], &Routines::none());
    [1e3 * whole, 1e3 * job::run_in_memory(&prepared).0.seconds]
}

pub fn run() {
    let least = |measure: &dyn Fn() -> f64| (0..5).map(|_| measure()).fold(f64::INFINITY, f64::min);
    println!("a study takes {:.3} times its runs (best of five)", least(&study));
    let [whole, alone] = (0..10).map(|_| process()).fold([f64::INFINITY; 2], |a, b| [a[0].min(b[0]), a[1].min(b[1])]);
    println!("the process {whole:.1} ms, its time loop {alone:.1} ms ({:.2})", whole / alone);
}
