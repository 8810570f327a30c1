//! Flow of mass, momentum and energy through Eulerian boundaries.

use super::topology::DomainTopology;
use super::transport::EdgeFlux;
use crate::kernel::lanes::InlineMap;
use crate::state::energies::BoundaryFlow;

/// Iterates over the masses that enter at the nodes of Eulerian boundaries, negative where they leave.
pub(super) fn entering<'a>(
    domain: &'a DomainTopology,
    fluxes: &'a [EdgeFlux],
) -> impl Iterator<Item = (usize, f64)> + 'a {
    domain.open.iter().flat_map(|i| {
        let (edge, flux) = (&domain.edges[*i as usize], &fluxes[*i as usize]);
        let [first, second] = edge.nodes.inline_map(|n| n as usize);
        [(first, flux.first * flux.mass), (second, (1.0 - flux.first) * flux.mass)]
    })
}

/// Adds the flow through the edges with the velocities of their nodes: mass that enters has the velocity of the
/// material at the boundary, as mass that leaves. Equation (18.15).
pub(super) fn add_flow(total: &mut BoundaryFlow, domain: &DomainTopology, fluxes: &[EdgeFlux], velocity: &[[f64; 2]]) {
    for edge in &domain.open {
        let mass = fluxes[*edge as usize].mass;
        total.mass_in += mass.max(0.0);
        total.mass_out -= mass.min(0.0);
    }
    for (node, mass) in entering(domain, fluxes) {
        let [r, z] = velocity[node];
        total.momentum += mass * z;
        total.kinetic += 0.5 * mass * (r * r + z * z);
    }
}
