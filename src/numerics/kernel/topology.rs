//! Topologies of elements: number of nodes, boundary, and quadrilateral cells.

use std::ops::{Deref, DerefMut};

/// Largest number of nodes of an element.
pub const MOST_NODES: usize = 6;

/// One value for each node of an element, in the order of its topology.
#[derive(Clone, Copy, Debug, Default)]
pub struct PerNode<T> {
    values: [T; MOST_NODES],
    count: u8,
}

/// Node indices of one element, as many as its topology has.
pub type ElementNodes = PerNode<u32>;

impl<T: Copy + Default> PerNode<T> {
    #[must_use]
    pub fn first(mut self, count: usize) -> Self {
        self.count = self.count.min(count as u8);
        self
    }

    /// Returns the values, and how many are in use.
    pub fn parts_mut(&mut self) -> (&mut [T; MOST_NODES], &mut u8) {
        (&mut self.values, &mut self.count)
    }

    /// Returns the sides of a closed boundary, from each node to the next; a side between coincident nodes is omitted.
    pub fn sides(self) -> impl Iterator<Item = [T; 2]> + Clone
    where
        T: PartialEq,
    {
        let count = self.len();
        (0..count).map(move |i| [self[i], self[(i + 1) % count]]).filter(|[a, b]| a != b)
    }

    /// Applies a function to each value.
    pub fn map<U: Copy + Default>(&self, of: impl Fn(T) -> U) -> PerNode<U> {
        let mut mapped = PerNode { values: [U::default(); MOST_NODES], count: self.count };
        mapped.values.iter_mut().zip(self.iter()).for_each(|(to, from)| *to = of(*from));
        mapped
    }
}

impl<T: Copy + Default, const N: usize> From<[T; N]> for PerNode<T> {
    fn from(list: [T; N]) -> Self {
        const { assert!(N <= MOST_NODES) };
        let mut values = [T::default(); MOST_NODES];
        values[..N].copy_from_slice(&list);
        PerNode { values, count: N as u8 }
    }
}

impl<T> Deref for PerNode<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.values[..usize::from(self.count)]
    }
}

impl<T> DerefMut for PerNode<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.values[..usize::from(self.count)]
    }
}

impl<T> IntoIterator for PerNode<T> {
    type Item = T;
    type IntoIter = std::iter::Take<std::array::IntoIter<T, MOST_NODES>>;

    fn into_iter(self) -> Self::IntoIter {
        self.values.into_iter().take(usize::from(self.count))
    }
}

impl<T: PartialEq> PartialEq for PerNode<T> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

/// The shape of the elements of a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ElementTopology {
    /// Two nodes, then the companion nodes of their rotations; both sides of a shell can be in contact.
    Shell,
    /// Four corners, counter-clockwise; for a triangle the last two coincide.
    Quadrilateral,
    /// Three corners and the middle nodes of the sides between them, around the boundary counter-clockwise from a
    /// corner.
    SixNodeTriangle,
    /// Two nodes of the bottom face, then those of the top face, counter-clockwise; tractions act between the faces.
    Cohesive,
}

impl ElementTopology {
    /// Returns the number of nodes of an element, including rotations.
    pub fn nodes(self) -> usize {
        match self {
            ElementTopology::Shell | ElementTopology::Quadrilateral | ElementTopology::Cohesive => 4,
            ElementTopology::SixNodeTriangle => 6,
        }
    }

    /// Returns the number of boundary nodes, which are the first ones.
    pub fn boundary(self) -> usize {
        if self == ElementTopology::Shell { 2 } else { self.nodes() }
    }

    /// Returns whether the boundary encloses the volume of an element.
    pub fn is_solid(self) -> bool {
        !matches!(self, ElementTopology::Shell | ElementTopology::Cohesive)
    }

    /// Returns the number of blocks of four corner forces per block of elements.
    pub fn force_blocks(self) -> usize {
        self.nodes().div_ceil(4)
    }

    /// Returns the quadrilateral cells of a solid element, counter-clockwise, as indices into the boundary; for a
    /// triangle the last two corners coincide.
    pub fn cells(self) -> &'static [[usize; 4]] {
        match self {
            ElementTopology::Shell | ElementTopology::Cohesive => &[],
            ElementTopology::Quadrilateral => &[[0, 1, 2, 3]],
            ElementTopology::SixNodeTriangle => &[[0, 1, 5, 5], [2, 3, 1, 1], [4, 5, 3, 3], [1, 3, 5, 5]],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{ElementNodes, ElementTopology, PerNode};
    use crate::kernel::quad;

    #[test]
    fn cells_of_a_six_node_triangle_fill_its_boundary() {
        let corners = [[1.0, 0.0], [2.0, 0.25], [3.0, 0.5], [2.5, 1.5], [1.0, 2.0], [0.75, 1.0]];
        let cells = ElementTopology::SixNodeTriangle.cells().iter().map(|cell| quad::volume(cell.map(|i| corners[i])));
        assert!((cells.sum::<f64>() - crate::kernel::solid::volume(&corners)).abs() < 1e-13);
    }

    #[test]
    fn sides_follow_the_boundary_and_skip_doubled_nodes() {
        let nodes = ElementNodes::from([4, 5, 6, 6]);
        assert!(nodes.sides().eq([[4, 5], [5, 6], [6, 4]]));
        assert!(nodes.first(2).sides().eq([[4, 5], [5, 4]]));
        assert_eq!(nodes.map(|n| 2 * n), PerNode::from([8, 10, 12, 12]));
        assert!(nodes.into_iter().eq([4, 5, 6, 6]));
    }
}
