//! Adaptive meshes (`*ADAPTIVE MESH`): nodes of a domain move to better places, and mass, momentum and element
//! variables are transported from the old to the new mesh of the same material. A mesh changes between two increments,
//! when the velocities of the next increment are known; no force is evaluated twice.

mod geometry;
mod limiter;
mod momentum;
pub mod smoothing;
#[cfg(test)]
mod tests;
pub mod topology;
pub mod transport;

use crate::element::elements::Elements;
use crate::element::group::ElementGroup;
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::heap_bytes;
use crate::kernel::quad;
use crate::state::EffectId;
use crate::state::archive::persist_struct;
use crate::state::dofs::Dofs;
use crate::state::nodes::Nodes;
use momentum::MomentumTransport;
use smoothing::{MeshGrading, MeshSmoothing, NodeMobility, SmoothingWeights, Surroundings};
use topology::DomainTopology;
use transport::{ElementTransport, TransportOrder};

/// Largest share of its volume that an element may lose in one transport.
const LARGEST_SHARE: f64 = 0.5;
/// Largest number of transports in which nodes reach their new places; longer ways are cut.
const MOST_TRANSPORTS: usize = 8;

/// Parameters of `*ADAPTIVE MESH` and its controls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptiveSettings {
    /// Number of increments between two changes of the mesh.
    pub frequency: u64,
    /// Number of sweeps in each change.
    pub sweeps: usize,
    /// Number of sweeps at the start of the first step in which the domain is active.
    pub initial_sweeps: usize,
    pub weights: SmoothingWeights,
    /// Whether the grading of the mesh at the start is kept; then the weights have no effect.
    pub graded: bool,
    /// Angle between the edges of the boundary from which on a node is at a corner, radians.
    pub corner_angle: f64,
    pub order: TransportOrder,
}

/// A domain of elements of one group with its transport; all arrays are allocated here, so that nothing allocates
/// inside an increment.
#[derive(Clone, Debug)]
pub struct AdaptiveDomain {
    /// Ledger row.
    pub id: EffectId,
    group: usize,
    settings: AdaptiveSettings,
    topology: DomainTopology,
    smoothing: MeshSmoothing,
    transport: ElementTransport,
    momentum: MomentumTransport,
    /// Places of the nodes: before, at the end, and at both ends of a transport.
    places: [Vec<[f64; 2]>; 4],
    /// Velocities in the middle of the next increment along r and z.
    velocity: [Vec<f64>; 2],
    /// The same before the change of the mesh.
    given_velocity: [Vec<f64>; 2],
    /// Masses of nodes, of elements and of their corners, before and after a transport.
    node_mass: [Vec<f64>; 2],
    mass: Vec<f64>,
    corner_mass: [Vec<[f64; 4]>; 2],
    /// Element variables.
    table: Vec<Vec<f64>>,
    /// Whether the motion of each node along r and z is prescribed.
    prescribed: Vec<[bool; 2]>,
    /// Increment in which the domain became active.
    first: Option<u64>,
}

impl AdaptiveDomain {
    /// Creates a domain from elements of a group, in ascending order; `None` if the group cannot be transported.
    /// `fixed` is whether each of the `nodes`, at their places at the start, moves with the material.
    pub fn new(
        id: EffectId,
        settings: AdaptiveSettings,
        (index, group): (usize, &mut dyn ElementGroup),
        elements: Vec<u32>,
        (nodes, fixed): (&Nodes, &[bool]),
    ) -> Option<AdaptiveDomain> {
        let topology = DomainTopology::new(group, elements);
        let variables = group.extensions().transfer()?.variables();
        let (cells, count) = (topology.corners.len(), topology.nodes.len());
        let mobility = mobility(&topology, fixed);
        let starts: Vec<[f64; 2]> = topology.nodes.iter().map(|n| nodes[*n as usize].place()).collect();
        let grading = settings.graded.then(|| MeshGrading::new(&topology, &starts));
        let numbers = |count: usize| vec![0.0; count];
        let places = || vec![[0.0; 2]; count];
        Some(AdaptiveDomain {
            id,
            group: index,
            settings,
            smoothing: MeshSmoothing::new(
                (&topology, &starts),
                settings.weights,
                grading,
                libm::cos(settings.corner_angle),
                mobility,
            ),
            transport: ElementTransport::new(&topology, settings.order),
            momentum: MomentumTransport::new(&topology, settings.order),
            places: [places(), places(), places(), places()],
            velocity: [numbers(count), numbers(count)],
            given_velocity: [numbers(count), numbers(count)],
            node_mass: [numbers(count), numbers(count)],
            mass: numbers(cells),
            corner_mass: [vec![[0.0; 4]; cells], vec![[0.0; 4]; cells]],
            table: (0..variables).map(|_| numbers(cells)).collect(),
            prescribed: vec![[false; 2]; count],
            topology,
            first: None,
        })
    }

    /// Takes the history of the domain of a previous step with the same ledger row.
    pub fn continue_from(&mut self, previous: &AdaptiveDomain) {
        self.first = previous.first;
    }

    /// Returns the size of all lists in bytes.
    pub fn bytes(&self) -> usize {
        let work = self.topology.bytes() + self.smoothing.bytes() + self.transport.bytes() + self.momentum.bytes();
        let nodes = self.places.iter().map(heap_bytes).sum::<usize>()
            + self.velocity.iter().chain(&self.given_velocity).chain(&self.node_mass).map(heap_bytes).sum::<usize>();
        let elements = heap_bytes(&self.mass)
            + self.corner_mass.iter().map(heap_bytes).sum::<usize>()
            + self.table.iter().map(heap_bytes).sum::<usize>();
        work + nodes + elements + heap_bytes(&self.prescribed)
    }

    /// Takes the degrees of freedom (node and axis) whose motions are prescribed from now on.
    pub fn begin(&mut self, prescribed: &[(usize, usize)]) {
        self.prescribed.fill([false; 2]);
        for (node, axis) in prescribed {
            if let Ok(at) = self.topology.nodes.binary_search(&(*node as u32)) {
                self.prescribed[at][*axis] = true;
            }
        }
    }

    /// Returns the number of sweeps that are due at an increment.
    fn sweeps_at(&mut self, increment: u64) -> usize {
        let first = *self.first.get_or_insert(increment);
        if increment == first {
            return self.settings.initial_sweeps;
        }
        if (increment - first).is_multiple_of(self.settings.frequency) { self.settings.sweeps } else { 0 }
    }

    /// Finds new places of the nodes if the mesh is due to change at an increment. Returns whether a node moves.
    pub fn begin_change(
        &mut self,
        increment: u64,
        elements: &Elements,
        nodes: &Nodes,
        surroundings: &dyn Surroundings,
    ) -> bool {
        let sweeps = self.sweeps_at(increment);
        sweeps > 0 && self.find_places(sweeps, elements, nodes, surroundings)
    }

    /// Changes the mesh. `half` is the time over which accelerations change the velocities to those of the next increment.
    /// Calls `changed` for each node whose mass has changed, with the change of its kinetic energy along r and z at the same
    /// velocity.
    pub fn change(
        &mut self,
        half: f64,
        elements: &mut Elements,
        dofs: &mut Dofs,
        changed: &mut dyn FnMut(usize, [f64; 2]),
    ) {
        self.read(half, elements, &dofs.nodes);
        let before = self.kinetic();
        let [v_r, v_z] = &mut self.given_velocity;
        v_r.copy_from_slice(&self.velocity[0]);
        v_z.copy_from_slice(&self.velocity[1]);
        let transports = self.limit_ways();
        for i in 0..transports {
            self.transport_part(i, transports);
        }
        self.restore_prescribed();
        dofs.energies.advection += before - self.kinetic();
        self.write(half, elements, &mut dofs.nodes, changed);
    }

    /// Finds new places by smoothing. Returns whether a node moves.
    fn find_places(
        &mut self,
        sweeps: usize,
        elements: &Elements,
        nodes: &Nodes,
        surroundings: &dyn Surroundings,
    ) -> bool {
        let group = &*elements.groups[self.group];
        let deletable = group.properties().deletable;
        let deleted = |e: u32| deletable && group.is_deleted(e as usize);
        self.smoothing.restrict(&self.topology, &self.prescribed, deleted);
        let [start, end, ..] = &mut self.places;
        for (place, n) in start.iter_mut().zip(&self.topology.nodes) {
            *place = nodes[*n as usize].place();
        }
        end.copy_from_slice(start);
        self.smoothing.read_contact(&self.topology, surroundings);
        for _ in 0..sweeps {
            self.smoothing.sweep(&self.topology, &self.prescribed, surroundings, end);
        }
        start != end
    }

    fn read(&mut self, half: f64, elements: &mut Elements, nodes: &Nodes) {
        let group = &mut elements.groups[self.group];
        for ((e, corners), mass) in self.topology.elements.iter().zip(&mut self.corner_mass[0]).zip(&mut self.mass) {
            let masses = group.masses(*e as usize);
            *corners = [0, 1, 2, 3].inline_map(|c: usize| masses[c]);
            *mass = (corners[0] + corners[1]) + (corners[2] + corners[3]);
        }
        if let Some(transfer) = group.extensions().transfer() {
            transfer.read(&self.topology.elements, &mut self.table);
        }
        let [v_r, v_z] = &mut self.velocity;
        for (i, n) in self.topology.nodes.iter().enumerate() {
            let n = *n as usize;
            let (node, a) = (&nodes[n], nodes.acceleration[n]);
            (v_r[i], v_z[i]) = (node.v_r + half * a[0], node.v_z + half * a[1]);
            self.node_mass[0][i] = nodes.mass[n];
        }
    }

    /// Returns the kinetic energy of the nodes.
    fn kinetic(&self) -> f64 {
        let [v_r, v_z] = &self.velocity;
        0.5 * self.node_mass[0].iter().zip(v_r.iter().zip(v_z)).map(|(m, (r, z))| m * (r * r + z * z)).sum::<f64>()
    }

    fn restore_prescribed(&mut self) {
        for (axis, (velocity, given)) in self.velocity.iter_mut().zip(&self.given_velocity).enumerate() {
            let nodes = velocity.iter_mut().zip(given).zip(&self.prescribed);
            nodes.filter(|node| node.1[axis]).for_each(|((velocity, given), _)| *velocity = *given);
        }
    }

    /// Cuts ways that are too long, and returns the number of transports in which nodes reach the new places.
    fn limit_ways(&mut self) -> usize {
        let [start, end, ..] = &mut self.places;
        let share = self.transport.measure(&self.topology, start, end);
        let count = (share / LARGEST_SHARE).ceil().max(1.0);
        if count <= MOST_TRANSPORTS as f64 {
            return count as usize;
        }
        let part = MOST_TRANSPORTS as f64 / count;
        for (end, start) in end.iter_mut().zip(&*start) {
            *end = [0, 1].inline_map(|i: usize| start[i] + part * (end[i] - start[i]));
        }
        MOST_TRANSPORTS
    }

    /// Transports masses, momentum and variables over one part of the way.
    fn transport_part(&mut self, part: usize, parts: usize) {
        let [start, end, from, to] = &mut self.places;
        for (place, part) in [(from, part), (to, part + 1)] {
            let share = part as f64 / parts as f64;
            for ((place, start), end) in place.iter_mut().zip(&*start).zip(&*end) {
                *place = if part == parts {
                    *end
                } else {
                    [0, 1].inline_map(|i: usize| start[i] + share * (end[i] - start[i]))
                };
            }
        }
        let [_, _, from, to] = &self.places;
        let domain = &self.topology;
        self.transport.measure(domain, from, to);
        self.transport.move_masses(domain, &self.mass);
        self.mass.copy_from_slice(&self.transport.mass);
        let [before, after] = &mut self.corner_mass;
        let [node_before, node_after] = &mut self.node_mass;
        node_after.copy_from_slice(node_before);
        for (e, corners) in domain.corners.iter().enumerate() {
            after[e] = corner_masses(corners.inline_map(|n| to[n as usize]), self.mass[e]);
            for (n, (after, before)) in corners.iter().zip(after[e].iter().zip(before[e])) {
                node_after[*n as usize] += after - before;
            }
        }
        self.momentum.measure(domain, from, self.transport.mass_fluxes(), [before, after]);
        self.velocity.iter_mut().for_each(|velocity| self.momentum.move_velocity(velocity, node_after));
        self.table.iter_mut().for_each(|values| self.transport.move_variable(domain, values));
        std::mem::swap(before, after);
        std::mem::swap(node_before, node_after);
    }

    fn write(
        &mut self,
        half: f64,
        elements: &mut Elements,
        nodes: &mut Nodes,
        changed: &mut dyn FnMut(usize, [f64; 2]),
    ) {
        let group = &mut elements.groups[self.group];
        if let Some(transfer) = group.extensions().transfer() {
            transfer.write(&self.topology.elements, &self.table, &self.corner_mass[0]);
        }
        elements.wake();
        let [v_r, v_z] = &self.velocity;
        for (i, n) in self.topology.nodes.iter().enumerate() {
            let (n, mass) = (*n as usize, self.node_mass[0][i]);
            let ([r, z], a, added) = (self.places[1][i], nodes.acceleration[n], mass - nodes.mass[n]);
            let node = &mut nodes[n];
            (node.r, node.z, node.v_r, node.v_z) = (r, z, v_r[i] - half * a[0], v_z[i] - half * a[1]);
            if added != 0.0 {
                (nodes.mass[n], nodes.inverse_mass[n]) = (mass, 1.0 / mass);
                changed(n, [0.5 * added * v_r[i] * v_r[i], 0.5 * added * v_z[i] * v_z[i]]);
            }
        }
    }
}

/// Returns the masses of the corners of an element with a mass.
fn corner_masses(corners: [[f64; 2]; 4], mass: f64) -> [f64; 4] {
    let shares = quad::corner_masses(corners, 1.0);
    let sum = (shares[0] + shares[1]) + (shares[2] + shares[3]);
    shares.inline_map(|share| mass / sum * share)
}

/// Returns how each node of a domain may move.
fn mobility(topology: &DomainTopology, fixed: &[bool]) -> Vec<NodeMobility> {
    let fixed = |n: &u32| fixed.get(*n as usize).copied().unwrap_or(false);
    let mut mobility: Vec<NodeMobility> =
        topology.inside.iter().map(|inside| if *inside { NodeMobility::Inside } else { NodeMobility::Fixed }).collect();
    topology.boundary.iter().for_each(|b| mobility[b.node as usize] = NodeMobility::Boundary);
    for (mobility, _) in mobility.iter_mut().zip(&topology.nodes).filter(|n| fixed(n.1)) {
        *mobility = NodeMobility::Fixed;
    }
    mobility
}

persist_struct!(AdaptiveDomain { first, prescribed: fixed } derived {
    id, group, settings, topology, smoothing, transport, momentum, places, velocity, given_velocity, node_mass, mass,
    corner_mass, table
});
