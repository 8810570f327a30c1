//! `*EROSION`.
//! Never here: when an element has come to a criterion.

use super::builder::Builder;
use super::types::Erosion;
use crate::deck::Card;

/// Scaled Jacobian without a value: an element that comes to it folds within a few increments. A triangle folds with its last
/// volume, to which its increments shorten without end.
const ALMOST_FOLDED: f64 = 0.01;

impl Builder<'_> {
    /// Elements that are deleted by more than their material.
    pub(super) fn erosion(&mut self, card: &Card) {
        let elements = match card.value("ELSET") {
            Some(word) => match self.element_members(word) {
                Some(members) => Some(members),
                None => return,
            },
            None => None,
        };
        let Some(distortion) = self.least_jacobian(card) else { return };
        let limits = ["PLASTIC STRAIN", "PRINCIPAL STRAIN", "INCREMENT"].map(|name| self.above_zero(card, name));
        let [Some(plastic), Some(strain), Some(increment)] = limits else { return };
        if [distortion, plastic, strain, increment].iter().all(Option::is_none) {
            self.out_of_range(card.span, "*EROSION needs DISTORTION, PLASTIC STRAIN, PRINCIPAL STRAIN or INCREMENT");
            return;
        }
        self.model.erosions.push(Erosion { span: card.span, elements, distortion, plastic, strain, increment });
    }

    /// DISTORTION, from 0 on and below 1; without a value [`ALMOST_FOLDED`]. `Some(None)` where it is not given.
    fn least_jacobian(&mut self, card: &Card) -> Option<Option<f64>> {
        let Some(word) = card.value("DISTORTION") else {
            return Some(card.has("DISTORTION").then_some(ALMOST_FOLDED));
        };
        let value = word.number(&mut self.diagnostics)?;
        if (0.0..1.0).contains(&value) {
            return Some(Some(value));
        }
        self.out_of_range(word.span, format!("DISTORTION must be from 0 on and below 1, not {value}"));
        None
    }
}
