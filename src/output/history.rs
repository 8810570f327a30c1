//! Histories: rows over time as CSV, and what each column came to.
//! Never here: when a row is due.

use std::fmt::Write as _;

use indexmap::IndexMap;
use serde::Serialize;

use super::csv;
use crate::state::Instant;
use crate::state::archive::{Archive, Persist, persist_fields, persist_struct};

/// Name of the column behind the time: the number of the step, from 1.
pub const STEP: &str = "step";

/// The histories of a run: what each column came to, and the rows where they are kept.
#[derive(Clone, Debug, Default)]
pub struct History {
    /// Column names without time (`U2@REF`, `ALLKE`).
    pub columns: Vec<String>,
    /// What they came to over all rows shown.
    pub summary: HistorySummary,
    keeps_rows: bool,
    /// Total time of each row that was kept.
    times: Vec<f64>,
    /// Number of the step, from 1, of each row that was kept.
    steps: Vec<u32>,
    /// Row-major values of rows that were kept.
    values: Vec<f64>,
}

impl History {
    /// Of these columns, with all rows.
    pub fn of_rows(columns: Vec<String>) -> Self {
        History { columns, keeps_rows: true, ..History::default() }
    }

    /// Of these columns, with what they come to and no rows: a few bytes however long the run.
    pub fn of_sums(columns: Vec<String>) -> Self {
        History { columns, ..History::default() }
    }

    /// Forgets all rows, and what they came to.
    pub fn clear(&mut self) {
        self.summary.0.clear();
        self.times.clear();
        self.steps.clear();
        self.values.clear();
    }

    /// Takes a row in: a value a column.
    pub fn push(&mut self, now: &Instant, values: &[f64]) {
        self.summary.observe(&self.columns, now.total_time, values);
        if self.keeps_rows {
            self.times.push(now.total_time);
            self.steps.push(now.step);
            self.values.extend_from_slice(values);
        }
    }

    /// Total time of each row that was kept.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Number of the step, from 1, of each row that was kept.
    pub fn steps(&self) -> &[u32] {
        &self.steps
    }

    /// Value of a column in a row that was kept.
    pub fn cell(&self, row: usize, column: usize) -> f64 {
        self.values[row * self.columns.len() + column]
    }

    /// The text of `<job>_history.csv`: `time`, `step` and the columns, numbers in the shortest form that reads back the same.
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

/// What has these values at ascending times, at a time between two of them by a straight line; `None` outside.
pub fn between(times: &[f64], value: impl Fn(usize) -> f64, time: f64) -> Option<f64> {
    let after = times.partition_point(|t| *t < time);
    if *times.get(after)? == time {
        return Some(value(after));
    }
    let before = after.checked_sub(1)?;
    let (u, v) = (value(before), value(after));
    Some(u + (v - u) * (time - times[before]) / (times[after] - times[before]))
}

/// What a column came to over the rows shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ColumnSummary {
    /// Value of the last row.
    #[serde(rename = "final")]
    pub last: f64,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// When the smallest was first met.
    pub time_min: f64,
    /// When the largest was first met.
    pub time_max: f64,
}

/// All columns by name.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(transparent)]
pub struct HistorySummary(pub IndexMap<String, ColumnSummary>);

impl HistorySummary {
    fn observe(&mut self, columns: &[String], time: f64, values: &[f64]) {
        if self.0.is_empty() {
            let first = |(name, &v): (&String, &f64)| {
                (name.clone(), ColumnSummary { last: v, min: v, max: v, time_min: time, time_max: time })
            };
            self.0 = columns.iter().zip(values).map(first).collect();
            return;
        }
        for (summary, &value) in self.0.values_mut().zip(values) {
            summary.last = value;
            // What had no value so far begins with its first.
            if value < summary.min || summary.min.is_nan() {
                (summary.min, summary.time_min) = (value, time);
            }
            if value > summary.max || summary.max.is_nan() {
                (summary.max, summary.time_max) = (value, time);
            }
        }
    }
}

impl Persist for History {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let History { columns, summary, keeps_rows: _, times, steps, values } = self;
        persist_fields!(archive; times, steps, values);
        let rows = values.len().checked_div(columns.len());
        if rows.is_some_and(|rows| rows != times.len()) || steps.len() != times.len() {
            archive.refuse(|| "its histories have other columns".into());
        }
        summary.persist(columns, archive);
    }
}

persist_struct!(ColumnSummary { last, min, max, time_min, time_max });

impl HistorySummary {
    /// Visits what the columns came to, which are those of the plan once a row has been seen.
    fn persist(&mut self, columns: &[String], archive: &mut Archive<'_>) {
        let mut seen = !self.0.is_empty();
        seen.persist(archive);
        if seen && self.0.is_empty() {
            self.0 = columns.iter().map(|name| (name.clone(), ColumnSummary::default())).collect();
        }
        self.0.values_mut().for_each(|column| column.persist(archive));
    }
}
