//! Identical bits on any number of threads, for every material law.
//!
//! Goal: no sum depends on the distribution of elements over threads. Tolerance: none. Source: the run on one thread.

use crate::common::bodies::{assembly, elastic, part};
use crate::common::solid::{grid, material, run};

/// Increments of a run, and the bits of its rows and of the fields of its last frame.
type RunBits = (u64, Vec<u64>, Vec<u64>);

fn digest(deck: &str, threads: usize) -> RunBits {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    pool.install(|| {
        let (outcome, memory) = run(deck);
        assert!(outcome.halt.is_none() && outcome.increments > 20, "{:?}", outcome.halt);
        let rows = memory.rows.iter().flat_map(|r| r.1.iter().map(|v| v.to_bits())).collect();
        let frame = memory.frames.last().expect("a frame");
        let fields = frame.point_fields.iter().chain(&frame.cell_fields);
        (outcome.increments, rows, fields.flat_map(|f| f.values.iter().map(|v| v.to_bits())).collect())
    })
}

/// Returns a bar of 50 by 200 elements (enough for several threads) that hits a wall at `speed`.
fn bar(material: &str, speed: f64, time: f64) -> String {
    grid(50, 200, false, |i, j| [0.064 * i as f64, 0.162 * j as f64])
        + material
        + &format!(
            "*Initial Conditions, type=VELOCITY\n ALL, 2, {:e}\n*Step\n*Dynamic, Explicit\n , {time:e}\n*Boundary\n I0, 1, 1\n \
             J0, 2, 2\n*Output, field, number interval=1\n*Node Output\n U, V\n*Element Output\n S, PEEQ\n\
             *Output, history, number interval=10\n*Energy Output\n ALLKE, ALLIE, ALLPD, ETOTAL\n*End Step\n",
            -speed
        )
}

fn agrees(name: &str, deck: &str) {
    let one = digest(deck, 1);
    for threads in [2, 5] {
        assert!(one == digest(deck, threads), "{name}: {threads} threads");
    }
}

fn steel(cards: &str) -> String {
    material(206e3, 0.3, 7.83e-9, cards)
}

#[test]
fn kinematic_hardening_results_are_independent_of_threads() {
    agrees("kinematic", &bar(&steel("*Plastic, hardening=KINEMATIC\n 400., 0.\n 500., 0.1\n"), 2e5, 3e-7));
}

/// Elements at the foot are deleted during the run.
#[test]
fn failure_with_deletion_is_independent_of_threads() {
    let deck = bar(&steel("*Plastic\n 400., 0.\n 500., 0.1\n*Shear Failure\n 0.05,\n"), 2e5, 3e-7);
    let deck = deck.replace(" S, PEEQ\n", " S, PEEQ, STATUS\n");
    let (_, memory) = run(&deck);
    let fields = &memory.frames.last().expect("a frame").cell_fields;
    let status = &fields.iter().find(|f| f.name == "STATUS").expect("a status").values;
    assert!(status.contains(&0.0) && status.contains(&1.0));
    agrees("failure", &deck);
}

#[test]
fn rubber_results_are_independent_of_threads() {
    let rubber = "*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n 1.e-9,\n*Hyperelastic, neo hooke\n 0.5, 0.1\n";
    agrees("neo-Hooke", &bar(rubber, 1e4, 3e-5));
    let others = ["mooney-rivlin\n 0.4, 0.1, 0.1\n*Damping, alpha=1.e4\n", "ogden\n 1., 1.3, 0.1\n"];
    for form in others {
        agrees(form, &bar(&rubber.replace("neo hooke\n 0.5, 0.1\n", form), 1e4, 3e-5));
    }
}

#[test]
fn foam_and_explosive_results_are_independent_of_threads() {
    let head = "*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n";
    let foam =
        " 3.2e-10,\n*Elastic\n 150., 0.\n*Crushable Foam\n 1.1, 0.1\n*Crushable Foam Hardening\n 6., 0.\n 20., 0.8\n";
    agrees("foam", &bar(&format!("{head}{foam}"), 1e5, 3e-6));
    let tnt =
        " 1.63e-9,\n*Eos, type=JWL\n 6.93e6, 3.712e5, 3231., 0.3, 4.15, 0.95, 4.29e12\n*Detonation Point\n 0., 0.\n";
    agrees("explosive", &bar(&format!("{head}{tnt}"), 1e4, 3e-7));
}

#[test]
fn equation_of_state_results_are_independent_of_threads() {
    let head = "*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n";
    let metal = format!("{head} 2.785e-9,\n*Eos, type=USUP\n 5.328e6, 1.338, 2.\n");
    agrees("linear Us-Up", &bar(&metal, 1e5, 3e-7));
    let gas = format!(
        "{head} 1.2e-12,\n*Eos, type=IDEAL GAS\n 2.87e8, 0.\n*Specific Heat\n 7.175e8,\n\
         *Initial Conditions, type=SPECIFIC ENERGY\n SOLID, 2.1e11\n"
    );
    agrees("ideal gas", &bar(&gas, 1e4, 5e-6));
}

/// Two blocks, with enough nodes for several threads, in contact with friction.
#[test]
fn contact_results_are_independent_of_threads() {
    let block = |name: &str, n: usize, from: f64| {
        part(
            name,
            [n, 60],
            |i, j| [i as f64 / n as f64, from + j as f64 / 60.0 + 0.02 * (3.0 * i as f64 / n as f64).sin()],
            "",
        )
    };
    let deck = block("LOWER", 60, -1.0)
        + &block("UPPER", 80, 0.001)
        + &assembly(&["LOWER", "UPPER"], "")
        + &elastic("LOWER", [1.0, 0.3, 1.0], "*Plastic\n 0.01, 0.\n 0.02, 1.\n")
        + &elastic("UPPER", [1.0, 0.3, 1.0], "")
        + "*Surface Interaction, name=DRY\n*Friction\n 0.1,\n*Initial Conditions, type=VELOCITY\n UPPER.ALL, 2, -0.05\n\
           *Step\n*Dynamic, Explicit\n , 0.4\n*Contact Pair, interaction=DRY\n LOWER.J1, UPPER.J0\n\
           *Output, field, number interval=1\n*Node Output\n U, V\n*Element Output\n S, PEEQ\n\
           *Output, history, number interval=10\n*Energy Output\n ALLKE, ALLCW, ALLFD, ALLPD, ETOTAL\n*End Step\n";
    let (outcome, _) = run(&deck);
    assert!(outcome.energy.contact > 0.0 && outcome.energy.friction > 0.0, "{:?}", outcome.energy);
    agrees("contact", &deck);
}
