//! All that deforms in a scene: nodes with their masses, groups of elements, what is prescribed on nodes and what pushes
//! them. Central differences for nodes. Never here: the length of an increment, deck words.

use rayon::prelude::*;

use crate::constraint::distortion::Controlled;
use crate::constraint::equation::System;
use crate::constraint::motion::Prescribed;
use crate::constraint::tie::Tie;
use crate::constraint::wall::Wall;
use crate::element::Corners;
use crate::element::block::is_larger;
use crate::element::connector::{Bounds, Connector};
use crate::element::frequency::HighestFrequency;
use crate::element::group::{Group, Totals};
use crate::element::mass_scaling::Masses;
use crate::element::quiescent::{Awake, FEW};
use crate::element::rings::Rings;
use crate::kernel::lanes::LANES;
use crate::state::EffectId;
use crate::state::Instant;
use crate::state::archive::{Archive, Persist, persist_all, persist_fields};
use crate::state::halt::Halt;
use crate::state::magnitude::Magnitude;
use crate::state::nodes::Node;

/// Nodes, and elements of a group, from which on it pays to wake other threads every increment.
pub(super) const PARALLEL: usize = 6000;
/// Nodes that a thread takes at once: fixed, so that sums do not depend on the number of threads.
const CHUNK: usize = 4096;

/// A motion of one degree of freedom of a node that is given, whatever forces act.
#[derive(Clone, Debug)]
pub struct Given {
    /// Node.
    pub node: usize,
    /// 0 along r, 1 along z.
    pub axis: usize,
    /// What is prescribed.
    pub kind: Prescribed,
    /// How much.
    pub magnitude: Magnitude,
}

impl Given {
    /// Whether it holds its degree of freedom where it is.
    fn holds(&self) -> bool {
        self.magnitude.value == 0.0 && self.kind != Prescribed::Acceleration
    }
}

/// A force on nodes.
pub trait NodeForce: Persist {
    /// Adds its forces, `[r, z]` of each node.
    ///
    /// # Errors
    /// Where no finite force can be given; the run halts.
    fn add(&mut self, now: &Instant, nodes: &[Node], forces: &mut [[f64; 2]]) -> Result<(), Halt>;

    /// Shows the accelerations of nodes at the instant before, where the force passes them on.
    fn see_accelerations(&mut self, _acceleration: &[[f64; 2]]) {}

    /// Of the work that its forces did over the increment behind what is dissipated: by opening a cavity and by friction.
    fn dissipated(&self, _behind: &Behind<'_>) -> [f64; 2] {
        [0.0; 2]
    }

    /// Elements with these corner nodes are no more: what acts on their faces ends.
    fn release(&mut self, _gone: &[[u32; 4]]) {}

    /// The masses of nodes have changed.
    fn weigh(&mut self, _mass: &[f64]) {}
}

/// The increment behind, for the work of forces.
#[derive(Clone, Copy, Debug)]
pub struct Behind<'a> {
    /// Half its length; 0 where there is none.
    pub half: f64,
    /// An eighth of its square, where central differences started with it (see [`Solid::advance`]); else 0.
    pub start: f64,
    /// Nodes with the velocities of its middle.
    pub nodes: &'a [Node],
    /// Accelerations at its start.
    pub acceleration: &'a [[f64; 2]],
}

impl Behind<'_> {
    /// Work on a node of a force now and at the start of the increment, by the trapezoid.
    pub fn work(&self, node: usize, now: [f64; 2], before: [f64; 2]) -> f64 {
        let (n, a) = (&self.nodes[node], self.acceleration[node]);
        self.half * ((now[0] + before[0]) * n.v_r + (now[1] + before[1]) * n.v_z)
            - self.start * (before[0] * a[0] + before[1] * a[1])
    }
}

/// Energies of the deformable part, summed over the run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energies {
    /// Kinetic, at the instant's own time: half v(i-1/2) m v(i+1/2), which central differences conserve exactly together
    /// with the strain energy of a linear body.
    pub kinetic: f64,
    /// Work of the stress.
    pub internal: f64,
    /// Plastic dissipation.
    pub plastic: f64,
    /// Work of the bulk viscosity.
    pub viscous: f64,
    /// Work of the hourglass control.
    pub artificial: f64,
    /// Work of distortion control.
    pub distortion: f64,
    /// Work of forces and prescribed motions.
    pub external: f64,
    /// Lost where nodes meet planes.
    pub contact: f64,
    /// Dissipated by friction, on planes and in a target that is not meshed.
    pub friction: f64,
    /// Dissipated by opening the cavity in a target that is not meshed.
    pub cavity: f64,
}

/// Corner slots that most nodes of a mesh of quadrilaterals have at most.
const SLOTS: usize = 4;

/// Which corner slots act on which node, in fixed order.
#[derive(Clone, Debug, Default)]
pub struct Gather {
    /// The first slots of each node, as places of the force along r in the blocks' corner forces (that along z is
    /// [`LANES`] behind); where it has fewer, one that holds zeros.
    slots: Vec<[u32; SLOTS]>,
    /// The slots of nodes that have more: node, slot.
    more: Vec<(u32, u32)>,
}

impl Gather {
    /// From the corner nodes of elements, group by group; each group begins a new block.
    pub fn new(count: usize, groups: &[&[[u32; 4]]]) -> Self {
        let blocks: usize = groups.iter().map(|g| g.len().div_ceil(LANES)).sum();
        let empty = (blocks * 8 * LANES) as u32;
        let mut gather = Gather { slots: vec![[empty; SLOTS]; count], more: Vec::new() };
        let mut block = 0;
        for elements in groups {
            for (e, corners) in elements.iter().enumerate() {
                for (c, &node) in corners.iter().enumerate() {
                    let slot = (((block + e / LANES) * 8 + 2 * c) * LANES + e % LANES) as u32;
                    match gather.slots[node as usize].iter_mut().find(|s| **s == empty) {
                        Some(free) => *free = slot,
                        None => gather.more.push((node, slot)),
                    }
                }
            }
            block += elements.len().div_ceil(LANES);
        }
        gather.more.sort_unstable();
        gather
    }

    /// Sum of the corner forces of one node.
    pub(crate) fn one(&self, node: usize, corners: &[Corners]) -> [f64; 2] {
        let mut force = [[0.0; 2]];
        self.sum(node, corners, &mut force);
        force[0]
    }

    /// Sums of the corner forces of nodes from `first` on.
    #[inline(always)]
    fn sum(&self, first: usize, corners: &[Corners], forces: &mut [[f64; 2]]) {
        let pair = |slot: u32| {
            let (block, at) = (slot as usize / (8 * LANES), slot as usize % (8 * LANES));
            let corner = corners[block].0.as_flattened();
            [corner[at], corner[at | LANES]]
        };
        let last = first + forces.len();
        for (force, slots) in forces.iter_mut().zip(&self.slots[first..last]) {
            let [a, b, c, d] = slots.map(pair);
            *force = [(a[0] + b[0]) + (c[0] + d[0]), (a[1] + b[1]) + (c[1] + d[1])];
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
}

/// Everything that deforms.
pub struct Solid {
    /// Nodes, in the order of the solver.
    pub nodes: Vec<Node>,
    /// Places at the start.
    pub start: Vec<[f64; 2]>,
    /// Lumped mass of each node.
    pub mass: Vec<f64>,
    /// Accelerations at the instant's own time.
    pub acceleration: Vec<[f64; 2]>,
    /// Groups of elements.
    pub groups: Vec<Box<dyn Group>>,
    /// What asked for the first group: where its time is booked.
    pub cause: EffectId,
    /// Names of the elements of each group, for messages.
    pub element_names: Vec<Vec<String>>,
    /// Energies so far.
    pub energies: Energies,
    /// What the last pass over the elements came to, and the group that limits the increment.
    pub limit: (Totals, usize),
    /// By how much that pass can have raised a frequency, where it is followed.
    pub(crate) deformed: f64,
    /// Estimate of the highest frequency of the whole; `None` where none is wanted or none can be made.
    pub frequency: Option<Box<HighestFrequency>>,
    /// Whether this step wants it.
    pub(crate) frequency_asked: bool,
    /// Rings of nodes under area weighting.
    pub rings: Option<Box<Rings>>,
    /// Nodes that move with rigid bodies.
    pub ties: Vec<Tie>,
    /// Springs and dashpots, and what they allow.
    pub(crate) connectors: Vec<Connector>,
    pub(crate) bounds: Bounds,
    /// Stiffness and damping of connectors at each node; empty without any.
    pub(crate) sums: Vec<[f64; 2]>,
    /// Elements under distortion control.
    pub(crate) distortion: Vec<Controlled>,
    /// Stable increment at the start, by which distortion control leads back.
    pub(crate) distortion_time: f64,
    /// Planes that nodes cannot pass, those of the step.
    pub walls: Vec<Wall>,
    /// Linear equations between degrees of freedom, those of the step.
    pub equations: Vec<System>,
    /// Masses without scaling; `None` unless the deck scales masses.
    pub(crate) masses: Option<Box<Masses>>,
    /// One over the mass; 0 where a rigid body carries the node.
    pub(crate) inverse_mass: Vec<f64>,
    pub(crate) corners: Vec<Corners>,
    pub(crate) gather: Gather,
    /// Forces on nodes now and an instant before; empty without any.
    pub(crate) external: [Vec<[f64; 2]>; 2],
    /// Forces against what is given, one entry a [`Given`].
    reactions: Vec<Reaction>,
    pub(crate) kinetic_parts: Vec<f64>,
    pub(super) awake: Awake,
    /// Whether nodes are worth spreading over threads.
    pub(crate) parallel: bool,
    /// Increment behind, and whether its strains are still to come.
    pub(crate) behind: f64,
    /// Time over which accelerations acted on the velocities last.
    pub(crate) half: f64,
    pub(crate) pending: bool,
    pub(crate) moved: bool,
    /// Corner nodes of deleted elements, and how many of them the forces of this step have been told.
    pub(crate) gone: (Vec<[u32; 4]>, usize),
}

/// What accelerations come from.
struct NodePass<'a> {
    gather: &'a Gather,
    corners: &'a [Corners],
    external: &'a [[f64; 2]],
    /// Factors on forces of elements; empty for none.
    rings: &'a [f64],
    nodes: &'a [Node],
    mass: &'a [f64],
    inverse_mass: &'a [f64],
    awake: &'a Awake,
    behind: f64,
}

impl NodePass<'_> {
    /// Accelerations of nodes from `first` on, and their kinetic energy. A few nodes at a time: first all their forces,
    /// then arithmetic that vectors can do.
    fn accelerate(&self, first: usize, accelerations: &mut [[f64; 2]]) -> f64 {
        let mut parts = [0.0; 4];
        let (mut forces, mut energies) = ([[0.0; 2]; FEW], [0.0; FEW]);
        for (i, accelerations) in accelerations.chunks_mut(FEW).enumerate() {
            let (first, count) = (first + i * FEW, accelerations.len());
            if !self.awake.has_work(first) {
                continue;
            }
            let forces = &mut forces[..count];
            self.gather.sum(first, self.corners, forces);
            if !self.rings.is_empty() {
                for (force, ring) in forces.iter_mut().zip(&self.rings[first..first + count]) {
                    *force = [ring * force[0], ring * force[1]];
                }
            }
            if !self.external.is_empty() {
                for (force, more) in forces.iter_mut().zip(&self.external[first..first + count]) {
                    *force = [force[0] + more[0], force[1] + more[1]];
                }
            }
            let masses = self.mass[first..first + count].iter().zip(&self.inverse_mass[first..first + count]);
            let nodes = self.nodes[first..first + count].iter().zip(masses);
            let all = accelerations.iter_mut().zip(&*forces).zip(nodes).zip(&mut energies);
            for (((acceleration, force), (node, (mass, inverse))), energy) in all {
                let [a_r, a_z] = force.map(|f| f * inverse);
                *acceleration = [a_r, a_z];
                let twice = node.v_r * (node.v_r + self.behind * a_r) + node.v_z * (node.v_z + self.behind * a_z);
                *energy = mass * twice;
            }
            energies[count..].fill(0.0);
            // Four sums side by side: one would wait for each addition.
            for four in energies.as_chunks::<4>().0 {
                for (part, energy) in parts.iter_mut().zip(four) {
                    *part += energy;
                }
            }
        }
        0.5 * ((parts[0] + parts[1]) + (parts[2] + parts[3]))
    }
}

#[derive(Clone, Copy, Debug, Default)]
struct Reaction {
    /// Node and axis.
    place: (usize, usize),
    /// Coordinate at the start of the step, from which a prescribed displacement counts.
    origin: f64,
    /// Force of elements and loads on the degree of freedom.
    force: f64,
    kinetic: f64,
    travel: f64,
}

impl Solid {
    /// Nodes at rest or moving, their masses, and elements.
    pub fn new(
        nodes: Vec<Node>,
        mass: Vec<f64>,
        groups: Vec<Box<dyn Group>>,
        element_names: Vec<Vec<String>>,
        gather: Gather,
    ) -> Self {
        let blocks: usize = groups.iter().map(|g| g.len().div_ceil(LANES)).sum();
        let count = nodes.len();
        // Room for all that may fail: nothing allocates inside an increment.
        let fragile = groups.iter().filter(|g| !g.is_empty() && g.status(0).is_some()).map(|g| g.len()).sum();
        Solid {
            start: nodes.iter().map(|n| [n.r, n.z]).collect(),
            inverse_mass: mass.iter().map(|&m| if m > 0.0 { 1.0 / m } else { 0.0 }).collect(),
            masses: None,
            deformed: 0.0,
            frequency: None,
            frequency_asked: false,
            rings: None,
            ties: Vec::new(),
            walls: Vec::new(),
            half: 0.0,
            connectors: Vec::new(),
            bounds: Bounds::default(),
            sums: Vec::new(),
            distortion: Vec::new(),
            distortion_time: 0.0,
            equations: Vec::new(),
            mass,
            acceleration: vec![[0.0; 2]; count],
            awake: Awake::new(count, &groups),
            groups,
            cause: 0,
            element_names,
            energies: Energies::default(),
            limit: (Totals::default(), 0),
            // One block more, which stays zero.
            corners: vec![Corners::default(); blocks + 1],
            gather,
            external: [Vec::new(), Vec::new()],
            reactions: Vec::new(),
            kinetic_parts: vec![0.0; count.div_ceil(CHUNK)],
            parallel: count >= PARALLEL && rayon::current_num_threads() > 1,
            behind: 0.0,
            pending: true,
            moved: false,
            gone: (Vec::with_capacity(fragile), 0),
            nodes,
        }
    }

    /// Begins a step with its forces and given motions.
    pub fn begin(&mut self, given: &[Given], forces: usize) {
        let reaction = |g: &Given| {
            let origin = self.place(g.node)[g.axis];
            Reaction { place: (g.node, g.axis), origin, ..Reaction::default() }
        };
        self.reactions = given.iter().map(reaction).collect();
        // These move nodes, or change their accelerations, behind the passes over nodes.
        if !(self.ties.is_empty() && self.walls.is_empty() && self.equations.is_empty()) {
            self.awake.wake();
        }
        self.gone.1 = 0;
        let pushed = forces > 0 || !self.connectors.is_empty() || !self.distortion.is_empty();
        let count = if pushed { self.nodes.len() } else { 0 };
        for list in &mut self.external {
            list.resize(count, [0.0; 2]);
        }
        // A node that is held does not start with a velocity.
        let first = self.behind == 0.0;
        for g in given.iter().filter(|g| first && g.holds()) {
            self.set_velocity(g, 0.0);
        }
        if first {
            self.constrain_velocities(0.0, 0.0);
        }
    }

    fn set_velocity(&mut self, given: &Given, value: f64) {
        let node = &mut self.nodes[given.node];
        *(if given.axis == 0 { &mut node.v_r } else { &mut node.v_z }) = value;
    }

    fn velocity(&self, given: &Given) -> f64 {
        let node = &self.nodes[given.node];
        if given.axis == 0 { node.v_r } else { node.v_z }
    }

    /// Stresses, corner forces and forces on nodes at this instant.
    ///
    /// # Errors
    /// From a force that fails, and where an element has no positive volume or a state that is not finite.
    pub fn evaluate(&mut self, now: &Instant, forces: &mut [Box<dyn NodeForce>]) -> Result<(), Halt> {
        if self.pending {
            self.update_elements(now);
            self.measure_rings();
            self.bound_frequency();
            self.pending = false;
        }
        let [external, before] = &mut self.external;
        std::mem::swap(external, before);
        external.fill([0.0; 2]);
        if self.gone.1 < self.gone.0.len() {
            forces.iter_mut().for_each(|force| force.release(&self.gone.0[self.gone.1..]));
            self.gone.1 = self.gone.0.len();
        }
        let dt = if self.moved { self.behind } else { 0.0 };
        let start = if self.half == 0.5 * dt { 0.125 * dt * dt } else { 0.0 };
        let behind = Behind { half: 0.5 * dt, start, nodes: &self.nodes, acceleration: &self.acceleration };
        for force in forces {
            force.see_accelerations(&self.acceleration);
            force.add(now, &self.nodes, external)?;
            let [cavity, friction] = force.dissipated(&behind);
            self.energies.cavity += cavity;
            self.energies.friction += friction;
            self.energies.external += cavity + friction;
        }
        self.add_connectors();
        self.resist_distortion();
        self.awake.update(&self.groups, &self.external[0]);
        if self.limit.0.rate.is_finite() {
            return Ok(());
        }
        Err(self.not_finite(now))
    }

    fn update_elements(&mut self, now: &Instant) {
        let mut first = 0;
        self.limit = (Totals::default(), 0);
        self.deformed = 0.0;
        for (i, group) in self.groups.iter_mut().enumerate() {
            let blocks = group.len().div_ceil(LANES);
            group.tell(now);
            let totals = group.update(&self.nodes, self.behind, &mut self.corners[first..first + blocks]);
            first += blocks;
            group.deleted(&mut self.gone.0);
            self.deformed = self.deformed.max(totals.deformed);
            self.energies.internal += totals.internal;
            self.energies.plastic += totals.plastic;
            self.energies.viscous += totals.viscous;
            self.energies.artificial += totals.artificial;
            if is_larger(totals.rate, self.limit.0.rate) {
                self.limit = (totals, i);
            }
        }
    }

    fn not_finite(&self, now: &Instant) -> Halt {
        let (totals, group) = self.limit;
        if let Some(halt) = self.groups[group].failure() {
            return halt;
        }
        let element = &self.element_names[group][totals.limiting];
        let volume = self.groups[group].volume(totals.limiting, &self.nodes);
        let why = if volume > 0.0 { "its state is not finite" } else { "it has turned inside out" };
        let reason = format!(
            "element {element} failed at increment {}, time {:e}: {why} (volume {volume:e})",
            now.increment, now.total_time
        );
        Halt { code: "R206", reason }
    }

    /// Accelerations from forces; what is given overrides them.
    pub fn accelerate(&mut self, given: &[Given]) {
        let pass = NodePass {
            gather: &self.gather,
            corners: &self.corners,
            external: &self.external[0],
            rings: self.rings.as_ref().map_or(&[], |r| &r.factors),
            nodes: &self.nodes,
            mass: &self.mass,
            inverse_mass: &self.inverse_mass,
            awake: &self.awake,
            behind: self.behind,
        };
        let chunk = |index: usize, accelerations: &mut [[f64; 2]], kinetic: &mut f64| {
            *kinetic = pass.accelerate(index * CHUNK, accelerations);
        };
        if !self.parallel {
            let parts = self.acceleration.chunks_mut(CHUNK).zip(&mut self.kinetic_parts).enumerate();
            parts.for_each(|(i, (a, k))| chunk(i, a, k));
        } else {
            let parts = self.acceleration.par_chunks_mut(CHUNK).zip(&mut self.kinetic_parts).enumerate();
            parts.for_each(|(i, (a, k))| chunk(i, a, k));
        }
        self.energies.kinetic = self.kinetic_parts.iter().sum();
        self.account(given);
        self.constrain_accelerations();
    }

    /// Books the work of forces and given motions over the increment behind, and replaces accelerations that are given.
    fn account(&mut self, given: &[Given]) {
        if self.moved {
            let half = 0.5 * self.behind;
            let [now, before] = &self.external;
            for ((f, g), node) in now.iter().zip(before).zip(&self.nodes) {
                self.energies.external += half * ((f[0] + g[0]) * node.v_r + (f[1] + g[1]) * node.v_z);
            }
        }
        for (i, g) in given.iter().enumerate() {
            let mass = self.mass[g.node];
            let (velocity, free) = (self.velocity(g), self.acceleration[g.node][g.axis]);
            // The pass over nodes took the free acceleration: what is given moves otherwise.
            let taken = 0.5 * mass * velocity * (velocity + self.behind * free);
            let kinetic = 0.5 * mass * velocity * velocity;
            self.energies.kinetic += kinetic - taken;
            let reaction = &mut self.reactions[i];
            let force = mass * free;
            if self.moved {
                let gained = kinetic - reaction.kinetic;
                self.energies.external += gained - 0.5 * (reaction.force + force) * reaction.travel;
            }
            *reaction = Reaction { force, kinetic, travel: 0.0, ..*reaction };
            self.acceleration[g.node][g.axis] = 0.0;
        }
        self.moved = false;
    }

    /// Where central differences start, forces act for half an increment alone and bring velocities from v to v + dt/2 a.
    /// What they give in that half is their impulse times the mean of both, v + dt/4 a, while the trapezoid over the whole
    /// increment reckons with the velocity at its end: too much by f a dt^2/8.
    fn book_start(&mut self, dt: f64) {
        let forces = self.external[0].iter().zip(&self.acceleration);
        let power: f64 = forces.map(|(f, a)| f[0] * a[0] + f[1] * a[1]).sum();
        self.energies.external -= 0.125 * dt * dt * power;
    }

    /// Carries all nodes over an increment. The first one starts central differences with half of it.
    pub fn advance(&mut self, given: &[Given], now: &Instant, dt: f64) {
        if self.behind == 0.0 {
            self.book_start(dt);
        }
        let half = 0.5 * (dt + self.behind);
        let awake = &self.awake;
        let chunk = |(index, (nodes, accelerations)): (usize, (&mut [Node], &[[f64; 2]]))| {
            for (i, (nodes, accelerations)) in nodes.chunks_mut(FEW).zip(accelerations.chunks(FEW)).enumerate() {
                if !awake.has_work(index * CHUNK + i * FEW) {
                    continue;
                }
                for (node, a) in nodes.iter_mut().zip(accelerations) {
                    node.v_r += half * a[0];
                    node.v_z += half * a[1];
                    node.r += dt * node.v_r;
                    node.z += dt * node.v_z;
                }
            }
        };
        if !self.parallel {
            self.nodes.chunks_mut(CHUNK).zip(self.acceleration.chunks(CHUNK)).enumerate().for_each(chunk);
        } else {
            self.nodes.par_chunks_mut(CHUNK).zip(self.acceleration.par_chunks(CHUNK)).enumerate().for_each(chunk);
        }
        for (i, g) in given.iter().enumerate() {
            let old = self.velocity(g);
            if old == 0.0 && g.holds() {
                continue;
            }
            let place = |node: &Node| if g.axis == 0 { node.r } else { node.z };
            // The pass above carried it along with its old velocity.
            let place_before = place(&self.nodes[g.node]) - dt * old;
            let moved = place_before - self.reactions[i].origin;
            let velocity = g.kind.velocity_over(&g.magnitude, now, dt, moved, [old, half]);
            self.set_velocity(g, velocity);
            let node = &mut self.nodes[g.node];
            *(if g.axis == 0 { &mut node.r } else { &mut node.z }) = place_before + dt * velocity;
            self.acceleration[g.node][g.axis] = (velocity - old) / half;
            self.reactions[i].travel = dt * velocity;
        }
        self.constrain_velocities(dt, half);
        (self.behind, self.half) = (dt, half);
        self.pending = true;
        self.moved = true;
    }

    /// Gives a node another mass at its velocity. The kinetic energy that comes with it is work from outside: with
    /// half v(i-1/2) m v(i+1/2) it is exactly half the added mass times v(i-1/2)^2.
    pub(super) fn change_mass(&mut self, n: usize, mass: f64) {
        let (added, node) = (mass - self.mass[n], &self.nodes[n]);
        if added == 0.0 {
            return;
        }
        let by_axis = [0.5 * added * node.v_r * node.v_r, 0.5 * added * node.v_z * node.v_z];
        self.energies.external += by_axis[0] + by_axis[1];
        // What is given books gains of kinetic energy as its own work: not these.
        for reaction in self.reactions.iter_mut().filter(|r| r.place.0 == n) {
            reaction.kinetic += by_axis[reaction.place.1];
        }
        self.mass[n] = mass;
        self.inverse_mass[n] = 1.0 / mass;
    }

    /// Lets an element limit the increment, until elements are updated next.
    pub(super) fn raise_limit(&mut self, group: usize, element: usize, rate: f64) {
        if rate > self.limit.0.rate {
            (self.limit.0.rate, self.limit.0.limiting, self.limit.1) = (rate, element, group);
        }
    }

    /// Velocity of a node at the instant's own time.
    pub fn velocity_now(&self, node: usize) -> [f64; 2] {
        let (n, a) = (&self.nodes[node], self.acceleration[node]);
        [n.v_r + 0.5 * self.behind * a[0], n.v_z + 0.5 * self.behind * a[1]]
    }

    /// Displacement of a node.
    pub fn displacement(&self, node: usize) -> [f64; 2] {
        [self.nodes[node].r - self.start[node][0], self.nodes[node].z - self.start[node][1]]
    }

    /// Place of a node now.
    pub fn place(&self, node: usize) -> [f64; 2] {
        [self.nodes[node].r, self.nodes[node].z]
    }

    /// Force that what is given exerts on a degree of freedom of a node; 0 where nothing is given.
    pub fn reaction(&self, node: usize, axis: usize) -> f64 {
        let inertia = self.mass[node] * self.acceleration[node][axis];
        let own = self.reactions.iter().filter(|r| r.place == (node, axis));
        own.map(|r| inertia - r.force - self.pull(node, axis)).sum()
    }

    /// Group and element that limit the increment.
    pub fn limiting(&self) -> (usize, usize) {
        (self.limit.1, self.limit.0.limiting)
    }

    /// The largest increment that is stable.
    pub fn stable_increment(&self) -> f64 {
        let elements = self.limit.0.rate;
        1.0 / if self.connectors.is_empty() { elements } else { self.bounds.rate(elements) }
    }
}

impl Persist for Energies {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Energies {
            kinetic,
            internal,
            plastic,
            viscous,
            artificial,
            external,
            contact,
            friction,
            cavity,
            distortion,
        } = self;
        persist_fields!(archive; kinetic, internal, plastic, viscous, artificial, external, contact, friction);
        persist_fields!(archive; cavity, distortion);
    }
}

impl Persist for Reaction {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Reaction { place: _, origin, force, kinetic, travel } = self;
        persist_fields!(archive; origin, force, kinetic, travel);
    }
}

impl Persist for Solid {
    /// In a step that has begun: what the step gives has its length.
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Solid {
            nodes,
            start: _,
            mass,
            acceleration,
            groups,
            cause: _,
            element_names: _,
            energies,
            limit,
            distortion,
            distortion_time,
            deformed: _,
            frequency,
            frequency_asked,
            rings,
            ties: _,
            connectors,
            bounds,
            sums: _,
            walls,
            equations,
            masses,
            inverse_mass,
            corners,
            gather: _,
            external,
            reactions,
            kinetic_parts: _,
            awake,
            parallel: _,
            behind,
            half,
            pending,
            moved,
            gone,
        } = self;
        archive.mark("nodes");
        persist_fields!(archive; nodes.as_mut_slice(), mass.as_mut_slice(), inverse_mass.as_mut_slice());
        persist_fields!(archive; acceleration.as_mut_slice(), energies, limit, awake, behind, half, pending, moved);
        archive.mark("links");
        persist_fields!(archive; connectors.as_mut_slice(), bounds, walls.as_mut_slice(), equations.as_mut_slice());
        // The forces of the instant before are written over.
        persist_fields!(archive; external[0].as_mut_slice(), reactions.as_mut_slice(), gone);
        if let Some(masses) = masses {
            masses.persist(archive);
        }
        persist_fields!(archive; distortion.as_mut_slice(), distortion_time, frequency_asked);
        if let Some(frequency) = frequency {
            frequency.persist(archive);
        }
        if let Some(rings) = rings {
            rings.persist(archive);
        }
        archive.mark("elements");
        persist_all(groups, archive);
        // Of elements that sleep they are zero, but zeros have signs, which reach the accelerations.
        corners.as_mut_slice().persist(archive);
    }
}
