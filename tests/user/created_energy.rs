//! User materials that create energy, and energy limits of every run.
//!
//! Goal: energy from nothing halts a run although ETOTAL is constant, on fixed, adaptive and new meshes, over several
//! steps, and after an energy was put in by loads. Source: conservation of energy. The same material without the
//! fault runs without a warning.

use revolve::solve::{self, CheckpointInterval, Instant, Outcome, RunControl, Sink, SinkError};
use revolve::user::{LoadFailure, MaterialAnswer, MaterialCall, Routines, UserMaterial};

use crate::common;
use crate::common::solid::grid;

/// Linear elasticity, whose stress also grows at a constant rate. Constants: bulk and shear modulus, rate.
struct GrowingStress;

impl UserMaterial for GrowingStress {
    fn stress(&mut self, call: &MaterialCall<'_>, answer: &mut MaterialAnswer<'_>) -> Result<(), LoadFailure> {
        let n = call.count;
        let (bulk, shear2) = (call.properties[0], 2.0 * call.properties[1]);
        let growth = if call.now.total_time > 0.0 { 1.0 + call.properties[2] * call.dt } else { 1.0 };
        for i in 0..n {
            let mean = (call.strain[i] + call.strain[n + i] + call.strain[2 * n + i]) / 3.0;
            for k in 0..4 {
                let dilation = if k < 3 { mean } else { 0.0 };
                let elastic = 3.0 * bulk * dilation + shear2 * (call.strain[k * n + i] - dilation);
                answer.stress[k * n + i] = growth * call.stress[k * n + i] + elastic;
            }
        }
        Ok(())
    }
}

/// Returns a bar in free longitudinal vibration; `rate` is that of the growth of its stress.
fn vibration(rate: f64, cards: &str, more_steps: &str) -> String {
    let (remesh, cards) = if cards.starts_with("*Remesh") { (cards, "") } else { ("", cards) };
    // One inner node out of line, so that `*REMESH` makes a new mesh at once.
    let shift = |i: usize, j: usize| if (i, j) == (1, 6) { 0.15 } else { 0.0 };
    let mut deck = grid(3, 12, false, |i, j| [i as f64 / 3.0 + shift(i, j), j as f64 / 3.0 + shift(i, j)]);
    for row in 0..=12 {
        deck += &format!("*Nset, nset=ROW{row}, generate\n {}, {}, 1\n", 4 * row + 1, 4 * row + 4);
    }
    deck += "*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n 2.,\n";
    deck += &format!("*User Material, constants=3\n 833.3333333333334, 384.6153846153846, {rate}\n");
    deck += remesh;
    deck += "*Initial Conditions, type=VELOCITY\n";
    for row in 0..=12 {
        deck += &format!(" ROW{row}, 2, {}\n", 0.02 * (f64::from(row) - 6.0) / 6.0);
    }
    deck + "*Step\n*Dynamic, Explicit\n , 20.\n*Bulk Viscosity\n 0., 0.\n"
        + cards
        + "*Output, history, number interval=5\n*Energy Output\n ALLKE, ETOTAL\n*End Step\n"
        + more_steps
}

fn outcome(text: &str) -> Outcome {
    common::run(text, &[], &Routines::none().with_material(GrowingStress)).0
}

/// Asserts that a run ends with a term that exceeds the energy put in, while ETOTAL is constant.
fn assert_halts(text: &str, transfer: &str) {
    let Outcome { halt, energy, .. } = outcome(text);
    let halt = halt.unwrap_or_else(|| panic!("{transfer}: no halt, {energy:?}"));
    println!("{transfer}: {}", halt.message());
    assert_eq!(halt.code(), "R208", "{transfer}: {}", halt.message());
    for word in ["times the energy put in", "energy was created", "check the user material", "*ENERGY LIMIT"] {
        assert!(halt.message().contains(word), "{transfer}: {}", halt.message());
    }
    assert!(energy.drift < 0.05, "{transfer}: ETOTAL drifts by {}", energy.drift);
    // ALLKE reaches twice the energy put in, or ALLIE its negative.
    assert!(energy.kinetic > 1.5 * energy.initial || energy.internal < -0.9 * energy.initial, "{transfer}: {energy:?}");
}

#[test]
fn created_energy_halts_on_every_mesh() {
    let step = "*Step\n*Dynamic, Explicit\n , 20.\n*End Step\n";
    assert_halts(&vibration(0.4, "", ""), "one step");
    assert_halts(&vibration(0.2, "", &step.repeat(3)), "four steps");
    assert_halts(&vibration(0.4, "*Adaptive Mesh, elset=SOLID\n", ""), "adaptive mesh");
    let remeshed = vibration(0.4, "*Remesh, elset=SOLID, angle=59.9, frequency=5\n", "");
    assert_halts(&remeshed, "new mesh");
    assert!(outcome(&remeshed).new_meshes.iter().any(|meshes| meshes.count > 0));
}

/// Stores the states of checkpoints.
#[derive(Default)]
struct States(Vec<Vec<u8>>);

impl Sink for States {
    fn row(&mut self, _now: &Instant, _values: &[f64]) -> Result<(), SinkError> {
        Ok(())
    }
    fn keeps(&self) -> bool {
        true
    }
    fn keep(&mut self, state: &[u8], _now: &Instant) -> Result<(), SinkError> {
        self.0.push(state.to_vec());
        Ok(())
    }
}

/// A resumed run keeps the energy put in before, and how long the excess has lasted: it halts at the same increment with
/// the same message.
#[test]
fn resumed_runs_halt_at_the_same_increment() {
    let text = vibration(0.4, "", "");
    let run = |control: RunControl<'_>| {
        let prepared = common::prepared(&text, &[], &Routines::none().with_material(GrowingStress));
        let mut states = States::default();
        let (outcome, _) =
            solve::run_with(&prepared.plan, prepared.state, &mut states, control).expect("the state fits");
        (format!("{:?} {:?}", outcome.halt, outcome.warnings), states.0)
    };
    let every = Some(CheckpointInterval::Increments(150));
    let (whole, states) = run(RunControl { every, ..RunControl::default() });
    assert!(whole.contains("EnergyLimit") && states.len() > 2, "{whole}");
    for state in &states {
        assert_eq!(run(RunControl { state: Some(state), ..RunControl::default() }).0, whole);
    }
}

/// Without growth the same body has warnings of its hourglass pattern only.
#[test]
fn correct_material_has_no_warning_of_energy() {
    let Outcome { halt, warnings, energy, .. } = outcome(&vibration(0.0, "", ""));
    let is_of_energy = |w: &String| w.starts_with("R301") || w.starts_with("R303");
    assert!(
        halt.is_none() && !warnings.iter().any(is_of_energy) && energy.drift < 1e-2,
        "{halt:?} {warnings:?} {energy:?}"
    );
}

/// Growth that ends at 1.3 times the energy put in is a warning; a limit of the deck raises that of the halt.
#[test]
fn small_excess_warns_and_the_deck_raises_the_limit() {
    let Outcome { halt, warnings, .. } = outcome(&vibration(0.015, "", ""));
    println!("{warnings:?}");
    assert!(halt.is_none(), "{halt:?}");
    assert!(warnings.iter().any(|w| w.starts_with("R303: ALL") && w.contains("of the energy put in")), "{warnings:?}");
    let limited = outcome(&vibration(0.4, "*Energy Limit, error=1.e6\n", ""));
    assert!(limited.halt.is_none() && limited.energy.kinetic > 2.0 * limited.energy.initial, "{:?}", limited.halt);
    let strict = outcome(&vibration(0.4, "*Energy Limit, error=0.5\n", ""));
    assert_eq!(strict.halt.map(|h| h.code()), Some("R208"));
}

/// Returns a block of TNT in free expansion with the constants omega, R1, R2.
fn explosive(constants: [f64; 3]) -> String {
    let [first, second, third] = constants;
    grid(10, 10, false, |i, j| [1e-3 * i as f64, 1e-3 * j as f64])
        + "*Solid Section, elset=SOLID, material=TNT\n*Material, name=TNT\n*Density\n 1630.,\n*Eos, type=JWL\n"
        + &format!(" 6930., 3.712e11, 3.231e9, {first}, {second}, {third}, 4.29e6, 2.e9\n")
        + "*Detonation Point\n 0., 0., 1.e-6\n*Boundary\n J0, 2\n*Step\n*Dynamic, Explicit\n , 6.e-6\n\
           *Output, history, number interval=5\n*Energy Output\n ALLKE, ALLIE\n*End Step\n"
}

/// The chemical energy of an explosive is no excess. With omega, R1 and R2 in another order the same explosive releases a
/// hundred times the energy of the elements that the front has reached.
#[test]
fn explosives_release_their_chemical_energy_only() {
    let run = |text: &str| common::run(text, &[], &Routines::none()).0;
    let right = run(&explosive([0.3, 4.15, 0.95]));
    assert!(right.halt.is_none() && right.warnings.is_empty(), "{:?} {:?}", right.halt, right.warnings);
    let chemical = std::f64::consts::PI * 1e-6 * 1630.0 * 4.29e6;
    assert!(right.energy.kinetic > 0.5 * chemical && right.energy.kinetic < chemical, "{:?}", right.energy);
    let wrong = run(&explosive([4.15, 0.95, 0.3]));
    let halt = wrong.halt.expect("a halt");
    assert!(halt.code() == "R208" && halt.message().contains("times the energy put in"), "{}", halt.message());
}
