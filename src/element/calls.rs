//! Groups whose material calls user subroutines: the kinematics of a batch of tasks, the calls by one thread in the order of the
//! elements, then stresses and forces. Threads share what comes before and after the calls; no bit depends on their number.
//! Never here: what a call is shown.

use pulp::Arch;
use rayon::prelude::*;

use super::block::{ElementBlock, Nodes, Workspace};
use super::constants::Constants;
use super::group::{PARALLEL, Pass, Quads, TASK, Totals, UserCalls};
use super::numbers::{Forces, Numbers};
use super::record::{Followed, Record};
use crate::kernel::lanes::{Corners, InlineMap, LANES, wide};
use crate::material::Material;
use crate::material::user::flow::Returning;
use crate::material::user::points::{PointAccess, Points};
use crate::material::user::{CALL_BLOCKS, CallTime, PointCalls, Shown};
use crate::state::Instant;
use crate::state::halt::Halt;
use crate::state::nodes::Node;
use crate::user::{AtPoints, LoadFailure};
use crate::variables::{Part, Variable};

/// Tasks between whose phases the subroutines are called for all of them, where threads share them.
const BATCH: usize = 8;
/// Calls of a task, and elements of a call.
const CALLS: usize = TASK / CALL_BLOCKS;
const ELEMENTS: usize = CALL_BLOCKS * LANES;

/// Scratch memory of a block between the phases.
#[derive(Clone)]
struct BlockScratch<T> {
    work: Workspace<T>,
    nodes: Nodes<T>,
}

/// Scratch memory of the calls, and why the last pass failed.
#[derive(Clone)]
pub(super) struct Calls<T> {
    /// Arguments of the calls of a batch, and of the last call of the group, which has fewer points.
    points: Vec<Points>,
    last: Points,
    blocks: Vec<BlockScratch<T>>,
    returning: Returning,
    failure: Option<Halt>,
}

/// A failure with the call in which it was.
type Failed = (usize, LoadFailure);

impl<T: Numbers> Calls<T> {
    /// For a group of so many elements.
    pub fn new<S>(material: &dyn PointCalls<S>, constants: &Constants, count: usize) -> Calls<T> {
        // What no other thread shares is best done task by task.
        let batch = if count < PARALLEL { 1 } else { BATCH.min(count.div_ceil(TASK * LANES)) };
        let scratch = || BlockScratch { work: Workspace::new(constants, 1.0, 0), nodes: Nodes::default() };
        Calls {
            points: (0..batch * CALLS).map(|_| material.arguments(ELEMENTS)).collect(),
            last: material.arguments(count % ELEMENTS),
            blocks: (0..batch * TASK).map(|_| scratch()).collect(),
            returning: material.scratch(),
            failure: None,
        }
    }

    pub fn bytes(&self) -> usize {
        let Calls { points, last, blocks, returning, .. } = self;
        let points: usize = points.iter().chain([last]).map(|p| size_of_val(p) + p.bytes()).sum();
        size_of_val(self) + points + size_of_val(&**blocks) + returning.bytes()
    }
}

/// A task in one phase.
struct TaskPhase<'a, S, T> {
    blocks: &'a mut [ElementBlock<S, T>],
    task: &'a mut Workspace<T>,
    scratch: &'a mut [BlockScratch<T>],
    points: &'a mut [Points],
    corners: &'a mut [Corners<T>],
}

/// What all tasks of a pass share.
struct PassInput<'a, M: Material<T>, T: Numbers> {
    material: &'a M,
    calls: &'a dyn PointCalls<M::State>,
    constants: &'a Constants,
    count: usize,
    nodes: &'a [Node],
    now: &'a Instant,
    dt: f64,
    cap: f64,
    arch: Arch,
}

impl<M: Material<T>, T: Numbers> PassInput<'_, M, T> {
    /// Kinematics of a task, and the arguments of its calls.
    fn measure<const AREA: bool>(&self, index: usize, phase: TaskPhase<'_, M::State, T>) {
        let TaskPhase { blocks, task, scratch, points, .. } = phase;
        task.begin(self.arch, self.cap, self.dt, self.constants);
        for (i, (block, BlockScratch { work, nodes })) in blocks.iter_mut().zip(scratch).enumerate() {
            let number = index * TASK + i;
            std::mem::swap(&mut work.task, &mut task.task);
            work.begin(self.arch, self.cap, self.dt, self.constants);
            work.prepare(number, i, self.count - number * LANES);
            nodes.collect(self.nodes, &block.nodes, 0.0);
            self.material.begin(&mut block.state, self.now.total_time);
            block.mask(self.material, nodes, work);
            block.measure_strain::<M, AREA>(self.constants, T::of(self.dt), nodes, work);
            std::mem::swap(&mut work.task, &mut task.task);
            let corners = |l: usize| [nodes.of(l, 0).inline_map(T::wide), nodes.of(l, 1).inline_map(T::wide)];
            let strain = work.strain.strain.each_ref().inline_map(wide);
            let (spin, volume) = (wide(&work.strain.spin), wide(&work.strain.volume));
            let shown = Shown { strain, spin, volume, corners: &corners };
            self.calls.gather(&mut points[i / CALL_BLOCKS], i % CALL_BLOCKS, &mut block.state, &shown);
        }
    }

    /// The answers of the calls, and the corner forces that follow.
    fn respond<const AREA: bool>(&self, phase: TaskPhase<'_, M::State, T>) {
        let TaskPhase { blocks, task, scratch, points, corners } = phase;
        let each = blocks.iter_mut().zip(scratch).zip(corners).enumerate();
        for (i, ((block, BlockScratch { work, nodes }), corners)) in each {
            std::mem::swap(&mut work.task, &mut task.task);
            self.calls.scatter(&points[i / CALL_BLOCKS], i % CALL_BLOCKS, &mut block.state);
            let eroded = work.task.eroded.get(i).filter(|e| e.any()).copied();
            let increment = (self.constants, self.dt);
            T::finish::<M, AREA>(block, self.material, increment, eroded.as_ref(), nodes, work, corners);
            if !work.task.records.is_empty() {
                let increment = (wide(&work.strain.spin), self.dt);
                work.follow(self.arch, i, &block.stress, M::FLOW, increment);
            }
            std::mem::swap(&mut work.task, &mut task.task);
            task.add_sums(work);
        }
    }
}

/// What a call may ask of its points.
struct Access<'a, S, T> {
    blocks: &'a [ElementBlock<S, T>],
    records: &'a [Record],
}

impl<S, T> Access<'_, S, T> {
    fn followed(&self, point: usize) -> Option<Followed> {
        Some(self.records.get(point / LANES)?.of(point % LANES))
    }
}

impl<S, T: Numbers> PointAccess for Access<'_, S, T> {
    fn component(&self, point: usize, part: Part) -> Option<f64> {
        match part.variable {
            Variable::Stress => Some(self.blocks[point / LANES].stress[part.component][point % LANES].wide()),
            _ => self.followed(point)?.value(part),
        }
    }
}

/// Runs a phase for each task of a batch.
fn spread<S: Send, T: Numbers>(
    threads: bool,
    blocks: &mut [ElementBlock<S, T>],
    tasks: &mut [Workspace<T>],
    corners: &mut [Corners<T>],
    calls: &mut Calls<T>,
    phase: impl Fn(usize, TaskPhase<'_, S, T>) + Sync,
) {
    let Calls { points, blocks: scratch, .. } = calls;
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

impl<M: Material<T>, const AREA: bool, T: Numbers> Quads<M, AREA, T> {
    /// As [`super::group::ElementGroup::update`], of a material that calls user subroutines.
    pub(super) fn update_with_calls(&mut self, pass: Pass<'_>) -> Totals {
        let now = *pass.now;
        let failed = self.pass_with_calls(pass).err().map(|failed| self.halt(&failed, &now));
        let totals = self.totals();
        let rate = if failed.is_some() { f64::NAN } else { totals.rate };
        if let Some(calls) = &mut self.calls {
            calls.failure = failed;
        }
        Totals { rate, ..totals }
    }

    fn pass_with_calls(&mut self, pass: Pass<'_>) -> Result<(), Failed> {
        let Pass { nodes, dt, before: _, now, threads, mut user, corners, lacking: _ } = pass;
        let Forces::Own(corners) = T::forces(corners) else { return Ok(()) };
        let Quads { material, constants, count, blocks, tasks, calls, arch, cap, .. } = self;
        let (Some(calls), Some(of_material)) = (calls.as_deref_mut(), material.calls()) else { return Ok(()) };
        let input = &PassInput::<M, T> {
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
                input.measure::<AREA>(turn * batch + i, phase);
            });
            let called = input.call(first, &*blocks, &*tasks, calls, &mut user);
            if called.is_ok() {
                spread(threads, &mut *blocks, &mut *tasks, &mut *corners, calls, |_, phase| {
                    input.respond::<AREA>(phase)
                });
            }
            calls.exchange_last(first, *count, batch * CALLS);
            called?;
        }
        Ok(())
    }

    #[cold]
    fn halt(&self, (call, failure): &Failed, now: &Instant) -> Halt {
        let element = failure.point.map(|i| call * ELEMENTS + i);
        let (name, element) = self.material.calls().map_or(("", None), |calls| calls.names(element));
        let place = element.map_or(String::new(), |element| format!(" at element {element}"));
        failure.halt(&format!("the user material `{name}`{place}"), now)
    }

    /// Moduli from the answers to fictitious strains at time zero, as ABAQUS/Explicit asks for them: the largest of all elements.
    fn probe_moduli(
        &mut self,
        nodes: &[Node],
        now: &Instant,
        user: &mut AtPoints<'_>,
    ) -> Result<Option<[f64; 2]>, Failed> {
        let Quads { material, constants, count, blocks, tasks, calls, arch, cap, .. } = self;
        let (Some(calls), Some(of_material)) = (calls.as_deref_mut(), material.calls()) else { return Ok(None) };
        let (material, count, cap, arch) = (&**material, *count, *cap, *arch);
        let input =
            PassInput::<M, T> { material, calls: of_material, constants, count, nodes, now, dt: 0.0, cap, arch };
        let mut largest: Option<[f64; 2]> = None;
        for (index, (blocks, task)) in blocks.chunks_mut(TASK).zip(tasks).enumerate() {
            let count_of_calls = blocks.len().div_ceil(CALL_BLOCKS);
            let first = index * TASK * LANES;
            // The first slot serves all tasks.
            calls.exchange_last(first, count, CALLS);
            let Calls { points, blocks: scratch, .. } = &mut *calls;
            input.measure::<AREA>(index, TaskPhase { blocks, task, scratch, points, corners: &mut [] });
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

impl<M: Material<T>, T: Numbers> PassInput<'_, M, T> {
    /// The calls of a batch, in the order of its elements.
    fn call(
        &self,
        first: usize,
        blocks: &[ElementBlock<M::State, T>],
        tasks: &[Workspace<T>],
        calls: &mut Calls<T>,
        user: &mut AtPoints<'_>,
    ) -> Result<(), Failed> {
        let Calls { points, returning, .. } = calls;
        let time = CallTime { now: self.now, dt: self.dt };
        for (i, (blocks, points)) in blocks.chunks(CALL_BLOCKS).zip(points).enumerate() {
            let records = &tasks[i / CALLS].task.records;
            let records = records.get(i % CALLS * CALL_BLOCKS..).unwrap_or_default();
            let access = Access { blocks, records };
            let called = self.calls.call(points, user.lend(), time, &access, returning);
            called.map_err(|failure| (first / ELEMENTS + i, failure))?;
        }
        Ok(())
    }
}

impl<T> Calls<T> {
    /// Puts the arguments of the group's last call in their place among so many calls that begin with an element, and back.
    fn exchange_last(&mut self, first: usize, count: usize, calls: usize) {
        let place = (count / ELEMENTS).wrapping_sub(first / ELEMENTS);
        if !count.is_multiple_of(ELEMENTS) && place < calls {
            std::mem::swap(&mut self.points[place], &mut self.last);
        }
    }
}

impl<M: Material<T>, const AREA: bool, T: Numbers> UserCalls for Quads<M, AREA, T> {
    fn probe(&mut self, nodes: &[Node], now: &Instant, mut user: AtPoints<'_>) -> Result<(), Halt> {
        let moduli = self.probe_moduli(nodes, now, &mut user).map_err(|failed| self.halt(&failed, now))?;
        if let Some([bulk, shear]) = moduli {
            (self.constants.bulk, self.constants.shear) = (bulk, shear);
        }
        Ok(())
    }

    fn failure(&self) -> Option<Halt> {
        self.calls.as_ref()?.failure.clone()
    }
}
