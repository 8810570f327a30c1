//! Resistance of a target that is not meshed (`CAVITY`): dynamic cavity expansion in layers, with Coulomb friction.
//! Facets are clipped by area at the faces of the target and between layers; only facets that move into the material
//! are loaded. Finite targets are in `finite`, tunnels opened by the body in `shadow` and `tunnel`, the law itself in
//! `kernel::cavity`.

mod arcs;
mod face_motion;
mod finite;
mod nose;
mod oblique;
mod plug;
mod profile;
mod rings;
mod shadow;
mod skin;
mod stack;
mod stages;
mod station_blocks;
mod tunnel;

use std::any::Any;

use super::{
    EnergyAccount, GeneralizedForce, Load, LoadForces, LoadOutput, LoadTargets, PenetrationRecord, SceneChange,
    SceneView, TargetDissipation, VelocityUse,
};
use crate::kernel::lists::{Memory, heap_bytes};
use crate::load::fields::FacetFields;
use crate::mesh::surface::{RigidFacets, SurfaceGeometry};
use crate::routines::LockedRoutines;
use crate::state::EffectId;
use crate::state::archive::Persist;
use crate::state::dofs::Dofs;
use crate::state::halt::{HaltDetails, HaltReason};
use crate::state::limit::IncrementLimit;
use crate::state::nodes::Nodes;
use crate::state::rigid_body_3d::RigidBody3d;
pub use finite::{EntryCrater, LayerBounds, StackBounds};
use nose::NoseResistance;
use oblique::ObliqueResistance;
pub use oblique::StackTilt;
use skin::SkinResistance;
pub use stack::LayerStack;
pub use stages::{AxialResistance, ResistanceConstants, force_stage_slopes, force_stages};

/// Resistance of one stack of layers on a surface.
#[derive(Clone, Debug, Persist)]
#[persist(fixed: noses, oblique; derived: id, friction, stack)]
pub struct CavityExpansion {
    id: EffectId,
    friction: f64,
    stack: LayerStack,
    noses: Vec<NoseResistance>,
    /// Rigid bodies with six degrees of freedom.
    oblique: Vec<ObliqueResistance>,
    skin: SkinResistance,
}

impl CavityExpansion {
    /// Creates the resistance of `stack` on a surface with a Coulomb coefficient. `travel` is the fraction of the nose
    /// height that the body may travel in one increment while a plane of the stack intersects the nose.
    pub fn new(id: EffectId, friction: f64, stack: LayerStack, surface: SurfaceGeometry, travel: f64) -> Self {
        let noses = surface.patches.iter().map(|patch| NoseResistance::new(patch, &stack, travel)).collect();
        CavityExpansion { id, friction, stack, noses, oblique: Vec::new(), skin: SkinResistance::new(surface.skin) }
    }

    /// Adds a patch of a rigid body with six degrees of freedom; the planes are inclined, and the layers follow each
    /// other along `direction`.
    #[must_use]
    pub fn with_oblique(
        mut self,
        patch: &RigidFacets,
        body: &RigidBody3d,
        (tilt, direction): (StackTilt, f64),
        travel: f64,
    ) -> Self {
        let material = (self.friction, travel);
        self.oblique.push(ObliqueResistance::new(patch, body, &self.stack, (tilt, direction), material));
        self
    }

    /// Ignores faces inside the tunnel that the body has already opened; `nodes` are the initial positions.
    pub fn separating(mut self, nodes: &Nodes) -> Self {
        self.noses.iter_mut().for_each(NoseResistance::ignore_opened_tunnel);
        self.skin.ignore_opened_tunnel(nodes);
        self
    }

    /// Returns the resistances on rigid bodies that move along z; `None` if there are others, or if the layers are
    /// bounded.
    pub fn axial_resistances(&self) -> Option<impl Iterator<Item = AxialResistance<'_>>> {
        let is_axial = self.skin.is_empty() && self.oblique.is_empty() && self.stack.bounds.is_none();
        let of_nose = |nose| AxialResistance { nose, stack: &self.stack, friction: self.friction };
        is_axial.then(|| self.noses.iter().map(of_nose))
    }

    fn forces_of_a_body(&self) -> usize {
        if self.friction > 0.0 { 2 } else { 1 }
    }

    fn on_nodes(&mut self, scene: &SceneView<'_>, forces: &mut [[f64; 2]]) -> Result<TargetDissipation, HaltReason> {
        if self.skin.is_empty() {
            return Ok(TargetDissipation::default());
        }
        let refused = self.skin.resist(&self.stack, self.friction, scene, forces);
        refused.map_err(|speed| not_finite(scene, speed))?;
        Ok(self.skin.dissipated(scene.dofs))
    }

    #[inline]
    fn on_bodies(&mut self, scene: &SceneView<'_>, out: &mut [f64]) -> Result<(), HaltReason> {
        let mut written = 0;
        for nose in &mut self.noses {
            let body = &scene.dofs.bodies[nose.body];
            let Some([normal, tangential]) = nose.resist(&self.stack, body) else {
                return Err(not_finite(scene, body.velocity_load.abs()));
            };
            out[written] = normal;
            written += 1;
            if self.friction > 0.0 {
                out[written] = self.friction * tangential;
                written += 1;
            }
        }
        if self.oblique.is_empty() { Ok(()) } else { self.on_oblique_bodies(scene, &mut out[written..]) }
    }

    #[inline(never)]
    fn on_oblique_bodies(&mut self, scene: &SceneView<'_>, in_space: &mut [f64]) -> Result<(), HaltReason> {
        let each = self.forces_of_a_body();
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

    fn targets(&self) -> LoadTargets {
        let each = self.forces_of_a_body();
        let accounts = &[EnergyAccount::Cavity, EnergyAccount::Friction][..each];
        let along_z = |nose: &NoseResistance| {
            let body = nose.body;
            accounts.iter().map(move |&account| GeneralizedForce::along_z(body, account))
        };
        // Friction first, as `on_bodies` writes the forces: the order of summation determines the last bits.
        let accounts = &[EnergyAccount::Friction, EnergyAccount::Cavity][2 - each..];
        let in_space = |oblique: &ObliqueResistance| {
            let body = oblique.body;
            accounts.iter().flat_map(move |&account| GeneralizedForce::in_space(body, account))
        };
        let bodies = self.noses.iter().flat_map(along_z).chain(self.oblique.iter().flat_map(in_space)).collect();
        LoadTargets { bodies, nodes: !self.skin.is_empty() }
    }

    fn velocity_use(&self) -> VelocityUse {
        VelocityUse::Resists
    }

    #[inline]
    fn apply(
        &mut self,
        scene: &SceneView<'_>,
        _: &mut LockedRoutines,
        forces: &mut LoadForces<'_>,
    ) -> Result<TargetDissipation, HaltReason> {
        match forces {
            LoadForces::OnNodes(forces) => self.on_nodes(scene, forces),
            LoadForces::OnBodies(forces) => self.on_bodies(scene, forces).map(|()| TargetDissipation::default()),
        }
    }

    fn max_increment(&self, scene: &SceneView<'_>) -> IncrementLimit {
        let bodies = &scene.dofs.bodies;
        let mut limit = self.skin.limit(&self.stack, &scene.dofs.nodes);
        for nose in &self.noses {
            limit = limit.earlier(nose.limit(&self.stack, &bodies[nose.body]));
        }
        for oblique in &self.oblique {
            limit = limit.earlier(oblique.limit(&self.stack, &bodies[oblique.body]));
        }
        limit
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

    fn penetrations(&self, dofs: &Dofs) -> Vec<PenetrationRecord> {
        let of_nose = |nose: &NoseResistance| nose.penetration(&self.stack, &dofs.bodies[nose.body]);
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
        let noses = self.noses.iter().map(NoseResistance::bytes).sum::<usize>() + heap_bytes(&self.noses);
        let oblique = self.oblique.iter().map(ObliqueResistance::bytes).sum::<usize>() + heap_bytes(&self.oblique);
        vec![("facets", noses + self.skin.bytes()), ("rings", oblique), ("layers", self.stack.bytes())]
    }
}

#[cold]
fn not_finite(scene: &SceneView<'_>, speed: f64) -> HaltReason {
    let time = scene.clock.now.total_time;
    let message = format!("the target resistance is not finite at total time {time:e} and speed {speed:e}");
    HaltReason::ResistanceNotFinite(HaltDetails::new(message))
}
