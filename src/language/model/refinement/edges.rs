//! Edges of a mesh with their new nodes.

use indexmap::IndexMap;

use crate::kernel::lists::sorted_pair;
use crate::model::types::Element;

/// Edges of all solids, shells and rigid surface elements, in order of elements.
#[derive(Debug, Default)]
pub struct EdgeTable {
    edges: IndexMap<[usize; 2], Edge>,
    /// First new node of each edge, and the index after the last new node.
    first_new: Vec<usize>,
}

/// An edge of the mesh.
#[derive(Clone, Copy, Debug, Default)]
pub struct Edge {
    /// Elements at the edge: the first one and the last one.
    pub elements: [usize; 2],
    /// Number of solid elements at the edge.
    pub solids: usize,
    /// Whether the edge is a shell or a rigid surface element.
    pub is_line: bool,
}

/// Returns the edges of an element: pairs of consecutive nodes around its boundary; of a cohesive element, both faces.
pub fn edges_of(element: &Element) -> impl Iterator<Item = [usize; 2]> {
    let nodes = &element.nodes;
    let cohesive = element.kind.is_cohesive();
    let count = match nodes.len() {
        _ if element.kind.is_discrete() => 0,
        2 => 1,
        count => count,
    };
    let is_edge = move |i: &usize| !cohesive || i.is_multiple_of(2);
    (0..count).filter(is_edge).map(move |i| [nodes[i], nodes[(i + 1) % nodes.len()]]).filter(|[a, b]| a != b)
}

impl EdgeTable {
    /// Collects the edges of elements, without new nodes.
    pub fn new(elements: &[Element]) -> EdgeTable {
        let mut edges: IndexMap<[usize; 2], Edge> = IndexMap::new();
        for (at, element) in elements.iter().enumerate() {
            for ends in edges_of(element) {
                let entry = edges.entry(sorted_pair(ends));
                let edge = entry.or_insert(Edge { elements: [at; 2], ..Edge::default() });
                edge.elements[1] = at;
                edge.solids += usize::from(element.kind.is_solid());
                edge.is_line |= !element.kind.is_solid() && !element.kind.is_cohesive();
            }
        }
        EdgeTable { edges, first_new: Vec::new() }
    }

    /// Gives each divided edge `factor - 1` new nodes, from the index `first` on.
    pub fn divide(&mut self, factor: usize, first: usize, is_divided: impl Fn(usize) -> bool) {
        let mut next = first;
        self.first_new = Vec::with_capacity(self.edges.len() + 1);
        for place in 0..self.edges.len() {
            self.first_new.push(next);
            next += if is_divided(place) { factor - 1 } else { 0 };
        }
        self.first_new.push(next);
    }

    /// Returns the number of edges.
    pub fn len(&self) -> usize {
        self.edges.len()
    }

    /// Returns the place of the edge between two nodes in the table.
    pub fn index(&self, ends: [usize; 2]) -> Option<usize> {
        self.edges.get_index_of(&sorted_pair(ends))
    }

    /// Returns whether the edge between two nodes has new nodes.
    pub fn is_divided(&self, ends: [usize; 2]) -> bool {
        self.index(ends).is_some_and(|place| !self.new_nodes(place).is_empty())
    }

    /// Iterates over the edges with their two nodes, the lower index first.
    pub fn iter(&self) -> impl Iterator<Item = (&[usize; 2], &Edge)> {
        self.edges.iter()
    }

    /// Returns the index after the last new node.
    pub fn end(&self) -> usize {
        self.first_new.last().copied().unwrap_or(0)
    }

    /// Returns whether two nodes are connected by an edge.
    pub fn connects(&self, ends: [usize; 2]) -> bool {
        self.get(ends).is_some()
    }

    /// Returns the edge between two nodes.
    pub fn get(&self, ends: [usize; 2]) -> Option<&Edge> {
        self.edges.get(&sorted_pair(ends))
    }

    /// Returns the new nodes of an edge, given by its place in the table.
    pub fn new_nodes(&self, place: usize) -> std::ops::Range<usize> {
        self.first_new[place]..self.first_new[place + 1]
    }

    /// Returns the node at the end of part `part` of an edge from `a` to `b`; part 0 is node `a`.
    pub fn node(&self, [a, b]: [usize; 2], part: usize) -> usize {
        if part == 0 || a == b {
            return a;
        }
        let Some(place) = self.index([a, b]) else { return a };
        let new_nodes = self.new_nodes(place);
        if part > new_nodes.len() {
            return b;
        }
        new_nodes.start + if a < b { part - 1 } else { new_nodes.len() - part }
    }

    /// Returns the edge of a new node, and the number of parts between its first node and the new node.
    pub fn place(&self, node: usize) -> Option<([usize; 2], usize)> {
        let place = self.first_new.partition_point(|&first| first <= node).checked_sub(1)?;
        let (ends, _) = self.edges.get_index(place)?;
        Some((*ends, node - self.first_new[place] + 1))
    }
}
