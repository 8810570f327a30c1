//! The degrees of freedom of a contact: their motion without contact, the impulses on them, and the rigid bodies and merged
//! nodes that take part.

use std::collections::HashMap;

use super::curve::{PointCarrier, SurfacePoint};
use super::sweeps::{ContactRows, ContactVelocities, NONE};
use super::written::WrittenEntries;
use crate::constraint::bonds::MergedDofs;
use crate::constraint::system::change_velocity;
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::Memory;
use crate::state::BodyState;
use crate::state::archive::Persist;
use crate::state::dofs::{Dof, Dofs};
use crate::state::energies::EnergyTotals;
use crate::state::nodes::Nodes;

/// Degrees of freedom of the points of a contact.
#[derive(Clone, Debug, Default, Persist, Memory)]
#[persist(fixed: impulses, bodies; derived: of_points, list, prescribed_nodes, merged, motion, written_impulses, means)]
pub(super) struct ContactDofs {
    /// Degrees of freedom of each point along r and z; [`NONE`] where it has none.
    pub(super) of_points: Vec<[u32; 2]>,
    /// The degrees of freedom of the points, and whether their motion is prescribed.
    pub(super) list: Vec<(Dof, bool)>,
    /// Nodes, axes and indices of the prescribed degrees of freedom of nodes, ascending.
    prescribed_nodes: Vec<([usize; 2], u32)>,
    /// Degrees of freedom of several nodes with equal motion.
    pub(super) merged: Vec<MergedContactDof>,
    pub(super) motion: ContactVelocities,
    /// Impulses on degrees of freedom along the normal and along the surface.
    pub(super) impulses: Vec<[f64; 2]>,
    written_impulses: WrittenEntries,
    /// Mean velocity of each degree of freedom near another surface during the impulses of the increment.
    pub(super) means: Vec<f64>,
    pub(super) bodies: Vec<ContactBody>,
    /// Time over which forces last acted on velocities.
    pub(super) half: f64,
    previous_dt: f64,
    /// Share of the forces in output. It is 1/2 in the first increment, in which forces act over half of the increment,
    /// so that the integral of forces over time is the change of momentum.
    pub(super) output_share: f64,
}

/// A degree of freedom of nodes with equal motion, such as the nodes of a kinematic coupling. It moves with their total
/// mass.
#[derive(Clone, Debug, Memory)]
pub(super) struct MergedContactDof {
    /// Index of the degree of freedom.
    pub(super) dof: usize,
    pub(super) nodes: MergedDofs,
}

impl MergedContactDof {
    /// Returns one over the total mass.
    fn inverse_mass(&self, dofs: &Dofs) -> f64 {
        1.0 / self.nodes.nodes.iter().map(|&n| dofs.nodes.mass[n]).sum::<f64>()
    }
}

/// A rigid body that takes part in the contact.
#[derive(Clone, Copy, Debug, Persist)]
#[persist(derived: dof, body, prescribed)]
pub(super) struct ContactBody {
    /// Index of the body's degree of freedom.
    pub(super) dof: usize,
    pub(super) body: usize,
    pub(super) prescribed: bool,
    /// Acceleration by contact in the previous increment; only of a free body.
    pub(super) contact_acceleration: f64,
}

impl ContactDofs {
    /// Numbers the degrees of freedom of the points.
    pub(super) fn new(points: &[SurfacePoint]) -> ContactDofs {
        let mut list: Vec<(Dof, bool)> = Vec::new();
        let number = |point: &SurfacePoint| match point.carrier {
            PointCarrier::Node(n) => {
                list.extend([0, 1].inline_map(|axis| (Dof::Node(n, axis), !point.free[axis])));
                [list.len() as u32 - 2, list.len() as u32 - 1]
            }
            PointCarrier::Body(b, _) => {
                let known = list.iter().position(|d| d.0 == Dof::Body(b));
                let index = known.unwrap_or_else(|| {
                    list.push((Dof::Body(b), false));
                    list.len() - 1
                });
                [NONE, index as u32]
            }
        };
        let of_points = points.iter().map(number).collect();
        let count = list.len();
        ContactDofs {
            prescribed_nodes: prescribed_nodes(&list),
            of_points,
            list,
            means: vec![0.0; count],
            motion: ContactVelocities { velocity: vec![0.0; count], inverse_mass: vec![0.0; count] },
            impulses: vec![[0.0; 2]; count],
            ..ContactDofs::default()
        }
    }

    pub(super) fn count(&self) -> usize {
        self.list.len()
    }

    /// Returns the index of a degree of freedom whose motion is prescribed; `None` if it does not take part in contact.
    pub(super) fn index_of_prescribed(&self, dof: Dof) -> Option<usize> {
        match dof {
            Dof::Body(_) => self
                .bodies
                .iter()
                .find(|known| known.prescribed && self.list[known.dof].0 == dof)
                .map(|known| known.dof),
            Dof::Node(node, axis) => {
                let from = self.prescribed_nodes.partition_point(|known| known.0 < [node, axis]);
                self.prescribed_nodes.get(from).filter(|known| known.0 == [node, axis]).map(|known| known.1 as usize)
            }
        }
    }

    /// Gives the points of each set of nodes with equal motion one common degree of freedom.
    pub(super) fn merge(&mut self, sets: Vec<MergedDofs>, points: &[SurfacePoint]) {
        let mut set_of_node: HashMap<(usize, usize), usize> = HashMap::new();
        for (set, merged) in sets.iter().enumerate() {
            set_of_node.extend(merged.nodes.iter().map(|&n| ((n, merged.axis), set)));
        }
        let mut dof_of_set = vec![NONE; sets.len()];
        for (dofs, point) in self.of_points.iter_mut().zip(points) {
            let PointCarrier::Node(node) = point.carrier else { continue };
            for (axis, dof) in dofs.iter_mut().enumerate() {
                let Some(&set) = set_of_node.get(&(node, axis)) else { continue };
                if dof_of_set[set] == NONE {
                    dof_of_set[set] = *dof;
                    self.list[*dof as usize].0 = Dof::Node(sets[set].nodes[0], axis);
                }
                *dof = dof_of_set[set];
            }
        }
        self.prescribed_nodes = prescribed_nodes(&self.list);
        let used = sets.into_iter().zip(dof_of_set).filter(|(_, dof)| *dof != NONE);
        self.merged = used.map(|(nodes, dof)| MergedContactDof { dof: dof as usize, nodes }).collect();
    }

    /// Returns for each point the first one with the same motion, for example of the nodes that a tie joins; empty if no
    /// points move alike.
    pub(super) fn points_that_move_alike(&self) -> Vec<u32> {
        if self.merged.is_empty() {
            return Vec::new();
        }
        // Nodes on the axis have different degrees of freedom along r, whose motions are prescribed.
        let along_r = |dof: u32| self.list.get(dof as usize).filter(|(_, is_prescribed)| !is_prescribed).map(|_| dof);
        let mut first: HashMap<(Option<u32>, u32), u32> = HashMap::new();
        let points = self.of_points.iter().zip(0..);
        points.map(|([r, z], point)| *first.entry((along_r(*r), *z)).or_insert(point)).collect()
    }

    /// Begins a step: lists the rigid bodies and passes the free ones to `rows`.
    pub(super) fn begin(&mut self, rows: &mut ContactRows, dofs: &mut Dofs) {
        let known_bodies = std::mem::take(&mut self.bodies);
        rows.bodies.clear();
        for (i, (dof, prescribed)) in self.list.iter_mut().enumerate() {
            if let Dof::Body(body) = *dof {
                *prescribed = dofs.bodies[body].prescribed;
                let known = known_bodies.iter().find(|known| known.body == body && !*prescribed);
                let contact_acceleration = known.map_or(0.0, |known| known.contact_acceleration);
                dofs.bodies[body].contact += contact_acceleration;
                self.bodies.push(ContactBody { dof: i, body, prescribed: *prescribed, contact_acceleration });
                rows.bodies.extend((!*prescribed).then_some(i as u32));
            }
        }
        let free = self.merged.iter().filter(|merged| !self.list[merged.dof].1);
        rows.bodies.extend(free.map(|merged| merged.dof as u32));
    }

    /// Takes impulses and bodies from the previous contact.
    pub(super) fn take_over(&mut self, previous: &ContactDofs) {
        (self.half, self.output_share) = (previous.half, previous.output_share);
        self.previous_dt = previous.previous_dt;
        self.bodies.clone_from(&previous.bodies);
        let mut impulses = std::mem::take(&mut self.impulses);
        self.pass_values(&mut impulses, previous, &previous.impulses);
        self.impulses = impulses;
        self.written_impulses.forget();
    }

    /// Notes that impulses have been read from a file.
    pub(super) fn forget_written(&mut self) {
        self.written_impulses.forget();
    }

    /// Allocates the list of written impulses.
    pub(super) fn reserve(&mut self) {
        self.written_impulses.reserve(2 * self.list.len());
    }

    /// Sets the values of degrees of freedom to those of the same ones of the previous contact, and the others to zero.
    pub(super) fn pass_values<T: Copy + Default>(
        &self,
        values: &mut [T],
        previous: &ContactDofs,
        previous_values: &[T],
    ) {
        let known: HashMap<Dof, T> = previous.list.iter().map(|d| d.0).zip(previous_values.iter().copied()).collect();
        for ((dof, _), value) in self.list.iter().zip(values) {
            *value = known.get(dof).copied().unwrap_or_default();
        }
    }

    /// Sets the time over which forces act on velocities in an increment of length `dt`: that of the nodes, if there are
    /// any. On a new mesh the velocities contain the impulses of half an increment before.
    pub(super) fn begin_increment(&mut self, nodes: &Nodes, dt: f64) {
        let of_bodies = 0.5 * (dt + std::mem::replace(&mut self.previous_dt, dt));
        let half = if nodes.is_empty() { of_bodies } else { nodes.half };
        let is_first = std::mem::replace(&mut self.half, half) == 0.0;
        self.output_share = if is_first && self.half == 0.5 * dt { 0.5 } else { 1.0 };
    }

    /// Reads velocities without contact and inverse masses of a point.
    #[inline]
    pub(super) fn read_point(&mut self, point: usize, carrier: PointCarrier, dofs: &Dofs) {
        let [r, z] = self.of_points[point];
        let ContactVelocities { velocity, inverse_mass } = &mut self.motion;
        match carrier {
            PointCarrier::Node(n) => {
                let (node, free) = (&dofs.nodes[n], dofs.nodes.inverse_mass[n]);
                for (dof, v) in [(r as usize, node.v_r), (z as usize, node.v_z)] {
                    velocity[dof] = v;
                    inverse_mass[dof] = if self.list[dof].1 { 0.0 } else { free };
                }
            }
            PointCarrier::Body(b, _) => {
                velocity[z as usize] = dofs.bodies[b].velocity_half;
                inverse_mass[z as usize] = if self.list[z as usize].1 { 0.0 } else { dofs.bodies[b].inverse_mass };
            }
        }
    }

    pub(super) fn read_merged(&mut self, dofs: &Dofs) {
        for merged in &self.merged {
            let leader = &dofs.nodes[merged.nodes.nodes[0]];
            self.motion.velocity[merged.dof] = [leader.v_r, leader.v_z][merged.nodes.axis];
            self.motion.inverse_mass[merged.dof] =
                if self.list[merged.dof].1 { 0.0 } else { merged.inverse_mass(dofs) };
        }
    }

    /// Returns the squared part of a normal along free degrees of freedom of a point.
    pub(super) fn free_share(&self, [r, z]: [u32; 2], normal: [f64; 2]) -> f64 {
        let share = |dof: u32, n: f64| if dof == NONE || self.list[dof as usize].1 { 0.0 } else { n * n };
        share(r, normal[0]) + share(z, normal[1])
    }

    /// Sums the impulses of rows on degrees of freedom.
    pub(super) fn gather_impulses(&mut self, rows: &ContactRows) {
        self.written_impulses.reset(&mut self.impulses, [0.0; 2]);
        for row in rows.rows.iter().filter(|row| row.acts()) {
            for term in rows.terms_of(row) {
                if self.impulses[term.dof as usize] == [0.0; 2] {
                    self.written_impulses.add(term.dof);
                }
                let [normal, slip] = &mut self.impulses[term.dof as usize];
                *normal += term.normal * row.normal_impulse;
                *slip += term.slip * row.whole_shear();
            }
        }
    }

    /// Applies the impulses to velocities and positions, and returns their work. `near` are the degrees of freedom near
    /// another surface.
    pub(super) fn apply_impulses(&mut self, near: &[u32], dofs: &mut Dofs, dt: f64) -> ImpulseWork {
        let half = self.half;
        let Dofs { bodies, nodes, energies, .. } = dofs;
        let mut work = ImpulseWork::default();
        for i in near.iter().map(|i| *i as usize) {
            let ((dof, prescribed), impulse) = (self.list[i], self.impulses[i]);
            if impulse == [0.0; 2] {
                self.means[i] = 0.0;
                continue;
            }
            let change = self.motion.inverse_mass[i] * (impulse[0] + impulse[1]);
            let mean = match dof {
                Dof::Node(n, axis) => {
                    let predicted = *nodes[n].velocity(axis);
                    let previous = predicted - half * nodes.acceleration[n][axis];
                    change_velocity(nodes, (n, axis), change, dt, half);
                    0.5 * (previous + (predicted + change))
                }
                Dof::Body(b) => push_body(&mut bodies[b], change, [half, dt], energies),
            };
            self.means[i] = mean;
            work.add(impulse, mean, prescribed, energies);
        }
        for MergedContactDof { dof, nodes: MergedDofs { nodes: members, axis } } in &self.merged {
            let change = self.motion.inverse_mass[*dof] * (self.impulses[*dof][0] + self.impulses[*dof][1]);
            members[1..].iter().for_each(|&n| change_velocity(nodes, (n, *axis), change, dt, half));
        }
        work
    }

    /// Adds impulses of pressure and of friction on the rigid body of a point, and applies them to its motion. Returns
    /// their work.
    pub(super) fn add_impulse(&mut self, point: u32, added: [f64; 2], dofs: &mut Dofs, dt: f64) -> [f64; 2] {
        let dof = self.of_points[point as usize][1];
        let ((Dof::Body(body), prescribed), true) = (self.list[dof as usize], added != [0.0; 2]) else {
            return [0.0; 2];
        };
        self.written_impulses.add(dof);
        let impulse = &mut self.impulses[dof as usize];
        *impulse = [0, 1].inline_map(|part: usize| impulse[part] + added[part]);
        let Dofs { bodies, energies, .. } = dofs;
        let inverse_mass = if prescribed { 0.0 } else { bodies[body].inverse_mass };
        let mean = push_body(&mut bodies[body], inverse_mass * (added[0] + added[1]), [self.half, dt], energies);
        let mut work = ImpulseWork::default();
        work.add(added, mean, prescribed, energies);
        work.of_impulses
    }

    /// Replaces the contact acceleration of free bodies with that of this increment; `other` returns an additional impulse
    /// on a degree of freedom.
    pub(super) fn push_bodies(&mut self, dofs: &mut Dofs, other: impl Fn(usize) -> f64) {
        for known in self.bodies.iter_mut().filter(|known| !known.prescribed) {
            let body = &mut dofs.bodies[known.body];
            body.contact -= known.contact_acceleration;
            let [normal, slip] = self.impulses[known.dof];
            known.contact_acceleration = (normal + slip + other(known.dof)) * body.inverse_mass / self.half;
            body.contact += known.contact_acceleration;
        }
    }

    /// Changes the velocity of a degree of freedom at the current instant. Returns the previous one.
    pub(super) fn complete_velocity(&self, index: usize, change: f64, dofs: &mut Dofs) -> f64 {
        match self.list[index].0 {
            Dof::Node(n, axis) => {
                let previous = dofs.nodes.velocity_now(n)[axis];
                *dofs.nodes[n].velocity(axis) += change;
                previous
            }
            Dof::Body(b) => {
                dofs.bodies[b].velocity += change;
                dofs.bodies[b].velocity - change
            }
        }
    }

    /// Adds a part of the impulses to the velocities at mid-increment, and returns its work at the current instant.
    pub(super) fn complete_velocities(&mut self, near: &[u32], part: f64, dofs: &mut Dofs) -> ImpulseWork {
        let mut work = ImpulseWork::default();
        for i in near.iter().map(|i| *i as usize) {
            let impulse = self.impulses[i].inline_map(|j| part * j);
            let change = self.motion.inverse_mass[i] * (impulse[0] + impulse[1]);
            let mean = self.complete_velocity(i, change, dofs) + 0.5 * change;
            self.means[i] = mean;
            work.add(impulse, mean, self.list[i].1, &mut dofs.energies);
        }
        let nodes = &mut dofs.nodes;
        for MergedContactDof { dof, nodes: MergedDofs { nodes: members, axis } } in &self.merged {
            let change = part * self.motion.inverse_mass[*dof] * (self.impulses[*dof][0] + self.impulses[*dof][1]);
            members[1..].iter().for_each(|n| *nodes[*n].velocity(*axis) += change);
        }
        work
    }

    /// Changes the velocity of a degree of freedom over an increment of length `dt`, and of all nodes with the same motion.
    pub(super) fn change_velocity(&self, index: usize, change: f64, dofs: &mut Dofs, dt: f64) {
        let half = self.half;
        match self.list[index].0 {
            Dof::Node(n, axis) => change_velocity(&mut dofs.nodes, (n, axis), change, dt, half),
            Dof::Body(body) => {
                dofs.bodies[body].velocity_half += change;
                dofs.bodies[body].displacement += dt * change;
            }
        }
        for MergedContactDof { nodes, .. } in self.merged.iter().filter(|merged| merged.dof == index) {
            let members = nodes.nodes[1..].iter();
            members.for_each(|&n| change_velocity(&mut dofs.nodes, (n, nodes.axis), change, dt, half));
        }
    }
}

/// Changes the velocity of a rigid body by impulses, and its displacement over an increment of length `dt`; `half` is the
/// time over which forces act. Returns the mean of the velocities before and after forces and impulses.
fn push_body(body: &mut BodyState, change: f64, [half, dt]: [f64; 2], energies: &mut EnergyTotals) -> f64 {
    let previous = body.before.velocity - (half - 0.5 * dt) * body.acceleration;
    let so_far = body.velocity_half - previous - half * body.acceleration;
    body.velocity_half += change;
    body.displacement += dt * change;
    // Impulses of other contacts in this increment also act during the change of velocity.
    energies.contact -= 0.5 * body.mass * so_far * change;
    0.5 * (previous + body.velocity_half)
}

/// Work of impulses: the impulse times the mean of the velocities before and after it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ImpulseWork {
    /// Work along the normal and along the surface.
    pub(super) of_impulses: [f64; 2],
    /// Work on free degrees of freedom.
    pub(super) on_free_dofs: f64,
}

impl ImpulseWork {
    /// Adds that of an impulse on a degree of freedom. The work on a prescribed motion is external work.
    fn add(&mut self, [normal, slip]: [f64; 2], mean: f64, prescribed: bool, energies: &mut EnergyTotals) {
        if prescribed {
            energies.external -= (normal + slip) * mean;
        } else {
            self.on_free_dofs += (normal + slip) * mean;
        }
        self.of_impulses[0] += normal * mean;
        self.of_impulses[1] += slip * mean;
    }
}

/// Returns nodes, axes and indices of the prescribed degrees of freedom of nodes, ascending.
fn prescribed_nodes(list: &[(Dof, bool)]) -> Vec<([usize; 2], u32)> {
    let prescribed = |(index, (dof, prescribed)): (u32, &(Dof, bool))| match *dof {
        Dof::Node(node, axis) if *prescribed => Some(([node, axis], index)),
        _ => None,
    };
    let mut nodes: Vec<_> = (0..).zip(list).filter_map(prescribed).collect();
    nodes.sort_unstable();
    nodes
}
