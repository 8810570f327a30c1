//! What is at rest costs nothing: tasks of elements without stress whose nodes do not move, and the nodes that only such
//! elements touch, are passed over until something reaches them. Skipping them changes no bit.
//! Never here: arithmetic of elements and nodes.

use super::group::{ElementGroup, TASK};
use crate::kernel::lanes::LANES;
use crate::kernel::lists::heap_bytes;
use crate::state::archive::{Archive, Persist, persist_struct};
use crate::state::nodes::Node;

/// Nodes that are passed over together.
pub const FEW: usize = 32;

/// Whether a task of elements is quiescent, and its nodes.
#[derive(Clone, Debug)]
pub(super) struct Quiescence {
    pub nodes: Vec<u32>,
    /// Since the start of the analysis nothing has reached the task.
    pub quiescent: bool,
}

impl Quiescence {
    /// The tasks of a group, all awake.
    pub fn of_tasks<const N: usize>(elements: &[[u32; N]]) -> Vec<Quiescence> {
        let task = |part: &[[u32; N]]| {
            let mut nodes: Vec<u32> = part.as_flattened().to_vec();
            nodes.sort_unstable();
            nodes.dedup();
            Quiescence { nodes, quiescent: false }
        };
        elements.chunks(TASK * LANES).map(task).collect()
    }

    pub fn bytes(&self) -> usize {
        size_of::<Quiescence>() + heap_bytes(&self.nodes)
    }

    /// Whether no node of the task moves.
    pub fn is_still(&self, nodes: &[Node]) -> bool {
        self.nodes.iter().all(|&n| nodes[n as usize].v_r == 0.0 && nodes[n as usize].v_z == 0.0)
    }
}

/// Which nodes have work, a few at a time.
#[derive(Clone, Debug, Default)]
pub(super) struct ActiveNodes {
    /// Groups and tasks that touch each few nodes; empty once all are awake for good.
    touching: Vec<Vec<(u32, u32)>>,
    /// Whether they have work in this increment; empty if all have.
    awake: Vec<bool>,
}

impl ActiveNodes {
    /// From the nodes of each group's elements.
    pub fn new(count: usize, groups: &[Box<dyn ElementGroup>]) -> Self {
        let mut touching = vec![Vec::new(); count.div_ceil(FEW)];
        for (g, group) in groups.iter().enumerate() {
            for e in 0..group.len() {
                let task = (g as u32, (e / (TASK * LANES)) as u32);
                for node in group.nodes(e) {
                    let list = &mut touching[node as usize / FEW];
                    if list.last() != Some(&task) && !list.contains(&task) {
                        list.push(task);
                    }
                }
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

    /// After the elements: nodes of quiescent tasks have no work, unless a force acts on them.
    pub fn update(&mut self, groups: &[Box<dyn ElementGroup>], external: &[[f64; 2]]) {
        if self.touching.is_empty() {
            return;
        }
        let quiescent = |(group, task): &(u32, u32)| groups[*group as usize].is_quiescent(*task as usize);
        self.awake.clear();
        self.awake.extend(self.touching.iter().map(|list| !list.iter().all(quiescent)));
        if self.awake.iter().all(|awake| *awake) {
            self.wake();
            return;
        }
        for (awake, forces) in self.awake.iter_mut().zip(external.chunks(FEW)) {
            *awake |= forces.iter().any(|f| f[0] != 0.0 || f[1] != 0.0);
        }
    }

    /// Whether the nodes from `first` on, a few, have work.
    #[inline(always)]
    pub fn has_work(&self, first: usize) -> bool {
        self.awake.is_empty() || self.awake[first / FEW]
    }
}

persist_struct!(Quiescence { quiescent } derived { nodes });

impl Persist for ActiveNodes {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let ActiveNodes { touching, awake } = self;
        let mut for_good = touching.is_empty();
        for_good.persist(archive);
        if for_good {
            touching.clear();
        }
        awake.persist(archive);
        // On the way back all may be awake for good by now, which changes no bit.
        if touching.is_empty() {
            awake.clear();
        }
        if !(awake.is_empty() || awake.len() == touching.len()) {
            archive.refuse(|| format!("{} parts of the nodes, of which the deck has {}", awake.len(), touching.len()));
            awake.clear();
        }
    }
}
