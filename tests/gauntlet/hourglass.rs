//! Hourglass patterns.

use crate::scene::{deck, off};
use crate::{Verdict, cases};

cases! { "Hourglass":
    point_loads, "forces on single nodes: the pattern that one-point elements do not resist",
        "ALLAE/ALLIE < 15 % (10x10 elements, singular loads), drift < 1 %";
    coarse_bending, "a plate with two elements through its thickness",
        "deflection of the clamped plate (with shear) within 2 % on 20x2 and on 40x4, enhanced control";
    a_million_increments_of_free_vibration, "growth of patterns, drift of energy, drift of position over 1e6 increments",
        "energy of the vibration within 1e-6, centre of mass where its velocity brings it within 1e-9, momentum within 1e-10";
}

fn point_loads() -> Verdict {
    let scene = deck("point_load.inp", &[]);
    let share = scene.last("ALLAE") / scene.last("ALLIE");
    Verdict { figure: format!("ALLAE/ALLIE {:.1} %", 100.0 * share), holds: scene.completed(0.01) && share < 0.15 }
}

/// Timoshenko and Woinowsky-Krieger, sections 16 and 20: w = p a^4/(64 D) (1 + 4 k h^2/a^2...), the part of shear being
/// p a^2/(4 kappa G h) with kappa = 5/6.
fn coarse_bending() -> Verdict {
    let (p, a, h, e, nu) = (0.1, 100.0_f64, 10.0_f64, 200e3, 0.3);
    let stiffness = e * h.powi(3) / (12.0 * (1.0 - nu * nu));
    let exact = p * a.powi(4) / (64.0 * stiffness) + p * a * a / (4.0 * 5.0 / 6.0 * e / (2.0 * (1.0 + nu)) * h);
    let found = [("20", "2"), ("40", "4")].map(|(nr, nz)| {
        let scene = deck("bending.inp", &[("nr", nr), ("nz", nz)]);
        let values = scene.column("U2@FIRST");
        let tail = &values[values.len() - values.len() / 5..];
        assert!(scene.completed(0.01));
        -tail.iter().map(|v| v.1).sum::<f64>() / tail.len() as f64
    });
    let holds = found.iter().all(|w| off(*w, exact) < 0.02);
    Verdict { figure: format!("{:.3e}, {:.3e} mm; {exact:.3e} by theory", found[0], found[1]), holds }
}

fn a_million_increments_of_free_vibration() -> Verdict {
    let scene = deck("flight.inp", &[]);
    let nodes = &scene.prepared.state.dofs.nodes;
    let (mass, moved, speed) = (&nodes.mass, scene.field("U"), scene.field("V"));
    let components = moved.len() / mass.len();
    let total: f64 = mass.iter().sum();
    let mean =
        |values: &[f64]| mass.iter().enumerate().map(|(n, m)| m * values[components * n + 1]).sum::<f64>() / total;
    // The top row starts a thousandth faster than the others.
    let top: f64 = (19..=21).map(|label| mass[scene.node(label)]).sum();
    let start = 1e-3 * (1.0 + 1e-3 * top / total);
    let (place, momentum) = (off(mean(&moved), start * 250_000.0), off(mean(&speed), start));
    // Of the vibration: what remains beside the energy of the flight.
    let vibration = 0.5 * top * (1.0 - top / total) * 1e-12;
    let drift = scene.outcome.energy.drift * 0.5 * total * start * start / vibration;
    let count = scene.outcome.increments;
    println!("{count} increments, drift {drift:.1e}, place {place:.1e}, momentum {momentum:.1e}");
    let holds = drift < 1e-6 && scene.completed(1e-9) && count == 1_000_000 && place < 1e-9 && momentum < 1e-10;
    let few = |x: f64| format!("1e{:.0}", x.max(1e-16).log10().ceil());
    Verdict { figure: format!("energy < {}, place < {}, momentum < {}", few(drift), few(place), few(momentum)), holds }
}
