//! Overlaps of bodies: a warning for overlaps at the start of bodies without contact, and a check of all bodies during
//! the run.

use std::collections::HashMap;

use super::pieces::pieces;
use super::{Compiler, State};
use crate::constraint::Constraint;
use crate::constraint::contact::curve::PointCarrier;
use crate::constraint::overlaps::{BodyOutline, OverlapMonitor, distance};
use crate::deck::{Diagnostic, Span};
use crate::kernel::lists::sorted_unique;
use crate::model::{ElementKind, ElementSide, Mesh, SideSelection, SurfaceContact};

/// Accepted penetration of a node, as a fraction of the face length: meshes of matching curved surfaces overlap
/// slightly.
const FIT: f64 = 0.05;

/// Connected elements with their bounding box.
struct ConnectedPart {
    elements: Vec<usize>,
    low: [f64; 2],
    high: [f64; 2],
}

impl ConnectedPart {
    fn meets(&self, other: &ConnectedPart) -> bool {
        (0..2).all(|i| self.low[i] < other.high[i] && other.low[i] < self.high[i])
    }

    fn holds(&self, p: [f64; 2]) -> bool {
        (0..2).all(|i| self.low[i] < p[i] && p[i] < self.high[i])
    }
}

impl Compiler<'_> {
    /// Warns of overlapping parts, once per pair.
    pub(super) fn report_overlaps(&mut self) {
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
                    self.report_overlap([&pieces[a], &pieces[b]], count, depth);
                }
            }
        }
    }

    fn report_overlap(&mut self, pieces: [&ConnectedPart; 2], count: usize, depth: f64) {
        let mesh = &self.model.mesh;
        let [a, b] = pieces.map(|p| &mesh.elements[p.elements[0]].name);
        let message = format!(
            "the bodies of elements {a} and {b} overlap at the start without contact between them: {count} nodes, up to {depth:.3e} deep"
        );
        let [first, second] = pieces.map(|p| self.section_of(p.elements[0]));
        let finding = Diagnostic::warning("P112", message).at(first, "of this body");
        let finding = if second == first { finding } else { finding.at(second, "and of this one") };
        self.diagnostics.push(finding.help("move them apart, use common nodes, or define contact (*CONTACT)"));
    }

    fn section_of(&self, element: usize) -> Span {
        let section = self.model.sections.iter().find(|s| s.elements.contains(&element));
        section.map_or(self.model.mesh.elements[element].span, |s| s.span)
    }

    /// Returns whether an element belongs to a rigid body with six degrees of freedom.
    fn is_spatial(&self, element: usize) -> bool {
        self.body_of_element.get(&element).is_some_and(|&b| self.bodies[b].spatial)
    }

    /// Returns the connected parts of solid elements, in the order of their first elements.
    fn pieces(&self) -> Vec<ConnectedPart> {
        self.pieces_of(ElementKind::is_solid)
    }

    /// Creates the check of bodies for overlaps; `None` if there are fewer than two.
    pub(super) fn overlapping_bodies(&mut self, state: &State) -> Option<Box<dyn Constraint>> {
        let lines = self.pieces_of(|kind| kind == ElementKind::Rax2);
        let solids = self.pieces();
        let count = solids.len();
        let all: Vec<ConnectedPart> = solids.into_iter().chain(lines).collect();
        let deforms = |piece: &ConnectedPart| self.places.elements.contains_key(&piece.elements[0]);
        let mut pairs = Vec::new();
        for a in 0..count {
            for b in a + 1..all.len() {
                if deforms(&all[a]) || deforms(&all[b]) {
                    pairs.push(([a, b], self.may_meet([&all[a], &all[b]])));
                }
            }
        }
        let step = self.model.steps.first().filter(|_| !pairs.is_empty())?;
        let outside = self.model.mesh.exterior_faces();
        let outlines: Vec<BodyOutline> = all.iter().map(|piece| self.outline(piece, &outside, state)).collect();
        pairs.retain(|(pair, _)| pair.iter().any(|&body| !outlines[body].faces.is_empty()));
        if pairs.is_empty() {
            return None;
        }
        let detail = "check for overlap of bodies";
        let id = self.ledger_row(step.span, "look at bodies", pairs.len(), "pairs", detail.into());
        Some(Box::new(OverlapMonitor::new(id, outlines, pairs)))
    }

    /// Returns the outline of a part. If its elements can be deleted, the outline changes, and only its points are
    /// checked.
    fn outline(&self, piece: &ConnectedPart, outside: &[(usize, ElementSide)], state: &State) -> BodyOutline {
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
                    Some(place) => PointCarrier::Node(place),
                    None => {
                        let body = self.places.tied.get(&node).or_else(|| self.body_of_node.get(&node));
                        PointCarrier::Body(body.copied().unwrap_or(0), mesh.points[node])
                    }
                });
                points.len() as u32 - 1
            })
        };
        let edges = outside.iter().filter(|f| piece.elements.binary_search(&f.0).is_ok());
        for ends in edges.filter_map(|&(e, side)| mesh.side_nodes(e, side)) {
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
        BodyOutline { name: self.name_of_piece(&piece.elements, &[]), points, faces }
    }

    fn pieces_of(&self, is: impl Fn(ElementKind) -> bool) -> Vec<ConnectedPart> {
        let mesh = &self.model.mesh;
        let solids: Vec<usize> =
            (0..mesh.elements.len()).filter(|&e| is(mesh.elements[e].kind) && !self.is_spatial(e)).collect();
        let piece = |elements: Vec<usize>| {
            let places: Vec<[f64; 2]> =
                elements.iter().flat_map(|&e| &mesh.elements[e].nodes).map(|&n| mesh.points[n]).collect();
            let most = |f: fn(f64, f64) -> f64| [0, 1].map(|i| places.iter().map(|p| p[i]).reduce(f).unwrap_or(0.0));
            ConnectedPart { low: most(f64::min), high: most(f64::max), elements }
        };
        pieces(mesh, &solids).into_iter().map(piece).collect()
    }

    /// Returns whether a step has contact between two parts.
    fn may_meet(&self, pieces: [&ConnectedPart; 2]) -> bool {
        let on = |sides: &SideSelection, piece: &ConnectedPart| {
            sides.faces.iter().any(|f| piece.elements.binary_search(&f.0).is_ok())
        };
        let between = |c: &SurfaceContact, [a, b]: [&ConnectedPart; 2]| on(&c.sides[0], a) && on(&c.sides[1], b);
        self.pairs
            .iter()
            .flat_map(|pairs| pairs.iter())
            .any(|c| between(c, pieces) || between(c, [pieces[1], pieces[0]]))
    }

    /// Returns the number of nodes of a part inside another one, beyond the accepted penetration, and their maximum
    /// depth.
    fn inside(&self, piece: &ConnectedPart, other: &ConnectedPart) -> (usize, f64) {
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
            // Even-odd rule along r.
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

    fn skin(&self, piece: &ConnectedPart) -> Vec<[[f64; 2]; 2]> {
        let mesh = &self.model.mesh;
        let own = mesh.exterior_faces().into_iter().filter(|f| piece.elements.binary_search(&f.0).is_ok());
        own.filter_map(|(e, side)| mesh.side_nodes(e, side)).map(|edge| edge.map(|n| mesh.points[n])).collect()
    }
}
