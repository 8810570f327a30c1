//! `--quantity`: an expression over what the history columns came to, such as `-1000*final(U2@REF)`.
//! Never here: the evaluator (`deck::expression`).

use super::StudyError;
use crate::deck::expression::{Argument, Expression, ExpressionError};
use crate::deck::names::nearest;
use crate::output::HistorySummary;

/// Functions of a history column.
pub(super) const FUNCTIONS: &[&str] = &["final", "min", "max", "time_min", "time_max"];

/// A quantity that has been parsed.
#[derive(Clone, Debug)]
pub struct Quantity {
    /// As written.
    pub text: String,
    expression: Expression,
}

impl Quantity {
    /// Parses an expression. `final(C)`, `min(C)`, `max(C)`, `time_min(C)` and `time_max(C)` take a column name.
    ///
    /// # Errors
    /// [`StudyError::Quantity`], with the place in the expression.
    pub fn parse(text: &str) -> Result<Quantity, StudyError> {
        let expression = parse(text, FUNCTIONS)?;
        Ok(Quantity { text: text.to_owned(), expression })
    }

    /// The value for a run's histories.
    ///
    /// # Errors
    /// [`StudyError::Quantity`]: a column that does not exist, with the nearest that does.
    pub fn evaluate(&self, history: &HistorySummary) -> Result<f64, StudyError> {
        let call = |function: &str, arguments: &[Argument]| {
            let [Argument::Raw(column)] = arguments else { return None };
            Some(value(history, function, column))
        };
        self.expression.evaluate(&|_| None, &call).map_err(|e| StudyError::quantity(&self.text, e.message))
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_read_columns() {
        let mut history = HistorySummary::default();
        let columns = ["U2@REF".to_owned()];
        for (t, u) in [(0.0, 0.0), (1.0, -0.06), (2.0, -0.05)] {
            history.observe(&columns, t, &[u]);
        }
        let value = |text: &str| Quantity::parse(text).and_then(|q| q.evaluate(&history));
        assert_eq!(value("-1000*final(U2@REF)"), Ok(50.0));
        assert_eq!(value("time_min(u2@ref) + max(U2@REF)"), Ok(1.0));
        assert!(value("final(U2@RFE)").is_err_and(|e| e.to_string().contains("did you mean U2@REF")));
        assert!(value("final(").is_err());
        for (wrong, told) in [
            ("finl(U2@REF)", "there is no function finl; did you mean final?"),
            ("sqrt(2 U2)", "`U` is not expected here"),
        ] {
            assert!(value(wrong).is_err_and(|e| e.to_string().contains(told)), "{wrong}");
        }
    }
}
