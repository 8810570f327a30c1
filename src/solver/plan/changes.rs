//! Changes to the active effects at the start of a step: effects that are kept, added or removed.

use crate::adaptive::AdaptiveDomain;
use crate::constraint::Constraint;
use crate::constraint::user_motion::UserMotion;
use crate::element::mass_scaling::StepMassScaling;
use crate::kernel::lists::{Memory, heap_bytes};
use crate::load::Load;

/// Entry of the list of effects that are active from a step on.
pub enum ListEntry<T: ?Sized> {
    /// The effect at this index of the previous list remains active unchanged.
    Kept(usize),
    /// A new effect, which may take over the history of effects of the previous list.
    Added {
        /// The effect in its initial state.
        effect: Box<T>,
        /// Indices of the previous effects whose history it takes over.
        continues: Vec<usize>,
    },
}

/// List of effects that replaces the list of the previous step. Previous effects without an entry end.
pub struct ListChange<T: ?Sized>(Vec<ListEntry<T>>);

impl<T: ?Sized> ListChange<T>
where
    Box<T>: Clone,
{
    /// Creates the change from a list of `before` effects to these entries; `None` if nothing changes.
    pub fn between(before: usize, entries: Vec<ListEntry<T>>) -> Option<ListChange<T>> {
        let is_kept = |(place, entry): (usize, &ListEntry<T>)| matches!(entry, ListEntry::Kept(from) if *from == place);
        let unchanged = entries.len() == before && entries.iter().enumerate().all(is_kept);
        (!unchanged).then_some(ListChange(entries))
    }

    /// Iterates over the added effects.
    pub fn added(&self) -> impl Iterator<Item = &T> {
        self.0.iter().filter_map(|entry| match entry {
            ListEntry::Added { effect, .. } => Some(&**effect),
            ListEntry::Kept(_) => None,
        })
    }

    /// Returns the list of effects of the first step.
    pub fn into_first(self) -> Vec<Box<T>> {
        let added = |entry| match entry {
            ListEntry::Added { effect, .. } => Some(effect),
            ListEntry::Kept(_) => None,
        };
        self.0.into_iter().filter_map(added).collect()
    }

    /// Applies the change to a list and returns the effects that end. `take_over(new, old)` copies the history of a
    /// previous effect to a new one.
    pub fn apply(&self, list: &mut Vec<Box<T>>, take_over: impl Fn(&mut T, &T)) -> Vec<Box<T>> {
        let begun = |entry: &ListEntry<T>| match entry {
            ListEntry::Kept(_) => None,
            ListEntry::Added { effect, continues } => {
                let mut begun = effect.clone();
                continues.iter().for_each(|&place| take_over(&mut begun, &list[place]));
                Some(begun)
            }
        };
        let begun: Vec<Option<Box<T>>> = self.0.iter().map(begun).collect();
        let mut previous: Vec<Option<Box<T>>> = list.drain(..).map(Some).collect();
        for (entry, begun) in self.0.iter().zip(begun) {
            list.extend(match entry {
                ListEntry::Kept(place) => previous[*place].take(),
                ListEntry::Added { .. } => begun,
            });
        }
        previous.into_iter().flatten().collect()
    }

    /// Returns the heap size of the entries in bytes, without the effects.
    pub fn bytes(&self) -> usize {
        heap_bytes(&self.0)
    }
}

/// Changes to all active effects at the start of a step. A `None` list is unchanged.
#[derive(Default)]
pub struct StepChanges {
    /// Loads; those that resist motion are last.
    pub loads: Option<ListChange<dyn Load>>,
    /// Constraints: prescribed motions, equations, contact, ties.
    pub constraints: Option<ListChange<dyn Constraint>>,
    /// User motions (VDISP), called once per increment.
    pub user_motions: Option<ListChange<UserMotion>>,
    /// New mass scaling; `Some(None)` ends it.
    pub scaling: Option<Option<StepMassScaling>>,
    /// New domains of adaptive meshes.
    pub adaptive: Option<Vec<AdaptiveDomain>>,
}

impl StepChanges {
    /// Returns whether nothing changes.
    pub fn is_empty(&self) -> bool {
        self.loads.is_none()
            && self.constraints.is_none()
            && self.user_motions.is_none()
            && self.scaling.is_none()
            && self.adaptive.is_none()
    }

    /// Returns the size of the lists in bytes, without loads, constraints and mass scaling.
    pub fn bytes(&self) -> usize {
        let motions =
            self.user_motions.iter().flat_map(ListChange::added).map(|m| size_of_val(m) + m.bytes()).sum::<usize>();
        let loads = self.loads.as_ref().map_or(0, ListChange::bytes);
        motions + loads + self.constraints.as_ref().map_or(0, ListChange::bytes)
    }
}
