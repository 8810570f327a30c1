//! `*CONTACT CONTROLS` of contact pairs.

use super::builder::ModelBuilder;
use crate::deck::Card;
use crate::deck::table::constraints as cards;

impl ModelBuilder<'_> {
    /// Records the penalty scale factor of a contact pair set (ABAQUS Keywords Reference Guide, *CONTACT CONTROLS).
    pub(super) fn contact_controls(&mut self, card: &Card) {
        let Some(set) = self.required(card, "CPSET").cloned() else { return };
        let cards::ContactControls { penalty, reset } = self.values(card);
        let factors = &mut self.state().penalty_factors;
        if reset {
            factors.push((set.clone(), 1.0));
        }
        factors.extend(penalty.map(|f| (set, f)));
    }
}
