//! Reads `*EROSION`: criteria for the deletion of elements.

use super::context::Context;
use super::faults::{ValueCheck, require};
use super::types::ErosionCriteria;
use crate::deck::Card;
use crate::deck::table::materials as cards;

/// Reads erosion criteria, which delete elements independently of their material.
pub fn read_erosion(context: &mut Context<'_>, card: &Card) {
    let Some(elements) = context.optional(card.value("ELSET"), Context::element_members) else { return };
    let cards::Erosion { distortion, plastic, strain, increment } = card.values();
    let erosion = ErosionCriteria { span: card.span, elements, distortion, plastic, strain, increment };
    if context.accepts(card, erosion.check()) {
        context.model.erosions.push(erosion);
    }
}

impl ErosionCriteria {
    /// Checks that there is a limit.
    pub fn check(&self) -> ValueCheck {
        let is_limited = [self.distortion, self.plastic, self.strain, self.increment].iter().any(Option::is_some);
        require(is_limited, "*EROSION requires DISTORTION, PLASTIC STRAIN, PRINCIPAL STRAIN or INCREMENT")
    }
}
