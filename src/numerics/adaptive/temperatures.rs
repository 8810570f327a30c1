//! Transport of nodal temperatures. They move with the masses between the nodes as velocities do: the heat content is
//! conserved to rounding, and no temperature leaves the range of its neighbours.

use super::active::ActiveParts;
use super::loops::DomainLoops;
use super::momentum::MomentumTransport;
use super::topology::DomainTopology;
use crate::heat::field::TemperatureField;
use crate::kernel::lists::heap_bytes;

/// Temperatures of the nodes of a domain, and their heat capacities.
#[derive(Clone, Debug)]
pub(super) struct TemperatureTransport {
    /// Temperature, and zero: the transport of momentum moves pairs of values.
    values: Vec<[f64; 2]>,
    /// Capacity over the specific heat of the domain: the mass of the domain at the node, and that of the same capacity
    /// for other materials.
    masses: Vec<f64>,
}

impl TemperatureTransport {
    /// Creates the transport for `count` nodes.
    pub fn new(count: usize) -> TemperatureTransport {
        TemperatureTransport { values: vec![[0.0; 2]; count], masses: vec![0.0; count] }
    }

    pub fn bytes(&self) -> usize {
        heap_bytes(&self.values) + heap_bytes(&self.masses)
    }

    /// Reads temperatures and capacities; `group` is the element group of the domain.
    pub fn read(&mut self, domain: &DomainTopology, group: usize, field: &TemperatureField) {
        let per = field.specific_heat(group).map_or(0.0, |heat| 1.0 / heat);
        for ((value, mass), n) in self.values.iter_mut().zip(&mut self.masses).zip(&domain.nodes) {
            *value = [field.temperatures()[*n as usize], 0.0];
            *mass = per * field.capacity_of(*n as usize);
        }
    }

    /// Moves temperatures by the masses that `momentum` has measured, with the masses of all nodes before and after.
    pub fn advance(
        &mut self,
        momentum: &mut MomentumTransport,
        loops: DomainLoops,
        (domain, active): (&DomainTopology, &ActiveParts),
        [before, after]: [&[f64]; 2],
    ) {
        let changes = before.iter().zip(after).zip(&active.nodes).filter(|change| *change.1);
        let masses = self.masses.iter_mut().zip(&active.nodes).filter(|mass| *mass.1);
        masses.zip(changes).for_each(|((mass, _), ((before, after), _))| *mass += after - before);
        momentum.move_velocity(loops, (domain, active), &mut self.values, &self.masses);
    }

    /// Writes the temperatures of nodes whose elements have changed; their capacities are those of the new masses.
    pub fn write(&mut self, (domain, active): (&DomainTopology, &ActiveParts), field: &mut TemperatureField) {
        let values = &mut self.values;
        field.restore_prescribed(|node, prescribed| {
            let at = domain.nodes.binary_search(&(node as u32)).ok().filter(|at| active.nodes[*at])?;
            Some(std::mem::replace(&mut values[at][0], prescribed))
        });
        for ((value, n), _) in self.values.iter().zip(&domain.nodes).zip(&active.nodes).filter(|node| *node.1) {
            field.set_transported(*n as usize, value[0]);
        }
    }
}
