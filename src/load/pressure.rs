//! A prescribed pressure on a surface (`P`).
//! Never here: pressures that depend on motion.

use super::{Account, Dissipation, Forces, GeneralizedForce, Load, LoadOutput, SceneChange, SceneView, Targets};
use crate::kernel::attitude::times;
use crate::kernel::facet::{ring_pressure, section_pressure, shell_pressure};
use crate::kernel::lanes::InlineMap;
use crate::load::fields::FacetFields;
use crate::mesh::surface::{Face, Surface};
use crate::state::EffectId;
use crate::state::archive::{Archive, Persist, persist_fields};
use crate::state::dofs::Dofs;
use crate::state::halt::Halt;
use crate::state::limit::Limit;
use crate::state::magnitude::Magnitude;
use crate::user::Locked;

/// A pressure; positive pushes against the outward normal. On a rigid body its resultant lies on the axis: the facets enter by the sum
/// of their axial areas alone, in space as along z.
#[derive(Clone, Debug)]
pub struct Pressure {
    id: EffectId,
    surface: Surface,
    /// Of each patch, the sum of area times n_z, and whether its body moves in space.
    axial_areas: Vec<(f64, bool)>,
    magnitude: Magnitude,
    /// Pressure at the last evaluation, for frames.
    current: f64,
}

impl Pressure {
    pub fn new(id: EffectId, surface: Surface, magnitude: Magnitude, dofs: &Dofs) -> Self {
        let axial =
            |facets: &[(usize, crate::kernel::facet::Facet)]| facets.iter().map(|(_, f)| f.area * f.normal[1]).sum();
        let patches = surface.patches.iter();
        let axial_areas = patches.map(|p| (axial(&p.facets), dofs.bodies[p.body].is_spatial())).collect();
        Pressure { id, surface, axial_areas, magnitude, current: 0.0 }
    }

    fn on_bodies(&self, dofs: &Dofs, mut forces: &mut [f64]) {
        for (patch, &(area, in_space)) in self.surface.patches.iter().zip(&self.axial_areas) {
            let (own, others) = forces.split_at_mut(if in_space { 3 } else { 1 });
            let force = -self.current * area;
            match &dofs.bodies[patch.body].spatial {
                None => own[0] = force,
                Some(body) => own.copy_from_slice(&times(force, body.attitude.axis())),
            }
            forces = others;
        }
    }
}

impl Load for Pressure {
    fn effect(&self) -> EffectId {
        self.id
    }

    fn targets(&self) -> Targets {
        let mut bodies = Vec::new();
        for (patch, &(_, in_space)) in self.surface.patches.iter().zip(&self.axial_areas) {
            match in_space {
                true => bodies.extend(GeneralizedForce::in_space(patch.body, Account::Work).take(3)),
                false => bodies.push(GeneralizedForce::along_z(patch.body, Account::Work)),
            }
        }
        Targets { bodies, nodes: self.surface.skin.most() > 0 }
    }

    fn apply(
        &mut self,
        scene: &SceneView<'_>,
        _: &mut Locked<'_>,
        forces: &mut Forces<'_>,
    ) -> Result<Dissipation, Halt> {
        self.current = self.magnitude.at(&scene.clock);
        match forces {
            Forces::OnNodes(forces) => {
                for (face, shell) in self.surface.skin.carrying_shells() {
                    push(&Face::new(face, &scene.dofs.nodes), shell, self.current, scene.rings, forces);
                }
            }
            Forces::OnBodies(forces) => self.on_bodies(scene.dofs, forces),
        }
        Ok(Dissipation::default())
    }

    fn max_increment(&self, scene: &SceneView<'_>) -> Limit {
        self.magnitude.limit(&scene.clock)
    }

    fn scene_changed(&mut self, change: &SceneChange<'_>) {
        if let SceneChange::DeletedElements(deleted) = change {
            self.surface.skin.release(deleted);
        }
    }
}

impl LoadOutput for Pressure {
    fn fields(&self, dofs: &Dofs) -> Option<FacetFields> {
        Some(FacetFields::uniform(&self.surface, self.current, dofs))
    }

    fn arrays(&self) -> Vec<(&'static str, usize)> {
        vec![("surface", self.surface.bytes()), ("amplitude", self.magnitude.bytes())]
    }
}

/// Adds a pressure on a face of a solid or of a shell.
#[inline]
pub(super) fn push(face: &Face, shell: bool, pressure: f64, rings: Option<&[f64]>, forces: &mut [[f64; 2]]) {
    for (node, force) in face.nodes.into_iter().zip(on_ends(face, shell, pressure, rings)) {
        forces[node] = [forces[node][0] + force[0], forces[node][1] + force[1]];
    }
}

/// Forces of a pressure on the nodes of a face of a solid or of a shell.
#[inline]
pub(super) fn on_ends(face: &Face, shell: bool, pressure: f64, rings: Option<&[f64]>) -> [[f64; 2]; 2] {
    if shell { shell_pressure(face.ends, pressure) } else { on_solid(face, pressure, rings) }
}

/// Forces of a pressure on the nodes of a face of a solid. Of one weighted by area, `rings` brings what acts on the plane
/// section to the rings of its nodes.
#[inline]
pub(super) fn on_solid(face: &Face, pressure: f64, rings: Option<&[f64]>) -> [[f64; 2]; 2] {
    let Some(rings) = rings else { return ring_pressure(face.ends, pressure) };
    let half = section_pressure(face.ends, pressure);
    face.nodes.inline_map(|node| half.inline_map(|f| rings[node] * f))
}

impl Persist for Pressure {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Pressure { id: _, surface, axial_areas: _, magnitude: _, current } = self;
        persist_fields!(archive; &mut surface.skin, current);
    }
}
