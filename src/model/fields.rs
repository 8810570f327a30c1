//! Field variables over the steps: `*FIELD`, and tables of materials that depend on them (`DEPENDENCIES=`).
//! Never here: how elements are given them.

use super::builder::Builder;
use super::history::{History, StepTime};
use super::types::{Model, PrescribedField};
use crate::deck::{Card, DataLine};

/// Field variables that a deck may give.
pub(super) const MOST_FIELDS: usize = 100;
/// Field variables that a table may depend on: as many as fit behind its other columns on a line of eight.
const MOST_DEPENDENCIES: usize = 5;

impl Builder<'_> {
    /// `*FIELD`: a value without amplitude is there at once (ABAQUS Analysis User's Guide 34.6.1, "Predefined fields", and
    /// 34.1.2, "Amplitude curves").
    pub(super) fn prescribed_fields(&mut self, card: &Card) {
        if self.step.is_none() {
            self.outside_step(card);
            return;
        }
        let Ok(amplitude) = self.amplitude_of(card) else { return };
        if self.step.as_ref().is_some_and(|s| s.ramp) && amplitude.is_none() {
            self.unsupported(card.span, "*STEP, AMPLITUDE=RAMP with *FIELD is not supported", "give AMPLITUDE=");
            return;
        }
        let Some(variable) = self.numbered_field(card) else { return };
        if self.operation(card, "FIELD") {
            self.state().history.fields.clear();
        }
        for line in &card.lines {
            let Some(set) = line.field(0) else { continue };
            let Some(value) = self.number(line, 1, "the value of the field") else { continue };
            let Some(nodes) = self.node_members(set) else { continue };
            let value = self.scaled(value, amplitude);
            let (set, span) = (set.text.clone(), line.span);
            self.state().fields.push(PrescribedField { variable, nodes, set, value, amplitude, span });
        }
    }

    /// VARIABLE, counted from 0; the first without it.
    pub(super) fn numbered_field(&mut self, card: &Card) -> Option<usize> {
        let Some(word) = card.value("VARIABLE") else { return Some(0) };
        let number = word.integer(&mut self.diagnostics)?;
        let variable = usize::try_from(number).ok().filter(|n| (1..=MOST_FIELDS).contains(n));
        if variable.is_none() {
            self.out_of_range(word.span, format!("VARIABLE={number} must lie between 1 and {MOST_FIELDS}"));
        }
        variable.map(|n| n - 1)
    }

    /// DEPENDENCIES: how many field variables a table depends on, from the first on (ABAQUS Analysis User's Guide 21.1.2,
    /// "Material data definition").
    pub(super) fn dependencies(&mut self, card: &Card) -> Option<usize> {
        let Some(word) = card.value("DEPENDENCIES") else { return Some(0) };
        let number = word.integer(&mut self.diagnostics)?;
        let count = usize::try_from(number).ok().filter(|n| *n <= MOST_DEPENDENCIES);
        if count.is_none() {
            let message = format!("DEPENDENCIES={number} must lie between 0 and {MOST_DEPENDENCIES}");
            self.out_of_range(word.span, message);
        }
        count
    }

    /// Rows of some values, the temperature and so many field variables. Where no row has a temperature it is 0 in all.
    pub(super) fn rows_over_fields(&mut self, card: &Card, values: usize, fields: usize) -> Option<Vec<Vec<f64>>> {
        let first = self.first_line(card)?;
        let row = |builder: &mut Self, line: &DataLine| -> Option<Vec<f64>> {
            let default = |i: usize| if i == values { f64::NAN } else { 0.0 };
            (0..values + 1 + fields).map(|i| builder.number_or(line, i, default(i))).collect()
        };
        let mut rows: Vec<Vec<f64>> = card.lines.iter().map(|line| row(self, line)).collect::<Option<_>>()?;
        let cold = rows.iter().filter(|r| r[values].is_nan()).count();
        if cold != 0 && cold != rows.len() {
            self.out_of_range(first.span, "either all rows of a table have a temperature, or none");
            return None;
        }
        rows.iter_mut().filter(|r| r[values].is_nan()).for_each(|r| r[values] = 0.0);
        Some(rows)
    }
}

impl History {
    /// Fields in force in a step that gives these; what follows from them is remembered for the next. A field that no step
    /// in force gives is what it was at the start.
    pub fn fields(&mut self, given: Vec<PrescribedField>, step: &StepTime, model: &Model) -> Vec<PrescribedField> {
        let mut all = std::mem::take(&mut self.fields);
        for later in given {
            for earlier in all.iter_mut().filter(|e| e.variable == later.variable) {
                earlier.nodes.retain(|n| later.nodes.binary_search(n).is_err());
            }
            all.push(later);
        }
        all.retain(|field| !field.nodes.is_empty());
        let settled = |field: &PrescribedField| {
            let mut settled = field.clone();
            if let Some(factor) = self.stays(field.amplitude, step, model) {
                (settled.value, settled.amplitude) = (field.value * factor, None);
            }
            settled
        };
        self.fields = all.iter().map(settled).collect();
        all
    }
}
