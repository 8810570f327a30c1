//! Order of elements and nodes in the solver, for locality of memory access. Output uses the order of the deck.

use crate::kernel::lists::sorted_unique;
use crate::model::Mesh;
use crate::plan::MeshIndexMap;

/// Mean distance between two elements of a node, divided by the square root of the number of elements, above which
/// elements are reordered. A square mesh numbered by rows has 0.5.
const SCATTERED: f64 = 4.0;
/// Distance between elements below which no reordering is needed, because their data remain in the first-level cache.
const NEAR: f64 = 256.0;

/// Orders elements so that neighbours are close: keeps the given order unless it is scattered, otherwise sorts along a
/// Z-order curve (G. M. Morton 1966).
pub fn in_order(elements: Vec<usize>, mesh: &Mesh) -> Vec<usize> {
    let limit = NEAR + SCATTERED * (elements.len() as f64).sqrt();
    // Distances are below the number of elements.
    let is_short = elements.len() as f64 <= limit;
    if is_short || mean_distance(&elements, mesh) <= limit { elements } else { along_curve(elements, mesh) }
}

/// Returns the mean distance, in the list, between consecutive elements of a node.
fn mean_distance(elements: &[usize], mesh: &Mesh) -> f64 {
    let mut last = vec![u32::MAX; mesh.points.len()];
    let (mut sum, mut count) = (0, 0_usize);
    for (at, &element) in elements.iter().enumerate() {
        for &node in &mesh.elements[element].nodes {
            let previous = std::mem::replace(&mut last[node], at as u32);
            if previous != u32::MAX {
                (sum, count) = (sum + at - previous as usize, count + 1);
            }
        }
    }
    sum as f64 / count.max(1) as f64
}

/// Sorts elements along a Z-order curve by their first corners, on a square grid of 2^16 x 2^16 cells.
fn along_curve(mut elements: Vec<usize>, mesh: &Mesh) -> Vec<usize> {
    let first_corner = |element: usize| mesh.points[mesh.elements[element].nodes[0]];
    let bound = |axis: usize, pick: fn(f64, f64) -> f64| elements.iter().map(|&e| first_corner(e)[axis]).reduce(pick);
    let [from, to] = [f64::min, f64::max].map(|pick| [0, 1].map(|axis| bound(axis, pick).unwrap_or_default()));
    let extent = (to[0] - from[0]).max(to[1] - from[1]);
    let per = if extent > 0.0 { f64::from(u16::MAX) / extent } else { 0.0 };
    elements.sort_by_cached_key(|&e| {
        let [r, z] = [0, 1].map(|axis| ((first_corner(e)[axis] - from[axis]) * per) as u16);
        spread(r) | spread(z) << 1
    });
    elements
}

/// Inserts a zero before each bit of a number.
fn spread(number: u16) -> u32 {
    let mut bits = u32::from(number);
    for (shift, mask) in [(8, 0x00ff_00ff), (4, 0x0f0f_0f0f), (2, 0x3333_3333), (1, 0x5555_5555)] {
        bits = (bits | bits << shift) & mask;
    }
    bits
}

/// Returns the solver node of each mesh node. Nodes are in the order of their last element, so that nodal forces are
/// summed while they are in the cache; nodes without elements are last. The map is in the order of the mesh.
pub fn nodes(elements: impl Iterator<Item = usize>, bare: Vec<usize>, mesh: &Mesh) -> MeshIndexMap<usize> {
    let mut last = vec![0_u32; mesh.points.len()];
    let mut touched = Vec::new();
    for (at, element) in elements.enumerate() {
        for &node in &mesh.elements[element].nodes {
            if last[node] == 0 {
                touched.push(node);
            }
            last[node] = at as u32 + 1;
        }
    }
    // Stable sort: nodes with the same last element keep the order of their first one.
    touched.sort_by_key(|&node| last[node]);
    let nodes_without_elements: Vec<usize> = sorted_unique(bare.into_iter().filter(|&node| last[node] == 0));
    touched.extend(nodes_without_elements);
    let mut places: Vec<(usize, usize)> = touched.into_iter().enumerate().map(|(i, node)| (node, i)).collect();
    places.sort_unstable();
    places.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::{in_order, mean_distance, nodes, spread};
    use crate::model::{CopyOnWrite, ElementKind, Mesh, Model};

    /// Returns a square mesh of n by n elements, numbered by rows, and its elements in a scattered order.
    fn square(n: usize) -> (CopyOnWrite<Mesh>, Vec<usize>) {
        let mut model = Model::default();
        for i in 0..(n + 1) * (n + 1) {
            model.node((i % (n + 1)) as f64, (i / (n + 1)) as f64);
        }
        for e in 0..n * n {
            let first = e % n + e / n * (n + 1);
            model.element(ElementKind::Cax4r, &[first, first + 1, first + n + 2, first + n + 1]);
        }
        (model.mesh, (0..n * n).map(|e| (e * 7919) % (n * n)).collect())
    }

    #[test]
    fn spread_inserts_zeros_between_bits() {
        assert_eq!((spread(0b1011), spread(u16::MAX)), (0b100_0101, 0x5555_5555));
    }

    #[test]
    fn ordered_rows_are_kept_and_scattered_elements_are_sorted() {
        let n = 100;
        let (mesh, scattered) = square(n);
        let rows: Vec<usize> = (0..n * n).collect();
        assert_eq!(in_order(rows.clone(), &mesh), rows);
        let mut together = in_order(scattered.clone(), &mesh);
        let [before, after] = [&scattered, &together].map(|list| mean_distance(list, &mesh));
        assert!(before > 10.0 * n as f64 && after < n as f64, "{before} {after}");
        together.sort_unstable();
        assert_eq!(together, rows);
    }

    #[test]
    fn nodes_follow_the_elements_that_complete_them() {
        let (mut mesh, _) = square(2);
        mesh.points.push([9.0, 9.0]);
        // Rows of three nodes, then a node without element that is given twice.
        let places = nodes([3, 2, 1, 0].into_iter(), vec![9, 9, 4], &mesh);
        let order: Vec<usize> = (0..9).map(|node| places[&node]).collect();
        // Nodes by their last element: 8; 7 and 6; 5 and 2; 4, 3, 1 and 0.
        assert_eq!(order, [8, 7, 4, 6, 5, 3, 2, 1, 0]);
        assert!(places.keys().is_sorted() && places[&9] == 9);
    }
}
