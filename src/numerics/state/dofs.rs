//! Degrees of freedom of a model: rigid bodies (one or six), and nodes (r and z).

use super::BodyState;
use super::archive::Persist;
use super::energies::EnergyTotals;
use super::nodes::Nodes;

/// A degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Dof {
    /// Displacement of a rigid body along z.
    Body(usize),
    /// Displacement of a node along r (0) or z (1).
    Node(usize, usize),
}

/// Degrees of freedom of a model, and the energies of deformable bodies.
#[derive(Clone, Debug, Default, Persist)]
#[persist(fixed: bodies)]
pub struct Dofs {
    /// State of the rigid bodies, in the order of the model.
    pub bodies: Vec<BodyState>,
    /// Nodes of deformable bodies.
    pub nodes: Nodes,
    /// Energies of deformable bodies.
    pub energies: EnergyTotals,
}

impl Dofs {
    /// Returns the displacement along a degree of freedom since the start of the analysis.
    pub fn displacement(&self, dof: Dof) -> f64 {
        match dof {
            Dof::Body(b) => self.bodies[b].displacement,
            Dof::Node(n, axis) => self.nodes.displacement(n)[axis],
        }
    }

    /// Returns the velocity at the current instant; for a rigid body in contact, including half the velocity change by
    /// contact over the previous increment.
    pub fn velocity(&self, dof: Dof) -> f64 {
        match dof {
            Dof::Body(b) if self.bodies[b].contact == 0.0 => self.bodies[b].velocity,
            Dof::Body(b) => self.bodies[b].velocity + 0.5 * self.nodes.previous_dt * self.bodies[b].contact,
            Dof::Node(n, axis) => self.nodes.velocity_now(n)[axis],
        }
    }

    /// Returns the acceleration; for a rigid body in contact, including that by contact over the previous increment.
    pub fn acceleration(&self, dof: Dof) -> f64 {
        match dof {
            Dof::Body(b) if self.bodies[b].contact == 0.0 => self.bodies[b].acceleration,
            Dof::Body(b) => self.bodies[b].acceleration + self.bodies[b].contact,
            Dof::Node(n, axis) => self.nodes.acceleration[n][axis],
        }
    }

    /// Returns the mass of the node or rigid body of a degree of freedom.
    pub fn mass(&self, dof: Dof) -> f64 {
        match dof {
            Dof::Body(b) => self.bodies[b].mass,
            Dof::Node(n, _) => self.nodes.mass[n],
        }
    }
}
