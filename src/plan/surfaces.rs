//! Surfaces of loads: sides of elements as facets of rigid bodies and faces of what deforms.
//! Never here: what acts on them.

use std::collections::BTreeMap;

use super::Compiler;
use crate::deck::{Diagnostic, Span};
use crate::kernel::facet::Facet;
use crate::mesh::surface::{Patch, Skin, Surface};
use crate::model::{ElementKind, Side, Sides};

impl Compiler<'_> {
    /// The surface of some sides. Elements of no body are an error.
    pub(super) fn surface(&mut self, sides: &Sides, span: Span) -> Surface {
        let mut by_body: BTreeMap<usize, Vec<(usize, Facet)>> = BTreeMap::new();
        let (mut faces, mut behind, mut shells) = (Vec::new(), Vec::new(), Vec::new());
        let mut stray = None;
        for &(element, side) in &sides.faces {
            if self.places.elements.contains_key(&element) {
                if let Some(mut ends) = self.model.mesh.ends(element, side) {
                    // The body lies to the left of the way; seen from the side of its normal a shell lies to the right.
                    if side == Side::Positive {
                        ends.reverse();
                    }
                    faces.push(ends.map(|n| self.places.nodes[&n]));
                    behind.push(element);
                    shells.push(self.model.mesh.elements[element].kind == ElementKind::Sax1);
                }
                continue;
            }
            match (self.body_of_element.get(&element), self.facet(element, side)) {
                (Some(&body), Some(facet)) => by_body.entry(body).or_default().push((element, facet)),
                (None, _) => stray = stray.or(Some(element)),
                _ => {}
            }
        }
        if let Some(element) = stray {
            let name = &self.model.mesh.elements[element].name;
            let message = format!("`{}` holds element {name}, which belongs to no body", sides.name);
            self.diagnostics.push(Diagnostic::error("P003", message).at(span, "this load needs facets of a body"));
        }
        let patches = by_body.into_iter().map(|(body, facets)| Patch { body, facets }).collect();
        let mut skin = Skin::new(faces, behind);
        if shells.contains(&true) {
            skin.shells = shells;
        }
        Surface { patches, skin }
    }

    /// The facet of one side. A solid's face runs counter-clockwise, so its outward normal is the negative side.
    fn facet(&self, element: usize, side: Side) -> Option<Facet> {
        let mesh = &self.model.mesh;
        let [from, to] = mesh.ends(element, side)?.map(|n| mesh.points[n]);
        Facet::new(from, to, side == Side::Positive)
    }
}
