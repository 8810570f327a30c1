//! Helpers of several tests: the reference deck `ogive.inp`, runs in memory, decks of bodies.
#![allow(dead_code)] // Each binary uses a part.

pub mod bodies;
pub mod faulty_decks;
pub mod mesh;
pub mod random;
pub mod routines;
pub mod scenes;
pub mod solid;
pub mod spheres;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use revolve::deck;
use revolve::job::{self, ParameterOverrides, PreparedJob};
use revolve::model::{self, Model};
use revolve::output::{JobFiles, OutputFrame};
use revolve::solve::{self, Instant, Outcome, Sink, SinkError};
use revolve::user::Routines;

/// Runs the program in the project's folder.
pub fn revolve(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_revolve"))
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("the program runs")
}

/// Returns the path of a file of the project.
pub fn project(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// Returns the deck of the copper bar with another material law, and with a single row of output.
pub fn bar_with_law(law: &str) -> String {
    let text = std::fs::read_to_string(project("input/taylor_copper.inp")).expect("the deck");
    let (begin, end) = (text.find("*Elastic").expect("a law"), text.find("*Initial").expect("a later card"));
    let mut text = format!("{}{law}{}", &text[..begin], &text[end..]);
    if law.contains("*Specific Heat") {
        text = text.replace("*Dynamic, Explicit\n", "*Dynamic, Explicit, adiabatic\n");
        text = text.replacen("*Step", "*Initial Conditions, type=TEMPERATURE\n BAR, 20.\n*Step", 1);
    }
    with_one_row(&text)
}

/// Returns a deck of one step whose output, the end of its text, is a single row: output times then limit no increment.
pub fn with_one_row(deck: &str) -> String {
    let text = deck.split("*Output").next().expect("text").to_owned();
    text + "*Output, history, number interval=1\n*Energy Output\n ETOTAL\n*End Step\n"
}

/// Returns whether a Fortran compiler is installed; without one the test prints that it was left out. CI requires one.
pub fn fortran(what: &str) -> bool {
    let compiler = std::env::var("FC").unwrap_or_else(|_| "gfortran".into());
    let found = Command::new(compiler).arg("--version").output().is_ok_and(|o| o.status.success());
    assert!(found || std::env::var_os("CI").is_none(), "in CI gfortran must be installed");
    if !found {
        println!("left out: {what} (no gfortran)");
    }
    found
}

/// Returns the first two components of a nodal field by solver node; the field is in mesh order.
pub fn at_nodes(prepared: &PreparedJob, values: &[f64]) -> Vec<[f64; 2]> {
    let places = &prepared.plan.places.nodes;
    let components = values.len() / places.len();
    let mut list = vec![[f64::NAN; 2]; places.len()];
    for (point, &node) in places.values().enumerate() {
        list[node] = [values[components * point], values[components * point + 1]];
    }
    list
}

/// Returns `--set` settings as owned pairs.
pub fn pairs(settings: &[(&str, &str)]) -> Vec<(String, String)> {
    settings.iter().map(|(n, v)| ((*n).to_owned(), (*v).to_owned())).collect()
}

/// Output sink that stores rows and frames in memory.
#[derive(Default)]
pub struct RecordedOutput {
    pub rows: Vec<(f64, Vec<f64>)>,
    pub frames: Vec<OutputFrame>,
    /// Names of the columns of the rows; empty if the output was not created for a job.
    pub columns: Vec<String>,
}

impl RecordedOutput {
    /// Creates an empty output with the names of the columns of a job.
    pub fn of(prepared: &PreparedJob) -> RecordedOutput {
        RecordedOutput { columns: prepared.plan.column_names(), ..RecordedOutput::default() }
    }
}

impl Sink for RecordedOutput {
    fn wants_frames(&self) -> bool {
        true
    }
    fn frame(&mut self, frame: &OutputFrame) -> Result<(), SinkError> {
        self.frames.push(frame.clone());
        Ok(())
    }
    fn row(&mut self, now: &Instant, values: &[f64]) -> Result<(), SinkError> {
        self.rows.push((now.total_time, values.to_vec()));
        Ok(())
    }
}

/// Prepares a deck and asserts that it has no errors.
pub fn prepared(text: &str, settings: &[(&str, &str)], routines: &Routines) -> PreparedJob {
    let overrides: &ParameterOverrides = &pairs(settings);
    let prepared = job::prepare_text("test.inp", text, overrides, routines);
    assert!(!prepared.diagnostics.has_errors(), "{}", prepared.diagnostics.render(&prepared.deck.sources));
    prepared
}

/// Runs a deck text in memory.
pub fn run(text: &str, settings: &[(&str, &str)], routines: &Routines) -> (Outcome, RecordedOutput) {
    let prepared = prepared(text, settings, routines);
    let mut memory = RecordedOutput::of(&prepared);
    let (outcome, _) = solve::run(&prepared.plan, prepared.state.clone(), &mut memory);
    (outcome, memory)
}

/// Returns the model of a deck with settings, and asserts that the deck has no errors.
pub fn model_of(text: &str, settings: &[(&str, &str)]) -> Model {
    let (deck, found) = deck::read_text("deck.inp", text, &pairs(settings));
    assert!(!found.has_errors(), "{}", found.render(&deck.sources));
    let (model, found) = model::build(&deck);
    assert!(!found.has_errors(), "{}", found.render(&deck.sources));
    model
}

/// Returns the text of `input/ogive.inp`.
pub fn ogive() -> String {
    std::fs::read_to_string(project("input/ogive.inp")).expect("the seed deck")
}

/// Runs `input/ogive.inp` into files.
pub fn run_ogive(folder: &Path, settings: &[(&str, &str)]) {
    let prepared = job::prepare(&project("input/ogive.inp"), &pairs(settings), &Routines::none());
    assert!(!prepared.diagnostics.has_errors());
    let job = JobFiles { folder: folder.to_path_buf(), name: "ogive".into() };
    let summary = job::run_to_files(&prepared, &job, &mut |_| {}).expect("files");
    assert_eq!(summary.status, "completed");
}
