//! Elements that replace an element of which only some edges are divided into two parts: transitions between refined and
//! unchanged elements.
//!
//! A quadrilateral has an even number of divided sides ([`super::local`]). Two opposite sides give two quadrilaterals, two
//! adjacent sides three, around a node at the centre. Sides of children have the numbers of the sides of the parent that
//! they are on.

use crate::model::element_nodes::NodeIndices;
use crate::model::types::{ElementKind, Mesh};

/// Nodes of a child, and the sides that are on sides of its parent, as bits.
pub type ChildElement = (NodeIndices, u8);

/// Returns the number of new nodes inside an element whose sides `divided`, given as bits, are divided.
pub fn inner_count(kind: ElementKind, divided: u8) -> usize {
    usize::from(kind.is_solid() && kind.node_count() == 4 && corner_between(divided, 4).is_some())
}

/// Smallest sine of an angle between two sides of a convex element.
const SMALLEST_SINE: f64 = 1e-3;

/// Returns whether the angles of an element are between 0 and 180 degrees; sides without length are ignored.
pub fn is_convex(mesh: &Mesh, nodes: &[usize]) -> bool {
    let mut corners = nodes.to_vec();
    corners.dedup();
    if corners.first() == corners.last() {
        corners.pop();
    }
    let point = |at: usize| mesh.points[corners[at % corners.len()]];
    (0..corners.len()).all(|at| {
        let [a, b, c] = [point(at), point(at + 1), point(at + 2)];
        let (u, v) = ([b[0] - a[0], b[1] - a[1]], [c[0] - b[0], c[1] - b[1]]);
        let lengths = ((u[0] * u[0] + u[1] * u[1]) * (v[0] * v[0] + v[1] * v[1])).sqrt();
        u[0] * v[1] - u[1] * v[0] > SMALLEST_SINE * lengths
    })
}

/// Returns the second one of two adjacent divided sides if no other side is divided; its first node is between both.
fn corner_between(divided: u8, count: usize) -> Option<usize> {
    (0..count).find(|&side| divided == 1 << side | 1 << ((side + count - 1) % count))
}

/// Returns the children of an element. `middle` returns the new node of a divided side, and `centre` is the new node inside
/// the element, if it has one.
pub fn children(nodes: &NodeIndices, divided: u8, middle: impl Fn(usize) -> usize, centre: usize) -> Vec<ChildElement> {
    let count = nodes.len();
    let middle = |side: usize| middle(side % count);
    let node = |at: usize| nodes[at % count];
    let element = |first: usize, list: &[usize], outer: &[usize]| child(count, first, list, outer);
    let corner = corner_between(divided, count);
    match (count, corner) {
        _ if divided == 0 => vec![(nodes.clone(), u8::MAX)],
        (4, Some(at)) => {
            // Numbers of nodes and sides are relative to the side before the corner.
            let start = at + 3;
            let [before, after] = [middle(start), middle(at)];
            vec![
                element(start, &[before, node(at), after, centre], &[0, 1]),
                element(start, &[node(start), before, centre, node(start + 3)], &[0, 3]),
                element(start, &[centre, after, node(start + 2), node(start + 3)], &[1, 2]),
            ]
        }
        (4, None) => {
            let start = usize::from(divided & 1 == 0);
            let [first, second] = [middle(start), middle(start + 2)];
            vec![
                element(start, &[node(start), first, second, node(start + 3)], &[0, 2, 3]),
                element(start, &[first, node(start + 1), node(start + 2), second], &[0, 1, 2]),
            ]
        }
        (_, Some(at)) => {
            let start = at + 2;
            let [before, after] = [middle(start), middle(at)];
            vec![
                element(start, &[before, node(at), after], &[0, 1]),
                element(start, &[node(start), before, after], &[0]),
                element(start, &[node(start), after, node(start + 2)], &[1, 2]),
            ]
        }
        (_, None) => {
            let start = divided.trailing_zeros() as usize;
            let new = middle(start);
            vec![
                element(start, &[node(start), new, node(start + 2)], &[0, 2]),
                element(start, &[new, node(start + 1), node(start + 2)], &[0, 1]),
            ]
        }
    }
}

/// Returns a child from its nodes and outer sides, both numbered from the side `first` of the parent.
fn child(count: usize, first: usize, list: &[usize], outer: &[usize]) -> ChildElement {
    let mut nodes = list.to_vec();
    nodes.rotate_right(first % count);
    let sides = outer.iter().map(|side| 1 << ((first + side) % count)).sum();
    (NodeIndices::from(&nodes[..]), sides)
}
