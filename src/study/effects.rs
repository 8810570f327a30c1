//! Each effect left out in turn: what it changes, what it costs.

use serde::Serialize;

use super::StudyError;
use super::ablation::{self, Omission};
use super::quantity::QuantityValue;
use super::refinement::{self, Study};
use super::runner::{StudyRun, StudyRunner, TimeSpread};
use super::settings::{Axis, ModelEdit, StudyParameter};
use super::table::{Table, cell, digits, duration, short};
use crate::model::Model;

/// One effect.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Effect {
    /// The effect, as the ledger calls it.
    pub effect: String,
    /// What took its place.
    pub instead: &'static str,
    /// The quantity without it; `None` where nothing came out.
    pub value: Option<f64>,
    /// Why nothing came out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
    /// Change by leaving it out.
    pub change: Option<f64>,
    /// The same over the quantity; `None` where that is zero.
    pub relative_change: Option<f64>,
    /// Time without it over time with it.
    pub time_ratio: Option<f64>,
    /// Element-cycles likewise.
    pub cycle_ratio: Option<f64>,
    /// Whether the change is above the error estimate; true where nothing came out without it.
    pub matters: bool,
}

/// All effects of a deck.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Effects {
    /// The quantity with all of them.
    pub value: f64,
    /// Its error by refinement.
    pub error: f64,
    /// What was refined for it.
    pub refined: String,
    /// Seconds with all of them.
    pub seconds: TimeSpread,
    /// One an effect that can be left out.
    pub effects: Vec<Effect>,
}

/// What is refined for the error where nothing is said: the increment, which every scene has.
pub fn default_axes() -> Result<Vec<Axis>, StudyError> {
    super::settings::axes(&["increment=1,0.5".to_owned()], &[])
}

/// Leaves out each effect of `model` in turn, at the finest level of all refinements except that of the increment.
pub fn leave_out(bench: &mut StudyRunner<'_>, axes: &[Axis], model: &Model) -> Result<Effects, StudyError> {
    let none = |why: &str| StudyError::Comparison(why.into());
    let study = refinement::grid(bench, axes, None)?;
    let row = base(&study, axes).ok_or_else(|| none("the study has no row"))?;
    let with = study.rows[row].run.clone()?;
    let QuantityValue::Number(value) = with.found else {
        return Err(none("effects are left out of a number, not of a field"));
    };
    let error = study.rows[row].bound;
    let error = error.ok_or_else(|| none("no error can be estimated: two levels or more are needed"))?;
    let values = study.rows[row].values.clone();
    let mut effects = Vec::new();
    for Omission { name, instead, edit } in ablation::omissions(model) {
        let change: ModelEdit = Box::new(move |model| {
            edit(model);
            Ok(())
        });
        let run = bench.at(axes, &values, Some(change));
        effects.push(effect(name, instead, run, &with, [value, error]));
    }
    let refined = axes.iter().map(|a| format!("{} = {}", a.name, a.values.join(", "))).collect::<Vec<_>>().join("; ");
    Ok(Effects { value, error, refined, seconds: with.seconds, effects })
}

/// The row that effects are left out of: the finest, but the deck's own increment.
fn base(study: &Study, axes: &[Axis]) -> Option<usize> {
    let wanted = |a: &Axis| match a.parameter {
        StudyParameter::Increment => a.values.iter().find(|v| v.parse() == Ok(1.0)).or(a.values.last()).cloned(),
        _ if a.is_refinement() => a.values.last().cloned(),
        _ => a.values.first().cloned(),
    };
    let values: Vec<String> = axes.iter().filter_map(wanted).collect();
    study.rows.iter().position(|r| r.values == values)
}

fn effect(
    effect: String,
    instead: &'static str,
    run: Result<StudyRun, StudyError>,
    with: &StudyRun,
    [value, error]: [f64; 2],
) -> Effect {
    let mut found = Effect { effect, instead, matters: true, ..Effect::default() };
    match run {
        Err(reason) => found.failure = Some(reason.to_string()),
        Ok(run) => {
            if let QuantityValue::Number(without) = run.found {
                let change = without - value;
                (found.value, found.change) = (Some(without), Some(change));
                found.relative_change = (value != 0.0).then(|| change / value.abs());
                found.matters = change.abs() > error;
            }
            found.time_ratio = Some(run.loop_seconds.median / with.loop_seconds.median);
            found.cycle_ratio = Some(run.element_cycles() / with.element_cycles());
        }
    }
    found
}

impl Effects {
    /// The table, in few digits or in all.
    pub fn table(&self, all_digits: bool) -> Table {
        let header = ["left out", "instead", "value", "change", "change %", "time x", "cycles x", "verdict"];
        let rows = self.effects.iter().map(|e| e.cells(all_digits)).collect();
        Table { header: header.map(String::from).to_vec(), rows }
    }

    /// What is said under the table, a line each.
    pub fn conclusions(&self) -> Vec<String> {
        let mut lines = vec![format!(
            "with all of them {} in {}, error estimate {} (refining {})",
            digits(self.value, 7),
            duration(self.seconds.median),
            short(self.error),
            self.refined
        )];
        let (matter, idle): (Vec<&Effect>, Vec<&Effect>) = self.effects.iter().partition(|e| e.matters);
        let names = |list: &[&Effect]| list.iter().map(|e| e.effect.as_str()).collect::<Vec<_>>().join(", ");
        if !matter.is_empty() {
            lines.push(format!("the scene calls for: {}", names(&matter)));
        }
        lines.extend(idle.iter().map(|e| e.warning()));
        if self.effects.is_empty() {
            lines.push("nothing of this deck can be left out".into());
        }
        lines
    }
}

impl Effect {
    fn cells(&self, all_digits: bool) -> Vec<String> {
        let number = |value: Option<f64>, few: usize| cell(value, few, all_digits);
        let verdict = match (&self.failure, self.matters) {
            (Some(_), _) => "no result without it",
            (None, true) => "matters",
            (None, false) => "below the error",
        };
        vec![
            self.effect.clone(),
            self.instead.into(),
            number(self.value, 7),
            number(self.change, 3),
            number(self.relative_change.map(|c| 100.0 * c), 3),
            number(self.time_ratio, 3),
            number(self.cycle_ratio, 3),
            verdict.into(),
        ]
    }

    /// That a deck pays for what changes nothing.
    fn warning(&self) -> String {
        let saved = self.time_ratio.map_or(0.0, |r| 100.0 * (1.0 - r));
        let pays = if saved >= 2.0 {
            format!("; without it the time loop takes {saved:.0} % less")
        } else {
            ", at no cost that shows".into()
        };
        format!("warning: {} changes nothing above the error estimate{pays}", self.effect)
    }
}
