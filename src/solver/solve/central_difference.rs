//! Central differences for nodes: accelerations from forces, velocities at mid-increment, displacements (ABAQUS Theory
//! Guide 2.4.5). Rigid bodies are integrated in `state`.

use crate::kernel::chunks::{ChunkLoops, FEW, chunks_of};
use crate::kernel::lanes::InlineMap;

use crate::element::elements::Elements;
use crate::state::dofs::Dofs;
use crate::state::nodes::Nodes;

/// Computes nodal accelerations and the kinetic energy, and adds the work of nodal forces over the previous increment.
/// `parts` is a work array for the energies of chunks.
pub(super) fn accelerate_nodes(elements: &Elements, dofs: &mut Dofs, parts: &mut [f64]) {
    let Dofs { nodes, energies, .. } = dofs;
    let mut acceleration = std::mem::take(&mut nodes.acceleration);
    let pass = NodePass { elements, nodes };
    energies.kinetic = ChunkLoops::new(elements.arch()).sum(
        &mut acceleration,
        parts,
        #[inline(always)]
        |first, accelerations| pass.accelerate(first, accelerations),
    );
    nodes.acceleration = acceleration;
    if nodes.work_pending {
        let half = 0.5 * nodes.previous_dt;
        let [now, before] = &nodes.forces;
        for ((f, g), node) in now.iter().zip(before).zip(nodes.as_slice()) {
            energies.external += half * ((f[0] + g[0]) * node.v_r + (f[1] + g[1]) * node.v_z);
        }
    }
}

pub(super) fn chunk_energies(nodes: &Nodes) -> Vec<f64> {
    vec![0.0; chunks_of(nodes.len())]
}

/// Input of the pass over nodes.
struct NodePass<'a> {
    elements: &'a Elements,
    nodes: &'a Nodes,
}

impl NodePass<'_> {
    /// Computes accelerations of nodes from index `first` on and returns their kinetic energy. Forces of a few nodes
    /// are gathered first, so that the arithmetic can be vectorised. Equation (14.2).
    #[inline(always)]
    fn accelerate(&self, first: usize, accelerations: &mut [[f64; 2]]) -> f64 {
        let mut parts = [0.0; 4];
        let (mut forces, mut energies) = ([[0.0; 2]; FEW], [0.0; FEW]);
        let (previous_dt, more) = (self.nodes.previous_dt, &self.nodes.forces[0]);
        for (i, accelerations) in accelerations.chunks_mut(FEW).enumerate() {
            let (first, count) = (first + i * FEW, accelerations.len());
            if !self.elements.has_work(first) {
                continue;
            }
            let forces = &mut forces[..count];
            self.elements.assembly.sum(first, forces);
            if !more.is_empty() {
                for (force, more) in forces.iter_mut().zip(&more[first..first + count]) {
                    *force = [force[0] + more[0], force[1] + more[1]];
                }
            }
            let masses =
                self.nodes.mass[first..first + count].iter().zip(&self.nodes.inverse_mass[first..first + count]);
            let nodes = self.nodes.as_slice()[first..first + count].iter().zip(masses);
            let nodes_of_chunk = accelerations.iter_mut().zip(&*forces).zip(nodes).zip(&mut energies);
            for (((acceleration, force), (node, (mass, inverse))), energy) in nodes_of_chunk {
                let [a_r, a_z] = force.inline_map(|f| f * inverse);
                *acceleration = [a_r, a_z];
                let twice = node.v_r * (node.v_r + previous_dt * a_r) + node.v_z * (node.v_z + previous_dt * a_z);
                *energy = mass * twice;
            }
            energies[count..].fill(0.0);
            // Four independent sums avoid the latency of additions.
            for four in energies.as_chunks::<4>().0 {
                for (part, energy) in parts.iter_mut().zip(four) {
                    *part += energy;
                }
            }
        }
        0.5 * ((parts[0] + parts[1]) + (parts[2] + parts[3]))
    }
}

/// Corrects the work of forces in the first increment: the trapezoidal rule overestimates it by f a dt^2/8 (reason:
/// [`LastIncrement::new`](crate::load::LastIncrement::new)). Equation (14.4).
fn correct_first_work(dofs: &mut Dofs, dt: f64) {
    let forces = dofs.nodes.forces[0].iter().zip(&dofs.nodes.acceleration);
    let power: f64 = forces.map(|(f, a)| f[0] * a[0] + f[1] * a[1]).sum();
    dofs.energies.external -= 0.125 * dt * dt * power;
}

/// Advances nodes over an increment. The first increment starts central differences with a half step. Equations (4.1),
/// (4.2).
pub(super) fn advance_nodes(elements: &Elements, dofs: &mut Dofs, dt: f64) {
    if dofs.nodes.previous_dt == 0.0 {
        correct_first_work(dofs, dt);
    }
    let half = 0.5 * (dt + dofs.nodes.previous_dt);
    let (nodes, accelerations) = dofs.nodes.motion_mut();
    ChunkLoops::new(elements.arch()).each(
        nodes,
        #[inline(always)]
        |first, nodes| {
            let accelerations = accelerations[first..first + nodes.len()].chunks(FEW);
            for (i, (nodes, accelerations)) in nodes.chunks_mut(FEW).zip(accelerations).enumerate() {
                if !elements.has_work(first + i * FEW) {
                    continue;
                }
                for (node, a) in nodes.iter_mut().zip(accelerations) {
                    node.v_r += half * a[0];
                    node.v_z += half * a[1];
                    node.r += dt * node.v_r;
                    node.z += dt * node.v_z;
                }
            }
        },
    );
    (dofs.nodes.previous_dt, dofs.nodes.half, dofs.nodes.work_pending) = (dt, half, true);
}

#[cfg(test)]
mod tests {
    use super::{accelerate_nodes, advance_nodes, chunk_energies};
    use crate::element::constants::{ElementConstants, HourglassControl};
    use crate::element::elements::Elements;
    use crate::element::frequency::{ConstrainedNodes, HighestFrequency};
    use crate::element::quad::QuadGroup;
    use crate::element::timing::GroupTiming;
    use crate::kernel::bulk_viscosity::BulkViscosity;
    use crate::kernel::quad;
    use crate::material::plasticity::ElasticOnly;
    use crate::material::volumetric::ConstantBulkModulus;
    use crate::material::von_mises::VonMises;
    use crate::mesh::gather::NodalAssembly;
    use crate::state::Instant;
    use crate::state::dofs::Dofs;
    use crate::state::nodes::{Node, Nodes};
    use crate::user::PointRoutines;

    /// A rectangular grid of elements, nodes row by row, with one more node that belongs to no element.
    struct GridMesh {
        nodes: Vec<Node>,
        elements: Vec<[u32; 4]>,
    }

    impl GridMesh {
        fn new(columns: usize, rows: usize, place: impl Fn(usize) -> [f64; 2]) -> GridMesh {
            let count = (columns + 1) * (rows + 1);
            let mut nodes: Vec<Node> = (0..count).map(place).map(|[r, z]| Node { r, z, ..Node::default() }).collect();
            nodes.push(Node::default());
            let elements = (0..columns * rows)
                .map(|e| (e / columns * (columns + 1) + e % columns) as u32)
                .map(|n| [n, n + 1, n + columns as u32 + 2, n + columns as u32 + 1])
                .collect();
            GridMesh { nodes, elements }
        }

        fn free(&self, bulk_viscosity: BulkViscosity, awake: bool) -> FreeBody {
            let constants = ElementConstants {
                bulk: 3.0,
                shear: 1.0,
                hourglass: HourglassControl { stiffness: 0.005, viscosity: 0.0, relaxes: true, enhanced: 0.0 },
                bulk_viscosity,
                shear_viscosity: 0.0,
                by_area: false,
            };
            let count = self.nodes.len();
            let mut mass = vec![0.0; count];
            for corners in &self.elements {
                let places = corners.map(|n| self.nodes[n as usize].place());
                for (n, m) in corners.iter().zip(quad::corner_masses(places, 1.0)) {
                    mass[*n as usize] += m;
                }
            }
            let mut quads = QuadGroup::new(
                VonMises::new(ElasticOnly, ConstantBulkModulus),
                constants,
                1.0,
                &self.elements,
                &self.nodes,
            );
            if awake {
                quads.keep_awake(count as u32 - 1);
            }
            let gather = NodalAssembly::new(count, &[(1, self.elements.iter().map(|e| (*e).into()))]);
            let elements = Elements::new(vec![Box::new(quads)], vec![0], gather, count);
            let dofs = Dofs { nodes: Nodes::new(self.nodes.clone(), mass), ..Dofs::default() };
            FreeBody { parts: chunk_energies(&dofs.nodes), dofs, elements }
        }
    }

    /// A body without loads and constraints.
    struct FreeBody {
        dofs: Dofs,
        elements: Elements,
        parts: Vec<f64>,
    }

    impl FreeBody {
        fn evaluate(&mut self) {
            self.evaluate_on(false);
        }

        fn evaluate_on(&mut self, threads: bool) {
            self.elements.update(
                &mut self.dofs,
                &Instant::default(),
                threads,
                PointRoutines::default(),
                GroupTiming::default(),
            );
            self.elements.add_link_forces(&mut self.dofs);
            accelerate_nodes(&self.elements, &mut self.dofs, &mut self.parts);
            self.dofs.nodes.work_pending = false;
        }

        fn advance(&mut self, dt: f64) {
            advance_nodes(&self.elements, &mut self.dofs, dt);
            self.elements.mark_moved();
        }
    }

    /// A wave that enters a long bar at rest gives the same bits with and without quiescent elements.
    #[test]
    fn quiescent_elements_change_no_bit() {
        let (columns, rows) = (2, 1500);
        let mut mesh = GridMesh::new(columns, rows, |n| [(n % (columns + 1)) as f64, (n / (columns + 1)) as f64]);
        mesh.nodes[..3].iter_mut().for_each(|n| n.v_z = 1e-3);
        // The free node moves, so the task that contains it is never quiescent.
        let count = mesh.nodes.len() - 1;
        mesh.nodes[count].v_r = 1.0;
        let run = |awake: bool| {
            let mut free = mesh.free(BulkViscosity::default(), awake);
            let mut quiescent = Vec::new();
            for _ in 0..600 {
                free.evaluate();
                quiescent.push((0..12).filter(|t| free.elements.groups[0].is_quiescent(*t)).count());
                let dt = 0.9 * free.elements.stable_increment();
                free.advance(dt);
            }
            (free.dofs, quiescent)
        };
        let (quiescent, awake) = (run(false), run(true));
        let last = *quiescent.1.last().expect("a count");
        assert_eq!((quiescent.1[1], last, awake.1[1]), (11, 7, 0));
        assert_eq!(quiescent.0.energies, awake.0.energies);
        let bits = |dofs: &Dofs| -> Vec<u64> {
            let nodes = &dofs.nodes.as_slice()[..count];
            nodes.iter().flat_map(Node::as_array).map(f64::to_bits).collect()
        };
        assert_eq!(bits(&quiescent.0), bits(&awake.0));
    }

    /// A wave that enters a bar at rest gives the same bits with corner forces in tiles, on any number of threads. Nodes in
    /// the middle of the bar are in reverse order, so that tasks do not complete them in the order of their numbers.
    #[test]
    fn tiles_change_no_bit() {
        let (columns, rows) = (3, 1100);
        let width = columns + 1;
        let mut mesh = GridMesh::new(columns, rows, |n| [1.0 + (n % width) as f64, (n / width) as f64]);
        mesh.nodes[..width].iter_mut().for_each(|n| n.v_z = 1e-3);
        let reversed = |n: usize| if (2000..2400).contains(&n) { 4399 - n } else { n };
        mesh.elements.iter_mut().for_each(|e| *e = e.map(|n| reversed(n as usize) as u32));
        let original_nodes = mesh.nodes.clone();
        (0..mesh.nodes.len()).for_each(|n| mesh.nodes[reversed(n)] = original_nodes[n]);
        let run = |tasks: Option<usize>, threads: bool| {
            let mut free = mesh.free(BulkViscosity::default(), false);
            if let Some(tasks) = tasks {
                let bytes = free.elements.bytes_of_gather();
                let Elements { groups, assembly, .. } = &mut free.elements;
                assembly.tile_by(groups, [(0, 2000)].into_iter(), |_| tasks);
                assert!(free.elements.bytes_of_gather() < bytes);
            }
            let mut bits = Vec::new();
            for _ in 0..700 {
                free.evaluate_on(threads);
                let Elements { groups, assembly, .. } = &free.elements;
                bits.push(assembly.corner_force(groups, (0, 2000), 1).map(f64::to_bits));
                bits.extend(
                    (0..mesh.nodes.len()).step_by(97).map(|n| free.elements.assembly.node_force(n).map(f64::to_bits)),
                );
                let dt = 0.9 * free.elements.stable_increment();
                free.advance(dt);
            }
            assert!(free.dofs.energies.internal > 0.0 && free.elements.groups[0].is_quiescent(12));
            let nodes = free.dofs.nodes.as_slice().iter().flat_map(Node::as_array).map(f64::to_bits);
            bits.extend(free.dofs.nodes.acceleration.iter().map(|a| a.map(f64::to_bits)));
            (bits, nodes.collect::<Vec<_>>(), free.dofs.energies)
        };
        let whole = run(None, false);
        for tasks in [1, 2, 5, 100] {
            assert_eq!(whole, run(Some(tasks), false), "{tasks} tasks in a tile");
            assert_eq!(whole, run(Some(tasks), true), "{tasks} tasks in a tile, several threads");
        }
    }

    /// Free vibration with all frequencies is stable at the estimated increment, which is conservative by 10 % without
    /// damping, and unstable a little above the exact bound.
    #[test]
    fn vibration_is_stable_just_up_to_the_estimate() {
        let noise = |i: usize| 0.3 * (((i * 7919) % 101) as f64 / 101.0 - 0.5);
        let mut mesh = GridMesh::new(6, 6, |n| [1.0 + (n % 7) as f64 + noise(n), (n / 7) as f64 + noise(n + 3)]);
        for (n, node) in mesh.nodes.iter_mut().enumerate() {
            node.v_r = 1e-8 * (((n * 7907) % 89) as f64 / 89.0 - 0.5);
            node.v_z = 1e-8 * (((n * 7901) % 97) as f64 / 97.0 - 0.5);
        }
        let run = |factor: f64| {
            let mut free = mesh.free(BulkViscosity::NONE, false);
            free.elements.frequency = HighestFrequency::new(&free.elements.groups, &free.dofs.nodes).map(Box::new);
            free.elements.begin_frequency(true, &free.dofs.nodes, &ConstrainedNodes { prescribed: &[], carried: &[] });
            let (mut largest, mut stable): (f64, f64) = (0.0, 0.0);
            for increment in 0..4000 {
                free.evaluate();
                if increment <= 1 {
                    stable = free.elements.stable_increment();
                }
                free.advance(if increment == 0 { stable } else { factor * stable });
                largest = largest.max(free.dofs.energies.kinetic.abs());
                if largest > 1e-10 {
                    break;
                }
            }
            largest
        };
        assert!(run(1.0) < 1e-12);
        assert!(run(1.1 * 1.03) > 1e-10);
    }
}
