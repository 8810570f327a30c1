//! Six-node triangles (CAX6M).
//!
//! Goal: uniform stress on any mesh, convergence for Lame's vessels, limit loads without locking, agreement with
//! quadrilaterals for the Taylor bar, contact on faces of two segments, element deletion, identical bits on any number
//! of threads.
//! Source: closed forms (Lame; Hill 1950, The Mathematical Theory of Plasticity, chapter V), balances, the same scenes
//! with quadrilaterals. The tolerance and its reason are stated at each test.

use std::f64::consts::PI;
use std::fmt::Write as _;

use revolve::job;
use revolve::solve::Outcome;
use revolve::user::Routines;

use crate::common::bodies::{self, assembly, cell_field, elastic, part, point_field, rigid_line};
use crate::common::solid::{column, copper_bar, grid, in_six_node_triangles, last, material, run};
use crate::common::spheres;
use crate::common::{RecordedOutput, at_nodes};
use crate::vessels::{mean_of_last_fifth, sphere};

fn run_complete(deck: &str) -> (Outcome, RecordedOutput) {
    let (outcome, memory) = run(deck);
    assert_eq!(outcome.halt, None, "{:?}", outcome.halt);
    (outcome, memory)
}

/// A ring with irregular nodes whose boundary has a velocity linear in r and z: every point has the uniform stress, and
/// the free inner nodes follow the linear motion. Without bulk viscosity, which depends on element size.
#[test]
fn linear_motion_gives_uniform_stress_on_any_mesh() {
    let (n, m, rates) = (6, 8, [2e-3, -3e-3]);
    let wobble = |i: usize| 0.2 * (((i * 7919) % 101) as f64 / 101.0 - 0.5);
    let place = |i: usize, j: usize| {
        let inside = (1..n).contains(&i) && (1..m).contains(&j);
        let off = if inside { [wobble(i + 13 * j), wobble(7 * i + j + 3)] } else { [0.0; 2] };
        [i as f64 + off[0], j as f64 + off[1]]
    };
    let mut deck = in_six_node_triangles(&grid(n, m, false, place), [n, m]) + &material(1.0, 0.3, 1.0, "");
    let (mut start, mut driven) = (String::new(), String::new());
    for (i, j) in (0..=m).flat_map(|j| (0..=n).map(move |i| (i, j))) {
        let (node, at) = (1 + i + j * (n + 1), place(i, j));
        for axis in 0..2 {
            writeln!(start, " {node}, {}, {:e}", axis + 1, rates[axis] * at[axis]).expect("text");
            if i == 0 || i == n || j == 0 || j == m {
                writeln!(driven, " {node}, {}, {}, {:e}", axis + 1, axis + 1, rates[axis] * at[axis]).expect("text");
            }
        }
    }
    write!(deck, "*Initial Conditions, type=VELOCITY\n{start}").expect("text");
    write!(deck, "*Step\n*Dynamic, Explicit\n , 5.\n*Bulk Viscosity\n 0., 0.\n*Boundary, type=VELOCITY\n{driven}")
        .expect("text");
    deck += "*Output, field, number interval=1\n*Node Output\n U\n*Element Output\n S, LE\n*End Step\n";
    let ran = bodies::run(&deck).whole();
    let (frame, stretch) = (ran.end(), rates.map(|rate| 1.0 + 5.0 * rate));
    let strain = [stretch[0].ln(), stretch[1].ln(), stretch[0].ln()];
    let (lame, shear) = (0.3 / (1.3 * 0.4), 1.0 / 2.6);
    let expected = strain.map(|e| lame * strain.iter().sum::<f64>() + 2.0 * shear * e);
    let stress = cell_field(frame, "S");
    let worst = stress.chunks(4).flat_map(|s| [s[0] - expected[0], s[1] - expected[1], s[2] - expected[2], s[3]]);
    let worst = worst.fold(0.0, |most: f64, x| most.max(x.abs()));
    let moved = at_nodes(&ran.prepared, point_field(frame, "U"));
    let start = &ran.prepared.state.dofs.nodes.start;
    let off =
        start.iter().zip(&moved).flat_map(|(p, u)| [0, 1].map(|axis| (u[axis] - 5.0 * rates[axis] * p[axis]).abs()));
    let off = off.fold(0.0, f64::max);
    println!("uniform strain: error of the stress {worst:.1e} of {:.1e}, of nodes {off:.1e}", expected[1]);
    // Increment strains add up to logarithmic strains to second order; node positions are exact to rounding.
    assert!(worst < 1e-5 * expected[1].abs(), "{worst:e} {expected:?}");
    assert!(off < 1e-12, "{off:e}");
}

/// Thick sphere of `vessels.rs`: displacements of second order, as with quadrilaterals on the same nodes.
#[test]
fn thick_sphere_converges_to_lame_with_second_order() {
    let mut errors = Vec::new();
    for n in [4, 8, 16] {
        let deck = in_six_node_triangles(&sphere(n, 2 * n, 1.0, ""), [n, 2 * n]);
        let (outcome, memory) = run_complete(&deck);
        assert!(outcome.energy.drift < 2e-3, "{}", outcome.energy.drift);
        errors.push([
            mean_of_last_fifth(&deck, &memory, "U1@INNER") / 4e-5 - 1.0,
            mean_of_last_fifth(&deck, &memory, "U1@OUTER") / 1.5e-5 - 1.0,
        ]);
    }
    let order = (errors[1][0] / errors[2][0]).abs().log2();
    println!("Lame sphere of CAX6M: errors {errors:?}, order {order:.2}");
    assert!(order > 1.6, "order {order}: {errors:?}");
    assert!(errors[2].iter().all(|e| e.abs() < 5e-3), "{errors:?}");
}

/// Nearly incompressible thick cylinder in plane strain: u(a) = (1 + nu) p a / E (b^2 + (1 - 2 nu) a^2) / (b^2 - a^2).
#[test]
fn nearly_incompressible_cylinder_does_not_lock() {
    let nu = 0.499;
    let exact = (1.0 + nu) * 10.0 / 200e3 * (400.0 + (1.0 - 2.0 * nu) * 100.0) / 300.0;
    let mut errors = Vec::new();
    for n in [2, 4, 8] {
        let deck = grid(n, 2, false, |i, j| [10.0 + 10.0 * i as f64 / n as f64, j as f64])
            + &material(200e3, nu, 7.85e-9, "")
            + "*Amplitude, name=RAMP, definition=SMOOTH STEP\n 0., 0., 3.e-4, 1.\n*Nset, nset=INNER\n 1,\n*Step\n*Dynamic, Explicit\n , 4.e-4\n\
               *Boundary\n ALL, 2, 2\n*Dsload, amplitude=RAMP\n I0, P, 1.\n*Output, history, number interval=100\n*Node Output, nset=INNER\n U1\n*End Step\n";
        let deck = in_six_node_triangles(&deck, [n, 2]);
        let (_, memory) = run_complete(&deck);
        errors.push(mean_of_last_fifth(&deck, &memory, "U1@INNER") / exact - 1.0);
    }
    let order = (errors[1] / errors[2]).abs().log2();
    println!("nearly incompressible cylinder of CAX6M: errors {errors:?}, order {order:.2}");
    assert!(order > 1.5, "order {order}: {errors:?}");
    assert!(errors[2].abs() < 2e-3, "{errors:?}");
}

/// Returns the work of the pressure over that of 2 Y ln(b/a) in a fully plastic thick sphere from 1 to 2 whose wall
/// moves outward by 3 %; Poisson's ratio 0.4999.
fn limit_load_of_sphere(n: usize) -> f64 {
    let (m, out) = (2 * n, 0.03);
    let place = |i: usize, j: usize| {
        let (radius, angle) = (1.0 + i as f64 / n as f64, 0.5 * PI * j as f64 / m as f64);
        if j == m { [0.0, radius] } else { [radius * angle.cos(), radius * angle.sin()] }
    };
    let mut deck = in_six_node_triangles(&grid(n, m, false, place), [n, m]);
    deck += &material(1000.0, 0.4999, 1.0, "*Plastic\n 1., 0.\n");
    deck += "*Amplitude, name=A, definition=smooth step\n 0., 0., 20., 1.\n*Step\n*Dynamic, Explicit\n , 20.\n";
    deck += "*Boundary\n J0, 2, 2\n J1, 1, 1\n*Boundary, amplitude=A\n";
    for j in 0..=m {
        let [r, z] = place(0, j).map(|x| out * x);
        if j < m {
            writeln!(deck, " {}, 1, 1, {r:e}", 1 + j * (n + 1)).expect("text");
        }
        if j > 0 {
            writeln!(deck, " {}, 2, 2, {z:e}", 1 + j * (n + 1)).expect("text");
        }
    }
    deck += "*Output, history, number interval=2\n*Energy Output\n ALLWK\n*End Step\n";
    let (outcome, memory) = run_complete(&deck);
    let work = column(&deck, &memory, "ALLWK");
    let [middle, end] = [0.5 * out, out].map(|u| 1.0 + u);
    let volume = 2.0 / 3.0 * PI * (end.powi(3) - middle.powi(3));
    let of_limit = |a: f64| 2.0 * ((7.0 + a.powi(3)).cbrt() / a).ln();
    let ratio = (work[2].1 - work[1].1) / volume / (0.5 * (of_limit(middle) + of_limit(end)));
    println!("sphere of CAX6M, {n} rays: {ratio:.4} of the limit load, drift {:.1e}", outcome.energy.drift);
    assert!(outcome.energy.drift < 1e-3, "{:e}", outcome.energy.drift);
    ratio
}

#[test]
fn plastic_sphere_converges_to_its_limit_load() {
    let over = [6, 8].map(|n| limit_load_of_sphere(n) - 1.0);
    // The load is an upper bound that decreases with the mesh; with locking it would be many times larger.
    assert!(over[0].abs() < 0.1 && over[1].abs() < 0.8 * over[0].abs(), "{over:?}");
}

/// Copper bar with 10x50 quadrilaterals, and with half as many cells of six-node triangles on the same nodes.
#[test]
fn taylor_bar_of_six_node_triangles_matches_quadrilaterals() {
    let quadrilaterals = copper_bar([10, 50], false, spheres::EVEN);
    let triangles = in_six_node_triangles(&quadrilaterals, [10, 50]);
    let [quads, triangles] = [quadrilaterals, triangles].map(|deck| {
        let (outcome, memory) = run_complete(&deck);
        let found = ["COOR2@TIP", "COOR1@RIM"].map(|name| last(&deck, &memory, name));
        println!("bar: {found:?}, {} increments, drift {:.1e}", outcome.increments, outcome.energy.drift);
        assert!(outcome.energy.drift < 5e-3, "{}", outcome.energy.drift);
        found
    });
    // Coarser cells with one diagonal direction: the same bound as for three-node triangles in `triangles.rs`.
    for (q, t) in quads.iter().zip(triangles) {
        assert!((t / q - 1.0).abs() < 0.03, "{quads:?} {triangles:?}");
    }
}

/// A bar of six-node triangles thrown at a rigid wall, and at a bar at rest: momentum is conserved to rounding, energy
/// to the error of the increments.
#[test]
fn contact_of_six_node_triangles_conserves_momentum_and_energy() {
    let block = |name: &str, from: f64| part(name, [4, 8], |i, j| [0.25 * i as f64, from + 0.25 * j as f64], "");
    let bar = in_six_node_triangles(&block("BAR", 0.0), [4, 8]);
    let speed = -1e-2;
    let step = "*Step\n*Dynamic, Explicit\n , 8.\n";
    let output = |request: &str| format!("*Output, history, frequency=1\n{request}\n*End Step\n");
    let least = |ran: &bodies::DeckRun, variable: &str| {
        let columns = ran.prepared.plan.columns.iter().filter(|c| c.name.starts_with(variable));
        let values: Vec<f64> = columns.flat_map(|c| ran.column(&c.name)).map(|row| row[1]).collect();
        assert!(!values.is_empty(), "{variable}");
        values.into_iter().fold(f64::INFINITY, f64::min)
    };
    let thrown = format!("*Initial Conditions, type=VELOCITY\n BAR.ALL, 2, {speed}\n");
    let at_wall = bar.clone()
        + &rigid_line("WALL", &[[0.0, -0.002], [3.0, -0.002]], "")
        + &assembly(&["BAR", "WALL"], "*Rigid Body, ref node=WALL.REF, elset=WALL.E\n")
        + &elastic("BAR", [1.0, 0.3, 1.0], "")
        + &thrown
        + step
        + "*Boundary\n WALL.REF, 2, 2\n*Contact Pair\n BAR.J0, WALL.SKIN\n"
        + &output("*Node Output, nset=BAR.J0\n COOR2");
    let wall = bodies::run(&at_wall).whole();
    let quads = bodies::run(&at_wall.replace(&bar, &block("BAR", 0.0))).whole();
    let depth_of_quads = -0.002 - least(&quads, "COOR2@");
    let before = speed * 2.0 * PI;
    let depth = -0.002 - least(&wall, "COOR2@");
    println!(
        "thrown at a wall: momentum {:.3e} of {before:.3e}, drift {:.1e} ({:.1e} of quadrilaterals), nodes {depth:.1e} below it \
         ({depth_of_quads:.1e} of quadrilaterals)",
        wall.momentum(),
        wall.outcome.energy.drift,
        quads.outcome.energy.drift
    );
    // Contact allows the penetration of one increment's acceleration: smaller than that of quadrilaterals.
    assert!(depth < depth_of_quads, "{depth:e} {depth_of_quads:e}");
    assert!(wall.momentum() > -0.5 * before, "no rebound: {}", wall.momentum());
    assert!(wall.outcome.energy.drift < 2e-3, "{}", wall.outcome.energy.drift);
    let at_bar = bar.clone()
        + &block("REST", -2.002)
        + &assembly(&["BAR", "REST"], "")
        + &elastic("BAR", [1.0, 0.3, 1.0], "")
        + &elastic("REST", [1.0, 0.3, 1.0], "")
        + &thrown
        + step
        + "*Contact Pair\n BAR.J0, REST.J1\n"
        + &output("*Contact Output, nset=BAR.J0\n COPEN");
    let both = bodies::run(&at_bar).whole();
    let of_quads = bodies::run(&at_bar.replace(&bar, &block("BAR", 0.0))).whole();
    let halved = bodies::run(&at_bar.replace("*Dynamic, Explicit\n", "*Dynamic, Explicit, scale factor=0.5\n")).whole();
    let [gap, gap_of_quads] = [&both, &of_quads].map(|ran| least(ran, "COPEN@"));
    // Contact closes the weighted mean gap of each node; 1e-3 of the displacement of an increment remains.
    let way = -speed * 8.0 / both.outcome.increments as f64;
    let [drift, drift_of_quads, halved] = [both, of_quads, halved].map(|ran| {
        assert!((ran.momentum() / before - 1.0).abs() < 1e-10, "{}", ran.momentum() / before);
        ran.outcome.energy.drift
    });
    println!(
        "thrown at a bar: drift {drift:.1e}, {halved:.1e} with half the increments, {drift_of_quads:.1e} of quadrilaterals; \
         least gap {gap:.1e}, {gap_of_quads:.1e} of quadrilaterals"
    );
    assert!(gap > -1e-3 * way, "{gap:e} {way:e}");
    // Second order in the increment, and less than with quadrilaterals on the same nodes.
    assert!(halved < 0.4 * drift && drift < drift_of_quads, "{halved} {drift} {drift_of_quads}");
    let general = at_bar.replace("*Contact Pair\n BAR.J0, REST.J1\n", "*Contact\n*Contact Inclusions, all exterior\n");
    let all = bodies::run(&general).whole();
    assert!((all.momentum() / before - 1.0).abs() < 1e-10, "{}", all.momentum() / before);
}

/// A bar that fails at its foot, and a bar with mass scaling.
#[test]
fn six_node_triangles_support_deletion_and_mass_scaling() {
    let failing =
        copper_bar([8, 40], false, spheres::EVEN).replace(" 700., 3.\n", " 700., 3.\n*Shear Failure\n 0.5,\n");
    let (outcome, _) = run_complete(&in_six_node_triangles(&failing, [8, 40]));
    println!("failing bar: {} deleted, drift {:.1e}", outcome.deleted, outcome.energy.drift);
    assert!(outcome.deleted > 0 && outcome.energy.drift < 1e-2, "{}", outcome.energy.drift);
    let scaled = copper_bar([8, 40], false, spheres::EVEN)
        .replace("*Boundary\n AXIS", "*Fixed Mass Scaling, type=BELOW MIN, dt=1.e-7\n*Boundary\n AXIS");
    let (outcome, _) = run_complete(&in_six_node_triangles(&scaled, [8, 40]));
    println!("scaled bar: {} increments, added {:?}", outcome.increments, outcome.steps[0].added_mass);
    assert!(outcome.steps[0].added_mass.is_some_and(|mass| mass > 0.0));
}

/// Enough elements for several threads, and a step split in two.
#[test]
fn threads_and_steps_change_no_bit() {
    let deck = in_six_node_triangles(&copper_bar([40, 120], false, spheres::EVEN), [40, 120])
        .replace(" , 80.e-6", " , 0.4e-6");
    let bits = |deck: &str, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let (outcome, memory) = run_complete(deck);
            assert!(outcome.increments > 20, "{}", outcome.increments);
            memory.rows.iter().flat_map(|row| row.1.iter().map(|v| v.to_bits())).collect::<Vec<u64>>()
        })
    };
    let one = bits(&deck, 1);
    for threads in [2, 5] {
        assert!(one == bits(&deck, threads), "{threads} threads");
    }
}

/// Materials without a shear modulus, hourglass controls that the element does not have.
#[test]
fn unsupported_sections_are_errors_with_a_place() {
    let mesh = in_six_node_triangles(&grid(2, 2, false, |i, j| [1.0 + i as f64, j as f64]), [2, 2]);
    let step = "*Step\n*Dynamic, Explicit\n , 1.\n*End Step\n";
    let elastic = "*Elastic\n 1., 0.3\n*Section Controls, name=C";
    for (law, what) in [
        ("*Eos, type=USUP\n 1., 1., 0.\n*Section Controls, name=C\n", "without a shear modulus"),
        (&format!("{elastic}, hourglass=ENHANCED\n"), "HOURGLASS"),
    ] {
        let head = "*Solid Section, elset=SOLID, material=M, controls=C\n*Material, name=M\n*Density\n 1.,\n";
        let prepared = job::prepare_text("test.inp", &(mesh.clone() + head + law + step), &[], &Routines::none());
        let message = prepared.diagnostics.render(&prepared.deck.sources);
        assert!(message.contains("P024") && message.contains(what) && message.contains("test.inp:"), "{message}");
    }
}
