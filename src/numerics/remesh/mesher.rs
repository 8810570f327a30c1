//! New elements inside the outline of a body: triangles, of which most are paired to quadrilaterals.

use std::f64::consts::FRAC_PI_2;

use rustc_hash::FxHashMap;

use super::folds::repair;
use super::improvement::{improve, quality};
use super::outline::{BoundaryEdge, OutlinePoint, divide, loops};
use super::pairing::elements;
use super::sizes::{SizeField, graded_sizes};
use super::splitting::split;
use super::triangulation::fill;
use super::{BodyMesh, INSIDE, MOST_NEW_ELEMENTS, MeshRevision, RevisedSide};
use crate::kernel::lanes::InlineMap;
use crate::kernel::shape::{corner_shape, has_larger_sines, middle, share_between, smallest_sine};

/// Ways to divide a body, tried one after the other up to the first good mesh. With an edge of 1.07, two triangles have the
/// area of a square; the shorter ones follow a more curved outline.
const DIVISIONS: [Division; 6] = [
    Division { edge: 1.1, splits: true },
    Division { edge: 0.95, splits: true },
    Division { edge: 1.07, splits: false },
    Division { edge: 0.9, splits: false },
    Division { edge: 0.75, splits: false },
    Division { edge: 0.6, splits: false },
];
/// Quality of the worst element from which on no other division is tried.
const SUFFICIENT: f64 = 0.35;
/// Smallest ratio of the corner triangles of an element to half its area.
const FLAT: f64 = 0.02;
/// Margin for rounding when squares of sines are compared.
const ROUNDING: f64 = 1e-9;

/// How a body is divided.
#[derive(Clone, Copy)]
struct Division {
    /// Edges over the wanted edge of squares.
    edge: f64,
    /// Whether elements of twice this edge are split, so that all are quadrilaterals.
    splits: bool,
}

impl Division {
    /// Returns the number of edges of the outline on each edge of the first mesh.
    fn multiple(self) -> usize {
        1 + usize::from(self.splits)
    }
}

/// What a new mesh must keep.
pub struct OutlineRules<'a> {
    /// Nodes of the boundary that remain.
    pub kept: &'a [bool],
    /// Edges of the boundary that are not divided again, in ascending order.
    pub fixed: &'a [[u32; 2]],
    /// Returns the place of a new node on the edge between two old ones, if it is not on this edge; with its distance
    /// from the first one, as a fraction of the edge.
    pub place: &'a dyn Fn([u32; 2], f64) -> Option<[f64; 2]>,
}

/// Remeshes a body. `limited` are the sizes that elements should have in this mesh only
/// ([`SizeLimits`](super::sizes::SizeLimits)). Returns `None` if the outline touches itself, if the sizes demand more than
/// [`MOST_NEW_ELEMENTS`], or if no mesh with valid elements is found.
pub fn new_mesh(old: &BodyMesh, rules: &OutlineRules<'_>, limited: Option<Vec<f64>>) -> Option<MeshRevision> {
    let middles: Vec<[f64; 2]> = old.quads.iter().map(|quad| middle(old.corners(quad))).collect();
    let lasting = graded_sizes(old, &old.sizes, &middles);
    let sizes = limited.map_or_else(|| lasting.clone(), |limited| graded_sizes(old, &limited, &middles));
    let mut graded = BodyMesh { sizes, ..old.clone() };
    if graded.expected_elements() > MOST_NEW_ELEMENTS {
        return None;
    }
    // Nodes of a closing cavity may have passed the axis by a little.
    graded.points.iter_mut().for_each(|p| p[0] = p[0].max(0.0));
    let mut loops = loops(old)?;
    for edge in loops.iter_mut().flatten() {
        edge.is_fixed = rules.fixed.binary_search(&edge.ends).is_ok();
    }
    repair(&mut graded, &mut loops, rules.kept);
    let field = SizeField::new(&graded, &middles);
    let mut best: Option<(MeshRevision, f64)> = None;
    for division in DIVISIONS {
        let Some(revision) = mesh_with(&graded, (&loops, rules), &field, division) else { continue };
        let mesh = &revision.mesh;
        let qualities = mesh.quads.iter().zip(&mesh.sizes).map(|(quad, wanted)| quality(quad, &mesh.points, *wanted));
        let worst = qualities.fold(f64::INFINITY, f64::min);
        if best.as_ref().is_none_or(|(_, other)| worst > *other) {
            best = Some((revision, worst));
        }
        if worst > SUFFICIENT || !division.splits {
            break;
        }
    }
    let (mut revision, _) = best?;
    revision.mesh.sizes = revision.origins.iter().map(|origin| lasting[*origin as usize]).collect();
    Some(revision)
}

/// Meshes a body with edges of the wanted lengths times a factor.
fn mesh_with(
    graded: &BodyMesh,
    (loops, rules): (&[Vec<BoundaryEdge>], &OutlineRules<'_>),
    field: &SizeField<'_>,
    division: Division,
) -> Option<MeshRevision> {
    let mut outlines = divided_outlines(graded, (loops, rules), division);
    let mut mesh = filled(&outlines, field, division)?;
    if division.splits {
        let mut removable: Vec<bool> = outlines.iter().flatten().map(|p| !is_kept_point(p, rules.kept)).collect();
        mesh = split(&mesh, &places(&outlines), &mut removable, &|place| division.edge * field.size(place));
        let mut is_removed = removable.into_iter();
        outlines.iter_mut().for_each(|points| points.retain(|_| !is_removed.next().unwrap_or_default()));
    }
    let mut revision = revision_of(mesh, &outlines);
    let on_boundary: Vec<bool> = revision.parents.iter().map(|parents| parents[0] != INSIDE).collect();
    let mesh = &mut revision.mesh;
    mesh.sizes = mesh.quads.iter().map(|quad| field.size(middle(mesh.corners(quad)))).collect();
    improve(mesh, &on_boundary);
    let has_flat_elements = !mesh.quads.iter().all(|quad| corner_shape(quad, &mesh.points) > FLAT);
    if mesh.quads.is_empty() || has_flat_elements || super::outline::loops(mesh)?.len() != outlines.len() {
        return None;
    }
    revision.origins = mesh.quads.iter().map(|quad| field.element(middle(mesh.corners(quad)))).collect();
    Some(revision)
}

/// Divides the outlines of a body.
fn divided_outlines(
    graded: &BodyMesh,
    (loops, rules): (&[Vec<BoundaryEdge>], &OutlineRules<'_>),
    division: Division,
) -> Vec<Vec<OutlinePoint>> {
    let edges = (division.edge, division.multiple());
    let mut outlines: Vec<Vec<OutlinePoint>> =
        loops.iter().map(|list| divide(graded, list, rules.kept, edges)).collect();
    for point in outlines.iter_mut().flatten().filter(|point| point.parents[0] != point.parents[1]) {
        let share = share_between(point.parents.inline_map(|n| graded.points[n as usize]), point.place);
        point.place = (rules.place)(point.parents, share).unwrap_or(point.place);
    }
    repair_points(&mut outlines, &graded.sizes, rules.kept);
    outlines
}

fn places(outlines: &[Vec<OutlinePoint>]) -> Vec<Vec<[f64; 2]>> {
    outlines.iter().map(|points| points.iter().map(|p| p.place).collect()).collect()
}

/// Fills outlines with elements; with twice the edges, between every second point, if these are split later.
fn filled(outlines: &[Vec<OutlinePoint>], field: &SizeField<'_>, division: Division) -> Option<BodyMesh> {
    let multiple = division.multiple();
    let (mut boundary, mut edges) = (Vec::new(), Vec::new());
    for points in &places(outlines) {
        if division.splits && (points.len() % 2 == 1 || points.len() < 6) {
            return None;
        }
        let (first, count) = (boundary.len() as u32, (points.len() / multiple) as u32);
        boundary.extend(points.iter().step_by(multiple));
        edges.extend((0..count).map(|i| [first + i, first + (i + 1) % count]));
    }
    let factor = division.edge * multiple as f64;
    let triangles = fill(&boundary, &edges, &|place| factor * field.size(place))?;
    let mesh = BodyMesh { quads: elements(&triangles), points: triangles.points, sizes: Vec::new() };
    if has_loose_points(&mesh) { None } else { Some(mesh) }
}

fn is_kept_point(point: &OutlinePoint, kept: &[bool]) -> bool {
    point.parents[0] == point.parents[1] && kept[point.parents[0] as usize]
}

/// Repairs a divided outline, whose chords may cross where the outline itself does not.
fn repair_points(all: &mut [Vec<OutlinePoint>], sizes: &[f64], kept: &[bool]) {
    let points: Vec<OutlinePoint> = all.iter().flatten().copied().collect();
    let places = points.iter().map(|p| p.place).collect();
    let mut outline = BodyMesh { points: places, quads: Vec::new(), sizes: sizes.to_vec() };
    let (mut first, mut loops) = (0, Vec::new());
    for list in &*all {
        let count = list.len() as u32;
        let edge = |(i, point): (u32, &OutlinePoint)| BoundaryEdge {
            ends: [first + i, first + (i + 1) % count],
            side: point.side,
            is_fixed: false,
        };
        loops.push((0..).zip(list).map(edge).collect());
        first += count;
    }
    repair(&mut outline, &mut loops, &points.iter().map(|p| is_kept_point(p, kept)).collect::<Vec<bool>>());
    for (list, edges) in all.iter_mut().zip(loops) {
        let point = |edge: &BoundaryEdge| {
            let n = edge.ends[0] as usize;
            OutlinePoint { place: outline.points[n], parents: points[n].parents, side: edge.side }
        };
        *list = edges.iter().map(point).collect();
    }
}

/// Relates a mesh, whose first points are those of the outline, to the old one.
fn revision_of(mesh: BodyMesh, all: &[Vec<OutlinePoint>]) -> MeshRevision {
    let mut revision = MeshRevision { mesh, ..MeshRevision::default() };
    let mut outline: FxHashMap<[u32; 2], (u32, u8)> = FxHashMap::default();
    for points in all {
        let (first, count) = (revision.parents.len() as u32, points.len() as u32);
        for (i, point) in (0..).zip(points) {
            revision.parents.push(point.parents);
            outline.insert([first + i, first + (i + 1) % count], point.side);
        }
    }
    revision.parents.resize(revision.mesh.points.len(), [INSIDE; 2]);
    for (e, quad) in (0..).zip(&revision.mesh.quads) {
        for side in 0..4 {
            if let Some(old) = outline.get(&[quad[side], quad[(side + 1) % 4]]) {
                revision.sides.push(RevisedSide { new: (e, side as u8), old: *old });
            }
        }
    }
    revision
}

/// Returns whether a point of a mesh has no element.
fn has_loose_points(mesh: &BodyMesh) -> bool {
    let mut is_used = vec![false; mesh.points.len()];
    mesh.quads.iter().flatten().for_each(|n| is_used[*n as usize] = true);
    is_used.contains(&false)
}

/// Returns the smallest angle of elements, or the smallest difference of an angle from 180 degrees, radians; negative if
/// an element is not convex.
pub fn sharpest(quads: &[[u32; 4]], place: impl Fn(u32) -> [f64; 2]) -> f64 {
    libm::asin(quads.iter().map(|quad| smallest_sine(quad, &place)).fold(1.0, f64::min))
}

/// Returns whether [`sharpest`] is below a limit, radians. The angles of most elements are compared without roots.
pub fn is_sharper(quads: &[[u32; 4]], place: impl Fn(u32) -> [f64; 2], limit: f64) -> bool {
    let square = libm::sin(limit) * libm::sin(limit);
    let is_clear = |quad: &[u32; 4]| {
        (0.0..FRAC_PI_2).contains(&limit) && has_larger_sines(quad, &place, square * (1.0 + ROUNDING))
    };
    quads.iter().any(|quad| !is_clear(quad) && libm::asin(smallest_sine(quad, &place)) < limit)
}

#[cfg(test)]
mod tests {
    use super::{OutlineRules, is_sharper, new_mesh, sharpest};
    use crate::kernel::quad::stable_edge;
    use crate::kernel::shape::{corner_shape, is_triangle};
    use crate::remesh::BodyMesh;

    fn block(n: u32, m: u32, place: impl Fn(f64, f64) -> [f64; 2]) -> BodyMesh {
        let mut mesh = BodyMesh::default();
        for j in 0..=m {
            for i in 0..=n {
                mesh.points.push(place(f64::from(i) / f64::from(n), f64::from(j) / f64::from(m)));
            }
        }
        for j in 0..m {
            for i in 0..n {
                let a = i + j * (n + 1);
                mesh.quads.push([a, a + 1, a + n + 2, a + n + 1]);
                mesh.sizes.push(1.0 / f64::from(n));
            }
        }
        mesh
    }

    fn area(mesh: &BodyMesh) -> f64 {
        let twice = |quad: &[u32; 4]| {
            let [a, b, c, d] = quad.map(|n| mesh.points[n as usize]);
            (c[0] - a[0]) * (d[1] - b[1]) - (c[1] - a[1]) * (d[0] - b[0])
        };
        0.5 * mesh.quads.iter().map(twice).sum::<f64>()
    }

    fn rules(kept: &[bool]) -> OutlineRules<'_> {
        OutlineRules { kept, fixed: &[], place: &|_, _| None }
    }

    /// The answers are those of the smallest angle, also at limits that equal it, and in a concave element.
    #[test]
    fn comparison_without_roots_agrees_with_the_smallest_angle() {
        for bend in [0.0, 0.05, 0.2, 0.9, 1.6] {
            let mesh = block(4, 4, |x, y| [x + bend * y * (1.0 - y), y + 0.5 * bend * x * y]);
            for quad in &mesh.quads {
                let (place, quads) = (|n: u32| mesh.points[n as usize], [*quad]);
                let angle = sharpest(&quads, place);
                for limit in [angle - 1e-12, angle, angle.next_up(), angle + 1e-12, 0.2, 0.0, -0.1] {
                    assert_eq!(is_sharper(&quads, place, limit), angle < limit, "{bend}: {angle} {limit}");
                }
            }
        }
    }

    #[test]
    fn a_block_is_filled_with_valid_elements_of_the_wanted_size() {
        let old = block(8, 16, |x, y| [x, 2.0 * y]);
        let kept_nodes = vec![false; old.points.len()];
        let new = new_mesh(&old, &rules(&kept_nodes), None).expect("a mesh");
        assert!((area(&new.mesh) - 2.0).abs() < 1e-12);
        let count = new.mesh.quads.len();
        assert!((100..160).contains(&count), "{count} elements");
        assert!(!new.mesh.quads.iter().any(is_triangle));
        let angle = sharpest(&new.mesh.quads, |n| new.mesh.points[n as usize]).to_degrees();
        assert!(angle > 30.0, "{angle} degrees");
        assert_eq!(new.sides.len(), new.parents.iter().filter(|p| p[0] != super::INSIDE).count());
    }

    /// Fragments that are too small for three edges of the wanted length keep their nodes.
    #[test]
    fn small_fragments_keep_their_elements() {
        for width in [0.01, 0.05, 0.1] {
            let mut old = block(8, 16, |x, y| [x, 2.0 * y]);
            let first = old.points.len() as u32;
            old.points.extend([[3.0, 0.0], [3.0 + width, 0.0], [3.0 + width, width], [3.0, width]]);
            old.quads.push([0, 1, 2, 3].map(|corner| first + corner));
            old.sizes.push(0.125);
            let kept_nodes = vec![false; old.points.len()];
            let new = new_mesh(&old, &rules(&kept_nodes), None).expect("a mesh");
            let is_used = |n: usize| new.mesh.quads.iter().flatten().any(|corner| *corner as usize == n);
            assert!((0..new.mesh.points.len()).all(is_used), "{width}");
            assert!((area(&new.mesh) - area(&old)).abs() < 1e-12, "{width}");
        }
    }

    /// The stable time increment is at least 0.75 times that of the old mesh, squares of the wanted size from the axis on,
    /// also in a bell.
    #[test]
    fn new_meshes_have_nearly_the_stable_time_increment_of_squares() {
        let squares = block(8, 24, |x, y| [x, 3.0 * y]);
        let bell = block(8, 24, |x, y| [x + 0.9 * x * libm::exp(-3.0 * y), 3.0 * y]);
        let smallest = |mesh: &BodyMesh| {
            mesh.quads.iter().map(|quad| stable_edge(mesh.corners(quad))).fold(f64::INFINITY, f64::min)
        };
        let square = smallest(&squares);
        for old in [squares, bell] {
            let new = new_mesh(&old, &rules(&vec![false; old.points.len()]), None).expect("a mesh");
            assert!(smallest(&new.mesh) > 0.75 * square, "{} of {square}", smallest(&new.mesh));
        }
    }

    #[test]
    fn a_mushroom_is_filled_with_valid_elements() {
        // A foot three times as wide as the shaft, with strongly flattened elements.
        let old = block(10, 40, |x, y| {
            let wide = 1.0 + 2.0 / (1.0 + (60.0 * (y - 0.08)) * (60.0 * (y - 0.08)).abs() + 1.0).abs();
            [x * wide, 4.0 * y]
        });
        let kept_nodes = vec![false; old.points.len()];
        let new = new_mesh(&old, &rules(&kept_nodes), None).expect("a mesh");
        assert!(new.mesh.quads.iter().all(|quad| corner_shape(quad, &new.mesh.points) > 0.1));
        let angle = sharpest(&new.mesh.quads, |n| new.mesh.points[n as usize]).to_degrees();
        assert!(angle > 10.0, "{angle} degrees");
        // The outline is kept to second order.
        assert!((area(&new.mesh) / area(&old) - 1.0).abs() < 0.01);
    }
}
