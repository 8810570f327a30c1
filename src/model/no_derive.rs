//! In the place of `derive` where the library is built without the feature `resistance`.

use super::builder::Builder;
use crate::deck::Card;
use crate::deck::table::materials::CavityExpansion;

impl Builder<'_> {
    /// Refuses the card.
    pub(super) fn derivation(&mut self, card: &Card, _: &CavityExpansion) {
        let message = "DERIVE is not in this build: the library's feature `resistance` is off";
        self.unsupported(card.span, message, "`revolve resistance` of a full build prints the card");
    }
}
