//! Nodes of an element: four at most, which lie in the element itself.
//! Never here: what they are for.

use crate::kernel::lists::heap_bytes;

use std::fmt;
use std::ops::{Deref, DerefMut};

/// Indices of the nodes of an element, in its order: a list that reads like a slice.
#[derive(Clone, PartialEq, Eq)]
pub struct ElementNodes(Held);

#[derive(Clone, PartialEq, Eq)]
enum Held {
    Few(u8, [usize; 4]),
    /// More than any type has; a check of the model tells.
    Many(Vec<usize>),
}

impl ElementNodes {
    /// Leaves the first ones alone.
    pub fn truncate(&mut self, count: usize) {
        *self = ElementNodes::from(&self[..count.min(self.len())]);
    }

    /// Bytes beside its own.
    pub(super) fn bytes_elsewhere(&self) -> usize {
        match &self.0 {
            Held::Few(..) => 0,
            Held::Many(list) => heap_bytes(list),
        }
    }
}

impl From<&[usize]> for ElementNodes {
    fn from(nodes: &[usize]) -> Self {
        let mut few = [0; 4];
        match few.get_mut(..nodes.len()) {
            Some(place) => {
                place.copy_from_slice(nodes);
                ElementNodes(Held::Few(nodes.len() as u8, few))
            }
            None => ElementNodes(Held::Many(nodes.to_vec())),
        }
    }
}

impl Deref for ElementNodes {
    type Target = [usize];

    fn deref(&self) -> &[usize] {
        match &self.0 {
            Held::Few(count, nodes) => &nodes[..usize::from(*count)],
            Held::Many(nodes) => nodes,
        }
    }
}

impl DerefMut for ElementNodes {
    fn deref_mut(&mut self) -> &mut [usize] {
        match &mut self.0 {
            Held::Few(count, nodes) => &mut nodes[..usize::from(*count)],
            Held::Many(nodes) => nodes,
        }
    }
}

impl<'a> IntoIterator for &'a ElementNodes {
    type Item = &'a usize;
    type IntoIter = std::slice::Iter<'a, usize>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<const N: usize> PartialEq<[usize; N]> for ElementNodes {
    fn eq(&self, other: &[usize; N]) -> bool {
        **self == other[..]
    }
}

impl fmt::Debug for ElementNodes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&**self, f)
    }
}

#[cfg(test)]
mod tests {
    use super::ElementNodes;

    #[test]
    fn a_list_of_any_length() {
        for count in 0..7 {
            let all: Vec<usize> = (10..10 + count).collect();
            let mut nodes = ElementNodes::from(&all[..]);
            assert_eq!((&*nodes, format!("{nodes:?}")), (&all[..], format!("{all:?}")));
            nodes.reverse();
            assert!(nodes.iter().rev().eq(&all));
            nodes.truncate(2);
            assert_eq!(nodes.len(), count.min(2));
        }
    }
}
