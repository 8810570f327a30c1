//! Elements in single precision.
//!
//! Goal: the error of single precision is that of its rounding, for any units, element sizes, distances from the origin
//! and velocities. Source: the same run in double precision; closed forms where named. The tolerance and its reason are
//! stated at each test.

use std::f64::consts::PI;

use revolve::user::{LoadFailure, MotionCall, Routines, UserMotion};

use crate::common::solid::{copper_bar, grid, last, material};
use crate::common::spheres::EVEN;
use crate::common::{prepared_in_single, project, run_in_both};

/// Returns final column values in double and in single precision.
fn run_both(deck: &str, names: &[&str]) -> Vec<[f64; 2]> {
    let [double, single] = run_in_both(deck, &[], &Routines::none());
    assert_eq!((&double.0.halt, &single.0.halt), (&None, &None));
    assert_ne!(double.0.digest, single.0.digest, "no element in single precision");
    names.iter().map(|name| [&double.1, &single.1].map(|memory| last(deck, memory, name))).collect()
}

fn relative_difference([a, b]: [f64; 2]) -> f64 {
    (b / a - 1.0).abs()
}

/// Copper bar: length and foot radius within 1e-4; rounding does not grow in plastic flow.
#[test]
fn copper_taylor_bar_matches_double_precision() {
    for (mesh, triangles) in [([13, 61], false), ([10, 50], false), ([9, 40], true)] {
        let deck = copper_bar(mesh, triangles, EVEN);
        for (name, pair) in ["COOR2@TIP", "COOR1@RIM"].iter().zip(run_both(&deck, &["COOR2@TIP", "COOR1@RIM"])) {
            println!("{mesh:?} {name}: {:.1e}", relative_difference(pair));
            assert!(relative_difference(pair) < 1e-4, "{mesh:?} {name}: {pair:?}");
        }
    }
}

/// Returns the copper bar of the decks in other units and sizes: `length` is the unit of length in metres, `pressure`
/// that of stress in pascals, `size` the scale of the bar.
fn scaled_bar(length: f64, pressure: f64, size: f64) -> String {
    let deck = std::fs::read_to_string(project("input/taylor_copper.inp")).expect("the deck");
    // Velocities keep their value in metres per second, so densities follow from the units.
    let density = 8930.0 * length * length / pressure;
    let scaled = [
        ("radius = 3.2e-3", format!("radius = {:e}", 3.2e-3 * size / length)),
        ("length = 32.4e-3", format!("length = {:e}", 32.4e-3 * size / length)),
        ("speed  = 227.", format!("speed = {:e}", 227.0 / length)),
        (" 8930.", format!(" {density:e}")),
        (" 117.e9,", format!(" {:e},", 117e9 / pressure)),
        (" 400.e6, 0.", format!(" {:e}, 0.", 400e6 / pressure)),
        (" 500.e6, 1.", format!(" {:e}, 1.", 500e6 / pressure)),
        (" 600.e6, 2.", format!(" {:e}, 2.", 600e6 / pressure)),
        (" 900.e6, 5.", format!(" {:e}, 5.", 900e6 / pressure)),
        (" , 80.e-6", format!(" , {:e}", 80e-6 * size)),
    ];
    scaled.iter().fold(deck, |deck, (from, to)| {
        assert!(deck.contains(from), "{from}");
        deck.replace(from, to)
    })
}

/// Elements of 10 and 0.3 micrometres and of 300 metres in metres, and of micrometres in millimetres and tonnes: the
/// cube of their volume is between 1e-69 and 1e24. Time scales with the size, so the result is the same.
#[test]
fn single_precision_does_not_depend_on_units_and_sizes() {
    for (length, pressure, size) in [(1.0, 1.0, 0.03), (1.0, 1.0, 1e-3), (1.0, 1.0, 1e6), (1e-3, 1e6, 3e-3)] {
        let deck = scaled_bar(length, pressure, size);
        let names = ["COOR2@TIP", "COOR1@CORNER", "ALLPD", "ALLAE"];
        let found = run_both(&deck, &names);
        for (name, pair) in names.iter().zip(&found) {
            println!("unit {length}, size {size}, {name}: {:.1e}", relative_difference(*pair));
            assert!(relative_difference(*pair) < 1e-5, "unit {length}, size {size}, {name}: {pair:?}");
        }
        // Length of the bar of the deck, 21.44 mm.
        let ratio = found[0][1] * length / (21.44109e-3 * size);
        assert!((ratio - 1.0).abs() < 1e-4, "{ratio}");
    }
}

/// A vibrating bar 1e6 elements away from the origin, moving at 50 times its vibration velocity: coordinate differences
/// are computed in double precision. Each of the 500 increments rounds stresses and strains to 6e-8; distance and speed
/// add nothing.
#[test]
fn single_precision_does_not_depend_on_distance_and_speed() {
    let deck = |away: f64, speed: f64| {
        grid(3, 12, false, |i, j| [0.1 * i as f64, away + 0.1 * j as f64])
            + &material(1.0, 0.3, 1.0, "")
            + "*Nset, nset=AXIS, generate\n 1, 49, 4\n*Nset, nset=TOP\n 52,\n*Nset, nset=FOOT\n 4,\n"
            + &format!("*Initial Conditions, type=VELOCITY\n ALL, 2, {:e}\n J1, 2, {:e}\n", speed, speed + 1e-2)
            + "*Step\n*Dynamic, Explicit, direct user control\n 0.02, 10.\n*Boundary\n AXIS, 1, 1\n\
               *Output, history, number interval=1\n*Node Output, nset=TOP\n U\n*Node Output, nset=FOOT\n U\n\
               *Element Output, elset=SOLID\n S\n*End Step\n"
    };
    let relative = |away: f64, speed: f64| {
        let deck = deck(away, speed);
        let names = ["U2@TOP", "U2@FOOT", "U1@TOP"];
        let pairs = run_both(&deck, &names);
        [0, 1].map(|precision| [pairs[0][precision] - pairs[1][precision], pairs[2][precision]])
    };
    let [here, single] = relative(0.0, 0.0);
    let [_, far] = relative(1e5, 0.5);
    println!("{here:?} {single:?} {far:?}");
    for i in 0..2 {
        assert!((single[i] - here[i]).abs() < 1e-5 * here[0].abs(), "{here:?} {single:?}");
        assert!((far[i] - here[i]).abs() < 1e-5 * here[0].abs(), "{here:?} {far:?}");
    }
}

/// Rotation of a block in the (r, z) plane at a constant rate; the large radius makes the hoop strain negligible.
struct BlockRotation {
    middle: [f64; 2],
    rate: f64,
}

impl UserMotion for BlockRotation {
    fn motion(&mut self, call: &MotionCall<'_>) -> Result<f64, LoadFailure> {
        let node = call.node as usize - 1;
        let arm = [(node % 3) as f64 - 1.0, (node / 3) as f64 - self.middle[1]];
        let (s, c) = (self.rate * call.now.total_time).sin_cos();
        let turned = [c * arm[0] - s * arm[1], s * arm[0] + c * arm[1]];
        Ok(turned[call.dof - 1] - arm[call.dof - 1])
    }
}

/// Ten turns at a radius of 1e6 elements: the stress rotates with the block, and the strain is that of the rings
/// (1e-6). Each of the 2000 increments rounds the stress to 6e-8.
#[test]
fn distant_rigid_rotation_rotates_the_stress() {
    let (radius, turns) = (1e6, 10.25);
    let deck = grid(2, 2, false, |i, j| [radius - 1.0 + i as f64, j as f64])
        + &material(1.0, 0.3, 1.0, "*Elset, elset=ONE\n 1,\n")
        + "*Initial Conditions, type=STRESS\n SOLID, 1., -0.5, 0.25, 0.3\n"
        + &format!("*Step\n*Dynamic, Explicit, direct user control\n 5.e-3, {turns}\n")
        + "*Bulk Viscosity\n 0., 0.\n*Boundary, user\n ALL, 1, 2\n*Output, history, number interval=1\n\
           *Element Output, elset=ONE\n S, LE\n*End Step\n";
    let routines = || Routines::none().with_motion(BlockRotation { middle: [radius, 0.5], rate: 2.0 * PI });
    let [_, (outcome, memory)] = run_in_both(&deck, &[], &routines());
    assert_eq!(outcome.halt, None);
    let prepared = prepared_in_single(&deck, &[], &routines());
    let value = |name: &str| {
        let at = prepared.plan.columns.iter().position(|c| c.name == format!("{name}@ONE")).expect("a column");
        memory.rows.last().expect("a row").1[at]
    };
    // A quarter turn in addition to whole turns exchanges rr and zz and changes the sign of the shear.
    for (name, expected) in [("S11", -0.5), ("S22", 1.0), ("S33", 0.25), ("S12", -0.3), ("LE11", 0.0), ("LE12", 0.0)] {
        println!("{name}: {:.1e}", value(name) - expected);
        assert!((value(name) - expected).abs() < 2e-5, "{name} {} {expected}", value(name));
    }
}
