//! `--precision single`: what is calculated in single precision, what is reported or rejected, and restart.
//!
//! Goal: the ledger reports the precision of the job, and such a run is as reproducible as others. Source: the run in
//! double precision, the uninterrupted run. Tolerance: none.

use std::sync::atomic::AtomicUsize;

use revolve::deck;
use revolve::job::{self, JobOptions, PreparedJob, RestartRequirement};
use revolve::model::Precision;
use revolve::output::JobFiles;
use revolve::solve::{self, CheckpointInterval, Instant, RunControl, Sink, SinkError};
use revolve::study::settings;
use revolve::user::Routines;

use crate::common::solid::{grid, material};
use crate::common::{prepared_in_single, revolve, run_in_both};

/// Returns a bar that hits a wall, with enough elements for several threads.
fn bar(cards: &str, material: &str) -> String {
    grid(25, 60, false, |i, j| [0.128 * i as f64, 0.2 * j as f64])
        + material
        + &format!(
            "{cards}*Initial Conditions, type=VELOCITY\n ALL, 2, -2.e5\n*Step\n*Dynamic, Explicit\n , 1.e-6\n*Boundary\n \
             I0, 1, 1\n J0, 2, 2\n*Output, field, number interval=2\n*Node Output\n U, V\n*Element Output\n S, PEEQ, LE, \
             ELEN, STATUS\n*Output, history, number interval=10\n*Energy Output\n ALL\n*End Step\n"
        )
}

fn steel(cards: &str) -> String {
    material(206e3, 0.3, 7.83e-9, cards)
}

fn rows(prepared: &PreparedJob) -> Vec<(&str, usize, &str)> {
    let rows = prepared.plan.ledger.effects.iter().filter(|row| row.effect.ends_with("precision"));
    rows.map(|row| (row.effect.as_str(), row.count, row.detail.as_str())).collect()
}

fn single(text: &str) -> PreparedJob {
    prepared_in_single(text, &[], &Routines::none())
}

#[test]
fn ledger_reports_the_precision_of_elements() {
    let text = bar("", &steel("*Plastic\n 400., 0.\n 500., 0.1\n"));
    let prepared = single(&text);
    let [("single precision", 1500, detail)] = rows(&prepared)[..] else { panic!("{:?}", rows(&prepared)) };
    assert!(detail.contains("plastic strains"), "{detail}");
    let double = job::prepare_text("test.inp", &text, &[], &Routines::none());
    assert_eq!(rows(&double), []);
    // Half of the elements have assumed-strain hourglass control, which exists in double precision only.
    let halves = text.replace(
        "*Solid Section, elset=SOLID, material=M\n",
        "*Elset, elset=BELOW, generate\n 1, 750, 1\n*Elset, elset=ABOVE, generate\n 751, 1500, 1\n\
         *Section Controls, name=C, hourglass=ENHANCED\n*Solid Section, elset=BELOW, material=M\n\
         *Solid Section, elset=ABOVE, material=M, controls=C\n",
    );
    let prepared = single(&halves);
    assert_eq!(
        rows(&prepared).iter().map(|row| (row.0, row.1)).collect::<Vec<_>>(),
        [("single precision", 750), ("double precision", 750)]
    );
    assert!(rows(&prepared)[1].2.contains("ENHANCED") && prepared.diagnostics.iter().all(|d| d.code != "P120"));
    // Corner forces are then summed in double precision for all elements.
    let [(double, _), (mixed, _)] = run_in_both(&halves, &[], &Routines::none());
    assert_eq!((&double.halt, &mixed.halt), (&None, &None));
    let [a, b] = [double, mixed].map(|outcome| outcome.energy.plastic);
    assert!(a != b && (a / b - 1.0).abs() < 1e-5, "{a:e} {b:e}");
}

#[test]
fn features_without_single_precision_are_reported() {
    let without = [
        (
            "equation of state",
            "*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n 7.83e-9,\n*Eos, type=USUP\n 4.6e6, 1.5, 2.\n*Elastic, type=SHEAR\n 79.e3,\n",
        ),
        (
            "rubber",
            "*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n 1.e-9,\n*Hyperelastic, neo hooke\n 0.5, 0.1\n",
        ),
        (
            "crushable foam",
            "*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n 3.2e-10,\n*Elastic\n 150., 0.\n*Crushable Foam\n 1.1, 0.1\n*Crushable Foam Hardening\n 6., 0.\n 20., 0.8\n",
        ),
    ];
    for (why, material) in without {
        let prepared = single(&bar("", material));
        let [("double precision", 1500, detail)] = rows(&prepared)[..] else { panic!("{why}: {:?}", rows(&prepared)) };
        assert!(detail.contains(why), "{why}: {detail}");
        assert!(prepared.diagnostics.iter().any(|d| d.code == "P120"), "{why}");
    }
    // A rigid body alone has no elements, so that the precision has no effect.
    let output = revolve(&["run", "input/ogive.inp", "--precision", "single", "--out", "target/precision"]);
    let message_text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        output.status.success() && message_text.contains("P120") && message_text.contains("double precision"),
        "{message_text}"
    );
    let output = revolve(&["run", "input/ogive.inp", "--precision", "half"]);
    let message_text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2) && message_text.contains("double or single"), "{message_text}");
}

/// Returns the digest of a run on a number of threads.
fn digest(prepared: &PreparedJob, threads: usize) -> String {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let (outcome, _) = pool.install(|| job::run_in_memory(prepared));
    assert!(outcome.halt.is_none() && outcome.increments > 10, "{:?}", outcome.halt);
    outcome.digest
}

const LAWS: [&str; 4] = [
    "",
    "*Plastic\n 400., 0.\n 500., 0.1\n*Shear Failure\n 0.02,\n",
    "*Plastic, hardening=KINEMATIC\n 400., 0.\n 500., 0.1\n",
    "*Plastic, hardening=JOHNSON COOK\n 90., 292., 0.31, 1.09, 1058., 25.\n*Rate Dependent, type=JOHNSON COOK\n 0.025, 1.\n",
];

#[test]
fn thread_count_does_not_change_bits() {
    for law in LAWS {
        let prepared = single(&bar("", &steel(law)));
        let one = digest(&prepared, 1);
        assert!([2, 5].iter().all(|threads| digest(&prepared, *threads) == one), "{law}");
    }
}

/// Sink that stores checkpoints.
#[derive(Default)]
struct CheckpointRecorder(Vec<Vec<u8>>);

impl Sink for CheckpointRecorder {
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

#[test]
fn resumed_run_has_the_same_bits() {
    for law in LAWS {
        let prepared = single(&bar("", &steel(law)));
        let run = |control: RunControl<'_>| {
            let mut keeper = CheckpointRecorder::default();
            let state = prepared.state.clone();
            let (outcome, _) = solve::run_with(&prepared.plan, state, &mut keeper, control).expect("it fits");
            (outcome, keeper.0)
        };
        let (whole, states) =
            run(RunControl { every: Some(CheckpointInterval::Increments(7)), ..RunControl::default() });
        assert!(states.len() > 1, "{law}: {}", states.len());
        for state in &states {
            assert_eq!(run(RunControl { state: Some(state), ..RunControl::default() }).0.digest, whole.digest, "{law}");
        }
        // A state in double precision does not fit.
        let double = job::prepare_text("test.inp", &bar("", &steel(law)), &[], &Routines::none());
        let control = RunControl { state: Some(&states[0]), ..RunControl::default() };
        assert!(
            solve::run_with(&double.plan, double.state, &mut CheckpointRecorder::default(), control).is_err(),
            "{law}"
        );
    }
}

/// A checkpoint can be resumed in its own precision only.
#[test]
fn checkpoint_fits_its_own_precision_only() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = bar("", &steel(""));
    let prepare = |precision| {
        let read = deck::read_text("bar.inp", &text, &[]);
        job::prepare_edited(read, &mut |model| model.settings.precision = precision, &Routines::none())
    };
    let (single, double) = (prepare(Precision::Single), prepare(Precision::Double));
    let job = JobFiles { folder: folder.path().join("bar"), name: "bar".into() };
    let signal = AtomicUsize::new(15);
    let options = JobOptions { interrupt: Some(&signal), ..JobOptions::default() };
    let summary = job::run_with(&single, &job, options, &mut |_| {}).expect("a folder");
    assert!(summary.interrupted, "{:?}", summary.reason);
    let Err(refused) = job::find_checkpoint(&double, &job, "", RestartRequirement::Whole) else {
        panic!("another precision")
    };
    assert!(refused.code == "K010" && refused.message.contains("single"), "{refused:?}");
    let (from, _) = job::find_checkpoint(&single, &job, "", RestartRequirement::Whole).expect("it fits");
    let options = JobOptions { from, ..JobOptions::default() };
    let summary = job::run_with(&single, &job, options, &mut |_| {}).expect("a folder");
    assert!(summary.timing.resumed_at.is_some());
    assert_eq!(summary.digest, digest(&single, 1));
}

#[test]
fn precision_is_a_study_parameter() {
    let of = |text: &str| settings::axes(&[text.to_owned()], &[]);
    assert!(!of("precision=double,single").expect("choices")[0].is_refinement());
    assert!(of("precision=double,half").is_err_and(|e| e.to_string().contains("double or single")));
    let out = tempfile::tempdir().expect("a folder");
    let quantity = ["--quantity", "1000*final(COOR2@TIP)", "--exact", "21.42", "--repeat", "1"];
    let requested =
        ["study", "input/taylor_copper.inp", "--refine", "precision=double,single", "--set", "nr=4", "--set", "nz=20"];
    let folder = ["--out", out.path().to_str().expect("a name")];
    let output = revolve(&[&requested[..], &quantity[..], &folder[..]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let record = std::fs::read_to_string(out.path().join("taylor_copper_study.json")).expect("a record");
    let record: serde_json::Value = serde_json::from_str(&record).expect("JSON");
    let value = |row: usize| record["runs"][row]["value"].as_f64().expect("a number");
    assert!(value(0) != value(1) && (value(1) / value(0) - 1.0).abs() < 1e-5, "{} {}", value(0), value(1));
}
