//! `*CONTACT CONTROLS` of contact pairs, `*CONTACT CONTROLS ASSIGNMENT` of general contact.
//! Never here: which surfaces there are, what contact does.

use super::builder::Builder;
use crate::deck::Card;

impl Builder<'_> {
    /// ABAQUS Keywords Reference Guide, *CONTACT CONTROLS: a factor on the stiffness of the penalty springs of a set of pairs.
    pub(super) fn contact_controls(&mut self, card: &Card) {
        let Some(set) = self.required(card, "CPSET").cloned() else { return };
        let Some(factor) = self.above_zero(card, "SCALE PENALTY") else { return };
        let factors = &mut self.state().penalty_factors;
        if card.has("RESET") {
            factors.push((set.clone(), 1.0));
        }
        factors.extend(factor.map(|f| (set, f)));
    }
}
