//! Run time of a whole increment of deformable elements, compared with a plain scalar loop of the same arithmetic
//! (`plain_solid`) in the same run.
//!
//! Scene: copper Taylor bar (CAX4R, von Mises with hardening, stiffness hourglass control, bulk viscosity, all
//! energies) with 2 000, 32 768 and 524 288 elements, fixed increments, each instruction set, one and two threads.

use std::hint::black_box;
use std::time::Instant;

use revolve::job::{self, Instructions, PreparedJob};
use revolve::user::Routines;

use super::plain_solid::PlainBar;
use crate::common;
use crate::common::solid::WHOLE_VISCOSITY;

pub const ROUNDS: usize = 3;
/// Increment in seconds.
const DT: f64 = 1e-9;
/// Elements along r and z, and increments of the shorter of two runs.
pub const SIZES: [([usize; 2], usize); 3] = [([20, 100], 300), ([128, 256], 300), ([512, 1024], 40)];
/// Ratio of the increments of the longer run to those of the shorter.
const LONGER: usize = 4;

/// Compared instruction sets with their names.
pub const SETS: [(&str, Instructions); 2] = [("AVX2", Instructions::Avx2), ("AVX-512", Instructions::Avx512)];

/// A short and a long run of one bar: the difference of their times excludes start, end and first memory access.
pub struct TimedPair {
    runs: [PreparedJob; 2],
    best: [f64; 2],
    elements: usize,
    increments: usize,
}

impl TimedPair {
    /// Prepares a bar with `nr` by `nz` elements; `None` if the machine lacks the instruction set.
    pub fn new([nr, nz]: [usize; 2], increments: usize, set: Instructions) -> Option<TimedPair> {
        let mut runs = [increments, LONGER * increments].map(|count| prepared_bar([nr, nz], count));
        runs.iter_mut().all(|run| run.use_instructions(set).is_ok()).then_some(())?;
        Some(TimedPair { runs, best: [f64::INFINITY; 2], elements: nr * nz, increments })
    }

    /// Runs both once more and returns the final kinetic energy of the shorter run.
    pub fn run(&mut self, threads: usize) -> f64 {
        let done = self.runs.each_ref().map(|run| time_run(run, threads));
        self.best = [0, 1].map(|i| self.best[i].min(done[i].0));
        done[0].1
    }

    /// Returns the best time so far in nanoseconds per element and increment.
    pub fn nanoseconds(&self) -> f64 {
        let more = (LONGER - 1) * self.increments * self.elements;
        (self.best[1] - self.best[0]) * 1e9 / more as f64
    }
}

/// Prepares the Taylor bar with `nr` by `nz` elements and fixed increments.
fn prepared_bar([nr, nz]: [usize; 2], increments: usize) -> PreparedJob {
    let text = std::fs::read_to_string(common::project("input/taylor_copper.inp")).expect("the deck");
    let time = DT * increments as f64;
    let text = text.replace(
        "*Dynamic, Explicit\n , 80.e-6",
        &format!("*Dynamic, Explicit, direct user control\n {DT:e}, {time:e}\n{}", WHOLE_VISCOSITY.trim_end()),
    );
    let text = text.split("*Output, field").next().expect("text").to_owned()
        + "*Output, history, number interval=1\n*Energy Output\n ETOTAL\n*End Step\n";
    let settings = [("nr", nr.to_string()), ("nz", nz.to_string())].map(|(n, v)| (n.to_owned(), v));
    let prepared = job::prepare_text("taylor.inp", &text, &settings, &Routines::none());
    assert!(!prepared.diagnostics.has_errors(), "{}", prepared.diagnostics.render(&prepared.deck.sources));
    prepared
}

/// Returns the seconds of the time loop on `threads` threads, and the final kinetic energy.
fn time_run(prepared: &PreparedJob, threads: usize) -> (f64, f64) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let (outcome, _) = pool.install(|| job::run_in_memory(prepared));
    assert_eq!(outcome.halt, None);
    (outcome.seconds, outcome.energy.kinetic)
}

/// Returns nanoseconds per element and increment of the plain loop, and the final kinetic energy.
fn plain_loop(nr: usize, nz: usize, increments: usize) -> (f64, f64) {
    let mut best = (f64::INFINITY, 0.0);
    for _ in 0..ROUNDS {
        let mut bar = PlainBar::new(nr, nz);
        let begin = Instant::now();
        bar.run(increments, black_box(DT));
        let seconds = begin.elapsed().as_secs_f64();
        black_box((bar.energies, bar.rate));
        best = (best.0.min(seconds * 1e9 / (increments * nr * nz) as f64), bar.kinetic);
    }
    best
}

/// Returns the additions and multiplications per second of a plain loop with the baseline instruction set, in units of
/// 1e9.
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

/// Returns the bandwidth of a = b + s c in GB/s for arrays larger than the caches.
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
    println!("nanoseconds per element and increment, best of {ROUNDS} (the plain loop over them)");
    for ([nr, nz], increments) in SIZES {
        let (plain, motion) = plain_loop(nr, nz, increments);
        println!("{} elements, plain loop {plain:.1}", nr * nz);
        for (name, set) in SETS {
            let costs = [1, 2].map(|threads| {
                let mut pair = TimedPair::new([nr, nz], increments, set)?;
                for _ in 0..ROUNDS {
                    // The same arithmetic with another order of summation of forces.
                    let difference = (pair.run(threads) / motion - 1.0).abs();
                    assert!(difference < 1e-10, "kinetic energy differs by {difference:e}");
                }
                Some(pair.nanoseconds())
            });
            if let [Some(one), Some(two)] = costs {
                let [first, second] = costs.map(|cost| cost.map_or(0.0, |cost| plain / cost));
                println!("{name}: one thread {one:.1} ({first:.2}), two {two:.1} ({second:.2}; {:.2} x)", one / two);
            }
        }
    }
}
