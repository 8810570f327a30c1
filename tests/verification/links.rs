//! Links between bodies: rigid bodies with tied nodes, equations, springs, dashpots, walls.
//!
//! Goal: periods, momenta, contact times and energies of linked bodies.
//! Source: closed forms of vibrating columns, oscillators and bars. The tolerance and its reason are stated at each
//! test.

use std::f64::consts::PI;
use std::fmt::Write as _;

use crate::common::solid::{column, grid, last, material, run};

/// Modulus of uniaxial strain of the columns, of density 1: wave speed 2 for height 1 and radius 0.1.
const MODULUS: f64 = 4.0;
const ROWS: usize = 20;

/// Returns a column along z in uniaxial strain with its last row tied to a rigid body of this mass whose reference
/// node is 900.
fn column_with_mass(mass: f64, more: &str) -> String {
    let nu: f64 = 0.25;
    let e = MODULUS * (1.0 + nu) * (1.0 - 2.0 * nu) / (1.0 - nu);
    grid(2, ROWS, false, |i, j| [0.05 * i as f64, j as f64 / ROWS as f64])
        + &material(e, nu, 1.0, "")
        + &format!(
            "*Node, nset=REF\n 900, 0., 1.\n*Element, type=MASS, elset=POINT\n 900, 900\n*Mass, elset=POINT\n {mass:e}\n\
             *Rigid Body, ref node=900, tie nset=J1\n{more}"
        )
}

/// Returns the rising zero crossings of a history by linear interpolation.
fn rising_zeros(history: &[(f64, f64)]) -> Vec<f64> {
    let rising = history.windows(2).filter(|w| w[0].1 < 0.0 && w[1].1 >= 0.0);
    rising.map(|w| w[0].0 - w[0].1 * (w[1].0 - w[0].0) / (w[1].1 - w[0].1)).collect()
}

/// beta tan beta = mass of the column over the attached mass; omega = beta c / L.
#[test]
fn rigid_mass_on_a_column_has_the_period_of_theory() {
    let column_mass = PI * 0.01;
    let beta: f64 = 0.860_333_589_019_38; // beta tan beta = 1
    let omega = 2.0 * beta;
    // First mode only, with an amplitude small enough for linear motion.
    let velocity = |z: f64| 1e-6 * (beta * z).sin();
    let mut start = String::from("*Initial Conditions, type=VELOCITY\n");
    for n in 0..3 * ROWS {
        writeln!(start, " {}, 2, {:e}", n + 1, velocity((n / 3) as f64 / ROWS as f64)).expect("text");
    }
    writeln!(start, " 900, 2, {:e}", velocity(1.0)).expect("text");
    let deck = column_with_mass(column_mass, &start)
        + "*Step\n*Dynamic, Explicit\n , 40.\n*Bulk Viscosity\n 0., 0.\n*Boundary\n ALL, 1, 1\n J0, 2, 2\n\
           *Output, history, frequency=1\n*Node Output, nset=REF\n U2\n*Node Output, nset=J1\n U2\n*Energy Output\n ALLKE\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    let motion = column(&deck, &memory, "U2@REF");
    let zeros = rising_zeros(&motion);
    let period = (zeros[zeros.len() - 1] - zeros[0]) / (zeros.len() - 1) as f64;
    // Second order: 1.1e-4 with 20 rows, 2e-5 with 40.
    let error = period * omega / (2.0 * PI) - 1.0;
    assert!(error.abs() < 2e-4, "period error {error:e}");
    // Tied nodes move with their body exactly.
    assert_eq!(last(&deck, &memory, &format!("U2@{}", 3 * ROWS + 3)), motion.last().expect("a row").1);
    let drift = outcome.energy.drift;
    println!("mass on a column: period error {error:.1e}, drift {drift:.1e}");
    assert!(drift < 2e-3, "{drift:e}");
}

#[test]
fn rigid_mass_and_free_column_conserve_momentum_and_energy() {
    let mass = 0.02;
    let deck = column_with_mass(mass, "*Initial Conditions, type=VELOCITY\n 900, 2, -1.e-3\n")
        + "*Step\n*Dynamic, Explicit, element by element\n , 3.\n*Bulk Viscosity\n 0., 0.\n*Boundary\n ALL, 1, 1\n*Output, history, number interval=50\n\
           *Node Output, nset=REF\n V2\n*Node Output, nset=ALL\n V2\n*Energy Output\n ETOTAL\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    // Lumped masses by row sums: integrals of N r dr over the two rings, half at the ends.
    let (h, row) = (0.05, 2.0 * PI / ROWS as f64);
    let share = [h * h / 6.0, h * h / 3.0 + h * (0.5 * h + h / 6.0), h * (0.5 * h + h / 3.0)];
    let start = -1e-3 * (mass + 0.25 * PI * 0.01 * 2.0 / ROWS as f64);
    for values in memory.rows.iter().map(|r| &r.1) {
        let of_node = |n: usize| {
            let half = if n / 3 == 0 || n / 3 == ROWS { 0.5 } else { 1.0 };
            half * row * share[n % 3] * values[1 + n]
        };
        let momentum = mass * values[0] + (0..3 * (ROWS + 1)).map(of_node).sum::<f64>();
        // Rounding of some thousand increments.
        assert!((momentum / start - 1.0).abs() < 1e-11, "{momentum:e} {start:e}");
    }
    println!("mass and free column: drift {:.1e}", outcome.energy.drift);
    assert!(outcome.energy.drift < 2e-3, "{:e}", outcome.energy.drift);
}

/// Gravity on all nodes and a force on a tied node accelerate the assembly as one body.
#[test]
fn tied_bodies_fall_as_one() {
    let deck = column_with_mass(0.02, "*Nset, nset=TIED\n 62\n")
        + "*Step\n*Dynamic, Explicit\n , 1.\n*Dload\n , GRAV, 9.81, 0., -1.\n*Boundary\n ALL, 1, 1\n\
           *Output, history, number interval=5\n*Node Output, nset=REF\n V2\n*Node Output, nset=TIED\n V2\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    // No strain except rounding.
    assert!((last(&deck, &memory, "V2@REF") / -9.81 - 1.0).abs() < 1e-11);
    assert!((last(&deck, &memory, "V2@TIED") / -9.81 - 1.0).abs() < 1e-11);
}

/// A bar whose upper half is a copy joined by equations moves like the whole bar.
#[test]
fn bars_joined_by_equations_match_shared_nodes() {
    let (n, m) = (2, 8);
    let ends = "*Step\n*Dynamic, Explicit, direct user control\n 0.01, 4.\n*Boundary\n J0, 2, 2\n";
    let asks = "*Output, history, number interval=20\n*Node Output, nset=TOP\n U2, U1\n*Energy Output\n ALLKE, ETOTAL\n*End Step\n";
    let load = "*Dsload\n TOP, P, -0.01\n";
    let whole = grid(n, m, false, |i, j| [0.2 + 0.1 * i as f64, 0.1 * j as f64])
        + &material(1.0, 0.3, 1.0, "*Nset, nset=TOP\n 25\n*Surface, name=TOP\n EJ1, S3\n")
        + ends
        + load
        + asks;
    let mut halves = grid(n, m / 2, false, |i, j| [0.2 + 0.1 * i as f64, 0.1 * j as f64]);
    for (k, j) in (0..=m / 2).map(|j| (j, j + m / 2)) {
        for i in 0..=n {
            writeln!(halves, "*Node\n {}, {}, {}", 101 + i + 3 * k, 0.2 + 0.1 * i as f64, 0.1 * j as f64)
                .expect("text");
        }
    }
    for e in 0..n * m / 2 {
        let a = 101 + e % n + 3 * (e / n);
        writeln!(halves, "*Element, type=CAX4R, elset=SOLID\n {}, {a}, {}, {}, {}", 101 + e, a + 1, a + 4, a + 3)
            .expect("text");
    }
    halves += "*Nset, nset=UPPER\n 101, 102, 103\n*Elset, elset=ETOP\n 107, 108\n*Surface, name=TOP\n ETOP, S3\n*Nset, nset=TOP\n 113\n\
               *Equation\n 2\n UPPER, 1, 1., J1, 1, -1.\n2\nUPPER, 2, 2.\nJ1, 2, -2.\n";
    let halves = halves + &material(1.0, 0.3, 1.0, "") + ends + load + asks;
    let ((one, rows), (two, joined)) = (run(&whole), run(&halves));
    assert_eq!((one.halt, two.halt), (None, None));
    assert!(one.energy.drift < 1e-3 && two.energy.drift < 1e-3, "{:e} {:e}", one.energy.drift, two.energy.drift);
    for name in ["U2@TOP", "U1@TOP", "ALLKE"] {
        for (a, b) in column(&whole, &rows, name).iter().zip(column(&halves, &joined, name)) {
            // The same sums in another order, over 400 increments.
            assert!((a.1 - b.1).abs() < 1e-12, "{name}: {} {}", a.1, b.1);
        }
    }
}

/// A node that follows a prescribed motion by an equation moves in the given ratio, and the energy balance closes.
#[test]
fn equation_follows_a_prescribed_motion() {
    let deck = grid(2, 4, false, |i, j| [i as f64, j as f64])
        + &material(
            100.0,
            0.3,
            1.0,
            "*Amplitude, name=RAMP, definition=SMOOTH STEP\n 0., 0., 1., 1.\n*Nset, nset=LEADER\n 1\n*Nset, nset=FOLLOWER\n 15\n*Nset, nset=OTHER\n 14\n",
        )
        + "*Equation\n 2\n 15, 2, 1., 1, 2, -2.\n3\n14, 2, 1., 15, 2, -0.5, 13, 2, -0.5\n*Step\n*Dynamic, Explicit, element by element\n , 1.\n\
           *Boundary, amplitude=RAMP\n 1, 2, 2, 0.01\n*Output, history, number interval=20\n\
           *Node Output, nset=LEADER\n U2, RF2\n*Node Output, nset=FOLLOWER\n U2\n*Node Output, nset=OTHER\n U2\n*Node Output, nset=J1\n U2\n*Energy Output\n ALLWK\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    assert!((last(&deck, &memory, "U2@LEADER") - 0.01).abs() < 1e-14);
    assert!((last(&deck, &memory, "U2@FOLLOWER") - 0.02).abs() < 1e-12);
    let mean = 0.5 * (last(&deck, &memory, "U2@FOLLOWER") + last(&deck, &memory, "U2@13"));
    assert!((last(&deck, &memory, "U2@OTHER") - mean).abs() < 1e-12);
    // The prescribed motion does all work, including that on the dependent node.
    println!("given motion through an equation: drift {:.1e}", outcome.energy.drift);
    assert!(outcome.energy.work > 0.0 && outcome.energy.drift < 2e-3, "{:?}", outcome.energy);
}

/// Asserts the error code of each change of a valid deck; the code is empty if the deck is valid.
fn assert_errors(good: &str, cases: &[(&str, &str, &str)]) {
    for (code, from, to) in cases {
        let text = good.replacen(from, to, 1);
        let prepared = revolve::job::prepare_text("bad.inp", &text, &[], &revolve::user::Routines::none());
        let shown = prepared.diagnostics.render(&prepared.deck.sources);
        let codes: Vec<&str> = prepared.diagnostics.iter().map(|d| d.code).collect();
        assert_eq!(codes.contains(code), !code.is_empty(), "{code}: {shown}");
        assert_eq!(prepared.diagnostics.has_errors(), !code.is_empty(), "{code}: {shown}");
    }
}

#[test]
fn invalid_equations_are_errors() {
    let good = column_with_mass(1.0, "*Equation\n 2\n 1, 2, 1., 2, 2, -1.\n")
        + "*Step\n*Dynamic, Explicit\n , 1.\n*Boundary\n 1, 2, 2\n*End Step\n";
    let cases = [
        ("", "", ""),
        ("P018", "*Equation\n", "*Equation\n 2\n 1, 2, 2., 2, 2, -2.\n"),
        ("P018", " 1, 2, 2\n", " 1, 2, 2\n 2, 2, 2\n"),
        ("P011", " 2, 2, -1.", " 900, 2, -1."),
        ("M102", ", -1.", ""),
        ("M102", " 1, 2, 1., 2, 2, -1.\n", ""),
        ("M103", " 2, 2, -1.", " 2, 6, -1."),
        ("M103", " 2\n 1, 2", " 1\n 1, 2"),
    ];
    assert_errors(&good, &cases);
}

/// Returns a stiff block of mass pi 1^2 0.5 on springs and dashpots.
fn block_on_springs(e: f64, more: &str, step: &str) -> String {
    grid(2, 2, false, |i, j| [0.5 * i as f64, 2.0 + 0.25 * j as f64])
        + more
        + &material(e, 0.0, 1.0, "*Nset, nset=ONE\n 1\n")
        + step
        + "*Bulk Viscosity\n 0., 0.\n*Output, history, frequency=1\n*Node Output, nset=ONE\n U2\n*Energy Output\n ALLSE, ALLVD, ALLKE\n*End Step\n"
}

#[test]
fn mass_on_spring_and_dashpot_matches_closed_form() {
    let mass = 0.5 * PI;
    let (k, c): (f64, f64) = (2.0, 0.1);
    let links = format!(
        "*Element, type=SPRING1, elset=K\n 101, 1\n*Spring, elset=K\n 2\n {k}\n*Element, type=DASHPOT1, elset=C\n 102, 1\n*Dashpot, elset=C\n 2\n {c}\n\
         *Initial Conditions, type=VELOCITY\n ALL, 2, 0.01\n"
    );
    let deck = block_on_springs(1e5, &links, "*Step\n*Dynamic, Explicit\n , 30.\n");
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    let motion = column(&deck, &memory, "U2@ONE");
    let zeros = rising_zeros(&motion);
    let period = (zeros[zeros.len() - 1] - zeros[0]) / (zeros.len() - 1) as f64;
    let decay = c / (2.0 * mass);
    let omega = (k / mass - decay * decay).sqrt();
    let error = period * omega / (2.0 * PI) - 1.0;
    // Local compliance of the block in its middle, 1.2e-4, and a smaller effect of the increment.
    assert!(error.abs() < 3e-4, "period error {error:e}");
    let peak = |a: f64, b: f64| motion.iter().filter(|m| (a..b).contains(&m.0)).fold(0.0, |p: f64, m| p.max(m.1));
    let measured = (peak(0.0, period) / peak(4.0 * period, 5.0 * period)).ln() / (4.0 * period);
    assert!((measured / decay - 1.0).abs() < 1e-2, "decay {measured} {decay}");
    let energy = outcome.energy;
    println!(
        "spring and dashpot: period {error:.1e}, decay {:.1e}, drift {:.1e}",
        measured / decay - 1.0,
        energy.drift
    );
    assert!(energy.drift < 1e-3, "{:e}", energy.drift);
    assert!(energy.viscous > 0.5 * energy.initial && energy.strain >= 0.0, "{energy:?}");
}

/// A spring far stiffer than the two free blocks it joins limits the increment: at 0.98 of the stable increment energy
/// is conserved and the blocks vibrate about their common centre.
#[test]
fn stiff_spring_limits_the_increment() {
    let other: String = (0..9)
        .map(|n| format!("*Node, nset=UP\n {}, {}, {}\n", 201 + n, 0.5 * (n % 3) as f64, 4.0 + 0.25 * (n / 3) as f64))
        .collect();
    let elements: String = (0..4)
        .map(|e| {
            let a = 201 + e % 2 + 3 * (e / 2);
            format!("*Element, type=CAX4R, elset=SOLID\n {}, {a}, {}, {}, {}\n", 201 + e, a + 1, a + 4, a + 3)
        })
        .collect();
    let run_with = |spring: &str, factor: &str| {
        let links = format!(
            "{other}{elements}*Element, type=SPRINGA, elset=K\n 301, 7, 201\n*Spring, elset=K{spring}\n\
             *Initial Conditions, type=VELOCITY\n UP, 2, 0.001\n"
        );
        run(&block_on_springs(
            1e3,
            &links,
            &format!("*Step\n*Dynamic, Explicit, element by element, scale factor={factor}\n , 20.\n"),
        ))
    };
    let (soft, _) = run_with("\n\n 0.1", "1.");
    let (stiff, _) = run_with("\n\n 100000.", "0.98");
    assert_eq!((&soft.halt, &stiff.halt), (&None, &None));
    assert!(stiff.increments > 3 * soft.increments, "{} {}", stiff.increments, soft.increments);
    assert!(soft.energy.drift < 1e-3 && stiff.energy.drift < 1e-2, "{:e} {:e}", soft.energy.drift, stiff.energy.drift);
    // A table of the same slope is the same spring with other increments.
    let (table, _) = run_with(", nonlinear\n\n -1., -10.\n 1., 10.", "1.");
    assert!((table.energy.strain / soft.energy.strain - 1.0).abs() < 1e-3, "{:?}", table.energy);
    // Above the limit the motion grows without bound.
    let (beyond, _) = run_with("\n\n 100000.", "1.6");
    assert!(beyond.halt.is_some() || beyond.energy.kinetic > 10.0 * beyond.energy.initial, "{:?}", beyond.energy);
}

/// Rigid wall at z = 0 with reference node 800.
const WALL: &str = "*Node\n 800, 0., 0.\n*Surface, type=SEGMENTS, name=WALL\n START, 0., 0.\n LINE, 100., 0.\n\
     *Rigid Body, ref node=800, analytical surface=WALL\n*Surface Interaction, name=SMOOTH\n";
const PAIR: &str = "*Contact Pair, interaction=SMOOTH\n J0, WALL\n";

/// Elastic bar in uniaxial strain against a wall: contact lasts 2 L/c with the force rho c v A, and the bar rebounds
/// with its initial speed.
#[test]
fn bar_rebounds_from_a_wall_after_two_wave_transits() {
    let (rows, v, nu): (usize, f64, f64) = (200, 1e-3, 0.25);
    let e = MODULUS * (1.0 + nu) * (1.0 - 2.0 * nu) / (1.0 - nu);
    let deck = grid(1, rows, false, |i, j| [1.0 + 0.02 * i as f64, 0.001 + j as f64 / rows as f64])
        + &material(e, nu, 1.0, WALL)
        + &format!("*Initial Conditions, type=VELOCITY\n ALL, 2, {}\n*Nset, nset=REF\n 800\n", -v)
        + "*Step\n*Dynamic, Explicit\n , 3.\n*Bulk Viscosity\n 0.02, 0.\n*Boundary\n ALL, 1, 1\n 800, 2, 2\n"
        + PAIR
        + "*Output, history, frequency=1\n*Node Output, nset=REF\n RF2\n*Node Output, nset=I0\n V2\n*Energy Output\n ALLKE\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    let (speed, area) = (2.0, PI * (1.02 * 1.02 - 1.0));
    let force = column(&deck, &memory, "RF2@REF");
    let held = force.windows(2).map(|w| w[1].1.abs() * (w[1].0 - w[0].0)).sum::<f64>();
    let plateau = speed * v * area;
    let pressed: Vec<f64> = force.iter().filter(|f| f.1.abs() > 0.5 * plateau).map(|f| f.0).collect();
    let contact = pressed[pressed.len() - 1] - pressed[0];
    // The bar has length 1 and a distance of 0.001 / v = 1 in time; the front is two elements wide.
    assert!((contact - 1.0).abs() < 0.02 && (pressed[0] - 1.0).abs() < 0.01, "{contact} from {}", pressed[0]);
    // The impulse reverses the momentum of the bar, except for that of half a row lost at first contact.
    let restitution = held / (area * v) - 1.0;
    let energy = outcome.energy;
    println!("bar and wall: contact {contact:.4}, rebound {restitution:.4} v, drift {:.1e}", energy.drift);
    assert!((0.97..1.001).contains(&restitution), "{restitution}");
    assert!(energy.drift < 2e-3 && energy.contact > 0.0 && energy.contact < 0.02 * energy.initial, "{energy:?}");
}

/// A contact pair may refer to a surface interaction defined after it, and an undefined one is an error.
#[test]
fn surface_interaction_may_follow_its_pair() {
    let interaction = "*Surface Interaction, name=ROUGH\n*Friction\n 0.25\n";
    let deck = |before: &str, after: &str| {
        grid(2, 4, false, |i, j| [i as f64, j as f64])
            + &material(MODULUS, 0.3, 1.0, WALL)
            + before
            + "*Initial Conditions, type=VELOCITY\n ALL, 2, -0.01\n ALL, 1, 0.01\n"
            + "*Step\n*Dynamic, Explicit\n , 2.\n*Boundary\n 800, 2, 2\n*Contact Pair, interaction=ROUGH\n J0, WALL\n"
            + "*End Step\n"
            + after
    };
    let [early, late] = [deck(interaction, ""), deck("", interaction)].map(|text| run(&text).0.energy);
    assert!(early.friction > 0.0);
    assert_eq!(early.friction.to_bits(), late.friction.to_bits());
    let none = deck("", "");
    let prepared = revolve::job::prepare_text("bad.inp", &none, &[], &revolve::user::Routines::none());
    let shown = prepared.diagnostics.render(&prepared.deck.sources);
    assert!(prepared.diagnostics.has_errors() && shown.contains("M114") && shown.contains("ROUGH"), "{shown}");
}

/// The copper Taylor bar against a wall is close to one with a fixed foot; friction reduces the foot radius.
#[test]
fn taylor_bar_on_a_wall_matches_one_with_a_fixed_foot() {
    let bar = |boundary: &str, pair: &str| {
        let deck = grid(6, 30, false, |i, j| [3.2e-3 * i as f64 / 6.0, 32.4e-3 * j as f64 / 30.0])
            + &material(
                117e9,
                0.35,
                8930.0,
                &format!(
                    "*Plastic\n 4.e8, 0.\n 5.e8, 1.\n{WALL}*Friction\n MU\n*Nset, nset=FOOT\n 7\n*Nset, nset=HEAD\n 211\n"
                ),
            )
            + "*Initial Conditions, type=VELOCITY\n ALL, 2, -227.\n*Step\n*Dynamic, Explicit\n , 8.e-5\n*Boundary\n 800, 2, 2\n"
            + boundary
            + pair
            + "*Output, history, number interval=10\n*Node Output, nset=FOOT\n U1\n*Node Output, nset=HEAD\n U2\n*Energy Output\n ALLFD\n*End Step\n";
        move |mu: &str| {
            let deck = deck.replace("MU", mu);
            let (outcome, memory) = run(&deck);
            assert_eq!(outcome.halt, None);
            println!("Taylor bar: drift {:.1e}, contact {:.1e}", outcome.energy.drift, outcome.energy.contact);
            assert!(outcome.energy.drift < 2e-3, "{:?}", outcome.energy);
            (last(&deck, &memory, "U1@FOOT"), last(&deck, &memory, "U2@HEAD"), outcome.energy.friction)
        }
    };
    let held = bar(" J0, 2, 2\n", "")("0.");
    let wall = bar("", PAIR);
    let (smooth, rough) = (wall("0."), wall("0.2"));
    println!("foot and head: held {held:?}, wall {smooth:?}, friction 0.2 {rough:?}");
    let size = |bar: (f64, f64, f64)| (3.2e-3 + bar.0, 32.4e-3 + bar.1);
    let ((radius, length), (held_radius, held_length)) = (size(smooth), size(held));
    // The rim of the foot lifts off a wall, which a fixed foot cannot: 2.7 % in radius and 0.1 % in length on this
    // mesh.
    assert!((length / held_length - 1.0).abs() < 3e-3, "{length} {held_length}");
    assert!((0.0..0.04).contains(&(radius / held_radius - 1.0)), "{radius} {held_radius}");
    assert!(smooth.2 == 0.0 && rough.2 > 0.0 && rough.0 < smooth.0, "{smooth:?} {rough:?}");
}

/// A moving wall pushes a bar; the energy of the bar is the work of the prescribed motion.
#[test]
fn moving_wall_does_the_work_of_its_force() {
    let deck = grid(1, 10, false, |i, j| [1.0 + 0.1 * i as f64, 0.1 * j as f64])
        + &material(4.0, 0.0, 1.0, &format!("{WALL}*Nset, nset=REF\n 800\n"))
        + "*Step\n*Dynamic, Explicit\n , 2.\n*Boundary, type=VELOCITY\n 800, 2, 2, 0.001\n"
        + PAIR
        + "*Output, history, frequency=1\n*Node Output, nset=REF\n RF2\n*Energy Output\n ALLWK\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    let energy = outcome.energy;
    let force = column(&deck, &memory, "RF2@REF");
    let work: f64 = force.windows(2).map(|w| w[1].1 * 0.001 * (w[1].0 - w[0].0)).sum();
    println!("moving wall: work {:.4e}, from its force {work:.4e}, drift {:.1e}", energy.work, energy.drift);
    assert!(energy.work > 0.0 && (work / energy.work - 1.0).abs() < 0.05, "{work} {energy:?}");
    assert!(energy.drift < 2e-3, "{energy:?}");
}

#[test]
fn invalid_wall_contact_is_an_error() {
    let good = grid(1, 1, false, |i, j| [1.0 + i as f64, j as f64])
        + &material(1.0, 0.0, 1.0, WALL)
        + "*Step\n*Dynamic, Explicit\n , 1.\n*Boundary\n 800, 2, 2\n"
        + PAIR
        + "*End Step\n";
    let cases = [
        ("", "", ""),
        ("P002", " 800, 2, 2", " 800, 1, 1"),
        (
            "P021",
            " START, 0., 0.\n LINE, 100., 0.",
            " START, 0., 0.5\n LINE, 100., 0.5\n*Surface, name=BOTH\n EJ0, S1\n EJ1, S3\n*Contact Pair\n BOTH, WALL",
        ),
        ("M104", " LINE, 100., 0.", " PARAB, 100., 1., 200., 0."),
        ("M114", " J0, WALL", " NONE, WALL"),
        ("", " J0, WALL", " J0, J1"),
        ("", "interaction=SMOOTH", "interaction=SMOOTH, mechanical constraint=PENALTY"),
        ("M103", "interaction=SMOOTH", "interaction=SMOOTH, mechanical constraint=SPRINGS"),
        ("M103", "name=SMOOTH\n", "name=SMOOTH\n*Friction\n -1.\n"),
    ];
    assert_errors(&good, &cases);
}

/// Nodes with equal motion, one of which is moved with a changing velocity and is in an equation with another body: the
/// work of the prescribed motion is the energy of both bodies, to the error of the strain integration.
#[test]
fn moved_group_in_an_equation_does_the_work_of_its_force() {
    let place = |i: usize, j: usize| [1.0 + i as f64 / 3.0, j as f64 / 4.0];
    let mesh = grid(3, 4, false, place).replace("*Node, nset=ALL", "*Node, nset=UP");
    let upper = mesh.split("*Nset").next().unwrap_or_default();
    let shifted = |line: &str| {
        let cells = line
            .split(',')
            .map(|cell| cell.trim().parse::<usize>().map_or(cell.to_owned(), |n| format!(" {}", n + 100)));
        cells.collect::<Vec<_>>().join(",") + "\n"
    };
    let upper: String =
        upper.lines().map(|line| if line.starts_with('*') { format!("{line}\n") } else { shifted(line) }).collect();
    let deck = grid(3, 4, false, place)
        + &upper
        + &material(1.0, 0.3, 1.0, "*Nset, nset=REF\n 1\n*MPC\n TIE, 2, 1\n TIE, 3, 1\n TIE, 4, 1\n")
        + "*Equation\n 2\n 1, 2, 1., 101, 2, -1.\n*Amplitude, name=A, definition=SMOOTH STEP\n 0., 0., 1., 1., 3., 0.\n\
           *Step\n*Dynamic, Explicit\n , 3.\n*Boundary, type=VELOCITY, amplitude=A\n 1, 2, 2, 0.05\n\
           *Output, history, frequency=1\n*Node Output, nset=REF\n RF2\n*Energy Output\n ALLWK\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    let rows = column(&deck, &memory, "RF2@REF");
    println!("moved group: {} rows, drift {:.1e}", rows.len(), outcome.energy.drift);
    assert!(outcome.energy.drift < 1e-2, "{:?}", outcome.energy);
}
