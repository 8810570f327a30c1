//! Calls of user subroutines at the points of six-node triangles.

use super::block::TriangleBlock;
use super::triangles::{FORCE_BLOCKS, TriangleIncrement, WorkArrays};
use crate::element::block::{ElementBlock, StoredTask, TaskWorkspace};
use crate::element::calls::{CallPass, CallingBlock};
use crate::kernel::lanes::{BlockCornerForces, InlineMap};
use crate::kernel::six_node_triangle::POINTS;
use crate::kernel::topology::ElementTopology;
use crate::material::Material;
use crate::material::increment::StrainIncrement;
use crate::material::user::BlockKinematics;
use crate::state::nodes::NodeAccelerations;

/// Scratch memory of a block between the phases.
#[derive(Clone, Default)]
pub(in crate::element) struct TriangleScratch {
    /// Workspace of each point.
    points: [TaskWorkspace; POINTS],
    work: WorkArrays,
}

/// Returns the increment of a pass. Materials that call user subroutines use no accelerations.
fn increment<'a, M: Material>(pass: &CallPass<'a, M>) -> TriangleIncrement<'a> {
    let (before, time) = (NodeAccelerations::default(), pass.now.total_time);
    TriangleIncrement { nodes: pass.nodes, dt: pass.dt, before, time, arch: pass.arch, count: pass.count }
}

impl<S: Clone + Send + Sync> CallingBlock for TriangleBlock<S> {
    type State = S;
    type Scratch = TriangleScratch;
    const POINTS: usize = POINTS;
    const FORCE_BLOCKS: usize = FORCE_BLOCKS;
    const NEEDS_SHEAR: bool = true;

    fn point(&self, p: usize) -> &ElementBlock<S> {
        &self.points[p]
    }

    fn point_mut(&mut self, p: usize) -> &mut ElementBlock<S> {
        &mut self.points[p]
    }

    fn measure<M: Material<State = S>>(
        &mut self,
        pass: &CallPass<'_, M>,
        (number, at): (usize, usize),
        (task, TriangleScratch { points, work }): (&mut StoredTask, &mut TriangleScratch),
        gather: &mut dyn FnMut(usize, &mut S, &BlockKinematics<'_>),
    ) {
        let increment = increment(pass);
        self.triangles.measure(&increment, work);
        let nodes = |l: usize| work.places(l).into();
        for (p, scratch) in points.iter_mut().enumerate() {
            task.exchange(scratch);
            pass.begin((number, POINTS * at + p), scratch);
            self.measure_point(p, pass.material, pass.constants, &increment, scratch, work);
            task.exchange(scratch);
            let cell = ElementTopology::SixNodeTriangle.cells()[p];
            let corners = |l: usize| {
                let places = work.places(l);
                [0, 1].inline_map(|axis: usize| cell.inline_map(|n| places[n][axis]))
            };
            let gradient = work.deformation(p, &self.start);
            let StrainIncrement { strain, spin, volume, .. } = scratch.strain;
            let gradient = Some(&gradient);
            let kinematics = BlockKinematics { strain, spin, volume, gradient, corners: &corners, nodes: &nodes };
            gather(p, &mut self.points[p].state, &kinematics);
        }
    }

    fn respond<M: Material<State = S>>(
        &mut self,
        pass: &CallPass<'_, M>,
        at: usize,
        (task, TriangleScratch { points, work }): (&mut StoredTask, &mut TriangleScratch),
        corners: &mut [BlockCornerForces],
    ) {
        let increment = increment(pass);
        for (p, scratch) in points.iter_mut().enumerate() {
            task.exchange(scratch);
            self.update_point(p, pass.material, pass.constants, &increment, scratch, work);
            if p + 1 == POINTS {
                self.assemble(pass.material, pass.constants, &increment, at, (scratch, work), corners);
            }
            task.exchange(scratch);
            task.add_sums(scratch);
        }
    }
}
