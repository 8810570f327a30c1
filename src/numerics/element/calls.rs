//! Element groups whose material calls user subroutines. For a batch of tasks: threads compute the kinematics, one
//! thread calls the subroutines in the order of the elements, then threads compute stresses and forces. Results have
//! the same bits for any number of threads.

use pulp::Arch;
use rayon::prelude::*;

use super::block::{CornerNodes, ElementBlock, StoredTask, TASK, TaskWorkspace};
use super::constants::ElementConstants;
use super::eroded::ErodedLanes;
use super::group::{ElementPass, GroupTotals, PARALLEL, QuadGroup, UserCalls};
use super::record::{BlockRecord, ElementRecord};
use crate::kernel::lanes::{BlockCornerForces, LANES};
use crate::material::Material;
use crate::material::increment::StrainIncrement;
use crate::material::user::flow::ReturnScratch;
use crate::material::user::points::{PointAccess, PointArguments};
use crate::material::user::{BlockKinematics, CALL_BLOCKS, CallTime, PointCalls};
use crate::routines::{LoadFailure, PointRoutines};
use crate::state::Instant;
use crate::state::halt::HaltReason;
use crate::state::nodes::Node;
use crate::variables::{Variable, VariableComponent};

/// Number of tasks of a batch; its subroutine calls are made between two parallel phases.
const BATCH: usize = 8;
/// Calls per task, and elements per call.
const CALLS: usize = TASK / CALL_BLOCKS;
const ELEMENTS: usize = CALL_BLOCKS * LANES;

/// Scratch memory of a block between the phases.
#[derive(Clone)]
struct BlockScratch {
    work: TaskWorkspace,
    nodes: CornerNodes,
}

/// Scratch memory of the calls, and the failure of the last pass.
#[derive(Clone)]
pub(super) struct UserCallBuffers {
    /// Arguments of the calls of a batch, and of the last call of the group, which has fewer points.
    points: Vec<PointArguments>,
    last: PointArguments,
    blocks: Vec<BlockScratch>,
    returning: ReturnScratch,
    failure: Option<HaltReason>,
}

/// Index of the failed call, and the failure.
type CallFailure = (usize, LoadFailure);

impl UserCallBuffers {
    /// Creates the buffers of a group of `count` elements.
    pub fn new<S>(material: &dyn PointCalls<S>, constants: &ElementConstants, count: usize) -> UserCallBuffers {
        // Small groups are computed by one thread, which is fastest with one task per batch.
        let batch = if count < PARALLEL { 1 } else { BATCH.min(count.div_ceil(TASK * LANES)) };
        let scratch = || BlockScratch { work: TaskWorkspace::new(constants, 0), nodes: CornerNodes::default() };
        UserCallBuffers {
            points: (0..batch * CALLS).map(|_| material.arguments(ELEMENTS)).collect(),
            last: material.arguments(count % ELEMENTS),
            blocks: (0..batch * TASK).map(|_| scratch()).collect(),
            returning: material.scratch(),
            failure: None,
        }
    }

    pub fn bytes(&self) -> usize {
        let UserCallBuffers { points, last, blocks, returning, .. } = self;
        let points: usize = points.iter().chain([last]).map(|p| size_of_val(p) + p.bytes()).sum();
        size_of_val(self) + points + size_of_val(&**blocks) + returning.bytes()
    }
}

/// Data of one task in one phase.
struct TaskPhase<'a, S> {
    blocks: &'a mut [ElementBlock<S>],
    task: &'a mut StoredTask,
    scratch: &'a mut [BlockScratch],
    points: &'a mut [PointArguments],
    corners: &'a mut [BlockCornerForces],
}

/// Input that all tasks of a pass share.
struct PassInput<'a, M: Material> {
    material: &'a M,
    calls: &'a dyn PointCalls<M::State>,
    constants: &'a ElementConstants,
    count: usize,
    nodes: &'a [Node],
    now: &'a Instant,
    dt: f64,
    cap: f64,
    arch: Arch,
}

impl<M: Material> PassInput<'_, M> {
    /// Computes the kinematics of a task, and stores the arguments of its calls.
    fn measure(&self, index: usize, phase: TaskPhase<'_, M::State>) {
        let TaskPhase { blocks, task, scratch, points, .. } = phase;
        task.clear_sums();
        for (i, (block, BlockScratch { work, nodes })) in blocks.iter_mut().zip(scratch).enumerate() {
            let number = index * TASK + i;
            task.exchange(work);
            work.begin(self.arch, self.cap, self.dt, self.constants);
            work.prepare(number, i, self.count - number * LANES);
            nodes.collect(self.nodes, &block.nodes);
            self.material.begin(&mut block.state, self.now.total_time);
            block.mask(self.material, nodes, work);
            block.measure_strain::<M>(self.constants, self.dt, nodes, work);
            task.exchange(work);
            let corners = |l: usize| nodes.places(l);
            let StrainIncrement { strain, spin, volume, .. } = work.strain;
            let shown = BlockKinematics { strain, spin, volume, corners: &corners };
            self.calls.gather(&mut points[i / CALL_BLOCKS], i % CALL_BLOCKS, &mut block.state, &shown);
        }
    }

    /// Reads the results of the calls, and computes the corner forces.
    fn respond(&self, phase: TaskPhase<'_, M::State>) {
        let TaskPhase { blocks, task, scratch, points, corners } = phase;
        let each = blocks.iter_mut().zip(scratch).zip(corners).enumerate();
        for (i, ((block, BlockScratch { work, nodes }), corners)) in each {
            task.exchange(work);
            self.calls.scatter(&points[i / CALL_BLOCKS], i % CALL_BLOCKS, &mut block.state);
            let eroded = work.task.eroded.get(i).is_some_and(ErodedLanes::any);
            let increment = (self.constants, self.dt);
            block.finish(self.material, increment, eroded, nodes, work, corners);
            if !work.task.records.is_empty() {
                let increment = (work.strain.spin, self.dt);
                work.update_record(self.arch, i, M::FLOW, increment);
            }
            task.exchange(work);
            task.add_sums(work);
        }
    }
}

/// Values of the points of a call that a subroutine may request.
struct BlockPointAccess<'a, S> {
    blocks: &'a [ElementBlock<S>],
    records: &'a [BlockRecord],
}

impl<S> BlockPointAccess<'_, S> {
    fn followed(&self, point: usize) -> Option<ElementRecord> {
        Some(self.records.get(point / LANES)?.of(point % LANES))
    }
}

impl<S> PointAccess for BlockPointAccess<'_, S> {
    fn component(&self, point: usize, part: VariableComponent) -> Option<f64> {
        match part.variable {
            Variable::Stress => Some(self.blocks[point / LANES].stress[part.component][point % LANES]),
            _ => self.followed(point)?.value(part),
        }
    }
}

/// Runs a phase for each task of a batch.
fn spread<S: Send>(
    threads: bool,
    blocks: &mut [ElementBlock<S>],
    tasks: &mut [StoredTask],
    corners: &mut [BlockCornerForces],
    calls: &mut UserCallBuffers,
    phase: impl Fn(usize, TaskPhase<'_, S>) + Sync,
) {
    let UserCallBuffers { points, blocks: scratch, .. } = calls;
    if threads {
        let parts = blocks.par_chunks_mut(TASK).zip(tasks).zip(corners.par_chunks_mut(TASK));
        let parts = parts.zip(scratch.par_chunks_mut(TASK)).zip(points.par_chunks_mut(CALLS)).enumerate();
        parts.for_each(|(i, ((((blocks, task), corners), scratch), points))| {
            phase(i, TaskPhase { blocks, task, scratch, points, corners });
        });
    } else {
        let parts = blocks.chunks_mut(TASK).zip(tasks).zip(corners.chunks_mut(TASK));
        let parts = parts.zip(scratch.chunks_mut(TASK)).zip(points.chunks_mut(CALLS)).enumerate();
        parts.for_each(|(i, ((((blocks, task), corners), scratch), points))| {
            phase(i, TaskPhase { blocks, task, scratch, points, corners });
        });
    }
}

impl<M: Material> QuadGroup<M> {
    /// Implements [`super::group::ElementGroup::update`] for a material that calls user subroutines.
    pub(super) fn update_with_calls(&mut self, pass: ElementPass<'_>) -> GroupTotals {
        let now = *pass.now;
        let failed = self.pass_with_calls(pass).err().map(|failed| self.halt(&failed, &now));
        let totals = self.totals();
        let rate = if failed.is_some() { f64::NAN } else { totals.rate };
        if let Some(calls) = &mut self.calls {
            calls.failure = failed;
        }
        GroupTotals { rate, ..totals }
    }

    fn pass_with_calls(&mut self, pass: ElementPass<'_>) -> Result<(), CallFailure> {
        let ElementPass {
            nodes,
            dt,
            before: _,
            now,
            threads,
            mut user,
            corners,
            tiles: _,
            dilation_correction: _,
            prefetches: _,
        } = pass;
        let QuadGroup { material, constants, count, blocks, tasks, calls, arch, cap, .. } = self;
        let (Some(calls), Some(of_material)) = (calls.as_deref_mut(), material.calls()) else { return Ok(()) };
        let input = &PassInput::<M> {
            material: &**material,
            calls: of_material,
            constants,
            count: *count,
            nodes,
            now,
            dt,
            cap: *cap,
            arch: *arch,
        };
        let batch = calls.blocks.len() / TASK;
        let threads = threads && *count >= PARALLEL;
        let parts = blocks.chunks_mut(batch * TASK).zip(tasks.chunks_mut(batch));
        for (turn, ((blocks, tasks), corners)) in parts.zip(corners.chunks_mut(batch * TASK)).enumerate() {
            let first = turn * batch * TASK * LANES;
            calls.exchange_last(first, *count, batch * CALLS);
            spread(threads, &mut *blocks, &mut *tasks, &mut *corners, calls, |i, phase| {
                input.measure(turn * batch + i, phase);
            });
            let called = input.call(first, &*blocks, &*tasks, calls, &mut user);
            if called.is_ok() {
                spread(threads, &mut *blocks, &mut *tasks, &mut *corners, calls, |_, phase| input.respond(phase));
            }
            calls.exchange_last(first, *count, batch * CALLS);
            called?;
        }
        Ok(())
    }

    #[cold]
    fn halt(&self, (call, failure): &CallFailure, now: &Instant) -> HaltReason {
        let element = failure.point.map(|i| call * ELEMENTS + i);
        let (name, element) = self.material.calls().map_or(("", None), |calls| calls.names(element));
        let place = element.map_or(String::new(), |element| format!(" at element {element}"));
        failure.halt(&format!("the user material `{name}`{place}"), now)
    }

    /// Returns the largest moduli of all elements, from the response to fictitious strains at time zero, as in
    /// ABAQUS/Explicit.
    fn probe_moduli(
        &mut self,
        nodes: &[Node],
        now: &Instant,
        user: &mut PointRoutines<'_>,
    ) -> Result<Option<[f64; 2]>, CallFailure> {
        let QuadGroup { material, constants, count, blocks, tasks, calls, arch, cap, .. } = self;
        let (Some(calls), Some(of_material)) = (calls.as_deref_mut(), material.calls()) else { return Ok(None) };
        let (material, count, cap, arch) = (&**material, *count, *cap, *arch);
        let input = PassInput::<M> { material, calls: of_material, constants, count, nodes, now, dt: 0.0, cap, arch };
        let mut largest: Option<[f64; 2]> = None;
        for (index, (blocks, task)) in blocks.chunks_mut(TASK).zip(tasks).enumerate() {
            let count_of_calls = blocks.len().div_ceil(CALL_BLOCKS);
            let first = index * TASK * LANES;
            // All tasks use the first slot.
            calls.exchange_last(first, count, CALLS);
            let UserCallBuffers { points, blocks: scratch, .. } = &mut *calls;
            input.measure(index, TaskPhase { blocks, task, scratch, points, corners: &mut [] });
            for (i, points) in points.iter_mut().take(count_of_calls).enumerate() {
                let found = of_material.probe(points, user.lend(), now);
                let found = found.map_err(|failure| (index * CALLS + i, failure))?;
                largest = found.map_or(largest, |[bulk, shear]| {
                    let [most_bulk, most_shear] = largest.unwrap_or_default();
                    Some([most_bulk.max(bulk), most_shear.max(shear)])
                });
            }
            calls.exchange_last(first, count, CALLS);
        }
        Ok(largest)
    }
}

impl<M: Material> PassInput<'_, M> {
    /// Calls the subroutines of a batch in the order of its elements.
    fn call(
        &self,
        first: usize,
        blocks: &[ElementBlock<M::State>],
        tasks: &[StoredTask],
        calls: &mut UserCallBuffers,
        user: &mut PointRoutines<'_>,
    ) -> Result<(), CallFailure> {
        let UserCallBuffers { points, returning, .. } = calls;
        let time = CallTime { now: self.now, dt: self.dt };
        for (i, (blocks, points)) in blocks.chunks(CALL_BLOCKS).zip(points).enumerate() {
            let records = &tasks[i / CALLS].task.records;
            let records = records.get(i % CALLS * CALL_BLOCKS..).unwrap_or_default();
            let access = BlockPointAccess { blocks, records };
            let called = self.calls.call(points, user.lend(), time, &access, returning);
            called.map_err(|failure| (first / ELEMENTS + i, failure))?;
        }
        Ok(())
    }
}

impl UserCallBuffers {
    /// Exchanges the arguments of the group's last call with those at its position, among `calls` calls that begin with
    /// element `first`. A second call reverses the exchange.
    fn exchange_last(&mut self, first: usize, count: usize, calls: usize) {
        let place = (count / ELEMENTS).wrapping_sub(first / ELEMENTS);
        if !count.is_multiple_of(ELEMENTS) && place < calls {
            std::mem::swap(&mut self.points[place], &mut self.last);
        }
    }
}

impl<M: Material> UserCalls for QuadGroup<M> {
    fn probe(&mut self, nodes: &[Node], now: &Instant, mut user: PointRoutines<'_>) -> Result<(), HaltReason> {
        let moduli = self.probe_moduli(nodes, now, &mut user).map_err(|failed| self.halt(&failed, now))?;
        if let Some([bulk, shear]) = moduli {
            (self.constants.bulk, self.constants.shear) = (bulk, shear);
        }
        Ok(())
    }

    fn failure(&self) -> Option<HaltReason> {
        self.calls.as_ref()?.failure.clone()
    }

    fn moduli(&self) -> [f64; 2] {
        [self.constants.bulk, self.constants.shear]
    }

    fn set_moduli(&mut self, [bulk, shear]: [f64; 2]) {
        (self.constants.bulk, self.constants.shear) = (bulk, shear);
    }
}
