//! Quadrilaterals of one material, with volume or area weighting, as solid elements.

use std::cell::RefCell;
use std::iter::once;
use std::ops::Range;
use std::slice;

use pulp::Arch;

use super::block::ElementBlock;
use super::calls::CallPass;
use super::constants::ElementConstants;
use super::distorted::DistortedLanes;
use super::eroded::ErodedLanes;
use super::group::{ElementStiffness, ElementTransfer};
use super::lane_sums::TASK;
use super::solid::{
    BlockPass, BlockPlace, InitialBlock, PointExpansion, SolidBlock, SolidGroup, SolidIncrement, SolidTask,
};
use super::subzonal::SubzonalPressures;
use super::workspace::{CornerNodes, StoredTask, TaskWorkspace};
use crate::kernel::lanes::{BlockCornerForces, InlineMap, LANES, Lanes, dispatch_outlined};
use crate::kernel::prefetch::{request, request_entry};
use crate::kernel::quad;
use crate::kernel::topology::{ElementTopology, PerNode};
use crate::material::carried::CarriedState;
use crate::material::increment::StrainIncrement;
use crate::material::user::BlockKinematics;
use crate::material::{BlockStart, Material};
use crate::state::archive::Persist;
use crate::state::nodes::Node;
use crate::variables::Variable;

/// Group of quadrilaterals.
pub type QuadGroup<M> = SolidGroup<M, ElementBlock<<M as Material>::State>>;

/// Blocks by which stresses and corner forces are requested before their update, and nodes, whose indices must be known.
const AHEAD: [usize; 2] = [2, 1];

thread_local! {
    /// Scratch memory of the tasks that a thread updates one after the other.
    static SCRATCH: RefCell<TaskWorkspace> = RefCell::default();
}

/// Fills the scratch memory of the thread with numbers that no update may use.
#[cfg(test)]
pub(super) fn spoil_scratch() {
    SCRATCH.with_borrow_mut(TaskWorkspace::spoil);
}

/// Scratch memory of a block of quadrilaterals before and after calls.
#[derive(Clone, Default)]
pub struct QuadScratch {
    work: TaskWorkspace,
    nodes: CornerNodes,
}

fn places(element: [u32; 4], nodes: &[Node]) -> [[f64; 2]; 4] {
    element.inline_map(|n| nodes[n as usize].place())
}

impl<M: Material> QuadGroup<M> {
    /// Adds subzonal pressures for elements in the initial configuration.
    #[must_use]
    pub fn with_subzones(mut self, elements: &[[u32; 4]], nodes: &[Node]) -> Self {
        for (stored, part) in self.tasks.iter_mut().zip(elements.chunks(TASK * LANES)) {
            stored.task.subzones = part.chunks(LANES).map(|block| SubzonalPressures::of(block, nodes)).collect();
        }
        self
    }
}

impl InitialBlock<'_, [u32; 4]> {
    /// Returns the geometry of the elements.
    fn start(&self) -> BlockStart {
        let InitialBlock { first, elements, nodes, .. } = *self;
        let (area, volume, centre) = ([1.0; LANES], [1.0; LANES], [[0.0; LANES]; 2]);
        let corners = [[[0.0; 4]; 2]; LANES];
        let mut start = BlockStart { count: elements.len(), area, volume, centre, corners, first };
        for l in 0..LANES {
            let corners = places(elements[l.min(elements.len() - 1)], nodes);
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
}

impl<S: Clone + Send + Sync + Persist + CarriedState + 'static> SolidBlock for ElementBlock<S> {
    type State = S;
    type Element = [u32; 4];
    type Memory = TaskWorkspace;
    type CallScratch = QuadScratch;
    const TOPOLOGY: ElementTopology = ElementTopology::Quadrilateral;
    const POINTS: usize = 1;
    const TILES: bool = true;
    const IN_TASKS: bool = true;
    const NEEDS_SHEAR: bool = false;

    fn new<M: Material<State = S>>(
        material: &M,
        constants: &ElementConstants,
        initial: &InitialBlock<'_, [u32; 4]>,
    ) -> Self {
        let InitialBlock { elements, nodes, density, .. } = *initial;
        let mut block = ElementBlock::of_points(material.initial_state(&initial.start()), [0.0; LANES]);
        for l in 0..LANES {
            // Lanes after the last element repeat it; their results are not used.
            let element = elements[l.min(elements.len() - 1)];
            let corners = places(element, nodes);
            let inverse_mass = quad::sums(quad::corner_masses(corners, density).inline_map(|mass| 1.0 / mass));
            for i in 0..4 {
                block.nodes[i][l] = element[i];
                block.inverse_mass[i][l] = inverse_mass[i];
            }
            block.mass[l] = density * quad::volume(corners);
        }
        if constants.by_area {
            block.inverse_mass = [block.mass.inline_map(|mass| 16.0 / mass), [0.0; LANES], [0.0; LANES], [0.0; LANES]];
        }
        block
    }

    fn element(&self, lane: usize) -> [u32; 4] {
        self.nodes.inline_map(|list| list[lane])
    }

    fn masses(&self, lane: usize) -> PerNode<f64> {
        self.corner_masses(lane).into()
    }

    fn set_masses(&mut self, lane: usize, masses: &[f64], rates: Option<&mut Lanes>) {
        let Some(masses) = masses.first_chunk::<4>() else { return };
        if let Some(rates) = rates {
            let previous = self.corner_masses(lane);
            let ratio = [0, 1, 2, 3].inline_map(|i| previous[i] / masses[i]);
            rates[lane] *= ratio.into_iter().fold(0.0, f64::max).sqrt();
        }
        self.set_corner_masses(lane, *masses);
    }

    fn mass(&self, lane: usize) -> f64 {
        self.mass[lane]
    }

    fn points(&self) -> &[ElementBlock<S>] {
        slice::from_ref(self)
    }

    fn points_mut(&mut self) -> &mut [ElementBlock<S>] {
        slice::from_mut(self)
    }

    fn volumes(element: [u32; 4], nodes: &[Node]) -> impl Iterator<Item = f64> {
        once(quad::volume(places(element, nodes)))
    }

    fn expansions(element: [u32; 4], nodes: &[Node], dt: f64, by_area: bool) -> impl Iterator<Item = PointExpansion> {
        let dilation = quad::volume_change(element.inline_map(|n| nodes[n as usize].as_array()), dt, by_area);
        once(PointExpansion { volume: quad::volume(places(element, nodes)), factor: 0.5, span: 1.0, dilation })
    }

    fn bytes(&self) -> usize {
        0
    }

    fn last_rate(&self, lane: usize, rates: Option<&Lanes>) -> f64 {
        rates.map_or(0.0, |rates| 0.5 * rates[lane])
    }

    fn elastic_rate(
        &self,
        lane: usize,
        constants: &ElementConstants,
        masses: Option<&[f64]>,
        nodes: &[Node],
    ) -> Option<f64> {
        let masses = masses.map_or(Some(self.corner_masses(lane)), |masses| masses.first_chunk().copied())?;
        Some(constants.own_rate(places(self.element(lane), nodes), &masses))
    }

    fn stiffness(&self, lane: usize, constants: &ElementConstants, nodes: &[Node]) -> ElementStiffness {
        constants.stiffness(places(self.element(lane), nodes)).into()
    }

    fn is_eroded(&self, lane: usize, eroded: Option<&ErodedLanes>) -> bool {
        eroded.is_some_and(|eroded| eroded.has(lane))
    }

    fn is_deleted<M: Material<State = S>>(&self, material: &M, lane: usize, eroded: Option<&ErodedLanes>) -> bool {
        let status = material.value(&self.state, lane, Variable::Status.into());
        status == Some(0.0) || self.is_eroded(lane, eroded)
    }

    fn may_be_distorted(&self, least: f64, nodes: &[Node], arch: Arch) -> u32 {
        dispatch_outlined(arch, DistortedLanes { corners: &self.nodes, nodes, least })
    }

    fn erode(&mut self, lanes: Range<usize>, volume: f64, eroded: Option<&mut ErodedLanes>) {
        if let Some(eroded) = eroded {
            lanes.for_each(|lane| eroded.take(lane, volume));
        }
    }

    fn with_memory(of_memory: impl FnOnce(&mut TaskWorkspace)) {
        SCRATCH.with_borrow_mut(of_memory);
    }

    #[inline(always)]
    fn update_task<M: Material<State = S>>(task: SolidTask<'_, M, Self>) {
        let pass = task.pass;
        let BlockPass { material, constants, increment } = pass.blocks;
        let SolidIncrement { nodes, dt, before, time, arch, count, .. } = increment;
        task.stored.exchange(task.memory);
        increment.begin(constants, task.memory);
        let mut corner_nodes = CornerNodes::default();
        for i in 0..task.blocks.len() {
            if pass.prefetches {
                task.prefetch(i);
            }
            let (block, scratch) = (&mut task.blocks[i], &mut *task.memory);
            let index = task.index * TASK + i;
            scratch.prepare(index, i, count - index * LANES);
            corner_nodes.collect(nodes, &block.nodes);
            scratch.strain.averaging = pass.dilation_correction.map(|list| list[index]);
            material.begin(&mut block.state, time);
            block.update(material, constants, (dt, before), &mut corner_nodes, scratch, &mut task.corners[i]);
            if !scratch.task.records.is_empty() {
                scratch.update_record(arch, i, M::FLOW, (scratch.strain.spin, dt));
            }
        }
        task.stored.exchange(task.memory);
        task.stored.set_sums(task.memory);
    }

    fn measure<M: Material<State = S>>(
        &mut self,
        pass: &CallPass<'_, M>,
        place: BlockPlace,
        (task, QuadScratch { work, nodes }): (&mut StoredTask, &mut QuadScratch),
        gather: &mut dyn FnMut(usize, &mut S, &BlockKinematics<'_>),
    ) {
        let BlockPass { material, constants, increment } = pass.blocks;
        task.exchange(work);
        pass.begin(place, work);
        nodes.collect(increment.nodes, &self.nodes);
        material.begin(&mut self.state, increment.time);
        self.mask(material, nodes, work);
        self.measure_strain::<M>(constants, increment.dt, nodes, work);
        task.exchange(work);
        let corners = |l: usize| nodes.places(l);
        let around = |l: usize| [0, 1, 2, 3].inline_map(|c: usize| nodes.0[c][l].place()).into();
        let StrainIncrement { strain, spin, volume, .. } = work.strain;
        let (gradient, starts) = (None, increment.dt == 0.0);
        let kinematics = BlockKinematics { strain, spin, volume, gradient, corners: &corners, nodes: &around, starts };
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
        let BlockPass { material, constants, increment: SolidIncrement { dt, arch, .. } } = pass.blocks;
        self.finish(material, (constants, dt), eroded, nodes, work, &mut corners[0]);
        if !work.task.records.is_empty() {
            work.update_record(arch, at, M::FLOW, (work.strain.spin, dt));
        }
        task.exchange(work);
        task.add_sums(work);
    }

    /// Subzonal pressures depend on the initial masses of the subzones.
    fn transfer<M: Material<State = S>>(group: &mut SolidGroup<M, Self>) -> Option<&mut dyn ElementTransfer> {
        let subzones = group.tasks.first().is_some_and(|task| !task.task.subzones.is_empty());
        if group.constants.by_area || subzones || !group.material.can_be_carried() { None } else { Some(group) }
    }
}

impl<M: Material> SolidTask<'_, M, ElementBlock<M::State>> {
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
        self.memory.prefetch_controls(block + blocks);
        let Some(next) = self.blocks.get(block + nodes) else { return };
        for &node in [next.nodes[0], next.nodes[2]].as_flattened().iter().step_by(2) {
            request_entry(self.pass.blocks.increment.nodes, node as usize);
        }
    }
}

#[cfg(test)]
mod tests {
    use pulp::Arch;

    use super::QuadGroup;
    use crate::element::constants::{ElementConstants, HourglassControl};
    use crate::element::group::{ElementGroup as _, ElementPass};
    use crate::kernel::bulk_viscosity::BulkViscosity;
    use crate::kernel::lanes::LANES;
    use crate::material::plasticity::PiecewiseLinearHardening;
    use crate::material::volumetric::ConstantBulkModulus;
    use crate::material::von_mises::VonMises;
    use crate::routines::PointRoutines;
    use crate::state::Instant;
    use crate::state::nodes::{Node, NodeAccelerations};

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
        let scalar = run(Arch::Scalar);
        assert_eq!(scalar, run(Arch::new()));
        #[cfg(target_arch = "x86_64")]
        if let Some(v3) = pulp::x86::V3::try_new() {
            assert_eq!(scalar, run(Arch::V3(v3)));
        }
    }
}
