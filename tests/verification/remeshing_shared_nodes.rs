//! New meshes of bodies that share nodes, as a jacket and its core, or layers of a plate.
//!
//! Goal: new meshes keep the common nodes and the edges between them, two parts of one material move as one body, mass and momentum
//! are conserved, and threads change no bit. Sources: the same bar in one section, the initial state, the run with one thread.

use revolve::job;
use revolve::user::Routines;

use crate::common::{self, RecordedOutput};
use crate::mesh_patches::sums;
use crate::remeshing::{run, taylor};

/// Elements of the bar along r and z.
const COUNTS: [usize; 2] = [6, 60];
/// Settings of a fast bar, whose foot is squashed.
const FAST: [(&str, &str); 5] = [("radius", "3e-3"), ("length", "30e-3"), ("speed", "450."), ("nr", "6"), ("nz", "60")];
const BOTH: &str = "*Remesh, elset=INNER, frequency=5\n*Remesh, elset=OUTER, frequency=5\n";

/// Returns the bar in two sections with common nodes: `is_inner` of an element's column. The second section has the same
/// material with another name.
fn divided(deck: &str, is_inner: impl Fn(usize) -> bool) -> String {
    let [nr, nz] = COUNTS;
    let set = |name: &str, wanted: bool| {
        let elements = (0..nr * nz).filter(|e| is_inner(e % nr) == wanted);
        let lines: String = elements.map(|e| format!(" {}\n", e + 1)).collect();
        format!("*Elset, elset={name}\n{lines}")
    };
    let section = "*Solid Section, elset=BAR, material=COPPER\n";
    let sections = "*Solid Section, elset=INNER, material=COPPER\n*Solid Section, elset=OUTER, material=ALIKE\n";
    let start = deck.find("*Material, name=COPPER").expect("a material");
    let end = deck.find("*Initial Conditions").expect("initial conditions");
    let alike = deck[start..end].replace("name=COPPER", "name=ALIKE");
    let divided = deck.replace(section, &(set("INNER", true) + &set("OUTER", false) + sections));
    divided.replacen("*Initial Conditions", &format!("{alike}*Initial Conditions"), 1)
}

/// A core of a third and of two thirds of the radius with a jacket, with new meshes of both: length and foot are those of the bar in one
/// section within 1 %, as whole new meshes are, the energy balance is closed, and both parts have new meshes.
#[test]
fn parts_of_one_material_deform_as_one_body() {
    let (_, reference) = run(&taylor("*Remesh, elset=BAR, frequency=5\n"), &FAST);
    for columns in [2, 4] {
        let (outcome, history) = run(&divided(&taylor(BOTH), |column| column < columns), &FAST);
        assert_eq!(outcome.halt, None);
        let counts: Vec<u64> = outcome.new_meshes.iter().map(|changes| changes.count).collect();
        println!("{counts:?} new meshes, drift {:.1e}, {} increments", outcome.energy.drift, outcome.increments);
        for quantity in ["COOR2@TIP", "COOR1@CORNER"] {
            let apart = history.0[quantity].last / reference.0[quantity].last - 1.0;
            println!("    {quantity} {:.3} % apart", 100.0 * apart);
            assert!(apart.abs() < 0.01, "{quantity} {apart}");
        }
        assert!(counts.iter().all(|count| *count > 0) && outcome.energy.drift < 1e-3, "{counts:?}");
    }
}

/// A core with a jacket flies, and its lower half is faster: nothing holds it. Mass and momentum are the same to rounding at the
/// end, and the digest does not depend on threads.
#[test]
fn common_nodes_keep_mass_and_momentum() {
    let free = taylor(BOTH)
        .replace("*Boundary\n FOOT, 2, 2\n", "")
        .replace("*Initial Conditions, type=VELOCITY\n BAR,", "*Initial Conditions, type=VELOCITY\n UPPER,")
        .replace("*Nset, nset=CORNER\n", "*Nset, nset=UPPER, generate\n <middle>, <toplast>\n*Nset, nset=CORNER\n")
        .replace("v = -speed\n", "v = -2*speed\nmiddle = (nz/2)*row + 1\n");
    let prepared = common::prepared(&divided(&free, |column| column < 2), &FAST, &Routines::none());
    let [mass, _, z, size] = sums(&prepared.state);
    let runs = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| job::run_into(&prepared, &mut RecordedOutput::default()))
    });
    let [(outcome, end), (other, _)] = runs;
    assert_eq!((&outcome.halt, &outcome.digest), (&None, &other.digest));
    let [new_mass, _, new_z, _] = sums(&end);
    let apart = [new_mass / mass - 1.0, (new_z - z) / size];
    println!("{:?}, mass {:.1e}, momentum {:.1e}", outcome.new_meshes, apart[0], apart[1]);
    assert!(outcome.new_meshes.iter().all(|changes| changes.count > 0), "{:?}", outcome.new_meshes);
    assert!(apart.iter().all(|x| x.abs() < 1e-12), "{apart:?}");
}
