//! The pairs of `*CONTACT PAIR`: which surfaces, and what the card says of them.
//! Never here: analytical surfaces and what lies opposite them, how surfaces interact, what contact does.

use super::builder::Builder;
use super::names::{qualified, upper};
use super::types::{AnalyticalSide, Clearance, Law, Sides, SurfaceContact};
use crate::deck::{Card, DataLine, Word};

impl Builder<'_> {
    /// A pair of surfaces of elements is added, or deleted.
    pub(super) fn surface_pair(&mut self, card: &Card, line: &DataLine, words: [&Word; 2], adds: bool) {
        let Some(first) = self.contact_sides(words[0]) else { return };
        let Some(second) = self.contact_sides(words[1]) else { return };
        self.add_pair(card, line, ([first, second], None), adds);
    }

    /// A pair of two surfaces, of which one may be analytical, is added, or deleted.
    pub(super) fn add_pair(
        &mut self,
        card: &Card,
        line: &DataLine,
        (sides, analytical): ([Sides; 2], Option<AnalyticalSide>),
        adds: bool,
    ) {
        let clearance = match card.value("ADJUST") {
            None => None,
            Some(word) => match self.adjust(word) {
                Some(fits) => Some(Clearance { gap: 0.0, above: Some(fits), below: Some(0.0) }),
                None => return,
            },
        };
        let penalty = card.read::<bool>("MECHANICAL CONSTRAINT").then_some(1.0);
        let same = |c: &SurfaceContact| {
            let names = [&c.sides[0].name, &c.sides[1].name];
            names == [&sides[0].name, &sides[1].name] || names == [&sides[1].name, &sides[0].name]
        };
        let pairs = &mut self.state().surface_contacts;
        let before = pairs.len();
        // A pair that is given again takes the place of the earlier one.
        pairs.retain(|c| !same(c));
        if !adds {
            if pairs.len() == before {
                self.no_pair_to_delete(line.span);
            }
            return;
        }
        let interaction = card.value("INTERACTION").and_then(|word| self.interaction(word));
        self.state().surface_contacts.push(SurfaceContact {
            sides,
            analytical,
            general: false,
            thin: card.has("NO THICKNESS"),
            clearance,
            penalty,
            cpset: card.value("CPSET").map(|w| upper(&w.text)),
            interaction,
            law: Law::default(),
            span: line.span,
        });
    }

    /// The sides of a surface of elements.
    pub(super) fn contact_sides(&mut self, word: &Word) -> Option<Sides> {
        let names = [qualified(&self.scope, &word.text), upper(&word.text)];
        if names.iter().any(|n| self.model.surfaces.nodes.contains_key(n)) {
            let message = format!("`{}` is a surface of nodes, which meets analytical surfaces alone", word.text);
            return self.refuse_unsupported(word.span, message, "give a surface of element faces");
        }
        let id = self.surface_id(word)?;
        let faces = self.model.surfaces.faces[id].faces.clone();
        if faces.is_empty() {
            return self.refuse_value(word.span, format!("surface `{}` has no faces", word.text));
        }
        Some(Sides { name: self.model.surfaces.name(id).to_owned(), surface: true, faces, whole: Vec::new() })
    }

    /// The largest gap at the start that is taken as none.
    fn adjust(&mut self, word: &Word) -> Option<f64> {
        let Some(value) = word.text.trim().parse::<f64>().ok() else {
            return self.refuse_unsupported(
                word.span,
                "ADJUST with a set of nodes is not supported",
                "give the largest gap to close",
            );
        };
        if value >= 0.0 && value.is_finite() {
            return Some(value);
        }
        self.refuse_value(word.span, format!("ADJUST is the largest gap to close, not {value}"))
    }
}
