//! Free nodes, whose elements are all deleted, at the axis of symmetry.

use super::group::ElementGroup;
use crate::kernel::topology::{ElementNodes, ElementTopology};
use crate::state::archive::Persist;
use crate::state::nodes::Nodes;

/// Nodes whose elements are all deleted. Cohesive elements, which have no mass, do not count.
#[derive(Clone, Debug, Persist)]
#[persist(fixed: around)]
pub struct FreeNodes {
    /// Number of active elements at each node.
    around: Vec<u32>,
    nodes: Vec<u32>,
    /// Number of deleted elements that have been processed.
    seen: usize,
}

impl FreeNodes {
    /// Creates the list for elements of which none is deleted.
    pub(super) fn new(groups: &[Box<dyn ElementGroup>]) -> FreeNodes {
        let groups = || groups.iter().filter(|group| group.topology() != ElementTopology::Cohesive);
        let boundaries = || groups().flat_map(|group| (0..group.len()).map(|element| group.boundary(element)));
        let count = boundaries().flatten().max().map_or(0, |last| last as usize + 1);
        let mut around = vec![0; count];
        boundaries().flatten().for_each(|node| around[node as usize] += 1);
        FreeNodes { around, nodes: Vec::new(), seen: 0 }
    }

    /// Reserves memory for all nodes, so that nothing allocates inside an increment.
    pub(super) fn make_room(&mut self) {
        self.nodes.reserve_exact(self.around.len().saturating_sub(self.nodes.len()));
    }

    /// Returns the bytes of the list.
    pub fn bytes(&self) -> usize {
        size_of_val(self) + size_of::<u32>() * (self.around.capacity() + self.nodes.capacity())
    }

    /// Takes the free nodes of a model with another mesh; `node` returns the node that one of that model has become.
    pub(super) fn follow_new_mesh(&mut self, previous: &FreeNodes, node: impl Fn(u32) -> Option<u32>) {
        self.nodes.clear();
        self.nodes.extend(previous.nodes.iter().filter_map(|n| node(*n)));
    }

    /// Adds the nodes of elements that were deleted since the last call; `deleted` lists all deleted elements.
    pub(super) fn count(&mut self, deleted: &[ElementNodes]) {
        for node in
            deleted[self.seen.min(deleted.len())..].iter().flat_map(|nodes| nodes.iter().map(|node| *node as usize))
        {
            self.around[node] = self.around[node].saturating_sub(1);
            if self.around[node] == 0 {
                self.nodes.push(node as u32);
            }
        }
        self.seen = deleted.len();
    }

    /// Reflects free nodes that have passed the axis. A ring without elements contracts to the axis, and its points pass
    /// through it to the opposite side: radius and radial velocity keep their magnitudes, and so do energy and momentum.
    /// Equation (12.4).
    pub fn reflect(&self, nodes: &mut Nodes) {
        let (nodes, _) = nodes.motion_mut();
        for &node in &self.nodes {
            let node = &mut nodes[node as usize];
            if node.r < 0.0 {
                (node.r, node.v_r) = (-node.r, -node.v_r);
            }
        }
    }
}
