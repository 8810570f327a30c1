//! Bodies of elements between which nothing acts: those that lie in each other at the start are told before a run, the others
//! are looked at while it lasts.
//! Never here: contact, how they are looked at.

use std::collections::HashMap;

use super::pieces::pieces;
use super::{Compiler, State};
use crate::constraint::Constraint;
use crate::constraint::contact::curve::Carrier;
use crate::constraint::overlaps::{Outline, Overlaps, distance};
use crate::deck::{Diagnostic, Span};
use crate::kernel::lists::sorted_unique;
use crate::model::{ElementKind, Mesh, Side, Sides, SurfaceContact};

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

    /// Whether what an element belongs to moves in space.
    fn is_spatial(&self, element: usize) -> bool {
        self.body_of_element.get(&element).is_some_and(|&b| self.bodies[b].spatial)
    }

    /// The pieces that solids make, in the order of their first elements.
    fn pieces(&self) -> Vec<Piece> {
        self.pieces_of(ElementKind::is_solid)
    }

    /// A look at bodies that may come to lie in each other without contact; `None` where there are none.
    pub(super) fn unpaired_bodies(&mut self, state: &State) -> Option<Box<dyn Constraint>> {
        let lines = self.pieces_of(|kind| kind == ElementKind::Rax2);
        let solids = self.pieces();
        let count = solids.len();
        let all: Vec<Piece> = solids.into_iter().chain(lines).collect();
        let deforms = |piece: &Piece| self.places.elements.contains_key(&piece.elements[0]);
        let mut pairs = Vec::new();
        for a in 0..count {
            for b in a + 1..all.len() {
                if (deforms(&all[a]) || deforms(&all[b])) && !self.may_meet([&all[a], &all[b]]) {
                    pairs.push([a, b]);
                }
            }
        }
        let step = self.model.steps.first().filter(|_| !pairs.is_empty())?;
        let outside = self.model.mesh.outside();
        let outlines: Vec<Outline> = all.iter().map(|piece| self.outline(piece, &outside, state)).collect();
        pairs.retain(|pair| pair.iter().any(|&body| !outlines[body].faces.is_empty()));
        if pairs.is_empty() {
            return None;
        }
        let detail = "whether they come to lie in each other: nothing acts between them";
        let id = self.cause(step.span, "look at bodies", pairs.len(), "pairs", detail.into());
        Some(Box::new(Overlaps::new(id, outlines, pairs)))
    }

    /// The outside of a piece. Where elements can be deleted it changes: there its points alone are looked at.
    fn outline(&self, piece: &Piece, outside: &[(usize, Side)], state: &State) -> Outline {
        let mesh: &Mesh = &self.model.mesh;
        let group = self.places.elements.get(&piece.elements[0]).map(|place| place.0);
        let encloses = mesh.elements[piece.elements[0]].kind.is_solid()
            && group.is_none_or(|_| {
                let groups = piece.elements.iter().filter_map(|e| self.places.elements.get(e));
                groups.map(|place| &state.elements.groups[place.0]).all(|group| !group.properties().deletable)
            });
        let (mut points, mut known, mut faces) = (Vec::new(), HashMap::new(), Vec::new());
        let mut add = |node: usize| {
            *known.entry(node).or_insert_with(|| {
                points.push(match self.places.free_node(node) {
                    Some(place) => Carrier::Node(place),
                    None => {
                        let body = self.places.tied.get(&node).or_else(|| self.body_of_node.get(&node));
                        Carrier::Body(body.copied().unwrap_or(0), mesh.points[node])
                    }
                });
                points.len() as u32 - 1
            })
        };
        let edges = outside.iter().filter(|f| piece.elements.binary_search(&f.0).is_ok());
        for ends in edges.filter_map(|&(e, side)| mesh.ends(e, side)) {
            faces.push(ends.map(&mut add));
        }
        if !mesh.elements[piece.elements[0]].kind.is_solid() {
            piece.elements.iter().flat_map(|&e| &mesh.elements[e].nodes).for_each(|&n| {
                add(n);
            });
        }
        if !encloses {
            faces.clear();
        }
        Outline { name: self.name_of_piece(&piece.elements, &[]), points, faces }
    }

    fn pieces_of(&self, is: impl Fn(ElementKind) -> bool) -> Vec<Piece> {
        let mesh = &self.model.mesh;
        let solids: Vec<usize> =
            (0..mesh.elements.len()).filter(|&e| is(mesh.elements[e].kind) && !self.is_spatial(e)).collect();
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
        self.pairs
            .iter()
            .flat_map(|pairs| pairs.iter())
            .any(|c| between(c, pieces) || between(c, [pieces[1], pieces[0]]))
    }

    /// How many nodes of one piece lie within another, further behind its skin than what fits, and how deep.
    fn inside(&self, piece: &Piece, other: &Piece) -> (usize, f64) {
        let mesh = &self.model.mesh;
        let mut nodes: Vec<usize> =
            sorted_unique(piece.elements.iter().flat_map(|&e| mesh.elements[e].nodes.iter().copied()));
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

    fn skin(&self, piece: &Piece) -> Vec<[[f64; 2]; 2]> {
        let mesh = &self.model.mesh;
        let own = mesh.outside().into_iter().filter(|f| piece.elements.binary_search(&f.0).is_ok());
        own.filter_map(|(e, side)| mesh.ends(e, side)).map(|edge| edge.map(|n| mesh.points[n])).collect()
    }
}
