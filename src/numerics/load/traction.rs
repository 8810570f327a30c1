//! Tractions on a surface that are no pressures: in a direction (`TRVEC`), along the surface (`TRSHR`), viscous
//! pressure against the normal velocity (`VP`), and those of infinite elements, which absorb waves; ABAQUS Analysis User's Guide 34.4.3, "Surface tractions" and "Viscous
//! pressure loads".

use super::prescribed::LoadDistribution;
use super::{LoadTargets, SceneChange, SceneView, VelocityUse};
use crate::kernel::facet::{Facet, ring_areas, section_areas, shell_areas};
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::Memory;
use crate::mesh::surface::{CurrentFace, SurfaceGeometry};
use crate::platform::PortableMath as _;
use crate::state::archive::Persist;
use crate::state::dofs::Dofs;
use crate::state::nodes::Nodes;

/// Direction and law of a traction; directions are unit vectors `[r, z]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TractionLaw {
    /// In a fixed direction.
    Fixed([f64; 2]),
    /// In a direction that rotates with each face.
    Following([f64; 2]),
    /// Along the surface, in the direction nearest to the initial one.
    Shear([f64; 2]),
    /// Against the normal velocity, which is relative to a rigid body or a node. The magnitude is pressure per velocity.
    Viscous(ReferenceMotion),
    /// Against the velocity, which absorbs waves. The magnitude is traction per normal velocity; `shear_ratio` times it
    /// that per velocity along the face.
    Absorbing { shear_ratio: f64 },
}

/// Motion to which a viscous pressure refers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReferenceMotion {
    AtRest,
    Body(usize),
    Node(usize),
}

impl ReferenceMotion {
    fn velocity(self, dofs: &Dofs) -> [f64; 2] {
        match self {
            ReferenceMotion::AtRest => [0.0; 2],
            ReferenceMotion::Body(body) => [0.0, dofs.bodies[body].velocity],
            ReferenceMotion::Node(node) => [dofs.nodes[node].v_r, dofs.nodes[node].v_z],
        }
    }
}

/// Returns the initial direction from the first to the second node of a face.
fn initial_tangent([a, b]: [usize; 2], nodes: &Nodes) -> [f64; 2] {
    let [from, to] = [nodes.start[a], nodes.start[b]];
    let (dr, dz) = (to[0] - from[0], to[1] - from[1]);
    let length = dr.portable_hypot(dz);
    [dr / length, dz / length]
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

impl TractionLaw {
    /// Returns whether the traction is proportional to a velocity.
    fn is_damping(&self) -> bool {
        matches!(self, TractionLaw::Viscous(_) | TractionLaw::Absorbing { .. })
    }

    /// Returns the velocity to which a traction refers.
    fn reference_velocity(&self, dofs: &Dofs) -> [f64; 2] {
        if let TractionLaw::Viscous(reference) = self { reference.velocity(dofs) } else { [0.0; 2] }
    }

    /// Returns the force along z on a facet of a rigid body that moves along z, for unit magnitude (and unit velocity).
    fn on_facet(&self, facet: &Facet) -> f64 {
        let [n_r, n_z] = facet.normal;
        let along_z = match *self {
            TractionLaw::Fixed(direction) | TractionLaw::Following(direction) => direction[1],
            TractionLaw::Shear(direction) => {
                let along = dot(direction, [-n_z, n_r]);
                if along == 0.0 { 0.0 } else { n_r * along.signum() }
            }
            TractionLaw::Viscous(_) => -n_z * n_z,
            TractionLaw::Absorbing { shear_ratio } => -n_z * n_z - shear_ratio * n_r * n_r,
        };
        facet.area * along_z
    }

    /// Returns the traction on a face for a magnitude. Viscous pressure uses the velocity in the middle of the previous
    /// increment, as do infinite elements: Equation (16.5).
    #[inline]
    fn on_face(&self, face: &CurrentFace, magnitude: f64, dofs: &Dofs) -> [f64; 2] {
        // The outward normal is on the right of the direction from the first to the second node.
        let tangent = [-face.normal[1], face.normal[0]];
        let unit = match *self {
            TractionLaw::Fixed(direction) => direction,
            TractionLaw::Following(direction) => {
                let start = initial_tangent(face.nodes, &dofs.nodes);
                let [along, outward] = [dot(direction, start), dot(direction, [start[1], -start[0]])];
                [0, 1].inline_map(|k: usize| along * tangent[k] + outward * face.normal[k])
            }
            TractionLaw::Shear(direction) => {
                let along = dot(direction, initial_tangent(face.nodes, &dofs.nodes));
                tangent.inline_map(|t| if along == 0.0 { 0.0 } else { t * along.signum() })
            }
            TractionLaw::Viscous(reference) => {
                let reference = reference.velocity(dofs);
                let velocity = face.mean(|n| [dofs.nodes[n].v_r - reference[0], dofs.nodes[n].v_z - reference[1]]);
                let normal = dot(velocity, face.normal);
                face.normal.inline_map(|n| -n * normal)
            }
            TractionLaw::Absorbing { shear_ratio } => {
                let velocity = face.mean(|n| [dofs.nodes[n].v_r, dofs.nodes[n].v_z]);
                let [normal, along] = [dot(velocity, face.normal), shear_ratio * dot(velocity, tangent)];
                [0, 1].inline_map(|k: usize| -(face.normal[k] * normal + tangent[k] * along))
            }
        };
        unit.inline_map(|t| t * magnitude)
    }
}

/// A traction on a surface of rigid bodies that move along z and of deformable bodies.
#[derive(Clone, Debug, Persist)]
#[persist(derived: of_bodies, law)]
pub struct TractionField {
    surface: SurfaceGeometry,
    /// Force along z on the facets of each rigid body for unit magnitude.
    of_bodies: Vec<f64>,
    law: TractionLaw,
    /// Damping rate of the nodes by a traction against the velocity, 1/time.
    damping: f64,
}

impl TractionField {
    pub fn new(surface: SurfaceGeometry, law: TractionLaw) -> Self {
        let sum = |facets: &[(usize, Facet)]| facets.iter().map(|(_, facet)| law.on_facet(facet)).sum();
        let of_bodies = surface.patches.iter().map(|patch| sum(&patch.facets)).collect();
        TractionField { surface, of_bodies, law, damping: 0.0 }
    }
}

impl LoadDistribution for TractionField {
    fn targets(&self) -> LoadTargets {
        LoadTargets::along_z(&self.surface)
    }

    fn velocity_use(&self) -> VelocityUse {
        if self.law.is_damping() { VelocityUse::Reads } else { VelocityUse::None }
    }

    fn on_nodes(&mut self, magnitude: f64, scene: &SceneView<'_>, forces: &mut [[f64; 2]]) {
        let dofs = scene.dofs;
        self.damping = 0.0;
        for (nodes, shell) in self.surface.skin.active_faces_with_shells() {
            let face = CurrentFace::new(nodes, &dofs.nodes);
            let traction = self.law.on_face(&face, magnitude, dofs);
            let areas = match scene.rings {
                _ if shell => shell_areas(face.ends),
                None => ring_areas(face.ends),
                Some(rings) => {
                    let halves = section_areas(face.ends);
                    [halves[0] * rings[nodes[0]], halves[1] * rings[nodes[1]]]
                }
            };
            for (node, area) in nodes.into_iter().zip(areas) {
                forces[node] = [forces[node][0] + area * traction[0], forces[node][1] + area * traction[1]];
                if self.law.is_damping() {
                    // Row sum of the damping matrix; a node belongs to at most two faces.
                    self.damping = self.damping.max(2.0 * magnitude.abs() * area * dofs.nodes.inverse_mass[node]);
                }
            }
        }
    }

    fn on_bodies(&mut self, magnitude: f64, scene: &SceneView<'_>, forces: &mut [f64]) {
        for ((force, patch), sum) in forces.iter_mut().zip(&self.surface.patches).zip(&self.of_bodies) {
            *force = magnitude * sum;
            if self.law.is_damping() {
                *force *= scene.dofs.bodies[patch.body].velocity_load - self.law.reference_velocity(scene.dofs)[1];
            }
        }
    }

    fn scene_changed(&mut self, change: &SceneChange<'_>) {
        change.remove_faces(&mut self.surface);
    }

    fn arrays(&self) -> (&'static str, usize) {
        ("surface", self.surface.bytes())
    }

    fn damping(&self) -> f64 {
        self.damping
    }
}
