//! Parts of a domain that a change of the mesh concerns: nodes that move, the elements at them, and their neighbours.

use super::topology::DomainTopology;
use crate::kernel::chunks::ChunkLoops;
use crate::kernel::lists::Memory;

/// A domain, its active parts, and loops over these parts.
#[derive(Clone, Copy)]
pub(super) struct MeshChange<'a> {
    pub domain: &'a DomainTopology,
    pub active: &'a ActiveParts,
    pub loops: ChunkLoops,
}

/// Iterates over the marked members of a part of a list that begins at `start`.
#[inline(always)]
pub(super) fn marked<'a, T>(
    part: &'a mut [T],
    start: usize,
    marks: &'a [bool],
) -> impl Iterator<Item = (usize, &'a mut T)> {
    let members = part.iter_mut().enumerate().map(move |(at, member)| (start + at, member));
    members.filter(|(index, _)| marks[*index])
}

/// Nodes and elements that a change of the mesh concerns.
#[derive(Clone, Debug, Default, Memory)]
pub(super) struct ActiveParts {
    /// Whether each node moves.
    pub moves: Vec<bool>,
    /// Whether a corner of each element moves.
    pub changes: Vec<bool>,
    /// Whether each element changes or has a neighbour that changes.
    pub reads: Vec<bool>,
    /// Whether each node is a corner of an element that changes.
    pub nodes: Vec<bool>,
    /// Whether each edge belongs to an element that changes.
    pub edges: Vec<bool>,
}

impl ActiveParts {
    pub fn new(domain: &DomainTopology) -> ActiveParts {
        let (nodes, elements) = (domain.nodes.len(), domain.corners.len());
        ActiveParts {
            moves: vec![false; nodes],
            changes: vec![false; elements],
            reads: vec![false; elements],
            nodes: vec![false; nodes],
            edges: vec![false; domain.edges.len()],
        }
    }

    /// Finds the parts at nodes whose places differ. Returns whether a node moves.
    pub fn find(&mut self, domain: &DomainTopology, [start, end]: [&[[f64; 2]]; 2]) -> bool {
        let mut any = false;
        for ((moves, start), end) in self.moves.iter_mut().zip(start).zip(end) {
            *moves = start != end;
            any |= *moves;
        }
        if !any {
            return false;
        }
        for list in [&mut self.reads, &mut self.nodes, &mut self.edges] {
            list.fill(false);
        }
        for (e, corners) in domain.corners.iter().enumerate() {
            let changes = corners.iter().any(|n| self.moves[*n as usize]);
            self.changes[e] = changes;
            if changes {
                self.reads[e] = true;
                corners.iter().for_each(|n| self.nodes[*n as usize] = true);
                for side in &domain.sides[e] {
                    self.reads[side.beside as usize] = true;
                    self.edges[side.edge as usize] = true;
                }
            }
        }
        true
    }
}
