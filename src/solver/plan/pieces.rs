//! Connected parts of a mesh.

use std::collections::HashMap;

use crate::model::Mesh;

/// Splits elements into parts that are connected by common nodes, in the order of their first elements.
pub(super) fn pieces(mesh: &Mesh, elements: &[usize]) -> Vec<Vec<usize>> {
    let mut root: Vec<usize> = (0..mesh.points.len()).collect();
    fn find(root: &mut [usize], mut n: usize) -> usize {
        while root[n] != n {
            root[n] = root[root[n]];
            n = root[n];
        }
        n
    }
    for &e in elements {
        let nodes = &mesh.elements[e].nodes;
        for &n in &nodes[1..] {
            let (a, b) = (find(&mut root, nodes[0]), find(&mut root, n));
            root[b] = a;
        }
    }
    let mut by_root: HashMap<usize, usize> = HashMap::new();
    let mut pieces: Vec<Vec<usize>> = Vec::new();
    for &e in elements {
        let key = find(&mut root, mesh.elements[e].nodes[0]);
        let at = *by_root.entry(key).or_insert_with(|| {
            pieces.push(Vec::new());
            pieces.len() - 1
        });
        pieces[at].push(e);
    }
    pieces
}
