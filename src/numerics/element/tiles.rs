//! Tiles: parts of large element groups in which corner forces are summed at their nodes while they are in the cache of a
//! core. A tile is a sequence of tasks that one thread updates. Corner forces of the last tasks are in a ring of memory of
//! this thread, and nodes are summed after the task with their last element. Only corner forces at nodes of several tiles
//! are stored. Sums have the same order, and thus the same bits, as without tiles.

use std::cell::RefCell;
use std::ops::Range;

use super::lane_sums::TASK;
use crate::kernel::chunks::FEW;
use crate::kernel::lanes::{BlockCornerForces, InlineMap, LANES};
use crate::kernel::lists::Memory;
use crate::mesh::corner_forces::CornerForces;
use crate::mesh::gather::{NodalAssembly, SLOTS, slots_total};
use crate::state::archive::Persist;

/// Tasks of a ring: 4 096 elements, or 256 kB.
const RING: usize = 16;
/// Smallest and largest number of tasks of a tile, and the number of tiles of a group between. Small tiles have many nodes
/// in common with others; many threads need many tiles.
const TILE: [usize; 2] = [16, 64];
const TILES: usize = 32;
/// Tiles are used if at most one node in this number is shared.
const UNSHARED: usize = 4;

thread_local! {
    /// The ring of a thread, and a block of zeros.
    static CORNERS: RefCell<CornerForces> = RefCell::default();
}

/// Calls a function with the ring of the thread.
pub(super) fn with_ring(of_ring: impl FnOnce(&mut CornerForces)) {
    CORNERS.with_borrow_mut(|ring| {
        if ring.is_empty() {
            *ring = CornerForces::new(RING * TASK + 1);
        }
        of_ring(ring);
    });
}

/// Returns the blocks of the ring for a task with a number of blocks.
pub(super) fn blocks_in_ring(task: usize, blocks: usize) -> Range<usize> {
    let first = task % RING * TASK;
    first..first + blocks
}

/// Tiles of all groups, and the nodal forces that they sum.
#[derive(Clone, Debug, Persist, Memory)]
#[persist(fixed: forces; derived: groups, slots, shared, first_shared, stored)]
#[memory(inside: groups)]
pub(super) struct Tiles {
    /// `None` for a group that stores all its corner forces.
    groups: Vec<Option<GroupTiles>>,
    /// Corner slots of each node in the ring; for other nodes those of zeros.
    slots: Vec<[u16; SLOTS]>,
    /// Sums of corner forces by node.
    forces: Vec<[f64; 2]>,
    /// Nodes that are summed from stored corner forces instead, in ascending order.
    shared: Vec<u32>,
    /// For each chunk of [`FEW`] nodes, the index in `shared` of its first one.
    first_shared: Vec<u32>,
    /// Blocks of corner forces that are stored, in ascending order.
    stored: Vec<u32>,
}

/// Tiles of a group.
#[derive(Clone, Debug, Memory)]
struct GroupTiles {
    /// Tasks of a tile.
    length: usize,
    /// Numbers of nodes and of stored blocks before each task, and after the last one. Nodes are counted from the first of
    /// the model, blocks from the first of the group.
    before: Vec<[u32; 2]>,
    /// The stored blocks, counted within their tasks.
    stored: Vec<u8>,
}

/// Blocks of corner forces of a group.
struct GroupBlocks {
    blocks: Range<usize>,
    /// Tasks of a tile; `None` if the group stores all its corner forces.
    length: Option<usize>,
}

impl GroupBlocks {
    /// Returns the blocks of each group; see [`Tiles::new`].
    fn of(groups: impl Iterator<Item = (usize, bool)>, length: impl Fn(usize) -> usize) -> Vec<GroupBlocks> {
        let mut first = 0;
        let group = |(count, tiles): (usize, bool)| {
            let blocks = first..first + count;
            first = blocks.end;
            GroupBlocks { blocks, length: tiles.then(|| length(count.div_ceil(TASK))) }
        };
        groups.map(group).collect()
    }

    fn task(&self, block: usize) -> usize {
        (block - self.blocks.start) / TASK
    }

    /// Returns the slot in the ring of a slot of all corner forces.
    fn ring_slot(&self, slot: u32) -> u16 {
        let (block, within) = CornerForces::place(slot);
        CornerForces::index((block - self.blocks.start) % (RING * TASK), 0, 0) as u16 + within as u16
    }

    /// Returns the last task of the blocks, from the first to the last, if the ring of one tile holds their forces until
    /// its end.
    fn completing_task(&self, first: usize, last: usize) -> Option<usize> {
        let length = self.length?;
        if !self.blocks.contains(&first) || !self.blocks.contains(&last) {
            return None;
        }
        let (first, last) = (self.task(first), self.task(last));
        (first / length == last / length && last - first < RING).then_some(last)
    }
}

/// Returns the number of tasks of a tile for a group with a number of tasks.
pub(super) fn tile_length(tasks: usize) -> usize {
    (tasks / TILES).clamp(TILE[0], TILE[1])
}

/// Node that a task completes.
#[derive(Clone, Copy)]
struct CompletedNode {
    group: usize,
    task: usize,
}

impl Tiles {
    /// Creates the tiles of groups, given by their numbers of blocks and whether they can have tiles, and the assembly of
    /// stored corner forces at shared nodes. `gather` is the assembly of all corner forces; `always` are blocks that are
    /// stored in any case; `length` returns the number of tasks of a tile from that of its group. Returns `None` if too
    /// many nodes are shared.
    pub fn new(
        groups: impl Iterator<Item = (usize, bool)>,
        gather: &NodalAssembly,
        always: impl Iterator<Item = usize>,
        length: impl Fn(usize) -> usize,
    ) -> Option<(Tiles, NodalAssembly)> {
        let parts = GroupBlocks::of(groups, length);
        let blocks = parts.last().map_or(0, |part| part.blocks.end);
        let mut is_stored = vec![false; blocks];
        let whole = parts.iter().filter(|part| part.length.is_none()).flat_map(|part| part.blocks.clone());
        whole.chain(always).for_each(|block| is_stored[block] = true);

        let nodes = gather.nodes();
        let zeros = CornerForces::index(RING * TASK, 0, 0) as u16;
        let (mut slots, mut shared) = (vec![[zeros; SLOTS]; nodes], Vec::new());
        let mut ends: Vec<Vec<u32>> = parts.iter().map(|p| vec![0; p.blocks.len().div_ceil(TASK)]).collect();
        let mut last = CompletedNode { group: 0, task: 0 };
        for (node, slots) in slots.iter_mut().enumerate() {
            let completed = completing(&parts, gather, node);
            let in_order = completed.filter(|c| (c.group, c.task) >= (last.group, last.task));
            if let Some(completed) = in_order {
                last = completed;
                ends[last.group][last.task] = node as u32 + 1;
                let ring_slots = gather.slots(node).map(|slot| parts[last.group].ring_slot(slot));
                slots.iter_mut().zip(ring_slots).for_each(|(to, slot)| *to = slot);
            } else {
                shared.push(node as u32);
                gather.slots(node).for_each(|slot| is_stored[CornerForces::place(slot).0] = true);
            }
        }
        if shared.len() * UNSHARED > nodes {
            return None;
        }
        let stored: Vec<u32> = (0..blocks as u32).filter(|block| is_stored[*block as usize]).collect();
        let gather = gather.of_nodes(&shared, stored.len(), |slot| {
            let (block, within) = CornerForces::place(slot);
            let index = stored.partition_point(|other| (*other as usize) < block);
            (CornerForces::index(index, 0, 0) + within) as u32
        });
        let mut nodes_before = 0;
        let mut of_group = |(part, ends): (&GroupBlocks, Vec<u32>)| {
            let length = part.length?;
            Some(GroupTiles::new(part, length, &mut nodes_before, &ends, &is_stored))
        };
        let tiles = Tiles {
            groups: parts.iter().zip(ends).map(&mut of_group).collect(),
            slots,
            forces: vec![[0.0; 2]; nodes],
            first_shared: (0..=nodes.div_ceil(FEW))
                .map(|chunk| shared.partition_point(|node| (*node as usize) < chunk * FEW) as u32)
                .collect(),
            shared,
            stored,
        };
        Some((tiles, gather))
    }

    /// Returns the number of blocks whose corner forces are stored.
    pub fn stored(&self) -> usize {
        self.stored.len()
    }

    /// Returns the stored blocks among a range of all blocks, as a range of stored ones.
    pub fn stored_among(&self, blocks: &Range<usize>) -> Range<usize> {
        let count_below = |end: usize| self.stored.partition_point(|block| (*block as usize) < end);
        count_below(blocks.start)..count_below(blocks.end)
    }

    /// Returns the tiles of a group for a pass; `None` if it has none.
    pub fn pass(&mut self, group: usize) -> Option<TilePass<'_>> {
        let tiles = self.groups.get(group)?.as_ref()?;
        let nodes = tiles.nodes(0..tiles.tasks());
        Some(TilePass { tiles, slots: &self.slots, forces: &mut self.forces[nodes] })
    }

    /// Writes the forces of the nodes from `first` on, a multiple of [`FEW`]; `gather` is the assembly of stored corner
    /// forces. It is not inlined, so that the loop over nodes of models without tiles stays short.
    #[inline(never)]
    pub fn sum(&self, first: usize, gather: (&NodalAssembly, &CornerForces), forces: &mut [[f64; 2]]) {
        forces.copy_from_slice(&self.forces[first..first + forces.len()]);
        let chunk = first / FEW;
        for at in self.first_shared[chunk] as usize..self.first_shared[chunk + 1] as usize {
            forces[self.shared[at] as usize - first] = gather.0.node_force(at, gather.1);
        }
    }

    /// Returns the force of a node.
    pub fn node_force(&self, node: usize, gather: (&NodalAssembly, &CornerForces)) -> [f64; 2] {
        match self.shared.binary_search(&(node as u32)) {
            Ok(at) => gather.0.node_force(at, gather.1),
            Err(_) => self.forces[node],
        }
    }
}

/// Returns the task that completes a node, if its corner forces are in the ring of one tile.
fn completing(parts: &[GroupBlocks], gather: &NodalAssembly, node: usize) -> Option<CompletedNode> {
    let blocks = || gather.slots(node).map(|slot| CornerForces::place(slot).0);
    let (first, last) = (blocks().min()?, blocks().max()?);
    if blocks().count() > SLOTS {
        return None;
    }
    let group = parts.partition_point(|part| part.blocks.end <= last);
    Some(CompletedNode { group, task: parts[group].completing_task(first, last)? })
}

impl GroupTiles {
    /// Creates the tiles of a group from the end of the nodes that each of its tasks completes, 0 if it completes none.
    fn new(part: &GroupBlocks, length: usize, nodes: &mut u32, ends: &[u32], is_stored: &[bool]) -> GroupTiles {
        let mut tiles = GroupTiles { length, before: vec![[*nodes, 0]], stored: Vec::new() };
        let tasks = is_stored[part.blocks.clone()].chunks(TASK);
        for (blocks, end) in tasks.zip(ends) {
            tiles.stored.extend((0..blocks.len() as u8).filter(|block| blocks[usize::from(*block)]));
            *nodes = end.max(nodes).to_owned();
            tiles.before.push([*nodes, tiles.stored.len() as u32]);
        }
        tiles
    }

    fn tasks(&self) -> usize {
        self.before.len() - 1
    }

    /// Returns the range of nodes that a range of tasks completes.
    fn nodes(&self, tasks: Range<usize>) -> Range<usize> {
        self.before[tasks.start][0] as usize..self.before[tasks.end][0] as usize
    }

    /// Returns the range of stored blocks of a range of tasks.
    fn blocks(&self, tasks: Range<usize>) -> Range<usize> {
        self.before[tasks.start][1] as usize..self.before[tasks.end][1] as usize
    }
}

/// Tiles of a group, and the nodal forces that they sum in a pass.
pub struct TilePass<'a> {
    tiles: &'a GroupTiles,
    slots: &'a [[u16; SLOTS]],
    forces: &'a mut [[f64; 2]],
}

impl<'a> TilePass<'a> {
    /// Returns all tasks; `corners` are the stored corner forces of the group.
    pub(super) fn all(self, corners: &'a mut [BlockCornerForces]) -> TileTasks<'a> {
        let TilePass { tiles, slots, forces } = self;
        TileTasks { tiles, slots, tasks: 0..tiles.tasks(), forces, corners }
    }
}

/// A range of tasks, with the forces of the nodes that they complete and their stored corner forces.
pub(super) struct TileTasks<'a> {
    tiles: &'a GroupTiles,
    slots: &'a [[u16; SLOTS]],
    pub tasks: Range<usize>,
    forces: &'a mut [[f64; 2]],
    corners: &'a mut [BlockCornerForces],
}

impl TileTasks<'_> {
    /// Returns the number of tasks of about half of the tiles; `None` if there is only one.
    pub fn half(&self) -> Option<usize> {
        let tiles = self.tasks.len().div_ceil(self.tiles.length);
        (tiles > 1).then(|| tiles / 2 * self.tiles.length)
    }

    /// Divides the tasks after the first `count`.
    pub fn split(self, count: usize) -> (Self, Self) {
        let TileTasks { tiles, slots, tasks, forces, corners } = self;
        let (first, second) = (tasks.start..tasks.start + count, tasks.start + count..tasks.end);
        let forces = forces.split_at_mut(tiles.nodes(first.clone()).len());
        let corners = corners.split_at_mut(tiles.blocks(first.clone()).len());
        (
            TileTasks { tiles, slots, tasks: first, forces: forces.0, corners: corners.0 },
            TileTasks { tiles, slots, tasks: second, forces: forces.1, corners: corners.1 },
        )
    }

    /// Sums the forces of the nodes that a task completes, whose corner forces are in the ring, and stores corner forces.
    pub fn complete(&mut self, task: usize, ring: &mut CornerForces) {
        let first_node = self.tiles.nodes(self.tasks.start..task).len();
        let nodes = self.tiles.nodes(task..task + 1);
        sum(&self.slots[nodes.clone()], ring.values(), &mut self.forces[first_node..first_node + nodes.len()]);
        let first_block = self.tiles.blocks(self.tasks.start..task).len();
        let stored = &self.tiles.stored[self.tiles.blocks(task..task + 1)];
        let blocks = ring.slots(blocks_in_ring(task, TASK));
        for (to, from) in self.corners[first_block..].iter_mut().zip(stored) {
            *to = blocks[usize::from(*from)];
        }
    }
}

/// Sums corner forces of a ring.
fn sum(slots: &[[u16; SLOTS]], ring: &[f64], forces: &mut [[f64; 2]]) {
    let pair = |slot: u16| [ring[usize::from(slot)], ring[usize::from(slot) + LANES]];
    for (force, slots) in forces.iter_mut().zip(slots) {
        *force = slots_total(slots.inline_map(pair));
    }
}
