//! Quiescent regions: tasks of stress-free elements whose nodes are at rest, and the nodes that belong only to such
//! elements, are skipped until a wave or a load reaches them. Skipping does not change any bit of the results.

use super::group::ElementGroup;
use super::lane_sums::TASK;
use crate::kernel::chunks::FEW;
use crate::kernel::lanes::LANES;
use crate::kernel::lists::heap_bytes;
use crate::state::archive::{Persist, StateArchive};
use crate::state::nodes::Node;

/// Nodes of a task of elements, and whether it is quiescent.
#[derive(Clone, Debug, Persist)]
#[persist(derived: nodes)]
pub(super) struct TaskQuiescence {
    pub nodes: Vec<u32>,
    /// Whether the task has been at rest since the start of the analysis.
    pub quiescent: bool,
}

impl TaskQuiescence {
    /// Creates the states of the tasks of a group, all active.
    pub fn of_tasks<E: AsRef<[u32]>>(elements: &[E]) -> Vec<TaskQuiescence> {
        let mut nodes = Vec::new();
        let task = |part: &[E]| {
            nodes.clear();
            nodes.extend(part.iter().flat_map(E::as_ref));
            nodes.sort_unstable();
            nodes.dedup();
            TaskQuiescence { nodes: nodes.clone(), quiescent: false }
        };
        elements.chunks(TASK * LANES).map(task).collect()
    }

    pub fn bytes(&self) -> usize {
        size_of::<TaskQuiescence>() + heap_bytes(&self.nodes)
    }

    /// Returns whether all nodes of the task are at rest.
    pub fn is_still(&self, nodes: &[Node]) -> bool {
        self.nodes.iter().all(|&n| nodes[n as usize].v_r == 0.0 && nodes[n as usize].v_z == 0.0)
    }
}

/// Chunks of nodes that need an update.
#[derive(Clone, Debug, Default)]
pub(super) struct ActiveNodes {
    /// Groups and tasks of the elements at each chunk of nodes; none for a chunk with a node without elements, which is
    /// always active. The list is empty once all chunks are.
    touching: Vec<Vec<(u32, u32)>>,
    /// Whether each chunk is active in this increment; empty if all are.
    awake: Vec<bool>,
}

impl ActiveNodes {
    /// Creates the lists from the nodes of each group's elements.
    pub fn new(count: usize, groups: &[Box<dyn ElementGroup>]) -> Self {
        let mut touching = vec![Vec::new(); count.div_ceil(FEW)];
        let mut has_element = vec![false; count];
        for (g, group) in groups.iter().enumerate() {
            for e in 0..group.len() {
                let task = (g as u32, (e / (TASK * LANES)) as u32);
                for node in group.nodes(e) {
                    has_element[node as usize] = true;
                    let list = &mut touching[node as usize / FEW];
                    if list.last() != Some(&task) && !list.contains(&task) {
                        list.push(task);
                    }
                }
            }
        }
        for (list, has_element) in touching.iter_mut().zip(has_element.chunks(FEW)) {
            if has_element.contains(&false) {
                list.clear();
            }
        }
        ActiveNodes { touching, awake: Vec::new() }
    }

    pub fn bytes(&self) -> usize {
        let touching: usize = self.touching.iter().map(|l| size_of_val(l) + heap_bytes(l)).sum();
        touching + self.awake.capacity()
    }

    pub fn wake(&mut self) {
        *self = ActiveNodes::default();
    }

    /// Updates the active chunks after the elements: nodes of quiescent tasks are inactive unless an external force
    /// acts on them.
    pub fn update(&mut self, groups: &[Box<dyn ElementGroup>], external: &[[f64; 2]]) {
        if self.touching.is_empty() {
            return;
        }
        let quiescent = |(group, task): &(u32, u32)| groups[*group as usize].is_quiescent(*task as usize);
        self.awake.clear();
        self.awake.extend(self.touching.iter().map(|list| list.is_empty() || !list.iter().all(quiescent)));
        if self.awake.iter().all(|awake| *awake) {
            self.wake();
            return;
        }
        for (awake, forces) in self.awake.iter_mut().zip(external.chunks(FEW)) {
            *awake |= forces.iter().any(|f| f[0] != 0.0 || f[1] != 0.0);
        }
    }

    /// Returns whether the chunk of nodes from `first` on is active.
    #[inline(always)]
    pub fn has_work(&self, first: usize) -> bool {
        self.awake.is_empty() || self.awake[first / FEW]
    }
}

impl Persist for ActiveNodes {
    fn persist(&mut self, archive: &mut StateArchive<'_>) {
        let ActiveNodes { touching, awake } = self;
        let mut for_good = touching.is_empty();
        for_good.persist(archive);
        if for_good {
            touching.clear();
        }
        awake.persist(archive);
        // When reading, all chunks may already be permanently active, which does not change any bit.
        if touching.is_empty() {
            awake.clear();
        }
        if !(awake.is_empty() || awake.len() == touching.len()) {
            archive.reject(|| format!("{} chunks of nodes, the deck requires {}", awake.len(), touching.len()));
            awake.clear();
        }
    }
}
