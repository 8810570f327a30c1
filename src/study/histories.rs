//! Functions of what history columns came to, for quantities.
//! Never here: the evaluator (`deck::expression`), rows of histories.

use super::StudyError;
use crate::deck::expression::{Expression, ExpressionError};
use crate::deck::names::nearest;
use crate::output::HistorySummary;

/// Functions of a history column.
pub(super) const FUNCTIONS: &[&str] = &["final", "min", "max", "time_min", "time_max"];

/// The expression of a quantity.
pub(super) fn parse(text: &str, functions: &[&str]) -> Result<Expression, StudyError> {
    let wrong =
        |e: ExpressionError| StudyError::Quantity { text: text.to_owned(), at: Some(e.start + 1), message: e.message };
    Expression::parse_with(text, functions).map_err(wrong)
}

pub(super) fn value(history: &HistorySummary, function: &str, column: &str) -> Result<f64, String> {
    let summary = history.0.iter().find(|(name, _)| name.eq_ignore_ascii_case(column)).map(|(_, s)| s);
    let Some(summary) = summary else { return Err(missing(history, column)) };
    Ok(match function {
        "final" => summary.last,
        "min" => summary.min,
        "max" => summary.max,
        "time_min" => summary.time_min,
        _ => summary.time_max,
    })
}

fn missing(history: &HistorySummary, column: &str) -> String {
    let names: Vec<&str> = history.0.keys().map(String::as_str).collect();
    match nearest(column, names.iter().copied()) {
        Some(near) => format!("there is no history column {column}; did you mean {near}?"),
        None => {
            format!("there is no history column {column}; the deck's *OUTPUT, HISTORY asks for {}", names.join(", "))
        }
    }
}
