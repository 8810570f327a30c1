//! Restart of laws whose strength depends on pressure, porosity or direction.
//!
//! Goal: a run stopped at any of six places between loading and unloading, and resumed, has the bits of an uninterrupted run; on
//! one thread and on two, on a mesh that follows the material, an adaptive mesh and new meshes.
//! Source: the uninterrupted run. Tolerance: none.

use revolve::solve::Outcome;
use revolve::user::Routines;

use crate::restart::{assert_resumes, bar, bare};

const SOIL: &str = "*Density\n 1.7e-9,\n*Elastic\n 300., 0.25\n";
const METAL: &str = "*Density\n 7.83e-9,\n*Elastic\n 206e3, 0.3\n*Plastic\n 400., 0.\n 600., 0.5\n";
const COHESION: &str = "*Drucker Prager Hardening\n 0.5, 0.\n 1., 0.1\n";

/// A law: its name, cards, and the velocity of the bar, mm/s.
struct Law {
    name: &'static str,
    cards: String,
    speed: f64,
}

fn laws() -> Vec<Law> {
    let law = |name, cards: String, speed| Law { name, cards, speed };
    let drucker_prager = |form: &str| format!("{SOIL}{form}{COHESION}");
    vec![
        law("Drucker-Prager, linear", drucker_prager("*Drucker Prager\n 35., 0.85, 5.\n"), 3e4),
        law(
            "Drucker-Prager, hyperbolic",
            drucker_prager("*Drucker Prager, shear criterion=HYPERBOLIC\n 35., 0.1, 10.\n"),
            3e4,
        ),
        law(
            "Drucker-Prager, exponent",
            drucker_prager("*Drucker Prager, shear criterion=EXPONENT FORM\n 0.5, 1.5, 10.\n"),
            3e4,
        ),
        law(
            "cap",
            format!(
                "{SOIL}*Cap Plasticity\n 0.1, 35., 0.4, 0., 0.03\n*Cap Hardening\n 0.2, 0.\n 1., 0.02\n 10., 0.1\n 100., 0.25\n"
            ),
            3e4,
        ),
        law(
            "P-alpha",
            "*Density\n 2.7e-9,\n*Eos, type=USUP\n 5.35e6, 1.34, 2.\n*Eos Compaction\n 3.5e6, 0.2, 80., 700.\n*Elastic, \
             type=SHEAR\n 2.e4,\n*Plastic\n 200., 0.\n"
                .into(),
            2e5,
        ),
        law(
            "Johnson-Holmquist 2",
            "*Density\n 3.7e-9,\n*User Material, constants=24\n 3.7e-9, 90.16e3, 0.93, 0.6, 0.31, 0.6, 0., 1.\n 0.2e3, , , 2.79e3, \
             1.46e3, 1., 0.005, 1.\n , 0., 0., 0., 130.95e3, 0., 0., 0.\n*Depvar\n 8,\n"
                .into(),
            2e5,
        ),
        law(
            "Holmquist-Johnson-Cook",
            "*Density\n 2.44e-9,\n*Holmquist Johnson Cook\n 14.86e3, 0.79, 1.6, 0.007, 0.61, 48., 4., 1.\n 0.01, 7., 16., 0.001, \
             800., 0.1, 0.04, 1.\n 85.e3, -171.e3, 208.e3, 0.\n"
                .into(),
            1e5,
        ),
        law(
            "concrete damaged plasticity",
            "*Density\n 2.4e-9,\n*Elastic\n 30.e3, 0.2\n*Concrete Damaged Plasticity\n 35., 0.1, 1.16, 0.667\n*Concrete \
             Compression Hardening\n 15., 0.\n 30., 0.0015\n 6., 0.009\n*Concrete Compression Damage\n 0., 0.\n 0.15, 0.0015\n 0.8, \
             0.009\n*Concrete Tension Stiffening\n 2.6, 0.\n 0.2, 0.0024\n*Concrete Tension Damage\n 0., 0.\n 0.8, 0.0024\n"
                .into(),
            3e4,
        ),
        law("Hill", format!("{METAL}*Potential\n 1., 1.2, 0.9, 1.1, 1., 1.\n"), 2e5),
        law(
            "porous metal",
            format!("{METAL}*Porous Metal Plasticity, relative density=0.98\n 1.5, 1., 2.25\n*Void Nucleation\n 0.3, 0.1, 0.04\n"),
            2e5,
        ),
        law(
            "tensile failure that stays",
            format!("{METAL}*Tensile Failure, element deletion=NO, pressure=BRITTLE, shear=DUCTILE\n 500.,\n"),
            2e5,
        ),
    ]
}

/// Returns a bar of a law that hits its fixed foot and rebounds: the waves cross it about twice.
fn rebound(law: &Law, n: usize, time: f64, cards: &str) -> String {
    let name = if law.name.starts_with("Johnson") { "ABQ_JH2_M" } else { "M" };
    let material = bare(&law.cards).replace("name=M\n", &format!("name={name}\n"));
    bar(n, &material.replace("material=M\n", &format!("material={name}\n")), law.speed, time, cards)
}

/// Returns the duration of two crossings.
fn duration(law: &Law) -> f64 {
    if law.cards.starts_with(SOIL) { 50e-6 } else { 8e-6 }
}

fn check(law: &Law, outcome: &Outcome) {
    assert_eq!(outcome.halt, None, "{}", law.name);
    println!("{}: {} increments, drift {:.1e}", law.name, outcome.increments, outcome.energy.drift);
}

#[test]
fn laws_with_strength_over_pressure_resume_on_one_thread_and_two() {
    for law in laws() {
        let deck = rebound(&law, 8, duration(&law), "");
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| assert_resumes(law.name, &deck, Routines::none))
        };
        let [one, two] = [1, 2].map(on);
        check(&law, &one);
        assert_eq!(one.digest, two.digest, "{}: the number of threads changes the results", law.name);
    }
}

/// Each law accepts adaptive and new meshes, and its states move with them.
#[test]
fn laws_with_strength_over_pressure_resume_on_moving_and_new_meshes() {
    for law in laws() {
        let adaptive = rebound(&law, 8, duration(&law), "*Adaptive Mesh, elset=SOLID, frequency=3\n");
        let outcome = assert_resumes(law.name, &adaptive, Routines::none);
        check(&law, &outcome);
        assert!(outcome.mesh_changes[0].count > 10, "{}: {:?}", law.name, outcome.mesh_changes);
        let remesh = "*Remesh, elset=SOLID, frequency=10, angle=1., increment=0.9999999\n*Step\n";
        let new = rebound(&law, 8, duration(&law), "").replacen("*Step\n", remesh, 1);
        let outcome = assert_resumes(law.name, &new, Routines::none);
        check(&law, &outcome);
        assert!(outcome.new_meshes[0].count >= 2, "{}: {:?}", law.name, outcome.new_meshes);
    }
}
