//! A deformable body that slides along the wall of a target: pressure and friction of faces at rest along their normals.
//!
//! Goal: the friction of a tube that internal pressure presses against the wall converges with the increment, and is
//! accurate at the default increment. The tolerance and its reason are stated at each test.

use crate::common::solid::{column, grid, last, material, run};

const INNER: f64 = 0.002;
const OUTER: f64 = 0.006;
const LENGTH: f64 = 0.016;
const SPEED: f64 = 500.0;
const PRESSURE: f64 = 400e6;
const DURATION: f64 = 60e-6;
const RISE: f64 = 20e-6;
const FRICTION: f64 = 0.1;

/// Returns the deck of a tube of steel that moves along the axis in a target, with an internal pressure that rises
/// linearly and then stays. The wall can react with up to 1.38 GPa, more than the tube needs.
fn tube(scale: f64) -> String {
    let place = |i: usize, j: usize| [INNER + (OUTER - INNER) * i as f64 / 3.0, LENGTH * j as f64 / 8.0];
    grid(3, 8, false, place)
        + &material(200e9, 0.29, 7850.0, "")
        + &format!(
            "*Material, name=AL\n*Density\n 2710.,\n*Cavity Expansion, yield=276.e6\n 5., 0., 1.\n\
             *Target, name=BLOCK, front=1., direction=-1\n AL, 3.\n\
             *Amplitude, name=RISE\n 0., 0., {RISE:e}, 1., {DURATION:e}, 1.\n\
             *Initial Conditions, type=VELOCITY\n ALL, 2, {:e}\n*Step\n*Dynamic, Explicit, scale factor={scale}\n , {DURATION:e}\n\
             *Dsload, target=BLOCK, friction={FRICTION}\n I1, CAVITY\n*Dsload, amplitude=RISE\n I0, P, {PRESSURE:e}\n\
             *Output, history, frequency=1\n*Energy Output\n ALLFD, ALLCAV, ALLKE, ETOTAL\n*End Step\n",
            -SPEED
        )
}

/// Returns the friction energy at the end, after checks of signs: the work of resistance never decreases by more than
/// 1e-4 of the friction energy, since sweeps leave small changes of the pressures.
fn friction_energy(scale: f64) -> f64 {
    let deck = tube(scale);
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    let friction = last(&deck, &memory, "ALLFD");
    for name in ["ALLFD", "ALLCAV"] {
        let values = column(&deck, &memory, name);
        let lowest = values.windows(2).map(|pair| pair[1].1 - pair[0].1).fold(0.0, f64::min);
        assert!(lowest > -1e-4 * friction, "{name} decreases by {lowest:e}");
    }
    friction
}

/// The friction energy at the default increment is within 3 % of that with a 32nd of the increment, and converges with
/// at least first order. An explicit pressure that stops faces makes less than a tenth of the friction at the default increment, and one that reverses faces six times as much.
#[test]
fn friction_of_a_sliding_tube_converges_with_the_increment() {
    let converged = friction_energy(1.0 / 32.0);
    let errors = [1.0, 0.5, 0.25].map(|scale| (friction_energy(scale) / converged - 1.0).abs());
    println!("friction energy {converged:.2} J, errors {errors:?}");
    assert!(errors[0] < 0.03, "{errors:?}");
    let order = 0.5 * (errors[0] / errors[2]).log2();
    assert!(order >= 1.0 && errors[1] < errors[0], "order {order}, {errors:?}");
}
