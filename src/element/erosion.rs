//! Erosion beyond what materials say (`*EROSION`): elements that are folded, strained or too short of an increment are deleted.
//! It is decided in front of a pass over the elements, on what the pass before left and on where nodes are now, for all elements
//! before any is deleted: the same set whatever threads take part, and a folded element is gone before its forces are asked for.
//! Never here: what a deck may ask, failure of materials, what becomes of faces and nodes.

use rayon::prelude::*;

use super::block::larger;
use super::elements::Elements;
use super::group::{ElementGroup, PARALLEL, TASK};
use crate::kernel::corners::{largest_shell_strain, largest_strain, scaled_jacobian};
use crate::kernel::lanes::{InlineMap, LANES};
use crate::kernel::lists::sorted_unique;
use crate::kernel::quad;
use crate::state::archive::{Archive, Persist};
use crate::state::dofs::Dofs;
use crate::state::nodes::Nodes;
use crate::variables::Variable;

/// When an element is deleted: any of these is enough.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Criteria {
    /// Its scaled Jacobian is no more than this.
    pub distortion: Option<f64>,
    /// Its equivalent plastic strain is no less than this; of shells that in the middle.
    pub plastic: Option<f64>,
    /// Its largest principal logarithmic strain is no less than this.
    pub strain: Option<f64>,
    /// Its own stable increment is no more than this.
    pub increment: Option<f64>,
}

impl Criteria {
    /// Whether an element of a group has come to one of them. Not a number is no reason to delete: it must be found.
    pub fn are_met(&self, group: &dyn ElementGroup, element: usize, nodes: &Nodes) -> bool {
        let place = |n: u32| nodes[n as usize].place();
        let start = |n: u32| nodes.start[n as usize];
        let strain = || {
            if group.is_solid() {
                let strains =
                    group.cells(element).map(|cell| largest_strain(cell.inline_map(place), cell.inline_map(start)));
                return strains.fold(f64::NEG_INFINITY, larger);
            }
            let boundary = group.boundary(element);
            let ends = [boundary[0], boundary[1]];
            largest_shell_strain(ends.inline_map(place), ends.inline_map(start))
        };
        let plastic = || group.value(element, Variable::PlasticStrain.into());
        let rate = || group.stable_rate(element, None, nodes.as_slice()).unwrap_or(0.0);
        // Shells have no cells that could fold.
        let folds = |least| group.cells(element).any(|cell| scaled_jacobian(cell.inline_map(place)) <= least);
        self.distortion.is_some_and(folds)
            || self.plastic.is_some_and(|most| plastic().is_some_and(|p| p >= most))
            || self.strain.is_some_and(|most| strain() >= most)
            || self.increment.is_some_and(|least| rate() * least >= 1.0)
    }
}

/// Elements under criteria.
#[derive(Clone, Debug)]
struct Watched {
    criteria: Criteria,
    elements: Vec<(usize, usize)>,
    /// Whether each has come to them; of those that are gone, too.
    due: Vec<bool>,
}

impl Watched {
    fn judge(&mut self, groups: &[Box<dyn ElementGroup>], nodes: &Nodes, threads: bool) {
        let criteria = self.criteria;
        let judge = |(elements, due): (&[(usize, usize)], &mut [bool])| {
            for (&(group, element), due) in elements.iter().zip(due) {
                let group = &*groups[group];
                // What is at rest since the start has come to nothing.
                if !*due && !group.is_quiescent(element / (TASK * LANES)) {
                    *due = criteria.are_met(group, element, nodes);
                }
            }
        };
        let Watched { elements, due, .. } = self;
        if threads && elements.len() >= PARALLEL {
            let tasks = elements.par_chunks(TASK * LANES).zip(due.par_chunks_mut(TASK * LANES));
            tasks.for_each(judge);
        } else {
            judge((elements, due));
        }
    }
}

/// All elements under criteria.
#[derive(Clone, Debug, Default)]
pub struct Erosion {
    list: Vec<Watched>,
}

impl Erosion {
    /// Puts elements, by group and element of the group, under criteria.
    pub fn watch(&mut self, criteria: Criteria, elements: Vec<(usize, usize)>) {
        self.list.push(Watched { criteria, due: vec![false; elements.len()], elements });
    }

    /// Groups that have elements under criteria.
    pub fn groups(&self) -> Vec<usize> {
        let groups: Vec<usize> = sorted_unique(self.list.iter().flat_map(|w| w.elements.iter().map(|e| e.0)));
        groups
    }

    pub fn bytes(&self) -> usize {
        let each = |w: &Watched| size_of_val(w) + size_of_val(&*w.elements) + w.due.capacity();
        self.list.iter().map(each).sum()
    }
}

impl Elements {
    /// Puts elements under criteria, of nodes at the start.
    pub fn watch(&mut self, erosion: Erosion, nodes: &Nodes) {
        for group in erosion.groups() {
            self.groups[group].extensions().deletion().make_erodible();
        }
        self.erosion = Some(Box::new(erosion));
        self.make_room_for_deletions();
        self.count_deletions(nodes.len());
    }

    /// Deletes the elements that have come to their criteria, at the end of an increment whose strains are still to come.
    pub(super) fn erode(&mut self, dofs: &mut Dofs, threads: bool) {
        if dofs.nodes.behind == 0.0 {
            return;
        }
        let Some(mut erosion) = self.erosion.take() else { return };
        for watched in &mut erosion.list {
            watched.judge(&self.groups, &dofs.nodes, threads);
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

    /// Deletes an element: its forces have acted over the first half of the increment behind and not over the second, which is the
    /// work that it still takes up. What it had stored counts as dissipated.
    fn delete(&mut self, group: usize, element: usize, dofs: &mut Dofs) {
        let own = self.groups[group].nodes(element);
        let nodes = &dofs.nodes;
        let mut work = 0.0;
        for (corner, &n) in own.iter().enumerate() {
            let ([f_r, f_z], node) = (self.corner_force(group, element, corner), nodes[n as usize]);
            work -= 0.5 * nodes.behind * (f_r * node.v_r + f_z * node.v_z);
        }
        let stored = self.groups[group].value(element, Variable::ElementStrainEnergy.into()).unwrap_or(0.0);
        dofs.energies.internal += work;
        dofs.energies.plastic += work + stored;
        self.clear_corners(group, element);
        let group = &mut self.groups[group];
        let volume =
            group.cells(element).map(|cell| quad::volume(cell.inline_map(|n| dofs.nodes.start[n as usize]))).sum();
        self.deleted.0.push(group.boundary(element));
        group.extensions().deletion().erode(element, volume);
        if let Some(removed) = &mut self.removed {
            removed.add(work);
        }
    }
}

impl Persist for Erosion {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        for Watched { criteria: _, elements: _, due } in &mut self.list {
            due.as_mut_slice().persist(archive);
        }
    }
}
