//! Gravity (`*DLOAD`, GRAV): a uniform acceleration along z, or in any direction on bodies with six degrees of freedom.

use super::prescribed::LoadDistribution;
use super::{GeneralizedForce, LoadTargets, SceneChange, SceneView};
use crate::kernel::lists::heap_bytes;
use crate::state::archive::Persist;

/// Gravity on a set of bodies and nodes; the magnitude is an acceleration.
#[derive(Clone, Debug, Persist)]
#[persist(fixed: nodes; derived: bodies, whole, along_z)]
pub struct GravityField {
    /// Generalised forces on bodies, with mass times the direction's component.
    pub bodies: Vec<(GeneralizedForce, f64)>,
    /// Nodes, with the part of their mass on which gravity acts.
    pub nodes: Vec<(usize, f64)>,
    /// Whether gravity acts on the full mass of the nodes; the masses are then updated when they change.
    pub whole: bool,
    /// Component of the direction along z, -1 to 1.
    pub along_z: f64,
}

impl LoadDistribution for GravityField {
    fn targets(&self) -> LoadTargets {
        LoadTargets { bodies: self.bodies.iter().map(|body| body.0).collect(), nodes: !self.nodes.is_empty() }
    }

    fn on_nodes(&mut self, magnitude: f64, _scene: &SceneView<'_>, forces: &mut [[f64; 2]]) {
        let along_z = magnitude * self.along_z;
        self.nodes.iter().for_each(|&(n, mass)| forces[n][1] += mass * along_z);
    }

    fn on_bodies(&mut self, magnitude: f64, _scene: &SceneView<'_>, forces: &mut [f64]) {
        for (force, (_, mass)) in forces.iter_mut().zip(&self.bodies) {
            *force = mass * magnitude;
        }
    }

    fn scene_changed(&mut self, change: &SceneChange<'_>) {
        let SceneChange::Masses(dofs) = change else { return };
        if self.whole {
            self.nodes.iter_mut().for_each(|m| m.1 = dofs.nodes.mass[m.0]);
        }
        for (force, weight) in &mut self.bodies {
            let body = &dofs.bodies[force.body];
            if !body.is_spatial() {
                *weight = body.mass * self.along_z;
            }
        }
    }

    fn arrays(&self) -> (&'static str, usize) {
        ("masses", heap_bytes(&self.bodies) + heap_bytes(&self.nodes))
    }
}
