//! Where nodes and elements of the mesh went: by their numbers, and in the order in which they were placed.
//! Never here: what they became.

use crate::kernel::lists::heap_bytes;

use std::ops::Index;

/// No place.
const NONE: u32 = u32::MAX;

/// A map from numbers of a mesh, which lie close: 4 bytes a number, and an entry for each that is there. Entries keep the order in
/// which they were inserted.
#[derive(Clone, Debug)]
pub struct Places<V> {
    /// Entry of each number; [`NONE`] where there is none.
    at: Vec<u32>,
    entries: Vec<(usize, V)>,
}

impl<V> Default for Places<V> {
    fn default() -> Self {
        Places { at: Vec::new(), entries: Vec::new() }
    }
}

impl<V> Places<V> {
    fn find(&self, number: usize) -> Option<usize> {
        self.at.get(number).filter(|at| **at != NONE).map(|at| *at as usize)
    }

    /// What a number became.
    pub fn get(&self, number: &usize) -> Option<&V> {
        self.find(*number).map(|at| &self.entries[at].1)
    }

    /// Whether a number is there.
    pub fn contains_key(&self, number: &usize) -> bool {
        self.find(*number).is_some()
    }

    /// Sets what a number became; one that is there keeps its place in the order.
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

    /// How many there are.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Numbers in order.
    pub fn keys(&self) -> impl Iterator<Item = &usize> + Clone {
        self.entries.iter().map(|e| &e.0)
    }

    /// What they became, in order.
    pub fn values(&self) -> impl Iterator<Item = &V> + Clone {
        self.entries.iter().map(|e| &e.1)
    }

    /// Both, in order.
    pub fn iter(&self) -> impl Iterator<Item = (&usize, &V)> + Clone {
        self.entries.iter().map(|e| (&e.0, &e.1))
    }

    /// Bytes of its lists.
    pub fn bytes(&self) -> usize {
        heap_bytes(&self.at) + heap_bytes(&self.entries)
    }
}

impl<V> Index<&usize> for Places<V> {
    type Output = V;

    fn index(&self, number: &usize) -> &V {
        &self.entries[self.at[*number] as usize].1
    }
}

impl<V> FromIterator<(usize, V)> for Places<V> {
    fn from_iter<I: IntoIterator<Item = (usize, V)>>(list: I) -> Self {
        let mut places = Places::default();
        let list = list.into_iter();
        places.entries.reserve_exact(list.size_hint().0);
        list.for_each(|(number, value)| places.insert(number, value));
        places
    }
}

#[cfg(test)]
mod tests {
    use super::Places;

    #[test]
    fn numbers_are_found_and_keep_their_order() {
        let mut places: Places<char> = [(7, 'a'), (2, 'b')].into_iter().collect();
        places.insert(3, 'c');
        places.insert(7, 'd');
        assert!(places.iter().eq([(&7, &'d'), (&2, &'b'), (&3, &'c')]) && places.keys().eq(&[7, 2, 3]));
        assert_eq!((places.get(&8), places.get(&0), places[&2], places.len()), (None, None, 'b', 3));
        assert!(places.contains_key(&3) && !places.contains_key(&1) && places.values().count() == 3);
        assert!(Places::<u8>::default().is_empty());
    }
}
