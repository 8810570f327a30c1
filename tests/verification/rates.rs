//! Rate- and temperature-dependent laws on single elements, compared with the laws evaluated by hand.
//!
//! Goal: kinematic hardening by rate and temperature, failure strains by rate, pressure and temperature, and tabular
//! dashpots agree with their definitions.
//! Source: one-dimensional return mapping and ordinary differential equations, integrated here. The tolerance is stated
//! at each test.

use std::f64::consts::PI;

use revolve::solve::Outcome;

use crate::common::RecordedOutput;
use crate::common::solid::{column, grid, last, material, run};

/// Returns a cylinder small enough for negligible inertia, whose top is displaced by `displacement` times an amplitude.
fn cylinder(cards: &str, amplitude: &str, displacement: f64, time: f64) -> String {
    grid(1, 1, false, |i, j| [1e-3 * i as f64, 1e-3 * j as f64])
        + &material(200e3, 0.3, 7.85e-9, cards)
        + &format!(
            "*Amplitude, name=A\n {amplitude}\n*Initial Conditions, type=TEMPERATURE\n ALL, 20.\n\
             *Step\n*Dynamic, Explicit, adiabatic\n , {time:e}\n*Boundary\n J0, 2, 2\n\
             *Boundary, amplitude=A\n J1, 2, 2, {displacement:e}\n*Output, history, number interval=400\n\
             *Element Output, elset=SOLID\n S22, PEEQ, TEMP\n*Node Output, nset=J1\n U2\n*End Step\n"
        )
}

fn run_complete(deck: &str) -> (Outcome, RecordedOutput) {
    let (outcome, memory) = run(deck);
    assert_eq!(outcome.halt, None);
    // The energy balance closes within 0.2 % of the work.
    assert!(outcome.energy.drift < 2e-3, "drift {:e}", outcome.energy.drift);
    (outcome, memory)
}

/// Kinematic hardening with the rate factor 1 + (rate/D)^(1/n), in tension, compression and tension.
#[test]
fn kinematic_hardening_with_rate_matches_return_mapping() {
    let (young, radius, slope) = (200e3, 300.0, 5000.0);
    let cards = "*Plastic, hardening=KINEMATIC\n 300., 0.\n 800., 0.1\n*Rate Dependent\n 4.e4, 5.\n";
    let deck = cylinder(cards, "0., 0., 1.e-5, 1., 3.e-5, -1., 5.e-5, 1.", 2e-5, 5e-5);
    let (_, memory) = run_complete(&deck);
    let (motion, stress) = (column(&deck, &memory, "U2@3"), column(&deck, &memory, "S22@SOLID"));
    let (mut plastic, mut before, mut worst) = (0.0, (0.0, 0.0), 0.0_f64);
    for (u, found) in motion.iter().zip(&stress) {
        let (time, strain) = (u.0, (1.0 + u.1 / 1e-3).ln());
        for k in 1..=20 {
            let here = before.1 + (strain - before.1) * f64::from(k) / 20.0;
            let dt = (time - before.0) / 20.0;
            let relative: f64 = young * (here - plastic) - slope * plastic;
            let left = |dp: f64| relative.abs() - (young + slope) * dp - radius * (1.0 + (dp / dt / 4e4).powf(0.2));
            if dt > 0.0 && left(0.0) > 0.0 {
                let (mut low, mut high) = (0.0, relative.abs() / young);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if left(middle) > 0.0 { low = middle } else { high = middle }
                }
                plastic += relative.signum() * low;
            }
        }
        before = (time, strain);
        worst = worst.max((found.1 - young * (strain - plastic)).abs());
    }
    println!("kinematic with rate: worst {worst:.2} MPa");
    // The bar vibrates slightly, and reversals occur between rows.
    assert!(worst < 6.0, "{worst}");
}

const WARM: &str =
    "*Plastic, hardening=KINEMATIC\n 400., 0., 20.\n 800., 0.1, 20.\n 200., 0., 220.\n 300., 0.1, 220.\n";

/// Yield stress and hardening slope are linear between two temperatures.
#[test]
fn kinematic_hardening_is_linear_between_temperatures() {
    let deck = cylinder(WARM, "0., 0., 1.e-5, 1.", 5e-5, 1e-5).replace("ALL, 20.", "ALL, 120.");
    let (_, memory) = run_complete(&deck);
    let (stress, strain) = (last(&deck, &memory, "S22@SOLID"), last(&deck, &memory, "PEEQ@SOLID"));
    let expected = 300.0 + 2500.0 * strain;
    println!("kinematic at 120 degrees: {stress:.3} against {expected:.3}");
    assert!(strain > 0.04 && (stress / expected - 1.0).abs() < 2e-3, "{stress} {expected}");
}

/// Heated by plastic work, with a back stress that follows C(T): the stress is s0(T) + C(T) p, and dT = k s dp.
#[test]
fn kinematic_hardening_with_heating_matches_quadrature() {
    let cards = format!("{WARM}*Inelastic Heat Fraction\n 0.9,\n*Specific Heat\n 2.e7,\n");
    let deck = cylinder(&cards, "0., 0., 1.e-5, 1.", 5e-5, 1e-5);
    let (_, memory) = run_complete(&deck);
    let [stress, strain, temperature] =
        ["S22@SOLID", "PEEQ@SOLID", "TEMP@SOLID"].map(|name| last(&deck, &memory, name));
    let at = |p: f64, t: f64| (400.0 - (t - 20.0)) + (4000.0 - 15.0 * (t - 20.0)) * p;
    let (steps, mut t) = (10_000, 20.0);
    let (dp, k) = (strain / f64::from(steps), 0.9 / (7.85e-9 * 2e7));
    for i in 0..steps {
        let p = dp * f64::from(i);
        let middle = t + 0.5 * dp * k * at(p, t);
        t += dp * k * at(p + 0.5 * dp, middle);
    }
    println!(
        "kinematic with heat: {temperature:.2} against {t:.2} degrees, {stress:.2} against {:.2} MPa",
        at(strain, t)
    );
    assert!(t > 100.0 && ((temperature - 20.0) / (t - 20.0) - 1.0).abs() < 5e-3, "{temperature} {t}");
    assert!((stress / at(strain, t) - 1.0).abs() < 5e-3, "{stress} {}", at(strain, t));
}

/// Returns the failure strain of a perfectly plastic cylinder whose end moves at constant velocity; the strain rate is
/// 2e4 exp(-p).
fn failure_strain(cards: &str, temperature: f64) -> f64 {
    let deck = cylinder(&format!("*Plastic\n 400., 0.\n{cards}"), "0., 0., 1.e-5, 1.", 2e-4, 1e-5)
        .replace("ALL, 20.", &format!("ALL, {temperature}"));
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    assert_eq!(last(&deck, &memory, "S22@SOLID"), 0.0);
    last(&deck, &memory, "PEEQ@SOLID")
}

/// Returns the strain at which the integral of dp over the rate-dependent failure strain reaches 1.
fn expected_failure_strain(at: impl Fn(f64) -> f64) -> f64 {
    let (mut p, mut sum, dp) = (0.0_f64, 0.0, 1e-6);
    while sum < 1.0 {
        sum += dp / at(2e4 * (-p).exp());
        p += dp;
    }
    p
}

/// Failure strains by triaxiality (1/3 in tension) or its negative, rate and temperature.
#[test]
fn failure_strain_depends_on_rate_and_temperature() {
    // 0.05 + rate/4e5 at triaxiality 0 and 20 degrees; half as much at 2/3; twice as much at 220 degrees.
    let f = |x: f64, rate: f64, t: f64| (0.05 + rate / 4e5) * (1.0 - 0.75 * x) * (1.0 + (t - 20.0) / 200.0);
    let mut ductile = String::from("*Damage Initiation, criterion=DUCTILE\n");
    let mut shear = String::from("*Shear Failure\n");
    for t in [20.0, 220.0] {
        for rate in [0.0, 4e4] {
            for x in [0.0, 2.0 / 3.0] {
                ductile += &format!(" {:.12}, {x:.12}, {rate}, {t}\n", f(x, rate, t));
            }
        }
        for ratio in [-2.0 / 3.0, 0.0] {
            for rate in [0.0, 4e4] {
                shear += &format!(" {:.12}, {rate}, {ratio:.12}, {t}\n", f(-ratio, rate, t));
            }
        }
    }
    ductile += "*Damage Evolution, type=DISPLACEMENT\n 0.,\n";
    for t in [20.0_f64, 120.0, 300.0] {
        let wanted = expected_failure_strain(|rate| f(1.0 / 3.0, rate, t.min(220.0)));
        for (name, cards) in [("ductile", &ductile), ("shear", &shear)] {
            let found = failure_strain(cards, t);
            println!("{name} at {t} degrees: fails at {found:.5}, expected {wanted:.5}");
            // The cylinder vibrates slightly, which changes the rate.
            assert!((found / wanted - 1.0).abs() < 5e-3, "{name} {t}: {found} {wanted}");
        }
    }
}

/// A block on a dashpot with a tabular force: m v' = -F(v), and the lost energy is dissipated.
#[test]
fn tabular_dashpot_decelerates_a_block() {
    let rows = [[-2.0, -3.0], [-1.0, -1.0], [0.0, 0.0], [1.0, 0.5], [2.0, 2.0]];
    let force = |v: f64| {
        let i = rows.partition_point(|r| r[0] <= v).clamp(1, rows.len() - 1);
        let ([a, f], [b, g]) = (rows[i - 1], rows[i]);
        // Constant force beyond the ends of the table.
        f + (g - f) * (v.clamp(rows[0][0], rows[4][0]) - a) / (b - a)
    };
    let table: String = rows.iter().map(|[v, f]| format!(" {f}, {v}\n")).collect();
    for start in [2.6_f64, -2.6] {
        let deck = grid(2, 2, false, |i, j| [0.5 * i as f64, 2.0 + 0.25 * j as f64])
            + "*Element, type=DASHPOT1, elset=C\n 102, 1\n"
            + &format!(
                "*Dashpot, elset=C, nonlinear\n 2\n{table}*Initial Conditions, type=VELOCITY\n ALL, 2, {start}\n"
            )
            + &material(1e5, 0.0, 1.0, "*Nset, nset=ONE\n 1\n")
            + "*Step\n*Dynamic, Explicit\n , 3.\n*Bulk Viscosity\n 0., 0.\n*Output, history, number interval=10\n\
               *Energy Output\n ALLKE, ALLVD\n*End Step\n";
        let (outcome, memory) = run_complete(&deck);
        let (steps, mut v) = (100_000, start);
        let h = 3.0 / f64::from(steps) / (0.5 * PI);
        for _ in 0..steps {
            let middle = v - 0.5 * h * force(v);
            v -= h * force(middle);
        }
        let found = (2.0 * last(&deck, &memory, "ALLKE") / (0.5 * PI)).sqrt();
        let lost = 0.25 * PI * (start * start - v * v);
        let viscous = last(&deck, &memory, "ALLVD");
        println!("dashpot from {start}: {found:.5} against {:.5}, dissipated {viscous:.5} of {lost:.5}", v.abs());
        // The block deforms where the dashpot is attached.
        assert!((found - v.abs()).abs() < 2e-3 * start.abs(), "{found} {v}");
        assert!((viscous / lost - 1.0).abs() < 2e-3, "{viscous} {lost}");
        assert!(outcome.increments > 1000);
    }
}
