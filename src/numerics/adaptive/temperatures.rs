//! Transport of nodal temperatures. The heat per mass moves with the masses between the nodes as velocities do: the heat
//! content is conserved to rounding, and no temperature leaves the range of its neighbours.

use super::active::{ActiveParts, MeshChange};
use super::boundary::entering;
use super::momentum::MomentumTransport;
use super::topology::DomainTopology;
use super::transport::EdgeFlux;
use crate::heat::field::TemperatureField;
use crate::kernel::lists::Memory;

/// Heat of the nodes of a domain.
#[derive(Clone, Debug, Memory)]
pub(super) struct TemperatureTransport {
    /// Heat per mass of the material of the domain, and zero: the transport of momentum moves pairs of values.
    values: Vec<[f64; 2]>,
    /// Masses of the material of the domain at the nodes.
    masses: Vec<f64>,
    /// Heat of other materials at the nodes, which follow the material.
    rest: Vec<f64>,
    /// Heat that has entered through Eulerian boundaries in this change of the mesh, less that which has left.
    entered: f64,
}

impl TemperatureTransport {
    /// Creates the transport for `count` nodes.
    pub fn new(count: usize) -> TemperatureTransport {
        TemperatureTransport {
            values: vec![[0.0; 2]; count],
            masses: vec![0.0; count],
            rest: vec![0.0; count],
            entered: 0.0,
        }
    }

    /// Reads the heat of the nodes; `group` is the element group of the domain.
    pub fn read(&mut self, domain: &DomainTopology, group: usize, field: &TemperatureField) {
        self.masses.fill(0.0);
        self.entered = 0.0;
        for (e, corners) in domain.elements.iter().zip(&domain.corners) {
            for (n, mass) in corners.iter().zip(field.masses_of(group, *e as usize)) {
                self.masses[*n as usize] += mass;
            }
        }
        for (i, n) in domain.nodes.iter().enumerate() {
            let temperature = field.temperatures()[*n as usize];
            let heat = field.heat_per_mass(group, temperature);
            self.values[i] = [heat, 0.0];
            self.rest[i] = field.content_at(*n as usize, temperature) - self.masses[i] * heat;
        }
    }

    /// Adds the heat of the material that passes through Eulerian boundaries, which has the temperature of the nodes there.
    pub fn add_flow(&mut self, domain: &DomainTopology, fluxes: &[EdgeFlux]) {
        self.entered += entering(domain, fluxes).map(|(node, mass)| mass * self.values[node][0]).sum::<f64>();
    }

    /// Moves heat with the masses that `momentum` has measured, with the masses of all nodes before and after.
    pub fn advance(&mut self, momentum: &mut MomentumTransport, change: MeshChange<'_>, [before, after]: [&[f64]; 2]) {
        let changes = before.iter().zip(after).zip(&change.active.nodes);
        for (mass, ((before, after), _)) in self.masses.iter_mut().zip(changes).filter(|node| *node.1.1) {
            *mass += after - before;
        }
        momentum.move_velocity(change, &mut self.values, &self.masses);
    }

    /// Writes the temperatures of nodes whose elements have changed; the capacities of the field are those of the new
    /// masses. Prescribed temperatures stay.
    pub fn write(&mut self, (domain, active): (&DomainTopology, &ActiveParts), field: &mut TemperatureField) {
        field.add_flow(self.entered);
        let TemperatureTransport { values, masses, rest, .. } = self;
        let content = |i: usize, values: &[[f64; 2]]| masses[i] * values[i][0] + rest[i];
        field.restore_prescribed(|node| {
            let i = domain.nodes.binary_search(&(node as u32)).ok().filter(|i| active.nodes[*i])?;
            let brought = content(i, values);
            // The node keeps its temperature.
            values[i][1] = 1.0;
            Some(brought)
        });
        for (i, n) in domain.nodes.iter().enumerate().filter(|(i, _)| active.nodes[*i]) {
            if values[i][1] == 0.0 {
                field.set_content(*n as usize, content(i, values));
            }
        }
    }
}
