//! The relation of a coarsened mesh to the mesh of the deck.

use std::collections::HashMap;

use crate::deck::Span;
use crate::model::types::{Element, ElementSide, Mesh};

/// A reason why a mesh cannot be coarsened, with the place in the deck.
#[derive(Debug)]
pub struct CoarseningFault {
    /// Message and label of the place.
    pub words: [String; 2],
    /// Source position of an element, or of a card that refers to it.
    pub span: Span,
}

impl CoarseningFault {
    /// Creates a fault.
    pub fn new(message: impl Into<String>, label: impl Into<String>, span: Span) -> CoarseningFault {
        CoarseningFault { words: [message.into(), label.into()], span }
    }
}

/// Relation of a coarsened mesh to the mesh of the deck, whose nodes keep their indices.
#[derive(Debug, Default)]
pub struct CoarsenedMesh {
    /// Elements of the deck that each element replaces.
    pub parts: Vec<Vec<usize>>,
    /// Element that replaces each element of the deck.
    pub merged: Vec<usize>,
    /// Whether a node of the deck belongs to elements of the deck, but to no merged one.
    pub is_removed: Vec<bool>,
}

impl CoarsenedMesh {
    /// Adds a merged element in place of elements of the deck.
    pub fn add(&mut self, element: Element, parts: Vec<usize>, mesh: &mut Mesh) {
        for &part in &parts {
            self.merged[part] = mesh.elements.len();
        }
        mesh.elements.push(element);
        self.parts.push(parts);
    }

    /// Returns the faces of the mesh of the deck that a face of a merged element replaces.
    pub fn faces_of(
        &self,
        coarse: &Mesh,
        fine: &Mesh,
        (element, side): (usize, ElementSide),
    ) -> Vec<(usize, ElementSide)> {
        let parts = &self.parts[element];
        let ElementSide::Face(_) = side else { return parts.iter().map(|&part| (part, side)).collect() };
        let Some([from, to]) = coarse.side_nodes(element, side) else { return Vec::new() };
        let faces = parts.iter().flat_map(|&part| (1..=4).map(move |number| (part, ElementSide::Face(number))));
        let ends = faces.filter_map(|face| Some((fine.side_nodes(face.0, face.1)?, face)));
        let starts: HashMap<[usize; 2], (usize, ElementSide)> = ends.collect();
        // Faces between two parts occur in both directions.
        let outer = starts.iter().filter(|([a, b], _)| !starts.contains_key(&[*b, *a]));
        let next: HashMap<usize, (usize, (usize, ElementSide))> =
            outer.map(|(&[a, b], &face)| (a, (b, face))).collect();
        let (mut node, mut outer_faces) = (from, Vec::new());
        while let Some(&(end, face)) = next.get(&node).filter(|_| node != to && outer_faces.len() <= next.len()) {
            outer_faces.push(face);
            node = end;
        }
        outer_faces
    }
}
