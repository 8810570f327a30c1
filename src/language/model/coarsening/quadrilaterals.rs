//! Quadrilaterals of a mesh with their edges.

use std::collections::{BTreeMap, HashMap};

use indexmap::IndexMap;

use crate::kernel::lists::sorted_pair;
use crate::model::types::Mesh;

/// Neighbours of the quadrilaterals of a mesh.
pub struct Quadrilaterals<'m> {
    pub mesh: &'m Mesh,
    /// Indices of the quadrilaterals, ascending.
    pub elements: Vec<usize>,
    /// Edges, the lower node first, with the elements at them and their sides from 0 to 3.
    pub edges: IndexMap<[usize; 2], Vec<(usize, usize)>>,
    /// Edges at each node, as places in `edges`.
    pub at_node: BTreeMap<usize, Vec<usize>>,
}

impl<'m> Quadrilaterals<'m> {
    /// Collects the quadrilaterals of a mesh.
    pub fn new(mesh: &'m Mesh) -> Quadrilaterals<'m> {
        let is_quadrilateral = |&e: &usize| mesh.elements[e].kind.is_solid();
        let elements: Vec<usize> = (0..mesh.elements.len()).filter(is_quadrilateral).collect();
        let mut edges: IndexMap<[usize; 2], Vec<(usize, usize)>> = IndexMap::new();
        for &element in &elements {
            for side in 0..4 {
                edges.entry(ends(mesh, element, side)).or_default().push((element, side));
            }
        }
        let mut at_node: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (place, ends) in edges.keys().enumerate() {
            ends.iter().for_each(|&node| at_node.entry(node).or_default().push(place));
        }
        Quadrilaterals { mesh, elements, edges, at_node }
    }

    /// Returns the place of the edge at a side of an element.
    pub fn edge(&self, element: usize, side: usize) -> usize {
        self.edges.get_index_of(&ends(self.mesh, element, side)).unwrap_or(0)
    }

    /// Returns the element and its side across a side of an element.
    pub fn neighbour(&self, element: usize, side: usize) -> Option<(usize, usize)> {
        self.edges[self.edge(element, side)].iter().copied().find(|other| other.0 != element)
    }

    /// Returns whether two edges have an element in common.
    pub fn share_element(&self, [a, b]: [usize; 2]) -> bool {
        self.edges[a].iter().any(|(element, _)| self.edges[b].iter().any(|(other, _)| other == element))
    }

    /// Returns whether the boundary turns by more than 30 degrees at a node between two edges.
    pub fn has_kink(&self, node: usize, edges: [usize; 2]) -> bool {
        let far = edges.map(|edge| self.edges.get_index(edge).map_or(node, |(ends, _)| ends[0] + ends[1] - node));
        turns(self.mesh, far[0], node, far[1])
    }
}

/// Cosine of the largest angle by which a line of merged edges may turn at a node, 30 degrees.
const STRAIGHT: f64 = 0.866;

/// Returns whether a line of nodes turns by more than 30 degrees at the middle one.
pub fn turns(mesh: &Mesh, from: usize, node: usize, to: usize) -> bool {
    let [a, b, c] = [from, node, to].map(|n| mesh.points[n]);
    let (u, v) = ([b[0] - a[0], b[1] - a[1]], [c[0] - b[0], c[1] - b[1]]);
    let lengths = (u[0] * u[0] + u[1] * u[1]) * (v[0] * v[0] + v[1] * v[1]);
    u[0] * v[0] + u[1] * v[1] < STRAIGHT * lengths.sqrt()
}

fn ends(mesh: &Mesh, element: usize, side: usize) -> [usize; 2] {
    let nodes = &mesh.elements[element].nodes;
    sorted_pair([nodes[side % nodes.len()], nodes[(side + 1) % nodes.len()]])
}

/// Regions that must not be merged with each other, by element.
pub type Regions = HashMap<usize, Vec<usize>>;
