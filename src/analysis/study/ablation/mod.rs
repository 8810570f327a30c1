//! Effects that can be removed from a model one at a time. Each removal edits the model between `model::build` and
//! `plan::compile`.

mod body;
mod loads;
mod material;
mod numerics;
mod target;

use crate::model::Model;

/// An effect that can be removed from models that have it.
struct EffectRemoval {
    name: &'static str,
    instead: &'static str,
    present: fn(&Model) -> bool,
    edit: fn(&mut Model),
}

impl EffectRemoval {
    const fn new(
        name: &'static str,
        instead: &'static str,
        present: fn(&Model) -> bool,
        edit: fn(&mut Model),
    ) -> EffectRemoval {
        EffectRemoval { name, instead, present, edit }
    }
}

/// Removal of one effect from a given model.
pub struct ReducedModel {
    /// Name of the effect in the ledger.
    pub name: String,
    /// Description of the replacement.
    pub instead: &'static str,
    /// Function that removes the effect from a model.
    pub edit: Box<dyn Fn(&mut Model) + Send + Sync>,
}

/// Returns the effects that can be removed from a model, in the order of the ledger.
pub fn omissions(model: &Model) -> Vec<ReducedModel> {
    let removals_of = |list: &'static [EffectRemoval]| {
        let present = list.iter().filter(|effect| (effect.present)(model));
        present.map(|effect| ReducedModel {
            name: effect.name.into(),
            instead: effect.instead,
            edit: Box::new(effect.edit),
        })
    };
    let other_lists = [target::LIST, material::LIST, numerics::LIST, body::LIST];
    removals_of(loads::LIST)
        .chain(target::layers_left_out(model))
        .chain(other_lists.into_iter().flat_map(removals_of))
        .collect()
}
