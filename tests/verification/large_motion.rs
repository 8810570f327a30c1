//! Large rotations and shears, and the wave in a bar with free sides.
//!
//! Goal: the stress rotates with the material without strain, large shear follows the Jaumann rate, and a bar has its
//! own wave speed instead of that of uniaxial strain. The tolerance and its reason are stated at each test.
//! Source: rigid motion; closed form of simple shear with the Jaumann rate (Dienes 1979, Acta Mech. 32, 217);
//! sqrt(E/rho) and rho c v of a bar.

use std::f64::consts::PI;
use std::fmt::Write as _;

use revolve::user::{LoadFailure, MotionCall, Routines, UserMotion};

use crate::common;
use crate::common::solid::{column, grid, last, material, run};

/// Rotation of a block in the (r, z) plane at a constant rate; the large radius makes the hoop strain negligible.
struct BlockRotation {
    middle: [f64; 2],
    rate: f64,
}

impl UserMotion for BlockRotation {
    fn motion(&mut self, call: &MotionCall<'_>) -> Result<f64, LoadFailure> {
        let axis = call.dof - 1;
        // Initial coordinates of the node.
        let node = call.node as usize - 1;
        let start = [self.middle[0] + (node % 3) as f64 - 1.0, (node / 3) as f64];
        let arm = [start[0] - self.middle[0], start[1] - self.middle[1]];
        let (s, c) = (self.rate * call.now.total_time).sin_cos();
        let turned = [c * arm[0] - s * arm[1], s * arm[0] + c * arm[1]];
        Ok(turned[axis] - arm[axis])
    }
}

/// The initial stress of a block rotates with it by a quarter, 0.4 and a whole turn.
#[test]
fn rigid_rotation_rotates_stress_without_strain() {
    let radius = 1e6;
    let deck = |turns: f64| {
        grid(2, 2, false, |i, j| [radius - 1.0 + i as f64, j as f64])
            + &material(1.0, 0.3, 1.0, "*Elset, elset=ONE\n 1,\n")
            + "*Initial Conditions, type=STRESS\n SOLID, 1., -0.5, 0.25, 0.3\n"
            + &format!("*Step\n*Dynamic, Explicit, direct user control\n {:e}, {turns}\n", 1e-2)
            + "*Bulk Viscosity\n 0., 0.\n*Boundary, user\n ALL, 1, 2\n*Output, history, number interval=1\n\
               *Element Output, elset=ONE\n S, LE\n*End Step\n"
    };
    for turns in [0.25, 0.4, 1.0_f64] {
        let deck = deck(turns);
        let routines = Routines::none().with_motion(BlockRotation { middle: [radius, 0.5], rate: 2.0 * PI });
        let (outcome, memory) = common::run(&deck, &[], &routines);
        assert_eq!(outcome.halt, None);
        let prepared = common::prepared(&deck, &[], &routines);
        let value = |name: &str| {
            let at = prepared.plan.columns.iter().position(|c| c.name == format!("{name}@ONE")).expect("a column");
            memory.rows.last().expect("a row").1[at]
        };
        let (s, c) = (2.0 * PI * turns).sin_cos();
        let turned = [
            ("S11", c * c - 0.5 * s * s - 0.6 * s * c),
            ("S22", s * s - 0.5 * c * c + 0.6 * s * c),
            ("S33", 0.25),
            ("S12", 1.5 * s * c + 0.3 * (c * c - s * s)),
        ];
        for (name, expected) in turned {
            // A ring of this radius has a hoop strain of 1e-6, and coordinate differences have rounding of the same
            // size.
            assert!((value(name) - expected).abs() < 1e-5, "{turns}: {name} {} {expected}", value(name));
        }
        for name in ["LE11", "LE22", "LE12"] {
            assert!(value(name).abs() < 1e-5, "{turns}: {name} {}", value(name));
        }
    }
}

/// Simple shear to 4 with the Jaumann rate: shear stress G sin g, normal stresses -+ G (1 - cos g).
#[test]
fn large_simple_shear_matches_the_jaumann_rate() {
    let mut deck = grid(2, 2, false, |i, j| [1.0 + i as f64, j as f64])
        + &material(2.6, 0.3, 1.0, "*Elset, elset=ONE\n 1,\n*Nset, nset=FIRST, generate\n 1, 7, 3\n")
        + "*Nset, nset=SECOND, generate\n 2, 8, 3\n*Nset, nset=THIRD, generate\n 3, 9, 3\n\
           *Step\n*Dynamic, Explicit, direct user control\n 1.e-4, 4.\n*Bulk Viscosity\n 0., 0.\n*Boundary\n ALL, 1, 1\n\
           *Boundary, type=VELOCITY\n";
    for (set, v) in [("FIRST", 0.0), ("SECOND", 1.0), ("THIRD", 2.0)] {
        writeln!(deck, " {set}, 2, 2, {v}").expect("text");
    }
    deck += "*Output, history, number interval=8\n*Element Output, elset=ONE\n S\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    let [along, normal] = ["S12@ONE", "S22@ONE"].map(|name| column(&deck, &memory, name));
    for ((g, along), (_, normal)) in along.into_iter().zip(normal) {
        // G is 1. Strain increments are added half an increment after the rotation: an error of 1e-4.
        assert!((along - g.sin()).abs() < 3e-4, "S12 {along} at {g}");
        assert!((normal - (1.0 - g.cos())).abs() < 3e-4, "S22 {normal} at {g}");
    }
    assert!(last(&deck, &memory, "S33@ONE").abs() < 1e-12);
}

/// Aluminium bar with free sides, driven at 10 m/s: 136.6452 MPa at 5042.257 m/s.
#[test]
fn bar_wave_matches_closed_form() {
    let (rows, length, speed) = (300, 0.3, 10.0);
    let (first, second) = (1 + 2 * 75, 1 + 2 * 225);
    let deck = grid(2, rows, false, |i, j| [0.5e-3 * i as f64, length * j as f64 / rows as f64])
        + &material(68.9e9, 1.0 / 3.0, 2710.0, "")
        + &format!(
            "*Elset, elset=A\n {first},\n*Elset, elset=B\n {second},\n*Initial Conditions, type=VELOCITY\n J0, 2, {speed}\n"
        )
        + &format!("*Step\n*Dynamic, Explicit\n , 5.e-5\n*Boundary, type=VELOCITY\n J0, 2, 2, {speed}\n")
        + "*Output, history, time interval=2.e-8\n*Element Output, elset=A\n S22\n*Element Output, elset=B\n S22\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    assert!(outcome.energy.drift < 2e-3, "{:e}", outcome.energy.drift);
    let [a, b] = ["S22@A", "S22@B"].map(|name| column(&deck, &memory, name));
    let arrival = |gauge: &[(f64, f64)]| gauge.iter().find(|s| s.1 < -0.5 * 136.6452e6).expect("it comes").0;
    let velocity = 0.15 / (arrival(&b) - arrival(&a));
    // Stress after the front and before the reflection.
    let plateau: Vec<f64> = a.iter().filter(|s| (3e-5..5e-5).contains(&s.0)).map(|s| -s.1).collect();
    let stress = plateau.iter().sum::<f64>() / plateau.len() as f64;
    println!("bar wave: {velocity:.1} m/s, {:.3} MPa, drift {:.1e}", stress / 1e6, outcome.energy.drift);
    // The front widens with the cube root of the distance (Love), so its half height is slightly late at the second
    // gauge.
    assert!((velocity / 5042.257 - 1.0).abs() < 5e-3, "{velocity}");
    assert!((stress / 136.6452e6 - 1.0).abs() < 2e-3, "{stress}");
}
