//! Area weighting: elements assemble forces and masses of their plane sections. This file scales the nodal forces back
//! to full rings, so that loads and motions act on a node as in other formulations.

use super::group::ElementGroup;
use crate::kernel::lists::Memory;
use crate::state::archive::Persist;
use crate::state::nodes::Nodes;
use crate::variables::Variable;

/// Factors from plane sections to rings at the nodes of area-weighted elements.
#[derive(Clone, Debug, Persist, Memory)]
#[persist(fixed: factors; derived: quarters)]
#[memory(inside: quarters)]
pub struct RingFactors {
    /// A quarter of the mass of each element over 2π, group by group.
    quarters: Vec<Vec<f64>>,
    /// Factor of each node, length: its mass over that of the adjacent plane sections.
    pub(super) factors: Vec<f64>,
}

impl RingFactors {
    /// Creates the factors for all elements of a model.
    pub fn new(groups: &[Box<dyn ElementGroup>], nodes: usize) -> RingFactors {
        let quarter = |mass: f64| 0.25 * mass / (2.0 * std::f64::consts::PI);
        let mass = |g: &dyn ElementGroup, e| g.value(e, Variable::Mass.into()).unwrap_or_default();
        let of_group = |g: &dyn ElementGroup| (0..g.len()).map(|e| quarter(mass(g, e))).collect();
        RingFactors { quarters: groups.iter().map(|g| of_group(&**g)).collect(), factors: vec![0.0; nodes] }
    }

    /// Updates the factors at the current positions: the mass of a section is that of its element over the
    /// circumference at its mean radius.
    pub(super) fn measure(&mut self, groups: &[Box<dyn ElementGroup>], nodes: &Nodes) {
        self.factors.fill(0.0);
        for (group, quarters) in groups.iter().zip(&self.quarters) {
            for (e, quarter) in quarters.iter().enumerate() {
                let corners = group.boundary(e).map(|n| n as usize);
                let radius = 0.25 * corners.iter().map(|&n| nodes[n].r).sum::<f64>();
                corners.iter().for_each(|&n| self.factors[n] += quarter / radius);
            }
        }
        for (factor, mass) in self.factors.iter_mut().zip(&nodes.mass) {
            *factor = if *factor > 0.0 { mass / *factor } else { 0.0 };
        }
    }
}
