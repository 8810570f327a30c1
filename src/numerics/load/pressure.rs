//! Prescribed pressure on a surface (`P`).

use super::prescribed::LoadDistribution;
use super::{EnergyAccount, GeneralizedForce, LoadTargets, SceneChange, SceneView};
use crate::kernel::attitude::times;
use crate::kernel::facet::{Facet, ring_pressure, section_pressure, shell_pressure};
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::Memory;
use crate::load::fields::FacetFields;
use crate::mesh::surface::{CurrentFace, SurfaceGeometry};
use crate::state::archive::Persist;
use crate::state::dofs::Dofs;

/// A uniform pressure, positive against the outward normal. On a rigid body the resultant acts along the axis, so only
/// the sum of the facets' axial areas is needed.
#[derive(Clone, Debug, Persist)]
#[persist(derived: axial_areas)]
pub struct PressureField {
    surface: SurfaceGeometry,
    /// Sum of area times n_z of each patch, and whether its body has six degrees of freedom.
    axial_areas: Vec<(f64, bool)>,
    /// Pressure at the last evaluation, for frame output.
    current: f64,
}

impl PressureField {
    pub fn new(surface: SurfaceGeometry, dofs: &Dofs) -> Self {
        let axial = |facets: &[(usize, Facet)]| facets.iter().map(|(_, f)| f.area * f.normal[1]).sum();
        let patches = surface.patches.iter();
        let axial_areas = patches.map(|p| (axial(&p.facets), dofs.bodies[p.body].is_spatial())).collect();
        PressureField { surface, axial_areas, current: 0.0 }
    }
}

impl LoadDistribution for PressureField {
    fn targets(&self) -> LoadTargets {
        let mut bodies = Vec::new();
        for (patch, &(_, in_space)) in self.surface.patches.iter().zip(&self.axial_areas) {
            match in_space {
                true => bodies.extend(GeneralizedForce::in_space(patch.body, EnergyAccount::Work).take(3)),
                false => bodies.push(GeneralizedForce::along_z(patch.body, EnergyAccount::Work)),
            }
        }
        LoadTargets { bodies, nodes: self.surface.skin.max_faces() > 0 }
    }

    fn on_nodes(&mut self, magnitude: f64, scene: &SceneView<'_>, forces: &mut [[f64; 2]]) {
        self.current = magnitude;
        for (face, shell) in self.surface.skin.active_faces_with_shells() {
            add_pressure(&CurrentFace::new(face, &scene.dofs.nodes), shell, magnitude, scene.rings, forces);
        }
    }

    fn on_bodies(&mut self, magnitude: f64, scene: &SceneView<'_>, mut forces: &mut [f64]) {
        self.current = magnitude;
        for (patch, &(area, in_space)) in self.surface.patches.iter().zip(&self.axial_areas) {
            let (of_patch, others) = forces.split_at_mut(if in_space { 3 } else { 1 });
            let force = -magnitude * area;
            match &scene.dofs.bodies[patch.body].spatial {
                None => of_patch[0] = force,
                Some(body) => of_patch.copy_from_slice(&times(force, body.attitude.axis())),
            }
            forces = others;
        }
    }

    fn scene_changed(&mut self, change: &SceneChange<'_>) {
        change.remove_faces(&mut self.surface);
    }

    fn fields(&self, dofs: &Dofs) -> Option<FacetFields> {
        Some(FacetFields::uniform(&self.surface, self.current, dofs))
    }

    fn arrays(&self) -> (&'static str, usize) {
        ("surface", self.surface.bytes())
    }
}

/// Adds the nodal forces of a pressure on a face of a solid or shell.
#[inline]
pub(super) fn add_pressure(
    face: &CurrentFace,
    shell: bool,
    pressure: f64,
    rings: Option<&[f64]>,
    forces: &mut [[f64; 2]],
) {
    for (node, force) in face.nodes.into_iter().zip(face_forces(face, shell, pressure, rings)) {
        forces[node] = [forces[node][0] + force[0], forces[node][1] + force[1]];
    }
}

/// Returns the nodal forces of a pressure on a face of a solid or shell.
#[inline]
pub(super) fn face_forces(face: &CurrentFace, shell: bool, pressure: f64, rings: Option<&[f64]>) -> [[f64; 2]; 2] {
    if shell { shell_pressure(face.ends, pressure) } else { solid_face_forces(face, pressure, rings) }
}

/// Returns the nodal forces of a pressure on a face of a solid. With area weighting, `rings` holds the factors from the
/// plane section to the rings of the nodes.
#[inline]
pub(super) fn solid_face_forces(face: &CurrentFace, pressure: f64, rings: Option<&[f64]>) -> [[f64; 2]; 2] {
    let Some(rings) = rings else { return ring_pressure(face.ends, pressure) };
    let half = section_pressure(face.ends, pressure);
    face.nodes.inline_map(|node| half.inline_map(|f| rings[node] * f))
}
