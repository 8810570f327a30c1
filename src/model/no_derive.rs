//! Replaces `derive` in builds without the feature `resistance`.

use super::builder::ModelBuilder;
use crate::deck::Card;
use crate::deck::table::materials::CavityExpansion;

impl ModelBuilder<'_> {
    /// Reports that the card is not supported.
    pub(super) fn derivation(&mut self, card: &Card, _: &CavityExpansion) {
        let message = "DERIVE is not available in this build: the feature `resistance` is off";
        self.unsupported(card.span, message, "run `revolve resistance` of a full build, which prints the card");
    }
}
