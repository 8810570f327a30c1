//! Transport of the momentum of nodes. The masses that pass between the corners of each element follow from the masses
//! that elements exchange and from their new corner masses, so that the momentum of each direction is conserved to
//! rounding and uniform velocities stay uniform (Benson 1992, Comput. Meth. Appl. Mech. Eng. 99, 235; Kucharik and
//! Shashkov 2014, J. Comput. Phys. 258, 268). Fluxes of second order are limited so that no value leaves the range of its
//! neighbours (Zalesak 1979, J. Comput. Phys. 31, 335).

use super::active::{MeshChange, marked};
use super::limiter::{larger, smaller};
use super::topology::{DomainEdge, DomainTopology};
use super::transport::{EdgeFlux, TransportOrder};
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::Memory;
use crate::kernel::shape::is_triangle;

/// Mass that passes along an edge to its first node.
#[derive(Clone, Copy, Debug, Default)]
struct NodeFlux {
    mass: f64,
    /// Mass of the corners at both ends.
    corners: f64,
    /// Velocity that is added to the change of the first node by the second order, times mass.
    correction: [f64; 2],
}

/// Velocity of a node after a motion of first order, the range of its neighbours, and the shares of the corrections that
/// keep it in this range.
#[derive(Clone, Copy, Debug, Default)]
struct NodeRange {
    low: [f64; 2],
    high: [f64; 2],
    raise: [f64; 2],
    lower: [f64; 2],
}

/// Transport of nodal velocities, and its work arrays.
#[derive(Clone, Debug, Memory)]
pub(super) struct MomentumTransport {
    order: TransportOrder,
    fluxes: Vec<NodeFlux>,
    /// Masses that pass from each corner of an element to the next one.
    passed: Vec<[f64; 4]>,
    /// Velocities after a motion of first order.
    moved: Vec<[f64; 2]>,
    ranges: Vec<NodeRange>,
}

impl MomentumTransport {
    pub fn new(domain: &DomainTopology, order: TransportOrder) -> MomentumTransport {
        let (nodes, elements) = (domain.nodes.len(), domain.corners.len());
        MomentumTransport {
            order,
            fluxes: vec![NodeFlux::default(); domain.edges.len()],
            passed: vec![[0.0; 4]; elements],
            moved: vec![[0.0; 2]; nodes],
            ranges: vec![NodeRange::default(); nodes],
        }
    }

    /// Finds the masses that pass between nodes, from those between elements and from the corner masses before and after.
    /// Equation (18.6).
    pub fn measure(&mut self, change: MeshChange<'_>, between: &[EdgeFlux], [before, after]: [&[[f64; 4]]; 2]) {
        let MeshChange { domain, active, loops } = change;
        loops.each(&mut self.passed, |start, part| {
            for (e, masses) in marked(part, start, &active.changes) {
                let inflow = corner_inflow(domain, between, e);
                let gains = [0, 1, 2, 3].inline_map(|i: usize| (after[e][i] - before[e][i]) - inflow[i]);
                *masses = if is_triangle(&domain.corners[e]) { passed_in_triangle(gains) } else { passed(gains) };
            }
        });
        let passed = &self.passed;
        loops.each(&mut self.fluxes, |start, part| {
            for (i, flux) in marked(part, start, &active.edges) {
                let edge = &domain.edges[i];
                let passed_by = |e: u32, side: u8, sign: f64| {
                    let (e, i) = (e as usize, side as usize);
                    let mass = if active.changes[e] { sign * passed[e][i] } else { 0.0 };
                    [mass, before[e][i] + before[e][(i + 1) % 4]]
                };
                // Masses run from corner i to the next one, which is the first node for the element on the right.
                let [mut mass, mut corners] = passed_by(edge.left, edge.sides[0], -1.0);
                if edge.is_inner() {
                    let right = passed_by(edge.right, edge.sides[1], 1.0);
                    (mass, corners) = (mass + right[0], corners + right[1]);
                }
                *flux = NodeFlux { mass, corners, correction: [0.0; 2] };
            }
        });
    }

    /// Moves velocities; `after` are the nodal masses after the motion.
    pub fn move_velocity(&mut self, change: MeshChange<'_>, values: &mut [[f64; 2]], after: &[f64]) {
        let MeshChange { active, loops, .. } = change;
        let (fluxes, old_values) = (&self.fluxes, &*values);
        loops.each(&mut self.moved, |start, part| {
            for (at, moved) in part.iter_mut().enumerate() {
                let n = start + at;
                *moved = old_values[n];
                if active.nodes[n] {
                    *moved = first_order(change, fluxes, (n, old_values), after[n]);
                }
            }
        });
        if self.order == TransportOrder::Second {
            self.limit(change, old_values, after);
            let (fluxes, ranges) = (&self.fluxes, &self.ranges);
            loops.each(&mut self.moved, |start, part| {
                for (n, moved) in marked(part, start, &active.nodes) {
                    correct(moved, change, (fluxes, ranges), (n, after[n]));
                }
            });
        }
        values.copy_from_slice(&self.moved);
    }

    /// Finds the corrections of second order, and the range of each node. Equation (18.7).
    fn limit(&mut self, change: MeshChange<'_>, given: &[[f64; 2]], after: &[f64]) {
        let MeshChange { domain, active, loops } = change;
        loops.each(&mut self.fluxes, |start, part| {
            for (i, flux) in marked(part, start, &active.edges) {
                let [first, second] = domain.edges[i].nodes.inline_map(|n| given[n as usize]);
                // Mean of the velocity in the mass that moves (Lax and Wendroff).
                let share = if flux.corners > 0.0 { smaller(flux.mass.abs() / flux.corners, 1.0) } else { 1.0 };
                let weight = 0.5 * (1.0 - share) * flux.mass.abs();
                flux.correction = [0, 1].inline_map(|k: usize| weight * (first[k] - second[k]));
            }
        });
        let (fluxes, moved) = (&self.fluxes, &self.moved);
        loops.each(&mut self.ranges, |start, part| {
            for (n, range) in marked(part, start, &active.nodes) {
                *range = node_range(change, fluxes, [given, moved], (n, after[n]));
            }
        });
    }
}

/// Returns the masses that enter an element at each corner from its neighbours.
fn corner_inflow(domain: &DomainTopology, between: &[EdgeFlux], e: usize) -> [f64; 4] {
    let mut inflow = [0.0; 4];
    for (i, side) in domain.sides[e].iter().enumerate() {
        let flux = &between[side.edge as usize];
        let (entering, first) = (flux.entering(side), if side.is_left { flux.first } else { 1.0 - flux.first });
        inflow[i] += first * entering;
        inflow[(i + 1) % 4] += (1.0 - first) * entering;
    }
    inflow
}

/// Returns the other end of an edge at a node, and the sign of fluxes to the node.
fn seen_from(edge: &DomainEdge, node: usize) -> (usize, f64) {
    if edge.nodes[0] as usize == node { (edge.nodes[1] as usize, 1.0) } else { (edge.nodes[0] as usize, -1.0) }
}

fn first_order(
    MeshChange { domain, active, .. }: MeshChange<'_>,
    fluxes: &[NodeFlux],
    (node, given): (usize, &[[f64; 2]]),
    after: f64,
) -> [f64; 2] {
    let own_velocity = given[node];
    // A sum of changes, so that a common value stays exact.
    let mut sum = [0.0; 2];
    for edge in domain.edges_at.list(node).iter().map(|i| *i as usize).filter(|i| active.edges[*i]) {
        let (other, sign) = seen_from(&domain.edges[edge], node);
        let entering = larger(sign * fluxes[edge].mass, 0.0);
        sum = [0, 1].inline_map(|k: usize| sum[k] + entering * (given[other][k] - own_velocity[k]));
    }
    [0, 1].inline_map(|k: usize| own_velocity[k] + sum[k] / after)
}

fn node_range(
    MeshChange { domain, active, .. }: MeshChange<'_>,
    fluxes: &[NodeFlux],
    [given, moved]: [&[[f64; 2]]; 2],
    (node, after): (usize, f64),
) -> NodeRange {
    let (own_velocity, new) = (given[node], moved[node]);
    let least = |a: [f64; 2], b: [f64; 2]| [0, 1].inline_map(|k: usize| smaller(a[k], b[k]));
    let highest = |a: [f64; 2], b: [f64; 2]| [0, 1].inline_map(|k: usize| larger(a[k], b[k]));
    let mut range =
        NodeRange { low: least(own_velocity, new), high: highest(own_velocity, new), ..NodeRange::default() };
    for edge in domain.edges_at.list(node).iter().map(|i| *i as usize) {
        let (other, sign) = seen_from(&domain.edges[edge], node);
        range.low = least(range.low, least(given[other], moved[other]));
        range.high = highest(range.high, highest(given[other], moved[other]));
        if active.edges[edge] {
            let correction = fluxes[edge].correction.inline_map(|x| sign * x);
            range.raise = [0, 1].inline_map(|k: usize| range.raise[k] + larger(correction[k], 0.0));
            range.lower = [0, 1].inline_map(|k: usize| range.lower[k] - smaller(correction[k], 0.0));
        }
    }
    let share = |room: f64, sum: f64| if sum > 0.0 { smaller(after * room / sum, 1.0) } else { 0.0 };
    range.raise = [0, 1].inline_map(|k: usize| share(range.high[k] - new[k], range.raise[k]));
    range.lower = [0, 1].inline_map(|k: usize| share(new[k] - range.low[k], range.lower[k]));
    range
}

/// Adds the limited corrections to the velocity of a node.
fn correct(
    moved: &mut [f64; 2],
    MeshChange { domain, active, .. }: MeshChange<'_>,
    (fluxes, ranges): (&[NodeFlux], &[NodeRange]),
    (node, after): (usize, f64),
) {
    let own_range = &ranges[node];
    let mut sum = [0.0; 2];
    for edge in domain.edges_at.list(node).iter().map(|i| *i as usize).filter(|i| active.edges[*i]) {
        let (other, sign) = seen_from(&domain.edges[edge], node);
        let other = &ranges[other];
        sum = [0, 1].inline_map(|k: usize| {
            let correction = sign * fluxes[edge].correction[k];
            let share = if correction > 0.0 {
                smaller(own_range.raise[k], other.lower[k])
            } else {
                smaller(own_range.lower[k], other.raise[k])
            };
            sum[k] + share * correction
        });
    }
    // Rounding may exceed the range by a last bit.
    *moved =
        [0, 1].inline_map(|k: usize| larger(smaller(moved[k] + sum[k] / after, own_range.high[k]), own_range.low[k]));
}

/// Returns the masses that pass from each corner of an element to the next one, the smallest that give the corners what
/// they gain; the gains sum to zero but for rounding.
fn passed(gains: [f64; 4]) -> [f64; 4] {
    let mut passed = [0.0; 4];
    for i in 1..4 {
        passed[i] = passed[i - 1] - gains[i];
    }
    let mean = 0.25 * ((passed[0] + passed[1]) + (passed[2] + passed[3]));
    passed.inline_map(|flux| flux - mean)
}

/// Returns the masses that pass in a triangle, whose last two corners are one node: nothing passes between these.
fn passed_in_triangle([_, second, third, fourth]: [f64; 4]) -> [f64; 4] {
    let to_third = -second;
    let to_first = to_third - (third + fourth);
    let mean = (to_third + to_first) / 3.0;
    [-mean, to_third - mean, 0.0, to_first - mean]
}

#[cfg(test)]
mod tests {
    use super::{passed, passed_in_triangle};

    #[test]
    fn corners_of_a_triangle_gain_what_passes() {
        let gains = [1.0, -2.5, 0.5, 1.0];
        let [to_second, to_third, within, to_first] = passed_in_triangle(gains);
        let gained = [to_first - to_second, to_second - to_third, to_third - to_first];
        for (gained, expected) in gained.into_iter().zip([1.0, -2.5, 1.5]) {
            assert!((gained - expected).abs() < 1e-15);
        }
        assert!(within == 0.0 && (to_second + to_third + to_first).abs() < 1e-15);
    }

    #[test]
    fn corners_gain_what_passes() {
        let gains = [1.0, -2.0, 0.5, 0.5];
        let flux = passed(gains);
        for i in 0..4 {
            assert!((flux[(i + 3) % 4] - flux[i] - gains[i]).abs() < 1e-15);
        }
        assert_eq!(passed([0.0; 4]), [0.0; 4]);
    }
}
