//! Passes over the cards of a deck whose mesh is refined.

use crate::deck::Card;

/// Cards that a pass over the deck reads. A refined mesh needs two passes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ReadPass {
    /// All cards.
    #[default]
    All,
    /// Cards that define nodes, elements and their sets.
    Mesh,
    /// All other cards.
    Rest,
}

impl ReadPass {
    /// Returns whether the pass reads a card. Parts and instances are blocks of both kinds of cards.
    pub fn reads(self, card: &Card) -> bool {
        let is_block = matches!(
            card.keyword.name,
            "PART" | "END PART" | "ASSEMBLY" | "END ASSEMBLY" | "INSTANCE" | "END INSTANCE"
        );
        match self {
            ReadPass::All => true,
            ReadPass::Mesh => is_block || defines_mesh(card),
            ReadPass::Rest => !defines_mesh(card),
        }
    }
}

/// Keywords of the cards that define nodes, elements or their sets.
const MESH_CARDS: [&str; 12] =
    ["NODE", "NGEN", "NFILL", "NCOPY", "NMAP", "SYSTEM", "ELEMENT", "ELGEN", "ELCOPY", "NSET", "ELSET", "MESH"];

/// Returns whether a card defines nodes, elements or their sets.
pub fn defines_mesh(card: &Card) -> bool {
    MESH_CARDS.contains(&card.keyword.name)
}
