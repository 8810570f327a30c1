//! Run time in single precision, as a ratio to double precision in the same run.
//!
//! Scene: copper Taylor bar of `solid_cost`, both precisions in alternation, each instruction set, one and two threads.

use revolve::model::Precision;

use super::solid_cost::{ROUNDS, SETS, SIZES, TimedPair};

pub fn run() {
    println!("nanoseconds per element and increment in double precision and in single, best of {ROUNDS}");
    for (size, increments) in SIZES {
        for (name, set) in SETS {
            for threads in [1, 2] {
                let pair = |precision| TimedPair::new(size, increments, precision, set);
                let (Some(mut double), Some(mut single)) = (pair(Precision::Double), pair(Precision::Single)) else {
                    continue;
                };
                for _ in 0..ROUNDS {
                    double.run(threads);
                    single.run(threads);
                }
                let [double, single] = [double.nanoseconds(), single.nanoseconds()];
                println!(
                    "{} elements, {name}, {threads} threads: {double:.1}, {single:.1}: {:.2} times as fast",
                    size[0] * size[1],
                    double / single
                );
            }
        }
    }
}
