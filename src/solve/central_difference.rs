//! Central differences: accelerations from forces, velocities half an increment on, displacements (ABAQUS Theory Guide 2.4.5)
//! of all degrees of freedom, those of rigid bodies and those of nodes.
//! Never here: which forces act, what constrains the motion, the length of an increment.

use rayon::prelude::*;

use crate::element::elements::Elements;
use crate::element::quiescent::FEW;
use crate::state::BodyState;
use crate::state::dofs::Dofs;
use crate::state::nodes::{Node, Nodes};

/// Nodes from which on it pays to wake other threads every increment.
const PARALLEL: usize = 6000;
/// Nodes that a thread takes at once: fixed, so that sums do not depend on the number of threads.
const CHUNK: usize = 4096;

/// Accelerations of bodies from their forces; those of prescribed ones are still to be replaced.
#[inline]
pub(super) fn accelerate_body(body: &mut BodyState) {
    body.before.acceleration = body.acceleration;
    body.acceleration = body.force * body.inverse_mass;
}

/// Velocities of bodies at the instant's own time, an increment `behind` after the last.
#[inline]
pub(super) fn velocities_from_half(bodies: &mut [BodyState], behind: f64) {
    let half = 0.5 * behind;
    for body in bodies {
        body.velocity = body.velocity_half + half * body.acceleration;
    }
}

/// Carries bodies over an increment.
#[inline]
pub(super) fn advance_bodies(bodies: &mut [BodyState], dt: f64) {
    for body in bodies {
        body.before.displacement = body.displacement;
        body.before.velocity = body.velocity;
        body.velocity_half = body.velocity + 0.5 * dt * body.acceleration;
        body.displacement += dt * body.velocity_half;
    }
}

/// Accelerations of nodes from their forces, their kinetic energy, and the work of forces over the increment behind. `parts` is
/// room for the energies of chunks.
pub(super) fn accelerate_nodes(elements: &Elements, dofs: &mut Dofs, parts: &mut [f64], threads: bool) {
    let Dofs { nodes, energies, .. } = dofs;
    let mut acceleration = std::mem::take(&mut nodes.acceleration);
    let pass = NodePass { elements, nodes };
    let chunk = |index: usize, accelerations: &mut [[f64; 2]], kinetic: &mut f64| {
        *kinetic = pass.accelerate(index * CHUNK, accelerations);
    };
    if threads && nodes.len() >= PARALLEL {
        let chunks = acceleration.par_chunks_mut(CHUNK).zip(&mut *parts).enumerate();
        chunks.for_each(|(i, (a, k))| chunk(i, a, k));
    } else {
        let chunks = acceleration.chunks_mut(CHUNK).zip(&mut *parts).enumerate();
        chunks.for_each(|(i, (a, k))| chunk(i, a, k));
    }
    nodes.acceleration = acceleration;
    energies.kinetic = parts.iter().sum();
    if nodes.moved {
        let half = 0.5 * nodes.behind;
        let [now, before] = &nodes.forces;
        for ((f, g), node) in now.iter().zip(before).zip(nodes.as_slice()) {
            energies.external += half * ((f[0] + g[0]) * node.v_r + (f[1] + g[1]) * node.v_z);
        }
    }
}

/// Room for [`accelerate_nodes`].
pub(super) fn room_for_parts(nodes: &Nodes) -> Vec<f64> {
    vec![0.0; nodes.len().div_ceil(CHUNK)]
}

/// What accelerations come from.
struct NodePass<'a> {
    elements: &'a Elements,
    nodes: &'a Nodes,
}

impl NodePass<'_> {
    /// Accelerations of nodes from `first` on, and their kinetic energy. A few nodes at a time: first all their forces,
    /// then arithmetic that vectors can do.
    fn accelerate(&self, first: usize, accelerations: &mut [[f64; 2]]) -> f64 {
        let mut parts = [0.0; 4];
        let (mut forces, mut energies) = ([[0.0; 2]; FEW], [0.0; FEW]);
        let (behind, more) = (self.nodes.behind, &self.nodes.forces[0]);
        for (i, accelerations) in accelerations.chunks_mut(FEW).enumerate() {
            let (first, count) = (first + i * FEW, accelerations.len());
            if !self.elements.has_work(first) {
                continue;
            }
            let forces = &mut forces[..count];
            self.elements.nodal_forces(first, forces);
            if !more.is_empty() {
                for (force, more) in forces.iter_mut().zip(&more[first..first + count]) {
                    *force = [force[0] + more[0], force[1] + more[1]];
                }
            }
            let masses =
                self.nodes.mass[first..first + count].iter().zip(&self.nodes.inverse_mass[first..first + count]);
            let nodes = self.nodes.as_slice()[first..first + count].iter().zip(masses);
            let all = accelerations.iter_mut().zip(&*forces).zip(nodes).zip(&mut energies);
            for (((acceleration, force), (node, (mass, inverse))), energy) in all {
                let [a_r, a_z] = force.map(|f| f * inverse);
                *acceleration = [a_r, a_z];
                let twice = node.v_r * (node.v_r + behind * a_r) + node.v_z * (node.v_z + behind * a_z);
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

/// Where central differences start, forces act for half an increment alone and bring velocities from v to v + dt/2 a.
/// What they give in that half is their impulse times the mean of both, v + dt/4 a, while the trapezoid over the whole
/// increment reckons with the velocity at its end: too much by f a dt^2/8.
fn book_start(dofs: &mut Dofs, dt: f64) {
    let forces = dofs.nodes.forces[0].iter().zip(&dofs.nodes.acceleration);
    let power: f64 = forces.map(|(f, a)| f[0] * a[0] + f[1] * a[1]).sum();
    dofs.energies.external -= 0.125 * dt * dt * power;
}

/// Carries nodes over an increment. The first one starts central differences with half of it.
pub(super) fn advance_nodes(elements: &Elements, dofs: &mut Dofs, dt: f64, threads: bool) {
    if dofs.nodes.behind == 0.0 {
        book_start(dofs, dt);
    }
    let half = 0.5 * (dt + dofs.nodes.behind);
    let chunk = |(index, (nodes, accelerations)): (usize, (&mut [Node], &[[f64; 2]]))| {
        for (i, (nodes, accelerations)) in nodes.chunks_mut(FEW).zip(accelerations.chunks(FEW)).enumerate() {
            if !elements.has_work(index * CHUNK + i * FEW) {
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
    let many = threads && dofs.nodes.len() >= PARALLEL;
    let (nodes, accelerations) = dofs.nodes.motion_mut();
    if many {
        nodes.par_chunks_mut(CHUNK).zip(accelerations.par_chunks(CHUNK)).enumerate().for_each(chunk);
    } else {
        nodes.chunks_mut(CHUNK).zip(accelerations.chunks(CHUNK)).enumerate().for_each(chunk);
    }
    (dofs.nodes.behind, dofs.nodes.half, dofs.nodes.moved) = (dt, half, true);
}
