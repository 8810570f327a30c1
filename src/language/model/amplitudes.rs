//! `*AMPLITUDE`. The kernel evaluates amplitudes.

use super::context::Context;
use super::faults::{ValueCheck, require};
use super::names::upper;
use super::types::{Amplitude, AmplitudeDefinition, AmplitudeId};
use crate::deck::Card;
use crate::deck::table::steps as cards;

/// Indices of the values of `DEFINITION` in the keyword table.
const SMOOTH_STEP: usize = 1;
const EQUALLY_SPACED: usize = 2;
const USER: usize = 3;

pub fn read_amplitude(context: &mut Context<'_>, card: &Card) {
    let amplitude: cards::Amplitude = card.values();
    let Some(definition) = amplitude_definition(context, card, &amplitude) else { return };
    let (name, absolute) = (amplitude.name, amplitude.absolute);
    context.names.amplitudes.entry(name.clone()).or_insert(context.model.amplitudes.len());
    context.model.amplitudes.push(Amplitude { name, definition, absolute, span: card.span });
}

fn amplitude_definition(
    context: &mut Context<'_>,
    card: &Card,
    amplitude: &cards::Amplitude,
) -> Option<AmplitudeDefinition> {
    let values = &amplitude.values;
    let mut points: Vec<[f64; 2]> = match amplitude.definition {
        USER => return user_amplitude(context, card, amplitude),
        EQUALLY_SPACED => {
            let Some(interval) = amplitude.interval else {
                return context.refuse_value(card.span, "DEFINITION=EQUALLY SPACED requires FIXED INTERVAL=");
            };
            values.iter().enumerate().map(|(i, v)| [amplitude.begin + i as f64 * interval, *v]).collect()
        }
        _ => values.as_chunks::<2>().0.to_vec(),
    };
    if amplitude.definition != EQUALLY_SPACED && values.len() % 2 == 1 {
        context.out_of_range(card.span, format!("expected pairs of time and value, found {} numbers", values.len()));
    }
    let (scale, shift) = ([amplitude.scale_time, amplitude.scale], [amplitude.shift_time, amplitude.shift]);
    points.iter_mut().for_each(|p| *p = [0, 1].map(|i: usize| p[i] * scale[i] + shift[i]));
    let (smooth, total_time) = (amplitude.definition == SMOOTH_STEP, amplitude.total_time);
    let definition = AmplitudeDefinition::Curve { points, smooth, total_time };
    context.accepts(card, definition.check()).then_some(definition)
}

impl AmplitudeDefinition {
    /// Checks the points of a curve.
    pub fn check(&self) -> ValueCheck {
        let AmplitudeDefinition::Curve { points, .. } = self else { return Ok(()) };
        let ascends = !points.is_empty() && points.windows(2).all(|w| w[0][0] < w[1][0]);
        require(ascends, "the times of an amplitude must ascend")?;
        require(points.iter().flatten().all(|x| x.is_finite()), "times and values of an amplitude must be finite")
    }
}

/// Returns the definition of a user amplitude: properties and number of state variables (`DEFINITION=USER`).
fn user_amplitude(context: &mut Context<'_>, card: &Card, amplitude: &cards::Amplitude) -> Option<AmplitudeDefinition> {
    let (expected, properties) = (amplitude.properties.unwrap_or(0), amplitude.values.clone());
    if expected != properties.len() {
        let message = format!("PROPERTIES={expected}, but the data lines have {} values", properties.len());
        return context.refuse_value(card.span, message);
    }
    Some(AmplitudeDefinition::User { properties, variables: amplitude.variables })
}

/// Returns the magnitude to which an amplitude is applied: 1 for an amplitude of absolute values.
pub fn scaled(context: &Context<'_>, magnitude: f64, amplitude: Option<AmplitudeId>) -> f64 {
    if amplitude.is_some_and(|i| context.model.amplitudes[i].absolute) { 1.0 } else { magnitude }
}

/// Returns the amplitude that a parameter of a card names; `Err` if the name is unknown, which is reported.
pub fn amplitude_of(context: &mut Context<'_>, card: &Card, name: &str) -> Result<Option<AmplitudeId>, ()> {
    let Some(word) = card.value(name) else { return Ok(None) };
    let index = context.names.amplitudes.get(&upper(&word.text)).copied();
    if index.is_none() {
        context.unknown("M112", "amplitude", word, |b| b.model.amplitudes.iter().map(|a| a.name.clone()).collect());
    }
    index.map(|index| Some(AmplitudeId::new(index))).ok_or(())
}
