//! Deformable bodies against answers from outside the code.
//!
//! Goal: stress, motion and energies of axisymmetric solids: equilibrium of patches, waves, pressure vessels, Taylor bars.
//! Source: closed forms of elasticity and plasticity (Lame; Hill 1950), wave speeds, and the results of other codes where
//! there is no closed form. Each test says its tolerance and why.

mod common;

use std::f64::consts::PI;
use std::fmt::Write as _;

use common::Memory;
use common::solid::{column, grid, last, material, run};
use revolve::job;
use revolve::solve::{self, Outcome};
use revolve::user::{LoadFailure, LoadPoints, Routines, UserLoad};

/// A distorted patch that touches the axis.
fn distorted(i: usize, j: usize) -> [f64; 2] {
    let shift = |a: usize, b: usize| if (1..3).contains(&a) && (1..3).contains(&b) { 0.2 } else { 0.0 };
    let sign = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
    [i as f64 + shift(i, j) * sign(i + j), 0.7 * j as f64 + shift(i, j) * sign(i)]
}

#[test]
fn a_distorted_patch_under_uniform_pressure_is_in_equilibrium() {
    let pressure = |surfaces: &[&str]| surfaces.iter().map(|s| format!(" {s}, P, 3.\n")).collect::<String>();
    let deck = grid(3, 3, false, distorted)
        + &material(1000.0, 0.3, 1.0, "")
        + "*Initial Conditions, type=STRESS\n SOLID, -3., -3., -3., 0.\n*Step\n*Dynamic, Explicit\n , 1.\n*Dsload\n"
        + &pressure(&["I1", "J0", "J1"])
        + "*Output, field, number interval=1\n*Node Output\n A\n*Element Output\n S\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert!(outcome.halt.is_none() && outcome.increments > 30, "{:?}", outcome.halt);
    for frame in &memory.frames {
        let acceleration = &frame.point_fields[0].values;
        // Rounding of a force of 3 on a mass of order 1.
        assert!(acceleration.iter().all(|a| a.abs() < 1e-12), "{acceleration:?}");
    }
    let stress = &memory.frames.last().expect("a frame").cell_fields.iter().find(|f| f.name == "S").expect("S").values;
    for s in stress.chunks(4) {
        assert!(s[..3].iter().all(|x| (x + 3.0).abs() < 1e-12) && s[3].abs() < 1e-12, "{s:?}");
    }
}

/// Linear velocity fields give uniform strain rates, in quadrilaterals and in triangles: v_r = a r, v_z = b z.
#[test]
fn a_distorted_patch_stretches_uniformly() {
    for triangles in [false, true] {
        let mut deck = grid(3, 3, triangles, distorted) + &material(1000.0, 0.25, 1.0, "");
        deck += "*Initial Conditions, type=VELOCITY\n";
        for n in 0..16 {
            let [r, z] = distorted(n % 4, n / 4);
            write!(deck, " {}, 1, {:e}\n {}, 2, {:e}\n", n + 1, 1e-3 * r, n + 1, 2e-3 * z).expect("text");
        }
        deck += "*Step\n*Dynamic, Explicit, direct user control\n 1.e-4, 1.e-4\n*Bulk Viscosity\n 0., 0.\n\
                 *Output, field, number interval=1\n*Element Output\n S\n*End Step\n";
        let (outcome, memory) = run(&deck);
        assert!(outcome.halt.is_none());
        let stress = &memory.frames.last().expect("a frame").cell_fields[0].values;
        // lambda = 400, mu = 400: strains 1e-7 in r and hoop, 2e-7 in z, from rates at the middle of the increment.
        let (lambda, mu) = (400.0, 400.0);
        let trace = 4e-7;
        for s in stress.chunks(4) {
            for (got, strain) in s[..3].iter().zip([1e-7, 2e-7, 1e-7]) {
                let expected = lambda * trace + 2.0 * mu * strain;
                assert!((got / expected - 1.0).abs() < 1e-6, "{got} {expected}");
            }
            assert!(s[3].abs() < 1e-13, "{s:?}");
        }
    }
}

/// Uniaxial strain: every node moves along z only; stress behind the front and speed of the front.
/// A displacement counts from the start of its step: what one step moved, the next may hold where it is, or move on.
#[test]
fn a_displacement_counts_from_the_start_of_its_step() {
    let step = |cards: &str| {
        format!(
            "*Step\n*Dynamic, Explicit, element by element\n , 1.\n*Boundary, {cards}\n*Output, history, frequency=1\n\
             *Node Output, nset=ONE\n U2\n*End Step\n"
        )
    };
    let deck = grid(2, 2, false, |i, j| [i as f64, j as f64])
        + &material(
            100.0,
            0.3,
            1.0,
            "*Nset, nset=ONE\n 2\n*Amplitude, name=RAMP, definition=SMOOTH STEP\n 0., 0., 1., 1.\n",
        )
        + &step("amplitude=RAMP\n J0, 2, 2, 0.5")
        + &step("op=NEW\n J0, 2, 2")
        + &step("op=NEW, amplitude=RAMP\n J0, 2, 2, 0.25");
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    let u = column(&deck, &memory, "U2@ONE");
    for (time, expected) in [(1.0, 0.5), (1.5, 0.5), (2.0, 0.5), (3.0, 0.75)] {
        let at = u.iter().rfind(|row| row.0 <= time + 1e-12).expect("a row").1;
        assert!((at - expected).abs() < 1e-12, "U2 = {at} at {time}, not {expected}");
    }
    let energy = outcome.energy;
    // Four elements under ramps of some ten increments: the balance is of second order.
    assert!(energy.drift < 2e-2, "drift {:e}", energy.drift);
}

#[test]
fn a_strain_wave_has_its_stress_and_its_speed() {
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
    // c_L = 6175.478 m/s, stress 167.3555 MPa, lateral stress nu/(1 - nu) of it.
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

/// Energies of an elastic bar without damping, over a million increments. The motion is so small that it is linear: what
/// the change of geometry does to the balance goes with the strain, here 1e-11.
#[test]
fn an_undamped_elastic_bar_keeps_its_energy() {
    let mut deck = grid(2, 4, false, |i, j| [i as f64, j as f64]) + &material(1.0, 0.3, 1.0, "");
    deck += "*Initial Conditions, type=VELOCITY\n J1, 2, 1.e-11\n";
    deck += "*Step\n*Dynamic, Explicit, direct user control\n 0.2, 200000.\n*Bulk Viscosity\n 0., 0.\n*Boundary\n J0, 2, 2\n\
             *Output, history, number interval=1000\n*Energy Output\n ALLKE, ALLIE, ETOTAL\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert_eq!((outcome.halt, outcome.increments), (None, 1_000_000));
    let internal = column(&deck, &memory, "ALLIE");
    assert!(internal.iter().any(|e| e.1 > 0.1 * outcome.energy.initial), "energy goes to and fro");
    println!("elastic bar, 1e6 increments: drift {:.1e}", outcome.energy.drift);
    assert!(outcome.energy.drift < 1e-10, "{:e}", outcome.energy.drift);
}

/// A thick sphere between a = 10 and b = 20 mm, a quarter of its section, pressed from inside by a slow ramp.
fn sphere(radial: usize, around: usize, pressure: f64, plastic: &str) -> String {
    let place = |i: usize, j: usize| {
        let radius = 10.0 * (1.0 + i as f64 / radial as f64);
        let angle = 0.5 * PI * j as f64 / around as f64;
        let [r, z] = [radius * angle.cos(), radius * angle.sin()];
        // The last ray lies on the axis, to the last bit.
        if j == around { [0.0, radius] } else { [r, z] }
    };
    grid(radial, around, false, place)
        + &material(200e3, 0.3, 7.85e-9, plastic)
        + "*Amplitude, name=RAMP, definition=SMOOTH STEP\n 0., 0., 3.e-4, 1.\n*Nset, nset=INNER\n 1,\n"
        + &format!("*Nset, nset=OUTER\n {},\n", radial + 1)
        + "*Step\n*Dynamic, Explicit\n , 4.e-4\n*Boundary\n J0, 2, 2\n"
        + &format!("*Dsload, amplitude=RAMP\n I0, P, {pressure}\n")
        + "*Output, history, number interval=100\n*Node Output, nset=INNER\n U1\n*Node Output, nset=OUTER\n U1\n*Energy Output\n ALLKE\n*End Step\n"
}

/// Mean of a column over its last fifth: what is left of the vibration goes to and fro.
fn settled(text: &str, memory: &Memory, name: &str) -> f64 {
    let values = column(text, memory, name);
    let tail = &values[values.len() - values.len() / 5..];
    tail.iter().map(|v| v.1).sum::<f64>() / tail.len() as f64
}

#[test]
fn a_thick_sphere_converges_to_lame_with_order_two() {
    let mut errors = Vec::new();
    for n in [5, 10, 20] {
        let deck = sphere(n, 2 * n, 1.0, "");
        let (outcome, memory) = run(&deck);
        assert!(outcome.halt.is_none(), "{:?}", outcome.halt);
        assert!(outcome.energy.drift < 2e-3, "{}", outcome.energy.drift);
        // u(a) = 4.000 um, u(b) = 1.5 um for 100 MPa; pressed with 1 MPa, for the closed form is that of small strains.
        errors.push([
            settled(&deck, &memory, "U1@INNER") / 4e-5 - 1.0,
            settled(&deck, &memory, "U1@OUTER") / 1.5e-5 - 1.0,
        ]);
    }
    let order = (errors[1][0] / errors[2][0]).abs().log2();
    println!("Lame sphere: errors {errors:?}, order {order:.2}");
    assert!((order - 2.0).abs() < 0.3, "order {order}: {errors:?}");
    assert!(errors[2].iter().all(|e| e.abs() < 3e-3), "{errors:?}");
}

/// Hill's sphere: perfectly plastic, the plastic front at c = 15 mm for p = 358.90406 MPa, outer displacement 8.859375 um.
#[test]
fn hills_sphere_yields_to_its_radius() {
    // A hundred times as stiff and as dense: the same wave speeds and stresses, and strains as small as the theory's.
    let deck = sphere(20, 30, 358.90406, "*Plastic\n 300., 0.\n")
        .replace("2e5, 0.3", "2e7, 0.3")
        .replace("7.85e-9", "7.85e-7");
    assert!(deck.contains("2e7, 0.3") && deck.contains("7.85e-7"));
    let (outcome, memory) = run(&deck);
    assert!(outcome.halt.is_none());
    let outer = settled(&deck, &memory, "U1@OUTER");
    println!("Hill sphere: u(b) = {:.4} um (8.8594)", outer * 1e5);
    // Mesh of h = 0.5 mm: the front is known to half an element, and u(b) goes with c^3.
    assert!((outer / 8.859375e-5 - 1.0).abs() < 1e-2, "{outer}");
}

/// A thick cylinder in plane strain, a = 10 and b = 20 mm: u(a) = 9.53333 um for 100 MPa. Pressed with 1 MPa, for the closed
/// form is that of small strains.
#[test]
fn a_thick_cylinder_is_lames_on_every_mesh() {
    let mut errors = Vec::new();
    for n in [10, 20] {
        let deck = grid(n, 1, false, |i, j| [10.0 + 10.0 * i as f64 / n as f64, j as f64])
            + &material(200e3, 0.3, 7.85e-9, "")
            + "*Amplitude, name=RAMP, definition=SMOOTH STEP\n 0., 0., 3.e-4, 1.\n*Nset, nset=INNER\n 1,\n*Step\n*Dynamic, Explicit\n , 4.e-4\n\
               *Boundary\n ALL, 2, 2\n*Dsload, amplitude=RAMP\n I0, P, 1.\n*Output, history, number interval=100\n*Node Output, nset=INNER\n U1\n*End Step\n";
        let (outcome, memory) = run(&deck);
        assert!(outcome.halt.is_none());
        errors.push(settled(&deck, &memory, "U1@INNER") / 9.53333e-5 - 1.0);
    }
    println!("Lame cylinder: errors {errors:?}");
    // Mean quadrature meets this solution, A r + B/r, at the nodes on every mesh; what is left is the strain of 1e-5.
    assert!(errors.iter().all(|e| e.abs() < 3e-5), "{errors:?}");
}

fn taylor(settings: &[(&str, &str)]) -> (Outcome, revolve::output::HistorySummary) {
    let mut prepared =
        job::prepare(&common::project("input/taylor_copper.inp"), &common::pairs(settings), &Routines::none());
    assert!(!prepared.diagnostics.has_errors());
    job::run_in_memory(&mut prepared)
}

/// Other codes: length 21.26 to 21.51 mm, foot radius 6.80 to 7.24 mm; OpenRadioss on 20x100: 21.428 and 7.169 mm.
#[test]
fn the_copper_taylor_bar_is_that_of_other_codes() {
    for (nr, nz, length, foot) in [("10", "50", 21.46, 7.11), ("20", "100", 21.428, 7.169)] {
        let (outcome, history) = taylor(&[("nr", nr), ("nz", nz)]);
        assert!(outcome.halt.is_none(), "{:?}", outcome.halt);
        let got = [history.0["COOR2@TIP"].last * 1e3, history.0["COOR1@CORNER"].last * 1e3];
        println!("Taylor {nr}x{nz}: L {:.3} mm, R {:.3} mm, drift {:.1e}", got[0], got[1], outcome.energy.drift);
        assert!((got[0] - length).abs() < 0.05 && (got[1] - foot).abs() < 0.05, "{got:?}");
        assert!(outcome.energy.drift < 2e-3, "{}", outcome.energy.drift);
        let element = outcome.steps[0].limiting_element.as_deref().expect("an element limits the increment");
        assert!(element.parse::<u32>().is_ok());
    }
}

/// ABAQUS's default, the global estimate, takes fewer increments than going element by element and comes to the same bar.
/// Elastic vibration, in which an estimate holds for good, needs one.
#[test]
fn the_global_estimate_saves_increments_and_changes_no_answer() {
    let deck = std::fs::read_to_string(common::project("input/taylor_copper.inp")).expect("the deck");
    let by_elements = deck.replace("*Dynamic, Explicit", "*Dynamic, Explicit, element by element");
    let [(global, a), (local, b)] = [&deck, &by_elements].map(|text| common::run(text, &[], &Routines::none()));
    assert_eq!((&global.halt, &local.halt), (&None, &None));
    let ratio = global.increments as f64 / local.increments as f64;
    let estimates = global.steps[0].global_estimates.expect("a count");
    println!("Taylor 10x50: {ratio:.3} of the increments, {estimates} estimates");
    // sqrt(1/2) would be squares at all times; elements start twice as long as wide and end flattened.
    assert!((0.71..0.93).contains(&ratio), "{ratio}");
    assert!((2..100).contains(&estimates) && local.steps[0].global_estimates.is_none());
    for name in ["COOR2@TIP", "COOR1@CORNER"] {
        let [x, y] = [(&by_elements, &b), (&deck, &a)].map(|(deck, memory)| last(deck, memory, name));
        // The error of the increments, second order, of a flow that is smooth in time.
        assert!((x / y - 1.0).abs() < 1e-3, "{name}: {x} {y}");
    }
    let elastic = grid(6, 6, false, |i, j| [1.0 + i as f64, j as f64])
        + &material(1.0, 0.3, 1.0, "")
        + "*Initial Conditions, type=VELOCITY\n J0, 2, 1.e-6\n";
    let run = |option: &str| run(&format!("{elastic}*Step\n*Dynamic, Explicit{option}\n , 500.\n*End Step\n")).0;
    let (global, local) = (run(""), run(", element by element"));
    assert_eq!((global.halt, global.steps[0].global_estimates), (None, Some(1)));
    let ratio = global.increments as f64 / local.increments as f64;
    println!("elastic squares: {ratio:.3} of the increments, drift {:.1e}", global.energy.drift);
    // sqrt(1/2) for the squares of a plane.
    assert!((0.7..0.76).contains(&ratio), "{ratio}");
    assert!(global.energy.drift < 2e-3, "{:e}", global.energy.drift);
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    // More elements than it takes to spread them.
    let digest = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let text = std::fs::read_to_string(common::project("input/taylor_copper.inp")).expect("the deck");
            let text = text.replace(" , 80.e-6", " , 0.3e-6");
            let (outcome, memory) = common::run(&text, &[("nr", "50"), ("nz", "200")], &Routines::none());
            assert!(outcome.halt.is_none() && outcome.increments > 20);
            let rows: Vec<u64> = memory.rows.iter().flat_map(|r| r.1.iter().map(|v| v.to_bits())).collect();
            let frame = memory.frames.last().expect("a frame");
            let fields = frame.point_fields.iter().chain(&frame.cell_fields);
            (outcome.increments, rows, fields.flat_map(|f| f.values.iter().map(|v| v.to_bits())).collect::<Vec<u64>>())
        })
    };
    let one = digest(1);
    for threads in [2, 5] {
        assert!(one == digest(threads), "{threads} threads");
    }
}

/// Johnson-Cook with rate and heat on one element that is compressed at a constant rate: the yield stress by hand.
#[test]
fn johnson_cook_with_heat_by_hand() {
    let cards = "*Plastic, hardening=JOHNSON COOK\n 806., 614., 0.168, 1.1, 1540., 20.\n*Rate Dependent, type=JOHNSON COOK\n 0.0089, 1.\n\
                 *Inelastic Heat Fraction\n 0.9,\n*Specific Heat\n 4.6e8,\n";
    // Uniform motion v_z = -1000 z, v_r free: the element is tiny, so inertia does not matter.
    let deck = grid(1, 1, false, |i, j| [1e-3 * i as f64, 1e-3 * j as f64])
        + &material(206e3, 0.3, 7.83e-9, cards)
        + "*Initial Conditions, type=TEMPERATURE\n ALL, 20.\n*Step\n*Dynamic, Explicit, adiabatic\n , 3.e-4\n*Boundary\n J0, 2, 2\n\
           *Boundary, type=VELOCITY\n J1, 2, 2, -1.\n*Output, history, number interval=300\n*Element Output, elset=SOLID\n MISES, PEEQ, TEMP, S11\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert!(outcome.halt.is_none(), "{:?}", outcome.halt);
    let [mises, strain, heat] = ["MISES", "PEEQ", "TEMP"].map(|n| column(&deck, &memory, &format!("{n}@SOLID")));
    // Temperature by quadrature of the plastic work along the hand-written law, rate by differences of the strain.
    let law = |p: f64, rate: f64, t: f64| {
        (806.0 + 614.0 * p.powf(0.168))
            * (1.0 + 0.0089 * rate.ln().max(0.0))
            * (1.0 - ((t - 20.0) / 1520.0).max(0.0).powf(1.1))
    };
    let mut temperature = 20.0;
    for k in 1..strain.len() {
        let (dp, dt) = (strain[k].1 - strain[k - 1].1, strain[k].0 - strain[k - 1].0);
        temperature += 0.9 / (7.83e-9 * 4.6e8) * 0.5 * (mises[k].1 + mises[k - 1].1) * dp;
        if k > 10 && dp > 0.0 {
            let expected = law(strain[k].1, dp / dt, heat[k].1);
            assert!((mises[k].1 / expected - 1.0).abs() < 2e-3, "row {k}: {} {expected}", mises[k].1);
        }
    }
    let got = heat.last().expect("a row").1;
    assert!(got > 60.0 && ((got - 20.0) / (temperature - 20.0) - 1.0).abs() < 5e-3, "{got} {temperature}");
}

struct Constant;

impl UserLoad for Constant {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        // The normal is shown outward in `normal_r`, and into the solid in `directions`.
        let n = pressure.len();
        assert!(points.normal_r.iter().zip(&points.directions[..n]).all(|(a, b)| *a == -b));
        pressure.fill(100.0 * points.amplitude);
        Ok(())
    }
}

#[test]
fn a_user_load_on_faces_is_a_pressure() {
    let deck = sphere(5, 10, 100.0, "");
    let user = deck.replace("I0, P, 100", "I0, PNU");
    let (a, _) = run(&deck);
    let (b, _) = common::run(&user, &[], &Routines::none().with_load(Constant));
    assert_eq!((a.halt, b.halt), (None, None));
    assert_eq!(a.energy.work.to_bits(), b.energy.work.to_bits());
}

/// A stiff disc that deforms, driven into a target that is not meshed, goes as deep as a rigid one: the closed form of
/// m dV/dt = -pi a^2 (A Y + C rho V^2).
#[test]
fn a_deformable_projectile_enters_the_same_target() {
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
    // The speed of the whole, from its kinetic energy; the disc rings a little.
    let got = (2.0 * last(&deck, &memory, "ALLKE") / (PI * a * a * m)).sqrt();
    assert!((got - expected).abs() < 0.01 * (v - expected), "{got} {expected}");
    // Nothing is done from outside: what is lost opens the cavity, but for what the disc stores.
    let energy = outcome.energy;
    let lost = 0.5 * PI * a * a * m * (v * v - expected * expected);
    assert_eq!(energy.friction, 0.0);
    assert!(energy.work.abs() < 1e-6 * lost, "{energy:?}");
    assert!((energy.cavity / lost - 1.0).abs() < 0.01 && energy.drift < 2e-3, "{energy:?} {lost}");
}

/// A cone that deforms, driven by a given velocity into a target with friction: the work of the cavity and of friction
/// are those of the pressure and of mu times it along the sides, F_n V and F_t V with F_t / F_n = mu / tan(half angle).
#[test]
fn friction_in_a_target_is_booked_as_friction() {
    let (n, mu, v) = (8, 0.3, 300e3);
    // A frustum of the half angle 45 degrees, its flat faces loaded by nothing.
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
    // Moved without a change of shape: sigma = 4 Y + rho (V/sqrt 2)^2 on the sides, whose projected area is pi (12^2 - 2^2).
    let sigma = 400.0 + 2.7e-9 * 0.5 * v * v;
    let cavity = sigma * PI * (144.0 - 4.0) * v * 4e-6;
    let energy = outcome.energy;
    println!("cone: ALLCAV {:e} of {cavity:e}, ALLFD over it {:.6}", energy.cavity, energy.friction / energy.cavity);
    assert!((energy.cavity / cavity - 1.0).abs() < 1e-6, "{energy:?} {cavity}");
    assert!((energy.friction / energy.cavity / mu - 1.0).abs() < 1e-6, "{energy:?}");
    // What moves the cone does all of it.
    assert!((energy.work / (energy.cavity + energy.friction) - 1.0).abs() < 1e-6 && energy.drift < 1e-6, "{energy:?}");
}

/// With a fixed increment it turns inside out; an automatic one adapts until nothing is left of the element.
#[test]
fn an_element_that_turns_inside_out_halts_the_run_with_its_name() {
    for (card, code) in [("\n , 1.", "R209"), (", direct user control\n 1.e-3, 1.", "R206")] {
        let deck = grid(3, 3, false, |i, j| [1.0 + i as f64, j as f64])
            + &material(1000.0, 0.3, 1.0, "*Plastic\n 1., 0.\n")
            + &format!("*Initial Conditions, type=VELOCITY\n 6, 1, 4000.\n*Step\n*Dynamic, Explicit{card}\n")
            + "*Output, field, number interval=100\n*Node Output\n U\n*End Step\n";
        let (outcome, memory) = run(&deck);
        let halt = outcome.halt.expect("a halt");
        assert_eq!(halt.code, code);
        for part in ["element ", "increment", "time"] {
            assert!(halt.reason.contains(part), "{}", halt.reason);
        }
        let frame = memory.frames.last().expect("a frame");
        assert!(frame.point_fields.iter().all(|f| f.values.iter().all(|v| v.is_finite())));
    }
}

#[test]
fn bad_solids_are_refused_with_a_reason() {
    let good = grid(1, 1, false, |i, j| [i as f64, j as f64])
        + &material(1000.0, 0.3, 1.0, "")
        + "*Step\n*Dynamic, Explicit\n , 1.\n*End Step\n";
    let cases = [
        ("M123", good.replace(" 1, 1, 2, 4, 3\n", " 1, 1, 3, 4, 2\n")),
        ("P013", good.replace("*Density\n 1e0,\n", "")),
        ("P001", good.replace("*Solid Section, elset=SOLID, material=M\n", "")),
        ("P014", good.replace("*Step", "*Plastic\n 1., 0.\n 2., 0.\n*Step")),
    ];
    let two = good.replace("*End Step\n", "*End Step\n*Step\n*Dynamic, Explicit, adiabatic\n , 1.\n*End Step\n");
    for (code, text) in cases.into_iter().chain([("P015", two)]) {
        assert_ne!(text, good, "{code}");
        let prepared = job::prepare_text("bad.inp", &text, &[], &Routines::none());
        assert!(
            prepared.diagnostics.iter().any(|d| d.code == code),
            "{code}: {}",
            prepared.diagnostics.render(&prepared.deck.sources)
        );
    }
}

/// Hourglass controls keep a bar that is excited in its hourglass pattern together.
#[test]
fn every_hourglass_control_keeps_the_pattern_small() {
    for control in ["STIFFNESS", "VISCOUS", "COMBINED", "ENHANCED"] {
        let mut deck = grid(4, 8, false, |i, j| [10.0 + i as f64, j as f64]) + &material(1000.0, 0.3, 1.0, "");
        deck = deck.replace("material=M\n", "material=M, controls=C\n");
        deck += &format!("*Section Controls, name=C, hourglass={control}\n");
        deck += "*Initial Conditions, type=VELOCITY\n";
        for n in 0..45 {
            let sign = if (n % 5 + n / 5) % 2 == 0 { 1.0 } else { -1.0 };
            writeln!(deck, " {}, 2, {}", n + 1, 0.01 * sign).expect("text");
        }
        deck += "*Step\n*Dynamic, Explicit\n , 20.\n*Output, history, number interval=100\n*Node Output, nset=ALL\n U2\n*Energy Output\n ALLAE\n*End Step\n";
        let mut prepared = common::prepared(&deck, &[], &Routines::none());
        let mut memory = Memory::default();
        let outcome = solve::run(&mut prepared.plan, &mut memory);
        assert!(outcome.halt.is_none(), "{control}: {:?}", outcome.halt);
        let largest = memory.rows.iter().flat_map(|r| r.1.iter().take(45)).fold(0.0f64, |m, u| m.max(u.abs()));
        // Without control the pattern would reach v t = 0.2.
        assert!(largest < 0.05, "{control}: {largest}");
        assert!(outcome.energy.artificial > 0.0, "{control}");
    }
}

/// Gravity on a set of elements acts on triangles, too.
#[test]
fn gravity_on_a_set_of_triangles_is_gravity() {
    let fall = |elements: &str| {
        let deck = grid(2, 2, true, |i, j| [i as f64, j as f64])
            + &material(100.0, 0.3, 1.0, "*Nset, nset=ONE\n 5\n")
            + &format!("*Step\n*Dynamic, Explicit\n , 1.\n*Dload\n {elements}, GRAV, 9.81, 0., -1.\n")
            + "*Output, history, frequency=1\n*Node Output, nset=ONE\n V2\n*End Step\n";
        let (outcome, memory) = run(&deck);
        assert_eq!(outcome.halt, None);
        last(&deck, &memory, "V2@ONE")
    };
    assert!((fall("SOLID") / -9.81 - 1.0).abs() < 1e-12);
    assert_eq!(fall("SOLID").to_bits(), fall("").to_bits());
}
