//! `*ENERGY LIMIT`.
//! Never here: what a run does where a limit is passed.

use super::builder::Builder;
use super::types::EnergyLimit;
use crate::deck::Card;
use crate::deck::table::steps as cards;

impl Builder<'_> {
    /// A step goes on with the limits of the step before until it gives its own.
    pub(super) fn energy_limit(&mut self, card: &Card) {
        let cards::EnergyLimit { error, artificial, halts } = self.values(card);
        if error.is_none() && artificial.is_none() {
            return self.out_of_range(card.span, "*ENERGY LIMIT needs ERROR or ARTIFICIAL");
        }
        self.state().energy_limit = Some(EnergyLimit { span: card.span, error, artificial, halts });
    }
}
