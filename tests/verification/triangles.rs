//! Nearly incompressible three-node triangles: averaging the pressure over nodes prevents locking.
//!
//! Sources: Hill 1950, The Mathematical Theory of Plasticity, chapter V (fully plastic sphere); the same bar with
//! quadrilaterals.

use std::f64::consts::PI;
use std::fmt::Write as _;

use crate::common::solid::{column, copper_bar, grid, last, material, run};
use crate::common::spheres;

/// Returns the pressure over 2 Y ln(b/a) in a fully plastic thick sphere from 1 to 2 whose wall moves outward by 3 %;
/// triangles with one diagonal direction, Poisson's ratio 0.4999.
fn pressure_of_sphere(n: usize, controls: &str) -> f64 {
    let (m, out) = (2 * n, 0.03);
    let place = |i: usize, j: usize| {
        let (radius, angle) = (1.0 + i as f64 / n as f64, 0.5 * PI * j as f64 / m as f64);
        if j == m { [0.0, radius] } else { [radius * angle.cos(), radius * angle.sin()] }
    };
    let node = |i: usize, j: usize| 1 + i + j * (n + 1);
    let mut deck = grid(n, m, true, place);
    write!(deck, "*Nset, nset=J0, generate\n 1, {}, 1\n", n + 1).expect("text");
    write!(deck, "*Nset, nset=J1, generate\n {}, {}, 1\n", node(0, m), node(n, m)).expect("text");
    deck += &material(1000.0, 0.4999, 1.0, "*Plastic\n 1., 0.\n").replace("material=M\n", controls);
    deck += "*Amplitude, name=A, definition=smooth step\n 0., 0., 20., 1.\n*Step\n*Dynamic, Explicit\n , 20.\n";
    deck += "*Boundary\n J0, 2, 2\n J1, 1, 1\n*Boundary, amplitude=A\n";
    for j in 0..=m {
        let [r, z] = place(0, j).map(|x| out * x);
        if j < m {
            writeln!(deck, " {}, 1, 1, {r:e}", node(0, j)).expect("text");
        }
        if j > 0 {
            writeln!(deck, " {}, 2, 2, {z:e}", node(0, j)).expect("text");
        }
    }
    deck += "*Output, history, number interval=2\n*Energy Output\n ALLWK\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    // Work of the wall over the second half of its displacement, on the upper half of the sphere.
    let work = column(&deck, &memory, "ALLWK");
    let [middle, end] = [0.5 * out, out].map(|u| 1.0 + u);
    let volume = 2.0 / 3.0 * PI * (end.powi(3) - middle.powi(3));
    let of_limit = |a: f64| 2.0 * ((7.0 + a.powi(3)).cbrt() / a).ln();
    let ratio = (work[2].1 - work[1].1) / volume / (0.5 * (of_limit(middle) + of_limit(end)));
    println!("sphere of triangles, {controls:?}: {ratio:.4} of the limit load, drift {:.1e}", outcome.energy.drift);
    assert!(outcome.energy.drift < 1e-3, "{:e}", outcome.energy.drift);
    ratio
}

#[test]
fn plastic_sphere_of_triangles_does_not_lock() {
    let averaged = [5, 8].map(|n| pressure_of_sphere(n, "material=M\n") - 1.0);
    let plain = pressure_of_sphere(5, "material=M, controls=C\n*Section Controls, name=C, averaged pressure=NO\n");
    // The error decreases with the mesh; without averaging the load is many times larger.
    assert!(averaged[0].abs() < 0.1 && averaged[1].abs() < 0.8 * averaged[0].abs(), "{averaged:?}");
    assert!(plain > 2.0, "{plain}");
}

/// Returns length and foot radius in mm of the copper bar at 227 m/s after 80 microseconds.
fn run_bar(triangles: bool) -> [f64; 2] {
    let (n, m) = (10, 50);
    let deck = copper_bar([n, m], triangles, spheres::EVEN);
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    let found = ["COOR2@TIP", "COOR1@RIM"].map(|name| last(&deck, &memory, name));
    println!("bar, triangles {triangles}: {found:?}, drift {:.1e}", outcome.energy.drift);
    found
}

/// One diagonal direction is the least favourable division of quadrilaterals.
#[test]
fn taylor_bar_of_triangles_matches_quadrilaterals() {
    let [quads, triangles] = [false, true].map(run_bar);
    for (q, t) in quads.iter().zip(triangles) {
        assert!((t / q - 1.0).abs() < 0.03, "{quads:?} {triangles:?}");
    }
}
