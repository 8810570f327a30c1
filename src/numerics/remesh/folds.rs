//! Repair of outlines that cross themselves: parts of a body that overlap a little are moved apart, and folds, small loops
//! between two edges that cross, are cut off.

use super::BodyMesh;
use super::outline::BoundaryEdge;
use crate::kernel::lanes::InlineMap;
use crate::kernel::shape::{distance, twice_area};

/// Deepest overlap that is removed by moving nodes, in units of the wanted edge.
const DEEPEST: f64 = 0.5;
/// Gap that remains, in units of the wanted edge.
const GAP: f64 = 1e-3;
/// Sweeps over all nodes that move parts apart.
const SWEEPS: usize = 8;
/// Largest number of edges in a fold.
const LONGEST: usize = 12;
/// Largest cosine of the angle between the outer normals of two edges that face each other.
const FACING: f64 = -0.1;

/// Repairs closed loops of edges. Nodes of the boundary move into the body; those that are `kept` stay.
pub(super) fn repair(mesh: &mut BodyMesh, loops: &mut [Vec<BoundaryEdge>], kept: &[bool]) {
    for _ in 0..SWEEPS {
        if !move_apart(mesh, loops, kept) {
            break;
        }
    }
    for edges in loops {
        while cut_fold(mesh, edges, kept) {}
    }
}

/// Moves nodes that are inside the body, and the edges that they have passed, apart. Returns whether any node moved.
fn move_apart(mesh: &mut BodyMesh, loops: &[Vec<BoundaryEdge>], kept: &[bool]) -> bool {
    let all_ends: Vec<[u32; 2]> = loops.iter().flatten().map(|edge| edge.ends).collect();
    let sizes: Vec<f64> = loops.iter().flatten().map(|edge| mesh.sizes[edge.side.0 as usize]).collect();
    let mut moves = false;
    for edges in loops {
        for at in 0..edges.len() {
            let previous_ends = edges[(at + edges.len() - 1) % edges.len()].ends;
            for (ends, size) in all_ends.iter().zip(&sizes) {
                moves |=
                    move_node(&mut mesh.points, [previous_ends, edges[at].ends], (*ends, *size), (&all_ends, kept));
            }
        }
    }
    moves
}

/// Moves a node between two edges out of the body if it has passed an edge, by half of its depth, and the edge as much.
fn move_node(
    points: &mut [[f64; 2]],
    [before, after]: [[u32; 2]; 2],
    (ends, size): ([u32; 2], f64),
    (all, kept): (&[[u32; 2]], &[bool]),
) -> bool {
    let own_nodes = [before[0], after[0], after[1]];
    if ends.iter().any(|n| own_nodes.contains(n)) {
        return false;
    }
    let [a, b] = ends.inline_map(|n| points[n as usize]);
    let p = points[after[0] as usize];
    let (length, along) = (distance(a, b), [b[0] - a[0], b[1] - a[1]]);
    let share = ((p[0] - a[0]) * along[0] + (p[1] - a[1]) * along[1]) / (length * length);
    // The body is on the left of its edges.
    let normal = [along[1] / length, -along[0] / length];
    let depth = -((p[0] - a[0]) * normal[0] + (p[1] - a[1]) * normal[1]);
    if !(0.0..=1.0).contains(&share) || !(0.0..DEEPEST * size).contains(&depth) {
        return false;
    }
    let [from, to] = [before[0], after[1]].inline_map(|n| points[n as usize]);
    let chord = [to[0] - from[0], to[1] - from[1]];
    let facing = (normal[0] * chord[1] - normal[1] * chord[0]) / distance(from, to);
    let middle = [0, 1].inline_map(|i: usize| p[i] + 0.5 * depth * normal[i]);
    if facing > FACING || windings(points, all, middle) < 2 {
        return false;
    }
    let is_free = |n: u32| f64::from(u8::from(!kept[n as usize] && points[n as usize][0] > 0.0));
    let weights = [(after[0], 1.0), (ends[0], share - 1.0), (ends[1], -share)].inline_map(|(n, w)| (n, w * is_free(n)));
    let sum: f64 = weights.iter().map(|(_, weight)| weight * weight).sum();
    if sum == 0.0 {
        return false;
    }
    for (n, weight) in weights {
        let step = weight / sum * (depth + GAP * size);
        let [r, z] = points[n as usize];
        // A node off the axis stays off it.
        points[n as usize] = [(r + step * normal[0]).max(0.5 * r), z + step * normal[1]];
    }
    true
}

/// Returns how often closed polygons wind around a place.
fn windings(points: &[[f64; 2]], edges: &[[u32; 2]], p: [f64; 2]) -> i32 {
    let turn = |ends: &[u32; 2]| {
        let [a, b] = ends.inline_map(|n| points[n as usize]);
        let is_left = twice_area([a, b, p]) > 0.0;
        i32::from(a[1] <= p[1] && b[1] > p[1] && is_left) - i32::from(a[1] > p[1] && b[1] <= p[1] && !is_left)
    };
    edges.iter().map(turn).sum()
}

/// Cuts off the shortest fold, if there is one: its edges and nodes leave the outline, except one node, which is put where
/// the edges cross.
fn cut_fold(mesh: &mut BodyMesh, edges: &mut Vec<BoundaryEdge>, kept: &[bool]) -> bool {
    let count = edges.len();
    for long in 2..=LONGEST.min(count.saturating_sub(4)) {
        for first in 0..count {
            let last = (first + long) % count;
            let [a, b] = [first, last].inline_map(|at| edges[at].ends.inline_map(|n| mesh.points[n as usize]));
            let Some(place) = crossing(a, b) else { continue };
            let nodes = || (1..=long).map(|i| edges[(first + i) % count].ends[0]);
            if nodes().any(|n| kept[n as usize]) {
                continue;
            }
            // A fold that encloses a gap larger than an element would fill it.
            let corners: Vec<[f64; 2]> = nodes().map(|n| mesh.points[n as usize]).collect();
            let twice: f64 = corners.windows(2).map(|pair| twice_area([place, pair[0], pair[1]])).sum();
            let size = mesh.sizes[edges[first].side.0 as usize];
            if 0.5 * twice < -size * size {
                continue;
            }
            let node = edges[first].ends[1];
            edges[last].ends[0] = node;
            mesh.points[node as usize] = place;
            edges.rotate_left(first);
            edges.drain(1..long);
            return true;
        }
    }
    false
}

/// Returns where two edges cross.
fn crossing([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> Option<[f64; 2]> {
    let [from, to] = [c, d].inline_map(|p| twice_area([a, b, p]));
    let [own, end] = [a, b].inline_map(|p| twice_area([c, d, p]));
    if from * to >= 0.0 || own * end >= 0.0 {
        return None;
    }
    let share = own / (own - end);
    // On the axis, rounding must not give a negative radius.
    Some([(a[0] + share * (b[0] - a[0])).max(0.0), a[1] + share * (b[1] - a[1])])
}

#[cfg(test)]
mod tests {
    use super::{crossing, repair};
    use crate::remesh::BodyMesh;
    use crate::remesh::outline::BoundaryEdge;

    /// Returns a closed outline with elements of size 1, and its edges.
    fn outline(points: &[[f64; 2]]) -> (BodyMesh, Vec<BoundaryEdge>) {
        let count = points.len() as u32;
        let mesh = BodyMesh { points: points.to_vec(), quads: Vec::new(), sizes: vec![1.0] };
        (mesh, (0..count).map(|i| BoundaryEdge { ends: [i, (i + 1) % count], side: (0, 0), is_fixed: false }).collect())
    }

    fn crosses(mesh: &BodyMesh, edges: &[BoundaryEdge]) -> bool {
        let ends_of = |edge: &BoundaryEdge| edge.ends.map(|n| mesh.points[n as usize]);
        edges.iter().any(|a| edges.iter().any(|b| crossing(ends_of(a), ends_of(b)).is_some()))
    }

    /// The two sides of a notch overlap at its tip: the notch ends where they cross.
    #[test]
    fn a_fold_at_the_tip_of_a_notch_is_cut_off() {
        let notch = [[5.4, 6.0], [5.1, 3.0], [4.8, 2.0], [5.3, 1.8], [4.9, 3.0], [4.6, 6.0]];
        let mut points = vec![[1.0, 0.0], [9.0, 0.0], [9.0, 6.0]];
        points.extend(notch);
        points.push([1.0, 6.0]);
        let (mut mesh, edges) = outline(&points);
        assert!(crosses(&mesh, &edges));
        let mut loops = [edges];
        repair(&mut mesh, &mut loops, &vec![false; points.len()]);
        assert!(!crosses(&mesh, &loops[0]) && loops[0].len() < points.len(), "{:?}", mesh.points);
    }

    /// A sheet overlaps the side of the body by 0.1: both move by half of the overlap, the nodes of the edge in proportion.
    #[test]
    fn parts_that_overlap_move_apart() {
        let points = [
            [1.0, 0.0],
            [9.0, 0.0],
            [9.0, 9.0],
            [6.0, 9.0],
            [5.9, 6.0],
            [8.0, 3.0],
            [6.0, 2.0],
            [4.0, 3.0],
            [6.0, 5.0],
            [6.0, 7.0],
            [6.0, 12.0],
            [1.0, 12.0],
        ];
        let (mut mesh, edges) = outline(&points);
        assert!(crosses(&mesh, &edges));
        let mut loops = [edges];
        repair(&mut mesh, &mut loops, &vec![false; points.len()]);
        assert!(!crosses(&mesh, &loops[0]), "{:?}", mesh.points);
        assert_eq!(loops[0].len(), points.len());
        let moved = mesh.points.iter().zip(&points).map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1])).fold(0.0, f64::max);
        assert!(moved < 0.12, "{moved}");
    }
}
