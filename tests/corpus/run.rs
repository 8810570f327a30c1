//! A deck in a temporary folder, its run by the program, and comparisons with estimates.

use std::fs;
use std::path::Path;
use std::process::Command;

use tempfile::TempDir;

/// A deck with its additional files.
pub struct Deck {
    folder: TempDir,
    arguments: Vec<String>,
}

/// Exit status, printed text and histories of a run.
pub struct Finished {
    pub status: i32,
    pub printed: String,
    histories: Vec<(String, Vec<f64>)>,
}

impl Deck {
    /// Writes the deck to a temporary folder.
    pub fn new(text: &str) -> Deck {
        let deck = Deck { folder: TempDir::new().expect("a folder"), arguments: Vec::new() };
        deck.with_file("deck.inp", text)
    }

    /// Writes a further file into the folder of the deck.
    pub fn with_file(self, name: &str, text: &str) -> Deck {
        fs::write(self.folder.path().join(name), text).expect("a file");
        self
    }

    /// Adds a Fortran file of user subroutines.
    pub fn with_subroutine(mut self, name: &str, text: &str) -> Deck {
        self.arguments.extend(["--user".to_owned(), name.to_owned()]);
        self.with_file(name, text)
    }

    /// Runs the deck and reads its histories. `REVOLVE_CORPUS=DIR` keeps a copy of the deck, named after the test.
    pub fn run(&self) -> Finished {
        if let Some(folder) = std::env::var_os("REVOLVE_CORPUS") {
            let name = std::thread::current().name().unwrap_or("deck").rsplit("::").next().map(|n| format!("{n}.inp"));
            let copy = Path::new(&folder).join(name.unwrap_or_default());
            fs::copy(self.folder.path().join("deck.inp"), copy).expect("a copy");
        }
        let output = Command::new(env!("CARGO_BIN_EXE_revolve"))
            .args(["run", "deck.inp", "--out", "out", "--threads", "1"])
            .args(&self.arguments)
            .current_dir(self.folder.path())
            .output()
            .expect("the program runs");
        let [out, err] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
        let printed = format!("{out}{err}");
        println!("{printed}");
        let histories = read_histories(&self.folder.path().join("out/deck_history.csv"));
        Finished { status: output.status.code().unwrap_or(-1), printed, histories }
    }

    /// Runs the deck and asserts that it completes with exactly these warnings and balanced energy.
    pub fn completes(&self, warnings: &[&str]) -> Finished {
        let finished = self.run();
        assert_eq!(finished.status, 0, "exit status");
        assert_eq!(finished.codes("warning"), warnings, "warnings");
        finished.assert_balanced();
        finished
    }

    /// Runs the deck and asserts that it ends with exactly these errors.
    pub fn fails(&self, errors: &[&str]) -> Finished {
        let finished = self.run();
        assert_eq!(finished.status, 2, "exit status");
        assert_eq!(finished.codes("error"), errors, "errors");
        finished
    }
}

impl Finished {
    /// Returns the codes of the messages of a level in the order in which they were printed; empty for a message
    /// without code.
    pub fn codes(&self, level: &str) -> Vec<&str> {
        let rest = self
            .printed
            .lines()
            .filter_map(|line| line.strip_prefix(level))
            .filter(|rest| rest.starts_with(['[', ':']));
        // Diagnostics of the deck have the code in brackets, warnings of a run begin with it.
        rest.map(|rest| rest[1..].trim_start().split([']', ':']).next().unwrap_or_default()).collect()
    }

    /// Returns a column of the histories.
    pub fn column(&self, name: &str) -> &[f64] {
        let found = self.histories.iter().find(|(column, _)| column.eq_ignore_ascii_case(name));
        let names = || self.histories.iter().map(|(column, _)| column.as_str()).collect::<Vec<_>>();
        &found.unwrap_or_else(|| panic!("no column {name} among {:?}", names())).1
    }

    /// Returns the names of the columns that begin with a text.
    pub fn columns_with(&self, head: &str) -> Vec<&str> {
        self.histories.iter().map(|(name, _)| name.as_str()).filter(|name| name.starts_with(head)).collect()
    }

    /// Returns the last value of a column.
    pub fn last(&self, name: &str) -> f64 {
        *self.column(name).last().expect("a row")
    }

    /// Returns the smallest value of a column.
    pub fn smallest(&self, name: &str) -> f64 {
        self.column(name).iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Returns the largest value of a column.
    pub fn largest(&self, name: &str) -> f64 {
        self.column(name).iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }

    /// Returns the value of a column at a time, interpolated between rows.
    pub fn at(&self, name: &str, time: f64) -> f64 {
        let (times, values) = (self.column("time"), self.column(name));
        let next = times.partition_point(|&t| t < time).clamp(1, times.len() - 1);
        let share = (time - times[next - 1]) / (times[next] - times[next - 1]).max(f64::MIN_POSITIVE);
        values[next - 1] + share.clamp(0.0, 1.0) * (values[next] - values[next - 1])
    }

    /// Returns the mean over time of a column between two times.
    pub fn mean(&self, name: &str, from: f64, to: f64) -> f64 {
        let samples = 400;
        let time = |i: usize| from + (to - from) * (i as f64 + 0.5) / samples as f64;
        (0..samples).map(|i| self.at(name, time(i))).sum::<f64>() / samples as f64
    }

    /// Asserts that the energy balance varies by less than 1 % of the largest energy.
    pub fn assert_balanced(&self) {
        let largest = ["ALLKE", "ALLIE", "ALLWK"].map(|name| self.largest(name).abs()).into_iter().fold(0.0, f64::max);
        let drift = self.largest("ETOTAL") - self.smallest("ETOTAL");
        assert!(drift <= 0.01 * largest, "energy balance varies by {drift:.3e}, largest energy {largest:.3e}");
    }
}

/// Asserts that a result is within a relative tolerance of its estimate.
#[track_caller]
pub fn assert_near(what: &str, result: f64, estimate: f64, tolerance: f64) {
    let deviation = result / estimate - 1.0;
    println!("estimate: {what} {result:.5e}, estimate {estimate:.5e}, deviation {:.2} %", 100.0 * deviation);
    assert!(deviation.abs() <= tolerance, "{what}: {result:.5e}, estimate {estimate:.5e} within {tolerance}");
}

/// Reads the columns of a history file; no columns without a file.
fn read_histories(path: &Path) -> Vec<(String, Vec<f64>)> {
    let text = fs::read_to_string(path).unwrap_or_default();
    let mut lines = text.lines();
    let names: Vec<String> = lines.next().unwrap_or_default().split(',').map(str::to_owned).collect();
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|value| value.parse().unwrap_or(f64::NAN)).collect()).collect();
    let column = |i: usize| rows.iter().map(|row| row.get(i).copied().unwrap_or(f64::NAN)).collect();
    names.into_iter().enumerate().map(|(i, name)| (name, column(i))).collect()
}
