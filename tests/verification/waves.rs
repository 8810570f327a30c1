//! Elastic waves and vibrations.
//!
//! Goal: stress and speed of a plane wave; an undamped bar conserves energy over a million increments.
//! Source: closed forms of elasticity. The tolerance and its reason are stated at each test.

use crate::common::solid::{column, grid, last, material, run};

/// Uniaxial strain with motion along z only: stress after the front, and speed of the front.
#[test]
fn strain_wave_matches_closed_form() {
    let (e, nu, rho, v) = (68.9e9, 1.0 / 3.0, 2710.0, 10.0);
    let m = 200;
    let deck = grid(2, m, false, |i, j| [i as f64 * 5e-3, j as f64 * 5e-3])
        + &material(e, nu, rho, "")
        + &format!(
            "*Elset, elset=MIDDLE\n 101,\n*Step\n*Dynamic, Explicit\n , 1.2e-4\n*Boundary\n ALL, 1, 1\n*Boundary, type=VELOCITY\n \
             J0, 2, 2, {v}\n*Output, history, time interval=2.5e-7\n*Element Output, elset=MIDDLE\n S22, S11\n*Energy Output\n ALLKE\n*End Step\n"
        );
    let (outcome, memory) = run(&deck);
    assert!(outcome.halt.is_none());
    // c_L = 6175.478 m/s, stress 167.3555 MPa, lateral stress nu/(1 - nu) times that.
    let stress = column(&deck, &memory, "S22@MIDDLE");
    let plateau: Vec<f64> =
        stress.iter().filter(|s| (1.0e-4..1.15e-4).contains(&s.0)).map(|s| -s.1 / 167.3555e6).collect();
    let mean = plateau.iter().sum::<f64>() / plateau.len() as f64;
    assert!((mean - 1.0).abs() < 5e-3, "plateau {mean}");
    let arrival = stress.iter().find(|s| -s.1 > 0.5 * 167.3555e6).expect("a front").0;
    let expected = 50.5 * 5e-3 / 6175.478;
    assert!((arrival - expected).abs() < 1e-6, "front at {arrival:e}, expected {expected:e}");
    let lateral = last(&deck, &memory, "S11@MIDDLE") / last(&deck, &memory, "S22@MIDDLE");
    assert!((lateral / 0.5 - 1.0).abs() < 1e-6, "{lateral}");
    assert!(outcome.energy.drift < 2e-3, "{}", outcome.energy.drift);
}

/// Energy of an undamped elastic bar over a million increments. The motion is small enough to be linear: changes of
/// geometry affect the balance in proportion to the strain, 1e-11.
#[test]
fn undamped_elastic_bar_conserves_energy() {
    let mut deck = grid(2, 4, false, |i, j| [i as f64, j as f64]) + &material(1.0, 0.3, 1.0, "");
    deck += "*Initial Conditions, type=VELOCITY\n J1, 2, 1.e-11\n";
    deck += "*Step\n*Dynamic, Explicit, direct user control\n 0.2, 200000.\n*Bulk Viscosity\n 0., 0.\n*Boundary\n J0, 2, 2\n\
             *Output, history, number interval=1000\n*Energy Output\n ALLKE, ALLIE, ETOTAL\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert_eq!((outcome.halt, outcome.increments), (None, 1_000_000));
    let internal = column(&deck, &memory, "ALLIE");
    assert!(internal.iter().any(|e| e.1 > 0.1 * outcome.energy.initial), "no exchange of kinetic and internal energy");
    println!("elastic bar, 1e6 increments: drift {:.1e}", outcome.energy.drift);
    assert!(outcome.energy.drift < 1e-10, "{:e}", outcome.energy.drift);
}
