//! Evaluations: tables of quantities over samples of parameters.
//!
//! Source: single runs. Each sample has the bits of a run that reads and plans the deck again, for any parameter, any
//! number of threads and any distribution of samples over calls, if it is integrated in increments (shots by stages are in
//! `staged_shots.rs`).

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::AtomicUsize;

use revolve::job;
use revolve::study::StudyError;
use revolve::study::evaluate::{DeckSource, SampleEvaluator, SampleTable, UserRoutines};
use revolve::study::quantity::{FinishedRun, Quantity, history};
use revolve::user::Routines;

use crate::common::{self, project};

/// All loads of rigid bodies, over two steps, with a target of two layers.
const LOADS: &str = "\
*Parameter
m1 = 0.5
m2 = 2.*m1
v = 30.
p = 1.e4
push = -20.
g = 9.81
front = -0.002
thin = 0.003
y = 5.e6
b = 0.5
rho = 1500.
mu = 0.1
lengths = 2.
*Node
 1, 0.,  0.
 2, 0.1, 0.02
 3, 0.1, 0.1
 9, 0.,  0.1
*Element, type=RAX2, elset=SIDE
 1, 1, 2
 2, 2, 3
*Element, type=MASS, elset=POINT
 9, 9
*Element, type=MASS, elset=MORE
 8, 2
*Mass, elset=POINT
 <m1>
*Mass, elset=MORE
 <m2>
*Rigid Body, ref node=9, elset=SIDE, density=100.
 0.001
*Surface, name=NOSE
 SIDE, SNEG
*Material, name=SOFT
*Density
 <rho>,
*Cavity Expansion, yield=<y>
 1., <b>, 1.e0
*Material, name=HARD
*Density
 2<rho>,
*Cavity Expansion, yield=2.e7
 3., 0., 1.
*Target, name=BLOCK, front=<front>, direction=-1
 SOFT, <thin>
 HARD, 1.
*Initial Conditions, type=VELOCITY
 9, 2, -<v>
*Step
*Dynamic, Explicit
 , 5.e-4
*Dsload, target=BLOCK, friction=<mu>
 NOSE, CAVITY
*Dsload
 NOSE, P, <p>
*Cload
 9, 2, <push>
*Dload
 , GRAV, <g>, 0., -1.
*Output, history, number interval=20
*Node Output, nset=ALL
 U2, V2
*Energy Output
 ALLKE, ETOTAL
*End Step
*Step
*Dynamic, Explicit
 , <lengths>e-4
*Cload, op=NEW
 9, 2, 5.
*End Step
*Nset, nset=ALL
 9
";

/// A deformable disc with contact, over two steps. Samples of all parameters but the modulus share one model.
const DISC: &str = "\
*Parameter
v = 20.
rho = 2700.
modulus = 70.e9
p = 1.e6
more = 2.e6
*Node
 1, 0., 0.
 3, 0.01, 0.
 7, 0., 0.01
 9, 0.01, 0.01
 20, 0., -1.e-5
*Ngen, nset=LOW
 1, 3, 1
*Ngen, nset=HIGH
 7, 9, 1
*Nfill
 LOW, HIGH, 2, 3
*Element, type=CAX4R, elset=DISC
 1, 1, 2, 5, 4
*Elgen, elset=DISC
 1, 2, 1, 1, 2, 3, 2
*Material, name=METAL
*Density
 <rho>,
*Elastic
 <modulus>, 0.33
*Plastic
 1.e8, 0.
*Solid Section, elset=DISC, material=METAL
*Nset, nset=ALL, generate
 1, 9
*Surface, name=BOTTOM
 DISC, S1
*Surface, name=TOP
 DISC, S3
*Surface, type=SEGMENTS, name=WALL
 START, 0., -1.e-5
 LINE, 0.02, -1.e-5
*Rigid Body, ref node=20, analytical surface=WALL
*Surface Interaction, name=SMOOTH
*Boundary
 20, 1, 6
*Initial Conditions, type=VELOCITY
 ALL, 2, -<v>
*Step
*Dynamic, Explicit
 , 4.e-6
*Contact Pair, interaction=SMOOTH
 BOTTOM, WALL
*Dsload
 TOP, P, <p>
*Output, history, number interval=4
*Node Output, nset=HIGH
 U2
*Energy Output
 ALLKE, ALLPD
*End Step
*Step
*Dynamic, Explicit
 , 2.e-6
*Dsload, op=NEW
 TOP, P, <more>
*End Step
";

/// Returns the quantities of a single run that starts from the text of the deck, or why there are none.
fn alone(source: &DeckSource, parameter: &str, value: f64, quantities: &[Quantity]) -> Result<Vec<u64>, String> {
    let overrides = [(parameter.to_owned(), format!("{value:?}"))];
    let prepared = job::prepare_read(source.read(&overrides), &Routines::none());
    if prepared.diagnostics.has_errors() {
        return Err(prepared.diagnostics.render(&prepared.deck.sources));
    }
    let mut history = history(quantities, &prepared.plan);
    let (outcome, state) = job::run_into(&prepared, &mut history);
    if let Some(halt) = outcome.halt {
        return Err(StudyError::Halted(halt).to_string());
    }
    let run = FinishedRun { history: &history, end: Some((outcome.steps.iter().map(|s| s.time).sum(), &state)) };
    quantities.iter().map(|q| q.number(run).map(f64::to_bits).map_err(|e| e.to_string())).collect()
}

/// Returns the result of each sample in a table.
fn table(evaluator: &SampleEvaluator, samples: &[f64], width: usize, threads: usize) -> Vec<Result<Vec<u64>, String>> {
    let mut values = vec![0.0; samples.len() * width];
    let requested = SampleTable { values: samples, count: samples.len() };
    let failures = evaluator.run(requested, &mut values, threads, &AtomicUsize::new(0), &mut |_| {}).expect("threads");
    let reasons: BTreeMap<usize, String> = failures.into_iter().map(|f| (f.row, f.reason.to_string())).collect();
    let row = |(i, row): (usize, &[f64])| match reasons.get(&i) {
        None => Ok(row.iter().map(|x| x.to_bits()).collect()),
        Some(why) => {
            assert!(row.iter().all(|x| x.is_nan()), "a sample that failed has no numbers");
            Err(why.clone())
        }
    };
    values.chunks(width).enumerate().map(row).collect()
}

fn agree(source: &DeckSource, texts: &[&str]) {
    let quantities: Vec<Quantity> = texts.iter().map(|t| Quantity::parse(t).expect("a quantity")).collect();
    let (deck, _) = source.read(&[]);
    for (name, value) in &deck.parameters {
        let samples = [*value, 1.01 * value, 0.0, -value, 1e300, 0.7 * value, f64::NAN];
        let expected: Vec<_> = samples.iter().map(|x| alone(source, name, *x, &quantities)).collect();
        assert!(expected[0].is_ok(), "{name}: {:?}", expected[0]);
        let evaluator = SampleEvaluator::new(
            source.clone(),
            Vec::new(),
            vec![name.clone()],
            quantities.clone(),
            UserRoutines::Absent,
        );
        let evaluator = evaluator.expect("an evaluator").in_increments();
        for threads in [1, 3] {
            assert_eq!(table(&evaluator, &samples, texts.len(), threads), expected, "{name}, {threads} threads");
        }
        let split: Vec<_> = samples.iter().rev().flat_map(|x| table(&evaluator, &[*x], texts.len(), 1)).collect();
        assert!(split.iter().rev().eq(&expected), "{name}: one sample a call, the last first");
    }
}

#[test]
fn table_matches_single_runs_bitwise() {
    let ogive = DeckSource::File(project("input/ogive.inp"));
    agree(&ogive, &["-1000*final(U2@REF)"]);
    agree(&ogive, &["final(U2@REF)", "max(ALLCAV) + mean(V2@REF, 0, 1e-4)"]);
    // For some values of the angle the body has six degrees of freedom, so that each sample is planned like a single
    // run.
    let oblique = std::fs::read_to_string(project("input/oblique.inp")).expect("a deck");
    let short = oblique.replace(" , 4.e-4", " , 1.e-5").replace("stations  = 64", "stations = 8");
    let short = short.replace("n     = 20", "n = 4").replace("m     = 10", "m = 2");
    agree(&DeckSource::Text("oblique.inp".into(), short), &["final(U2@REF)", "final(ALLKE)"]);
    let loads = DeckSource::Text("loads.inp".into(), LOADS.into());
    agree(&loads, &["final(U2@ALL)", "final(ETOTAL)"]);
    agree(&loads, &["min(V2@ALL)"]);
    let disc = DeckSource::Text("disc.inp".into(), DISC.into());
    agree(&disc, &["final(U2@9)", "final(ALLKE) + final(ALLPD)"]);
}

/// Source: a counting allocator. From the second sample on, each sample allocates as often as the one before and leaves
/// nothing, so a table of any length needs the memory of one sample. A rigid body reuses its plan; the plan of a
/// deformable body is compiled for each sample from the model of the first one.
#[test]
fn samples_leave_no_memory() {
    let bar = std::fs::read_to_string(project("input/taylor_copper.inp")).expect("a deck");
    let bar = bar.replace("nr = 10", "nr = 4").replace("nz = 50", "nz = 20");
    let bar = bar.replacen("*Material,", "*Remesh, automatic=NO\n*Material,", 1);
    let bar = DeckSource::Text("bar.inp".into(), bar);
    let ogive = DeckSource::File(project("input/ogive.inp"));
    for (source, name, value, quantity) in
        [(ogive, "V", 600.0, "final(U2@REF)"), (bar, "speed", 200.0, "final(U1@CORNER)")]
    {
        let quantities = vec![Quantity::parse(quantity).expect("a quantity")];
        let made = SampleEvaluator::new(source, Vec::new(), vec![name.into()], quantities, UserRoutines::Absent);
        let evaluator = made.expect("an evaluator");
        let counts = [0; 4].map(|_| {
            let counted = allocation_counter::measure(|| drop(table(&evaluator, &[value], 1, 1)));
            println!("{name}: {} allocations, {} bytes at most", counted.count_total, counted.bytes_max);
            (counted.count_total, counted.bytes_current)
        });
        assert!(counts[1..].iter().all(|&(count, bytes)| count == counts[1].0 && bytes == 0), "{name}: {counts:?}");
    }
}

#[test]
fn invalid_evaluations_are_rejected_before_any_run() {
    let source = DeckSource::File(project("input/ogive.inp"));
    let make = |name: &str, quantity: &str| {
        let quantities = vec![Quantity::parse(quantity).expect("a quantity")];
        SampleEvaluator::new(source.clone(), Vec::new(), vec![name.into()], quantities, UserRoutines::Absent)
            .map(|_| ())
    };
    let message_text = |made: Result<(), StudyError>| made.expect_err("refused").to_string();
    assert!(message_text(make("v", "final(U2@REF)")).contains("did you mean V?"));
    assert!(message_text(make("V", "final(U2@RFE)")).contains("did you mean U2@REF?"));
    let broken = DeckSource::File(Path::new("no such deck.inp").into());
    let made = SampleEvaluator::new(broken, Vec::new(), Vec::new(), Vec::new(), UserRoutines::Absent).map(|_| ());
    assert!(matches!(made, Err(StudyError::Refused { code: "D001", .. })), "{made:?}");
}

#[test]
fn an_interrupt_ends_a_table_early() {
    let quantities = vec![Quantity::parse("final(U2@REF)").expect("a quantity")];
    let source = DeckSource::File(project("input/ogive.inp"));
    let evaluator =
        SampleEvaluator::new(source, Vec::new(), vec!["V".into()], quantities, UserRoutines::Absent).expect("made");
    let samples = vec![500.0; 1000];
    for threads in [1, 2] {
        let mut values = vec![f64::NAN; samples.len()];
        let interrupt = AtomicUsize::new(2);
        let requested = SampleTable { values: &samples, count: samples.len() };
        let failures = evaluator.run(requested, &mut values, threads, &interrupt, &mut |_| {}).expect("threads");
        assert!(values.iter().all(|x| x.is_nan()), "no run is completed");
        assert!(failures.len() <= threads, "{} were begun", failures.len());
        assert!(failures.iter().all(|f| f.reason.to_string().contains("R207")), "{failures:?}");
    }
}

/// Reactions and contact forces are means since the previous row, so that a run of which only the last row is needed still
/// has all rows. Source: the same run with its history.
#[test]
fn final_reactions_match_those_of_a_run() {
    let deck = project("input/indentation.inp");
    let settings = common::pairs(&[("n", "8")]);
    let prepared = job::prepare(&deck, &settings, &Routines::none());
    let (_, history) = job::run_in_memory(&prepared);
    let quantity = Quantity::parse("final(RF2@SPHERE)").expect("a quantity");
    let source = DeckSource::File(deck);
    let evaluator = SampleEvaluator::new(source, settings, vec!["speed".into()], vec![quantity], UserRoutines::Absent);
    let (table, failures) = evaluator.expect("an evaluator").table(&[50.0], 1).expect("threads");
    assert_eq!((table, failures), (vec![history.0["RF2@SPHERE"].last], Vec::new()));
}
