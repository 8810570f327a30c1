//! Six-node triangles as solid elements: geometry, masses and deletion of single elements, and the update of tasks.

use std::cell::RefCell;
use std::f64::consts::PI;
use std::ops::Range;

use super::block::TriangleBlock;
use super::triangles::{FORCE_BLOCKS, WorkArrays, operators_at, places};
use crate::element::block::ElementBlock;
use crate::element::calls::CallPass;
use crate::element::constants::{ElementConstants, damped};
use crate::element::eroded::ErodedLanes;
use crate::element::group::ElementStiffness;
use crate::element::lane_sums::TASK;
use crate::element::solid::{BlockPlace, InitialBlock, PointExpansion, SolidBlock, SolidGroup, SolidTask};
use crate::element::workspace::{StoredTask, TaskWorkspace};
use crate::kernel::lanes::{BlockCornerForces, InlineMap, Lanes};
use crate::kernel::six_node_triangle::{NODES, POINTS, TriangleOperators, frequency_squared, stiffness};
use crate::kernel::topology::{ElementTopology, PerNode};
use crate::material::Material;
use crate::material::carried::CarriedState;
use crate::material::increment::StrainIncrement;
use crate::material::user::BlockKinematics;
use crate::state::archive::Persist;
use crate::state::nodes::Node;

/// Group of six-node triangles.
pub type SixNodeTriangles<M> = SolidGroup<M, TriangleBlock<<M as Material>::State>>;

thread_local! {
    /// Scratch memory of the tasks that a thread updates one after the other.
    static SCRATCH: RefCell<(TaskWorkspace, WorkArrays)> = RefCell::default();
}

/// Scratch memory of a block before and after calls.
#[derive(Clone, Default)]
pub struct TriangleScratch {
    /// Workspace of each point.
    points: [TaskWorkspace; POINTS],
    work: WorkArrays,
}

/// Returns one over the stable time increment of an element with these moduli, inverse masses and linear bulk viscosity.
#[inline(never)]
fn elastic_rate(operators: &TriangleOperators, moduli: [f64; 2], inverse: &[f64; NODES], linear: f64) -> f64 {
    0.5 * frequency_squared(operators, moduli, inverse).sqrt() * damped(linear)
}

impl<S: Clone + Send + Sync + Persist + CarriedState + 'static> SolidBlock for TriangleBlock<S> {
    type State = S;
    type Element = [u32; NODES];
    type Memory = (TaskWorkspace, WorkArrays);
    type CallScratch = TriangleScratch;
    const TOPOLOGY: ElementTopology = ElementTopology::SixNodeTriangle;
    const POINTS: usize = POINTS;
    const TILES: bool = false;
    const IN_TASKS: bool = false;
    const NEEDS_SHEAR: bool = true;

    fn new<M: Material<State = S>>(
        material: &M,
        _constants: &ElementConstants,
        initial: &InitialBlock<'_, [u32; NODES]>,
    ) -> Self {
        TriangleBlock::at_rest(material, initial)
    }

    fn element(&self, lane: usize) -> [u32; NODES] {
        self.triangles.element(lane)
    }

    fn masses(&self, lane: usize) -> PerNode<f64> {
        self.triangles.inverse_masses(lane).inline_map(|inverse| 1.0 / inverse).into()
    }

    fn set_masses(&mut self, lane: usize, masses: &[f64], _rates: Option<&mut Lanes>) {
        let factor =
            masses.iter().sum::<f64>() / self.triangles.inverse_masses(lane).iter().map(|i| 1.0 / i).sum::<f64>();
        let mut raised: f64 = 0.0;
        for (list, mass) in self.triangles.inverse_mass.iter_mut().zip(masses) {
            raised = raised.max(1.0 / (mass * list[lane]));
            list[lane] = 1.0 / mass;
        }
        self.triangles.rate[lane] *= raised.sqrt();
        self.points.iter_mut().for_each(|p| p.mass[lane] *= factor);
    }

    fn mass(&self, lane: usize) -> f64 {
        self.points.iter().map(|p| p.mass[lane]).sum()
    }

    fn points(&self) -> &[ElementBlock<S>] {
        &self.points
    }

    fn points_mut(&mut self) -> &mut [ElementBlock<S>] {
        &mut self.points
    }

    fn volumes(element: [u32; NODES], nodes: &[Node]) -> impl Iterator<Item = f64> {
        operators_at(places(element, nodes)).volume.into_iter().map(|volume| 2.0 * PI * volume)
    }

    fn expansions(
        element: [u32; NODES],
        nodes: &[Node],
        dt: f64,
        _by_area: bool,
    ) -> impl Iterator<Item = PointExpansion> {
        let nodes_of_element = element.inline_map(|n| nodes[n as usize]);
        let g = operators_at(nodes_of_element.inline_map(|n| [n.r - 0.5 * dt * n.v_r, n.z - 0.5 * dt * n.v_z]));
        let (v_r, v_z) = (nodes_of_element.inline_map(|n| n.v_r), nodes_of_element.inline_map(|n| n.v_z));
        (0..POINTS).map(move |p| {
            let [rr, zz, hoop, ..] = g.gradients(p, &v_r, &v_z);
            PointExpansion { volume: 2.0 * PI * g.volume[p], factor: PI, span: dt, dilation: rr + zz + hoop }
        })
    }

    fn bytes(&self) -> usize {
        size_of_val(&*self.start)
    }

    fn last_rate(&self, lane: usize, _rates: Option<&Lanes>) -> f64 {
        0.5 * self.triangles.rate[lane]
    }

    fn elastic_rate(
        &self,
        lane: usize,
        constants: &ElementConstants,
        masses: Option<&[f64]>,
        nodes: &[Node],
    ) -> Option<f64> {
        let inverse = match masses {
            Some(masses) => masses.first_chunk::<NODES>()?.inline_map(|mass| 1.0 / mass),
            None => self.triangles.inverse_masses(lane),
        };
        let (operators, linear) = (operators_at(places(self.element(lane), nodes)), constants.bulk_viscosity.linear);
        Some(elastic_rate(&operators, [constants.bulk, constants.shear], &inverse, linear))
    }

    fn stiffness(&self, lane: usize, constants: &ElementConstants, nodes: &[Node]) -> ElementStiffness {
        stiffness(places(self.element(lane), nodes), [constants.bulk, constants.shear]).into()
    }

    fn is_eroded(&self, lane: usize, _eroded: Option<&ErodedLanes>) -> bool {
        self.triangles.deleted[lane]
    }

    fn erode(&mut self, lanes: Range<usize>, _volume: f64, _eroded: Option<&mut ErodedLanes>) {
        for lane in lanes {
            self.triangles.deleted[lane] = true;
            self.points.iter_mut().flat_map(|p| &mut p.stress).for_each(|s| s[lane] = 0.0);
        }
    }

    fn with_memory(of_memory: impl FnOnce(&mut (TaskWorkspace, WorkArrays))) {
        SCRATCH.with_borrow_mut(of_memory);
    }

    #[inline(always)]
    fn update_task<M: Material<State = S>>(task: SolidTask<'_, M, Self>) {
        let SolidTask { pass, index, blocks, corners, stored, memory: (scratch, work) } = task;
        stored.exchange(scratch);
        pass.blocks.increment.begin(pass.blocks.constants, scratch);
        for (at, (block, corners)) in blocks.iter_mut().zip(corners.chunks_mut(FORCE_BLOCKS)).enumerate() {
            let block_place = BlockPlace { number: index * TASK + at, at };
            block.update(&pass.blocks, block_place, (&mut *scratch, &mut *work), corners);
        }
        stored.exchange(scratch);
        stored.set_sums(scratch);
    }

    fn measure<M: Material<State = S>>(
        &mut self,
        pass: &CallPass<'_, M>,
        BlockPlace { number, at }: BlockPlace,
        (task, TriangleScratch { points, work }): (&mut StoredTask, &mut TriangleScratch),
        gather: &mut dyn FnMut(usize, &mut S, &BlockKinematics<'_>),
    ) {
        self.triangles.measure(&pass.blocks.increment, work);
        let nodes = |l: usize| work.places(l).into();
        for (p, scratch) in points.iter_mut().enumerate() {
            task.exchange(scratch);
            pass.begin(BlockPlace { number, at: POINTS * at + p }, scratch);
            self.measure_point(p, &pass.blocks, scratch, work);
            task.exchange(scratch);
            let cell = Self::TOPOLOGY.cells()[p];
            let corners = |l: usize| {
                let places = work.places(l);
                [0, 1].inline_map(|axis: usize| cell.inline_map(|n| places[n][axis]))
            };
            let gradient = work.deformation(p, &self.start);
            let StrainIncrement { strain, spin, volume, .. } = scratch.strain;
            let (gradient, starts) = (Some(&gradient), pass.blocks.increment.dt == 0.0);
            let kinematics =
                BlockKinematics { strain, spin, volume, gradient, corners: &corners, nodes: &nodes, starts };
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
        for (p, scratch) in points.iter_mut().enumerate() {
            task.exchange(scratch);
            self.update_point(p, &pass.blocks, scratch, work);
            if p + 1 == POINTS {
                self.assemble(&pass.blocks, at, (scratch, work), corners);
            }
            task.exchange(scratch);
            task.add_sums(scratch);
        }
    }
}
