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
            let Some(side) = side(&name, kind) else {
                let message = format!("{} has no side {}", kind.name(), word.text);
                let finding = Diagnostic::error("M131", message).at(word.span, "no such side");
                self.diagnostics.push(finding.help("RAX2 and SAX1 have SPOS and SNEG, CAX3 S1 to S3, CAX4R S1 to S4"));
                return faces;
            };
            faces.push((element, side));
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

/// The side a name means on a type of element.
pub(super) fn side(name: &str, kind: ElementKind) -> Option<Side> {
    match (name, kind) {
        ("SPOS", ElementKind::Rax2 | ElementKind::Sax1) => Some(Side::Positive),
        ("SNEG", ElementKind::Rax2 | ElementKind::Sax1) => Some(Side::Negative),
        (_, kind) if kind.is_solid() => {
            let number: u8 = name.strip_prefix('S')?.parse().ok()?;
            (1..=kind.node_count() as u8).contains(&number).then_some(Side::Face(number))
        }
        _ => None,
    }
}
