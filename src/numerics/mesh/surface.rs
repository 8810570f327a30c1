//! Surfaces: facets of rigid bodies and faces of deformable elements.

use super::hidden::InteriorFaces;
use super::room::clone_with_capacity;
use crate::kernel::facet::Facet;
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::Memory;
use crate::kernel::topology::ElementNodes;
use crate::platform::PortableMath as _;
use crate::state::archive::{Persist, StateArchive};
use crate::state::nodes::Nodes;

/// A surface; either part may be empty.
#[derive(Clone, Debug, Default, Persist, Memory)]
#[persist(derived: patches)]
pub struct SurfaceGeometry {
    /// Rigid parts, one per rigid body.
    pub patches: Vec<RigidFacets>,
    /// Faces of deformable elements in the surface.
    pub skin: DeformableFaces,
}

/// Facets of one rigid body in their initial position.
#[derive(Clone, Debug, Memory)]
pub struct RigidFacets {
    pub body: usize,
    /// Mesh index of the element, and facet.
    pub facets: Vec<(usize, Facet)>,
}

/// Faces of deformable elements.
#[derive(Debug, Default, Memory)]
pub struct DeformableFaces {
    /// Nodes of each face; the body is on the left in the direction from first to second node.
    pub faces: Vec<[usize; 2]>,
    /// Mesh index of the element of each face.
    pub elements: Vec<usize>,
    /// Whether the element of each face is not deleted.
    pub is_active: Vec<bool>,
    /// Whether the element of each face is a shell; empty if there are no shells.
    pub shells: Vec<bool>,
    /// Interior faces, appended to `faces` when they become exposed; capacity for all of them is reserved.
    hidden: Option<Box<InteriorFaces>>,
}

/// A face with the current coordinates of its end points.
#[derive(Clone, Copy, Debug)]
pub struct CurrentFace {
    pub nodes: [usize; 2],
    /// Current coordinates of the nodes, `[r, z]`.
    pub ends: [[f64; 2]; 2],
    /// Outward unit normal.
    pub normal: [f64; 2],
}

impl CurrentFace {
    #[inline]
    pub fn new(face: [usize; 2], nodes: &Nodes) -> CurrentFace {
        let [a, b] = face.inline_map(|n| nodes[n].place());
        let (dr, dz) = (b[0] - a[0], b[1] - a[1]);
        let length = dr.portable_hypot(dz);
        CurrentFace { nodes: face, ends: [a, b], normal: [dz / length, -dr / length] }
    }

    pub fn middle(&self) -> [f64; 2] {
        let [a, b] = self.ends;
        [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
    }

    /// Returns the mean of a nodal quantity over both nodes.
    #[inline]
    pub fn mean(&self, of: impl Fn(usize) -> [f64; 2]) -> [f64; 2] {
        let [a, b] = self.nodes.inline_map(of);
        [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
    }

    /// Returns the normal velocity at the time of the current increment.
    pub fn normal_velocity(&self, nodes: &Nodes) -> f64 {
        let v = self.mean(|n| nodes.velocity_now(n));
        v[0] * self.normal[0] + v[1] * self.normal[1]
    }
}

impl SurfaceGeometry {
    /// Returns whether the surface has neither facets nor faces.
    pub fn is_empty(&self) -> bool {
        self.patches.is_empty() && self.skin.faces.is_empty()
    }

    /// Returns the number of facets and faces.
    pub fn count(&self) -> usize {
        self.patches.iter().map(|p| p.facets.len()).sum::<usize>() + self.skin.faces.len()
    }
}

impl DeformableFaces {
    /// Creates active faces from nodes and elements.
    pub fn new(faces: Vec<[usize; 2]>, elements: Vec<usize>) -> Self {
        DeformableFaces { is_active: vec![true; faces.len()], faces, elements, shells: Vec::new(), hidden: None }
    }

    /// Adds interior faces, which become active when the opposite element is deleted.
    pub fn with_hidden(mut self, hidden: InteriorFaces) -> DeformableFaces {
        if !hidden.is_empty() {
            self.reserve(hidden.len());
            self.hidden = Some(Box::new(hidden));
        }
        self
    }

    /// Returns the number of faces when all interior faces are exposed.
    pub fn max_faces(&self) -> usize {
        self.faces.len() + self.hidden.as_ref().map_or(0, |h| h.len() - h.exposed_count())
    }

    pub fn hidden(&self) -> Option<&InteriorFaces> {
        self.hidden.as_deref()
    }

    /// Reserves capacity for more faces; nothing may allocate during an increment.
    pub fn reserve(&mut self, more: usize) {
        self.faces.reserve_exact(more);
        self.elements.reserve_exact(more);
        self.is_active.reserve_exact(more);
        if !self.shells.is_empty() {
            self.shells.reserve_exact(more);
        }
    }

    /// Adds an exposed face of a solid.
    pub fn push(&mut self, face: [usize; 2], element: usize) {
        self.faces.push(face);
        self.elements.push(element);
        self.is_active.push(true);
        if !self.shells.is_empty() {
            self.shells.push(false);
        }
    }

    /// Returns `count` faces starting with `first`, all active.
    pub fn part(&self, first: usize, count: usize) -> DeformableFaces {
        let [first, last] = [first, first + count].inline_map(|at| at.min(self.faces.len()));
        let range = first..last;
        let shells = self.shells.get(range.clone()).unwrap_or_default().to_vec();
        DeformableFaces {
            shells,
            ..DeformableFaces::new(self.faces[range.clone()].to_vec(), self.elements[range].to_vec())
        }
    }

    /// Iterates over the faces whose element is not deleted.
    pub fn active_faces(&self) -> impl Iterator<Item = [usize; 2]> {
        self.faces.iter().zip(&self.is_active).filter(|f| *f.1).map(|f| *f.0)
    }

    /// Iterates over the faces whose element is not deleted, and whether it is a shell.
    pub fn active_faces_with_shells(&self) -> impl Iterator<Item = ([usize; 2], bool)> {
        let shell = |i: usize| self.shells.get(i).copied().unwrap_or(false);
        self.faces.iter().zip(&self.is_active).enumerate().filter(|f| *f.1.1).map(move |(i, f)| (*f.0, shell(i)))
    }

    /// Deletes elements: their faces become inactive, and newly exposed interior faces are added.
    pub fn remove_elements(&mut self, deleted: &[ElementNodes]) {
        for (face, is_active) in self.faces.iter().zip(&mut self.is_active) {
            *is_active &= !belongs_to_any(*face, deleted);
        }
        let Some(mut hidden) = self.hidden.take() else { return };
        hidden.remove_elements(deleted).for_each(|at| {
            let face = hidden.exposed_face(at);
            self.push(face.nodes, face.element);
        });
        self.hidden = Some(hidden);
    }

    /// Keeps the first `count` faces.
    pub fn truncate(&mut self, count: usize) {
        self.faces.truncate(count);
        self.elements.truncate(count);
        self.is_active.truncate(count);
        self.shells.truncate(count);
    }
}

/// Returns whether a face is a side of one of these elements, in the same direction; a neighbour has the opposite
/// direction.
fn belongs_to_any(face: [usize; 2], elements: &[ElementNodes]) -> bool {
    let face = face.inline_map(|n| n as u32);
    elements.iter().any(|boundary| boundary.sides().any(|side| side == face))
}

impl Clone for DeformableFaces {
    fn clone(&self) -> Self {
        let DeformableFaces { faces, elements, is_active, shells, hidden } = self;
        let (faces, elements) = (clone_with_capacity(faces), clone_with_capacity(elements));
        DeformableFaces {
            faces,
            elements,
            is_active: clone_with_capacity(is_active),
            shells: clone_with_capacity(shells),
            hidden: hidden.clone(),
        }
    }
}

impl Persist for DeformableFaces {
    fn persist(&mut self, archive: &mut StateArchive<'_>) {
        // Faces are determined by the plan and by the faces exposed since.
        let DeformableFaces { faces: _, elements: _, is_active: _, shells: _, hidden } = self;
        if let Some(mut hidden) = hidden.take() {
            let first = self.faces.len() - hidden.exposed_count();
            hidden.persist(archive);
            if archive.reads() {
                self.truncate(first);
                (0..hidden.exposed_count()).for_each(|at| {
                    let face = hidden.exposed_face(at);
                    self.push(face.nodes, face.element);
                });
            }
            self.hidden = Some(hidden);
        }
        self.is_active.as_mut_slice().persist(archive);
    }
}
