//! Rough contact (no slip) with penalty springs.
//!
//! Goal: contact that prevents slip never creates energy, whatever the time increment.
//! Source: conservation of energy. Tolerance: rounding for the kinetic energy, 0.1 % of the kinetic energy for the dissipated energy.

use crate::common::solid::{column, grid, material, run};

/// A rigid cone enters a plastic block with rough penalty contact. Facets of both surfaces end at different places, so that
/// several rows prevent the slip of the same nodes. Bar: at any fixed increment friction dissipates, and never more than the
/// kinetic energy at the start.
#[test]
fn rough_penalty_contact_does_not_create_energy() {
    for (n, slope) in [(9, 0.5), (10, 0.95), (14, 1.5)] {
        for increment in [0.25, 0.12] {
            let text = rough_cone(n, slope, increment * 9.0 / n as f64);
            let (outcome, memory) = run(&text);
            assert_eq!(outcome.halt, None, "{n} {slope} {increment}");
            let column = |name: &str| column(&text, &memory, name).into_iter().map(|row| row.1).collect::<Vec<f64>>();
            let (kinetic, friction) = (column("ALLKE"), column("ALLFD"));
            let most = kinetic.iter().copied().fold(0.0, f64::max);
            assert!(most <= kinetic[0] * (1.0 + 1e-6), "{n} {slope} {increment}: {most} of {}", kinetic[0]);
            let least = friction.iter().copied().fold(0.0, f64::min);
            let last = friction[friction.len() - 1];
            assert!(
                least > -1e-3 * kinetic[0] && last > 0.0 && last < kinetic[0],
                "{n} {slope} {increment}: {least} {last}"
            );
        }
    }
}

/// Returns a rigid cone of this slope and 0.76 units of kinetic energy above a block of `n` by `n` elements.
fn rough_cone(n: usize, slope: f64, increment: f64) -> String {
    let place = |i: usize, j: usize| {
        let inside = i > 0 && i < n && j > 0 && j < n;
        let shift = if inside { 0.075 * (((7 * i + 3 * j) % 5) as f64 - 2.0) } else { 0.0 };
        [32.0 * (i as f64 + shift) / n as f64, 30.0 * (j as f64 / n as f64 - 1.0)]
    };
    grid(n, n, false, place)
        + &material(0.042, 0.085, 11.7, "*Plastic\n 3.5e-5, 0.\n")
        + &format!(
            "*Node\n 80000, 0., 0.05\n 80001, 0., 0.05\n 80002, 18., {}\n 80003, 18., 40.\n*Element, type=RAX2, elset=NOSE\n 80001, \
             80001, 80002\n 80002, 80002, 80003\n*Element, type=MASS, elset=M\n 80100, 80000\n*Mass, elset=M\n 94400.,\n*Surface, \
             name=NOSE\n NOSE, SNEG\n*Rigid Body, ref node=80000, elset=NOSE\n*Initial Conditions, type=VELOCITY\n 80000, 2, \
             -0.004\n*Surface Interaction, name=I\n*Friction, rough\n*Step\n*Dynamic, explicit, direct user \
             control\n {increment}, 4000.\n*Boundary\n I0, 1, 1\n J0, 2, 2\n*Contact Pair, interaction=I, mechanical \
             constraint=PENALTY\n J1, NOSE\n*Output, history, number interval=100\n*Energy Output\n ALLKE, ALLFD\n*End Step\n",
            0.05 + 18.0 * slope
        )
}
