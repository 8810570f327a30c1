//! Deleted elements of a model: their boundaries, the nodes that remain, and totals.

use super::free_nodes::FreeNodes;
use super::group::{ElementGroup, GroupSetting};
use super::removed::DeletionRecord;
use crate::kernel::lists::heap_bytes;
use crate::kernel::topology::ElementNodes;
use crate::state::archive::{Persist, StateArchive};
use crate::state::nodes::Nodes;

/// Elements deleted so far.
#[derive(Clone, Debug, Default, Persist)]
#[persist(present: record, free_nodes; then: Deletions::check)]
pub struct Deletions {
    /// Masses and energies of deleted elements; `None` unless requested.
    pub record: Option<Box<DeletionRecord>>,
    /// Nodes whose elements are all deleted; `None` if no element can be deleted.
    pub free_nodes: Option<Box<FreeNodes>>,
    /// Boundaries of deleted elements.
    pub(super) boundaries: Vec<ElementNodes>,
    /// Number of boundaries that the loads of this step have processed.
    processed: usize,
    /// Number of elements deleted from meshes that have been replaced since.
    on_replaced_meshes: usize,
}

impl Deletions {
    /// Reserves memory for all elements that may be deleted, so that nothing allocates inside an increment.
    pub(super) fn reserve(&mut self, groups: &[Box<dyn ElementGroup>]) {
        let fragile: usize = groups.iter().filter(|g| g.properties().deletable).map(|g| g.len()).sum();
        self.boundaries.reserve_exact(fragile.saturating_sub(self.boundaries.len()));
        if let Some(record) = &mut self.record {
            record.make_room();
        }
        if fragile > 0 {
            self.free_nodes.get_or_insert_with(|| Box::new(FreeNodes::new(groups))).make_room();
        }
    }

    /// Begins a step: no deletion has been processed. A cloned state has no reserved memory.
    pub(super) fn begin(&mut self, groups: &[Box<dyn ElementGroup>]) {
        self.processed = 0;
        self.reserve(groups);
    }

    /// Starts to compute totals of deletion; elements then record strains and energies.
    pub fn start_record(&mut self, groups: &mut [Box<dyn ElementGroup>], nodes: usize) {
        self.record = Some(Box::new(DeletionRecord::new(groups, nodes)));
        let deletable = groups.iter_mut().filter(|g| g.properties().deletable);
        deletable.for_each(|g| g.configure(GroupSetting::Records));
    }

    /// Adds the elements deleted in the last pass to the totals; `factor` returns the factor of mass scaling on an element.
    pub(super) fn count_pass(&mut self, groups: &[Box<dyn ElementGroup>], factor: impl Fn(usize, usize) -> f64) {
        if let Some(record) = &mut self.record {
            record.count(groups, factor, self.boundaries.len());
        }
        if let Some(free) = &mut self.free_nodes {
            free.count(&self.boundaries);
        }
    }

    /// Merges the mass of nodes that have become free in the last pass with their bodies, as [`FreeNodes::merge`]. Returns the
    /// loss of kinetic energy; `None` if no mass has changed.
    pub fn merge_free_nodes(
        &mut self,
        nodes: &mut Nodes,
        free_axes: impl Fn(&Nodes, usize) -> Option<[bool; 2]>,
    ) -> Option<f64> {
        self.free_nodes.as_mut()?.merge(&self.boundaries, nodes, free_axes)
    }

    /// Returns whether nodes have become free in the last pass.
    pub fn has_fresh_nodes(&self) -> bool {
        self.free_nodes.as_ref().is_some_and(|free| free.has_fresh())
    }

    /// Returns the number of deleted elements.
    pub fn count(&self) -> usize {
        self.on_replaced_meshes + self.boundaries.len()
    }

    /// Returns the boundaries of the deleted elements.
    pub fn boundaries(&self) -> &[ElementNodes] {
        &self.boundaries
    }

    /// Returns the boundaries of elements deleted since the last call in this step.
    pub fn newly_deleted(&mut self) -> &[ElementNodes] {
        let processed = std::mem::replace(&mut self.processed, self.boundaries.len());
        &self.boundaries[processed..]
    }

    /// Takes the deletions of a model in which a group had another mesh; `node` returns the node that one of that model has
    /// become. The boundaries of deleted elements of this group are no longer known.
    pub(super) fn follow_new_mesh(&mut self, previous: &Deletions, group: usize, node: impl Fn(u32) -> Option<u32>) {
        let moved = |boundary: &ElementNodes| {
            let mut moved = *boundary;
            for n in moved.iter_mut() {
                *n = node(*n)?;
            }
            Some(moved)
        };
        self.boundaries.clear();
        self.boundaries.extend(previous.boundaries.iter().filter_map(moved));
        self.processed = self.boundaries.len();
        self.on_replaced_meshes = previous.count() - self.boundaries.len();
        if let (Some(free), Some(previous)) = (&mut self.free_nodes, &previous.free_nodes) {
            free.follow_new_mesh(previous, &node);
        }
        if let (Some(record), Some(previous)) = (&mut self.record, &previous.record) {
            record.follow_new_mesh(previous, (group, self.boundaries.len()), node);
        }
    }

    /// Returns the bytes of totals and free nodes.
    pub fn bytes_of_record(&self) -> usize {
        let free = self.free_nodes.as_ref().map_or(0, |free| free.bytes());
        self.record.as_ref().map_or(0, |record| record.bytes()) + free
    }

    /// Returns the bytes of the boundaries.
    pub(super) fn bytes_of_boundaries(&self) -> usize {
        heap_bytes(&self.boundaries)
    }

    fn check(&mut self, archive: &mut StateArchive<'_>) {
        if self.processed > self.boundaries.len() {
            archive.reject(|| "more deleted elements are marked as processed than exist".into());
        }
    }
}
