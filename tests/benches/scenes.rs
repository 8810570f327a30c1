//! Statistics of random physical scenes.
//!
//! `cargo bench scenes -- 1000` runs a thousand scenes (default 100); `SCENES_SEED=7` selects other scenes,
//! `SCENES_FROM=500` continues from a number, and `SCENES_KEEP=FOLDER` keeps the decks of failed scenes.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use crate::common::scenes::{SceneResult, SceneVerdict, judge};

/// Runs the scenes and prints their statistics.
pub fn run() {
    let count = std::env::args().find_map(|a| a.parse::<u64>().ok()).unwrap_or(100);
    let number = |name: &str| std::env::var(name).ok().and_then(|s| s.parse::<u64>().ok());
    let (seed, first) = (number("SCENES_SEED").unwrap_or(1), number("SCENES_FROM").unwrap_or(0));
    std::panic::set_hook(Box::new(|info| println!("panic: {info}")));
    let (begin, mut ends, mut codes) = (Instant::now(), BTreeMap::new(), BTreeMap::new());
    let mut increments = 0;
    let mut longest = (Duration::ZERO, 0);
    for number in first..first + count {
        let begin = Instant::now();
        let verdict = judge(seed, number);
        longest = longest.max((begin.elapsed(), number));
        increments += verdict.increments;
        *ends.entry(verdict.end).or_insert(0_u64) += 1;
        if verdict.end == SceneResult::Halted {
            *codes.entry(verdict.words[..4].to_owned()).or_insert(0_u64) += 1;
        }
        if verdict.end.is_fault() || verdict.end == SceneResult::Refused {
            print_verdict(&verdict);
        }
    }
    println!("{count} scenes of seed {seed}, {increments} increments, {:.0} s", begin.elapsed().as_secs_f64());
    for (end, count) in ends {
        println!("{end:?}: {count}");
    }
    println!("halts: {codes:?}; longest {:.1?}, scene {}", longest.0, longest.1);
}

fn print_verdict(verdict: &SceneVerdict) {
    let SceneVerdict { number, name, deck, end, drift, words, increments } = verdict;
    println!("scene {number} ({name}): {end:?}, drift {drift:.2e} after {increments} increments\n{}", words.trim_end());
    if let Ok(folder) = std::env::var("SCENES_KEEP") {
        std::fs::write(format!("{folder}/scene_{number}.inp"), deck).expect("a deck");
    }
}
