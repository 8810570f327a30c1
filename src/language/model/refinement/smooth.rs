//! Smooth curves through the nodes of boundaries and interfaces that the deck lists as polylines.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::curves::{EdgeCurves, Tangents};
use super::edges::EdgeTable;
use crate::kernel::lists::sorted_pair;
use crate::model::coarsening::quadrilaterals::Regions;
use crate::model::types::Mesh;

type Vector = [f64; 2];

/// Turning angle in radians below which a polyline is straight.
const STRAIGHT: f64 = 1e-4;
/// Largest angle between the tangent of a curve and the next edge, relative to the turning angle, at the begin of a
/// straight part. It is 0.5 on an arc with equal edges.
const TANGENT: f64 = 0.25;

fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1]]
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn unit(a: Vector) -> Vector {
    let length = dot(a, a).sqrt();
    a.map(|x| x / length)
}

/// Returns the angle between two vectors.
fn angle(a: Vector, b: Vector) -> f64 {
    (a[0] * b[1] - a[1] * b[0]).abs().atan2(dot(a, b))
}

/// Returns the direction at the middle point of the circle through three points.
fn circle_direction([a, b, c]: [Vector; 3]) -> Vector {
    let (u, v) = (minus(b, a), minus(c, b));
    let (p, q) = (1.0 / dot(u, u), 1.0 / dot(v, v));
    unit([0, 1].map(|i| p * u[i] + q * v[i]))
}

/// Returns the direction at the other end of the arc that has a direction at one end of a chord.
fn reflected(direction: Vector, chord: Vector) -> Vector {
    let chord = unit(chord);
    let along = 2.0 * dot(direction, chord);
    [0, 1].map(|i| along * chord[i] - direction[i])
}

/// Adds curves to the edges of boundaries, of interfaces of regions, and of shells and rigid surfaces. They go through all
/// nodes, and have a continuous direction where the polyline turns by at most `corner` (radians).
pub fn fit(mesh: &Mesh, regions: &Regions, corner: f64, curves: &mut EdgeCurves) {
    let edges = EdgeTable::new(&mesh.elements);
    let is_interface = |[a, b]: [usize; 2]| regions.get(&a) != regions.get(&b);
    let is_on_axis = |ends: &[usize; 2]| ends.iter().all(|&n| mesh.points[n][0] == 0.0);
    let curved_edges = edges.iter().filter(|(_, edge)| edge.is_line || edge.solids == 1 || is_interface(edge.elements));
    let mut network = Network { mesh, corner, neighbours: BTreeMap::new() };
    for (&[a, b], _) in curved_edges.filter(|(ends, _)| !is_on_axis(ends)) {
        network.neighbours.entry(a).or_default().push(b);
        network.neighbours.entry(b).or_default().push(a);
    }
    let mut known: HashMap<[[u64; 2]; 2], Tangents> = HashMap::new();
    for run in network.runs() {
        for (pair, tangents) in run.windows(2).zip(network.tangents(&run)) {
            let Some(tangents) = tangents else { continue };
            // Bodies in contact have the same curve on coincident edges.
            let [a, b] = [pair[0], pair[1]].map(|n| mesh.points[n].map(f64::to_bits));
            let tangents = match (known.get(&[a, b]), known.get(&[b, a])) {
                (Some(&same), _) => same,
                (None, Some(&[from, to])) => [to.map(|x| -x), from.map(|x| -x)],
                (None, None) => *known.entry([a, b]).or_insert(tangents),
            };
            curves.record_smooth([pair[0], pair[1]], tangents);
        }
    }
}

/// Edges that may be curved.
struct Network<'m> {
    mesh: &'m Mesh,
    /// Largest turning angle inside a curve, radians.
    corner: f64,
    neighbours: BTreeMap<usize, Vec<usize>>,
}

impl Network<'_> {
    /// Returns whether a curve continues at a node.
    fn is_smooth(&self, node: usize) -> bool {
        match self.neighbours[&node][..] {
            [a, b] => {
                let [a, node, b] = [a, node, b].map(|n| self.mesh.points[n]);
                angle(minus(node, a), minus(b, node)) <= self.corner
            }
            _ => false,
        }
    }

    /// Returns the nodes of each smooth part between corners; a closed one begins and ends with the same node.
    fn runs(&self) -> Vec<Vec<usize>> {
        let mut visited: HashSet<[usize; 2]> = HashSet::new();
        let ends = self.neighbours.keys().copied().filter(|&node| !self.is_smooth(node));
        let nodes = self.neighbours.keys().copied();
        let mut runs = Vec::new();
        for start in ends.chain(nodes) {
            for &next in &self.neighbours[&start] {
                let mut run = vec![start];
                let (mut previous, mut node) = (start, next);
                while visited.insert(sorted_pair([previous, node])) {
                    run.push(node);
                    let following = self.neighbours[&node].iter().copied().find(|&n| n != previous);
                    let Some(following) = following.filter(|_| node != start && self.is_smooth(node)) else { break };
                    (previous, node) = (node, following);
                }
                if run.len() > 1 {
                    runs.push(run);
                }
            }
        }
        runs
    }

    /// Returns the tangents at both ends of each edge of a run; `None` for straight edges.
    fn tangents(&self, run: &[usize]) -> Vec<Option<Tangents>> {
        let mut points: Vec<Vector> = run.iter().map(|&n| self.mesh.points[n]).collect();
        let (last, is_closed) = (points.len() - 1, run[0] == run[run.len() - 1]);
        let (point_before, point_after) = if is_closed && self.is_smooth(run[0]) {
            (Some(points[last - 1]), Some(points[1]))
        } else {
            (self.mirrored(points[1], points[0]), self.mirrored(points[last - 1], points[last]))
        };
        points.splice(0..0, point_before);
        points.extend(point_after);
        let first = usize::from(point_before.is_some());
        let smooth = SmoothRun::new(points);
        (first..first + last).map(|edge| smooth.tangents(edge)).collect()
    }

    /// Returns the mirror image of a point across the axis, if a curve continues smoothly there.
    fn mirrored(&self, point: Vector, end: Vector) -> Option<Vector> {
        let image = [-point[0], point[1]];
        (end[0] == 0.0 && angle(minus(end, point), minus(image, end)) <= self.corner).then_some(image)
    }
}

/// A polyline without corners.
struct SmoothRun {
    points: Vec<Vector>,
    /// Turning angle at each point; zero at the ends.
    turning: Vec<f64>,
    /// Whether each edge is straight.
    is_straight: Vec<bool>,
}

impl SmoothRun {
    fn new(points: Vec<Vector>) -> SmoothRun {
        let edges = points.len() - 1;
        let mut turning = vec![0.0; points.len()];
        for at in 1..edges {
            turning[at] = angle(minus(points[at], points[at - 1]), minus(points[at + 1], points[at]));
        }
        let ends_straight = |at: usize| (1..edges).contains(&at) && turning[at] < STRAIGHT;
        let is_straight: Vec<bool> =
            (0..edges).map(|e| edges == 1 || ends_straight(e) || ends_straight(e + 1)).collect();
        let mut run = SmoothRun { points, turning, is_straight };
        let [first, last] = [run.begins_straight(1, 1), run.begins_straight(edges - 1, -1)];
        run.is_straight[0] |= first;
        run.is_straight[edges - 1] |= last;
        run
    }

    /// Returns the direction from the point `at` into the part of the run on one side, if two curved edges are there:
    /// that of the circle through three points.
    fn direction_from(&self, at: usize, side: isize) -> Option<Vector> {
        let places = [at.checked_add_signed(side)?, at.checked_add_signed(2 * side)?];
        let [near, far] = if side < 0 { places } else { [at, places[0]] };
        if self.is_straight.get(near) != Some(&false) || self.is_straight.get(far) != Some(&false) {
            return None;
        }
        let [b, c] = places.map(|place| self.points.get(place).copied());
        let (a, b, c) = (self.points[at], b?, c?);
        Some(reflected(circle_direction([a, b, c]), minus(b, a)))
    }

    /// Returns whether the end edge at the point `at` is tangential to the curve on the other side.
    fn begins_straight(&self, at: usize, side: isize) -> bool {
        let Some(end) = at.checked_add_signed(-side).map(|end| self.points[end]) else { return false };
        let edge = minus(self.points[at], end);
        self.direction_from(at, side).is_some_and(|curve| angle(curve, edge) < TANGENT * self.turning[at])
    }

    /// Returns the direction of the curve at a point, along the run, for the edge on one side.
    fn direction(&self, at: usize, edge: usize) -> Option<Vector> {
        let edges = self.is_straight.len();
        if at == 0 || at == edges {
            return None;
        }
        let [before, after] = [at - 1, at];
        let chord = |e: usize| minus(self.points[e + 1], self.points[e]);
        if !self.is_straight[before] && !self.is_straight[after] {
            return Some(circle_direction([self.points[at - 1], self.points[at], self.points[at + 1]]));
        }
        let straight = unit(chord(if edge == before { after } else { before }));
        let side = if edge == before { -1 } else { 1 };
        match self.direction_from(at, side).map(|d| if side < 0 { d.map(|x| -x) } else { d }) {
            Some(curve) if angle(curve, straight) >= TANGENT * self.turning[at] => Some(curve),
            _ => Some(straight),
        }
    }

    /// Returns the tangents of an edge at both ends, scaled for a cubic curve; on a circle it is an arc up to the sixth
    /// power of its angle.
    fn tangents(&self, edge: usize) -> Option<Tangents> {
        if self.is_straight[edge] {
            return None;
        }
        let chord = minus(self.points[edge + 1], self.points[edge]);
        let (start, end) = match (self.direction(edge, edge), self.direction(edge + 1, edge)) {
            (Some(from), Some(to)) => (from, to),
            (Some(from), None) => (from, reflected(from, chord)),
            (None, Some(to)) => (reflected(to, chord), to),
            (None, None) => return None,
        };
        let (length, along) = (dot(chord, chord).sqrt(), unit(chord));
        Some([start, end].map(|t| t.map(|x| 2.0 * length / (1.0 + dot(t, along)) * x)))
    }
}
