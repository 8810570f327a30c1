//! Body forces: per volume along r or z (`BR`, `BZ`), and centrifugal (`CENTRIF`).

use super::prescribed::LoadDistribution;
use super::{EnergyAccount, GeneralizedForce, LoadTargets, SceneChange, SceneView};
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::heap_bytes;
use crate::kernel::quad::{corner_masses, section};
use crate::kernel::topology::ElementNodes;
use crate::state::archive::Persist;
use crate::state::nodes::Nodes;

/// A force per current volume on deformable elements and rigid bodies.
#[derive(Clone, Debug, Persist)]
#[persist(derived: axis, bodies)]
pub struct BodyForceField {
    /// 0 along r, 1 along z.
    pub axis: usize,
    /// Corner nodes of the quadrilaterals of the elements.
    pub cells: Vec<[u32; 4]>,
    /// Rigid bodies and their loaded volume; the force acts along z.
    pub bodies: Vec<(usize, f64)>,
}

/// Returns the part of the volume of a cell that belongs to each corner (with area weighting: of the section).
#[inline]
pub(super) fn corner_volumes(cell: &[u32; 4], nodes: &Nodes, rings: Option<&[f64]>) -> [f64; 4] {
    let places = cell.inline_map(|n| nodes[n as usize].place());
    match rings {
        Some(rings) => {
            let quarter = 0.25 * section(places.inline_map(|p| p[0]), places.inline_map(|p| p[1]));
            cell.inline_map(|n| quarter * rings[n as usize])
        }
        None => corner_masses(places, 1.0),
    }
}

/// Returns whether a cell belongs to an element of the list.
fn belongs_to_any(cell: &[u32; 4], elements: &[ElementNodes]) -> bool {
    elements.iter().any(|nodes| cell.iter().all(|n| nodes.contains(n)))
}

impl LoadDistribution for BodyForceField {
    fn targets(&self) -> LoadTargets {
        let along_z = |body: &(usize, f64)| GeneralizedForce::along_z(body.0, EnergyAccount::Work);
        LoadTargets { bodies: self.bodies.iter().map(along_z).collect(), nodes: !self.cells.is_empty() }
    }

    fn on_nodes(&mut self, magnitude: f64, scene: &SceneView<'_>, forces: &mut [[f64; 2]]) {
        for cell in &self.cells {
            let volumes = corner_volumes(cell, &scene.dofs.nodes, scene.rings);
            for (&node, volume) in cell.iter().zip(volumes) {
                forces[node as usize][self.axis] += magnitude * volume;
            }
        }
    }

    fn on_bodies(&mut self, magnitude: f64, _scene: &SceneView<'_>, forces: &mut [f64]) {
        for (force, (_, volume)) in forces.iter_mut().zip(&self.bodies) {
            *force = magnitude * volume;
        }
    }

    fn scene_changed(&mut self, change: &SceneChange<'_>) {
        if let SceneChange::DeletedElements(deleted) = change {
            self.cells.retain(|cell| !belongs_to_any(cell, deleted));
        }
    }

    fn arrays(&self) -> (&'static str, usize) {
        ("cells", heap_bytes(&self.cells) + heap_bytes(&self.bodies))
    }
}

/// Centrifugal force of a rotation about the axis of symmetry: mass times squared angular velocity (the magnitude,
/// 1/time²) times radius.
#[derive(Clone, Debug, Persist)]
#[persist(derived: nodes)]
pub struct CentrifugalField {
    /// Nodes, with the part of their mass that rotates.
    pub nodes: Vec<(usize, f64)>,
}

impl LoadDistribution for CentrifugalField {
    fn targets(&self) -> LoadTargets {
        LoadTargets { bodies: Vec::new(), nodes: true }
    }

    fn on_nodes(&mut self, magnitude: f64, scene: &SceneView<'_>, forces: &mut [[f64; 2]]) {
        for &(node, mass) in &self.nodes {
            forces[node][0] += mass * magnitude * scene.dofs.nodes[node].r;
        }
    }

    fn arrays(&self) -> (&'static str, usize) {
        ("masses", heap_bytes(&self.nodes))
    }
}
