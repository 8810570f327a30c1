//! Contact with analytical planes: `*SURFACE, TYPE=SEGMENTS`, `*CONTACT PAIR`, `*SURFACE INTERACTION`, `*FRICTION`.
//! Never here: surfaces of elements, what contact does.

use super::builder::Builder;
use super::names::{qualified, upper};
use super::types::{Contact, Interaction, Plane};
use crate::deck::{Card, Diagnostic, Word};

impl Builder<'_> {
    /// A straight line of one height: START, r, z and LINE, r, z.
    pub(super) fn plane(&mut self, card: &Card, name: &Word) {
        let [start, line] = &card.lines[..] else {
            self.unsupported(
                card.span,
                "analytical surfaces of other than one line are not supported",
                "START and LINE are",
            );
            return;
        };
        let is = |word: Option<&Word>, what: &str| word.is_some_and(|w| w.is(what));
        if !is(start.field(0), "START") || !is(line.field(0), "LINE") {
            self.unsupported(card.span, "this analytical surface is not supported", "START, r, z and LINE, r, z are");
            return;
        }
        let mut point = |line| Some([self.number(line, 1, "r")?, self.number(line, 2, "z")?]);
        let (Some([r1, z1]), Some([r2, z2])) = (point(start), point(line)) else { return };
        if z1 != z2 || r1 == r2 {
            self.unsupported(card.span, "only planes z = const are supported", "give both points the same z");
            return;
        }
        let plane = Plane { height: z1, from: r1, to: r2, reference: None, span: card.span };
        self.model.planes.insert(qualified(&self.scope, &name.text), plane);
    }

    /// A rigid body that carries a plane.
    pub(super) fn carry_plane(&mut self, word: &Word, reference: usize) {
        for name in [qualified(&self.scope, &word.text), upper(&word.text)] {
            if let Some(plane) = self.model.planes.get_mut(&name) {
                plane.reference = Some(reference);
                return;
            }
        }
        let names: Vec<String> = self.model.planes.keys().cloned().collect();
        self.unknown("M114", "analytical surface", word, &names);
    }

    pub(super) fn surface_interaction(&mut self, card: &Card) {
        let Some(name) = self.required(card, "NAME") else { return };
        self.model.interactions.push(Interaction { name: upper(&name.text), friction: 0.0 });
        self.contact_note(card);
    }

    pub(super) fn friction(&mut self, card: &Card) {
        self.contact_note(card);
        let Some(line) = self.first_line(card) else { return };
        let Some(friction) = self.number_or(line, 0, 0.0) else { return };
        if friction < 0.0 || !friction.is_finite() {
            self.out_of_range(line.span, format!("the coefficient of friction must not be below zero, not {friction}"));
            return;
        }
        if let Some(interaction) = self.model.interactions.last_mut() {
            interaction.friction = friction;
        }
    }

    pub(super) fn surface_behavior(&mut self, card: &Card) {
        self.contact_note(card);
    }

    fn contact_note(&mut self, card: &Card) {
        if !self.deck.cards.iter().any(|c| c.keyword.name == "CONTACT PAIR") {
            self.inert(card, "it serves contact only".into());
        }
    }

    pub(super) fn contact_pair(&mut self, card: &Card) {
        let Some(adds) = self.pair_operation(card) else { return };
        if let Some(word) = card.value("INTERACTION") {
            self.interactions_used.push(word.clone());
        }
        if self.first_line(card).is_none() {
            return;
        }
        for line in &card.lines {
            let (Some(first), Some(second)) = (line.field(0), line.field(1)) else {
                self.diagnostics.push(Diagnostic::error("M102", "a pair has two surfaces").at(line.span, "here"));
                continue;
            };
            let (planes, scope) = (&self.model.planes, &self.scope);
            let find =
                |w: &Word| [qualified(scope, &w.text), upper(&w.text)].into_iter().find(|n| planes.contains_key(n));
            let (plane, other) = match (find(first), find(second)) {
                (Some(plane), None) => (plane, second),
                (None, Some(plane)) => (plane, first),
                _ => {
                    let message = "one surface of a pair must be an analytical plane, the other must deform";
                    self.unsupported(line.span, message, "contact of deformable surfaces is not simulated");
                    continue;
                }
            };
            let Some(nodes) = self.contact_nodes(other) else { continue };
            let set = other.text.clone();
            let interaction = card.value("INTERACTION").cloned();
            let pairs = &mut self.state().contacts;
            let before = pairs.len();
            // A pair that is given again takes the place of the earlier one.
            pairs.retain(|c| c.plane != plane || c.nodes != nodes);
            if !adds {
                if pairs.len() == before {
                    let message = "there is no such contact pair to delete";
                    self.diagnostics.push(Diagnostic::error("M114", message).at(line.span, "in force here"));
                }
                continue;
            }
            pairs.push(Contact { plane, nodes, set, interaction, friction: 0.0, span: line.span });
        }
    }

    /// Whether a card adds pairs (the default) or deletes them; `None` once refused (ABAQUS Keywords Reference Guide,
    /// *CONTACT PAIR).
    fn pair_operation(&mut self, card: &Card) -> Option<bool> {
        match card.value("OP") {
            None => Some(true),
            Some(word) if word.is("ADD") => Some(true),
            Some(word) if word.is("DELETE") => Some(false),
            Some(word) => {
                self.out_of_range(word.span, format!("OP is ADD or DELETE, not {}", word.text));
                None
            }
        }
    }

    /// Gives contacts the friction of their interactions, once all are known: a pair may name one that comes later.
    pub(super) fn apply_interactions(&mut self) {
        let names: Vec<String> = self.model.interactions.iter().map(|i| i.name.clone()).collect();
        for word in std::mem::take(&mut self.interactions_used) {
            if !names.contains(&upper(&word.text)) {
                self.unknown("M114", "surface interaction", &word, &names);
            }
        }
        let interactions = &self.model.interactions;
        for contact in self.model.steps.iter_mut().flat_map(|s| &mut s.contacts) {
            let name = contact.interaction.as_ref().map(|w| upper(&w.text));
            let found = interactions.iter().find(|i| Some(&i.name) == name.as_ref());
            contact.friction = found.map_or(0.0, |i| i.friction);
        }
    }

    /// Nodes of a surface of nodes or of element faces, ascending.
    pub(super) fn contact_nodes(&mut self, word: &Word) -> Option<Vec<usize>> {
        for name in [qualified(&self.scope, &word.text), upper(&word.text)] {
            if let Some(nodes) = self.model.node_surfaces.get(&name) {
                return Some(nodes.clone());
            }
        }
        let key = self.surface_key(word)?;
        let mesh = &self.model.mesh;
        let faces = &self.model.surfaces[&key].faces;
        let mut nodes: Vec<usize> = faces.iter().filter_map(|&(e, side)| mesh.ends(e, side)).flatten().collect();
        nodes.sort_unstable();
        nodes.dedup();
        Some(nodes)
    }

    /// A surface of nodes: sets or single nodes.
    pub(super) fn node_surface(&mut self, card: &Card, name: &Word) {
        let words = card.lines.iter().filter_map(|l| l.field(0));
        let mut nodes: Vec<usize> = words.filter_map(|w| self.node_members(w)).flatten().collect();
        nodes.sort_unstable();
        nodes.dedup();
        self.model.node_surfaces.insert(qualified(&self.scope, &name.text), nodes);
        if !self.deck.cards.iter().any(|c| matches!(c.keyword.name, "COUPLING" | "TIE")) {
            self.contact_note(card);
        }
    }
}
