//! Quality of the meshes of bodies that are remeshed, and their new meshes so far.

use super::outcome::MeshChanges;
use super::run_state::RunState;
use crate::plan::{Plan, RemeshedBody};
use crate::remesh::mesher::sharpest;
use crate::remesh::{BodyMesh, MeshRevision};
use crate::state::archive::Persist;

/// An angle at which a new mesh begins, times this factor, is the limit if it is smaller than that of the deck.
const WORSE: f64 = 0.5;

/// Quality of the mesh of a body when it was made.
#[derive(Clone, Debug, Default, Persist)]
pub(super) struct MeshQuality {
    /// Angle below which the body is remeshed, radians.
    limit: f64,
    /// Stable time increment; 0 if it is not known yet.
    increment: f64,
    /// Increment before which the mesh is not checked.
    pub(super) next: u64,
    /// Number of new meshes.
    count: u64,
}

impl MeshQuality {
    fn is_distorted(&mut self, body: &RemeshedBody, run: &RunState<'_>) -> bool {
        if run.now.increment < self.next {
            return false;
        }
        self.next = run.now.increment + body.frequency;
        let (nodes, elements) = (&run.state.dofs.nodes, &run.state.elements);
        let stable = elements.stable_increment();
        if self.increment == 0.0 {
            self.increment = stable;
        }
        let is_short = elements.limiting().0 == body.group && stable < body.increment * self.increment;
        is_short || sharpest(&body.quads, |n| nodes[body.nodes[n as usize]].place()) < self.limit
    }

    /// Begins a new mesh, for a limit of the deck.
    pub(super) fn begin_mesh(&mut self, mesh: &BodyMesh, limit: f64) {
        let angle = sharpest(&mesh.quads, |n| mesh.points[n as usize]);
        (self.limit, self.increment) = (limit.min(WORSE * angle), 0.0);
        self.count += 1;
    }
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
        let quality = |body: &RemeshedBody| MeshQuality { limit: body.angle, ..MeshQuality::default() };
        RemeshMonitor { bodies: bodies.map(quality).collect(), ..RemeshMonitor::default() }
    }

    /// Returns a body whose mesh is to be replaced at this instant.
    #[inline]
    pub(super) fn body_to_mesh(&mut self, run: &RunState<'_>) -> Option<usize> {
        let bodies = &run.plan.remesh.as_ref()?.bodies;
        bodies.iter().zip(&mut self.bodies).position(|(body, quality)| quality.is_distorted(body, run))
    }

    /// Returns the number of new meshes of each ledger row.
    pub(super) fn counts(&self, plan: &Plan) -> Vec<MeshChanges> {
        let bodies = plan.remesh.iter().flat_map(|remesh| &remesh.bodies).zip(&self.bodies);
        bodies.map(|(body, quality)| MeshChanges { row: body.id, count: quality.count }).collect()
    }
}
