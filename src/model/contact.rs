//! Contact with analytical surfaces: `*SURFACE, TYPE=SEGMENTS`, `*RIGID SURFACE`, `*CONTACT PAIR`.
//! Never here: surfaces of elements, what contact does.

use super::builder::Builder;
use super::names::{qualified, upper};
use super::types::{
    AnalyticalSide, InteractionId, Model, Profile, RigidBody, RigidSurface, RigidSurfaceId, Segment, Sides,
};
use crate::deck::{Card, DataLine, Diagnostic, Span, Word};
use crate::kernel::lists::sorted_unique;
use crate::platform::PortableMath as _;

/// Up to this part of the radius the ends of an arc differ by rounding alone.
const ARC_ROUNDING: f64 = 1e-6;
/// Up to this part a slip of digits is taken for the arc that was meant.
const ARC_MOST: f64 = 1e-2;

/// The point nearest to a centre that is equally far from two others.
fn evened(a: [f64; 2], b: [f64; 2], centre: [f64; 2]) -> [f64; 2] {
    let chord = [b[0] - a[0], b[1] - a[1]];
    let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
    let off = ((centre[0] - middle[0]) * chord[0] + (centre[1] - middle[1]) * chord[1])
        / (chord[0] * chord[0] + chord[1] * chord[1]);
    [centre[0] - off * chord[0], centre[1] - off * chord[1]]
}

impl Builder<'_> {
    /// A chain of segments: START, then LINE and CIRCL (ABAQUS Keywords Reference Guide, *SURFACE, TYPE=SEGMENTS).
    pub(super) fn analytical_surface(&mut self, card: &Card, name: &Word) {
        let Some((start, rest)) = card.lines.split_first() else {
            self.required_lines(card);
            return;
        };
        let Some(mut at) = self.surface_point(start, "START") else { return };
        let (mut segments, mut lines) = (Vec::new(), Vec::new());
        for line in rest {
            let Some(segment) = self.segment(line, at) else { return };
            at = segment.ends()[1];
            segments.push(segment);
            lines.push(line.span);
        }
        if segments.is_empty() {
            return self.out_of_range(start.span, "an analytical surface needs a LINE or a CIRCL behind START");
        }
        let mut profile = Profile { segments };
        if let Some(word) = card.value("FILLET RADIUS") {
            let Some(radius) = word.number(&mut self.diagnostics) else { return };
            if radius.is_nan() || radius < 0.0 {
                return self
                    .out_of_range(word.span, format!("the radius of a fillet must not be below zero, not {radius}"));
            }
            if radius > 0.0 {
                match profile.fillet(radius) {
                    Ok(rounded) => profile = rounded,
                    Err(k) => {
                        let message =
                            format!("there is no room for a fillet of radius {radius} where this segment begins");
                        return self.out_of_range(lines[k], message);
                    }
                }
            }
        }
        let profile = self.placed(profile);
        let surface = RigidSurface { profile, reference: None, span: card.span };
        self.model.surfaces.analytical.insert(qualified(&self.scope, &name.text), surface);
    }

    fn required_lines(&mut self, card: &Card) {
        let finding = Diagnostic::error("M102", "an analytical surface begins with START, r, z");
        self.diagnostics.push(finding.at(card.span, "no data lines"));
    }

    /// The surface of an instance in the assembly. What turns the plane over turns the way along the surface with it: the front
    /// stays the front.
    fn placed(&self, profile: Profile) -> Profile {
        let Some(placement) = &self.instance else { return profile };
        let put = |p: [f64; 2]| placement.apply(p);
        let moved = |s: &Segment| match *s {
            Segment::Line(ends) => Segment::Line(ends.map(put)),
            Segment::Arc(ends, centre, ..) => Segment::arc(put(ends[0]), put(ends[1]), put(centre)),
        };
        let placed = Profile { segments: profile.segments.iter().map(moved).collect() };
        let [o, r, z] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(put);
        let turned = (r[0] - o[0]) * (z[1] - o[1]) - (r[1] - o[1]) * (z[0] - o[0]) < 0.0;
        if turned { placed.reversed() } else { placed }
    }

    fn surface_point(&mut self, line: &DataLine, word: &str) -> Option<[f64; 2]> {
        if !line.field(0).is_some_and(|w| w.is(word)) {
            return self.refuse_value(line.span, format!("an analytical surface begins with {word}, r, z"));
        }
        Some([self.number(line, 1, "r")?, self.number(line, 2, "z")?])
    }

    /// The segment of a data line that begins at a point.
    fn segment(&mut self, line: &DataLine, from: [f64; 2]) -> Option<Segment> {
        let is = |what: &str| line.field(0).is_some_and(|w| w.is(what));
        if !is("LINE") && !is("CIRCL") {
            return self.refuse_unsupported(
                line.span,
                "this segment of an analytical surface is not supported",
                "LINE and CIRCL are",
            );
        }
        let to = [self.number(line, 1, "r")?, self.number(line, 2, "z")?];
        if from == to {
            return self.refuse_value(line.span, "this segment has no length");
        }
        if is("LINE") {
            return Some(Segment::Line([from, to]));
        }
        let centre = [self.number(line, 3, "r of the centre")?, self.number(line, 4, "z of the centre")?];
        let centre = evened(from, to, self.arc_centre(from, to, centre, line.span)?);
        let (u, v) = ([from[0] - centre[0], from[1] - centre[1]], [to[0] - centre[0], to[1] - centre[1]]);
        let sine = (u[0] * v[1] - u[1] * v[0]) / (u[0].portable_hypot(u[1]) * v[0].portable_hypot(v[1]));
        if sine.abs() < 1e-6 {
            return self.refuse_value(line.span, "an arc must be shorter than half a circle: give it in two");
        }
        Some(Segment::arc(from, to, centre))
    }

    /// The centre of an arc. Where its ends are not quite equally far from it this is told, and the nearest point that they are
    /// equally far from is taken; where they are off by more than a hundredth the arc is refused.
    pub(super) fn arc_centre(
        &mut self,
        from: [f64; 2],
        to: [f64; 2],
        centre: [f64; 2],
        span: Span,
    ) -> Option<[f64; 2]> {
        let [a, b] = [from, to].map(|p| (p[0] - centre[0]).portable_hypot(p[1] - centre[1]));
        let off = (a - b).abs() / a.max(b);
        if off <= ARC_ROUNDING {
            return Some(centre);
        }
        let message = format!(
            "the ends of the arc are {a} and {b} from its centre ({}, {}): {off:.1e} of the radius apart",
            centre[0], centre[1]
        );
        if off.is_nan() || off > ARC_MOST {
            let finding = Diagnostic::error("M103", message).at(span, "no circle goes through both");
            return self.diagnostics.refuse(finding.help("up to a hundredth of the radius is taken for rounding"));
        }
        let finding = Diagnostic::warning("M170", message).at(span, "the nearest centre is taken");
        self.diagnostics.push(finding.help("give the centre with more digits"));
        Some(evened(from, to, centre))
    }

    /// The old card: an analytical surface with its reference node (ABAQUS Keywords Reference Guide, *RIGID SURFACE).
    pub(super) fn rigid_surface(&mut self, card: &Card) {
        if !card.value("TYPE").is_some_and(|w| w.is("SEGMENTS")) {
            let message = "only TYPE=SEGMENTS is a surface of revolution in the r-z plane";
            return self.unsupported(card.span, message, "TYPE=SEGMENTS is");
        }
        let Some(name) = card.value("NAME").or(card.value("ELSET")) else {
            self.required(card, "NAME");
            return;
        };
        self.analytical_surface(card, name);
        let Some(word) = card.value("REF NODE") else { return };
        let Some(nodes) = self.node_members(word) else { return };
        let [reference] = nodes[..] else {
            return self.out_of_range(word.span, format!("REF NODE must be one node; this set has {}", nodes.len()));
        };
        if let Some(surface) = self.model.surfaces.analytical.get_mut(&qualified(&self.scope, &name.text)) {
            surface.reference = Some(reference);
        }
        if self.model.rigid_bodies.iter().any(|b| b.reference == reference) {
            return;
        }
        let (elements, nodes, name) = (Vec::new(), Vec::new(), upper(&name.text));
        let body = RigidBody { name, reference, elements, nodes, thickness: 0.0, density: 0.0, span: card.span };
        self.model.rigid_bodies.push(body);
    }

    /// A rigid body that carries an analytical surface.
    pub(super) fn carry_surface(&mut self, word: &Word, reference: usize) {
        for name in [qualified(&self.scope, &word.text), upper(&word.text)] {
            if let Some(surface) = self.model.surfaces.analytical.get_mut(&name) {
                surface.reference = Some(reference);
                return;
            }
        }
        let names: Vec<String> = self.model.surfaces.analytical.keys().cloned().collect();
        self.unknown("M114", "analytical surface", word, |_| names.clone());
    }

    pub(super) fn contact_note(&mut self, card: &Card) {
        if !self.deck.cards.iter().any(|c| matches!(c.keyword.name, "CONTACT PAIR" | "CONTACT")) {
            self.inert(card, "it serves contact only".into());
        }
    }

    pub(super) fn contact_pair(&mut self, card: &Card) {
        let adds = card.read("OP");
        if self.first_line(card).is_none() {
            return;
        }
        for line in &card.lines {
            let Some(first) = line.field(0) else {
                self.diagnostics.push(Diagnostic::error("M102", "a pair has two surfaces").at(line.span, "here"));
                continue;
            };
            // A surface alone meets itself.
            let second = line.field(1).unwrap_or(first);
            let (known, scope) = (&self.model.surfaces.analytical, &self.scope);
            let find =
                |w: &Word| [qualified(scope, &w.text), upper(&w.text)].iter().find_map(|n| known.get_index_of(n));
            let (side, surface, other) = match (find(first), find(second)) {
                (Some(surface), None) => (0, surface, second),
                (None, Some(surface)) => (1, surface, first),
                _ if self.lost.explains("surface", first) || self.lost.explains("surface", second) => continue,
                (None, None) => {
                    self.surface_pair(card, line, [first, second], adds);
                    continue;
                }
                _ => {
                    let message = "both surfaces of this pair are analytical ones";
                    self.unsupported(line.span, message, "two rigid surfaces without elements do not meet");
                    continue;
                }
            };
            let name = known.get_index(surface).map_or(String::new(), |(name, _)| name.clone());
            let Some((nodes, sides)) = self.sides_of_nodes(other) else { continue };
            let surface = RigidSurfaceId::new(surface);
            let rigid = Sides { name, surface: true, faces: Vec::new(), whole: Vec::new() };
            let sides = if side == 0 { [rigid, sides] } else { [sides, rigid] };
            self.add_pair(card, line, (sides, Some(AnalyticalSide { side, surface, nodes })), adds);
        }
    }

    pub(super) fn no_pair_to_delete(&mut self, span: Span) {
        let message = "there is no such contact pair to delete";
        self.diagnostics.push(Diagnostic::error("M114", message).at(span, "in force here"));
    }

    /// Gives contacts the friction of their interactions, once all are known: a pair may name one that comes later.
    pub(super) fn apply_interactions(&mut self) {
        let names: Vec<String> = self.model.interactions.iter().map(|i| i.name.clone()).collect();
        let mut used = std::mem::take(&mut self.interactions_used);
        used.dedup_by_key(|word| word.span);
        for word in used {
            if !names.contains(&upper(&word.text)) {
                self.unknown("M114", "surface interaction", &word, |_| names.clone());
            }
        }
        let Model { interactions, steps, .. } = &mut self.model;
        let law = |id: Option<InteractionId>| {
            id.and_then(|id| interactions.get(id.index())).map(|i| i.law.clone()).unwrap_or_default()
        };
        for step in steps {
            step.surface_contacts.iter_mut().for_each(|contact| contact.law = law(contact.interaction));
            let assigned = step.general_contact.iter_mut().flat_map(|general| &mut general.assigned);
            assigned.for_each(|assigned| assigned.law = law(assigned.interaction));
        }
    }

    /// The surface interaction of a name.
    pub(super) fn interaction(&mut self, word: &Word) -> Option<InteractionId> {
        self.interactions_used.push(word.clone());
        self.interaction_places.get(&upper(&word.text)).copied().map(InteractionId::new)
    }

    /// Nodes of a surface of nodes or of element faces, ascending.
    pub(super) fn contact_nodes(&mut self, word: &Word) -> Option<Vec<usize>> {
        self.sides_of_nodes(word).map(|sides| sides.0)
    }

    /// The same, and its faces.
    fn sides_of_nodes(&mut self, word: &Word) -> Option<(Vec<usize>, Sides)> {
        for name in [qualified(&self.scope, &word.text), upper(&word.text)] {
            if let Some(nodes) = self.model.surfaces.nodes.get(&name) {
                return Some((nodes.clone(), Sides { name, surface: true, faces: Vec::new(), whole: Vec::new() }));
            }
        }
        let id = self.surface_id(word)?;
        let (mesh, name) = (&self.model.mesh, self.model.surfaces.name(id).to_owned());
        let faces = self.model.surfaces.faces[id].faces.clone();
        let nodes: Vec<usize> = sorted_unique(faces.iter().filter_map(|&(e, side)| mesh.ends(e, side)).flatten());
        Some((nodes, Sides { name, surface: true, faces, whole: Vec::new() }))
    }

    /// A surface of nodes: sets or single nodes.
    pub(super) fn node_surface(&mut self, card: &Card, name: &Word) {
        let words = card.lines.iter().filter_map(|l| l.field(0));
        let nodes: Vec<usize> = sorted_unique(words.filter_map(|w| self.node_members(w)).flatten());
        self.model.surfaces.nodes.insert(qualified(&self.scope, &name.text), nodes);
        if !self.deck.cards.iter().any(|c| matches!(c.keyword.name, "COUPLING" | "TIE")) {
            self.contact_note(card);
        }
    }
}
