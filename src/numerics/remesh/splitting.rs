//! Quadrilaterals from a mesh of twice the wanted edge: elements are divided at the middles of their sides, triangles into
//! three quadrilaterals and quadrilaterals into four, so that no triangle remains (Johnston, Sullivan and Kwasnik 1991,
//! Int. J. Numer. Meth. Eng. 31, 67). Sides across thin parts of a body are not divided.

use rustc_hash::FxHashMap;

use super::BodyMesh;
use super::improvement::quality;
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::sorted_pair;
use crate::kernel::shape::{distance, is_triangle, triangle};

/// Length of a side across a thin part, in units of the wanted edge, below which one element is better than two.
const THIN: f64 = 0.9;

/// Divides elements of a coarse mesh whose first points are every second one of the closed polygons `outlines`. The points
/// of the new mesh begin with those of the polygons. Points that are `removable` may be missing; on
/// return, `removable` marks the missing points. `size` is the wanted edge at a place.
pub(super) fn split(
    coarse: &BodyMesh,
    outlines: &[Vec<[f64; 2]>],
    removable: &mut [bool],
    size: &dyn Fn([f64; 2]) -> f64,
) -> BodyMesh {
    let points = outlines.concat();
    let on_outline = points.len() / 2;
    let mut split = Splitting { middles: outline_middles(outlines), on_outline: points.len(), ..Splitting::default() };
    split.mesh.points = points;
    split.mesh.points.extend_from_slice(&coarse.points[on_outline..]);
    for quad in &coarse.quads {
        // Points inside follow twice as many points of the outline.
        let corners = quad.inline_map(|n| if (n as usize) < on_outline { 2 * n } else { n + on_outline as u32 });
        split.divide(if is_triangle(quad) { &corners[..3] } else { &corners }, removable, size);
    }
    split.without_unused_points(removable)
}

/// Returns the points in the middle of the coarse edges of closed polygons.
fn outline_middles(outlines: &[Vec<[f64; 2]>]) -> FxHashMap<[u32; 2], u32> {
    let (mut middles, mut first) = (FxHashMap::default(), 0);
    for points in outlines {
        let count = points.len() as u32;
        let middle = |i: u32| (sorted_pair([first + i, first + (i + 2) % count]), first + i + 1);
        middles.extend((0..count).step_by(2).map(middle));
        first += count;
    }
    middles
}

#[derive(Default)]
struct Splitting {
    mesh: BodyMesh,
    /// Points in the middle of divided sides.
    middles: FxHashMap<[u32; 2], u32>,
    /// Number of points of the outline.
    on_outline: usize,
}

/// Elements that fill a polygon, and the quality of the worst one.
struct Filling {
    quads: Vec<[u32; 4]>,
    worst: f64,
}

impl Splitting {
    /// Divides an element.
    fn divide(&mut self, corners: &[u32], removable: &[bool], size: &dyn Fn([f64; 2]) -> f64) {
        let count = corners.len();
        let wanted = size(self.mean(corners));
        let sides: Vec<Option<u32>> =
            (0..count).map(|i| self.middle([corners[i], corners[(i + 1) % count]], wanted)).collect();
        if sides.iter().all(Option::is_some) {
            let centre = self.add_mean(corners);
            for (i, corner) in corners.iter().enumerate() {
                let [next, previous] = [i, (i + count - 1) % count].inline_map(|i| sides[i].unwrap_or_default());
                self.mesh.quads.push([*corner, next, centre, previous]);
            }
            return;
        }
        let polygon: Vec<u32> =
            corners.iter().zip(&sides).flat_map(|(corner, side)| [Some(*corner), *side]).flatten().collect();
        let mut filling = self.fill(&polygon, wanted);
        // The tip of a wedge has one long triangle.
        let may_leave = |n: &u32| (*n as usize) < self.on_outline && removable[*n as usize];
        if count == 3 && sides.iter().flatten().count() == 2 && sides.iter().flatten().all(may_leave) {
            let whole = self.fill(corners, wanted);
            filling = if whole.worst > filling.worst { whole } else { filling };
        }
        self.mesh.quads.extend(filling.quads);
    }

    /// Returns the middle of a side; `None` for a short one between two points of the outline.
    fn middle(&mut self, ends: [u32; 2], wanted: f64) -> Option<u32> {
        if let Some(middle) = self.middles.get(&sorted_pair(ends)) {
            return Some(*middle);
        }
        let [a, b] = ends.inline_map(|n| self.mesh.points[n as usize]);
        if ends.iter().all(|n| (*n as usize) < self.on_outline) && distance(a, b) < THIN * wanted {
            return None;
        }
        let middle = self.add_mean(&ends);
        self.middles.insert(sorted_pair(ends), middle);
        Some(middle)
    }

    /// Returns the elements without further points that fill a polygon and of which the worst one is the best.
    fn fill(&self, polygon: &[u32], wanted: f64) -> Filling {
        let last = polygon.len() - 1;
        let mut best = Filling { quads: Vec::new(), worst: f64::NEG_INFINITY };
        for i in 1..last {
            for k in i..last {
                let quad = if i == k {
                    triangle([polygon[0], polygon[i], polygon[last]], |n| self.mesh.points[n as usize])
                } else {
                    [polygon[0], polygon[i], polygon[k], polygon[last]]
                };
                let mut worst = quality(&quad, &self.mesh.points, wanted);
                let mut quads = vec![quad];
                for part in [&polygon[..=i], &polygon[i..=k], &polygon[k..]].into_iter().filter(|part| part.len() > 2) {
                    let filling = self.fill(part, wanted);
                    worst = worst.min(filling.worst);
                    quads.extend(filling.quads);
                }
                if best.quads.is_empty() || worst > best.worst {
                    best = Filling { quads, worst };
                }
            }
        }
        best
    }

    fn mean(&self, nodes: &[u32]) -> [f64; 2] {
        let sum = |i: usize| nodes.iter().map(|n| self.mesh.points[*n as usize][i]).sum::<f64>();
        [0, 1].inline_map(|i: usize| sum(i) / nodes.len() as f64)
    }

    /// Adds a point in the middle of others. Returns its index.
    fn add_mean(&mut self, nodes: &[u32]) -> u32 {
        let mean = self.mean(nodes);
        self.mesh.points.push(mean);
        self.mesh.points.len() as u32 - 1
    }

    /// Removes points without elements, and marks those of the outline in `is_removed`.
    fn without_unused_points(self, is_removed: &mut [bool]) -> BodyMesh {
        let Splitting { mut mesh, .. } = self;
        let mut is_used = vec![false; mesh.points.len()];
        mesh.quads.iter().flatten().for_each(|n| is_used[*n as usize] = true);
        is_removed.iter_mut().zip(&is_used).for_each(|(is_removed, is_used)| *is_removed = !is_used);
        let mut next = 0;
        let numbers: Vec<u32> = is_used
            .iter()
            .map(|used| {
                next += u32::from(*used);
                next.wrapping_sub(1)
            })
            .collect();
        mesh.quads.iter_mut().flatten().for_each(|n| *n = numbers[*n as usize]);
        let mut used = is_used.into_iter();
        mesh.points.retain(|_| used.next().unwrap_or(true));
        mesh
    }
}

#[cfg(test)]
mod tests {
    use super::split;
    use crate::kernel::shape::is_triangle;
    use crate::remesh::BodyMesh;

    /// Returns a strip of coarse squares with the side 2 and this height, its last one a triangle, as its outline and its
    /// coarse mesh; the wanted edge is 1.
    fn strip(height: f64) -> (Vec<[f64; 2]>, BodyMesh) {
        let (low, high) =
            ((0..=6).map(|i| [5.0 + f64::from(i), 0.0]), (0..5).rev().map(|i| [5.0 + f64::from(i), height]));
        let mut outline: Vec<[f64; 2]> = low.collect();
        outline.push([10.0, 0.5 * height]);
        outline.extend(high);
        outline.push([5.0, 0.5 * height]);
        let points: Vec<[f64; 2]> = outline.iter().step_by(2).copied().collect();
        // Coarse points: 0 to 3 below, 4 to 6 above from the tip.
        (outline, BodyMesh { points, quads: vec![[0, 1, 5, 6], [1, 2, 4, 5], [2, 3, 4, 4]], sizes: Vec::new() })
    }

    #[test]
    fn elements_have_no_triangles_and_thin_parts_have_one_element_across() {
        for (height, count, triangles) in [(2.0, 11, 0), (0.5, 6, 2)] {
            let (outline, coarse) = strip(height);
            let mut removable = vec![true; outline.len()];
            let fine = split(&coarse, &[outline], &mut removable, &|_| 1.0);
            let triangle_count = fine.quads.iter().filter(|quad| is_triangle(quad)).count();
            assert_eq!((fine.quads.len(), triangle_count), (count, triangles), "{height}: {:?}", fine.quads);
            let is_used = |n: usize| fine.quads.iter().flatten().any(|corner| *corner as usize == n);
            assert!((0..fine.points.len()).all(is_used));
        }
    }
}
