//! Goal: what single precision saves, as a ratio to double precision in the same run.
//! Scene: the copper Taylor bar of `solid_cost`, the two precisions in alternation, on each instruction set and one thread and two.

use revolve::job::Instructions;
use revolve::model::Precision;

use super::solid_cost::{bar, timed};

const ROUNDS: usize = 3;

pub fn run() {
    println!("nanoseconds an element and increment in double precision and in single, best of {ROUNDS}");
    for (nr, nz, increments) in [(20, 100, 3000), (128, 256, 200), (512, 1024, 30)] {
        for (name, set) in [("AVX2", Instructions::Avx2), ("AVX-512", Instructions::Avx512)] {
            for threads in [1, 2] {
                let mut best = [f64::INFINITY; 2];
                for _ in 0..ROUNDS {
                    for (best, precision) in best.iter_mut().zip([Precision::Double, Precision::Single]) {
                        let mut prepared = bar([nr, nz], increments, precision);
                        if prepared.use_instructions(set).is_ok() {
                            *best = best.min(timed(prepared, increments, threads).0);
                        }
                    }
                }
                let [double, single] = best.map(|seconds| seconds * 1e9 / (increments * nr * nz) as f64);
                println!(
                    "{} elements, {name}, {threads} threads: {double:.1}, {single:.1}: {:.2} times as fast",
                    nr * nz,
                    double / single
                );
            }
        }
    }
}
