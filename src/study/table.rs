//! Tables for the terminal and as CSV.
//! Never here: what is in them.

use crate::output::columns::lined_up;
use crate::output::csv;

/// Text with columns lined up, numbers to the right.
pub fn terminal(header: &[String], rows: &[Vec<String>]) -> String {
    lined_up(header, rows, true)
}

/// CSV; fields with commas or quotes are quoted.
pub fn csv(header: &[String], rows: &[Vec<String>]) -> String {
    let line = |row: &[String]| row.iter().map(|f| csv::field(f)).collect::<Vec<_>>().join(",") + "\n";
    line(header) + &rows.iter().map(|r| line(r)).collect::<String>()
}

/// Seven digits: what a run's accuracy can carry.
pub fn number(value: f64) -> String {
    let text = format!("{value:.6e}");
    let short: f64 = text.parse().unwrap_or(value);
    format!("{short}")
}
