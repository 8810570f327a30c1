//! Named initial clearances of general contact: `*CONTACT CLEARANCE` and `*CONTACT INITIALIZATION DATA`.

use indexmap::IndexMap;

use super::types::PrescribedClearance;
use crate::deck::Deck;
use crate::deck::read::ReadCard;
use crate::deck::table::constraints as cards;

/// Returns the clearances by name; assignments anywhere in the deck may refer to them (ABAQUS Keywords Reference
/// Guide).
pub(super) fn named_clearances(deck: &Deck) -> IndexMap<String, PrescribedClearance> {
    let mut named = IndexMap::new();
    for card in &deck.cards {
        let (name, clearance) = match card.keyword.name {
            "CONTACT CLEARANCE" => {
                let cards::ContactClearance { name, gap, above, below } = ReadCard::read(card);
                (name, PrescribedClearance { gap, above, below })
            }
            "CONTACT INITIALIZATION DATA" => {
                let cards::ContactInitializationData { name, gap, above, below } = ReadCard::read(card);
                // Without a clearance only overclosures are resolved.
                let above = above.or(gap.is_none().then_some(0.0));
                (name, PrescribedClearance { gap: gap.unwrap_or(0.0), above, below })
            }
            _ => continue,
        };
        named.entry(name).or_insert(clearance);
    }
    named
}
