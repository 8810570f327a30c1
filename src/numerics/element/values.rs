//! Element output values: taken from the group, or computed by the formulas of the variables.

use crate::element::group::ElementGroup;
use crate::state::nodes::Node;
use crate::variables::{ElementValues, Variable, VariableComponent};

/// An element of a group at the current node positions.
struct ElementView<'a> {
    group: &'a dyn ElementGroup,
    nodes: &'a [Node],
    element: usize,
}

impl ElementValues for ElementView<'_> {
    fn held(&self, variable: Variable, component: usize) -> Option<f64> {
        self.group.value(self.element, VariableComponent { variable, component })
    }

    fn volume(&self) -> f64 {
        self.group.volume(self.element, self.nodes)
    }
}

/// Returns an output value of an element, stored in its group or computed by formula; `None` if the element does not
/// have it.
pub fn value(group: &dyn ElementGroup, nodes: &[Node], element: usize, part: VariableComponent) -> Option<f64> {
    part.variable.of(part.component, &ElementView { group, nodes, element })
}

/// Returns whether an element has a variable, or will have it once output records are active.
pub fn has(group: &dyn ElementGroup, nodes: &[Node], element: usize, part: VariableComponent) -> bool {
    let row = part.variable.row();
    match row.needs {
        Some(other) => has(group, nodes, element, other.into()),
        None => row.followed || value(group, nodes, element, part).is_some(),
    }
}

/// Returns the internal energy of an element since the start: the sum of its recorded energies.
pub fn internal_energy(group: &dyn ElementGroup, element: usize) -> f64 {
    use Variable::{ElementArtificialEnergy, ElementDamageEnergy, ElementPlasticEnergy, ElementStrainEnergy};
    let energies = [ElementStrainEnergy, ElementPlasticEnergy, ElementDamageEnergy, ElementArtificialEnergy];
    energies.iter().filter_map(|&energy| group.value(element, energy.into())).sum()
}
