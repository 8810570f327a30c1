//! Infinite elements (CINAX4).
//!
//! Goal: waves leave the mesh, pressure waves and shear waves, in the given and in a refined mesh.
//! Source: plane waves in an infinite bar (Lysmer and Kuhlemeyer 1969): an impulse passes, nothing returns. The tolerance and
//! its reason are stated at each test.

use crate::common;
use crate::common::solid::{column, grid};
use revolve::user::Routines;

const STEP: &str = "*Step\n*Dynamic, Explicit\n , 30.\n";
const OUTPUT: &str = "*Output, history, number interval=60\n*Energy Output\n ALLKE, ALLIE, ALLWK, ETOTAL\n*End Step\n";

/// A bar along z at 1000 < r < 1001 with 100 elements over the length of 10, density 1, Young's modulus 1, ratio 0.25; its
/// upper end has an infinite element if `absorbs`.
fn bar(absorbs: bool, boundary: &str) -> String {
    let mesh = grid(1, 100, false, |i, j| [1000.0 + i as f64, 0.1 * j as f64]);
    let outer =
        "*Node\n 901, 1000., 20.\n 902, 1001., 20.\n*Element, type=CINAX4, elset=FAR\n 901, 201, 202, 902, 901\n";
    let section = "*Solid Section, elset=FAR, material=M\n";
    let (outer, section) = if absorbs { (outer, section) } else { ("", "") };
    let pulse = "*Amplitude, name=PULSE, definition=SMOOTH STEP\n 0., 0., 2., 1., 4., 0.\n";
    let material = "*Material, name=M\n*Density\n 1.,\n*Elastic\n 1., 0.25\n";
    format!("{mesh}{outer}*Solid Section, elset=SOLID, material=M\n{section}{material}{pulse}{STEP}{boundary}{OUTPUT}")
}

/// Returns the kinetic energy left in the bar, of the energy put in by the pulse.
fn energy_left(deck: &str, settings: &[(&str, &str)]) -> f64 {
    let (outcome, memory) = common::run(deck, settings, &Routines::none());
    assert!(outcome.halt.is_none() && outcome.energy.drift < 3e-3, "{:?} {}", outcome.halt, outcome.energy.drift);
    let history = |name: &str| column(deck, &memory, name);
    let most = history("ALLWK").iter().fold(0.0, |most: f64, row| most.max(row.1));
    let end = |name: &str| history(name).last().expect("a row").1;
    end("ALLKE") / most
}

/// Asserts that the waves of a load at the lower end leave the mesh. The traction follows from the velocity half an increment
/// earlier, so that a share of the amplitude in proportion to the element size returns: energy of second order.
fn assert_waves_leave(load: &str) {
    assert!(energy_left(&bar(false, load), &[]) > 0.3);
    let left = [1, 2].map(|n: i32| energy_left(&bar(true, load), &[("mesh", &n.to_string())]));
    assert!(left[0] < 1e-4 && left[1] < 0.35 * left[0], "{left:?}");
}

const PUSH: &str = "*Boundary\n ALL, 1, 1\n*Dload, amplitude=PULSE\n 1, P1, 1e-4\n";

/// A pressure wave, with radial displacements fixed.
#[test]
fn pressure_waves_leave_the_mesh() {
    assert_waves_leave(PUSH);
}

/// A shear wave: nodes move along r only. At a radius of 1000 it is nearly plane; the hoop strain of the displacement that stays
/// is no motion.
#[test]
fn shear_waves_leave_the_mesh() {
    assert_waves_leave("*Boundary\n ALL, 2, 2\n*Dload, amplitude=PULSE\n 1, TRSHR1, 1e-4, 1., 0.\n");
}

/// Infinite elements without a section, twice on a face, or inside the body are errors.
#[test]
fn infinite_elements_without_effect_are_errors() {
    let good = bar(true, PUSH);
    for (from, to) in [
        ("*Solid Section, elset=FAR, material=M\n", ""),
        ("901, 201, 202, 902, 901\n", "901, 201, 202, 902, 901\n 903, 202, 201, 901, 902\n"),
        ("901, 201, 202, 902, 901\n", "901, 101, 102, 902, 901\n"),
    ] {
        let found = revolve::job::prepare_text("a.inp", &good.replace(from, to), &[], &Routines::none()).diagnostics;
        assert!(found.iter().any(|finding| finding.code == "M195"), "{from}");
    }
}
