//! Curved edges: parts of arcs that `*NGEN, LINE=C` generates, rows of nodes that `*NFILL` generates between them, and
//! smooth curves through listed nodes.

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
}

impl EdgeCurves {
    /// Records that consecutive nodes are connected by arcs around a centre.
    pub fn record_arc(&mut self, nodes: &[usize], centre: [f64; 2], normal: f64) {
        for pair in nodes.windows(2) {
            let sign = if pair[0] < pair[1] { 1.0 } else { -1.0 };
            self.curves.insert(sorted_pair([pair[0], pair[1]]), EdgeCurve::Arc { centre, normal: sign * normal });
        }
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
            if !ends.iter().any(|end| self.curves.contains_key(&sorted_pair(*end))) {
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
        if self.curves.is_empty() || share <= 0.0 || share >= 1.0 { [0.0; 2] } else { self.at(points, edge, share, 0) }
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
            _ => [0.0; 2],
        }
    }
}

/// Returns the offset of a cubic curve from its chord.
fn cubic_offset([a, b]: [[f64; 2]; 2], [from, to]: &Tangents, s: f64) -> [f64; 2] {
    let rest = 1.0 - s;
    [0, 1].map(|i| s * rest * (rest * (from[i] - (b[i] - a[i])) - s * (to[i] - (b[i] - a[i]))))
}

/// Returns the offset of an arc from its chord; zero if the nodes were moved off the arc.
fn arc_offset([a, b]: [[f64; 2]; 2], centre: [f64; 2], normal: f64, share: f64) -> [f64; 2] {
    let square = |p: [f64; 2]| (p[0] - centre[0]).powi(2) + (p[1] - centre[1]).powi(2);
    if (square(a) - square(b)).abs() > 2.0 * ROUND * square(a) {
        return [0.0; 2];
    }
    let place = on_arc(a, b, centre, normal, share);
    [0, 1].map(|i| place[i] - a[i] - share * (b[i] - a[i]))
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
