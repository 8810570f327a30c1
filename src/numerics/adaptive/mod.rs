//! Adaptive meshes (`*ADAPTIVE MESH`): nodes of a domain move to better places, and mass, momentum and element
//! variables are transported from the old to the new mesh of the same material. A mesh changes between two increments,
//! when the velocities of the next increment are known; no force is evaluated twice.

mod active;
mod boundary;
mod geometry;
pub mod held_places;
mod limiter;
mod momentum;
pub mod smoothing;
mod temperatures;
#[cfg(test)]
mod tests;
pub mod topology;
pub mod transport;

use crate::element::elements::Elements;
use crate::element::group::{ArrivedElements, ElementGroup};
use crate::heat::field::TemperatureField;
use crate::kernel::chunks::ChunkLoops;
use crate::kernel::lanes::{InlineMap, PACK, Pack};
use crate::kernel::lists::Memory;
use crate::kernel::quad;
use crate::kernel::shape::smallest_angle;
use crate::material::PointValue;
use crate::state::EffectId;
use crate::state::archive::Persist;
use crate::state::dofs::Dofs;
use crate::state::energies::BoundaryFlow;
use crate::state::magnitude::AmplitudeClock;
use crate::state::nodes::Nodes;
use active::{ActiveParts, MeshChange};
use held_places::{HeldPlaces, MeshMotion};
use limiter::smaller;
use momentum::MomentumTransport;
use smoothing::{MeshGrading, MeshSmoothing, NodeMobility, SmoothingWeights, Surroundings};
use temperatures::TemperatureTransport;
use topology::DomainTopology;
use transport::{ElementTransport, TransportOrder};

/// Largest share of its volume that an element may lose in one transport.
const LARGEST_SHARE: f64 = 0.5;
/// Largest number of transports in which nodes reach their new places; longer displacements are cut.
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
    /// Whether sweeps start from the places after the previous change of the mesh; otherwise from those of the material.
    pub returns: bool,
}

/// Boundaries of a domain, and motions of its nodes that are prescribed in space.
pub struct DomainBoundary<'a> {
    /// Whether each node of the solver moves with the material.
    pub fixed: &'a [bool],
    /// Whether each node of the solver slides also at the ends of prescribed motions of the material.
    pub sliding: &'a [bool],
    /// Returns whether an edge of the boundary, given by its nodes in the solver, is on an Eulerian boundary.
    pub is_open: &'a dyn Fn([u32; 2]) -> bool,
    pub motions: Vec<MeshMotion>,
}

/// A domain of elements of one group with its transport; all arrays are allocated here, so that nothing allocates
/// inside an increment.
#[derive(Clone, Debug, Persist, Memory)]
#[persist(
    fixed: prescribed;
    derived: id, group, settings, topology, active, transport, momentum, temperatures, places, velocity,
        given_velocity, node_mass, mass, material_volume, corner_mass, packs, mass_shares, due_sweeps, is_corrected
)]
#[memory(inside: packs)]
pub struct AdaptiveDomain {
    /// Ledger row.
    pub id: EffectId,
    group: usize,
    settings: AdaptiveSettings,
    topology: DomainTopology,
    smoothing: MeshSmoothing,
    held_places: HeldPlaces,
    active: ActiveParts,
    transport: ElementTransport,
    momentum: MomentumTransport,
    /// Parts of the element masses that are not from mass scaling; `None` without it.
    mass_shares: Option<Vec<Pack>>,
    /// Nodal temperatures; `None` if the elements have none.
    temperatures: Option<TemperatureTransport>,
    /// Places of the nodes: before, at the end, and at both ends of a transport.
    places: [Vec<[f64; 2]>; 4],
    /// Velocities in the middle of the next increment, before and after the change of the mesh.
    given_velocity: Vec<[f64; 2]>,
    velocity: Vec<[f64; 2]>,
    /// Masses of nodes, of elements and of their corners, before and after a transport.
    node_mass: [Vec<f64>; 2],
    mass: Vec<f64>,
    /// Volumes of the material in the elements; empty if no pressure follows from the density.
    material_volume: Vec<f64>,
    corner_mass: [Vec<[f64; 4]>; 2],
    /// Element variables, [`PACK`] in each list.
    packs: Vec<Vec<Pack>>,
    /// Whether the motion of each node along r and z is prescribed.
    prescribed: Vec<[bool; 2]>,
    /// Increment in which the domain became active.
    first: Option<u64>,
    /// Number of changes of the mesh in which a node has moved.
    changes: u64,
    /// Number of sweeps of the change of the mesh that has begun; otherwise 0.
    due_sweeps: usize,
    /// Whether contact has corrected new places in this change.
    is_corrected: bool,
}

impl AdaptiveDomain {
    /// Creates a domain from elements of a group, in ascending order; `None` if the group cannot be transported.
    /// `nodes` are at their places at the start.
    pub fn new(
        id: EffectId,
        settings: AdaptiveSettings,
        (index, group): (usize, &mut dyn ElementGroup),
        elements: Vec<u32>,
        (nodes, boundary): (&Nodes, DomainBoundary<'_>),
    ) -> Option<AdaptiveDomain> {
        let topology = DomainTopology::new(group, elements, boundary.is_open);
        let transfer = group.transfer()?;
        let variables = transfer.variables();
        transfer.prepare();
        let (cells, count) = (topology.corners.len(), topology.nodes.len());
        let has_material_volume = topology.elements.first().is_some_and(|e| transfer.volume_ratio(*e).is_some());
        let mobility = mobility(&topology, boundary.fixed);
        let slides_at_ends = topology.nodes.iter().map(|n| boundary.sliding.get(*n as usize) == Some(&true)).collect();
        let held_places = HeldPlaces::new(&topology, boundary.motions, settings.returns);
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
                (mobility, slides_at_ends),
            ),
            held_places,
            active: ActiveParts::new(&topology),
            transport: ElementTransport::new(&topology, settings.order),
            momentum: MomentumTransport::new(&topology, settings.order),
            mass_shares: None,
            temperatures: None,
            places: [places(), places(), places(), places()],
            given_velocity: places(),
            velocity: places(),
            node_mass: [numbers(count), numbers(count)],
            mass: numbers(cells),
            material_volume: numbers(if has_material_volume { cells } else { 0 }),
            corner_mass: [vec![[0.0; 4]; cells], vec![[0.0; 4]; cells]],
            packs: vec![vec![Pack::default(); cells]; variables.div_ceil(PACK)],
            prescribed: vec![[false; 2]; count],
            topology,
            first: None,
            changes: 0,
            due_sweeps: 0,
            is_corrected: false,
        })
    }

    /// Returns the domain with the transport of masses without scaling.
    #[must_use]
    pub fn with_mass_scaling(mut self) -> AdaptiveDomain {
        self.mass_shares = Some(vec![Pack::default(); self.topology.corners.len()]);
        self
    }

    /// Returns the domain with the transport of nodal temperatures.
    #[must_use]
    pub fn with_temperatures(mut self) -> AdaptiveDomain {
        self.temperatures = Some(TemperatureTransport::new(self.topology.nodes.len()));
        self
    }

    /// Returns the element group of the domain.
    pub fn group(&self) -> usize {
        self.group
    }

    /// Takes the history of the domain of a previous step with the same ledger row.
    pub fn continue_from(&mut self, previous: &AdaptiveDomain) {
        (self.first, self.changes) = (previous.first, previous.changes);
        self.smoothing.continue_from(&previous.smoothing);
        self.held_places.continue_from(&previous.held_places);
    }

    /// Takes the history of the domain of the same ledger row with another mesh.
    pub fn follow(&mut self, previous: &AdaptiveDomain) {
        (self.first, self.changes) = (previous.first, previous.changes);
    }

    /// Takes the degrees of freedom (node and axis) whose motions are prescribed from now on.
    pub fn begin(&mut self, prescribed: &[(usize, usize)], nodes: &Nodes) {
        self.prescribed.fill([false; 2]);
        for (node, axis) in prescribed {
            if let Ok(at) = self.topology.nodes.binary_search(&(*node as u32)) {
                self.prescribed[at][*axis] = true;
            }
        }
        self.held_places.begin(&self.topology, &self.prescribed, nodes);
    }

    /// Advances the prescribed places of the mesh by an increment from the time of the clock on.
    pub fn advance(&mut self, clock: &AmplitudeClock<'_>, dt: f64) {
        self.held_places.advance(clock, dt);
    }

    /// Returns the number of sweeps that are due at an increment.
    fn sweeps_at(&mut self, increment: u64) -> usize {
        let first = *self.first.get_or_insert(increment);
        if increment == first {
            return self.settings.initial_sweeps;
        }
        if (increment - first).is_multiple_of(self.settings.frequency) { self.settings.sweeps } else { 0 }
    }

    /// Returns whether the mesh is due to change at an increment.
    pub fn is_due(&mut self, increment: u64) -> bool {
        self.due_sweeps = self.sweeps_at(increment);
        self.due_sweeps > 0
    }

    /// Finds new places of the nodes if the mesh is due to change.
    pub fn find_new_places(
        &mut self,
        loops: ChunkLoops,
        elements: &Elements,
        nodes: &Nodes,
        surroundings: &dyn Surroundings,
    ) {
        if self.due_sweeps > 0 {
            self.find_places((self.due_sweeps, loops), elements, nodes, surroundings);
        }
    }

    /// Returns the new place of a node; `None` if the mesh does not change now or has no such node.
    pub fn new_place(&self, node: usize) -> Option<[f64; 2]> {
        self.position(node).map(|at| self.places[1][at])
    }

    /// Returns whether the new place of a node may be corrected along r and z.
    pub fn is_free(&self, node: usize) -> [bool; 2] {
        let free =
            |at: usize| self.held_places.kept[at].inline_map(|kept| !kept && self.smoothing.is_on_free_boundary(at));
        self.position(node).map_or([false; 2], free)
    }

    /// Moves the new place of a node.
    pub fn shift(&mut self, node: usize, [r, z]: [f64; 2]) {
        if let Some(at) = self.position(node) {
            let new_place = &mut self.places[1][at];
            *new_place = [new_place[0] + r, new_place[1] + z];
            self.is_corrected = true;
        }
    }

    /// Returns the position of a node in the domain if the mesh changes now.
    fn position(&self, node: usize) -> Option<usize> {
        self.topology.nodes.binary_search(&(node as u32)).ok().filter(|_| self.due_sweeps > 0)
    }

    /// Begins the change to the new places. Returns whether a node moves.
    pub fn begin_change(&mut self) -> bool {
        let [start, end, ..] = &mut self.places;
        if std::mem::take(&mut self.is_corrected) {
            self.smoothing.take_back_corrected(&self.topology, &self.held_places, start, end);
        }
        let moves = std::mem::take(&mut self.due_sweeps) > 0 && self.active.find(&self.topology, [start, end]);
        self.changes += u64::from(moves);
        moves
    }

    /// Returns the number of changes of the mesh in which a node has moved.
    pub fn changes(&self) -> u64 {
        self.changes
    }

    /// Returns the smallest angle of all elements, radians.
    pub fn smallest_angle(&self, nodes: &Nodes) -> f64 {
        let position = |n: u32| nodes[self.topology.nodes[n as usize] as usize].place();
        let angles = self.topology.corners.iter().map(|corners| smallest_angle(corners, position));
        angles.fold(f64::INFINITY, f64::min)
    }

    /// Changes the mesh. `half` is the time over which accelerations change the velocities to those of the next increment.
    /// Calls `changed` for each node with prescribed motion whose mass has changed, with the change of its kinetic energy
    /// along r and z at the same velocity.
    pub fn change(
        &mut self,
        (half, loops): (f64, ChunkLoops),
        elements: &mut Elements,
        (dofs, mut field): (&mut Dofs, Option<&mut TemperatureField>),
        changed: &mut dyn FnMut(usize, [f64; 2]),
    ) {
        self.read(half, elements, &dofs.nodes);
        if let (Some(temperatures), Some(field)) = (&mut self.temperatures, &field) {
            temperatures.read(&self.topology, self.group, field);
        }
        let kinetic_before = self.kinetic();
        self.given_velocity.copy_from_slice(&self.velocity);
        let (transports, entered) = (self.limit_displacements(loops), dofs.energies.flow.kinetic);
        for i in 0..transports {
            self.transport_part((i, transports), loops, &mut dofs.energies.flow);
        }
        self.restore_prescribed();
        dofs.energies.advection += kinetic_before + (dofs.energies.flow.kinetic - entered) - self.kinetic();
        self.write(half, elements, &mut dofs.nodes, changed);
        if let (Some(temperatures), Some(field)) = (&mut self.temperatures, &mut field) {
            field.take_masses(self.group, |e| elements.mass_scaling.unscaled_masses(&elements.groups, self.group, e));
            temperatures.write((&self.topology, &self.active), field);
        }
    }

    /// Finds new places by smoothing.
    fn find_places(
        &mut self,
        (sweeps, loops): (usize, ChunkLoops),
        elements: &Elements,
        nodes: &Nodes,
        surroundings: &dyn Surroundings,
    ) {
        let group = &*elements.groups[self.group];
        let deletable = group.properties().deletable;
        let deleted = |e: u32| deletable && group.is_deleted(e as usize);
        self.smoothing.restrict(&self.topology, (&self.prescribed, &self.held_places), deleted);
        let [start, end, ..] = &mut self.places;
        for (place, n) in start.iter_mut().zip(&self.topology.nodes) {
            *place = nodes[*n as usize].place();
        }
        end.copy_from_slice(start);
        if !self.held_places.returns() {
            self.smoothing.add_deferred(end);
        }
        self.held_places.place(&self.topology, (start, end), &self.smoothing, surroundings);
        self.smoothing.read_contact(&self.topology, surroundings);
        for _ in 0..sweeps {
            self.smoothing.sweep(loops, &self.topology, &self.held_places, surroundings, end);
        }
        self.held_places.remember(end);
        self.smoothing.defer_short(&self.topology, &self.held_places, start, end);
    }

    fn read(&mut self, half: f64, elements: &mut Elements, nodes: &Nodes) {
        if let Some(shares) = &mut self.mass_shares {
            for (i, e) in self.topology.elements.iter().enumerate().filter(|(i, _)| self.active.reads[*i]) {
                shares[i].0[..2].copy_from_slice(&elements.mass_scaling.unscaled_shares(self.group, *e as usize));
            }
        }
        let group = &mut elements.groups[self.group];
        for (i, e) in self.topology.elements.iter().enumerate().filter(|(i, _)| self.active.reads[*i]) {
            let masses = group.masses(*e as usize);
            let corners = [0, 1, 2, 3].inline_map(|c: usize| masses[c]);
            (self.corner_mass[0][i], self.mass[i]) = (corners, (corners[0] + corners[1]) + (corners[2] + corners[3]));
        }
        if let Some(transfer) = group.transfer() {
            transfer.read((&self.topology.elements, &self.active.reads), &mut self.packs);
            for (i, volume) in self.material_volume.iter_mut().enumerate().filter(|(i, _)| self.active.reads[*i]) {
                let ratio = transfer.volume_ratio(self.topology.elements[i]).unwrap_or(1.0);
                *volume = ratio * self.topology.volume(i, &self.places[0]);
            }
        }
        for (i, n) in self.topology.nodes.iter().enumerate() {
            let n = *n as usize;
            let (node, a) = (&nodes[n], nodes.acceleration[n]);
            self.velocity[i] = [node.v_r + half * a[0], node.v_z + half * a[1]];
            self.node_mass[0][i] = nodes.mass[n];
        }
    }

    /// Returns the kinetic energy of the nodes of elements that change.
    fn kinetic(&self) -> f64 {
        let nodes = self.node_mass[0].iter().zip(&self.velocity).zip(&self.active.nodes);
        0.5 * nodes.filter(|n| *n.1).map(|((m, [r, z]), _)| m * (r * r + z * z)).sum::<f64>()
    }

    fn restore_prescribed(&mut self) {
        let nodes = self.velocity.iter_mut().zip(&self.given_velocity).zip(&self.prescribed);
        for ((velocity, given), prescribed) in nodes {
            for axis in 0..2 {
                if prescribed[axis] {
                    velocity[axis] = given[axis];
                }
            }
        }
    }

    /// Cuts displacements that are too long, and returns the number of transports in which nodes reach the new places.
    fn limit_displacements(&mut self, loops: ChunkLoops) -> usize {
        let [start, end, ..] = &mut self.places;
        let change = MeshChange { domain: &self.topology, active: &self.active, loops };
        let share = self.transport.measure(change, [start, end]);
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

    /// Sets the places at both ends of one part of the displacements, and measures the transport between them.
    fn begin_part(&mut self, (part, parts): (usize, usize), loops: ChunkLoops) {
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
        // A single part has been measured.
        if parts > 1 {
            let [_, _, from, to] = &self.places;
            let change = MeshChange { domain: &self.topology, active: &self.active, loops };
            self.transport.measure(change, [from, to]);
        }
    }

    /// Transports masses, momentum and variables over one part of the displacements.
    fn transport_part(&mut self, (part, parts): (usize, usize), loops: ChunkLoops, flow: &mut BoundaryFlow) {
        self.begin_part((part, parts), loops);
        let change = MeshChange { domain: &self.topology, active: &self.active, loops };
        if !self.material_volume.is_empty() {
            self.transport.move_content(change, &mut self.material_volume);
        }
        self.transport.move_masses(change, &mut self.mass);
        self.find_masses(loops);
        let change = MeshChange { domain: &self.topology, active: &self.active, loops };
        let [before, after] = &self.corner_mass;
        boundary::add_flow(flow, &self.topology, self.transport.fluxes(), &self.velocity);
        self.momentum.measure(change, self.transport.fluxes(), [before, after]);
        self.momentum.move_velocity(change, &mut self.velocity, &self.node_mass[1]);
        if let Some(temperatures) = &mut self.temperatures {
            let [before, after] = &self.node_mass;
            temperatures.add_flow(&self.topology, self.transport.fluxes());
            temperatures.advance(&mut self.momentum, change, [before, after]);
        }
        let packs = self.packs.iter_mut().chain(&mut self.mass_shares);
        packs.for_each(|values| self.transport.move_variables(change, values));
        self.corner_mass.swap(0, 1);
        self.node_mass.swap(0, 1);
    }

    /// Finds the masses of corners and nodes after a part of the displacements.
    fn find_masses(&mut self, loops: ChunkLoops) {
        let [_, _, _, to] = &self.places;
        let ([masses_before, after], mass, changes) = (&mut self.corner_mass, &self.mass, &self.active.changes);
        let (topology, masses_before) = (&self.topology, &*masses_before);
        loops.each(after, |start, part| {
            for (at, after) in part.iter_mut().enumerate() {
                let e = start + at;
                *after = if changes[e] {
                    corner_masses(topology.corners[e].inline_map(|n| to[n as usize]), mass[e])
                } else {
                    masses_before[e]
                };
            }
        });
        let (after, nodes, [node_before, node_after]) = (&*after, &self.active.nodes, &mut self.node_mass);
        let node_before = &*node_before;
        loops.each(node_after, |start, part| {
            for (at, node_after) in part.iter_mut().enumerate() {
                let n = start + at;
                *node_after = node_before[n];
                if nodes[n] {
                    for e in topology.around.list(n).iter().map(|e| *e as usize).filter(|e| changes[*e]) {
                        for (i, corner) in topology.corners[e].iter().enumerate() {
                            *node_after += if *corner as usize == n { after[e][i] - masses_before[e][i] } else { 0.0 };
                        }
                    }
                }
            }
        });
    }

    fn write(
        &mut self,
        half: f64,
        elements: &mut Elements,
        nodes: &mut Nodes,
        changed: &mut dyn FnMut(usize, [f64; 2]),
    ) {
        let group = &mut elements.groups[self.group];
        if let Some(transfer) = group.transfer() {
            let (masses, corners) = (&*self.corner_mass[0], &*self.topology.corners);
            let arrived = ArrivedElements { masses, corners, places: &self.places[1] };
            transfer.write((&self.topology.elements, &self.active.changes), &self.packs, arrived);
            for (i, volume) in self.material_volume.iter().enumerate().filter(|(i, _)| self.active.changes[*i]) {
                let ratio = volume / self.topology.volume(i, &self.places[1]);
                group.set(self.topology.elements[i] as usize, PointValue::VolumeRatio(ratio));
            }
        }
        elements.wake();
        for (i, n) in self.topology.nodes.iter().enumerate().filter(|(i, _)| self.active.nodes[*i]) {
            let (n, mass, [v_r, v_z]) = (*n as usize, self.node_mass[0][i], self.velocity[i]);
            let ([r, z], a, added) = (self.places[1][i], nodes.acceleration[n], mass - nodes.mass[n]);
            let node = &mut nodes[n];
            (node.r, node.z, node.v_r, node.v_z) = (r, z, v_r - half * a[0], v_z - half * a[1]);
            if added != 0.0 {
                (nodes.mass[n], nodes.inverse_mass[n]) = (mass, 1.0 / mass);
                if self.prescribed[i] != [false; 2] {
                    changed(n, [0.5 * added * v_r * v_r, 0.5 * added * v_z * v_z]);
                }
            }
        }
        if let Some(shares) = &self.mass_shares {
            for (i, e) in self.topology.elements.iter().enumerate().filter(|(i, _)| self.active.changes[*i]) {
                let [plain, fixed, ..] = shares[i].0;
                let Elements { groups, mass_scaling, .. } = &mut *elements;
                let element = (self.group, *e as usize);
                mass_scaling.take_masses(groups, element, self.corner_mass[0][i], [plain, fixed]);
            }
            elements.mass_scaling.sum_masses(nodes);
        }
    }
}

/// Smallest mass of a corner over the mean of the element. Corners of convex elements have more, also on the axis.
const SMALLEST_SHARE: f64 = 0.05;

/// Returns the masses of the corners of an element with a mass. In an element that the material has made concave, the integral of
/// a shape function can be negative: the integrals are then averaged with their mean, so that all masses are positive.
fn corner_masses(corners: [[f64; 2]; 4], mass: f64) -> [f64; 4] {
    let shares = quad::corner_masses(corners, 1.0);
    let sum = (shares[0] + shares[1]) + (shares[2] + shares[3]);
    let least = smaller(smaller(shares[0], shares[1]), smaller(shares[2], shares[3]));
    let mean = 0.25 * sum;
    if sum <= 0.0 {
        return [0.25 * mass; 4];
    }
    if least >= SMALLEST_SHARE * mean {
        return shares.inline_map(|share| mass / sum * share);
    }
    let part = (1.0 - SMALLEST_SHARE) * mean / (mean - least);
    shares.inline_map(|share| mass / sum * (mean + part * (share - mean)))
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
