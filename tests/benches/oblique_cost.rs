//! Run time of an increment with six degrees of freedom, compared with the same body in axial motion in the same run.
//!
//! Scene: ogive with 20 facets, during entry and in one layer, fixed increments. The inclined body has 64 stations,
//! with and without friction, and with its shank, half of which is loaded when it slides.

use std::time::Instant;

use revolve::job;
use revolve::user::Routines;

use crate::common;

const INCREMENTS: usize = 100_000;
const ROUNDS: usize = 7;

/// Returns the smallest time in nanoseconds per increment over several rounds.
fn nanoseconds(deck: &str, settings: &[(&str, &str)]) -> f64 {
    let prepared = common::prepared(deck, settings, &Routines::none());
    let round = |_| {
        let begin = Instant::now();
        let (outcome, _) = job::run_in_memory(&prepared);
        begin.elapsed().as_secs_f64() * 1e9 / outcome.increments as f64
    };
    (0..ROUNDS).map(round).fold(f64::INFINITY, f64::min)
}

/// Returns the ogive deck or the oblique deck with fixed increments, without output, with a large mass.
fn deck(path: &str) -> String {
    let text = std::fs::read_to_string(common::project(path)).expect("a shipped deck");
    let fixed = format!("*Dynamic, Explicit, direct user control\n {:e}, 1.e-4", 1e-4 / INCREMENTS as f64);
    let text = text.split("*Output, field").next().expect("text").to_owned() + "*End Step\n";
    let at = text.find("*Dynamic, Explicit").expect("a step");
    let end = at + text[at..].match_indices('\n').nth(1).expect("two lines").0;
    text[..at].to_owned() + &fixed + &text[end..]
}

pub fn run() {
    let flat = deck("input/ogive.inp");
    let tilted = flat
        .replace("direction=-1", "direction=-1, obliquity=20.")
        .replace("*Surface, name=NOSE", "*Attitude, ref node=REF, inertia=UNIFORM\n*Surface, name=NOSE");
    let shank = deck("input/oblique.inp");
    println!("  {:32} {:>12} {:>12} {:>8}", "", "along z, ns", "oblique, ns", "ratio");
    for (where_, front) in [("entering", "0."), ("embedded", "0.1")] {
        for friction in ["0.", "0.1"] {
            let settings = [("front", front), ("friction", friction), ("mass", "10.")];
            let (a, b) = (nanoseconds(&flat, &settings), nanoseconds(&tilted, &settings));
            println!("  nose {where_}, friction {friction:20} {a:12.0} {b:12.0} {:8.1}", b / a);
        }
    }
    for friction in ["0.", "0.1"] {
        let settings = [("friction", friction), ("mass", "10."), ("thickness", "10.")];
        let a = nanoseconds(&shank, &[&settings[..], &[("obliquity", "0.")]].concat());
        let b = nanoseconds(&shank, &settings);
        println!("  nose and shank, friction {friction:20} {a:12.0} {b:12.0} {:8.1}", b / a);
    }
}
