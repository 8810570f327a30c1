//! Resistance of a target that is not meshed (`CAVITY`): dynamic cavity expansion in layers, with Coulomb friction.
//! Facets are clipped by area at the target's faces and between layers; only those that move into the material are loaded.
//! What bounds the target is in `finite`, what a body ahead has opened already in `shadow` and `tunnel`.
//! Never here: the law itself (`kernel::cavity`), deck words.

mod finite;
mod nose;
mod oblique;
mod plug;
mod rings;
mod shadow;
mod skin;
mod stack;
mod tunnel;

use std::any::Any;

use super::{
    Account, Dissipation, Forces, GeneralizedForce, Load, LoadOutput, Penetration, SceneChange, SceneView, Targets,
    VelocityUse,
};
use crate::kernel::lists::heap_bytes;
use crate::load::fields::FacetFields;
use crate::mesh::surface::{Patch, Surface};
use crate::state::EffectId;
use crate::state::archive::persist_struct;
use crate::state::dofs::Dofs;
use crate::state::halt::Halt;
use crate::state::limit::Limit;
use crate::state::nodes::Nodes;
use crate::state::rigid_body_3d::RigidBody3d;
use crate::user::Locked;
pub use finite::{Bounds, Crater, Finite};
use nose::Nose;
use oblique::Oblique;
pub use oblique::Tilt;
use skin::Resisted;
pub use stack::Stack;

/// The resistance of one stack on a surface.
#[derive(Clone, Debug)]
pub struct CavityExpansion {
    id: EffectId,
    friction: f64,
    stack: Stack,
    noses: Vec<Nose>,
    /// Bodies in space.
    oblique: Vec<Oblique>,
    skin: Resisted,
}

impl CavityExpansion {
    /// The resistance of `stack` on a surface with a Coulomb coefficient. `travel` is the fraction of a nose's height that one
    /// increment may move while a plane of the stack cuts it.
    pub fn new(id: EffectId, friction: f64, stack: Stack, surface: Surface, travel: f64) -> Self {
        let noses = surface.patches.iter().map(|patch| Nose::new(patch, &stack, travel)).collect();
        CavityExpansion { id, friction, stack, noses, oblique: Vec::new(), skin: Resisted::new(surface.skin) }
    }

    /// The same on a patch of a body in space, with the planes tilted; layers follow each other along `direction`.
    #[must_use]
    pub fn with_oblique(
        mut self,
        patch: &Patch,
        body: &RigidBody3d,
        (tilt, direction): (Tilt, f64),
        travel: f64,
    ) -> Self {
        self.oblique.push(Oblique::new(patch, body, (tilt, direction), (self.friction, travel)));
        self
    }

    /// The same where nothing acts inside the tunnel that has been opened already; `nodes` are those at the start.
    pub fn separating(mut self, nodes: &Nodes) -> Self {
        self.noses.iter_mut().for_each(Nose::separate);
        self.skin.separate(nodes);
        self
    }

    fn forces_of_a_body(&self) -> usize {
        if self.friction > 0.0 { 2 } else { 1 }
    }

    fn on_nodes(&mut self, scene: &SceneView<'_>, forces: &mut [[f64; 2]]) -> Result<Dissipation, Halt> {
        if self.skin.is_empty() {
            return Ok(Dissipation::default());
        }
        let refused = self.skin.resist(&self.stack, self.friction, scene, forces);
        refused.map_err(|speed| not_finite(scene, speed))?;
        Ok(self.skin.dissipated(scene.dofs))
    }

    #[inline]
    fn on_bodies(&mut self, scene: &SceneView<'_>, out: &mut [f64]) -> Result<(), Halt> {
        let each = self.forces_of_a_body();
        let (along_z, in_space) = out.split_at_mut(each * self.noses.len());
        for (nose, out) in self.noses.iter_mut().zip(along_z.chunks_exact_mut(each)) {
            let body = &scene.dofs.bodies[nose.body];
            let Some([normal, tangential]) = nose.resist(&self.stack, body) else {
                return Err(not_finite(scene, body.velocity_load.abs()));
            };
            out[0] = normal;
            if let Some(friction) = out.get_mut(1) {
                *friction = self.friction * tangential;
            }
        }
        for (oblique, out) in self.oblique.iter_mut().zip(in_space.chunks_exact_mut(6 * each)) {
            let body = &scene.dofs.bodies[oblique.body];
            let wrenches = oblique.resist(&self.stack, body, scene.clock.now.total_time);
            let [friction, pressure] = wrenches.ok_or_else(|| not_finite(scene, body.speed()))?;
            let (rubbed, pressed) = out.split_at_mut(6 * (each - 1));
            pressed.copy_from_slice(&pressure.components());
            if !rubbed.is_empty() {
                rubbed.copy_from_slice(&friction.components());
            }
        }
        Ok(())
    }
}

impl Load for CavityExpansion {
    fn effect(&self) -> EffectId {
        self.id
    }

    fn targets(&self) -> Targets {
        let each = self.forces_of_a_body();
        let accounts = &[Account::Cavity, Account::Friction][..each];
        let along_z = |nose: &Nose| {
            let body = nose.body;
            accounts.iter().map(move |&account| GeneralizedForce::along_z(body, account))
        };
        // Friction first: the order of sums.
        let accounts = &[Account::Friction, Account::Cavity][2 - each..];
        let in_space = |oblique: &Oblique| {
            let body = oblique.body;
            accounts.iter().flat_map(move |&account| GeneralizedForce::in_space(body, account))
        };
        let bodies = self.noses.iter().flat_map(along_z).chain(self.oblique.iter().flat_map(in_space)).collect();
        Targets { bodies, nodes: !self.skin.is_empty() }
    }

    fn velocity_use(&self) -> VelocityUse {
        VelocityUse::Resists
    }

    #[inline]
    fn apply(
        &mut self,
        scene: &SceneView<'_>,
        _: &mut Locked<'_>,
        forces: &mut Forces<'_>,
    ) -> Result<Dissipation, Halt> {
        match forces {
            Forces::OnNodes(forces) => self.on_nodes(scene, forces),
            Forces::OnBodies(forces) => self.on_bodies(scene, forces).map(|()| Dissipation::default()),
        }
    }

    fn max_increment(&self, scene: &SceneView<'_>) -> Limit {
        let bodies = &scene.dofs.bodies;
        let noses = self.noses.iter().map(|nose| nose.limit(&self.stack, &bodies[nose.body]));
        let oblique = self.oblique.iter().map(|oblique| oblique.limit(&self.stack, &bodies[oblique.body]));
        noses.chain(oblique).fold(self.skin.limit(&self.stack, &scene.dofs.nodes), Limit::nearer)
    }

    fn scene_changed(&mut self, change: &SceneChange<'_>) {
        if let SceneChange::DeletedElements(deleted) = change {
            self.skin.remove_elements(deleted);
        }
    }
}

impl LoadOutput for CavityExpansion {
    fn continue_from(&mut self, previous: &dyn Load) {
        let Some(previous) = (previous as &dyn Any).downcast_ref::<CavityExpansion>() else { return };
        for oblique in &mut self.oblique {
            previous.oblique.iter().for_each(|known| oblique.continue_from(known));
        }
        self.skin.continue_from(&previous.skin);
    }

    fn penetrations(&self, dofs: &Dofs) -> Vec<Penetration> {
        let of_nose = |nose: &Nose| nose.penetration(&self.stack, &dofs.bodies[nose.body]);
        let noses = self.noses.iter().filter_map(of_nose);
        noses.chain(self.oblique.iter().filter_map(|o| o.penetration(&dofs.bodies[o.body]))).collect()
    }

    fn fields(&self, dofs: &Dofs) -> Option<FacetFields> {
        let mut fields = FacetFields::default();
        self.noses.iter().for_each(|nose| nose.show(&self.stack, &dofs.bodies[nose.body], &mut fields));
        self.oblique.iter().for_each(|oblique| oblique.show(&self.stack, &dofs.bodies[oblique.body], &mut fields));
        self.skin.show(&self.stack, &dofs.nodes, &mut fields);
        Some(fields)
    }

    fn arrays(&self) -> Vec<(&'static str, usize)> {
        let noses = self.noses.iter().map(Nose::bytes).sum::<usize>() + heap_bytes(&self.noses);
        let oblique = self.oblique.iter().map(Oblique::bytes).sum::<usize>() + heap_bytes(&self.oblique);
        vec![("facets", noses + self.skin.bytes()), ("rings", oblique), ("layers", self.stack.bytes())]
    }
}

#[cold]
fn not_finite(scene: &SceneView<'_>, speed: f64) -> Halt {
    let time = scene.clock.now.total_time;
    Halt { code: "R202", reason: format!("the resistance is not finite at time {time:e}, speed {speed:e}") }
}

persist_struct!(CavityExpansion { noses: fixed, skin, oblique: fixed } derived { id, friction, stack });
