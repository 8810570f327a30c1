//! Loads that are stiff, sudden, discontinuous, or absent.

use revolve::user::{LoadFailure, LoadPoints, Routines, UserLoad};

use crate::scene::{GauntletRun, off, read, text, with};
use crate::{CaseVerdict, cases, common::solid};

cases! { "Loads":
    a_stiff_user_load, "user pressure of springs 100 times stiffer than the elements: increment from elements only",
        "with SCALE FACTOR=0.05 on the card the block rebounds with its momentum within 5 %, drift < 0.5 %";
    a_stiff_foundation, "user pressure of a foundation ten times as stiff as an element: increment from elements only",
        "without an option on the card: column at rest by Hooke's law within 0.5 %, drift < 0.1 %, one warning";
    a_load_that_blinks, "load that is on in every other increment: work and impulse at the wrong instant",
        "impulse by the trapezoidal rule after 1000 increments, the last half with the previous force: 1e-12; drift < 1e-5 (square of the increment)";
    a_step_load_on_one_facet, "sudden pressure on a single facet",
        "momentum of the free block equal to the impulse within 0.1 %, drift < 1 %";
    a_layer_thinner_than_a_facet, "hard layer of 0.1 mm, facets of 0.6 mm: facets counted as inside or outside",
        "depth within 0.2 % of 400 facets; without the layer more than a micron deeper";
    a_thousand_layers, "target of 1000 layers of one material: lost boundaries, run time",
        "depth of the undivided target within 1e-6";
    arrest_from_3_km_s, "1e9 times the energy of the next case",
        "depth of the closed form within 1e-5 (400 facets, accuracy 1e-6)";
    arrest_from_1_mm_s, "rest within a fraction of the first increment",
        "depth of the closed form within 1e-5";
    no_velocity, "0/0 in direction and in scales",
        "completed without motion";
    starts_inside, "projectile starts with half of its nose in the target",
        "depth between those with the whole nose and with no part of the nose in the target, drift < 1e-5";
    leaves_the_target, "perforation of a thin plate: loads after the back face",
        "no acceleration after the exit, drift < 1e-5";
    misses_the_target, "projectile moves away from the target: loads outside the target",
        "V t within 1e-12, no acceleration";
}

struct ClosureLoad<F>(F);

impl<F: FnMut(&LoadPoints<'_>, &mut [f64]) + Send> UserLoad for ClosureLoad<F> {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        (self.0)(points, pressure);
        Ok(())
    }
}

fn a_stiff_user_load() -> CaseVerdict {
    // A foundation of 100 times the stiffness per area of one element, E/h with h = 20/80.
    let bed = |points: &LoadPoints<'_>, pressure: &mut [f64]| {
        for (p, z) in pressure.iter_mut().zip(points.z) {
            *p = 100.0 * 200e3 / 0.25 * (-z).max(0.0);
        }
    };
    let scene = with("stiff_load.inp", &[], &Routines::none().with_load(ClosureLoad(bed)));
    let nodes = &scene.prepared.state.dofs.nodes;
    let momentum: f64 = nodes.mass.iter().zip(scene.at_nodes("V")).map(|(m, v)| m * v[1]).sum();
    let back = momentum / (1e3 * nodes.mass.iter().sum::<f64>());
    let figure = format!("rebounds with {back:.3} of its momentum, drift {:.2} %", 100.0 * scene.outcome.energy.drift);
    CaseVerdict { figure, holds: scene.completed(5e-3) && off(back, 1.0) < 0.05 }
}

fn a_stiff_foundation() -> CaseVerdict {
    let stiffness = 10.0 * 200e3;
    let bed = move |points: &LoadPoints<'_>, pressure: &mut [f64]| {
        for (p, z) in pressure.iter_mut().zip(points.z) {
            *p = -stiffness * z;
        }
    };
    let deck = solid::grid(2, 20, false, |i, j| [i as f64, j as f64])
        + &solid::material(200e3, 0.0, 7.85e-9, "")
        + "*Nset, nset=HEAD\n 61,\n*Amplitude, name=A, definition=SMOOTH STEP\n 0., 0., 1.e-3, 1.\n*Step\n\
           *Dynamic, Explicit\n , 1.2e-3\n*Dsload\n J0, PNU\n*Dsload, amplitude=A\n J1, P, 100.\n\
           *Output, history, number interval=100\n*Node Output, nset=HEAD\n U2\n*End Step\n";
    let scene = text(&deck, &Routines::none().with_load(ClosureLoad(bed)));
    let (found, exact) = (scene.last("U2@HEAD"), -100.0 * (1.0 / stiffness + 20.0 / 200e3));
    let warnings = scene.outcome.warnings.len();
    let figure = format!("within {:.2} %, {warnings} warning", 100.0 * off(found, exact));
    CaseVerdict { figure, holds: scene.completed(1e-3) && off(found, exact) < 5e-3 && warnings == 1 }
}

fn a_load_that_blinks() -> CaseVerdict {
    let mut calls = 0_u64;
    let blink = move |_: &LoadPoints<'_>, pressure: &mut [f64]| {
        pressure.fill(if calls.is_multiple_of(2) { 8.0 } else { 0.0 });
        calls += 1;
    };
    let scene = with("disc.inp", &[], &Routines::none().with_load(ClosureLoad(blink)));
    let force = 8.0 * std::f64::consts::PI * 0.25;
    // The load acts at increments 0, 2, …, 998, with half its value at the first. The step ends with the force of
    // increment 999, which is zero.
    let exact = 1e-3 * force * (499.0 + 0.5);
    let error = off(scene.last("V2@REF").abs(), exact);
    CaseVerdict { figure: format!("{error:.0e}"), holds: scene.completed(1e-5) && error < 1e-12 }
}

fn a_step_load_on_one_facet() -> CaseVerdict {
    let deck = solid::grid(10, 10, false, |i, j| [i as f64, j as f64])
        + &solid::material(1e5, 0.3, 1.0, "")
        + "*Elset, elset=ONE\n 91,\n*Surface, name=ONE\n ONE, S3\n*Step\n*Dynamic, Explicit\n , 0.5\n*Boundary\n I0, 1, 1\n\
           *Dsload\n ONE, P, 100.\n*Output, field, number interval=1\n*Node Output\n U, V\n*Element Output\n S\n*End Step\n";
    let scene = text(&deck, &Routines::none());
    let nodes = &scene.prepared.state.dofs.nodes;
    let momentum: f64 = nodes.mass.iter().zip(scene.at_nodes("V")).map(|(m, v)| m * v[1]).sum();
    // The area of the face grows with the strain of 1e-3.
    let error = off(-momentum, 100.0 * std::f64::consts::PI * 0.5);
    let figure = format!("impulse within {:.2} %, drift {:.2} %", 100.0 * error, 100.0 * scene.outcome.energy.drift);
    CaseVerdict { figure, holds: scene.completed(0.01) && error < 1e-3 }
}

fn layered(rows: &str, card: &str, settings: &[(&str, &str)]) -> GauntletRun {
    let deck = read("layers.inp").replace(" AL6061, 0.5\n", rows).replace("*Dynamic, Explicit\n", card);
    let mut values = deck;
    for (name, value) in settings {
        let start = values.find(&format!("\n{name} = ")).expect("a parameter") + 1;
        let end = start + values[start..].find('\n').expect("a line");
        values.replace_range(start..end, &format!("{name} = {value}"));
    }
    text(&values, &Routines::none())
}

const PLAIN: &str = "*Dynamic, Explicit\n";
const FINE: &str = "*Dynamic, Explicit, accuracy=1.e-6\n";

fn depth(scene: &GauntletRun) -> f64 {
    -scene.outcome.rests.first().expect("it stops").displacement
}

fn a_layer_thinner_than_a_facet() -> CaseVerdict {
    let rows = " AL6061, 0.02\n HARD, 1.e-4\n AL6061, 0.48\n";
    let [coarse, fine] = ["20", "400"].map(|n| depth(&layered(rows, FINE, &[("n", n)])));
    let without = depth(&layered(" AL6061, 0.5\n", FINE, &[("n", "400")]));
    let figure = format!(
        "within {:.2} %; the layer reduces the depth by {:.2} mm",
        100.0 * off(coarse, fine),
        1e3 * (without - fine)
    );
    CaseVerdict { figure, holds: off(coarse, fine) < 2e-3 && without - fine > 1e-6 }
}

fn a_thousand_layers() -> CaseVerdict {
    let rows = " AL6061, 0.5e-3\n".repeat(1000);
    let (many, one) = (layered(&rows, FINE, &[]), layered(" AL6061, 0.5\n", FINE, &[]));
    let error = off(depth(&many), depth(&one));
    CaseVerdict { figure: format!("{:.0e}", error.max(1e-16)), holds: many.completed(1e-5) && error < 1e-6 }
}

/// Returns the depth of a fully embedded nose: P = m/2b ln(1 + b V^2/a).
fn arrest(speed: &str) -> f64 {
    let (alpha, beta, mass): (f64, f64, f64) = (55_222.618_593, 1.126_227_107_768e-2, 0.021);
    let v: f64 = speed.parse().expect("a number");
    let exact = mass / (2.0 * beta) * (beta * v * v / alpha).ln_1p();
    let scene = layered(" AL6061, 5.\n", FINE, &[("V", speed), ("front", "0.1"), ("n", "400")]);
    assert!(scene.completed(1e-5), "{}", scene.outcome.energy.drift);
    off(depth(&scene), exact)
}

fn arrest_from_3_km_s() -> CaseVerdict {
    let error = arrest("3000.");
    CaseVerdict { figure: format!("{error:.0e}"), holds: error < 1e-5 }
}

fn arrest_from_1_mm_s() -> CaseVerdict {
    let error = arrest("1.e-3");
    CaseVerdict { figure: format!("{error:.0e}"), holds: error < 1e-5 }
}

fn no_velocity() -> CaseVerdict {
    let scene = layered(" AL6061, 0.5\n", PLAIN, &[("V", "0.")]);
    let moved = scene.last("U2@REF");
    CaseVerdict { figure: format!("{moved}"), holds: scene.completed(1e-12) && moved == 0.0 }
}

fn starts_inside() -> CaseVerdict {
    let at = |front: &str| layered(" AL6061, 0.5\n", FINE, &[("front", front)]);
    let (none, half, whole) = (depth(&at("0.")), at("0.006"), depth(&at("0.1")));
    let found = depth(&half);
    let figure = format!("{:.2} mm between {:.2} and {:.2}", 1e3 * found, 1e3 * whole, 1e3 * none);
    CaseVerdict { figure, holds: half.completed(1e-5) && whole < found && found < none }
}

fn leaves_the_target() -> CaseVerdict {
    let scene = layered(" AL6061, 0.005\n", FINE, &[]);
    let (speed, left) = (scene.last("V2@REF"), scene.last("A2@REF"));
    let figure = format!("exit at {:.1} m/s", -speed);
    CaseVerdict { figure, holds: scene.completed(1e-5) && left == 0.0 && speed < -500.0 && speed > -569.0 }
}

fn misses_the_target() -> CaseVerdict {
    let scene = layered(" AL6061, 0.5\n", PLAIN, &[("V", "-569."), ("front", "-0.01")]);
    let error = off(scene.last("U2@REF"), 0.569);
    let figure = format!("{error:.0e}");
    CaseVerdict { figure, holds: scene.completed(1e-12) && error < 1e-12 && scene.last("A2@REF") == 0.0 }
}
