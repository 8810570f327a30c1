//! New elements in a part of a body without a card.
//!
//! Goal: conservation of mass and momentum, and the same bits on any number of threads. Source: the initial state, and the run
//! with one thread. Tolerance: rounding. A unit test of `solve/mesh_patch.rs` compares the elements outside the part.

use revolve::job;
use revolve::plan::State;
use revolve::user::Routines;

use crate::common::bodies::{assembly, elastic, part};
use crate::common::{self, RecordedOutput, bodies};
use crate::remeshing::{new_meshes, taylor};

/// Settings of a fast bar, whose foot is squashed.
const FAST: [(&str, &str); 5] = [("radius", "3e-3"), ("length", "30e-3"), ("speed", "450."), ("nr", "6"), ("nz", "60")];

/// Sums of a state: mass, momentum along r and z, and the sum of the absolute momenta of the nodes.
pub fn sums(state: &State) -> [f64; 4] {
    let nodes = &state.dofs.nodes;
    let of_node = |n: usize| {
        let (mass, [r, z]) = (nodes.mass[n], nodes.velocity_now(n));
        [mass, mass * r, mass * z, mass * (r.abs() + z.abs())]
    };
    let all = (0..nodes.len()).map(of_node);
    all.fold([0.0; 4], |sum, of_node| [0, 1, 2, 3].map(|i| sum[i] + of_node[i]))
}

/// Two halves of a bar collide at 900 m/s: patches in the middle of the body, where no condition holds nodes. Mass and momentum
/// are the same to rounding at the end.
#[test]
fn patches_in_the_middle_of_a_body_conserve_mass_and_momentum() {
    let deck = taylor("")
        .replace("*Boundary\n FOOT, 2, 2\n", "")
        .replace("*Initial Conditions, type=VELOCITY\n BAR,", "*Initial Conditions, type=VELOCITY\n UPPER,")
        .replace("*Nset, nset=CORNER\n", "*Nset, nset=UPPER, generate\n <middle>, <toplast>\n*Nset, nset=CORNER\n")
        .replace("v = -speed\n", "v = -2*speed\nmiddle = (nz/2)*row + 1\n");
    let prepared = common::prepared(&deck, &FAST, &Routines::none());
    let [mass, r, z, size] = sums(&prepared.state);
    let (outcome, end) = job::run_into(&prepared, &mut RecordedOutput::default());
    assert_eq!(outcome.halt, None);
    let [new_mass, _, new_z, _] = sums(&end);
    let apart = [new_mass / mass - 1.0, (new_z - z) / size];
    let changes = outcome.new_meshes[0];
    println!("{changes:?}, mass {:.1e}, momentum {:.1e}, r {r}", apart[0], apart[1]);
    assert!(changes.count > 2 && changes.new_elements < 200 * changes.count, "{changes:?}");
    assert!(apart.iter().all(|x| x.abs() < 1e-12), "{apart:?}");
}

/// The same bits with one thread and with several.
#[test]
fn threads_do_not_change_patches() {
    let prepared = common::prepared(&taylor(""), &FAST, &Routines::none());
    let digest = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let (outcome, _) = pool.install(|| job::run_in_memory(&prepared));
        assert!(outcome.halt.is_none() && new_meshes(&outcome) > 2, "{:?}", outcome.halt);
        outcome.digest
    };
    let first = digest(1);
    assert!([2, 5].into_iter().all(|threads| digest(threads) == first));
}

/// A fast copper bar has new elements; a calm bar with an equation of state, which has none, hits another wall. The calm bar ends as
/// alone: place of its tip within 0.1 % of its motion, the effect of the increments. Its state was that of other variables once.
#[test]
fn the_first_new_mesh_of_a_body_keeps_the_state_of_others() {
    let calm = "*Material, name=CALM\n*Density\n 11.34e-9,\n*Elastic, type=SHEAR\n 5.6e3,\n*Plastic\n 20., 0.\n*Eos, \
                type=USUP\n 2.05e6, 1.46, 2.77\n";
    let fast = elastic("FAST", [117e3, 0.35, 8.93e-9], "*Plastic\n 400., 0.\n 600., 2.\n 900., 5.\n");
    let tip_node = "*Nset, nset=TIP\n 1,\n";
    let bars = [
        (
            part("FAST", [6, 60], |i, j| [0.5 * i as f64, 0.5 * j as f64], tip_node),
            fast.as_str(),
            ("FAST", "J0", -450e3),
        ),
        (part("CALM", [4, 20], |i, j| [0.75 * i as f64, j as f64 - 20.0], tip_node), calm, ("CALM", "J1", 60e3)),
    ];
    let tip = |bars: &[(String, &str, (&str, &str, f64))]| {
        let names: Vec<&str> = bars.iter().map(|bar| bar.2.0).collect();
        let parts: String = bars.iter().map(|bar| bar.0.as_str()).collect();
        let materials: String = bars.iter().map(|bar| bar.1).collect();
        let speeds: String = bars.iter().map(|(_, _, (name, _, speed))| format!(" {name}.ALL, 2, {speed}\n")).collect();
        let walls: String =
            bars.iter().map(|(_, _, (name, foot, _))| format!(" {name}.I0, 1\n {name}.{foot}, 2\n")).collect();
        let step = "*Step\n*Dynamic, Explicit\n , 60.e-6\n*Boundary\n";
        let deck = parts
            + &assembly(&names, "")
            + &materials
            + "*Initial Conditions, type=VELOCITY\n"
            + &speeds
            + step
            + &walls;
        let output = "*Output, history, number interval=1\n*Node Output, nset=CALM.TIP\n COOR2\n*End Step\n";
        let ran = bodies::run(&(deck + output)).whole();
        println!("{} new meshes, drift {:.1e}", new_meshes(&ran.outcome), ran.outcome.energy.drift);
        assert_eq!(new_meshes(&ran.outcome) > 0, bars.len() > 1);
        assert!(ran.outcome.energy.drift < 1e-3);
        ran.column("COOR2@CALM.TIP").last().expect("a row")[1]
    };
    let [both, alone] = [tip(&bars), tip(&bars[1..])];
    println!("tip {both} and {alone}");
    assert!(alone > -19.5 && (both - alone).abs() < 1e-3 * (20.0 + alone), "{both} {alone}");
}
