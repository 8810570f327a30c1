//! Effects that can be left out of a model, one at a time: each an edit between `model::build` and `plan::compile`.
//! Never here: runs, what the change of a result means (`effects`).

mod body;
mod loads;
mod material;
mod numerics;
mod target;

use crate::model::Model;

/// An effect that can be left out.
#[derive(Clone, Copy)]
pub struct Ablation {
    /// The effect, as the ledger calls it.
    pub name: &'static str,
    /// What takes its place, in words.
    pub instead: &'static str,
    /// In how many ways it can be left out of this model: none where it is not there, one a layer for layers.
    pub ways: fn(&Model) -> usize,
    /// Leaves it out, in the way counted from 0.
    pub edit: fn(&mut Model, usize),
    /// Names the way, where there are several.
    pub way: fn(&Model, usize) -> String,
}

/// All of them, in the order of the ledger.
pub fn all() -> impl Iterator<Item = &'static Ablation> {
    loads::LIST.iter().chain(target::LIST).chain(material::LIST).chain(numerics::LIST).chain(body::LIST)
}

/// Nothing to tell ways apart.
fn one_way(_model: &Model, _way: usize) -> String {
    String::new()
}
