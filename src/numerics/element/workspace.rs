//! State of the tasks of a group other than stress and material, and the scratch memory of their updates.
#![allow(clippy::needless_range_loop)] // Compilers vectorize loops over lanes in this form.

use pulp::Arch;

use super::assumed::AssumedStresses;
use super::constants::ElementConstants;
use super::eroded::ErodedLanes;
use super::lane_sums::{LaneSums, larger};
use super::motion::BlockMotion;
use super::record::{BlockRecord, RecordUpdate};
use super::subzonal::SubzonalPressures;
use crate::kernel::lanes::{InlineMap, LANES, Lanes, column, inline_from_fn};
use crate::kernel::lists::Memory;
use crate::kernel::moduli::ElasticModuli;
use crate::kernel::prefetch::request;
use crate::material::PlasticFlow;
use crate::material::carried::carried_state;
use crate::material::increment::{StrainIncrement, StressUpdate};
use crate::material::user::lengths::middle;
use crate::state::archive::{Persist, StateArchive, persist_fields};
use crate::state::nodes::Node;

/// Corner nodes of a block.
///
/// Loops over lanes read the corners with a stride of four, which compilers turn into a transposition in registers.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub struct CornerNodes(pub [[Node; LANES]; 4]);

impl CornerNodes {
    /// Copies the corner nodes `of` a block.
    #[inline(always)]
    pub fn collect(&mut self, nodes: &[Node], of: &[[u32; LANES]; 4]) {
        for (to, of) in self.0.iter_mut().zip(of) {
            for l in 0..LANES {
                to[l] = nodes[of[l] as usize];
            }
        }
    }

    /// Replaces a deleted element by a ring of its volume at rest, with radii 1 and 2. `height` is the volume of the
    /// element over that of a ring with these radii and height 1.
    pub(super) fn mask(&mut self, l: usize, height: f64) {
        let places = [[1.0, 0.0], [2.0, 0.0], [2.0, height], [1.0, height]];
        self.0.iter_mut().zip(places).for_each(|(to, [r, z])| to[l] = Node { r, z, ..Node::default() });
    }

    /// Returns coordinates of the corners of a lane: along r, or along z.
    #[inline(always)]
    pub(super) fn places(&self, l: usize) -> [[f64; 4]; 2] {
        let corners = self.of(l);
        [corners.inline_map(|node| node.r), corners.inline_map(|node| node.z)]
    }

    /// Returns velocities of the corners of a lane: along r, or along z.
    #[inline(always)]
    pub(super) fn velocities(&self, l: usize) -> [[f64; 4]; 2] {
        let corners = self.of(l);
        [corners.inline_map(|node| node.v_r), corners.inline_map(|node| node.v_z)]
    }

    #[inline(always)]
    fn of(&self, l: usize) -> [Node; 4] {
        let CornerNodes(corners) = self;
        [corners[0][l], corners[1][l], corners[2][l], corners[3][l]]
    }
}

/// Hourglass and viscous stresses of a block until the next increment; zero where the constants have no such stress.
#[derive(Clone, Debug, Default, Persist, Memory)]
#[repr(C, align(64))]
pub(super) struct ControlStresses {
    /// Generalised hourglass stresses along r and z.
    pub(super) hourglass: [Lanes; 2],
    /// Stress of the bulk viscosity.
    pub(super) viscous: Lanes,
    /// Slow part of the volumetric strain rate.
    pub(super) slow_dilation: Lanes,
}

/// Sums of the last pass and state of one task, stored between passes.
#[derive(Clone, Debug, Default, Persist)]
// The sums stay valid while a task is quiescent.
#[persist(derived: deformed, deleted)]
pub struct StoredTask {
    /// With the sums of [`StressUpdate`].
    sums: LaneSums,
    /// See [`TaskWorkspace`].
    deformed: [Lanes; 2],
    /// Number of elements that the material deleted in the last pass.
    pub(super) deleted: usize,
    pub(super) task: TaskState,
}

/// Scratch memory of a thread, with the state of the task that it updates.
#[derive(Clone, Debug, Default, Persist)]
#[repr(C, align(64))]
// The other fields are scratch memory of one pass; the sums stay valid while a task is quiescent.
#[persist(
    derived: stress, recorded, r, z, v_r, v_z, motion, turned, middle, weight, strain, block, at, own_rate, cap,
        arch, deformed;
    then: TaskWorkspace::persist_work
)]
pub struct TaskWorkspace {
    /// Coordinates and velocities of the corners, combined by [`sums`].
    pub(super) r: [Lanes; 4],
    pub(super) z: [Lanes; 4],
    pub(super) v_r: [Lanes; 4],
    pub(super) v_z: [Lanes; 4],
    /// For elements of another shape, set by [`TaskWorkspace::set_gradients`]: spin increments times the volumes at
    /// mid-increment, and the volumes, in [`UNIT`].
    pub(super) turned: Lanes,
    pub(super) middle: Lanes,
    /// Geometry and motion of the block.
    pub(super) motion: BlockMotion,
    /// Weight of each lane: 1, or 0 for lanes without an active element.
    pub(super) weight: Lanes,
    /// Kinematics of the block, and the resulting stress update.
    pub(super) strain: StrainIncrement,
    pub(super) stress: StressUpdate,
    pub(super) sums: LaneSums,
    /// Sums of [`Self::energy_sums`] at the start of the block; only with records.
    recorded: [Lanes; 4],
    pub(super) block: f64,
    /// Index of the block in the task.
    pub(super) at: usize,
    pub(super) task: TaskState,
    /// Two over the stable time increments of the elements of the block.
    pub(super) own_rate: Lanes,
    /// Bound of the highest frequency of the whole model; infinite if unknown.
    pub(super) cap: f64,
    /// Instruction set of the functions that are compiled once for many materials.
    pub(super) arch: Arch,
    /// Largest squares of the strain increment and of the volume change in the pass, lane by lane; computed only with a
    /// finite `cap`.
    pub(super) deformed: [Lanes; 2],
}

/// State of the blocks of a task other than stress and material; each list but the first is empty unless the model needs
/// it.
#[derive(Clone, Debug, Default, Persist, Memory)]
#[persist(fixed: eroded, own_rates, records, controls, enhanced, subzones)]
pub struct TaskState {
    /// Hourglass and viscous stresses.
    pub(super) controls: Vec<ControlStresses>,
    /// Stresses of assumed strains; empty without ENHANCED.
    pub(super) enhanced: Vec<AssumedStresses>,
    /// Subzonal pressures; empty if off.
    pub(super) subzones: Vec<SubzonalPressures>,
    /// Strains and energies for output; empty if not requested.
    pub(super) records: Vec<BlockRecord>,
    /// Elements deleted by `*EROSION`; empty if no element is subject to it.
    pub(super) eroded: Vec<ErodedLanes>,
    /// Two over the stable time increments of elements; empty unless deletion criteria need them and no constant
    /// determines them.
    pub(super) own_rates: Vec<Lanes>,
}

impl TaskWorkspace {
    /// Sets the velocity gradients (rr, zz, hoop, rz, zr) at mid-increment times the volumes there, in [`UNIT`], for
    /// elements of another shape.
    #[inline(always)]
    pub(super) fn set_gradients(&mut self, dt: f64, gradients: &[Lanes; 5], volume: &Lanes) {
        let [rr, zz, hoop, rz, zr] = gradients;
        self.strain.strain = [*rr, *zz, *hoop, inline_from_fn(|l| rz[l] + zr[l])];
        self.turned = inline_from_fn(|l| 0.5 * dt * (rz[l] - zr[l]));
        self.middle = *volume;
    }

    /// Sets the centres of elements or cells from their corners: along r, or along z.
    pub(super) fn set_places(&mut self, corners: impl Fn(usize) -> [[f64; 4]; 2]) {
        for l in 0..LANES {
            let [r, z] = corners(l);
            self.strain.place.iter_mut().zip(middle(r, z)).for_each(|(list, value)| list[l] = value);
        }
    }

    /// Fills all lists with values that are not numbers.
    #[cfg(test)]
    pub(super) fn spoil(&mut self) {
        let (list, lists) = ([f64::NAN; LANES], [[f64::NAN; LANES]; 4]);
        (self.r, self.z, self.v_r, self.v_z, self.recorded, self.deformed) =
            (lists, lists, lists, lists, lists, [list; 2]);
        (self.turned, self.middle, self.weight, self.own_rate, self.motion) =
            (list, list, list, list, BlockMotion::spoilt());
        let sums = LaneSums {
            internal: list,
            plastic: list,
            damaged: list,
            viscous: list,
            artificial: list,
            rate: list,
            limiting: list,
        };
        self.sums = sums;
        let strain = StrainIncrement {
            strain: lists,
            carried: lists,
            spin: list,
            place: [list; 2],
            volume: list,
            current_volume: list,
            mass: list,
            viscous: list,
            dt: f64::NAN,
            moduli: ElasticModuli { bulk: f64::NAN, shear: f64::NAN },
            viscosity: f64::NAN,
            count: LANES,
            averaging: Some(list),
        };
        self.strain = strain;
        self.stress = StressUpdate {
            mean: list,
            deviator: lists,
            trial: list,
            flow: list,
            plastic: lists,
            returned: list,
            bulk: list,
            shear: list,
            heat: list,
            tension_excess: list,
            sheared: list,
            internal: list,
            dissipated: list,
            damaged: list,
            deleted: 7,
        };
    }

    /// Creates the scratch memory of a task of `blocks` blocks. Frequencies are not capped.
    pub fn new(constants: &ElementConstants, blocks: usize) -> Self {
        TaskWorkspace { cap: f64::INFINITY, task: TaskState::new(constants, blocks), ..TaskWorkspace::default() }
    }

    /// Stores the rates of the current block if a list for them exists.
    #[inline(always)]
    pub(super) fn keep_own_rates(&mut self) {
        if let Some(rates) = self.task.own_rates.get_mut(self.at) {
            *rates = self.own_rate;
        }
    }

    /// Sets the weight of a lane without an active element to zero.
    pub(super) fn mask(&mut self, lane: usize) {
        self.weight[lane] = 0.0;
    }

    /// Returns whether a lane has an active element.
    pub(super) fn is_active(&self, lane: usize) -> bool {
        self.weight[lane] > 0.0
    }

    /// Returns the index of the current block, as a float as in the sums.
    pub(super) fn number(&self) -> f64 {
        self.block
    }

    /// Returns the sums of the pass, and the squares of the largest strain increment and volume change.
    pub(super) fn parts(&self) -> (LaneSums, [Lanes; 2]) {
        let StressUpdate { internal, dissipated, damaged, .. } = self.stress;
        (LaneSums { internal, plastic: dissipated, damaged, ..self.sums }, self.deformed)
    }

    /// Begins a pass with the bound `cap` of the highest frequency.
    #[inline(always)]
    pub(super) fn begin(&mut self, arch: Arch, cap: f64, dt: f64, constants: &ElementConstants) {
        self.arch = arch;
        self.sums = LaneSums::default();
        self.stress.begin();
        let moduli = ElasticModuli { bulk: constants.bulk, shear: constants.shear };
        self.strain =
            StrainIncrement { dt, moduli, viscosity: constants.shear_viscosity, ..StrainIncrement::default() };
        (self.cap, self.deformed) = (cap, [[0.0; LANES]; 2]);
    }

    /// Requests the hourglass and viscous stresses of a block of the task, if it has so many.
    #[inline(always)]
    pub(super) fn prefetch_controls(&self, index: usize) {
        if let Some(ControlStresses { hourglass, viscous, slow_dilation }) = self.task.controls.get(index) {
            let lists = [&hourglass[0], &hourglass[1], viscous, slow_dilation];
            lists.iter().for_each(|list| request(&list[..], 0, LANES));
        }
    }

    /// Updates the record of the block `index` of the task.
    #[inline(never)]
    pub(super) fn update_record(&mut self, arch: Arch, index: usize, flow: PlasticFlow, (spins, dt): (Lanes, f64)) {
        let sums = self.energy_sums();
        let grown = |i: usize| inline_from_fn(|l| sums[i][l] - self.recorded[i][l]);
        let energies = [0, 1, 2, 3].inline_map(grown);
        let (increment, update, record) = (&self.strain, &self.stress, &mut self.task.records[index]);
        record.add_energies(&energies, flow);
        arch.dispatch(RecordUpdate { record, flow, spins, dt, increment, update });
    }

    /// Returns the sums of the pass that records take: work of the stress, of hourglass control, loss by damage, and
    /// dissipation by plastic flow and damage.
    fn energy_sums(&self) -> [Lanes; 4] {
        [self.stress.internal, self.sums.artificial, self.stress.damaged, self.stress.dissipated]
    }

    /// Updates the largest strain increment and volume change of the pass.
    #[inline(always)]
    pub(super) fn measure(&mut self) {
        for l in 0..LANES {
            let [rr, zz, hoop, rz] = column(&self.strain.strain, l);
            let square = self.weight[l] * ((rr * rr + zz * zz) + (hoop * hoop + 2.0 * rz * rz));
            let dilation = self.weight[l] * (rr + zz + hoop);
            self.deformed[0][l] = larger(square, self.deformed[0][l]);
            self.deformed[1][l] = larger(dilation * dilation, self.deformed[1][l]);
        }
    }

    /// Prepares for block number `block`, at index `at` of the task. Its first `count` lanes hold elements; the others
    /// get weight 0.
    #[inline(always)]
    pub fn prepare(&mut self, block: usize, at: usize, count: usize) {
        self.block = block as f64;
        self.at = at;
        self.strain.count = count.min(LANES);
        self.weight = [1.0; LANES];
        if count < LANES {
            self.weight[count..].fill(0.0);
        }
        if !self.task.records.is_empty() {
            self.recorded = self.energy_sums();
        }
    }

    fn persist_work(&mut self, archive: &mut StateArchive<'_>) {
        persist_fields!(archive; &mut self.stress.internal, &mut self.stress.dissipated, &mut self.stress.damaged);
    }
}

impl StoredTask {
    /// Creates the state of a task of `blocks` blocks.
    pub(super) fn new(constants: &ElementConstants, blocks: usize) -> StoredTask {
        StoredTask { task: TaskState::new(constants, blocks), ..StoredTask::default() }
    }

    /// Returns the sums of the pass, and the squares of the largest strain increment and volume change.
    pub(super) fn parts(&self) -> (LaneSums, [Lanes; 2]) {
        (self.sums, self.deformed)
    }

    /// Exchanges the state with that of the scratch memory, before and after an update.
    #[inline(always)]
    pub(super) fn exchange(&mut self, scratch: &mut TaskWorkspace) {
        std::mem::swap(&mut self.task, &mut scratch.task);
    }

    /// Stores the sums of a pass.
    #[inline(always)]
    pub(super) fn set_sums(&mut self, scratch: &TaskWorkspace) {
        ((self.sums, self.deformed), self.deleted) = (scratch.parts(), scratch.stress.deleted);
    }

    /// Resets the sums at the start of a pass.
    pub(super) fn clear_sums(&mut self) {
        (self.sums, self.deformed, self.deleted) = (LaneSums::default(), [[0.0; LANES]; 2], 0);
    }

    /// Adds the sums of a block that was updated with its own scratch memory.
    pub(super) fn add_sums(&mut self, block: &TaskWorkspace) {
        let (sums, deformed) = block.parts();
        self.sums.add(&sums);
        for l in 0..LANES {
            for (most, list) in self.deformed.iter_mut().zip(&deformed) {
                most[l] = larger(list[l], most[l]);
            }
        }
        self.deleted += block.stress.deleted;
    }
}

impl TaskState {
    fn new(constants: &ElementConstants, blocks: usize) -> TaskState {
        let enhanced = if constants.hourglass.enhanced == 0.0 { 0 } else { blocks };
        TaskState {
            controls: vec![ControlStresses::default(); blocks],
            enhanced: vec![AssumedStresses::default(); enhanced],
            ..TaskState::default()
        }
    }

    /// Allocates the state of deletion by `*EROSION` for `blocks` blocks.
    pub(super) fn make_erodible(&mut self, blocks: usize) {
        self.eroded = vec![ErodedLanes::default(); blocks];
    }

    /// Allocates the rates of elements for `blocks` blocks.
    pub(super) fn store_rates(&mut self, blocks: usize) {
        self.own_rates.resize(blocks, [0.0; LANES]);
    }

    /// Adds work of the stress, and loss by damage, to the record of a lane in the block `index`, if records exist.
    pub(super) fn add_to_record(&mut self, index: usize, lane: usize, energies: [f64; 2]) {
        if let Some(record) = self.records.get_mut(index) {
            record.add_to_lane(lane, energies);
        }
    }
}

carried_state!(ControlStresses { hourglass, viscous, slow_dilation });
