//! The ledger: a list of the effects of an analysis with the cards that request them, their memory and their share of
//! the run time.

use serde::Serialize;

use crate::output::columns::wrapped;

/// An effect of the simulation, with the cards that request it, its memory and its share of the run time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LedgerRow {
    /// Name of the effect.
    pub effect: String,
    /// Number of facets, nodes, bodies, … on which it acts.
    pub count: usize,
    /// Unit of the count, for example `nodes`.
    pub unit: &'static str,
    /// `file:line` of the cards that request it.
    pub asked_by: Vec<String>,
    /// Details: law, scheme, values.
    pub detail: String,
    /// Names and sizes of its arrays, bytes.
    pub arrays: Vec<(String, usize)>,
    /// Address space reserved for entries that are added during the run, bytes. It uses memory only when it is written.
    #[serde(skip_serializing_if = "is_zero")]
    pub reserved: usize,
    /// Share of the run time, 0 to 1; `None` before a run or if it was not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share: Option<f64>,
}

/// A card of the deck that has no effect.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct UnusedCard {
    /// Keyword or load label.
    pub what: String,
    /// `file:line`.
    pub asked_by: String,
    /// Reason why the card has no effect.
    pub why: String,
}

/// The list of effects of an analysis, and of cards without effect.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Ledger {
    /// Effects that the analysis includes.
    pub effects: Vec<LedgerRow>,
    /// Cards without effect.
    pub unused: Vec<UnusedCard>,
}

impl Ledger {
    /// Adds a row and returns its index, by which the effect refers to it.
    pub fn add(&mut self, effect: &str, count: usize, unit: &'static str, asked_by: String, detail: String) -> usize {
        self.effects.push(LedgerRow {
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

    /// Sets the share of the run time of each effect, from its measured time and the total time in seconds.
    pub fn set_time_shares(&mut self, seconds: &[f64], total: f64) {
        for (row, spent) in self.effects.iter_mut().zip(seconds) {
            if *spent > 0.0 && total > 0.0 {
                row.share = Some((spent / total).min(1.0));
            }
        }
    }

    /// Renders the ledger as text of 80 columns, with file names without folders. `bytes` adds a column of memory
    /// sizes.
    pub fn render(&self, bytes: bool) -> String {
        let mut header = vec!["effect", "count", "card"];
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

/// Width of the text, columns.
const WIDTH: usize = 80;

impl LedgerRow {
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

/// Returns `file:line` without folders.
fn last_name(place: &str) -> &str {
    place.rsplit('/').next().unwrap_or(place)
}
