//! Run time of an increment of a rigid body, compared with a scalar loop of the same arithmetic in the same run.
//!
//! Scene: ogive fully embedded in one layer, 20, 200 and 2000 facets, fixed increments. Loop: normal velocity and
//! pressure of every facet, sum of forces, central differences with predicted velocity.

use std::hint::black_box;
use std::time::Instant;

use revolve::job;
use revolve::user::{LoadFailure, LoadPoints, Routines, UserLoad};

const INCREMENTS: usize = 200_000;
const ROUNDS: usize = 15;

/// A large mass keeps the velocity nearly constant over all increments.
const MASS: f64 = 1e4;
const C0: f64 = 5.0394 * 276e6;
const C2: f64 = 0.9830 * 2710.0;

struct FacetScene {
    facets: Vec<PlainFacet>,
    deck: String,
}

#[derive(Clone, Copy)]
struct PlainFacet {
    normal_z: f64,
    area: f64,
}

/// Returns straight facets along the CRH 3 ogive with the nodes of the deck.
fn scene(n: usize) -> FacetScene {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/input/ogive.inp");
    let deck = std::fs::read_to_string(path).expect("the ogive deck");
    let dt = 1e-3 / INCREMENTS as f64;
    let deck = deck
        .replace("n    = 20", &format!("n = {n}"))
        .replace("mass = 0.021", &format!("mass = {MASS:e}"))
        .replace("front = 0.\n", "front = 0.1\n")
        .replace("AL6061, 0.5", "AL6061, 50.")
        .replace("*Dynamic, Explicit\n , 1.e-3", &format!("*Dynamic, Explicit, direct user control\n {dt:e}, 1.e-3"));
    let deck = deck.split("*Output, field").next().expect("text").to_owned() + "*End Step\n";
    let (a, crh) = (3.555e-3_f64, 3.0_f64);
    let radius = 2.0 * crh * a;
    let height = (radius * radius - (a - radius) * (a - radius)).sqrt();
    let node = |i: usize| {
        let end = (height / (radius - a)).atan();
        let angle = std::f64::consts::PI - end * (1.0 - i as f64 / n as f64);
        [a - radius + radius * -angle.cos(), height - radius * angle.sin()]
    };
    let facet = |i: usize| {
        let (p, q) = (node(i), node(i + 1));
        let length = (q[0] - p[0]).hypot(q[1] - p[1]);
        PlainFacet { normal_z: -(q[0] - p[0]) / length, area: std::f64::consts::PI * (p[0] + q[0]) * length }
    };
    FacetScene { facets: (0..n).map(facet).collect(), deck }
}

/// Returns nanoseconds per increment of the plain loop, and the final kinetic energy.
fn plain_loop(facets: &[PlainFacet]) -> (f64, f64) {
    let begin = Instant::now();
    let dt = black_box(1e-3 / INCREMENTS as f64);
    let (mut v, mut u, mut a, mut half) = (-569.0, 0.0, 0.0, -569.0);
    for increment in 0..=INCREMENTS {
        let speed: f64 = if increment == 0 { v } else { half + 0.5 * dt * a };
        let mut force = 0.0;
        for facet in facets {
            let v_n = speed * facet.normal_z;
            let pressure = if v_n > 0.0 { C0 + C2 * v_n * v_n } else { 0.0 };
            force -= pressure * facet.area * facet.normal_z;
        }
        a = force / MASS;
        if increment > 0 {
            v = half + 0.5 * dt * a;
        }
        if increment < INCREMENTS {
            half = v + 0.5 * dt * a;
            u += dt * half;
        }
    }
    black_box(u);
    (begin.elapsed().as_secs_f64() * 1e9 / INCREMENTS as f64, 0.5 * MASS * v * v)
}

struct CavityLoad;

impl UserLoad for CavityLoad {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        let velocities = points.velocity_r.iter().zip(points.velocity_z);
        let normals = points.normal_r.iter().zip(points.normal_z);
        for ((p, (v_r, v_z)), (n_r, n_z)) in pressure.iter_mut().zip(velocities).zip(normals) {
            let v_n = v_r * n_r + v_z * n_z;
            *p = if v_n > 0.0 { C0 + C2 * v_n * v_n } else { 0.0 };
        }
        Ok(())
    }
}

/// Returns nanoseconds per increment of the solver, and the final kinetic energy.
fn solver_run(deck: &str, routines: &Routines) -> (f64, f64) {
    let prepared = job::prepare_text("ogive.inp", deck, &[], routines);
    let text = prepared.diagnostics.render(&prepared.deck.sources);
    assert!(!prepared.diagnostics.has_errors(), "{text}");
    let (outcome, _) = job::run_in_memory(&prepared);
    assert_eq!((outcome.halt, outcome.increments), (None, INCREMENTS as u64));
    (outcome.seconds * 1e9 / INCREMENTS as f64, outcome.energy.kinetic)
}

/// Prints the run times of CAVITY and of a user load relative to the plain loop: measured in turn, best of all rounds.
fn compare_run_times(n: usize) {
    let FacetScene { facets, deck } = scene(n);
    let own = deck.replace("*Dsload, target=BLOCK, friction=<friction>\n NOSE, CAVITY", "*Dsload\n NOSE, PNU");
    let routine = Routines::none().with_load(CavityLoad);
    let mut best = [f64::INFINITY; 3];
    for _ in 0..if n == 2000 { 3 } else { ROUNDS } {
        let runs = [plain_loop(black_box(&facets)), solver_run(&deck, &Routines::none()), solver_run(&own, &routine)];
        for (best, run) in best.iter_mut().zip(runs) {
            *best = best.min(run.0);
            // The same arithmetic with another order of summation over 200 000 increments.
            let difference = (run.1 / runs[0].1 - 1.0).abs();
            assert!(difference < 1e-11, "{n} facets: kinetic energy differs by {difference:e}");
        }
    }
    let [plain, cavity, user] = best;
    println!(
        "{n:5} facets: loop {plain:.1}, CAVITY {cavity:.1} ({:.2}), UserLoad {user:.1} ({:.2})",
        cavity / plain,
        user / plain
    );
}

pub fn run() {
    println!("nanoseconds per increment, best of {ROUNDS} in turn (ratio to the plain loop)");
    for n in [20, 200, 2000] {
        compare_run_times(n);
    }
}
