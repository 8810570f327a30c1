//! Models without elements of a mesh: masses, springs and dashpots, and rigid bodies that they join.
//!
//! Goal: the motions, frequencies and energies of oscillators, and the limit of stability.
//! Source: closed forms. Automatic increments have a relative error of about ACCURACY, by default 1e-4.

use std::f64::consts::PI;

use crate::common::solid::{column, grid, last, material, run};

/// Returns the mean period between rising zero crossings, found by linear interpolation.
fn period(history: &[(f64, f64)]) -> f64 {
    let rising = history.windows(2).filter(|w| w[0].1 < 0.0 && w[1].1 >= 0.0);
    let zeros: Vec<f64> = rising.map(|w| w[0].0 - w[0].1 * (w[1].0 - w[0].0) / (w[1].1 - w[0].1)).collect();
    (zeros[zeros.len() - 1] - zeros[0]) / (zeros.len() - 1) as f64
}

/// Returns a mass of 5 on a node at z = 0.5, which moves along z with the velocity -2, above a fixed node at the origin.
fn mass_above_ground(links: &str, step: &str, more: &str) -> String {
    format!(
        "*Node\n 1, 0., 0.\n 2, 0., 0.5\n*Nset, nset=M\n 2\n*Element, type=MASS, elset=EM\n 1, 2\n*Mass, elset=EM\n 5.\n{links}\
         *Initial Conditions, type=VELOCITY\n M, 2, -2.\n*Boundary\n 1, 1, 2\n*Step\n{step}\n{more}\
         *Output, history, frequency=1\n*Node Output, nset=M\n U2, V2, A2\n*Energy Output\n ALLKE, ALLSE, ALLIE, ALLVD, ETOTAL\n*End Step\n"
    )
}

const SPRING_AND_DASHPOT: &str = "*Element, type=SPRINGA, elset=K\n 2, 2, 1\n*Spring, elset=K\n\n 20000.\n\
     *Element, type=DASHPOTA, elset=C\n 3, 2, 1\n*Dashpot, elset=C\n\n 100.\n";
const TO_GROUND: &str = "*Element, type=SPRING1, elset=K\n 2, 2\n*Spring, elset=K\n 2\n 20000.\n\
     *Element, type=DASHPOT1, elset=C\n 3, 2\n*Dashpot, elset=C\n 2\n 100.\n";
const AUTOMATIC: &str = "*Dynamic, Explicit\n , 0.5";

/// `x(t) = (v/omega) exp(-d t) sin(omega t)` with `d = c/2m`, between two nodes and to the ground. Errors are relative to
/// the amplitude. With automatic increments dashpots have the error `c dt/4m` = 1e-4 per radian, with increments of 1e-5 half this error.
#[test]
fn damped_oscillation_has_its_closed_form() {
    let (m, k, c): (f64, f64, f64) = (5.0, 20000.0, 100.0);
    let decay = c / (2.0 * m);
    let omega = (k / m - decay * decay).sqrt();
    let exact = |t: f64| -2.0 / omega * (-decay * t).exp() * (omega * t).sin();
    for (links, name) in [(SPRING_AND_DASHPOT, "to a node"), (TO_GROUND, "to the ground")] {
        for (step, tolerance) in [(AUTOMATIC, 3e-4), ("*Dynamic, Explicit, direct user control\n 1e-5, 0.5", 1.5e-4)] {
            let deck = mass_above_ground(links, step, "");
            let (outcome, memory) = run(&deck);
            assert_eq!((&outcome.halt, outcome.warnings.len()), (&None, 0), "{:?}", outcome.warnings);
            let motion = column(&deck, &memory, "U2@M");
            let error = motion.iter().map(|u| (u.1 - exact(u.0)).abs()).fold(0.0, f64::max) * omega / 2.0;
            let dissipated = last(&deck, &memory, "ALLVD") / 10.0;
            println!(
                "oscillator {name}, {} increments: error {error:.1e} of the amplitude, ALLVD {dissipated:.5} of 10, drift {:.1e}",
                outcome.increments, outcome.energy.drift
            );
            assert!(error < tolerance, "{error:e}");
            let remaining = (-2.0 * decay * 0.5_f64).exp();
            assert!((dissipated - 1.0).abs() < 5.0 * remaining && outcome.energy.drift < 1e-3, "{:?}", outcome.energy);
        }
    }
}

/// Two masses joined by a spring in free flight: `omega = sqrt(k/mu)` with the reduced mass, and the common centre moves
/// at constant velocity.
#[test]
fn two_free_masses_vibrate_with_the_reduced_mass() {
    let (a, b, k): (f64, f64, f64) = (2.0, 3.0, 500.0);
    let deck = format!(
        "*Node\n 1, 0., 0.\n 2, 0., 1.\n*Nset, nset=A\n 1\n*Nset, nset=B\n 2\n*Element, type=MASS, elset=MA\n 1, 1\n*Mass, elset=MA\n {a}\n\
         *Element, type=MASS, elset=MB\n 2, 2\n*Mass, elset=MB\n {b}\n*Element, type=SPRINGA, elset=K\n 3, 1, 2\n*Spring, elset=K\n\n {k}\n\
         *Initial Conditions, type=VELOCITY\n B, 2, 1.\n*Step\n{AUTOMATIC}\n*Output, history, frequency=1\n*Node Output, nset=A\n U2\n\
         *Node Output, nset=B\n U2\n*End Step\n"
    )
    .replace("0.5\n", "10.\n");
    let (outcome, memory) = run(&deck);
    assert_eq!((&outcome.halt, outcome.warnings.len()), (&None, 0), "{:?}", outcome.warnings);
    let [first, second] = ["U2@A", "U2@B"].map(|name| column(&deck, &memory, name));
    let extension: Vec<(f64, f64)> = first.iter().zip(&second).map(|(a, b)| (a.0, b.1 - a.1)).collect();
    let expected = 2.0 * PI * (a * b / (a + b) / k).sqrt();
    let error = period(&extension) / expected - 1.0;
    let centre = (a * first[first.len() - 1].1 + b * second[second.len() - 1].1) / (a + b);
    println!("two masses: period error {error:.1e}, centre {centre:.12}, drift {:.1e}", outcome.energy.drift);
    assert!(error.abs() < 1.5e-4, "{error:e}");
    assert!((centre / (10.0 * b / (a + b)) - 1.0).abs() < 1e-12, "{centre}");
}

/// A spring with the stiffness k in compression and 4 k in tension has half periods of both: `pi sqrt(m/k) (1 + 1/2)`.
#[test]
fn bilinear_spring_has_the_sum_of_two_half_periods() {
    let table = "*Element, type=SPRINGA, elset=K\n 2, 1, 2\n*Spring, elset=K, nonlinear\n\n -20000., -1.\n 0., 0.\n 80000., 1.\n";
    let deck = mass_above_ground(table, "*Dynamic, Explicit\n , 2.", "");
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    let motion = column(&deck, &memory, "U2@M");
    let error = period(&motion) / (1.5 * PI * (5.0 / 20000.0_f64).sqrt()) - 1.0;
    println!("bilinear spring: period error {error:.1e}, drift {:.1e}", outcome.energy.drift);
    assert!(error.abs() < 1e-4 && outcome.energy.drift < 1e-3, "{error:e}");
}

/// Returns two rigid discs of masses 1 and 2 that a connector joins.
fn two_discs(connector: &str, step: &str) -> String {
    let disc = |n: usize, z: f64, mass: f64| {
        format!(
            "*Node\n {n}1, 0., {z}\n {n}2, 1., {z}\n*Nset, nset=D{n}\n {n}1\n*Element, type=RAX2, elset=E{n}\n {n}1, {n}1, {n}2\n\
             *Element, type=MASS, elset=M{n}\n {n}2, {n}1\n*Mass, elset=M{n}\n {mass}\n*Rigid Body, ref node={n}1, elset=E{n}\n"
        )
    };
    disc(1, 0.0, 1.0)
        + &disc(2, 1.0, 2.0)
        + connector
        + "*Initial Conditions, type=VELOCITY\n D1, 2, 3.\n*Step\n"
        + step
        + "\n*Output, history, frequency=1\n*Node Output, nset=D1\n U2, V2\n*Node Output, nset=D2\n U2, V2\n*Energy Output\n ALLKE, ALLSE, ALLVD, ETOTAL\n*End Step\n"
}

/// Rigid bodies joined by a spring vibrate with the reduced mass; a dashpot takes the relative velocity exponentially.
#[test]
fn rigid_bodies_are_joined_by_springs_and_dashpots() {
    let mu = 2.0 / 3.0;
    let spring = "*Element, type=SPRINGA, elset=K\n 3, 11, 21\n*Spring, elset=K\n\n 500.\n";
    let deck = two_discs(spring, "*Dynamic, Explicit\n , 5.");
    let (outcome, memory) = run(&deck);
    assert_eq!((&outcome.halt, outcome.warnings.len()), (&None, 0), "{:?}", outcome.warnings);
    let [first, second] = ["U2@D1", "U2@D2"].map(|name| column(&deck, &memory, name));
    let extension: Vec<(f64, f64)> = first.iter().zip(&second).map(|(a, b)| (a.0, b.1 - a.1)).collect();
    let error = period(&extension) / (2.0 * PI * (mu / 500.0_f64).sqrt()) - 1.0;
    let drift = outcome.energy.drift;
    println!("two discs: {} increments, period error {error:.1e}, drift {drift:.1e}", outcome.increments);
    assert!(error.abs() < 1e-4 && drift < 1e-4, "{error:e} {drift:e}");
    let dashpot = "*Element, type=DASHPOTA, elset=C\n 3, 11, 21\n*Dashpot, elset=C\n\n 4.\n";
    let deck = two_discs(dashpot, "*Dynamic, Explicit\n , 0.3");
    let (outcome, memory) = run(&deck);
    assert_eq!((&outcome.halt, outcome.warnings.len()), (&None, 0), "{:?}", outcome.warnings);
    let relative = last(&deck, &memory, "V2@D1") - last(&deck, &memory, "V2@D2");
    let error = relative / (3.0 * (-4.0 / mu * 0.3_f64).exp()) - 1.0;
    println!("dashpot between two discs: {} increments, relative velocity {error:.1e}", outcome.increments);
    assert!(error.abs() < 1e-3, "{error:e}");
}

/// The stable time increment of one mass on a spring is `2/omega`: with fixed increments of `0.99 * 2/omega` the motion is bounded, with the
/// amplitude `1/sqrt(1 - 0.99^2)` = 7.1, if the limit on energies permits it. With `1.01 * 2/omega` it grows, and the run halts. Automatic
/// increments are stable for soft and stiff springs.
#[test]
fn increments_are_stable_up_to_two_over_omega() {
    let critical = 2.0 * (5.0 / 20000.0_f64).sqrt();
    let spring = SPRING_AND_DASHPOT.split("*Element, type=DASHPOTA").next().expect("a spring");
    let fixed = |ratio: f64, limit: &str| {
        let step = format!("*Dynamic, Explicit, direct user control\n {}, {}", ratio * critical, 2000.0 * critical);
        let deck = mass_above_ground(spring, &step, limit);
        let (outcome, memory) = run(&deck);
        let largest = column(&deck, &memory, "U2@M").iter().fold(0.0_f64, |most, u| most.max(u.1.abs()));
        (outcome, largest * (20000.0_f64 / 5.0).sqrt() / 2.0)
    };
    let (below, amplitude) = fixed(0.99, "*Energy Limit, error=1000.\n");
    let (above, growth) = fixed(1.01, "");
    println!("0.99: amplitude {amplitude:.2} of the exact one; 1.01: {growth:.1e}, {:?}", above.halt);
    assert!(below.halt.is_none() && amplitude < 7.2, "{amplitude} {:?}", below.halt);
    let halt = above.halt.map(|halt| halt.to_string()).unwrap_or_default();
    assert!(halt.contains("1.01 times the stable time increment"), "{halt}");
    for stiffness in [1.0, 1e4, 1e8] {
        let links = SPRING_AND_DASHPOT.replace("20000.", &format!("{stiffness}"));
        let deck =
            mass_above_ground(&links, &format!("*Dynamic, Explicit\n , {}", 50.0 / (stiffness / 5.0_f64).sqrt()), "");
        let (outcome, _) = run(&deck);
        assert!(outcome.halt.is_none() && outcome.energy.drift < 2e-3, "{stiffness}: {:?}", outcome.energy);
    }
}

/// A free mass under gravity and a constant force moves as `v t + a t^2/2`, to rounding.
#[test]
fn free_mass_falls() {
    let loads = "*Dload\n , GRAV, 9.81, 0., -1.\n*Cload\n 2, 2, 10.\n";
    let deck = mass_above_ground("", AUTOMATIC, loads).replace("*Boundary\n 1, 1, 2\n", "");
    let (outcome, memory) = run(&deck);
    assert_eq!((&outcome.halt, outcome.warnings.len()), (&None, 0), "{:?}", outcome.warnings);
    let exact = |t: f64| -2.0 * t + 0.5 * (10.0 / 5.0 - 9.81) * t * t;
    let motion = column(&deck, &memory, "U2@M");
    let error = motion.iter().map(|u| (u.1 - exact(u.0)).abs()).fold(0.0, f64::max);
    println!("free mass: {} increments, error {error:.1e}, drift {:.1e}", outcome.increments, outcome.energy.drift);
    assert!(motion.len() > 20 && error < 1e-12, "{} {error:e}", motion.len());
}

/// Two masses on a spring without a force at the start move although a body of elements is at rest, whose nodes are not
/// updated while nothing reaches them.
#[test]
fn masses_move_next_to_a_body_at_rest() {
    let masses = "*Node, nset=A\n 901, 5., 0.\n*Node, nset=B\n 902, 5., 1.\n*Element, type=MASS, elset=EM\n 901, 901\n 902, 902\n*Mass, elset=EM\n 2.\n\
         *Element, type=SPRINGA, elset=K\n 903, 901, 902\n*Spring, elset=K\n\n 500.\n*Initial Conditions, type=VELOCITY\n A, 2, -1.\n B, 2, 1.\n";
    let deck = grid(6, 4, false, |i, j| [0.1 * i as f64, 0.1 * j as f64])
        + &material(1e3, 0.3, 1.0, masses)
        + "*Step\n*Dynamic, Explicit\n , 2.\n*Output, history, frequency=1\n*Node Output, nset=B\n U2\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    let error = period(&column(&deck, &memory, "U2@B")) / (2.0 * PI * (1.0 / 500.0_f64).sqrt()) - 1.0;
    println!("masses next to a body: period error {error:.1e}");
    assert!(error.abs() < 1e-3, "{error:e}");
}
