//! An element as output sees it: what its group holds, and what follows from that by the formulas of the variables.
//! Never here: which variables there are.

use crate::element::group::ElementGroup;
use crate::state::nodes::Node;
use crate::variables::{ElementValues, Part, Variable};

/// An element of a group on the present nodes.
struct Seen<'a> {
    group: &'a dyn ElementGroup,
    nodes: &'a [Node],
    element: usize,
}

impl ElementValues for Seen<'_> {
    fn held(&self, variable: Variable, component: usize) -> Option<f64> {
        self.group.value(self.element, Part { variable, component })
    }

    fn volume(&self) -> f64 {
        self.group.volume(self.element, self.nodes)
    }
}

/// A number of an element, held by its group or by formula; `None` where it does not have it.
pub fn value(group: &dyn ElementGroup, nodes: &[Node], element: usize, part: Part) -> Option<f64> {
    part.variable.of(part.component, &Seen { group, nodes, element })
}

/// Whether an element has a variable, or will have it once elements follow it.
pub fn has(group: &dyn ElementGroup, nodes: &[Node], element: usize, part: Part) -> bool {
    let row = part.variable.row();
    match row.needs {
        Some(other) => has(group, nodes, element, other.into()),
        None => row.followed || value(group, nodes, element, part).is_some(),
    }
}
