//! Solver indices of mesh nodes and elements, in maps that keep the order of insertion.

use std::ops::Index;

use crate::kernel::lists::Memory;

/// Marks an index without entry.
const NONE: u32 = u32::MAX;

/// A map from mesh indices to values, in the order of insertion. The indices are dense, so that a lookup table of 4
/// bytes per index is used in place of hashing. While the indices are 0, 1, 2 and so on, only the values are stored.
#[derive(Clone, Debug, Memory)]
#[memory(flat: values)]
pub struct MeshIndexMap<V> {
    /// Position of each index in the lists; [`NONE`] without entry.
    at: Vec<u32>,
    /// Indices in the order of insertion. This list and `at` are empty while each index is its own position.
    keys: Vec<u32>,
    values: Vec<V>,
}

impl<V> Default for MeshIndexMap<V> {
    fn default() -> Self {
        MeshIndexMap { at: Vec::new(), keys: Vec::new(), values: Vec::new() }
    }
}

impl<V> MeshIndexMap<V> {
    /// Creates an empty map with memory for a number of entries.
    pub fn with_capacity(count: usize) -> MeshIndexMap<V> {
        MeshIndexMap { values: Vec::with_capacity(count), ..MeshIndexMap::default() }
    }

    fn find(&self, number: usize) -> Option<usize> {
        if self.keys.is_empty() {
            return (number < self.values.len()).then_some(number);
        }
        self.at.get(number).filter(|at| **at != NONE).map(|at| *at as usize)
    }

    fn key(&self, at: usize) -> usize {
        self.keys.get(at).map_or(at, |key| *key as usize)
    }

    /// Returns the value of an index.
    pub fn get(&self, number: &usize) -> Option<&V> {
        self.find(*number).map(|at| &self.values[at])
    }

    /// Returns whether an index has a value.
    pub fn contains_key(&self, number: &usize) -> bool {
        self.find(*number).is_some()
    }

    /// Sets the value of an index. An index that is present keeps its position in the order.
    pub fn insert(&mut self, number: usize, value: V) {
        if let Some(index) = self.find(number) {
            self.values[index] = value;
            return;
        }
        let position = self.values.len();
        if !self.keys.is_empty() || number != position {
            self.list_indices();
            if number >= self.at.len() {
                self.at.resize(number + 1, NONE);
            }
            self.at[number] = position as u32;
            self.keys.push(number as u32);
        }
        self.values.push(value);
    }

    /// Fills the lists of indices if each index is its own position.
    fn list_indices(&mut self) {
        if self.keys.is_empty() {
            let positions = 0..self.values.len() as u32;
            for list in [&mut self.at, &mut self.keys] {
                list.reserve_exact(self.values.capacity());
                list.extend(positions.clone());
            }
        }
    }

    /// Returns the number of entries.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Returns whether there are no entries.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Iterates over the indices in order of insertion.
    pub fn keys(&self) -> impl Iterator<Item = usize> + Clone {
        (0..self.len()).map(|at| self.key(at))
    }

    /// Iterates over the values in order of insertion.
    pub fn values(&self) -> impl Iterator<Item = &V> + Clone {
        self.values.iter()
    }

    /// Iterates over indices and values in order of insertion.
    pub fn iter(&self) -> impl Iterator<Item = (usize, &V)> + Clone {
        self.keys().zip(&self.values)
    }
}

impl<V> Index<&usize> for MeshIndexMap<V> {
    type Output = V;

    fn index(&self, number: &usize) -> &V {
        let position = if self.keys.is_empty() { *number } else { self.at[*number] as usize };
        &self.values[position]
    }
}

impl<V> FromIterator<(usize, V)> for MeshIndexMap<V> {
    fn from_iter<I: IntoIterator<Item = (usize, V)>>(list: I) -> Self {
        let list = list.into_iter();
        let mut places = MeshIndexMap::with_capacity(list.size_hint().0);
        list.for_each(|(number, value)| places.insert(number, value));
        places
    }
}

/// Solver indices of the deformable nodes and elements of the mesh.
#[derive(Clone, Debug, Default, Memory)]
pub struct SolidPlaces {
    /// Solver node of each mesh node.
    pub nodes: MeshIndexMap<usize>,
    /// Group and index in the group of each mesh element.
    pub elements: MeshIndexMap<(usize, usize)>,
    /// Rigid body of the mesh nodes that are tied to one.
    pub tied: MeshIndexMap<usize>,
    /// Index of the rotation in the list of solver nodes, for mesh nodes of shells.
    pub rotations: MeshIndexMap<usize>,
}

impl SolidPlaces {
    /// Returns whether a mesh node belongs to a deformable body and is not tied to a rigid body.
    pub fn has_node(&self, node: usize) -> bool {
        self.free_node(node).is_some()
    }

    /// Returns the mesh element of an element of a group, given the group and the index in it.
    pub fn element_at(&self, place: (usize, usize)) -> Option<usize> {
        self.elements.iter().find(|entry| *entry.1 == place).map(|entry| entry.0)
    }

    /// Returns the solver node of a mesh node; `None` if it is tied to a rigid body or not deformable.
    pub fn free_node(&self, node: usize) -> Option<usize> {
        self.nodes.get(&node).copied().filter(|_| !self.tied.contains_key(&node))
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
        assert!(places.iter().eq([(7, &'d'), (2, &'b'), (3, &'c')]) && places.keys().eq([7, 2, 3]));
        assert_eq!((places.get(&8), places.get(&0), places[&2], places.len()), (None, None, 'b', 3));
        assert!(places.contains_key(&3) && !places.contains_key(&1) && places.values().count() == 3);
        assert!(MeshIndexMap::<u8>::default().is_empty());
    }

    #[test]
    fn indices_in_order_are_not_stored() {
        let mut places: MeshIndexMap<char> = [(0, 'a'), (1, 'b'), (0, 'c')].into_iter().collect();
        assert!(places.keys.is_empty() && places.iter().eq([(0, &'c'), (1, &'b')]) && !places.contains_key(&2));
        places.insert(5, 'd');
        places.insert(2, 'e');
        places.insert(1, 'f');
        assert!(places.iter().eq([(0, &'c'), (1, &'f'), (5, &'d'), (2, &'e')]) && places.get(&3).is_none());
        assert_eq!((places[&0], places[&5]), ('c', 'd'));
    }
}
