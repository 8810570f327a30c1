//! Surfaces: `*SURFACE` on elements and sides.
//! Never here: loads on them.

use super::builder::Builder;
use super::names::{qualified, upper};
use super::types::{ElementKind, Side, Sides, Surface};
use crate::deck::{Card, Diagnostic, Span, Word};

impl Builder<'_> {
    pub(super) fn surface(&mut self, card: &Card) {
        let Some(name) = self.required(card, "NAME") else { return };
        if card.value("TYPE").is_some_and(|w| w.is("NODE")) {
            self.node_surface(card, name);
            return;
        }
        if card.value("TYPE").is_some_and(|w| w.is("SEGMENTS")) {
            self.analytical_surface(card, name);
            return;
        }
        if let Some(kind) = card.value("TYPE").filter(|w| !w.is("ELEMENT")) {
            return self.unsupported(
                kind.span,
                format!("TYPE={} is not supported", kind.text),
                "ELEMENT, NODE and SEGMENTS are",
            );
        }
        let (mut faces, mut whole) = (Vec::new(), Vec::new());
        for line in &card.lines {
            let Some(set) = line.field(0) else { continue };
            let elements = self.element_members(set).unwrap_or_default();
            match line.field(1) {
                Some(side) => faces.extend(self.sides(&elements, side)),
                None => {
                    faces.extend(self.free_sides(&elements, line.span));
                    whole.extend(elements);
                }
            }
        }
        let key = qualified(&self.scope, &name.text);
        let fresh = || Surface { name: name.text.clone(), faces: Vec::new(), whole: Vec::new(), span: card.span };
        let surface = self.model.surfaces.faces.entry(key).or_insert_with(fresh);
        surface.faces.extend(faces);
        surface.whole.extend(whole);
    }

    pub(super) fn sides(&mut self, elements: &[usize], word: &Word) -> Vec<(usize, Side)> {
        let name = upper(&word.text);
        let mut faces = Vec::new();
        for &element in elements {
            let kind = self.model.mesh.elements[element].kind;
            let mut sides = sides_of(&name, kind).peekable();
            if sides.peek().is_none() {
                let message = format!("{} has no side {}", kind.name(), word.text);
                let finding = Diagnostic::error("M131", message).at(word.span, "no such side");
                self.diagnostics
                    .push(finding.help("RAX2 and SAX1 have SPOS and SNEG, CAX3 and CAX6M S1 to S3, CAX4R S1 to S4"));
                return faces;
            }
            faces.extend(sides.map(|side| (element, side)));
        }
        faces
    }

    /// The free faces of solids; a RAX2 has two sides, so one must be named.
    fn free_sides(&mut self, elements: &[usize], span: Span) -> Vec<(usize, Side)> {
        let mesh = &self.model.mesh;
        if elements.iter().any(|&e| matches!(mesh.elements[e].kind, ElementKind::Rax2 | ElementKind::Sax1)) {
            let finding = Diagnostic::error("M130", "which side of these RAX2 elements?").at(span, "no side named");
            let help = "SPOS is first to second node turned 90 degrees counter-clockwise in (r, z), SNEG the other";
            self.diagnostics.push(finding.help(help));
            return Vec::new();
        }
        let outside = mesh.outside();
        let of = |&e: &usize| {
            let first = outside.partition_point(|f| f.0 < e);
            outside[first..].iter().take_while(move |f| f.0 == e).copied()
        };
        elements.iter().flat_map(of).collect()
    }
}

impl Surface {
    /// Its sides for what acts on them; the name as a card gives it.
    pub(super) fn sides(&self, name: &str) -> Sides {
        Sides { name: name.into(), surface: true, faces: self.faces.clone(), whole: self.whole.clone() }
    }
}

/// The parts of the boundary that a name means on a type of element; none where it has no such side.
pub(super) fn sides_of(name: &str, kind: ElementKind) -> impl Iterator<Item = Side> {
    let shell = matches!(kind, ElementKind::Rax2 | ElementKind::Sax1);
    let of_shell = match name {
        "SPOS" if shell => Some(Side::Positive),
        "SNEG" if shell => Some(Side::Negative),
        _ => None,
    };
    let number = name.strip_prefix('S').filter(|_| kind.is_solid()).and_then(|n| n.parse().ok());
    of_shell.into_iter().chain(number.map_or(0..0, |n| kind.face(n)).map(Side::Face))
}
