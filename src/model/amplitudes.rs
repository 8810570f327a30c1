//! `*AMPLITUDE`.
//! Never here: how it is evaluated.

use super::builder::Builder;
use super::names::upper;
use super::types::Amplitude;
use crate::deck::{Card, Word};

impl Builder<'_> {
    pub(super) fn amplitude(&mut self, card: &Card) {
        let Some(name) = self.required(card, "NAME") else { return };
        self.refuse(card, &["SMOOTH", "VARIABLES"]);
        let definition = card.value("DEFINITION").map_or("TABULAR".into(), |w| upper(&w.text).replace(' ', ""));
        let mut values = Vec::new();
        for word in card.lines.iter().flat_map(|l| &l.fields).filter(|w| !w.text.is_empty()) {
            values.extend(word.number(&mut self.diagnostics));
        }
        let points = match definition.as_str() {
            "TABULAR" | "SMOOTHSTEP" => values.chunks(2).filter(|p| p.len() == 2).map(|p| [p[0], p[1]]).collect(),
            "EQUALLYSPACED" => self.equally_spaced(card, &values),
            other => {
                let help = "TABULAR, SMOOTH STEP and EQUALLY SPACED are";
                self.unsupported(card.span, format!("DEFINITION={other} is not supported"), help);
                return;
            }
        };
        if definition != "EQUALLYSPACED" && values.len() % 2 == 1 {
            self.out_of_range(card.span, format!("{} numbers are not pairs of time and value", values.len()));
        }
        if points.windows(2).any(|w| w[1][0] <= w[0][0]) || points.is_empty() {
            self.out_of_range(card.span, "an amplitude needs times that ascend");
            return;
        }
        let total_time = card.value("TIME").is_some_and(|w| upper(&w.text).starts_with("TOTAL"));
        let smooth = definition == "SMOOTHSTEP";
        self.model.amplitudes.push(Amplitude { name: upper(&name.text), points, smooth, total_time, span: card.span });
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

    /// Amplitude index by name; `Err` if it is named and unknown (reported).
    pub(super) fn amplitude_of(&mut self, card: &Card) -> Result<Option<usize>, ()> {
        let Some(word) = card.value("AMPLITUDE") else { return Ok(None) };
        self.find_amplitude(word).map(Some).ok_or(())
    }

    fn find_amplitude(&mut self, word: &Word) -> Option<usize> {
        let found = self.model.amplitudes.iter().position(|a| a.name == upper(&word.text));
        if found.is_none() {
            let names: Vec<String> = self.model.amplitudes.iter().map(|a| a.name.clone()).collect();
            self.unknown("M112", "amplitude", word, &names);
        }
        found
    }
}
