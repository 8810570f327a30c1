//! Body forces: per volume along r or z (`BR`, `BZ`), and centrifugal (`CENTRIF`).

use super::TargetDissipation;
use super::{EnergyAccount, GeneralizedForce, Load, LoadForces, LoadOutput, LoadTargets, SceneChange, SceneView};
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::{Memory, heap_bytes};
use crate::kernel::quad::{corner_masses, section};
use crate::kernel::topology::ElementNodes;
use crate::routines::LockedRoutines;
use crate::state::EffectId;
use crate::state::archive::Persist;
use crate::state::halt::HaltReason;
use crate::state::limit::IncrementLimit;
use crate::state::magnitude::Magnitude;
use crate::state::nodes::Nodes;

/// A force per current volume on deformable elements and rigid bodies.
#[derive(Clone, Debug, Persist)]
#[persist(derived: id, axis, bodies, magnitude)]
pub struct BodyForceLoad {
    pub id: EffectId,
    /// 0 along r, 1 along z.
    pub axis: usize,
    /// Corner nodes of the quadrilaterals of the elements.
    pub cells: Vec<[u32; 4]>,
    /// Rigid bodies and their loaded volume; the force acts along z.
    pub bodies: Vec<(usize, f64)>,
    pub magnitude: Magnitude,
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

impl Load for BodyForceLoad {
    fn effect(&self) -> EffectId {
        self.id
    }

    fn targets(&self) -> LoadTargets {
        let along_z = |body: &(usize, f64)| GeneralizedForce::along_z(body.0, EnergyAccount::Work);
        LoadTargets { bodies: self.bodies.iter().map(along_z).collect(), nodes: !self.cells.is_empty() }
    }

    fn apply(
        &mut self,
        scene: &SceneView<'_>,
        _: &mut LockedRoutines,
        forces: &mut LoadForces<'_>,
    ) -> Result<TargetDissipation, HaltReason> {
        let magnitude = self.magnitude.at(&scene.clock);
        match forces {
            LoadForces::OnNodes(forces) => {
                for cell in &self.cells {
                    let volumes = corner_volumes(cell, &scene.dofs.nodes, scene.rings);
                    for (&node, volume) in cell.iter().zip(volumes) {
                        forces[node as usize][self.axis] += magnitude * volume;
                    }
                }
            }
            LoadForces::OnBodies(forces) => {
                for (force, (_, volume)) in forces.iter_mut().zip(&self.bodies) {
                    *force = magnitude * volume;
                }
            }
        }
        Ok(TargetDissipation::default())
    }

    fn max_increment(&self, scene: &SceneView<'_>) -> IncrementLimit {
        self.magnitude.limit(&scene.clock)
    }

    fn scene_changed(&mut self, change: &SceneChange<'_>) {
        if let SceneChange::DeletedElements(deleted) = change {
            self.cells.retain(|cell| !belongs_to_any(cell, deleted));
        }
    }
}

impl LoadOutput for BodyForceLoad {
    fn arrays(&self) -> Vec<(&'static str, usize)> {
        vec![("cells", heap_bytes(&self.cells) + heap_bytes(&self.bodies)), ("amplitude", self.magnitude.bytes())]
    }
}

/// Centrifugal force of a rotation about the axis of symmetry: mass times squared angular velocity times radius.
#[derive(Clone, Debug, Persist)]
#[persist(derived: id, nodes, square)]
pub struct CentrifugalLoad {
    pub id: EffectId,
    /// Nodes, with the part of their mass that rotates.
    pub nodes: Vec<(usize, f64)>,
    /// Squared angular velocity, 1/time².
    pub square: Magnitude,
}

impl Load for CentrifugalLoad {
    fn effect(&self) -> EffectId {
        self.id
    }

    fn targets(&self) -> LoadTargets {
        LoadTargets { bodies: Vec::new(), nodes: true }
    }

    fn apply(
        &mut self,
        scene: &SceneView<'_>,
        _: &mut LockedRoutines,
        forces: &mut LoadForces<'_>,
    ) -> Result<TargetDissipation, HaltReason> {
        if let LoadForces::OnNodes(forces) = forces {
            let square = self.square.at(&scene.clock);
            for &(node, mass) in &self.nodes {
                forces[node][0] += mass * square * scene.dofs.nodes[node].r;
            }
        }
        Ok(TargetDissipation::default())
    }

    fn max_increment(&self, scene: &SceneView<'_>) -> IncrementLimit {
        self.square.limit(&scene.clock)
    }
}

impl LoadOutput for CentrifugalLoad {
    fn arrays(&self) -> Vec<(&'static str, usize)> {
        vec![("masses", heap_bytes(&self.nodes)), ("amplitude", self.square.bytes())]
    }
}
