//! Wave fronts and sliding on fine meshes with the default damping.
//!
//! Goal: step waves that converge although bulk viscosity acts, and a friction force that does not fall by flutter.
//! Source: wave theory of bars of different impedance; the rigid-plastic friction of a pulled bar in statics.

use std::f64::consts::PI;

use crate::common::bodies::{DeckRun, assembly, elastic, part, point_field, rigid_line, run};
use crate::common::solid::WHOLE_VISCOSITY;

/// Speed of impact of the bars, and time at the end.
const SPEED: f64 = 1e-3;
const TIME: f64 = 0.7;
/// Density and modulus of the second bar. Those of the first bar and its length are 1.
const SECOND: [f64; 2] = [0.81, 0.36];

fn run_bars(n: usize, time: f64, viscosity: &str) -> DeckRun {
    let [density, modulus] = SECOND;
    let bar = |name: &str, from: f64| part(name, [1, n], |i, j| [0.05 * i as f64, from + j as f64 / n as f64], "");
    let deck = bar("FIRST", 0.0)
        + &bar("SECOND", 1.0)
        + &assembly(&["FIRST", "SECOND"], "")
        + &elastic("FIRST", [1.0, 0.0, 1.0], "")
        + &elastic("SECOND", [modulus, 0.0, density], "")
        + &format!("*Surface Interaction, name=I\n*Initial Conditions, type=VELOCITY\n FIRST.ALL, 2, {SPEED}\n")
        + &format!(
            "*Step\n*Dynamic, Explicit\n , {time}\n{viscosity}*Contact Pair, interaction=I\n FIRST.J1, SECOND.J0\n"
        )
        + "*Output, field, number interval=1\n*Node Output\n V, U\n*Output, history, number interval=1\n*Energy Output\n ALLVD\n*End Step\n";
    run(&deck).whole()
}

/// Returns the mean error of the velocities over the speed of impact, and the share of the energy in ALLVD.
fn unequal_bars(n: usize, viscosity: &str) -> [f64; 2] {
    let ran = run_bars(n, TIME, viscosity);
    let [density, modulus] = SECOND;
    let (impedance, wave) = ((density * modulus).sqrt(), (modulus / density).sqrt());
    let velocity = point_field(ran.end(), "V");
    let error = |name: &str, exact: &dyn Fn(f64) -> f64| {
        let nodes = ran.nodes(name);
        let off = nodes.iter().map(|&[node, place]| {
            let start = ran.state.dofs.nodes.start[place][1];
            (velocity[2 * node + 1] / SPEED - exact(start)).abs()
        });
        off.sum::<f64>() / nodes.len() as f64
    };
    let between = 1.0 / (1.0 + impedance);
    let first = error("FIRST", &|z| if z < 1.0 - TIME { 1.0 } else { between });
    let second = error("SECOND", &|z| if z < 1.0 + wave * TIME { between } else { 0.0 });
    [first + second, ran.column("ALLVD").last().expect("a row")[1] / ran.outcome.energy.initial]
}

/// Bulk viscosity that takes more than 5 % of the energy causes a warning unless the deck requests damping.
#[test]
fn large_viscous_dissipation_is_reported() {
    let warnings = |n, viscosity: &str| run_bars(n, 4.0, viscosity).outcome.warnings;
    let found = warnings(10, "*Bulk Viscosity, linear term=UNFILTERED\n 1., 1.2\n");
    println!("{found:?}");
    assert!(found.len() == 1 && found[0].contains("(ALLVD)") && found[0].contains("*BULK VISCOSITY"), "{found:?}");
    assert_eq!(warnings(40, ""), [""; 0]);
}

/// A viscosity that acts on the whole rate smears fronts with order 1/2 in the limit (0.59 between the finest meshes).
/// Fronts that central differences disperse converge with order 2/3 (0.77). The filtered viscosity takes half as much
/// energy.
#[test]
fn filtered_viscosity_raises_the_order_of_fronts() {
    let meshes = [40, 80, 160];
    let filtered = meshes.map(|n| unequal_bars(n, ""));
    let whole = meshes.map(|n| unequal_bars(n, WHOLE_VISCOSITY));
    let order = |levels: [[f64; 2]; 3]| 0.5 * (levels[0][0] / levels[2][0]).log2();
    let orders = [order(filtered), order(whole)];
    println!("fronts in unequal bars: {filtered:.5?}, whole rate {whole:.5?}, orders {orders:.2?}");
    assert!(orders[0] > 0.7 && orders[0] > orders[1] + 0.05, "{orders:?}");
    assert!(filtered[2][0] < 0.92 * whole[2][0] && filtered[2][1] < 0.55 * whole[2][1], "{filtered:?} {whole:?}");
}

/// Units of [`pulled_tube`]: mm, t, s.
const ORIGINAL: [f64; 3] = [1.0; 3];

/// Pulls a tube of radii 4 and 5, which an inner pressure of 10 presses to a rigid hollow cylinder, and returns the
/// displacement of its end over that of statics, F^2/(2 E A f) with the friction f per length. The units are mm, t and s
/// times `units`.
fn pulled_tube([nr, nz]: [usize; 2], mu: f64, friction: &str, units: [f64; 3]) -> (f64, Vec<String>) {
    let (modulus, pressure, stress) = (2e5, 10.0, 520.0 * mu);
    // Lame's tube with u = 0 at the outer radius and without lateral contraction.
    let c = -pressure / (-1.0 / 25.0 - 1.0 / 16.0);
    let wall = 2.0 * c / 25.0;
    let area = PI * 9.0;
    let exact = (stress * area).powi(2) / (2.0 * modulus * area * mu * wall * 10.0 * PI);
    let end = 1 + nz * (nr + 1);
    let [length, mass, time] = units;
    let stresses = mass / (length * time * time);
    let deck = part(
        "TUBE",
        [nr, nz],
        |i, j| [4.0 + i as f64 / nr as f64, 100.0 * j as f64 / nz as f64].map(|x| x * length),
        &format!("*Nset, nset=END\n {end},\n"),
    ) + &rigid_line("WALL", &[[5.0, -10.0], [5.0, 120.0]].map(|place| place.map(|x| x * length)), "")
        + &assembly(&["TUBE", "WALL"], "*Rigid Body, ref node=WALL.REF, elset=WALL.E\n")
        + &elastic("TUBE", [modulus * stresses, 0.0, 7.85e-9 * mass / length.powi(3)], "")
        + &format!(
            "*Surface Interaction, name=I\n*Friction{friction}\n {mu}\n\
             *Amplitude, name=PRESS, definition=SMOOTH STEP\n 0., 0., {}, 1.\n\
             *Amplitude, name=PULL, definition=SMOOTH STEP\n 0., 0., {}, 0., {}, 1.\n*Step\n*Dynamic, Explicit\n , {}\n\
             *Boundary\n WALL.REF, ENCASTRE\n TUBE.J0, 2, 2\n*Contact Pair, interaction=I\n TUBE.I1, WALL.SKIN\n\
             *Dsload, amplitude=PRESS\n TUBE.I0, P, {}\n*Dsload, amplitude=PULL\n TUBE.J1, P, {}\n\
             *Output, history, number interval=1\n*Node Output, nset=TUBE.END\n U2\n*End Step\n",
            3e-4 * time,
            4e-4 * time,
            1.4e-3 * time,
            1.6e-3 * time,
            pressure * stresses,
            -stress * stresses
        );
    let ran = run(&deck).whole();
    let moved = ran.column("U2@TUBE.END").last().expect("a row")[1];
    (moved / (exact * length), ran.outcome.warnings)
}

/// Friction and the damping of flutter contain no value with a unit: units that differ by powers of two give the same
/// bits.
#[test]
fn friction_does_not_depend_on_units() {
    let [one, other] = [ORIGINAL, [8.0, 0.25, 32.0]].map(|units| pulled_tube([2, 50], 0.1, "", units));
    assert!(one == other && one.0 > 0.9, "{one:?} {other:?}");
}

/// On 4x200 elements with a coefficient of 0.1 the tube flutters without damping, its end moves twice as far, and a
/// warning names flutter.
#[test]
fn pulled_tube_keeps_its_friction_force_on_fine_meshes() {
    for (mesh, mu) in [([2, 100], 0.3), ([4, 200], 0.1), ([4, 200], 0.3)] {
        let (ratio, warnings) = pulled_tube(mesh, mu, "", ORIGINAL);
        println!("pulled tube: {ratio:.4} of the displacement of statics");
        assert!((ratio - 1.0).abs() < 0.02 && warnings.is_empty(), "{ratio} {warnings:?}");
    }
    let (undamped, warnings) = pulled_tube([4, 200], 0.1, ", slip damping=0", ORIGINAL);
    println!("pulled tube without damping: {undamped:.4}, {warnings:?}");
    assert!(undamped > 1.3 && warnings.iter().any(|w| w.contains("flutter")), "{undamped} {warnings:?}");
}
