//! Effects that can be left out of a model, one at a time: each an edit between `model::build` and `plan::compile`.

mod body;
mod loads;
mod material;
mod numerics;
mod target;

use crate::model::Model;

/// An effect that can be left out.
struct Ablation {
    name: &'static str,
    instead: &'static str,
    present: fn(&Model) -> bool,
    edit: fn(&mut Model),
}

impl Ablation {
    const fn new(
        name: &'static str,
        instead: &'static str,
        present: fn(&Model) -> bool,
        edit: fn(&mut Model),
    ) -> Ablation {
        Ablation { name, instead, present, edit }
    }
}

/// A model without one effect.
pub struct Omission {
    /// The effect, as the ledger calls it.
    pub name: String,
    /// What takes its place, in words.
    pub instead: &'static str,
    /// Leaves it out.
    pub edit: Box<dyn Fn(&mut Model)>,
}

/// What can be left out of a model, in the order of the ledger.
pub fn omissions(model: &Model) -> Vec<Omission> {
    let of = |list: &'static [Ablation]| {
        let present = list.iter().filter(|effect| (effect.present)(model));
        present.map(|effect| Omission {
            name: effect.name.into(),
            instead: effect.instead,
            edit: Box::new(effect.edit),
        })
    };
    let rest = [target::LIST, material::LIST, numerics::LIST, body::LIST];
    of(loads::LIST).chain(target::layers_left_out(model)).chain(rest.into_iter().flat_map(of)).collect()
}
