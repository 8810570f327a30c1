//! Nodes that move on their own: those of deformable bodies.
//! Never here: elements, what prescribes a motion.

use std::ops::{Index, IndexMut};

use super::archive::{Archive, Persist, persist_fields, persist_struct};
use crate::kernel::lists::heap_bytes;

/// What elements read of a node: one half of a cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub struct Node {
    /// Current r.
    pub r: f64,
    /// Current z.
    pub z: f64,
    /// Velocity along r at the middle of the increment behind.
    pub v_r: f64,
    /// Velocity along z.
    pub v_z: f64,
}

impl Node {
    /// `[r, z]`.
    pub fn place(&self) -> [f64; 2] {
        [self.r, self.z]
    }

    /// `[r, z, v_r, v_z]`.
    #[inline(always)]
    pub fn as_array(&self) -> [f64; 4] {
        [self.r, self.z, self.v_r, self.v_z]
    }

    /// Velocity along r (0) or z (1).
    pub fn velocity(&mut self, axis: usize) -> &mut f64 {
        if axis == 0 { &mut self.v_r } else { &mut self.v_z }
    }

    /// Coordinate along r (0) or z (1).
    pub fn coordinate(&mut self, axis: usize) -> &mut f64 {
        if axis == 0 { &mut self.r } else { &mut self.z }
    }
}

/// Accelerations of nodes when the increment behind began, and the time over which they acted on velocities: (dt + dt')/2 of
/// both increments around. No accelerations where nothing is known of them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Accelerated<'a> {
    /// Of each node.
    pub accelerations: &'a [[f64; 2]],
    /// How long.
    pub half: f64,
}

/// All of them, in the order of the solver.
#[derive(Clone, Debug, Default)]
pub struct Nodes {
    list: Vec<Node>,
    /// Places at the start.
    pub start: Vec<[f64; 2]>,
    /// Lumped masses; 0 where a rigid body carries the node.
    pub mass: Vec<f64>,
    /// One over the mass; 0 where a rigid body carries the node.
    pub inverse_mass: Vec<f64>,
    /// Accelerations at the instant's own time.
    pub acceleration: Vec<[f64; 2]>,
    /// Forces on nodes that are not of elements, now and an instant before; empty without any.
    pub forces: [Vec<[f64; 2]>; 2],
    /// Length of the increment behind; 0 at the start.
    pub behind: f64,
    /// Time over which accelerations acted on the velocities last.
    pub half: f64,
    /// Whether there is an increment behind whose work is still to be booked.
    pub moved: bool,
}

impl Nodes {
    /// Nodes at their places at the start, with their masses.
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

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether nothing deforms.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Places and velocities.
    pub fn as_slice(&self) -> &[Node] {
        &self.list
    }

    /// Places and velocities, with the accelerations that change them.
    pub fn motion_mut(&mut self) -> (&mut [Node], &[[f64; 2]]) {
        (&mut self.list, &self.acceleration)
    }

    /// Makes room for forces, or takes it away.
    pub fn make_room(&mut self, pushed: bool) {
        let count = if pushed { self.list.len() } else { 0 };
        self.forces.iter_mut().for_each(|list| list.resize(count, [0.0; 2]));
    }

    /// The forces of this instant begin at zero; those that were become those before.
    pub fn begin_forces(&mut self) {
        let [now, before] = &mut self.forces;
        std::mem::swap(now, before);
        now.fill([0.0; 2]);
    }

    /// Length of the increment behind whose work is still to be booked; 0 where there is none.
    pub fn unbooked(&self) -> f64 {
        if self.moved { self.behind } else { 0.0 }
    }

    /// Velocity of a node a part of the increment behind after its middle: half of it is the instant's own time.
    pub fn velocity_after(&self, node: usize, part: f64) -> [f64; 2] {
        let (n, a, time) = (&self.list[node], self.acceleration[node], part * self.behind);
        [n.v_r + time * a[0], n.v_z + time * a[1]]
    }

    /// Velocity of a node at the instant's own time.
    pub fn velocity_now(&self, node: usize) -> [f64; 2] {
        self.velocity_after(node, 0.5)
    }

    /// Displacement of a node.
    pub fn displacement(&self, node: usize) -> [f64; 2] {
        [self.list[node].r - self.start[node][0], self.list[node].z - self.start[node][1]]
    }

    /// Gives a node another mass at its velocity. Returns by how much the kinetic energy grows with it along r and z, which is
    /// work from outside: with half v(i-1/2) m v(i+1/2) it is exactly half the added mass times v(i-1/2)^2.
    pub fn change_mass(&mut self, node: usize, mass: f64) -> [f64; 2] {
        let (added, n) = (mass - self.mass[node], &self.list[node]);
        self.mass[node] = mass;
        self.inverse_mass[node] = 1.0 / mass;
        [0.5 * added * n.v_r * n.v_r, 0.5 * added * n.v_z * n.v_z]
    }

    /// Bytes of forces, where there are any.
    pub fn bytes_of_forces(&self) -> usize {
        self.forces.len() * size_of::<[f64; 2]>() * self.list.len()
    }

    /// Names and bytes of the arrays, but for forces.
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

persist_struct!(Node { r, z, v_r, v_z });

impl Persist for Nodes {
    /// In a step that has begun: forces have their room. Those of the instant before are written over.
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Nodes { list, start: _, mass, inverse_mass, acceleration, forces, behind, half, moved } = self;
        persist_fields!(archive; list.as_mut_slice(), mass.as_mut_slice(), inverse_mass.as_mut_slice());
        persist_fields!(archive; acceleration.as_mut_slice(), forces[0].as_mut_slice(), behind, half, moved);
    }
}
