//! Benchmarks: run times as ratios to plain loops of the same run. No time is asserted, because machines differ.
//!
//! `cargo bench` runs all benchmarks, `cargo bench NAME` those whose name contains NAME. `scenes` prints statistics of
//! random scenes.

#[path = "../common/mod.rs"]
mod common;

mod contact_cost;
mod elastic_cost;
mod increment_cost;
mod law_cost;
mod oblique_cost;
mod overhead;
mod plain_solid;
mod scenes;
mod solid_cost;
mod user_cost;

/// Benchmarks by name.
const BENCHES: &[(&str, fn())] = &[
    ("increment_cost", increment_cost::run),
    ("solid_cost", solid_cost::run),
    ("elastic_cost", elastic_cost::run),
    ("user_cost", user_cost::run),
    ("law_cost", law_cost::run),
    ("oblique_cost", oblique_cost::run),
    ("contact_cost", contact_cost::run),
    ("overhead", overhead::run),
    ("scenes", scenes::run),
];

fn main() {
    // Options belong to cargo, numbers are arguments of a benchmark.
    let is_name = |a: &String| !a.starts_with('-') && a.parse::<u64>().is_err();
    let names: Vec<String> = std::env::args().skip(1).filter(is_name).collect();
    for (name, run) in BENCHES.iter().filter(|b| names.is_empty() || names.iter().any(|n| b.0.contains(n.as_str()))) {
        println!("{name}");
        run();
    }
}
