//! Eulerian boundaries of adaptive meshes, and motions of the mesh that are prescribed in space.
//!
//! Goal: material that flows through a mesh keeps its state, and what enters and leaves is accounted for. Source: the
//! exact motion of material at constant velocity, conservation of mass and momentum, ideal work of extrusion, and the
//! same extrusion on a mesh that follows the material.

use std::f64::consts::PI;
use std::fmt::Write as _;

use revolve::job;
use revolve::plan::State;
use revolve::solve::Outcome;
use revolve::user::Routines;

use crate::common;
use crate::common::solid::{grid, material};

/// Constraint that holds all nodes in space.
const HELD: &str = "*Adaptive Mesh Constraint\n ALL, 1, 2\n";

/// Returns a mesh of `n` by `m` elements whose lower and upper ends are Eulerian boundaries.
fn open_grid(n: usize, m: usize, place: impl Fn(usize, usize) -> [f64; 2]) -> String {
    let open = |text: String, name: &str| {
        text.replace(&format!("name={name}\n"), &format!("name={name}, region type=EULERIAN\n"))
    };
    open(open(grid(n, m, false, place), "J0"), "J1")
}

/// Returns a bar with Eulerian ends that moves upwards with the velocity 1, with cards before its step and in it.
fn bar([n, m]: [usize; 2], [radius, length]: [f64; 2], start: &str, time: f64, cards: &str) -> String {
    let waves = |i: usize, j: usize| {
        let inside = i > 0 && i < n && j > 0 && j < m;
        let by = if inside { 0.2 * ((3 * i + 5 * j) as f64).sin() } else { 0.0 };
        [radius * (i as f64 + by) / n as f64, length * (j as f64 + by) / m as f64]
    };
    open_grid(n, m, waves)
        + start
        + &format!(
            "*Initial Conditions, type=VELOCITY\n ALL, 2, 1.\n*Step\n*Dynamic, Explicit\n , {time:e}\n*Adaptive Mesh, elset=SOLID\n\
             {cards}*Output, history\n*Energy Output\n ALLKE\n*End Step\n"
        )
}

fn run(deck: &str) -> (Outcome, State, State) {
    let prepared = common::prepared(deck, &[], &Routines::none());
    let (outcome, end) = job::run_into(&prepared, &mut common::RecordedOutput::default());
    assert_eq!(outcome.halt, None);
    (outcome, prepared.state, end)
}

/// A uniform flow through an irregular mesh at rest, and through one that moves, stays uniform, and the mesh is where it is
/// prescribed to be, up to the motion of the material in the last increment.
#[test]
fn uniform_flow_stays_uniform() {
    let ramp = "*Amplitude, name=RAMP\n 0., 0., 1., 0.4\n";
    for (cards, speed) in [
        (HELD.to_string(), 0.0),
        ("*Adaptive Mesh Constraint, type=VELOCITY\n ALL, 2, 2, 0.4\n ALL, 1, 1\n".into(), 0.4),
        ("*Adaptive Mesh Constraint, amplitude=RAMP\n ALL, 2, 2, 1.\n ALL, 1, 1\n".into(), 0.4),
    ] {
        let start = material(1000.0, 0.3, 1.0, ramp);
        let (outcome, before, after) = run(&bar([5, 12], [1.0, 2.4], &start, 1.0, &cards));
        let (nodes, dt) = (&after.dofs.nodes, after.dofs.nodes.previous_dt);
        for n in 0..nodes.len() {
            let off = [nodes[n].v_r, nodes[n].v_z - 1.0, nodes.mass[n] / before.dofs.nodes.mass[n] - 1.0];
            assert!(off.iter().all(|x| x.abs() < 1e-12), "{off:?}");
            // The last change of the mesh was one increment before the end.
            let z = before.dofs.nodes[n].z + speed * (1.0 - dt) + dt;
            assert!((nodes[n].z - z).abs() < 1e-12, "{} {z}", nodes[n].z);
        }
        let flow = outcome.energy.flow;
        let passed = PI * (1.0 - speed) * (1.0 - dt);
        assert!(
            (flow.mass_in / passed - 1.0).abs() < 1e-10 && (flow.mass_out / passed - 1.0).abs() < 1e-10,
            "{flow:?}"
        );
        assert!(outcome.energy.drift < 1e-12, "{}", outcome.energy.drift);
    }
}

/// A smooth profile of plastic strain moves with the material through a mesh at rest, and its upper half leaves the mesh:
/// error of second order in the L1 norm.
#[test]
fn profiles_leave_the_mesh_with_second_order() {
    let value = |z: f64| 0.1 + 0.5 * (PI * z).sin().powi(2);
    let law = "*Plastic\n 1000., 0.\n 1001., 10.\n";
    let errors = [40, 80, 160].map(|m| {
        let mut start = material(1000.0, 0.3, 1.0, law) + "*Initial Conditions, type=HARDENING\n";
        for e in 0..m {
            writeln!(start, " {}, {:e}", e + 1, value((e as f64 + 0.5) / m as f64)).expect("text");
        }
        let (_, before, after) = run(&bar([1, m], [0.1, 1.0], &start, 0.5, HELD));
        let moved = 0.5;
        let group = &after.elements.groups[0];
        let strain = |e: usize| group.value(e, revolve::variables::Variable::PlasticStrain.into());
        let sum: f64 = (0..m)
            .filter_map(|e| {
                let nodes = group.nodes(e);
                let z = |state: &State| (0..4).map(|c| state.dofs.nodes[nodes[c] as usize].z).sum::<f64>() / 4.0;
                let from = z(&after) - moved;
                assert!((z(&after) - z(&before)).abs() < 0.1 / m as f64);
                (from > 0.0).then(|| (strain(e).expect("a strain") - value(from)).abs() / m as f64)
            })
            .sum();
        sum
    });
    let orders = [0, 1].map(|i| (errors[i] / errors[i + 1]).log2());
    println!("errors {errors:?}, orders {orders:?}");
    assert!(orders.iter().all(|order| *order >= 1.8), "{errors:?} {orders:?}");
}

/// A bar that expands and contracts while it flows: mass and momentum that enter less those that leave are the changes in
/// the mesh, also across a step boundary, and the energies balance.
#[test]
fn what_enters_and_leaves_is_balanced() {
    let start = material(100.0, 0.3, 1.0, "*Plastic\n 2., 0.\n 4., 1.\n");
    let deck =
        bar([4, 20], [1.0, 5.0], &start, 1.0, HELD).replace(" ALL, 2, 1.\n", " ALL, 2, 1.\n FAST, 2, 2.5\n").replace(
            "*Initial Conditions, type=VELOCITY",
            "*Nset, nset=FAST, generate\n 30, 70\n*Initial Conditions, type=VELOCITY",
        ) + "*Step\n*Dynamic, Explicit\n , 1.\n*End Step\n";
    let (outcome, before, after) = run(&deck);
    let sum = |state: &State, of: &dyn Fn(usize) -> f64| {
        (0..state.dofs.nodes.len()).map(|n| state.dofs.nodes.mass[n] * of(n)).sum::<f64>()
    };
    let [mass, mass_after] = [&before, &after].map(|state| sum(state, &|_| 1.0));
    // Velocities are those at the middle of increments; no force acts on the bar along z.
    let [momentum, momentum_after] = [&before, &after].map(|state| sum(state, &|n| state.dofs.nodes[n].v_z));
    let flow = outcome.energy.flow;
    let mass_error = (mass_after - mass - (flow.mass_in - flow.mass_out)) / mass;
    let momentum_error = (momentum_after - momentum - flow.momentum) / momentum;
    println!("{flow:?}: mass {mass_error:.1e}, momentum {momentum_error:.1e}, drift {:.1e}", outcome.energy.drift);
    assert!((mass_after / mass - 1.0).abs() > 1e-3 && flow.mass_out > 0.3 * mass, "{mass} {mass_after} {flow:?}");
    assert!(mass_error.abs() < 1e-12 && momentum_error.abs() < 1e-12);
    assert!(outcome.energy.plastic > 0.0 && outcome.energy.drift < 1e-3, "{:?}", outcome.energy);
}

/// Radii of a billet and of the extruded bar, and length of the die between them, mm.
const DIE: [f64; 3] = [10.0, 8.0, 10.0];
/// Velocity of the billet, mm/s, its density, t/mm³, and its yield stress, MPa.
const BILLET: [f64; 3] = [1e4, 2.7e-9, 100.0];

/// Returns the radius of a smooth die without corners.
fn radius(z: f64) -> f64 {
    let ([wide, narrow, length], s) = (DIE, (z / DIE[2]).clamp(0.0, 1.0));
    wide - (wide - narrow) * s * s * (3.0 - 2.0 * s) * f64::from(length > 0.0)
}

/// Returns the extrusion of a perfectly plastic billet through a frictionless die, with a mesh from `low` on.
fn extrusion(eulerian: bool, low: f64, time: f64) -> String {
    let (n, high, size) = (5, 22.0, 2.0);
    let m = ((high - low) / size) as usize;
    let place = |i: usize, j: usize| {
        let z = low + size * j as f64;
        [radius(z) * i as f64 / n as f64, z]
    };
    let mesh = if eulerian { open_grid(n, m, place) } else { grid(n, m, false, place) };
    let [velocity, density, yield_stress] = BILLET;
    let mut die = format!(" START, {}, -100.\n", DIE[0]);
    for k in 0..=40 {
        let z = DIE[2] * f64::from(k) / 40.0;
        writeln!(die, " LINE, {:.15}, {z:.15}", radius(z)).expect("text");
    }
    let (region, cards) = if eulerian {
        let constraint = "*Adaptive Mesh, elset=SOLID\n*Adaptive Mesh Constraint\n J0, 1, 2\n J1, 2, 2\n I1, 2, 2\n";
        (", region type=EULERIAN", constraint)
    } else {
        ("", "")
    };
    mesh + &material(70e3, 0.33, density, &format!("*Plastic\n {yield_stress}, 0.\n"))
        + &format!(
            "*Node, nset=REF\n 9000, 0., 0.\n*Surface, type=SEGMENTS, name=DIE\n{die} LINE, 8., 13.\n LINE, 12., 16.\n\
             *Rigid Body, ref node=9000, analytical surface=DIE\n*Amplitude, name=UP\n 0., 0., 2.e-4, 1., 1., 1.\n\
             *Surface Interaction, name=SMOOTH\n*Step\n*Dynamic, Explicit\n , {time:e}\n*Boundary\n REF, 1, 6\n\
             *Boundary, type=VELOCITY, amplitude=UP{region}\n J0, 2, 2, {velocity:e}\n*Contact Pair, interaction=SMOOTH\n I1, DIE\n\
             {cards}*Output, history, number interval=200\n*Node Output, nset=J0, statistics=SUM\n RF2\n*Energy Output\n ALLPD\n\
             *End Step\n"
        )
}

/// Returns the means of the pressure on the end of the billet and of the plastic power over the velocity and the section in
/// the last part of a run.
fn extrusion_pressure(eulerian: bool, low: f64, [from, time]: [f64; 2]) -> (Outcome, [f64; 2]) {
    let prepared = common::prepared(&extrusion(eulerian, low, time), &[], &Routines::none());
    let mut sink = common::RecordedOutput::default();
    let (outcome, _) = job::run_into(&prepared, &mut sink);
    assert_eq!(outcome.halt, None);
    let names = prepared.plan.column_names();
    let column = |name: &str| names.iter().position(|n| n == name).unwrap_or_else(|| panic!("{name} in {names:?}"));
    let (force, work) = (column("RF2_SUM@J0"), column("ALLPD"));
    let rows: Vec<_> = sink.rows.iter().filter(|row| row.0 >= from).collect();
    let section = PI * DIE[0] * DIE[0];
    let mean = rows.iter().map(|row| row.1[force]).sum::<f64>() / rows.len() as f64;
    let (first, last) = (rows[0], rows[rows.len() - 1]);
    let power = (last.1[work] - first.1[work]) / (last.0 - first.0);
    (outcome, [mean / section, power / BILLET[0] / section])
}

/// Steady extrusion through a smooth die: the pressure does the plastic work (2 %, with hourglass control), is above that of ideal work, Y ln(A0/A1), and
/// is that of a long billet whose mesh follows the material (3 %: its force varies by 12 % as elements pass the die).
#[test]
fn extrusion_needs_the_pressure_of_a_long_billet() {
    let (follows, [expected, _]) = extrusion_pressure(false, -38.0, [8e-4, 2e-3]);
    let (outcome, [pressure, plastic]) = extrusion_pressure(true, -12.0, [8e-4, 2e-3]);
    let ideal = BILLET[2] * 2.0 * (DIE[0] / DIE[1]).ln();
    let flow = outcome.energy.flow;
    let rate = BILLET[1] * PI * DIE[0] * DIE[0] * BILLET[0] * (2e-3 - 1e-4);
    println!(
        "extrusion: pressure {pressure:.2}, plastic {plastic:.2}, long billet {expected:.2}, ideal {ideal:.2}, mass in {:.4}, \
         out {:.4} of {rate:e}, drifts {:.1e} {:.1e}",
        flow.mass_in / rate,
        flow.mass_out / rate,
        outcome.energy.drift,
        follows.energy.drift
    );
    assert!((pressure / expected - 1.0).abs() < 0.03, "{pressure} {expected}");
    assert!(plastic > ideal && (plastic / pressure - 1.0).abs() < 0.02, "{plastic} {pressure} {ideal}");
    assert!((flow.mass_in / rate - 1.0).abs() < 1e-3 && (flow.mass_out / rate - 1.0).abs() < 5e-3, "{flow:?} {rate}");
    assert!(outcome.energy.drift < 1e-3, "{}", outcome.energy.drift);
}

/// Two threads give the bits of one.
#[test]
fn threads_do_not_change_bits() {
    let start = material(100.0, 0.3, 1.0, "*Plastic\n 2., 0.\n 4., 1.\n");
    let deck = bar([40, 160], [1.0, 4.0], &start, 0.01, HELD).replace(" ALL, 2, 1.\n", " ALL, 2, 1.\n I1, 2, 1.5\n");
    let bits = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let (outcome, _, end) = run(&deck);
            let nodes = &end.dofs.nodes;
            let of = |n: usize| [nodes[n].r, nodes[n].z, nodes[n].v_r, nodes[n].v_z, nodes.mass[n]].map(f64::to_bits);
            (outcome.increments, (0..nodes.len()).map(of).collect::<Vec<_>>())
        })
    };
    assert!(bits(1) == bits(2));
}

fn diagnostics(deck: &str) -> String {
    let prepared = job::prepare_text("test.inp", deck, &common::pairs(&[]), &Routines::none());
    prepared.diagnostics.render(&prepared.deck.sources)
}

/// What is not supported is refused, with what would be right.
#[test]
fn unsupported_boundaries_are_refused() {
    let start = material(100.0, 0.3, 1.0, "");
    let deck = bar([2, 4], [1.0, 2.0], &start, 0.1, HELD);
    let contact = deck.replace("*Adaptive Mesh, ", "*Contact Pair\n J0, J1\n*Adaptive Mesh, ");
    let moved = deck.replace(
        "*Adaptive Mesh, ",
        "*Amplitude, name=A\n 0., 0., 1., 1.\n*Boundary, amplitude=A\n J0, 2, 2, 1.\n*Adaptive Mesh, ",
    );
    let part = deck.replace("*Adaptive Mesh, elset=SOLID", "*Adaptive Mesh, elset=EJ0");
    let third = deck.replace("ALL, 1, 2\n", "ALL, 1, 3\n");
    let of_nodes = deck.replace("*Step", "*Surface, name=S, type=NODE, region type=SLIDING\n J0,\n*Step");
    for (deck, words) in [
        (contact, ["P071", "a surface in contact contains an Eulerian boundary"]),
        (moved, ["P071", "is prescribed along the same axis as the place of the mesh"]),
        (part, ["P071", "is prescribed in space, but it must move with the material"]),
        (third, ["M", "1 is r, 2 is z"]),
        (of_nodes, ["M104", "REGION TYPE applies to surfaces of element faces"]),
    ] {
        let found = diagnostics(&deck);
        assert!(words.iter().all(|word| found.contains(word)), "{words:?}: {found}");
    }
    let jump = deck.replace("ALL, 1, 2\n", "ALL, 1, 2, 0.5\n");
    assert!(diagnostics(&jump).contains("M140"), "{}", diagnostics(&jump));
}

/// The ends of a loaded surface follow the material; in a sliding region they move along the boundary. A Lagrangian surface
/// without load keeps its ends with the material.
#[test]
fn region_types_hold_and_free_the_ends() {
    let deck = |surface: &str, load: &str| {
        let cards = format!(
            "*Adaptive Mesh Controls, name=C\n 0., 1., 0.\n*Step\n*Dynamic, Explicit\n , 0.01\n*Adaptive Mesh, elset=SOLID, controls=C, \
             frequency=1\n{load}*Output, history\n*Energy Output\n ALLKE\n*End Step\n"
        );
        // Elements along the side differ in height.
        grid(2, 4, false, |i, j| [i as f64, [0.0, 1.0, 2.5, 3.5, 4.5][j]])
            + &format!("*Elset, elset=SIDE\n 4, 6\n*Surface, name=SIDE{surface}\n SIDE, S2\n")
            + &material(1e4, 0.3, 1.0, "")
            + &cards
    };
    let moved = |surface: &str, load: &str| {
        let (_, before, after) = run(&deck(surface, load));
        // Node at the lower end of the loaded side; waves move it by less than 1e-3.
        (after.dofs.nodes[5].z - before.dofs.nodes[5].z).abs() > 0.05
    };
    assert!(moved("", ""));
    assert!(!moved(", region type=LAGRANGIAN", ""));
    assert!(!moved("", "*Dsload\n SIDE, P, 0.001\n"));
    assert!(moved("", "*Dsload, region type=SLIDING\n SIDE, P, 0.001\n"));
    assert!(!moved("", "*Cload\n 6, 1, 0.001\n"));
    assert!(moved("", "*Cload, region type=SLIDING\n 6, 1, 0.001\n"));
}
