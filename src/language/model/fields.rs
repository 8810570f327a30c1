//! Predefined fields: `*FIELD` and `*TEMPERATURE`, their propagation over steps, and material tables that depend on field
//! variables (`DEPENDENCIES=`).

use super::amplitudes;
use super::context::Context;
use super::families::StepReader;
use super::history::{StepHistory, StepTiming};
use super::names::upper;
use super::types::{Model, PredefinedVariable, PrescribedField};
use crate::deck::read::FromValue;
use crate::deck::{Card, DataLine};

/// Largest number of field variables.
pub const MOST_FIELDS: usize = 100;

/// Reads `*FIELD` or `*TEMPERATURE`. A value without amplitude is applied at once (ABAQUS Analysis User's Guide 34.6.1, "Predefined
/// fields", and 34.1.2, "Amplitude curves").
pub fn read_prescribed_fields(context: &mut Context<'_>, steps: &mut StepReader, card: &Card) {
    let Ok(amplitude) = amplitudes::amplitude_of(context, card, "AMPLITUDE") else { return };
    if steps.current.as_ref().is_some_and(|s| s.ramp) && amplitude.is_none() {
        let message = format!("*STEP, AMPLITUDE=RAMP with *{} is not supported", card.keyword.name);
        return context.unsupported(card.span, message, "give AMPLITUDE=");
    }
    let is_temperature = card.keyword.name == "TEMPERATURE";
    let variable = if is_temperature {
        PredefinedVariable::Temperature
    } else {
        PredefinedVariable::Field(card.read::<usize>("VARIABLE") - 1)
    };
    let Some(user) = user_variables(context, card, amplitude.is_some()) else { return };
    if steps.operation(card, card.keyword.name) {
        let given = &mut steps.state().history.fields;
        given.retain(|field| (field.variable == PredefinedVariable::Temperature) != is_temperature);
    }
    for (at, line) in card.lines.iter().enumerate() {
        let Some(set) = line.field(0) else { continue };
        let value = if user.is_some() { 0.0 } else { f64::from_value(card.given_field(at, 1)) };
        let Some(nodes) = context.node_members(set) else { continue };
        let target = match variable {
            PredefinedVariable::Temperature => format!("`{}`", upper(&set.text)),
            PredefinedVariable::Field(variable) => format!("variable {} of `{}`", variable + 1, upper(&set.text)),
        };
        steps.note_value(context, card, target, line.span);
        let value = amplitudes::scaled(context, value, amplitude);
        let (set, span) = (set.text.clone(), line.span);
        steps.state().fields.push(PrescribedField { variable, nodes, set, user, value, amplitude, span });
    }
}

/// Returns the number of variables that the user subroutine sets together; `Some(None)` without `USER`.
fn user_variables(context: &mut Context<'_>, card: &Card, has_amplitude: bool) -> Option<Option<usize>> {
    let number: Option<usize> = card.read("NUMBER");
    if !card.has("USER") {
        let message = "NUMBER and BLOCKING of *FIELD require USER";
        let is_given = number.is_some() || card.has("BLOCKING");
        return if is_given { context.refuse_value(card.span, message) } else { Some(None) };
    }
    if has_amplitude {
        return context.refuse_value(card.span, "vufield sets the values: remove AMPLITUDE");
    }
    let number = number.unwrap_or(1);
    let last = card.read::<usize>("VARIABLE") - 1 + number;
    let message = format!("the last variable of NUMBER={number} would be {last}, and at most {MOST_FIELDS} exist");
    if last > MOST_FIELDS { context.refuse_value(card.span, message) } else { Some(Some(number)) }
}

/// Reads rows of `values` values, the temperature and `fields` field variables. If no row has a temperature, it is
/// 0.
pub fn rows_over_fields(context: &mut Context<'_>, card: &Card, values: usize, fields: usize) -> Option<Vec<Vec<f64>>> {
    let first = context.first_line(card)?;
    let limit = values + 1 + fields;
    for word in card.lines.iter().flat_map(|line| (limit..line.fields.len()).filter_map(|at| line.field(at))) {
        context.report_surplus(word, &format!("DEPENDENCIES={fields} reads {limit} values of a row"));
    }
    let row = |context: &mut Context<'_>, line: &DataLine| -> Option<Vec<f64>> {
        let default = |i: usize| if i == values { f64::NAN } else { 0.0 };
        (0..values + 1 + fields).map(|i| context.number_or(line, i, default(i))).collect()
    };
    let mut rows: Vec<Vec<f64>> = card.lines.iter().map(|line| row(context, line)).collect::<Option<_>>()?;
    let cold = rows.iter().filter(|r| r[values].is_nan()).count();
    if cold != 0 && cold != rows.len() {
        return context.refuse_value(first.span, "all rows of a table must have a temperature, or none");
    }
    rows.iter_mut().filter(|r| r[values].is_nan()).for_each(|r| r[values] = 0.0);
    Some(rows)
}

impl StepHistory {
    /// Returns the predefined fields in force in a step that prescribes `given`, and stores those that continue in the
    /// next step. A field that is no longer prescribed returns to its initial value.
    pub fn fields(
        &mut self,
        given: Vec<PrescribedField>,
        step: &StepTiming,
        model: &mut Model,
    ) -> Vec<PrescribedField> {
        let mut in_force = std::mem::take(&mut self.fields);
        for later in given {
            for earlier in in_force.iter_mut().filter(|e| e.shares_variable(&later)) {
                earlier.nodes.retain(|n| later.nodes.binary_search(n).is_err());
            }
            in_force.push(later);
        }
        in_force.retain(|field| !field.nodes.is_empty());
        let mut carried = in_force.clone();
        for field in &mut carried {
            self.settle((&mut field.value, &mut field.amplitude), false, step, model);
        }
        self.fields = carried;
        in_force
    }
}
