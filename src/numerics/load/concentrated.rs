//! Concentrated forces and moments (`*CLOAD`).

use super::{EnergyAccount, GeneralizedForce, Load, LoadForces, LoadOutput, LoadTargets, SceneView, TargetDissipation};
use crate::kernel::lists::{Memory, heap_bytes};
use crate::routines::LockedRoutines;
use crate::state::EffectId;
use crate::state::archive::Persist;
use crate::state::dofs::Dofs;
use crate::state::halt::HaltReason;
use crate::state::limit::IncrementLimit;
use crate::state::magnitude::Magnitude;
use crate::state::rigid_body_3d::Wrench;

/// A force or moment on one degree of freedom of each listed body and node.
#[derive(Clone, Debug, Persist)]
#[persist(derived: id, bodies, spatial, nodes, dof, magnitude)]
pub struct ConcentratedLoad {
    pub id: EffectId,
    /// Bodies that move along z only.
    pub bodies: Vec<usize>,
    /// Bodies with six degrees of freedom, with the z coordinate in the mesh of the ring on which the force acts.
    pub spatial: Vec<(usize, f64)>,
    pub nodes: Vec<usize>,
    /// Degree of freedom, from 0. Bodies: along 1, 2, 3, about 1, 2, 3. Nodes: 0 along r or rotation, 1 along z.
    pub dof: usize,
    /// Force or moment on each body and node.
    pub magnitude: Magnitude,
}

impl ConcentratedLoad {
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

impl Load for ConcentratedLoad {
    fn effect(&self) -> EffectId {
        self.id
    }

    fn targets(&self) -> LoadTargets {
        let along_z = self.bodies.iter().map(|&body| GeneralizedForce::along_z(body, EnergyAccount::Work));
        let in_space = self.spatial.iter().flat_map(|&(body, _)| GeneralizedForce::in_space(body, EnergyAccount::Work));
        LoadTargets { bodies: along_z.chain(in_space).collect(), nodes: !self.nodes.is_empty() }
    }

    fn apply(
        &mut self,
        scene: &SceneView<'_>,
        _: &mut LockedRoutines,
        forces: &mut LoadForces<'_>,
    ) -> Result<TargetDissipation, HaltReason> {
        let magnitude = self.magnitude.at(&scene.clock);
        match forces {
            LoadForces::OnNodes(forces) => self.nodes.iter().for_each(|&n| forces[n][self.dof] += magnitude),
            LoadForces::OnBodies(forces) => {
                let (along_z, in_space) = forces.split_at_mut(self.bodies.len());
                along_z.fill(magnitude);
                for (out, &place) in in_space.chunks_exact_mut(6).zip(&self.spatial) {
                    out.copy_from_slice(&self.wrench(place, scene.dofs, magnitude).components());
                }
            }
        }
        Ok(TargetDissipation::default())
    }

    fn max_increment(&self, scene: &SceneView<'_>) -> IncrementLimit {
        self.magnitude.limit(&scene.clock)
    }
}

impl LoadOutput for ConcentratedLoad {
    fn arrays(&self) -> Vec<(&'static str, usize)> {
        let places = size_of::<usize>() * (self.bodies.capacity() + self.nodes.capacity());
        let places = places + heap_bytes(&self.spatial);
        vec![("places", places), ("amplitude", self.magnitude.bytes())]
    }
}
