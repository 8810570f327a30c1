//! Random scenes: `tests/common/scenes.rs` makes them and says how each may end. `cargo bench scenes -- 1000` runs more.

use crate::common::scenes::{End, judge};
use crate::{Verdict, cases};

cases! { "Random scenes":
    a_hundred_random_scenes, "what nobody thought of: bodies, meshes, materials, loads, contact, erosion, controls and noses by lot",
        "each ends with its books closed within 1 %, with a word on them, or in a halt with increment and time; above 20 % only in a halt; no panic";
}

fn a_hundred_random_scenes() -> Verdict {
    let mut ends = [0; 3];
    let mut holds = true;
    for number in 0..100 {
        let verdict = judge(20_261, number);
        match verdict.end {
            End::Closed | End::ClosedAndTold => ends[0] += 1,
            End::Told => ends[1] += 1,
            End::Halted => ends[2] += 1,
            end => {
                println!("scene {number} ({}): {end:?}, drift {:.2e}\n{}", verdict.name, verdict.drift, verdict.words);
                holds = false;
            }
        }
    }
    Verdict { figure: format!("{} closed, {} told, {} halted", ends[0], ends[1], ends[2]), holds }
}
