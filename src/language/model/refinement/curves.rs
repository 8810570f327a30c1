//! Curved edges: parts of arcs that `*NGEN, LINE=C` generates, rows of nodes that `*NFILL` generates between them, and
//! smooth curves through listed nodes. `*NCOPY` and `*NMAP` keep them.

use std::collections::HashMap;

use crate::kernel::lists::sorted_pair;

/// Largest difference of the distances of both ends of an arc from its centre, relative to the radius.
const ROUND: f64 = 1e-6;
/// Largest number of `*NFILL` cards that generate rows from rows of each other.
const DEEPEST: usize = 16;

/// Derivatives of a cubic curve at both ends of an edge, with respect to the fraction of the edge.
pub type Tangents = [[f64; 2]; 2];

/// Shape of an edge from its node with the lower index to the other one.
#[derive(Clone, Copy, Debug)]
enum EdgeCurve {
    /// An arc: centre, and direction as for [`on_arc`].
    Arc { centre: [f64; 2], normal: f64 },
    /// Part of a row between two edges, at this fraction of the distance from the first one.
    Row { share: f64, rows: [[usize; 2]; 2] },
    /// A cubic curve (Hermite).
    Cubic(Tangents),
}

/// Edges that are not straight.
#[derive(Debug, Default)]
pub struct EdgeCurves {
    curves: HashMap<[usize; 2], EdgeCurve>,
    /// Nodes that are mapped from polar coordinates, with the index of their system, radius and angle in degrees. Edges
    /// between them are straight in these coordinates.
    polar: HashMap<usize, (usize, [f64; 2])>,
    /// Polar systems, as maps from their Cartesian coordinates.
    systems: Vec<AffineMap>,
}

/// An affine map of the r-z plane.
#[derive(Clone, Copy, Debug)]
pub struct AffineMap {
    /// Image of the origin.
    origin: [f64; 2],
    /// Images of the unit vectors.
    axes: [[f64; 2]; 2],
}

impl AffineMap {
    /// Returns the map of an affine function.
    pub fn of(map: impl Fn([f64; 2]) -> [f64; 2]) -> AffineMap {
        let origin = map([0.0, 0.0]);
        let axis = |unit| [0, 1].map(|i| map(unit)[i] - origin[i]);
        AffineMap { origin, axes: [axis([1.0, 0.0]), axis([0.0, 1.0])] }
    }

    fn vector(&self, v: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| v[0] * self.axes[0][i] + v[1] * self.axes[1][i])
    }

    fn point(&self, p: [f64; 2]) -> [f64; 2] {
        let v = self.vector(p);
        [0, 1].map(|i| self.origin[i] + v[i])
    }

    /// Returns the sign of the map: -1 for a reflection; `None` if circles do not remain circles.
    fn sign_of_similarity(&self) -> Option<f64> {
        let [[a, b], [c, d]] = self.axes;
        let (first, second) = (a * a + b * b, c * c + d * d);
        let is_similar = (first - second).abs() < ROUND * first && (a * c + b * d).abs() < ROUND * first;
        is_similar.then_some((a * d - b * c).signum())
    }
}

impl EdgeCurve {
    /// Returns the curve in the opposite direction.
    fn reversed(self) -> EdgeCurve {
        match self {
            EdgeCurve::Arc { centre, normal } => EdgeCurve::Arc { centre, normal: -normal },
            EdgeCurve::Row { share, rows } => EdgeCurve::Row { share, rows: rows.map(|[a, b]| [b, a]) },
            EdgeCurve::Cubic([from, to]) => EdgeCurve::Cubic([to, from].map(|t| t.map(|x| -x))),
        }
    }

    /// Returns the image of the curve; `None` if it has no such form. `nodes` are the images of nodes.
    fn image(&self, nodes: &HashMap<usize, usize>, map: &AffineMap) -> Option<EdgeCurve> {
        Some(match *self {
            EdgeCurve::Arc { centre, normal } => {
                EdgeCurve::Arc { centre: map.point(centre), normal: map.sign_of_similarity()? * normal }
            }
            EdgeCurve::Row { share, rows: [[a, b], [c, d]] } => {
                let image = |node: usize| nodes.get(&node).copied();
                EdgeCurve::Row { share, rows: [[image(a)?, image(b)?], [image(c)?, image(d)?]] }
            }
            EdgeCurve::Cubic(tangents) => EdgeCurve::Cubic(tangents.map(|t| map.vector(t))),
        })
    }
}

impl EdgeCurves {
    /// Records that consecutive nodes are connected by arcs around a centre.
    pub fn record_arc(&mut self, nodes: &[usize], centre: [f64; 2], normal: f64) {
        for pair in nodes.windows(2) {
            let sign = if pair[0] < pair[1] { 1.0 } else { -1.0 };
            self.curves.insert(sorted_pair([pair[0], pair[1]]), EdgeCurve::Arc { centre, normal: sign * normal });
        }
    }

    /// Records the images of curves under a map of nodes: copies, or the moved nodes themselves. Returns whether a curve
    /// has no image of its form, so that the edge is straight.
    pub fn record_images(&mut self, nodes: &HashMap<usize, usize>, map: &AffineMap) -> bool {
        let inside = |key: &[usize; 2]| Some([*nodes.get(&key[0])?, *nodes.get(&key[1])?]);
        let images: Vec<([usize; 2], Option<EdgeCurve>)> =
            self.curves.iter().filter_map(|(key, curve)| Some((inside(key)?, curve.image(nodes, map)))).collect();
        let is_lost = images.iter().any(|image| image.1.is_none());
        for (ends, image) in images {
            let image = image.map(|curve| if ends[0] < ends[1] { curve } else { curve.reversed() });
            match image {
                Some(curve) => drop(self.curves.insert(sorted_pair(ends), curve)),
                None => drop(self.curves.remove(&sorted_pair(ends))),
            }
        }
        let mut systems: HashMap<usize, usize> = HashMap::new();
        for (old, new) in nodes {
            let Some(&(system, local)) = self.polar.get(old) else { continue };
            let image = *systems.entry(system).or_insert_with(|| {
                let AffineMap { origin, axes } = self.systems[system];
                self.systems.push(AffineMap { origin: map.point(origin), axes: axes.map(|axis| map.vector(axis)) });
                self.systems.len() - 1
            });
            self.polar.insert(*new, (image, local));
        }
        is_lost
    }

    /// Records nodes that are mapped from polar coordinates: radius, and angle in degrees.
    pub fn record_polar(&mut self, nodes: impl Iterator<Item = (usize, [f64; 2])>, system: AffineMap) {
        let index = self.systems.len();
        self.systems.push(system);
        self.polar.extend(nodes.map(|(node, local)| (node, (index, local))));
        let polar = &self.polar;
        let is_here = |node: &usize| polar.get(node).is_some_and(|place| place.0 == index);
        self.curves.retain(|ends, _| !ends.iter().all(is_here));
    }

    /// Returns whether an edge may be curved.
    fn is_curved(&self, edge: [usize; 2]) -> bool {
        let systems = edge.map(|node| self.polar.get(&node).map(|place| place.0));
        self.curves.contains_key(&sorted_pair(edge)) || systems[0].is_some() && systems[0] == systems[1]
    }

    /// Records a cubic curve from the first to the second node, unless the edge has a curve.
    pub fn record_smooth(&mut self, nodes: [usize; 2], [from, to]: Tangents) {
        let tangents = if nodes[0] < nodes[1] { [from, to] } else { [to, from].map(|t| t.map(|x| -x)) };
        self.curves.entry(sorted_pair(nodes)).or_insert(EdgeCurve::Cubic(tangents));
    }

    /// Records edges of rows between two lines, if one line is curved there. `rows` are the nodes between each pair of
    /// nodes of the lines, at the fractions `shares`.
    pub fn record_rows(&mut self, lines: [&[usize]; 2], rows: &[Vec<usize>], shares: &[f64]) {
        for at in 1..rows.len() {
            let ends = lines.map(|line| [line[at - 1], line[at]]);
            if !ends.iter().any(|end| self.is_curved(*end)) {
                continue;
            }
            for ((&a, &b), &share) in rows[at - 1].iter().zip(&rows[at]).zip(shares) {
                let rows = if a < b { ends } else { ends.map(|[from, to]| [to, from]) };
                self.curves.insert(sorted_pair([a, b]), EdgeCurve::Row { share, rows });
            }
        }
    }

    /// Returns the offset of an edge from the straight line between its nodes, at a fraction of its length.
    pub fn offset(&self, points: &[[f64; 2]], edge: [usize; 2], share: f64) -> [f64; 2] {
        if self.curves.is_empty() && self.polar.is_empty() || share <= 0.0 || share >= 1.0 {
            [0.0; 2]
        } else {
            self.at(points, edge, share, 0)
        }
    }

    fn at(&self, points: &[[f64; 2]], edge: [usize; 2], share: f64, depth: usize) -> [f64; 2] {
        let key = sorted_pair(edge);
        let along = if key == edge { share } else { 1.0 - share };
        match self.curves.get(&key) {
            Some(&EdgeCurve::Arc { centre, normal }) => arc_offset(key.map(|node| points[node]), centre, normal, along),
            Some(EdgeCurve::Row { share, rows }) if depth < DEEPEST => {
                let [a, b] = rows.map(|row| self.at(points, row, along, depth + 1));
                [0, 1].map(|i| (1.0 - share) * a[i] + share * b[i])
            }
            Some(EdgeCurve::Cubic(tangents)) => cubic_offset(key.map(|node| points[node]), tangents, along),
            None => self.polar_offset(points, key, along),
            Some(EdgeCurve::Row { .. }) => [0.0; 2],
        }
    }

    /// Returns the offset of an edge that is straight in polar coordinates.
    fn polar_offset(&self, points: &[[f64; 2]], edge: [usize; 2], share: f64) -> [f64; 2] {
        let [Some((system, a)), Some((other, b))] = edge.map(|node| self.polar.get(&node)) else { return [0.0; 2] };
        if system != other || a[1] == b[1] {
            return [0.0; 2];
        }
        let [radius, angle] = [0, 1].map(|i| a[i] + share * (b[i] - a[i]));
        let position = self.systems[*system].point(polar_point(radius, angle));
        let [from, to] = edge.map(|node| points[node]);
        [0, 1].map(|i| position[i] - from[i] - share * (to[i] - from[i]))
    }
}

/// Returns the offset of a cubic curve from its chord.
fn cubic_offset([a, b]: [[f64; 2]; 2], [from, to]: &Tangents, s: f64) -> [f64; 2] {
    let complement = 1.0 - s;
    [0, 1].map(|i| s * complement * (complement * (from[i] - (b[i] - a[i])) - s * (to[i] - (b[i] - a[i]))))
}

/// Returns the offset of an arc from its chord; zero if the nodes were moved off the arc.
fn arc_offset([a, b]: [[f64; 2]; 2], centre: [f64; 2], normal: f64, share: f64) -> [f64; 2] {
    let square = |p: [f64; 2]| (p[0] - centre[0]).powi(2) + (p[1] - centre[1]).powi(2);
    if (square(a) - square(b)).abs() > 2.0 * ROUND * square(a) {
        return [0.0; 2];
    }
    let position = on_arc(a, b, centre, normal, share);
    [0, 1].map(|i| position[i] - a[i] - share * (b[i] - a[i]))
}

/// Returns the point at fraction `s` of the arc from `a` to `b` around `c`: counter-clockwise for positive `normal`,
/// clockwise for negative, the shorter way for zero.
pub fn on_arc(a: [f64; 2], b: [f64; 2], c: [f64; 2], normal: f64, s: f64) -> [f64; 2] {
    let (u, v) = ([a[0] - c[0], a[1] - c[1]], [b[0] - c[0], b[1] - c[1]]);
    let short = (u[0] * v[1] - u[1] * v[0]).atan2(u[0] * v[0] + u[1] * v[1]);
    let whole = if short * normal < 0.0 { short + normal.signum() * std::f64::consts::TAU } else { short };
    let (sine, cosine) = (s * whole).sin_cos();
    [c[0] + u[0] * cosine - u[1] * sine, c[1] + u[0] * sine + u[1] * cosine]
}

/// Returns the point at a radius and an angle in degrees.
pub fn polar_point(radius: f64, degrees: f64) -> [f64; 2] {
    let (sine, cosine) = match degrees.rem_euclid(360.0) {
        // Multiples of 90 degrees are exact, so that nodes on the axis remain there.
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        other => libm::sincos(other.to_radians()),
    };
    [radius * cosine, radius * sine]
}
