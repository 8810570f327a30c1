//! Random scenes, generated and classified by `tests/common/scenes.rs`. `cargo bench scenes -- 1000` runs more.

use crate::common::scenes::{SceneResult, judge};
use crate::{CaseVerdict, cases};

cases! { "Random scenes":
    a_hundred_random_scenes, "unforeseen combinations: random bodies, meshes, materials, loads, contact, erosion, hourglass controls and noses",
        "each ends with a drift below 1 %, with a warning, or with a halt that gives increment and time; above 20 % only a halt; no panic";
}

fn a_hundred_random_scenes() -> CaseVerdict {
    let mut ends = [0; 3];
    let mut holds = true;
    for number in 0..100 {
        let verdict = judge(20_261, number);
        match verdict.end {
            SceneResult::Closed | SceneResult::ClosedWithWarning => ends[0] += 1,
            SceneResult::WarnedDrift => ends[1] += 1,
            SceneResult::Halted => ends[2] += 1,
            end => {
                println!("scene {number} ({}): {end:?}, drift {:.2e}\n{}", verdict.name, verdict.drift, verdict.words);
                holds = false;
            }
        }
    }
    CaseVerdict { figure: format!("{} closed, {} with a warning, {} halted", ends[0], ends[1], ends[2]), holds }
}
