//! Quality of the meshes of bodies that are remeshed, and their new meshes so far.

use super::outcome::MeshChanges;
use crate::plan::{Plan, RemeshedBody};
use crate::remesh::MeshRevision;
use crate::state::archive::Persist;

/// Excess of increments from which the first new mesh of a body without a card is worth its cost.
const PRICE: f64 = 100.0;

/// Quality of the mesh of a body when it was made.
#[derive(Clone, Debug, Default, Persist)]
pub(super) struct MeshQuality {
    /// Angle below which the body is remeshed, radians.
    pub(super) limit: f64,
    /// Stable time increment; 0 if it is not known yet. Without a card, the largest one so far.
    pub(super) increment: f64,
    /// Increments that the body has cost since its last mesh, beyond those with the largest stable time increment.
    pub(super) excess: f64,
    /// Excess of increments from which a new mesh is worth its cost.
    pub(super) price: f64,
    /// Increment before which the mesh is not checked.
    pub(super) next: u64,
    /// Number of new meshes.
    pub(super) count: u64,
}

/// New meshes of a run.
#[derive(Debug, Default, Persist)]
#[persist(derived: revisions)]
pub(super) struct RemeshMonitor {
    /// All new meshes, in their order. They are in the header of a checkpoint.
    pub(super) revisions: Vec<MeshRevision>,
    pub(super) bodies: Vec<MeshQuality>,
    /// Whether a mesh that could not be made has been reported.
    pub(super) reported: bool,
}

impl RemeshMonitor {
    pub(super) fn new(plan: &Plan) -> RemeshMonitor {
        let bodies = plan.remesh.iter().flat_map(|remesh| &remesh.bodies);
        let quality = |body: &RemeshedBody| MeshQuality { limit: body.angle, price: PRICE, ..MeshQuality::default() };
        RemeshMonitor { bodies: bodies.map(quality).collect(), ..RemeshMonitor::default() }
    }

    /// Returns the number of new meshes of each ledger row.
    pub(super) fn counts(&self, plan: &Plan) -> Vec<MeshChanges> {
        let bodies = plan.remesh.iter().flat_map(|remesh| &remesh.bodies).zip(&self.bodies);
        bodies.filter_map(|(body, quality)| Some(MeshChanges { row: body.id?, count: quality.count })).collect()
    }
}
