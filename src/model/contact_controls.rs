//! `*CONTACT CONTROLS` of contact pairs, `*CONTACT CONTROLS ASSIGNMENT` of general contact.
//! Never here: which surfaces there are, what contact does.

use super::builder::Builder;
use crate::deck::Card;
use crate::deck::table::constraints as cards;

impl Builder<'_> {
    /// ABAQUS Keywords Reference Guide, *CONTACT CONTROLS: a factor on the stiffness of the penalty springs of a set of pairs.
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
