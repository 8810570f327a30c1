//! Tables for the terminal and as CSV.

use crate::output::columns::lined_up;
use crate::output::csv;

/// A table of text.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Column names.
    pub header: Vec<String>,
    /// Cells, row by row.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// Text with columns lined up, numbers to the right.
    pub fn terminal(&self) -> String {
        lined_up(&self.header, &self.rows, true)
    }

    /// CSV; fields with commas or quotes are quoted.
    pub fn csv(&self) -> String {
        std::iter::once(&self.header).chain(&self.rows).map(csv::line).collect()
    }
}

/// A cell with a number in few digits or in all that a CSV file needs; empty without a number.
pub(super) fn cell(value: Option<f64>, few: usize, all_digits: bool) -> String {
    match value {
        Some(value) if all_digits => format!("{value:?}"),
        Some(value) => digits(value, few),
        None => String::new(),
    }
}

/// Seven digits, without an exponent: what a run's accuracy can carry.
pub fn number(value: f64) -> String {
    rounded(value, 7).to_string()
}

/// Rounds to so many significant digits.
pub fn rounded(value: f64, count: usize) -> f64 {
    format!("{value:.*e}", count.saturating_sub(1)).parse().unwrap_or(value)
}

/// Seconds with a unit, three digits.
pub fn duration(seconds: f64) -> String {
    let (value, unit) = match seconds {
        s if s < 1e-3 => (1e6 * s, "us"),
        s if s < 1.0 => (1e3 * s, "ms"),
        s => (s, "s"),
    };
    format!("{} {unit}", short(value))
}

/// Three digits.
pub fn short(value: f64) -> String {
    digits(value, 3)
}

/// So many digits, in the shortest form that holds them.
pub fn digits(value: f64, count: usize) -> String {
    let number = rounded(value, count);
    let size = number.abs();
    if size != 0.0 && !(1e-4..1e7).contains(&size) { format!("{number:e}") } else { format!("{number}") }
}
