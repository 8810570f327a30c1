//! A group of elements: its blocks, dispatched to the instruction set of the machine, spread over threads.
//! Never here: arithmetic.

use std::sync::Arc;

use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

use crate::element::block::{ElementBlock, Nodes, Sums, Workspace, across, is_larger};
use crate::element::calls::Calls;
use crate::element::constants::{Constants, damped};
use crate::element::numbers::{Forces, IncrementInput, Numbers, widen};
use crate::element::quiescent::Quiescence;
use crate::element::record::{Followed, Record};
use crate::element::subzonal::Subzones;
use crate::kernel::lanes::LANES;
use crate::kernel::lanes::{Corners, InlineMap};
use crate::kernel::lanes::{Lanes, wide};
use crate::kernel::quad;
use crate::kernel::real::Real;
use crate::kernel::shell::Frame;
use crate::kernel::topology::{ElementNodes, MOST_NODES, PerNode, Topology};
use crate::material::{BlockStart, Material, PlasticFlow, PointValue};
use crate::mesh::corner_forces::Slots;
use crate::state::Instant;
use crate::state::archive::{Archive, Persist, persist_fields, persist_struct};
use crate::state::halt::Halt;
use crate::state::nodes::{Accelerated, Node};
use crate::user::AtPoints;
use crate::variables::{Part, Variable};

/// Blocks of one task of a thread: fixed, so that sums do not depend on the number of threads.
pub(crate) const TASK: usize = 16;

/// What an increment of a group came to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Totals {
    /// Work of the stress.
    pub internal: f64,
    /// Plastic dissipation.
    pub plastic: f64,
    /// Work of the bulk viscosity.
    pub viscous: f64,
    /// Work of the hourglass control.
    pub artificial: f64,
    /// One over the stable increment.
    pub rate: f64,
    /// Element (of the group) that limits it.
    pub limiting: usize,
    /// By how much what deformed in this increment can raise a frequency, relative: gradients by the largest strain (the norm
    /// of the tensor), the root of the volume by half its largest change. 0 unless frequencies are capped.
    pub deformed: f64,
}

/// What does not differ between the elements of a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GroupProperties {
    /// Shape of the elements.
    pub topology: Topology,
    /// Whether the numbers are in single precision.
    pub single: bool,
    /// Whether elements can be deleted at all.
    pub deletable: bool,
    /// Whether bulk viscosity damps the highest modes.
    pub damped: bool,
    /// Whether the pressure follows from density, energy or the whole deformation, so that no initial stress can be given.
    pub holds_pressure: bool,
    /// Number of field variables that elements hold.
    pub fields: usize,
}

/// Elements of one topology and one material.
#[allow(clippy::len_without_is_empty)] // It is a method of `dyn ElementGroup`.
pub trait ElementGroup: Persist + Send + Sync {
    /// Number of elements.
    fn len(&self) -> usize;
    /// What all elements have in common.
    fn properties(&self) -> GroupProperties;
    /// Nodes of an element in the order of the topology; of shells their rotations, too.
    fn nodes(&self, element: usize) -> ElementNodes;
    /// Lumped masses that an element gives to its nodes; rotary inertias to rotations.
    fn masses(&self, element: usize) -> PerNode<f64>;
    /// Updates stresses to the end of an increment, and the forces on the nodes.
    fn update(&mut self, pass: Pass<'_>) -> Totals;
    /// Value of a variable that an element holds; `None` where it does not have it, or where it follows by a formula.
    fn value(&self, element: usize, part: Part) -> Option<f64>;
    /// One over the stable increment of an element on the present nodes, by the bound of the inner loop with linear bulk viscosity
    /// alone and without a bound of the whole scene. With other masses than its own, `None` where masses cannot be scaled.
    fn stable_rate(&self, element: usize, masses: Option<&[f64]>, nodes: &[Node]) -> Option<f64>;
    /// Elastic stiffness of an element on the present nodes; `None` where it is not linear, so that no highest frequency follows
    /// from it.
    fn stiffness(&self, element: usize, nodes: &[Node]) -> Option<Stiffness>;
    /// Whether a task of elements is passed over because all of it is at rest and free of stress.
    fn is_quiescent(&self, _task: usize) -> bool {
        false
    }
    /// Bytes that the elements occupy.
    fn bytes(&self) -> usize;
    /// Another group in the same state.
    fn copy(&self) -> Box<dyn ElementGroup>;
    /// What the group can do beside increments.
    fn extensions(&mut self) -> &mut dyn Extensions;
}

impl dyn ElementGroup + '_ {
    /// Whether there is no element.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Shape of the elements.
    pub fn topology(&self) -> Topology {
        self.properties().topology
    }

    /// Whether the boundary of an element encloses its volume.
    pub fn is_solid(&self) -> bool {
        self.topology().is_solid()
    }

    /// Blocks of corner forces of all elements.
    pub fn force_blocks(&self) -> usize {
        self.len().div_ceil(LANES) * self.topology().force_blocks()
    }

    /// Nodes around an element, without rotations.
    pub fn boundary(&self, element: usize) -> ElementNodes {
        self.nodes(element).first(self.topology().boundary())
    }

    /// Corner nodes of the quadrilaterals that a solid element consists of.
    pub fn cells(&self, element: usize) -> impl Iterator<Item = [u32; 4]> {
        let nodes = self.nodes(element);
        self.topology().cells().iter().map(move |cell| cell.inline_map(|i| nodes[i]))
    }

    /// Whether an element is deleted.
    pub fn is_deleted(&self, element: usize) -> bool {
        self.value(element, Variable::Status.into()) == Some(0.0)
    }

    /// Volume of an element on the present nodes.
    pub fn volume(&self, element: usize, nodes: &[Node]) -> f64 {
        self.volume_at(element, |n| nodes[n as usize].place())
    }

    /// Volume of an element whose nodes have these places.
    pub fn volume_at(&self, element: usize, place: impl Fn(u32) -> [f64; 2]) -> f64 {
        if self.is_solid() {
            return self.cells(element).map(|cell| quad::volume(cell.inline_map(&place))).sum();
        }
        let (nodes, thickness) = (self.nodes(element), self.value(element, Variable::Thickness.into()));
        Frame::new([0, 1].inline_map(|i| place(nodes[i]))).area() * thickness.unwrap_or(0.0)
    }
}

/// Elastic stiffness of an element: `[r, z]` of each node in turn.
#[derive(Clone, Copy, Debug)]
pub struct Stiffness(pub [[f64; 2 * MOST_NODES]; 2 * MOST_NODES]);

impl<const N: usize> From<[[f64; N]; N]> for Stiffness {
    fn from(list: [[f64; N]; N]) -> Self {
        let mut matrix = [[0.0; 2 * MOST_NODES]; 2 * MOST_NODES];
        matrix.iter_mut().zip(list).for_each(|(row, own)| row[..N].copy_from_slice(&own));
        Stiffness(matrix)
    }
}

/// What a group can do beside increments; `None` where it has nothing of the kind.
pub trait Extensions {
    /// Settings of the run.
    fn settings(&mut self) -> &mut dyn Settings;
    /// Deletion of elements.
    fn deletion(&mut self) -> &mut dyn Deletion;
    /// State at the start.
    fn initial_state(&mut self) -> &mut dyn InitialState;
    /// Temperatures that are given from outside.
    fn temperatures(&mut self) -> Option<&mut dyn Temperatures> {
        None
    }
    /// Field variables.
    fn fields(&mut self) -> Option<&mut dyn Fields> {
        None
    }
    /// Routines of the user that elements call.
    fn user(&mut self) -> Option<&mut dyn UserCalls> {
        None
    }
}

/// Settings of a run that a group follows.
pub trait Settings {
    /// Gives the nodes of an element other masses.
    fn set_masses(&mut self, element: usize, masses: &[f64]);
    /// Follows strains and energies from now on, because an output asks for them.
    fn follow(&mut self);
    /// Sets the highest frequency of the whole scene, angle over time; infinite if it is not known.
    fn limit_frequency(&mut self, _frequency: f64) {}
    /// Uses another instruction set from now on; the bits stay the same.
    fn use_instructions(&mut self, _arch: Arch) {}
}

/// Elements that are deleted.
pub trait Deletion {
    /// Allows [`Deletion::erode`].
    fn make_erodible(&mut self);
    /// Deletes an element of this volume at the start, where it is solid; [`Deletion::newly_deleted`] does not list it.
    fn erode(&mut self, element: usize, volume: f64);
    /// Adds the boundaries of elements that the last update deleted.
    fn newly_deleted(&mut self, _deleted: &mut Vec<ElementNodes>) {}
}

/// State of elements at the start. What an element does not hold is left alone.
pub trait InitialState {
    /// Sets stress and temperature.
    fn set(&mut self, element: usize, stress: Option<[f64; 4]>, temperature: Option<f64>);
    /// Sets a state variable of the user, counted from 0; whether the element keeps it.
    fn set_state(&mut self, _element: usize, _variable: usize, _value: f64) -> bool {
        false
    }
    /// Sets the equivalent plastic strain; whether the material hardens by it alone.
    fn set_plastic_strain(&mut self, _element: usize, _strain: f64) -> bool {
        false
    }
    /// Sets the energy a mass.
    fn set_energy(&mut self, _element: usize, _energy: f64) {}
    /// Sets another characteristic length than the root of the area.
    fn set_length(&mut self, _element: usize, _length: f64) {}
}

/// Temperatures of elements.
pub trait Temperatures {
    /// Sets the temperatures of all elements.
    fn set_temperatures(&mut self, temperatures: &[f64]);
    /// Writes the temperatures that elements hold, plastic work counted; leaves alone what holds none.
    fn temperatures(&self, out: &mut [f64]);
    /// Subtracts increments of the thermal strain from the strains of the next update, which covers the increment `dt` that ends
    /// at these nodes. Returns the work of the stress that the update will book too little.
    fn expand(&mut self, strains: &[f64], nodes: &[Node], dt: f64) -> f64;
}

/// Field variables of elements, counted from 0 and below [`GroupProperties::fields`].
pub trait Fields {
    /// Sets a variable of an element at the start.
    fn set_field(&mut self, element: usize, variable: usize, value: f64);
    /// Sets a variable of all elements.
    fn set_fields(&mut self, variable: usize, values: &[f64]);
}

/// Routines of the user that a group calls.
pub trait UserCalls {
    /// Asks for what must be known when the analysis begins, before masses are scaled and a highest frequency is estimated: the
    /// moduli of a user's material.
    ///
    /// # Errors
    /// The routine's, and an answer that is not elastic.
    fn probe(&mut self, nodes: &[Node], now: &Instant, user: AtPoints<'_>) -> Result<(), Halt>;
    /// Why the last update gave no stress.
    fn failure(&self) -> Option<Halt>;
}

/// What a pass over the elements of a group is given.
pub struct Pass<'a> {
    /// All nodes, where they are now.
    pub nodes: &'a [Node],
    /// Length of the increment behind.
    pub dt: f64,
    /// What carried nodes over it.
    pub before: Accelerated<'a>,
    /// Now.
    pub now: &'a Instant,
    /// Whether other threads may take part.
    pub threads: bool,
    /// The user's routines that are asked at points, where there are some.
    pub user: AtPoints<'a>,
    /// Where the corner forces of the group's blocks go.
    pub corners: Slots<'a>,
    /// What the volumetric strain increments lack to be averaged ones, block by block; `None` where each element has its own.
    pub lacking: Option<&'a [Lanes]>,
}

impl Clone for Box<dyn ElementGroup> {
    fn clone(&self) -> Self {
        self.copy()
    }
}

/// Elements of a group from which on it pays to wake other threads every increment.
pub(super) const PARALLEL: usize = 1000;

/// Quadrilaterals of one material, weighted by volume or by area, in double precision or in single.
pub struct Quads<M: Material<T>, const AREA: bool = false, T: Numbers = f64> {
    pub(super) material: Arc<M>,
    pub(super) constants: Constants,
    pub(super) count: usize,
    pub(super) blocks: Vec<ElementBlock<M::State, T>>,
    pub(super) tasks: Vec<Workspace<T>>,
    /// Scratch memory of user subroutines; `None` without any.
    pub(super) calls: Option<Box<Calls<T>>>,
    /// Unit of lengths and times of both.
    length: f64,
    /// Speed of sound to a power of two, beside which velocities are rounded; 0 in double precision.
    sound: f64,
    pub(super) arch: Arch,
    /// Elements whose deletion has been told.
    told: Vec<bool>,
    quiescence: Vec<Quiescence>,
    /// Highest frequency that counts.
    pub(super) cap: f64,
}

impl<M: Material> Quads<M> {
    /// Elements by their corner nodes, at their places now.
    pub fn new(material: M, constants: Constants, density: f64, elements: &[[u32; 4]], nodes: &[Node]) -> Self {
        Quads::weighted(material, constants, density, elements, nodes)
    }
}

impl<M: Material<T>, const AREA: bool, T: Numbers> Quads<M, AREA, T> {
    /// The same on another instruction set, which gives the same bits.
    #[must_use]
    pub fn on(mut self, arch: Arch) -> Self {
        self.arch = arch;
        self
    }

    /// The same with subzonal pressures, of elements at their places at the start.
    #[must_use]
    pub fn with_subzones(mut self, elements: &[[u32; 4]], nodes: &[Node]) -> Self {
        for (scratch, part) in self.tasks.iter_mut().zip(elements.chunks(TASK * LANES)) {
            scratch.task.subzones = part.chunks(LANES).map(|block| Subzones::of(block, nodes)).collect();
        }
        self
    }

    /// The same, weighted by volume or by area.
    pub fn weighted(material: M, constants: Constants, density: f64, elements: &[[u32; 4]], nodes: &[Node]) -> Self {
        let length = T::length(extremes(elements, nodes));
        let fresh = |(index, part): (usize, &[_])| {
            let state = material.initial_state(&block_start(index * LANES, part, nodes));
            let mut block = block(state, (density, length), part, nodes);
            if AREA {
                block.inverse_mass = [
                    block.mass.inline_map(|mass| T::of(16.0) / mass),
                    [T::ZERO; LANES],
                    [T::ZERO; LANES],
                    [T::ZERO; LANES],
                ];
            }
            block
        };
        let blocks: Vec<_> = elements.chunks(LANES).enumerate().map(fresh).collect();
        Quads {
            calls: material.calls().map(|calls| Box::new(Calls::new(calls, &constants, elements.len()))),
            material: Arc::new(material),
            constants,
            count: elements.len(),
            tasks: blocks.chunks(TASK).map(|part| Workspace::new(&constants, length, part.len())).collect(),
            blocks,
            length,
            sound: T::sound((constants.bulk + 4.0 / 3.0 * constants.shear) / density),
            arch: Arch::new(),
            quiescence: Quiescence::of_tasks(elements),
            told: if M::FAILS { vec![false; elements.len()] } else { Vec::new() },
            cap: f64::INFINITY,
        }
    }
}

impl<M: Material<T>, const AREA: bool, T: Numbers> Clone for Quads<M, AREA, T> {
    fn clone(&self) -> Self {
        Quads {
            material: Arc::clone(&self.material),
            calls: self.calls.clone(),
            constants: self.constants,
            count: self.count,
            blocks: self.blocks.clone(),
            tasks: self.tasks.clone(),
            length: self.length,
            sound: self.sound,
            arch: self.arch,
            told: self.told.clone(),
            quiescence: self.quiescence.clone(),
            cap: self.cap,
        }
    }
}

impl<M: Material<T>, const AREA: bool, T: Numbers> Quads<M, AREA, T> {
    /// What is followed of an element; `None` if nothing is.
    fn followed(&self, element: usize) -> Option<Followed> {
        let block = element / LANES;
        Some(self.tasks[block / TASK].task.records.get(block % TASK)?.of(element % LANES))
    }

    /// Whether the pressure, and with it the mass, is part of the state.
    const HOLDS_PRESSURE: bool = M::MODULI_VARY && !matches!(M::FLOW, PlasticFlow::Coupled);

    /// Sets a value of an element; whether its material uses it.
    fn set_value(&mut self, element: usize, value: PointValue) -> bool {
        self.material.set(&mut self.blocks[element / LANES].state, element % LANES, value)
    }

    fn corners(&self, element: usize) -> [u32; 4] {
        [0, 1, 2, 3].inline_map(|c| self.blocks[element / LANES].nodes[c][element % LANES])
    }

    fn corner_masses(&self, element: usize) -> [f64; 4] {
        self.blocks[element / LANES].corner_masses(element % LANES).inline_map(|mass| self.unit() * mass)
    }

    fn is_deleted(&self, element: usize) -> bool {
        let status = self.material.value(&self.blocks[element / LANES].state, element % LANES, Variable::Status.into());
        status == Some(0.0) || self.is_eroded(element)
    }

    pub(super) fn totals(&self) -> Totals {
        let Constants { bulk, shear, bulk_viscosity: [linear, _], .. } = self.constants;
        let xi = linear * (bulk + 4.0 / 3.0 * shear) / bulk;
        let still = self.cap * damped(xi);
        let totals = totals(self.tasks.iter().map(Workspace::parts), |task| {
            if self.quiescence[task].quiescent { still } else { f64::INFINITY }
        });
        Totals { rate: self.constants.with_assumed(totals.rate, self.cap), ..totals }
    }

    /// Unit of energies and masses of the blocks.
    fn unit(&self) -> f64 {
        self.length * self.length * self.length
    }

    /// Whether an element was deleted from outside.
    fn is_eroded(&self, element: usize) -> bool {
        let block = element / LANES;
        self.tasks[block / TASK].task.eroded.get(block % TASK).is_some_and(|e| e.has(element % LANES))
    }
}

#[cfg(test)]
impl<M: Material<T>, const AREA: bool, T: Numbers> Quads<M, AREA, T> {
    /// Lets no task become quiescent, by counting a node that never rests.
    pub fn keep_awake(&mut self, node: u32) {
        self.quiescence.iter_mut().for_each(|resting| resting.nodes.push(node));
    }
}

/// Elements of a block at their places at the start. Lanes behind the last element repeat it.
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

/// The least and the largest volume of elements.
fn extremes(elements: &[[u32; 4]], nodes: &[Node]) -> [f64; 2] {
    let volumes = elements.iter().map(|corners| quad::volume(corners.inline_map(|n| nodes[n as usize].place())));
    volumes.fold([f64::INFINITY, 0.0], |[least, largest], volume| [least.min(volume), largest.max(volume)])
}

/// A block of at most eight elements at rest, in units of a length.
fn block<S, T: Real>(
    state: S,
    (density, length): (f64, f64),
    elements: &[[u32; 4]],
    nodes: &[Node],
) -> ElementBlock<S, T> {
    let unit = length * length * length;
    let mut block = ElementBlock {
        nodes: [[0; LANES]; 4],
        stress: [[T::ZERO; LANES]; 4],
        mass: [T::ZERO; LANES],
        inverse_mass: [[T::ZERO; LANES]; 4],
        state,
    };
    for l in 0..LANES {
        // Lanes behind the last element repeat it; nothing reads their answers.
        let element = elements[l.min(elements.len() - 1)];
        let corners = element.inline_map(|n| nodes[n as usize].place());
        let inverse_mass = quad::sums(quad::corner_masses(corners, density).inline_map(|mass| 1.0 / mass));
        for i in 0..4 {
            block.nodes[i][l] = element[i];
            block.inverse_mass[i][l] = T::of(unit * inverse_mass[i]);
        }
        block.mass[l] = T::of(density * quad::volume(corners) / unit);
    }
    block
}

/// A block of points of other elements at rest, with their masses.
pub(super) fn block_of_points<S>(state: S, mass: Lanes) -> ElementBlock<S> {
    let (nodes, zeros) = ([[0; LANES]; 4], [[0.0; LANES]; 4]);
    ElementBlock { nodes, stress: zeros, mass, inverse_mass: zeros, state }
}

impl<M: Material<T>, const AREA: bool, T: Numbers> ElementGroup for Quads<M, AREA, T> {
    fn len(&self) -> usize {
        self.count
    }

    fn properties(&self) -> GroupProperties {
        GroupProperties {
            topology: Topology::Quadrilateral,
            single: T::SINGLE,
            deletable: self.material.can_delete() || self.tasks.iter().any(|scratch| !scratch.task.eroded.is_empty()),
            damped: self.constants.damps(),
            holds_pressure: Self::HOLDS_PRESSURE,
            fields: self.material.calls().map_or(0, |calls| calls.fields()),
        }
    }

    fn nodes(&self, element: usize) -> ElementNodes {
        self.corners(element).into()
    }

    fn masses(&self, element: usize) -> PerNode<f64> {
        self.corner_masses(element).into()
    }

    fn update(&mut self, pass: Pass<'_>) -> Totals {
        if M::CALLS {
            return self.update_with_calls(pass);
        }
        let Pass { nodes, dt, before, now, threads, corners, lacking, .. } = pass;
        let pass = Common {
            material: &*self.material,
            constants: &self.constants,
            count: self.count,
            nodes,
            increment: IncrementInput { dt, before },
            sound: self.sound,
            time: now.total_time,
            cap: self.cap,
            lacking,
        };
        let arch = self.arch;
        let run = |index,
                   blocks: &mut [ElementBlock<M::State, T>],
                   mut corners: Forces<'_, T>,
                   scratch: &mut Workspace<T>,
                   resting: &mut Quiescence| {
            if resting.quiescent && lacking.is_none() && resting.is_still(nodes) {
                return;
            }
            let task =
                Task::<M, AREA, T> { pass: &pass, arch, index, blocks: &mut *blocks, corners: &mut corners, scratch };
            arch.dispatch(task);
            // Without an increment behind nothing has been added to the sums, so they hold while the task is quiescent. The
            // pressure of an equation of state is not in the state looked at here.
            resting.quiescent = dt == 0.0
                && lacking.is_none()
                && !M::MODULI_VARY
                && corners.are_zero()
                && blocks.iter().all(|b| b.stress.as_flattened().iter().all(|x| *x == T::ZERO))
                && resting.is_still(nodes);
        };
        if !threads || self.count < PARALLEL {
            let parts = self.blocks.chunks_mut(TASK).zip(self.tasks.iter_mut().zip(&mut self.quiescence)).enumerate();
            let each = |((i, (blocks, (own, resting))), corners)| run(i, blocks, corners, own, resting);
            match T::forces(corners) {
                Forces::Own(list) => parts.zip(list.chunks_mut(TASK).map(Forces::Own)).for_each(each),
                // Not compiled for double precision.
                Forces::Wider(list) if T::SINGLE => {
                    parts.zip(list.chunks_mut(TASK).map(Forces::Wider)).for_each(each);
                }
                Forces::Wider(_) => {}
            }
        } else {
            let parts = self.tasks.par_iter_mut().zip(&mut self.quiescence);
            let parts = self.blocks.par_chunks_mut(TASK).zip(parts).enumerate();
            let each = |((i, (blocks, (own, resting))), corners): ((_, (&mut [_], (&mut _, &mut _))), _)| {
                run(i, blocks, corners, own, resting);
            };
            match T::forces(corners) {
                Forces::Own(list) => parts.zip(list.par_chunks_mut(TASK).map(Forces::Own)).for_each(each),
                Forces::Wider(list) if T::SINGLE => {
                    parts.zip(list.par_chunks_mut(TASK).map(Forces::Wider)).for_each(each);
                }
                Forces::Wider(_) => {}
            }
        }
        self.totals()
    }

    fn value(&self, element: usize, part: Part) -> Option<f64> {
        let (block, lane) = (&self.blocks[element / LANES], element % LANES);
        match part.variable {
            Variable::Stress => Some(block.stress.get(part.component)?[lane].wide()),
            Variable::Mass => Some(self.unit() * block.mass[lane].wide()),
            Variable::Status => Some(f64::from(u8::from(!self.is_deleted(element)))),
            Variable::PlasticComponents if matches!(M::FLOW, PlasticFlow::None | PlasticFlow::Unknown) => None,
            // What the material alone knows of dissipation is no part of the energy that is followed.
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
        let (block, lane) = (element / LANES, element % LANES);
        let masses = match masses {
            // Where the pressure follows from density or energy a mass, the mass is part of the state.
            Some(_) if Self::HOLDS_PRESSURE || AREA => return None,
            None if Self::HOLDS_PRESSURE => {
                let rates = self.tasks[block / TASK].task.own_rates.get(block % TASK);
                return Some(rates.map_or(0.0, |rates| 0.5 * rates[lane].wide()));
            }
            Some(masses) => *masses.first_chunk()?,
            None => self.corner_masses(element),
        };
        let corners = self.corners(element).inline_map(|n| nodes[n as usize].place());
        Some(self.constants.own_rate(corners, &masses))
    }

    fn stiffness(&self, element: usize, nodes: &[Node]) -> Option<Stiffness> {
        if Self::HOLDS_PRESSURE || AREA {
            return None;
        }
        let corners = self.corners(element).inline_map(|n| nodes[n as usize].place());
        Some(self.constants.stiffness(corners, self.is_deleted(element)).into())
    }

    fn is_quiescent(&self, task: usize) -> bool {
        self.quiescence[task].quiescent
    }

    fn bytes(&self) -> usize {
        let kept: usize = self.tasks.iter().map(Workspace::bytes).sum();
        let quiescence: usize = self.quiescence.iter().map(Quiescence::bytes).sum();
        let states: usize = self.blocks.iter().map(|block| self.material.bytes(&block.state)).sum();
        let calls = self.calls.as_ref().map_or(0, |calls| calls.bytes());
        let names = self.material.calls().map_or(0, |calls| calls.bytes());
        let arrays = size_of_val(&*self.blocks) + size_of_val(&*self.tasks) + self.told.capacity();
        arrays + kept + quiescence + states + calls + names
    }

    fn copy(&self) -> Box<dyn ElementGroup> {
        Box::new(self.clone())
    }

    fn extensions(&mut self) -> &mut dyn Extensions {
        self
    }
}

impl<M: Material<T>, const AREA: bool, T: Numbers> Extensions for Quads<M, AREA, T> {
    fn settings(&mut self) -> &mut dyn Settings {
        self
    }

    fn deletion(&mut self) -> &mut dyn Deletion {
        self
    }

    fn initial_state(&mut self) -> &mut dyn InitialState {
        self
    }

    fn temperatures(&mut self) -> Option<&mut dyn Temperatures> {
        Some(self)
    }

    fn fields(&mut self) -> Option<&mut dyn Fields> {
        if M::CALLS { Some(self) } else { None }
    }

    fn user(&mut self) -> Option<&mut dyn UserCalls> {
        if M::CALLS { Some(self) } else { None }
    }
}

impl<M: Material<T>, const AREA: bool, T: Numbers> Fields for Quads<M, AREA, T> {
    fn set_field(&mut self, element: usize, variable: usize, value: f64) {
        self.set_value(element, PointValue::Field(variable, value));
    }

    fn set_fields(&mut self, variable: usize, values: &[f64]) {
        for (element, value) in values.iter().enumerate() {
            self.set_value(element, PointValue::NodalField(variable, *value));
        }
    }
}

impl<M: Material<T>, const AREA: bool, T: Numbers> Settings for Quads<M, AREA, T> {
    fn set_masses(&mut self, element: usize, masses: &[f64]) {
        let Some(masses) = masses.first_chunk::<4>() else { return };
        // The increment that a quiescent task allows is no longer what it was.
        self.quiescence[element / (TASK * LANES)].quiescent = false;
        let masses = masses.inline_map(|mass| mass / self.unit());
        self.blocks[element / LANES].set_corner_masses(element % LANES, masses);
    }

    fn follow(&mut self) {
        for (scratch, blocks) in self.tasks.iter_mut().zip(self.blocks.chunks(TASK)) {
            scratch.task.records = vec![Record::default(); blocks.len()];
        }
    }

    fn limit_frequency(&mut self, frequency: f64) {
        self.cap = self.constants.cap(frequency);
    }

    fn use_instructions(&mut self, arch: Arch) {
        self.arch = arch;
    }
}

impl<M: Material<T>, const AREA: bool, T: Numbers> Deletion for Quads<M, AREA, T> {
    fn make_erodible(&mut self) {
        for (scratch, blocks) in self.tasks.iter_mut().zip(self.blocks.chunks(TASK)) {
            scratch.make_erodible(blocks.len(), Self::HOLDS_PRESSURE);
        }
    }

    fn erode(&mut self, element: usize, volume: f64) {
        let (block, lane) = (element / LANES, element % LANES);
        self.quiescence[block / TASK].quiescent = false;
        // Lanes behind the last element repeat it.
        let behind = if element + 1 == self.count { LANES } else { lane + 1 };
        (lane..behind).for_each(|l| self.tasks[block / TASK].task.eroded[block % TASK].take(l, volume));
        if let Some(told) = self.told.get_mut(element) {
            *told = true;
        }
    }

    fn newly_deleted(&mut self, deleted: &mut Vec<ElementNodes>) {
        if !M::FAILS || self.tasks.iter().all(|scratch| scratch.stress.deleted == 0) {
            return;
        }
        let mut told = std::mem::take(&mut self.told);
        tell_deleted(self, &mut told, deleted);
        self.told = told;
    }
}

impl<M: Material<T>, const AREA: bool, T: Numbers> InitialState for Quads<M, AREA, T> {
    fn set(&mut self, element: usize, stress: Option<[f64; 4]>, temperature: Option<f64>) {
        let (block, lane) = (&mut self.blocks[element / LANES], element % LANES);
        for (list, value) in block.stress.iter_mut().zip(stress.into_iter().flatten()) {
            list[lane] = T::of(value);
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

    fn set_length(&mut self, element: usize, length: f64) {
        self.set_value(element, PointValue::Length(length));
    }
}

impl<M: Material<T>, const AREA: bool, T: Numbers> Temperatures for Quads<M, AREA, T> {
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

    /// Of what expands alike in all directions the thermal strain is a pressure that is taken off the stress beforehand: the
    /// trial is the same to the last term. The work is a trapezoid over the stress, of which the update sees the pressure taken
    /// off already.
    fn expand(&mut self, strains: &[f64], nodes: &[Node], dt: f64) -> f64 {
        let mut work = 0.0;
        for (e, strain) in strains.iter().enumerate().filter(|s| *s.1 != 0.0) {
            if self.is_eroded(e) || self.set_value(e, PointValue::ThermalStrain(*strain)) {
                continue;
            }
            self.quiescence[e / (TASK * LANES)].quiescent = false;
            let (block, lane) = (&mut self.blocks[e / LANES], e % LANES);
            let share = self.material.share(&block.state, lane);
            let pressure = share * 3.0 * self.constants.bulk * strain;
            block.stress[..3].iter_mut().for_each(|list| list[lane] = T::of(list[lane].wide() - pressure));
            let corners = [0, 1, 2, 3].inline_map(|c| nodes[block.nodes[c][lane] as usize]);
            work += 0.5 * pressure * quad::volume_change::<AREA>(corners.inline_map(|n| n.as_array()), dt);
        }
        work
    }
}

/// What all blocks of one pass share.
struct Common<'a, M> {
    material: &'a M,
    constants: &'a Constants,
    count: usize,
    nodes: &'a [Node],
    increment: IncrementInput<'a>,
    /// Speed of sound; 0 in double precision, where nothing asks for it.
    sound: f64,
    time: f64,
    cap: f64,
    lacking: Option<&'a [Lanes]>,
}

/// The blocks that a thread takes at once.
struct Task<'a, 'c, M: Material<T>, const AREA: bool, T: Numbers> {
    pass: &'a Common<'a, M>,
    arch: Arch,
    index: usize,
    blocks: &'a mut [ElementBlock<M::State, T>],
    corners: &'a mut Forces<'c, T>,
    scratch: &'a mut Workspace<T>,
}

impl<M: Material<T>, const AREA: bool, T: Numbers> NullaryFnOnce for Task<'_, '_, M, AREA, T> {
    type Output = ();

    /// Inlined into a function of the machine's instruction set.
    #[inline(always)]
    fn call(self) {
        let scratch = self.scratch;
        let pass = self.pass;
        scratch.begin(self.arch, pass.cap, pass.increment.dt, pass.constants);
        let mut places = Nodes::default();
        let mut own = Corners::default();
        for (i, block) in self.blocks.iter_mut().enumerate() {
            let index = self.index * TASK + i;
            scratch.prepare(index, i, pass.count - index * LANES);
            places.collect(pass.nodes, &block.nodes, pass.sound);
            scratch.strain.averaging = pass.lacking.map(|list| list[index]);
            pass.material.begin(&mut block.state, pass.time);
            let corners = match self.corners {
                Forces::Own(list) => &mut list[i],
                Forces::Wider(_) => &mut own,
            };
            let increment = &pass.increment;
            T::update::<M, AREA>(block, pass.material, pass.constants, increment, &mut places, scratch, corners);
            if let Forces::Wider(list) = self.corners {
                widen(&own, &mut list[i]);
            }
            if !scratch.task.records.is_empty() {
                let increment = (wide(&scratch.strain.spin), increment.dt);
                scratch.follow(self.arch, i, &block.stress, M::FLOW, increment);
            }
        }
    }
}

/// Adds the boundaries of elements whose deletion has not been listed, and counts it as listed.
pub(super) fn tell_deleted(group: &dyn ElementGroup, told: &mut [bool], deleted: &mut Vec<ElementNodes>) {
    for (element, told) in told.iter_mut().enumerate() {
        if !*told && group.is_deleted(element) {
            *told = true;
            deleted.push(group.boundary(element));
        }
    }
}

/// Folds what tasks came to in their order: their sums and what deformed; no rate of a task is larger than `most` says.
pub(super) fn totals(tasks: impl Iterator<Item = (Sums, [Lanes; 2])>, most: impl Fn(usize) -> f64) -> Totals {
    let mut totals = Totals::default();
    let mut largest = 0.0;
    for (task, (sums, deformed)) in tasks.enumerate() {
        let most = most(task);
        let [strain, dilation] = deformed.inline_map(|list| list.iter().fold(0.0, |most: f64, x| most.max(*x)).sqrt());
        totals.deformed = totals.deformed.max(strain + 0.5 * dilation);
        totals.internal += across(&sums.internal);
        totals.plastic += across(&sums.plastic);
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

persist_struct!(Quads<M, AREA, T> [M: Material<T>, const AREA: bool, T: Numbers] {
    cap, blocks: fixed, tasks: fixed, told: fixed, quiescence: fixed
} derived {
    material, constants, calls, count, length, sound, arch
} then persist_called_moduli);

/// The moduli of a user's material are those of its answer at time zero, which is not asked for again.
fn persist_called_moduli<M: Material<T>, const AREA: bool, T: Numbers>(
    quads: &mut Quads<M, AREA, T>,
    archive: &mut Archive<'_>,
) {
    if M::CALLS {
        persist_fields!(archive; &mut quads.constants.bulk, &mut quads.constants.shear);
    }
}

persist_struct!(Totals { internal, plastic, viscous, artificial, rate, limiting, deformed });

#[cfg(test)]
mod tests {
    use pulp::Arch;

    use super::{Accelerated, ElementGroup, Pass, Quads};
    use crate::element::constants::{Constants, HourglassControl};
    use crate::kernel::lanes::Corners;
    use crate::kernel::lanes::LANES;
    use crate::material::plasticity::PiecewiseLinearHardening;
    use crate::material::volumetric::Linear;
    use crate::material::von_mises::VonMises;
    use crate::mesh::corner_forces::Slots;
    use crate::state::Instant;
    use crate::state::nodes::Node;
    use crate::user::AtPoints;

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
        let constants = Constants {
            bulk: 3.0,
            shear: 1.0,
            hourglass: HourglassControl { stiffness: 0.005, viscosity: 0.01, relaxes: true, enhanced: 0.0 },
            bulk_viscosity: [0.06, 1.2],
        };
        let run = |arch: Arch| {
            let lines = PiecewiseLinearHardening::new(&[[0.02, 0.0], [0.03, 0.1]], 1.0).expect("slopes fall");
            let mut quads = Quads::new(VonMises::new(lines, Linear), constants, 2.0, &elements, &nodes).on(arch);
            let mut corners = vec![Corners::default(); elements.len().div_ceil(LANES)];
            let totals = (0..3).map(|_| {
                let now = &Instant::default();
                quads.update(Pass {
                    nodes: &nodes,
                    dt: 0.3,
                    before: Accelerated::default(),
                    now,
                    threads: false,
                    user: AtPoints::default(),
                    corners: Slots::Double(&mut corners),
                    lacking: None,
                })
            });
            let totals = totals.last().expect("totals");
            let corners: Vec<u64> =
                corners.iter().flat_map(|c| c.0.as_flattened().as_flattened()).map(|f| f.to_bits()).collect();
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
