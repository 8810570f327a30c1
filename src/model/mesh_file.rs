//! placeholder
use super::builder::Builder;
use crate::deck::Card;
impl Builder<'_> {
    pub(super) fn mesh_file(&mut self, card: &Card) {
        self.not_yet(card);
    }
}
