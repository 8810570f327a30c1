//! Materials of the user: `*USER MATERIAL` and `*DEPVAR`.
//! Never here: the routine.

use super::builder::Builder;
use super::types::StateVariables;
use crate::deck::Card;

impl Builder<'_> {
    /// `*USER MATERIAL, CONSTANTS=n`: eight constants a line; an empty field is zero.
    pub(super) fn user_material(&mut self, card: &Card) {
        let Some(word) = self.required(card, "CONSTANTS") else { return };
        let Some(wanted) = word.integer(&mut self.diagnostics) else { return };
        let mut constants = Vec::new();
        for line in &card.lines {
            let filled = line.fields.iter().rposition(|w| !w.text.is_empty()).map_or(0, |last| last + 1);
            for i in 0..filled {
                let Some(value) = self.number_or(line, i, 0.0) else { return };
                constants.push(value);
            }
        }
        if usize::try_from(wanted) != Ok(constants.len()) {
            let message = format!("CONSTANTS={wanted}, but {} constants follow", constants.len());
            self.out_of_range(card.span, message);
            return;
        }
        self.last_material().user = Some(constants);
    }

    /// `*DEPVAR`: number of variables; further lines describe them for people.
    pub(super) fn state_variables(&mut self, card: &Card) {
        if !self.deck.cards.iter().any(|c| c.keyword.name == "USER MATERIAL") {
            self.inert(card, "it serves *USER MATERIAL only".into());
            return;
        }
        let Some(line) = self.first_line(card) else { return };
        let Some(count) = self.integer(line, 0, "the number of state variables") else { return };
        let Some(count) = usize::try_from(count).ok().filter(|c| *c <= 10_000) else {
            self.out_of_range(
                line.span,
                format!("the number of state variables must lie between 0 and 10000, not {count}"),
            );
            return;
        };
        let mut delete = None;
        if let Some(word) = card.value("DELETE") {
            let Some(number) = word.integer(&mut self.diagnostics) else { return };
            delete = usize::try_from(number).ok().filter(|n| (1..=count).contains(n)).map(|n| n - 1);
            if delete.is_none() {
                self.out_of_range(word.span, format!("DELETE={number} is none of the {count} state variables"));
            }
        }
        self.last_material().state = StateVariables { count, delete };
    }
}
