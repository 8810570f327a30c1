//! Reads `*HEADING` and `*UNITS`: title of the analysis and names of the units.

use super::context::Context;
use super::units::DeckUnits;
use crate::deck::{Card, Diagnostic};

/// Appends the data lines of `*HEADING` to the title.
pub fn read_heading(context: &mut Context<'_>, card: &Card) {
    for word in card.lines.iter().filter_map(|l| l.fields.first()) {
        let gap = if context.model.settings.title.is_empty() { "" } else { "\n" };
        context.model.settings.title += &format!("{gap}{}", word.text);
    }
}

/// Reads the names of length, mass, time and temperature; the temperature is K by default.
pub fn read_units(context: &mut Context<'_>, card: &Card) {
    let Some(line) = context.first_line(card) else { return };
    let word = |i: usize| line.fields.get(i).map(|w| w.text.trim().to_owned()).filter(|w| !w.is_empty());
    let (Some(length), Some(mass), Some(time)) = (word(0), word(1), word(2)) else {
        let diagnostic =
            Diagnostic::error("M107", "*UNITS requires length, mass and time").at(line.span, "one is missing");
        return context.diagnostics.push(diagnostic.help("for example `m, kg, s` or `mm, t, s`"));
    };
    let temperature = word(3).unwrap_or_else(|| "K".into());
    context.model.settings.units = Some(DeckUnits { length, mass, time, temperature });
}
