//! Outline of a body: loops of boundary edges, and their division into edges of given lengths.

use rustc_hash::FxHashMap;

use super::BodyMesh;
use crate::kernel::lanes::InlineMap;
use crate::kernel::shape::distance;

/// Cosine of the change of direction from which on a boundary node is a corner, 30 degrees.
const CORNER: f64 = 0.866_025_403_784_438_6;
/// Corners nearer to each other than this fraction of the edge length become one.
const NEAR: f64 = 0.5;
/// Fraction of an edge within which a new node takes the place of an old one.
const SNAP: f64 = 0.3;

/// An edge on the boundary; the body is on its left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoundaryEdge {
    /// Nodes of the body.
    pub ends: [u32; 2],
    /// Index of the element, and number of its side from 0.
    pub side: (u32, u8),
    /// Whether it is not divided again.
    pub is_fixed: bool,
}

/// A node of the divided outline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutlinePoint {
    /// Place `[r, z]`.
    pub place: [f64; 2],
    /// The two old nodes between which it is, twice the same at an old node.
    pub parents: [u32; 2],
    /// Old side on which the edge to the next point of the loop begins.
    pub side: (u32, u8),
}

/// Returns the boundary edges of elements, in the order of their nodes.
pub fn boundary_edges(quads: &[[u32; 4]]) -> Vec<BoundaryEdge> {
    let mut open: FxHashMap<[u32; 2], BoundaryEdge> = FxHashMap::default();
    for (e, quad) in quads.iter().enumerate() {
        for side in 0..4 {
            let ends = [quad[side], quad[(side + 1) % 4]];
            if ends[0] != ends[1] && open.remove(&[ends[1], ends[0]]).is_none() {
                open.insert(ends, BoundaryEdge { ends, side: (e as u32, side as u8), is_fixed: false });
            }
        }
    }
    let mut edges: Vec<BoundaryEdge> = open.into_values().collect();
    edges.sort_unstable_by_key(|edge| edge.ends);
    edges
}

/// Returns the closed loops of boundary edges; `None` if the boundary touches itself in a node.
pub fn loops(mesh: &BodyMesh) -> Option<Vec<Vec<BoundaryEdge>>> {
    let edges = boundary_edges(&mesh.quads);
    if edges.windows(2).any(|pair| pair[0].ends[0] == pair[1].ends[0]) {
        return None;
    }
    let mut used = vec![false; edges.len()];
    let mut all_loops = Vec::new();
    for first in 0..edges.len() {
        let (mut list, mut current) = (Vec::new(), first);
        while !std::mem::replace(&mut used[current], true) {
            list.push(edges[current]);
            current = edges.binary_search_by_key(&edges[current].ends[1], |edge| edge.ends[0]).ok()?;
        }
        if !list.is_empty() {
            all_loops.push(list);
        }
    }
    Some(all_loops)
}

/// Divides a loop into edges of about `factor` times the sizes of the elements. Corners, the nodes that are `kept`, and fixed
/// edges remain; the number of edges between two remaining nodes is a multiple of `multiple`, except between fixed edges. A
/// loop that is too short for three edges keeps all its nodes.
pub fn divide(
    mesh: &BodyMesh,
    edges: &[BoundaryEdge],
    kept: &[bool],
    (factor, multiple): (f64, usize),
) -> Vec<OutlinePoint> {
    let starts = ends_of_runs(mesh, edges, kept);
    let mut points = Vec::new();
    for (i, &start) in starts.iter().enumerate() {
        let end = if i + 1 < starts.len() { starts[i + 1] } else { starts[0] + edges.len() };
        let run: Vec<BoundaryEdge> = (start..end).map(|at| edges[at % edges.len()]).collect();
        if run[0].is_fixed {
            points.extend(run.iter().map(|edge| old_node(mesh, edge)));
            continue;
        }
        divide_run(mesh, &run, (factor, multiple), &mut points);
    }
    if points.len() < 3 {
        return edges.iter().map(|edge| old_node(mesh, edge)).collect();
    }
    points
}

/// Returns the positions of nodes that must remain, at least one; of a run of fixed edges only the ends.
fn ends_of_runs(mesh: &BodyMesh, edges: &[BoundaryEdge], kept: &[bool]) -> Vec<usize> {
    let count = edges.len();
    let sharpness = |at: usize| cosine_between(mesh, [&edges[(at + count - 1) % count], &edges[at]]);
    let fixed_edges = |at: usize| [(at + count - 1) % count, at].inline_map(|i| edges[i].is_fixed);
    let is_kept = |at: usize| match fixed_edges(at) {
        [true, true] => false,
        [false, false] => kept[edges[at].ends[0] as usize],
        _ => true,
    };
    let is_free_corner = |at: &usize| fixed_edges(*at) == [false; 2] && !is_kept(*at) && is_corner(sharpness(*at));
    let mut corners: Vec<usize> = (0..count).filter(is_free_corner).collect();
    corners.sort_by(|a, b| sharpness(*a).total_cmp(&sharpness(*b)).then(a.cmp(b)));
    let mut positions: Vec<usize> = (0..count).filter(|&at| is_kept(at)).collect();
    for corner in corners {
        let point_at = |at: usize| mesh.points[edges[at].ends[0] as usize];
        let size = mesh.sizes[edges[corner].side.0 as usize];
        if positions.iter().all(|&other| distance(point_at(corner), point_at(other)) > NEAR * size) {
            positions.push(corner);
        }
    }
    if positions.is_empty() {
        positions.push(0);
    }
    positions.sort_unstable();
    positions
}

/// Returns whether two edges with this cosine between their directions have a corner between them.
pub(super) fn is_corner(cosine: f64) -> bool {
    cosine < CORNER
}

/// Returns the cosine between the directions of two edges.
pub(super) fn cosine_between(mesh: &BodyMesh, pair: [&BoundaryEdge; 2]) -> f64 {
    let [a, b] = pair.inline_map(|edge| {
        let [from, to] = edge.ends.inline_map(|n| mesh.points[n as usize]);
        [to[0] - from[0], to[1] - from[1]]
    });
    let lengths = ((a[0] * a[0] + a[1] * a[1]) * (b[0] * b[0] + b[1] * b[1])).sqrt();
    if lengths > 0.0 { (a[0] * b[0] + a[1] * b[1]) / lengths } else { 1.0 }
}

/// Returns the node at which an edge begins.
fn old_node(mesh: &BodyMesh, edge: &BoundaryEdge) -> OutlinePoint {
    let node = edge.ends[0];
    OutlinePoint { place: mesh.points[node as usize], parents: [node; 2], side: edge.side }
}

/// Divides the edges between two nodes that remain; the last node is the first one of the next run.
fn divide_run(mesh: &BodyMesh, run: &[BoundaryEdge], (factor, multiple): (f64, usize), points: &mut Vec<OutlinePoint>) {
    // Lengths in units of the wanted edge, summed up to the start of each edge.
    let mut sums = vec![0.0];
    for edge in run {
        let [a, b] = edge.ends.inline_map(|n| mesh.points[n as usize]);
        let size = factor * mesh.sizes[edge.side.0 as usize];
        sums.push(sums[sums.len() - 1] + distance(a, b) / size);
    }
    let total = sums[run.len()];
    let count = multiple * ((total / multiple as f64).round() as usize).max(1);
    let step = total / count as f64;
    for i in 0..count {
        let target_length = i as f64 * step;
        let nearest = sums.partition_point(|sum| *sum < target_length);
        let nodes = [nearest.saturating_sub(1), nearest].into_iter().filter(|at| *at < run.len());
        let snapped = nodes.filter(|&at| (at > 0 || i == 0) && (sums[at] - target_length).abs() <= SNAP * step);
        if let Some(at) =
            snapped.min_by(|a, b| (sums[*a] - target_length).abs().total_cmp(&(sums[*b] - target_length).abs()))
        {
            points.push(old_node(mesh, &run[at]));
            continue;
        }
        let edge_index = (sums.partition_point(|sum| *sum <= target_length) - 1).min(run.len() - 1);
        let share = (target_length - sums[edge_index]) / (sums[edge_index + 1] - sums[edge_index]);
        let [a, b] = run[edge_index].ends.inline_map(|n| mesh.points[n as usize]);
        let point = [0, 1].inline_map(|k: usize| a[k] + share * (b[k] - a[k]));
        points.push(OutlinePoint { place: point, parents: run[edge_index].ends, side: run[edge_index].side });
    }
}

#[cfg(test)]
mod tests {
    use super::{divide, loops};
    use crate::remesh::BodyMesh;

    /// Returns a rectangle of n by m elements.
    fn block(n: u32, m: u32, kept: impl Fn(u32, u32) -> bool) -> (BodyMesh, Vec<bool>) {
        let mut mesh = BodyMesh::default();
        let mut keep = Vec::new();
        for j in 0..=m {
            for i in 0..=n {
                mesh.points.push([f64::from(i), f64::from(j)]);
                keep.push(kept(i, j));
            }
        }
        for j in 0..m {
            for i in 0..n {
                let a = i + j * (n + 1);
                mesh.quads.push([a, a + 1, a + n + 2, a + n + 1]);
                mesh.sizes.push(1.0);
            }
        }
        (mesh, keep)
    }

    #[test]
    fn a_uniform_outline_keeps_its_nodes() {
        let (mesh, kept_nodes) = block(4, 6, |_, _| false);
        let all_loops = loops(&mesh).unwrap_or_default();
        assert_eq!((all_loops.len(), all_loops[0].len()), (1, 20));
        let points = divide(&mesh, &all_loops[0], &kept_nodes, (1.0, 1));
        assert_eq!(points.len(), 20);
        assert!(points.iter().all(|p| p.parents[0] == p.parents[1]));
    }

    #[test]
    fn kept_nodes_remain_and_new_nodes_are_on_old_edges() {
        let (mesh, kept_nodes) = block(5, 8, |i, j| i == 5 && j == 3);
        let all_loops = loops(&mesh).unwrap_or_default();
        let points = divide(&mesh, &all_loops[0], &kept_nodes, (1.3, 1));
        assert!(points.iter().any(|p| p.place == [5.0, 3.0] && p.parents == [23, 23]));
        let is_on_edge = |p: [f64; 2]| p[0] == 0.0 || p[0] == 5.0 || p[1] == 0.0 || p[1] == 8.0;
        assert!(points.iter().all(|p| is_on_edge(p.place)));
    }
}
