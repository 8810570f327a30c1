//! Axisymmetric shells (SAX1).
//!
//! Goal: shells bend, stretch, shear, vibrate and flow as thin-shell theory says, at the axis too; loads, boundaries and
//! outputs mean what the manual says; energy is conserved.
//! Source: Timoshenko and Woinowsky-Krieger, Theory of Plates and Shells (circular plates; ring load on a long cylinder); Leissa,
//! Vibration of Plates, NASA SP-160 (frequencies); membrane theory of spheres; Hopkins and Wang 1954, J. Mech. Phys. Solids 3,
//! 117 (limit loads of circular plates by von Mises); the equation of motion of a thin ring. ABAQUS Analysis User's Guide
//! 29.6.1 (normals, sides, pressure), 29.6.5 (`*SHELL SECTION`), 34.3.1 (boundary conditions by name).
//! Tolerance: 0.5 % on the finest mesh; orders are asserted before.

use std::f64::consts::PI;
use std::fmt::Write as _;

use crate::common::solid::{column, grid, last, material, run};
use crate::common::{self, Memory};
use revolve::job;
use revolve::user::Routines;

const YOUNG: f64 = 200e9;
const RATIO: f64 = 0.3;
const DENSITY: f64 = 7800.0;

/// Shells along a line of places, with the sets A and B at its ends.
fn line(places: &[[f64; 2]], section: &str, material: &str) -> String {
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

fn step(time: f64, cards: &str, outputs: &str) -> String {
    format!(
        "*Step\n*Dynamic, explicit\n , {time:e}\n{cards}*Output, history, number interval=2000\n{outputs}*End step\n"
    )
}

/// Grows smoothly over a part of the step: what vibrates then is less than 1e-4 of what stands.
fn slowly(time: f64) -> String {
    format!("*Amplitude, name=SLOWLY, definition=SMOOTH STEP\n 0., 0., {time:e}, 1.\n")
}

/// Mean of a column over the last part of the rows.
fn settled(text: &str, memory: &Memory, name: &str) -> f64 {
    let rows = column(text, memory, name);
    let tail = &rows[rows.len() * 3 / 4..];
    tail.iter().map(|r| r.1).sum::<f64>() / tail.len() as f64
}

/// Frequency by the first and last time that a column falls through zero.
fn frequency(text: &str, memory: &Memory, name: &str) -> f64 {
    let rows = column(text, memory, name);
    let falls = rows.windows(2).filter(|w| w[0].1 > 0.0 && w[1].1 <= 0.0);
    let times: Vec<f64> = falls.map(|w| w[0].0 + (w[1].0 - w[0].0) * w[0].1 / (w[0].1 - w[1].1)).collect();
    (times.len() - 1) as f64 / (times[times.len() - 1] - times[0])
}

#[track_caller]
fn close(what: &str, found: f64, expected: f64, tolerance: f64) {
    assert!((found / expected - 1.0).abs() < tolerance, "{what}: {found} and not {expected}");
}

/// Answers on meshes, each twice as fine: of second order until next to nothing changes, the last within half a per cent.
#[track_caller]
fn converges(what: &str, found: &[f64; 3], expected: f64) {
    let [first, second] = [found[1] - found[0], found[2] - found[1]].map(|d| (d / expected).abs());
    assert!(second < 0.4 * first || second < 2e-4, "{what}: {found:?} and not {expected}");
    close(what, found[2], expected, 5e-3);
}

fn rigidity(thickness: f64) -> f64 {
    YOUNG * thickness.powi(3) / (12.0 * (1.0 - RATIO * RATIO))
}

/// Of the section against transverse shear.
fn shear_stiffness(thickness: f64) -> f64 {
    5.0 / 6.0 * YOUNG / (2.0 * (1.0 + RATIO)) * thickness
}

fn plate(n: usize, edge: &str) -> String {
    let places: Vec<[f64; 2]> = (0..=n).map(|i| [0.1 * i as f64 / n as f64, 0.0]).collect();
    line(&places, &section(2e-3), "") + &format!("*Boundary\n A, XSYMM\n B, {edge}\n")
}

/// Clamped and supported under pressure that grows slowly: deflection of the middle, which is the worst place, and the moment
/// there. Transverse shear adds p a^2/(4 K) to the deflection of thin plates, here 0.2 and 0.05 %.
#[test]
fn plates_bend() {
    let (a, p) = (0.1_f64, 100.0);
    let unit = p * a.powi(4) / (64.0 * rigidity(2e-3));
    for (edge, factor, moment) in [
        ("ENCASTRE", 1.0, p * a * a * (1.0 + RATIO) / 16.0),
        ("1, 2", (5.0 + RATIO) / (1.0 + RATIO), p * a * a * (3.0 + RATIO) / 16.0),
    ] {
        let of = |n: usize| {
            let text = plate(n, edge)
                + &slowly(0.02)
                + &step(
                    0.03,
                    &format!("*Dload, amplitude=SLOWLY\n SHELL, P, {p}\n"),
                    "*Node output, nset=A\n U2, UR3\n*Element output, elset=E1\n SM\n*Energy output\n ETOTAL, ALLWK\n",
                );
            let (outcome, memory) = run(&text);
            assert_eq!(outcome.halt, None);
            assert_eq!(last(&text, &memory, "UR3@A"), 0.0);
            assert!(last(&text, &memory, "ETOTAL").abs() < 1e-9 * last(&text, &memory, "ALLWK"));
            ["U2@A", "SM1@E1"].map(|name| settled(&text, &memory, name))
        };
        let found = [10, 20, 40].map(of);
        let shear = p * a * a / (4.0 * shear_stiffness(2e-3));
        converges("deflection", &found.map(|f| f[0]), unit * factor + shear);
        close("thin plate", found[2][0], unit * factor, 5e-3);
        // P acts along the normal, which points up: in the middle that side is stretched.
        close("moment", found[2][1], moment, 1e-2);
    }
}

/// A sudden pressure: the plate swings about the static deflection, up to about twice of it (single modes just twice).
#[test]
fn a_sudden_load_swings_about_the_static_deflection() {
    let text =
        plate(40, "ENCASTRE") + &step(20.0 / 498.286, "*Dload\n SHELL, P, 100.\n", "*Node output, nset=A\n U2\n");
    let (_, memory) = run(&text);
    let rows = column(&text, &memory, "U2@A");
    let still = 100.0 * 0.1_f64.powi(4) / (64.0 * rigidity(2e-3));
    close("mean", rows.iter().map(|r| r.1).sum::<f64>() / rows.len() as f64, still, 1e-2);
    let most = rows.iter().map(|r| r.1).fold(0.0, f64::max);
    assert!(most > 1.95 * still && most < 2.2 * still, "{most} {still}");
}

/// J0 and I0 by their series.
fn bessel(x: f64, sign: f64) -> f64 {
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..60 {
        term *= sign * 0.25 * x * x / f64::from(k * k);
        sum += term;
    }
    sum
}

#[test]
fn plates_vibrate() {
    for (edge, root, expected) in [("ENCASTRE", 3.196_220_6, 498.286), ("1, 2", 2.221_519_4, 240.715)] {
        let ratio = bessel(root, -1.0) / bessel(root, 1.0);
        let of = |n: usize| {
            let mut text = plate(n, edge) + "*Initial conditions, type=VELOCITY\n";
            for i in 0..n {
                let x = root * i as f64 / n as f64;
                writeln!(text, " {}, 2, {:e}", i + 1, 1e-4 * (bessel(x, -1.0) - ratio * bessel(x, 1.0))).expect("text");
            }
            text += &step(8.4 / expected, "*Bulk viscosity\n 0., 0.\n", "*Node output, nset=A\n U2\n");
            let (_, memory) = run(&text);
            frequency(&text, &memory, "U2@A")
        };
        converges(edge, &[10, 20, 40].map(of), expected);
    }
}

/// Deflection and moment of a long cylinder at a ring load, with the shear that thin-shell theory leaves out: a beam by Timoshenko
/// on its foundation, w'''' - k/S w'' + k/D w = 0, with no rotation at the load and half of it as shear.
fn ring_load(radius: f64, thickness: f64, load: f64) -> [f64; 2] {
    let (d, k) = (rigidity(thickness), YOUNG * thickness / (radius * radius));
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

/// Half of a long cylinder under a ring load: against theory with shear, and where the wall is thin against thin-shell theory.
#[test]
fn a_ring_load_on_a_long_cylinder() {
    let load = 10e3;
    let of = |n: usize, thickness: f64, length: f64| {
        let places: Vec<[f64; 2]> = (0..=n).map(|i| [0.1, length * i as f64 / n as f64]).collect();
        let text = line(&places, &section(thickness), "")
            + "*Boundary\n A, YSYMM\n"
            + &slowly(3e-3)
            + &step(
                4e-3,
                &format!("*Cload, amplitude=SLOWLY\n A, 1, {:e}\n", 0.5 * 2.0 * PI * 0.1 * load * (thickness / 2e-3)),
                "*Node output, nset=A\n U1, RM3\n*Element output, elset=E1\n SM\n*Element output, elset=E2\n SM\n",
            );
        let (_, memory) = run(&text);
        ["U1@A", "SM1@E1", "SM1@E2", "RM3@A"].map(|name| settled(&text, &memory, name))
    };
    let kirchhoff = |thickness: f64, load: f64| {
        let beta = (3.0 * (1.0 - RATIO * RATIO)).powf(0.25) / (0.1 * thickness).sqrt();
        load * beta * 0.01 / (2.0 * YOUNG * thickness)
    };
    close("closed form", ring_load(0.1, 2e-7, load)[0], kirchhoff(2e-7, load), 1e-4);
    let [deflection, moment] = ring_load(0.1, 2e-3, load);
    close("the reference without shear", kirchhoff(2e-3, load), 11.361_500e-6, 1e-6);
    close("shear", deflection, kirchhoff(2e-3, load), 2e-2);
    let found = [40, 80, 160].map(|n| of(n, 2e-3, 0.1));
    converges("deflection", &found.map(|f| f[0]), deflection);
    // The normal of a cylinder that runs upward points inward. At the load, from the middles of two elements.
    converges("moment", &found.map(|f| 1.5 * f[1] - 0.5 * f[2]), -moment);
    close("reaction", found[2][3].abs(), moment * 2.0 * PI * 0.1, 1e-2);
    // A tenth of thickness and load: thin-shell theory.
    close("thin", of(80, 2e-4, 0.04)[0], kirchhoff(2e-4, 0.1 * load), 5e-3);
}

#[test]
fn cylinders_and_spheres_breathe() {
    let cylinder = |cards: &str, n: usize| {
        let places: Vec<[f64; 2]> = (0..=n).map(|i| [0.1, 0.02 * i as f64 / n as f64]).collect();
        line(&places, &section(2e-3), "") + "*Initial conditions, type=VELOCITY\n ALL, 1, 1.e-3\n" + cards
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
    close("ring", breathe(&cylinder("", 1), 8059.1238).0, 8059.1238, 2e-3);
    close("plane strain", breathe(&cylinder("*Boundary\n ALL, 2, 2\n", 4), 8448.2573).0, 8448.2573, 2e-3);
    let sphere = |n: usize| {
        let angle = |i: usize| 0.5 * PI * i as f64 / n as f64;
        let places: Vec<[f64; 2]> =
            (0..=n).map(|i| [if i == 0 { 0.0 } else { 0.1 * angle(i).sin() }, 0.1 * angle(i).cos()]).collect();
        let mut text =
            line(&places, &section(2e-4), "") + "*Boundary\n A, XSYMM\n B, YSYMM\n*Initial conditions, type=VELOCITY\n";
        for i in 0..=n {
            writeln!(text, " {}, 1, {:e}\n {}, 2, {:e}", i + 1, 1e-3 * angle(i).sin(), i + 1, 1e-3 * angle(i).cos())
                .expect("text");
        }
        breathe(&text, 13_622.405_6).0
    };
    converges("sphere", &[10, 20, 40].map(sphere), 13_622.405_6);
}

/// A closed sphere under pressure from within: u = p R^2 (1 - nu) / (2 E t) everywhere, at the pole too.
#[test]
fn a_sphere_under_pressure() {
    let (radius, thickness, p) = (0.1, 1e-3, 1e4);
    let of = |n: usize| {
        let angle = |i: usize| 0.5 * PI * i as f64 / n as f64;
        let places: Vec<[f64; 2]> =
            (0..=n).map(|i| [if i == 0 { 0.0 } else { radius * angle(i).sin() }, radius * angle(i).cos()]).collect();
        let text = line(&places, &section(thickness), "")
            + "*Boundary\n A, XSYMM\n B, YSYMM\n"
            + &slowly(4e-3)
            // From the pole down to the equator the normal points outward, and P acts along it.
            + &step(5e-3, &format!("*Dload, amplitude=SLOWLY\n SHELL, P, {p}\n"), "*Node output, nset=A\n U2\n*Node output, nset=B\n U1\n*Element output, elset=E1\n SF, S, S_SNEG, S_SPOS\n");
        let (_, memory) = run(&text);
        ["U2@A", "U1@B", "SF1@E1", "SF2@E1", "S11@E1"].map(|name| settled(&text, &memory, name))
    };
    let found = [10, 20, 40].map(of);
    let expected = p * radius * radius * (1.0 - RATIO) / (2.0 * YOUNG * thickness);
    converges("pole", &found.map(|f| f[0]), expected);
    converges("equator", &found.map(|f| f[1]), expected);
    for i in [2, 3] {
        close("section force at the pole", found[2][i], 0.5 * p * radius, 2e-2);
    }
}

/// A shallow spherical cap, clamped, under a sudden pressure of 600 psi that makes it flow (Nagarajan and Popov 1974, Comput.
/// Struct. 4, 1117; radius 22.27 in, thickness 0.41 in, half-angle 26.67 degrees): the apex beside that of solids through the
/// thickness. Shells leave out what is of the order of thickness over radius, 2 %.
#[test]
fn a_spherical_cap_under_a_sudden_pressure() {
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
        let text = line(&places, &format!("*Shell section, elset=SHELL, material=M\n {thickness}, 9\n"), flows)
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
    close("largest deflection", least(&fine), least(&whole), 2e-2);
}

/// Section points by number: 1 is the side SNEG, the last SPOS, the middle one what S is without a number.
#[test]
fn section_points_have_numbers() {
    let with = |output: &str| {
        let cards = "*Dload, amplitude=SLOWLY\n SHELL, P, 100.\n";
        let text = plate(10, "ENCASTRE") + &slowly(2e-3) + &step(3e-3, cards, output);
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
    // Bent: stretched on one side, pressed on the other.
    let [below, above] = ["S11_SNEG@E1", "S11_SPOS@E1"].map(|name| find(&by_number, name));
    assert!(below * above < 0.0, "{below} {above}");
    let refused = |output: &str| codes(&(plate(10, "ENCASTRE") + &step(3e-3, "", output)));
    assert_eq!(refused("*Element output, elset=E1\n 2,\n S\n"), ["M104"]);
    assert!(refused("*Element output, elset=E1\n 1, 5\n S\n").is_empty());
}

/// Perfectly plastic plates by von Mises: supported they carry 6.51 M/a^2, clamped 12.5 M/a^2, with M = Y t^2/4.
#[test]
fn plates_have_their_limit_load() {
    let (a, t, yields) = (0.1_f64, 4e-3, 20e6);
    for (edge, factor) in [("1, 2", 6.51), ("ENCASTRE", 12.5)] {
        let limit = factor * 0.25 * yields * t * t / (a * a);
        let rises = |share: f64| {
            let places: Vec<[f64; 2]> = (0..=40).map(|i| [a * f64::from(i) / 40.0, 0.0]).collect();
            let section = format!("*Shell section, elset=SHELL, material=M\n {t}, 9\n");
            let text = line(&places, &section, &format!("*Plastic\n {yields:e}, 0.\n"))
                + &format!("*Boundary\n A, XSYMM\n B, {}\n", edge.replace("1, 2", "2, 2"))
                + &slowly(8e-3)
                + &step(
                    0.012,
                    &format!("*Dload, amplitude=SLOWLY\n SHELL, P, {:e}\n", share * limit),
                    "*Node output, nset=A\n U2, V2\n",
                );
            let (_, memory) = run(&text);
            last(&text, &memory, "U2@A")
        };
        let elastic = limit * a.powi(4) / (64.0 * rigidity(t)) * if factor < 7.0 { 4.08 } else { 1.0 };
        let [below, above] = [0.97, 1.04].map(rises);
        assert!(below < 4.0 * elastic && above > 2.0 * below, "{edge}: {below} {above} {elastic}");
    }
}

/// A ring that flies outward, by Johnson and Cook with heat: its equation of motion by fine steps.
#[test]
fn a_ring_is_stopped_by_johnson_cook() {
    let [a, b, n, m, c, rate0, melt, room] = [90e6, 292e6, 0.31, 1.09, 0.025, 1.0, 1356.0, 293.0];
    let (speed, time, radius) = (100.0, 60e-6, 0.02);
    let text = line(&[[radius, 0.0], [radius, 1e-3]], &section(1e-3), &format!(
        "*Plastic, hardening=JOHNSON COOK\n {a:e}, {b:e}, {n}, {m}, {melt}, {room}\n*Rate dependent, type=JOHNSON COOK\n {c}, {rate0}\n*Specific heat\n 385.,\n*Inelastic heat fraction\n 0.9\n"))
        + &format!("*Initial conditions, type=VELOCITY\n ALL, 1, {speed}\n*Initial conditions, type=TEMPERATURE\n ALL, {room}\n")
        + &step(time, "*Bulk viscosity\n 0., 0.\n", "*Node output, nset=A\n U1, V1\n*Element output, elset=E1\n PEEQ, TEMP, S22, STH\n*Energy output\n ETOTAL, ALLKE, ALLPD\n")
            .replace("*Dynamic, explicit", "*Dynamic, explicit, adiabatic");
    let (_, memory) = run(&text);
    let [moved, strain, temperature] = ["U1@A", "PEEQ@E1", "TEMP@E1"].map(|name| last(&text, &memory, name));
    assert!(last(&text, &memory, "ETOTAL") > 0.0);
    // r'' = -s A/(rho A0 r0) with an area that flow leaves as A0 r0/r, and elasticity before.
    let (mut r, mut v, mut s, mut p, mut heat) = (radius, speed, 0.0_f64, 0.0_f64, room);
    let dt = 1e-11;
    for _ in 0..(time / dt).round() as usize {
        let rate = v / r;
        let yields = |strain: f64, rate: f64, heat: f64| {
            let factor = if rate > rate0 { 1.0 + c * (rate / rate0).ln() } else { 1.0 };
            let theta = ((heat - room) / (melt - room)).max(0.0);
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
    close("displacement", moved, r - radius, 5e-3);
    close("strain", strain, p, 5e-3);
    close("heat", temperature - room, heat - room, 5e-3);
}

/// A cap that snaps far through with flow: the energy stays to rounding.
#[test]
fn energy_stays() {
    let places: Vec<[f64; 2]> = (0..=20)
        .map(|i| {
            let angle = 0.4 * f64::from(i) / 20.0;
            [if i == 0 { 0.0 } else { angle.sin() }, angle.cos()]
        })
        .collect();
    let text = line(&places, &section(0.01), "*Plastic\n 3.e8, 0.\n 5.e8, 0.3\n")
        + "*Boundary\n A, XSYMM\n B, ENCASTRE\n"
        + &step(
            5e-3,
            "*Dload\n SHELL, P, -8.e6\n",
            "*Node output, nset=A\n U2\n*Energy output\n ETOTAL, ALLWK, ALLPD, ALLIE, ALLSE\n",
        );
    let (outcome, memory) = run(&text);
    assert_eq!(outcome.halt, None);
    let [sum, work, plastic, internal] = ["ETOTAL", "ALLWK", "ALLPD", "ALLIE"].map(|name| last(&text, &memory, name));
    assert!(last(&text, &memory, "U2@A") < -0.1, "it snaps through");
    assert!(
        sum.abs() < 1e-3 * work && plastic > 0.2 * internal && plastic < internal,
        "{sum} {work} {plastic} {internal}"
    );
}

/// One load in four ways: on elements, on each side as a surface, and as a moment on the rotation.
#[test]
fn loads_push_the_way_of_the_manual() {
    let place = |load: &str| {
        let text = plate(4, "ENCASTRE")
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
    close("the other side", up[0], -along[0], 1e-9);
    assert!(place("*Cload\n MID, 6, 1.\n")[1] > 0.0);
    let weight = place("*Dload\n , GRAV, 9.81, 0., -1.\n");
    assert_eq!(weight, place("*Dload\n SHELL, GRAV, 9.81, 0., -1.\n"));
    close("fall", weight[0], -0.5 * 9.81 * 1e-10, 1e-2);
}

fn codes(text: &str) -> Vec<&'static str> {
    job::prepare_text("case.inp", text, &[], &Routines::none()).diagnostics.iter().map(|d| d.code).collect()
}

#[test]
fn what_shells_cannot_be_is_refused() {
    let good = plate(2, "ENCASTRE") + &step(1e-6, "", "*Energy output\n ALLKE\n");
    assert_eq!(codes(&good), [""; 0]);
    for (from, to, code) in [
        (" 0.002, 5", " 0.002, 4", "M103"),
        (" 0.002, 5", " 0., 5", "M103"),
        ("material=M\n 0", "material=M, offset=0.5\n 0", "M104"),
        ("*Shell section", "*Solid section", "M180"),
        ("*Material, name=M\n", "*Material, name=M\n*User material, constants=1\n 1.\n", "P023"),
        ("*Material, name=M\n", "*Material, name=M\n*Plastic, hardening=KINEMATIC\n 1.e8, 0.\n 2.e8, 1.\n", "P023"),
        ("*Shell section, elset=SHELL, material=M\n 0.002, 5\n", "", "P001"),
    ] {
        let text = good.replace(from, to);
        assert_ne!(text, good);
        assert!(codes(&text).contains(&code), "{to}: {:?}", codes(&text));
    }
}

/// A deck of shells holds rotations in its state, one of solids none.
#[test]
fn rotations_are_there_only_with_shells() {
    let shells =
        common::prepared(&(plate(4, "ENCASTRE") + &step(1e-6, "", "*Energy output\n ALLKE\n")), &[], &Routines::none());
    assert_eq!((shells.state.dofs.nodes.len(), shells.plan.places.rotations.len()), (10, 5));
    let solid = grid(2, 2, false, |i, j| [i as f64, j as f64])
        + &material(1e9, 0.3, 1e3, "")
        + &step(1e-6, "", "*Energy output\n ALLKE\n");
    let solid = common::prepared(&solid, &[], &Routines::none());
    assert_eq!((solid.state.dofs.nodes.len(), solid.plan.places.rotations.len()), (9, 0));
}
