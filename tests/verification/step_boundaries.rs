//! Steps without changes, and changes of single conditions.
//!
//! Goal: an analysis split into steps without changes has the same rows, frames, energies and warnings as one step, to
//! the last bit. This includes a restart in a later step. A condition that a later step replaces keeps its history.
//! Source: the analysis in one step. Tolerance: none with identical increments, which `DIRECT USER CONTROL` gives for
//! an increment that is a power of two and steps that are integer multiples of that increment (all sums are exact).
//! With error control the increments at step boundaries differ, and the tolerance is that of the error control.

use std::fs;

use proptest::prelude::any;
use proptest::test_runner::{Config, TestRunner};
use revolve::job::{self, PreparedJob};
use revolve::output::OutputFrame;
use revolve::solve::{self, CheckpointInterval, Instant, Outcome, RunControl, Sink, SinkError};
use revolve::user::{LoadFailure, MotionCall, Routines, UserMotion};

use crate::common::bodies::{assembly, elastic, part, rigid_line};
use crate::common::{RecordedOutput, project};

/// Deck of one step, divided into its parts.
struct SplitDeck {
    /// Path of the deck, used for messages and relative files.
    name: String,
    /// Text before the step.
    head: String,
    /// Keyword line of the procedure without the increment parameters.
    procedure: String,
    conditions: String,
    /// Output requests with an interval in increments.
    output: String,
}

/// Increments between rows, and increments of each analysis: a multiple of `EVERY` times 2 and 5.
const EVERY: u64 = 12;
const ALL: u64 = 240;

impl SplitDeck {
    /// Amplitudes in step time would end with the first step, so they are changed to total time.
    fn new(name: &str, text: &str) -> SplitDeck {
        let lower = text.to_lowercase();
        let at =
            |from: usize, word: &str| from + lower[from..].find(word).unwrap_or_else(|| panic!("{name}: no {word}"));
        let step = at(0, "\n*step") + 1;
        let procedure = at(step, "\n*dynamic") + 1;
        let data = at(procedure, "\n") + 1;
        let conditions = at(data, "\n") + 1;
        let end = at(conditions, "*end step");
        let output = lower[conditions..end].find("*output").map_or(end, |found| conditions + found);
        let in_total_time = |line: &str| {
            let line_lower = line.to_lowercase();
            let is_curve = line_lower.starts_with("*amplitude") && !line_lower.contains("user");
            format!("{line}{}\n", if is_curve { ", time=TOTAL TIME" } else { "" })
        };
        let every = |line: &str| {
            let is_request = line.to_lowercase().starts_with("*output,");
            let kept: Vec<&str> = line.split(',').filter(|w| !is_request || !w.contains("interval")).collect();
            kept.join(",") + &if is_request { format!(", frequency={EVERY}\n") } else { "\n".into() }
        };
        let keyword = lower[procedure..data].split(',').next().expect("a keyword").trim().to_owned();
        SplitDeck {
            name: name.to_owned(),
            head: text[..step].lines().map(in_total_time).collect(),
            procedure: keyword + ", explicit",
            conditions: text[conditions..output].to_owned(),
            output: text[output..end].lines().map(every).collect(),
        }
    }

    fn of_file(name: &str) -> SplitDeck {
        SplitDeck::new(name, &fs::read_to_string(project(name)).expect("a deck"))
    }

    /// Returns the deck with automatic increments and this duration.
    fn automatic(&self, time: f64) -> String {
        format!("{}*Step\n{}\n , {time:e}\n{}*End Step\n", self.head, self.procedure, self.conditions)
    }

    /// Returns the deck with [`ALL`] increments divided into `steps` steps. Later steps repeat the conditions or omit
    /// them.
    fn split(&self, steps: u64, increment: f64, repeats: bool) -> String {
        let mut text = self.head.clone();
        for index in 0..steps {
            let conditions = if index == 0 || repeats { &*self.conditions } else { "" };
            let time = increment * (ALL / steps) as f64;
            text += &format!("*Step\n{}, direct user control\n {increment:e}, {time:e}\n{conditions}", self.procedure);
            text += &format!("{}*End Step\n", self.output);
        }
        text
    }

    fn prepare(&self, text: &str, settings: &[(&str, &str)], routines: &Routines) -> PreparedJob {
        let settings = crate::common::pairs(settings);
        let prepared = job::prepare_text(&project(&self.name).to_string_lossy(), text, &settings, routines);
        let found = prepared.diagnostics.render(&prepared.deck.sources);
        assert!(!prepared.diagnostics.has_errors(), "{}: {found}", self.name);
        prepared
    }

    /// Returns a power of two well below the stable increment of the elements; for a rigid model, below the duration
    /// over [`ALL`].
    fn increment(&self, settings: &[(&str, &str)], time: f64, routines: &Routines) -> f64 {
        let prepared = self.prepare(&self.automatic(0.005 * time), settings, routines);
        let rigid = prepared.state.dofs.nodes.is_empty();
        let bearable = || 0.25 * run(&prepared, RunControl::default()).0.steps[0].largest_increment;
        let bound = if rigid { time / ALL as f64 } else { bearable() };
        bound.log2().floor().exp2()
    }
}

/// Rows and frames in memory, and the checkpoints.
#[derive(Default)]
struct StepRecorder {
    shown: RecordedOutput,
    states: Vec<(Vec<u8>, usize, usize)>,
}

impl Sink for StepRecorder {
    fn wants_frames(&self) -> bool {
        true
    }
    fn frame(&mut self, frame: &OutputFrame) -> Result<(), SinkError> {
        self.shown.frame(frame)
    }
    fn row(&mut self, now: &Instant, values: &[f64]) -> Result<(), SinkError> {
        self.shown.row(now, values)
    }
    fn keeps(&self) -> bool {
        true
    }
    fn keep(&mut self, state: &[u8], _now: &Instant) -> Result<(), SinkError> {
        self.states.push((state.to_vec(), self.shown.rows.len(), self.shown.frames.len()));
        Ok(())
    }
}

fn run(prepared: &PreparedJob, control: RunControl<'_>) -> (Outcome, StepRecorder) {
    let mut keeper = StepRecorder::default();
    let (outcome, _) = solve::run_with(&prepared.plan, prepared.state.clone(), &mut keeper, control).expect("it fits");
    (outcome, keeper)
}

/// Returns the bits of all rows, including their times.
fn row_bits(memory: &RecordedOutput) -> Vec<Vec<u64>> {
    let bits = |(time, values): &(f64, Vec<f64>)| [*time].iter().chain(values).map(|v| v.to_bits()).collect();
    memory.rows.iter().map(bits).collect()
}

fn frame_bits(memory: &RecordedOutput) -> Vec<(u64, Vec<u64>)> {
    let bits = |frame: &OutputFrame| {
        let fields = frame.point_fields.iter().chain(&frame.cell_fields).flat_map(|f| &f.values);
        let all = [frame.time].into_iter().chain(frame.points.iter().flatten().copied()).chain(fields.copied());
        (frame.increment, all.map(f64::to_bits).collect())
    };
    memory.frames.iter().map(bits).collect()
}

/// Returns the final results that are compared, without counts of steps.
fn final_results(outcome: &Outcome) -> String {
    let Outcome { halt, energy, rests, penetrations, unfinished, exits, deleted, warnings, increments, .. } = outcome;
    format!(
        "{halt:?} {energy:?} {rests:?} {penetrations:?} {unfinished:?} {exits:?} {deleted} {warnings:?} {increments}"
    )
}

#[track_caller]
fn assert_same_results(
    what: &str,
    prepared: &PreparedJob,
    found: &(Outcome, RecordedOutput),
    expected: &(Outcome, RecordedOutput),
) {
    let (own, others) = (row_bits(&found.1), row_bits(&expected.1));
    assert_eq!(own.len(), others.len(), "{what}: rows");
    for ((row, other), at) in own.iter().zip(&others).zip(0..) {
        if let Some(column) = (0..row.len()).find(|&i| row[i] != other[i]) {
            let name = column.checked_sub(1).map_or("time", |i| &prepared.plan.columns[i].name);
            let values =
                [&found.1, &expected.1].map(|m| column.checked_sub(1).map_or(m.rows[at].0, |i| m.rows[at].1[i]));
            panic!("{what}: row {at}, {name}: {values:?}");
        }
    }
    assert!(frame_bits(&found.1) == frame_bits(&expected.1), "{what}: frames");
    assert_eq!(final_results(&found.0), final_results(&expected.0), "{what}");
}

/// Asserts equal results of a deck in one step, in 2 and 5 steps without changes, and from a checkpoint in the second
/// of two steps.
fn assert_steps_change_nothing(
    deck: &SplitDeck,
    settings: &[(&str, &str)],
    increment: f64,
    routines: &dyn Fn() -> Routines,
) -> Outcome {
    let ran = |steps: u64, repeats: bool, control: RunControl<'_>| {
        let prepared = deck.prepare(&deck.split(steps, increment, repeats), settings, &routines());
        let (outcome, keeper) = run(&prepared, control);
        (prepared, outcome, keeper)
    };
    let (_, outcome, whole) = ran(1, false, RunControl::default());
    assert_eq!(outcome.increments, ALL, "{}: {:?}", deck.name, outcome.halt);
    let whole = (outcome, whole.shown);
    // If a later step changes conditions, nodal loads that depend on velocity are evaluated at its start with the
    // acceleration there instead of the previous one.
    let reads_velocity = deck.conditions.contains("PNU") || deck.conditions.to_lowercase().contains("cavity");
    // A repeated displacement counts from the current positions: equal only to rounding.
    let counts_anew = deck.conditions.contains("*Boundary, amplitude");
    let repeated = if reads_velocity || counts_anew { None } else { Some((2, true)) };
    for (steps, repeats) in [(2, false), (5, false)].into_iter().chain(repeated) {
        let (prepared, outcome, keeper) = ran(steps, repeats, RunControl::default());
        let changed = prepared.plan.steps[1..].iter().filter(|step| !step.changes.is_empty()).count();
        let what = format!("{} in {steps} steps ({changed} with changes)", deck.name);
        assert_same_results(&what, &prepared, &(outcome, keeper.shown), &whole);
    }
    let every = Some(CheckpointInterval::Increments(3 * ALL / 4));
    let (prepared, _, checkpointed) = ran(2, false, RunControl { every, ..RunControl::default() });
    let (state, row, frame) = &checkpointed.states[0];
    let (outcome, rest) = run(&prepared, RunControl { state: Some(state), ..RunControl::default() });
    let mut shown = checkpointed.shown;
    shown.rows.truncate(*row);
    shown.frames.truncate(*frame);
    shown.rows.extend(rest.shown.rows);
    shown.frames.extend(rest.shown.frames);
    assert_same_results(&format!("{} from a checkpoint", deck.name), &prepared, &(outcome, shown), &whole);
    whole.0
}

fn check_example(name: &str, settings: &[(&str, &str)]) -> Outcome {
    let routines = || Routines::none().with_pressure(|points, i| 1e6 * points.amplitude * (2.0 - points.r[i]));
    let deck = SplitDeck::of_file(name);
    let time =
        deck.prepare(&fs::read_to_string(project(name)).expect("a deck"), settings, &routines()).plan.steps[0].duration;
    // An increment ends early when a body comes to rest or a force is discontinuous, so the analysis has fewer complete
    // increments.
    let mut increment = deck.increment(settings, time, &routines());
    let increments = |dt: f64| {
        run(&deck.prepare(&deck.split(1, dt, false), settings, &routines()), RunControl::default()).0.increments
    };
    while increments(increment) != ALL {
        increment *= 0.5;
    }
    assert_steps_change_nothing(&deck, settings, increment, &routines)
}

#[test]
fn rigid_examples_do_not_depend_on_steps() {
    for name in
        ["ogive", "oblique", "ogive_steel", "ogive_rod", "plate_6061", "plates_derived", "ogive_user", "gauntlet/disc"]
    {
        check_example(&format!("input/{name}.inp"), &[]);
    }
    let outcome = check_example("input/oblique.inp", &[("friction", "0.1")]);
    assert_eq!(outcome.penetrations.len(), 1);
}

#[test]
fn deformable_examples_do_not_depend_on_steps() {
    for name in [
        "blast_disk",
        "debonding_disc",
        "forging",
        "long_rod",
        "ogive_meshed",
        "ogive_rod_meshed",
        "press_fit",
        "punch_rubber",
        "push_out",
        "rod_plate_deletion",
        "sphere_on_plate",
        "taylor_copper",
        "tube_crush",
        "upsetting",
    ] {
        check_example(&format!("input/{name}.inp"), &[]);
    }
}

#[test]
fn gauntlet_scenes_do_not_depend_on_steps() {
    for name in [
        "bending",
        "cylinder",
        "flight",
        "impact",
        "impact_controlled",
        "layers",
        "necking",
        "needle",
        "point_load",
        "release",
        "stiff_load",
        "units",
        "void",
    ] {
        check_example(&format!("input/gauntlet/{name}.inp"), &[]);
    }
}

/// Sinusoidal user motion.
struct SineMotion;

impl UserMotion for SineMotion {
    fn motion(&mut self, call: &MotionCall<'_>) -> Result<f64, LoadFailure> {
        Ok(0.01 * call.now.total_time)
    }
}

/// Returns a block that slides along another one and a light rigid plate pushed against it, with the loads and
/// constraints selected by the bits of `kinds`.
fn scene(kinds: u32) -> SplitDeck {
    let has = |bit: u32| kinds >> bit & 1 == 1;
    let either = |bit: u32, yes: &str, no: &str| if has(bit) { yes.to_owned() } else { no.to_owned() };
    let corner = "*Nset, nset=INNER\n 8\n*Nset, nset=BESIDE\n 9\n";
    let blast = "*Incident Wave Interaction Property, name=TNT, type=AIR BLAST\n*Conwep Charge Property\n 1., 1.e-2\n 1., 0.01, 1.e7\n";
    let charge = "*Node, nset=CHARGE\n 9100, 0., 3.\n";
    let damping = either(20, "*Damping, alpha=0.1, beta=0.02\n", "");
    let spring = either(0, "*Element, type=SPRING1, elset=SPRING\n 9000, 3\n*Spring, elset=SPRING\n 2,\n 0.5,\n", "");
    let lower = part("LOWER", [12, 2], |i, j| [1.0 + 0.15 * i as f64, 0.15 * j as f64 - 0.3], "");
    let upper =
        part("UPPER", [5, 3], |i, j| [1.3 + 0.14 * i as f64, 0.002 + 0.14 * j as f64], &(corner.to_owned() + &spring));
    let mass = "*Element, type=MASS, elset=M\n 900, 1000\n*Mass, elset=M\n 0.02,\n";
    let plate = rigid_line("PLATE", &[[9.0, 0.424], [0.5, 0.424]], mass);
    let contact = match (has(1), has(2)) {
        (true, _) => "*Contact\n*Contact Inclusions, all exterior\n*Contact Property Assignment\n , , DRY\n".into(),
        (_, penalty) => {
            let law = if penalty { ", mechanical constraint=PENALTY" } else { "" };
            format!("*Contact Pair, interaction=DRY{law}\n LOWER.J1, UPPER.J0\n UPPER.J1, PLATE.SKIN\n")
        }
    };
    let head = lower
        + &upper
        + &plate
        + &assembly(&["LOWER", "UPPER", "PLATE"], &format!("{charge}*Rigid Body, ref node=PLATE.REF, elset=PLATE.E\n"))
        + &elastic("LOWER", [1.0, 0.3, 1.0], &either(3, "*Conductivity\n 0.01,\n*Specific Heat\n 1.,\n", ""))
        + &elastic(
            "UPPER",
            [1.0, 0.3, 1.0],
            &(either(3, "*Conductivity\n 0.01,\n*Specific Heat\n 1.,\n", "") + &damping),
        )
        + blast
        + &either(4, "*Equation\n 2\n UPPER.INNER, 1, 1., UPPER.BESIDE, 1, -1.\n", "")
        + "*Surface Interaction, name=DRY\n*Friction\n 0.2,\n*Amplitude, name=UP\n 0., 0., 1., 1., 2., 0.5\n"
        + "*Initial Conditions, type=VELOCITY\n UPPER.ALL, 1, 0.05\n UPPER.ALL, 2, -0.02\n*Step\n*Dynamic, Explicit\n , 1.\n";
    let conditions = "*Boundary\n LOWER.J0, 1, 2\n".to_owned()
        + &contact
        + &either(5, "*Cload\n PLATE.REF, 2, -0.002\n", "")
        + &either(6, "*Cload, amplitude=UP\n UPPER.J1, 1, 1.e-4\n", "")
        + &either(7, "*Dload\n , GRAV, 0.01, 0., -1.\n", "")
        + &either(8, "*Dsload, amplitude=UP\n UPPER.J1, P, 1.e-3\n", "")
        + &either(9, "*Dsload\n UPPER.I1, PNU\n", "")
        + &either(10, "*Boundary, amplitude=UP\n UPPER.I1, 1, 1, 0.01\n", "")
        + &either(11, "*Boundary, type=VELOCITY, amplitude=UP\n UPPER.INNER, 2, 2, -0.01\n", "")
        + &either(12, "*Boundary, type=ACCELERATION\n UPPER.BESIDE, 2, 2, -0.01\n", "")
        + &either(13, "*Boundary, user\n LOWER.I0, 1, 1\n", "")
        + &either(14, "*Variable Mass Scaling, dt=0.03, type=BELOW MIN, frequency=7\n", "")
        + &either(15, "*Fixed Mass Scaling, factor=1.5\n", "")
        + &either(
            16,
            "*Dsload, amplitude=UP\n UPPER.I1, TRVEC, 1.e-3, 1., 1.\n PLATE.SKIN, TRSHR, 1.e-3, 0., 1.\n",
            "",
        )
        + &either(17, "*Dsload\n UPPER.I1, VP, 0.3\n", "")
        + &either(18, "*Dload\n UPPER.SOLID, BZ, 1.e-3\n UPPER.SOLID, CENTRIF, 1.e-3\n", "")
        + &either(19, "*Incident Wave Interaction, property=TNT, conwep\n UPPER.I1, CHARGE\n", "");
    let conditions = if has(3) {
        conditions + "*Boundary\n LOWER.J0, 11, 11, 5.\n*Cflux\n UPPER.INNER, 11, 0.01\n"
    } else {
        conditions
    };
    let output = "*Output, field, number interval=1\n*Node Output\n U, V, A, RF\n*Element Output\n S\n*Output, history, number interval=1\n\
        *Energy Output\n ALL\n*Node Output, nset=PLATE.REF\n U2, V2, A2\n*Contact Output, nset=UPPER.J0\n CPRESS, CSLIP, CSHEAR1\n*End Step\n";
    let text = head + &conditions + output;
    let text = if has(3) {
        text.replace("CAX4R", "CAX4RT").replace("*Dynamic, Explicit", "*Dynamic Temperature-displacement, Explicit")
    } else {
        text
    };
    SplitDeck::new(&format!("scene {kinds:#b}"), &text)
}

fn scene_routines() -> Routines {
    Routines::none().with_motion(SineMotion).with_pressure(|points, i| 1e-3 * (1.0 - 0.5 * points.velocity_r[i]))
}

/// Each kind of load and constraint alone with contact, all kinds together, and random combinations.
#[test]
fn loads_and_constraints_do_not_depend_on_steps() {
    let check = |kinds: u32| assert_steps_change_nothing(&scene(kinds), &[], 1.0 / 64.0, &scene_routines);
    (0..21).for_each(|bit| {
        check(1 << bit);
    });
    let mut runner = TestRunner::new_with_rng(
        Config { cases: 24, failure_persistence: None, ..Config::default() },
        proptest::test_runner::TestRng::deterministic_rng(proptest::test_runner::RngAlgorithm::ChaCha),
    );
    runner
        .run(&any::<u32>(), |kinds| {
            check(kinds & 0x1f_ffff);
            Ok(())
        })
        .expect("equal results with several steps");
}

/// A stretched bar whose end is released in the second step. The node is at rest until then, so the energy of the initial
/// stress V s^2/(2 E) remains, and the free end moves with s/(rho c) (wave equation) from then on. The increment changes
/// with the released node, or with an output at the end of the first step.
#[test]
fn release_of_a_stretched_bar_conserves_energy() {
    for (rows, first) in [(40, "2.e-6"), (40, "1.99e-6"), (80, "0.7e-6"), (160, "2.e-6")] {
        let (stress, length) = (100e6, 0.1);
        let deck = crate::common::solid::grid(1, rows, false, |i, j| {
            [0.01 * i as f64, length * j as f64 / rows as f64]
        }) + "*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n 7800.,\n*Elastic\n 200.e9, 0.\n\
               *Initial Conditions, type=STRESS\n SOLID, 0., 100.e6, 0., 0.\n*Boundary\n ALL, 1\n J0, 2\n*Nset, nset=TOP\n J1\n"
            + &format!(
                "*Step\n*Dynamic, Explicit\n , {first}\n*Bulk Viscosity\n 0., 0.\n*Boundary\n J1, 2\n*End Step\n\
                 *Step\n*Dynamic, Explicit\n , 15.e-6\n*Bulk Viscosity\n 0., 0.\n*Boundary, op=NEW\n ALL, 1\n J0, 2\n\
                 *Output, history, number interval=20\n*Node Output, nset=TOP, statistics=MEAN\n U2\n\
                 *Energy Output\n ALLKE, ALLIE, ETOTAL\n*End Step\n"
            );
        let (outcome, shown) = crate::common::run(&deck, &[], &Routines::none());
        let prepared = crate::common::prepared(&deck, &[], &Routines::none());
        let column = |name: &str| prepared.plan.columns.iter().position(|c| c.name.starts_with(name)).expect(name);
        let (kinetic, total, moved) = (column("ALLKE"), column("ETOTAL"), column("U2"));
        let stored = std::f64::consts::PI * 1e-4 * length * stress * stress / (2.0 * 200e9);
        let speed = stress / (7800.0 * 200e9_f64).sqrt();
        assert_eq!(outcome.halt, None);
        let last = &shown.rows.last().expect("a row").1;
        println!("{rows} {first}: {} {stored} {} {}", last[kinetic], last[total] / stored, last[moved]);
        // The last increments are shortened, which moves ETOTAL where the front accelerates nodes.
        let complete = shown.rows.iter().filter(|row| row.0 < 12e-6);
        let drift = complete.map(|row| row.1[total].abs()).fold(0.0, f64::max);
        assert!(drift < 1e-4 * stored, "{rows}: ETOTAL {drift} of {stored}");
        // The wave has passed 15 us of the 19.7 us of the bar; the energy next to the free end is kinetic.
        let behind = 15e-6 * (200e9_f64 / 7800.0).sqrt() / length;
        assert!(
            (last[kinetic] / (behind * stored) - 1.0).abs() < 0.6 / rows as f64 + 0.01,
            "{rows}: {}",
            last[kinetic]
        );
        assert!((last[moved] / (-speed * 15e-6) - 1.0).abs() < 2.0 / rows as f64, "{rows}: {}", last[moved]);
    }
}
