//! Mass, momentum and energies of a part: a set of elements.

use super::elements::Elements;
use super::values::internal_energy;
use crate::state::nodes::Nodes;
use crate::variables::Variable;

/// Totals of the active elements of a part, and the mass of its deleted elements.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PartTotals {
    /// Mass of the active elements.
    pub mass: f64,
    /// Momentum along z.
    pub momentum: f64,
    pub kinetic: f64,
    /// Internal energy, with the work of hourglass control.
    pub internal: f64,
    /// Mass of the deleted elements, without mass scaling.
    pub eroded: f64,
}

impl PartTotals {
    /// Adds an element, by group and index, with velocities at the current instant as in the total energies. A node
    /// contributes the part of its mass that belongs to the element.
    pub fn add(&mut self, elements: &Elements, (index, element): (usize, usize), nodes: &Nodes) {
        let group = &elements.groups[index];
        let value = |variable: Variable| group.value(element, variable.into()).unwrap_or(0.0);
        if group.is_deleted(element) {
            self.eroded += value(Variable::Mass) / elements.mass_scaling.factor(index, element).unwrap_or(1.0);
            return;
        }
        let (dt, boundary) = (nodes.previous_dt, group.topology().boundary());
        for (at, (&n, &mass)) in group.nodes(element).iter().zip(group.masses(element).iter()).enumerate() {
            let (node, [a_r, a_z]) = (nodes[n as usize], nodes.acceleration[n as usize]);
            self.kinetic += 0.5 * mass * (node.v_r * (node.v_r + dt * a_r) + node.v_z * (node.v_z + dt * a_z));
            // Companion nodes of shells have rotations only.
            if at < boundary {
                self.mass += mass;
                self.momentum += mass * (node.v_z + 0.5 * dt * a_z);
            }
        }
        self.internal += internal_energy(&**group, element);
    }
}
