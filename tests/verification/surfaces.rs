//! Analytical rigid surfaces on fixed, moving and free bodies, and section forces of deformable bodies.
//!
//! Goal: momentum, energy, forces and contact times.
//! Source: closed forms of bars, of Hertz and of rigid bodies. The tolerance and its reason are stated at each test.
//! Tests of a single node on arcs, slopes and corners are in `src/numerics/constraint/contact/analytical.rs`.

use revolve::solve;
use revolve::user::Routines;

use crate::common::solid::{column, grid, last, material, run};
use crate::common::{RecordedOutput, prepared};

/// Returns a flat punch with reference node 800, a mass and an initial velocity.
fn flat_punch(z: f64, mass: f64, velocity: f64) -> String {
    format!(
        "*Node, nset=REF\n 800, 0., {z}\n*Element, type=MASS, elset=POINT\n 800, 800\n*Mass, elset=POINT\n {mass:e}\n\
         *Surface, type=SEGMENTS, name=PUNCH\n START, 9., {z}\n LINE, 0., {z}\n\
         *Rigid Body, ref node=800, analytical surface=PUNCH\n*Surface Interaction, name=DRY\n\
         *Initial Conditions, type=VELOCITY\n 800, 2, {velocity:e}\n"
    )
}

/// A rigid mass falls on the end of an elastic bar: V = v exp(-rho c A t/M) until the reflected wave returns after 2
/// L/c (St. Venant; Graff, Wave Motion in Elastic Solids, 2.5). The error is of first order in the row height because
/// the front is discontinuous.
#[test]
fn mass_on_a_bar_decelerates_exponentially() {
    let area = std::f64::consts::PI * 0.01;
    let mass = 0.5 * area;
    let error = |rows: usize| {
        let deck = grid(1, rows, false, |i, j| [0.1 * i as f64, j as f64 / rows as f64])
            + &material(1.0, 0.0, 1.0, &flat_punch(1.0, mass, -1e-3))
            + "*Step\n*Dynamic, Explicit\n , 1.6\n*Bulk Viscosity\n 0., 0.\n*Boundary\n J0, 2, 2\n*Contact Pair, interaction=DRY\n J1, PUNCH\n\
               *Output, history, frequency=1\n*Node Output, nset=REF\n V2, A2\n*End Step\n";
        let (outcome, memory) = run(&deck);
        assert_eq!(outcome.halt, None);
        assert!(outcome.energy.drift < 2e-2 && outcome.energy.contact >= 0.0, "{:?}", outcome.energy);
        let velocity = column(&deck, &memory, "V2@REF");
        let off = |&(t, v): &(f64, f64)| (v / -1e-3 - (-2.0 * t).exp()).abs();
        // After the initial discontinuity.
        velocity.iter().filter(|row| row.0 > 0.2).map(off).fold(0.0, f64::max)
    };
    let [coarse, fine] = [20, 80].map(error);
    println!("mass on a bar: velocity errors {coarse:.2e}, {fine:.2e} of the first");
    assert!(fine < 0.5 * coarse, "{coarse} {fine}");
    assert!(fine < 0.01, "{fine}");
}

/// A free hemisphere with friction falls on a free block: momentum is conserved to rounding, energy only decreases.
#[test]
fn free_punch_and_block_conserve_momentum() {
    let punch = "*Node, nset=REF\n 800, 0., 2.5\n*Element, type=MASS, elset=POINT\n 800, 800\n*Mass, elset=POINT\n 5.\n\
         *Surface, type=SEGMENTS, name=PUNCH, fillet radius=0.05\n START, 0.9, 3.\n LINE, 0.8, 2.\n CIRCL, 0., 1.05, 0., 2.\n\
         *Rigid Body, ref node=800, analytical surface=PUNCH\n*Surface Interaction, name=DRY\n*Friction\n 0.3\n\
         *Initial Conditions, type=VELOCITY\n 800, 2, -0.2\n"
        .replace("CIRCL, 0., 1.05, 0., 2.", "CIRCL, 0., 1.2, 0., 2.");
    let deck = grid(12, 10, false, |i, j| [i as f64 / 10.0, 0.1 * j as f64])
        + &material(10.0, 0.3, 1.0, &punch)
        + "*Step\n*Dynamic, Explicit\n , 4.\n*Contact Pair, interaction=DRY\n PUNCH, J1\n\
           *Output, history, number interval=40\n*Node Output, nset=REF\n V2, A2\n*End Step\n";
    let prepared = prepared(&deck, &[], &Routines::none());
    let momentum = |state: &revolve::plan::State| {
        let nodes = &state.dofs.nodes;
        let of = |n: usize| nodes.mass[n] * nodes.as_slice()[n].v_z;
        let body = &state.dofs.bodies[0];
        (0..nodes.len()).map(of).sum::<f64>() + body.mass * body.velocity_half
    };
    let (outcome, state) = solve::run(&prepared.plan, prepared.state.clone(), &mut RecordedOutput::default());
    assert_eq!(outcome.halt, None);
    let off = (momentum(&state) / (5.0 * -0.2) - 1.0).abs();
    let energy = outcome.energy;
    println!("free punch: momentum error {off:.1e}, lost {:.2e}, friction {:.2e}", energy.contact, energy.friction);
    assert!(off < 1e-11, "{off}");
    assert!(state.dofs.bodies[0].velocity > -0.1, "no contact with the block");
    assert!(energy.friction > 0.0 && energy.contact > -1e-4 * energy.initial && energy.drift < 5e-3, "{energy:?}");
}

/// Rigid sphere pressed into an elastic block: F = 4/3 E* sqrt(R) d^1.5 (Hertz 1882; Johnson, Contact Mechanics, 4.2).
/// The block ends at 12, 24 and 48 contact radii and is stiffer than a half-space. This deviation is inversely
/// proportional to its size (far field of a point force), and the limit of the two largest blocks is the half-space.
#[test]
fn pressed_rigid_sphere_converges_to_hertz() {
    let (depth, radius, nu, cells) = (0.01_f64, 1.0_f64, 0.3, 6_usize);
    let contact = (radius * depth).sqrt();
    let force = 4.0 / 3.0 / (1.0 - nu * nu) * radius.sqrt() * depth.powf(1.5);
    // Uniform cells over two contact radii, then each cell is a fifth longer than the previous one.
    let place = |k: usize| {
        let (even, growth) = (2 * cells, 1.2_f64);
        let outer = k.saturating_sub(even) as i32;
        contact / cells as f64 * (k.min(even) as f64 + (growth.powi(outer) - 1.0) / (growth - 1.0) * growth)
    };
    let excess = |size: f64| {
        let count = (0..).find(|&k| place(k) > size * contact).expect("it grows");
        let scale = place(count) / (size * contact);
        // Outer cells are scaled so that block sizes have a ratio of two.
        let place =
            |k: usize| if k <= 2 * cells { place(k) } else { place(2 * cells) + (place(k) - place(2 * cells)) / scale };
        let time = 16.0_f64.max(16.0 / 24.0 * size);
        let sphere = format!(
            "*Node, nset=REF\n 9800, 0., 0.\n*Surface, type=SEGMENTS, name=BALL\n START, 1., 1.\n CIRCL, 0., 0., 0., 1.\n\
             *Rigid Body, ref node=9800, analytical surface=BALL\n*Surface Interaction, name=DRY\n\
             *Amplitude, name=PUSH, definition=SMOOTH STEP\n 0., 0., {time}, 1., 1000., 1.\n"
        );
        let deck = grid(count, count, false, |i, j| [place(i), -place(count - j)])
            + &material(1.0, nu, 1.0, &sphere)
            + &format!(
                "*Step\n*Dynamic, Explicit\n , {}\n*Boundary\n J0, 2, 2\n I1, 1, 1\n*Boundary, amplitude=PUSH\n 9800, 2, 2, {}\n\
                 *Contact Pair, interaction=DRY\n J1, BALL\n*Output, history, number interval=240\n*Node Output, nset=REF\n RF2\n*End Step\n",
                1.5 * time,
                -depth
            );
        let (outcome, memory) = run(&deck);
        assert_eq!(outcome.halt, None);
        assert!(outcome.energy.drift < 1e-4, "{:?}", outcome.energy);
        let rows = column(&deck, &memory, "RF2@REF");
        let rest: Vec<f64> = rows.iter().filter(|r| r.0 > 1.1 * time).map(|r| -r.1).collect();
        rest.iter().sum::<f64>() / rest.len() as f64 / force - 1.0
    };
    let [small, middle, large] = [12.0, 24.0, 48.0].map(excess);
    let order = ((small - middle) / (middle - large)).log2();
    let half_space = 2.0 * large - middle;
    println!("Hertz: {small:.4}, {middle:.4}, {large:.4} above Hertz, order {order:.2}, half space {half_space:.4}");
    assert!((order - 1.0).abs() < 0.3, "{order}: {small} {middle} {large}");
    // Six cells resolve the contact radius to a tenth.
    assert!(half_space.abs() < 0.02, "{half_space}");
}

/// The force of a slowly stretched bar on a wall equals that of its lowest elements, the reaction and the section force
/// in its middle, up to residual vibration.
#[test]
fn section_forces_equal_the_reaction() {
    let deck = grid(3, 12, false, |i, j| [1.0 + i as f64 / 3.0, j as f64 / 4.0])
        + &material(
            1.0,
            0.3,
            1.0,
            "*Elset, elset=ROW, generate\n 19, 21\n*Surface, name=CUT\n ROW, S1\n*Integrated Output Section, name=MIDDLE, surface=CUT\n*Amplitude, name=RISE, definition=SMOOTH STEP\n 0., 0., 200., 1.\n*Nset, nset=FOOT\n J0\n",
        )
        + "*Step\n*Dynamic, Explicit\n , 300.\n*Boundary\n J0, 2, 2\n*Dsload, amplitude=RISE\n J1, P, -1e-4\n\
           *Output, history, number interval=300\n*Node Output, nset=J0\n RF2\n\
           *Integrated Output, surface=J0\n SOF, SOAREA\n*Integrated Output, section=MIDDLE\n SOF2\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    let area = std::f64::consts::PI * 3.0;
    let reaction: f64 = (1..=4).map(|n| last(&deck, &memory, &format!("RF2@{n}"))).sum();
    let [foot, middle] = ["SOF2@J0", "SOF2@MIDDLE"].map(|name| last(&deck, &memory, name));
    println!("reaction {reaction:.6e}, foot {foot:.6e}, middle {middle:.6e}, applied {:.6e}", -1e-4 * area);
    // The reaction is the mean over the output interval.
    assert!((foot / reaction - 1.0).abs() < 1e-4, "{foot} {reaction}");
    assert!((middle / foot - 1.0).abs() < 1e-2 && (foot / (-1e-4 * area) - 1.0).abs() < 1e-2, "{foot} {middle}");
    assert!((last(&deck, &memory, "SOAREA@J0") / area - 1.0).abs() < 1e-3);
}

/// Diagnostics of `check` for surfaces with reversed sides and for arcs that are not quite circular.
#[test]
fn faulty_surfaces_are_reported_with_a_place() {
    let deck = |surface: &str| {
        grid(2, 2, false, |i, j| [i as f64, j as f64])
            + &material(1.0, 0.0, 1.0, "")
            + &format!(
                "*Node\n 800, 0., 0.\n*Surface, type=SEGMENTS, name=WALL\n{surface}*Rigid Body, ref node=800, analytical surface=WALL\n\
                 *Surface Interaction, name=DRY\n*Step\n*Dynamic, Explicit\n , 1.\n*Boundary\n 800, 2, 2\n*Contact Pair, interaction=DRY\n J0, WALL\n*End Step\n"
            )
    };
    for (code, error, surface) in [
        ("", false, " START, 0., 0.\n LINE, 9., 0.\n"),
        ("", false, " START, 0., -1.\n LINE, 9., -1.\n"),
        ("P110", false, " START, 9., 0.\n LINE, 0., 0.\n"),
        ("P110", false, " START, 9., -1.\n LINE, 0., -1.\n"),
        ("P111", false, " START, 0., 1e-4\n LINE, 9., 1e-4\n"),
        ("", false, " START, 0., -1.\n CIRCL, 9., 8., 0., 8.\n"),
        ("M170", false, " START, 0., -1.\n CIRCL, 9., 8., 0., 8.0001\n"),
        ("M103", true, " START, 0., -1.\n CIRCL, 9., 8., 0., 8.2\n"),
        ("M103", true, " START, 0., -0.1\n"),
        ("M104", true, " START, 0., -0.1\n PARAB, 1., 1., 2., 4.\n"),
        ("P021", true, " START, 0., 0.5\n LINE, 1.5, -0.5\n LINE, 9., -0.5\n"),
    ] {
        let prepared = revolve::job::prepare_text("slip.inp", &deck(surface), &[], &Routines::none());
        let shown = prepared.diagnostics.render(&prepared.deck.sources);
        assert_eq!(prepared.diagnostics.has_errors(), error, "{surface}{shown}");
        let reported = prepared.diagnostics.iter().any(|d| d.code == code);
        assert_eq!(reported, !code.is_empty(), "{surface}{code}: {shown}");
    }
}
