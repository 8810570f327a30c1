//! Bodies of elements that lie in each other at the start although nothing joins them: told before a run.
//! Never here: contact, what happens later.

use std::collections::{BTreeMap, HashMap};

use super::Compiler;
use crate::deck::{Diagnostic, Span};
use crate::model::ElementKind;

/// Part of a skin's face by which a node may lie behind it: chords of curved surfaces that fit.
const FIT: f64 = 0.05;

/// Elements that hang together by nodes.
struct Piece {
    elements: Vec<usize>,
    low: [f64; 2],
    high: [f64; 2],
}

impl Piece {
    fn meets(&self, other: &Piece) -> bool {
        (0..2).all(|i| self.low[i] < other.high[i] && other.low[i] < self.high[i])
    }

    fn holds(&self, p: [f64; 2]) -> bool {
        (0..2).all(|i| self.low[i] < p[i] && p[i] < self.high[i])
    }
}

impl Compiler<'_> {
    /// Says which pieces overlap, once for each two.
    pub(super) fn tell_overlaps(&mut self) {
        let pieces = self.pieces();
        for a in 0..pieces.len() {
            for b in a + 1..pieces.len() {
                if !pieces[a].meets(&pieces[b]) {
                    continue;
                }
                let found = [self.inside(&pieces[a], &pieces[b]), self.inside(&pieces[b], &pieces[a])];
                let count = found.iter().map(|f| f.0).sum::<usize>();
                let depth = found.iter().map(|f| f.1).fold(0.0, f64::max);
                if count > 0 {
                    self.tell_overlap([&pieces[a], &pieces[b]], count, depth);
                }
            }
        }
    }

    fn tell_overlap(&mut self, pieces: [&Piece; 2], count: usize, depth: f64) {
        let mesh = &self.model.mesh;
        let [a, b] = pieces.map(|p| &mesh.elements[p.elements[0]].name);
        let message = format!(
            "the bodies of elements {a} and {b} lie in each other at the start: {count} nodes, up to {depth:.3e} deep, and nothing acts between them"
        );
        let [first, second] = pieces.map(|p| self.section_of(p.elements[0]));
        let finding = Diagnostic::warning("P112", message).at(first, "of this body");
        let finding = if second == first { finding } else { finding.at(second, "and of this one") };
        self.diagnostics.push(finding.help("move them apart, or give them common nodes"));
    }

    fn section_of(&self, element: usize) -> Span {
        let section = self.model.sections.iter().find(|s| s.elements.contains(&element));
        section.map_or(self.model.mesh.elements[element].span, |s| s.span)
    }

    /// The pieces that solids make, in the order of their first elements.
    fn pieces(&self) -> Vec<Piece> {
        let mesh = &self.model.mesh;
        let mut root: Vec<usize> = (0..mesh.points.len()).collect();
        fn find(root: &mut [usize], mut n: usize) -> usize {
            while root[n] != n {
                root[n] = root[root[n]];
                n = root[n];
            }
            n
        }
        let solids: Vec<usize> = (0..mesh.elements.len())
            .filter(|&e| matches!(mesh.elements[e].kind, ElementKind::Cax3 | ElementKind::Cax4r))
            .collect();
        for &e in &solids {
            let nodes = &mesh.elements[e].nodes;
            let first = find(&mut root, nodes[0]);
            for &n in &nodes[1..] {
                let other = find(&mut root, n);
                root[other] = first;
            }
        }
        let mut by_root: BTreeMap<usize, usize> = BTreeMap::new();
        let mut pieces: Vec<Piece> = Vec::new();
        for e in solids {
            let key = find(&mut root, mesh.elements[e].nodes[0]);
            let at = *by_root.entry(key).or_insert_with(|| {
                let (low, high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
                pieces.push(Piece { elements: Vec::new(), low, high });
                pieces.len() - 1
            });
            let piece = &mut pieces[at];
            piece.elements.push(e);
            for &n in &mesh.elements[e].nodes {
                for i in [0, 1] {
                    piece.low[i] = piece.low[i].min(mesh.points[n][i]);
                    piece.high[i] = piece.high[i].max(mesh.points[n][i]);
                }
            }
        }
        pieces
    }

    /// How many nodes of one piece lie within another, further behind its skin than what fits, and how deep.
    fn inside(&self, piece: &Piece, other: &Piece) -> (usize, f64) {
        let mesh = &self.model.mesh;
        let mut nodes: Vec<usize> = piece.elements.iter().flat_map(|&e| mesh.elements[e].nodes.clone()).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes.retain(|&n| other.holds(mesh.points[n]));
        if nodes.is_empty() {
            return (0, 0.0);
        }
        let skin = self.skin(other);
        let (mut count, mut deepest) = (0, 0.0_f64);
        for n in nodes {
            let p = mesh.points[n];
            // The even-odd rule along r.
            let crosses = |[a, b]: &&[[f64; 2]; 2]| {
                (a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
            };
            if skin.iter().filter(crosses).count() % 2 == 0 {
                continue;
            }
            let near = skin.iter().map(|face| distance(p, *face)).min_by(|x, y| x.0.total_cmp(&y.0));
            if let Some((depth, _)) = near.filter(|(depth, length)| *depth > FIT * length) {
                count += 1;
                deepest = deepest.max(depth);
            }
        }
        (count, deepest)
    }

    /// Edges of a piece that one element alone has.
    fn skin(&self, piece: &Piece) -> Vec<[[f64; 2]; 2]> {
        let mesh = &self.model.mesh;
        let mut edges: HashMap<[usize; 2], usize> = HashMap::new();
        let around = |e: usize| {
            let nodes = &mesh.elements[e].nodes;
            (0..nodes.len()).map(move |i| [nodes[i], nodes[(i + 1) % nodes.len()]])
        };
        for &e in &piece.elements {
            for [a, b] in around(e) {
                *edges.entry([a.min(b), a.max(b)]).or_default() += 1;
            }
        }
        let all = piece.elements.iter().flat_map(|&e| around(e));
        let free = all.filter(|[a, b]| edges[&[*a.min(b), *a.max(b)]] == 1);
        free.map(|edge| edge.map(|n| mesh.points[n])).collect()
    }
}

/// Distance of a point from an edge, and the length of that.
fn distance(p: [f64; 2], [a, b]: [[f64; 2]; 2]) -> (f64, f64) {
    let (t, d) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let square = t[0] * t[0] + t[1] * t[1];
    let at = ((d[0] * t[0] + d[1] * t[1]) / square).clamp(0.0, 1.0);
    (libm::hypot(d[0] - at * t[0], d[1] - at * t[1]), square.sqrt())
}
