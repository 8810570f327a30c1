//! The relation of a refined mesh to the mesh of the deck.

use super::edges::EdgeTable;
use crate::deck::Span;
use crate::model::types::{Element, ElementSide};

/// A `*MPC` that links one node to a reference node.
#[derive(Clone, Debug)]
pub struct NodePair {
    /// Name used in messages.
    pub name: String,
    /// Linked node, and its reference node.
    pub nodes: [usize; 2],
    /// Source position of the data line.
    pub span: Span,
}

/// Relation of a refined mesh to the mesh of the deck.
#[derive(Debug)]
pub struct RefinedMesh {
    /// Number of parts of each edge.
    pub(super) factor: usize,
    /// Number of nodes of the deck; they keep their indices, and new nodes follow.
    pub(super) originals: usize,
    /// Elements of the deck.
    pub(super) parents: Vec<Element>,
    pub(super) edges: EdgeTable,
    /// First new node inside each parent, and the number of all nodes.
    pub(super) first_inside: Vec<usize>,
    /// First child of each parent, and the number of all children.
    pub(super) first_child: Vec<usize>,
    /// Sides of each child that are on sides of its parent, as bits.
    pub(super) outer_sides: Vec<u8>,
    /// Child of each parent that is nearest to its centroid; it has the label of the parent.
    pub(super) middle_child: Vec<usize>,
}

impl RefinedMesh {
    /// Returns whether a node is defined by the deck.
    pub fn is_original(&self, node: usize) -> bool {
        node < self.originals
    }

    /// Returns the sides of an element of the deck that are divided, as bits. A side between two equal nodes counts as
    /// divided if the number of other divided sides is odd.
    pub(super) fn divided_sides(&self, parent: usize) -> u8 {
        let nodes = &self.parents[parent].nodes;
        let ends = |side: usize| [nodes[side], nodes[(side + 1) % nodes.len()]];
        let is_divided = |side: usize| self.edges.is_divided(ends(side));
        let real: u8 = (0..nodes.len()).map(|side| u8::from(is_divided(side)) << side).sum();
        let collapsed = (0..nodes.len()).find(|&side| ends(side)[0] == ends(side)[1]);
        match collapsed {
            Some(side) if real.count_ones() % 2 == 1 => real | 1 << side,
            _ => real,
        }
    }

    /// Returns the children of an element of the deck.
    pub fn children(&self, parent: usize) -> std::ops::Range<usize> {
        self.first_child[parent]..self.first_child[parent + 1]
    }

    /// Returns whether children belong to the same element of the deck.
    pub fn has_one_parent(&self, children: &[usize]) -> bool {
        let parent = |child: usize| self.first_child.partition_point(|&first| first <= child) - 1;
        children.iter().all(|&child| parent(child) == parent(children[0]))
    }

    /// Returns whether a side of a child is on a side of its parent.
    pub fn is_outer(&self, child: usize, side: ElementSide) -> bool {
        match side {
            ElementSide::Face(number) => self.outer_sides[child] & (1 << (number - 1)) != 0,
            ElementSide::Positive | ElementSide::Negative => true,
        }
    }
}
