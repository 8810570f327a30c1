//! Each kind of load on a rigid cone and on a nearly rigid deformable cone.
//!
//! Goal: a load has the same ledger rows, frame fields, increment limits and work on either body.
//! Source: Newton's second law for the same mass under the same load. Young's modulus of the deformable cone is 1e12
//! Pa, which keeps its strains below 1e-6.
//! Tolerance: 2e-3 of displacement and work. The rest is the elastic vibration that the load excites (p/(rho c) = 3e-3
//! of the final velocity) and the tangential motion of the faces. Resistances depend on this vibration to second order.

use std::f64::consts::PI;

use revolve::job;
use revolve::user::{LoadFailure, LoadPoints, Routines, UserLoad};

use crate::common;
use crate::common::solid::{grid, material};

/// Number of elements along r and along z.
const N: usize = 4;
const DENSITY: f64 = 1000.0;

/// Returns the mesh of a downward-pointing cone shell of radius 1 with a thickness of 1 along z.
fn cone() -> String {
    grid(N, N, false, |i, j| [i as f64 / N as f64, 0.5 * i as f64 / N as f64 + j as f64 / N as f64])
}

/// Returns the deck of a rigid or deformable cone with an initial axial velocity under a load.
fn deck(rigid: bool, velocity: f64, step: &str) -> String {
    // Volume by the theorem of Pappus: a section of area 1 with its centroid at r = 1/2.
    let mass = DENSITY * PI;
    let body = if rigid {
        format!(
            "*Node, nset=REF\n 999, 0., 0.\n*Rigid Body, ref node=999, elset=SOLID\n*Element, type=MASS, elset=MASS\n 999, 999\n\
             *Mass, elset=MASS\n {mass:.17e}\n*Nset, nset=BODY\n 999\n"
        )
    } else {
        material(1e12, 0.0, DENSITY, "") + "*Nset, nset=BODY\n ALL\n"
    };
    cone()
        + &body
        + "*Nset, nset=P\n 25\n*Material, name=SOIL\n*Density\n 2000.,\n*Cavity Expansion, yield=1.e5\n 4., 0., 1.\n\
           *Target, name=GROUND, front=-0.01, direction=-1\n SOIL, 0.03\n SOIL, 100.\n\
           *Amplitude, name=KINK\n 0., 0., 0.0033, 1., 1., 1.\n"
        + &format!("*Initial Conditions, type=VELOCITY\n BODY, 2, {velocity}\n")
        + &format!("*Step\n*Dynamic, Explicit\n , 0.01\n{step}")
        + "*Output, field, number interval=4\n*Node Output\n U\n*Output, history, number interval=200\n*Node Output, nset=P\n U2\n\
           *Energy Output\n ALLWK, ALLCAV, ALLFD\n*End Step\n"
}

/// Pressure that grows with time and opposes the motion, and a body force.
struct PressureAndBodyForce;

impl UserLoad for PressureAndBodyForce {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        for (p, v) in pressure.iter_mut().zip(points.velocity_z) {
            *p = points.amplitude * (1e5 - 1e4 * v);
        }
        Ok(())
    }
}

fn routines() -> Routines {
    Routines::none().with_load(PressureAndBodyForce)
}

/// Returns the ledger rows of the load with their counts.
fn load_effects(text: &str) -> Vec<(String, usize)> {
    let prepared = common::prepared(text, &[], &routines());
    let loads =
        ["pressure", "concentrated force", "gravity", "user load", "user body force", "cavity expansion", "friction"];
    let others = ["target", "load velocity"];
    let rows = prepared.plan.ledger.effects.iter().filter(|r| loads.iter().chain(&others).any(|l| *l == r.effect));
    // Forces and gravity act on the one rigid body or on all nodes of the deformable one.
    rows.map(|r| (r.effect.clone(), if r.unit == "facets" || r.unit == "points" { r.count } else { 0 })).collect()
}

#[test]
fn loads_act_alike_on_rigid_and_deformable_bodies() {
    let loads = [
        ("pressure", 0.0, "*Dsload, amplitude=KINK\n J0, P, 1.e5\n"),
        ("concentrated force", 0.0, "*Cload, amplitude=KINK\n BODY, 2, FORCE\n"),
        ("gravity", 0.0, "*Dload, amplitude=KINK\n , GRAV, 100., 0., -1.\n"),
        ("user pressure", -10.0, "*Dsload, amplitude=KINK\n J0, PNU\n"),
        ("user body force", -10.0, "*Dload, amplitude=KINK\n SOLID, BZNU\n"),
        ("resistance", -10.0, "*Dsload, target=GROUND\n J0, CAVITY\n"),
        ("resistance with friction", -10.0, "*Dsload, target=GROUND, friction=0.1\n J0, CAVITY\n"),
    ];
    for (name, velocity, load) in loads {
        // The same total force: on one reference node, or divided over all nodes.
        let force = |rigid: bool| if rigid { 3e5 } else { 3e5 / ((N + 1) * (N + 1)) as f64 };
        let text = |rigid: bool| deck(rigid, velocity, &load.replace("FORCE", &force(rigid).to_string()));
        let (rigid, soft) = (text(true), text(false));
        assert_eq!(load_effects(&rigid), load_effects(&soft), "{name}: rows of the ledger");
        let runs = [&rigid, &soft].map(|text| common::run(text, &[], &routines()));
        for (outcome, _) in &runs {
            assert_eq!(outcome.halt, None, "{name}");
        }
        for column in ["U2@P", "ALLWK", "ALLCAV", "ALLFD"] {
            let of = |text: &str, run: usize| {
                let at = common::prepared(text, &[], &routines()).plan.columns.iter().position(|c| c.name == column);
                runs[run].1.rows.last().expect("a row").1[at.expect("a column")]
            };
            let (a, b) = (of(&rigid, 0), of(&soft, 1));
            println!("{name}, {column}: rigid {a:.6e}, deformable {b:.6e}");
            // Zero values are zero to the rounding of energies of 1e5.
            assert!((a - b).abs() <= 2e-3 * a.abs() + 1e-9, "{name}, {column}: {a} against {b}");
        }
        let fields = |run: usize| {
            let frame = runs[run].1.frames.last().expect("a frame");
            let facet = ["PRESSURE", "NORMAL_VELOCITY", "LAYER"];
            let shown = frame.cell_fields.iter().filter(|f| facet.contains(&f.name.as_str()));
            shown.map(|f| (f.name.clone(), f.values.clone())).collect::<Vec<_>>()
        };
        for ((field, a), (other, b)) in fields(0).into_iter().zip(fields(1)) {
            assert_eq!(field, other, "{name}");
            let size = a.iter().fold(0.0f64, |m, v| m.max(v.abs()));
            // A vibration of 3e-3 of the velocity enters the resistance squared.
            let worst = a.iter().zip(&b).fold(0.0f64, |m, (x, y)| m.max((x - y).abs()));
            assert!(worst <= 1e-2 * size, "{name}, {field}: {a:?} against {b:?}");
        }
        assert_eq!(fields(0).len(), fields(1).len(), "{name}: fields of frames");
    }
}

/// Increments end at the kinks of an amplitude, so the impulse of a piecewise linear load is exact.
#[test]
fn increments_end_at_amplitude_kinks() {
    for rigid in [true, false] {
        let text = deck(rigid, 0.0, "*Dsload, amplitude=KINK\n J0, P, 1.e5\n")
            .replace("*Output, history, number interval=200\n", "*Output, history, frequency=1\n");
        let (_, memory) = common::run(&text, &[], &Routines::none());
        let nearest = memory.rows.iter().map(|row| (row.0 - 0.0033).abs()).fold(f64::MAX, f64::min);
        assert!(nearest < 1e-15, "rigid {rigid}: nearest increment end {nearest:e} from the kink");
    }
}

/// A facet parallel to the faces of the layers meets a layer at one instant, and an increment ends there.
#[test]
fn increments_end_when_a_flat_face_reaches_a_layer() {
    for rigid in [true, false] {
        let flat = deck(rigid, -10.0, "*Dsload, target=GROUND\n J0, CAVITY\n")
            .replace(&cone(), &grid(N, N, false, |i, j| [i as f64 / N as f64, j as f64 / N as f64]))
            .replace("*Output, history, number interval=200\n", "*Output, history, frequency=1\n");
        let (_, memory) = common::run(&flat, &[], &Routines::none());
        let prepared = common::prepared(&flat, &[], &Routines::none());
        let at = prepared.plan.columns.iter().position(|c| c.name == "U2@P").expect("a column");
        // Time at which free flight reaches the front at z = -0.01.
        let nearest = memory.rows.iter().map(|row| (row.1[at] + 0.01).abs()).fold(f64::MAX, f64::min);
        assert!(nearest < 1e-9, "rigid {rigid}: nearest increment end {nearest:e} from the contact");
    }
}

/// An infinite resistance stops the run with the same code for both bodies.
#[test]
fn infinite_resistance_stops_the_run() {
    for rigid in [true, false] {
        let text = deck(rigid, -1e160, "*Dsload, target=GROUND\n J0, CAVITY\n").replace("front=-0.01", "front=10.");
        let (outcome, _) = common::run(&text, &[], &Routines::none());
        assert_eq!(outcome.halt.map(|h| h.code()), Some("R202"), "rigid {rigid}");
    }
}

/// One plan and initial state run twice in sequence and twice in parallel with the same bits.
#[test]
fn repeated_and_parallel_runs_of_a_plan_have_the_same_bits() {
    let text = deck(false, -10.0, "*Dsload, target=GROUND, friction=0.1\n J0, CAVITY\n");
    let prepared = &common::prepared(&text, &[], &Routines::none());
    let run = || job::run_in_memory(prepared).0.digest;
    let first = run();
    let (second, third) = std::thread::scope(|scope| {
        let threads = [scope.spawn(run), scope.spawn(run)];
        let [a, b] = threads.map(|t| t.join().expect("a run"));
        (a, b)
    });
    assert_eq!([&second, &third], [&first, &first]);
}
