//! Element deletion by `*EROSION`: elements that are too distorted, too strained or have too small a stable time
//! increment are deleted.
//!
//! Criteria are evaluated before a pass over the elements, with the results of the previous pass and the current node
//! positions, for all elements before any is deleted. The result is independent of threads, and an inverted element is
//! deleted before its forces are computed.

use rayon::prelude::*;

use super::assembly::ForceAssembly;
use super::criteria::DeletionCriteria;
use super::deletions::Deletions;
use super::group::{ElementGroup, PARALLEL};
use super::lane_sums::{TASK, larger};
use super::timing::GroupTiming;
use crate::kernel::corners::{is_distorted, largest_shell_strain, largest_strain};
use crate::kernel::lanes::{InlineMap, LANES};
use crate::kernel::lists::{Memory, sorted_unique};
use crate::kernel::quad;
use crate::kernel::topology::ElementTopology;
use crate::state::EffectId;
use crate::state::archive::Persist;
use crate::state::dofs::Dofs;
use crate::state::nodes::Nodes;
use crate::variables::Variable;

impl DeletionCriteria {
    /// Returns whether an element meets a criterion. NaN does not delete an element, so that the error is found.
    pub fn are_met(&self, group: &dyn ElementGroup, element: usize, nodes: &Nodes) -> bool {
        let position = |n: u32| nodes[n as usize].place();
        let start = |n: u32| nodes.start[n as usize];
        let strain = || {
            if group.is_solid() {
                let strains =
                    group.cells(element).map(|cell| largest_strain(cell.inline_map(position), cell.inline_map(start)));
                return strains.fold(f64::NEG_INFINITY, larger);
            }
            if group.topology() == ElementTopology::Cohesive {
                return f64::NEG_INFINITY;
            }
            let boundary = group.boundary(element);
            let ends = [boundary[0], boundary[1]];
            largest_shell_strain(ends.inline_map(position), ends.inline_map(start))
        };
        let plastic = || group.value(element, Variable::PlasticStrain.into());
        let rate = || group.stable_rate(element, None, nodes.as_slice()).unwrap_or(0.0);
        // Shells have no cells that can invert.
        let folds = |least| group.cells(element).any(|cell| is_distorted(cell.inline_map(position), least));
        self.distortion.is_some_and(folds)
            || self.plastic.is_some_and(|most| plastic().is_some_and(|p| p >= most))
            || self.strain.is_some_and(|most| strain() >= most)
            || self.increment.is_some_and(|least| rate() * least >= 1.0)
    }
}

/// Elements with the same criteria.
#[derive(Clone, Debug, Persist, Memory)]
#[persist(fixed: due; derived: id, criteria, elements, blocks, marks)]
struct MonitoredElements {
    /// Row of the ledger.
    id: EffectId,
    criteria: DeletionCriteria,
    elements: Vec<(usize, usize)>,
    /// Whether each element has met the criteria; includes deleted elements.
    due: Vec<bool>,
    /// Elements by blocks of their groups, in their order.
    blocks: Vec<MonitoredBlock>,
    /// Lanes of each block that meet the criteria for the first time.
    marks: Vec<u32>,
}

/// Consecutive elements in the same block of a group, in the order of their lanes.
#[derive(Clone, Copy, Debug)]
struct MonitoredBlock {
    group: u32,
    block: u32,
    /// Lanes of the elements, as bits.
    lanes: u32,
    /// Index of the first element.
    first: u32,
}

impl MonitoredBlock {
    /// Collects elements into blocks.
    fn of_elements(elements: &[(usize, usize)]) -> Vec<MonitoredBlock> {
        let mut blocks: Vec<MonitoredBlock> = Vec::new();
        for (first, &(group, element)) in (0..).zip(elements) {
            let (group, block, lane) = (group as u32, (element / LANES) as u32, 1 << (element % LANES));
            match blocks.last_mut().filter(|last| (last.group, last.block) == (group, block) && last.lanes < lane) {
                Some(last) => last.lanes |= lane,
                None => blocks.push(MonitoredBlock { group, block, lanes: lane, first }),
            }
        }
        blocks
    }

    /// Returns the index of the element in a lane.
    fn index_of(&self, lane: u32) -> usize {
        (self.first + (self.lanes & ((1 << lane) - 1)).count_ones()) as usize
    }

    /// Returns the lanes whose elements meet criteria and are not due yet.
    fn judge(&self, criteria: &DeletionCriteria, groups: &[Box<dyn ElementGroup>], nodes: &Nodes, due: &[bool]) -> u32 {
        let (group, block) = (&*groups[self.group as usize], self.block as usize);
        // Quiescent elements have not deformed.
        if group.is_quiescent(block / TASK) {
            return 0;
        }
        let possible = self.lanes & group.may_meet(criteria, block, nodes.as_slice());
        let is_met =
            |lane: u32| !due[self.index_of(lane)] && criteria.are_met(group, block * LANES + lane as usize, nodes);
        lanes_of(possible).filter(|lane| is_met(*lane)).fold(0, |lanes, lane| lanes | 1 << lane)
    }
}

/// Iterates over the positions of the bits of a number, ascending.
fn lanes_of(mut bits: u32) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        let lane = (bits != 0).then(|| bits.trailing_zeros())?;
        bits &= bits - 1;
        Some(lane)
    })
}

impl MonitoredElements {
    fn new(id: EffectId, criteria: DeletionCriteria, elements: Vec<(usize, usize)>) -> MonitoredElements {
        let blocks = MonitoredBlock::of_elements(&elements);
        let (due, marks) = (vec![false; elements.len()], vec![0; blocks.len()]);
        MonitoredElements { id, criteria, elements, due, blocks, marks }
    }

    /// Finds the elements that meet the criteria for the first time.
    fn evaluate(&mut self, groups: &[Box<dyn ElementGroup>], nodes: &Nodes, threads: bool) {
        let MonitoredElements { criteria, elements, due, blocks, marks, .. } = self;
        let judge = |(blocks, marks): (&[MonitoredBlock], &mut [u32])| {
            let judged = blocks.iter().map(|block| block.judge(criteria, groups, nodes, due));
            marks.iter_mut().zip(judged).for_each(|(mark, lanes)| *mark = lanes);
        };
        if threads && elements.len() >= PARALLEL {
            blocks.par_chunks(TASK).zip(marks.par_chunks_mut(TASK)).for_each(judge);
        } else {
            judge((blocks, marks));
        }
    }

    /// Marks the elements that the last evaluation found as due.
    fn take_found(&mut self) {
        let MonitoredElements { due, blocks, marks, .. } = self;
        for (block, marks) in blocks.iter().zip(marks).filter(|(_, marks)| **marks != 0) {
            lanes_of(std::mem::take(marks)).for_each(|lane| due[block.index_of(lane)] = true);
        }
    }

    /// Iterates over the indices of the elements that the last evaluation found.
    fn found(&self) -> impl Iterator<Item = usize> {
        let marked = self.blocks.iter().zip(&self.marks).filter(|(_, marks)| **marks != 0);
        marked.flat_map(|(block, marks)| lanes_of(*marks).map(|lane| block.index_of(lane)))
    }
}

/// All elements with deletion criteria.
#[derive(Clone, Debug, Default, Persist, Memory)]
#[persist(fixed: list)]
pub struct ErosionControl {
    list: Vec<MonitoredElements>,
}

impl ErosionControl {
    /// Adds criteria for elements, given by group and element of the group; `id` is their row of the ledger.
    pub fn watch(&mut self, id: EffectId, criteria: DeletionCriteria, elements: Vec<(usize, usize)>) {
        self.list.push(MonitoredElements::new(id, criteria, elements));
    }

    /// Returns the groups with deletion criteria.
    pub fn groups(&self) -> Vec<usize> {
        sorted_unique(self.list.iter().flat_map(|w| w.elements.iter().map(|e| e.0)))
    }

    /// Deletes the elements that meet their criteria, at the end of an increment, before its strains are computed, and
    /// records the run time.
    pub(super) fn erode(
        &mut self,
        groups: &mut [Box<dyn ElementGroup>],
        assembly: &mut ForceAssembly,
        deletions: &mut Deletions,
        dofs: &mut Dofs,
        threads: bool,
        timing: &mut GroupTiming<'_>,
    ) {
        if dofs.nodes.previous_dt == 0.0 {
            return;
        }
        for watched in &mut self.list {
            let started = timing.start(watched.id);
            watched.evaluate(groups, &dofs.nodes, threads);
            timing.stop(started, watched.id);
        }
        for watched in &mut self.list {
            for (group, element) in watched.found().map(|index| watched.elements[index]) {
                if !groups[group].is_deleted(element) {
                    delete(groups, (group, element), assembly, deletions, dofs);
                }
            }
            watched.take_found();
        }
    }

    /// Takes which elements have met criteria in a model in which a group had another mesh.
    pub(super) fn follow_new_mesh(&mut self, previous: &ErosionControl, group: usize) {
        for (watched, previous) in self.list.iter_mut().zip(&previous.list) {
            let previous = previous.elements.iter().zip(&previous.due).filter(|((g, _), _)| *g != group);
            let current = watched.elements.iter().zip(&mut watched.due).filter(|((g, _), _)| *g != group);
            current.zip(previous).for_each(|((_, due), (_, was_due))| *due = *was_due);
        }
    }
}

/// Deletes an element. Its forces have acted over the first half of the previous increment only; their work is
/// added to its energy. Its stored energy counts as dissipated; energy that it has released, for example by the
/// expansion of a gas, does not. Equation (12.3).
fn delete(
    groups: &mut [Box<dyn ElementGroup>],
    (group, element): (usize, usize),
    assembly: &mut ForceAssembly,
    deletions: &mut Deletions,
    dofs: &mut Dofs,
) {
    let nodes_of_element = groups[group].nodes(element);
    let nodes = &dofs.nodes;
    let mut work = 0.0;
    for (corner, &n) in nodes_of_element.iter().enumerate() {
        let ([f_r, f_z], node) = (assembly.corner_force(groups, (group, element), corner), nodes[n as usize]);
        work -= 0.5 * nodes.previous_dt * (f_r * node.v_r + f_z * node.v_z);
    }
    let stored = groups[group].value(element, Variable::ElementStrainEnergy.into()).unwrap_or(0.0);
    dofs.energies.internal += work;
    dofs.energies.plastic += (work + stored).max(0.0);
    assembly.clear(groups, group, element);
    let group = &mut groups[group];
    let volume = group.cells(element).map(|cell| quad::volume(cell.inline_map(|n| dofs.nodes.start[n as usize]))).sum();
    // The faces at a cohesive element have been exposed before.
    let listed = if group.topology() == ElementTopology::Cohesive { 0 } else { group.topology().boundary() };
    deletions.boundaries.push(group.boundary(element).first(listed));
    group.erode(element, volume);
    if let Some(record) = &mut deletions.record {
        record.add(work);
    }
}
