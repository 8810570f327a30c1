//! Values between the nodes of a mesh, and material points that histories follow from mesh to mesh.

use super::BodyMesh;
use crate::kernel::box_grid::BoxGrid;
use crate::kernel::lanes::InlineMap;
use crate::kernel::shape::{halves, twice_area};
use crate::kernel::sorted_boxes::box_of;
use crate::state::archive::Persist;

/// A place in a triangle of nodes.
#[derive(Clone, Copy, Debug)]
pub struct PlaceInTriangle {
    /// Nodes of the body.
    pub nodes: [u32; 3],
    /// Share of each node in the value at the place; their sum is 1.
    pub shares: [f64; 3],
}

impl PlaceInTriangle {
    /// Returns the value at the place of a field with the given values at all nodes.
    pub fn value(&self, values: &[[f64; 2]]) -> [f64; 2] {
        let corners = self.nodes.inline_map(|n| values[n as usize]);
        [0, 1].inline_map(|i: usize| (0..3).map(|k| self.shares[k] * corners[k][i]).sum())
    }
}

/// Finds places in the triangles of a mesh; those outside are moved to the nearest element.
pub fn places_in_triangles(mesh: &BodyMesh, at: &[[f64; 2]]) -> Vec<PlaceInTriangle> {
    let triangles: Vec<_> = mesh.quads.iter().flat_map(|quad| triangles_of(mesh, quad)).collect();
    let boxes = BoxGrid::new(triangles.iter().map(|(_, corners)| box_of(corners)).zip(0..));
    let find = |place: [f64; 2]| {
        let mut reach = 0.0;
        let mut best = (f64::NEG_INFINITY, u32::MAX, [0.0; 3]);
        while best.1 == u32::MAX {
            boxes.near([place, place], reach, |t| {
                let weights = barycentric(triangles[t as usize].1, place);
                let least = weights[0].min(weights[1]).min(weights[2]);
                if least > best.0 || least == best.0 && t < best.1 {
                    best = (least, t, weights);
                }
            });
            reach = if reach > 0.0 { 2.0 * reach } else { 0.1 * mesh.sizes[0] };
        }
        let inside = best.2.inline_map(|w| w.max(0.0));
        let sum = inside[0] + inside[1] + inside[2];
        PlaceInTriangle { nodes: triangles[best.1 as usize].0, shares: inside.inline_map(|w| w / sum) }
    };
    at.iter().map(|place| find(*place)).collect()
}

/// Returns the values of a field of the nodes of a mesh at places; those outside take values of the nearest element.
pub fn interpolated(mesh: &BodyMesh, values: &[[f64; 2]], at: &[[f64; 2]]) -> Vec<[f64; 2]> {
    places_in_triangles(mesh, at).iter().map(|place| place.value(values)).collect()
}

/// Returns the nodes of the triangles of positive area that make up an element.
fn triangles_of(mesh: &BodyMesh, quad: &[u32; 4]) -> impl Iterator<Item = ([u32; 3], [[f64; 2]; 3])> {
    let places = mesh.corners(quad);
    let pair = halves(places).inline_map(|list| (list.inline_map(|i| quad[i]), list.inline_map(|i| places[i])));
    pair.into_iter().filter(|(_, corners)| twice_area(*corners) > 0.0)
}

fn barycentric([a, b, c]: [[f64; 2]; 3], p: [f64; 2]) -> [f64; 3] {
    let whole = twice_area([a, b, c]);
    [[p, b, c], [a, p, c], [a, b, p]].inline_map(|part| twice_area(part) / whole)
}

/// A material point that histories show in place of a node that a new mesh does not have.
#[derive(Clone, Debug, Default, PartialEq, Persist)]
pub struct TracerPoint {
    /// The node whose name it has.
    pub node: usize,
    /// Nodes between which it is.
    pub between: [usize; 3],
    /// Share of each node in its motion; their sum is 1.
    pub shares: [f64; 3],
    /// Place at the start of the analysis.
    pub start: [f64; 2],
    /// Its place relative to that between the nodes, so that the place is continuous at a new mesh.
    pub offset: [f64; 2],
}

impl TracerPoint {
    /// Returns the point of a node at a place of a new mesh. `shown` is where histories show it.
    pub fn new(
        node: usize,
        start: [f64; 2],
        shown: [f64; 2],
        (at, points): (PlaceInTriangle, &[[f64; 2]]),
    ) -> TracerPoint {
        let place = at.value(points);
        let offset = [0, 1].inline_map(|i: usize| shown[i] - place[i]);
        TracerPoint { node, between: at.nodes.inline_map(|n| n as usize), shares: at.shares, start, offset }
    }

    /// Returns the point in another numbering: `node` is the node whose name it has, `number` that of the others.
    #[must_use]
    pub fn renumbered(&self, node: usize, number: impl Fn(usize) -> usize) -> TracerPoint {
        TracerPoint { node, between: self.between.inline_map(number), ..self.clone() }
    }

    /// Returns the index of the point of a node in a list in the order of these nodes.
    pub fn index_in(list: &[TracerPoint], node: usize) -> Option<usize> {
        list.binary_search_by_key(&node, |point| point.node).ok()
    }

    /// Returns the value at the point of a quantity of nodes. The offset of a place is not included. Equation (18.11a).
    pub fn value(&self, of_node: impl Fn(usize) -> f64) -> f64 {
        (0..3).map(|k| self.shares[k] * of_node(self.between[k])).sum()
    }
}
