//! New nodes that belong to a set of nodes of the deck.
//!
//! A set is a region or a line. All nodes inside an element belong to a set that contains all its nodes. New nodes of
//! an edge belong to a set that contains both ends, unless the edge is a shortcut through the interior between two
//! nodes of a line along the boundary.

use super::edges::{Edge, edges_of};
use super::mesh::RefinedMesh;
use crate::model::types::Element;

/// Edges and elements whose new nodes belong to a set.
#[derive(Debug, Default)]
pub struct Selection {
    /// Places in the edge table.
    pub edges: Vec<usize>,
    /// Indices of parents.
    pub elements: Vec<usize>,
}

impl Selection {
    /// Returns the new nodes, ascending.
    pub fn nodes(&self, refined: &RefinedMesh) -> Vec<usize> {
        let on_edges = self.edges.iter().flat_map(|&place| refined.edges.new_nodes(place));
        let inside = self.elements.iter().flat_map(|&e| refined.first_inside[e]..refined.first_inside[e + 1]);
        on_edges.chain(inside).collect()
    }
}

impl RefinedMesh {
    /// Returns the edges and elements that belong to a set of nodes of the deck; new nodes in the list are ignored.
    pub fn selection(&self, members: &[usize]) -> Selection {
        let mut inside = vec![false; self.originals];
        members.iter().filter(|&&node| self.is_original(node)).for_each(|&node| inside[node] = true);
        let contains = |element: &Element| !element.kind.is_discrete() && element.nodes.iter().all(|&n| inside[n]);
        let mut whole: Vec<bool> = self.parents.iter().map(contains).collect();
        let ears: Vec<usize> = (0..whole.len()).filter(|&e| whole[e] && self.is_ear(e, &whole)).collect();
        ears.into_iter().for_each(|e| whole[e] = false);
        let both = |ends: &[usize; 2]| ends.iter().all(|&n| inside[n]);
        let certain = |edge: &Edge| edge.is_line || edge.solids == 1 || edge.elements.iter().any(|&e| whole[e]);
        let mut on_line = vec![false; self.originals];
        for (ends, _) in self.edges.iter().filter(|(ends, edge)| both(ends) && edge.solids < 2) {
            ends.iter().for_each(|&n| on_line[n] = true);
        }
        let belongs =
            |ends: &[usize; 2], edge: &Edge| both(ends) && (certain(edge) || !ends.iter().all(|&n| on_line[n]));
        let edges = self.edges.iter().enumerate().filter(|(_, (ends, edge))| belongs(ends, edge));
        let edges = edges.map(|(place, _)| place).collect();
        Selection { edges, elements: (0..whole.len()).filter(|&e| whole[e]).collect() }
    }

    /// Returns whether a triangle has two sides on the boundary, and the element at its third side is not in a set:
    /// then the set is a line around the corner.
    fn is_ear(&self, element: usize, whole: &[bool]) -> bool {
        let parent = &self.parents[element];
        if !parent.kind.is_solid() || parent.nodes.len() == 4 {
            return false;
        }
        let shared: Vec<&Edge> =
            edges_of(parent).filter_map(|ends| self.edges.get(ends)).filter(|edge| edge.solids > 1).collect();
        // A side with a midside node has two edges.
        shared.len() == parent.nodes.len() / 3
            && shared.iter().all(|edge| edge.elements.iter().all(|&e| e == element || !whole[e]))
    }
}
