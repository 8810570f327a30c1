//! Local refinement with conforming transitions.
//!
//! Goal: elements around refined ones are divided such that no node lies inside an edge; refinement changes no total of the
//! model, and linear fields remain exact.
//! Source: integrals over straight-sided elements and faces; uniform stress of linear fields. The tolerance and its reason
//! are stated at each test.

use std::collections::{BTreeMap, BTreeSet};

use revolve::deck::{self, Deck};
use revolve::job::{self, PreparedJob};
use revolve::model::{self, Model};
use revolve::solve;
use revolve::user::Routines;

use super::refinement::{RandomMesh, assert_same_totals, random_mesh, totals};
use crate::common::random::RandomSequence;
use crate::common::solid::{grid, material};
use crate::common::{RecordedOutput, model_of};

/// Returns a deck in which some elements are refined.
fn marked(text: &str, is_refined: &[bool]) -> Deck {
    let (mut deck, found) = deck::read_text("deck.inp", text, &[]);
    assert!(!found.has_errors(), "{}", found.render(&deck.sources));
    deck.refine_elements(is_refined.into());
    deck
}

fn refined(text: &str, is_refined: &[bool]) -> Model {
    let deck = marked(text, is_refined);
    let (model, found) = model::build(&deck);
    assert!(!found.has_errors(), "{}", found.render(&deck.sources));
    model
}

/// Returns random marks: single elements, or a block of consecutive ones.
fn marks(random: &mut RandomSequence, count: usize) -> Vec<bool> {
    if random.next() < 0.5 {
        let share = random.between(0.05, 0.6);
        return (0..count).map(|_| random.next() < share).collect();
    }
    let first = random.count(0, count - 1);
    let last = random.count(first, count - 1);
    (0..count).map(|element| (first..=last).contains(&element)).collect()
}

fn area(model: &Model, nodes: &[usize]) -> f64 {
    let point = |k: usize| model.mesh.points[nodes[k % nodes.len()]];
    let cross = |k: usize| point(k)[0] * point(k + 1)[1] - point(k + 1)[0] * point(k)[1];
    0.5 * (0..nodes.len()).map(cross).sum::<f64>()
}

/// Returns the edges of solid elements with the number of elements at each.
fn edges(model: &Model) -> BTreeMap<[usize; 2], usize> {
    let mut edges = BTreeMap::new();
    for element in model.mesh.elements.iter().filter(|element| element.nodes.len() > 2) {
        for at in 0..element.nodes.len() {
            let [a, b] = [element.nodes[at], element.nodes[(at + 1) % element.nodes.len()]];
            *edges.entry([a.min(b), a.max(b)]).or_insert(0) += 1;
        }
    }
    edges
}

/// No node lies inside an edge, and all elements have a positive area.
fn assert_conforming(what: &str, model: &Model) {
    let used: BTreeSet<usize> = model.mesh.elements.iter().flat_map(|e| e.nodes.to_vec()).collect();
    for ([a, b], count) in edges(model) {
        assert!(count <= 2, "{what}");
        let [p, q] = [a, b].map(|node| model.mesh.points[node]);
        let d = [q[0] - p[0], q[1] - p[1]];
        let square = d[0] * d[0] + d[1] * d[1];
        for &node in used.iter().filter(|&&node| node != a && node != b) {
            let x = model.mesh.points[node];
            let v = [x[0] - p[0], x[1] - p[1]];
            let (along, across) = ((v[0] * d[0] + v[1] * d[1]) / square, (v[0] * d[1] - v[1] * d[0]) / square);
            assert!(!(1e-9..1.0 - 1e-9).contains(&along) || across.abs() > 1e-9, "{what}: node {node} in edge {a} {b}");
        }
    }
    for element in model.mesh.elements.iter().filter(|element| element.nodes.len() > 2) {
        assert!(area(model, &element.nodes) > 0.0, "{what}: element {}", element.name.as_str());
    }
}

/// Volume, masses, pressures, gravity and forces within 1e-13, the tolerance of uniform refinement; 400 random meshes of
/// quadrilaterals and triangles.
#[test]
fn local_refinement_of_random_meshes_preserves_totals() {
    let mut refined_elements = 0;
    for seed in 0..400 {
        let RandomMesh { text, lines } = random_mesh(seed);
        let coarse = model_of(&text, &[]);
        let mut random = RandomSequence(seed + 1000);
        let marks = marks(&mut random, coarse.mesh.elements.len());
        let fine = refined(&text, &marks);
        let what = format!("seed {seed}, marks {marks:?}");
        assert_same_totals(&what, &totals(&coarse), &totals(&fine));
        assert_conforming(&what, &fine);
        let is_solid = |e: &usize| coarse.mesh.elements[*e].nodes.len() > 2;
        let least: usize = (0..marks.len()).filter(|e| marks[*e] && is_solid(e)).count();
        assert!(fine.mesh.elements.len() >= coarse.mesh.elements.len() + 3 * least, "{what}");
        refined_elements += least;
        let names: BTreeSet<&str> = fine.mesh.node_names.iter().map(|n| n.as_str()).collect();
        assert_eq!(names.len(), fine.mesh.points.len(), "labels are unique");
        // The nodes of a line of the grid are those of its edges.
        let on_edges =
            |set: &BTreeSet<usize>| edges(&fine).keys().filter(|ends| ends.iter().all(|n| set.contains(n))).count();
        for (name, members) in lines {
            let set: BTreeSet<usize> = fine.node_sets[name].members.iter().copied().collect();
            assert!(set.len() >= members.len() && on_edges(&set) >= set.len() - 1, "{what}: {name}");
        }
    }
    assert!(refined_elements > 2000, "{refined_elements}");
}

/// All elements marked: the mesh of uniform refinement.
#[test]
fn refinement_of_all_elements_is_uniform_refinement() {
    for seed in 0..20 {
        let RandomMesh { text, .. } = random_mesh(seed);
        let uniform = model_of(&text, &[("mesh", "2")]);
        let local = refined(&text, &vec![true; model_of(&text, &[]).mesh.elements.len()]);
        assert_eq!(uniform.mesh.points, local.mesh.points);
        let nodes = |model: &Model| model.mesh.elements.iter().map(|e| e.nodes.to_vec()).collect::<Vec<_>>();
        assert_eq!(nodes(&uniform), nodes(&local));
    }
}

fn prepared(text: &str, is_refined: &[bool]) -> PreparedJob {
    let deck = marked(text, is_refined);
    let prepared = job::prepare_edited((deck, deck::Diagnostics::default()), &mut |_| {}, &Routines::none());
    assert!(!prepared.diagnostics.has_errors(), "{}", prepared.diagnostics.render(&prepared.deck.sources));
    prepared
}

/// Returns the values of the last frame by variable.
fn last_frame(prepared: &PreparedJob) -> BTreeMap<String, Vec<f64>> {
    let mut memory = RecordedOutput::default();
    let (outcome, _) = solve::run(&prepared.plan, prepared.state.clone(), &mut memory);
    assert!(outcome.halt.is_none(), "{:?}", outcome.halt);
    let frame = memory.frames.last().expect("a frame");
    frame.point_fields.iter().chain(&frame.cell_fields).map(|f| (f.name.clone(), f.values.clone())).collect()
}

/// Returns a node of a distorted grid that touches the axis.
fn distorted_node(i: usize, j: usize) -> [f64; 2] {
    let inside = (1..5).contains(&i) && (1..5).contains(&j);
    let shift = if inside { 0.15 } else { 0.0 };
    let sign = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
    [i as f64 + shift * sign(i + j), 0.7 * j as f64 + shift * sign(i)]
}

/// Linear velocities give equal stresses in all elements, within 1e-12 of their size; a hydrostatic stress is in equilibrium
/// with a pressure on all sides, within 1e-12 (a force of 3 on a mass of order 1).
#[test]
fn transitions_pass_the_patch_test() {
    let mut random = RandomSequence(7);
    for triangles in [false, true] {
        let mesh = grid(5, 5, triangles, distorted_node) + &material(1000.0, 0.25, 1.0, "");
        let mut moving = mesh.clone() + "*Initial Conditions, type=VELOCITY\n";
        for n in 0..36 {
            let [r, z] = distorted_node(n % 6, n / 6);
            moving += &format!(" {}, 1, {:e}\n {}, 2, {:e}\n", n + 1, 1e-3 * r, n + 1, 2e-3 * z);
        }
        moving += "*Step\n*Dynamic, Explicit, direct user control\n 1.e-4, 1.e-4\n*Bulk Viscosity\n 0., 0.\n\
                   *Output, field, number interval=1\n*Element Output\n S\n*End Step\n";
        let pressed = mesh
            + "*Initial Conditions, type=STRESS\n SOLID, -3., -3., -3., 0.\n*Step\n*Dynamic, Explicit\n , 1.\n*Dsload\n \
               I1, P, 3.\n J0, P, 3.\n J1, P, 3.\n*Output, field, number interval=1\n*Node Output\n A\n*End Step\n";
        for _ in 0..25 {
            let marks = marks(&mut random, if triangles { 50 } else { 25 });
            let fields = last_frame(&prepared(&moving, &marks));
            let (lambda, mu, trace) = (400.0, 400.0, 4e-7);
            let stress = &fields["S"];
            for s in stress.chunks(4) {
                for (at, strain) in [1e-7, 2e-7, 1e-7].into_iter().enumerate() {
                    let expected: f64 = lambda * trace + 2.0 * mu * strain;
                    assert!((s[at] - stress[at]).abs() < 1e-12 * expected, "{marks:?} {s:?} {stress:?}");
                    // The strain rates are those at the middle of the increment.
                    assert!((s[at] / expected - 1.0).abs() < 1e-6, "{s:?}");
                }
                assert!(s[3].abs() < 1e-12 * stress[0], "{s:?}");
            }
            // The surfaces of `grid` are those of quadrilaterals.
            if triangles {
                continue;
            }
            let accelerations = &last_frame(&prepared(&pressed, &marks))["A"];
            // Masses of refined elements are about a fourth.
            assert!(accelerations.iter().all(|a| a.abs() < 4e-12), "{marks:?} {accelerations:?}");
        }
    }
}
