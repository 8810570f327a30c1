//! Concentrated forces and moments (`*CLOAD`).

use super::prescribed::LoadDistribution;
use super::{EnergyAccount, GeneralizedForce, LoadTargets, SceneView};
use crate::kernel::lists::heap_bytes;
use crate::state::archive::Persist;
use crate::state::dofs::Dofs;
use crate::state::rigid_body_3d::Wrench;

/// A force or moment, the magnitude, on one degree of freedom of each listed body and node.
#[derive(Clone, Debug, Persist)]
#[persist(derived: bodies, spatial, nodes, dof)]
pub struct ConcentratedForces {
    /// Bodies that move along z only.
    pub bodies: Vec<usize>,
    /// Bodies with six degrees of freedom, with the z coordinate in the mesh of the ring on which the force acts.
    pub spatial: Vec<(usize, f64)>,
    pub nodes: Vec<usize>,
    /// Degree of freedom, from 0. Bodies: along 1, 2, 3, about 1, 2, 3. Nodes: 0 along r or rotation, 1 along z.
    pub dof: usize,
}

impl ConcentratedForces {
    /// Returns the force and moment on a body with six degrees of freedom, for a force at a height on its axis.
    fn wrench(&self, (body, height): (usize, f64), dofs: &Dofs, magnitude: f64) -> Wrench {
        let mut components = [0.0; 6];
        components[self.dof] = magnitude;
        let wrench = Wrench::of(components);
        match &dofs.bodies[body].spatial {
            Some(spatial) if self.dof < 3 => Wrench::at(spatial.arm([0.0, height], 0.0), wrench.force),
            _ => wrench,
        }
    }
}

impl LoadDistribution for ConcentratedForces {
    fn targets(&self) -> LoadTargets {
        let along_z = self.bodies.iter().map(|&body| GeneralizedForce::along_z(body, EnergyAccount::Work));
        let in_space = self.spatial.iter().flat_map(|&(body, _)| GeneralizedForce::in_space(body, EnergyAccount::Work));
        LoadTargets { bodies: along_z.chain(in_space).collect(), nodes: !self.nodes.is_empty() }
    }

    fn on_nodes(&mut self, magnitude: f64, _scene: &SceneView<'_>, forces: &mut [[f64; 2]]) {
        self.nodes.iter().for_each(|&n| forces[n][self.dof] += magnitude);
    }

    fn on_bodies(&mut self, magnitude: f64, scene: &SceneView<'_>, forces: &mut [f64]) {
        let (along_z, in_space) = forces.split_at_mut(self.bodies.len());
        along_z.fill(magnitude);
        for (out, &place) in in_space.chunks_exact_mut(6).zip(&self.spatial) {
            out.copy_from_slice(&self.wrench(place, scene.dofs, magnitude).components());
        }
    }

    fn arrays(&self) -> (&'static str, usize) {
        let places = size_of::<usize>() * (self.bodies.capacity() + self.nodes.capacity());
        ("places", places + heap_bytes(&self.spatial))
    }
}
