//! All degrees of freedom of a scene: rigid bodies, with one along z or with six, and nodes, which move along r and z.
//! Never here: what makes them move.

use super::BodyState;
use super::archive::persist_struct;
use super::energies::Energies;
use super::nodes::Nodes;

/// One degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Dof {
    /// A rigid body, along z.
    Body(usize),
    /// A node, along r (0) or z (1).
    Node(usize, usize),
}

/// What moves, and the energies that go with it.
#[derive(Clone, Debug, Default)]
pub struct Dofs {
    /// Rigid bodies.
    pub bodies: Vec<BodyState>,
    /// Nodes of what deforms.
    pub nodes: Nodes,
    /// Energies of what deforms.
    pub energies: Energies,
}

impl Dofs {
    /// Displacement.
    pub fn displacement(&self, dof: Dof) -> f64 {
        match dof {
            Dof::Body(b) => self.bodies[b].displacement,
            Dof::Node(n, axis) => self.nodes.displacement(n)[axis],
        }
    }

    /// Velocity at the instant's own time; of a rigid body in contact with that of the increment behind over half of it.
    pub fn velocity(&self, dof: Dof) -> f64 {
        match dof {
            Dof::Body(b) if self.bodies[b].contact == 0.0 => self.bodies[b].velocity,
            Dof::Body(b) => self.bodies[b].velocity + 0.5 * self.nodes.behind * self.bodies[b].contact,
            Dof::Node(n, axis) => self.nodes.velocity_now(n)[axis],
        }
    }

    /// Acceleration; of a rigid body in contact with that of the increment behind.
    pub fn acceleration(&self, dof: Dof) -> f64 {
        match dof {
            Dof::Body(b) if self.bodies[b].contact == 0.0 => self.bodies[b].acceleration,
            Dof::Body(b) => self.bodies[b].acceleration + self.bodies[b].contact,
            Dof::Node(n, axis) => self.nodes.acceleration[n][axis],
        }
    }

    /// Mass.
    pub fn mass(&self, dof: Dof) -> f64 {
        match dof {
            Dof::Body(b) => self.bodies[b].mass,
            Dof::Node(n, _) => self.nodes.mass[n],
        }
    }
}

persist_struct!(Dofs { bodies: fixed, nodes, energies });
