//! Mesh lines that bound the blocks of a structured mesh: boundaries, interfaces, and lines through nodes that are
//! irregular or that the deck refers to.

use super::quadrilaterals::{Quadrilaterals, Regions};

/// Edges on lines that remain.
pub struct KeptLines {
    /// Whether each edge remains.
    pub edges: Vec<bool>,
}

impl KeptLines {
    /// Finds the lines from boundaries, interfaces of regions and given nodes.
    pub fn find(quads: &Quadrilaterals<'_>, regions: &Regions, fixed: &[usize]) -> KeptLines {
        let is_interface =
            |sides: &Vec<(usize, usize)>| sides.len() != 2 || regions.get(&sides[0].0) != regions.get(&sides[1].0);
        let mut lines = KeptLines { edges: quads.edges.values().map(is_interface).collect() };
        let at_fixed = fixed.iter().filter_map(|node| quads.at_node.get(node)).flatten();
        at_fixed.for_each(|&edge| lines.edges[edge] = true);
        lines.continue_lines(quads);
        lines
    }

    /// Continues lines that end at a node, until no line ends inside the mesh.
    fn continue_lines(&mut self, quads: &Quadrilaterals<'_>) {
        let mut open: Vec<usize> = quads.at_node.keys().copied().collect();
        while let Some(node) = open.pop() {
            for edge in self.missing(quads, node) {
                if !std::mem::replace(&mut self.edges[edge], true)
                    && let Some((ends, _)) = quads.edges.get_index(edge)
                {
                    open.extend(ends);
                }
            }
        }
    }

    /// Returns the edges at a node that must remain because of its other edges.
    fn missing(&self, quads: &Quadrilaterals<'_>, node: usize) -> Vec<usize> {
        let edges = &quads.at_node[&node];
        let kept_edges: Vec<usize> = edges.iter().copied().filter(|&edge| self.edges[edge]).collect();
        let boundary: Vec<usize> = edges.iter().copied().filter(|&edge| quads.edges[edge].len() == 1).collect();
        match (boundary.len(), edges.len()) {
            (0, 4) => match kept_edges[..] {
                [] => Vec::new(),
                [edge] => edges.iter().copied().filter(|&e| e != edge && !quads.share_element([e, edge])).collect(),
                [a, b] if !quads.share_element([a, b]) => Vec::new(),
                _ => edges.clone(),
            },
            (2, 2) => Vec::new(),
            (2, 3) if !quads.has_kink(node, [boundary[0], boundary[1]]) => Vec::new(),
            _ => edges.clone(),
        }
    }
}
