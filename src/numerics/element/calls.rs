//! Element groups whose material calls user subroutines. For a batch of tasks: threads compute the kinematics, one
//! thread calls the subroutines in the order of the elements, then threads compute stresses and forces. Results have
//! the same bits for any number of threads.
//!
//! A call has the points of one number in up to [`ELEMENTS`] elements, because subroutines receive one number of the
//! integration point (`kIntPt`) per call.

use rayon::prelude::*;

use super::constants::ElementConstants;
use super::group::{ElementPass, GroupTotals, PARALLEL, UserCalls};
use super::lane_sums::TASK;
use super::record::BlockRecord;
use super::solid::{BlockPass, BlockPlace, SolidBlock, SolidGroup, SolidIncrement};
use super::workspace::{StoredTask, TaskWorkspace};
use crate::kernel::lanes::{BlockCornerForces, LANES};
use crate::kernel::lists::Memory;
use crate::material::Material;
use crate::material::user::flow::ReturnScratch;
use crate::material::user::points::{PointAccess, PointArguments};
use crate::material::user::{CALL_BLOCKS, CallTime, PointCalls};
use crate::routines::{LoadFailure, PointRoutines};
use crate::state::Instant;
use crate::state::archive::{StateArchive, persist_fields};
use crate::state::halt::HaltReason;
use crate::state::nodes::{Node, NodeAccelerations};
use crate::variables::{Variable, VariableComponent};

/// Number of tasks of a batch; its subroutine calls are made between two parallel phases.
const BATCH: usize = 8;
/// Calls per task and integration point, and elements per call.
const CALLS: usize = TASK / CALL_BLOCKS;
const ELEMENTS: usize = CALL_BLOCKS * LANES;

/// Scratch memory of the calls, and the failure of the last pass.
#[derive(Clone)]
pub struct UserCallBuffers<T> {
    /// Arguments of the calls of a batch, and of the last calls of the group, which have fewer points. The calls of the
    /// points of the same elements follow each other.
    points: Vec<PointArguments>,
    last: Vec<PointArguments>,
    blocks: Vec<T>,
    returning: ReturnScratch,
    failure: Option<HaltReason>,
}

/// Index of the failed call, and the failure.
type CallFailure = (usize, LoadFailure);

impl<T: Clone + Default> UserCallBuffers<T> {
    /// Creates the buffers of a group of `count` elements with `points` points each; `None` for a material without
    /// calls.
    pub fn new<M: Material>(material: &M, points: usize, count: usize) -> Option<Box<UserCallBuffers<T>>> {
        let material = material.calls()?;
        // Small groups are computed by one thread, which is fastest with one task per batch.
        let batch = if count < PARALLEL { 1 } else { BATCH.min(count.div_ceil(TASK * LANES)) };
        let arguments = |elements: usize| (1..=points).map(move |point| material.arguments(elements, point));
        Some(Box::new(UserCallBuffers {
            points: (0..batch * CALLS).flat_map(|_| arguments(ELEMENTS)).collect(),
            last: arguments(count % ELEMENTS).collect(),
            blocks: vec![T::default(); batch * TASK],
            returning: material.scratch(),
            failure: None,
        }))
    }
}

impl<T> UserCallBuffers<T> {
    pub fn bytes(&self) -> usize {
        let UserCallBuffers { points, last, blocks, returning, .. } = self;
        let points: usize = points.iter().chain(last).map(|p| size_of_val(p) + p.bytes()).sum();
        size_of_val(self) + points + size_of_val(&**blocks) + returning.bytes()
    }

    /// Exchanges the arguments of the group's last calls with those at their position, among the calls of `calls`
    /// parts of elements that begin with element `first`. A second call reverses the exchange.
    fn exchange_last(&mut self, first: usize, count: usize, calls: usize) {
        let position = (count / ELEMENTS).wrapping_sub(first / ELEMENTS);
        if !count.is_multiple_of(ELEMENTS) && position < calls {
            let points = self.last.len();
            self.points[position * points..][..points].swap_with_slice(&mut self.last);
        }
    }
}

/// Data of one task in one phase.
struct TaskPhase<'a, B: SolidBlock> {
    blocks: &'a mut [B],
    task: &'a mut StoredTask,
    scratch: &'a mut [B::CallScratch],
    points: &'a mut [PointArguments],
    corners: &'a mut [BlockCornerForces],
}

/// Input that all tasks of a pass share.
pub struct CallPass<'a, M: Material> {
    pub blocks: BlockPass<'a, M>,
    calls: &'a dyn PointCalls<M::State>,
    now: &'a Instant,
}

impl<M: Material> CallPass<'_, M> {
    /// Begins the update of a block of points with its own workspace.
    pub fn begin(&self, BlockPlace { number, at }: BlockPlace, work: &mut TaskWorkspace) {
        let BlockPass { constants, increment, .. } = &self.blocks;
        increment.begin(constants, work);
        work.prepare(number, at, increment.count - number * LANES);
    }

    /// Computes the kinematics of a task, and stores the arguments of its calls.
    fn measure<B: SolidBlock<State = M::State>>(&self, index: usize, phase: TaskPhase<'_, B>) {
        let TaskPhase { blocks, task, scratch, points, .. } = phase;
        task.clear_sums();
        for (i, (block, scratch)) in blocks.iter_mut().zip(scratch).enumerate() {
            let points = &mut points[i / CALL_BLOCKS * B::POINTS..];
            let block_place = BlockPlace { number: index * TASK + i, at: i };
            block.measure(self, block_place, (task, scratch), &mut |p, state, kinematics| {
                self.calls.gather(&mut points[p], i % CALL_BLOCKS, state, kinematics);
            });
        }
    }

    /// Reads the results of the calls, and computes the corner forces.
    fn respond<B: SolidBlock<State = M::State>>(&self, phase: TaskPhase<'_, B>) {
        let TaskPhase { blocks, task, scratch, points, corners } = phase;
        let each = blocks.iter_mut().zip(scratch).zip(corners.chunks_mut(B::TOPOLOGY.force_blocks())).enumerate();
        for (i, ((block, scratch), corners)) in each {
            let points = &points[i / CALL_BLOCKS * B::POINTS..];
            for (p, points) in points.iter().take(B::POINTS).enumerate() {
                self.calls.scatter(points, i % CALL_BLOCKS, &mut block.points_mut()[p].state);
            }
            block.respond(self, i, (task, scratch), corners);
        }
    }

    /// Calls the subroutines of a batch in the order of its elements.
    fn call<B: SolidBlock<State = M::State>>(
        &self,
        first: usize,
        (blocks, tasks): (&[B], &[StoredTask]),
        calls: &mut UserCallBuffers<B::CallScratch>,
        user: &mut PointRoutines<'_>,
    ) -> Result<(), CallFailure> {
        let UserCallBuffers { points, returning, .. } = calls;
        let time = CallTime { now: self.now, dt: self.blocks.increment.dt };
        for (i, (blocks, points)) in blocks.chunks(CALL_BLOCKS).zip(points.chunks_mut(B::POINTS)).enumerate() {
            let records = &tasks[i / CALLS].task.records;
            let records = records.get(i % CALLS * CALL_BLOCKS * B::POINTS..).unwrap_or_default();
            for (number, points) in points.iter_mut().enumerate() {
                let access = BlockPointAccess { blocks, records, number };
                let called = self.calls.call(points, user.lend(), time, &access, returning);
                called.map_err(|failure| ((first / ELEMENTS + i) * B::POINTS + number, failure))?;
            }
        }
        Ok(())
    }
}

/// Values of the points of a call that a subroutine may request.
struct BlockPointAccess<'a, B> {
    blocks: &'a [B],
    records: &'a [BlockRecord],
    /// Number of the integration point, from 0.
    number: usize,
}

impl<B: SolidBlock> PointAccess for BlockPointAccess<'_, B> {
    fn component(&self, point: usize, part: VariableComponent) -> Option<f64> {
        let (block, lane) = (point / LANES, point % LANES);
        match part.variable {
            Variable::Stress => Some(self.blocks[block].points()[self.number].stress[part.component][lane]),
            _ => self.records.get(block * B::POINTS + self.number)?.of(lane).value(part),
        }
    }
}

/// Runs a phase for each task of a batch.
fn spread<B: SolidBlock>(
    threads: bool,
    (blocks, tasks): (&mut [B], &mut [StoredTask]),
    corners: &mut [BlockCornerForces],
    calls: &mut UserCallBuffers<B::CallScratch>,
    phase: impl Fn(usize, TaskPhase<'_, B>) + Sync,
) {
    let UserCallBuffers { points, blocks: scratch, .. } = calls;
    let (forces, calls) = (TASK * B::TOPOLOGY.force_blocks(), CALLS * B::POINTS);
    if threads {
        let parts = blocks.par_chunks_mut(TASK).zip(tasks).zip(corners.par_chunks_mut(forces));
        let parts = parts.zip(scratch.par_chunks_mut(TASK)).zip(points.par_chunks_mut(calls)).enumerate();
        parts.for_each(|(i, ((((blocks, task), corners), scratch), points))| {
            phase(i, TaskPhase { blocks, task, scratch, points, corners });
        });
    } else {
        let parts = blocks.chunks_mut(TASK).zip(tasks).zip(corners.chunks_mut(forces));
        let parts = parts.zip(scratch.chunks_mut(TASK)).zip(points.chunks_mut(calls)).enumerate();
        parts.for_each(|(i, ((((blocks, task), corners), scratch), points))| {
            phase(i, TaskPhase { blocks, task, scratch, points, corners });
        });
    }
}

/// Saves the moduli of a user material, which are determined only at time zero.
pub(super) fn persist_called_moduli<M: Material, B: SolidBlock<State = M::State>>(
    group: &mut SolidGroup<M, B>,
    archive: &mut StateArchive<'_>,
) {
    if M::CALLS {
        persist_fields!(archive; &mut group.constants.bulk, &mut group.constants.shear);
    }
}

impl<M: Material, B: SolidBlock<State = M::State>> SolidGroup<M, B> {
    /// Implements [`super::group::ElementGroup::update`] for a material that calls user subroutines.
    pub(super) fn update_with_calls(&mut self, pass: ElementPass<'_>) -> GroupTotals {
        let now = *pass.now;
        let failure = self.update_batches(pass).err().map(|failed| self.halt(&failed, &now));
        let failed = failure.is_some();
        if let Some(calls) = &mut self.calls {
            calls.failure = failure;
        }
        let totals = self.totals();
        GroupTotals { rate: if failed { f64::NAN } else { totals.rate }, ..totals }
    }

    /// Updates the elements batch by batch.
    fn update_batches(&mut self, pass: ElementPass<'_>) -> Result<(), CallFailure> {
        let ElementPass { nodes, dt, now, threads, mut user, corners, .. } = pass;
        let increment = self.increment(nodes, now, dt);
        let SolidGroup { material, constants, blocks, tasks, calls, .. } = self;
        let (Some(calls), Some(of_material)) = (calls.as_deref_mut(), material.calls()) else { return Ok(()) };
        let count = increment.count;
        let pass =
            &CallPass { blocks: BlockPass { material: &**material, constants, increment }, calls: of_material, now };
        let batch = calls.blocks.len() / TASK;
        let threads = threads && count >= PARALLEL;
        let parts = blocks.chunks_mut(batch * TASK).zip(tasks.chunks_mut(batch));
        let parts = parts.zip(corners.chunks_mut(batch * TASK * B::TOPOLOGY.force_blocks()));
        for (turn, ((blocks, tasks), corners)) in parts.enumerate() {
            let first = turn * batch * TASK * LANES;
            calls.exchange_last(first, count, batch * CALLS);
            spread(threads, (&mut *blocks, &mut *tasks), &mut *corners, calls, |i, phase| {
                pass.measure(turn * batch + i, phase);
            });
            let called = pass.call(first, (&*blocks, &*tasks), calls, &mut user);
            if called.is_ok() {
                spread(threads, (&mut *blocks, &mut *tasks), corners, calls, |_, phase| pass.respond(phase));
            }
            calls.exchange_last(first, count, batch * CALLS);
            called?;
        }
        Ok(())
    }

    #[cold]
    fn halt(&self, (call, failure): &CallFailure, now: &Instant) -> HaltReason {
        let element = failure.point.map(|i| call / B::POINTS * ELEMENTS + i);
        let (name, element) = self.material.calls().map_or(("", None), |calls| calls.names(element));
        let number = call % B::POINTS + 1;
        let point = if B::POINTS > 1 { format!(", integration point {number}") } else { String::new() };
        let location = element.map_or(String::new(), |element| format!(" at element {element}{point}"));
        let halt = failure.halt(&format!("the user material `{name}`{location}"), now);
        match element {
            Some(element) => halt.at_element(element),
            None => halt,
        }
    }

    /// Returns the input of an increment. Materials that call user subroutines use no accelerations.
    fn increment<'a>(&self, nodes: &'a [Node], now: &Instant, dt: f64) -> SolidIncrement<'a> {
        let SolidGroup { cap, arch, count, .. } = *self;
        SolidIncrement { nodes, dt, before: NodeAccelerations::default(), time: now.total_time, cap, arch, count }
    }

    /// Returns the largest moduli of all elements, from the response to fictitious strains at time zero, as in
    /// ABAQUS/Explicit.
    fn largest_moduli(
        &mut self,
        nodes: &[Node],
        now: &Instant,
        user: &mut PointRoutines<'_>,
    ) -> Result<Option<[f64; 2]>, CallFailure> {
        let increment = self.increment(nodes, now, 0.0);
        let SolidGroup { material, constants, blocks, tasks, calls, .. } = self;
        let (Some(calls), Some(of_material)) = (calls.as_deref_mut(), material.calls()) else { return Ok(None) };
        let count = increment.count;
        let pass =
            CallPass { blocks: BlockPass { material: &**material, constants, increment }, calls: of_material, now };
        let mut largest: Option<[f64; 2]> = None;
        for (index, (blocks, task)) in blocks.chunks_mut(TASK).zip(tasks.iter_mut()).enumerate() {
            let count_of_calls = blocks.len().div_ceil(CALL_BLOCKS) * B::POINTS;
            let first = index * TASK * LANES;
            // All tasks use the first slot.
            calls.exchange_last(first, count, CALLS);
            let UserCallBuffers { points, blocks: scratch, .. } = &mut *calls;
            pass.measure(index, TaskPhase::<B> { blocks, task, scratch, points, corners: &mut [] });
            for (i, points) in points.iter_mut().take(count_of_calls).enumerate() {
                let number = index * CALLS * B::POINTS + i;
                let moduli = of_material.probe(points, user.lend(), now).and_then(with_shear::<B>);
                largest = larger_moduli(largest, moduli.map_err(|failure| (number, failure))?);
            }
            calls.exchange_last(first, count, CALLS);
        }
        Ok(largest)
    }
}

/// Returns the larger of each modulus.
fn larger_moduli(largest: Option<[f64; 2]>, found: Option<[f64; 2]>) -> Option<[f64; 2]> {
    let Some([bulk, shear]) = found else { return largest };
    let [most_bulk, most_shear] = largest.unwrap_or_default();
    Some([most_bulk.max(bulk), most_shear.max(shear)])
}

/// Checks that a material has a shear modulus if its elements need one.
fn with_shear<B: SolidBlock>(moduli: Option<[f64; 2]>) -> Result<Option<[f64; 2]>, LoadFailure> {
    match moduli {
        Some([bulk, shear]) if B::NEEDS_SHEAR && shear <= 1e-9 * bulk => Err(LoadFailure::new(
            "its response to small strains at time zero has no shear modulus, which six-node triangles need",
        )),
        _ => Ok(moduli),
    }
}

impl<M: Material, B: SolidBlock<State = M::State>> UserCalls for SolidGroup<M, B> {
    fn probe(&mut self, nodes: &[Node], now: &Instant, mut user: PointRoutines<'_>) -> Result<(), HaltReason> {
        let moduli = self.largest_moduli(nodes, now, &mut user).map_err(|failed| self.halt(&failed, now))?;
        if let Some([bulk, shear]) = moduli {
            (self.constants.bulk, self.constants.shear) = (bulk, shear);
        }
        Ok(())
    }

    fn failure(&self) -> Option<HaltReason> {
        self.calls.as_ref()?.failure.clone()
    }

    fn constants(&mut self) -> &mut ElementConstants {
        &mut self.constants
    }
}
