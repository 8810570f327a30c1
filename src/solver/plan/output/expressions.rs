//! History columns that are computed from other columns (`*OUTPUT EXPRESSION`). The evaluator is in `deck::expression`.

use crate::deck::expression::{Expression, ExpressionError};
use crate::deck::names::nearest;
use crate::deck::{Diagnostic, Span};
use crate::model::{Model, OutputExpression};
use crate::plan::{ColumnSource, Columns, HistoryColumn, Report};

/// Name of the total time in expressions.
const TIME: &str = "time";

/// An expression of previous history columns.
#[derive(Clone, Debug)]
pub struct RowExpression {
    expression: Expression,
    /// Names and indices of the columns in the expression.
    columns: Vec<(String, usize)>,
}

impl RowExpression {
    /// Parses an expression of history columns.
    fn read(text: &str, columns: &[HistoryColumn]) -> Result<RowExpression, ExpressionError> {
        let find = |name: &str| columns.iter().position(|c| c.name.eq_ignore_ascii_case(name));
        let expression = Expression::parse_over(text, &|rest| longest(rest, columns))?;
        expression.check(&|name| name.eq_ignore_ascii_case(TIME) || find(name).is_some())?;
        let columns = expression.names().filter_map(|name| Some((name.to_owned(), find(name)?))).collect();
        Ok(RowExpression { expression, columns })
    }

    /// Returns the indices of the columns in the expression.
    pub fn columns(&self) -> impl Iterator<Item = usize> {
        self.columns.iter().map(|column| column.1)
    }

    /// Returns the value for a row of column values at a total time; NaN if it has none.
    pub fn value(&self, time: f64, row: &[f64]) -> f64 {
        let find = |name: &str| self.columns.iter().find(|c| c.0 == name).map(|c| row[c.1]);
        let known = |name: &str| find(name).or_else(|| name.eq_ignore_ascii_case(TIME).then_some(time));
        self.expression.evaluate(&known, &|_, _| None).unwrap_or(f64::NAN)
    }
}

/// Returns the length in bytes of the longest column name at the beginning of a text, ignoring case; 0 if there is none
/// or the name continues.
fn longest(text: &str, columns: &[HistoryColumn]) -> usize {
    let begins = |name: &str| text.get(..name.len()).is_some_and(|start| start.eq_ignore_ascii_case(name));
    let ends = |name: &str| !text[name.len()..].starts_with(|c: char| c.is_alphanumeric() || "_@.".contains(c));
    let names = columns.iter().map(|c| c.name.as_str());
    names.filter(|name| begins(name) && ends(name)).map(str::len).max().unwrap_or(0)
}

/// Adds the columns of `*OUTPUT EXPRESSION` after all other columns.
pub fn expression_columns(model: &Model, columns: &mut Columns, report: &mut Report) {
    for definition in &model.output.expressions {
        let OutputExpression { name, text, span, .. } = definition;
        if let Some(why) = taken(name, &columns.list) {
            let finding = Diagnostic::error("P076", format!("the history column `{name}` cannot be defined: {why}"));
            report.push(finding.at(*span, "this name").help("choose another name"));
            continue;
        }
        match RowExpression::read(text, &columns.list) {
            Ok(expression) => {
                report.ledger_row(*span, "history expression", 1, "column", format!("{name} = {text}"));
                let source = ColumnSource::Expression(columns.expressions.len());
                columns.list.push(HistoryColumn { name: name.clone(), part: None, source });
                columns.expressions.push(expression);
            }
            Err(error) => wrong_expression(definition, &error, &columns.list, report),
        }
    }
}

fn wrong_expression(card: &OutputExpression, error: &ExpressionError, columns: &[HistoryColumn], report: &mut Report) {
    let OutputExpression { name, text, place, .. } = card;
    let whole = place.end.checked_sub(place.start) != Some(text.len() as u32);
    let inside = |at: usize| place.start + at as u32;
    let error_span = if whole { *place } else { Span { start: inside(error.start), end: inside(error.end), ..*place } };
    let (what, label) = match &error.unknown {
        Some(unknown) => (format!("history column `{unknown}` does not exist"), "not a column"),
        None => (format!("the expression of history column `{name}` is invalid"), error.message.as_str()),
    };
    let finding = Diagnostic::error("P075", what).at(error_span, label);
    report.push(match &error.unknown {
        Some(unknown) => finding.help(near(unknown, columns)),
        None => finding,
    });
}

/// Returns the reason why a column name is not allowed.
fn taken(name: &str, columns: &[HistoryColumn]) -> Option<&'static str> {
    match () {
        () if columns.iter().any(|c| c.name.eq_ignore_ascii_case(name)) => Some("the name is already used"),
        () if [TIME, "step", "pi"].iter().any(|n| n.eq_ignore_ascii_case(name)) => Some("the name is reserved"),
        () => None,
    }
}

/// Suggests a similar column name, or lists the columns.
fn near(unknown: &str, columns: &[HistoryColumn]) -> String {
    let names = || columns.iter().map(|c| c.name.as_str());
    if let Some(near) = nearest(unknown, names()) {
        return format!("did you mean {near}?");
    }
    let first_names: Vec<&str> = names().take(12).collect();
    let more = if columns.len() > 12 { ", …" } else { "" };
    match first_names[..] {
        [] => "the deck requests no history output; add *OUTPUT, HISTORY for the columns of the expression".into(),
        _ => format!("the history columns are {}{more}", first_names.join(", ")),
    }
}
