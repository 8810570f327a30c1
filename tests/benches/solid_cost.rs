//! Goal: what a whole increment of deformable elements costs, beside what the machine can do, in one run.
//! Scene: the copper Taylor bar (CAX4R, von Mises with hardening, stiffness hourglass control, bulk viscosity, all energies)
//! with 32 768 and 524 288 elements, fixed increments, one thread and two.

use std::hint::black_box;
use std::time::Instant;

use revolve::job;
use revolve::user::Routines;

use crate::common;

/// Nanoseconds an element and increment, the best of some runs.
fn cost(nr: usize, nz: usize, increments: usize, threads: usize) -> f64 {
    let text = std::fs::read_to_string(common::project("input/taylor_copper.inp")).expect("the deck");
    let dt = 1e-12;
    let time = dt * increments as f64;
    let text = text.replace(
        "*Dynamic, Explicit\n , 80.e-6",
        &format!("*Dynamic, Explicit, direct user control\n {dt:e}, {time:e}"),
    );
    let text = text.split("*Output, field").next().expect("text").to_owned()
        + "*Output, history, number interval=1\n*Energy Output\n ETOTAL\n*End Step\n";
    let settings = [("nr", nr.to_string()), ("nz", nz.to_string())].map(|(n, v)| (n.to_owned(), v));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    pool.install(|| {
        let mut best = f64::INFINITY;
        for _ in 0..3 {
            let prepared = job::prepare_text("taylor.inp", &text, &settings, &Routines::none());
            assert!(!prepared.diagnostics.has_errors(), "{}", prepared.diagnostics.render(&prepared.deck.sources));
            let (outcome, _) = job::run_in_memory(&prepared);
            assert_eq!((outcome.halt, outcome.increments), (None, increments as u64));
            best = best.min(outcome.seconds * 1e9 / (increments * nr * nz) as f64);
        }
        best
    })
}

/// Additions and multiplications a second of a plain loop, in units of 1e9: the baseline instruction set's.
fn arithmetic() -> f64 {
    let mut lanes = black_box([1.0f64; 64]);
    let (factor, term) = (black_box(0.999_999), black_box(1e-9));
    let rounds = 2_000_000;
    let begin = Instant::now();
    for _ in 0..rounds {
        for lane in &mut lanes {
            *lane = *lane * factor + term;
        }
    }
    black_box(lanes);
    (rounds * 128) as f64 / begin.elapsed().as_secs_f64() / 1e9
}

/// Bandwidth of a = b + s c over arrays that fit no cache, in GB/s.
fn triad() -> f64 {
    let n = 8_000_000;
    let (b, c) = (vec![1.0; n], vec![2.0; n]);
    let mut a = vec![0.0; n];
    let s = black_box(3.0);
    let mut best = 0.0f64;
    for _ in 0..4 {
        let begin = Instant::now();
        for ((a, b), c) in a.iter_mut().zip(&b).zip(&c) {
            *a = b + s * c;
        }
        best = best.max(24.0 * n as f64 / begin.elapsed().as_secs_f64() / 1e9);
        black_box(&a);
    }
    best
}

pub fn run() {
    println!("machine: {:.1} G add-or-mul/s (baseline instructions), triad {:.1} GB/s", arithmetic(), triad());
    for (nr, nz, increments) in [(128, 256, 200), (512, 1024, 60)] {
        let [one, two] = [1, 2].map(|threads| cost(nr, nz, increments, threads));
        println!(
            "{} elements: {one:.1} ns an element-cycle on one thread, {two:.1} on two ({:.2} x)",
            nr * nz,
            one / two
        );
    }
}
