//! From syntax tree to model: names resolved, parts and instances flattened, values checked.
//! Never here: arrays for solving.

mod amplitudes;
mod bodies;
mod boundary;
mod builder;
mod check;
pub mod codes;
mod completion;
mod compose;
mod connectors;
mod consistency;
mod consistent_material;
mod contact;
mod controls;
mod degrees;
mod elements;
mod energy_limit;
mod eos;
mod equations;
mod failure;
mod history;
mod load_history;
mod loads;
mod mass_scaling;
mod materials;
pub(crate) mod mesh_file;
mod names;
mod nodes;
mod outputs;
mod parts;
mod rubber;
pub mod scene;
mod sets;
mod steps;
mod surfaces;
pub mod types;
mod user_material;
#[cfg(feature = "mesh-files")]
pub(crate) mod vtk_file;
#[cfg(not(feature = "mesh-files"))]
#[path = "no_vtk_file.rs"]
mod vtk_file;

pub use types::*;

use crate::deck::{Deck, Diagnostics};

/// Resolves a deck. Always returns a model; it may be run only where the diagnostics hold no error.
pub fn build(deck: &Deck) -> (Model, Diagnostics) {
    let mut builder = builder::Builder::new(deck);
    builder.model.inert = check::check(deck, &mut builder.diagnostics);
    for card in &deck.cards {
        builder.card(card);
    }
    builder.finish()
}
