//! Goal: what a whole increment of deformable elements costs, beside a plain scalar loop of the same arithmetic, in one run.
//! Scene: the copper Taylor bar (CAX4R, von Mises with hardening, stiffness hourglass control, bulk viscosity, all energies)
//! with 32 768 and 524 288 elements, fixed increments, one thread and two.
//! The loop: `plain_solid`.

use std::hint::black_box;
use std::time::Instant;

use revolve::deck;
use revolve::job::{self, Prepared};
use revolve::model::Precision;
use revolve::user::Routines;

use super::plain_solid::Bar;
use crate::common;

const ROUNDS: usize = 3;
/// Length of an increment, seconds.
const DT: f64 = 1e-9;

/// Nanoseconds an element and increment on so many threads, the best of some runs, and the energy of the motion.
fn solver(nr: usize, nz: usize, increments: usize, threads: usize) -> (f64, f64) {
    let prepare = || bar([nr, nz], increments, Precision::Double);
    let best = (0..ROUNDS).map(|_| timed(prepare(), increments, threads)).min_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or((0.0, 0.0), |(seconds, energy)| (seconds * 1e9 / (increments * nr * nz) as f64, energy))
}

/// The Taylor bar with so many elements along r and z and increments of a fixed length.
pub fn bar([nr, nz]: [usize; 2], increments: usize, precision: Precision) -> Prepared {
    let text = std::fs::read_to_string(common::project("input/taylor_copper.inp")).expect("the deck");
    let time = DT * increments as f64;
    let text = text.replace(
        "*Dynamic, Explicit\n , 80.e-6",
        &format!("*Dynamic, Explicit, direct user control\n {DT:e}, {time:e}"),
    );
    let text = text.split("*Output, field").next().expect("text").to_owned()
        + "*Output, history, number interval=1\n*Energy Output\n ETOTAL\n*End Step\n";
    let settings = [("nr", nr.to_string()), ("nz", nz.to_string())].map(|(n, v)| (n.to_owned(), v));
    let read = deck::read_text("taylor.inp", &text, &settings);
    let prepared = job::prepare_edited(read, &mut |model| model.precision = precision, &Routines::none());
    assert!(!prepared.diagnostics.has_errors(), "{}", prepared.diagnostics.render(&prepared.deck.sources));
    prepared
}

/// Seconds in the time loop on so many threads, and the energy of the motion.
pub fn timed(prepared: Prepared, increments: usize, threads: usize) -> (f64, f64) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let (outcome, _) = pool.install(|| job::run_in_memory(&prepared));
    assert_eq!((outcome.halt, outcome.increments), (None, increments as u64));
    (outcome.seconds, outcome.energy.kinetic)
}

/// The same of the plain loop.
fn plain(nr: usize, nz: usize, increments: usize) -> (f64, f64) {
    let mut best = (f64::INFINITY, 0.0);
    for _ in 0..ROUNDS {
        let mut bar = Bar::new(nr, nz);
        let begin = Instant::now();
        bar.run(increments, black_box(DT));
        let seconds = begin.elapsed().as_secs_f64();
        black_box((bar.energies, bar.rate));
        best = (best.0.min(seconds * 1e9 / (increments * nr * nz) as f64), bar.kinetic);
    }
    best
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
    println!("nanoseconds an element and increment, best of {ROUNDS} (ratio to the plain loop)");
    for (nr, nz, increments) in [(128, 256, 200), (512, 1024, 60)] {
        let loops = plain(nr, nz, increments);
        let [one, two] = [1, 2].map(|threads| solver(nr, nz, increments, threads));
        // The same arithmetic in another order of adding forces.
        let difference = (one.1 / loops.1 - 1.0).abs();
        assert!(difference < 1e-10, "kinetic energy differs by {difference:e}");
        println!(
            "{} elements: loop {:.1}, one thread {:.1} ({:.2}), two {:.1} ({:.2})",
            nr * nz,
            loops.0,
            one.0,
            one.0 / loops.0,
            two.0,
            two.0 / loops.0
        );
    }
}
