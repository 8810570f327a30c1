//! Connected parts of a mesh.

use std::collections::HashMap;

use crate::kernel::disjoint_sets::DisjointSets;
use crate::model::Mesh;

/// Splits elements into parts that are connected by common nodes, in the order of their first elements.
pub(super) fn pieces(mesh: &Mesh, elements: &[usize]) -> Vec<Vec<usize>> {
    let mut sets = DisjointSets::new(mesh.points.len());
    for &e in elements {
        let nodes = &mesh.elements[e].nodes;
        nodes[1..].iter().for_each(|&n| sets.unite(nodes[0], n));
    }
    let mut by_root: HashMap<usize, usize> = HashMap::new();
    let mut pieces: Vec<Vec<usize>> = Vec::new();
    for &e in elements {
        let key = sets.representative(mesh.elements[e].nodes[0]);
        let at = *by_root.entry(key).or_insert_with(|| {
            pieces.push(Vec::new());
            pieces.len() - 1
        });
        pieces[at].push(e);
    }
    pieces
}
