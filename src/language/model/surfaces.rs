//! `*SURFACE` on element faces.

use super::builder::ModelBuilder;
use super::names::{qualified, upper};
use super::types::{ElementKind, ElementSide, ElementSurface, SideSelection};
use crate::deck::{Card, Diagnostic, Span, Word};

impl ModelBuilder<'_> {
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
                "supported: ELEMENT, NODE, SEGMENTS",
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
        let fresh = || ElementSurface {
            name: name.text.clone(),
            faces: Vec::new(),
            free_face_elements: Vec::new(),
            span: card.span,
        };
        let surface = self.model.surfaces.faces.entry(key).or_insert_with(fresh);
        surface.faces.extend(faces);
        surface.free_face_elements.extend(whole);
    }

    pub(super) fn sides(&mut self, elements: &[usize], word: &Word) -> Vec<(usize, ElementSide)> {
        let name = upper(&word.text);
        let mut faces = Vec::new();
        for &element in elements {
            let kind = self.model.mesh.elements[element].kind;
            let mut sides = sides_of(&name, kind).peekable();
            if sides.peek().is_none() {
                let message = format!("{} has no side {}", kind.name(), word.text);
                let diagnostic = Diagnostic::error("M131", message).at(word.span, "no such side");
                self.diagnostics.push(
                    diagnostic
                        .help("use SPOS or SNEG for RAX2 and SAX1, S1 to S3 for CAX3 and CAX6M, S1 to S4 for CAX4R"),
                );
                return faces;
            }
            faces.extend(sides.map(|side| (element, side)));
        }
        faces
    }

    /// Returns the exterior faces of solids. RAX2 and SAX1 elements have two sides, of which the card must name one.
    fn free_sides(&mut self, elements: &[usize], span: Span) -> Vec<(usize, ElementSide)> {
        let mesh = &self.model.mesh;
        if elements.iter().any(|&e| matches!(mesh.elements[e].kind, ElementKind::Rax2 | ElementKind::Sax1)) {
            let diagnostic = Diagnostic::error("M130", "RAX2 and SAX1 elements require a side, SPOS or SNEG")
                .at(span, "no side named");
            let help = "the normal of SPOS is the direction from the first to the second node, \
                        rotated by 90 degrees counter-clockwise in (r, z)";
            self.diagnostics.push(diagnostic.help(help));
            return Vec::new();
        }
        let outside = mesh.exterior_faces();
        let of = |&e: &usize| {
            let first = outside.partition_point(|f| f.0 < e);
            outside[first..].iter().take_while(move |f| f.0 == e).copied()
        };
        elements.iter().flat_map(of).collect()
    }
}

impl ElementSurface {
    /// Returns the faces of the surface under the name used by a card.
    pub(super) fn sides(&self, name: &str) -> SideSelection {
        SideSelection {
            name: name.into(),
            surface: true,
            faces: self.faces.clone(),
            free_face_elements: self.free_face_elements.clone(),
        }
    }
}

/// Returns the sides that a label denotes for an element type; none if the type has no such side.
pub(super) fn sides_of(name: &str, kind: ElementKind) -> impl Iterator<Item = ElementSide> {
    let shell = matches!(kind, ElementKind::Rax2 | ElementKind::Sax1);
    let of_shell = match name {
        "SPOS" if shell => Some(ElementSide::Positive),
        "SNEG" if shell => Some(ElementSide::Negative),
        _ => None,
    };
    let number = name.strip_prefix('S').filter(|_| kind.is_solid()).and_then(|n| n.parse().ok());
    of_shell.into_iter().chain(number.map_or(0..0, |n| kind.face(n)).map(ElementSide::Face))
}
