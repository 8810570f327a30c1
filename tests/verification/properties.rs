//! Properties of random valid scenes: energy and momentum are conserved, a shift along z and other node and element
//! numbers change results by rounding only, and all results of a completed run are finite.

use std::fmt::Write as _;

use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

use crate::common;
use crate::common::solid::run;

/// Free block of irregular quadrilaterals with random nodal velocities.
#[derive(Clone, Debug)]
struct RandomBlock {
    columns: usize,
    rows: usize,
    inner: f64,
    wobble: Vec<f64>,
    young: f64,
    nu: f64,
    density: f64,
    yields: bool,
    speed: f64,
}

fn random_blocks() -> impl Strategy<Value = RandomBlock> {
    let shape = (1_usize..5, 1_usize..5, prop::sample::select(vec![0.0, 0.01, 1.0, 30.0]));
    let material = (0.5_f64..2.0, 0.0_f64..0.49, 0.5_f64..2.0, any::<bool>());
    let wobble = prop::collection::vec(-0.2_f64..0.2, 100);
    (shape, material, wobble, -5.0_f64..-2.0).prop_map(
        |((columns, rows, inner), (young, nu, density, yields), wobble, power)| RandomBlock {
            columns,
            rows,
            inner,
            wobble,
            young,
            nu,
            density,
            yields,
            speed: 10_f64.powf(power),
        },
    )
}

impl RandomBlock {
    fn count(&self) -> usize {
        (self.columns + 1) * (self.rows + 1)
    }

    /// Returns the deck, shifted along z, with label `label(n)` of node n and elements in reverse order if `backwards`.
    fn deck(&self, shift: f64, label: impl Fn(usize) -> usize, backwards: bool) -> String {
        let (c, mut text) = (self.columns, String::from("*Node, nset=ALL\n"));
        let mut nodes: Vec<usize> = (0..self.count()).collect();
        let mut elements: Vec<usize> = (0..c * self.rows).collect();
        if backwards {
            nodes.reverse();
            elements.reverse();
        }
        for n in nodes {
            let (i, j) = (n % (c + 1), n / (c + 1));
            let (mut r, z) = (self.inner + i as f64 + self.wobble[n], j as f64 + self.wobble[n + 40] + shift);
            if i == 0 {
                r = self.inner;
            }
            writeln!(text, " {}, {r:.17e}, {z:.17e}", label(n)).expect("text");
        }
        text += "*Element, type=CAX4R, elset=SOLID\n";
        for e in elements {
            let n = e / c * (c + 1) + e % c;
            let corners = [n, n + 1, n + c + 2, n + c + 1].map(|n| label(n).to_string());
            writeln!(text, " {}, {}", e + 1, corners.join(", ")).expect("text");
        }
        let plastic = if self.yields { format!("*Plastic\n {:e}, 0.\n", 0.3 * self.speed) } else { String::new() };
        text += &common::solid::material(self.young, self.nu, self.density, &plastic);
        text += "*Initial Conditions, type=VELOCITY\n";
        for n in 0..self.count() {
            let (v_r, v_z) = (self.speed * self.wobble[n + 20], self.speed * self.wobble[n + 60]);
            if n % (c + 1) > 0 {
                writeln!(text, " {}, 1, {v_r:.17e}", label(n)).expect("text");
            }
            writeln!(text, " {}, 2, {v_z:.17e}", label(n)).expect("text");
        }
        let axis: Vec<String> = (0..=self.rows).map(|j| format!(" {}, 1, 1\n", label(j * (c + 1)))).collect();
        text + "*Step\n*Dynamic, Explicit, direct user control\n 0.01, 10.\n*Boundary\n"
            + &axis.concat()
            + "*Output, field, number interval=1\n*Node Output\n U, V\n*Element Output\n S\n*End Step\n"
    }
}

/// Results of a deck: displacements and velocities by node of the scene, initial and final axial momentum, energy
/// drift.
struct SceneResult {
    fields: Vec<f64>,
    momentum: [f64; 2],
    drift: f64,
}

fn run_scene(scene: &RandomBlock, deck: &str, label: impl Fn(usize) -> usize) -> SceneResult {
    let prepared = common::prepared(deck, &[], &revolve::user::Routines::none());
    let nodes = &prepared.state.dofs.nodes;
    let node = |n: usize| {
        let at = prepared.plan.mesh.node_names.iter().position(|name| *name == label(n).to_string()).expect("a node");
        prepared.plan.places.nodes[&at]
    };
    let (outcome, memory) = run(deck);
    assert_eq!(outcome.halt, None);
    let frame = memory.frames.last().expect("a frame");
    let all = frame.point_fields.iter().chain(&frame.cell_fields);
    assert!(all.into_iter().all(|f| f.values.iter().all(|v| v.is_finite())), "non-finite value");
    let field = |name: &str| &frame.point_fields.iter().find(|f| f.name == name).expect("a field").values;
    let [moved, speed] = ["U", "V"].map(|name| common::at_nodes(&prepared, field(name)));
    let mut answer = SceneResult { fields: Vec::new(), momentum: [0.0; 2], drift: outcome.energy.drift };
    for n in 0..scene.count() {
        let at = node(n);
        for axis in 0..2 {
            answer.fields.push(moved[at][axis]);
            answer.fields.push(speed[at][axis]);
        }
        answer.momentum[0] += nodes.mass[at] * nodes[at].v_z;
        answer.momentum[1] += nodes.mass[at] * speed[at][1];
    }
    answer
}

fn largest_value(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |a, b| a.max(b.abs()))
}

#[test]
fn random_scenes_conserve_energy_and_momentum() {
    let config = Config { cases: 400, failure_persistence: None, ..Config::default() };
    let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    let checked = runner.run(&random_blocks(), |scene| {
        let plain = run_scene(&scene, &scene.deck(0.0, |n| n + 1, false), |n| n + 1);
        // The work of the bulk viscosity is that of the previous increment: an error of first order in the increment,
        // which is about 1 % of the shortest period.
        prop_assert!(plain.drift < 5e-3, "drift {:e}", plain.drift);
        let scale = largest_value(plain.fields.iter().copied()) * scene.density * (scene.inner + 5.0) * 200.0;
        let lost = (plain.momentum[1] - plain.momentum[0]).abs();
        prop_assert!(lost < 1e-12 * scale, "momentum {:?}", plain.momentum);
        // Sums in another order and coordinates with other rounding, after some hundred increments.
        let label = |n: usize| 7 * n + 3;
        for (shift, backwards) in [(16.0, false), (0.0, true)] {
            let other = run_scene(&scene, &scene.deck(shift, label, backwards), label);
            let off = largest_value(plain.fields.iter().zip(&other.fields).map(|(a, b)| a - b));
            let size = largest_value(plain.fields.iter().copied());
            prop_assert!(off < 1e-8 * size + 1e-13, "shift {shift}, backwards {backwards}: error {off:e} of {size:e}");
        }
        Ok(())
    });
    checked.expect("properties");
}
