//! Element groups whose material calls user subroutines. For a batch of tasks: threads compute the kinematics, one
//! thread calls the subroutines in the order of the elements, then threads compute stresses and forces. Results have
//! the same bits for any number of threads.
//!
//! A call has the points of one number in up to [`ELEMENTS`] elements, because subroutines receive one number of the
//! integration point (`kIntPt`) per call.

use crate::kernel::lists::Memory;
use pulp::Arch;
use rayon::prelude::*;

use super::block::{CornerNodes, ElementBlock, StoredTask, TASK, TaskWorkspace};
use super::constants::ElementConstants;
use super::eroded::ErodedLanes;
use super::group::{ElementPass, GroupTotals, PARALLEL, QuadGroup, UserCalls};
use super::record::BlockRecord;
use crate::kernel::lanes::{BlockCornerForces, InlineMap, LANES};
use crate::material::Material;
use crate::material::increment::StrainIncrement;
use crate::material::user::flow::ReturnScratch;
use crate::material::user::points::{PointAccess, PointArguments};
use crate::material::user::{BlockKinematics, CALL_BLOCKS, CallTime, PointCalls};
use crate::routines::{LoadFailure, PointRoutines};
use crate::state::Instant;
use crate::state::archive::{StateArchive, persist_fields};
use crate::state::halt::HaltReason;
use crate::state::nodes::Node;
use crate::variables::{Variable, VariableComponent};

/// Number of tasks of a batch; its subroutine calls are made between two parallel phases.
const BATCH: usize = 8;
/// Calls per task and integration point, and elements per call.
const CALLS: usize = TASK / CALL_BLOCKS;
const ELEMENTS: usize = CALL_BLOCKS * LANES;

/// A block of elements whose points call user subroutines.
pub(super) trait CallingBlock: Send + Sync {
    /// State of the material of a point.
    type State;
    /// Scratch memory of a block between the phases.
    type Scratch: Clone + Default + Send;
    /// Number of integration points of an element.
    const POINTS: usize;
    /// Blocks of corner forces of a block of elements.
    const FORCE_BLOCKS: usize;
    /// Whether some motions of the nodes are resisted by the shear stiffness of the material only.
    const NEEDS_SHEAR: bool;

    /// Returns a point of the elements.
    fn point(&self, p: usize) -> &ElementBlock<Self::State>;

    fn point_mut(&mut self, p: usize) -> &mut ElementBlock<Self::State>;

    /// Computes the kinematics of an increment, and passes those of each point to `gather`. `place`: the indices
    /// of the block in the group and in its task.
    fn measure<M: Material<State = Self::State>>(
        &mut self,
        pass: &CallPass<'_, M>,
        place: (usize, usize),
        memory: (&mut StoredTask, &mut Self::Scratch),
        gather: &mut dyn FnMut(usize, &mut Self::State, &BlockKinematics<'_>),
    );

    /// Computes stresses and corner forces from the results of the calls.
    fn respond<M: Material<State = Self::State>>(
        &mut self,
        pass: &CallPass<'_, M>,
        at: usize,
        memory: (&mut StoredTask, &mut Self::Scratch),
        corners: &mut [BlockCornerForces],
    );
}

/// Scratch memory of a block of quadrilaterals between the phases.
#[derive(Clone, Default)]
pub(super) struct QuadScratch {
    work: TaskWorkspace,
    nodes: CornerNodes,
}

/// Scratch memory of the calls, and the failure of the last pass.
#[derive(Clone)]
pub(super) struct UserCallBuffers<T> {
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
        let place = (count / ELEMENTS).wrapping_sub(first / ELEMENTS);
        if !count.is_multiple_of(ELEMENTS) && place < calls {
            let points = self.last.len();
            self.points[place * points..][..points].swap_with_slice(&mut self.last);
        }
    }
}

/// Data of one task in one phase.
struct TaskPhase<'a, B: CallingBlock> {
    blocks: &'a mut [B],
    task: &'a mut StoredTask,
    scratch: &'a mut [B::Scratch],
    points: &'a mut [PointArguments],
    corners: &'a mut [BlockCornerForces],
}

/// Input that all tasks of a pass share.
pub(super) struct CallPass<'a, M: Material> {
    pub material: &'a M,
    calls: &'a dyn PointCalls<M::State>,
    pub constants: &'a ElementConstants,
    /// Number of elements of the group.
    pub count: usize,
    pub nodes: &'a [Node],
    pub now: &'a Instant,
    pub dt: f64,
    cap: f64,
    pub arch: Arch,
}

impl<M: Material> CallPass<'_, M> {
    /// Begins the update of a block of points with its own workspace.
    pub fn begin(&self, (number, at): (usize, usize), work: &mut TaskWorkspace) {
        work.begin(self.arch, self.cap, self.dt, self.constants);
        work.prepare(number, at, self.count - number * LANES);
    }

    /// Computes the kinematics of a task, and stores the arguments of its calls.
    fn measure<B: CallingBlock<State = M::State>>(&self, index: usize, phase: TaskPhase<'_, B>) {
        let TaskPhase { blocks, task, scratch, points, .. } = phase;
        task.clear_sums();
        for (i, (block, scratch)) in blocks.iter_mut().zip(scratch).enumerate() {
            let points = &mut points[i / CALL_BLOCKS * B::POINTS..];
            block.measure(self, (index * TASK + i, i), (task, scratch), &mut |p, state, kinematics| {
                self.calls.gather(&mut points[p], i % CALL_BLOCKS, state, kinematics);
            });
        }
    }

    /// Reads the results of the calls, and computes the corner forces.
    fn respond<B: CallingBlock<State = M::State>>(&self, phase: TaskPhase<'_, B>) {
        let TaskPhase { blocks, task, scratch, points, corners } = phase;
        let each = blocks.iter_mut().zip(scratch).zip(corners.chunks_mut(B::FORCE_BLOCKS)).enumerate();
        for (i, ((block, scratch), corners)) in each {
            let points = &points[i / CALL_BLOCKS * B::POINTS..];
            for (p, points) in points.iter().take(B::POINTS).enumerate() {
                self.calls.scatter(points, i % CALL_BLOCKS, &mut block.point_mut(p).state);
            }
            block.respond(self, i, (task, scratch), corners);
        }
    }

    /// Calls the subroutines of a batch in the order of its elements.
    fn call<B: CallingBlock<State = M::State>>(
        &self,
        first: usize,
        (blocks, tasks): (&[B], &[StoredTask]),
        calls: &mut UserCallBuffers<B::Scratch>,
        user: &mut PointRoutines<'_>,
    ) -> Result<(), CallFailure> {
        let UserCallBuffers { points, returning, .. } = calls;
        let time = CallTime { now: self.now, dt: self.dt };
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

impl<S: Clone + Send + Sync> CallingBlock for ElementBlock<S> {
    type State = S;
    type Scratch = QuadScratch;
    const POINTS: usize = 1;
    const FORCE_BLOCKS: usize = 1;
    const NEEDS_SHEAR: bool = false;

    fn point(&self, _p: usize) -> &ElementBlock<S> {
        self
    }

    fn point_mut(&mut self, _p: usize) -> &mut ElementBlock<S> {
        self
    }

    fn measure<M: Material<State = S>>(
        &mut self,
        pass: &CallPass<'_, M>,
        place: (usize, usize),
        (task, QuadScratch { work, nodes }): (&mut StoredTask, &mut QuadScratch),
        gather: &mut dyn FnMut(usize, &mut S, &BlockKinematics<'_>),
    ) {
        task.exchange(work);
        pass.begin(place, work);
        nodes.collect(pass.nodes, &self.nodes);
        pass.material.begin(&mut self.state, pass.now.total_time);
        self.mask(pass.material, nodes, work);
        self.measure_strain::<M>(pass.constants, pass.dt, nodes, work);
        task.exchange(work);
        let corners = |l: usize| nodes.places(l);
        let around = |l: usize| [0, 1, 2, 3].inline_map(|c: usize| nodes.0[c][l].place()).into();
        let StrainIncrement { strain, spin, volume, .. } = work.strain;
        let kinematics = BlockKinematics { strain, spin, volume, gradient: None, corners: &corners, nodes: &around };
        gather(0, &mut self.state, &kinematics);
    }

    fn respond<M: Material<State = S>>(
        &mut self,
        pass: &CallPass<'_, M>,
        at: usize,
        (task, QuadScratch { work, nodes }): (&mut StoredTask, &mut QuadScratch),
        corners: &mut [BlockCornerForces],
    ) {
        task.exchange(work);
        let eroded = work.task.eroded.get(at).is_some_and(ErodedLanes::any);
        self.finish(pass.material, (pass.constants, pass.dt), eroded, nodes, work, &mut corners[0]);
        if !work.task.records.is_empty() {
            let increment = (work.strain.spin, pass.dt);
            work.update_record(pass.arch, at, M::FLOW, increment);
        }
        task.exchange(work);
        task.add_sums(work);
    }
}

/// Values of the points of a call that a subroutine may request.
struct BlockPointAccess<'a, B> {
    blocks: &'a [B],
    records: &'a [BlockRecord],
    /// Number of the integration point, from 0.
    number: usize,
}

impl<B: CallingBlock> PointAccess for BlockPointAccess<'_, B> {
    fn component(&self, point: usize, part: VariableComponent) -> Option<f64> {
        let (block, lane) = (point / LANES, point % LANES);
        match part.variable {
            Variable::Stress => Some(self.blocks[block].point(self.number).stress[part.component][lane]),
            _ => self.records.get(block * B::POINTS + self.number)?.of(lane).value(part),
        }
    }
}

/// Runs a phase for each task of a batch.
fn spread<B: CallingBlock>(
    threads: bool,
    (blocks, tasks): (&mut [B], &mut [StoredTask]),
    corners: &mut [BlockCornerForces],
    calls: &mut UserCallBuffers<B::Scratch>,
    phase: impl Fn(usize, TaskPhase<'_, B>) + Sync,
) {
    let UserCallBuffers { points, blocks: scratch, .. } = calls;
    let (forces, calls) = (TASK * B::FORCE_BLOCKS, CALLS * B::POINTS);
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

/// A group of elements, as far as calls need it.
pub(super) struct CallingElements<'a, M: Material, B: CallingBlock> {
    pub material: &'a M,
    pub constants: &'a mut ElementConstants,
    pub count: usize,
    pub blocks: &'a mut [B],
    pub tasks: &'a mut [StoredTask],
    pub calls: Option<&'a mut UserCallBuffers<B::Scratch>>,
    pub arch: Arch,
    pub cap: f64,
}

/// Groups whose material may call user subroutines.
pub(super) trait CallingGroup {
    type Material: Material;
    type Block: CallingBlock<State = <Self::Material as Material>::State>;

    fn elements(&mut self) -> CallingElements<'_, Self::Material, Self::Block>;

    /// Returns the sums and limits of the last pass.
    fn totals(&self) -> GroupTotals;
}

impl<M: Material> CallingGroup for QuadGroup<M> {
    type Material = M;
    type Block = ElementBlock<M::State>;

    fn elements(&mut self) -> CallingElements<'_, M, ElementBlock<M::State>> {
        let QuadGroup { material, constants, count, blocks, tasks, calls, arch, cap, .. } = self;
        let (calls, count, arch, cap) = (calls.as_deref_mut(), *count, *arch, *cap);
        CallingElements { material: &**material, constants, count, blocks, tasks, calls, arch, cap }
    }

    fn totals(&self) -> GroupTotals {
        QuadGroup::totals(self)
    }
}

/// Implements [`super::group::ElementGroup::update`] for a material that calls user subroutines.
pub(super) fn update_with_calls(group: &mut impl CallingGroup, pass: ElementPass<'_>) -> GroupTotals {
    let now = *pass.now;
    let mut elements = group.elements();
    let failure = elements.update(pass).err().map(|failed| elements.halt(&failed, &now));
    let failed = failure.is_some();
    if let Some(calls) = elements.calls {
        calls.failure = failure;
    }
    let totals = group.totals();
    GroupTotals { rate: if failed { f64::NAN } else { totals.rate }, ..totals }
}

/// Saves the moduli of a user material, which are determined only at time zero.
pub(super) fn persist_called_moduli<G: CallingGroup>(group: &mut G, archive: &mut StateArchive<'_>) {
    if G::Material::CALLS {
        let constants = group.elements().constants;
        persist_fields!(archive; &mut constants.bulk, &mut constants.shear);
    }
}

impl<M: Material, B: CallingBlock<State = M::State>> CallingElements<'_, M, B> {
    /// Updates the elements batch by batch.
    fn update(&mut self, pass: ElementPass<'_>) -> Result<(), CallFailure> {
        let ElementPass { nodes, dt, now, threads, mut user, corners, .. } = pass;
        let CallingElements { material, constants, count, blocks, tasks, calls, arch, cap } = self;
        let (Some(calls), Some(of_material)) = (calls.as_deref_mut(), material.calls()) else { return Ok(()) };
        let (material, count, arch, cap) = (*material, *count, *arch, *cap);
        let pass = &CallPass { material, calls: of_material, constants, count, nodes, now, dt, cap, arch };
        let batch = calls.blocks.len() / TASK;
        let threads = threads && count >= PARALLEL;
        let parts = blocks.chunks_mut(batch * TASK).zip(tasks.chunks_mut(batch));
        let parts = parts.zip(corners.chunks_mut(batch * TASK * B::FORCE_BLOCKS));
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
        let place = element.map_or(String::new(), |element| format!(" at element {element}{point}"));
        let halt = failure.halt(&format!("the user material `{name}`{place}"), now);
        match element {
            Some(element) => halt.at_element(element),
            None => halt,
        }
    }

    /// Returns the largest moduli of all elements, from the response to fictitious strains at time zero, as in
    /// ABAQUS/Explicit.
    fn probe(
        &mut self,
        nodes: &[Node],
        now: &Instant,
        user: &mut PointRoutines<'_>,
    ) -> Result<Option<[f64; 2]>, CallFailure> {
        let CallingElements { material, constants, count, blocks, tasks, calls, arch, cap } = self;
        let (Some(calls), Some(of_material)) = (calls.as_deref_mut(), material.calls()) else { return Ok(None) };
        let (material, count, arch, cap) = (*material, *count, *arch, *cap);
        let pass = CallPass { material, calls: of_material, constants, count, nodes, now, dt: 0.0, cap, arch };
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
                let found = of_material.probe(points, user.lend(), now).and_then(with_shear::<B>);
                largest = larger_moduli(largest, found.map_err(|failure| (number, failure))?);
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
fn with_shear<B: CallingBlock>(moduli: Option<[f64; 2]>) -> Result<Option<[f64; 2]>, LoadFailure> {
    match moduli {
        Some([bulk, shear]) if B::NEEDS_SHEAR && shear <= 1e-9 * bulk => Err(LoadFailure::new(
            "its response to small strains at time zero has no shear modulus, which six-node triangles need",
        )),
        _ => Ok(moduli),
    }
}

impl<G: CallingGroup> UserCalls for G {
    fn probe(&mut self, nodes: &[Node], now: &Instant, mut user: PointRoutines<'_>) -> Result<(), HaltReason> {
        let mut elements = self.elements();
        let moduli = elements.probe(nodes, now, &mut user).map_err(|failed| elements.halt(&failed, now))?;
        if let Some([bulk, shear]) = moduli {
            (elements.constants.bulk, elements.constants.shear) = (bulk, shear);
        }
        Ok(())
    }

    fn failure(&mut self) -> Option<HaltReason> {
        self.elements().calls?.failure.clone()
    }

    fn moduli(&mut self) -> [f64; 2] {
        let constants = self.elements().constants;
        [constants.bulk, constants.shear]
    }

    fn set_moduli(&mut self, [bulk, shear]: [f64; 2]) {
        let constants = self.elements().constants;
        (constants.bulk, constants.shear) = (bulk, shear);
    }
}
