//! Triangles inside a polygon with given sizes: constrained Delaunay triangulation whose circumcentres are added until
//! all triangles are small and well shaped (Ruppert 1995, J. Algorithms 18, 548, without division of the boundary).

use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

use crate::kernel::box_grid::BoxGrid;
use crate::kernel::lanes::InlineMap;
use crate::kernel::shape::{distance, share_between, twice_area};
use crate::kernel::sorted_boxes::bounding_box;

/// Circumradius, in units of the wanted edge, above which a triangle is divided; that of an equilateral one is 0.577.
const LARGE: f64 = 0.72;
/// Circumradius over the shortest edge above which a triangle is divided if it is not small, 26 degrees.
const SLENDER: f64 = 1.15;
/// Smallest distances of a new point from the boundary and from other points, in units of the wanted edge.
const FROM_BOUNDARY: f64 = 0.45;
const APART: f64 = 0.62;
/// Coordinates below this one are zero; the library accepts none between zero and 2e-43.
const SMALLEST: f64 = 1e-40;
/// Smallest ratio of the area of a triangle to the square of its longest side. Flatter ones are between the polygon and a
/// straight line.
const FLATTEST: f64 = 1e-9;
/// Largest number of rounds of added points.
const ROUNDS: usize = 60;
/// Rounds in which points move to the middle of their neighbours.
const SMOOTHINGS: usize = 4;

/// Points and triangles; the points of the polygon are first.
pub(super) struct TriangleMesh {
    pub points: Vec<[f64; 2]>,
    pub triangles: Vec<[u32; 3]>,
}

/// Factor on the distance of boxes, for rounding.
const ROUNDING: f64 = 1.0 + 1e-9;

/// Edges of closed polygons.
struct Boundary {
    ends: Vec<[[f64; 2]; 2]>,
    boxes: BoxGrid,
}

impl Boundary {
    fn new(points: &[[f64; 2]], edges: &[[u32; 2]]) -> Boundary {
        let ends: Vec<_> = edges.iter().map(|edge| edge.inline_map(|n| points[n as usize])).collect();
        let boxes = BoxGrid::new(ends.iter().map(|edge| bounding_box(*edge)).zip(0..));
        Boundary { ends, boxes }
    }

    /// Returns whether a point is inside, by the even-odd rule along r.
    fn encloses(&self, p: [f64; 2]) -> bool {
        let mut crossings = 0;
        self.boxes.near([[f64::NEG_INFINITY, p[1]], [f64::INFINITY, p[1]]], 0.0, |edge| {
            let [a, b] = self.ends[edge as usize];
            let crosses = (a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
            crossings += usize::from(crosses);
        });
        crossings % 2 == 1
    }

    fn is_near(&self, p: [f64; 2], reach: f64) -> bool {
        let mut is_near = false;
        self.boxes.near([p; 2], ROUNDING * reach, |edge| {
            let [a, b] = self.ends[edge as usize];
            let share = share_between([a, b], p);
            is_near |= distance([0, 1].inline_map(|i: usize| a[i] + share * (b[i] - a[i])), p) < reach;
        });
        is_near
    }
}

type Delaunay = ConstrainedDelaunayTriangulation<Point2<f64>>;

/// Fills closed polygons with triangles whose edges have about the length `size` of a place; `None` if the polygons
/// touch or cross each other.
pub(super) fn fill(boundary: &[[f64; 2]], edges: &[[u32; 2]], size: &dyn Fn([f64; 2]) -> f64) -> Option<TriangleMesh> {
    let polygon = Boundary::new(boundary, edges);
    let mut points = boundary.to_vec();
    let mut delaunay = triangulated(&points, edges)?;
    for _ in 0..ROUNDS {
        let added = wanted_points(&delaunay, &points, &polygon, size);
        if added.is_empty() {
            break;
        }
        for p in added {
            add(&mut delaunay, p, points.len())?;
            points.push(p);
        }
    }
    for _ in 0..SMOOTHINGS {
        smooth(&triangles(&delaunay, &points, &polygon), boundary.len(), &mut points);
        delaunay = triangulated(&points, edges)?;
    }
    let triangles = triangles(&delaunay, &points, &polygon);
    Some(TriangleMesh { points, triangles })
}

/// Adds a point, which gets the next index. Coordinates that are too small for the library are zero.
fn add(delaunay: &mut Delaunay, place: [f64; 2], index: usize) -> Option<()> {
    let [r, z] = place.inline_map(|x| if x.abs() < SMALLEST { 0.0 } else { x });
    let added = delaunay.insert(Point2::new(r, z)).ok()?;
    (added.index() == index).then_some(())
}

fn triangulated(points: &[[f64; 2]], edges: &[[u32; 2]]) -> Option<Delaunay> {
    let mut delaunay = Delaunay::new();
    for (index, point) in points.iter().enumerate() {
        add(&mut delaunay, *point, index)?;
    }
    for edge in edges {
        let [from, to] = edge.inline_map(|n| spade::handles::FixedVertexHandle::from_index(n as usize));
        if !delaunay.can_add_constraint(from, to) {
            return None;
        }
        delaunay.add_constraint(from, to);
        // An edge through another point would be divided.
        delaunay.get_edge_from_neighbors(from, to)?;
    }
    Some(delaunay)
}

fn triangles(delaunay: &Delaunay, points: &[[f64; 2]], polygon: &Boundary) -> Vec<[u32; 3]> {
    let faces = delaunay.inner_faces().map(|face| face.vertices().map(|v| v.fix().index() as u32));
    faces
        .filter(|t| {
            let [a, b, c] = t.inline_map(|n| points[n as usize]);
            let longest = distance(a, b).max(distance(b, c)).max(distance(c, a));
            twice_area([a, b, c]) > 2.0 * FLATTEST * longest * longest && polygon.encloses(middle([a, b, c]))
        })
        .collect()
}

/// Returns the mean of the corners of a triangle.
fn middle([a, b, c]: [[f64; 2]; 3]) -> [f64; 2] {
    [0, 1].inline_map(|i: usize| (a[i] + b[i] + c[i]) / 3.0)
}

/// Returns the circumcentre and the circumradius of a triangle.
fn circumcircle([a, b, c]: [[f64; 2]; 3]) -> ([f64; 2], f64) {
    let ([p, q], [s, t]) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
    let twice = 2.0 * (p * t - q * s);
    let (first, second) = (p * p + q * q, s * s + t * t);
    let [r, z] = [(t * first - q * second) / twice, (p * second - s * first) / twice];
    ([a[0] + r, a[1] + z], (r * r + z * z).sqrt())
}

/// Point that can be added: the circumcentre of a triangle, its radius relative to the wanted length, and that length.
struct PointCandidate {
    centre: [f64; 2],
    relative_radius: f64,
    length: f64,
}

/// Returns circumcentres of large and slender triangles with distances from each other and from all points; the worst
/// triangles first.
fn wanted_points(
    delaunay: &Delaunay,
    points: &[[f64; 2]],
    polygon: &Boundary,
    size: &dyn Fn([f64; 2]) -> f64,
) -> Vec<[f64; 2]> {
    let mut candidates = Vec::new();
    for triangle in triangles(delaunay, points, polygon) {
        let corners = triangle.inline_map(|n| points[n as usize]);
        let (centre, radius) = circumcircle(corners);
        let length = size(middle(corners));
        let sides = [0, 1, 2].inline_map(|i: usize| distance(corners[i], corners[(i + 1) % 3]));
        let shortest = sides[0].min(sides[1]).min(sides[2]);
        let is_bad = radius > LARGE * length || radius > SLENDER * shortest && radius > 0.5 * length;
        if is_bad && centre.iter().all(|x| x.is_finite()) {
            candidates.push(PointCandidate { centre, relative_radius: radius / length, length });
        }
    }
    candidates.sort_by(|a, b| {
        let by_place = a.centre[0].total_cmp(&b.centre[0]).then(a.centre[1].total_cmp(&b.centre[1]));
        b.relative_radius.total_cmp(&a.relative_radius).then(by_place)
    });
    let boxes = BoxGrid::new(points.iter().map(|p| [*p; 2]).zip(0..));
    let mut added: Vec<[f64; 2]> = Vec::new();
    for PointCandidate { centre, length, .. } in candidates {
        let is_apart = |p: &[f64; 2]| distance(*p, centre) > APART * length;
        let mut is_free = true;
        boxes.near([centre; 2], ROUNDING * APART * length, |n| is_free &= is_apart(&points[n as usize]));
        if is_free
            && added.iter().all(is_apart)
            && polygon.encloses(centre)
            && !polygon.is_near(centre, FROM_BOUNDARY * length)
        {
            added.push(centre);
        }
    }
    added
}

/// Moves all points inside to the middle of the triangles around them.
fn smooth(triangles: &[[u32; 3]], fixed: usize, points: &mut [[f64; 2]]) {
    let mut sums = vec![([0.0; 2], 0.0); points.len()];
    for triangle in triangles {
        let corners = triangle.inline_map(|n| points[n as usize]);
        let (area, [a, b, c]) = (twice_area(corners), corners);
        for n in triangle {
            let (sum, weight) = &mut sums[*n as usize];
            *sum = [0, 1].inline_map(|i: usize| sum[i] + area * (a[i] + b[i] + c[i]) / 3.0);
            *weight += area;
        }
    }
    for (point, (sum, weight)) in points.iter_mut().zip(sums).skip(fixed).filter(|(_, (_, weight))| *weight > 0.0) {
        *point = sum.inline_map(|x| x / weight);
    }
}

#[cfg(test)]
mod tests {
    use super::fill;
    use crate::kernel::shape::twice_area;

    /// A wave has reached the rim of a square: displacements of 1e-54, and a side that is bent by rounding.
    #[test]
    fn tiny_coordinates_and_bent_sides_do_not_matter() {
        let points = [[1.0, 0.0], [2.0, -3.4e-54], [2.0 - 1e-15, 0.5], [2.0, 1.0], [1.0, 1.0], [1.0 + 1e-16, 0.5]];
        let edges: Vec<[u32; 2]> = (0..6).map(|i| [i, (i + 1) % 6]).collect();
        let mesh = fill(&points, &edges, &|_| 0.5).expect("triangles");
        let areas: Vec<f64> =
            mesh.triangles.iter().map(|t| 0.5 * twice_area(t.map(|n| mesh.points[n as usize]))).collect();
        assert!((areas.iter().sum::<f64>() - 1.0).abs() < 1e-12 && areas.iter().all(|a| *a > 0.01), "{areas:?}");
    }
}
