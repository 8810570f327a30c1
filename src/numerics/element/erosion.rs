//! Element deletion by `*EROSION`: elements that are too distorted, too strained or have too small a stable time
//! increment are deleted.
//!
//! Criteria are evaluated before a pass over the elements, with the results of the previous pass and the current node
//! positions, for all elements before any is deleted. The result is independent of threads, and an inverted element is
//! deleted before its forces are computed.

use rayon::prelude::*;

use super::block::{TASK, larger};
use super::elements::Elements;
use super::group::{ElementGroup, GroupSetting, PARALLEL};
use crate::kernel::corners::{is_distorted, largest_shell_strain, largest_strain};
use crate::kernel::lanes::{InlineMap, LANES};
use crate::kernel::lists::{Memory, sorted_unique};
use crate::kernel::quad;
use crate::kernel::topology::ElementTopology;
use crate::state::archive::Persist;
use crate::state::dofs::Dofs;
use crate::state::nodes::Nodes;
use crate::variables::Variable;

/// Deletion criteria of an element; one is sufficient.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DeletionCriteria {
    /// Scaled Jacobian less than or equal to this value.
    pub distortion: Option<f64>,
    /// Equivalent plastic strain greater than or equal to this value; for shells at the middle point.
    pub plastic: Option<f64>,
    /// Largest principal logarithmic strain greater than or equal to this value.
    pub strain: Option<f64>,
    /// Own stable time increment less than or equal to this value.
    pub increment: Option<f64>,
}

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
#[persist(fixed: due; derived: criteria, elements)]
struct MonitoredElements {
    criteria: DeletionCriteria,
    elements: Vec<(usize, usize)>,
    /// Whether each element has met the criteria; includes deleted elements.
    due: Vec<bool>,
}

impl MonitoredElements {
    fn evaluate(&mut self, groups: &[Box<dyn ElementGroup>], nodes: &Nodes, threads: bool) {
        let criteria = self.criteria;
        let judge = |(elements, due): (&[(usize, usize)], &mut [bool])| {
            for (&(group, element), due) in elements.iter().zip(due) {
                let group = &*groups[group];
                // Quiescent elements have not deformed.
                if !*due && !group.is_quiescent(element / (TASK * LANES)) {
                    *due = criteria.are_met(group, element, nodes);
                }
            }
        };
        let MonitoredElements { elements, due, .. } = self;
        if threads && elements.len() >= PARALLEL {
            let tasks = elements.par_chunks(TASK * LANES).zip(due.par_chunks_mut(TASK * LANES));
            tasks.for_each(judge);
        } else {
            judge((elements, due));
        }
    }
}

/// All elements with deletion criteria.
#[derive(Clone, Debug, Default, Persist, Memory)]
#[persist(fixed: list)]
pub struct ErosionControl {
    list: Vec<MonitoredElements>,
}

impl ErosionControl {
    /// Adds criteria for elements, given by group and element of the group.
    pub fn watch(&mut self, criteria: DeletionCriteria, elements: Vec<(usize, usize)>) {
        self.list.push(MonitoredElements { criteria, due: vec![false; elements.len()], elements });
    }

    /// Returns the groups with deletion criteria.
    pub fn groups(&self) -> Vec<usize> {
        sorted_unique(self.list.iter().flat_map(|w| w.elements.iter().map(|e| e.0)))
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

impl Elements {
    /// Sets the deletion criteria of elements; nodes are in the initial configuration.
    pub fn watch(&mut self, erosion: ErosionControl, nodes: &Nodes) {
        for group in erosion.groups() {
            self.groups[group].configure(GroupSetting::Deletion);
        }
        self.erosion = Some(Box::new(erosion));
        self.reserve_deletions();
        self.count_deletions(nodes.len());
    }

    /// Deletes the elements that meet their criteria, at the end of an increment, before its strains are computed.
    pub(super) fn erode(&mut self, dofs: &mut Dofs, threads: bool) {
        if dofs.nodes.previous_dt == 0.0 {
            return;
        }
        let Some(mut erosion) = self.erosion.take() else { return };
        for watched in &mut erosion.list {
            watched.evaluate(&self.groups, &dofs.nodes, threads);
        }
        for watched in &erosion.list {
            for (&(group, element), _) in watched.elements.iter().zip(&watched.due).filter(|e| *e.1) {
                if !self.groups[group].is_deleted(element) {
                    self.delete(group, element, dofs);
                }
            }
        }
        self.erosion = Some(erosion);
    }

    /// Deletes an element. Its forces have acted over the first half of the previous increment only; their work is
    /// added to its energy. Its stored energy counts as dissipated; energy that it has released, for example by the
    /// expansion of a gas, does not. Equation (12.3).
    fn delete(&mut self, group: usize, element: usize, dofs: &mut Dofs) {
        let nodes_of_element = self.groups[group].nodes(element);
        let nodes = &dofs.nodes;
        let mut work = 0.0;
        for (corner, &n) in nodes_of_element.iter().enumerate() {
            let ([f_r, f_z], node) = (self.corner_force(group, element, corner), nodes[n as usize]);
            work -= 0.5 * nodes.previous_dt * (f_r * node.v_r + f_z * node.v_z);
        }
        let stored = self.groups[group].value(element, Variable::ElementStrainEnergy.into()).unwrap_or(0.0);
        dofs.energies.internal += work;
        dofs.energies.plastic += (work + stored).max(0.0);
        self.clear_corners(group, element);
        let group = &mut self.groups[group];
        let volume =
            group.cells(element).map(|cell| quad::volume(cell.inline_map(|n| dofs.nodes.start[n as usize]))).sum();
        // The faces at a cohesive element have been exposed before.
        let listed = if group.topology() == ElementTopology::Cohesive { 0 } else { group.topology().boundary() };
        self.deleted.0.push(group.boundary(element).first(listed));
        group.erode(element, volume);
        if let Some(removed) = &mut self.removed {
            removed.add(work);
        }
    }
}
