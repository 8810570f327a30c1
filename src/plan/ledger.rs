//! The ledger: which effects a deck brought to life, what asked for each, what it holds and what share of the time it took.
//! Never here: the decision which effects exist.

use serde::Serialize;

use crate::output::columns::wrapped;

/// One row.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The effect.
    pub effect: String,
    /// How many facets, nodes, bodies, … it acts on.
    pub count: usize,
    /// What is counted.
    pub unit: &'static str,
    /// `file:line` of the cards that asked for it.
    pub asked_by: Vec<String>,
    /// Details a reader wants: law, scheme, values.
    pub detail: String,
    /// Names and bytes of its arrays.
    pub arrays: Vec<(String, usize)>,
    /// Bytes of address space for entries that are added during the run; they take memory once they are written.
    #[serde(skip_serializing_if = "is_zero")]
    pub reserved: usize,
    /// Share of the run's time, 0 to 1; absent before a run and where it was not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share: Option<f64>,
}

/// A card that was read and brings nothing to life.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Unused {
    /// Keyword or load label.
    pub what: String,
    /// `file:line`.
    pub asked_by: String,
    /// Why.
    pub why: String,
}

/// All rows, in the order in which an increment meets them.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Ledger {
    /// Effects that exist.
    pub effects: Vec<Row>,
    /// Cards that change nothing here.
    pub unused: Vec<Unused>,
}

impl Ledger {
    /// Adds a row and returns its index, which serves as the effect's cause.
    pub fn add(&mut self, effect: &str, count: usize, unit: &'static str, asked_by: String, detail: String) -> usize {
        self.effects.push(Row {
            effect: effect.into(),
            count,
            unit,
            asked_by: vec![asked_by],
            detail,
            arrays: Vec::new(),
            reserved: 0,
            share: None,
        });
        self.effects.len() - 1
    }

    /// Sets each effect's share of the time.
    pub fn share(&mut self, seconds: &[f64], total: f64) {
        for (row, spent) in self.effects.iter_mut().zip(seconds) {
            if *spent > 0.0 && total > 0.0 {
                row.share = Some((spent / total).min(1.0));
            }
        }
    }

    /// The ledger as text of 80 columns; files by their last name, as paths are in the summary. `bytes` adds those of each effect.
    pub fn render(&self, bytes: bool) -> String {
        let mut header = vec!["effect", "count", "asked by"];
        if bytes {
            header.push("bytes");
        }
        header.push("detail");
        let rows: Vec<_> = self.effects.iter().map(|row| row.cells(bytes)).collect();
        let mut text = wrapped(&header, &rows, WIDTH);
        for unused in &self.unused {
            text += &format!("not used: {} ({}): {}\n", unused.what, last_name(&unused.asked_by), unused.why);
        }
        text
    }
}

fn is_zero(bytes: &usize) -> bool {
    *bytes == 0
}

/// Columns of a terminal that nobody has widened.
const WIDTH: usize = 80;

impl Row {
    fn cells(&self, bytes: bool) -> Vec<String> {
        let places: Vec<&str> = self.asked_by.iter().map(|place| last_name(place)).collect();
        let mut cells = vec![self.effect.clone(), format!("{} {}", self.count, self.unit), places.join(", ")];
        if bytes {
            cells.push(self.arrays.iter().map(|a| a.1).sum::<usize>().to_string());
        }
        let mut detail = self.detail.clone();
        if bytes && self.reserved > 0 {
            detail += &format!(", {} bytes reserved", self.reserved);
        }
        cells.push(detail);
        cells
    }
}

/// `file:line` without folders.
fn last_name(place: &str) -> &str {
    place.rsplit('/').next().unwrap_or(place)
}
