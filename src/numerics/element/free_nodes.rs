//! Free nodes, whose elements are all deleted: reflection at the axis of symmetry, and the merging of their mass with their
//! body.

use super::group::ElementGroup;
use crate::kernel::topology::{ElementNodes, ElementTopology};
use crate::state::archive::Persist;
use crate::state::nodes::Nodes;

/// Nodes whose elements are all deleted. Cohesive elements, which have no mass, do not count.
#[derive(Clone, Debug, Persist)]
#[persist(fixed: around; derived: fresh, pass, receivers)]
pub struct FreeNodes {
    /// Number of active elements at each node.
    around: Vec<u32>,
    nodes: Vec<u32>,
    /// Number of deleted elements that have been processed.
    seen: usize,
    /// Nodes that have become free in the last pass.
    fresh: Vec<u32>,
    /// Number of elements that had been deleted before the last pass.
    pass: usize,
    /// Work array: nodes that receive the mass of a free node.
    receivers: Vec<Receiver>,
}

/// A node that receives mass, and the axes along which its motion is free.
#[derive(Clone, Copy, Debug)]
struct Receiver {
    node: usize,
    free: [bool; 2],
}

/// Number of receivers for which memory is reserved; a node of a usual mesh has eight neighbours.
const RECEIVERS: usize = 64;

impl FreeNodes {
    /// Creates the list for elements of which none is deleted.
    pub(super) fn new(groups: &[Box<dyn ElementGroup>]) -> FreeNodes {
        let groups = || groups.iter().filter(|group| group.topology() != ElementTopology::Cohesive);
        let boundaries = || groups().flat_map(|group| (0..group.len()).map(|element| group.boundary(element)));
        let count = boundaries().flatten().max().map_or(0, |last| last as usize + 1);
        let mut around = vec![0; count];
        boundaries().flatten().for_each(|node| around[node as usize] += 1);
        FreeNodes { around, nodes: Vec::new(), seen: 0, fresh: Vec::new(), pass: 0, receivers: Vec::new() }
    }

    /// Reserves memory for all nodes, so that nothing allocates inside an increment.
    pub(super) fn make_room(&mut self) {
        self.nodes.reserve_exact(self.around.len().saturating_sub(self.nodes.len()));
        self.fresh.reserve_exact(self.around.len().saturating_sub(self.fresh.len()));
        self.receivers.reserve(RECEIVERS);
    }

    /// Returns the bytes of the list.
    pub fn bytes(&self) -> usize {
        let lists = self.around.capacity() + self.nodes.capacity() + self.fresh.capacity();
        size_of_val(self) + size_of::<u32>() * lists + size_of::<Receiver>() * self.receivers.capacity()
    }

    /// Takes the free nodes of a model with another mesh; `node` returns the node that one of that model has become.
    pub(super) fn follow_new_mesh(&mut self, previous: &FreeNodes, node: impl Fn(u32) -> Option<u32>) {
        self.nodes.clear();
        self.nodes.extend(previous.nodes.iter().filter_map(|n| node(*n)));
    }

    /// Adds the nodes of elements that were deleted since the last call; `deleted` lists all deleted elements.
    pub(super) fn count(&mut self, deleted: &[ElementNodes]) {
        self.fresh.clear();
        self.pass = self.seen.min(deleted.len());
        for node in deleted[self.pass..].iter().flat_map(|nodes| nodes.iter().map(|node| *node as usize)) {
            self.around[node] = self.around[node].saturating_sub(1);
            if self.around[node] == 0 {
                self.nodes.push(node as u32);
                self.fresh.push(node as u32);
            }
        }
        self.seen = deleted.len();
    }

    /// Returns whether nodes have become free in the last pass.
    pub(super) fn has_fresh(&self) -> bool {
        !self.fresh.is_empty()
    }

    /// Distributes the mass of each node that has become free in the last pass equally over the nodes of its last elements
    /// that still have elements. The impact is perfectly plastic and conserves momentum. A node without such neighbours
    /// remains a point mass. `free_axes` returns the axes along which the motion of a node is free, or `None` if the node may
    /// neither give nor receive mass. Returns the loss of kinetic energy; `None` if no mass has changed. Equation (12.5).
    pub(super) fn merge(
        &mut self,
        deleted: &[ElementNodes],
        nodes: &mut Nodes,
        free_axes: impl Fn(&Nodes, usize) -> Option<[bool; 2]>,
    ) -> Option<f64> {
        let FreeNodes { around, fresh, pass, receivers, .. } = self;
        let mut loss = None;
        for point in fresh.drain(..) {
            receivers.clear();
            if nodes.mass[point as usize] <= 0.0 || free_axes(nodes, point as usize).is_none() {
                continue;
            }
            let last_elements = deleted[*pass..].iter().filter(|boundary| boundary.contains(&point));
            for node in last_elements.flat_map(|boundary| boundary.iter().map(|n| *n as usize)) {
                let is_new = around[node] > 0 && receivers.iter().all(|known| known.node != node);
                if let (true, Some(free)) = (is_new && nodes.mass[node] > 0.0, free_axes(nodes, node)) {
                    receivers.push(Receiver { node, free });
                }
            }
            if !receivers.is_empty() {
                *loss.get_or_insert(0.0) += merge_point(nodes, point as usize, receivers);
            }
        }
        loss
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

/// Moves the mass of a point to its receivers, and returns the loss of the kinetic energy v(i-1/2) m v(i+1/2)/2. Along an
/// axis that is not free, the receiver is at rest and takes up the momentum. Equation (12.5).
fn merge_point(nodes: &mut Nodes, point: usize, receivers: &[Receiver]) -> f64 {
    let (share, dt) = (nodes.mass[point] / receivers.len() as f64, nodes.previous_dt);
    let (arriving, arriving_acceleration) = ([nodes[point].v_r, nodes[point].v_z], nodes.acceleration[point]);
    let mut loss = 0.0;
    for &Receiver { node, free } in receivers {
        let (mass, sum) = (nodes.mass[node], nodes.mass[node] + share);
        for axis in [0, 1] {
            let (v, a) = (*nodes[node].velocity(axis), nodes.acceleration[node][axis]);
            let (w, b) = (arriving[axis], arriving_acceleration[axis]);
            let mean = |own: f64, other: f64| if free[axis] { (mass * own + share * other) / sum } else { own };
            let (merged, acceleration) = (mean(v, w), mean(a, b));
            let twice = mass * v * (v + dt * a) + share * w * (w + dt * b);
            loss += 0.5 * (twice - sum * merged * (merged + dt * acceleration));
            *nodes[node].velocity(axis) = merged;
            nodes.acceleration[node][axis] = acceleration;
        }
        (nodes.mass[node], nodes.inverse_mass[node]) = (sum, 1.0 / sum);
    }
    (nodes.mass[point], nodes.inverse_mass[point]) = (0.0, 0.0);
    nodes.acceleration[point] = [0.0; 2];
    loss
}

#[cfg(test)]
mod tests {
    use super::FreeNodes;
    use crate::kernel::topology::ElementNodes;
    use crate::state::nodes::{Node, Nodes};

    /// Nodes of three triangles in a row, of which the first one is deleted: node 0 has no elements.
    fn strip() -> (FreeNodes, Nodes, Vec<ElementNodes>) {
        let around = vec![1, 2, 3, 2, 1];
        let free = FreeNodes { around, nodes: Vec::new(), seen: 0, fresh: Vec::new(), pass: 0, receivers: Vec::new() };
        let velocities = [[3.0, -4.0], [1.0, 2.0], [-2.0, 5.0], [0.0, 1.0], [0.0, 0.0]];
        let node = |[v_r, v_z]: [f64; 2]| Node { r: 1.0, z: 0.0, v_r, v_z };
        let nodes = Nodes::new(velocities.map(node).to_vec(), vec![2.0, 3.0, 5.0, 7.0, 1.0]);
        (free, nodes, vec![ElementNodes::from([0, 1, 2])])
    }

    fn momentum_and_energy(nodes: &Nodes) -> [f64; 3] {
        let pairs = || nodes.as_slice().iter().zip(&nodes.mass);
        let energy = pairs().map(|(n, m)| 0.5 * m * (n.v_r * n.v_r + n.v_z * n.v_z)).sum();
        [pairs().map(|(n, m)| m * n.v_r).sum(), pairs().map(|(n, m)| m * n.v_z).sum(), energy]
    }

    /// Perfectly plastic impacts of two halves of 1 kg on 3 kg and 5 kg: each loses m M/(m + M)/2 times the squared
    /// difference of the velocities, 36 + 4 and 81 + 25 (m/s)².
    #[test]
    fn merging_is_a_plastic_impact_of_two_masses() {
        let (mut free, mut nodes, deleted) = strip();
        let before = momentum_and_energy(&nodes);
        free.count(&deleted);
        let loss = free.merge(&deleted, &mut nodes, |_, _| Some([true; 2])).expect("a node has become free");
        let closed = 0.5 * (3.0 / 4.0) * 40.0 + 0.5 * (5.0 / 6.0) * 106.0;
        assert!((loss / closed - 1.0).abs() < 1e-14, "{loss} {closed}");
        let after = momentum_and_energy(&nodes);
        assert!((after[0] - before[0]).abs() < 1e-14 && (after[1] - before[1]).abs() < 1e-14, "{before:?} {after:?}");
        assert!((before[2] - after[2] - loss).abs() < 1e-13);
        assert_eq!(nodes.mass, [0.0, 4.0, 6.0, 7.0, 1.0]);
        assert_eq!(free.merge(&deleted, &mut nodes, |_, _| Some([true; 2])), None, "each node merges once");
    }

    /// The loss is that of the kinetic energy v(i-1/2) m v(i+1/2)/2 also where nodes are accelerated.
    #[test]
    fn loss_of_accelerated_masses_is_that_of_the_products_of_velocities() {
        let (mut free, mut nodes, deleted) = strip();
        nodes.previous_dt = 0.5;
        (nodes.acceleration[0], nodes.acceleration[1]) = ([2.0, -1.0], [-3.0, 4.0]);
        let energy = |nodes: &Nodes| -> f64 {
            let of_axis = |mass: f64, v: f64, a: f64| 0.5 * mass * v * (v + 0.5 * a);
            let motions = nodes.as_slice().iter().zip(&nodes.mass).zip(&nodes.acceleration);
            motions.map(|((n, m), a)| of_axis(*m, n.v_r, a[0]) + of_axis(*m, n.v_z, a[1])).sum()
        };
        let before = energy(&nodes);
        free.count(&deleted);
        let loss = free.merge(&deleted, &mut nodes, |_, _| Some([true; 2])).expect("a node has become free");
        assert!((before - energy(&nodes) - loss).abs() < 1e-13, "{before} {loss}");
    }

    /// Mass that has been received is passed on when the receiver becomes free: momentum is conserved over both impacts.
    #[test]
    fn merged_mass_merges_again() {
        let (mut free, mut nodes, mut deleted) = strip();
        let before = momentum_and_energy(&nodes);
        free.count(&deleted);
        let first = free.merge(&deleted, &mut nodes, |_, _| Some([true; 2])).expect("node 0");
        deleted.push(ElementNodes::from([1, 2, 3]));
        free.count(&deleted);
        let second = free.merge(&deleted, &mut nodes, |_, _| Some([true; 2])).expect("node 1");
        let after = momentum_and_energy(&nodes);
        assert_eq!(nodes.mass, [0.0, 0.0, 8.0, 9.0, 1.0]);
        assert!((after[0] - before[0]).abs() < 1e-14 && (after[1] - before[1]).abs() < 1e-14, "{before:?} {after:?}");
        assert!((before[2] - after[2] - first - second).abs() < 1e-13);
    }

    /// A receiver on the axis keeps its radial velocity of zero, and nodes that may not receive mass are left out.
    #[test]
    fn receivers_on_the_axis_do_not_move_along_r() {
        let (mut free, mut nodes, deleted) = strip();
        nodes[1].v_r = 0.0;
        let before = momentum_and_energy(&nodes);
        free.count(&deleted);
        let axes = |_: &Nodes, n| if n == 2 { None } else { Some([n != 1, true]) };
        let loss = free.merge(&deleted, &mut nodes, axes).expect("node 0");
        let after = momentum_and_energy(&nodes);
        assert_eq!((nodes[1].v_r, nodes.mass[1], nodes.mass[2]), (0.0, 5.0, 5.0));
        assert!((after[1] - before[1]).abs() < 1e-14);
        let closed = 0.5 * 2.0 * 9.0 + 0.5 * (2.0 * 3.0 / 5.0) * 36.0;
        assert!((loss / closed - 1.0).abs() < 1e-14, "{loss} {closed}");
    }
}
