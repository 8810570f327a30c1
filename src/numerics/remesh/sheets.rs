//! Sheets and webs of a body that have become thinner than a fraction of its elements, and loose fragments. They are left out of
//! a new mesh, which may then consist of more parts than the old one.

use super::BodyMesh;
use super::outline::{BoundaryEdge, boundary_edges};
use crate::kernel::box_grid::BoxGrid;
use crate::kernel::disjoint_sets::DisjointSets;
use crate::kernel::lanes::InlineMap;
use crate::kernel::quad;
use crate::kernel::shape::{distance, twice_area};
use crate::kernel::sorted_boxes::bounding_box;

/// Smallest length of a sheet along the outline, in units of the wanted edge: tips of wedges are no sheets.
const SHORTEST: f64 = 1.0;
/// Largest cosine between the outer normals of the two faces of a sheet.
const FACING: f64 = -0.5;
/// Smallest area of a part that remains, in units of the square of the wanted edge.
const SMALLEST: f64 = 0.25;
/// Attempts to separate parts that touch in a node.
const ATTEMPTS: usize = 10;

/// Returns which elements form sheets that are thinner than a fraction of the wanted edge, or are loose, and what they hold: small
/// parts, and elements at nodes in which the rest would touch itself. Elements with a node that is `needed` stay. `None` if nothing can be
/// left out.
pub fn thin_elements(
    mesh: &BodyMesh,
    fraction: f64,
    is_loose: impl Fn(usize) -> bool,
    needed: impl Fn(u32) -> bool,
) -> Option<Vec<bool>> {
    if fraction == 0.0 {
        return None;
    }
    let is_needed = |e: usize| mesh.quads[e].iter().any(|n| needed(*n));
    let mut thin: Vec<bool> = (0..mesh.quads.len()).map(|e| is_loose(e) && !is_needed(e)).collect();
    for edge in thin_edges(mesh, fraction) {
        thin[edge.side.0 as usize] |= !is_needed(edge.side.0 as usize);
    }
    if !thin.contains(&true) {
        return None;
    }
    for _ in 0..ATTEMPTS {
        leave_out_small_parts(mesh, &mut thin);
        if !separate(mesh, &mut thin) {
            let loses = (0..thin.len()).any(|e| thin[e] && is_needed(e));
            return (thin.contains(&false) && !loses).then_some(thin);
        }
    }
    None
}

/// Returns the edges of the outline that face another part of the outline, through the body, within the limit of thickness, in
/// runs that are long enough.
fn thin_edges(mesh: &BodyMesh, fraction: f64) -> Vec<BoundaryEdge> {
    let place = |n: u32| mesh.points[n as usize];
    let on_axis = |edge: &BoundaryEdge| edge.ends.iter().all(|n| place(*n)[0] <= 0.0);
    let edges: Vec<BoundaryEdge> = boundary_edges(&mesh.quads).into_iter().filter(|edge| !on_axis(edge)).collect();
    let ends: Vec<[[f64; 2]; 2]> = edges.iter().map(|edge| edge.ends.inline_map(place)).collect();
    let boxes = BoxGrid::new(ends.iter().map(|ends| bounding_box(*ends)).zip(0..));
    let is_thin = |at: usize| {
        let reach = fraction * mesh.sizes[edges[at].side.0 as usize];
        let (from, inward) = ray(ends[at]);
        let to = [0, 1].inline_map(|axis: usize| from[axis] + reach * inward[axis]);
        let mut meets = false;
        boxes.near(bounding_box([from, to]), 0.0, |other| {
            let other = other as usize;
            let shares_node = edges[other].ends.iter().any(|n| edges[at].ends.contains(n));
            let (_, facing) = ray(ends[other]);
            let cosine = inward[0] * facing[0] + inward[1] * facing[1];
            meets |= !shares_node && cosine < FACING && crosses([from, to], ends[other]);
        });
        meets
    };
    let thin: Vec<bool> = (0..edges.len()).map(is_thin).collect();
    // Runs of thin edges are connected by common nodes.
    let mut runs = DisjointSets::new(mesh.points.len());
    let members: Vec<BoundaryEdge> =
        edges.into_iter().zip(thin).filter(|(_, thin)| *thin).map(|(edge, _)| edge).collect();
    members.iter().for_each(|edge| runs.unite(edge.ends[0] as usize, edge.ends[1] as usize));
    let mut lengths = vec![0.0; mesh.points.len()];
    for edge in &members {
        let [a, b] = edge.ends.inline_map(place);
        lengths[runs.representative(edge.ends[0] as usize)] += distance(a, b) / mesh.sizes[edge.side.0 as usize];
    }
    let mut is_long = |edge: &BoundaryEdge| lengths[runs.representative(edge.ends[0] as usize)] >= SHORTEST;
    members.into_iter().filter(|edge| is_long(edge)).collect()
}

/// Returns the middle of an edge and the direction into the body, which is on its left.
fn ray([a, b]: [[f64; 2]; 2]) -> ([f64; 2], [f64; 2]) {
    let (length, along) = (distance(a, b), [b[0] - a[0], b[1] - a[1]]);
    let middle = [0, 1].inline_map(|axis: usize| 0.5 * (a[axis] + b[axis]));
    (middle, if length > 0.0 { [-along[1] / length, along[0] / length] } else { [0.0; 2] })
}

/// Returns whether two lines cross or touch.
fn crosses([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> bool {
    let [from, to] = [c, d].inline_map(|p| twice_area([a, b, p]));
    let [own, end] = [a, b].inline_map(|p| twice_area([c, d, p]));
    from * to <= 0.0 && own * end <= 0.0
}

/// Leaves out connected parts of the rest that are too small.
fn leave_out_small_parts(mesh: &BodyMesh, thin: &mut [bool]) {
    let mut parts = DisjointSets::new(mesh.points.len());
    let rest: Vec<usize> = (0..thin.len()).filter(|e| !thin[*e]).collect();
    for e in &rest {
        let quad = mesh.quads[*e];
        quad[1..].iter().for_each(|n| parts.unite(quad[0] as usize, *n as usize));
    }
    let mut areas = vec![0.0; mesh.points.len()];
    let mut part = |e: usize| parts.representative(mesh.quads[e][0] as usize);
    for e in &rest {
        let corners = mesh.corners(&mesh.quads[*e]);
        let area = quad::section(corners.inline_map(|p| p[0]), corners.inline_map(|p| p[1]));
        areas[part(*e)] += area / (mesh.sizes[*e] * mesh.sizes[*e]);
    }
    for e in rest {
        thin[e] = areas[part(e)] < SMALLEST;
    }
}

/// Leaves out the elements at nodes in which the outline of the rest touches itself. Returns whether there are any.
fn separate(mesh: &BodyMesh, thin: &mut [bool]) -> bool {
    let rest: Vec<usize> = (0..thin.len()).filter(|e| !thin[*e]).collect();
    let quads: Vec<[u32; 4]> = rest.iter().map(|e| mesh.quads[*e]).collect();
    let mut begins = vec![0_u8; mesh.points.len()];
    boundary_edges(&quads).iter().for_each(|edge| begins[edge.ends[0] as usize] += 1);
    let mut any = false;
    for (e, quad) in rest.into_iter().zip(quads) {
        if quad.iter().any(|n| begins[*n as usize] > 1) {
            (thin[e], any) = (true, true);
        }
    }
    any
}

#[cfg(test)]
mod tests {
    use super::thin_elements;
    use crate::remesh::BodyMesh;

    /// Returns two blocks of 4 by 4 squares with a web of the given thickness and of four squares' length between them.
    fn blocks(thickness: f64) -> BodyMesh {
        let mut mesh = BodyMesh::default();
        let square = |mesh: &mut BodyMesh, [r, z]: [f64; 2], height: f64| {
            let corners = [[r, z], [r + 1.0, z], [r + 1.0, z + height], [r, z + height]];
            let nodes = corners.map(|corner| {
                let known = mesh.points.iter().position(|point| *point == corner);
                known.unwrap_or_else(|| {
                    mesh.points.push(corner);
                    mesh.points.len() - 1
                }) as u32
            });
            mesh.quads.push(nodes);
            mesh.sizes.push(1.0);
        };
        for first in [1.0, 9.0] {
            for (i, height) in [1.0, thickness, 2.0 - thickness, 1.0].into_iter().enumerate() {
                let z = [0.0, 1.0, 1.0 + thickness, 3.0][i];
                (0..4).for_each(|j| square(&mut mesh, [first + f64::from(j), z], height));
            }
        }
        (0..4).for_each(|j| square(&mut mesh, [5.0 + f64::from(j), 1.0], thickness));
        mesh
    }

    #[test]
    fn a_thin_web_is_left_out_and_a_thick_one_is_not() {
        let thin = thin_elements(&blocks(0.05), 0.1, |_| false, |_| false).expect("a web");
        assert_eq!((thin.iter().filter(|thin| **thin).count(), thin.iter().rposition(|thin| !thin)), (4, Some(31)));
        assert_eq!(thin_elements(&blocks(0.2), 0.1, |_| false, |_| false), None);
        assert_eq!(thin_elements(&blocks(0.05), 0.0, |_| false, |_| false), None);
        // An element with a needed node stays, the others of the web are left out.
        let last = blocks(0.05).quads[35][2];
        assert!(thin_elements(&blocks(0.05), 0.1, |_| false, |n| n == last).is_some_and(|thin| !thin[35] && thin[34]));
    }

    /// The tip of a wedge has no thickness, but is no sheet.
    #[test]
    fn the_tip_of_a_wedge_remains() {
        let mut mesh = BodyMesh::default();
        for i in 0..=10 {
            let r = 1.0 + f64::from(i);
            mesh.points.extend([[r, 0.0], [r, 0.15 * f64::from(i)]]);
        }
        mesh.points[1][1] = 0.0;
        mesh.quads.push([0, 2, 3, 0].map(|n| n as u32));
        mesh.quads[0] = [0, 2, 3, 3];
        for i in 1..10 {
            mesh.quads.push([2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1]);
        }
        mesh.sizes = vec![1.0; 10];
        assert_eq!(thin_elements(&mesh, 0.1, |_| false, |_| false), None);
    }
}
