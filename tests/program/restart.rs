//! Restart from checkpoints.
//!
//! Goal: a run resumed from any checkpoint has the bits of an uninterrupted run: rows, frames, summaries and digest.
//! Source: the uninterrupted run. Tolerance: none.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use revolve::job::{self, JobOptions, RestartRequirement};
use revolve::output::{JobFiles, OutputFrame};
use revolve::solve::Instant;
use revolve::solve::{self, CheckpointInterval, Outcome, Progress, RunControl, Sink, SinkError};
use revolve::study::quantity::{FinishedRun, Quantity};
use revolve::user::compile::compile;
use revolve::user::{
    AmplitudeAnswer, AmplitudeCall, AnalysisMoment, FieldAnswer, FieldCall, HardeningAnswer, HardeningCall,
    LoadFailure, LoadPoints, MaterialAnswer, MaterialCall, MotionCall, Routines, RunAction, UserAmplitude, UserEvents,
    UserFields, UserHardening, UserLoad, UserMaterial, UserMotion,
};

use crate::common;
use crate::common::bodies::{BOTH_ADAPTIVE, assembly, elastic, part, punch_and_block, rigid_line};
use crate::common::solid::{grid, in_six_node_triangles, material};
use crate::common::{RecordedOutput, prepared, project};

/// Sink that stores rows, frames and checkpoints, each with the numbers of rows and frames before it.
#[derive(Default)]
struct CheckpointRecorder {
    shown: RecordedOutput,
    states: Vec<(Vec<u8>, usize, usize)>,
}

impl Sink for CheckpointRecorder {
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

fn rows(memory: &RecordedOutput, from: usize) -> Vec<Vec<u64>> {
    let bits = |(time, values): &(f64, Vec<f64>)| [*time].iter().chain(values).map(|v| v.to_bits()).collect();
    memory.rows[from..].iter().map(bits).collect()
}

fn frames(memory: &RecordedOutput, from: usize) -> Vec<(u64, Vec<u64>)> {
    let bits = |frame: &OutputFrame| {
        let fields = frame.point_fields.iter().chain(&frame.cell_fields).flat_map(|f| &f.values);
        let all = [frame.time].into_iter().chain(frame.points.iter().flatten().copied()).chain(fields.copied());
        (frame.increment, all.map(f64::to_bits).collect())
    };
    memory.frames[from..].iter().map(bits).collect()
}

/// Returns the parts of an outcome that are compared.
fn ending(outcome: &Outcome) -> String {
    let Outcome { halt, ended_by_user, steps, energy, rests, increments, digest, .. } = outcome;
    format!("{halt:?} {ended_by_user} {steps:?} {energy:?} {rests:?} {increments} {digest}")
}

fn run(text: &str, routines: &Routines, control: RunControl<'_>) -> (Outcome, CheckpointRecorder) {
    let prepared = prepared(text, &[], routines);
    let mut keeper = CheckpointRecorder::default();
    let (outcome, _) = solve::run_with(&prepared.plan, prepared.state, &mut keeper, control).expect("the state fits");
    (outcome, keeper)
}

/// Writes about six checkpoints of a deck and resumes from each.
pub(crate) fn assert_resumes(name: &str, text: &str, routines: impl Fn() -> Routines) -> Outcome {
    let (whole, reference) = run(text, &routines(), RunControl::default());
    assert!(whole.increments > 12, "{name}: {whole:?}");
    let every = Some(CheckpointInterval::Increments(whole.increments / 6));
    let (kept, keeper) = run(text, &routines(), RunControl { every, ..RunControl::default() });
    assert_eq!(ending(&kept), ending(&whole), "{name}: writing checkpoints changes the run");
    assert!(keeper.states.len() >= 4, "{name}: {} states", keeper.states.len());
    for (i, (state, row, frame)) in keeper.states.iter().enumerate() {
        let control = RunControl { state: Some(state), ..RunControl::default() };
        let (outcome, more) = run(text, &routines(), control);
        assert_eq!(ending(&outcome), ending(&whole), "{name}: state {i}");
        assert!(rows(&more.shown, 0) == rows(&reference.shown, *row), "{name}: rows after state {i}");
        assert!(frames(&more.shown, 0) == frames(&reference.shown, *frame), "{name}: frames after state {i}");
    }
    whole
}

/// Returns a bar of `n` by 4 `n` elements that flies against its fixed foot, with all output variables.
pub(crate) fn bar(n: usize, material: &str, speed: f64, time: f64, cards: &str) -> String {
    let (width, height) = (3.2 / n as f64, 12.8 / (4 * n) as f64);
    grid(n, 4 * n, false, |i, j| [width * i as f64, height * j as f64])
        + material
        + &format!(
            "*Nset, nset=TOP\n 5\n*Initial Conditions, type=VELOCITY\n ALL, 2, {:e}\n*Step\n*Dynamic, Explicit\n , {time:e}\n\
             *Boundary\n I0, 1, 1\n J0, 2, 2\n{cards}*Output, field, number interval=7\n*Node Output\n U, V, A, RF\n\
             *Element Output\n ALL\n*Output, history, number interval=23\n*Node Output, nset=TOP\n U, V, A\n\
             *Node Output, nset=J0\n RF2\n*Node Output, nset=J0, statistics=SUM\n RF2\n*Output Expression\n PUSH = 2*RF2_SUM@J0\n*Energy Output\n ALL\n*Incrementation Output\n DT\n*End Step\n",
            -speed
        )
}

fn steel(cards: &str) -> String {
    material(206e3, 0.3, 7.83e-9, cards)
}

pub(crate) fn bare(cards: &str) -> String {
    format!("*Solid Section, elset=SOLID, material=M\n*Material, name=M\n{cards}")
}

const JOHNSON_COOK: &str = "*Plastic, hardening=JOHNSON COOK\n 90., 292., 0.31, 1.09, 1058., 25.\n\
     *Rate Dependent, type=JOHNSON COOK\n 0.025, 1.\n*Specific Heat\n 3.83e8,\n*Inelastic Heat Fraction\n 0.9,\n";

/// Nodal temperatures with all heat sources and sinks, plastic heat and thermal strain.
#[test]
fn nodal_temperatures_resume() {
    let cards = format!("{JOHNSON_COOK}*Conductivity\n 5e4, 0.\n 9e4, 300.\n*Expansion\n 1.2e-5,\n");
    let heat = "*Boundary\n J0, 11, 11, 30.\n*Film\n EI1, F2, 10., 1e4\n*Dflux\n EJ1, S3, 1e6\n SOLID, BF, 1e7\n*Cflux\n 5, 11, 1e3\n";
    let text = bar(4, &steel(&cards), 2e5, 5e-6, heat)
        .replace("CAX4R", "CAX4RT")
        .replace("*Dynamic, Explicit", "*Dynamic Temperature-displacement, Explicit")
        .replace("U, V, A, RF", "U, V, A, RF, NT, RFL");
    let outcome = assert_resumes("heat", &text, Routines::none);
    assert!(outcome.energy.heat.is_some_and(|heat| heat != 0.0), "{:?}", outcome.energy);
}

/// Six degrees of freedom: ricochet from an inclined target, and arrest in one, with yaw and friction.
#[test]
fn bodies_with_six_degrees_of_freedom_resume() {
    let text = fs::read_to_string(project("input/oblique.inp")).expect("a deck");
    let text =
        text.replace("stations  = 64", "stations = 16").replace("n     = 20", "n = 8").replace("m     = 10", "m = 3");
    let ricochet = text.replace("V         = 500.", "V = 400.").replace("obliquity = 30.", "obliquity = 65.");
    let outcome = assert_resumes("ricochet", &ricochet, Routines::none);
    assert_eq!(outcome.penetrations[0].end, "ricochet");
    let stuck = text
        .replace("V         = 500.", "V = 250.")
        .replace("shank = 0.0593", "shank = 0.002")
        .replace("friction = 0.", "friction = 0.05")
        .replace("yaw       = 0.", "yaw = 3.");
    let outcome = assert_resumes("rest", &stuck, Routines::none);
    assert_eq!(outcome.penetrations[0].end, "at rest");
}

#[test]
fn every_material_law_resumes() {
    let head = "*Density\n 2.785e-9,\n";
    let gas = "*Density\n 1.2e-12,\n*Eos, type=IDEAL GAS\n 2.87e8, 0.\n*Specific Heat\n 7.175e8,\n\
         *Initial Conditions, type=SPECIFIC ENERGY\n SOLID, 2.1e11\n";
    for (name, material, speed, time) in [
        ("elastic", steel(""), 1e4, 5e-6),
        ("plastic", steel("*Plastic\n 400., 0.\n 500., 0.1\n"), 2e5, 5e-6),
        ("kinematic", steel("*Plastic, hardening=KINEMATIC\n 400., 0.\n 500., 0.1\n"), 2e5, 5e-6),
        ("Johnson-Cook", steel(JOHNSON_COOK), 2e5, 5e-6),
        ("deletion", steel("*Plastic\n 400., 0.\n 500., 0.1\n*Shear Failure\n 0.05,\n"), 2e5, 5e-6),
        (
            "damage",
            steel(
                "*Plastic\n 400., 0.\n*Damage Initiation, criterion=DUCTILE\n 0.05, 0., 0.\n*Damage Evolution, type=DISPLACEMENT\n 0.02,\n",
            ),
            2e5,
            5e-6,
        ),
        ("rubber", bare("*Density\n 1.e-9,\n*Hyperelastic, neo hooke\n 0.5, 0.1\n"), 1e4, 1e-4),
        ("Mooney-Rivlin", bare("*Density\n 1.e-9,\n*Hyperelastic, mooney-rivlin\n 0.4, 0.1, 0.1\n"), 1e4, 1e-4),
        ("Ogden", bare("*Density\n 1.e-9,\n*Hyperelastic, ogden\n 1., 1.3, 0.1\n*Damping, alpha=1.e4\n"), 1e4, 1e-4),
        ("foam", steel("*Crushable Foam\n 1.1, 0.1\n*Crushable Foam Hardening\n 400., 0.\n 500., 0.1\n"), 2e5, 5e-6),
        (
            "explosive",
            bare(
                "*Density\n 1.63e-9,\n*Eos, type=JWL\n 6.93e6, 3.712e5, 3231., 0.3, 4.15, 0.95, 4.29e12\n*Detonation Point\n 0., 0.\n",
            ),
            1e4,
            2e-6,
        ),
        (
            "Us-Up with strength",
            bare(&format!(
                "{head}*Eos, type=USUP\n 5.328e6, 1.338, 2.\n*Elastic, type=SHEAR\n 2.8e4,\n*Plastic\n 300., 0.\n"
            )),
            1e5,
            3e-6,
        ),
        ("linear Us-Up", bare(&format!("{head}*Eos, type=USUP\n 5.328e6, 1.338, 2.\n")), 1e5, 3e-6),
        ("ideal gas", bare(gas), 1e4, 3e-5),
    ] {
        let quadrilaterals = bar(4, &material, speed, time, "");
        let triangles = in_six_node_triangles(&quadrilaterals, [4, 16]);
        // Six-node triangles need a shear modulus.
        let fluid = ["explosive", "linear Us-Up", "ideal gas"].contains(&name);
        let both = [("CAX4R", quadrilaterals), ("CAX6M", triangles)];
        for (elements, deck) in both.into_iter().take(if fluid { 1 } else { 2 }) {
            let outcome = assert_resumes(&format!("{name}, {elements}"), &deck, Routines::none);
            println!("{name}, {elements}: {} increments, drift {:.1e}", outcome.increments, outcome.energy.drift);
            assert_eq!(outcome.halt, None, "{name}, {elements}");
        }
    }
}

/// The increment limited by single elements in place of the global estimate; distortion control; area weighting; an
/// analytical target with friction on faces of elements that fail.
#[test]
fn element_controls_and_a_target_resume() {
    let plastic = steel("*Plastic\n 400., 0.\n 500., 0.1\n*Shear Failure\n 0.05,\n");
    let controlled = |parameters: &str| {
        let cards = format!("material=M, controls=C\n*Section Controls, name=C, {parameters}\n*Material");
        bar(4, &plastic.replacen("material=M\n*Material", &cards, 1), 2e5, 5e-6, "")
    };
    let target = "*Material, name=ROCK\n*Density\n 2.7e-9,\n*Cavity Expansion, yield=100.\n 4., 0., 1.\n\
         *Target, name=WALL, front=1., direction=-1\n ROCK, 900.\n";
    let shot = bar(
        4,
        &(plastic.clone() + target),
        8e5,
        5e-6,
        "*Dsload, target=WALL, friction=0.1\n J0, CAVITY\n I1, CAVITY\n",
    );
    for (name, deck) in [
        ("element by element", bar(4, &plastic, 2e5, 5e-6, "").replace("Explicit\n", "Explicit, element by element\n")),
        ("distortion control", controlled("distortion control=YES, length ratio=0.7")),
        ("area weighting", controlled("weighting=AREA")),
        ("target", shot.replace(" J0, 2, 2\n", "")),
    ] {
        let outcome = assert_resumes(name, &deck, Routines::none);
        assert_eq!(outcome.halt, None, "{name}");
        assert!(name != "target" || outcome.energy.cavity > 0.0 && outcome.energy.friction > 0.0);
    }
}

/// Element deletion by several criteria: deleted elements, stored rates for the next decision, eroded mass and energy,
/// and nodes without elements.
#[test]
fn element_deletion_resumes() {
    let metal = "*Plastic\n 400., 0.\n 500., 0.1\n";
    let shock = "*Density\n 2.785e-9,\n*Eos, type=USUP\n 5.328e6, 1.338, 2.\n*Elastic, type=SHEAR\n 2.8e4,\n*Plastic\n 300., 0.\n";
    let shells = || {
        let nodes: String = (0..=20).map(|i| format!(" {}, 10., {}\n", i + 1, 0.5 * f64::from(i))).collect();
        let elements: String = (1..=20).map(|i| format!(" {i}, {i}, {}\n", i + 1)).collect();
        format!(
            "*Node, nset=ALL\n{nodes}*Nset, nset=UPPER, generate\n 11, 21, 1\n*Element, type=SAX1, elset=SHELL\n{elements}*Shell Section, \
             elset=SHELL, material=M\n 0.2, 5\n*Material, name=M\n*Density\n 7.8e-9,\n*Elastic\n 200e3, 0.3\n{metal}*Erosion, plastic \
             strain=0.3\n*Initial Conditions, type=VELOCITY\n UPPER, 2, 3e5\n*Step\n*Dynamic, Explicit\n , 12e-6\n*Output, field, \
             number interval=7\n*Node Output\n U, V\n*Element Output\n ALL\n*Output, history, number interval=23\n*Energy \
             Output\n ALL\n*End Step\n"
        )
    };
    let shot = || {
        let block = |name: &str, n: [usize; 2], from: f64| part(name, n, |i, j| [i as f64, from + j as f64], "");
        block("ROD", [3, 6], 0.0)
            + &block("PLATE", [8, 4], -4.01)
            + &assembly(&["ROD", "PLATE"], "")
            + &elastic("ROD", [207e3, 0.3, 7.85e-9], "*Plastic\n 1500., 0.\n")
            + &elastic("PLATE", [69e3, 0.33, 2.71e-9], "*Plastic\n 300., 0.\n 400., 1.\n")
            + "*Erosion, plastic strain=0.5, distortion=0.2\n*Initial Conditions, type=VELOCITY\n ROD.ALL, 2, -8e5\n*Step\n*Dynamic, \
               Explicit\n , 8e-6\n*Contact\n*Contact Inclusions, all exterior\n*Contact Controls Assignment, nodal erosion=YES\n*Output, \
               field, number interval=7\n*Node Output\n U, V\n*Element Output\n STATUS, PEEQ\n*Output, history, number \
               interval=23\n*Energy Output\n ALL\n*End Step\n"
    };
    let pressed = |label: &str| {
        let law = "*Material, name=LAW\n*Density\n 1e-9,\n*Cavity Expansion, yield=50.\n 4., 0., 1.\n*Target, name=T, front=-1., direction=1\n LAW, 9.\n";
        let target = if label == "CAVITY" { law } else { "" };
        let magnitude = if label == "CAVITY" { "" } else { ", 30." };
        let flying: String = (0..=12)
            .map(|j| {
                format!(
                    "*Nset, nset=R{j}, generate\n {}, {}, 1\n*Initial Conditions, type=VELOCITY\n R{j}, 2, {}e4\n",
                    13 * j + 1,
                    13 * j + 13,
                    j * j
                )
            })
            .collect();
        grid(12, 12, false, |i, j| [i as f64, j as f64])
            + "*Surface, name=SKIN\n SOLID,\n"
            + &material(200e3, 0.3, 7.8e-9, metal)
            + "*Erosion, principal strain=0.15\n"
            + target
            + &flying
            + &format!(
                "*Step\n*Dynamic, Explicit\n , 4e-6\n*Dsload\n SKIN, {label}{magnitude}\n*Output, field, number interval=7\n*Node Output\n U, V\n*Element Output\n STATUS\n*Output, history, number interval=23\n*Energy Output\n ALL\n*End Step\n"
            )
    };
    for (name, deck) in [
        ("plastic", bar(4, &(steel(metal) + "*Erosion, plastic strain=0.05, increment=1e-10\n"), 2e5, 5e-6, "")),
        ("rates of a state", bar(4, &(bare(shock) + "*Erosion, increment=6.5e-8\n"), 2e5, 5e-6, "")),
        ("shells", shells()),
        ("a rod through a plate", shot()),
        ("a rod through a plate, nodes merge", shot().replace("erosion=YES", "erosion=MERGE")),
        ("pressure on newly exposed faces", pressed("P")),
        ("user pressure on newly exposed faces", pressed("PNU")),
        ("resistance of a target on newly exposed faces", pressed("CAVITY").replace("*Dsload", "*Dsload, target=T")),
    ] {
        let outcome = assert_resumes(name, &deck, || Routines::none().with_load(RampPressure));
        let removed = outcome.energy.removed.expect("books");
        println!("{name}: {removed:?}");
        assert!(outcome.halt.is_none() && removed.mass > 0.0, "{name}: {outcome:?}");
    }
}

/// The stresses of assumed strains and the yield stress of each element are part of the state: HOURGLASS=ENHANCED with
/// plasticity, damage, deletion, and rubber.
#[test]
fn enhanced_hourglass_control_resumes() {
    let plastic = "*Plastic\n 400., 0.\n 500., 0.1\n";
    let damage = "*Damage Initiation, criterion=DUCTILE\n 0.05, 0., 0.\n*Damage Evolution, type=DISPLACEMENT\n 0.02,\n";
    let rubber = bare("*Density\n 1.e-9,\n*Hyperelastic, neo hooke\n 0.5, 0.1\n");
    for (name, material, speed, time) in [
        ("plastic", steel(plastic), 2e5, 5e-6),
        ("damage", steel(&format!("{plastic}{damage}")), 2e5, 5e-6),
        ("rubber", rubber, 1e4, 1e-4),
    ] {
        let cards = "material=M, controls=C\n*Section Controls, name=C, hourglass=ENHANCED\n*Material";
        let material = material.replacen("material=M\n*Material", cards, 1);
        let outcome = assert_resumes(name, &bar(4, &material, speed, time, ""), Routines::none);
        assert!(outcome.halt.is_none() && outcome.energy.artificial > 0.0, "{name}: {outcome:?}");
    }
}

/// Regions at rest are skipped until the wave arrives; work is distributed over threads.
#[test]
fn large_body_resumes_on_any_number_of_threads() {
    let steel = steel("*Plastic\n 400., 0.\n 500., 0.1\n*Shear Failure\n 0.05,\n");
    let deck = bar(40, &steel, 2e5, 1e-6, "").replace(" ALL, 2,", " J1, 2,");
    let with = |threads: usize, control: RunControl<'_>| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let (outcome, keeper) = run(&deck, &Routines::none(), control);
            (ending(&outcome), keeper.states)
        })
    };
    let every = Some(CheckpointInterval::Increments(15));
    let (whole, states) = with(1, RunControl { every, ..RunControl::default() });
    assert!(states.len() > 3);
    for (i, threads) in [(0, 2), (1, 5), (3, 1)] {
        assert_eq!(
            with(threads, RunControl { state: Some(&states[i].0), ..RunControl::default() }).0,
            whole,
            "{threads} threads"
        );
    }
}

/// A model that is large enough for tiles of corner forces has the bits of one without tiles, on any number of threads and
/// after a restart. Corner forces are stored for all elements if some can be deleted by `*EROSION`.
#[test]
fn large_model_in_tiles_resumes() {
    let text = fs::read_to_string(project("input/taylor_copper.inp")).expect("the deck");
    let text = text.replace(" , 80.e-6", " , 60.e-9").replace("field, number interval=20", "field, number interval=1");
    let stored = text.replace("*Step,", "*Erosion, plastic strain=9.\n*Step,");
    let with = |text: &str, threads: usize, control: RunControl<'_>| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let settings = [("nr", "128"), ("nz", "1024")];
            let prepared = prepared(text, &settings, &Routines::none());
            let mut keeper = CheckpointRecorder::default();
            let ran = solve::run_with(&prepared.plan, prepared.state, &mut keeper, control).expect("the state fits");
            assert!(ran.0.increments > 12, "{:?}", ran.0);
            (frames(&keeper.shown, 0), rows(&keeper.shown, 0).last().cloned(), keeper.states)
        })
    };
    let whole = with(&stored, 2, RunControl::default());
    let every = Some(CheckpointInterval::Increments(6));
    let tiled = with(&text, 1, RunControl { every, ..RunControl::default() });
    assert!(tiled.1 == whole.1 && tiled.0.last() == whole.0.last(), "tiles change the results");
    let state = Some(&*tiled.2[0].0);
    for threads in [2, 5] {
        let resumed = with(&text, threads, RunControl { state, ..RunControl::default() });
        assert!(resumed.1 == whole.1 && resumed.0.last() == whole.0.last(), "{threads} threads");
    }
}

const WALL: &str = "*Node, nset=ANVIL\n 800, 0., 0.\n*Surface, type=SEGMENTS, name=WALL\n START, 0., 0.\n LINE, 100., 0.\n\
     *Rigid Body, ref node=800, analytical surface=WALL\n*Surface Interaction, name=ROUGH\n*Friction\n 0.2\n";

/// Returns two steps of a model with all links and loads.
fn linked() -> String {
    let step = |name: &str, more: &str| {
        format!(
            "*Step, name={name}\n*Dynamic, Explicit, scale factor=0.8\n , 1.5\n*Boundary\n I0, 1, 1\n 800, 2, 2\n{more}\
             *Output, field, number interval=3\n*Node Output\n U, V, A, RF\n*Element Output\n S, LE\n\
             *Output, history, number interval=17\n*Node Output, nset=REF\n U2, V2, A2\n*Node Output, nset=ANVIL\n RF2\n\
             *Node Output, nset=I1\n U, V, RF\n*Energy Output\n ALL\n*End Step\n"
        )
    };
    let links = "*Element, type=SPRINGA, elset=K\n 301, 2, 9\n*Spring, elset=K\n\n 3.\n*Element, type=DASHPOT1, elset=C\n 302, 12\n\
         *Dashpot, elset=C\n 2\n 0.4\n*Equation\n 2\n 8, 1, 1., 11, 1, -1.\n*Amplitude, name=RAMP, time=TOTAL TIME\n 0., 0., 1., 1., 4., 0.3\n\
         *Initial Conditions, type=VELOCITY\n ALL, 2, -0.02\n 900, 2, -0.02\n";
    let tied = "*Node, nset=REF\n 900, 0., 1.\n*Element, type=MASS, elset=POINT\n 900, 900\n*Mass, elset=POINT\n 1.2\n\
         *Rigid Body, ref node=900, tie nset=J1\n";
    grid(2, 5, false, |i, j| [0.5 * i as f64, 0.3 * j as f64 + 1e-4])
        + &material(20.0, 0.25, 1.0, "*Plastic\n 0.02, 0.\n 0.2, 0.2\n")
        + tied
        + WALL
        + links
        + &step(
            "One",
            "*Contact Pair, interaction=ROUGH\n J0, WALL\n*Dsload, amplitude=RAMP\n I1, P, 0.05\n*Dload\n , GRAV, 0.02, 0., -1.\n",
        )
        + &step("Two", "*Cload, amplitude=RAMP\n 6, 1, 0.01\n")
}

/// Masses, springs and dashpots without elements, and a rigid body on a spring.
#[test]
fn masses_and_springs_resume() {
    let step = |name: &str, more: &str| {
        format!(
            "*Step, name={name}\n*Dynamic, Explicit\n , 0.2\n*Boundary\n 1, 1, 2\n{more}*Output, field, number interval=3\n*Node Output\n U, V, A, RF\n\
             *Output, history, number interval=17\n*Node Output, nset=M\n U2, V2\n*Node Output, nset=REF\n U2\n*Energy Output\n ALL\n*End Step\n"
        )
    };
    let deck = "*Node\n 1, 0., 0.\n 2, 0., 0.5\n 3, 0., 1.\n 4, 1., 1.\n*Nset, nset=M\n 2\n*Nset, nset=REF\n 3\n*Element, type=MASS, elset=EM\n 1, 2\n 2, 3\n\
         *Mass, elset=EM\n 5.\n*Element, type=RAX2, elset=DISC\n 3, 3, 4\n*Rigid Body, ref node=3, elset=DISC\n*Element, type=SPRINGA, elset=K\n 4, 2, 1\n 5, 3, 2\n\
         *Spring, elset=K\n\n 20000.\n*Element, type=DASHPOT1, elset=C\n 6, 2\n*Dashpot, elset=C\n 2\n 10.\n\
         *Initial Conditions, type=VELOCITY\n M, 2, -2.\n"
        .to_owned()
        + &step("One", "")
        + &step("Two", "*Cload\n 2, 2, 10.\n");
    let outcome = assert_resumes("masses", &deck, Routines::none);
    assert_eq!(outcome.halt, None);
}

#[test]
fn links_and_loads_over_two_steps_resume() {
    let outcome = assert_resumes("links", &linked(), Routines::none);
    assert_eq!(outcome.halt, None);
    let energy = &outcome.energy;
    assert!(energy.contact != 0.0 && energy.friction > 0.0 && energy.plastic > 0.0, "{energy:?}");
}

/// Returns a rigid nose that hits two blocks, which are in contact with each other, with friction, an initial clearance
/// and softened contact; the second of two steps adds a contact pair.
fn meeting() -> String {
    let block = |name: &str, n: usize, from: f64| {
        part(name, [n, 5], |i, j| [i as f64 / n as f64, from + 0.1 * j as f64 * (1.0 + 0.02 * (i as f64 - 2.0))], "")
    };
    let nose = [[0.4, 1.4], [0.4, 1.1], [0.0, 0.98]];
    let mass = "*Element, type=MASS, elset=M\n 900, 1000\n*Mass, elset=M\n 0.2,\n";
    let step = |time: f64, cards: &str| {
        format!(
            "*Step\n*Dynamic, Explicit\n , {time}\n{cards}*Output, field, number interval=3\n*Node Output\n U, V, A\n*Element Output\n \
             S, PEEQ\n*Output, history, number interval=17\n*Node Output, nset=NOSE.REF\n U2, V2, A2\n*Energy Output\n ALL\n*End Step\n"
        )
    };
    block("LOWER", 4, -0.51)
        + &block("UPPER", 5, 0.0)
        + &rigid_line("NOSE", &nose, mass)
        + &assembly(&["LOWER", "UPPER", "NOSE"], "*Rigid Body, ref node=NOSE.REF, elset=NOSE.E\n")
        + &elastic("LOWER", [1.0, 0.3, 1.0], "*Plastic\n 0.02, 0.\n 0.05, 0.3\n")
        + &elastic("UPPER", [1.0, 0.3, 1.0], "")
        + "*Surface Interaction, name=DRY\n*Friction, exponential decay\n 0.3, 0.1, 20.\n*Surface Interaction, name=SOFT\n\
           *Friction\n 0.2,\n*Surface Behavior, pressure-overclosure=LINEAR\n 5.,\n\
           *Initial Conditions, type=VELOCITY\n NOSE.REF, 2, -0.2\n UPPER.ALL, 2, -0.05\n"
        + &step(
            1.5,
            "*Boundary\n LOWER.J0, 2, 2\n*Contact Pair, interaction=DRY, adjust=0.03\n UPPER.J0, LOWER.J1\n\
             *Contact Pair, interaction=SOFT\n NOSE.SKIN, UPPER.J1\n",
        )
        + &step(1.0, "*Contact Pair, interaction=DRY\n LOWER.I1, UPPER.I1\n")
}

#[test]
fn contact_resumes() {
    let outcome = assert_resumes("contact", &meeting(), Routines::none);
    assert_eq!(outcome.halt, None);
    let energy = &outcome.energy;
    assert!(energy.contact != 0.0 && energy.friction > 0.0 && energy.plastic > 0.0, "{energy:?}");
}

/// Checkpoints after new meshes contain them.
#[test]
fn new_meshes_resume() {
    let card = "*Remesh, elset=BAR, angle=59., frequency=5\n*Material, name=COPPER";
    let deck = fs::read_to_string(project("input/taylor_copper.inp")).expect("the deck");
    let outcome = assert_resumes("new meshes", &deck.replacen("*Material, name=COPPER", card, 1), Routines::none);
    assert!(outcome.new_meshes[0].count >= 2, "{:?}", outcome.new_meshes);
}

/// Checkpoints after new elements in a part of a body that no card names.
#[test]
fn patches_resume() {
    let deck = fs::read_to_string(project("input/taylor_copper.inp")).expect("the deck");
    let fast = deck.replacen("speed  = 227.", "speed  = 450.", 1).replacen("nr = 10\nnz = 50", "nr = 6\nnz = 30", 1);
    let outcome = assert_resumes("patches", &fast.replacen("80.e-6", "30.e-6", 1), Routines::none);
    let changes = outcome.new_meshes[0];
    assert!(changes.count >= 2 && changes.new_elements < 100 * changes.count, "{changes:?}");
}

/// New meshes of bodies in contact with friction: pressures, slip and stored energies; also with temperatures, mass scaling
/// and deleted elements.
#[test]
fn new_meshes_of_bodies_in_contact_resume() {
    let remesh = |name: &str| format!("*Remesh, elset={name}.SOLID, frequency=10, angle=1., increment=0.9999999\n");
    let bodies = |law: &str, cards: &str| {
        let text = punch_and_block(12, 8e-6, law, cards);
        text.replacen("*Surface Interaction", &(remesh("PUNCH") + &remesh("BLOCK") + "*Surface Interaction"), 1)
    };
    let friction = "*Friction\n 0.3,\n";
    let warm = bodies(friction, "")
        .replace("CAX4R", "CAX4RT")
        .replace("*Dynamic, Explicit", "*Dynamic Temperature-displacement, Explicit")
        .replace("*Elastic", "*Conductivity\n 100.,\n*Specific Heat\n 4e8,\n*Expansion\n 2e-5,\n*Elastic")
        .replace("*Friction", "*Gap Conductance\n 0.5, 0.\n 0.1, 0.05\n*Friction");
    for (name, text) in [
        ("friction", bodies(friction, "")),
        ("soft", bodies("*Surface Behavior, pressure-overclosure=LINEAR\n 1e6,\n", "")),
        ("warm", warm),
        (
            "scaled",
            bodies(
                friction,
                "*Fixed Mass Scaling, factor=2.\n*Variable Mass Scaling, type=BELOW MIN, dt=2e-8, frequency=7\n",
            ),
        ),
        ("eroded", bodies("", "").replacen("*Remesh", "*Erosion, plastic strain=0.25\n*Remesh", 1)),
    ] {
        let outcome = assert_resumes(name, &text, Routines::none);
        println!("{name}: {:?} new meshes, {} deleted", outcome.new_meshes, outcome.deleted);
        assert_eq!(outcome.halt, None);
        assert!(outcome.new_meshes.iter().map(|changes| changes.count).sum::<u64>() >= 2, "{name}");
    }
}

/// Surfaces of adaptive meshes that slide in contact: places of nodes, pressures, slip and stored energies.
#[test]
fn adaptive_meshes_in_contact_resume() {
    for law in ["*Friction\n 0.3,\n", "*Friction\n 0.1,\n*Surface Behavior, pressure-overclosure=LINEAR\n 1e6,\n"] {
        let text = punch_and_block(12, 8e-6, law, BOTH_ADAPTIVE);
        let outcome = assert_resumes("adaptive meshes in contact", &text, Routines::none);
        assert_eq!(outcome.halt, None);
    }
}

/// The same bodies with temperatures, penalty contact, and heat conduction across contact.
#[test]
fn thermal_contact_resumes() {
    let text = meeting()
        .replace("CAX4R", "CAX4RT")
        .replace("*Dynamic, Explicit", "*Dynamic Temperature-displacement, Explicit")
        .replace("*Elastic", "*Conductivity\n 0.01,\n*Specific Heat\n 1.,\n*Elastic")
        .replace("interaction=DRY, adjust=0.03", "interaction=DRY, adjust=0.03, mechanical constraint=PENALTY")
        .replace(
            "*Surface Interaction, name=SOFT",
            "*Gap Conductance\n 0.5, 0.\n 0.1, 0.05\n*Surface Interaction, name=SOFT",
        )
        .replace(
            "*Initial Conditions, type=VELOCITY",
            "*Initial Conditions, type=TEMPERATURE\n UPPER.ALL, 10.\n*Initial Conditions, type=VELOCITY",
        )
        .replace("S, PEEQ", "S, PEEQ, TEMP");
    let outcome = assert_resumes("warm contact", &text, Routines::none);
    assert_eq!(outcome.halt, None);
    let energy = &outcome.energy;
    assert!(
        energy.penalty.is_some() && energy.friction > 0.0 && energy.internal_heat.is_some_and(|h| h > 0.0),
        "{energy:?}"
    );
}

/// Places, masses, temperatures, counts and thermal strains of an adaptive mesh are part of the state, with the state of a
/// user material.
#[test]
fn adaptive_meshes_resume() {
    let cards = "*Plastic\n 400., 0.\n 500., 0.1\n*Specific Heat\n 4.6e8,\n*Inelastic Heat Fraction\n 0.9,\n";
    let mesh = "*Adaptive Mesh, elset=SOLID, frequency=3\n";
    let text = bar(4, &steel(cards), 2e5, 5e-6, mesh);
    let outcome = assert_resumes("adaptive mesh", &text, Routines::none);
    assert!(outcome.halt.is_none() && outcome.mesh_changes[0].count > 10, "{:?}", outcome.mesh_changes);
    let heated = format!("{cards}*Conductivity\n 5e4,\n*Expansion\n 1.2e-5,\n");
    let warm = bar(4, &steel(&heated), 2e5, 5e-6, &format!("{mesh}*Boundary\n J0, 11, 11, 30.\n"))
        .replace("CAX4R", "CAX4RT")
        .replace("*Dynamic, Explicit", "*Dynamic Temperature-displacement, Explicit")
        .replace("U, V, A, RF", "U, V, A, RF, NT, RFL");
    let outcome = assert_resumes("adaptive mesh with temperatures", &warm, Routines::none);
    assert!(outcome.halt.is_none() && outcome.mesh_changes[0].count > 10, "{:?}", outcome.mesh_changes);
    let user = text
        .replace(&steel(cards), &bare("*Density\n 7.83e-9,\n*User Material, constants=2\n 206e3, 0.3\n*Depvar\n 5,\n"));
    let outcome =
        assert_resumes("adaptive mesh of a user material", &user, || Routines::none().with_material(GradientRecorder));
    assert!(outcome.halt.is_none() && outcome.mesh_changes[0].count > 10, "{:?}", outcome.mesh_changes);
}

/// Material that flows through two Eulerian boundaries of a mesh whose lower end moves, in two steps: prescribed places,
/// and masses and energies that have entered and left, are part of the state.
#[test]
fn eulerian_boundaries_resume() {
    let mesh = "*Amplitude, name=RAMP\n 0., 0., 1., 1.\n*Adaptive Mesh, elset=SOLID\n*Adaptive Mesh Constraint\n J1, 2, 2\n\
                *Adaptive Mesh Constraint, type=VELOCITY, amplitude=RAMP\n J0, 1, 2, 1e9\n";
    let text = bar(4, &steel("*Plastic\n 400., 0.\n 500., 0.1\n"), 2e5, 3e-6, mesh)
        .replace(" J0, 2, 2\n", "")
        .replace("ALL, 2, -2e5", "ALL, 2, -2e5\n TOP, 2, -1e5")
        .replace("*Surface, name=J0\n", "*Surface, name=J0, region type=EULERIAN\n")
        .replace("*Surface, name=J1\n", "*Surface, name=J1, region type=EULERIAN\n")
        + "*Step\n*Dynamic, Explicit\n , 3e-6\n*End Step\n";
    let outcome = assert_resumes("Eulerian boundaries", &text, Routines::none);
    let flow = outcome.energy.flow;
    assert!(outcome.halt.is_none() && flow.mass_in > 0.0 && flow.mass_out > 0.0, "{flow:?}");
    let warm = text
        .replace("*Plastic", "*Specific Heat\n 4.6e8,\n*Conductivity\n 5e4,\n*Plastic")
        .replace("CAX4R", "CAX4RT")
        .replacen("*Step\n", "*Initial Conditions, type=TEMPERATURE\n ALL, 20.\n*Step\n", 1)
        .replace("*Dynamic, Explicit", "*Dynamic Temperature-displacement, Explicit");
    let outcome = assert_resumes("Eulerian boundaries with temperatures", &warm, Routines::none);
    assert!(outcome.halt.is_none() && outcome.energy.heat.is_some_and(|heat| heat != 0.0), "{:?}", outcome.energy);
}

/// Elasticity from the stretch of the deformation gradient, which is stored in the state variables.
struct GradientRecorder;

impl UserMaterial for GradientRecorder {
    fn stress(&mut self, call: &MaterialCall<'_>, answer: &mut MaterialAnswer<'_>) -> Result<(), LoadFailure> {
        let (n, [modulus, ratio]) = (call.count, [call.properties[0], call.properties[1]]);
        let (shear2, dilation) = (modulus / (1.0 + ratio), modulus * ratio / ((1.0 + ratio) * (1.0 - 2.0 * ratio)));
        for i in 0..n {
            let stretch = [0, 1, 2, 3].map(|k| call.stretch[1][k * n + i] - if k < 3 { 1.0 } else { 0.0 });
            let sum = stretch[0] + stretch[1] + stretch[2];
            for (k, part) in stretch.into_iter().enumerate() {
                answer.stress[k * n + i] = shear2 * part + if k < 3 { dilation * sum } else { 0.0 };
            }
            for k in 0..5 {
                answer.state[k * n + i] = call.gradient[1][k * n + i];
            }
        }
        Ok(())
    }
}

/// Massless reference nodes, one with a prescribed motion and one with a load, and a tied surface.
#[test]
fn reference_nodes_resume() {
    let pad = "*Node\n 951, 0., 12.9\n 952, 3.2, 12.9\n 953, 3.2, 14.\n 954, 0., 14.\n*Element, type=CAX4R, elset=SOLID\n 951, 951, 952, 953, 954\n\
         *Elset, elset=PAD\n 951\n*Surface, name=UNDER\n PAD, S1\n*Surface, name=OVER\n PAD, S3\n*Tie, name=T, position tolerance=0.2\n J1, UNDER\n\
         *Node, nset=REF\n 900, 0., 14.\n 901, 0., 15.\n*Coupling, constraint name=C, ref node=900, surface=OVER\n*Kinematic\n\
         *Coupling, constraint name=D, ref node=901, surface=I1\n*Distributing\n";
    let cards = "*Boundary, type=VELOCITY\n 900, 2, 2, -2.e5\n*Cload\n 901, 2, 20.\n";
    let material = pad.to_owned() + &steel("*Plastic\n 400., 0.\n 500., 0.1\n");
    let text = bar(4, &material, 2e5, 5e-6, cards).replace("nset=J0\n RF2", "nset=REF\n RF2, U2");
    let outcome = assert_resumes("reference nodes", &text, Routines::none);
    assert_eq!(outcome.halt, None);
    assert!(outcome.energy.plastic > 0.0 && outcome.energy.drift < 5e-2, "{:?}", outcome.energy);
}

/// A plate of plastic shells with heat and mass scaling.
#[test]
fn shells_resume() {
    let deck = "*Node, nset=ALL\n 1, 0., 0.\n 9, 4., 0.\n*Ngen, nset=ALL\n 1, 9\n*Element, type=SAX1, elset=E\n 1, 1, 2\n\
                *Elgen, elset=E\n 1, 8\n*Shell Section, elset=E, material=M\n 0.2\n*Material, name=M\n*Density\n 1.,\n*Elastic\n 1.e3, 0.3\n\
                *Plastic, hardening=JOHNSON COOK\n 1., 2., 0.5, 1., 900., 20.\n*Rate Dependent, type=JOHNSON COOK\n 0.02, 1.\n\
                *Specific Heat\n 0.01,\n*Inelastic Heat Fraction\n*Initial Conditions, type=TEMPERATURE\n ALL, 30.\n\
                *Boundary\n 9, ENCASTRE\n*Step\n*Dynamic, Explicit, adiabatic\n , 2.\n*Fixed Mass Scaling, factor=1.2\n\
                *Dload\n E, P, 0.3\n*Output, history, frequency=1\n*Energy Output\n ALLPD, ETOTAL\n*Output, field, number interval=4\n\
                *Node Output\n U, UR\n*Element Output\n S, LE, S_SPOS, PEEQ_SNEG, STH\n*End Step\n";
    let outcome = assert_resumes("shells", deck, Routines::none);
    assert!(outcome.halt.is_none() && outcome.energy.plastic > 0.0, "{:?}", outcome.energy);
}

/// Damage, deletion and the energies of cohesive elements are part of the state.
#[test]
fn cohesive_elements_resume() {
    let text = fs::read_to_string(project("tests/deck/words/cohesive.inp")).expect("a deck");
    let text = text
        .replace("number interval=2", "number interval=7")
        .replace("frequency=1\n*Energy Output\n ALLKE, ALLDMD", "number interval=23\n*Energy Output\n ALL")
        .replace(" 0.2,\n**material", " 0.06,\n**material")
        .replace(" TOP, 1, 1, 0.2\n", " TOP, 1, 1, 0.\n")
        .replace(" , 0.4\n", " , 1.5\n");
    let outcome = assert_resumes("cohesive elements", &text, Routines::none);
    assert!(outcome.halt.is_none() && outcome.deleted == 1, "{outcome:?}");
    let viscous = text.replace(" 0.06,\n**material", " 0.06,\n*Damage Stabilization\n 0.02,\n**material");
    let viscous = viscous.replace("type=TRACTION\n 500., 400.", "type=COUPLED TRACTION\n 500., 400., 0., 100.");
    let delayed = assert_resumes("cohesive elements with viscosity", &viscous, Routines::none);
    assert!(delayed.halt.is_none() && delayed.energy.damage > outcome.energy.damage, "{delayed:?}");
}

/// Bonds, damage and failure of cohesive surfaces are part of the state.
#[test]
fn cohesive_surfaces_resume() {
    let text = fs::read_to_string(project("tests/deck/words/cohesive.inp")).expect("a deck");
    let pair = "*Surface Interaction, name=BOND\n*Friction\n 0.2,\n*Cohesive Behavior, repeated contacts\n 500., 400.\n*Damage \
                Initiation, criterion=QUADS\n 5., 6.\n*Damage Evolution, type=ENERGY\n 0.06,\n*Contact Pair, \
                interaction=BOND, adjust=0.2\n ROOF, BED\n*Amplitude, name=V\n 0., 1., 0.2, 1., 0.21, -2., 0.5, -2., 0.51, 2., \
                1., 2.\n";
    let surfaces =
        "*Elset, elset=A\n 1\n*Elset, elset=B\n 2\n*Surface, name=BED\n A, S3\n*Surface, name=ROOF\n B, S1\n";
    let text = text
        .replace("*Element, type=COHAX4, elset=COH\n 3, 3, 4, 6, 5\n", surfaces)
        .replace("*Cohesive Section, elset=COH, material=GLUE, response=TRACTION SEPARATION\n 1.,\n", pair)
        .replace("number interval=2", "number interval=7")
        .replace(
            "frequency=1\n*Energy Output\n ALLKE, ALLDMD",
            "number interval=23\n*Energy Output\n ALL\n*Contact Output\n CFN",
        )
        .replace("type=VELOCITY\n TOP", "type=VELOCITY, amplitude=V\n TOP")
        .replace(" TOP, 1, 1, 0.2\n", " TOP, 1, 1, 0.05\n")
        .replace(" U\n*Element Output\n S, E, SDEG", " U, CPRESS, CSDMG, CSQUADSCRT\n*Element Output\n S")
        .replace(" , 0.4\n", " , 1.\n");
    let outcome = assert_resumes("cohesive surfaces", &text, Routines::none);
    assert!(outcome.halt.is_none(), "{outcome:?}");
    // The ring is bonded and torn off twice: the area is 3 π, and that of the deformed ring.
    let twice = 2.0 * 0.06 * 3.0 * std::f64::consts::PI;
    assert!((outcome.energy.damage.expect("damage") / twice - 1.0).abs() < 1e-2, "{:?}", outcome.energy);
    let viscous =
        text.replace("type=ENERGY\n 0.06,\n*Contact", "type=ENERGY\n 0.06,\n*Damage Stabilization\n 0.02,\n*Contact");
    let delayed = assert_resumes("cohesive surfaces with viscosity", &viscous, Routines::none);
    // The damage is delayed, so that less of the fracture energy is spent.
    assert!(delayed.halt.is_none() && delayed.energy.damage < outcome.energy.damage, "{delayed:?}");
}

#[test]
fn scaled_masses_resume() {
    let cards =
        "*Fixed Mass Scaling, factor=2., elset=EJ0\n*Variable Mass Scaling, type=BELOW MIN, dt=3.e-8, frequency=9\n";
    let outcome =
        assert_resumes("mass scaling", &bar(4, &steel("*Plastic\n 400., 0.\n"), 2e5, 5e-6, cards), Routines::none);
    assert!(outcome.steps[0].added_mass.expect("mass") > 0.0);
}

struct RampPressure;

impl UserLoad for RampPressure {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        for (p, v) in pressure.iter_mut().zip(points.velocity_z) {
            *p = 0.01 + 0.3 * points.now.total_time - 0.1 * v;
        }
        Ok(())
    }
}

struct SwayMotion;

impl UserMotion for SwayMotion {
    fn motion(&mut self, call: &MotionCall<'_>) -> Result<f64, LoadFailure> {
        Ok(0.02 * call.now.total_time - 0.1 * call.state[0] + 0.01 * call.increments[0])
    }
}

/// User amplitude that stores its peak in its state variables.
struct PeakAmplitude;

impl UserAmplitude for PeakAmplitude {
    fn amplitude(&mut self, call: &mut AmplitudeCall<'_>) -> Result<AmplitudeAnswer, LoadFailure> {
        let value = (7.0 * call.now.total_time).min(1.5) + 0.1 * call.old;
        call.variables[0] = call.variables[0].max(value);
        Ok(AmplitudeAnswer { value: value - 0.2 * call.variables[0], ..AmplitudeAnswer::default() })
    }
}

/// Records the events with their increments, and `R` before a checkpoint.
#[derive(Clone, Default)]
struct EventLog(std::sync::Arc<std::sync::Mutex<Vec<String>>>);

impl UserEvents for EventLog {
    fn moment(&mut self, moment: AnalysisMoment, now: &Instant, _increment: f64) -> Result<RunAction, LoadFailure> {
        self.0.lock().expect("a diary").push(format!("{} {}", moment as i32, now.increment));
        Ok(RunAction::Continue)
    }
    fn restart_follows(&mut self) {
        self.0.lock().expect("a diary").push("R".into());
    }
}

fn with_routines() -> String {
    let cards = "*Amplitude, name=PEAK, definition=USER, properties=1, variables=1\n 6.,\n";
    linked()
        .replacen("*Step", &format!("{cards}*Step"), 1)
        .replace("*Dsload, amplitude=RAMP\n I1, P, 0.05\n", "*Dsload, amplitude=PEAK\n I1, PNU, 0.05\n")
        .replace("*Cload, amplitude=RAMP", "*Boundary, user, type=VELOCITY\n 1, 1, 1\n*Cload, amplitude=PEAK")
}

#[test]
fn user_subroutines_without_internal_state_resume() {
    let routines = || Routines::none().with_load(RampPressure).with_motion(SwayMotion).with_amplitude(PeakAmplitude);
    let outcome = assert_resumes("routines", &with_routines(), routines);
    assert_eq!(outcome.halt, None);
}

/// User events report which checkpoints are written, and that the analysis starts from a checkpoint.
#[test]
fn user_events_report_checkpoints() {
    let diary = EventLog::default();
    let routines = |diary: &EventLog| Routines::none().with_events(diary.clone());
    let every = Some(CheckpointInterval::Increments(10));
    let (_, keeper) = run(&linked(), &routines(&diary), RunControl { every, ..RunControl::default() });
    let message_text = std::mem::take(&mut *diary.0.lock().expect("a diary"));
    let at = message_text.iter().position(|t| t == "R").expect("a state");
    assert_eq!(message_text[at..at + 4], ["R", "4 10", "2 10", "3 10"]);
    run(&linked(), &routines(&diary), RunControl { state: Some(&keeper.states[0].0), ..RunControl::default() });
    let again = std::mem::take(&mut *diary.0.lock().expect("a diary"));
    assert_eq!(again[..3], ["0 10", "2 10", "3 10"]);
    assert_eq!(again[1..], message_text.iter().filter(|t| *t != "R").skip(at + 1).cloned().collect::<Vec<_>>());
}

/// Every deck in `input`, with its Fortran files.
#[test]
fn every_example_resumes() {
    for (deck, user) in [
        ("ogive", None),
        ("ogive_user", Some("vdload_cavity.f")),
        ("ogive_user", Some("vdload_table.f90")),
        ("blast_disk", Some("vdload_blast.f")),
        ("taylor_copper", None),
        ("taylor_vumat", Some("vumat_hardening.f90")),
        ("upsetting", None),
    ] {
        let text = fs::read_to_string(project(&format!("input/{deck}.inp"))).expect("a deck");
        let text = text.replace("nr = 20\nnz = 30", "nr = 8\nnz = 12");
        if user.is_some() && !common::fortran("restart of examples with routines in Fortran") {
            continue;
        }
        let files: Vec<_> = user.iter().map(|f| project(&format!("input/{f}"))).collect();
        let compiled = (!files.is_empty()).then(|| compile(&files, false).expect("a library"));
        let routines = || compiled.as_ref().map_or(Routines::none(), |c| c.open().expect("routines"));
        let outcome = assert_resumes(deck, &text, routines);
        assert_eq!(outcome.halt, None, "{deck}");
    }
}

/// The moduli that the user subroutine gave at the start are not requested again; the frequency bound is restored.
#[test]
fn user_material_with_the_global_estimate_resumes() {
    if !common::fortran("restart of a user material under the global estimate") {
        return;
    }
    let text =
        fs::read_to_string(project("input/taylor_vumat.inp")).expect("a deck").replace(", element by element", "");
    let compiled = compile(&[project("input/vumat_hardening.f90")], false).expect("a library");
    let outcome = assert_resumes("taylor_vumat", &text, || compiled.open().expect("routines"));
    assert!(outcome.halt.is_none() && outcome.steps[0].global_estimates > Some(1), "{outcome:?}");
}

/// Yield stress with strain hardening, which falls with temperature and the first field variable; counts its calls in a
/// state variable.
struct SofteningMaterial;

impl UserHardening for SofteningMaterial {
    fn yield_stress(&mut self, call: &HardeningCall<'_>, answer: &mut HardeningAnswer<'_>) -> Result<(), LoadFailure> {
        for i in 0..call.count {
            let factor = call.field[1][i] * (1.0 - 1e-3 * call.temperature[1][i]);
            answer.stress[i] = factor * (400.0 + 1000.0 * call.strain[i]);
            answer.slopes[i] = factor * 1000.0;
            answer.state[call.count + i] = call.state[call.count + i] + 1.0;
        }
        Ok(())
    }
}

/// Stores the plastic strain, reduces the field variable, and deletes elements.
impl UserFields for SofteningMaterial {
    fn fields(&mut self, call: &FieldCall<'_>, answer: &mut FieldAnswer<'_>) -> Result<(), LoadFailure> {
        let n = call.count;
        call.values.give("PEEQ", &mut |_, i, strain| {
            answer.state[2 * n + i] = if strain < 0.2 { 1.0 } else { 0.0 };
            answer.state[i] = strain;
            answer.field[i] = 1.0 - 0.5 * strain;
        });
        Ok(())
    }
}

#[test]
fn user_hardening_and_fields_resume() {
    let cards = "*Plastic, hardening=USER\n*User Defined Field\n*Depvar, delete=3\n 3,\n*Specific Heat\n 3.83e8,\n*Inelastic \
                 Heat Fraction\n 0.9,\n";
    let text =
        |n| bar(n, &steel(cards), 2e5, 5e-6, "").replace("*Dynamic, Explicit\n", "*Dynamic, Explicit, adiabatic\n");
    for (elements, deck) in [("CAX4R", text(3)), ("CAX6M", in_six_node_triangles(&text(4), [4, 16]))] {
        let outcome = assert_resumes(elements, &deck, || {
            Routines::none().with_hardening(SofteningMaterial).with_fields(SofteningMaterial)
        });
        assert!(outcome.halt.is_none() && outcome.energy.plastic > 0.0 && outcome.deleted > 0, "{outcome:?}");
    }
}

/// Neo-Hooke from the deformation gradient, and kinematic plasticity with tensors in state variables.
#[test]
fn user_material_of_six_node_triangles_resumes() {
    if !common::fortran("restart of a user material of six-node triangles") {
        return;
    }
    let compiled = compile(&[project("tests/user/corotational.f90")], false).expect("a library");
    for (law, density, speed, time) in
        [("2, 20., 400., 0., 0., 0.", 1e-9, 4e4, 1e-4), ("10, 8e4, 1.7e5, 400., 2000., 0.", 7.83e-9, 2e5, 5e-6)]
    {
        let cards = format!("*Density\n {density:e},\n*User Material, constants=6\n {law}\n*Depvar\n 5,\n");
        let text = in_six_node_triangles(&bar(4, &bare(&cards), speed, time, ""), [4, 16]);
        let outcome = assert_resumes(law, &text, || compiled.open().expect("routines"));
        assert_eq!(outcome.halt, None, "{law}");
    }
}

/// If a deformable body fails, the last frame is that of the last valid increment, as in a run that writes every
/// increment: once near the start, and once after more increments than there are between internal checkpoints.
#[test]
fn last_valid_increment_is_written_after_a_failure() {
    for control in ["", ", direct user control\n 2.e-7"] {
        let deck = |interval: &str| {
            let dynamic = if control.is_empty() { "\n , 1.".into() } else { format!("{control}, 1.") };
            grid(3, 3, false, |i, j| [1.0 + i as f64, j as f64])
                + &material(1000.0, 0.3, 1.0, "*Plastic\n 1., 0.\n")
                + &format!(
                    "*Initial Conditions, type=VELOCITY\n 6, 1, 4000.\n*Step\n*Dynamic, Explicit{dynamic}\n*Output, field, {interval}\n\
                     *Node Output\n U, V, A\n*Element Output\n S, PEEQ, LE\n*Output, history, {interval}\n*Energy Output\n ALLKE, ALLPD\n*End Step\n"
                )
        };
        let (outcome, memory) = common::run(&deck("number interval=1"), &[], &Routines::none());
        let (every, all) = common::run(&deck("frequency=1"), &[], &Routines::none());
        let halt = outcome.halt.as_ref().expect("a halt");
        assert_eq!(every.halt, outcome.halt);
        // The first and the last frame, which are identical if the first increment fails.
        let increment = memory.frames.last().expect("a frame").increment;
        let count = if increment == 0 { 1 } else { 2 };
        assert_eq!((memory.frames.len(), memory.rows.len()), (count, count));
        assert!(frames(&memory, count - 1) == frames(&all, all.frames.len() - 1));
        assert!(rows(&memory, count - 1) == rows(&all, all.rows.len() - 1));
        // The element collapses in a valid increment, or inverts in the increment after the last valid one.
        let failed = if halt.code() == "R209" { increment } else { increment + 1 };
        assert!(halt.message().contains(&format!("increment {failed},")), "{halt:?} {increment}");
        assert!(control.is_empty() || halt.code() != "R209" && increment > 5000, "{halt:?} {increment}");
        assert_eq!(outcome.digest, every.digest);
    }
}

/// The state of a large model is stored in a file during the run; the folder does not contain it.
#[test]
fn last_valid_increment_of_a_large_model_is_written_after_a_failure() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = |interval: &str| {
        let deck = grid(3, 24_000, false, |i, j| [1.0 + i as f64, j as f64])
            + &material(1000.0, 0.3, 1.0, "*Plastic\n 1., 0.\n")
            + &format!(
                "*Initial Conditions, type=VELOCITY\n 6, 1, 4000.\n*Step\n*Dynamic, Explicit, direct user control\n 5.e-5, 1.\n\
                 *Output, field, {interval}\n*Node Output\n U, V\n*End Step\n"
            );
        let prepared = prepared(&deck, &[], &Routines::none());
        let job =
            JobFiles { folder: folder.path().join(interval.split(' ').next().expect("a word")), name: "test".into() };
        let summary = job::run_to_files(&prepared, &job, &mut |_| {}).expect("a run");
        let mut files: Vec<PathBuf> =
            fs::read_dir(&job.folder).expect("a folder").map(|e| e.expect("a file").path()).collect();
        files.sort();
        files.retain(|path| path.extension().is_some_and(|ending| ending == "vtu"));
        let last = fs::read(files.last().expect("a frame")).expect("a file");
        (summary.halt.expect("a halt"), summary.digest, files.len(), last)
    };
    let (last, every) = (run("number interval=1"), run("frequency=100"));
    println!("{}: {} frames", last.0, every.2);
    assert!((&last.0, &last.1, &last.3) == (&every.0, &every.1, &every.3), "{} and {}", last.0, every.0);
    assert!(last.2 == 2 && every.2 > 2);
}

/// The internal checkpoint is from a time when a part of the body was at rest; the whole body moves when it fails.
#[test]
fn return_to_the_last_valid_increment_includes_sleeping_elements() {
    let deck = grid(4, 256, false, |i, j| [1.0 + i as f64, j as f64])
        + &material(1000.0, 0.3, 1.0, "*Plastic\n 100., 0.\n")
        + "*Step\n*Dynamic, Explicit, direct user control\n 0.01, 400.\n*Boundary, type=VELOCITY\n J1, 2, 2, -2.\n*Boundary\n J0, 2, 2\n\
           *Output, field, number interval=1\n*Node Output\n U\n*End Step\n";
    let (outcome, memory) = common::run(&deck, &[], &Routines::none());
    let halt = outcome.halt.expect("a halt");
    let increment = memory.frames.last().expect("a frame").increment;
    // The wave needs about 700 increments from end to end.
    assert!(halt.code() == "R206" && increment > 1000 && memory.frames.len() == 2, "{halt:?} {increment}");
    assert!(halt.message().contains(&format!("increment {},", increment + 1)), "{} {increment}", halt.message());
}

/// Runs a deck into files and interrupts it before its first increment.
fn interrupted(deck: &str, folder: &Path, settings: &[(&str, &str)], user: &str) -> JobFiles {
    let prepared = prepared(deck, settings, &Routines::none());
    let (signal, job) = (AtomicUsize::new(15), JobFiles { folder: folder.into(), name: "test".into() });
    let options = JobOptions { interrupt: Some(&signal), user: user.into(), ..JobOptions::default() };
    let summary = job::run_with(&prepared, &job, options, &mut |_| {}).expect("a run");
    assert!(
        summary.interrupted
            && summary.halt.is_some_and(|halt| halt.to_string().starts_with("R207: interrupted by SIGTERM"))
    );
    job
}

/// Quantities include the rows from before the interruption: the maximum of the velocity is at the start.
#[test]
fn quantities_of_a_resumed_run_match_the_whole_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let prepared = prepared(&common::ogive(), &[], &Routines::none());
    let job = |name: &str| JobFiles { folder: folder.path().join(name), name: "test".into() };
    let whole = job::run_to_files(&prepared, &job("whole"), &mut |_| {}).expect("a run");
    let (signal, cut) = (AtomicUsize::new(0), job("cut"));
    let mut stop = |progress: &Progress<'_>| {
        if progress.fraction > 0.4 {
            signal.store(15, Ordering::Relaxed);
        }
    };
    let every = Some(CheckpointInterval::Increments(50));
    let options = JobOptions { interrupt: Some(&signal), every, ..JobOptions::default() };
    assert!(job::run_with(&prepared, &cut, options, &mut stop).expect("a run").interrupted);
    let from = job::find_checkpoint(&prepared, &cut, "", RestartRequirement::Whole).expect("accepted").0;
    assert!(from.is_some());
    let options = JobOptions { from, ..JobOptions::default() };
    let gone_on = job::run_with(&prepared, &cut, options, &mut |_| {}).expect("a run");
    assert!(gone_on.timing.resumed_at.is_some_and(|increment| increment > 0));
    for text in ["min(V2@REF)", "time_min(V2@REF)", "at(U2@REF, 5e-5)", "mean(V2@REF, 1e-5, 9e-4)"] {
        let quantity = Quantity::parse(text).expect("a quantity");
        let [a, b] = [&whole, &gone_on].map(|run| quantity.number(FinishedRun { history: &run.history, end: None }));
        assert_eq!(a.expect("a number").to_bits(), b.expect("a number").to_bits(), "{text}");
    }
}

#[test]
fn checkpoint_of_another_model_is_rejected() {
    let folder = tempfile::tempdir().expect("a folder");
    let deck = common::ogive();
    let job = interrupted(&deck, folder.path(), &[("V", "600")], "a");
    let code = |text: &str, settings: &[(&str, &str)], user: &str| {
        let found =
            job::find_checkpoint(&prepared(text, settings, &Routines::none()), &job, user, RestartRequirement::Whole);
        found.map_or_else(|finding| finding.code, |(checkpoint, _)| if checkpoint.is_some() { "taken" } else { "none" })
    };
    assert_eq!(code(&deck, &[("V", "600")], "a"), "taken");
    assert_eq!(code(&deck, &[("V", "601")], "a"), "K004");
    assert_eq!(code(&deck, &[("V", "600")], "b"), "K005");
    assert_eq!(code(&deck.replace(", 1.e-3", ", 2.e-3"), &[("V", "600")], "a"), "K003");
    // Its only frame is deleted and user subroutines have internal state: both are reported.
    fs::remove_file(job.path("_0000.vtu")).expect("removed");
    let routines = Routines::none().with_load(RampPressure);
    let (_, notes) =
        job::find_checkpoint(&prepared(&deck, &[("V", "600")], &routines), &job, "a", RestartRequirement::Whole)
            .expect("taken");
    assert_eq!(notes.iter().map(|n| n.code).collect::<Vec<_>>(), ["K103", "K102"]);
    let path = job.path(".checkpoint");
    let bytes = fs::read(&path).expect("bytes");
    fs::write(&path, &bytes[..bytes.len() - 1]).expect("cut");
    assert_eq!(code(&deck, &[("V", "600")], "a"), "K001");
    fs::remove_file(&path).expect("removed");
    assert_eq!(code(&deck, &[("V", "600")], "a"), "none");
}

/// A state of another model is rejected by its shape, even if its identity is the same.
#[test]
fn state_of_another_shape_is_rejected() {
    let every = Some(CheckpointInterval::Increments(20));
    let (_, keeper) = run(&linked(), &Routines::none(), RunControl { every, ..RunControl::default() });
    for text in
        [common::ogive(), bar(4, &steel(""), 1e4, 5e-6, ""), linked().replace("*Plastic\n 0.02, 0.\n 0.2, 0.2\n", "")]
    {
        let prepared = prepared(&text, &[], &Routines::none());
        let control = RunControl { state: Some(&keeper.states[0].0), ..RunControl::default() };
        let refused =
            solve::run_with(&prepared.plan, prepared.state.clone(), &mut CheckpointRecorder::default(), control);
        assert!(refused.is_err(), "{:?}", refused.map(|(o, _)| o.digest));
    }
}

/// `*RESTART, WRITE` writes at its intervals and at the end of every step but the last.
#[test]
fn restart_card_writes_checkpoints() {
    let deck = |card: &str| linked().replacen("*Boundary", &format!("{card}\n*Boundary"), 1);
    let count = |card: &str| run(&deck(card), &Routines::none(), RunControl::default()).1.states.len();
    // The last interval of the second step is the end of the run.
    assert_eq!(count("*Restart, write, number interval=4"), 7);
    assert_eq!(count("*Restart, write"), 1);
    assert_eq!(count("*Restart, write, frequency=0"), 0);
    let prepared = prepared(&deck("*Restart, write, number interval=4"), &[], &Routines::none());
    assert!(prepared.plan.ledger.effects.iter().any(|row| row.effect == "checkpoint"));
}
