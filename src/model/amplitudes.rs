//! `*AMPLITUDE`.
//! Never here: how it is evaluated.

use super::builder::Builder;
use super::names::upper;
use super::types::{Amplitude, AmplitudeDefinition, AmplitudeId};
use crate::deck::{Card, Word};

impl Builder<'_> {
    pub(super) fn amplitude(&mut self, card: &Card) {
        let Some(name) = self.required(card, "NAME") else { return };
        let definition = card.value("DEFINITION").map_or("TABULAR".into(), |w| upper(&w.text).replace(' ', ""));
        let mut values = Vec::new();
        for word in card.lines.iter().flat_map(|l| &l.fields).filter(|w| !w.text.is_empty()) {
            values.extend(word.number(&mut self.diagnostics));
        }
        let mut points: Vec<[f64; 2]> = match definition.as_str() {
            "USER" => {
                self.user_amplitude(card, upper(&name.text), values);
                return;
            }
            "TABULAR" | "SMOOTHSTEP" => values.chunks(2).filter(|p| p.len() == 2).map(|p| [p[0], p[1]]).collect(),
            "EQUALLYSPACED" => self.equally_spaced(card, &values),
            other => {
                let help = "TABULAR, SMOOTH STEP, EQUALLY SPACED and USER are";
                self.unsupported(card.span, format!("DEFINITION={other} is not supported"), help);
                return;
            }
        };
        if definition != "EQUALLYSPACED" && values.len() % 2 == 1 {
            self.out_of_range(card.span, format!("{} numbers are not pairs of time and value", values.len()));
        }
        let Some(()) = self.scale_and_shift(card, &mut points) else { return };
        if points.windows(2).any(|w| w[1][0] <= w[0][0]) || points.is_empty() {
            self.out_of_range(card.span, "an amplitude needs times that ascend");
            return;
        }
        let absolute = self.is_absolute(card);
        let total_time = card.value("TIME").is_some_and(|w| upper(&w.text).starts_with("TOTAL"));
        let smooth = definition == "SMOOTHSTEP";
        let definition = AmplitudeDefinition::Curve { points, smooth, total_time };
        self.model.amplitudes.push(Amplitude { name: upper(&name.text), definition, absolute, span: card.span });
    }

    /// `SCALEX`, `SCALEY`, `SHIFTX`, `SHIFTY`: x SCALE + SHIFT on times and values.
    fn scale_and_shift(&mut self, card: &Card, points: &mut [[f64; 2]]) -> Option<()> {
        for (i, (scale, shift)) in [("SCALEX", "SHIFTX"), ("SCALEY", "SHIFTY")].into_iter().enumerate() {
            let mut number =
                |name, default| card.value(name).map_or(Some(default), |w| w.number(&mut self.diagnostics));
            let (scale, shift) = (number(scale, 1.0)?, number(shift, 0.0)?);
            points.iter_mut().for_each(|p| p[i] = p[i] * scale + shift);
        }
        Some(())
    }

    /// `DEFINITION=USER`: constants for the routine, and how many variables it keeps.
    fn user_amplitude(&mut self, card: &Card, name: String, properties: Vec<f64>) {
        let mut count = |parameter| -> Option<Option<usize>> {
            let Some(word) = card.value(parameter) else { return Some(None) };
            Some(Some(word.integer(&mut self.diagnostics)?.max(0) as usize))
        };
        let (Some(expected), Some(variables)) = (count("PROPERTIES"), count("VARIABLES")) else { return };
        let expected = expected.unwrap_or(0);
        if expected != properties.len() {
            let message = format!("PROPERTIES={expected}, but {} constants are given", properties.len());
            self.out_of_range(card.span, message);
            return;
        }
        let definition = AmplitudeDefinition::User { properties, variables: variables.unwrap_or(0) };
        let absolute = self.is_absolute(card);
        self.model.amplitudes.push(Amplitude { name, definition, absolute, span: card.span });
    }

    /// `VALUE=ABSOLUTE`: the values on the data lines of loads and motions are ignored (ABAQUS Keywords Reference Guide,
    /// *AMPLITUDE).
    fn is_absolute(&mut self, card: &Card) -> bool {
        match card.value("VALUE") {
            None => false,
            Some(word) if word.is("RELATIVE") => false,
            Some(word) if word.is("ABSOLUTE") => true,
            Some(word) => {
                self.out_of_range(word.span, format!("VALUE is RELATIVE or ABSOLUTE, not {}", word.text));
                false
            }
        }
    }

    /// The magnitude that an amplitude scales: 1 where its values are magnitudes themselves.
    pub(super) fn scaled(&self, magnitude: f64, amplitude: Option<AmplitudeId>) -> f64 {
        if amplitude.is_some_and(|i| self.model.amplitudes[i].absolute) { 1.0 } else { magnitude }
    }

    fn equally_spaced(&mut self, card: &Card, values: &[f64]) -> Vec<[f64; 2]> {
        let number = |b: &mut Self, name: &str| card.value(name).and_then(|w| w.number(&mut b.diagnostics));
        let begin = number(self, "BEGIN").unwrap_or(0.0);
        let Some(interval) = number(self, "FIXED INTERVAL").filter(|i| *i > 0.0) else {
            self.out_of_range(card.span, "EQUALLY SPACED needs FIXED INTERVAL= above zero");
            return Vec::new();
        };
        values.iter().enumerate().map(|(i, v)| [begin + i as f64 * interval, *v]).collect()
    }

    /// The amplitude of a card; `Err` if it is named and unknown (reported).
    pub(super) fn amplitude_of(&mut self, card: &Card) -> Result<Option<AmplitudeId>, ()> {
        let Some(word) = card.value("AMPLITUDE") else { return Ok(None) };
        self.find_amplitude(word).map(Some).ok_or(())
    }

    /// The same of a film coefficient.
    pub(super) fn film_amplitude(&mut self, card: &Card) -> Result<Option<AmplitudeId>, ()> {
        let Some(word) = card.value("FILM AMPLITUDE") else { return Ok(None) };
        self.find_amplitude(word).map(Some).ok_or(())
    }

    fn find_amplitude(&mut self, word: &Word) -> Option<AmplitudeId> {
        let name = upper(&word.text);
        let found = self.model.amplitudes.iter().position(|a| a.name == name);
        if found.is_none() {
            self.unknown("M112", "amplitude", word, |b| b.model.amplitudes.iter().map(|a| a.name.clone()).collect());
        }
        found.map(AmplitudeId::new)
    }
}
