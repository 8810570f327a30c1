//! A group of six-node triangles: its blocks, distributed over threads, and its implementation of the group interface.

use crate::kernel::lists::Memory;
use std::cell::RefCell;
use std::f64::consts::PI;
use std::sync::Arc;

use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

use super::block::TriangleBlock;
use super::calls::TriangleScratch;
use super::triangles::{FORCE_BLOCKS, TriangleIncrement, WorkArrays, operators_at, places};
use crate::element::block::{StoredTask, TASK, TaskWorkspace};
use crate::element::calls::{CallingElements, CallingGroup, UserCallBuffers, persist_called_moduli, update_with_calls};
use crate::element::constants::{ElementConstants, damped};
use crate::element::group::{
    ElementFields, ElementGroup, ElementPass, ElementStiffness, ElementTemperatures, EnergySource, ExpansionWork,
    GroupDeletion, GroupExtensions, GroupProperties, GroupSettings, GroupTotals, InitialState, InterfaceElements,
    PARALLEL, UserCalls, list_deleted, totals,
};
use crate::element::quiescent::TaskQuiescence;
use crate::element::record::BlockRecord;
use crate::kernel::bulk_viscosity::BulkViscosity;
use crate::kernel::lanes::{BlockCornerForces, InlineMap, LANES, dispatch_outlined};
use crate::kernel::six_node_triangle::{NODES, POINTS, TriangleOperators, frequency_squared, stiffness};
use crate::kernel::topology::{ElementNodes, ElementTopology, PerNode};
use crate::material::available::AvailableEnergy;
use crate::material::{Material, PlasticFlow, PointValue};
use crate::mesh::corner_forces::are_zero;
use crate::state::archive::Persist;
use crate::state::nodes::Node;
use crate::variables::{Variable, VariableComponent};

/// Group of six-node triangles with the same material.
#[derive(Persist)]
#[persist(
    fixed: blocks, tasks, listed, quiescence;
    derived: material, constants, calls, count, arch, erodible;
    then: persist_called_moduli
)]
pub struct SixNodeTriangles<M: Material> {
    material: Arc<M>,
    constants: ElementConstants,
    count: usize,
    blocks: Vec<TriangleBlock<M::State>>,
    tasks: Vec<StoredTask>,
    quiescence: Vec<TaskQuiescence>,
    /// Buffers of user subroutines; `None` without user subroutines.
    calls: Option<Box<UserCallBuffers<TriangleScratch>>>,
    arch: Arch,
    /// Elements whose deletion has been listed.
    listed: Vec<bool>,
    erodible: bool,
    /// Bound of the highest frequency of the whole model.
    cap: f64,
}

thread_local! {
    /// Scratch memory of the tasks that a thread updates one after the other.
    static SCRATCH: RefCell<(TaskWorkspace, WorkArrays)> = RefCell::default();
}

impl<M: Material> SixNodeTriangles<M> {
    /// Whether the pressure is part of the material state; with an equation of state the mass too.
    const HOLDS_PRESSURE: bool = M::MODULI_VARY && !matches!(M::FLOW, PlasticFlow::Coupled | PlasticFlow::Unknown);

    /// Creates a group from the nodes of its elements (around the boundary, counter-clockwise, from a corner) in the
    /// initial configuration.
    pub fn new(
        material: M,
        constants: ElementConstants,
        density: f64,
        elements: &[[u32; NODES]],
        nodes: &[Node],
    ) -> Self {
        let block = |(index, part): (usize, &[_])| TriangleBlock::new(&material, density, (index * LANES, part), nodes);
        let blocks: Vec<_> = elements.chunks(LANES).enumerate().map(block).collect();
        // The constants need no hourglass control: there are no hourglass modes.
        SixNodeTriangles {
            tasks: blocks.chunks(TASK).map(|part| StoredTask::new(&constants, POINTS * part.len())).collect(),
            quiescence: TaskQuiescence::of_tasks(elements),
            calls: UserCallBuffers::new(&material, POINTS, elements.len()),
            constants,
            count: elements.len(),
            blocks,
            arch: Arch::new(),
            listed: if M::FAILS { vec![false; elements.len()] } else { Vec::new() },
            erodible: false,
            cap: f64::INFINITY,
            material: Arc::new(material),
        }
    }

    fn block(&self, element: usize) -> (&TriangleBlock<M::State>, usize) {
        (&self.blocks[element / LANES], element % LANES)
    }

    fn block_mut(&mut self, element: usize) -> (&mut TriangleBlock<M::State>, usize) {
        (&mut self.blocks[element / LANES], element % LANES)
    }

    /// Returns the mass-weighted mean over the points of an element; `None` if a point has no value.
    fn mean(&self, element: usize, of: impl Fn(usize) -> Option<f64>) -> Option<f64> {
        let (block, lane) = self.block(element);
        let (mut sum, mut mass) = (0.0, 0.0);
        for p in 0..POINTS {
            sum += block.points[p].mass[lane] * of(p)?;
            mass += block.points[p].mass[lane];
        }
        Some(sum / mass)
    }

    /// Returns a recorded value of a point of an element.
    fn followed(&self, element: usize, p: usize, part: VariableComponent) -> Option<f64> {
        let (task, at) = (&self.tasks[element / (TASK * LANES)], element / LANES % TASK);
        task.task.records.get(POINTS * at + p)?.of(element % LANES).value(part)
    }

    /// Returns the operators of an element at the current positions.
    fn operators(&self, element: usize, nodes: &[Node]) -> TriangleOperators {
        let (block, lane) = self.block(element);
        operators_at(places(block.triangles.element(lane), nodes))
    }

    /// Sets a value of all points of an element. Returns whether its material uses it.
    fn set_value(&mut self, element: usize, value: PointValue) -> bool {
        let (block, lane) = (&mut self.blocks[element / LANES], element % LANES);
        block.points.iter_mut().all(|point| self.material.set(&mut point.state, lane, value))
    }

    fn wake(&mut self, element: usize) {
        self.quiescence[element / (TASK * LANES)].quiescent = false;
    }
}

impl<M: Material> Clone for SixNodeTriangles<M> {
    fn clone(&self) -> Self {
        SixNodeTriangles {
            material: Arc::clone(&self.material),
            constants: self.constants,
            count: self.count,
            blocks: self.blocks.clone(),
            tasks: self.tasks.clone(),
            quiescence: self.quiescence.clone(),
            calls: self.calls.clone(),
            arch: self.arch,
            listed: self.listed.clone(),
            erodible: self.erodible,
            cap: self.cap,
        }
    }
}

/// Returns one over the stable time increment of an element with these moduli, inverse masses and linear bulk viscosity.
#[inline(never)]
fn elastic_rate(operators: &TriangleOperators, moduli: [f64; 2], inverse: &[f64; NODES], linear: f64) -> f64 {
    0.5 * frequency_squared(operators, moduli, inverse).sqrt() * damped(linear)
}

/// Update of the blocks of one task.
struct TaskPass<'a, M: Material> {
    material: &'a M,
    constants: &'a ElementConstants,
    increment: &'a TriangleIncrement<'a>,
    cap: f64,
    index: usize,
    blocks: &'a mut [TriangleBlock<M::State>],
    corners: &'a mut [BlockCornerForces],
    stored: &'a mut StoredTask,
    memory: &'a mut (TaskWorkspace, WorkArrays),
}

/// Number of a task, its blocks, corner forces and state.
type NumberedTask<'a, S> =
    (usize, ((&'a mut [TriangleBlock<S>], &'a mut [BlockCornerForces]), (&'a mut StoredTask, &'a mut TaskQuiescence)));

impl<M: Material> NullaryFnOnce for TaskPass<'_, M> {
    type Output = ();

    /// Updates the blocks of the task. It is inlined into a function compiled for the selected instruction set.
    #[inline(always)]
    fn call(self) {
        let TaskPass { material, constants, increment, cap, index, blocks, corners, stored, memory } = self;
        let (scratch, work) = memory;
        stored.exchange(scratch);
        scratch.begin(increment.arch, cap, increment.dt, constants);
        for (at, (block, corners)) in blocks.iter_mut().zip(corners.chunks_mut(FORCE_BLOCKS)).enumerate() {
            let place = (index * TASK + at, at);
            block.update(material, constants, increment, place, (&mut *scratch, &mut *work), corners);
        }
        stored.exchange(scratch);
        stored.set_sums(scratch);
    }
}

impl<M: Material> InterfaceElements for SixNodeTriangles<M> {}

impl<M: Material> EnergySource for SixNodeTriangles<M> {
    fn available_energy(&self, element: usize, nodes: &[Node]) -> AvailableEnergy {
        let (block, lane) = self.block(element);
        let operators = operators_at(block.triangles.element(lane).inline_map(|n| nodes[n as usize].place()));
        let mut sum = AvailableEnergy::NONE;
        for (p, point) in block.points.iter().enumerate() {
            let (volume, mass) = (2.0 * PI * operators.volume[p], point.mass[lane]);
            let AvailableEnergy { energy, from } = self.material.available_energy(&point.state, lane, volume / mass);
            let of_stress = volume * self.constants.elastic_energy(point.stress.inline_map(|list| list[lane]));
            sum = AvailableEnergy { energy: sum.energy + mass * energy + of_stress, from };
        }
        sum
    }
}

impl<M: Material> ElementGroup for SixNodeTriangles<M> {
    fn len(&self) -> usize {
        self.count
    }

    fn properties(&self) -> GroupProperties {
        GroupProperties {
            topology: ElementTopology::SixNodeTriangle,
            deletable: self.material.can_delete() || self.erodible,
            damped: self.constants.damps(),
            holds_pressure: Self::HOLDS_PRESSURE,
            fields: self.material.calls().map_or(0, |calls| calls.fields()),
            tiles: false,
        }
    }

    fn nodes(&self, element: usize) -> ElementNodes {
        let (block, lane) = self.block(element);
        block.triangles.element(lane).into()
    }

    fn masses(&self, element: usize) -> PerNode<f64> {
        let (block, lane) = self.block(element);
        block.triangles.inverse_masses(lane).inline_map(|inverse| 1.0 / inverse).into()
    }

    fn update(&mut self, pass: ElementPass<'_>) -> GroupTotals {
        if M::CALLS {
            return update_with_calls(self, pass);
        }
        let ElementPass { nodes, dt, before, now, threads, corners, .. } = pass;
        let (arch, count, cap) = (self.arch, self.count, self.cap);
        let increment = &TriangleIncrement { nodes, dt, before, time: now.total_time, arch, count };
        let (material, constants) = (&*self.material, &self.constants);
        let run = |(index, ((blocks, corners), (stored, resting))): NumberedTask<'_, M::State>| {
            if resting.quiescent && resting.is_still(nodes) {
                return;
            }
            SCRATCH.with_borrow_mut(|memory| {
                let (blocks, corners) = (&mut *blocks, &mut *corners);
                let pass = TaskPass { material, constants, increment, cap, index, blocks, corners, stored, memory };
                dispatch_outlined(arch, pass);
            });
            let idle = |list: &[f64]| list.iter().all(|x| *x == 0.0);
            resting.quiescent = dt == 0.0
                && !M::MODULI_VARY
                && are_zero(corners)
                && blocks.iter().flat_map(|p| &p.points).all(|p| idle(p.stress.as_flattened()))
                && resting.is_still(nodes);
        };
        let SixNodeTriangles { blocks, tasks, quiescence, .. } = self;
        if threads && count >= PARALLEL {
            let parts = blocks.par_chunks_mut(TASK).zip(corners.par_chunks_mut(TASK * FORCE_BLOCKS));
            parts.zip(tasks.par_iter_mut().zip(quiescence)).enumerate().for_each(run);
        } else {
            let parts = blocks.chunks_mut(TASK).zip(corners.chunks_mut(TASK * FORCE_BLOCKS));
            parts.zip(tasks.iter_mut().zip(quiescence)).enumerate().for_each(run);
        }
        self.totals()
    }

    fn value(&self, element: usize, part: VariableComponent) -> Option<f64> {
        let (block, lane) = self.block(element);
        let of_point = |p: usize| {
            let own = self.material.value(&block.points[p].state, lane, part);
            own.or_else(|| self.followed(element, p, part))
        };
        match part.variable {
            Variable::Stress => self.mean(element, |p| Some(block.points[p].stress.get(part.component)?[lane])),
            Variable::ElementStrainEnergy
            | Variable::ElementPlasticEnergy
            | Variable::ElementArtificialEnergy
            | Variable::ElementDamageEnergy => {
                let sum = of_point(0)? + of_point(1)? + of_point(2)?;
                // For user materials, the recorded energy includes the dissipation.
                let unknown = M::FLOW == PlasticFlow::Unknown && part.variable == Variable::ElementStrainEnergy;
                Some(if unknown { sum - self.value(element, Variable::ElementPlasticEnergy.into())? } else { sum })
            }
            Variable::Degradation
            | Variable::DamageInitiation
            | Variable::DuctileInitiation
            | Variable::JohnsonCookInitiation => Some(of_point(0)?.max(of_point(1)?).max(of_point(2)?)),
            Variable::Mass => Some(block.mass(lane)),
            Variable::Status => Some(if block.triangles.deleted[lane] { 0.0 } else { 1.0 }),
            Variable::PlasticComponents if matches!(M::FLOW, PlasticFlow::None | PlasticFlow::Unknown) => None,
            _ => self.mean(element, of_point),
        }
    }

    fn stable_rate(&self, element: usize, masses: Option<&[f64]>, nodes: &[Node]) -> Option<f64> {
        let (block, lane) = self.block(element);
        let inverse = match masses {
            Some(_) if M::EQUATION_OF_STATE => return None,
            None if Self::HOLDS_PRESSURE => return Some(0.5 * block.triangles.rate[lane]),
            Some(masses) => masses.first_chunk::<NODES>()?.inline_map(|mass| 1.0 / mass),
            None => block.triangles.inverse_masses(lane),
        };
        let ElementConstants { bulk, shear, bulk_viscosity: BulkViscosity { linear, .. }, .. } = self.constants;
        let (moduli, operators) = ([bulk + self.material.initial_bulk(), shear], self.operators(element, nodes));
        let initial = |inverse: &[f64; NODES]| elastic_rate(&operators, moduli, inverse, linear);
        // The last update found the current stiffness of rubber.
        let current = 0.5 * block.triangles.rate[lane];
        if Self::HOLDS_PRESSURE && current > 0.0 {
            return Some(initial(&inverse) * current / initial(&block.triangles.inverse_masses(lane)));
        }
        Some(initial(&inverse))
    }

    fn stiffness(&self, element: usize, nodes: &[Node]) -> Option<ElementStiffness> {
        let (block, lane) = self.block(element);
        if Self::HOLDS_PRESSURE {
            return None;
        }
        if block.triangles.deleted[lane] {
            return Some([[0.0; 2 * NODES]; 2 * NODES].into());
        }
        Some(
            stiffness(places(block.triangles.element(lane), nodes), [self.constants.bulk, self.constants.shear]).into(),
        )
    }

    fn is_quiescent(&self, task: usize) -> bool {
        self.quiescence[task].quiescent
    }

    fn bytes(&self) -> usize {
        let tasks: usize = self.tasks.iter().map(|stored| stored.task.bytes()).sum();
        let quiescence: usize = self.quiescence.iter().map(TaskQuiescence::bytes).sum();
        let points = self.blocks.iter().flat_map(|block| &block.points);
        let states: usize = points.map(|point| self.material.bytes(&point.state)).sum();
        let start: usize = self.blocks.iter().map(|block| size_of_val(&*block.start)).sum();
        let calls = self.calls.as_ref().map_or(0, |calls| calls.bytes());
        let names = self.material.calls().map_or(0, |calls| calls.bytes());
        let arrays = size_of_val(&*self.blocks) + size_of_val(&*self.tasks) + self.listed.capacity();
        arrays + tasks + quiescence + states + start + calls + names
    }

    fn copy(&self) -> Box<dyn ElementGroup> {
        Box::new(self.clone())
    }

    fn extensions(&mut self) -> &mut dyn GroupExtensions {
        self
    }
}

impl<M: Material> GroupExtensions for SixNodeTriangles<M> {
    fn settings(&mut self) -> &mut dyn GroupSettings {
        self
    }

    fn deletion(&mut self) -> &mut dyn GroupDeletion {
        self
    }

    fn initial_state(&mut self) -> &mut dyn InitialState {
        self
    }

    fn temperatures(&mut self) -> Option<&mut dyn ElementTemperatures> {
        Some(self)
    }

    fn fields(&mut self) -> Option<&mut dyn ElementFields> {
        if M::CALLS { Some(self) } else { None }
    }

    fn user(&mut self) -> Option<&mut dyn UserCalls> {
        if M::CALLS { Some(self) } else { None }
    }
}

impl<M: Material> CallingGroup for SixNodeTriangles<M> {
    type Material = M;
    type Block = TriangleBlock<M::State>;

    fn elements(&mut self) -> CallingElements<'_, M, TriangleBlock<M::State>> {
        let SixNodeTriangles { material, constants, count, blocks, tasks, calls, arch, cap, .. } = self;
        let (calls, count, arch, cap) = (calls.as_deref_mut(), *count, *arch, *cap);
        CallingElements { material: &**material, constants, count, blocks, tasks, calls, arch, cap }
    }

    fn totals(&self) -> GroupTotals {
        let ElementConstants { bulk, shear, bulk_viscosity: BulkViscosity { linear, .. }, .. } = self.constants;
        let still = self.cap * damped(linear * (bulk + 4.0 / 3.0 * shear) / bulk);
        totals(self.tasks.iter().map(StoredTask::parts), |task| {
            if self.quiescence[task].quiescent { still } else { f64::INFINITY }
        })
    }
}

impl<M: Material> ElementFields for SixNodeTriangles<M> {
    fn set_field(&mut self, element: usize, variable: usize, value: f64) {
        self.set_value(element, PointValue::Field(variable, value));
    }

    fn set_fields(&mut self, variable: usize, values: &[f64]) {
        for (element, value) in values.iter().enumerate() {
            self.set_value(element, PointValue::NodalField(variable, *value));
        }
    }
}

impl<M: Material> GroupSettings for SixNodeTriangles<M> {
    fn set_masses(&mut self, element: usize, masses: &[f64]) {
        // The stable time increment of a quiescent task has changed.
        self.wake(element);
        let (block, lane) = self.block_mut(element);
        let factor =
            masses.iter().sum::<f64>() / block.triangles.inverse_masses(lane).iter().map(|i| 1.0 / i).sum::<f64>();
        let mut raised: f64 = 0.0;
        for (list, mass) in block.triangles.inverse_mass.iter_mut().zip(masses) {
            raised = raised.max(1.0 / (mass * list[lane]));
            list[lane] = 1.0 / mass;
        }
        block.triangles.rate[lane] *= raised.sqrt();
        block.points.iter_mut().for_each(|p| p.mass[lane] *= factor);
    }

    fn follow(&mut self) {
        for (stored, blocks) in self.tasks.iter_mut().zip(self.blocks.chunks(TASK)) {
            stored.task.records = vec![BlockRecord::default(); POINTS * blocks.len()];
        }
    }

    fn limit_frequency(&mut self, frequency: f64) {
        self.cap = frequency;
    }

    fn use_instructions(&mut self, arch: Arch) {
        self.arch = arch;
    }
}

impl<M: Material> GroupDeletion for SixNodeTriangles<M> {
    fn make_erodible(&mut self) {
        self.erodible = true;
    }

    fn erode(&mut self, element: usize, _volume: f64) {
        self.wake(element);
        // Lanes after the last element repeat it.
        let last = if element + 1 == self.count { LANES } else { element % LANES + 1 };
        let block = &mut self.blocks[element / LANES];
        for lane in element % LANES..last {
            block.triangles.deleted[lane] = true;
            block.points.iter_mut().flat_map(|p| &mut p.stress).for_each(|s| s[lane] = 0.0);
        }
        if let Some(listed) = self.listed.get_mut(element) {
            *listed = true;
        }
    }

    fn newly_deleted(&mut self, deleted: &mut Vec<ElementNodes>) {
        if !M::FAILS || self.tasks.iter().all(|stored| stored.deleted == 0) {
            return;
        }
        let mut listed = std::mem::take(&mut self.listed);
        list_deleted(self, &mut listed, deleted);
        self.listed = listed;
    }
}

impl<M: Material> InitialState for SixNodeTriangles<M> {
    fn set(&mut self, element: usize, stress: Option<[f64; 4]>, temperature: Option<f64>) {
        let (block, lane) = self.block_mut(element);
        for point in &mut block.points {
            for (list, value) in point.stress.iter_mut().zip(stress.into_iter().flatten()) {
                list[lane] = value;
            }
        }
        if let Some(stress) = stress {
            self.set_value(element, PointValue::Stress(stress));
        }
        if let Some(temperature) = temperature {
            self.set_value(element, PointValue::Temperature(temperature));
        }
    }

    fn set_state(&mut self, element: usize, variable: usize, value: f64) -> bool {
        self.set_value(element, PointValue::StateVariable(variable, value))
    }

    fn set_plastic_strain(&mut self, element: usize, strain: f64) -> bool {
        self.set_value(element, PointValue::PlasticStrain(strain))
    }

    fn set_energy(&mut self, element: usize, energy: f64) {
        self.set_value(element, PointValue::SpecificEnergy(energy));
    }

    fn set_length(&mut self, element: usize, point: usize, length: f64) {
        let state = &mut self.blocks[element / LANES].points[point].state;
        self.material.set(state, element % LANES, PointValue::Length(length));
    }
}

impl<M: Material> ElementTemperatures for SixNodeTriangles<M> {
    fn set_temperatures(&mut self, temperatures: &[f64]) {
        for (e, temperature) in temperatures.iter().enumerate() {
            self.set_value(e, PointValue::NodalTemperature(*temperature));
        }
    }

    fn temperatures(&self, out: &mut [f64]) {
        for (e, out) in out.iter_mut().enumerate() {
            *out = self.value(e, Variable::Temperature.into()).unwrap_or(*out);
        }
    }

    /// Subtracts the thermal strain as for quadrilaterals.
    fn expand(&mut self, strains: &[f64], nodes: &[Node], dt: f64) -> ExpansionWork {
        let mut work = ExpansionWork::default();
        for (e, strain) in strains.iter().enumerate().filter(|s| *s.1 != 0.0) {
            if self.blocks[e / LANES].triangles.deleted[e % LANES] {
                continue;
            }
            self.wake(e);
            let is_subtracted_later = self.set_value(e, PointValue::ThermalStrain(*strain));
            let (bulk, material) = (self.constants.bulk, Arc::clone(&self.material));
            let (block, lane) = self.block_mut(e);
            let own = block.triangles.element(lane).inline_map(|n| nodes[n as usize]);
            let g = operators_at(own.inline_map(|n| [n.r - 0.5 * dt * n.v_r, n.z - 0.5 * dt * n.v_z]));
            let (v_r, v_z) = (own.inline_map(|n| n.v_r), own.inline_map(|n| n.v_z));
            let mut done = [0.0; POINTS];
            for (p, point) in block.points.iter_mut().enumerate() {
                let pressure = material.share(&point.state, lane) * 3.0 * bulk * strain;
                let sum = (point.stress[0][lane] + point.stress[1][lane]) + point.stress[2][lane];
                work.supplied -= 2.0 * PI * g.volume[p] * strain * (sum - 1.5 * pressure);
                if is_subtracted_later {
                    continue;
                }
                point.stress[..3].iter_mut().for_each(|list| list[lane] -= pressure);
                let [rr, zz, hoop, ..] = g.gradients(p, &v_r, &v_z);
                done[p] = PI * pressure * dt * (rr + zz + hoop);
            }
            for (p, done) in done.into_iter().enumerate() {
                work.omitted += done;
                let (task, at) = (&mut self.tasks[e / (TASK * LANES)], e / LANES % TASK);
                task.task.add_to_record(POINTS * at + p, lane, [done, 0.0]);
            }
        }
        work
    }
}
