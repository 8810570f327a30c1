//! Chains of shells and rigid surface elements, and their merged elements.

use std::collections::{HashMap, HashSet};

use super::mesh::{CoarsenedMesh, CoarseningFault};
use super::quadrilaterals::{Regions, turns};
use crate::model::element_nodes::NodeIndices;
use crate::model::types::{Element, Mesh};

/// Nodes at which chains end.
pub struct ChainEnds<'a> {
    /// Regions that must not be merged with each other.
    pub regions: &'a Regions,
    /// Nodes that the deck refers to, ascending.
    pub fixed: &'a [usize],
    /// Nodes of solids, and whether each remains.
    pub of_solids: HashMap<usize, bool>,
}

/// Two-node elements of a mesh.
struct Lines<'a> {
    mesh: &'a Mesh,
    ends: &'a ChainEnds<'a>,
    all: Vec<usize>,
    /// Elements that begin, and that end, at each node.
    at_node: [HashMap<usize, Vec<usize>>; 2],
}

/// Merges chains of two-node elements; returns the chains that cannot be merged.
pub fn merge_chains(
    fine: &Mesh,
    factor: usize,
    ends: &ChainEnds<'_>,
    (mesh, merged): (&mut Mesh, &mut CoarsenedMesh),
) -> Vec<CoarseningFault> {
    let mut faults = Vec::new();
    for chain in Lines::new(fine, ends).chains() {
        let first = &fine.elements[chain[0]];
        if chain.len() % factor != 0 {
            let message = format!("a chain of {} elements cannot be merged by {factor}", chain.len());
            faults.push(CoarseningFault::new(message, format!("element {} of the chain", first.name), first.span));
            continue;
        }
        for parts in chain.chunks(factor) {
            let nodes = [fine.elements[parts[0]].nodes[0], fine.elements[parts[factor - 1]].nodes[1]];
            let element = Element { nodes: NodeIndices::from(&nodes[..]), ..fine.elements[parts[0]].clone() };
            merged.add(element, parts.to_vec(), mesh);
        }
    }
    faults
}

impl<'a> Lines<'a> {
    fn new(mesh: &'a Mesh, ends: &'a ChainEnds<'a>) -> Lines<'a> {
        let is_line = |&e: &usize| mesh.elements[e].kind.is_line();
        let lines: Vec<usize> = (0..mesh.elements.len()).filter(is_line).collect();
        let mut at_node = [HashMap::new(), HashMap::new()];
        for &line in &lines {
            for (at_node, &node) in at_node.iter_mut().zip(&mesh.elements[line].nodes) {
                at_node.entry(node).or_insert_with(Vec::new).push(line);
            }
        }
        Lines { mesh, ends, all: lines, at_node }
    }

    /// Returns the element that continues a chain after an element; `None` if the chain ends there.
    fn next(&self, element: usize) -> Option<usize> {
        let node = self.mesh.elements[element].nodes[1];
        let [begin, end] = self.at_node.each_ref().map(|at_node| at_node.get(&node));
        let (&[next], &[previous]) = (&begin?[..], &end?[..]) else { return None };
        let outer = [self.mesh.elements[previous].nodes[0], self.mesh.elements[next].nodes[1]];
        let ends_here = self.ends.fixed.binary_search(&node).is_ok()
            || self.ends.regions.get(&previous) != self.ends.regions.get(&next)
            || turns(self.mesh, outer[0], node, outer[1])
            || self.ends.of_solids.get(&node) == Some(&true);
        (!ends_here).then_some(next)
    }

    /// Returns all chains: first those with a first element, then closed ones.
    fn chains(&self) -> Vec<Vec<usize>> {
        let followers: HashSet<usize> = self.all.iter().filter_map(|&line| self.next(line)).collect();
        let (mut visited, mut chains) = (HashSet::new(), Vec::new());
        for &start in self.all.iter().filter(|line| !followers.contains(line)).chain(&self.all) {
            let mut chain = Vec::new();
            let mut next = Some(start);
            while let Some(element) = next.filter(|&element| visited.insert(element)) {
                chain.push(element);
                next = self.next(element);
            }
            if !chain.is_empty() {
                chains.push(chain);
            }
        }
        chains
    }
}
