//! New meshes of bodies during a run: the outline of a deformed body is divided again, its inside is filled with
//! elements, mostly quadrilaterals, and masses, momentum and element variables are moved to the new elements.

pub mod balanced_parts;
mod folds;
mod improvement;
pub mod interpolation;
pub mod mesher;
pub mod outline;
pub mod overlap;
mod pairing;
pub mod patch;
pub mod sheets;
pub mod sizes;
mod splitting;
pub mod transfer;
mod triangulation;

use crate::kernel::lanes::InlineMap;
use crate::kernel::shape::quad_area;
use crate::remesh::interpolation::TracerPoint;
use crate::state::archive::Persist;

/// Quadrilaterals of a body with its own numbering of nodes. The last two nodes of a triangle are the same.
#[derive(Clone, Debug, Default, PartialEq, Persist)]
pub struct BodyMesh {
    /// Places `[r, z]` of the nodes.
    pub points: Vec<[f64; 2]>,
    /// Nodes of each element, counter-clockwise.
    pub quads: Vec<[u32; 4]>,
    /// Length of the edges that a mesh should have at the place of each element.
    pub sizes: Vec<f64>,
}

/// Largest number of elements of a new mesh of a body.
pub const MOST_NEW_ELEMENTS: f64 = 5e6;

impl BodyMesh {
    /// Returns the number of squares of the wanted sizes that have the area of the mesh.
    pub fn expected_elements(&self) -> f64 {
        let squares = |(quad, size): (&[u32; 4], &f64)| quad_area(self.corners(quad)).abs() / (size * size);
        self.quads.iter().zip(&self.sizes).map(squares).sum()
    }

    /// Returns the corners of an element.
    pub fn corners(&self, quad: &[u32; 4]) -> [[f64; 2]; 4] {
        quad.inline_map(|n| self.points[n as usize])
    }
}

/// Side of a new element on the boundary of its body, and the side of an old element on which it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Persist)]
pub struct RevisedSide {
    /// Index of the new element, and number of its side from 0.
    pub new: (u32, u8),
    /// Index of the old element, and number of its side from 0.
    pub old: (u32, u8),
}

/// A new mesh of a body, with what relates it to the mesh that it replaces.
#[derive(Clone, Debug, Default, PartialEq, Persist)]
pub struct MeshRevision {
    /// Index of the body among those that can have new meshes.
    pub body: usize,
    /// Nodes and elements.
    pub mesh: BodyMesh,
    /// For each new node the two old nodes between which it is, twice the same one at the place of this node;
    /// [`INSIDE`] for new nodes inside the body.
    pub parents: Vec<[u32; 2]>,
    /// Sides on the boundary.
    pub sides: Vec<RevisedSide>,
    /// Place at the start of each new node: its place less the displacement of the material there.
    pub starts: Vec<[f64; 2]>,
    /// For each new element the old element at its centre.
    pub origins: Vec<u32>,
    /// Number of elements that the old mesh has, too: the first ones, with the same nodes. Their old elements are in
    /// `origins`. Zero if the whole body has a new mesh.
    pub unchanged: usize,
    /// Points of histories in the new mesh, between its nodes, in the order of the nodes of the model before it whose names
    /// they have.
    pub tracers: Vec<TracerPoint>,
    /// Places of all nodes of the model before it; empty if it has no ties.
    pub places: Vec<[f64; 2]>,
}

/// Marks new nodes that are not on the boundary.
pub const INSIDE: u32 = u32::MAX;
