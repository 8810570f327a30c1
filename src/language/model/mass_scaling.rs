//! Reads mass scaling: `*FIXED MASS SCALING` and `*VARIABLE MASS SCALING`.

use super::context::Context;
use super::families::StepReader;
use super::types::{MassScaling, ScalingSchedule, ScalingType};
use crate::deck::Card;
use crate::deck::table::steps as cards;

/// Reads mass scaling. The first card of a step replaces the mass scaling of earlier steps, which otherwise
/// continues.
pub fn read_mass_scaling(context: &mut Context<'_>, steps: &mut StepReader, card: &Card) {
    let Some(request) = scaling_request(context, card) else { return };
    if steps.clear_once("MASS SCALING") {
        steps.state().mass_scalings.clear();
    }
    steps.state().mass_scalings.push(request);
}

fn scaling_request(context: &mut Context<'_>, card: &Card) -> Option<MassScaling> {
    let elements = context.optional(card.value("ELSET"), Context::element_members)?;
    let ((factor, dt, kind, budget), rhythm) = if card.keyword.name == "FIXED MASS SCALING" {
        let cards::FixedMassScaling { factor, dt, kind, budget } = card.values();
        ((factor, dt, kind, budget), None)
    } else {
        let cards::VariableMassScaling { dt, kind, frequency, intervals, budget } = card.values();
        let rhythm = match (frequency, intervals) {
            (Some(count), None) => ScalingSchedule::Increments(count as u64),
            (None, Some(count)) => ScalingSchedule::Intervals(count as u64),
            _ => {
                let message = "*VARIABLE MASS SCALING requires either FREQUENCY or NUMBER INTERVAL";
                return context.refuse_value(card.span, message);
            }
        };
        ((None, dt, kind, budget), Some(rhythm))
    };
    if factor.is_none() && dt.is_none() {
        let needs = if rhythm.is_none() { "FACTOR or DT" } else { "DT" };
        return context.refuse_value(card.span, format!("*{} requires {needs}", card.keyword.name));
    }
    if dt.is_none() && card.has("TYPE") {
        return context.refuse_value(card.span, "TYPE requires DT");
    }
    let kind = [ScalingType::BelowMin, ScalingType::Uniform, ScalingType::SetEqual][kind];
    let target = dt.map(|dt| (kind, dt));
    if budget.is_some() && target.is_none_or(|(kind, _)| kind != ScalingType::BelowMin) {
        return context.refuse_value(card.span, "BUDGET requires DT and TYPE=BELOW MIN");
    }
    Some(MassScaling { span: card.span, elements, factor: factor.unwrap_or(1.0), target, budget, schedule: rhythm })
}
