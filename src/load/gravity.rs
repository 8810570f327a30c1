//! A uniform acceleration of mass (`*DLOAD`, GRAV): along z, on bodies in space in any direction.
//! Never here: forces that do not scale with mass.

use super::{Dissipation, Forces, GeneralizedForce, Load, LoadOutput, SceneChange, SceneView, Targets};
use crate::kernel::lists::heap_bytes;
use crate::state::EffectId;
use crate::state::archive::persist_struct;
use crate::state::halt::Halt;
use crate::state::limit::Limit;
use crate::state::magnitude::Magnitude;
use crate::user::Locked;

/// Gravity on some bodies and nodes.
#[derive(Clone, Debug)]
pub struct Gravity {
    pub id: EffectId,
    /// Generalised forces on bodies, with mass times the component of the direction.
    pub bodies: Vec<(GeneralizedForce, f64)>,
    /// `(node, mass it acts on)`.
    pub nodes: Vec<(usize, f64)>,
    /// Whether it acts on all of the nodes' mass, whatever that becomes.
    pub whole: bool,
    pub acceleration: Magnitude,
    /// Component of the direction along z.
    pub along_z: f64,
}

impl Load for Gravity {
    fn effect(&self) -> EffectId {
        self.id
    }

    fn targets(&self) -> Targets {
        Targets { bodies: self.bodies.iter().map(|body| body.0).collect(), nodes: !self.nodes.is_empty() }
    }

    fn apply(
        &mut self,
        scene: &SceneView<'_>,
        _: &mut Locked<'_>,
        forces: &mut Forces<'_>,
    ) -> Result<Dissipation, Halt> {
        let acceleration = self.acceleration.at(&scene.clock);
        match forces {
            Forces::OnNodes(forces) => {
                let along_z = acceleration * self.along_z;
                self.nodes.iter().for_each(|&(n, mass)| forces[n][1] += mass * along_z);
            }
            Forces::OnBodies(forces) => {
                for (force, (_, mass)) in forces.iter_mut().zip(&self.bodies) {
                    *force = mass * acceleration;
                }
            }
        }
        Ok(Dissipation::default())
    }

    fn max_increment(&self, scene: &SceneView<'_>) -> Limit {
        self.acceleration.limit(&scene.clock)
    }

    fn scene_changed(&mut self, change: &SceneChange<'_>) {
        if let SceneChange::Masses(mass) = change
            && self.whole
        {
            self.nodes.iter_mut().for_each(|m| m.1 = mass[m.0]);
        }
    }
}

impl LoadOutput for Gravity {
    fn arrays(&self) -> Vec<(&'static str, usize)> {
        let masses = heap_bytes(&self.bodies);
        let masses = masses + heap_bytes(&self.nodes);
        vec![("masses", masses), ("amplitude", self.acceleration.bytes())]
    }
}

persist_struct!(Gravity { nodes: fixed } derived { id, bodies, whole, acceleration, along_z });
