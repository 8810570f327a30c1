//! The links of a plan: equations between solver nodes, and sets of nodes with equal motion.

use std::borrow::Cow;
use std::collections::HashSet;

use indexmap::IndexMap;

use crate::constraint::bonds::{MergedDofs, NodalEquation};
use crate::constraint::tie::TiedNodes;
use crate::deck::Span;
use crate::plan::constraints::tie_equations::TieEquations;

/// Equations and links between solver nodes, which are active in all steps, and nodes tied to rigid bodies.
#[derive(Debug, Default)]
pub struct Links {
    /// Equations, and the card of each.
    pub equations: Vec<NodalEquation>,
    pub spans: Vec<Span>,
    /// Equations of nodes at ends of ties.
    pub ends: Vec<EndEquation>,
    /// Sets of nodes with equal motion along an axis.
    pub merged: Vec<MergedDofs>,
    /// Index in `merged` of the set that contains a node and axis.
    pub group: IndexMap<(usize, usize), usize>,
    /// Nodes that belong to rigid bodies.
    pub rigid_ties: Vec<TiedNodes>,
    /// Equations of each tie of the model.
    pub surface_ties: Vec<TieEquations>,
    /// Degrees of freedom (node, axis) of massless nodes without any constraint.
    pub unresisted_dofs: HashSet<(usize, usize)>,
    /// First card with an equation or link.
    pub first: Option<Span>,
}

/// The equation of a node at an end of a tie and that of the next node.
#[derive(Clone, Copy, Debug)]
pub struct EndEquation {
    pub end: usize,
    pub next: usize,
    /// Area of the node at the end relative to that of the next one.
    pub area: f64,
}

impl Links {
    /// Creates links without equations from the equations of each tie of the model and the nodes tied to rigid bodies.
    pub fn of_ties(surface_ties: Vec<TieEquations>, rigid_ties: Vec<TiedNodes>) -> Links {
        Links { surface_ties, rigid_ties, ..Links::default() }
    }

    /// Returns whether there are no equations and links.
    pub fn is_empty(&self) -> bool {
        self.equations.is_empty() && self.merged.is_empty()
    }

    /// Gives two nodes the same motion along an axis; the first one is the leader. Returns `false` if they already had
    /// it.
    pub fn merge(&mut self, leader: usize, node: usize, axis: usize) -> bool {
        match (self.group.get(&(leader, axis)).copied(), self.group.get(&(node, axis)).copied()) {
            (Some(a), Some(b)) if a == b => return leader == node,
            (Some(a), Some(b)) => {
                let moved = std::mem::take(&mut self.merged[b].nodes);
                moved.iter().for_each(|&n| {
                    self.group.insert((n, axis), a);
                });
                self.merged[a].nodes.extend(moved);
            }
            (Some(a), None) => self.add(a, node, axis),
            (None, Some(b)) => {
                self.merged[b].nodes.insert(0, leader);
                self.group.insert((leader, axis), b);
            }
            (None, None) => {
                self.merged.push(MergedDofs { nodes: Vec::new(), axis });
                let group = self.merged.len() - 1;
                self.add(group, leader, axis);
                self.add(group, node, axis);
            }
        }
        true
    }

    /// Returns the set of nodes with the same motion as a node along an axis.
    pub fn merged_with(&self, node: usize, axis: usize) -> Option<&MergedDofs> {
        self.merged.get(*self.group.get(&(node, axis))?)
    }

    fn add(&mut self, group: usize, node: usize, axis: usize) {
        self.merged[group].nodes.push(node);
        self.group.insert((node, axis), group);
    }

    pub fn equation(&mut self, terms: Vec<((usize, usize), f64)>, is_redundant: bool, span: Span) {
        self.equations.push(NodalEquation { terms, is_redundant });
        self.spans.push(span);
    }

    /// Adds the equation that a degree of freedom (node, axis) follows the weighted mean of nodes. Returns its index.
    pub fn follow(&mut self, dof: (usize, usize), shares: &[(usize, f64)], span: Span) -> usize {
        let others = shares.iter().map(|&(n, share)| ((n, dof.1), -share));
        self.equation(std::iter::once((dof, 1.0)).chain(others).collect(), true, span);
        self.equations.len() - 1
    }

    /// Returns the equations of a step. If the motion of a node at the end of a tie is prescribed, and that of the next node
    /// is not, the equation of the end is added to that of the next node: a separate equation would restrain the other
    /// surface more than a common mesh.
    pub fn equations_with(&self, prescribed: &HashSet<(usize, usize)>) -> Cow<'_, [NodalEquation]> {
        let mut equations = Cow::Borrowed(&self.equations[..]);
        let is_prescribed = |i: usize| prescribed.contains(&self.equations[i].dependent());
        for &EndEquation { end, next, area } in &self.ends {
            if is_prescribed(end) && !is_prescribed(next) {
                let equations = equations.to_mut();
                let terms = std::mem::take(&mut equations[end].terms);
                equations[next].add(&terms, area);
            }
        }
        equations
    }

    /// Returns the degrees of freedom (node, axis) in equations, and those with the same motion as one in an equation.
    pub fn dofs_of_equations(&self) -> HashSet<(usize, usize)> {
        let mut dofs: HashSet<(usize, usize)> = self.terms().collect();
        for MergedDofs { nodes, axis } in &self.merged {
            if nodes.iter().any(|&n| dofs.contains(&(n, *axis))) {
                dofs.extend(nodes.iter().map(|&n| (n, *axis)));
            }
        }
        dofs
    }

    /// Returns the sets of nodes with equal motion, the node with a prescribed motion first, and the degrees of freedom
    /// of the sets with a prescribed motion.
    pub fn equal_motions(&self, prescribed: &HashSet<(usize, usize)>) -> (Vec<MergedDofs>, HashSet<(usize, usize)>) {
        let (mut sets, mut prescribed_dofs) = (self.merged.clone(), HashSet::new());
        for MergedDofs { nodes, axis } in &mut sets {
            if let Some(leader) = nodes.iter().position(|&n| prescribed.contains(&(n, *axis))) {
                nodes.swap(0, leader);
                prescribed_dofs.extend(nodes.iter().map(|&n| (n, *axis)));
            }
        }
        (sets, prescribed_dofs)
    }

    /// Returns the degrees of freedom (node, axis) in equations and links.
    pub fn involved_dofs(&self) -> HashSet<(usize, usize)> {
        self.group.keys().copied().chain(self.terms()).collect()
    }

    fn terms(&self) -> impl Iterator<Item = (usize, usize)> {
        self.equations.iter().flat_map(|equation| equation.terms.iter().map(|term| term.0))
    }
}
