//! A concentrated force or moment (`*CLOAD`).
//! Never here: distributed loads.

use super::{Account, Dissipation, Forces, GeneralizedForce, Load, LoadOutput, SceneView, Targets};
use crate::kernel::lists::heap_bytes;
use crate::state::EffectId;
use crate::state::archive::persist_struct;
use crate::state::dofs::Dofs;
use crate::state::halt::Halt;
use crate::state::limit::Limit;
use crate::state::magnitude::Magnitude;
use crate::state::rigid_body_3d::Wrench;
use crate::user::Locked;

/// The same force or moment along one degree of freedom of each of some bodies and nodes.
#[derive(Clone, Debug)]
pub struct Concentrated {
    pub id: EffectId,
    /// Bodies along z.
    pub bodies: Vec<usize>,
    /// Bodies in space, with the height in the mesh of the ring on which the force is spread.
    pub spatial: Vec<(usize, f64)>,
    pub nodes: Vec<usize>,
    /// The degree of freedom from 0: along 1, 2, 3, about 1, 2, 3; of nodes 0 along r or of a rotation, 1 along z.
    pub dof: usize,
    /// Force on each.
    pub magnitude: Magnitude,
}

impl Concentrated {
    /// The force on a body in space at a height on its axis.
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

impl Load for Concentrated {
    fn effect(&self) -> EffectId {
        self.id
    }

    fn targets(&self) -> Targets {
        let along_z = self.bodies.iter().map(|&body| GeneralizedForce::along_z(body, Account::Work));
        let in_space = self.spatial.iter().flat_map(|&(body, _)| GeneralizedForce::in_space(body, Account::Work));
        Targets { bodies: along_z.chain(in_space).collect(), nodes: !self.nodes.is_empty() }
    }

    fn apply(
        &mut self,
        scene: &SceneView<'_>,
        _: &mut Locked<'_>,
        forces: &mut Forces<'_>,
    ) -> Result<Dissipation, Halt> {
        let magnitude = self.magnitude.at(&scene.clock);
        match forces {
            Forces::OnNodes(forces) => self.nodes.iter().for_each(|&n| forces[n][self.dof] += magnitude),
            Forces::OnBodies(forces) => {
                let (along_z, in_space) = forces.split_at_mut(self.bodies.len());
                along_z.fill(magnitude);
                for (out, &place) in in_space.chunks_exact_mut(6).zip(&self.spatial) {
                    out.copy_from_slice(&self.wrench(place, scene.dofs, magnitude).components());
                }
            }
        }
        Ok(Dissipation::default())
    }

    fn max_increment(&self, scene: &SceneView<'_>) -> Limit {
        self.magnitude.limit(&scene.clock)
    }
}

impl LoadOutput for Concentrated {
    fn arrays(&self) -> Vec<(&'static str, usize)> {
        let places = size_of::<usize>() * (self.bodies.capacity() + self.nodes.capacity());
        let places = places + heap_bytes(&self.spatial);
        vec![("places", places), ("amplitude", self.magnitude.bytes())]
    }
}

persist_struct!(Concentrated {} derived { id, bodies, spatial, nodes, dof, magnitude });
