//! Surfaces: chains of facets on rigid bodies, whose shape never changes, and of faces on deformable nodes.
//! Never here: what acts on a surface, what of the inside comes to lie bare (`hidden`).

use super::hidden::Hidden;
use super::room::with_room;
use crate::kernel::facet::Facet;
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::heap_bytes;
use crate::kernel::topology::ElementNodes;
use crate::platform::PortableMath as _;
use crate::state::archive::{Archive, Persist};
use crate::state::nodes::Nodes;

/// A surface of a scene; either part may be empty.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    /// The parts on rigid bodies, each body once.
    pub patches: Vec<Patch>,
    /// The part on what deforms.
    pub skin: Skin,
}

/// The facets of one rigid body at their places at the start.
#[derive(Clone, Debug)]
pub struct Patch {
    pub body: usize,
    /// Facets with the index of their element in the mesh.
    pub facets: Vec<(usize, Facet)>,
}

/// Faces of deformable elements.
#[derive(Debug, Default)]
pub struct Skin {
    /// The two nodes of each, so that the body lies to the left of the way from the first to the second.
    pub faces: Vec<[usize; 2]>,
    /// Index in the mesh of the element behind each.
    pub elements: Vec<usize>,
    /// Whether that element is still there.
    pub carries: Vec<bool>,
    /// Whether it is a shell; empty where none is.
    pub shells: Vec<bool>,
    /// Faces that come behind these as they come to lie bare; there is room for all.
    hidden: Option<Box<Hidden>>,
}

/// A face as it is now.
#[derive(Clone, Copy, Debug)]
pub struct Face {
    pub nodes: [usize; 2],
    /// Places of the nodes, `[r, z]`.
    pub ends: [[f64; 2]; 2],
    /// Outward unit normal.
    pub normal: [f64; 2],
}

impl Face {
    #[inline]
    pub fn new(face: [usize; 2], nodes: &Nodes) -> Face {
        let [a, b] = face.inline_map(|n| nodes[n].place());
        let (dr, dz) = (b[0] - a[0], b[1] - a[1]);
        let length = dr.portable_hypot(dz);
        Face { nodes: face, ends: [a, b], normal: [dz / length, -dr / length] }
    }

    pub fn middle(&self) -> [f64; 2] {
        let [a, b] = self.ends;
        [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
    }

    /// Mean of what its two nodes have.
    #[inline]
    pub fn mean(&self, of: impl Fn(usize) -> [f64; 2]) -> [f64; 2] {
        let [a, b] = self.nodes.inline_map(of);
        [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
    }

    /// Velocity along the normal at the instant's own time.
    pub fn normal_velocity(&self, nodes: &Nodes) -> f64 {
        let v = self.mean(|n| nodes.velocity_now(n));
        v[0] * self.normal[0] + v[1] * self.normal[1]
    }
}

impl Surface {
    /// Whether it has neither facets nor faces.
    pub fn is_empty(&self) -> bool {
        self.patches.is_empty() && self.skin.faces.is_empty()
    }

    /// Facets and faces.
    pub fn count(&self) -> usize {
        self.patches.iter().map(|p| p.facets.len()).sum::<usize>() + self.skin.faces.len()
    }

    pub fn bytes(&self) -> usize {
        let facets = |p: &Patch| heap_bytes(&p.facets);
        self.patches.iter().map(facets).sum::<usize>() + heap_bytes(&self.patches) + self.skin.bytes()
    }
}

impl Skin {
    /// Faces that all carry, with the elements behind them.
    pub fn new(faces: Vec<[usize; 2]>, elements: Vec<usize>) -> Self {
        Skin { carries: vec![true; faces.len()], faces, elements, shells: Vec::new(), hidden: None }
    }

    /// The same with faces between elements, which carry from when the element in front of them goes.
    pub fn with_hidden(mut self, hidden: Hidden) -> Skin {
        if !hidden.is_empty() {
            self.make_room(hidden.len());
            self.hidden = Some(Box::new(hidden));
        }
        self
    }

    /// The faces that it and its hidden ones can come to.
    pub fn most(&self) -> usize {
        self.faces.len() + self.hidden.as_ref().map_or(0, |h| h.len() - h.bare())
    }

    pub fn hidden(&self) -> Option<&Hidden> {
        self.hidden.as_deref()
    }

    /// Makes room for so many faces more: nothing allocates inside an increment.
    pub fn make_room(&mut self, more: usize) {
        self.faces.reserve_exact(more);
        self.elements.reserve_exact(more);
        self.carries.reserve_exact(more);
        if !self.shells.is_empty() {
            self.shells.reserve_exact(more);
        }
    }

    /// Adds a face of a solid that has come to lie bare.
    pub fn push(&mut self, face: [usize; 2], element: usize) {
        self.faces.push(face);
        self.elements.push(element);
        self.carries.push(true);
        if !self.shells.is_empty() {
            self.shells.push(false);
        }
    }

    /// Some of its faces, all of which carry.
    pub fn part(&self, first: usize, count: usize) -> Skin {
        let [first, last] = [first, first + count].inline_map(|at| at.min(self.faces.len()));
        let range = first..last;
        let shells = self.shells.get(range.clone()).unwrap_or_default().to_vec();
        Skin { shells, ..Skin::new(self.faces[range.clone()].to_vec(), self.elements[range].to_vec()) }
    }

    /// The faces behind which there is an element.
    pub fn carrying(&self) -> impl Iterator<Item = [usize; 2]> {
        self.faces.iter().zip(&self.carries).filter(|f| *f.1).map(|f| *f.0)
    }

    /// The faces behind which there is an element, with whether that is a shell.
    pub fn carrying_shells(&self) -> impl Iterator<Item = ([usize; 2], bool)> {
        let shell = |i: usize| self.shells.get(i).copied().unwrap_or(false);
        self.faces.iter().zip(&self.carries).enumerate().filter(|f| *f.1.1).map(move |(i, f)| (*f.0, shell(i)))
    }

    /// Elements with these boundaries are deleted: their faces no longer carry, hidden ones that are exposed do.
    pub fn release(&mut self, deleted: &[ElementNodes]) {
        for (face, carries) in self.faces.iter().zip(&mut self.carries) {
            *carries &= !is_of(*face, deleted);
        }
        let Some(mut hidden) = self.hidden.take() else { return };
        hidden.release(deleted).for_each(|at| {
            let (_, face, element) = hidden.came(at);
            self.push(face, element);
        });
        self.hidden = Some(hidden);
    }

    /// Takes the last faces away, so that so many are left.
    pub fn cut(&mut self, count: usize) {
        self.faces.truncate(count);
        self.elements.truncate(count);
        self.carries.truncate(count);
        self.shells.truncate(count);
    }

    pub fn bytes(&self) -> usize {
        heap_bytes(&self.faces)
            + heap_bytes(&self.elements)
            + self.carries.capacity()
            + self.shells.capacity()
            + self.hidden.as_ref().map_or(0, |h| size_of_val(&**h) + h.bytes())
    }
}

/// Whether a face belongs to one of these elements: its nodes follow each other there, and in no neighbour.
fn is_of(face: [usize; 2], elements: &[ElementNodes]) -> bool {
    let face = face.inline_map(|n| n as u32);
    elements.iter().any(|boundary| boundary.sides().any(|side| side == face))
}

impl Clone for Skin {
    fn clone(&self) -> Self {
        let Skin { faces, elements, carries, shells, hidden } = self;
        let (faces, elements) = (with_room(faces), with_room(elements));
        Skin { faces, elements, carries: with_room(carries), shells: with_room(shells), hidden: hidden.clone() }
    }
}

impl Persist for Skin {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        // Faces follow from the plan and from those that have been exposed since.
        let Skin { faces: _, elements: _, carries: _, shells: _, hidden } = self;
        if let Some(mut hidden) = hidden.take() {
            let first = self.faces.len() - hidden.bare();
            hidden.persist(archive);
            if archive.reads() {
                self.cut(first);
                (0..hidden.bare()).for_each(|at| {
                    let (_, face, element) = hidden.came(at);
                    self.push(face, element);
                });
            }
            self.hidden = Some(hidden);
        }
        self.carries.as_mut_slice().persist(archive);
    }
}
