//! History output: rows over time as CSV, and a summary of each column.

use std::fmt::Write as _;

use indexmap::IndexMap;
use serde::Serialize;

use super::csv;
use revolve_numerics::state::Instant;
use revolve_numerics::state::archive::{Persist, StateArchive, persist_fields};

/// Name of the column after the time: number of the step, from 1.
pub const STEP: &str = "step";

/// Histories of a run: summaries of the columns, and optionally the rows.
#[derive(Clone, Debug, Default)]
pub struct RunHistory {
    /// Column names without the time (`U2@REF`, `ALLKE`).
    pub columns: Vec<String>,
    /// Summaries of the columns over all rows.
    pub summary: HistorySummary,
    keeps_rows: bool,
    /// Whether the summaries are those of removed rows, to be replaced by the next row.
    is_cleared: bool,
    /// Total time of each stored row.
    times: Vec<f64>,
    /// Step number, from 1, of each stored row.
    steps: Vec<u32>,
    /// Values of stored rows, row by row.
    values: Vec<f64>,
}

impl RunHistory {
    /// Creates a history that stores all rows.
    pub fn of_rows(columns: Vec<String>) -> Self {
        RunHistory { columns, keeps_rows: true, ..RunHistory::default() }
    }

    /// Creates a history that stores only summaries; its memory does not grow with the run.
    pub fn of_sums(columns: Vec<String>) -> Self {
        RunHistory { columns, ..RunHistory::default() }
    }

    /// Removes all rows. The next row replaces the summaries.
    pub fn clear(&mut self) {
        self.is_cleared = true;
        self.times.clear();
        self.steps.clear();
        self.values.clear();
    }

    /// Adds a row: one value for each column.
    pub fn push(&mut self, now: &Instant, values: &[f64]) {
        if std::mem::take(&mut self.is_cleared) {
            self.summary.begin(&self.columns, now.total_time, values);
        } else {
            self.summary.observe(&self.columns, now.total_time, values);
        }
        if self.keeps_rows {
            self.times.push(now.total_time);
            self.steps.push(now.step);
            self.values.extend_from_slice(values);
        }
    }

    /// Returns the total time of each stored row.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Returns the step number, from 1, of each stored row.
    pub fn steps(&self) -> &[u32] {
        &self.steps
    }

    /// Returns the value of a column in a stored row.
    pub fn cell(&self, row: usize, column: usize) -> f64 {
        self.values[row * self.columns.len() + column]
    }

    /// Returns the text of `<job>_history.csv`: `time`, `step` and the columns; numbers have the fewest digits that
    /// restore the same value.
    pub fn csv(&self) -> String {
        let mut text = format!("time,{STEP}");
        for column in &self.columns {
            let _ = write!(text, ",{}", csv::field(column));
        }
        for (i, (time, step)) in self.times.iter().zip(&self.steps).enumerate() {
            let _ = write!(text, "\n{time:?},{step}");
            for value in &self.values[i * self.columns.len()..(i + 1) * self.columns.len()] {
                let _ = write!(text, ",{value:?}");
            }
        }
        text + "\n"
    }
}

/// Returns the number of characters of a row in `<job>_history.csv`.
pub fn row_length(now: &Instant, values: &[f64]) -> usize {
    let mut text = format!("\n{:?},{}", now.total_time, now.step);
    for value in values {
        let _ = write!(text, ",{value:?}");
    }
    text.len()
}

/// Interpolates values at ascending times linearly; `None` outside their range.
pub fn between(times: &[f64], value: impl Fn(usize) -> f64, time: f64) -> Option<f64> {
    let after = times.partition_point(|t| *t < time);
    if *times.get(after)? == time {
        return Some(value(after));
    }
    let previous = after.checked_sub(1)?;
    let (u, v) = (value(previous), value(after));
    Some(u + (v - u) * (time - times[previous]) / (times[after] - times[previous]))
}

/// Summary of a column over all rows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Persist)]
pub struct ColumnSummary {
    /// Value of the last row.
    #[serde(rename = "final")]
    pub last: f64,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// Time of the first minimum.
    pub time_min: f64,
    /// Time of the first maximum.
    pub time_max: f64,
}

impl ColumnSummary {
    /// Returns the value of the function `final`, `min`, `max`, `time_min` or `time_max`.
    pub fn value(&self, function: &str) -> f64 {
        match function {
            "final" => self.last,
            "min" => self.min,
            "max" => self.max,
            "time_min" => self.time_min,
            _ => self.time_max,
        }
    }
}

/// Summary of each history column, by the name of the column.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(transparent)]
pub struct HistorySummary(pub IndexMap<String, ColumnSummary>);

impl HistorySummary {
    /// Takes the first row; names that exist are not allocated again.
    fn begin(&mut self, columns: &[String], time: f64, values: &[f64]) {
        let first = |v: f64| ColumnSummary { last: v, min: v, max: v, time_min: time, time_max: time };
        if self.0.len() == values.len() {
            self.0.values_mut().zip(values).for_each(|(summary, value)| *summary = first(*value));
        } else {
            self.0 = columns.iter().zip(values).map(|(name, value)| (name.clone(), first(*value))).collect();
        }
    }

    fn observe(&mut self, columns: &[String], time: f64, values: &[f64]) {
        if self.0.is_empty() {
            return self.begin(columns, time, values);
        }
        for (summary, &value) in self.0.values_mut().zip(values) {
            summary.last = value;
            // Replaces NaN by the first value.
            if value < summary.min || summary.min.is_nan() {
                (summary.min, summary.time_min) = (value, time);
            }
            if value > summary.max || summary.max.is_nan() {
                (summary.max, summary.time_max) = (value, time);
            }
        }
    }

    /// Saves or reads the summaries; after the first row the columns are those of the plan.
    fn persist(&mut self, columns: &[String], archive: &mut StateArchive<'_>) {
        let mut seen = !self.0.is_empty();
        seen.persist(archive);
        if seen && self.0.is_empty() {
            self.0 = columns.iter().map(|name| (name.clone(), ColumnSummary::default())).collect();
        }
        self.0.values_mut().for_each(|column| column.persist(archive));
    }
}

impl Persist for RunHistory {
    fn persist(&mut self, archive: &mut StateArchive<'_>) {
        let RunHistory { columns, summary, keeps_rows: _, is_cleared: _, times, steps, values } = self;
        persist_fields!(archive; times, steps, values);
        let rows = values.len().checked_div(columns.len());
        if rows.is_some_and(|rows| rows != times.len()) || steps.len() != times.len() {
            archive.reject(|| "its history columns differ".into());
        }
        summary.persist(columns, archive);
    }
}
