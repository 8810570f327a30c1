//! Groups of solid elements of one shape and one material: their blocks, dispatched to the instruction set of the machine
//! and distributed over threads.

use std::ops::Range;
use std::sync::Arc;

use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

use super::block::ElementBlock;
use super::calls::{CallPass, UserCallBuffers, persist_called_moduli};
use super::constants::{ElementConstants, damped};
use super::criteria::{DeletionCriteria, DeletionFilter};
use super::distorted::lanes_with;
use super::eroded::ErodedLanes;
use super::group::{
    ElementGroup, ElementPass, ElementStiffness, ElementTransfer, ExpansionWork, GroupProperties, GroupSetting,
    GroupTotals, NodalVariable, PARALLEL, SolidElements, UserCalls,
};
use super::lane_sums::{TASK, across, is_larger};
use super::quiescent::TaskQuiescence;
use super::record::BlockRecord;
use super::tiles::{TileTasks, blocks_in_ring, with_ring};
use super::workspace::{StoredTask, TaskWorkspace};
use crate::kernel::lanes::{BlockCornerForces, InlineMap, LANES, Lanes, dispatch_outlined};
use crate::kernel::lists::Memory;
use crate::kernel::topology::{ElementNodes, ElementTopology, PerNode};
use crate::material::available::AvailableEnergy;
use crate::material::user::BlockKinematics;
use crate::material::volumetric::ElementSize;
use crate::material::{Material, PlasticFlow, PointValue};
use crate::mesh::corner_forces::{CornerForces, are_zero};
use crate::state::archive::Persist;
use crate::state::nodes::{Node, NodeAccelerations};
use crate::variables::{Variable, VariableComponent};

/// Initial configuration of the elements of a block.
pub struct InitialBlock<'a, E> {
    /// Number of the first element in the group.
    pub first: usize,
    /// Nodes of at most [`LANES`] elements. Lanes after the last element repeat it.
    pub elements: &'a [E],
    pub nodes: &'a [Node],
    /// Mass per volume.
    pub density: f64,
}

/// Volume of a point of an element, and half of its increase in an increment as a product of three factors. A pressure is
/// multiplied by one after the other, because the last bits depend on the order.
pub struct PointExpansion {
    pub volume: f64,
    pub factor: f64,
    pub span: f64,
    pub dilation: f64,
}

/// Returns the lanes of an element of a group of `count` elements. Lanes after the last element repeat it: the state of
/// another element with its nodes may be invalid.
pub(super) fn lanes_of(element: usize, count: usize) -> Range<usize> {
    let lane = element % LANES;
    lane..if element + 1 == count { LANES } else { lane + 1 }
}

/// Place of a block in its group and in its task.
#[derive(Clone, Copy)]
pub struct BlockPlace {
    /// Number of the block in the group.
    pub number: usize,
    /// Index of the block in its task.
    pub at: usize,
}

/// A block of [`LANES`] solid elements of one shape with their material.
pub trait SolidBlock: Clone + Persist + Send + Sync + 'static {
    /// State of the material of a point.
    type State;
    /// Node indices of an element.
    type Element: AsRef<[u32]> + Into<ElementNodes> + Copy;
    /// Scratch memory of a thread, with the state of the task that it updates.
    type Memory;
    /// Scratch memory of a block before and after calls of user subroutines.
    type CallScratch: Clone + Default + Send + Sync + 'static;
    const TOPOLOGY: ElementTopology;
    /// Number of integration points of an element.
    const POINTS: usize;
    /// Whether corner forces may be stored for a part of the elements only.
    const TILES: bool;
    /// Whether rates and deletion of elements are part of the state of tasks and not of blocks.
    const IN_TASKS: bool;
    /// Whether some motions of the nodes are resisted by the shear stiffness of the material only.
    const NEEDS_SHEAR: bool;

    /// Creates a block of elements at rest.
    fn new<M: Material<State = Self::State>>(
        material: &M,
        constants: &ElementConstants,
        initial: &InitialBlock<'_, Self::Element>,
    ) -> Self;
    /// Returns the nodes of the element in a lane.
    fn element(&self, lane: usize) -> Self::Element;
    /// Returns the masses of the element in a lane at its nodes.
    fn masses(&self, lane: usize) -> PerNode<f64>;
    /// Sets the masses of the element in a lane at its nodes, and increases its rate in proportion.
    fn set_masses(&mut self, lane: usize, masses: &[f64], rates: Option<&mut Lanes>);
    /// Returns the mass of the element in a lane.
    fn mass(&self, lane: usize) -> f64;
    /// Returns the integration points of the elements.
    fn points(&self) -> &[ElementBlock<Self::State>];
    fn points_mut(&mut self) -> &mut [ElementBlock<Self::State>];
    /// Returns the volumes of the points of an element.
    fn volumes(element: Self::Element, nodes: &[Node]) -> impl Iterator<Item = f64>;
    /// Returns the expansion of the points of an element in the increment `dt` that ends at these nodes.
    fn expansions(
        element: Self::Element,
        nodes: &[Node],
        dt: f64,
        by_area: bool,
    ) -> impl Iterator<Item = PointExpansion>;
    /// Returns the bytes of the lists of the block.
    fn bytes(&self) -> usize;
    /// Returns one over the stable time increment of the element in a lane in the last update, without assumed strains; 0
    /// if it is not stored or before the first update.
    fn last_rate(&self, lane: usize, rates: Option<&Lanes>) -> f64;
    /// Returns one over the stable time increment of the element in a lane for elastic constants, with its own masses if
    /// none are given.
    fn elastic_rate(
        &self,
        lane: usize,
        constants: &ElementConstants,
        masses: Option<&[f64]>,
        nodes: &[Node],
    ) -> Option<f64>;
    /// Returns the elastic stiffness of the element in a lane.
    fn stiffness(&self, lane: usize, constants: &ElementConstants, nodes: &[Node]) -> ElementStiffness;
    /// Returns whether [`SolidBlock::erode`] has deleted the element in a lane.
    fn is_eroded(&self, lane: usize, eroded: Option<&ErodedLanes>) -> bool;
    /// Returns whether the element in a lane is deleted.
    fn is_deleted<M: Material<State = Self::State>>(
        &self,
        _material: &M,
        lane: usize,
        eroded: Option<&ErodedLanes>,
    ) -> bool {
        self.is_eroded(lane, eroded)
    }
    /// Returns the lanes whose elements may have a scaled Jacobian of at most `least`, as bits.
    fn may_be_distorted(&self, _least: f64, _nodes: &[Node], _arch: Arch) -> u32 {
        u32::MAX
    }
    /// Deletes an element with this initial volume in all lanes that hold it.
    fn erode(&mut self, lanes: Range<usize>, volume: f64, eroded: Option<&mut ErodedLanes>);

    /// Calls a function with the scratch memory of the thread.
    fn with_memory(of_memory: impl FnOnce(&mut Self::Memory));
    /// Updates the blocks of a task. It is inlined into a function compiled for the selected instruction set.
    fn update_task<M: Material<State = Self::State>>(task: SolidTask<'_, M, Self>);
    /// Computes the kinematics of an increment before calls of user subroutines, and passes those of each point to
    /// `gather`.
    fn measure<M: Material<State = Self::State>>(
        &mut self,
        pass: &CallPass<'_, M>,
        place: BlockPlace,
        memory: (&mut StoredTask, &mut Self::CallScratch),
        gather: &mut dyn FnMut(usize, &mut Self::State, &BlockKinematics<'_>),
    );
    /// Computes stresses and corner forces from the results of the calls. `at` is the index of the block in its task.
    fn respond<M: Material<State = Self::State>>(
        &mut self,
        pass: &CallPass<'_, M>,
        at: usize,
        memory: (&mut StoredTask, &mut Self::CallScratch),
        corners: &mut [BlockCornerForces],
    );
    /// Returns the interface to the variables of a group that move through an adaptive mesh.
    fn transfer<M: Material<State = Self::State>>(
        _group: &mut SolidGroup<M, Self>,
    ) -> Option<&mut dyn ElementTransfer> {
        None
    }
}

/// Solid elements of one shape and one material.
#[derive(Persist)]
#[persist(
    fixed: blocks, tasks, listed, quiescence;
    derived: material, constants, calls, count, arch, erodible;
    then: persist_called_moduli
)]
pub struct SolidGroup<M: Material, B: SolidBlock<State = M::State>> {
    pub(super) material: Arc<M>,
    pub(super) constants: ElementConstants,
    pub(super) count: usize,
    pub(super) blocks: Vec<B>,
    pub(super) tasks: Vec<StoredTask>,
    /// Buffers of user subroutines; `None` without user subroutines.
    pub(super) calls: Option<Box<UserCallBuffers<B::CallScratch>>>,
    pub(super) arch: Arch,
    /// Elements that [`ElementGroup::newly_deleted`] has already listed.
    listed: Vec<bool>,
    quiescence: Vec<TaskQuiescence>,
    /// Whether `*EROSION` may delete elements.
    erodible: bool,
    /// Bound of the highest frequency of the whole model.
    pub(super) cap: f64,
}

impl<M: Material, B: SolidBlock<State = M::State>> SolidGroup<M, B> {
    /// Returns whether the pressure is part of the material state; with an equation of state the mass too.
    fn holds_pressure(&self) -> bool {
        let is_elastic = !matches!(M::FLOW, PlasticFlow::Coupled | PlasticFlow::Unknown);
        M::MODULI_VARY && (is_elastic || self.material.holds_pressure())
    }

    /// Creates a group from the nodes of its elements in the initial configuration: corners of quadrilaterals, or nodes
    /// around six-node triangles, counter-clockwise.
    pub fn new(
        material: M,
        constants: ElementConstants,
        density: f64,
        elements: &[B::Element],
        nodes: &[Node],
    ) -> Self {
        let block = |(index, elements): (usize, &[B::Element])| {
            let initial = InitialBlock { first: index * LANES, elements, nodes, density };
            B::new(&material, &constants, &initial)
        };
        let blocks: Vec<B> = elements.chunks(LANES).enumerate().map(block).collect();
        SolidGroup {
            calls: UserCallBuffers::new(&material, B::POINTS, elements.len()),
            material: Arc::new(material),
            constants,
            count: elements.len(),
            tasks: blocks.chunks(TASK).map(|part| StoredTask::new(&constants, B::POINTS * part.len())).collect(),
            blocks,
            arch: Arch::new(),
            quiescence: TaskQuiescence::of_tasks(elements),
            listed: if M::FAILS { vec![false; elements.len()] } else { Vec::new() },
            erodible: false,
            cap: f64::INFINITY,
        }
    }

    /// Selects another instruction set; results have the same bits.
    #[must_use]
    pub fn on(mut self, arch: Arch) -> Self {
        self.arch = arch;
        self
    }

    /// Keeps all tasks active, by adding a moving node to each; for tests of single increments.
    pub fn keep_awake(&mut self, node: u32) {
        self.quiescence.iter_mut().for_each(|resting| resting.nodes.push(node));
    }

    /// Makes a task active.
    pub(super) fn wake(&mut self, task: usize) {
        self.quiescence[task].quiescent = false;
    }

    fn block(&self, element: usize) -> (&B, usize) {
        (&self.blocks[element / LANES], element % LANES)
    }

    fn eroded_lanes(&self, element: usize) -> Option<&ErodedLanes> {
        let block = element / LANES;
        self.tasks[block / TASK].task.eroded.get(block % TASK)
    }

    fn is_deleted(&self, element: usize) -> bool {
        let (block, lane) = self.block(element);
        block.is_deleted(&*self.material, lane, self.eroded_lanes(element))
    }

    fn last_rate(&self, element: usize) -> f64 {
        let ((block, lane), index) = (self.block(element), element / LANES);
        block.last_rate(lane, self.tasks[index / TASK].task.own_rates.get(index % TASK))
    }

    /// Returns one over the stable time increment of an element with these masses, whose pressure follows from an equation of
    /// state, at its current density and energy.
    fn rate_of_eos(&self, element: usize, masses: &[f64], nodes: &[Node]) -> Option<f64> {
        let (block, lane) = self.block(element);
        let mut bulk: f64 = 0.0;
        for (point, volume) in block.points().iter().zip(B::volumes(block.element(lane), nodes)) {
            let size = ElementSize { volume, mass: point.mass[lane] };
            bulk = bulk.max(self.material.bulk_modulus(&point.state, lane, size)?);
        }
        block.elastic_rate(lane, &ElementConstants { bulk, ..self.constants }, Some(masses), nodes)
    }

    /// Returns the mass-weighted mean over the points of an element; `None` if a point has no value.
    fn mean(&self, element: usize, of_point: impl Fn(usize) -> Option<f64>) -> Option<f64> {
        if B::POINTS == 1 {
            return of_point(0);
        }
        let (block, lane) = self.block(element);
        let (mut sum, mut mass) = (0.0, 0.0);
        for (p, point) in block.points().iter().enumerate() {
            sum += point.mass[lane] * of_point(p)?;
            mass += point.mass[lane];
        }
        Some(sum / mass)
    }

    /// Returns a recorded value of a point of an element.
    fn recorded(&self, element: usize, point: usize, part: VariableComponent) -> Option<f64> {
        let block = element / LANES;
        let records = &self.tasks[block / TASK].task.records;
        records.get(B::POINTS * (block % TASK) + point)?.of(element % LANES).value(part)
    }

    /// Returns the sums and limits of the last pass: those of the tasks in their order.
    pub(super) fn totals(&self) -> GroupTotals {
        let ElementConstants { bulk, shear, bulk_viscosity, .. } = self.constants;
        let still = self.cap * damped(bulk_viscosity.linear * (bulk + 4.0 / 3.0 * shear) / bulk);
        let mut totals = GroupTotals::default();
        let mut largest = 0.0;
        for (stored, resting) in self.tasks.iter().zip(&self.quiescence) {
            let (sums, deformed) = stored.parts();
            let limit = if resting.quiescent { still } else { f64::INFINITY };
            let [strain, dilation] =
                deformed.inline_map(|list| list.iter().fold(0.0, |largest: f64, x| largest.max(*x)).sqrt());
            totals.deformed = totals.deformed.max(strain + 0.5 * dilation);
            totals.internal += across(&sums.internal);
            totals.plastic += across(&sums.plastic);
            totals.damaged += across(&sums.damaged);
            totals.viscous += across(&sums.viscous);
            totals.artificial += across(&sums.artificial);
            for (l, (&rate, &block)) in sums.rate.iter().zip(&sums.limiting).enumerate() {
                let rate = if rate > limit { limit } else { rate };
                if is_larger(rate, largest) {
                    largest = rate;
                    totals.limiting = block as usize * LANES + l;
                }
            }
        }
        totals.rate = self.constants.with_assumed(0.5 * largest, self.cap);
        totals
    }

    /// Calls a function with each task and its number of integration points, in blocks.
    fn for_tasks(&mut self, mut of_task: impl FnMut(&mut StoredTask, usize)) {
        let parts = self.tasks.iter_mut().zip(self.blocks.chunks(TASK));
        parts.for_each(|(stored, blocks)| of_task(stored, B::POINTS * blocks.len()));
    }
}

impl<M: Material, B: SolidBlock<State = M::State>> Clone for SolidGroup<M, B> {
    fn clone(&self) -> Self {
        SolidGroup {
            material: Arc::clone(&self.material),
            calls: self.calls.clone(),
            constants: self.constants,
            count: self.count,
            blocks: self.blocks.clone(),
            tasks: self.tasks.clone(),
            arch: self.arch,
            listed: self.listed.clone(),
            quiescence: self.quiescence.clone(),
            erodible: self.erodible,
            cap: self.cap,
        }
    }
}

impl<M: Material, B: SolidBlock<State = M::State>> ElementGroup for SolidGroup<M, B> {
    fn len(&self) -> usize {
        self.count
    }

    fn properties(&self) -> GroupProperties {
        GroupProperties {
            topology: B::TOPOLOGY,
            deletable: self.material.can_delete() || self.erodible,
            damped: self.constants.damps(),
            holds_pressure: self.holds_pressure(),
            equation_of_state: M::EQUATION_OF_STATE,
            fields: self.material.calls().map_or(0, |calls| calls.fields()),
            // Equations of state use the corner forces of the previous pass.
            tiles: B::TILES && !M::CALLS && !M::EQUATION_OF_STATE,
        }
    }

    fn nodes(&self, element: usize) -> ElementNodes {
        let (block, lane) = self.block(element);
        block.element(lane).into()
    }

    fn masses(&self, element: usize) -> PerNode<f64> {
        let (block, lane) = self.block(element);
        block.masses(lane)
    }

    fn set_masses(&mut self, element: usize, masses: &[f64]) {
        let block = element / LANES;
        // The stable time increment of a quiescent task has changed.
        self.wake(block / TASK);
        let rates = self.tasks[block / TASK].task.own_rates.get_mut(block % TASK);
        self.blocks[block].set_masses(element % LANES, masses, rates);
    }

    fn update(&mut self, pass: ElementPass<'_>) -> GroupTotals {
        if M::CALLS {
            return self.update_with_calls(pass);
        }
        let ElementPass { nodes, dt, before, now, threads, corners, tiles, dilation_correction, prefetches, .. } = pass;
        let (arch, count, tiled) = (self.arch, self.count, tiles.is_some());
        let increment = SolidIncrement { nodes, dt, before, time: now.total_time, cap: self.cap, arch, count };
        let blocks = BlockPass { material: &*self.material, constants: &self.constants, increment };
        let pass = SolidPass { blocks, dilation_correction, prefetches, tiled };
        let run = |task: TaskSlices<'_, B>| {
            let TaskSlices { index, blocks, stored, quiescence, corners } = task;
            if quiescence.quiescent && dilation_correction.is_none() && quiescence.is_still(nodes) {
                if tiled {
                    corners.fill(BlockCornerForces::default());
                }
                return;
            }
            B::with_memory(|memory| {
                let (blocks, corners) = (&mut *blocks, &mut *corners);
                dispatch_outlined(arch, SolidTask { pass: &pass, index, blocks, corners, stored, memory });
            });
            let free = |point: &ElementBlock<M::State>| point.stress.as_flattened().iter().all(|x| *x == 0.0);
            // With dt = 0 nothing has been added to the sums, so they stay valid while the task is quiescent. The
            // pressure of an equation of state is not part of the stress that is checked here.
            quiescence.quiescent = dt == 0.0
                && dilation_correction.is_none()
                && !M::MODULI_VARY
                && are_zero(corners)
                && blocks.iter().flat_map(B::points).all(free)
                && quiescence.is_still(nodes);
            if B::TILES && quiescence.quiescent {
                // Zeros of one sign, as above.
                corners.fill(BlockCornerForces::default());
            }
        };
        let threads = threads && count >= PARALLEL;
        let SolidGroup { blocks, tasks, quiescence, .. } = self;
        let forces = TASK * B::TOPOLOGY.force_blocks();
        if let Some(tiles) = tiles {
            TaskLists { blocks, tasks, quiescence, tiles: tiles.all(corners) }.update(threads, &run);
        } else if !threads {
            let parts = blocks.chunks_mut(TASK).zip(corners.chunks_mut(forces));
            let stored = tasks.iter_mut().zip(quiescence);
            for (index, ((blocks, corners), (stored, quiescence))) in parts.zip(stored).enumerate() {
                run(TaskSlices { index, blocks, stored, quiescence, corners });
            }
        } else {
            let parts = blocks.par_chunks_mut(TASK).zip(corners.par_chunks_mut(forces));
            let stored = tasks.par_iter_mut().zip(quiescence);
            parts.zip(stored).enumerate().for_each(|(index, ((blocks, corners), (stored, quiescence)))| {
                run(TaskSlices { index, blocks, stored, quiescence, corners });
            });
        }
        self.totals()
    }

    fn value(&self, element: usize, part: VariableComponent) -> Option<f64> {
        let (block, lane) = self.block(element);
        let points = block.points();
        let of_point = |p: usize| {
            let of_material = self.material.value(&points[p].state, lane, part);
            of_material.or_else(|| self.recorded(element, p, part))
        };
        let combined = |combine: fn(f64, f64) -> f64| {
            (1..B::POINTS).try_fold(of_point(0)?, |sum, p| Some(combine(sum, of_point(p)?)))
        };
        match part.variable {
            Variable::Stress => self.mean(element, |p| Some(points[p].stress.get(part.component)?[lane])),
            Variable::Mass => Some(block.mass(lane)),
            Variable::Status => Some(f64::from(u8::from(!self.is_deleted(element)))),
            Variable::PlasticComponents if matches!(M::FLOW, PlasticFlow::None | PlasticFlow::Unknown) => None,
            // For user materials, the recorded energy includes the dissipation that only the material knows.
            Variable::ElementStrainEnergy if M::FLOW == PlasticFlow::Unknown => {
                let dissipated = self.value(element, Variable::ElementPlasticEnergy.into())?;
                Some(combined(|a, b| a + b)? - dissipated)
            }
            Variable::ElementStrainEnergy
            | Variable::ElementPlasticEnergy
            | Variable::ElementArtificialEnergy
            | Variable::ElementDamageEnergy => combined(|a, b| a + b),
            Variable::Degradation
            | Variable::DamageInitiation
            | Variable::DuctileInitiation
            | Variable::JohnsonCookInitiation => combined(f64::max),
            _ => self.mean(element, of_point),
        }
    }

    fn set(&mut self, element: usize, value: PointValue) -> bool {
        let lanes = match value {
            PointValue::VolumeRatio(_) | PointValue::MassScale(_) => lanes_of(element, self.count),
            _ => element % LANES..element % LANES + 1,
        };
        let points = self.blocks[element / LANES].points_mut();
        let points = match value {
            PointValue::Length(point, _) => &mut points[point..=point],
            _ => points,
        };
        if let PointValue::Stress(stress) = value {
            for point in &mut *points {
                point.stress.iter_mut().zip(stress).for_each(|(list, value)| list[lanes.start] = value);
            }
        }
        let material = &*self.material;
        points.iter_mut().all(|point| lanes.clone().all(|lane| material.set(&mut point.state, lane, value)))
    }

    fn stable_rate(&self, element: usize, masses: Option<&[f64]>, nodes: &[Node]) -> Option<f64> {
        let (block, lane) = self.block(element);
        match masses {
            Some(_) if self.constants.by_area => return None,
            Some(masses) if M::EQUATION_OF_STATE => return self.rate_of_eos(element, masses, nodes),
            None if self.holds_pressure() => return Some(self.last_rate(element)),
            _ => {}
        }
        let constants = ElementConstants { bulk: self.constants.bulk + self.material.initial_bulk(), ..self.constants };
        let initial = |masses: Option<&[f64]>| block.elastic_rate(lane, &constants, masses, nodes);
        let rate = if self.holds_pressure() { self.last_rate(element) } else { 0.0 };
        if rate > 0.0 {
            // The last update found the current stiffness of rubber.
            let current = self.constants.with_assumed(rate, f64::INFINITY);
            return Some(initial(masses)? * current / initial(None)?);
        }
        initial(masses)
    }

    fn stiffness(&self, element: usize, nodes: &[Node]) -> Option<ElementStiffness> {
        if self.holds_pressure() || self.constants.by_area {
            return None;
        }
        if self.is_deleted(element) {
            return Some(ElementStiffness::ZERO);
        }
        let (block, lane) = self.block(element);
        Some(block.stiffness(lane, &self.constants, nodes))
    }

    fn is_quiescent(&self, task: usize) -> bool {
        self.quiescence[task].quiescent
    }

    fn available_energy(&self, element: usize, nodes: &[Node]) -> AvailableEnergy {
        let (block, lane) = self.block(element);
        let mut sum = AvailableEnergy::NONE;
        for (point, volume) in block.points().iter().zip(B::volumes(block.element(lane), nodes)) {
            let mass = point.mass[lane];
            let AvailableEnergy { energy, from } = self.material.available_energy(&point.state, lane, volume / mass);
            let of_stress = volume * self.constants.elastic_energy(point.stress.inline_map(|list| list[lane]));
            sum = AvailableEnergy { energy: sum.energy + mass * energy + of_stress, from };
        }
        sum
    }

    fn configure(&mut self, setting: GroupSetting) {
        match setting {
            GroupSetting::Records => {
                self.for_tasks(|stored, points| stored.task.records = vec![BlockRecord::default(); points]);
            }
            GroupSetting::StableRates => {
                if B::IN_TASKS && self.holds_pressure() && !M::EQUATION_OF_STATE {
                    self.for_tasks(|stored, blocks| stored.task.store_rates(blocks));
                }
            }
            GroupSetting::Deletion => {
                self.erodible = true;
                if B::IN_TASKS {
                    self.for_tasks(|stored, blocks| stored.task.make_erodible(blocks));
                    if self.holds_pressure() {
                        self.for_tasks(|stored, blocks| stored.task.store_rates(blocks));
                    }
                }
            }
            GroupSetting::MassScales => {
                let points = self.blocks.iter_mut().flat_map(|block| block.points_mut());
                points.for_each(|point| self.material.prepare_scaling(&mut point.state));
            }
            GroupSetting::HighestFrequency(frequency) => self.cap = self.constants.cap(frequency),
            GroupSetting::Instructions(arch) => self.arch = arch,
        }
    }

    fn erode(&mut self, element: usize, volume: f64) {
        let (block, lanes) = (element / LANES, lanes_of(element, self.count));
        self.wake(block / TASK);
        let eroded = self.tasks[block / TASK].task.eroded.get_mut(block % TASK);
        self.blocks[block].erode(lanes, volume, eroded);
        if let Some(listed) = self.listed.get_mut(element) {
            *listed = true;
        }
    }

    fn newly_deleted(&mut self, deleted: &mut Vec<ElementNodes>) {
        if !M::FAILS || self.tasks.iter().all(|stored| stored.deleted == 0) {
            return;
        }
        for element in 0..self.count {
            if !self.listed[element] && self.is_deleted(element) {
                self.listed[element] = true;
                deleted.push((self as &dyn ElementGroup).boundary(element));
            }
        }
    }

    fn as_solid(&mut self) -> Option<&mut dyn SolidElements> {
        Some(self)
    }

    fn bytes(&self) -> usize {
        let of_tasks: usize = self.tasks.iter().map(|stored| stored.task.bytes()).sum();
        let quiescence: usize = self.quiescence.iter().map(TaskQuiescence::bytes).sum();
        let points = self.blocks.iter().flat_map(B::points);
        let states: usize = points.map(|point| self.material.bytes(&point.state)).sum();
        let of_blocks: usize = self.blocks.iter().map(B::bytes).sum();
        let calls = self.calls.as_ref().map_or(0, |calls| calls.bytes());
        let names = self.material.calls().map_or(0, |calls| calls.bytes());
        let arrays = size_of_val(&*self.blocks) + size_of_val(&*self.tasks) + self.listed.capacity();
        arrays + of_tasks + quiescence + states + of_blocks + calls + names
    }

    fn copy(&self) -> Box<dyn ElementGroup> {
        Box::new(self.clone())
    }
}

impl<M: Material, B: SolidBlock<State = M::State>> DeletionFilter for SolidGroup<M, B> {
    fn may_meet(&self, criteria: &DeletionCriteria, block: usize, nodes: &[Node]) -> u32 {
        let DeletionCriteria { distortion, plastic, strain, increment } = *criteria;
        if strain.is_some() || increment.is_some() || B::POINTS > 1 {
            return u32::MAX;
        }
        let (of_block, first) = (&self.blocks[block], block * LANES);
        let is_strained = |lane: usize, most: f64| {
            let strain = self.material.value(&of_block.points()[0].state, lane, Variable::PlasticStrain.into());
            let strain = strain.or_else(|| self.recorded(first + lane, 0, Variable::PlasticStrain.into()));
            strain.is_some_and(|strain| strain >= most)
        };
        let strained = plastic.map_or(0, |most| lanes_with(|lane| is_strained(lane, most)));
        strained | distortion.map_or(0, |least| of_block.may_be_distorted(least, nodes, self.arch))
    }
}

impl<M: Material, B: SolidBlock<State = M::State>> SolidElements for SolidGroup<M, B> {
    fn temperatures(&self, out: &mut [f64]) {
        for (e, out) in out.iter_mut().enumerate() {
            let (block, lane) = self.block(e);
            let of_point = |p: usize| self.material.value(&block.points()[p].state, lane, Variable::Temperature.into());
            *out = self.mean(e, of_point).unwrap_or(*out);
        }
    }

    fn set_means(&mut self, variable: NodalVariable, means: &[f64]) {
        for (element, mean) in means.iter().enumerate() {
            let value = match variable {
                NodalVariable::Temperature => PointValue::NodalTemperature(*mean),
                NodalVariable::Field(field) => PointValue::NodalField(field, *mean),
            };
            self.set(element, value);
        }
    }

    /// Subtracts the thermal strain. For isotropic expansion, it is equivalent to a pressure that is subtracted from
    /// the stress beforehand: the trial stress is identical. The returned work corrects the trapezoidal rule, which
    /// uses the reduced stress.
    fn expand(&mut self, strains: &[f64], nodes: &[Node], dt: f64) -> ExpansionWork {
        let mut work = ExpansionWork::default();
        let ElementConstants { bulk, by_area, .. } = self.constants;
        for (e, strain) in strains.iter().enumerate().filter(|s| *s.1 != 0.0) {
            let (index, lane) = (e / LANES, e % LANES);
            if self.blocks[index].is_eroded(lane, self.eroded_lanes(e)) {
                continue;
            }
            let is_subtracted_later = self.set(e, PointValue::ThermalStrain(*strain));
            self.wake(index / TASK);
            let (block, task) = (&mut self.blocks[index], &mut self.tasks[index / TASK].task);
            let expansions = B::expansions(block.element(lane), nodes, dt, by_area);
            for (p, (point, expansion)) in block.points_mut().iter_mut().zip(expansions).enumerate() {
                let PointExpansion { volume, factor, span, dilation } = expansion;
                let pressure = self.material.mean_share(&point.state, lane) * 3.0 * bulk * strain;
                let sum = (point.stress[0][lane] + point.stress[1][lane]) + point.stress[2][lane];
                work.supplied -= volume * strain * (sum - 1.5 * pressure);
                if is_subtracted_later {
                    continue;
                }
                point.stress[..3].iter_mut().for_each(|list| list[lane] -= pressure);
                let omitted = factor * pressure * span * dilation;
                work.omitted += omitted;
                task.add_to_record(B::POINTS * (index % TASK) + p, lane, [omitted, 0.0]);
            }
        }
        work
    }

    fn user(&mut self) -> Option<&mut dyn UserCalls> {
        if M::CALLS { Some(self) } else { None }
    }

    fn transfer(&mut self) -> Option<&mut dyn ElementTransfer> {
        B::transfer(self)
    }
}

/// Input of an increment that all blocks of a group share, without their material.
#[derive(Clone, Copy)]
pub struct SolidIncrement<'a> {
    pub nodes: &'a [Node],
    /// Length of the increment, and the accelerations that moved the nodes over it.
    pub dt: f64,
    pub before: NodeAccelerations<'a>,
    /// Total time at the end of the increment.
    pub time: f64,
    /// Bound of the highest frequency of the whole model.
    pub cap: f64,
    pub arch: Arch,
    /// Number of elements of the group.
    pub count: usize,
}

impl SolidIncrement<'_> {
    /// Begins the update of a task or a block with its own workspace.
    #[inline(always)]
    pub(super) fn begin(&self, constants: &ElementConstants, work: &mut TaskWorkspace) {
        work.begin(self.arch, self.cap, self.dt, constants);
    }
}

/// Input that all blocks of a group share.
#[derive(Clone, Copy)]
pub struct BlockPass<'a, M> {
    pub material: &'a M,
    pub constants: &'a ElementConstants,
    pub increment: SolidIncrement<'a>,
}

/// Input that all tasks of a pass share.
pub struct SolidPass<'a, M> {
    pub blocks: BlockPass<'a, M>,
    pub dilation_correction: Option<&'a [Lanes]>,
    pub prefetches: bool,
    /// Whether corner forces are in a ring.
    pub tiled: bool,
}

/// Update of the blocks of one task.
pub struct SolidTask<'a, M: Material, B: SolidBlock<State = M::State>> {
    pub pass: &'a SolidPass<'a, M>,
    pub index: usize,
    pub blocks: &'a mut [B],
    pub corners: &'a mut [BlockCornerForces],
    pub stored: &'a mut StoredTask,
    pub memory: &'a mut B::Memory,
}

impl<M: Material, B: SolidBlock<State = M::State>> NullaryFnOnce for SolidTask<'_, M, B> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        B::update_task(self);
    }
}

/// Blocks, state and corner forces of one task.
struct TaskSlices<'a, B> {
    /// Number of the task in the group.
    index: usize,
    blocks: &'a mut [B],
    stored: &'a mut StoredTask,
    quiescence: &'a mut TaskQuiescence,
    corners: &'a mut [BlockCornerForces],
}

/// Lists of the tasks of some tiles.
struct TaskLists<'a, B> {
    blocks: &'a mut [B],
    tasks: &'a mut [StoredTask],
    quiescence: &'a mut [TaskQuiescence],
    tiles: TileTasks<'a>,
}

impl<B: Send> TaskLists<'_, B> {
    /// Updates the tasks by `run`, on several threads if permitted. Tiles are divided among threads by halves.
    fn update(self, threads: bool, run: &(impl Fn(TaskSlices<'_, B>) + Sync)) {
        let Some(count) = self.tiles.half() else { return with_ring(|ring| self.update_tile(ring, run)) };
        let (first, second) = self.split(count);
        if threads {
            rayon::join(|| first.update(threads, run), || second.update(threads, run));
        } else {
            first.update(threads, run);
            second.update(threads, run);
        }
    }

    fn update_tile(mut self, ring: &mut CornerForces, run: &impl Fn(TaskSlices<'_, B>)) {
        let stored = self.tasks.iter_mut().zip(self.quiescence);
        let parts = self.blocks.chunks_mut(TASK).zip(stored);
        for (index, (blocks, (stored, quiescence))) in self.tiles.tasks.clone().zip(parts) {
            let corners = ring.slots(blocks_in_ring(index, blocks.len()));
            run(TaskSlices { index, blocks, stored, quiescence, corners });
            self.tiles.complete(index, ring);
        }
    }

    /// Divides the tasks after the first `count`.
    fn split(self, count: usize) -> (Self, Self) {
        let TaskLists { blocks, tasks, quiescence, tiles } = self;
        let blocks = blocks.split_at_mut(count * TASK);
        let (tasks, quiescence) = (tasks.split_at_mut(count), quiescence.split_at_mut(count));
        let tiles = tiles.split(count);
        (
            TaskLists { blocks: blocks.0, tasks: tasks.0, quiescence: quiescence.0, tiles: tiles.0 },
            TaskLists { blocks: blocks.1, tasks: tasks.1, quiescence: quiescence.1, tiles: tiles.1 },
        )
    }
}

#[cfg(test)]
mod tests {
    use super::lanes_of;
    use crate::kernel::lanes::LANES;

    #[test]
    fn lanes_after_the_last_element_repeat_it() {
        let (full, part) = (2 * LANES, 2 * LANES - 3);
        assert_eq!(lanes_of(LANES + 2, full), 2..3);
        assert_eq!(lanes_of(full - 1, full), LANES - 1..LANES);
        assert_eq!(lanes_of(part - 1, part), LANES - 4..LANES);
        assert_eq!(lanes_of(part - 2, part), LANES - 5..LANES - 4);
    }
}
