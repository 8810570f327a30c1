//! Bound of the stable time increment by cohesive elements. It follows from the stiffness between their faces and the
//! masses of the nodes that they join, including those of the adjacent bodies.

use crate::element::group::ElementGroup;
use crate::kernel::lists::Memory;
use crate::state::nodes::Nodes;

/// A degree of freedom that resists the motion of a node of an interface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InertiaShare {
    /// Node that represents all nodes with this motion.
    pub node: usize,
    /// Displacement of the interface node per displacement of this node.
    pub weight: f64,
    /// Acceleration per force, for rigid bodies and linked nodes; `None` if it is that of the node.
    pub inverse_mass: Option<f64>,
}

/// Stiffness between two nodes along an axis.
#[derive(Clone, Debug, PartialEq, Memory)]
pub struct InterfaceSpring {
    /// Group and index in the group of the element.
    pub element: (usize, usize),
    /// 0 along r, 1 along z.
    pub axis: usize,
    /// Force per separation.
    pub stiffness: f64,
    /// Degrees of freedom that move both nodes.
    pub shares: Vec<InertiaShare>,
}

/// Springs of all cohesive elements.
#[derive(Clone, Debug, Default, Memory)]
pub struct InterfaceBounds {
    springs: Vec<InterfaceSpring>,
    /// Stiffness at each node along each axis.
    sums: Vec<[f64; 2]>,
}

impl InterfaceBounds {
    /// Creates the bounds of springs between `count` nodes.
    pub fn new(springs: Vec<InterfaceSpring>, count: usize) -> Self {
        let mut sums = vec![[0.0; 2]; count];
        for spring in &springs {
            for share in &spring.shares {
                sums[share.node][spring.axis] += share.weight.abs() * spring.stiffness;
            }
        }
        InterfaceBounds { springs, sums }
    }

    /// Sets one over the stable time increment of each element for the current masses. Equation (17.7).
    ///
    /// K = Bᵀ k B has the eigenvalues of √k B M⁻¹ Bᵀ √k; these are at most the largest row sum (Gershgorin). The two
    /// points of an element have their own nodes, so that rows of one axis contain all couplings; along other axes of
    /// the mid-surface the larger of both stiffnesses is used.
    pub fn apply(&self, groups: &mut [Box<dyn ElementGroup>], nodes: &Nodes) {
        let mut rates: Option<((usize, usize), f64)> = None;
        for spring in &self.springs {
            let row = |share: &InertiaShare| {
                let inverse = share.inverse_mass.unwrap_or(nodes.inverse_mass[share.node]);
                share.weight.abs() * self.sums[share.node][spring.axis] * inverse
            };
            let rate = 0.5 * spring.shares.iter().map(row).sum::<f64>().sqrt();
            let largest = match rates {
                Some((element, largest)) if element == spring.element => rate.max(largest),
                _ => rate,
            };
            rates = Some((spring.element, largest));
            let (group, element) = spring.element;
            if let Some(cohesive) = groups[group].as_cohesive() {
                cohesive.set_rate(element, largest);
            }
        }
    }
}
