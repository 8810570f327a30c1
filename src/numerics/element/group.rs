//! Interface of element groups, and the group of quadrilaterals: its blocks, dispatched to the instruction set of the
//! machine and distributed over threads.

use crate::kernel::lists::Memory;
use std::cell::RefCell;
use std::sync::Arc;

use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

use crate::element::block::{CornerNodes, ElementBlock, LaneSums, StoredTask, TASK, TaskWorkspace, across, is_larger};
use crate::element::calls::{
    CallingBlock as _, QuadScratch, UserCallBuffers, persist_called_moduli, update_with_calls,
};
use crate::element::constants::{ElementConstants, damped};
use crate::element::quiescent::TaskQuiescence;
use crate::element::record::{BlockRecord, ElementRecord};
use crate::element::subzonal::SubzonalPressures;
use crate::element::tiles::{TilePass, TileTasks, blocks_in_ring, with_ring};
use crate::kernel::cohesive;
use crate::kernel::lanes::{BlockCornerForces, InlineMap, LANES, Lanes, Pack, dispatch_outlined};
use crate::kernel::prefetch::{request, request_entry};
use crate::kernel::quad;
use crate::kernel::shell::ShellFrame;
use crate::kernel::topology::{ElementNodes, ElementTopology, MOST_NODES, PerNode};
use crate::material::available::AvailableEnergy;
use crate::material::{BlockStart, Material, PlasticFlow, PointValue};
use crate::mesh::corner_forces::{CornerForces, are_zero};
use crate::routines::PointRoutines;
use crate::state::Instant;
use crate::state::archive::Persist;
use crate::state::halt::HaltReason;
use crate::state::nodes::{Node, NodeAccelerations};
use crate::variables::{Variable, VariableComponent};

/// Energy increments and limits of a group from one update.
#[derive(Clone, Copy, Debug, Default, PartialEq, Persist)]
pub struct GroupTotals {
    /// Work of the stress.
    pub internal: f64,
    /// Energy dissipated by plastic flow and damage.
    pub plastic: f64,
    /// Elastic energy lost by damage, a part of `plastic`.
    pub damaged: f64,
    /// Work of the bulk viscosity.
    pub viscous: f64,
    /// Work of the hourglass control.
    pub artificial: f64,
    /// One over the stable time increment.
    pub rate: f64,
    /// Index in the group of the element that limits it.
    pub limiting: usize,
    /// Bound of the relative increase of a frequency by the deformation in this increment: gradients by the largest
    /// strain (norm of the tensor), the root of the volume by half its largest change. 0 unless frequencies are capped.
    pub deformed: f64,
}

/// Properties that all elements of a group share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GroupProperties {
    /// Shape of the elements.
    pub topology: ElementTopology,
    /// Whether elements can be deleted.
    pub deletable: bool,
    /// Whether bulk viscosity damps the highest modes.
    pub damped: bool,
    /// Whether the pressure follows from density, energy or the total deformation, so that no initial stress can be
    /// prescribed.
    pub holds_pressure: bool,
    /// Number of field variables that elements store.
    pub fields: usize,
    /// Whether corner forces may be stored for a part of the elements only.
    pub tiles: bool,
}

/// Properties of cohesive elements; groups of other elements have none.
pub trait InterfaceElements {
    /// Returns the constitutive thickness of a cohesive element; `None` for other elements.
    fn constitutive_thickness(&self, _element: usize) -> Option<f64> {
        None
    }
    /// Returns the stiffness at both points of a cohesive element, force per separation; `None` for other elements.
    fn interface_stiffness(&self, _element: usize) -> Option<[f64; 2]> {
        None
    }
}

/// Elements that can release energy.
pub trait EnergySource {
    /// Returns the energy that an element can release from its initial state.
    fn available_energy(&self, _element: usize, _nodes: &[Node]) -> AvailableEnergy {
        AvailableEnergy::NONE
    }
}

/// Elements of one topology and one material.
#[allow(clippy::len_without_is_empty)] // `is_empty` is a method of `dyn ElementGroup`.
pub trait ElementGroup: InterfaceElements + EnergySource + Persist + Send + Sync {
    /// Returns the number of elements.
    fn len(&self) -> usize;
    /// Returns the properties that all elements share.
    fn properties(&self) -> GroupProperties;
    /// Returns the nodes of an element in the order of the topology; for shells also the companion nodes of the
    /// rotations.
    fn nodes(&self, element: usize) -> ElementNodes;
    /// Returns the lumped masses of an element at its nodes; rotary inertias at companion nodes.
    fn masses(&self, element: usize) -> PerNode<f64>;
    /// Updates the stresses to the end of an increment, and the corner forces.
    fn update(&mut self, pass: ElementPass<'_>) -> GroupTotals;
    /// Returns the value of a variable that the group stores for an element; `None` if the element does not have it or
    /// a formula computes it.
    fn value(&self, element: usize, part: VariableComponent) -> Option<f64>;
    /// Returns one over the stable time increment of an element at the current positions, by the bound of the inner
    /// loop with linear bulk viscosity only and without a bound of the whole model. Uses `masses` instead of the
    /// element's own masses if given; `None` if the masses cannot be scaled.
    fn stable_rate(&self, element: usize, masses: Option<&[f64]>, nodes: &[Node]) -> Option<f64>;
    /// Returns the elastic stiffness of an element at the current positions; `None` for an element that is not linear
    /// elastic at small strain, which has no highest frequency in this sense.
    fn stiffness(&self, element: usize, nodes: &[Node]) -> Option<ElementStiffness>;
    /// Returns whether a task of elements is skipped because all its elements are at rest and free of stress.
    fn is_quiescent(&self, _task: usize) -> bool {
        false
    }
    /// Returns the bytes of the arrays of the group.
    fn bytes(&self) -> usize;
    /// Returns a copy of the group in the same state.
    fn copy(&self) -> Box<dyn ElementGroup>;
    /// Returns the functions of the group apart from updates.
    fn extensions(&mut self) -> &mut dyn GroupExtensions;
}

impl dyn ElementGroup + '_ {
    /// Returns whether the group has no elements.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the shape of the elements.
    pub fn topology(&self) -> ElementTopology {
        self.properties().topology
    }

    /// Returns whether the boundary of an element encloses its volume.
    pub fn is_solid(&self) -> bool {
        self.topology().is_solid()
    }

    /// Returns the number of blocks of corner forces of all elements.
    pub fn force_blocks(&self) -> usize {
        self.len().div_ceil(LANES) * self.topology().force_blocks()
    }

    /// Returns the nodes on the boundary of an element, without rotations.
    pub fn boundary(&self, element: usize) -> ElementNodes {
        self.nodes(element).first(self.topology().boundary())
    }

    /// Returns the corner nodes of the quadrilateral cells of a solid element.
    pub fn cells(&self, element: usize) -> impl Iterator<Item = [u32; 4]> {
        let nodes = self.nodes(element);
        self.topology().cells().iter().map(move |cell| cell.inline_map(|i| nodes[i]))
    }

    /// Returns whether an element of the group is deleted.
    pub fn is_deleted(&self, element: usize) -> bool {
        self.value(element, Variable::Status.into()) == Some(0.0)
    }

    /// Returns the volume of an element at the current positions.
    pub fn volume(&self, element: usize, nodes: &[Node]) -> f64 {
        self.volume_at(element, |n| nodes[n as usize].place())
    }

    /// Returns the volume of an element for given node positions.
    pub fn volume_at(&self, element: usize, place: impl Fn(u32) -> [f64; 2]) -> f64 {
        if self.is_solid() {
            return self.cells(element).map(|cell| quad::volume(cell.inline_map(&place))).sum();
        }
        let nodes = self.nodes(element);
        if let Some(thickness) = self.constitutive_thickness(element) {
            let [a, b] = cohesive::areas([0, 1, 2, 3].inline_map(|i: usize| place(nodes[i])));
            return thickness * (a + b);
        }
        let thickness = self.value(element, Variable::Thickness.into());
        ShellFrame::new([0, 1].inline_map(|i| place(nodes[i]))).area() * thickness.unwrap_or(0.0)
    }
}

/// Work of a thermal strain.
#[derive(Clone, Copy, Debug, Default)]
pub struct ExpansionWork {
    /// Stress work that the element update omits.
    pub omitted: f64,
    /// Energy that the temperature puts in: the work of the stress on the thermal strain, with opposite sign.
    pub supplied: f64,
}

/// Elastic stiffness of an element, rows and columns `[r, z]` of each node in turn.
#[derive(Clone, Copy, Debug)]
pub struct ElementStiffness(pub [[f64; 2 * MOST_NODES]; 2 * MOST_NODES]);

impl<const N: usize> From<[[f64; N]; N]> for ElementStiffness {
    fn from(list: [[f64; N]; N]) -> Self {
        let mut matrix = [[0.0; 2 * MOST_NODES]; 2 * MOST_NODES];
        matrix.iter_mut().zip(list).for_each(|(row, own)| row[..N].copy_from_slice(&own));
        ElementStiffness(matrix)
    }
}

/// Functions of a group apart from updates; optional ones return `None` if not available.
pub trait GroupExtensions {
    /// Returns the interface for settings that hold during the whole run.
    fn settings(&mut self) -> &mut dyn GroupSettings;
    /// Returns the interface for element deletion.
    fn deletion(&mut self) -> &mut dyn GroupDeletion;
    /// Returns the interface that sets the initial state.
    fn initial_state(&mut self) -> &mut dyn InitialState;
    /// Returns the interface for prescribed temperatures.
    fn temperatures(&mut self) -> Option<&mut dyn ElementTemperatures> {
        None
    }
    /// Returns the interface for field variables.
    fn fields(&mut self) -> Option<&mut dyn ElementFields> {
        None
    }
    /// Returns the interface to the variables that move through an adaptive mesh.
    fn transfer(&mut self) -> Option<&mut dyn ElementTransfer> {
        None
    }
    /// Returns the interface for user subroutines.
    fn user(&mut self) -> Option<&mut dyn UserCalls> {
        None
    }
}

/// Settings of a run that affect a group.
pub trait GroupSettings {
    /// Sets the masses of an element at its nodes.
    fn set_masses(&mut self, element: usize, masses: &[f64]);
    /// Sets one over the stable time increment of a cohesive element, which depends on the bodies that it joins.
    fn set_rate(&mut self, _element: usize, _rate: f64) {}
    /// Allocates the stable time increments of elements, from which mass scaling finds the current stiffness of rubber.
    fn keep_rates(&mut self) {}
    /// Starts to record strains and energies for output.
    fn follow(&mut self);
    /// Sets the bound of the highest frequency of the whole model, radians per time; infinite if unknown.
    fn limit_frequency(&mut self, _frequency: f64) {}
    /// Selects another instruction set; results have the same bits.
    fn use_instructions(&mut self, _arch: Arch) {}
}

/// Interface that deletes elements and lists the deleted ones.
pub trait GroupDeletion {
    /// Allocates what [`GroupDeletion::erode`] needs.
    fn make_erodible(&mut self);
    /// Deletes an element; `volume` is its initial volume if it is solid. [`GroupDeletion::newly_deleted`] does not
    /// list it.
    fn erode(&mut self, element: usize, volume: f64);
    /// Appends the boundaries of elements that the last update deleted.
    fn newly_deleted(&mut self, _deleted: &mut Vec<ElementNodes>) {}
}

/// Initial state of elements. Values that an element does not store are ignored.
pub trait InitialState {
    /// Sets the initial stress (rr, zz, hoop, rz) and temperature of an element; `None` leaves the value unchanged.
    fn set(&mut self, element: usize, stress: Option<[f64; 4]>, temperature: Option<f64>);
    /// Sets a solution-dependent state variable, counted from 0. Returns whether the element stores it.
    fn set_state(&mut self, _element: usize, _variable: usize, _value: f64) -> bool {
        false
    }
    /// Sets the equivalent plastic strain. Returns whether the material hardens by this variable only.
    fn set_plastic_strain(&mut self, _element: usize, _strain: f64) -> bool {
        false
    }
    /// Sets the specific energy, energy per mass.
    fn set_energy(&mut self, _element: usize, _energy: f64) {}
    /// Sets the characteristic length of an integration point, counted from 0, which is otherwise the square root of the
    /// section area.
    fn set_length(&mut self, _element: usize, _point: usize, _length: f64) {}
}

/// Interface for elements whose temperatures are prescribed or solved for.
pub trait ElementTemperatures {
    /// Sets the temperatures of all elements.
    fn set_temperatures(&mut self, temperatures: &[f64]);
    /// Writes the temperatures of the elements, including the rise by plastic work, to `out`; entries of elements
    /// without temperature are unchanged.
    fn temperatures(&self, out: &mut [f64]);
    /// Subtracts increments of the thermal strain from the strains of the next update, which covers the increment `dt`
    /// that ends at these nodes.
    fn expand(&mut self, strains: &[f64], nodes: &[Node], dt: f64) -> ExpansionWork;
}

/// Interface to the variables of a group that move with the material.
pub trait ElementTransfer {
    /// Returns the number of variables of an element.
    fn variables(&mut self) -> usize;
    /// Allocates what [`ElementTransfer::write`] needs, before the first increment.
    fn prepare(&mut self);
    /// Reads the variables of elements in ascending order, per mass, into lists of packs. The second list is whether each
    /// element is read.
    fn read(&mut self, elements: (&[u32], &[bool]), packs: &mut [Vec<Pack>]);
    /// Writes the variables, and the masses of the elements at their corners. The second list is whether each element is
    /// written.
    fn write(&mut self, elements: (&[u32], &[bool]), packs: &[Vec<Pack>], arrived: ArrivedElements<'_>);
    /// Returns [`Material::volume_ratio`] of an element.
    fn volume_ratio(&self, element: u32) -> Option<f64>;
    /// Sets the ratio of volumes of an element.
    fn set_volume_ratio(&mut self, element: u32, ratio: f64);
}

/// Elements of a domain after a transport, in its order.
#[derive(Clone, Copy)]
pub struct ArrivedElements<'a> {
    /// Masses at the corners.
    pub masses: &'a [[f64; 4]],
    /// Nodes of the corners, as indices of `places`.
    pub corners: &'a [[u32; 4]],
    /// Places of the nodes.
    pub places: &'a [[f64; 2]],
}

/// Field variables of elements, counted from 0 and below [`GroupProperties::fields`].
pub trait ElementFields {
    /// Sets the initial value of a field variable of an element.
    fn set_field(&mut self, element: usize, variable: usize, value: f64);
    /// Sets a field variable of all elements.
    fn set_fields(&mut self, variable: usize, values: &[f64]);
}

/// User subroutines that a group calls.
pub trait UserCalls {
    /// Calls the user material at the start of the analysis to determine its moduli, before mass scaling and the
    /// estimate of the highest frequency.
    ///
    /// # Errors
    /// The failure of the subroutine, or an inelastic response.
    fn probe(&mut self, nodes: &[Node], now: &Instant, user: PointRoutines<'_>) -> Result<(), HaltReason>;
    /// Returns the failure of the subroutine in the last update.
    fn failure(&mut self) -> Option<HaltReason>;
    /// Returns the largest bulk and shear modulus of all elements.
    fn moduli(&mut self) -> [f64; 2];
    /// Takes these moduli from the same group with another mesh.
    fn set_moduli(&mut self, moduli: [f64; 2]);
}

/// Input of the update of a group.
pub struct ElementPass<'a> {
    /// All nodes, at current positions.
    pub nodes: &'a [Node],
    /// Length of the previous increment.
    pub dt: f64,
    /// Accelerations that moved the nodes over it.
    pub before: NodeAccelerations<'a>,
    /// Instant at which the nodes have their current positions.
    pub now: &'a Instant,
    /// Whether the update may use several threads.
    pub threads: bool,
    /// User subroutines that are called at points.
    pub user: PointRoutines<'a>,
    /// Destination of the corner forces of the group that are stored.
    pub corners: &'a mut [BlockCornerForces],
    /// Tiles in which corner forces are summed; `None` if all are stored.
    pub tiles: Option<TilePass<'a>>,
    /// Averaged minus own volumetric strain increment of each element, block by block; `None` without averaging.
    pub dilation_correction: Option<&'a [Lanes]>,
    /// Whether data of later blocks are requested in advance; groups may ignore it.
    pub prefetches: bool,
}

impl Clone for Box<dyn ElementGroup> {
    fn clone(&self) -> Self {
        self.copy()
    }
}

/// Number of elements above which parallel updates are faster.
pub(super) const PARALLEL: usize = 1000;

thread_local! {
    /// Scratch memory of the tasks that a thread updates one after the other.
    static SCRATCH: RefCell<TaskWorkspace> = RefCell::default();
}

/// Fills the scratch memory of the thread with numbers that no update may use.
#[cfg(test)]
pub(super) fn spoil_scratch() {
    SCRATCH.with_borrow_mut(TaskWorkspace::spoil);
}

/// Quadrilaterals of one material, with volume or area weighting.
#[derive(Persist)]
#[persist(
    fixed: blocks, tasks, listed, quiescence;
    derived: material, constants, calls, count, arch;
    then: persist_called_moduli
)]
pub struct QuadGroup<M: Material> {
    pub(super) material: Arc<M>,
    pub(super) constants: ElementConstants,
    pub(super) count: usize,
    pub(super) blocks: Vec<ElementBlock<M::State>>,
    pub(super) tasks: Vec<StoredTask>,
    /// Buffers of user subroutines; `None` without user subroutines.
    pub(super) calls: Option<Box<UserCallBuffers<QuadScratch>>>,
    pub(super) arch: Arch,
    /// Elements that [`GroupDeletion::newly_deleted`] has already listed.
    listed: Vec<bool>,
    quiescence: Vec<TaskQuiescence>,
    /// Bound of the highest frequency of the whole model.
    pub(super) cap: f64,
}

impl<M: Material> QuadGroup<M> {
    /// Selects another instruction set; results have the same bits.
    #[must_use]
    pub fn on(mut self, arch: Arch) -> Self {
        self.arch = arch;
        self
    }

    /// Adds subzonal pressures for elements in the initial configuration.
    #[must_use]
    pub fn with_subzones(mut self, elements: &[[u32; 4]], nodes: &[Node]) -> Self {
        for (stored, part) in self.tasks.iter_mut().zip(elements.chunks(TASK * LANES)) {
            stored.task.subzones = part.chunks(LANES).map(|block| SubzonalPressures::of(block, nodes)).collect();
        }
        self
    }

    /// Creates a group from the corner nodes of its elements in the initial configuration.
    pub fn new(material: M, constants: ElementConstants, density: f64, elements: &[[u32; 4]], nodes: &[Node]) -> Self {
        let fresh = |(index, part): (usize, &[_])| {
            let state = material.initial_state(&block_start(index * LANES, part, nodes));
            let mut block = block(state, density, part, nodes);
            if constants.by_area {
                block.inverse_mass =
                    [block.mass.inline_map(|mass| 16.0 / mass), [0.0; LANES], [0.0; LANES], [0.0; LANES]];
            }
            block
        };
        let blocks: Vec<_> = elements.chunks(LANES).enumerate().map(fresh).collect();
        QuadGroup {
            calls: UserCallBuffers::new(&material, ElementBlock::<M::State>::POINTS, elements.len()),
            material: Arc::new(material),
            constants,
            count: elements.len(),
            tasks: blocks.chunks(TASK).map(|part| StoredTask::new(&constants, part.len())).collect(),
            blocks,
            arch: Arch::new(),
            quiescence: TaskQuiescence::of_tasks(elements),
            listed: if M::FAILS { vec![false; elements.len()] } else { Vec::new() },
            cap: f64::INFINITY,
        }
    }
}

impl<M: Material> Clone for QuadGroup<M> {
    fn clone(&self) -> Self {
        QuadGroup {
            material: Arc::clone(&self.material),
            calls: self.calls.clone(),
            constants: self.constants,
            count: self.count,
            blocks: self.blocks.clone(),
            tasks: self.tasks.clone(),
            arch: self.arch,
            listed: self.listed.clone(),
            quiescence: self.quiescence.clone(),
            cap: self.cap,
        }
    }
}

impl<M: Material> QuadGroup<M> {
    /// Returns the recorded values of an element; `None` without a record.
    fn followed(&self, element: usize) -> Option<ElementRecord> {
        let block = element / LANES;
        Some(self.tasks[block / TASK].task.records.get(block % TASK)?.of(element % LANES))
    }

    /// Whether the pressure is part of the material state; with an equation of state the mass too.
    const HOLDS_PRESSURE: bool = M::MODULI_VARY && !matches!(M::FLOW, PlasticFlow::Coupled | PlasticFlow::Unknown);

    /// Returns one over the stable time increment of an element of rubber with corner masses: that of its initial moduli,
    /// times the ratio that the last update found for the current masses.
    fn rubber_rate(&self, element: usize, nodes: &[Node], masses: &[f64; 4]) -> f64 {
        let corners = self.corners(element).inline_map(|n| nodes[n as usize].place());
        let constants = ElementConstants { bulk: self.material.initial_bulk(), ..self.constants };
        let initial = |masses: &[f64; 4]| constants.own_rate(corners, masses);
        let rate = self.last_rate(element);
        if rate > 0.0 {
            let current = self.constants.with_assumed(rate, f64::INFINITY);
            return initial(masses) * current / initial(&self.corner_masses(element));
        }
        initial(masses)
    }

    /// Returns one over the stable time increment of an element in the last update, without assumed strains; 0 if it is
    /// not stored or before the first update.
    fn last_rate(&self, element: usize) -> f64 {
        let (block, lane) = (element / LANES, element % LANES);
        let rates = self.tasks[block / TASK].task.own_rates.get(block % TASK);
        rates.map_or(0.0, |rates| 0.5 * rates[lane])
    }

    /// Sets a value of an element. Returns whether its material uses it.
    fn set_value(&mut self, element: usize, value: PointValue) -> bool {
        self.material.set(&mut self.blocks[element / LANES].state, element % LANES, value)
    }

    fn corners(&self, element: usize) -> [u32; 4] {
        [0, 1, 2, 3].inline_map(|c| self.blocks[element / LANES].nodes[c][element % LANES])
    }

    fn corner_masses(&self, element: usize) -> [f64; 4] {
        self.blocks[element / LANES].corner_masses(element % LANES)
    }

    fn is_deleted(&self, element: usize) -> bool {
        let status = self.material.value(&self.blocks[element / LANES].state, element % LANES, Variable::Status.into());
        status == Some(0.0) || self.is_eroded(element)
    }

    pub(super) fn totals(&self) -> GroupTotals {
        let ElementConstants { bulk, shear, bulk_viscosity, .. } = self.constants;
        let xi = bulk_viscosity.linear * (bulk + 4.0 / 3.0 * shear) / bulk;
        let still = self.cap * damped(xi);
        let totals = totals(self.tasks.iter().map(StoredTask::parts), |task| {
            if self.quiescence[task].quiescent { still } else { f64::INFINITY }
        });
        GroupTotals { rate: self.constants.with_assumed(totals.rate, self.cap), ..totals }
    }

    /// Makes a task active.
    pub(super) fn wake(&mut self, task: usize) {
        self.quiescence[task].quiescent = false;
    }

    /// Returns whether an element was deleted by `*EROSION`.
    fn is_eroded(&self, element: usize) -> bool {
        let block = element / LANES;
        self.tasks[block / TASK].task.eroded.get(block % TASK).is_some_and(|e| e.has(element % LANES))
    }
}

impl<M: Material> QuadGroup<M> {
    /// Keeps all tasks active, by adding a moving node to each; for tests of single increments.
    pub fn keep_awake(&mut self, node: u32) {
        self.quiescence.iter_mut().for_each(|resting| resting.nodes.push(node));
    }
}

/// Returns initial geometry of the elements of a block. Lanes after the last element repeat it.
fn block_start(first: usize, elements: &[[u32; 4]], nodes: &[Node]) -> BlockStart {
    let (area, volume, centre) = ([1.0; LANES], [1.0; LANES], [[0.0; LANES]; 2]);
    let corners = [[[0.0; 4]; 2]; LANES];
    let mut start = BlockStart { count: elements.len(), area, volume, centre, corners, first };
    for l in 0..LANES {
        let corners = elements[l.min(elements.len() - 1)].inline_map(|n| nodes[n as usize].place());
        let [a, b, c, d] = corners;
        start.area[l] = quad::section(corners.inline_map(|c| c[0]), corners.inline_map(|c| c[1]));
        start.volume[l] = quad::volume(corners);
        start.corners[l] = [corners.inline_map(|c| c[0]), corners.inline_map(|c| c[1])];
        for i in 0..2 {
            start.centre[i][l] = 0.25 * ((a[i] + b[i]) + (c[i] + d[i]));
        }
    }
    start
}

/// Creates a block of at most [`LANES`] elements at rest.
fn block<S>(state: S, density: f64, elements: &[[u32; 4]], nodes: &[Node]) -> ElementBlock<S> {
    let mut block = ElementBlock {
        nodes: [[0; LANES]; 4],
        stress: [[0.0; LANES]; 4],
        mass: [0.0; LANES],
        inverse_mass: [[0.0; LANES]; 4],
        state,
    };
    for l in 0..LANES {
        // Lanes after the last element repeat it; their results are not used.
        let element = elements[l.min(elements.len() - 1)];
        let corners = element.inline_map(|n| nodes[n as usize].place());
        let inverse_mass = quad::sums(quad::corner_masses(corners, density).inline_map(|mass| 1.0 / mass));
        for i in 0..4 {
            block.nodes[i][l] = element[i];
            block.inverse_mass[i][l] = inverse_mass[i];
        }
        block.mass[l] = density * quad::volume(corners);
    }
    block
}

/// Creates a block of integration points of other elements, at rest, with the given masses.
pub(super) fn block_of_points<S>(state: S, mass: Lanes) -> ElementBlock<S> {
    let (nodes, zeros) = ([[0; LANES]; 4], [[0.0; LANES]; 4]);
    ElementBlock { nodes, stress: zeros, mass, inverse_mass: zeros, state }
}

impl<M: Material> InterfaceElements for QuadGroup<M> {}

impl<M: Material> EnergySource for QuadGroup<M> {
    fn available_energy(&self, element: usize, nodes: &[Node]) -> AvailableEnergy {
        let group: &dyn ElementGroup = self;
        let (block, lane, volume) = (&self.blocks[element / LANES], element % LANES, group.volume(element, nodes));
        let mass = block.mass[lane];
        let AvailableEnergy { energy, from } = self.material.available_energy(&block.state, lane, volume / mass);
        let of_stress = volume * self.constants.elastic_energy(block.stress.inline_map(|list| list[lane]));
        AvailableEnergy { energy: mass * energy + of_stress, from }
    }
}

impl<M: Material> ElementGroup for QuadGroup<M> {
    fn len(&self) -> usize {
        self.count
    }

    fn properties(&self) -> GroupProperties {
        GroupProperties {
            topology: ElementTopology::Quadrilateral,
            // `make_erodible` allocates in all tasks or in none; this function runs once per element in places.
            deletable: self.material.can_delete() || self.tasks.first().is_some_and(|t| !t.task.eroded.is_empty()),
            damped: self.constants.damps(),
            holds_pressure: Self::HOLDS_PRESSURE,
            fields: self.material.calls().map_or(0, |calls| calls.fields()),
            // Equations of state use the corner forces of the previous pass.
            tiles: !M::CALLS && !M::EQUATION_OF_STATE,
        }
    }

    fn nodes(&self, element: usize) -> ElementNodes {
        self.corners(element).into()
    }

    fn masses(&self, element: usize) -> PerNode<f64> {
        self.corner_masses(element).into()
    }

    fn update(&mut self, pass: ElementPass<'_>) -> GroupTotals {
        if M::CALLS {
            return update_with_calls(self, pass);
        }
        let ElementPass { nodes, dt, before, now, threads, corners, tiles, dilation_correction, prefetches, .. } = pass;
        let pass = PassContext {
            material: &*self.material,
            constants: &self.constants,
            count: self.count,
            nodes,
            dt,
            before,
            time: now.total_time,
            cap: self.cap,
            dilation_correction,
            prefetches,
            tiled: tiles.is_some(),
        };
        let arch = self.arch;
        let run = |(index, blocks): (usize, &mut [ElementBlock<M::State>]),
                   (stored, resting): (&mut StoredTask, &mut TaskQuiescence),
                   corners: &mut [BlockCornerForces]| {
            if resting.quiescent && dilation_correction.is_none() && resting.is_still(nodes) {
                if pass.tiled {
                    corners.fill(BlockCornerForces::default());
                }
                return;
            }
            SCRATCH.with_borrow_mut(|scratch| {
                let (blocks, corners) = (&mut *blocks, &mut *corners);
                dispatch_outlined(arch, QuadTask { pass: &pass, arch, index, blocks, corners, stored, scratch });
            });
            // With dt = 0 nothing has been added to the sums, so they stay valid while the task is quiescent. The
            // pressure of an equation of state is not part of the stress that is checked here.
            resting.quiescent = dt == 0.0
                && dilation_correction.is_none()
                && !M::MODULI_VARY
                && are_zero(corners)
                && blocks.iter().all(|b| b.stress.as_flattened().iter().all(|x| *x == 0.0))
                && resting.is_still(nodes);
            if resting.quiescent {
                // Zeros of one sign, as above.
                corners.fill(BlockCornerForces::default());
            }
        };
        let threads = threads && self.count >= PARALLEL;
        if let Some(tiles) = tiles {
            let QuadGroup { blocks, tasks, quiescence, .. } = self;
            TaskLists { blocks, tasks, quiescence, tiles: tiles.all(corners) }.update(threads, &run);
        } else if !threads {
            let stored = self.tasks.iter_mut().zip(&mut self.quiescence);
            let parts = self.blocks.chunks_mut(TASK).enumerate().zip(stored);
            parts.zip(corners.chunks_mut(TASK)).for_each(|((blocks, own), corners)| run(blocks, own, corners));
        } else {
            let stored = self.tasks.par_iter_mut().zip(&mut self.quiescence);
            let parts = self.blocks.par_chunks_mut(TASK).enumerate().zip(stored);
            parts.zip(corners.par_chunks_mut(TASK)).for_each(|((blocks, own), corners)| run(blocks, own, corners));
        }
        self.totals()
    }

    fn value(&self, element: usize, part: VariableComponent) -> Option<f64> {
        let (block, lane) = (&self.blocks[element / LANES], element % LANES);
        match part.variable {
            Variable::Stress => Some(block.stress.get(part.component)?[lane]),
            Variable::Mass => Some(block.mass[lane]),
            Variable::Status => Some(f64::from(u8::from(!self.is_deleted(element)))),
            Variable::PlasticComponents if matches!(M::FLOW, PlasticFlow::None | PlasticFlow::Unknown) => None,
            // For user materials, the recorded energy includes the dissipation that only the material knows.
            Variable::ElementStrainEnergy if M::FLOW == PlasticFlow::Unknown => {
                let dissipated = self.value(element, Variable::ElementPlasticEnergy.into())?;
                Some(self.followed(element)?.value(part)? - dissipated)
            }
            _ => {
                let own = self.material.value(&block.state, lane, part);
                own.or_else(|| self.followed(element)?.value(part))
            }
        }
    }

    fn stable_rate(&self, element: usize, masses: Option<&[f64]>, nodes: &[Node]) -> Option<f64> {
        let masses = match masses {
            // If the pressure follows from density and specific energy, the mass is part of the material state.
            Some(_) if M::EQUATION_OF_STATE || self.constants.by_area => return None,
            None if Self::HOLDS_PRESSURE => return Some(self.last_rate(element)),
            Some(masses) => *masses.first_chunk()?,
            None => self.corner_masses(element),
        };
        if Self::HOLDS_PRESSURE {
            return Some(self.rubber_rate(element, nodes, &masses));
        }
        let corners = self.corners(element).inline_map(|n| nodes[n as usize].place());
        Some(self.constants.own_rate(corners, &masses))
    }

    fn stiffness(&self, element: usize, nodes: &[Node]) -> Option<ElementStiffness> {
        if Self::HOLDS_PRESSURE || self.constants.by_area {
            return None;
        }
        let corners = self.corners(element).inline_map(|n| nodes[n as usize].place());
        Some(self.constants.stiffness(corners, self.is_deleted(element)).into())
    }

    fn is_quiescent(&self, task: usize) -> bool {
        self.quiescence[task].quiescent
    }

    fn bytes(&self) -> usize {
        let kept: usize = self.tasks.iter().map(|stored| stored.task.bytes()).sum();
        let quiescence: usize = self.quiescence.iter().map(TaskQuiescence::bytes).sum();
        let states: usize = self.blocks.iter().map(|block| self.material.bytes(&block.state)).sum();
        let calls = self.calls.as_ref().map_or(0, |calls| calls.bytes());
        let names = self.material.calls().map_or(0, |calls| calls.bytes());
        let arrays = size_of_val(&*self.blocks) + size_of_val(&*self.tasks) + self.listed.capacity();
        arrays + kept + quiescence + states + calls + names
    }

    fn copy(&self) -> Box<dyn ElementGroup> {
        Box::new(self.clone())
    }

    fn extensions(&mut self) -> &mut dyn GroupExtensions {
        self
    }
}

impl<M: Material> GroupExtensions for QuadGroup<M> {
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

    /// Subzonal pressures depend on the initial masses of the subzones.
    fn transfer(&mut self) -> Option<&mut dyn ElementTransfer> {
        let subzones = self.tasks.first().is_some_and(|task| !task.task.subzones.is_empty());
        if self.constants.by_area || subzones || !self.material.can_be_carried() { None } else { Some(self) }
    }

    fn user(&mut self) -> Option<&mut dyn UserCalls> {
        if M::CALLS { Some(self) } else { None }
    }
}

impl<M: Material> ElementFields for QuadGroup<M> {
    fn set_field(&mut self, element: usize, variable: usize, value: f64) {
        self.set_value(element, PointValue::Field(variable, value));
    }

    fn set_fields(&mut self, variable: usize, values: &[f64]) {
        for (element, value) in values.iter().enumerate() {
            self.set_value(element, PointValue::NodalField(variable, *value));
        }
    }
}

impl<M: Material> GroupSettings for QuadGroup<M> {
    fn set_masses(&mut self, element: usize, masses: &[f64]) {
        let Some(masses) = masses.first_chunk::<4>() else { return };
        // The stable time increment of a quiescent task has changed.
        self.quiescence[element / (TASK * LANES)].quiescent = false;
        let (block, lane) = (element / LANES, element % LANES);
        let before = self.corner_masses(element);
        if let Some(rates) = self.tasks[block / TASK].task.own_rates.get_mut(block % TASK) {
            let ratio = [0, 1, 2, 3].inline_map(|i| before[i] / masses[i]);
            let raised = ratio.into_iter().fold(0.0, f64::max).sqrt();
            rates[lane] *= raised;
        }
        self.blocks[element / LANES].set_corner_masses(element % LANES, *masses);
    }

    fn keep_rates(&mut self) {
        if Self::HOLDS_PRESSURE && !M::EQUATION_OF_STATE {
            for (stored, blocks) in self.tasks.iter_mut().zip(self.blocks.chunks(TASK)) {
                stored.task.store_rates(blocks.len());
            }
        }
    }

    fn follow(&mut self) {
        for (stored, blocks) in self.tasks.iter_mut().zip(self.blocks.chunks(TASK)) {
            stored.task.records = vec![BlockRecord::default(); blocks.len()];
        }
    }

    fn limit_frequency(&mut self, frequency: f64) {
        self.cap = self.constants.cap(frequency);
    }

    fn use_instructions(&mut self, arch: Arch) {
        self.arch = arch;
    }
}

impl<M: Material> GroupDeletion for QuadGroup<M> {
    fn make_erodible(&mut self) {
        for (stored, blocks) in self.tasks.iter_mut().zip(self.blocks.chunks(TASK)) {
            stored.task.make_erodible(blocks.len());
            if Self::HOLDS_PRESSURE {
                stored.task.store_rates(blocks.len());
            }
        }
    }

    fn erode(&mut self, element: usize, volume: f64) {
        let (block, lane) = (element / LANES, element % LANES);
        self.quiescence[block / TASK].quiescent = false;
        // Lanes after the last element repeat it.
        let end = if element + 1 == self.count { LANES } else { lane + 1 };
        (lane..end).for_each(|l| self.tasks[block / TASK].task.eroded[block % TASK].take(l, volume));
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

impl<M: Material> InitialState for QuadGroup<M> {
    fn set(&mut self, element: usize, stress: Option<[f64; 4]>, temperature: Option<f64>) {
        let (block, lane) = (&mut self.blocks[element / LANES], element % LANES);
        for (list, value) in block.stress.iter_mut().zip(stress.into_iter().flatten()) {
            list[lane] = value;
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

    fn set_length(&mut self, element: usize, _point: usize, length: f64) {
        self.set_value(element, PointValue::Length(length));
    }
}

impl<M: Material> ElementTemperatures for QuadGroup<M> {
    fn set_temperatures(&mut self, temperatures: &[f64]) {
        for (e, temperature) in temperatures.iter().enumerate() {
            self.set_value(e, PointValue::NodalTemperature(*temperature));
        }
    }

    fn temperatures(&self, out: &mut [f64]) {
        for (e, out) in out.iter_mut().enumerate() {
            let held = self.material.value(&self.blocks[e / LANES].state, e % LANES, Variable::Temperature.into());
            *out = held.unwrap_or(*out);
        }
    }

    /// Subtracts the thermal strain. For isotropic expansion, it is equivalent to a pressure that is subtracted from
    /// the stress beforehand: the trial stress is identical. The returned work corrects the trapezoidal rule, which
    /// uses the reduced stress.
    fn expand(&mut self, strains: &[f64], nodes: &[Node], dt: f64) -> ExpansionWork {
        let mut work = ExpansionWork::default();
        for (e, strain) in strains.iter().enumerate().filter(|s| *s.1 != 0.0) {
            if self.is_eroded(e) {
                continue;
            }
            let (block, lane) = (&self.blocks[e / LANES], e % LANES);
            let corners = [0, 1, 2, 3].inline_map(|c| nodes[block.nodes[c][lane] as usize]);
            let pressure = self.material.share(&block.state, lane) * 3.0 * self.constants.bulk * strain;
            let volume = quad::volume(corners.inline_map(|n| n.place()));
            let sum = (block.stress[0][lane] + block.stress[1][lane]) + block.stress[2][lane];
            work.supplied -= volume * strain * (sum - 1.5 * pressure);
            if self.set_value(e, PointValue::ThermalStrain(*strain)) {
                continue;
            }
            self.quiescence[e / (TASK * LANES)].quiescent = false;
            let block = &mut self.blocks[e / LANES];
            block.stress[..3].iter_mut().for_each(|list| list[lane] -= pressure);
            let corners = corners.inline_map(|n| n.as_array());
            let done = 0.5 * pressure * quad::volume_change(corners, dt, self.constants.by_area);
            work.omitted += done;
            self.tasks[e / (TASK * LANES)].task.add_to_record(e / LANES % TASK, lane, [done, 0.0]);
        }
        work
    }
}

/// Lists of the tasks of some tiles.
struct TaskLists<'a, S> {
    blocks: &'a mut [ElementBlock<S>],
    tasks: &'a mut [StoredTask],
    quiescence: &'a mut [TaskQuiescence],
    tiles: TileTasks<'a>,
}

impl<S: Send> TaskLists<'_, S> {
    /// Updates the tasks by `run`, on several threads if permitted. Tiles are divided among threads by halves.
    fn update<F>(self, threads: bool, run: &F)
    where
        F: Fn((usize, &mut [ElementBlock<S>]), (&mut StoredTask, &mut TaskQuiescence), &mut [BlockCornerForces]) + Sync,
    {
        let Some(count) = self.tiles.half() else { return with_ring(|ring| self.update_tile(ring, run)) };
        let (first, second) = self.split(count);
        if threads {
            rayon::join(|| first.update(threads, run), || second.update(threads, run));
        } else {
            first.update(threads, run);
            second.update(threads, run);
        }
    }

    fn update_tile<F>(mut self, ring: &mut CornerForces, run: &F)
    where
        F: Fn((usize, &mut [ElementBlock<S>]), (&mut StoredTask, &mut TaskQuiescence), &mut [BlockCornerForces]),
    {
        let own = self.tasks.iter_mut().zip(self.quiescence);
        for (task, (blocks, own)) in self.tiles.tasks.clone().zip(self.blocks.chunks_mut(TASK).zip(own)) {
            let corners = ring.slots(blocks_in_ring(task, blocks.len()));
            run((task, blocks), own, corners);
            self.tiles.complete(task, ring);
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

/// Input that all blocks of a pass share.
struct PassContext<'a, M> {
    material: &'a M,
    constants: &'a ElementConstants,
    count: usize,
    nodes: &'a [Node],
    /// Length of the increment, and the accelerations that moved the nodes over it.
    dt: f64,
    before: NodeAccelerations<'a>,
    time: f64,
    cap: f64,
    dilation_correction: Option<&'a [Lanes]>,
    prefetches: bool,
    /// Whether corner forces are in a ring.
    tiled: bool,
}

/// Blocks by which stresses and corner forces are requested before their update, and nodes, whose indices must be known.
const AHEAD: [usize; 2] = [2, 1];

/// Update of the blocks of one task.
struct QuadTask<'a, M: Material> {
    pass: &'a PassContext<'a, M>,
    arch: Arch,
    index: usize,
    blocks: &'a mut [ElementBlock<M::State>],
    corners: &'a mut [BlockCornerForces],
    stored: &'a mut StoredTask,
    scratch: &'a mut TaskWorkspace,
}

impl<M: Material> QuadTask<'_, M> {
    /// Requests what later blocks than this one read and write. Blocks of a group follow each other in memory, also across
    /// tasks.
    #[inline(always)]
    fn prefetch(&self, block: usize) {
        let [blocks, nodes] = AHEAD;
        let size = size_of::<ElementBlock<M::State>>() / size_of::<f64>();
        request(self.blocks[block].stress.as_flattened(), blocks * size, size);
        if !self.pass.tiled {
            request(self.corners[block].as_flattened().as_flattened(), blocks * 8 * LANES, 8 * LANES);
        }
        self.scratch.prefetch_controls(block + blocks);
        let Some(next) = self.blocks.get(block + nodes) else { return };
        for &node in [next.nodes[0], next.nodes[2]].as_flattened().iter().step_by(2) {
            request_entry(self.pass.nodes, node as usize);
        }
    }
}

impl<M: Material> NullaryFnOnce for QuadTask<'_, M> {
    type Output = ();

    /// Updates the blocks of the task. It is inlined into a function compiled for the selected instruction set.
    #[inline(always)]
    fn call(self) {
        let pass = self.pass;
        self.stored.exchange(self.scratch);
        self.scratch.begin(self.arch, pass.cap, pass.dt, pass.constants);
        let mut places = CornerNodes::default();
        for i in 0..self.blocks.len() {
            if pass.prefetches {
                self.prefetch(i);
            }
            let (block, scratch) = (&mut self.blocks[i], &mut *self.scratch);
            let index = self.index * TASK + i;
            scratch.prepare(index, i, pass.count - index * LANES);
            places.collect(pass.nodes, &block.nodes);
            scratch.strain.averaging = pass.dilation_correction.map(|list| list[index]);
            pass.material.begin(&mut block.state, pass.time);
            let (increment, corners) = ((pass.dt, pass.before), &mut self.corners[i]);
            block.update(pass.material, pass.constants, increment, &mut places, scratch, corners);
            if !scratch.task.records.is_empty() {
                let increment = (scratch.strain.spin, pass.dt);
                scratch.update_record(self.arch, i, M::FLOW, increment);
            }
        }
        self.stored.exchange(self.scratch);
        self.stored.set_sums(self.scratch);
    }
}

/// Appends the boundaries of elements whose deletion has not been listed, and marks them as listed.
pub(super) fn list_deleted(group: &dyn ElementGroup, listed: &mut [bool], deleted: &mut Vec<ElementNodes>) {
    for (element, listed) in listed.iter_mut().enumerate() {
        if !*listed && group.is_deleted(element) {
            *listed = true;
            deleted.push(group.boundary(element));
        }
    }
}

/// Combines the sums and the largest deformations of tasks, in their order; rates of a task are limited to `most`.
pub(super) fn totals(tasks: impl Iterator<Item = (LaneSums, [Lanes; 2])>, most: impl Fn(usize) -> f64) -> GroupTotals {
    let mut totals = GroupTotals::default();
    let mut largest = 0.0;
    for (task, (sums, deformed)) in tasks.enumerate() {
        let most = most(task);
        let [strain, dilation] = deformed.inline_map(|list| list.iter().fold(0.0, |most: f64, x| most.max(*x)).sqrt());
        totals.deformed = totals.deformed.max(strain + 0.5 * dilation);
        totals.internal += across(&sums.internal);
        totals.plastic += across(&sums.plastic);
        totals.damaged += across(&sums.damaged);
        totals.viscous += across(&sums.viscous);
        totals.artificial += across(&sums.artificial);
        for (l, (&rate, &block)) in sums.rate.iter().zip(&sums.limiting).enumerate() {
            let rate = if rate > most { most } else { rate };
            if is_larger(rate, largest) {
                largest = rate;
                totals.limiting = block as usize * LANES + l;
            }
        }
    }
    totals.rate = 0.5 * largest;
    totals
}

#[cfg(test)]
mod tests {
    use pulp::Arch;

    use super::{ElementGroup, ElementPass, NodeAccelerations, QuadGroup};
    use crate::element::constants::{ElementConstants, HourglassControl};
    use crate::kernel::bulk_viscosity::BulkViscosity;
    use crate::kernel::lanes::LANES;
    use crate::material::plasticity::PiecewiseLinearHardening;
    use crate::material::volumetric::ConstantBulkModulus;
    use crate::material::von_mises::VonMises;
    use crate::routines::PointRoutines;
    use crate::state::Instant;
    use crate::state::nodes::Node;

    #[test]
    fn every_instruction_set_gives_the_same_bits() {
        let (columns, rows) = (5, 4);
        let wobble = |i: usize| ((i * 7919) % 101) as f64 * 1e-3;
        let node = |n: usize| {
            let (i, j) = (n % (columns + 1), n / (columns + 1));
            Node { r: i as f64 + wobble(n), z: j as f64 - wobble(n + 3), v_r: wobble(n + 5), v_z: wobble(n + 9) }
        };
        let nodes: Vec<Node> = (0..(columns + 1) * (rows + 1)).map(node).collect();
        let corner = |e: usize| {
            let first = (e / columns * (columns + 1) + e % columns) as u32;
            let row = columns as u32 + 1;
            [first, first + 1, first + row + 1, first + row]
        };
        let elements: Vec<[u32; 4]> = (0..columns * rows).map(corner).collect();
        let constants = ElementConstants {
            bulk: 3.0,
            shear: 1.0,
            hourglass: HourglassControl { stiffness: 0.005, viscosity: 0.01, relaxes: true, enhanced: 0.0 },
            bulk_viscosity: BulkViscosity::default(),
            shear_viscosity: 0.0,
            by_area: false,
        };
        let run = |arch: Arch| {
            let lines = PiecewiseLinearHardening::new(&[[0.02, 0.0], [0.03, 0.1]], 1.0).expect("slopes fall");
            let mut quads =
                QuadGroup::new(VonMises::new(lines, ConstantBulkModulus), constants, 2.0, &elements, &nodes).on(arch);
            let mut corners = vec![[[[0.0; LANES]; 2]; 4]; elements.len().div_ceil(LANES)];
            let totals = (0..3).map(|_| {
                let now = &Instant::default();
                quads.update(ElementPass {
                    nodes: &nodes,
                    dt: 0.3,
                    before: NodeAccelerations::default(),
                    now,
                    threads: false,
                    user: PointRoutines::default(),
                    corners: &mut corners,
                    tiles: None,
                    dilation_correction: None,
                    prefetches: !matches!(arch, Arch::Scalar),
                })
            });
            let totals = totals.last().expect("totals");
            let corners: Vec<u64> =
                corners.as_flattened().as_flattened().as_flattened().iter().map(|f| f.to_bits()).collect();
            assert!(totals.plastic > 0.0 && totals.rate > 0.0);
            (corners, totals)
        };
        let plain = run(Arch::Scalar);
        assert_eq!(plain, run(Arch::new()));
        #[cfg(target_arch = "x86_64")]
        if let Some(v3) = pulp::x86::V3::try_new() {
            assert_eq!(plain, run(Arch::V3(v3)));
        }
    }
}
