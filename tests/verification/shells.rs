//! Axisymmetric shells (SAX1).
//!
//! Goal: bending, stretching, transverse shear, vibration and plasticity of thin-shell theory, also at the axis; loads,
//! boundary conditions and outputs as documented; conservation of energy.
//! Source: Timoshenko and Woinowsky-Krieger, Theory of Plates and Shells (circular plates; ring load on a long
//! cylinder); Leissa, Vibration of Plates, NASA SP-160 (frequencies); membrane theory of spheres; Hopkins and Wang
//! 1954, J. Mech. Phys. Solids 3, 117 (limit loads of circular von Mises plates); equation of motion of a thin ring.
//! ABAQUS Analysis User's Guide 29.6.1 (normals, sides, pressure), 29.6.5 (`*SHELL SECTION`), 34.3.1 (boundary
//! conditions by name).
//! Tolerance: 0.5 % on the finest mesh, after the order is asserted.

use std::f64::consts::PI;
use std::fmt::Write as _;

use crate::common::solid::{column, grid, last, material, run};
use crate::common::{self, RecordedOutput};
use revolve::job;
use revolve::user::Routines;

const YOUNG: f64 = 200e9;
const RATIO: f64 = 0.3;
const DENSITY: f64 = 7800.0;

/// Returns shells along a line of points, with node sets A and B at its ends.
pub(crate) fn shell_line(places: &[[f64; 2]], section: &str, material: &str) -> String {
    let mut text = String::from("*Node, nset=ALL\n");
    for (i, [r, z]) in places.iter().enumerate() {
        writeln!(text, " {}, {r:.17e}, {z:.17e}", i + 1).expect("text");
    }
    text += "*Element, type=SAX1, elset=SHELL\n";
    for i in 1..places.len() {
        writeln!(text, " {i}, {i}, {}", i + 1).expect("text");
    }
    let last = places.len();
    writeln!(text, "*Nset, nset=A\n 1\n*Nset, nset=B\n {last}\n*Elset, elset=E1\n 1").expect("text");
    if last > 2 {
        text += "*Elset, elset=E2\n 2\n";
    }
    text + section + &format!("*Material, name=M\n*Density\n {DENSITY},\n*Elastic\n {YOUNG:e}, {RATIO}\n{material}")
}

fn section(thickness: f64) -> String {
    format!("*Shell section, elset=SHELL, material=M\n {thickness}, 5\n")
}

pub(crate) fn step(time: f64, cards: &str, outputs: &str) -> String {
    format!(
        "*Step\n*Dynamic, explicit\n , {time:e}\n{cards}*Output, history, number interval=2000\n{outputs}*End step\n"
    )
}

/// Returns a smooth amplitude over part of the step; the remaining vibration is below 1e-4 of the static deflection.
pub(crate) fn smooth_amplitude(time: f64) -> String {
    format!("*Amplitude, name=SLOWLY, definition=SMOOTH STEP\n 0., 0., {time:e}, 1.\n")
}

/// Returns the mean of a column over the last quarter of the rows.
pub(crate) fn static_value(text: &str, memory: &RecordedOutput, name: &str) -> f64 {
    let rows = column(text, memory, name);
    let tail = &rows[rows.len() * 3 / 4..];
    tail.iter().map(|r| r.1).sum::<f64>() / tail.len() as f64
}

/// Returns the frequency from the first and last falling zero crossing of a column.
fn frequency(text: &str, memory: &RecordedOutput, name: &str) -> f64 {
    let rows = column(text, memory, name);
    let falls = rows.windows(2).filter(|w| w[0].1 > 0.0 && w[1].1 <= 0.0);
    let times: Vec<f64> = falls.map(|w| w[0].0 + (w[1].0 - w[0].0) * w[0].1 / (w[0].1 - w[1].1)).collect();
    (times.len() - 1) as f64 / (times[times.len() - 1] - times[0])
}

#[track_caller]
pub(crate) fn assert_close(what: &str, found: f64, expected: f64, tolerance: f64) {
    assert!((found / expected - 1.0).abs() < tolerance, "{what}: {found}, expected {expected}");
}

/// Asserts second-order convergence on successively refined meshes, down to changes of 2e-4, and an error below 0.5 %
/// on the finest.
#[track_caller]
fn assert_convergence(what: &str, found: &[f64; 3], expected: f64) {
    let [first, second] = [found[1] - found[0], found[2] - found[1]].map(|d| (d / expected).abs());
    assert!(second < 0.4 * first || second < 2e-4, "{what}: {found:?}, expected {expected}");
    assert_close(what, found[2], expected, 5e-3);
}

fn bending_stiffness(thickness: f64) -> f64 {
    YOUNG * thickness.powi(3) / (12.0 * (1.0 - RATIO * RATIO))
}

/// Returns the transverse shear stiffness of the section.
fn shear_stiffness(thickness: f64) -> f64 {
    5.0 / 6.0 * YOUNG / (2.0 * (1.0 + RATIO)) * thickness
}

fn plate_deck(n: usize, edge: &str) -> String {
    let places: Vec<[f64; 2]> = (0..=n).map(|i| [0.1 * i as f64 / n as f64, 0.0]).collect();
    shell_line(&places, &section(2e-3), "") + &format!("*Boundary\n A, XSYMM\n B, {edge}\n")
}

/// Clamped and simply supported plates under slowly increasing pressure: deflection and moment in the middle, where the
/// error is largest. Transverse shear adds p a^2/(4 K) to the deflection, here 0.2 and 0.05 %.
#[test]
fn plate_deflection_matches_theory() {
    let (a, p) = (0.1_f64, 100.0);
    let unit = p * a.powi(4) / (64.0 * bending_stiffness(2e-3));
    for (edge, factor, moment) in [
        ("ENCASTRE", 1.0, p * a * a * (1.0 + RATIO) / 16.0),
        ("1, 2", (5.0 + RATIO) / (1.0 + RATIO), p * a * a * (3.0 + RATIO) / 16.0),
    ] {
        let of = |n: usize| {
            let text = plate_deck(n, edge)
                + &smooth_amplitude(0.02)
                + &step(
                    0.03,
                    &format!("*Dload, amplitude=SLOWLY\n SHELL, P, {p}\n"),
                    "*Node output, nset=A\n U2, UR3\n*Element output, elset=E1\n SM\n*Energy output\n ETOTAL, ALLWK\n",
                );
            let (outcome, memory) = run(&text);
            assert_eq!(outcome.halt, None);
            assert_eq!(last(&text, &memory, "UR3@A"), 0.0);
            assert!(last(&text, &memory, "ETOTAL").abs() < 1e-9 * last(&text, &memory, "ALLWK"));
            ["U2@A", "SM1@E1"].map(|name| static_value(&text, &memory, name))
        };
        let found = [10, 20, 40].map(of);
        let shear = p * a * a / (4.0 * shear_stiffness(2e-3));
        assert_convergence("deflection", &found.map(|f| f[0]), unit * factor + shear);
        assert_close("thin plate", found[2][0], unit * factor, 5e-3);
        // P acts along the upward normal and stretches that side in the middle.
        assert_close("moment", found[2][1], moment, 1e-2);
    }
}

/// Sudden pressure: the plate vibrates about the static deflection up to about twice its value (exactly twice for a
/// single mode).
#[test]
fn suddenly_loaded_plate_vibrates_about_static_deflection() {
    let text =
        plate_deck(40, "ENCASTRE") + &step(20.0 / 498.286, "*Dload\n SHELL, P, 100.\n", "*Node output, nset=A\n U2\n");
    let (_, memory) = run(&text);
    let rows = column(&text, &memory, "U2@A");
    let still = 100.0 * 0.1_f64.powi(4) / (64.0 * bending_stiffness(2e-3));
    assert_close("mean", rows.iter().map(|r| r.1).sum::<f64>() / rows.len() as f64, still, 1e-2);
    let most = rows.iter().map(|r| r.1).fold(0.0, f64::max);
    assert!(most > 1.95 * still && most < 2.2 * still, "{most} {still}");
}

/// Returns the Bessel functions J0 and I0 by their series.
fn bessel(x: f64, sign: f64) -> f64 {
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..60 {
        term *= sign * 0.25 * x * x / f64::from(k * k);
        sum += term;
    }
    sum
}

#[test]
fn plate_frequencies_match_theory() {
    for (edge, root, expected) in [("ENCASTRE", 3.196_220_6, 498.286), ("1, 2", 2.221_519_4, 240.715)] {
        let ratio = bessel(root, -1.0) / bessel(root, 1.0);
        let of = |n: usize| {
            let mut text = plate_deck(n, edge) + "*Initial conditions, type=VELOCITY\n";
            for i in 0..n {
                let x = root * i as f64 / n as f64;
                writeln!(text, " {}, 2, {:e}", i + 1, 1e-4 * (bessel(x, -1.0) - ratio * bessel(x, 1.0))).expect("text");
            }
            text += &step(8.4 / expected, "*Bulk viscosity\n 0., 0.\n", "*Node output, nset=A\n U2\n");
            let (_, memory) = run(&text);
            frequency(&text, &memory, "U2@A")
        };
        assert_convergence(edge, &[10, 20, 40].map(of), expected);
    }
}

/// Returns deflection and moment of a long cylinder under a ring load with transverse shear, which thin-shell theory
/// neglects. The model is a Timoshenko beam on its elastic foundation, w'''' - k/S w'' + k/D w = 0, with zero rotation
/// and half the load as shear at the load.
fn ring_load(radius: f64, thickness: f64, load: f64) -> [f64; 2] {
    let (d, k) = (bending_stiffness(thickness), YOUNG * thickness / (radius * radius));
    let s = shear_stiffness(thickness);
    let (a, b2) = (0.5 * k / s, (0.25 * k / d).sqrt());
    let (alpha, gamma) = ((b2 + 0.5 * a).sqrt(), (b2 - 0.5 * a).sqrt());
    let slope = [-alpha, gamma];
    let third = [3.0 * alpha * gamma * gamma - alpha.powi(3), 3.0 * alpha * alpha * gamma - gamma.powi(3)];
    let turn = [0, 1].map(|i| slope[i] + d / s * (third[i] - k / s * slope[i]));
    let determinant = slope[0] * turn[1] - slope[1] * turn[0];
    let shear = -0.5 * load / s;
    let (cosine, sine) = (shear * turn[1] / determinant, -shear * turn[0] / determinant);
    let bent = cosine * (alpha * alpha - gamma * gamma) - 2.0 * alpha * gamma * sine - k / s * cosine;
    [cosine, -d * bent]
}

/// Half of a long cylinder under a ring load, compared with the theory with shear, and with thin-shell theory for a
/// thin wall.
#[test]
fn ring_load_on_a_cylinder_matches_theory() {
    let load = 10e3;
    let of = |n: usize, thickness: f64, length: f64| {
        let places: Vec<[f64; 2]> = (0..=n).map(|i| [0.1, length * i as f64 / n as f64]).collect();
        let text = shell_line(&places, &section(thickness), "")
            + "*Boundary\n A, YSYMM\n"
            + &smooth_amplitude(3e-3)
            + &step(
                4e-3,
                &format!("*Cload, amplitude=SLOWLY\n A, 1, {:e}\n", 0.5 * 2.0 * PI * 0.1 * load * (thickness / 2e-3)),
                "*Node output, nset=A\n U1, RM3\n*Element output, elset=E1\n SM\n*Element output, elset=E2\n SM\n",
            );
        let (_, memory) = run(&text);
        ["U1@A", "SM1@E1", "SM1@E2", "RM3@A"].map(|name| static_value(&text, &memory, name))
    };
    let kirchhoff = |thickness: f64, load: f64| {
        let beta = (3.0 * (1.0 - RATIO * RATIO)).powf(0.25) / (0.1 * thickness).sqrt();
        load * beta * 0.01 / (2.0 * YOUNG * thickness)
    };
    assert_close("closed form", ring_load(0.1, 2e-7, load)[0], kirchhoff(2e-7, load), 1e-4);
    let [deflection, moment] = ring_load(0.1, 2e-3, load);
    assert_close("the reference without shear", kirchhoff(2e-3, load), 11.361_500e-6, 1e-6);
    assert_close("shear", deflection, kirchhoff(2e-3, load), 2e-2);
    let found = [40, 80, 160].map(|n| of(n, 2e-3, 0.1));
    assert_convergence("deflection", &found.map(|f| f[0]), deflection);
    // The normal of a cylinder whose elements run upward points inward. Value at the load extrapolated from two element
    // centres.
    assert_convergence("moment", &found.map(|f| 1.5 * f[1] - 0.5 * f[2]), -moment);
    assert_close("reaction", found[2][3].abs(), moment * 2.0 * PI * 0.1, 1e-2);
    // A tenth of the thickness and load: thin-shell theory.
    assert_close("thin", of(80, 2e-4, 0.04)[0], kirchhoff(2e-4, 0.1 * load), 5e-3);
}

#[test]
fn breathing_frequencies_match_theory() {
    let cylinder = |cards: &str, n: usize| {
        let places: Vec<[f64; 2]> = (0..=n).map(|i| [0.1, 0.02 * i as f64 / n as f64]).collect();
        shell_line(&places, &section(2e-3), "") + "*Initial conditions, type=VELOCITY\n ALL, 1, 1.e-3\n" + cards
    };
    let breathe = |text: &str, expected: f64| {
        let text = text.to_owned()
            + &step(
                8.4 / expected,
                "*Bulk viscosity\n 0., 0.\n",
                "*Node output, nset=A\n U1\n*Node output, nset=B\n U1, U2\n",
            );
        let (_, memory) = run(&text);
        (frequency(&text, &memory, "U1@B"), text, memory)
    };
    assert_close("ring", breathe(&cylinder("", 1), 8059.1238).0, 8059.1238, 2e-3);
    assert_close("plane strain", breathe(&cylinder("*Boundary\n ALL, 2, 2\n", 4), 8448.2573).0, 8448.2573, 2e-3);
    let sphere = |n: usize| {
        let angle = |i: usize| 0.5 * PI * i as f64 / n as f64;
        let places: Vec<[f64; 2]> =
            (0..=n).map(|i| [if i == 0 { 0.0 } else { 0.1 * angle(i).sin() }, 0.1 * angle(i).cos()]).collect();
        let mut text = shell_line(&places, &section(2e-4), "")
            + "*Boundary\n A, XSYMM\n B, YSYMM\n*Initial conditions, type=VELOCITY\n";
        for i in 0..=n {
            writeln!(text, " {}, 1, {:e}\n {}, 2, {:e}", i + 1, 1e-3 * angle(i).sin(), i + 1, 1e-3 * angle(i).cos())
                .expect("text");
        }
        breathe(&text, 13_622.405_6).0
    };
    assert_convergence("sphere", &[10, 20, 40].map(sphere), 13_622.405_6);
}

/// Closed sphere under internal pressure: u = p R^2 (1 - nu) / (2 E t) everywhere, including the pole.
#[test]
fn pressurized_sphere_matches_membrane_theory() {
    let (radius, thickness, p) = (0.1, 1e-3, 1e4);
    let of = |n: usize| {
        let angle = |i: usize| 0.5 * PI * i as f64 / n as f64;
        let places: Vec<[f64; 2]> =
            (0..=n).map(|i| [if i == 0 { 0.0 } else { radius * angle(i).sin() }, radius * angle(i).cos()]).collect();
        let text = shell_line(&places, &section(thickness), "")
            + "*Boundary\n A, XSYMM\n B, YSYMM\n"
            + &smooth_amplitude(4e-3)
            // From the pole to the equator the normal points outward, and P acts along it.
            + &step(5e-3, &format!("*Dload, amplitude=SLOWLY\n SHELL, P, {p}\n"), "*Node output, nset=A\n U2\n*Node output, nset=B\n U1\n*Element output, elset=E1\n SF, S, S_SNEG, S_SPOS\n");
        let (_, memory) = run(&text);
        ["U2@A", "U1@B", "SF1@E1", "SF2@E1", "S11@E1"].map(|name| static_value(&text, &memory, name))
    };
    let found = [10, 20, 40].map(of);
    let expected = p * radius * radius * (1.0 - RATIO) / (2.0 * YOUNG * thickness);
    assert_convergence("pole", &found.map(|f| f[0]), expected);
    assert_convergence("equator", &found.map(|f| f[1]), expected);
    for i in [2, 3] {
        assert_close("section force at the pole", found[2][i], 0.5 * p * radius, 2e-2);
    }
}

/// Shallow clamped spherical cap under a sudden pressure of 600 psi with plastic flow (Nagarajan and Popov 1974,
/// Comput. Struct. 4, 1117; radius 22.27 in, thickness 0.41 in, half-angle 26.67 degrees). The apex deflection is
/// compared with that of solid elements. Shells neglect terms of the order of thickness over radius, 2 %.
#[test]
fn spherical_cap_matches_solid_elements() {
    let (radius, thickness, angle, time) = (22.27, 0.41, 26.67_f64.to_radians(), 1e-3);
    let flows = "*Plastic\n 24000., 0.\n 234000., 1.\n";
    let steps = |loads: &str, apex: &str| {
        format!(
            "*Step\n*Dynamic, explicit\n , {time:e}\n{loads}*Output, history, number interval=400\n*Node output, nset={apex}\n U2\n\
             *Energy output\n ALLPD\n*End step\n"
        )
    };
    let history = |text: &str, name: &str| -> Vec<f64> {
        let (outcome, memory) = run(text);
        assert_eq!(outcome.halt, None);
        assert!(outcome.energy.plastic > 0.0 && outcome.energy.drift < 1e-2, "{:e}", outcome.energy.drift);
        column(text, &memory, name).iter().map(|row| row.1).collect()
    };
    let shells = |n: usize| {
        let at = |i: usize| angle * i as f64 / n as f64;
        let places: Vec<[f64; 2]> =
            (0..=n).map(|i| [if i == 0 { 0.0 } else { radius * at(i).sin() }, radius * at(i).cos()]).collect();
        let text = shell_line(&places, &format!("*Shell section, elset=SHELL, material=M\n {thickness}, 9\n"), flows)
            .replace(&format!(" {DENSITY},\n"), " 2.45e-4,\n")
            .replace(&format!(" {YOUNG:e},"), " 10.5e6,");
        // From the pole on the normal points outward.
        history(&(text + "*Boundary\n A, XSYMM\n B, ENCASTRE\n" + &steps("*Dload\n SHELL, P, -600.\n", "A")), "U2@A")
    };
    let solids = |through: usize, along: usize| {
        let text = grid(through, along, false, |i, j| {
            let (s, turn) =
                (radius + thickness * (i as f64 / through as f64 - 0.5), angle * (1.0 - j as f64 / along as f64));
            [if j == along { 0.0 } else { s * turn.sin() }, s * turn.cos()]
        });
        let apex = 1 + through / 2 + along * (through + 1);
        let text = text + &material(10.5e6, 0.3, 2.45e-4, flows) + &format!("*Nset, nset=APEX\n {apex}\n");
        let held = "*Boundary\n J0, 1, 2\n*Dsload\n I1, P, 600.\n";
        history(&(text + &steps(held, "APEX")), "U2@APEX")
    };
    let apart = |a: &[f64], b: &[f64]| {
        let largest = b.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
        let square: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>() / b.len() as f64;
        square.sqrt() / largest
    };
    let [coarse, middle, fine] = [16, 32, 64].map(shells);
    let [thick, whole] = [[4, 60], [8, 120]].map(|[n, m]| solids(n, m));
    let [first, second] = [apart(&coarse, &fine), apart(&middle, &fine)];
    let between = apart(&fine, &whole);
    let least = |u: &[f64]| u.iter().copied().fold(0.0, f64::min);
    println!(
        "spherical cap: shells {first:.2e}, {second:.2e} from the finest, which is {between:.2e} from solids ({:.2e} on half as \
         many); apex {:.5} and {:.5}",
        apart(&thick, &whole),
        least(&fine),
        least(&whole)
    );
    assert!(second < 0.6 * first && second < 1e-2, "{first} {second}");
    assert!(between < 2e-2, "{between}");
    assert_close("largest deflection", least(&fine), least(&whole), 2e-2);
}

/// Numbers of section points: 1 is the side SNEG, the last one SPOS, and S without a number is at the middle one.
#[test]
fn section_point_numbers_and_names_agree() {
    let with = |output: &str| {
        let cards = "*Dload, amplitude=SLOWLY\n SHELL, P, 100.\n";
        let text = plate_deck(10, "ENCASTRE") + &smooth_amplitude(2e-3) + &step(3e-3, cards, output);
        let (_, memory) = run(&text);
        let prepared = common::prepared(&text, &[], &Routines::none());
        let names: Vec<String> = prepared.plan.columns.iter().map(|c| c.name.clone()).collect();
        (names, memory.rows.last().expect("a row").1.clone())
    };
    let by_number = with("*Element output, elset=E1\n 1, 3, 5\n S11, MISES, S12\n");
    let by_name = with("*Element output, elset=E1\n S11_SNEG, S11, S11_SPOS, MISES_SNEG, MISES, MISES_SPOS, S12\n");
    let find = |found: &(Vec<String>, Vec<f64>), name: &str| {
        let at = found.0.iter().position(|n| n == name).unwrap_or_else(|| panic!("{name} among {:?}", found.0));
        found.1[at]
    };
    for name in ["S11_SNEG", "S11", "S11_SPOS", "MISES_SNEG", "MISES", "MISES_SPOS"] {
        let [number, own] = [&by_number, &by_name].map(|found| find(found, &format!("{name}@E1")));
        assert!(number == own && (number != 0.0), "{name}: {number} {own}");
    }
    // Bending: tension on one side, compression on the other.
    let [below, above] = ["S11_SNEG@E1", "S11_SPOS@E1"].map(|name| find(&by_number, name));
    assert!(below * above < 0.0, "{below} {above}");
    let refused = |output: &str| error_codes(&(plate_deck(10, "ENCASTRE") + &step(3e-3, "", output)));
    assert_eq!(refused("*Element output, elset=E1\n 2,\n S\n"), ["M104"]);
    assert!(refused("*Element output, elset=E1\n 1, 5\n S\n").is_empty());
}

/// Perfectly plastic von Mises plates carry 6.51 M/a^2 simply supported and 12.5 M/a^2 clamped, with M = Y t^2/4.
#[test]
fn plate_limit_loads_match_theory() {
    let (a, t, yields) = (0.1_f64, 4e-3, 20e6);
    for (edge, factor) in [("1, 2", 6.51), ("ENCASTRE", 12.5)] {
        let limit = factor * 0.25 * yields * t * t / (a * a);
        let rises = |share: f64| {
            let places: Vec<[f64; 2]> = (0..=40).map(|i| [a * f64::from(i) / 40.0, 0.0]).collect();
            let section = format!("*Shell section, elset=SHELL, material=M\n {t}, 9\n");
            let text = shell_line(&places, &section, &format!("*Plastic\n {yields:e}, 0.\n"))
                + &format!("*Boundary\n A, XSYMM\n B, {}\n", edge.replace("1, 2", "2, 2"))
                + &smooth_amplitude(8e-3)
                + &step(
                    0.012,
                    &format!("*Dload, amplitude=SLOWLY\n SHELL, P, {:e}\n", share * limit),
                    "*Node output, nset=A\n U2, V2\n",
                );
            let (_, memory) = run(&text);
            last(&text, &memory, "U2@A")
        };
        let elastic = limit * a.powi(4) / (64.0 * bending_stiffness(t)) * if factor < 7.0 { 4.08 } else { 1.0 };
        let [below, above] = [0.97, 1.04].map(rises);
        assert!(below < 4.0 * elastic && above > 2.0 * below, "{edge}: {below} {above} {elastic}");
    }
}

/// Ring with outward velocity, Johnson-Cook law with heating: compared with its equation of motion integrated in small
/// steps.
#[test]
fn johnson_cook_ring_matches_its_equation_of_motion() {
    let [a, b, n, m, c, rate0, melt, reference] = [90e6, 292e6, 0.31, 1.09, 0.025, 1.0, 1356.0, 293.0];
    let (speed, time, radius) = (100.0, 60e-6, 0.02);
    let text = shell_line(&[[radius, 0.0], [radius, 1e-3]], &section(1e-3), &format!(
        "*Plastic, hardening=JOHNSON COOK\n {a:e}, {b:e}, {n}, {m}, {melt}, {reference}\n*Rate dependent, type=JOHNSON COOK\n {c}, {rate0}\n*Specific heat\n 385.,\n*Inelastic heat fraction\n 0.9\n"))
        + &format!("*Initial conditions, type=VELOCITY\n ALL, 1, {speed}\n*Initial conditions, type=TEMPERATURE\n ALL, {reference}\n")
        + &step(time, "*Bulk viscosity\n 0., 0.\n", "*Node output, nset=A\n U1, V1\n*Element output, elset=E1\n PEEQ, TEMP, S22, STH\n*Energy output\n ETOTAL, ALLKE, ALLPD\n")
            .replace("*Dynamic, explicit", "*Dynamic, explicit, adiabatic");
    let (_, memory) = run(&text);
    let [moved, strain, temperature] = ["U1@A", "PEEQ@E1", "TEMP@E1"].map(|name| last(&text, &memory, name));
    assert!(last(&text, &memory, "ETOTAL") > 0.0);
    // r'' = -s A/(rho A0 r0); plastic flow keeps the volume, A = A0 r0/r, after the elastic part.
    let (mut r, mut v, mut s, mut p, mut heat) = (radius, speed, 0.0_f64, 0.0_f64, reference);
    let dt = 1e-11;
    for _ in 0..(time / dt).round() as usize {
        let rate = v / r;
        let yields = |strain: f64, rate: f64, heat: f64| {
            let factor = if rate > rate0 { 1.0 + c * (rate / rate0).ln() } else { 1.0 };
            let theta = ((heat - reference) / (melt - reference)).max(0.0);
            (a + b * strain.powf(n)) * factor * (1.0 - theta.powf(m))
        };
        let trial = s + YOUNG * rate * dt;
        let at = yields(p, rate, heat);
        if trial > at {
            let flow = (trial - at) / YOUNG;
            (s, p, heat) = (at, p + flow, heat + 0.9 * at * flow / (DENSITY * 385.0));
        } else {
            s = trial;
        }
        v -= dt * s / (DENSITY * r);
        r += dt * v;
    }
    assert_close("displacement", moved, r - radius, 5e-3);
    assert_close("strain", strain, p, 5e-3);
    assert_close("heat", temperature - reference, heat - reference, 5e-3);
}

/// A cap that snaps through with plastic flow conserves energy to rounding.
#[test]
fn snap_through_conserves_energy() {
    let places: Vec<[f64; 2]> = (0..=20)
        .map(|i| {
            let angle = 0.4 * f64::from(i) / 20.0;
            [if i == 0 { 0.0 } else { angle.sin() }, angle.cos()]
        })
        .collect();
    let text = shell_line(&places, &section(0.01), "*Plastic\n 3.e8, 0.\n 5.e8, 0.3\n")
        + "*Boundary\n A, XSYMM\n B, ENCASTRE\n"
        + &step(
            5e-3,
            "*Dload\n SHELL, P, -8.e6\n",
            "*Node output, nset=A\n U2\n*Energy output\n ETOTAL, ALLWK, ALLPD, ALLIE, ALLSE\n",
        );
    let (outcome, memory) = run(&text);
    assert_eq!(outcome.halt, None);
    let [sum, work, plastic, internal] = ["ETOTAL", "ALLWK", "ALLPD", "ALLIE"].map(|name| last(&text, &memory, name));
    assert!(last(&text, &memory, "U2@A") < -0.1, "no snap-through");
    assert!(
        sum.abs() < 1e-3 * work && plastic > 0.2 * internal && plastic < internal,
        "{sum} {work} {plastic} {internal}"
    );
}

/// One load in four forms: on elements, on each side as a surface, and as a moment on a rotation.
#[test]
fn shell_loads_act_in_the_documented_direction() {
    let place = |load: &str| {
        let text = plate_deck(4, "ENCASTRE")
            + "*Surface, name=UP\n SHELL, SPOS\n*Surface, name=DOWN\n SHELL, SNEG\n*Nset, nset=MID\n 3\n"
            + &step(
                1e-5,
                load,
                "*Node output, nset=A\n U2\n*Node output, nset=MID\n U2, UR3\n*Energy output\n ALLWK, ETOTAL\n",
            );
        let (_, memory) = run(&text);
        assert!(last(&text, &memory, "ETOTAL").abs() < 2e-2 * last(&text, &memory, "ALLWK").abs());
        [last(&text, &memory, "U2@A"), last(&text, &memory, "UR3@MID")]
    };
    let [along, up, down] =
        ["*Dload\n SHELL, P, 1.e3\n", "*Dsload\n UP, P, 1.e3\n", "*Dsload\n DOWN, P, 1.e3\n"].map(place);
    assert!(along[0] > 0.0);
    assert_eq!(along, down);
    assert_close("the other side", up[0], -along[0], 1e-9);
    assert!(place("*Cload\n MID, 6, 1.\n")[1] > 0.0);
    let weight = place("*Dload\n , GRAV, 9.81, 0., -1.\n");
    assert_eq!(weight, place("*Dload\n SHELL, GRAV, 9.81, 0., -1.\n"));
    assert_close("fall", weight[0], -0.5 * 9.81 * 1e-10, 1e-2);
}

fn error_codes(text: &str) -> Vec<&'static str> {
    job::prepare_text("case.inp", text, &[], &Routines::none()).diagnostics.iter().map(|d| d.code).collect()
}

#[test]
fn unsupported_shells_are_errors() {
    let good = plate_deck(2, "ENCASTRE") + &step(1e-6, "", "*Energy output\n ALLKE\n");
    assert_eq!(error_codes(&good), [""; 0]);
    for (from, to, code) in [
        (" 0.002, 5", " 0.002, 4", "M103"),
        (" 0.002, 5", " 0., 5", "M103"),
        ("material=M\n 0", "material=M, offset=0.6\n 0", "M103"),
        ("*Shell section", "*Solid section", "M180"),
        ("*Material, name=M\n", "*Material, name=M\n*User material, constants=1\n 1.\n", "P023"),
        ("*Material, name=M\n", "*Material, name=M\n*Plastic, hardening=KINEMATIC\n 1.e8, 0.\n 2.e8, 1.\n", "P023"),
        ("*Shell section, elset=SHELL, material=M\n 0.002, 5\n", "", "P001"),
    ] {
        let text = good.replace(from, to);
        assert_ne!(text, good);
        assert!(error_codes(&text).contains(&code), "{to}: {:?}", error_codes(&text));
    }
}

/// The state of a shell deck has rotations, that of a solid deck has none.
#[test]
fn only_shell_decks_have_rotations() {
    let shells = common::prepared(
        &(plate_deck(4, "ENCASTRE") + &step(1e-6, "", "*Energy output\n ALLKE\n")),
        &[],
        &Routines::none(),
    );
    assert_eq!((shells.state.dofs.nodes.len(), shells.plan.places.rotations.len()), (10, 5));
    let solid = grid(2, 2, false, |i, j| [i as f64, j as f64])
        + &material(1e9, 0.3, 1e3, "")
        + &step(1e-6, "", "*Energy output\n ALLKE\n");
    let solid = common::prepared(&solid, &[], &Routines::none());
    assert_eq!((solid.state.dofs.nodes.len(), solid.plan.places.rotations.len()), (9, 0));
}
