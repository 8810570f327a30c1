//! Faces between elements that come to lie bare as what is in front of them is deleted.
//! Never here: faces that lie bare already, what acts on them.

use crate::kernel::lanes::InlineMap;
use std::ops::Range;

use super::room::with_room;
use crate::kernel::lists::heap_bytes;
use crate::kernel::topology::ElementNodes;
use crate::state::archive::{Archive, Persist, persist_fields};

/// Faces that nothing acts on yet.
#[derive(Debug, Default)]
pub struct Hidden {
    /// The two nodes of each, ascending, so that the body lies to the left of the way from the first to the second.
    faces: Vec<[usize; 2]>,
    /// Index in the mesh of the element behind each.
    elements: Vec<usize>,
    /// Whether it is still hidden, with its element behind it.
    waits: Vec<bool>,
    /// Those that have come to lie bare, in that order.
    bare: Vec<u32>,
}

impl Hidden {
    /// Faces with the elements behind them, in any order; each counts once.
    pub fn new(mut list: Vec<([usize; 2], usize)>) -> Self {
        list.sort_unstable();
        list.dedup();
        let (faces, elements): (Vec<_>, Vec<_>) = list.into_iter().unzip();
        Hidden { waits: vec![true; faces.len()], bare: Vec::with_capacity(faces.len()), faces, elements }
    }

    /// All of them, bare by now or not.
    pub fn len(&self) -> usize {
        self.faces.len()
    }

    pub fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }

    /// The nodes of all, bare by now or not.
    pub fn faces(&self) -> &[[usize; 2]] {
        &self.faces
    }

    pub fn bare(&self) -> usize {
        self.bare.len()
    }

    /// Of those that lie bare by the order in which they came: index among all, nodes, element.
    pub fn came(&self, at: usize) -> (usize, [usize; 2], usize) {
        let i = self.bare[at] as usize;
        (i, self.faces[i], self.elements[i])
    }

    /// Elements with these boundaries are deleted: their faces stay hidden, those against them are exposed if the element behind is
    /// still there. Returns which have come, for [`Hidden::came`].
    pub fn release(&mut self, deleted: &[ElementNodes]) -> Range<usize> {
        let first = self.bare.len();
        if self.faces.is_empty() {
            return first..first;
        }
        let edges = || deleted.iter().flat_map(|boundary| boundary.sides()).map(|side| side.inline_map(|n| n as usize));
        for own in edges() {
            if let Ok(i) = self.faces.binary_search(&own) {
                self.waits[i] = false;
            }
        }
        for [a, b] in edges() {
            if let Ok(i) = self.faces.binary_search(&[b, a])
                && std::mem::replace(&mut self.waits[i], false)
            {
                self.bare.push(i as u32);
            }
        }
        first..self.bare.len()
    }

    pub fn bytes(&self) -> usize {
        heap_bytes(&self.faces) + heap_bytes(&self.elements) + self.waits.capacity() + heap_bytes(&self.bare)
    }
}

impl Clone for Hidden {
    fn clone(&self) -> Self {
        let Hidden { faces, elements, waits, bare } = self;
        let (faces, elements, waits) = (faces.clone(), elements.clone(), waits.clone());
        Hidden { faces, elements, waits, bare: with_room(bare) }
    }
}

impl Persist for Hidden {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Hidden { faces, elements: _, waits, bare } = self;
        if faces.is_empty() {
            return;
        }
        persist_fields!(archive; waits.as_mut_slice(), bare);
        if bare.len() > faces.len() || bare.iter().any(|i| *i as usize >= faces.len()) {
            archive.refuse(|| "faces lie bare that the deck does not have".into());
            bare.clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Hidden;
    use crate::kernel::topology::ElementNodes;

    /// Two squares above each other between nodes 0 to 5, each two nodes a row: what is between them has two sides.
    #[test]
    fn a_face_comes_when_what_is_in_front_goes_and_never_without_what_is_behind() {
        let [lower, upper] = [[0, 1, 3, 2], [2, 3, 5, 4]].map(ElementNodes::from);
        let both = || Hidden::new(vec![([3, 2], 7), ([2, 3], 8), ([3, 2], 7)]);
        let mut hidden = both();
        assert_eq!(hidden.len(), 2);
        let came: Vec<_> = hidden.release(&[upper]).map(|at| hidden.came(at)).collect();
        assert_eq!(came, [(1, [3, 2], 7)]);
        assert_eq!(hidden.release(&[lower]).len(), 0);
        assert_eq!(both().release(&[lower, upper]).len(), 0);
    }
}
