//! Decks on which random scenes (`tests/soak.sh`) once failed.
//!
//! Goal: the energy balance closes, no energy has a wrong sign, and each expected code is reported, no other. Source:
//! conservation of energy, signs of stored and dissipated energies. Tolerance: 1 % of the largest energy.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::common::project;

/// Largest part of the largest energy by which the balance may drift, and an energy may have the wrong sign.
const BOUND: f64 = 0.01;
/// Codes about the mesh and the increments, which do not concern the sign of energies.
const ABOUT_ACCURACY: [&str; 3] = ["R302", "R308", "R309"];

/// Energies that are never negative; those of a sum are added.
const NEVER_NEGATIVE: [&[&str]; 10] = [
    &["ALLKE"],
    &["ALLSE"],
    &["ALLPD"],
    &["ALLDMD"],
    &["ALLVD"],
    &["ALLFD"],
    &["ALLAE"],
    &["ALLDC"],
    &["ALLCAV"],
    &["ALLCW", "ALLPW"],
];
/// Dissipated energies, which never decrease.
const NEVER_DECREASING: [&[&str]; 4] = [&["ALLPD", "ALLDMD"], &["ALLVD"], &["ALLFD"], &["ALLCAV"]];

/// Columns of a history file.
struct History {
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl History {
    fn read(path: &Path) -> History {
        let text = fs::read_to_string(path).expect("a history");
        let mut lines = text.lines();
        let names = lines.next().expect("a header").split(',').map(str::to_owned).collect();
        let number = |cell: &str| cell.parse().expect("a number");
        History { names, rows: lines.map(|line| line.split(',').map(number).collect()).collect() }
    }

    /// Returns the sum of columns in each row; columns that do not exist are zero.
    fn sum(&self, columns: &[&str]) -> Vec<f64> {
        let places: Vec<usize> = columns.iter().filter_map(|c| self.names.iter().position(|n| n == c)).collect();
        self.rows.iter().map(|row| places.iter().map(|&p| row[p]).sum()).collect()
    }

    fn largest_energy(&self) -> f64 {
        let all = ["ALLKE", "ALLIE", "ALLWK"].map(|name| self.sum(&[name]));
        all.iter().flatten().fold(0.0, |most, energy| most.max(energy.abs()))
    }

    /// Returns the energies with a wrong sign. A material with stored energy releases strain energy, and pays for its
    /// hourglass control.
    fn wrong_signs(&self, stores_energy: bool) -> Vec<String> {
        let bound = BOUND * self.largest_energy();
        let mut found = Vec::new();
        for columns in NEVER_NEGATIVE.iter().filter(|c| !(stores_energy && matches!(c[0], "ALLSE" | "ALLAE"))) {
            let lowest = self.sum(columns).into_iter().fold(0.0, f64::min);
            if lowest < -bound {
                found.push(format!("{} is {lowest:e}", columns.join(" + ")));
            }
        }
        for columns in NEVER_DECREASING {
            let mut highest = 0.0_f64;
            for energy in self.sum(columns) {
                highest = highest.max(energy);
                if energy < highest - bound {
                    found.push(format!("{} decreases from {highest:e} to {energy:e}", columns.join(" + ")));
                    break;
                }
            }
        }
        found
    }
}

/// Returns the codes of the warnings on standard error.
fn codes(messages: &str) -> BTreeSet<String> {
    let of_deck = messages.split("warning[").skip(1).filter_map(|rest| rest.split(']').next());
    let of_run = messages.split("warning: ").skip(1).filter_map(|rest| rest.split(':').next());
    of_deck.chain(of_run).filter(|code| !ABOUT_ACCURACY.contains(code)).map(str::to_owned).collect()
}

/// The first line of a deck describes it; the second one lists the expected codes: `** expected: R303`. An energy with a
/// wrong sign needs an expected code.
#[test]
fn decks_of_former_failures_have_energies_of_the_right_sign() {
    let folder = project("tests/soak/regressions");
    let mut decks: Vec<_> = fs::read_dir(&folder).expect("decks").map(|e| e.expect("an entry").path()).collect();
    decks.sort();
    let mut failures = Vec::new();
    for deck in &decks {
        let name = deck.file_stem().expect("a name").to_str().expect("a name");
        let text = fs::read_to_string(deck).expect("a deck");
        let expected = text.lines().nth(1).and_then(|line| line.strip_prefix("** expected:")).expect("expected codes");
        let expected: BTreeSet<String> = expected.split_whitespace().map(str::to_owned).collect();
        let scratch = tempfile::tempdir().expect("a folder");
        let mut command = Command::new(env!("CARGO_BIN_EXE_revolve"));
        let output = command.arg("run").arg(deck).arg("--out").arg(scratch.path()).output().expect("the program runs");
        let messages = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{name}: {messages}");
        let summary = fs::read_to_string(scratch.path().join(format!("{name}.json"))).expect("a summary");
        let summary: Value = serde_json::from_str(&summary).expect("JSON");
        let drift = summary["energy"]["drift"].as_f64().expect("a number");
        let history = History::read(&scratch.path().join(format!("{name}_history.csv")));
        let wrong = history.wrong_signs(text.to_ascii_lowercase().contains("*eos"));
        let found = codes(&messages);
        println!("{name}: drift {drift:.1e}, codes {found:?}, wrong signs {wrong:?}");
        if found != expected || drift > BOUND || !wrong.is_empty() && expected.is_empty() {
            failures.push(format!("{name}: drift {drift:e}, codes {found:?} in place of {expected:?}, {wrong:?}"));
        }
    }
    assert!(decks.len() > 4 && failures.is_empty(), "{failures:#?}");
}
