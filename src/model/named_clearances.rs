//! Clearances of general contact by name: `*CONTACT CLEARANCE` and `*CONTACT INITIALIZATION DATA`.
//! Never here: which surfaces they are assigned to.

use indexmap::IndexMap;

use super::types::Clearance;
use crate::deck::Deck;
use crate::deck::read::ReadCard;
use crate::deck::table::constraints as cards;

/// The clearances of general contact by name, which assignments anywhere in the deck may refer to (ABAQUS Keywords Reference Guide,
/// *CONTACT CLEARANCE and *CONTACT INITIALIZATION DATA).
pub(super) fn named_clearances(deck: &Deck) -> IndexMap<String, Clearance> {
    let mut named = IndexMap::new();
    for card in &deck.cards {
        let (name, clearance) = match card.keyword.name {
            "CONTACT CLEARANCE" => {
                let cards::ContactClearance { name, gap, above, below } = ReadCard::read(card);
                (name, Clearance { gap, above, below })
            }
            "CONTACT INITIALIZATION DATA" => {
                let cards::ContactInitializationData { name, gap, above, below } = ReadCard::read(card);
                // Without a clearance overlaps alone are resolved.
                let above = above.or(gap.is_none().then_some(0.0));
                (name, Clearance { gap: gap.unwrap_or(0.0), above, below })
            }
            _ => continue,
        };
        named.entry(name).or_insert(clearance);
    }
    named
}
