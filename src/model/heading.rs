//! What a deck says of itself: `*HEADING`, `*UNITS`.
//! Never here: what changes a result.

use super::builder::Builder;
use super::units::Units;
use crate::deck::{Card, Diagnostic};

impl Builder<'_> {
    /// `*HEADING`: its lines one below the other.
    pub(super) fn heading(&mut self, card: &Card) {
        for word in card.lines.iter().filter_map(|l| l.fields.first()) {
            let gap = if self.model.settings.title.is_empty() { "" } else { "\n" };
            self.model.settings.title += &format!("{gap}{}", word.text);
        }
    }

    /// `*UNITS`: names of length, mass, time and, if it is not K, temperature.
    pub(super) fn units(&mut self, card: &Card) {
        let Some(line) = self.first_line(card) else { return };
        let word = |i: usize| line.fields.get(i).map(|w| w.text.trim().to_owned()).filter(|w| !w.is_empty());
        let (Some(length), Some(mass), Some(time)) = (word(0), word(1), word(2)) else {
            let finding =
                Diagnostic::error("M107", "*UNITS names length, mass and time").at(line.span, "one is missing");
            return self.diagnostics.push(finding.help("as in `m, kg, s` or `mm, t, s`"));
        };
        let temperature = word(3).unwrap_or_else(|| "K".into());
        self.model.settings.units = Some(Units { length, mass, time, temperature });
    }
}
