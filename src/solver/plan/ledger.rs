//! The ledger: a list of the effects of an analysis with the cards that request them, their memory and their share of
//! the run time.

use indexmap::IndexSet;
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
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize)]
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
    pub unused: IndexSet<UnusedCard>,
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

    /// Brings the rows into the order of the rows of a later mesh, and adds the rows that only the later mesh has. Rows that it
    /// does not have are the last ones.
    pub fn follow(&mut self, later: Vec<LedgerRow>) {
        let mut first: Vec<Option<LedgerRow>> = self.effects.drain(..).map(Some).collect();
        for row in later {
            let is_same = |planned: &LedgerRow| planned.is_of(&row.effect, &row.asked_by);
            let planned = first.iter_mut().find_map(|planned| planned.take_if(|planned| is_same(planned)));
            self.effects.push(planned.unwrap_or(row));
        }
        self.effects.extend(first.into_iter().flatten());
    }

    /// Sets the share of the run time of each effect, from its measured time and the total time in seconds.
    pub fn set_time_shares(&mut self, seconds: &[f64], total: f64) {
        for (row, spent) in self.effects.iter_mut().zip(seconds) {
            if *spent > 0.0 && total > 0.0 {
                row.share = Some((spent / total).min(1.0));
            }
        }
    }

    /// Adds a result of the run to the details of a row.
    pub fn add_result(&mut self, row: usize, text: &str) {
        if let Some(row) = self.effects.get_mut(row) {
            row.detail += ", ";
            row.detail += text;
        }
    }

    /// Renders the effects as one line, and the cards without effect.
    pub fn render_names(&self) -> String {
        let names: IndexSet<&str> = self.effects.iter().map(|row| row.effect.as_str()).collect();
        let names: Vec<&str> = names.into_iter().collect();
        format!("effects: {}\n{}", names.join(", "), self.unused_text(false))
    }

    /// Renders the ledger as text of 80 columns, with file names without folders. `bytes` adds a column of memory
    /// sizes, and the reason for each card without effect.
    pub fn render(&self, bytes: bool) -> String {
        let mut header = vec!["effect", "count", "card"];
        if bytes {
            header.push("bytes");
        }
        header.push("detail");
        let rows: Vec<_> = self.effects.iter().map(|row| row.cells(bytes)).collect();
        let mut text = wrapped(&header, &rows, WIDTH);
        text += &self.unused_text(bytes);
        text
    }

    /// Returns the cards without effect: each with its reason, or only their names if there are many and `all` is false.
    fn unused_text(&self, all: bool) -> String {
        if all || self.unused.len() <= LISTED {
            let line =
                |card: &UnusedCard| format!("not used: {} ({}): {}\n", card.what, last_name(&card.asked_by), card.why);
            return self.unused.iter().map(line).collect();
        }
        let mut names: Vec<&str> = self.unused.iter().map(|card| card.what.split(',').next().unwrap_or("")).collect();
        names.dedup();
        format!(
            "not used: {} ({} settings; `revolve check --bytes` gives the reasons)\n",
            names.join(", "),
            self.unused.len()
        )
    }
}

fn is_zero(bytes: &usize) -> bool {
    *bytes == 0
}

/// Number of cards without effect up to which each has a line.
const LISTED: usize = 3;
/// Width of the text, columns.
const WIDTH: usize = 80;

impl LedgerRow {
    /// Returns whether this is the row of an effect that these cards request, on any mesh.
    pub fn is_of(&self, effect: &str, asked_by: &[String]) -> bool {
        self.effect == effect && self.asked_by == asked_by
    }

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

#[cfg(test)]
mod tests {
    use super::{Ledger, LedgerRow, UnusedCard};

    /// Rows of a later mesh keep their indices; those of the deck keep their counts.
    #[test]
    fn rows_follow_those_of_a_later_mesh() {
        let rows = |names: &[(&str, usize)]| -> Vec<LedgerRow> {
            let mut ledger = Ledger::default();
            for (effect, count) in names {
                ledger.add(effect, *count, "elements", "a.inp:7".into(), String::new());
            }
            ledger.effects
        };
        let first = [("plasticity", 5), ("remeshing", 5), ("remeshing", 8), ("deletion", 5)];
        let mut ledger = Ledger { effects: rows(&first), ..Ledger::default() };
        ledger.follow(rows(&[("plasticity", 9), ("averaged pressure", 1), ("remeshing", 9), ("remeshing", 12)]));
        let found: Vec<_> = ledger.effects.iter().map(|row| (&*row.effect, row.count)).collect();
        assert_eq!(found[..3], [("plasticity", 5), ("averaged pressure", 1), ("remeshing", 5)]);
        assert_eq!(found[3..], [("remeshing", 8), ("deletion", 5)]);
    }

    #[test]
    fn many_cards_without_effect_are_one_line() {
        let card =
            |what: &str| UnusedCard { what: what.into(), asked_by: "folder/a.inp:7".into(), why: "a reason".into() };
        let ledger = |cards: &[&str]| Ledger { unused: cards.iter().map(|c| card(c)).collect(), ..Ledger::default() };
        let few = ledger(&["*PREPRINT", "*NSET, INTERNAL"]).render(false);
        assert!(
            few.ends_with("not used: *PREPRINT (a.inp:7): a reason\nnot used: *NSET, INTERNAL (a.inp:7): a reason\n")
        );
        let many = ledger(&["*BOUNDARY RP, 1", "*BOUNDARY RP, 3", "*BOUNDARY RP, 4", "*PREPRINT", "*NSET, INTERNAL"]);
        let text = many.render(false);
        assert!(text.ends_with(
            "not used: *BOUNDARY RP, *PREPRINT, *NSET (5 settings; `revolve check --bytes` gives the reasons)\n"
        ));
        assert_eq!(many.render(true).matches("a reason").count(), 5);
    }
}
