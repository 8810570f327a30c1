//! Smooth curves through listed boundaries of a refined mesh (`mesh-curved`).
//!
//! Goal: a coarse listed mesh of a curved body is refined towards the body, not towards its polygon.
//! Source: volumes of revolution in closed form; nodes of arcs that `*NGEN, LINE=C` generates.

use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt::Write as _;

use revolve::deck;
use revolve::model::{self, Model};

use crate::common::solid::{grid, material};
use crate::common::{model_of, pairs};

type Point = [f64; 2];

/// Returns the volume of a model.
fn volume(model: &Model) -> f64 {
    let triangle = |[a, b, c]: [Point; 3]| {
        let area = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
        TAU * area * (a[0] + b[0] + c[0]) / 3.0
    };
    let cells = (0..model.mesh.elements.len()).flat_map(|e| model.mesh.initial_cells(e));
    cells.map(|[a, b, c, d]| triangle([a, b, c]) + triangle([a, c, d])).sum()
}

fn hollow_sphere(n: usize) -> String {
    grid(2, n, false, |i, j| {
        let (radius, angle) = (1.0 + 0.5 * i as f64, FRAC_PI_2 * j as f64 / n as f64);
        [radius * if j == n { 0.0 } else { angle.cos() }, radius * angle.sin()]
    }) + &material(1e5, 0.3, 1.0, "")
}

/// A ring with a circular section of radius 1 with a hole of radius 0.5: closed curves.
fn ring(n: usize) -> String {
    let mut text = String::from("*Node\n");
    for (j, i) in (0..n).flat_map(|j| (0..=2).map(move |i| (j, i))) {
        let (radius, angle) = (0.5 + 0.25 * i as f64, TAU * j as f64 / n as f64);
        writeln!(text, " {}, {:e}, {:e}", 1 + i + 3 * j, 3.0 + radius * angle.cos(), radius * angle.sin())
            .expect("text");
    }
    text += "*Element, type=CAX4R, elset=SOLID\n";
    for (j, i) in (0..n).flat_map(|j| (0..2).map(move |i| (j, i))) {
        let node = |i: usize, j: usize| 1 + i + 3 * (j % n);
        let nodes = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)].map(|n| n.to_string());
        writeln!(text, " {}, {}", 1 + i + 2 * j, nodes.join(", ")).expect("text");
    }
    text + &material(1e5, 0.3, 1.0, "")
}

/// An ogive of CRH 2 with `n` elements along the nose, and a shank: radius 1, nose length sqrt(7), shank length 3.
fn ogive(n: usize) -> String {
    let (radius, nose) = (4.0_f64, 7.0_f64.sqrt());
    let half = (nose / radius).asin();
    grid(2, n + 3, false, |i, j| {
        // The tip is cut off, so that all elements have four corners.
        let angle = 0.95 * half * (1.0 - j.min(n) as f64 / n as f64);
        let outer = [radius * angle.cos() - 3.0, nose - radius * angle.sin() + j.saturating_sub(n) as f64];
        [0.5 * i as f64 * outer[0], outer[1]]
    }) + &material(1e5, 0.3, 1.0, "")
}

/// Volume of the ogive from its cut tip to the end of the shank.
fn ogive_volume() -> f64 {
    let (radius, nose) = (4.0_f64, 7.0_f64.sqrt());
    let start = (nose / radius).asin() * 0.95;
    // The integral of pi (R cos a - 3)^2 R cos a over the angle.
    let primitive = |a: f64| {
        let (s, c) = a.sin_cos();
        radius.powi(2) * (s - s.powi(3) / 3.0) - 6.0 * radius * 0.5 * (a + s * c) + 9.0 * s
    };
    PI * radius * (primitive(start) - primitive(0.0)) + 3.0 * PI
}

/// Errors of the volume with polylines and with curves. Refined by 4, curves reduce the error by a factor above 10, and
/// the error has order 2.
#[test]
fn volumes_converge_to_those_of_curved_bodies() {
    let sphere = TAU / 3.0 * (8.0 - 1.0);
    let torus = 3.0 * TAU * PI * (1.0 - 0.25);
    for (what, text, exact) in
        [("hollow sphere", hollow_sphere(4), sphere), ("ring", ring(16), torus), ("ogive", ogive(4), ogive_volume())]
    {
        let error = |factor: &str, angle: Option<&str>| {
            let mut settings = vec![("mesh", factor)];
            settings.extend(angle.map(|angle| ("mesh-curved", angle)));
            (volume(&model_of(&text, &settings)) / exact - 1.0).abs()
        };
        let [coarse, polygon] = ["1", "4"].map(|factor| error(factor, None));
        let curved = ["1", "2", "4", "8"].map(|factor| error(factor, Some("30")));
        let orders: Vec<f64> = curved.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
        println!("{what}: {coarse:.2e}, polygon {polygon:.2e}, curves {curved:?}, orders {orders:.3?}");
        assert!((polygon / coarse - 1.0).abs() < 1e-9 && curved[0] == coarse, "{what}: a polygon keeps its volume");
        assert!(polygon / curved[2] > 10.0, "{what}");
        assert!(orders[..2].iter().all(|order| (order - 2.0).abs() < 0.1), "{what}");
        // Each node is a corner if curves must not turn.
        assert_eq!(error("4", Some("0.01")), polygon, "{what}");
    }
}

/// Two bodies in contact along a curve, with their own nodes at the same places: their new nodes coincide to the last bit,
/// also where the curve of one body ends. The interface of two materials is a curve, too.
#[test]
fn curves_of_two_bodies_coincide() {
    let n = 6;
    let body = |first: usize, radii: [f64; 2], count: usize, set: &str| {
        let mut text = String::from("*Node\n");
        for (j, i) in (0..=count).flat_map(|j| (0..=1).map(move |i| (j, i))) {
            let (radius, angle) = (radii[i], FRAC_PI_2 * j as f64 / n as f64);
            writeln!(text, " {}, {:e}, {:e}", first + i + 2 * j, radius * angle.sin(), radius * angle.cos())
                .expect("text");
        }
        writeln!(text, "*Element, type=CAX4R, elset={set}").expect("text");
        for j in 0..count {
            let node = |i: usize, j: usize| first + i + 2 * j;
            let nodes = [node(0, j), node(0, j + 1), node(1, j + 1), node(1, j)];
            writeln!(text, " {}, {}", first + j, nodes.map(|n| n.to_string()).join(", ")).expect("text");
        }
        text
    };
    let sections = material(1e5, 0.3, 1.0, "") + "*Solid Section, elset=OTHER, material=M\n";
    let settings = [("mesh", "4"), ("mesh-curved", "30")];
    // The outer body covers four of six edges.
    let text = body(1, [0.5, 1.0], n, "SOLID") + &body(101, [1.0, 1.5], 4, "OTHER") + &sections;
    let model = model_of(&text, &settings);
    let points_of = |set: &str| {
        let elements = &model.element_sets[set].members;
        let nodes = elements.iter().flat_map(|&e| model.mesh.elements[e].nodes.iter().copied());
        let points = nodes.map(|node| model.mesh.points[node]);
        points.filter(|[r, z]| (r.hypot(*z) - 1.0).abs() < 1e-3).map(|p| p.map(f64::to_bits)).collect::<BTreeSet<_>>()
    };
    let [inner, outer] = ["SOLID", "OTHER"].map(points_of);
    assert_eq!((inner.len(), outer.len()), (4 * n + 1, 4 * 4 + 1));
    assert!(outer.is_subset(&inner));
    // Common nodes: the interface of the sections follows the same circle.
    let shared = grid(2, n, false, |i, j| {
        let (radius, angle) = (0.5 + 0.5 * i as f64, FRAC_PI_2 * j as f64 / n as f64);
        [radius * if j == n { 0.0 } else { angle.cos() }, radius * angle.sin()]
    })
    .replace("elset=SOLID\n", "\n");
    let sets: String = (0..n)
        .map(|j| format!("*Elset, elset=SOLID\n {},\n*Elset, elset=OTHER\n {},\n", 2 * j + 1, 2 * j + 2))
        .collect();
    let model = model_of(&(shared + &sets + &sections), &settings);
    let distance = |[r, z]: &Point| (r.hypot(*z) - 1.0).abs();
    let count = model.mesh.points.iter().filter(|p| distance(p) < 2e-8).count();
    assert_eq!(count, 4 * n + 1);
}

/// The new nodes of a listed circle are within 1e-6 of the circle, and within 2e-4 (0.2 % of an edge) of the nodes of a
/// finer mesh.
#[test]
fn listed_arcs_have_the_nodes_of_generated_arcs() {
    let listed = model_of(&hollow_sphere(6), &[("mesh", "4"), ("mesh-curved", "30")]);
    let generated = model_of(&hollow_sphere(24), &[]);
    let on_surface = |p: &&Point| (p[0].hypot(p[1]) - 2.0).abs() < 1e-6;
    let surface = |model: &Model| model.mesh.points.iter().filter(on_surface).copied().collect::<Vec<Point>>();
    let (a, b) = (surface(&listed), surface(&generated));
    assert_eq!((a.len(), b.len()), (25, 25));
    let nearest = |p: &Point| b.iter().map(|q| (p[0] - q[0]).hypot(p[1] - q[1])).fold(f64::INFINITY, f64::min);
    let worst = a.iter().map(nearest).fold(0.0, f64::max);
    println!("largest distance of nodes {worst:.1e}");
    assert!(worst < 2e-4, "{worst:e}");
}

/// Angles out of range are errors, and curves that would turn thin elements inside out are located errors.
#[test]
fn invalid_curves_are_errors() {
    for angle in ["0", "90", "a", "-5"] {
        let (_, found) = deck::read_text("deck.inp", &ring(16), &pairs(&[("mesh", "2"), ("mesh-curved", angle)]));
        assert!(found.iter().any(|d| d.code == "D408" && d.message.contains(angle)), "{angle}");
    }
    let thin = grid(1, 4, false, |i, j| {
        let (radius, angle) = (1.0 + 0.005 * i as f64, FRAC_PI_2 * j as f64 / 4.0);
        [radius * angle.cos(), radius * angle.sin()]
    });
    let layers = thin.replace(
        "*Element",
        "*Node\n 91, 2., 0.\n 92, 1.85, 0.77\n 93, 1.41, 1.41\n 94, 0.77, 1.85\n 95, 0., 2.\n*Element",
    ) + "*Element, type=CAX4R, elset=SOLID\n 11, 2, 91, 92, 4\n 12, 4, 92, 93, 6\n 13, 6, 93, 94, 8\n 14, 8, 94, 95, 10\n"
        + &material(1e5, 0.3, 1.0, "");
    let (read, _) = deck::read_text("deck.inp", &layers, &pairs(&[("mesh", "4"), ("mesh-curved", "30")]));
    let (_, found) = model::build(&read);
    let is_it = |d: &deck::Diagnostic| {
        d.code == "M123" && !d.labels.is_empty() && d.help.iter().any(|h| h.contains("--curved"))
    };
    assert!(found.iter().any(is_it), "{}", found.render(&read.sources));
}
