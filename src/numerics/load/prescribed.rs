//! Loads whose magnitude is a given function of time: the magnitude, and its distribution over nodes and bodies.

use std::any::Any;

use super::fields::FacetFields;
use super::{Load, LoadForces, LoadOutput, LoadTargets, SceneChange, SceneView, TargetDissipation, VelocityUse};
use crate::kernel::lists::Memory;
use crate::routines::LockedRoutines;
use crate::state::EffectId;
use crate::state::archive::Persist;
use crate::state::dofs::Dofs;
use crate::state::halt::HaltReason;
use crate::state::limit::IncrementLimit;
use crate::state::magnitude::Magnitude;

/// Distribution of a load over nodes and rigid bodies. Its methods have the same meaning as the methods of [`Load`] and
/// [`LoadOutput`] with the same names.
pub trait LoadDistribution: Any + Clone + Persist + Send + Sync {
    fn targets(&self) -> LoadTargets;

    fn velocity_use(&self) -> VelocityUse {
        VelocityUse::None
    }

    /// Adds the forces of a magnitude on nodes, `[r, z]`.
    fn on_nodes(&mut self, magnitude: f64, scene: &SceneView<'_>, forces: &mut [[f64; 2]]);

    /// Sets the generalised forces of a magnitude on rigid bodies, in the order of the targets.
    fn on_bodies(&mut self, _magnitude: f64, _scene: &SceneView<'_>, _forces: &mut [f64]) {}

    fn scene_changed(&mut self, _change: &SceneChange<'_>) {}

    /// Returns name and size (bytes) of the arrays.
    fn arrays(&self) -> (&'static str, usize);

    fn fields(&self, _dofs: &Dofs) -> Option<FacetFields> {
        None
    }

    fn damping(&self) -> f64 {
        0.0
    }
}

/// A load with a magnitude over time.
#[derive(Clone, Debug, Persist)]
#[persist(derived: id, magnitude)]
pub struct PrescribedLoad<D: LoadDistribution> {
    pub id: EffectId,
    pub magnitude: Magnitude,
    pub distribution: D,
}

impl<D: LoadDistribution> Load for PrescribedLoad<D> {
    fn effect(&self) -> EffectId {
        self.id
    }

    fn targets(&self) -> LoadTargets {
        self.distribution.targets()
    }

    fn velocity_use(&self) -> VelocityUse {
        self.distribution.velocity_use()
    }

    fn apply(
        &mut self,
        scene: &SceneView<'_>,
        _: &mut LockedRoutines,
        forces: &mut LoadForces<'_>,
    ) -> Result<TargetDissipation, HaltReason> {
        let magnitude = self.magnitude.at(&scene.clock);
        match forces {
            LoadForces::OnNodes(forces) => self.distribution.on_nodes(magnitude, scene, forces),
            LoadForces::OnBodies(forces) => self.distribution.on_bodies(magnitude, scene, forces),
        }
        Ok(TargetDissipation::default())
    }

    fn max_increment(&self, scene: &SceneView<'_>) -> IncrementLimit {
        self.magnitude.limit(&scene.clock)
    }

    fn scene_changed(&mut self, change: &SceneChange<'_>) {
        self.distribution.scene_changed(change);
    }
}

impl<D: LoadDistribution> LoadOutput for PrescribedLoad<D> {
    fn arrays(&self) -> Vec<(&'static str, usize)> {
        vec![self.distribution.arrays(), ("amplitude", self.magnitude.bytes())]
    }

    fn fields(&self, dofs: &Dofs) -> Option<FacetFields> {
        self.distribution.fields(dofs)
    }

    fn damping(&self) -> f64 {
        self.distribution.damping()
    }
}
