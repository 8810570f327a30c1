//! New meshes of bodies with springs, dashpots, point masses, concentrated forces and user loads.
//!
//! Goal: motion, momentum and energies continue at each new mesh. Source: closed forms of rigid motion, and conservation of
//! momentum. Tolerances are stated at each test.

use std::f64::consts::PI;

use revolve::user::{LoadFailure, LoadPoints, Routines, UserLoad};

use super::remeshing::new_meshes;
use super::remeshing_contact::EAGER;
use crate::common::bodies::{DeckRun, assembly, elastic, part, run_with};
use crate::common::solid::{grid, material};

/// Radius and height of a steel cylinder, mm, and its density, t/mm³.
const RADIUS: f64 = 1.0;
const HEIGHT: f64 = 2.0;
const DENSITY: f64 = 7.85e-9;
/// Number of elements along the radius and the axis.
const GRID: [usize; 2] = [4, 8];
/// Initial velocity, mm/s.
const SPEED: f64 = 1000.0;

fn cylinder_mass() -> f64 {
    DENSITY * PI * RADIUS * RADIUS * HEIGHT
}

/// A cylinder that moves along its axis. `cards` precede the step, `in_step` has its loads.
fn cylinder(remesh: &str, cards: &str, time: f64, in_step: &str) -> String {
    let [n, m] = GRID;
    let place = |i: usize, j: usize| [RADIUS * i as f64 / n as f64, HEIGHT * j as f64 / m as f64];
    let corner = (n + 1) * (m + 1);
    grid(n, m, false, place)
        + &material(200e3, 0.3, DENSITY, "")
        + &format!(
            "{remesh}*Nset, nset=RIM\n {corner},\n*Nset, nset=UPPER, generate\n {}, {corner}, 1\n{cards}*Initial \
             Conditions, type=VELOCITY\n ALL, 2, {SPEED}\n*Step\n*Dynamic, Explicit\n , {time:e}\n{in_step}*Output, \
             history, number interval=100\n*Node Output, nset=RIM\n U2, V2\n*Energy Output\n ALL\n*End Step\n",
            corner - n
        )
}

/// Returns runs without and with new meshes.
fn both(cards: &str, time: f64, in_step: &str, routines: &Routines) -> [DeckRun; 2] {
    let eager = format!("*Remesh, elset=SOLID, frequency=100, {EAGER}\n");
    ["*Remesh, automatic=NO\n", &eager].map(|card| run_with(&cylinder(card, cards, time, in_step), routines).whole())
}

fn last(ran: &DeckRun, name: &str) -> f64 {
    ran.column(name).last().map_or(f64::NAN, |row| row[1])
}

/// A cylinder with a point mass at its rim on a spring and a dashpot to the ground: the displacement is that of a rigid damped
/// oscillator within 1e-3 of its amplitude, the elastic deflection of the cylinder. The energy closes, and the spring and the
/// dashpot have their energies without new meshes within 1e-3 of the initial energy.
#[test]
fn springs_dashpots_and_point_masses_continue() {
    let (point, time) = (5e-8, 1.6e-4);
    let mass = cylinder_mass() + point;
    let omega = 2.0 * PI / time;
    let (stiffness, damping) = (mass * omega * omega, 0.1 * mass * omega);
    let cards = format!(
        "*Element, type=MASS, elset=POINT\n 9001, {rim}\n*Mass, elset=POINT\n {point:e},\n*Element, type=SPRING1, elset=SPRING\n \
         9002, {rim}\n*Spring, elset=SPRING\n 2,\n {stiffness:e},\n*Element, type=DASHPOT1, elset=DASHPOT\n 9003, {rim}\n*Dashpot, \
         elset=DASHPOT\n 2,\n {damping:e},\n",
        rim = (GRID[0] + 1) * (GRID[1] + 1)
    );
    let [follows, moved] = both(&cards, time, "", &Routines::none());
    let (decay, damped) = (0.05 * omega, omega * (1.0_f64 - 0.05 * 0.05).sqrt());
    let exact = |t: f64| SPEED / damped * (-decay * t).exp() * (damped * t).sin();
    let apart = |ran: &DeckRun| {
        let rows = ran.column("U2@RIM");
        rows.iter().map(|[t, u]| (u - exact(*t)).abs()).fold(0.0, f64::max) * omega / SPEED
    };
    let [from_exact, without] = [&moved, &follows].map(apart);
    let energy = 0.5 * mass * SPEED * SPEED;
    let energies = ["ALLIE", "ALLVD"].map(|name| (last(&moved, name) - last(&follows, name)) / energy);
    println!(
        "{} meshes: displacement {from_exact:.1e} apart, {without:.1e} without; energies {energies:?}, drift {:.1e}",
        new_meshes(&moved.outcome),
        moved.outcome.energy.drift
    );
    assert!(new_meshes(&moved.outcome) >= 5 && moved.outcome.energy.drift < 1e-3);
    assert!(from_exact < 1e-3, "{from_exact:e}");
    assert!(energies.iter().all(|apart| apart.abs() < 1e-3), "{energies:?}");
    let masses: f64 = moved.state.dofs.nodes.mass.iter().sum();
    assert!((masses / mass - 1.0).abs() < 1e-12, "{masses:e}");
}

/// Forces on the nodes of a face: the momentum is their impulse to rounding, whatever nodes the new meshes have.
#[test]
fn concentrated_forces_continue() {
    let (force, time) = (-2.0, 4e-5);
    let [_, moved] = both("", time, &format!("*Cload\n UPPER, 2, {force}\n"), &Routines::none());
    let exact = cylinder_mass() * SPEED + (GRID[0] + 1) as f64 * force * time;
    // Velocities are those of half an increment before.
    let momentum = mean_momentum(&moved) / exact - 1.0;
    println!(
        "{} meshes: momentum {momentum:.1e}, drift {:.1e}",
        new_meshes(&moved.outcome),
        moved.outcome.energy.drift
    );
    assert!(new_meshes(&moved.outcome) >= 3 && moved.outcome.energy.drift < 1e-3);
    assert!(momentum.abs() < 1e-9, "{momentum:e}");
}

/// Returns the momentum along the axis at the end.
fn mean_momentum(ran: &DeckRun) -> f64 {
    let nodes = &ran.state.dofs.nodes;
    (0..nodes.len()).map(|n| nodes.mass[n] * nodes.velocity_now(n)[1]).sum()
}

/// An elastic foundation that pulls a face back in proportion to its displacement along the axis. The memory of each point is its
/// initial place.
struct Foundation {
    stiffness: f64,
}

impl UserLoad for Foundation {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        let count = points.z.len();
        for (i, p) in pressure.iter_mut().enumerate() {
            let displacement = points.motion[3 * count + i];
            let start = &points.memory[i];
            if start.get() == 0.0 {
                start.set(points.z[i]);
            }
            if (points.z[i] - start.get() - displacement).abs() > 1e-12 * HEIGHT {
                let place = start.get();
                return Err(LoadFailure::new(format!("z = {}, from {place} by {displacement}", points.z[i])));
            }
            *p = self.stiffness * displacement;
        }
        Ok(())
    }

    fn reads_motion(&self) -> bool {
        true
    }

    fn memory(&self) -> usize {
        1
    }
}

/// A user load on the upper face of the cylinder, an elastic foundation: displacement of a rigid oscillator within 1e-3 of its
/// amplitude, the elastic deflection of the cylinder. Displacements and memory of the points continue.
#[test]
fn user_loads_continue() {
    let time = 1.6e-4;
    let omega = 2.0 * PI / time;
    let stiffness = cylinder_mass() * omega * omega / (PI * RADIUS * RADIUS);
    let routines = Routines::none().with_load(Foundation { stiffness });
    let [follows, moved] = both("", time, "*Dsload\n J1, PNU\n", &routines);
    let apart = |ran: &DeckRun| {
        let rows = ran.column("U2@RIM");
        rows.iter().map(|[t, u]| (u - SPEED / omega * (omega * t).sin()).abs()).fold(0.0, f64::max) * omega / SPEED
    };
    let [from_exact, without] = [&moved, &follows].map(apart);
    let work = last(&moved, "ALLWK") / (0.5 * cylinder_mass() * SPEED * SPEED);
    println!(
        "{} meshes: displacement {from_exact:.1e} apart, {without:.1e} without; work {work:.1e} of the energy, drift {:.1e}",
        new_meshes(&moved.outcome),
        moved.outcome.energy.drift
    );
    assert!(new_meshes(&moved.outcome) >= 5 && moved.outcome.energy.drift < 1e-3);
    assert!(from_exact < 1e-3, "{from_exact:e}");
    // After a period the cylinder is where it was.
    assert!(work.abs() < 5e-3, "{work:e}");
}

/// Two cylinders that are tied, of copper and aluminium, both of which yield: the copper one moves at first. `cards` are those of
/// new meshes.
fn tied_cylinders(cards: &str) -> String {
    let lower = part("LOWER", [8, 16], |i, j| [0.125 * i as f64, 0.125 * j as f64], "");
    // Inner nodes of the second cylinder are displaced, so that its angles request a new mesh.
    let zigzag =
        |i: usize, j: usize| if j.is_multiple_of(2) || j == 9 { 0.0 } else { 0.15 * (PI * i as f64 / 6.0).sin() };
    let upper = part("UPPER", [6, 9], |i, j| [i as f64 / 6.0 + zigzag(i, j), HEIGHT + HEIGHT * j as f64 / 9.0], "");
    let yields = "*Plastic\n 200., 0.\n 300., 1.\n";
    lower
        + &upper
        + &assembly(&["LOWER", "UPPER"], "*Nset, nset=TOP\n UPPER.70\n*Tie, name=JOINT\n UPPER.J0, LOWER.J1\n")
        + &elastic("LOWER", [117e3, 0.33, 8.9e-9], yields)
        + &elastic("UPPER", [70e3, 0.33, 2.7e-9], yields)
        + &format!(
            "{cards}*Initial Conditions, type=VELOCITY\n LOWER.ALL, 2, -3e4\n*Step\n*Dynamic, Explicit\n , 2e-5\n*Output, \
             history, number interval=20\n*Node Output, nset=TOP\n U2\n*Energy Output\n ALL\n*End Step\n"
        )
}

/// New meshes of the first, of the second and of both of two tied bodies: momentum is conserved to rounding, the displacement and plastic work are those without new meshes within 0.5 % and 2 %.
#[test]
fn ties_continue() {
    let follows = run_with(&tied_cylinders("*Remesh, automatic=NO\n"), &Routines::none()).whole();
    let lower = format!("*Remesh, elset=LOWER.SOLID, frequency=50, {EAGER}\n");
    let upper = "*Remesh, elset=UPPER.SOLID, frequency=50, angle=59.\n".to_string();
    for cards in [lower.clone(), upper.clone(), lower + &upper] {
        let moved = run_with(&tied_cylinders(&cards), &Routines::none()).whole();
        let exact = -3e4 * 8.9e-9 * PI * RADIUS * RADIUS * HEIGHT;
        let momentum = mean_momentum(&moved) / exact - 1.0;
        let [apart, work] = ["U2@TOP", "ALLPD"].map(|name| last(&moved, name) / last(&follows, name) - 1.0);
        println!(
            "{} meshes: momentum {momentum:.1e}, displacement {apart:.1e} and plastic work {work:.1e} apart, drift {:.1e}",
            new_meshes(&moved.outcome),
            moved.outcome.energy.drift
        );
        assert!(new_meshes(&moved.outcome) >= 1 && moved.outcome.energy.drift < 1.5e-3);
        assert!(momentum.abs() < 1e-12, "{momentum:e}");
        assert!(apart.abs() < 5e-3 && work.abs() < 2e-2, "{apart:e} {work:e}");
    }
}
