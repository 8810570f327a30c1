//! `*CONTACT CONTROLS` of contact pairs.

use super::context::Context;
use super::families::StepReader;
use crate::deck::Card;
use crate::deck::table::constraints as cards;

/// Records the penalty scale factor of a contact pair set (ABAQUS Keywords Reference Guide, *CONTACT CONTROLS).
pub fn read_contact_controls(context: &mut Context<'_>, steps: &mut StepReader, card: &Card) {
    let Some(set) = context.required(card, "CPSET").cloned() else { return };
    let cards::ContactControls { penalty, reset } = card.values();
    let factors = &mut steps.state().penalty_factors;
    if reset {
        factors.push((set.clone(), 1.0));
    }
    factors.extend(penalty.map(|f| (set, f)));
}
