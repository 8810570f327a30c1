//! Node indices of an element, stored inline for up to four nodes.

use crate::kernel::lists::heap_bytes;

use std::fmt;
use std::ops::{Deref, DerefMut};

/// Node indices of an element in element order; dereferences to a slice.
#[derive(Clone, PartialEq, Eq)]
pub struct NodeIndices(NodeStorage);

#[derive(Clone, PartialEq, Eq)]
enum NodeStorage {
    Few(u8, [usize; 4]),
    /// More than four nodes.
    Many(Vec<usize>),
}

impl NodeIndices {
    /// Keeps the first `count` indices.
    pub fn truncate(&mut self, count: usize) {
        *self = NodeIndices::from(&self[..count.min(self.len())]);
    }

    /// Returns the heap memory in bytes.
    pub(super) fn bytes_elsewhere(&self) -> usize {
        match &self.0 {
            NodeStorage::Few(..) => 0,
            NodeStorage::Many(list) => heap_bytes(list),
        }
    }
}

impl From<&[usize]> for NodeIndices {
    fn from(nodes: &[usize]) -> Self {
        let mut few = [0; 4];
        match few.get_mut(..nodes.len()) {
            Some(place) => {
                place.copy_from_slice(nodes);
                NodeIndices(NodeStorage::Few(nodes.len() as u8, few))
            }
            None => NodeIndices(NodeStorage::Many(nodes.to_vec())),
        }
    }
}

impl Deref for NodeIndices {
    type Target = [usize];

    fn deref(&self) -> &[usize] {
        match &self.0 {
            NodeStorage::Few(count, nodes) => &nodes[..usize::from(*count)],
            NodeStorage::Many(nodes) => nodes,
        }
    }
}

impl DerefMut for NodeIndices {
    fn deref_mut(&mut self) -> &mut [usize] {
        match &mut self.0 {
            NodeStorage::Few(count, nodes) => &mut nodes[..usize::from(*count)],
            NodeStorage::Many(nodes) => nodes,
        }
    }
}

impl<'a> IntoIterator for &'a NodeIndices {
    type Item = &'a usize;
    type IntoIter = std::slice::Iter<'a, usize>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<const N: usize> PartialEq<[usize; N]> for NodeIndices {
    fn eq(&self, other: &[usize; N]) -> bool {
        **self == other[..]
    }
}

impl fmt::Debug for NodeIndices {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&**self, f)
    }
}

#[cfg(test)]
mod tests {
    use super::NodeIndices;

    #[test]
    fn lists_of_any_length_are_stored() {
        for count in 0..7 {
            let listed: Vec<usize> = (10..10 + count).collect();
            let mut nodes = NodeIndices::from(&listed[..]);
            assert_eq!((&*nodes, format!("{nodes:?}")), (&listed[..], format!("{listed:?}")));
            nodes.reverse();
            assert!(nodes.iter().rev().eq(&listed));
            nodes.truncate(2);
            assert_eq!(nodes.len(), count.min(2));
        }
    }
}
