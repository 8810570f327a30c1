//! Sizes of new elements: those of the elements that they replace, smaller where the outline is curved and where the
//! plastic strain changes, with a limited change between neighbours.

use super::BodyMesh;
use super::outline::{BoundaryEdge, cosine_between, is_corner, loops};
use super::transfer::{fitted_gradient, neighbours};
use crate::kernel::box_grid::BoxGrid;
use crate::kernel::lanes::InlineMap;
use crate::kernel::shape::{distance, elements_around, middle, twice_area};

/// Largest change of the wanted edge per distance.
const GRADING: f64 = 0.3;
/// Smallest edge, in units of the size without limits, if the deck has none.
const SMALLEST: f64 = 0.25;

/// Limits of the sizes of new elements.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SizeLimits {
    /// Largest angle that an edge of a curved outline spans, radians.
    pub curvature_angle: Option<f64>,
    /// Largest change of the equivalent plastic strain across an element.
    pub strain_change: Option<f64>,
    /// Smallest edge that these limits demand; `None` for a quarter of the size without them.
    pub smallest: Option<f64>,
}

impl SizeLimits {
    /// Returns the sizes of the elements of a mesh under these limits, with the plastic strain of each element; `None`
    /// without limits.
    pub fn apply(&self, mesh: &BodyMesh, strain: impl Fn(usize) -> f64) -> Option<Vec<f64>> {
        if self.curvature_angle.is_none() && self.strain_change.is_none() {
            return None;
        }
        let mut limits = vec![f64::INFINITY; mesh.quads.len()];
        if let Some(angle) = self.curvature_angle {
            limit_by_curvature(mesh, angle, &mut limits);
        }
        if let Some(change) = self.strain_change {
            let strains: Vec<f64> = (0..mesh.quads.len()).map(strain).collect();
            limit_by_gradient(mesh, &strains, change, &mut limits);
        }
        let limited = |(size, limit): (&f64, f64)| size.min(limit.max(self.smallest.unwrap_or(SMALLEST * size)));
        Some(mesh.sizes.iter().zip(limits).map(limited).collect())
    }
}

/// Limits edges of the outline to the radius times an angle. The radius is that of the circle through the middle of an
/// edge and the points one size before and after it along the outline, or at nearer corners.
fn limit_by_curvature(mesh: &BodyMesh, angle: f64, limits: &mut [f64]) {
    for edges in loops(mesh).unwrap_or_default() {
        for at in 0..edges.len() {
            let e = edges[at].side.0 as usize;
            let reach = mesh.sizes[e];
            let [before, after] = [false, true].inline_map(|ahead| point_along(mesh, &edges, at, (ahead, reach)));
            let middle_point = middle_of(mesh, &edges[at]);
            let sides = distance(before, middle_point) * distance(middle_point, after) * distance(after, before);
            let radius = sides / (2.0 * twice_area([before, middle_point, after]).abs());
            limits[e] = limits[e].min(angle * radius);
        }
    }
}

fn middle_of(mesh: &BodyMesh, edge: &BoundaryEdge) -> [f64; 2] {
    let [a, b] = edge.ends.inline_map(|n| mesh.points[n as usize]);
    [0, 1].inline_map(|i: usize| 0.5 * (a[i] + b[i]))
}

/// Returns the point of the outline at a distance from the middle of an edge, in the direction of the loop (`ahead`) or
/// against it; a corner if one is nearer.
fn point_along(mesh: &BodyMesh, edges: &[BoundaryEdge], mut at: usize, (ahead, mut rest): (bool, f64)) -> [f64; 2] {
    let (count, end) = (edges.len(), usize::from(ahead));
    let mut from = middle_of(mesh, &edges[at]);
    for _ in 0..count {
        let end_point = mesh.points[edges[at].ends[end] as usize];
        let length = distance(from, end_point);
        if length >= rest {
            let share = rest / length;
            return [0, 1].inline_map(|i: usize| from[i] + share * (end_point[i] - from[i]));
        }
        let next = if ahead { (at + 1) % count } else { (at + count - 1) % count };
        let pair = if ahead { [at, next] } else { [next, at] };
        if is_corner(cosine_between(mesh, pair.inline_map(|i| &edges[i]))) {
            return end_point;
        }
        (from, at, rest) = (end_point, next, rest - length);
    }
    from
}

/// Limits elements to a change of a value over the gradient of the value, by least squares over their neighbours.
fn limit_by_gradient(mesh: &BodyMesh, values: &[f64], change: f64, limits: &mut [f64]) {
    let middles: Vec<[f64; 2]> = mesh.quads.iter().map(|quad| middle(mesh.corners(quad))).collect();
    for (e, others) in neighbours(mesh).iter().enumerate() {
        let difference = |other: &u32| {
            let other = *other as usize;
            ([0, 1].inline_map(|i: usize| middles[other][i] - middles[e][i]), values[other] - values[e])
        };
        let [along_r, along_z] = fitted_gradient(others.iter().map(difference));
        limits[e] = limits[e].min(change / (along_r * along_r + along_z * along_z).sqrt());
    }
}

/// Limits the change of sizes between neighbours.
pub(super) fn graded_sizes(mesh: &BodyMesh, wanted: &[f64], middles: &[[f64; 2]]) -> Vec<f64> {
    let mut sizes = wanted.to_vec();
    let around = elements_around(&mesh.quads, mesh.points.len());
    loop {
        let mut changes = false;
        for (e, quad) in mesh.quads.iter().enumerate() {
            for other in quad.iter().flat_map(|n| &around[*n as usize]) {
                let other = *other as usize;
                let largest = sizes[other] + GRADING * distance(middles[e], middles[other]);
                if sizes[e] > largest * (1.0 + 1e-9) {
                    (sizes[e], changes) = (largest, true);
                }
            }
        }
        if !changes {
            return sizes;
        }
    }
}

/// Sizes at places: those of the old element with the nearest middle.
pub(super) struct SizeField<'a> {
    sizes: &'a [f64],
    middles: &'a [[f64; 2]],
    boxes: BoxGrid,
    /// Distance within which the nearest element is searched first.
    reach: f64,
}

impl SizeField<'_> {
    pub(super) fn new<'a>(mesh: &'a BodyMesh, middles: &'a [[f64; 2]]) -> SizeField<'a> {
        let boxes = BoxGrid::new(middles.iter().map(|middle| [*middle, *middle]).zip(0..));
        let reach = mesh.sizes.iter().copied().fold(f64::INFINITY, f64::min);
        SizeField { sizes: &mesh.sizes, middles, boxes, reach }
    }

    pub(super) fn element(&self, place: [f64; 2]) -> u32 {
        let mut reach = self.reach;
        for _ in 0..40 {
            let mut nearest = (f64::INFINITY, 0);
            self.boxes.near([place, place], reach, |e| {
                let apart = distance(self.middles[e as usize], place);
                if (apart, e) < nearest {
                    nearest = (apart, e);
                }
            });
            if nearest.0 <= reach {
                return nearest.1;
            }
            reach *= 2.0;
        }
        0
    }

    pub(super) fn size(&self, place: [f64; 2]) -> f64 {
        self.sizes[self.element(place) as usize]
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::SizeLimits;
    use crate::remesh::mesher::{OutlineRules, new_mesh};
    use crate::remesh::{BodyMesh, MeshRevision};

    /// Returns a mesh of `n` by `m` elements of the size 0.1 with nodes at the places of a function of the unit square.
    fn mesh(n: u32, m: u32, place: impl Fn(f64, f64) -> [f64; 2]) -> BodyMesh {
        let share = |i: u32, n: u32| f64::from(i) / f64::from(n);
        let points = (0..=m).flat_map(|j| (0..=n).map(move |i| (i, j))).map(|(i, j)| place(share(i, n), share(j, m)));
        let quad = |(i, j): (u32, u32)| [0, 1, n + 2, n + 1].map(|k| i + j * (n + 1) + k);
        let quads: Vec<[u32; 4]> = (0..m).flat_map(|j| (0..n).map(move |i| (i, j))).map(quad).collect();
        BodyMesh { points: points.collect(), sizes: vec![0.1; quads.len()], quads }
    }

    fn remeshed(mesh: &BodyMesh, sizes: Vec<f64>) -> MeshRevision {
        let rules = OutlineRules { kept: &vec![false; mesh.points.len()], fixed: &[], place: &|_, _| None };
        new_mesh(mesh, &rules, Some(sizes)).expect("a mesh")
    }

    /// A quarter of a ring between the radii 0.3 and 1.3 that turns around its centre at r = 5.
    #[test]
    fn curved_outlines_have_edges_of_an_angle() {
        let ring = mesh(10, 10, |x, y| {
            let (radius, angle) = (0.3 + x, 0.5 * PI * y);
            [5.0 + radius * angle.cos(), radius * angle.sin()]
        });
        let limits = SizeLimits { curvature_angle: Some(0.15), smallest: Some(0.01), ..SizeLimits::default() };
        let sizes = limits.apply(&ring, |_| 0.0).expect("sizes");
        // Away from the corners: 0.15 times the radius inside, the chords of ten edges make it uncertain by one per cent.
        let (inner, outer) = (sizes[5 * 10], sizes[5 * 10 + 9]);
        assert!((inner / (0.15 * 0.3) - 1.0).abs() < 0.02, "{inner}");
        assert_eq!(outer, 0.1);
        let new = remeshed(&ring, sizes);
        assert!(new.mesh.sizes.iter().all(|size| *size == 0.1));
        let radius = |p: &[f64; 2]| (p[0] - 5.0).hypot(p[1]);
        let edges = new.mesh.points.iter().filter(|p| radius(p) < 0.31).count() - 1;
        // A quarter of a turn has 10.5 angles of 0.15; edges of triangles are 7 % longer than those of squares.
        assert!((9..=11).contains(&edges), "{edges} edges");
    }

    /// A strain that rises from 0 to 1 along z, from 0.3 to 0.7 in a unit square: elements of 0.04 have a change of 0.1.
    #[test]
    fn elements_are_small_where_the_strain_changes() {
        let square = mesh(10, 10, |x, y| [x, y]);
        let strain = |e: usize| (2.5 * ((e / 10) as f64 * 0.1 + 0.05 - 0.3)).clamp(0.0, 1.0);
        let limits = SizeLimits { strain_change: Some(0.1), ..SizeLimits::default() };
        let sizes = limits.apply(&square, strain).expect("sizes");
        assert!((sizes[55] - 0.04).abs() < 1e-12, "{}", sizes[55]);
        assert_eq!((sizes[0], sizes[99]), (0.1, 0.1));
        let steep = SizeLimits { strain_change: Some(0.01), ..SizeLimits::default() }.apply(&square, strain);
        assert_eq!(steep.expect("sizes")[55], 0.025);
        assert!(SizeLimits::default().apply(&square, strain).is_none());
        let new = remeshed(&square, sizes);
        let rows = |from: f64, to: f64| new.mesh.points.iter().filter(|p| p[1] > from && p[1] < to).count();
        assert!(rows(0.4, 0.6) > 3 * rows(0.8, 0.999), "{} {}", rows(0.4, 0.6), rows(0.8, 0.999));
    }
}
