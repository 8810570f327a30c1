//! Reads `*ENERGY LIMIT`: limits of the energy balance for warnings and halts.

use super::context::Context;
use super::families::StepReader;
use super::types::EnergyLimit;
use crate::deck::Card;
use crate::deck::table::steps as cards;

/// Sets the energy limits, which remain in force until a later step sets others.
pub fn read_energy_limit(context: &mut Context<'_>, steps: &mut StepReader, card: &Card) {
    let cards::EnergyLimit { error, artificial, halts } = card.values();
    if error.is_none() && artificial.is_none() {
        return context.out_of_range(card.span, "*ENERGY LIMIT requires ERROR or ARTIFICIAL");
    }
    steps.state().energy_limit = Some(EnergyLimit { span: card.span, error, artificial, halts });
}
