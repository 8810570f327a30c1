//! Map from indices of mesh nodes or elements to values, which keeps the order of insertion.

use crate::kernel::lists::heap_bytes;

use std::ops::Index;

/// Marks an index without entry.
const NONE: u32 = u32::MAX;

/// A map from mesh indices to values, in the order of insertion. The indices are dense, so that a lookup table of 4
/// bytes per index is used in place of hashing.
#[derive(Clone, Debug)]
pub struct MeshIndexMap<V> {
    /// Position of each index in `entries`; [`NONE`] without entry.
    at: Vec<u32>,
    entries: Vec<(usize, V)>,
}

impl<V> Default for MeshIndexMap<V> {
    fn default() -> Self {
        MeshIndexMap { at: Vec::new(), entries: Vec::new() }
    }
}

impl<V> MeshIndexMap<V> {
    /// Creates an empty map with memory for entries of the indices below a number.
    pub fn with_capacity(count: usize) -> MeshIndexMap<V> {
        MeshIndexMap { at: Vec::with_capacity(count), entries: Vec::with_capacity(count) }
    }

    fn find(&self, number: usize) -> Option<usize> {
        self.at.get(number).filter(|at| **at != NONE).map(|at| *at as usize)
    }

    /// Returns the value of an index.
    pub fn get(&self, number: &usize) -> Option<&V> {
        self.find(*number).map(|at| &self.entries[at].1)
    }

    /// Returns whether an index has a value.
    pub fn contains_key(&self, number: &usize) -> bool {
        self.find(*number).is_some()
    }

    /// Sets the value of an index. An index that is present keeps its position in the order.
    pub fn insert(&mut self, number: usize, value: V) {
        if let Some(at) = self.find(number) {
            self.entries[at].1 = value;
            return;
        }
        if number >= self.at.len() {
            self.at.resize(number + 1, NONE);
        }
        self.at[number] = self.entries.len() as u32;
        self.entries.push((number, value));
    }

    /// Returns the number of entries.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Returns whether there are no entries.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Iterates over the indices in order of insertion.
    pub fn keys(&self) -> impl Iterator<Item = &usize> + Clone {
        self.entries.iter().map(|e| &e.0)
    }

    /// Iterates over the values in order of insertion.
    pub fn values(&self) -> impl Iterator<Item = &V> + Clone {
        self.entries.iter().map(|e| &e.1)
    }

    /// Iterates over indices and values in order of insertion.
    pub fn iter(&self) -> impl Iterator<Item = (&usize, &V)> + Clone {
        self.entries.iter().map(|e| (&e.0, &e.1))
    }

    /// Returns the heap size in bytes.
    pub fn bytes(&self) -> usize {
        heap_bytes(&self.at) + heap_bytes(&self.entries)
    }
}

impl<V> Index<&usize> for MeshIndexMap<V> {
    type Output = V;

    fn index(&self, number: &usize) -> &V {
        &self.entries[self.at[*number] as usize].1
    }
}

impl<V> FromIterator<(usize, V)> for MeshIndexMap<V> {
    fn from_iter<I: IntoIterator<Item = (usize, V)>>(list: I) -> Self {
        let mut places = MeshIndexMap::default();
        let list = list.into_iter();
        places.entries.reserve_exact(list.size_hint().0);
        list.for_each(|(number, value)| places.insert(number, value));
        places
    }
}

#[cfg(test)]
mod tests {
    use super::MeshIndexMap;

    #[test]
    fn entries_are_found_and_keep_their_order() {
        let mut places: MeshIndexMap<char> = [(7, 'a'), (2, 'b')].into_iter().collect();
        places.insert(3, 'c');
        places.insert(7, 'd');
        assert!(places.iter().eq([(&7, &'d'), (&2, &'b'), (&3, &'c')]) && places.keys().eq(&[7, 2, 3]));
        assert_eq!((places.get(&8), places.get(&0), places[&2], places.len()), (None, None, 'b', 3));
        assert!(places.contains_key(&3) && !places.contains_key(&1) && places.values().count() == 3);
        assert!(MeshIndexMap::<u8>::default().is_empty());
    }
}
