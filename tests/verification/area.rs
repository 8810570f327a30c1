//! Area weighting of elements: spherical symmetry to rounding, the Taylor bar, unsupported combinations.

use std::f64::consts::PI;
use std::fmt::Write as _;

use revolve::job;
use revolve::user::Routines;

use crate::common;
use crate::common::solid::{grid, last, material, run};

/// Returns the relative asymmetry of an imploding beryllium shell (Verney 1968) and its inner radius. The shell reaches
/// from radius 8 to 10, is meshed by equal angles, and the state is that after 40 microseconds. The asymmetry is the
/// largest difference of radial displacement within a shell of nodes over the largest displacement.
fn asymmetry(controls: &str) -> [f64; 2] {
    let n = 8;
    let place = |i: usize, j: usize| {
        let (radius, angle) = (8.0 + 2.0 * i as f64 / n as f64, 0.5 * PI * j as f64 / n as f64);
        [radius * angle.cos(), radius * angle.sin()]
    };
    // Nodes on the axis and on the symmetry plane have coordinates of exactly zero.
    let place = |i: usize, j: usize| if j == n { [0.0, place(i, 0)[0]] } else { place(i, j) };
    let mut deck = grid(n, n, false, place);
    deck =
        deck.replace("*Solid Section, elset=SOLID, material=M", "*Solid Section, elset=SOLID, material=M, controls=C");
    deck += &material(4.41, 0.085, 1.845, "*Plastic\n 0.0033, 0.\n");
    deck = deck.replace("material=M\n", "material=M, controls=C\n");
    write!(deck, "*Section Controls, name=C{controls}\n*Initial Conditions, type=VELOCITY\n").expect("text");
    for j in 0..=n {
        for i in 0..=n {
            let [r, z] = place(i, j);
            let radius = 8.0 + 2.0 * i as f64 / n as f64;
            let v = -0.06 * (8.0 / radius).powi(2) / radius;
            let node = 1 + i + j * (n + 1);
            write!(deck, " {node}, 1, {:e}\n {node}, 2, {:e}\n", v * r, v * z).expect("text");
        }
    }
    deck += "*Step\n*Dynamic, Explicit\n , 40.\n*Boundary\n J0, 2, 2\n J1, 1, 1\n*Output, history, number interval=1\n\
             *Node Output, nset=ALL\n U1, U2\n*End Step\n";
    let (outcome, memory) = run(&deck);
    assert_eq!(outcome.halt, None);
    let radius = |i: usize, j: usize| {
        let [r, z] = place(i, j);
        let node = 1 + i + j * (n + 1);
        let u = |name: &str| last(&deck, &memory, &format!("{name}@{node}"));
        (r + u("U1")).hypot(z + u("U2"))
    };
    let mut worst: f64 = 0.0;
    for i in 0..=n {
        let shell: Vec<f64> = (0..=n).map(|j| radius(i, j)).collect();
        let moved = 8.0 + 2.0 * i as f64 / n as f64 - shell[0];
        worst = shell.iter().map(|s| (s - shell[0]).abs() / moved).fold(worst, f64::max);
    }
    println!(
        "shell{controls}: asymmetry {worst:.1e}, inner radius {:.4}, drift {:.1e}",
        radius(0, 0),
        outcome.energy.drift
    );
    [worst, radius(0, 0)]
}

/// With equal angles, area weighting keeps a sphere symmetric to rounding (Caramana, Burton, Shashkov and Whalen 1998,
/// J. Comput. Phys. 146, 227, section 5); volume weighting does not. Both radii agree within the mesh error.
#[test]
fn area_weighting_keeps_spherical_symmetry() {
    let by_area = asymmetry(", weighting=AREA");
    let by_volume = asymmetry(", weighting=VOLUME");
    assert!(by_area[0] < 1e-10, "{by_area:?}");
    assert!(by_volume[0] > 1e-5, "{by_volume:?}");
    assert!((by_area[1] / by_volume[1] - 1.0).abs() < 0.01, "{by_area:?} {by_volume:?}");
}

/// Other codes: length 21.26 to 21.51 mm, foot radius 6.80 to 7.24 mm.
#[test]
fn taylor_bar_with_area_weighting_matches_other_codes() {
    let text = std::fs::read_to_string(common::project("input/taylor_copper.inp")).expect("the deck");
    let text = text.replace(
        "elset=BAR, material=COPPER\n",
        "elset=BAR, material=COPPER, controls=C\n*Section Controls, name=C, weighting=AREA\n",
    );
    let (outcome, memory) = common::run(&text, &[], &Routines::none());
    assert_eq!(outcome.halt, None);
    let [length, foot] = ["COOR2@TIP", "COOR1@CORNER"].map(|name| 1e3 * last(&text, &memory, name));
    println!("Taylor 10x50 by area: {length:.3} mm, {foot:.3} mm, drift {:.1e}", outcome.energy.drift);
    assert!((21.26..21.55).contains(&length) && (6.80..7.24).contains(&foot), "{length} {foot}");
    // With area weighting the work of the element stress differs slightly from that of the nodal forces.
    assert!(outcome.energy.drift < 2e-2, "{:e}", outcome.energy.drift);
}

#[test]
fn unsupported_area_weighting_is_an_error() {
    let good = grid(1, 1, false, |i, j| [1.0 + i as f64, j as f64]) + &material(1.0, 0.3, 1.0, "");
    let good = good.replace("material=M\n", "material=M, controls=C\n")
        + "*Section Controls, name=C, weighting=AREA\n*Step\n*Dynamic, Explicit\n , 1.\n*End Step\n";
    let codes = |text: &str| {
        let prepared = job::prepare_text("case.inp", text, &[], &Routines::none());
        prepared.diagnostics.iter().map(|d| d.code).collect::<Vec<_>>()
    };
    assert_eq!(codes(&good), [""; 0]);
    let undamped = good.replace(" , 1.\n", " , 1.\n*Bulk Viscosity\n 0., 0.\n");
    let odd = good.replace("weighting=AREA", "weighting=LENGTH");
    let rubber = good.replace("*Elastic\n 1e0, 0.3\n", "*Hyperelastic, neo hooke\n 1., 0.1\n");
    assert!(rubber.contains("neo hooke"), "{rubber}");
    for (text, code) in [(undamped, "P050"), (odd, "M103"), (rubber, "P050")] {
        assert!(codes(&text).contains(&code), "{code}: {:?}", codes(&text));
    }
}
