//! Properties of random valid scenes: energy and momentum are kept, a shift along z and other numbers of nodes and elements
//! change nothing but rounding, and a run that completes holds no number that is not finite.

use std::fmt::Write as _;

use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

use crate::common;
use crate::common::solid::run;

/// A free block of quadrilaterals with uneven corners, thrown and torn by velocities at its nodes.
#[derive(Clone, Debug)]
struct Scene {
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

fn scenes() -> impl Strategy<Value = Scene> {
    let shape = (1_usize..5, 1_usize..5, prop::sample::select(vec![0.0, 0.01, 1.0, 30.0]));
    let material = (0.5_f64..2.0, 0.0_f64..0.49, 0.5_f64..2.0, any::<bool>());
    let wobble = prop::collection::vec(-0.2_f64..0.2, 100);
    (shape, material, wobble, -5.0_f64..-2.0).prop_map(
        |((columns, rows, inner), (young, nu, density, yields), wobble, power)| Scene {
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

impl Scene {
    fn count(&self) -> usize {
        (self.columns + 1) * (self.rows + 1)
    }

    /// The deck, shifted along z; node n gets the label `label(n)`, and elements come in the order of `backwards`.
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

/// What a deck came to: displacements and velocities by node of the scene, the momentum along z before and after, drift.
struct Answer {
    fields: Vec<f64>,
    momentum: [f64; 2],
    drift: f64,
}

fn answer(scene: &Scene, deck: &str, label: impl Fn(usize) -> usize) -> Answer {
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
    assert!(all.into_iter().all(|f| f.values.iter().all(|v| v.is_finite())), "a number that is not finite");
    let field = |name: &str| &frame.point_fields.iter().find(|f| f.name == name).expect("a field").values;
    let [moved, speed] = ["U", "V"].map(|name| common::at_nodes(&prepared, field(name)));
    let mut answer = Answer { fields: Vec::new(), momentum: [0.0; 2], drift: outcome.energy.drift };
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

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |a, b| a.max(b.abs()))
}

#[test]
fn random_scenes_keep_energy_momentum_and_their_answer() {
    let config = Config { cases: 400, failure_persistence: None, ..Config::default() };
    let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    let checked = runner.run(&scenes(), |scene| {
        let plain = answer(&scene, &scene.deck(0.0, |n| n + 1, false), |n| n + 1);
        // The bulk viscosity is booked over the increment behind: first order in it, 1 % of the highest period or so.
        prop_assert!(plain.drift < 5e-3, "drift {:e}", plain.drift);
        let scale = largest(plain.fields.iter().copied()) * scene.density * (scene.inner + 5.0) * 200.0;
        let lost = (plain.momentum[1] - plain.momentum[0]).abs();
        prop_assert!(lost < 1e-12 * scale, "momentum {:?}", plain.momentum);
        // Sums in another order, coordinates with another rounding: after some hundred increments.
        let label = |n: usize| 7 * n + 3;
        for (shift, backwards) in [(16.0, false), (0.0, true)] {
            let other = answer(&scene, &scene.deck(shift, label, backwards), label);
            let off = largest(plain.fields.iter().zip(&other.fields).map(|(a, b)| a - b));
            let size = largest(plain.fields.iter().copied());
            prop_assert!(off < 1e-8 * size + 1e-13, "shift {shift}, backwards {backwards}: off by {off:e} of {size:e}");
        }
        Ok(())
    });
    checked.expect("properties");
}
