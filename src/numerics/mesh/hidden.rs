//! Interior faces, which become exposed when an adjacent element is deleted.

use crate::kernel::lanes::InlineMap;
use std::ops::Range;

use super::room::clone_with_capacity;
use crate::kernel::lists::Memory;
use crate::kernel::topology::ElementNodes;
use crate::state::archive::{Persist, StateArchive, persist_fields};

/// Interior faces and their exposure state.
#[derive(Debug, Default, Memory)]
pub struct InteriorFaces {
    /// Nodes of each face, in ascending order of faces; the body is on the left in the direction from first to second
    /// node.
    faces: Vec<[usize; 2]>,
    /// Mesh index of the element of each face.
    elements: Vec<usize>,
    /// Whether the face is still hidden and its element not deleted.
    is_hidden: Vec<bool>,
    /// Indices of the exposed faces, in order of exposure.
    exposed: Vec<u32>,
}

/// A face that was inside.
#[derive(Debug, PartialEq)]
pub struct ExposedFace {
    /// Index among all faces that are hidden at the start.
    pub index: usize,
    pub nodes: [usize; 2],
    /// Mesh index of its element.
    pub element: usize,
}

impl InteriorFaces {
    /// Creates the interior faces from nodes and element indices in any order; duplicates are removed.
    pub fn new(mut list: Vec<([usize; 2], usize)>) -> Self {
        list.sort_unstable();
        list.dedup();
        let (faces, elements): (Vec<_>, Vec<_>) = list.into_iter().unzip();
        InteriorFaces { is_hidden: vec![true; faces.len()], exposed: Vec::with_capacity(faces.len()), faces, elements }
    }

    /// Returns the number of faces, hidden or exposed.
    pub fn len(&self) -> usize {
        self.faces.len()
    }

    pub fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }

    /// Returns the nodes of all faces, hidden or exposed.
    pub fn faces(&self) -> &[[usize; 2]] {
        &self.faces
    }

    pub fn exposed_count(&self) -> usize {
        self.exposed.len()
    }

    /// Returns the exposed face with a number in order of exposure.
    pub fn exposed_face(&self, at: usize) -> ExposedFace {
        let index = self.exposed[at] as usize;
        ExposedFace { index, nodes: self.faces[index], element: self.elements[index] }
    }

    /// Deletes elements: their own faces will not be exposed, and the opposite faces of elements that remain become
    /// exposed. Returns the range of newly exposed faces, for [`InteriorFaces::exposed_face`].
    pub fn remove_elements(&mut self, deleted: &[ElementNodes]) -> Range<usize> {
        let first = self.exposed.len();
        if self.faces.is_empty() {
            return first..first;
        }
        let edges = || deleted.iter().flat_map(|boundary| boundary.sides()).map(|side| side.inline_map(|n| n as usize));
        for own in edges() {
            if let Ok(i) = self.faces.binary_search(&own) {
                self.is_hidden[i] = false;
            }
        }
        for [a, b] in edges() {
            if let Ok(i) = self.faces.binary_search(&[b, a])
                && std::mem::replace(&mut self.is_hidden[i], false)
            {
                self.exposed.push(i as u32);
            }
        }
        first..self.exposed.len()
    }
}

impl Clone for InteriorFaces {
    fn clone(&self) -> Self {
        let InteriorFaces { faces, elements, is_hidden, exposed } = self;
        let (faces, elements, is_hidden) = (faces.clone(), elements.clone(), is_hidden.clone());
        InteriorFaces { faces, elements, is_hidden, exposed: clone_with_capacity(exposed) }
    }
}

impl Persist for InteriorFaces {
    fn persist(&mut self, archive: &mut StateArchive<'_>) {
        let InteriorFaces { faces, elements: _, is_hidden, exposed } = self;
        if faces.is_empty() {
            return;
        }
        persist_fields!(archive; is_hidden.as_mut_slice(), exposed);
        if exposed.len() > faces.len() || exposed.iter().any(|i| *i as usize >= faces.len()) {
            archive.reject(|| "the exposed faces do not match the deck".into());
            exposed.clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{ExposedFace, InteriorFaces};
    use crate::kernel::topology::ElementNodes;

    /// Two stacked squares with nodes 0 to 5; the face between them has two sides.
    #[test]
    fn a_face_is_exposed_only_if_its_own_element_remains() {
        let [lower, upper] = [[0, 1, 3, 2], [2, 3, 5, 4]].map(ElementNodes::from);
        let both = || InteriorFaces::new(vec![([3, 2], 7), ([2, 3], 8), ([3, 2], 7)]);
        let mut hidden = both();
        assert_eq!(hidden.len(), 2);
        let came: Vec<_> = hidden.remove_elements(&[upper]).map(|at| hidden.exposed_face(at)).collect();
        assert_eq!(came, [ExposedFace { index: 1, nodes: [3, 2], element: 7 }]);
        assert_eq!(hidden.remove_elements(&[lower]).len(), 0);
        assert_eq!(both().remove_elements(&[lower, upper]).len(), 0);
    }
}
