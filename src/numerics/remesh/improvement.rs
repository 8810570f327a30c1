//! Better shapes of the elements of a new mesh: nodes inside move where this increases the smallest stable time increment
//! around them (optimisation-based smoothing: Freitag and Ollivier-Gooch 1997, Int. J. Numer. Meth. Eng. 40, 3979).

use super::BodyMesh;
use crate::kernel::lanes::InlineMap;
use crate::kernel::quad::stable_edge;
use crate::kernel::shape::{elements_around, is_triangle, smallest_sine};

/// Quality of the elements around a node from which on it stays: that of squares at the axis.
const SUFFICIENT: f64 = 0.75;
/// Sine of angles below which the quality of a quadrilateral is reduced, 37 degrees.
const SHARP: f64 = 0.6;
/// First step of the search for a better place of a node, in units of the wanted edge.
const STEP: f64 = 0.15;
/// Steps of the search.
const STEPS: usize = 3;
/// Sweeps over all nodes.
const SWEEPS: usize = 4;

/// Moves nodes inside where this improves the worst element around them, in several sweeps.
pub(super) fn improve(mesh: &mut BodyMesh, on_boundary: &[bool]) {
    let around = elements_around(&mesh.quads, mesh.points.len());
    // A node stays where it is until it or a node of the elements around it has moved.
    let mut may_move: Vec<bool> = on_boundary.iter().map(|is_on| !is_on).collect();
    for _ in 0..SWEEPS {
        for n in 0..mesh.points.len() {
            if std::mem::take(&mut may_move[n]) && improve_node(mesh, n, &around[n]) {
                let moved = around[n].iter().flat_map(|e| mesh.quads[*e as usize]);
                moved.for_each(|other| may_move[other as usize] = !on_boundary[other as usize]);
            }
        }
    }
}

/// Returns the quality of an element: the edge of the square with its stable time increment over the wanted edge, reduced
/// in quadrilaterals with sharp or flat angles; not positive if it is concave.
pub(super) fn quality(quad: &[u32; 4], points: &[[f64; 2]], wanted: f64) -> f64 {
    let sine = smallest_sine(quad, |n| points[n as usize]);
    if sine <= 0.0 {
        return sine;
    }
    let factor = if is_triangle(quad) { 1.0 } else { (sine / SHARP).min(1.0) };
    factor * stable_edge(quad.inline_map(|n| points[n as usize])) / wanted
}

/// Returns the quality of the worst element at a node.
fn worst_around(mesh: &BodyMesh, around: &[u32]) -> f64 {
    let quality = |e: &u32| quality(&mesh.quads[*e as usize], &mesh.points, mesh.sizes[*e as usize]);
    around.iter().map(quality).fold(f64::INFINITY, f64::min)
}

/// Returns the quality of the worst element at a node; `None` if an element is not better than a limit.
fn worst_above(mesh: &BodyMesh, around: &[u32], limit: f64) -> Option<f64> {
    around.iter().try_fold(f64::INFINITY, |worst, e| {
        let worst = worst.min(quality(&mesh.quads[*e as usize], &mesh.points, mesh.sizes[*e as usize]));
        (worst > limit).then_some(worst)
    })
}

/// Moves a node to the middle of its neighbours in the elements around it if this improves the worst element; otherwise
/// to the best of several places around it. Returns whether it has moved.
fn improve_node(mesh: &mut BodyMesh, n: usize, around: &[u32]) -> bool {
    let (mut sum, mut count) = ([0.0; 2], 0.0);
    for quad in around.iter().map(|e| &mesh.quads[*e as usize]) {
        for i in (0..4).filter(|i| quad[*i] as usize == n) {
            for other in [quad[(i + 1) % 4], quad[(i + 3) % 4]].into_iter().filter(|other| *other as usize != n) {
                let neighbour = mesh.points[other as usize];
                (sum, count) = ([sum[0] + neighbour[0], sum[1] + neighbour[1]], count + 1.0);
            }
        }
    }
    let start = mesh.points[n];
    let mut best = (worst_around(mesh, around), start);
    if best.0 > SUFFICIENT {
        return false;
    }
    let mut step = STEP * mesh.sizes[around[0] as usize];
    let middle = sum.inline_map(|x| x / count);
    let places = |p: [f64; 2], step: f64| {
        [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]]
            .inline_map(|d: [f64; 2]| [p[0] + step * d[0], p[1] + step * d[1]])
    };
    let mut attempt = |place: [f64; 2], best: &mut (f64, [f64; 2])| {
        mesh.points[n] = place;
        if let Some(worst) = worst_above(mesh, around, best.0) {
            *best = (worst, place);
        }
    };
    attempt(middle, &mut best);
    for _ in 0..STEPS {
        let centre = best.1;
        places(centre, step).into_iter().for_each(|place| attempt(place, &mut best));
        if best.1 == centre {
            step *= 0.5;
        }
    }
    mesh.points[n] = best.1;
    best.1 != start
}
