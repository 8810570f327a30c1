//! Nodes of deformable bodies: positions, velocities, masses and forces.

use std::ops::{Index, IndexMut};

use super::archive::{Persist, StateArchive, persist_fields};
use crate::kernel::lists::heap_bytes;

/// Nodal data that elements read: half a cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Persist)]
#[repr(C, align(32))]
pub struct Node {
    /// Current coordinate r, length.
    pub r: f64,
    /// Current coordinate z, length.
    pub z: f64,
    /// Velocity along r at the middle of the previous increment.
    pub v_r: f64,
    /// Velocity along z at the middle of the previous increment.
    pub v_z: f64,
}

impl Node {
    /// Returns the position `[r, z]`.
    pub fn place(&self) -> [f64; 2] {
        [self.r, self.z]
    }

    /// Returns `[r, z, v_r, v_z]`.
    #[inline(always)]
    pub fn as_array(&self) -> [f64; 4] {
        [self.r, self.z, self.v_r, self.v_z]
    }

    /// Returns the velocity along r (0) or z (1).
    pub fn velocity(&mut self, axis: usize) -> &mut f64 {
        if axis == 0 { &mut self.v_r } else { &mut self.v_z }
    }

    /// Returns the coordinate r (0) or z (1).
    pub fn coordinate(&mut self, axis: usize) -> &mut f64 {
        if axis == 0 { &mut self.r } else { &mut self.z }
    }
}

/// Accelerations of nodes at the start of the previous increment, and the time over which they changed the velocities:
/// (dt + dt')/2 of the increments before and after that instant. The default is no accelerations.
#[derive(Clone, Copy, Debug, Default)]
pub struct NodeAccelerations<'a> {
    /// Accelerations of all nodes, `[r, z]`; empty if unknown.
    pub accelerations: &'a [[f64; 2]],
    /// Time over which they acted.
    pub half: f64,
}

/// All nodes of deformable bodies, in the order of the solver.
#[derive(Clone, Debug, Default)]
pub struct Nodes {
    list: Vec<Node>,
    /// Initial positions `[r, z]`.
    pub start: Vec<[f64; 2]>,
    /// Lumped masses; 0 for nodes of rigid bodies.
    pub mass: Vec<f64>,
    /// Inverse masses; 0 for nodes of rigid bodies.
    pub inverse_mass: Vec<f64>,
    /// Accelerations `[r, z]` at the current instant.
    pub acceleration: Vec<[f64; 2]>,
    /// Nodal forces not from elements, at the current and the previous instant; empty without such forces.
    pub forces: [Vec<[f64; 2]>; 2],
    /// Length of the previous increment; 0 at the start.
    pub previous_dt: f64,
    /// Time over which accelerations acted in the last velocity update.
    pub half: f64,
    /// Whether the work of the previous increment has not been added to the energies yet.
    pub work_pending: bool,
}

impl Nodes {
    /// Creates nodes at initial positions with their masses.
    pub fn new(list: Vec<Node>, mass: Vec<f64>) -> Self {
        Nodes {
            start: list.iter().map(Node::place).collect(),
            inverse_mass: mass.iter().map(|&m| if m > 0.0 { 1.0 / m } else { 0.0 }).collect(),
            mass,
            acceleration: vec![[0.0; 2]; list.len()],
            list,
            ..Nodes::default()
        }
    }

    /// Returns the number of nodes.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Returns whether no node is integrated: there are no deformable bodies, no springs and no free masses.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Returns positions and velocities.
    pub fn as_slice(&self) -> &[Node] {
        &self.list
    }

    /// Returns positions and velocities for modification, and the accelerations.
    pub fn motion_mut(&mut self) -> (&mut [Node], &[[f64; 2]]) {
        (&mut self.list, &self.acceleration)
    }

    /// Allocates or frees the forces that are not from elements.
    pub fn resize_forces(&mut self, pushed: bool) {
        let count = if pushed { self.list.len() } else { 0 };
        self.forces.iter_mut().for_each(|list| list.resize(count, [0.0; 2]));
    }

    /// Moves the current forces to the previous instant, and sets the current ones to zero.
    pub fn begin_forces(&mut self) {
        let [now, before] = &mut self.forces;
        std::mem::swap(now, before);
        now.fill([0.0; 2]);
    }

    /// Returns the length of the previous increment if its work has not been added to the energies yet, otherwise 0.
    pub fn unaccounted_dt(&self) -> f64 {
        if self.work_pending { self.previous_dt } else { 0.0 }
    }

    /// Returns the velocity of a node at `part` times the previous increment after its middle; 0.5 is the current
    /// instant. Equation (4.4).
    pub fn velocity_after(&self, node: usize, part: f64) -> [f64; 2] {
        let (n, a, time) = (&self.list[node], self.acceleration[node], part * self.previous_dt);
        [n.v_r + time * a[0], n.v_z + time * a[1]]
    }

    /// Returns the velocity of a node at the current instant.
    pub fn velocity_now(&self, node: usize) -> [f64; 2] {
        self.velocity_after(node, 0.5)
    }

    /// Returns the displacement `[r, z]` of a node from its initial position.
    pub fn displacement(&self, node: usize) -> [f64; 2] {
        [self.list[node].r - self.start[node][0], self.list[node].z - self.start[node][1]]
    }

    /// Changes the mass of a node at constant velocity. Returns the increase of kinetic energy along r and z, which is
    /// external work: with the energy v(i-1/2) m v(i+1/2)/2 it is exactly half the added mass times v(i-1/2)².
    pub fn change_mass(&mut self, node: usize, mass: f64) -> [f64; 2] {
        let (added, n) = (mass - self.mass[node], &self.list[node]);
        self.mass[node] = mass;
        self.inverse_mass[node] = 1.0 / mass;
        [0.5 * added * n.v_r * n.v_r, 0.5 * added * n.v_z * n.v_z]
    }

    /// Returns the number of bytes that the nodal forces occupy.
    pub fn bytes_of_forces(&self) -> usize {
        self.forces.len() * size_of::<[f64; 2]>() * self.list.len()
    }

    /// Returns names and bytes of the arrays except forces.
    pub fn arrays(&self) -> Vec<(&'static str, usize)> {
        vec![
            ("motion", heap_bytes(&self.list)),
            ("start", heap_bytes(&self.start)),
            ("mass", size_of::<f64>() * (self.mass.capacity() + self.inverse_mass.capacity())),
            ("acceleration", heap_bytes(&self.acceleration)),
        ]
    }
}

impl Index<usize> for Nodes {
    type Output = Node;

    #[inline(always)]
    fn index(&self, node: usize) -> &Node {
        &self.list[node]
    }
}

impl IndexMut<usize> for Nodes {
    #[inline(always)]
    fn index_mut(&mut self, node: usize) -> &mut Node {
        &mut self.list[node]
    }
}

impl Persist for Nodes {
    /// Visits the state within a step, where the forces are allocated. Those of the previous instant are overwritten
    /// before use and not saved.
    fn persist(&mut self, archive: &mut StateArchive<'_>) {
        let Nodes { list, start: _, mass, inverse_mass, acceleration, forces, previous_dt, half, work_pending } = self;
        persist_fields!(archive; list.as_mut_slice(), mass.as_mut_slice(), inverse_mass.as_mut_slice());
        persist_fields!(archive; acceleration.as_mut_slice(), forces[0].as_mut_slice(), previous_dt, half, work_pending);
    }
}
