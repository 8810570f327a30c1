//! Bodies of elements that lie in each other at the start although nothing joins them: told before a run.
//! Never here: contact, what happens later.

use super::Compiler;
use super::pieces::pieces;
use crate::deck::{Diagnostic, Span};
use crate::model::{Sides, SurfaceContact};

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
                if !pieces[a].meets(&pieces[b]) || self.may_meet([&pieces[a], &pieces[b]]) {
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
        self.diagnostics.push(finding.help("move them apart, give them common nodes, or let them meet (*CONTACT)"));
    }

    fn section_of(&self, element: usize) -> Span {
        let section = self.model.sections.iter().find(|s| s.elements.contains(&element));
        section.map_or(self.model.mesh.elements[element].span, |s| s.span)
    }

    /// The pieces that solids make, in the order of their first elements.
    fn pieces(&self) -> Vec<Piece> {
        let mesh = &self.model.mesh;
        let solids: Vec<usize> = (0..mesh.elements.len()).filter(|&e| mesh.elements[e].kind.is_solid()).collect();
        let piece = |elements: Vec<usize>| {
            let places: Vec<[f64; 2]> =
                elements.iter().flat_map(|&e| &mesh.elements[e].nodes).map(|&n| mesh.points[n]).collect();
            let most = |f: fn(f64, f64) -> f64| [0, 1].map(|i| places.iter().map(|p| p[i]).reduce(f).unwrap_or(0.0));
            Piece { low: most(f64::min), high: most(f64::max), elements }
        };
        pieces(mesh, &solids).into_iter().map(piece).collect()
    }

    /// Whether a step has contact between two pieces.
    fn may_meet(&self, pieces: [&Piece; 2]) -> bool {
        let on = |sides: &Sides, piece: &Piece| sides.faces.iter().any(|f| piece.elements.binary_search(&f.0).is_ok());
        let between = |c: &SurfaceContact, [a, b]: [&Piece; 2]| on(&c.sides[0], a) && on(&c.sides[1], b);
        self.pairs.iter().flatten().any(|c| between(c, pieces) || between(c, [pieces[1], pieces[0]]))
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

    /// The outside of a piece.
    fn skin(&self, piece: &Piece) -> Vec<[[f64; 2]; 2]> {
        let mesh = &self.model.mesh;
        let own = mesh.outside().into_iter().filter(|f| piece.elements.binary_search(&f.0).is_ok());
        own.filter_map(|(e, side)| mesh.ends(e, side)).map(|edge| edge.map(|n| mesh.points[n])).collect()
    }
}

/// Distance of a point from an edge, and the length of that.
fn distance(p: [f64; 2], [a, b]: [[f64; 2]; 2]) -> (f64, f64) {
    let (t, d) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let square = t[0] * t[0] + t[1] * t[1];
    let at = ((d[0] * t[0] + d[1] * t[1]) / square).clamp(0.0, 1.0);
    (libm::hypot(d[0] - at * t[0], d[1] - at * t[1]), square.sqrt())
}
