//! Reads `*EROSION`: criteria for the deletion of elements.

use super::context::Context;
use super::types::ErosionCriteria;
use crate::deck::Card;
use crate::deck::table::materials as cards;

/// Reads erosion criteria, which delete elements independently of their material.
pub(super) fn read_erosion(context: &mut Context<'_>, card: &Card) {
    let elements = match card.value("ELSET") {
        Some(word) => match context.element_members(word) {
            Some(members) => Some(members),
            None => return,
        },
        None => None,
    };
    let cards::Erosion { distortion, plastic, strain, increment } = card.values();
    if [distortion, plastic, strain, increment].iter().all(Option::is_none) {
        return context
            .out_of_range(card.span, "*EROSION requires DISTORTION, PLASTIC STRAIN, PRINCIPAL STRAIN or INCREMENT");
    }
    context.model.erosions.push(ErosionCriteria { span: card.span, elements, distortion, plastic, strain, increment });
}
