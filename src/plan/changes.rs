//! What a step changes of what is in force: effects that stay, begin and end, in the order in which they act from then on.
//! Never here: which effects a deck asks for.

use crate::constraint::Constraint;
use crate::constraint::user_motion::UserMotion;
use crate::element::mass_scaling::Scaling;
use crate::kernel::lists::heap_bytes;
use crate::load::Load;

/// One effect of a list from a step on.
pub enum Entry<T: ?Sized> {
    /// That at this place of the list before stays in force as it is.
    Kept(usize),
    /// A new one, which takes over the memory of those at these places of the list before.
    Added {
        /// As it begins.
        effect: Box<T>,
        /// Places of those that it continues.
        continues: Vec<usize>,
    },
}

/// A list of effects from a step on. What of the list before has no entry ends.
pub struct ListChange<T: ?Sized>(Vec<Entry<T>>);

impl<T: ?Sized> ListChange<T>
where
    Box<T>: Clone,
{
    /// The change of a list of so many effects to these; `None` where nothing changes.
    pub fn between(before: usize, entries: Vec<Entry<T>>) -> Option<ListChange<T>> {
        let is_kept = |(place, entry): (usize, &Entry<T>)| matches!(entry, Entry::Kept(from) if *from == place);
        let unchanged = entries.len() == before && entries.iter().enumerate().all(is_kept);
        (!unchanged).then_some(ListChange(entries))
    }

    /// The effects that begin.
    pub fn added(&self) -> impl Iterator<Item = &T> {
        self.0.iter().filter_map(|entry| match entry {
            Entry::Added { effect, .. } => Some(&**effect),
            Entry::Kept(_) => None,
        })
    }

    /// The list of a first step, in which nothing is in force before.
    pub fn into_first(self) -> Vec<Box<T>> {
        let added = |entry| match entry {
            Entry::Added { effect, .. } => Some(effect),
            Entry::Kept(_) => None,
        };
        self.0.into_iter().filter_map(added).collect()
    }

    /// Changes a list; `take_over` gives a new effect the memory of one that it continues. Returns the effects that have ended.
    pub fn apply(&self, list: &mut Vec<Box<T>>, take_over: impl Fn(&mut T, &T)) -> Vec<Box<T>> {
        let begun = |entry: &Entry<T>| match entry {
            Entry::Kept(_) => None,
            Entry::Added { effect, continues } => {
                let mut begun = effect.clone();
                continues.iter().for_each(|&place| take_over(&mut begun, &list[place]));
                Some(begun)
            }
        };
        let begun: Vec<Option<Box<T>>> = self.0.iter().map(begun).collect();
        let mut before: Vec<Option<Box<T>>> = list.drain(..).map(Some).collect();
        for (entry, begun) in self.0.iter().zip(begun) {
            list.extend(match entry {
                Entry::Kept(place) => before[*place].take(),
                Entry::Added { .. } => begun,
            });
        }
        before.into_iter().flatten().collect()
    }

    /// Bytes of the entries, but for those of the effects themselves.
    pub fn bytes(&self) -> usize {
        heap_bytes(&self.0)
    }
}

/// What a step changes of what is in force. All of it is empty where a step goes on as the one before.
#[derive(Default)]
pub struct Changes {
    /// Loads; those that resist come last.
    pub loads: Option<ListChange<dyn Load>>,
    /// Constraints: prescribed motions, equations, contact, ties.
    pub constraints: Option<ListChange<dyn Constraint>>,
    /// User motions, which are asked once an increment.
    pub user_motions: Option<ListChange<UserMotion>>,
    /// Mass scaling, or that it ends.
    pub scaling: Option<Option<Scaling>>,
}

impl Changes {
    /// Whether all goes on as before.
    pub fn is_empty(&self) -> bool {
        self.loads.is_none() && self.constraints.is_none() && self.user_motions.is_none() && self.scaling.is_none()
    }

    /// Bytes of its lists, but for those of loads, constraints and mass scaling.
    pub fn bytes(&self) -> usize {
        let motions =
            self.user_motions.iter().flat_map(ListChange::added).map(|m| size_of_val(m) + m.bytes()).sum::<usize>();
        let loads = self.loads.as_ref().map_or(0, ListChange::bytes);
        motions + loads + self.constraints.as_ref().map_or(0, ListChange::bytes)
    }
}
