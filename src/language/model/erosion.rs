//! Reads `*EROSION`: criteria for the deletion of elements.

use super::builder::ModelBuilder;
use super::types::ErosionCriteria;
use crate::deck::Card;
use crate::deck::table::materials as cards;

impl ModelBuilder<'_> {
    /// Reads erosion criteria, which delete elements independently of their material.
    pub(super) fn erosion(&mut self, card: &Card) {
        let elements = match card.value("ELSET") {
            Some(word) => match self.element_members(word) {
                Some(members) => Some(members),
                None => return,
            },
            None => None,
        };
        let cards::Erosion { distortion, plastic, strain, increment } = self.values(card);
        if [distortion, plastic, strain, increment].iter().all(Option::is_none) {
            return self.out_of_range(
                card.span,
                "*EROSION requires DISTORTION, PLASTIC STRAIN, PRINCIPAL STRAIN or INCREMENT",
            );
        }
        self.model.erosions.push(ErosionCriteria { span: card.span, elements, distortion, plastic, strain, increment });
    }
}
