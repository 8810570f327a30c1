//! Loads on faces of deformable elements.
//!
//! Goal: a user load acts as a pressure; a deformable body in a target decelerates like a rigid one, and frictional
//! work is reported in ALLFD.
//! Source: the built-in pressure; closed forms of the resistance. The tolerance and its reason are stated at each test.

use std::f64::consts::PI;

use revolve::user::{LoadFailure, LoadPoints, Routines, UserLoad};

use super::vessels::sphere;
use crate::common;
use crate::common::solid::{grid, last, material, run};

struct ConstantPressure;

impl UserLoad for ConstantPressure {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        // `normal_r` is the outward normal, `directions` point into the solid.
        let n = pressure.len();
        assert!(points.normal_r.iter().zip(&points.directions[..n]).all(|(a, b)| *a == -b));
        pressure.fill(100.0 * points.amplitude);
        Ok(())
    }
}

#[test]
fn user_load_on_faces_equals_pressure() {
    let deck = sphere(5, 10, 100.0, "");
    let user = deck.replace("I0, P, 100", "I0, PNU");
    let (a, _) = run(&deck);
    let (b, _) = common::run(&user, &[], &Routines::none().with_load(ConstantPressure));
    assert_eq!((a.halt, b.halt), (None, None));
    assert_eq!(a.energy.work.to_bits(), b.energy.work.to_bits());
}

/// A stiff deformable disc in a target without mesh has the velocity of a rigid one: closed form of m dV/dt = -pi a^2
/// (A Y + C rho V^2).
#[test]
fn deformable_disc_in_a_target_matches_rigid_closed_form() {
    let (a, thickness, density, v): (f64, f64, f64, f64) = (5.0, 5.0, 7.85e-9, 300e3);
    let deck = grid(6, 6, false, |i, j| [a * i as f64 / 6.0, thickness * j as f64 / 6.0])
        + &material(200e3, 0.3, density, "")
        + &format!(
            "*Material, name=ROCK\n*Density\n 2.7e-9,\n*Cavity Expansion, yield=100.\n 4., 0., 1.\n*Target, name=WALL, front=1., direction=-1\n ROCK, 900.\n\
             *Initial Conditions, type=VELOCITY\n ALL, 2, {:e}\n*Step\n*Dynamic, Explicit\n , 1.e-5\n*Dsload, target=WALL\n J0, CAVITY\n\
             *Output, history, number interval=10\n*Energy Output\n ALLKE\n*End Step\n",
            -v
        );
    let (outcome, memory) = run(&deck);
    assert!(outcome.halt.is_none(), "{:?}", outcome.halt);
    // m V' = -k0 - k2 V^2 with m/area = rho t.
    let (k0, k2, m): (f64, f64, f64) = (400.0, 2.7e-9, density * thickness);
    let root = (k0 * k2).sqrt();
    let start = (v * (k2 / k0).sqrt()).atan();
    let expected = (k0 / k2).sqrt() * (start - root / m * 1e-5).tan();
    // Mean speed from the kinetic energy; the disc vibrates slightly.
    let got = (2.0 * last(&deck, &memory, "ALLKE") / (PI * a * a * m)).sqrt();
    assert!((got - expected).abs() < 0.01 * (v - expected), "{got} {expected}");
    // No external work: the lost energy is the cavity work, except for the energy stored in the disc.
    let energy = outcome.energy;
    let lost = 0.5 * PI * a * a * m * (v * v - expected * expected);
    assert_eq!(energy.friction, 0.0);
    assert!(energy.work.abs() < 1e-6 * lost, "{energy:?}");
    assert!((energy.cavity / lost - 1.0).abs() < 0.01 && energy.drift < 2e-3, "{energy:?} {lost}");
}

/// A deformable cone is driven with prescribed velocity into a target with friction. The work of cavity and friction is
/// that of the pressure and of mu times the pressure on the sides, F_n V and F_t V with F_t / F_n = mu / tan(half
/// angle).
#[test]
fn friction_in_a_target_appears_as_frictional_work() {
    let (n, mu, v) = (8, 0.3, 300e3);
    // A frustum with a half angle of 45 degrees and unloaded flat faces.
    let deck = grid(n, n, false, |i, j| {
        let z = 10.0 * j as f64 / n as f64;
        [(2.0 + z) * i as f64 / n as f64, z]
    }) + &material(200e3, 0.3, 7.85e-9, "")
        + &format!(
            "*Material, name=ROCK\n*Density\n 2.7e-9,\n*Cavity Expansion, yield=100.\n 4., 0., 1.\n*Target, name=WALL, front=11., direction=-1\n ROCK, 900.\n\
             *Initial Conditions, type=VELOCITY\n ALL, 2, {:e}\n*Step\n*Dynamic, Explicit\n , 4.e-6\n*Dsload, target=WALL, friction={mu}\n I1, CAVITY\n\
             *Boundary, type=VELOCITY\n ALL, 2, 2, {:e}\n*Boundary\n ALL, 1, 1\n*Output, history, number interval=10\n*Energy Output\n ALLKE\n*End Step\n",
            -v, -v
        );
    let (outcome, _) = run(&deck);
    assert_eq!(outcome.halt, None);
    // Motion without deformation: sigma = 4 Y + rho (V/sqrt 2)^2 on the sides, whose projected area is pi (12^2 - 2^2).
    let sigma = 400.0 + 2.7e-9 * 0.5 * v * v;
    let cavity = sigma * PI * (144.0 - 4.0) * v * 4e-6;
    let energy = outcome.energy;
    println!("cone: ALLCAV {:e} of {cavity:e}, ALLFD over it {:.6}", energy.cavity, energy.friction / energy.cavity);
    assert!((energy.cavity / cavity - 1.0).abs() < 1e-6, "{energy:?} {cavity}");
    assert!((energy.friction / energy.cavity / mu - 1.0).abs() < 1e-6, "{energy:?}");
    // All work is done by the prescribed motion.
    assert!((energy.work / (energy.cavity + energy.friction) - 1.0).abs() < 1e-6 && energy.drift < 1e-6, "{energy:?}");
}

/// A table of a pressure has points every 1.6 stable increments: long and short increments by turns would excite vibrations of a column of
/// elements whose sides are held (174 times the energy put in). Its energy balance is closed to 1e-3 of the energy put in.
#[test]
fn points_of_a_table_do_not_excite_vibrations() {
    let pulse: String = (0..=40)
        .map(|i| format!(" {:e}, {:.9}\n", 2e-7 * f64::from(i), (PI * f64::from(i) / 40.0).sin().powi(2)))
        .collect();
    let deck = grid(1, 120, false, |i, j| [0.5 * i as f64, 0.5 * j as f64])
        + &material(30000.0, 0.2, 2.4e-9, &format!("*Amplitude, name=A\n{pulse}"))
        + "*Step\n*Dynamic, Explicit\n , 4.e-5\n*Boundary\n ALL, 1\n*Dsload, amplitude=A\n J0, P, 4.\n*End Step\n";
    let (outcome, _) = run(&deck);
    println!("{} increments, drift {:.1e}", outcome.increments, outcome.energy.drift);
    assert!(outcome.halt.is_none() && outcome.energy.drift < 1e-3, "{:?}", outcome.halt);
}
