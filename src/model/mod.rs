//! From syntax tree to model: names resolved, parts and instances flattened, values checked.
//! Never here: arrays for solving.

pub mod types;

pub use types::*;

use crate::deck::{Deck, Diagnostics};

/// Resolves a deck. Always returns a model; it may be run only where the diagnostics hold no error.
pub fn build(deck: &Deck) -> (Model, Diagnostics) {
    let _ = deck;
    todo!("the model room")
}
