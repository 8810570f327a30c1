//! Gravity (`*DLOAD`, GRAV): a uniform acceleration along z, or in any direction on bodies with six degrees of freedom.

use super::{GeneralizedForce, Load, LoadForces, LoadOutput, LoadTargets, SceneChange, SceneView, TargetDissipation};
use crate::kernel::lists::{Memory, heap_bytes};
use crate::routines::LockedRoutines;
use crate::state::EffectId;
use crate::state::archive::Persist;
use crate::state::halt::HaltReason;
use crate::state::limit::IncrementLimit;
use crate::state::magnitude::Magnitude;

/// Gravity on a set of bodies and nodes.
#[derive(Clone, Debug, Persist)]
#[persist(fixed: nodes; derived: id, bodies, whole, acceleration, along_z)]
pub struct GravityLoad {
    pub id: EffectId,
    /// Generalised forces on bodies, with mass times the direction's component.
    pub bodies: Vec<(GeneralizedForce, f64)>,
    /// Nodes, with the part of their mass on which gravity acts.
    pub nodes: Vec<(usize, f64)>,
    /// Whether gravity acts on the full mass of the nodes; the masses are then updated when they change.
    pub whole: bool,
    pub acceleration: Magnitude,
    /// Component of the direction along z, -1 to 1.
    pub along_z: f64,
}

impl Load for GravityLoad {
    fn effect(&self) -> EffectId {
        self.id
    }

    fn targets(&self) -> LoadTargets {
        LoadTargets { bodies: self.bodies.iter().map(|body| body.0).collect(), nodes: !self.nodes.is_empty() }
    }

    fn apply(
        &mut self,
        scene: &SceneView<'_>,
        _: &mut LockedRoutines,
        forces: &mut LoadForces<'_>,
    ) -> Result<TargetDissipation, HaltReason> {
        let acceleration = self.acceleration.at(&scene.clock);
        match forces {
            LoadForces::OnNodes(forces) => {
                let along_z = acceleration * self.along_z;
                self.nodes.iter().for_each(|&(n, mass)| forces[n][1] += mass * along_z);
            }
            LoadForces::OnBodies(forces) => {
                for (force, (_, mass)) in forces.iter_mut().zip(&self.bodies) {
                    *force = mass * acceleration;
                }
            }
        }
        Ok(TargetDissipation::default())
    }

    fn max_increment(&self, scene: &SceneView<'_>) -> IncrementLimit {
        self.acceleration.limit(&scene.clock)
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
}

impl LoadOutput for GravityLoad {
    fn arrays(&self) -> Vec<(&'static str, usize)> {
        let masses = heap_bytes(&self.bodies);
        let masses = masses + heap_bytes(&self.nodes);
        vec![("masses", masses), ("amplitude", self.acceleration.bytes())]
    }
}
