//! Quadrilaterals from pairs of triangles with a common edge; triangles without a partner remain.

use std::collections::BTreeSet;

use rustc_hash::FxHashMap;

use super::triangulation::TriangleMesh;
use crate::kernel::lanes::InlineMap;
use crate::kernel::shape::{smallest_sine, triangle};

/// Smallest sine of the angles of a quadrilateral, 30 degrees.
const SMALLEST: f64 = 0.5;

/// A triangle that has a common edge with another one, and the quadrilateral of both.
#[derive(Clone, Copy)]
struct Partner {
    triangle: u32,
    quad: [u32; 4],
    sine: f64,
}

/// Returns the elements that fill the triangles. Triangles with the fewest possible partners are paired first, each with
/// the partner that gives the best angles.
pub(super) fn elements(mesh: &TriangleMesh) -> Vec<[u32; 4]> {
    let partners = partners(mesh);
    let mut is_free = vec![true; partners.len()];
    let mut degree: Vec<usize> = partners.iter().map(Vec::len).collect();
    let mut queue: BTreeSet<(usize, u32)> = degree.iter().copied().zip(0..).collect();
    let mut quads = Vec::new();
    while let Some((_, first)) = queue.pop_first() {
        is_free[first as usize] = false;
        let free = partners[first as usize].iter().filter(|partner| is_free[partner.triangle as usize]);
        let best = free.copied().max_by(|a, b| a.sine.total_cmp(&b.sine).then(b.triangle.cmp(&a.triangle)));
        let Some(best) = best else {
            quads.push(triangle(mesh.triangles[first as usize], |n| mesh.points[n as usize]));
            continue;
        };
        is_free[best.triangle as usize] = false;
        queue.remove(&(degree[best.triangle as usize], best.triangle));
        quads.push(best.quad);
        for other in [first, best.triangle].iter().flat_map(|t| &partners[*t as usize]) {
            let index = other.triangle as usize;
            if is_free[index] && queue.remove(&(degree[index], other.triangle)) {
                degree[index] -= 1;
                queue.insert((degree[index], other.triangle));
            }
        }
    }
    quads
}

/// Returns for each triangle those with which it makes a quadrilateral with valid angles.
fn partners(mesh: &TriangleMesh) -> Vec<Vec<Partner>> {
    let mut partners = vec![Vec::new(); mesh.triangles.len()];
    let mut open: FxHashMap<[u32; 2], (u32, u32)> = FxHashMap::default();
    for (t, triangle) in (0..).zip(&mesh.triangles) {
        for i in 0..3 {
            let [a, b, c] = [i, i + 1, i + 2].inline_map(|k: usize| triangle[k % 3]);
            let Some((other, opposite)) = open.remove(&[b, a]) else {
                open.insert([a, b], (t, c));
                continue;
            };
            let quad = [a, opposite, b, c];
            let sine = smallest_sine(&quad, |n| mesh.points[n as usize]);
            if sine > SMALLEST {
                partners[t as usize].push(Partner { triangle: other, quad, sine });
                partners[other as usize].push(Partner { triangle: t, quad, sine });
            }
        }
    }
    partners
}

#[cfg(test)]
mod tests {
    use super::elements;
    use crate::kernel::shape::is_triangle;
    use crate::remesh::triangulation::TriangleMesh;

    /// A strip of an odd number of triangles: all but one are paired, whatever the order.
    #[test]
    fn a_strip_keeps_one_triangle() {
        let points: Vec<[f64; 2]> = (0..9).map(|i| [0.5 * f64::from(i), if i % 2 == 0 { 0.0 } else { 0.8 }]).collect();
        let triangle_of = |i: u32| if i.is_multiple_of(2) { [i, i + 2, i + 1] } else { [i, i + 1, i + 2] };
        let mesh = TriangleMesh { points, triangles: [3, 0, 6, 1, 5, 2, 4].map(triangle_of).to_vec() };
        let elements = elements(&mesh);
        assert_eq!((elements.len(), elements.iter().filter(|quad| is_triangle(quad)).count()), (4, 1));
    }
}
