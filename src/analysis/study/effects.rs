//! Ablation study: each effect is removed in turn, and the change of the quantity and of the run time is reported.

use serde::Serialize;

use super::StudyError;
use super::ablation::{self, ReducedModel};
use super::quantity::QuantityValue;
use super::refinement::{self, RefinementStudy};
use super::runner::{StudyRun, StudyRunner, TimeSpread};
use super::settings::{ModelEdit, StudyAxis, StudyParameter};
use super::table::{TextTable, cell, digits, duration, short};
use crate::model::Model;

/// Result of removing one effect.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct AblatedEffect {
    /// Name of the effect in the ledger.
    pub effect: String,
    /// Description of the replacement.
    pub instead: &'static str,
    /// The quantity without the effect; `None` if the run failed.
    pub value: Option<f64>,
    /// Error of the run without the effect.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
    /// Quantity without the effect minus quantity with it.
    pub change: Option<f64>,
    /// Change divided by the size of the quantity; `None` if the quantity is zero.
    pub relative_change: Option<f64>,
    /// Run time without the effect divided by run time with it.
    pub time_ratio: Option<f64>,
    /// Element-cycles without the effect divided by element-cycles with it.
    pub cycle_ratio: Option<f64>,
    /// Whether the change exceeds the error estimate; true if the run without the effect failed.
    pub matters: bool,
}

/// Results for all effects of a deck.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EffectAblation {
    /// The quantity with all effects.
    pub value: f64,
    /// Error estimate of the quantity.
    pub error: f64,
    /// Refined parameters and levels of the error estimate.
    pub refined: String,
    /// Run time with all effects, in seconds.
    pub seconds: TimeSpread,
    /// One entry per effect that can be removed.
    pub effects: Vec<AblatedEffect>,
}

/// Returns the default refinement of the error estimate: the time increment.
pub fn default_axes() -> Result<Vec<StudyAxis>, StudyError> {
    super::settings::axes(&["increment=1,0.5".to_owned()], &[])
}

/// Removes each effect of `model` in turn, at the finest level of all refinements except that of the increment.
pub fn leave_out(bench: &mut StudyRunner<'_>, axes: &[StudyAxis], model: &Model) -> Result<EffectAblation, StudyError> {
    let none = |why: &str| StudyError::Comparison(why.into());
    let study = refinement::grid(bench, axes, None)?;
    let row = base(&study, axes).ok_or_else(|| none("the study has no row"))?;
    let with = study.rows[row].run.clone()?;
    let QuantityValue::Number(value) = with.found else {
        return Err(none("an ablation study needs a number as quantity, not a field"));
    };
    let error = study.rows[row].bound;
    let error = error.ok_or_else(|| none("no error can be estimated: give two or more levels"))?;
    let values = study.rows[row].values.clone();
    let mut effects = Vec::new();
    for ReducedModel { name, instead, edit } in ablation::omissions(model) {
        let change: ModelEdit = Box::new(move |model| {
            edit(model);
            Ok(())
        });
        let run = bench.at(axes, &values, Some(change));
        effects.push(effect(name, instead, run, &with, [value, error]));
    }
    let refined = axes.iter().map(|a| format!("{} = {}", a.name, a.values.join(", "))).collect::<Vec<_>>().join("; ");
    Ok(EffectAblation { value, error, refined, seconds: with.seconds, effects })
}

/// Returns the row that effects are removed from: the finest levels, with the increment of the deck.
fn base(study: &RefinementStudy, axes: &[StudyAxis]) -> Option<usize> {
    let base_value = |a: &StudyAxis| match a.parameter {
        StudyParameter::Increment => a.values.iter().find(|v| v.parse() == Ok(1.0)).or(a.values.last()).cloned(),
        _ if a.is_refinement() => a.values.last().cloned(),
        _ => a.values.first().cloned(),
    };
    let values: Vec<String> = axes.iter().filter_map(base_value).collect();
    study.rows.iter().position(|r| r.values == values)
}

fn effect(
    effect: String,
    instead: &'static str,
    run: Result<StudyRun, StudyError>,
    with: &StudyRun,
    [value, error]: [f64; 2],
) -> AblatedEffect {
    let mut ablated = AblatedEffect { effect, instead, matters: true, ..AblatedEffect::default() };
    match run {
        Err(reason) => ablated.failure = Some(reason.to_string()),
        Ok(run) => {
            if let QuantityValue::Number(without) = run.found {
                let change = without - value;
                (ablated.value, ablated.change) = (Some(without), Some(change));
                ablated.relative_change = (value != 0.0).then(|| change / value.abs());
                ablated.matters = change.abs() > error;
            }
            ablated.time_ratio = Some(run.loop_seconds.median / with.loop_seconds.median);
            ablated.cycle_ratio = Some(run.element_cycles() / with.element_cycles());
        }
    }
    ablated
}

impl EffectAblation {
    /// Returns the table with few digits or with all digits.
    pub fn table(&self, all_digits: bool) -> TextTable {
        let header = ["left out", "instead", "value", "change", "change %", "time x", "cycles x", "verdict"];
        let rows = self.effects.iter().map(|e| e.cells(all_digits)).collect();
        TextTable { header: header.map(String::from).to_vec(), rows }
    }

    /// Returns the lines below the table.
    pub fn conclusions(&self) -> Vec<String> {
        let mut lines = vec![format!(
            "with all effects: {} in {}, error estimate {} (from {})",
            digits(self.value, 7),
            duration(self.seconds.median),
            short(self.error),
            self.refined
        )];
        let (matter, idle): (Vec<&AblatedEffect>, Vec<&AblatedEffect>) = self.effects.iter().partition(|e| e.matters);
        let names = |list: &[&AblatedEffect]| list.iter().map(|e| e.effect.as_str()).collect::<Vec<_>>().join(", ");
        if !matter.is_empty() {
            lines.push(format!("effects that matter: {}", names(&matter)));
        }
        lines.extend(idle.iter().map(|e| e.warning()));
        if self.effects.is_empty() {
            lines.push("the deck has no effect that can be removed".into());
        }
        lines
    }
}

impl AblatedEffect {
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

    /// Returns the warning on an effect that does not change the quantity.
    fn warning(&self) -> String {
        let saved = self.time_ratio.map_or(0.0, |r| 100.0 * (1.0 - r));
        let pays = if saved >= 2.0 {
            format!("; without it the time loop is {saved:.0} % shorter")
        } else {
            "; its run time is negligible".into()
        };
        format!("warning: {} changes the quantity by less than the error estimate{pays}", self.effect)
    }
}
