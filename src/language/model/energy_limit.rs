//! Reads `*ENERGY LIMIT`: limits of the energy balance for warnings and halts.

use super::builder::ModelBuilder;
use super::types::EnergyLimit;
use crate::deck::Card;
use crate::deck::table::steps as cards;

impl ModelBuilder<'_> {
    /// Sets the energy limits, which remain in force until a later step sets others.
    pub(super) fn energy_limit(&mut self, card: &Card) {
        let cards::EnergyLimit { error, artificial, halts } = self.values(card);
        if error.is_none() && artificial.is_none() {
            return self.out_of_range(card.span, "*ENERGY LIMIT requires ERROR or ARTIFICIAL");
        }
        self.state().energy_limit = Some(EnergyLimit { span: card.span, error, artificial, halts });
    }
}
