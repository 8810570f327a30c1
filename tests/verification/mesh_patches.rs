//! New elements in a part of a body without a card.
//!
//! Goal: conservation of mass and momentum, and the same bits on any number of threads. Source: the initial state, and the run
//! with one thread. Tolerance: rounding. A unit test of `solve/mesh_patch.rs` compares the elements outside the part.

use revolve::job;
use revolve::plan::State;
use revolve::user::Routines;

use crate::common::{self, RecordedOutput};
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
