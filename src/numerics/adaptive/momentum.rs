//! Transport of the momentum of nodes. The masses that pass between the corners of each element follow from the masses
//! that elements exchange and from their new corner masses, so that the momentum of each direction is conserved to
//! rounding and uniform velocities stay uniform (Benson 1992, Comput. Meth. Appl. Mech. Eng. 99, 235; Kucharik and
//! Shashkov 2014, J. Comput. Phys. 258, 268).

use super::geometry::share_of_first;
use super::limiter::{TransportWork, WeightFlux};
use super::topology::DomainTopology;
use super::transport::TransportOrder;
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::heap_bytes;

/// Transport of nodal velocities, and its work arrays.
#[derive(Clone, Debug)]
pub(super) struct MomentumTransport {
    order: TransportOrder,
    /// Masses that move between two nodes, to the first one.
    fluxes: Vec<WeightFlux>,
    /// Masses of the corners at the ends of each edge between nodes.
    masses: Vec<f64>,
    /// Masses that elements give to their corners.
    inflow: Vec<[f64; 4]>,
    work: TransportWork,
}

impl MomentumTransport {
    pub fn new(domain: &DomainTopology, order: TransportOrder) -> MomentumTransport {
        let fluxes = domain.links.iter().map(|cells| WeightFlux { cells: *cells, weight: 0.0 }).collect();
        let links = domain.links.len();
        MomentumTransport {
            order,
            fluxes,
            masses: vec![0.0; links],
            inflow: vec![[0.0; 4]; domain.corners.len()],
            work: TransportWork::new(domain.nodes.len(), links),
        }
    }

    pub fn bytes(&self) -> usize {
        heap_bytes(&self.fluxes) + heap_bytes(&self.masses) + heap_bytes(&self.inflow) + self.work.bytes()
    }

    /// Finds the masses that pass between nodes, from those between elements and from the corner masses before and after.
    pub fn measure(
        &mut self,
        domain: &DomainTopology,
        places: &[[f64; 2]],
        between: &[WeightFlux],
        [before, after]: [&[[f64; 4]]; 2],
    ) {
        self.inflow.fill([0.0; 4]);
        for (edge, flux) in domain.edges.iter().zip(between) {
            let first = share_of_first(places[edge.a as usize][0], places[edge.b as usize][0]);
            let shares = [first * flux.weight, (1.0 - first) * flux.weight];
            for (share, [left, right]) in shares.iter().zip(edge.corners) {
                self.inflow[edge.left as usize][left as usize] += share;
                self.inflow[edge.right as usize][right as usize] -= share;
            }
        }
        self.fluxes.iter_mut().for_each(|flux| flux.weight = 0.0);
        self.masses.fill(0.0);
        for (e, links) in domain.links_of.iter().enumerate() {
            let [before, after, inflow] = [&before[e], &after[e], &self.inflow[e]];
            let passed = passed([0, 1, 2, 3].inline_map(|i: usize| (after[i] - before[i]) - inflow[i]));
            for (i, (link, forward)) in links.iter().enumerate() {
                let to_first = if *forward { -passed[i] } else { passed[i] };
                self.fluxes[*link as usize].weight += to_first;
                self.masses[*link as usize] += before[i] + before[(i + 1) % 4];
            }
        }
    }

    /// Moves a component of the velocity; `after` are the nodal masses after the motion.
    pub fn move_velocity(&mut self, values: &mut [f64], after: &[f64]) {
        let (fluxes, masses, second) = (&self.fluxes, &self.masses, self.order == TransportOrder::Second);
        let reconstructed = |i: usize| {
            let flux = &fluxes[i];
            let donor = values[flux.donor()];
            let other = values[flux.cells[usize::from(flux.weight <= 0.0)] as usize];
            // Mean of the velocity in the mass that moves (Lax and Wendroff).
            let part = 0.5 * (1.0 - (flux.weight.abs() / masses[i]).min(1.0));
            if second { donor + part * (other - donor) } else { donor }
        };
        self.work.transport(values, fluxes, after, reconstructed);
        values.copy_from_slice(&self.work.value);
    }
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

#[cfg(test)]
mod tests {
    use super::passed;

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
