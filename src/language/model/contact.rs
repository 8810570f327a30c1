//! Analytical surfaces and contact pairs: `*SURFACE, TYPE=SEGMENTS`, `*RIGID SURFACE`, `*CONTACT PAIR`.

use super::builder::ModelBuilder;
use super::names::{qualified, upper};
use super::types::{
    AnalyticalSide, InteractionId, Model, ProfileSegment, RigidBody, RigidSurface, RigidSurfaceId, SideSelection,
    SurfaceProfile,
};
use crate::deck::{Card, DataLine, Diagnostic, Span, Word};
use crate::kernel::lists::sorted_unique;
use crate::platform::PortableMath as _;

/// Relative difference of the radii at both ends of an arc that is treated as rounding.
const ARC_ROUNDING: f64 = 1e-6;
/// Largest relative difference of the radii that is corrected; beyond it the arc is invalid.
const ARC_LIMIT: f64 = 1e-2;

/// Returns the point on the perpendicular bisector of `a` and `b` that is nearest to `centre`.
fn equidistant_centre(a: [f64; 2], b: [f64; 2], centre: [f64; 2]) -> [f64; 2] {
    let chord = [b[0] - a[0], b[1] - a[1]];
    let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
    let off = ((centre[0] - middle[0]) * chord[0] + (centre[1] - middle[1]) * chord[1])
        / (chord[0] * chord[0] + chord[1] * chord[1]);
    [centre[0] - off * chord[0], centre[1] - off * chord[1]]
}

impl ModelBuilder<'_> {
    /// Reads an analytical surface: START, then LINE and CIRCL (ABAQUS Keywords Reference Guide, *SURFACE,
    /// TYPE=SEGMENTS).
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
            return self.out_of_range(start.span, "an analytical surface requires a LINE or CIRCL after START");
        }
        let mut profile = SurfaceProfile { segments };
        if let Some(word) = card.value("FILLET RADIUS") {
            let Some(radius) = word.number(&mut self.diagnostics) else { return };
            if radius.is_nan() || radius < 0.0 {
                return self.out_of_range(word.span, format!("FILLET RADIUS must not be negative, found {radius}"));
            }
            if radius > 0.0 {
                match profile.fillet(radius) {
                    Ok(rounded) => profile = rounded,
                    Err(k) => {
                        let message = format!("a fillet of radius {radius} does not fit at the start of this segment");
                        return self.out_of_range(lines[k], message);
                    }
                }
            }
        }
        let profile = self.placed(profile);
        let surface = RigidSurface { profile, reference: None, span: card.span };
        let key = qualified(&self.scope, &name.text);
        if let Some(first) = self.model.surfaces.analytical.get(&key).filter(|_| !self.faulty.contains(&card.span)) {
            let message = format!("the surface {} is defined twice", name.text);
            let diagnostic = Diagnostic::error("M160", message).at(card.span, "second definition");
            return self.diagnostics.push(diagnostic.at(first.span, "first definition").help("remove one definition"));
        }
        self.model.surfaces.analytical.insert(key, surface);
    }

    fn required_lines(&mut self, card: &Card) {
        let diagnostic = Diagnostic::error("M102", "an analytical surface must start with `START, r, z`");
        self.diagnostics.push(diagnostic.at(card.span, "no data lines"));
    }

    /// Places a profile by the current instance. If the placement mirrors the plane, the profile is reversed, so that
    /// its contact side is preserved.
    fn placed(&self, profile: SurfaceProfile) -> SurfaceProfile {
        let Some(placement) = &self.instance else { return profile };
        let put = |p: [f64; 2]| placement.apply(p);
        let moved = |s: &ProfileSegment| match *s {
            ProfileSegment::Line(ends) => ProfileSegment::Line(ends.map(put)),
            ProfileSegment::Arc(ends, centre, ..) => ProfileSegment::arc(put(ends[0]), put(ends[1]), put(centre)),
        };
        let placed = SurfaceProfile { segments: profile.segments.iter().map(moved).collect() };
        let [o, r, z] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(put);
        let turned = (r[0] - o[0]) * (z[1] - o[1]) - (r[1] - o[1]) * (z[0] - o[0]) < 0.0;
        if turned { placed.reversed() } else { placed }
    }

    fn surface_point(&mut self, line: &DataLine, word: &str) -> Option<[f64; 2]> {
        if !line.field(0).is_some_and(|w| w.is(word)) {
            return self.refuse_value(line.span, format!("an analytical surface must start with `{word}, r, z`"));
        }
        if let Some(surplus) = line.field(3).or(line.field(4)) {
            self.report_surplus(surplus, "START has two coordinates");
        }
        Some([self.number(line, 1, "r")?, self.number(line, 2, "z")?])
    }

    /// Reads the segment of a data line, which starts at the end of the previous one.
    fn segment(&mut self, line: &DataLine, from: [f64; 2]) -> Option<ProfileSegment> {
        let is = |what: &str| line.field(0).is_some_and(|w| w.is(what));
        if !is("LINE") && !is("CIRCL") {
            return self.refuse_unsupported(
                line.span,
                "this segment of an analytical surface is not supported",
                "use LINE or CIRCL",
            );
        }
        let to = [self.number(line, 1, "r")?, self.number(line, 2, "z")?];
        if from == to {
            return self.refuse_value(line.span, "this segment has zero length");
        }
        if is("LINE") {
            if let Some(surplus) = line.field(3).or(line.field(4)) {
                self.report_surplus(surplus, "LINE has two coordinates; CIRCL has a centre");
            }
            return Some(ProfileSegment::Line([from, to]));
        }
        let centre = [self.number(line, 3, "r of the centre")?, self.number(line, 4, "z of the centre")?];
        let centre = equidistant_centre(from, to, self.arc_centre(from, to, centre, line.span)?);
        let (u, v) = ([from[0] - centre[0], from[1] - centre[1]], [to[0] - centre[0], to[1] - centre[1]]);
        let sine = (u[0] * v[1] - u[1] * v[0]) / (u[0].portable_hypot(u[1]) * v[0].portable_hypot(v[1]));
        if sine.abs() < 1e-6 {
            return self.refuse_value(line.span, "an arc must be shorter than half a circle; split it into two arcs");
        }
        Some(ProfileSegment::arc(from, to, centre))
    }

    /// Returns the centre of an arc. If the distances to the ends differ by more than rounding, the centre is corrected
    /// with a warning; if they differ by more than 1 % of the radius, an error is reported.
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
            "the ends of the arc have the distances {a} and {b} from the \
             centre ({}, {}); relative difference {off:.1e}",
            centre[0], centre[1]
        );
        if off.is_nan() || off > ARC_LIMIT {
            let diagnostic = Diagnostic::error("M103", message).at(span, "no circle about this centre");
            return self.diagnostics.refuse(diagnostic.help("the relative difference may be 1e-2 at most"));
        }
        let diagnostic = Diagnostic::warning("M170", message).at(span, "the nearest valid centre is used");
        self.diagnostics.push(diagnostic.help("give the centre with more digits"));
        Some(equidistant_centre(from, to, centre))
    }

    /// Reads an analytical surface with its reference node in the older syntax (ABAQUS Keywords Reference Guide, *RIGID
    /// SURFACE).
    pub(super) fn rigid_surface(&mut self, card: &Card) {
        if !card.value("TYPE").is_some_and(|w| w.is("SEGMENTS")) {
            let message = "*RIGID SURFACE supports TYPE=SEGMENTS only, a surface of revolution";
            return self.unsupported(card.span, message, "use TYPE=SEGMENTS");
        }
        let Some(name) = card.value("NAME").or(card.value("ELSET")) else {
            self.required(card, "NAME");
            return;
        };
        self.analytical_surface(card, name);
        let Some(word) = card.value("REF NODE") else { return };
        let Some(nodes) = self.node_members(word) else { return };
        let [reference] = nodes[..] else {
            return self.out_of_range(word.span, format!("REF NODE must be one node, found a set of {}", nodes.len()));
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

    /// Assigns an analytical surface to the rigid body with a reference node.
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
            self.inert(card, "it is used by contact only".into());
        }
    }

    pub(super) fn contact_pair(&mut self, card: &Card) {
        let adds = card.read("OP");
        if self.first_line(card).is_none() {
            return;
        }
        for line in &card.lines {
            let Some(first) = line.field(0) else {
                self.diagnostics
                    .push(Diagnostic::error("M102", "a contact pair requires two surfaces").at(line.span, "here"));
                continue;
            };
            // A single surface defines self-contact.
            let second = line.field(1).unwrap_or(first);
            let (side, surface, other) = match (self.analytical_id(first), self.analytical_id(second)) {
                (Some(surface), None) => (0, surface, second),
                (None, Some(surface)) => (1, surface, first),
                _ if self.missing.explains("surface", first) || self.missing.explains("surface", second) => continue,
                (None, None) => {
                    self.surface_pair(card, line, [first, second], adds);
                    continue;
                }
                _ => {
                    let message = "both surfaces of this contact pair are analytical";
                    self.unsupported(line.span, message, "one of the surfaces must have elements or nodes");
                    continue;
                }
            };
            let Some((nodes, sides)) = self.nodes_and_faces(other) else { continue };
            let rigid = SideSelection::new(self.model.surfaces.analytical_name(surface), &[]);
            // Nodes of shells contact an analytical surface on either side.
            let sides = SideSelection { faces: sides.first_sides(), ..sides };
            let sides = if side == 0 { [rigid, sides] } else { [sides, rigid] };
            self.add_pair(card, line, (sides, Some(AnalyticalSide { side, surface, nodes })), adds);
        }
    }

    /// Returns the analytical surface with a name.
    pub(super) fn analytical_id(&self, word: &Word) -> Option<RigidSurfaceId> {
        let known = &self.model.surfaces.analytical;
        let names = [qualified(&self.scope, &word.text), upper(&word.text)];
        names.iter().find_map(|name| known.get_index_of(name)).map(RigidSurfaceId::new)
    }

    pub(super) fn report_missing_pair(&mut self, span: Span) {
        let message = "the contact pair to delete does not exist";
        self.diagnostics.push(Diagnostic::error("M114", message).at(span, "not in force here"));
    }

    /// Copies the laws of interactions to the contacts after all cards are read; a pair may precede its interaction.
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

    /// Returns the surface interaction with a name, which may be defined later.
    pub(super) fn interaction(&mut self, word: &Word) -> Option<InteractionId> {
        self.interactions_used.push(word.clone());
        self.interaction_places.get(&upper(&word.text)).copied().map(InteractionId::new)
    }

    /// Returns the nodes of a node-based or element-based surface, ascending.
    pub(super) fn contact_nodes(&mut self, word: &Word) -> Option<Vec<usize>> {
        self.nodes_and_faces(word).map(|sides| sides.0)
    }

    /// Returns the nodes and the faces of a surface; a node-based surface has no faces.
    pub(super) fn nodes_and_faces(&mut self, word: &Word) -> Option<(Vec<usize>, SideSelection)> {
        for name in [qualified(&self.scope, &word.text), upper(&word.text)] {
            if let Some(nodes) = self.model.surfaces.nodes.get(&name) {
                return Some((nodes.clone(), SideSelection::new(&name, &[])));
            }
        }
        let id = self.surface_id(word)?;
        let (mesh, name) = (&self.model.mesh, self.model.surfaces.name(id).to_owned());
        let faces = self.model.surfaces.faces[id].faces.clone();
        let nodes: Vec<usize> = sorted_unique(faces.iter().filter_map(|&(e, side)| mesh.side_nodes(e, side)).flatten());
        Some((nodes, SideSelection { name, surface: true, faces, free_face_elements: Vec::new() }))
    }

    /// Defines a node-based surface from node sets and single nodes.
    pub(super) fn node_surface(&mut self, card: &Card, name: &Word) {
        let words = card.lines.iter().filter_map(|l| l.field(0));
        let between = self.between_labels(words.clone());
        if let Some(last) = card.lines.last().filter(|_| !between.is_empty()) {
            self.add_node_line(last.span, &between, "");
        }
        let nodes = words.filter_map(|w| self.node_members(w)).flatten();
        let nodes: Vec<usize> = sorted_unique(nodes.chain(between));
        self.model.surfaces.nodes.insert(qualified(&self.scope, &name.text), nodes);
        if !self.deck.cards.iter().any(|c| matches!(c.keyword.name, "COUPLING" | "TIE")) {
            self.contact_note(card);
        }
    }
}
