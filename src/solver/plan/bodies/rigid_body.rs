//! The rigid bodies of a plan and their nodes and elements.

use indexmap::IndexMap;

use crate::deck::Span;
use crate::kernel::lists::heap_bytes;

/// Rigid bodies in the order of the model, and the body of each node and element.
#[derive(Default)]
pub struct Bodies {
    pub list: Vec<PlannedRigidBody>,
    pub of_node: IndexMap<usize, usize>,
    pub of_element: IndexMap<usize, usize>,
}

impl Bodies {
    /// Takes the list of bodies, with their initial velocities.
    pub fn take_list(&mut self, velocities: &[f64]) -> Vec<PlannedRigidBody> {
        let mut list = std::mem::take(&mut self.list);
        list.iter_mut().zip(velocities).for_each(|(body, velocity)| body.initial_velocity = *velocity);
        list
    }
}

/// A rigid body of the plan. Nodes and elements are mesh indices.
#[derive(Clone, Debug)]
pub struct PlannedRigidBody {
    /// Name in messages and results.
    pub name: String,
    /// Index of the reference node.
    pub reference: usize,
    /// Nodes with lumped mass: `(node, mass)`, in ascending order.
    pub lumped_mass: Vec<(usize, f64)>,
    /// Mass of deformable elements at shared nodes.
    pub tied_mass: f64,
    /// All nodes that move with the body, in ascending order.
    pub nodes: Vec<usize>,
    /// Elements of the body.
    pub elements: Vec<usize>,
    /// Whether the body has six degrees of freedom; otherwise it moves along z only.
    pub spatial: bool,
    /// Lowest and highest initial z of elements, nodes and analytical surfaces; without any, of the reference node.
    pub along_z: [f64; 2],
    /// Initial velocity along z.
    pub initial_velocity: f64,
    /// Span of `*RIGID BODY`.
    pub span: Span,
}

impl PlannedRigidBody {
    /// Returns the total mass: own mass and mass of tied deformable elements.
    pub fn mass(&self) -> f64 {
        self.own_mass() + self.tied_mass
    }

    /// Returns the size in bytes, including lists.
    pub fn bytes(&self) -> usize {
        let places = size_of::<usize>() * (self.nodes.capacity() + self.elements.capacity());
        size_of_val(self) + self.name.capacity() + places + heap_bytes(&self.lumped_mass)
    }

    /// Returns the mass without tied deformable elements: the sum of the lumped masses.
    pub fn own_mass(&self) -> f64 {
        self.lumped_mass.iter().map(|m| m.1).sum()
    }
}
