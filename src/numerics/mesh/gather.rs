//! Assembly of corner forces into nodal forces, in a fixed order, so that the sums have the same bits on any number of
//! threads.

use super::corner_forces::CornerForces;
use crate::kernel::lanes::{InlineMap, LANES};
use crate::kernel::lists::Memory;
use crate::kernel::prefetch::request;
use crate::kernel::topology::ElementNodes;

/// Corner slots stored inline; most nodes of a quadrilateral mesh have at most four.
pub const SLOTS: usize = 4;

/// Returns the sum of the corner forces of a node: the one order of summation of the first slots.
#[inline(always)]
pub fn slots_total([a, b, c, d]: [[f64; 2]; SLOTS]) -> [f64; 2] {
    [(a[0] + b[0]) + (c[0] + d[0]), (a[1] + b[1]) + (c[1] + d[1])]
}

/// Corner slots of each node, in fixed order.
#[derive(Clone, Debug, Default, Memory)]
pub struct NodalAssembly {
    /// First slots of each node, as indices of corner forces; unused ones refer to a slot of zeros.
    slots: Vec<[u32; SLOTS]>,
    /// Additional slots, as pairs of node and slot.
    more: Vec<(u32, u32)>,
    /// The slot of zeros.
    empty: u32,
}

impl NodalAssembly {
    /// Creates the assembly for `count` nodes. Each group gives its number of corner force blocks per element block,
    /// and its elements; it starts with a new block.
    pub fn new<G>(count: usize, groups: &[(usize, G)]) -> Self
    where
        G: ExactSizeIterator<Item = ElementNodes> + Clone,
    {
        let blocks: usize = groups.iter().map(|(per, g)| per * g.len().div_ceil(LANES)).sum();
        let empty = CornerForces::index(blocks, 0, 0) as u32;
        let mut gather = NodalAssembly { slots: vec![[empty; SLOTS]; count], more: Vec::new(), empty };
        let mut block = 0;
        for (per, elements) in groups {
            for (e, nodes) in elements.clone().enumerate() {
                for (c, &node) in nodes.iter().enumerate() {
                    let slot = CornerForces::index(block + e / LANES * per + c / 4, e % LANES, c % 4) as u32;
                    match gather.slots[node as usize].iter_mut().find(|s| **s == empty) {
                        Some(free) => *free = slot,
                        None => gather.more.push((node, slot)),
                    }
                }
            }
            block += per * elements.len().div_ceil(LANES);
        }
        gather.more.sort_unstable();
        gather
    }

    /// Creates the assembly of some nodes for corner forces in `blocks` other blocks; `map` returns the new index
    /// of a slot.
    pub fn of_nodes(&self, nodes: &[u32], blocks: usize, map: impl Fn(u32) -> u32) -> Self {
        let empty = CornerForces::index(blocks, 0, 0) as u32;
        let mut part = NodalAssembly { slots: vec![[empty; SLOTS]; nodes.len()], more: Vec::new(), empty };
        for (at, (&node, slots)) in nodes.iter().zip(&mut part.slots).enumerate() {
            let mut slots_of_node = self.slots(node as usize).map(&map);
            slots.iter_mut().zip(&mut slots_of_node).for_each(|(to, slot)| *to = slot);
            part.more.extend(slots_of_node.map(|slot| (at as u32, slot)));
        }
        part
    }

    /// Returns the number of nodes.
    pub fn nodes(&self) -> usize {
        self.slots.len()
    }

    /// Returns the corner slots of a node in the order of summation.
    pub fn slots(&self, node: usize) -> impl Iterator<Item = u32> {
        let first = self.more.partition_point(|m| (m.0 as usize) < node);
        let more = self.more[first..].iter().take_while(move |m| m.0 as usize == node).map(|m| m.1);
        self.slots[node].iter().copied().filter(|slot| *slot != self.empty).chain(more)
    }

    pub fn node_force(&self, node: usize, corners: &CornerForces) -> [f64; 2] {
        let mut force = [[0.0; 2]];
        self.sum(node, corners, &mut force);
        force[0]
    }

    /// Sums the corner forces of the nodes starting with `first`.
    #[inline(always)]
    pub fn sum(&self, first: usize, corners: &CornerForces, forces: &mut [[f64; 2]]) {
        let values = corners.values();
        let pair = |slot: u32| [values[slot as usize], values[slot as usize + LANES]];
        let last = first + forces.len();
        for (force, slots) in forces.iter_mut().zip(&self.slots[first..last]) {
            *force = slots_total(slots.inline_map(pair));
        }
        if self.more.is_empty() {
            return;
        }
        let begin = self.more.partition_point(|m| (m.0 as usize) < first);
        for &(node, slot) in self.more[begin..].iter().take_while(|m| (m.0 as usize) < last) {
            let (force, more) = (&mut forces[node as usize - first], pair(slot));
            *force = [force[0] + more[0], force[1] + more[1]];
        }
    }

    /// Requests the corner forces of the `count` nodes from `first` on, if there are so many. Successive nodes usually have
    /// successive slots, so that the slots of one node in eight cover all cache lines.
    #[inline(always)]
    pub fn prefetch(&self, first: usize, count: usize, corners: &CornerForces) {
        let Some(nodes) = self.slots.get(first..first + count) else { return };
        for &slot in nodes.iter().step_by(8).flatten() {
            request(corners.values(), slot as usize, 1);
            request(corners.values(), slot as usize + LANES, 1);
        }
    }
}
