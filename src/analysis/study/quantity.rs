//! Quantities: expressions over history columns and norms of fields, for example `-1000*final(U2@REF)`.

use super::StudyError;
use super::field::{FieldName, NormField};
use crate::deck::expression::{Expression, ExpressionError, FunctionArgument};
use crate::deck::names::nearest;
use crate::output::history::between;
use crate::output::{HistorySummary, RunHistory};
use crate::plan::{Plan, State};
use crate::state::Instant;

/// Functions of a history column that need only its final and extreme values.
const FUNCTIONS: &[&str] = &["final", "min", "max", "time_min", "time_max"];
/// Functions whose arguments are not a column alone: values between rows, time averages, norms and the outline.
const MORE: [&str; 4] = ["at", "mean", "norm", "outline"];
/// Functions of the final state; history rows are not needed.
const STATE_FUNCTIONS: [&str; 2] = ["norm", "outline"];
/// Error text for a function of the final state of a run that is not available.
const NO_STATE: &str = "norm(...) and outline(...) are not available in the command run";

/// A parsed quantity: an expression over history columns and field norms of a run.
#[derive(Clone, Debug)]
pub struct Quantity {
    /// Expression as written.
    pub text: String,
    kind: QuantityKind,
    /// Whether history rows are needed, and not only final and extreme values.
    rows: bool,
}

#[derive(Clone, Debug)]
enum QuantityKind {
    /// Number computed for each run.
    Number(Expression),
    /// `norm(VARIABLE)` alone: a field of each run, compared with that of the finest level.
    Field(FieldName),
}

/// Value of a quantity for one run.
#[derive(Clone, Debug, PartialEq)]
pub enum QuantityValue {
    /// Value of the expression.
    Number(f64),
    /// A field, to be compared with that of the finest level.
    Field(Box<NormField>),
}

impl QuantityValue {
    /// Returns the number; `None` for a field.
    pub fn number(&self) -> Option<f64> {
        match self {
            QuantityValue::Number(value) => Some(*value),
            QuantityValue::Field(_) => None,
        }
    }
}

impl Quantity {
    /// Parses an expression of `final(C)`, `min(C)`, `max(C)`, `time_min(C)`, `time_max(C)`, `at(C, t)`,
    /// `mean(C, t1, t2)` over history columns, `norm(VARIABLE, EXPR)` over nodes or elements, where EXPR knows `r`,
    /// `z` (current), `r0`, `z0` (initial) and `t`, and `outline(z)`, the largest final radius of the deformable
    /// elements at the height z. `norm(VARIABLE)` alone compares with the finest level.
    pub fn parse(text: &str) -> Result<Quantity, StudyError> {
        let functions: Vec<&str> = FUNCTIONS.iter().copied().chain(MORE).collect();
        let expression = parse_expression(text, &functions)?;
        let alone = text.trim().strip_prefix("norm(").and_then(|t| t.strip_suffix(')'));
        if let Some(variable) = alone.filter(|a| !a.contains([',', '('])) {
            let field = FieldName::parse(variable).map_err(|e| StudyError::quantity(text, e))?;
            return Ok(Quantity { text: text.to_owned(), kind: QuantityKind::Field(field), rows: false });
        }
        for (function, argument) in expression.raw_arguments() {
            check(function, argument).map_err(|e| StudyError::quantity(text, e))?;
        }
        let rows = expression.raw_arguments().any(|(f, _)| f == "at" || f == "mean");
        Ok(Quantity { text: text.to_owned(), kind: QuantityKind::Number(expression), rows })
    }

    /// Returns whether the quantity compares fields with the finest level.
    pub fn compares_fields(&self) -> bool {
        matches!(self.kind, QuantityKind::Field(_))
    }

    /// Returns whether the quantity is a norm alone, and thus already a relative error.
    pub fn is_norm(&self) -> bool {
        let QuantityKind::Number(expression) = &self.kind else { return true };
        let mut arguments = expression.raw_arguments();
        let alone = format!("norm({})", arguments.next().map_or("", |a| a.1));
        arguments.next().is_none() && self.text.split_whitespace().eq(alone.split_whitespace())
    }

    /// Returns whether only the last history row is needed.
    pub fn needs_last_row_only(&self) -> bool {
        let QuantityKind::Number(expression) = &self.kind else { return true };
        expression.raw_arguments().all(|(function, _)| function == "final" || STATE_FUNCTIONS.contains(&function))
    }

    /// Returns the names of the history columns in the expression.
    pub fn columns(&self) -> impl Iterator<Item = &str> {
        let expression = match &self.kind {
            QuantityKind::Number(expression) => Some(expression),
            QuantityKind::Field(_) => None,
        };
        let of_columns = |&(function, _): &(&str, &str)| !STATE_FUNCTIONS.contains(&function);
        let arguments = expression.into_iter().flat_map(Expression::raw_arguments).filter(of_columns);
        arguments.map(|(_, argument)| argument.split(',').next().unwrap_or_default().trim())
    }

    /// Returns the quantity with the time average between two times in place of final values and values at a time;
    /// `None` if it has neither.
    pub fn averaged(&self, from: f64, to: f64) -> Option<Quantity> {
        let QuantityKind::Number(expression) = &self.kind else { return None };
        let mut text = self.text.clone();
        for (function, argument) in expression.raw_arguments().filter(|(f, _)| matches!(*f, "final" | "at")) {
            let column = argument.split(',').next().unwrap_or_default().trim();
            text = text.replace(&format!("{function}({argument})"), &format!("mean({column}, {from:?}, {to:?})"));
        }
        if text == self.text { None } else { Quantity::parse(&text).ok() }
    }

    /// Creates a history that stores the data needed for this quantity.
    pub fn history(&self, plan: &Plan) -> RunHistory {
        history(std::slice::from_ref(self), plan)
    }

    /// Checks that the quantity does not need a finest level, which only a study has.
    pub fn check_without_study(&self) -> Result<(), StudyError> {
        let message = "norm(VAR) needs the finest level of a study; use norm(VAR, EXPR)";
        if self.compares_fields() { Err(StudyError::quantity(&self.text, message.into())) } else { Ok(()) }
    }

    /// Checks that a run of the plan can provide the quantity: its history columns exist, and a norm has deformable
    /// elements.
    pub fn check(&self, plan: &Plan) -> Result<(), StudyError> {
        let wrong = |message: String| StudyError::quantity(&self.text, message);
        let nothing = "norms and outlines need deformable elements, and the model has none";
        let QuantityKind::Number(expression) = &self.kind else {
            return if !plan.places.elements.is_empty() { Ok(()) } else { Err(wrong(nothing.into())) };
        };
        let mut empty = self.history(plan);
        empty.push(&Instant::default(), &vec![0.0; plan.columns.len()]);
        for (function, argument) in expression.raw_arguments() {
            let name = argument.split(',').next().unwrap_or_default().trim();
            match function {
                function if STATE_FUNCTIONS.contains(&function) => {
                    if plan.places.elements.is_empty() {
                        return Err(wrong(nothing.into()));
                    }
                }
                _ => drop(column(&empty, name).map_err(wrong)?),
            }
        }
        if expression.raw_arguments().next().is_none() {
            return Err(wrong(
                "the expression does not depend on the run; use final(COLUMN), at(COLUMN, t), norm(VARIABLE, EXPR), …"
                    .into(),
            ));
        }
        Ok(())
    }

    /// Computes the quantity, a number or a field, from the results of a run.
    pub fn evaluate(&self, run: FinishedRun<'_>) -> Result<QuantityValue, StudyError> {
        let wrong = |message: String| StudyError::quantity(&self.text, message);
        match &self.kind {
            QuantityKind::Field(name) => {
                let (time, state) = run.end.ok_or_else(|| wrong(NO_STATE.into()))?;
                NormField::of(state, *name, time).map(|f| QuantityValue::Field(Box::new(f))).map_err(wrong)
            }
            QuantityKind::Number(_) => self.number(run).map(QuantityValue::Number),
        }
    }

    /// Evaluates the quantity for a run as a number.
    pub fn number(&self, run: FinishedRun<'_>) -> Result<f64, StudyError> {
        let wrong = |message: String| StudyError::quantity(&self.text, message);
        self.check_without_study()?;
        let QuantityKind::Number(expression) = &self.kind else {
            return Err(wrong("the quantity is a field, not a number".into()));
        };
        let call = |function: &str, arguments: &[FunctionArgument]| {
            let [FunctionArgument::Raw(argument)] = arguments else { return None };
            Some(match function {
                "at" => at(run.history, argument),
                "mean" => mean(run.history, argument),
                "norm" => run.end.ok_or(NO_STATE.to_owned()).and_then(|end| norm(end, argument)),
                "outline" => run.end.ok_or(NO_STATE.to_owned()).and_then(|end| outline(end.1, argument)),
                _ => summary_value(&run.history.summary, function, argument),
            })
        };
        let number = expression.evaluate(&|_| None, &call).map_err(|e| wrong(e.message))?;
        if number.is_finite() { Ok(number) } else { Err(wrong(format!("the value is {number}"))) }
    }
}

/// A finished run: its histories and, if available, its final state.
#[derive(Clone, Copy)]
pub struct FinishedRun<'a> {
    /// Histories, with rows if a quantity [needs them](history).
    pub history: &'a RunHistory,
    /// Final time and state; required for norms.
    pub end: Option<(f64, &'a State)>,
}

/// Checks that runs of the plan, without a study, can provide all quantities.
pub fn check_all(quantities: &[Quantity], plan: &Plan) -> Result<(), StudyError> {
    quantities.iter().try_for_each(|quantity| quantity.check_without_study().and_then(|()| quantity.check(plan)))
}

/// Creates a history that stores the data needed for all quantities.
pub fn history(quantities: &[Quantity], plan: &Plan) -> RunHistory {
    let rows = quantities.iter().any(|q| q.rows);
    if rows { RunHistory::of_rows(plan.column_names()) } else { RunHistory::of_sums(plan.column_names()) }
}

/// Returns the index of a history column.
fn column(history: &RunHistory, name: &str) -> Result<usize, String> {
    // Creates the error message for a missing column.
    summary_value(&history.summary, "final", name)?;
    history.columns.iter().position(|c| c.eq_ignore_ascii_case(name)).ok_or_else(|| format!("no column {name}"))
}

fn row_between(history: &RunHistory, column: usize, time: f64) -> Result<f64, String> {
    let last = history.times().last().copied().unwrap_or(0.0);
    // The end time as written in the expression may differ from the last row by rounding.
    let meant = if time > last && time <= last * (1.0 + 1e-9) { last } else { time };
    between(history.times(), |row| history.cell(row, column), meant)
        .ok_or_else(|| format!("the time {time:e} is outside the history; the last row is at {last:e}"))
}

/// Checks the form of an argument before any run.
fn check(function: &str, argument: &str) -> Result<(), String> {
    match function {
        "at" => parts::<1>(function, argument).map(|_| ()),
        "mean" => parts::<2>(function, argument).map(|_| ()),
        "norm" => norm_parts(argument).map(|_| ()),
        "outline" => height(argument).map(|_| ()),
        _ => Ok(()),
    }
}

/// Parses a column and `N` numbers.
fn parts<'a, const N: usize>(function: &str, argument: &'a str) -> Result<(&'a str, [f64; N]), String> {
    let form = if N == 1 { "at(COLUMN, time)" } else { "mean(COLUMN, from, to)" };
    let words: Vec<&str> = argument.split(',').map(str::trim).collect();
    let wrong = || format!("{function}({argument}): expected {form}");
    let (column, number_texts) = words.split_first().filter(|w| w.1.len() == N).ok_or_else(wrong)?;
    let mut numbers = [0.0; N];
    for (number, text) in numbers.iter_mut().zip(number_texts) {
        let expression = Expression::parse(text).map_err(|_| wrong())?;
        *number = expression.evaluate(&|_| None, &|_, _| None).map_err(|_| wrong())?;
    }
    Ok((column, numbers))
}

/// Parses the argument of `outline`, a number.
fn height(argument: &str) -> Result<f64, String> {
    let number = Expression::parse(argument).and_then(|e| e.evaluate(&|_| None, &|_, _| None));
    number.map_err(|_| format!("outline({argument}): expected outline(z) with a number z"))
}

/// Returns the largest radius of the deformable elements at a height in the current configuration.
fn outline(state: &State, argument: &str) -> Result<f64, String> {
    let z = height(argument)?;
    let position = |n: u32| state.dofs.nodes[n as usize].place();
    let mut largest: Option<f64> = None;
    for group in &state.elements.groups {
        for element in (0..group.len()).filter(|e| !group.is_deleted(*e)) {
            let boundary = group.boundary(element);
            for (i, node) in boundary.iter().enumerate() {
                let [a, b] = [position(*node), position(boundary[(i + 1) % boundary.len()])];
                if (a[1] - z) * (b[1] - z) <= 0.0 {
                    let part = (z - a[1]) / (b[1] - a[1]);
                    let radius = if a[1] == b[1] { a[0].max(b[0]) } else { a[0] + part * (b[0] - a[0]) };
                    largest = Some(largest.map_or(radius, |known| known.max(radius)));
                }
            }
        }
    }
    largest.ok_or_else(|| format!("no deformable element is at the height {z:e} at the end of the run"))
}

fn at(history: &RunHistory, argument: &str) -> Result<f64, String> {
    let (name, [time]) = parts::<1>("at", argument)?;
    row_between(history, column(history, name)?, time)
}

/// Returns the time average by the trapezoidal rule over the rows.
fn mean(history: &RunHistory, argument: &str) -> Result<f64, String> {
    let (name, [from, until]) = parts::<2>("mean", argument)?;
    let (column, times) = (column(history, name)?, history.times());
    let mut previous = (from, row_between(history, column, from)?);
    let end = (until, row_between(history, column, until)?);
    let inside = (0..times.len()).filter(|&i| times[i] > from && times[i] < until);
    let mut sum = 0.0;
    for (time, value) in inside.map(|i| (times[i], history.cell(i, column))).chain([end]) {
        sum += 0.5 * (value + previous.1) * (time - previous.0);
        previous = (time, value);
    }
    if until > from {
        Ok(sum / (until - from))
    } else {
        Err(format!("mean({argument}): the second time must be greater than the first"))
    }
}

fn norm_parts(argument: &str) -> Result<(FieldName, Expression), String> {
    let Some((variable, exact)) = argument.split_once(',') else {
        return Err(format!(
            "norm({argument}) compares with the finest level and must stand alone; norm({argument}, EXPR in r, z, t) \
             compares with an expression"
        ));
    };
    let exact = Expression::parse(exact.trim()).map_err(|e| format!("norm({argument}): {}", e.message))?;
    let known = ["r", "z", "r0", "z0", "t", "pi"];
    if let Some(name) = exact.names().find(|n| !known.contains(n)) {
        return Err(format!("norm({argument}): unknown name `{name}`; allowed names: r, z, r0, z0, t, pi"));
    }
    Ok((FieldName::parse(variable)?, exact))
}

fn norm((time, state): (f64, &State), argument: &str) -> Result<f64, String> {
    let (name, exact) = norm_parts(argument)?;
    let field = NormField::of(state, name, time)?;
    field.relative_norm(|point| {
        let known = |name: &str| match name {
            "r" => Some(point.now[0]),
            "z" => Some(point.now[1]),
            "r0" => Some(point.start[0]),
            "z0" => Some(point.start[1]),
            "t" => Some(time),
            _ => None,
        };
        exact.evaluate(&known, &|_, _| None).map_err(|e| e.message)
    })
}

fn parse_expression(text: &str, functions: &[&str]) -> Result<Expression, StudyError> {
    let wrong =
        |e: ExpressionError| StudyError::Quantity { text: text.to_owned(), at: Some(e.start + 1), message: e.message };
    Expression::parse_with(text, functions).map_err(wrong)
}

fn summary_value(history: &HistorySummary, function: &str, column: &str) -> Result<f64, String> {
    let summary = history.0.iter().find(|(name, _)| name.eq_ignore_ascii_case(column)).map(|(_, s)| s);
    let Some(summary) = summary else { return Err(missing(history, column)) };
    Ok(summary.value(function))
}

fn missing(history: &HistorySummary, column: &str) -> String {
    let names: Vec<&str> = history.0.keys().map(String::as_str).collect();
    match nearest(column, names.iter().copied()) {
        Some(near) => format!("there is no history column {column}; did you mean {near}?"),
        None => {
            format!("there is no history column {column}; the deck requests {}", names.join(", "))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn now(total_time: f64) -> Instant {
        Instant { total_time, ..Instant::default() }
    }

    #[test]
    fn histories_are_interpolated_between_rows() {
        let mut history = RunHistory::of_rows(vec!["U2@REF".into()]);
        for (t, u) in [(0.0, 0.0), (1.0, 2.0), (2.0, 0.0)] {
            history.push(&now(t), &[u]);
        }
        assert_eq!(at(&history, "u2@ref, 0.5"), Ok(1.0));
        assert_eq!(at(&history, "U2@REF, 1+1"), Ok(0.0));
        assert_eq!(mean(&history, "U2@REF, 0, 2"), Ok(1.0));
        assert_eq!(mean(&history, "U2@REF, 0.5, 1.5"), Ok(1.5));
        for wrong in ["U2@REF, 3", "U2@REF", "U2@RFE, 1", "U2@REF, x"] {
            assert!(at(&history, wrong).is_err(), "{wrong}");
        }
        assert!(mean(&history, "U2@REF, 1, 1").is_err());
    }

    #[test]
    fn invalid_expressions_are_errors_before_any_run() {
        for wrong in
            ["final(", "at(C)", "mean(C, 1)", "norm(NOISE)", "norm(S22, x)", "2*norm(S22)", "norm(S22, 1+)", ""]
        {
            assert!(Quantity::parse(wrong).is_err(), "{wrong}");
        }
        assert!(Quantity::parse("norm(S22)").is_ok_and(|m| m.compares_fields()));
        assert!(Quantity::parse("2*norm(V2, sin(pi*(z - t)))").is_ok_and(|m| !m.compares_fields()));
    }

    #[test]
    fn quantities_read_columns() {
        let mut history = RunHistory::of_sums(vec!["U2@REF".into()]);
        for (t, u) in [(0.0, 0.0), (1.0, -0.06), (2.0, -0.05)] {
            history.push(&now(t), &[u]);
        }
        let value =
            |text: &str| Quantity::parse(text).and_then(|q| q.number(FinishedRun { history: &history, end: None }));
        assert_eq!(value("-1000*final(U2@REF)"), Ok(50.0));
        assert_eq!(value("time_min(u2@ref) + max(U2@REF)"), Ok(1.0));
        assert!(value("final(U2@RFE)").is_err_and(|e| e.to_string().contains("did you mean U2@REF")));
        assert!(value("final(").is_err());
        for (wrong, message) in [
            ("finl(U2@REF)", "there is no function finl; did you mean final?"),
            ("sqrt(2 U2)", "`U` is not expected here"),
        ] {
            assert!(value(wrong).is_err_and(|e| e.to_string().contains(message)), "{wrong}");
        }
    }
}
