//! Pressure vessels.
//!
//! Goal: displacements of elastic and plastic thick spheres and cylinders, and their order in the mesh.
//! Source: closed forms (Lame; Hill 1950). The tolerance and its reason are stated at each test.

use std::f64::consts::PI;

use crate::common::RecordedOutput;
use crate::common::solid::{column, grid, material, run};

/// Returns a quarter section of a thick sphere from a = 10 to b = 20 mm under slowly increasing internal pressure.
pub fn sphere(radial: usize, around: usize, pressure: f64, plastic: &str) -> String {
    let place = |i: usize, j: usize| {
        let radius = 10.0 * (1.0 + i as f64 / radial as f64);
        let angle = 0.5 * PI * j as f64 / around as f64;
        let [r, z] = [radius * angle.cos(), radius * angle.sin()];
        // Nodes of the last ray have r = 0 exactly.
        if j == around { [0.0, radius] } else { [r, z] }
    };
    grid(radial, around, false, place)
        + &material(200e3, 0.3, 7.85e-9, plastic)
        + "*Amplitude, name=RAMP, definition=SMOOTH STEP\n 0., 0., 3.e-4, 1.\n*Nset, nset=INNER\n 1,\n"
        + &format!("*Nset, nset=OUTER\n {},\n", radial + 1)
        + "*Step\n*Dynamic, Explicit\n , 4.e-4\n*Boundary\n J0, 2, 2\n"
        + &format!("*Dsload, amplitude=RAMP\n I0, P, {pressure}\n")
        + "*Output, history, number interval=100\n*Node Output, nset=INNER\n U1\n*Node Output, nset=OUTER\n U1\n*Energy Output\n ALLKE\n*End Step\n"
}

/// Returns the mean of a column over its last fifth, which averages the remaining vibration.
pub fn mean_of_last_fifth(text: &str, memory: &RecordedOutput, name: &str) -> f64 {
    let values = column(text, memory, name);
    let tail = &values[values.len() - values.len() / 5..];
    tail.iter().map(|v| v.1).sum::<f64>() / tail.len() as f64
}

#[test]
fn thick_sphere_converges_to_lame_with_second_order() {
    let mut errors = Vec::new();
    for n in [5, 10, 20] {
        let deck = sphere(n, 2 * n, 1.0, "");
        let (outcome, memory) = run(&deck);
        assert!(outcome.halt.is_none(), "{:?}", outcome.halt);
        assert!(outcome.energy.drift < 2e-3, "{}", outcome.energy.drift);
        // u(a) = 4.000 um and u(b) = 1.5 um at 100 MPa; the pressure is 1 MPa because the closed form assumes small
        // strains.
        errors.push([
            mean_of_last_fifth(&deck, &memory, "U1@INNER") / 4e-5 - 1.0,
            mean_of_last_fifth(&deck, &memory, "U1@OUTER") / 1.5e-5 - 1.0,
        ]);
    }
    let order = (errors[1][0] / errors[2][0]).abs().log2();
    println!("Lame sphere: errors {errors:?}, order {order:.2}");
    assert!((order - 2.0).abs() < 0.3, "order {order}: {errors:?}");
    assert!(errors[2].iter().all(|e| e.abs() < 3e-3), "{errors:?}");
}

/// Hill's sphere, perfectly plastic: plastic front at c = 15 mm for p = 358.90406 MPa, outer displacement 8.859375 um.
#[test]
fn hill_sphere_matches_closed_form() {
    // Stiffness and density times 100: the same wave speeds and stresses, and strains as small as the theory assumes.
    let deck = sphere(20, 30, 358.90406, "*Plastic\n 300., 0.\n")
        .replace("2e5, 0.3", "2e7, 0.3")
        .replace("7.85e-9", "7.85e-7");
    assert!(deck.contains("2e7, 0.3") && deck.contains("7.85e-7"));
    let (outcome, memory) = run(&deck);
    assert!(outcome.halt.is_none());
    let outer = mean_of_last_fifth(&deck, &memory, "U1@OUTER");
    println!("Hill sphere: u(b) = {:.4} um (8.8594)", outer * 1e5);
    // On a mesh of h = 0.5 mm the front is resolved to half an element, and u(b) is proportional to c^3.
    assert!((outer / 8.859375e-5 - 1.0).abs() < 1e-2, "{outer}");
}

/// Thick cylinder in plane strain, a = 10 and b = 20 mm: u(a) = 9.53333 um at 100 MPa. The pressure is 1 MPa because
/// the closed form assumes small strains.
#[test]
fn thick_cylinder_matches_lame_on_every_mesh() {
    let mut errors = Vec::new();
    for n in [10, 20] {
        let deck = grid(n, 1, false, |i, j| [10.0 + 10.0 * i as f64 / n as f64, j as f64])
            + &material(200e3, 0.3, 7.85e-9, "")
            + "*Amplitude, name=RAMP, definition=SMOOTH STEP\n 0., 0., 3.e-4, 1.\n*Nset, nset=INNER\n 1,\n*Step\n*Dynamic, Explicit\n , 4.e-4\n\
               *Boundary\n ALL, 2, 2\n*Dsload, amplitude=RAMP\n I0, P, 1.\n*Output, history, number interval=100\n*Node Output, nset=INNER\n U1\n*End Step\n";
        let (outcome, memory) = run(&deck);
        assert!(outcome.halt.is_none());
        errors.push(mean_of_last_fifth(&deck, &memory, "U1@INNER") / 9.53333e-5 - 1.0);
    }
    println!("Lame cylinder: errors {errors:?}");
    // Mean quadrature reproduces this solution, A r + B/r, at the nodes of any mesh; the rest is the strain of 1e-5.
    assert!(errors.iter().all(|e| e.abs() < 3e-5), "{errors:?}");
}
