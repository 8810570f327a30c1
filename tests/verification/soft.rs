//! Rubber, foam, explosives, and mass proportional damping.
//!
//! Goal: each law has the stress of its formula, also within a body.
//! Source: closed forms and quadrature, implemented independently here. The tolerance is stated at each test.

use std::f64::consts::PI;

use revolve::solve::Outcome;

use crate::common::RecordedOutput;
use crate::common::solid::{column, grid, last, run};

const HEAD: &str = "*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n";

fn assert_complete(name: &str, outcome: &Outcome, drift: f64) {
    assert_eq!(outcome.halt, None, "{name}");
    println!("{name}: {} increments, drift {:.1e}", outcome.increments, outcome.energy.drift);
    assert!(outcome.energy.drift < drift, "{name}: drift {:e}", outcome.energy.drift);
}

/// Returns the mean of a column over its last fifth, which averages the remaining vibration.
fn mean_of_last_fifth(text: &str, memory: &RecordedOutput, name: &str) -> f64 {
    let values = column(text, memory, name);
    let tail = &values[values.len() - values.len() / 5..];
    tail.iter().map(|v| v.1).sum::<f64>() / tail.len() as f64
}

/// Cauchy stress by principal stretches.
type StressFunction = fn([f64; 3]) -> [f64; 3];

/// Returns the stress from the derivatives of the energy by I1 and I2, as functions of (I1 - 3, I2 - 3), and the
/// pressure by J.
fn by_invariants(l: [f64; 3], slopes: impl Fn(f64, f64) -> [f64; 2], mean: impl Fn(f64) -> f64) -> [f64; 3] {
    let j = l[0] * l[1] * l[2];
    let b = l.map(|x| x * x * j.powf(-2.0 / 3.0));
    let (i1, i2) = (b[0] + b[1] + b[2], b[0] * b[1] + b[1] * b[2] + b[2] * b[0]);
    let [u1, u2] = slopes(i1 - 3.0, i2 - 3.0);
    // Deviator of (U1 + I1 U2) B - U2 B^2, times 2/J.
    let part = b.map(|x| (u1 + i1 * u2) * x - u2 * x * x);
    let third = (part[0] + part[1] + part[2]) / 3.0;
    part.map(|x| 2.0 / j * (x - third) + mean(j))
}

fn mooney(l: [f64; 3]) -> [f64; 3] {
    by_invariants(l, |_, _| [0.4, 0.1], |j| 20.0 * (j - 1.0))
}

fn mooney_by_default(l: [f64; 3]) -> [f64; 3] {
    by_invariants(l, |_, _| [0.4, 0.1], |j| 20.0 * 1.0 * (j - 1.0))
}

fn yeoh(l: [f64; 3]) -> [f64; 3] {
    let mean = |j: f64| 20.0 * (j - 1.0) + 4.0 / 0.2 * (j - 1.0).powi(3) + 6.0 / 0.3 * (j - 1.0).powi(5);
    by_invariants(l, |x, _| [0.5 - 2.0 * 0.02 * x + 3.0 * 0.004 * x * x, 0.0], mean)
}

fn second_order(l: [f64; 3]) -> [f64; 3] {
    let slopes = |x: f64, y: f64| [0.4 + 2.0 * 0.01 * x + 0.005 * y, 0.1 + 0.005 * x + 2.0 * 0.002 * y];
    by_invariants(l, slopes, |j| 20.0 * (j - 1.0))
}

fn ogden(l: [f64; 3]) -> [f64; 3] {
    let j = l[0] * l[1] * l[2];
    let mut stress = [20.0 * (j - 1.0); 3];
    for [mu, alpha] in [[0.8, 1.3], [0.05, 4.0], [-0.1, -2.0]] {
        let power = l.map(|x| (x * j.powf(-1.0 / 3.0)).powf(alpha));
        let third = (power[0] + power[1] + power[2]) / 3.0;
        for i in 0..3 {
            stress[i] += 2.0 * mu / (alpha * j) * (power[i] - third);
        }
    }
    stress
}

const FORMS: [(&str, StressFunction); 6] = [
    ("mooney-rivlin\n 0.4, 0.1, 0.1", mooney),
    ("mooney-rivlin\n 0.4, 0.1", mooney_by_default),
    ("yeoh\n 0.5, -0.02, 0.004, 0.1, 0.2, 0.3", yeoh),
    ("polynomial, n=2\n 0.4, 0.1, 0.01, 0.005, 0.002, 0.1, 0.", second_order),
    ("ogden, n=3\n 0.8, 1.3, 0.05, 4., -0.1, -2., 0.1, 0.\n 0.", ogden),
    ("reduced polynomial, n=3\n 0.5, -0.02, 0.004, 0.1, 0.2, 0.3", yeoh),
];

/// Stretches a block of rubber with inner radius `from` by a prescribed edge motion and returns stretches and stresses.
fn stretch_block(form: &str, from: f64, boundary: &str) -> ([f64; 3], [f64; 4]) {
    let deck = grid(1, 1, false, |i, j| [from + i as f64, j as f64])
        + HEAD
        + &format!(" 1.e-9,\n*Hyperelastic, {form}\n*Nset, nset=CORNER\n 4,\n")
        + "*Amplitude, name=A, definition=SMOOTH STEP\n 0., 0., 0.02, 1.\n*Step\n*Dynamic, Explicit\n , 0.02\n"
        + &format!("*Boundary\n J0, 2, 2\n{boundary}\n")
        + "*Output, history, number interval=20\n*Node Output, nset=CORNER\n U1, U2\n*Element Output, elset=SOLID\n \
           S11, S22, S33, S12\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert_complete(form, &outcome, 1e-3);
    let of = |name: &str| last(&deck, &memory, name);
    let [u, w] = ["U1@CORNER", "U2@CORNER"].map(of);
    let hoop = if from > 0.0 { 1.0 } else { 1.0 + u };
    ([1.0 + u, 1.0 + w, hoop], ["S11@SOLID", "S22@SOLID", "S33@SOLID", "S12@SOLID"].map(of))
}

/// Uniaxial tension to 2.5, compression to 0.5 and equibiaxial tension to 1.8: closed form at the computed stretches,
/// and zero stress in free directions. The deformation gradient is exact, so only rounding remains.
#[test]
fn hyperelastic_stresses_match_closed_forms() {
    for (form, law) in FORMS {
        for (boundary, equibiaxial) in [("J1, 2, 2, 1.5", false), ("J1, 2, 2, -0.5", false), ("I1, 1, 1, 0.8", true)] {
            let boundary = format!("*Boundary, amplitude=A\n {boundary}");
            let (stretches, stress) = stretch_block(form, 0.0, boundary.trim());
            let expected = law(stretches);
            println!("{form:?}: {stretches:.4?}: {stress:.5?} {expected:.5?}");
            for (got, expected) in stress.iter().zip([expected[0], expected[1], expected[2], 0.0]) {
                assert!((got - expected).abs() < 1e-8, "{form}: {got} {expected}");
            }
            let (free, held) = if equibiaxial { (stress[1], stress[0]) } else { (stress[0], stress[1]) };
            // The block vibrates slightly.
            assert!(free.abs() < 0.03 && held.abs() > 0.5, "{free} {held}");
        }
    }
}

/// Planar tension to 2 in a ring with a large radius and negligible hoop strain; the rounding of the radius 1e6
/// remains.
#[test]
fn hyperelastic_planar_tension_matches_closed_forms() {
    for (form, law) in FORMS {
        let (stretches, stress) = stretch_block(form, 1e6, "I0, 1, 1\n*Boundary, amplitude=A\n J1, 2, 2, 1.");
        let expected = law(stretches);
        println!("{form:?}: {stretches:.4?}: {stress:.5?} {expected:.5?}");
        for (got, expected) in stress.iter().zip([expected[0], expected[1], expected[2], 0.0]) {
            assert!((got - expected).abs() < 2e-5, "{form}: {got} {expected}");
        }
        assert!((stretches[1] - 2.0).abs() < 1e-12 && stress[0].abs() < 0.05 && stress[1] > 1.0);
    }
}

/// A ring of rubber in simple shear, with displacements along z of gamma (r - 1), to gamma = 3 and back to 0.5: the volume
/// is constant and the hoop stretch is 1, so that the energy is (C10 + C01) gamma^2 times the volume. The shear stress is linear in
/// gamma, and the trapezoidal rule of the work is exact: only rounding remains, although the material turns far.
#[test]
fn strain_energy_of_sheared_rubber_matches_its_closed_form() {
    for (form, constants) in [("neo hooke\n 0.5, 0.1", 0.5), ("mooney-rivlin\n 0.4, 0.3, 0.1", 0.7)] {
        let deck = grid(2, 2, false, |i, j| [1.0 + 0.5 * i as f64, 0.5 * j as f64])
            + HEAD
            + &format!(" 1.,\n*Hyperelastic, {form}\n*Nset, nset=MIDDLE, generate\n 2, 8, 3\n")
            + "*Amplitude, name=A\n 0., 0., 1., 3., 1.5, 0.5\n*Step\n*Dynamic, Explicit, direct user control\n 0.005, 1.5\n\
               *Boundary\n ALL, 1, 1\n I0, 2, 2\n*Boundary, amplitude=A\n MIDDLE, 2, 2, 0.5\n I1, 2, 2, 1.\n\
               *Output, history, number interval=3\n*Energy Output\n ALLSE, ALLAE\n*End Step\n";
        let (outcome, memory) = run(&deck);
        assert_eq!(outcome.halt, None);
        for ((time, energy), gamma) in column(&deck, &memory, "ALLSE").into_iter().zip([0.0, 1.5, 3.0, 0.5]) {
            let expected = constants * gamma * gamma * 3.0 * PI;
            println!("{form:?}: time {time}: {energy:e} {expected:e}");
            assert!((energy - expected).abs() < 1e-9, "{form:?}, time {time}: {energy} {expected}");
        }
    }
}

/// A thick Mooney-Rivlin sphere, A = 1 to B = 2, expanded by pressure and brought to rest by mass proportional damping.
/// For constant volume the pressure is the integral of 2 (s_hoop - s_r)/r over the wall; a bulk modulus of 1000 shear
/// moduli changes it by some thousandths.
#[test]
fn inflated_mooney_rivlin_sphere_matches_quadrature() {
    let (pressure, around) = (0.7, 16);
    let mut radii = Vec::new();
    for n in [4, 8] {
        let place = |i: usize, j: usize| {
            let (radius, angle) = (1.0 + i as f64 / n as f64, 0.5 * PI * j as f64 / around as f64);
            if j == around { [0.0, radius] } else { [radius * angle.cos(), radius * angle.sin()] }
        };
        let deck = grid(n, around, false, place)
            + HEAD
            + " 1.e-9,\n*Hyperelastic, mooney-rivlin\n 0.4, 0.1, 0.002\n*Damping, alpha=1.e4\n*Nset, nset=INNER\n 1,\n\
               *Amplitude, name=A, definition=SMOOTH STEP\n 0., 0., 1.e-3, 1., 1., 1.\n*Step\n*Dynamic, Explicit\n , 2.e-3\n\
               *Boundary\n J0, 2, 2\n J1, 1, 1\n"
            + &format!("*Dsload, amplitude=A\n I0, P, {pressure}\n")
            + "*Output, history, number interval=100\n*Node Output, nset=INNER\n U1\n*End Step\n";
        let (outcome, memory) = run(&deck);
        assert_complete("sphere", &outcome, 5e-3);
        radii.push(1.0 + mean_of_last_fifth(&deck, &memory, "U1@INNER"));
    }
    let pressed = |a: f64| {
        // Midpoints in the reference radius; r^3 = R^3 + a^3 - 1.
        let steps = 20_000;
        let part = |k: usize| {
            let big = 1.0 + (k as f64 + 0.5) / f64::from(20_000);
            let r = (big.powi(3) + a.powi(3) - 1.0).cbrt();
            let l = r / big;
            // s_hoop - s_r of the incompressible material.
            let apart = 2.0 * 0.4 * (l * l - l.powi(-4)) - 2.0 * 0.1 * (l.powi(-2) - l.powi(4));
            // dr = R^2/r^2 dR.
            2.0 * apart / r * (big / r).powi(2) / f64::from(20_000)
        };
        (0..steps).map(part).sum::<f64>()
    };
    let (mut low, mut high) = (1.0, 3.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if pressed(middle) < pressure { low = middle } else { high = middle }
    }
    let limit = radii[1] + (radii[1] - radii[0]) / 3.0;
    println!("sphere: inner radius {radii:.5?}, limit {limit:.5}, quadrature {low:.5}");
    assert!(low > 1.2, "{low}");
    assert!((radii[1] - low).abs() < (radii[0] - low).abs(), "{radii:?} {low}");
    assert!((limit / low - 1.0).abs() < 1e-3, "{limit} {low}");
}

/// Foam with E = 150 and no lateral strain; yield surface of the transport cask example.
const FOAM: &str = " 3.2e-10,\n*Elastic\n 150., 0.\n*Crushable Foam, hardening=VOLUMETRIC\n 1.1, 0.1\n*Crushable Foam Hardening\n \
                    6., 0.\n 7., 0.4\n 20., 0.8\n";

fn hardened_stress(p: f64) -> f64 {
    if p < 0.4 { 6.0 + 2.5 * p } else { 7.0 + 32.5 * (p - 0.4) }
}

/// Runs a foam cylinder small enough for negligible inertia whose edges follow an amplitude.
fn run_foam(foam: &str, boundary: &str, amplitude: &str) -> (String, Outcome, RecordedOutput) {
    let deck = grid(1, 1, false, |i, j| [1e-3 * i as f64, 1e-3 * j as f64])
        + HEAD
        + foam
        + &format!(
            "*Nset, nset=CORNER\n 4,\n*Amplitude, name=A\n {amplitude}\n*Step\n*Dynamic, Explicit\n , 1.e-4\n*Boundary\n J0, 2, 2\n\
             *Boundary, amplitude=A\n {boundary}\n*Output, history, number interval=200\n*Node Output, nset=CORNER\n U1, U2\n\
             *Element Output, elset=SOLID\n S11, S22, S33, PEEQ, PE11, PE22, PRESS\n*Energy Output\n ALLPD\n*End Step\n"
        );
    let (outcome, memory) = run(&deck);
    (deck, outcome, memory)
}

/// Uniaxial compression follows the table, unloading is elastic, and there is no lateral plastic strain.
#[test]
fn foam_compression_follows_its_table() {
    let (deck, outcome, memory) = run_foam(FOAM, "J1, 2, 2, -0.5e-3", "0., 0., 8.e-5, 1., 1.e-4, 0.97");
    assert_complete("foam", &outcome, 2e-3);
    let [stress, strain, side, lateral, along] =
        ["S22@SOLID", "PEEQ@SOLID", "S11@SOLID", "PE11@SOLID", "PE22@SOLID"].map(|n| column(&deck, &memory, n));
    let height = column(&deck, &memory, "U2@CORNER");
    let mut worst: f64 = 0.0;
    for k in 20..160 {
        let total = -(1.0 + height[k].1 / 1e-3).ln();
        // By hand: the stress of the elastic part is that of the table.
        let (mut low, mut high) = (0.0, total);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if 150.0 * (total - middle) > hardened_stress(middle) { low = middle } else { high = middle }
        }
        worst = worst.max((-stress[k].1 / hardened_stress(low) - 1.0).abs()).max((strain[k].1 / low - 1.0).abs());
        assert!(side[k].1.abs() < 0.02 && lateral[k].1.abs() < 2e-4, "{} {}", side[k].1, lateral[k].1);
        assert!((along[k].1 + strain[k].1).abs() < 1e-4, "{} {}", along[k].1, strain[k].1);
    }
    println!("foam: worst {worst:.1e}, crushed to {:.4}", strain[160].1);
    assert!(worst < 3e-3 && strain[160].1 > 0.5, "{worst} {}", strain[160].1);
    // After the reversal: Hooke's law over logarithmic strain, no further plastic strain.
    let (turn, end) = (164, 199);
    let [before, after] = [turn, end].map(|k: usize| (1.0 + height[k].1 / 1e-3).ln());
    let slope = (stress[end].1 - stress[turn].1) / (after - before);
    println!("foam: unloads with {slope:.3}");
    assert!((slope / 150.0 - 1.0).abs() < 5e-3 && strain[end].1 == strain[turn].1, "{slope}");
    // Plastic work by quadrature of the table; the volume decreases with the strain.
    let p = strain[end].1;
    let work = |k: i32| {
        let at = (f64::from(k) + 0.5) * p / 1000.0;
        hardened_stress(at) * (-(at + hardened_stress(at) / 150.0)).exp() * p / 1000.0
    };
    let expected = PI * 1e-9 * (0..1000).map(work).sum::<f64>();
    let dissipated = last(&deck, &memory, "ALLPD");
    println!("foam: dissipates {dissipated:e} of {expected:e}");
    assert!((dissipated / expected - 1.0).abs() < 5e-3);
}

/// Hydrostatic compression follows the pressure derived from the uniaxial table; hydrostatic tension is limited by the
/// specified strength.
#[test]
fn foam_hydrostatic_strengths_match_the_card() {
    let (k, kt) = (1.1, 0.1);
    let alpha2 = 9.0 * k * k / ((3.0 * kt + k) * (3.0 - k));
    let drawn = kt * 6.0 / k;
    let pressed = |v: f64| {
        let s = hardened_stress(v);
        s * (s * (1.0 / alpha2 + 1.0 / 9.0) + drawn / 3.0) / (drawn + s / 3.0)
    };
    assert!((pressed(0.0) - 6.0 / k).abs() < 1e-12);
    let (deck, outcome, memory) = run_foam(FOAM, "J1, 2, 2, -0.15e-3\n I1, 1, 1, -0.15e-3", "0., 0., 1.e-4, 1.");
    assert_complete("hydrostatic", &outcome, 2e-3);
    let [pressure, strain] = ["PRESS@SOLID", "PEEQ@SOLID"].map(|n| column(&deck, &memory, n));
    let flows = pressure.iter().zip(&strain).filter(|x| x.1.1 > 1e-3);
    let worst = flows.map(|(p, v)| (p.1 / pressed(v.1) - 1.0).abs()).fold(0.0, f64::max);
    println!("foam compressed: worst {worst:.1e}, to {:.4} at {:.4}", pressure[200].1, strain[200].1);
    // The state of each increment is on the yield surface to rounding.
    assert!(worst < 1e-9 && strain[200].1 > 0.3, "{worst} {}", strain[200].1);
    let (deck, outcome, memory) = run_foam(FOAM, "J1, 2, 2, 0.02e-3\n I1, 1, 1, 0.02e-3", "0., 0., 1.e-4, 1.");
    assert_complete("drawn", &outcome, 2e-3);
    let (pressure, strain) = (last(&deck, &memory, "PRESS@SOLID"), last(&deck, &memory, "PEEQ@SOLID"));
    println!("foam in tension: {pressure:.6} against {:.6}, {strain:.4}", -drawn);
    assert!((pressure / -drawn - 1.0).abs() < 1e-9 && strain < -0.03, "{pressure}");
}

/// Isotropic hardening: uniaxial compression follows the table, with the lateral flow of the plastic Poisson's ratio.
#[test]
fn isotropic_foam_has_lateral_flow() {
    let foam = FOAM.replace("hardening=VOLUMETRIC\n 1.1, 0.1", "hardening=ISOTROPIC\n 1.1, 0.2");
    let (deck, outcome, memory) = run_foam(&foam, "J1, 2, 2, -0.3e-3", "0., 0., 1.e-4, 1.");
    assert_complete("isotropic", &outcome, 2e-3);
    let [stress, strain, lateral, along] =
        ["S22@SOLID", "PEEQ@SOLID", "PE11@SOLID", "PE22@SOLID"].map(|n| last(&deck, &memory, n));
    println!("isotropic foam: {stress:.4} at {strain:.4}, lateral {lateral:.5} of {along:.5}");
    assert!(strain > 0.25 && (-stress / hardened_stress(strain) - 1.0).abs() < 3e-3, "{stress} {strain}");
    assert!((strain / -along - 1.0).abs() < 2e-3 && (lateral / along + 0.2).abs() < 2e-3, "{lateral} {along}");
}

/// The strain rate raises the yield stress by the table of ratios or the power law.
#[test]
fn foam_strength_increases_with_rate() {
    let rate = 0.3 / 1e-4;
    for (card, factor) in
        [(" 1.e5, 2.\n".into(), 1.0 + (rate / 1e5_f64).sqrt()), (format!("@ 1., 0.\n 2., {}\n", 2.0 * rate), 1.5)]
    {
        let kind = if card.starts_with('@') { ", type=YIELD RATIO" } else { "" };
        let foam = FOAM.to_owned() + &format!("*Rate Dependent{kind}\n{}", card.trim_start_matches('@'));
        // A constant logarithmic strain rate needs an exponentially decreasing height.
        let rows: Vec<String> = (0..=200)
            .map(|k| format!("{:e}, {:e}", f64::from(k) * 5e-7, (-0.3 * f64::from(k) / 200.0).exp_m1()))
            .collect();
        let amplitude: Vec<String> = rows.chunks(4).map(|c| c.join(", ")).collect();
        let (deck, outcome, memory) = run_foam(&foam, "J1, 2, 2, 1.e-3", &amplitude.join("\n "));
        assert_complete("rate", &outcome, 2e-3);
        let (stress, strain) =
            (mean_of_last_fifth(&deck, &memory, "S22@SOLID"), mean_of_last_fifth(&deck, &memory, "PEEQ@SOLID"));
        println!(
            "foam at a rate: {stress:.4} at {strain:.4}, factor {:.4} of {factor:.4}",
            -stress / hardened_stress(strain)
        );
        // The elastic strain is a small part.
        assert!((-stress / hardened_stress(strain) / factor - 1.0).abs() < 1e-2, "{stress} {strain}");
    }
}

/// Detonation speed of TNT; kg, m, s.
const SPEED: f64 = 6930.0;
const TNT: &str = " 1630.,\n*Eos, type=JWL\n 6930., 3.712E11, 3.231E9, 0.3, 4.15, 0.95, 4.29E6\n*Detonation Point\n";

/// Detonation products expanding to four times their volume follow the isentrope A e^(-R1 V) + B e^(-R2 V) + C V^-(1 +
/// omega).
#[test]
fn jwl_products_follow_the_isentrope() {
    let deck = grid(1, 1, false, |i, j| [1e-3 * i as f64, 1e-3 * j as f64])
        + HEAD
        + TNT
        + " 0., 0., 0., -1.\n*Amplitude, name=A, definition=SMOOTH STEP\n 0., 0., 1.e-3, 1.\n*Step\n*Dynamic, Explicit\n , 1.e-3\n\
           *Bulk Viscosity\n 0., 0.\n*Boundary\n ALL, 1, 1\n J0, 2, 2\n*Boundary, amplitude=A\n J1, 2, 2, 3.e-3\n\
           *Output, history, number interval=50\n*Node Output, nset=J1\n U2\n*Element Output, elset=SOLID\n PRESS, BURNF, SPECIFIC_ENERGY\n\
           *End Step\n";
    let (outcome, memory) = run(&deck);
    assert_complete("products", &outcome, 1e-3);
    let [a, b, r1, r2, omega, energy] = [3.712e11_f64, 3.231e9, 4.15, 0.95, 0.3, 1630.0 * 4.29e6];
    let c = omega * (energy - a / r1 * (-r1).exp() - b / r2 * (-r2).exp());
    let pressure = column(&deck, &memory, "PRESS@SOLID");
    let height = &memory.rows;
    let prepared = crate::common::prepared(&deck, &[], &revolve::user::Routines::none());
    let at = prepared.plan.columns.iter().position(|c| c.name.starts_with("U2@")).expect("U2");
    let mut worst: f64 = 0.0;
    for (row, p) in height.iter().zip(&pressure) {
        let v = 1.0 + row.1[at] / 1e-3;
        let expected = a * (-r1 * v).exp() + b * (-r2 * v).exp() + c * v.powf(-1.0 - omega);
        worst = worst.max((p.1 / expected - 1.0).abs());
    }
    println!("products: worst {worst:.1e} down to {:e}", pressure[50].1);
    assert_eq!(last(&deck, &memory, "BURNF@SOLID"), 1.0);
    assert!(worst < 1e-4, "{worst}");
}

/// Two detonation points with different times: each element burns from the arrival of the first detonation, over 2.5
/// elements.
#[test]
fn programmed_burn_follows_arrival_times() {
    let n = 20;
    let deck = grid(1, n, false, |i, j| [1e-3 * i as f64, 1e-3 * j as f64])
        + HEAD
        + TNT
        + " 0., 0.\n 0., 0.02, 0., 1.e-6\n*Step\n*Dynamic, Explicit\n , 1.7e-6\n*Boundary\n ALL, 1, 1\n J0, 2, 2\n J1, 2, 2\n\
           *Output, field, number interval=1\n*Element Output\n BURNF, PRESS\n*End Step\n";
    let (outcome, memory) = run(&deck);
    // With two dozen increments the trapezoidal work is coarse.
    assert_complete("detonation", &outcome, 2e-2);
    let frame = memory.frames.last().expect("a frame");
    let burnt = &frame.cell_fields.iter().find(|f| f.name == "BURNF").expect("BURNF").values;
    let mut seen = [0; 3];
    for (e, share) in burnt.iter().enumerate() {
        let z = 1e-3 * (e as f64 + 0.5);
        let lit = (0.5e-3_f64.hypot(z) / SPEED).min(1e-6 + 0.5e-3_f64.hypot(0.02 - z) / SPEED);
        let expected = ((1.7e-6 - lit) * SPEED / (2.5 * 1e-3)).clamp(0.0, 1.0);
        assert!((share - expected).abs() < 1e-9, "{e}: {share} {expected}");
        seen[if expected == 0.0 {
            0
        } else if expected < 1.0 {
            1
        } else {
            2
        }] += 1;
    }
    println!("detonation: {seen:?} elements wait, burn, have burnt");
    assert!(seen.iter().all(|count| *count > 1), "{seen:?}");
}

/// In a long column the peak pressure of a plane detonation approaches the Chapman-Jouguet pressure of 21.0 GPa from
/// below, because the burn extends over 2.5 elements. Both meshes are compared.
#[test]
fn plane_detonation_approaches_chapman_jouguet_pressure() {
    let peak = |n: usize| {
        let h = 0.1 / n as f64;
        let deck = grid(1, n, false, |i, j| [h * i as f64, h * j as f64])
            + HEAD
            + TNT
            + " 0., 0.\n*Step\n*Dynamic, Explicit\n , 1.3e-5\n*Boundary\n ALL, 1, 1\n J0, 2, 2\n*Output, field, number interval=1\n\
               *Element Output\n PRESS\n*End Step\n";
        let (outcome, memory) = run(&deck);
        assert_complete("plane detonation", &outcome, 1e-2);
        let frame = memory.frames.last().expect("a frame");
        let pressure = &frame.cell_fields.iter().find(|f| f.name == "PRESS").expect("PRESS").values;
        pressure.iter().copied().fold(0.0, f64::max)
    };
    let [coarse, fine] = [100, 200].map(peak);
    println!("plane detonation: {coarse:e} {fine:e}");
    assert!(coarse < fine && (fine / 21.0e9 - 1.0).abs() < 0.1, "{coarse:e} {fine:e}");
}

/// 20 mm of TNT on a rigid wall drive 4 mm of copper: Gurney velocity sqrt(2 E)/sqrt(M/C + 1/3) with sqrt(2 E) = 2.37
/// to 2.44 km/s (Kennedy 1970, UCID-15702); the model itself is accurate to some hundredths.
#[test]
fn flyer_reaches_the_gurney_velocity() {
    let (he, flyer) = (100, 20);
    let deck = grid(1, he + flyer, false, |i, j| [2e-4 * i as f64, 2e-4 * j as f64])
        .replace("elset=SOLID", "elset=ANY")
        + &format!(
            "*Elset, elset=SOLID, generate\n 1, {he}\n*Elset, elset=FLYER, generate\n {}, {}\n",
            he + 1,
            he + flyer
        )
        + HEAD
        + TNT
        + " 0., 0.\n*Solid Section, elset=FLYER, material=CU\n*Material, name=CU\n*Density\n 8930.,\n*Eos, type=USUP\n \
           3940., 1.489, 2.02\n*Elastic, type=SHEAR\n 47.7E9\n*Plastic\n 120.E6, 0.\n 450.E6, 1.\n*Step\n*Dynamic, Explicit\n , 4.e-5\n\
           *Boundary\n ALL, 1, 1\n J0, 2, 2\n*Output, history, number interval=40\n*Node Output, nset=J1\n V2\n*Energy Output\n \
           ETOTAL, ALLKE, ALLIE\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert_complete("flyer", &outcome, 2e-3);
    let prepared = crate::common::prepared(&deck, &[], &revolve::user::Routines::none());
    let at = prepared.plan.columns.iter().position(|c| c.name.starts_with("V2@")).expect("V2");
    let velocities: Vec<f64> = memory.rows.iter().map(|row| row.1[at]).collect();
    let tail = &velocities[30..];
    let velocity = tail.iter().sum::<f64>() / tail.len() as f64;
    let ratio = (8930.0 * 0.004) / (1630.0 * 0.02);
    let gurney = 2.405e3 / (ratio + 1.0_f64 / 3.0).sqrt();
    println!("flyer: {velocity:.0} m/s, Gurney {gurney:.0}");
    assert!((velocity / gurney - 1.0).abs() < 0.08, "{velocity} {gurney}");
}

/// A table of the linear Us-Up equation gives the same pressures as the equation, from tension to one third
/// compression, with heating.
#[test]
fn tabular_equation_of_state_matches_us_up() {
    let (rho, c0, s, gamma) = (2.785, 0.5328, 1.338, 2.0);
    let row = |k: i32| {
        let strain = 0.1 - 0.6 * f64::from(k) / 600.0;
        let eta = 1.0 - strain.exp();
        let cold = rho * c0 * c0 * eta * (1.0 - 0.5 * gamma * eta) / (1.0 - s * eta).powi(2);
        format!(" {cold:.12e}, {gamma}, {strain:.12e}\n")
    };
    let rows: String = (0..=600).map(row).collect();
    let pressure = |eos: &str| {
        let deck = grid(1, 1, false, |i, j| [0.01 * i as f64, 0.01 * j as f64])
            + HEAD
            + &format!(
                " {rho},\n*Eos, type={eos}*Amplitude, name=A\n 0., 0., 1., 0.05, 6., -0.3\n*Step\n*Dynamic, Explicit, direct user control\n 4.e-3, 6.\n"
            )
            + "*Boundary\n ALL, 1, 1\n J0, 2, 2\n*Boundary, amplitude=A\n J1, 2, 2, 0.01\n*Output, history, number interval=60\n\
               *Element Output, elset=SOLID\n PRESS, SPECIFIC_ENERGY\n*End Step\n";
        let (outcome, memory) = run(&deck);
        assert_complete("table", &outcome, 5e-2);
        ["PRESS@SOLID", "SPECIFIC_ENERGY@SOLID"].map(|n| column(&deck, &memory, n))
    };
    let [table, exact] = [format!("TABULAR\n{rows}"), format!("USUP\n {c0}, {s}, {gamma}\n")].map(|eos| pressure(&eos));
    for (table, exact) in table.iter().zip(&exact) {
        let most = exact.iter().map(|x| x.1.abs()).fold(0.0, f64::max);
        let worst = table.iter().zip(exact).map(|(t, e)| (t.1 - e.1).abs() / most).fold(0.0, f64::max);
        println!("table: worst {worst:.1e} of {most:e}");
        // Linear interpolation between 600 rows.
        assert!(worst < 1e-4, "{worst}");
    }
}

/// Runs a bar of one element with a fixed foot and no lateral motion, whose head starts with a small velocity.
fn vibrating_bar(alpha: f64, dt: f64, time: f64) -> (String, Outcome, RecordedOutput) {
    let control = if dt > 0.0 {
        format!(", direct user control\n {dt:e}, {time:e}")
    } else {
        format!(", element by element\n , {time:e}")
    };
    let deck = grid(1, 1, false, |i, j| [i as f64, j as f64])
        + HEAD
        + &format!(
            " 1.,\n*Elastic\n 1., 0.\n*Damping, alpha={alpha:e}\n*Initial Conditions, type=VELOCITY\n J1, 2, 1.e-6\n*Step\n*Dynamic, Explicit{control}\n\
             *Bulk Viscosity\n 0., 0.\n*Boundary\n ALL, 1, 1\n J0, 2, 2\n*Nset, nset=HEAD\n 3,\n*Output, history, frequency=1\n\
             *Node Output, nset=HEAD\n U2\n*Energy Output\n ALLKE, ALLIE, ALLVD, ETOTAL\n*End Step\n"
        );
    let (outcome, memory) = run(&deck);
    (deck, outcome, memory)
}

/// Half of the mass 1 vibrates on the stiffness 1 (without lateral strain): omega = sqrt(2). The damping force uses the
/// velocity of half an increment before, so the error is of first order; the dissipated energy is in ALLVD.
#[test]
fn mass_proportional_damping_matches_its_decrement() {
    let (alpha, time, omega): (f64, f64, f64) = (0.4, 16.0, 2.0_f64.sqrt());
    let damped = (omega * omega - 0.25 * alpha * alpha).sqrt();
    let exact = |t: f64| 1e-6 / damped * (-0.5 * alpha * t).exp() * (damped * t).sin();
    let mut errors = Vec::new();
    for dt in [0.04, 0.02, 0.01] {
        let (deck, outcome, memory) = vibrating_bar(alpha, dt, time);
        assert_complete("damped", &outcome, 1e-9);
        let motion = column(&deck, &memory, "U2@HEAD");
        errors.push(motion.iter().map(|u| (u.1 - exact(u.0)).abs()).fold(0.0, f64::max) * damped / 1e-6);
        let energy = outcome.energy;
        let lost = 0.25 * PI * 1e-12;
        assert!((energy.viscous + energy.kinetic + energy.internal - lost).abs() < 1e-3 * lost, "{energy:?} {lost}");
    }
    let orders: Vec<f64> = errors.windows(2).map(|w| (w[0] / w[1]).log2()).collect();
    println!("damped: errors {errors:?}, orders {orders:.3?}");
    assert!(orders.iter().all(|o| (o - 1.0).abs() < 0.1), "{orders:?}");
    assert!(errors[2] < 3e-3, "{errors:?}");
}

/// Damping reduces the stable increment by the factor sqrt(1 + xi^2) - xi with xi = alpha/2 omega; alpha = 0 changes
/// nothing.
#[test]
fn damping_reduces_the_stable_increment() {
    let [(_, free, plain), (_, none, same), (_, damped, _)] =
        [0.0, 0.0, 2.0].map(|alpha| vibrating_bar(alpha, 0.0, 16.0));
    let without = vibrating_bar(0.0, 0.0, 16.0);
    let undamped = without.0.replace("*Damping, alpha=0e0\n", "");
    assert!(undamped != without.0);
    let (_, undamped_rows) = run(&undamped);
    assert!(plain.rows == same.rows && undamped_rows.rows == plain.rows && free.increments == none.increments);
    let [free, damped] = [&free, &damped].map(|o| o.steps[0].largest_increment);
    let xi = 2.0 / (2.0 * (2.0 / free));
    let expected = (1.0 + xi * xi).sqrt() - xi;
    // The last increment may be longer by a thousandth.
    println!("damped increment: {:.6} of the free one, {expected:.6}", damped / free);
    assert!(expected < 0.9 && (damped / free / expected - 1.0).abs() < 2e-3, "{damped} {free}");
}
